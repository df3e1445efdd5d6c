!> The observation set of one calibration: the only thing that simulation and estimation share.
!>
!> It holds what the instruments delivered and what an operator knows. It never holds the truth.
module gracecg_observations_observation_set
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_RADIUS_IGRF
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: integer_text
    use gracecg_spacecraft_mass_properties, only: mass_properties_t, validate_mass_properties
    use gracecg_spacecraft_moment_series, only: has_moments, check_moments_cover
    use gracecg_spacecraft_torque_rods, only: check_rod_sampling
    use gracecg_observations_knowledge, only: operator_knowledge_t, HEADS
    implicit none
    private
    public :: observation_set_t, check_observations, has_orbit, has_star_camera, SAMPLE_TOLERANCE, &
        LARGEST_ACCELERATION, LARGEST_FIELD

    !> Samples of the three instruments, and the orbit if it is known (GPS), for the model that stands
    !> in for a lost magnetometer. Times are seconds from the epoch.
    type :: observation_set_t
        type(operator_knowledge_t) :: knowledge              !! What else the operator knows
        real(dp), allocatable :: accelerometer_time(:)  !! (n), s, multiples of its interval, within 1 %
        real(dp), allocatable :: acceleration(:, :)     !! (3, n), body axes, m/s^2
        real(dp), allocatable :: further_acceleration(:, :, :)
        !! (3, n, others), of the accelerometers beyond the first, at the same times, m/s^2, where there are several
        real(dp), allocatable :: angular_acceleration(:, :)
        !! (3, n), body axes, rad/s^2, where the accelerometer has angular channels
        real(dp), allocatable :: star_camera_time(:)    !! (p)
        integer, allocatable :: star_camera_head(:)     !! (p), 1..HEADS
        real(dp), allocatable :: quaternion(:, :)       !! (4, p), inertial to camera, scalar last
        real(dp), allocatable :: magnetometer_time(:)   !! (r)
        real(dp), allocatable :: field(:, :)            !! (3, r), body axes, T
        real(dp), allocatable :: orbit_time(:)          !! (s); not allocated or empty: no orbit known
        real(dp), allocatable :: orbit_position(:, :)   !! (3, s), inertial J2000, m
    end type observation_set_t

    real(dp), parameter :: MOST_EPOCHS = 1e6_dp             !! Of an arc: a day at ten samples a second
    real(dp), parameter :: SAMPLE_TOLERANCE = 1e-4_dp       !! Of the length of a star-camera quaternion
    real(dp), parameter :: LARGEST_ACCELERATION = 1         !! Of a satellite in free fall, m/s^2
    real(dp), parameter :: LARGEST_FIELD = 1e-3_dp          !! Fifteen times the Earth's, T

