!> The fields of Level-1 records, read and written: a word each of text, bytes of binary, most significant first.
module gracecg_level1_field_forms
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use, intrinsic :: iso_fortran_env, only: real32
    use gracecg_level1_basics
    use gracecg_base_decimal, only: scan_real, scan_integer, is_white, shortest_digits
    use gracecg_base_kinds, only: i4
    use gracecg_level1_header, only: printable
    use gracecg_level1_products, only: KIND_F4, KIND_F8, KIND_LETTER, KIND_FLAG8, KIND_FLAG32, level1_field_t, &
        KIND_I1, KIND_I2, KIND_I4, KIND_U2, KIND_U4, KIND_NUMERAL
    implicit none
    private
    public :: read_word, word_at, skip_white, put_word, general_text, read_bytes, unsigned_at, put_bytes, &
        BLOCK_NUMBERS

    character(1), parameter :: LF = achar(10)
    integer, parameter :: LONGEST_WORD = 60     !! That messages show
    !> Range of the integers of each kind. A block number of GRACE-FO text exceeds the 16 bits of GRACE
    integer(i8), parameter :: LOWEST(12) = [-128_i8, -32768_i8, -2147483648_i8, 0_i8, 0_i8, 0_i8, 0_i8, 0_i8, 0_i8, &
                                            0_i8, 0_i8, 0_i8]
    integer(i8), parameter :: HIGHEST(12) = [127_i8, 32767_i8, 2147483647_i8, 255_i8, 4294967295_i8, 4294967295_i8, &
                                             0_i8, 0_i8, 0_i8, 9_i8, 255_i8, 4294967295_i8]

    !> Text has at least 10 digits of a number of single precision (16, housekeeping 10): more than that is a loss
    real(dp), parameter :: TEXT_DIGITS = 5e-10_dp
    !> A block number of GRACE-FO text counts on where that of binary begins anew
    integer, parameter :: BLOCK_NUMBERS = 65536
    integer(i8), parameter :: LOW_WORD = 4294967295_i8

