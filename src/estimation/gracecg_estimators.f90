!> The estimators by name.
module gracecg_estimators
    use gracecg_error, only: error_t, fail
    use gracecg_observation_set, only: observation_set_t
    use gracecg_calibration_solution, only: calibration_solution_t
    use gracecg_assest, only: estimate_assest_fde
    implicit none
    private
    public :: estimate_offset, ALGORITHM_NAMES

    character(10), parameter :: ALGORITHM_NAMES(1) = [character(10) :: 'assest-fde']

contains

    !> Estimates the CG offset of an observation set. Fails for a name that is none of
    !> ALGORITHM_NAMES, and as the estimator does.
    subroutine estimate_offset(algorithm, observations, solution, error, with_covariance)
        character(*), intent(in) :: algorithm
        type(observation_set_t), intent(in) :: observations
        type(calibration_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: with_covariance    !! Compute the covariance: true when absent

        select case (algorithm)
        case ('assest-fde')
            call estimate_assest_fde(observations, solution, error, with_covariance)
        case default
            call fail(error, 'there is no algorithm "'//trim(algorithm)//'"')
        end select
    end subroutine estimate_offset
end module gracecg_estimators
