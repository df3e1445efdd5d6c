!> A calibration case: everything that a simulation needs, as a person states it.
!>
!> It holds the truth (satellite, initial state, environment) and, apart from it, what the operator goes by.
!> The defaults are the values of CSR-TM-00-01 section 5.2 as printed; what was fitted to its
!> figures stands in the built-in cases (gracecg_simulation_report_cases). A case is read from and
!> written to a namelist file (`describe_case`), and turned into models by gracecg_simulation_case_models.
module gracecg_simulation_case
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, KILOMETRE
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_quaternion, only: normalised
    use gracecg_files_run_record, only: add_to_hash, EMPTY_HASH
    use gracecg_files_settings, only: settings_t
    use gracecg_environment_earth_orientation, only: earth_parameters_t, earth_orientation_t, new_earth_orientation, &
        EARTH_ORIENTATIONS
    use gracecg_environment_iers_file, only: read_earth_parameters
    use gracecg_environment_time, only: utc_t, gmst_1982
    use gracecg_environment_thermosphere, only: density_wave_t, REPORT_WAVE_AMPLITUDE, REPORT_WAVE_PERIOD
    use gracecg_environment_gravity_models, only: GRAVITY_MODELS
    use gracecg_environment_geomagnetic_models, only: GEOMAGNETIC_MODELS
    use gracecg_environment_density_models, only: DENSITY_MODELS
    use gracecg_environment_space_weather, only: SPACE_WEATHER_SOURCES
    use gracecg_environment_wind_models, only: WIND_MODELS
    use gracecg_environment_earth_radiation, only: DEFAULT_SOLAR_IRRADIANCE, EARTH_RADIATION_CONSTANTS, SEGMENT_CENTRES
    use gracecg_spacecraft_motion_limits, only: motion_limits_t
    use gracecg_spacecraft_settings, only: describe_calibration, describe_mass_properties, describe_manoeuvre, &
        describe_limits
    use gracecg_spacecraft_rod_pattern, only: AS_DRIVEN
    use gracecg_spacecraft_moment_series, only: has_moments, check_moments_cover
    use gracecg_spacecraft_torque_rods, only: check_rod_sampling
    use gracecg_observations_knowledge, only: describe_a_priori, ESTIMATION_GROUPS
    use gracecg_simulation_arc, only: DEFAULT_TOLERANCE
    use gracecg_simulation_attitude_control, only: attitude_control_t, describe_control, check_control
    use gracecg_observations_accelerometer_line, only: describe_line
    use gracecg_simulation_satellite, only: satellite_t, describe_surface, describe_accelerometer, &
        describe_star_camera, describe_magnetometer
    use gracecg_simulation_operator_errors, only: operator_t, describe_operator
    use gracecg_simulation_stated_start, only: stated_start_t, describe_start, find_start
    implicit none
    private
    public :: case_t, read_case, case_from_text, case_text, LEVEL1_GROUPS
    public :: earth_orientation_name, find_earth_parameters, flies_under_control, sidereal_angle_at_epoch

    !> Of the orientation of the Earth: 'iau' from the year 2000 on, unless the sidereal angle is given; of the geomagnetic
    !> field: 'igrf95' before, 'igrf14' from then on
    character(*), parameter :: BY_DATE = 'by-date'
    integer, parameter :: HIGHEST_NUMBER = 9999         !! That a case may be given
    integer, parameter :: MJD_2000 = 51544              !! 2000-01-01
    !> Groups of simulated Level-1 files, which may stand in the same file
    character(18), parameter :: LEVEL1_GROUPS(2) = [character(18) :: 'level1_simulation', 'level1_span']

    !> How the truth is integrated, all by Runge-Kutta-Fehlberg 7(8): in one step an interval up to LONG_ARC and in
    !> steps under control beyond; in one step an interval; in steps under control
    character(16), parameter :: INTEGRATORS(3) = [character(16) :: 'rkf78', 'rkf78-fixed', 'rkf78-controlled']
    real(dp), parameter :: LONG_ARC = 600               !! In s, ten times the report's; beyond, steps under control save much time

    !> A calibration with everything that a simulation must know: one namelist file.
    type :: case_t
        character(64) :: name = 'calibration'       !! For output
        integer :: number = 0                       !! Labels its random numbers: 1..3 in the report; 0: the name does
        type(utc_t) :: epoch                        !! Time 0
        real(dp) :: duration = 0                    !! Length of the arc, s
        character(8) :: pattern_rule = AS_DRIVEN    !! Of the rods, where they are chosen: one of PATTERN_RULES
        type(satellite_t) :: satellite              !! The truth
        type(operator_t) :: operator                !! What its operator goes by, and where that is wrong
        type(motion_limits_t) :: limits             !! Of the manoeuvre
        type(attitude_control_t) :: control         !! Of the satellite, beside the manoeuvre
        ! initial state
        type(stated_start_t) :: start               !! How a file states it
        real(dp) :: position(3) = 0                 !! Inertial J2000, m
        real(dp) :: velocity(3) = 0                 !! m/s
        real(dp) :: quaternion(4) = 0               !! Inertial to body, scalar last
        real(dp) :: angular_velocity(3) = 0         !! Body axes, rad/s
        ! integration
        real(dp) :: interval = 0.1_dp               !! Of the truth's epochs, s
        character(16) :: integrator = INTEGRATORS(1)    !! One of INTEGRATORS
        real(dp) :: tolerance = DEFAULT_TOLERANCE   !! Of the step control
        ! Earth
        character(16) :: earth_rotation = 'gmst-1982' !! Sidereal angle at the epoch: 'given' or 'gmst-1982'
        real(dp) :: sidereal_angle = 0              !! rad, if given
        real(dp) :: ut1_minus_utc = 0               !! s, for gmst-1982 and iau
        character(16) :: earth_orientation = BY_DATE    !! One of EARTH_ORIENTATIONS, or BY_DATE
        character(256) :: earth_orientation_file = ''   !! Of the IERS: UT1 and pole, for 'iau'
        type(earth_parameters_t) :: earth_parameters    !! At the epoch, of that file
        character(16) :: gravity_model = 'egm96'  !! 'egm96', 'point-mass' or 'file'
        character(256) :: gravity_file = ''   !! ICGEM .gfc
        integer :: gravity_degree = 20, gravity_order = 20  !! Up to which the sum goes
        character(16) :: field_model = 'igrf95'    !! 'igrf95', 'igrf14' or 'file'
        character(256) :: field_file = ''     !! .shc
        ! atmosphere
        character(16) :: density_model = 'dtm77'  !! One of DENSITY_MODELS or 'none'
        real(dp) :: density_scale = 1               !! Factor of the model's density
        character(16) :: space_weather = 'table'  !! 'table', 'given' or 'file'
        character(256) :: space_weather_file = ''   !! Of days, flux and Kp, if 'file'
        real(dp) :: f107 = 150, f107_mean = 150     !! sfu, if given
        real(dp) :: kp = 2                          !! If given
        real(dp) :: reference_density = 4e-12_dp    !! Exponential model, kg/m^3
        real(dp) :: reference_height = 466e3_dp     !! m
        real(dp) :: scale_height = 65e3_dp          !! m
        type(density_wave_t) :: density_wave = density_wave_t(REPORT_WAVE_AMPLITUDE, REPORT_WAVE_PERIOD, 0.0_dp)
        !! Relative to the model's density: amplitude, period (s), phase (rad)
        logical :: density_wave_random = .true.     !! The phase is drawn for every run
        character(16) :: wind_model = 'hwm93-smooth'      !! Of WIND_MODELS, 'none' or 'file'
        character(256) :: wind_file = ''            !! Of latitudes and local times, if 'file'
        real(dp) :: wind_east = 0, wind_north = 0   !! m/s, if constant
        ! radiation
        real(dp) :: solar_irradiance = DEFAULT_SOLAR_IRRADIANCE     !! At 1 au, W/m^2
        character(20) :: earth_radiation_constants = 'report'
        !! 'report', 'knocke' or 'constant-emissivity'
        character(16) :: earth_radiation_centres = 'half-solid-angle'   !! One of SEGMENT_CENTRES
        integer :: earth_radiation_rings = 1
        !! Of segments about the cap below the satellite, 0 to 7
        ! instruments
        character(256) :: star_catalogue_file = ''    !! Empty: the embedded catalogue
    contains
        procedure :: label                          !! Names its random numbers
    end type case_t

