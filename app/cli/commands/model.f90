!> gracecg model NAME: single models of the environment at a place and time, one CSV row each.
module gracecg_cli_model
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, ASTRONOMICAL_UNIT
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_text, only: integer_text, join, real_text
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
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: publish_row, add_format_option, take_format
    implicit none
    private
    public :: declare_gravity, run_gravity, declare_field, run_field, declare_density, run_density
    public :: declare_wind, run_wind, declare_sun, run_sun, declare_orientation, run_orientation

    integer, parameter :: DEFAULT_DEGREE = 70       !! All of the embedded EGM96
    real(dp), parameter :: LOWEST_HEIGHT = -500.0_dp
    !! Above the ellipsoid, m: below all dry land
    real(dp), parameter :: SMALLEST_DISTANCE = 6.35e6_dp
    !! From the Earth's centre, m: below the poles
    real(dp), parameter :: GREATEST_COORDINATE = 1e10_dp    !! m
    character(*), parameter :: EXAMPLE_PLACE = '--position 6837865 0 0'
    character(*), parameter :: EXAMPLE_DATE = '--date 1989-01-02T00:00:00'

    character(*), parameter :: PLACE_COLUMNS = 'height_km,latitude_deg,local_time_h'

    !> A place in geodetic coordinates (WGS-84).
    type :: place_t
        real(dp) :: latitude = 0, longitude = 0     !! rad
        real(dp) :: height = 0                      !! m
    end type place_t

