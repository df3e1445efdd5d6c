!> Position of the Sun, and the Earth's shadow.
module gracecg_environment_sun
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: PI, DEGREE, ARCSECOND, ASTRONOMICAL_UNIT, SOLAR_RADIUS, &
        WGS84_SEMI_MAJOR_AXIS
    use gracecg_base_lanes, only: LANES, lanes_sines_cosines
    use gracecg_base_vectors, only: cross
    implicit none
    private
    public :: sun_position, conical_shadow, is_another_light, edge_of_shadow

    real(dp), parameter :: CHANGE = 0.01_dp     !! Of the part that is seen of the Sun: some 5e-10 m/s^2
    real(dp), parameter :: OBLIQUITY_J2000 = 23.43929111_dp*DEGREE
    !! Mean obliquity of the ecliptic at J2000 (IAU 1976), rad

    !> Angles of the Sun's motion, by place: mean anomaly; perturbations by Venus (two terms), Jupiter (two terms), the
    !> Moon, and one inequality of long period; mean longitude
    integer, parameter :: ANOMALY = 1, VENUS_1 = 2, VENUS_2 = 3, JUPITER_1 = 4, JUPITER_2 = 5, MOON = 6, LONG_PERIOD = 7, &
        LONGITUDE = 8
    real(dp), parameter :: PHASE(LANES) = [0.0_dp, 153.23_dp, 216.57_dp, 312.69_dp, 353.06_dp, 350.74_dp, 231.19_dp, 0.0_dp]
    !! Of the perturbations, whose time counts from 1900, degrees
    real(dp), parameter :: RATE(LANES) = [0.0_dp, 22518.7541_dp, 45037.5082_dp, 32964.3577_dp, 65928.7155_dp, 445267.1142_dp, &
                                          20.20_dp, 0.0_dp]     !! Degrees a Julian century

