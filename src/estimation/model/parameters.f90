!> The parameters of the physical model (gracecg_estimation_physical_model) in one table: name, unit, what
!> they act on, size, and what is known of them before a fit.
!>
!> A new one gets a place and a row here, its effect and its partials in the physical model
!> (`generalised_torque` or `acceleration_partials`), and, if it is known to a standard deviation, a line in
!> `a_priori_sigmas`.
module gracecg_estimation_parameters
    use gracecg_base_kinds, only: dp
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_run_information, only: JOINED_COUNT
    implicit none
    private
    public :: PARAMETERS, ESTIMABLE, PARAMETER_NAMES, PARAMETER_UNITS, ALWAYS_ESTIMATED
    public :: ATTITUDE_ANGLES, RATE, TORQUE, OFFSET, DRIFT, BIAS, SCALE_FACTORS, ROD_GAIN, FIELD_BIAS
    public :: DRAG_CURVATURE, WAVE_SINE, WAVE_COSINE, WAVE_FREQUENCY, INERTIA, TORQUE_CHANGE
    public :: ROD_GAINS, ROD_TURNS, ROD_DELAYS, ROD_FREQUENCIES, FIELD_TURN, FIELD_DELAY
    public :: ACCELEROMETER_DELAYS, ACCELEROMETER_TURN, MOUNTING_1, MOUNTING_2, STAR_CAMERA_DELAY
    public :: ALL_RODS_DELAY, ALL_RODS_FREQUENCY, FORCE_BENDS, AIRFLOW_TURN, SIDE_FORCE, FORCE_JUMP, FIELD_SCALES, &
        FIELD_SHEARS
    public :: ROD_SWAPS, FIELD_SWAPS, ACCELEROMETER_SWAPS
    public :: BEND_AXIS, BEND_DEGREE, FORCE_SHAPES, JOINED
    public :: is_rotational, is_tested_only, typical_sizes, loose_sigmas, a_priori_sigmas

    integer, parameter :: PARAMETERS = 106    !! Number of all parameters
    integer, parameter :: ESTIMABLE = 57    !! The first so many can be estimated; the others are tested only
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
    integer, parameter :: FORCE_BENDS(12) = [39, 40, 41, 42, 43, 44, 45, 46, 47, 48, 49, 50]
    !! Of forces that are no straight line, besides: Legendre's polynomials over the arc along body axes, by BEND_AXIS
    !! and BEND_DEGREE
    integer, parameter :: AIRFLOW_TURN(2) = [51, 52]        !! Of the airflow towards y and z, by the wind
    integer, parameter :: SIDE_FORCE(2) = [53, 54]          !! Of the drag along x by the airflow's angles towards y and z
    integer, parameter :: FORCE_JUMP(3) = [55, 56, 57]      !! Of the acceleration, from one sample on
    ! What follows is never estimated with the rest, but tested: partials at the value 0 are all there is of it
    integer, parameter :: ROD_GAINS(3) = [58, 59, 60]       !! Of the rods along x, y, z: gain over that believed, minus 1
    integer, parameter :: ROD_TURNS(6) = [61, 62, 63, 64, 65, 66]   !! As torque_rods_t has its misalignment
    integer, parameter :: ROD_DELAYS(3) = [67, 68, 69]      !! From command to moment, of each rod
    integer, parameter :: ROD_FREQUENCIES(3) = [70, 71, 72] !! Of all activations of a rod
    integer, parameter :: FIELD_TURN(3) = [73, 74, 75]      !! Rotation vector from the magnetometer's samples to the field
    integer, parameter :: FIELD_DELAY = 76                  !! Of the magnetometer's time tags
    integer, parameter :: ACCELEROMETER_DELAYS(3) = [77, 78, 79]    !! Of the time tags of each axis
    integer, parameter :: ACCELEROMETER_TURN(3) = [80, 81, 82]
    !! Rotation vector from the acceleration to the accelerometer's samples
    integer, parameter :: MOUNTING_1(3) = [83, 84, 85], MOUNTING_2(3) = [86, 87, 88]
    !! Rotation vector from the body to what the samples of a star-camera head say of it, body axes
    integer, parameter :: STAR_CAMERA_DELAY = 89            !! Of the star camera's time tags
    integer, parameter :: ALL_RODS_DELAY = 90, ALL_RODS_FREQUENCY = 91  !! As ROD_DELAYS, ROD_FREQUENCIES, of all rods
    integer, parameter :: FIELD_SCALES(3) = [92, 93, 94]    !! Scale factors of the magnetometer minus 1
    integer, parameter :: FIELD_SHEARS(3) = [95, 96, 97]
    !! Parts of one component of the field in another and as much back: x and y, y and z, z and x
    ! 1 if two axes are interchanged, x and y, y and z, z and x; no other value has a meaning
    integer, parameter :: ROD_SWAPS(3) = [98, 99, 100]       !! The commands of two rods
    integer, parameter :: FIELD_SWAPS(3) = [101, 102, 103]    !! Two axes of the magnetometer
    integer, parameter :: ACCELEROMETER_SWAPS(3) = [104, 105, 106]  !! Two axes of the accelerometer
    integer, parameter :: FORCE_SHAPES(15) = [DRAG_CURVATURE, FORCE_BENDS, SIDE_FORCE]
    !! Of forces that are no straight line in time
    !> Axes and degrees of FORCE_BENDS
    integer, parameter :: BEND_AXIS(12) = [1, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3]
    integer, parameter :: BEND_DEGREE(12) = [3, 4, 5, 6, 2, 3, 4, 5, 6, 2, 3, 4]    !! Of the polynomials
    real(dp), parameter :: USUAL_ARC = 60           !! Of the cases of CSR-TM-00-01, s
    real(dp), parameter :: USUAL_BEND = 5e-11_dp
    !! Standard deviation of each, m/s^2. Fitted, as USUAL_SIDE_FORCE is, to the six cases of CSR-TM-00-01: with these two
    !! the mean normalised square of the errors of `optimal` is near 3 there, and its RMS error grows by some
    !! per cent (docs/validation.md). The forces themselves bend by up to 4e-10 m/s^2, most of which the offset does not feel
    real(dp), parameter :: USUAL_WIND = 0.013_dp
    !! Standard deviation of AIRFLOW_TURN, rad: 100 m/s RMS across polar orbits (data/wind_hwm93_1989-01-02.txt)
    real(dp), parameter :: USUAL_SIDE_FORCE = 7e-7_dp
    !! Standard deviation of each of SIDE_FORCE, m/s^2/rad: fitted as USUAL_BEND; some 2e-6 acts in case 1, less in the others
    integer, parameter :: ALWAYS_ESTIMATED(18) = [ATTITUDE_ANGLES, RATE, TORQUE, OFFSET, DRIFT, BIAS]
    !! Parameters of every fit; `optimal` adds to them

    !> Parameters that several runs can have in common: the offset first, then by SHARED_GROUPS
    integer, parameter :: JOINED(JOINED_COUNT) = [OFFSET, SCALE_FACTORS, ROD_GAIN, FIELD_BIAS, INERTIA]

    !> What a parameter acts on
    integer, parameter :: ROTATION = 1, ACCELERATION = 2, ATTITUDE = 3

    !> A row of the table: what the parameters of a group have in common.
    type :: group_t
        character(8) :: unit
        integer :: acts_on          !! ROTATION (the accelerometer sees it, too), ACCELERATION or ATTITUDE (the star camera alone)
        real(dp) :: size            !! Typical, for convergence
        logical :: over_arc         !! `size` is what the parameter makes in the whole arc: divided by its length
        real(dp) :: loose           !! A standard deviation so large that it weighs nothing
    end type group_t

    logical, parameter :: YES = .true., NO = .false.
    !> In the order of the places
    type(group_t), parameter :: TABLE(29) = [ &
        group_t('rad', ROTATION, 1e-3_dp, NO, 1.0_dp), &            ! ATTITUDE_ANGLES
        group_t('rad/s', ROTATION, 1e-3_dp, NO, 0.1_dp), &          ! RATE
        group_t('N m', ROTATION, 1e-4_dp, NO, 0.01_dp), &           ! TORQUE
        group_t('m', ACCELERATION, 1e-3_dp, NO, 1.0_dp), &          ! OFFSET
        group_t('m/s^3', ACCELERATION, 1e-6_dp, YES, 1.0_dp), &     ! DRIFT: likewise
        group_t('m/s^2', ACCELERATION, 1e-6_dp, NO, 10.0_dp), &     ! BIAS: it would pull the scale factor
        group_t('1', ACCELERATION, 1.0_dp, NO, 1.0_dp), &           ! SCALE_FACTORS
        group_t('1', ROTATION, 1.0_dp, NO, 1.0_dp), &               ! ROD_GAIN
        group_t('T', ROTATION, 1e-7_dp, NO, 1e-3_dp), &             ! FIELD_BIAS
        group_t('m/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &     ! DRAG_CURVATURE
        group_t('m/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &     ! WAVE_SINE
        group_t('m/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &     ! WAVE_COSINE
        group_t('Hz', ACCELERATION, 1e-1_dp, YES, 1.0_dp), &        ! WAVE_FREQUENCY
        group_t('kg m^2', ROTATION, 1.0_dp, NO, 1e3_dp), &          ! INERTIA
        group_t('N m', ROTATION, 1.0_dp, NO, 0.01_dp), &            ! TORQUE_CHANGE
        group_t('1', ROTATION, 1.0_dp, NO, 1.0_dp), &               ! ROD_GAINS
        group_t('rad', ROTATION, 1.0_dp, NO, 1.0_dp), &             ! ROD_TURNS
        group_t('s', ROTATION, 1.0_dp, NO, 10.0_dp), &              ! ROD_DELAYS
        group_t('Hz', ROTATION, 1.0_dp, NO, 1.0_dp), &              ! ROD_FREQUENCIES
        group_t('rad', ROTATION, 1.0_dp, NO, 1.0_dp), &             ! FIELD_TURN
        group_t('s', ROTATION, 1.0_dp, NO, 100.0_dp), &             ! FIELD_DELAY
        group_t('s', ACCELERATION, 1.0_dp, NO, 10.0_dp), &          ! ACCELEROMETER_DELAYS
        group_t('rad', ACCELERATION, 1.0_dp, NO, 1.0_dp), &         ! ACCELEROMETER_TURN
        group_t('rad', ATTITUDE, 1.0_dp, NO, 1.0_dp), &             ! MOUNTING_1, MOUNTING_2
        group_t('s', ATTITUDE, 1.0_dp, NO, 10.0_dp), &              ! STAR_CAMERA_DELAY
        group_t('m/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &     ! FORCE_BENDS
        group_t('rad', ACCELERATION, 1e-1_dp, NO, 1.0_dp), &        ! AIRFLOW_TURN
        group_t('m/s^2', ACCELERATION, 1e-4_dp, NO, 1e-2_dp), &     ! SIDE_FORCE
        group_t('m/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp)]       ! FORCE_JUMP
    !> The row of each parameter
    integer, parameter :: GROUP(PARAMETERS) = [1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4, 5, 5, 5, 6, 6, 6, 7, 7, 7, 8, &
                                               9, 9, 9, 10, 11, 12, 13, 14, 14, 14, 14, 14, 14, 15, 15, 15, &
                                               26, 26, 26, 26, 26, 26, 26, 26, 26, 26, 26, 26, 27, 27, 28, 28, 29, 29, 29, &
                                               16, 16, 16, 17, 17, 17, 17, 17, 17, 18, 18, 18, 19, 19, 19, &
                                               20, 20, 20, 21, 22, 22, 22, 23, 23, 23, 24, 24, 24, 24, 24, 24, 25, 18, 19, &
                                               16, 16, 16, 16, 16, 16, 16, 16, 16, 16, 16, 16, 7, 7, 7]

    character(12), parameter :: PARAMETER_NAMES(PARAMETERS) = [character(12) :: &
        'zeta_x', 'zeta_y', 'zeta_z', 'omega_x', 'omega_y', 'omega_z', 'torque_x', 'torque_y', 'torque_z', &
        'd_x', 'd_y', 'd_z', 'alpha_x', 'alpha_y', 'alpha_z', 'beta_x', 'beta_y', 'beta_z', &
        'scale_x', 'scale_y', 'scale_z', 'rod_gain', 'field_bias_x', 'field_bias_y', 'field_bias_z', &
        'drag_curve', 'wave_sin', 'wave_cos', 'wave_freq', &
        'J_xx', 'J_yy', 'J_zz', 'J_xy', 'J_yz', 'J_zx', 'change_x', 'change_y', 'change_z', &
        'bend_x3', 'bend_x4', 'bend_x5', 'bend_x6', 'bend_y2', 'bend_y3', 'bend_y4', 'bend_y5', 'bend_y6', &
        'bend_z2', 'bend_z3', 'bend_z4', 'airflow_y', 'airflow_z', 'side_y', 'side_z', &
        'jump_x', 'jump_y', 'jump_z', &
        'rod_gain_x', 'rod_gain_y', 'rod_gain_z', 'rod_x_turn_y', 'rod_x_turn_z', 'rod_y_turn_z', &
        'rod_y_turn_x', 'rod_z_turn_x', 'rod_z_turn_y', 'rod_delay_x', 'rod_delay_y', 'rod_delay_z', &
        'rod_freq_x', 'rod_freq_y', 'rod_freq_z', 'field_turn_x', 'field_turn_y', 'field_turn_z', 'field_delay', &
        'acc_delay_x', 'acc_delay_y', 'acc_delay_z', 'acc_turn_x', 'acc_turn_y', 'acc_turn_z', &
        'head1_turn_x', 'head1_turn_y', 'head1_turn_z', 'head2_turn_x', 'head2_turn_y', 'head2_turn_z', &
        'star_delay', 'rod_delay', 'rod_freq', &
        'field_scal_x', 'field_scal_y', 'field_scal_z', 'field_sh_xy', 'field_sh_yz', 'field_sh_zx', &
        'rod_swap_xy', 'rod_swap_yz', 'rod_swap_zx', 'field_swp_xy', 'field_swp_yz', 'field_swp_zx', &
        'acc_swap_xy', 'acc_swap_yz', 'acc_swap_zx']
    !! By place
    character(8), parameter :: PARAMETER_UNITS(PARAMETERS) = TABLE(GROUP)%unit    !! By place

contains

    !> Does a parameter act on attitude and angular velocity?
    elemental logical function is_rotational(parameter)
        integer, intent(in) :: parameter        !! Its place

        is_rotational = TABLE(GROUP(parameter))%acts_on == ROTATION
    end function is_rotational

    !> Is a parameter one of those that are tested, not estimated?
    elemental logical function is_tested_only(parameter)
        integer, intent(in) :: parameter        !! Its place

        is_tested_only = parameter > ESTIMABLE
    end function is_tested_only

    !> Sizes of parameters, for convergence.
    pure function typical_sizes(estimated, duration) result(sizes)
        integer, intent(in) :: estimated(:)         !! Places
        real(dp), intent(in) :: duration            !! Of the arc, s
        real(dp) :: sizes(size(estimated))

        sizes = TABLE(GROUP(estimated))%size/merge(duration, 1.0_dp, TABLE(GROUP(estimated))%over_arc)
    end function typical_sizes

    !> Standard deviations so large that they weigh nothing.
    pure function loose_sigmas(estimated) result(sigmas)
        integer, intent(in) :: estimated(:)         !! Places
        real(dp) :: sigmas(size(estimated))

        sigmas = TABLE(GROUP(estimated))%loose
    end function loose_sigmas

    !> How well the operator knows the parameters beforehand: standard deviations by place, 0 where nothing
    !> is known. They are a-priori knowledge of what is estimated, and limits of what is only considered.
    pure function a_priori_sigmas(knowledge) result(sigmas)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp) :: sigmas(PARAMETERS)

        integer :: i

        sigmas = 0
        sigmas(SCALE_FACTORS) = knowledge%a_priori%aged_scale_sigmas()
        sigmas(ROD_GAIN) = knowledge%a_priori%sigma_rod_gain
        sigmas(FIELD_BIAS) = knowledge%a_priori%sigma_magnetometer_bias
        sigmas(INERTIA) = knowledge%a_priori%sigma_inertia*minval([(knowledge%inertia(i, i), i=1, 3)])
        sigmas(TORQUE_CHANGE) = knowledge%a_priori%sigma_torque
        sigmas(FORCE_BENDS) = USUAL_BEND*max(1.0_dp, knowledge%duration/USUAL_ARC)**BEND_DEGREE
        sigmas(AIRFLOW_TURN) = USUAL_WIND
        sigmas(SIDE_FORCE) = USUAL_SIDE_FORCE
    end function a_priori_sigmas
end module gracecg_estimation_parameters
