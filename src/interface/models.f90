!> The C interface: models of the environment. Documented in include/gracecg.h.
module gracecg_interface_models
    use gracecg, only: dp, error_t, utc_t, gravity_model_t, new_gravity_model, GRAVITY_MODELS, geomagnetic_model_t, &
        new_geomagnetic_model, GEOMAGNETIC_MODELS, decimal_year, density_model_t, new_density_model, density_settings_t, &
        space_weather_source_t, DENSITY_MODELS, atmosphere_point_t, atmosphere_state_t, tabulated_wind_t, embedded_wind, &
        read_wind, julian_centuries_tt, earth_radiation_t, new_earth_radiation, standard_rings, &
        EARTH_RADIATION_EPOCH_JD, earth_fixed_to_geodetic, local_mean_solar_time, day_of_year
    use gracecg, only: position_of_sun => sun_position
    use gracecg_base_constants, only: SECONDS_PER_DAY, EARTH_RADIUS_EGM96, MJD_TO_JD
    use gracecg_base_error, only: fail
    use gracecg_base_text, only: integer_text, join
    use gracecg_files_file, only: file_exists
    use gracecg_files_value, only: did_you_mean
    use gracecg_interface_handles, only: object_t
    use gracecg_interface_outcome, only: outcome_t, STATUS_BAD_VALUE, STATUS_FAILED, STATUS_NULL_POINTER
    use gracecg_interface_time, only: later_time
    implicit none
    private
    public :: gravity_object_t, field_object_t, density_object_t, wind_object_t, earth_radiation_object_t
    public :: gravity_open, gravity_evaluate, field_open, density_open, density_evaluate
    public :: wind_open, wind_evaluate, sun_position, earth_radiation_open, earth_radiation_evaluate

    character(*), parameter :: WIND_NAMES(1) = [character(11) :: 'hwm93']

    !> A gravity model behind a handle.
    type, extends(object_t) :: gravity_object_t
        class(gravity_model_t), allocatable :: model    !! Of any kind
    end type gravity_object_t

    !> A geomagnetic field behind a handle.
    type, extends(object_t) :: field_object_t
        class(geomagnetic_model_t), allocatable :: model    !! At its date
    end type field_object_t

    !> A thermosphere behind a handle.
    type, extends(object_t) :: density_object_t
        class(density_model_t), allocatable :: model    !! With its indices
    end type density_object_t

    !> A wind behind a handle.
    type, extends(object_t) :: wind_object_t
        type(tabulated_wind_t) :: model                 !! Embedded or of a file
    end type wind_object_t

    !> The Earth's light behind a handle.
    type, extends(object_t) :: earth_radiation_object_t
        type(earth_radiation_t) :: model                !! With its rings
    end type earth_radiation_object_t

