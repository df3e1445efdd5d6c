!> The method of Adams, Bashforth and Moulton: predictor and corrector of several steps, of constant length.
!>
!> A step costs one evaluation of the derivative, against thirteen of Runge-Kutta-Fehlberg 7(8): the predictor
!> extrapolates a polynomial through the last slopes, the slope at the place it finds corrects it (E. Hairer,
!> S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, section III.1). In backward differences,
!>
!>     y(n+1) = y(n) + h sum_(j<order) gamma_j D^j f(n),
!>     gamma_j = 1 - sum_(i<j) gamma_i/(j + 1 - i);  corrector: gamma*_j = -sum_(i<j) gamma*_i/(j + 1 - i), of f(n+1).
!>
!> Its error is gamma*_order/(gamma_order - gamma*_order) of the difference between the two (1/32.5 for order 8,
!> 1/42.3 for 10), so that the difference tells of everything a polynomial does not follow: a torque that begins, an
!> edge, the Earth's shadow.
!> Where it exceeds a tolerance the step is taken by Runge and Kutta, and the method starts anew.
module gracecg_base_multistep
    use gracecg_base_kinds, only: dp
    use gracecg_base_runge_kutta, only: ode_system_t, rkf78_step
    implicit none
    private
    public :: multistep_t, new_multistep, MOST_ORDER

    integer, parameter :: MOST_ORDER = 12   !! Above, rounding grows with the coefficients

    !> The method, and the slopes behind it.
    type :: multistep_t
        private
        integer :: order = 0
        integer :: kept = 0                     ! slopes, at most order
        real(dp), allocatable :: slopes(:, :)   ! (components, order): the last one first
        real(dp) :: ahead(MOST_ORDER) = 0       ! coefficients of the predictor, of slopes 1, 2, ..
        real(dp) :: corrected(0:MOST_ORDER) = 0 ! of the corrector: the new slope, then slopes 1, 2, ..
    contains
        procedure :: restart            !! Forgets the slopes
        procedure :: keep               !! Takes the slope at the end of a step
        procedure :: is_ready           !! Are there slopes enough for `predict`?
        procedure :: predict            !! The state a step ahead, by the slopes so far
        procedure :: correct            !! The same with the slope that was found there
        procedure :: step => take_step  !! All of a step of a system, or one by Runge and Kutta
    end type multistep_t

contains

    !> A method of some order for a state of some size, without slopes yet.
    pure function new_multistep(order, components) result(method)
        integer, intent(in) :: order        !! 1 to MOST_ORDER
        integer, intent(in) :: components   !! Of the state
        type(multistep_t) :: method

        real(dp) :: gamma(0:MOST_ORDER), gamma_star(0:MOST_ORDER), binomial
        integer :: i, j, m

        method%order = max(1, min(order, MOST_ORDER))
        allocate (method%slopes(components, method%order), source=0.0_dp)
        do j = 0, method%order - 1
            gamma(j) = 1
            gamma_star(j) = merge(1, 0, j == 0)
            do i = 0, j - 1
                gamma(j) = gamma(j) - gamma(i)/(j + 1 - i)
                gamma_star(j) = gamma_star(j) - gamma_star(i)/(j + 1 - i)
            end do
            binomial = 1        ! D^j f(n) = sum_m (-1)^m binomial(j, m) f(n - m)
            do m = 0, j
                method%ahead(m + 1) = method%ahead(m + 1) + gamma(j)*(-1)**m*binomial
                method%corrected(m) = method%corrected(m) + gamma_star(j)*(-1)**m*binomial
                binomial = binomial*(j - m)/(m + 1)
            end do
        end do
    end function new_multistep

    !> Forgets the slopes: what follows has nothing to do with what was, or the step has another length.
    pure subroutine restart(self)
        class(multistep_t), intent(inout) :: self

        self%kept = 0
    end subroutine restart

    !> Takes the slope at the end of a step, or, first, where the first step begins.
    pure subroutine keep(self, slope)
        class(multistep_t), intent(inout) :: self
        real(dp), intent(in) :: slope(:)        !! dy/dt

        integer :: i

        do i = self%order, 2, -1
            self%slopes(:, i) = self%slopes(:, i - 1)
        end do
        self%slopes(:, 1) = slope
        self%kept = min(self%order, self%kept + 1)
    end subroutine keep

    !> Are there slopes enough for `predict`?
    pure logical function is_ready(self)
        class(multistep_t), intent(in) :: self

        is_ready = self%order > 0 .and. self%kept == self%order
    end function is_ready

    !> The state a step ahead, by the slopes so far.
    pure subroutine predict(self, h, y, y_next)
        class(multistep_t), intent(in) :: self
        real(dp), intent(in) :: h               !! Length of the step, the same each time
        real(dp), intent(in) :: y(:)            !! Where the last slope was found
        real(dp), intent(out) :: y_next(:)      !! A step further

        integer :: i

        y_next = 0
        do i = self%order, 1, -1
            y_next = y_next + self%ahead(i)*self%slopes(:, i)
        end do
        y_next = y + h*y_next
    end subroutine predict

    !> The same with the slope that was found where `predict` led.
    pure subroutine correct(self, h, y, slope, y_next)
        class(multistep_t), intent(in) :: self
        real(dp), intent(in) :: h               !! As for `predict`
        real(dp), intent(in) :: y(:)            !! As for `predict`
        real(dp), intent(in) :: slope(:)        !! dy/dt a step further
        real(dp), intent(out) :: y_next(:)      !! A step further

        integer :: i

        y_next = self%corrected(0)*slope
        do i = 1, self%order - 1
            y_next = y_next + self%corrected(i)*self%slopes(:, i)
        end do
        y_next = y + h*y_next
    end subroutine correct

    !> One step of a system: by this method where its slopes suffice and predictor and corrector agree within
    !> tolerance*scale, by Runge-Kutta-Fehlberg 7(8) otherwise.
    pure subroutine take_step(self, system, t, y, h, tolerance, scale, y_next)
        class(multistep_t), intent(inout) :: self
        class(ode_system_t), intent(in) :: system
        real(dp), intent(in) :: t, h            !! Where the step begins, and its length, the same each time
        real(dp), intent(in) :: y(:)            !! State at t: where the step before ended
        real(dp), intent(in) :: tolerance       !! Of the difference of predictor and corrector, relative to scale
        real(dp), intent(in) :: scale(:)        !! Size of each component, same unit, > 0
        real(dp), intent(out) :: y_next(:)      !! State at t + h

        real(dp) :: predicted(size(y)), slope(size(y))

        if (self%is_ready()) then
            call self%predict(h, y, predicted)
            call system%rate(t + h, predicted, slope)
            call self%correct(h, y, slope, y_next)
            if (all(abs(y_next - predicted) <= tolerance*scale)) then
                call self%keep(slope)
                return
            end if
            call self%restart()
        else if (self%kept == 0) then
            call system%rate(t, y, slope)
            call self%keep(slope)
        end if
        call rkf78_step(system, t, y, h, y_next)
        call system%rate(t + h, y_next, slope)
        call self%keep(slope)
    end subroutine take_step
end module gracecg_base_multistep
