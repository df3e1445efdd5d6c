!> Gauss-Markov processes against their closed forms.
module test_gauss_markov
    use vocabulary
    use gracecg_base_gauss_markov
    implicit none
    private
    public :: collect_gauss_markov

contains

    subroutine collect_gauss_markov(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('covariance-is-stationary', test_stationary), &
                    new_unittest('autocovariance-of-the-oscillator', test_autocovariance), &
                    new_unittest('tiny-noise-of-slow-processes', test_slow), &
                    new_unittest('superposition', test_superposition)]
    end subroutine collect_gauss_markov

    subroutine test_stationary(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: OMEGA(3) = [0.05_dp, 0.7_dp, 40.0_dp], ZETA(4) = [1e-5_dp, 0.1_dp, 0.999999_dp, 1.0_dp]
        type(gauss_markov_t) :: process
        integer :: i, j

        do i = 1, size(OMEGA)
            do j = 1, size(ZETA)
                process = superposed(second_order_process(2.5_dp, OMEGA(i), ZETA(j), 0.1_dp), &
                                     first_order_process(3.0_dp, exp(-0.1_dp*OMEGA(i))))
                associate (p => process%covariance)
                    call check(error, maxval(abs(matmul(matmul(process%transition, p), transpose(process%transition)) + &
                                                 matmul(process%noise_root, transpose(process%noise_root)) - p)) < 1e-9_dp)
                end associate
            end do
        end do
    end subroutine test_stationary

    !> r(t) = sigma^2 exp(-zeta w t) (cos w' t + zeta/sqrt(1 - zeta^2) sin w' t), w' = w sqrt(1 - zeta^2)
    !> (Gelb 1974); for zeta = 1 sigma^2 exp(-w t) (1 + w t).
    subroutine test_autocovariance(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: W = 0.6_dp, H = 0.1_dp, SIGMA = 2
        real(dp), parameter :: ZETA(2) = [0.2_dp, 1.0_dp]
        type(gauss_markov_t) :: process
        real(dp) :: p(2, 2), expected, t, damped
        integer :: i, lag

        do i = 1, 2
            process = second_order_process(SIGMA, W, ZETA(i), H)
            p = process%covariance
            do lag = 1, 100
                p = matmul(process%transition, p)
                t = lag*H
                if (i == 1) then
                    damped = sqrt(1 - ZETA(i)**2)
                    expected = SIGMA**2*exp(-ZETA(i)*W*t)*(cos(W*damped*t) + ZETA(i)/damped*sin(W*damped*t))
                else
                    expected = SIGMA**2*exp(-W*t)*(1 + W*t)
                end if
                call check(error, p(1, 1), expected, thr=1e-12_dp*SIGMA**2)
            end do
        end do
    end subroutine test_autocovariance

    !> Q_11 = 4 zeta (w h)^3 sigma^2/3 for a small w h: far below the rounding of P - Phi P Phi^T.
    subroutine test_slow(error)
        type(error_type), allocatable, intent(out) :: error
        type(gauss_markov_t) :: process

        process = second_order_process(1.0_dp, 1e-5_dp, 1.0_dp, 0.1_dp)
        call check(error, process%noise_root(1, 1)**2/(4e-18_dp/3), 1.0_dp, thr=1e-5_dp)
        call check(error, process%noise_root(2, 2) > 0, 'the noise is positive definite')
    end subroutine test_slow

    subroutine test_superposition(error)
        type(error_type), allocatable, intent(out) :: error
        type(gauss_markov_t) :: process

        process = superposed(superposed(no_process(), first_order_process(3.0_dp, 0.5_dp)), &
                             second_order_process(4.0_dp, 1.0_dp, 0.5_dp, 0.1_dp))
        call check(error, process%n, 3)
        call check(error, dot_product(process%output, matmul(process%covariance, process%output)), 25.0_dp, &
                   thr=1e-13_dp)
    end subroutine test_superposition
end module test_gauss_markov
