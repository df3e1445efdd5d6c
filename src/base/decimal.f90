!> Decimal numbers in long texts, read quickly: the nearest real number, always.
!>
!> Up to 18 digits make an integer m, and the number is m 10^e. Where m has at most 53 bits and |e| <= 22,
!> both are exact in double precision and one operation rounds correctly (W. D. Clinger, "How to read
!> floating point numbers accurately", PLDI 1990). Otherwise m and 10^|e| (exact as a sum of two reals up to
!> 10^45) are combined with twice the precision (gracecg_base_double_double); where even that leaves
!> open which of two neighbours is nearer, and for more digits or larger exponents, the run-time library decides.
module gracecg_base_decimal
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_text, only: parse_real
    use gracecg_base_double_double, only: exact_product, exact_power, POWER, EXACT_TENS, MOST_TENS
    implicit none
    private
    public :: scan_real, scan_integer, is_white

    integer, parameter :: MOST_DIGITS = 18      !! Of an integer of 64 bits
    integer(i8), parameter :: EXACT_INTEGER = 2_i8**53
    real(dp), parameter :: DOUBT = 2.0_dp**(-40)        !! Relative, far above the error of the small part
    character(1), parameter :: LF = achar(10)

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
    subroutine scan_real(text, at, value, ok)
        character(*), intent(in) :: text    !! Holds white space or a line feed behind the number
        integer, intent(inout) :: at        !! First character of the number; then the first one behind it
        real(dp), intent(out) :: value      !! The nearest number; 0 when not ok
        logical, intent(out) :: ok          !! False if there is no finite decimal number

        integer(i8) :: mantissa
        integer :: first, digits, kept, exponent, digit, scale, sign_of_scale
        logical :: negative, lost, sure

        first = at
        value = 0
        negative = text(at:at) == '-'
        if (negative .or. text(at:at) == '+') at = at + 1
        mantissa = 0
        digits = 0
        kept = 0
        exponent = 0
        lost = .false.
        do
            digit = iachar(text(at:at)) - iachar('0')
            if (digit < 0 .or. digit > 9) exit
            digits = digits + 1
            if (kept < MOST_DIGITS) then
                mantissa = 10*mantissa + digit
                if (mantissa > 0) kept = kept + 1
            else
                exponent = exponent + 1
                lost = lost .or. digit > 0
            end if
            at = at + 1
        end do
        if (text(at:at) == '.') then
            at = at + 1
            do
                digit = iachar(text(at:at)) - iachar('0')
                if (digit < 0 .or. digit > 9) exit
                digits = digits + 1
                if (kept < MOST_DIGITS) then
                    mantissa = 10*mantissa + digit
                    if (mantissa > 0) kept = kept + 1
                    exponent = exponent - 1
                else
                    lost = lost .or. digit > 0
                end if
                at = at + 1
            end do
        end if
        ok = digits > 0
        if (ok .and. is_exponent(text(at:at))) then
            at = at + 1
            sign_of_scale = 1
            if (text(at:at) == '-') sign_of_scale = -1
            if (text(at:at) == '-' .or. text(at:at) == '+') at = at + 1
            digits = 0
            scale = 0
            do
                digit = iachar(text(at:at)) - iachar('0')
                if (digit < 0 .or. digit > 9) exit
                digits = digits + 1
                scale = min(10*scale + digit, 99999)
                at = at + 1
            end do
            ok = digits > 0
            exponent = exponent + sign_of_scale*scale
        end if
        ok = ok .and. (is_white(text(at:at)) .or. text(at:at) == LF)
        if (.not. ok) then
            at = first + scan(text(first:), ' '//achar(9)//achar(11)//achar(12)//achar(13)//LF) - 1
            return
        end if
        sure = .not. lost
        if (sure) then
            if (mantissa == 0) then
                value = 0
            else if (mantissa <= EXACT_INTEGER .and. abs(exponent) <= EXACT_TENS) then
                if (exponent < 0) then
                    value = real(mantissa, dp)/POWER(-exponent)
                else
                    value = real(mantissa, dp)*POWER(exponent)
                end if
            else
                call scale_integer(mantissa, exponent, value, sure)
            end if
        end if
        if (.not. sure) then
            call parse_real(text(first:at - 1), value, ok)
        else if (negative) then
            value = -value
        end if
    end subroutine scan_real

    elemental logical function is_exponent(letter)
        character(1), intent(in) :: letter

        is_exponent = letter == 'e' .or. letter == 'E' .or. letter == 'd' .or. letter == 'D'
    end function is_exponent

    !> m 10^e to the nearest number. Not sure where twice the precision does not tell.
    pure subroutine scale_integer(m, e, value, sure)
        integer(i8), intent(in) :: m        !! 0 < m < 10^18
        integer, intent(in) :: e
        real(dp), intent(out) :: value
        logical, intent(out) :: sure

        real(dp) :: large, small, factor, rest, product, error, correction

        value = 0
        sure = abs(e) <= MOST_TENS
        if (.not. sure) return
        large = real(m, dp)
        small = real(m - int(large, i8), dp)
        call exact_power(abs(e), factor, rest)
        if (e >= 0) then
            call exact_product(large, factor, product, error)
            correction = error + (small*factor + large*rest)
        else
            value = large/factor
            call exact_product(value, factor, product, error)
            correction = ((((large - product) - error) + small) - value*rest)/factor
            product = value
        end if
        value = product + correction
        sure = abs((product + correction*(1 + DOUBT)) - (product + correction*(1 - DOUBT))) <= 0
    end subroutine scale_integer

    !> Reads the integer that begins at `at` and ends before white space or a line feed, one of which must
    !> follow in the text. Not ok: anything else, or more than 18 digits.
    pure subroutine scan_integer(text, at, value, ok)
        character(*), intent(in) :: text    !! Holds white space or a line feed behind the number
        integer, intent(inout) :: at        !! First character of the number; then the first one behind it
        integer(i8), intent(out) :: value   !! 0 when not ok
        logical, intent(out) :: ok          !! False if there is no such integer

        integer :: digits, digit, first
        logical :: negative

        first = at
        negative = text(at:at) == '-'
        if (negative .or. text(at:at) == '+') at = at + 1
        value = 0
        digits = 0
        do
            digit = iachar(text(at:at)) - iachar('0')
            if (digit < 0 .or. digit > 9) exit
            digits = digits + 1
            if (digits <= MOST_DIGITS) value = 10*value + digit
            at = at + 1
        end do
        ok = digits > 0 .and. digits <= MOST_DIGITS .and. (is_white(text(at:at)) .or. text(at:at) == LF)
        if (ok) then
            if (negative) value = -value
            return
        end if
        value = 0
        at = first + scan(text(first:), ' '//achar(9)//achar(11)//achar(12)//achar(13)//LF) - 1
    end subroutine scan_integer
end module gracecg_base_decimal
