!> The rotation of the physical model (gracecg_estimation_physical_model), and its partials by the parameters.
module gracecg_estimation_model_rotation
    use gracecg_base_kinds, only: dp
    use gracecg_base_lanes, only: lanes_of, lanes_carry
    use gracecg_base_quaternion, only: quaternion_rate
    use gracecg_observations_parameters
    use gracecg_estimation_rigid_body, only: rigid_body_t, new_rigid_body
    use gracecg_estimation_model_state, only: physical_model_t, model_state_t, model_trajectory_t
    implicit none
    private
    public :: integrate_trajectory, turned_into, add_cross_matrix

    !> Rows and columns of the elements of INERTIA
    integer, parameter :: ELEMENT_ROW(6) = [1, 2, 3, 1, 2, 3], ELEMENT_COLUMN(6) = [1, 2, 3, 2, 3, 1]

    integer, parameter :: PIECE_LENGTH = 32     !! Steps over which partials are carried at once

contains

    !> The body with the state's inertia errors.
    pure function body_of(model, state) result(body)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(rigid_body_t) :: body

        real(dp) :: tensor(3, 3)
        integer :: i

        tensor = model%inertia
        do i = 1, 6
            tensor = tensor + state%value(INERTIA(i))*unit_inertia(i)
        end do
        body = new_rigid_body(tensor)
    end function body_of

    !> dJ/dp of element i of INERTIA.
    pure function unit_inertia(i) result(j)
        integer, intent(in) :: i
        real(dp) :: j(3, 3)

        j = 0
        j(ELEMENT_ROW(i), ELEMENT_COLUMN(i)) = 1
        j(ELEMENT_COLUMN(i), ELEMENT_ROW(i)) = 1
    end function unit_inertia

    !> Integrates the nominal rotation, by the classical Runge-Kutta method of order 4 with one step a sampling interval, so
    !> that torques are needed at half steps only, and the variational equations; without partials, the rotation alone.
    subroutine integrate_trajectory(model, state, trajectory, without_partials, goes_on)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(inout) :: trajectory   !! Reused if it has the right shape
        logical, intent(in), optional :: without_partials       !! None are integrated
        logical, intent(in), optional :: goes_on
        !! The partials at epoch 0 stand in the trajectory: they are by what was at an earlier epoch

        real(dp), parameter :: PART(2:4) = [0.5_dp, 0.5_dp, 1.0_dp]     ! of the step
        integer, parameter :: LATER(2:4) = [1, 1, 2]                    ! half steps
        type(rigid_body_t) :: body
        real(dp) :: y(7), slope(7, 4)           ! q, omega
        integer :: parameters, k, i

        parameters = size(model%rotational)
        if (present(without_partials)) parameters = merge(0, parameters, without_partials)
        call shape_trajectory(model%steps, lanes_of(parameters), trajectory)
        body = body_of(model, state)
        y = [state%quaternion, state%value(RATE)]
        do k = 0, model%steps
            slope(:, 1) = nominal_rate(model, state, body, 2*k, y)
            trajectory%q(:, k) = y(:4)
            trajectory%omega(:, k) = y(5:)
            trajectory%omega_dot(:, k) = slope(5:, 1)
            if (size(model%jump_torque) > 0) trajectory%omega_dot(:, k) = slope(5:, 1) + &
                times(body%inverse_inertia, matmul(model%jump_torque(:, :, k), 1 + state%value(ROD_GAINS)))
            if (k == model%steps) exit
            do i = 2, 4
                slope(:, i) = nominal_rate(model, state, body, 2*k + LATER(i), y + model%interval*PART(i)*slope(:, i - 1))
            end do
            y = y + model%interval/6*slope(:, 1) + model%interval/3*slope(:, 2) + model%interval/3*slope(:, 3) + &
                model%interval/6*slope(:, 4)
            y(:4) = y(:4)/norm2(y(:4))
        end do
        if (parameters > 0) call carry_partials(model, state, body, trajectory, goes_on)
    end subroutine integrate_trajectory

    !> Right-hand side of the equations of the nominal rotation at a half step.
    pure function nominal_rate(model, state, body, half, y) result(dydt)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(rigid_body_t), intent(in) :: body      ! with the state's inertia errors
        integer, intent(in) :: half
        real(dp), intent(in) :: y(7)                ! q, omega
        real(dp) :: dydt(7)

        real(dp) :: c(3)

        c = turned_into(y(:4), model%upwards(:, half))/sum(y(:4)**2)
        dydt(:4) = quaternion_rate(y(:4), y(5:))
        dydt(5:) = times(body%inverse_inertia, torque_at(model, state, body, half, c) - &
                         crossed(y(5:), times(body%inertia, y(5:))))       ! (4-1), (4-7)
    end function nominal_rate

    pure subroutine shape_trajectory(n, lanes, trajectory)
        integer, intent(in) :: n, lanes
        type(model_trajectory_t), intent(inout) :: trajectory

        if (allocated(trajectory%q)) then
            if (all(shape(trajectory%partials) == [lanes, 9, n + 1])) return
            deallocate (trajectory%q, trajectory%omega, trajectory%omega_dot, trajectory%partials)
        end if
        allocate (trajectory%q(4, 0:n), trajectory%omega(3, 0:n), trajectory%omega_dot(3, 0:n), trajectory%partials(lanes, 9, 0:n))
    end subroutine shape_trajectory

    !> All torques at a half step.
    pure function torque_at(model, state, body, half, c) result(acting)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(rigid_body_t), intent(in) :: body
        integer, intent(in) :: half
        real(dp), intent(in) :: c(3)        ! upwards, body axes
        real(dp) :: acting(3)

        integer :: i

        acting = (1 + state%value(ROD_GAIN))*(model%magnetic_torque(:, half) - &
                                              crossed(model%dipole(:, half), state%value(FIELD_BIAS))) + &
                 3*model%rate_squared(half)*crossed(c, times(body%inertia, c)) + state%value(TORQUE) + &
                 (half/(2.0_dp*model%steps) - 0.5_dp)*state%value(TORQUE_CHANGE)
        do i = 1, size(model%shaped)
            acting = acting + state%value(model%shaped(i))*model%shape(:, half, i)
        end do
    end function torque_at

    !> The partials along the nominal rotation: d zeta/dt = -omega x zeta + d omega, d(d omega)/dt = A zeta + B d omega +
    !> J^-1 dT/dp, by the same method of Runge and Kutta. Between the epochs A and B are those of the mean of the attitudes
    !> and of the rate that its derivatives let expect, not of the stages: that changes predicted sigmas by 1e-12 of themselves.
    subroutine carry_partials(model, state, body, trajectory, goes_on)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(rigid_body_t), intent(in) :: body
        type(model_trajectory_t), intent(inout) :: trajectory
        logical, intent(in), optional :: goes_on

        real(dp), dimension(3, 0:2*PIECE_LENGTH) :: omega, omega_dot, c
        real(dp), dimension(3, 3, 0:2*PIECE_LENGTH) :: by_angles, by_rate
        real(dp) :: driving(size(trajectory%partials, 1), 3, 0:2*PIECE_LENGTH), q(4)
        integer, allocatable :: places(:)
        integer :: i, k, first, last, half
        logical :: inertia_changes, begins

        associate (x => trajectory%partials(:, :, 0), p => size(model%rotational))
            begins = .true.
            if (present(goes_on)) begins = .not. goes_on
            if (begins) x = 0
            do i = 1, merge(3, 0, begins)
                where (model%rotational == ATTITUDE_ANGLES(i)) x(:p, i) = 1
                where (model%rotational == RATE(i)) x(:p, 3 + i) = 1
            end do
            places = pack([(i, i=1, p)], [(all([ATTITUDE_ANGLES, RATE] /= model%rotational(i)), i=1, p)])
        end associate
        driving = 0
        inertia_changes = any(KIND_OF(model%rotational) == INERTIA(1))
        do first = 0, max(0, model%steps - 1), PIECE_LENGTH
            last = min(first + PIECE_LENGTH, model%steps)
            do half = 2*first, 2*last
                k = half/2
                i = half - 2*first
                q = trajectory%q(:, k)
                omega(:, i) = trajectory%omega(:, k)
                if (mod(half, 2) == 1) then
                    q = q + trajectory%q(:, k + 1)
                    omega(:, i) = (omega(:, i) + trajectory%omega(:, k + 1))/2 + model%interval/8* &
                                  (trajectory%omega_dot(:, k) - trajectory%omega_dot(:, k + 1))
                end if
                c(:, i) = turned_into(q, model%upwards(:, half))/sum(q**2)
                call linear_rates(body, 3*model%rate_squared(half), omega(:, i), c(:, i), by_angles(:, :, i), by_rate(:, :, i))
                if (inertia_changes) omega_dot(:, i) = &
                    body%angular_acceleration(torque_at(model, state, body, half, c(:, i)), omega(:, i))
            end do
            do i = 1, size(places)
                call take_driving(model, state, body, model%rotational(places(i)), 2*first, 2*(last - first), omega, &
                                  omega_dot, c, driving(places(i), :, :))
            end do
            call lanes_carry(size(driving, 1), last - first, model%interval, omega, by_angles, by_rate, driving, &
                             trajectory%partials(:, :, first:last))
        end do
    end subroutine carry_partials

    !> The partials of d omega/dt by the angles and by the rate: c changes by c x zeta,
    !> A = 3 mu/r^3 J^-1 ([c x] J - [J c x]) [c x], and B = J^-1 ([J omega x] - [omega x] J), (4-11), (4-14).
    pure subroutine linear_rates(body, three_mu, omega, c, by_angles, by_rate)
        type(rigid_body_t), intent(in) :: body
        real(dp), intent(in) :: three_mu, omega(3), c(3)        ! 3 mu/r^3; body axes
        real(dp), intent(out), dimension(3, 3) :: by_angles, by_rate

        real(dp) :: by_c(3, 3), jc(3), j_omega(3)
        integer :: k

        associate (j => body%inertia)
            jc = times(j, c)
            j_omega = times(j, omega)
            do k = 1, 3
                by_c(:, k) = crossed(c, j(:, k))
                by_rate(:, k) = -crossed(omega, j(:, k))
            end do
        end associate
        call add_cross_matrix(-1.0_dp, jc, by_c)
        call add_cross_matrix(1.0_dp, j_omega, by_rate)
        by_angles(:, 1) = by_c(:, 2)*c(3) - by_c(:, 3)*c(2)
        by_angles(:, 2) = by_c(:, 3)*c(1) - by_c(:, 1)*c(3)
        by_angles(:, 3) = by_c(:, 1)*c(2) - by_c(:, 2)*c(1)
        do k = 1, 3
            by_angles(:, k) = three_mu*times(body%inverse_inertia, by_angles(:, k))
            by_rate(:, k) = times(body%inverse_inertia, by_rate(:, k))
        end do
    end subroutine linear_rates

    !> Adds f [v x] to a matrix.
    pure subroutine add_cross_matrix(f, v, matrix)
        real(dp), intent(in) :: f, v(3)             !! Factor; vector
        real(dp), intent(inout) :: matrix(3, 3)     !! To which f [v x] is added

        matrix(2, 1) = matrix(2, 1) + f*v(3)
        matrix(3, 1) = matrix(3, 1) - f*v(2)
        matrix(1, 2) = matrix(1, 2) - f*v(3)
        matrix(3, 2) = matrix(3, 2) + f*v(1)
        matrix(1, 3) = matrix(1, 3) + f*v(2)
        matrix(2, 3) = matrix(2, 3) - f*v(1)
    end subroutine add_cross_matrix

    !> What the change of a parameter by 1 adds to d omega/dt over some half steps.
    pure subroutine take_driving(model, state, body, parameter, first, count, omega, omega_dot, c, driving)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(rigid_body_t), intent(in) :: body
        integer, intent(in) :: parameter, first, count      ! half steps first, ..., first + count
        real(dp), intent(in), dimension(3, 0:count) :: omega, omega_dot, c  ! omega_dot for INERTIA alone
        real(dp), intent(inout) :: driving(:, 0:)

        real(dp) :: acting(3), axis(3), dj(3, 3)
        integer :: i, half, place

        acting = 0
        axis = 0
        axis(mod(MEMBER_OF(parameter) - 1, 3) + 1) = 1
        if (KIND_OF(parameter) == INERTIA(1)) dj = unit_inertia(MEMBER_OF(parameter))
        place = findloc(model%shaped, parameter, 1)
        do i = 0, count
            half = first + i
            select case (KIND_OF(parameter))
            case (TORQUE(1))
                acting = axis
            case (TORQUE_CHANGE(1))
                acting = (half/(2.0_dp*model%steps) - 0.5_dp)*axis
            case (ROD_GAIN)
                acting = model%magnetic_torque(:, half) - crossed(model%dipole(:, half), state%value(FIELD_BIAS))
            case (FIELD_BIAS(1))
                acting = -(1 + state%value(ROD_GAIN))*crossed(model%dipole(:, half), axis)
            case (INERTIA(1))
                acting = 3*model%rate_squared(half)*crossed(c(:, i), times(dj, c(:, i))) - times(dj, omega_dot(:, i)) - &
                         crossed(omega(:, i), times(dj, omega(:, i)))
            case default
                acting = model%shape(:, half, place)
            end select
            driving(:, i) = times(body%inverse_inertia, acting)
        end do
    end subroutine take_driving

    !> `transformed` of gracecg_base_vectors once more, in this file: so the compiler puts it in line in inner loops.
    pure function times(m, v)
        real(dp), intent(in) :: m(3, 3), v(3)
        real(dp) :: times(3)

        times = m(:, 1)*v(1) + m(:, 2)*v(2) + m(:, 3)*v(3)
    end function times

    !> A vector in the axes that a quaternion q turns into, times q^2; the product of the rotation matrix likewise.
    pure function turned_into(q, v) result(turned)
        real(dp), intent(in) :: q(4), v(3)    !! Scalar last, of any length; the vector
        real(dp) :: turned(3)

        real(dp) :: across(3)

        across = crossed(q(:3), v) - q(4)*v
        turned = crossed(q(:3), across) + (q(1)*v(1) + q(2)*v(2) + q(3)*v(3))*q(:3) - q(4)*across
    end function turned_into

    !> `cross` likewise.
    pure function crossed(a, b)
        real(dp), intent(in) :: a(3), b(3)
        real(dp) :: crossed(3)

        crossed = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
    end function crossed
end module gracecg_estimation_model_rotation
