!> The Runge-Kutta-Fehlberg integrator: order, exactness, error estimate.
module test_runge_kutta
    use vocabulary
    use gracecg_base_runge_kutta, only: rkf78_step
    use gracecg_base_table_rkf78
    use controlled_systems, only: kepler_t
    implicit none
    private
    public :: collect_runge_kutta

contains

    subroutine collect_runge_kutta(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('tableau-conditions', test_tableau), &
                    new_unittest('order-eight-on-kepler', test_order), &
                    new_unittest('error-estimate-is-order-seven', test_estimate)]
    end subroutine collect_runge_kutta

    !> Row sums equal the nodes; quadrature conditions sum b c^k = 1/(k+1).
    subroutine test_tableau(error)
        type(error_type), allocatable, intent(out) :: error
        integer :: i, k

        do i = 1, STAGES
            call check(error, sum(COEFFICIENTS(FIRST(i):FIRST(i + 1) - 1)), NODES(i), thr=1e-14_dp)
        end do
        do k = 0, 7
            call check(error, sum(WEIGHTS_8*NODES**k), 1/(k + 1.0_dp), thr=1e-15_dp)
            if (k < 7) call check(error, sum(WEIGHTS_7*NODES**k), 1/(k + 1.0_dp), thr=1e-15_dp)
        end do
    end subroutine test_tableau

    !> Global error after one revolution of an orbit with e = 0.3.
    real(dp) function orbit_error(steps) result(distance)
        integer, intent(in) :: steps
        type(kepler_t) :: system
        real(dp) :: y(4), next(4), start(4), h
        integer :: i

        start = [0.7_dp, 0.0_dp, 0.0_dp, sqrt(1.3_dp/0.7_dp)]
        y = start
        h = 2*PI/steps
        do i = 1, steps
            call rkf78_step(system, (i - 1)*h, y, h, next)
            y = next
        end do
        distance = norm2(y - start)
    end function orbit_error

    subroutine test_order(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: order

        order = log(orbit_error(40)/orbit_error(80))/log(2.0_dp)
        call check(error, order > 7.6_dp .and. order < 9.0_dp, 'global order 8 expected')
    end subroutine test_order

    !> The estimate shrinks as h^8 (the local error of the order-7 formula).
    subroutine test_estimate(error)
        type(error_type), allocatable, intent(out) :: error
        type(kepler_t) :: system
        real(dp) :: next(4), alone(4), slope(4), coarse(4), fine(4), order
        real(dp), parameter :: START(4) = [0.7_dp, 0.1_dp, -0.2_dp, 1.2_dp]

        call rkf78_step(system, 0.0_dp, START, 0.2_dp, next, coarse)
        call rkf78_step(system, 0.0_dp, START, 0.1_dp, next, fine)
        order = log(norm2(coarse)/norm2(fine))/log(2.0_dp)
        call check(error, order > 7.3_dp .and. order < 8.7_dp)

        ! what leaves out a derivative gives the same bits
        call rkf78_step(system, 0.0_dp, START, 0.1_dp, alone)
        call check(error, all(abs(alone - next) <= 0))
        call system%rate(0.0_dp, START, slope)
        call rkf78_step(system, 0.0_dp, START, 0.1_dp, alone, slope=slope)
        call check(error, all(abs(alone - next) <= 0))
    end subroutine test_estimate
end module test_runge_kutta
