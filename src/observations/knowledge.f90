!> What an operator knows of the satellite, the manoeuvre and the instruments, and how well: all that is told
!> to an estimator beside the samples. It is knowledge and may be wrong; how to estimate is not part of it.
module gracecg_observations_knowledge
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE
    use gracecg_base_error, only: error_t, number_text
    use gracecg_base_coloured_noise, only: noise_spectrum_t, ONE_SIDED, TWO_SIDED
    use gracecg_files_settings, only: settings_t, FULL_RANGE
    use gracecg_environment_time, only: utc_t, parse_utc, utc_text
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_activation_t, new_torque_rods, &
        MAX_ACTIVATIONS, MAX_DIPOLE, WAVEFORM_NAMES
    use gracecg_observations_optimal_options, only: optimal_settings_t, describe_optimal
    use gracecg_observations_sequential_options, only: sequential_settings_t, describe_sequential
    implicit none
    private
    public :: operator_knowledge_t, a_priori_t, HEADS, NO_FIELD_MODEL
    public :: describe_manoeuvre, describe_instruments, describe_a_priori, describe_estimation, check_quaternion
    public :: describe_noise_spectra

    integer, parameter :: HEADS = 2     !! Star-camera heads of a satellite
    !> What stands for no field model
    character(*), parameter :: NO_FIELD_MODEL = 'none'
    !> The group of files of version 0.1 in which the keys of `a_priori` stood
    character(*), parameter :: FORMER_GROUP = 'optimal'
    real(dp), parameter :: QUATERNION_TOLERANCE = 1e-6_dp   !! Of the length of a quaternion

    !> The limits within which satellite and instruments are known: standard deviations.
    !>
    !> They serve twice: as a-priori knowledge of the parameters that are estimated, and, for those that are
    !> not, in the consider covariance of the bound. The defaults are the true errors of the simulation of
    !> CSR-TM-00-01, section 5.2, where it has such an error (scale factors, magnetometer bias); the others
    !> are said below.
    type :: a_priori_t
        real(dp) :: sigma_scale_factors(3) = [0.0101_dp, 0.0159_dp, 0.0119_dp]
        !! Of the accelerometer's scale factors, relative
        real(dp) :: sigma_rod_gain = 0.005_dp
        !! Of the dipole moment of the rods, relative; not in the report
        real(dp) :: sigma_magnetometer_bias(3) = [50e-9_dp, 30e-9_dp, 25e-9_dp]     !! T
        real(dp) :: sigma_inertia = 1e-3_dp
        !! Of each element of the inertia tensor, in units of its smallest moment; not in the report
        real(dp) :: sigma_torque = 1e-6_dp
        !! Of the change of the unmodelled torque from the beginning to the end of the arc, N m: a
        !! twentieth of the air's and the Sun's torque of some 2e-5 N m in Figures 5.6 and 5.7
    end type a_priori_t

    !> What an operator knows of the satellite, the manoeuvre and the instruments.
    type :: operator_knowledge_t
        character(64) :: name = 'calibration'           !! For output
        type(utc_t) :: epoch                            !! Time 0 of all time tags
        real(dp) :: duration = 0                        !! Length of the arc, s
        real(dp) :: mass = 0                            !! kg
        real(dp) :: inertia(3, 3) = 0                   !! J_p about the proof-mass centre, kg m^2
        type(torque_rods_t) :: rods                     !! The manoeuvre
        real(dp) :: rate_limit = 0.1_dp*DEGREE
        !! Greatest angular velocity about any axis, rad/s: what the star cameras bear, CSR-TM-00-01 4.1
        real(dp) :: pointing_limit = DEGREE
        !! Greatest turn away from the attitude that is held without a manoeuvre, rad
        real(dp) :: accelerometer_interval = 0.1_dp     !! Sampling intervals, s
        real(dp) :: star_camera_interval = 0.5_dp       !! As above, s
        real(dp) :: magnetometer_interval = 1.0_dp      !! As above, s
        real(dp) :: mounting(4, HEADS) = 0              !! Quaternions, body to camera, scalar last
        integer :: camera = 1                           !! The head whose quaternions are used
        type(noise_spectrum_t) :: accelerometer_noise(3)    !! (3-2) of each axis, m^2 s^-4/Hz
        real(dp) :: star_camera_sigma(3) = 0            !! About camera x, y, boresight, rad
        character(16) :: field_model = NO_FIELD_MODEL
        !! Geomagnetic field where the magnetometer fails: 'igrf95', 'igrf14' or 'none'
        real(dp) :: sidereal_angle = 0                  !! Greenwich, at the epoch, rad, for that model
        type(a_priori_t) :: a_priori                    !! How well it is known
        real(dp) :: guess_quaternion(4) = 0             !! Initial guess at the epoch, inertial to body
        real(dp) :: guess_angular_velocity(3) = 0       !! rad/s
        real(dp) :: guess_offset(3) = 0                 !! d*, m
        real(dp) :: accelerometer_weight(3) = 1         !! Diagonal of the report's weight matrix
        real(dp) :: star_camera_weight = 1              !! Of every attitude component, ASSEST
        real(dp) :: combined_star_camera_weight = 90    !! The same, ASCFEST and ASCREST
        type(optimal_settings_t) :: optimal             !! Of the estimator `optimal`
        type(sequential_settings_t) :: sequential       !! Of the estimator `sequential`
    end type operator_knowledge_t

