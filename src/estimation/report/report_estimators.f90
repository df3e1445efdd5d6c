!> The estimators of CSR-TM-00-01 section 4.6. ASSEST, the Accelerometer and Star camera Separate ESTimation (4.6.1): first
!> the initial attitude and angular velocity from the star camera (or the latter from other means), then the CG offset from
!> the accelerometer along the rotation so found. ASCFEST and ASCREST, the Accelerometer and Star camera Combined Full- and
!> Reduced-dimensioned ESTimations (4.6.2, 4.6.3): attitude, angular velocity and CG offset from all observations together.
module gracecg_estimation_report_estimators
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_text, only: append
    use gracecg_base_vectors, only: identity
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_offset_model, only: offset_rate_partials
    use gracecg_estimation_report_problem, only: report_problem_t, prepare_problem, OFFSET_PARAMETERS
    use gracecg_estimation_batch_problem, only: batch_solution_t
    use gracecg_estimation_batch_processor, only: batch_settings_t, process_batch
    use gracecg_estimation_noise_propagation, only: propagate_noise, star_noise_covariance
    use gracecg_estimation_fit_checks, only: refuse_stuck_axis, check_accelerations, check_torque
    use gracecg_estimation_solution, only: solution_t, store_offset, STATE, STATE_ATTITUDE, STATE_RATE
    use gracecg_estimation_fit_record, only: fit_record_t, record_rotation, STAR_CAMERA_NOISE, A_PRIORI_KNOWLEDGE
    implicit none
    private
    public :: estimate_assest, estimate_combined

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

        type(report_problem_t) :: problem
        type(batch_solution_t) :: attitude, offset
        real(dp), allocatable :: gain(:, :)
        real(dp) :: by_rotation(STATE, STATE)

        solution%algorithm = merge('assest-rde', 'assest-fde', reduced)
        associate (knowledge => observations%knowledge, known => observations%knowledge%knows_angular_velocity())
            call begin(observations, options, reduced, known, problem, solution, error)
            if (allocated(error)) return
            if (known) then
                problem%angular_velocity = knowledge%angular_velocity
                solution%angular_velocity = knowledge%angular_velocity
                solution%converged = .true.
                call append(solution%warnings, 'the angular velocity at the epoch is that of the setup, from other means: '// &
                            'no star camera was used, and nothing tells whether the satellite turned as the setup '// &
                            'should have made it')
            else
                call problem%choose(attitude=.true., offset=.false.)
                call fit(options, 'attitude and rate', problem, attitude, solution, error)
                call add_context(error, 'ASSEST, angular velocity from the star camera')
                if (allocated(error)) return
                call store_rotation(problem, attitude, solution)
            end if
            call problem%choose(attitude=.false., offset=.true.)
            call fit(options, 'CG offset', problem, offset, solution, error)
            call add_context(error, 'ASSEST, CG offset from the accelerometer')
            if (allocated(error)) return
            solution%condition = offset%condition
            call store_offset(problem%offset_state, offset%residuals, solution)
            if (.not. (options%covariance .or. present(record))) return
            call propagate_rotation(knowledge, known, problem, attitude, offset, gain, by_rotation)
            call propagate_noise(knowledge, gain, problem%data%accelerometer_epoch, by_rotation, &
                                 merge(A_PRIORI_KNOWLEDGE, STAR_CAMERA_NOISE, known), solution, error, record)
            if (.not. allocated(error)) call check_fit(knowledge, problem, offset%residuals, .not. known, solution, error, record)
        end associate
    end subroutine estimate_assest

    !> ASCFEST (full) or ASCREST (reduced). Covariance, checks and failures as of estimate_assest.
    subroutine estimate_combined(observations, options, reduced, solution, error, record)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        logical, intent(in) :: reduced          !! ASCREST instead of ASCFEST
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record   !! For diagnostics; with the covariance

        type(report_problem_t) :: problem
        type(batch_solution_t) :: batch
        real(dp), allocatable :: to_state(:, :), gain(:, :)

        solution%algorithm = merge('ascrest', 'ascfest', reduced)
        call begin(observations, options, reduced, .false., problem, solution, error)
        if (allocated(error)) return
        problem%attitude_weight = options%combined_star_camera_weight
        call problem%choose(attitude=.true., offset=.true.)
        call fit(options, 'attitude, rate and CG offset', problem, batch, solution, error)
        call add_context(error, merge('ASCREST', 'ASCFEST', reduced))
        if (allocated(error)) return
        call store_rotation(problem, batch, solution)
        solution%condition = batch%condition
        associate (knowledge => observations%knowledge, stars => problem%attitude_observations, n => problem%components, &
                   m => problem%attitude_parameters)
            call store_offset(problem%offset_state, batch%residuals(stars + 1:), solution)
            if (.not. (options%covariance .or. present(record))) return
            allocate (to_state(STATE, m + OFFSET_PARAMETERS), source=0.0_dp)
            to_state(STATE_ATTITUDE, :n) = problem%small_angle_map()
            to_state(STATE_RATE, n + 1:m) = identity(3)
            to_state(:OFFSET_PARAMETERS, m + 1:) = identity(OFFSET_PARAMETERS)
            gain = matmul(matmul(to_state, batch%inverse), batch%gain)
            call propagate_noise(knowledge, gain(:, stars + 1:), problem%data%accelerometer_epoch, &
                                 by_star_camera(knowledge, problem, gain(:, :stars)), STAR_CAMERA_NOISE, solution, error, record)
            if (.not. allocated(error)) &
                call check_fit(knowledge, problem, batch%residuals(stars + 1:), .true., solution, error, record)
        end associate
    end subroutine estimate_combined

    !> The problem at its first guess.
    subroutine begin(observations, options, reduced, without_attitude, problem, solution, error)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        logical, intent(in) :: reduced, without_attitude
        type(report_problem_t), intent(out) :: problem
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(fitting_data_t) :: data

        call preprocess(observations, options, data, error, without_attitude)
        if (.not. allocated(error)) call refuse_stuck_axis(data, error)
        if (allocated(error)) return
        solution%warnings = data%warnings
        if (options%history) allocate (solution%history(0))
        call prepare_problem(observations%knowledge, options, data, reduced, problem)
    end subroutine begin

    !> Runs the batch processor, its iterations behind those in the solution's history.
    subroutine fit(options, name, problem, batch, solution, error)
        type(estimation_options_t), intent(in) :: options
        character(*), intent(in) :: name        !! What is fitted, for the history
        type(report_problem_t), intent(inout) :: problem
        type(batch_solution_t), intent(out) :: batch
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(batch_settings_t) :: settings

        if (options%history) settings%history = name
        call process_batch(problem, settings, batch, error)
        if (options%history .and. .not. allocated(error)) solution%history = [solution%history, batch%history]
    end subroutine fit

    !> Puts attitude and angular velocity of a fit into a solution.
    subroutine store_rotation(problem, batch, solution)
        type(report_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch
        type(solution_t), intent(inout) :: solution

        solution%quaternion = problem%quaternion
        solution%angular_velocity = problem%angular_velocity
        solution%iterations = batch%iterations
        solution%converged = batch%converged
    end subroutine store_rotation

    !> Of ASSEST: the response of the state to the accelerometer, and its covariance by the noise of the star camera, or by
    !> the error of the knowledge that replaces it, through the error of omega(t0).
    subroutine propagate_rotation(knowledge, known, problem, attitude, offset, gain, covariance)
        type(operator_knowledge_t), intent(in) :: knowledge
        logical, intent(in) :: known                !! The angular velocity, from other means
        type(report_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: attitude, offset
        real(dp), allocatable, intent(out) :: gain(:, :)        !! STATE x (3 times samples)
        real(dp), intent(out) :: covariance(STATE, STATE)

        integer, parameter :: RATES(3) = [4, 5, 6]
        real(dp) :: to_state(STATE, 6), rotation_covariance(6, 6)   ! of small angles, then the angular velocity
        real(dp) :: to_angles(6, problem%components + 3)
        integer :: i

        allocate (gain(STATE, problem%observations), source=0.0_dp)
        gain(:OFFSET_PARAMETERS, :) = matmul(offset%inverse, offset%gain)
        to_state = 0
        to_state(STATE_ATTITUDE, :3) = identity(3)
        to_state(STATE_RATE, RATES) = identity(3)
        associate (rotation => problem%rotation, epoch => problem%data%accelerometer_epoch)
            do i = 1, size(epoch)
                associate (omega => rotation%omega(:, epoch(i)), of_sample => gain(:OFFSET_PARAMETERS, 3*i - 2:3*i))
                    to_state(:OFFSET_PARAMETERS, RATES) = to_state(:OFFSET_PARAMETERS, RATES) - matmul(of_sample, matmul( &
                        offset_rate_partials(omega, problem%offset_state(1:3), problem%fit%body%rate_partials(omega)), &
                        rotation%phi_22(:, :, epoch(i))))
                end associate
            end do
        end associate
        if (known) then
            rotation_covariance = 0
            do i = 1, 3
                rotation_covariance(RATES(i), RATES(i)) = knowledge%angular_velocity_sigma(i)**2
            end do
        else
            to_angles = 0
            to_angles(:3, :problem%components) = problem%small_angle_map()
            to_angles(4:, problem%components + 1:) = identity(3)
            rotation_covariance = by_star_camera(knowledge, problem, matmul(to_angles, matmul(attitude%inverse, attitude%gain)))
        end if
        covariance = matmul(to_state, matmul(rotation_covariance, transpose(to_state)))
    end subroutine propagate_rotation

    !> Covariance by the star camera's noise of what responds to the attitude observations by a gain.
    function by_star_camera(knowledge, problem, gain) result(covariance)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(report_problem_t), intent(in) :: problem
        real(dp), intent(in) :: gain(:, :)          !! Parameters x attitude observations
        real(dp) :: covariance(size(gain, 1), size(gain, 1))

        covariance = star_noise_covariance(problem%quaternion_gain(gain), problem%data%attitude_source, &
                                           knowledge%star_camera_sigma, knowledge%mounting, problem%data%stars)
    end function by_star_camera

    !> Whether residuals and torque are what the setup says; what there is for a record.
    subroutine check_fit(knowledge, problem, residuals, has_attitude, solution, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(report_problem_t), intent(in) :: problem
        real(dp), intent(in) :: residuals(:)        !! Of the accelerometer, m/s^2
        logical, intent(in) :: has_attitude         !! The rotation was seen
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record

        if (present(record)) call record_rotation(problem%data, problem%rotation, residuals, record)
        call check_accelerations(knowledge, problem%data, residuals, solution%warnings, error)
        if (.not. allocated(error) .and. has_attitude) &
            call check_torque(knowledge, problem%data, knowledge%star_camera_sigma, problem%quaternion, &
                              problem%angular_velocity, solution%warnings, error, record)
    end subroutine check_fit
end module gracecg_estimation_report_estimators
