!> `optimal`: the batch estimate of least variance. Gauss-Newton iteration of the physical model
!> (gracecg_estimation_physical_model) on whitened observations (gracecg_estimation_whitened_problem), with editing of
!> outliers and, where the noise is not known, variance components from the data.
module gracecg_estimation_optimal
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: ARCSECOND
    use gracecg_base_error, only: error_t, add_context, number_text
    use gracecg_base_text, only: append
    use gracecg_base_coloured_noise, only: noise_spectrum_t
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t, NOISE_ESTIMATED, WAVE_SEARCHED
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_observations_parameters
    use gracecg_estimation_parameters, only: OF_STATE
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, assumed_noise_t, prepare_calibration, &
        set_noise, estimated_parameters, with_parameters
    use gracecg_estimation_wave_search, only: density_wave_found_t, search_wave, search_level, report_wave
    use gracecg_estimation_jump_search, only: force_jump_found_t, search_jump, report_jump
    use gracecg_estimation_batch_problem, only: batch_solution_t
    use gracecg_estimation_simplified_newton, only: newton_settings_t, simplified_newton
    use gracecg_estimation_variance_components, only: estimate_spectrum, estimate_variance
    use gracecg_estimation_outlier_editing, only: leave_out_worst, spikes_of, report_edited, MEDIAN_OF_ONE, MEDIAN_OF_THREE
    use gracecg_estimation_fit_checks, only: refuse_stuck_axis, check_torque, judge_noise
    use gracecg_estimation_belief, only: apply_value
    use gracecg_estimation_belief_tests, only: test_beliefs, side_scores
    use gracecg_estimation_iteration, only: iteration_t, append_iteration
    use gracecg_estimation_gather_information, only: gather_information
    use gracecg_estimation_solution, only: solution_t, estimated_parameter_t
    use gracecg_estimation_fit_record, only: fit_record_t, record_samples, record_covariance, NOISE_SOURCES, &
        STAR_CAMERA_NOISE, A_PRIORI_KNOWLEDGE
    implicit none
    private
    public :: estimate_optimal

    integer, parameter :: MOST_ROUNDS = 30          !! Of editing and variance components
    integer, parameter :: FEW = 8                   !! Steps of a fit that is done once
    real(dp), parameter :: ROUGHLY = 1e-2_dp
    !! Largest correction at the end of a fit where only the residuals, or the misfit, are looked at, standard deviations
    real(dp), parameter :: SAME_LEVEL = 0.01_dp     !! Relative change of the noise that ends the rounds
    real(dp), parameter :: FIRST_LEVEL = 1e-19_dp   !! Where the noise is not known, m^2 s^-4/Hz
    real(dp), parameter :: FIRST_ANGLE = 10*ARCSECOND
    real(dp), parameter :: LIMIT = 6                !! Of editing, standard deviations; 2e-9 of Gaussian noise is beyond
    real(dp), parameter :: MOST = 0.25_dp           !! Part of a series that may be left out
    !> Below what any instrument has: data without noise
    real(dp), parameter :: SMALLEST_LEVEL = 1e-30_dp, SMALLEST_ANGLE = 1e-10_dp

    !> A fit that has settled.
    type :: fit_t
        type(whitened_problem_t) :: problem
        type(batch_solution_t) :: batch
        integer :: iterations = 0
        logical :: converged = .false.
        logical :: noise_estimated = .false.    !! Some of it
        type(iteration_t), allocatable :: history(:)    !! If the options ask for it
    end type fit_t