contains

    !> Arguments and help of `gracecg model orientation`.
    subroutine declare_orientation(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('model orientation', '', 0, 0, &
                                'The matrix from inertial (GCRS) to Earth-fixed axes by precession IAU 2006, nutation '// &
                                'IAU 2000B, Earth rotation angle, and UT1 and pole of a file of the IERS; row by row.', &
                                'gracecg model orientation --date 2026-03-01T00:00:00')
        call add_date(arguments)
        call arguments%add_option('--ut1-minus-utc', 'S', 's, where no file is given (default 0)')
        call arguments%add_option('--file', 'FILE', 'finals2000A or EOP C04 of the IERS')
        call arguments%add_option('--after', 'S', 's after the date at which the constants are computed (default 0)')
        call add_format_option(arguments, default='csv')
    end subroutine declare_orientation

    !> The work of `gracecg model orientation`.
    subroutine run_orientation(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(utc_t) :: utc
        type(earth_parameters_t) :: parameters
        type(earth_orientation_t) :: orientation
        character(:), allocatable :: date, file
        real(dp) :: after

        call arguments%get('--date', date, misuse)
        call arguments%get('--ut1-minus-utc', parameters%ut1_minus_utc, misuse, default=0.0_dp, low=-1.0_dp, high=1.0_dp, &
                           unit='s')
        call arguments%get('--file', file, misuse, default='')
        call arguments%get('--after', after, misuse, default=0.0_dp, low=-864000.0_dp, high=864000.0_dp, unit='s')
        call refuse_if(arguments%has('--ut1-minus-utc') .and. arguments%has('--file'), &
                       'give --ut1-minus-utc or --file, not both', misuse)
        call take_format(arguments, console, misuse, default='csv')
        if (allocated(misuse)) return
        call parse_utc(date, utc, error)
        if (.not. allocated(error) .and. file /= '') call read_earth_parameters(file, utc, parameters, error)
        if (allocated(error)) return
        orientation = iau_orientation(utc, parameters)
        call publish_row('model orientation', 'xx,xy,xz,yx,yy,yz,zx,zy,zz', &
                         [transpose(orientation%from_inertial(after))], console, error)
    end subroutine run_orientation

    !> Arguments and help of `gracecg model gravity`.
    subroutine declare_gravity(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('model gravity', '', 0, 0, &
                                'Gravitational acceleration (m/s^2, Earth-fixed axes, without '// &
                                'the centrifugal part) and potential (m^2/s^2) of EGM96, of '// &
                                'another model or of a model file.', &
                                'gracecg model gravity '//EXAMPLE_PLACE//' --degree 20')
        call add_position(arguments)
        call arguments%add_option('--model', 'NAME', join(GRAVITY_MODELS, ', ')//' (default '// &
                                  trim(GRAVITY_MODELS(1))//')', choices=GRAVITY_MODELS)
        call arguments%add_option('--degree', 'N', 'highest degree (default '// &
                                  integer_text(DEFAULT_DEGREE)//')')
        call arguments%add_option('--order', 'M', 'highest order (default: the degree)')
        call arguments%add_option('--file', 'FILE', 'model in ICGEM format (.gfc)')
        call add_format_option(arguments, default='csv')
    end subroutine declare_gravity

    !> The work of `gracecg model gravity`.
    subroutine run_gravity(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        class(gravity_model_t), allocatable :: model
        character(:), allocatable :: name, file
        real(dp) :: position(3), acceleration(3), potential
        integer :: degree, order

        call get_position(arguments, position, misuse)
        call arguments%get('--degree', degree, misuse, default=DEFAULT_DEGREE, low=0)
        call arguments%get('--order', order, misuse, default=degree, low=0)
        call arguments%get('--model', name, misuse, default=trim(GRAVITY_MODELS(1)), choices=GRAVITY_MODELS)
        call arguments%get('--file', file, misuse, default='')
        call refuse_if(arguments%has('--model') .and. arguments%has('--file'), &
                       'give --model or --file, not both', misuse)
        call take_format(arguments, console, misuse, default='csv')
        if (allocated(misuse)) return

        call check_position(position, error)
        if (allocated(error)) return
        if (arguments%has('--file')) name = 'file'
        call new_gravity_model(name, degree, order, file, model, error)
        if (allocated(error)) return
        call model%acceleration(position, acceleration)
        call model%potential(position, potential)
        call publish_row('model gravity', 'ax_m_s2,ay_m_s2,az_m_s2,potential_m2_s2', [acceleration, potential], console, &
                         error)
    end subroutine run_gravity

    !> Arguments and help of `gracecg model field`.
    subroutine declare_field(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('model field', '', 0, 0, &
                                'Magnetic flux density in T: Earth-fixed axes, and along the '// &
                                'local geocentric vertical (up), south and east.', &
                                'gracecg model field '//EXAMPLE_DATE//' '//EXAMPLE_PLACE)
        call add_date(arguments)
        call add_position(arguments)
        call arguments%add_option('--table', 'NAME', 'igrf95 (default; 1985 to 2000) or igrf14 '// &
                                  '(1900 to 2030)', choices=GEOMAGNETIC_MODELS)
        call arguments%add_option('--file', 'FILE', 'model in SHC format instead of a table')
        call add_format_option(arguments, default='csv')
    end subroutine declare_field

    !> The work of `gracecg model field`.
    subroutine run_field(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        class(geomagnetic_model_t), allocatable :: model
        type(utc_t) :: date
        character(:), allocatable :: table, file
        real(dp) :: position(3), b(3), radial, south, east

        call get_date(arguments, date, misuse)
        call get_position(arguments, position, misuse)
        call arguments%get('--table', table, misuse, default='igrf95', choices=GEOMAGNETIC_MODELS)
        call arguments%get('--file', file, misuse, default='')
        call refuse_if(arguments%has('--table') .and. arguments%has('--file'), &
                       'give --table or --file, not both', misuse)
        call take_format(arguments, console, misuse, default='csv')
        if (allocated(misuse)) return

        call check_position(position, error)
        if (allocated(error)) return
        if (arguments%has('--file')) table = 'file'
        call new_geomagnetic_model(table, decimal_year(date), file, model, error)
        if (allocated(error)) return
        call model%evaluate(position, b)
        call spherical_components(position, b, radial, south, east)
        call publish_row('model field', 'bx_tesla,by_tesla,bz_tesla,b_radial_tesla,b_south_tesla,b_east_tesla', &
                         [b, radial, south, east], console, error)
    end subroutine run_field

    !> Arguments and help of `gracecg model density`.
    subroutine declare_density(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('model density', '', 0, 0, &
                                'Density (kg/m^3), temperatures (K) and number densities '// &
                                '(1/m^3) of the thermosphere. Solar flux and Kp come '// &
                                'from the built-in table (December 1988 to February 1989, and '// &
                                '2000) unless all three are given.', &
                                'gracecg model density '//EXAMPLE_DATE//' '//EXAMPLE_PLACE)
        call add_date(arguments)
        call add_position(arguments)
        call arguments%add_option('--model', 'NAME', join(DENSITY_MODELS, ', ')//' (default '// &
                                  trim(DENSITY_MODELS(1))//')', choices=DENSITY_MODELS)
        call arguments%add_option('--f107', 'V', 'observed solar flux F10.7 of the day before, sfu')
        call arguments%add_option('--f107a', 'V', 'its mean over 81 days, sfu')
        call arguments%add_option('--kp', 'V', 'Kp three hours before, 0 to 9')
        call add_format_option(arguments, default='csv')
    end subroutine declare_density

    !> The work of `gracecg model density`.
    subroutine run_density(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        class(density_model_t), allocatable :: model
        type(density_settings_t) :: settings
        character(:), allocatable :: name
        type(utc_t) :: date
        type(place_t) :: place
        type(atmosphere_point_t) :: point
        type(atmosphere_state_t) :: air
        real(dp) :: position(3), f107, f107_mean, kp
        integer :: given

        given = count([arguments%has('--f107'), arguments%has('--f107a'), arguments%has('--kp')])
        call refuse_if(given == 1 .or. given == 2, 'give all three of --f107, --f107a and --kp, or none', misuse)
        call get_date(arguments, date, misuse)
        call get_position(arguments, position, misuse)
        call arguments%get('--model', name, misuse, default=trim(DENSITY_MODELS(1)), choices=DENSITY_MODELS)
        call arguments%get('--f107', f107, misuse, default=0.0_dp, unit='sfu')
        call arguments%get('--f107a', f107_mean, misuse, default=0.0_dp, unit='sfu')
        call arguments%get('--kp', kp, misuse, default=0.0_dp)
        call take_format(arguments, console, misuse, default='csv')
        if (allocated(misuse)) return

        if (given == 0) call look_up_space_weather(date, f107, f107_mean, kp, error)
        settings%space_weather = space_weather_source_t('given', f107, f107_mean, kp)
        if (.not. allocated(error)) call new_density_model(name, date, settings, model, error)
        if (.not. allocated(error)) call check_position(position, error)
        if (allocated(error)) return
        place = place_of(position)
        if (place%height < model%lowest_height()) then
            call fail(error, 'height '//real_text(place%height/1000)// &
                      ' km above the ellipsoid: '//name//' is valid from '// &
                      real_text(model%lowest_height()/1000)//' km on')
            return
        end if
        point = atmosphere_point_t(place%height, place%latitude, &
                                   local_mean_solar_time(date, place%longitude), day_of_year(date))
        call model%evaluate(point, air)
        call publish_row('model density', 'density_kg_m3,temperature_kelvin,exospheric_temperature_kelvin,'// &
                         'n_he_per_m3,n_o_per_m3,n_n2_per_m3,'//PLACE_COLUMNS//',day,f107_sfu,f107a_sfu,kp', &
                         [air%density, air%temperature, air%exospheric_temperature, air%n_he, air%n_o, air%n_n2, &
                          place_values(place, point%local_solar_time), point%day_of_year, f107, f107_mean, kp], &
                         console, error)
    end subroutine run_density

    !> Indices of the embedded table.
    subroutine look_up_space_weather(date, f107, f107_mean, kp, error)
        type(utc_t), intent(in) :: date
        real(dp), intent(out) :: f107, f107_mean    !! sfu
        real(dp), intent(out) :: kp
        type(error_t), allocatable, intent(out) :: error

        type(space_weather_source_t) :: table

        call table%indices_at(date, f107, f107_mean, kp, error)
        call add_context(error, '--f107, --f107a and --kp are needed')
    end subroutine look_up_space_weather

    !> Arguments and help of `gracecg model wind`.
    subroutine declare_wind(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('model wind', '', 0, 0, &
                                'Horizontal wind of the thermosphere in m/s relative to the '// &
                                'rotating Earth, by latitude and local solar time: the '// &
                                'built-in table of HWM93.', &
                                'gracecg model wind '//EXAMPLE_DATE//' '//EXAMPLE_PLACE)
        call add_date(arguments)
        call add_position(arguments)
        call add_format_option(arguments, default='csv')
    end subroutine declare_wind

    !> The work of `gracecg model wind`.
    subroutine run_wind(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(tabulated_wind_t) :: model
        type(utc_t) :: date
        type(place_t) :: place
        real(dp) :: position(3), local_time, east, north

        call get_date(arguments, date, misuse)
        call get_position(arguments, position, misuse)
        call take_format(arguments, console, misuse, default='csv')
        if (allocated(misuse)) return

        call check_position(position, error)
        if (allocated(error)) return
        place = place_of(position)
        local_time = local_mean_solar_time(date, place%longitude)
        model = embedded_wind()
        call model%evaluate(place%latitude, local_time, east, north)
        call publish_row('model wind', 'east_m_s,north_m_s,'//PLACE_COLUMNS, &
                         [east, north, place_values(place, local_time)], console, error, &
                         'HWM93 of 1989-01-02 0 h UT at 466 km; the same table serves every date and height')
    end subroutine run_wind

    !> Arguments and help of `gracecg model sun`.
    subroutine declare_sun(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('model sun', '', 0, 0, &
                                'Geometric position of the Sun from the Earth''s centre in m, '// &
                                'mean equator and equinox of J2000, and its distance in au.', &
                                'gracecg model sun '//EXAMPLE_DATE)
        call add_date(arguments)
        call add_format_option(arguments, default='csv')
    end subroutine declare_sun

    !> The work of `gracecg model sun`.
    subroutine run_sun(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(utc_t) :: date
        real(dp) :: position(3)

        call get_date(arguments, date, misuse)
        call take_format(arguments, console, misuse, default='csv')
        if (allocated(misuse)) return
        position = sun_position(julian_centuries_tt(date))
        call publish_row('model sun', 'x_m,y_m,z_m,distance_au', [position, norm2(position)/ASTRONOMICAL_UNIT], &
                         console, error)
    end subroutine run_sun

    subroutine add_position(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%add_option('--position', 'X Y Z', 'Earth-fixed position, m', required=.true.)
    end subroutine add_position

    subroutine add_date(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%add_option('--date', 'DATE', &
                                  'UTC, ISO 8601: 1989-01-02T00:00:00 or 1989-01-02', &
                                  required=.true.)
    end subroutine add_date

    subroutine get_position(arguments, position, misuse)
        type(arguments_t), intent(in) :: arguments
        real(dp), intent(out) :: position(3)        !! Earth-fixed, m
        type(error_t), allocatable, intent(inout) :: misuse

        call arguments%get('--position', position, misuse, low=-GREATEST_COORDINATE, &
                           high=GREATEST_COORDINATE, unit='m')
    end subroutine get_position

    subroutine get_date(arguments, date, misuse)
        type(arguments_t), intent(in) :: arguments
        type(utc_t), intent(out) :: date
        type(error_t), allocatable, intent(inout) :: misuse

        character(:), allocatable :: text

        if (allocated(misuse)) return
        call arguments%get('--date', text, misuse)
        if (.not. allocated(misuse)) call parse_utc(text, date, misuse)
        call add_context(misuse, 'option --date')
    end subroutine get_date

    !> Refuses a position inside the Earth.
    subroutine check_position(position, error)
        real(dp), intent(in) :: position(3)         !! Earth-fixed, m
        type(error_t), allocatable, intent(out) :: error

        type(place_t) :: place

        if (norm2(position) < SMALLEST_DISTANCE) then
            call fail(error, 'option --position: '//real_text(norm2(position)/1000)// &
                      ' km from the Earth''s centre lies inside the Earth; give Earth-fixed metres')
            return
        end if
        place = place_of(position)
        if (place%height < LOWEST_HEIGHT) &
            call fail(error, 'option --position: lies '//real_text(-place%height/1000)// &
                      ' km below the ellipsoid, inside the Earth; give Earth-fixed metres')
    end subroutine check_position

    function place_of(position) result(place)
        real(dp), intent(in) :: position(3)         !! Earth-fixed, m
        type(place_t) :: place

        call earth_fixed_to_geodetic(position, place%latitude, place%longitude, place%height)
    end function place_of

    !> Where and when, as the models took it.
    function place_values(place, local_time) result(values)
        type(place_t), intent(in) :: place
        real(dp), intent(in) :: local_time          !! h
        real(dp) :: values(3)                       !! By PLACE_COLUMNS

        values = [place%height/1000, place%latitude/DEGREE, local_time]
    end function place_values
end module gracecg_cli_model
