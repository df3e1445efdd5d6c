!> Autoregressive noise against its closed forms.
module test_autoregression
    use vocabulary
    use gracecg_base_autoregression
    use gracecg_base_lapack, only: solve_normal_equations
    implicit none
    private
    public :: collect_autoregression

contains

    subroutine collect_autoregression(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('predictors-of-order-two', test_order_two), &
                    new_unittest('moving-average', test_moving_average), &
                    new_unittest('no-noise', test_no_noise), &
                    new_unittest('sums-of-several-series', test_sums), &
                    new_unittest('what-a-fit-takes', test_errors), &
                    new_unittest('missing-samples', test_missing)]
    end subroutine collect_autoregression

    !> x_i = a x_(i-1) + b x_(i-2) + e: r_1 = a/(1 - b) r_0, r_k = a r_(k-1) + b r_(k-2) (G. U. Yule, Phil. Trans. A 226 (1927)
    !> 267-298); higher orders add nothing.
    subroutine test_order_two(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: A = 0.6_dp, B = -0.3_dp, ROUNDING = 1e-7_dp
        type(autocovariances_t) :: sums
        type(autoregression_t) :: model
        real(dp) :: r(0:6)
        integer :: k

        r(0) = (1 - B)/((1 + B)*((1 - B)**2 - A**2))        ! for e of variance 1
        r(1) = A/(1 - B)*r(0)
        do k = 2, 6
            r(k) = A*r(k - 1) + B*r(k - 2)
        end do
        call sums%begin(6)
        sums%sums = r
        model = predictors_of(sums, 1.0_dp)
        call check(error, abs(model%predictor(1, 1) - r(1)/r(0)) < ROUNDING, 'order 1')
        do k = 2, 6
            call check(error, all(abs(model%predictor(:2, k) - [A, B]) < ROUNDING) .and. &
                       all(abs(model%predictor(3:k, k)) < ROUNDING), 'higher orders')
            call check(error, abs(model%deviation(k) - 1) < ROUNDING, 'what is left')
        end do
    end subroutine test_order_two

    !> Noise that rises with frequency, e_i - c e_(i-1): what the sample before leaves is 1 + c^2 - c^2/(1 + c^2), what very many
    !> leave is e.
    subroutine test_moving_average(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: C = 0.8_dp
        type(autocovariances_t) :: sums
        type(autoregression_t) :: model

        call sums%begin(40)
        sums%sums(0:1) = [1 + C**2, -C]
        model = predictors_of(sums, 1.0_dp)
        call check(error, abs(model%deviation(1)**2 - (1 + C**2 - C**2/(1 + C**2))) < 1e-7_dp, 'order 1')
        call check(error, abs(model%deviation(40) - 1) < 1e-6_dp, 'order 40')
    end subroutine test_moving_average

    !> A series without noise: predictors of 0, no NaN.
    subroutine test_no_noise(error)
        type(error_type), allocatable, intent(out) :: error
        type(autocovariances_t) :: sums
        type(autoregression_t) :: model

        call sums%begin(3)
        call sums%add([0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp])
        model = predictors_of(sums, 4.0_dp)
        call check(error, all(abs(model%predictor) <= 0) .and. all(model%deviation > 0) .and. all(model%deviation < 1e-100_dp))
    end subroutine test_no_noise

    !> Residuals r = v - A C A^T R^-1 v of a fit with weights R^-1, C = (A^T R^-1 A)^-1, have the covariance R - A C A^T (P. J. G.
    !> Teunissen, Adjustment Theory, 2000, chapter 2): with what errors took the sums are those of R, of which the series here is
    !> white.
    subroutine test_errors(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: VARIANCE = 4
        integer, parameter :: N = 7, ORDER = 3
        type(autocovariances_t) :: sums
        real(dp) :: partials(2, N), information(2, 2), covariance(2, 2), taken(N, N)
        integer :: i, k

        partials(1, :) = 1
        partials(2, :) = [(real(i, dp), i=1, N)]
        information = matmul(partials, transpose(partials))/VARIANCE
        covariance = reshape([information(2, 2), -information(2, 1), -information(1, 2), information(1, 1)], [2, 2])/ &
                     (information(1, 1)*information(2, 2) - information(1, 2)**2)
        taken = matmul(transpose(partials), matmul(covariance, partials))
        call sums%begin(ORDER)
        do i = 1, N
            sums%sums(0) = sums%sums(0) + VARIANCE - taken(i, i)
            do k = max(1, i - ORDER), i - 1
                sums%sums(i - k) = sums%sums(i - k) - taken(k, i)
            end do
        end do
        call sums%add_errors(partials, covariance)
        call check(error, abs(sums%sums(0) - N*VARIANCE) < 1e-12_dp, 'variance')
        call check(error, all(abs(sums%sums(1:)) < 1e-12_dp), 'no correlation')
    end subroutine test_errors

    !> Of two series the sums are those of the pairs in each.
    subroutine test_sums(error)
        type(error_type), allocatable, intent(out) :: error
        type(autocovariances_t) :: sums
        type(random_stream_t) :: stream
        real(dp) :: x(6)
        integer :: i

        stream = new_stream(1_i8, 1, 1, 1, 1)
        x = [(stream%normal(), i=1, 6)]
        call sums%begin(2)
        call sums%add(x(:3))
        call sums%add(x(4:))
        call check(error, sums%count, 6)
        call check(error, abs(sums%sums(0) - sum(x**2)) < 1e-14_dp)
        call check(error, abs(sums%sums(1) - (x(1)*x(2) + x(2)*x(3) + x(4)*x(5) + x(5)*x(6))) < 1e-14_dp)
        call check(error, abs(sums%sums(2) - x(1)*x(3) - x(4)*x(6)) < 1e-14_dp)
    end subroutine test_sums

    !> Samples that are missing, against their conditional mean and covariance by the covariance matrix R of the sequence (T. W.
    !> Anderson, An Introduction to Multivariate Statistical Analysis, 2003, theorem 2.5.1): with them the innovations have the
    !> squares x^T R^-1 x that the others have alone, and the sums lack their covariance.
    subroutine test_missing(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: ROUNDING = 1e-7_dp
        integer, parameter :: N = 9, MISSING(*) = [3, 4, 9], THERE(*) = [1, 2, 5, 6, 7, 8]
        type(autocovariances_t) :: sums, with
        type(autoregression_t) :: model
        type(bridge_t) :: bridge
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: covariance(N, N), inverse(6, 6), unused(6), condition, x(1, N), filled(1, N), expected(3), about(3, 3)
        integer :: i, k

        call sums%begin(N - 1)          ! noise that rises with frequency
        sums%sums(0:1) = [1.7_dp, -0.8_dp]
        model = predictors_of(sums, 1.0_dp)
        do i = 1, N
            covariance(:, i) = [(sums%sums(abs(i - k)), k=1, N)]
        end do
        stream = new_stream(1_i8, 1, 1, 1, 2)
        x(1, :) = [(stream%normal(), i=1, N)]
        call solve_normal_equations(covariance(THERE, THERE), x(1, THERE), unused, inverse, condition, failure)
        expected = matmul(covariance(MISSING, THERE), matmul(inverse, x(1, THERE)))
        about = covariance(MISSING, MISSING) - matmul(covariance(MISSING, THERE), matmul(inverse, covariance(THERE, MISSING)))
        bridge = new_bridge(model, [(all(MISSING /= i), i=1, N)])
        filled = x
        call bridge%fill(filled)
        call check(error, all(abs(filled(1, MISSING) - expected) < ROUNDING) .and. &
                   all(abs(filled(1, THERE) - x(1, THERE)) <= 0), 'conditional mean')
        call check(error, all(abs(bridge%covariance() - about) < ROUNDING), 'conditional covariance')
        call bridge%whiten(x)
        call check(error, abs(sum(x**2) - dot_product(filled(1, THERE), matmul(inverse, filled(1, THERE)))) < ROUNDING, 'squares')
        call with%begin(1)
        call with%add_missing(bridge)
        call check(error, abs(with%sums(0) - about(1, 1) - about(2, 2) - about(3, 3)) < ROUNDING .and. &
                   abs(with%sums(1) - about(1, 2)) < ROUNDING, 'what is lacking')
    end subroutine test_missing
end module test_autoregression
