!> What the chapters of the report page share: the page, the folder of its files, the size of the
!> campaign, what was found, and how figures are drawn.
!>
!> Plain procedures, not bound to the type: gfortran 12 does not reliably read a type with bound procedures
!> that reaches one scope through several modules.
module gracecg_report_book
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t
    use gracecg_text, only: string_t, append
    use gracecg_html, only: html_page_t
    use gracecg_gnuplot, only: draw_figure, NO_GNUPLOT
    implicit none
    private
    public :: report_book_t, finding_t, open_book, book_file, add_figure, add_finding, COMMAND, MILLIMETRE, AXES

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
<<<<<<< HEAD
        integer :: seed = 1, threads = 1
        type(finding_t), allocatable :: findings(:)
        type(string_t), allocatable :: files(:)         !! Names of the CSV files
        type(string_t), allocatable :: figures(:)       !! Names of the figures' scripts
=======
        integer :: seed = 1, threads = 1    !! First seed; in parallel
        type(finding_t), allocatable :: findings(:)    !! In the order of the page
        character(80), allocatable :: files(:)          !! Names of the CSV files
        character(40), allocatable :: figures(:)        !! Names of the figures' scripts
>>>>>>> clean
        integer :: not_drawn = 0                        !! Figures
        character(:), allocatable :: reason             !! Why the first of them is not
        logical :: gnuplot_missing = .false.    !! The page is without figures
        character(:), allocatable :: renderer           !! gnuplot and its version, when a figure is drawn
<<<<<<< HEAD
=======
    contains
        procedure :: open => open_book    !! An empty book
        procedure :: file => file_of_book    !! The path of a CSV file, which is noted for the list of files
        procedure :: draw    !! Draws a figure and puts it on the page
        procedure :: find    !! Notes a line of the summary
>>>>>>> clean
    end type report_book_t

contains

    !> An empty book.
<<<<<<< HEAD
    subroutine open_book(book, folder, runs, seed, threads)
        type(report_book_t), intent(out) :: book
        character(*), intent(in) :: folder
        integer, intent(in) :: runs, seed, threads
=======
    subroutine open_book(self, folder, runs, seed, threads)
        class(report_book_t), intent(out) :: self
        character(*), intent(in) :: folder    !! For the page and its files
        integer, intent(in) :: runs, seed, threads    !! Runs of every Monte Carlo; first seed; in parallel
>>>>>>> clean

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
<<<<<<< HEAD
    function book_file(book, name) result(path)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: name
=======
    function file_of_book(self, name) result(path)
        class(report_book_t), intent(inout) :: self
        character(*), intent(in) :: name    !! Without the folder
>>>>>>> clean
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
<<<<<<< HEAD
=======

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
>>>>>>> clean
end module gracecg_report_book
