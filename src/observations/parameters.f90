!> What can be estimated, and believed: every parameter of the physical model in one table.
!>
!> A row of KINDS says of some parameters that belong together their names, unit, what they act on, size, and, if an
!> operator believes something of them, words. A new kind is a row here, its name in the enumeration, and its partial: of the
!> rotation in gracecg_estimation_model_rotation or gracecg_estimation_torque_shapes, of what instruments show in
!> gracecg_estimation_shown_samples; what is known of it beforehand is `a_priori_t`'s.
!>
!> A parameter is told by its place, 1 to PARAMETERS; its value is the error of what is believed, so that 0 is the
!> belief.
module gracecg_observations_parameters
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, NANOTESLA
    implicit none
    private
    public :: parameter_kind_t, KINDS, KIND_OF, MEMBER_OF, PARAMETERS
    public :: ROTATION, ACCELERATION, ATTITUDE, CHANNELS
    public :: is_rotational, is_of_star_camera, acts_in_proportion, find_parameters, typical_sizes, loose_sigmas
    public :: parameter_names, parameter_units, belief_subject, belief_unit, belief_size, largest_error
    public :: ATTITUDE_ANGLES, RATE, TORQUE, OFFSET, DRIFT, BIAS, SCALE_FACTORS, ROD_GAIN, FIELD_BIAS
    public :: DRAG_CURVATURE, WAVE_SINE, WAVE_COSINE, WAVE_FREQUENCY, WAVE_GROWTH, INERTIA, TORQUE_CHANGE
    public :: ROD_GAINS, ROD_TURNS, ROD_DELAYS, ROD_FREQUENCIES, FIELD_TURN, FIELD_DELAY
    public :: ACCELEROMETER_DELAYS, ACCELEROMETER_TURN, MOUNTING_1, MOUNTING_2, STAR_CAMERA_DELAY
    public :: ALL_RODS_DELAY, ALL_RODS_FREQUENCY, FORCE_BENDS, AIRFLOW_TURN, SIDE_FORCE, LIFT, TILT, FORCE_JUMP, LIGHT, &
        FIELD_SCALES, FIELD_SHEARS
    public :: ROD_SWAPS, FIELD_SWAPS, ACCELEROMETER_SWAPS
    public :: OF_ATTITUDE_ANGLES, OF_RATE, OF_TORQUE, OF_OFFSET, OF_DRIFT, OF_BIAS, OF_DRAG_CURVATURE
    public :: OF_WAVE_SINE, OF_WAVE_COSINE, OF_WAVE_FREQUENCY, OF_WAVE_GROWTH, OF_FORCE_BENDS, OF_AIRFLOW_TURN, OF_SIDE_FORCE
    public :: OF_LIFT, OF_TILT, OF_FORCE_JUMP, OF_LIGHT, OF_TORQUE_BENDS, OF_HEAD_DRIFT, OF_CHANNEL_BIAS, OF_CHANNEL_DRIFT, &
        OF_ROD_GAINS
    public :: OF_ROD_GAIN, OF_ROD_DELAYS, OF_ROD_FREQUENCIES, OF_ALL_RODS_DELAY, OF_ALL_RODS_FREQUENCY
    public :: OF_ROD_TURNS, OF_INERTIA, OF_TORQUE_CHANGE, OF_SCALE_FACTORS, OF_ACCELEROMETER_DELAYS
    public :: OF_ACCELEROMETER_TURN, OF_FIELD_BIAS, OF_FIELD_TURN, OF_FIELD_SCALES, OF_FIELD_SHEARS
    public :: OF_FIELD_DELAY, OF_MOUNTING_1, OF_MOUNTING_2, OF_STAR_CAMERA_DELAY, OF_ROD_SWAPS, OF_FIELD_SWAPS
    public :: OF_ACCELEROMETER_SWAPS, OF_SAMPLING_DELAY, OF_LEAKAGE, OF_LEAKAGE_RATE, OF_CHANNEL_SCALES
    public :: OF_CHANNEL_LEAKAGE, OF_CHANNEL_LEAKAGE_RATE, OF_LINE_SCALES, OF_LINE_BIAS, OF_LINE_DRIFT
    public :: LINE_SCALES, LINE_BIAS, LINE_DRIFT
    public :: OF_HEAD_DELAY, HEAD_DELAY, TORQUE_BENDS, HEAD_DRIFT, CHANNEL_BIAS, CHANNEL_DRIFT, SAMPLING_DELAY, LEAKAGE, &
        LEAKAGE_RATE, CHANNEL_SCALES, &
        CHANNEL_LEAKAGE, CHANNEL_LEAKAGE_RATE
    public :: BELIEFS, TILT_AXIS, BEND_AXIS, BEND_DEGREE, FORCE_SHAPES

    !> What a parameter acts on
    enum, bind(c)
        enumerator :: ROTATION = 1  !! Of the satellite: the accelerometer sees it, too
        enumerator :: ACCELERATION  !! What the accelerometer shows
        enumerator :: ATTITUDE      !! What the star camera shows, alone
        enumerator :: CHANNELS      !! What angular channels of the accelerometer, or contrasts of several, show, alone
    end enum

    !> The kinds, in the order of KINDS
    enum, bind(c)
        enumerator :: OF_ATTITUDE_ANGLES = 1, OF_RATE, OF_TORQUE, OF_OFFSET, OF_DRIFT, OF_BIAS
        enumerator :: OF_DRAG_CURVATURE, OF_WAVE_SINE, OF_WAVE_COSINE, OF_WAVE_FREQUENCY, OF_WAVE_GROWTH
        enumerator :: OF_FORCE_BENDS, OF_AIRFLOW_TURN, OF_SIDE_FORCE, OF_LIFT, OF_TILT, OF_FORCE_JUMP, OF_LIGHT, OF_TORQUE_BENDS
        enumerator :: OF_HEAD_DRIFT
        enumerator :: OF_HEAD_DELAY, OF_CHANNEL_BIAS, OF_CHANNEL_DRIFT
        enumerator :: OF_ROD_GAINS, OF_ROD_GAIN, OF_ROD_DELAYS, OF_ROD_FREQUENCIES, OF_ALL_RODS_DELAY, OF_ALL_RODS_FREQUENCY
        enumerator :: OF_ROD_TURNS, OF_INERTIA, OF_TORQUE_CHANGE, OF_SCALE_FACTORS, OF_ACCELEROMETER_DELAYS
        enumerator :: OF_ACCELEROMETER_TURN, OF_FIELD_BIAS, OF_FIELD_TURN, OF_FIELD_SCALES, OF_FIELD_SHEARS, OF_FIELD_DELAY
        enumerator :: OF_MOUNTING_1, OF_MOUNTING_2, OF_STAR_CAMERA_DELAY
        enumerator :: OF_ROD_SWAPS, OF_FIELD_SWAPS, OF_ACCELEROMETER_SWAPS
        enumerator :: OF_SAMPLING_DELAY, OF_LEAKAGE, OF_LEAKAGE_RATE, OF_CHANNEL_SCALES, OF_CHANNEL_LEAKAGE, OF_CHANNEL_LEAKAGE_RATE
        enumerator :: OF_LINE_SCALES, OF_LINE_BIAS, OF_LINE_DRIFT
    end enum

    !> A row of the table: what parameters of one kind have in common.
    type :: parameter_kind_t
        integer :: count                    !! How many there are
        character(12) :: stem               !! Of their names
        character(56) :: members            !! Ends of their names, separated by blanks; '-': the name has none
        character(8) :: unit                !! Of the estimates, SI
        integer :: acts_on                  !! ROTATION, ACCELERATION, ATTITUDE or CHANNELS
        real(dp) :: size                    !! Typical, for convergence
        logical :: over_arc                 !! `size` is what it makes in the whole arc: divided by its length
        real(dp) :: loose                   !! A standard deviation so large that it weighs nothing
        character(36) :: subject = ''       !! In words, @ stands for the member; '': nobody believes anything of it
        character(72) :: members_in_words = ''  !! Separated by commas; '': `members`
        character(8) :: shown_unit = ''     !! In which it is shown; '': a ratio
        real(dp) :: shown_size = 1          !! Of that unit in SI units
        real(dp) :: largest = 1             !! Wrong value that is conceivable, in that unit
    end type parameter_kind_t

    logical, parameter :: YES = .true., NO = .false.
    character(*), parameter :: XYZ = 'x y z', PAIRS = 'xy yz zx', PAIRS_IN_WORDS = 'x and y,y and z,z and x'
    !> Elements of a matrix: the axis that shows it, and the rod or axis that makes it
    character(*), parameter :: BY_ROD = 'xx xy xz yx yy yz zx zy zz'
    character(*), parameter :: BY_CONTRAST = 'x1 y1 z1 x2 y2 z2'    !! Axis and contrast
    character(*), parameter :: BY_ROD_IN_WORDS = 'x by x,x by y,x by z,y by x,y by y,y by z,z by x,z by y,z by z'
    real(dp), parameter :: LATE = 5     !! The longest conceivable delay, s

    !> All kinds of parameter, in the order of OF_...
    type(parameter_kind_t), parameter :: KINDS(*) = [ &
        parameter_kind_t(3, 'zeta_', XYZ, 'rad', ROTATION, 1e-3_dp, NO, 1.0_dp), &
        parameter_kind_t(3, 'omega_', XYZ, 'rad/s', ROTATION, 1e-3_dp, NO, 0.1_dp), &
        parameter_kind_t(3, 'torque_', XYZ, 'N m', ROTATION, 1e-4_dp, NO, 0.01_dp), &
        parameter_kind_t(3, 'd_', XYZ, 'm', ACCELERATION, 1e-3_dp, NO, 1.0_dp), &
        parameter_kind_t(3, 'alpha_', XYZ, 'm/s^3', ACCELERATION, 1e-6_dp, YES, 1.0_dp), &
        parameter_kind_t(3, 'beta_', XYZ, 'm/s^2', ACCELERATION, 1e-6_dp, NO, 10.0_dp), &   ! it would pull the scale factor
        parameter_kind_t(1, 'drag_curve', '-', 'm/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &
        parameter_kind_t(1, 'wave_sin', '-', 'm/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &
        parameter_kind_t(1, 'wave_cos', '-', 'm/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &
        parameter_kind_t(1, 'wave_freq', '-', 'Hz', ACCELERATION, 1e-1_dp, YES, 1.0_dp), &
        parameter_kind_t(1, 'wave_growth', '-', '1', ACCELERATION, 1e-1_dp, NO, 1e2_dp), &
        parameter_kind_t(12, 'bend_', 'x3 x4 x5 x6 y2 y3 y4 y5 y6 z2 z3 z4', 'm/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &
        parameter_kind_t(2, 'airflow_', 'y z', 'rad', ACCELERATION, 1e-1_dp, NO, 1.0_dp), &
        parameter_kind_t(2, 'side_', 'y z', 'm/s^2', ACCELERATION, 1e-4_dp, NO, 1e-2_dp), &
        parameter_kind_t(2, 'lift_', 'y z', 'm/s^2', ACCELERATION, 1e-6_dp, NO, 1e-2_dp), &
        parameter_kind_t(5, 'tilt_', 'xr yr yz zr zy', 'm/s^2', ACCELERATION, 1e-6_dp, NO, 1e-2_dp), &
        parameter_kind_t(3, 'jump_', XYZ, 'm/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &
        parameter_kind_t(9, 'light_', 'x y z x1 y1 z1 x2 y2 z2', 'm/s^2', ACCELERATION, 1e-8_dp, NO, 1e-6_dp), &
        parameter_kind_t(6, 'torque_', 'x2 x3 y2 y3 z2 z3', 'N m', ROTATION, 1e-5_dp, NO, 0.01_dp), &
        parameter_kind_t(3, 'head2_rate_', XYZ, 'rad/s', ATTITUDE, 1e-5_dp, NO, 1.0_dp), &
        parameter_kind_t(1, 'head2_delay', '-', 's', ATTITUDE, 1.0_dp, NO, 10.0_dp), &
        parameter_kind_t(3, 'ang_bias_', XYZ, 'rad/s^2', CHANNELS, 1e-4_dp, NO, 10.0_dp), &
        parameter_kind_t(3, 'ang_drift_', XYZ, 'rad/s^3', CHANNELS, 1e-6_dp, YES, 1.0_dp), &
        parameter_kind_t(3, 'rod_gain_', XYZ, '1', ROTATION, 1.0_dp, NO, 1.0_dp, 'gain of rod @', largest=2.0_dp), &
        parameter_kind_t(1, 'rod_gain', '-', '1', ROTATION, 1.0_dp, NO, 1.0_dp, 'gain of all rods', largest=2.0_dp), &
        parameter_kind_t(3, 'rod_delay_', XYZ, 's', ROTATION, 1.0_dp, NO, 10.0_dp, 'delay of rod @', '', 's', 1.0_dp, LATE), &
        parameter_kind_t(3, 'rod_freq_', XYZ, 'Hz', ROTATION, 1.0_dp, NO, 1.0_dp, 'frequency of rod @', '', 'Hz', 1.0_dp, &
                         0.1_dp), &
        parameter_kind_t(1, 'rod_delay', '-', 's', ROTATION, 1.0_dp, NO, 10.0_dp, 'delay of all rods', '', 's', 1.0_dp, LATE), &
        parameter_kind_t(1, 'rod_freq', '-', 'Hz', ROTATION, 1.0_dp, NO, 1.0_dp, 'frequency of all rods', '', 'Hz', 1.0_dp, &
                         0.1_dp), &
        parameter_kind_t(6, 'rod_', 'x_turn_y x_turn_z y_turn_z y_turn_x z_turn_x z_turn_y', 'rad', ROTATION, 1.0_dp, NO, &
                         1.0_dp, 'direction of rod @', 'x about y,x about z,y about z,y about x,z about x,z about y', 'deg', &
                         DEGREE, 180.0_dp), &
        parameter_kind_t(6, 'J_', 'xx yy zz xy yz zx', 'kg m^2', ROTATION, 1.0_dp, NO, 1e3_dp, 'inertia @', '', 'kg m^2', &
                         1.0_dp, 1e3_dp), &
        parameter_kind_t(3, 'change_', XYZ, 'N m', ROTATION, 1.0_dp, NO, 0.01_dp, 'change of other torques about @', '', &
                         'N m', 1.0_dp, 1e-3_dp), &
        parameter_kind_t(3, 'scale_', XYZ, '1', ACCELERATION, 1.0_dp, NO, 1.0_dp, 'scale factor of accelerometer @', &
                         largest=2.0_dp), &
        parameter_kind_t(3, 'acc_delay_', XYZ, 's', ACCELERATION, 1.0_dp, NO, 10.0_dp, 'delay of accelerometer @', '', 's', &
                         1.0_dp, LATE), &
        parameter_kind_t(3, 'acc_turn_', XYZ, 'rad', ACCELERATION, 1.0_dp, NO, 1.0_dp, 'direction of accelerometer about @', &
                         '', 'deg', DEGREE, 180.0_dp), &
        parameter_kind_t(3, 'field_bias_', XYZ, 'T', ROTATION, 1e-7_dp, NO, 1e-3_dp, 'bias of magnetometer @', '', 'nT', &
                         NANOTESLA, 1e5_dp), &
        parameter_kind_t(3, 'field_turn_', XYZ, 'rad', ROTATION, 1.0_dp, NO, 1.0_dp, 'direction of magnetometer about @', '', &
                         'deg', DEGREE, 180.0_dp), &
        parameter_kind_t(3, 'field_scal_', XYZ, '1', ROTATION, 1.0_dp, NO, 1.0_dp, 'scale factor of magnetometer @', &
                         largest=2.0_dp), &
        parameter_kind_t(3, 'field_sh_', PAIRS, '1', ROTATION, 1.0_dp, NO, 1.0_dp, 'skewness of magnetometer @', PAIRS_IN_WORDS), &
        parameter_kind_t(1, 'field_delay', '-', 's', ROTATION, 1.0_dp, NO, 100.0_dp, 'delay of magnetometer', '', 's', 1.0_dp, &
                         LATE), &
        parameter_kind_t(3, 'head1_turn_', XYZ, 'rad', ATTITUDE, 1.0_dp, NO, 1.0_dp, 'mounting of head 1 about @', '', 'deg', &
                         DEGREE, 180.0_dp), &
        parameter_kind_t(3, 'head2_turn_', XYZ, 'rad', ATTITUDE, 1.0_dp, NO, 1.0_dp, 'mounting of head 2 about @', '', 'deg', &
                         DEGREE, 180.0_dp), &
        parameter_kind_t(1, 'star_delay', '-', 's', ATTITUDE, 1.0_dp, NO, 10.0_dp, 'delay of star camera', '', 's', 1.0_dp, &
                         LATE), &
        parameter_kind_t(3, 'rod_swap_', PAIRS, '1', ROTATION, 1.0_dp, NO, 1.0_dp, 'interchange of rods @', PAIRS_IN_WORDS), &
        parameter_kind_t(3, 'field_swp_', PAIRS, '1', ROTATION, 1.0_dp, NO, 1.0_dp, 'interchange of magnetometer @', &
                         PAIRS_IN_WORDS), &
        parameter_kind_t(3, 'acc_swap_', PAIRS, '1', ACCELERATION, 1.0_dp, NO, 1.0_dp, 'interchange of accelerometer @', &
                         PAIRS_IN_WORDS), &
        parameter_kind_t(1, 'acc_delay', '-', 's', ACCELERATION, 1.0_dp, NO, 10.0_dp, 'delay of the accelerometer', '', 's', &
                         1.0_dp, LATE), &
        parameter_kind_t(9, 'leak_', BY_ROD, 's^-2/Am', ACCELERATION, 1e-11_dp, NO, 1e-3_dp, 'leakage of rods @', &
                         BY_ROD_IN_WORDS, '', 1.0_dp, 1e-9_dp), &
        parameter_kind_t(9, 'leak_r_', BY_ROD, 's^-1/Am', ACCELERATION, 1e-11_dp, NO, 1e-3_dp, 'leakage of rods'' rates @', &
                         BY_ROD_IN_WORDS, '', 1.0_dp, 1e-8_dp), &
        parameter_kind_t(9, 'ang_scale_', BY_ROD, '1', CHANNELS, 1.0_dp, NO, 1.0_dp, 'angular channels: @', BY_ROD_IN_WORDS), &
        parameter_kind_t(9, 'ang_leak_', BY_ROD, 'si', CHANNELS, 1e-9_dp, NO, 1.0_dp, 'leakage into the channels @', &
                         BY_ROD_IN_WORDS, '', 1.0_dp, 1e-6_dp), &
        parameter_kind_t(9, 'ang_lrate_', BY_ROD, 'si', CHANNELS, 1e-9_dp, NO, 1.0_dp, 'leakage of rates into the channels @', &
                         BY_ROD_IN_WORDS, '', 1.0_dp, 1e-6_dp), &
        parameter_kind_t(6, 'line_scale_', BY_CONTRAST, '1', ACCELERATION, 1.0_dp, NO, 1.0_dp), &
        parameter_kind_t(6, 'line_bias_', BY_CONTRAST, 'm/s^2', CHANNELS, 1e-6_dp, NO, 10.0_dp), &
        parameter_kind_t(6, 'line_drift_', BY_CONTRAST, 'm/s^3', CHANNELS, 1e-6_dp, YES, 1.0_dp)]

    integer :: i_row, i_member       ! of the loops below, which make constants
    integer, parameter :: COUNTS(*) = KINDS%count
    integer, parameter :: PARAMETERS = sum(COUNTS)      !! Number of all parameters
    integer, parameter :: EVERY(*) = [(i_row, i_row=1, PARAMETERS)]     !! All places
    !> The row of each parameter, and which of that row it is
    integer, parameter :: KIND_OF(PARAMETERS) = [((i_row, i_member=1, COUNTS(i_row)), i_row=1, size(COUNTS))]
    integer, parameter :: MEMBER_OF(PARAMETERS) = [((i_member, i_member=1, COUNTS(i_row)), i_row=1, size(COUNTS))]
    !! Which of its row each parameter is
    !> All parameters of which an operator believes something, in the order in which they are shown
    integer, parameter :: BELIEFS(*) = pack(EVERY, KIND_OF >= OF_ROD_GAINS .and. KIND_OF <= OF_ACCELEROMETER_SWAPS)

    !> Places, as index vectors
    integer, parameter :: ATTITUDE_ANGLES(3) = pack(EVERY, KIND_OF == OF_ATTITUDE_ANGLES)   !! zeta at the epoch
    integer, parameter :: RATE(3) = pack(EVERY, KIND_OF == OF_RATE)                         !! omega at the epoch
    integer, parameter :: TORQUE(3) = pack(EVERY, KIND_OF == OF_TORQUE)                     !! T
    integer, parameter :: OFFSET(3) = pack(EVERY, KIND_OF == OF_OFFSET)                     !! d
    integer, parameter :: DRIFT(3) = pack(EVERY, KIND_OF == OF_DRIFT)                       !! alpha
    integer, parameter :: BIAS(3) = pack(EVERY, KIND_OF == OF_BIAS)                         !! beta
    integer, parameter :: DRAG_CURVATURE = findloc(KIND_OF, OF_DRAG_CURVATURE, 1)           !! gamma
    !> Amplitudes of the density wave, and the error of its frequency
    integer, parameter :: WAVE_SINE = findloc(KIND_OF, OF_WAVE_SINE, 1)
    integer, parameter :: WAVE_COSINE = findloc(KIND_OF, OF_WAVE_COSINE, 1)  !! As WAVE_SINE
    integer, parameter :: WAVE_FREQUENCY = findloc(KIND_OF, OF_WAVE_FREQUENCY, 1)  !! Its error
    integer, parameter :: WAVE_GROWTH = findloc(KIND_OF, OF_WAVE_GROWTH, 1)
    !! Of its amplitude, from the middle of the arc to its end, relative
    integer, parameter :: FORCE_BENDS(12) = pack(EVERY, KIND_OF == OF_FORCE_BENDS)
    !! Of forces that are no straight line, besides: Legendre's polynomials over the arc along body axes, by BEND_AXIS
    !! and BEND_DEGREE
    integer, parameter :: AIRFLOW_TURN(2) = pack(EVERY, KIND_OF == OF_AIRFLOW_TURN) !! Of the airflow towards y and z, by the wind
    integer, parameter :: SIDE_FORCE(2) = pack(EVERY, KIND_OF == OF_SIDE_FORCE)
    !! Of the drag along x by the airflow's angles towards y and z
    integer, parameter :: LIFT(2) = pack(EVERY, KIND_OF == OF_LIFT)
    !! Of the force along y and z by the airflow's angle towards them
    integer, parameter :: TILT(5) = pack(EVERY, KIND_OF == OF_TILT)
    !! Of the force along the first axis by the roll r, or by the airflow's angle towards the second
    integer, parameter :: FORCE_JUMP(3) = pack(EVERY, KIND_OF == OF_FORCE_JUMP)     !! Of the acceleration, from one sample on
    integer, parameter :: LIGHT(9) = pack(EVERY, KIND_OF == OF_LIGHT)
    !! Acceleration by the Sun's, as much as is seen: x, y, z, its slope and its curve from the middle of the arc to its end
    integer, parameter :: ROD_GAINS(3) = pack(EVERY, KIND_OF == OF_ROD_GAINS)
    !! Of the rods along x, y, z: gain over that believed, minus 1
    integer, parameter :: ROD_GAIN = findloc(KIND_OF, OF_ROD_GAIN, 1)               !! g: the same of all rods
    integer, parameter :: ROD_DELAYS(3) = pack(EVERY, KIND_OF == OF_ROD_DELAYS)     !! From command to moment, of each rod
    integer, parameter :: ROD_FREQUENCIES(3) = pack(EVERY, KIND_OF == OF_ROD_FREQUENCIES)   !! Of all activations of a rod
    integer, parameter :: ALL_RODS_DELAY = findloc(KIND_OF, OF_ALL_RODS_DELAY, 1)   !! As ROD_DELAYS, of all rods
    integer, parameter :: ALL_RODS_FREQUENCY = findloc(KIND_OF, OF_ALL_RODS_FREQUENCY, 1)  !! As ROD_FREQUENCIES, of all rods
    integer, parameter :: ROD_TURNS(6) = pack(EVERY, KIND_OF == OF_ROD_TURNS)       !! As torque_rods_t has its misalignment
    integer, parameter :: INERTIA(6) = pack(EVERY, KIND_OF == OF_INERTIA)           !! Errors of J's xx, yy, zz, xy, yz, zx
    integer, parameter :: TORQUE_CHANGE(3) = pack(EVERY, KIND_OF == OF_TORQUE_CHANGE)       !! T'
    integer, parameter :: SCALE_FACTORS(3) = pack(EVERY, KIND_OF == OF_SCALE_FACTORS)       !! s: scale factor minus 1
    integer, parameter :: ACCELEROMETER_DELAYS(3) = pack(EVERY, KIND_OF == OF_ACCELEROMETER_DELAYS) !! Of each axis's time tags
    integer, parameter :: ACCELEROMETER_TURN(3) = pack(EVERY, KIND_OF == OF_ACCELEROMETER_TURN)
    !! Rotation vector from the acceleration to the accelerometer's samples
    integer, parameter :: FIELD_BIAS(3) = pack(EVERY, KIND_OF == OF_FIELD_BIAS)     !! b
    integer, parameter :: FIELD_TURN(3) = pack(EVERY, KIND_OF == OF_FIELD_TURN)
    !! Rotation vector from the magnetometer's samples to the field
    integer, parameter :: FIELD_SCALES(3) = pack(EVERY, KIND_OF == OF_FIELD_SCALES) !! Scale factors of the magnetometer minus 1
    integer, parameter :: FIELD_SHEARS(3) = pack(EVERY, KIND_OF == OF_FIELD_SHEARS)
    !! Parts of one component of the field in another and as much back: x and y, y and z, z and x
    integer, parameter :: FIELD_DELAY = findloc(KIND_OF, OF_FIELD_DELAY, 1)         !! Of the magnetometer's time tags
    !> Rotation vector from the body to what the samples of a star-camera head say of it, body axes
    integer, parameter :: MOUNTING_1(3) = pack(EVERY, KIND_OF == OF_MOUNTING_1)
    integer, parameter :: MOUNTING_2(3) = pack(EVERY, KIND_OF == OF_MOUNTING_2)  !! Of head 2
    integer, parameter :: STAR_CAMERA_DELAY = findloc(KIND_OF, OF_STAR_CAMERA_DELAY, 1)     !! Of the star camera's time tags
    !> 1 if two axes are interchanged, x and y, y and z, z and x; no other value has a meaning: the commands of two rods,
    !> two axes of the magnetometer, of the accelerometer
    integer, parameter :: ROD_SWAPS(3) = pack(EVERY, KIND_OF == OF_ROD_SWAPS)
    integer, parameter :: FIELD_SWAPS(3) = pack(EVERY, KIND_OF == OF_FIELD_SWAPS)  !! Of the magnetometer
    integer, parameter :: ACCELEROMETER_SWAPS(3) = pack(EVERY, KIND_OF == OF_ACCELEROMETER_SWAPS)  !! Of the accelerometer

    !> What arcs of Level-1 data have besides: torques that bend (Legendre's polynomials of degree 2, 3 over the arc), the drift of
    !> gyros that count as head 2, angular channels S J^-1 T + bias + drift + leakage, leakage of the rods' moments and rates
    integer, parameter :: TORQUE_BENDS(6) = pack(EVERY, KIND_OF == OF_TORQUE_BENDS)
    integer, parameter :: HEAD_DRIFT(3) = pack(EVERY, KIND_OF == OF_HEAD_DRIFT)  !! Of gyros that count as head 2
    integer, parameter :: HEAD_DELAY = findloc(KIND_OF, OF_HEAD_DELAY, 1)           !! Of the tags of head 2
    integer, parameter :: CHANNEL_BIAS(3) = pack(EVERY, KIND_OF == OF_CHANNEL_BIAS)  !! Of the angular channels
    integer, parameter :: CHANNEL_DRIFT(3) = pack(EVERY, KIND_OF == OF_CHANNEL_DRIFT)  !! Of their biases
    integer, parameter :: SAMPLING_DELAY = findloc(KIND_OF, OF_SAMPLING_DELAY, 1)   !! Of all tags of the accelerometer
    integer, parameter :: LEAKAGE(9) = pack(EVERY, KIND_OF == OF_LEAKAGE)           !! (axis, rod), the rod first
    integer, parameter :: LEAKAGE_RATE(9) = pack(EVERY, KIND_OF == OF_LEAKAGE_RATE)  !! As LEAKAGE, of the rates of the moments
    integer, parameter :: CHANNEL_SCALES(9) = pack(EVERY, KIND_OF == OF_CHANNEL_SCALES) !! S minus 1
    integer, parameter :: CHANNEL_LEAKAGE(9) = pack(EVERY, KIND_OF == OF_CHANNEL_LEAKAGE)  !! As LEAKAGE, into the angular channels
    integer, parameter :: CHANNEL_LEAKAGE_RATE(9) = pack(EVERY, KIND_OF == OF_CHANNEL_LEAKAGE_RATE)  !! As LEAKAGE_RATE, into them

    !> Of several accelerometers on a line (gracecg_observations_accelerometer_line): x, y, z of the first contrast, then of
    !> the second
    integer, parameter :: LINE_SCALES(6) = pack(EVERY, KIND_OF == OF_LINE_SCALES)   !! Contrasts of their scale factors
    integer, parameter :: LINE_BIAS(6) = pack(EVERY, KIND_OF == OF_LINE_BIAS)       !! Biases of the contrasts of their samples
    integer, parameter :: LINE_DRIFT(6) = pack(EVERY, KIND_OF == OF_LINE_DRIFT)     !! Drifts of these

    integer, parameter :: FORCE_SHAPES(15) = [DRAG_CURVATURE, FORCE_BENDS, SIDE_FORCE]
    !! Of forces that are no straight line in time
    integer, parameter :: TILT_AXIS(5) = [1, 2, 2, 3, 3]     !! Of the force of each of TILT
    !> Axes and degrees of FORCE_BENDS
    integer, parameter :: BEND_AXIS(12) = [1, 1, 1, 1, 2, 2, 2, 2, 2, 3, 3, 3]
    integer, parameter :: BEND_DEGREE(12) = [3, 4, 5, 6, 2, 3, 4, 5, 6, 2, 3, 4]    !! Of the polynomials

contains

    !> The name of a parameter, as in output.
    elemental function parameter_names(place) result(name)
        integer, intent(in) :: place        !! Of the parameter
        character(12) :: name

        type(parameter_kind_t) :: row

        row = KINDS(KIND_OF(place))
        name = row%stem
        if (row%members /= '-') name = trim(row%stem)//word(row%members, ' ', MEMBER_OF(place))
    end function parameter_names

    !> The SI unit of a parameter; 1 for a pure number.
    elemental function parameter_units(place) result(unit)
        integer, intent(in) :: place        !! Of the parameter
        character(8) :: unit

        unit = KINDS(KIND_OF(place))%unit
    end function parameter_units

    !> What a belief is of, in words: 'gain of rod x'; nothing if nobody believes anything of it.
    elemental function belief_subject(place) result(subject)
        integer, intent(in) :: place        !! Of the parameter
        character(48) :: subject

        type(parameter_kind_t) :: row
        integer :: at

        row = KINDS(KIND_OF(place))
        subject = row%subject
        at = index(subject, '@')
        if (at == 0) return
        if (row%members_in_words == '') then
            subject = subject(:at - 1)//word(row%members, ' ', MEMBER_OF(place))
        else
            subject = subject(:at - 1)//word(row%members_in_words, ',', MEMBER_OF(place))
        end if
    end function belief_subject

    !> The unit in which an error of a belief is shown; nothing for a ratio.
    elemental function belief_unit(place) result(unit)
        integer, intent(in) :: place        !! Of the parameter
        character(8) :: unit

        unit = KINDS(KIND_OF(place))%shown_unit
    end function belief_unit

    !> That unit in SI units.
    elemental real(dp) function belief_size(place)
        integer, intent(in) :: place        !! Of the parameter

        belief_size = KINDS(KIND_OF(place))%shown_size
    end function belief_size

    !> The largest error of a belief that is conceivable, SI units.
    elemental real(dp) function largest_error(place)
        integer, intent(in) :: place        !! Of the parameter

        largest_error = KINDS(KIND_OF(place))%largest*KINDS(KIND_OF(place))%shown_size
    end function largest_error

    !> Does a parameter act on attitude and angular velocity?
    elemental logical function is_rotational(place)
        integer, intent(in) :: place        !! Of the parameter

        is_rotational = KINDS(KIND_OF(place))%acts_on == ROTATION
    end function is_rotational

    !> Is a parameter an error of the star camera, that nothing else shows?
    elemental logical function is_of_star_camera(place)
        integer, intent(in) :: place        !! Of the parameter

        is_of_star_camera = KINDS(KIND_OF(place))%acts_on == ATTITUDE
    end function is_of_star_camera

    !> Is a parameter an error of a belief that the model has in proportion alone, by its partial where the belief holds?
    elemental logical function acts_in_proportion(place)
        integer, intent(in) :: place        !! Of the parameter

        acts_in_proportion = any(BELIEFS == place) .and. &
            .not. any(KIND_OF(place) == [OF_ROD_GAIN, OF_INERTIA, OF_TORQUE_CHANGE, OF_SCALE_FACTORS, OF_FIELD_BIAS])
    end function acts_in_proportion

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
                if (parameter_names(place) == left(:length)) exit
            end do
            if (place > 0) then
                if (any(KIND_OF(place) == [OF_ROD_SWAPS, OF_FIELD_SWAPS, OF_ACCELEROMETER_SWAPS])) place = 0
            end if
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

        sizes = KINDS(KIND_OF(places))%size/merge(duration, 1.0_dp, KINDS(KIND_OF(places))%over_arc)
    end function typical_sizes

    !> Standard deviations so large that they weigh nothing, SI units.
    pure function loose_sigmas(places) result(sigmas)
        integer, intent(in) :: places(:)    !! Of the parameters
        real(dp) :: sigmas(size(places))

        sigmas = KINDS(KIND_OF(places))%loose
    end function loose_sigmas

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
