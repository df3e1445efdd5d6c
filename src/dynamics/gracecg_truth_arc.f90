!> A propagated arc: the true orbit and attitude at equal intervals, with everything that acts.
module gracecg_truth_arc
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t, fail, number_text
    use gracecg_earth_shape, only: earth_fixed_to_geodetic
    use gracecg_torque_rods, only: shortest_rod_period
    use gracecg_runge_kutta, only: rkf78_step, rkf78_integrate
    use gracecg_equations_of_motion, only: satellite_dynamics_t, loads_t, STATE_SIZE, OMEGA, POSITION
    implicit none
    private
    public :: truth_arc_t, propagate_arc

    type :: truth_arc_t
        integer :: steps = 0                        !! n; epochs are k = 0..n
        real(dp) :: interval = 0                    !! s
        real(dp), allocatable :: state(:, :)        !! (13, 0:n), see gracecg_equations_of_motion
        real(dp), allocatable :: omega_dot(:, :)    !! (3, 0:n), body axes, rad/s^2
        type(loads_t), allocatable :: loads(:)      !! (0:n)
    end type truth_arc_t

    !> Scale of each state component for the error control: position, velocity, rate, quaternion.
    real(dp), parameter :: SCALES(STATE_SIZE) = [1e7_dp, 1e7_dp, 1e7_dp, 1e4_dp, 1e4_dp, 1e4_dp, &
                                                 1e-3_dp, 1e-3_dp, 1e-3_dp, 1.0_dp, 1.0_dp, 1.0_dp, 1.0_dp]

contains

    !> Integrates from t = 0 over `steps` intervals, with one Runge-Kutta step an interval, or, when
    !> `tolerance` is given, with step-size control between the epochs.
    !>
    !> Fails when the satellite hits the ground, leaves the range of its models, or a number is not
    !> finite.
    subroutine propagate_arc(dynamics, initial_state, interval, steps, arc, error, tolerance)
        class(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: initial_state(:)    !! 13
        real(dp), intent(in) :: interval            !! s
        integer, intent(in) :: steps
        type(truth_arc_t), intent(out) :: arc
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: tolerance !! Local error per step relative to SCALES

        real(dp) :: t
        integer :: k, taken

        arc%steps = steps
        arc%interval = interval
        allocate (arc%state(STATE_SIZE, 0:steps), arc%omega_dot(3, 0:steps), arc%loads(0:steps))
        arc%state(:, 0) = initial_state
        do k = 0, steps
            if (k > 0) then
                if (present(tolerance)) then
                    arc%state(:, k) = arc%state(:, k - 1)
                    t = (k - 1)*interval
                    call rkf78_integrate(dynamics, t, arc%state(:, k), k*interval, tolerance, SCALES, &
                                         taken, error, largest_step(dynamics))
                    if (allocated(error)) return
                else
                    call rkf78_step(dynamics, (k - 1)*interval, arc%state(:, k - 1), interval, &
                                    arc%state(:, k))
                end if
            end if
            call check_state(dynamics, k*interval, arc%state(:, k), error)
            if (allocated(error)) return
            call dynamics%loads(k*interval, arc%state(:, k), arc%loads(k))
            arc%omega_dot(:, k) = dynamics%angular_acceleration(arc%state(OMEGA, k), arc%loads(k))
        end do
    end subroutine propagate_arc

    !> A tenth of the shortest period of the rods, whose torque the error estimate does not see; s.
    pure real(dp) function largest_step(dynamics)
        class(satellite_dynamics_t), intent(in) :: dynamics

        largest_step = huge(1.0_dp)
        if (dynamics%with_rods) largest_step = 0.1_dp*shortest_rod_period(dynamics%rods)
    end function largest_step

    subroutine check_state(dynamics, t, state, error)
        class(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: t, state(:)
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
            call fail(error, 'the satellite is below the ground at t = '//number_text(t)//' s')
        else if (height < lowest) then
            call fail(error, 'the satellite is '//number_text(height/1000)//' km high at t = '// &
                      number_text(t)//' s, below the '//number_text(lowest/1000)// &
                      ' km from which the atmosphere model is valid')
        end if
    end subroutine check_state
end module gracecg_truth_arc
