!> Constants estimated from observations that come one after the other: the triangular array
!>
!>     [ R_y | z_y ],    whose solution is the estimate and whose inverse squared is the covariance.
!>
!> What enters is folded in by orthogonal transformations, and no covariance or normal matrix is formed, so that rounding
!> errors do not grow with the square of the ratio of the largest to the smallest standard deviation (G. J. Bierman,
!> Factorization Methods for Discrete Sequential Estimation (1977), chapters V-VII). Observations have unit noise:
!> whitened ones where their noise is coloured (gracecg_estimation_noise_whitening).
!>
!> Constants that move by a known linear law (attitude errors) are estimated as what they were at
!> the epoch: Bierman's "pseudo-epoch state".
module gracecg_estimation_square_root_information
    use gracecg_base_kinds, only: dp
    use gracecg_base_lapack, only: triangle_of
    use gracecg_estimation_noise_whitening, only: nonzero_rows
    implicit none
    private
    public :: constants_t, new_constants

    !> The array [R_y | z_y] of the constants.
    type :: constants_t
        integer :: n = 0                            !! Number of constants
        real(dp), allocatable :: array(:, :)        !! (n + 1, n): column i is row i of [R_y | z_y]
        real(dp) :: squares = 0                     !! Sum of the squared residuals so far
    contains
        procedure :: fold_in
        !! Folds an observation of the constants in, by Givens' rotations: row = [g, r], unit noise
        procedure :: fold_in_all
        !! The same with many observations that see the same constants
        procedure :: solution    !! The estimate R_y^-1 z_y
        procedure :: last_covariance
        !! Estimate and covariance of the last few constants: only their corner of R_y is needed, so they
        !! cost little at every epoch
        procedure :: inverse_root    !! R_y^-1: times its transpose the covariance
        procedure :: log_determinant => constants_log_determinant    !! ln det(R_y^T R_y)
    end type constants_t

contains

    !> Constants of which nothing is known.
    pure function new_constants(n) result(constants)
        integer, intent(in) :: n    !! Their number
        type(constants_t) :: constants

        constants%n = n
        allocate (constants%array(n + 1, n), source=0.0_dp)
    end function new_constants

    !> Folds an observation of the constants in, by Givens' rotations: row = [g, r], unit noise.
    pure subroutine fold_in(self, row)
        class(constants_t), intent(inout) :: self
        real(dp), intent(in) :: row(:)          !! (n + 1)

        real(dp) :: left(self%n + 1)            ! of the row, by and by

        left = row
        call fold_row(self%n, self%n + 1, self%array, left)
        self%squares = self%squares + left(self%n + 1)**2
    end subroutine fold_in

    !> The same with many observations: what they see of the constants (the columns that are not zero) is brought
    !> into a triangle of its own first, by Householder's reflections, and its few rows then are folded in. Where they see
    !> half of the constants, a row costs a quarter.
    pure subroutine fold_in_all(self, rows)
        class(constants_t), intent(inout) :: self
        real(dp), intent(in) :: rows(:, :)      !! (n + 1, observations)

        real(dp), allocatable :: own(:, :)      ! columns are rows
        real(dp) :: row(self%n + 1)
        integer, allocatable :: places(:)
        integer :: i, last

        places = [nonzero_rows(rows(:self%n, :)), self%n + 1]
        last = size(places)
        allocate (own(last, last))
        call triangle_of(rows(places, :), own)
        do i = 1, last - 1
            row = 0
            row(places(i:)) = own(i:, i)
            call self%fold_in(row)
        end do
        self%squares = self%squares + own(last, last)**2
    end subroutine fold_in_all

    !> The estimate R_y^-1 z_y. The constants must be determined.
    pure function solution(self) result(y)
        class(constants_t), intent(in) :: self
        real(dp) :: y(self%n)

        integer :: i

        do i = self%n, 1, -1
            y(i) = (self%array(self%n + 1, i) - dot_product(self%array(i + 1:self%n, i), y(i + 1:)))/ &
                   self%array(i, i)
        end do
    end function solution

    !> Estimate and covariance of the last few constants: only their corner of R_y is needed, so they
    !> cost little at every epoch. They must be determined.
    pure subroutine last_covariance(self, estimate, covariance)
        class(constants_t), intent(in) :: self
        real(dp), intent(out) :: estimate(:)        !! (k): of the last k constants
        real(dp), intent(out) :: covariance(:, :)   !! k x k

        type(constants_t) :: last
        real(dp) :: root(size(estimate), size(estimate))

        last%n = size(estimate)
        associate (first => self%n - last%n + 1)
            last%array = self%array(first:, first:)
        end associate
        estimate = last%solution()
        root = last%inverse_root()
        covariance = matmul(root, transpose(root))
    end subroutine last_covariance

    !> R_y^-1: times its transpose the covariance.
    pure function inverse_root(self) result(inverse)
        class(constants_t), intent(in) :: self
        real(dp) :: inverse(self%n, self%n)

        integer :: i, j

        inverse = 0
        do j = 1, self%n
            inverse(j, j) = 1/self%array(j, j)
            do i = j - 1, 1, -1
                inverse(i, j) = -dot_product(self%array(i + 1:j, i), inverse(i + 1:j, j))/self%array(i, i)
            end do
        end do
    end function inverse_root

    !> ln det(R_y^T R_y).
    pure real(dp) function constants_log_determinant(self) result(value)
        class(constants_t), intent(in) :: self

        integer :: i

        value = 0
        do i = 1, self%n
            value = value + 2*log(abs(self%array(i, i)))
        end do
    end function constants_log_determinant

    !> Folds a row into triangular rows by Givens' rotations; what is left of it stays in its other columns. The
    !> columns of `array` are its rows.
    pure subroutine fold_row(n, columns, array, row)
        integer, intent(in) :: n, columns
        real(dp), intent(inout) :: array(columns, n), row(columns)

        real(dp) :: radius, c, s, kept
        integer :: i, j

        do i = 1, n
            if (.not. abs(row(i)) > 0) cycle
            radius = sqrt(array(i, i)**2 + row(i)**2)
            c = array(i, i)/radius
            s = row(i)/radius
            do j = i, columns
                kept = array(j, i)
                array(j, i) = c*kept + s*row(j)
                row(j) = c*row(j) - s*kept
            end do
        end do
    end subroutine fold_row
end module gracecg_estimation_square_root_information
