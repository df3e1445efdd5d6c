!> The parameters of the physical model (gracecg_estimation_physical_model) in one table: name, unit, what
!> they act on, size, and what is known of them before a fit.
!>
!> A new one gets a place and a row here, its effect and its partials in the physical model
!> (`generalised_torque` or `acceleration_partials`), and, if it is known to a standard deviation, a line in
!> `a_priori_sigmas`.
module gracecg_estimation_parameters
    use gracecg_base_kinds, only: dp
    use gracecg_observations_knowledge, only: operator_knowledge_t
    implicit none
    private
    public :: PARAMETERS, PARAMETER_NAMES, PARAMETER_UNITS, ALWAYS_ESTIMATED
    public :: ATTITUDE_ANGLES, RATE, TORQUE, OFFSET, DRIFT, BIAS, SCALE_FACTORS, ROD_GAIN, FIELD_BIAS
    public :: DRAG_CURVATURE, WAVE_SINE, WAVE_COSINE, WAVE_FREQUENCY, INERTIA, TORQUE_CHANGE
    public :: is_rotational, typical_sizes, loose_sigmas, a_priori_sigmas

    integer, parameter :: PARAMETERS = 38    !! Number of all parameters
    !> Places of the parameters, as index vectors
    integer, parameter :: ATTITUDE_ANGLES(3) = [1, 2, 3]    !! zeta at the epoch
    integer, parameter :: RATE(3) = [4, 5, 6]               !! omega at the epoch
    integer, parameter :: TORQUE(3) = [7, 8, 9]             !! T
    integer, parameter :: OFFSET(3) = [10, 11, 12]          !! d
    integer, parameter :: DRIFT(3) = [13, 14, 15]           !! alpha
    integer, parameter :: BIAS(3) = [16, 17, 18]            !! beta
    integer, parameter :: SCALE_FACTORS(3) = [19, 20, 21]   !! s: scale factor minus 1
    integer, parameter :: ROD_GAIN = 22                     !! g: gain minus 1
    integer, parameter :: FIELD_BIAS(3) = [23, 24, 25]      !! b
    integer, parameter :: DRAG_CURVATURE = 26               !! gamma
    integer, parameter :: WAVE_SINE = 27, WAVE_COSINE = 28  !! Amplitudes of the density wave
    integer, parameter :: WAVE_FREQUENCY = 29               !! Error of the wave's frequency
    integer, parameter :: INERTIA(6) = [30, 31, 32, 33, 34, 35] !! Errors of J's xx, yy, zz, xy, yz, zx
    integer, parameter :: TORQUE_CHANGE(3) = [36, 37, 38]   !! T'
    integer, parameter :: ALWAYS_ESTIMATED(18) = [ATTITUDE_ANGLES, RATE, TORQUE, OFFSET, DRIFT, BIAS]
    !! Parameters of every fit; `optimal` adds to them

    !> What a parameter acts on
    integer, parameter :: ROTATION = 1, ACCELERATION = 2

    !> A row of the table.
    type :: parameter_t
        character(12) :: name
        character(8) :: unit
        integer :: acts_on          !! ROTATION (the accelerometer sees it, too) or ACCELERATION
        real(dp) :: size            !! Typical, for convergence; times the length of the arc if `over_arc`
        logical :: over_arc         !! `size` is what the parameter makes in the whole arc
        real(dp) :: loose           !! A standard deviation so large that it weighs nothing
    end type parameter_t

    logical, parameter :: YES = .true., NO = .false.
    !> In the order of the places
    type(parameter_t), parameter :: TABLE(PARAMETERS) = [ &
        parameter_t('zeta_x', 'rad', ROTATION, 1e-3_dp, NO, 1.0_dp), &
        parameter_t('zeta_y', 'rad', ROTATION, 1e-3_dp, NO, 1.0_dp), &
        parameter_t('zeta_z', 'rad', ROTATION, 1e-3_dp, NO, 1.0_dp), &
        parameter_t('omega_x', 'rad/s', ROTATION, 1e-3_dp, NO, 0.1_dp), &
        parameter_t('omega_y', 'rad/s', ROTATION, 1e-3_dp, NO, 0.1_dp), &
        parameter_t('omega_z', 'rad/s', ROTATION, 1e-3_dp, NO, 0.1_dp), &
        parameter_t('torque_x', 'N m', ROTATION, 1e-4_dp, NO, 0.01_dp), &
        parameter_t('torque_y', 'N m', ROTATION, 1e-4_dp, NO, 0.01_dp), &
        parameter_t('torque_z', 'N m', ROTATION, 1e-4_dp, NO, 0.01_dp), &
        parameter_t('d_x', 'm', ACCELERATION, 1e-3_dp, NO, 1.0_dp), &
        parameter_t('d_y', 'm', ACCELERATION, 1e-3_dp, NO, 1.0_dp), &
        parameter_t('d_z', 'm', ACCELERATION, 1e-3_dp, NO, 1.0_dp), &
        parameter_t('alpha_x', 'm/s^3', ACCELERATION, 1e-6_dp, YES, 1e-4_dp), &
        parameter_t('alpha_y', 'm/s^3', ACCELERATION, 1e-6_dp, YES, 1e-4_dp), &
        parameter_t('alpha_z', 'm/s^3', ACCELERATION, 1e-6_dp, YES, 1e-4_dp), &
        parameter_t('beta_x', 'm/s^2', ACCELERATION, 1e-6_dp, NO, 1e-3_dp), &
        parameter_t('beta_y', 'm/s^2', ACCELERATION, 1e-6_dp, NO, 1e-3_dp), &
        parameter_t('beta_z', 'm/s^2', ACCELERATION, 1e-6_dp, NO, 1e-3_dp), &
        parameter_t('scale_x', '1', ACCELERATION, 1.0_dp, NO, 1.0_dp), &
        parameter_t('scale_y', '1', ACCELERATION, 1.0_dp, NO, 1.0_dp), &
        parameter_t('scale_z', '1', ACCELERATION, 1.0_dp, NO, 1.0_dp), &
        parameter_t('rod_gain', '1', ROTATION, 1.0_dp, NO, 1.0_dp), &
        parameter_t('field_bias_x', 'T', ROTATION, 1e-7_dp, NO, 1e-3_dp), &
        parameter_t('field_bias_y', 'T', ROTATION, 1e-7_dp, NO, 1e-3_dp), &
        parameter_t('field_bias_z', 'T', ROTATION, 1e-7_dp, NO, 1e-3_dp), &
        parameter_t('drag_curve', 'm/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &
        parameter_t('wave_sin', 'm/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &
        parameter_t('wave_cos', 'm/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &
        parameter_t('wave_freq', 'Hz', ACCELERATION, 1e-1_dp, YES, 1.0_dp), &
        parameter_t('J_xx', 'kg m^2', ROTATION, 1.0_dp, NO, 1e3_dp), &
        parameter_t('J_yy', 'kg m^2', ROTATION, 1.0_dp, NO, 1e3_dp), &
        parameter_t('J_zz', 'kg m^2', ROTATION, 1.0_dp, NO, 1e3_dp), &
        parameter_t('J_xy', 'kg m^2', ROTATION, 1.0_dp, NO, 1e3_dp), &
        parameter_t('J_yz', 'kg m^2', ROTATION, 1.0_dp, NO, 1e3_dp), &
        parameter_t('J_zx', 'kg m^2', ROTATION, 1.0_dp, NO, 1e3_dp), &
        parameter_t('change_x', 'N m', ROTATION, 1.0_dp, NO, 0.01_dp), &
        parameter_t('change_y', 'N m', ROTATION, 1.0_dp, NO, 0.01_dp), &
        parameter_t('change_z', 'N m', ROTATION, 1.0_dp, NO, 0.01_dp)]

    character(12), parameter :: PARAMETER_NAMES(PARAMETERS) = TABLE%name   !! By place
    character(8), parameter :: PARAMETER_UNITS(PARAMETERS) = TABLE%unit    !! By place

contains

    !> Does a parameter act on attitude and angular velocity?
    elemental logical function is_rotational(parameter)
        integer, intent(in) :: parameter        !! Its place

        is_rotational = TABLE(parameter)%acts_on == ROTATION
    end function is_rotational

    !> Sizes of parameters, for convergence.
    pure function typical_sizes(estimated, duration) result(sizes)
        integer, intent(in) :: estimated(:)         !! Places
        real(dp), intent(in) :: duration            !! Of the arc, s
        real(dp) :: sizes(size(estimated))

        sizes = TABLE(estimated)%size/merge(duration, 1.0_dp, TABLE(estimated)%over_arc)
    end function typical_sizes

    !> Standard deviations so large that they weigh nothing.
    pure function loose_sigmas(estimated) result(sigmas)
        integer, intent(in) :: estimated(:)         !! Places
        real(dp) :: sigmas(size(estimated))

        sigmas = TABLE(estimated)%loose
    end function loose_sigmas

    !> How well the operator knows the parameters beforehand: standard deviations by place, 0 where nothing
    !> is known. They are a-priori knowledge of what is estimated, and limits of what is only considered.
    pure function a_priori_sigmas(knowledge) result(sigmas)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp) :: sigmas(PARAMETERS)

        integer :: i

        sigmas = 0
        sigmas(SCALE_FACTORS) = knowledge%a_priori%sigma_scale_factors
        sigmas(ROD_GAIN) = knowledge%a_priori%sigma_rod_gain
        sigmas(FIELD_BIAS) = knowledge%a_priori%sigma_magnetometer_bias
        sigmas(INERTIA) = knowledge%a_priori%sigma_inertia*minval([(knowledge%inertia(i, i), i=1, 3)])
        sigmas(TORQUE_CHANGE) = knowledge%a_priori%sigma_torque
    end function a_priori_sigmas
end module gracecg_estimation_parameters
