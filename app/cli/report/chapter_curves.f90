!> The report page: section 5.3 with Figures 5.2-5.8, the assumptions behind the estimators.
module gracecg_cli_chapter_curves
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text
    use gracecg_studies_curves, only: verification_t, window_check_t, check_windows, window_counts_t, count_windows, &
        write_curves, curves_file_name, curve_column
    use gracecg_studies_window_sensitivity, only: variation_t, write_variations
    use gracecg_cli_verify, only: window_verdict
    use gracecg_cli_document, only: table_rows_t, head_cell, number_cell, text_cell, verdict_cell, &
        VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid, curve
    use gracecg_cli_report_book, only: report_book_t, book_file, add_figure, add_claim, COMMAND, SATELLITES
    use gracecg_cli_number_text, only: scaled_text, decimal_exponent, share_text, pick_text, percent_text, &
        fixed_text
    implicit none
    private
    public :: add_curves_chapter


    !> A figure of the report.
    type :: figure_t
        character(4) :: number = ''
        character(80) :: caption = ''       !! As printed
        character(160) :: shows = ''        !! What the report sees in it
    end type figure_t

    type(figure_t), parameter :: FIGURES(7) = [ &
        figure_t('5.2', 'Non-gravitational acceleration of front GRACE', &
                 'It can be fitted by straight lines, although not perfectly; short-period density '// &
                 'perturbations bend it.'), &
        figure_t('5.3', 'Non-gravitational acceleration of back GRACE', &
                 'The same for the back satellite, which flies turned by 180 deg about the vertical.'), &
        figure_t('5.4', 'Disturbance accelerations of front GRACE due to CG offset', &
                 'a_{acc}, by the angular acceleration, dominates; the gravity gradient a_{gg} is '// &
                 'nearly a straight line.'), &
        figure_t('5.5', 'Disturbance accelerations of back GRACE due to CG offset', &
                 'The same for the back satellite.'), &
        figure_t('5.6', 'External torques of front GRACE', &
                 'The magnetic torque dominates the sum of the torques.'), &
        figure_t('5.7', 'External torques of back GRACE', &
                 'The same for the back satellite.'), &
        figure_t('5.8', 'Angular velocity and acceleration of front (top) and back GRACE (bottom)', &
                 'No rotation exceeds 0.1 deg/s about any axis, so the star cameras see well.')]

