!> Noise whose power spectral density is S(f) = level (1 + corner/f): CSR-TM-00-01 eq. (3-2).
!>
!> The white part has the variance level*fs at the sampling frequency fs when S is two-sided, half
!> of that when it is one-sided. The flicker part is a sum of stationary first-order Gauss-Markov
!> (Ornstein-Uhlenbeck) processes
!>
!>     x(k+1) = phi x(k) + sqrt(s (1 - phi^2)) n(k),   phi = exp(-2 pi p),   p = pole/fs,
!>
!> started in their stationary distribution N(0, s). Poles a half decade apart with the equal
!> variances s = 2 h ln(sqrt 10), h = two-sided level times corner, add up to h/f with a ripple
!> of 2/cosh(pi^2/ln(sqrt 10)) = 0.08 %, since the integral of 2 h q/(pi (q^2 + f^2)) over ln(q) is
!> h/f. What the ends of the row lack is made up there: see POLE and WEIGHT. A flicker spectrum has
!> no scale of its own, so one row of poles serves every sampling frequency.
!>
!> The spectrum of the generated samples is h/f to 0.4 % for 1e-4 <= f/fs <= 0.3: 1 mHz to 3 Hz
!> at 10 Hz. Below the lowest pole (7e-6 fs) it is flat; aliasing lifts it by 24 % at fs/2.
!>
!> A spectrum that is a table, between its rows straight lines of log density over log frequency, is followed by a white part
!> and as many processes, of fixed poles and with variances of either sign: least squares of the relative misfit from the
!> first frequency to fs/2. A negative variance is no process of its own, but what uses variances and correlations (the
!> whitening, covariances) depends on the sum alone, and that is one as long as its spectrum is positive. So samples are
!> drawn by the innovations of the filter for the sum.
module gracecg_base_coloured_noise
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail, fail_out_of_range
    use gracecg_base_lapack, only: triangle_of
    use gracecg_base_text, only: integer_text
    use gracecg_base_random, only: random_stream_t
    implicit none
    private
    public :: noise_spectrum_t, coloured_noise_t, coloured_noise, are_alike, ONE_SIDED, TWO_SIDED, N_POLES

    integer, parameter :: ONE_SIDED = 1     !! The power lies at frequencies from 0 to fs/2
    integer, parameter :: TWO_SIDED = 2     !! The power lies at frequencies from -fs/2 to fs/2

    integer, parameter :: N_POLES = 10   !! First-order processes whose sum is the flicker part
    integer :: i_pole    !! Index of the constant arrays below

    real(dp), parameter :: POLE_RATIO = sqrt(10.0_dp)
    real(dp), parameter :: HIGHEST_POLE = 0.2204_dp
    !! In units of fs. Fitted with the first two weights: smallest greatest relative error of the
    !! sampled spectrum against 1/f from 1e-4 to 0.3 fs
    real(dp), parameter :: POLE(N_POLES) = &
        [(HIGHEST_POLE*POLE_RATIO**(1 - i_pole), i_pole=1, N_POLES)]
    !! Pole frequencies in units of fs
    real(dp), parameter :: WEIGHT(N_POLES) = 2*log(POLE_RATIO)* &
        [1.289_dp, 0.9535_dp, (1.0_dp, i_pole=3, N_POLES - 1), POLE_RATIO/(POLE_RATIO - 1)]
    !! Variances in units of h. The first two: fitted, for the missing poles above and for aliasing.
    !! The last: sum of the geometric series of the missing poles below, exact for f >> pole

    !> Chosen, not fitted to an accelerometer: these poles follow a table of level (1 + corner/f) within 6 %, in the
    !> mean 0.5 %, and one that rises within 15 and 1 % (suite coloured-noise)
    integer, parameter :: FAST = 4                  !! Of a table's poles those for what rises with frequency
    real(dp), parameter :: FAST_PHI(FAST) = [-0.6_dp, -0.3_dp, -0.05_dp, 0.1_dp]    !! Their correlations
    real(dp), parameter :: HIGHEST_SLOW = 0.2_dp    !! Of the others, in units of fs; at equal ratios down to
    real(dp), parameter :: LOWEST_SLOW = 1e-3_dp    !! this, or half of the table's first frequency
    real(dp), parameter :: LEAST_WHITE = 0.5_dp     !! Of a table's least density
    integer, parameter :: FITTED = 200              !! Frequencies of the fit
    real(dp), parameter :: MOST_MISFIT = 1.6_dp     !! Ratio of densities

    real(dp), parameter :: LARGEST = huge(1.0_dp)

    !> A power spectral density S(f) = level (1 + corner/f), CSR-TM-00-01 eq. (3-2), or level times a table.
    type :: noise_spectrum_t
        real(dp) :: level = 0           !! White level, unit^2/Hz (m^2 s^-4/Hz), >= 0
        real(dp) :: corner = 0          !! Frequency where both parts are equal, Hz, >= 0
        integer :: sides = TWO_SIDED    !! ONE_SIDED or TWO_SIDED
        real(dp), allocatable :: frequency(:)   !! Of a table, Hz, increasing, to fs/2 at least; else not allocated
        real(dp), allocatable :: shape(:)       !! Its densities by level, the least of them 1
    end type noise_spectrum_t

    !> A generator of coloured noise and where it has got to.
    type :: coloured_noise_t
        private
        real(dp) :: sampling_interval = 1   !! s
        real(dp) :: white_deviation = 0     !! Of the white part, unit of the samples
        real(dp) :: phi(N_POLES) = 0        !! Correlation of one sample with the next
        real(dp) :: variance(N_POLES) = 0   !! Stationary variances, unit of the samples squared
        real(dp) :: drive(N_POLES) = 0      !! Standard deviations of the driving noise
        real(dp) :: state(N_POLES) = 0
        logical :: has_flicker = .false.
        logical :: is_table = .false.
        real(dp) :: covariance(N_POLES, N_POLES) = 0    !! Of a table: of the states before the next sample
        logical :: started = .false.
    contains
        procedure :: generate       !! The next samples of the process
        procedure :: restart        !! Forgets the past: the next sample begins a new record
        procedure :: draws_of_sample    !! Normal numbers that a sample takes
        procedure :: autocovariance !! Of the process, by lag
        procedure :: spectrum       !! Power spectral density of the process
        procedure :: markov_form    !! The process as a sum of first-order Gauss-Markov processes
    end type coloured_noise_t

