!> gracecg history: the offset over months and years, and when to calibrate next.
module gracecg_cli_history
    use gracecg_base_constants, only: MICROMETRE, SECONDS_PER_DAY, JULIAN_YEAR
    use gracecg_base_text, only: pick_text
    use gracecg_environment_time, only: utc_t, parse_utc
    use gracecg_files_table, only: table_file_t
    use gracecg_estimation_action, only: listed_axes
    use gracecg_estimation_joint_estimate, only: FAMILY_LEVEL
    use gracecg_cli_console, only: STATUS_NOT_TO_BE_USED
    use gracecg_estimation_offset_change, only: offset_change_t, read_changes, read_dated_rows
    use gracecg_estimation_offset_history, only: history_settings_t, tank_series_t, new_tank_series, offset_history_t, &
        history_point_t, trace_offset, LONGEST_FUTURE, DEFAULT_WALK
    use gracecg_estimation_offset_movement, only: movement_words
    use gracecg_estimation_saved_estimate, only: dated_offset_t, read_offsets
    use gracecg_cli_calibration_json, only: put_movement
    use gracecg_cli_page_program, only: make_page
    use gracecg_cli_joint, only: show_offset
    use gracecg_cli_work
    implicit none
    private
    public :: declare_history, run_history

    integer, parameter :: MOST_FILES = 1000
    character(11), parameter :: TANK_COLUMNS(3) = [character(11) :: 'time_utc', 'tank_1_kg', 'tank_2_kg']

    real(dp), parameter :: NOT_ZERO = 3             !! Standard deviations of a component that is not 0
    real(dp), parameter :: LATE = 0.84_dp       !! Part of the futures that have left at the last of the dates told

