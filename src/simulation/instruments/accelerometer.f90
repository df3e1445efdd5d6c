!> The accelerometer: CSR-TM-00-01 section 3.2.
!>
!> What it senses is the acceleration of its proof mass centre (PMC), which lies off the centre of
!> mass (COM) by d; what it puts out is that acceleration through a cubic polynomial, with bias and
!> coloured noise.
module gracecg_simulation_accelerometer
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_vectors, only: cross
    use gracecg_base_random, only: random_stream_t
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, noise_spectrum_t
    implicit none
    private
    public :: accelerometer_t, accelerometer_noise_t, pmc_acceleration_t, pmc_acceleration

    !> Performance of an accelerometer. The values here are those of CSR-TM-00-01 section 5.2 and
    !> eq. (3-2); whether (3-2) is one- or two-sided is not said there, two-sided is inferred.
    type :: accelerometer_t
        real(dp) :: scale1(3) = [1.0101_dp, 0.9841_dp, 0.9881_dp]
        !! Linear scale factor
        real(dp) :: scale2(3) = [7.251_dp, 33.1796_dp, -7.8153_dp]
        !! Quadratic scale factor, s^2/m
        real(dp) :: scale3(3) = [-6.1314e3_dp, -6.9825e4_dp, 3.6445e3_dp]
        !! Cubic scale factor, s^4/m^2
        real(dp) :: bias(3) = [-1.2047e-6_dp, -2.2781e-5_dp, 0.9871e-6_dp]
        !! m/s^2
        type(noise_spectrum_t) :: noise(3) = [noise_spectrum_t(1e-20_dp, 0.005_dp), &
                                              noise_spectrum_t(1e-18_dp, 0.1_dp), &
                                              noise_spectrum_t(1e-20_dp, 0.005_dp)]
        !! Power spectral densities, m^2 s^-4/Hz
        real(dp) :: sampling_interval = 0.1_dp
        !! s
        logical :: limited = .false.            !! Whether samples saturate at the range
        real(dp) :: range = 5e-5_dp             !! Full scale of an axis, section 3.2.1, m/s^2
        logical :: quantised = .false.          !! Whether samples are rounded
        real(dp) :: resolution = 1e-10_dp       !! Step of rounded samples, section 3.2.1, m/s^2
    contains
        procedure :: measure            !! Noisy samples of true accelerations
        procedure :: begin_noise        !! The noise of a record that is drawn in pieces
        procedure :: measure_piece      !! Noisy samples of a piece of it
        procedure :: noise_of_axis      !! The noise generator of an axis
        procedure :: response           !! Scale factors and biases put on an acceleration
        procedure :: digitised          !! Samples as they are put out: saturated and rounded
    end type accelerometer_t

    !> The noise of a record, and where it has got to.
    type :: accelerometer_noise_t
        private
        type(coloured_noise_t) :: axis(3)       ! x, y, z
        type(random_stream_t) :: stream(3)      ! one stream at three places: the axes are drawn one after the other
    end type accelerometer_noise_t

    !> The acceleration of the PMC and its parts, body frame, m/s^2.
    type :: pmc_acceleration_t
        real(dp) :: total(3)            !! Their sum: CSR-TM-00-01 eq. (3-7)
        real(dp) :: velocity(3)         !! By angular velocity: omega x (omega x d), eq. (3-9)
        real(dp) :: acceleration(3)     !! By angular acceleration: d(omega)/dt x d, eq. (3-8)
        real(dp) :: gravity_gradient(3) !! eq. (3-10)
        real(dp) :: non_gravitational(3)    !! Of the satellite, as the true one
    end type pmc_acceleration_t

