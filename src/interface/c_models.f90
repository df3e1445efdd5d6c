!> The C interface: models of the environment. Documented in include/gracecg.h.
module gracecg_interface_c_models
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int32_t, c_null_char, c_intptr_t, c_size_t
    use gracecg, only: dp, error_t, utc_t, gravity_model_t, new_gravity_model, GRAVITY_MODELS, &
        geomagnetic_model_t, new_geomagnetic_model, GEOMAGNETIC_MODELS, decimal_year, &
        density_model_t, new_density_model, density_settings_t, &
        space_weather_source_t, atmosphere_point_t, atmosphere_state_t, &
        tabulated_wind_t, embedded_wind, read_wind, sun_position, conical_shadow, julian_centuries_tt, &
        earth_radiation_t, earth_irradiance_t, new_earth_radiation, standard_rings, &
        EARTH_RADIATION_EPOCH_JD, MAX_SEGMENTS, earth_fixed_to_geodetic, local_mean_solar_time, &
        day_of_year
    use gracecg_base_constants, only: SECONDS_PER_DAY, EARTH_RADIUS_EGM96
    use gracecg_base_error, only: fail
    use gracecg_base_kinds, only: i8
    use gracecg_base_text, only: integer_text, join
    use gracecg_files_file, only: file_exists
    use gracecg_files_value, only: did_you_mean
    use gracecg_interface_handles, only: object_t, acquire, release
    use gracecg_interface_c_support, only: c_error_t, c_utc_t, STATUS_OK, STATUS_FAILED, STATUS_BAD_SIZE, STATUS_BAD_VALUE, &
        LONGEST_NAME, start, raise, pass_on, need, check_count, check_finite, check_result, &
        check_distance, fortran_text, time_of, later_time, keep_copy, refuse_handle, free_object
    implicit none
    private
    public :: c_gravity_open, c_gravity_free, c_gravity_evaluate
    public :: c_field_open, c_field_free, c_field_evaluate
    public :: c_density_open, c_density_open_indices, c_density_free, c_density_evaluate
    public :: c_density_open_model, c_density_open_model_indices
    public :: c_wind_open, c_wind_free, c_wind_evaluate
    public :: c_sun_position, c_sun_illumination
    public :: c_earth_radiation_open, c_earth_radiation_free, c_earth_radiation_flux
    public :: c_earth_radiation_segments

    real(dp), parameter :: MJD_TO_JD = 2400000.5_dp
    character(*), parameter :: WIND_NAMES(1) = [character(11) :: 'hwm93']
    integer, parameter :: MOST_RINGS = 7

    type, extends(object_t) :: gravity_object_t
        class(gravity_model_t), allocatable :: model
    end type gravity_object_t

    type, extends(object_t) :: field_object_t
        class(geomagnetic_model_t), allocatable :: model
    end type field_object_t

    type, extends(object_t) :: density_object_t
        class(density_model_t), allocatable :: model
    end type density_object_t

    type, extends(object_t) :: wind_object_t
        type(tabulated_wind_t) :: model
    end type wind_object_t

    type, extends(object_t) :: earth_radiation_object_t
        type(earth_radiation_t) :: model
    end type earth_radiation_object_t

    character(kind=c_char), parameter :: DEFAULT_DENSITY(6) = ['d', 't', 'm', '7', '7', c_null_char]
    !! Of the entries that name no model

