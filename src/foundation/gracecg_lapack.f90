!> Interfaces to LAPACK.
module gracecg_lapack
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t, fail
    implicit none
    private
    public :: symmetric_eigen

    interface
        subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
            import :: dp
            character, intent(in) :: jobz, uplo
            integer, intent(in) :: n, lda, lwork
            real(dp), intent(inout) :: a(lda, *)
            real(dp), intent(out) :: w(*), work(*)
            integer, intent(out) :: info
        end subroutine dsyev
    end interface

contains

    !> Eigenvalues and orthonormal eigenvectors of a symmetric matrix.
    subroutine symmetric_eigen(a, values, vectors, error)
        real(dp), intent(in) :: a(:, :)         !! Symmetric; the lower triangle is used
        real(dp), intent(out) :: values(:)      !! Ascending
        real(dp), intent(out) :: vectors(:, :)  !! In columns
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: work(34*size(a, 1))
        integer :: n, info

        n = size(a, 1)
        vectors = a
        call dsyev('V', 'L', n, vectors, n, values, work, size(work), info)
        if (info /= 0) call fail(error, 'the eigenvalues of a symmetric matrix did not converge')
    end subroutine symmetric_eigen
end module gracecg_lapack
