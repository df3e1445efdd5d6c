!> The estimators by name.
module gracecg_estimation_estimators
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: append, join, rounded_text
    use gracecg_files_value, only: did_you_mean
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    use gracecg_observations_observation_set, only: observation_set_t, has_orbit
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_parameters, only: SCALE_FACTORS, ROD_GAIN, FIELD_SCALES
    use gracecg_estimation_options, only: estimation_options_t, NOISE_ESTIMATED, check_options
    use gracecg_estimation_belief_report, only: belief_report_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_plausibility, only: refuse_long_arc, judge_plausibility
    use gracecg_estimation_report_estimators, only: estimate_assest, estimate_combined
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_sequential, only: estimate_sequential
    use gracecg_estimation_explanation, only: explain, explain_failure, confirm_contradictions
    use gracecg_estimation_belief_words, only: say_contradiction, is_larger_alike, FAILED_TESTS
    use gracecg_estimation_fit_checks, only: find_excess
    implicit none
    private
    public :: estimate_offset, ESTIMATOR_NAMES, REPORT_ESTIMATORS

    !> The algorithms of CSR-TM-00-01, as on the command line
    character(10), parameter :: REPORT_ESTIMATORS(4) = [character(10) :: 'assest-fde', 'assest-rde', &
                                                        'ascfest', 'ascrest']
    !> All algorithms, as on the command line
    character(10), parameter :: ESTIMATOR_NAMES(6) = [character(10) :: REPORT_ESTIMATORS, 'optimal', &
                                                      'sequential']

