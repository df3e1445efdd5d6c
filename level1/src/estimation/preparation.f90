!> One span of a calibration from Level-1 files as an ordinary observation set: GPS time from the span's beginning, SRF
!> for body axes, the rods as they were measured, with gains and delays by the attitude, accelerations without the rods'
!> leakage where the spans together determine it.
module gracecg_level1_preparation
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_coloured_noise, only: ONE_SIDED
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_text, only: integer_text
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series
    use gracecg_spacecraft_torque_rods, only: take_measured_moments
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_observations_observation_set, only: observation_set_t, check_observations
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_series, only: interpolate
    use gracecg_environment_time, only: utc_of_gps
    implicit none
    private
    public :: prepare_observations

    real(dp), parameter :: MOMENT_STEP = 0.1_dp     !! Of the moments, s
    real(dp), parameter :: SAMPLES_A_SECOND = 10, SAMPLE_INTERVAL = 1/SAMPLES_A_SECOND      !! Of the set's accelerometer, s
    real(dp), parameter :: MOMENT_MARGIN = 1        !! Before and behind the arc, s

contains

    !> The observation set of a span. Fails when the span is not used, or no estimator could use the set.
    subroutine prepare_observations(calibration, setup, estimate, number, observations, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(in) :: estimate
        integer, intent(in) :: number               !! Of the span
        type(observation_set_t), intent(out) :: observations
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: IDENTITY_QUATERNION(4) = [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
        type(moment_series_t) :: moments
        real(dp) :: zero, length
        integer, allocatable :: wanted(:)
        real(dp), allocatable :: samples(:, :)
        integer :: k

        associate (span => calibration%spans(number))
            if (.not. span%used) then
                call fail(error, 'span '//integer_text(number)//' is not usable: '//trim(span%reason))
                return
            end if
            zero = real(ceiling(span%start) + 1, dp)    ! a sample lies within an interval behind it
            length = real(floor(span%stop - zero) - 1, dp)
            associate (knowledge => observations%knowledge)
                knowledge%name = 'GRACE-'//calibration%satellite//' '//calibration%date//' span '//integer_text(number)
                knowledge%epoch = utc_of_gps(calibration%epoch + nint(zero, i8), 0.0_dp)
                knowledge%duration = length
                knowledge%mass = setup%mass
                knowledge%inertia = setup%inertia
                knowledge%accelerometer_interval = SAMPLE_INTERVAL
                knowledge%star_camera_interval = 1
                knowledge%magnetometer_interval = 1
                knowledge%mounting = spread(IDENTITY_QUATERNION, 2, size(knowledge%mounting, 2))
                knowledge%star_camera_sigma = estimate%rods%rms
                knowledge%accelerometer_noise%sides = ONE_SIDED
                knowledge%accelerometer_noise%level = 2*knowledge%accelerometer_interval*estimate%solutions(1)%rms**2
                knowledge%a_priori%sigma_magnetometer_bias = setup%field_sigma
                knowledge%a_priori%sigma_scale_factors = max(1e-6_dp, setup%scale_sigma)
                knowledge%a_priori%sigma_rod_gain = max(1e-4_dp, maxval(estimate%rods%gain_sigma))
                call measured_rods(calibration, setup, estimate, zero, length, moments, error)
                if (allocated(error)) return
                call take_measured_moments(moments, knowledge%rods)
            end associate
            samples = span%linear
            if (estimate%solutions(1)%leakage == 'estimated') samples = samples - &
                matmul(estimate%solutions(1)%leak, estimate%motion(number)%current) - &
                matmul(estimate%solutions(1)%leak_rate, estimate%motion(number)%current_rate)
            call resample(span%time - zero - estimate%accelerometer_delay, samples, length, observations)
            wanted = pack([(k, k=1, size(span%attitude_time))], span%attitude_time >= zero .and. &
                          span%attitude_time <= zero + length)
            observations%star_camera_time = span%attitude_time(wanted) - zero
            observations%star_camera_head = 0*wanted + 1
            observations%quaternion = span%quaternion(:, wanted)
            observations%magnetometer_time = observations%star_camera_time
            observations%field = span%field(:, wanted)
            observations%orbit_time = observations%star_camera_time
            observations%orbit_position = span%position(:, wanted)
        end associate
        call check_observations(observations, error)
    end subroutine prepare_observations

    !> The accelerometer at whole tenths of a second, as estimators need it, by the cubic through the four nearest of its
    !> samples (every 0.099991 s, at odd fractions); none where samples are missing.
    subroutine resample(time, samples, length, observations)
        real(dp), intent(in) :: time(:), samples(:, :)      !! s from the beginning of the arc; m/s^2
        real(dp), intent(in) :: length                      !! Of the arc, s
        type(observation_set_t), intent(inout) :: observations

        real(dp), parameter :: LONGEST_STEP = 1.5_dp*SAMPLE_INTERVAL
        real(dp) :: all_times(floor(length/SAMPLE_INTERVAL + 1e-6_dp) + 1), values(3, size(all_times))
        logical :: there(size(all_times))
        integer :: i, k

        do i = 1, size(all_times)
            all_times(i) = (i - 1)/SAMPLES_A_SECOND
            k = last_not_after(time, all_times(i))
            there(i) = k >= 1 .and. k < size(time)
            if (there(i)) there(i) = time(k + 1) - time(k) < LONGEST_STEP
            values(:, i) = 0
            if (there(i)) call interpolate(time, samples, all_times(i), values(:, i))
        end do
        observations%accelerometer_time = pack(all_times, there)
        observations%acceleration = values(:, pack([(k, k=1, size(there))], there))
    end subroutine resample

    !> The moments of the rods, kappa_k I_k(t - tau) with the gains by the attitude.
    subroutine measured_rods(calibration, setup, estimate, zero, length, moments, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(in) :: estimate
        real(dp), intent(in) :: zero, length        !! Begin of the arc from the epoch, and its length, s
        type(moment_series_t), intent(out) :: moments
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: time(:), moment(:, :)
        real(dp) :: current(3), first, last
        integer :: i, n

        ! Whatever lies beyond the currents that there are is left to the series' own ends.
        first = max(-MOMENT_MARGIN, calibration%current_time(1) - zero)
        last = min(length + MOMENT_MARGIN, calibration%current_time(size(calibration%current_time)) - zero)
        n = floor((last - first)/MOMENT_STEP) + 1
        allocate (time(n), moment(3, n))
        do i = 1, n
            time(i) = first + (i - 1)*MOMENT_STEP
            call estimate%drive%at(zero + time(i) - estimate%rods%delay, current)
            moment(:, i) = estimate%rods%gain*setup%rod_gain*setup%rod_sign*current
        end do
        call new_moment_series(moments, time, moment, error)
    end subroutine measured_rods
end module gracecg_level1_preparation
