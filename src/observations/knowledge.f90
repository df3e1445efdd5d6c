!> What an operator knows of the satellite, the manoeuvre and the instruments, and how well: all that is told
!> to an estimator beside the samples. It is knowledge and may be wrong; how to estimate is not part of it.
module gracecg_observations_knowledge
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, ARCSECOND, NANOTESLA
    use gracecg_base_error, only: number_text
    use gracecg_base_coloured_noise, only: noise_spectrum_t
    use gracecg_files_settings, only: settings_t
    use gracecg_environment_earth_orientation, only: earth_parameters_t, EARTH_ORIENTATIONS
    use gracecg_environment_time, only: utc_t
    use gracecg_environment_geomagnetic_models, only: GEOMAGNETIC_MODELS
    use gracecg_observations_accelerometer_line, only: accelerometer_line_t, describe_line
    use gracecg_observations_noise_table, only: describe_noise_spectra
    use gracecg_spacecraft_motion_limits, only: motion_limits_t
    use gracecg_spacecraft_settings, only: describe_calibration, describe_mass_properties, describe_manoeuvre, &
        describe_limits
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    implicit none
    private
    public :: operator_knowledge_t, a_priori_t, HEADS, NO_FIELD_MODEL, USUAL_DRAG
    public :: describe_satellite, describe_instruments, describe_a_priori, check_quaternion, ESTIMATION_GROUPS

    integer, parameter :: HEADS = 2     !! Star-camera heads of a satellite
    !> What stands for no field model
    character(*), parameter :: NO_FIELD_MODEL = 'none'
    !> Groups that a case file, or a setup.nml, may have beside: they say how to estimate, and the estimators read them
    character(10), parameter :: ESTIMATION_GROUPS(3) = [character(10) :: 'estimation', 'optimal', 'sequential']
    real(dp), parameter :: USUAL_DRAG = 3.5e-7_dp           !! Of air and light in four of the cases of CSR-TM-00-01, m/s^2
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
        real(dp) :: years_since_calibration = 0
        !! Of the scale factors, since the time to which their sigma belongs
        real(dp) :: scale_stability(3) = [1e-4_dp, 1e-2_dp, 2e-3_dp]
        !! Change of the scale factors in a year, relative: section 3.2.1
        real(dp) :: sigma_rod_gain = 0.005_dp
        !! Of the dipole moment of the rods, relative; not in the report
        real(dp) :: sigma_magnetometer_bias(3) = [50e-9_dp, 30e-9_dp, 25e-9_dp]     !! T
        real(dp) :: sigma_inertia = 1e-3_dp
        !! Of each element of the inertia tensor, in units of its smallest moment; not in the report
        real(dp) :: sigma_torque = 1e-6_dp
        !! Of the change of the unmodelled torque from the beginning to the end of the arc, N m: a
        !! twentieth of the air's and the Sun's torque of some 2e-5 N m in Figures 5.6 and 5.7
        real(dp) :: drag = 0
        !! Size of the acceleration by air and light, m/s^2, with which the sizes of forces grow that are no straight line
        !! (gracecg_estimation_parameters); 0: not stated
        real(dp) :: sigma_directions(3) = [0.5_dp, 0.1_dp, 0.5_dp]*DEGREE
        !! Of the axes of rods, accelerometer and magnetometer, about each other axis, rad; not in the report
        real(dp) :: sigma_magnetometer_scale = 0.01_dp
        !! Of each axis, relative; not in the report
        real(dp) :: sigma_mounting = 0.01_dp*DEGREE
        !! Of each star-camera head, about each axis, rad; not in the report
        real(dp) :: sigma_delays = 0.01_dp
        !! Of the time tags of each instrument against the commands of the rods, s; not in the report
        logical :: signs_known = .false.
        !! Which axis of rods, accelerometer and magnetometer is which, and the sign of the accelerometer's axes together,
        !! which no calibration tells, have been confirmed, by an earlier trim
    contains
        procedure :: aged_scale_sigmas  !! Those of the scale factors today
    end type a_priori_t

    !> What an operator knows of the satellite, the manoeuvre and the instruments.
    type :: operator_knowledge_t
        character(64) :: name = 'calibration'           !! For output
        type(utc_t) :: epoch                            !! Time 0 of all time tags
        real(dp) :: duration = 0                        !! Length of the arc, s
        real(dp) :: mass = 0                            !! kg
        real(dp) :: inertia(3, 3) = 0                   !! J_p about the proof-mass centre, kg m^2
        type(torque_rods_t) :: rods                     !! The manoeuvre
        type(motion_limits_t) :: limits                 !! Of the manoeuvre
        real(dp) :: accelerometer_interval = 0.1_dp     !! Sampling intervals, s
        real(dp) :: star_camera_interval = 0.5_dp       !! As above, s
        real(dp) :: magnetometer_interval = 1.0_dp      !! As above, s
        real(dp) :: mounting(4, HEADS) = 0              !! Quaternions, body to camera, scalar last
        integer :: camera = 1                           !! The head whose quaternions are used; 0: all heads'
        type(accelerometer_line_t) :: line              !! Where there are several accelerometers
        type(noise_spectrum_t) :: accelerometer_noise(3)
        !! (3-2) of each axis, or a table, m^2 s^-4/Hz; of several accelerometers that of their mean
        real(dp) :: accelerometer_scale(3) = 1          !! Sample by acceleration, as far as it is known
        real(dp) :: accelerometer_delay = 0             !! Time tag minus time of its samples, s
        real(dp) :: accelerometer_range = 0             !! Full scale, m/s^2; 0: not known
        real(dp) :: magnetometer_range = 0              !! Full scale, T; 0: not known
        real(dp) :: magnetometer_bias(3) = 0            !! Sample minus flux density, T
        real(dp) :: torque_change(3) = 0
        !! Of the torque that is not modelled, from the beginning to the end of the arc, body axes, N m
        real(dp) :: star_camera_sigma(3) = 0            !! About camera x, y, boresight, rad
        character(16) :: field_model = NO_FIELD_MODEL
        !! Geomagnetic field where the magnetometer fails: 'igrf95', 'igrf14' or 'none'
        real(dp) :: sidereal_angle = 0                  !! Greenwich, at the epoch, rad, for that model
        character(16) :: earth_orientation = 'report'   !! One of EARTH_ORIENTATIONS, for that model
        type(earth_parameters_t) :: earth_parameters    !! At the epoch, for 'iau'
        real(dp) :: angular_velocity(3) = 0
        !! At the epoch (time tag 0 of the accelerometer), body axes, rad/s, where it is known from other means
        !! than the star camera
        real(dp) :: angular_velocity_sigma(3) = 0       !! Its standard deviation, rad/s; 0: not known
        type(a_priori_t) :: a_priori                    !! How well it is known
    contains
        procedure :: knows_angular_velocity             !! It is known from other means
    end type operator_knowledge_t

