!> The dynamics that the estimators fit, CSR-TM-00-01 section 4.3: rigid-body rotation under the
!> magnetic torque alone, with its state transition matrix.
!>
!> The magnetic flux density is measured in body axes, so the torque m x B is a known function of
!> time; it is tabulated at every half step of the integration (classical Runge-Kutta of order 4).
module gracecg_estimation_attitude_fit
    use gracecg_base_kinds, only: dp
    use gracecg_base_vectors, only: cross, cross_matrix, inverse_3x3, identity
    use gracecg_base_quaternion, only: quaternion_rate, rate_matrix
    implicit none
    private
    public :: attitude_fit_t, fitted_rotation_t, fitted_attitude_t, fitted_small_angles_t
    public :: new_attitude_fit, kinematic_partials

    !> What is integrated beside the angular velocity and its transition matrix
    integer, parameter :: NOTHING_ELSE = 0, FULL_ATTITUDE = 1, SMALL_ANGLES = 2

    !> What the rotation depends on.
    type :: attitude_fit_t
        integer :: steps = 0                        !! Number of integration steps n
        real(dp) :: interval = 0                    !! Step h, s
        real(dp) :: inertia(3, 3) = 0               !! J_p about the proof-mass centre, kg m^2
        real(dp) :: inverse_inertia(3, 3) = 0       !! 1/(kg m^2)
        real(dp), allocatable :: torque(:, :)       !! m x B in body axes at j h/2, (3, 0:2n), N m
    contains
        procedure :: angular_acceleration   !! d omega/dt of (4-4) under the rods' torque
        procedure :: rate_partials          !! Partials of the angular acceleration
        procedure :: fit_rotation           !! Integrates attitude and rate with all partials
        procedure :: fit_attitude           !! The state's integration, quaternion as attitude
        procedure :: fit_small_angles       !! The same, small angles as attitude
    end type attitude_fit_t

    !> Angular velocity along the arc, at k h for k = 0..n.
    type :: fitted_rotation_t
        real(dp), allocatable :: omega(:, :)        !! (3, 0:n), body axes, rad/s
        real(dp), allocatable :: omega_dot(:, :)    !! (3, 0:n), rad/s^2
        real(dp), allocatable :: phi_22(:, :, :)    !! d omega(t)/d omega(t0), (3, 3, 0:n), eq. (4-55)
    end type fitted_rotation_t

    !> Attitude quaternion along the arc with its partials.
    type :: fitted_attitude_t
        real(dp), allocatable :: q(:, :)            !! (4, 0:n)
        real(dp), allocatable :: phi_11(:, :, :)    !! dq(t)/dq(t0), (4, 4, 0:n), eq. (4-53)
        real(dp), allocatable :: phi_12(:, :, :)    !! dq(t)/d omega(t0), (4, 3, 0:n), eq. (4-54), s
    end type fitted_attitude_t

    !> Attitude along the arc with the partials of small angles zeta that turn the nominal into the
    !> true attitude.
    type :: fitted_small_angles_t
        real(dp), allocatable :: q(:, :)            !! (4, 0:n)
        real(dp), allocatable :: phi_11(:, :, :)    !! d zeta(t)/d zeta(t0), (3, 3, 0:n), eq. (4-65)
        real(dp), allocatable :: phi_12(:, :, :)    !! d zeta(t)/d omega(t0), (3, 3, 0:n), eq. (4-66), s
    end type fitted_small_angles_t

    !> What is integrated together, or its derivative; the parts that are not wanted stay zero.
    type :: bundle_t
        real(dp) :: q(4) = 0, omega(3) = 0, phi_22(3, 3) = 0
        real(dp) :: phi_11(4, 4) = 0, phi_12(4, 3) = 0          ! full attitude
        real(dp) :: zeta_11(3, 3) = 0, zeta_12(3, 3) = 0        ! small angles
    end type bundle_t

