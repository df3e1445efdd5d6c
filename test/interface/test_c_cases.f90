!> The C interface to cases, force models, propagation and simulators, called as C calls it: the numbers are those of the
!> Fortran API.
module test_c_cases
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int32_t, c_intptr_t, c_null_char, c_size_t
    use vocabulary
    use calibrations
    use gracecg, only: calibration_text, case_text, initial_state, satellite_dynamics_t, accelerations_t, loads_t, truth_arc_t, &
        propagate_arc, rotation_matrix, quaternion_product, conjugate_quaternion, STATE_POSITION, STATE_VELOCITY, STATE_ATTITUDE
    use gracecg_simulation_arc, only: MAX_STEPS
    use c_library
    use c_checks
    implicit none
    private
    public :: collect_c_cases

contains

    subroutine collect_c_cases(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('case-text', test_case_text), &
                    new_unittest('force-model', test_force_model), &
                    new_unittest('torques-and-rate', test_torques), &
                    new_unittest('propagation', test_propagation), &
                    new_unittest('truth', test_truth)]
    end subroutine collect_c_cases

    !> The text of a case is that of the Fortran API, and makes the same case again.
    subroutine test_case_text(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(error_t), allocatable :: problem
        character(:), allocatable :: expected, words, again
        character(kind=c_char), allocatable :: text(:)
        integer(c_intptr_t) :: handle, copy
        integer(c_size_t) :: length

        call check_ok(error, gracecg_case_open(c_string('back-2'), handle, failure))
        call check_ok(error, gracecg_get_text(handle, c_string('text'), size=NONE, length=length, error=failure))
        call take_calibration('back-2', calibration)
        call calibration_text(calibration, expected, problem)
        if (unmet(error, int(length), len(expected), 'length')) return
        allocate (text(length))
        status = gracecg_get_text(handle, c_string('text'), text, length, error=failure)
        call check_refused(error, BAD_SIZE, 'characters; there is room for')
        if (.not. allocated(error)) call check(error, text(1) == c_null_char, 'no empty text after a failure')
        call get_words(handle, 'text', words)
        call check(error, words == expected, 'another text')
        call check_ok(error, gracecg_case_open(c_string(words), copy, failure))
        call get_words(copy, 'text', again)
        call check(error, again == words, 'another case from the text')
        call check(error, copy /= handle, 'two cases of one handle')
        call free(handle, copy)
        call check_refused(error, HAS_FAILED, 'text', gracecg_case_open(c_string('&truth positon = 1 /'), handle, failure))
    end subroutine test_case_text

    !> Two epochs at once, parts and sum; each output may be NULL.
    subroutine test_force_model(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(satellite_dynamics_t) :: dynamics
        type(accelerations_t) :: acting
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: handle, model
        real(dp) :: state(13), x(3, 2), v(3, 2), q(4, 2), g(3, 2), d(3, 2), s(3, 2), e(3, 2), total(3, 2)
        real(dp) :: alone(3, 2)
        character(:), allocatable :: text
        real(dp), parameter :: SECONDS(2) = [0.0_dp, 12.5_dp]
        integer :: i

        status = gracecg_case_open(c_string('front-3'), handle)
        call check_ok(error, gracecg_force_model_open(handle, model, failure))
        state = item(handle, 'state', 13)
        call take_case('front-3', case)
        call check_equal(error, state, initial_state(case), 'initial state')
        x = spread(state(STATE_POSITION), 2, 2)
        v = spread(state(STATE_VELOCITY), 2, 2)
        q = spread(state(STATE_ATTITUDE), 2, 2)
        x(:, 2) = x(:, 2) + SECONDS(2)*v(:, 2)
        call check_ok(error, gracecg_force_model_evaluate(model, 2_c_size_t, SECONDS, x, v, q, g, d, s, e, total, failure))
        call make_dynamics(case, dynamics)
        do i = 1, 2
            call dynamics%accelerations(SECONDS(i), x(:, i), v(:, i), q(:, i), acting)
            call check_equal(error, [g(:, i), d(:, i), e(:, i), total(:, i)], &
                             [acting%gravity, acting%drag, acting%earth_radiation, acting%total], 'forces')
            call check_equal(error, s(:, i) + 1, acting%solar_radiation + 1, 'sunlight')
        end do
        status = gracecg_force_model_evaluate(model, 2_c_size_t, SECONDS, x, v, q, total=alone, error=failure)
        call check_equal(error, [alone], [total], 'the sum alone')
        call check_equal(error, [item(model, 'epoch', 2), item(model, 'sidereal_angle', 1)], &
                         [real(case%epoch%mjd, dp), case%epoch%seconds, &
                             case%sidereal_angle], 'epoch')
        call free(model, handle)
        case%gravity_model = 'file'
        case%gravity_file = 'nowhere.gfc'
        call case_text(case, text, problem)
        call check_ok(error, gracecg_case_open(c_string(text), handle, failure))
        call check_refused(error, HAS_FAILED, 'nowhere.gfc', gracecg_force_model_open(handle, model, failure))
        call check(error, model == 0, 'a handle after a failure')
        status = gracecg_free(handle)
    end subroutine test_force_model

    subroutine test_torques(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(satellite_dynamics_t) :: dynamics
        type(loads_t) :: acting
        integer(c_intptr_t) :: handle, model
        real(dp) :: state(13), rate(13), expected(13), torques(12), b(3), rotation(9)
        real(dp), parameter :: T = 2.5_dp

        status = gracecg_case_open(c_string('back-1'), handle)
        call check_ok(error, gracecg_force_model_open(handle, model, failure))
        call take_case('back-1', case)
        call make_dynamics(case, dynamics)
        state = initial_state(case)
        call dynamics%loads(T, state, acting)
        status = gracecg_force_model_loads(model, T, state, torques, b, error=failure)
        call check_equal(error, [torques, b], &
                         [acting%torque_aero, acting%torque_solar, acting%torque_gravity, &
                          acting%torque_magnetic, acting%field], 'torques')
        call dynamics%rate(T, state, expected)
        status = gracecg_force_model_loads(model, T, state, rate=rate, rotation=rotation, error=failure)
        call check_equal(error, rate, expected, 'rate')
        call check_equal(error, rotation, [transpose(dynamics%earth%from_inertial(T))], 'orientation')
        call free(model, handle)
    end subroutine test_torques

    subroutine test_propagation(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: STEPS = 50
        type(case_t) :: case
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: handle, model
        real(dp) :: state(13), states(13, 0:STEPS), fine(13, 0:360)

        status = gracecg_case_open(c_string('front-2'), handle)
        call check_ok(error, gracecg_force_model_open(handle, model, failure))
        call take_case('front-2', case)
        call make_dynamics(case, dynamics)
        state = initial_state(case)
        call propagate_arc(dynamics, state, 0.2_dp, STEPS, arc, problem)
        status = gracecg_force_model_propagate(model, state, 0, 0.2_dp, int(STEPS, c_size_t), 0.0_dp, states, failure)
        call check_equal(error, [states], [arc%state], 'fixed steps')
        call propagate_arc(dynamics, state, 0.2_dp, STEPS, arc, problem, 1e-12_dp)
        status = gracecg_force_model_propagate(model, state, 0, 0.2_dp, int(STEPS, c_size_t), 1e-12_dp, states, failure)
        call check_equal(error, [states], [arc%state], 'with step-size control')
        states = 0
        status = gracecg_force_model_propagate(model, state, 0, 0.2_dp, NONE, 0.0_dp, states, failure)
        call check_equal(error, states(:, 0), state, 'no step')
        status = gracecg_force_model_propagate(model, state, 0, -0.2_dp, ONE, 0.0_dp, states, failure)
        call check_refused(error, BAD_VALUE, 'interval')
        status = gracecg_force_model_propagate(model, state, 2, 2.0_dp**31, ONE, 0.0_dp, states, failure)
        call check_refused(error, BAD_VALUE, '86400 s) at most')
        state(4:6) = state(4:6)/1000
        status = gracecg_force_model_propagate(model, state, 0, 0.2_dp, ONE, 0.0_dp, states, failure)
        call check_refused(error, BAD_VALUE, 'allowed range 100 to 20000 m/s')
        state(4:6) = state(4:6)*1000
        status = gracecg_force_model_loads(model, 1e11_dp, state, rate=states(:, 0), error=failure)
        call check_refused(error, BAD_VALUE, 'at most a century')
        ! An interval that is too long for one step is flown in steps under control: six hours, by a minute and at once
        status = gracecg_force_model_propagate(model, state, 1, 600.0_dp, int(STEPS, c_size_t), 0.0_dp, states, failure)
        call check_ok(error, gracecg_force_model_propagate(model, state, 1, 60.0_dp, 36*10_c_size_t, 0.0_dp, fine, failure))
        call check(error, maxval(norm2(states(1:3, :36) - fine(1:3, ::10), 1)) < 1e-3_dp, 'long intervals')
        status = gracecg_force_model_propagate(model, state, 0, 0.2_dp, ONE, -1.0_dp, states, failure)
        call check_refused(error, BAD_VALUE, 'tolerance')
        status = gracecg_force_model_propagate(model, state, 0, 0.2_dp, int(MAX_STEPS + 1, c_size_t), 0.0_dp, &
                                               states, failure)
        call check_refused(error, BAD_SIZE, 'steps')
        status = gracecg_force_model_propagate(model, state, 3, 0.2_dp, ONE, 0.0_dp, states, failure)
        call check_refused(error, BAD_VALUE, 'pointing = 3')
        status = gracecg_force_model_propagate(model, [state(1:3), -state(1:3), state(7:)], 1, 1.0_dp, ONE, 0.0_dp, states, &
                                               failure)
        call check_refused(error, BAD_VALUE, 'plane')
        status = gracecg_force_model_propagate(model, [state(1:3), -state(1:3)*[1.0_dp, 1 + epsilon(1.0_dp), 1.0_dp], &
                                                       state(7:)], 1, 1.0_dp, ONE, 0.0_dp, states, failure)
        call check_refused(error, BAD_VALUE, 'plane')
        if (.not. allocated(error)) call compare_held(error, model, state)
        call free(model, handle)
    end subroutine test_propagation

    !> Nadir pointing: body z to the Earth, body x along or against the orbit, near the attitude of the case, whose
    !> satellite pitches by a degree; the angular velocity turns the attitude as the states have it; the orbit's energy
    !> changes by a hundred-thousandth at most, whereas a free satellite's attitude would drift away.
    subroutine compare_held(error, model, state)
        type(error_type), allocatable, intent(inout) :: error
        integer(c_intptr_t), intent(in) :: model
        real(dp), intent(in) :: state(13)               ! of the leading satellite
        integer, parameter :: STEPS = 600
        real(dp), parameter :: INTERVAL = 1, DEGREES = 2
        integer(c_int32_t) :: pointing
        real(dp) :: states(13, 0:STEPS), axes(3, 3), turn(4), rate(3)
        integer :: k

        do pointing = 1, 2
            status = gracecg_force_model_propagate(model, state, pointing, INTERVAL, int(STEPS, c_size_t), 0.0_dp, states, failure)
            call check_ok(error)
            do k = 0, STEPS, 60
                axes = rotation_matrix(states(10:13, k))
                call check(error, dot_product(axes(3, :), states(1:3, k)) < -(1 - 1e-14_dp)*norm2(states(1:3, k)) .and. &
                           (3 - 2*pointing)*dot_product(axes(1, :), states(4:6, k)) > 0.99_dp*norm2(states(4:6, k)), &
                           'axes')
            end do
            ! R(t + h) R(t)^T is the turn by h omega(t + h/2), to third order
            do k = 1, STEPS - 1, 60
                turn = quaternion_product(states(10:13, k + 1), conjugate_quaternion(states(10:13, k - 1)))
                rate = 2*turn(1:3)*sign(1.0_dp, turn(4))/(2*INTERVAL)
                call check(error, all(abs(rate - states(7:9, k)) < 1e-9_dp), 'angular velocity')
            end do
        end do
        status = gracecg_force_model_propagate(model, state, 2, INTERVAL, ONE, 0.0_dp, states, failure)
        turn = quaternion_product(states(10:13, 0), conjugate_quaternion(state(10:13)))
        call check(error, 2*norm2(turn(1:3)) < DEGREES*atan(1.0_dp)/45, 'the attitude of the case')
    end subroutine compare_held

    subroutine test_truth(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: expected
        integer(c_intptr_t) :: handle, simulator
        integer(c_size_t) :: n
        real(dp), allocatable :: t(:), b(:), drag(:)

        status = gracecg_case_open(c_string('front-1'), handle)
        call check_ok(error, gracecg_simulator_open(handle, simulator, failure))
        status = gracecg_get(simulator, c_string('time'), NONE, count=n, error=failure)
        call check(error, int(n), 601, 'epochs')
        t = item(simulator, 'time', 601)
        b = item(simulator, 'flux_density', 1803)
        drag = item(simulator, 'non_gravitational', 1803)
        call make_simulator('front-1', expected)
        call check_equal(error, item(simulator, 'state', 13*601), [expected%arc%state], 'states')
        call check_equal(error, item(simulator, 'angular_acceleration', 1803), [expected%arc%omega_dot], 'angular acceleration')
        call check_equal(error, b(1801:), [expected%arc%loads(600)%field], 'field')
        call check_equal(error, drag(901:903), expected%arc%loads(300)%drag + expected%arc%loads(300)%srp + &
                         expected%arc%loads(300)%erp, 'non-gravitational')
        call check_equal(error, [t(4), t(n)], [0.3_dp, 60.0_dp], 'times')
        call check_refused(error, BAD_SIZE, 'there are 601', gracecg_get(simulator, c_string('time'), n - 1, t, n, failure))
        call free(simulator, handle)
    end subroutine test_truth
end module test_c_cases
