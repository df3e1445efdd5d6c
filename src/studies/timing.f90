!> When to calibrate, section 6.2 of CSR-TM-00-01 and its Figures 6.1 and 6.4: one revolution of each
!> satellite, the places of the report's cases, and the best ones.
module gracecg_studies_timing
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, NANOTESLA, MICROTESLA
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    use gracecg_base_text, only: integer_text
    use gracecg_files_data_table, only: data_table_t
    use gracecg_environment_time, only: utc_t, utc_plus, utc_text, seconds_between
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: report_case, TIME_OF_CASE
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit
    use gracecg_planning_scan, only: orbit_place_t, scan_orbit, x_is_weakest
    implicit none
    private
    public :: timing_study_t, study_timing, weakest_x, timing_summary_t, summary_of, best_places, places_table, &
        marked_places_table, revolutions_table

    !> One revolution of one satellite.
    type :: timing_study_t
        type(case_t) :: case                                !! Where the revolution begins
        type(nominal_orbit_t) :: orbit                      !! Along which the places lie
        type(orbit_place_t), allocatable :: places(:)       !! Every `step` along the revolution
        type(orbit_place_t), allocatable :: of_cases(:)     !! Of the report's cases, or of the case alone
        logical :: of_report = .false.                      !! The report's cases lie on this orbit
        integer :: step = 0                                 !! Between the places, s
    end type timing_study_t

    !> What section 6.2 says about a revolution.
    type :: timing_summary_t
        real(dp) :: strongest_field = 0     !! Largest component, T
        real(dp) :: largest = 0             !! Component of the angular acceleration's amplitude, rad/s^2
        real(dp) :: x_strongest = 0         !! Part of the places where the amplitude about x is the largest
        integer :: x_weakest = 0            !! How long it is the smallest, s
    end type timing_summary_t

