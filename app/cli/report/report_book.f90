!> What the chapters of the report share: the book, the size of the campaign, and the summary as it grows.
module gracecg_cli_report_book
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: AXES, MILLIMETRE
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_cli_document, only: document_t, table_rows_t, number_cells
    implicit none
    private
    public :: report_book_t, claim_t, open_book, book_file, add_figure, add_claim, add_rms_table, rms_cells, COMMAND, SATELLITES

    character(*), parameter :: COMMAND = 'report'       !! Its name, for messages
    !> Of the pair
    character(5), parameter :: SATELLITES(2) = [character(5) :: 'front', 'back']

    !> One line of the summary: what the report shows, and what is found here.
    type :: claim_t
        character(32) :: source = ''        !! Of the report: 'Figure 5.2'
        character(24) :: anchor = ''        !! Id of the chapter, table or figure on the page
        character(200) :: claim = ''        !! What the report shows
        character(200) :: result = ''       !! What is found here
        integer :: kind = 0                 !! VERDICT_...
        character(24) :: verdict = ''       !! In words
    end type claim_t

    !> The report as it grows.
    type :: report_book_t
        type(document_t) :: page                    !! The chapters so far
        character(:), allocatable :: folder         !! Of page and files; exists
        type(string_t), allocatable :: files(:)     !! Names of the CSV files
        integer :: figures = 0                      !! Made of panels
        integer :: runs = 0                         !! Of every Monte Carlo
        integer(i8) :: seed = 1                         !! First seed of all Monte Carlos
        type(claim_t), allocatable :: claims(:)     !! In the order of the page
    end type report_book_t

contains

    !> An empty book.
    subroutine open_book(book, folder)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: folder              !! For its files

        book%folder = folder
        allocate (book%files(0), book%claims(0))
    end subroutine open_book

    !> The path of a CSV file, which is noted for the list of files.
    function book_file(book, name) result(path)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: name                !! Without the folder
        character(:), allocatable :: path

        call append(book%files, name)
        path = book%folder//'/'//name
    end function book_file

    !> A figure of panels.
    subroutine add_figure(book, name, panels, caption, title, description)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: name                !! figure_5_2: its id, and that of its file
        character(*), intent(in) :: panels              !! By panel_grid
        character(*), intent(in) :: caption, title, description
        !! Below the figure; name and description for who does not see it

        book%figures = book%figures + 1
        call book%page%figure(name, panels, caption, title, description)
    end subroutine add_figure

    !> Notes a line of the summary.
    subroutine add_claim(book, source, anchor, claim, result, kind, verdict)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: source, anchor, claim, result
        !! Where the claim stands; anchor of the chapter; the claim; what was found
        integer, intent(in) :: kind             !! Of the verdict
        character(*), intent(in) :: verdict     !! In words

        type(claim_t) :: found

        found = claim_t(source, anchor, claim, result, kind, verdict)
        book%claims = [book%claims, found]
    end subroutine add_claim

    !> A table of RMS errors beside theory.
    subroutine add_rms_table(book, of_what, anchor, columns, rows)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: of_what         !! 'Figure 6.5'
        character(*), intent(in) :: anchor          !! Id of the table on the page
        character(*), intent(in) :: columns(:)      !! Heads of the columns before the errors
        type(table_rows_t), intent(in) :: rows      !! Each ends with rms_cells

        character(16) :: heads(size(columns) + 6)
        integer :: i

        heads(:size(columns)) = columns
        do i = 1, 3
            heads(size(columns) + 2*i - 1) = AXES(i)//' here'
            heads(size(columns) + 2*i) = AXES(i)//' theory'
        end do
        call book%page%table(of_what//': RMS errors of the CG offset, mm, '//integer_text(book%runs)//' runs and theory', heads, &
                             rows, anchor)
    end subroutine add_rms_table

    !> The errors of a row of such a table.
    function rms_cells(rms, predicted) result(cells)
        real(dp), intent(in) :: rms(3)              !! x, y, z, m
        real(dp), intent(in) :: predicted(3)        !! By theory, m
        character(:), allocatable :: cells

        integer :: i

        cells = number_cells([(rms(i)/MILLIMETRE, predicted(i)/MILLIMETRE, i=1, 3)], 5)
    end function rms_cells
end module gracecg_cli_report_book
