!> Identities of the attitude quaternions.
module test_quaternion
    use vocabulary
    use gracecg_base_vectors, only: cross_matrix
    use gracecg_base_quaternion
    implicit none
    private
    public :: collect_quaternion

    real(dp), parameter :: P(4) = [0.18_dp, -0.36_dp, 0.54_dp, 0.7395944834840242_dp]
    real(dp), parameter :: Q(4) = [-0.6_dp, 0.48_dp, 0.0_dp, 0.64_dp]

contains

    subroutine collect_quaternion(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('matrix-is-orthogonal', test_orthogonal), &
                    new_unittest('product-is-matrix-product', test_product), &
                    new_unittest('matrix-and-back-near-zero-q4', test_round_trip), &
                    new_unittest('rate-agrees-with-turning', test_rate), &
                    new_unittest('passive-sense', test_sense), &
                    new_unittest('cross-matrix-and-inverse', test_matrices)]
    end subroutine collect_quaternion

    !> (2-29) is a rotation.
    subroutine test_orthogonal(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: m(3, 3)

        m = rotation_matrix(normalised(P))
        call check(error, maxval(abs(matmul(m, transpose(m)) - identity(3))) < 4e-16_dp)
    end subroutine test_orthogonal

    !> Products of quaternions, the operator of (4-61) and (4-63), go as those of matrices.
    subroutine test_product(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: a(4), b(4), difference(3, 3)

        a = normalised(P)
        b = normalised(Q)
        difference = rotation_matrix(quaternion_product(a, b)) - &
                     matmul(rotation_matrix(a), rotation_matrix(b))
        call check(error, maxval(abs(difference)) < 1e-15_dp)
        call check(error, maxval(abs(quaternion_product(a, conjugate_quaternion(a)) - &
                                     [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp])) < 1e-15_dp)
    end subroutine test_product

    !> Turns of half a revolution about every kind of axis, where q4 = 0 or nearly so and (4-34)-(4-36) and
    !> (4-76)-(4-78) divide by it.
    subroutine test_round_trip(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: a(4), b(4), axis(3)
        integer :: i

        do i = 0, 60
            axis = unit([cos(0.7_dp*i), sin(1.3_dp*i), cos(2.1_dp*i + 0.3_dp)])
            a = quaternion_from_axis_angle(axis, PI - 1e-9_dp*mod(i, 3))
            b = quaternion_of_matrix(rotation_matrix(a))
            if (dot_product(a, b) < 0) b = -b
            call check(error, maxval(abs(a - b)) < 2e-15_dp)
        end do
    end subroutine test_round_trip

    !> dq/dt, (2-20), (4-8), against the exact turn by omega dt; it is linear in q, (2-21), (4-9), (4-12).
    subroutine test_rate(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: OMEGA(3) = [0.3_dp, -0.2_dp, 0.5_dp], H = 1e-4_dp
        real(dp) :: a(4), forward(4), backward(4), rate(4)

        a = normalised(P)
        rate = quaternion_rate(a, OMEGA)
        forward = quaternion_product(quaternion_from_axis_angle(unit(OMEGA), H*norm2(OMEGA)), a)
        backward = quaternion_product(quaternion_from_axis_angle(unit(OMEGA), -H*norm2(OMEGA)), a)
        call check(error, maxval(abs((forward - backward)/(2*H) - rate)) < 1e-9_dp)
        call check(error, maxval(abs(matmul(rate_matrix(OMEGA), a)/2 - rate)) < 1e-16_dp)
    end subroutine test_rate

    !> A frame turned by +90 deg about z sees the old x axis along its -y axis. (2-29) of (2-19) is Rodrigues'
    !> formula.
    subroutine test_sense(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: AXIS(3) = [0.48_dp, -0.6_dp, 0.64_dp], ANGLE = 1.1_dp
        real(dp) :: m(3, 3)

        m = rotation_matrix(quaternion_from_axis_angle([0.0_dp, 0.0_dp, 1.0_dp], PI/2))
        call check(error, maxval(abs(matmul(m, [1.0_dp, 0.0_dp, 0.0_dp]) - &
                                     [0.0_dp, -1.0_dp, 0.0_dp])) < 1e-15_dp)
        m = rotation_matrix(quaternion_from_axis_angle(AXIS, ANGLE))
        m = m - (cos(ANGLE)*identity(3) - sin(ANGLE)*cross_matrix(AXIS) + &
                 (1 - cos(ANGLE))*spread(AXIS, 2, 3)*spread(AXIS, 1, 3))
        call check(error, maxval(abs(m)) < 1e-15_dp)
    end subroutine test_sense

    !> Pi(a) b of (4-16) is a x b; the matrix as printed, v_x and v_y exchanged, makes (-9, 0, 6) of (1, 2, 3) and
    !> (4, 5, 6).
    subroutine test_matrices(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: A(3) = [1.0_dp, -2.0_dp, 0.5_dp], B(3) = [0.2_dp, 3.0_dp, -1.0_dp]
        real(dp) :: m(3, 3)

        call check(error, maxval(abs(matmul(cross_matrix(A), B) - cross(A, B))) < 1e-15_dp)
        m = cross_matrix([1.0_dp, 2.0_dp, 3.0_dp])
        call check(error, all(nint(matmul(m, [4.0_dp, 5.0_dp, 6.0_dp])) == [-3, 6, -3]))
        m = cross_matrix([2.0_dp, 1.0_dp, 3.0_dp])
        call check(error, all(nint(matmul(m, [4.0_dp, 5.0_dp, 6.0_dp])) == [-9, 0, 6]), 'as printed')
        m = identity(3) + cross_matrix(A)
        call check(error, maxval(abs(matmul(m, inverse_3x3(m)) - identity(3))) < 1e-15_dp)
    end subroutine test_matrices
end module test_quaternion
