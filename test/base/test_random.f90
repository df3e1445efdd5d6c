!> The random numbers: published vectors, independence of streams, distributions.
module test_random
    use vocabulary
    use gracecg_base_lanes, only: LANES
    use gracecg_base_random, only: philox_4x32
    use statistics, only: Z_999, mean, chi_square_limits, ljung_box
    implicit none
    private
    public :: collect_random

contains

    subroutine collect_random(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('published-vectors', test_known_answers), &
                    new_unittest('first-uniform-numbers', test_first_uniform), &
                    new_unittest('every-part-of-the-name-counts', test_names), &
                    new_unittest('seeds-of-64-bits', test_long_seeds), &
                    new_unittest('numbers-passed-over', test_skip), &
                    new_unittest('normal-numbers-of-uniform-ones', test_box_muller), &
                    new_unittest('blocks-side-by-side', test_blocks), &
                    new_unittest('uniform-distribution', test_uniform), &
                    new_unittest('normal-distribution', test_normal), &
                    new_unittest('normal-whiteness', test_whiteness)]
    end subroutine collect_random

    !> Passing over numbers leads where drawing them does: even and odd counts, with and without one left of a block.
    subroutine test_skip(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: drawn, passed
        real(dp) :: x(9)
        integer :: before, n

        do before = 0, 1
            do n = 0, size(x)
                drawn = new_stream(5, 4, 1, 3, 2)
                call drawn%normals(x(:before))
                passed = drawn
                call drawn%normals(x(:n))
                call passed%skip_normals(int(n, i8))
                call check(error, abs(drawn%normal() - passed%normal()) <= 0)
                call check(error, abs(drawn%normal() - passed%normal()) <= 0)
            end do
        end do
    end subroutine test_skip

    !> A block's two normal numbers are those of its two uniform ones, by the intrinsic functions.
    subroutine test_box_muller(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: PAIRS = 20000
        type(random_stream_t) :: uniform, normal
        real(dp) :: x(2*PAIRS), u, v, radius, worst
        integer :: i

        uniform = new_stream(6, 5, 1, 3, 2)
        normal = uniform
        call normal%normals(x)
        worst = 0
        do i = 1, PAIRS
            u = uniform%uniform()
            v = uniform%uniform()
            radius = sqrt(-2*log(u))
            worst = max(worst, abs(x(2*i - 1) - radius*cos(TWO_PI*v))/radius, abs(x(2*i) - radius*sin(TWO_PI*v))/radius)
        end do
        call check(error, worst < 2e-15_dp)
    end subroutine test_box_muller

    !> Blocks that are made together are those of their counters one by one, also where the number of the block starts again.
    subroutine test_blocks(error)
        type(error_type), allocatable, intent(out) :: error
        integer(i8), parameter :: KEY(2) = [7_i8, 4294967295_i8], FIRST(4) = [4294967290_i8, 3_i8, 1_i8, 4294967295_i8]
        integer(i8), dimension(LANES, 4) :: together, alone
        integer :: i

        call philox_4x32(FIRST, KEY, together)
        do i = 1, LANES
            call philox_4x32([modulo(FIRST(1) + i - 1, 2_i8**32), FIRST(2:)], KEY, alone)
            call check(error, all(together(i, :) == alone(1, :)))
        end do
    end subroutine test_blocks

    !> Random123 1.x, file kat_vectors, lines `philox4x32 10`.
    subroutine test_known_answers(error)
        type(error_type), allocatable, intent(out) :: error
        integer(i8), parameter :: ONES = int(z'FFFFFFFF', i8)
        integer(i8) :: pi_counter(4), pi_key(2)

        call expect([0_i8, 0_i8, 0_i8, 0_i8], [0_i8, 0_i8], &
                    [int(z'6627E8D5', i8), int(z'E169C58D', i8), int(z'BC57AC4C', i8), &
                     int(z'9B00DBD8', i8)])
        call expect([ONES, ONES, ONES, ONES], [ONES, ONES], &
                    [int(z'408F276D', i8), int(z'41C83B0E', i8), int(z'A20BC7C6', i8), &
                     int(z'6D5451FD', i8)])
        pi_counter = [int(z'243F6A88', i8), int(z'85A308D3', i8), int(z'13198A2E', i8), &
                      int(z'03707344', i8)]
        pi_key = [int(z'A4093822', i8), int(z'299F31D0', i8)]
        call expect(pi_counter, pi_key, &
                    [int(z'D16CFE09', i8), int(z'94FDCCEB', i8), int(z'5001E420', i8), &
                     int(z'24126EA1', i8)])

    contains

        subroutine expect(counter, key, answer)
            integer(i8), intent(in) :: counter(4), key(2), answer(4)
            integer(i8) :: word(LANES, 4)

            call philox_4x32(counter, key, word)
            call check(error, all(word(1, :) == answer))
        end subroutine expect
    end subroutine test_known_answers

    !> The stream named by zeros begins with the first published block: 53 bits of its words.
    subroutine test_first_uniform(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: LAST_BIT = 2.0_dp**(-53)
        type(random_stream_t) :: stream
        real(dp) :: first, second

        stream = new_stream(0, 0, 0, 0, 0)
        first = stream%uniform()
        second = stream%uniform()
        call check(error, first == shiftr(int(z'6627E8D5E169C58D', i8), 11)*LAST_BIT)
        call check(error, second == int(z'BC57AC4C9B00D', i8)*2*LAST_BIT + LAST_BIT)
    end subroutine test_first_uniform

    !> No two of the names made of 0, 1, 2, -1 share a number among their first.
    subroutine test_names(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: PARTS(4) = [0, 1, 2, -1]
        type(random_stream_t) :: stream
        real(dp) :: first(4**5)
        integer :: i, digit(5)

        do i = 0, size(first) - 1
            digit = 1 + [mod(i, 4), mod(i/4, 4), mod(i/16, 4), mod(i/64, 4), i/256]
            stream = new_stream(PARTS(digit(1)), PARTS(digit(2)), PARTS(digit(3)), &
                                PARTS(digit(4)), PARTS(digit(5)))
            first(i + 1) = stream%uniform()
            call check(error, .not. any(first(:i) == first(i + 1)))
        end do
    end subroutine test_names

    !> Seeds of 32 bits mean the same in both kinds; all others are other streams, at the place that the
    !> documentation says.
    subroutine test_long_seeds(error)
        type(error_type), allocatable, intent(out) :: error
        integer(i8), parameter :: TWO_32 = 2_i8**32, SEEDS(14) = [0_i8, 1_i8, -1_i8, 2_i8**31 - 1, 2_i8**31, &
            TWO_32 - 1, TWO_32, TWO_32 + 1, -TWO_32, 2_i8**61, 2_i8**62, huge(1_i8) - TWO_32, huge(1_i8), -huge(1_i8)]
        integer, parameter :: SHORT(5) = [0, 1, -1, huge(1), -huge(1)]
        integer, parameter :: INSTRUMENTS(3) = [0, 1, 2**30 - 1]
        type(random_stream_t) :: a, b
        real(dp) :: first(size(SEEDS)*4*size(INSTRUMENTS))
        integer(i8) :: word(LANES, 4)
        integer :: i, k, l, n

        do i = 1, size(SHORT)
            a = new_stream(SHORT(i), 3, 1, 4, 2)
            b = new_stream(int(SHORT(i), i8), 3, 1, 4, 2)
            call check(error, abs(a%uniform() - b%uniform()) <= 0)
        end do
        n = 0
        do i = 1, size(SEEDS)
            do k = 0, 3
                do l = 1, size(INSTRUMENTS)
                    a = new_stream(SEEDS(i), 3, k, 4, INSTRUMENTS(l))
                    n = n + 1
                    first(n) = a%uniform()
                    call check(error, .not. any(abs(first(:n - 1) - first(n)) <= 0))
                end do
            end do
        end do
        a = new_stream(5*TWO_32 + 7, 3, 1, 4, 2)
        call philox_4x32([0_i8, 3_i8, 1_i8 + 4*5, 2_i8], [7_i8, 4_i8], word)
        call check(error, a%uniform(), real(word(1, 1), dp)*2.0_dp**(-32), thr=1e-9_dp)
    end subroutine test_long_seeds

    !> Chi-square of 100 equal bins, range and mean.
    subroutine test_uniform(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 500000, BINS = 100
        type(random_stream_t) :: stream
        real(dp) :: x(N), statistic, limits(2)
        integer :: i, bin, counts(BINS)

        stream = new_stream(11, 0, 0, 0, 0)
        counts = 0
        do i = 1, N
            x(i) = stream%uniform()
            bin = 1 + int(BINS*x(i))
            counts(bin) = counts(bin) + 1
        end do
        call check(error, minval(x) > 0 .and. maxval(x) < 1)
        call check(error, abs(mean(x) - 0.5_dp) < Z_999*sqrt(1.0_dp/(12*N)))
        statistic = sum((counts - real(N, dp)/BINS)**2)/(real(N, dp)/BINS)
        limits = chi_square_limits(BINS - 1)
        call check(error, statistic > limits(1) .and. statistic < limits(2))
    end subroutine test_uniform

    !> Chi-square of 100 bins of equal probability.
    subroutine test_normal(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 500000, BINS = 100
        type(random_stream_t) :: stream
        real(dp) :: statistic, limits(2), probability
        integer :: i, bin, counts(BINS)

        stream = new_stream(13, 0, 0, 0, 0)
        counts = 0
        do i = 1, N
            probability = 0.5_dp*erfc(-stream%normal()/sqrt(2.0_dp))
            bin = min(BINS, 1 + int(BINS*probability))
            counts(bin) = counts(bin) + 1
        end do
        statistic = sum((counts - real(N, dp)/BINS)**2)/(real(N, dp)/BINS)
        limits = chi_square_limits(BINS - 1)
        call check(error, statistic > limits(1) .and. statistic < limits(2))
    end subroutine test_normal

    !> Of the numbers, and of their squares: both of a Box-Muller pair come from one radius.
    subroutine test_whiteness(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 100000, LAGS = 20
        type(random_stream_t) :: stream
        real(dp) :: x(N), limits(2)

        stream = new_stream(14, 0, 0, 0, 0)
        call stream%normals(x)
        limits = chi_square_limits(LAGS)
        call check(error, ljung_box(x, LAGS) < limits(2))
        call check(error, ljung_box(x**2, LAGS) < limits(2))
    end subroutine test_whiteness
end module test_random
