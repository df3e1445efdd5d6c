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
    public :: given_t, nominal_t
    public :: new_problem, linearise_prior, linearise_stars, linearise_accelerations, move_nominal, note_iteration

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

    !> What an estimate begins with and does not change.
    type :: given_t
        type(fitting_data_t) :: data
        !! Preprocessed observations
        type(physical_model_t) :: model
        !! What is fitted
        type(model_state_t) :: guess                        !! Where the a-priori knowledge stands
        real(dp) :: prior_sigma(size(ESTIMATED)) = 1        !! A priori, of the parameters
        real(dp) :: shared_sigma = 1                        !! A priori, of the shared parts
        real(dp) :: white_sigma(3) = 1                      !! White noise of the accelerometer, m/s^2
        real(dp) :: star_sigma(3) = 1                       !! Of the star camera about its axes, rad
        type(gauss_markov_t) :: process(3)
        !! Of each accelerometer axis before others are searched for, white noise = 1: first the flicker noise
        integer :: noise_states(3) = 0                      !! Of the process: those of the flicker noise
    end type given_t

    !> The nominal trajectory.
    type :: nominal_t
        type(model_state_t) :: state
        !! At which it is linearised
        type(model_trajectory_t) :: trajectory
        !! Along the arc, at that state
        real(dp), allocatable :: partials(:, :, :)          !! Of the accelerometer, (ESTIMATED, 3, samples)
        logical :: keeps_history = .false.
        !! Is every correction noted?
        type(iteration_t), allocatable :: history(:)        !! The corrections noted
    end type nominal_t

