!> Figures of several panels as JSON, for `gracecg.plot.panels`: curves of CSV files beside the page, a common legend, the
!> limits of the report's printed axes where there are some.
module gracecg_cli_panels
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_files_json, only: json_quoted
    implicit none
    private
    public :: panel_t, legend_item_t, grid_t, panel_grid, curve, level, values_curve

    !> One panel of a figure.
    type :: panel_t
        character(90) :: title = ''     !! Quantity and unit
        character(4000) :: curves = ''  !! From `curve`, `level`, `values_curve`, put together by //
        logical :: has_limits = .false. !! The report's axis is known
        real(dp) :: low = 0, high = 0   !! Its limits, in the unit of the plot
        real(dp) :: least = 0, greatest = 0     !! Of what is plotted; when equal, the axis follows the curves
    end type panel_t

    !> A line, or a point (marker not empty), and what it stands for.
    type :: legend_item_t
        character(48) :: text = ''      !! What it stands for
        integer :: colour = 0           !! 1 to 4: blue, orange, green, purple; 5: grey, dashed as a line; 0: that of the text
        character(1) :: marker = ''     !! Of matplotlib; a capital: open
    end type legend_item_t

    !> The figure as a whole.
    type :: grid_t
        integer :: columns = 1          !! Panels side by side
        integer :: panel_height = 130   !! Units of the drawing, of which 560 are its width
        character(40) :: x_label = ''   !! Of the abscissa
        real(dp) :: x_low = 0, x_high = 1       !! Ends of the abscissa, the same for all panels
        real(dp) :: x_step = 0          !! Between its ticks; 0: as it comes
        character(16), allocatable :: x_names(:)        !! In the place of 1, 2, ... on it
        logical :: logarithmic = .false.        !! The ordinates
        real(dp) :: y_low = 0, y_high = 0       !! Ends of all ordinates; when equal, each panel has its own
        real(dp) :: y_step = 0          !! Between their ticks; 0: as it comes
        logical :: from_zero = .false.  !! Ordinates begin at 0
    end type grid_t

contains

    !> The whole figure. Panels fill the grid row after row.
    function panel_grid(grid, panels, legend, marks, mark_name) result(json)
        type(grid_t), intent(in) :: grid
        type(panel_t), intent(in) :: panels(:)
        type(legend_item_t), intent(in) :: legend(:)
        real(dp), intent(in), optional :: marks(:)              !! Places on the x axis to be marked
        character(*), intent(in), optional :: mark_name         !! Followed by their numbers
        character(:), allocatable :: json

        character(:), allocatable :: list
        integer :: i

        json = '{"columns":'//integer_text(grid%columns)//',"panel_height":'//integer_text(grid%panel_height)// &
               ',"x_label":'//json_quoted(trim(grid%x_label))//',"x":'//pair(grid%x_low, grid%x_high)// &
               ',"logarithmic":'//truth(grid%logarithmic)//',"from_zero":'//truth(grid%from_zero)
        if (grid%x_step > 0) json = json//',"x_step":'//real_text(grid%x_step)
        if (grid%y_step > 0) json = json//',"y_step":'//real_text(grid%y_step)
        if (grid%y_high > grid%y_low) json = json//',"y":'//pair(grid%y_low, grid%y_high)
        if (allocated(grid%x_names)) then
            list = ''
            do i = 1, size(grid%x_names)
                list = list//','//json_quoted(trim(grid%x_names(i)))
            end do
            json = json//',"x_names":['//list(2:)//']'
        end if
        if (present(marks)) then
            list = ''
            do i = 1, size(marks)
                list = list//','//real_text(marks(i))
            end do
            json = json//',"marks":['//list(2:)//'],"mark_name":'//json_quoted(mark_name)
        end if
        list = ''
        do i = 1, size(legend)
            list = list//',{"text":'//json_quoted(trim(legend(i)%text))//',"colour":'//integer_text(legend(i)%colour)// &
                   ',"marker":'//json_quoted(trim(legend(i)%marker))//'}'
        end do
        json = json//',"legend":['//list(2:)//'],"panels":['
        do i = 1, size(panels)
            if (i > 1) json = json//','
            json = json//panel_json(panels(i))
        end do
        json = json//']}'
    end function panel_grid

    function panel_json(panel) result(json)
        type(panel_t), intent(in) :: panel
        character(:), allocatable :: json

        json = '{"title":'//json_quoted(trim(panel%title))
        if (panel%has_limits) json = json//',"printed":'//pair(panel%low, panel%high)
        if (panel%greatest > panel%least) json = json//',"range":'//pair(panel%least, panel%greatest)
        json = json//',"curves":['//panel%curves(:max(0, len_trim(panel%curves) - 1))//']}'
    end function panel_json

    !> Columns of a CSV file. A comma stands behind.
    function curve(file, x, y, colour, factor, marker, only, most, shift, error) result(json)
        character(*), intent(in) :: file            !! Beside the page
        character(*), intent(in) :: x               !! Column; empty: 1, 2, ... in the order of the rows
        character(*), intent(in) :: y               !! Column
        integer, intent(in) :: colour               !! As of legend_item_t
        real(dp), intent(in), optional :: factor    !! Of y
        character(*), intent(in), optional :: marker        !! Points in the place of a line; 'bar': bars from 0
        character(*), intent(in), optional :: only
        !! Rows whose columns have these texts: 'case=front-1,algorithm=optimal'
        integer, intent(in), optional :: most       !! Only rows with x up to this
        real(dp), intent(in), optional :: shift     !! Added to x
        character(*), intent(in), optional :: error         !! Column of the standard deviation of y
        character(:), allocatable :: json

        json = '{"file":"'//file//'","x":"'//x//'","y":"'//y//'","colour":'//integer_text(colour)
        if (present(factor)) json = json//',"factor":'//real_text(factor)
        if (present(marker)) json = json//',"marker":"'//marker//'"'
        if (present(only)) json = json//',"only":"'//only//'"'
        if (present(most)) json = json//',"most":'//integer_text(most)
        if (present(shift)) json = json//',"shift":'//real_text(shift)
        if (present(error)) json = json//',"error":"'//error//'"'
        json = json//'},'
    end function curve

    !> Points at 1, 2, ... . A comma stands behind.
    function values_curve(values, colour, marker) result(json)
        real(dp), intent(in) :: values(:)       !! One by one, at 1, 2, ..
        integer, intent(in) :: colour           !! Number of the figure's colours
        character(*), intent(in) :: marker      !! One letter, as matplotlib has it
        character(:), allocatable :: json

        integer :: i

        json = ''
        do i = 1, size(values)
            json = json//','//real_text(values(i))
        end do
        json = '{"values":['//json(2:)//'],"colour":'//integer_text(colour)//',"marker":"'//marker//'"},'
    end function values_curve

    !> A horizontal line. A comma stands behind.
    function level(value, colour) result(json)
        real(dp), intent(in) :: value   !! Where it lies
        integer, intent(in) :: colour   !! Number of the figure's colours
        character(:), allocatable :: json

        json = '{"level":'//real_text(value)//',"colour":'//integer_text(colour)//'},'
    end function level

    function pair(low, high) result(json)
        real(dp), intent(in) :: low, high
        character(:), allocatable :: json

        json = '['//real_text(low)//','//real_text(high)//']'
    end function pair

    pure function truth(value) result(json)
        logical, intent(in) :: value
        character(:), allocatable :: json

        json = trim(merge('true ', 'false', value))
    end function truth
end module gracecg_cli_panels
