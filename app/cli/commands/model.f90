!> gracecg model NAME: single models at a place and time, one CSV row each.
module gracecg_cli_model
    use gracecg_base_constants, only: ASTRONOMICAL_UNIT
    use gracecg_environment_time, only: utc_t, parse_utc, decimal_year, day_of_year, local_mean_solar_time, &
        julian_centuries_tt
    use gracecg_environment_earth_orientation, only: earth_orientation_t, earth_parameters_t, iau_orientation
    use gracecg_environment_iers_file, only: read_earth_parameters
    use gracecg_environment_earth_shape, only: earth_fixed_to_geodetic
    use gracecg_environment_geopotential, only: gravity_model_t
    use gracecg_environment_gravity_models, only: new_gravity_model, GRAVITY_MODELS
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t, spherical_components
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model, GEOMAGNETIC_MODELS
    use gracecg_environment_space_weather, only: space_weather_source_t
    use gracecg_environment_thermosphere, only: density_model_t, atmosphere_point_t, atmosphere_state_t
    use gracecg_environment_density_models, only: new_density_model, density_settings_t, DENSITY_MODELS
    use gracecg_environment_wind, only: tabulated_wind_t, embedded_wind
    use gracecg_environment_sun, only: sun_position
    use gracecg_cli_calibration_argument, only: warn_of_field
    use gracecg_cli_results, only: publish_row
    use gracecg_cli_work
    implicit none
    private
    public :: declare_gravity, run_gravity, declare_field, run_field, declare_density, run_density
    public :: declare_wind, run_wind, declare_sun, run_sun, declare_orientation, run_orientation

    real(dp), parameter :: LOWEST_HEIGHT = -500.0_dp        !! Above the ellipsoid, m: below all dry land
    real(dp), parameter :: SMALLEST_DISTANCE = 6.35e6_dp    !! From the Earth's centre, m: below the poles
    real(dp), parameter :: GREATEST_COORDINATE = 1e10_dp    !! m
    real(dp), parameter :: LONGEST_DELAY = 864000.0_dp      !! Of --after, s: ten days
    character(*), parameter :: EXAMPLE_PLACE = ' --position 6837865 0 0'
    character(*), parameter :: EXAMPLE_DATE = ' --date 1989-01-02T00:00:00'
    character(*), parameter :: PLACE_COLUMNS = 'height_km,latitude_deg,local_time_h'

    !> When and where a model is asked for.
    type :: point_t
        type(utc_t) :: date
        real(dp) :: position(3) = 0                 !! Earth-fixed, m
        real(dp) :: latitude = 0, longitude = 0     !! Geodetic (WGS-84), rad
        real(dp) :: height = 0                      !! Above the ellipsoid, m
        real(dp) :: local_time = 0                  !! Mean solar time, h
        real(dp) :: place(3) = 0                    !! By PLACE_COLUMNS
    end type point_t

