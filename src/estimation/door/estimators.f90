!> The estimators by name.
!>
!> The work is in a submodule, so that who uses this module need not know the estimators' types.
module gracecg_estimation_estimators
    use gracecg_base_error, only: error_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_fit_record, only: fit_record_t
    implicit none
    private
    public :: estimate_offset, ESTIMATOR_NAMES, REPORT_ESTIMATORS

    !> The algorithms of CSR-TM-00-01, as on the command line
    character(10), parameter :: REPORT_ESTIMATORS(4) = [character(10) :: 'assest-fde', 'assest-rde', &
                                                        'ascfest', 'ascrest']
    !> All algorithms, as on the command line
    character(10), parameter :: ESTIMATOR_NAMES(6) = [character(10) :: REPORT_ESTIMATORS, 'optimal', &
                                                      'sequential']

    interface
        !> Estimates the CG offset of an observation set. Fails for a name that is none of
        !> ESTIMATOR_NAMES, and as the estimator does; with options%covariance also when the fit contradicts
        !> what is known of rods and noise.
        module subroutine estimate_offset(algorithm, observations, options, solution, error, record)
            character(*), intent(in) :: algorithm               !! One of ESTIMATOR_NAMES
            type(observation_set_t), intent(in) :: observations
            type(estimation_options_t), intent(in) :: options   !! estimation_options_t() needs no telling
            type(solution_t), intent(out) :: solution
            type(error_t), allocatable, intent(out) :: error
            type(fit_record_t), intent(out), optional :: record
            !! For diagnostics: series and covariances of the fit, as if options%covariance were true
        end subroutine estimate_offset
    end interface
end module gracecg_estimation_estimators
