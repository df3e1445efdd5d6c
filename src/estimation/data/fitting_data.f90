!> Preprocessing and interpolation of CSR-TM-00-01 section 4.5: star-camera quaternions turned to body
!> axes, freed of sign flips and normalised; quaternions and magnetic flux density interpolated to
!> the accelerometer's epochs; a first guess of the rotation. What the data lack is made up for as far as
!> possible, with a warning.
module gracecg_estimation_fitting_data
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_base_vectors, only: cross
    use gracecg_base_quaternion, only: normalised
    use gracecg_environment_time, only: sidereal_angle
    use gracecg_spacecraft_torque_rods, only: dipole_moment
    use gracecg_observations_observation_set, only: observation_set_t, check_observations, has_orbit, has_star_camera
    use gracecg_estimation_interpolation, only: interpolation_t, interpolation_at, interpolated
    use gracecg_estimation_repeated_samples, only: drop_repeated_samples, drop_stuck_samples
    use gracecg_estimation_star_attitude, only: star_attitude_t, take_star_attitude
    use gracecg_estimation_field_fallback, only: complete_field, compare_field
    use gracecg_estimation_first_guess, only: guess_rotation
    use gracecg_estimation_options, only: estimation_options_t
    implicit none
    private
    public :: fitting_data_t, preprocess

    !> What the estimators work on. Fitting epochs are t = k h, k = 0..n.
    type :: fitting_data_t
        integer :: steps = 0                            !! n
        real(dp) :: interval = 0                        !! h, s
        integer, allocatable :: accelerometer_epoch(:)  !! k of each accelerometer sample, increasing
        real(dp), allocatable :: acceleration(:, :)     !! (3, samples), m/s^2
        real(dp), allocatable :: angular(:, :)
        !! (3, samples), rad/s^2, of size 0 without angular channels; of several accelerometers their contrasts, m/s^2, 3 each
        integer, allocatable :: attitude_epoch(:)       !! k of each attitude pseudo-observation
        real(dp), allocatable :: quaternion(:, :)       !! (4, pseudo-observations), inertial to body
        type(interpolation_t), allocatable :: attitude_source(:)    !! Where each comes from
        type(star_attitude_t) :: stars                  !! Star-camera samples before interpolation
        real(dp) :: guess_quaternion(4) = 0             !! First guess at the epoch, inertial to body
        real(dp) :: guess_angular_velocity(3) = 0       !! The same of the angular velocity, rad/s
        real(dp), allocatable :: dipole(:, :)           !! m at 0, h/2 ... n h: (3, 2n + 1), A m^2; 0 of torquers
        real(dp), allocatable :: field(:, :)            !! B at the same times: (3, 2n + 1), T
        logical :: field_compared = .false.             !! With the geomagnetic model: what follows is known
        real(dp) :: field_seen(3) = 0, field_modelled(3) = 0    !! Means over the arc, body axes, T
        real(dp), allocatable :: torque(:, :)
        !! m x B, or that of torquers, and what is known of other torques, at the same times: (3, 2n + 1), N m
        real(dp), allocatable :: orbit_time(:)          !! s; empty: no orbit known
        real(dp), allocatable :: orbit_position(:, :)   !! (3, positions), inertial J2000, m
        type(string_t), allocatable :: warnings(:)      !! What is wrong with the data and bridged
    end type fitting_data_t

