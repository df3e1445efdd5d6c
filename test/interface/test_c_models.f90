!> The C interface to time and models, called as C calls it: the numbers are those of the Fortran API.
module test_c_models
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_int32_t, c_intptr_t, c_size_t
    use vocabulary
    use gracecg, only: utc_t, parse_utc, utc_plus, gmst_1982, geopotential_t, egm96, igrf_t, igrf, decimal_year, dtm_t, &
        new_dtm, density_model_t, new_density_model, density_settings_t, DENSITY_MODELS, atmosphere_point_t, &
        atmosphere_state_t, earth_fixed_to_geodetic, local_mean_solar_time, day_of_year, embedded_wind, tabulated_wind_t, &
        sun_position, conical_shadow, julian_centuries_tt, ESTIMATOR_NAMES, CASE_NAMES, LIBRARY_VERSION, earth_radiation_t, &
        new_earth_radiation, standard_rings, EARTH_RADIATION_EPOCH_JD
    use gracecg_interface_general, only: INTERFACE_VERSION
    use c_library
    use c_checks
    implicit none
    private
    public :: collect_c_models

contains

    subroutine collect_c_models(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('constant-texts', test_constant_texts), &
                    new_unittest('time', test_time), &
                    new_unittest('gravity', test_gravity), &
                    new_unittest('geomagnetic-field', test_field), &
                    new_unittest('density-and-wind', test_air), &
                    new_unittest('sun-and-earth-radiation', test_light)]
    end subroutine collect_c_models

    subroutine test_constant_texts(error)
        type(error_type), allocatable, intent(out) :: error
        integer(c_int32_t) :: i

        call check(error, text_at(gracecg_version()), LIBRARY_VERSION)
        call check(error, int(gracecg_interface_version()), int(INTERFACE_VERSION))
        do i = 1, size(ESTIMATOR_NAMES)
            call check(error, text_at(gracecg_name(c_string('algorithm'), i - 1)), trim(ESTIMATOR_NAMES(i)))
        end do
        do i = 1, size(CASE_NAMES)
            call check(error, text_at(gracecg_name(c_string('case'), i - 1)), trim(CASE_NAMES(i)))
        end do
        call check(error, .not. (c_associated(gracecg_name(c_string('algorithm'), -1)) .or. &
                                c_associated(gracecg_name(c_string('algorithm'), size(ESTIMATOR_NAMES))) .or. &
                                c_associated(gracecg_name(c_string('case'), size(CASE_NAMES))) .or. &
                                c_associated(gracecg_name(c_string('cases'), 0)) .or. &
                                c_associated(gracecg_name(index=0))), 'no NULL outside')
        call check(error, text_at(gracecg_status_text(OK)), 'success')
        call check(error, text_at(gracecg_status_text(NO_MEMORY)), 'no memory')
        call check(error, text_at(gracecg_status_text(NOT_USABLE)), 'not to be used')
        call check(error, text_at(gracecg_status_text(99)), 'unknown status')
        call check(error, text_at(gracecg_status_text(-1)), 'unknown status')
    end subroutine test_constant_texts

    subroutine test_time(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_struct) :: before, after
        character(kind=c_char) :: text(32)
        type(utc_t) :: time
        type(error_t), allocatable :: problem
        real(dp) :: angle

        call check_ok(error, gracecg_utc_parse(c_string('1989-12-31T23:59:59'), before, failure))
        call check_ok(error, gracecg_utc_plus(before, 1.5_dp, after, failure))      ! into a leap second
        call check_ok(error, gracecg_utc_text(after, text, size(text, kind=c_size_t), error=failure))
        call check(error, transfer(text(:21), repeat(' ', 21)), '1989-12-31T23:59:60.5')
        call check_ok(error, gracecg_utc_difference(before, after, angle, failure))
        call check_equal(error, [angle], [1.5_dp], 'seconds between')
        call check_refused(error, BAD_VALUE, 'seconds', gracecg_utc_plus(before, 1e10_dp, after, failure))
        call parse_utc(DATE, time, problem)
        status = gracecg_sidereal_angle(utc_struct(time%mjd, time%seconds), -0.1_dp, angle, failure)
        call check_equal(error, [angle], [gmst_1982(time, -0.1_dp)], 'sidereal angle')
        call check_refused(error, BAD_VALUE, 'month 13', gracecg_utc_parse(c_string('1989-13-02'), before, failure))
        call check_refused(error, BAD_VALUE, 'ut1_minus_utc', gracecg_sidereal_angle(before, 2.0_dp, angle, failure))
    end subroutine test_time

    subroutine test_gravity(error)
        type(error_type), allocatable, intent(out) :: error
        type(geopotential_t) :: model
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: gravity
        real(dp) :: positions(3, 2), a(3, 2), u(2), g(9, 2), expected(3), potential, tensor(3, 3)
        integer :: i

        call check_ok(error, gracecg_gravity_open(c_string('egm96'), 30, 25, gravity, failure))
        positions(:, 1) = PLACE
        positions(:, 2) = [6.9e6_dp, 0.0_dp, -1e5_dp]
        call check_ok(error, gracecg_gravity_evaluate(gravity, 2_c_size_t, positions, a, u, g, failure))
        call egm96(30, 25, model, problem)
        do i = 1, 2
            call model%acceleration(positions(:, i), expected)
            call model%potential(positions(:, i), potential)
            call model%gradient_tensor(positions(:, i), tensor)
            call check_equal(error, a(:, i), expected, 'acceleration')
            call check_equal(error, u(i:i), [potential], 'potential')
            call check_equal(error, g(:, i), [tensor], 'gradient')
        end do
        status = gracecg_gravity_evaluate(gravity, NONE, error=failure)
        call check(error, int(status), int(OK), 'no points')
        status = gracecg_free(gravity, failure)
        call check(error, gravity == 0 .and. status == OK, 'the handle after free')

        status = gracecg_gravity_open(c_string('point-mass'), 0, 0, gravity, failure)
        status = gracecg_gravity_evaluate(gravity, ONE, PLACE, a, error=failure)
        call check_equal(error, a(:, 1), -398600.4415e9_dp/(dot_product(PLACE, PLACE)*norm2(PLACE))*PLACE, &
                         'point mass')
        status = gracecg_free(gravity)
        status = gracecg_gravity_open(c_string('point-mass'), 2, 0, gravity, failure)
        call check_refused(error, BAD_VALUE, 'a point mass has degree')
        call check_refused(error, BAD_VALUE, 'degree = 71', gracecg_gravity_open(c_string('egm96'), 71, 0, gravity, failure))
    end subroutine test_gravity

    subroutine test_field(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_struct) :: date_of_field
        type(igrf_t) :: model
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: field
        real(dp) :: b(3), expected(3)

        status = gracecg_utc_parse(c_string(DATE), date_of_field)
        call check_ok(error, gracecg_field_open(c_string('igrf95'), date_of_field, field, failure))
        call check_ok(error, gracecg_field_evaluate(field, ONE, PLACE, b, failure))
        call igrf('igrf95', decimal_year(utc_t(date_of_field%mjd, date_of_field%seconds)), model, problem)
        call model%evaluate(PLACE, expected)
        call check_equal(error, b, expected, 'field')
        status = gracecg_free(field)
        status = gracecg_field_open(c_string('igrf95'), utc_struct(60000, 0.0_dp), field, failure)
        call check_refused(error, BAD_VALUE, 'igrf14 covers')
    end subroutine test_field

    subroutine test_air(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_struct) :: epoch
        type(utc_t) :: time
        type(dtm_t) :: model
        class(density_model_t), allocatable :: any_model
        integer :: i
        type(tabulated_wind_t) :: table
        type(atmosphere_point_t) :: point
        type(atmosphere_state_t) :: air
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: density, wind
        real(dp) :: rho(1), t(1), numbers(3), longitude, blows(2), expected(2)
        real(dp), parameter :: SECONDS(1) = [5000.0_dp]

        status = gracecg_utc_parse(c_string(DATE), epoch)
        status = gracecg_density_open(c_string('dtm77'), indices=[200.0_dp, 180.0_dp, 3.0_dp], density=density, error=failure)
        call check_ok(error)
        call check_ok(error, gracecg_density_evaluate(density, epoch, ONE, SECONDS, PLACE, rho, t, numbers, failure))
        call new_dtm('dtm77', 200.0_dp, 180.0_dp, 3.0_dp, model, problem)
        time = utc_plus(utc_t(epoch%mjd, epoch%seconds), SECONDS(1))
        call earth_fixed_to_geodetic(PLACE, point%latitude, longitude, point%height)
        point%local_solar_time = local_mean_solar_time(time, longitude)
        point%day_of_year = day_of_year(time)
        call model%evaluate(point, air)
        call check_equal(error, [rho, t, numbers], &
                         [air%density, air%temperature, air%n_he, air%n_o, air%n_n2], 'density')
        status = gracecg_density_evaluate(density, epoch, ONE, SECONDS, 0.945_dp*PLACE, rho, error=failure)
        call check_refused(error, BAD_VALUE, '120 km')
        status = gracecg_free(density)
        status = gracecg_density_open(c_string('dtm77'), epoch, density=density, error=failure)
        call check(error, int(status), int(OK), 'indices of the table')
        status = gracecg_free(density)
        status = gracecg_density_open(c_string('dtm77'), utc_struct(50000, 0.0_dp), density=density, error=failure)
        call check_refused(error, BAD_VALUE, 'no space weather')

        do i = 1, size(DENSITY_MODELS)
            status = gracecg_density_open(c_string(trim(DENSITY_MODELS(i))), epoch, density=density, error=failure)
            call check_ok(error)
            status = gracecg_density_evaluate(density, epoch, ONE, SECONDS, PLACE, rho, t, numbers, failure)
            call new_density_model(trim(DENSITY_MODELS(i)), utc_t(epoch%mjd, epoch%seconds), density_settings_t(), &
                                   any_model, problem)
            call any_model%evaluate(point, air)
            call check_equal(error, [rho, t, numbers + 1], &
                             [air%density, air%temperature, air%n_he + 1, air%n_o + 1, air%n_n2 + 1], DENSITY_MODELS(i))
            status = gracecg_free(density)
        end do
        status = gracecg_density_open(c_string('dtm94'), indices=[200.0_dp, 180.0_dp, 12.0_dp], density=density, error=failure)
        call check_refused(error, BAD_VALUE, 'kp')
        status = gracecg_density_open(c_string('dtm95'), epoch, density=density, error=failure)
        call check_refused(error, HAS_FAILED, 'dtm94')
        status = gracecg_density_open(c_string('dtm94'), density=density, error=failure)
        call check_refused(error, NULL_POINTER, 'date or indices')
        status = gracecg_density_open(c_string('dtm94'), epoch, [200.0_dp, 180.0_dp, 3.0_dp], density, failure)
        call check_refused(error, BAD_VALUE, 'not both')

        call check_ok(error, gracecg_wind_open(c_string('hwm93'), wind, failure))
        status = gracecg_wind_evaluate(wind, epoch, ONE, SECONDS, PLACE, blows, failure)
        table = embedded_wind()
        call table%evaluate(point%latitude, point%local_solar_time, expected(1), expected(2))
        call check_equal(error, blows, expected, 'wind')
        status = gracecg_free(wind)
    end subroutine test_air

    !> The flux, the Sun and its shadow are those of the Fortran API.
    subroutine test_light(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_struct) :: epoch
        integer(c_intptr_t) :: model
        type(utc_t) :: time
        type(earth_radiation_t) :: light
        type(error_t), allocatable :: problem
        real(dp) :: sun(3), free(1), flux(3), expected(3)
        real(dp), parameter :: SECONDS(1) = [1000.0_dp]

        status = gracecg_utc_parse(c_string(DATE), epoch)
        call check_ok(error, gracecg_sun_position(epoch, ONE, SECONDS, sun, failure))
        call check_equal(error, sun, sun_position(julian_centuries_tt( &
                                                  utc_plus(utc_t(epoch%mjd, epoch%seconds), SECONDS(1)))), 'Sun')
        status = gracecg_sun_illumination(ONE, PLACE, sun, free, failure)
        call check_equal(error, free + 1, [conical_shadow(PLACE, sun)] + 1, 'illumination')

        call check_ok(error, gracecg_earth_radiation_open(c_string('report'), 2, 1367.0_dp, model, failure))
        call check_ok(error, gracecg_earth_radiation_evaluate(model, epoch, ONE, SECONDS, PLACE, flux, error=failure))
        time = utc_plus(utc_t(epoch%mjd, epoch%seconds), SECONDS(1))
        call new_earth_radiation('report', standard_rings(2), 1367.0_dp, light, problem)
        call light%flux_at(PLACE, sun_position(julian_centuries_tt(time)), &
                           time%mjd + time%seconds/86400 + (2400000.5_dp - EARTH_RADIATION_EPOCH_JD), expected)
        call check_equal(error, flux, expected, 'flux')
        ! some 240 W/m^2 of heat, and reflected light; upwards
        call check(error, dot_product(flux, PLACE)/norm2(PLACE) > 150 .and. &
                   dot_product(flux, PLACE)/norm2(PLACE) < 600, 'size of the flux')
        status = gracecg_earth_radiation_evaluate(model, epoch, ONE, SECONDS, 0.9_dp*PLACE, flux, error=failure)
        call check_refused(error, BAD_VALUE, 'inside the Earth')
        status = gracecg_free(model)
        status = gracecg_earth_radiation_open(c_string('report'), 8, 1367.0_dp, model, failure)
        call check_refused(error, BAD_VALUE, 'rings = 8')
        status = gracecg_earth_radiation_open(c_string('report'), -1, 1367.0_dp, model, failure)
        call check_refused(error, BAD_VALUE, 'rings = -1')
        status = gracecg_earth_radiation_open(c_string('knoke'), 1, 1367.0_dp, model, failure)
        call check_refused(error, HAS_FAILED, 'knocke')
    end subroutine test_light
end module test_c_models
