!> A designed manoeuvre against the report's: one manoeuvre of all three rods for each satellite, its limit
!> along a revolution, and what `optimal` reaches with it in the cases of the report.
module gracecg_studies_designed_manoeuvre
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    use gracecg_files_data_table, only: data_table_t
    use gracecg_spacecraft_torque_rods, only: take_manoeuvre, SQUARE
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_planning_scan, only: map_point_t, map_manoeuvre
    use gracecg_planning_design, only: manoeuvre_design_t
    use gracecg_planning_planner, only: plan_request_t, EVERYWHERE, plan_t, prepare_plan, find_manoeuvre, &
        times_along, take_design
    use gracecg_planning_bound, only: case_bound_t, bound_of_case
    use gracecg_studies_trim, only: trim_settings_t, trim_statistics_t, repeat_trim
    implicit none
    private
    public :: design_study_t, study_design, design_map_table
    public :: designed_calibration_t, calibrate_with_design, designed_calibrations_table
    public :: DESIGN_ALGORITHM, LOWEST_FREQUENCY

    character(*), parameter :: DESIGN_ALGORITHM = 'optimal'     !! That calibrates with the designed manoeuvre
    real(dp), parameter :: LOWEST_FREQUENCY = 0.1_dp            !! Of the search, Hz
    integer, parameter :: TRIM_ROUNDS = 2
    real(dp), parameter :: MAP_STEP = 60            !! Between the places of the map, s

    !> The manoeuvres of one satellite over a revolution.
    type :: design_study_t
        type(calibration_t) :: calibration                  !! Case 1, the manoeuvre the designed one
        type(manoeuvre_design_t) :: design                  !! What the search found
        type(map_point_t), allocatable :: report(:)         !! The map of the report's manoeuvre
        type(map_point_t), allocatable :: designed(:)       !! Of the designed one
        integer :: places = 0                               !! That it is designed for
    end type design_study_t

    !> What the designed manoeuvre reaches in a case; body axes, m.
    type :: designed_calibration_t
        character(64) :: case_name = ''         !! Of the case of the report
        real(dp) :: bound(3) = 0                !! Cramer-Rao
        integer :: runs = 0                     !! Each calibrates, trims and calibrates again
        real(dp) :: rms(3) = 0                  !! Of the errors, all errors on
        real(dp) :: trimmed(3) = 0              !! Likewise, when one trim has made the offset small
    end type designed_calibration_t

contains

    !> Designs a manoeuvre of square waves for one revolution of a satellite, and maps it and the report's.
    subroutine study_design(satellite, threads, study, error, progress)
        character(*), intent(in) :: satellite       !! 'front' or 'back'
        integer, intent(in) :: threads              !! How many to use
        type(design_study_t), intent(out) :: study
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the manoeuvres looked at

        type(plan_request_t) :: request
        type(plan_t) :: plan
        real(dp), allocatable :: times(:)

        call find_calibration(satellite//'-1', study%calibration, error)
        if (allocated(error)) return
        request%place = EVERYWHERE
        request%settings%threads = threads
        request%settings%lowest_frequency = LOWEST_FREQUENCY
        request%settings%waveform_used = .false.
        request%settings%waveform_used(SQUARE) = .true.
        call prepare_plan(study%calibration, request, plan, error)
        call tell(progress, 'designed manoeuvre, '//satellite//' satellite')
        if (.not. allocated(error)) call find_manoeuvre(request, plan, error, progress)
        if (allocated(error)) return
        study%places = size(plan%sites)
        study%design = plan%design
        times = times_along(plan%orbit, MAP_STEP)
        call map_manoeuvre(plan%arc, plan%orbit, times, study%calibration%case%satellite%rods, threads, study%report, &
                           error)
        if (allocated(error)) return
        call map_manoeuvre(plan%arc, plan%orbit, times, study%design%rods, threads, study%designed, error)
        call take_design(study%design, study%calibration)
        study%calibration%case%name = satellite//'-design'
    end subroutine study_design

    !> Bound and Monte Carlo of a case with the designed manoeuvre: calibrations, and others after one trim by them. Fails
    !> as `repeat_trim` does, so when a run does not converge.
    subroutine calibrate_with_design(case_name, design, seed, runs, threads, reached, error, progress)
        character(*), intent(in) :: case_name               !! Of the report
        type(manoeuvre_design_t), intent(in) :: design      !! For the satellite of the case
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: runs, threads                !! How many, and how many in parallel
        type(designed_calibration_t), intent(out) :: reached
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the runs

        type(calibration_t) :: calibration
        type(case_bound_t) :: bound
        type(trim_settings_t) :: settings
        type(trim_statistics_t) :: rounds(TRIM_ROUNDS)

        call find_calibration(case_name, calibration, error)
        if (allocated(error)) return
        call expect_pieces(progress, runs, 'runs')
        call tell(progress, 'designed manoeuvre, '//case_name)
        call take_manoeuvre(design%rods, calibration%case%satellite%rods)
        call bound_of_case(calibration%case, calibration%options, bound, error)
        if (allocated(error)) return
        call take_design(design, calibration)
        settings%rounds = TRIM_ROUNDS
        settings%seed = seed
        call repeat_trim(calibration%case, DESIGN_ALGORITHM, calibration%options, settings, runs, threads, rounds, error, &
                         progress)
        if (allocated(error)) return
        reached%case_name = case_name
        reached%bound = bound%sigma
        reached%runs = runs
        reached%rms = rounds(1)%estimate_error
        reached%trimmed = rounds(TRIM_ROUNDS)%estimate_error
    end subroutine calibrate_with_design

    !> The maps of a satellite: theoretical limit of the offset, the worst direction last, of the manoeuvre of case 1 and of the
    !> designed one, started there.
    function design_map_table(study) result(table)
        type(design_study_t), intent(in) :: study
        type(data_table_t) :: table

        integer :: i

        call table%columns_of('time_s,latitude_deg,longitude_deg,report_x_mm,report_y_mm,report_z_mm,report_worst_mm,'// &
                              'designed_x_mm,designed_y_mm,designed_z_mm,designed_worst_mm')
        do i = 1, size(study%report)
            associate (a => study%report(i), b => study%designed(i))
                call table%add([a%time, a%latitude/DEGREE, a%longitude/DEGREE, a%quality%sigma/MILLIMETRE, &
                                a%worst_sigma/MILLIMETRE, b%quality%sigma/MILLIMETRE, b%worst_sigma/MILLIMETRE])
            end associate
        end do
    end function design_map_table

    !> What is reached in the cases: a row a case and axis.
    function designed_calibrations_table(reached) result(table)
        type(designed_calibration_t), intent(in) :: reached(:)
        type(data_table_t) :: table

        integer :: i, axis

        call table%columns_of('case,axis,bound_mm,runs,rms_mm,rms_after_trim_mm')
        do i = 1, size(reached)
            do axis = 1, 3
                associate (r => reached(i))
                    call table%add(r%case_name, AXES(axis))
                    call table%add([r%bound(axis)/MILLIMETRE, real(r%runs, dp), [r%rms(axis), r%trimmed(axis)]/MILLIMETRE])
                end associate
            end do
        end do
    end function designed_calibrations_table
end module gracecg_studies_designed_manoeuvre