contains

    !> Geometric position of the Sun (no aberration, no light time): the Earth's mean Kepler ellipse
    !> with its secular changes and the equation of the centre (J. Meeus, Astronomical Algorithms,
    !> ch. 25), the largest perturbations by Venus, Jupiter and the Moon (J. Meeus, Astronomical
    !> Formulae for Calculators, ch. 18), and general precession back to J2000.
    !>
    !> Error against JPL DE421 in 1986-2001: at most 12 arcsec (4.6 rms) and 2700 km (1000 rms).
    pure function sun_position(julian_centuries_tt) result(position)
        real(dp), intent(in) :: julian_centuries_tt
        !! Terrestrial Time since J2000 (JD 2451545.0), in Julian centuries of 36525 days
        real(dp) :: position(3)
        !! From the Earth's centre, mean equator and equinox of J2000, m

        real(dp), parameter :: NODE = 174.876_dp*DEGREE, ARCSECONDS = 1296000
        real(dp), dimension(LANES) :: turns, sine, cosine
        real(dp) :: t, eccentricity, centre, longitude_term, distance_term, latitude, distance, x, y, z
        real(dp) :: true_anomaly(2), true_longitude(2), along_latitude(2)  ! [cosine, sine]

        t = julian_centuries_tt
        turns = PHASE/360 + RATE/360*(t + 1)
        turns(ANOMALY) = (357.52911_dp + t*(35999.05029_dp - t*0.0001537_dp))/360
        turns(LONGITUDE) = (280.46646_dp + t*(36000.76983_dp + t*0.0003032_dp))/360 - &
                           t*(5029.0966_dp + t*1.11113_dp)/ARCSECONDS     ! from the equinox of J2000
        call lanes_sines_cosines(turns, sine, cosine)
        eccentricity = 0.016708634_dp - t*(0.000042037_dp + t*0.0000001267_dp)
        centre = (1.914602_dp - t*(0.004817_dp + t*0.000014_dp))*sine(ANOMALY) + &
                 (0.019993_dp - t*0.000101_dp)*(2*sine(ANOMALY)*cosine(ANOMALY)) + &
                 0.000289_dp*(sine(ANOMALY)*(3 - 4*sine(ANOMALY)**2))
        longitude_term = 0.00134_dp*cosine(VENUS_1) + 0.00154_dp*cosine(VENUS_2) + 0.00200_dp*cosine(JUPITER_1) + &
                         0.00179_dp*sine(MOON) + 0.00178_dp*sine(LONG_PERIOD)
        distance_term = 0.00000543_dp*sine(VENUS_1) + 0.00001575_dp*sine(VENUS_2) + 0.00001627_dp*sine(JUPITER_1) + &
                        0.00003076_dp*cosine(MOON) + 0.00000927_dp*sine(JUPITER_2)

        true_anomaly = turned([cosine(ANOMALY), sine(ANOMALY)], centre*DEGREE)
        true_longitude = turned([cosine(LONGITUDE), sine(LONGITUDE)], (centre + longitude_term)*DEGREE)
        latitude = 47.0029_dp*ARCSECOND*t*(true_longitude(2)*cos(NODE) - true_longitude(1)*sin(NODE))
        distance = ASTRONOMICAL_UNIT*(1.000001018_dp*(1 - eccentricity**2)/(1 + eccentricity*true_anomaly(1)) + distance_term)
        along_latitude = turned([1.0_dp, 0.0_dp], latitude)
        x = along_latitude(1)*true_longitude(1)
        y = along_latitude(1)*true_longitude(2)
        z = along_latitude(2)
        position = distance*[x, y*cos(OBLIQUITY_J2000) - z*sin(OBLIQUITY_J2000), &
                             y*sin(OBLIQUITY_J2000) + z*cos(OBLIQUITY_J2000)]
    end function sun_position

    !> A direction turned by a small angle: sine and cosine to the eighth power, with an error of 1e-18 of 0.04 rad, which the
    !> equation of the centre does not reach. (The latitude grows by 2.3e-4 a century.)
    pure function turned(direction, angle) result(u)
        real(dp), intent(in) :: direction(2)    ! [cosine, sine]
        real(dp), intent(in) :: angle           ! rad
        real(dp) :: u(2)

        real(dp), parameter :: S3 = -1/6.0_dp, S5 = 1/120.0_dp, S7 = -1/5040.0_dp
        real(dp), parameter :: C2 = -1/2.0_dp, C4 = 1/24.0_dp, C6 = -1/720.0_dp, C8 = 1/40320.0_dp
        real(dp) :: c, s, z

        z = angle**2
        s = angle*(1 + z*(S3 + z*(S5 + z*S7)))
        c = 1 + z*(C2 + z*(C4 + z*(C6 + z*C8)))
        u = [direction(1)*c - direction(2)*s, direction(2)*c + direction(1)*s]
    end function turned

    !> Eclipse factor of eq. (2-8): the part of the Sun's disc that a spherical Earth leaves free, seen from
    !> the satellite (O. Montenbruck, E. Gill, Satellite Orbits, 2000, section 3.4.2). It is 1 in
    !> full Sun and 0 in the umbra; the two discs are taken as plane circles. A position inside
    !> the Earth counts as one on its surface.
    pure real(dp) function conical_shadow(position, sun_position) result(illumination)
        real(dp), intent(in) :: position(3)         !! Satellite, from the Earth's centre, m
        real(dp), intent(in) :: sun_position(3)     !! Sun, same axes, m

        real(dp) :: to_sun(3), sun_distance_squared, radius_squared, along, sun_disc, earth_disc, separation

        to_sun = sun_position - position
        sun_distance_squared = dot_product(to_sun, to_sun)
        radius_squared = dot_product(position, position)
        along = dot_product(position, to_sun)
        ! The Sun above the horizon, as most of the time: no angles are needed. With the sines of the discs' angles R/d and A/r,
        ! -along < r d cos(sun_disc + earth_disc) = sqrt((d^2 - R^2) (r^2 - A^2)) - R A
        if (radius_squared > WGS84_SEMI_MAJOR_AXIS**2) then
            associate (beyond => SOLAR_RADIUS*WGS84_SEMI_MAJOR_AXIS - along)
                if (beyond < 0 .or. beyond**2 < (sun_distance_squared - SOLAR_RADIUS**2)* &
                    (radius_squared - WGS84_SEMI_MAJOR_AXIS**2)) then
                    illumination = 1
                    return
                end if
            end associate
        end if
        sun_disc = SOLAR_RADIUS/sqrt(sun_distance_squared)
        earth_disc = min(1.0_dp, WGS84_SEMI_MAJOR_AXIS/sqrt(radius_squared))
        sun_disc = asin(sun_disc)
        earth_disc = asin(earth_disc)
        separation = atan2(norm2(cross(position, to_sun)), -along)

        if (separation >= sun_disc + earth_disc) then
            illumination = 1
        else if (separation <= earth_disc - sun_disc) then
            illumination = 0
        else if (separation <= sun_disc - earth_disc) then
            illumination = 1 - (earth_disc/sun_disc)**2
        else
            illumination = 1 - common_area(sun_disc, earth_disc, separation)/(PI*sun_disc**2)
        end if
    end function conical_shadow

    !> Whether the light is so different that it shows: another part of the Sun is seen, or all of it no more or again.
    elemental logical function is_another_light(light, before)
        real(dp), intent(in) :: light, before       !! Of conical_shadow

        is_another_light = abs(light - before) > CHANGE .or. (light >= 1 .neqv. before >= 1)
    end function is_another_light

    !> When in an arc the satellite enters or leaves the full light of the Sun, or where it does neither in the penumbra, sees
    !> another part of the Sun than before, s; negative where its light stays, or its orbit is not known.
    pure real(dp) function edge_of_shadow(centuries, time, position, duration) result(edge)
        real(dp), intent(in) :: centuries       !! Of the arc, Julian, TT from J2000
        real(dp), intent(in) :: time(:)         !! Of the positions, rising, s from the begin of the arc
        real(dp), intent(in) :: position(:, :)  !! Inertial frame, (3, size(time)), m
        real(dp), intent(in) :: duration        !! Of the arc, s

        real(dp) :: sun(3), light, before, first
        integer :: i

        edge = -1
        sun = sun_position(centuries)
        before = -1
        do i = 1, size(time)
            if (time(i) < 0 .or. time(i) > duration) cycle
            light = conical_shadow(position(:, i), sun)
            if (before < 0) first = light
            if (edge < 0 .and. abs(light - first) > CHANGE) edge = time(i)
            if (before >= 0 .and. (light >= 1 .neqv. before >= 1)) edge = time(i)
            before = light
        end do
    end function edge_of_shadow

    !> Area common to two circles that cut each other, Montenbruck and Gill eqs. (3.92)-(3.93), with
    !> the arc cosines as arc tangents: an arc cosine of a number near 1 loses half its digits.
    pure real(dp) function common_area(a, b, separation) result(area)
        real(dp), intent(in) :: a, b            !! Radii
        real(dp), intent(in) :: separation      !! Distance of the centres, between abs(a-b) and a+b

        real(dp) :: x, y

        x = (separation**2 + (a - b)*(a + b))/(2*separation)
        y = sqrt(max(0.0_dp, (a - x)*(a + x)))
        area = a**2*atan2(y, x) + b**2*atan2(y, separation - x) - separation*y
    end function common_area
end module gracecg_environment_sun