contains

    !> Flies a satellite once round the Earth. Fails as `scan_orbit` does.
    subroutine study_timing(calibration, step, threads, study, error, progress)
        type(calibration_t), intent(in) :: calibration      !! Its orbit, satellite and options
        integer, intent(in) :: step                 !! Between the places, s
        integer, intent(in) :: threads              !! How many to use
        type(timing_study_t), intent(out) :: study
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the places

        integer, allocatable :: times(:)
        integer :: i

        call tell(progress, 'orbit of '//trim(calibration%case%name))
        study%step = step
        study%case = calibration%case
        call new_nominal_orbit(study%case, study%orbit, error)
        if (allocated(error)) return
        study%of_report = has_orbit_of_case_1(study%case)
        times = [0]
        if (study%of_report) times = nint(TIME_OF_CASE)
        call scan_orbit(study%case, calibration%options, study%orbit, times, threads, study%of_cases, error)
        if (allocated(error)) return
        times = [(i*step, i=0, int(study%orbit%revolution)/step)]
        call tell(progress, 'calibrations along the orbit of '//trim(calibration%case%name))
        call expect_pieces(progress, size(times), 'places')
        call scan_orbit(study%case, calibration%options, study%orbit, times, threads, study%places, error, progress)
    end subroutine study_timing

    !> Does a case begin where and when case 1 of its satellite does in the report? Then the report's other cases
    !> lie on its orbit.
    logical function has_orbit_of_case_1(case)
        type(case_t), intent(in) :: case

        type(case_t) :: first
        type(error_t), allocatable :: failure

        has_orbit_of_case_1 = .false.
        call report_case(trim(case%satellite%name)//'-1', first, failure)
        if (allocated(failure)) return
        has_orbit_of_case_1 = abs(seconds_between(first%epoch, case%epoch)) <= 0 .and. &
                              all(abs(first%position - case%position) <= 0) .and. &
                              all(abs(first%velocity - case%velocity) <= 0)
    end function has_orbit_of_case_1

    !> The extremes of a revolution.
    pure function summary_of(study) result(summary)
        type(timing_study_t), intent(in) :: study
        type(timing_summary_t) :: summary

        integer :: i

        associate (places => study%places)
            do i = 1, size(places)
                summary%strongest_field = max(summary%strongest_field, maxval(abs(places(i)%field)))
                summary%largest = max(summary%largest, maxval(places(i)%acceleration))
            end do
            summary%x_strongest = real(count(x_is_strongest(places)), dp)/size(places)
        end associate
        summary%x_weakest = weakest_x(study)
    end function summary_of

    !> How long the angular acceleration is the smallest about x, s of the revolution.
    pure integer function weakest_x(study)
        type(timing_study_t), intent(in) :: study

        weakest_x = min(count(x_is_weakest(study%places))*study%step, nint(study%orbit%revolution))
    end function weakest_x

    elemental logical function x_is_strongest(place)
        type(orbit_place_t), intent(in) :: place

        x_is_strongest = place%acceleration(1) > maxval(place%acceleration(2:3))
    end function x_is_strongest

    !> Numbers of the places that are best for x, y, z, and for all: where the largest of the three standard
    !> deviations is least. None passes the edge of the Earth's shadow.
    pure function best_places(places) result(best)
        type(orbit_place_t), intent(in) :: places(:)
        integer :: best(4)

        real(dp) :: sigma(3, size(places))
        integer :: i

        do i = 1, size(places)
            sigma(:, i) = places(i)%sigma
        end do
        best = [(minloc(sigma(i, :), 1, .not. places%at_edge), i=1, 3), minloc(maxval(sigma, 1), 1, .not. places%at_edge)]
    end function best_places

    !> Figures 6.1 and 6.4: the calibrations at places of an orbit. For people: their columns.
    function places_table(places, epoch, labels) result(table)
        type(orbit_place_t), intent(in) :: places(:)
        type(utc_t), intent(in) :: epoch                    !! From which their times count
        character(*), intent(in), optional :: labels(:)     !! Of the places, in a column before the others
        type(data_table_t) :: table

        integer :: i

        if (present(labels)) call table%column('place', 'a', 'place')
        call table%column('time_s', 'i8', 'time|s')
        call table%column('utc', 'clock', 'UTC|')
        call table%column('latitude_deg', 'i8', 'lat|deg')
        call table%column('longitude_deg', 'i8', 'lon|deg')
        call table%column('bx_nt', 'f8.1', 'field, uT|x', NANOTESLA/MICROTESLA)
        call table%column('by_nt', 'f8.1', '|y', NANOTESLA/MICROTESLA)
        call table%column('bz_nt', 'f8.1', '|z', NANOTESLA/MICROTESLA)
        call table%column('alpha_x_rad_s2', 'f8.2', '1e-6 rad/s^2|x', 1e6_dp)
        call table%column('alpha_y_rad_s2', 'f8.2', '|y', 1e6_dp)
        call table%column('alpha_z_rad_s2', 'f8.2', '|z', 1e6_dp)
        call table%column('sigma_x_mm', 'f8.4', 'sigma, mm|x')
        call table%column('sigma_y_mm', 'f8.4', '|y')
        call table%column('sigma_z_mm', 'f8.4', '|z')
        do i = 1, size(places)
            associate (place => places(i))
                if (present(labels)) call table%add(labels(i))
                call table%add(place%time)
                call table%add(utc_text(utc_plus(epoch, real(place%time, dp))))
                call table%add([[place%latitude, place%longitude]/DEGREE, place%field/NANOTESLA, place%acceleration, &
                                place%sigma/MILLIMETRE])
            end associate
        end do
    end function places_table

    !> The places of the report's cases on a revolution, or that of the case, and the best ones.
    function marked_places_table(study) result(table)
        type(timing_study_t), intent(in) :: study
        type(data_table_t) :: table

        character(8) :: labels(size(study%of_cases) + 4)
        integer :: i

        do i = 1, size(study%of_cases)
            labels(i) = 'case '//integer_text(i)
        end do
        labels(size(study%of_cases) + 1:) = [character(8) :: 'best x', 'best y', 'best z', 'best all']
        table = places_table([study%of_cases, study%places(best_places(study%places))], study%case%epoch, labels)
    end function marked_places_table

    !> What section 6.2 of the report says of a revolution, satellite by satellite.
    function revolutions_table(studies) result(table)
        type(timing_study_t), intent(in) :: studies(:)
        type(data_table_t) :: table

        type(timing_summary_t) :: summary
        integer :: i

        call table%columns_of('satellite,step_s,strongest_field_nt,largest_acceleration_rad_s2,x_strongest,x_weakest_s')
        do i = 1, size(studies)
            summary = summary_of(studies(i))
            call table%add(studies(i)%case%satellite%name)
            call table%add([real(studies(i)%step, dp), summary%strongest_field/NANOTESLA, summary%largest, summary%x_strongest, &
                            real(summary%x_weakest, dp)])
        end do
    end function revolutions_table
end module gracecg_studies_timing
