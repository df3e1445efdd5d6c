!> The coupled equations of motion: what they conserve, their symmetries, their parts.
module test_equations_of_motion
    use vocabulary
    use calibrations
    use gracecg_base_constants, only: EARTH_ROTATION_RATE
    use gracecg_base_vectors, only: rotation_z
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_product, quaternion_from_axis_angle
    use gracecg_base_runge_kutta, only: rkf78_step
    use gracecg_environment_geopotential, only: point_mass_gravity_t
    use gracecg_environment_geomagnetic_field, only: spherical_components
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_environment_exponential_density, only: exponential_density_t, new_exponential_density
    use gracecg_spacecraft_torque_rods, only: dipole_moment
    use gracecg_simulation_dynamics
    use gracecg_simulation_case_models, only: initial_state
    implicit none
    private
    public :: collect_equations_of_motion, full_dynamics

    real(dp), parameter :: PERIOD = 5627.0_dp       !! Of the orbit, about, s
    !> A low orbit of eccentricity 0.02 and an attitude that turns about all axes
    real(dp), parameter :: STATE_0(STATE_SIZE) = [6.8e6_dp, 1.0e5_dp, -2.0e5_dp, &
                                                  300.0_dp, 1000.0_dp, 7660.0_dp, &
                                                  0.004_dp, 0.011_dp, -0.006_dp, &
                                                  0.1_dp, -0.5_dp, 0.5_dp, 0.7_dp]
    real(dp), parameter :: INERTIA(3, 3) = reshape([70.23_dp, -3.0_dp, -2.883_dp, &
                                                    -3.0_dp, 345.14_dp, -0.348_dp, &
                                                    -2.883_dp, -0.348_dp, 388.84_dp], [3, 3])

