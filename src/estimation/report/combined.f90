!> ASCFEST and ASCREST, the Accelerometer and Star camera Combined Full- and Reduced-dimensioned
!> ESTimations of CSR-TM-00-01 sections 4.6.2 and 4.6.3: attitude, angular velocity and CG offset from
!> all observations together.
module gracecg_estimation_combined
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_attitude_problem, only: attitude_problem_t, prepare_attitude, store_rotation
    use gracecg_estimation_offset_model, only: offset_rate_partials
    use gracecg_estimation_offset_problem, only: linearise_accelerations, OFFSET_PARAMETERS, OFFSET_NAMES, &
        offset_scales, ACCELEROMETER_AXES
    use gracecg_estimation_batch_problem, only: batch_solution_t
    use gracecg_estimation_batch_processor, only: batch_settings_t, process_batch
    use gracecg_estimation_noise_propagation, only: propagate_noise, star_noise_covariance
    use gracecg_estimation_fit_checks, only: refuse_stuck_axis, check_accelerations, check_torque
    use gracecg_base_vectors, only: identity
    use gracecg_estimation_solution, only: solution_t, store_offset, STATE, STATE_ATTITUDE, STATE_RATE
    use gracecg_estimation_iteration, only: iteration_t, rms_of
    use gracecg_estimation_fit_record, only: fit_record_t, record_rotation, STAR_CAMERA_NOISE
    implicit none
    private
    public :: estimate_combined, combined_problem_t, prepare_combined

    !> State [attitude, omega, d, alpha, beta]: 16 parameters (full) or 15 (reduced). The observations
    !> are those of the attitude, then those of the accelerometer.
    type, extends(attitude_problem_t) :: combined_problem_t
        real(dp) :: offset_state(OFFSET_PARAMETERS) = 0     !! d (m), alpha (m/s^3), beta (m/s^2)
        real(dp) :: accelerometer_weight(3) = 1             !! Of its axes
        integer :: attitude_observations = 0                !! Scalars of the attitude
    contains
        procedure :: linearise => linearise_combined
        procedure :: correct => correct_combined
        procedure :: describe_residuals => residuals_of_combined
        procedure :: describe_state => state_of_combined
    end type combined_problem_t

