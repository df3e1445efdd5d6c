!> The accelerometer's observation model and its partials.
module test_offset_model
    use vocabulary
    use gracecg_estimation_offset_model, only: offset_matrix, offset_rate_partials
    implicit none
    private
    public :: collect_offset_model

    real(dp), parameter :: OMEGA(3) = [0.3_dp, -1.1_dp, 0.7_dp], OMEGA_DOT(3) = [0.2_dp, 0.5_dp, -0.4_dp]

contains

    subroutine collect_offset_model(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('matrix-as-printed', test_matrix), &
                    new_unittest('partials-against-differences', test_partials)]
    end subroutine collect_offset_model

    !> The elements as CSR-TM-00-01 eq. (4-17) writes them.
    subroutine test_matrix(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: expected(3, 3)

        associate (x => OMEGA(1), y => OMEGA(2), z => OMEGA(3), &
                   dx => OMEGA_DOT(1), dy => OMEGA_DOT(2), dz => OMEGA_DOT(3))
            expected(1, :) = [-y**2 - z**2, x*y - dz, x*z + dy]
            expected(2, :) = [x*y + dz, -x**2 - z**2, z*y - dx]
            expected(3, :) = [x*z - dy, z*y + dx, -y**2 - x**2]
        end associate
        call check(error, maxval(abs(offset_matrix(OMEGA, OMEGA_DOT) - expected)) < 1e-15_dp)
    end subroutine test_matrix

    !> (4-21), (4-27)-(4-32). With d omega/dt = Lambda omega the model is quadratic: central differences are
    !> exact.
    subroutine test_partials(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: LAMBDA(3, 3) = reshape([0.1_dp, 0.4_dp, -0.2_dp, 0.7_dp, 0.0_dp, 0.3_dp, &
                                                       -0.5_dp, 0.6_dp, 0.2_dp], [3, 3])
        real(dp), parameter :: D(3) = [0.3_dp, 0.4_dp, -0.5_dp], STEP = 1e-2_dp
        real(dp) :: partials(3, 3), plus(3), minus(3), differences(3)
        integer :: i

        partials = offset_rate_partials(OMEGA, D, LAMBDA)
        do i = 1, 3
            plus = OMEGA
            minus = OMEGA
            plus(i) = plus(i) + STEP
            minus(i) = minus(i) - STEP
            differences = matmul(offset_matrix(plus, matmul(LAMBDA, plus)) - &
                                 offset_matrix(minus, matmul(LAMBDA, minus)), D)/(2*STEP)
            call check(error, maxval(abs(differences - partials(:, i))) < 1e-13_dp)
        end do
    end subroutine test_partials
end module test_offset_model