contains

    !> Estimates the CG offset of an observation set. Fails for a name that is none of
    !> ESTIMATOR_NAMES, for options that no file could give, and as the estimator does; with options%covariance also when the
    !> fit contradicts what is known of rods and noise, and for an offset that no satellite has.
    subroutine estimate_offset(algorithm, observations, options, solution, error, record)
        character(*), intent(in) :: algorithm               !! One of ESTIMATOR_NAMES
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options   !! estimation_options_t() needs no telling
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(out), optional :: record
        !! For diagnostics: series and covariances of the fit, as if options%covariance were true

        call check_options(options, error)
        if (.not. allocated(error)) call refuse_long_arc(observations%knowledge, error)
        if (observations%knowledge%line%number > 1 .and. algorithm /= 'optimal' .and. any(ESTIMATOR_NAMES == algorithm)) &
            call fail(error, 'several accelerometers: '//trim(algorithm)//' is for one; use --algorithm optimal')
        if (allocated(error)) return
        select case (algorithm)
        case ('assest-fde', 'assest-rde')
            call estimate_assest(observations, options, algorithm == 'assest-rde', solution, error, record)
        case ('ascfest', 'ascrest')
            call estimate_combined(observations, options, algorithm == 'ascrest', solution, error, record)
        case ('optimal')
            call estimate_optimal(observations, options, solution, error, record)
        case ('sequential')
            call estimate_sequential(observations, options, solution, error, record)
        case default
            call fail(error, 'no algorithm "'//trim(algorithm)//'"; there are '// &
                      join(ESTIMATOR_NAMES, ', ')//did_you_mean(algorithm, ESTIMATOR_NAMES))
            return
        end select
        if (options%covariance .and. options%test_beliefs) call judge_beliefs(observations, options, solution, error)
        call judge_plausibility(observations, options, solution, error)
    end subroutine estimate_offset

    !> What the data say of the operator's beliefs. `optimal` has tested them at its own fit; for the others it is
    !> done at a fit of its own.
    subroutine judge_beliefs(observations, options, solution, error)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(inout) :: error      !! Of the estimate; its cause is added

        type(solution_t) :: tested
        type(error_t), allocatable :: failure
        character(:), allocatable :: text
        real(dp), parameter :: FAR_APART = 5    ! standard deviations
        real(dp) :: factor
        integer :: i

        if (.not. allocated(solution%beliefs)) then
            call estimate_optimal(observations, options, tested, failure)
            if (.not. allocated(tested%beliefs)) then
                if (.not. allocated(failure)) return
                call explain_failure(observations, options, text)
                if (text /= '') text = '; '//text
                if (allocated(error)) then
                    error%message = error%message//text
                else
                    call append(solution%warnings, FAILED_TESTS//failure%message//text)
                end if
                return
            end if
            tested%beliefs%apart = abs(solution%offset - tested%offset)
            if (any(tested%beliefs%apart > FAR_APART*[(sqrt(solution%covariance(i, i)), i=1, 3)]) .and. solution%converged) &
                call append(solution%warnings, solution%algorithm//' is not for this manoeuvre: it is off from `optimal` by '// &
                            'more than '//rounded_text(FAR_APART, 1)//' of its sigmas, which leave out scale factors, the '// &
                            'magnetometer''s bias and forces that bend; use --algorithm optimal')
            solution%beliefs = tested%beliefs
            solution%misfit = tested%misfit
        end if
        solution%beliefs%lost_channel = lost_channel(observations%knowledge%rods)
        call doubt_scale(observations%knowledge, options, solution)
        if (.not. (has_orbit(observations) .or. observations%knowledge%rods%direct)) call doubt_field(solution%beliefs)
        call confirm_contradictions(observations, options, solution%misfit, solution%beliefs)
        if (solution%misfit > 0 .and. solution%beliefs%has_contradiction() .and. solution%beliefs%lost_channel == '') &
            call explain(observations, options, solution%beliefs, solution%misfit, solution%beliefs%explanations)
        call say_contradiction(solution%beliefs, text)
        if (text == '') text = trim(solution%beliefs%lost_channel)
        if (allocated(error)) then
            if (text /= '') error%message = error%message//'; '//text
            return
        end if
        if (text /= '') call append(solution%warnings, text)
        factor = solution%beliefs%noise_factor()
        if (factor > 1) then
            solution%covariance = factor**2*solution%covariance
            solution%state_covariance = factor**2*solution%state_covariance
            call append(solution%warnings, 'the noise is up to '//rounded_text(factor, 3)//' times what the setup says: the '// &
                        'sigmas of offset and state are taken as many times larger')
        end if
    end subroutine judge_beliefs

    !> Says of a rod that it was measured to do nothing, though the setup drives it; empty where there is none.
    pure function lost_channel(rods) result(text)
        type(torque_rods_t), intent(in) :: rods
        character(112) :: text

        integer :: axis

        text = ''
        if (.not. allocated(rods%measured%moment)) return
        associate (driven => rods%activations(:rods%count))
            do axis = 1, 3
                if (any(abs(rods%measured%moment(axis, :)) > 0)) cycle
                if (.not. any(driven%axis == axis .and. abs(driven%amplitude) > 0)) cycle
                text = trim(merge('torque.csv: the torque about', 'rods.csv: the moment of rod ', rods%direct))//' '// &
                       AXES(axis)//' is 0 all through, though the setup drives it: was its channel lost?'
                return
            end do
        end associate
    end function lost_channel

    !> Where the noise is taken from the data, and that of all axes is larger than the setup says by one factor: the samples may
    !> be as many times too large, and the offset with them, which no test sees then.
    subroutine doubt_scale(knowledge, options, solution)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(inout) :: solution

        type(error_t), allocatable :: no_noise
        real(dp) :: factors(3)
        integer :: axis

        if (options%optimal%noise /= NOISE_ESTIMATED) return
        do axis = 1, 3
            call find_excess(solution%residual_rms(axis), knowledge%accelerometer_noise(axis), knowledge%accelerometer_interval, &
                             factors(axis), no_noise)
            if (allocated(no_noise)) return
        end do
        if (.not. is_larger_alike(factors)) return
        associate (too_large => 1 - 1/minval(factors))
            call solution%beliefs%add_untested(SCALE_FACTORS(1), 'unit or scale of all accelerometer samples', &
                                               -solution%offset, too_large, too_large)
        end associate
        call append(solution%warnings, 'the noise of all axes is '//rounded_text(minval(factors), 3)//' times that of the '// &
                    'setup: samples that are as many times too large would look so, and d would be; if it is the noise, give '// &
                    'its levels in the setup')
    end subroutine doubt_scale

    !> Without an orbit no field model is there to compare the magnetometer with: its unit or scale may be as wrong as the
    !> star camera and the rods' gain do not tell, whatever is stated of it.
    subroutine doubt_field(beliefs)
        type(belief_report_t), intent(inout) :: beliefs

        real(dp), parameter :: ANY_SCALE = 1        ! A factor of 2
        real(dp) :: unseen
        integer :: i

        i = findloc(beliefs%values%belief, ROD_GAIN, 1)
        if (i == 0) return                          ! no rods
        associate (gain => beliefs%values(i))
            if (.not. gain%unseen > 0) return
            unseen = min(gain%unseen, ANY_SCALE)
            call beliefs%add_untested(FIELD_SCALES(1), 'unit or scale of the magnetometer (no orbit)', &
                                      gain%effect/gain%unseen, unseen, unseen)
        end associate
    end subroutine doubt_field
end module gracecg_estimation_estimators
