!> The dynamics that the report's estimators fit, CSR-TM-00-01 section 4.3: rigid-body rotation under the
!> magnetic torque alone, with its state transition matrix.
!>
!> The magnetic flux density is measured in body axes, so the torque m x B is a known function of time; it is
!> tabulated at every half step of the integration, by the classical Runge-Kutta method of order 4.
!>
!> Three things make the equations short. Lambda of (4-11), (4-14) is linear in omega, and what omega does to itself
!> in Euler's equations (4-7) is quadratic: it is Lambda omega/2, so that omega is one more column beside Phi_22. The
!> quaternion's equation (4-8) is linear: q(t) is a quaternion p(t) times q(t0), which holds for every Runge-Kutta
!> step as well, and dq(t)/dq(t0) is the matrix of p. And dq = Gamma(q) zeta: the partials by omega(t0) are those
!> of the small angles.
module gracecg_estimation_attitude_fit
    use gracecg_base_kinds, only: dp
    use gracecg_base_vectors, only: identity
    use gracecg_base_quaternion, only: quaternion_rate, quaternion_product, conjugate_quaternion, rate_matrix, &
        rotation_matrix, normalised
    use gracecg_estimation_rigid_body, only: rigid_body_t, new_rigid_body
    implicit none
    private
    public :: attitude_fit_t, fitted_rotation_t, new_attitude_fit, kinematic_partials

    !> What the rotation depends on.
    type :: attitude_fit_t
        integer :: steps = 0                        !! Number of integration steps n
        real(dp) :: interval = 0                    !! Step h, s
        type(rigid_body_t) :: body                  !! With J_p about the proof-mass centre
        real(dp), allocatable :: driven(:, :)       !! J^-1 (m x B) in body axes at j h/2, (3, 0:2n), rad/s^2
        real(dp), private :: lambda_by_rate(3, 3, 3) = 0    ! d Lambda/d omega_i, no unit
    contains
        procedure :: integrate                      !! From the epoch to the end of the arc
    end type attitude_fit_t

    !> Attitude and angular velocity with their partials along the arc, at k h for k = 0..n.
    type :: fitted_rotation_t
        real(dp), allocatable :: q(:, :)            !! (4, 0:n), inertial to body
        real(dp), allocatable :: omega(:, :)        !! (3, 0:n), body axes, rad/s
        real(dp), allocatable :: omega_dot(:, :)    !! (3, 0:n), rad/s^2
        real(dp), allocatable :: phi_22(:, :, :)    !! d omega(t)/d omega(t0), (3, 3, 0:n), eq. (4-55)
        real(dp), allocatable :: angles(:, :, :)
        !! d zeta(t)/d omega(t0), eq. (4-66), of small angles zeta that turn the nominal into the true attitude:
        !! (3, 3, 0:n), s
    contains
        procedure :: quaternion_transition  !! Phi_11 and Phi_12 of the quaternion
        procedure :: angle_transition       !! Phi_11 and Phi_12 of small angles
    end type fitted_rotation_t

    !> Columns of the state. Its rows are four lanes, which the processor's vector instructions take two or four at a
    !> time: the first belongs to omega, the others to the columns of the partials.
    integer, parameter :: LANES = 4
    integer, parameter :: RATE(3) = [1, 2, 3]       ! omega and the rows of Phi_22
    integer, parameter :: QUATERNION = 4
    integer, parameter :: ANGLE(3) = [5, 6, 7]      ! rows of d zeta/d omega(t0); the first lane has no meaning
    integer, parameter :: COLUMNS = 7

