!> The digits of a real number: they read back, no fewer do, and none of that many are nearer.
module test_shortest_decimal
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_text, only: parse_real, integer_text
    use gracecg_base_shortest_decimal, only: shortest_digits
    use gracecg_base_random, only: random_stream_t, new_stream
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_shortest_decimal

    integer, parameter :: TRIALS = 20000    !! Of each kind of number

contains

    subroutine collect_shortest_decimal(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('samples', test_samples), &
                    new_unittest('short-decimals', test_short), &
                    new_unittest('powers-of-two', test_powers_of_two), &
                    new_unittest('outside', test_outside)]
    end subroutine collect_shortest_decimal

    !> Does m 10^e read back as x?
    logical function reads_back(m, e, x)
        integer(i8), intent(in) :: m
        integer, intent(in) :: e
        real(dp), intent(in) :: x

        real(dp) :: value
        logical :: ok

        call parse_real(integer_text(m)//'e'//integer_text(e), value, ok)
        reads_back = ok .and. abs(value - x) <= 0
    end function reads_back

    !> What the digits of x have to be, by the run-time library's conversions: they read back; the decimals with
    !> one digit less around x do not; and a formatted write with as many digits gives the same, but for ties.
    subroutine check_digits(error, x)
        type(error_type), allocatable, intent(out) :: error
        real(dp), intent(in) :: x

        character(40) :: written
        integer(i8) :: digits
        integer :: exponent, n
        logical :: sure

        call shortest_digits(x, digits, exponent, sure)
        call check(error, sure, 'not sure')
        if (.not. allocated(error)) call check(error, reads_back(digits, exponent, x), 'does not read back')
        if (allocated(error)) return
        do while (mod(digits, 10_i8) == 0)
            digits = digits/10
            exponent = exponent + 1
        end do
        call check(error, .not. (reads_back(digits/10, exponent + 1, x) .or. &
                                 reads_back(digits/10 + 1, exponent + 1, x)), 'fewer digits read back')
        if (allocated(error)) return
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

    !> Numbers with all their bits, of every size that the digits are said for.
    subroutine test_samples(error)
        type(error_type), allocatable, intent(out) :: error

        type(random_stream_t) :: stream
        integer :: i

        stream = new_stream(3, 1, 1, 1, 1)
        do i = 1, TRIALS
            call check_digits(error, 10.0_dp**(43.9_dp*stream%uniform() - 27.95_dp))
            if (allocated(error)) return
        end do
    end subroutine test_samples

    !> Decimals of up to 15 digits come back as they were.
    subroutine test_short(error)
        type(error_type), allocatable, intent(out) :: error

        type(random_stream_t) :: stream
        real(dp) :: x
        integer(i8) :: m, digits
        integer :: i, e, exponent
        logical :: sure, ok

        stream = new_stream(4, 1, 1, 1, 1)
        do i = 1, TRIALS
            m = 1 + int(10.0_dp**(15*stream%uniform()), i8)
            if (mod(m, 10_i8) == 0) m = m + 1
            e = -int(25*stream%uniform())
            call parse_real(integer_text(m)//'e'//integer_text(e), x, ok)
            call shortest_digits(x, digits, exponent, sure)
            if (.not. sure) cycle
            do while (mod(digits, 10_i8) == 0)
                digits = digits/10
                exponent = exponent + 1
            end do
            call check(error, digits == m .and. exponent == e, integer_text(m)//'e'//integer_text(e))
            if (allocated(error)) return
        end do
    end subroutine test_short

    !> Powers of two and their neighbours: below them the reals lie twice as close.
    subroutine test_powers_of_two(error)
        type(error_type), allocatable, intent(out) :: error

        integer :: k

        do k = -90, 52
            call check_digits(error, 2.0_dp**k)
            if (.not. allocated(error)) call check_digits(error, nearest(2.0_dp**k, -1.0_dp))
            if (.not. allocated(error)) call check_digits(error, nearest(2.0_dp**k, 1.0_dp))
            if (allocated(error)) return
        end do
    end subroutine test_powers_of_two

    !> Nothing is said of numbers too large or too small.
    subroutine test_outside(error)
        type(error_type), allocatable, intent(out) :: error

        real(dp), parameter :: X(4) = [1e17_dp, 1e-29_dp, tiny(1.0_dp), huge(1.0_dp)]
        integer(i8) :: digits
        integer :: exponent, i
        logical :: sure

        do i = 1, size(X)
            call shortest_digits(X(i), digits, exponent, sure)
            call check(error, .not. sure)
            if (allocated(error)) return
        end do
    end subroutine test_outside
end module test_shortest_decimal