contains

    !> The optimal batch estimate. Its covariance is the inverse information of all parameters, which
    !> costs nothing and is always given; without options%covariance the fit is not checked.
    !>
    !> What the options name of beliefs that the model has in proportion alone is put into the beliefs, and the fit done again,
    !> until it stays: a delay or a turn is then what it is, not its first power.
    !>
    !> Fails when the observations are refused, the offset is not determined, more than a quarter of a
    !> series would have to be left out, and, with the checks, when the satellite did not turn as the
    !> torque rods should have made it.
    subroutine estimate_optimal(observations, options, solution, error, record, problem, once)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record   !! For diagnostics
        type(whitened_problem_t), intent(out), optional :: problem  !! At the estimate, for a joint one; gives the information, too
        logical, intent(in), optional :: once
        !! A few steps of one fit, no wave or jump searched and no sample left out: enough to tell that a hypothesis is hopeless

        integer, parameter :: MOST_MOVES = 8
        real(dp), parameter :: STAYS = 0.02_dp      ! Standard deviations
        type(observation_set_t) :: believed
        type(estimation_options_t) :: unchecked     ! on the way: a belief that is still wrong must not refuse the fit
        type(estimated_parameter_t), allocatable :: found(:)
        integer, allocatable :: named(:), places(:)
        character(:), allocatable :: unknown        ! none: the options have been looked at
        real(dp), allocatable :: moved(:)
        logical :: settled, at_rest
        integer :: i, move

        call find_parameters(options%optimal%also, named, unknown)
        named = pack(named, ACTS_IN_PROPORTION(named))
        allocate (moved(size(named)), source=0.0_dp)
        believed = observations
        unchecked = options
        unchecked%covariance = .false.
        at_rest = .true.
        settled = size(named) == 0
        do move = 0, MOST_MOVES
            if (settled) then
                call estimate_as_believed(believed, options, solution, error, record, problem, once)
            else
                call estimate_as_believed(believed, unchecked, solution, error, once=once)
            end if
            if (allocated(error)) return
            places = [(findloc(solution%parameters%name, parameter_names(named(i)), 1), i=1, size(named))]
            found = solution%parameters(places)
            if (settled) exit
            at_rest = all(abs(found%value) < STAYS*found%sigma)
            settled = at_rest .or. move == MOST_MOVES - 1
            if (at_rest) cycle
            do i = 1, size(named)
                call apply_value(named(i), found(i)%value, believed)
            end do
            moved = moved + found%value
        end do
        solution%parameters(places)%value = solution%parameters(places)%value + moved
        solution%converged = solution%converged .and. at_rest
    end subroutine estimate_optimal

    !> The estimate with the beliefs as they are.
    subroutine estimate_as_believed(observations, options, solution, error, record, problem, once)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record   !! For diagnostics
        type(whitened_problem_t), intent(out), optional :: problem  !! At the estimate, for a joint one; gives the information, too
        logical, intent(in), optional :: once
        !! A few steps of one fit, no wave or jump searched and no sample left out: enough to tell that a hypothesis is hopeless

        type(whitened_problem_t) :: start
        type(fitting_data_t) :: data
        type(fit_t), allocatable :: fit
        logical :: coarse

        coarse = .false.
        if (present(once)) coarse = once
        solution%algorithm = 'optimal'
        call preprocess(observations, options, data, error)
        if (.not. allocated(error)) call refuse_stuck_axis(data, error)
        if (allocated(error)) return
        call prepare_calibration(observations%knowledge, options, data, &
                                 estimated_parameters(options%optimal, observations%knowledge, data), start)
        solution%warnings = start%data%warnings
        call fit_best(observations%knowledge, options, coarse, start, fit, solution, error)
        if (allocated(error)) then      ! spikes may be so large that no fit tells them from the rest
            start%acceleration_kept = .not. spikes_of(start%data, start%noise%accelerometer)
            if (.not. all(start%acceleration_kept)) then
                solution%warnings = start%data%warnings
                call fit_best(observations%knowledge, options, coarse, start, fit, solution, error)
            end if
        end if
        call add_context(error, 'optimal')
        if (allocated(error)) return
        call store(fit%problem, fit%batch, solution)
        if (present(record)) call record_fit(fit%problem, fit%batch, record)
        call report_edited(fit%problem%data, fit%problem%acceleration_kept, fit%problem%star_kept, LIMIT, MOST, &
                           solution%edited, solution%warnings, error)
        if (.not. allocated(error) .and. .not. fit%noise_estimated) &       ! and what the fit does not look at
            solution%misfit = sum(fit%batch%residuals**2) + LIMIT**2*sum(solution%edited) + &
                              sum(side_scores(observations%knowledge, fit%problem%data)**2)
        if (.not. allocated(error) .and. options%covariance .and. options%test_beliefs) then
            allocate (solution%beliefs)
            call test_beliefs(observations%knowledge, options, fit%problem, solution%beliefs, error)
            if (allocated(error)) deallocate (solution%beliefs)
        end if
        if (.not. allocated(error) .and. (options%covariance .or. present(record))) &
            call check_fit(observations%knowledge, fit%problem, solution, error, record)
        if (.not. allocated(error) .and. present(problem)) then
            allocate (solution%information)
            call gather_information(observations%knowledge, options, fit%problem, solution%information, error)
            problem = fit%problem
        end if
        call add_context(error, 'optimal')
    end subroutine estimate_as_believed

    !> The fit with the parameters that the options ask for; if its residuals show a density wave, one that
    !> estimates the wave and curved drag, too: a parabola would pull the wave's frequency; if those show a jump of
    !> the forces, one that estimates it. A jump that explains much of a wave comes first: a step looks like a long one.
    subroutine fit_best(knowledge, options, once, start, fit, solution, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        logical, intent(in) :: once     !! A few steps, and nothing changes
        type(whitened_problem_t), intent(in) :: start
        type(fit_t), allocatable, intent(out) :: fit
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(fit_t), allocatable :: wider
        type(density_wave_found_t) :: wave
        type(force_jump_found_t) :: jump
        real(dp) :: without_jump(3)                 ! the offset by the fit without it, m
        type(error_t), allocatable :: not_determined
        logical :: louder               ! The first search: under more noise than there is
        logical :: search_jumps
        logical :: only_to_search       ! That there is a wave is seen long before the fit without it has settled

        search_jumps = options%optimal%search_jump .and. options%optimal%estimate_within_limits .and. .not. once
        only_to_search = options%optimal%density_wave == WAVE_SEARCHED .and. .not. once
        allocate (fit)
        fit%problem = start
        if (only_to_search) fit%problem%noise%accelerometer%level = search_level(start%noise%accelerometer%level)
        louder = any(fit%problem%noise%accelerometer%level > start%noise%accelerometer%level)
        call settle_counted(only_to_search, fit, error)
        if (allocated(error)) return
        if (only_to_search) then
            wave = search_wave(knowledge%rods, fit%problem, fit%batch)
            if (louder) fit%problem%noise = start%noise
            if (louder .and. .not. wave%found) then     ! a small one
                call settle_counted(.true., fit, error)
                if (allocated(error)) return
                wave = search_wave(knowledge%rods, fit%problem, fit%batch)
            end if
            if (wave%found .and. search_jumps) then
                jump = search_jump(fit%problem, fit%batch, of_wave=wave%gain)
                if (jump%found) fit%problem%acceleration_kept = start%acceleration_kept     ! some were left out for the jump
                if (jump%found) call fit_jump(rough=.true.)
                if (jump%found) wave = search_wave(knowledge%rods, fit%problem, fit%batch)
            end if
            if (wave%found) then
                allocate (wider)
                call widen(knowledge, options, fit, wave, wider)
                call settle_wider(.false., wave%found)
                if (wave%found) call look_for_growth()
                call report_wave(wave, fit%problem, solution%warnings)
            end if
            if (.not. wave%found) call settle_counted(.false., fit, error)
            if (allocated(error)) return
        end if
        if (search_jumps .and. .not. jump%found) then
            jump = search_jump(fit%problem, fit%batch)
            if (jump%found) call fit_jump(rough=.false.)
        end if
        if (jump%found) call report_jump(knowledge, fit%problem, fit%batch, jump, without_jump, solution%warnings)
        solution%converged = fit%converged
        if (fit%noise_estimated) &
            call append(solution%warnings, 'the noise is estimated from the data where the setup does not give it')

    contains

        !> The fit with the jump.
        subroutine fit_jump(rough)
            logical, intent(in) :: rough

            allocate (wider)
            call with_parameters(knowledge, options, fit%problem, [fit%problem%model%estimated, FORCE_JUMP], wider%problem)
            wider%problem%model%jump = jump%epoch
            without_jump = fit%problem%state%value(OFFSET)
            call settle_wider(rough, jump%found)
        end subroutine fit_jump

        !> A wave whose amplitude changes with the drag leaves another one, near in frequency: then its growth is estimated, too.
        subroutine look_for_growth()
            real(dp), parameter :: NEAR = 2     ! Cycles in the arc, chosen: one that grows steadily leaves a line 0.75 away
            type(density_wave_found_t) :: left
            logical :: grows

            left = search_wave(knowledge%rods, fit%problem, fit%batch)
            if (.not. left%found .or. abs(left%frequency - wave%frequency)*knowledge%duration > NEAR) return
            allocate (wider)
            call with_parameters(knowledge, options, fit%problem, [fit%problem%model%estimated, WAVE_GROWTH], wider%problem)
            call settle_wider(.false., grows)
        end subroutine look_for_growth

        !> The fit with more parameters takes the place of the other, if there is one.
        subroutine settle_wider(rough, there_is)
            logical, intent(in) :: rough
            logical, intent(out) :: there_is

            call settle_counted(rough, wider, not_determined)
            there_is = .not. allocated(not_determined) .and. wider%converged
            if (there_is) call move_alloc(wider, fit)
            if (allocated(wider)) deallocate (wider)
        end subroutine settle_wider

        !> Settles one of the fits, and adds its steps to those of the others.
        subroutine settle_counted(rough, one, failed)
            logical, intent(in) :: rough
            type(fit_t), intent(inout) :: one
            type(error_t), allocatable, intent(out) :: failed

            one%iterations = 0
            if (allocated(one%history)) deallocate (one%history)
            call settle(knowledge, options, once, rough, one, failed)
            solution%iterations = solution%iterations + one%iterations
            if (options%history .and. allocated(one%history)) then
                if (allocated(solution%history)) then
                    solution%history = [solution%history, one%history]
                else
                    solution%history = one%history
                end if
            end if
        end subroutine settle_counted
    end subroutine fit_best

    !> Fits, estimates the noise that is not known, leaves out outliers, until nothing changes.
    subroutine settle(knowledge, options, once, rough, fit, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        logical, intent(in) :: once     !! A few steps, and nothing changes
        logical, intent(in) :: rough    !! Near enough to look at the residuals
        type(fit_t), intent(inout) :: fit
        type(error_t), allocatable, intent(out) :: error

        type(newton_settings_t) :: settings
        logical :: unknown_level(3), unknown_angle(3), changed
        integer :: round, i

        call find_unknown(knowledge, options, fit%problem%noise, unknown_level, unknown_angle)
        fit%noise_estimated = any(unknown_level) .or. any(unknown_angle)
        settings%rough = rough .or. once
        if (settings%rough) settings%tolerance = ROUGHLY
        if (once) settings%most_iterations = FEW
        if (options%history) settings%history = 'whitened, '//number_text(real(size(fit%problem%names), dp))//' parameters'
        do round = 1, MOST_ROUNDS
            call set_noise(fit%problem, error)
            if (.not. allocated(error)) call simplified_newton(fit%problem, settings, fit%batch, error)
            if (allocated(error)) return
            do i = 1, merge(size(fit%batch%history), 0, options%history)
                call append_iteration(fit%history, fit%batch%history(i), fit%batch%history(i)%fit)
            end do
            fit%iterations = fit%iterations + fit%batch%iterations
            call refresh_residuals(fit%batch, fit%problem)
            if (once) exit
            changed = .false.
            if (any(unknown_level)) call update_spectra(fit%problem, unknown_level, changed, error)
            if (allocated(error)) return
            if (any(unknown_angle)) call update_angles(fit%problem, fit%batch, unknown_angle, changed)
            call edit(fit%problem, changed)
            if (.not. changed) exit
        end do
        fit%converged = fit%batch%converged .and. round <= MOST_ROUNDS
    end subroutine settle

    !> Leaves out what is too far from the fit: of the accelerometer by the innovation of the whitening filter,
    !> which a spike moves by its whole size; of the star camera by the length of the three angles in units of
    !> their noise. The residuals must be those of the present state.
    subroutine edit(problem, changed)
        type(whitened_problem_t), intent(inout) :: problem
        logical, intent(inout) :: changed    !! Set if another fit is needed

        real(dp) :: normalised(size(problem%star_kept))
        integer :: axis, i

        do axis = 1, 3
            call leave_out_worst(abs(problem%whiteners(axis)%innovations(problem%acceleration_residual(axis, :))), LIMIT, &
                                 MEDIAN_OF_ONE, problem%acceleration_kept(axis, :), changed)
        end do
        do i = 1, size(normalised)
            normalised(i) = norm2(problem%star_angles(:, i)/problem%noise%star_camera_sigma)
        end do
        call leave_out_worst(normalised, LIMIT, MEDIAN_OF_THREE, problem%star_kept, changed)
    end subroutine edit

    !> The fit with a wave and curved drag beside the other parameters. To be settled.
    subroutine widen(knowledge, options, fit, wave, wider)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(fit_t), intent(in) :: fit
        type(density_wave_found_t), intent(in) :: wave
        type(fit_t), intent(out) :: wider

        integer, allocatable :: wanted(:)

        wanted = [fit%problem%model%estimated, WAVE_SINE, WAVE_COSINE, WAVE_FREQUENCY]
        if (.not. any(wanted == DRAG_CURVATURE)) wanted = [wanted, DRAG_CURVATURE]
        if (any(wanted == FORCE_BENDS(1))) wanted = [wanted, AIRFLOW_TURN]
        call with_parameters(knowledge, options, fit%problem, wanted, wider%problem)
        wider%problem%model%wave_frequency = wave%frequency
        wider%problem%state%value([WAVE_SINE, WAVE_COSINE]) = wave%amplitude
    end subroutine widen

    !> Which levels are to be estimated; something to begin with stands in for them.
    subroutine find_unknown(knowledge, options, noise, unknown_level, unknown_angle)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(assumed_noise_t), intent(inout) :: noise
        logical, intent(out) :: unknown_level(3), unknown_angle(3)

        unknown_level = options%optimal%noise == NOISE_ESTIMATED .or. .not. knowledge%accelerometer_noise%level > 0
        unknown_angle = options%optimal%noise == NOISE_ESTIMATED .or. .not. knowledge%star_camera_sigma > 0
        where (.not. noise%accelerometer%level > 0) noise%accelerometer%level = FIRST_LEVEL
        where (.not. noise%star_camera_sigma > 0) noise%star_camera_sigma = FIRST_ANGLE
    end subroutine find_unknown

    !> The accelerometer's residuals after the last correction; the problem's are from before it.
    pure subroutine refresh_residuals(batch, problem)
        type(batch_solution_t), intent(in) :: batch
        type(whitened_problem_t), intent(inout) :: problem

        integer :: i

        do i = 1, size(problem%acceleration_residual, 2)
            problem%acceleration_residual(:, i) = problem%acceleration_residual(:, i) - &
                                      matmul(batch%correction, problem%acceleration_partials(:, :, i))
        end do
    end subroutine refresh_residuals

    !> Level and corner frequency of the accelerometer axes whose noise is not known. What the fit
    !> takes from an axis, as far as it matters: offset, drift, bias and harmonic acceleration.
    subroutine update_spectra(problem, unknown, changed, error)
        type(whitened_problem_t), intent(inout) :: problem
        logical, intent(in) :: unknown(3)
        logical, intent(inout) :: changed
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: regressors(:, :)
        type(noise_spectrum_t) :: found
        integer :: axis

        do axis = 1, 3
            if (.not. unknown(axis)) cycle
            regressors = problem%acceleration_partials(places_of(problem, axis), axis, :)
            associate (noise => problem%noise%accelerometer(axis))
                call estimate_spectrum(problem%model%interval, noise%sides, problem%data%accelerometer_epoch, &
                                       problem%acceleration_kept(axis, :), problem%acceleration_residual(axis, :), &
                                       regressors, found, error)
                if (allocated(error)) return
                found%level = max(found%level, SMALLEST_LEVEL)
                changed = changed .or. abs(found%level/noise%level - 1) > SAME_LEVEL .or. &
                          abs(found%corner - noise%corner) > SAME_LEVEL*max(found%corner, noise%corner)
                noise = found
            end associate
        end do
    end subroutine update_spectra

    !> Places, among the estimated parameters, of those that an accelerometer axis depends on directly.
    pure function places_of(problem, axis) result(places)
        type(whitened_problem_t), intent(in) :: problem
        integer, intent(in) :: axis
        integer, allocatable :: places(:)

        integer :: i

        places = pack([(i, i=1, size(problem%model%estimated))], &
                      [(any([OFFSET, DRIFT(axis), BIAS(axis), DRAG_CURVATURE, WAVE_SINE, WAVE_COSINE, WAVE_FREQUENCY, &
                             WAVE_GROWTH, FORCE_JUMP(axis), pack(FORCE_BENDS, BEND_AXIS == axis)] == &
                            problem%model%estimated(i)), i=1, size(problem%model%estimated))])
    end function places_of

    !> Noise of the star camera about those axes for which it is not known.
    subroutine update_angles(problem, batch, unknown, changed)
        type(whitened_problem_t), intent(inout) :: problem
        type(batch_solution_t), intent(in) :: batch
        logical, intent(in) :: unknown(3)
        logical, intent(inout) :: changed

        integer, allocatable :: rows(:)
        real(dp) :: factor
        integer :: axis, i

        do axis = 1, 3
            if (.not. unknown(axis)) cycle
            rows = pack([(3*i - 3 + axis, i=1, size(problem%star_kept))], problem%star_kept)
            factor = estimate_variance(batch%residuals(rows), batch%gain(:, rows), batch%inverse)
            changed = changed .or. abs(factor - 1) > SAME_LEVEL
            associate (sigma => problem%noise%star_camera_sigma(axis))
                sigma = max(sigma*sqrt(factor), SMALLEST_ANGLE)
            end associate
        end do
    end subroutine update_angles

    subroutine store(problem, batch, solution)
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch
        type(solution_t), intent(inout) :: solution

        integer :: i, axis, redundancy

        associate (state => problem%state, estimated => problem%model%estimated)
            solution%offset = state%value(OFFSET)
            solution%drift = state%value(DRIFT)
            solution%bias = state%value(BIAS)
            solution%quaternion = state%quaternion
            solution%angular_velocity = state%value(RATE)
            solution%covariance = batch%inverse(OFFSET, OFFSET)     ! estimated begins with ALWAYS_ESTIMATED
            solution%state_covariance = batch%inverse(OF_STATE, OF_STATE)
            solution%parameters = [(estimated_parameter_t(parameter_names(estimated(i)), state%value(estimated(i)), &
                                                          sqrt(batch%inverse(i, i)), PARAMETER_UNITS(estimated(i))), &
                                    i=1, size(estimated))]
            solution%parameters = pack(solution%parameters, &
                                       [((estimated(i) > maxval(BIAS) .or. any(TORQUE == estimated(i))) .and. &
                                         all([FORCE_BENDS, SIDE_FORCE, AIRFLOW_TURN] /= estimated(i)), &
                                         i=1, size(estimated))])
        end associate
        solution%condition = batch%condition
        do axis = 1, 3
            associate (left => pack(problem%acceleration_residual(axis, :), problem%acceleration_kept(axis, :)))
                solution%residual_rms(axis) = norm2(left)/sqrt(real(size(left), dp))
            end associate
        end do
        solution%noise_level = problem%noise%accelerometer%level
        solution%noise_corner = problem%noise%accelerometer%corner
        solution%star_camera_sigma = problem%noise%star_camera_sigma
        redundancy = 3*count(problem%star_kept) + count(problem%acceleration_kept)*problem%model%line%number + &
                     (problem%observations - problem%sample_rows()) - size(problem%model%estimated)
        solution%variance_factor = sum(batch%residuals**2)/max(1, redundancy)
    end subroutine store

    !> Whether noise and torque are what the setup says: warnings, or an error.
    subroutine check_fit(knowledge, problem, solution, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(whitened_problem_t), intent(in) :: problem
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record

        integer :: axis

        do axis = 1, 3
            call judge_noise(axis, solution%residual_rms(axis), problem%noise%accelerometer(axis), &
                             problem%model%interval, solution%warnings, error)
            if (allocated(error)) return
        end do
        call check_torque(knowledge, problem%data, problem%noise%star_camera_sigma, problem%state%quaternion, &
                          problem%state%value(RATE), solution%warnings, error, record, problem%star_kept)
    end subroutine check_fit

    !> Puts the fit into a record: the samples kept on all axes, the covariance, and what of it each group of
    !> observations brings.
    subroutine record_fit(problem, batch, record)
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch
        type(fit_record_t), intent(inout) :: record

        real(dp) :: by_source(3, 3, NOISE_SOURCES)
        integer :: axis

        call record_samples(problem%data, all(problem%acceleration_kept, 1), problem%acceleration_residual, &
                            problem%acceleration_partials(OFFSET, :, :), problem%trajectory%omega_dot, record)
        associate (stars => problem%star_rows, last => problem%star_rows + problem%acceleration_rows)
            do axis = 1, 3
                by_source(:, :, axis) = brought_by(stars + axis, last, 3) + brought_by(last + axis, problem%sample_rows(), 3)
            end do
            by_source(:, :, STAR_CAMERA_NOISE) = brought_by(1, stars, 1)
            by_source(:, :, A_PRIORI_KNOWLEDGE) = brought_by(problem%sample_rows() + 1, problem%observations, 1)
        end associate
        call record_covariance(problem%names, batch%inverse, OFFSET, by_source, record)

    contains

        !> What the observations first, first + step, ... bring to the covariance of the offset: they are
        !> whitened, so their errors have the covariance I, and (H^T H)^-1 H^T takes them to the
        !> parameters.
        function brought_by(first, last, step) result(covariance)
            integer, intent(in) :: first, last, step
            real(dp) :: covariance(3, 3)            ! m^2

            real(dp), allocatable :: gain(:, :)

            gain = matmul(batch%inverse(OFFSET, :), batch%gain(:, first:last:step))
            covariance = matmul(gain, transpose(gain))
        end function brought_by
    end subroutine record_fit
end module gracecg_estimation_optimal
