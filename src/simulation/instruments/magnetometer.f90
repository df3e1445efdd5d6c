!> The magnetometer: CSR-TM-00-01 section 3.4.
module gracecg_simulation_magnetometer
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail, require_range, add_context
    use gracecg_base_random, only: random_stream_t
    implicit none
    private
    public :: magnetometer_t

    real(dp), parameter :: LARGEST = 1.0_dp
    !! Upper end of every setting's range, T: far beyond any field of the Earth

    !> Performance of a magnetometer. Bias and noise are those of CSR-TM-00-01 section 5.2, range
    !> and resolution those of section 3.4.1, which the report's simulation leaves out.
    type :: magnetometer_t
        real(dp) :: bias(3) = [50e-9_dp, -30e-9_dp, 25e-9_dp]   !! T
        real(dp) :: noise = 3e-9_dp             !! Standard deviation, T
        logical :: limited = .false.            !! Whether samples saturate at the range
        real(dp) :: range = 50e-6_dp            !! Greatest value of an axis, T
        logical :: quantised = .false.          !! Whether samples are rounded
        real(dp) :: resolution = 25e-9_dp       !! Step of rounded samples, T
        real(dp) :: sampling_interval = 1.0_dp  !! Between samples, s
        real(dp) :: linearity = 0
        !! Greatest departure from a straight line within the range, T; at most 25 nT by section 3.4.1
        real(dp) :: bandwidth = 0
        !! Corner of its low-pass filter of first order, Hz, 4.5 by section 3.4.1; 0: no filter
    contains
        procedure :: response           !! Bias and departure from a straight line put on a field
        procedure :: passed             !! A field behind the low-pass filter
        procedure :: measure    !! Noisy samples of a true field
        procedure, private :: check_settings
    end type magnetometer_t

contains

    !> Samples of the magnetometer, CSR-TM-00-01 eq. (3-23), then saturated and rounded where that
    !> is asked for. Fails when a setting is not in its range, or when a sample is not finite.
    subroutine measure(self, field, stream, measured, error)
        class(magnetometer_t), intent(in) :: self
        real(dp), intent(in) :: field(:, :)     !! True flux density, body frame, T; (3, samples)
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(out) :: measured(:, :) !! T; of the same shape
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: AT_ONCE = 32      ! samples whose numbers are drawn together
        real(dp) :: draws(3*AT_ONCE)
        integer :: k, i, n

        call self%check_settings(error)
        if (allocated(error)) return
        do k = 0, size(field, 2) - 1, AT_ONCE
            n = min(AT_ONCE, size(field, 2) - k)
            call stream%normals(draws(:3*n))
            do i = 1, n
                measured(:, k + i) = self%response(field(:, k + i)) + self%noise*draws(3*i - 2:3*i)
            end do
        end do
        if (.not. all(ieee_is_finite(measured))) then
            call fail(error, 'a magnetometer sample is not finite: look for NaN in the true '// &
                      'field and the bias')
            return
        end if
        if (self%limited) measured = max(-self%range, min(self%range, measured))
        if (self%quantised) measured = self%resolution*anint(measured/self%resolution)
    end subroutine measure

    !> The output without noise: bias, and a departure from the straight line of the form u - u^3, u = B/range,
    !> which is 0 in the middle and at the ends of the range (the straight line goes through them) and greatest
    !> at u = 0.58. The report gives the greatest departure alone; the form is assumed.
    pure function response(self, field) result(output)
        class(magnetometer_t), intent(in) :: self
        real(dp), intent(in) :: field(3)    !! True flux density, body frame, T
        real(dp) :: output(3)               !! T

        real(dp), parameter :: TO_ITS_GREATEST = 1.5_dp*sqrt(3.0_dp)    ! over the greatest of u - u^3, at u = 1/sqrt(3)

        output = field + self%bias
        if (self%linearity > 0) output = output + self%linearity*TO_ITS_GREATEST* &
                                         (field/self%range - (field/self%range)**3)
    end function response

    !> A series of the field behind a low-pass filter of first order, dy/dt = 2 pi f (B - y): exact for a field
    !> that changes linearly between the epochs, and begun as if it had always changed as in the first interval.
    !> Of a piece of a series the output at its first epoch may be given, where the piece before ended.
    pure function passed(self, field, interval, first) result(output)
        class(magnetometer_t), intent(in) :: self
        real(dp), intent(in) :: field(:, :)     !! T; (3, epochs)
        real(dp), intent(in) :: interval        !! Between the epochs, s
        real(dp), intent(in), optional :: first(3)  !! Output at the first epoch, T
        real(dp) :: output(3, size(field, 2))   !! T

        real(dp) :: time_constant, decay, slope(3)
        integer :: k

        output = field
        if (.not. self%bandwidth > 0) return
        time_constant = 1/(TWO_PI*self%bandwidth)
        decay = exp(-interval/time_constant)
        if (present(first)) then
            output(:, 1) = first
        else if (size(field, 2) > 1) then
            output(:, 1) = field(:, 1) - time_constant*(field(:, 2) - field(:, 1))/interval
        end if
        do k = 2, size(field, 2)
            slope = (field(:, k) - field(:, k - 1))/interval
            output(:, k) = field(:, k) - time_constant*slope + &
                           decay*(output(:, k - 1) - field(:, k - 1) + time_constant*slope)
        end do
    end function passed

    subroutine check_settings(self, error)
        class(magnetometer_t), intent(in) :: self
        type(error_t), allocatable, intent(out) :: error

        call require_range('noise', self%noise, [0.0_dp, LARGEST], 'T', error)
        call require_range('linearity error', self%linearity, [0.0_dp, LARGEST], 'T', error)
        if (self%limited .or. self%linearity > 0) &
            call require_range('range', self%range, [tiny(1.0_dp), LARGEST], 'T', error)
        if (self%quantised) call require_range('resolution', self%resolution, [tiny(1.0_dp), LARGEST], 'T', error)
        call add_context(error, 'magnetometer')
    end subroutine check_settings
end module gracecg_simulation_magnetometer
