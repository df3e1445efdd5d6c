!> Attitude quaternions: passive (inertial to body), scalar part last, as in CSR-TM-00-01.
!>
!> A quaternion q and the matrix rotation_matrix(q) take coordinates of the first frame (inertial)
!> into those of the second (body). Composition is in the order of the matrices:
!> rotation_matrix(product(p, q)) = matmul(rotation_matrix(p), rotation_matrix(q)).
module gracecg_base_quaternion
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: rotation_matrix, quaternion_of_matrix, quaternion_product, conjugate_quaternion
    public :: normalised, quaternion_rate, rate_matrix, quaternion_from_axis_angle
    public :: rotation_angle_between, rotation_between

contains

    !> Direction cosine matrix of a unit quaternion, CSR-TM-00-01 eq. (2-29).
    pure function rotation_matrix(q) result(m)
        real(dp), intent(in) :: q(4)    !! Unit quaternion, scalar last
        real(dp) :: m(3, 3)

        m(1, 1) = 1 - 2*(q(2)**2 + q(3)**2)
        m(2, 1) = 2*(q(1)*q(2) - q(3)*q(4))
        m(3, 1) = 2*(q(1)*q(3) + q(2)*q(4))
        m(1, 2) = 2*(q(1)*q(2) + q(3)*q(4))
        m(2, 2) = 1 - 2*(q(1)**2 + q(3)**2)
        m(3, 2) = 2*(q(2)*q(3) - q(1)*q(4))
        m(1, 3) = 2*(q(1)*q(3) - q(2)*q(4))
        m(2, 3) = 2*(q(2)*q(3) + q(1)*q(4))
        m(3, 3) = 1 - 2*(q(1)**2 + q(2)**2)
    end function rotation_matrix

    !> The quaternion of a rotation matrix by its largest component (S. W. Shepperd, J. Guidance and
    !> Control 1 (1978) 223-224), so that no component is divided by a small number. It stands in
    !> for CSR-TM-00-01 eqs. (4-34)-(4-36) and (4-76)-(4-78), which divide by q4.
    pure function quaternion_of_matrix(m) result(q)
        real(dp), intent(in) :: m(3, 3) !! Rotation matrix
        real(dp) :: q(4)                !! Unit quaternion, scalar last, q(4) >= 0

        real(dp) :: trace, squares(4), f
        integer :: largest

        trace = m(1, 1) + m(2, 2) + m(3, 3)
        squares = [1 + 2*m(1, 1) - trace, 1 + 2*m(2, 2) - trace, 1 + 2*m(3, 3) - trace, 1 + trace]
        largest = maxloc(squares, 1)    ! squares = 4 q(i)^2
        f = 0.5_dp/sqrt(squares(largest))
        select case (largest)
        case (1)
            q = f*[squares(1), m(1, 2) + m(2, 1), m(1, 3) + m(3, 1), m(2, 3) - m(3, 2)]
        case (2)
            q = f*[m(1, 2) + m(2, 1), squares(2), m(2, 3) + m(3, 2), m(3, 1) - m(1, 3)]
        case (3)
            q = f*[m(1, 3) + m(3, 1), m(2, 3) + m(3, 2), squares(3), m(1, 2) - m(2, 1)]
        case default
            q = f*[m(2, 3) - m(3, 2), m(3, 1) - m(1, 3), m(1, 2) - m(2, 1), squares(4)]
        end select
        q = q/norm2(q)
        if (q(4) < 0) q = -q
    end function quaternion_of_matrix

    !> The quaternion of the rotation q followed by the rotation p: the operator of eqs. (4-61), (4-63).
    pure function quaternion_product(p, q) result(r)
        real(dp), intent(in) :: p(4), q(4)  !! Of unit length, scalar last
        real(dp) :: r(4)

        r(1) = p(4)*q(1) + p(3)*q(2) - p(2)*q(3) + p(1)*q(4)
        r(2) = -p(3)*q(1) + p(4)*q(2) + p(1)*q(3) + p(2)*q(4)
        r(3) = p(2)*q(1) - p(1)*q(2) + p(4)*q(3) + p(3)*q(4)
        r(4) = -p(1)*q(1) - p(2)*q(2) - p(3)*q(3) + p(4)*q(4)
    end function quaternion_product

    !> The inverse of a unit quaternion.
    pure function conjugate_quaternion(q) result(r)
        real(dp), intent(in) :: q(4)    !! Of unit length, scalar last
        real(dp) :: r(4)

        r = [-q(1), -q(2), -q(3), q(4)]
    end function conjugate_quaternion

    !> A quaternion made one of unit length, eqs. (4-37), (4-44). A zero quaternion gives NaN.
    pure function normalised(q) result(u)
        real(dp), intent(in) :: q(4)    !! Of any length but zero
        real(dp) :: u(4)

        u = q/norm2(q)
    end function normalised

    !> Omega(omega), CSR-TM-00-01 eqs. (2-21), (4-9).
    pure function rate_matrix(omega) result(m)
        real(dp), intent(in) :: omega(3)    !! Angular velocity in the body frame, rad/s
        real(dp) :: m(4, 4)

        m(:, 1) = [0.0_dp, -omega(3), omega(2), -omega(1)]
        m(:, 2) = [omega(3), 0.0_dp, -omega(1), -omega(2)]
        m(:, 3) = [-omega(2), omega(1), 0.0_dp, -omega(3)]
        m(:, 4) = [omega(1), omega(2), omega(3), 0.0_dp]
    end function rate_matrix

    !> dq/dt = Omega(omega) q / 2, CSR-TM-00-01 eqs. (2-20), (4-8).
    pure function quaternion_rate(q, omega) result(rate)
        real(dp), intent(in) :: q(4)        !! Scalar last
        real(dp), intent(in) :: omega(3)    !! Angular velocity in the body frame, rad/s
        real(dp) :: rate(4)

        rate(1) = 0.5_dp*(omega(3)*q(2) - omega(2)*q(3) + omega(1)*q(4))
        rate(2) = 0.5_dp*(-omega(3)*q(1) + omega(1)*q(3) + omega(2)*q(4))
        rate(3) = 0.5_dp*(omega(2)*q(1) - omega(1)*q(2) + omega(3)*q(4))
        rate(4) = 0.5_dp*(-omega(1)*q(1) - omega(2)*q(2) - omega(3)*q(3))
    end function quaternion_rate

    !> The quaternion of a frame turned about `axis` by `angle`, CSR-TM-00-01 eq. (2-19).
    pure function quaternion_from_axis_angle(axis, angle) result(q)
        real(dp), intent(in) :: axis(3)     !! Unit vector
        real(dp), intent(in) :: angle       !! rad
        real(dp) :: q(4)

        q(1:3) = axis*sin(angle/2)
        q(4) = cos(angle/2)
    end function quaternion_from_axis_angle

    !> The angle of the rotation that takes one attitude into another, rad; blind to the sign of q.
    pure real(dp) function rotation_angle_between(p, q) result(angle)
        real(dp), intent(in) :: p(4), q(4)  !! Unit quaternions

        real(dp) :: d(4)

        d = quaternion_product(p, conjugate_quaternion(q))
        angle = 2*atan2(norm2(d(1:3)), abs(d(4)))
    end function rotation_angle_between

    !> Axis times angle of the rotation that takes one attitude into another, at most half a turn; blind to the sign of q.
    pure function rotation_between(from, to) result(phi)
        real(dp), intent(in) :: from(4), to(4)  !! Unit quaternions
        real(dp) :: phi(3)                      !! rad

        real(dp) :: d(4), sine

        d = quaternion_product(to, conjugate_quaternion(from))
        if (d(4) < 0) d = -d
        sine = norm2(d(1:3))
        phi = 2*d(1:3)
        if (sine > 1e-8_dp) phi = 2*atan2(sine, d(4))/sine*d(1:3)
    end function rotation_between
end module gracecg_base_quaternion
