!> The rotation of a rigid body: order of the integration, conserved quantities, partials.
module test_rigid_body
    use vocabulary
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_observations_parameters, only: RATES => RATE
    use gracecg_estimation_physical_model, only: physical_model_t, model_state_t, model_trajectory_t, integrate_trajectory
    use gracecg_estimation_rigid_body, only: rigid_body_t, new_rigid_body
    implicit none
    private
    public :: collect_rigid_body

    real(dp), parameter :: TENSOR(3, 3) = reshape([80.0_dp, 3.0_dp, -2.0_dp, 3.0_dp, 350.0_dp, 1.0_dp, &
                                                   -2.0_dp, 1.0_dp, 390.0_dp], [3, 3])

contains

    subroutine collect_rigid_body(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('order-four', test_order), &
                    new_unittest('free-body-keeps-momentum-and-energy', test_free_body), &
                    new_unittest('partials-equal-differences', test_partials)]
    end subroutine collect_rigid_body

    !> A body without torque along an arc of a minute.
    subroutine fly(steps, rate, flown)
        integer, intent(in) :: steps
        real(dp), intent(in) :: rate(3)     !! At the epoch, rad/s
        type(model_trajectory_t), intent(out) :: flown
        type(physical_model_t) :: model
        type(model_state_t) :: state

        model%steps = steps
        model%interval = 60.0_dp/steps
        model%inertia = TENSOR
        allocate (model%magnetic_torque(3, 0:2*steps), model%dipole(3, 0:2*steps), model%upwards(3, 0:2*steps), source=0.0_dp)
        allocate (model%rate_squared(0:2*steps), source=0.0_dp)
        allocate (model%shaped(0), model%rotational(0), model%jump_torque(3, 3, 0))
        state%quaternion = [0.1_dp, -0.5_dp, 0.1_dp, sqrt(0.73_dp)]
        state%value(RATES) = rate
        call integrate_trajectory(model, state, flown)
    end subroutine fly

    !> Half the step, a sixteenth of the error.
    subroutine test_order(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: OMEGA(3) = [0.2_dp, -0.3_dp, 0.5_dp]
        type(model_trajectory_t) :: coarse, finer, fine
        real(dp) :: order

        call fly(300, OMEGA, coarse)
        call fly(600, OMEGA, finer)
        call fly(6000, OMEGA, fine)
        order = log(norm2(coarse%omega(:, 300) - fine%omega(:, 6000))/norm2(finer%omega(:, 600) - fine%omega(:, 6000)))/log(2.0_dp)
        call check(error, order > 3.8_dp .and. order < 4.2_dp, 'the order is 4')
    end subroutine test_order

    !> Angular momentum in inertial axes and kinetic energy; the quaternion is kept at unit length.
    subroutine test_free_body(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: OMEGA(3) = [0.02_dp, -0.03_dp, 0.05_dp]
        type(model_trajectory_t) :: free
        real(dp) :: momentum(3)

        call fly(600, OMEGA, free)
        associate (first => free%omega(:, 0), last => free%omega(:, 600))
            call check(error, norm2(free%q(:, 600)), 1.0_dp, thr=1e-14_dp)
            momentum = matmul(matmul(TENSOR, last), rotation_matrix(free%q(:, 600))) - &
                       matmul(matmul(TENSOR, first), rotation_matrix(free%q(:, 0)))
            call check(error, norm2(momentum), 0.0_dp, thr=1e-9_dp*norm2(matmul(TENSOR, OMEGA)))
            call check(error, dot_product(last, matmul(TENSOR, last)), dot_product(OMEGA, matmul(TENSOR, OMEGA)), thr=1e-10_dp)
        end associate
    end subroutine test_free_body

    !> Lambda (4-11), (4-14), and J d omega/dt + omega x J omega = T, (2-16), (4-1), (4-7).
    subroutine test_partials(error)
        type(error_type), allocatable, intent(out) :: error
        type(rigid_body_t) :: body
        real(dp), parameter :: OMEGA(3) = [1e-3_dp, -2e-3_dp, 5e-4_dp], T(3) = [1e-4_dp, 2e-4_dp, -3e-4_dp]
        real(dp) :: change(3), differences(3, 3)
        integer :: i

        body = new_rigid_body(TENSOR)
        do i = 1, 3                         ! quadratic in omega: central differences are exact
            change = 0
            change(i) = 1e-3_dp
            differences(:, i) = (body%angular_acceleration(T, OMEGA + change) - &
                                 body%angular_acceleration(T, OMEGA - change))/2e-3_dp
        end do
        call check(error, maxval(abs(differences - body%rate_partials(OMEGA))), 0.0_dp, thr=1e-14_dp)
        call check(error, norm2(matmul(TENSOR, body%angular_acceleration(T, OMEGA)) + &
                                cross(OMEGA, matmul(TENSOR, OMEGA)) - T), 0.0_dp, thr=1e-16_dp)
    end subroutine test_partials
end module test_rigid_body
