!> ASSEST, the Accelerometer and Star camera Separate ESTimation of CSR-TM-00-01 section 4.6.1: first
!> the initial attitude and angular velocity from the star camera (or the latter from other means), then the CG offset from the
!> accelerometer along the rotation so found.
module gracecg_estimation_assest
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_text, only: append
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_attitude_fit, only: fitted_rotation_t
    use gracecg_estimation_attitude_problem, only: attitude_problem_t, prepare_attitude
    use gracecg_estimation_offset_model, only: offset_rate_partials
    use gracecg_estimation_offset_problem, only: offset_problem_t, prepare_offset, OFFSET_PARAMETERS, OFFSET_NAMES
    use gracecg_estimation_batch_problem, only: batch_solution_t
    use gracecg_estimation_batch_processor, only: batch_settings_t, process_batch
    use gracecg_estimation_noise_propagation, only: accelerometer_noise_covariance, star_noise_covariance
    use gracecg_estimation_fit_checks, only: refuse_stuck_axis, check_accelerations, check_torque
    use gracecg_estimation_solution, only: solution_t, store_offset, STATE_ATTITUDE, STATE_RATE
    use gracecg_estimation_fit_record, only: fit_record_t, record_rotation, record_covariance, NOISE_SOURCES, &
        STAR_CAMERA_NOISE, A_PRIORI_KNOWLEDGE
    implicit none
    private
    public :: estimate_assest

