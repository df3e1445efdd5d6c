!> Figures of several panels: one gnuplot script for a grid of plots with a common legend, the
!> limits of the report's printed axes dashed where there are some.
module gracecg_cli_panels
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_cli_gnuplot, only: script_head
    implicit none
    private
    public :: panel_t, legend_item_t, grid_t, panel_grid, LINE_WIDTH_OF_POINTS

    integer, parameter :: LETTER = 8            !! Width of a letter of the legend, units of the drawing
    integer, parameter :: LEFT = 78, RIGHT = 14, BOTTOM = 58, LEGEND_ROW = 28, TITLE = 38, GAP_X = 88
    integer, parameter :: GAP_Y = 42, MARK_ROW = 26
    !! Margins and gaps, units of the drawing
    integer, parameter :: SAMPLE = 30           !! Length of a line in the legend
    character(*), parameter :: LINE_WIDTH_OF_POINTS = ' linewidth 1.5'    !! For the command `plot`
    character(1), parameter :: LF = achar(10)

    !> One panel of a figure.
    type :: panel_t
        character(90) :: title = ''     !! Quantity and unit
        character(2000) :: plot = ''     !! What stands behind `plot`, without the printed limits
        character(160) :: settings = '' !! Of this panel alone
        logical :: has_limits = .false. !! The report's axis is known
        real(dp) :: low = 0, high = 0   !! Its limits, in the unit of the plot
        real(dp) :: least = 0, greatest = 0     !! Of what is plotted; when equal, gnuplot chooses the axis
    end type panel_t

    !> A line, or a point (point_type > 0), and what it stands for.
    type :: legend_item_t
        character(48) :: text = ''    !! What it stands for
        integer :: line_type = 0        !! Also the colour of a point; 0: that of the text
        integer :: point_type = 0    !! Of gnuplot; 0: a line
    end type legend_item_t

    !> The figure as a whole.
    type :: grid_t
        integer :: columns = 1    !! Panels side by side
        integer :: width = 560, panel_height = 130
        !! Units of the drawing; so wide, letters have 11 pixels on a phone of 390
        character(40) :: x_label = ''    !! Of the abscissa
        real(dp) :: x_low = 0, x_high = 1    !! Ends of the abscissa, the same for all panels
        character(300) :: settings = ''                 !! Of all panels: tics of x
    end type grid_t