contains

    !> A generator for a spectrum. Fails when an argument is not in its range, or a table cannot be followed.
    function coloured_noise(spectrum, sampling_interval, error) result(noise)
        type(noise_spectrum_t), intent(in) :: spectrum
        real(dp), intent(in) :: sampling_interval   !! s, > 0
        type(error_t), allocatable, intent(out) :: error
        type(coloured_noise_t) :: noise

        real(dp) :: two_sided_level

        call check_arguments(spectrum, sampling_interval, error)
        if (allocated(error)) return
        two_sided_level = spectrum%level*spectrum%sides/2
        noise%sampling_interval = sampling_interval
        if (allocated(spectrum%frequency)) then
            noise%is_table = spectrum%level > 0
            call follow_table(spectrum%frequency, spectrum%shape, noise, error)
            noise%white_deviation = noise%white_deviation*sqrt(two_sided_level)
            noise%variance = noise%variance*two_sided_level
            return
        end if
        noise%white_deviation = sqrt(two_sided_level/sampling_interval)
        noise%phi = exp(-TWO_PI*POLE)
        noise%variance = two_sided_level*spectrum%corner*WEIGHT
        noise%drive = sqrt(noise%variance*(1 - noise%phi**2))
        noise%has_flicker = any(noise%variance > 0)
    end function coloured_noise

    !> Whether two spectra are alike but for their levels.
    pure elemental logical function are_alike(one, other)
        type(noise_spectrum_t), intent(in) :: one, other    !! To be compared

        are_alike = abs(one%corner - other%corner) <= 0 .and. one%sides == other%sides .and. &
                    (allocated(one%frequency) .eqv. allocated(other%frequency))
        if (.not. (are_alike .and. allocated(one%frequency))) return
        are_alike = size(one%frequency) == size(other%frequency)
        if (are_alike) are_alike = all(abs(one%frequency - other%frequency) <= 0) .and. &
                                   all(abs(one%shape - other%shape) <= 0)
    end function are_alike

    !> Poles and variances for a table of two-sided densities. Fails when it ends below fs/2 or when they cannot follow it.
    subroutine follow_table(frequency, shape, noise, error)
        real(dp), intent(in) :: frequency(:), shape(:)      !! Increasing, Hz; densities, least 1
        type(coloured_noise_t), intent(inout) :: noise      !! With its interval
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: BELOW = 10    ! octaves below the table in which the density has to be positive
        real(dp) :: lowest, rows(2 + N_POLES, FITTED), f(FITTED + BELOW), misfit(FITTED + BELOW), parts(0:N_POLES)
        character(8) :: at
        integer :: i, n

        associate (h => noise%sampling_interval)
            n = size(frequency)
            if (frequency(n) < 0.5_dp*(1 - 1e-9_dp)/h) then
                call fail_out_of_range(error, 'last frequency of the table of the noise', frequency(n), 0.5_dp/h, LARGEST, 'Hz')
                return
            end if
            lowest = min(frequency(1)*h/2, LOWEST_SLOW)
            noise%phi(:FAST) = FAST_PHI
            noise%phi(FAST + 1:) = [(exp(-TWO_PI*HIGHEST_SLOW*(lowest/HIGHEST_SLOW)**((i - 1.0_dp)/(N_POLES - FAST - 1))), &
                                     i=1, N_POLES - FAST)]
            f(:FITTED) = [(frequency(1)*(0.5_dp/h/frequency(1))**((i - 1.0_dp)/(FITTED - 1)), i=1, FITTED)]
            f(FITTED + 1:) = [(frequency(1)*0.5_dp**i, i=1, BELOW)]
            do i = 1, FITTED
                rows(1, i) = h
                rows(2:1 + N_POLES, i) = h*(1 - noise%phi**2)/((1 - noise%phi)**2 + 4*noise%phi*sin(TWO_PI*f(i)*h/2)**2)
                rows(:1 + N_POLES, i) = rows(:1 + N_POLES, i)/density_of_table(frequency, shape, f(i))
            end do
            rows(2 + N_POLES, :) = 1
            parts = least_squares(rows)
            if (parts(0)*h < LEAST_WHITE) then
                parts(0) = LEAST_WHITE/h
                rows(2 + N_POLES, :) = 1 - parts(0)*rows(1, :)
                parts(1:) = least_squares(rows(2:, :))
            end if
            noise%white_deviation = sqrt(parts(0))
            noise%variance = parts(1:)
        end associate
        misfit = [(noise%spectrum(f(i))/density_of_table(frequency, shape, f(i)), i=1, size(f))]
        i = findloc((misfit > 1/MOST_MISFIT .and. misfit < MOST_MISFIT) .or. (misfit > 0 .and. f < frequency(1)), .false., 1)
        if (i == 0) return
        write (at, '(es8.2)') f(i)
        call fail_out_of_range(error, 'density of the noise that can be drawn over that of the table near '//at//' Hz (narrow '// &
                               'lines, and amplitudes steeper than 1/f or f^2, cannot be followed)', misfit(i), &
                               1/MOST_MISFIT, MOST_MISFIT, '')
    end subroutine follow_table

    !> The x of least squared |A x - b|.
    pure function least_squares(rows) result(x)
        real(dp), intent(in) :: rows(:, :)      !! (A, b)^T
        real(dp) :: x(size(rows, 1) - 1)

        real(dp) :: triangle(size(rows, 1), size(rows, 1))
        integer :: i

        call triangle_of(rows, triangle)
        do i = size(x), 1, -1
            x(i) = (triangle(size(rows, 1), i) - dot_product(triangle(i + 1:size(x), i), x(i + 1:)))/triangle(i, i)
        end do
    end function least_squares

    !> The density of a table: a power of the frequency from row to row, constant below the first.
    pure real(dp) function density_of_table(frequency, shape, f) result(density)
        real(dp), intent(in) :: frequency(:), shape(:), f

        integer :: i

        i = max(1, min(count(frequency <= f), size(frequency) - 1))
        density = shape(i)*(shape(i + 1)/shape(i))**(log(max(f, frequency(1))/frequency(i))/log(frequency(i + 1)/frequency(i)))
    end function density_of_table

    subroutine check_arguments(spectrum, sampling_interval, error)
        type(noise_spectrum_t), intent(in) :: spectrum
        real(dp), intent(in) :: sampling_interval
        type(error_t), allocatable, intent(out) :: error

        if (.not. (spectrum%level >= 0 .and. ieee_is_finite(spectrum%level))) then
            call fail_out_of_range(error, 'noise level', spectrum%level, 0.0_dp, LARGEST, 'unit^2/Hz')
        else if (.not. (spectrum%corner >= 0 .and. ieee_is_finite(spectrum%corner))) then
            call fail_out_of_range(error, 'noise corner frequency', spectrum%corner, 0.0_dp, LARGEST, 'Hz')
        else if (.not. (sampling_interval > 0 .and. ieee_is_finite(sampling_interval))) then
            call fail_out_of_range(error, 'sampling interval', sampling_interval, &
                                   tiny(1.0_dp), LARGEST, 's')
        else if (spectrum%sides /= ONE_SIDED .and. spectrum%sides /= TWO_SIDED) then
            call fail(error, 'sides of the noise spectrum = '//integer_text(spectrum%sides)// &
                      ': allowed are 1 (one-sided) and 2 (two-sided)')
        end if
    end subroutine check_arguments

    !> The next samples of the process; a call goes on where the last one ended, so that a record
    !> may be drawn whole or in pieces.
    subroutine generate(self, stream, samples)
        class(coloured_noise_t), intent(inout) :: self
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(out) :: samples(:)     !! In the square root of (unit of level times Hz)

        integer, parameter :: AT_ONCE = 32      ! samples whose numbers are drawn together
        real(dp), target :: draws((1 + N_POLES)*AT_ONCE)
        real(dp), pointer, contiguous :: of_sample(:, :)
        integer :: k, i, n

        if (self%is_table) then
            call generate_by_innovations(self, stream, samples)
            return
        end if
        if (.not. self%has_flicker) then
            call stream%normals(samples)
            samples = self%white_deviation*samples
            return
        end if
        of_sample(0:N_POLES, 1:AT_ONCE) => draws
        do k = 0, size(samples) - 1, AT_ONCE
            n = min(AT_ONCE, size(samples) - k)
            call stream%normals(draws(:n*(1 + N_POLES)))
            do i = 1, n
                if (self%started) then
                    self%state = self%phi*self%state + self%drive*of_sample(1:, i)
                else
                    self%state = sqrt(self%variance)*of_sample(1:, i)
                    self%started = .true.
                end if
                samples(k + i) = self%white_deviation*of_sample(0, i) + sum(self%state)
            end do
        end do
    end subroutine generate

    !> The same for a table: what the samples so far let expect of the next one, and an innovation.
    subroutine generate_by_innovations(self, stream, samples)
        class(coloured_noise_t), intent(inout) :: self
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(out) :: samples(:)

        real(dp) :: gain(N_POLES), deviation
        integer :: k, p

        call stream%normals(samples)
        if (.not. self%started) then
            self%state = 0
            self%covariance = 0
            do p = 1, N_POLES
                self%covariance(p, p) = self%variance(p)
            end do
            self%started = .true.
        end if
        do k = 1, size(samples)
            gain = sum(self%covariance, 2)
            deviation = sqrt(self%white_deviation**2 + sum(gain))
            gain = gain/deviation
            self%state = self%state + gain*samples(k)
            samples(k) = sum(self%state) + (deviation - sum(gain))*samples(k)
            self%state = self%phi*self%state
            do p = 1, N_POLES
                self%covariance(:, p) = self%phi*(self%covariance(:, p) - gain*gain(p))*self%phi(p)
                self%covariance(p, p) = self%covariance(p, p) + self%variance(p)*(1 - self%phi(p)**2)
            end do
        end do
    end subroutine generate_by_innovations

    !> Makes the next sample the first of a new, independent realisation.
    pure subroutine restart(self)
        class(coloured_noise_t), intent(inout) :: self

        self%started = .false.
    end subroutine restart

    !> How many normal numbers `generate` draws for a sample.
    pure integer function draws_of_sample(self) result(draws)
        class(coloured_noise_t), intent(in) :: self

        draws = merge(1 + N_POLES, 1, self%has_flicker)
    end function draws_of_sample

    !> Autocovariance of the generated samples: exact for this process,
    !> r(k) = white variance (k = 0 only) + sum of s phi^|k|.
    pure function autocovariance(self, lags) result(r)
        class(coloured_noise_t), intent(in) :: self
        integer, intent(in) :: lags(:)      !! Samples
        real(dp) :: r(size(lags))           !! Unit of the samples squared

        integer :: i

        do i = 1, size(lags)
            r(i) = sum(self%variance*self%phi**abs(lags(i)))
            if (lags(i) == 0) r(i) = r(i) + self%white_deviation**2
        end do
    end function autocovariance

    !> Two-sided power spectral density of the generated samples, aliasing included: exact for this
    !> process, the Fourier transform of its autocovariance.
    pure elemental real(dp) function spectrum(self, f) result(density)
        class(coloured_noise_t), intent(in) :: self
        real(dp), intent(in) :: f           !! Hz; |f| <= fs/2

        density = self%sampling_interval*(self%white_deviation**2 + &
            sum(self%variance*(1 - self%phi**2)/((1 - self%phi)**2 + &
                               4*self%phi*sin(TWO_PI*f*self%sampling_interval/2)**2)))
    end function spectrum

    !> The process as a sum of a white sequence and independent first-order Gauss-Markov sequences
    !> x(k+1) = correlation x(k) + noise, for filters.
    pure subroutine markov_form(self, white_variance, correlation, variance)
        class(coloured_noise_t), intent(in) :: self
        real(dp), intent(out) :: white_variance             !! Unit of the samples squared
        real(dp), intent(out) :: correlation(N_POLES)       !! Of one sample with the next
        real(dp), intent(out) :: variance(N_POLES)          !! Stationary, unit of the samples squared

        white_variance = self%white_deviation**2
        correlation = self%phi
        variance = self%variance
    end subroutine markov_form
end module gracecg_base_coloured_noise
