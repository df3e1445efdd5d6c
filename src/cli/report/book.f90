!> What the chapters of the report page share: the page, the folder of its files, the size of the
!> campaign, what was found, and how figures are drawn.
!>
!> Plain procedures, not bound to the type: gfortran 12 does not reliably read a type with bound procedures
!> that reaches one scope through several modules.
module gracecg_cli_book
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_cli_html, only: html_page_t
    use gracecg_cli_gnuplot, only: draw_figure, NO_GNUPLOT
    use gracecg_cli_number_text, only: fixed_text
    implicit none
    private
    public :: report_book_t, finding_t, open_book, book_file, add_figure, add_finding, COMMAND
    public :: begin_rms_table, rms_cells

    character(*), parameter :: COMMAND = 'report'    !! Its name, for messages

    !> One line of the summary.
    type :: finding_t
        character(32) :: source = ''        !! Of the report: 'Figure 5.2'
        character(24) :: anchor = ''        !! Id of the chapter, table or figure on the page
        character(200) :: claim = ''        !! What the report shows
        character(200) :: result = ''       !! What is found here
        integer :: kind = 0                 !! VERDICT_...
        character(24) :: verdict = ''       !! In words
    end type finding_t

    !> The page with its files, as it grows.
    type :: report_book_t
        type(html_page_t) :: page                       !! The chapters so far
        character(:), allocatable :: folder             !! Exists
        integer :: runs = 0                             !! Of every Monte Carlo
        integer :: seed = 1, threads = 1                !! First seed of all Monte Carlos; threads to work on
        type(finding_t), allocatable :: findings(:)     !! In the order of the page
        type(string_t), allocatable :: files(:)         !! Names of the CSV files
        type(string_t), allocatable :: figures(:)       !! Names of the figures' scripts
        integer :: not_drawn = 0                        !! Figures
        character(:), allocatable :: reason             !! Why the first of them is not
        logical :: gnuplot_missing = .false.    !! The page is without figures
        character(:), allocatable :: renderer           !! gnuplot and its version, when a figure is drawn
    end type report_book_t

contains

    !> An empty book.
    subroutine open_book(book, folder, runs, seed, threads)
        type(report_book_t), intent(out) :: book
        character(*), intent(in) :: folder          !! For the page and its files
        integer, intent(in) :: runs, seed, threads  !! Runs of every Monte Carlo; first seed; in parallel

        book%folder = folder
        book%runs = runs
        book%seed = seed
        book%threads = threads
        allocate (book%findings(0), book%files(0), book%figures(0))
        book%reason = ''
        book%renderer = ''
        call book%page%begin('', '')
    end subroutine open_book

    !> The path of a CSV file, which is noted for the list of files.
    function book_file(book, name) result(path)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: name            !! Without the folder
        character(:), allocatable :: path

        call append(book%files, name)
        path = book%folder//'/'//name
    end function book_file

    !> Draws a figure and puts it on the page; where it cannot be drawn, the page says so. Fails when a file
    !> cannot be written.
    subroutine add_figure(book, name, script, caption, title, description, error)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: name                !! figure_5_2: of its files, and its id
        character(*), intent(in) :: script    !! For gnuplot, text
        character(*), intent(in) :: caption, title, description
        !! Below the figure; name and description for who does not see it
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: svg, reason

        call append(book%figures, name)
        call draw_figure(book%folder, name, script, svg, reason, error)
        if (allocated(error)) return
        if (reason == '') then
            if (book%renderer == '') book%renderer = renderer_of(svg)
            call book%page%figure(name, svg, caption, title, description)
            return
        end if
        book%not_drawn = book%not_drawn + 1
        if (book%reason == '') book%reason = reason
        book%gnuplot_missing = book%gnuplot_missing .or. reason == NO_GNUPLOT
        call book%page%missing_figure(name, reason, caption)
    end subroutine add_figure

    !> Notes a line of the summary.
    subroutine add_finding(book, source, anchor, claim, result, kind, verdict)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: source, anchor, claim, result
        !! Where the claim stands; anchor of the chapter; the claim; what was found
        integer, intent(in) :: kind    !! Of the verdict
        character(*), intent(in) :: verdict    !! In words

        type(finding_t) :: found

        found%source = source
        found%anchor = anchor
        found%claim = claim
        found%result = result
        found%kind = kind
        found%verdict = verdict
        book%findings = [book%findings, found]
    end subroutine add_finding

    !> Begins a table of RMS errors beside theory: head and columns; rows and the table's end are the chapter's.
    subroutine begin_rms_table(book, anchor, columns)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: anchor          !! Id of the table on the page
        character(*), intent(in) :: columns(:)      !! Heads of the columns before the errors

        integer :: i

        call book%page%begin_table('RMS errors of the CG offset, mm: '//integer_text(book%runs)//' runs and theory', anchor)
        call book%page%begin_row()
        do i = 1, size(columns)
            call book%page%column_head(trim(columns(i)))
        end do
        do i = 1, 3
            call book%page%column_head(AXES(i)//' here', numeric=.true.)
            call book%page%column_head(AXES(i)//' theory', numeric=.true.)
        end do
        call book%page%end_row()
        call book%page%head_end()
    end subroutine begin_rms_table

    !> The errors of a row of such a table, and the row's end.
    subroutine rms_cells(book, rms, predicted)
        type(report_book_t), intent(inout) :: book
        real(dp), intent(in) :: rms(3)              !! x, y, z, m
        real(dp), intent(in) :: predicted(3)        !! By theory, m

        integer :: axis

        do axis = 1, 3
            call book%page%number_cell(fixed_text(rms(axis)/MILLIMETRE, 5))
            call book%page%number_cell(fixed_text(predicted(axis)/MILLIMETRE, 5))
        end do
        call book%page%end_row()
    end subroutine rms_cells

    !> Who drew an SVG file, as it says itself: 'gnuplot 5.4 patchlevel 4'.
    pure function renderer_of(svg) result(name)
        character(*), intent(in) :: svg
        character(:), allocatable :: name

        character(*), parameter :: SIGN = 'Produced by GNUPLOT'
        integer :: first, length

        name = 'gnuplot'
        first = index(svg, SIGN)
        if (first == 0) return
        length = index(svg(first:), '</') - 1
        if (length > len(SIGN)) name = 'gnuplot'//trim(svg(first + len(SIGN):first + length - 1))
    end function renderer_of
end module gracecg_cli_book