contains

    !> Arguments and help of `gracecg history`.
    subroutine declare_history(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('history', 'FILE ...', 1, MOST_FILES, &
                                'The CG offset over months and years, from calibrations: estimates saved with '// &
                                'gracecg estimate --format json or gracecg level1 estimate --format json, or '// &
                                'CSV files with time_utc,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm. '// &
                                'Between calibrations it changes by masses that are moved, by the '// &
                                'gas that the tanks lose, and by a random walk. Says what the offset is today, when it '// &
                                'will leave its limit, and when to calibrate. The exit status is 3 when the '// &
                                'calibrations contradict each other: no masses are to be moved by them.', &
                                'gracecg simulate front-1 --out run1'//new_line('a')// &
                                'gracecg estimate run1 --algorithm optimal --format json > run1.json'//new_line('a')// &
                                'gracecg history run1.json --today 1989-06-01 --report history.html')
        call arguments%add_option('--changes', 'FILE', 'CSV of masses moved: time_utc, change of the offset and its '// &
                                  'sigmas in mm, columns as above')
        call arguments%add_option('--tanks', 'FILE', 'CSV of the gas in both tanks: time_utc,tank_1_kg,tank_2_kg')
        call arguments%add_option('--tank-x', 'X1 X2', 'of --tanks: where they lie on the x axis, m')
        call arguments%add_option('--mass', 'KG', 'of the satellite with the gas of the first time', default='420')
        call arguments%add_option('--walk-um', 'UM', 'standard deviation of the random walk of an axis in a year, '// &
                                  'micrometres', default=rounded_text(DEFAULT_WALK/MICROMETRE, 3))
        call arguments%add_option('--limit-mm', 'MM', 'that no component is to leave', default='0.1')
        call arguments%add_option('--risk', 'P', 'of having left it, that calls for a calibration', default='0.05')
        call arguments%add_option('--today', 'ISO', 'UTC (default: the time of the last calibration)')
        call arguments%add_option('--step', 'DAYS', 'from point to point', default='10')
        call arguments%add_option('--out', 'FILE', 'CSV file of the offset at all points')
        call arguments%add_option('--report', 'FILE.html', 'writes a page with the plot (takes Python)')
        call add_format_option(arguments)
    end subroutine declare_history

    !> The work of `gracecg history`.
    subroutine run_history(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(history_settings_t) :: settings
        type(offset_history_t) :: history
        type(dated_offset_t), allocatable :: offsets(:)
        type(offset_change_t), allocatable :: changes(:)
        type(tank_series_t) :: tanks
        character(:), allocatable :: out, page, date
        type(utc_t), allocatable :: today

        call read_settings(arguments, settings, misuse)
        call arguments%get('--out', out, misuse)
        call arguments%get('--report', page, misuse)
        call arguments%get('--today', date, misuse)
        call take_format(arguments, console, misuse)
        call refuse_if(arguments%has('--tanks') .neqv. arguments%has('--tank-x'), '--tanks and --tank-x belong together', &
                       misuse)
        if (allocated(misuse)) return
        call check_writable(out, error)
        if (.not. allocated(error)) call check_writable(page, error)
        if (.not. allocated(error) .and. date /= '') then
            allocate (today)
            call parse_utc(date, today, error)
            call add_context(error, '--today')
        end if
        if (.not. allocated(error)) call read_all_offsets(arguments, console, offsets, error)
        if (.not. allocated(error)) call read_known_changes(arguments, changes, misuse, tanks, error)
        if (allocated(error) .or. allocated(misuse)) return
        call trace_offset(offsets, changes, tanks, settings, history, error, today)
        if (allocated(error)) return
        if (contradict(history)) console%status_done = STATUS_NOT_TO_BE_USED
        if (contradict(history)) call console%warn('the calibrations differ by more than the random walk explains: chi square '// &
                              rounded_text(history%statistic, 4)//' for '//integer_text(history%degrees)// &
                              ' degrees of freedom; masses that were moved belong into --changes, or --walk-um is too small')
        if (history%movement%kind /= 'none') call console%warn('not expected: '//trim(movement_words(history%movement))// &
                                                               '; masses that were moved belong into --changes')
        call show(history, settings, any(offsets%moves_masses), console)
        call publish(page, out, history, settings, any(offsets%moves_masses), console, error)
        if (.not. allocated(error) .and. page /= '') call console%line('written: '//page)
    end subroutine run_history

    subroutine read_settings(arguments, settings, misuse)
        type(arguments_t), intent(in) :: arguments
        type(history_settings_t), intent(out) :: settings
        type(error_t), allocatable, intent(inout) :: misuse

        real(dp) :: walk        ! um

        call arguments%get('--walk-um', walk, misuse, low=1e-3_dp, high=1e5_dp, unit='um')
        call arguments%get('--limit-mm', settings%limit, misuse, low=1e-4_dp, high=1e3_dp, unit='mm')
        call arguments%get('--risk', settings%risk, misuse, low=1e-3_dp, high=0.5_dp)
        call arguments%get('--step', settings%step, misuse, low=0.1_dp, high=365.0_dp, unit='days')
        settings%walk = walk*MICROMETRE
        settings%limit = settings%limit*MILLIMETRE
        settings%step = settings%step*SECONDS_PER_DAY
    end subroutine read_settings

    subroutine read_all_offsets(arguments, console, offsets, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(dated_offset_t), allocatable, intent(out) :: offsets(:)
        type(error_t), allocatable, intent(out) :: error

        type(dated_offset_t), allocatable :: more(:)
        character(1), allocatable :: known(:)       ! Satellites, where files say one
        integer :: i

        allocate (offsets(0))
        do i = 1, arguments%positional_count()
            call read_offsets(arguments%positional(i), more, error)
            if (allocated(error)) return
            offsets = [offsets, more]
            known = pack(offsets%satellite, offsets%satellite /= '')
            if (any(known /= more(1)%satellite) .and. more(1)%satellite /= '') then
                call fail(error, arguments%positional(i)//' is of satellite '//more(1)%satellite//', those before of '// &
                          known(1)//': a history is of one satellite')
                return
            end if
            if (all(more%moves_masses)) cycle
            call console%warn(arguments%positional(i)//' says itself to calibrate again before masses are moved')
        end do
    end subroutine read_all_offsets

    subroutine read_known_changes(arguments, changes, misuse, tanks, error)
        type(arguments_t), intent(in) :: arguments
        type(offset_change_t), allocatable, intent(out) :: changes(:)
        type(error_t), allocatable, intent(inout) :: misuse
        type(tank_series_t), intent(out) :: tanks
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: path
        type(table_file_t) :: file
        type(utc_t), allocatable :: time(:)
        real(dp), allocatable :: mass(:, :)
        real(dp) :: position(3, 2), places(2), satellite

        call arguments%get('--mass', satellite, misuse, low=1.0_dp, high=1e6_dp, unit='kg')
        if (allocated(misuse)) return
        call arguments%get('--changes', path, misuse)
        if (path /= '') call read_changes(path, changes, error)
        if (allocated(error)) return
        if (.not. allocated(changes)) allocate (changes(0))
        call arguments%get('--tanks', path, misuse)
        if (path == '') return
        call arguments%get('--tank-x', places, misuse, low=-10.0_dp, high=10.0_dp, unit='m')
        if (allocated(misuse)) return
        call read_dated_rows(path, TANK_COLUMNS, file, time, mass, error)
        if (allocated(error)) return
        position = 0
        position(1, :) = places
        call new_tank_series(time, mass, position, satellite, tanks, error)
        call add_context(error, path)
    end subroutine read_known_changes

    !> For people.
    subroutine show(history, settings, moves_masses, console)
        type(offset_history_t), intent(in) :: history
        type(history_settings_t), intent(in) :: settings
        logical, intent(in) :: moves_masses     !! As of outlook
        type(console_t), intent(inout) :: console

        call console%line(integer_text(history%calibrations)//' calibrations from '//date_of(history%points(1)%time)//' to '// &
                          date_of(history%points(findloc(history%points%is_calibration, .true., 1, back=.true.))%time))
        call console%line('')
        call console%line('after each calibration: from those so far, and from all')
        call console%table(points_table(pack(history%points, history%points%is_calibration), short=.true.))
        if (history%degrees > 0) &
            call console%line('what calibrations brought that was not expected: chi square '// &
                              rounded_text(history%statistic, 4)//' for '//integer_text(history%degrees)// &
                              ' degrees of freedom, probability '//rounded_text(history%probability, 3))
        call console%line('')
        call console%line('today, '//date_of(history%today%time)//', the offset is')
        call show_offset(history%today%filtered, history%today%filtered_sigma, console)
        call console%paragraph(outlook(history, settings, moves_masses))
    end subroutine show

    !> When the offset leaves its limit, in words.
    function outlook(history, settings, moves_masses) result(text)
        type(offset_history_t), intent(in) :: history
        type(history_settings_t), intent(in) :: settings
        logical, intent(in) :: moves_masses     !! Some calibration allows it by itself
        character(:), allocatable :: text

        character(:), allocatable :: last
        logical :: beyond(3), known(3)

        text = 'no masses are to be moved by calibrations that contradict each other'
        if (contradict(history)) return
        text = rounded_text(settings%limit/MILLIMETRE, 4)//' mm'
        last = date_of(history%leaving(3))
        if (history%left_in_the_end < LATE) last = 'later than '//last
        if (history%left_already > 0.5_dp) then
            beyond = abs(history%today%filtered) > max(settings%limit, NOT_ZERO*history%today%filtered_sigma)
            known = moves_masses .and. history%today%filtered_sigma <= settings%limit
            text = 'it lies outside of '//text//': '
            if (any(beyond .and. known)) then
                text = text//'move masses along '//trim(listed_axes(beyond .and. known))//' (gracecg trim), then calibrate'
                if (.not. all(known)) text = text//'; '//trim(listed_axes(.not. known))//': not known well enough to be trimmed'
            else
                text = text//'calibrate again before masses are moved'
            end if
        else if (history%leaves) then
            text = 'it will leave '//text//' on '//date_of(history%leaving(2))//' (68 %: '//date_of(history%leaving(1))// &
                   ' to '//last//')'
        else
            text = 'it will hardly leave '//text//' within '//integer_text(nint(LONGEST_FUTURE/JULIAN_YEAR))// &
                   ' years (probability '//rounded_text(history%left_in_the_end, 3)//')'
        end if
        if (history%left_already <= 0.5_dp .and. history%left_in_the_end >= settings%risk) &
            text = text//'; calibrate by '//date_of(history%calibrate_by)// &
                   ', when that has happened with a probability of '//rounded_text(settings%risk, 3)
    end function outlook

    !> Do the calibrations differ by more than changes and walk explain?
    pure logical function contradict(history)
        type(offset_history_t), intent(in) :: history

        contradict = history%degrees > 0 .and. history%probability < FAMILY_LEVEL
    end function contradict

    function date_of(time) result(text)
        type(utc_t), intent(in) :: time
        character(10) :: text

        text = utc_text(time)       ! as much of it as fits
    end function date_of

    !> The offset at points in time, a row each.
    function points_table(points, short) result(table)
        type(history_point_t), intent(in) :: points(:)
        logical, intent(in) :: short        !! Dates without the time of day, for people
        type(data_table_t) :: table

        integer :: i

        call table%column('time_utc', 'a', 'date')
        call table%column('calibration')
        call axis_columns(table, 'd', '_mm', 'f10.4', 'offset, mm')
        call axis_columns(table, 'sigma_', '_mm', 'f9.4', 'sigma, mm')
        call axis_columns(table, 'smoothed_', '_mm', 'f10.4', 'smoothed, mm')
        call table%columns_of('smoothed_sigma_x_mm,smoothed_sigma_y_mm,smoothed_sigma_z_mm')
        do i = 1, size(points)
            associate (point => points(i))
                call table%add(pick_text(short, date_of(point%time), utc_text(point%time)))
                call table%add(point%is_calibration)
                call table%add([point%filtered, point%filtered_sigma, point%smoothed, point%smoothed_sigma]/MILLIMETRE)
            end associate
        end do
    end function points_table

    !> As CSV or JSON, the page and the file of it.
    subroutine publish(page, out, history, settings, moves_masses, console, error)
        character(*), intent(in) :: page, out   !! Paths; empty: none
        type(offset_history_t), intent(in) :: history
        type(history_settings_t), intent(in) :: settings
        logical, intent(in) :: moves_masses     !! As of outlook
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results
        character(:), allocatable :: json

        call results%open('history')
        call results%member('calibrations', history%calibrations)
        call results%member('walk_um_in_a_year', settings%walk/MICROMETRE)
        call results%member('chi_square', history%statistic)
        call results%member('degrees_of_freedom', history%degrees)
        call results%member('probability', history%probability)
        call put_movement(history%movement, results)
        call results%begin('today')
        call results%member('time_utc', utc_text(history%today%time))
        call results%member('offset_mm', history%today%filtered/MILLIMETRE)
        call results%member('sigma_mm', history%today%filtered_sigma/MILLIMETRE)
        call results%member('covariance_m2', history%today%filtered_covariance)
        call results%end()
        call results%member('limit_mm', settings%limit/MILLIMETRE)
        call results%member('risk', settings%risk)
        call results%member('outlook', outlook(history, settings, moves_masses))
        if (history%leaves) then
            call results%member('leaves_utc', utc_text(history%leaving(2)))
            call results%member('leaves_from_utc', utc_text(history%leaving(1)))
            if (history%left_in_the_end >= LATE) call results%member('leaves_to_utc', utc_text(history%leaving(3)))
        end if
        if (history%left_in_the_end >= settings%risk) &
            call results%member('calibrate_by_utc', utc_text(history%calibrate_by))
        call results%member('part_that_leaves', history%left_in_the_end)
        call results%member('outlook_years', nint(LONGEST_FUTURE/JULIAN_YEAR))
        call results%member('outside_already', history%left_already > 0.5_dp)
        call results%member('futures', settings%futures)
        call results%publish(points_table(history%points, short=.false.), console, error, out, 'offset in body axes', json)
        if (.not. allocated(error) .and. page /= '') call make_page(page, json, error)
    end subroutine publish
end module gracecg_cli_history