contains

    !> gracecg_gravity_open
    function c_gravity_open(name_or_file, degree, order, handle, error) result(status) &
        bind(c, name='gracecg_gravity_open')
        character(kind=c_char), intent(in), optional :: name_or_file(*)
        integer(c_int32_t), intent(in), value :: degree, order
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(gravity_object_t) :: made
        type(error_t), allocatable :: failure
        character(:), allocatable :: name

        call start(status, error)
        call need(present(handle), 'gravity', status, error)
        if (present(handle)) handle = 0
        call fortran_text(name_or_file, LONGEST_NAME, 'name_or_file', name, status, error)
        if (status /= STATUS_OK) return
        if (name == 'point-mass' .and. (degree /= 0 .or. order /= 0)) then
            call fail(failure, 'a point mass has degree and order 0, not '//integer_text(degree)// &
                      ' and '//integer_text(order))
        else if (any(GRAVITY_MODELS == name)) then
            call new_gravity_model(name, degree, order, '', made%model, failure)
        else
            call check_file(name, GRAVITY_MODELS, 'gravity model', failure)
            if (.not. allocated(failure)) call new_gravity_model('file', degree, order, name, made%model, failure)
        end if
        call pass_on(failure, status, error)
        if (status /= STATUS_OK) return
        call keep_copy(made, handle, status, error)
    end function c_gravity_open

    !> Fails when a name is neither one of the known ones nor that of a file.
    subroutine check_file(name, known, what, failure)
        character(*), intent(in) :: name, known(:), what
        type(error_t), allocatable, intent(out) :: failure

        if (file_exists(name)) return
        call fail(failure, 'no '//what//' "'//name//'": it is neither a built-in one ('// &
                  join(known, ', ')//') nor a file'//did_you_mean(name, known))
    end subroutine check_file

    !> gracecg_gravity_free
    function c_gravity_free(handle, error) result(status) bind(c, name='gracecg_gravity_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(gravity_object_t) :: mold

        call free_object(handle, 'gravity model', status, error, mold)
    end function c_gravity_free

    !> gracecg_gravity_evaluate
    function c_gravity_evaluate(handle, n, position, acceleration, potential, gradient, error) &
        result(status) bind(c, name='gracecg_gravity_evaluate')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: position(3, *)
        real(c_double), intent(inout), optional :: acceleration(3, *), potential(*), gradient(3, 3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        integer(c_size_t), parameter :: PIECE = 64      ! places that are handed to the model together
        class(object_t), pointer :: object
        real(dp) :: a(3, PIECE), u(PIECE), tensor(3, 3, PIECE)
        integer(c_size_t) :: first, last
        integer :: i, m

        call start_points(n, present(position), status, error)
        if (status == STATUS_OK .and. n > 0) call check_distance(position, n, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (gravity_object_t)
            do first = 1, n, PIECE
                last = min(first + PIECE - 1, n)
                m = int(last - first + 1)
                if (present(gradient)) then
                    do i = 1, m
                        call object%model%all_derivatives(position(:, first + i - 1), u(i), a(:, i), tensor(:, :, i))
                    end do
                    call check_result([tensor(:, :, :m)], 'the gradient', status, error)
                    gradient(:, :, first:last) = tensor(:, :, :m)
                else
                    call object%model%accelerations(position(:, first:last), a(:, :m), u(:m))
                end if
                if (present(acceleration)) then
                    call check_result([a(:, :m)], 'the acceleration', status, error)
                    acceleration(:, first:last) = a(:, :m)
                end if
                if (present(potential)) then
                    call check_result(u(:m), 'the potential', status, error)
                    potential(first:last) = u(:m)
                end if
                if (status /= STATUS_OK) exit
            end do
        class default
            call refuse_handle('gravity model', status, error)
        end select
        call release(int(handle, i8), object)
    end function c_gravity_evaluate

    !> Begins a function of n points.
    subroutine start_points(n, has_positions, status, error)
        integer(c_size_t), intent(in) :: n
        logical, intent(in) :: has_positions
        integer(c_int), intent(out) :: status
        type(c_error_t), intent(inout), optional :: error

        call start(status, error)
        call check_count(n, 'n', status, error)
        if (n > 0) call need(has_positions, 'position', status, error)
    end subroutine start_points

    !> gracecg_field_open
    function c_field_open(name_or_file, date, handle, error) result(status) &
        bind(c, name='gracecg_field_open')
        character(kind=c_char), intent(in), optional :: name_or_file(*)
        type(c_utc_t), intent(in), optional :: date
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(field_object_t) :: made
        type(utc_t) :: time
        type(error_t), allocatable :: failure
        character(:), allocatable :: name

        call start(status, error)
        call need(present(handle), 'field', status, error)
        if (present(handle)) handle = 0
        call fortran_text(name_or_file, LONGEST_NAME, 'name_or_file', name, status, error)
        call time_of(date, 'date', time, status, error)
        if (status /= STATUS_OK) return
        if (any(GEOMAGNETIC_MODELS == name)) then
            call new_geomagnetic_model(name, decimal_year(time), '', made%model, failure)
        else
            call check_file(name, GEOMAGNETIC_MODELS, 'geomagnetic field', failure)
            if (.not. allocated(failure)) &
                call new_geomagnetic_model('file', decimal_year(time), name, made%model, failure)
        end if
        call pass_on(failure, status, error)
        if (status /= STATUS_OK) return
        call keep_copy(made, handle, status, error)
    end function c_field_open

    !> gracecg_field_free
    function c_field_free(handle, error) result(status) bind(c, name='gracecg_field_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(field_object_t) :: mold

        call free_object(handle, 'geomagnetic field', status, error, mold)
    end function c_field_free

    !> gracecg_field_evaluate
    function c_field_evaluate(handle, n, position, flux_density, error) result(status) &
        bind(c, name='gracecg_field_evaluate')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: position(3, *)
        real(c_double), intent(inout), optional :: flux_density(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        real(dp) :: vector(3)
        integer(c_size_t) :: i

        call start_points(n, present(position), status, error)
        if (n > 0) call need(present(flux_density), 'flux_density', status, error)
        if (status == STATUS_OK .and. n > 0) call check_distance(position, n, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (field_object_t)
            do i = 1, n
                call object%model%evaluate(position(:, i), vector)
                call check_result(vector, 'the flux density', status, error)
                if (status /= STATUS_OK) exit
                flux_density(:, i) = vector
            end do
        class default
            call refuse_handle('geomagnetic field', status, error)
        end select
        call release(int(handle, i8), object)
    end function c_field_evaluate

    !> gracecg_density_open
    function c_density_open(date, handle, error) result(status) bind(c, name='gracecg_density_open')
        type(c_utc_t), intent(in), optional :: date
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        status = c_density_open_model(DEFAULT_DENSITY, date, handle, error)
    end function c_density_open

    !> gracecg_density_open_model
    function c_density_open_model(name, date, handle, error) result(status) &
        bind(c, name='gracecg_density_open_model')
        character(kind=c_char), intent(in), optional :: name(*)
        type(c_utc_t), intent(in), optional :: date
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(utc_t) :: time

        call start_density(handle, status, error)
        call time_of(date, 'date', time, status, error)
        call open_density(name, time, density_settings_t(), STATUS_FAILED, handle, status, error)
    end function c_density_open_model

    !> gracecg_density_open_indices
    function c_density_open_indices(f107, f107_mean, kp, handle, error) result(status) &
        bind(c, name='gracecg_density_open_indices')
        real(c_double), intent(in), value :: f107, f107_mean, kp
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        status = c_density_open_model_indices(DEFAULT_DENSITY, f107, f107_mean, kp, handle, error)
    end function c_density_open_indices

    !> gracecg_density_open_model_indices
    function c_density_open_model_indices(name, f107, f107_mean, kp, handle, error) result(status) &
        bind(c, name='gracecg_density_open_model_indices')
        character(kind=c_char), intent(in), optional :: name(*)
        real(c_double), intent(in), value :: f107, f107_mean, kp
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        call start_density(handle, status, error)
        call open_density(name, utc_t(0, 0.0_dp), &
                          density_settings_t(space_weather=space_weather_source_t('given', f107, f107_mean, kp)), &
                          STATUS_BAD_VALUE, handle, status, error)
    end function c_density_open_model_indices

    subroutine start_density(handle, status, error)
        integer(c_intptr_t), intent(inout), optional :: handle
        integer(c_int), intent(out) :: status
        type(c_error_t), intent(inout), optional :: error

        call start(status, error)
        call need(present(handle), 'density', status, error)
        if (present(handle)) handle = 0
    end subroutine start_density

    !> Makes the model of a name and a handle for it.
    subroutine open_density(c_name, time, settings, status_of_failure, handle, status, error)
        character(kind=c_char), intent(in), optional :: c_name(*)
        type(utc_t), intent(in) :: time
        type(density_settings_t), intent(in) :: settings
        integer(c_int), intent(in) :: status_of_failure
        integer(c_intptr_t), intent(inout) :: handle
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        type(density_object_t) :: made
        type(error_t), allocatable :: failure
        character(:), allocatable :: name

        call fortran_text(c_name, LONGEST_NAME, 'name', name, status, error)
        if (status /= STATUS_OK) return
        call new_density_model(name, time, settings, made%model, failure)
        call pass_on(failure, status, error, status_of_failure)
        if (status /= STATUS_OK) return
        call keep_copy(made, handle, status, error)
    end subroutine open_density

    !> gracecg_density_free
    function c_density_free(handle, error) result(status) bind(c, name='gracecg_density_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(density_object_t) :: mold

        call free_object(handle, 'density model', status, error, mold)
    end function c_density_free

    !> gracecg_density_evaluate
    function c_density_evaluate(handle, epoch, n, seconds, position, mass_density, temperature, &
                                number_density, error) result(status) &
        bind(c, name='gracecg_density_evaluate')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_utc_t), intent(in), optional :: epoch
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: seconds(*), position(3, *)
        real(c_double), intent(inout), optional :: mass_density(*), temperature(*), number_density(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(atmosphere_point_t) :: point
        type(atmosphere_state_t) :: air
        type(utc_t) :: start_time, time
        integer(c_size_t) :: i

        call start_series(epoch, n, present(seconds), present(position), start_time, status, error)
        if (n > 0) call need(present(mass_density), 'mass_density', status, error)
        if (status == STATUS_OK .and. n > 0) call check_distance(position, n, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (density_object_t)
            do i = 1, n
                call later_time(start_time, seconds(i), time, status, error)
                if (status /= STATUS_OK) exit
                call point_at(time, position(:, i), point)
                if (point%height < object%model%lowest_height()) then
                    call raise(STATUS_BAD_VALUE, 'position '//integer_text(int(i, i8))//' is too low: the '// &
                               'model is valid from '//integer_text(nint(object%model%lowest_height()/1000))// &
                               ' km above the ellipsoid on', status, error)
                    exit
                end if
                call object%model%evaluate(point, air)
                call check_result([air%density, air%temperature, air%n_he, air%n_o, air%n_n2], &
                                  'the density', status, error)
                if (status /= STATUS_OK) exit
                mass_density(i) = air%density
                if (present(temperature)) temperature(i) = air%temperature
                if (present(number_density)) number_density(:, i) = [air%n_he, air%n_o, air%n_n2]
            end do
        class default
            call refuse_handle('density model', status, error)
        end select
        call release(int(handle, i8), object)
    end function c_density_evaluate

    !> Begins a function of n points at times from an epoch.
    subroutine start_series(epoch, n, has_seconds, has_positions, start_time, status, error)
        type(c_utc_t), intent(in), optional :: epoch
        integer(c_size_t), intent(in) :: n
        logical, intent(in) :: has_seconds, has_positions
        type(utc_t), intent(out) :: start_time
        integer(c_int), intent(out) :: status
        type(c_error_t), intent(inout), optional :: error

        call start_points(n, has_positions, status, error)
        if (n > 0) call need(has_seconds, 'seconds', status, error)
        call time_of(epoch, 'epoch', start_time, status, error)
    end subroutine start_series

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

    !> gracecg_wind_open
    function c_wind_open(name_or_file, handle, error) result(status) bind(c, name='gracecg_wind_open')
        character(kind=c_char), intent(in), optional :: name_or_file(*)
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(wind_object_t) :: made
        type(error_t), allocatable :: failure
        character(:), allocatable :: name

        call start(status, error)
        call need(present(handle), 'wind', status, error)
        if (present(handle)) handle = 0
        call fortran_text(name_or_file, LONGEST_NAME, 'name_or_file', name, status, error)
        if (status /= STATUS_OK) return
        if (name == 'hwm93') then
            made%model = embedded_wind()
        else
            call check_file(name, WIND_NAMES, 'wind', failure)
            if (.not. allocated(failure)) call read_wind(name, made%model, failure)
        end if
        call pass_on(failure, status, error)
        if (status /= STATUS_OK) return
        call keep_copy(made, handle, status, error)
    end function c_wind_open

    !> gracecg_wind_free
    function c_wind_free(handle, error) result(status) bind(c, name='gracecg_wind_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(wind_object_t) :: mold

        call free_object(handle, 'wind', status, error, mold)
    end function c_wind_free

    !> gracecg_wind_evaluate
    function c_wind_evaluate(handle, epoch, n, seconds, position, east_north, error) result(status) &
        bind(c, name='gracecg_wind_evaluate')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_utc_t), intent(in), optional :: epoch
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: seconds(*), position(3, *)
        real(c_double), intent(inout), optional :: east_north(2, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(atmosphere_point_t) :: point
        type(utc_t) :: start_time, time
        real(dp) :: wind(2)
        integer(c_size_t) :: i

        call start_series(epoch, n, present(seconds), present(position), start_time, status, error)
        if (n > 0) call need(present(east_north), 'east_north', status, error)
        if (status == STATUS_OK .and. n > 0) call check_distance(position, n, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (wind_object_t)
            do i = 1, n
                call later_time(start_time, seconds(i), time, status, error)
                if (status /= STATUS_OK) exit
                call point_at(time, position(:, i), point)
                call object%model%evaluate(point%latitude, point%local_solar_time, wind(1), wind(2))
                call check_result(wind, 'the wind', status, error)
                if (status /= STATUS_OK) exit
                east_north(:, i) = wind
            end do
        class default
            call refuse_handle('wind', status, error)
        end select
        call release(int(handle, i8), object)
    end function c_wind_evaluate

    !> gracecg_sun_position
    function c_sun_position(epoch, n, seconds, position, error) result(status) &
        bind(c, name='gracecg_sun_position')
        type(c_utc_t), intent(in), optional :: epoch
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: seconds(*)
        real(c_double), intent(inout), optional :: position(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(utc_t) :: start_time, time
        integer(c_size_t) :: i

        call start_series(epoch, n, present(seconds), present(position), start_time, status, error)
        if (status /= STATUS_OK) return
        do i = 1, n
            call later_time(start_time, seconds(i), time, status, error)
            if (status /= STATUS_OK) exit
            position(:, i) = sun_position(julian_centuries_tt(time))
        end do
    end function c_sun_position

    !> gracecg_sun_illumination
    function c_sun_illumination(n, position, sun, illumination, error) result(status) &
        bind(c, name='gracecg_sun_illumination')
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: position(3, *), sun(3, *)
        real(c_double), intent(inout), optional :: illumination(*)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        real(dp) :: value(1)
        integer(c_size_t) :: i

        call start_points(n, present(position), status, error)
        if (n > 0) call need(present(sun), 'sun', status, error)
        if (n > 0) call need(present(illumination), 'illumination', status, error)
        if (status /= STATUS_OK .or. n == 0) return
        call check_distance(position, n, status, error)
        call check_finite(sun, 3*n, 'sun', status, error)
        if (status /= STATUS_OK) return
        do i = 1, n
            value = conical_shadow(position(:, i), sun(:, i))
            call check_result(value, 'the illumination', status, error)
            if (status /= STATUS_OK) exit
            illumination(i) = value(1)
        end do
    end function c_sun_illumination

    !> gracecg_earth_radiation_open
    function c_earth_radiation_open(constants, rings, solar_irradiance, handle, error) result(status) &
        bind(c, name='gracecg_earth_radiation_open')
        character(kind=c_char), intent(in), optional :: constants(*)
        integer(c_int32_t), intent(in), value :: rings
        real(c_double), intent(in), value :: solar_irradiance
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(earth_radiation_object_t) :: made
        type(error_t), allocatable :: failure
        character(:), allocatable :: name

        call start(status, error)
        call need(present(handle), 'model', status, error)
        if (present(handle)) handle = 0
        call fortran_text(constants, LONGEST_NAME, 'constants', name, status, error)
        if (status /= STATUS_OK) return
        if (rings < 0 .or. rings > MOST_RINGS) then
            call raise(STATUS_BAD_VALUE, 'rings = '//integer_text(rings)//' is outside 0 to '// &
                       integer_text(MOST_RINGS), status, error)
            return
        end if
        call new_earth_radiation(made%model, name, standard_rings(rings), solar_irradiance, failure)
        call pass_on(failure, status, error)
        if (status /= STATUS_OK) return
        call keep_copy(made, handle, status, error)
    end function c_earth_radiation_open

    !> gracecg_earth_radiation_free
    function c_earth_radiation_free(handle, error) result(status) &
        bind(c, name='gracecg_earth_radiation_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(earth_radiation_object_t) :: mold

        call free_object(handle, 'Earth radiation model', status, error, mold)
    end function c_earth_radiation_free

    !> gracecg_earth_radiation_flux
    function c_earth_radiation_flux(handle, epoch, n, seconds, position, flux, error) result(status) &
        bind(c, name='gracecg_earth_radiation_flux')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_utc_t), intent(in), optional :: epoch
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: seconds(*), position(3, *)
        real(c_double), intent(inout), optional :: flux(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(earth_irradiance_t) :: light
        type(utc_t) :: start_time
        real(dp) :: sum_of_light(3)
        integer(c_size_t) :: i
        integer :: j

        call start_series(epoch, n, present(seconds), present(position), start_time, status, error)
        if (n > 0) call need(present(flux), 'flux', status, error)
        if (status == STATUS_OK .and. n > 0) call check_above_ground(position, n, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (earth_radiation_object_t)
            do i = 1, n
                call light_at(object%model, start_time, seconds(i), position(:, i), light, status, error)
                if (status /= STATUS_OK) exit
                sum_of_light = 0
                do j = 1, light%count
                    sum_of_light = sum_of_light + light%irradiance(j)*light%direction(:, j)
                end do
                flux(:, i) = sum_of_light
            end do
        class default
            call refuse_handle('Earth radiation model', status, error)
        end select
        call release(int(handle, i8), object)
    end function c_earth_radiation_flux

    !> Positions: finite, and outside the Earth.
    subroutine check_above_ground(position, n, status, error)
        real(dp), intent(in) :: position(3, *)
        integer(c_size_t), intent(in) :: n
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        integer(c_size_t) :: i

        call check_finite(position, 3*n, 'position', status, error)
        if (status /= STATUS_OK) return
        do i = 1, n
            if (norm2(position(:, i)) > EARTH_RADIUS_EGM96) cycle
            call raise(STATUS_BAD_VALUE, 'position '//integer_text(int(i, i8))//' lies inside the Earth; '// &
                       'positions have to be in metres', status, error)
            return
        end do
    end subroutine check_above_ground

    !> The Earth's light at a place and time.
    subroutine light_at(model, epoch, seconds, position, light, status, error)
        type(earth_radiation_t), intent(in) :: model
        type(utc_t), intent(in) :: epoch
        real(dp), intent(in) :: seconds
        real(dp), intent(in) :: position(3)         !! Inertial, m
        type(earth_irradiance_t), intent(out) :: light
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        type(utc_t) :: time

        call later_time(epoch, seconds, time, status, error)
        if (status /= STATUS_OK) return
        call model%irradiance_at(position, sun_position(julian_centuries_tt(time)), &
                                 time%mjd + time%seconds/SECONDS_PER_DAY + &
                                 (MJD_TO_JD - EARTH_RADIATION_EPOCH_JD), light)
        call check_result(light%irradiance(:light%count), 'the irradiance', status, error)
    end subroutine light_at

    !> gracecg_earth_radiation_segments
    function c_earth_radiation_segments(handle, epoch, seconds, position, capacity, count, irradiance, &
                                        direction, error) result(status) &
        bind(c, name='gracecg_earth_radiation_segments')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_utc_t), intent(in), optional :: epoch
        real(c_double), intent(in), value :: seconds
        real(c_double), intent(in), optional :: position(3)
        integer(c_size_t), intent(in), value :: capacity
        integer(c_size_t), intent(inout), optional :: count
        real(c_double), intent(inout), optional :: irradiance(*), direction(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(earth_irradiance_t) :: light
        type(utc_t) :: start_time

        call start_series(epoch, 1_c_size_t, .true., present(position), start_time, status, error)
        call check_count(capacity, 'capacity', status, error)
        call need(present(count), 'count', status, error)
        call need(present(irradiance), 'irradiance', status, error)
        call need(present(direction), 'direction', status, error)
        if (status /= STATUS_OK) return
        count = 0
        call check_above_ground(position, 1_c_size_t, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (earth_radiation_object_t)
            call light_at(object%model, start_time, seconds, position, light, status, error)
            if (status == STATUS_OK) then
                count = light%count
                if (capacity < count) then
                    call raise(STATUS_BAD_SIZE, 'there are '//integer_text(light%count)//' segments; '// &
                               'the arrays have room for '//integer_text(int(capacity, i8))//' (at most '// &
                               integer_text(MAX_SEGMENTS)//' are ever needed)', status, error)
                else
                    irradiance(:count) = light%irradiance(:count)
                    direction(:, :count) = light%direction(:, :count)
                end if
            end if
        class default
            call refuse_handle('Earth radiation model', status, error)
        end select
        call release(int(handle, i8), object)
    end function c_earth_radiation_segments
end module gracecg_interface_c_models