contains

    !> Standard deviations of the scale factors, of their calibration and of their change since then, relative.
    pure function aged_scale_sigmas(self) result(sigmas)
        class(a_priori_t), intent(in) :: self
        real(dp) :: sigmas(3)       !! x, y, z

        sigmas = self%sigma_scale_factors
        if (self%years_since_calibration > 0) sigmas = hypot(sigmas, self%years_since_calibration*self%scale_stability)
    end function aged_scale_sigmas

    !> True when the angular velocity at the epoch is known from other means than the star camera.
    pure logical function knows_angular_velocity(self)
        class(operator_knowledge_t), intent(in) :: self

        knows_angular_velocity = all(self%angular_velocity_sigma > 0)
    end function knows_angular_velocity

    !> The settings of satellite and manoeuvre: groups calibration, mass_properties, rods, rod and limits.
    subroutine describe_satellite(settings, knowledge)
        class(settings_t), intent(inout) :: settings
        type(operator_knowledge_t), intent(inout) :: knowledge

        call describe_calibration(settings, knowledge%name, knowledge%epoch, knowledge%duration)
        call describe_mass_properties(settings, knowledge%mass, knowledge%inertia)
        call describe_manoeuvre(settings, knowledge%rods)
        call describe_limits(settings, knowledge%limits)
    end subroutine describe_satellite

    !> What an operator knows of the instruments: groups accelerometer, star_camera, magnetometer,
    !> geomagnetic_field; and angular_velocity, where that is known.
    subroutine describe_instruments(settings, knowledge)
        class(settings_t), intent(inout) :: settings
        type(operator_knowledge_t), intent(inout) :: knowledge

        integer :: head

        call settings%group('accelerometer', 'Accelerometer: sampling and noise spectrum level (1 + corner/f), or a table')
        call settings%real_value('interval', knowledge%accelerometer_interval, 1e-3_dp, 10.0_dp, 's', unit='s')
        call describe_noise_spectra(settings, knowledge%accelerometer_noise)
        call settings%real_values('scale', knowledge%accelerometer_scale, 0.1_dp, 10.0_dp, 'x, y, z: by which '// &
                                  'samples are divided')
        call settings%real_value('delay', knowledge%accelerometer_delay, -1.0_dp, 1.0_dp, &
                                 's, by which the time tags are late', unit='s')
        call settings%real_value('range', knowledge%accelerometer_range, 0.0_dp, 1.0_dp, &
                                 'm/s^2, full scale, at which samples are refused; 0: not known', unit='m/s^2')
        call settings%end_group()
        call describe_line(settings, knowledge%line)
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
        call settings%real_values('bias_nt', knowledge%magnetometer_bias, -1e6_dp, 1e6_dp, &
                                  'nT, that is taken off the samples', NANOTESLA, 'nT')
        call settings%real_value('range_nt', knowledge%magnetometer_range, 0.0_dp, 1e9_dp, &
                                 'nT, full scale, at which samples are refused; 0: not known', NANOTESLA, 'nT')
        call settings%end_group()
        call settings%group('torque', 'Torque that is not modelled: a constant one is estimated')
        call settings%real_values('change', knowledge%torque_change, -1.0_dp, 1.0_dp, &
                                  'N m, from the beginning to the end of the arc', unit='N m')
        call settings%end_group()
        if (knowledge%knows_angular_velocity() .or. settings%holds('angular_velocity')) then
            call settings%group('angular_velocity', 'At time 0, known from other means: ASSEST needs no star camera')
            call settings%real_values('value', knowledge%angular_velocity, -10.0_dp, 10.0_dp, 'rad/s, body axes', &
                                      unit='rad/s', required=.true.)
            call settings%real_values('sigma', knowledge%angular_velocity_sigma, 1e-12_dp, 1.0_dp, &
                                      'rad/s, its standard deviation', unit='rad/s', required=.true.)
            call settings%end_group()
        end if
        call settings%group('geomagnetic_field', 'Model of the field where the magnetometer fails')
        call settings%text_value('model', knowledge%field_model, 'of the field; needs the orbit', &
                                 [character(16) :: GEOMAGNETIC_MODELS, NO_FIELD_MODEL])
        call settings%real_value('sidereal_angle_deg', knowledge%sidereal_angle, -360.0_dp, 360.0_dp, &
                                 'deg, of Greenwich at the epoch', DEGREE, 'deg')
        call settings%text_value('earth_orientation', knowledge%earth_orientation, 'by that angle, or of the IAU', &
                                 EARTH_ORIENTATIONS)
        call settings%real_value('ut1_minus_utc', knowledge%earth_parameters%ut1_minus_utc, -2.0_dp, 2.0_dp, &
                                 's, at the epoch, for iau', unit='s')
        call settings%real_values('pole_arcsec', knowledge%earth_parameters%pole, -2.0_dp, 2.0_dp, &
                                  'arcsec, x and y of the pole, for iau', ARCSECOND, 'arcsec')
        call settings%end_group()
    end subroutine describe_instruments

    !> How well satellite and instruments are known: group a_priori.
    subroutine describe_a_priori(settings, a_priori)
        class(settings_t), intent(inout) :: settings
        type(a_priori_t), intent(inout) :: a_priori

        real(dp), parameter :: SMALLEST = 1e-12_dp

        call settings%group('a_priori', 'How well satellite and instruments are known: standard deviations')
        call settings%real_values('sigma_scale_factors', a_priori%sigma_scale_factors, SMALLEST, 1.0_dp, &
                                  'of the accelerometer, relative')
        call settings%real_value('years_since_calibration', a_priori%years_since_calibration, 0.0_dp, 100.0_dp, &
                                 'of the scale factors, to which their sigma belongs')
        call settings%real_values('scale_stability', a_priori%scale_stability, 0.0_dp, 1.0_dp, &
                                  'change of the scale factors in a year, relative')
        call settings%real_value('sigma_rod_gain', a_priori%sigma_rod_gain, SMALLEST, 1.0_dp, &
                                 'of all dipole moments, relative')
        call settings%real_values('sigma_magnetometer_bias', a_priori%sigma_magnetometer_bias, SMALLEST, &
                                  1e-3_dp, 'T', unit='T')
        call settings%real_value('sigma_inertia', a_priori%sigma_inertia, 0.0_dp, 1.0_dp, &
                                 'of the elements of the inertia tensor, in its smallest moment')
        call settings%real_value('sigma_torque', a_priori%sigma_torque, 0.0_dp, 1.0_dp, &
                                 'N m, of the change of the unmodelled torque over the arc', unit='N m')
        call settings%real_value('drag', a_priori%drag, 0.0_dp, 1e-3_dp, 'm/s^2, size of the acceleration by air and light; 0: '// &
                                 'not stated, then that of the models in a simulation, else 3.5e-7', unit='m/s^2')
        call settings%real_values('sigma_directions_deg', a_priori%sigma_directions, SMALLEST, 180.0_dp, &
                                  'deg, of the axes of rods, accelerometer, magnetometer', DEGREE, 'deg')
        call settings%real_value('sigma_magnetometer_scale', a_priori%sigma_magnetometer_scale, SMALLEST, 1.0_dp, &
                                 'of each axis, relative')
        call settings%real_value('sigma_mounting_deg', a_priori%sigma_mounting, SMALLEST, 180.0_dp, &
                                 'deg, of each star-camera head', DEGREE, 'deg')
        call settings%real_value('sigma_delays', a_priori%sigma_delays, SMALLEST, 10.0_dp, &
                                 's, of the time tags of each instrument against the rods', unit='s')
        call settings%logical_value('signs_known', a_priori%signs_known, &
                                    'a trim has confirmed axes and signs of the accelerometer')
        call settings%end_group()
    end subroutine describe_a_priori

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