contains

    !> The whole script. Panels fill the grid row after row.
    function panel_grid(name, contents, grid, panels, legend, marks, mark_name, data) result(script)
        character(*), intent(in) :: name, contents      !! As for script_head
        type(grid_t), intent(in) :: grid
        type(panel_t), intent(in) :: panels(:)
        type(legend_item_t), intent(in) :: legend(:)
        real(dp), intent(in), optional :: marks(:)              !! Places on the x axis to be marked
        character(*), intent(in), optional :: mark_name         !! Followed by their numbers
        character(*), intent(in), optional :: data              !! Data blocks of the script's own
        character(:), allocatable :: script

        integer :: rows, height, top, gap, i

        rows = (size(panels) + grid%columns - 1)/grid%columns
        top = LEGEND_ROW*legend_rows(legend, grid%width) + TITLE
        gap = GAP_Y
        if (present(marks)) then
            top = top + MARK_ROW
            gap = gap + MARK_ROW
        end if
        height = top + rows*grid%panel_height + (rows - 1)*gap + BOTTOM
        script = script_head(name, contents, grid%width, height)// &
                 'set xrange ['//real_text(grid%x_low)//':'//real_text(grid%x_high)//']'//LF// &
                 'set title offset 0,'//merge(' 0.4', '-0.9', present(marks))//LF// &
                 'set key noautotitle'//LF//'unset key'//LF
        if (grid%settings /= '') script = script//trim(grid%settings)//LF
        if (present(data)) script = script//data
        script = script//'set multiplot layout '//integer_text(rows)//','//integer_text(grid%columns)// &
                 ' margins '//part(LEFT, grid%width)//','//part(grid%width - RIGHT, grid%width)//','// &
                 part(BOTTOM, height)//','//part(height - top, height)// &
                 ' spacing '//part(GAP_X, grid%width)//','//part(gap, height)//LF// &
                 legend_script(legend, grid%width, height)
        do i = 1, size(panels)
            script = script//LF
            if (present(marks)) script = script//marks_script(marks, mark_name)
            script = script//panel_script(panels(i), grid, i > size(panels) - grid%columns)
            if (i == 1 .or. present(marks)) script = script//'unset label'//LF//'unset arrow'//LF
        end do
        script = script//LF//'unset multiplot'//LF//'set output'//LF
    end function panel_grid

    !> Vertical lines with a name above the panel.
    function marks_script(marks, mark_name) result(script)
        real(dp), intent(in) :: marks(:)
        character(*), intent(in) :: mark_name
        character(:), allocatable :: script

        integer :: i

        script = ''
        do i = 1, size(marks)
            script = script//'set arrow from '//real_text(marks(i))//', graph 0 to '//real_text(marks(i))// &
                     ', graph 1.02 nohead linetype 5'//LF// &
                     'set label "'//mark_name//' '//integer_text(i)//'" at '//real_text(marks(i))// &
                     ', graph 1 offset 0,0.7 '//trim(merge('left  ', 'center', i == 1))//LF
        end do
    end function marks_script

    function panel_script(panel, grid, in_last_row) result(script)
        type(panel_t), intent(in) :: panel
        type(grid_t), intent(in) :: grid
        logical, intent(in) :: in_last_row
        character(:), allocatable :: script

        character(:), allocatable :: low, high

        script = 'set title "'//trim(panel%title)//'"'//LF
        if (panel%greatest > panel%least) script = script//y_axis(panel)
        if (panel%settings /= '') script = script//trim(panel%settings)//LF
        if (in_last_row) then
            script = script//'set format x'//LF//'set xlabel "'//trim(grid%x_label)//'"'//LF
        else
            script = script//'set format x ""'//LF
        end if
        if (.not. panel%has_limits) then
            script = script//'plot '//trim(panel%plot)//LF
            return
        end if
        low = real_text(panel%low)
        high = real_text(panel%high)
        script = script//'set object 1 rectangle from graph 0, first '//low//' to graph 1, first '//high// &
                 ' behind fillcolor rgb band fillstyle solid noborder'//LF// &
                 'plot '//low//' with lines linetype 5, '//high//' with lines linetype 5, \'//LF// &
                 '    '//trim(panel%plot)//LF//'unset object 1'//LF
    end function panel_script

    !> Range and tics that show both the curves and the printed limits, four or five tics.
    function y_axis(panel) result(script)
        type(panel_t), intent(in) :: panel
        character(:), allocatable :: script

        real(dp), parameter :: MARGIN = 0.07_dp, MOST_INTERVALS = 4.6_dp, MANTISSAS(3) = [1.0_dp, 2.0_dp, 5.0_dp]
        real(dp) :: low, high, step, power
        integer :: i

        low = panel%least
        high = panel%greatest
        if (panel%has_limits) then
            low = min(low, panel%low)
            high = max(high, panel%high)
        end if
        power = 10.0_dp**floor(log10((high - low)/MOST_INTERVALS))
        step = 10*power
        do i = size(MANTISSAS), 1, -1
            if ((high - low)/(MANTISSAS(i)*power) <= MOST_INTERVALS) step = MANTISSAS(i)*power
        end do
        script = 'set yrange ['//real_text(low - MARGIN*(high - low))//':'// &
                 real_text(high + MARGIN*(high - low))//']'//LF//'set ytics '//short_text(step)//LF
    end function y_axis

    !> A step without the traces of binary numbers: 0.05, not 0.05000000000000001.
    function short_text(value) result(text)
        real(dp), intent(in) :: value
        character(:), allocatable :: text

        character(12) :: digits

        write (digits, '(es10.2)') value
        text = trim(adjustl(digits))
    end function short_text

    !> The legend on top of the figure, as labels and arrows of the first panel.
    function legend_script(legend, width, height) result(script)
        type(legend_item_t), intent(in) :: legend(:)
        integer, intent(in) :: width, height
        character(:), allocatable :: script

        character(:), allocatable :: y
        integer :: i, x, row

        script = ''
        x = RIGHT
        row = 1
        do i = 1, size(legend)
            if (x > RIGHT .and. x + item_width(legend(i)) > width) then
                x = RIGHT
                row = row + 1
            end if
            y = part(height - LEGEND_ROW*row + LEGEND_ROW/2, height)
            if (legend(i)%point_type > 0) then
                script = script//'set label "" at screen '//part(x + SAMPLE - 10, width)//','//y// &
                         ' point '//colour_of(legend(i))//LINE_WIDTH_OF_POINTS// &
                         ' pointtype '//integer_text(legend(i)%point_type)//' pointsize 0.8'//LF
            else
                script = script//'set arrow from screen '//part(x, width)//','//y//' to screen '// &
                         part(x + SAMPLE, width)//','//y//' nohead '//colour_of(legend(i))//LF
            end if
            script = script//'set label "'//trim(legend(i)%text)//'" at screen '// &
                     part(x + SAMPLE + 6, width)//','//y//LF
            x = x + item_width(legend(i))
        end do
    end function legend_script

    pure function colour_of(item) result(text)
        type(legend_item_t), intent(in) :: item
        character(:), allocatable :: text

        if (item%line_type > 0) then
            text = 'linetype '//integer_text(item%line_type)
        else
            text = 'linecolor rgb ink'
        end if
    end function colour_of

    pure integer function legend_rows(legend, width) result(rows)
        type(legend_item_t), intent(in) :: legend(:)
        integer, intent(in) :: width

        integer :: i, x

        rows = min(1, size(legend))
        x = RIGHT
        do i = 1, size(legend)
            if (x > RIGHT .and. x + item_width(legend(i)) > width) then
                x = RIGHT
                rows = rows + 1
            end if
            x = x + item_width(legend(i))
        end do
    end function legend_rows

    pure integer function item_width(item)
        type(legend_item_t), intent(in) :: item

        item_width = SAMPLE + 6 + LETTER*len_trim(item%text) + 20
    end function item_width

    !> A length as part of a side of the drawing.
    function part(length, side) result(text)
        integer, intent(in) :: length, side
        character(:), allocatable :: text

        character(8) :: digits

        write (digits, '(f8.5)') real(length, dp)/side
        text = trim(adjustl(digits))
    end function part
end module gracecg_cli_panels
