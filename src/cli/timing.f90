!> gracecg timing: the best time for a calibration, Figures 6.1 and 6.4 of CSR-TM-00-01.
module gracecg_cli_timing
    use omp_lib, only: omp_get_num_procs
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, NANOTESLA, AXES
    use gracecg_base_error, only: error_t
    use gracecg_files_file, only: check_writable
    use gracecg_base_text, only: integer_text
    use gracecg_environment_time, only: utc_text
    use gracecg_planning_scan, only: orbit_place_t, x_is_weakest
    use gracecg_studies_timing, only: timing_study_t, study_timing, best_places, write_places
    use gracecg_cli_arguments, only: arguments_t
    use gracecg_cli_console, only: console_t
    implicit none
    private
    public :: declare_timing, run_timing

    character(5), parameter :: SATELLITES(2) = [character(5) :: 'front', 'back']
    integer, parameter :: DEFAULT_STEP = 10, LONGEST_STEP = 600     !! s

contains

    !> Arguments and help of `gracecg timing`.
    subroutine declare_timing(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('timing', '', 0, 0, &
                                'Finds the best time for a calibration: over one revolution from case 1, '// &
                                'the geomagnetic field in body axes (Figure 6.1 of CSR-TM-00-01), the '// &
                                'amplitude of the angular acceleration that the rods give (Figure 6.4) '// &
                                'and the predicted standard deviation of the CG offset.', &
                                'gracecg timing --satellite front --step 60 --out timing.csv')
        call arguments%add_option('--satellite', 'NAME', 'front or back (default front)')
        call arguments%add_option('--step', 'S', 'whole seconds from place to place (default 10)')
        call arguments%add_option('--out', 'FILE', 'CSV file for all places')
    end subroutine declare_timing

    !> The work of `gracecg timing`.
    subroutine run_timing(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(timing_study_t) :: study
        character(:), allocatable :: satellite, path
        integer :: step

        call arguments%get('--satellite', satellite, misuse, default='front', choices=SATELLITES)
        call arguments%get('--step', step, misuse, default=DEFAULT_STEP, low=1, high=LONGEST_STEP)
        call arguments%get('--out', path, misuse, default='')
        if (allocated(misuse)) return
        call check_writable(path, error)
        if (allocated(error)) return

        call console%progress('timing: '//satellite)
        call study_timing(satellite, step, omp_get_num_procs(), study, error)
        if (allocated(error)) return
        call show_heading(study, console)
        call show_table(study%of_cases, study%places, console)
        call show_weakest_x(study%places, step, console)
        if (path /= '') call write_places(path, 'timing', satellite, study%places, error)
    end subroutine run_timing

    subroutine show_heading(study, console)
        type(timing_study_t), intent(in) :: study
        type(console_t), intent(inout) :: console

        associate (case => study%case)
            call console%line(trim(case%satellite%name)//' satellite: one revolution of '// &
                              integer_text(nint(study%orbit%revolution))//' s from '// &
                              utc_text(case%epoch)//', a calibration of '// &
                              integer_text(nint(case%duration))//' s at every '// &
                              integer_text(study%step)//' s')
        end associate
        call console%line('field in body axes; amplitude of the angular acceleration; predicted '// &
                          'standard deviation of the CG offset')
        call console%line('')
    end subroutine show_heading

    !> The places of the report's cases and the best ones.
    subroutine show_table(of_cases, places, console)
        type(orbit_place_t), intent(in) :: of_cases(:), places(:)
        type(console_t), intent(inout) :: console

        integer :: best(4), i

        call console%line('                 time  latitude  longitude           field, nT        '// &
                          '   acceleration, 1e-6 rad/s^2          sigma, mm')
        call console%line('                    s       deg        deg       x       y       z'// &
                          '          x       y       z        x       y       z')
        do i = 1, size(of_cases)
            call show_place('case '//integer_text(i), of_cases(i), console)
        end do
        best = best_places(places)
        do i = 1, size(AXES)
            call show_place('best for '//AXES(i), places(best(i)), console)
        end do
        call show_place('best for all', places(best(4)), console)
        call console%line('(best for all: the largest of the three standard deviations is least)')
    end subroutine show_table

    subroutine show_place(label, place, console)
        character(*), intent(in) :: label
        type(orbit_place_t), intent(in) :: place
        type(console_t), intent(inout) :: console

        character(120) :: row

        write (row, '(a, t14, i8, f10.1, f11.1, 1x, 3i8, 3x, 3f8.2, 1x, 3f8.4)') label, place%time, &
            place%latitude/DEGREE, place%longitude/DEGREE, nint(place%field/NANOTESLA), &
            place%acceleration*1e6_dp, place%sigma/MILLIMETRE
        call console%line(trim(row))
    end subroutine show_place

    !> When the angular acceleration about x is the smallest of the three: section 6.2 expects about
    !> 100 s of a revolution.
    subroutine show_weakest_x(places, step, console)
        type(orbit_place_t), intent(in) :: places(:)
        integer, intent(in) :: step             !! s
        type(console_t), intent(inout) :: console

        logical :: weakest(0:size(places) + 1)
        character(:), allocatable :: text
        integer :: i

        weakest = [.false., x_is_weakest(places), .false.]
        text = ''
        do i = 1, size(places)
            if (.not. weakest(i)) cycle
            if (.not. weakest(i - 1)) then
                text = text//', '//integer_text(places(i)%time)
            else if (.not. weakest(i + 1)) then
                text = text//' to '//integer_text(places(i)%time)
            end if
        end do
        call console%line('')
        call console%line('angular acceleration smaller about x than about y and z: '// &
                          integer_text(count(weakest)*step)//' s of the revolution')
        if (text /= '') call console%line('(places at'//text(2:)//' s)')
    end subroutine show_weakest_x
end module gracecg_cli_timing
