!> Runge-Kutta-Fehlberg 7(8), 13 stages: E. Fehlberg, NASA TR R-287 (1968), Table X.
!>
!> The solution is carried on with the formula of order 8; its difference from the formula of
!> order 7, h 41/840 (k1 + k11 - k12 - k13), estimates the local error.
!>
!> Under step control, with values anywhere between the steps:
!>
!> A panel of length H is four steps of H/4. One step of H beside them is the check: a panel is taken when both end
!> within tolerance*scale of each other, and the four steps are carried on; where the solution is smooth their error is
!> 1/4^8 of the difference. (Fehlberg's own estimate, h 41/840 (k1 + k11 - k12 - k13), has no stage inside the step: it
!> does not see a torque that depends on time alone, nor an edge of the Earth's shadow between two ends. This one does.)
!>
!> Between, the solution is the polynomial of degree 9 through values y_i and slopes f_i at the five ends of the steps,
!>
!>     y(t) = sum_i [1 - 2 l_i'(x_i) (x - x_i)] l_i(x)^2 y_i + H (x - x_i) l_i(x)^2 f_i,    x = (t - t_0)/H, x_i = i/4,
!>
!> l_i the polynomials of Lagrange (Hermite's interpolation; J. Stoer, R. Bulirsch, Introduction to Numerical Analysis,
!> 2.1.5): its error is of order H^10, beside H^9 of a step. Values and slopes are continuous, and do not depend on where
!> they are asked for.
module gracecg_base_runge_kutta
    use gracecg_base_kinds, only: dp
    use gracecg_base_table_rkf78, only: STAGES, STAGE_NODES => NODES, WEIGHTS_7, WEIGHTS_8, FIRST, STAGE_USED, COEFFICIENTS
    use gracecg_base_error, only: error_t, fail, number_text
    implicit none
    private
    public :: ode_system_t, rkf78_step, controlled_steps_t, begin_steps

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

    integer, parameter :: PARTS = 4         !! Steps of a panel
    integer :: node
    real(dp), parameter :: NODES(0:PARTS) = [(real(node, dp)/PARTS, node=0, PARTS)]

    !> An integration on its way: the last panel, and what the next one is tried with.
    type :: controlled_steps_t
        real(dp) :: from = 0, to = 0            !! The last panel, s; the same before the first one
        integer :: panels = 0                   !! Taken so far
        real(dp), private :: tolerance = 0
        real(dp), private :: trial = 0          ! length of the next panel, s
        real(dp), private, allocatable :: scale(:)
        real(dp), private, allocatable :: value(:, :), slope(:, :)      ! (components, 0:PARTS)
    contains
        procedure :: advance            !! The next panel
        procedure :: state_at           !! The solution anywhere in the last panel
        procedure :: shortest           !! No panel is shorter, s
    end type controlled_steps_t

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
            time = t + STAGE_NODES(stage)*h
            if (present(within)) time = min(max(time, within(1)), within(2))
            call system%rate(time, argument, k(:, stage))
        end do
        y_next = y + h*matmul(k, WEIGHTS_8)
        if (present(local_error)) local_error = h*matmul(k, WEIGHTS_7 - WEIGHTS_8)
    end subroutine rkf78_step

    !> Puts an integration to its beginning.
    pure subroutine begin_steps(t, y, tolerance, scale, first_length, steps)
        real(dp), intent(in) :: t, y(:)         !! Time, s, and state
        real(dp), intent(in) :: tolerance       !! Of a panel's check, relative to scale
        real(dp), intent(in) :: scale(:)        !! Size of each component, same unit, > 0
        real(dp), intent(in) :: first_length    !! Of the panel that is tried first, s, > 0
        type(controlled_steps_t), intent(out) :: steps

        steps%from = t
        steps%to = t
        steps%tolerance = tolerance
        steps%trial = first_length
        steps%scale = scale
        allocate (steps%value(size(y), 0:PARTS), steps%slope(size(y), 0:PARTS), source=0.0_dp)
        steps%value(:, PARTS) = y
    end subroutine begin_steps

    !> The next panel. It ends at `limit` at the latest: an edge, on whose other side the derivative is another function.
    !> The derivative is asked for times between both ends of the panel, not at them, where it may be of either side.
    !>
    !> Fails when the panel becomes too short to advance t, or a derivative is not a number.
    subroutine advance(self, system, limit, error)
        class(controlled_steps_t), intent(inout) :: self
        class(ode_system_t), intent(in) :: system
        real(dp), intent(in) :: limit           !! s, more than `shortest` after the end of the last panel
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: SAFETY = 0.9_dp, LARGEST_GROWTH = 4, LARGEST_CUT = 0.1_dp, ORDER = 9
        real(dp) :: length, least, deviation, check(size(self%scale)), t, within(2)
        integer :: i
        logical :: last

        t = self%to
        self%from = t
        least = self%shortest()
        self%value(:, 0) = self%value(:, PARTS)
        do
            last = self%trial > limit - t - 2*least
            length = merge(limit - t, self%trial, last)
            if (.not. length > least) then
                self%to = t
                call fail(error, 'numerical integration: the step size became too small at t = '//number_text(t)// &
                          ' s; loosen the tolerance or look for a discontinuity or NaN')
                return
            end if
            self%to = merge(limit, t + length, last)
            within = [t + time_resolution(t), self%to - time_resolution(self%to)]
            do i = 0, PARTS
                associate (place => t + NODES(i)*length)
                    call system%rate(min(max(place, within(1)), within(2)), self%value(:, i), self%slope(:, i))
                    if (i < PARTS) call rkf78_step(system, place, self%value(:, i), length/PARTS, self%value(:, i + 1), &
                                                   slope=self%slope(:, i), within=within)
                end associate
            end do
            call rkf78_step(system, t, self%value(:, 0), length, check, slope=self%slope(:, 0), within=within)
            check = abs(check - self%value(:, PARTS))/(self%tolerance*self%scale)
            deviation = maxval(check)
            if (.not. all(check <= huge(length)) .or. .not. all(abs(self%slope) <= huge(length))) then
                self%trial = LARGEST_CUT*length
            else if (deviation <= 1) then
                ! a panel that an edge cut short says nothing against the length before
                self%trial = max(merge(self%trial, 0.0_dp, last), &
                                 length*min(LARGEST_GROWTH, SAFETY*max(deviation, 1e-9_dp)**(-1/ORDER)))
                self%panels = self%panels + 1
                return
            else
                self%trial = length*max(LARGEST_CUT, SAFETY*deviation**(-1/ORDER))
            end if
        end do
    end subroutine advance

    !> How near to an edge the derivative is asked for, s: on its side of it in spite of some roundings.
    pure real(dp) function time_resolution(t)
        real(dp), intent(in) :: t

        time_resolution = 8*spacing(max(1.0_dp, abs(t)))
    end function time_resolution

    !> No panel is shorter: edges that lie as near together as this are one.
    pure real(dp) function shortest(self)
        class(controlled_steps_t), intent(in) :: self

        shortest = 8*time_resolution(self%to)
    end function shortest

    !> The solution at a time.
    pure function state_at(self, t) result(y)
        class(controlled_steps_t), intent(in) :: self
        real(dp), intent(in) :: t               !! s, from `from` to `to`
        real(dp) :: y(size(self%scale))

        real(dp), dimension(0:PARTS) :: of_value, of_slope
        real(dp) :: x, length, square, bend
        integer :: i, j

        length = self%to - self%from
        x = (t - self%from)/length
        do i = 0, PARTS
            square = 1
            bend = 0
            do j = 0, PARTS
                if (j == i) cycle
                square = square*((x - NODES(j))/(NODES(i) - NODES(j)))**2
                bend = bend + 2/(NODES(i) - NODES(j))
            end do
            of_value(i) = (1 - bend*(x - NODES(i)))*square
            of_slope(i) = length*(x - NODES(i))*square
        end do
        y = matmul(self%value, of_value) + matmul(self%slope, of_slope)
    end function state_at
end module gracecg_base_runge_kutta
