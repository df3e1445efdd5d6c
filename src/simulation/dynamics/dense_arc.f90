!> An arc that is known at every time, not at epochs alone: all panels of its integration under control.
module gracecg_simulation_dense_arc
    use gracecg_base_kinds, only: dp
    use gracecg_base_runge_kutta, only: controlled_steps_t
    use gracecg_base_error, only: error_t
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_quaternion, only: normalised
    use gracecg_simulation_arc, only: begin_panels, next_panel, check_state
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, STATE_SIZE, ATTITUDE
    implicit none
    private
    public :: dense_arc_t, fly_densely

    !> The truth between two times.
    type :: dense_arc_t
        private
        type(controlled_steps_t), allocatable :: panels(:)  ! each as it was when it had been taken
        real(dp), allocatable :: from(:)                    ! where they begin, s
    contains
        procedure :: state_at       !! The state at a time
    end type dense_arc_t

contains

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
end module gracecg_simulation_dense_arc
