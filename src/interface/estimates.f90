!> The C interface: estimates of one observation set, of several, and of the arcs of a long one. Documented in
!> include/gracecg.h.
module gracecg_interface_estimates
    use, intrinsic :: iso_c_binding, only: c_intptr_t
    use gracecg, only: dp, error_t, solution_t, estimate_offset, fit_record_t, fit_diagnostics_t, diagnose, &
        verdict_t, judge, action_t, act_on_runs, DO_NOT_USE, NOT_TESTED, joint_run_t, joint_options_t, &
        joint_solution_t, run_from_observations, estimate_runs, arc_chain_t, USUAL_ARC, estimate_in_arcs => estimate_chain
    use gracecg_base_error, only: add_context, fail
    use gracecg_base_kinds, only: i8
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_environment_time, only: time_tag
    use gracecg_estimation_belief_report, only: CONTRADICTED, UNTESTED
    use gracecg_estimation_belief_words, only: say_contradiction, say_untested, say_failed_tests
    use gracecg_interface_handles, only: object_t, acquire, release
    use gracecg_interface_items, only: items_t, lines_of, LIST
    use gracecg_interface_outcome, only: outcome_t, leaves_object, STATUS_BAD_VALUE, STATUS_NOT_CONVERGED, STATUS_NOT_USABLE
    use gracecg_interface_general, only: refuse_handle
    use gracecg_interface_observations, only: observations_object_t
    implicit none
    private
    public :: fit_object_t, joint_object_t, chain_object_t, estimate, estimate_joint, estimate_chain

    !> An estimate behind a handle, with all that it can tell of itself.
    type, extends(object_t) :: fit_object_t
        type(solution_t) :: solution                    !! The result
        type(fit_record_t) :: record                    !! Series and covariances
        type(fit_diagnostics_t) :: tests                !! Of both
        type(verdict_t) :: verdict                      !! On all
        type(error_t), allocatable :: untested          !! Why there are no tests
    contains
        procedure :: tell => tell_fit                   !! Puts its items
    end type fit_object_t

    !> One offset of several observation sets behind a handle.
    type, extends(object_t) :: joint_object_t
        type(joint_solution_t) :: solution              !! The result
        type(action_t) :: action                        !! What to do with it
    contains
        procedure :: tell => tell_joint                 !! Puts its items
    end type joint_object_t

    !> One offset of a long observation set behind a handle.
    type, extends(object_t) :: chain_object_t
        type(arc_chain_t) :: chain                      !! The result
    contains
        procedure :: tell => tell_chain                 !! Puts its items
    end type chain_object_t

