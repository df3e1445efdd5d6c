!> The studies behind the report's chapters: what they count, choose and compare, on made-up results where
!> that is enough, and on few runs where it is not.
module test_report_studies
    use vocabulary
    use calibrations
    use gracecg_base_progress, only: progress_t
    use gracecg_base_statistics, only: sampling_error
    use gracecg_simulation_simulator, only: error_switches_t, new_switched_simulator, switch_off
    use gracecg_planning_bound, only: case_bound_t, bound_of_case
    use gracecg_planning_design, only: manoeuvre_design_t
    use gracecg_studies_campaign, only: campaign_t, new_campaign, run_case, first_runs
    use gracecg_studies_curves, only: window_check_t, window_counts_t, count_windows
    use gracecg_studies_designed_manoeuvre, only: designed_calibration_t, calibrate_with_design
    use gracecg_studies_limit, only: limit_study_t, study_limit, relative_error, at_the_bound
    use gracecg_studies_monte_carlo, only: monte_carlo_t, run_monte_carlo, error_statistics_t, statistics_of
    use gracecg_studies_timing, only: timing_study_t, timing_summary_t, summary_of, weakest_x, best_places
    implicit none
    private
    public :: collect_report_studies

    !> Counts what it is told.
    type, extends(progress_t) :: listener_t
        integer :: told = 0
        character(200) :: latest = ''
    contains
        procedure :: progress => listen
    end type listener_t

