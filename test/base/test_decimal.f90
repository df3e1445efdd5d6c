!> Decimal numbers: the nearest real number, whatever the way to it; and the digits of a real number: they read back, no
!> fewer do, and none of that many are nearer.
module test_decimal
    use vocabulary
    use gracecg_base_decimal, only: scan_real, scan_integer, shortest_digits
    implicit none
    private
    public :: collect_decimal

    integer, parameter :: TRIALS = 20000    !! Of each kind of number

contains

    subroutine collect_decimal(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('like-the-run-time-library', test_random), &
                    new_unittest('between-two-numbers', test_halfway), &
                    new_unittest('integers', test_integers), &
                    new_unittest('digits-of-samples', test_samples), &
                    new_unittest('digits-of-short-decimals', test_short), &
                    new_unittest('digits-of-powers-of-two-and-far-numbers', test_powers_of_two)]
    end subroutine collect_decimal

    !> The same number as the run-time library gives, to the last bit.
    subroutine check_same(error, text)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: text
        real(dp) :: value, expected
        integer :: at, status
        logical :: ok

        at = 1
        call scan_real(text//' ', at, value, ok)
        read (text, *, iostat=status) expected
        call check(error, ok .and. status == 0 .and. transfer(value, 0_i8) == transfer(expected, 0_i8), text)
        call check(error, at, len(text) + 1, text)
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
        end do
    end subroutine test_halfway

    subroutine test_integers(error)
        type(error_type), allocatable, intent(out) :: error
        character(24), parameter :: WRONG(6) = [character(24) :: '', '-', '1.5', '12a', '9223372036854775808', '+-1']
        integer(i8) :: value
        integer :: i, at
        logical :: ok

        at = 2
        call scan_integer(' -123456789012345678'//achar(10), at, value, ok)
        call check(error, ok .and. value == -123456789012345678_i8 .and. at == 21)
        do i = 1, size(WRONG)
            at = 1
            call scan_integer(trim(WRONG(i))//' ', at, value, ok)
            call check(error, .not. ok, WRONG(i))
        end do
    end subroutine test_integers

    !> Does m 10^e read back as x?
    logical function reads_back(m, e, x)
        integer(i8), intent(in) :: m
        integer, intent(in) :: e
        real(dp), intent(in) :: x
        character(40) :: text
        real(dp) :: value

        text = integer_text(m)//'e'//integer_text(e)
        read (text, *) value
        reads_back = abs(value - x) <= 0
    end function reads_back

    !> What the digits of x have to be, by the run-time library's conversions: they read back; the decimals with
    !> one digit less around x do not; and a formatted write with as many digits gives the same, but for ties.
    subroutine check_digits(error, x)
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in) :: x
        character(40) :: written
        integer(i8) :: digits
        integer :: exponent, n

        call shortest_digits(x, digits, exponent)
        call check(error, reads_back(digits, exponent, x), 'does not read back')
        do while (mod(digits, 10_i8) == 0)
            digits = digits/10
            exponent = exponent + 1
        end do
        call check(error, .not. (reads_back(digits/10, exponent + 1, x) .or. &
                                 reads_back(digits/10 + 1, exponent + 1, x)), 'fewer digits read back')
        n = len(integer_text(digits))
        write (written, '(es40.'//integer_text(n - 1)//'e3)') x
        ! larger numbers may end in a 5 that is rounded up here and to even there
        if (fraction(x) > 0.5_dp .and. x < 1e6_dp) call check(error, reads_as(written, digits), written)
    end subroutine check_digits

    !> Has the text ' 1.234E-005' these digits?
    logical function reads_as(written, digits)
        character(*), intent(in) :: written
        integer(i8), intent(in) :: digits
        character(40) :: expected
        integer :: i, n

        expected = ''
        n = 0
        do i = 1, index(written, 'E') - 1
            if (index('0123456789', written(i:i)) == 0) cycle
            n = n + 1
            expected(n:n) = written(i:i)
        end do
        reads_as = expected == integer_text(digits)
    end function reads_as

    !> Numbers with all their bits, of most sizes that occur.
    subroutine test_samples(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: stream
        integer :: i

        stream = new_stream(3, 1, 1, 1, 1)
        do i = 1, TRIALS
            call check_digits(error, 10.0_dp**(43.9_dp*stream%uniform() - 27.95_dp))
        end do
    end subroutine test_samples

    !> Decimals of up to 15 digits come back as they were.
    subroutine test_short(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: stream
        real(dp) :: x
        integer(i8) :: m, digits
        integer :: i, e, exponent
        character(40) :: text

        stream = new_stream(4, 1, 1, 1, 1)
        do i = 1, TRIALS
            m = 1 + int(10.0_dp**(15*stream%uniform()), i8)
            if (mod(m, 10_i8) == 0) m = m + 1
            e = -int(25*stream%uniform())
            text = integer_text(m)//'e'//integer_text(e)
            read (text, *) x
            call shortest_digits(x, digits, exponent)
            do while (mod(digits, 10_i8) == 0)
                digits = digits/10
                exponent = exponent + 1
            end do
            call check(error, digits == m .and. exponent == e, integer_text(m)//'e'//integer_text(e))
        end do
    end subroutine test_short

    !> Powers of two and their neighbours: below them the reals lie twice as close.
    !> Numbers too large or too small for the quick way.
    subroutine test_powers_of_two(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: X(5) = [1e17_dp, 1e-29_dp, 1e22_dp/7, tiny(1.0_dp), huge(1.0_dp)]
        integer :: k, i

        do k = -90, 52
            call check_digits(error, 2.0_dp**k)
            call check_digits(error, nearest(2.0_dp**k, -1.0_dp))
            call check_digits(error, nearest(2.0_dp**k, 1.0_dp))
        end do
        do i = 1, size(X)
            call check_digits(error, X(i))
        end do
    end subroutine test_powers_of_two
end module test_decimal
