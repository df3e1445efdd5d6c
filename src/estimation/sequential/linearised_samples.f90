!> The calibration as a filter sees it: linearised samples of accelerometer and star camera in the
!> order of time, the disturbances of each accelerometer axis as Gauss-Markov processes.
!>
!> The constants are the parts of a disturbance that two axes share with a third, the error of its frequency, the
!> parameters of the physical model at the epoch about a nominal trajectory and, last, the CG offset. Every
!> axis has a process of its own (the
!> flicker noise of the instrument, and what the non-gravitational acceleration does beside its
!> straight line); given the constants, the axes are independent, so each is whitened by itself and
!> what is left meets in the array of the constants (gracecg_estimation_square_root_information).
module gracecg_estimation_linearised_samples
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: sum_of_products
    use gracecg_base_vectors, only: identity
    use gracecg_base_coloured_noise, only: coloured_noise_t, N_POLES
    use gracecg_base_gauss_markov, only: gauss_markov_t, no_process, first_order_process, superposed
    use gracecg_observations_parameters, only: ATTITUDE_ANGLES, RATE, TORQUE, OFFSET, DRIFT, BIAS, FORCE_SHAPES, &
        LIFT, SCALE_FACTORS, FIELD_BIAS, parameter_names
    use gracecg_estimation_information, only: information_t, information_of
    use gracecg_estimation_noise_whitening, only: process_filter_t, prepare_filter, nonzero_rows
    use gracecg_estimation_square_root_information, only: constants_t, new_constants
    use gracecg_estimation_process_smoother, only: smooth_errors, smooth_signals
    use gracecg_estimation_solution, only: running_estimate_t
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_physical_model, only: physical_model_t, model_state_t, model_trajectory_t, &
        integrate_trajectory, predict_accelerations, star_angles, correct_state, turn_between, describe_model_state
    use gracecg_estimation_iteration, only: iteration_t, append_iteration, rms_of
    implicit none
    private
    public :: filter_problem_t, SHARED, FREQUENCY
    public :: flicker_process, whiten, whiten_axis, gather, run_through_time, smooth_axis, smooth_star_camera
    public :: MODEL_FIRST, N_CONSTANTS, ESTIMATED, OFFSET_PLACES, FIRST_FIT
    public :: calibration_filter_t, begin_filter

    integer, parameter :: SHARED(2) = [1, 2]        !! Places of the shared parts among the constants
    integer, parameter :: FREQUENCY = 3     !! Place of the error of a tone's frequency, in units of one cycle an arc

    !> A calibration, linearised about a nominal trajectory.
    type :: filter_problem_t
        integer :: m = 0                            !! Number of constants; the offset is the last three
        integer :: steps = 0                        !! Intervals of the arc
        real(dp) :: interval = 0                    !! Of the accelerometer, s
        real(dp), allocatable :: prior(:, :)        !! [g, r] of the a-priori knowledge: (m + 1, m)
        integer, allocatable :: epoch(:)            !! Of the accelerometer's samples, in intervals
        real(dp), allocatable :: acceleration(:, :, :)
        !! [g, r] in units of the white noise: (m + 1, samples, axis)
        logical, allocatable :: kept(:, :)          !! (samples, axis)
        real(dp), allocatable :: star_time(:)       !! Increasing, s
        real(dp), allocatable :: star(:, :, :)      !! [g, r] in units of the noise: (m + 1, 3, samples)
        logical, allocatable :: star_kept(:)        !! (samples)
        type(gauss_markov_t) :: process(3)          !! By axis, in units of the white noise
        type(process_filter_t) :: filter(3)         !! Of the processes and the samples kept when last used
    end type filter_problem_t

    !> A pole whose correlation time is longer than so many arcs cannot be told from a bias
    real(dp), parameter :: LONG_COMPARED_TO_ARC = 10

    !> The parameters of the physical model that are estimated, in their order among the constants
    integer, parameter :: ESTIMATED(*) = [ATTITUDE_ANGLES, RATE, TORQUE, DRIFT, BIAS, FORCE_SHAPES, LIFT, SCALE_FACTORS, &
                                          FIELD_BIAS, OFFSET]
    integer, parameter :: OFFSET_PLACES(3) = size(ESTIMATED) - [2, 1, 0]    !! Of the offset among them

    !> What the first fit is called in the history
    character(*), parameter :: FIRST_FIT = 'attitude and rate'

    !> The constants
    integer, parameter :: MODEL_FIRST = FREQUENCY + 1     !! First those SHARED, FREQUENCY; from here on those ESTIMATED
    integer, parameter :: N_CONSTANTS = FREQUENCY + size(ESTIMATED)    !! Their number
    real(dp), parameter :: FREQUENCY_SIGMA = 1              !! A priori, cycles an arc: what a spectrum resolves

    !> A calibration about its nominal trajectory.
    type, extends(filter_problem_t) :: calibration_filter_t
        type(fitting_data_t) :: data            !! Preprocessed observations
        type(physical_model_t) :: model         !! What is fitted
        type(model_state_t) :: guess            !! Where the a-priori knowledge stands
        real(dp) :: prior_sigma(size(ESTIMATED)) = 1        !! A priori, of the parameters
        real(dp) :: shared_sigma = 1            !! A priori, of the shared parts
        real(dp) :: white_sigma(3) = 1          !! White noise of the accelerometer, m/s^2
        real(dp) :: star_sigma(3) = 1           !! Of the star camera about its axes, rad
        type(gauss_markov_t) :: known_process(3)
        !! Of each accelerometer axis before others are searched for, white noise = 1: the flicker noise
        type(model_state_t) :: state            !! The nominal one, at which it is linearised
        type(model_trajectory_t) :: trajectory  !! Along the arc, at that state
        real(dp), allocatable :: partials(:, :, :)          !! Of the accelerometer, (ESTIMATED, 3, samples)
        logical :: keeps_history = .false.      !! Is every correction noted?
        type(iteration_t), allocatable :: history(:)        !! The corrections noted
    contains
        procedure :: linearise_prior            !! A-priori knowledge about the nominal trajectory
        procedure :: linearise_stars            !! Residuals and partials of the star camera
        procedure :: linearise_accelerations    !! The same of the accelerometer
        procedure :: move => move_nominal       !! Another nominal trajectory, and the a-priori knowledge and stars about it
    end type calibration_filter_t

