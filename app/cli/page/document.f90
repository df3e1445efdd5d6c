!> The content of a page as JSON blocks, from top to bottom: chapters, paragraphs, verdicts, tables, figures. The Python
!> package sets it (`gracecg.pages`).
!>
!> A table is one call with its heads and its rows; a row is added with its cells, put together by //:
!> `call rows%add(head_cell('x')//number_cells([0.5_dp, 0.1_dp], 3)//text_cell('good'))`. In texts `^{...}` raises and
!> `_{...}` lowers, and text between back quotes is code.
module gracecg_cli_document
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: integer_text
    use gracecg_files_json, only: json_quoted
    use gracecg_cli_number_text, only: fixed_text
    implicit none
    private
    public :: document_t
    public :: table_rows_t, head_cell, number_cell, number_cells, judged_cell, text_cell, verdict_cell
    public :: VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED, VERDICT_NONE, VERDICT_KINDS

    !> Kinds of verdicts: as it should be; nearly, or with a remark; not; no judgement
    integer, parameter :: VERDICT_MET = 1, VERDICT_PARTLY = 2, VERDICT_MISSED = 3, VERDICT_NONE = 4
    character(6), parameter :: VERDICT_KINDS(4) = [character(6) :: 'met', 'partly', 'missed', 'none']   !! Their names
    character(1), parameter :: LF = achar(10)

    !> Rows of a table, as they grow.
    type :: table_rows_t
        private
        character(:), allocatable :: json           !! Unallocated: none yet
    contains
        procedure :: add => add_row         !! Adds a row of cells
    end type table_rows_t

    !> A page's content in the making.
    type :: document_t
        private
        character(:), allocatable :: buffer         !! The blocks, each with a comma behind: the first `used` characters
        integer :: used = 0
    contains
        procedure :: chapter                !! Begins a chapter, which ends the one before
        procedure :: heading                !! A heading within a chapter
        procedure :: paragraph              !! A paragraph
        procedure :: verdict                !! A verdict that stands for itself
        procedure :: details                !! Lines that are shown when the reader asks for them
        procedure :: files                  !! Links to files beside the page
        procedure :: table                  !! A table
        procedure :: figure                 !! A figure of panels, or a drawing
        procedure :: append                 !! The blocks of another document, behind those of this one
        procedure :: blocks                 !! All blocks as a JSON array
        procedure, private :: put
    end type document_t