contains

    !> Adds the chapter with the curves of case 1 of each satellite.
    subroutine add_curves_chapter(book, verifications, variations, error)
        type(report_book_t), intent(inout) :: book
        type(verification_t), intent(in) :: verifications(2)    !! Front, back
        type(variation_t), intent(in) :: variations(:)          !! What the comparison can see
        type(error_t), allocatable, intent(out) :: error

        type(window_check_t), allocatable :: checks(:)
        integer, allocatable :: satellite(:)            !! Of each check, place in SATELLITES
        character(:), allocatable :: name
        integer :: i

        allocate (checks(0), satellite(0))
        do i = 1, size(SATELLITES)
            name = trim(SATELLITES(i))//'-1'
            call write_curves(book_file(book, curves_file_name(name)), COMMAND, name, verifications(i), error)
            if (allocated(error)) return
            checks = [checks, check_windows(trim(SATELLITES(i)), verifications(i))]
            satellite = [satellite, spread(i, 1, size(checks) - size(satellite))]
        end do

        call book%page%chapter('curves', 'The assumptions behind the estimators: Figures 5.2 to 5.8')
        call book%page%paragraph('Case 1 of each satellite over its 60 s, without noise, body axes. '// &
                                 'Blue: this program. Grey: the range of the printed axis, all that is '// &
                                 'left of the report''s curves. A curve is inside when it leaves that range by at '// &
                                 'most 5 % of its width. A plotting program that chooses an axis ends it at '// &
                                 'the tick marks next outside the curve: so the curve must also reach into '// &
                                 'the first and the last interval between the printed marks (on the ticks). '// &
                                 'Fill is the share of the axis that the curve covers. Curves that depend '// &
                                 'on the attitude dynamics alone follow from the report''s numbers; for drag, radiation and '// &
                                 'surface torques several inputs of the report cannot be had, so for '// &
                                 'them the mean is judged too (within 15 % of the middle of the axis).')
        call add_verdict(book, checks)
        call add_sensitivity(book, variations, error)
        if (allocated(error)) return
        do i = 1, size(FIGURES)
            associate (these => checks%figure == FIGURES(i)%number)
                call add_curves_figure(book, FIGURES(i), pack(checks, these), SATELLITES(pack(satellite, these)))
            end associate
        end do
    end subroutine add_curves_chapter

    !> The counts over all figures.
    subroutine add_verdict(book, checks)
        type(report_book_t), intent(inout) :: book
        type(window_check_t), intent(in) :: checks(:)

        type(window_counts_t) :: counts
        character(:), allocatable :: inside, surface
        integer :: kind

        counts = count_windows(checks)
        inside = share_text(counts%attitude_inside, counts%attitude)//' inside, '// &
                 share_text(counts%attitude_on_ticks, counts%attitude)//' on the ticks'
        surface = share_text(counts%surface_inside, counts%surface)//' inside, '// &
                  share_text(counts%surface_near, counts%surface)//' with the mean within 15 %'
        kind = VERDICT_MET
        if (counts%attitude_on_ticks < counts%attitude) kind = VERDICT_PARTLY
        if (counts%attitude_inside < counts%attitude) kind = VERDICT_MISSED
        call book%page%verdict(kind, 'Attitude dynamics: '//inside//'.', 'Accelerations by the offset, gravity, '// &
                               'magnetic and total torque, angular velocity and acceleration. The curve that covers '// &
                               'least covers '//percent_text(counts%attitude_fill)//' of its axis; the finest step of '// &
                               '1, 2, 5 that needs at most 4 intervals, the rule of most printed axes, gives the '// &
                               'printed limits for '//integer_text(counts%attitude_automatic)//'.')
        call add_claim(book, 'Figures 5.4 to 5.8', 'figure_5_4', 'curves of the attitude dynamics lie within their '// &
                       'printed axes, and reach to their end intervals', inside, kind, verdict_words(kind))
        kind = VERDICT_MET
        if (counts%surface_inside < counts%surface) &
            kind = merge(VERDICT_PARTLY, VERDICT_MISSED, counts%surface_near >= 0.8*counts%surface)
        call book%page%verdict(kind, 'Surface forces and torques: '//surface//'.', 'Each of the others is listed '// &
                               'below its figure.')
        call add_claim(book, 'Figures 5.2, 5.3, 5.6, 5.7', 'figure_5_2', 'drag, radiation pressure and surface '// &
                       'torques lie within their printed axes', surface, kind, verdict_words(kind))
    end subroutine add_verdict

    !> What the comparison can see, and what it cannot.
    subroutine add_sensitivity(book, variations, error)
        type(report_book_t), intent(inout) :: book
        type(variation_t), intent(in) :: variations(:)  !! The first is the case as it is
        type(error_t), allocatable, intent(out) :: error

        type(table_rows_t) :: rows
        integer :: i, seen_inside, seen_on_ticks

        call write_variations(book_file(book, 'window_sensitivity.csv'), COMMAND, variations, error)
        if (allocated(error)) return
        do i = 1, size(variations)
            associate (c => variations(i)%counts)
                call rows%add(head_cell(trim(variations(i)%name))//number_cell(share_text(c%attitude_inside, c%attitude))// &
                              number_cell(share_text(c%attitude_on_ticks, c%attitude))// &
                              number_cell(share_text(c%attitude_automatic, c%attitude))// &
                              number_cell(percent_text(c%attitude_fill)))
            end associate
        end do
        associate (counts => variations%counts)
            seen_inside = count(counts%attitude_inside < counts(1)%attitude_inside)
            seen_on_ticks = count(counts%attitude_on_ticks < counts(1)%attitude_on_ticks)
        end associate
        call book%page%heading('What this comparison can see')
        call book%page%paragraph('The same windows with one setting changed at a time, both satellites. Of '// &
                                 integer_text(size(variations) - 1)//' changes, being inside alone tells '// &
                                 integer_text(seen_inside)//' from the report''s settings, the ticks tell '// &
                                 integer_text(seen_on_ticks)//': a curve that is too small stays inside.')
        call book%page%table('Windows of the attitude dynamics that are met', [character(16) :: 'change', 'inside', &
                             'on the ticks', 'by the rule', 'least fill'], rows, 'window_sensitivity')
    end subroutine add_sensitivity

    pure function verdict_words(kind) result(words)
        integer, intent(in) :: kind
        character(:), allocatable :: words

        select case (kind)
        case (VERDICT_MET)
            words = 'agrees'
        case (VERDICT_PARTLY)
            words = 'agrees in most'
        case default
            words = 'differs'
        end select
    end function verdict_words

    !> One figure, and the numbers of its panels.
    subroutine add_curves_figure(book, figure, checks, satellite)
        type(report_book_t), intent(inout) :: book
        type(figure_t), intent(in) :: figure
        type(window_check_t), intent(in) :: checks(:)
        character(5), intent(in) :: satellite(:)

        character(13), parameter :: HEADS(10) = [character(13) :: 'quantity', 'axis', 'unit', 'printed from', 'to', &
                                                 'least', 'greatest', 'mean', 'fill', 'verdict']
        type(table_rows_t) :: rows
        character(:), allocatable :: name, caption, cells
        logical :: both
        integer :: i, exponent

        name = 'figure_5_'//figure%number(3:3)
        caption = 'Figure '//trim(figure%number)//'. '//trim(figure%caption)//'.'
        both = any(satellite /= satellite(1))
        call book%page%heading(caption(:len(caption) - 1))
        call book%page%paragraph('What the report sees in it: '//trim(figure%shows))
        call add_figure(book, name, script_of(checks, satellite), caption//' Blue: this program. Grey '// &
                        'band between dashed lines: the printed axis.', 'Figure '//trim(figure%number), &
                        integer_text(size(checks))//' panels of curves over 60 s, each with the range of the printed '// &
                        'axis; the table that follows has their numbers.')
        do i = 1, size(checks)
            associate (c => checks(i))
                exponent = exponent_of(c)
                cells = pick_text(both, head_cell(trim(satellite(i))), '')//head_cell(quantity_name(c%quantity))// &
                        text_cell(c%axis)//text_cell('10^{'//integer_text(exponent)//'} '//html_unit(c%quantity))
                cells = cells//number_cell(scaled_text(c%low, exponent, 4))//number_cell(scaled_text(c%high, exponent, 4))
                cells = cells//number_cell(scaled_text(c%least, exponent, 4))// &
                        number_cell(scaled_text(c%greatest, exponent, 4))//number_cell(scaled_text(c%mean, exponent, 4))
                call rows%add(cells//number_cell(fixed_text(100*c%fill, 0)//' %')//verdict_cell(kind_of(c), window_verdict(c)))
            end associate
        end do
        caption = 'Figure '//trim(figure%number)//': curves and printed axes'
        if (both) then
            call book%page%table(caption, [character(13) :: 'satellite', HEADS], rows, name//'_numbers')
        else
            call book%page%table(caption, HEADS, rows, name//'_numbers')
        end if
    end subroutine add_curves_figure

    pure integer function kind_of(check) result(kind)
        type(window_check_t), intent(in) :: check

        kind = VERDICT_MISSED
        if (check%inside .and. merge(check%on_ticks, check%near_centre, check%attitude_only)) then
            kind = VERDICT_MET
        else if (check%inside .or. (.not. check%attitude_only .and. check%near_centre)) then
            kind = VERDICT_PARTLY
        end if
    end function kind_of

    !> The printed panels stand side by side, x, y and z below each other; here two quantities do.
    function script_of(checks, satellite) result(script)
        type(window_check_t), intent(in) :: checks(:)   !! In the order quantity, axis
        character(5), intent(in) :: satellite(:)
        character(:), allocatable :: script

        type(panel_t) :: panels(size(checks))
        type(legend_item_t) :: legend(2)
        type(grid_t) :: grid
        integer :: i, place

        grid%columns = 2
        grid%x_label = 'time, s'
        grid%x_high = 60
        grid%x_step = 20
        do i = 1, size(checks)
            ! quantity q = 2 row block, column; axis a: row
            place = 6*((i - 1)/6) + 2*mod(i - 1, 3) + 1 + mod((i - 1)/3, 2)
            if (i > 6*(size(checks)/6)) place = i       ! a quantity that is left over: as it comes
            panels(place) = panel_of(checks(i), satellite(i), any(satellite /= satellite(1)))
        end do
        legend(1) = legend_item_t('gracecg', 1)
        legend(2) = legend_item_t('printed axis', 5)
        script = panel_grid(grid, panels, legend)
    end function script_of

    function panel_of(check, satellite, both) result(panel)
        type(window_check_t), intent(in) :: check
        character(*), intent(in) :: satellite
        logical, intent(in) :: both                     !! Satellites are in the figure
        type(panel_t) :: panel

        integer :: exponent

        exponent = exponent_of(check)
        panel%title = quantity_name(check%quantity)//' '//check%axis//', 10^{'//integer_text(exponent)//'} '// &
                      plot_unit(check%quantity)
        if (both) panel%title = trim(satellite)//' '//symbol(check%quantity, check%axis)//', 10^{'// &
                                integer_text(exponent)//'} '//plot_unit(check%quantity)
        panel%curves = curve(curves_file_name(trim(satellite)//'-1'), 'time_s', &
                             trim(curve_column(check%quantity, check%axis)), 1, 10.0_dp**(-exponent))
        panel%has_limits = .true.
        panel%low = check%low*10.0_dp**(-exponent)
        panel%high = check%high*10.0_dp**(-exponent)
        panel%least = check%least*10.0_dp**(-exponent)
        panel%greatest = check%greatest*10.0_dp**(-exponent)
    end function panel_of

    pure integer function exponent_of(check)
        type(window_check_t), intent(in) :: check

        exponent_of = decimal_exponent(max(abs(check%low), abs(check%high)))
    end function exponent_of

    pure function quantity_name(quantity) result(name)
        character(*), intent(in) :: quantity        !! Of CURVE_NAMES
        character(:), allocatable :: name

        select case (quantity)
        case ('srp')
            name = 'solar radiation'
        case ('erp')
            name = 'Earth radiation'
        case ('non_gravitational')
            name = 'non-gravitational'
        case ('a_vel', 'a_gg', 'a_acc', 'a_total')
            name = 'a_{'//trim(quantity(3:))//'}'
        case ('torque_aero')
            name = 'aerodynamic torque'
        case ('torque_solar')
            name = 'solar torque'
        case ('torque_gravity')
            name = 'gravity torque'
        case ('torque_magnetic')
            name = 'magnetic torque'
        case ('torque_total')
            name = 'total torque'
        case ('omega')
            name = 'angular velocity'
        case ('omega_dot')
            name = 'angular acceleration'
        case default
            name = trim(quantity)
        end select
    end function quantity_name

    !> omega_x or d omega_x/dt, for a narrow title.
    pure function symbol(quantity, axis) result(name)
        character(*), intent(in) :: quantity, axis
        character(:), allocatable :: name

        character(*), parameter :: GREEK_OMEGA = char(207)//char(137)     ! UTF-8

        select case (quantity)
        case ('omega')
            name = GREEK_OMEGA//'_'//axis
        case ('omega_dot')
            name = 'd'//GREEK_OMEGA//'_'//axis//'/dt'
        case default
            name = quantity_name(quantity)//' '//axis
        end select
    end function symbol

    pure function plot_unit(quantity) result(unit)
        character(*), intent(in) :: quantity
        character(:), allocatable :: unit

        if (index(quantity, 'torque') == 1) then
            unit = 'N m'
        else if (quantity == 'omega') then
            unit = 'rad/s'
        else if (quantity == 'omega_dot') then
            unit = 'rad/s^2'
        else
            unit = 'm/s^2'
        end if
    end function plot_unit

    pure function html_unit(quantity) result(unit)
        character(*), intent(in) :: quantity
        character(:), allocatable :: unit

        unit = plot_unit(quantity)
        if (unit(len(unit):) == '2') unit = unit(:len(unit) - 1)//'{2}'
    end function html_unit
end module gracecg_cli_chapter_curves
