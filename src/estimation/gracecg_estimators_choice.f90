!> The estimators by name: the choice.
submodule (gracecg_estimators) gracecg_estimators_choice
    use gracecg_error, only: fail
    use gracecg_text, only: join
    use gracecg_value, only: did_you_mean
    use gracecg_assest, only: estimate_assest
    use gracecg_combined_estimation, only: estimate_combined
    use gracecg_optimal_estimation, only: estimate_optimal
    use gracecg_sequential, only: estimate_sequential
    implicit none

contains

    module subroutine estimate_offset(algorithm, observations, solution, error, with_covariance, record)
        character(*), intent(in) :: algorithm
        type(observation_set_t), intent(in) :: observations
        type(calibration_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: with_covariance
        type(fit_record_t), intent(out), optional :: record

        logical :: covariance

        covariance = .true.
        if (present(with_covariance)) covariance = with_covariance .or. present(record)
        select case (algorithm)
        case ('assest-fde')
            call estimate_assest(observations, .false., solution, error, covariance, record)
        case ('assest-rde')
            call estimate_assest(observations, .true., solution, error, covariance, record)
        case ('ascfest')
            call estimate_combined(observations, .false., solution, error, covariance, record)
        case ('ascrest')
            call estimate_combined(observations, .true., solution, error, covariance, record)
        case ('optimal')
            call estimate_optimal(observations, solution, error, covariance, record)
        case ('sequential')
            call estimate_sequential(observations, solution, error, covariance, record)
        case default
            call fail(error, 'no algorithm "'//trim(algorithm)//'"; there are '// &
                      join(ESTIMATOR_NAMES, ', ')//did_you_mean(algorithm, ESTIMATOR_NAMES))
        end select
    end subroutine estimate_offset
end submodule gracecg_estimators_choice
