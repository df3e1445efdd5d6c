!> Euler's equations of a rigid body, CSR-TM-00-01 (2-16), (4-1), (4-7).
module gracecg_estimation_rigid_body
    use gracecg_base_kinds, only: dp
    use gracecg_base_vectors, only: cross, cross_matrix, inverse_3x3
    implicit none
    private
    public :: rigid_body_t, new_rigid_body

    !> A rigid body.
    type :: rigid_body_t
        real(dp) :: inertia(3, 3) = 0           !! J, kg m^2
        real(dp) :: inverse_inertia(3, 3) = 0   !! 1/(kg m^2)
    contains
        procedure :: angular_acceleration   !! d omega/dt under a torque
        procedure :: rate_partials          !! Its partials by omega
    end type rigid_body_t

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

        lambda = -matmul(self%inverse_inertia, matmul(cross_matrix(omega), self%inertia) - &
                         cross_matrix(matmul(self%inertia, omega)))
    end function rate_partials
end module gracecg_estimation_rigid_body
