!> Decimal numbers in texts: read as the nearest real number, always, and written with the fewest digits that read back
!> as the same number. Both quickly, for long files.
!>
!> Reading: up to 18 digits make an integer m, and the number is m 10^e. Where m has at most 53 bits and |e| <= 22, both
!> are exact in double precision and one operation rounds correctly (W. D. Clinger, "How to read floating point numbers
!> accurately", PLDI 1990). Otherwise the run-time library decides.
!>
!> Writing: 17 digits always suffice, and a decimal of 15 digits or fewer that reads back as x is x rounded to 15 (D.
!> Goldberg, ACM Computing Surveys 23 (1991) 5-48). A decimal that is farther from x than half the spacing of the reals
!> there does not read back: so most need no trial.
module gracecg_base_decimal
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp, i8
    implicit none
    private
    public :: scan_real, scan_integer, is_white, shortest_digits

    integer(i8), parameter :: FULL = 10_i8**17              !! From here on an integer of 64 bits takes no digit more
    integer(i8), parameter :: EXACT_INTEGER = 2_i8**53
    integer, parameter :: EXACT_TENS = 22                   !! Largest power of ten that is exact in double precision
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

        character(32) :: buffer
        integer(i8) :: whole, unit
        real(dp) :: half_spacing, again
        integer :: last, excess, more

        write (buffer, '(es31.16e4)') x
        call take_digits_of(buffer, whole, last)
        half_spacing = 0.5_dp*spacing(x)*10.0_dp**(-last)   ! in units of the 17th digit
        do excess = 2, 0, -1
            unit = 10_i8**excess
            digits = (whole + unit/2)/unit
            exponent = last + excess
            if (excess == 0) return
            if (abs(digits*unit - whole) > half_spacing + 1) cycle
            if (excess == 1 .and. mod(whole, 10_i8) == 5) then      ! which of two is nearer 17 digits do not tell
                write (buffer, '(es31.15e4)') x
                call take_digits_of(buffer, digits, exponent)
            end if
            do more = 0, merge(1, 0, fraction(x) <= 0.5_dp)     ! above a power of two the reals lie farther apart
                digits = digits + more
                write (buffer, '(i0, a, i0)') digits, 'e', exponent
                read (buffer, *) again
                if (abs(again - x) <= 0) return
            end do
        end do

    contains

        pure subroutine take_digits_of(text, digits, exponent)
            character(*), intent(in) :: text
            integer(i8), intent(out) :: digits
            integer, intent(out) :: exponent

            integer :: at
            logical :: negative, sure, ok

            at = verify(text, ' ')
            call take_decimal(text, at, negative, digits, exponent, sure, ok)
        end subroutine take_digits_of
    end subroutine shortest_digits
end module gracecg_base_decimal