contains

    !> True when the set has an orbit.
    pure logical function has_orbit(observations)
        type(observation_set_t), intent(in) :: observations

        has_orbit = allocated(observations%orbit_time)
        if (has_orbit) has_orbit = size(observations%orbit_time) > 0
    end function has_orbit

    !> True when a star camera delivered something.
    pure logical function has_star_camera(observations)
        type(observation_set_t), intent(in) :: observations

        has_star_camera = size(observations%star_camera_time) > 0
    end function has_star_camera

    !> Refuses what no estimator could use: empty or inconsistent series, NaN, times that go back, accelerometer times that are
    !> no multiples of its interval or outside the arc, two different samples of one time, values of another unit, quaternions
    !> that are not unit, an impossible inertia tensor.
    !> A sample that is given twice, alike, passes. Rods without a magnetometer need an orbit; without a
    !> star camera the operator must know the angular velocity.
    subroutine check_observations(observations, error)
        type(observation_set_t), intent(in) :: observations
        type(error_t), allocatable, intent(out) :: error

        call check_sizes(observations, error)
        if (.not. allocated(error)) call check_setup(observations%knowledge, error)
        if (.not. allocated(error)) call check_accelerometer(observations, error)
        if (.not. allocated(error)) call check_magnetometer(observations, error)
        if (.not. allocated(error)) call check_star_camera(observations, error)
        if (.not. allocated(error) .and. has_orbit(observations)) call check_orbit(observations, error)
    end subroutine check_observations

    !> Fails unless every time tag has its sample.
    subroutine check_sizes(observations, error)
        type(observation_set_t), intent(in) :: observations
        type(error_t), allocatable, intent(out) :: error

        call require('accelerometer_time, acceleration', allocated(observations%accelerometer_time) .and. &
                     allocated(observations%acceleration))
        call require('magnetometer_time, field', allocated(observations%magnetometer_time) .and. allocated(observations%field))
        call require('star_camera_time, star_camera_head, quaternion', allocated(observations%star_camera_time) .and. &
                     allocated(observations%star_camera_head) .and. allocated(observations%quaternion))
        call require('orbit_time, orbit_position', &
                     allocated(observations%orbit_time) .eqv. allocated(observations%orbit_position))
        if (observations%knowledge%line%number > 1) &
            call require('further_acceleration', allocated(observations%further_acceleration))
        if (allocated(error)) return
        call compare('accelerometer', size(observations%accelerometer_time), &
                     size(observations%acceleration, 2))
        if (observations%knowledge%line%number > 1) then
            call compare('further accelerometers', size(observations%accelerometer_time), &
                         size(observations%further_acceleration, 2))
            call compare('accelerometers', observations%knowledge%line%number, &
                         size(observations%further_acceleration, 3) + 1)
        end if
        call compare('magnetometer', size(observations%magnetometer_time), size(observations%field, 2))
        call compare('star camera', size(observations%star_camera_time), size(observations%quaternion, 2))
        call compare('star camera, heads', size(observations%star_camera_time), &
                     size(observations%star_camera_head))
        if (allocated(observations%orbit_time)) &
            call compare('orbit', size(observations%orbit_time), size(observations%orbit_position, 2))

    contains

        subroutine require(names, there)
            character(*), intent(in) :: names       !! Of components
            logical, intent(in) :: there

            if (.not. (allocated(error) .or. there)) call fail(error, 'not all of '//names//' are allocated: of an '// &
                                                               'instrument without samples they are of size 0')
        end subroutine require

        subroutine compare(name, times, samples)
            character(*), intent(in) :: name
            integer, intent(in) :: times, samples

            if (allocated(error) .or. times == samples) return
            call fail(error, name//': '//integer_text(times)//' time tags, but '// &
                      integer_text(samples)//' samples')
        end subroutine compare
    end subroutine check_sizes

    subroutine check_setup(knowledge, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        if (.not. knowledge%duration > 0) then
            call fail(error, 'duration = '//number_text(knowledge%duration)//' s must be positive')
        else if (.not. all([knowledge%accelerometer_interval, knowledge%star_camera_interval, &
                            knowledge%magnetometer_interval] > 0)) then
            call fail(error, 'the sampling intervals of accelerometer, star camera and '// &
                      'magnetometer must be positive')
        else if (.not. knowledge%duration <= MOST_EPOCHS*knowledge%accelerometer_interval) then
            call fail(error, 'duration = '//number_text(knowledge%duration)//' s is more than '// &
                      number_text(MOST_EPOCHS)//' sampling intervals of the accelerometer')
        else if (knowledge%camera < 0 .or. knowledge%camera > HEADS) then
            call fail(error, 'star camera: head '//integer_text(knowledge%camera)//' does not exist')
        else
            call validate_mass_properties(mass_properties_t(knowledge%mass, knowledge%inertia), error)
            if (.not. allocated(error)) call check_instruments(knowledge, error)
            if (.not. allocated(error)) &
                call check_rod_sampling(knowledge%rods, knowledge%accelerometer_interval, error)
            if (.not. allocated(error) .and. has_moments(knowledge%rods%measured)) &
                call check_moments_cover(knowledge%rods%measured, knowledge%duration, error)
        end if
    end subroutine check_setup

    !> What is known of instruments and torque has to be finite, and a scale factor positive.
    subroutine check_instruments(knowledge, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        if (.not. all(knowledge%accelerometer_scale > 0)) then
            call fail(error, 'the scale factors of the accelerometer must be positive')
        else if (.not. all(abs([knowledge%accelerometer_scale, knowledge%accelerometer_delay, &
                                knowledge%magnetometer_bias, knowledge%torque_change, knowledge%rods%gain, &
                                knowledge%rods%misalignment, knowledge%rods%delay, &
                                knowledge%angular_velocity, knowledge%angular_velocity_sigma]) <= huge(1.0_dp))) then
            call fail(error, 'what is known of accelerometer, magnetometer, rods, torque and rotation must be finite')
        end if
    end subroutine check_instruments

    subroutine check_accelerometer(observations, error)
        type(observation_set_t), intent(in) :: observations
        type(error_t), allocatable, intent(out) :: error

        integer :: k

        if (size(observations%accelerometer_time) < 2) then
            call fail(error, 'accelerometer: fewer than two samples')
            return
        end if
        call check_series('accelerometer', observations%accelerometer_time, &
                          observations%acceleration, error)
        if (.not. allocated(error)) &
            call check_epochs(observations%accelerometer_time, observations%knowledge%accelerometer_interval, &
                              observations%knowledge%duration, error)
        if (.not. allocated(error)) &
            call check_magnitude('accelerometer', observations%accelerometer_time, &
                                 observations%acceleration, LARGEST_ACCELERATION, 'm/s^2', error)
        if (.not. allocated(error)) &
            call check_saturation('accelerometer', observations%accelerometer_time, observations%acceleration, &
                                  observations%knowledge%accelerometer_range, 'm/s^2', error)
        do k = 2, merge(1, observations%knowledge%line%number, allocated(error))
            associate (samples => observations%further_acceleration(:, :, k - 1), time => observations%accelerometer_time, &
                       name => 'accelerometer '//integer_text(k))
                call check_series(name, time, samples, error)
                if (.not. allocated(error)) call check_magnitude(name, time, samples, LARGEST_ACCELERATION, 'm/s^2', error)
                if (.not. allocated(error)) call check_saturation(name, time, samples, &
                                                                  observations%knowledge%accelerometer_range, 'm/s^2', error)
            end associate
            if (allocated(error)) return
        end do
    end subroutine check_accelerometer

    !> The accelerometer samples at multiples of its interval, within the arc.
    subroutine check_epochs(times, interval, duration, error)
        real(dp), intent(in) :: times(:)                !! Rising; equal where a sample is given twice
        real(dp), intent(in) :: interval, duration      !! s
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: WITHIN = 0.01_dp         ! sampling intervals
        integer :: i, k, previous, steps

        steps = nint(duration/interval)
        previous = -1
        do i = 1, size(times)
            k = nint(min(max(times(i)/interval, -1.0_dp), steps + 1.0_dp))
            if (k < 0 .or. k > steps) then
                call fail(error, 'accelerometer: time '//number_text(times(i))//' s lies outside the arc of '// &
                          number_text(steps*interval)//' s')
            else if (abs(times(i) - k*interval) > WITHIN*interval) then
                call fail(error, 'accelerometer: time '//number_text(times(i))//' s is not a multiple of the sampling interval '// &
                          number_text(interval)//' s')
            else if (k == previous) then
                if (times(i) > times(i - 1)) &
                    call fail(error, 'accelerometer: two samples near '//number_text(times(i))//' s')
            end if
            if (allocated(error)) return
            previous = k
        end do
    end subroutine check_epochs

    subroutine check_magnetometer(observations, error)
        type(observation_set_t), intent(in) :: observations
        type(error_t), allocatable, intent(out) :: error

        if (size(observations%magnetometer_time) < 2 .and. observations%knowledge%rods%direct) return
        if (size(observations%magnetometer_time) < 2 .and. .not. has_orbit(observations)) then
            call fail(error, 'magnetometer: fewer than two samples, and no orbit along which a '// &
                      'field model could stand in')
            return
        end if
        call check_series('magnetometer', observations%magnetometer_time, observations%field, error)
        if (.not. allocated(error)) &
            call check_magnitude('magnetometer', observations%magnetometer_time, observations%field, &
                                 LARGEST_FIELD, 'T', error)
        if (.not. allocated(error)) &
            call check_saturation('magnetometer', observations%magnetometer_time, observations%field, &
                                  observations%knowledge%magnetometer_range, 'T', error)
    end subroutine check_magnetometer

    !> Refuses a sample that is too large for any satellite: it was written in another unit.
    subroutine check_magnitude(name, times, values, largest, unit, error)
        character(*), intent(in) :: name
        real(dp), intent(in) :: times(:), values(:, :)
        real(dp), intent(in) :: largest         !! Allowed absolute value of a component
        character(*), intent(in) :: unit
        type(error_t), allocatable, intent(out) :: error

        integer :: k

        do k = 1, size(times)
            if (all(abs(values(:, k)) <= largest)) cycle
            call fail(error, name//': the sample at '//number_text(times(k))//' s has a component of '// &
                      number_text(maxval(abs(values(:, k))))//' '//unit//', more than '// &
                      number_text(largest)//' '//unit//'; samples have to be in '//unit)
            return
        end do
    end subroutine check_magnitude

    !> Refuses samples at the full scale of an instrument, where that is known: what they say is wrong, and a fit
    !> would take it for true.
    subroutine check_saturation(name, times, values, full_scale, unit, error)
        character(*), intent(in) :: name
        real(dp), intent(in) :: times(:), values(:, :)
        real(dp), intent(in) :: full_scale      !! 0: not known
        character(*), intent(in) :: unit
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: WITHIN = 1e-9_dp     ! of the full scale: what a file may round away
        logical, allocatable :: saturated(:)

        if (.not. full_scale > 0) return
        saturated = any(abs(values) >= (1 - WITHIN)*full_scale, 1)
        if (.not. any(saturated)) return
        call fail(error, name//': '//integer_text(count(saturated))//' of '//integer_text(size(times))// &
                  ' samples stand at its full scale of '//number_text(full_scale)//' '//unit//', the first at '// &
                  number_text(times(findloc(saturated, .true., 1)))//' s: it was saturated; leave these samples out, '// &
                  'or correct its range in setup.nml')
    end subroutine check_saturation

    !> Each head is a series of its own. One head may be lost altogether, both if the operator knows the
    !> angular velocity.
    subroutine check_star_camera(observations, error)
        type(observation_set_t), intent(in) :: observations
        type(error_t), allocatable, intent(out) :: error

        integer :: head, i

        associate (times => observations%star_camera_time, heads_of => observations%star_camera_head)
            if (size(times) == 0 .and. observations%knowledge%knows_angular_velocity()) then
                return
            else if (size(times) < 2) then
                call fail(error, 'star camera: fewer than two samples, and no angular velocity in the setup, by '// &
                          'which assest-fde and assest-rde alone do without')
                return
            else if (any(heads_of < 1 .or. heads_of > HEADS)) then
                call fail(error, 'star camera: a sample of a head that does not exist; there are '// &
                          integer_text(HEADS))
                return
            end if
            do head = 1, HEADS
                associate (own => pack([(i, i=1, size(times))], heads_of == head))
                    call check_series('star camera '//integer_text(head), times(own), &
                                      observations%quaternion(:, own), error)
                end associate
                if (allocated(error)) return
            end do
        end associate
        if (any(abs(norm2(observations%quaternion, 1) - 1) > SAMPLE_TOLERANCE)) then
            call fail(error, 'star camera: a quaternion is not of unit length')
        end if
    end subroutine check_star_camera

    subroutine check_orbit(observations, error)
        type(observation_set_t), intent(in) :: observations
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: FEWEST = 4        ! of the interpolation
        integer :: lowest

        associate (times => observations%orbit_time, position => observations%orbit_position)
            if (size(times) < FEWEST) then
                call fail(error, 'orbit: '//integer_text(size(times))//' positions, at least '// &
                          integer_text(FEWEST)//' are needed')
                return
            end if
            call check_series('orbit', times, position, error)
            if (allocated(error)) return
            lowest = minloc(norm2(position, 1), 1)
            if (norm2(position(:, lowest)) > EARTH_RADIUS_IGRF) return
            call fail(error, 'orbit: the position at '//number_text(times(lowest))//' s is '// &
                      number_text(norm2(position(:, lowest)))//' m from the centre of the Earth, '// &
                      'inside it; positions have to be in metres')
        end associate
    end subroutine check_orbit

    subroutine check_series(name, times, values, error)
        character(*), intent(in) :: name
        real(dp), intent(in) :: times(:), values(:, :)
        type(error_t), allocatable, intent(out) :: error

        integer :: k

        do k = 1, size(times)
            if (.not. abs(times(k)) <= huge(1.0_dp)) then
                call fail(error, name//': time tag '//integer_text(k)//' is NaN or infinite')
                return
            else if (.not. all(abs(values(:, k)) <= huge(1.0_dp))) then
                call fail(error, name//': the sample at '//number_text(times(k))// &
                          ' s is NaN or infinite; leave it out')
                return
            end if
        end do
        do k = 2, size(times)
            if (times(k) > times(k - 1)) cycle
            if (times(k) >= times(k - 1)) then
                if (all(abs(values(:, k) - values(:, k - 1)) <= 0)) cycle   ! given twice
            end if
            call fail(error, name//': time tags must increase, but '//number_text(times(k))// &
                      ' s follows '//number_text(times(k - 1))//' s')
            if (times(k) >= times(k - 1)) error%message = error%message//' with another value'
            return
        end do
    end subroutine check_series
end module gracecg_observations_observation_set