contains

    subroutine collect_report_studies(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('first-runs-of-a-campaign', test_first_runs), &
                    new_unittest('curves-within-their-windows', test_windows), &
                    new_unittest('revolution', test_revolution), &
                    new_unittest('sampling-error', test_sampling_error), &
                    new_unittest('limit', test_limit), &
                    new_unittest('designed-calibration', test_designed)]
    end subroutine collect_report_studies

    subroutine listen(self, text)
        class(listener_t), intent(inout) :: self
        character(*), intent(in) :: text

        self%told = self%told + 1
        self%latest = text
    end subroutine listen

    !> Three runs cut to two are the campaign of two runs; every algorithm is told of.
    subroutine test_first_runs(error)
        type(error_type), allocatable, intent(out) :: error
        character(10), parameter :: ALGORITHMS(2) = [character(10) :: 'assest-fde', 'ascfest']
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(campaign_t) :: three, two, cut
        type(listener_t) :: listener
        type(error_t), allocatable :: failure

        three = new_campaign(ALGORITHMS, 1, 7_i8, 3, 1, 1)
        two = new_campaign(ALGORITHMS, 1, 7_i8, 2, 1, 1)
        call take_calibration('back-3', calibration)
        call make_simulator(calibration%case, simulator)
        call run_case(three, 1, calibration, simulator, 2, failure, listener)
        if (.not. allocated(failure)) call run_case(two, 1, calibration, simulator, 1, failure)
        if (failed(error, failure)) return
        cut = first_runs(three, 2)
        call check(error, cut%runs == 2 .and. all(cut%entries(2, 1)%run == [1, 2]))
        call check(error, all(abs(cut%entries(2, 1)%statistics%rms - two%entries(2, 1)%statistics%rms) <= 0))
        call check(error, any(abs(cut%entries(1, 1)%statistics%rms - three%entries(1, 1)%statistics%rms) > 0))
        call check(error, listener%told, 2)
        call check(error, trim(listener%latest), 'back-3, ascfest')
    end subroutine test_first_runs

    subroutine test_windows(error)
        type(error_type), allocatable, intent(out) :: error
        type(window_check_t) :: checks(5)
        type(window_counts_t) :: counts

        checks%attitude_only = [.true., .true., .false., .false., .false.]
        checks%inside = [.true., .false., .true., .true., .false.]
        checks%near_centre = [.true., .true., .false., .false., .true.]
        checks%on_ticks = [.true., .true., .false., .true., .false.]
        checks%fill = [0.5_dp, 0.25_dp, 0.125_dp, 1.0_dp, 1.0_dp]
        counts = count_windows(checks)
        call check(error, counts%attitude == 2 .and. counts%attitude_inside == 1 .and. counts%surface == 3 .and. &
                   counts%surface_inside == 2 .and. counts%surface_near == 1)
        call check(error, counts%attitude_on_ticks == 2 .and. counts%surface_on_ticks == 1)
        call check(error, counts%attitude_fill, 0.25_dp)
    end subroutine test_windows

    !> Four places: x is the strongest at two of them and the weakest at one; the best place for all is best
    !> for none alone.
    subroutine test_revolution(error)
        type(error_type), allocatable, intent(out) :: error
        type(timing_study_t) :: study
        type(timing_summary_t) :: summary
        integer :: k

        allocate (study%places(4))
        study%step = 30
        study%orbit%revolution = 110
        study%places(1)%acceleration = [3.0_dp, 1.0_dp, 2.0_dp]
        study%places(2)%acceleration = [5.0_dp, 4.0_dp, 1.0_dp]
        study%places(3)%acceleration = [1.0_dp, 2.0_dp, 3.0_dp]
        study%places(4)%acceleration = [2.0_dp, 1.0_dp, 3.0_dp]
        do k = 1, 4
            study%places(k)%field = [1, -2*k, 3]
        end do
        study%places(1)%sigma = [1, 9, 9]
        study%places(2)%sigma = [9, 1, 9]
        study%places(3)%sigma = [9, 9, 1]
        study%places(4)%sigma = [2, 3, 2]
        summary = summary_of(study)
        call check(error, summary%strongest_field, 8.0_dp)
        call check(error, summary%largest, 5.0_dp)
        call check(error, summary%x_strongest, 0.5_dp)
        call check(error, summary%x_weakest, 30)
        study%orbit%revolution = 25
        call check(error, weakest_x(study), 25, 'no more than the revolution')
        call check(error, all(best_places(study%places) == [1, 2, 3, 4]))
    end subroutine test_revolution

    !> An RMS of 50 runs scatters by a tenth: three sigma are 1.3, and no more.
    subroutine test_sampling_error(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, sampling_error(50), 0.1_dp, thr=1e-15_dp)
        call check(error, all(at_the_bound([1.0_dp, 1.299_dp, 1.301_dp, 0.701_dp, 0.699_dp], 50) .eqv. &
                              [.true., .true., .false., .true., .false.]))
    end subroutine test_sampling_error

    !> Bound and RMS errors are those that bound and Monte Carlo give each by itself.
    subroutine test_limit(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ASCREST = 4
        type(calibration_t) :: calibration
        type(case_bound_t) :: bound
        type(error_switches_t) :: switches
        type(simulator_t) :: simulator
        type(monte_carlo_t) :: results
        type(error_statistics_t) :: statistics
        type(limit_study_t) :: study
        type(listener_t) :: listener
        type(error_t), allocatable :: failure

        call take_calibration('front-3', calibration)
        call study_limit(calibration, 5_i8, 2, 2, study, failure, listener)
        if (.not. allocated(failure)) call bound_of_case(calibration%case, calibration%options, bound, failure)
        if (.not. allocated(failure)) call switch_off(switches, 'systematic', failure)
        if (.not. allocated(failure)) call new_switched_simulator(calibration%case, switches, simulator, failure)
        if (.not. allocated(failure)) &
            call run_monte_carlo(simulator, trim(ESTIMATOR_NAMES(ASCREST)), calibration%options, 5_i8, [1, 2], 1, &
                                 results, failure)
        if (failed(error, failure)) return
        statistics = statistics_of(results%offset/MILLIMETRE, simulator%case%satellite%offset/MILLIMETRE)
        call check(error, all(abs(study%bound - bound%sigma) <= 0))
        call check(error, all(study%runs == 2) .and. all(study%not_converged == 0))
        call check(error, all(abs(study%rms(:, ASCREST)/MILLIMETRE - statistics%rms) <= 1e-12_dp*statistics%rms))
        call check(error, relative_error(study, ASCREST, 2), study%rms(2, ASCREST)/bound%sigma(2), thr=1e-15_dp)
        call check(error, listener%told >= size(ESTIMATOR_NAMES))
    end subroutine test_limit

    !> With the case's own manoeuvre as the design: the bound is the case's.
    subroutine test_designed(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(case_bound_t) :: bound
        type(manoeuvre_design_t) :: design
        type(designed_calibration_t) :: reached
        type(error_t), allocatable :: failure

        call take_calibration('back-3', calibration)
        call bound_of_case(calibration%case, calibration%options, bound, failure)
        design%rods = calibration%case%satellite%rods
        if (.not. allocated(failure)) call calibrate_with_design('back-3', design, 1_i8, 2, 2, reached, failure)
        if (failed(error, failure)) return
        call check(error, all(abs(reached%bound - bound%sigma) <= 0) .and. reached%runs == 2)
        call check(error, all(reached%rms > 0) .and. all(reached%rms < 1e-4_dp) .and. &
                                               all(reached%trimmed < 1e-4_dp))
    end subroutine test_designed
end module test_report_studies