contains

    !> "egm96" (to degree 70), "point-mass" (degree and order 0), or the path of an ICGEM .gfc file.
    subroutine gravity_open(name, degree, order, made, outcome)
        character(*), intent(in) :: name            !! Of a model, or path of a file
        integer, intent(in) :: degree, order    !! To which the model is used
        type(gravity_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        if (name == 'point-mass' .and. (degree /= 0 .or. order /= 0)) then
            call outcome%refuse(STATUS_BAD_VALUE, 'a point mass has degree and order 0, not '//integer_text(degree)//' and '// &
                                integer_text(order))
        else if (any(GRAVITY_MODELS == name)) then
            call new_gravity_model(name, degree, order, '', made%model, failure)
            call outcome%take(failure, STATUS_BAD_VALUE)
        else
            call check_file(name, GRAVITY_MODELS, 'gravity model', failure)
            if (.not. allocated(failure)) call new_gravity_model('file', degree, order, name, made%model, failure)
        end if
        call outcome%take(failure)
    end subroutine gravity_open

    !> Fails when a name is neither one of the known ones nor that of a file.
    subroutine check_file(name, known, what, failure)
        character(*), intent(in) :: name, known(:), what
        type(error_t), allocatable, intent(out) :: failure

        if (file_exists(name)) return
        call fail(failure, 'no '//what//' "'//name//'": it is neither a built-in one ('//join(known, ', ')// &
                  ') nor a file'//did_you_mean(name, known))
    end subroutine check_file

    !> Of Earth-fixed positions [n][3]: acceleration [n][3] (m/s^2, Earth-fixed, without the centrifugal part), potential [n]
    !> (m^2/s^2) and its second derivatives [n][3][3] (1/s^2, symmetric).
    subroutine gravity_evaluate(gravity, n, position, acceleration, potential, gradient, outcome)
        class(gravity_object_t), intent(in) :: gravity
        integer, intent(in) :: n                                    !! Places
        real(dp), intent(in) :: position(3, n)                      !! Earth-fixed, m
        real(dp), intent(inout), optional :: acceleration(3, n)     !! m/s^2
        real(dp), intent(inout), optional :: potential(n)           !! m^2/s^2
        real(dp), intent(inout), optional :: gradient(3, 3, n)      !! 1/s^2
        type(outcome_t), intent(inout) :: outcome

        integer, parameter :: PIECE = 64                ! places that are handed to the model together
        real(dp) :: a(3, PIECE), u(PIECE)
        integer :: first, last, i, m

        do first = 1, n, PIECE
            last = min(first + PIECE - 1, n)
            m = last - first + 1
            if (present(gradient)) then
                do i = 1, m
                    call gravity%model%all_derivatives(position(:, first + i - 1), u(i), a(:, i), gradient(:, :, first + i - 1))
                end do
            else
                call gravity%model%accelerations(position(:, first:last), a(:, :m), u(:m))
            end if
            if (present(acceleration)) acceleration(:, first:last) = a(:, :m)
            if (present(potential)) potential(first:last) = u(:m)
        end do
    end subroutine gravity_evaluate

    !> "igrf95" (1985 to 2000), "igrf14" (1900 to 2030, extrapolated to 2040), or the path of an SHC file, at a date.
    subroutine field_open(name, date, made, outcome)
        character(*), intent(in) :: name            !! Of a model, or path of a file
        type(utc_t), intent(in) :: date
        type(field_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        if (any(GEOMAGNETIC_MODELS == name)) then
            call new_geomagnetic_model(name, decimal_year(date), '', made%model, failure)
            call outcome%take(failure, STATUS_BAD_VALUE)
        else
            call check_file(name, GEOMAGNETIC_MODELS, 'geomagnetic field', failure)
            if (.not. allocated(failure)) call new_geomagnetic_model('file', decimal_year(date), name, made%model, failure)
        end if
        call outcome%take(failure)
    end subroutine field_open

    !> A thermosphere: "dtm77", "dtm78" (as CNES has it), "dtm94", or "exponential" (4e-12 kg/m^3 at 466 km, scale height
    !> 65 km); with indices that are given, or those of a date in the embedded table. One of both has to be absent.
    subroutine density_open(name, date, indices, made, outcome)
        character(*), intent(in) :: name                !! Of a model
        type(utc_t), intent(in), optional :: date       !! Of the indices in the embedded table
        real(dp), intent(in), optional :: indices(3)    !! F10.7, its mean, sfu; Kp
        type(density_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        if (present(date) .eqv. present(indices)) then
            call outcome%refuse(merge(STATUS_BAD_VALUE, STATUS_NULL_POINTER, present(date)), &
                                'either a date or indices are needed, and not both')
        else if (present(date)) then
            call new_density_model(name, date, density_settings_t(), made%model, failure)
        else
            call new_density_model(name, utc_t(0, 0.0_dp), density_settings_t(space_weather=space_weather_source_t( &
                                   'given', indices(1), indices(2), indices(3))), made%model, failure)
        end if
        call outcome%take(failure, merge(STATUS_BAD_VALUE, STATUS_FAILED, any(DENSITY_MODELS == name)))
    end subroutine density_open

    !> Density (kg/m^3), temperature (K) and number densities at positions and times.
    subroutine density_evaluate(density, epoch, n, seconds, position, mass_density, temperature, number_density, outcome)
        class(density_object_t), intent(in) :: density
        type(utc_t), intent(in) :: epoch
        integer, intent(in) :: n                                    !! Places
        real(dp), intent(in) :: seconds(n), position(3, n)          !! s from the epoch; Earth-fixed, m
        real(dp), intent(inout) :: mass_density(n)                  !! kg/m^3
        real(dp), intent(inout), optional :: temperature(n)         !! K
        real(dp), intent(inout), optional :: number_density(3, n)   !! He, O, N2, 1/m^3
        type(outcome_t), intent(inout) :: outcome

        type(atmosphere_point_t) :: point
        type(atmosphere_state_t) :: air
        type(utc_t) :: time
        integer :: i

        do i = 1, n
            call later_time(epoch, seconds(i), time, outcome)
            if (.not. outcome%good()) return
            call point_at(time, position(:, i), point)
            if (point%height < density%model%lowest_height()) then
                call outcome%refuse(STATUS_BAD_VALUE, 'position '//integer_text(i)//' is too low: the model is valid from '// &
                                    integer_text(nint(density%model%lowest_height()/1000))//' km above the ellipsoid on')
                return
            end if
            call density%model%evaluate(point, air)
            mass_density(i) = air%density
            if (present(temperature)) temperature(i) = air%temperature
            if (present(number_density)) number_density(:, i) = [air%n_he, air%n_o, air%n_n2]
        end do
    end subroutine density_evaluate

    !> Where and when, as the thermosphere's models want it.
    pure subroutine point_at(time, position, point)
        type(utc_t), intent(in) :: time
        real(dp), intent(in) :: position(3)         !! Earth-fixed, m
        type(atmosphere_point_t), intent(out) :: point

        real(dp) :: longitude

        call earth_fixed_to_geodetic(position, point%latitude, longitude, point%height)
        point%local_solar_time = local_mean_solar_time(time, longitude)
        point%day_of_year = day_of_year(time)
    end subroutine point_at

    !> "hwm93" (the embedded table: 1989-01-02 0 h UT, 466 km) or the path of a table of one's own.
    subroutine wind_open(name, made, outcome)
        character(*), intent(in) :: name            !! Of a table, or path of a file
        type(wind_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        if (name == 'hwm93') then
            made%model = embedded_wind()
        else
            call check_file(name, WIND_NAMES, 'wind', failure)
            if (.not. allocated(failure)) call read_wind(name, made%model, failure)
        end if
        call outcome%take(failure)
    end subroutine wind_open

    !> Eastward and northward wind [n][2] (m/s, relative to the turning Earth) at Earth-fixed positions [n][3].
    subroutine wind_evaluate(wind, epoch, n, seconds, position, east_north, outcome)
        class(wind_object_t), intent(in) :: wind
        type(utc_t), intent(in) :: epoch
        integer, intent(in) :: n                                !! Places
        real(dp), intent(in) :: seconds(n), position(3, n)      !! s from the epoch; Earth-fixed, m
        real(dp), intent(inout) :: east_north(2, n)             !! m/s
        type(outcome_t), intent(inout) :: outcome

        type(atmosphere_point_t) :: point
        type(utc_t) :: time
        integer :: i

        do i = 1, n
            call later_time(epoch, seconds(i), time, outcome)
            if (.not. outcome%good()) return
            call point_at(time, position(:, i), point)
            call wind%model%evaluate(point%latitude, point%local_solar_time, east_north(1, i), east_north(2, i))
        end do
    end subroutine wind_evaluate

    !> The Sun [n][3] (m, inertial, from the Earth's centre, geometric) `seconds`[n] after `epoch`.
    subroutine sun_position(epoch, n, seconds, position, outcome)
        type(utc_t), intent(in) :: epoch
        integer, intent(in) :: n                        !! Times
        real(dp), intent(in) :: seconds(n)              !! s from the epoch
        real(dp), intent(inout) :: position(3, n)       !! Inertial, m
        type(outcome_t), intent(inout) :: outcome

        type(utc_t) :: time
        integer :: i

        do i = 1, n
            call later_time(epoch, seconds(i), time, outcome)
            if (.not. outcome%good()) return
            position(:, i) = position_of_sun(julian_centuries_tt(time))
        end do
    end subroutine sun_position

    !> The Earth's light and heat by Knocke's model, with segments of the surface in rings around the nearest point.
    subroutine earth_radiation_open(constants, rings, solar_irradiance, made, outcome)
        character(*), intent(in) :: constants           !! Name of a set
        integer, intent(in) :: rings                    !! Around the cap
        real(dp), intent(in) :: solar_irradiance        !! At 1 au, W/m^2
        type(earth_radiation_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        call new_earth_radiation(constants, standard_rings(rings), solar_irradiance, made%model, failure)
        call outcome%take(failure)
    end subroutine earth_radiation_open

    !> The Earth's radiation at positions and times: net flux [n][3] (W/m^2, inertial, away from the Earth).
    subroutine earth_radiation_evaluate(model, epoch, n, seconds, position, flux, outcome)
        class(earth_radiation_object_t), intent(in) :: model
        type(utc_t), intent(in) :: epoch
        integer, intent(in) :: n                                !! Places
        real(dp), intent(in) :: seconds(n), position(3, n)      !! s from the epoch; inertial, m
        real(dp), intent(inout) :: flux(3, n)                   !! Inertial, W/m^2
        type(outcome_t), intent(inout) :: outcome

        type(utc_t) :: time
        integer :: i

        do i = 1, n
            if (norm2(position(:, i)) <= EARTH_RADIUS_EGM96) &
                call outcome%refuse(STATUS_BAD_VALUE, 'a position lies inside the Earth')
            call later_time(epoch, seconds(i), time, outcome)
            if (.not. outcome%good()) return
            call model%model%flux_at(position(:, i), position_of_sun(julian_centuries_tt(time)), time%mjd + &
                                     time%seconds/SECONDS_PER_DAY + (MJD_TO_JD - EARTH_RADIATION_EPOCH_JD), flux(:, i))
        end do
    end subroutine earth_radiation_evaluate
end module gracecg_interface_models
