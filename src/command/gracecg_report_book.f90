!> What the chapters of the report page share: the page, the folder of its files, the size of the
!> campaign, what was found, and how figures are drawn.
module gracecg_report_book
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t
    use gracecg_text, only: integer_text
    use gracecg_html, only: html_page_t
    use gracecg_gnuplot, only: draw_figure, NO_GNUPLOT
    implicit none
    private
    public :: report_book_t, finding_t, fixed_text, scaled_text, decimal_exponent, percent_text, share_text, &
        pick_text, &
        COMMAND, MILLIMETRE, AXES

    character(*), parameter :: COMMAND = 'report'    !! Its name, for messages
    real(dp), parameter :: MILLIMETRE = 1e-3_dp         !! m
    character(1), parameter :: AXES(3) = ['x', 'y', 'z']    !! Names of the body axes

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
        integer :: seed = 1, threads = 1    !! First seed; in parallel
        type(finding_t), allocatable :: findings(:)    !! In the order of the page
        character(80), allocatable :: files(:)          !! Names of the CSV files
        character(40), allocatable :: figures(:)        !! Names of the figures' scripts
        integer :: not_drawn = 0                        !! Figures
        character(:), allocatable :: reason             !! Why the first of them is not
        logical :: gnuplot_missing = .false.    !! The page is without figures
        character(:), allocatable :: renderer           !! gnuplot and its version, when a figure is drawn
    contains
        procedure :: open => open_book    !! An empty book
        procedure :: file => file_of_book    !! The path of a CSV file, which is noted for the list of files
        procedure :: draw    !! Draws a figure and puts it on the page
        procedure :: find    !! Notes a line of the summary
    end type report_book_t

contains

    !> An empty book.
    subroutine open_book(self, folder, runs, seed, threads)
        class(report_book_t), intent(out) :: self
        character(*), intent(in) :: folder    !! For the page and its files
        integer, intent(in) :: runs, seed, threads    !! Runs of every Monte Carlo; first seed; in parallel

        self%folder = folder
        self%runs = runs
        self%seed = seed
        self%threads = threads
        allocate (self%findings(0), self%files(0), self%figures(0))
        self%reason = ''
        self%renderer = ''
        call self%page%begin('', '')
    end subroutine open_book

    !> The path of a CSV file, which is noted for the list of files.
    function file_of_book(self, name) result(path)
        class(report_book_t), intent(inout) :: self
        character(*), intent(in) :: name    !! Without the folder
        character(:), allocatable :: path

        character(len(self%files)) :: noted

        noted = name
        self%files = [self%files, noted]
        path = self%folder//'/'//name
    end function file_of_book

    !> Draws a figure and puts it on the page; where it cannot be drawn, the page says so. Fails when a file
    !> cannot be written.
    subroutine draw(self, name, script, caption, title, description, error)
        class(report_book_t), intent(inout) :: self
        character(*), intent(in) :: name                !! figure_5_2: of its files, and its id
        character(*), intent(in) :: script    !! For gnuplot, text
        character(*), intent(in) :: caption, title, description
        !! Below the figure; name and description for who does not see it
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: svg, reason
        character(len(self%figures)) :: noted

        noted = name
        self%figures = [self%figures, noted]
        call draw_figure(self%folder, name, script, svg, reason, error)
        if (allocated(error)) return
        if (reason == '') then
            if (self%renderer == '') self%renderer = renderer_of(svg)
            call self%page%figure(name, svg, caption, title, description)
            return
        end if
        self%not_drawn = self%not_drawn + 1
        if (self%reason == '') self%reason = reason
        self%gnuplot_missing = self%gnuplot_missing .or. reason == NO_GNUPLOT
        call self%page%missing_figure(name, reason, caption)
    end subroutine draw

    !> Notes a line of the summary.
    subroutine find(self, source, anchor, claim, result, kind, verdict)
        class(report_book_t), intent(inout) :: self
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
        self%findings = [self%findings, found]
    end subroutine find

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

    !> A number with a fixed count of decimals, 0 before the point.
    function fixed_text(value, decimals) result(text)
        real(dp), intent(in) :: value    !! Any
        integer, intent(in) :: decimals    !! Behind the point
        character(:), allocatable :: text

        character(40) :: digits
        character(12) :: form

        write (form, '(a, i0, a)') '(f40.', decimals, ')'
        write (digits, form) value
        text = trim(adjustl(digits))
        if (decimals == 0) text = text(:len(text) - 1)
        if (text(1:1) == '.') text = '0'//text
        if (index(text, '-.') == 1) text = '-0'//text(2:)
        if (text(1:1) == '-' .and. verify(text, '-0.') == 0) text = text(2:)
    end function fixed_text

    !> A number without its power of ten.
    function scaled_text(value, exponent, decimals) result(text)
        real(dp), intent(in) :: value    !! Any
        integer, intent(in) :: exponent, decimals    !! Power of ten taken out; digits behind the point
        character(:), allocatable :: text

        text = fixed_text(value/10.0_dp**exponent, decimals)
    end function scaled_text

    !> The power of ten of a number: floor(log10(abs(value))), 0 for 0.
    pure integer function decimal_exponent(value) result(exponent)
        real(dp), intent(in) :: value    !! Any but 0

        exponent = 0
        if (abs(value) > 0) exponent = floor(log10(abs(value)*(1 + 1e-12_dp)))
    end function decimal_exponent

    !> One of two texts.
    pure function pick_text(condition, if_true, if_false) result(text)
        logical, intent(in) :: condition    !! Which of the two
        character(*), intent(in) :: if_true, if_false    !! The two
        character(:), allocatable :: text

        if (condition) then
            text = if_true
        else
            text = if_false
        end if
    end function pick_text

    !> A part of 1 as '12.3 %'.
    function percent_text(part) result(text)
        real(dp), intent(in) :: part    !! Of 1
        character(:), allocatable :: text

        text = fixed_text(100*part, 1)//' %'
    end function percent_text

    !> Counts as '3 of 4'.
    function share_text(part, whole) result(text)
        integer, intent(in) :: part, whole    !! Counts
        character(:), allocatable :: text

        text = integer_text(part)//' of '//integer_text(whole)
    end function share_text
end module gracecg_report_book
