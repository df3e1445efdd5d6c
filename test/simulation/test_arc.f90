!> The propagated arc: its epochs, its two ways of integration, its refusals.
module constant_fields
    use vocabulary
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    implicit none
    private
    public :: constant_field_t

    !> The same everywhere, Earth-fixed axes, T.
    type, extends(geomagnetic_model_t) :: constant_field_t
        real(dp) :: vector(3) = 0
    contains
        procedure :: evaluate
    end type constant_field_t

contains

    pure subroutine evaluate(self, position, b)
        class(constant_field_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: b(3)

        b = self%vector + 0*position
    end subroutine evaluate
end module constant_fields

module test_truth_arc
    use vocabulary
    use calibrations
    use gracecg_base_runge_kutta, only: rkf78_step
    use gracecg_spacecraft_torque_rods, only: rod_activation_t, new_torque_rods, WAVEFORM_NAMES, SINE, COSINE, TAPERED, SQUARE
    use gracecg_simulation_dynamics
    use gracecg_simulation_arc
    use gracecg_simulation_arc, only: dense_arc_t, fly_densely
    use gracecg_simulation_case, only: flies_under_control
    use test_equations_of_motion, only: full_dynamics
    use constant_fields, only: constant_field_t
    implicit none
    private
    public :: collect_truth_arc

contains

    subroutine collect_truth_arc(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('epochs-and-loads', test_epochs), &
                    new_unittest('controlled-and-fixed-agree', test_control), &
                    new_unittest('known-at-every-time', test_dense), &
                    new_unittest('a-jump', test_jump), &
                    new_unittest('hours-and-shadows', test_hours), &
                    new_unittest('pieces-and-threads', test_pieces), &
                    new_unittest('which-steps', test_choice), &
                    new_unittest('tolerance-bounds-the-error', test_tolerance), &
                    new_unittest('nan-and-ground-are-refused', test_nan)]
    end subroutine collect_truth_arc

    !> The arc starts with the initial state; at every epoch the loads and the angular acceleration
    !> are those of the state.
    subroutine test_epochs(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc, other
        type(loads_t) :: acting
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE), rate(STATE_SIZE), next(STATE_SIZE)
        integer :: k

        call full_dynamics(dynamics, start)
        call propagate_arc(dynamics, start, 0.5_dp, 10, arc, failure)
        if (failed(error, failure)) return
        call propagate_arc(dynamics, start(:6), 0.5_dp, 10, other, failure)
        call check_fails(error, failure, '6 elements; 13 are needed')
        call check(error, arc%steps == 10 .and. arc%interval == 0.5_dp .and. &
                   lbound(arc%loads, 1) == 0 .and. ubound(arc%state, 2) == 10)
        call check(error, maxval(abs(arc%state(:, 0) - start)), 0.0_dp)
        do k = 0, 10
            call dynamics%rate(0.5_dp*k, arc%state(:, k), rate)
            call dynamics%loads(0.5_dp*k, arc%state(:, k), acting)
            call check(error, maxval(abs(arc%omega_dot(:, k) - rate(OMEGA))), 0.0_dp, &
                       thr=1e-13_dp*maxval(abs(rate(OMEGA))))
            call check(error, maxval(abs(arc%loads(k)%drag - acting%drag))/norm2(acting%drag) + &
                       maxval(abs(arc%loads(k)%field - acting%field))/norm2(acting%field), 0.0_dp, thr=1e-12_dp)
        end do
        call rkf78_step(dynamics, 4.5_dp, arc%state(:, 9), 0.5_dp, next)
        call check(error, maxval(abs(arc%state(:, 10) - next)), 0.0_dp)
    end subroutine test_epochs

    !> An arc that is known at every time has at the epochs of another its states, and between them those of a step from
    !> there.
    subroutine test_dense(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc
        type(dense_arc_t) :: dense
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE), next(STATE_SIZE)
        integer :: k

        call full_dynamics(dynamics, start)
        call propagate_arc(dynamics, start, 0.5_dp, 40, arc, failure, 1e-12_dp)
        if (.not. allocated(failure)) call fly_densely(dynamics, start, 0.0_dp, 20.0_dp, 1e-12_dp, dense, failure)
        if (failed(error, failure)) return
        do k = 0, 39
            call check(error, maxval(abs(dense%state_at(0.5_dp*k)/arc%state(:, k) - 1), mask=abs(arc%state(:, k)) > 1e-6_dp), &
                       0.0_dp, thr=1e-12_dp)
            call rkf78_step(dynamics, 0.5_dp*k, arc%state(:, k), 0.2_dp, next)
            call check(error, maxval(abs(dense%state_at(0.5_dp*k + 0.2_dp)/next - 1), mask=abs(next) > 1e-6_dp), 0.0_dp, &
                       thr=1e-11_dp)
        end do
    end subroutine test_dense

    !> Steps under control and one every 0.01 s: rods that begin, bend and end in the midst of the arc at epochs of the
    !> latter. The differences stay near the rounding of a state.
    subroutine test_control(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: WAVEFORMS(3) = [SINE, TAPERED, SQUARE]
        real(dp), parameter :: ALLOWED(STATE_SIZE) = [1e-6_dp, 1e-6_dp, 1e-6_dp, 1e-9_dp, 1e-9_dp, 1e-9_dp, &
                                                      1e-15_dp, 1e-15_dp, 1e-15_dp, 1e-13_dp, 1e-13_dp, 1e-13_dp, 1e-13_dp]
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: controlled, fixed
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE), largest(STATE_SIZE)
        integer :: i, k

        call full_dynamics(dynamics, start)
        do i = 1, size(WAVEFORMS)
            call drive(dynamics, WAVEFORMS(i), 0.0_dp)
            call propagate_arc(dynamics, start, 0.1_dp, 600, controlled, failure, 1e-12_dp)
            if (failed(error, failure)) return
            call propagate_arc(dynamics, start, 0.01_dp, 6000, fixed, failure)
            if (failed(error, failure)) return
            do k = 1, STATE_SIZE
                largest(k) = maxval(abs(controlled%state(k, :) - fixed%state(k, ::10)))
            end do
            call check(error, maxval(largest/ALLOWED), 0.0_dp, WAVEFORM_NAMES(WAVEFORMS(i)), thr=1.0_dp)
            call check(error, maxval(abs(controlled%omega_dot - fixed%omega_dot(:, ::10))), 0.0_dp, &
                       WAVEFORM_NAMES(WAVEFORMS(i)), thr=1e-15_dp)
            start(OMEGA) = [0.01_dp, 0.02_dp, -0.005_dp]
        end do
    end subroutine test_control

    !> Drives the y rod from 7.03 to 47.03 s.
    subroutine drive(dynamics, waveform, phase)
        type(satellite_dynamics_t), intent(inout) :: dynamics
        integer, intent(in) :: waveform
        real(dp), intent(in) :: phase           !! rad
        type(error_t), allocatable :: failure

        call new_torque_rods([rod_activation_t(axis=2, amplitude=30.0_dp, frequency=0.1_dp, phase=phase, start=7.03_dp, &
                              stop=47.03_dp, waveform=waveform, taper=merge(5.0_dp, 0.0_dp, waveform == TAPERED), &
                              rise_time=1.0_dp)], &
                             dynamics%rods, failure)
        call need(failure)
    end subroutine drive

    !> A cosine begins with a jump. Steps that end there keep their order: the angular momentum that the rod gives in one
    !> and a half periods is that of the integral, without the other torques and with a satellite that is a sphere.
    subroutine test_jump(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: FIELD = 3e-5_dp
        type(satellite_dynamics_t) :: dynamics
        type(constant_field_t) :: constant
        type(truth_arc_t) :: arc
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE), expected, t
        integer :: k

        call full_dynamics(dynamics, start)
        call drive(dynamics, COSINE, 0.0_dp)
        deallocate (dynamics%field)
        constant%vector = [0.0_dp, 0.0_dp, FIELD]       ! along the axis about which the Earth turns
        allocate (dynamics%field, source=constant)
        dynamics%with_drag = .false.
        dynamics%with_solar_radiation = .false.
        dynamics%with_gravity_gradient = .false.
        dynamics%inertia = 1e6_dp*identity(3)           ! it hardly turns
        dynamics%inverse_inertia = 1e-6_dp*identity(3)
        start(OMEGA) = 0
        start(ATTITUDE) = [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
        call propagate_arc(dynamics, start, 0.1_dp, 300, arc, failure, 1e-14_dp)
        if (failed(error, failure)) return
        do k = 0, 300
            t = 0.1_dp*k - 7.03_dp
            expected = 0
            if (t > 0) expected = 30*FIELD*sin(TWO_PI*0.1_dp*t)/(TWO_PI*0.1_dp)*1e-6_dp
            call check(error, arc%state(OMEGA(1), k), expected, thr=1e-18_dp)
        end do
    end subroutine test_jump

    !> Two hours held by control, with the Earth's shadow: the tolerance, a hundredth of it, and one step every 0.1 s agree
    !> within what docs/validation.md says, and the tolerance is nearer.
    subroutine test_hours(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: EPOCHS = 7200
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc, fine, fixed
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE)

        call full_dynamics(dynamics, start)
        dynamics%control%acts = .true.
        call dynamics%control%hold(start)
        call propagate_arc(dynamics, start, 1.0_dp, EPOCHS, arc, failure, DEFAULT_TOLERANCE)
        if (.not. allocated(failure)) &
            call propagate_arc(dynamics, start, 1.0_dp, EPOCHS, fine, failure, DEFAULT_TOLERANCE/100)
        if (.not. allocated(failure)) call propagate_arc(dynamics, start, 0.1_dp, 10*EPOCHS, fixed, failure)
        if (failed(error, failure)) return
        call check(error, maxval(abs(arc%loads%srp(1))) > 1e-9_dp .and. any(abs(arc%loads%srp(1)) <= 0), 'light and shadow')
        call check(error, maxval(abs(arc%state(POSITION, :) - fine%state(POSITION, :))), 0.0_dp, 'position', thr=3e-6_dp)
        call check(error, maxval(abs(arc%state(OMEGA, :) - fine%state(OMEGA, :))), 0.0_dp, 'rate', thr=2e-12_dp)
        call check(error, maxval(abs(fixed%state(POSITION, ::10) - fine%state(POSITION, :))), 0.0_dp, 'position, fixed', &
                   thr=1e-5_dp)
        call check(error, maxval(abs(fixed%state(OMEGA, ::10) - fine%state(OMEGA, :))), 0.0_dp, 'rate, fixed', thr=2e-11_dp)
        call check(error, maxval(abs(fixed%state(OMEGA, ::10) - fine%state(OMEGA, :))) > &
                   maxval(abs(arc%state(OMEGA, :) - fine%state(OMEGA, :))))
    end subroutine test_hours

    !> An arc in pieces, and arcs in threads side by side, have the bits of the whole one; so does every tenth epoch alone,
    !> under control.
    subroutine test_pieces(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: whole, piece, sparse, beside(4)
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE)
        logical :: stopped(4)
        integer :: i, way

        call full_dynamics(dynamics, start)
        call drive(dynamics, SQUARE, 0.5_dp)
        do way = 1, 2
            call propagate(0.1_dp, 600, whole, failure)
            if (failed(error, failure)) return
            if (way == 1) then
                call begin_arc(dynamics, start, 0.1_dp, 600, piece, failure)
            else
                call begin_arc(dynamics, start, 0.1_dp, 600, piece, failure, DEFAULT_TOLERANCE)
            end if
            do while (piece%last < 600 .and. .not. allocated(failure))
                call continue_arc(dynamics, 37, piece, failure)
                call check(error, maxval(abs(piece%state - whole%state(:, piece%first:piece%last))), 0.0_dp, 'pieces')
            end do
            if (failed(error, failure)) return
            !$omp parallel do num_threads(2) private(failure)
            do i = 1, 4
                call propagate(0.1_dp, 600, beside(i), failure)
                stopped(i) = allocated(failure)
            end do
            !$omp end parallel do
            do i = 1, 4
                call check(error, .not. stopped(i))
                call check(error, maxval(abs(beside(i)%state - whole%state)), 0.0_dp, 'threads')
            end do
        end do
        call propagate(1.0_dp, 60, sparse, failure)
        call check(error, maxval(abs(sparse%state - whole%state(:, ::10))), 0.0_dp, 'epochs')

    contains

        !> As `way` has it.
        subroutine propagate(interval, steps, arc, failure)
            real(dp), intent(in) :: interval
            integer, intent(in) :: steps
            type(truth_arc_t), intent(out) :: arc
            type(error_t), allocatable, intent(out) :: failure

            if (way == 1) then
                call propagate_arc(dynamics, start, interval, steps, arc, failure)
            else
                call propagate_arc(dynamics, start, interval, steps, arc, failure, DEFAULT_TOLERANCE)
            end if
        end subroutine propagate
    end subroutine test_pieces

    !> What flies: one step an interval up to 600 s, control beyond, unless the case says which.
    subroutine test_choice(error)
        type(error_type), allocatable, intent(out) :: error
        character(16), parameter :: NAMES(3) = [character(16) :: 'rkf78', 'rkf78-fixed', 'rkf78-controlled']
        real(dp), parameter :: DURATIONS(2) = [600.0_dp, 601.0_dp]
        logical, parameter :: CONTROLLED(2, 3) = reshape([.false., .true., .false., .false., .true., .true.], [2, 3])
        type(case_t) :: case
        integer :: i, k

        call take_case('front-1', case)
        call check(error, case%integrator == NAMES(1) .and. .not. flies_under_control(case))
        do i = 1, 3
            do k = 1, 2
                case%integrator = NAMES(i)
                case%duration = DURATIONS(k)
                call check(error, flies_under_control(case) .eqv. CONTROLLED(k, i), trim(NAMES(i)))
            end do
        end do
    end subroutine test_choice

    !> A tumbling satellite over a quarter of an hour in one epoch: a looser tolerance takes longer
    !> steps, which shows in the result, and the error stays near it.
    subroutine test_tolerance(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: fixed, loose
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE), deviation

        call full_dynamics(dynamics, start)
        dynamics%with_rods = .false.
        start(OMEGA) = [0.05_dp, 0.1_dp, -0.02_dp]
        call propagate_arc(dynamics, start, 1.0_dp, 900, fixed, failure)
        if (failed(error, failure)) return
        call propagate_arc(dynamics, start, 900.0_dp, 1, loose, failure, 1e-8_dp)
        if (failed(error, failure)) return
        deviation = maxval(abs(fixed%state(ATTITUDE, 900) - loose%state(ATTITUDE, 1)))
        call check(error, deviation > 1e-12_dp)
        call check(error, deviation, 0.0_dp, thr=100*1e-8_dp)
    end subroutine test_tolerance

    !> A fall: the arc ends with an error where the atmosphere's model does.
    subroutine test_nan(error)
        type(error_type), allocatable, intent(out) :: error
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc
        type(error_t), allocatable :: failure
        real(dp) :: start(STATE_SIZE), poisoned(STATE_SIZE)
        integer :: i

        call full_dynamics(dynamics, start)
        do i = 1, STATE_SIZE
            poisoned = start
            poisoned(i) = NAN
            call propagate_arc(dynamics, poisoned, 0.1_dp, 1, arc, failure)
            call check_fails(error, failure, 'not finite')
        end do
        dynamics%mass = NAN     ! first seen in the second state
        call propagate_arc(dynamics, start, 0.1_dp, 1, arc, failure)
        call check_fails(error, failure, 'not finite ... t = 0.1 s')
        call propagate_arc(dynamics, start, 0.1_dp, 1, arc, failure, 1e-13_dp)
        call check_fails(error, failure, 'NaN')
        call full_dynamics(dynamics, start)
        start(VELOCITY) = [-5000.0_dp, 0.0_dp, 5000.0_dp]
        call propagate_arc(dynamics, start, 10.0_dp, 30, arc, failure)
        call check_fails(error, failure, 'below ... 120 km ... t = ')
        start(VELOCITY) = [-100.0_dp, 0.0_dp, 7600.0_dp]        ! an orbit that stays above
        call propagate_arc(dynamics, start, 10.0_dp, 30, arc, failure)
        call check_passes(error, failure)
    end subroutine test_nan
end module test_truth_arc