contains

    !> The case's label in the names of random streams (gracecg_base_random): its number, or one of its name, above all numbers.
    pure integer function label(self)
        class(case_t), intent(in) :: self

        integer(i8) :: hash

        hash = EMPTY_HASH
        call add_to_hash(trim(self%name), hash)
        label = self%number
        if (label == 0) label = HIGHEST_NUMBER + 1 + int(modulo(hash, int(huge(1) - HIGHEST_NUMBER, i8)))
    end function label

    !> Reads a case from a namelist file. Fails, with file, line and key, for a key that is not known,
    !> a wrong type, a missing value or a value outside its range.
    subroutine read_case(path, case, error)
        character(*), intent(in) :: path    !! Of the namelist file
        type(case_t), intent(out) :: case
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: settings

        call settings%open(path, error)
        if (.not. allocated(error)) call take_case(settings, path, case, error)
    end subroutine read_case

    !> A case from the text of a case file; `name` stands for the file in messages. Fails as `read_case`.
    subroutine case_from_text(text, name, case, error)
        character(*), intent(in) :: text, name  !! Content; what stands for the file in messages
        type(case_t), intent(out) :: case
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: settings

        call settings%open_text(text, name, error)
        if (.not. allocated(error)) call take_case(settings, name, case, error)
    end subroutine case_from_text

    subroutine take_case(settings, name, case, error)
        type(settings_t), intent(inout) :: settings
        character(*), intent(in) :: name        !! Of the file, for messages
        type(case_t), intent(inout) :: case
        type(error_t), allocatable, intent(out) :: error

        type(earth_orientation_t) :: earth

        case%field_model = BY_DATE
        call describe_case(settings, case)
        if (case%field_model == BY_DATE) case%field_model = GEOMAGNETIC_MODELS(merge(1, 2, case%epoch%mjd < MJD_2000))
        call settings%finish(error, others=[character(len(LEVEL1_GROUPS)) :: ESTIMATION_GROUPS, LEVEL1_GROUPS])
        if (allocated(error)) return
        call check_rod_sampling(case%satellite%rods, case%satellite%accelerometer%sampling_interval, error)
        if (.not. allocated(error)) call check_control(case%control, case%satellite%rods, error)
        if (.not. allocated(error) .and. has_moments(case%satellite%rods%measured)) &
            call check_moments_cover(case%satellite%rods%measured, case%duration, error)
        call add_context(error, name)
        if (allocated(error)) return
        call find_earth_parameters(case, case%earth_parameters, error)
        if (.not. allocated(error)) &
            call new_earth_orientation(trim(earth_orientation_name(case)), case%epoch, sidereal_angle_at_epoch(case), &
                                       case%earth_parameters, earth, error)
        if (.not. allocated(error)) &
            call find_start(case%start, case%epoch, case%earth_parameters%ut1_minus_utc, earth, case%position, case%velocity, &
                            case%quaternion, case%angular_velocity, error)
        ! One that is of unit length to rounding stays as it is: a written case reads back exactly.
        if (abs(norm2(case%quaternion) - 1) > 4*epsilon(1.0_dp)) case%quaternion = normalised(case%quaternion)
        call add_context(error, name)
    end subroutine take_case

    !> The orientation of the Earth that a case has: one of EARTH_ORIENTATIONS, or what it was given.
    pure function earth_orientation_name(case) result(name)
        type(case_t), intent(in) :: case
        character(16) :: name

        name = case%earth_orientation
        if (name /= BY_DATE) return
        name = 'report'
        if (case%epoch%mjd >= MJD_2000 .and. case%earth_rotation /= 'given') name = 'iau'
    end function earth_orientation_name

    !> Of Greenwich, rad.
    pure real(dp) function sidereal_angle_at_epoch(case) result(angle)
        type(case_t), intent(in) :: case

        angle = case%sidereal_angle
        if (case%earth_rotation /= 'given') angle = gmst_1982(case%epoch, case%ut1_minus_utc)
    end function sidereal_angle_at_epoch

    !> Are the steps of a case's truth under control, and not one an interval?
    pure logical function flies_under_control(case)
        type(case_t), intent(in) :: case

        flies_under_control = case%integrator == INTEGRATORS(3) .or. &
                              case%integrator == INTEGRATORS(1) .and. case%duration > LONG_ARC
    end function flies_under_control

    !> UT1 and the pole of a case: of its file, or as given. Fails as `read_earth_parameters`.
    subroutine find_earth_parameters(case, parameters, error)
        type(case_t), intent(in) :: case
        type(earth_parameters_t), intent(out) :: parameters
        type(error_t), allocatable, intent(out) :: error

        parameters%ut1_minus_utc = case%ut1_minus_utc
        if (case%earth_orientation_file == '') return
        call read_earth_parameters(trim(case%earth_orientation_file), case%epoch, parameters, error)
    end subroutine find_earth_parameters

    !> The namelist text of a case: what `read_case` reads. Fails when a setting is not finite.
    subroutine case_text(case, text, error)
        type(case_t), intent(in) :: case
        character(:), allocatable, intent(out) :: text  !! Lines separated by line feeds
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: settings
        type(case_t) :: copy

        copy = case
        call describe_case(settings, copy)
        call settings%to_text(text, error)
    end subroutine case_text

    !> Every setting of a case, with its unit and range.
    subroutine describe_case(settings, case)
        class(settings_t), intent(inout) :: settings
        type(case_t), intent(inout) :: case

        call describe_calibration(settings, case%name, case%epoch, case%duration, case%pattern_rule)
        call describe_mass_properties(settings, case%satellite%mass, case%satellite%inertia)
        call describe_manoeuvre(settings, case%satellite%rods)
        call describe_limits(settings, case%limits)
        call describe_control(settings, case%control)
        call describe_state(settings, case)
        call describe_earth(settings, case)
        call describe_atmosphere(settings, case)
        call describe_surface(settings, case%satellite)
        call describe_radiation(settings, case)
        call describe_accelerometer(settings, case%satellite%accelerometer)
        call describe_line(settings, case%satellite%line)
        call describe_star_camera(settings, case%satellite%star_camera, case%star_catalogue_file, case%operator%head)
        call describe_magnetometer(settings, case%satellite%magnetometer)
        call describe_operator(settings, case%operator)
        call describe_a_priori(settings, case%operator%a_priori)
    end subroutine describe_case

    subroutine describe_state(settings, case)
        class(settings_t), intent(inout) :: settings
        type(case_t), intent(inout) :: case

        call settings%group('truth', 'The true state at the epoch, and how it is integrated')
        call settings%text_value('satellite', case%satellite%name, 'of the pair', &
                                 [character(16) :: 'front', 'back'])
        call settings%integer_value('number', case%number, 0, HIGHEST_NUMBER, 'of the case: labels its random '// &
                                    'numbers; 0: its name does')
        call settings%real_values('offset_mm', case%satellite%offset, -10.0_dp, 10.0_dp, &
                                  'mm, from the centre of mass to the proof-mass centre', MILLIMETRE, 'mm')
        call describe_start(settings, case%start, case%position, case%velocity, case%quaternion, case%angular_velocity)
        call settings%real_value('interval', case%interval, 1e-3_dp, 10.0_dp, 's, of the true arc', unit='s')
        call settings%text_value('integrator', case%integrator, 'Runge-Kutta-Fehlberg 7(8): one step an interval up to '// &
                                 '600 s, steps under control beyond; or always the one or the other', INTEGRATORS)
        call settings%real_value('tolerance', case%tolerance, 1e-15_dp, 1e-3_dp, 'of the step control')
        call settings%end_group()
    end subroutine describe_state

    subroutine describe_earth(settings, case)
        class(settings_t), intent(inout) :: settings
        type(case_t), intent(inout) :: case

        call settings%group('earth', 'Rotation, gravity and magnetic field of the Earth')
        call settings%text_value('rotation', case%earth_rotation, 'sidereal angle at the epoch', &
                                 [character(16) :: 'given', 'gmst-1982'])
        call settings%real_value('sidereal_angle_deg', case%sidereal_angle, -360.0_dp, 360.0_dp, &
                                 'deg, if given', DEGREE, 'deg')
        call settings%real_value('ut1_minus_utc', case%ut1_minus_utc, -1.0_dp, 1.0_dp, 's, for gmst-1982 and iau', &
                                 unit='s')
        call settings%text_value('earth_orientation', case%earth_orientation, 'precession, nutation, pole: of the '// &
                                 'report (none), of the IAU, or iau from 2000 on', &
                                 [character(16) :: BY_DATE, EARTH_ORIENTATIONS])
        if (case%earth_orientation == 'iau' .and. case%earth_rotation == 'given') then
            call settings%reject('earth_orientation', '= ''iau'' computes the angle of the Earth: leave out rotation = ''given''')
        end if
        call settings%text_value('earth_orientation_file', case%earth_orientation_file, 'finals2000A or EOP C04 of '// &
                                 'the IERS: UT1 and pole, for iau')
        if (case%earth_orientation_file /= '') then
            if (earth_orientation_name(case) /= 'iau') then
                call settings%reject('earth_orientation_file', 'names a file that is not used: write '// &
                                     'earth_orientation = ''iau'' to use it, or leave it empty')
            else if (abs(case%ut1_minus_utc) > 0) then
                call settings%reject('ut1_minus_utc', 'is given beside a file that has it: leave one of them out')
            end if
        end if
        call settings%text_value('gravity', case%gravity_model, 'geopotential', &
                                 [character(16) :: GRAVITY_MODELS, 'file'])
        call settings%text_value('gravity_file', case%gravity_file, 'ICGEM .gfc file')
        call check_file_key(settings, 'gravity', case%gravity_model, case%gravity_file)
        call settings%integer_value('degree', case%gravity_degree, 0, 360, 'of the geopotential')
        call settings%integer_value('order', case%gravity_order, 0, 360, 'of the geopotential')
        call settings%text_value('magnetic_field', case%field_model, 'geomagnetic field; left out: igrf14 from 2000 on, '// &
                                 'else igrf95', [character(16) :: BY_DATE, GEOMAGNETIC_MODELS, 'file'])
        call settings%text_value('magnetic_field_file', case%field_file, 'SHC file')
        call check_file_key(settings, 'magnetic_field', case%field_model, case%field_file)
        call settings%end_group()
    end subroutine describe_earth

    !> A model from a file needs the file's name, and a name asks for that model: a file that is named
    !> and not used would go unnoticed.
    subroutine check_file_key(settings, key, choice, path)
        class(settings_t), intent(inout) :: settings
        character(*), intent(in) :: key     !! That chooses the model; key_file names the file
        character(*), intent(in) :: choice, path

        if (choice == 'file' .and. path == '') then
            call settings%reject(key//'_file', 'names no file, but '//key//' = ''file''')
        else if (choice /= 'file' .and. path /= '') then
            call settings%reject(key//'_file', 'names a file that is not used: write '//key// &
                                 ' = ''file'' to use it, or leave it empty')
        end if
    end subroutine check_file_key

    subroutine describe_atmosphere(settings, case)
        class(settings_t), intent(inout) :: settings
        type(case_t), intent(inout) :: case

        call settings%group('atmosphere', 'Density and wind')
        call settings%text_value('density', case%density_model, 'thermosphere model', &
                                 [character(16) :: DENSITY_MODELS, 'none'])
        call settings%real_value('density_scale', case%density_scale, 0.0_dp, 100.0_dp, &
                                 'factor of the model''s density')
        call settings%text_value('space_weather', case%space_weather, 'solar flux and Kp of the date', &
                                 SPACE_WEATHER_SOURCES)
        call settings%text_value('space_weather_file', case%space_weather_file, 'if file')
        call check_file_key(settings, 'space_weather', case%space_weather, case%space_weather_file)
        call settings%real_value('f107', case%f107, 50.0_dp, 500.0_dp, 'sfu, of the day before, if given', &
                                 unit='sfu')
        call settings%real_value('f107_mean', case%f107_mean, 50.0_dp, 500.0_dp, 'sfu, 81-day mean, if given', &
                                 unit='sfu')
        call settings%real_value('kp', case%kp, 0.0_dp, 9.0_dp, '3 hours before, if given')
        call settings%real_value('reference_density', case%reference_density, 0.0_dp, 1.0_dp, &
                                 'kg/m^3, exponential model', unit='kg/m^3')
        call settings%real_value('reference_height_km', case%reference_height, 0.0_dp, 1e5_dp, &
                                 'km, exponential model', KILOMETRE, 'km')
        call settings%real_value('scale_height_km', case%scale_height, 1e-3_dp, 1e5_dp, &
                                 'km, exponential model', KILOMETRE, 'km')
        call settings%real_value('density_wave_amplitude', case%density_wave%amplitude, 0.0_dp, 1.0_dp, &
                                 'of the short-period density perturbation, relative to the model''s density')
        call settings%real_value('density_wave_period', case%density_wave%period, 1e-3_dp, 1e6_dp, 's', &
                                 unit='s')
        call settings%real_value('density_wave_phase_deg', case%density_wave%phase, -360.0_dp, 360.0_dp, &
                                 'deg', DEGREE, 'deg')
        call settings%logical_value('density_wave_random', case%density_wave_random, &
                                    'draw the phase anew for every run')
        call settings%text_value('wind', case%wind_model, 'horizontal wind; hwm93 is linear between its points, with kinks', &
                                 [character(16) :: WIND_MODELS, 'none', 'file'])
        call settings%text_value('wind_file', case%wind_file, 'if file')
        call check_file_key(settings, 'wind', case%wind_model, case%wind_file)
        call settings%real_value('wind_east', case%wind_east, -2000.0_dp, 2000.0_dp, 'm/s, if constant', &
                                 unit='m/s')
        call settings%real_value('wind_north', case%wind_north, -2000.0_dp, 2000.0_dp, 'm/s, if constant', &
                                 unit='m/s')
        call settings%end_group()
    end subroutine describe_atmosphere

    subroutine describe_radiation(settings, case)
        class(settings_t), intent(inout) :: settings
        type(case_t), intent(inout) :: case

        call settings%group('radiation', 'Radiation of Sun and Earth')
        call settings%real_value('solar_irradiance', case%solar_irradiance, 1.0_dp, 1e4_dp, 'W/m^2 at 1 au', &
                                 unit='W/m^2')
        call settings%real_value('reflectivity_sun', case%satellite%reflectivity_sun, 0.0_dp, 2.0_dp, &
                                 'eta of the solar radiation pressure')
        call settings%text_value('earth_constants', case%earth_radiation_constants, 'albedo and emissivity', &
                                 EARTH_RADIATION_CONSTANTS)
        call settings%integer_value('earth_rings', case%earth_radiation_rings, 0, 7, &
                                    'of 6, 12, 18 ... segments around the cap')
        call settings%text_value('earth_centres', case%earth_radiation_centres, 'of the segments of a ring', &
                                 SEGMENT_CENTRES)
        call settings%real_value('reflectivity_earth', case%satellite%reflectivity_earth, 0.0_dp, 2.0_dp, &
                                 'eta of the Earth radiation pressure')
        call settings%end_group()
    end subroutine describe_radiation
end module gracecg_simulation_case
