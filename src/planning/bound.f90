!> The theoretical limit of a case: the least covariance of the CG offset for its manoeuvre and the true
!> noise spectra, at its true state, and the consider covariance for what the operator knows only
!> within limits.
module gracecg_planning_bound
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_environment_sun, only: edge_of_shadow
    use gracecg_environment_time, only: julian_centuries_tt
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_simulation_dynamics, only: OMEGA_PLACES => OMEGA, ATTITUDE_PLACES => ATTITUDE
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_observations_parameters, only: PARAMETERS, parameter_names, OFFSET, RATE, SCALE_FACTORS, ROD_GAIN, ROD_GAINS, &
        FIELD_BIAS, INERTIA, TORQUE_CHANGE, LIGHT
    use gracecg_estimation_parameters, only: a_priori_sigmas
    use gracecg_estimation_physical_model, only: model_state_t
    use gracecg_estimation_gather_information, only: gather_information
    use gracecg_estimation_run_information, only: run_information_t
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, prepare_calibration, set_noise, &
        information_matrix, asked_parameters, estimated_parameters
    use gracecg_estimation_belief_report, only: belief_report_t
    use gracecg_estimation_belief_tests, only: test_beliefs
    use gracecg_planning_offset_bound, only: offset_bound_t, bound_offset
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_operator_errors, only: operator_t, OPERATOR_ERRORS => SOURCES, COMMON_ROD_GAIN, &
        ACCELEROMETER_SCALE, MAGNETOMETER_BIAS, KNOWN_INERTIA => INERTIA, KNOWN_CHANGE => TORQUE_CHANGE, KNOWN_GAINS => ROD_GAIN
    use gracecg_simulation_simulator, only: simulator_t, observe_without_noise, tell_operator, error_switches_t, &
        new_switched_simulator
    implicit none
    private
    public :: case_bound_t, bound_of_case, information_of_case, reliability_of_case, SOURCES, OPERATOR_PLACES

    character(18), parameter :: SOURCES(5) = [character(18) :: 'scale factors', 'rod gain', &
                                              'magnetometer bias', 'inertia', 'unmodelled torque']
    !! What the consider covariance is made of

    integer, parameter :: OPERATOR_PLACES(5) = [ACCELEROMETER_SCALE, COMMON_ROD_GAIN, MAGNETOMETER_BIAS, &
                                                KNOWN_INERTIA, KNOWN_CHANGE]
    !! Places of SOURCES among the errors of an operator

    !> The bound of a case.
    type, extends(offset_bound_t) :: case_bound_t
        real(dp) :: by_source(3, size(SOURCES)) = 0
        !! Standard deviation of d by each of SOURCES, m; 0 for what is estimated
        real(dp) :: by_knowledge(3, size(OPERATOR_ERRORS)) = 0
        !! The same by what the operator's errors have a standard deviation of, m; 0 for what SOURCES has, too
        real(dp) :: shadow_edge = -1    !! When the arc passes the edge of the Earth's shadow, s; negative: never
    end type case_bound_t

    integer, parameter :: CONSIDERED(16) = [SCALE_FACTORS, ROD_GAIN, FIELD_BIAS, INERTIA, TORQUE_CHANGE]
    !! Parameters that are considered where they are not estimated
    integer, parameter :: SOURCE_OF(16) = [1, 1, 1, 2, 3, 3, 3, 4, 4, 4, 4, 4, 4, 5, 5, 5]      !! Of them, in SOURCES

    !> A case at its true state.
    type :: at_truth_t
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations     !! Without noise
        real(dp) :: shadow_edge = -1                !! As of case_bound_t
        integer, allocatable :: estimated(:)        !! Parameters
        type(whitened_problem_t) :: problem         !! Of these and others
    end type at_truth_t

