!> Coloured noise: the analytic spectrum against the law, the samples against the analytic ones.
module test_coloured_noise
    use vocabulary
    use gracecg_base_spectrum, only: power_spectrum, HANN
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, noise_spectrum_t, ONE_SIDED, TWO_SIDED
    use statistics, only: Z_999, mean, variance, chi_square_limits, ljung_box
    implicit none
    private
    public :: collect_coloured_noise

    real(dp), parameter :: LEVEL = 1e-20_dp         !! m^2 s^-4/Hz
    real(dp), parameter :: INTERVAL = 0.1_dp        !! s
    real(dp), parameter :: Z_9999 = 3.8906_dp       !! Two-sided 99.99 % point

contains

    subroutine collect_coloured_noise(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('white-variance-and-sides', test_sides), &
                    new_unittest('flicker-law-within-half-a-percent', test_law), &
                    new_unittest('spectrum-is-transform-of-autocovariance', test_transform), &
                    new_unittest('periodogram-slope-and-level', test_periodogram), &
                    new_unittest('sample-autocovariance', test_autocovariance), &
                    new_unittest('white-part-is-white', test_white), &
                    new_unittest('whole-or-in-pieces', test_pieces), &
                    new_unittest('rejects-bad-arguments-and-tables', test_arguments), &
                    new_unittest('table-of-the-formula', test_table), &
                    new_unittest('samples-of-a-table-have-its-spectrum', test_drawn_table)]
    end subroutine collect_coloured_noise

    !> White: level*fs two-sided, half of it one-sided; the flicker part follows the same factor.
    subroutine test_sides(error)
        type(error_type), allocatable, intent(out) :: error
        type(coloured_noise_t) :: one, two
        type(error_t), allocatable :: failure
        real(dp) :: r_one(2), r_two(2)

        two = coloured_noise(noise_spectrum_t(LEVEL, 0.0_dp, TWO_SIDED), INTERVAL, failure)
        r_two = two%autocovariance([0, 1])
        call check(error, sqrt(r_two(1)), 3.16227766e-10_dp, thr=1e-18_dp)
        call check(error, r_two(2), 0.0_dp)
        one = coloured_noise(noise_spectrum_t(LEVEL, 0.3_dp, ONE_SIDED), INTERVAL, failure)
        two = coloured_noise(noise_spectrum_t(LEVEL, 0.3_dp, TWO_SIDED), INTERVAL, failure)
        r_one = one%autocovariance([0, 7])
        r_two = two%autocovariance([0, 7])
        call check(error, maxval(abs(r_two/r_one - 2)) < 1e-14_dp)
    end subroutine test_sides

    !> The flicker part of (3-2) from 1 mHz to 3 Hz at 10 Hz.
    subroutine test_law(error)
        type(error_type), allocatable, intent(out) :: error
        type(coloured_noise_t) :: noise
        type(error_t), allocatable :: failure
        real(dp) :: f, ratio
        integer :: i

        noise = coloured_noise(noise_spectrum_t(LEVEL, 1.0_dp, TWO_SIDED), INTERVAL, failure)
        do i = 0, 200
            f = 1e-3_dp*3000.0_dp**(i/200.0_dp)
            ratio = (noise%spectrum(f) - LEVEL)/(LEVEL/f)
            call check(error, ratio, 1.0_dp, thr=0.005_dp)
        end do
    end subroutine test_law

    !> S(f) = dt sum over k of r(k) cos(2 pi f k dt).
    subroutine test_transform(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: LAST = 400000
        real(dp), parameter :: F(3) = [0.01_dp, 0.3_dp, 4.0_dp]
        type(coloured_noise_t) :: noise
        type(error_t), allocatable :: failure
        real(dp), allocatable :: r(:)
        real(dp) :: s
        integer :: i, k

        noise = coloured_noise(noise_spectrum_t(LEVEL, 0.5_dp, TWO_SIDED), INTERVAL, failure)
        allocate (r(0:LAST), source=noise%autocovariance([(k, k=0, LAST)]))
        do i = 1, size(F)
            s = r(0)
            do k = 1, LAST
                s = s + 2*r(k)*cos(TWO_PI*F(i)*INTERVAL*k)
            end do
            call check(error, INTERVAL*s/noise%spectrum(F(i)), 1.0_dp, thr=1e-6_dp)
        end do
    end subroutine test_transform

    !> Averaged periodograms (Hann window) of flicker noise at 18 frequencies from 0.1 to 3 Hz
    !> against level*corner/f. The logarithm of a mean of M exponential variables has the variance
    !> 1/M; the limits are for 99.9 %. The window raises the lowest of the powers by 0.4 %.
    subroutine test_periodogram(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 1000, RECORDS = 400
        integer, parameter :: BIN(18) = [10, 13, 16, 20, 24, 29, 36, 44, 53, 65, 79, 96, 117, 142, &
                                         173, 210, 250, 300]
        real(dp), parameter :: CORNER = 1e4_dp
        type(coloured_noise_t) :: noise
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: c(N, size(BIN)), s(N, size(BIN)), window(N), x(N), power(size(BIN))
        real(dp) :: log_f(size(BIN)), excess(size(BIN)), slope, spread
        integer :: i, k

        do k = 1, N
            window(k) = 1 - cos(TWO_PI*(k - 0.5_dp)/N)
        end do
        do i = 1, size(BIN)
            do k = 1, N
                c(k, i) = window(k)*cos(TWO_PI*BIN(i)*k/N)
                s(k, i) = window(k)*sin(TWO_PI*BIN(i)*k/N)
            end do
        end do
        noise = coloured_noise(noise_spectrum_t(LEVEL, CORNER, TWO_SIDED), INTERVAL, failure)
        stream = new_stream(21, 0, 0, 0, 0)
        power = 0
        do i = 1, RECORDS
            call noise%restart()
            call noise%generate(stream, x)
            power = power + matmul(x, c)**2 + matmul(x, s)**2
        end do
        power = power*INTERVAL/sum(window**2)/RECORDS
        log_f = log(BIN/(N*INTERVAL))
        excess = log(power/(LEVEL*(1 + CORNER*N*INTERVAL/BIN)))
        spread = sum((log_f - mean(log_f))**2)
        slope = sum((log_f - mean(log_f))*excess)/spread
        call check(error, mean(excess), 0.0_dp, thr=Z_999/sqrt(real(RECORDS*size(BIN), dp)))
        call check(error, slope, 0.0_dp, thr=Z_999/sqrt(RECORDS*spread))
    end subroutine test_periodogram

    !> Products of the first and a later sample of independent records; squares of samples from the first to the 600th.
    subroutine test_autocovariance(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RECORDS = 4000, LAGS(7) = [0, 1, 2, 5, 10, 20, 50], AT(5) = [1, 2, 60, 300, 600]
        type(coloured_noise_t) :: noise
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: x(600), r(7), found(7), squares(5)
        integer :: i

        noise = coloured_noise(noise_spectrum_t(LEVEL, 2.0_dp, TWO_SIDED), INTERVAL, failure)
        stream = new_stream(22, 0, 0, 0, 0)
        found = 0
        squares = 0
        do i = 1, RECORDS
            call noise%restart()
            call noise%generate(stream, x)
            found = found + x(1)*x(1 + LAGS)
            squares = squares + x(AT)**2
        end do
        found = found/RECORDS
        r = noise%autocovariance(LAGS)
        call check(error, maxval(abs(found - r)/sqrt((r(1)**2 + r**2)/RECORDS)) < Z_9999, &
                   'beyond the 99.9 % limit of the greatest of 7')
        call check(error, all(noise%autocovariance(-LAGS) == r))
        call check(error, maxval(abs(squares/RECORDS/r(1) - 1)) < Z_9999*sqrt(2.0_dp/RECORDS), &
                   'beyond the 99.9 % limit of the greatest of 5')
    end subroutine test_autocovariance

    subroutine test_white(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 100000, LAGS = 20
        type(coloured_noise_t) :: noise
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: x(N), limits(2)

        noise = coloured_noise(noise_spectrum_t(LEVEL, 0.0_dp, TWO_SIDED), INTERVAL, failure)
        stream = new_stream(24, 0, 0, 0, 0)
        call noise%generate(stream, x)
        limits = chi_square_limits(LAGS)
        call check(error, ljung_box(x, LAGS) < limits(2))
        call check(error, variance(x)/(LEVEL/INTERVAL), 1.0_dp, thr=Z_999*sqrt(2.0_dp/N))
        ! The test can fail: flicker of the same level is found at once.
        noise = coloured_noise(noise_spectrum_t(LEVEL, 1.0_dp, TWO_SIDED), INTERVAL, failure)
        call noise%generate(stream, x)
        call check(error, ljung_box(x, LAGS) > 100*limits(2))
    end subroutine test_white

    subroutine test_pieces(error)
        type(error_type), allocatable, intent(out) :: error
        type(coloured_noise_t) :: noise
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: whole(100), pieces(100)

        noise = coloured_noise(noise_spectrum_t(LEVEL, 0.1_dp, TWO_SIDED), INTERVAL, failure)
        stream = new_stream(25, 0, 0, 0, 0)
        call noise%generate(stream, whole)
        call noise%restart()
        stream = new_stream(25, 0, 0, 0, 0)
        call noise%generate(stream, pieces(:33))
        call noise%generate(stream, pieces(34:))
        call check(error, all(whole == pieces))
    end subroutine test_pieces

    !> Frequencies of a table, from 0.1 mHz to 5 Hz.
    pure function table_frequencies() result(f)
        real(dp) :: f(40)

        integer :: i

        f = [(1e-4_dp*5e4_dp**((i - 1)/39.0_dp), i=1, 40)]
    end function table_frequencies

    !> The noise of an accelerometer for a next mission, by its least density: 2e-12 sqrt(1.2 + 0.002/f + 6000 f^4) m/s^2/sqrt(Hz),
    !> which rises two thousandfold to 5 Hz.
    elemental real(dp) function rising(f)
        real(dp), intent(in) :: f       !! Hz

        rising = (1.2_dp + 0.002_dp/f + 6000*f**4)/1.2_dp
    end function rising

    !> A table of the formula gives the formula's spectrum, in the mean within 0.5 %.
    subroutine test_table(error)
        type(error_type), allocatable, intent(out) :: error
        type(coloured_noise_t) :: noise
        type(error_t), allocatable :: failure
        real(dp) :: f(400), ratio(400)
        integer :: i

        noise = coloured_noise(noise_spectrum_t(LEVEL, frequency=table_frequencies(), shape=1 + 0.1_dp/table_frequencies()), &
                               INTERVAL, failure)
        call check(error, message_of(failure), '')
        f = [(2e-3_dp*2500.0_dp**((i - 1)/399.0_dp), i=1, 400)]
        ratio = noise%spectrum(f)/(LEVEL*(1 + 0.1_dp/f))
        call check(error, maxval(abs(ratio - 1)) < 0.06_dp .and. abs(mean(ratio) - 1) < 0.005_dp, 'formula')
        noise = coloured_noise(noise_spectrum_t(LEVEL, frequency=table_frequencies(), shape=rising(table_frequencies())), &
                               INTERVAL, failure)
        ratio = noise%spectrum(f)/(LEVEL*rising(f))
        call check(error, maxval(abs(ratio - 1)) < 0.15_dp .and. abs(mean(ratio) - 1) < 0.01_dp, 'a rising spectrum')
    end subroutine test_table

    !> Periodograms of samples, averaged over bands, against the rising table; drawn whole and in pieces they are the same.
    !> Windows raise the powers by their second differences, a few per cent of f^4 at the lowest band.
    subroutine test_drawn_table(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 40000, SEGMENT = 2000
        integer, parameter :: EDGE(8) = [20, 40, 80, 160, 300, 500, 700, 950]       ! of 1/200 Hz
        type(coloured_noise_t) :: noise
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: x(N), pieces(100)
        real(dp), allocatable :: f(:), density(:)
        integer :: i, k

        noise = coloured_noise(noise_spectrum_t(LEVEL, frequency=table_frequencies(), shape=rising(table_frequencies())), &
                               INTERVAL, failure)
        stream = new_stream(27, 0, 0, 0, 0)
        call noise%generate(stream, x)
        call noise%restart()
        stream = new_stream(27, 0, 0, 0, 0)
        call noise%generate(stream, pieces(:33))
        call noise%generate(stream, pieces(34:))
        call check(error, all(x(:100) == pieces), 'pieces')
        call check(error, noise%draws_of_sample(), 1)
        call power_spectrum([(i, i=1, N)], x, INTERVAL, SEGMENT, HANN, f, density)
        do k = 1, size(EDGE) - 1
            associate (band => [(i, i=EDGE(k) + 1, EDGE(k + 1))])
                call check(error, mean(density(band)/noise%spectrum(f(band))), 1.0_dp, &
                           thr=0.03_dp + Z_9999/sqrt(real(size(band)*N/SEGMENT, dp)))
            end associate
        end do
    end subroutine test_drawn_table

    !> A table that ends below half the sampling frequency, and one with a narrow line.
    subroutine test_arguments(error)
        type(error_type), allocatable, intent(out) :: error
        type(coloured_noise_t) :: noise
        type(error_t), allocatable :: failure
        real(dp) :: shape(40)

        call expect_failure(-LEVEL, 0.1_dp, TWO_SIDED, INTERVAL, 'noise level')
        call expect_failure(nan, 0.1_dp, TWO_SIDED, INTERVAL, 'noise level')
        call expect_failure(LEVEL, -0.1_dp, TWO_SIDED, INTERVAL, 'corner')
        call expect_failure(LEVEL, nan, TWO_SIDED, INTERVAL, 'corner')
        call expect_failure(LEVEL, 0.1_dp, 3, INTERVAL, 'sides')
        call expect_failure(LEVEL, 0.1_dp, ONE_SIDED, 0.0_dp, 'interval')
        call expect_failure(LEVEL, 0.1_dp, ONE_SIDED, nan, 'interval')
        shape = 1
        noise = coloured_noise(noise_spectrum_t(LEVEL, frequency=table_frequencies(), shape=shape), INTERVAL/2, failure)
        call check_fails(error, failure, 'last frequency ... = 5 Hz ... 10')
        shape(30) = 1e4_dp
        noise = coloured_noise(noise_spectrum_t(LEVEL, frequency=table_frequencies(), shape=shape), INTERVAL, failure)
        call check_fails(error, failure, 'near ... narrow lines')

    contains

        subroutine expect_failure(level, corner, sides, interval, word)
            real(dp), intent(in) :: level, corner, interval
            integer, intent(in) :: sides
            character(*), intent(in) :: word
            type(coloured_noise_t) :: noise
            type(error_t), allocatable :: failure

            noise = coloured_noise(noise_spectrum_t(level, corner, sides), interval, failure)
            call check_fails(error, failure, word)
        end subroutine expect_failure
    end subroutine test_arguments
end module test_coloured_noise
