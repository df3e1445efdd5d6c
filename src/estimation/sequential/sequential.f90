!> The estimator `sequential`: a filter with smoother, the constants in a square-root information array, the attitude
!> error multiplicative.
!>
!> It fits the physical model (gracecg_estimation_physical_model) to accelerometer and star-camera samples at
!> their own epochs, each in units of its noise. The attitude error is a rotation vector; filter and
!> smoother run about a nominal trajectory (gracecg_estimation_linearised_samples) and are repeated about the corrected
!> one until nothing changes. Beside bias, drift and a parabola of the drag, which would pull the frequency of a
!> wave, the non-gravitational acceleration of every axis may follow Gauss-Markov processes
!> (gracecg_estimation_disturbance_search), and the flicker noise of the accelerometer is followed by its own.
!> Samples that all others contradict are edited.
module gracecg_estimation_sequential
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, N_POLES
    use gracecg_base_text, only: append, string_t
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_parameters, only: PARAMETERS, OFFSET, FORCE_SHAPES, LIFT, LOOSE_SIGMAS, parameter_names, &
        PARAMETER_UNITS, TORQUE, DRIFT, BIAS, RATE
    use gracecg_estimation_options, only: estimation_options_t, sequential_options_t, ADAPTIVE, STRAIGHT_LINE
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_parameters, only: a_priori_sigmas, feels_lift, OF_STATE
    use gracecg_estimation_physical_model, only: prepare_model, initial_state, airflow_at, model_state_t, correct_state
    use gracecg_estimation_square_root_information, only: constants_t
    use gracecg_estimation_noise_whitening, only: prepare_filter
    use gracecg_estimation_linearised_samples, only: filter_problem_t, flicker_process, whiten, gather, smooth_axis, &
        smooth_star_camera, SHARED, FREQUENCY, run_through_time, calibration_filter_t, begin_filter, ESTIMATED, MODEL_FIRST, &
        N_CONSTANTS, FIRST_FIT, OFFSET_PLACES
    use gracecg_estimation_disturbance_search, only: disturbances_t, search_disturbances
    use gracecg_estimation_spike_screen, only: is_spike
    use gracecg_estimation_outlier_editing, only: decide_anew, report_edited
    use gracecg_estimation_fit_checks, only: refuse_stuck_axis, check_torque
    use gracecg_estimation_solution, only: solution_t, estimated_parameter_t
    use gracecg_estimation_fit_record, only: fit_record_t, record_samples, record_covariance, NOISE_SOURCES, &
        STAR_CAMERA_NOISE, A_PRIORI_KNOWLEDGE
    implicit none
    private
    public :: estimate_sequential, check_noise

    real(dp), parameter :: NO_SHAPE = 1e-15_dp
    !! A-priori sigma of the shapes of a drag that is to be a straight line, m/s^2 (of side forces m/s^2/rad), and of a lift
    !! that is not felt
    real(dp), parameter :: NO_ERROR = 1e-6_dp
    !! Part of their a-priori sigmas that scale factors and magnetometer bias may have where they are trusted
    integer, parameter :: MOST_ATTITUDE_ITERATIONS = 20, MOST_ITERATIONS = 10
    integer, parameter :: MOST_EDITING_ROUNDS = 5
    real(dp), parameter :: NEGLIGIBLE = 1e-3_dp
    !! Correction of the nominal trajectory, in standard deviations; the solution contains it anyway
    real(dp), parameter :: SPIKE_LIMIT = 8          !! Of the first screening, standard deviations
    !> Medians of chi-square variables with 1 and 3 degrees of freedom
    real(dp), parameter :: MEDIAN_1 = 0.4549_dp, MEDIAN_3 = 2.3660_dp

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

    !> Estimates the CG offset.
    !>
    !> Fails when the observations are refused, when the setup gives no noise levels, when the samples
    !> do not determine the offset, and, with options%covariance or a record, when the satellite did not turn
    !> as the torque rods should have made it.
    subroutine estimate_sequential(observations, options, solution, error, record)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record   !! For diagnostics

        type(calibration_filter_t) :: problem
        type(disturbances_t) :: disturbances
        type(filtered_t) :: filtered
        integer :: round, iterations, axis
        logical :: changed

        solution%algorithm = 'sequential'
        call begin(observations, options, problem, error)
        if (.not. allocated(error)) call fit_attitude(problem, error)
        if (allocated(error)) return
        do axis = 1, 3
            problem%kept(:, axis) = .not. is_spike(problem%acceleration(N_CONSTANTS + 1, :, axis), 1.0_dp, SPIKE_LIMIT)
        end do
        do round = 1, MOST_EDITING_ROUNDS
            call fit(options%sequential, problem, disturbances, filtered, iterations, solution%converged, error)
            if (allocated(error)) return
            solution%iterations = solution%iterations + iterations
            call edit(options%sequential%edit_sigma, problem, filtered, changed)
            if (.not. changed) exit
        end do
        solution%converged = solution%converged .and. .not. changed
        solution%warnings = problem%data%warnings
        if (options%history) solution%history = problem%history
        call store_solution(observations%knowledge, options%sequential%edit_sigma, problem, disturbances, filtered, solution, &
                            error, record)
        if (allocated(error)) return
        if (options%covariance .or. present(record)) &
            call check_torque(observations%knowledge, problem%data, problem%star_sigma, solution%quaternion, &
                              solution%angular_velocity, solution%warnings, error, record, problem%star_kept)
    end subroutine estimate_sequential

    !> What the estimate begins with: data, model, a-priori knowledge, noise, first guess.
    subroutine begin(observations, options, problem, error)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(calibration_filter_t), intent(out) :: problem
        type(error_t), allocatable, intent(out) :: error

        type(fitting_data_t) :: data
        real(dp) :: stated(PARAMETERS)
        integer :: i

        call preprocess(observations, options, data, error)
        if (.not. allocated(error)) call refuse_stuck_axis(data, error)
        if (.not. allocated(error)) call check_noise(observations%knowledge, error)
        if (allocated(error)) return
        call prepare_model(observations%knowledge, data, ESTIMATED, problem%model)
        call begin_filter(data, problem)
        problem%keeps_history = options%history
        problem%state = initial_state(data, options)
        problem%guess = problem%state
        problem%guess%value(OFFSET) = 0         ! so that the guess has no weight at all
        problem%prior_sigma = LOOSE_SIGMAS(ESTIMATED)
        stated = a_priori_sigmas(observations%knowledge)
        if (.not. options%sequential%estimate_within_limits) stated = NO_ERROR*stated
        where (stated(ESTIMATED) > 0) problem%prior_sigma = stated(ESTIMATED)
        do i = 1, size(ESTIMATED)
            if (any(ESTIMATED(i) == LIFT) .and. .not. feels_lift(observations%knowledge) .or. &
                options%sequential%acceleration == STRAIGHT_LINE .and. any(ESTIMATED(i) == [FORCE_SHAPES, LIFT])) &
                problem%prior_sigma(i) = NO_SHAPE
        end do
        problem%shared_sigma = options%sequential%shared_part
        problem%star_sigma = observations%knowledge%star_camera_sigma
        call take_noise(observations%knowledge, problem, error)
    end subroutine begin

    !> Fails unless every noise level is given: they are the weights.
    subroutine check_noise(knowledge, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        integer :: axis

        do axis = 1, 3
            if (.not. knowledge%accelerometer_noise(axis)%level > 0) then
                call fail(error, 'noise_level of accelerometer axis '//AXES(axis)//' = '// &
                          number_text(knowledge%accelerometer_noise(axis)%level)//' m^2 s^-4/Hz: it must be '// &
                          'positive, since the noise gives the samples their weights')
            else if (.not. knowledge%star_camera_sigma(axis) > 0) then
                call fail(error, 'noise_about_axes('//AXES(axis)//') of the star camera = '// &
                          number_text(knowledge%star_camera_sigma(axis))//' rad: it must be positive, since '// &
                          'the noise gives the samples their weights')
            end if
            if (allocated(error)) return
        end do
    end subroutine check_noise

    !> White noise of the accelerometer, and the processes of its axes: flicker noise.
    subroutine take_noise(knowledge, problem, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(calibration_filter_t), intent(inout) :: problem
        type(error_t), allocatable, intent(out) :: error

        type(coloured_noise_t) :: noise
        real(dp) :: white_variance, correlation(N_POLES), variance(N_POLES)
        integer :: axis

        do axis = 1, 3
            noise = coloured_noise(knowledge%accelerometer_noise(axis), knowledge%accelerometer_interval, error)
            if (allocated(error)) return
            call noise%markov_form(white_variance, correlation, variance)
            problem%white_sigma(axis) = sqrt(white_variance)
            problem%known_process(axis) = flicker_process(noise, problem%steps)
        end do
    end subroutine take_noise

    !> Brings the nominal trajectory near the truth by the star camera alone: Gauss and Newton's
    !> iteration with the accelerometer left aside. What it would determine stays as it was. Spikes of the
    !> star camera are left out before they can pull the trajectory, and once more looked for about the fit: about a poor
    !> first guess the ends of the arc stand out, and a spike may not.
    subroutine fit_attitude(problem, error)
        type(calibration_filter_t), intent(inout) :: problem
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: ATTITUDE_AND_RATE = 6
        real(dp), parameter :: NO_PART(2) = 0
        real(dp) :: y(N_CONSTANTS)
        type(constants_t) :: constants
        integer :: iteration

        call problem%move(FIRST_FIT, NO_PART, error)
        call screen_stars(problem)
        do iteration = 1, MOST_ATTITUDE_ITERATIONS
            call gather(problem, constants)
            y = constants%solution()
            call problem%move(FIRST_FIT, NO_PART, error, y)
            if (allocated(error)) return
            if (corrections_in_sigmas(constants, y, ATTITUDE_AND_RATE) < 1) exit
        end do
        problem%star_kept = .true.
        call screen_stars(problem)
        call problem%linearise_accelerations()
    end subroutine fit_attitude

    !> Leaves spikes of the star camera out.
    subroutine screen_stars(problem)
        class(filter_problem_t), intent(inout) :: problem

        integer :: j

        do j = 1, 3
            problem%star_kept = problem%star_kept .and. &
                                .not. is_spike(problem%star(N_CONSTANTS + 1, j, :), 1.0_dp, SPIKE_LIMIT)
        end do
        if (count(problem%star_kept) < 3) problem%star_kept = .true.
    end subroutine screen_stars

    !> The largest correction of the first parameters of the model in units of their standard deviations.
    pure real(dp) function corrections_in_sigmas(constants, correction, n) result(largest)
        type(constants_t), intent(in) :: constants
        real(dp), intent(in) :: correction(N_CONSTANTS)
        integer, intent(in) :: n                !! How many parameters

        real(dp) :: root(N_CONSTANTS, N_CONSTANTS)

        root = constants%inverse_root()
        associate (last => MODEL_FIRST + n - 1)
            largest = maxval(abs(correction(MODEL_FIRST:last))/norm2(root(MODEL_FIRST:last, :), 2))
        end associate
    end function corrections_in_sigmas

    !> Corrects the nominal trajectory until nothing changes. The disturbances of the axes are searched for, if they are to
    !> be found from the data, once offset and scale factors have left their first guess: their product is not linear.
    subroutine fit(options, problem, disturbances, filtered, iterations, converged, error)
        type(sequential_options_t), intent(in) :: options
        type(calibration_filter_t), intent(inout) :: problem
        type(disturbances_t), intent(out) :: disturbances
        type(filtered_t), intent(inout) :: filtered
        integer, intent(out) :: iterations
        logical, intent(out) :: converged
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: SEARCHED = 3      ! iteration
        real(dp) :: y(N_CONSTANTS)
        integer :: axis

        problem%process = problem%known_process
        do axis = 1, 3
            call prepare_filter(problem%process(axis), problem%epoch, problem%kept(:, axis), problem%filter(axis))
        end do
        converged = .false.
        do iterations = 1, MOST_ITERATIONS
            call whiten(problem, filtered%remainder)
            if (iterations == SEARCHED .and. options%acceleration == ADAPTIVE) then
                associate (middle => problem%model%steps/2)
                    call search_disturbances(options%likelihood_gain, problem%white_sigma, &
                                             airflow_at(problem%model, problem%trajectory%q(:, middle), middle), &
                                             problem, filtered%remainder, disturbances)
                end associate
                call problem%linearise_prior(disturbances%shared_part)
            end if
            call gather(problem, filtered%constants, filtered%remainder)
            y = filtered%constants%solution()
            converged = corrections_in_sigmas(filtered%constants, y, size(ESTIMATED)) < NEGLIGIBLE .and. iterations >= SEARCHED
            if (converged) return
            call problem%move('all parameters', disturbances%shared_part, error, y)
            if (allocated(error)) return
            call problem%linearise_accelerations()
        end do
        iterations = MOST_ITERATIONS
        call whiten(problem, filtered%remainder)
        call gather(problem, filtered%constants, filtered%remainder)
    end subroutine fit

    !> Smooths, and decides anew which samples are kept: those whose chi-square against all others is below the
    !> limit of as many standard deviations, in units of what is usual if that is more than noise.
    subroutine edit(edit_sigma, problem, filtered, changed)
        real(dp), intent(in) :: edit_sigma      !! Limit, standard deviations
        type(calibration_filter_t), intent(inout) :: problem
        type(filtered_t), intent(inout) :: filtered     !! The residuals are put there
        logical, intent(out) :: changed         !! Another set of samples than before

        real(dp), dimension(size(problem%epoch)) :: residual, chi_square
        real(dp) :: flicker(1, size(problem%epoch))
        real(dp) :: star_chi_square(size(problem%star_time))
        real(dp), allocatable :: signal(:, :)
        integer :: axis

        changed = .false.
        if (.not. allocated(filtered%residual)) allocate (filtered%residual(3, size(problem%epoch)))
        do axis = 1, 3
            signal = reshape(problem%process(axis)%output, [problem%process(axis)%n, 1])
            signal(problem%known_process(axis)%n + 1:, 1) = 0
            call smooth_axis(problem, axis, filtered%constants, signal, flicker, residual, chi_square)
            residual = problem%white_sigma(axis)*(residual + flicker(1, :))
            filtered%residual(axis, :) = residual
            filtered%residual_rms(axis) = norm2(pack(residual, problem%kept(:, axis)))/ &
                                          sqrt(real(max(1, count(problem%kept(:, axis))), dp))
            call decide_anew(chi_square, edit_sigma**2, MEDIAN_1, problem%kept(:, axis), changed)
        end do
        call smooth_star_camera(problem, filtered%constants, star_chi_square)
        call decide_anew(star_chi_square, chi_square_of_three(edit_sigma), MEDIAN_3, problem%star_kept, changed)
    end subroutine edit

    !> The value that a chi-square with 3 degrees of freedom exceeds as rarely as a normal variable
    !> exceeds z, one-sided: E. B. Wilson, M. M. Hilferty, Proc. Nat. Acad. Sci. 17 (1931) 684-688.
    pure real(dp) function chi_square_of_three(z) result(value)
        real(dp), intent(in) :: z

        real(dp), parameter :: V = 2/27.0_dp

        value = 3*(1 - V + z*sqrt(V))**3
    end function chi_square_of_three

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
                                                      PARAMETER_UNITS(TORQUE(i))), i=1, 3)]
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
        class(calibration_filter_t), intent(in) :: problem
        real(dp), intent(in) :: squares         !! Sum of the squared innovations
        type(solution_t), intent(inout) :: solution

        real(dp), parameter :: SIGNIFICANT = 5          !! In standard deviations of the variance
        real(dp) :: variance
        integer :: n

        n = count(problem%kept) + 3*count(problem%star_kept) - N_CONSTANTS + count(problem%prior_sigma <= NO_SHAPE)
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
end module gracecg_estimation_sequential
