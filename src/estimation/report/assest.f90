!> ASSEST, the Accelerometer and Star camera Separate ESTimation of CSR-TM-00-01 section 4.6.1: first
!> the initial attitude and angular velocity from the star camera, then the CG offset from the
!> accelerometer along the rotation so found.
module gracecg_estimation_assest
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_attitude_fit, only: fitted_rotation_t
    use gracecg_estimation_attitude_problem, only: attitude_problem_t, prepare_attitude
    use gracecg_estimation_offset_model, only: offset_rate_partials
    use gracecg_estimation_offset_problem, only: offset_problem_t, prepare_offset, OFFSET_PARAMETERS, OFFSET_NAMES
    use gracecg_estimation_batch_processor, only: batch_settings_t, batch_solution_t, process_batch
    use gracecg_estimation_noise_propagation, only: accelerometer_noise_covariance, star_noise_covariance
    use gracecg_estimation_fit_checks, only: refuse_stuck_axis, check_accelerations, check_torque
    use gracecg_estimation_solution, only: solution_t, store_offset, STATE_ATTITUDE, STATE_RATE
    use gracecg_estimation_fit_record, only: fit_record_t, record_rotation, record_covariance, NOISE_SOURCES, &
        STAR_CAMERA_NOISE
    implicit none
    private
    public :: estimate_assest

contains

    !> ASSEST with the angular velocity from Full (FDE) or Reduced Dimension Estimation (RDE).
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

        solution%algorithm = merge('assest-rde', 'assest-fde', reduced)
        call preprocess(observations, options, data, error)
        if (.not. allocated(error)) call refuse_stuck_axis(data, error)
        if (allocated(error)) return
        solution%warnings = data%warnings
        call prepare_attitude(observations%knowledge, data, reduced, attitude)
        attitude%attitude_weight = options%star_camera_weight
        if (options%history) settings%history = 'attitude and rate'
        call process_batch(attitude, settings, attitude_batch, error)
        if (allocated(error)) then
            call add_context(error, 'ASSEST, angular velocity from the star camera')
            return
        end if
        call attitude%fit%fit_rotation(attitude%angular_velocity, rotation)
        call prepare_offset(observations%knowledge, options, data, rotation, offset)
        if (options%history) settings%history = 'CG offset'
        call process_batch(offset, settings, offset_batch, error)
        if (allocated(error)) then
            call add_context(error, 'ASSEST, CG offset from the accelerometer')
            return
        end if
        solution%quaternion = attitude%quaternion
        solution%angular_velocity = attitude%angular_velocity
        solution%iterations = attitude_batch%iterations
        solution%converged = attitude_batch%converged
        solution%condition = offset_batch%condition
        if (options%history) solution%history = [attitude_batch%history, offset_batch%history]
        call store_offset(offset%state, offset_batch%residuals, solution)
        if (options%covariance .or. present(record)) then
            call propagate_noise(observations%knowledge, attitude, attitude_batch, offset, offset_batch, &
                                 solution, error, record)
            if (present(record)) call record_rotation(data, rotation, offset_batch%residuals, record)
            if (.not. allocated(error)) &
                call check_accelerations(observations%knowledge, data, offset_batch%residuals, &
                                         solution%warnings, error)
            if (.not. allocated(error)) &
                call check_torque(observations%knowledge, data, observations%knowledge%star_camera_sigma, &
                                  attitude%quaternion, attitude%angular_velocity, solution%warnings, error, record)
        end if
    end subroutine estimate_assest

    !> Covariance of the offset and of the whole state under the instruments' noise: that of the accelerometer, with its
    !> spectrum (3-2), and that of the star camera through the error of omega(t0).
    subroutine propagate_noise(knowledge, attitude, attitude_batch, offset, offset_batch, solution, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(attitude_problem_t), intent(in) :: attitude
        type(batch_solution_t), intent(in) :: attitude_batch
        type(offset_problem_t), intent(in) :: offset
        type(batch_solution_t), intent(in) :: offset_batch
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record

        real(dp), allocatable :: gain(:, :), rate_gain(:, :), whole(:, :), by_axis(:, :, :), from_rate(:, :)
        real(dp), allocatable :: rate_to_state(:, :)
        real(dp), allocatable :: of_attitude(:, :), to_angles(:, :)
        real(dp) :: rate_covariance(3, 3), by_source(3, 3, NOISE_SOURCES)
        integer :: i, k, row, n
        integer, parameter :: parameters = OFFSET_PARAMETERS

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
                                offset_rate_partials(rotation%omega(:, k), &
                                                     attitude%fit%body%rate_partials(rotation%omega(:, k)), &
                                                     offset%state(1:3)), rotation%phi_22(:, :, k)))
            end do
        end associate
        n = attitude%attitude_components()
        rate_gain = matmul(attitude_batch%inverse, attitude_batch%gain)
        of_attitude = star_noise_covariance( &
                          attitude%quaternion_gain(rate_gain), attitude%data%attitude_source, &
                          knowledge%star_camera_sigma, knowledge%mounting, attitude%data%stars)
        rate_covariance = of_attitude(n + 1:n + 3, n + 1:n + 3)
        from_rate = matmul(rate_to_state, matmul(rate_covariance, transpose(rate_to_state)))
        whole = whole + from_rate
        solution%covariance = whole(:3, :3)
        to_angles = attitude%small_angle_map()
        associate (p => solution%state_covariance, &
                   angles_rate => matmul(to_angles, of_attitude(:n, n + 1:n + 3)))
            p(:parameters, :parameters) = whole
            p(STATE_RATE, STATE_RATE) = rate_covariance
            p(STATE_ATTITUDE, STATE_ATTITUDE) = matmul(to_angles, matmul(of_attitude(:n, :n), transpose(to_angles)))
            p(STATE_ATTITUDE, STATE_RATE) = angles_rate
            p(STATE_ATTITUDE, :parameters) = matmul(angles_rate, transpose(rate_to_state))
            p(STATE_RATE, :parameters) = matmul(rate_covariance, transpose(rate_to_state))
            p(STATE_RATE, STATE_ATTITUDE) = transpose(p(STATE_ATTITUDE, STATE_RATE))
            p(:parameters, STATE_ATTITUDE) = transpose(p(STATE_ATTITUDE, :parameters))
            p(:parameters, STATE_RATE) = transpose(p(STATE_RATE, :parameters))
        end associate
        if (.not. present(record)) return
        by_source = 0
        by_source(:, :, :3) = by_axis(:3, :3, :)
        by_source(:, :, STAR_CAMERA_NOISE) = from_rate(:3, :3)
        call record_covariance([character(12) :: OFFSET_NAMES, 'omega_x', 'omega_y', 'omega_z'], &
                               solution%state_covariance(:parameters + 3, :parameters + 3), [1, 2, 3], by_source, record)
    end subroutine propagate_noise
end module gracecg_estimation_assest
