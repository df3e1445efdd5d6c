!> ASSEST, the Accelerometer and Star camera Separate ESTimation of CSR-TM-00-01 section 4.6.1: first
!> the initial attitude and angular velocity from the star camera, then the CG offset from the
!> accelerometer along the angular velocity so found.
module gracecg_assest
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t, add_context
    use gracecg_quaternion, only: normalised
    use gracecg_coloured_noise, only: coloured_noise_t, coloured_noise
    use gracecg_observation_set, only: observation_set_t, calibration_setup_t
    use gracecg_preprocessing, only: fitting_data_t, preprocess
    use gracecg_attitude_fit, only: attitude_fit_t, fitted_rotation_t, fitted_attitude_t, new_attitude_fit
    use gracecg_offset_model, only: offset_matrix, offset_rate_partials
    use gracecg_batch_processor, only: batch_problem_t, batch_settings_t, batch_solution_t, process_batch
    use gracecg_noise_propagation, only: stationary_noise_covariance, star_noise_covariance
    use gracecg_calibration_solution, only: calibration_solution_t
    implicit none
    private
    public :: estimate_assest_fde

    real(dp), parameter :: TYPICAL_RATE = 1e-3_dp           !! Scale of the angular velocity, rad/s
    real(dp), parameter :: TYPICAL_OFFSET = 1e-3_dp         !! m
    real(dp), parameter :: TYPICAL_ACCELERATION = 1e-6_dp   !! m/s^2

    !> Full Dimension Estimation (FDE): state [q(t0), omega(t0)], eqs. (4-50)-(4-57).
    type, extends(batch_problem_t) :: angular_velocity_fde_t
        type(attitude_fit_t) :: fit
        type(fitting_data_t) :: data
        real(dp) :: quaternion(4)                   !! q*(t0)
        real(dp) :: angular_velocity(3)             !! omega*(t0), rad/s
        real(dp) :: weight                          !! Of every quaternion component
    contains
        procedure :: linearise => linearise_fde
        procedure :: correct => correct_fde
    end type angular_velocity_fde_t

    !> The offset with drift and bias: state [d, alpha, beta], eqs. (4-80)-(4-82). Linear.
    type, extends(batch_problem_t) :: separate_offset_t
        type(fitting_data_t) :: data
        type(fitted_rotation_t) :: rotation
        real(dp) :: state(9)                        !! d (m), alpha (m/s^3), beta (m/s^2)
        real(dp) :: weight(3)
    contains
        procedure :: linearise => linearise_offset
        procedure :: correct => correct_offset
    end type separate_offset_t

