!> Attitude from star directions: QUEST (M. D. Shuster, S. D. Oh, J. Guidance and Control 4 (1981)
!> 70-77; CSR-TM-00-01 section 3.3.4).
!>
!> Sought is the rotation A that takes reference directions V(i) into observed ones W(i) with the
!> least loss 1/2 sum a(i) |W(i) - A V(i)|^2, weights of sum 1 (G. Wahba, SIAM Review 7 (1965) 409).
!> Its quaternion is the eigenvector of the largest eigenvalue of a 4x4 matrix K (P. Davenport).
!> `quest` finds that eigenvalue by Newton's method on the characteristic polynomial; `q_method`
!> solves the whole eigenproblem and is the reference.
!> In both, rounding leaves an error of about 1e-16 over the square of the stars' spread (rad) in q:
!> 1e-14 for a field of 24 deg, 1e-12 for one of 2 deg.
!>
!> The weights stand in (3-16), (3-17) and (3-21), where the report leaves them out.
module gracecg_simulation_quest
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_base_vectors, only: identity, determinant_3x3, inverse_3x3
    use gracecg_base_quaternion, only: normalised
    implicit none
    private
    public :: quest, q_method

    integer, parameter :: MAX_ITERATIONS = 50
    real(dp), parameter :: SMALLEST_SPREAD = 1e-4_dp
    !! Root-mean-square distance of the stars from one line of sight below which they count as
    !! collinear, rad (20 arcsec)
    real(dp), parameter :: SMALLEST_SEPARATION = 1e-12_dp
    !! Of the largest eigenvalue; stars with SMALLEST_SPREAD have 1e-8, rounding makes some 1e-16

