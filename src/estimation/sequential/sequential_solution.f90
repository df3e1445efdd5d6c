!> What the estimator `sequential` hands out of its last fit: the solution with its covariance, what is to be said
!> of it, and the record for diagnostics.
module gracecg_estimation_sequential_solution
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: append, string_t
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_parameters, only: parameter_names, parameter_units, TORQUE, OFFSET, DRIFT, &
        BIAS, RATE, ATTITUDE_ANGLES
    use gracecg_estimation_physical_model, only: model_state_t, correct_state
    use gracecg_estimation_square_root_information, only: constants_t
    use gracecg_estimation_linearised_samples, only: filter_problem_t, SHARED, FREQUENCY, run_through_time
    use gracecg_estimation_linearisation, only: calibration_filter_t, ESTIMATED, OFFSET_PLACES, MODEL_FIRST, N_CONSTANTS
    use gracecg_estimation_disturbance_search, only: disturbances_t
    use gracecg_estimation_outlier_editing, only: report_edited
    use gracecg_estimation_solution, only: solution_t, estimated_parameter_t
    use gracecg_estimation_fit_record, only: fit_record_t, record_samples, record_covariance, NOISE_SOURCES, &
        STAR_CAMERA_NOISE, A_PRIORI_KNOWLEDGE
    implicit none
    private
    public :: filtered_t, store_solution

    !> The parameters of the solution's state, in its order
    integer, parameter :: OF_STATE(15) = [OFFSET, DRIFT, BIAS, RATE, ATTITUDE_ANGLES]
    real(dp), parameter :: UNDETERMINED = 0.3_dp    !! A sigma of the offset that the data did not make, m

    !> What the filter made of the samples.
    type :: filtered_t
        real(dp), allocatable :: remainder(:, :, :)     !! What the axes say of the constants: (., samples, axis)
        type(constants_t) :: constants                  !! After all observations
        real(dp), allocatable :: residual(:, :)
        !! Of the accelerometer, smoothed, the noise of the instrument left in: (3, samples), m/s^2
        real(dp) :: residual_rms(3) = 0                 !! Of those kept, m/s^2
    end type filtered_t