contains

    !> Estimates the offset from observations alone, by an algorithm of gracecg_name.
    subroutine estimate(algorithm, observations, made, outcome)
        character(*), intent(in) :: algorithm           !! Its name
        class(observations_object_t), intent(in) :: observations
        type(fit_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        call estimate_offset(algorithm, observations%set, observations%options, made%solution, failure, made%record)
        call outcome%take(failure)
        associate (solution => made%solution)
            call require_finite([solution%offset, [solution%covariance], solution%residual_rms], outcome)
            if (.not. solution%converged) &
                call outcome%refuse(STATUS_NOT_CONVERGED, algorithm//' did not converge in '// &
                                    integer_text(solution%iterations)//' iterations: the offset is not to be relied upon; '// &
                                    'check guess_quaternion and guess_angular_velocity of its options')
        end associate
        if (.not. leaves_object(outcome%status)) return
        call diagnose(observations%set%knowledge, made%solution, made%record, made%tests, made%untested)
        call outcome%take(made%untested, STATUS_NOT_USABLE)
        if (allocated(made%untested)) return
        made%verdict = judge(observations%set%knowledge, made%solution, made%record, made%tests)
        if (made%verdict%action%kind == DO_NOT_USE) call outcome%refuse(STATUS_NOT_USABLE, made%verdict%action%text)
    end subroutine estimate

    subroutine require_finite(values, outcome)
        real(dp), intent(in) :: values(:)
        type(outcome_t), intent(inout) :: outcome

        if (.not. all(abs(values) <= huge(1.0_dp))) &
            call outcome%refuse(STATUS_BAD_VALUE, 'the estimate would be NaN or infinite')
    end subroutine require_finite

    subroutine tell_fit(self, items)
        class(fit_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        call tell_solution(self%solution, items)
        call tell_record(self%record, items)
        call items%put('state_covariance', self%solution%state_covariance)
        call tell_running(self%solution, items)
        if (items%asks('test_') .or. items%asks('action')) call tell_tests(self, items)
        if (items%asks('belief_') .or. items%asks('contradictions') .or. items%asks('untestable')) &
            call tell_beliefs(self%solution, items)
    end subroutine tell_fit

    subroutine tell_solution(solution, items)
        type(solution_t), intent(in) :: solution
        type(items_t), intent(inout) :: items

        character(:), allocatable :: text
        integer :: i, n

        call items%put('offset', solution%offset)
        call items%put('sigma', [(sqrt(solution%covariance(i, i)), i=1, 3)])
        call items%put('covariance', solution%covariance)
        call items%put('drift', solution%drift)
        call items%put('bias', solution%bias)
        call items%put('quaternion', solution%quaternion)
        call items%put('angular_velocity', solution%angular_velocity)
        call items%put('residual_rms', solution%residual_rms)
        call items%put('condition', solution%condition)
        call items%put('variance_factor', solution%variance_factor)
        call items%put('noise_level', solution%noise_level)
        call items%put('noise_corner', solution%noise_corner)
        call items%put('star_camera_sigma', solution%star_camera_sigma)
        call items%put('edited', real(solution%edited, dp))
        call items%put('iterations', real(solution%iterations, dp))
        call items%put('converged', merge(1.0_dp, 0.0_dp, solution%converged))
        n = 0
        if (allocated(solution%parameters)) n = size(solution%parameters)
        call items%put('parameter_value', [(solution%parameters(i)%value, i=1, n)])
        call items%put('parameter_sigma', [(solution%parameters(i)%sigma, i=1, n)])
        text = ''
        do i = 1, n
            text = text//trim(solution%parameters(i)%name)//new_line('a')
        end do
        call items%say('parameter_names', text)
        call lines_of(solution%warnings, text)
        call items%say('warnings', text)
    end subroutine tell_solution

    subroutine tell_record(record, items)
        type(fit_record_t), intent(in) :: record
        type(items_t), intent(inout) :: items

        character(:), allocatable :: text
        integer :: i

        call items%put('time', [(time_tag(record%epoch(i), record%interval), i=1, size(record%epoch))])
        call items%put('residual', record%residual)
        ! A row of C's is a column here
        call items%put('partials', reshape(record%partials, shape(record%partials), order=[2, 1, 3]))
        call items%put('angular_acceleration', record%angular_acceleration)
        text = ''
        do i = 1, size(record%names)
            text = text//trim(record%names(i))//new_line('a')
        end do
        call items%say('fitted_names', text)
        call items%put('fitted_covariance', record%covariance)
        call items%put('covariance_by_source', record%covariance_by_source)
    end subroutine tell_record

    subroutine tell_running(solution, items)
        type(solution_t), intent(in) :: solution
        type(items_t), intent(inout) :: items

        if (allocated(solution%running)) then
            call items%put('running_time', solution%running%time)
            call items%put('running_offset', solution%running%offset)
            call items%put('running_sigma', solution%running%sigma)
        else
            call items%put('running_time', [real(dp) ::])
            call items%put('running_offset', [real(dp) ::])
            call items%put('running_sigma', [real(dp) ::])
        end if
    end subroutine tell_running

    subroutine tell_tests(fit, items)
        class(fit_object_t), intent(in) :: fit
        type(items_t), intent(inout) :: items

        if (allocated(fit%untested)) then
            call fail(items%failure, 'tests of the fit: '//fit%untested%message)
            return
        end if
        associate (found => fit%tests)
            call items%put('test_torque_factor', fit%record%torque_factor)
            call items%put('test_torque_sigma', fit%record%torque_sigma)
            call items%put('test_attitude_misfit', fit%record%attitude_misfit)
            call items%put('test_rms', found%residuals%rms)
            call items%put('test_expected_rms', found%residuals%expected_rms)
            call items%put('test_ratio', found%residuals%ratio)
            call items%put('test_ratio_sigma', found%residuals%ratio_sigma)
            call items%put('test_probability', found%residuals%probability)
            call items%put('test_worst', found%residuals%worst)
            call items%put('test_worst_time', found%residuals%worst_time)
            call items%put('test_peak_frequency', found%residuals%peak_frequency)
            call items%put('test_peak_ratio', found%residuals%peak_ratio)
            call items%put('test_bound', found%bound)
            call items%put('test_information_share', found%information_share)
            call items%put('test_source_share', found%source_share)
            call items%put('test_semi_axis', found%ellipsoid%semi_axis)
            call items%put('test_direction', found%ellipsoid%direction)
        end associate
        call tell_action(fit%verdict%action, items)
    end subroutine tell_tests

    subroutine tell_action(action, items)
        type(action_t), intent(in) :: action
        type(items_t), intent(inout) :: items

        call items%say('action', action%text)
        call items%put('action_sigma', action%sigma)
        call items%put('action_kind', real(action%kind, dp))
        call items%put('action_trim', merge(1.0_dp, 0.0_dp, action%trimmed))
        call items%put('action_again', merge(1.0_dp, 0.0_dp, action%again))
    end subroutine tell_action

    subroutine tell_beliefs(solution, items)
        type(solution_t), intent(in) :: solution
        type(items_t), intent(inout) :: items

        character(:), allocatable :: text

        if (.not. allocated(solution%beliefs)) then
            if (items%asks(LIST)) return
            call say_failed_tests(solution%warnings, text)
            if (text == '') text = 'the options leave out the tests of what the setup says (test_beliefs, covariance)'
            call fail(items%failure, text)
            return
        end if
        associate (report => solution%beliefs)
            call items%put('belief_undetected', report%undetected(.false.))
            call items%put('belief_undetected_as_stated', report%undetected(.true.))
            call items%put('belief_apart', report%apart)
            call items%put('belief_tested', real(report%how_many(), dp))
            call items%put('belief_contradicted', real(report%how_many(CONTRADICTED), dp))
            call items%put('belief_untested', real(report%how_many(UNTESTED), dp))
            call items%put('belief_sign_known', merge(1.0_dp, 0.0_dp, report%signs_known))
            call say_contradiction(report, text)
            call items%say('contradictions', text)
            call say_untested(report, text)
            call items%say('untestable', text)
        end associate
    end subroutine tell_beliefs

    !> One offset from several observation sets, by the algorithm optimal with the options of each.
    subroutine estimate_joint(count, observations, made, outcome)
        integer, intent(in) :: count                                !! Observation sets
        integer(c_intptr_t), intent(in) :: observations(count)      !! Their handles
        type(joint_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(joint_run_t) :: runs(count)
        type(string_t), allocatable :: names(:)
        type(error_t), allocatable :: failure
        integer :: i

        allocate (names(0))
        do i = 1, count
            call run_of_handle(int(observations(i), i8), i, runs(i), outcome)
            call append(names, 'run '//integer_text(i))
        end do
        if (.not. outcome%good()) return
        call estimate_runs(runs, joint_options_t(), made%solution, failure)
        call outcome%take(failure)
        call require_finite([made%solution%offset, [made%solution%covariance]], outcome)
        if (.not. outcome%good()) return
        call act_on_runs(runs, joint_options_t(), names, made%solution, made%action)
        if (made%action%kind == DO_NOT_USE) call outcome%refuse(STATUS_NOT_USABLE, made%action%text)
    end subroutine estimate_joint

    subroutine run_of_handle(handle, i, run, outcome)
        integer(i8), intent(in) :: handle
        integer, intent(in) :: i        !! Number of the run, for messages
        type(joint_run_t), intent(out) :: run
        type(outcome_t), intent(inout) :: outcome

        class(object_t), pointer :: object
        type(error_t), allocatable :: failure

        if (.not. outcome%good()) return
        call acquire(handle, object)
        select type (object)
        type is (observations_object_t)
            call run_from_observations(object%set, object%options, run, failure)
            call add_context(failure, 'run '//integer_text(i))
            call outcome%take(failure)
        class default
            call refuse_handle('observation set', outcome)
        end select
        call release(handle, object)
    end subroutine run_of_handle

    subroutine tell_joint(self, items)
        class(joint_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        call tell_joined(self%solution, items)
        call tell_action(self%action, items)
    end subroutine tell_joint

    subroutine tell_joined(solution, items)
        type(joint_solution_t), intent(in) :: solution
        type(items_t), intent(inout) :: items

        integer :: i

        call items%put('offset', solution%offset)
        call items%put('covariance', solution%covariance)
        call items%put('chi_square', solution%statistic)
        call items%put('degrees', real(solution%degrees, dp))
        call items%put('probability', solution%probability)
        call items%put('consistent', merge(1.0_dp, 0.0_dp, solution%consistent))
        call items%put('difference', [(solution%runs(i)%difference, i=1, size(solution%runs))])
        call items%put('difference_sigma', [(solution%runs(i)%difference_sigma, i=1, size(solution%runs))])
    end subroutine tell_joined

    !> One offset from a long observation set, cut into arcs of `arc` seconds at most (0: 60).
    subroutine estimate_chain(observations, arc, threads, made, outcome)
        class(observations_object_t), intent(in) :: observations
        real(dp), intent(in) :: arc                     !! Length at most, s; 0: the usual one
        integer, intent(in) :: threads    !! To work on
        type(chain_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        call estimate_in_arcs(observations%set, observations%options, joint_options_t(), merge(arc, USUAL_ARC, arc > 0), threads, &
                              made%chain, failure)
        call outcome%take(failure)
        call require_finite([made%chain%solution%offset, [made%chain%solution%covariance]], outcome)
    end subroutine estimate_chain

    subroutine tell_chain(self, items)
        class(chain_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        character(:), allocatable :: text

        call tell_joined(self%chain%solution, items)
        call tell_action(action_t(NOT_TESTED, text='not tested: in arcs nothing of what the setup says is; estimate the part '// &
                                  'with a manoeuvre by itself before masses move'), items)
        call items%put('arcs', real(size(self%chain%arcs), dp))
        call items%put('joined', real(count(self%chain%arcs%joined), dp))
        call lines_of(self%chain%warnings, text)
        call items%say('warnings', text)
    end subroutine tell_chain
end module gracecg_interface_estimates