contains

    !> The optimal attitude by QUEST: (3-11) with the least loss (3-12), from (3-14).
    !> Fails for fewer than two stars, collinear stars, standard deviations that are not positive, and
    !> anything not finite.
    subroutine quest(observed, reference, deviation, q, covariance, loss, error)
        real(dp), intent(in) :: observed(:, :)  !! W: unit vectors, camera frame; (3, stars)
        real(dp), intent(in) :: reference(:, :) !! V: unit vectors, reference frame; (3, stars)
        real(dp), intent(in) :: deviation(:)
        !! Standard deviation of a direction along each of two axes across it, observation and
        !! reference together, rad; (stars)
        real(dp), intent(out) :: q(4)           !! Reference to camera frame, scalar last, q(4) >= 0
        real(dp), intent(out) :: covariance(3, 3)
        !! Of the vector part of the small rotation from the true to the optimal attitude, which is
        !! half the rotation's angles, camera frame, rad^2: CSR-TM-00-01 eq. (3-21)
        real(dp), intent(out) :: loss           !! Wahba's loss (3-12) = 1 - largest eigenvalue
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: k(4, 4), separation

        q = 0
        loss = 0
        call set_up(observed, reference, deviation, k, covariance, error)
        if (allocated(error)) return
        call find_eigenvector(k, largest_eigenvalue(k), q, separation)
        ! The Rayleigh quotient of this q is free of the polynomial's cancellation.
        call find_eigenvector(k, dot_product(q, matmul(k, q)), q, separation)
        call finish(q, dot_product(q, matmul(k, q)), separation, loss, error)
    end subroutine quest

    !> The optimal attitude by Davenport's q-method, (3-14) with a general eigenvalue solver. Arguments and
    !> failures as for `quest`.
    subroutine q_method(observed, reference, deviation, q, covariance, loss, error)
        real(dp), intent(in) :: observed(:, :), reference(:, :), deviation(:)   !! As for `quest`
        real(dp), intent(out) :: q(4), covariance(3, 3), loss                   !! As for `quest`
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: k(4, 4), values(4), vectors(4, 4)

        q = 0
        loss = 0
        call set_up(observed, reference, deviation, k, covariance, error)
        if (allocated(error)) return
        call symmetric_eigen(k, values, vectors, error)
        if (allocated(error)) return
        q = vectors(:, 4)
        call finish(q, values(4), values(4) - values(3), loss, error)
    end subroutine q_method

    !> Davenport's matrix K, CSR-TM-00-01 eqs. (3-15)-(3-18), with weights of sum 1 (3-13), and the covariance
    !> (3-21), (3-22), which is defined by (3-19), (3-20).
    subroutine set_up(observed, reference, deviation, k, covariance, error)
        real(dp), intent(in) :: observed(:, :), reference(:, :), deviation(:)
        real(dp), intent(out) :: k(4, 4), covariance(3, 3)
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: weight, total_variance, b(3, 3), observed_spread(3, 3), reference_spread(3, 3)
        integer :: i, n

        k = 0
        covariance = 0
        n = size(observed, 2)
        if (n < 2) then
            call fail(error, 'an attitude needs the directions of at least two stars')
            return
        else if (size(reference, 2) /= n .or. size(deviation) /= n) then
            call fail(error, 'observed directions, reference directions and standard '// &
                      'deviations must be equal in number')
            return
        else if (.not. all(deviation > 0)) then
            call fail(error, 'the standard deviation of a star direction must be positive')
            return
        end if

        total_variance = 1/sum(1/deviation**2)
        b = 0
        observed_spread = identity(3)
        reference_spread = identity(3)
        do i = 1, n
            weight = total_variance/deviation(i)**2
            call add_outer_product(weight, observed(:, i), reference(:, i), b)
            call add_outer_product(-weight, observed(:, i), observed(:, i), observed_spread)
            call add_outer_product(-weight, reference(:, i), reference(:, i), reference_spread)
        end do
        ! Not by `min`: what it makes of NaN is the compiler's choice
        if (.not. (determinant_3x3(observed_spread) > SMALLEST_SPREAD**2 .and. &
                   determinant_3x3(reference_spread) > SMALLEST_SPREAD**2)) then
            call fail(error, 'no attitude from these stars: their directions are collinear '// &
                      '(within 20 arcsec) or not finite')
            return
        end if

        covariance = total_variance/4*inverse_3x3(observed_spread)
        k(1:3, 1:3) = b + transpose(b)
        k(4, 4) = b(1, 1) + b(2, 2) + b(3, 3)
        do i = 1, 3
            k(i, i) = k(i, i) - k(4, 4)
        end do
        k(1:3, 4) = [b(2, 3) - b(3, 2), b(3, 1) - b(1, 3), b(1, 2) - b(2, 1)]
        k(4, 1:3) = k(1:3, 4)
    end subroutine set_up

    !> m + weight u v^T.
    pure subroutine add_outer_product(weight, u, v, m)
        real(dp), intent(in) :: weight, u(3), v(3)
        real(dp), intent(inout) :: m(3, 3)

        m(:, 1) = m(:, 1) + weight*v(1)*u
        m(:, 2) = m(:, 2) + weight*v(2)*u
        m(:, 3) = m(:, 3) + weight*v(3)*u
    end subroutine add_outer_product

    !> The largest eigenvalue of K by Newton's method on its characteristic polynomial, Shuster and
    !> Oh eqs. (70), (71), from 1: no eigenvalue is greater, and right of the greatest the
    !> polynomial is convex, so the iteration falls onto it. It ends when it no longer falls.
    pure real(dp) function largest_eigenvalue(k) result(x)
        real(dp), intent(in) :: k(4, 4)

        real(dp) :: s(3, 3), z(3), sigma, kappa, a, b, c, d, slope, step
        integer :: iteration

        sigma = k(4, 4)
        z = k(1:3, 4)
        s = k(1:3, 1:3) + sigma*identity(3)
        kappa = s(2, 2)*s(3, 3) - s(2, 3)**2 + s(1, 1)*s(3, 3) - s(1, 3)**2 &
            + s(1, 1)*s(2, 2) - s(1, 2)**2
        a = sigma**2 - kappa
        b = sigma**2 + dot_product(z, z)
        c = determinant_3x3(s) + dot_product(z, matmul(s, z))
        d = sum(matmul(s, z)**2)
        x = 1
        do iteration = 1, MAX_ITERATIONS
            slope = 4*x**3 - 2*(a + b)*x - c
            if (.not. slope > 0) exit
            step = (x**4 - (a + b)*x**2 - c*x + a*b + c*sigma - d)/slope
            if (.not. step > epsilon(x)) exit
            x = x - step
        end do
    end function largest_eigenvalue

    !> The eigenvector of K for a simple eigenvalue x: column j of the adjugate of K - x I is q q(j)
    !> times the product of the differences of x from the other eigenvalues. The fourth column is
    !> Shuster's Gibbs-vector form, singular at turns of 180 deg; the others are what it becomes
    !> after a first turn of 180 deg about an axis. The one with the greatest diagonal element is
    !> always well determined.
    pure subroutine find_eigenvector(k, x, q, separation)
        real(dp), intent(in) :: k(4, 4)
        real(dp), intent(in) :: x
        real(dp), intent(out) :: q(4)
        real(dp), intent(out) :: separation !! That element: about 0 when x is a multiple eigenvalue

        real(dp) :: m(4, 4), upper(6), lower(6), diagonal(4)

        m = k - x*identity(4)
        upper = row_pair_minors(m(:, 1), m(:, 2))
        lower = row_pair_minors(m(:, 3), m(:, 4))
        diagonal(1) = m(2, 2)*lower(6) - m(2, 3)*lower(5) + m(2, 4)*lower(4)
        diagonal(2) = m(1, 1)*lower(6) - m(1, 3)*lower(3) + m(1, 4)*lower(2)
        diagonal(3) = m(1, 4)*upper(5) - m(2, 4)*upper(3) + m(4, 4)*upper(1)
        diagonal(4) = m(1, 3)*upper(4) - m(2, 3)*upper(2) + m(3, 3)*upper(1)
        select case (maxloc(abs(diagonal), 1))
        case (1)
            q = [diagonal(1), &
                 -m(1, 2)*lower(6) + m(2, 3)*lower(3) - m(2, 4)*lower(2), &
                 m(1, 2)*lower(5) - m(2, 2)*lower(3) + m(2, 4)*lower(1), &
                 -m(1, 2)*lower(4) + m(2, 2)*lower(2) - m(2, 3)*lower(1)]
        case (2)
            q = [-m(1, 2)*lower(6) + m(1, 3)*lower(5) - m(1, 4)*lower(4), &
                 diagonal(2), &
                 -m(1, 1)*lower(5) + m(1, 2)*lower(3) - m(1, 4)*lower(1), &
                 m(1, 1)*lower(4) - m(1, 2)*lower(2) + m(1, 3)*lower(1)]
        case (3)
            q = [m(2, 4)*upper(6) - m(3, 4)*upper(5) + m(4, 4)*upper(4), &
                 -m(1, 4)*upper(6) + m(3, 4)*upper(3) - m(4, 4)*upper(2), &
                 diagonal(3), &
                 -m(1, 3)*upper(5) + m(2, 3)*upper(3) - m(3, 4)*upper(1)]
        case default
            q = [-m(2, 3)*upper(6) + m(3, 3)*upper(5) - m(3, 4)*upper(4), &
                 m(1, 3)*upper(6) - m(3, 3)*upper(3) + m(3, 4)*upper(2), &
                 -m(1, 3)*upper(5) + m(2, 3)*upper(3) - m(3, 4)*upper(1), &
                 diagonal(4)]
        end select
        q = normalised(q)
        separation = maxval(abs(diagonal))
    end subroutine find_eigenvector

    !> The six 2x2 determinants of two rows, columns (1,2), (1,3), (1,4), (2,3), (2,4), (3,4).
    pure function row_pair_minors(u, v) result(minors)
        real(dp), intent(in) :: u(4), v(4)
        real(dp) :: minors(6)

        minors = [u(1)*v(2) - u(2)*v(1), u(1)*v(3) - u(3)*v(1), u(1)*v(4) - u(4)*v(1), &
                  u(2)*v(3) - u(3)*v(2), u(2)*v(4) - u(4)*v(2), u(3)*v(4) - u(4)*v(3)]
    end function row_pair_minors

    !> Settles the sign of q and the loss. Fails when K has no single largest eigenvalue.
    subroutine finish(q, eigenvalue, separation, loss, error)
        real(dp), intent(inout) :: q(4)
        real(dp), intent(in) :: eigenvalue
        real(dp), intent(in) :: separation  !! Of the largest eigenvalue from the others
        real(dp), intent(out) :: loss
        type(error_t), allocatable, intent(out) :: error

        loss = max(0.0_dp, 1 - eigenvalue)
        if (.not. separation > SMALLEST_SEPARATION) then
            call fail(error, 'no attitude from these stars: observed and reference directions '// &
                      'contradict each other, several attitudes fit them equally well')
        else if (q(4) < 0) then
            q = -q
        end if
    end subroutine finish
end module gracecg_simulation_quest
