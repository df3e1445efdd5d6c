!> The style sheet of the program's HTML pages: light and dark, phone and print.
!>
!> All pairs of text and background have a contrast of 4.5 at least. Figures are drawn once, in the
!> colours for light pages; on dark ones, rules of the style sheet give the same curves other colours.
module gracecg_cli_html_style
    use gracecg_cli_palette, only: PALETTE, gnuplot_rgb
    use gracecg_base_text, only: join
    implicit none
    private
    public :: style_sheet

    character(1), parameter :: LF = achar(10)
    character(*), parameter :: ATTRIBUTES(3) = [character(6) :: 'stroke', 'fill', 'color']
    !! Of SVG, in which gnuplot writes colours

    character(*), parameter :: RULES(78) = [character(118) :: &
        ':root{color-scheme:light dark;--paper:#ffffff;--ink:#1b1f24;--soft:#545b64;--rule:#d0d5db;--shade:#a3acb7;', &
        '--box:#f3f5f7;--link:#0550ae;--good:#0f6b35;--warn:#7a4f00;--bad:#a8201a}', &
        '*{box-sizing:border-box}', &
        'html{-webkit-text-size-adjust:100%;text-size-adjust:100%;scroll-padding-top:3.5rem}', &
        'body{margin:0 auto;max-width:88rem;background:var(--paper);color:var(--ink);overflow-wrap:break-word;', &
        'font:1rem/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"Liberation Sans",Arial,sans-serif}', &
        'header,section,nav{padding:0 1rem}', &
        'header{padding-top:1.25rem}', &
        'h1{font-size:1.75rem;line-height:1.25;margin:0 0 .75rem}', &
        'h2{font-size:1.35rem;line-height:1.3;margin:2.5rem 0 .75rem;padding-top:.75rem;border-top:1px solid var(--rule)}', &
        'h3{font-size:1.1rem;line-height:1.35;margin:2rem 0 .5rem}', &
        'p,ul,dl{margin:.6rem 0;max-width:46rem}', &
        'a{color:var(--link)}', &
        'code{font:.92em ui-monospace,"Liberation Mono",Menlo,Consolas,monospace;background:var(--box);padding:.05em .3em;', &
        'border-radius:.2em;overflow-wrap:anywhere}', &
        'pre{font:.85rem/1.5 ui-monospace,"Liberation Mono",Menlo,Consolas,monospace;padding:.75rem;--paper:var(--box);', &
        'border-radius:.3rem}', &
        'pre code{background:none;padding:0;font-size:1em}', &
        'ul.files{columns:4 14rem;padding-left:1.2rem;max-width:none}', &
        'details{margin:.5rem 0}summary{cursor:pointer}', &
        'td .value{color:var(--ink);display:inline-block;min-width:4.3em}', &
        'tbody tr.part{border-top:2px solid var(--soft)}', &
        'nav.bar{position:sticky;top:0;z-index:2;background:var(--paper);border-bottom:1px solid var(--rule);', &
        'padding-block:.6rem}', &
        'nav.bar a{margin-right:1.5rem}', &
        '#contents{margin-top:3rem;padding-bottom:3rem}', &
        '#contents h2{font-size:1.1rem;border:0;margin:0}', &
        '#contents ol{margin:0;padding-left:1.6rem;columns:2 18rem;column-gap:3rem}', &
        '#contents li{margin:.3rem 0;break-inside:avoid;line-height:1.35}', &
        'sup,sub{font-size:.75em;line-height:0}', &
        '.scroll{overflow-x:auto;margin:1rem 0;max-width:100%;scrollbar-width:thin;background-color:var(--paper);', &
        'background-image:linear-gradient(to right,var(--paper) 30%,transparent),', &
        'linear-gradient(to left,var(--paper) 30%,transparent),', &
        'linear-gradient(to right,var(--shade),transparent),linear-gradient(to left,var(--shade),transparent);', &
        'background-position:0 0,100% 0,0 0,100% 0;background-size:3rem 100%,3rem 100%,1rem 100%,1rem 100%;', &
        'background-repeat:no-repeat;background-attachment:local,local,scroll,scroll}', &
        'div.scroll{container-type:inline-size}', &
        '.scroll:focus-visible,a:focus-visible,summary:focus-visible{outline:2px solid var(--link);outline-offset:2px}', &
        'table{border-collapse:collapse;font-size:.9rem;line-height:1.35;font-variant-numeric:tabular-nums}', &
        'caption{text-align:left;font-weight:600;padding:.25rem 0 .5rem;font-size:1rem;', &
        'max-width:min(46rem,calc(100vw - 2rem));max-width:min(46rem,100cqw);position:sticky;left:0}', &
        'th,td{padding:.28rem .7rem;text-align:left;vertical-align:baseline;white-space:nowrap}', &
        'thead th{border-bottom:2px solid var(--rule);vertical-align:bottom;font-weight:600}', &
        'thead th[colspan]{white-space:normal}', &
        'th:first-child{position:sticky;left:0;background:var(--paper);padding-left:0}', &
        'tbody th{font-weight:500}', &
        'tbody tr{border-bottom:1px solid var(--rule)}', &
        'td.number,th.number{text-align:right}', &
        'td.wide{white-space:normal;min-width:14rem}', &
        '.met{color:var(--good)}.partly{color:var(--warn)}.missed{color:var(--bad)}.verdict{font-weight:600}', &
        'p.note{background:var(--box);border-left:4px solid var(--rule);padding:.5rem .8rem}', &
        'p.note.met{border-color:var(--good)}p.note.partly{border-color:var(--warn)}p.note.missed{border-color:var(--bad)}', &
        'p.note .rest{color:var(--ink);font-weight:400}', &
        'figure{margin:1.25rem 0;max-width:38rem}', &
        'figure svg{display:block;width:100%;height:auto;font-family:"Liberation Sans",Arial,Helvetica,sans-serif}', &
        'figcaption{color:var(--soft);font-size:.92rem;margin-top:.4rem}', &
        'figure .absent{border:1px dashed var(--soft);padding:1.5rem 1rem;margin:0;color:var(--soft)}', &
        '.drawing path{fill:none;stroke-linejoin:round;stroke-linecap:round}.drawing .thin{stroke-width:1.2}', &
        '.drawing .line{stroke-width:1.7}.drawing .bold{stroke-width:2.6}.drawing .dashed{stroke-dasharray:5 4}', &
        '.drawing .frame{stroke-width:1.4}.drawing{max-width:33rem}', &
        '@media screen and (min-width:75rem){html{scroll-padding-top:1rem}nav.bar{display:none}', &
        'body{display:grid;grid-template-columns:17rem minmax(0,1fr);align-items:start}header,main{grid-column:2}', &
        'header{padding-top:2rem}#contents{grid-column:1;grid-row:1/span 2;position:sticky;top:0;max-height:100vh;', &
        'overflow-y:auto;margin:0;padding-block:2rem;font-size:.92rem}#contents ol{columns:auto}}', &
        '@media screen and (max-width:40rem){h1{font-size:1.45rem}h2{font-size:1.2rem}figure{margin-inline:-1rem}', &
        'figcaption,figure .absent{margin-inline:1rem}', &
        'td.wide{min-width:11rem}th,td{padding:.28rem .4rem}th{white-space:normal}td.words{white-space:normal}', &
        'tbody th[rowspan],th.one{white-space:nowrap}.fits td{white-space:normal}', &
        '.stacks,.stacks caption,.stacks tbody,.stacks tr,.stacks th,.stacks td{display:block;padding:.1rem 0}', &
        '.stacks tr{padding:.4rem 0}.stacks thead{position:absolute;clip-path:inset(50%)}}', &
        '@media print{@page{size:A4;margin:18mm 16mm;@bottom-center{content:counter(page) " / " counter(pages);', &
        'font:9pt sans-serif;color:#545b64}}body{font-size:10pt}nav{display:none}header,section{padding:0}', &
        'h2,h3,h3+p{break-after:avoid}figure,tr,p.note{break-inside:avoid}figure{max-width:135mm}', &
        'figure svg{max-height:190mm}.scroll{overflow:visible;background:none}div.scroll{break-inside:avoid}', &
        'pre{white-space:pre-wrap}', &
        'table{font-size:8.5pt;max-width:100%}a{color:inherit;text-decoration:none}', &
        'th,td{padding:.15rem .35rem;white-space:normal}td.number{white-space:nowrap}', &
        'thead{display:table-header-group}th:first-child,caption{position:static}}']

    !> The classes of tools/drawings.py: fill of texts and areas, and stroke (s-...) of lines
    character(5), parameter :: DRAWN_AS(2, 8) = reshape([character(5) :: 'paper', 'paper', 'ink', 'ink', 'soft', &
        'soft', 'rule', 'rule', 'box', 'box', 'blue', 'link', 'green', 'good', 'red', 'bad'], [2, 8])
    !! Class, and the colour of the page in its place

    character(*), parameter :: DARK = &
        ':root{--paper:#14181d;--ink:#e6e9ed;--soft:#a9b1bb;--rule:#3a424c;--box:#1d232a;--link:#7cb7ff;'//LF// &
        '--shade:#79838f;--good:#6fd08c;--warn:#e3b341;--bad:#ff9a92}'//LF