contains

    !> Prepares the fitting dynamics; the arc starts at t = 0. J^-1 of (4-1) is J_p^-1, (4-4)-(4-6).
    function new_attitude_fit(inertia, interval, torque) result(fit)
        real(dp), intent(in) :: inertia(3, 3)   !! J_p, kg m^2
        real(dp), intent(in) :: interval        !! Step h, s
        real(dp), intent(in) :: torque(:, :)    !! m x B at 0, h/2, h, ... n h: (3, 2n + 1), N m
        type(attitude_fit_t) :: fit

        real(dp) :: unit(3, 3)
        integer :: i

        fit%steps = (size(torque, 2) - 1)/2
        fit%interval = interval
        fit%body = new_rigid_body(inertia)
        allocate (fit%driven(3, 0:2*fit%steps))
        fit%driven = matmul(fit%body%inverse_inertia, torque)
        unit = identity(3)
        do i = 1, 3
            fit%lambda_by_rate(:, :, i) = fit%body%rate_partials(unit(:, i))
        end do
    end function new_attitude_fit

    !> Gamma = d(dq/dt)/d omega, eqs. (4-13), (4-15).
    pure function kinematic_partials(q) result(gamma)
        real(dp), intent(in) :: q(4)    !! Inertial to body, scalar last
        real(dp) :: gamma(4, 3)

        gamma(:, 1) = 0.5_dp*[q(4), q(3), -q(2), -q(1)]
        gamma(:, 2) = 0.5_dp*[-q(3), q(4), q(1), -q(2)]
        gamma(:, 3) = 0.5_dp*[q(2), -q(1), q(4), -q(3)]
    end function kinematic_partials

    !> dq(t)/dq(t0) (4-53) and dq(t)/d omega(t0) (4-54) at epoch k, which (4-12) and (4-13) would carry on.
    pure function quaternion_transition(self, k) result(phi)
        class(fitted_rotation_t), intent(in) :: self
        integer, intent(in) :: k        !! Epoch
        real(dp) :: phi(4, 7)           !! Phi_11, and Phi_12 in s

        real(dp) :: p(4)
        integer :: i

        associate (q_0 => self%q(:, 0), q => self%q(:, k))
            p = quaternion_product(q, conjugate_quaternion(q_0))/dot_product(q_0, q_0)
            phi(:, :4) = rate_matrix(p(1:3))
            do i = 1, 4
                phi(i, i) = p(4)
            end do
            do i = 1, 3         ! Gamma(q) zeta
                phi(:, 4 + i) = quaternion_rate(q, self%angles(:, i, k))
            end do
        end associate
    end function quaternion_transition

    !> d zeta(t)/d zeta(t0) (4-65), which turns with the body, and d zeta(t)/d omega(t0) (4-66) at epoch k.
    pure function angle_transition(self, k) result(phi)
        class(fitted_rotation_t), intent(in) :: self
        integer, intent(in) :: k        !! Epoch
        real(dp) :: phi(3, 6)           !! Phi_11, and Phi_12 in s

        real(dp) :: now(3, 3), then(3, 3)

        now = rotation_matrix(normalised(self%q(:, k)))
        then = rotation_matrix(normalised(self%q(:, 0)))
        phi(:, :3) = matmul(now, transpose(then))
        phi(:, 4:) = self%angles(:, :, k)
    end function angle_transition

    !> Integrates attitude and angular velocity, (4-80), with the whole state transition matrix, (4-50)-(4-56), (4-83),
    !> (4-84), (4-87)-(4-89), that of small angles, (4-58), (4-59), (4-64)-(4-67), (4-92), (4-93), (4-96)-(4-99),
    !> among it, whose sign of Pi is corrected: d zeta/dt = -Pi(omega*) zeta + d omega. The classical Runge-Kutta method of
    !> order 4, one step an interval.
    subroutine integrate(self, q_0, omega_0, rotation)
        class(attitude_fit_t), intent(in) :: self
        real(dp), intent(in) :: q_0(4)              !! At t = 0, inertial to body
        real(dp), intent(in) :: omega_0(3)          !! At t = 0, rad/s
        type(fitted_rotation_t), intent(out) :: rotation

        real(dp), dimension(LANES, COLUMNS) :: y, slope_1, slope_2, slope_3, slope_4
        real(dp) :: h
        integer :: k, i

        associate (n => self%steps)
            allocate (rotation%q(4, 0:n), rotation%omega(3, 0:n), rotation%omega_dot(3, 0:n), rotation%phi_22(3, 3, 0:n), &
                      rotation%angles(3, 3, 0:n))
        end associate
        h = self%interval
        y = 0
        y(1, RATE) = omega_0
        y(2:4, RATE) = identity(3)
        y(:, QUATERNION) = q_0
        do k = 0, self%steps
            call rates(self%lambda_by_rate, self%driven(:, 2*k), y, slope_1)
            rotation%q(:, k) = y(:, QUATERNION)
            rotation%omega(:, k) = y(1, RATE)
            rotation%omega_dot(:, k) = slope_1(1, RATE)
            do i = 1, 3
                rotation%phi_22(:, i, k) = y(1 + i, RATE)
                rotation%angles(:, i, k) = y(1 + i, ANGLE)
            end do
            if (k == self%steps) exit
            call rates(self%lambda_by_rate, self%driven(:, 2*k + 1), y + h/2*slope_1, slope_2)
            call rates(self%lambda_by_rate, self%driven(:, 2*k + 1), y + h/2*slope_2, slope_3)
            call rates(self%lambda_by_rate, self%driven(:, 2*k + 2), y + h*slope_3, slope_4)
            y = y + h/6*slope_1 + h/3*slope_2 + h/3*slope_3 + h/6*slope_4
        end do
    end subroutine integrate

    !> The right-hand sides of (4-50), (4-51), (4-55) and (4-66), (4-67): F of (4-45), and A Phi of (4-47) with the
    !> blocks of A (4-48) apart, of which (4-10) is zero. Some 110 operations on four lanes, 28 reals in and out: what is
    !> read stays in the nearest cache, so the multiplier sets the pace.
    pure subroutine rates(lambda_by_rate, driven, y, dydt)
        real(dp), intent(in) :: lambda_by_rate(3, 3, 3), driven(3)
        real(dp), intent(in) :: y(LANES, COLUMNS)
        real(dp), intent(out) :: dydt(LANES, COLUMNS)

        real(dp) :: lambda(3, 3), omega(3)
        integer :: i

        omega = y(1, RATE)
        lambda = lambda_by_rate(:, :, 1)*omega(1) + lambda_by_rate(:, :, 2)*omega(2) + lambda_by_rate(:, :, 3)*omega(3)
        do i = 1, 3
            dydt(:, i) = lambda(i, 1)*y(:, 1) + lambda(i, 2)*y(:, 2) + lambda(i, 3)*y(:, 3)
            dydt(1, i) = dydt(1, i)/2 + driven(i)
        end do
        dydt(:, QUATERNION) = quaternion_rate(y(:, QUATERNION), omega)
        dydt(:, 5) = y(:, 1) + omega(3)*y(:, 6) - omega(2)*y(:, 7)
        dydt(:, 6) = y(:, 2) + omega(1)*y(:, 7) - omega(3)*y(:, 5)
        dydt(:, 7) = y(:, 3) + omega(2)*y(:, 5) - omega(1)*y(:, 6)
    end subroutine rates
end module gracecg_estimation_attitude_fit
