!> A page with the folder behind it: the CSV files, and the figures with the scripts that draw them.
!>
!> Plain procedures, not bound to the type: gfortran 12 does not reliably read a type with bound procedures
!> that reaches one scope through several modules.
module gracecg_cli_book
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, append
    use gracecg_cli_html, only: html_page_t
    use gracecg_cli_gnuplot, only: draw_figure
    implicit none
    private
    public :: book_t, open_book, book_file, add_figure

    !> The page with its files, as it grows.
    type :: book_t
        type(html_page_t) :: page                       !! The chapters so far
        character(:), allocatable :: folder             !! Of the files; exists
        type(string_t), allocatable :: files(:)         !! Names of the CSV files
        type(string_t), allocatable :: figures(:)       !! Names of the figures' scripts
        type(string_t), allocatable :: reasons(:)       !! Why figures are not drawn, each once
        integer :: not_drawn = 0                        !! Figures
        character(:), allocatable :: renderer           !! gnuplot and its version, when a figure is drawn
    end type book_t

contains

    !> An empty book.
    subroutine open_book(book, folder)
        class(book_t), intent(inout) :: book
        character(*), intent(in) :: folder              !! For its files

        book%folder = folder
        allocate (book%files(0), book%figures(0), book%reasons(0))
        book%renderer = ''
        call book%page%begin('', '')
    end subroutine open_book

    !> The path of a CSV file, which is noted for the list of files.
    function book_file(book, name) result(path)
        class(book_t), intent(inout) :: book
        character(*), intent(in) :: name                !! Without the folder
        character(:), allocatable :: path

        call append(book%files, name)
        path = book%folder//'/'//name
    end function book_file

    !> Draws a figure and puts it on the page; where it cannot be drawn, the page says so. Fails when a file
    !> cannot be written.
    subroutine add_figure(book, name, script, caption, title, description, error)
        class(book_t), intent(inout) :: book
        character(*), intent(in) :: name                !! figure_5_2: of its files, and its id
        character(*), intent(in) :: script              !! For gnuplot, text
        character(*), intent(in) :: caption, title, description
        !! Below the figure; name and description for who does not see it
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: svg, reason
        integer :: i

        call append(book%figures, name)
        call draw_figure(book%folder, name, script, svg, reason, error)
        if (allocated(error)) return
        if (reason == '') then
            if (book%renderer == '') book%renderer = renderer_of(svg)
            call book%page%figure(name, svg, caption, title, description)
            return
        end if
        book%not_drawn = book%not_drawn + 1
        call book%page%missing_figure(name, reason, caption)
        do i = 1, size(book%reasons)
            if (book%reasons(i)%text == reason) return
        end do
        call append(book%reasons, reason)
    end subroutine add_figure

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
