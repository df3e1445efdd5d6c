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

    character(*), parameter :: RULES(58) = [character(118) :: &
        ':root{color-scheme:light dark;--paper:#ffffff;--ink:#1b1f24;--soft:#545b64;--rule:#d0d5db;', &
        '--box:#f3f5f7;--link:#0550ae;--good:#0f6b35;--warn:#7a4f00;--bad:#a8201a}', &
        '*{box-sizing:border-box}', &
        'html{-webkit-text-size-adjust:100%;text-size-adjust:100%}', &
        'body{margin:0;background:var(--paper);color:var(--ink);', &
        'font:1rem/1.55 system-ui,-apple-system,"Segoe UI",Roboto,"Liberation Sans",Arial,sans-serif;', &
        'overflow-wrap:break-word}', &
        'header,nav,main,footer{max-width:60rem;margin:0 auto;padding:0 1rem}', &
        'header{padding-top:2rem}', &
        'h1{font-size:1.75rem;line-height:1.25;margin:0 0 .75rem}', &
        'h2{font-size:1.35rem;line-height:1.3;margin:3rem 0 .75rem;padding-top:.75rem;border-top:1px solid var(--rule)}', &
        'h3{font-size:1.1rem;line-height:1.35;margin:2rem 0 .5rem}', &
        'p,ul,dl{margin:.6rem 0;max-width:46rem}', &
        'a{color:var(--link)}', &
        'code{font:.92em ui-monospace,"Liberation Mono",Menlo,Consolas,monospace;background:var(--box);padding:.05em .3em;', &
        'border-radius:.2em}', &
        'pre{font:.85rem/1.5 ui-monospace,"Liberation Mono",Menlo,Consolas,monospace;background:var(--box);padding:.75rem;', &
        'overflow-x:auto;border-radius:.3rem}', &
        'ul.files{columns:3 14rem;padding-left:1.2rem}', &
        'details{margin:.5rem 0}summary{cursor:pointer}', &
        'td .value{color:var(--ink);display:inline-block;min-width:4.3em}', &
        'tbody tr.part{border-top:2px solid var(--soft)}', &
        'pre code{background:none;padding:0;font-size:1em}', &
        'nav ol{columns:2 18rem;column-gap:3rem;margin:1rem 0;padding:.75rem 1rem .75rem 2.4rem;', &
        'background:var(--box);border-radius:.3rem}', &
        'nav li{margin:.15rem 0;break-inside:avoid}', &
        'sup,sub{font-size:.75em;line-height:0}', &
        '.scroll{overflow-x:auto;margin:1rem 0;max-width:100%}', &
        '.scroll:focus-visible,a:focus-visible{outline:2px solid var(--link);outline-offset:2px}', &
        'table{border-collapse:collapse;font-size:.9rem;line-height:1.35;font-variant-numeric:tabular-nums}', &
        'caption{text-align:left;font-weight:600;padding:.25rem 0 .5rem;font-size:1rem;', &
        'max-width:min(46rem,calc(100vw - 2rem))}', &
        'th,td{padding:.28rem .7rem;text-align:left;vertical-align:baseline;white-space:nowrap}', &
        'thead th{border-bottom:2px solid var(--rule);vertical-align:bottom;font-weight:600}', &
        'thead th[colspan]{white-space:normal}', &
        'tbody th{font-weight:500}', &
        'tbody tr{border-bottom:1px solid var(--rule)}', &
        'td.number,th.number{text-align:right}', &
        'td.wide{white-space:normal;min-width:14rem}', &
        '.met{color:var(--good)}.partly{color:var(--warn)}.missed{color:var(--bad)}.verdict{font-weight:600}', &
        'p.note{background:var(--box);border-left:4px solid var(--rule);padding:.5rem .8rem}', &
        'p.note.met{border-color:var(--good)}p.note.partly{border-color:var(--warn)}p.note.missed{border-color:var(--bad)}', &
        'p.note .rest{color:var(--ink);font-weight:400}', &
        'figure{margin:1.25rem 0;max-width:46rem}', &
        'figure svg{display:block;width:100%;height:auto;font-family:"Liberation Sans",Arial,Helvetica,sans-serif}', &
        'figcaption{color:var(--soft);font-size:.92rem;margin-top:.4rem}', &
        'figure .absent{border:1px dashed var(--soft);padding:1.5rem 1rem;margin:0;color:var(--soft)}', &
        'footer{margin-top:3rem;padding-bottom:3rem;color:var(--soft);font-size:.9rem}', &
        '@media (max-width:30rem){header{padding-top:1.25rem}h1{font-size:1.45rem}h2{font-size:1.2rem}', &
        'td.wide{min-width:11rem}th,td{padding:.28rem .45rem}tbody th{white-space:normal}', &
        'tbody th:first-child:not([rowspan]){min-width:8.5rem}tbody th[rowspan]{white-space:nowrap}', &
        'table.stacks,.stacks caption,.stacks tbody,.stacks tr,.stacks th,.stacks td{display:block;padding:.1rem 0}', &
        '.stacks tr{padding:.4rem 0}.stacks thead{position:absolute;clip-path:inset(50%)}}', &
        '@media print{@page{margin:16mm}body{font-size:10pt}nav ol{columns:2}', &
        'h2{break-before:page;border:0}section:first-of-type h2{break-before:auto}', &
        'h2,h3,h3+p{break-after:avoid}figure,tr,p.note{break-inside:avoid}figure{max-width:150mm}', &
        'figure svg{max-height:210mm}.scroll{overflow:visible}table{font-size:8.5pt}a{color:inherit}', &
        'th,td{padding:.15rem .4rem}thead{display:table-header-group}}']

    character(*), parameter :: DARK = &
        ':root{--paper:#14181d;--ink:#e6e9ed;--soft:#a9b1bb;--rule:#3a424c;--box:#1d232a;--link:#7cb7ff;'//LF// &
        '--good:#6fd08c;--warn:#e3b341;--bad:#ff9a92}'//LF

contains

    !> The whole sheet, for a style element.
    function style_sheet() result(css)
        character(:), allocatable :: css

        integer :: i

        css = join(RULES, LF)//LF//'@media screen and (prefers-color-scheme:dark){'//LF//DARK
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
