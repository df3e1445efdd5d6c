!> The propagated arc: its epochs, its two ways of integration, its refusals.
module test_truth_arc
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, message_of
    use gracecg_base_runge_kutta, only: rkf78_step
    use gracecg_spacecraft_torque_rods, only: rod_activation_t, new_torque_rods, WAVEFORM_NAMES, SINE, TAPERED, SQUARE
    use gracecg_simulation_dynamics
    use gracecg_simulation_arc
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: report_case
    use gracecg_simulation_case_models, only: build_dynamics, initial_state
    use fixture, only: check_fails, check_passes
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_truth_arc

contains

    subroutine collect_truth_arc(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('epochs-and-loads', test_epochs), &
                    new_unittest('adams-and-runge-kutta', test_adams), &
                    new_unittest('fixed-and-adaptive-agree', test_adaptive), &
                    new_unittest('tolerance-bounds-the-error', test_tolerance), &
                    new_unittest('nan-is-refused', test_nan), &
                    new_unittest('ground-is-refused', test_ground)]
    end subroutine collect_truth_arc

    subroutine example(dynamics, state, error)
        type(satellite_dynamics_t), intent(out) :: dynamics
        real(dp), intent(out) :: state(STATE_SIZE)
        type(error_type), allocatable, intent(out) :: error

        type(case_t) :: case
        type(error_t), allocatable :: failure

        call report_case('front-1', case, failure)
        if (.not. allocated(failure)) call build_dynamics(case, dynamics, failure)
        call check_passes(error, message_of(failure))
        state = initial_state(case)
    end subroutine example

    !> The arc starts with the initial state; at every epoch the loads and the angular acceleration
    !> are those of the state.
    subroutine test_epochs(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc
        type(loads_t) :: acting
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE), rate(STATE_SIZE), next(STATE_SIZE)
        integer :: k

        call example(dynamics, start, error)
        if (allocated(error)) return
        call propagate_arc(dynamics, start, 0.5_dp, 10, arc, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, arc%steps == 10 .and. arc%interval == 0.5_dp .and. &
                   lbound(arc%loads, 1) == 0 .and. ubound(arc%state, 2) == 10)
        if (allocated(error)) return
        call check(error, maxval(abs(arc%state(:, 0) - start)), 0.0_dp)
        if (allocated(error)) return
        do k = 0, 10
            call dynamics%rate(0.5_dp*k, arc%state(:, k), rate)
            call dynamics%loads(0.5_dp*k, arc%state(:, k), acting)
            call check(error, maxval(abs(arc%omega_dot(:, k) - rate(OMEGA))), 0.0_dp, &
                       thr=1e-13_dp*maxval(abs(rate(OMEGA))))
            if (allocated(error)) return
            call check(error, maxval(abs(arc%loads(k)%drag - acting%drag))/norm2(acting%drag) + &
                       maxval(abs(arc%loads(k)%field - acting%field))/norm2(acting%field), 0.0_dp, thr=1e-12_dp)
            if (allocated(error)) return
        end do
        call propagate_arc(dynamics, start, 0.5_dp, 10, arc, failure, runge_kutta=.true.)
        call rkf78_step(dynamics, 4.5_dp, arc%state(:, 9), 0.5_dp, next)
        call check(error, maxval(abs(arc%state(:, 10) - next)), 0.0_dp)
    end subroutine test_epochs

    !> The method of Adams and Runge and Kutta alone, in steps of 0.1 s: rods that begin in the midst of the arc, square
    !> waves with their edges, a spinning satellite. The differences stay near the rounding of a state.
    subroutine test_adams(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: WAVEFORMS(3) = [SINE, TAPERED, SQUARE]
        real(dp), parameter :: ALLOWED(STATE_SIZE) = [1e-6_dp, 1e-6_dp, 1e-6_dp, 1e-9_dp, 1e-9_dp, 1e-9_dp, &
                                                      1e-15_dp, 1e-15_dp, 1e-15_dp, 1e-13_dp, 1e-13_dp, 1e-13_dp, 1e-13_dp]
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: adams, alone
        type(rod_activation_t) :: activation
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE), largest(STATE_SIZE)
        integer :: i, k

        call example(dynamics, start, error)
        if (allocated(error)) return
        activation = rod_activation_t(axis=2, amplitude=30.0_dp, frequency=0.1_dp, start=7.03_dp, stop=47.03_dp, &
                                      taper=5.0_dp, rise_time=1.0_dp)
        do i = 1, size(WAVEFORMS)
            activation%waveform = WAVEFORMS(i)
            activation%taper = merge(5.0_dp, 0.0_dp, WAVEFORMS(i) == TAPERED)
            call new_torque_rods(dynamics%rods, [activation], failure)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            call propagate_arc(dynamics, start, 0.1_dp, 600, adams, failure)
            call propagate_arc(dynamics, start, 0.1_dp, 600, alone, failure, runge_kutta=.true.)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            do k = 1, STATE_SIZE
                largest(k) = maxval(abs(adams%state(k, :) - alone%state(k, :)))
            end do
            call check(error, maxval(largest/ALLOWED), 0.0_dp, WAVEFORM_NAMES(WAVEFORMS(i)), thr=1.0_dp)
            if (allocated(error)) return
            call check(error, maxval(abs(adams%omega_dot - alone%omega_dot)), 0.0_dp, WAVEFORM_NAMES(WAVEFORMS(i)), &
                       thr=1e-15_dp)
            if (allocated(error)) return
            start(OMEGA) = [0.01_dp, 0.02_dp, -0.005_dp]
        end do
    end subroutine test_adams

    !> One step an epoch of 0.1 s against step-size control: over epochs of 1 s with the rods on,
    !> and over the whole minute with the rods off.
    !>
    !> (Fehlberg's error estimate, k1 + k11 - k12 - k13, vanishes where the derivative depends on
    !> time alone, as the rods' torque nearly does. So step-size control is blind to the rods'
    !> period of 10 s, and the epochs have to be close.)
    subroutine test_adaptive(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: TOLERANCE = 1e-13_dp
        type(satellite_dynamics_t) :: dynamics
        real(dp) :: start(STATE_SIZE)

        call example(dynamics, start, error)
        if (allocated(error)) return
        call compare(1.0_dp, 60)
        if (allocated(error)) return
        dynamics%with_rods = .false.
        call compare(60.0_dp, 1)

    contains

        !> The scales of the error control are 1e7 m, 1e4 m/s, 1e-3 rad/s and 1.
        subroutine compare(interval, steps)
            real(dp), intent(in) :: interval
            integer, intent(in) :: steps
            type(truth_arc_t) :: fixed, adaptive
            type(error_t), allocatable :: failure
            real(dp) :: difference(STATE_SIZE)

            call propagate_arc(dynamics, start, 0.1_dp, 600, fixed, failure)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            call propagate_arc(dynamics, start, interval, steps, adaptive, failure, TOLERANCE)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            difference = abs(fixed%state(:, 600) - adaptive%state(:, steps))
            call check(error, maxval(difference(POSITION)), 0.0_dp, thr=TOLERANCE*1e7_dp)
            if (allocated(error)) return
            call check(error, maxval(difference(VELOCITY)), 0.0_dp, thr=TOLERANCE*1e4_dp)
            if (allocated(error)) return
            call check(error, maxval(difference(OMEGA)), 0.0_dp, thr=TOLERANCE*1e-3_dp)
            if (allocated(error)) return
            call check(error, maxval(difference(ATTITUDE)), 0.0_dp, thr=TOLERANCE)
        end subroutine compare
    end subroutine test_adaptive

    !> A tumbling satellite over a quarter of an hour in one epoch: a looser tolerance takes longer
    !> steps, which shows in the result, and the error stays near it.
    subroutine test_tolerance(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: fixed, loose
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE), deviation

        call example(dynamics, start, error)
        if (allocated(error)) return
        dynamics%with_rods = .false.
        start(OMEGA) = [0.05_dp, 0.1_dp, -0.02_dp]
        call propagate_arc(dynamics, start, 1.0_dp, 900, fixed, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call propagate_arc(dynamics, start, 900.0_dp, 1, loose, failure, 1e-8_dp)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        deviation = maxval(abs(fixed%state(ATTITUDE, 900) - loose%state(ATTITUDE, 1)))
        call check(error, deviation > 1e-12_dp)
        if (allocated(error)) return
        call check(error, deviation, 0.0_dp, thr=100*1e-8_dp)
    end subroutine test_tolerance

    subroutine test_nan(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE), poisoned(STATE_SIZE)
        integer :: i

        call example(dynamics, start, error)
        if (allocated(error)) return
        do i = 1, STATE_SIZE
            poisoned = start
            poisoned(i) = ieee_value(1.0_dp, ieee_quiet_nan)
            call propagate_arc(dynamics, poisoned, 0.1_dp, 1, arc, failure)
            call check_fails(error, message_of(failure), ['not finite'])
            if (allocated(error)) return
        end do
        dynamics%mass = ieee_value(1.0_dp, ieee_quiet_nan)     ! first seen in the second state
        call propagate_arc(dynamics, start, 0.1_dp, 1, arc, failure)
        call check_fails(error, message_of(failure), [character(12) :: 'not finite', 't = 0.1 s'])
        if (allocated(error)) return
        call propagate_arc(dynamics, start, 0.1_dp, 1, arc, failure, 1e-13_dp)
        call check_fails(error, message_of(failure), ['NaN'])
    end subroutine test_nan

    !> A fall: the arc ends with an error where the atmosphere's model does.
    subroutine test_ground(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE)

        call example(dynamics, start, error)
        if (allocated(error)) return
        start(VELOCITY) = [-5000.0_dp, 0.0_dp, 5000.0_dp]
        call propagate_arc(dynamics, start, 10.0_dp, 30, arc, failure)
        call check_fails(error, message_of(failure), [character(8) :: 'below', '120 km', 't = '])
        if (allocated(error)) return
        start(VELOCITY) = [-100.0_dp, 0.0_dp, 7600.0_dp]        ! an orbit that stays above
        call propagate_arc(dynamics, start, 10.0_dp, 30, arc, failure)
        call check_passes(error, message_of(failure))
    end subroutine test_ground
end module test_truth_arc
