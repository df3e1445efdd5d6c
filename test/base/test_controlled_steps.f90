!> Runge-Kutta-Fehlberg 7(8) under step control: its order between the steps, what the control sees, edges.
module controlled_systems
    use vocabulary
    use gracecg_base_runge_kutta, only: ode_system_t
    implicit none
    private
    public :: power_t, kepler_t, kicked_t

    !> dy/dt = p t^(p - 1): y = t^p.
    type, extends(ode_system_t) :: power_t
        integer :: p = 1
    contains
        procedure :: rate => power_rate
    end type power_t

    !> Kepler's problem in a plane with mu = 1; `poison` makes the derivative NaN from t = 1.
    type, extends(ode_system_t) :: kepler_t
        logical :: poison = .false.
    contains
        procedure :: rate => kepler_rate
    end type kepler_t

    !> An oscillator that rests until t = `from`, and is then pushed by the force 1: y = 1 - cos(t - from). At the time
    !> itself the derivative is not a number. A second, driven integral: dy3/dt = cos 2t.
    type, extends(ode_system_t) :: kicked_t
        real(dp) :: from = huge(1.0_dp)
    contains
        procedure :: rate => kicked_rate
    end type kicked_t

contains

    pure subroutine power_rate(self, t, y, dydt)
        class(power_t), intent(in) :: self
        real(dp), intent(in) :: t, y(:)
        real(dp), intent(out) :: dydt(:)

        dydt = self%p*t**(self%p - 1) + 0*y
    end subroutine power_rate

    pure subroutine kepler_rate(self, t, y, dydt)
        class(kepler_t), intent(in) :: self
        real(dp), intent(in) :: t, y(:)
        real(dp), intent(out) :: dydt(:)

        dydt(1:2) = y(3:4)
        dydt(3:4) = -y(1:2)/norm2(y(1:2))**3
        if (self%poison .and. t > 1) dydt = NAN
    end subroutine kepler_rate

    pure subroutine kicked_rate(self, t, y, dydt)
        class(kicked_t), intent(in) :: self
        real(dp), intent(in) :: t, y(:)
        real(dp), intent(out) :: dydt(:)

        dydt = [y(2), merge(1.0_dp, 0.0_dp, t > self%from) - y(1), cos(2*t)]
        if (.not. (t < self%from .or. t > self%from)) dydt = NAN
    end subroutine kicked_rate
end module controlled_systems

module test_controlled_steps
    use vocabulary
    use gracecg_base_runge_kutta, only: rkf78_step, controlled_steps_t, begin_steps
    use controlled_systems
    implicit none
    private
    public :: collect_controlled_steps

    real(dp), parameter :: ANY = 1e9_dp         ! a tolerance that takes every panel

