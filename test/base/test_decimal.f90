!> Decimal numbers: the nearest real number, whatever the way to it.
module test_decimal
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_text, only: parse_real, integer_text
    use gracecg_base_decimal, only: scan_real, scan_integer
    use gracecg_base_random, only: random_stream_t, new_stream
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_decimal

contains

    subroutine collect_decimal(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('like-the-run-time-library', test_random), &
                    new_unittest('between-two-numbers', test_halfway), &
                    new_unittest('forms', test_forms), &
                    new_unittest('refused', test_refused), &
                    new_unittest('integers', test_integers)]
    end subroutine collect_decimal

    !> The same number as the run-time library gives, to the last bit.
    subroutine check_same(error, text)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: text

        real(dp) :: value, expected
        integer :: at
        logical :: ok, expected_ok

        at = 1
        call scan_real(text//' ', at, value, ok)
        call parse_real(text, expected, expected_ok)
        call check(error, ok .and. expected_ok .and. transfer(value, 0_i8) == transfer(expected, 0_i8), text)
        if (.not. allocated(error)) call check(error, at, len(text) + 1, text)
    end subroutine check_same

    !> Numbers of 1 to 20 digits with exponents of -50 to 50, the point anywhere.
    subroutine test_random(error)
        type(error_type), allocatable, intent(out) :: error

        type(random_stream_t) :: stream
        real(dp) :: u(4)
        character(:), allocatable :: digits, text
        integer :: i, k, point

        stream = new_stream(1_i8, 0, 0, 1, 1)
        do i = 1, 40000
            do k = 1, 4
                u(k) = stream%uniform()
            end do
            digits = ''
            do k = 1, 1 + int(20*u(1))
                digits = digits//achar(iachar('0') + int(10*stream%uniform()))
            end do
            point = int(len(digits)*u(2))
            text = digits(:point)//'.'//digits(point + 1:)//'e'//integer_text(int(101*u(3)) - 50)
            if (u(4) < 0.5_dp) text = '-'//text
            call check_same(error, text)
            if (allocated(error)) return
        end do
    end subroutine test_random

    !> Numbers near the middle between two neighbours, where twice the precision may not tell.
    subroutine test_halfway(error)
        type(error_type), allocatable, intent(out) :: error

        character(32), parameter :: HARD(10) = [character(32) :: '9007199254740993', '9007199254740992.99999999999', &
                                                '9007199254740993.0000000001', '900719925474099301', &
                                                '4503599627370496.5', '4503599627370497.5', '1.0000000000000002e23', &
                                                '8.5e22', '123456789012345678e-45', '999999999999999999e45']
        integer :: i

        do i = 1, size(HARD)
            call check_same(error, trim(HARD(i)))
            if (allocated(error)) return
        end do
    end subroutine test_halfway

    subroutine test_forms(error)
        type(error_type), allocatable, intent(out) :: error

        character(24), parameter :: FORMS(12) = [character(24) :: '0', '-0.0', '+7', '7.', '.5', '1e+33', '1D-3', &
                                                 '000000000000000000000001', '0.000000000000000000001', '1e-320', &
                                                 '65000', '-137.4900054931641']
        integer :: i

        do i = 1, size(FORMS)
            call check_same(error, trim(FORMS(i)))
            if (allocated(error)) return
        end do
    end subroutine test_forms

    subroutine test_refused(error)
        type(error_type), allocatable, intent(out) :: error

        character(12), parameter :: WRONG(10) = [character(12) :: '.', '-', 'e5', '1e', '1.2.3', '1,5', 'nan', '1e400', &
                                                 '12x', '--1']
        real(dp) :: value
        integer :: i, at
        logical :: ok

        do i = 1, size(WRONG)
            at = 1
            call scan_real(trim(WRONG(i))//' ', at, value, ok)
            call check(error, .not. ok, WRONG(i))
            if (.not. allocated(error)) call check(error, at, len_trim(WRONG(i)) + 1, WRONG(i))
            if (allocated(error)) return
        end do
    end subroutine test_refused

    subroutine test_integers(error)
        type(error_type), allocatable, intent(out) :: error

        character(24), parameter :: WRONG(6) = [character(24) :: '', '-', '1.5', '12a', '1234567890123456789', '+-1']
        integer(i8) :: value
        integer :: i, at
        logical :: ok

        at = 2
        call scan_integer(' -123456789012345678'//achar(10), at, value, ok)
        call check(error, ok .and. value == -123456789012345678_i8 .and. at == 21)
        do i = 1, size(WRONG)
            if (allocated(error)) return
            at = 1
            call scan_integer(trim(WRONG(i))//' ', at, value, ok)
            call check(error, .not. ok, WRONG(i))
        end do
    end subroutine test_integers
end module test_decimal
