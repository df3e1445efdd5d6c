!> A propagated arc: the true orbit and attitude at equal intervals, with everything that acts; and one that is known at
!> every time (dense_arc_t).
module gracecg_simulation_arc
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, fail_out_of_range, number_text
    use gracecg_environment_earth_shape, only: earth_fixed_to_geodetic
    use gracecg_base_runge_kutta, only: rkf78_step, controlled_steps_t, begin_steps
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, loads_t, STATE_SIZE, OMEGA, POSITION, VELOCITY, &
        ATTITUDE
    use gracecg_simulation_nadir_pointing, only: nadir_pointing_t
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_quaternion, only: normalised
    implicit none
    private
    public :: truth_arc_t, propagate_arc, begin_arc, continue_arc, check_state, dense_arc_t, fly_densely
    public :: MAX_STEPS, DEFAULT_TOLERANCE

    integer, parameter :: MAX_STEPS = 1000000
    !! Of an arc: a day at ten epochs a second; some 0.5 GB
    real(dp), parameter :: LONGEST_INTERVAL = 86400     !! Of an arc's epochs, s
    real(dp), parameter :: LEAST_SPEED = 100            !! m/s; in km/s a satellite's would be less
    real(dp), parameter :: GREATEST_SPEED = 2e4_dp      !! m/s; nothing stays with the Earth at 1.12e4 m/s

    real(dp), parameter :: DEFAULT_TOLERANCE = 1e-10_dp
    !! Of the step control: a tenth of the error of one step every 0.1 s, whose edges lie within steps (docs/validation.md)

    !> The propagated truth: states and loads at equal intervals from the epoch. All epochs are held, or, of a long
    !> arc, those of a piece, each under its own number k; pieces share the epoch where they meet.
    type :: truth_arc_t
        integer :: steps = 0                        !! n; epochs are k = 0..n
        real(dp) :: interval = 0                    !! s
        integer :: first = 0, last = 0              !! Epochs that are held; 0 and n of a whole arc
        real(dp), allocatable :: state(:, :)        !! (13, first:last), see gracecg_simulation_dynamics
        real(dp), allocatable :: omega_dot(:, :)    !! (3, first:last), body axes, rad/s^2
        type(loads_t), allocatable :: loads(:)      !! (first:last)
        type(controlled_steps_t), allocatable, private :: under_control     ! where the integration has got to
    end type truth_arc_t

    !> Scale of each state component for the error control: position (m), velocity (m/s), rate (rad/s), quaternion, each the
    !> power of ten next to what it has in a low orbit, pointing to the Earth
    real(dp), parameter :: SCALES(STATE_SIZE) = [1e7_dp, 1e7_dp, 1e7_dp, 1e4_dp, 1e4_dp, 1e4_dp, &
                                                 1e-3_dp, 1e-3_dp, 1e-3_dp, 1.0_dp, 1.0_dp, 1.0_dp, 1.0_dp]
    real(dp), parameter :: FIRST_LENGTH = 1     ! That is tried first under control, s: short enough for any manoeuvre

    !> The truth between two times.
    type :: dense_arc_t
        private
        type(controlled_steps_t), allocatable :: panels(:)  ! each as it was when it had been taken
        real(dp), allocatable :: from(:)                    ! where they begin, s
    contains
        procedure :: state_at       !! The state at a time
    end type dense_arc_t

