!> The estimator `sequential`: a multiplicative square-root information filter with smoother.
!>
!> It fits the physical model (gracecg_estimation_physical_model) to accelerometer and star-camera samples at
!> their own epochs, each in units of its noise. The attitude error is a rotation vector; filter and
!> smoother run about a nominal trajectory and are repeated about the corrected one until nothing
!> changes. Beside bias, drift and a parabola of the drag, which would pull the frequency of a wave, the
!> non-gravitational acceleration of every axis may follow Gauss-Markov processes
!> (gracecg_estimation_disturbance_search), and the flicker noise of the accelerometer is followed by its own. Samples
!> that all others contradict are edited.
module gracecg_estimation_sequential
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: append, integer_text
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, N_POLES
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_sequential_options, only: sequential_options_t, ADAPTIVE, GIVEN, STRAIGHT_LINE
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_physical_model, only: physical_model_t, model_state_t, model_trajectory_t, &
        prepare_model, initial_state, integrate_trajectory, predict_accelerations, star_angles, correct_state, &
        turn_between, airflow_at, PARAMETER_NAMES, ATTITUDE_ANGLES, RATE, TORQUE, OFFSET, DRIFT, BIAS, &
        DRAG_CURVATURE
    use gracecg_base_gauss_markov, only: gauss_markov_t
    use gracecg_estimation_square_root_filter, only: constants_t, process_filter_t
    use gracecg_estimation_linearised_samples, only: filter_problem_t, flicker_process, filter_axis, gather, &
        run_through_time, smooth_axis, smooth_star_camera
    use gracecg_estimation_disturbance_search, only: disturbance_t, search_disturbance, with_disturbance
    use gracecg_estimation_process_whitening, only: whiten_by_process
    use gracecg_estimation_spike_screen, only: is_spike
    use gracecg_base_statistics, only: median_of
    use gracecg_estimation_attitude_problem, only: attitude_problem_t, prepare_attitude
    use gracecg_estimation_fit_checks, only: refuse_stuck_axis, check_torque
    use gracecg_estimation_solution, only: solution_t, estimated_parameter_t
    use gracecg_estimation_fit_record, only: fit_record_t, STAR_CAMERA_NOISE, A_PRIORI_KNOWLEDGE
    implicit none
    private
    public :: estimate_sequential

    !> The parameters of the physical model, and their places among the constants: the offset last
    integer, parameter :: ESTIMATED(19) = [ATTITUDE_ANGLES, RATE, TORQUE, DRIFT, BIAS, DRAG_CURVATURE, OFFSET]
    integer, parameter :: M = size(ESTIMATED) + 2           !! Number of constants
    integer, parameter :: SHARED(2) = [M - 4, M - 3]
    !! Parts of the disturbance found in one axis that the other two see
    integer, parameter :: PLACE(19) = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, M - 2, M - 1, M]
    integer, parameter :: OTHERS = size(ESTIMATED) - 3
    integer, parameter :: OFFSETS_AMONG_ESTIMATED(3) = OTHERS + [1, 2, 3]
    !> What is known a priori, so little that it weighs nothing: standard deviations of attitude (rad),
    !> angular velocity (rad/s), torque (N m), drift (m/s^3), bias and curvature of the drag (m/s^2), offset (m)
    real(dp), parameter :: PRIOR_SIGMA(19) = [1.0_dp, 1.0_dp, 1.0_dp, 0.1_dp, 0.1_dp, 0.1_dp, &
                                              0.01_dp, 0.01_dp, 0.01_dp, 1e-4_dp, 1e-4_dp, 1e-4_dp, &
                                              1e-3_dp, 1e-3_dp, 1e-3_dp, 1e-6_dp, 1.0_dp, 1.0_dp, 1.0_dp]
    real(dp), parameter :: NO_CURVATURE = 1e-15_dp  !! The same where the drag is to be a straight line, m/s^2
    real(dp), parameter :: UNDETERMINED = 0.3_dp    !! A sigma of the offset that the data did not make, m

    integer, parameter :: MOST_ATTITUDE_ITERATIONS = 20, MOST_ITERATIONS = 10
    integer, parameter :: MOST_EDITING_ROUNDS = 5
    real(dp), parameter :: NEGLIGIBLE = 1e-3_dp
    !! Correction of the nominal trajectory, in standard deviations; the solution contains it anyway
    real(dp), parameter :: SPIKE_LIMIT = 8          !! Of the first screening, standard deviations
    !> Medians of chi-square variables with 1 and 3 degrees of freedom
    real(dp), parameter :: MEDIAN_1 = 0.4549_dp, MEDIAN_3 = 2.3660_dp
    real(dp), parameter :: ALONG_THE_AIRFLOW = 0.7_dp   !! Cosine of the angle to an axis that drag acts along

    !> The disturbances found in one axis.
    type :: found_t
        type(disturbance_t), allocatable :: list(:)
    end type found_t

    !> What an estimate works on.
    type :: work_t
        type(fitting_data_t) :: data
        type(physical_model_t) :: model
        type(model_state_t) :: state              !! The nominal one
        type(model_state_t) :: guess              !! Where the a-priori knowledge stands
        type(model_trajectory_t) :: trajectory
        type(filter_problem_t) :: problem
        real(dp) :: white_sigma(3) = 1                  !! Of the accelerometer, m/s^2
        real(dp), allocatable :: predicted(:, :)        !! (3, samples)
        real(dp), allocatable :: partials(:, :, :)      !! (parameters, 3, samples)
        real(dp), allocatable :: remainder(:, :, :)     !! (M + 1, samples, axis)
        integer :: leading = 0                          !! Axis with the largest disturbance found; 0: none
        type(process_filter_t) :: filter(3)
        type(constants_t) :: constants
        type(found_t) :: found(3)                       !! By axis
        real(dp) :: star_sigma(3) = 1                   !! Of the star camera about its axes, rad
        real(dp) :: prior_sigma(size(ESTIMATED)) = PRIOR_SIGMA  !! Of the parameters of the model
        real(dp) :: shared_part(2) = 0                  !! A priori, the constants SHARED
        real(dp) :: shared_sigma = 1                    !! and their standard deviation
        integer :: noise_states(3) = 0                  !! Of each axis' process: those of the flicker noise
        real(dp), allocatable :: residual(:, :)
        !! Of the accelerometer, smoothed, the noise of the instrument left in: (3, samples), m/s^2
        real(dp) :: residual_rms(3) = 0                 !! Of those kept, m/s^2
    end type work_t

