!> The median.
module test_statistics
    use gracecg_base_kinds, only: dp
    use gracecg_base_statistics, only: median_of
    use gracecg_base_random, only: random_stream_t, new_stream
    use fixture, only: check
    use testdrive, only: new_unittest, unittest_type, error_type
    implicit none
    private
    public :: collect_statistics

contains

    subroutine collect_statistics(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('few-numbers', test_few), &
                    new_unittest('halves-many-numbers', test_many)]
    end subroutine collect_statistics

    subroutine test_few(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, median_of([5.0_dp, -1.0_dp, 3.0_dp]), 3.0_dp)
        call check(error, median_of([4.0_dp, 1.0_dp, 1e9_dp, 2.0_dp]), 3.0_dp)
        call check(error, median_of([7.0_dp]), 7.0_dp)
    end subroutine test_few

    !> As many lie below it as above it.
    subroutine test_many(error)
        type(error_type), allocatable, intent(out) :: error

        type(random_stream_t) :: stream
        real(dp) :: values(1001), median

        stream = new_stream(9, 0, 0, 0, 0)
        call stream%normals(values)
        median = median_of(values)
        call check(error, count(values < median) == 500 .and. count(values > median) == 500, 'not the middle')
    end subroutine test_many
end module test_statistics