contains

    !> The true acceleration at the PMC, CSR-TM-00-01 eqs. (3-7)-(3-10): (3-3) where d is constant and the
    !> Earth a sphere, (3-6).
    pure function pmc_acceleration(omega, omega_dot, d, c, mu, r, a_ng) result(a)
        real(dp), intent(in) :: omega(3)        !! Angular velocity, body frame, rad/s
        real(dp), intent(in) :: omega_dot(3)    !! Angular acceleration, body frame, rad/s^2
        real(dp), intent(in) :: d(3)            !! From COM to PMC, body frame, m
        real(dp), intent(in) :: c(3)            !! Unit vector of the local vertical, body frame
        real(dp), intent(in) :: mu              !! Geocentric gravitational constant, m^3/s^2
        real(dp), intent(in) :: r               !! Geocentric distance of the COM, m
        real(dp), intent(in) :: a_ng(3)         !! Non-gravitational acceleration, body frame, m/s^2
        type(pmc_acceleration_t) :: a

        a%velocity = cross(omega, cross(omega, d))
        a%acceleration = cross(omega_dot, d)
        a%gravity_gradient = mu/r**3*(d - 3*dot_product(c, d)*c)
        a%non_gravitational = a_ng
        a%total = a%velocity + a%acceleration + a%gravity_gradient + a%non_gravitational
    end function pmc_acceleration

    !> Samples of the accelerometer, CSR-TM-00-01 eq. (3-1). Fails when a setting of the noise is
    !> not in its range, or when a sample is not finite.
    subroutine measure(self, acceleration, stream, measured, error)
        class(accelerometer_t), intent(in) :: self
        real(dp), intent(in) :: acceleration(:, :)  !! At the PMC, body frame, m/s^2; (3, samples)
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(out) :: measured(:, :)     !! m/s^2; of the same shape
        type(error_t), allocatable, intent(out) :: error

        type(accelerometer_noise_t) :: noise

        call self%begin_noise(stream, size(acceleration, 2), noise, error)
        if (allocated(error)) return
        call self%measure_piece(acceleration, noise, measured, error)
        stream = noise%stream(3)
    end subroutine measure

    !> The noise of a record of so many samples, which may be measured in pieces. Fails when a setting of the noise is
    !> not in its range.
    subroutine begin_noise(self, stream, samples, noise, error)
        class(accelerometer_t), intent(in) :: self
        type(random_stream_t), intent(in) :: stream     !! Where the record's numbers begin
        integer, intent(in) :: samples                  !! Of the whole record
        type(accelerometer_noise_t), intent(out) :: noise
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        noise%stream = stream
        do i = 1, 3
            noise%axis(i) = self%noise_of_axis(i, error)
            if (allocated(error)) return
            if (i == 3) exit
            noise%stream(i + 1) = noise%stream(i)
            call noise%stream(i + 1)%skip_normals(int(samples, i8)*noise%axis(i)%draws_of_sample())
        end do
    end subroutine begin_noise

    !> The next samples of a record, CSR-TM-00-01 eq. (3-1). Fails when a sample is not finite.
    subroutine measure_piece(self, acceleration, noise, measured, error)
        class(accelerometer_t), intent(in) :: self
        real(dp), intent(in) :: acceleration(:, :)          !! At the PMC, body frame, m/s^2; (3, samples)
        type(accelerometer_noise_t), intent(inout) :: noise !! Goes on where it has got to
        real(dp), intent(out) :: measured(:, :)             !! m/s^2; of the same shape
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        do i = 1, 3
            call noise%axis(i)%generate(noise%stream(i), measured(i, :))
        end do
        do i = 1, size(acceleration, 2)
            measured(:, i) = self%response(acceleration(:, i)) + measured(:, i)
        end do
        if (.not. all(ieee_is_finite(measured))) then
            call fail(error, 'an accelerometer sample is not finite: look for NaN in the true '// &
                      'acceleration, the scale factors and the bias')
        end if
        measured = self%digitised(measured)
    end subroutine measure_piece

    !> A generator of one axis' noise, eq. (3-2). Fails when a setting of the noise is not in its range.
    function noise_of_axis(self, i, error) result(noise)
        class(accelerometer_t), intent(in) :: self
        integer, intent(in) :: i    !! 1, 2, 3 for x, y, z
        type(error_t), allocatable, intent(out) :: error
        type(coloured_noise_t) :: noise

        noise = coloured_noise(self%noise(i), self%sampling_interval, error)
        call add_context(error, 'accelerometer, '//AXES(i)//' axis')
    end function noise_of_axis

    !> The output without noise: the polynomial of the true acceleration, and the bias, eq. (3-1).
    pure function response(self, acceleration) result(output)
        class(accelerometer_t), intent(in) :: self
        real(dp), intent(in) :: acceleration(3)     !! m/s^2
        real(dp) :: output(3)                       !! m/s^2

        output = self%bias + acceleration*(self%scale1 + acceleration*(self%scale2 &
                                                                       + acceleration*self%scale3))
    end function response

    !> What the instrument puts out of a value: within its full scale, and in steps of its resolution, where
    !> that is asked for.
    elemental real(dp) function digitised(self, value)
        class(accelerometer_t), intent(in) :: self
        real(dp), intent(in) :: value       !! m/s^2

        digitised = value
        if (self%quantised) digitised = self%resolution*anint(value/self%resolution)
        if (self%limited) digitised = max(-self%range, min(self%range, digitised))
    end function digitised
end module gracecg_simulation_accelerometer
