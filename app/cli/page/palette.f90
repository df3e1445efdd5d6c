!> The colours of the figures: told apart by colour-blind eyes too (after Okabe and Ito, and Tol), each
!> with a brother for dark pages. On its page each has a contrast of 3 at least.
module gracecg_cli_palette
    implicit none
    private
    public :: colour_t, PALETTE, BLUE, ORANGE, GREEN, PURPLE, GREY, BAND, INK, gnuplot_rgb

    !> A colour of the figures on light and on dark ground.
    type :: colour_t
        character(6) :: name = ''       !! For the scripts of gnuplot
        character(7) :: light = ''      !! As #rrggbb, on white
        character(7) :: dark = ''       !! In its place on a dark page
    end type colour_t

    integer, parameter :: BLUE = 1, ORANGE = 2, GREEN = 3, PURPLE = 4      !! Curves, in this order
    integer, parameter :: GREY = 5      !! Printed limits, notes
    integer, parameter :: BAND = 6      !! Filled areas behind curves
    integer, parameter :: INK = 7       !! Marks in the colour of the text
    type(colour_t), parameter :: PALETTE(7) = [ &
        colour_t('blue', '#0072b2', '#5db9ee'), &
        colour_t('orange', '#c85200', '#ff9a4d'), &
        colour_t('green', '#008a64', '#45d6a6'), &
        colour_t('purple', '#aa3377', '#f08cc4'), &
        colour_t('grey', '#595959', '#aab2bc'), &
        colour_t('band', '#e6e6e6', '#2b323b'), &
        colour_t('ink', '#1b1f24', '#e6e9ed')]
    !! All colours of the figures

contains

    !> A colour #rrggbb as gnuplot writes it into SVG: rgb(  0, 114, 178) for lines and areas, rgb(0,114,178)
    !> for texts.
    pure function gnuplot_rgb(colour, of_text) result(text)
        character(7), intent(in) :: colour    !! As #rrggbb
        logical, intent(in) :: of_text    !! The form that gnuplot gives to text, not to lines
        character(:), allocatable :: text

        character(18) :: padded
        integer :: part(3), i

        read (colour, '(1x, 3z2)') part
        write (padded, '(a, i3, a, i3, a, i3, a)') 'rgb(', part(1), ', ', part(2), ', ', part(3), ')'
        text = padded
        if (.not. of_text) return
        text = ''
        do i = 1, len(padded)
            if (padded(i:i) /= ' ') text = text//padded(i:i)
        end do
    end function gnuplot_rgb
end module gracecg_cli_palette
