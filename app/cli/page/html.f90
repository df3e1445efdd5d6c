!> Writes one self-contained HTML page: style sheet and figures stand in it, nothing is fetched.
!>
!> A page is built from top to bottom: `begin`, then chapters with paragraphs, tables and figures, then
!> `write`. A table is one call with its heads and its rows; a row is added with its cells, put together
!> by //: `call rows%add(head_cell('x')//number_cells([0.5_dp, 0.1_dp], 3)//text_cell('good'))`. All texts
!> are escaped; in them `^{...}` raises and `_{...}` lowers, as in gnuplot, and text between back quotes is
!> set as code. Verdicts carry a mark and a word, so colour is never alone.
module gracecg_cli_html
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text
    use gracecg_files_file, only: output_file_t
    use gracecg_cli_html_style, only: style_sheet
    use gracecg_cli_number_text, only: fixed_text
    implicit none
    private
    public :: html_page_t, html_escaped, html_typeset, inline_svg
    public :: table_rows_t, head_cell, number_cell, number_cells, judged_cell, text_cell, verdict_cell
    public :: VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED, VERDICT_NONE

    !> Kinds of verdicts: as it should be; nearly, or with a remark; not; no judgement
    integer, parameter :: VERDICT_MET = 1, VERDICT_PARTLY = 2, VERDICT_MISSED = 3, VERDICT_NONE = 4
    character(*), parameter :: VERDICT_CLASS(4) = [character(6) :: 'met', 'partly', 'missed', 'none']
    character(*), parameter :: VERDICT_MARK(4) = [character(8) :: '&#10003;', '&#9888;', '&#10007;', '&#8226;']
    !! Check mark, warning sign, cross, bullet
    character(1), parameter :: LF = achar(10), QUOTE = '"'

    !> Rows of a table, as they grow.
    type :: table_rows_t
        private
        character(:), allocatable :: html           !! Unallocated: none yet
        character(:), allocatable :: first          !! Cells of the first row
    contains
        procedure :: add => add_row
        !! Adds a row of cells
    end type table_rows_t

    type :: html_page_t
        !! A page in the making
        private
        character(:), allocatable :: title, lead
        character(:), allocatable :: buffer         !! The chapters: the first `used` characters
        integer :: used = 0
        character(:), allocatable :: contents       !! Entries of the table of contents
        logical :: chapter_open = .false.
    contains
        procedure :: begin => begin_page    !! Starts a page
        procedure :: chapter => begin_chapter    !! Begins a chapter, which ends the one before
        procedure :: heading    !! A heading within a chapter
        procedure :: paragraph    !! A paragraph
        procedure :: bullet_list    !! A list with bullets
        procedure :: verdict => verdict_note
        !! A verdict that stands for itself: its mark, a few words, and what there is to say about it
        procedure :: preformatted    !! Lines as they are, in a typewriter's face
        procedure :: details    !! Lines that are shown when the reader asks for them
        procedure :: append => append_page    !! The chapters of another page, behind those of this one
        procedure :: markup    !! HTML as it is
        procedure :: table => add_table    !! A table
        procedure :: figure    !! A figure of SVG text
        procedure :: missing_figure    !! The place of a figure that could not be drawn, with the reason
        procedure :: document    !! The whole page as text
        procedure :: write => write_page    !! Writes the page
    end type html_page_t

