!> Air and light on the satellite: limits with known answers.
module test_surface_loads
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_is_nan
    use vocabulary
    use gracecg_base_constants, only: SPEED_OF_LIGHT, ASTRONOMICAL_UNIT
    use gracecg_environment_earth_radiation, only: earth_irradiance_t
    use gracecg_spacecraft_plates, only: satellite_surface_t, plate_t, surface_of, new_trapezoid, MAX_PLATES
    use gracecg_base_quaternion, only: rotation_matrix, normalised
    use gracecg_spacecraft_surface_loads
    implicit none
    private
    public :: collect_surface_loads

    real(dp), parameter :: MASS = 420.0_dp                          !! kg
    real(dp), parameter :: R_GAS = 8.31446261815324_dp              !! J/(mol K)
    real(dp), parameter :: IRRADIANCE = 1367.2335_dp                !! W/m^2
    real(dp), parameter :: NO_OFFSET(3) = 0.0_dp
    real(dp), parameter :: X(3) = [1.0_dp, 0.0_dp, 0.0_dp]
    type(gas_t), parameter :: GAS = gas_t(4e-12_dp, 1200.0_dp, 16e-3_dp)
    real(dp), parameter :: SUN(3) = ASTRONOMICAL_UNIT*[0.48_dp, -0.6_dp, 0.64_dp]      !! Direction to it, m

