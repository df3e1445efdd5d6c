!> gracecg verify: the verification of CSR-TM-00-01 section 5.3.
module gracecg_cli_verify
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: AXES, MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: tell
    use gracecg_base_text, only: integer_text, pick_text, share_text
    use gracecg_base_version, only: file_comments
    use gracecg_files_file, only: make_directory
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: published_name
    use gracecg_studies_campaign, only: campaign_t, report_campaign
    use gracecg_studies_curves, only: verification_t, verify_case, window_check_t, &
        check_windows, window_counts_t, count_windows, curves_table, curves_file_name, &
        add_window_rows, CURVE_NAMES, WINDOW_COLUMNS, curve_column
    use gracecg_studies_estimate_windows, only: estimate_window_t, campaign_windows, loss_windows, estimate_counts_t, &
        count_estimate_windows, estimate_windows_table, LEAST_SHARE_INSIDE, POINTS_OF_CASE
    use gracecg_studies_magnetometer_loss, only: field_study_t, study_magnetometer_loss, LOSS_STUDIES, MODEL_FIELD_ERROR
    use gracecg_studies_published_case, only: built_in_case
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_cli_calibration_argument, only: add_cases_option, take_calibrations, MOST_CASES
    use gracecg_cli_arguments, only: arguments_t, refuse_if, MOST_RUNS
    use gracecg_cli_console, only: console_t
    use gracecg_cli_number_text, only: percent_text, fixed_text, decimal_exponent
    use gracecg_files_data_table, only: data_table_t
    use gracecg_files_units, only: unit_of_column
    use gracecg_cli_results, only: results_t, add_format_option, take_format
    implicit none
    private
    public :: declare_verify, run_verify

    character(*), parameter :: DEFAULT_CASES = 'front-1,back-1'
    !> Curves whose names are no words, and what they are
    character(20), parameter :: IN_WORDS(2, 14) = reshape([character(20) :: &
        'srp', 'solar radiation', 'erp', 'Earth radiation', 'non_gravitational', 'non-gravitational', &
        'a_vel', 'offset: rotation', 'a_gg', 'offset: gradient', 'a_acc', 'offset: spin-up', 'a_total', 'offset: total', &
        'torque_aero', 'torque of air', 'torque_solar', 'torque of sunlight', 'torque_gravity', 'gravity torque', &
        'torque_magnetic', 'magnetic torque', 'torque_total', 'total torque', 'omega', 'angular velocity', &
        'omega_dot', 'angular acceleration'], [2, 14])
    integer, parameter :: CASE_WITH_WINDOWS = 1     !! Figures 5.2-5.8 show case 1 of each satellite

