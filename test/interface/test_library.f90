!> The umbrella module: with `use gracecg` alone, models one by one, an integrator of one's own, and a
!> calibration from arrays in memory.
module test_library
    use vocabulary
    use calibrations
    use gracecg
    implicit none
    private
    public :: collect_library

contains

    subroutine collect_library(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('accelerations-add-up', test_sum), &
                    new_unittest('accelerations-by-parts', test_parts), &
                    new_unittest('own-integrator', test_own_integrator), &
                    new_unittest('own-gravity', test_own_gravity), &
                    new_unittest('calibration-in-memory', test_calibration), &
                    new_unittest('texts-in-memory', test_texts), &
                    new_unittest('arcs-too-long', test_long_arcs), &
                    new_unittest('what-was-never-made', test_unmade)]
    end subroutine collect_library

    subroutine prepare(name, dynamics, state)
        character(*), intent(in) :: name
        type(satellite_dynamics_t), intent(out) :: dynamics
        real(dp), intent(out) :: state(STATE_SIZE)
        type(case_t) :: case

        call take_case(name, case)
        call make_dynamics(case, dynamics)
        state = initial_state(case)
    end subroutine prepare

    !> The sum of the accelerations is the velocity's rate in the equations of motion.
    subroutine test_sum(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(accelerations_t) :: acting
        real(dp) :: state(STATE_SIZE), rate(STATE_SIZE), difference
        integer :: i

        do i = 1, size(CASE_NAMES)
            call prepare(CASE_NAMES(i), dynamics, state)
            call dynamics%accelerations(7.5_dp, state(STATE_POSITION), state(STATE_VELOCITY), &
                                        state(STATE_ATTITUDE), acting)
            call dynamics%rate(7.5_dp, state, rate)
            difference = norm2(acting%total - rate(STATE_VELOCITY))
            call check(error, difference < 1e-14_dp*norm2(acting%total), trim(CASE_NAMES(i)))
            call check(error, all(abs(acting%total - acting%gravity - acting%drag - acting%solar_radiation - &
                                      acting%earth_radiation) < 1e-14_dp), 'the sum of the parts')
        end do
    end subroutine test_sum

    !> Each part from the models one by one, in inertial axes: gravity by (2-3), (2-4).
    subroutine test_parts(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(case_t) :: case
        type(accelerations_t) :: acting
        type(geopotential_t) :: gravity
        type(error_t), allocatable :: failure
        real(dp) :: state(STATE_SIZE), r(3), v(3), q(4), rotation(3, 3), body(3, 3), a(3), sun(3)
        real(dp), parameter :: T = 30.0_dp

        call prepare('back-1', dynamics, state)
        call take_case('back-1', case)
        r = state(STATE_POSITION)
        v = state(STATE_VELOCITY)
        q = state(STATE_ATTITUDE)
        call dynamics%accelerations(T, r, v, q, acting)
        rotation = rotation_z(sidereal_angle(case%sidereal_angle, T))
        call egm96(case%gravity_degree, case%gravity_order, gravity, failure)
        call gravity%acceleration(matmul(rotation, r), a)
        call check(error, norm2(matmul(transpose(rotation), a) - acting%gravity) < 1e-14_dp*norm2(a), 'gravity')
        sun = sun_position(julian_centuries_tt(utc_plus(case%epoch, T)))
        body = rotation_matrix(q)
        a = solar_radiation_acceleration(dynamics%surface, case%satellite%mass, case%satellite%reflectivity_sun, &
                                         case%solar_irradiance, conical_shadow(r, sun), matmul(body, sun - r))
        call check(error, norm2(matmul(transpose(body), a) - acting%solar_radiation) <= 1e-9_dp*norm2(a) .and. &
                   norm2(a) > 0, 'sunlight')
        ! drag is against the motion through air that turns with the Earth
        a = v - EARTH_ROTATION_RATE*[-r(2), r(1), 0.0_dp]
        call check(error, -dot_product(a, acting%drag) > 0.99_dp*norm2(a)*norm2(acting%drag) .and. &
                   norm2(acting%drag) > 1e-8_dp, 'drag')
        call check(error, dot_product(r, acting%earth_radiation) > 0.9_dp*norm2(r)*norm2(acting%earth_radiation), &
                   'the Earth''s light')
    end subroutine test_parts

    !> A classical Runge-Kutta scheme of the caller's, with the attitude held, comes to the library's own
    !> orbit: the forces hardly depend on the small turns of a calibration.
    subroutine test_own_integrator(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: STEP = 1.0_dp
        integer, parameter :: STEPS = 60
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc
        type(error_t), allocatable :: failure
        real(dp) :: state(STATE_SIZE), y(6), k1(6), k2(6), k3(6), k4(6), q(4)
        integer :: i

        call prepare('front-3', dynamics, state)
        call propagate_arc(dynamics, state, 0.1_dp, 600, arc, failure)
        y = state(1:6)
        do i = 0, STEPS - 1
            q = arc%state(STATE_ATTITUDE, 10*i)
            k1 = derivative(i*STEP, y)
            k2 = derivative((i + 0.5_dp)*STEP, y + STEP/2*k1)
            k3 = derivative((i + 0.5_dp)*STEP, y + STEP/2*k2)
            k4 = derivative((i + 1)*STEP, y + STEP*k3)
            y = y + STEP/6*(k1 + 2*k2 + 2*k3 + k4)
        end do
        call check(error, norm2(y(1:3) - arc%state(STATE_POSITION, 600)) < 1e-4_dp .and. &
                   norm2(y(1:3) - state(1:3)) > 4e5_dp, 'position after a minute')

    contains

        function derivative(t, y) result(dydt)
            real(dp), intent(in) :: t, y(6)
            real(dp) :: dydt(6)
            type(accelerations_t) :: acting

            call dynamics%accelerations(t, y(1:3), y(4:6), q, acting)
            dydt = [y(4:6), acting%total]
        end function derivative
    end subroutine test_own_integrator

    !> A model can be replaced by another, and effects left out.
    subroutine test_own_gravity(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(accelerations_t) :: acting
        real(dp) :: state(STATE_SIZE), r(3)

        call prepare('front-1', dynamics, state)
        dynamics%gravity = point_mass_gravity_t(4e14_dp)
        dynamics%with_drag = .false.
        dynamics%with_solar_radiation = .false.
        dynamics%with_earth_radiation = .false.
        r = state(STATE_POSITION)
        call dynamics%accelerations(0.0_dp, r, state(STATE_VELOCITY), state(STATE_ATTITUDE), acting)
        call check(error, norm2(acting%total + 4e14_dp/norm2(r)**3*r) < 1e-14_dp*norm2(acting%total))
    end subroutine test_own_gravity

    !> Simulated, put into arrays, and estimated with the offset near the truth.
    subroutine test_calibration(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(observation_set_t) :: simulated, observations
        type(solution_t) :: solution
        integer :: i

        call take_case('front-3', case)
        call make_observations(case, 1, 1, simulated)
        observations%knowledge = simulated%knowledge
        observations%accelerometer_time = simulated%accelerometer_time
        observations%acceleration = simulated%acceleration
        observations%star_camera_time = simulated%star_camera_time
        observations%star_camera_head = simulated%star_camera_head
        observations%quaternion = simulated%quaternion
        observations%magnetometer_time = simulated%magnetometer_time
        observations%field = simulated%field
        do i = 1, size(ESTIMATOR_NAMES)
            if (estimate_fails(error, trim(ESTIMATOR_NAMES(i)), observations, estimation_options_t(), &
                               solution)) return
            ! some sigmas, with what the systematic errors add
            call check(error, all(abs(solution%offset - case%satellite%offset) < 2e-4_dp) .and. solution%converged, &
                       trim(ESTIMATOR_NAMES(i)))
        end do
    end subroutine test_calibration

    !> A case and a setup come back from their texts.
    subroutine test_texts(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case, again
        type(observation_set_t) :: observations
        type(operator_knowledge_t) :: knowledge
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, text_again

        call take_case('front-2', case)
        call case_text(case, text, failure)
        call case_from_text(text, 'memory', again, failure)
        if (failed(error, failure)) return
        call case_text(again, text_again, failure)
        call check(error, text_again == text, 'case')
        call make_observations(case, 1, 1, observations)
        call setup_text(observations%knowledge, text, failure)
        call setup_from_text(text, 'memory', knowledge, failure)
        if (failed(error, failure)) return
        call setup_text(knowledge, text_again, failure)
        if (unmet(error, text_again == text .and. len(text) > 1000, 'setup')) return
        call setup_from_text(text//'&spurious /', 'memory', knowledge, failure)
        call check_fails(error, failure, 'memory: ... spurious')
        call case_from_text('&calibration epoch = 5 /', 'memory', again, failure)
        call check_fails(error, failure, 'memory: ... epoch')
    end subroutine test_texts

    !> What would not fit into memory is refused, before it is asked for.
    subroutine test_long_arcs(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure
        real(dp) :: state(STATE_SIZE)

        call prepare('front-1', dynamics, state)
        call propagate_arc(dynamics, state, 0.1_dp, 2000000, arc, failure)
        call check_fails(error, failure, 'steps of an arc ... 1000000')
        call propagate_arc(dynamics, state, 0.1_dp, -1, arc, failure)
        call check_fails(error, failure, 'steps of an arc ... -1')
        call propagate_arc(dynamics, state, 0.0_dp, 1, arc, failure)
        call check_fails(error, failure, 'interval ... positive')
        call take_case('front-1', case)
        call make_simulator(case, simulator)
        call make_observations(simulator, 1, 1, observations)
        observations%knowledge%duration = 1e300_dp
        call check_observations(observations, failure)
        call check_fails(error, failure, 'duration ... 1000000')
        case%duration = 86400
        case%interval = 1e-3_dp
        call new_simulator(case, simulator, failure)
        call check_fails(error, failure, 'steps of an arc')
    end subroutine test_long_arcs

    !> Objects that nobody made are refused where there is an error to say so.
    subroutine test_unmade(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(fit_record_t) :: record
        type(fit_diagnostics_t) :: diagnostics
        type(solution_t) :: solution
        type(error_t), allocatable :: failure

        call observe(simulator, 1, 1, observations, failure)
        call check_fails(error, failure, 'has not been made')
        call write_observations(FOLDER//'unmade', observations, [character(1) ::], failure)
        call check_fails(error, failure, 'is empty')
        call diagnose(observations%knowledge, solution, record, diagnostics, failure)
        call check_fails(error, failure, 'not that of a fit')
    end subroutine test_unmade
end module test_library
