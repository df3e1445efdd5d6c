!> Runge-Kutta-Fehlberg 7(8), 13 stages: E. Fehlberg, NASA TR R-287 (1968), Table X.
!>
!> The solution is carried on with the formula of order 8; its difference from the formula of
!> order 7, h 41/840 (k1 + k11 - k12 - k13), estimates the local error for step-size control.
module gracecg_base_runge_kutta
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_table_rkf78, only: STAGES, NODES, WEIGHTS_7, WEIGHTS_8, FIRST, STAGE_USED, &
        COEFFICIENTS
    implicit none
    private
    public :: ode_system_t, rkf78_step, rkf78_integrate

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
    pure subroutine rkf78_step(system, t, y, h, y_next, local_error, slope)
        class(ode_system_t), intent(in) :: system
        real(dp), intent(in) :: t, h                        !! Where the step begins, and its length
        real(dp), intent(in) :: y(:)                        !! State at t
        real(dp), intent(out) :: y_next(:)                  !! Order 8
        real(dp), intent(out), optional :: local_error(:)   !! y_next of order 7 minus order 8
        real(dp), intent(in), optional :: slope(:)          !! dy/dt at (t, y), where it is known

        real(dp) :: k(size(y), STAGES), argument(size(y))
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
            call system%rate(t + NODES(stage)*h, argument, k(:, stage))
        end do
        y_next = y + h*matmul(k, WEIGHTS_8)
        if (present(local_error)) local_error = h*matmul(k, WEIGHTS_7 - WEIGHTS_8)
    end subroutine rkf78_step

    !> Integrates from t to t_end with step-size control: every step's estimated local error of each
    !> component stays below `tolerance * scale`.
    !>
    !> The estimate h 41/840 (k1 + k11 - k12 - k13) vanishes where dy/dt depends on t alone: a driving
    !> term asks for a `largest_step` well below its period.
    !>
    !> Fails when the step becomes too small to advance t, or a derivative is not a number.
    subroutine rkf78_integrate(system, t, y, t_end, tolerance, scale, steps, error, largest_step)
        class(ode_system_t), intent(in) :: system
        real(dp), intent(inout) :: t            !! Start time; t_end on return
        real(dp), intent(inout) :: y(:)         !! State at t
        real(dp), intent(in) :: t_end           !! s, may lie before t
        real(dp), intent(in) :: tolerance       !! Relative to scale, per step
        real(dp), intent(in) :: scale(:)        !! Size of each component, same unit, > 0
        integer, intent(out) :: steps           !! Accepted steps
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: largest_step  !! s, > 0

        real(dp), parameter :: SAFETY = 0.9_dp, LARGEST_GROWTH = 5, LARGEST_CUT = 0.1_dp
        real(dp) :: h, longest, deviation, y_next(size(y)), local_error(size(y))
        logical :: last

        steps = 0
        if (abs(t_end - t) <= 0) return
        longest = abs(t_end - t)
        if (present(largest_step)) longest = min(longest, largest_step)
        h = sign(longest, t_end - t)
        do
            if (abs(h) > longest) h = sign(longest, h)
            last = abs(h) >= abs(t_end - t)
            if (last) h = t_end - t
            call rkf78_step(system, t, y, h, y_next, local_error)
            deviation = maxval(abs(local_error)/(tolerance*scale))
            if (.not. all(abs(local_error) <= huge(h)) .or. .not. deviation <= huge(h)) then
                h = LARGEST_CUT*h
            else if (deviation <= 1) then
                t = merge(t_end, t + h, last)
                y = y_next
                steps = steps + 1
                if (last) return
                h = h*min(LARGEST_GROWTH, SAFETY*max(deviation, 1e-8_dp)**(-0.125_dp))
            else
                h = h*max(LARGEST_CUT, SAFETY*deviation**(-0.125_dp))
            end if
            if (abs(h) <= 16*epsilon(t)*max(abs(t), abs(t_end))) then
                call fail(error, 'numerical integration: the step size became too small at t = '// &
                          number_text(t)//' s; loosen the tolerance or look for '// &
                          'a discontinuity or NaN')
                return
            end if
        end do
    end subroutine rkf78_integrate
end module gracecg_base_runge_kutta
