!> The least variance with which the CG offset can be estimated, and what is added to it by parameters
!> that are known only within limits.
!>
!> With N_xx the Fisher information of the estimated parameters x, the covariance of any unbiased
!> estimate is at least N_xx^-1 (C. R. Rao, Bull. Calcutta Math. Soc. 37 (1945) 81-91; H. Cramer,
!> Mathematical Methods of Statistics (1946) section 32.3). An estimate that leaves parameters c of
!> a-priori covariance C at their nominal values has the consider covariance (S. F. Schmidt, Advances in
!> Control Systems 3 (1966) 293-340; B. D. Tapley, B. E. Schutz, G. H. Born, Statistical Orbit
!> Determination (2004) section 6.5)
!>
!>     N_xx^-1 + S C S^T,   S = -N_xx^-1 N_xc.
module gracecg_planning_offset_bound
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_vectors, only: inverse_3x3, determinant_3x3
    use gracecg_estimation_diagnostics, only: ellipsoid_t, error_ellipsoid
    implicit none
    private
    public :: offset_bound_t, bound_offset, principal_axes, invert_information

    !> Bound and consider covariance of the CG offset.
    type :: offset_bound_t
        real(dp) :: covariance(3, 3) = 0        !! Of d at best, m^2
        real(dp) :: sigma(3) = 0                !! Of its components, m
        real(dp) :: principal_sigma(3) = 0      !! Semi-axes of the error ellipsoid, ascending, m
        real(dp) :: direction(3, 3) = 0
        !! Their directions as columns, body axes, largest component positive; the last is the worst
        real(dp), allocatable :: considered(:, :)
        !! Error of d by one sigma of each considered parameter, (3, parameters), m
        real(dp) :: consider_sigma(3) = 0       !! Of d with all of them, m
    end type offset_bound_t

contains

    !> Bound and consider covariance. The estimated parameters stand first in the information matrix.
    !>
    !> Fails when the observations do not determine the parameters.
    subroutine bound_offset(information, names, offset, consider_sigma, bound, error)
        real(dp), intent(in) :: information(:, :)   !! Of estimated and considered parameters
        character(*), intent(in) :: names(:)        !! Of the estimated ones
        integer, intent(in) :: offset(3)            !! Places of d
        real(dp), intent(in) :: consider_sigma(:)   !! A priori, of the considered ones
        type(offset_bound_t), intent(out) :: bound
        type(error_t), allocatable, intent(out) :: error

        real(dp), dimension(size(names), size(names)) :: covariance
        real(dp), dimension(size(names)) :: zero, unused
        real(dp) :: condition
        integer :: n, i

        n = size(names)
        zero = 0
        call solve_normal_equations(information(:n, :n), zero, unused, covariance, condition, error, names)
        if (allocated(error)) return
        bound%covariance = covariance(offset, offset)
        bound%sigma = [(sqrt(bound%covariance(i, i)), i=1, 3)]
        call principal_axes(bound%covariance, bound%principal_sigma, bound%direction, error)
        if (allocated(error)) return
        allocate (bound%considered(3, size(consider_sigma)))
        do i = 1, size(consider_sigma)
            bound%considered(:, i) = -matmul(covariance(offset, :), information(:n, n + i))*consider_sigma(i)
        end do
        bound%consider_sigma = sqrt(bound%sigma**2 + sum(bound%considered**2, 2))
    end subroutine bound_offset

    !> The error ellipsoid of a covariance; its last axis is the longest.
    subroutine principal_axes(covariance, sigma, direction, error)
        real(dp), intent(in) :: covariance(3, 3)        !! m^2
        real(dp), intent(out) :: sigma(3)               !! Semi-axes, ascending, m
        real(dp), intent(out) :: direction(3, 3)        !! Unit vectors as columns, largest component positive
        type(error_t), allocatable, intent(out) :: error

        type(ellipsoid_t) :: ellipsoid

        call error_ellipsoid(covariance, ellipsoid, error)
        sigma = ellipsoid%semi_axis(3:1:-1)
        direction = ellipsoid%direction(:, 3:1:-1)
    end subroutine principal_axes

    !> Covariance and standard deviations of an information about d; huge(1.0) for both where a direction is unseen.
    pure subroutine invert_information(information, covariance, sigma)
        real(dp), intent(in) :: information(3, 3)       !! 1/m^2
        real(dp), intent(out) :: covariance(3, 3)       !! m^2
        real(dp), intent(out) :: sigma(3)               !! m

        real(dp), parameter :: SINGULAR = 1e-12_dp      ! of the determinant with unit diagonal
        real(dp) :: product_of_diagonal
        integer :: i

        covariance = huge(1.0_dp)
        sigma = huge(1.0_dp)
        product_of_diagonal = information(1, 1)*information(2, 2)*information(3, 3)
        if (.not. determinant_3x3(information) > SINGULAR*product_of_diagonal) return
        covariance = inverse_3x3(information)
        sigma = [(sqrt(covariance(i, i)), i=1, 3)]
    end subroutine invert_information
end module gracecg_planning_offset_bound
