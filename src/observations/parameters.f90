!> What can be estimated, and believed: every parameter of the physical model in one table.
!>
!> A row of KINDS says of some parameters that belong together their names, unit, what they act on, size, and, if an
!> operator believes something of them, words. A new kind is a row, the constant of its places below the table, and its
!> partial: of the rotation in gracecg_estimation_model_rotation or gracecg_estimation_torque_shapes, of what instruments show
!> in gracecg_estimation_shown_samples.
!>
!> A parameter is told by its place, 1 to PARAMETERS, its kind by the first place of the row; its value is the error of what is
!> believed, so that 0 is the belief.
module gracecg_observations_parameters
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, NANOTESLA
    implicit none
    private
    public :: find_parameters, parameter_names, belief_subject, typical_sizes

    !> What a parameter acts on
    enum, bind(c)
        enumerator :: ROTATION = 1  !! Of the satellite: the accelerometer sees it, too
        enumerator :: TORQUE_SHAPE  !! The same, by a torque in proportion
        enumerator :: FIELD_SHAPE   !! The same, by a change of the field in proportion
        enumerator :: ACCELERATION  !! What the accelerometer shows
        enumerator :: INSTRUMENT    !! The same, in proportion
        enumerator :: ATTITUDE      !! What the star camera shows, alone, in proportion
        enumerator :: CHANNELS      !! What angular channels of the accelerometer, or contrasts of several, show, alone
    end enum

    !> A row of the table: what parameters of one kind have in common.
    type :: parameter_kind_t
        integer :: count                    !! How many there are
        character(12) :: stem               !! Of their names
        character(56) :: members            !! Ends of their names, separated by blanks; '': the name has none
        character(8) :: unit                !! Of the estimates, SI
        integer :: acts_on                  !! ROTATION, ..., CHANNELS
        real(dp) :: size                    !! Typical, for convergence
        real(dp) :: loose                   !! A standard deviation so large that it weighs nothing
        character(36) :: subject = ''       !! In words, @ stands for the member; '': nobody believes anything of it
        character(72) :: members_in_words = ''  !! Separated by commas; '': `members`
        character(8) :: shown_unit = ''     !! In which it is shown; '': a ratio
        real(dp) :: shown_size = 1          !! Of that unit in SI units
        real(dp) :: largest = 1             !! Wrong value that is conceivable, in that unit
        logical :: over_arc = .false.       !! `size` is what it makes in the whole arc: divided by its length
        logical :: tested = .true.          !! Whether fits test what is believed of it
    end type parameter_kind_t

    character(*), parameter :: XYZ = 'x y z', PAIRS = 'xy yz zx', PAIRS_IN_WORDS = 'x and y,y and z,z and x'
    !> Elements of a matrix: the axis that shows it, and the rod or axis that makes it
    character(*), parameter :: BY_ROD = 'xx xy xz yx yy yz zx zy zz'
    character(*), parameter :: BY_CONTRAST = 'x1 y1 z1 x2 y2 z2'    !! Axis and contrast
    character(*), parameter :: BY_ROD_IN_WORDS = 'x by x,x by y,x by z,y by x,y by y,y by z,z by x,z by y,z by z'
    real(dp), parameter :: LATE = 5     !! The longest conceivable delay, s

    !> All kinds of parameter, in the order of their places
    type(parameter_kind_t), parameter :: KINDS(*) = [ &
        parameter_kind_t(3, 'zeta_', XYZ, 'rad', ROTATION, 1e-3_dp, 1.0_dp), &
        parameter_kind_t(3, 'omega_', XYZ, 'rad/s', ROTATION, 1e-3_dp, 0.1_dp), &
        parameter_kind_t(3, 'torque_', XYZ, 'N m', ROTATION, 1e-4_dp, 0.01_dp), &
        parameter_kind_t(3, 'd_', XYZ, 'm', ACCELERATION, 1e-3_dp, 1.0_dp), &
        parameter_kind_t(3, 'alpha_', XYZ, 'm/s^3', ACCELERATION, 1e-6_dp, 1.0_dp, over_arc=.true.), &
        parameter_kind_t(3, 'beta_', XYZ, 'm/s^2', ACCELERATION, 1e-6_dp, 10.0_dp), &   ! it would pull the scale factor
        parameter_kind_t(1, 'drag_curve', '', 'm/s^2', ACCELERATION, 1e-8_dp, 1e-6_dp), &
        parameter_kind_t(1, 'wave_sin', '', 'm/s^2', ACCELERATION, 1e-8_dp, 1e-6_dp), &
        parameter_kind_t(1, 'wave_cos', '', 'm/s^2', ACCELERATION, 1e-8_dp, 1e-6_dp), &
        parameter_kind_t(1, 'wave_freq', '', 'Hz', ACCELERATION, 1e-1_dp, 1.0_dp, over_arc=.true.), &
        parameter_kind_t(1, 'wave_growth', '', '1', ACCELERATION, 1e-1_dp, 1e2_dp), &
        parameter_kind_t(12, 'bend_', 'x3 x4 x5 x6 y2 y3 y4 y5 y6 z2 z3 z4', 'm/s^2', ACCELERATION, 1e-8_dp, 1e-6_dp), &
        parameter_kind_t(2, 'airflow_', 'y z', 'rad', ACCELERATION, 1e-1_dp, 1.0_dp), &
        parameter_kind_t(2, 'side_', 'y z', 'm/s^2', ACCELERATION, 1e-4_dp, 1e-2_dp), &
        parameter_kind_t(2, 'lift_', 'y z', 'm/s^2', ACCELERATION, 1e-6_dp, 1e-2_dp), &
        parameter_kind_t(5, 'tilt_', 'xr yr yz zr zy', 'm/s^2', ACCELERATION, 1e-6_dp, 1e-2_dp), &
        parameter_kind_t(3, 'jump_', XYZ, 'm/s^2', ACCELERATION, 1e-8_dp, 1e-6_dp), &
        parameter_kind_t(9, 'light_', 'x y z x1 y1 z1 x2 y2 z2', 'm/s^2', ACCELERATION, 1e-8_dp, 1e-6_dp), &
        parameter_kind_t(6, 'torque_', 'x2 x3 y2 y3 z2 z3', 'N m', TORQUE_SHAPE, 1e-5_dp, 0.01_dp), &
        parameter_kind_t(3, 'head2_rate_', XYZ, 'rad/s', ATTITUDE, 1e-5_dp, 1.0_dp), &
        parameter_kind_t(1, 'head2_delay', '', 's', ATTITUDE, 1.0_dp, 10.0_dp), &
        parameter_kind_t(3, 'ang_bias_', XYZ, 'rad/s^2', CHANNELS, 1e-4_dp, 10.0_dp), &
        parameter_kind_t(3, 'ang_drift_', XYZ, 'rad/s^3', CHANNELS, 1e-6_dp, 1.0_dp, over_arc=.true.), &
        parameter_kind_t(3, 'rod_gain_', XYZ, '1', TORQUE_SHAPE, 1.0_dp, 1.0_dp, 'gain of rod @', largest=2.0_dp), &
        parameter_kind_t(1, 'rod_gain', '', '1', ROTATION, 1.0_dp, 1.0_dp, 'gain of all rods', largest=2.0_dp), &
        parameter_kind_t(3, 'rod_delay_', XYZ, 's', TORQUE_SHAPE, 1.0_dp, 10.0_dp, 'delay of rod @', shown_unit='s', &
                         largest=LATE), &
        parameter_kind_t(3, 'rod_freq_', XYZ, 'Hz', TORQUE_SHAPE, 1.0_dp, 1.0_dp, 'frequency of rod @', shown_unit='Hz', &
                         largest=0.1_dp), &
        parameter_kind_t(1, 'rod_delay', '', 's', TORQUE_SHAPE, 1.0_dp, 10.0_dp, 'delay of all rods', shown_unit='s', &
                         largest=LATE), &
        parameter_kind_t(1, 'rod_freq', '', 'Hz', TORQUE_SHAPE, 1.0_dp, 1.0_dp, 'frequency of all rods', shown_unit='Hz', &
                         largest=0.1_dp), &
        parameter_kind_t(6, 'rod_', 'x_turn_y x_turn_z y_turn_z y_turn_x z_turn_x z_turn_y', 'rad', TORQUE_SHAPE, 1.0_dp, &
                         1.0_dp, 'direction of rod @', 'x about y,x about z,y about z,y about x,z about x,z about y', &
                         shown_unit='deg', shown_size=DEGREE, largest=180.0_dp), &
        parameter_kind_t(6, 'J_', 'xx yy zz xy yz zx', 'kg m^2', ROTATION, 1.0_dp, 1e3_dp, 'inertia @', shown_unit='kg m^2', &
                         largest=1e3_dp), &
        parameter_kind_t(3, 'change_', XYZ, 'N m', ROTATION, 1.0_dp, 0.01_dp, 'change of other torques about @', &
                         shown_unit='N m', largest=1e-3_dp), &
        parameter_kind_t(3, 'scale_', XYZ, '1', ACCELERATION, 1.0_dp, 1.0_dp, 'scale factor of accelerometer @', &
                         largest=2.0_dp), &
        parameter_kind_t(3, 'acc_delay_', XYZ, 's', INSTRUMENT, 1.0_dp, 10.0_dp, 'delay of accelerometer @', shown_unit='s', &
                         largest=LATE), &
        parameter_kind_t(3, 'acc_turn_', XYZ, 'rad', INSTRUMENT, 1.0_dp, 1.0_dp, 'direction of accelerometer about @', &
                         shown_unit='deg', shown_size=DEGREE, largest=180.0_dp), &
        parameter_kind_t(3, 'field_bias_', XYZ, 'T', ROTATION, 1e-7_dp, 1e-3_dp, 'bias of magnetometer @', shown_unit='nT', &
                         shown_size=NANOTESLA, largest=1e5_dp), &
        parameter_kind_t(3, 'field_turn_', XYZ, 'rad', FIELD_SHAPE, 1.0_dp, 1.0_dp, 'direction of magnetometer about @', &
                         shown_unit='deg', shown_size=DEGREE, largest=180.0_dp), &
        parameter_kind_t(3, 'field_scal_', XYZ, '1', FIELD_SHAPE, 1.0_dp, 1.0_dp, 'scale factor of magnetometer @', &
                         largest=2.0_dp), &
        parameter_kind_t(3, 'field_sh_', PAIRS, '1', FIELD_SHAPE, 1.0_dp, 1.0_dp, 'skewness of magnetometer @', &
                         PAIRS_IN_WORDS), &
        parameter_kind_t(1, 'field_delay', '', 's', FIELD_SHAPE, 1.0_dp, 100.0_dp, 'delay of magnetometer', shown_unit='s', &
                         largest=LATE), &
        parameter_kind_t(3, 'head1_turn_', XYZ, 'rad', ATTITUDE, 1.0_dp, 1.0_dp, 'mounting of head 1 about @', &
                         shown_unit='deg', shown_size=DEGREE, largest=180.0_dp), &
        parameter_kind_t(3, 'head2_turn_', XYZ, 'rad', ATTITUDE, 1.0_dp, 1.0_dp, 'mounting of head 2 about @', &
                         shown_unit='deg', shown_size=DEGREE, largest=180.0_dp), &
        parameter_kind_t(1, 'star_delay', '', 's', ATTITUDE, 1.0_dp, 10.0_dp, 'delay of star camera', shown_unit='s', &
                         largest=LATE), &
        parameter_kind_t(3, 'rod_swap_', PAIRS, '1', TORQUE_SHAPE, 1.0_dp, 1.0_dp, 'interchange of rods @', PAIRS_IN_WORDS), &
        parameter_kind_t(3, 'field_swp_', PAIRS, '1', FIELD_SHAPE, 1.0_dp, 1.0_dp, 'interchange of magnetometer @', &
                         PAIRS_IN_WORDS), &
        parameter_kind_t(3, 'acc_swap_', PAIRS, '1', INSTRUMENT, 1.0_dp, 1.0_dp, 'interchange of accelerometer @', &
                         PAIRS_IN_WORDS), &
        parameter_kind_t(1, 'acc_delay', '', 's', INSTRUMENT, 1.0_dp, 10.0_dp, 'delay of the accelerometer', shown_unit='s', &
                         largest=LATE, tested=.false.), &
        parameter_kind_t(9, 'leak_', BY_ROD, 's^-2/Am', INSTRUMENT, 1e-11_dp, 1e-3_dp, 'leakage of rods @', BY_ROD_IN_WORDS, &
                         largest=1e-9_dp, tested=.false.), &
        parameter_kind_t(9, 'leak_r_', BY_ROD, 's^-1/Am', INSTRUMENT, 1e-11_dp, 1e-3_dp, 'leakage of rods'' rates @', &
                         BY_ROD_IN_WORDS, largest=1e-8_dp, tested=.false.), &
        parameter_kind_t(9, 'ang_scale_', BY_ROD, '1', CHANNELS, 1.0_dp, 1.0_dp, 'angular channels: @', BY_ROD_IN_WORDS, &
                         tested=.false.), &
        parameter_kind_t(9, 'ang_leak_', BY_ROD, 'si', CHANNELS, 1e-9_dp, 1.0_dp, 'leakage into the channels @', &
                         BY_ROD_IN_WORDS, largest=1e-6_dp, tested=.false.), &
        parameter_kind_t(9, 'ang_lrate_', BY_ROD, 'si', CHANNELS, 1e-9_dp, 1.0_dp, 'leakage of rates into the channels @', &
                         BY_ROD_IN_WORDS, largest=1e-6_dp, tested=.false.), &
        parameter_kind_t(6, 'line_scale_', BY_CONTRAST, '1', INSTRUMENT, 1.0_dp, 1.0_dp), &
        parameter_kind_t(6, 'line_bias_', BY_CONTRAST, 'm/s^2', CHANNELS, 1e-6_dp, 10.0_dp), &
        parameter_kind_t(6, 'line_drift_', BY_CONTRAST, 'm/s^3', CHANNELS, 1e-6_dp, 1.0_dp, over_arc=.true.)]

    integer :: i_row, i_member       ! of the loops below, which make constants
    integer, parameter :: COUNTS(*) = KINDS%count
    integer, parameter, public :: PARAMETERS = sum(COUNTS)      !! Number of all parameters
    integer, parameter :: EVERY(*) = [(i_row, i_row=1, PARAMETERS)]     !! All places
    !> The row of each parameter
    type(parameter_kind_t), parameter :: ROW(*) = KINDS([((i_row, i_member=1, COUNTS(i_row)), i_row=1, size(COUNTS))])
    !> Which of its row each parameter is
    integer, parameter, public :: MEMBER_OF(*) = [((i_member, i_member=1, COUNTS(i_row)), i_row=1, size(COUNTS))]
    integer, parameter, public :: KIND_OF(*) = EVERY - MEMBER_OF + 1        !! The kind of each: the first place of its row
    character(8), parameter, public :: PARAMETER_UNITS(*) = ROW%unit        !! SI; 1 for a pure number
    real(dp), parameter, public :: LOOSE_SIGMAS(*) = ROW%loose              !! So large that they weigh nothing, SI units

    logical, parameter, public :: IS_ROTATIONAL(*) = ROW%acts_on <= FIELD_SHAPE         !! Acts on attitude and rate
    logical, parameter, public :: HAS_TORQUE_SHAPE(*) = IS_ROTATIONAL .and. ROW%acts_on /= ROTATION     !! In proportion
    logical, parameter, public :: IS_OF_FIELD(*) = ROW%acts_on == FIELD_SHAPE           !! Changes the field in proportion
    logical, parameter, public :: IS_OF_INSTRUMENT(*) = ROW%acts_on == INSTRUMENT       !! Of the accelerometer, in proportion
    logical, parameter, public :: IS_OF_STAR_CAMERA(*) = ROW%acts_on == ATTITUDE        !! Nothing else shows it

    logical, parameter :: IS_BELIEVED(*) = ROW%subject /= '' .and. ROW%tested
    !> All parameters of which an operator believes something, in the order in which they are shown
    integer, parameter, public :: BELIEFS(*) = pack(EVERY, IS_BELIEVED)
    !> Which of them the model has in proportion alone, by the partial where the belief holds
    logical, parameter, public :: ACTS_IN_PROPORTION(*) = IS_BELIEVED .and. &
        (HAS_TORQUE_SHAPE .or. IS_OF_INSTRUMENT .or. IS_OF_STAR_CAMERA)
    character(8), parameter, public :: BELIEF_UNIT(*) = ROW%shown_unit      !! In which an error is shown; nothing for a ratio
    real(dp), parameter, public :: BELIEF_SIZE(*) = ROW%shown_size          !! That unit in SI units
    real(dp), parameter, public :: LARGEST_ERROR(*) = ROW%largest*ROW%shown_size    !! That is conceivable, SI units

    !> Places, as index vectors
    integer, parameter, public :: ATTITUDE_ANGLES(3) = pack(EVERY, ROW%stem == 'zeta_')  !! zeta at the epoch
    integer, parameter, public :: RATE(3) = pack(EVERY, ROW%stem == 'omega_')  !! omega at the epoch
    integer, parameter, public :: TORQUE(3) = pack(EVERY, ROW%stem == 'torque_' .and. ROW%count == 3)  !! T
    integer, parameter, public :: OFFSET(3) = pack(EVERY, ROW%stem == 'd_')  !! d
    integer, parameter, public :: DRIFT(3) = pack(EVERY, ROW%stem == 'alpha_')  !! alpha
    integer, parameter, public :: BIAS(3) = pack(EVERY, ROW%stem == 'beta_')  !! beta
    integer, parameter, public :: DRAG_CURVATURE = findloc(ROW%stem, 'drag_curve', 1)  !! gamma
    !> Amplitudes of the density wave, and the error of its frequency
    integer, parameter, public :: WAVE_SINE = findloc(ROW%stem, 'wave_sin', 1)
    integer, parameter, public :: WAVE_COSINE = findloc(ROW%stem, 'wave_cos', 1)  !! As WAVE_SINE
    integer, parameter, public :: WAVE_FREQUENCY = findloc(ROW%stem, 'wave_freq', 1)  !! Its error
    integer, parameter, public :: WAVE_GROWTH = findloc(ROW%stem, 'wave_growth', 1)
    !! Of its amplitude, from the middle of the arc to its end, relative
    integer, parameter, public :: FORCE_BENDS(12) = pack(EVERY, ROW%stem == 'bend_')
    !! Of forces that are no straight line, besides: Legendre's polynomials over the arc along body axes, by BEND_AXIS
    !! and BEND_DEGREE
    integer, parameter, public :: AIRFLOW_TURN(2) = pack(EVERY, ROW%stem == 'airflow_')
    !! Of the airflow towards y and z, by the wind
    integer, parameter, public :: SIDE_FORCE(2) = pack(EVERY, ROW%stem == 'side_')
    !! Of the drag along x by the airflow's angles towards y and z
    integer, parameter, public :: LIFT(2) = pack(EVERY, ROW%stem == 'lift_')
    !! Of the force along y and z by the airflow's angle towards them
    integer, parameter, public :: TILT(5) = pack(EVERY, ROW%stem == 'tilt_')
    !! Of the force along the first axis by the roll r, or by the airflow's angle towards the second
    integer, parameter, public :: FORCE_JUMP(3) = pack(EVERY, ROW%stem == 'jump_')  !! Of the acceleration, from one sample on
    integer, parameter, public :: LIGHT(9) = pack(EVERY, ROW%stem == 'light_')
    !! Acceleration by the Sun's, as much as is seen: x, y, z, its slope and its curve from the middle of the arc to its end
    integer, parameter, public :: ROD_GAINS(3) = pack(EVERY, ROW%stem == 'rod_gain_')
    !! Of the rods along x, y, z: gain over that believed, minus 1
    integer, parameter, public :: ROD_GAIN = findloc(ROW%stem, 'rod_gain', 1)  !! g: the same of all rods
    integer, parameter, public :: ROD_DELAYS(3) = pack(EVERY, ROW%stem == 'rod_delay_')  !! From command to moment, of each rod
    integer, parameter, public :: ROD_FREQUENCIES(3) = pack(EVERY, ROW%stem == 'rod_freq_')  !! Of all activations of a rod
    integer, parameter, public :: ALL_RODS_DELAY = findloc(ROW%stem, 'rod_delay', 1)  !! As ROD_DELAYS, of all rods
    integer, parameter, public :: ALL_RODS_FREQUENCY = findloc(ROW%stem, 'rod_freq', 1)  !! As ROD_FREQUENCIES, of all rods
    integer, parameter, public :: ROD_TURNS(6) = pack(EVERY, ROW%stem == 'rod_')  !! As torque_rods_t has its misalignment
    integer, parameter, public :: INERTIA(6) = pack(EVERY, ROW%stem == 'J_')  !! Errors of J's xx, yy, zz, xy, yz, zx
    integer, parameter, public :: TORQUE_CHANGE(3) = pack(EVERY, ROW%stem == 'change_')  !! T'
    integer, parameter, public :: SCALE_FACTORS(3) = pack(EVERY, ROW%stem == 'scale_')  !! s: scale factor minus 1
    integer, parameter, public :: ACCELEROMETER_DELAYS(3) = pack(EVERY, ROW%stem == 'acc_delay_')  !! Of each axis's time tags
    integer, parameter, public :: ACCELEROMETER_TURN(3) = pack(EVERY, ROW%stem == 'acc_turn_')
    !! Rotation vector from the acceleration to the accelerometer's samples
    integer, parameter, public :: FIELD_BIAS(3) = pack(EVERY, ROW%stem == 'field_bias_')  !! b
    integer, parameter, public :: FIELD_TURN(3) = pack(EVERY, ROW%stem == 'field_turn_')
    !! Rotation vector from the magnetometer's samples to the field
    integer, parameter, public :: FIELD_SCALES(3) = pack(EVERY, ROW%stem == 'field_scal_')
    !! Scale factors of the magnetometer minus 1
    integer, parameter, public :: FIELD_SHEARS(3) = pack(EVERY, ROW%stem == 'field_sh_')
    !! Parts of one component of the field in another and as much back: x and y, y and z, z and x
    integer, parameter, public :: FIELD_DELAY = findloc(ROW%stem, 'field_delay', 1)  !! Of the magnetometer's time tags
    !> Rotation vector from the body to what the samples of a star-camera head say of it, body axes
    integer, parameter, public :: MOUNTING_1(3) = pack(EVERY, ROW%stem == 'head1_turn_')
    integer, parameter, public :: MOUNTING_2(3) = pack(EVERY, ROW%stem == 'head2_turn_')  !! Of head 2
    integer, parameter, public :: STAR_CAMERA_DELAY = findloc(ROW%stem, 'star_delay', 1)  !! Of the star camera's time tags
    !> 1 if two axes are interchanged, x and y, y and z, z and x; no other value has a meaning: the commands of two rods,
    !> two axes of the magnetometer, of the accelerometer
    integer, parameter, public :: ROD_SWAPS(3) = pack(EVERY, ROW%stem == 'rod_swap_')
    integer, parameter, public :: FIELD_SWAPS(3) = pack(EVERY, ROW%stem == 'field_swp_')  !! Of the magnetometer
    integer, parameter, public :: ACCELEROMETER_SWAPS(3) = pack(EVERY, ROW%stem == 'acc_swap_')  !! Of the accelerometer
    integer, parameter, public :: INTERCHANGES(9) = [ROD_SWAPS, FIELD_SWAPS, ACCELEROMETER_SWAPS]   !! All of these

    !> What arcs of Level-1 data have besides: torques that bend (Legendre's polynomials of degree 2, 3 over the arc), the drift of
    !> gyros that count as head 2, angular channels S J^-1 T + bias + drift + leakage, leakage of the rods' moments and rates
    integer, parameter, public :: TORQUE_BENDS(6) = pack(EVERY, ROW%stem == 'torque_' .and. ROW%count == 6)
    integer, parameter, public :: HEAD_DRIFT(3) = pack(EVERY, ROW%stem == 'head2_rate_')  !! Of gyros that count as head 2
    integer, parameter, public :: HEAD_DELAY = findloc(ROW%stem, 'head2_delay', 1)  !! Of the tags of head 2
    integer, parameter, public :: CHANNEL_BIAS(3) = pack(EVERY, ROW%stem == 'ang_bias_')  !! Of the angular channels
    integer, parameter, public :: CHANNEL_DRIFT(3) = pack(EVERY, ROW%stem == 'ang_drift_')  !! Of their biases
    integer, parameter, public :: SAMPLING_DELAY = findloc(ROW%stem, 'acc_delay', 1)  !! Of all tags of the accelerometer
    integer, parameter, public :: LEAKAGE(9) = pack(EVERY, ROW%stem == 'leak_')  !! (axis, rod), the rod first
    integer, parameter, public :: LEAKAGE_RATE(9) = pack(EVERY, ROW%stem == 'leak_r_')  !! As LEAKAGE, of the rates of the moments
    integer, parameter, public :: CHANNEL_SCALES(9) = pack(EVERY, ROW%stem == 'ang_scale_')  !! S minus 1
    integer, parameter, public :: CHANNEL_LEAKAGE(9) = pack(EVERY, ROW%stem == 'ang_leak_')  !! As LEAKAGE, into these channels
    integer, parameter, public :: CHANNEL_LEAKAGE_RATE(9) = pack(EVERY, ROW%stem == 'ang_lrate_')  !! As LEAKAGE_RATE, likewise

    !> Of several accelerometers on a line (gracecg_observations_accelerometer_line): x, y, z of the first contrast, then of
    !> the second
    integer, parameter, public :: LINE_SCALES(6) = pack(EVERY, ROW%stem == 'line_scale_')  !! Contrasts of their scale factors
    integer, parameter, public :: LINE_BIAS(6) = pack(EVERY, ROW%stem == 'line_bias_')  !! Biases of the contrasts of their samples
    integer, parameter, public :: LINE_DRIFT(6) = pack(EVERY, ROW%stem == 'line_drift_')  !! Drifts of these

    integer, parameter, public :: FORCE_SHAPES(15) = [DRAG_CURVATURE, FORCE_BENDS, SIDE_FORCE]
    !! Of forces that are no straight line in time
    integer, parameter, public :: TILT_AXIS(5) = [1, 2, 2, 3, 3]  !! Of the force of each of TILT
    !> Axes and degrees of FORCE_BENDS
    integer, parameter, public :: BEND_AXIS(12) = [1, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3]
    integer, parameter, public :: BEND_DEGREE(12) = [3, 4, 5, 6, 2, 3, 4, 5, 6, 2, 3, 4]  !! Of the polynomials

contains

    !> The name of a parameter, as in output.
    elemental function parameter_names(place) result(name)
        integer, intent(in) :: place        !! Of the parameter
        character(12) :: name

        name = trim(ROW(place)%stem)//word(ROW(place)%members, ' ', MEMBER_OF(place))
    end function parameter_names

    !> What a belief is of, in words: 'gain of rod x'; nothing if nobody believes anything of it.
    elemental function belief_subject(place) result(subject)
        integer, intent(in) :: place        !! Of the parameter
        character(48) :: subject

        integer :: at

        subject = ROW(place)%subject
        at = index(subject, '@')
        if (at == 0) return
        if (ROW(place)%members_in_words == '') then
            subject = subject(:at - 1)//word(ROW(place)%members, ' ', MEMBER_OF(place))
        else
            subject = subject(:at - 1)//word(ROW(place)%members_in_words, ',', MEMBER_OF(place))
        end if
    end function belief_subject

    !> The parameters that a text names, as `parameter_names` does, separated by blanks or commas. Interchanges, which have
    !> no size, cannot be estimated and are not known.
    pure subroutine find_parameters(text, places, unknown)
        character(*), intent(in) :: text    !! Names, separated by blanks or commas
        integer, allocatable, intent(out) :: places(:)    !! Of the parameters they name
        character(:), allocatable, intent(out) :: unknown   !! The first name that is none; empty: all are known

        character(len(text)) :: left
        integer :: length, place

        left = text
        do place = 1, len(left)
            if (left(place:place) == ',') left(place:place) = ' '
        end do
        unknown = ''
        allocate (places(0))
        do
            left = adjustl(left)
            if (left == '') return
            length = index(left//' ', ' ') - 1
            do place = PARAMETERS, 1, -1
                if (parameter_names(place) == left(:length) .and. .not. any(INTERCHANGES == place)) exit
            end do
            if (place == 0) then
                unknown = left(:length)
                return
            end if
            if (.not. any(places == place)) places = [places, place]
            left(:length) = ''
        end do
    end subroutine find_parameters

    !> Sizes of parameters, for convergence, SI units.
    pure function typical_sizes(places, duration) result(sizes)
        integer, intent(in) :: places(:)    !! Of the parameters
        real(dp), intent(in) :: duration    !! Of the arc, s
        real(dp) :: sizes(size(places))

        sizes = ROW(places)%size/merge(duration, 1.0_dp, ROW(places)%over_arc)
    end function typical_sizes

    !> A word of a text; nothing behind the last one.
    pure function word(text, separator, number)
        character(*), intent(in) :: text
        character(1), intent(in) :: separator
        integer, intent(in) :: number       !! 1 is the first
        character(16) :: word

        integer :: first, length, i

        first = 1
        do i = 1, number
            length = index(trim(text(first:))//separator, separator) - 1
            word = text(first:first + length - 1)
            first = min(first + length + 1, len(text) + 1)
        end do
    end function word
end module gracecg_observations_parameters
