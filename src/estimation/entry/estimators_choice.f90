!> The estimators by name: the choice.
submodule (gracecg_estimation_estimators) gracecg_estimation_estimators_choice
    use gracecg_base_error, only: fail
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
    end subroutine estimate_offset
end submodule gracecg_estimation_estimators_choice
