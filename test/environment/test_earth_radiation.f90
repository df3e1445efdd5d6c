!> Knocke's Earth radiation model: geometry, constants, limits.
module test_earth_radiation
    use vocabulary
    use gracecg_base_constants, only: ASTRONOMICAL_UNIT, EARTH_RADIUS_EGM96
    use gracecg_environment_earth_radiation
    use gracecg_base_vectors, only: rotation_z
    implicit none
    private
    public :: collect_earth_radiation

    real(dp), parameter :: E_S = 1000.0_dp  !! Solar irradiance of most tests, W/m^2
    real(dp), parameter :: LOW = EARTH_RADIUS_EGM96 + 466e3_dp
    !! Distance from the Earth's centre of a satellite like GRACE, m
    real(dp), parameter :: X(3) = [1.0_dp, 0.0_dp, 0.0_dp], Z(3) = [0.0_dp, 0.0_dp, 1.0_dp]

contains

    subroutine collect_earth_radiation(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('projected-area', test_projected_area), &
                    new_unittest('ring-centres', test_ring_centres), &
                    new_unittest('solid-angles', test_solid_angles), &
                    new_unittest('centres-that-halve-the-area', test_half_area), &
                    new_unittest('albedo-and-emissivity', test_zonal_values), &
                    new_unittest('seasons', test_seasons), &
                    new_unittest('flux-is-the-sum', test_flux), &
                    new_unittest('convergence-with-rings', test_convergence), &
                    new_unittest('rotation-about-axis', test_rotation), &
                    new_unittest('night-side', test_night), &
                    new_unittest('over-the-poles', test_poles), &
                    new_unittest('distance-of-sun', test_distance), &
                    new_unittest('refuses-bad-settings', test_failures)]
    end subroutine collect_earth_radiation

    function model_with(rings, constants) result(model)
        integer, intent(in) :: rings(:)
        character(*), intent(in) :: constants
        type(earth_radiation_t) :: model

        type(error_t), allocatable :: failure

        call new_earth_radiation(constants, rings, E_S, model, failure)
    end function model_with

    !> A model whose irradiance is A' E_s for every segment: no reflection, an emissivity of 4.
    function uniform_emitter(rings) result(model)
        integer, intent(in) :: rings(:)
        type(earth_radiation_t) :: model

        model = model_with(rings, 'report')
        model%albedo = 0
        model%emissivity = [4.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp]
    end function uniform_emitter

    !> A' of (2-10) by numerical integration over the cap and over a segment of each ring.
    subroutine test_projected_area(error)
        type(error_type), allocatable, intent(out) :: error

        call check_area(error, LOW, [6], 0.182090533_dp)
        call check_area(error, LOW, [6, 12], 0.067085986_dp)
        call check_area(error, 12270e3_dp, [6, 12], 0.015339100_dp)
    end subroutine test_projected_area

    subroutine check_area(error, radius, rings, expected)
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in) :: radius, expected
        integer, intent(in) :: rings(:)
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: radiation

        model = uniform_emitter(rings)
        call model%irradiance_at(radius*X, ASTRONOMICAL_UNIT*X, 0.0_dp, radiation)
        call check(error, radiation%count, 1 + sum(rings))
        call check(error, maxval(abs(radiation%irradiance(:radiation%count)/E_S - &
                                     expected)) < 1e-9_dp)
    end subroutine check_area

    !> Centres half-way between the boundaries found by numerical integration: the nadir angle at
    !> which the satellite sees them.
    subroutine test_ring_centres(error)
        type(error_type), allocatable, intent(out) :: error

        call check_centres(error, LOW, [6], [1.935348_dp, 21.265067_dp])
        call check_centres(error, LOW, [6, 12], [1.115392_dp, 3.620605_dp, 21.265067_dp])
        call check_centres(error, 12270e3_dp, [6, 12], [6.656188_dp, 19.592263_dp, 58.680123_dp])
    end subroutine test_ring_centres

    subroutine check_centres(error, radius, rings, edges)
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in) :: radius
        integer, intent(in) :: rings(:)
        real(dp), intent(in) :: edges(:)    !! beta of the cap's and the rings' edges, degrees
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: radiation
        real(dp) :: beta, nadir_angle
        integer :: ring, segment

        model = uniform_emitter(rings)
        call model%irradiance_at(radius*Z, ASTRONOMICAL_UNIT*X, 0.0_dp, radiation)
        call check(error, norm2(radiation%direction(:, 1) - Z) < 1e-14_dp)
        segment = 1
        do ring = 1, size(rings)
            beta = (edges(ring) + edges(ring + 1))/2*DEGREE
            nadir_angle = atan2(EARTH_RADIUS_EGM96*sin(beta), &
                                radius - EARTH_RADIUS_EGM96*cos(beta))
            segment = segment + rings(ring)
            call check(error, acos(radiation%direction(3, segment))/DEGREE, nadir_angle/DEGREE, &
                       thr=1e-5_dp)
        end do
    end subroutine check_centres

    !> The force of a uniform Earth on a sphere is the integral of cos(zeta) over its disc, pi sin(zeta_m)^2: 19 segments
    !> whose centres halve the solid angle of their rings are off by the cap's share alone, those of mid-angle by 5 %.
    subroutine test_half_area(error)
        type(error_type), allocatable, intent(out) :: error
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: radiation
        type(error_t), allocatable :: failure
        real(dp) :: force(2), depth
        integer :: i

        do i = 1, size(SEGMENT_CENTRES)
            call new_earth_radiation('report', standard_rings(2), E_S, model, failure, trim(SEGMENT_CENTRES(i)))
            model%albedo = 0
            model%emissivity = [4.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp]
            call model%irradiance_at(LOW*X, ASTRONOMICAL_UNIT*X, 0.0_dp, radiation)
            force(i) = dot_product(radiation%irradiance(:radiation%count), radiation%direction(1, :radiation%count))
        end do
        force = force/(E_S*(EARTH_RADIUS_EGM96/LOW)**2)
        depth = 1 - sqrt(1 - (EARTH_RADIUS_EGM96/LOW)**2)
        ! the cap, a 19th of the solid angle, counts with cos 0 in place of its mean, 1 - depth/38
        call check(error, force(2), 1 + 2*depth/19*depth/38/(EARTH_RADIUS_EGM96/LOW)**2, thr=1e-12_dp)
        call check(error, abs(force(1) - 1) > 0.04_dp .and. abs(force(2) - 1) < 0.003_dp)
        call new_earth_radiation('report', standard_rings(2), E_S, model, failure, 'nowhere')
        call check_fails(error, failure, 'nowhere ... mid-angle')
    end subroutine test_half_area

    !> The flux is the sum over the segments, of any rings and either kind of centres, over day and night.
    subroutine test_flux(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SUN(3) = ASTRONOMICAL_UNIT*[0.6_dp, -0.48_dp, 0.64_dp]
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: radiation
        type(error_t), allocatable :: failure
        real(dp) :: flux(3), expected(3), place(3)
        integer :: rings, i, j

        do rings = 0, 7
            do i = 1, size(SEGMENT_CENTRES)
                call new_earth_radiation('report', standard_rings(rings), E_S, model, failure, trim(SEGMENT_CENTRES(i)))
                do j = 0, 6
                    place = LOW*[cos(0.9_dp*j)*sin(0.5_dp*j), sin(0.9_dp*j)*sin(0.5_dp*j), cos(0.5_dp*j)]
                    call model%irradiance_at(place, SUN, 100.0_dp, radiation)
                    expected = matmul(radiation%direction(:, :radiation%count), radiation%irradiance(:radiation%count))
                    call model%flux_at(place, SUN, 100.0_dp, flux)
                    call check(error, maxval(abs(flux - expected)) <= 1e-14_dp*norm2(expected))
                end do
            end do
        end do
    end subroutine test_flux

    !> All segments together fill the Earth's disc: 2 pi (1 - cos zeta_m).
    subroutine test_solid_angles(error)
        type(error_type), allocatable, intent(out) :: error
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: radiation
        integer :: rings

        do rings = 0, 7
            model = uniform_emitter(standard_rings(rings))
            call model%irradiance_at(LOW*X, ASTRONOMICAL_UNIT*X, 0.0_dp, radiation)
            call check(error, sum(radiation%irradiance(:radiation%count))/E_S, &
                       2*(1 - cos(asin(EARTH_RADIUS_EGM96/LOW))), thr=1e-12_dp)
        end do
        call check(error, radiation%count, MAX_SEGMENTS)
    end subroutine test_solid_angles

    !> The values of (2-11)-(2-14) at the equator and the poles in December (t = t0).
    subroutine test_zonal_values(error)
        type(error_type), allocatable, intent(out) :: error

        call check_zonal(error, 'knocke', X, 0.195_dp, 0.77_dp)
        call check_zonal(error, 'knocke', Z, 0.73_dp, 0.43_dp)
        call check_zonal(error, 'knocke', -Z, 0.53_dp, 0.57_dp)
        call check_zonal(error, 'report', X, 0.195_dp, 0.77_dp)
        call check_zonal(error, 'report', Z, 0.73_dp, 0.33_dp)
        call check_zonal(error, 'report', -Z, 0.53_dp, 0.67_dp)
    end subroutine test_zonal_values

    !> One segment, at the subsatellite point; a Sun in the zenith, and one in the nadir.
    subroutine check_zonal(error, constants, place, albedo, emissivity)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: constants
        real(dp), intent(in) :: place(3), albedo, emissivity
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: day, night
        real(dp) :: full

        model = model_with([integer ::], constants)
        full = 2*(1 - cos(asin(EARTH_RADIUS_EGM96/LOW)))*E_S
        call model%irradiance_at(LOW*place, ASTRONOMICAL_UNIT*place, 0.0_dp, day)
        call model%irradiance_at(LOW*place, -ASTRONOMICAL_UNIT*place, 0.0_dp, night)
        call check(error, 4*night%irradiance(1)/full, emissivity, thr=1e-12_dp)
        call check(error, (day%irradiance(1) - night%irradiance(1))/full, albedo, thr=1e-12_dp)
    end subroutine check_zonal

    !> Half a year after t0 north and south have changed places in (2-13), (2-14).
    subroutine test_seasons(error)
        type(error_type), allocatable, intent(out) :: error
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: december, june
        real(dp) :: position(3)
        integer :: i

        model = model_with([integer ::], 'report')
        do i = -4, 4
            position = LOW*[cos(20*i*DEGREE), 0.0_dp, sin(20*i*DEGREE)]
            call model%irradiance_at(position, ASTRONOMICAL_UNIT*X, 0.0_dp, december)
            position(3) = -position(3)
            call model%irradiance_at(position, ASTRONOMICAL_UNIT*X, 365.25_dp/2, june)
            call check(error, june%irradiance(1), december%irradiance(1), thr=1e-10_dp)
        end do
    end subroutine test_seasons

    !> Uniform albedo, Sun, satellite and Earth in line: the sum along the vertical tends to the
    !> integral of cos(beta) cos(zeta) 2 sin(zeta) d(zeta) over the disc. Knocke's rings come
    !> from below, slowly: the outermost one is wide. Narrow rings come near, nearly quadratically.
    subroutine test_convergence(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: NARROW(4) = [2, 4, 8, 15]
        real(dp) :: exact, difference, previous
        integer :: i

        exact = integral_over_disc(LOW)
        previous = exact
        do i = 1, 4
            difference = exact - vertical_sum(standard_rings(i))
            call check(error, difference > 0 .and. difference < 0.7_dp*previous)
            previous = difference
        end do
        previous = exact
        do i = 1, size(NARROW)
            difference = abs(exact - vertical_sum(spread(4, 1, NARROW(i))))
            call check(error, difference < previous/2.8_dp)
            previous = difference
        end do
        call check(error, previous < 2.5e-3_dp*exact)
    end subroutine test_convergence

    real(dp) function vertical_sum(rings)
        integer, intent(in) :: rings(:)
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: radiation

        model = model_with(rings, 'report')
        model%albedo = [1.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp]
        model%emissivity = 0
        call model%irradiance_at(LOW*X, ASTRONOMICAL_UNIT*X, 0.0_dp, radiation)
        vertical_sum = dot_product(radiation%irradiance(:radiation%count), &
                                   radiation%direction(1, :radiation%count))/E_S
    end function vertical_sum

    real(dp) function integral_over_disc(radius) result(total)
        real(dp), intent(in) :: radius
        integer, parameter :: STEPS = 100000
        real(dp) :: limb, zeta, beta
        integer :: i

        limb = asin(EARTH_RADIUS_EGM96/radius)
        total = 0
        do i = 1, STEPS
            zeta = limb*(i - 0.5_dp)/STEPS
            beta = asin(radius*sin(zeta)/EARTH_RADIUS_EGM96) - zeta
            total = total + cos(beta)*cos(zeta)*2*sin(zeta)*limb/STEPS
        end do
    end function integral_over_disc

    !> Satellite and Sun turned together about the Earth's axis: the same irradiances, directions
    !> turned.
    subroutine test_rotation(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: POSITION(3) = [3.1e6_dp, -2.2e6_dp, 5.6e6_dp]
        real(dp), parameter :: SUN(3) = ASTRONOMICAL_UNIT*[0.36_dp, 0.8_dp, 0.48_dp]
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: first, turned
        real(dp) :: m(3, 3)
        integer :: n

        model = model_with(standard_rings(3), 'report')
        m = rotation_z(1.234_dp)
        call model%irradiance_at(POSITION, SUN, 100.0_dp, first)
        call model%irradiance_at(matmul(m, POSITION), matmul(m, SUN), 100.0_dp, turned)
        n = first%count
        call check(error, maxval(abs(turned%irradiance(:n) - first%irradiance(:n))) < 1e-11_dp)
        call check(error, maxval(abs(turned%direction(:, :n) - &
                                     matmul(m, first%direction(:, :n)))) < 1e-14_dp)
        call check(error, maxval(abs(norm2(first%direction(:, :n), 1) - 1)) < 1e-14_dp)
    end subroutine test_rotation

    !> With the Sun behind the Earth only the emission is left.
    subroutine test_night(error)
        type(error_type), allocatable, intent(out) :: error
        type(earth_radiation_t) :: model, without_albedo
        type(earth_irradiance_t) :: radiation, emission
        integer :: n

        model = model_with(standard_rings(2), 'report')
        without_albedo = model
        without_albedo%albedo = 0
        n = model%segment_count
        call model%irradiance_at(LOW*X, -ASTRONOMICAL_UNIT*X, 50.0_dp, radiation)
        call without_albedo%irradiance_at(LOW*X, -ASTRONOMICAL_UNIT*X, 50.0_dp, emission)
        call check(error, all(abs(radiation%irradiance(:n) - emission%irradiance(:n)) <= 0))
        call check(error, minval(emission%irradiance(:n)) > 0)
        call model%irradiance_at(LOW*X, ASTRONOMICAL_UNIT*X, 50.0_dp, radiation)
        call check(error, all(radiation%irradiance(:n) > emission%irradiance(:n)))
    end subroutine test_night

    !> At a pole there is no north, but nothing of the zonal model's sums depends on it.
    subroutine test_poles(error)
        type(error_type), allocatable, intent(out) :: error
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: at_pole, beside
        integer :: i, n
        real(dp) :: pole(3)

        model = model_with(standard_rings(1), 'report')
        n = model%segment_count
        do i = -1, 1, 2
            pole = LOW*i*Z
            call model%irradiance_at(pole, ASTRONOMICAL_UNIT*i*Z, 10.0_dp, at_pole)
            call model%irradiance_at(pole + X, ASTRONOMICAL_UNIT*i*Z, 10.0_dp, beside)
            call check(error, maxval(abs(at_pole%irradiance(:n) - beside%irradiance(:n))) < 1e-3_dp)
            call check(error, maxval(abs(norm2(at_pole%direction(:, :n), 1) - 1)) < 1e-14_dp)
            call check(error, norm2(sum(at_pole%direction(:, :n), 2) - &
                                    sum(beside%direction(:, :n), 2)) < 1e-5_dp)
        end do
    end subroutine test_poles

    !> Reflected and emitted light of (2-10) go with the inverse square of the Sun's distance.
    subroutine test_distance(error)
        type(error_type), allocatable, intent(out) :: error
        type(earth_radiation_t) :: model
        type(earth_irradiance_t) :: near, far
        integer :: n

        model = model_with(standard_rings(1), 'report')
        n = model%segment_count
        call model%irradiance_at(LOW*X, ASTRONOMICAL_UNIT*X, 0.0_dp, near)
        call model%irradiance_at(LOW*X, 2*ASTRONOMICAL_UNIT*X, 0.0_dp, far)
        call check(error, maxval(abs(near%irradiance(:n)/far%irradiance(:n) - 4)) < 1e-12_dp)
    end subroutine test_distance

    subroutine test_failures(error)
        type(error_type), allocatable, intent(out) :: error

        call check_refused(error, 'knoke', [6], E_S, 'knocke')
        call check_refused(error, 'report', [6, 0], E_S, 'at least one segment')
        call check_refused(error, 'report', standard_rings(8), E_S, '169')
        call check_refused(error, 'report', spread(1, 1, 17), E_S, 'number of rings')
        call check_refused(error, 'report', [6], -1.0_dp, 'irradiance')
        call check_refused(error, 'report', [6], E_S*not_a_number(), 'irradiance')
    end subroutine test_failures

    subroutine check_refused(error, constants, rings, irradiance, part_of_message)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: constants, part_of_message
        integer, intent(in) :: rings(:)
        real(dp), intent(in) :: irradiance
        type(earth_radiation_t) :: model
        type(error_t), allocatable :: failure

        call new_earth_radiation(constants, rings, irradiance, model, failure)
        call check_fails(error, failure, part_of_message)
    end subroutine check_refused

    real(dp) function not_a_number()

        not_a_number = NAN
    end function not_a_number
end module test_earth_radiation
