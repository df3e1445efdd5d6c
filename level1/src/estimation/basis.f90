!> Orthonormal bases of samples: a band of frequencies, and what is not wanted in it.
module gracecg_level1_basis
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    implicit none
    private
    public :: orthonormalise, remove_space, band_basis, polynomial_basis, polynomial_columns, polynomial_curvature

    real(dp), parameter :: DEPENDENT = 1e-9_dp      !! A column of which less is left is one of the others

contains

    !> Makes columns orthonormal (Gram-Schmidt, twice); those that depend on the others are dropped. What belongs to each
    !> column elsewhere is combined alike.
    pure subroutine orthonormalise(columns, elsewhere)
        real(dp), allocatable, intent(inout) :: columns(:, :)               !! Sample, column
        real(dp), allocatable, intent(inout), optional :: elsewhere(:, :)   !! Anything, column

        real(dp), allocatable :: joined(:, :)
        real(dp) :: length, left
        integer :: i, k, n, m, round, kept

        n = size(columns, 1)
        m = 0
        if (present(elsewhere)) m = size(elsewhere, 1)
        allocate (joined(n + m, size(columns, 2)))
        joined(:n, :) = columns
        if (present(elsewhere)) joined(n + 1:, :) = elsewhere
        kept = 0
        do i = 1, size(joined, 2)
            length = norm2(joined(:n, i))
            if (.not. length > 0) cycle
            joined(:, i) = joined(:, i)/length
            do round = 1, 2
                do k = 1, kept
                    joined(:, i) = joined(:, i) - dot_product(joined(:n, k), joined(:n, i))*joined(:, k)
                end do
            end do
            left = norm2(joined(:n, i))
            if (left < DEPENDENT) cycle
            kept = kept + 1
            joined(:, kept) = joined(:, i)/left
        end do
        columns = joined(:n, :kept)
        if (present(elsewhere)) elsewhere = joined(n + 1:, :kept)
    end subroutine orthonormalise

    !> What of a column is outside of the space of an orthonormal basis.
    pure subroutine remove_space(basis, column)
        real(dp), intent(in) :: basis(:, :)     !! Sample, column
        real(dp), intent(inout) :: column(:)    !! Of as many samples

        integer :: k

        do k = 1, size(basis, 2)
            column = column - dot_product(basis(:, k), column)*basis(:, k)
        end do
    end subroutine remove_space

    !> An orthonormal basis of cos, sin(2 pi k t/T) with low <= k/T <= high, at the samples that there are.
    pure subroutine band_basis(times, low, high, basis)
        real(dp), intent(in) :: times(:)            !! s
        real(dp), intent(in) :: low, high           !! Hz
        real(dp), allocatable, intent(out) :: basis(:, :)   !! Sample, column

        real(dp) :: length
        integer :: first, last, k

        length = (times(size(times)) - times(1))*size(times)/max(1, size(times) - 1)
        first = max(1, ceiling(low*length))
        last = min(floor(high*length), (size(times) - 1)/2)
        allocate (basis(size(times), 2*max(0, last - first + 1)))
        do k = first, last
            basis(:, 2*(k - first) + 1) = cos(TWO_PI*k*(times - times(1))/length)
            basis(:, 2*(k - first) + 2) = sin(TWO_PI*k*(times - times(1))/length)
        end do
        call orthonormalise(basis)
    end subroutine band_basis

    !> An orthonormal basis of the polynomials.
    pure subroutine polynomial_basis(times, degree, basis)
        real(dp), intent(in) :: times(:)            !! Rising, s; at least two
        integer, intent(in) :: degree               !! The highest
        real(dp), allocatable, intent(out) :: basis(:, :)   !! Sample, column

        allocate (basis(size(times), degree + 1))
        call polynomial_columns(times, degree, basis)
        call orthonormalise(basis)
    end subroutine polynomial_basis

    !> 1, u, u^2, ... with u from -1 to 1 over the samples (as Legendre polynomials, not normalised).
    pure subroutine polynomial_columns(times, degree, columns)
        real(dp), intent(in) :: times(:)            !! Rising, s; at least two
        integer, intent(in) :: degree    !! The highest
        real(dp), intent(out) :: columns(:, :)      !! Sample, degree + 1

        real(dp) :: u(size(times))
        integer :: k

        u = 2*(times - times(1))/(times(size(times)) - times(1)) - 1
        columns(:, 1) = 1
        if (degree > 0) columns(:, 2) = u
        do k = 2, degree
            columns(:, k + 1) = ((2*k - 1)*u*columns(:, k) - (k - 1)*columns(:, k - 1))/k
        end do
    end subroutine polynomial_columns

    !> The second derivatives by time of what `polynomial_columns` makes, at other times:
    !> P''_(k+1) = P''_(k-1) + (2 k + 1) P'_k, and so P' from P.
    pure subroutine polynomial_curvature(times, wanted, degree, columns)
        real(dp), intent(in) :: times(:)            !! Of the columns, s
        real(dp), intent(in) :: wanted(:)           !! s
        integer, intent(in) :: degree               !! The highest
        real(dp), intent(out) :: columns(:, :)      !! Wanted time, degree + 1; 1/s^2

        real(dp), dimension(size(wanted), -1:degree) :: value, first, second
        real(dp) :: u(size(wanted)), per_second
        integer :: k

        per_second = 2/(times(size(times)) - times(1))
        u = per_second*(wanted - times(1)) - 1
        value(:, -1) = 0
        value(:, 0) = 1
        first(:, -1:0) = 0
        second(:, -1:0) = 0
        do k = 0, degree - 1
            value(:, k + 1) = ((2*k + 1)*u*value(:, k) - k*value(:, k - 1))/(k + 1)
            first(:, k + 1) = first(:, k - 1) + (2*k + 1)*value(:, k)
            second(:, k + 1) = second(:, k - 1) + (2*k + 1)*first(:, k)
        end do
        columns = per_second**2*second(:, 0:)
    end subroutine polynomial_curvature
end module gracecg_level1_basis