contains

    subroutine collect_equations_of_motion(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('kepler-orbit-conserves', test_kepler), &
                    new_unittest('symmetric-top-precesses', test_symmetric_top), &
                    new_unittest('turned-about-the-pole', test_turned_world), &
                    new_unittest('rate-is-the-slope', test_slope), &
                    new_unittest('length-of-the-quaternion-does-not-matter', &
                                 test_quaternion_length), &
                    new_unittest('each-effect-is-switched-alone', test_switches), &
                    new_unittest('density-wave-scales-the-drag', test_density_wave), &
                    new_unittest('rate-is-the-sum-of-the-loads', test_sum), &
                    new_unittest('forces-by-plates', test_plates), &
                    new_unittest('printed-rotations', test_printed_rotations)]
    end subroutine collect_equations_of_motion

    !> Forces plate by plate: they are those whose moment the torques are (a centre of mass that is moved by s
    !> changes them by -s x F), black plates feel the pressure of (2-8) with eta = 0, and in a cold gas that sticks
    !> to cold plates the drag is (2-6) with C_d = 2. By default nothing changes.
    subroutine test_plates(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(exponential_density_t) :: cold
        type(error_t), allocatable :: failure
        type(loads_t) :: plates, moved, report
        type(accelerations_t) :: alone
        real(dp) :: state(STATE_SIZE)
        real(dp), parameter :: S(3) = [0.3_dp, -0.2_dp, 0.5_dp]

        call full_dynamics(dynamics, state)
        state(ATTITUDE) = STATE_0(ATTITUDE)         ! no plate lies along the flow
        call dynamics%loads(0.0_dp, state, report)
        dynamics%forces_by_plates = .true.
        call dynamics%loads(0.0_dp, state, plates)
        call dynamics%accelerations(0.0_dp, state(POSITION), state(VELOCITY), state(ATTITUDE), alone)
        call check(error, maxval(abs(matmul(plates%body_from_inertial, alone%drag) - plates%drag)) < 1e-20_dp .and. &
                   norm2(plates%drag - report%drag) > 0.01_dp*norm2(report%drag) .and. &
                   norm2(plates%erp - report%erp) > 0.01_dp*norm2(report%erp) .and. &
                   all(abs(plates%torque_aero - report%torque_aero) <= 0), 'not the formulae of the report')
        dynamics%centre_of_mass = dynamics%centre_of_mass + S
        call dynamics%loads(0.0_dp, state, moved)
        call check(error, norm2(moved%torque_aero - plates%torque_aero + dynamics%mass*cross(S, plates%drag)) < &
                   1e-12_dp*norm2(plates%torque_aero), 'air')
        call check(error, norm2(moved%torque_solar - plates%torque_solar + dynamics%mass*cross(S, plates%srp)) < &
                   1e-12_dp*norm2(plates%torque_solar) .and. norm2(plates%srp) > 0, 'sunlight')

        dynamics%surface%specular = 0
        dynamics%surface%diffuse = 0
        dynamics%reflectivity_sun = 0
        dynamics%drag_coefficient = 2
        dynamics%wall%temperature = 0
        dynamics%wall%accommodation = 1
        call new_exponential_density(4e-12_dp, 466e3_dp, 1e3_dp, cold, failure)
        deallocate (dynamics%atmosphere)
        allocate (dynamics%atmosphere, source=cold)
        call dynamics%loads(0.0_dp, state, plates)
        dynamics%forces_by_plates = .false.
        call dynamics%loads(0.0_dp, state, report)
        call check(error, norm2(plates%srp - report%srp) < 1e-14_dp*norm2(report%srp), 'black plates')
        ! thermal speed 130 m/s: pressure (130/7600)^2 of the ram pressure
        call check(error, norm2(plates%drag - report%drag) < 1e-3_dp*norm2(report%drag) .and. &
                   norm2(report%drag) > 0, 'cold gas')
    end subroutine test_plates

    !> A point mass pulls, and nothing else acts.
    function bare_dynamics(inertia_tensor) result(dynamics)
        real(dp), intent(in) :: inertia_tensor(3, 3)
        type(satellite_dynamics_t) :: dynamics

        dynamics%gravity = point_mass_gravity_t(EARTH_GM)
        dynamics%mass = 420
        dynamics%inertia = inertia_tensor
        dynamics%inverse_inertia = inverse_3x3(inertia_tensor)
        dynamics%with_drag = .false.
        dynamics%with_solar_radiation = .false.
        dynamics%with_earth_radiation = .false.
        dynamics%with_gravity_gradient = .false.
        dynamics%with_rods = .false.
    end function bare_dynamics

    !> Every effect, as in case 1 of the report.
    subroutine full_dynamics(dynamics, state)
        type(satellite_dynamics_t), intent(out) :: dynamics
        real(dp), intent(out) :: state(STATE_SIZE)
        type(case_t) :: case

        call take_case('front-1', case)
        call make_dynamics(case, dynamics)
        state = initial_state(case)
    end subroutine full_dynamics

    !> The state after `steps` steps of length h from t = 0.
    function propagated(dynamics, start, h, steps) result(state)
        type(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: start(STATE_SIZE), h
        integer, intent(in) :: steps
        real(dp) :: state(STATE_SIZE), next(STATE_SIZE)

        integer :: k

        state = start
        do k = 0, steps - 1
            call rkf78_step(dynamics, k*h, state, h, next)
            state = next
        end do
    end function propagated

    !> Energy, angular momentum and the direction of the perigee over one revolution. At 10 s the
    !> method's own error is 1e-13; at 0.1 s it is rounding alone.
    subroutine test_kepler(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: STEPS(3) = [0.1_dp, 1.0_dp, 10.0_dp]
        type(satellite_dynamics_t) :: dynamics
        real(dp) :: state(STATE_SIZE), momentum(3)
        integer :: i

        dynamics = bare_dynamics(INERTIA)
        momentum = orbital_momentum(STATE_0)
        do i = 1, size(STEPS)
            state = propagated(dynamics, STATE_0, STEPS(i), nint(PERIOD/STEPS(i)))
            call check(error, energy(state), energy(STATE_0), thr=1e-12_dp, rel=.true.)
            call check(error, norm2(orbital_momentum(state) - momentum), 0.0_dp, &
                       thr=1e-12_dp*norm2(momentum))
            call check(error, norm2(perigee(state) - perigee(STATE_0)), 0.0_dp, thr=2e-12_dp)
        end do

    contains

        pure real(dp) function energy(y)
            real(dp), intent(in) :: y(:)

            energy = dot_product(y(VELOCITY), y(VELOCITY))/2 - EARTH_GM/norm2(y(POSITION))
        end function energy

        pure function orbital_momentum(y) result(h)
            real(dp), intent(in) :: y(:)
            real(dp) :: h(3)

            h = cross(y(POSITION), y(VELOCITY))
        end function orbital_momentum

        !> The eccentricity vector.
        pure function perigee(y) result(e)
            real(dp), intent(in) :: y(:)
            real(dp) :: e(3)

            e = cross(y(VELOCITY), orbital_momentum(y))/EARTH_GM - y(POSITION)/norm2(y(POSITION))
        end function perigee
    end subroutine test_kepler

    !> A free symmetric top (A, A, C): omega goes round the axis at (C - A)/A omega_z.
    subroutine test_symmetric_top(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: A = 350, C = 70, T = 600
        type(satellite_dynamics_t) :: dynamics
        real(dp) :: state(STATE_SIZE), angle, expected(3)

        dynamics = bare_dynamics(reshape([A, 0.0_dp, 0.0_dp, 0.0_dp, A, 0.0_dp, 0.0_dp, 0.0_dp, &
                                 C], &
                                         [3, 3]))
        state = propagated(dynamics, STATE_0, 1.0_dp, 600)
        angle = (C - A)/A*STATE_0(9)*T
        expected = [STATE_0(7)*cos(angle) - STATE_0(8)*sin(angle), &
                    STATE_0(7)*sin(angle) + STATE_0(8)*cos(angle), STATE_0(9)]
        call check(error, maxval(abs(state(OMEGA) - expected)), 0.0_dp, thr=1e-14_dp)
    end subroutine test_symmetric_top

    !> Satellite and Earth turned about the pole, (2-4), together: the motion is turned, too. (The Sun stays
    !> where it is, so its radiation is off.)
    subroutine test_turned_world(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: ANGLE = 0.8_dp
        type(satellite_dynamics_t) :: dynamics
        real(dp) :: start(STATE_SIZE), straight(STATE_SIZE), turned(STATE_SIZE)

        call full_dynamics(dynamics, start)
        dynamics%with_solar_radiation = .false.
        dynamics%with_earth_radiation = .false.
        straight = propagated(dynamics, start, 1.0_dp, 60)
        dynamics%earth%angle = dynamics%earth%angle + ANGLE
        turned = propagated(dynamics, turn(start), 1.0_dp, 60)
        straight = turn(straight)
        call check(error, norm2(turned(POSITION) - straight(POSITION)), 0.0_dp, thr=1e-7_dp)
        call check(error, norm2(turned(VELOCITY) - straight(VELOCITY)), 0.0_dp, thr=1e-10_dp)
        call check(error, norm2(turned(OMEGA) - straight(OMEGA)), 0.0_dp, thr=1e-16_dp)
        call check(error, norm2(turned(ATTITUDE) - straight(ATTITUDE)), 0.0_dp, thr=1e-13_dp)

    contains

        function turn(y) result(z)
            real(dp), intent(in) :: y(STATE_SIZE)
            real(dp) :: z(STATE_SIZE)

            z(POSITION) = matmul(y(POSITION), rotation_z(ANGLE))
            z(VELOCITY) = matmul(y(VELOCITY), rotation_z(ANGLE))
            z(OMEGA) = y(OMEGA)
            z(ATTITUDE) = quaternion_product(y(ATTITUDE), &
                                             quaternion_from_axis_angle([0.0_dp, 0.0_dp, 1.0_dp], &
                                                 ANGLE))
        end function turn
    end subroutine test_turned_world

    !> dX/dt of (2-31) against central differences of fourth order of the propagated state, all effects on.
    subroutine test_slope(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: H = 0.2_dp
        integer, parameter :: PLACES(4) = [-2, -1, 1, 2]
        real(dp), parameter :: WEIGHTS(4) = [1, -8, 8, -1]/(12*H)
        type(satellite_dynamics_t) :: dynamics
        real(dp) :: start(STATE_SIZE), state(STATE_SIZE), next(STATE_SIZE), slope(STATE_SIZE), &
            rate(STATE_SIZE)
        integer :: i

        call full_dynamics(dynamics, start)
        state = propagated(dynamics, start, 0.5_dp, 26)
        slope = 0
        do i = 1, 4
            call rkf78_step(dynamics, 13.0_dp, state, PLACES(i)*H, next)
            slope = slope + WEIGHTS(i)*(next - state)
        end do
        call dynamics%rate(13.0_dp, state, rate)
        ! the differences err by H^4/30 of the fifth derivative: of the rods' (2 pi 0.1 Hz)^4 times
        ! 1e-5 rad/s^2, of the orbit's (1.1e-3 Hz)^4 times 8.5 m/s^2
        call check(error, maxval(abs(slope(POSITION) - rate(POSITION))), 0.0_dp, thr=3e-8_dp)
        call check(error, maxval(abs(slope(VELOCITY) - rate(VELOCITY))), 0.0_dp, thr=3e-11_dp)
        call check(error, maxval(abs(slope(OMEGA) - rate(OMEGA))), 0.0_dp, &
                   thr=H**4/30*(0.628_dp)**4*1e-5_dp)
        call check(error, maxval(abs(slope(ATTITUDE) - rate(ATTITUDE))), 0.0_dp, thr=1e-9_dp)
    end subroutine test_slope

    !> The quaternion's length, which integration does not keep exactly, acts on nothing but its own
    !> rate.
    subroutine test_quaternion_length(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        real(dp) :: start(STATE_SIZE), rate(STATE_SIZE), scaled(STATE_SIZE)

        call full_dynamics(dynamics, start)
        call dynamics%rate(2.0_dp, start, rate)
        start(ATTITUDE) = -1.01_dp*start(ATTITUDE)
        call dynamics%rate(2.0_dp, start, scaled)
        call check(error, maxval(abs(scaled(VELOCITY) - rate(VELOCITY))), 0.0_dp, thr=1e-14_dp)
        call check(error, maxval(abs(scaled(OMEGA) - rate(OMEGA))), 0.0_dp, thr=1e-19_dp)
        call check(error, maxval(abs(scaled(ATTITUDE) + 1.01_dp*rate(ATTITUDE))), 0.0_dp, &
                   thr=1e-18_dp)
    end subroutine test_quaternion_length

    !> Without one effect its loads are zero and all others are what they were.
    subroutine test_switches(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics, less
        type(loads_t) :: all_loads
        real(dp) :: state(STATE_SIZE), with_all(3, 8)
        integer :: i

        call full_dynamics(dynamics, state)
        call dynamics%loads(2.0_dp, state, all_loads)
        with_all = listed(all_loads)
        do i = 1, 8
            call check(error, any(with_all(:, i) /= 0))
        end do
        less = dynamics
        less%with_drag = .false.
        call check_missing([1, 4])
        less = dynamics
        less%with_solar_radiation = .false.
        call check_missing([2, 5])
        less = dynamics
        less%with_earth_radiation = .false.
        call check_missing([3])
        less = dynamics
        less%with_gravity_gradient = .false.
        call check_missing([6])
        less = dynamics
        less%with_rods = .false.
        call check_missing([7])
        less = dynamics
        deallocate (less%gravity)
        call check_missing([8])
        less = dynamics
        deallocate (less%atmosphere)
        call check_missing([1, 4])
        less = dynamics
        deallocate (less%field)
        call check_missing([7])

    contains

        pure function listed(acting) result(vectors)
            type(loads_t), intent(in) :: acting
            real(dp) :: vectors(3, 8)

            vectors = reshape([acting%drag, acting%srp, acting%erp, acting%torque_aero, &
                               acting%torque_solar, acting%torque_gravity, acting%torque_magnetic, &
                               acting%gravity], [3, 8])
        end function listed

        subroutine check_missing(places)
            integer, intent(in) :: places(:)
            type(loads_t) :: acting
            real(dp) :: expected(3, 8)

            expected = with_all
            expected(:, places) = 0
            call less%loads(2.0_dp, state, acting)
            call check(error, maxval(abs(listed(acting) - expected)), 0.0_dp)
        end subroutine check_missing
    end subroutine test_switches

    !> The wave changes drag and aerodynamic torque by its relative amount and nothing else.
    subroutine test_density_wave(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: T = 2
        type(satellite_dynamics_t) :: dynamics
        type(loads_t) :: calm, waving
        real(dp) :: state(STATE_SIZE), factor

        call full_dynamics(dynamics, state)
        dynamics%density_wave = density_wave_t()
        call dynamics%loads(T, state, calm)
        dynamics%density_wave = density_wave_t(0.1_dp, 8.0_dp, 30*DEGREE)
        call dynamics%loads(T, state, waving)
        factor = 1 + 0.1_dp*sin(90*DEGREE + 30*DEGREE)/dynamics%density_scale
        call check(error, norm2(waving%drag - factor*calm%drag), 0.0_dp, &
                   thr=1e-14_dp*norm2(calm%drag))
        call check(error, norm2(waving%torque_aero - factor*calm%torque_aero), 0.0_dp, &
                   thr=1e-14_dp*norm2(calm%torque_aero))
        call check(error, norm2(waving%srp - calm%srp) + norm2(waving%erp - calm%erp) + &
                   norm2(waving%torque_solar - calm%torque_solar), 0.0_dp)
    end subroutine test_density_wave

    !> The rate is put together from the loads: accelerations in inertial axes (2-1), (3-5), torques in body
    !> axes (2-16), so J domega/dt + omega x J omega is the sum of the torques.
    subroutine test_sum(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(loads_t) :: acting
        real(dp) :: state(STATE_SIZE), rate(STATE_SIZE), force(3), torque(3), found(3)

        call full_dynamics(dynamics, state)
        call dynamics%loads(2.0_dp, state, acting)
        call dynamics%rate(2.0_dp, state, rate)
        force = acting%drag + acting%srp + acting%erp
        found = matmul(rotation_matrix(state(ATTITUDE)), rate(VELOCITY) - acting%gravity)
        call check(error, norm2(found - force) < 1e-14_dp)      ! rounding of gravity, 8.5 m/s^2
        torque = acting%torque_aero + acting%torque_solar + acting%torque_gravity + &
            acting%torque_magnetic
        found = matmul(dynamics%inertia, rate(OMEGA)) + &
                       cross(state(OMEGA), matmul(dynamics%inertia, &
                                                                                 state(OMEGA)))
        call check(error, norm2(found - torque), 0.0_dp, thr=1e-12_dp*norm2(torque))
        call check(error, norm2(rate(POSITION) - state(VELOCITY)), 0.0_dp)
    end subroutine test_sum

    !> Gravity and magnetic torque through the axes that the report prints: the gradient along radius, north
    !> and east (2-3), turned by (2-5) and (2-4); the field up, south and east, turned by (2-27) with (2-28)
    !> and (2-29) to body axes (2-30); the torque (2-25).
    subroutine test_printed_rotations(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: T = 17
        type(satellite_dynamics_t) :: dynamics
        type(loads_t) :: acting
        real(dp) :: state(STATE_SIZE), printed(3, 3), gradient(3), field(3), fixed(3), part(3)
        real(dp) :: r, latitude, longitude, right_ascension, alpha_g

        call full_dynamics(dynamics, state)
        state(POSITION) = [3.1e6_dp, -2.2e6_dp, 5.6e6_dp]
        call dynamics%loads(T, state, acting)
        r = norm2(state(POSITION))
        latitude = asin(state(3)/r)
        right_ascension = atan2(state(2), state(1))
        alpha_g = dynamics%earth%angle + EARTH_ROTATION_RATE*T
        longitude = right_ascension - alpha_g
        associate (lat => latitude, lon => longitude, ra => right_ascension, ag => alpha_g)
            printed(1, :) = [cos(lat)*cos(lon), -sin(lat)*cos(lon), -sin(lon)]
            printed(2, :) = [cos(lat)*sin(lon), -sin(lat)*sin(lon), cos(lon)]
            printed(3, :) = [sin(lat), cos(lat), 0.0_dp]
            gradient = matmul(printed, [slope([1.0_dp, 0.0_dp, 0.0_dp]), slope([0.0_dp, 1.0_dp, 0.0_dp]), &
                                        slope([0.0_dp, 0.0_dp, 1.0_dp/cos(lat)])])
            gradient = [cos(ag)*gradient(1) - sin(ag)*gradient(2), &
                        sin(ag)*gradient(1) + cos(ag)*gradient(2), gradient(3)]
            call check(error, norm2(gradient - acting%gravity), 0.0_dp, 'gravity', thr=1e-9_dp)

            fixed = r*[cos(lat)*cos(lon), cos(lat)*sin(lon), sin(lat)]
            call dynamics%field%evaluate(fixed, field)
            call spherical_components(fixed, field, part(1), part(2), part(3))
            printed(1, :) = [cos(lat)*cos(ra), sin(lat)*cos(ra), -sin(ra)]
            printed(2, :) = [cos(lat)*sin(ra), sin(lat)*sin(ra), cos(ra)]
            printed(3, :) = [sin(lat), -cos(lat), 0.0_dp]
        end associate
        field = matmul(rotation_matrix(state(ATTITUDE)/norm2(state(ATTITUDE))), matmul(printed, part))
        call check(error, norm2(field - acting%field), 0.0_dp, 'field', thr=1e-13_dp*norm2(field))
        part = cross(dipole_moment(dynamics%rods, T), field)
        call check(error, norm2(part - acting%torque_magnetic), 0.0_dp, 'torque', thr=1e-13_dp*norm2(part))
        call check(error, norm2(part) > 1e-5_dp, 'the rods act')

    contains

        !> The derivative of the potential by metres along radius, north and east (in longitude), by
        !> differences of fourth order.
        real(dp) function slope(direction)
            real(dp), intent(in) :: direction(3)
            real(dp), parameter :: STEP = 4000
            real(dp) :: u(-2:2), at(3)
            integer :: k

            do k = -2, 2
                at = [r, latitude, longitude] + k*STEP*direction*[1.0_dp, 1/r, 1/r]
                at = at(1)*[cos(at(2))*cos(at(3)), cos(at(2))*sin(at(3)), sin(at(2))]
                call dynamics%gravity%potential(at, u(k))
            end do
            slope = (u(-2) - 8*u(-1) + 8*u(1) - u(2))/(12*STEP)
        end function slope
    end subroutine test_printed_rotations
end module test_equations_of_motion