contains

    !> The flicker part of an accelerometer axis, in units of its white part.
    function flicker_process(noise, steps) result(process)
        type(coloured_noise_t), intent(in) :: noise
        integer, intent(in) :: steps                !! Of the arc
        type(gauss_markov_t) :: process

        real(dp) :: white_variance, correlation(N_POLES), variance(N_POLES)
        type(gauss_markov_t) :: part
        integer :: i

        call noise%markov_form(white_variance, correlation, variance)
        process = no_process()
        do i = 1, N_POLES
            if (.not. abs(variance(i)) > 0) cycle
            if (all(variance >= 0) .and. -log(abs(correlation(i)))*steps*LONG_COMPARED_TO_ARC < 1) cycle
            part = first_order_process(sqrt(abs(variance(i))/white_variance), correlation(i))
            part%noise = sign(part%noise, variance(i))              ! only their sum has to be a noise
            part%covariance = sign(part%covariance, variance(i))
            process = superposed(process, part)
        end do
    end function flicker_process

    !> The samples of an axis, whitened by its process.
    pure subroutine whiten_axis(problem, axis, remainder)
        class(filter_problem_t), intent(inout) :: problem
        integer, intent(in) :: axis     !! 1, 2, 3
        real(dp), intent(out) :: remainder(:, :)        !! (m + 1, samples)

        call prepare_filter(problem%process(axis), problem%epoch, problem%kept(:, axis), problem%filter(axis))
        remainder = problem%acceleration(:, :, axis)
        call problem%filter(axis)%whiten(remainder)
    end subroutine whiten_axis

    !> The samples of all axes, by filters as they are.
    pure subroutine whiten(problem, remainder)
        class(filter_problem_t), intent(in) :: problem
        real(dp), allocatable, intent(inout) :: remainder(:, :, :)      !! (m + 1, samples, axis)

        integer :: axis

        remainder = problem%acceleration
        do axis = 1, 3
            call problem%filter(axis)%whiten(remainder(:, :, axis))
        end do
    end subroutine whiten

    !> The constants from what is known a priori, the star camera and, if given, the axes' remainders, but for
    !> one axis if `without` names it.
    pure subroutine gather(problem, constants, remainder, without)
        class(filter_problem_t), intent(in) :: problem
        type(constants_t), intent(out) :: constants
        real(dp), intent(in), optional :: remainder(:, :, :)    !! (m + 1, samples, axis)
        integer, intent(in), optional :: without    !! The axis to leave out, 1, 2 or 3

        real(dp) :: stars(problem%m + 1, 3*size(problem%star_time))
        integer :: i, n, axis

        call gather_prior(problem, constants)
        n = 0
        do i = 1, size(problem%star_time)
            if (.not. problem%star_kept(i)) cycle
            stars(:, n + 1:n + 3) = problem%star(:, :, i)
            n = n + 3
        end do
        call constants%fold_in_all(stars(:, :n))
        if (.not. present(remainder)) return
        do axis = 1, 3
            if (present(without)) then
                if (axis == without) cycle
            end if
            call constants%fold_in_all(remainder(:, :, axis))
        end do
    end subroutine gather

    pure subroutine gather_prior(problem, constants)
        class(filter_problem_t), intent(in) :: problem
        type(constants_t), intent(out) :: constants

        integer :: i

        constants = new_constants(problem%m)
        do i = 1, problem%m
            call constants%fold_in(problem%prior(:, i))
        end do
        constants%squares = 0           ! of the observations alone
    end subroutine gather_prior

    !> The same in the order of time, with the estimate of the offset as it stands at every step.
    pure subroutine run_through_time(problem, remainder, nominal_offset, constants, running)
        class(filter_problem_t), intent(in) :: problem
        real(dp), intent(in) :: remainder(:, :, :)      !! (m + 1, samples, axis)
        real(dp), intent(in) :: nominal_offset(3)       !! About which the problem is linearised, m
        type(constants_t), intent(out) :: constants
        type(running_estimate_t), intent(out) :: running

        real(dp) :: covariance(3, 3), t
        integer :: k, i, star, axis, edited, edited_stars

        allocate (running%time(0:problem%steps), running%offset(3, 0:problem%steps), &
                  running%sigma(3, 0:problem%steps), running%edited_accelerometer(0:problem%steps), &
                  running%edited_star_camera(0:problem%steps))
        call gather_prior(problem, constants)
        i = 1
        star = 1
        edited = 0
        edited_stars = 0
        do k = 0, problem%steps
            t = k*problem%interval
            do while (star <= size(problem%star_time))
                if (problem%star_time(star) > t + problem%interval/2 .and. k < problem%steps) exit
                do axis = 1, merge(3, 0, problem%star_kept(star))
                    call constants%fold_in(problem%star(:, axis, star))
                end do
                if (.not. problem%star_kept(star)) edited_stars = edited_stars + 1
                star = star + 1
            end do
            do while (i <= size(problem%epoch))
                if (problem%epoch(i) > k) exit
                do axis = 1, 3
                    if (problem%kept(i, axis)) call constants%fold_in(remainder(:, i, axis))
                    if (.not. problem%kept(i, axis)) edited = edited + 1
                end do
                i = i + 1
            end do
            running%time(k) = t
            call constants%last_covariance(running%offset(:, k), covariance)
            running%offset(:, k) = running%offset(:, k) + nominal_offset
            running%sigma(:, k) = [(sqrt(covariance(axis, axis)), axis=1, 3)]
            running%edited_accelerometer(k) = edited
            running%edited_star_camera(k) = edited_stars
        end do
    end subroutine run_through_time

    !> What smoothing tells of one axis: its process at every sample, and how far the sample is from what
    !> all others predict, as a chi-square with one degree of freedom ("deletion residual": P. de Jong,
    !> J. Penzer, J. Am. Stat. Assoc. 93 (1998) 796-806). With the smoothed errors u of the partials and the observation
    !> (gracecg_estimation_process_smoother), e = u_r - u_g y and V = u_g C u_g^T, y the constants and C their covariance,
    !> that is e^2/(D - V) of a sample in use and (e/D)^2/(1/D + V/D^2) of one that is left out.
    subroutine smooth_axis(problem, axis, constants, signals, disturbance, residual, chi_square)
        class(filter_problem_t), intent(in) :: problem  !! Whitened
        integer, intent(in) :: axis    !! 1, 2, 3
        type(constants_t), intent(in) :: constants      !! After all observations
        real(dp), intent(in) :: signals(:, :)           !! Of the process' states those wanted: h, a part of it; by column
        real(dp), intent(out) :: disturbance(:, :)      !! signals^T p, (signals, samples), white noise = 1
        real(dp), intent(out) :: residual(:)            !! Smoothed residuals; of one left out against the others
        real(dp), intent(out) :: chi_square(:)          !! (samples)

        real(dp), allocatable :: rows(:, :), root(:, :)
        real(dp), dimension(size(problem%epoch)) :: errors, information
        real(dp) :: y(problem%m), through(problem%m, size(problem%epoch)), spread
        integer, allocatable :: seen(:)
        integer :: i, n

        y = constants%solution()
        root = constants%inverse_root()
        seen = nonzero_rows(problem%acceleration(:problem%m, :, axis))
        n = size(seen)
        rows = problem%acceleration([seen, problem%m + 1], :, axis)
        associate (process => problem%process(axis), kept => problem%kept(:, axis))
            call smooth_errors(problem%filter(axis), rows, information)
            errors = rows(n + 1, :) - matmul(y(seen), rows(:n, :))
            call sum_of_products(problem%m, size(problem%epoch), n, transpose(root(seen, :)), transpose(rows(:n, :)), through)
            do i = 1, size(problem%epoch)
                spread = sum(through(:, i)**2)
                associate (d => information(i))
                    if (kept(i)) then
                        residual(i) = errors(i)
                        chi_square(i) = errors(i)**2/max(d - spread, epsilon(d)*d)
                    else
                        residual(i) = errors(i)/d
                        chi_square(i) = residual(i)**2/(1/d + spread/d**2)
                    end if
                end associate
            end do
            call smooth_signals(process, problem%epoch, kept, errors, signals, disturbance)
        end associate
    end subroutine smooth_axis

    !> The same of the star camera: a chi-square with three degrees of freedom of every sample against
    !> all others, e^T (I - V)^-1 e, or e^T (I + V)^-1 e of one that is not kept.
    subroutine smooth_star_camera(problem, constants, chi_square)
        class(filter_problem_t), intent(in) :: problem
        type(constants_t), intent(in) :: constants
        real(dp), intent(out) :: chi_square(:)          !! (samples)

        type(information_t) :: information
        type(error_t), allocatable :: not_positive
        real(dp) :: y(problem%m), root(problem%m, problem%m), left(3, problem%m), v(3, 3), e(3)
        integer :: i

        y = constants%solution()
        root = constants%inverse_root()
        do i = 1, size(problem%star_time)
            associate (rows => problem%star(:, :, i))
                e = rows(problem%m + 1, :) - matmul(y, rows(:problem%m, :))
                left = matmul(transpose(rows(:problem%m, :)), root)
            end associate
            v = identity(3) + merge(-1, 1, problem%star_kept(i))*matmul(left, transpose(left))
            call information_of(e, v, information, not_positive)
            chi_square(i) = merge(huge(1.0_dp), information%squares, allocated(not_positive))
        end do
    end subroutine smooth_star_camera

    !> Takes the data, all samples kept; no sample is linearised.
    subroutine begin_filter(data, problem)
        type(fitting_data_t), intent(in) :: data
        type(calibration_filter_t), intent(inout) :: problem

        problem%data = data
        problem%m = N_CONSTANTS
        problem%steps = data%steps
        problem%interval = data%interval
        problem%epoch = data%accelerometer_epoch
        problem%star_time = data%stars%time
        associate (samples => size(problem%epoch), stars => size(problem%star_time))
            allocate (problem%prior(N_CONSTANTS + 1, N_CONSTANTS), problem%acceleration(N_CONSTANTS + 1, samples, 3), &
                      problem%star(N_CONSTANTS + 1, 3, stars), source=0.0_dp)
            allocate (problem%kept(samples, 3), problem%star_kept(stars), source=.true.)
            allocate (problem%partials(size(ESTIMATED), 3, samples))
        end associate
    end subroutine begin_filter

    !> The a-priori knowledge about the nominal trajectory.
    subroutine linearise_prior(self, shared_part)
        class(calibration_filter_t), intent(inout) :: self
        real(dp), intent(in) :: shared_part(:)              !! A priori, of the constants SHARED

        real(dp) :: known(N_CONSTANTS), sigma(N_CONSTANTS)
        integer :: i

        known(SHARED) = shared_part
        known(FREQUENCY) = 0
        known(MODEL_FIRST:) = self%guess%value(ESTIMATED) - self%state%value(ESTIMATED)
        known(MODEL_FIRST:MODEL_FIRST + 2) = turn_between(self%state%quaternion, self%guess%quaternion)
        sigma(SHARED) = self%shared_sigma
        sigma(FREQUENCY) = FREQUENCY_SIGMA
        sigma(MODEL_FIRST:) = self%prior_sigma
        self%prior = 0
        do i = 1, N_CONSTANTS
            self%prior(i, i) = 1/sigma(i)
            self%prior(N_CONSTANTS + 1, i) = known(i)/sigma(i)
        end do
    end subroutine linearise_prior

    !> Residuals and partials of the star camera, in units of its noise.
    subroutine linearise_stars(self)
        class(calibration_filter_t), intent(inout) :: self

        real(dp) :: angles(3), partials(size(ESTIMATED), 3)
        integer :: i, j

        associate (stars => self%data%stars)
            do i = 1, size(stars%time)
                call star_angles(self%model, self%state, self%trajectory, stars%time(i), stars%head(i), &
                                 stars%quaternion(:, i), angles, partials)
                do j = 1, 3
                    self%star(MODEL_FIRST:, j, i) = [partials(:, j), angles(j)]/self%star_sigma(j)
                end do
            end do
        end associate
    end subroutine linearise_stars

    !> Residuals and partials of the accelerometer, in units of its white noise.
    subroutine linearise_accelerations(self)
        class(calibration_filter_t), intent(inout) :: self

        real(dp) :: predicted(3, size(self%epoch))
        integer :: i, axis

        call predict_accelerations(self%model, self%state, self%trajectory, self%epoch, predicted, self%partials)
        do axis = 1, 3
            do i = 1, size(self%epoch)
                self%acceleration(MODEL_FIRST:, i, axis) = [self%partials(:, axis, i), &
                    self%data%acceleration(axis, i) - predicted(axis, i)]/self%white_sigma(axis)
            end do
        end do
    end subroutine linearise_accelerations

    !> Corrects the nominal state, integrates its trajectory, and linearises a-priori knowledge and star camera about it.
    !> Fails when a correction is not finite.
    subroutine move_nominal(self, fit, shared_part, error, correction)
        class(calibration_filter_t), intent(inout) :: self
        character(*), intent(in) :: fit                     !! What is fitted, for the history
        real(dp), intent(in) :: shared_part(:)              !! See linearise_prior
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: correction(N_CONSTANTS)
        !! Of the constants, in the parameters' units; absent: none, at the first guess

        if (present(correction)) then
            if (.not. all(abs(correction) <= huge(1.0_dp))) then
                call fail(error, 'sequential: the nominal trajectory diverges; check guess_quaternion and '// &
                          'guess_angular_velocity')
                return
            end if
            call correct_state(self%model, correction(MODEL_FIRST:), self%state)
        end if
        call integrate_trajectory(self%model, self%state, self%trajectory)
        if (present(correction) .and. self%keeps_history) call note_iteration(self, fit, correction)
        call self%linearise_prior(shared_part)
        call self%linearise_stars()
    end subroutine move_nominal

    !> Notes a correction that has been made, with the residuals before it.
    subroutine note_iteration(problem, fit, correction)
        class(calibration_filter_t), intent(inout) :: problem
        character(*), intent(in) :: fit
        real(dp), intent(in) :: correction(N_CONSTANTS)

        type(iteration_t) :: note
        integer :: axis, last

        note%names = parameter_names(ESTIMATED)
        note%correction = correction(MODEL_FIRST:)
        call describe_model_state(problem%model, problem%state, note)
        last = merge(3, 6, fit == FIRST_FIT)    ! the first leaves the accelerometer aside
        note%residual_names = [character(12) :: 'star_x', 'star_y', 'star_z', 'acc_x', 'acc_y', 'acc_z']
        note%residual_names = note%residual_names(:last)
        associate (r => N_CONSTANTS + 1)
            note%residual_rms = [(rms_of(pack(problem%star(r, axis, :), problem%star_kept)), axis=1, 3), &
                                 (rms_of(pack(problem%acceleration(r, :, axis), problem%kept(:, axis))), axis=1, last - 3)]
        end associate
        note%residual_unit = 'sigma'
        call append_iteration(problem%history, note, fit)
    end subroutine note_iteration
end module gracecg_estimation_linearised_samples
