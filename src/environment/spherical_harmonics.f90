!> Sums of solid spherical harmonics and of their derivatives, in Cartesian coordinates: fast, and
!> without a singular place anywhere outside the centre.
!>
!> An exterior harmonic function is U = sum_nm (R/r)^(n+1) Pbar_nm(sin lat) [C cos m lon + S sin m lon].
!> The inversion q = 2 R (x, y, z)/r^2 turns it, but for a factor R/r, into a polynomial:
!>
!>     U = (|q|/2) Phi,   Phi = sum_nm Re(f_nm h_(n-m)(q) (q_x + i q_y)^m),
!>     h_0 = 1,  h_1 = q_z,  h_(k+1) = q_z h_k - beta q^2 h_(k-1),   beta = k (k + 2m)/(4 (m + k)^2 - 1)
!>
!> The h are the derived Legendre functions of S. Pines (AIAA J. 11 (1973) 1508-1511), scaled so
!> that their first coefficient is one and multiplied by powers of 2R/r; the recursion with rising
!> degree at fixed order is the stable one (J. B. Lundberg and B. E. Schutz, J. Guidance 11 (1988)
!> 31-38). The scale is taken into the coefficients when a function is built.
!>
!> Derivatives need sums of one kind more, and no other recursion. At fixed q^2 the derivative of h_k of order m by
!> q_z is k h_(k-1) of order m + 1, which the recursion of that order has anyway: d = (Phi_x, Phi_y, Phi_z) at
!> fixed q^2 takes sums over order m of the coefficients f_nm and (n - m + 1) f_n,m-1. What is missing, the
!> derivative by q^2, follows from Euler's theorem for the terms of degree n; for that the sums are also taken
!> with a factor n or n^2, which an index N or NN tells. With u = q/|q|
!>
!>     grad U = (|q|/4R) [q^2 d - (Phi + Phi_N + q.d) q]
!>     grad grad U = (|q| q^2/8R^2) {q^2 dd - (q v^T + v q^T) - (Phi + Phi_N + q.d) 1
!>                   + [3 Phi + 4 Phi_N + Phi_NN + 5 q.d + 2 q.d_N + q.(dd q)] u u^T},
!>     v = 2 d + d_N + dd q
!>
!> with the matrix dd of the second derivatives of Phi at fixed q^2. That the trace is 0 is Laplace's equation, and not put in.
!> The sums themselves stand in harmonic_sums.c.
module gracecg_environment_spherical_harmonics
    use, intrinsic :: iso_c_binding, only: c_double, c_int32_t
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: MAX_DEGREE, harmonic_function_t, new_harmonic_function, gradients_of_two

    ! The last three as in harmonic_sums.c
    integer, parameter :: MAX_DEGREE = 360  !! Highest degree of a function
    integer, parameter :: LANES = 8         !! Orders that lie side by side in memory, for vector instructions
    integer, parameter :: PLACES = 8        !! Places worked on together
    integer, parameter :: FIRST_SUMS = 5, ALL_SUMS = 14
    !! Sums for first derivatives: Phi, Phi_N, d; for second ones also Phi_NN, d_N, dd (xx, xy, xz, yz, zz)

    type :: harmonic_function_t
        !! An exterior harmonic function
        private
        real(dp) :: radius = 1                          !! R, m
        integer(c_int32_t) :: blocks = 0, orders = 0    !! Blocks of LANES orders; orders with a sum
        integer(c_int32_t) :: widest = LANES            !! Most numbers of a vector; fewer where the processor has no such
        integer(c_int32_t), allocatable :: first(:)     !! Steps before each block, and all steps
        real(c_double), allocatable :: steps(:, :, :)
        !! One step of the recursion for LANES orders m, shape (LANES, 0:6, steps): beta; of degree n = m + k,
        !! cos and sin: f_nm, (k + 1) f_n,m-1, (k + 1) (k + 2) f_n,m-2
    contains
        procedure :: limit_vectors  !! To less wide vectors than the processor has
        procedure :: is_finite      !! Whether all coefficients are numbers
        procedure :: value          !! At a place
        procedure :: gradient       !! At a place
        procedure :: derivatives    !! Value, gradient and second derivatives at a place
        procedure :: gradients      !! Values and gradients at many places
    end type harmonic_function_t

    interface
        !> The first FIRST_SUMS sums at a place.
        pure subroutine harmonic_sums_first(widest, blocks, orders, first, steps, q, sums) &
            bind(c, name='gracecg_harmonic_sums_first')
            import :: c_double, c_int32_t, FIRST_SUMS, LANES
            integer(c_int32_t), intent(in), value :: widest, blocks, orders
            integer(c_int32_t), intent(in) :: first(*)
            real(c_double), intent(in) :: steps(LANES, 0:6, *), q(3)
            real(c_double), intent(out) :: sums(FIRST_SUMS)
        end subroutine harmonic_sums_first

        !> The first FIRST_SUMS sums of two functions at a place, with the same bits; the other has no more degrees and orders.
        pure subroutine harmonic_sums_two(widest, blocks, orders, first, steps, other_blocks, other_orders, other_first, &
                                          other_steps, q, sums) bind(c, name='gracecg_harmonic_sums_two')
            import :: c_double, c_int32_t, FIRST_SUMS, LANES
            integer(c_int32_t), intent(in), value :: widest, blocks, orders, other_blocks, other_orders
            integer(c_int32_t), intent(in) :: first(*), other_first(*)
            real(c_double), intent(in) :: steps(LANES, 0:6, *), other_steps(LANES, 0:6, *), q(3)
            real(c_double), intent(out) :: sums(FIRST_SUMS, 2)
        end subroutine harmonic_sums_two

        !> All sums at a place; the first ones with the same bits.
        pure subroutine harmonic_sums_second(widest, blocks, orders, first, steps, q, sums) &
            bind(c, name='gracecg_harmonic_sums_second')
            import :: c_double, c_int32_t, ALL_SUMS, LANES
            integer(c_int32_t), intent(in), value :: widest, blocks, orders
            integer(c_int32_t), intent(in) :: first(*)
            real(c_double), intent(in) :: steps(LANES, 0:6, *), q(3)
            real(c_double), intent(out) :: sums(ALL_SUMS)
        end subroutine harmonic_sums_second

        !> The first FIRST_SUMS sums at PLACES places, with the same bits.
        pure subroutine harmonic_sums_places(widest, orders, first, steps, q, sums) bind(c, name='gracecg_harmonic_sums_places')
            import :: c_double, c_int32_t, FIRST_SUMS, LANES, PLACES
            integer(c_int32_t), intent(in), value :: widest, orders
            integer(c_int32_t), intent(in) :: first(*)
            real(c_double), intent(in) :: steps(LANES, 0:6, *), q(PLACES, 3)
            real(c_double), intent(out) :: sums(PLACES, FIRST_SUMS)
        end subroutine harmonic_sums_places
    end interface

