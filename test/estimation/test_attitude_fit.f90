!> The fitting dynamics and their state transition matrix.
module test_attitude_fit
    use vocabulary
    use gracecg_base_quaternion, only: rotation_matrix, normalised, quaternion_rate
    use gracecg_estimation_attitude_fit
    implicit none
    private
    public :: collect_attitude_fit

    !> CSR-TM-00-01 section 5.2, kg m^2
    real(dp), parameter :: INERTIA(3, 3) = reshape([70.23_dp, -3.0_dp, -2.883_dp, -3.0_dp, 345.14_dp, &
                                                    -0.348_dp, -2.883_dp, -0.348_dp, 388.84_dp], [3, 3])
    real(dp), parameter :: Q_0(4) = [-0.70085473_dp, -3.1e-6_dp, 0.71330403_dp, 3.1e-6_dp]
    real(dp), parameter :: OMEGA_0(3) = [2e-5_dp, 1.1149e-3_dp, -1e-5_dp]

contains

    subroutine collect_attitude_fit(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('phi-22-against-differences', test_phi_22), &
                    new_unittest('phi-11-and-12-against-differences', test_phi_quaternion), &
                    new_unittest('phi-11-and-12-as-printed', test_phi_printed), &
                    new_unittest('angular-momentum-conserved', test_momentum), &
                    new_unittest('order-four', test_order), &
                    new_unittest('rate-does-not-depend-on-attitude', test_attitude_free)]
    end subroutine collect_attitude_fit

    !> 60 s of a torque like the report's case 1.
    function example_fit(steps, torque_size) result(fit)
        integer, intent(in) :: steps
        real(dp), intent(in) :: torque_size     !! N m
        type(attitude_fit_t) :: fit

        real(dp) :: torque(3, 2*steps + 1), interval
        integer :: j

        interval = 60.0_dp/steps
        do j = 0, 2*steps
            torque(:, j + 1) = torque_size*[0.6_dp, -1.0_dp, 0.8_dp]*sin(TWO_PI*0.1_dp*j*interval/2)
        end do
        fit = new_attitude_fit(INERTIA, interval, torque)
    end function example_fit

    !> Phi_22 of (4-55), (4-67). Central differences err by (60 s STEP)^2/6, 6e-12.
    subroutine test_phi_22(error)
        type(error_type), allocatable, intent(out) :: error
        type(attitude_fit_t) :: fit
        type(fitted_rotation_t) :: nominal, plus, minus
        real(dp), parameter :: STEP = 1e-7_dp
        real(dp) :: change(3), differences(3)
        integer :: i

        fit = example_fit(600, 1e-3_dp)
        call fit%integrate(Q_0, OMEGA_0, nominal)
        do i = 1, 3
            change = 0
            change(i) = STEP
            call fit%integrate(Q_0, OMEGA_0 + change, plus)
            call fit%integrate(Q_0, OMEGA_0 - change, minus)
            differences = (plus%omega(:, 600) - minus%omega(:, 600))/(2*STEP)
            call check(error, maxval(abs(differences - nominal%phi_22(:, i, 600))) < 1e-9_dp)
        end do
    end subroutine test_phi_22

    !> (4-50)-(4-56): the transition matrix (4-47), with A (4-48) of (4-12), (4-13), (4-15).
    subroutine test_phi_quaternion(error)
        type(error_type), allocatable, intent(out) :: error
        type(attitude_fit_t) :: fit
        type(fitted_rotation_t) :: nominal, plus, minus
        real(dp), parameter :: STEP = 1e-5_dp
        real(dp) :: change(7), differences(4), found(4), transition(4, 7)
        integer :: i

        fit = example_fit(600, 1e-3_dp)
        call fit%integrate(Q_0, OMEGA_0, nominal)
        transition = nominal%quaternion_transition(600)
        do i = 1, 7
            change = 0
            change(i) = STEP
            call fit%integrate(Q_0 + change(1:4), OMEGA_0 + change(5:7), plus)
            call fit%integrate(Q_0 - change(1:4), OMEGA_0 - change(5:7), minus)
            differences = (plus%q(:, 600) - minus%q(:, 600))/(2*STEP)
            found = transition(:, i)
            call check(error, maxval(abs(differences - found)) < 1e-6_dp*max(1.0_dp, maxval(abs(found))))
        end do
    end subroutine test_phi_quaternion

    !> (4-53), (4-54), (4-87), (4-88) integrated as printed: the closed forms in their place are the same in every step
    !> of Runge and Kutta.
    subroutine test_phi_printed(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: STEPS = 600
        type(attitude_fit_t) :: fit
        type(fitted_rotation_t) :: rotation, fine
        real(dp) :: phi(4, 7), closed(4, 7), k1(4, 7), k2(4, 7), k3(4, 7), k4(4, 7), h
        integer :: k, i

        fit = example_fit(STEPS, 1e-3_dp)
        call fit%integrate(normalised(Q_0), OMEGA_0, rotation)
        fit = example_fit(2*STEPS, 1e-3_dp)     ! for what stands at half steps
        call fit%integrate(normalised(Q_0), OMEGA_0, fine)
        h = 60.0_dp/STEPS
        phi = 0
        do i = 1, 4
            phi(i, i) = 1
        end do
        do k = 0, STEPS - 1
            k1 = slope(2*k, phi)
            k2 = slope(2*k + 1, phi + h/2*k1)
            k3 = slope(2*k + 1, phi + h/2*k2)
            k4 = slope(2*k + 2, phi + h*k3)
            phi = phi + h/6*(k1 + 2*k2 + 2*k3 + k4)
        end do
        closed = rotation%quaternion_transition(STEPS)
        call check(error, maxval(abs(phi(:, :4) - closed(:, :4))) < 1e-10_dp, 'Phi_11')
        call check(error, maxval(abs(phi(:, 5:) - closed(:, 5:))) < 1e-8_dp*30, 'Phi_12')

    contains

        !> Omega/2 Phi_11, and Omega/2 Phi_12 + Gamma Phi_22, at a half step
        function slope(half, at) result(rate)
            integer, intent(in) :: half
            real(dp), intent(in) :: at(4, 7)
            real(dp) :: rate(4, 7)

            integer :: j

            do j = 1, 7
                rate(:, j) = quaternion_rate(at(:, j), fine%omega(:, half))
            end do
            rate(:, 5:) = rate(:, 5:) + matmul(kinematic_partials(fine%q(:, half)), fine%phi_22(:, :, half))
        end function slope
    end subroutine test_phi_printed

    !> Without torque J omega keeps its inertial direction and size, and q stays of unit length.
    subroutine test_momentum(error)
        type(error_type), allocatable, intent(out) :: error
        type(attitude_fit_t) :: fit
        type(fitted_rotation_t) :: rotation
        real(dp), parameter :: FAST(3) = [0.05_dp, 0.1_dp, -0.02_dp]
        real(dp) :: start(3), finish(3)

        fit = example_fit(600, 0.0_dp)
        call fit%integrate(normalised(Q_0), FAST, rotation)
        start = matmul(transpose(rotation_matrix(rotation%q(:, 0))), matmul(INERTIA, rotation%omega(:, 0)))
        finish = matmul(transpose(rotation_matrix(rotation%q(:, 600))), matmul(INERTIA, rotation%omega(:, 600)))
        call check(error, norm2(finish - start) < 1e-9_dp*norm2(start))
        call check(error, abs(norm2(rotation%q(:, 600)) - 1) < 1e-10_dp)
    end subroutine test_momentum

    !> Global error against a fine integration shrinks as h^4.
    subroutine test_order(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: order

        order = log(final_error(30)/final_error(60))/log(2.0_dp)
        call check(error, order > 3.6_dp .and. order < 4.6_dp)
    contains
        real(dp) function final_error(steps)
            integer, intent(in) :: steps
            type(attitude_fit_t) :: fit
            type(fitted_rotation_t) :: coarse, fine
            real(dp), parameter :: FAST(3) = [0.05_dp, 0.1_dp, -0.02_dp]

            fit = example_fit(steps, 1.0_dp)
            call fit%integrate(Q_0, FAST, coarse)
            fit = example_fit(3000, 1.0_dp)
            call fit%integrate(Q_0, FAST, fine)
            final_error = norm2(coarse%omega(:, steps) - fine%omega(:, 3000))
        end function final_error
    end subroutine test_order

    !> The angular velocity (4-51), (4-80) does not depend on the attitude, (4-10), and follows Euler's equations (4-7).
    subroutine test_attitude_free(error)
        type(error_type), allocatable, intent(out) :: error
        type(attitude_fit_t) :: fit
        type(fitted_rotation_t) :: one, other
        real(dp), parameter :: NO_TORQUE(3) = 0

        fit = example_fit(600, 1e-3_dp)
        call fit%integrate(Q_0, OMEGA_0, one)
        call fit%integrate([0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], OMEGA_0, other)
        call check(error, maxval(abs(one%omega - other%omega)) + maxval(abs(one%omega_dot - other%omega_dot)), 0.0_dp)
        call check(error, maxval(abs(one%omega_dot(:, 37) - fit%driven(:, 74) - &
                                     fit%body%angular_acceleration(NO_TORQUE, one%omega(:, 37)))), &
                   0.0_dp, thr=1e-14_dp*maxval(abs(one%omega_dot(:, 37))))
    end subroutine test_attitude_free
end module test_attitude_fit
