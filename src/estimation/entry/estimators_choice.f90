!> The estimators by name: the choice.
submodule (gracecg_estimation_estimators) gracecg_estimation_estimators_choice
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, MILLIMETRE
    use gracecg_base_error, only: fail, number_text
    use gracecg_base_text, only: join
    use gracecg_files_value, only: did_you_mean
    use gracecg_estimation_assest, only: estimate_assest
    use gracecg_estimation_combined, only: estimate_combined
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_sequential, only: estimate_sequential
    implicit none

contains

    module subroutine estimate_offset(algorithm, observations, options, solution, error, record)
        character(*), intent(in) :: algorithm
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(out), optional :: record

        select case (algorithm)
        case ('assest-fde')
            call estimate_assest(observations, options, .false., solution, error, record)
        case ('assest-rde')
            call estimate_assest(observations, options, .true., solution, error, record)
        case ('ascfest')
            call estimate_combined(observations, options, .false., solution, error, record)
        case ('ascrest')
            call estimate_combined(observations, options, .true., solution, error, record)
        case ('optimal')
            call estimate_optimal(observations, options, solution, error, record)
        case ('sequential')
            call estimate_sequential(observations, options, solution, error, record)
        case default
            call fail(error, 'no algorithm "'//trim(algorithm)//'"; there are '// &
                      join(ESTIMATOR_NAMES, ', ')//did_you_mean(algorithm, ESTIMATOR_NAMES))
        end select
        if (.not. allocated(error) .and. (options%covariance .or. present(record))) &
            call refuse_implausible(solution, options%largest_offset, error)
    end subroutine estimate_offset

    !> Mass and accelerometer of such a satellite are balanced to a millimetre: an offset beyond a centimetre
    !> tells of wrong units, axes or times.
    subroutine refuse_implausible(solution, largest, error)
        type(solution_t), intent(in) :: solution
        real(dp), intent(in) :: largest         !! m
        type(error_t), allocatable, intent(out) :: error

        integer :: axis

        if (.not. solution%converged) return
        axis = maxloc(abs(solution%offset), 1)
        if (abs(solution%offset(axis)) <= largest) return
        call fail(error, solution%algorithm//': the CG offset on '//AXES(axis)//' would be '// &
                  number_text(solution%offset(axis)/MILLIMETRE)//' mm; beyond '//number_text(largest/MILLIMETRE)// &
                  ' mm it is not plausible: check units, axes and time tags of the samples and the rods of the setup, or '// &
                  'raise largest_offset_mm of the group estimation of the options')
    end subroutine refuse_implausible
end submodule gracecg_estimation_estimators_choice
