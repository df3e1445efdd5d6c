!> The dynamics that the report's estimators fit, CSR-TM-00-01 section 4.3: rigid-body rotation under the
!> magnetic torque alone, with its state transition matrix.
!>
!> The magnetic flux density is measured in body axes, so the torque m x B is a known function of
!> time; it is tabulated at every half step of the integration (gracecg_estimation_rigid_body).
module gracecg_estimation_attitude_fit
    use gracecg_base_kinds, only: dp
    use gracecg_base_vectors, only: cross_matrix, identity
    use gracecg_base_quaternion, only: quaternion_rate, rate_matrix
    use gracecg_estimation_rigid_body, only: rigid_body_t, rotation_t, new_rigid_body
    implicit none
    private
    public :: attitude_fit_t, fitted_rotation_t, fitted_attitude_t
    public :: new_attitude_fit, kinematic_partials

    !> What the rotation depends on.
    type :: attitude_fit_t
        integer :: steps = 0                        !! Number of integration steps n
        real(dp) :: interval = 0                    !! Step h, s
        type(rigid_body_t) :: body                  !! With J_p about the proof-mass centre
        real(dp), allocatable :: torque(:, :)       !! m x B in body axes at j h/2, (3, 0:2n), N m
    contains
        procedure :: angular_acceleration   !! d omega/dt of (4-7) under the rods' torque
        procedure :: fit_rotation           !! Integrates the rate with its partials
        procedure :: fit_attitude           !! The same and the attitude
    end type attitude_fit_t

    !> Angular velocity along the arc, at k h for k = 0..n.
    type :: fitted_rotation_t
        real(dp), allocatable :: omega(:, :)        !! (3, 0:n), body axes, rad/s
        real(dp), allocatable :: omega_dot(:, :)    !! (3, 0:n), rad/s^2
        real(dp), allocatable :: phi_22(:, :, :)    !! d omega(t)/d omega(t0), (3, 3, 0:n), eq. (4-55)
    end type fitted_rotation_t

    !> Attitude along the arc with its partials: of the quaternion (c = 4), or of small angles zeta that
    !> turn the nominal into the true attitude (c = 3).
    type :: fitted_attitude_t
        real(dp), allocatable :: q(:, :)            !! (4, 0:n)
        real(dp), allocatable :: phi_11(:, :, :)
        !! dq(t)/dq(t0), eq. (4-53), or d zeta(t)/d zeta(t0), eq. (4-65): (c, c, 0:n)
        real(dp), allocatable :: phi_12(:, :, :)
        !! dq(t)/d omega(t0), eq. (4-54), or d zeta(t)/d omega(t0), eq. (4-66): (c, 3, 0:n), s
    end type fitted_attitude_t

    integer, parameter :: Q_PLACE = 13, PHI_PLACE = 17  !! Where q and Phi_11, Phi_12 begin in the state

    !> The equations of one fit. State: omega, Phi_22, then q, Phi_11, Phi_12 if the attitude is wanted.
    type, extends(rotation_t) :: fitted_arc_t
        class(attitude_fit_t), pointer :: fit => null()
        integer :: components = 0                   !! c of the attitude: 4, 3 or, if it is not wanted, 0
        type(fitted_rotation_t), pointer :: rotation => null()
        type(fitted_attitude_t), pointer :: attitude => null()
    contains
        procedure :: rate => rate_of_fit
        procedure :: keep => keep_fit
    end type fitted_arc_t

