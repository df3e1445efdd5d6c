!> HTML pages and the figures in them: escaping, structure, and what inline SVG is made of.
module test_html
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, message_of
    use gracecg_files_file, only: text_file_t, read_text_file
    use gracecg_cli_html
    use gracecg_cli_palette, only: PALETTE, gnuplot_rgb
    use testdrive, only: new_unittest, unittest_type, error_type, check, test_failed
    use fixture, only: FOLDER, make_folder, check_passes, check_fails
    implicit none
    private
    public :: collect_html

    character(1), parameter :: LF = achar(10)

contains

    subroutine collect_html(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('escaping', test_escaping), &
                    new_unittest('typesetting', test_typesetting), &
                    new_unittest('page', test_page), &
                    new_unittest('long-page', test_long_page), &
                    new_unittest('appended-page', test_appended), &
                    new_unittest('inline-svg', test_inline_svg), &
                    new_unittest('colours-of-gnuplot', test_colours), &
                    new_unittest('file', test_file)]
    end subroutine collect_html

    subroutine check_text(error, found, expected)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: found, expected

        call check(error, found == expected .and. len(found) == len(expected), &
                   'found: '//found//LF//'expected: '//expected)
    end subroutine check_text

    subroutine test_escaping(error)
        type(error_type), allocatable, intent(out) :: error

        call check_text(error, html_escaped('a < b & c > "d" ''e'''), &
                        'a &lt; b &amp; c &gt; &quot;d&quot; &#39;e&#39;')
        if (allocated(error)) return
        call check_text(error, html_escaped('&amp;'), '&amp;amp;')
        if (allocated(error)) return
        call check_text(error, html_escaped('a'//achar(0)//achar(27)//'b'), 'a  b')
        if (allocated(error)) return
        call check_text(error, html_escaped(''), '')
        if (allocated(error)) return
        call check_text(error, html_escaped('line'//LF//'line'), 'line'//LF//'line')
    end subroutine test_escaping

    subroutine test_typesetting(error)
        type(error_type), allocatable, intent(out) :: error

        call check_text(error, html_typeset('10^{-7} m/s^{2}'), '10<sup>-7</sup> m/s<sup>2</sup>')
        if (allocated(error)) return
        call check_text(error, html_typeset('a_{<}b'), 'a<sub>&lt;</sub>b')
        if (allocated(error)) return
        call check_text(error, html_typeset('`x^{2} <` and'), '<code>x^{2} &lt;</code> and')
        if (allocated(error)) return
        call check_text(error, html_typeset('a_b ` {x} ^2 _{ open'), 'a_b ` {x} ^2 _{ open')
        if (allocated(error)) return
        call check_text(error, html_typeset('^{}'), '<sup></sup>')
    end subroutine test_typesetting

    !> A page with everything that a page can have.
    subroutine make_page(page)
        type(html_page_t), intent(out) :: page

        type(table_rows_t) :: rows

        call page%begin('A & B', 'The <lead>')
        call page%chapter('first', 'First')
        call page%heading('Heading', 'there')
        call page%paragraph('Text')
        call page%bullet_list(['one', 'two'])
        call page%verdict(VERDICT_MISSED, 'Outside', 'why')
        call page%preformatted('<pre>', 'lines')
        call page%details('more', 'lines')
        call rows%add(head_cell('front', rows=2)//number_cell(' 0.5 ')//text_cell('a', wraps=.true.)// &
                      verdict_cell(VERDICT_MET, 'inside'))
        call rows%add(judged_cell(VERDICT_PARTLY, 'near', '1.25')//number_cells([2.5_dp, -0.75_dp], 1)// &
                      head_cell('link', anchor='table'))
        call page%table('A table of m^{2}', [character(4) :: 'case', 'x', 'y', ''], rows, 'table', stacks=.true.)
        call page%figure('figure_1', svg_text(), 'Caption', 'Title', 'Description')
        call page%missing_figure('figure_2', 'no gnuplot', 'Caption 2')
        call page%chapter('second', 'Second')
    end subroutine make_page

    !> In the manner of gnuplot.
    function svg_text() result(text)
        character(:), allocatable :: text

        text = '<?xml version="1.0"?>'//LF//'<svg '//LF//' width="600" height="300" viewBox="0 0 600 300"'//LF// &
               ' xmlns="http://www.w3.org/2000/svg"'//LF//'>'//LF//'<title>Gnuplot</title>'//LF// &
               '<desc>Produced by GNUPLOT 5.4</desc>'//LF//'<g id="canvas">'//LF//"<path id='p' d='M0,0'/>"//LF// &
               "<use href='#p'/><use xlink:href=""#canvas"" filter='url(#box)'/>"//LF// &
               '<g fill="none">'//LF//'</g>'//LF//'<g a="1" stroke-linecap="butt" stroke-linejoin="miter">'//LF// &
               achar(9)//'<text font-family="sans-serif">x</text>'//LF//'</g>'//LF//'</g>'//LF//'</svg>'//LF
    end function svg_text

    !> Every element that is opened is closed, in its order; what must be there is there.
    subroutine test_page(error)
        type(error_type), allocatable, intent(out) :: error
        character(66), parameter :: PARTS(23) = [character(66) :: &
            '<html lang="en">', '<title>A &amp; B</title>', '<p>The &lt;lead&gt;</p>', &
            '<li><a href="#first">First</a></li>', '<section aria-labelledby="second">', '<h3 id="there">Heading</h3>', &
            '<table id="table" class="stacks">', '<span aria-hidden="true">&#10007;</span> Outside', '<code>&lt;pre&gt;</code>', &
            '<summary>more</summary>', '<caption>A table of m<sup>2</sup></caption>', 'aria-label="A table of m2"', &
            '<th scope="col" class="number">x</th>', '<th scope="colgroup" colspan="2">y</th>', '<tr class="part">', &
            '<th scope="rowgroup" rowspan="2">front</th>', '<td class="number">0.5</td>', &
            '<span class="value">1.25</span>', '<th scope="row"><a href="#table">link</a></th>', &
            '<td class="number">2.5</td><td class="number">-0.8</td>', '<th scope="col">case</th>', &
            'Not drawn: no gnuplot', '<svg role="img" aria-labelledby="figure_1_title figure_1_desc"']
        type(html_page_t) :: page
        character(:), allocatable :: html
        integer :: i

        call make_page(page)
        html = page%document()
        do i = 1, size(PARTS)
            call check(error, index(html, trim(PARTS(i))) > 0, 'not there: '//trim(PARTS(i)))
            if (allocated(error)) return
        end do
        call check_balance(error, html)
        if (allocated(error)) return
        call check(error, index(html, 'src=') == 0 .and. index(html, '@import') == 0 .and. index(html, '<link') == &
                   index(html, '<link rel="icon" href="data:,">'), 'nothing is fetched')
    end subroutine test_page

    !> Opening and closing tags are in balance.
    subroutine check_balance(error, html)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: html
        character(12), parameter :: VOID(3) = [character(12) :: 'meta', 'link', '!DOCTYPE']
        character(12) :: open_tags(100), name
        integer :: i, last, depth, length

        depth = 0
        i = index(html, '</style>') + len('</style>')
        open_tags(1:2) = [character(12) :: 'html', 'head']
        depth = 2
        do
            last = index(html(i:), '<')
            if (last == 0) exit
            i = i + last - 1
            last = i + index(html(i:), '>') - 1
            if (html(i + 1:i + 1) == '/') then
                name = html(i + 2:last - 1)
                call check(error, open_tags(depth) == name, 'closed: '//trim(name)//', open: '//open_tags(depth))
                if (allocated(error)) return
                depth = depth - 1
            else if (html(last - 1:last - 1) /= '/') then
                length = scan(html(i + 1:last), ' >'//LF) - 1
                name = html(i + 1:i + length)
                if (.not. any(VOID == name)) then
                    depth = depth + 1
                    open_tags(depth) = name
                end if
            end if
            i = last + 1
        end do
        call check(error, depth, 0, 'open at the end: '//open_tags(max(1, depth)))
    end subroutine check_balance

    !> The buffer grows without losing anything.
    subroutine test_long_page(error)
        type(error_type), allocatable, intent(out) :: error
        type(html_page_t) :: page
        character(:), allocatable :: html
        integer :: i, lines

        call page%begin('Long', 'page')
        call page%chapter('only', 'Only')
        do i = 1, 20000
            call page%paragraph('0123456789')
        end do
        html = page%document()
        lines = 0
        i = index(html, '<p>0123456789</p>')
        do while (i > 0 .and. i <= len(html) - 17)
            if (html(i:i + 16) /= '<p>0123456789</p>') exit
            lines = lines + 1
            i = i + 18
        end do
        call check(error, lines, 20000)
    end subroutine test_long_page

    !> Chapters of another page follow, with their entries of the contents.
    subroutine test_appended(error)
        type(error_type), allocatable, intent(out) :: error
        type(html_page_t) :: page, chapters
        character(:), allocatable :: html

        call make_page(chapters)
        call page%begin('Title', 'lead')
        call page%chapter('summary', 'Summary')
        call page%append(chapters)
        call page%chapter('last', 'Last')
        html = page%document()
        call check_balance(error, html)
        if (allocated(error)) return
        call check(error, index(html, 'id="summary"') < index(html, 'id="first"') .and. &
                   index(html, 'id="second"') < index(html, 'id="last"'), 'order of the chapters')
        if (allocated(error)) return
        call check(error, index(html, '<a href="#second">') > 0 .and. index(html, '<title>Title') > 0)
    end subroutine test_appended

    !> Names carry the figure's, fixed sizes and gnuplot's own title are gone, empty groups too.
    subroutine test_inline_svg(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: html

        html = inline_svg(svg_text(), 'f', 'A "title"', 'What it < shows')
        call check_text(error, html, '<svg role="img" aria-labelledby="f_title f_desc" viewBox="0 0 600 300" '// &
                        'xmlns="http://www.w3.org/2000/svg">'//LF//'<title id="f_title">A &quot;title&quot;</title>'//LF// &
                        '<desc id="f_desc">What it &lt; shows</desc>'//LF//LF//LF//'<g id="f_canvas">'//LF// &
                        "<path id='f_p' d='M0,0'/>"//LF// &
                        "<use href='#f_p'/><use xlink:href=""#f_canvas"" filter='url(#f_box)'/>"//LF// &
                        '<g a="1">'//LF//'<text>x</text>'//LF//'</g>'//LF//'</g>'//LF//'</svg>')
        if (allocated(error)) return
        call check_text(error, inline_svg('no figure', 'f', 'a', 'b'), '')
    end subroutine test_inline_svg

    !> Colours as gnuplot writes them, and on the style sheet for dark pages.
    subroutine test_colours(error)
        type(error_type), allocatable, intent(out) :: error
        type(html_page_t) :: page
        character(:), allocatable :: html
        integer :: i

        call check_text(error, gnuplot_rgb('#0072b2', of_text=.false.), 'rgb(  0, 114, 178)')
        if (allocated(error)) return
        call check_text(error, gnuplot_rgb('#595959', of_text=.true.), 'rgb(89,89,89)')
        if (allocated(error)) return
        call page%begin('a', 'b')
        html = page%document()
        do i = 1, size(PALETTE)
            call check(error, index(html, '[stroke="'//gnuplot_rgb(PALETTE(i)%light, .false.)//'"]{stroke:'// &
                                    PALETTE(i)%dark//'}') > 0, PALETTE(i)%name)
            if (allocated(error)) return
            call check(error, contrast(PALETTE(i)%light, '#ffffff') >= 3 .neqv. PALETTE(i)%name == 'band', &
                       PALETTE(i)%name//' on white')
            if (allocated(error)) return
            call check(error, contrast(PALETTE(i)%dark, '#14181d') >= 3 .neqv. PALETTE(i)%name == 'band', &
                       PALETTE(i)%name//' on dark')
            if (allocated(error)) return
        end do
    end subroutine test_colours

    !> Contrast ratio of WCAG 2.
    real function contrast(a, b)
        character(7), intent(in) :: a, b

        real :: lighter, darker

        lighter = max(luminance(a), luminance(b))
        darker = min(luminance(a), luminance(b))
        contrast = (lighter + 0.05)/(darker + 0.05)
    end function contrast

    real function luminance(colour)
        character(7), intent(in) :: colour

        integer :: part(3)
        real :: linear(3)

        read (colour, '(1x, 3z2)') part
        linear = part/255.0
        where (linear <= 0.04045)
            linear = linear/12.92
        elsewhere
            linear = ((linear + 0.055)/1.055)**2.4
        end where
        luminance = dot_product([0.2126, 0.7152, 0.0722], linear)
    end function luminance

    subroutine test_file(error)
        type(error_type), allocatable, intent(out) :: error
        type(html_page_t) :: page
        type(error_t), allocatable :: failure
        type(text_file_t) :: file

        call make_page(page)
        call page%write(FOLDER//'no-such-folder/page.html', failure)
        call check_fails(error, message_of(failure), [character(20) :: 'no-such-folder', 'no folder'])
        if (.not. allocated(error)) call make_folder(error)
        if (allocated(error)) return
        call page%write(FOLDER//'page.html', failure)
        if (.not. allocated(failure)) call read_text_file(FOLDER//'page.html', file, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check_text(error, file%text, page%document()//LF)
    end subroutine test_file
end module test_html
