!> The result of an estimator, the same for all of them.
module gracecg_estimation_solution
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: string_t
    use gracecg_estimation_belief_report, only: belief_report_t
    use gracecg_base_quaternion, only: rate_matrix
    use gracecg_estimation_iteration, only: iteration_t
    use gracecg_estimation_run_information, only: run_information_t
    implicit none
    private
    public :: solution_t, estimated_parameter_t, running_estimate_t, store_offset, has_attitude, quaternion_sigmas, state_sigmas
    public :: STATE, STATE_NAMES, STATE_UNITS, STATE_OFFSET, STATE_DRIFT, STATE_BIAS, STATE_RATE, STATE_ATTITUDE

    integer, parameter :: STATE = 15    !! Parameters that every estimator has
    !> Their places in the covariance of the state
    integer, parameter :: STATE_OFFSET(3) = [1, 2, 3], STATE_DRIFT(3) = [4, 5, 6], STATE_BIAS(3) = [7, 8, 9], &
                          STATE_RATE(3) = [10, 11, 12], STATE_ATTITUDE(3) = [13, 14, 15]
    !> Their names and units; zeta are small angles about the body axes that turn the attitude at the epoch
    character(12), parameter :: STATE_NAMES(STATE) = [character(12) :: 'd_x', 'd_y', 'd_z', 'alpha_x', 'alpha_y', &
        'alpha_z', 'beta_x', 'beta_y', 'beta_z', 'omega_x', 'omega_y', 'omega_z', 'zeta_x', 'zeta_y', 'zeta_z']
    character(6), parameter :: STATE_UNITS(STATE) = [character(6) :: 'm', 'm', 'm', 'm/s^3', 'm/s^3', 'm/s^3', &
        'm/s^2', 'm/s^2', 'm/s^2', 'rad/s', 'rad/s', 'rad/s', 'rad', 'rad', 'rad']    !! Of STATE_NAMES

    !> A parameter beside the offset.
    type :: estimated_parameter_t
        character(12) :: name = ''      !! As gracecg_observations_parameters names it
        real(dp) :: value = 0           !! SI units
        real(dp) :: sigma = 0           !! Standard deviation, SI units
        character(8) :: unit = ''       !! 1 for a pure number
    end type estimated_parameter_t

    !> The estimate as it stood at every epoch, from the samples until then.
    type :: running_estimate_t
        real(dp), allocatable :: time(:)                    !! (epochs), s
        real(dp), allocatable :: offset(:, :)               !! (3, epochs), m
        real(dp), allocatable :: sigma(:, :)                !! (3, epochs), m
        integer, allocatable :: edited_accelerometer(:)     !! (epochs), values edited until then
        integer, allocatable :: edited_star_camera(:)       !! (epochs), samples edited until then
    end type running_estimate_t

    !> Offset and covariance, and what else the fit has found.
    type :: solution_t
        character(:), allocatable :: algorithm  !! Name as on the command line
        real(dp) :: offset(3) = 0               !! d, from COM to proof-mass centre, body axes, m
        real(dp) :: covariance(3, 3) = 0
        !! Of the offset under the noise of accelerometer and star camera, m^2. Of the report's estimators:
        !! what the weights make of the true noise spectra, not the inverse of the normal matrix; of
        !! `optimal`, whose weights are those of the noise, that inverse. Without systematic errors and
        !! the noise of the magnetometer, which is smaller by far.
        real(dp) :: state_covariance(STATE, STATE) = 0
        !! Of d, alpha, beta, omega and zeta, by STATE_NAMES, SI units: of the same kind as `covariance`, which is
        !! its first block; 0 where that is not asked for
        real(dp) :: drift(3) = 0                !! alpha of (4-17), m/s^3
        real(dp) :: bias(3) = 0                 !! beta of (4-17), m/s^2
        real(dp) :: quaternion(4) = 0           !! Attitude at the epoch, inertial to body; 0: not estimated
        real(dp) :: angular_velocity(3) = 0     !! At the epoch, rad/s
        integer :: iterations = 0               !! Of the batch processor, in its non-linear part
        logical :: converged = .false.          !! Of the batch processor, in its non-linear part
        real(dp) :: condition = 0
        !! Of the normal matrix with unit diagonal: of the offset's in ASSEST, of the whole one in
        !! ASCFEST and ASCREST
        real(dp) :: residual_rms(3) = 0         !! Of the accelerometer, m/s^2
        type(estimated_parameter_t), allocatable :: parameters(:)
        !! Of `optimal` and `sequential`: unknown torque, and what the settings ask for. Not allocated by
        !! the report's four
        real(dp) :: noise_level(3) = 0          !! Accelerometer, (3-2): what `optimal` and `sequential` weighted with
        real(dp) :: noise_corner(3) = 0         !! Hz
        real(dp) :: star_camera_sigma(3) = 0    !! About camera x, y, boresight, rad
        real(dp) :: variance_factor = 0
        !! Of `optimal` and `sequential`: weighted squares of the residuals over their redundancy; 1 if model and noise hold
        real(dp) :: misfit = 0
        !! Of `optimal`: weighted squares of the residuals, each sample left out counted with its limit; 0 where the
        !! noise is estimated
        integer :: edited(2) = 0                !! Samples left out: accelerometer (by axis), star camera
        type(string_t), allocatable :: warnings(:)
        !! What was wrong with the observations and has been bridged, and what casts doubt on the fit
        type(belief_report_t), allocatable :: beliefs
        !! What the data say of the operator's beliefs; allocated where options%covariance asks for checks
        type(iteration_t), allocatable :: history(:)
        !! Every iteration, if the options ask for it
        type(run_information_t), allocatable :: information
        !! For a joint estimate of several runs: of `optimal`, if it was asked for its problem
        type(running_estimate_t), allocatable :: running
        !! The estimate on the way, of an estimator that filters
    end type solution_t

