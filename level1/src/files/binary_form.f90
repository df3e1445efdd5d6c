!> The fields of Level-1 records in binary: bytes, most significant first, read and written.
module gracecg_level1_binary_form
    use, intrinsic :: iso_fortran_env, only: real32
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use gracecg_base_kinds, only: dp, i4, i8
    use gracecg_level1_products, only: level1_field_t, KIND_I1, KIND_I2, KIND_I4, KIND_U2, KIND_U4, KIND_F4, KIND_F8, &
        KIND_NUMERAL, KIND_FLAG32
    implicit none
    private
    public :: read_bytes, unsigned_at, put_bytes, BLOCK_NUMBERS

    !> Text has at least 10 digits of a number of single precision (16, housekeeping 10): more than that is a loss
    real(dp), parameter :: TEXT_DIGITS = 5e-10_dp
    !> A block number of GRACE-FO text counts on where that of binary begins anew
    integer, parameter :: BLOCK_NUMBERS = 65536
    integer(i8), parameter :: LOW_WORD = 4294967295_i8

contains

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
                double = ior(shiftl(int(word_at(bytes(at:at + 3)), i8), 32), &
                             iand(int(word_at(bytes(at + 4:at + 7)), i8), LOW_WORD))
                values(i) = transfer(double, 1.0_dp)
                if (iand(shiftr(double, 52), 2047_i8) == 2047) then
                    values(i) = ieee_value(1.0_dp, ieee_quiet_nan)
                    not_finite = not_finite + 1
                end if
                at = at + length
            end do
        case (KIND_F4)
            do i = 1, size(values)
                word = word_at(bytes(at:at + 3))
                values(i) = real(transfer(word, 1.0_real32), dp)
                if (iand(shiftr(word, 23), 255) == 255) then
                    values(i) = ieee_value(1.0_dp, ieee_quiet_nan)
                    not_finite = not_finite + 1
                end if
                at = at + length
            end do
        case (KIND_I4, KIND_U4, KIND_FLAG32)
            do i = 1, size(values)
                values(i) = word_at(bytes(at:at + 3))
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
    pure integer(i4) function word_at(bytes) result(word)
        character(4), intent(in) :: bytes

        word = ior(ior(shiftl(iachar(bytes(1:1)), 24), shiftl(iachar(bytes(2:2)), 16)), &
                   ior(shiftl(iachar(bytes(3:3)), 8), iachar(bytes(4:4))))
    end function word_at

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
end module gracecg_level1_binary_form
