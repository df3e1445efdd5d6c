!> Runge-Kutta-Fehlberg 7(8), 13 stages: E. Fehlberg, NASA TR R-287 (1968), Table X.
!>
!> The solution is carried on with the formula of order 8; its difference from the formula of
!> order 7, h 41/840 (k1 + k11 - k12 - k13), estimates the local error. Steps under control: gracecg_base_controlled_steps.
module gracecg_base_runge_kutta
    use gracecg_base_kinds, only: dp
    use gracecg_base_table_rkf78, only: STAGES, NODES, WEIGHTS_7, WEIGHTS_8, FIRST, STAGE_USED, &
        COEFFICIENTS
    implicit none
    private
    public :: ode_system_t, rkf78_step

    integer, parameter :: OF_ORDER_7 = 11       !! The stage that no other one and not order 8 takes

    !> A system of ordinary differential equations dy/dt = f(t, y).
    type, abstract :: ode_system_t
    contains
        procedure(rate_interface), deferred :: rate !! Right-hand side of the equations
    end type ode_system_t

    abstract interface
        pure subroutine rate_interface(self, t, y, dydt)
            import :: ode_system_t, dp
            class(ode_system_t), intent(in) :: self
            real(dp), intent(in) :: t           !! Time, s
            real(dp), intent(in) :: y(:)        !! State
            real(dp), intent(out) :: dydt(:)    !! Its derivative, same shape
        end subroutine rate_interface
    end interface

contains

    !> One step of length h from (t, y): thirteen derivatives, one less without the error, which alone takes stage 11,
    !> and one less with the slope.
    pure subroutine rkf78_step(system, t, y, h, y_next, local_error, slope, within)
        class(ode_system_t), intent(in) :: system
        real(dp), intent(in) :: t, h                        !! Where the step begins, and its length
        real(dp), intent(in) :: y(:)                        !! State at t
        real(dp), intent(out) :: y_next(:)                  !! Order 8
        real(dp), intent(out), optional :: local_error(:)   !! y_next of order 7 minus order 8
        real(dp), intent(in), optional :: slope(:)          !! dy/dt at (t, y), where it is known
        real(dp), intent(in), optional :: within(2)         !! Derivatives are asked for at times between these

        real(dp) :: k(size(y), STAGES), argument(size(y)), time
        integer :: stage, entry

        k(:, OF_ORDER_7) = 0
        do stage = 1, STAGES
            if (stage == OF_ORDER_7 .and. .not. present(local_error)) cycle
            if (stage == 1 .and. present(slope)) then
                k(:, 1) = slope
                cycle
            end if
            argument = 0
            do entry = FIRST(stage), FIRST(stage + 1) - 1
                argument = argument + COEFFICIENTS(entry)*k(:, STAGE_USED(entry))
            end do
            argument = y + h*argument
            time = t + NODES(stage)*h
            if (present(within)) time = min(max(time, within(1)), within(2))
            call system%rate(time, argument, k(:, stage))
        end do
        y_next = y + h*matmul(k, WEIGHTS_8)
        if (present(local_error)) local_error = h*matmul(k, WEIGHTS_7 - WEIGHTS_8)
    end subroutine rkf78_step
end module gracecg_base_runge_kutta