contains

    !> The bound for what the options ask `optimal` by name to estimate, and across the edge of the Earth's shadow its light;
    !> scale factors and magnetometer bias are considered otherwise. The density wave counts only if the options give it.
    !>
    !> Fails when the case cannot be simulated, the rods are off, a noise level is not positive, or the
    !> offset is not determined.
    subroutine bound_of_case(case, options, bound, error)
        type(case_t), intent(in) :: case
        type(estimation_options_t), intent(in) :: options
        type(case_bound_t), intent(out) :: bound
        type(error_t), allocatable, intent(out) :: error

        type(at_truth_t) :: truth
        real(dp) :: sigma(PARAMETERS)
        real(dp), allocatable :: information(:, :), rhs(:), residuals(:)
        integer, allocatable :: left(:)         ! Places of those that are considered and not estimated
        integer :: i

        call prepare_at_truth(case, options, .true., CONSIDERED, truth, error)
        if (.not. allocated(error)) then
            left = pack([(i, i=1, size(CONSIDERED))], [(.not. is_in(truth%estimated, CONSIDERED(i)), i=1, size(CONSIDERED))])
            sigma = a_priori_sigmas(truth%observations%knowledge)
            call information_matrix(truth%problem, information, rhs, residuals)
            call bound_offset(information, parameter_names(truth%estimated), OFFSET, sigma(CONSIDERED(left)), &
                              bound%offset_bound_t, error)
        end if
        if (.not. allocated(error)) then
            bound%shadow_edge = truth%shadow_edge
            do i = 1, size(left)
                associate (sum => bound%by_source(:, SOURCE_OF(left(i))))
                    sum = sqrt(sum**2 + bound%considered(:, i)**2)
                end associate
            end do
            call consider_knowledge(truth, options, bound, error)
        end if
        call add_context(error, 'case '//trim(case%name))
    end subroutine bound_of_case

    !> The information of a case at its true state about what several calibrations share: its joint estimate with others
    !> has the joint bound as its covariance. Fails as bound_of_case.
    subroutine information_of_case(case, options, information, error)
        type(case_t), intent(in) :: case
        type(estimation_options_t), intent(in) :: options
        type(run_information_t), intent(out) :: information
        type(error_t), allocatable, intent(out) :: error

        type(at_truth_t) :: truth

        call prepare_at_truth(case, options, .true., [integer ::], truth, error)
        if (.not. allocated(error)) &
            call gather_information(truth%observations%knowledge, options, truth%problem, information, error)
        call add_context(error, 'case '//trim(case%name))
    end subroutine information_of_case

    !> How far what an operator believes could be wrong in a case without `optimal` seeing it, and what that would do
    !> to the offset: minimal detectable values and effects. Fails as bound_of_case does.
    subroutine reliability_of_case(case, options, report, error)
        type(case_t), intent(in) :: case
        type(estimation_options_t), intent(in) :: options
        type(belief_report_t), intent(out) :: report    !! Its scores and states mean nothing: there are no data
        type(error_t), allocatable, intent(out) :: error

        type(at_truth_t) :: truth

        call prepare_at_truth(case, options, .false., [integer ::], truth, error)
        if (.not. allocated(error)) call test_beliefs(truth%observations%knowledge, options, truth%problem, report, error)
        call add_context(error, 'case '//trim(case%name))
    end subroutine reliability_of_case

    !> A case without noise, and without what an estimate takes for granted or considers, at its true state. The light of the
    !> Sun is estimated, as by `optimal`, where the arc passes the edge of the Earth's shadow. Fails when the rods are off, or an
    !> instrument has no noise.
    subroutine prepare_at_truth(case, options, asked_alone, more, truth, error)
        type(case_t), intent(in) :: case
        type(estimation_options_t), intent(in) :: options
        logical, intent(in) :: asked_alone      !! What the options ask for by name; else all that `optimal` estimates
        integer, intent(in) :: more(:)          !! Parameters that the problem has behind those, too
        type(at_truth_t), intent(out) :: truth
        type(error_t), allocatable, intent(out) :: error

        type(fitting_data_t) :: data
        integer :: i

        call new_switched_simulator(case, error_switches_t(curved_force=.false., scale_factors=.false., &
                                                           magnetometer_bias=.false.), truth%simulator, error)
        if (allocated(error)) return
        call observe_without_noise(truth%simulator, density_wave_t(), truth%observations)
        associate (set => truth%observations, knowledge => truth%observations%knowledge)
            truth%shadow_edge = edge_of_shadow(julian_centuries_tt(knowledge%epoch), set%orbit_time, set%orbit_position, &
                                               knowledge%duration)
            truth%estimated = asked_parameters(options%optimal, knowledge)
            if (.not. asked_alone) truth%estimated = estimated_parameters(options%optimal, knowledge)
            if (options%optimal%estimate_within_limits .and. all(truth%estimated /= LIGHT(1)) .and. truth%shadow_edge >= 0) &
                truth%estimated = [truth%estimated, LIGHT]
            call preprocess(set, options, data, error)
            if (allocated(error)) return
            if (.not. any(abs(data%torque) > 0)) then
                call fail(error, 'the '//trim(merge('torquers   ', 'torque rods', knowledge%rods%direct))//' are off '// &
                          'all the time: nothing turns the satellite so that the offset could be seen; give a manoeuvre in '// &
                          'groups '//trim(merge('&excitation', '&rod       ', knowledge%rods%direct)))
            else if (.not. all(knowledge%star_camera_sigma > 0)) then
                call fail(error, 'the star camera has no noise: a bound needs the noise of all instruments; '// &
                          'give catalogue_noise or measurement_noise')
            end if
            if (allocated(error)) return
            call prepare_calibration(knowledge, options, data, [truth%estimated, pack(more, &
                                     [(.not. is_in(truth%estimated, more(i)), i=1, size(more))])], truth%problem)
        end associate
        truth%problem%state%quaternion = truth%simulator%arc%state(ATTITUDE_PLACES, 0)
        truth%problem%state%value(RATE) = truth%simulator%arc%state(OMEGA_PLACES, 0)
        truth%problem%state%value(OFFSET) = truth%simulator%case%satellite%offset
        call set_noise(truth%problem, error)
    end subroutine prepare_at_truth

    !> Is a parameter among those that are estimated? The gain of all rods is, where that of each is.
    pure logical function is_in(estimated, parameter)
        integer, intent(in) :: estimated(:), parameter

        is_in = any(estimated == parameter) .or. parameter == ROD_GAIN .and. any(estimated == ROD_GAINS(1))
    end function is_in

    !> What the errors in the operator's knowledge add: to first order, by the difference of one Gauss-Newton
    !> step with each component one sigma up and one down. The steps start where right knowledge leads to: with
    !> small residuals, so that partials that change do not matter.
    subroutine consider_knowledge(truth, options, bound, error)
        type(at_truth_t), intent(in) :: truth
        type(estimation_options_t), intent(in) :: options
        type(case_bound_t), intent(inout) :: bound
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: STEPS = 3     ! to the estimate
        type(operator_t) :: operator
        type(model_state_t) :: state
        real(dp) :: up(size(truth%estimated)), down(size(truth%estimated)), sigma
        integer :: source, i, place(3)

        place = [(findloc(truth%estimated, OFFSET(i), 1), i=1, 3)]
        operator = truth%simulator%case%operator
        if (.not. any(operator%sigma > 0)) return
        state = truth%problem%state
        do i = 1, STEPS
            call find_step(0.0_dp, up, advance=.true.)
            if (allocated(error)) return
        end do
        do source = 1, size(OPERATOR_ERRORS)
            if (any(OPERATOR_PLACES == source) .or. source == KNOWN_GAINS .and. any(truth%estimated == ROD_GAINS(1))) cycle
            do i = 1, OPERATOR_ERRORS(source)%components
                sigma = operator%sigma(i, source)
                if (.not. sigma > 0) cycle
                call find_step(sigma, up, advance=.false.)
                if (.not. allocated(error)) call find_step(-sigma, down, advance=.false.)
                if (allocated(error)) return
                associate (total => bound%by_knowledge(:, source))
                    total = sqrt(total**2 + ((up(place) - down(place))/2)**2)
                end associate
            end do
        end do
        bound%consider_sigma = sqrt(bound%consider_sigma**2 + sum(bound%by_knowledge**2, 2))

    contains

        !> The Gauss-Newton step from the state, with a change of component i of the source.
        subroutine find_step(change, step, advance)
            real(dp), intent(in) :: change      !! 0 before there is a source
            real(dp), intent(out) :: step(:)
            logical, intent(in) :: advance      !! Take it

            type(operator_t) :: wrong
            type(observation_set_t) :: told
            type(fitting_data_t) :: data
            type(whitened_problem_t) :: problem
            real(dp), allocatable :: information(:, :), rhs(:), residuals(:)
            real(dp) :: covariance(size(step), size(step)), condition

            step = 0
            wrong = operator
            if (abs(change) > 0) wrong%value(i, source) = wrong%value(i, source) + change
            told = truth%observations
            call tell_operator(truth%simulator, wrong, told)
            call preprocess(told, options, data, error)
            if (allocated(error)) return
            call prepare_calibration(told%knowledge, options, data, truth%estimated, problem)
            problem%state = state
            call set_noise(problem, error)
            if (allocated(error)) return
            call information_matrix(problem, information, rhs, residuals)
            call solve_normal_equations(information, rhs, step, covariance, condition, error, &
                                        parameter_names(truth%estimated))
            if (allocated(error) .or. .not. advance) return
            call problem%correct(step)
            state = problem%state
        end subroutine find_step
    end subroutine consider_knowledge
end module gracecg_planning_bound
