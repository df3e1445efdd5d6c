!> Decimal numbers in texts: read as the nearest real number, always, and written with the fewest digits that read back
!> as the same number. Both quickly, for long files.
!>
!> Reading: up to 18 digits make an integer m, and the number is m 10^e. Where m has at most 53 bits and |e| <= 22, both
!> are exact in double precision and one operation rounds correctly (W. D. Clinger, "How to read floating point numbers
!> accurately", PLDI 1990). Otherwise the run-time library decides.
!>
!> Writing: a decimal reads back as x when it lies within half the spacing of the reals around x (a quarter below a power
!> of two). 17 digits always suffice, and a decimal of 15 digits or fewer that reads back as x is x rounded to 15 (D.
!> Goldberg, ACM Computing Surveys 23 (1991) 5-48). So x 10^k is computed once, with twice the digits of double precision;
!> the decimals of 15, 16 and 17 digits below and above it follow from its whole part, and how far each is from x is known
!> to 1e-14 of the last digit. Of two that read back the nearer is taken.
module gracecg_base_decimal
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp, i8
    implicit none
    private
    public :: scan_real, scan_integer, is_white, shortest_digits

    integer(i8), parameter :: FULL = 10_i8**17              !! From here on an integer of 64 bits takes no digit more
    integer(i8), parameter :: EXACT_INTEGER = 2_i8**53
    integer, parameter :: EXACT_TENS = 22                   !! Largest power of ten that is exact in double precision
    integer, parameter :: MOST_DIGITS = 17                  !! Always enough to tell two numbers apart
    integer(i8), parameter :: LEAST = 10_i8**(MOST_DIGITS - 1)  ! of 17 digits
    real(dp), parameter :: SPLITTER = 2.0_dp**27 + 1        ! of Dekker's product
    character(1), parameter :: LF = achar(10)
    !> The powers of ten that are exact
    real(dp), parameter :: POWER(0:EXACT_TENS) = [1e0_dp, 1e1_dp, 1e2_dp, 1e3_dp, 1e4_dp, 1e5_dp, 1e6_dp, 1e7_dp, 1e8_dp, &
                                                  1e9_dp, 1e10_dp, 1e11_dp, 1e12_dp, 1e13_dp, 1e14_dp, 1e15_dp, 1e16_dp, &
                                                  1e17_dp, 1e18_dp, 1e19_dp, 1e20_dp, 1e21_dp, 1e22_dp]

contains

    !> Blank, tab, carriage return and the like, but no line feed.
    elemental logical function is_white(letter)
        character(1), intent(in) :: letter  !! Of a text

        integer :: code

        code = iachar(letter)
        is_white = code == 32 .or. (code >= 9 .and. code <= 13 .and. code /= 10)
    end function is_white

    !> Reads the decimal number that begins at `at` and ends before white space or a line feed, one of which
    !> must follow in the text. Not ok: anything else than a decimal number that is finite.
    pure subroutine scan_real(text, at, value, ok)
        character(*), intent(in) :: text    !! Holds white space or a line feed behind the number
        integer, intent(inout) :: at        !! First character of the number; then the first one behind it
        real(dp), intent(out) :: value      !! The nearest number; 0 when not ok
        logical, intent(out) :: ok          !! False if there is no finite decimal number

        integer(i8) :: mantissa
        integer :: first, exponent, status
        logical :: negative, sure

        first = at
        value = 0
        call take_decimal(text, at, negative, mantissa, exponent, sure, ok)
        if (.not. ok) then
            at = behind_word(text, first)
        else if (sure .and. mantissa <= EXACT_INTEGER .and. abs(exponent) <= EXACT_TENS) then
            if (exponent < 0) then
                value = real(mantissa, dp)/POWER(-exponent)
            else
                value = real(mantissa, dp)*POWER(exponent)
            end if
            if (negative) value = -value
        else
            read (text(first:at - 1), *, iostat=status) value
            ok = status == 0 .and. ieee_is_finite(value)
            if (.not. ok) value = 0
        end if
    end subroutine scan_real

    !> Sign, digits and exponent of a decimal number: mantissa times 10^exponent, but for digits that were left out.
    pure subroutine take_decimal(text, at, negative, mantissa, exponent, sure, ok)
        character(*), intent(in) :: text
        integer, intent(inout) :: at
        logical, intent(out) :: negative
        integer(i8), intent(out) :: mantissa
        integer, intent(out) :: exponent
        logical, intent(out) :: sure            ! no digit but 0 was left out
        logical, intent(out) :: ok              ! it is a number

        integer(i8) :: scale
        integer :: begin, digits

        negative = text(at:at) == '-'
        if (negative .or. text(at:at) == '+') at = at + 1
        mantissa = 0
        exponent = 0
        sure = .true.
        begin = at
        call take_digits(text, at, mantissa, exponent, sure)
        digits = at - begin
        if (text(at:at) == '.') then
            at = at + 1
            begin = at
            call take_digits(text, at, mantissa, exponent, sure)
            digits = digits + at - begin
            exponent = exponent - (at - begin)
        end if
        ok = digits > 0
        select case (text(at:at))
        case ('e', 'E', 'd', 'D')
            at = at + 1
            if (ok) call scan_integer(text, at, scale, ok)
            if (ok) exponent = exponent + int(max(-99999_i8, min(99999_i8, scale)))
        case default
            ok = ok .and. ends(text(at:at))
        end select
    end subroutine take_decimal

    !> Takes digits as far as they go: those that find no room in the integer raise the exponent.
    pure subroutine take_digits(text, at, mantissa, exponent, sure)
        character(*), intent(in) :: text
        integer, intent(inout) :: at, exponent
        integer(i8), intent(inout) :: mantissa
        logical, intent(inout) :: sure          ! no digit but 0 was left out

        integer :: digit

        do
            digit = iachar(text(at:at)) - iachar('0')
            if (digit < 0 .or. digit > 9) exit
            if (mantissa < FULL) then
                mantissa = 10*mantissa + digit
            else
                exponent = exponent + 1
                sure = sure .and. digit == 0
            end if
            at = at + 1
        end do
    end subroutine take_digits

    !> Does a number end before this letter?
    elemental logical function ends(letter)
        character(1), intent(in) :: letter

        ends = is_white(letter) .or. letter == LF
    end function ends

    !> The place of the first white space or line feed.
    pure integer function behind_word(text, first) result(at)
        character(*), intent(in) :: text
        integer, intent(in) :: first

        at = first
        do while (.not. ends(text(at:at)))
            at = at + 1
        end do
    end function behind_word

    !> Reads the integer that begins at `at` and ends before white space or a line feed, one of which must
    !> follow in the text. Not ok: anything else, or more than 64 bits hold.
    pure subroutine scan_integer(text, at, value, ok)
        character(*), intent(in) :: text    !! Holds white space or a line feed behind the number
        integer, intent(inout) :: at        !! First character of the number; then the first one behind it
        integer(i8), intent(out) :: value   !! 0 when not ok
        logical, intent(out) :: ok          !! False if there is no such integer

        integer :: digit, first, begin
        logical :: negative

        first = at
        negative = text(at:at) == '-'
        if (negative .or. text(at:at) == '+') at = at + 1
        begin = at
        value = 0
        do
            digit = iachar(text(at:at)) - iachar('0')
            if (digit < 0 .or. digit > 9) exit
            if (value >= FULL) then
                if (value > (huge(value) - digit)/10) exit
            end if
            value = 10*value + digit
            at = at + 1
        end do
        ok = at > begin .and. ends(text(at:at))
        if (ok) then
            if (negative) value = -value
        else
            value = 0
            at = behind_word(text, first)
        end if
    end subroutine scan_integer

    !> The digits of x as a whole number: x is digits times 10^exponent.
    pure subroutine shortest_digits(x, digits, exponent)
        real(dp), intent(in) :: x               !! Positive and finite
        integer(i8), intent(out) :: digits      !! At most 17; may end with zeros
        integer, intent(out) :: exponent        !! Of the last digit

        logical :: sure

        call digits_at_once(x, digits, exponent, sure)
        if (.not. sure) call digits_by_trial(x, digits, exponent)
    end subroutine shortest_digits

    !> The same without reading back. Not sure: outside of 1e-28 to 1e16, or where a decimal lies on the border of what
    !> reads back as x.
    pure subroutine digits_at_once(x, digits, exponent, sure)
        real(dp), intent(in) :: x
        integer(i8), intent(out) :: digits
        integer, intent(out) :: exponent
        logical, intent(out) :: sure

        real(dp), parameter :: DOUBT = 1e-6_dp          ! nearer to a limit, in the 17th digit, nothing is said
        real(dp) :: large, small, tens, more_tens, rest, below, above, border_below, border_above
        integer(i8) :: whole, unit
        integer :: excess, scale

        digits = 0
        exponent = 0
        sure = .false.
        if (.not. (x > 1e-28_dp .and. x < 1e16_dp)) return
        scale = MOST_DIGITS - 1 - floor(log10(x))       ! 1 to 44, twice EXACT_TENS
        call exact_product(POWER(min(scale, EXACT_TENS)), POWER(scale - min(scale, EXACT_TENS)), tens, more_tens)
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
    end subroutine digits_at_once

    !> The first of 15, 16 and 17 digits that read back as x.
    pure subroutine digits_by_trial(x, digits, exponent)
        real(dp), intent(in) :: x
        integer(i8), intent(out) :: digits
        integer, intent(out) :: exponent

        character(*), parameter :: FORMATS(3) = ['(es32.14e4)', '(es32.15e4)', '(es32.16e4)']
        character(32) :: buffer
        real(dp) :: again
        integer :: i, point, letter

        do i = 1, size(FORMATS)
            write (buffer, FORMATS(i)) x
            read (buffer, *) again
            if (abs(again - x) <= 0) exit
        end do
        point = index(buffer, '.')
        letter = index(buffer, 'E')
        read (buffer(letter + 1:), *) exponent
        exponent = exponent - (letter - point - 1)
        buffer = buffer(:point - 1)//buffer(point + 1:letter - 1)
        read (buffer, *) digits
    end subroutine digits_by_trial

    !> a b = product + error, exactly: T. J. Dekker, Numer. Math. 18 (1971) 224-242.
    pure subroutine exact_product(a, b, product, error)
        real(dp), intent(in) :: a, b
        real(dp), intent(out) :: product, error

        real(dp) :: a1, a2, b1, b2

        product = a*b
        a1 = SPLITTER*a
        a1 = a1 - (a1 - a)
        a2 = a - a1
        b1 = SPLITTER*b
        b1 = b1 - (b1 - b)
        b2 = b - b1
        error = (((a1*b1 - product) + a1*b2) + a2*b1) + a2*b2
    end subroutine exact_product
end module gracecg_base_decimal
