!> The linear solvers on LAPACK.
module test_lapack
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, message_of
    use gracecg_base_lapack, only: symmetric_eigen, normal_equations, grouped_normal_equations, solve_normal_equations
    use gracecg_base_vectors, only: identity
    use fixture, only: check_fails, check_passes
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_lapack

    !> Six observations (columns) of three parameters of very different size.
    real(dp), parameter :: ROWS(3, 6) = reshape([ &
        1.0_dp, 2e6_dp, 0.1e-6_dp, 2.0_dp, -1e6_dp, 0.3e-6_dp, -1.0_dp, 3e6_dp, 0.7e-6_dp, &
        0.5_dp, 1e6_dp, -0.9e-6_dp, 1.5_dp, 0e6_dp, 0.2e-6_dp, -0.3_dp, 1e6_dp, 0.5e-6_dp], [3, 6])

contains

    subroutine collect_lapack(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('eigenproblem', test_eigen), &
                    new_unittest('normal-equations-of-known-answer', test_solve), &
                    new_unittest('groups-of-observations', test_groups), &
                    new_unittest('singular-direction-is-named', test_singular), &
                    new_unittest('nan-is-refused', test_nan)]
    end subroutine collect_lapack

    subroutine test_eigen(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure
        real(dp), parameter :: A(3, 3) = reshape([ &
            2.0_dp, -1.0_dp, 0.0_dp, -1.0_dp, 2.0_dp, -1.0_dp, 0.0_dp, -1.0_dp, 2.0_dp], [3, 3])
        real(dp), parameter :: EIGENVALUES(3) = [2 - sqrt(2.0_dp), 2.0_dp, 2 + sqrt(2.0_dp)]
        real(dp) :: values(3), vectors(3, 3)

        call symmetric_eigen(A, values, vectors, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, maxval(abs(values - EIGENVALUES)) < 1e-14_dp)
        if (allocated(error)) return
        call check(error, maxval(abs(matmul(transpose(vectors), vectors) - identity(3))) < 1e-14_dp)
    end subroutine test_eigen

    subroutine test_solve(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure
        real(dp), parameter :: TRUTH(3) = [0.7_dp, -2e-6_dp, 3e6_dp]
        real(dp) :: normal(3, 3), rhs(3), x(3), covariance(3, 3), condition, scale(3)
        integer :: i

        call normal_equations(ROWS, matmul(TRUTH, ROWS), normal, rhs)
        call solve_normal_equations(normal, rhs, x, covariance, condition, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, maxval(abs(x/TRUTH - 1)) < 1e-13_dp)
        if (allocated(error)) return
        scale = [(1/sqrt(normal(i, i)), i=1, 3)]
        call check(error, maxval(abs(matmul(normal*spread(scale, 2, 3), &
                                            covariance/spread(scale, 1, 3)) - identity(3))) &
                   < 1e-12_dp)
        if (allocated(error)) return
        call check(error, condition < 10, 'units must not spoil the condition')
    end subroutine test_solve

    !> The sums over groups, some of which do not depend on a parameter, are those over all; with weights, and a NaN shows.
    subroutine test_groups(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: GROUPS(3, 3) = reshape([1, 5, 2, 2, 4, 2, 6, 6, 1], [3, 3])
        real(dp) :: rows_of(3, 6), weights(6), normal(3, 3), rhs(3), expected(3, 3), expected_rhs(3)
        integer :: i

        rows_of = ROWS
        rows_of(2, 1:5:2) = 0
        rows_of([1, 3], 6) = 0
        weights = [(0.5_dp*i, i=1, 6)]
        call normal_equations(rows_of, ROWS(1, :), expected, expected_rhs, weights)
        call grouped_normal_equations(GROUPS, rows_of, ROWS(1, :), normal, rhs, weights)
        call check(error, all(abs(normal - expected) <= 1e-14_dp*abs(expected)) .and. &
                   all(abs(rhs - expected_rhs) <= 1e-14_dp*abs(expected_rhs)))
        if (allocated(error)) return
        rows_of(2, 3) = ieee_value(1.0_dp, ieee_quiet_nan)
        call grouped_normal_equations(GROUPS, rows_of, ROWS(1, :), normal, rhs)
        call check(error, .not. all(abs(normal) <= huge(1.0_dp)), 'NaN')
    end subroutine test_groups

    subroutine test_singular(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure
        real(dp) :: rows_without(3, 6), normal(3, 3), rhs(3), x(3), covariance(3, 3), condition

        rows_without = ROWS
        rows_without(2, :) = 0
        call normal_equations(rows_without, ROWS(1, :), normal, rhs)
        call solve_normal_equations(normal, rhs, x, covariance, condition, failure, &
                                    [character(2) :: 'dx', 'dy', 'dz'])
        call check_fails(error, message_of(failure), ['dy'])
        if (allocated(error)) return
        call check(error, index(failure%message, 'dx'), 0, failure%message)
    end subroutine test_singular

    subroutine test_nan(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure
        real(dp) :: normal(3, 3), rhs(3), x(3), covariance(3, 3), condition

        normal = identity(3)
        normal(1, 2) = ieee_value(1.0_dp, ieee_quiet_nan)
        rhs = 1
        call solve_normal_equations(normal, rhs, x, covariance, condition, failure)
        call check(error, allocated(failure))
    end subroutine test_nan
end module test_lapack
