!> ASSEST, the Accelerometer and Star camera Separate ESTimation of CSR-TM-00-01 section 4.6.1: first
!> the initial attitude and angular velocity from the star camera, then the CG offset from the
!> accelerometer along the rotation so found.
module gracecg_assest
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t, add_context
    use gracecg_observation_set, only: observation_set_t, calibration_setup_t
    use gracecg_preprocessing, only: fitting_data_t, preprocess
    use gracecg_attitude_fit, only: fitted_rotation_t
    use gracecg_attitude_problem, only: attitude_problem_t, prepare_attitude
    use gracecg_offset_model, only: offset_rate_partials
    use gracecg_offset_problem, only: offset_problem_t, prepare_offset
    use gracecg_batch_processor, only: batch_settings_t, batch_solution_t, process_batch
    use gracecg_noise_propagation, only: accelerometer_noise_covariance, star_noise_covariance
    use gracecg_fit_checks, only: refuse_stuck_axis, check_accelerations, check_torque
    use gracecg_calibration_solution, only: calibration_solution_t, store_offset
    implicit none
    private
    public :: estimate_assest

contains

    !> ASSEST with the angular velocity from Full (FDE) or Reduced Dimension Estimation (RDE).
    !>
    !> Fails when the observations are refused or a normal matrix is singular, and, with the
    !> covariance, when the satellite did not turn as the torque rods should have made it.
    subroutine estimate_assest(observations, reduced, solution, error, with_covariance)
        type(observation_set_t), intent(in) :: observations
        logical, intent(in) :: reduced          !! RDE instead of FDE
        type(calibration_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in) :: with_covariance
        !! Compute solution%covariance and check the torque; it costs as much as the estimate itself

        type(attitude_problem_t) :: attitude
        type(offset_problem_t) :: offset
        type(fitting_data_t) :: data
        type(fitted_rotation_t) :: rotation
        type(batch_settings_t) :: settings
        type(batch_solution_t) :: attitude_batch, offset_batch

        solution%algorithm = merge('assest-rde', 'assest-fde', reduced)
        call preprocess(observations, data, error)
        if (.not. allocated(error)) call refuse_stuck_axis(data, error)
        if (allocated(error)) return
        solution%warnings = data%warnings
        call prepare_attitude(observations%setup, data, reduced, attitude)
        call process_batch(attitude, settings, attitude_batch, error)
        if (allocated(error)) then
            call add_context(error, 'ASSEST, angular velocity from the star camera')
            return
        end if
        call attitude%fit%fit_rotation(attitude%angular_velocity, rotation)
        call prepare_offset(observations%setup, data, rotation, offset)
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
        call store_offset(offset%state, offset_batch%residuals, solution)
        if (with_covariance) then
            call propagate_noise(observations%setup, attitude, attitude_batch, offset, offset_batch, &
                                 solution%covariance, error)
            if (.not. allocated(error)) &
                call check_accelerations(observations%setup, data, offset_batch%residuals, &
                                         solution%warnings, error)
            if (.not. allocated(error)) call check_torque(observations%setup, attitude, solution%warnings, error)
        end if
    end subroutine estimate_assest

    !> Covariance of the offset under the instruments' noise: that of the accelerometer, with its
    !> spectrum (3-2), and that of the star camera through the error of omega(t0).
    subroutine propagate_noise(setup, attitude, attitude_batch, offset, offset_batch, covariance, error)
        type(calibration_setup_t), intent(in) :: setup
        type(attitude_problem_t), intent(in) :: attitude
        type(batch_solution_t), intent(in) :: attitude_batch
        type(offset_problem_t), intent(in) :: offset
        type(batch_solution_t), intent(in) :: offset_batch
        real(dp), intent(out) :: covariance(3, 3)
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: gain(:, :), rate_gain(:, :)
        real(dp) :: rate_covariance(3, 3), rate_to_offset(3, 3)
        integer :: i, k, row, n

        gain = matmul(offset_batch%inverse(1:3, :), offset_batch%gain)
        call accelerometer_noise_covariance(setup, gain, offset%data%accelerometer_epoch, covariance, error)
        if (allocated(error)) return

        rate_to_offset = 0
        associate (rotation => offset%rotation)
            do i = 1, size(offset%data%accelerometer_epoch)
                k = offset%data%accelerometer_epoch(i)
                row = 3*(i - 1)
                rate_to_offset = rate_to_offset - matmul(gain(:, row + 1:row + 3), matmul( &
                                 offset_rate_partials(rotation%omega(:, k), &
                                                      attitude%fit%rate_partials(rotation%omega(:, k)), &
                                                      offset%state(1:3)), rotation%phi_22(:, :, k)))
            end do
        end associate
        n = attitude%attitude_components()
        rate_gain = matmul(attitude_batch%inverse(n + 1:n + 3, :), attitude_batch%gain)
        rate_covariance = star_noise_covariance( &
                          attitude%quaternion_gain(rate_gain), attitude%data%attitude_source, &
                          setup%star_camera_sigma, setup%mounting, attitude%data%stars)
        covariance = covariance + matmul(rate_to_offset, matmul(rate_covariance, transpose(rate_to_offset)))
    end subroutine propagate_noise
end module gracecg_assest
