!> The estimation algorithms by the names of the command line.
module gracecg_estimators
    use gracecg_error, only: error_t, fail
    use gracecg_text, only: join
    use gracecg_value, only: did_you_mean
    use gracecg_observation_set, only: observation_set_t
    use gracecg_calibration_solution, only: calibration_solution_t
    use gracecg_assest, only: estimate_assest_fde
    implicit none
    private
    public :: estimate_offset, ESTIMATOR_NAMES

    character(12), parameter :: ESTIMATOR_NAMES(1) = [character(12) :: 'assest-fde']

contains

    !> The CG offset by one of ESTIMATOR_NAMES. Fails for another name, and where the estimator
    !> fails.
    subroutine estimate_offset(algorithm, observations, solution, error)
        character(*), intent(in) :: algorithm
        type(observation_set_t), intent(in) :: observations
        type(calibration_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        select case (algorithm)
        case ('assest-fde')
            call estimate_assest_fde(observations, solution, error)
        case default
            call fail(error, 'no algorithm "'//trim(algorithm)//'"; there are '// &
                      join(ESTIMATOR_NAMES, ', ')//did_you_mean(algorithm, ESTIMATOR_NAMES))
        end select
    end subroutine estimate_offset
end module gracecg_estimators