contains

    !> Prepares an observation set for estimation.
    !>
    !> What has no star camera is prepared for those alone that can do without the attitude; the operator then
    !> knows the angular velocity.
    !>
    !> Fails when the observations are refused by check_observations, when there are too few attitudes, or when the magnetometer
    !> leaves a gap that the field model cannot fill.
    subroutine preprocess(observations, options, data, error, without_attitude)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options       !! May give the first guess of the rotation
        type(fitting_data_t), intent(out) :: data
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: without_attitude       !! The caller can do without; absent: no

        type(observation_set_t) :: clean
        real(dp) :: quaternion(4)
        logical :: attitude_needed

        allocate (data%warnings(0))
        call check_observations(observations, error)
        if (allocated(error)) return
        clean = observations
        if (clean%knowledge%line%number > 1) then
            call clean%knowledge%line%combine(clean%acceleration, clean%further_acceleration, clean%angular_acceleration)
            deallocate (clean%further_acceleration)
        end if
        call drop_repeated_samples(clean, data%warnings)
        call drop_stuck_samples(clean, data%warnings)
        call apply_knowledge(clean)
        data%interval = clean%knowledge%accelerometer_interval
        data%steps = nint(clean%knowledge%duration/data%interval)
        call take_accelerations(clean, data)
        if (has_orbit(clean)) then
            data%orbit_time = clean%orbit_time
            data%orbit_position = clean%orbit_position
        else
            allocate (data%orbit_time(0), data%orbit_position(3, 0))
        end if
        data%guess_quaternion = [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]        ! gives a sign to the first quaternion
        if (is_given(options%guess_quaternion)) data%guess_quaternion = normalised(options%guess_quaternion)
        call take_star_attitude(clean, data%guess_quaternion, data%stars, data%warnings)
        attitude_needed = .true.
        if (present(without_attitude)) attitude_needed = .not. without_attitude
        call take_attitude(clean%knowledge%star_camera_interval, attitude_needed, data, error)
        if (allocated(error)) return
        call take_torque(clean, data, error)
        if (allocated(error)) return
        if (.not. has_star_camera(clean)) return
        call compare_field(clean, data%stars, data%field_seen, data%field_modelled, data%field_compared)
        call guess_rotation(data%stars%time, data%stars%quaternion, quaternion, data%guess_angular_velocity)
        if (.not. is_given(options%guess_quaternion)) data%guess_quaternion = quaternion
        if (is_given(options%guess_angular_velocity)) data%guess_angular_velocity = options%guess_angular_velocity
    end subroutine preprocess

    !> Takes out of the samples what the operator knows of their errors: accelerometer scale factors and
    !> magnetometer bias. The accelerometer's delay is taken out of all other times, which from then on count
    !> as its time tags do, so that its samples stay at the fitting epochs.
    subroutine apply_knowledge(observations)
        type(observation_set_t), intent(inout) :: observations

        integer :: i

        associate (knowledge => observations%knowledge)
            if (any(abs(knowledge%accelerometer_scale - 1) > 0)) &
                observations%acceleration = observations%acceleration/ &
                    spread(knowledge%accelerometer_scale, 2, size(observations%acceleration, 2))
            if (knowledge%line%number > 1) &
                observations%angular_acceleration = observations%angular_acceleration/ &
                    spread([(knowledge%accelerometer_scale, i=2, knowledge%line%number)], 2, &
                           size(observations%angular_acceleration, 2))
            if (any(abs(knowledge%magnetometer_bias) > 0)) &
                observations%field = observations%field - &
                    spread(knowledge%magnetometer_bias, 2, size(observations%field, 2))
            if (.not. abs(knowledge%accelerometer_delay) > 0) return
            observations%star_camera_time = observations%star_camera_time + knowledge%accelerometer_delay
            observations%magnetometer_time = observations%magnetometer_time + knowledge%accelerometer_delay
            if (has_orbit(observations)) &
                observations%orbit_time = observations%orbit_time + knowledge%accelerometer_delay
            knowledge%rods%delay = knowledge%rods%delay + knowledge%accelerometer_delay
            knowledge%sidereal_angle = sidereal_angle(knowledge%sidereal_angle, -knowledge%accelerometer_delay)
            associate (earth => knowledge%earth_parameters)     ! UT1 that is early turns the Earth back
                earth%ut1_minus_utc = earth%ut1_minus_utc - knowledge%accelerometer_delay
            end associate
        end associate
    end subroutine apply_knowledge

    !> An option of which 0 says that it is not given.
    pure logical function is_given(values)
        real(dp), intent(in) :: values(:)

        is_given = .not. all(abs(values) <= 0)
    end function is_given

    !> Accelerometer samples with the index of their epoch.
    subroutine take_accelerations(observations, data)
        type(observation_set_t), intent(in) :: observations
        type(fitting_data_t), intent(inout) :: data

        integer :: apart

        associate (times => observations%accelerometer_time)
            data%accelerometer_epoch = nint(times/data%interval)
            apart = 1       ! epochs from sample to sample: means of `level1 prepare` have one a second
            if (size(times) > 1) apart = minval(data%accelerometer_epoch(2:) - data%accelerometer_epoch(:size(times) - 1))
            if (size(times) < data%steps/apart) then
                call append(data%warnings, 'accelerometer: '//integer_text(data%steps/apart - size(times))// &
                            ' of '//integer_text(data%steps/apart)//' samples are missing')
            end if
        end associate
        data%acceleration = observations%acceleration
        allocate (data%angular(3, 0))
        if (allocated(observations%angular_acceleration)) data%angular = observations%angular_acceleration
    end subroutine take_accelerations

    !> The interpolation (4-38), (4-40), (4-42), (4-44) of the quaternions.
    subroutine take_attitude(star_camera_interval, needed, data, error)
        real(dp), intent(in) :: star_camera_interval    !! s
        logical, intent(in) :: needed                   !! Too few attitudes are an error
        type(fitting_data_t), intent(inout) :: data
        type(error_t), allocatable, intent(out) :: error

        type(interpolation_t) :: source
        integer :: k, used

        allocate (data%attitude_epoch(data%steps), data%quaternion(4, data%steps))
        allocate (data%attitude_source(data%steps))
        used = 0
        do k = 1, data%steps
            source = interpolation_at(data%stars%time, k*data%interval, star_camera_interval)
            if (.not. source%supported) cycle
            used = used + 1
            data%attitude_epoch(used) = k
            data%attitude_source(used) = source
            data%quaternion(:, used) = normalised(interpolated(data%stars%quaternion, source))
        end do
        data%attitude_epoch = data%attitude_epoch(:used)
        data%attitude_source = data%attitude_source(:used)
        data%quaternion = data%quaternion(:, :used)
        if (used >= 3 .or. .not. needed) return
        if (size(data%stars%time) == 0) then
            call fail(error, 'star camera: no samples; assest-fde and assest-rde alone do without, by the angular '// &
                      'velocity of the setup')
        else
            call fail(error, 'star camera: too few samples for an attitude')
        end if
    end subroutine take_attitude

    !> The torque of the manoeuvre at every half step, of rods m x B (2-25) with the interpolated field
    !> (4-39), (4-41), (4-43), of torquers without one, and the known change of the other torques over the arc, which is 0 in
    !> its middle.
    subroutine take_torque(observations, data, error)
        type(observation_set_t), intent(in) :: observations
        type(fitting_data_t), intent(inout) :: data
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: times(:), field(:, :)
        type(interpolation_t) :: source
        real(dp) :: t, late
        integer :: j

        late = observations%knowledge%accelerometer_delay
        if (.not. observations%knowledge%rods%direct) &
            call complete_field(observations, data%stars, times, field, data%warnings, error)
        if (allocated(error)) return
        allocate (data%dipole(3, 2*data%steps + 1), data%field(3, 2*data%steps + 1), data%torque(3, 2*data%steps + 1), &
                  source=0.0_dp)
        do j = 0, 2*data%steps
            t = j*data%interval/2
            data%torque(:, j + 1) = (j/(2.0_dp*data%steps) - 0.5_dp)*observations%knowledge%torque_change
            if (observations%knowledge%rods%direct) then
                data%torque(:, j + 1) = data%torque(:, j + 1) + dipole_moment(observations%knowledge%rods, t)
                cycle
            end if
            ! a delay moves the samples beyond the reach of an end: the field there stays
            source = interpolation_at(times, min(max(t, late), data%steps*data%interval + late), &
                                      observations%knowledge%magnetometer_interval)
            if (.not. source%supported) then
                call fail(error, 'magnetometer: no samples near '//number_text(t)//' s (repetitions of one value do not count)')
                if (.not. has_orbit(observations)) error%message = error%message// &
                    '; with the orbit in the set, a field model would stand in'
                return
            end if
            data%dipole(:, j + 1) = dipole_moment(observations%knowledge%rods, t)
            data%field(:, j + 1) = interpolated(field, source)
            data%torque(:, j + 1) = data%torque(:, j + 1) + cross(data%dipole(:, j + 1), data%field(:, j + 1))
        end do
    end subroutine take_torque
end module gracecg_estimation_fitting_data
