!> The linear solvers on LAPACK.
module test_lapack
    use vocabulary
    use gracecg_base_lapack, only: symmetric_eigen, normal_equations, grouped_normal_equations, solve_normal_equations, &
        sum_of_products, triangle_of
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
                    new_unittest('sums-of-products-of-any-size', test_products), &
                    new_unittest('sums-do-not-depend-on-threads', test_threads), &
                    new_unittest('triangle-of-rows', test_triangle), &
                    new_unittest('singular-and-nan-are-refused', test_singular)]
    end subroutine collect_lapack

    subroutine test_eigen(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure
        real(dp), parameter :: A(3, 3) = reshape([ &
            2.0_dp, -1.0_dp, 0.0_dp, -1.0_dp, 2.0_dp, -1.0_dp, 0.0_dp, -1.0_dp, 2.0_dp], [3, 3])
        real(dp), parameter :: EIGENVALUES(3) = [2 - sqrt(2.0_dp), 2.0_dp, 2 + sqrt(2.0_dp)]
        real(dp) :: values(3), vectors(3, 3)

        call symmetric_eigen(A, values, vectors, failure)
        call check_passes(error, failure)
        call check(error, maxval(abs(values - EIGENVALUES)) < 1e-14_dp)
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
        call check_passes(error, failure)
        call check(error, maxval(abs(x/TRUTH - 1)) < 1e-13_dp)
        scale = [(1/sqrt(normal(i, i)), i=1, 3)]
        call check(error, maxval(abs(matmul(normal*spread(scale, 2, 3), &
                                            covariance/spread(scale, 1, 3)) - identity(3))) &
                   < 1e-12_dp)
        call check(error, condition < 10, 'units must not spoil the condition')
    end subroutine test_solve

    !> The sums over groups, some of which do not depend on a parameter, are those over all; a NaN shows.
    subroutine test_groups(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: GROUPS(3, 3) = reshape([1, 5, 2, 2, 4, 2, 6, 6, 1], [3, 3])
        real(dp) :: rows_of(3, 6), normal(3, 3), rhs(3), expected(3, 3), expected_rhs(3)

        rows_of = ROWS
        rows_of(2, 1:5:2) = 0
        rows_of([1, 3], 6) = 0
        call normal_equations(rows_of, ROWS(1, :), expected, expected_rhs)
        call grouped_normal_equations(GROUPS, rows_of, ROWS(1, :), normal, rhs)
        call check(error, all(abs(normal - expected) <= 1e-14_dp*abs(expected)) .and. &
                   all(abs(rhs - expected_rhs) <= 1e-14_dp*abs(expected_rhs)))
        rows_of(2, 3) = NAN
        call grouped_normal_equations(GROUPS, rows_of, ROWS(1, :), normal, rhs)
        call check(error, .not. all(abs(normal) <= huge(1.0_dp)), 'NaN')
    end subroutine test_groups

    !> Numbers between -1 and 1 that follow no rule which sums would know of.
    pure function numbers(m, n) result(values)
        integer, intent(in) :: m, n
        real(dp) :: values(m, n)

        integer :: i, j

        do j = 1, n
            do i = 1, m
                values(i, j) = modulo(0.618033988749895_dp*(i + 17*j)**2, 2.0_dp) - 1
            end do
        end do
    end function numbers

    !> Against a double loop, of sizes below and above that of a piece; the normal equations with weights.
    subroutine test_products(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: SIZES(5) = [0, 1, 7, 45, 150], COUNTS(4) = [0, 1, 128, 300]
        real(dp), allocatable :: a(:, :), b(:, :), c(:, :), normal(:, :), rhs(:), weights(:)
        integer :: i, j, k

        do i = 1, size(SIZES)
            do j = 1, size(COUNTS)
                associate (m => SIZES(i), n => SIZES(size(SIZES) + 1 - i), count => COUNTS(j))
                    a = numbers(m, count)
                    b = numbers(n, count)
                    weights = [(1 + modulo(0.3_dp*k, 1.0_dp), k=1, count)]
                    allocate (c(m, n), normal(m, m), rhs(m))
                    call sum_of_products(m, n, count, a, b, c)
                    call check(error, agree(c, a, b, [(1.0_dp, k=1, count)]), 'products')
                    call normal_equations(a, [(sin(1.0_dp*k), k=1, count)], normal, rhs, weights)
                    call check(error, agree(normal, a, a, weights) .and. all(abs(normal - transpose(normal)) <= 0), 'normal')
                    call check(error, agree(spread(rhs, 2, 1), a, reshape([(sin(1.0_dp*k), k=1, count)], [1, count]), weights), &
                               'right-hand side')
                    deallocate (c, normal, rhs)
                end associate
            end do
        end do

    contains

        !> Every element within the rounding of its sum.
        logical function agree(found, one, other, weights)
            real(dp), intent(in) :: found(:, :), one(:, :), other(:, :), weights(:)
            integer :: p, q

            agree = .true.
            do q = 1, size(other, 1)
                do p = 1, size(one, 1)
                    agree = agree .and. abs(found(p, q) - sum(one(p, :)*other(q, :)*weights)) <= &
                            1e-14_dp*sum(abs(one(p, :)*other(q, :)*weights))
                end do
            end do
        end function agree
    end subroutine test_products

    !> Of so many observations that BLAS, given all of them, would take several threads: the same bits within threads as alone.
    subroutine test_threads(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 60, M = 2000, TIMES = 8
        real(dp) :: rows_of(N, M), normal(N, N, 0:TIMES), rhs(N, 0:TIMES), triangle(N, N, 0:TIMES)
        integer :: i

        rows_of = numbers(N, M)
        call normal_equations(rows_of, rows_of(1, :), normal(:, :, 0), rhs(:, 0))
        call triangle_of(rows_of, triangle(:, :, 0))
        !$omp parallel do num_threads(2) schedule(dynamic)
        do i = 1, TIMES
            call normal_equations(rows_of, rows_of(1, :), normal(:, :, i), rhs(:, i))
            call triangle_of(rows_of, triangle(:, :, i))
        end do
        !$omp end parallel do
        do i = 1, TIMES
            call check(error, all(abs(normal(:, :, i) - normal(:, :, 0)) <= 0) .and. all(abs(rhs(:, i) - rhs(:, 0)) <= 0) .and. &
                       all(abs(triangle(:, :, i) - triangle(:, :, 0)) <= 0))
        end do
    end subroutine test_threads

    !> It is triangular, and its Gram matrix is that of the rows: the reflections are orthogonal. Of fewer rows than columns
    !> and of none, too; zeros stay; a NaN shows.
    subroutine test_triangle(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 12, COUNTS(5) = [0, 1, 5, 12, 2000]
        real(dp) :: triangle(N, N)
        real(dp), allocatable :: rows_of(:, :)
        integer :: i, j

        do i = 1, size(COUNTS)
            rows_of = numbers(N, COUNTS(i))
            rows_of(3, :) = 0
            call triangle_of(rows_of, triangle)
            do j = 2, N
                call check(error, all(abs(triangle(:j - 1, j)) <= 0), 'above the diagonal')
            end do
            call check(error, maxval(abs(matmul(triangle, transpose(triangle)) - matmul(rows_of, transpose(rows_of)))) <= &
                       1e-14_dp*max(1, COUNTS(i)), 'products')
            call check(error, all(abs(triangle(3, :)) <= 0), 'zeros')
        end do
        rows_of(4, 1000) = NAN
        call triangle_of(rows_of, triangle)
        call check(error, .not. abs(triangle(N, N)) <= huge(1.0_dp), 'NaN')
    end subroutine test_triangle

    subroutine test_singular(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure
        real(dp) :: rows_without(3, 6), normal(3, 3), rhs(3), x(3), covariance(3, 3), condition

        rows_without = ROWS
        rows_without(2, :) = 0
        call normal_equations(rows_without, ROWS(1, :), normal, rhs)
        call solve_normal_equations(normal, rhs, x, covariance, condition, failure, &
                                    [character(2) :: 'dx', 'dy', 'dz'])
        call check(error, index(message_of(failure), 'dx'), 0, message_of(failure))
        call check_fails(error, failure, 'dy')
        normal = identity(3)
        normal(1, 2) = NAN
        rhs = 1
        call solve_normal_equations(normal, rhs, x, covariance, condition, failure)
        call check(error, allocated(failure))
    end subroutine test_singular
end module test_lapack