contains

    !> Arguments and help of `gracecg model orientation`.
    subroutine declare_orientation(arguments)
        type(arguments_t), intent(inout) :: arguments

        call describe(arguments, 'orientation --date', 'The matrix from inertial (GCRS) to Earth-fixed axes by precession '// &
                      'IAU 2006, nutation IAU 2000B, Earth rotation angle, and UT1 and pole of a file of the IERS; row by row.')
        call arguments%add_option('--ut1-minus-utc', 'S', 's, where no file is given', default='0')
        call arguments%add_option('--file', 'FILE', 'finals2000A or EOP C04 of the IERS')
        call arguments%add_option('--after', 'S', 's after the date at which the constants are computed', default='0')
    end subroutine declare_orientation

    !> The work of `gracecg model orientation`.
    subroutine run_orientation(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(point_t) :: point
        type(earth_parameters_t) :: parameters
        type(earth_orientation_t) :: orientation
        character(:), allocatable :: file
        real(dp) :: after

        call arguments%get('--ut1-minus-utc', parameters%ut1_minus_utc, misuse, low=-1.0_dp, high=1.0_dp, unit='s')
        call arguments%get('--after', after, misuse, low=-LONGEST_DELAY, high=LONGEST_DELAY, unit='s')
        call take_point(arguments, '--ut1-minus-utc', file, point, console, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        if (file /= '') call read_earth_parameters(file, point%date, parameters, error)
        if (allocated(error)) return
        orientation = iau_orientation(point%date, parameters)
        call publish_row('model orientation', 'xx,xy,xz,yx,yy,yz,zx,zy,zz', &
                         [transpose(orientation%from_inertial(after))], console, error)
    end subroutine run_orientation

    !> Arguments and help of `gracecg model gravity`.
    subroutine declare_gravity(arguments)
        type(arguments_t), intent(inout) :: arguments

        call describe(arguments, 'gravity --position', 'Gravitational acceleration (m/s^2, Earth-fixed axes, without the '// &
                      'centrifugal part) and potential (m^2/s^2) of EGM96, of another model or of a model file.', ' --degree 20')
        call arguments%add_option('--model', 'NAME', 'of the gravity field', choices=GRAVITY_MODELS, &
                                  default=trim(GRAVITY_MODELS(1)))
        call arguments%add_option('--degree', 'N', 'highest degree', default='70')
        call arguments%add_option('--order', 'M', 'highest order (default: the degree)')
        call arguments%add_option('--file', 'FILE', 'model in ICGEM format (.gfc)')
    end subroutine declare_gravity

    !> The work of `gracecg model gravity`.
    subroutine run_gravity(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        class(gravity_model_t), allocatable :: model
        type(point_t) :: point
        character(:), allocatable :: name, file
        real(dp) :: acceleration(3), potential
        integer :: degree, order

        call arguments%get('--degree', degree, misuse, low=0)
        order = degree
        call arguments%get('--order', order, misuse, low=0)
        call arguments%get('--model', name, misuse)
        call take_point(arguments, '--model', file, point, console, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        if (file /= '') name = 'file'
        call new_gravity_model(name, degree, order, file, model, error)
        if (allocated(error)) return
        call model%acceleration(point%position, acceleration)
        call model%potential(point%position, potential)
        call publish_row('model gravity', 'ax_m_s2,ay_m_s2,az_m_s2,potential_m2_s2', [acceleration, potential], console, &
                         error)
    end subroutine run_gravity

    !> Arguments and help of `gracecg model field`.
    subroutine declare_field(arguments)
        type(arguments_t), intent(inout) :: arguments

        call describe(arguments, 'field --date --position', 'Magnetic flux density in T: Earth-fixed axes, and along the '// &
                      'local geocentric vertical (up), south and east.')
        call arguments%add_option('--table', 'NAME', 'igrf95 (1985 to 2000) or igrf14 (1900 to 2030, extrapolated to 2040)', &
                                  choices=GEOMAGNETIC_MODELS, default='igrf95')
        call arguments%add_option('--file', 'FILE', 'model in SHC format instead of a table')
    end subroutine declare_field

    !> The work of `gracecg model field`.
    subroutine run_field(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        class(geomagnetic_model_t), allocatable :: model
        type(point_t) :: point
        character(:), allocatable :: table, file
        real(dp) :: b(3), radial, south, east

        call arguments%get('--table', table, misuse)
        call take_point(arguments, '--table', file, point, console, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        if (file /= '') table = 'file'
        call new_geomagnetic_model(table, decimal_year(point%date), file, model, error)
        if (allocated(error)) return
        call warn_of_field(table, point%date, console)
        call model%evaluate(point%position, b)
        call spherical_components(point%position, b, radial, south, east)
        call publish_row('model field', 'bx_tesla,by_tesla,bz_tesla,b_radial_tesla,b_south_tesla,b_east_tesla', &
                         [b, radial, south, east], console, error)
    end subroutine run_field

    !> Arguments and help of `gracecg model density`.
    subroutine declare_density(arguments)
        type(arguments_t), intent(inout) :: arguments

        call describe(arguments, 'density --date --position', 'Density (kg/m^3), temperatures (K) and number densities '// &
                      '(1/m^3) of the thermosphere. Solar flux and Kp come from the built-in table (December 1988 to '// &
                      'February 1989, and 2000) unless all three are given.')
        call arguments%add_option('--model', 'NAME', 'of the thermosphere', choices=DENSITY_MODELS, &
                                  default=trim(DENSITY_MODELS(1)))
        call arguments%add_option('--f107', 'V', 'observed solar flux F10.7 of the day before, sfu')
        call arguments%add_option('--f107a', 'V', 'its mean over 81 days, sfu')
        call arguments%add_option('--kp', 'V', 'Kp three hours before, 0 to 9')
    end subroutine declare_density

    !> The work of `gracecg model density`.
    subroutine run_density(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        class(density_model_t), allocatable :: model
        type(density_settings_t) :: settings
        type(space_weather_source_t) :: table
        type(point_t) :: point
        type(atmosphere_state_t) :: air
        character(:), allocatable :: name, file
        real(dp) :: f107, f107_mean, kp
        integer :: given

        given = count([arguments%has('--f107'), arguments%has('--f107a'), arguments%has('--kp')])
        call refuse_if(given == 1 .or. given == 2, 'give all three of --f107, --f107a and --kp, or none', misuse)
        call arguments%get('--model', name, misuse)
        f107 = 0
        f107_mean = 0
        kp = 0
        call arguments%get('--f107', f107, misuse, unit='sfu')
        call arguments%get('--f107a', f107_mean, misuse, unit='sfu')
        call arguments%get('--kp', kp, misuse)
        call take_point(arguments, '', file, point, console, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        if (given == 0 .and. name /= 'exponential') then
            call table%indices_at(point%date, f107, f107_mean, kp, error)
            call add_context(error, '--f107, --f107a and --kp are needed')
        end if
        settings%space_weather = space_weather_source_t('given', f107, f107_mean, kp)
        if (.not. allocated(error)) call new_density_model(name, point%date, settings, model, error)
        if (allocated(error)) return
        if (point%height < model%lowest_height()) then
            call fail(error, 'height '//real_text(point%height/1000)//' km above the ellipsoid: '//name//' is valid from '// &
                      real_text(model%lowest_height()/1000)//' km on')
            return
        end if
        associate (sky => atmosphere_point_t(point%height, point%latitude, point%local_time, day_of_year(point%date)))
            call model%evaluate(sky, air)
            call publish_row('model density', 'density_kg_m3,temperature_kelvin,exospheric_temperature_kelvin,'// &
                             'n_he_per_m3,n_o_per_m3,n_n2_per_m3,'//PLACE_COLUMNS//',day,f107_sfu,f107a_sfu,kp', &
                             [air%density, air%temperature, air%exospheric_temperature, air%n_he, air%n_o, air%n_n2, &
                              point%place, sky%day_of_year, f107, f107_mean, kp], console, error)
        end associate
    end subroutine run_density

    !> Arguments and help of `gracecg model wind`.
    subroutine declare_wind(arguments)
        type(arguments_t), intent(inout) :: arguments

        call describe(arguments, 'wind --date --position', 'Horizontal wind of the thermosphere in m/s relative to the '// &
                      'rotating Earth, by latitude and local solar time: the built-in table of HWM93.')
    end subroutine declare_wind

    !> The work of `gracecg model wind`.
    subroutine run_wind(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(tabulated_wind_t) :: model
        type(point_t) :: point
        character(:), allocatable :: file
        real(dp) :: east, north

        call take_point(arguments, '', file, point, console, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        model = embedded_wind()
        call model%evaluate(point%latitude, point%local_time, east, north)
        call publish_row('model wind', 'east_m_s,north_m_s,'//PLACE_COLUMNS, [east, north, point%place], console, error, &
                         'HWM93 of 1989-01-02 0 h UT at 466 km; the same table serves every date and height')
    end subroutine run_wind

    !> Arguments and help of `gracecg model sun`.
    subroutine declare_sun(arguments)
        type(arguments_t), intent(inout) :: arguments

        call describe(arguments, 'sun --date', 'Geometric position of the Sun from the Earth''s centre in m, mean equator '// &
                      'and equinox of J2000, and its distance in au.')
    end subroutine declare_sun

    !> The work of `gracecg model sun`.
    subroutine run_sun(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(point_t) :: point
        character(:), allocatable :: file
        real(dp) :: position(3)

        call take_point(arguments, '', file, point, console, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        position = sun_position(julian_centuries_tt(point%date))
        call publish_row('model sun', 'x_m,y_m,z_m,distance_au', [position, norm2(position)/ASTRONOMICAL_UNIT], &
                         console, error)
    end subroutine run_sun

    !> Begins the declaration of a model: its help with an example, when and where it is asked for, and the format.
    subroutine describe(arguments, name, summary, example)
        type(arguments_t), intent(inout) :: arguments
        character(*), intent(in) :: name        !! And which of --date and --position it takes
        character(*), intent(in) :: summary     !! What the model gives
        character(*), intent(in), optional :: example       !! What its example has besides

        character(:), allocatable :: command, line
        logical :: dated, placed

        command = 'model '//name(:index(name, ' ') - 1)
        dated = index(name, '--date') > 0
        placed = index(name, '--position') > 0
        line = 'gracecg '//command
        if (dated) line = line//EXAMPLE_DATE
        if (placed) line = line//EXAMPLE_PLACE
        if (present(example)) line = line//example
        call arguments%describe(command, '', 0, 0, summary, line)
        if (dated) call arguments%add_option('--date', 'DATE', 'UTC, ISO 8601: 1989-01-02T00:00:00 or 1989-01-02', &
                                             required=.true.)
        if (placed) call arguments%add_option('--position', 'X Y Z', 'Earth-fixed position, m', required=.true.)
        call add_format_option(arguments, default='csv')
    end subroutine describe

    !> When and where the model is asked for, and the file that it may be read from in place of a built-in one. Fails when
    !> the place lies inside the Earth.
    subroutine take_point(arguments, instead, file, point, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: instead     !! The option that excludes --file; empty: there is no --file
        character(:), allocatable, intent(out) :: file      !! Empty: none
        type(point_t), intent(out) :: point
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(inout) :: misuse
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: date

        file = ''
        if (instead /= '') then
            call arguments%get('--file', file, misuse)
            call refuse_if(arguments%has(instead) .and. file /= '', 'give '//instead//' or --file, not both', misuse)
        end if
        call take_format(arguments, console, misuse)
        if (arguments%declares('--date')) call arguments%get('--date', date, misuse)
        if (allocated(date) .and. .not. allocated(misuse)) then
            call parse_utc(date, point%date, misuse)
            call add_context(misuse, 'option --date')
        end if
        if (.not. arguments%declares('--position')) return
        call arguments%get('--position', point%position, misuse, low=-GREATEST_COORDINATE, high=GREATEST_COORDINATE, unit='m')
        if (allocated(misuse)) return
        associate (distance => norm2(point%position))
            if (distance < SMALLEST_DISTANCE) then
                call fail(error, 'option --position: '//real_text(distance/1000)// &
                          ' km from the Earth''s centre lies inside the Earth; give Earth-fixed metres')
                return
            end if
        end associate
        call earth_fixed_to_geodetic(point%position, point%latitude, point%longitude, point%height)
        if (point%height < LOWEST_HEIGHT) &
            call fail(error, 'option --position: lies '//real_text(-point%height/1000)// &
                      ' km below the ellipsoid, inside the Earth; give Earth-fixed metres')
        if (allocated(date)) point%local_time = local_mean_solar_time(point%date, point%longitude)
        point%place = [point%height/1000, point%latitude/DEGREE, point%local_time]
    end subroutine take_point
end module gracecg_cli_model