contains

    !> The whole sheet, for a style element.
    function style_sheet() result(css)
        character(:), allocatable :: css

        integer :: i

        css = join(RULES, LF)//LF
        do i = 1, size(DRAWN_AS, 2)
            css = css//'.drawing .'//trim(DRAWN_AS(1, i))//'{fill:var(--'//trim(DRAWN_AS(2, i))//')}.drawing .s-'// &
                  trim(DRAWN_AS(1, i))//'{stroke:var(--'//trim(DRAWN_AS(2, i))//')}'//LF
        end do
        css = css//'@media screen and (prefers-color-scheme:dark){'//LF//DARK
        do i = 1, size(PALETTE)
            css = css//recoloured(gnuplot_rgb(PALETTE(i)%light, of_text=.false.), PALETTE(i)%dark)// &
                  recoloured(gnuplot_rgb(PALETTE(i)%light, of_text=.true.), PALETTE(i)%dark)
        end do
        css = css//recoloured('black', '#c9cfd6')//recoloured('rgb(190, 190, 190)', '#4a525c')// &
              recoloured('#ffffff', '#14181d')//recoloured('#FFFFFF', '#14181d')//'}'
    end function style_sheet

    !> Rules that replace a colour of the figures.
    function recoloured(from, to) result(css)
        character(*), intent(in) :: from, to
        character(:), allocatable :: css

        integer :: i

        css = ''
        do i = 1, size(ATTRIBUTES)
            css = css//'figure svg ['//trim(ATTRIBUTES(i))//'="'//from//'"]{'//trim(ATTRIBUTES(i))//':'//to//'}'
        end do
        css = css//LF
    end function recoloured
end module gracecg_cli_html_style