contains

    !> ASCFEST (full) or ASCREST (reduced).
    !>
    !> The covariance of the offset is propagated when it is asked for, or there is a record, and the fit is
    !> then checked; this costs as much as the estimate.
    !>
    !> Fails when the observations are refused or the normal matrix is singular, and, with the
    !> covariance, when the satellite did not turn as the torque rods should have made it.
    subroutine estimate_combined(observations, options, reduced, solution, error, record)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        logical, intent(in) :: reduced          !! ASCREST instead of ASCFEST
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record   !! For diagnostics; with the covariance

        type(combined_problem_t) :: problem
        type(fitting_data_t) :: data
        type(batch_settings_t) :: settings
        type(batch_solution_t) :: batch

        solution%algorithm = merge('ascrest', 'ascfest', reduced)
        call preprocess(observations, options, data, error)
        if (.not. allocated(error)) call refuse_stuck_axis(data, error)
        if (allocated(error)) return
        solution%warnings = data%warnings
        call prepare_combined(observations%knowledge, options, data, reduced, problem)
        if (options%history) settings%history = 'attitude, rate and CG offset'
        call process_batch(problem, settings, batch, error)
        if (allocated(error)) then
            call add_context(error, merge('ASCREST', 'ASCFEST', reduced))
            return
        end if
        call store_rotation(problem, batch, solution)
        solution%condition = batch%condition
        associate (residuals => batch%residuals(problem%attitude_observations + 1:), knowledge => observations%knowledge)
            call store_offset(problem%offset_state, residuals, solution)
            if (.not. (options%covariance .or. present(record))) return
            call propagate(knowledge, problem, batch, solution, error, record)
            if (allocated(error)) return
            if (present(record)) call record_rotation(data, problem%rotation, residuals, record)
            call check_accelerations(knowledge, data, residuals, solution%warnings, error)
            if (.not. allocated(error)) &
                call check_torque(knowledge, data, knowledge%star_camera_sigma, problem%quaternion, problem%angular_velocity, &
                                  solution%warnings, error, record)
        end associate
    end subroutine estimate_combined

    !> Sets up the problem from preprocessed observations.
    subroutine prepare_combined(knowledge, options, data, reduced, problem)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(fitting_data_t), intent(in) :: data
        logical, intent(in) :: reduced  !! ASCREST instead of ASCFEST
        type(combined_problem_t), intent(inout) :: problem

        call prepare_attitude(knowledge, data, reduced, problem)
        problem%names = [problem%names, OFFSET_NAMES]
        problem%scales = [problem%scales, offset_scales(knowledge%duration)]
        problem%attitude_observations = problem%observations
        problem%observations = problem%attitude_observations + 3*size(data%accelerometer_epoch)
        problem%attitude_weight = options%combined_star_camera_weight
        problem%accelerometer_weight = options%accelerometer_weight
        problem%offset_state(1:3) = options%guess_offset
    end subroutine prepare_combined

    !> H = [0, dA/d omega Phi_22, A~, t I, I; Phi_11, Phi_12, 0, 0, 0], eqs. (4-90), (4-91), (4-101), (4-102),
    !> of the observations (4-85), (4-86) or (4-94), (4-95); the zeros are (4-20), (4-26).
    subroutine linearise_combined(self, partials, residuals, weights, error)
        class(combined_problem_t), intent(inout) :: self
        real(dp), contiguous, intent(out) :: partials(:, :) !! Parameters x observations
        real(dp), intent(out) :: residuals(:), weights(:)   !! Observed minus computed; weights
        type(error_t), allocatable, intent(out) :: error

        integer :: first_offset, last_attitude, n, i, k, column, axis

        n = self%attitude_components()
        first_offset = self%attitude_parameters() + 1
        last_attitude = self%attitude_observations
        partials = 0
        call self%linearise_attitude(partials(:first_offset - 1, :last_attitude), residuals(:last_attitude))
        weights(:last_attitude) = self%attitude_weight
        call linearise_accelerations(self%data, self%rotation, self%offset_state, &
                                     partials(first_offset:, last_attitude + 1:), &
                                     residuals(last_attitude + 1:))
        do axis = 1, 3
            weights(last_attitude + axis::3) = self%accelerometer_weight(axis)
        end do
        associate (rotation => self%rotation)
            do i = 1, size(self%data%accelerometer_epoch)
                k = self%data%accelerometer_epoch(i)
                column = last_attitude + 3*(i - 1)
                partials(n + 1:n + 3, column + 1:column + 3) = transpose(matmul( &
                    offset_rate_partials(rotation%omega(:, k), self%offset_state(1:3), &
                                         self%fit%body%rate_partials(rotation%omega(:, k))), rotation%phi_22(:, :, k)))
            end do
        end associate
    end subroutine linearise_combined

    !> X* + x, (4-103).
    subroutine correct_combined(self, correction)
        class(combined_problem_t), intent(inout) :: self
        real(dp), intent(inout) :: correction(:)

        call self%attitude_problem_t%correct(correction)
        self%offset_state = self%offset_state + correction(self%attitude_parameters() + 1:)
    end subroutine correct_combined

    !> Covariance of the state under the noise of accelerometer and star camera.
    subroutine propagate(knowledge, problem, batch, solution, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(combined_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record

        real(dp), allocatable :: to_state(:, :), gain(:, :)
        integer :: n, m

        n = problem%attitude_components()
        m = problem%attitude_parameters()
        allocate (to_state(STATE, m + OFFSET_PARAMETERS), source=0.0_dp)
        to_state(STATE_ATTITUDE, :n) = problem%small_angle_map()
        to_state(STATE_RATE, n + 1:m) = identity(3)
        to_state(:OFFSET_PARAMETERS, m + 1:) = identity(OFFSET_PARAMETERS)
        gain = matmul(matmul(to_state, batch%inverse), batch%gain)
        associate (stars => problem%attitude_observations, data => problem%data)
            call propagate_noise(knowledge, gain(:, stars + 1:), data%accelerometer_epoch, &
                                 star_noise_covariance(problem%quaternion_gain(gain(:, :stars)), data%attitude_source, &
                                                       knowledge%star_camera_sigma, knowledge%mounting, data%stars), &
                                 STAR_CAMERA_NOISE, solution, error, record)
        end associate
    end subroutine propagate

    !> RMS of the residuals of the attitude, and of the accelerometer.
    subroutine residuals_of_combined(self, residuals, note)
        class(combined_problem_t), intent(in) :: self
        real(dp), intent(in) :: residuals(:)
        type(iteration_t), intent(inout) :: note

        integer :: i

        call self%attitude_problem_t%describe_residuals(residuals, note)
        note%residual_names = [note%residual_names, ACCELEROMETER_AXES]
        note%residual_rms = [note%residual_rms, (rms_of(residuals(self%attitude_observations + i::3)), i=1, 3)]
        note%residual_unit = trim(note%residual_unit)//', m/s^2'
    end subroutine residuals_of_combined

    subroutine state_of_combined(self, note)
        class(combined_problem_t), intent(in) :: self
        type(iteration_t), intent(inout) :: note

        call self%attitude_problem_t%describe_state(note)
        note%state_names = [note%state_names, OFFSET_NAMES]
        note%state = [note%state, self%offset_state]
    end subroutine state_of_combined
end module gracecg_estimation_combined
