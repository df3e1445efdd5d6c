!> The digits with which a real number is written: the fewest that read back as the same number, without
!> reading back.
!>
!> A decimal reads back as x when it lies within half the spacing of the reals around x (a quarter below a
!> power of two). 17 digits always suffice, and a decimal of 15 digits or fewer that reads back as x is x rounded
!> to 15 (D. Goldberg, ACM Computing Surveys 23 (1991) 5-48). So x 10^k is computed once, with twice the digits of
!> double precision; the decimals of 15, 16 and 17 digits below and above it follow from its whole part, and how
!> far each is from x is known to 1e-14 of the last digit. Of two that read back the nearer is taken.
module gracecg_base_shortest_decimal
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_double_double, only: exact_product, exact_power
    implicit none
    private
    public :: shortest_digits, MOST_DIGITS

    integer, parameter :: MOST_DIGITS = 17          !! Always enough to tell two numbers apart
    integer(i8), parameter :: LEAST = 10_i8**(MOST_DIGITS - 1)  ! of 17 digits
    real(dp), parameter :: DOUBT = 1e-6_dp          ! nearer to a limit, in the 17th digit, nothing is said

contains

    !> The digits as a whole number: x is digits times 10^exponent. Not sure: outside of 1e-28 to 1e16, or where
    !> a decimal lies on the border of what reads back as x.
    pure subroutine shortest_digits(x, digits, exponent, sure)
        real(dp), intent(in) :: x               !! Positive and finite
        integer(i8), intent(out) :: digits      !! At most 17; may end with zeros
        integer, intent(out) :: exponent        !! Of the last digit
        logical, intent(out) :: sure            !! Whether the digits are those wanted

        real(dp) :: large, small, tens, more_tens, rest, below, above, border_below, border_above
        integer(i8) :: whole, unit
        integer :: excess, decade, scale

        digits = 0
        exponent = 0
        sure = .false.
        if (.not. (x > 1e-28_dp .and. x < 1e16_dp)) return
        decade = floor(log10(x))
        scale = MOST_DIGITS - 1 - decade        ! 1 to 44
        call exact_power(scale, tens, more_tens)
        call exact_product(x, tens, large, small)
        small = small + x*more_tens
        unit = floor(small + 0.5_dp, i8)
        whole = int(large, i8) + unit               ! large has no fraction: it is above 2^53
        rest = small - real(unit, dp)
        if (whole < LEAST .or. whole >= 10*LEAST) return    ! next to a power of ten
        border_above = 0.5_dp*spacing(x)*tens       ! in units of the 17th digit
        border_below = merge(border_above/2, border_above, fraction(x) <= 0.5_dp)
        do excess = 2, 0, -1
            unit = 10_i8**excess
            digits = whole/unit
            below = real(whole - digits*unit, dp) + rest    ! from the decimal below x to x
            above = unit - below                            ! from x to the decimal above
            exponent = excess - scale
            sure = min(abs(above - border_above), abs(below - border_below)) > DOUBT
            if (.not. sure) return
            if (above < border_above .and. (above <= below .or. below > border_below)) then
                digits = digits + 1
                return
            else if (below < border_below) then
                return
            end if
        end do
        sure = .false.
    end subroutine shortest_digits
end module gracecg_base_shortest_decimal