contains

    !> Arguments and help of `gracecg verify`.
    subroutine declare_verify(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('verify', '[CASE ...]', 0, MOST_CASES, &
                                'Computes the curves of Figures 5.2-5.8 of CSR-TM-00-01 along '// &
                                'the arcs of the cases (front-1 and back-1 when none is '// &
                                'named). Case 1 of a satellite is compared with the axis '// &
                                'windows that the report prints: a curve is inside when it '// &
                                'leaves its window by at most 5 % of its width; `fill` is the share of the '// &
                                'window that it covers; `ticks` says whether it reaches into the first and the '// &
                                'last interval between the printed tick marks, as a curve does for which a '// &
                                'program chose the axis. A case file with other settings than the built-in case '// &
                                'is compared, too, and named as edited: that measures what the comparison can '// &
                                'see. When no case is named, the points of Figures 6.2, 6.3 and 6.6 are compared as well.', &
                                'gracecg verify front-1 back-1 --out curves')
        call add_cases_option(arguments, 'front-1,back-1')
        call arguments%add_option('--runs', 'N', 'of Figures 6.2, 6.3 and 6.6, for whose points no case may be '// &
                                  'named (default '//integer_text(POINTS_OF_CASE)//', as in the report, and at least that)')
        call arguments%add_option('--seed', 'S', 'of their random numbers (default 1)')
        call arguments%add_option('--threads', 'N', 'for them (default: the processors of the machine)')
        call arguments%add_option('--out', 'DIR', &
                                  'folder for the curves, verify_CASE.csv; made if it is not there')
        call add_format_option(arguments)
    end subroutine declare_verify

    !> The work of `gracecg verify`.
    subroutine run_verify(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_t), allocatable :: calibrations(:)
        type(verification_t) :: verification
        type(results_t) :: results
        type(data_table_t) :: table, curves
        character(:), allocatable :: folder, path
        integer :: i, runs, threads
        integer(i8) :: seed
        logical :: named

        call arguments%get('--out', folder, misuse, default='')
        call arguments%get('--runs', runs, misuse, default=POINTS_OF_CASE, low=POINTS_OF_CASE, high=MOST_RUNS)
        call arguments%get('--seed', seed, misuse, default=1_i8)
        call arguments%get_threads(threads, misuse)
        call take_format(arguments, console, misuse)
        named = arguments%positional_count() > 0 .or. arguments%has('--cases')
        call refuse_if(named .and. arguments%has('--runs'), 'option --runs: it is of Figures 6.2, 6.3 and '// &
                       '6.6, which stay away when a case is named', misuse)
        if (allocated(misuse)) return
        call take_calibrations(arguments, DEFAULT_CASES, calibrations, misuse, error, may_rest=.true.)
        if (allocated(misuse)) return
        if (.not. allocated(error) .and. folder /= '') call make_directory(folder, error)
        if (allocated(error)) return
        call table%columns_of(WINDOW_COLUMNS)
        do i = 1, size(calibrations)
            call tell(console, 'verify: '//trim(calibrations(i)%case%name))
            call verify_case(calibrations(i)%case, verification, error)
            if (allocated(error)) return
            if (i > 1) call console%line('')
            call show(calibrations(i)%case, verification, console)
            call add_rows(calibrations(i)%case, verification, table)
            if (folder == '') cycle
            path = folder//'/'//curves_file_name(calibrations(i)%case%name)
            curves = curves_table(verification)
            call curves%write(path, file_comments('verify', 'case '//trim(calibrations(i)%case%name)//'; body axes'), error)
            if (allocated(error)) return
            call console%line('written: '//path)
        end do
        call results%open('verify')
        if (.not. named) call add_estimates(runs, seed, threads, results, console, error)
        if (allocated(error)) return
        call results%publish(table, console, error)
    end subroutine run_verify

    !> The curves of a case as rows, with the windows of case 1.
    subroutine add_rows(case, verification, table)
        type(case_t), intent(in) :: case
        type(verification_t), intent(in) :: verification
        type(data_table_t), intent(inout) :: table

        integer, parameter :: OF_WINDOWS = 10       ! Columns that other cases leave empty
        integer :: i, curve, axis

        if (case%number == CASE_WITH_WINDOWS) then
            call add_window_rows(case%name, check_windows(trim(case%satellite%name), verification), table)
            return
        end if
        do curve = 1, size(CURVE_NAMES)
            do axis = 1, size(AXES)
                call table%add(case%name)
                call table%add(CURVE_NAMES(curve))
                call table%add(AXES(axis))
                call table%add(unit_of_column(trim(curve_column(CURVE_NAMES(curve), AXES(axis)))))
                associate (values => verification%curve(axis, curve, :))
                    call table%add([minval(values), maxval(values), sum(values)/size(values)])
                end associate
                do i = 1, OF_WINDOWS
                    call table%add_nothing()
                end do
            end do
        end do
    end subroutine add_rows

    subroutine show(case, verification, console)
        type(case_t), intent(in) :: case
        type(verification_t), intent(in) :: verification
        type(console_t), intent(inout) :: console

        character(:), allocatable :: reference
        character(16) :: published

        reference = trim(case%satellite%name)//'-'//integer_text(CASE_WITH_WINDOWS)
        if (case%number /= CASE_WITH_WINDOWS) then
            call show_ranges(trim(case%name), verification, console)
            return
        end if
        call built_in_case(case, published)
        if (published_name(published) == reference) then
            call console%line(trim(case%name)//': curves and the printed axis windows, SI units, body axes')
        else
            call console%line(trim(case%name)//', edited: not the case of the report')
            call console%line('Its curves and the axis windows printed for '//reference//', SI units, body axes')
        end if
        call show_windows(check_windows(trim(case%satellite%name), verification), console)
    end subroutine show

    !> A line for each curve that has a printed window, and the counts.
    subroutine show_windows(checks, console)
        type(window_check_t), intent(in) :: checks(:)
        type(console_t), intent(inout) :: console

        character(6) :: unit
        character(100) :: line
        real(dp) :: scale
        integer :: i

        call console%line('fig quantity            axis unit     from       to    least greatest fill inside   ticks '// &
                          'mean')
        do i = 1, size(checks)
            associate (c => checks(i))
                unit = '1e'//integer_text(decimal_exponent(max(abs(c%low), abs(c%high))))
                scale = 10.0_dp**decimal_exponent(max(abs(c%low), abs(c%high)))
                write (line, '(a4, a21, 2a, 4a9, i4, 5a)') c%figure, padded(curve_words(c%quantity), 21), c%axis//'  ', &
                    padded(unit, 5), column_number(c%low/scale), column_number(c%high/scale), column_number(c%least/scale), &
                    column_number(c%greatest/scale), nint(100*c%fill), '% ', padded(inside_words(c), 10), &
                    yes_or_no(c%on_ticks)//'  ', mean_words(c)
            end associate
            call console%line(trim(line))
        end do
        call show_counts(count_windows(checks), console)
    end subroutine show_windows

    subroutine show_counts(counts, console)
        type(window_counts_t), intent(in) :: counts
        type(console_t), intent(inout) :: console

        call console%line('attitude dynamics alone: '//share_text(counts%attitude_inside, counts%attitude)// &
                          ' inside, '//integer_text(counts%attitude_on_ticks)//' on the ticks; least fill '// &
                          whole_percent(counts%attitude_fill))
        call console%line('surface forces and torques: '//share_text(counts%surface_inside, counts%surface)// &
                          ' inside, '//integer_text(counts%surface_on_ticks)//' on the ticks')
        call console%line('surface forces and torques, mean within 15 % of the window''s centre: '// &
                          share_text(counts%surface_near, counts%surface))
    end subroutine show_counts

    !> The points of Figures 6.2, 6.3 and 6.6, as text and as members of the result.
    subroutine add_estimates(runs, seed, threads, results, console, error)
        integer, intent(in) :: runs, threads
        integer(i8), intent(in) :: seed
        type(results_t), intent(inout) :: results
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(campaign_t) :: campaign
        type(field_study_t) :: losses(LOSS_STUDIES)
        type(data_table_t) :: panels

        call console%expect_parts(2, 'parts')
        call report_campaign(seed, runs, threads, campaign, error, console)
        call console%next_part()
        if (.not. allocated(error)) call study_magnetometer_loss('front', MODEL_FIELD_ERROR, seed, runs, threads, losses, &
                                                                 error, console)
        if (allocated(error)) return
        call console%line('')
        call console%line('Estimates of '//integer_text(runs)//' runs and the printed axis windows of Figures 6.2, 6.3 '// &
                          'and 6.6, mm')
        call console%line('fig satellite algorithm   axis  window from, to     least  greatest fill inside    ticks')
        call show_panels(campaign_windows(campaign, 1), console)
        call show_panels(campaign_windows(campaign, 2), console)
        call show_panels(loss_windows(losses), console)
        call console%line('(inside: points of all runs; the other columns: of the first '//integer_text(POINTS_OF_CASE)// &
                          ', which the figures have)')
        call console%line('')
        call console%line('Figure 6.2: '//estimate_counts_words(count_estimate_windows(campaign_windows(campaign, 1))))
        call console%line('Figure 6.3: '//estimate_counts_words(count_estimate_windows(campaign_windows(campaign, 2))))
        call console%line('Figure 6.6: '//estimate_counts_words(count_estimate_windows(loss_windows(losses))))
        call results%member('runs', runs)
        call results%member('seed', seed)
        panels = estimate_windows_table([campaign_windows(campaign, 1), campaign_windows(campaign, 2), loss_windows(losses)])
        call panels%to_json(results, 'estimates')
    end subroutine add_estimates

    subroutine show_panels(windows, console)
        type(estimate_window_t), intent(in) :: windows(:)
        type(console_t), intent(inout) :: console

        character(100) :: line
        integer :: i

        do i = 1, size(windows)
            associate (w => windows(i))
                write (line, '(a4, a10, a12, a4, 2f8.1, 2f10.3, i5, a, 1x, a11, a)') w%figure, padded(w%satellite, 10), &
                    padded(w%algorithm, 12), padded(w%axis, 4), [w%low, w%high, w%least, w%greatest]/MILLIMETRE, &
                    nint(100*w%fill), '%', padded(share_text(w%inside, w%points), 11), &
                    yes_or_no(w%on_ticks)
            end associate
            call console%line(trim(line))
        end do
    end subroutine show_panels

    !> The counts of a figure of estimates, in words.
    function estimate_counts_words(counts) result(text)
        type(estimate_counts_t), intent(in) :: counts
        character(:), allocatable :: text

        text = percent_text(real(counts%inside, dp)/counts%points)//' of '//integer_text(counts%points)// &
               ' points inside (expected: '//percent_text(LEAST_SHARE_INSIDE)//' or more), '// &
               share_text(counts%on_ticks, counts%panels)//' panels on the ticks'
    end function estimate_counts_words

    !> Whether a curve is inside, in a column of the console.
    function inside_words(check) result(text)
        type(window_check_t), intent(in) :: check
        character(:), allocatable :: text

        text = 'yes'
        if (check%excess > 0) text = pick_text(check%inside, 'yes, ', 'out ')//whole_percent(check%excess)
    end function inside_words

    function mean_words(check) result(text)
        type(window_check_t), intent(in) :: check
        character(:), allocatable :: text

        text = ''
        if (.not. check%attitude_only) text = pick_text(check%near_centre, 'near', 'off')
    end function mean_words

    pure function yes_or_no(condition) result(text)
        logical, intent(in) :: condition
        character(3) :: text

        text = merge('yes', 'no ', condition)
    end function yes_or_no

    function whole_percent(part) result(text)
        real(dp), intent(in) :: part        !! Of 1
        character(:), allocatable :: text

        text = fixed_text(100*part, 0)//' %'
    end function whole_percent

    !> A number of nine columns: with four decimals, where they suffice.
    pure function column_number(value) result(text)
        real(dp), intent(in) :: value
        character(9) :: text

        if (abs(value) < 100) then
            write (text, '(f9.4)') merge(0.0_dp, value, abs(value) < 5e-5_dp)   ! no -0.0000
        else
            write (text, '(es9.1)') value
        end if
    end function column_number

    pure function padded(words, width) result(text)
        character(*), intent(in) :: words
        integer, intent(in) :: width
        character(width) :: text

        text = words
    end function padded

    !> A curve's name in words.
    pure function curve_words(quantity) result(words)
        character(*), intent(in) :: quantity    !! Of CURVE_NAMES
        character(20) :: words

        integer :: place

        place = findloc(IN_WORDS(1, :) == quantity, .true., 1)
        words = quantity
        if (place > 0) words = IN_WORDS(2, place)
    end function curve_words

    !> A line for each curve: its range and mean.
    subroutine show_ranges(name, verification, console)
        character(*), intent(in) :: name
        type(verification_t), intent(in) :: verification
        type(console_t), intent(inout) :: console

        character(80) :: line
        integer :: curve, axis

        call console%line(name//': curves, SI units, body axes')
        call console%line('quantity             axis  least        greatest     mean')
        do curve = 1, size(CURVE_NAMES)
            do axis = 1, size(AXES)
                associate (values => verification%curve(axis, curve, :))
                    write (line, '(a21, a3, 3(es12.4, 1x))') padded(curve_words(CURVE_NAMES(curve)), 21), AXES(axis), &
                        minval(values), maxval(values), sum(values)/size(values)
                end associate
                call console%line(trim(line))
            end do
        end do
    end subroutine show_ranges
end module gracecg_cli_verify
