!> One span of a calibration from Level-1 files as an ordinary observation set: GPS time, SRF for body axes, the rods as they
!> were measured, with gains and delays by the estimate, accelerations without the rods' leakage where the spans together
!> determine it.
module gracecg_level1_preparation
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: integer_text
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, take_measured_moments, rod_moments
    use gracecg_level1_setup, only: level1_setup_t, QUIETEST
    use gracecg_observations_observation_set, only: observation_set_t, check_observations
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_gyros, only: gyro_axes_t
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_to_observations, only: arcs_of_spans
    implicit none
    private
    public :: prepare_observations

    real(dp), parameter :: MOMENT_STEP = 0.1_dp     !! Of the moments, s
    real(dp), parameter :: MOMENT_MARGIN = 1        !! Before and behind the arc, s

contains

    !> The observation set of a span, of one that a firing cuts the longest piece. Fails when the span is not used, or no
    !> estimator could use the set.
    subroutine prepare_observations(calibration, setup, estimate, number, observations, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(in) :: estimate
        integer, intent(in) :: number               !! Of the span
        type(observation_set_t), intent(out) :: observations
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t), allocatable :: arcs(:)
        type(gyro_axes_t) :: no_gyros
        type(torque_rods_t) :: rods
        type(moment_series_t) :: moments
        real(dp), allocatable :: time(:), moment(:, :)
        real(dp) :: per_current(3), late, first, last
        integer, allocatable :: span_of(:)
        integer :: i, n

        if (.not. calibration%spans(number)%used) then
            call fail(error, 'span '//integer_text(number)//' is not usable: '//trim(calibration%spans(number)%reason))
            return
        end if
        call arcs_of_spans(calibration, setup, no_gyros, estimate%steps, arcs, span_of, error)
        if (.not. allocated(error) .and. all(span_of /= number)) call fail(error, 'span '//integer_text(number)//' is too short')
        if (allocated(error)) return
        observations = arcs(maxloc([(merge(arcs(i)%knowledge%duration, 0.0_dp, span_of(i) == number), i=1, size(arcs))], 1))
        if (allocated(observations%angular_acceleration)) deallocate (observations%angular_acceleration)
        associate (knowledge => observations%knowledge)
            knowledge%name = trim(knowledge%name)//' span '//integer_text(number)
            knowledge%camera = 1
            knowledge%star_camera_sigma = estimate%head_sigma
            knowledge%accelerometer_noise%level = 2*knowledge%accelerometer_interval*max(QUIETEST, estimate%solutions(1)%rms)**2
            knowledge%accelerometer_delay = estimate%accelerometer_delay
            knowledge%a_priori%sigma_magnetometer_bias = setup%field_sigma
            knowledge%a_priori%sigma_scale_factors = max(1e-6_dp, setup%scale_sigma)
            knowledge%a_priori%sigma_rod_gain = max(1e-4_dp, maxval(estimate%rods%gain_sigma))
            rods = knowledge%rods
            rods%gain = estimate%rods%gain
            rods%delay = estimate%rods%delay
            late = estimate%rods%delay + estimate%accelerometer_delay
            per_current = setup%rod_gain*setup%rod_sign
            if (estimate%solutions(1)%leakage == 'estimated') then
                do i = 1, size(observations%accelerometer_time)
                    associate (t => observations%accelerometer_time(i) - estimate%accelerometer_delay, &
                               half => knowledge%accelerometer_interval/2, one => estimate%solutions(1))
                        observations%acceleration(:, i) = observations%acceleration(:, i) - &
                            matmul(one%leak, currents(t)) - matmul(one%leak_rate, currents(t + half) - currents(t - half))/(2*half)
                    end associate
                end do
            end if
            associate (measured => knowledge%rods%measured%time, n_measured => size(knowledge%rods%measured%time))
                ! as far as the series goes on by itself: a spacing beyond its ends
                first = max(-MOMENT_MARGIN, late + 2*measured(1) - measured(2))
                last = min(knowledge%duration + MOMENT_MARGIN, late + 2*measured(n_measured) - measured(n_measured - 1))
                n = floor((last - first)/MOMENT_STEP) + 1
                time = [(first + (i - 1)*MOMENT_STEP, i=1, n)]
            end associate
            allocate (moment(3, n))
            do i = 1, n
                moment(:, i) = rod_moments(rods, time(i))
            end do
            call new_moment_series(moments, time, moment, error)
            if (allocated(error)) return
            call take_measured_moments(moments, knowledge%rods)
        end associate
        call check_observations(observations, error)

    contains

        !> The currents at a time, mA.
        pure function currents(time) result(current)
            real(dp), intent(in) :: time
            real(dp) :: current(3)

            current = rod_moments(rods, time, .true.)/(rods%gain*per_current)
        end function currents
    end subroutine prepare_observations
end module gracecg_level1_preparation
