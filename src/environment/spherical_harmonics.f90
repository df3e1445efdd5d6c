!> Sums of solid spherical harmonics and of their derivatives, in Cartesian coordinates: fast, and
!> without a singular place anywhere outside the centre.
!>
!> An exterior harmonic function is sum_nm (R/r)^(n+1) Pbar_nm(sin lat) [C cos m lon + S sin m lon].
!> The inversion q = 2 R (x, y, z)/r^2 turns each term, but for a factor R/r, into a polynomial:
!>
!>     B_nm = (R/r) h_(n-m)(q) (q_x + i q_y)^m,    h_0 = 1,  h_1 = q_z,
!>     h_(k+1) = q_z h_k - beta q^2 h_(k-1),       beta = k (k + 2m)/(4 (m + k)^2 - 1)
!>
!> The h are the derived Legendre functions of S. Pines (AIAA J. 11 (1973) 1508-1511), scaled so
!> that their first coefficient is one and multiplied by powers of 2R/r; the recursion with rising
!> degree at fixed order is the stable one (J. B. Lundberg and B. E. Schutz, J. Guidance 11 (1988)
!> 31-38). The scale is taken into the coefficients when a model is built, and so are the
!> derivatives: a derivative of B_nm is a combination of functions B of degree n + 1
!> (L. E. Cunningham, Celestial Mechanics 2 (1970) 207-216). Hence potential, gradient and second
!> derivatives are all plain sums over B with coefficients of their own, and one procedure
!> evaluates them, three at a time.
module gracecg_environment_spherical_harmonics
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: MAX_DEGREE, harmonic_triple_t, new_harmonic_triple, harmonic_function, differentiate

    integer, parameter :: MAX_DEGREE = 360
    !! Highest degree of a function that can be differentiated twice and evaluated
    integer, parameter :: LANES = 4
    !! Orders summed side by side, so that the compiler can use the processor's vector instructions
    integer, parameter :: MAX_BLOCKS = 91   !! Blocks of orders: enough for orders 0..MAX_DEGREE + 2

    type :: harmonic_triple_t
        !! Three exterior harmonic functions that are evaluated together
        private
        real(dp) :: radius = 1                      !! R, m
        integer, allocatable :: first(:)            !! First step of each block of orders in `steps`
        real(dp), allocatable :: steps(:, :, :)
        !! One step of the recursion for LANES orders m, shape (LANES, 0:6, steps): beta, three
        !! coefficients of Re B_nm, three of Im B_nm
    contains
        procedure :: evaluate   !! The three values at a place
    end type harmonic_triple_t

