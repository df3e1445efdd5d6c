!> Linear algebra: explicit interfaces to the LAPACK procedures that are used, and the few solvers built
!> on them. Nothing else in the project calls LAPACK.
!>
!> The matrices have some 20 rows. For these the unblocked procedures (dpotf2 and the like) are the right
!> ones: the blocked ones of a threaded library (OpenBLAS) wake its threads, which costs more than the
!> work and more again inside the threads of a Monte Carlo. Long sums of products go to dgemm piece by piece, each of at
!> most ALONE products, which OpenBLAS does on the thread that calls; dsyrk looks at the number of threads alone.
module gracecg_base_lapack
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, number_text
    implicit none
    private
    public :: symmetric_eigen, solve_normal_equations, grouped_normal_equations, normal_equations, sum_of_products, triangle_of
    public :: factor_bands, solve_bands

    interface
        pure subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
            import :: dp
            character(1), intent(in) :: transa, transb
            integer, intent(in) :: m, n, k, lda, ldb, ldc
            real(dp), intent(in) :: alpha, a(lda, *), b(ldb, *), beta
            real(dp), intent(inout) :: c(ldc, *)
        end subroutine dgemm

        pure subroutine dgeqr2(m, n, a, lda, tau, work, info)
            import :: dp
            integer, intent(in) :: m, n, lda
            real(dp), intent(inout) :: a(lda, *)
            real(dp), intent(out) :: tau(*), work(*)
            integer, intent(out) :: info
        end subroutine dgeqr2

        subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
            import :: dp
            character(1), intent(in) :: jobz, uplo
            integer, intent(in) :: n, lda, lwork
            real(dp), intent(inout) :: a(lda, *)
            real(dp), intent(out) :: w(*), work(*)
            integer, intent(out) :: info
        end subroutine dsyev

        subroutine dpotf2(uplo, n, a, lda, info)
            import :: dp
            character(1), intent(in) :: uplo
            integer, intent(in) :: n, lda
            real(dp), intent(inout) :: a(lda, *)
            integer, intent(out) :: info
        end subroutine dpotf2

        subroutine dtrti2(uplo, diag, n, a, lda, info)
            import :: dp
            character(1), intent(in) :: uplo, diag
            integer, intent(in) :: n, lda
            real(dp), intent(inout) :: a(lda, *)
            integer, intent(out) :: info
        end subroutine dtrti2

        subroutine dlauu2(uplo, n, a, lda, info)
            import :: dp
            character(1), intent(in) :: uplo
            integer, intent(in) :: n, lda
            real(dp), intent(inout) :: a(lda, *)
            integer, intent(out) :: info
        end subroutine dlauu2

        subroutine dpocon(uplo, n, a, lda, anorm, rcond, work, iwork, info)
            import :: dp
            character(1), intent(in) :: uplo
            integer, intent(in) :: n, lda
            real(dp), intent(in) :: a(lda, *), anorm
            real(dp), intent(out) :: rcond, work(*)
            integer, intent(out) :: iwork(*), info
        end subroutine dpocon

        pure subroutine dpbtrf(uplo, n, kd, ab, ldab, info)
            import :: dp
            character(1), intent(in) :: uplo
            integer, intent(in) :: n, kd, ldab
            real(dp), intent(inout) :: ab(ldab, *)
            integer, intent(out) :: info
        end subroutine dpbtrf

        pure subroutine dpbtrs(uplo, n, kd, nrhs, ab, ldab, b, ldb, info)
            import :: dp
            character(1), intent(in) :: uplo
            integer, intent(in) :: n, kd, nrhs, ldab, ldb
            real(dp), intent(in) :: ab(ldab, *)
            real(dp), intent(inout) :: b(ldb, *)
            integer, intent(out) :: info
        end subroutine dpbtrs
    end interface

    integer, parameter :: GROUP = 128           ! observations of a piece
    integer, parameter :: ALONE = 2**18         ! products of a matrix and a matrix (OpenBLAS 0.3: 65536 times 4)
    integer, parameter :: ALONE_BY_VECTOR = 2**13   ! of a matrix and a vector (2048 times 4)