contains

    !> The settings of satellite and manoeuvre: groups calibration, mass_properties, rod and
    !> limits.
    subroutine describe_manoeuvre(settings, knowledge)
        class(settings_t), intent(inout) :: settings
        type(operator_knowledge_t), intent(inout) :: knowledge

        character(40) :: epoch
        real(dp) :: moments(3), products(3)
        type(error_t), allocatable :: problem

        epoch = utc_text(knowledge%epoch)
        call settings%group('calibration', 'The calibration: arc and time')
        call settings%text_value('name', knowledge%name, 'of the calibration')
        call settings%text_value('epoch', epoch, 'UTC, ISO 8601: time 0 of all time tags', required=.true.)
        call parse_utc(trim(epoch), knowledge%epoch, problem)
        if (allocated(problem)) call settings%reject('epoch', problem%message)
        call settings%real_value('duration', knowledge%duration, 1.0_dp, 86400.0_dp, 's, length of the arc', &
                                 unit='s')
        call settings%end_group()

        moments = [knowledge%inertia(1, 1), knowledge%inertia(2, 2), knowledge%inertia(3, 3)]
        products = [knowledge%inertia(1, 2), knowledge%inertia(2, 3), knowledge%inertia(1, 3)]
        call settings%group('mass_properties', 'Mass, and inertia about the proof-mass centre')
        call settings%real_value('mass', knowledge%mass, 1e-3_dp, 1e6_dp, 'kg', unit='kg', required=.true.)
        call settings%real_values('moments_of_inertia', moments, 1e-6_dp, 1e9_dp, &
                                  'Ixx, Iyy, Izz in kg m^2', unit='kg m^2', required=.true.)
        call settings%real_values('products_of_inertia', products, -1e9_dp, 1e9_dp, &
                                  'Ixy, Iyz, Izx in kg m^2, with the sign of Ixy = -integral of x y dm', &
                                  unit='kg m^2')
        call settings%end_group()
        knowledge%inertia = reshape([moments(1), products(1), products(3), &
                                 products(1), moments(2), products(2), &
                                 products(3), products(2), moments(3)], [3, 3])
        call describe_rods(settings, knowledge%rods)
        call settings%group('limits', 'What the manoeuvre may do to the satellite')
        call settings%real_value('rate_deg_s', knowledge%rate_limit, 1e-6_dp, 1e3_dp, &
                                 'deg/s, angular velocity about any axis (star cameras)', DEGREE, 'deg/s')
        call settings%real_value('pointing_deg', knowledge%pointing_limit, 1e-6_dp, 180.0_dp, &
                                 'deg, turn away from the attitude held without a manoeuvre', DEGREE, 'deg')
        call settings%end_group()
    end subroutine describe_manoeuvre

    !> The manoeuvre: one group `rod` for each activation of a torque rod.
    subroutine describe_rods(settings, rods)
        class(settings_t), intent(inout) :: settings
        type(torque_rods_t), intent(inout) :: rods

        type(rod_activation_t) :: activations(MAX_ACTIVATIONS)
        type(error_t), allocatable :: problem
        character(len(WAVEFORM_NAMES)) :: waveform
        integer :: n, i

        n = rods%count
        activations = rods%activations
        call settings%count('rod', n)
        if (n > MAX_ACTIVATIONS) then
            call settings%group('rod', '', MAX_ACTIVATIONS + 1)
            call settings%reject('axis', 'at most 16 groups &rod are allowed')
            return
        end if
        do i = 1, n
            call settings%group('rod', 'Magnetic moment amplitude w(2 pi frequency (t - start) + phase)', i)
            call settings%integer_value('axis', activations(i)%axis, 1, 3, 'body axis: 1 x, 2 y, 3 z')
            call settings%real_value('amplitude', activations(i)%amplitude, -MAX_DIPOLE, MAX_DIPOLE, &
                                     'A m^2', unit='A m^2', required=.true.)
            call settings%real_value('frequency', activations(i)%frequency, 0.0_dp, 10.0_dp, 'Hz', &
                                     unit='Hz', required=.true.)
            call settings%real_value('phase_deg', activations(i)%phase, -360.0_dp, 360.0_dp, 'deg', &
                                     DEGREE, 'deg')
            call settings%real_value('start', activations(i)%start, 0.0_dp, 86400.0_dp, 's', unit='s')
            call settings%real_value('stop', activations(i)%stop, 0.0_dp, 86400.0_dp, 's', unit='s', &
                                     required=.true.)
            waveform = WAVEFORM_NAMES(activations(i)%waveform)
            call settings%text_value('waveform', waveform, 'w', WAVEFORM_NAMES)
            activations(i)%waveform = max(1, findloc(WAVEFORM_NAMES, waveform, 1))
            call settings%real_value('taper', activations(i)%taper, 0.0_dp, 86400.0_dp, &
                                     's, of a smooth start and stop; 0: abrupt', unit='s')
            call settings%real_value('rise_time', activations(i)%rise_time, 0.0_dp, 86400.0_dp, &
                                     's, of each edge of a square wave', unit='s')
            if (allocated(settings%failure)) return
            call new_torque_rods(rods, activations(:i), problem)
            if (allocated(problem)) call settings%reject('amplitude', problem%message)
            call settings%end_group()
        end do
        if (n == 0) rods%count = 0
    end subroutine describe_rods

    !> What an operator knows of the instruments: groups accelerometer, star_camera, magnetometer,
    !> geomagnetic_field.
    subroutine describe_instruments(settings, knowledge)
        class(settings_t), intent(inout) :: settings
        type(operator_knowledge_t), intent(inout) :: knowledge

        integer :: head

        call settings%group('accelerometer', 'Accelerometer: sampling and noise spectrum level (1 + corner/f)')
        call settings%real_value('interval', knowledge%accelerometer_interval, 1e-3_dp, 10.0_dp, 's', unit='s')
        call describe_noise_spectra(settings, knowledge%accelerometer_noise)
        call settings%end_group()
        call settings%group('star_camera', 'Star camera: mounting and noise')
        call settings%real_value('interval', knowledge%star_camera_interval, 1e-3_dp, 100.0_dp, 's', unit='s')
        call settings%integer_value('head', knowledge%camera, 1, HEADS, 'whose quaternions are used')
        call settings%real_values('noise_about_axes', knowledge%star_camera_sigma, 0.0_dp, 1.0_dp, &
                                  'rad, about camera x, y and boresight', unit='rad')
        do head = 1, HEADS
            call settings%real_values(merge('mounting_1', 'mounting_2', head == 1), &
                                      knowledge%mounting(:, head), -1.0_dp, 1.0_dp, &
                                      'quaternion body to camera, scalar last', required=.true.)
            call check_quaternion(settings, merge('mounting_1', 'mounting_2', head == 1), &
                                  knowledge%mounting(:, head))
        end do
        call settings%end_group()
        call settings%group('magnetometer', 'Magnetometer')
        call settings%real_value('interval', knowledge%magnetometer_interval, 1e-3_dp, 100.0_dp, 's', unit='s')
        call settings%end_group()
        call settings%group('geomagnetic_field', 'Model of the field where the magnetometer fails')
        call settings%text_value('model', knowledge%field_model, 'of the field; needs the orbit', &
                                 [character(6) :: 'igrf95', 'igrf14', NO_FIELD_MODEL])
        call settings%real_value('sidereal_angle_deg', knowledge%sidereal_angle, -360.0_dp, 360.0_dp, &
                                 'deg, of Greenwich at the epoch', DEGREE, 'deg')
        call settings%end_group()
    end subroutine describe_instruments

    !> The noise spectra of the accelerometer's axes, within a group.
    subroutine describe_noise_spectra(settings, noise)
        class(settings_t), intent(inout) :: settings
        type(noise_spectrum_t), intent(inout) :: noise(3)   !! x, y, z; the sides of all are those of x

        call settings%real_values('noise_level', noise%level, 0.0_dp, 1.0_dp, 'm^2 s^-4/Hz', unit='m^2 s^-4/Hz')
        call settings%real_values('noise_corner', noise%corner, 0.0_dp, 100.0_dp, 'Hz', unit='Hz')
        call settings%integer_value('noise_sides', noise(1)%sides, ONE_SIDED, TWO_SIDED, &
                                    'the spectrum is one- (1) or two-sided (2)')
        noise%sides = noise(1)%sides
    end subroutine describe_noise_spectra

    !> How well satellite and instruments are known: group a_priori. Files of version 0.1 have its keys in
    !> another group.
    subroutine describe_a_priori(settings, a_priori)
        class(settings_t), intent(inout) :: settings
        type(a_priori_t), intent(inout) :: a_priori

        if (settings%holds(FORMER_GROUP)) call describe_sigmas(settings, FORMER_GROUP, a_priori)
        call describe_sigmas(settings, 'a_priori', a_priori)
    end subroutine describe_a_priori

    subroutine describe_sigmas(settings, group, a_priori)
        class(settings_t), intent(inout) :: settings
        character(*), intent(in) :: group
        type(a_priori_t), intent(inout) :: a_priori

        real(dp), parameter :: SMALLEST = 1e-12_dp

        call settings%group(group, 'How well satellite and instruments are known: standard deviations')
        call settings%real_values('sigma_scale_factors', a_priori%sigma_scale_factors, SMALLEST, 1.0_dp, &
                                  'of the accelerometer, relative')
        call settings%real_value('sigma_rod_gain', a_priori%sigma_rod_gain, SMALLEST, 1.0_dp, &
                                 'of all dipole moments, relative')
        call settings%real_values('sigma_magnetometer_bias', a_priori%sigma_magnetometer_bias, SMALLEST, &
                                  1e-3_dp, 'T', unit='T')
        call settings%real_value('sigma_inertia', a_priori%sigma_inertia, 0.0_dp, 1.0_dp, &
                                 'of the elements of the inertia tensor, in its smallest moment')
        call settings%real_value('sigma_torque', a_priori%sigma_torque, 0.0_dp, 1.0_dp, &
                                 'N m, of the change of the unmodelled torque over the arc', unit='N m')
        call settings%end_group()
    end subroutine describe_sigmas

    !> Initial guesses and weights: groups estimation, optimal and sequential.
    subroutine describe_estimation(settings, knowledge)
        class(settings_t), intent(inout) :: settings
        type(operator_knowledge_t), intent(inout) :: knowledge

        call settings%group('estimation', 'Initial guesses and weights of the estimators')
        call settings%real_values('guess_quaternion', knowledge%guess_quaternion, -1.0_dp, 1.0_dp, &
                                  'inertial to body, scalar last; normalised before use', required=.true.)
        if (.not. norm2(knowledge%guess_quaternion) > 0.5_dp) then
            call settings%reject('guess_quaternion', 'is too far from unit length')
        end if
        call settings%real_values('guess_angular_velocity', knowledge%guess_angular_velocity, -1.0_dp, 1.0_dp, &
                                  'rad/s', unit='rad/s', required=.true.)
        call settings%real_values('guess_offset_mm', knowledge%guess_offset, -1000.0_dp, 1000.0_dp, 'mm', &
                                  1e-3_dp, 'mm')
        call settings%real_values('accelerometer_weight', knowledge%accelerometer_weight, tiny(1.0_dp), &
                                  FULL_RANGE, 'of the axes')
        call settings%real_value('star_camera_weight', knowledge%star_camera_weight, tiny(1.0_dp), FULL_RANGE, &
                                 'of every attitude component, ASSEST')
        call settings%real_value('combined_star_camera_weight', knowledge%combined_star_camera_weight, &
                                 tiny(1.0_dp), FULL_RANGE, 'of every attitude component, ASCFEST and ASCREST')
        call settings%end_group()
        call describe_optimal(settings, knowledge%optimal)
        call describe_sequential(settings, knowledge%sequential)
    end subroutine describe_estimation

    !> Refuses a quaternion that is not of unit length.
    subroutine check_quaternion(settings, key, quaternion)
        class(settings_t), intent(inout) :: settings
        character(*), intent(in) :: key         !! Name of the key, for the message
        real(dp), intent(in) :: quaternion(4)   !! Scalar last

        if (.not. abs(norm2(quaternion) - 1) <= QUATERNION_TOLERANCE) then
            call settings%reject(key, 'is not a unit quaternion: its length is '// &
                                 number_text(norm2(quaternion))//'; allowed is 1 within 1e-6')
        end if
    end subroutine check_quaternion
end module gracecg_observations_knowledge