contains

    !> Estimates the CG offset. The covariance comes with it and is always given; without options%covariance
    !> the turn is not compared with the rods' torque.
    !>
    !> Fails when the observations are refused, when the setup gives no noise levels, when the samples
    !> do not determine the offset, and, with the checks, when the satellite did not turn as the torque
    !> rods should have made it.
    subroutine estimate_sequential(observations, options, solution, error, record)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record   !! For diagnostics

        type(work_t) :: work
        integer :: round, iterations
        logical :: changed

        solution%algorithm = 'sequential'
        call prepare(observations, options, work, error)
        if (allocated(error)) return
        call fit_attitude(work, error)
        if (allocated(error)) return
        call screen_accelerations(work)
        solution%iterations = 0
        do round = 1, MOST_EDITING_ROUNDS
            call fit(observations%knowledge, options%sequential, work, iterations, solution%converged, error)
            if (allocated(error)) return
            solution%iterations = solution%iterations + iterations
            call edit(options%sequential%edit_sigma, work, changed)
            if (.not. changed) exit
        end do
        solution%converged = solution%converged .and. .not. changed
        solution%warnings = work%data%warnings
        call store_solution(observations%knowledge, work, solution, error, record)
        if (allocated(error)) return
        if (options%covariance .or. present(record)) &
            call check_rotation(observations%knowledge, work, solution, error, record)
    end subroutine estimate_sequential

    !> Preprocesses, and lays the problem out. Spikes of the star camera are left out of it.
    subroutine prepare(observations, options, work, error)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(work_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error

        integer :: n, stars

        call preprocess(observations, options, work%data, error)
        if (.not. allocated(error)) call refuse_stuck_axis(work%data, error)
        if (.not. allocated(error)) call check_noise(observations%knowledge, error)
        if (allocated(error)) return
        call prepare_model(observations%knowledge, work%data, ESTIMATED, work%model)
        work%state = initial_state(work%data, options)
        work%guess = work%state
        work%guess%value(OFFSET) = 0            ! so that the guess has no weight at all
        n = size(work%data%accelerometer_epoch)
        stars = size(work%data%stars%time)
        allocate (work%residual(3, n), source=0.0_dp)
        allocate (work%predicted(3, n), work%partials(size(ESTIMATED), 3, n), work%remainder(M + 1, n, 3))
        associate (problem => work%problem)
            problem%m = M
            problem%steps = work%data%steps
            problem%interval = work%data%interval
            problem%epoch = work%data%accelerometer_epoch
            problem%star_time = work%data%stars%time
            allocate (problem%prior(M + 1, M), problem%acceleration(M + 1, n, 3), problem%kept(n, 3), &
                      problem%star(M + 1, 3, stars), problem%star_kept(stars))
            problem%acceleration = 0
            problem%star = 0
            problem%kept = .true.
            problem%star_kept = .true.
        end associate
        call set_noise(observations%knowledge, options%sequential, work, error)
        if (allocated(error)) return
        call integrate_trajectory(work%model, work%state, work%trajectory)
        work%star_sigma = observations%knowledge%star_camera_sigma
        work%shared_sigma = options%sequential%shared_part
        if (options%sequential%acceleration == STRAIGHT_LINE) &
            where (ESTIMATED == DRAG_CURVATURE) work%prior_sigma = NO_CURVATURE
        call linearise_stars(work)
        call screen_stars(work%problem)
    end subroutine prepare

    !> Fails unless every noise level is given: they are the weights.
    subroutine check_noise(knowledge, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        integer :: axis

        do axis = 1, 3
            if (.not. knowledge%accelerometer_noise(axis)%level > 0) then
                call fail(error, 'sequential: noise_level of accelerometer axis '//AXES(axis)//' = '// &
                          number_text(knowledge%accelerometer_noise(axis)%level)//' m^2 s^-4/Hz: it must be '// &
                          'positive, since the noise gives the samples their weights')
            else if (.not. knowledge%star_camera_sigma(axis) > 0) then
                call fail(error, 'sequential: noise_about_axes('//AXES(axis)//') of the star camera = '// &
                          number_text(knowledge%star_camera_sigma(axis))//' rad: it must be positive, since '// &
                          'the noise gives the samples their weights')
            end if
            if (allocated(error)) return
        end do
    end subroutine check_noise

    !> White noise and flicker processes of the accelerometer.
    subroutine set_noise(knowledge, sequential, work, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(sequential_options_t), intent(in) :: sequential
        type(work_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error

        type(coloured_noise_t) :: noise
        real(dp) :: white_variance, correlation(N_POLES), variance(N_POLES)
        integer :: axis

        do axis = 1, 3
            noise = coloured_noise(knowledge%accelerometer_noise(axis), knowledge%accelerometer_interval, error)
            if (allocated(error)) return
            call noise%markov_form(white_variance, correlation, variance)
            work%white_sigma(axis) = sqrt(white_variance)
            work%problem%process(axis) = flicker_process(noise, work%problem%steps)
            work%noise_states(axis) = work%problem%process(axis)%n
            if (sequential%acceleration == GIVEN .and. sequential%process_sigma(axis) > 0) &
                work%problem%process(axis) = with_disturbance( &
                work%problem%process(axis), disturbance_t(sequential%process_sigma(axis)/work%white_sigma(axis), &
                                                          1/sequential%process_period, &
                                                          sequential%process_damping), work%problem%interval)
        end do
    end subroutine set_noise

    !> Residuals and partials of the star camera and of the a-priori knowledge about the nominal
    !> trajectory, in units of their standard deviations.
    subroutine linearise_stars(work)
        type(work_t), intent(inout) :: work

        real(dp) :: angles(3), partials(size(ESTIMATED), 3), known(size(ESTIMATED))
        integer :: i, j

        known = work%guess%value(ESTIMATED) - work%state%value(ESTIMATED)
        known(1:3) = turn_between(work%state%quaternion, work%guess%quaternion)
        work%problem%prior = 0
        do i = 1, size(ESTIMATED)
            work%problem%prior(PLACE(i), PLACE(i)) = 1/work%prior_sigma(i)
            work%problem%prior(M + 1, PLACE(i)) = known(i)/work%prior_sigma(i)
        end do
        do i = 1, size(SHARED)
            work%problem%prior(SHARED(i), SHARED(i)) = 1/work%shared_sigma
            work%problem%prior(M + 1, SHARED(i)) = work%shared_part(i)/work%shared_sigma
        end do
        associate (stars => work%data%stars)
            do i = 1, size(stars%time)
                call star_angles(work%model, work%trajectory, stars%time(i), stars%head(i), stars%quaternion(:, i), &
                                 angles, partials)
                do j = 1, 3
                    work%problem%star(PLACE, j, i) = partials(:, j)/work%star_sigma(j)
                    work%problem%star(M + 1, j, i) = angles(j)/work%star_sigma(j)
                end do
            end do
        end associate
    end subroutine linearise_stars

    !> The same of the accelerometer, in units of its white noise.
    subroutine linearise_accelerations(work)
        type(work_t), intent(inout) :: work

        integer :: i, axis

        call predict_accelerations(work%model, work%state, work%trajectory, work%data%accelerometer_epoch, &
                                   work%predicted, work%partials)
        associate (problem => work%problem)
            do axis = 1, 3
                do i = 1, size(problem%epoch)
                    problem%acceleration(PLACE, i, axis) = work%partials(:, axis, i)/work%white_sigma(axis)
                    problem%acceleration(M + 1, i, axis) = (work%data%acceleration(axis, i) - &
                                                            work%predicted(axis, i))/work%white_sigma(axis)
                end do
            end do
        end associate
    end subroutine linearise_accelerations

    !> Leaves spikes of the star camera out, before they can pull the nominal trajectory.
    subroutine screen_stars(problem)
        type(filter_problem_t), intent(inout) :: problem

        integer :: j

        do j = 1, 3
            problem%star_kept = problem%star_kept .and. .not. is_spike(problem%star(M + 1, j, :), 1.0_dp, SPIKE_LIMIT)
        end do
        if (count(problem%star_kept) < 3) problem%star_kept = .true.
    end subroutine screen_stars

    !> The same of the accelerometer.
    subroutine screen_accelerations(work)
        type(work_t), intent(inout) :: work

        integer :: axis

        do axis = 1, 3
            work%problem%kept(:, axis) = .not. is_spike(work%problem%acceleration(M + 1, :, axis), 1.0_dp, &
                                                        SPIKE_LIMIT)
        end do
    end subroutine screen_accelerations

    !> Brings the nominal trajectory near the truth by the star camera alone: Gauss and Newton's
    !> iteration with the accelerometer left aside. What it would determine stays as it was.
    subroutine fit_attitude(work, error)
        type(work_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error

        logical, allocatable :: kept(:, :)
        type(constants_t) :: constants
        real(dp) :: y(M)
        integer :: iteration

        allocate (kept, mold=work%problem%kept)
        kept = work%problem%kept
        work%problem%kept = .false.
        do iteration = 1, MOST_ATTITUDE_ITERATIONS
            call gather(work%problem, work%remainder, constants)
            y = constants%solution()
            call advance_nominal(work, y, error)
            if (allocated(error)) return
            call linearise_stars(work)
            if (corrections_in_sigmas(constants, y, 6) < 1) exit
        end do
        work%problem%kept = kept
        call linearise_accelerations(work)
    end subroutine fit_attitude

    !> Corrects the nominal state and integrates its trajectory. Fails when a correction is not finite.
    subroutine advance_nominal(work, correction, error)
        type(work_t), intent(inout) :: work
        real(dp), intent(in) :: correction(M)
        type(error_t), allocatable, intent(out) :: error

        if (.not. all(abs(correction) <= huge(1.0_dp))) then
            call fail(error, 'sequential: the nominal trajectory diverges; check guess_quaternion and '// &
                      'guess_angular_velocity')
            return
        end if
        call correct_state(work%model, correction(PLACE), work%state)
        call integrate_trajectory(work%model, work%state, work%trajectory)
    end subroutine advance_nominal

    !> The largest correction of the first parameters of the model in units of their standard deviations.
    pure real(dp) function corrections_in_sigmas(constants, correction, n) result(largest)
        type(constants_t), intent(in) :: constants
        real(dp), intent(in) :: correction(M)
        integer, intent(in) :: n

        real(dp) :: root(M, M)

        root = constants%inverse_root()
        largest = maxval(abs(correction(PLACE(:n)))/norm2(root(PLACE(:n), :), 2))
    end function corrections_in_sigmas

    !> Corrects the nominal trajectory until nothing changes, then filters about it. The disturbances of
    !> the axes are searched for in the first iteration, if they are to be found from the data.
    subroutine fit(knowledge, sequential, work, iterations, converged, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(sequential_options_t), intent(in) :: sequential
        type(work_t), intent(inout) :: work
        integer, intent(out) :: iterations
        logical, intent(out) :: converged
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: y(M)
        logical :: searching

        call set_noise(knowledge, sequential, work, error)
        if (allocated(error)) return
        searching = sequential%acceleration == ADAPTIVE
        converged = .false.
        do iterations = 1, MOST_ITERATIONS
            call whiten(work)
            if (searching) then
                call search(sequential%likelihood_gain, work, error)
                if (allocated(error)) return
                searching = .false.
            end if
            call gather(work%problem, work%remainder, work%constants)
            y = work%constants%solution()
            converged = corrections_in_sigmas(work%constants, y, size(ESTIMATED)) < NEGLIGIBLE
            if (converged) exit
            call advance_nominal(work, y, error)
            if (allocated(error)) return
            call linearise_stars(work)
            call linearise_accelerations(work)
        end do
        iterations = min(iterations, MOST_ITERATIONS)
        call filter(work, error)
    end subroutine fit

    !> Filters about the present nominal trajectory with what the smoother needs.
    subroutine filter(work, error)
        type(work_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error

        integer :: axis

        do axis = 1, 3
            call filter_axis(work%problem, axis, work%problem%process(axis), .true., work%filter(axis), &
                             work%remainder(:, :, axis), error)
            if (allocated(error)) return
        end do
        call gather(work%problem, work%remainder, work%constants)
    end subroutine filter

    !> What the axes' samples say of the constants, without a smoother.
    subroutine whiten(work)
        type(work_t), intent(inout) :: work

        real(dp) :: unused
        integer :: axis

        do axis = 1, 3
            associate (problem => work%problem)
                call whiten_by_process(problem%process(axis), problem%epoch, problem%kept(:, axis), &
                                       problem%acceleration(:, :, axis), work%remainder(:, :, axis), unused)
            end associate
        end do
    end subroutine whiten

    !> Searches all axes for disturbances. Drag varies along its own direction: of what the axis with the
    !> largest disturbance shows, the others see a part that is estimated, even where it is too small to
    !> be found by itself. So that axis comes first, and the others know of it.
    subroutine search(needed_gain, work, error)
        real(dp), intent(in) :: needed_gain
        type(work_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error

        type(gauss_markov_t) :: noise(3)
        real(dp) :: largest(3), unused
        integer :: axis

        noise = work%problem%process
        work%leading = 0
        work%problem%acceleration(SHARED, :, :) = 0
        do axis = 1, 3
            call search_disturbance(work%problem, axis, needed_gain, work%remainder, work%found(axis)%list)
            largest(axis) = work%white_sigma(axis)*maxval([0.0_dp, work%found(axis)%list%sigma])
        end do
        if (.not. maxval(largest) > 0) return
        work%leading = maxloc(largest, 1)
        call take_disturbance(noise(work%leading)%n, work, error)
        if (allocated(error)) return
        do axis = 1, 3
            if (axis == work%leading) cycle
            work%problem%process(axis) = noise(axis)
            call whiten_by_process(noise(axis), work%problem%epoch, work%problem%kept(:, axis), &
                                   work%problem%acceleration(:, :, axis), work%remainder(:, :, axis), unused)
            call search_disturbance(work%problem, axis, needed_gain, work%remainder, work%found(axis)%list)
        end do
    end subroutine search

    !> Smooths the disturbance of the leading axis and lets the other two see a part of it: a priori that
    !> of an acceleration along the airflow, if that is anywhere near the leading axis.
    subroutine take_disturbance(noise_states, work, error)
        integer, intent(in) :: noise_states         !! Of the leading axis: those of the instrument's noise
        type(work_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error

        type(process_filter_t) :: filter
        type(constants_t) :: constants
        real(dp), dimension(size(work%problem%epoch)) :: disturbance, unused_residual, unused_chi_square
        real(dp), allocatable :: signal(:)
        real(dp) :: airflow(3)
        integer :: axis, other

        associate (leading => work%leading)
            call filter_axis(work%problem, leading, work%problem%process(leading), .true., filter, &
                             work%remainder(:, :, leading), error)
            if (allocated(error)) return
            call gather(work%problem, work%remainder, constants)
            signal = work%problem%process(leading)%output
            signal(:noise_states) = 0
            call smooth_axis(work%problem, leading, filter, constants, signal, disturbance, unused_residual, &
                             unused_chi_square)
            airflow = airflow_at(work%model, work%trajectory%q(:, work%model%steps/2), work%model%steps/2)
            other = 0
            do axis = 1, 3
                if (axis == leading) cycle
                other = other + 1
                work%shared_part(other) = 0
                if (abs(airflow(leading)) > ALONG_THE_AIRFLOW) work%shared_part(other) = airflow(axis)/airflow(leading)
                work%problem%acceleration(SHARED(other), :, axis) = disturbance*work%white_sigma(leading)/ &
                                                                    work%white_sigma(axis)
            end do
        end associate
        call linearise_stars(work)              ! with the a-priori knowledge
    end subroutine take_disturbance

    !> Decides anew which samples are kept: those whose chi-square against all others is below the limit
    !> of as many standard deviations, in units of what is usual if that is more than noise.
    subroutine edit(edit_sigma, work, changed)
        real(dp), intent(in) :: edit_sigma      !! The limit, standard deviations
        type(work_t), intent(inout) :: work
        logical, intent(out) :: changed         !! Another set of samples than before

        real(dp), allocatable :: flicker(:), residual(:), chi_square(:), star_chi_square(:), signal(:)
        logical, allocatable :: kept(:)
        real(dp) :: limit
        integer :: axis, n

        n = size(work%problem%epoch)
        changed = .false.
        limit = edit_sigma**2
        allocate (flicker(n), residual(n), chi_square(n), kept(n))
        do axis = 1, 3
            signal = work%problem%process(axis)%output
            signal(work%noise_states(axis) + 1:) = 0
            call smooth_axis(work%problem, axis, work%filter(axis), work%constants, signal, flicker, residual, &
                             chi_square)
            kept = chi_square <= limit*max(1.0_dp, median_of(chi_square)/MEDIAN_1)
            changed = changed .or. any(kept .neqv. work%problem%kept(:, axis))
            work%residual(axis, :) = work%white_sigma(axis)*(residual + flicker)
            work%residual_rms(axis) = norm2(pack(work%residual(axis, :), work%problem%kept(:, axis)))/ &
                                      sqrt(real(max(1, count(work%problem%kept(:, axis))), dp))
            work%problem%kept(:, axis) = kept
        end do
        allocate (star_chi_square(size(work%problem%star_time)))
        call smooth_star_camera(work%problem, work%constants, star_chi_square)
        limit = chi_square_of_three(edit_sigma)
        kept = star_chi_square <= limit*max(1.0_dp, median_of(star_chi_square)/MEDIAN_3)
        changed = changed .or. any(kept .neqv. work%problem%star_kept)
        work%problem%star_kept = kept
    end subroutine edit

    !> The value that a chi-square with 3 degrees of freedom exceeds as rarely as a normal variable
    !> exceeds z, one-sided: E. B. Wilson, M. M. Hilferty, Proc. Nat. Acad. Sci. 17 (1931) 684-688.
    pure real(dp) function chi_square_of_three(z) result(value)
        real(dp), intent(in) :: z

        real(dp), parameter :: V = 2/27.0_dp

        value = 3*(1 - V + z*sqrt(V))**3
    end function chi_square_of_three

    !> The last estimate with its covariance, and what is to be said of it.
    subroutine store_solution(knowledge, work, solution, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(work_t), intent(inout) :: work
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record

        type(model_state_t) :: final
        type(constants_t) :: constants
        real(dp) :: y(M), root(M, M), unused(3)
        integer :: i

        allocate (solution%running)
        call run_through_time(work%problem, work%remainder, work%state%value(OFFSET), constants, solution%running)
        y = constants%solution()
        final = work%state
        call correct_state(work%model, y(PLACE), final)
        solution%offset = final%value(OFFSET)
        solution%drift = final%value(DRIFT)
        solution%bias = final%value(BIAS)
        solution%quaternion = final%quaternion
        solution%angular_velocity = final%value(RATE)
        solution%residual_rms = work%residual_rms
        solution%condition = condition_of(constants)
        root = constants%inverse_root()
        solution%parameters = [(estimated_parameter_t(PARAMETER_NAMES(TORQUE(i)), final%value(TORQUE(i)), &
                                                      norm2(root(TORQUE(i), :))), i=1, 3)]    ! PLACE is the same
        solution%noise_level = knowledge%accelerometer_noise%level
        solution%noise_corner = knowledge%accelerometer_noise%corner
        solution%star_camera_sigma = knowledge%star_camera_sigma
        solution%edited = [count(.not. work%problem%kept), count(.not. work%problem%star_kept)]
        call constants%last_covariance(unused, solution%covariance)
        if (.not. maxval(solution%running%sigma(:, work%problem%steps)) < UNDETERMINED) then
            call fail(error, 'sequential: the observations do not determine the offset: its standard '// &
                      'deviation is '//number_text(maxval(solution%running%sigma(:, work%problem%steps)))// &
                      ' m; did the torque rods turn the satellite?')
            return
        end if
        call allow_for_misfit(work, constants, solution)
        call report_editing(work, solution)
        call report_disturbances(work, solution)
        if (present(record)) call record_fit(work, constants, solution%covariance(1, 1)/ &
                                             sum(root(PLACE(OFFSETS_AMONG_ESTIMATED(1)), :)**2), record)
    end subroutine store_solution

    !> Puts the fit into a record. The whitened observations have unit noise, so with the covariance
    !> P = U U^T of the constants the observations of a source, with the partials g, bring
    !> U (sum U^T g g^T U) U^T to it; all sources together make it whole.
    subroutine record_fit(work, constants, misfit, record)
        type(work_t), intent(in) :: work
        type(constants_t), intent(in) :: constants  !! After all observations
        real(dp), intent(in) :: misfit              !! Factor by which the covariance is enlarged
        type(fit_record_t), intent(inout) :: record

        real(dp) :: root(M, M)
        integer, allocatable :: kept(:), order(:)
        integer :: i, axis

        associate (problem => work%problem)
            kept = pack([(i, i=1, size(problem%epoch))], all(problem%kept, 2))
            record%interval = problem%interval
            record%epoch = problem%epoch(kept)
            record%residual = work%residual(:, kept)
            allocate (record%partials(3, 3, size(kept)))
            do i = 1, size(kept)
                record%partials(:, :, i) = transpose(work%partials(OFFSETS_AMONG_ESTIMATED, :, kept(i)))
            end do
            record%angular_acceleration = work%trajectory%omega_dot(:, record%epoch)

            order = PLACE([OFFSETS_AMONG_ESTIMATED, [(i, i=1, OTHERS)]])
            record%names = [PARAMETER_NAMES(OFFSET), PARAMETER_NAMES(ESTIMATED(:OTHERS))]
            if (work%leading > 0) then
                order = [order, SHARED]
                record%names = [character(12) :: record%names, 'shared_1', 'shared_2']
            end if
            root = constants%inverse_root()
            record%covariance = misfit*matmul(root(order, :), transpose(root(order, :)))
            associate (by => record%covariance_by_source)
                by = 0
                do i = 1, M
                    call add(problem%prior(:M, i), by(:, :, A_PRIORI_KNOWLEDGE))
                end do
                do i = 1, size(problem%star_time)
                    if (.not. problem%star_kept(i)) cycle
                    do axis = 1, 3
                        call add(problem%star(:M, axis, i), by(:, :, STAR_CAMERA_NOISE))
                    end do
                end do
                do axis = 1, 3
                    do i = 1, size(problem%epoch)
                        if (problem%kept(i, axis)) call add(work%remainder(:M, i, axis), by(:, :, axis))
                    end do
                end do
            end associate
        end associate

    contains

        !> Adds what one whitened observation brings to the covariance of the offset.
        pure subroutine add(g, covariance)
            real(dp), intent(in) :: g(M)
            real(dp), intent(inout) :: covariance(3, 3)     ! m^2

            real(dp) :: gain(3)

            gain = matmul(root(PLACE(OFFSETS_AMONG_ESTIMATED), :), matmul(g, root))
            covariance = covariance + misfit*spread(gain, 2, 3)*spread(gain, 1, 3)
        end subroutine add
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
    subroutine allow_for_misfit(work, constants, solution)
        type(work_t), intent(in) :: work
        type(constants_t), intent(in) :: constants
        type(solution_t), intent(inout) :: solution

        real(dp), parameter :: SIGNIFICANT = 5          !! In standard deviations of the variance
        real(dp) :: variance
        integer :: n

        n = count(work%problem%kept) + 3*count(work%problem%star_kept) - M
        variance = constants%squares/max(1, n)
        solution%variance_factor = variance
        if (.not. variance > 1 + SIGNIFICANT*sqrt(2.0_dp/max(1, n))) return
        solution%covariance = variance*solution%covariance
        solution%running%sigma = sqrt(variance)*solution%running%sigma
        call append(solution%warnings, 'the innovations have a variance of '//number_text(variance)// &
                    ' instead of 1: the samples have more noise, or the satellite more disturbances, than '// &
                    'the filter knows of; the sigmas are enlarged by the square root of it')
    end subroutine allow_for_misfit

    subroutine report_editing(work, solution)
        type(work_t), intent(in) :: work
        type(solution_t), intent(inout) :: solution

        integer :: axis, edited

        associate (problem => work%problem)
            do axis = 1, 3
                edited = count(.not. problem%kept(:, axis))
                if (edited == 0) cycle
                call append(solution%warnings, 'accelerometer: '//integer_text(edited)//' of '// &
                            integer_text(size(problem%epoch))//' values of axis '//AXES(axis)// &
                            ' edited, the first at '// &
                            number_text(problem%interval*problem%epoch(findloc(problem%kept(:, axis), .false., 1)))// &
                            ' s')
            end do
            edited = count(.not. problem%star_kept)
            if (edited > 0) &
                call append(solution%warnings, 'star camera: '//integer_text(edited)//' of '// &
                            integer_text(size(problem%star_time))//' samples edited, the first at '// &
                            number_text(problem%star_time(findloc(problem%star_kept, .false., 1)))//' s')
        end associate
    end subroutine report_editing

    subroutine report_disturbances(work, solution)
        type(work_t), intent(in) :: work
        type(solution_t), intent(inout) :: solution

        integer :: axis, i

        do axis = 1, 3
            if (.not. allocated(work%found(axis)%list)) cycle
            do i = 1, size(work%found(axis)%list)
                associate (disturbance => work%found(axis)%list(i))
                    call append(solution%warnings, 'accelerometer: the non-gravitational acceleration of axis '// &
                                AXES(axis)//' is no straight line; followed as a process of '// &
                                number_text(disturbance%sigma*work%white_sigma(axis))//' m/s^2 with a period of '// &
                                number_text(1/disturbance%frequency)//' s and a damping ratio of '// &
                                number_text(disturbance%damping))
                end associate
            end do
        end do
    end subroutine report_disturbances

    !> Compares the turn that the star camera saw with the torque of the rods.
    subroutine check_rotation(knowledge, work, solution, error, record)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(work_t), intent(in) :: work
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        type(fit_record_t), intent(inout), optional :: record

        type(attitude_problem_t) :: attitude

        call prepare_attitude(knowledge, work%data, .true., attitude)
        attitude%quaternion = solution%quaternion
        attitude%angular_velocity = solution%angular_velocity
        call check_torque(knowledge, attitude, solution%warnings, error, record)
    end subroutine check_rotation
end module gracecg_estimation_sequential