contains

    !> The last estimate with its covariance, and what is to be said of it. Fails when the samples do not
    !> determine the offset.
    subroutine store_solution(knowledge, edit_sigma, problem, disturbances, filtered, solution, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp), intent(in) :: edit_sigma      !! Limit of editing, standard deviations
        type(calibration_filter_t), intent(in) :: problem
        type(disturbances_t), intent(in) :: disturbances
        type(filtered_t), intent(in) :: filtered
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record

        type(model_state_t) :: final
        type(constants_t) :: constants
        real(dp) :: y(N_CONSTANTS), root(N_CONSTANTS, N_CONSTANTS), unused(3)
        integer :: places(size(OF_STATE)), i

        allocate (solution%running)
        call run_through_time(problem, filtered%remainder, problem%state%value(OFFSET), constants, solution%running)
        y = constants%solution()
        root = constants%inverse_root()
        final = problem%state
        call correct_state(problem%model, y(MODEL_FIRST:), final)
        solution%offset = final%value(OFFSET)
        solution%drift = final%value(DRIFT)
        solution%bias = final%value(BIAS)
        solution%quaternion = final%quaternion
        solution%angular_velocity = final%value(RATE)
        solution%residual_rms = filtered%residual_rms
        solution%condition = condition_of(constants)
        solution%parameters = [(estimated_parameter_t(parameter_names(TORQUE(i)), final%value(TORQUE(i)), &
                                                      norm2(root(constant_of(TORQUE(i)), :)), &
                                                      parameter_units(TORQUE(i))), i=1, 3)]
        solution%noise_level = knowledge%accelerometer_noise%level
        solution%noise_corner = knowledge%accelerometer_noise%corner
        solution%star_camera_sigma = knowledge%star_camera_sigma
        call constants%last_covariance(unused, solution%covariance)
        associate (sigma => maxval(solution%running%sigma(:, problem%steps)))
            if (.not. sigma < UNDETERMINED) then
                call fail(error, 'sequential: the observations do not determine the offset: its standard '// &
                          'deviation is '//number_text(sigma)//' m; did the torque rods turn the satellite?')
                return
            end if
        end associate
        places = [(constant_of(OF_STATE(i)), i=1, size(OF_STATE))]
        solution%state_covariance = matmul(root(places, :), transpose(root(places, :)))
        call allow_for_misfit(problem, constants%squares, solution)
        call report_edited(problem%data, transpose(problem%kept), problem%star_kept, edit_sigma, 1.0_dp, &
                           solution%edited, solution%warnings, error)
        call report_disturbances(disturbances, problem%white_sigma, solution%warnings)
        if (present(record)) &
            call record_fit(problem, filtered, disturbances%leading > 0, root, &
                            solution%covariance(1, 1)/sum(root(constant_of(OFFSET(1)), :)**2), record)
    end subroutine store_solution

    !> Where a parameter of the model stands among the constants.
    pure integer function constant_of(parameter)
        integer, intent(in) :: parameter

        constant_of = MODEL_FIRST - 1 + findloc(ESTIMATED, parameter, 1)
    end function constant_of

    !> Puts the fit into a record. The whitened observations have unit noise, so with the covariance
    !> P = U U^T of the constants the observations of a source, with the partials g, bring
    !> P (sum g g^T) P to it; all sources together make it whole.
    subroutine record_fit(problem, filtered, with_shared, root, misfit, record)
        type(calibration_filter_t), intent(in) :: problem
        type(filtered_t), intent(in) :: filtered
        logical, intent(in) :: with_shared          !! A disturbance is shared by the axes
        real(dp), intent(in) :: root(:, :)          !! U
        real(dp), intent(in) :: misfit              !! Factor by which the covariance is enlarged
        type(fit_record_t), intent(inout) :: record

        real(dp) :: by(3, 3, NOISE_SOURCES), to_offset(3, N_CONSTANTS)
        integer, allocatable :: places(:), kept(:)
        character(12), allocatable :: names(:)
        integer :: i, axis

        call record_samples(problem%data, all(problem%kept, 2), filtered%residual, &
                            problem%partials(OFFSET_PLACES, :, :), problem%trajectory%omega_dot, record)
        names = parameter_names(ESTIMATED)
        places = [(MODEL_FIRST - 1 + i, i=1, size(ESTIMATED))]
        if (with_shared) then
            names = [character(12) :: names, 'shared_1', 'shared_2', 'frequency']
            places = [places, SHARED, FREQUENCY]
        end if
        to_offset = matmul(root(MODEL_FIRST - 1 + OFFSET_PLACES, :), transpose(root))
        by(:, :, A_PRIORI_KNOWLEDGE) = brought_by(problem%prior)
        kept = pack([(i, i=1, size(problem%star_kept))], problem%star_kept)
        by(:, :, STAR_CAMERA_NOISE) = brought_by(reshape(problem%star(:, :, kept), [N_CONSTANTS + 1, 3*size(kept)]))
        do axis = 1, 3
            kept = pack([(i, i=1, size(problem%epoch))], problem%kept(:, axis))
            by(:, :, axis) = brought_by(filtered%remainder(:, kept, axis))
        end do
        call record_covariance(names, misfit*matmul(root(places, :), transpose(root(places, :))), OFFSET_PLACES, &
                               by, record)

    contains

        !> What whitened observations bring to the covariance of the offset.
        pure function brought_by(rows) result(covariance)
            real(dp), intent(in) :: rows(:, :)      ! [g, r], (N_CONSTANTS + 1, observations)
            real(dp) :: covariance(3, 3)            ! m^2

            real(dp) :: gain(3, size(rows, 2))

            gain = matmul(to_offset, rows(:N_CONSTANTS, :))
            covariance = misfit*matmul(gain, transpose(gain))
        end function brought_by
    end subroutine record_fit

    !> Condition number (1-norm) of the normal matrix with unit diagonal.
    pure real(dp) function condition_of(constants) result(condition)
        type(constants_t), intent(in) :: constants

        real(dp), dimension(constants%n, constants%n) :: root, normal, inverse
        real(dp) :: scale(constants%n)
        integer :: i

        root = 0
        do i = 1, constants%n
            root(i, i:) = constants%array(i:constants%n, i)
        end do
        normal = matmul(transpose(root), root)
        inverse = constants%inverse_root()
        inverse = matmul(inverse, transpose(inverse))
        scale = [(sqrt(normal(i, i)), i=1, constants%n)]
        normal = normal/(spread(scale, 1, constants%n)*spread(scale, 2, constants%n))
        inverse = inverse*(spread(scale, 1, constants%n)*spread(scale, 2, constants%n))
        condition = maxval(sum(abs(normal), 1))*maxval(sum(abs(inverse), 1))
    end function condition_of

    !> Enlarges the covariance by the variance of the innovations where that is significantly above 1.
    subroutine allow_for_misfit(problem, squares, solution)
        class(filter_problem_t), intent(in) :: problem
        real(dp), intent(in) :: squares         !! Sum of the squared innovations
        type(solution_t), intent(inout) :: solution

        real(dp), parameter :: SIGNIFICANT = 5          !! In standard deviations of the variance
        real(dp) :: variance
        integer :: n

        n = count(problem%kept) + 3*count(problem%star_kept) - N_CONSTANTS
        variance = squares/max(1, n)
        solution%variance_factor = variance
        if (.not. variance > 1 + SIGNIFICANT*sqrt(2.0_dp/max(1, n))) return
        solution%covariance = variance*solution%covariance
        solution%state_covariance = variance*solution%state_covariance
        solution%running%sigma = sqrt(variance)*solution%running%sigma
        call append(solution%warnings, 'the innovations have a variance of '//number_text(variance)// &
                    ' instead of 1: the samples have more noise, or the satellite more disturbances, than '// &
                    'the filter knows of; the sigmas are enlarged by the square root of it')
    end subroutine allow_for_misfit

    subroutine report_disturbances(disturbances, white_sigma, warnings)
        type(disturbances_t), intent(in) :: disturbances
        real(dp), intent(in) :: white_sigma(3)  !! Of the accelerometer, m/s^2
        type(string_t), allocatable, intent(inout) :: warnings(:)

        integer :: axis, i

        do axis = 1, 3
            if (.not. allocated(disturbances%axis(axis)%list)) cycle
            do i = 1, size(disturbances%axis(axis)%list)
                associate (disturbance => disturbances%axis(axis)%list(i))
                    call append(warnings, 'accelerometer: the non-gravitational acceleration of axis '// &
                                AXES(axis)//' is no straight line; followed as a process of '// &
                                number_text(disturbance%sigma*white_sigma(axis))//' m/s^2 with a period of '// &
                                number_text(1/disturbance%frequency)//' s and a damping ratio of '// &
                                number_text(disturbance%damping))
                end associate
            end do
        end do
    end subroutine report_disturbances
end module gracecg_estimation_sequential_solution
