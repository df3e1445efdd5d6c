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
module gracecg_base_coloured_noise
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail, fail_out_of_range
    use gracecg_base_text, only: integer_text
    use gracecg_base_random, only: random_stream_t
    implicit none
    private
    public :: noise_spectrum_t, coloured_noise_t, coloured_noise, ONE_SIDED, TWO_SIDED, N_POLES

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

    real(dp), parameter :: LARGEST = huge(1.0_dp)

    !> A power spectral density S(f) = level (1 + corner/f), CSR-TM-00-01 eq. (3-2).
    type :: noise_spectrum_t
        real(dp) :: level = 0           !! White level, unit^2/Hz (m^2 s^-4/Hz), >= 0
        real(dp) :: corner = 0          !! Frequency where both parts are equal, Hz, >= 0
        integer :: sides = TWO_SIDED    !! ONE_SIDED or TWO_SIDED
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

    !> A generator for a spectrum. Fails when an argument is not in its range.
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
        noise%white_deviation = sqrt(two_sided_level/sampling_interval)
        noise%phi = exp(-TWO_PI*POLE)
        noise%variance = two_sided_level*spectrum%corner*WEIGHT
        noise%drive = sqrt(noise%variance*(1 - noise%phi**2))
        noise%has_flicker = any(noise%variance > 0)
    end function coloured_noise

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
            sum(self%drive**2/((1 - self%phi)**2 + &
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
