!> The Sun against the JPL ephemeris DE421, and the Earth's shadow.
module test_sun
    use vocabulary
    use gracecg_base_constants, only: ASTRONOMICAL_UNIT, SOLAR_RADIUS, WGS84_SEMI_MAJOR_AXIS
    use gracecg_environment_sun, only: sun_position, conical_shadow
    implicit none
    private
    public :: collect_sun

    real(dp), parameter :: SUN(3) = [ASTRONOMICAL_UNIT, 0.0_dp, 0.0_dp]
    real(dp), parameter :: ORBIT = 6.84e6_dp    !! m

contains

    subroutine collect_sun(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('positions', test_positions), &
                    new_unittest('day-and-night', test_day_and_night), &
                    new_unittest('penumbra-monotone-and-continuous', test_penumbra), &
                    new_unittest('penumbra-area', test_area), &
                    new_unittest('annular-eclipse', test_annular)]
    end subroutine collect_sun

    !> DE421 (jplephem), 0 h UTC of 1989-01-02, where the formula is 2.7" and 634 km off, and of 2000-06-01: 5.8" and 804 km.
    subroutine test_positions(error)
        type(error_type), allocatable, intent(out) :: error

        call check_position(error, 2447528.500650278_dp, &
                            [29896916.4e3_dp, -132144058.7e3_dp, -57295472.1e3_dp], &
                            2.7_dp, 634e3_dp)
        call check_position(error, 2451696.500742870_dp, &
                            [49857773.3e3_dp, 131456818.6e3_dp, 56992745.6e3_dp], &
                            5.8_dp, 804e3_dp)
    end subroutine test_positions

    !> The error has to be the one the formula is known to have, not only below its bound.
    subroutine check_position(error, julian_date, expected, error_arcseconds, error_distance)
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in) :: julian_date, expected(3), error_arcseconds, error_distance
        real(dp) :: position(3), angle

        position = sun_position((julian_date - 2451545)/36525)
        angle = atan2(norm2(cross(position, expected)), dot_product(position, expected))
        call check(error, angle/ARCSECOND, error_arcseconds, thr=0.06_dp)
        call check(error, norm2(position) - norm2(expected), error_distance, thr=1e3_dp)
    end subroutine check_position

    subroutine test_day_and_night(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, conical_shadow([ORBIT, 0.0_dp, 0.0_dp], SUN), 1.0_dp)
        call check(error, conical_shadow([0.0_dp, 0.0_dp, ORBIT], SUN), 1.0_dp)
        call check(error, conical_shadow([-ORBIT, 0.0_dp, 0.0_dp], SUN), 0.0_dp)
    end subroutine test_day_and_night

    !> An orbit crossed in steps of 1e-5 rad, about a thousandth of the penumbra: the light fades,
    !> never by much at once, from 1 to 0; at the middle the Sun's centre is on the horizon.
    subroutine test_penumbra(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: STEP = 1e-5_dp
        real(dp) :: limb, light, previous
        integer :: i

        limb = PI - asin(WGS84_SEMI_MAJOR_AXIS/ORBIT)
        previous = 1
        do i = -600, 600
            light = shadow_at(limb + i*STEP)
            call check(error, light <= previous .and. previous - light < 1.5e-3_dp)
            if (i == -600) call check(error, light, 1.0_dp)
            if (i == 0) call check(error, light, 0.5_dp, thr=2e-2_dp)
            previous = light
        end do
        call check(error, previous, 0.0_dp)
    end subroutine test_penumbra

    pure real(dp) function shadow_at(angle)
        real(dp), intent(in) :: angle   !! From the Sun's direction, rad

        shadow_at = conical_shadow(ORBIT*[cos(angle), sin(angle), 0.0_dp], SUN)
    end function shadow_at

    !> The covered part of the disc by adding up strips.
    subroutine test_area(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: STRIPS = 20000
        real(dp) :: position(3), to_sun(3), angle, a, b, c, x, covered
        integer :: i, k

        do k = -2, 2
            angle = PI - asin(WGS84_SEMI_MAJOR_AXIS/ORBIT) + k*1.8e-3_dp
            position = ORBIT*[cos(angle), sin(angle), 0.0_dp]
            to_sun = SUN - position
            a = asin(SOLAR_RADIUS/norm2(to_sun))
            b = asin(WGS84_SEMI_MAJOR_AXIS/ORBIT)
            c = acos(-dot_product(position, to_sun)/(ORBIT*norm2(to_sun)))
            covered = 0
            do i = 1, STRIPS    ! across the line of centres; the Sun's disc lies about x = 0
                x = a*(2*(i - 0.5_dp)/STRIPS - 1)
                covered = covered + 2*a/STRIPS*2* &
                          sqrt(min(a**2 - x**2, max(0.0_dp, b**2 - (x + c)**2)))
            end do
            call check(error, conical_shadow(position, SUN), 1 - covered/(PI*a**2), thr=1e-5_dp)
        end do
    end subroutine test_area

    !> Beyond the umbra's tip the Earth leaves a ring of the Sun.
    subroutine test_annular(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: DISTANCE = 2e9_dp
        real(dp) :: expected

        expected = 1 - (asin(WGS84_SEMI_MAJOR_AXIS/DISTANCE)/ &
                        asin(SOLAR_RADIUS/(ASTRONOMICAL_UNIT + DISTANCE)))**2
        call check(error, conical_shadow([-DISTANCE, 0.0_dp, 0.0_dp], SUN), expected, thr=1e-12_dp)
    end subroutine test_annular
end module test_sun
