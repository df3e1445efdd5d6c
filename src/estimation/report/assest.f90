!> ASSEST, the Accelerometer and Star camera Separate ESTimation of CSR-TM-00-01 section 4.6.1: first
!> the initial attitude and angular velocity from the star camera (or the latter from other means), then the CG offset from the
!> accelerometer along the rotation so found.
module gracecg_estimation_assest
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_text, only: append
    use gracecg_base_vectors, only: identity
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_attitude_fit, only: fitted_rotation_t
    use gracecg_estimation_attitude_problem, only: attitude_problem_t, prepare_attitude, store_rotation
    use gracecg_estimation_offset_model, only: offset_rate_partials
    use gracecg_estimation_offset_problem, only: offset_problem_t, prepare_offset, OFFSET_PARAMETERS
    use gracecg_estimation_batch_problem, only: batch_solution_t
    use gracecg_estimation_batch_processor, only: batch_settings_t, process_batch
    use gracecg_estimation_noise_propagation, only: propagate_noise, star_noise_covariance
    use gracecg_estimation_fit_checks, only: refuse_stuck_axis, check_accelerations, check_torque
    use gracecg_estimation_solution, only: solution_t, store_offset, STATE, STATE_ATTITUDE, STATE_RATE
    use gracecg_estimation_fit_record, only: fit_record_t, record_rotation, STAR_CAMERA_NOISE, A_PRIORI_KNOWLEDGE
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
            call propagate(knowledge, attitude, attitude_batch, offset, offset_batch, solution, error, record)
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
        call store_rotation(attitude, batch, solution)
    end subroutine find_rotation

    !> Covariance of the state under the instruments' noise: that of the accelerometer, and that of the star camera, or of
    !> the knowledge that replaces it, through the error of omega(t0).
    subroutine propagate(knowledge, attitude, attitude_batch, offset, offset_batch, solution, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(attitude_problem_t), intent(in) :: attitude
        type(batch_solution_t), intent(in) :: attitude_batch
        type(offset_problem_t), intent(in) :: offset
        type(batch_solution_t), intent(in) :: offset_batch
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record

        real(dp), allocatable :: gain(:, :)
        real(dp) :: to_state(STATE, 6), rotation_covariance(6, 6)   ! of small angles, then the angular velocity
        integer, parameter :: RATES(3) = [4, 5, 6]
        integer :: i, source

        allocate (gain(STATE, offset%observations), source=0.0_dp)
        gain(:OFFSET_PARAMETERS, :) = matmul(offset_batch%inverse, offset_batch%gain)
        to_state = 0
        to_state(STATE_ATTITUDE, :3) = identity(3)
        to_state(STATE_RATE, RATES) = identity(3)
        associate (rotation => offset%rotation, epoch => offset%data%accelerometer_epoch)
            do i = 1, size(epoch)
                associate (k => epoch(i), of_sample => gain(:OFFSET_PARAMETERS, 3*i - 2:3*i))
                    to_state(:OFFSET_PARAMETERS, RATES) = to_state(:OFFSET_PARAMETERS, RATES) - matmul(of_sample, matmul( &
                        offset_rate_partials(rotation%omega(:, k), offset%state(1:3), &
                                             attitude%fit%body%rate_partials(rotation%omega(:, k))), rotation%phi_22(:, :, k)))
                end associate
            end do
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
            call propagate_noise(knowledge, gain, epoch, matmul(to_state, matmul(rotation_covariance, transpose(to_state))), &
                                 source, solution, error, record)
        end associate
    end subroutine propagate

    !> Covariance of the small angles of the attitude, and of the angular velocity, at the epoch under the star
    !> camera's noise: rad, rad/s.
    function star_camera_covariance(knowledge, attitude, batch) result(covariance)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(attitude_problem_t), intent(in) :: attitude
        type(batch_solution_t), intent(in) :: batch
        real(dp) :: covariance(6, 6)

        real(dp) :: to_angles(6, size(batch%inverse, 1))
        integer :: n

        n = attitude%attitude_components()
        to_angles = 0
        to_angles(:3, :n) = attitude%small_angle_map()
        to_angles(4:, n + 1:) = identity(3)
        covariance = star_noise_covariance( &
                     attitude%quaternion_gain(matmul(to_angles, matmul(batch%inverse, batch%gain))), &
                     attitude%data%attitude_source, knowledge%star_camera_sigma, knowledge%mounting, attitude%data%stars)
    end function star_camera_covariance
end module gracecg_estimation_assest
