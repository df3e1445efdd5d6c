!> gracecg timing: the best time for a calibration, Figures 6.1 and 6.4 of CSR-TM-00-01.
module gracecg_cli_timing
    use gracecg_base_error, only: error_t
    use gracecg_files_file, only: check_writable
    use gracecg_files_data_table, only: data_table_t
    use gracecg_base_text, only: integer_text
    use gracecg_environment_time, only: utc_text
    use gracecg_planning_scan, only: orbit_place_t, x_is_weakest
    use gracecg_studies_timing, only: timing_study_t, study_timing, best_places, places_table, write_places
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_cli_calibration_argument, only: add_options_option, add_cases_option, take_one_calibration
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t, add_format_option, take_format
    implicit none
    private
    public :: declare_timing, run_timing

    character(5), parameter :: SATELLITES(2) = [character(5) :: 'front', 'back']
    integer, parameter :: DEFAULT_STEP = 10, LONGEST_STEP = 600     !! s

contains

    !> Arguments and help of `gracecg timing`.
    subroutine declare_timing(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('timing', '[CASE]', 0, 1, &
                                'Finds the best time for a calibration: over one revolution from the epoch of '// &
                                'a case (default front-1), '// &
                                'the geomagnetic field in body axes (Figure 6.1 of CSR-TM-00-01), the '// &
                                'amplitude of the angular acceleration that the rods give (Figure 6.4) '// &
                                'and the predicted standard deviation of the CG offset.', &
                                'gracecg timing front-1 --step 60 --out timing.csv')
        call add_cases_option(arguments, 'front-1', single=.true.)
        call arguments%add_option('--satellite', 'NAME', 'front or back: the orbit of its case 1, where no CASE is named')
        call arguments%add_option('--step', 'S', 'whole seconds from place to place (default 10)')
        call arguments%add_option('--threads', 'N', 'to work on (default: the processors of the machine)')
        call arguments%add_option('--out', 'FILE', 'CSV file for all places')
        call add_format_option(arguments)
        call add_options_option(arguments)
    end subroutine declare_timing

    !> The work of `gracecg timing`.
    subroutine run_timing(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(timing_study_t) :: study
        type(calibration_t) :: calibration
        character(:), allocatable :: satellite, path
        integer :: step, threads

        call arguments%get('--satellite', satellite, misuse, default='front', choices=SATELLITES)
        call arguments%get('--step', step, misuse, default=DEFAULT_STEP, low=1, high=LONGEST_STEP)
        call arguments%get('--out', path, misuse, default='')
        call take_format(arguments, console, misuse)
        call arguments%get_threads(threads, misuse)
        call refuse_if(arguments%has('--satellite') .and. (arguments%positional_count() > 0 .or. arguments%has('--cases')), &
                       'option --satellite and a CASE exclude each other: a case names its satellite', misuse)
        if (allocated(misuse)) return
        call check_writable(path, error)
        if (.not. allocated(error)) call take_one_calibration(arguments, satellite//'-1', console, calibration, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return

        call study_timing(calibration, step, threads, study, error, console)
        if (allocated(error)) return
        call show_heading(study, console)
        call show_table(study%of_cases, study%places, console)
        call show_weakest_x(study%places, step, console)
        call publish(study, step, console, error)
        if (allocated(error)) return
        if (path /= '') call write_places(path, 'timing', trim(study%case%satellite%name), study%places, error)
    end subroutine run_timing

    !> All places as CSV or JSON.
    subroutine publish(study, step, console, error)
        type(timing_study_t), intent(in) :: study
        integer, intent(in) :: step             !! s
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results
        type(data_table_t) :: of_cases

        call results%open('timing')
        call results%member('satellite', trim(study%case%satellite%name))
        call results%member('epoch_utc', utc_text(study%case%epoch))
        call results%member('duration_s', study%case%duration)
        call results%member('revolution_s', study%orbit%revolution)
        call results%member('step_s', step)
        of_cases = places_table(study%of_cases)
        call of_cases%to_json(results, 'cases')
        call results%begin('best_places')
        associate (best => best_places(study%places))
            call results%member('x_time_s', study%places(best(1))%time)
            call results%member('y_time_s', study%places(best(2))%time)
            call results%member('z_time_s', study%places(best(3))%time)
            call results%member('all_time_s', study%places(best(4))%time)
        end associate
        call results%end()
        call results%member('weakest_about_x_s', count(x_is_weakest(study%places))*step)
        call results%publish(places_table(study%places), console, error)
    end subroutine publish

    subroutine show_heading(study, console)
        type(timing_study_t), intent(in) :: study
        type(console_t), intent(inout) :: console

        associate (case => study%case)
            call console%paragraph(trim(case%satellite%name)//' satellite: one revolution of '// &
                              integer_text(nint(study%orbit%revolution))//' s from '// &
                              utc_text(case%epoch)//', a calibration of '// &
                              integer_text(nint(case%duration))//' s at every '// &
                              integer_text(study%step)//' s')
        end associate
        call console%paragraph('field in body axes; amplitude of the angular acceleration; predicted sigma of the CG offset')
        call console%line('')
    end subroutine show_heading

    !> The places of the report's cases and the best ones.
    subroutine show_table(of_cases, places, console)
        type(orbit_place_t), intent(in) :: of_cases(:), places(:)
        type(console_t), intent(inout) :: console

        character(8) :: labels(size(of_cases) + 4)
        integer :: i

        do i = 1, size(of_cases)
            labels(i) = 'case '//integer_text(i)
        end do
        labels(size(of_cases) + 1:) = [character(8) :: 'best x', 'best y', 'best z', 'best all']
        call console%table(places_table([of_cases, places(best_places(places))], labels))
        call console%line('(best x: the least sigma of x; best all: the largest of the three is least)')
    end subroutine show_table

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
        if (text /= '') call console%paragraph('(places at'//text(2:)//' s)')
    end subroutine show_weakest_x
end module gracecg_cli_timing