contains

    !> Puts the accelerometer's part of an estimate into a solution.
    pure subroutine store_offset(state, residuals, solution)
        real(dp), intent(in) :: state(9)            !! d (m), alpha (m/s^3), beta (m/s^2)
        real(dp), intent(in) :: residuals(:)        !! x, y, z of each sample in turn, m/s^2
        type(solution_t), intent(inout) :: solution

        integer :: axis

        solution%offset = state(1:3)
        solution%drift = state(4:6)
        solution%bias = state(7:9)
        do axis = 1, 3
            solution%residual_rms(axis) = norm2(residuals(axis::3))/sqrt(size(residuals)/3.0_dp)
        end do
    end subroutine store_offset

    !> Standard deviations of the state, by STATE_NAMES; 0 where the covariance was not asked for.
    pure function state_sigmas(solution) result(sigmas)
        type(solution_t), intent(in) :: solution
        real(dp) :: sigmas(STATE)           !! SI units

        integer :: i

        sigmas = [(sqrt(max(0.0_dp, solution%state_covariance(i, i))), i=1, STATE)]
    end function state_sigmas

    !> True when the attitude was estimated, and not the angular velocity taken from elsewhere.
    pure logical function has_attitude(solution)
        type(solution_t), intent(in) :: solution

        has_attitude = any(abs(solution%quaternion) > 0)
    end function has_attitude

    !> Standard deviations of q1 to q4: by dq = Omega(zeta) q/2 from those of the angles zeta, with their
    !> correlations.
    pure function quaternion_sigmas(solution) result(sigmas)
        type(solution_t), intent(in) :: solution
        real(dp) :: sigmas(4)

        real(dp) :: partials(4, 3), angle(3)
        integer :: i

        do i = 1, 3
            angle = 0
            angle(i) = 1
            partials(:, i) = matmul(rate_matrix(angle), solution%quaternion)/2
        end do
        associate (p => solution%state_covariance(13:15, 13:15))     ! STATE_ATTITUDE
            sigmas = [(sqrt(max(0.0_dp, dot_product(partials(i, :), matmul(p, partials(i, :))))), i=1, 4)]
        end associate
    end function quaternion_sigmas
end module gracecg_estimation_solution
