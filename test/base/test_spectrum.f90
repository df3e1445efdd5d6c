!> The power spectrum: conservation of power, lines, the level of known noise, gaps.
module test_spectrum
    use vocabulary
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, noise_spectrum_t, TWO_SIDED
    use gracecg_base_spectrum
    use statistics, only: Z_999
    implicit none
    private
    public :: collect_spectrum

    real(dp), parameter :: H = 0.1_dp       !! Sampling interval, s
    integer, parameter :: WHOLE = 100000    !! Longer than every record: one segment

contains

    subroutine collect_spectrum(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('parseval', test_parseval), &
                    new_unittest('line', test_line), &
                    new_unittest('strongest-line', test_strongest), &
                    new_unittest('level-of-coloured-noise', test_level), &
                    new_unittest('segments', test_segments), &
                    new_unittest('band-means', test_bands)]
    end subroutine collect_spectrum

    !> Power of both sides: frequency 0 and, for an even length, the last one stand alone.
    real(dp) function total_power(frequency, density, length) result(power)
        real(dp), intent(in) :: frequency(:), density(:)
        integer, intent(in) :: length

        power = density(1) + 2*sum(density(2:))
        if (mod(length, 2) == 0) power = power - density(size(density))
        power = power*(frequency(2) - frequency(1))
    end function total_power

    !> The integral of the spectrum is the mean square, for even and odd lengths.
    subroutine test_parseval(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), allocatable :: x(:), frequency(:), density(:)
        integer :: n, i

        do n = 63, 64
            x = [(sin(1.7_dp*i) + cos(0.31_dp*i*i) + 0.4_dp, i=1, n)]
            call power_spectrum([(i, i=1, n)], x, H, WHOLE, BOXCAR, frequency, density)
            call check(error, frequency(size(frequency)), (n/2)/(n*H), thr=1e-14_dp)
            call check(error, total_power(frequency, density, n), sum(x**2)/n, thr=1e-13_dp)
        end do
    end subroutine test_parseval

    !> A line at f_6 of amplitude A: with Hann's taper it stays within three frequencies, where its
    !> power is A^2/2; its peak is A^2 T/4 times (sum w)^2/(n sum w^2) = 2/3.
    subroutine test_line(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 600
        real(dp), parameter :: A = 3
        real(dp), allocatable :: x(:), frequency(:), density(:)
        integer :: i

        x = [(A*cos(TWO_PI*6*i/N + 0.3_dp), i=1, N)]
        call power_spectrum([(i, i=1, N)], x, H, WHOLE, HANN, frequency, density)
        call check(error, frequency(7), 0.1_dp, thr=1e-15_dp)
        call check(error, density(7), A**2*N*H/4*2/3, thr=1e-9_dp)
        call check(error, 2*sum(density(6:8))/(N*H), A**2/2, thr=1e-10_dp)
        call check(error, maxval(density([1, 2, 3, 4, 10, 20, 200])), 0.0_dp, thr=1e-9_dp)
    end subroutine test_line

    !> A tone of amplitude a in n of a minute's samples, some of them absent or zero: a line of n a^2/2 at
    !> its frequency; in white noise of variance 1 a single line has the mean 2.
    subroutine test_strongest(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SPACING = 1/240.0_dp, TONE = 20*SPACING
        integer, parameter :: SERIES = 2000
        type(random_stream_t) :: stream
        integer, allocatable :: epoch(:)
        real(dp), allocatable :: values(:)
        real(dp) :: line, frequency, noise(64), mean
        integer :: i

        epoch = pack([(i, i=100, 699)], [(i < 200 .or. i > 210, i=100, 699)])
        allocate (values(size(epoch)))
        values = 0.3_dp*sin(TWO_PI*TONE*epoch*H + 1)
        values(300:303) = 0
        call strongest_line(epoch, values, size(epoch) - 4, H, 60.0_dp, 1.5_dp, 1.0_dp, line, frequency)
        call check(error, frequency, TONE, thr=1e-12_dp)
        call check(error, line, 0.045_dp*(size(epoch) - 4), thr=0.03_dp, rel=.true.)
        mean = 0
        stream = new_stream(5, 1, 1, 1, 1)
        do i = 1, SERIES
            call stream%normals(noise)
            call strongest_line([(i, i=1, 64)], noise, 64, H, 0.25_dp/0.7_dp, 0.5_dp, 1.41_dp, line, frequency)
            mean = mean + line/SERIES
        end do
        call check(error, mean, 2.0_dp, thr=Z_999*2/sqrt(real(SERIES, dp)))
    end subroutine test_strongest

    !> Over its expectation a periodogram has mean 1 and variance 1 at each frequency; Hann's taper
    !> correlates the powers of neighbours by 4/9 and 1/36. A third of the samples lost changes the
    !> level by nothing (but mixes frequencies, so that is done with white noise).
    subroutine test_level(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 3000
        type(coloured_noise_t) :: noise
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp), allocatable :: x(:), frequency(:), density(:), ratio(:)
        real(dp) :: corner
        integer, allocatable :: epoch(:)
        integer :: i, trial

        do trial = 1, 3
            corner = merge(0.1_dp, 0.0_dp, trial == 1)
            noise = coloured_noise(noise_spectrum_t(1e-18_dp, corner, TWO_SIDED), H, failure)
            if (failed(error, failure)) return
            stream = new_stream(99, 1, 1, trial, 1)
            allocate (x(N))
            call noise%generate(stream, x)
            epoch = [(i, i=1, N)]
            if (trial == 3) epoch = pack(epoch, mod(epoch*epoch, 7) /= 1)
            call power_spectrum(epoch, x(epoch), H, WHOLE, HANN, frequency, density)
            ratio = density(4:)/noise%spectrum(frequency(4:))
            call check(error, sum(ratio)/size(ratio), 1.0_dp, 'mean over the frequencies', &
                       thr=Z_999*sqrt((1 + 2*(4/9.0_dp + 1/36.0_dp))/size(ratio))*merge(1.5_dp, 1.0_dp, trial == 3))
            deallocate (x)
        end do
    end subroutine test_level

    !> Segments that overlap by half: the mean of their periodograms, in the frequencies of one.
    subroutine test_segments(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), allocatable :: x(:), frequency(:), density(:), part(:), total(:), unused(:)
        integer :: i, first

        x = [(sin(1.7_dp*i) + cos(0.31_dp*i*i), i=1, 160)]
        call power_spectrum([(i, i=1, 160)], x, H, 64, HANN, frequency, density)
        allocate (total(33), source=0.0_dp)
        do first = 1, 97, 32
            call power_spectrum([(i, i=1, 64)], x(first:first + 63), H, WHOLE, HANN, unused, part)
            total = total + part/4
        end do
        if (unmet(error, size(frequency), 33)) return
        call check(error, maxval(abs(density - total)), 0.0_dp, thr=1e-14_dp*maxval(total))
    end subroutine test_segments

    !> The bands cover every frequency above 0 once, and none is wider than asked.
    subroutine test_bands(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), allocatable :: frequency(:), f(:), d(:)
        integer :: k

        frequency = [(k/60.0_dp, k=0, 300)]
        call band_means(frequency, frequency, 1/3.0_dp, f, d)
        if (unmet(error, maxval(abs(f - d)) < 1e-14_dp .and. all(f(2:) > f(:size(f) - 1)))) return
        call check(error, f(1), frequency(2), thr=1e-15_dp)
        if (unmet(error, all(f(2:)/f(:size(f) - 1) < 2.001_dp), 'a band is missing')) return
        if (unmet(error, size(f), 20)) return
        call band_means(frequency, 0*frequency + 7, 1/3.0_dp, f, d)
        call check(error, maxval(abs(d - 7)), 0.0_dp, thr=1e-14_dp)
    end subroutine test_bands
end module test_spectrum
