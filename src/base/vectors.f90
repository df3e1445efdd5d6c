!> Vectors of three components and 3x3 matrices.
module gracecg_base_vectors
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: cross, cross_matrix, unit, identity, rotation_z, inverse_3x3, determinant_3x3
    public :: transformed, transformed_back

contains

    !> Vector product a x b.
    pure function cross(a, b) result(c)
        real(dp), intent(in) :: a(3), b(3)  !! In one frame
        real(dp) :: c(3)

        c(1) = a(2)*b(3) - a(3)*b(2)
        c(2) = a(3)*b(1) - a(1)*b(3)
        c(3) = a(1)*b(2) - a(2)*b(1)
    end function cross

    !> A vector's coordinates after a transformation, M v. (gfortran hands some products of `matmul` to its library, which
    !> takes longer to look at their shapes than to multiply.)
    pure function transformed(m, v) result(w)
        real(dp), intent(in) :: m(3, 3), v(3)   !! Of any unit
        real(dp) :: w(3)

        w = m(:, 1)*v(1) + m(:, 2)*v(2) + m(:, 3)*v(3)
    end function transformed

    !> The same by the transpose, M^T v: back again where M is a rotation.
    pure function transformed_back(m, v) result(w)
        real(dp), intent(in) :: m(3, 3), v(3)   !! Of any unit
        real(dp) :: w(3)

        w(1) = m(1, 1)*v(1) + m(2, 1)*v(2) + m(3, 1)*v(3)
        w(2) = m(1, 2)*v(1) + m(2, 2)*v(2) + m(3, 2)*v(3)
        w(3) = m(1, 3)*v(1) + m(2, 3)*v(2) + m(3, 3)*v(3)
    end function transformed_back

    !> The antisymmetric matrix of a vector, CSR-TM-00-01 eq. (4-16), which prints v_x and v_y exchanged:
    !> matmul(cross_matrix(v), w) is v x w.
    pure function cross_matrix(v) result(m)
        real(dp), intent(in) :: v(3)    !! In any frame
        real(dp) :: m(3, 3)

        m(:, 1) = [0.0_dp, v(3), -v(2)]
        m(:, 2) = [-v(3), 0.0_dp, v(1)]
        m(:, 3) = [v(2), -v(1), 0.0_dp]
    end function cross_matrix

    !> A vector's direction, of length one. A zero vector gives NaN.
    pure function unit(v) result(u)
        real(dp), intent(in) :: v(3)    !! Any but zero
        real(dp) :: u(3)

        u = v/norm2(v)
    end function unit

    !> The identity matrix of order n.
    pure function identity(n) result(m)
        integer, intent(in) :: n    !! Its order, 0 or more
        real(dp) :: m(n, n)

        integer :: i

        m = 0
        do i = 1, n
            m(i, i) = 1
        end do
    end function identity

    !> The matrix that takes coordinates of a frame into those of a frame turned about its z axis by
    !> `angle` (passive). With the sidereal angle it takes inertial into Earth-fixed coordinates:
    !> the transpose of CSR-TM-00-01 eq. (2-4).
    pure function rotation_z(angle) result(m)
        real(dp), intent(in) :: angle   !! rad
        real(dp) :: m(3, 3)

        real(dp) :: c, s

        c = cos(angle)
        s = sin(angle)
        m(:, 1) = [c, -s, 0.0_dp]
        m(:, 2) = [s, c, 0.0_dp]
        m(:, 3) = [0.0_dp, 0.0_dp, 1.0_dp]
    end function rotation_z

    !> Determinant of a matrix.
    pure real(dp) function determinant_3x3(m) result(d)
        real(dp), intent(in) :: m(3, 3) !! Of any unit

        d = dot_product(m(:, 1), cross(m(:, 2), m(:, 3)))
    end function determinant_3x3

    !> Inverse by cofactors: for well-conditioned matrices such as an inertia tensor. Everything
    !> else goes through LAPACK.
    pure function inverse_3x3(m) result(inverse)
        real(dp), intent(in) :: m(3, 3) !! Regular
        real(dp) :: inverse(3, 3)

        inverse(1, :) = cross(m(:, 2), m(:, 3))
        inverse(2, :) = cross(m(:, 3), m(:, 1))
        inverse(3, :) = cross(m(:, 1), m(:, 2))
        inverse = inverse/determinant_3x3(m)
    end function inverse_3x3
end module gracecg_base_vectors