contains

    !> Prepares the fitting dynamics; the arc starts at t = 0. J^-1 of (4-1) is J_p^-1, (4-4)-(4-6).
    function new_attitude_fit(inertia, interval, torque) result(fit)
        real(dp), intent(in) :: inertia(3, 3)   !! J_p, kg m^2
        real(dp), intent(in) :: interval        !! Step h, s
        real(dp), intent(in) :: torque(:, :)    !! m x B at 0, h/2, h, ... n h: (3, 2n + 1), N m
        type(attitude_fit_t) :: fit

        fit%steps = (size(torque, 2) - 1)/2
        fit%interval = interval
        fit%body = new_rigid_body(inertia)
        allocate (fit%torque(3, 0:2*fit%steps), source=torque)
    end function new_attitude_fit

    !> d omega/dt under m x B, eq. (4-7), at the half step `half`.
    pure function angular_acceleration(self, half, omega) result(omega_dot)
        class(attitude_fit_t), intent(in) :: self
        integer, intent(in) :: half         !! Time in half steps from the start
        real(dp), intent(in) :: omega(3)    !! rad/s
        real(dp) :: omega_dot(3)            !! rad/s^2

        omega_dot = self%body%angular_acceleration(self%torque(:, half), omega)
    end function angular_acceleration

    !> Gamma = d(dq/dt)/d omega, eqs. (4-13), (4-15).
    pure function kinematic_partials(q) result(gamma)
        real(dp), intent(in) :: q(4)    !! Inertial to body, scalar last
        real(dp) :: gamma(4, 3)

        gamma(:, 1) = 0.5_dp*[q(4), q(3), -q(2), -q(1)]
        gamma(:, 2) = 0.5_dp*[-q(3), q(4), q(1), -q(2)]
        gamma(:, 3) = 0.5_dp*[q(2), -q(1), q(4), -q(3)]
    end function kinematic_partials

    !> Integrates the angular velocity, (4-80), and its state transition matrix.
    subroutine fit_rotation(self, omega_0, rotation)
        class(attitude_fit_t), intent(in), target :: self
        real(dp), intent(in) :: omega_0(3)          !! At t = 0, rad/s
        type(fitted_rotation_t), intent(out), target :: rotation

        type(fitted_arc_t) :: arc

        call prepare_arc(self, rotation, arc)
        call arc%integrate([omega_0, identity(3)])
    end subroutine fit_rotation

    !> Integrates attitude and angular velocity with the whole state transition matrix, (4-50)-(4-56), (4-83),
    !> (4-84), (4-87)-(4-89), or, reduced, with that of small angles, (4-58), (4-59), (4-64)-(4-67), (4-92),
    !> (4-93), (4-96)-(4-99), whose sign of Pi is corrected: d zeta/dt = -Pi(omega*) zeta + d omega.
    subroutine fit_attitude(self, reduced, q_0, omega_0, attitude, rotation)
        class(attitude_fit_t), intent(in), target :: self
        logical, intent(in) :: reduced              !! Small angles in place of the quaternion's components
        real(dp), intent(in) :: q_0(4)              !! At t = 0, inertial to body
        real(dp), intent(in) :: omega_0(3)          !! At t = 0, rad/s
        type(fitted_attitude_t), intent(out), target :: attitude
        type(fitted_rotation_t), intent(out), target :: rotation

        type(fitted_arc_t) :: arc
        integer :: i

        call prepare_arc(self, rotation, arc)
        arc%components = merge(3, 4, reduced)
        arc%attitude => attitude
        associate (n => self%steps, c => arc%components)
            allocate (attitude%q(4, 0:n), attitude%phi_11(c, c, 0:n), attitude%phi_12(c, 3, 0:n))
            call arc%integrate([omega_0, identity(3), q_0, identity(c), (0.0_dp, i=1, 3*c)])
        end associate
    end subroutine fit_attitude

    subroutine prepare_arc(fit, rotation, arc)
        class(attitude_fit_t), intent(in), target :: fit
        type(fitted_rotation_t), intent(inout), target :: rotation
        type(fitted_arc_t), intent(inout) :: arc

        arc%steps = fit%steps
        arc%interval = fit%interval
        arc%fit => fit
        arc%rotation => rotation
        associate (n => fit%steps)
            allocate (rotation%omega(3, 0:n), rotation%omega_dot(3, 0:n), rotation%phi_22(3, 3, 0:n))
        end associate
    end subroutine prepare_arc

    !> The right-hand sides of (4-50), (4-51), (4-53)-(4-55) and (4-65)-(4-67): F of (4-45), and
    !> A Phi of (4-47) with the blocks of A (4-48) apart.
    pure subroutine rate_of_fit(self, half, n, y, dydt)
        class(fitted_arc_t), intent(in) :: self
        integer, intent(in) :: half, n
        real(dp), intent(in) :: y(n)
        real(dp), intent(out) :: dydt(n)

        call rotation_rates(self%fit%body, self%fit%torque(:, half), y(1), y(4), dydt(1), dydt(4))
        if (self%components == 0) return
        dydt(Q_PLACE:Q_PLACE + 3) = quaternion_rate(y(Q_PLACE:Q_PLACE + 3), y(1:3))
        if (self%components == 4) then
            call full_rates(y(1), y(Q_PLACE), y(4), y(PHI_PLACE), y(PHI_PLACE + 16), dydt(PHI_PLACE), &
                            dydt(PHI_PLACE + 16))
        else
            call small_angle_rates(y(1), y(4), y(PHI_PLACE), y(PHI_PLACE + 9), dydt(PHI_PLACE), &
                                   dydt(PHI_PLACE + 9))
        end if
    end subroutine rate_of_fit

    !> (4-7), (4-51), (4-59) and (4-55), (4-67), into which q does not enter, (4-10).
    pure subroutine rotation_rates(body, torque, omega, phi_22, omega_rate, phi_22_rate)
        type(rigid_body_t), intent(in) :: body
        real(dp), intent(in) :: torque(3), omega(3), phi_22(3, 3)
        real(dp), intent(out) :: omega_rate(3), phi_22_rate(3, 3)

        omega_rate = body%angular_acceleration(torque, omega)
        phi_22_rate = matmul(body%rate_partials(omega), phi_22)
    end subroutine rotation_rates

    !> (4-53), (4-54), with the partials (4-12), (4-13) of dq/dt, (4-8).
    pure subroutine full_rates(omega, q, phi_22, phi_11, phi_12, phi_11_rate, phi_12_rate)
        real(dp), intent(in) :: omega(3), q(4), phi_22(3, 3), phi_11(4, 4), phi_12(4, 3)
        real(dp), intent(out) :: phi_11_rate(4, 4), phi_12_rate(4, 3)

        real(dp) :: half_omega_matrix(4, 4)

        half_omega_matrix = rate_matrix(omega)/2
        phi_11_rate = matmul(half_omega_matrix, phi_11)
        phi_12_rate = matmul(half_omega_matrix, phi_12) + matmul(kinematic_partials(q), phi_22)
    end subroutine full_rates

    !> (4-65), (4-66), which follow from (4-64), with minus Pi.
    pure subroutine small_angle_rates(omega, phi_22, phi_11, phi_12, phi_11_rate, phi_12_rate)
        real(dp), intent(in) :: omega(3), phi_22(3, 3), phi_11(3, 3), phi_12(3, 3)
        real(dp), intent(out) :: phi_11_rate(3, 3), phi_12_rate(3, 3)

        real(dp) :: minus_pi(3, 3)

        minus_pi = -cross_matrix(omega)
        phi_11_rate = matmul(minus_pi, phi_11)
        phi_12_rate = matmul(minus_pi, phi_12) + phi_22
    end subroutine small_angle_rates

    subroutine keep_fit(self, k, n, y, dydt)
        class(fitted_arc_t), intent(inout) :: self
        integer, intent(in) :: k, n
        real(dp), intent(in) :: y(n), dydt(n)

        self%rotation%omega(:, k) = y(1:3)
        self%rotation%omega_dot(:, k) = dydt(1:3)
        call keep_matrix(3, 3, y(4), self%rotation%phi_22(:, :, k))
        associate (c => self%components)
            if (c == 0) return
            self%attitude%q(:, k) = y(Q_PLACE:Q_PLACE + 3)
            call keep_matrix(c, c, y(PHI_PLACE), self%attitude%phi_11(:, :, k))
            call keep_matrix(c, 3, y(PHI_PLACE + c*c), self%attitude%phi_12(:, :, k))
        end associate
    end subroutine keep_fit

    pure subroutine keep_matrix(rows, columns, values, matrix)
        integer, intent(in) :: rows, columns
        real(dp), intent(in) :: values(rows, columns)
        real(dp), intent(out) :: matrix(rows, columns)

        matrix = values
    end subroutine keep_matrix
end module gracecg_estimation_attitude_fit
