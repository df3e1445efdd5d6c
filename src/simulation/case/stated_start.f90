!> The initial state of a case as its file states it: position and velocity in one of several forms, the attitude by a
!> quaternion or by one word.
module gracecg_simulation_stated_start
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, KILOMETRE
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_quaternion, only: quaternion_of_matrix
    use gracecg_base_vectors, only: cross, rotation_z
    use gracecg_files_settings, only: settings_t
    use gracecg_environment_earth_orientation, only: earth_orientation_t
    use gracecg_environment_time, only: utc_t, gmst_1982
    use gracecg_observations_knowledge, only: check_quaternion
    use gracecg_simulation_nadir_pointing, only: held_axes
    use gracecg_simulation_orbital_elements, only: kepler_state, tle_state
    implicit none
    private
    public :: stated_start_t, describe_start, find_start

    character(*), parameter :: STATE = 'state', EARTH_FIXED = 'earth-fixed', KEPLER = 'kepler', TLE = 'tle'
    character(16), parameter :: ORBITS(4) = [character(16) :: STATE, EARTH_FIXED, KEPLER, TLE]
    character(*), parameter :: GIVEN = 'given', BACKWARD = 'nadir-backward'
    character(16), parameter :: ATTITUDES(3) = [character(16) :: GIVEN, 'nadir', BACKWARD]
    character(16), parameter :: ANGLES(4:6) = [character(16) :: 'node_deg', 'perigee_deg', 'mean_anomaly_deg']
    real(dp), parameter :: LEAST_DISTANCE = 6.4e6_dp    !! From the Earth's centre, m
    character(*), parameter :: INSIDE = 'lies inside the Earth: at least 6400 km from its centre is allowed'

    !> How a file states it. What is written has the state and the attitude itself.
    type :: stated_start_t
        character(16) :: orbit = STATE          !! One of ORBITS
        real(dp) :: elements(6) = 0             !! Of `kepler_state`
        character(80) :: lines(2) = ''          !! Two-line elements
        character(16) :: attitude = GIVEN       !! One of ATTITUDES
    end type stated_start_t

contains

    !> The keys of position, velocity, attitude and angular velocity in group truth.
    subroutine describe_start(settings, start, position, velocity, quaternion, angular_velocity)
        class(settings_t), intent(inout) :: settings
        type(stated_start_t), intent(inout) :: start
        real(dp), intent(inout) :: position(3), velocity(3)     !! Inertial, or as `start` says, m, m/s
        real(dp), intent(inout) :: quaternion(4)                !! Inertial to body, scalar last
        real(dp), intent(inout) :: angular_velocity(3)          !! Body axes, rad/s

        character(16), parameter :: STATES(4) = [character(16) :: 'position', 'velocity', 'quaternion', 'angular_velocity']
        logical :: twice
        integer :: k

        call settings%text_value('orbit', start%orbit, 'how it is given, of the epoch', ORBITS)
        select case (start%orbit)
        case (KEPLER)
            call settings%real_value('semi_major_axis_km', start%elements(1), 6400.0_dp, 1e6_dp, 'km, osculating, J2000', &
                                     KILOMETRE, 'km', .true.)
            call settings%real_value('eccentricity', start%elements(2), 0.0_dp, 0.99_dp, '', required=.true.)
            call settings%real_value('inclination_deg', start%elements(3), 0.0_dp, 180.0_dp, 'deg', DEGREE, 'deg', .true.)
            do k = 4, 6
                call settings%real_value(trim(ANGLES(k)), start%elements(k), -360.0_dp, 360.0_dp, 'deg', DEGREE, 'deg', .true.)
            end do
            if (.not. start%elements(1)*(1 - start%elements(2)) > LEAST_DISTANCE) &
                call settings%reject('eccentricity', 'the perigee '//INSIDE)
        case (TLE)
            call settings%text_value('tle_1', start%lines(1), 'first of two-line elements', required=.true.)
            call settings%text_value('tle_2', start%lines(2), 'second of two-line elements', required=.true.)
        case default
            call settings%real_values('position', position, -1e9_dp, 1e9_dp, 'm, inertial J2000, or Earth-fixed', unit='m', &
                                      required=.true.)
            call settings%real_values('velocity', velocity, -1e5_dp, 1e5_dp, 'm/s, likewise', unit='m/s', required=.true.)
            if (.not. norm2(position) > LEAST_DISTANCE) call settings%reject('position', INSIDE)
        end select
        call settings%text_value('attitude', start%attitude, 'by quaternion and angular velocity, or z to the Earth and x '// &
                                 'along the velocity, or against it', ATTITUDES)
        if (start%attitude == GIVEN) then
            call settings%real_values('quaternion', quaternion, -1.0_dp, 1.0_dp, 'inertial to body, scalar last', required=.true.)
            call check_quaternion(settings, 'quaternion', quaternion)
            call settings%real_values('angular_velocity', angular_velocity, -1.0_dp, 1.0_dp, 'rad/s', unit='rad/s', &
                                      required=.true.)
        end if
        do k = 1, size(STATES)
            twice = merge(any(start%orbit == [character(16) :: KEPLER, TLE]), start%attitude /= GIVEN, k <= 2)
            if (twice .and. settings%holds('truth', trim(STATES(k)))) &
                call settings%reject(trim(STATES(k)), 'stands beside orbit or attitude that say it, too: leave it out')
        end do
    end subroutine describe_start

    !> The inertial state and the attitude that are stated; then nothing but these is. Fails as `tle_state`, and inside the
    !> Earth.
    subroutine find_start(start, epoch, ut1_minus_utc, earth, position, velocity, quaternion, angular_velocity, error)
        type(stated_start_t), intent(inout) :: start
        type(utc_t), intent(in) :: epoch
        real(dp), intent(in) :: ut1_minus_utc                   !! s
        type(earth_orientation_t), intent(in) :: earth          !! From the epoch on
        real(dp), intent(inout) :: position(3), velocity(3)     !! As stated, then inertial, m, m/s
        real(dp), intent(inout) :: quaternion(4)                !! Inertial to body, scalar last
        real(dp), intent(inout) :: angular_velocity(3)          !! Body axes, rad/s
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: to_inertial(3, 3), axes(3, 3)

        to_inertial = transpose(earth%from_inertial(0.0_dp))
        select case (start%orbit)
        case (EARTH_FIXED)
            position = matmul(to_inertial, position)
            velocity = matmul(to_inertial, velocity) + cross(earth%rate*earth%axis(), position)
        case (KEPLER)
            call kepler_state(start%elements, position, velocity)
        case (TLE)
            call tle_state(start%lines, epoch, position, velocity, error)
            if (allocated(error)) return
            to_inertial = matmul(to_inertial, rotation_z(gmst_1982(epoch, ut1_minus_utc)))
            position = matmul(to_inertial, position)
            velocity = matmul(to_inertial, velocity)
        end select
        if (.not. norm2(position) > LEAST_DISTANCE) call fail(error, 'the position '//INSIDE)
        if (start%attitude /= GIVEN .and. .not. allocated(error)) then
            axes = held_axes(start%attitude /= BACKWARD, [position, velocity])
            quaternion = quaternion_of_matrix(axes)
            angular_velocity = matmul(axes, cross(position, velocity))/sum(position**2)
        end if
        start = stated_start_t()
    end subroutine find_start
end module gracecg_simulation_stated_start
