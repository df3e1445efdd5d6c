!> The magnetometer: CSR-TM-00-01 section 3.4.
module gracecg_simulation_magnetometer
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, fail_out_of_range, add_context
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
    contains
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

        integer :: i

        call self%check_settings(error)
        if (allocated(error)) return
        do i = 1, size(field, 2)
            call stream%normals(measured(:, i))
            measured(:, i) = field(:, i) + self%bias + self%noise*measured(:, i)
        end do
        if (.not. all(ieee_is_finite(measured))) then
            call fail(error, 'a magnetometer sample is not finite: look for NaN in the true '// &
                      'field and the bias')
            return
        end if
        if (self%limited) measured = max(-self%range, min(self%range, measured))
        if (self%quantised) measured = self%resolution*anint(measured/self%resolution)
    end subroutine measure

    subroutine check_settings(self, error)
        class(magnetometer_t), intent(in) :: self
        type(error_t), allocatable, intent(out) :: error

        if (.not. (self%noise >= 0 .and. self%noise <= LARGEST)) then
            call fail_out_of_range(error, 'noise', self%noise, 0.0_dp, LARGEST, 'T')
        else if (self%limited .and. .not. (self%range > 0 .and. self%range <= LARGEST)) then
            call fail_out_of_range(error, 'range', self%range, tiny(1.0_dp), LARGEST, 'T')
        else if (self%quantised .and. &
                 .not. (self%resolution > 0 .and. self%resolution <= LARGEST)) then
            call fail_out_of_range(error, 'resolution', self%resolution, tiny(1.0_dp), LARGEST, 'T')
        end if
        call add_context(error, 'magnetometer')
    end subroutine check_settings
end module gracecg_simulation_magnetometer
