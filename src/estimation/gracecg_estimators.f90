!> The estimators by name.
module gracecg_estimators
    use gracecg_error, only: error_t, fail
    use gracecg_text, only: join
    use gracecg_value, only: did_you_mean
    use gracecg_observation_set, only: observation_set_t
    use gracecg_calibration_solution, only: calibration_solution_t
    use gracecg_assest, only: estimate_assest
    use gracecg_combined_estimation, only: estimate_combined
    implicit none
    private
    public :: estimate_offset, ESTIMATOR_NAMES

    character(10), parameter :: ESTIMATOR_NAMES(4) = [character(10) :: 'assest-fde', 'assest-rde', &
                                                      'ascfest', 'ascrest']

contains

    !> Estimates the CG offset of an observation set. Fails for a name that is none of
    !> ESTIMATOR_NAMES, and as the estimator does.
    subroutine estimate_offset(algorithm, observations, solution, error, with_covariance)
        character(*), intent(in) :: algorithm
        type(observation_set_t), intent(in) :: observations
        type(calibration_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: with_covariance    !! Compute the covariance: true when absent

        logical :: covariance

        covariance = .true.
        if (present(with_covariance)) covariance = with_covariance
        select case (algorithm)
        case ('assest-fde')
            call estimate_assest(observations, .false., solution, error, covariance)
        case ('assest-rde')
            call estimate_assest(observations, .true., solution, error, covariance)
        case ('ascfest')
            call estimate_combined(observations, .false., solution, error, covariance)
        case ('ascrest')
            call estimate_combined(observations, .true., solution, error, covariance)
        case default
            call fail(error, 'no algorithm "'//trim(algorithm)//'"; there are '// &
                      join(ESTIMATOR_NAMES, ', ')//did_you_mean(algorithm, ESTIMATOR_NAMES))
        end select
    end subroutine estimate_offset
end module gracecg_estimators
