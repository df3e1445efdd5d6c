!> The method of Adams, Bashforth and Moulton: its order, its coefficients, and when it gives way.
module multistep_systems
    use gracecg_base_kinds, only: dp
    use gracecg_base_runge_kutta, only: ode_system_t
    implicit none
    private
    public :: power_t, kicked_t

    !> dy/dt = n t^(n - 1).
    type, extends(ode_system_t) :: power_t
        integer :: n = 1
    contains
        procedure :: rate => power_rate
    end type power_t

    !> An oscillator that is pushed with a constant force from a moment on.
    type, extends(ode_system_t) :: kicked_t
        real(dp) :: from = huge(1.0_dp)
        real(dp) :: force = 0
    contains
        procedure :: rate => kicked_rate
    end type kicked_t

contains

    pure subroutine power_rate(self, t, y, dydt)
        class(power_t), intent(in) :: self
        real(dp), intent(in) :: t, y(:)
        real(dp), intent(out) :: dydt(:)

        dydt = self%n*t**(self%n - 1) + 0*y
    end subroutine power_rate

    pure subroutine kicked_rate(self, t, y, dydt)
        class(kicked_t), intent(in) :: self
        real(dp), intent(in) :: t, y(:)
        real(dp), intent(out) :: dydt(:)

        dydt = [y(2), -y(1) + merge(self%force, 0.0_dp, t >= self%from)]
    end subroutine kicked_rate
end module multistep_systems

module test_multistep
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_is_nan
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: integer_text
    use gracecg_base_multistep
    use multistep_systems
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_multistep

contains

    subroutine collect_multistep(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('polynomials', test_polynomials), &
                    new_unittest('order', test_order), &
                    new_unittest('a-kick', test_kick), &
                    new_unittest('nan', test_nan)]
    end subroutine collect_multistep

    !> A method of order p follows t^p exactly, predictor and corrector each by itself, and t^(p + 1) not.
    subroutine test_polynomials(error)
        type(error_type), allocatable, intent(out) :: error
        type(multistep_t) :: method
        type(power_t) :: system
        real(dp) :: y(1), slope(1), predicted(1), corrected(1), miss
        integer :: order, n, k

        do order = 1, MOST_ORDER
            do n = 1, order + 1
                system%n = n
                method = new_multistep(order, 1)
                do k = 1, order
                    call method%keep([n*(0.1_dp*k)**(n - 1)])
                end do
                y = (0.1_dp*order)**n
                slope = n*(0.1_dp*(order + 1))**(n - 1)
                call method%predict(0.1_dp, y, predicted)
                call method%correct(0.1_dp, y, slope, corrected)
                miss = max(abs(predicted(1) - (0.1_dp*(order + 1))**n), abs(corrected(1) - (0.1_dp*(order + 1))**n))
                call check(error, miss < 1e-13_dp .eqv. n <= order, 'order '//integer_text(order)//', t^'//integer_text(n))
                if (allocated(error)) return
            end do
        end do
    end subroutine test_polynomials

    !> The error of an oscillator after a time shrinks as h^4 with order 4. (One evaluation a step leaves higher orders
    !> stable only in steps so short that their error is below rounding.)
    subroutine test_order(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, log(miss(400)/miss(800))/log(2.0_dp), 4.0_dp, thr=0.3_dp)

    contains

        real(dp) function miss(steps)
            integer, intent(in) :: steps

            type(multistep_t) :: method
            type(kicked_t) :: system
            real(dp) :: y(2), next(2), h
            integer :: k

            h = 8.0_dp/steps
            method = new_multistep(4, 2)
            y = [1.0_dp, 0.0_dp]
            do k = 1, steps
                call method%step(system, (k - 1)*h, y, h, 1.0_dp, [1.0_dp, 1.0_dp], next)
                y = next
            end do
            miss = norm2(y - [cos(8.0_dp), -sin(8.0_dp)])
        end function miss
    end subroutine test_order

    !> A force that begins is met by Runge and Kutta, at once, and the method starts anew.
    subroutine test_kick(error)
        type(error_type), allocatable, intent(out) :: error
        type(multistep_t) :: method
        type(kicked_t) :: system
        real(dp) :: y(2), next(2)
        real(dp), parameter :: H = 0.005_dp, START = 40*H, FORCE = 1e-3_dp
        integer :: k

        system = kicked_t(from=START - 1e-12_dp, force=FORCE)
        method = new_multistep(8, 2)
        y = [1.0_dp, 0.0_dp]
        do k = 1, 80
            call method%step(system, (k - 1)*H, y, H, 1e-12_dp, [1.0_dp, 1.0_dp], next)
            y = next
            call check(error, method%is_ready() .eqv. (k >= 7 .and. k < 40) .or. k >= 47)
            if (allocated(error)) return
        end do
        ! q = cos t + F (1 - cos(t - START))
        call check(error, y(1), cos(80*H) + FORCE*(1 - cos(80*H - START)), thr=1e-7_dp)
    end subroutine test_kick

    !> NaN is not kept back.
    subroutine test_nan(error)
        type(error_type), allocatable, intent(out) :: error
        type(multistep_t) :: method
        type(kicked_t) :: system
        real(dp) :: y(2), next(2)
        integer :: k

        method = new_multistep(4, 2)
        y = [1.0_dp, 0.0_dp]
        do k = 1, 8
            call method%step(system, k*0.1_dp, y, 0.1_dp, 1e-9_dp, [1.0_dp, 1.0_dp], next)
            y = next
        end do
        system%force = ieee_value(1.0_dp, ieee_quiet_nan)
        system%from = 0
        call method%step(system, 0.9_dp, y, 0.1_dp, 1e-9_dp, [1.0_dp, 1.0_dp], next)
        call check(error, ieee_is_nan(next(2)))
    end subroutine test_nan
end module test_multistep
