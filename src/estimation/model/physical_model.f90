!> The physical model that the optimal and the sequential estimator fit, and that the bound is
!> computed from: rotation under the magnetic torque, the gravity gradient and an unknown torque, and
!> what star camera and accelerometer show of it, with the partials of every parameter.
!>
!> Rotation: J d omega/dt = (1 + g) m x (B - b) + 3 mu/r^3 c x (J c) + T + T' (t/t_n - 1/2) -
!> omega x (J omega), CSR-TM-00-01 eqs. (2-16), (2-23), with the rods' gain error g, the magnetometer's
!> bias b, the unknown torque T and its change T' over the arc of length t_n. The attitude error is
!> multiplicative: R(q) = C(zeta) R(q*), d zeta/dt = -omega* x zeta + d omega. J_p stands for the
!> inertia about the centre of mass, from which it differs by 1e-6 (4-6).
!>
!> Accelerometer: S [(A~ + G) d + alpha t + beta + w (gamma P2(t) + (a sin + b cos)(2 pi (f + df) t))], (3-7),
!> (4-17), with S = diag(1 + s), and along the airflow w, which comes from the orbit (body x without one),
!> a density wave and Legendre's polynomial P2 over the arc. What forces of unknown shape do besides (FORCE_BENDS,
!> SIDE_FORCE) is counted as the accelerometer shows it, without S: their a-priori sigmas would pull s otherwise.
module gracecg_estimation_physical_model
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM, EARTH_ROTATION_RATE
    use gracecg_base_error, only: number_text
    use gracecg_base_text, only: append
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_base_vectors, only: unit
    use gracecg_observations_knowledge, only: operator_knowledge_t, HEADS
    use gracecg_environment_sun, only: sun_position, conical_shadow
    use gracecg_environment_time, only: julian_centuries_tt
    use gracecg_observations_parameters, only: IS_ROTATIONAL, HAS_TORQUE_SHAPE, LIGHT
    use gracecg_estimation_interpolation, only: interpolation_t, interpolation_at, cubic_interpolated, &
        LONGEST_ORBIT_SPACING
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_model_rotation, only: integrate_trajectory
    use gracecg_estimation_model_state
    use gracecg_estimation_shown_samples, only: predict_accelerations, predict_channels, predict_contrasts, &
        star_angles, airflow_at
    use gracecg_estimation_torque_shapes, only: take_torque_shapes, take_moments
    implicit none
    private
    public :: describe_model_state, physical_model_t, model_state_t, model_trajectory_t, prepare_model, &
        initial_state, integrate_trajectory, predict_accelerations, predict_channels, predict_contrasts, star_angles, &
        correct_state, &
        turned_by, turn_between, sinc, airflow_at

contains

    !> Prepares the model for an observation set's preprocessed data. Without an orbit that reaches
    !> over the arc there is no gravity gradient, of which data%warnings is told.
    subroutine prepare_model(knowledge, data, estimated, model)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(inout) :: data
        integer, intent(in) :: estimated(:)     !! Parameters whose partials shall be computed
        type(physical_model_t), intent(out) :: model

        integer :: j, n, head

        n = data%steps
        model%steps = n
        model%interval = data%interval
        model%inertia = knowledge%inertia
        model%line = knowledge%line
        allocate (model%magnetic_torque(3, 0:2*n), source=data%torque)
        allocate (model%dipole(3, 0:2*n), source=data%dipole)
        call take_gravity(data, model)
        do head = 1, HEADS
            model%camera_from_body(:, :, head) = rotation_matrix(knowledge%mounting(:, head))
        end do
        model%estimated = estimated
        model%rotational = pack(estimated, IS_ROTATIONAL(estimated))
        model%place = [(findloc(model%rotational, estimated(j), 1), j=1, size(estimated))]
        model%shaped = pack(model%rotational, HAS_TORQUE_SHAPE(model%rotational))
        allocate (model%shape(3, 0:2*n, size(model%shaped)), source=0.0_dp)
        if (size(model%shaped) > 0) call take_torque_shapes(knowledge, data, model)
        call take_moments(knowledge, data, model)
        if (.not. any(estimated == LIGHT(1))) return
        allocate (model%light(0:n), source=0.0_dp)
        if (.not. model%airflow_known) return       ! no orbit
        do j = 0, n
            model%light(j) = conical_shadow(cubic_interpolated(data%orbit_time, data%orbit_position, j*model%interval), &
                                            sun_position(julian_centuries_tt(knowledge%epoch)))
        end do
    end subroutine prepare_model

    !> mu/r^3, the direction upwards and that of the airflow along the orbit.
    subroutine take_gravity(data, model)
        type(fitting_data_t), intent(inout) :: data
        type(physical_model_t), intent(inout) :: model

        type(interpolation_t) :: place
        real(dp) :: position(3), t
        integer :: j

        associate (n => model%steps)
            allocate (model%rate_squared(0:2*n), source=0.0_dp)
            allocate (model%upwards(3, 0:2*n), source=0.0_dp)
            allocate (model%airflow(3, 0:n), source=0.0_dp)
            if (size(data%orbit_time) == 0) then
                call append(data%warnings, 'no orbit: the gravity gradient is left out of rotation and '// &
                            'acceleration')
                return
            end if
            do j = 0, 2*n
                t = j*model%interval/2
                place = interpolation_at(data%orbit_time, t, model%interval, LONGEST_ORBIT_SPACING)
                if (.not. place%supported) then
                    call append(data%warnings, 'orbit: no positions around '//number_text(t)// &
                                ' s: the gravity gradient is left out of rotation and acceleration')
                    model%rate_squared = 0
                    return
                end if
                position = cubic_interpolated(data%orbit_time, data%orbit_position, t)
                model%rate_squared(j) = EARTH_GM/norm2(position)**3
                model%upwards(:, j) = unit(position)
                if (mod(j, 2) == 0) model%airflow(:, j/2) = unit(velocity_in_air(position, t))
            end do
            model%airflow_known = .true.
        end associate

    contains

        !> Relative to air that turns with the Earth; the orbit's velocity by differences over 2 s.
        pure function velocity_in_air(position, t) result(velocity)
            real(dp), intent(in) :: position(3), t
            real(dp) :: velocity(3)

            real(dp), parameter :: STEP = 1         ! s

            velocity = (cubic_interpolated(data%orbit_time, data%orbit_position, t + STEP) - &
                        cubic_interpolated(data%orbit_time, data%orbit_position, t - STEP))/(2*STEP) - &
                       EARTH_ROTATION_RATE*[-position(2), position(1), 0.0_dp]
        end function velocity_in_air
    end subroutine take_gravity
end module gracecg_estimation_physical_model