contains

    !> Starts a page. The lead is one paragraph that says what the page is.
    subroutine begin_page(self, title, lead)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: title, lead    !! At the top, and the sentence below it

        self%title = title
        self%lead = lead
        self%contents = ''
        self%buffer = ''
        self%used = 0
        self%chapter_open = .false.
    end subroutine begin_page

    !> Begins a chapter, which ends the one before.
    subroutine begin_chapter(self, id, title)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: id          !! For links to it: letters, digits, hyphens; once a page
        character(*), intent(in) :: title    !! Of the chapter

        if (self%chapter_open) call self%markup('</section>')
        self%chapter_open = .true.
        self%contents = self%contents//'<li><a href="#'//id//'">'//html_typeset(title)//'</a></li>'//LF
        call self%markup('<section aria-labelledby="'//id//'">'//LF//'<h2 id="'//id//'">'// &
                         html_typeset(title)//'</h2>')
    end subroutine begin_chapter

    !> A heading within a chapter.
    subroutine heading(self, title, id)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: title    !! Plain text
        character(*), intent(in), optional :: id    !! Anchor

        if (present(id)) then
            call self%markup('<h3 id="'//id//'">'//html_typeset(title)//'</h3>')
        else
            call self%markup('<h3>'//html_typeset(title)//'</h3>')
        end if
    end subroutine heading

    subroutine paragraph(self, text)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Plain text

        call self%markup('<p>'//html_typeset(text)//'</p>')
    end subroutine paragraph

    subroutine bullet_list(self, texts)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: texts(:)    !! One for each bullet

        integer :: i

        call self%markup('<ul>')
        do i = 1, size(texts)
            call self%markup('<li>'//html_typeset(trim(texts(i)))//'</li>')
        end do
        call self%markup('</ul>')
    end subroutine bullet_list

    !> A verdict that stands for itself: its mark, a few words, and what there is to say about it.
    subroutine verdict_note(self, kind, words, explanation)
        class(html_page_t), intent(inout) :: self
        integer, intent(in) :: kind             !! VERDICT_...
        character(*), intent(in) :: words    !! The verdict
        character(*), intent(in), optional :: explanation    !! Beside the words

        character(:), allocatable :: rest

        rest = ''
        if (present(explanation)) rest = ' <span class="rest">'//html_typeset(explanation)//'</span>'
        call self%markup('<p class="note verdict '//trim(VERDICT_CLASS(kind))//'">'//marked(kind, words)// &
                         rest//'</p>')
    end subroutine verdict_note

    !> Lines as they are, in a typewriter's face. Long ones scroll within their box.
    subroutine preformatted(self, text, name)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Plain text
        character(*), intent(in) :: name    !! What they are, for readers who do not see the box

        call self%markup('<pre class="scroll" role="group" tabindex="0" aria-label="'//html_escaped(plain(name))// &
                         '"><code>'//html_escaped(text)//'</code></pre>')
    end subroutine preformatted

    !> Lines that are shown when the reader asks for them.
    subroutine details(self, summary, text)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: summary, text    !! The line always seen, and what it unfolds

        call self%markup('<details><summary>'//html_typeset(summary)//'</summary>')
        call self%preformatted(text, summary)
        call self%markup('</details>')
    end subroutine details

    !> The chapters of another page, behind those of this one. Title and lead stay.
    subroutine append_page(self, other)
        class(html_page_t), intent(inout) :: self
        type(html_page_t), intent(in) :: other

        if (self%chapter_open) call self%markup('</section>')
        self%chapter_open = other%chapter_open
        self%contents = self%contents//other%contents
        call append_text(self, other%buffer(:other%used))
    end subroutine append_page

    !> HTML as it is.
    subroutine markup(self, html)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: html    !! Put in as it stands

        call append_text(self, html//LF)
    end subroutine markup

    !> A table. A wide one scrolls within its box, its first column staying. An empty head lets the one before
    !> it reach over its column, too; a head over numbers is set to the right, as they are.
    subroutine add_table(self, caption, heads, rows, id, stacks, fits)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: caption             !! Above the table
        character(*), intent(in) :: heads(:)            !! Of the columns
        type(table_rows_t), intent(in) :: rows
        character(*), intent(in), optional :: id        !! For links to it, and as its name
        logical, intent(in), optional :: stacks
        !! On a phone the cells of a row stand below each other: for tables of words
        logical, intent(in), optional :: fits
        !! On a phone the cells are broken into lines, so that the table is seen whole

        character(:), allocatable :: name, attributes, head_row
        logical :: numeric(size(heads))
        integer :: i, columns

        name = ''
        if (present(id)) name = ' id="'//id//'"'
        if (present(stacks)) then
            if (stacks) name = name//' class="stacks"'
        end if
        if (present(fits)) then
            if (fits) name = name//' class="fits"'
        end if
        numeric = numeric_columns(rows%first, size(heads))
        head_row = '<tr>'
        do i = 1, size(heads)
            if (heads(i) == '') cycle
            columns = 1
            do while (i + columns <= size(heads))
                if (heads(i + columns) /= '') exit
                columns = columns + 1
            end do
            attributes = ' scope="col"'
            if (columns > 1) then
                attributes = ' scope="colgroup" colspan="'//integer_text(columns)//'"'
            else if (numeric(i)) then
                attributes = attributes//' class="number"'
            end if
            head_row = head_row//'<th'//attributes//'>'//html_typeset(trim(heads(i)))//'</th>'
        end do
        call self%markup('<div class="scroll" role="region" tabindex="0" aria-label="'// &
                         html_escaped(plain(caption))//'">'//LF//'<table'//name//'>'//LF// &
                         '<caption>'//html_typeset(caption)//'</caption>'//LF//'<thead>'//LF//head_row//'</tr>'//LF// &
                         '</thead>'//LF//'<tbody>'//LF//rows%html//'</tbody>'//LF//'</table>'//LF//'</div>')
    end subroutine add_table

    !> Which columns hold numbers, by the cells of the first row.
    pure function numeric_columns(cells, columns) result(numeric)
        character(*), intent(in) :: cells
        integer, intent(in) :: columns
        logical :: numeric(columns)

        integer :: i, from, length

        numeric = .false.
        from = 1
        do i = 1, columns
            length = index(cells(from:), '</t')     ! of td or th
            if (length == 0) return
            numeric(i) = index(cells(from:from + length - 1), '<td class="number') == 1
            from = from + length + len('</td>') - 1
        end do
    end function numeric_columns

    !> Adds a row. One whose first cell is several rows high begins a part of the table, which a line sets
    !> off.
    subroutine add_row(self, cells)
        class(table_rows_t), intent(inout) :: self
        character(*), intent(in) :: cells               !! From the functions *_cell, put together by //

        if (.not. allocated(self%html)) then
            self%html = ''
            self%first = cells
        end if
        if (index(cells(:index(cells, '>')), 'rowspan=') > 0) then
            self%html = self%html//'<tr class="part">'//cells//'</tr>'//LF
        else
            self%html = self%html//'<tr>'//cells//'</tr>'//LF
        end if
    end subroutine add_row

    !> Head of one row, or of several.
    function head_cell(text, rows, anchor) result(cell)
        character(*), intent(in) :: text                !! Plain text
        integer, intent(in), optional :: rows           !! So many rows high
        character(*), intent(in), optional :: anchor    !! Id on the page that the text leads to
        character(:), allocatable :: cell

        character(:), allocatable :: attributes, content

        attributes = ' scope="row"'
        if (present(rows)) then
            if (rows > 1) attributes = ' scope="rowgroup" rowspan="'//integer_text(rows)//'"'
        end if
        if (index(text, '-') > 0 .and. index(text, ' ') == 0) attributes = attributes//' class="one"'     ! front-1
        content = html_typeset(text)
        if (present(anchor)) content = '<a href="#'//anchor//'">'//content//'</a>'
        cell = '<th'//attributes//'>'//content//'</th>'
    end function head_cell

    !> A number, as text: set to the right, its digits of equal width.
    function number_cell(text) result(cell)
        character(*), intent(in) :: text                !! The number
        character(:), allocatable :: cell

        cell = '<td class="number">'//html_typeset(trim(adjustl(text)))//'</td>'
    end function number_cell

    !> Numbers with so many decimals, a cell each.
    function number_cells(values, decimals) result(cells)
        real(dp), intent(in) :: values(:)
        !! Numbers, in the unit that the caller names
        integer, intent(in) :: decimals                 !! Digits behind the point
        character(:), allocatable :: cells

        integer :: i

        cells = ''
        do i = 1, size(values)
            cells = cells//number_cell(fixed_text(values(i), decimals))
        end do
    end function number_cells

    !> A number with a verdict before it.
    function judged_cell(kind, word, text) result(cell)
        integer, intent(in) :: kind                     !! VERDICT_...
        character(*), intent(in) :: word                !! The verdict in a word
        character(*), intent(in) :: text                !! The number
        character(:), allocatable :: cell

        cell = '<td class="number '//trim(VERDICT_CLASS(kind))//'">'//marked(kind, word)// &
               ' <span class="value">'//html_typeset(trim(adjustl(text)))//'</span></td>'
    end function judged_cell

    !> A cell with text.
    function text_cell(text, wraps) result(cell)
        character(*), intent(in) :: text                !! Plain text
        logical, intent(in), optional :: wraps          !! May be broken into several lines
        character(:), allocatable :: cell

        cell = '<td>'//html_typeset(text)//'</td>'
        if (.not. present(wraps)) return
        if (wraps) cell = '<td class="wide">'//html_typeset(text)//'</td>'
    end function text_cell

    !> A verdict: its mark and its words.
    function verdict_cell(kind, words) result(cell)
        integer, intent(in) :: kind                     !! VERDICT_...
        character(*), intent(in) :: words               !! The verdict
        character(:), allocatable :: cell

        cell = '<td class="words '//trim(VERDICT_CLASS(kind))//'">'//marked(kind, words)//'</td>'
    end function verdict_cell

    !> A figure of SVG text. Title and description are for those who cannot see it.
    subroutine figure(self, id, svg, caption, title, description, by_classes)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: id          !! Letters, digits, underscores; once a page
        character(*), intent(in) :: svg         !! A whole SVG document, as gnuplot writes it
        character(*), intent(in) :: caption     !! Below the figure
        character(*), intent(in) :: title, description    !! For readers who do not see the figure
        logical, intent(in), optional :: by_classes
        !! Coloured by the classes of the style sheet, as tools/drawings.py does; else as gnuplot does

        character(:), allocatable :: drawn

        drawn = ''
        if (present(by_classes)) then
            if (by_classes) drawn = ' class="drawing"'
        end if
        call self%markup('<figure id="'//id//'"'//drawn//'>')
        call self%markup(inline_svg(svg, id, title, description))
        call self%markup('<figcaption>'//html_typeset(caption)//'</figcaption>'//LF//'</figure>')
    end subroutine figure

    !> The place of a figure that could not be drawn, with the reason.
    subroutine missing_figure(self, id, reason, caption)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: id, reason, caption
        !! Anchor; why there is no figure; what it would show

        call self%markup('<figure id="'//id//'">'//LF//'<p class="absent">Not drawn: '//html_typeset(reason)// &
                         '</p>'//LF//'<figcaption>'//html_typeset(caption)//'</figcaption>'//LF//'</figure>')
    end subroutine missing_figure

    !> The whole page as text. The contents stand at its end, so that on narrow screens the result comes first; the
    !> bar that leads to them stays in sight. On wide screens they stay beside the chapters.
    function document(self) result(html)
        class(html_page_t), intent(in) :: self
        character(:), allocatable :: html

        character(:), allocatable :: ending

        ending = ''
        if (self%chapter_open) ending = '</section>'//LF
        html = '<!DOCTYPE html>'//LF//'<html lang="en">'//LF//'<head>'//LF//'<meta charset="utf-8">'//LF// &
               '<meta name="viewport" content="width=device-width, initial-scale=1">'//LF// &
               '<meta name="color-scheme" content="light dark">'//LF// &
               '<title>'//html_escaped(plain(self%title))//'</title>'//LF// &
               '<link rel="icon" href="data:,">'//LF//'<style>'//LF//style_sheet()//LF//'</style>'//LF// &
               '</head>'//LF//'<body>'//LF//'<header id="top">'//LF//'<h1>'//html_typeset(self%title)//'</h1>'//LF// &
               '<p>'//html_typeset(self%lead)//'</p>'//LF//'</header>'//LF
        if (self%contents /= '') html = html//'<nav class="bar" aria-label="On this page"><a href="#top">Top</a>'// &
                                        '<a href="#contents">Contents</a></nav>'//LF
        html = html//'<main>'//LF//self%buffer(:self%used)//ending//'</main>'//LF
        if (self%contents /= '') html = html//'<nav id="contents" aria-labelledby="contents-head">'//LF// &
                                        '<h2 id="contents-head">Contents</h2>'//LF//'<ol>'//LF//self%contents// &
                                        '</ol>'//LF//'</nav>'//LF
        html = html//'</body>'//LF//'</html>'
    end function document

    !> Writes the page. Fails when the file cannot be written; then there is none, or still the older one.
    subroutine write_page(self, path, error)
        class(html_page_t), intent(in) :: self
        character(*), intent(in) :: path    !! Of the file
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file

        call file%open(path, error)
        if (allocated(error)) return
        call file%line(self%document())
        call file%commit(error)
    end subroutine write_page

    !> Appends to the buffer, which grows by doubling.
    subroutine append_text(self, text)
        class(html_page_t), intent(inout) :: self
        character(*), intent(in) :: text

        integer, parameter :: SMALLEST = 65536
        character(:), allocatable :: larger

        if (self%used + len(text) > len(self%buffer)) then
            allocate (character(max(SMALLEST, 2*(self%used + len(text)))) :: larger)
            larger(:self%used) = self%buffer(:self%used)
            call move_alloc(larger, self%buffer)
        end if
        self%buffer(self%used + 1:self%used + len(text)) = text
        self%used = self%used + len(text)
    end subroutine append_text

    function marked(kind, words) result(html)
        integer, intent(in) :: kind
        character(*), intent(in) :: words
        character(:), allocatable :: html

        html = '<span aria-hidden="true">'//trim(VERDICT_MARK(kind))//'</span> '//html_typeset(words)
    end function marked

    !> A text that stands for itself in HTML, also within an attribute. Control characters, which HTML
    !> does not have, become blanks.
    pure function html_escaped(text) result(html)
        character(*), intent(in) :: text    !! Any
        character(:), allocatable :: html

        character(6) :: letter      ! The longest
        integer :: i, length, used

        allocate (character(len(letter)*len(text)) :: html)
        used = 0
        do i = 1, len(text)
            length = 1
            select case (text(i:i))
            case ('&')
                letter = '&amp;'
            case ('<')
                letter = '&lt;'
            case ('>')
                letter = '&gt;'
            case ('"')
                letter = '&quot;'
            case ("'")
                letter = '&#39;'
            case (achar(0):achar(9), achar(11):achar(31), achar(127))
                letter = ' '
            case default
                letter = text(i:i)
            end select
            if (letter(1:1) == '&') length = len_trim(letter)
            html(used + 1:used + length) = letter(:length)
            used = used + length
        end do
        html = html(:used)
    end function html_escaped

    !> A text with its marks: `^{a}` raised, `_{a}` lowered, code between back quotes; all else escaped.
    !> A mark without its end stands as it is.
    function html_typeset(text) result(html)
        character(*), intent(in) :: text    !! With ^{...}, _{...} and `...`
        character(:), allocatable :: html

        character(:), allocatable :: tag
        integer :: from, first, inside, last

        html = ''
        from = 1
        do
            first = from - 1 + scan_mark(text(from:))
            if (first < from) exit
            select case (text(first:first))
            case ('`')
                tag = 'code'
                inside = first + 1
                last = first + index(text(inside:), '`')
            case default
                tag = merge('sup', 'sub', text(first:first) == '^')
                inside = first + 2
                last = first + 1 + index(text(inside:), '}')
            end select
            html = html//html_escaped(text(from:first - 1))//'<'//tag//'>'// &
                   html_escaped(text(inside:last - 1))//'</'//tag//'>'
            from = last + 1
        end do
        html = html//html_escaped(text(from:))
    end function html_typeset

    !> Where the first complete mark begins; 0: nowhere.
    pure integer function scan_mark(text) result(first)
        character(*), intent(in) :: text

        do first = 1, len(text) - 1
            select case (text(first:first))
            case ('`')
                if (index(text(first + 1:), '`') > 0) return
            case ('^', '_')
                if (text(first + 1:first + 1) == '{' .and. index(text(first + 1:), '}') > 0) return
            end select
        end do
        first = 0
    end function scan_mark

    !> A text without its marks.
    pure function plain(text) result(words)
        character(*), intent(in) :: text
        character(:), allocatable :: words

        integer :: i

        words = ''
        do i = 1, len(text)
            select case (text(i:i))
            case ('`', '{', '}')
            case ('_', '^')
                if (i < len(text)) then
                    if (text(i + 1:i + 1) == '{') cycle
                end if
                words = words//text(i:i)
            case default
                words = words//text(i:i)
            end select
        end do
    end function plain

    !> An SVG document made fit to stand within a page: no XML declaration, its own title and description,
    !> and names that begin with `id`, so that several figures do not disturb each other.
    function inline_svg(svg, id, title, description) result(html)
        character(*), intent(in) :: svg, id, title, description
        !! The figure; prefix of its anchors; name and description for who does not see it
        character(:), allocatable :: html

        integer :: first, body

        first = index(svg, '<svg')
        if (first == 0) then
            html = ''
            return
        end if
        body = first + index(svg(first:), '>')
        html = trimmed_right(svg(body:))
        html = without_element(html, 'title')
        html = without_element(html, 'desc')
        html = replaced(html, ' stroke-linecap="butt" stroke-linejoin="miter"', '')     ! as without them
        html = replaced(html, ' font-family="sans-serif"', '')                          ! the page's
        html = replaced(html, achar(9), '')
        html = without_empty_groups(html)
        html = replaced(html, ' id="', ' id="'//id//'_')
        html = replaced(html, " id='", " id='"//id//'_')
        html = replaced(html, 'href="#', 'href="#'//id//'_')
        html = replaced(html, "href='#", "href='#"//id//'_')
        html = replaced(html, 'url(#', 'url(#'//id//'_')
        html = '<svg role="img" aria-labelledby="'//id//'_title '//id//'_desc"'// &
               kept_attributes(svg(first + 4:body - 2))//'>'//LF// &
               '<title id="'//id//'_title">'//html_escaped(plain(title))//'</title>'//LF// &
               '<desc id="'//id//'_desc">'//html_escaped(plain(description))//'</desc>'//html
    end function inline_svg

    !> Without the groups that hold nothing, of which gnuplot writes many.
    pure function without_empty_groups(svg) result(smaller)
        character(*), intent(in) :: svg
        character(:), allocatable :: smaller

        character(*), parameter :: GROUP_END = '>'//LF//'</g>'//LF
        integer :: from, used, last, first

        smaller = svg
        from = 1
        used = 0
        do
            last = from - 1 + index(svg(from:), GROUP_END)
            if (last < from) exit
            first = from - 1 + index(svg(from:last), '<', back=.true.)
            if (index(svg(first:last), '<g ') /= 1) first = last + len(GROUP_END)      ! not an empty one: kept
            smaller(used + 1:used + first - from) = svg(from:first - 1)
            used = used + first - from
            from = last + len(GROUP_END)
        end do
        smaller(used + 1:used + len(svg) - from + 1) = svg(from:)
        smaller = smaller(:used + len(svg) - from + 1)
    end function without_empty_groups

    !> The attributes of an svg element, but for a fixed size: the page decides on it.
    pure function kept_attributes(attributes) result(kept)
        character(*), intent(in) :: attributes
        character(:), allocatable :: kept

        character(*), parameter :: NAMES(3) = [character(12) :: 'viewBox=', 'xmlns=', 'xmlns:xlink=']
        integer :: i, first, length

        kept = ''
        do i = 1, size(NAMES)
            first = index(attributes, trim(NAMES(i)))
            if (first == 0) cycle
            length = index(attributes(first + len_trim(NAMES(i)) + 1:), QUOTE)
            kept = kept//' '//attributes(first:first + len_trim(NAMES(i)) + length)
        end do
    end function kept_attributes

    !> Without the elements of that name.
    pure function without_element(xml, name) result(rest)
        character(*), intent(in) :: xml, name
        character(:), allocatable :: rest

        integer :: first, length

        rest = xml
        do
            first = index(rest, '<'//name//'>')
            if (first == 0) exit
            length = index(rest(first:), '</'//name//'>')
            if (length == 0) exit
            rest = rest(:first - 1)//rest(first + length + len(name) + 2:)
        end do
    end function without_element

    !> Every `old` replaced by `new`.
    pure function replaced(text, old, new) result(changed)
        character(*), intent(in) :: text, old, new
        character(:), allocatable :: changed

        integer :: i, count, from, to, step

        count = 0
        i = 1
        do
            step = index(text(i:), old)
            if (step == 0) exit
            count = count + 1
            i = i + step - 1 + len(old)
        end do
        allocate (character(len(text) + count*(len(new) - len(old))) :: changed)
        from = 1
        to = 1
        do i = 1, count
            step = index(text(from:), old) - 1
            changed(to:to + step + len(new) - 1) = text(from:from + step - 1)//new
            from = from + step + len(old)
            to = to + step + len(new)
        end do
        changed(to:) = text(from:)
    end function replaced

    pure function trimmed_right(text) result(shorter)
        character(*), intent(in) :: text
        character(:), allocatable :: shorter

        integer :: last

        last = verify(text, ' '//LF//achar(13)//achar(9), back=.true.)
        shorter = text(:last)
    end function trimmed_right
end module gracecg_cli_html