contains

    !> Eigenvalues (ascending) and eigenvectors (columns) of a symmetric matrix.
    subroutine symmetric_eigen(a, values, vectors, error)
        real(dp), intent(in) :: a(:, :)         !! Symmetric, n x n; only its upper triangle is used
        real(dp), intent(out) :: values(:)      !! n
        real(dp), intent(out) :: vectors(:, :)  !! n x n, orthonormal columns
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: work(40*size(a, 1))
        integer :: n, info

        n = size(a, 1)
        vectors = a
        if (any(ieee_is_nan(a))) then
            call fail(error, 'eigenvalues asked of a matrix that contains NaN')
            return
        end if
        call dsyev('V', 'U', n, vectors, n, values, work, size(work), info)
        if (info /= 0) call fail(error, 'the symmetric eigenproblem did not converge')
    end subroutine symmetric_eigen

    !> C = A B^T: the sum of the products of columns. One order, on one thread.
    pure subroutine sum_of_products(m, n, count, a, b, c)
        integer, intent(in) :: m, n, count          !! Rows of A and of B, columns of both
        real(dp), intent(in) :: a(m, count), b(n, count)    !! A and B
        real(dp), intent(out) :: c(m, n)                    !! A B^T

        c = 0
        call add_products(m, n, count, a, b, c)
    end subroutine sum_of_products

    !> C + A B^T in place of C.
    pure subroutine add_products(m, n, count, a, b, c)
        integer, intent(in) :: m, n, count
        real(dp), intent(in) :: a(m, count), b(n, count)
        real(dp), intent(inout) :: c(m, n)

        integer :: columns, i, k

        if (m == 0) return
        columns = max(1, ALONE/GROUP/m)
        do k = 1, count, GROUP
            do i = 1, n, columns
                call dgemm('N', 'T', m, min(columns, n - i + 1), min(GROUP, count - k + 1), 1.0_dp, a(1, k), m, b(i, k), n, &
                           1.0_dp, c(1, i), m)
            end do
        end do
    end subroutine add_products

    !> The triangle R of A = Q R, Q with orthonormal columns, as its transpose: what rows of observations say in as few rows
    !> as there are columns. By Householder's reflections; elements of the diagonal may be negative. On one thread to n = 90.
    pure subroutine triangle_of(rows, triangle)
        real(dp), intent(in) :: rows(:, :)          !! A^T: (n, observations)
        real(dp), intent(out) :: triangle(:, :)     !! R^T: n x n

        real(dp), allocatable :: stack(:, :)        ! the triangle so far, below it observations
        real(dp), dimension(size(rows, 1)) :: factors, work
        integer :: n, most, many, first, i, info

        n = size(rows, 1)
        most = max(1, min(size(rows, 2), ALONE_BY_VECTOR/n - n))
        allocate (stack(n + most, n))
        stack(:n, :) = 0
        do first = 1, size(rows, 2), most
            many = min(most, size(rows, 2) - first + 1)
            do i = 1, n
                stack(n + 1:n + many, i) = rows(i, first:first + many - 1)
            end do
            call dgeqr2(n + many, n, stack, n + most, factors, work, info)
            do i = 1, n
                stack(i + 1:n, i) = 0
            end do
        end do
        triangle = transpose(stack(:n, :))
    end subroutine triangle_of

    !> Cholesky's factor of a positive definite matrix by bands: element i, i + k stands in row 1 + k of column i.
    pure subroutine factor_bands(bands)
        real(dp), intent(inout) :: bands(:, :)      !! (bands, n): the matrix; its factor

        integer :: info

        if (size(bands) > 0) call dpbtrf('L', size(bands, 2), size(bands, 1) - 1, bands, size(bands, 1), info)
    end subroutine factor_bands

    !> Solves equations with such a factor, in place.
    pure subroutine solve_bands(factor, sides)
        real(dp), intent(in) :: factor(:, :)        !! (bands, n)
        real(dp), intent(inout) :: sides(:, :)      !! (n, any)

        integer :: info

        if (size(factor) > 0) call dpbtrs('L', size(factor, 2), size(factor, 1) - 1, size(sides, 2), factor, size(factor, 1), &
                                          sides, size(sides, 1), info)
    end subroutine solve_bands

    !> Normal matrix A^T W A and right-hand side A^T W b of a weighted least-squares problem. The rows of A are the columns
    !> of `rows` (one observation a column, contiguous in memory).
    pure subroutine normal_equations(rows, observed, normal, rhs, weights)
        real(dp), contiguous, intent(in) :: rows(:, :)  !! n parameters x m observations
        real(dp), intent(in) :: observed(:)             !! m
        real(dp), contiguous, intent(out) :: normal(:, :)   !! n x n, both triangles
        real(dp), intent(out) :: rhs(:)                 !! n
        real(dp), intent(in), optional :: weights(:)    !! m; absent: rows and observed have been multiplied by their roots

        real(dp) :: weighted(size(rows, 1) + 1, GROUP), sums(size(rows, 1), size(rows, 1) + 1)
        integer :: n, k, i, many

        n = size(rows, 1)
        sums = 0
        do k = 0, size(rows, 2) - 1, GROUP
            many = min(GROUP, size(rows, 2) - k)
            do i = 1, many
                weighted(:n, i) = rows(:, k + i)
                weighted(n + 1, i) = observed(k + i)
                if (present(weights)) weighted(:, i) = weighted(:, i)*weights(k + i)
            end do
            call add_products(n, n + 1, many, rows(:, k + 1:k + many), weighted, sums)
        end do
        do k = 1, n
            normal(:k, k) = sums(:k, k)
            normal(k, :k - 1) = sums(:k - 1, k)
        end do
        rhs = sums(:, n + 1)
    end subroutine normal_equations

    !> The same of observations in groups, each of which depends on the same few parameters: the products of the others, all
    !> of them zero, are left out.
    pure subroutine grouped_normal_equations(groups, rows, observed, normal, rhs)
        integer, intent(in) :: groups(:, :)
        !! First observation, last, and step of each group: (3, groups). Together every observation once
        real(dp), intent(in) :: rows(:, :)              !! n parameters x m observations, multiplied by the roots of their weights
        real(dp), intent(in) :: observed(:)             !! m
        real(dp), contiguous, intent(out) :: normal(:, :)   !! n x n, both triangles
        real(dp), intent(out) :: rhs(:)                 !! n

        real(dp), allocatable :: part_rows(:, :), part(:, :), part_rhs(:)
        integer, allocatable :: used(:)
        real(dp) :: sums(size(rows, 1))
        integer :: g, i, k

        normal = 0
        rhs = 0
        do g = 1, size(groups, 2)
            associate (first => groups(1, g), last => groups(2, g), step => groups(3, g))
                sums = 0
                do i = first, last, step
                    sums = sums + abs(rows(:, i))
                end do
                used = pack([(k, k=1, size(sums))], .not. sums <= 0)    ! NaN, too
                allocate (part_rows(size(used), (last - first + step)/step), part(size(used), size(used)), part_rhs(size(used)))
                do i = first, last, step
                    part_rows(:, 1 + (i - first)/step) = rows(used, i)
                end do
                call normal_equations(part_rows, observed(first:last:step), part, part_rhs)
                do k = 1, size(used)
                    normal(used, used(k)) = normal(used, used(k)) + part(:, k)
                end do
                rhs(used) = rhs(used) + part_rhs
                deallocate (part_rows, part, part_rhs)
            end associate
        end do
    end subroutine grouped_normal_equations

    !> Solves the normal equations N x = b by Cholesky's factorisation, after scaling N to a unit
    !> diagonal so that the units of the parameters do not matter.
    !>
    !> Fails when N is singular to working precision; the message gives the direction, in terms of
    !> the scaled parameters, that the observations do not determine.
    subroutine solve_normal_equations(normal, rhs, solution, covariance, condition, error, names)
        real(dp), intent(in) :: normal(:, :)        !! N, n x n, symmetric
        real(dp), intent(in) :: rhs(:)              !! b, n
        real(dp), intent(out) :: solution(:)        !! x, n
        real(dp), intent(out) :: covariance(:, :)   !! N^-1, n x n
        real(dp), intent(out) :: condition          !! Condition number of the scaled N, 1-norm
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: names(:)  !! Of the parameters, for messages

        real(dp) :: scaled(size(rhs), size(rhs)), factor(size(rhs), size(rhs)), scale(size(rhs))
        real(dp) :: reciprocal, work(3*size(rhs))
        integer :: n, i, info, iwork(size(rhs))

        n = size(rhs)
        solution = 0
        covariance = 0
        condition = huge(1.0_dp)
        if (.not. all(abs(normal) <= huge(1.0_dp)) .or. .not. all(abs(rhs) <= huge(1.0_dp))) then
            call fail(error, 'the normal equations contain NaN or infinity')
            return
        end if
        scale = 1
        do i = 1, n
            if (normal(i, i) > 0) scale(i) = 1/sqrt(normal(i, i))
        end do
        do i = 1, n
            scaled(:, i) = scale*normal(:, i)*scale(i)
        end do
        factor = scaled
        call dpotf2('U', n, factor, n, info)
        if (info == 0) then
            call dpocon('U', n, factor, n, maxval(sum(abs(scaled), 1)), reciprocal, work, iwork, &
                        info)
            condition = 1/max(reciprocal, tiny(1.0_dp))
        else
            reciprocal = 0
        end if
        if (reciprocal < n*epsilon(1.0_dp)) then
            call report_singular(scaled, error, names)
            return
        end if
        call dtrti2('U', 'N', n, factor, n, info)       ! U^-1
        call dlauu2('U', n, factor, n, info)            ! U^-1 U^-T
        do i = 1, n
            covariance(1:i, i) = scale(1:i)*factor(1:i, i)*scale(i)
            covariance(i, 1:i) = covariance(1:i, i)
        end do
        solution = matmul(covariance, rhs)
    end subroutine solve_normal_equations

    !> The message for a singular normal matrix.
    subroutine report_singular(scaled, error, names)
        real(dp), intent(in) :: scaled(:, :)
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: names(:)

        real(dp) :: values(size(scaled, 1)), vectors(size(scaled, 1), size(scaled, 1))
        character(:), allocatable :: direction
        type(error_t), allocatable :: eigen_error
        integer :: i

        call symmetric_eigen(scaled, values, vectors, eigen_error)
        direction = ''
        if (.not. allocated(eigen_error) .and. present(names)) then
            do i = 1, size(names)
                if (abs(vectors(i, 1)) < 0.1_dp) cycle
                direction = direction//' '//trim(names(i))//' ('//number_text(vectors(i, 1))//')'
            end do
            direction = '; not determined by the observations:'//direction
        end if
        call fail(error, 'the normal matrix is singular'//direction)
    end subroutine report_singular
end module gracecg_base_lapack