contains

    !> A function of given fully normalised coefficients, n = 0..degree, m = 0..order. They are multiplied by the
    !> first coefficient of Pbar_nm, as a polynomial in sin lat times cos^m lat, over 2^n:
    !>
    !>     sqrt((2 - delta_0m)(2n + 1)(n - m)!/(n + m)!) (2n - 1)!!/((n - m)! 2^n)
    pure function new_harmonic_function(radius, scale, c, s) result(harmonic)
        real(dp), intent(in) :: radius      !! R, m
        real(dp), intent(in) :: scale       !! Factor of all coefficients
        real(dp), intent(in) :: c(0:, 0:)   !! Of cos m lon; (n, m), n >= m used; shape (0:degree, 0:order)
        real(dp), intent(in) :: s(0:, 0:)   !! Of sin m lon; those of m = 0 are not used
        type(harmonic_function_t) :: harmonic

        real(dp) :: sectorial, factor
        integer :: degree, order, m, k, n, block, lane, place

        degree = ubound(c, 1)
        order = min(ubound(c, 2), degree)
        harmonic%radius = radius
        harmonic%orders = min(order + 2, degree) + 1
        harmonic%blocks = (harmonic%orders - 1)/LANES + 1
        allocate (harmonic%first(0:harmonic%blocks))
        harmonic%first(0) = 0
        do block = 0, harmonic%blocks - 1
            harmonic%first(block + 1) = harmonic%first(block) + degree + 1 - LANES*block
        end do
        allocate (harmonic%steps(LANES, 0:6, harmonic%first(harmonic%blocks)), source=0.0_dp)
        do m = 0, harmonic%orders - 1
            do k = 0, degree - m
                harmonic%steps(modulo(m, LANES) + 1, 0, step_of(m, k)) = k*(k + 2*m)/(4.0_dp*(m + k)**2 - 1)
            end do
        end do

        sectorial = scale
        do m = 0, order
            if (m == 1) sectorial = sectorial*sqrt(3.0_dp)/2
            if (m > 1) sectorial = sectorial*sqrt((2*m + 1)/(2.0_dp*m))/2
            factor = sectorial
            do n = m, degree
                if (n > m) factor = factor*sqrt((4.0_dp*n**2 - 1)/((n - m)*(n + m)))/2
                do lane = m, min(m + 2, n)  ! the order whose recursion has it
                    k = n - lane
                    place = step_of(lane, k)    ! gfortran 16 takes no internal function within a selector
                    associate (step => harmonic%steps(modulo(lane, LANES) + 1, :, place))
                        select case (lane - m)
                        case (0)
                            step(2:3) = factor*[c(n, m), s(n, m)]
                        case (1)
                            step(4:5) = (k + 1)*factor*[c(n, m), s(n, m)]
                        case (2)
                            step(6:7) = (k + 1)*(k + 2)*factor*[c(n, m), s(n, m)]
                        end select
                        if (m == 0) step(2*(lane - m) + 3) = 0
                    end associate
                end do
            end do
        end do

    contains

        !> The place in `steps` of h_k of an order.
        pure integer function step_of(order, k)
            integer, intent(in) :: order, k

            step_of = harmonic%first(order/LANES) + k + 1
        end function step_of
    end function new_harmonic_function

    !> Lets the sums do without wide vectors, which gives the same bits.
    pure subroutine limit_vectors(self, widest)
        class(harmonic_function_t), intent(inout) :: self
        integer, intent(in) :: widest   !! 2, 4 or 8 numbers

        self%widest = widest
    end subroutine limit_vectors

    !> Whether all coefficients are finite numbers, as they were given and times what stands before them.
    pure logical function is_finite(self)
        class(harmonic_function_t), intent(in) :: self

        is_finite = all(ieee_is_finite(self%steps))
    end function is_finite

    !> The value at a place other than the centre.
    pure subroutine value(self, position, u)
        class(harmonic_function_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! m
        real(dp), intent(out) :: u              !! In the unit of `scale` of new_harmonic_function

        real(dp) :: q(3), sums(FIRST_SUMS)

        q = inverted(self, position)
        call harmonic_sums_first(self%widest, self%blocks, self%orders, self%first, self%steps, q, sums)
        u = value_of(q, sums)
    end subroutine value

    !> The gradient at a place other than the centre.
    pure subroutine gradient(self, position, g)
        class(harmonic_function_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! m
        real(dp), intent(out) :: g(3)           !! 1/m

        real(dp) :: q(3), sums(FIRST_SUMS)

        q = inverted(self, position)
        call harmonic_sums_first(self%widest, self%blocks, self%orders, self%first, self%steps, q, sums)
        g = gradient_of(self%radius, q, sums)
    end subroutine gradient

    !> The gradients of two functions at a place other than the centre, with the bits of `gradient`. Where both have one
    !> radius, and the other no more degrees and orders, one recursion serves both.
    pure subroutine gradients_of_two(one, other, position, g, g_other)
        type(harmonic_function_t), intent(in) :: one, other
        real(dp), intent(in) :: position(3)             !! m
        real(dp), intent(out) :: g(3), g_other(3)       !! 1/m

        real(dp) :: q(3), sums(FIRST_SUMS, 2)

        if (abs(one%radius - other%radius) > 0 .or. other%first(1) > one%first(1) .or. other%orders > one%orders) then
            call one%gradient(position, g)
            call other%gradient(position, g_other)
            return
        end if
        q = inverted(one, position)
        call harmonic_sums_two(one%widest, one%blocks, one%orders, one%first, one%steps, other%blocks, other%orders, &
                               other%first, other%steps, q, sums)
        g = gradient_of(one%radius, q, sums(:, 1))
        g_other = gradient_of(one%radius, q, sums(:, 2))
    end subroutine gradients_of_two

    !> Value, gradient and second derivatives at a place other than the centre, by one recursion. Value and gradient
    !> have the bits of `value` and `gradient`.
    pure subroutine derivatives(self, position, u, g, tensor)
        class(harmonic_function_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! m
        real(dp), intent(out) :: u              !! In the unit of `scale` of new_harmonic_function
        real(dp), intent(out) :: g(3)           !! 1/m
        real(dp), intent(out) :: tensor(3, 3)   !! 1/m^2

        real(dp) :: q(3), sums(ALL_SUMS)

        q = inverted(self, position)
        call harmonic_sums_second(self%widest, self%blocks, self%orders, self%first, self%steps, q, sums)
        u = value_of(q, sums)
        g = gradient_of(self%radius, q, sums)
        tensor = second_derivatives_of(self%radius, q, sums)
    end subroutine derivatives

    !> Values and gradients at many places other than the centre, PLACES of them together: half the time for each, and
    !> the bits of `value` and `gradient`.
    pure subroutine gradients(self, positions, g, u)
        class(harmonic_function_t), intent(in) :: self
        real(dp), intent(in) :: positions(:, :)     !! m, shape (3, n)
        real(dp), intent(out) :: g(:, :)            !! 1/m, shape (3, n)
        real(dp), intent(out), optional :: u(:)     !! Values, n

        real(dp) :: q(PLACES, 3), sums(PLACES, FIRST_SUMS), q_here(3), sums_here(FIRST_SUMS)
        integer :: i, p, before

        do before = 0, size(positions, 2) - 1, PLACES
            do p = 1, PLACES    ! behind the last place, that again
                q(p, :) = inverted(self, positions(:, min(before + p, size(positions, 2))))
            end do
            call harmonic_sums_places(self%widest, self%orders, self%first, self%steps, q, sums)
            do p = 1, min(PLACES, size(positions, 2) - before)
                i = before + p
                q_here = q(p, :)
                sums_here = sums(p, :)
                g(:, i) = gradient_of(self%radius, q_here, sums_here)
                if (present(u)) u(i) = value_of(q_here, sums_here)
            end do
        end do
    end subroutine gradients

    !> q = 2 R (x, y, z)/r^2.
    pure function inverted(self, position) result(q)
        class(harmonic_function_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! m
        real(dp) :: q(3)

        q = position*(2*self%radius/dot_product(position, position))
    end function inverted

    pure real(dp) function value_of(q, sums)
        real(dp), intent(in) :: q(3), sums(FIRST_SUMS)

        value_of = norm_of(q)/2*sums(1)
    end function value_of

    pure function gradient_of(radius, q, sums) result(g)
        real(dp), intent(in) :: radius              !! R, m
        real(dp), intent(in) :: q(3), sums(FIRST_SUMS)
        real(dp) :: g(3)                            !! 1/m

        associate (phi => sums(1), phi_n => sums(2), d => sums(3:5))
            g = norm_of(q)/(4*radius)*(dot_product(q, q)*d - (phi + phi_n + dot_product(q, d))*q)
        end associate
    end function gradient_of

    pure function second_derivatives_of(radius, q, sums) result(tensor)
        real(dp), intent(in) :: radius          !! R, m
        real(dp), intent(in) :: q(3), sums(ALL_SUMS)
        real(dp) :: tensor(3, 3)                !! 1/m^2

        real(dp) :: dd(3, 3), dd_q(3), v(3), u(3), q_squared, diagonal, along_u
        integer :: i, j

        q_squared = dot_product(q, q)
        u = q/max(norm_of(q), tiny(q))   ! 0 where q is, beyond 1e160 m
        dd = reshape(sums([10, 11, 12, 11, 10, 13, 12, 13, 14]), [3, 3])
        dd(2, 2) = -dd(1, 1)
        dd_q = dd(:, 1)*q(1) + dd(:, 2)*q(2) + dd(:, 3)*q(3)
        associate (phi => sums(1), phi_n => sums(2), d => sums(3:5), phi_nn => sums(6), d_n => sums(7:9))
            v = 2*d + d_n + dd_q
            diagonal = phi + phi_n + dot_product(q, d)
            along_u = 3*phi + 4*phi_n + phi_nn + 5*dot_product(q, d) + 2*dot_product(q, d_n) + dot_product(q, dd_q)
        end associate
        do j = 1, 3
            do i = 1, j
                tensor(i, j) = q_squared*dd(i, j) - (q(i)*v(j) + v(i)*q(j)) + along_u*u(i)*u(j)
                if (i == j) tensor(i, j) = tensor(i, j) - diagonal
                tensor(i, j) = norm_of(q)*q_squared/(8*radius**2)*tensor(i, j)
                tensor(j, i) = tensor(i, j)
            end do
        end do
    end function second_derivatives_of

    pure real(dp) function norm_of(q)
        real(dp), intent(in) :: q(3)

        norm_of = sqrt(dot_product(q, q))
    end function norm_of
end module gracecg_environment_spherical_harmonics
