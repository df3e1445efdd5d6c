!> Every estimator against the theoretical limit: RMS errors with the systematic errors off, beside the
!> Cramer-Rao bound of the manoeuvre under the noise of the instruments.
module gracecg_studies_limit
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    use gracecg_base_statistics, only: sampling_error
    use gracecg_files_data_table, only: data_table_t
    use gracecg_estimation_estimators, only: ESTIMATOR_NAMES
    use gracecg_simulation_simulator, only: simulator_t, error_switches_t, new_switched_simulator, switch_off
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_planning_bound, only: case_bound_t, bound_of_case
    use gracecg_studies_monte_carlo, only: monte_carlo_t, run_monte_carlo, rms_of_errors
    implicit none
    private
    public :: limit_study_t, study_limit, relative_error, at_the_bound, detectable_excess, limits_table

    integer, parameter :: ALGORITHMS = size(ESTIMATOR_NAMES)
    real(dp), parameter :: SIGMAS = 3               !! Of the sampling error: so far the bound counts as reached
    real(dp), parameter :: POWER_SIGMAS = 0.8416_dp !! Of a test that finds what there is in 80 % of its trials

    !> The limit of a case, and what the estimators reach; each array in the order of ESTIMATOR_NAMES.
    type :: limit_study_t
        character(64) :: case_name = ''             !! Of the case
        real(dp) :: bound(3) = 0                    !! Cramer-Rao, body axes, m
        integer :: runs(ALGORITHMS) = 0             !! Of each Monte Carlo
        real(dp) :: rms(3, ALGORITHMS) = 0          !! (axis, estimator), m
        integer :: not_converged(ALGORITHMS) = 0    !! Runs
    end type limit_study_t

contains

    !> Bound of a case and Monte Carlo of every estimator, the systematic errors off. Fails as `bound_of_case`
    !> and `run_monte_carlo` do.
    subroutine study_limit(calibration, seed, runs, threads, study, error, progress)
        type(calibration_t), intent(in) :: calibration
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads      !! Of each Monte Carlo; in parallel
        type(limit_study_t), intent(out) :: study
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(case_bound_t) :: bound
        type(error_switches_t) :: switches
        type(simulator_t) :: simulator
        type(monte_carlo_t) :: results
        integer :: a, k

        study%case_name = calibration%case%name
        study%runs = runs
        call switch_off(switches, 'systematic', error)
        if (.not. allocated(error)) call bound_of_case(calibration%case, calibration%options, bound, error)
        if (.not. allocated(error)) call new_switched_simulator(calibration%case, switches, simulator, error)
        if (allocated(error)) return
        study%bound = bound%sigma
        call expect_pieces(progress, sum(study%runs), 'runs')
        do a = 1, ALGORITHMS
            call tell(progress, 'limit, '//trim(study%case_name)//', '//trim(ESTIMATOR_NAMES(a)))
            call run_monte_carlo(simulator, trim(ESTIMATOR_NAMES(a)), calibration%options, seed, &
                                 [(k, k=1, study%runs(a))], threads, results, error, progress=progress)
            if (allocated(error)) return
            study%rms(:, a) = rms_of_errors(results, simulator)
            study%not_converged(a) = count(.not. results%converged)
        end do
    end subroutine study_limit

    !> RMS error of an estimator divided by the bound.
    elemental function relative_error(study, a, axis) result(ratio)
        type(limit_study_t), intent(in) :: study
        integer, intent(in) :: a                        !! In the order of ESTIMATOR_NAMES
        integer, intent(in) :: axis                     !! 1 to 3
        real(dp) :: ratio

        ratio = study%rms(axis, a)/study%bound(axis)
    end function relative_error

    !> Whether a ratio of RMS error and bound is 1 but for the sampling error of so many runs.
    elemental logical function at_the_bound(ratio, runs)
        real(dp), intent(in) :: ratio
        !! RMS over bound
        integer, intent(in) :: runs                     !! Of the Monte Carlo

        at_the_bound = abs(ratio - 1) <= SIGMAS*sampling_error(runs)
    end function at_the_bound

    !> The relative excess over the bound that so many runs tell from chance with a probability of 80 %: an RMS
    !> so much larger is not "at the bound" any more.
    elemental real(dp) function detectable_excess(runs) result(excess)
        integer, intent(in) :: runs                     !! Of the Monte Carlo

        excess = (SIGMAS + POWER_SIGMAS)*sampling_error(runs)
    end function detectable_excess

    !> A row a case, estimator and axis; `sampling_error`: one sigma of the ratio.
    function limits_table(studies) result(table)
        type(limit_study_t), intent(in) :: studies(:)
        type(data_table_t) :: table

        integer :: i, a, axis

        call table%columns_of('case,algorithm,axis,runs,rms_mm,bound_mm,ratio,sampling_error,at_the_bound,not_converged')
        do i = 1, size(studies)
            do a = 1, ALGORITHMS
                do axis = 1, 3
                    associate (study => studies(i), ratio => relative_error(studies(i), a, axis))
                        call table%add(study%case_name, ESTIMATOR_NAMES(a), AXES(axis))
                        call table%add([real(study%runs(a), dp), study%rms(axis, a)/MILLIMETRE, study%bound(axis)/MILLIMETRE, &
                                        ratio, ratio*sampling_error(study%runs(a))])
                        call table%add(at_the_bound(ratio, study%runs(a)))
                        call table%add(study%not_converged(a))
                    end associate
                end do
            end do
        end do
    end function limits_table
end module gracecg_studies_limit