contains

    !> Integrates from t = 0 over `steps` intervals by Runge-Kutta-Fehlberg 7(8), the attitude free or held as `dynamics`
    !> has it: one step an interval, or, when `tolerance` is given, steps under control, between whose ends the states are
    !> interpolated (gracecg_base_runge_kutta). These end where a rod's moment begins, ends or has an edge.
    !>
    !> Fails when there are too many steps, the satellite hits the ground, leaves the range of its models,
    !> or a number is not finite.
    subroutine propagate_arc(dynamics, initial_state, interval, steps, arc, error, tolerance)
        class(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: initial_state(:)    !! 13
        real(dp), intent(in) :: interval            !! s
        integer, intent(in) :: steps                !! Number of the intervals
        type(truth_arc_t), intent(out) :: arc
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: tolerance !! Of the step control, relative to SCALES

        call begin_arc(dynamics, initial_state, interval, steps, arc, error, tolerance)
        if (.not. allocated(error)) call continue_arc(dynamics, steps, arc, error)
    end subroutine propagate_arc

    !> An arc that is propagated in pieces: its first epoch. Arguments and failures are those of `propagate_arc`.
    subroutine begin_arc(dynamics, initial_state, interval, steps, arc, error, tolerance)
        class(satellite_dynamics_t), intent(in) :: dynamics     !! With all its models
        real(dp), intent(in) :: initial_state(:)    !! (13)
        real(dp), intent(in) :: interval            !! s
        integer, intent(in) :: steps                !! Of the whole arc
        type(truth_arc_t), intent(out) :: arc       !! Holds its first epoch
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: tolerance     !! Of the step control

        if (.not. (interval > 0 .and. interval <= LONGEST_INTERVAL)) then
            call fail(error, 'the interval of an arc is '//number_text(interval)//' s: it has to be positive, a day ('// &
                      number_text(LONGEST_INTERVAL)//' s) at most')
        else if (size(initial_state) /= STATE_SIZE) then
            call fail(error, 'the state of an arc has '//number_text(real(size(initial_state), dp))//' elements; 13 are '// &
                      'needed: position, velocity, quaternion, angular velocity')
        else if (steps < 0 .or. steps > MAX_STEPS) then
            call fail_out_of_range(error, 'number of steps of an arc', real(steps, dp), 0.0_dp, real(MAX_STEPS, dp))
        end if
        if (allocated(error)) return
        arc%steps = steps
        arc%interval = interval
        allocate (arc%state(STATE_SIZE, 0:0), arc%omega_dot(3, 0:0), arc%loads(0:0))
        arc%state(:, 0) = initial_state
        call hold_attitude(dynamics, 0.0_dp, arc%state(:, 0))
        if (present(tolerance)) then
            allocate (arc%under_control)
            call begin_panels(0.0_dp, arc%state(:, 0), tolerance, arc%under_control)
        end if
        call finish_epoch(dynamics, 0, arc, error)
    end subroutine begin_arc

    !> The next epochs of an arc, in place of those that it holds, but for the last of these.
    subroutine continue_arc(dynamics, epochs, arc, error)
        class(satellite_dynamics_t), intent(in) :: dynamics     !! As at the beginning
        integer, intent(in) :: epochs                           !! How many further ones; fewer at the end
        type(truth_arc_t), intent(inout) :: arc
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: slope(STATE_SIZE)
        integer :: k

        call make_room(min(epochs, arc%steps - arc%last), arc, error)
        if (allocated(error)) return
        do k = arc%first + 1, arc%last
            if (allocated(arc%under_control)) then
                call interpolate(dynamics, k, arc, error)
                if (allocated(error)) return
            else
                call dynamics%rate_under(arc%state(:, k - 1), arc%loads(k - 1), slope)
                call rkf78_step(dynamics, (k - 1)*arc%interval, arc%state(:, k - 1), arc%interval, arc%state(:, k), &
                                slope=slope)
            end if
            call hold_attitude(dynamics, k*arc%interval, arc%state(:, k))
            call finish_epoch(dynamics, k, arc, error)
            if (allocated(error)) return
        end do
    end subroutine continue_arc

    !> What acts at epoch k, whose state is known.
    subroutine finish_epoch(dynamics, k, arc, error)
        class(satellite_dynamics_t), intent(in) :: dynamics
        integer, intent(in) :: k
        type(truth_arc_t), intent(inout) :: arc
        type(error_t), allocatable, intent(out) :: error

        call check_state(dynamics, k*arc%interval, arc%state(:, k), error)
        if (allocated(error)) return
        call dynamics%loads(k*arc%interval, arc%state(:, k), arc%loads(k))
        arc%omega_dot(:, k) = dynamics%angular_acceleration(arc%state(OMEGA, k), arc%loads(k))
    end subroutine finish_epoch

    !> The state at epoch k from steps under control, which go on until they have passed it.
    subroutine interpolate(dynamics, k, arc, error)
        class(satellite_dynamics_t), intent(in) :: dynamics
        integer, intent(in) :: k
        type(truth_arc_t), intent(inout) :: arc
        type(error_t), allocatable, intent(out) :: error

        associate (steps => arc%under_control)
            do while (steps%to < k*arc%interval)
                call next_panel(dynamics, arc%steps*arc%interval, steps, error)
                if (allocated(error)) return
            end do
            arc%state(:, k) = steps%state_at(k*arc%interval)
        end associate
    end subroutine interpolate

    !> An integration under control at its beginning.
    pure subroutine begin_panels(t, state, tolerance, steps)
        real(dp), intent(in) :: t               !! s
        real(dp), intent(in) :: state(:)        !! 13
        real(dp), intent(in) :: tolerance       !! Relative to SCALES
        type(controlled_steps_t), intent(out) :: steps

        call begin_steps(t, state, tolerance, SCALES, FIRST_LENGTH, steps)
    end subroutine begin_panels

    !> Its next panel, up to the next edge of what rods and thrusters do.
    subroutine next_panel(dynamics, end, steps, error)
        class(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: end             !! Of the integration, s
        type(controlled_steps_t), intent(inout) :: steps
        type(error_t), allocatable, intent(out) :: error

        call steps%advance(dynamics, min(end, dynamics%next_edge(steps%to + steps%shortest())), error)
    end subroutine next_panel

    !> Of a satellite whose attitude is held, attitude and angular velocity follow from the orbit; that of others is
    !> free.
    pure subroutine hold_attitude(dynamics, t, state)
        class(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: t           !! s
        real(dp), intent(inout) :: state(:) !! 13

        select type (dynamics)
        class is (nadir_pointing_t)
            call dynamics%hold(t, state)
        end select
    end subroutine hold_attitude

    !> Room for so many further epochs behind the last one, which stays.
    subroutine make_room(epochs, arc, error)
        integer, intent(in) :: epochs
        type(truth_arc_t), intent(inout) :: arc
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: state(:, :), omega_dot(:, :)
        type(loads_t), allocatable :: loads(:)
        integer :: status

        associate (from => arc%last, to => arc%last + epochs)
            allocate (state(STATE_SIZE, from:to), omega_dot(3, from:to), loads(from:to), stat=status)
            if (status /= 0) then
                call fail(error, 'no memory for an arc of '//number_text(real(epochs, dp))//' steps')
                return
            end if
            state(:, from) = arc%state(:, from)
            omega_dot(:, from) = arc%omega_dot(:, from)
            loads(from) = arc%loads(from)
        end associate
        call move_alloc(state, arc%state)
        call move_alloc(omega_dot, arc%omega_dot)
        call move_alloc(loads, arc%loads)
        arc%first = arc%last
        arc%last = arc%last + epochs
    end subroutine make_room

    !> Fails when a state is not finite, or lies below the ground or below the air's model.
    subroutine check_state(dynamics, t, state, error)
        class(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: t           !! s, for the message
        real(dp), intent(in) :: state(:)    !! 13
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: latitude, longitude, height, lowest

        if (.not. all(abs(state) <= huge(1.0_dp))) then
            call fail(error, 'the propagated state is not finite at t = '//number_text(t)//' s')
            return
        end if
        call earth_fixed_to_geodetic(state(POSITION), latitude, longitude, height)  ! any longitude does
        lowest = 0
        if (allocated(dynamics%atmosphere) .and. dynamics%with_drag) then
            lowest = dynamics%atmosphere%lowest_height()
        end if
        if (height < 0) then
            call fail(error, 'the satellite is below the ground at t = '//number_text(t)//' s, '// &
                      number_text(norm2(state(POSITION)))//' m from the centre of the Earth; positions are in metres')
        else if (.not. (norm2(state(VELOCITY)) >= LEAST_SPEED .and. norm2(state(VELOCITY)) <= GREATEST_SPEED)) then
            call fail_out_of_range(error, 'speed of the satellite at t = '//number_text(t)//' s', norm2(state(VELOCITY)), &
                                   LEAST_SPEED, GREATEST_SPEED, 'm/s')
        else if (height < lowest) then
            call fail(error, 'the satellite is '//number_text(height/1000)//' km high at t = '// &
                      number_text(t)//' s, below the '//number_text(lowest/1000)// &
                      ' km from which the atmosphere model is valid')
        end if
    end subroutine check_state

    !> Integrates from one time to another under control. Fails as `propagate_arc`.
    subroutine fly_densely(dynamics, initial_state, from, to, tolerance, arc, error)
        class(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: initial_state(:)    !! At `from`; 13
        real(dp), intent(in) :: from, to            !! s since the epoch
        real(dp), intent(in) :: tolerance           !! Of the step control
        type(dense_arc_t), intent(out) :: arc
        type(error_t), allocatable, intent(out) :: error

        type(controlled_steps_t) :: steps
        type(controlled_steps_t), allocatable :: longer(:)
        integer :: n

        call begin_panels(from, initial_state, tolerance, steps)
        allocate (arc%panels(64))
        n = 0
        do while (steps%to < to)
            call next_panel(dynamics, to, steps, error)
            if (.not. allocated(error)) call check_state(dynamics, steps%to, steps%state_at(steps%to), error)
            if (allocated(error)) return
            if (n == size(arc%panels)) then
                allocate (longer(2*n))
                longer(:n) = arc%panels
                call move_alloc(longer, arc%panels)
            end if
            n = n + 1
            arc%panels(n) = steps
        end do
        arc%panels = arc%panels(:n)
        arc%from = arc%panels%from
    end subroutine fly_densely

    !> The state at a time that was flown, its attitude of unit length.
    pure function state_at(self, t) result(state)
        class(dense_arc_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s since the epoch
        real(dp) :: state(STATE_SIZE)

        state = self%panels(max(1, last_not_after(self%from, t)))%state_at(t)
        state(ATTITUDE) = normalised(state(ATTITUDE))
    end function state_at
end module gracecg_simulation_arc