contains

    !> ASSEST with the angular velocity from Full (FDE) or Reduced Dimension Estimation (RDE); or, where the
    !> operator knows it from other means, with that, without the star camera: section 4.6. Both are then alike,
    !> and there is no attitude.
    !>
    !> The covariance of the offset is propagated when it is asked for, or there is a record, and the fit is
    !> then checked; this costs as much as the estimate.
    !>
    !> Fails when the observations are refused or a normal matrix is singular, and, with the
    !> covariance, when the satellite did not turn as the torque rods should have made it.
    subroutine estimate_assest(observations, options, reduced, solution, error, record)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        logical, intent(in) :: reduced          !! RDE instead of FDE
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record   !! For diagnostics; with the covariance

        type(attitude_problem_t) :: attitude
        type(offset_problem_t) :: offset
        type(fitting_data_t) :: data
        type(fitted_rotation_t) :: rotation
        type(batch_settings_t) :: settings
        type(batch_solution_t) :: attitude_batch, offset_batch
        logical :: covariance_wanted

        solution%algorithm = merge('assest-rde', 'assest-fde', reduced)
        associate (knowledge => observations%knowledge)
            call preprocess(observations, options, data, error, without_attitude=knowledge%knows_angular_velocity())
            if (.not. allocated(error)) call refuse_stuck_axis(data, error)
            if (allocated(error)) return
            solution%warnings = data%warnings
            call prepare_attitude(knowledge, data, reduced, attitude)
            attitude%attitude_weight = options%star_camera_weight
            call find_rotation(knowledge, options, attitude, attitude_batch, solution, error)
            if (allocated(error)) return
            covariance_wanted = options%covariance .or. present(record)
            if (covariance_wanted) then
                call attitude%fit%fit_rotation(attitude%angular_velocity, rotation)
            else
                call attitude%fit%fit_rate(attitude%angular_velocity, rotation)
            end if
            call prepare_offset(knowledge, options, data, rotation, offset)
            if (options%history) settings%history = 'CG offset'
            call process_batch(offset, settings, offset_batch, error)
            if (allocated(error)) then
                call add_context(error, 'ASSEST, CG offset from the accelerometer')
                return
            end if
            solution%condition = offset_batch%condition
            if (options%history) solution%history = [solution%history, offset_batch%history]
            call store_offset(offset%state, offset_batch%residuals, solution)
            if (.not. covariance_wanted) return
            call propagate_noise(knowledge, attitude, attitude_batch, offset, offset_batch, solution, error, record)
            if (allocated(error)) return
            if (present(record)) call record_rotation(data, rotation, offset_batch%residuals, record)
            call check_accelerations(knowledge, data, offset_batch%residuals, solution%warnings, error)
            if (.not. allocated(error) .and. .not. knowledge%knows_angular_velocity()) &
                call check_torque(knowledge, data, knowledge%star_camera_sigma, attitude%quaternion, &
                                  attitude%angular_velocity, solution%warnings, error, record)
        end associate
    end subroutine estimate_assest

    !> Attitude and angular velocity at the epoch from the star camera, or what the operator knows of the latter.
    subroutine find_rotation(knowledge, options, attitude, batch, solution, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(attitude_problem_t), intent(inout) :: attitude
        type(batch_solution_t), intent(inout) :: batch
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(batch_settings_t) :: settings

        if (options%history) allocate (solution%history(0))
        if (knowledge%knows_angular_velocity()) then
            attitude%angular_velocity = knowledge%angular_velocity
            solution%angular_velocity = knowledge%angular_velocity
            solution%converged = .true.
            call append(solution%warnings, 'the angular velocity at the epoch is that of the setup, from other means: '// &
                        'no star camera was used, and nothing tells whether the satellite turned as the torque rods '// &
                        'should have made it')
            return
        end if
        if (options%history) settings%history = 'attitude and rate'
        call process_batch(attitude, settings, batch, error)
        if (allocated(error)) then
            call add_context(error, 'ASSEST, angular velocity from the star camera')
            return
        end if
        solution%quaternion = attitude%quaternion
        solution%angular_velocity = attitude%angular_velocity
        solution%iterations = batch%iterations
        solution%converged = batch%converged
        if (options%history) solution%history = batch%history
    end subroutine find_rotation

    !> Covariance of the offset and of the whole state under the instruments' noise: that of the accelerometer, with its
    !> spectrum (3-2), and that of the star camera, or of the knowledge that replaces it, through the error of omega(t0).
    subroutine propagate_noise(knowledge, attitude, attitude_batch, offset, offset_batch, solution, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(attitude_problem_t), intent(in) :: attitude
        type(batch_solution_t), intent(in) :: attitude_batch
        type(offset_problem_t), intent(in) :: offset
        type(batch_solution_t), intent(in) :: offset_batch
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record

        real(dp), allocatable :: gain(:, :), whole(:, :), by_axis(:, :, :), from_rate(:, :)
        real(dp), allocatable :: rate_to_state(:, :)
        real(dp) :: rotation_covariance(6, 6), by_source(3, 3, NOISE_SOURCES)
        integer :: i, k, row, source
        integer, parameter :: parameters = OFFSET_PARAMETERS, ANGLES(3) = [1, 2, 3], RATES(3) = [4, 5, 6]

        gain = matmul(offset_batch%inverse(:parameters, :), offset_batch%gain)
        allocate (whole(parameters, parameters), by_axis(parameters, parameters, 3))
        call accelerometer_noise_covariance(knowledge, gain, offset%data%accelerometer_epoch, whole, error, by_axis)
        if (allocated(error)) return

        allocate (rate_to_state(parameters, 3), source=0.0_dp)
        associate (rotation => offset%rotation)
            do i = 1, size(offset%data%accelerometer_epoch)
                k = offset%data%accelerometer_epoch(i)
                row = 3*(i - 1)
                rate_to_state = rate_to_state - matmul(gain(:, row + 1:row + 3), matmul( &
                                offset_rate_partials(rotation%omega(:, k), offset%state(1:3), &
                                                     attitude%fit%body%rate_partials(rotation%omega(:, k))), &
                                rotation%phi_22(:, :, k)))
            end do
        end associate
        if (knowledge%knows_angular_velocity()) then
            rotation_covariance = 0
            do i = 1, 3
                rotation_covariance(RATES(i), RATES(i)) = knowledge%angular_velocity_sigma(i)**2
            end do
            source = A_PRIORI_KNOWLEDGE
        else
            rotation_covariance = star_camera_covariance(knowledge, attitude, attitude_batch)
            source = STAR_CAMERA_NOISE
        end if
        from_rate = matmul(rate_to_state, matmul(rotation_covariance(RATES, RATES), transpose(rate_to_state)))
        whole = whole + from_rate
        solution%covariance = whole(:3, :3)
        associate (p => solution%state_covariance)
            p(:parameters, :parameters) = whole
            p(STATE_RATE, STATE_RATE) = rotation_covariance(RATES, RATES)
            p(STATE_ATTITUDE, STATE_ATTITUDE) = rotation_covariance(ANGLES, ANGLES)
            p(STATE_ATTITUDE, STATE_RATE) = rotation_covariance(ANGLES, RATES)
            p(STATE_ATTITUDE, :parameters) = matmul(rotation_covariance(ANGLES, RATES), transpose(rate_to_state))
            p(STATE_RATE, :parameters) = matmul(rotation_covariance(RATES, RATES), transpose(rate_to_state))
            p(STATE_RATE, STATE_ATTITUDE) = transpose(p(STATE_ATTITUDE, STATE_RATE))
            p(:parameters, STATE_ATTITUDE) = transpose(p(STATE_ATTITUDE, :parameters))
            p(:parameters, STATE_RATE) = transpose(p(STATE_RATE, :parameters))
        end associate
        if (.not. present(record)) return
        by_source = 0
        by_source(:, :, :3) = by_axis(:3, :3, :)
        by_source(:, :, source) = from_rate(:3, :3)
        call record_covariance([character(12) :: OFFSET_NAMES, 'omega_x', 'omega_y', 'omega_z'], &
                               solution%state_covariance(:parameters + 3, :parameters + 3), [1, 2, 3], by_source, record)
    end subroutine propagate_noise

    !> Covariance of the small angles of the attitude, and of the angular velocity, at the epoch under the star
    !> camera's noise: rad, rad/s.
    function star_camera_covariance(knowledge, attitude, batch) result(covariance)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(attitude_problem_t), intent(in) :: attitude
        type(batch_solution_t), intent(in) :: batch
        real(dp) :: covariance(6, 6)

        real(dp), allocatable :: rate_gain(:, :), of_state(:, :), to_angles(:, :)
        integer :: n

        n = attitude%attitude_components()
        rate_gain = matmul(batch%inverse, batch%gain)
        of_state = star_noise_covariance(attitude%quaternion_gain(rate_gain), attitude%data%attitude_source, &
                                         knowledge%star_camera_sigma, knowledge%mounting, attitude%data%stars)
        to_angles = attitude%small_angle_map()
        covariance(4:, 4:) = of_state(n + 1:n + 3, n + 1:n + 3)
        covariance(:3, :3) = matmul(to_angles, matmul(of_state(:n, :n), transpose(to_angles)))
        covariance(:3, 4:) = matmul(to_angles, of_state(:n, n + 1:n + 3))
        covariance(4:, :3) = transpose(covariance(:3, 4:))
    end function star_camera_covariance
end module gracecg_estimation_assest