contains

    !> Prepares the fitting dynamics; the arc starts at t = 0.
    function new_attitude_fit(inertia, interval, torque) result(fit)
        real(dp), intent(in) :: inertia(3, 3)   !! J_p, kg m^2
        real(dp), intent(in) :: interval        !! Step h, s
        real(dp), intent(in) :: torque(:, :)    !! m x B at 0, h/2, h, ... n h: (3, 2n + 1), N m
        type(attitude_fit_t) :: fit

        fit%steps = (size(torque, 2) - 1)/2
        fit%interval = interval
        fit%inertia = inertia
        fit%inverse_inertia = inverse_3x3(inertia)
        allocate (fit%torque(3, 0:2*fit%steps), source=torque)
    end function new_attitude_fit

    !> d omega/dt = J_p^-1 (m x B - omega x (J_p omega)), eq. (4-7), at the half step `half`.
    pure function angular_acceleration(self, half, omega) result(omega_dot)
        class(attitude_fit_t), intent(in) :: self
        integer, intent(in) :: half         !! Time in half steps from the start
        real(dp), intent(in) :: omega(3)    !! rad/s
        real(dp) :: omega_dot(3)            !! rad/s^2

        omega_dot = matmul(self%inverse_inertia, &
                           self%torque(:, half) - cross(omega, matmul(self%inertia, omega)))
    end function angular_acceleration

    !> Lambda = d(d omega/dt)/d omega = -J_p^-1 [Pi(omega) J_p - Pi(J_p omega)], eqs. (4-11), (4-14).
    pure function rate_partials(self, omega) result(lambda)
        class(attitude_fit_t), intent(in) :: self
        real(dp), intent(in) :: omega(3)    !! rad/s
        real(dp) :: lambda(3, 3)            !! 1/s

        lambda = -matmul(self%inverse_inertia, matmul(cross_matrix(omega), self%inertia) - &
                         cross_matrix(matmul(self%inertia, omega)))
    end function rate_partials

    !> Gamma = d(dq/dt)/d omega, eqs. (4-13), (4-15).
    pure function kinematic_partials(q) result(gamma)
        real(dp), intent(in) :: q(4)    !! Inertial to body, scalar last
        real(dp) :: gamma(4, 3)

        gamma(:, 1) = 0.5_dp*[q(4), q(3), -q(2), -q(1)]
        gamma(:, 2) = 0.5_dp*[-q(3), q(4), q(1), -q(2)]
        gamma(:, 3) = 0.5_dp*[q(2), -q(1), q(4), -q(3)]
    end function kinematic_partials

    !> Integrates the angular velocity and its state transition matrix.
    subroutine fit_rotation(self, omega_0, rotation)
        class(attitude_fit_t), intent(in) :: self
        real(dp), intent(in) :: omega_0(3)          !! At t = 0, rad/s
        type(fitted_rotation_t), intent(out) :: rotation

        type(bundle_t) :: state
        integer :: k

        call allocate_rotation(self%steps, rotation)
        state = initial_bundle([0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], omega_0)
        call store_rotation(self, 0, state, rotation)
        do k = 1, self%steps
            call advance(self, k - 1, NOTHING_ELSE, state)
            call store_rotation(self, k, state, rotation)
        end do
    end subroutine fit_rotation

    !> Integrates attitude and angular velocity with the whole state transition matrix, (4-50)-(4-56).
    subroutine fit_attitude(self, q_0, omega_0, attitude, rotation)
        class(attitude_fit_t), intent(in) :: self
        real(dp), intent(in) :: q_0(4)              !! At t = 0, inertial to body
        real(dp), intent(in) :: omega_0(3)          !! At t = 0, rad/s
        type(fitted_attitude_t), intent(out) :: attitude
        type(fitted_rotation_t), intent(out) :: rotation

        type(bundle_t) :: state
        integer :: k, n

        n = self%steps
        call allocate_rotation(n, rotation)
        allocate (attitude%q(4, 0:n), attitude%phi_11(4, 4, 0:n), attitude%phi_12(4, 3, 0:n))
        state = initial_bundle(q_0, omega_0)
        do k = 0, n
            if (k > 0) call advance(self, k - 1, FULL_ATTITUDE, state)
            attitude%q(:, k) = state%q
            attitude%phi_11(:, :, k) = state%phi_11
            attitude%phi_12(:, :, k) = state%phi_12
            call store_rotation(self, k, state, rotation)
        end do
    end subroutine fit_attitude

    !> Integrates attitude and angular velocity with the transition matrix of the reduced state,
    !> (4-58), (4-59), (4-65)-(4-67), whose sign of Pi is corrected: d zeta/dt = -Pi(omega*) zeta + d omega.
    subroutine fit_small_angles(self, q_0, omega_0, attitude, rotation)
        class(attitude_fit_t), intent(in) :: self
        real(dp), intent(in) :: q_0(4)              !! At t = 0, inertial to body
        real(dp), intent(in) :: omega_0(3)          !! At t = 0, rad/s
        type(fitted_small_angles_t), intent(out) :: attitude
        type(fitted_rotation_t), intent(out) :: rotation

        type(bundle_t) :: state
        integer :: k, n

        n = self%steps
        call allocate_rotation(n, rotation)
        allocate (attitude%q(4, 0:n), attitude%phi_11(3, 3, 0:n), attitude%phi_12(3, 3, 0:n))
        state = initial_bundle(q_0, omega_0)
        do k = 0, n
            if (k > 0) call advance(self, k - 1, SMALL_ANGLES, state)
            attitude%q(:, k) = state%q
            attitude%phi_11(:, :, k) = state%zeta_11
            attitude%phi_12(:, :, k) = state%zeta_12
            call store_rotation(self, k, state, rotation)
        end do
    end subroutine fit_small_angles

    subroutine allocate_rotation(n, rotation)
        integer, intent(in) :: n
        type(fitted_rotation_t), intent(out) :: rotation

        allocate (rotation%omega(3, 0:n), rotation%omega_dot(3, 0:n), rotation%phi_22(3, 3, 0:n))
    end subroutine allocate_rotation

    subroutine store_rotation(self, k, state, rotation)
        type(attitude_fit_t), intent(in) :: self
        integer, intent(in) :: k
        type(bundle_t), intent(in) :: state
        type(fitted_rotation_t), intent(inout) :: rotation

        rotation%omega(:, k) = state%omega
        rotation%omega_dot(:, k) = self%angular_acceleration(2*k, state%omega)
        rotation%phi_22(:, :, k) = state%phi_22
    end subroutine store_rotation

    pure function initial_bundle(q_0, omega_0) result(state)
        real(dp), intent(in) :: q_0(4), omega_0(3)
        type(bundle_t) :: state

        state%q = q_0
        state%omega = omega_0
        state%phi_22 = identity(3)
        state%phi_11 = identity(4)
        state%zeta_11 = identity(3)
    end function initial_bundle

    !> One step of the classical Runge-Kutta method from step k.
    pure subroutine advance(self, k, more, state)
        type(attitude_fit_t), intent(in) :: self
        integer, intent(in) :: k
        integer, intent(in) :: more     !! NOTHING_ELSE, FULL_ATTITUDE or SMALL_ANGLES
        type(bundle_t), intent(inout) :: state

        type(bundle_t) :: k1, k2, k3, k4

        call derivative(self, 2*k, more, state, k1)
        call derivative(self, 2*k + 1, more, shifted(state, k1, self%interval/2), k2)
        call derivative(self, 2*k + 1, more, shifted(state, k2, self%interval/2), k3)
        call derivative(self, 2*k + 2, more, shifted(state, k3, self%interval), k4)
        state = shifted(shifted(shifted(shifted(state, k1, self%interval/6), &
                                        k2, self%interval/3), k3, self%interval/3), k4, self%interval/6)
    end subroutine advance

    !> The right-hand sides of (4-50), (4-51), (4-53)-(4-55) and (4-65)-(4-67).
    pure subroutine derivative(self, half, more, state, rate)
        type(attitude_fit_t), intent(in) :: self
        integer, intent(in) :: half
        integer, intent(in) :: more
        type(bundle_t), intent(in) :: state
        type(bundle_t), intent(out) :: rate

        real(dp) :: half_omega_matrix(4, 4), minus_pi(3, 3)

        rate%omega = self%angular_acceleration(half, state%omega)
        rate%phi_22 = matmul(self%rate_partials(state%omega), state%phi_22)
        if (more == NOTHING_ELSE) return
        rate%q = quaternion_rate(state%q, state%omega)
        if (more == FULL_ATTITUDE) then
            half_omega_matrix = rate_matrix(state%omega)/2
            rate%phi_11 = matmul(half_omega_matrix, state%phi_11)
            rate%phi_12 = matmul(half_omega_matrix, state%phi_12) + &
                          matmul(kinematic_partials(state%q), state%phi_22)
        else
            minus_pi = -cross_matrix(state%omega)
            rate%zeta_11 = matmul(minus_pi, state%zeta_11)
            rate%zeta_12 = matmul(minus_pi, state%zeta_12) + state%phi_22
        end if
    end subroutine derivative

    !> state + h rate
    pure function shifted(state, rate, h) result(sum)
        type(bundle_t), intent(in) :: state, rate
        real(dp), intent(in) :: h
        type(bundle_t) :: sum

        sum%q = state%q + h*rate%q
        sum%omega = state%omega + h*rate%omega
        sum%phi_22 = state%phi_22 + h*rate%phi_22
        sum%phi_11 = state%phi_11 + h*rate%phi_11
        sum%phi_12 = state%phi_12 + h*rate%phi_12
        sum%zeta_11 = state%zeta_11 + h*rate%zeta_11
        sum%zeta_12 = state%zeta_12 + h*rate%zeta_12
    end function shifted
end module gracecg_estimation_attitude_fit
