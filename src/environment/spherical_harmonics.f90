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
module gracecg_environment_spherical_harmonics
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite, ieee_value, ieee_quiet_nan
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: MAX_DEGREE, harmonic_function_t, new_harmonic_function

    integer, parameter :: MAX_DEGREE = 360  !! Highest degree of a function
    integer, parameter :: LANES = 8         !! Orders that lie side by side in memory, for vector instructions
    integer, parameter :: PLACES = 8        !! Places worked on together
    integer, parameter :: FIRST_SUMS = 5, ALL_SUMS = 14
    !! Sums for first derivatives: Phi, Phi_N, d; for second ones also Phi_NN, d_N, dd (xx, xy, xz, yz, zz)

    type :: harmonic_function_t
        !! An exterior harmonic function
        private
        real(dp) :: radius = 1                          !! R, m
        integer :: blocks = 0, orders = 0       !! Blocks of LANES orders; orders with a sum
        integer, allocatable :: first(:)        !! Steps before each block, and all steps
        real(dp), allocatable :: steps(:, :, :)
        !! One step k of the recursion for LANES orders m, shape (LANES, 0:6, steps): beta of k + 1; of degree n = m + k,
        !! cos and sin: f_nm, (k + 1) f_n,m-1, (k + 1) (k + 2) f_n,m-2
    contains
        procedure :: is_finite      !! Whether all coefficients are numbers
        procedure :: value          !! At a place
        procedure :: gradient       !! At a place
        procedure :: derivatives    !! Value, gradient and second derivatives at a place
        procedure :: gradients      !! Values and gradients at many places
    end type harmonic_function_t

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
                harmonic%steps(modulo(m, LANES) + 1, 0, step_of(m, k)) = (k + 1)*(k + 1 + 2*m)/(4.0_dp*(m + k + 1)**2 - 1)
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
        call sums_at(self, q, FIRST_SUMS, sums)
        u = value_of(q, sums)
    end subroutine value

    !> The gradient at a place other than the centre.
    pure subroutine gradient(self, position, g)
        class(harmonic_function_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! m
        real(dp), intent(out) :: g(3)           !! 1/m

        real(dp) :: q(3), sums(FIRST_SUMS)

        q = inverted(self, position)
        call sums_at(self, q, FIRST_SUMS, sums)
        g = gradient_of(self%radius, q, sums)
    end subroutine gradient

    !> Value, gradient and second derivatives at a place other than the centre, by one recursion. Value and gradient
    !> are those of `value` and `gradient` but for rounding.
    pure subroutine derivatives(self, position, u, g, tensor)
        class(harmonic_function_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! m
        real(dp), intent(out) :: u              !! In the unit of `scale` of new_harmonic_function
        real(dp), intent(out) :: g(3)           !! 1/m
        real(dp), intent(out) :: tensor(3, 3)   !! 1/m^2

        real(dp) :: q(3), sums(ALL_SUMS)

        q = inverted(self, position)
        call sums_at(self, q, ALL_SUMS, sums)
        u = value_of(q, sums)
        g = gradient_of(self%radius, q, sums)
        tensor = second_derivatives_of(self%radius, q, sums)
    end subroutine derivatives

    !> Values and gradients at many places other than the centre, PLACES of them together: less time for each. They are
    !> those of `value` and `gradient` but for rounding, and do not depend on the other places.
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
            call sums_at_places(self, q, sums)
            do p = 1, min(PLACES, size(positions, 2) - before)
                i = before + p
                q_here = q(p, :)
                sums_here = sums(p, :)
                g(:, i) = gradient_of(self%radius, q_here, sums_here)
                if (present(u)) u(i) = value_of(q_here, sums_here)
            end do
        end do
    end subroutine gradients

    !> The first sums at a place, FIRST_SUMS or ALL_SUMS of them.
    pure subroutine sums_at(harmonic, q, count, sums)
        class(harmonic_function_t), intent(in) :: harmonic
        real(dp), intent(in) :: q(3)
        integer, intent(in), value :: count
        real(dp), intent(out) :: sums(count)

        real(dp), dimension(-2:MAX_DEGREE + LANES) :: re, im    ! of (q_x + i q_y)^m; 0 before m = 0
        real(dp) :: parts(LANES, ALL_SUMS)
        integer :: block, m, i

        re(-2:1) = [0.0_dp, 0.0_dp, 1.0_dp, q(1)]
        im(-2:1) = [0.0_dp, 0.0_dp, 0.0_dp, q(2)]
        do m = 2, LANES
            i = m/2
            re(m) = re(i)*re(m - i) - im(i)*im(m - i)
            im(m) = re(i)*im(m - i) + im(i)*re(m - i)
        end do
        do block = 1, harmonic%blocks - 1
            do m = LANES*block + 1, LANES*block + LANES
                re(m) = re(m - LANES)*re(LANES) - im(m - LANES)*im(LANES)
                im(m) = re(m - LANES)*im(LANES) + im(m - LANES)*re(LANES)
            end do
        end do
        parts(:, :count) = 0
        do block = 0, harmonic%blocks - 1
            m = LANES*block
            call add_orders(count, real(m, dp), harmonic%first(block + 1) - harmonic%first(block), &
                            harmonic%steps(1, 0, harmonic%first(block) + 1), q(3), -dot_product(q, q), &
                            re(m - 2), im(m - 2), parts)
        end do
        do i = 1, count
            sums(i) = ((parts(1, i) + parts(5, i)) + (parts(3, i) + parts(7, i))) + &
                      ((parts(2, i) + parts(6, i)) + (parts(4, i) + parts(8, i)))
        end do
    end subroutine sums_at

    !> Adds LANES orders, side by side, to the sums of each lane.
    !>
    !> gfortran compiles this for each `count`, and makes the loop over orders, which stands around that over degrees, one of
    !> vectors as wide as its flags allow. For that the orders of a block have as many degrees (coefficients behind an order's
    !> last one are 0), all numbers are of one kind, and there is at least one degree. A term of f is a number of its own, and
    !> not read twice: reading is what takes longest with 8 numbers a vector. Unrolled, the loop over degrees runs out of
    !> registers of 2 numbers, and the recursion waits for memory.
    pure subroutine add_orders(count, first_order, degrees, steps, q_z, minus_q_squared, power_re, power_im, parts)
        integer, intent(in), value :: count                         !! FIRST_SUMS or ALL_SUMS
        real(dp), intent(in) :: first_order
        integer, intent(in) :: degrees                              !! Of the first order
        real(dp), intent(in) :: steps(LANES, 0:6, degrees)
        real(dp), intent(in) :: q_z, minus_q_squared
        real(dp), intent(in), dimension(-1:LANES) :: power_re, power_im     !! Of (q_x + i q_y)^m, from m = first order - 2 on
        real(dp), intent(inout) :: parts(LANES, ALL_SUMS)

        real(dp), parameter :: LANE(LANES) = [0, 1, 2, 3, 4, 5, 6, 7]
        real(dp) :: h, next, after, k, m, f_re, f_im, df_re, df_im, n_re, n_im, p_re, p_im, b_re, b_im, c_re, c_im
        ! Over degrees, with cos and sin: f, k f, k^2 f, d, k d, dd
        real(dp) :: re, im, k_re, k_im, kk_re, kk_im, d_re, d_im, kd_re, kd_im, dd_re, dd_im
        integer :: i, l

        if (degrees < 1) return
        do l = 1, LANES
            h = 1
            next = q_z
            k = 0
            re = 0
            im = 0
            k_re = 0
            k_im = 0
            kk_re = 0
            kk_im = 0
            d_re = 0
            d_im = 0
            kd_re = 0
            kd_im = 0
            dd_re = 0
            dd_im = 0
            !GCC$ unroll 1
            do i = 1, degrees
                f_re = h*steps(l, 1, i)
                f_im = h*steps(l, 2, i)
                df_re = h*steps(l, 3, i)
                df_im = h*steps(l, 4, i)
                re = re + f_re
                im = im + f_im
                k_re = k_re + k*f_re
                k_im = k_im + k*f_im
                d_re = d_re + df_re
                d_im = d_im + df_im
                if (count == ALL_SUMS) then
                    kk_re = kk_re + k*(k*f_re)
                    kk_im = kk_im + k*(k*f_im)
                    kd_re = kd_re + k*df_re
                    kd_im = kd_im + k*df_im
                    dd_re = dd_re + h*steps(l, 5, i)
                    dd_im = dd_im + h*steps(l, 6, i)
                end if
                after = q_z*next + minus_q_squared*steps(l, 0, i)*h
                h = next
                next = after
                k = k + 1
            end do
            ! The powers m, m - 1 and m - 2 of q_x + i q_y; sums with n = m + k in place of k
            m = first_order + LANE(l)
            p_re = power_re(l)
            p_im = power_im(l)
            b_re = power_re(l - 1)
            b_im = power_im(l - 1)
            n_re = m*re + k_re
            n_im = m*im + k_im
            parts(l, 1) = parts(l, 1) + (p_re*re + p_im*im)
            parts(l, 2) = parts(l, 2) + (p_re*n_re + p_im*n_im)
            parts(l, 3) = parts(l, 3) + m*(b_re*re + b_im*im)
            parts(l, 4) = parts(l, 4) + m*(b_re*im - b_im*re)
            parts(l, 5) = parts(l, 5) + (b_re*d_re + b_im*d_im)
            if (count == ALL_SUMS) then
                c_re = power_re(l - 2)
                c_im = power_im(l - 2)
                parts(l, 6) = parts(l, 6) + (p_re*(m*(n_re + k_re) + kk_re) + p_im*(m*(n_im + k_im) + kk_im))
                parts(l, 7) = parts(l, 7) + m*(b_re*n_re + b_im*n_im)
                parts(l, 8) = parts(l, 8) + m*(b_re*n_im - b_im*n_re)
                parts(l, 9) = parts(l, 9) + (b_re*(m*d_re + kd_re) + b_im*(m*d_im + kd_im))
                parts(l, 10) = parts(l, 10) + m*(m - 1)*(c_re*re + c_im*im)
                parts(l, 11) = parts(l, 11) + m*(m - 1)*(c_re*im - c_im*re)
                parts(l, 12) = parts(l, 12) + (m - 1)*(c_re*d_re + c_im*d_im)
                parts(l, 13) = parts(l, 13) + (m - 1)*(c_re*d_im - c_im*d_re)
                parts(l, 14) = parts(l, 14) + (c_re*dd_re + c_im*dd_im)
            end if
        end do
    end subroutine add_orders

    !> The first FIRST_SUMS sums at PLACES places.
    pure subroutine sums_at_places(harmonic, q, sums)
        class(harmonic_function_t), intent(in) :: harmonic
        real(dp), intent(in) :: q(PLACES, 3)
        real(dp), intent(out) :: sums(PLACES, FIRST_SUMS)

        real(dp), dimension(PLACES) :: minus_q_squared, power_re, power_im
        integer :: m, block, lane

        minus_q_squared = -(q(:, 1)**2 + q(:, 2)**2 + q(:, 3)**2)
        power_re = 0
        power_im = 0
        sums = 0
        do m = 0, harmonic%orders - 1
            block = m/LANES
            lane = modulo(m, LANES) + 1
            call add_order_at_places(m, harmonic%first(block + 1) - harmonic%first(block) - lane + 1, lane, &
                                     harmonic%steps(1, 0, harmonic%first(block) + 1), q, minus_q_squared, &
                                     power_re, power_im, sums)
        end do
    end subroutine sums_at_places

    !> Adds an order at PLACES places, side by side, as `add_orders` does at one.
    pure subroutine add_order_at_places(order, degrees, lane, steps, q, minus_q_squared, power_re, power_im, sums)
        integer, intent(in) :: order, degrees, lane
        real(dp), intent(in) :: steps(LANES, 0:6, degrees)
        real(dp), intent(in) :: q(PLACES, 3), minus_q_squared(PLACES)
        real(dp), intent(inout), dimension(PLACES) :: power_re, power_im    !! Of q_x + i q_y: order - 1 before, order after
        real(dp), intent(inout) :: sums(PLACES, FIRST_SUMS)

        real(dp) :: h, next, after, k, m, f_re, f_im, re, im, k_re, k_im, d_re, d_im, p_re, p_im, b_re, b_im, first
        integer :: i, p

        if (degrees < 1) return
        m = order
        first = merge(1.0_dp, 0.0_dp, order == 0)
        do p = 1, PLACES
            h = 1
            next = q(p, 3)
            k = 0
            re = 0
            im = 0
            k_re = 0
            k_im = 0
            d_re = 0
            d_im = 0
            !GCC$ unroll 1
            do i = 1, degrees
                f_re = h*steps(lane, 1, i)
                f_im = h*steps(lane, 2, i)
                re = re + f_re
                im = im + f_im
                k_re = k_re + k*f_re
                k_im = k_im + k*f_im
                d_re = d_re + h*steps(lane, 3, i)
                d_im = d_im + h*steps(lane, 4, i)
                after = q(p, 3)*next + minus_q_squared(p)*steps(lane, 0, i)*h
                h = next
                next = after
                k = k + 1
            end do
            b_re = power_re(p)
            b_im = power_im(p)
            p_re = b_re*q(p, 1) - b_im*q(p, 2) + first
            p_im = b_re*q(p, 2) + b_im*q(p, 1)
            power_re(p) = p_re
            power_im(p) = p_im
            sums(p, 1) = sums(p, 1) + (p_re*re + p_im*im)
            sums(p, 2) = sums(p, 2) + (p_re*(m*re + k_re) + p_im*(m*im + k_im))
            sums(p, 3) = sums(p, 3) + m*(b_re*re + b_im*im)
            sums(p, 4) = sums(p, 4) + m*(b_re*im - b_im*re)
            sums(p, 5) = sums(p, 5) + (b_re*d_re + b_im*d_im)
        end do
    end subroutine add_order_at_places

    !> q = 2 R (x, y, z)/r^2; NaN, and so all that is made of it, deep in the Earth, where a place in kilometres would lie
    !> and the terms of high degree are beyond any meaning.
    pure function inverted(self, position) result(q)
        class(harmonic_function_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! m
        real(dp) :: q(3)

        real(dp), parameter :: DEEPEST = 0.25_dp        ! r^2/R^2
        real(dp) :: r_squared

        r_squared = dot_product(position, position)
        q = position*(2*self%radius/r_squared)
        if (r_squared < DEEPEST*self%radius**2 .or. .not. allocated(self%first)) q = ieee_value(q, ieee_quiet_nan)
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
