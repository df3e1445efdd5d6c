!> The calibration, linearised for the filter: the physical model about a nominal trajectory, every sample in
!> units of its noise.
!>
!> The constants that the filter estimates stand in blocks: first the parts of a disturbance that two axes
!> share with a third, then the error of its frequency, then the parameters of the physical model, of these the CG offset last.
module gracecg_estimation_linearisation
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_gauss_markov, only: gauss_markov_t
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_observations_parameters, only: ATTITUDE_ANGLES, RATE, TORQUE, OFFSET, DRIFT, BIAS, &
        FORCE_SHAPES, SCALE_FACTORS, FIELD_BIAS, parameter_names
    use gracecg_estimation_physical_model, only: physical_model_t, model_state_t, model_trajectory_t, &
        integrate_trajectory, predict_accelerations, star_angles, correct_state, turn_between, describe_model_state
    use gracecg_estimation_iteration, only: iteration_t, append_iteration, rms_of
    use gracecg_estimation_linearised_samples, only: filter_problem_t, SHARED, FREQUENCY
    implicit none
    private
    public :: MODEL_FIRST, N_CONSTANTS, ESTIMATED, OFFSET_PLACES, FIRST_FIT
    public :: calibration_filter_t, begin_filter

    !> The parameters of the physical model that are estimated, in their order among the constants
    integer, parameter :: ESTIMATED(39) = [ATTITUDE_ANGLES, RATE, TORQUE, DRIFT, BIAS, FORCE_SHAPES, SCALE_FACTORS, &
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
        !! Of each accelerometer axis before others are searched for, white noise = 1: first the flicker noise
        integer :: noise_states(3) = 0          !! Of the process: those of the flicker noise
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
end module gracecg_estimation_linearisation
