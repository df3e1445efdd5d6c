!> The median, and the tail of the chi-square distribution.
module test_statistics
    use vocabulary
    use gracecg_base_statistics, only: median_of, order_of, chi_square_tail
    implicit none
    private
    public :: collect_statistics

contains

    subroutine collect_statistics(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('median', test_median), &
                    new_unittest('order', test_order), &
                    new_unittest('chi-square-tail', test_tail)]
    end subroutine collect_statistics

    !> Of few numbers; of many as many lie below it as above it.
    subroutine test_median(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: stream
        real(dp) :: values(1001), median

        call check(error, median_of([5.0_dp, -1.0_dp, 3.0_dp]), 3.0_dp)
        call check(error, median_of([4.0_dp, 1.0_dp, 1e9_dp, 2.0_dp]), 3.0_dp)
        call check(error, median_of([7.0_dp]), 7.0_dp)
        stream = new_stream(9, 0, 0, 0, 0)
        call stream%normals(values)
        median = median_of(values)
        call check(error, count(values < median) == 500 .and. count(values > median) == 500, 'not the middle')
    end subroutine test_median

    !> Increasing, and equals in the order of their places.
    subroutine test_order(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: stream
        real(dp) :: values(1001)
        integer :: order(1001)

        stream = new_stream(9, 0, 0, 0, 0)
        call stream%normals(values)
        values = anint(10*values)
        order = order_of(values)
        call check(error, all(values(order(2:)) > values(order(:1000)) .or. &
                              (.not. values(order(2:)) < values(order(:1000)) .and. order(2:) > order(:1000))), 'order')
        if (allocated(error)) return
        call check(error, size(order_of(values(:0))), 0)
    end subroutine test_order

    !> Tables of the chi-square distribution (Abramowitz and Stegun, Table 26.8).
    subroutine test_tail(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, chi_square_tail(3.84146_dp, 1), 0.05_dp, thr=1e-6_dp)
        call check(error, chi_square_tail(9.21034_dp, 2), 0.01_dp, thr=1e-7_dp)
        call check(error, chi_square_tail(16.2662_dp, 3), 0.001_dp, thr=1e-7_dp)
        call check(error, chi_square_tail(18.3070_dp, 10), 0.05_dp, thr=1e-6_dp)
        call check(error, chi_square_tail(124.342_dp, 100), 0.05_dp, thr=1e-6_dp)
        call check(error, chi_square_tail(0.0_dp, 7), 1.0_dp, thr=1e-15_dp)
    end subroutine test_tail
end module test_statistics
