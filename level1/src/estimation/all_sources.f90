!> The estimate of the offset from Level-1 data: rods calibrated by the attitude, delays, all sources of angular
!> acceleration side by side, and a judgement that names what is wrong.
module gracecg_level1_all_sources
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: append
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_drive, only: level1_drive_t
    use gracecg_level1_drive_fit, only: choose_drive, make_motion, tie_gains
    use gracecg_level1_gyros, only: fit_gyro_axes
    use gracecg_level1_judgement, only: name_faults, judge
    use gracecg_level1_offset_solution, only: level1_solution_t
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_sources, only: LEVEL1_SOURCES, solve_by_source, drop_outliers
    implicit none
    private
    public :: estimate_level1

contains

    !> Estimates by the sources asked for. Fails when the data do not allow any estimate.
    subroutine estimate_level1(calibration, setup, sources, leakage, estimate, error)
        type(level1_calibration_t), intent(inout) :: calibration    !! Outliers are taken out
        type(level1_setup_t), intent(in) :: setup
        character(*), intent(in) :: sources(:)              !! Of LEVEL1_SOURCES
        character(*), intent(in) :: leakage                 !! estimate, prior or none
        type(level1_estimate_t), intent(out) :: estimate
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: EDIT_ROUNDS = 3
        type(level1_drive_t) :: drive
        type(level1_solution_t) :: solution
        type(error_t), allocatable :: failure
        integer :: i, round, dropped

        allocate (estimate%findings(0), estimate%remarks(0), estimate%solutions(0))
        if (.not. any(calibration%spans%used)) then
            call fail(error, 'no span is usable: the first, because of '//trim(calibration%spans(1)%reason))
            return
        end if
        call fit_gyro_axes(calibration, estimate%gyros, failure)
        call choose_drive(calibration, setup, drive, estimate, error)
        if (.not. allocated(error)) call tie_gains(calibration, setup, drive, estimate, error)
        if (allocated(error)) return
        do round = 1, EDIT_ROUNDS
            solution%source = LEVEL1_SOURCES(1)
            call solve_by_source(calibration, setup, estimate, LEVEL1_SOURCES(1), leakage, solution, error)
            if (allocated(error)) return
            call drop_outliers(calibration, drive, estimate, solution, dropped)
            if (dropped == 0) exit
            call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay, .true.)
        end do
        do i = 1, size(sources)
            call solve_by_source(calibration, setup, estimate, sources(i), leakage, solution, failure)
            if (allocated(failure)) then
                call append(estimate%remarks, trim(sources(i))//': '//failure%message)
                deallocate (failure)
                cycle
            end if
            estimate%solutions = [estimate%solutions, solution]
        end do
        estimate%drive = drive
        if (size(estimate%solutions) == 0) then
            call fail(error, 'no source gives an offset: '//estimate%remarks(size(estimate%remarks))%text)
            return
        end if
        call name_faults(calibration, setup, estimate)
        call judge(calibration, estimate)
        estimate%flag = estimate%solutions(1)%flag
    end subroutine estimate_level1
end module gracecg_level1_all_sources
