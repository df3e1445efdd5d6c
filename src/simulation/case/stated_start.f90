!> The initial state of a case as its file states it: position and velocity in one of several forms, the attitude by a
!> quaternion or by one word.
!>
!> Two-line elements are mean ones. Their state is that of the theory that they are made for (F. R. Hoots, R. L. Roehrich,
!> Spacetrack Report No. 3, 1980: SGP4): the same at the elements' epoch; away from it without its drag, but for the change
!> of the mean motion, and without J4 and the squares of J2, which is some 0.1 km after a day and some km after ten. The
!> elements themselves are good to 1 km or so.
module gracecg_simulation_stated_start
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, KILOMETRE, EARTH_GM, TWO_PI, SECONDS_PER_DAY
    use gracecg_base_error, only: error_t, fail, fail_out_of_range
    use gracecg_base_quaternion, only: quaternion_of_matrix
    use gracecg_base_vectors, only: cross, rotation_z
    use gracecg_files_settings, only: settings_t
    use gracecg_environment_earth_orientation, only: earth_orientation_t
    use gracecg_environment_time, only: utc_t, gmst_1982, seconds_between, modified_julian_day
    use gracecg_observations_knowledge, only: check_quaternion
    use gracecg_simulation_nadir_pointing, only: held_axes
    implicit none
    private
    public :: stated_start_t, describe_start, find_start, kepler_state, tle_state

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

    !> The Earth of two-line elements, WGS 72: m^3/s^2, m
    real(dp), parameter :: GM = 398600.8e9_dp, RADIUS = 6378135.0_dp, J2 = 1.082616e-3_dp, J3 = -2.53881e-6_dp
    real(dp), parameter :: FEWEST_TURNS = 6.4_dp, MOST_TURNS = 17   !! A day; with fewer the theory is another
    real(dp), parameter :: MOST_DAYS = 10                   !! From the elements' epoch

    !> Where a satellite stands in the plane of its orbit.
    type :: in_plane_t
        real(dp) :: distance = 0            !! m
        real(dp) :: angle = 0               !! From the node, rad
        real(dp) :: rising = 0, along = 0   !! Velocity away from the centre, and across that, m/s
    end type in_plane_t

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

    !> Position and velocity of osculating elements, in the axes of the elements.
    pure subroutine kepler_state(elements, position, velocity)
        real(dp), intent(in) :: elements(6)
        !! Semi-major axis (m), eccentricity, inclination, right ascension of the node, argument of the perigee, mean
        !! anomaly (rad)
        real(dp), intent(out) :: position(3), velocity(3)   !! m, m/s

        associate (e => elements(2), perigee => elements(5))
            call leave_plane(in_plane(EARTH_GM, elements(1), e*cos(perigee), e*sin(perigee), perigee + elements(6)), &
                             elements(3), elements(4), position, velocity)
        end associate
    end subroutine kepler_state

    !> Position and velocity at a time, in axes of the true equator and mean equinox of that time: about z by the sidereal
    !> angle of 1982 (GMST) from Earth-fixed ones. Fails for lines that are no two-line elements, for orbits of 225 minutes
    !> and more, and more than 10 days from the elements' epoch.
    subroutine tle_state(lines, time, position, velocity, error)
        character(*), intent(in) :: lines(2)    !! As published, 69 characters each
        type(utc_t), intent(in) :: time
        real(dp), intent(out) :: position(3), velocity(3)   !! m, m/s
        type(error_t), allocatable, intent(out) :: error

        type(in_plane_t) :: place
        character(8) :: wrong
        integer :: status
        real(dp) :: year, day, turns, n, a, e, i, node, perigee, anomaly, change, since, c, s, p, part, axn, ayn, u, twice

        position = 0
        velocity = 0
        wrong = ''
        read (lines(1), '(18x, f2.0, f12.8, 1x, f10.8)', iostat=status) year, day, change
        if (status /= 0 .or. .not. has_checksum(lines(1), '1')) wrong = 'first'
        read (lines(2), '(8x, f8.4, 1x, f8.4, 1x, f7.7, 1x, f8.4, 1x, f8.4, 1x, f11.8)', iostat=status) i, node, e, perigee, &
            anomaly, turns
        if (status /= 0 .or. .not. has_checksum(lines(2), '2')) wrong = 'second'
        if (wrong /= '') then
            call fail(error, 'the '//trim(wrong)//' of the two-line elements: it has to begin with its number and a blank, to '// &
                      'have 69 characters, and its last digit, the checksum, has to agree with the others')
        else if (.not. (turns >= FEWEST_TURNS .and. turns <= MOST_TURNS)) then
            call fail_out_of_range(error, 'two-line elements: mean motion', turns, FEWEST_TURNS, MOST_TURNS, 'revolutions a day')
        end if
        if (allocated(error)) return
        since = seconds_between(utc_t(modified_julian_day(merge(1900, 2000, year >= 57) + nint(year), 1, 1), 0.0_dp), time) - &
                (day - 1)*SECONDS_PER_DAY
        if (abs(since) > MOST_DAYS*SECONDS_PER_DAY) &
            call fail_out_of_range(error, 'two-line elements: time from them to the epoch', since/SECONDS_PER_DAY, &
                                   -MOST_DAYS, MOST_DAYS, 'days')
        if (allocated(error)) return
        c = cos(i*DEGREE)
        s = sin(i*DEGREE)
        ! the published mean motion is Kozai's: Brouwer's, and its semi-major axis
        n = turns*TWO_PI/SECONDS_PER_DAY
        part = 0.75_dp*J2*RADIUS**2*(3*c**2 - 1)/(1 - e**2)**1.5_dp
        a = (GM/n**2)**(1.0_dp/3)
        u = part/a**2
        u = part/(a*(1 - u*(1.0_dp/3 + u*(1 + u*134/81))))**2
        n = n/(1 + u)
        a = (GM/n**2)**(1.0_dp/3)
        ! secular changes
        part = 1.5_dp*J2*n*(RADIUS/(a*(1 - e**2)))**2
        node = node*DEGREE - part*c*since
        perigee = perigee*DEGREE + part*(5*c**2 - 1)/2*since
        anomaly = anomaly*DEGREE + (n + part*sqrt(1 - e**2)*(3*c**2 - 1)/2)*since + &
                  TWO_PI*change*(since/SECONDS_PER_DAY)**2
        ! of long period, by J3
        part = J3/J2*s*RADIUS/(a*(1 - e**2))
        axn = e*cos(perigee)
        ayn = e*sin(perigee) - part/2
        u = anomaly + perigee - part*(3 + 5*c)/(4*max(1 + c, 1e-9_dp))*axn
        ! of short period, by J2
        place = in_plane(GM, a, axn, ayn, u)
        p = a*(1 - axn**2 - ayn**2)
        part = J2*RADIUS**2/(2*p)
        twice = 2*place%angle
        place%distance = place%distance*(1 - 1.5_dp*part/p*sqrt(p/a)*(3*c**2 - 1)) + part/2*s**2*cos(twice)
        place%rising = place%rising - n*part*s**2*sin(twice)
        place%along = place%along + n*part*(s**2*cos(twice) + 1.5_dp*(3*c**2 - 1))
        place%angle = place%angle - part/p*(7*c**2 - 1)*sin(twice)/4
        call leave_plane(place, i*DEGREE + 1.5_dp*part/p*c*s*cos(twice), node + 1.5_dp*part/p*c*sin(twice), position, velocity)
    end subroutine tle_state

    !> The motion in the plane of an orbit, of its eccentricity's components along the node and across it.
    pure type(in_plane_t) function in_plane(gm, a, axn, ayn, u) result(place)
        real(dp), intent(in) :: gm              !! m^3/s^2
        real(dp), intent(in) :: a               !! m
        real(dp), intent(in) :: axn, ayn        !! e cos(perigee), e sin(perigee)
        real(dp), intent(in) :: u               !! Mean argument of the latitude, rad

        real(dp) :: eccentric, across, root, turn
        integer :: k

        eccentric = u
        do k = 1, 30
            turn = (u - ayn*cos(eccentric) + axn*sin(eccentric) - eccentric)/ &
                   (1 - axn*cos(eccentric) - ayn*sin(eccentric))
            eccentric = eccentric + max(-0.95_dp, min(0.95_dp, turn))
        end do
        across = axn*sin(eccentric) - ayn*cos(eccentric)
        root = sqrt(1 - axn**2 - ayn**2)
        place%distance = a*(1 - axn*cos(eccentric) - ayn*sin(eccentric))
        place%rising = sqrt(gm*a)*across/place%distance
        place%along = sqrt(gm*a)*root/place%distance
        place%angle = atan2(sin(eccentric) - ayn - axn*across/(1 + root), cos(eccentric) - axn + ayn*across/(1 + root))
    end function in_plane

    !> From the plane of an orbit into space.
    pure subroutine leave_plane(place, inclination, node, position, velocity)
        type(in_plane_t), intent(in) :: place
        real(dp), intent(in) :: inclination, node           !! rad
        real(dp), intent(out) :: position(3), velocity(3)   !! m, m/s

        real(dp) :: to_node(3), across(3), outward(3), forward(3)

        to_node = [cos(node), sin(node), 0.0_dp]
        across = [-sin(node)*cos(inclination), cos(node)*cos(inclination), sin(inclination)]
        outward = across*sin(place%angle) + to_node*cos(place%angle)
        forward = across*cos(place%angle) - to_node*sin(place%angle)
        position = place%distance*outward
        velocity = place%rising*outward + place%along*forward
    end subroutine leave_plane

    !> Number, length and checksum of a line: its digits add up to the last, a minus counts 1, modulo 10.
    pure logical function has_checksum(line, number)
        character(*), intent(in) :: line, number

        integer :: k, total

        has_checksum = len_trim(line) == 69
        if (.not. has_checksum) return
        total = 0
        do k = 1, len_trim(line) - 1
            total = total + max(0, index('0123456789', line(k:k)) - 1) + merge(1, 0, line(k:k) == '-')
        end do
        has_checksum = line(:2) == number//' ' .and. index('0123456789', line(69:69)) - 1 == modulo(total, 10)
    end function has_checksum
end module gracecg_simulation_stated_start