contains

    !> Begins a chapter, which ends the one before.
    subroutine chapter(self, id, title)
        class(document_t), intent(inout) :: self
        character(*), intent(in) :: id          !! For links to it: letters, digits, hyphens; once a page
        character(*), intent(in) :: title       !! Of the chapter

        call self%put('chapter', member('id', id)//member('title', title))
    end subroutine chapter

    !> A heading within a chapter.
    subroutine heading(self, title)
        class(document_t), intent(inout) :: self
        character(*), intent(in) :: title       !! With marks

        call self%put('heading', member('title', title))
    end subroutine heading

    subroutine paragraph(self, text)
        class(document_t), intent(inout) :: self
        character(*), intent(in) :: text        !! With marks

        call self%put('paragraph', member('text', text))
    end subroutine paragraph

    !> A verdict that stands for itself: a few words, and what there is to say about it.
    subroutine verdict(self, kind, words, explanation)
        class(document_t), intent(inout) :: self
        integer, intent(in) :: kind             !! VERDICT_...
        character(*), intent(in) :: words       !! The verdict
        character(*), intent(in), optional :: explanation       !! Beside the words

        character(:), allocatable :: rest

        rest = ''
        if (present(explanation)) rest = explanation
        call self%put('verdict', member('kind', trim(VERDICT_KINDS(kind)))//member('words', words)//member('rest', rest))
    end subroutine verdict

    !> Lines that are shown when the reader asks for them.
    subroutine details(self, summary, text)
        class(document_t), intent(inout) :: self
        character(*), intent(in) :: summary, text   !! The line always seen, and what it unfolds

        call self%put('details', member('summary', summary)//member('text', text))
    end subroutine details

    !> Links to files beside the page; those of figures are added when they are drawn.
    subroutine files(self, names)
        class(document_t), intent(inout) :: self
        character(*), intent(in) :: names       !! Each with a comma behind, JSON texts

        call self%put('files', '"names":['//without_comma(names)//'],')
    end subroutine files

    !> A table. An empty head lets the one before it reach over its column, too.
    subroutine table(self, caption, heads, rows, id, stacks)
        class(document_t), intent(inout) :: self
        character(*), intent(in) :: caption             !! Above the table
        character(*), intent(in) :: heads(:)            !! Of the columns
        type(table_rows_t), intent(in) :: rows
        character(*), intent(in) :: id                  !! For links to it, and as its name
        logical, intent(in), optional :: stacks
        !! On a phone the cells of a row stand below each other: for tables of words

        character(:), allocatable :: list
        logical :: stacked
        integer :: i

        list = ''
        do i = 1, size(heads)
            list = list//json_quoted(trim(heads(i)))//','
        end do
        stacked = .false.
        if (present(stacks)) stacked = stacks
        call self%put('table', member('id', id)//member('caption', caption)//'"heads":['//without_comma(list)//'],"stacks":'// &
                      trim(merge('true ', 'false', stacked))//',"rows":['//without_comma(rows%json)//'],')
    end subroutine table

    !> A figure. Title and description are for those who cannot see it.
    subroutine figure(self, id, drawn, caption, title, description)
        class(document_t), intent(inout) :: self
        character(*), intent(in) :: id          !! Letters, digits, underscores; once a page
        character(*), intent(in) :: drawn
        !! A JSON object of panels (gracecg_cli_panels), or the name of a drawing, which has title and description
        character(*), intent(in) :: caption     !! Below the figure
        character(*), intent(in), optional :: title, description        !! For readers who do not see it

        character(:), allocatable :: words

        words = member('id', id)//member('caption', caption)
        if (present(title)) words = words//member('title', title)
        if (present(description)) words = words//member('description', description)
        if (index(drawn, '{') == 1) then
            call self%put('figure', words//'"panels":'//drawn//',')
        else
            call self%put('drawing', words//member('name', drawn))
        end if
    end subroutine figure

    !> The blocks of another document, behind those of this one.
    subroutine append(self, other)
        class(document_t), intent(inout) :: self
        type(document_t), intent(in) :: other

        if (other%used > 0) call append_text(self, other%buffer(:other%used))
    end subroutine append

    !> All blocks as a JSON array, one a line.
    pure function blocks(self) result(json)
        class(document_t), intent(in) :: self
        character(:), allocatable :: json

        json = '[]'
        if (self%used > 0) json = '['//LF//self%buffer(:self%used - 2)//LF//']'
    end function blocks

    subroutine put(self, kind, members)
        class(document_t), intent(inout) :: self
        character(*), intent(in) :: kind, members       !! Each member with a comma behind

        call append_text(self, '{"block":"'//kind//'",'//without_comma(members)//'},'//LF)
    end subroutine put

    !> Appends to the buffer, which grows by doubling.
    subroutine append_text(self, text)
        class(document_t), intent(inout) :: self
        character(*), intent(in) :: text

        character(:), allocatable :: longer

        if (.not. allocated(self%buffer)) allocate (character(65536) :: self%buffer)
        if (self%used + len(text) > len(self%buffer)) then
            allocate (character(2*(self%used + len(text))) :: longer)
            longer(:self%used) = self%buffer(:self%used)
            call move_alloc(longer, self%buffer)
        end if
        self%buffer(self%used + 1:self%used + len(text)) = text
        self%used = self%used + len(text)
    end subroutine append_text

    !> Adds a row. One whose first cell is several rows high begins a part of the table.
    subroutine add_row(self, cells)
        class(table_rows_t), intent(inout) :: self
        character(*), intent(in) :: cells               !! From the functions *_cell, put together by //

        if (.not. allocated(self%json)) self%json = ''
        self%json = self%json//'['//without_comma(cells)//'],'
    end subroutine add_row

    !> Head of one row, or of several.
    pure function head_cell(text, rows, anchor) result(cell)
        character(*), intent(in) :: text                !! With marks
        integer, intent(in), optional :: rows           !! So many rows high
        character(*), intent(in), optional :: anchor    !! Id on the page that the text leads to
        character(:), allocatable :: cell

        cell = '{'//member('head', text)
        if (present(rows)) cell = cell//'"rows":'//integer_text(rows)//','
        if (present(anchor)) cell = cell//member('anchor', anchor)
        cell = without_comma(cell)//'},'
    end function head_cell

    !> A number, as text: set to the right, its digits of equal width.
    pure function number_cell(text) result(cell)
        character(*), intent(in) :: text                !! The number
        character(:), allocatable :: cell

        cell = '{"number":'//json_quoted(trim(adjustl(text)))//'},'
    end function number_cell

    !> Numbers with so many decimals, a cell each.
    function number_cells(values, decimals) result(cells)
        real(dp), intent(in) :: values(:)               !! In the unit that the caller names
        integer, intent(in) :: decimals                 !! Digits behind the point
        character(:), allocatable :: cells

        integer :: i

        cells = ''
        do i = 1, size(values)
            cells = cells//number_cell(fixed_text(values(i), decimals))
        end do
    end function number_cells

    !> A number with a verdict before it.
    pure function judged_cell(kind, word, text) result(cell)
        integer, intent(in) :: kind                     !! VERDICT_...
        character(*), intent(in) :: word                !! The verdict in a word
        character(*), intent(in) :: text                !! The number
        character(:), allocatable :: cell

        cell = '{'//member('kind', trim(VERDICT_KINDS(kind)))//member('word', word)//'"number":'// &
               json_quoted(trim(adjustl(text)))//'},'
    end function judged_cell

    !> A cell with text.
    pure function text_cell(text, wraps) result(cell)
        character(*), intent(in) :: text                !! With marks
        logical, intent(in), optional :: wraps          !! May be broken into several lines
        character(:), allocatable :: cell

        cell = '{"text":'//json_quoted(text)//'},'
        if (.not. present(wraps)) return
        if (wraps) cell = '{"text":'//json_quoted(text)//',"wraps":true},'
    end function text_cell

    !> A verdict: its mark and its words.
    pure function verdict_cell(kind, words) result(cell)
        integer, intent(in) :: kind                     !! VERDICT_...
        character(*), intent(in) :: words               !! The verdict
        character(:), allocatable :: cell

        cell = '{'//member('kind', trim(VERDICT_KINDS(kind)))//'"verdict":'//json_quoted(words)//'},'
    end function verdict_cell

    !> A text with its key, and a comma behind.
    pure function member(key, text) result(json)
        character(*), intent(in) :: key, text
        character(:), allocatable :: json

        json = '"'//key//'":'//json_quoted(text)//','
    end function member

    pure function without_comma(list) result(json)
        character(*), intent(in) :: list        !! Empty, or with a comma at its end
        character(:), allocatable :: json

        json = list(:max(0, len(list) - 1))
    end function without_comma
end module gracecg_cli_document