contains

    !> A problem without numbers, all samples kept.
    subroutine new_problem(data, problem)
        type(fitting_data_t), intent(in) :: data
        type(filter_problem_t), intent(out) :: problem

        problem%m = N_CONSTANTS
        problem%steps = data%steps
        problem%interval = data%interval
        problem%epoch = data%accelerometer_epoch
        problem%star_time = data%stars%time
        associate (samples => size(problem%epoch), stars => size(problem%star_time))
            allocate (problem%prior(N_CONSTANTS + 1, N_CONSTANTS), problem%acceleration(N_CONSTANTS + 1, samples, 3), &
                      problem%star(N_CONSTANTS + 1, 3, stars), source=0.0_dp)
            allocate (problem%kept(samples, 3), problem%star_kept(stars), source=.true.)
        end associate
    end subroutine new_problem

    !> The a-priori knowledge about the nominal trajectory.
    subroutine linearise_prior(given, state, shared_part, problem)
        type(given_t), intent(in) :: given
        type(model_state_t), intent(in) :: state            !! The nominal one
        real(dp), intent(in) :: shared_part(:)              !! A priori, of the constants SHARED
        type(filter_problem_t), intent(inout) :: problem

        real(dp) :: known(N_CONSTANTS), sigma(N_CONSTANTS)
        integer :: i

        known(SHARED) = shared_part
        known(FREQUENCY) = 0
        known(MODEL_FIRST:) = given%guess%value(ESTIMATED) - state%value(ESTIMATED)
        known(MODEL_FIRST:MODEL_FIRST + 2) = turn_between(state%quaternion, given%guess%quaternion)
        sigma(SHARED) = given%shared_sigma
        sigma(FREQUENCY) = FREQUENCY_SIGMA
        sigma(MODEL_FIRST:) = given%prior_sigma
        problem%prior = 0
        do i = 1, N_CONSTANTS
            problem%prior(i, i) = 1/sigma(i)
            problem%prior(N_CONSTANTS + 1, i) = known(i)/sigma(i)
        end do
    end subroutine linearise_prior

    !> Residuals and partials of the star camera, in units of its noise.
    subroutine linearise_stars(given, nominal, problem)
        type(given_t), intent(in) :: given
        type(nominal_t), intent(in) :: nominal
        type(filter_problem_t), intent(inout) :: problem

        real(dp) :: angles(3), partials(size(ESTIMATED), 3)
        integer :: i, j

        associate (stars => given%data%stars)
            do i = 1, size(stars%time)
                call star_angles(given%model, nominal%state, nominal%trajectory, stars%time(i), stars%head(i), &
                                 stars%quaternion(:, i), angles, partials)
                do j = 1, 3
                    problem%star(MODEL_FIRST:N_CONSTANTS, j, i) = partials(:, j)/given%star_sigma(j)
                    problem%star(N_CONSTANTS + 1, j, i) = angles(j)/given%star_sigma(j)
                end do
            end do
        end associate
    end subroutine linearise_stars

    !> Residuals and partials of the accelerometer, in units of its white noise.
    subroutine linearise_accelerations(given, nominal, problem)
        type(given_t), intent(in) :: given
        type(nominal_t), intent(inout) :: nominal
        type(filter_problem_t), intent(inout) :: problem

        real(dp) :: predicted(3, size(problem%epoch))
        integer :: i, axis

        if (.not. allocated(nominal%partials)) allocate (nominal%partials(size(ESTIMATED), 3, size(problem%epoch)))
        call predict_accelerations(given%model, nominal%state, nominal%trajectory, problem%epoch, predicted, &
                                   nominal%partials)
        do axis = 1, 3
            do i = 1, size(problem%epoch)
                problem%acceleration(MODEL_FIRST:N_CONSTANTS, i, axis) = nominal%partials(:, axis, i)/given%white_sigma(axis)
                problem%acceleration(N_CONSTANTS + 1, i, axis) = &
                    (given%data%acceleration(axis, i) - predicted(axis, i))/given%white_sigma(axis)
            end do
        end do
    end subroutine linearise_accelerations

    !> Corrects the nominal state and integrates its trajectory. Fails when a correction is not finite.
    subroutine move_nominal(model, correction, nominal, error)
        type(physical_model_t), intent(in) :: model
        real(dp), intent(in) :: correction(N_CONSTANTS)
        !! Of the state, in the parameters' units
        type(nominal_t), intent(inout) :: nominal
        type(error_t), allocatable, intent(out) :: error

        if (.not. all(abs(correction) <= huge(1.0_dp))) then
            call fail(error, 'sequential: the nominal trajectory diverges; check guess_quaternion and '// &
                      'guess_angular_velocity')
            return
        end if
        call correct_state(model, correction(MODEL_FIRST:), nominal%state)
        call integrate_trajectory(model, nominal%state, nominal%trajectory)
    end subroutine move_nominal

    !> Notes a correction that has been made, with the residuals before it.
    subroutine note_iteration(fit, model, problem, correction, nominal)
        character(*), intent(in) :: fit             !! What is fitted
        type(physical_model_t), intent(in) :: model
        type(filter_problem_t), intent(in) :: problem   !! As it was before
        real(dp), intent(in) :: correction(N_CONSTANTS)     !! Of the constants, SI units
        type(nominal_t), intent(inout) :: nominal       !! After the correction

        type(iteration_t) :: note
        integer :: axis

        if (.not. nominal%keeps_history) return
        note%names = parameter_names(ESTIMATED)
        note%correction = correction(MODEL_FIRST:MODEL_FIRST + size(ESTIMATED) - 1)
        call describe_model_state(model, nominal%state, note)
        note%residual_names = [character(12) :: 'star_x', 'star_y', 'star_z', 'acc_x', 'acc_y', 'acc_z']
        allocate (note%residual_rms(6))
        do axis = 1, 3
            note%residual_rms(axis) = rms_of(pack(problem%star(N_CONSTANTS + 1, axis, :), problem%star_kept))
            note%residual_rms(3 + axis) = rms_of(pack(problem%acceleration(N_CONSTANTS + 1, :, axis), &
                                                      problem%kept(:, axis)))
        end do
        if (fit == FIRST_FIT) then      ! which leaves the accelerometer aside
            note%residual_names = note%residual_names(:3)
            note%residual_rms = note%residual_rms(:3)
        end if
        note%residual_unit = 'sigma'
        call append_iteration(nominal%history, note, fit)
    end subroutine note_iteration
end module gracecg_estimation_linearisation
