!> Autoregressive noise against its closed forms.
module test_autoregression
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_autoregression
    use gracecg_base_random, only: random_stream_t, new_stream
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_autoregression

contains

    subroutine collect_autoregression(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('predictors-of-order-two', test_order_two), &
                    new_unittest('moving-average', test_moving_average), &
                    new_unittest('sums-of-several-series', test_sums)]
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
            if (allocated(error)) return
            call check(error, all(abs(model%predictor(:2, k) - [A, B]) < ROUNDING) .and. &
                       all(abs(model%predictor(3:k, k)) < ROUNDING), 'higher orders')
            if (allocated(error)) return
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
        if (allocated(error)) return
        call check(error, abs(model%deviation(40) - 1) < 1e-6_dp, 'order 40')
    end subroutine test_moving_average

    !> Of two series, with a gap and a sample that does not count, the sums are those of the pairs that there are.
    subroutine test_sums(error)
        type(error_type), allocatable, intent(out) :: error

        type(autocovariances_t) :: sums
        type(random_stream_t) :: stream
        real(dp) :: x(6)
        integer :: i

        stream = new_stream(1_i8, 1, 1, 1, 1)
        x = [(stream%normal(), i=1, 6)]
        call sums%begin(2)
        call sums%add([0, 1, 2], x(:3), [.true., .true., .true.])
        call sums%add([5, 6, 8], x(4:), [.true., .false., .true.])
        call check(error, sums%count, 5)
        if (allocated(error)) return
        call check(error, abs(sums%sums(0) - sum(x([1, 2, 3, 4, 6])**2)) < 1e-14_dp)
        if (allocated(error)) return
        call check(error, abs(sums%sums(1) - (x(1)*x(2) + x(2)*x(3))) < 1e-14_dp)
        if (allocated(error)) return
        call check(error, abs(sums%sums(2) - x(1)*x(3)) < 1e-14_dp)
    end subroutine test_sums
end module test_autoregression
