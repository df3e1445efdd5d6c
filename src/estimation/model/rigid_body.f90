!> The rotation of a rigid body along an arc: Euler's equations, CSR-TM-00-01 (2-16), (4-1), (4-7), and their
!> integration by the classical Runge-Kutta method of order 4 with one step a sampling interval, so
!> that torques are needed at half steps only.
!>
!> What is integrated beside the angular velocity (attitude, variational equations) and what is kept of it
!> is said by an extension of `rotation_t`.
module gracecg_estimation_rigid_body
    use gracecg_base_kinds, only: dp
    use gracecg_base_vectors, only: cross, cross_matrix, inverse_3x3
    implicit none
    private
    public :: rigid_body_t, rotation_t, new_rigid_body

    !> A rigid body.
    type :: rigid_body_t
        real(dp) :: inertia(3, 3) = 0           !! J, kg m^2
        real(dp) :: inverse_inertia(3, 3) = 0   !! 1/(kg m^2)
    contains
        procedure :: angular_acceleration   !! d omega/dt under a torque
        procedure :: rate_partials          !! Its partials by omega
    end type rigid_body_t

    !> Equations of a rotation. Epochs are k h, k = 0..n; half steps are j h/2.
    type, abstract :: rotation_t
        integer :: steps = 0            !! n
        real(dp) :: interval = 0        !! h, s
        integer :: quaternion = 0
        !! Place in the state of a quaternion that is brought back to unit length after every step; 0: none
    contains
        procedure(rate_interface), deferred :: rate     !! Right-hand side of the equations
        procedure(keep_interface), deferred :: keep     !! Takes what is wanted of an epoch
        procedure :: integrate                          !! From the first epoch to the last
    end type rotation_t

    abstract interface
        !> The derivative of the state at a half step.
        pure subroutine rate_interface(self, half, n, y, dydt)
            import :: rotation_t, dp
            class(rotation_t), intent(in) :: self
            integer, intent(in) :: half         !! Time in half steps from the start
            integer, intent(in) :: n            !! Size of the state
            real(dp), intent(in) :: y(n)        !! State
            real(dp), intent(out) :: dydt(n)    !! Its derivative, 1/s
        end subroutine rate_interface

        !> Takes what is wanted of an epoch.
        subroutine keep_interface(self, k, n, y, dydt)
            import :: rotation_t, dp
            class(rotation_t), intent(inout) :: self
            integer, intent(in) :: k            !! The epoch, in steps from the start
            integer, intent(in) :: n            !! Size of the state
            real(dp), intent(in) :: y(n)        !! State
            real(dp), intent(in) :: dydt(n)     !! Its derivative, 1/s
        end subroutine keep_interface
    end interface

contains

    !> A body of a given inertia.
    pure function new_rigid_body(inertia) result(body)
        real(dp), intent(in) :: inertia(3, 3)   !! J, kg m^2
        type(rigid_body_t) :: body

        body%inertia = inertia
        body%inverse_inertia = inverse_3x3(inertia)
    end function new_rigid_body

    !> d omega/dt = J^-1 (T - omega x (J omega)), eqs. (4-1), (4-7).
    pure function angular_acceleration(self, torque, omega) result(omega_dot)
        class(rigid_body_t), intent(in) :: self
        real(dp), intent(in) :: torque(3)   !! T, body axes, N m
        real(dp), intent(in) :: omega(3)    !! Body axes, rad/s
        real(dp) :: omega_dot(3)            !! rad/s^2

        omega_dot = matmul(self%inverse_inertia, torque - cross(omega, matmul(self%inertia, omega)))
    end function angular_acceleration

    !> Lambda = d(d omega/dt)/d omega = -J^-1 [Pi(omega) J - Pi(J omega)], eqs. (4-11), (4-14).
    pure function rate_partials(self, omega) result(lambda)
        class(rigid_body_t), intent(in) :: self
        real(dp), intent(in) :: omega(3)    !! Body axes, rad/s
        real(dp) :: lambda(3, 3)            !! 1/s

        real(dp) :: by_momentum(3, 3), by_omega(3, 3), change(3)
        integer :: k

        by_momentum = cross_matrix(self%inertia(:, 1)*omega(1) + self%inertia(:, 2)*omega(2) + self%inertia(:, 3)*omega(3))
        by_omega = cross_matrix(omega)
        do k = 1, 3         ! column by column: what a change about one axis does
            change = by_momentum(:, k) - (by_omega(:, 1)*self%inertia(1, k) + by_omega(:, 2)*self%inertia(2, k) + &
                                          by_omega(:, 3)*self%inertia(3, k))
            lambda(:, k) = self%inverse_inertia(:, 1)*change(1) + self%inverse_inertia(:, 2)*change(2) + &
                           self%inverse_inertia(:, 3)*change(3)
        end do
    end function rate_partials

    !> Integrates from epoch 0 to the last one, and hands every epoch to `keep`.
    subroutine integrate(self, initial)
        class(rotation_t), intent(inout) :: self
        real(dp), intent(in) :: initial(:)      !! State at epoch 0

        real(dp), parameter :: PART(2:4) = [0.5_dp, 0.5_dp, 1.0_dp]     ! of the step
        integer, parameter :: LATER(2:4) = [1, 1, 2]                    ! half steps
        real(dp) :: y(size(initial)), stage(size(initial)), slope(size(initial), 4)
        integer :: k, i, n

        n = size(initial)
        y = initial
        do k = 0, self%steps
            call self%rate(2*k, n, y, slope(:, 1))
            call self%keep(k, n, y, slope(:, 1))
            if (k == self%steps) exit
            do i = 2, 4
                stage = y + self%interval*PART(i)*slope(:, i - 1)
                call self%rate(2*k + LATER(i), n, stage, slope(:, i))
            end do
            y = y + self%interval/6*slope(:, 1) + self%interval/3*slope(:, 2) + self%interval/3*slope(:, 3) + &
                self%interval/6*slope(:, 4)
            if (self%quaternion > 0) then
                associate (q => y(self%quaternion:self%quaternion + 3))
                    q = q/norm2(q)
                end associate
            end if
        end do
    end subroutine integrate
end module gracecg_estimation_rigid_body