contains

    !> The coefficients f_nm of a function sum_nm Re(f_nm B_nm), n = 0..degree, m = 0..order, from
    !> fully normalised ones. They are multiplied by the first coefficient of Pbar_nm, as a
    !> polynomial in sin lat times cos^m lat, over 2^n:
    !>
    !>     sqrt((2 - delta_0m)(2n + 1)(n - m)!/(n + m)!) (2n - 1)!!/((n - m)! 2^n)
    pure function harmonic_function(c, s) result(f)
        real(dp), intent(in) :: c(0:, 0:)   !! Of cos m lon; (n, m), n >= m used
        real(dp), intent(in) :: s(0:, 0:)   !! Of sin m lon; those of m = 0 are not used
        complex(dp), allocatable :: f(:, :) !! Shape (0:degree, 0:order), zero for m > n

        real(dp) :: sectorial, factor
        integer :: n, m

        allocate (f(0:ubound(c, 1), 0:ubound(c, 2)), source=(0.0_dp, 0.0_dp))
        sectorial = 1
        do m = 0, min(ubound(c, 2), ubound(c, 1))
            if (m == 1) sectorial = sectorial*sqrt(3.0_dp)/2
            if (m > 1) sectorial = sectorial*sqrt((2*m + 1)/(2.0_dp*m))/2
            factor = sectorial
            do n = m, ubound(c, 1)
                if (n > m) factor = factor*sqrt((4.0_dp*n**2 - 1)/((n - m)*(n + m)))/2
                f(n, m) = factor*cmplx(c(n, m), -s(n, m), dp)
            end do
        end do
        f(:, 0) = real(f(:, 0))
    end function harmonic_function

    !> The derivatives of a function with respect to x/R, y/R and z/R, one degree and order higher.
    !> Cunningham's relations become
    !>
    !>     d/dz B_nm = -2 w B_(n+1,m),                            w = (2n + 1)/4
    !>     d/dx B_nm = -w B_(n+1,m+1) + w B_(n+1,m-1)
    !>     d/dy B_nm = i w B_(n+1,m+1) + i w B_(n+1,m-1)
    !>
    !> and for m = 0 the first term doubled in place of the second.
    pure subroutine differentiate(f, dx, dy, dz)
        complex(dp), intent(in) :: f(0:, 0:)    !! Of harmonic_function, or of a derivative
        complex(dp), allocatable, intent(out) :: dx(:, :), dy(:, :), dz(:, :)   !! Likewise

        complex(dp) :: term
        integer :: n, m, degree, order

        degree = ubound(f, 1)
        order = ubound(f, 2)
        allocate (dx(0:degree + 1, 0:order + 1), source=(0.0_dp, 0.0_dp))
        allocate (dy, dz, source=dx)
        do m = 0, order
            do n = m, degree
                term = (2*n + 1)*f(n, m)/4
                dz(n + 1, m) = -2*term
                if (m == 0) then
                    term = 2*term
                else
                    dx(n + 1, m - 1) = dx(n + 1, m - 1) + term
                    dy(n + 1, m - 1) = dy(n + 1, m - 1) + (0, 1)*term
                end if
                dx(n + 1, m + 1) = dx(n + 1, m + 1) - term
                dy(n + 1, m + 1) = dy(n + 1, m + 1) + (0, 1)*term
            end do
        end do
        dx(:, 0) = real(dx(:, 0))   ! B_n0 is real
        dy(:, 0) = real(dy(:, 0))
    end subroutine differentiate

    !> Arranges the coefficients of three functions of equal shape for `evaluate`.
    pure function new_harmonic_triple(radius, f1, f2, f3) result(triple)
        real(dp), intent(in) :: radius                              !! R, m
        complex(dp), intent(in), dimension(0:, 0:) :: f1, f2, f3    !! Shape (0:degree, 0:order)
        type(harmonic_triple_t) :: triple

        complex(dp) :: f(3)
        integer :: degree, order, block, lane, k, m, step

        degree = ubound(f1, 1)
        order = min(ubound(f1, 2), degree)
        triple%radius = radius
        allocate (triple%first(order/LANES + 2))
        triple%first(1) = 1
        do block = 1, size(triple%first) - 1
            triple%first(block + 1) = triple%first(block) + degree + 1 - LANES*(block - 1)
        end do
        allocate (triple%steps(LANES, 0:6, triple%first(size(triple%first)) - 1), source=0.0_dp)
        do block = 1, size(triple%first) - 1
            do lane = 1, LANES
                m = LANES*(block - 1) + lane - 1
                if (m > order) exit
                do k = 0, degree - m
                    step = triple%first(block) + k
                    triple%steps(lane, 0, step) = k*(k + 2*m)/(4.0_dp*(m + k)**2 - 1)
                    f = [f1(m + k, m), f2(m + k, m), f3(m + k, m)]
                    triple%steps(lane, 1:3, step) = real(f)
                    triple%steps(lane, 4:6, step) = -aimag(f)
                end do
            end do
        end do
    end function new_harmonic_triple

    !> The values of the three functions at a place other than the centre.
    pure subroutine evaluate(self, position, values)
        class(harmonic_triple_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! m
        real(dp), intent(out) :: values(3)      !! Of the three functions, in their order

        real(dp) :: q(3)

        q = position*(2*self%radius/dot_product(position, position))
        call sum_harmonics(size(self%first) - 1, self%first, self%steps, q, values)
        values = values*(sqrt(dot_product(q, q))/2)
    end subroutine evaluate

    !> sum_nm Re(f_nm h_(n-m) (q_x + i q_y)^m). First the sums over the degree, for LANES orders at
    !> once; then the sum over the orders.
    pure subroutine sum_harmonics(blocks, first, steps, q, values)
        integer, intent(in) :: blocks
        integer, intent(in) :: first(blocks + 1)
        real(dp), intent(in) :: steps(LANES, 0:6, *)
        real(dp), intent(in) :: q(3)
        real(dp), intent(out) :: values(3)

        ! The arrays have constant shapes, and each sum a name of its own, for the compiler's sake:
        ! it keeps them in registers.
        real(dp), dimension(LANES) :: h, previous, next, re1, re2, re3, im1, im2, im3
        real(dp) :: sums(LANES, MAX_BLOCKS, 6), q_squared
        complex(dp) :: power
        integer :: block, lane, i

        q_squared = dot_product(q, q)
        do block = 1, blocks
            previous = 0
            h = 1
            re1 = 0
            re2 = 0
            re3 = 0
            im1 = 0
            im2 = 0
            im3 = 0
            do i = first(block), first(block + 1) - 1
                re1 = re1 + h*steps(:, 1, i)
                re2 = re2 + h*steps(:, 2, i)
                re3 = re3 + h*steps(:, 3, i)
                im1 = im1 + h*steps(:, 4, i)
                im2 = im2 + h*steps(:, 5, i)
                im3 = im3 + h*steps(:, 6, i)
                next = q(3)*h - q_squared*steps(:, 0, i)*previous
                previous = h
                h = next
            end do
            sums(:, block, 1) = re1
            sums(:, block, 2) = re2
            sums(:, block, 3) = re3
            sums(:, block, 4) = im1
            sums(:, block, 5) = im2
            sums(:, block, 6) = im3
        end do

        values = 0
        power = 1
        do block = 1, blocks
            do lane = 1, LANES
                values = values + power%re*sums(lane, block, 1:3) + power%im*sums(lane, block, 4:6)
                power = power*cmplx(q(1), q(2), dp)
            end do
        end do
    end subroutine sum_harmonics
end module gracecg_environment_spherical_harmonics
