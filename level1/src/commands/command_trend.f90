!> gracecg level1 trend: offsets from Level-1 data of several dates.
module gracecg_level1_command_trend
    use gracecg_base_constants, only: MICROMETRE, JULIAN_YEAR
    use gracecg_base_text, only: pick_text
    use gracecg_files_json, only: read_json_file, read_json_numbers, read_json_text
    use gracecg_level1_events, only: level1_event_t, read_events
    use gracecg_level1_setup, only: level1_setup_t, read_level1_setup
    use gracecg_level1_time, only: gps_day
    use gracecg_level1_trend, only: trend_point_t, level1_trend_t, fit_trend, predicted_change
    use gracecg_cli_page_program, only: make_page
    use gracecg_cli_results, only: put_columns
    use gracecg_cli_work
    implicit none
    private
    public :: declare_level1_trend, run_level1_trend

    integer, parameter :: MOST_RESULTS = 10000
    real(dp), parameter :: LIMIT = 100*MICROMETRE       !! Of each component of d

contains

    !> Arguments and help of `gracecg level1 trend`.
    subroutine declare_level1_trend(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('level1 trend', 'RESULT ...', 1, MOST_RESULTS, &
                                'How the CG offset changes with time: a weighted straight line through the results of '// &
                                '`gracecg level1 estimate --format json` of several dates, by axis, with a step at every '// &
                                'VCM event of an SOE file, and beside it what the gas used lets expect.', &
                                'gracecg level1 trend 2020-02.json 2020-08.json 2021-02.json --setup setup.nml')
        call arguments%add_option('--soe', 'FILE', 'events: a step at every VCM of the satellite')
        call arguments%add_option('--setup', 'FILE', 'mass and positions of the tanks, for the change that the gas lets expect')
        call arguments%add_option('--report', 'FILE.html', 'writes a page with the plot (takes Python)')
        call add_format_option(arguments)
    end subroutine declare_level1_trend

    !> The work of `gracecg level1 trend`.
    subroutine run_level1_trend(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(trend_point_t), allocatable :: points(:)
        type(level1_trend_t) :: trend
        type(level1_setup_t) :: setup
        character(:), allocatable :: soe, setup_file, page
        character(1) :: satellite
        real(dp), allocatable :: steps(:)

        call arguments%get('--soe', soe, misuse)
        call arguments%get('--setup', setup_file, misuse)
        call arguments%get('--report', page, misuse)
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return
        call check_writable(page, error)
        if (.not. allocated(error) .and. setup_file /= '') call read_level1_setup(setup_file, setup, error)
        if (.not. allocated(error)) call read_points(arguments, points, satellite, error)
        if (.not. allocated(error)) call read_steps(soe, satellite, steps, error)
        if (.not. allocated(error)) call fit_trend(points, steps, LIMIT, trend, error)
        if (allocated(error)) return
        if (any(points%flag > 0)) call console%warn(integer_text(count(points%flag > 0))//' of the results are to be used '// &
                                                    'with care (flag 1)')
        call show(page, points, trend, setup, satellite, console, error)
        if (.not. allocated(error) .and. page /= '') call console%line('written: '//page)
    end subroutine run_level1_trend

    !> The results in order of time, of one satellite.
    subroutine read_points(arguments, points, satellite, error)
        type(arguments_t), intent(in) :: arguments
        type(trend_point_t), allocatable, intent(out) :: points(:)
        character(1), intent(out) :: satellite
        type(error_t), allocatable, intent(out) :: error

        type(trend_point_t) :: point
        character(1) :: name
        integer :: i, earlier

        allocate (points(0))
        satellite = ''
        do i = 1, arguments%positional_count()
            call read_point(arguments%positional(i), point, name, error)
            if (.not. allocated(error) .and. i > 1 .and. name /= satellite) &
                call fail(error, arguments%positional(i)//': of satellite '//name//', the first result is of '//satellite)
            if (.not. allocated(error) .and. any(abs(points%time - point%time) <= 0)) &
                call fail(error, arguments%positional(i)//': of the same time as another result: each counts once')
            if (allocated(error)) return
            satellite = name
            earlier = count(points%time <= point%time)
            points = [points(:earlier), point, points(earlier + 1:)]
        end do
    end subroutine read_points

    !> A result of `gracecg level1 estimate --format json`.
    subroutine read_point(path, point, satellite, error)
        character(*), intent(in) :: path
        type(trend_point_t), intent(out) :: point
        character(1), intent(out) :: satellite
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: text, name
        real(dp) :: flag(1), time(1)
        logical :: ok

        satellite = ''
        call read_json_file(path, text, error)
        if (allocated(error)) return
        call read_json_text(text, 'satellite', name, ok)
        if (.not. ok) then
            call fail(error, path//': has no "satellite"; expected what gracecg level1 estimate --format json prints')
            return
        end if
        satellite = name
        call take('epoch_gps_s', time)
        call take('offset_mm', point%offset)
        call take('sigma_mm', point%sigma)
        call take('flag', flag)
        call take('gas_kg', point%gas)
        if (allocated(error)) return
        if (flag(1) > 1) then
            call read_json_text(text, 'reason', name, ok)
            call fail(error, path//': this estimate is not to be used (flag 2: '//name//'): leave it out')
            return
        end if
        if (any(.not. point%sigma > 0)) call fail(error, path//': sigma_mm has to be positive')
        point%time = time(1)
        point%flag = nint(flag(1))
        point%offset = point%offset*MILLIMETRE
        point%sigma = point%sigma*MILLIMETRE

    contains

        subroutine take(key, numbers)
            character(*), intent(in) :: key
            real(dp), intent(inout) :: numbers(:)

            real(dp), allocatable :: found(:)

            if (allocated(error)) return
            call read_json_numbers(text, key, found, ok)
            if (ok) ok = size(found) == size(numbers)
            if (ok) then
                numbers = found
            else
                call fail(error, path//': "'//key//'" is missing or has not '//integer_text(size(numbers))//' numbers; '// &
                          'expected what gracecg level1 estimate --format json prints')
            end if
        end subroutine take
    end subroutine read_point

    !> Times of the VCM events of a satellite.
    subroutine read_steps(path, satellite, steps, error)
        character(*), intent(in) :: path        !! Empty: none
        character(1), intent(in) :: satellite
        real(dp), allocatable, intent(out) :: steps(:)
        type(error_t), allocatable, intent(out) :: error

        type(level1_event_t), allocatable :: events(:)
        integer :: i

        allocate (steps(0))
        if (path == '') return
        call read_events(path, events, error)
        if (allocated(error)) return
        do i = 1, size(events)
            if (events(i)%name /= 'VCM') cycle
            if (events(i)%spacecraft /= 'GRACE'//satellite .and. events(i)%spacecraft /= 'GRACEX') cycle
            if (any(steps == events(i)%time)) cycle         ! written twice
            steps = [steps, events(i)%time]
        end do
    end subroutine read_steps

    subroutine show(page, points, trend, setup, satellite, console, error)
        character(*), intent(in) :: page        !! Path; empty: none
        type(trend_point_t), intent(in) :: points(:)
        type(level1_trend_t), intent(in) :: trend
        type(level1_setup_t), intent(in) :: setup       !! Without a mass: nothing is known of the tanks
        character(1), intent(in) :: satellite
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(data_table_t) :: table
        type(results_t) :: results
        character(:), allocatable :: text
        integer :: k
        logical :: is_left

        is_left = trend%passes >= 0 .and. trend%passes <= points(size(points))%time
        call trend_table(points, trend, setup, table)
        call console%line('satellite '//satellite//', '//integer_text(size(points))//' dates')
        call console%table(table)
        do k = 1, 3
            call console%line('d'//AXES(k)//': '//um(trend%rate(k)*JULIAN_YEAR)//' +- '// &
                              um(trend%rate_sigma(k)*JULIAN_YEAR)//' um/a'//pick_text(trend%degrees > 0, '; chi square '// &
                              trim(rounded_text(trend%chi_square(k), 3))//' with '//integer_text(trend%degrees)// &
                              ' degrees of freedom', ''))
        end do
        do k = 1, size(trend%step_time)
            call console%line('step at '//gps_day(floor(trend%step_time(k), i8))//': '// &
                              um(trend%step(1, k))//', '//um(trend%step(2, k))//', '//um(trend%step(3, k))//' um (x, y, z)')
        end do
        if (trend%passes < 0) then
            call console%line('no component of d exceeds 100 um for 50 years')
        else if (is_left) then
            call console%line('a component of d is above 100 um')
        else
            call console%line('a component of d passes 100 um on '//gps_day(floor(trend%passes, i8)))
        end if
        call results%open('level1 trend')
        call results%member('satellite', satellite)
        call results%member('rate_um_year', trend%rate*JULIAN_YEAR/MICROMETRE)
        call results%member('rate_sigma_um_year', trend%rate_sigma*JULIAN_YEAR/MICROMETRE)
        call results%member('chi_square', trend%chi_square)
        call results%member('degrees', trend%degrees)
        if (trend%passes >= 0) call results%member('passes_100_um', gps_day(floor(trend%passes, i8)))
        call results%member('limit_um', LIMIT/MICROMETRE)
        call results%member('limit_left', is_left)
        call results%begin_array('steps')
        do k = 1, size(trend%step_time)
            call results%begin(on_one_line=.true.)
            call results%member('date', gps_day(floor(trend%step_time(k), i8)))
            call results%member('step_um', trend%step(:, k)/MICROMETRE)
            call results%member('sigma_um', trend%step_sigma(:, k)/MICROMETRE)
            call results%end()
        end do
        call results%end()
        call put_lines(points, trend, results)
        if (console%format == 'text' .and. page == '') return
        call results%publish(table, console, error, json=text)
        if (.not. allocated(error) .and. page /= '') call make_page(page, text, error)
    end subroutine show

    !> A row a date.
    subroutine trend_table(points, trend, setup, table)
        type(trend_point_t), intent(in) :: points(:)
        type(level1_trend_t), intent(in) :: trend
        type(level1_setup_t), intent(in) :: setup
        type(data_table_t), intent(out) :: table

        integer :: i

        call table%column('date', 'a', 'date (GPS)')
        call table%column('time_gps_s')
        call axis_columns(table, 'd', '_mm', 'f9.4', 'd, mm')
        call axis_columns(table, 'sigma_', '_mm', 'f8.4', 'sigma, mm')
        call axis_columns(table, 'line_', '_mm', 'f9.4', 'line, mm')
        do i = 1, size(AXES)
            call table%column('by_gas_'//AXES(i)//'_um', 'f9.2', 'by gas '//AXES(i)//'|um')
        end do
        call table%column('flag', 'i0', 'flag')
        do i = 1, size(points)
            call table%add(gps_day(floor(points(i)%time, i8)), [points(i)%time, [points(i)%offset, points(i)%sigma, &
                                                                trend%at(points(i)%time)]/MILLIMETRE])
            if (setup%mass > 0 .and. all(points(i)%gas >= 0) .and. all(points(1)%gas >= 0)) then
                call table%add(predicted_change(setup, points(1)%gas, points(i)%gas)/MICROMETRE)
            else
                call table%add_nothing(3)
            end if
            call table%add(points(i)%flag)
        end do
    end subroutine trend_table

    !> The lines with their steps, closely.
    subroutine put_lines(points, trend, results)
        type(trend_point_t), intent(in) :: points(:)
        type(level1_trend_t), intent(in) :: trend
        type(results_t), intent(inout) :: results

        integer, parameter :: LINE_POINTS = 401
        real(dp) :: time(LINE_POINTS), line(3, LINE_POINTS)
        integer :: i

        do i = 1, LINE_POINTS
            time(i) = points(1)%time + (i - 1)*(points(size(points))%time - points(1)%time)/(LINE_POINTS - 1)
            line(:, i) = trend%at(time(i))/MICROMETRE
        end do
        call results%begin('tables')
        call results%begin('trend_lines')
        call results%member('time_gps_s', time)
        call put_columns(results, 'd', '_um', line)
        call results%end()
        call results%end()
    end subroutine put_lines

    function um(length) result(text)
        real(dp), intent(in) :: length
        character(:), allocatable :: text

        character(16) :: digits

        write (digits, '(f16.1)') length/MICROMETRE
        text = trim(adjustl(digits))
    end function um
end module gracecg_level1_command_trend
