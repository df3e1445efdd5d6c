!> What star camera, accelerometer and its angular channels show of the physical model (gracecg_estimation_physical_model)
!> along a rotation, with the partials of every parameter.
module gracecg_estimation_shown_samples
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_vectors, only: cross, cross_matrix, transformed
    use gracecg_observations_parameters
    use gracecg_estimation_model_rotation, only: turned_into, add_cross_matrix
    use gracecg_estimation_model_state, only: physical_model_t, model_state_t, model_trajectory_t, turned_by, turn_between, &
        turned_about
    use gracecg_estimation_offset_model, only: offset_matrix, offset_rate_partials
    use gracecg_estimation_offset_information, only: gravity_gradient_matrix
    implicit none
    private
    public :: predict_accelerations, predict_channels, predict_contrasts, star_angles, airflow_at

contains

    !> What the accelerometer would show at the samples' epochs, and the partials of the estimated
    !> parameters.
    pure subroutine predict_accelerations(model, state, trajectory, epoch, predicted, partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory    !! Of this state
        integer, intent(in) :: epoch(:)                 !! k of each sample
        real(dp), intent(out), optional :: predicted(:, :)      !! (3, samples), m/s^2
        real(dp), intent(out), optional :: partials(:, :, :)    !! (estimated, 3, samples)

        real(dp) :: factor(3), unscaled(3), matrix(3, 3), changes(3, 5), drag(3), along(3), bends(size(FORCE_BENDS)), shown(3), t
        real(dp) :: tilts(size(TILT))
        logical :: drag_changes, side_forces, lifted, tilted, bent
        integer, allocatable :: linear(:)
        integer :: i, k, n

        linear = pack(model%estimated, IS_OF_INSTRUMENT(model%estimated) .and. abs(state%value(model%estimated)) > 0)
        factor = 1 + state%value(SCALE_FACTORS)
        drag_changes = model%wave_frequency > 0 .or. any(model%estimated == DRAG_CURVATURE)
        side_forces = any(model%estimated == SIDE_FORCE(1))
        lifted = any(model%estimated == LIFT(1))
        tilted = any(model%estimated == TILT(1))
        bent = any(abs(state%value(FORCE_BENDS)) > 0) .or. any(KIND_OF(model%estimated) == FORCE_BENDS(1))
        changes = 0
        drag = 0
        tilts = 0
        bends = 0
        do i = 1, size(epoch)
            k = epoch(i)
            t = model%start + k*model%interval
            matrix = acceleration_matrix(model, trajectory, k)
            along = airflow_at(model, trajectory%q(:, k), k)
            if (drag_changes) then
                changes = drag_partials(model, state, along, k)
                drag = changes(:, 1)*state%value(DRAG_CURVATURE) + changes(:, 2)*state%value(WAVE_SINE) + &
                       changes(:, 3)*state%value(WAVE_COSINE)
                drag(2:) = drag(2:) + state%value(AIRFLOW_TURN)*dot_product(along, drag)
            end if
            unscaled = transformed(matrix, state%value(OFFSET)) + state%value(DRIFT)*t + state%value(BIAS) + drag
            if (k >= model%jump) unscaled = unscaled + state%value(FORCE_JUMP)
            if (allocated(model%light)) unscaled = unscaled + matmul(reshape(state%value(LIGHT), [3, 3]), light_at(model, k))
            shown = factor*unscaled
            if (side_forces) shown(1) = shown(1) + along(2)*state%value(SIDE_FORCE(1)) + along(3)*state%value(SIDE_FORCE(2))
            if (lifted) shown(2:) = shown(2:) + along(2:)*state%value(LIFT)
            if (tilted) then
                tilts = tilts_at(model, trajectory, along, k)
                do n = 1, size(TILT)
                    shown(TILT_AXIS(n)) = shown(TILT_AXIS(n)) + tilts(n)*state%value(TILT(n))
                end do
            end if
            if (bent) then
                bends = bends_at(model, k)
                do n = 1, size(FORCE_BENDS)
                    shown(BEND_AXIS(n)) = shown(BEND_AXIS(n)) + bends(n)*state%value(FORCE_BENDS(n))
                end do
            end if
            do n = 1, size(linear)
                shown = shown + state%value(linear(n))* &
                        instrument_partial(model, state, trajectory, k, linear(n), factor, unscaled)
            end do
            if (present(predicted)) predicted(:, i) = shown
            if (present(partials)) &
                call acceleration_partials(model, state, trajectory, k, factor, matrix, unscaled, &
                                           drag, changes, along, tilts, bends, partials(:, :, i))
        end do
    end subroutine predict_accelerations

    !> What the angular channels would show at the samples' epochs, S d omega/dt + bias + drift t + L m + K dm/dt, and the
    !> partials of the estimated parameters.
    pure subroutine predict_channels(model, state, trajectory, epoch, predicted, partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory      !! Of this state
        integer, intent(in) :: epoch(:)                         !! k of each sample
        real(dp), intent(out) :: predicted(:, :)                !! (3, samples), rad/s^2
        real(dp), intent(out), optional :: partials(:, :, :)    !! (estimated, 3, samples)

        real(dp) :: scales(3, 3), weight(3, 9), slope(3), rotational(size(model%rotational), 3), partial(3), bend(3)
        integer :: i, j, k, axis, from, before, after, middle

        scales = transpose(reshape(state%value(CHANNEL_SCALES), [3, 3]))
        do i = 1, 3
            scales(i, i) = scales(i, i) + 1
        end do
        weight = 0
        weight(:, 7:9) = scales
        do j = 1, size(epoch)
            k = epoch(j)
            before = max(0, k - 1)
            after = min(model%steps, k + 1)
            slope = (trajectory%omega_dot(:, after) - trajectory%omega_dot(:, before))/((after - before)*model%interval)
            ! of the torque as believed: delays of torque and samples that cancel each other show nothing, nor does their product
            middle = max(1, min(model%steps - 1, k))
            bend = (trajectory%omega_dot(:, middle + 1) - 2*trajectory%omega_dot(:, middle) + &
                    trajectory%omega_dot(:, middle - 1))/model%interval**2
            slope = slope + state%value(ALL_RODS_DELAY)*bend
            predicted(:, j) = transformed(scales, trajectory%omega_dot(:, k) - state%value(SAMPLING_DELAY)*slope) + &
                              state%value(CHANNEL_BIAS) + state%value(CHANNEL_DRIFT)*(k*model%interval)
            if (size(model%moment) > 0) predicted(:, j) = predicted(:, j) + &
                matmul(model%moment(:, k), reshape(state%value(CHANNEL_LEAKAGE), [3, 3])) + &
                matmul(model%moment_rate(:, k), reshape(state%value(CHANNEL_LEAKAGE_RATE), [3, 3]))
            if (.not. present(partials)) cycle
            if (any(model%place > 0)) call combine_columns(trajectory%partials(:, :, k), weight, rotational)
            do i = 1, size(model%estimated)
                associate (p => model%estimated(i))
                    partial = 0
                    axis = (MEMBER_OF(p) + 2)/3
                    from = mod(MEMBER_OF(p) - 1, 3) + 1
                    select case (KIND_OF(p))
                    case (CHANNEL_BIAS(1))
                        partial(from) = 1
                    case (CHANNEL_DRIFT(1))
                        partial(from) = k*model%interval
                    case (CHANNEL_SCALES(1))
                        partial(axis) = trajectory%omega_dot(from, k)
                    case (CHANNEL_LEAKAGE(1))
                        partial(axis) = model%moment(from, k)
                    case (CHANNEL_LEAKAGE_RATE(1))
                        partial(axis) = model%moment_rate(from, k)
                    case (SAMPLING_DELAY)
                        partial = -transformed(scales, slope)
                    case default
                        if (model%place(i) > 0) partial = rotational(model%place(i), :)
                    end select
                    partials(i, :, j) = partial
                end associate
            end do
        end do
    end subroutine predict_channels

    !> What the contrasts of several accelerometers would show at the samples' epochs, (3 a contrast, samples), m/s^2, and the
    !> partials of the estimated parameters. With scale factors 1 + s + sum_j c_jk u_j of accelerometer k, rho of their places,
    !> e along the line, M = [d omega/dt x] + [omega x]^2 + G of (3-7), each axis by itself,
    !>   y_1 = rho (1 + s + u_2/sqrt 6) M e + u_1 M d + b_1 + b_1' t,  y_2 = rho u_1/sqrt 6 M e + u_2 M d + b_2 + b_2' t,
    !> for sum_k c_1k^2 c_2k = 1/sqrt 6; two accelerometers have y_1, without u_2. Of other forces than M d those are left out
    !> that bend, times u.
    pure subroutine predict_contrasts(model, state, trajectory, epoch, predicted, partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory      !! Of this state
        integer, intent(in) :: epoch(:)                         !! k of each sample
        real(dp), intent(out) :: predicted(:, :)                !! (3 a contrast, samples), m/s^2
        real(dp), intent(out), optional :: partials(:, :, :)    !! (estimated, 3 a contrast, samples)

        real(dp) :: u(3, 2), along(3, 2), bias(3, 2), drift(3, 2), matrix(3, 3), by_offset(3), by_line(3), weight(3, 9), t
        real(dp) :: rotational(size(model%rotational), 3), partial(3)
        integer :: i, j, k, n, axis, first

        u = reshape(state%value(LINE_SCALES), [3, 2])
        bias = reshape(state%value(LINE_BIAS), [3, 2])
        drift = reshape(state%value(LINE_DRIFT), [3, 2])
        along(:, 1) = 1 + state%value(SCALE_FACTORS) + u(:, 2)/sqrt(6.0_dp)
        along(:, 2) = u(:, 1)/sqrt(6.0_dp)
        do i = 1, size(epoch)
            k = epoch(i)
            t = model%start + k*model%interval
            matrix = acceleration_matrix(model, trajectory, k)
            by_offset = transformed(matrix, state%value(OFFSET))
            by_line = model%line%reach()*transformed(matrix, model%line%direction())
            do j = 1, model%line%number - 1
                first = 3*j - 2
                predicted(first:first + 2, i) = along(:, j)*by_line + u(:, j)*by_offset + bias(:, j) + drift(:, j)*t
                if (.not. present(partials)) cycle
                weight = spread(along(:, j)*model%line%reach(), 2, 9)* &
                         motion_weights(model, trajectory, k, model%line%direction()) + &
                         spread(u(:, j), 2, 9)*motion_weights(model, trajectory, k, state%value(OFFSET))
                if (any(model%place > 0)) call combine_columns(trajectory%partials(:, :, k), weight, rotational)
                do n = 1, size(model%estimated)
                    associate (p => model%estimated(n))
                        partial = 0
                        axis = mod(MEMBER_OF(p) - 1, 3) + 1
                        associate (same => (MEMBER_OF(p) + 2)/3 == j)
                            select case (KIND_OF(p))
                            case (OFFSET(1))
                                partial = u(:, j)*matrix(:, axis)
                            case (SCALE_FACTORS(1))
                                if (j == 1) partial(axis) = by_line(axis)
                            case (LINE_SCALES(1))
                                partial(axis) = merge(by_offset(axis), by_line(axis)/sqrt(6.0_dp), same)
                            case (LINE_BIAS(1))
                                if (same) partial(axis) = 1
                            case (LINE_DRIFT(1))
                                if (same) partial(axis) = t
                            case default
                                if (model%place(n) > 0) partial = rotational(model%place(n), :)
                            end select
                        end associate
                        partials(n, first:first + 2, i) = partial
                    end associate
                end do
            end do
        end do
    end subroutine predict_contrasts

    !> A~ + G at k h.
    pure function acceleration_matrix(model, trajectory, k) result(matrix)
        type(physical_model_t), intent(in) :: model
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k
        real(dp) :: matrix(3, 3)

        matrix = offset_matrix(trajectory%omega(:, k), trajectory%omega_dot(:, k))
        if (model%rate_squared(2*k) > 0) &
            matrix = matrix + gravity_gradient_matrix(model%rate_squared(2*k), vertical_at(model, trajectory, k))
    end function acceleration_matrix

    !> The partials of M r by the angles, by omega and by d omega/dt, at k h.
    pure function motion_weights(model, trajectory, k, r) result(weight)
        type(physical_model_t), intent(in) :: model
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k
        real(dp), intent(in) :: r(3)            !! Body axes
        real(dp) :: weight(3, 9)

        real(dp) :: c(3), r_by_c(3)
        integer :: i

        weight = 0
        if (model%rate_squared(2*k) > 0) then
            c = vertical_at(model, trajectory, k)
            ! G r = mu/r^3 (r - 3 (c.r) c), and c changes by c x zeta
            r_by_c = cross(r, c)
            weight(:, :3) = dot_product(c, r)*cross_matrix(c)
            do i = 1, 3
                weight(:, i) = -3*model%rate_squared(2*k)*(weight(:, i) + c*r_by_c(i))
            end do
        end if
        weight(:, 4:6) = offset_rate_partials(trajectory%omega(:, k), r)
        weight(:, 7:9) = -cross_matrix(r)
    end function motion_weights

    pure function vertical_at(model, trajectory, k) result(c)
        type(physical_model_t), intent(in) :: model
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k
        real(dp) :: c(3)            !! Upwards, body axes

        c = turned_into(trajectory%q(:, k), model%upwards(:, 2*k))
    end function vertical_at

    !> The unscaled acceleration along the airflow that is no straight line by its parameters: curvature,
    !> sine, cosine, frequency, growth. The curvature's is Legendre's polynomial of degree 2 over the arc.
    pure function drag_partials(model, state, along, k) result(partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        real(dp), intent(in) :: along(3)    !! The direction of the airflow
        integer, intent(in) :: k
        real(dp) :: partials(3, 5)          !! (axis, parameter); of the frequency in m/s^2/Hz

        real(dp) :: angle, t, x, growth

        t = model%start + k*model%interval
        x = 2*real(k, dp)/model%steps - 1
        angle = TWO_PI*(model%wave_frequency + state%value(WAVE_FREQUENCY))*t
        partials(:, 1) = along*(3*x**2 - 1)/2
        growth = 1 + x*state%value(WAVE_GROWTH)
        partials(:, 2) = growth*along*sin(angle)
        partials(:, 3) = growth*along*cos(angle)
        partials(:, 4) = TWO_PI*t*(state%value(WAVE_SINE)*partials(:, 3) - state%value(WAVE_COSINE)*partials(:, 2))
        partials(:, 5) = along*x*(state%value(WAVE_SINE)*sin(angle) + state%value(WAVE_COSINE)*cos(angle))
    end function drag_partials

    !> The polynomials of FORCE_BENDS at k h.
    pure function bends_at(model, k) result(values)
        type(physical_model_t), intent(in) :: model
        integer, intent(in) :: k
        real(dp) :: values(size(FORCE_BENDS))

        real(dp) :: x, polynomial(0:6)
        integer :: n

        x = 2*real(k, dp)/model%steps - 1
        polynomial(0) = 1
        polynomial(1) = x
        do n = 1, 5         ! Bonnet's recursion
            polynomial(n + 1) = ((2*n + 1)*x*polynomial(n) - n*polynomial(n - 1))/(n + 1)
        end do
        do n = 1, size(values)
            values(n) = polynomial(BEND_DEGREE(n))
        end do
    end function bends_at

    !> The angles by which forces change beside SIDE_FORCE and LIFT: of the roll, and of the airflow, rad.
    pure function tilts_at(model, trajectory, along, k) result(tilts)
        type(physical_model_t), intent(in) :: model
        type(model_trajectory_t), intent(in) :: trajectory
        real(dp), intent(in) :: along(3)
        integer, intent(in) :: k
        real(dp) :: tilts(size(TILT))

        real(dp) :: up(3)

        up = vertical_at(model, trajectory, k)
        tilts = [up(2), up(2), along(3), up(2), along(2)]
    end function tilts_at

    !> The part of the Sun that is seen at k h, times 1, x and x^2, x from -1 to 1 along the arc.
    pure function light_at(model, k) result(light)
        type(physical_model_t), intent(in) :: model
        integer, intent(in) :: k
        real(dp) :: light(3)

        associate (x => 2*real(k, dp)/model%steps - 1)
            light = model%light(k)*[1.0_dp, x, x**2]
        end associate
    end function light_at

    !> The direction of the airflow at k h.
    pure function airflow_at(model, q, k) result(along)
        type(physical_model_t), intent(in) :: model
        real(dp), intent(in) :: q(4)            !! Attitude, inertial to body
        integer, intent(in) :: k    !! The epoch, in intervals
        real(dp) :: along(3)                    !! Unit vector, body axes

        along = [1.0_dp, 0.0_dp, 0.0_dp]
        if (model%airflow_known) along = turned_into(q, model%airflow(:, k))
    end function airflow_at

    pure subroutine acceleration_partials(model, state, trajectory, k, factor, matrix, unscaled, drag, changes, &
                                          along, tilts, bends, partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k
        real(dp), intent(in) :: factor(3), matrix(3, 3), unscaled(3)
        real(dp), intent(in) :: drag(3)             !! That is no straight line
        real(dp), intent(in) :: changes(3, 5)       !! Of drag_partials
        real(dp), intent(in) :: along(3)            !! The direction of the airflow
        real(dp), intent(in) :: tilts(size(TILT))           !! The angles
        real(dp), intent(in) :: bends(size(FORCE_BENDS))    !! The polynomials
        real(dp), intent(out) :: partials(:, :)     !! (estimated, 3)

        real(dp) :: weight(3, 9), rotational(size(model%rotational), 3), sunlight(3)
        integer :: i, axis

        associate (t => model%start + k*model%interval)
            weight = motion_weights(model, trajectory, k, state%value(OFFSET))
            if (model%line%number > 1) weight = weight + spread(state%value(LINE_SCALES(:3)), 2, 9)*motion_weights( &
                                                model, trajectory, k, model%line%reach()/model%line%number*model%line%direction())
            if (model%airflow_known) weight(:, :3) = weight(:, :3) + cross_matrix(drag)
            do i = 1, 9
                weight(:, i) = factor*weight(:, i)
            end do
            ! a rotation without partials is enough for parameters that do not act on it
            if (any(model%place > 0)) call combine_columns(trajectory%partials(:, :, k), weight, rotational)
            partials = 0
            do i = 1, size(model%estimated)
                associate (p => model%estimated(i), r => model%place(i))
                    if (r > 0) then
                        partials(i, :) = rotational(r, :)
                        cycle
                    end if
                    axis = mod(MEMBER_OF(p) - 1, 3) + 1
                    select case (KIND_OF(p))
                    case (OFFSET(1))
                        partials(i, :) = factor*matrix(:, axis)
                    case (DRIFT(1))
                        partials(i, axis) = factor(axis)*t
                    case (BIAS(1))
                        partials(i, axis) = factor(axis)
                    case (SCALE_FACTORS(1))
                        partials(i, axis) = unscaled(axis)
                    case (DRAG_CURVATURE, WAVE_SINE, WAVE_COSINE, WAVE_FREQUENCY, WAVE_GROWTH)
                        partials(i, :) = factor*changes(:, p - DRAG_CURVATURE + 1)
                    case (FORCE_BENDS(1))
                        partials(i, BEND_AXIS(MEMBER_OF(p))) = bends(MEMBER_OF(p))
                    case (FORCE_JUMP(1))
                        if (k >= model%jump) partials(i, axis) = factor(axis)
                    case (LIGHT(1))
                        sunlight = light_at(model, k)
                        partials(i, axis) = factor(axis)*sunlight((MEMBER_OF(p) + 2)/3)
                    case (SIDE_FORCE(1))
                        partials(i, 1) = along(1 + MEMBER_OF(p))
                    case (TILT(1))
                        partials(i, TILT_AXIS(MEMBER_OF(p))) = tilts(MEMBER_OF(p))
                    case (LIFT(1))
                        partials(i, 1 + MEMBER_OF(p)) = along(1 + MEMBER_OF(p))
                    case (AIRFLOW_TURN(1))
                        axis = 1 + MEMBER_OF(p)
                        partials(i, axis) = factor(axis)*dot_product(along, drag)
                    case default
                        if (IS_OF_INSTRUMENT(p)) &
                            partials(i, :) = instrument_partial(model, state, trajectory, k, p, factor, unscaled)
                    end select
                end associate
            end do
        end associate
    end subroutine acceleration_partials

    !> What the accelerometer shows by 1 of such a parameter.
    pure function instrument_partial(model, state, trajectory, k, parameter, factor, unscaled) result(partial)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k                    ! Epoch
        integer, intent(in) :: parameter            ! Its place
        real(dp), intent(in) :: factor(3), unscaled(3)      ! Scale factors, m/s^2
        real(dp) :: partial(3)                      ! m/s^2 by its unit

        real(dp) :: slope(3)
        integer :: axis, other

        axis = MEMBER_OF(parameter)
        other = modulo(axis, 3) + 1
        partial = 0
        select case (KIND_OF(parameter))
        case (ACCELEROMETER_DELAYS(1))
            slope = acceleration_slope(model, state, trajectory, k)
            partial(axis) = -factor(axis)*slope(axis)
        case (ACCELEROMETER_TURN(1))
            partial = factor*turned_about(axis, unscaled)
        case (ACCELEROMETER_SWAPS(1))
            partial(axis) = factor(other)*unscaled(other) - factor(axis)*unscaled(axis)
            partial(other) = -partial(axis)
        case (SAMPLING_DELAY)
            partial = -factor*acceleration_slope(model, state, trajectory, k)
        case (LEAKAGE(1))
            partial((axis + 2)/3) = model%moment(mod(axis - 1, 3) + 1, k)
        case (LEAKAGE_RATE(1))
            partial((axis + 2)/3) = model%moment_rate(mod(axis - 1, 3) + 1, k)
        case (LINE_SCALES(1))       ! of the mean: the first contrast alone
            if (axis > 3) return
            slope = transformed(acceleration_matrix(model, trajectory, k), model%line%direction())
            partial(axis) = model%line%reach()/model%line%number*slope(axis)
        end select
    end function instrument_partial

    !> What three numbers change by with the parameters of the rotation: columns times their weights.
    pure subroutine combine_columns(columns, weight, combined)
        real(dp), contiguous, intent(in) :: columns(:, :)   ! of zeta, omega and d omega/dt: (lanes, 9)
        real(dp), intent(in) :: weight(3, 9)
        real(dp), contiguous, intent(out) :: combined(:, :)

        integer :: i, l

        do i = 1, 3
            do l = 1, size(combined, 1)
                combined(l, i) = (columns(l, 1)*weight(i, 1) + columns(l, 2)*weight(i, 2) + columns(l, 3)*weight(i, 3)) + &
                                 (columns(l, 4)*weight(i, 4) + columns(l, 5)*weight(i, 5) + columns(l, 6)*weight(i, 6)) + &
                                 (columns(l, 7)*weight(i, 7) + columns(l, 8)*weight(i, 8) + columns(l, 9)*weight(i, 9))
            end do
        end do
    end subroutine combine_columns

    !> How fast the unscaled acceleration changes at k h, by a central difference (one-sided at the ends), m/s^3.
    pure function acceleration_slope(model, state, trajectory, k) result(slope)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k
        real(dp) :: slope(3)

        integer :: before, after

        before = max(0, k - 1)
        after = min(model%steps, k + 1)
        slope = matmul(acceleration_matrix(model, trajectory, after) - acceleration_matrix(model, trajectory, before), &
                       state%value(OFFSET))/((after - before)*model%interval) + state%value(DRIFT)
    end function acceleration_slope

    !> Angles, about the axes of the head that took it, from the computed attitude to a star-camera
    !> sample, and the partials of the computed attitude. The sample's epoch may lie between the steps:
    !> from the nearest one the attitude is carried on with omega and d omega/dt.
    pure subroutine star_angles(model, state, trajectory, time, head, quaternion, angles, partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory
        real(dp), intent(in) :: time            !! s
        integer, intent(in) :: head    !! That took the sample, 1 to HEADS
        real(dp), intent(in) :: quaternion(4)   !! Sample, inertial to body
        real(dp), intent(out) :: angles(3)      !! Observed minus computed, about camera axes, rad
        real(dp), intent(out), optional :: partials(:, :)   !! (estimated, 3)

        real(dp) :: computed(4), tau, rate(3), turned(3, 3), weight(3, 9), rotational(size(model%rotational), 3)
        integer :: k, i

        k = max(0, min(model%steps, nint(time/model%interval)))
        tau = time - k*model%interval
        associate (omega => trajectory%omega(:, k), camera => model%camera_from_body(:, :, head))
            computed = turned_by(tau*omega + tau**2/2*trajectory%omega_dot(:, k), trajectory%q(:, k))
            angles = matmul(camera, turn_between(computed, quaternion))
            rate = omega + tau*trajectory%omega_dot(:, k)
            do i = 1, size(model%estimated)
                associate (p => model%estimated(i))
                    if (.not. IS_OF_STAR_CAMERA(p)) cycle
                    if (abs(state%value(p)) > 0) angles = angles - state%value(p)*camera_partial(p, head, camera, rate, time)
                end associate
            end do
            if (.not. present(partials)) return
            turned = 0
            call add_cross_matrix(-tau, omega, turned)
            do i = 1, 3
                weight(:, i) = camera(:, i) + transformed(camera, turned(:, i))
                weight(:, 3 + i) = tau*camera(:, i)
                weight(:, 6 + i) = tau**2/2*camera(:, i)
            end do
            call combine_columns(trajectory%partials(:, :, k), weight, rotational)
            partials = 0
            do i = 1, size(model%estimated)
                associate (p => model%estimated(i), r => model%place(i))
                    if (r > 0) then
                        partials(i, :) = rotational(r, :)
                    else if (IS_OF_STAR_CAMERA(p)) then
                        partials(i, :) = camera_partial(p, head, camera, rate, time)
                    end if
                end associate
            end do
        end associate
    end subroutine star_angles

    !> The angles that a head shows by 1 of such a parameter.
    pure function camera_partial(parameter, head, camera, rate, time) result(partial)
        integer, intent(in) :: parameter        !! Its place
        integer, intent(in) :: head
        real(dp), intent(in) :: camera(3, 3)    !! Camera from body
        real(dp), intent(in) :: rate(3)         !! Of the body, rad/s
        real(dp), intent(in) :: time            !! s
        real(dp) :: partial(3)                  !! Camera axes, rad by its unit

        partial = 0
        select case (KIND_OF(parameter))
        case (MOUNTING_1(1), MOUNTING_2(1))
            if (any(merge(MOUNTING_1, MOUNTING_2, head == 1) == parameter)) partial = camera(:, MEMBER_OF(parameter))
        case (HEAD_DRIFT(1))
            if (head == 2) partial = camera(:, MEMBER_OF(parameter))*time
        case (HEAD_DELAY)
            if (head == 2) partial = -transformed(camera, rate)
        case (STAR_CAMERA_DELAY)
            partial = -transformed(camera, rate)
        end select
    end function camera_partial
end module gracecg_estimation_shown_samples