contains

    subroutine collect_controlled_steps(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('exact-to-degree-eight', test_exact), &
                    new_unittest('order-between-the-steps', test_order), &
                    new_unittest('control-meets-tolerance', test_control), &
                    new_unittest('a-driving-term-is-seen', test_driven), &
                    new_unittest('edges', test_edge), &
                    new_unittest('nan-is-reported', test_nan)]
    end subroutine collect_controlled_steps

    !> t^8 comes out exactly everywhere in a panel of length 1, t^10 not.
    subroutine test_exact(error)
        type(error_type), allocatable, intent(out) :: error
        type(power_t) :: system
        type(controlled_steps_t) :: steps
        type(error_t), allocatable :: failure
        real(dp) :: t, y(1), largest
        integer :: k, p

        do p = 1, 10
            system%p = p
            call begin_steps(1.0_dp, [1.0_dp], ANY, [1.0_dp], 1.0_dp, steps)
            call steps%advance(system, 2.0_dp, failure)
            if (failed(error, failure)) return
            largest = 0
            do k = 0, 50
                t = 1 + k/50.0_dp
                y = steps%state_at(t)
                largest = max(largest, abs(y(1)/t**p - 1))
            end do
            if (p <= 8) call check(error, largest, 0.0_dp, 't^'//integer_text(p), thr=1e-14_dp)
            if (p == 10) call check(error, largest > 1e-12_dp, 'degree 10 cannot be exact')
        end do
    end subroutine test_exact

    !> Kepler's orbit, one panel and one of half the length: at their nodes and between them the error goes down by 2^9, at
    !> least, as that of one step of order 8 does.
    subroutine test_order(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: START(4) = [0.7_dp, 0.1_dp, -0.2_dp, 1.2_dp], LENGTH = 1.6_dp
        integer, parameter :: PLACES = 40, FINE = 64
        real(dp) :: missed(2), order
        integer :: halved

        do halved = 1, 2
            missed(halved) = panel_error(LENGTH/halved)
        end do
        order = log(missed(1)/missed(2))/log(2.0_dp)
        call check(error, order > 8.5_dp .and. order < 11.0_dp, 'order 9 expected')
        call check(error, missed(2) > 1e-12_dp, 'rounding hides the order')

    contains

        !> The greatest error in a panel against steps FINE times as short.
        real(dp) function panel_error(h) result(largest)
            real(dp), intent(in) :: h
            type(kepler_t) :: system
            type(controlled_steps_t) :: steps
            type(error_t), allocatable :: failure
            real(dp) :: y(4), next(4)
            integer :: i, k

            call begin_steps(0.0_dp, START, ANY, [1.0_dp, 1.0_dp, 1.0_dp, 1.0_dp], h, steps)
            call steps%advance(system, h, failure)
            y = START
            largest = 0
            do k = 1, PLACES
                do i = 1, FINE
                    call rkf78_step(system, 0.0_dp, y, h/(PLACES*FINE), next)
                    y = next
                end do
                largest = max(largest, norm2(steps%state_at(h*k/PLACES) - y))
            end do
        end function panel_error
    end subroutine test_order

    !> An orbit with e = 0.9, whose steps must vary: it closes, and the energy is that of the start at any time.
    subroutine test_control(error)
        type(error_type), allocatable, intent(out) :: error
        type(kepler_t) :: system
        type(controlled_steps_t) :: steps
        type(error_t), allocatable :: failure
        real(dp), parameter :: START(4) = [0.1_dp, 0.0_dp, 0.0_dp, sqrt(1.9_dp/0.1_dp)]
        real(dp) :: y(4), largest
        integer :: k

        call begin_steps(0.0_dp, START, 1e-9_dp, [1.0_dp, 1.0_dp, 1.0_dp, 1.0_dp], 1.0_dp, steps)
        largest = 0
        do k = 1, 1000
            do while (steps%to < 2*PI*k/1000)
                call steps%advance(system, 2*PI, failure)
                call check_passes(error, failure)
            end do
            y = steps%state_at(2*PI*k/1000)
            largest = max(largest, abs(norm2(y(3:4))**2/2 - 1/norm2(y(1:2)) + 0.5_dp))
        end do
        call check(error, largest, 0.0_dp, 'energy', thr=1e-9_dp)
        call check(error, norm2(y - START), 0.0_dp, 'a revolution', thr=1e-8_dp)
        call check(error, steps%panels > 10 .and. steps%panels < 100)
    end subroutine test_control

    !> An integral of a driving term, which the difference of Fehlberg's two formulas is blind to, keeps to the tolerance.
    subroutine test_driven(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: T_END = 20
        type(kicked_t) :: system
        type(controlled_steps_t) :: steps
        type(error_t), allocatable :: failure
        real(dp) :: next(3), local_error(3), y(3)

        call rkf78_step(system, 0.0_dp, [0.0_dp, 0.0_dp, 0.0_dp], 1.0_dp, next, local_error)
        call check(error, abs(local_error(3)) < 1e-16_dp .and. abs(next(3) - sin(2.0_dp)/2) > 1e-8_dp, 'blind')
        call begin_steps(0.0_dp, [0.0_dp, 0.0_dp, 0.0_dp], 1e-12_dp, [1.0_dp, 1.0_dp, 1.0_dp], T_END, steps)
        do while (steps%to < T_END)
            call steps%advance(system, T_END, failure)
            call check_passes(error, failure)
        end do
        y = steps%state_at(T_END)
        call check(error, y(3), sin(2*T_END)/2, thr=1e-13_dp)
    end subroutine test_driven

    !> A force that jumps: a step that ends there keeps the order, before and behind, and asks for no derivative at the
    !> edge itself. Unforeseen, it costs panels, not accuracy.
    subroutine test_edge(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: EDGE = 1.23_dp, T_END = 5, TOLERANCE = 1e-11_dp
        type(kicked_t) :: system
        integer :: foreseen, unforeseen

        system%from = EDGE
        foreseen = panels_of(EDGE)
        unforeseen = panels_of(T_END)
        call check(error, foreseen < 25 .and. unforeseen > 2*foreseen)

    contains

        integer function panels_of(first_limit)
            real(dp), intent(in) :: first_limit
            type(controlled_steps_t) :: steps
            type(error_t), allocatable :: failure
            real(dp) :: t, y(3), largest
            integer :: k

            call begin_steps(0.0_dp, [0.0_dp, 0.0_dp, 0.0_dp], TOLERANCE, [1.0_dp, 1.0_dp, 1.0_dp], 0.5_dp, steps)
            largest = 0
            do k = 1, 500
                t = k*T_END/500
                do while (steps%to < t)
                    call steps%advance(system, merge(first_limit, T_END, steps%to < first_limit), failure)
                    call check_passes(error, failure)
                end do
                y = steps%state_at(t)
                largest = max(largest, abs(y(1) - merge(1 - cos(t - EDGE), 0.0_dp, t > EDGE)))
            end do
            call check(error, largest, 0.0_dp, thr=10*TOLERANCE)
            panels_of = steps%panels
        end function panels_of
    end subroutine test_edge

    subroutine test_nan(error)
        type(error_type), allocatable, intent(out) :: error
        type(kepler_t) :: system
        type(controlled_steps_t) :: steps
        type(error_t), allocatable :: failure
        integer :: k

        system%poison = .true.
        call begin_steps(0.0_dp, [0.7_dp, 0.0_dp, 0.0_dp, 1.2_dp], 1e-10_dp, [1.0_dp, 1.0_dp, 1.0_dp, 1.0_dp], 1.0_dp, steps)
        do k = 1, 1000
            call steps%advance(system, 3.0_dp, failure)
            if (allocated(failure)) exit
        end do
        call check_fails(error, failure, 'NaN')
        call check(error, steps%to, 1.0_dp, thr=1e-6_dp)
    end subroutine test_nan
end module test_controlled_steps
