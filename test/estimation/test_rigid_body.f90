!> The rotation of a rigid body: order of the integration, conserved quantities, partials.
module test_rigid_body
    use gracecg_base_kinds, only: dp
    use gracecg_base_vectors, only: cross
    use gracecg_base_quaternion, only: quaternion_rate, rotation_matrix
    use gracecg_estimation_rigid_body, only: rigid_body_t, rotation_t, new_rigid_body
    use fixture, only: check
    use testdrive, only: new_unittest, unittest_type, error_type
    implicit none
    private
    public :: collect_rigid_body

    real(dp), parameter :: TENSOR(3, 3) = reshape([80.0_dp, 3.0_dp, -2.0_dp, 3.0_dp, 350.0_dp, 1.0_dp, &
                                                   -2.0_dp, 1.0_dp, 390.0_dp], [3, 3])

    !> dy/dt = t^power.
    type, extends(rotation_t) :: power_t
        integer :: power = 0
        real(dp) :: last = 0
    contains
        procedure :: rate => rate_of_power
        procedure :: keep => keep_power
    end type power_t

    !> A body without torque: q, omega.
    type, extends(rotation_t) :: free_t
        type(rigid_body_t) :: body
        real(dp), allocatable :: y(:, :)
    contains
        procedure :: rate => rate_of_free
        procedure :: keep => keep_free
    end type free_t

contains

    subroutine collect_rigid_body(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('integrates-cubes-exactly', test_order), &
                    new_unittest('free-body-keeps-momentum-and-energy', test_free_body), &
                    new_unittest('partials-equal-differences', test_partials)]
    end subroutine collect_rigid_body

    pure subroutine rate_of_power(self, half, n, y, dydt)
        class(power_t), intent(in) :: self
        integer, intent(in) :: half, n
        real(dp), intent(in) :: y(n)
        real(dp), intent(out) :: dydt(n)

        dydt = 0*y + (half*self%interval/2)**self%power
    end subroutine rate_of_power

    subroutine keep_power(self, k, n, y, dydt)
        class(power_t), intent(inout) :: self
        integer, intent(in) :: k, n
        real(dp), intent(in) :: y(n), dydt(n)

        if (k == self%steps .and. abs(dydt(n)) > 0) self%last = y(n)
    end subroutine keep_power

    pure subroutine rate_of_free(self, half, n, y, dydt)
        class(free_t), intent(in) :: self
        integer, intent(in) :: half, n
        real(dp), intent(in) :: y(n)
        real(dp), intent(out) :: dydt(n)

        real(dp), parameter :: NO_TORQUE(3) = 0

        dydt(1:4) = quaternion_rate(y(1:4), y(5:7))
        dydt(5:7) = self%body%angular_acceleration(half*NO_TORQUE, y(5:7))
    end subroutine rate_of_free

    subroutine keep_free(self, k, n, y, dydt)
        class(free_t), intent(inout) :: self
        integer, intent(in) :: k, n
        real(dp), intent(in) :: y(n), dydt(n)

        if (size(dydt) == n) self%y(:, k) = y
    end subroutine keep_free

    !> A method of order 4 integrates t^3 exactly, t^4 not.
    subroutine test_order(error)
        type(error_type), allocatable, intent(out) :: error
        type(power_t) :: system
        integer :: power

        do power = 0, 4
            system = power_t(steps=3, interval=0.5_dp, power=power)
            call system%integrate([2.0_dp])
            associate (wrong => abs(system%last - 2 - 1.5_dp**(power + 1)/(power + 1)))
                if (power < 4) call check(error, wrong, 0.0_dp, thr=1e-14_dp)
                if (power == 4) call check(error, wrong > 1e-5_dp, 'the order is 4')
            end associate
            if (allocated(error)) return
        end do
    end subroutine test_order

    !> Angular momentum in inertial axes and kinetic energy; the quaternion is kept at unit length.
    subroutine test_free_body(error)
        type(error_type), allocatable, intent(out) :: error
        type(free_t) :: free
        real(dp), parameter :: OMEGA(3) = [0.02_dp, -0.03_dp, 0.05_dp]
        real(dp) :: momentum(3)

        free = free_t(steps=600, interval=0.1_dp, quaternion=1, body=new_rigid_body(TENSOR))
        allocate (free%y(7, 0:600))
        call free%integrate([0.1_dp, -0.5_dp, 0.1_dp, sqrt(0.73_dp), OMEGA])
        associate (last => free%y(:, 600), first => free%y(:, 0))
            call check(error, norm2(last(1:4)), 1.0_dp, thr=1e-14_dp)
            momentum = matmul(matmul(TENSOR, last(5:7)), rotation_matrix(last(1:4))) - &
                       matmul(matmul(TENSOR, first(5:7)), rotation_matrix(first(1:4)))
            call check(error, norm2(momentum), 0.0_dp, thr=1e-9_dp*norm2(matmul(TENSOR, OMEGA)))
            call check(error, dot_product(last(5:7), matmul(TENSOR, last(5:7))), &
                       dot_product(OMEGA, matmul(TENSOR, OMEGA)), thr=1e-10_dp)
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