contains

    !> ASSEST with the angular velocity from FDE.
    !>
    !> Fails when the observations are refused or a normal matrix is singular.
    subroutine estimate_assest_fde(observations, solution, error, with_covariance)
        type(observation_set_t), intent(in) :: observations
        type(calibration_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: with_covariance
        !! Compute solution%covariance (default true); it costs more than the estimate itself

        type(angular_velocity_fde_t) :: attitude
        type(separate_offset_t) :: offset
        type(batch_settings_t) :: settings
        type(batch_solution_t) :: attitude_batch, offset_batch
        logical :: covariance_wanted

        covariance_wanted = .true.
        if (present(with_covariance)) covariance_wanted = with_covariance
        solution%algorithm = 'assest-fde'
        associate (setup => observations%setup)
            call preprocess(observations, attitude%data, error)
            if (allocated(error)) return
            attitude%fit = new_attitude_fit(setup%inertia, attitude%data%interval, attitude%data%torque)
            call prepare_fde(setup, attitude)
            call process_batch(attitude, settings, attitude_batch, error)
            if (allocated(error)) then
                call add_context(error, 'ASSEST, angular velocity from the star camera')
                return
            end if
            call attitude%fit%fit_rotation(attitude%angular_velocity, offset%rotation)
            offset%data = attitude%data
            call prepare_offset(setup, offset)
            call process_batch(offset, settings, offset_batch, error)
            if (allocated(error)) then
                call add_context(error, 'ASSEST, CG offset from the accelerometer')
                return
            end if
            solution%offset = offset%state(1:3)
            solution%drift = offset%state(4:6)
            solution%bias = offset%state(7:9)
            solution%quaternion = normalised(attitude%quaternion)
            solution%angular_velocity = attitude%angular_velocity
            solution%iterations = attitude_batch%iterations
            solution%converged = attitude_batch%converged
            solution%condition = offset_batch%condition
            solution%residual_rms = root_mean_square(reshape(offset_batch%residuals, &
                                                             [3, size(offset_batch%residuals)/3]))
            if (covariance_wanted) then
                call propagate_noise(setup, attitude, attitude_batch, offset, offset_batch, &
                                     solution%covariance, error)
            end if
        end associate
    end subroutine estimate_assest_fde

    subroutine prepare_fde(setup, problem)
        type(calibration_setup_t), intent(in) :: setup
        type(angular_velocity_fde_t), intent(inout) :: problem

        problem%names = [character(12) :: 'q1', 'q2', 'q3', 'q4', 'omega_x', 'omega_y', 'omega_z']
        problem%scales = [1.0_dp, 1.0_dp, 1.0_dp, 1.0_dp, TYPICAL_RATE, TYPICAL_RATE, TYPICAL_RATE]
        problem%observations = 4*size(problem%data%attitude_epoch)
        problem%quaternion = normalised(setup%guess_quaternion)
        problem%angular_velocity = setup%guess_angular_velocity
        problem%weight = setup%star_camera_weight
    end subroutine prepare_fde

    subroutine linearise_fde(self, partials, residuals, weights, error)
        class(angular_velocity_fde_t), intent(inout) :: self
        real(dp), contiguous, intent(out) :: partials(:, :)
        real(dp), intent(out) :: residuals(:), weights(:)
        type(error_t), allocatable, intent(out) :: error

        type(fitted_attitude_t) :: attitude
        type(fitted_rotation_t) :: rotation
        integer :: i, k, row

        call self%fit%fit_attitude(self%quaternion, self%angular_velocity, attitude, rotation)
        do i = 1, size(self%data%attitude_epoch)
            k = self%data%attitude_epoch(i)
            row = 4*(i - 1)
            partials(1:4, row + 1:row + 4) = transpose(attitude%phi_11(:, :, k))
            partials(5:7, row + 1:row + 4) = transpose(attitude%phi_12(:, :, k))
            residuals(row + 1:row + 4) = self%data%quaternion(:, i) - attitude%q(:, k)
        end do
        weights = self%weight
    end subroutine linearise_fde

    !> X* + x; the nominal quaternion is normalised before the next iteration.
    subroutine correct_fde(self, correction)
        class(angular_velocity_fde_t), intent(inout) :: self
        real(dp), intent(in) :: correction(:)

        self%quaternion = normalised(self%quaternion + correction(1:4))
        self%angular_velocity = self%angular_velocity + correction(5:7)
    end subroutine correct_fde

    subroutine prepare_offset(setup, problem)
        type(calibration_setup_t), intent(in) :: setup
        type(separate_offset_t), intent(inout) :: problem

        problem%names = [character(12) :: 'd_x', 'd_y', 'd_z', 'alpha_x', 'alpha_y', 'alpha_z', &
                         'beta_x', 'beta_y', 'beta_z']
        problem%scales = [spread(TYPICAL_OFFSET, 1, 3), &
                          spread(TYPICAL_ACCELERATION/setup%duration, 1, 3), &
                          spread(TYPICAL_ACCELERATION, 1, 3)]
        problem%observations = 3*size(problem%data%accelerometer_epoch)
        problem%linear = .true.
        problem%state = 0
        problem%state(1:3) = setup%guess_offset
        problem%weight = setup%accelerometer_weight
    end subroutine prepare_offset

    !> H = [A~, t I, I], eq. (4-82).
    subroutine linearise_offset(self, partials, residuals, weights, error)
        class(separate_offset_t), intent(inout) :: self
        real(dp), contiguous, intent(out) :: partials(:, :)
        real(dp), intent(out) :: residuals(:), weights(:)
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: t, a(3, 3)
        integer :: i, k, row, axis

        partials = 0
        do i = 1, size(self%data%accelerometer_epoch)
            k = self%data%accelerometer_epoch(i)
            t = k*self%data%interval
            row = 3*(i - 1)
            a = offset_matrix(self%rotation%omega(:, k), self%rotation%omega_dot(:, k))
            partials(1:3, row + 1:row + 3) = transpose(a)
            do axis = 1, 3
                partials(3 + axis, row + axis) = t
                partials(6 + axis, row + axis) = 1
            end do
            residuals(row + 1:row + 3) = self%data%acceleration(:, i) - &
                                         matmul(a, self%state(1:3)) - self%state(4:6)*t - self%state(7:9)
            weights(row + 1:row + 3) = self%weight
        end do
    end subroutine linearise_offset

    subroutine correct_offset(self, correction)
        class(separate_offset_t), intent(inout) :: self
        real(dp), intent(in) :: correction(:)

        self%state = self%state + correction
    end subroutine correct_offset

    !> Covariance of the offset under the instruments' noise: that of the accelerometer, with its
    !> spectrum (3-2), and that of the star camera through the error of omega(t0).
    subroutine propagate_noise(setup, attitude, attitude_batch, offset, offset_batch, covariance, error)
        type(calibration_setup_t), intent(in) :: setup
        type(angular_velocity_fde_t), intent(in) :: attitude
        type(batch_solution_t), intent(in) :: attitude_batch
        type(separate_offset_t), intent(in) :: offset
        type(batch_solution_t), intent(in) :: offset_batch
        real(dp), intent(out) :: covariance(3, 3)
        type(error_t), allocatable, intent(out) :: error

        type(coloured_noise_t) :: noise
        real(dp), allocatable :: gain(:, :), star_gain(:, :)
        real(dp) :: state_covariance(7, 7), rate_to_offset(3, 3)
        integer :: axis, i, k, row, n

        n = offset%data%steps
        gain = matmul(offset_batch%inverse, offset_batch%gain)
        covariance = 0
        do axis = 1, 3
            noise = coloured_noise(setup%accelerometer_psd_level(axis), &
                                   setup%accelerometer_psd_corner(axis), &
                                   setup%accelerometer_psd_sides, setup%accelerometer_interval, error)
            if (allocated(error)) return
            covariance = covariance + stationary_noise_covariance( &
                         gain(1:3, axis::3), offset%data%accelerometer_epoch, &
                         noise%autocovariance([(i, i=0, n)]))
        end do

        rate_to_offset = 0
        do i = 1, size(offset%data%accelerometer_epoch)
            k = offset%data%accelerometer_epoch(i)
            row = 3*(i - 1)
            rate_to_offset = rate_to_offset - matmul(gain(1:3, row + 1:row + 3), matmul( &
                             offset_rate_partials(offset%rotation%omega(:, k), &
                                                  attitude%fit%rate_partials(offset%rotation%omega(:, k)), &
                                                  offset%state(1:3)), offset%rotation%phi_22(:, :, k)))
        end do
        star_gain = matmul(attitude_batch%inverse, attitude_batch%gain)
        state_covariance = star_noise_covariance( &
                           reshape(star_gain, [7, 4, size(star_gain, 2)/4]), attitude%data%attitude_source, &
                           setup%star_camera_sigma, setup%mounting(:, setup%camera), &
                           attitude%data%star_quaternion)
        covariance = covariance + matmul(rate_to_offset, matmul(state_covariance(5:7, 5:7), &
                                                                transpose(rate_to_offset)))
    end subroutine propagate_noise

    pure function root_mean_square(values) result(rms)
        real(dp), intent(in) :: values(:, :)    !! (3, samples)
        real(dp) :: rms(3)

        rms = sqrt(sum(values**2, 2)/size(values, 2))
    end function root_mean_square
end module gracecg_assest
