!> Position of the Sun, and the Earth's shadow.
module gracecg_environment_sun
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: PI, DEGREE, ARCSECOND, ASTRONOMICAL_UNIT, SOLAR_RADIUS, &
        WGS84_SEMI_MAJOR_AXIS
    use gracecg_base_vectors, only: cross
    implicit none
    private
    public :: sun_position, conical_shadow

    real(dp), parameter :: OBLIQUITY_J2000 = 23.43929111_dp*DEGREE
    !! Mean obliquity of the ecliptic at J2000 (IAU 1976), rad

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

        real(dp) :: t, mean_longitude, mean_anomaly, eccentricity, centre
        real(dp) :: longitude_term, distance_term, longitude, latitude, distance

        t = julian_centuries_tt
        mean_longitude = 280.46646_dp + t*(36000.76983_dp + t*0.0003032_dp)
        mean_anomaly = (357.52911_dp + t*(35999.05029_dp - t*0.0001537_dp))*DEGREE
        eccentricity = 0.016708634_dp - t*(0.000042037_dp + t*0.0000001267_dp)
        centre = (1.914602_dp - t*(0.004817_dp + t*0.000014_dp))*sin(mean_anomaly) + &
                 (0.019993_dp - t*0.000101_dp)*sin(2*mean_anomaly) + &
                 0.000289_dp*sin(3*mean_anomaly)
        call perturbations(t, longitude_term, distance_term)

        longitude = (mean_longitude + centre + longitude_term)*DEGREE - &
                    t*(5029.0966_dp + t*1.11113_dp)*ARCSECOND
        latitude = 47.0029_dp*ARCSECOND*t*sin(longitude - 174.876_dp*DEGREE)
        distance = 1.000001018_dp*(1 - eccentricity**2)/ &
                   (1 + eccentricity*cos(mean_anomaly + centre*DEGREE)) + distance_term
        position = distance*ASTRONOMICAL_UNIT*equatorial_direction(longitude, latitude)
    end function sun_position

    !> Perturbations of the Sun's longitude and distance by Venus (two terms), Jupiter (two terms),
    !> the Moon, and one inequality of long period; their time counts from 1900.
    pure subroutine perturbations(t, longitude, distance)
        real(dp), intent(in) :: t               !! Julian centuries TT since J2000
        real(dp), intent(out) :: longitude      !! degrees
        real(dp), intent(out) :: distance       !! au

        real(dp) :: s, venus_1, venus_2, jupiter_1, jupiter_2, moon, long_period

        s = t + 1
        venus_1 = (153.23_dp + 22518.7541_dp*s)*DEGREE
        venus_2 = (216.57_dp + 45037.5082_dp*s)*DEGREE
        jupiter_1 = (312.69_dp + 32964.3577_dp*s)*DEGREE
        jupiter_2 = (353.06_dp + 65928.7155_dp*s)*DEGREE
        moon = (350.74_dp + 445267.1142_dp*s)*DEGREE
        long_period = (231.19_dp + 20.20_dp*s)*DEGREE
        longitude = 0.00134_dp*cos(venus_1) + 0.00154_dp*cos(venus_2) + &
                    0.00200_dp*cos(jupiter_1) + 0.00179_dp*sin(moon) + &
                    0.00178_dp*sin(long_period)
        distance = 0.00000543_dp*sin(venus_1) + 0.00001575_dp*sin(venus_2) + &
                   0.00001627_dp*sin(jupiter_1) + 0.00003076_dp*cos(moon) + &
                   0.00000927_dp*sin(jupiter_2)
    end subroutine perturbations

    !> Unit vector in equatorial axes of J2000 from ecliptic longitude and latitude of J2000.
    pure function equatorial_direction(longitude, latitude) result(direction)
        real(dp), intent(in) :: longitude, latitude     !! rad
        real(dp) :: direction(3)

        real(dp) :: x, y, z

        x = cos(latitude)*cos(longitude)
        y = cos(latitude)*sin(longitude)
        z = sin(latitude)
        direction(1) = x
        direction(2) = y*cos(OBLIQUITY_J2000) - z*sin(OBLIQUITY_J2000)
        direction(3) = y*sin(OBLIQUITY_J2000) + z*cos(OBLIQUITY_J2000)
    end function equatorial_direction

    !> Eclipse factor of eq. (2-8): the part of the Sun's disc that a spherical Earth leaves free, seen from
    !> the satellite (O. Montenbruck, E. Gill, Satellite Orbits, 2000, section 3.4.2). It is 1 in
    !> full Sun and 0 in the umbra; the two discs are taken as plane circles. A position inside
    !> the Earth counts as one on its surface.
    pure real(dp) function conical_shadow(position, sun_position) result(illumination)
        real(dp), intent(in) :: position(3)         !! Satellite, from the Earth's centre, m
        real(dp), intent(in) :: sun_position(3)     !! Sun, same axes, m

        real(dp) :: to_sun(3), sun_disc, earth_disc, separation

        to_sun = sun_position - position
        sun_disc = asin(SOLAR_RADIUS/norm2(to_sun))
        earth_disc = asin(min(1.0_dp, WGS84_SEMI_MAJOR_AXIS/norm2(position)))
        separation = atan2(norm2(cross(position, to_sun)), -dot_product(position, to_sun))

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