contains

    !> Reads the word that begins at `at`, which then stands behind it.
    subroutine read_word(text, at, kind, value, problem)
        character(*), intent(in) :: text        !! Ends with a line feed
        integer, intent(inout) :: at            !! Place in the text
        integer, intent(in) :: kind             !! Of the field, KIND_...
        real(dp), intent(out) :: value          !! Letters as their codes, flags as integers; NaN: no finite number
        character(:), allocatable, intent(inout) :: problem     !! Allocated when it is wrong

        integer :: first
        integer(i8) :: number
        logical :: ok

        first = at
        select case (kind)
        case (KIND_F8, KIND_F4)
            call scan_real(text, at, value, ok)
            if (ok) return
            value = ieee_value(1.0_dp, ieee_quiet_nan)
            if (.not. is_no_number(text(first:at - 1))) &
                problem = '"'//printable(text(first:at - 1))//'" is not a decimal number'
            if (allocated(problem) .and. verify(text(first:at - 1), '*') == 0) problem = problem// &
                ': stars stand where a number was too long when the file was written; take the line out, or correct it'
        case (KIND_LETTER)
            value = iachar(text(at:at))
            at = at + 1
            if (text(first:first) < 'A' .or. text(first:first) > 'Z' .or. .not. is_end(text(at:at))) &
                problem = '"'//word_at(text, first)//'" is not one letter, A to Z'
        case (KIND_FLAG8, KIND_FLAG32)
            call read_flag(text, at, merge(8, 32, kind == KIND_FLAG8), number, ok)
            if (.not. ok) problem = '"'//word_at(text, first)//'" is not a flag of '// &
                integer_text(merge(8, 32, kind == KIND_FLAG8))//' binary digits'
            value = real(number, dp)
        case default
            call scan_integer(text, at, number, ok)
            if (ok) ok = number >= LOWEST(kind) .and. number <= HIGHEST(kind)
            if (.not. ok) problem = '"'//word_at(text, first)//'" is not an integer from '// &
                integer_text(LOWEST(kind))//' to '//integer_text(HIGHEST(kind))
            value = real(number, dp)
        end select
    end subroutine read_word

    !> A flag of so many binary digits, bit 0 rightmost.
    pure subroutine read_flag(text, at, digits, number, ok)
        character(*), intent(in) :: text
        integer, intent(inout) :: at
        integer, intent(in) :: digits
        integer(i8), intent(out) :: number
        logical, intent(out) :: ok

        integer :: i, digit

        number = 0
        ok = .false.
        do i = 1, digits
            digit = iachar(text(at:at)) - iachar('0')
            if (digit < 0 .or. digit > 1) return
            number = 2*number + digit
            at = at + 1
        end do
        ok = is_end(text(at:at))
    end subroutine read_flag

    !> Whether a word stands for a value that is no finite number, as programs print it.
    pure logical function is_no_number(word)
        character(*), intent(in) :: word

        is_no_number = any(lower_case(word) == [character(5) :: 'nan', '+nan', '-nan', 'inf', '+inf', '-inf'])
    end function is_no_number

    pure logical function is_end(letter)
        character(1), intent(in) :: letter

        is_end = is_white(letter) .or. letter == LF
    end function is_end

    !> To the next byte that is no white space.
    pure subroutine skip_white(text, at)
        character(*), intent(in) :: text        !! Ends with a line feed
        integer, intent(inout) :: at            !! Place in the text

        do while (is_white(text(at:at)))
            at = at + 1
        end do
    end subroutine skip_white

    !> The place behind a word, which is not longer than the longest.
    pure integer function end_of_word(text, first) result(place)
        character(*), intent(in) :: text        !! Ends with a line feed
        integer, intent(in) :: first            !! Place of its first letter

        place = first
        do while (.not. is_end(text(place:place)) .and. place < first + LONGEST_WORD)
            place = place + 1
        end do
    end function end_of_word

    !> The word that begins there, for a message.
    pure function word_at(text, first) result(word)
        character(*), intent(in) :: text        !! Ends with a line feed
        integer, intent(in) :: first            !! Place of its first letter
        character(end_of_word(text, first) - first) :: word

        word = printable(text(first:end_of_word(text, first) - 1))
    end function word_at

    !> Writes a value and a blank.
    subroutine put_word(value, kind, text, length)
        real(dp), intent(in) :: value               !! As `read_word` gives it
        integer, intent(in) :: kind                 !! Of the field, KIND_...
        character(*), intent(inout) :: text         !! A record in the making
        integer, intent(inout) :: length            !! Of it, so far

        character(32) :: word
        integer :: i, last      ! bits

        select case (kind)
        case (KIND_F8, KIND_F4)
            word = general_text(value, kind == KIND_F4)
        case (KIND_LETTER)
            word = achar(nint(value))
        case (KIND_FLAG8, KIND_FLAG32)
            last = merge(7, 31, kind == KIND_FLAG8)
            word = ''
            do i = 0, last
                word(last - i + 1:last - i + 1) = merge('1', '0', btest(nint(value, i8), i))
            end do
        case default
            word = integer_text(nint(value, i8))
        end select
        text(length + 1:length + len_trim(word) + 1) = word
        length = length + len_trim(word) + 1
    end subroutine put_word

    !> A number in the form that official files have: -1.25e-05, 65000, 1e+33. The fewest of 15 to 17 digits that
    !> give the number back, without needless zeros; 16 always do for a number of single precision.
    function general_text(value, single) result(text)
        real(dp), intent(in) :: value       !! NaN is 'nan'
        logical, intent(in) :: single       !! It is one of single precision
        character(32) :: text

        character(20) :: digits
        character(22) :: rounded
        integer(i8) :: number
        integer :: exponent, last

        text = 'nan'
        if (.not. abs(value) <= huge(value)) return
        text = '0'
        if (abs(value) <= 0) return
        call shortest_digits(abs(value), number, exponent)
        digits = integer_text(number)
        exponent = exponent + len_trim(digits) - 1      ! of the first digit
        if (single .and. len_trim(digits) > 15) then
            write (rounded, '(es22.15e3)') abs(value)
            digits = rounded(1:1)//rounded(3:17)
        end if
        last = verify(trim(digits), '0', back=.true.)
        if (exponent < -4 .or. exponent >= 16) then
            text = digits(1:1)
            if (last > 1) text = digits(1:1)//'.'//digits(2:last)
            text = trim(text)//'e'//merge('-', '+', exponent < 0)//repeat('0', merge(1, 0, abs(exponent) < 10))// &
                integer_text(abs(exponent))
        else if (exponent < 0) then
            text = '0.'//repeat('0', -exponent - 1)//digits(:last)
        else if (last <= exponent + 1) then
            text = digits(:last)//repeat('0', exponent + 1 - last)
        else
            text = digits(:exponent + 1)//'.'//digits(exponent + 2:last)
        end if
        if (value < 0) text = '-'//trim(text)
    end function general_text

    !> One field of records of equal length, one after the other.
    pure subroutine read_bytes(bytes, offset, length, kind, values, not_finite)
        character(*), intent(in) :: bytes           !! The records
        integer, intent(in) :: offset, length       !! Of the field in a record, and of a record
        integer, intent(in) :: kind                 !! Of the field, KIND_...
        real(dp), intent(out) :: values(:)          !! As many as records; NaN: no finite number
        integer(i8), intent(inout) :: not_finite    !! Counts the values that are no finite numbers

        integer :: i, at
        integer(i4) :: word
        integer(i8) :: double

        at = offset + 1
        select case (kind)
        case (KIND_F8)
            do i = 1, size(values)
                double = ior(shiftl(int(signed_at(bytes(at:at + 3)), i8), 32), &
                             iand(int(signed_at(bytes(at + 4:at + 7)), i8), LOW_WORD))
                values(i) = transfer(double, 1.0_dp)
                if (iand(shiftr(double, 52), 2047_i8) == 2047) then
                    values(i) = ieee_value(1.0_dp, ieee_quiet_nan)
                    not_finite = not_finite + 1
                end if
                at = at + length
            end do
        case (KIND_F4)
            do i = 1, size(values)
                word = signed_at(bytes(at:at + 3))
                values(i) = real(transfer(word, 1.0_real32), dp)
                if (iand(shiftr(word, 23), 255) == 255) then
                    values(i) = ieee_value(1.0_dp, ieee_quiet_nan)
                    not_finite = not_finite + 1
                end if
                at = at + length
            end do
        case (KIND_I4, KIND_U4, KIND_FLAG32)
            do i = 1, size(values)
                values(i) = signed_at(bytes(at:at + 3))
                if (kind /= KIND_I4 .and. values(i) < 0) values(i) = values(i) + 2.0_dp**32
                at = at + length
            end do
        case (KIND_I2, KIND_U2)
            do i = 1, size(values)
                values(i) = ior(shiftl(iachar(bytes(at:at)), 8), iachar(bytes(at + 1:at + 1)))
                if (kind == KIND_I2 .and. values(i) >= 2**15) values(i) = values(i) - 2**16
                at = at + length
            end do
        case default
            do i = 1, size(values)
                values(i) = iachar(bytes(at:at))
                if (kind == KIND_I1 .and. values(i) >= 2**7) values(i) = values(i) - 2**8
                if (kind == KIND_NUMERAL) values(i) = values(i) - iachar('0')
                at = at + length
            end do
        end select
    end subroutine read_bytes

    !> Four bytes as a signed integer.
    pure integer(i4) function signed_at(bytes) result(word)
        character(4), intent(in) :: bytes

        word = ior(ior(shiftl(iachar(bytes(1:1)), 24), shiftl(iachar(bytes(2:2)), 16)), &
                   ior(shiftl(iachar(bytes(3:3)), 8), iachar(bytes(4:4))))
    end function signed_at

    !> An unsigned integer of up to four bytes.
    pure integer(i8) function unsigned_at(bytes) result(number)
        character(*), intent(in) :: bytes       !! Most significant first

        integer :: i

        number = 0
        do i = 1, len(bytes)
            number = ior(shiftl(number, 8), int(iachar(bytes(i:i)), i8))
        end do
    end function unsigned_at

    !> Writes the bytes of a value. A block number of more than 16 bits begins anew.
    pure subroutine put_bytes(value, field, record, length, is_rounded, is_too_large)
        real(dp), intent(in) :: value                   !! As `read_bytes` gives it
        type(level1_field_t), intent(in) :: field
        character(*), intent(inout) :: record           !! A record in the making
        integer, intent(inout) :: length                !! Of it, so far
        logical, intent(out) :: is_rounded              !! Digits that text has are lost in single precision
        logical, intent(out) :: is_too_large            !! For single precision: nothing is written

        integer(i8) :: word
        real(real32) :: single
        integer :: i

        is_rounded = .false.
        is_too_large = field%kind == KIND_F4 .and. abs(value) > huge(single)
        if (is_too_large) return
        select case (field%kind)
        case (KIND_F8)
            word = transfer(value, word)
        case (KIND_F4)
            single = real(value, real32)
            is_rounded = abs(real(single, dp) - value) > TEXT_DIGITS*abs(value)
            word = transfer(single, 0_i4)
        case (KIND_NUMERAL)
            word = nint(value, i8) + iachar('0')
        case default
            word = nint(value, i8)
        end select
        do i = field%bytes - 1, 0, -1
            length = length + 1
            record(length:length) = achar(int(ibits(word, 8*i, 8)))
        end do
    end subroutine put_bytes
end module gracecg_level1_field_forms
