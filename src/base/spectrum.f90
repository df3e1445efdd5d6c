!> The power spectrum of a record of samples: Welch's averaged periodogram.
!>
!> P. D. Welch, IEEE Trans. Audio Electroacoustics 15 (1967) 70-73. The time grows like n log n, whatever the length.
!>
!> Fourier sums at equally spaced frequencies of any spacing, in a time that grows like n log n.
!>
!> The sum over k of x_k exp(2 pi i j k/L) is a convolution, because 2jk = j^2 + k^2 - (j - k)^2: a chirp, as in
!> L. R. Rabiner, R. W. Schafer, C. M. Rader, IEEE Trans. Audio Electroacoustics 17 (1969) 86-92 (after
!> L. I. Bluestein, 1968). The convolution is done with transforms whose length is a power of two, in the form of
!> Stockham (W. T. Cochran et al., Proc. IEEE 55 (1967) 1664-1674). Neither the number of samples nor L, which
!> need not even be whole, has to have small factors.
module gracecg_base_spectrum
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI, PI
    implicit none
    private
    public :: power_spectrum, band_means, strongest_line, BOXCAR, HANN, fourier_sums

    integer, parameter :: BOXCAR = 0    !! No taper: power is conserved (Parseval), lines leak far
    integer, parameter :: HANN = 1      !! Lines leak into the two neighbouring frequencies only