contains

    subroutine collect_surface_loads(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('conventional-drag', test_drag), &
                    new_unittest('conventional-sunlight', test_sunlight), &
                    new_unittest('conventional-earthlight', test_earthlight), &
                    new_unittest('black-plates-are-conventional', test_black), &
                    new_unittest('mirror', test_mirror), &
                    new_unittest('spheres-in-light', test_light_spheres), &
                    new_unittest('sphere-in-air', test_air_sphere), &
                    new_unittest('gas-at-rest', test_rest), &
                    new_unittest('plate-at-any-speed', test_speeds), &
                    new_unittest('any-number-of-plates', test_counts), &
                    new_unittest('forces-and-loads-together', test_together), &
                    new_unittest('mean-molar-mass', test_molar_mass), &
                    new_unittest('refuses-impossible-wall', test_wall)]
    end subroutine collect_surface_loads

    !> The satellite of CSR-TM-00-01 section 5.2.
    function grace(specular, diffuse) result(surface)
        real(dp), intent(in) :: specular, diffuse
        type(satellite_surface_t) :: surface

        type(error_t), allocatable :: failure

        call new_trapezoid(3.122_dp, 0.720_dp, 1.942_dp, 0.693_dp, specular, diffuse, surface, failure)
    end function grace

    !> Points spread evenly over the unit sphere.
    pure function sphere_point(i, n) result(point)
        integer, intent(in) :: i, n
        real(dp) :: point(3)

        real(dp) :: z

        z = 2*(i - 0.5_dp)/n - 1
        point = [sqrt(1 - z**2)*cos(PI*(3 - sqrt(5.0_dp))*i), &
                 sqrt(1 - z**2)*sin(PI*(3 - sqrt(5.0_dp))*i), z]
    end function sphere_point

    !> Force of the air on an element of 1 m^2, N.
    pure function traction(gas, wall, velocity, normal) result(force)
        type(gas_t), intent(in) :: gas
        type(wall_t), intent(in) :: wall
        real(dp), intent(in) :: velocity(3), normal(3)
        real(dp) :: force(3)

        type(surface_load_t) :: load

        load = aerodynamic_load(surface_of([plate_t(normal=normal, area=1)]), NO_OFFSET, gas, wall, velocity)
        force = load%force
    end function traction

    !> CSR-TM-00-01 eqs. (2-6), (2-7) along x, where A_d = (1.942 + 0.693)/2 0.720 m^2.
    subroutine test_drag(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SPEED = 7600.0_dp, AREA = 0.9486_dp
        real(dp) :: a(3), oblique(3)

        a = drag_acceleration(grace(0.0_dp, 0.0_dp), MASS, 2.0_dp, GAS%density, SPEED*X)
        call check(error, maxval(abs(a + 0.5_dp*2*AREA/MASS*GAS%density*SPEED**2*X)) < 1e-20_dp)
        oblique = SPEED*unit([1.0_dp, 0.05_dp, -0.02_dp])
        a = drag_acceleration(grace(0.0_dp, 0.0_dp), MASS, 2.0_dp, GAS%density, oblique)
        call check(error, norm2(cross(a, oblique)) < 1e-15_dp*norm2(a)*SPEED .and. &
                   dot_product(a, oblique) < 0)
    end subroutine test_drag

    !> CSR-TM-00-01 eqs. (2-8), (2-9): at 1 au on the bottom; twice as far a quarter; in shadow nothing.
    subroutine test_sunlight(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: ETA = 0.45_dp, PRESSURE = 4.5606e-6_dp, AREA = 1.942_dp*3.122_dp
        real(dp), parameter :: BELOW(3) = [0.0_dp, 0.0_dp, ASTRONOMICAL_UNIT]
        type(satellite_surface_t) :: surface
        real(dp) :: a(3), expected(3)

        surface = grace(0.0_dp, 0.0_dp)
        a = solar_radiation_acceleration(surface, MASS, ETA, IRRADIANCE, 1.0_dp, BELOW)
        expected = [0.0_dp, 0.0_dp, -PRESSURE*(1 + ETA)*AREA/MASS]
        call check(error, maxval(abs(a - expected)) < 1e-7_dp*norm2(expected))
        expected = solar_radiation_acceleration(surface, MASS, ETA, IRRADIANCE, 0.5_dp, 2*BELOW)
        call check(error, maxval(abs(8*expected - a)) < 1e-14_dp*norm2(a))
        a = solar_radiation_acceleration(surface, MASS, ETA, IRRADIANCE, 0.0_dp, BELOW)
        call check(error, norm2(a), 0.0_dp)
    end subroutine test_sunlight

    !> CSR-TM-00-01 eqs. (2-10), (2-15) with two segments, on bottom and front, seen from a turned body.
    subroutine test_earthlight(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: ETA = 0.5_dp
        type(earth_irradiance_t) :: radiation
        real(dp) :: m(3, 3), a(3), expected(3)

        m = rotation_matrix(normalised([0.1_dp, 0.7_dp, -0.4_dp, 0.3_dp]))
        radiation%count = 2
        radiation%direction(:, 1) = -m(3, :)    ! upwards, from below the bottom
        radiation%direction(:, 2) = -m(1, :)    ! from before the front
        radiation%irradiance(1:2) = [300.0_dp, 40.0_dp]
        a = earth_radiation_acceleration(grace(0.0_dp, 0.0_dp), MASS, ETA, m, &
                                         [0.0_dp, 0.0_dp, -1.0_dp], radiation)
        expected = -(1 + ETA)/(MASS*SPEED_OF_LIGHT)* &
                   1.942_dp*3.122_dp*[40.0_dp, 0.0_dp, 300.0_dp]
        call check(error, maxval(abs(a - expected)) < 1e-13_dp*norm2(expected))
    end subroutine test_earthlight

    !> Plates that absorb everything are the conventional model with eta = 0.
    subroutine test_black(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_surface_t) :: black
        type(earth_irradiance_t) :: radiation
        type(surface_load_t) :: load
        real(dp) :: m(3, 3), force(3)
        integer :: j

        black = grace(0.0_dp, 0.0_dp)
        load = solar_radiation_load(black, NO_OFFSET, IRRADIANCE, 0.8_dp, SUN)
        force = MASS*solar_radiation_acceleration(black, MASS, 0.0_dp, IRRADIANCE, 0.8_dp, SUN)
        call check(error, maxval(abs(load%force - force)) < 1e-14_dp*norm2(force))
        m = rotation_matrix(normalised([0.1_dp, 0.7_dp, -0.4_dp, 0.3_dp]))
        radiation%count = 1     ! the cross-section towards the only segment is the one of (2-15)
        radiation%irradiance(1) = 200
        do j = 1, 7
            radiation%direction(:, 1) = sphere_point(j, 7)
            load = earth_radiation_load(black, NO_OFFSET, m, radiation)
            force = MASS*earth_radiation_acceleration(black, MASS, 0.0_dp, m, &
                                                      matmul(m, radiation%direction(:, 1)), radiation)
            call check(error, maxval(abs(load%force - force)) < 1e-14_dp*norm2(force))
        end do
    end subroutine test_black

    !> One mirror: 2 P A cos^2(theta) against its normal, and the arm times that (2-24).
    subroutine test_mirror(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: NORMAL(3) = [0.6_dp, 0.0_dp, 0.8_dp], AREA = 2.5_dp
        real(dp), parameter :: CENTRE(3) = [1.0_dp, 0.3_dp, -0.2_dp]
        real(dp), parameter :: CENTRE_OF_MASS(3) = [0.1_dp, 0.1_dp, 0.0_dp]
        type(satellite_surface_t) :: mirror
        type(surface_load_t) :: load
        real(dp) :: expected(3)

        mirror = surface_of([plate_t(NORMAL, AREA, CENTRE, specular=1.0_dp)])
        load = solar_radiation_load(mirror, CENTRE_OF_MASS, IRRADIANCE, 1.0_dp, ASTRONOMICAL_UNIT*X)
        expected = -2*IRRADIANCE/SPEED_OF_LIGHT*AREA*0.36_dp*NORMAL
        call check(error, maxval(abs(load%force - expected)) < 1e-14_dp*norm2(expected))
        expected = cross(CENTRE - CENTRE_OF_MASS, expected)
        call check(error, maxval(abs(load%torque - expected)) < 1e-14_dp*norm2(expected))
        load = solar_radiation_load(mirror, CENTRE_OF_MASS, IRRADIANCE, 1.0_dp, &
                                    -ASTRONOMICAL_UNIT*X)
        call check(error, norm2(load%force) + norm2(load%torque), 0.0_dp)
    end subroutine test_mirror

    !> Radiation pressure coefficients of spheres: 1 when black, 1 as a mirror, 1 + 4/9 as a
    !> Lambert scatterer.
    subroutine test_light_spheres(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, sphere_coefficient(0.0_dp, 0.0_dp), 1.0_dp, thr=1e-3_dp)
        call check(error, sphere_coefficient(1.0_dp, 0.0_dp), 1.0_dp, thr=1e-3_dp)
        call check(error, sphere_coefficient(0.0_dp, 1.0_dp), 13.0_dp/9, thr=1e-3_dp)
    end subroutine test_light_spheres

    real(dp) function sphere_coefficient(specular, diffuse) result(coefficient)
        real(dp), intent(in) :: specular, diffuse
        integer, parameter :: ELEMENTS = 5000
        type(satellite_surface_t) :: element
        type(surface_load_t) :: load
        real(dp) :: force(3)
        integer :: i

        force = 0
        do i = 1, ELEMENTS
            element = surface_of([plate_t(sphere_point(i, ELEMENTS), 4*PI/ELEMENTS, specular=specular, diffuse=diffuse)])
            load = solar_radiation_load(element, NO_OFFSET, IRRADIANCE, 1.0_dp, ASTRONOMICAL_UNIT*X)
            force = force + load%force
        end do
        coefficient = -force(1)*SPEED_OF_LIGHT/(IRRADIANCE*PI)
    end function sphere_coefficient

    !> Spheres of many elements against the closed form (e.g. S. A. Schaaf, P. L. Chambre, Flow of
    !> Rarefied Gases, 1961), for several speed ratios and accommodations.
    subroutine test_air_sphere(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: RATIO(4) = [0.3_dp, 1.0_dp, 3.0_dp, 7.0_dp]
        integer, parameter :: ELEMENTS = 20000
        type(wall_t) :: wall
        real(dp) :: c, c_leaving, s, force(3), expected
        integer :: i, k

        c = sqrt(2*R_GAS*GAS%temperature/GAS%molar_mass)
        do k = 1, size(RATIO)
            s = RATIO(k)
            wall = wall_t(300.0_dp, 1 - 0.1_dp*(k - 1))
            force = 0
            do i = 1, ELEMENTS
                force = force + 4*PI/ELEMENTS* &
                        traction(GAS, wall, s*c*X, sphere_point(i, ELEMENTS))
            end do
            c_leaving = sqrt((1 - wall%accommodation)*(s*c)**2/2 + &
                             wall%accommodation*2*R_GAS*wall%temperature/GAS%molar_mass)
            expected = (4*s**4 + 4*s**2 - 1)/(2*s**4)*erf(s) + &
                       (2*s**2 + 1)/(sqrt(PI)*s**3)*exp(-s**2) + 2*sqrt(PI)/3*c_leaving/(s*c)
            call check(error, -force(1)/(0.5_dp*GAS%density*(s*c)**2*PI)/expected, 1.0_dp, &
                       thr=2e-5_dp)
        end do
    end subroutine test_air_sphere

    !> A gas at rest presses with n k T = rho R T/M on a wall as warm as itself, and moves no
    !> closed body.
    subroutine test_rest(error)
        type(error_type), allocatable, intent(out) :: error
        type(wall_t) :: wall
        type(surface_load_t) :: load
        real(dp) :: f(3), pressure

        wall = wall_t(GAS%temperature, 1.0_dp)
        pressure = GAS%density*R_GAS*GAS%temperature/GAS%molar_mass
        f = traction(GAS, wall, 0*X, X)
        call check(error, maxval(abs(f + pressure*X)) < 1e-14_dp*pressure)
        load = aerodynamic_load(grace(0.0_dp, 0.0_dp), [0.3_dp, 0.1_dp, -0.2_dp], GAS, wall, 0*X)
        call check(error, norm2(load%force) < 1e-14_dp*pressure)
        call check(error, norm2(load%torque) < 1e-14_dp*pressure)
    end subroutine test_rest

    !> The formula of `aerodynamic_load` with the compiler's exp and erfc, from the lee to the windward side; NaN stays.
    subroutine test_speeds(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: c, w, flux, pressure, f(3)
        integer :: i

        c = sqrt(2*R_GAS*GAS%temperature/GAS%molar_mass)
        do i = -300, 300
            w = 0.1_dp*i
            f = traction(GAS, wall_t(300.0_dp, 1.0_dp), w*c*X, X)
            flux = GAS%density*c/2*(exp(-w**2)/sqrt(PI) + w*erfc(-w))
            pressure = GAS%density*c**2*erfc(-w)/4 + sqrt(PI)/2*sqrt(2*R_GAS*300/GAS%molar_mass)*flux
            call check(error, f(1), -flux*w*c - pressure, thr=4e-15_dp*GAS%density*c**2*max(1.0_dp, w**2))
        end do
        f = traction(GAS, wall_t(), ieee_value(c, ieee_quiet_nan)*X, X)
        call check(error, all(ieee_is_nan(f)))
    end subroutine test_speeds

    !> Surfaces of 1 to MAX_PLATES plates: the sums are those of the plates one by one.
    subroutine test_counts(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: COM(3) = [0.1_dp, -0.2_dp, 0.3_dp]
        type(plate_t) :: plates(MAX_PLATES)
        real(dp) :: sums(7, 2), found(7, 2)
        integer :: i, n

        do i = 1, MAX_PLATES
            plates(i) = plate_t(sphere_point(i, MAX_PLATES), 0.1_dp*i, 2*sphere_point(MAX_PLATES + 1 - i, MAX_PLATES), &
                                0.01_dp*i, 0.5_dp - 0.01_dp*i)
        end do
        sums = 0
        do n = 1, MAX_PLATES
            sums = sums + sums_over(surface_of(plates(n:n)))
            found = sums_over(surface_of(plates(:n)))
            do i = 1, 2
                call check(error, maxval(abs(found(:3, i) - sums(:3, i))) <= 1e-13_dp*norm2(sums(:3, i)) .and. &
                           maxval(abs(found(4:6, i) - sums(4:6, i))) <= 1e-13_dp*(norm2(sums(:6, i))) .and. &
                           abs(found(7, i) - sums(7, i)) <= 1e-13_dp*sums(7, i))
            end do
        end do

    contains

        !> In air and in light
        function sums_over(surface) result(both)
            type(satellite_surface_t), intent(in) :: surface
            real(dp) :: both(7, 2)

            type(surface_load_t) :: part

            part = aerodynamic_load(surface, COM, GAS, wall_t(), [900.0_dp, -700.0_dp, 300.0_dp])
            both(:, 1) = [part%force, part%torque, part%projected_area]
            part = solar_radiation_load(surface, COM, IRRADIANCE, 1.0_dp, SUN)
            both(:, 2) = [part%force, part%torque, part%projected_area]
        end function sums_over
    end subroutine test_counts

    !> Accelerations by the area that came with a load are those of the surface.
    subroutine test_together(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: COM(3) = [0.1_dp, -0.2_dp, 0.3_dp], VELOCITY(3) = [7600.0_dp, 200.0_dp, -30.0_dp]
        type(satellite_surface_t) :: surface
        type(surface_load_t) :: load
        real(dp) :: a(3), expected(3)

        surface = grace(0.2_dp, 0.3_dp)
        load = aerodynamic_load(surface, COM, GAS, wall_t(), VELOCITY)
        a = drag_acceleration(surface, MASS, 2.3_dp, GAS%density, VELOCITY, load%projected_area)
        expected = drag_acceleration(surface, MASS, 2.3_dp, GAS%density, VELOCITY)
        call check(error, maxval(abs(a - expected)) <= 1e-15_dp*norm2(expected))
        load = solar_radiation_load(surface, COM, IRRADIANCE, 0.7_dp, SUN)
        a = solar_radiation_acceleration(surface, MASS, 0.4_dp, IRRADIANCE, 0.7_dp, SUN, load%projected_area)
        expected = solar_radiation_acceleration(surface, MASS, 0.4_dp, IRRADIANCE, 0.7_dp, SUN)
        call check(error, maxval(abs(a - expected)) <= 1e-15_dp*norm2(expected))
    end subroutine test_together

    subroutine test_molar_mass(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, mean_molar_mass([0.0_dp, 5.0_dp, 0.0_dp]), 15.999e-3_dp, thr=1e-15_dp)
        call check(error, mean_molar_mass([1e12_dp, 3e12_dp, 2e12_dp]), &
                   (4.002602e-3_dp + 3*15.999e-3_dp + 2*28.014e-3_dp)/6, thr=1e-15_dp)
    end subroutine test_molar_mass

    subroutine test_wall(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure

        call validate_wall(wall_t(), failure)
        if (failed(error, failure)) return
        call validate_wall(wall_t(-1.0_dp, 0.9_dp), failure)
        if (unmet(error, allocated(failure))) return
        call validate_wall(wall_t(300.0_dp, 1.1_dp), failure)
        if (unmet(error, allocated(failure))) return
        call validate_wall(wall_t(300.0_dp, NAN), failure)
        call check(error, allocated(failure))
    end subroutine test_wall
end module test_surface_loads