contains

    !> Two-sided power spectral density at f_k = k/(L h), k = 0 .. L/2, of samples at multiples of h:
    !>
    !>     S(f_k) = h |sum w_i x_i exp(-2 pi j f_k i h)|^2 / sum w_i^2,
    !>
    !> averaged over segments of L samples that overlap by half, L = min(record, longest_segment).
    !> Missing samples count as zero and are left out of sum w_i^2; segments with less than half of
    !> their samples are left out. The mean of the samples is not removed.
    pure subroutine power_spectrum(epoch, values, interval, longest_segment, taper, frequency, density)
        integer, intent(in) :: epoch(:)         !! Increasing index of each sample, in units of h
        real(dp), intent(in) :: values(:)       !! One for each epoch
        real(dp), intent(in) :: interval        !! h, s
        integer, intent(in) :: longest_segment  !! Samples, at least 2
        integer, intent(in) :: taper            !! BOXCAR or HANN
        real(dp), allocatable, intent(out) :: frequency(:)  !! Hz
        real(dp), allocatable, intent(out) :: density(:)    !! Unit of the samples squared, per Hz

        real(dp), allocatable :: record(:), window(:)
        complex(dp), allocatable :: sums(:)
        logical, allocatable :: is_there(:)
        integer :: span, length, first, used, i, k

        span = epoch(size(epoch)) - epoch(1) + 1
        length = max(2, min(span, longest_segment))
        allocate (record(0:max(span, length) - 1), source=0.0_dp)
        allocate (is_there(0:max(span, length) - 1), source=.false.)
        do i = 1, size(epoch)
            record(epoch(i) - epoch(1)) = values(i)
            is_there(epoch(i) - epoch(1)) = .true.
        end do
        allocate (window(0:length - 1), source=1.0_dp)
        if (taper == HANN) window = [(sin(TWO_PI*(i + 0.5_dp)/(2*length))**2, i=0, length - 1)]
        frequency = [(k/(length*interval), k=0, length/2)]
        allocate (density(length/2 + 1), source=0.0_dp)
        allocate (sums(length/2 + 1))
        used = 0
        do first = 0, span - length, max(1, length/2)
            associate (part => record(first:first + length - 1), there => is_there(first:first + length - 1))
                if (2*count(there) < length) cycle
                call fourier_sums(part*window, real(length, dp), 0, sums)
                density = density + (sums%re**2 + sums%im**2)*interval/sum(window**2, mask=there)
                used = used + 1
            end associate
        end do
        density = density/max(1, used)
    end subroutine power_spectrum

    !> The strongest line in the periodogram of samples at multiples of h, 2 |sum x_i exp(2 pi j f k_i h)|^2/n
    !> for f every quarter of 1/arc. For white samples of variance 1 a line is a
    !> chi-square with two degrees of freedom. Missing samples may be absent or zero.
    pure subroutine strongest_line(epoch, values, counted, interval, arc, least_cycles, highest, line, frequency)
        integer, intent(in) :: epoch(:)         !! Increasing index of each sample, k, in units of h
        real(dp), intent(in) :: values(:)       !! One for each epoch
        integer, intent(in) :: counted          !! n: the samples that are there
        real(dp), intent(in) :: interval        !! h, s
        real(dp), intent(in) :: arc             !! Length of the record, s
        real(dp), intent(in) :: least_cycles    !! Of the lowest frequency, in the arc
        real(dp), intent(in) :: highest         !! Frequency, Hz; at most 1/(2h) is tried
        real(dp), intent(out) :: line           !! 0 if no frequency was tried
        real(dp), intent(out) :: frequency      !! Hz

        integer, parameter :: LINES_PER_BIN = 4     ! frequencies tried, in units of 1/arc
        real(dp), allocatable :: record(:)
        complex(dp), allocatable :: sums(:)
        real(dp) :: power, spacing
        integer :: i, j, first, last

        line = 0
        spacing = 1/(LINES_PER_BIN*arc)
        first = ceiling(least_cycles*LINES_PER_BIN)
        last = int(min(highest, 0.5_dp/interval)*arc*LINES_PER_BIN)
        frequency = first*spacing
        if (last < first) return
        allocate (record(epoch(1):epoch(size(epoch))), source=0.0_dp)
        do i = 1, size(epoch)
            record(epoch(i)) = values(i)
        end do
        allocate (sums(first:last))
        call fourier_sums(record, LINES_PER_BIN*arc/interval, first, sums)
        do j = first, last
            power = 2*(sums(j)%re**2 + sums(j)%im**2)/counted
            if (.not. power > line) cycle
            line = power
            frequency = j*spacing
        end do
    end subroutine strongest_line

    !> The means of a spectrum over bands of `octaves`, from its second frequency (the first above 0)
    !> on: each band begins where the last one ended and holds at least one frequency.
    pure subroutine band_means(frequency, density, octaves, band_frequency, band_density)
        real(dp), intent(in) :: frequency(:), density(:)    !! From frequency 0 on
        real(dp), intent(in) :: octaves                     !! Width of a band, > 0
        real(dp), allocatable, intent(out) :: band_frequency(:), band_density(:)
        !! (bands): Hz, and the means in the unit of the density

        integer :: first, last, bands
        real(dp) :: means(2, size(frequency))

        bands = 0
        first = 2
        do while (first <= size(frequency))
            last = first
            do while (last < size(frequency))
                if (frequency(last + 1) > frequency(first)*2**octaves) exit
                last = last + 1
            end do
            bands = bands + 1
            means(1, bands) = sum(frequency(first:last))/(last - first + 1)
            means(2, bands) = sum(density(first:last))/(last - first + 1)
            first = last + 1
        end do
        band_frequency = means(1, :bands)
        band_density = means(2, :bands)
    end subroutine band_means

    !> sum over k of x_k exp(2 pi i j k/L), k = 0 .. size(x) - 1, for j = first .. first + size(sums) - 1.
    !>
    !> The chirp's phases pi k^2/L are reduced before they are multiplied, without rounding: what is left is the
    !> rounding of transforms, some 1e-16 of the root of sum |x_k|^2 times the samples.
    pure subroutine fourier_sums(x, length, first, sums)
        real(dp), intent(in) :: x(0:)           !! Samples
        real(dp), intent(in) :: length          !! L, > 0: the frequency j has j/L turns a sample
        integer, intent(in) :: first            !! The first j, >= 0
        complex(dp), intent(out) :: sums(0:)    !! One for each frequency

        complex(dp), allocatable :: series(:), kernel(:), roots(:)
        integer :: samples, frequencies, n, k

        samples = size(x)
        frequencies = size(sums)
        if (samples == 0 .or. frequencies == 0) then
            sums = 0
            return
        end if
        n = 1
        do while (n < samples + frequencies - 1)
            n = 2*n
        end do
        allocate (roots(0:max(0, n/2 - 1)))
        do k = 0, ubound(roots, 1)
            roots(k) = cmplx(cos(TWO_PI*k/n), sin(TWO_PI*k/n), dp)
        end do
        allocate (series(0:n - 1), kernel(0:n - 1), source=(0.0_dp, 0.0_dp))
        do k = 0, samples - 1
            series(k) = x(k)*chirp(k, length)
        end do
        do k = 0, frequencies - 1
            kernel(k) = conjg(chirp(first + k, length))
        end do
        do k = 1, samples - 1       ! negative differences j - k: from the end backwards
            kernel(n - k) = conjg(chirp(first - k, length))
        end do
        call transform(series, roots)
        call transform(kernel, roots)
        series = conjg(series*kernel)   ! the way back is the conjugate of the way there
        call transform(series, roots)
        do k = 0, frequencies - 1
            sums(k) = chirp(first + k, length)*conjg(series(k))/n
        end do
    end subroutine fourier_sums

    !> exp(pi i k^2/L).
    elemental complex(dp) function chirp(k, length)
        integer, intent(in) :: k
        real(dp), intent(in) :: length

        real(dp) :: angle

        angle = PI*mod(real(k, dp)**2, 2*length)/length     ! both are exact up to |k| = 2^26
        chirp = cmplx(cos(angle), sin(angle), dp)
    end function chirp

    !> sum over k of x_k exp(2 pi i j k/n) for j = 0 .. n - 1, in place.
    pure subroutine transform(x, roots)
        complex(dp), intent(inout) :: x(0:)     !! n of them, a power of two
        complex(dp), intent(in) :: roots(0:)    !! exp(2 pi i k/n), k < n/2

        complex(dp), allocatable :: work(:)
        integer :: n, done
        logical :: in_work

        n = size(x)
        allocate (work(0:n - 1))
        done = 1
        in_work = .false.
        do while (done < n)
            if (in_work) then
                call halve(done, n/(2*done), work, x, roots)
            else
                call halve(done, n/(2*done), x, work, roots)
            end if
            in_work = .not. in_work
            done = 2*done
        end do
        if (in_work) x = work
    end subroutine transform

    !> One of the log2(n) stages: sums and differences of the two halves of x, half as many transforms of half
    !> the length; written next to each other, so that the last stage leaves the frequencies in order.
    pure subroutine halve(m, l, x, y, roots)
        integer, intent(in) :: m        !! Frequencies found in the stages before: 1, 2, 4, ..
        integer, intent(in) :: l        !! n/(2m)
        complex(dp), intent(in) :: x(0:m - 1, 0:l - 1, 0:1)
        complex(dp), intent(out) :: y(0:m - 1, 0:1, 0:l - 1)
        complex(dp), intent(in) :: roots(0:m*l - 1)

        integer :: j, k

        do j = 0, l - 1
            do k = 0, m - 1
                y(k, 0, j) = x(k, j, 0) + x(k, j, 1)
                y(k, 1, j) = roots(j*m)*(x(k, j, 0) - x(k, j, 1))
            end do
        end do
    end subroutine halve
end module gracecg_base_spectrum
