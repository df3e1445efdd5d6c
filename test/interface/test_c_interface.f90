!> The C interface, called as C calls it: the numbers are those of the Fortran API, and misuse is
!> refused with a status and a message.
module test_c_interface
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_double, c_int, c_int32_t, c_intptr_t, &
        c_loc, c_null_char, c_size_t
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_positive_inf
    use gracecg, only: estimation_options_t, report_options, calibration_t, find_calibration, calibration_text
    use gracecg, only: dp, error_t, message_of, utc_t, parse_utc, utc_plus, seconds_between, gmst_1982, &
        geopotential_t, egm96, igrf_t, igrf, decimal_year, dtm_t, new_dtm, &
        density_model_t, new_density_model, density_settings_t, DENSITY_MODELS, atmosphere_point_t, &
        atmosphere_state_t, earth_fixed_to_geodetic, local_mean_solar_time, day_of_year, embedded_wind, &
        tabulated_wind_t, sun_position, conical_shadow, julian_centuries_tt, satellite_surface_t, &
        new_trapezoid, projected_area, drag_acceleration, solar_radiation_acceleration, &
        aerodynamic_load, solar_radiation_load, surface_load_t, gas_t, wall_t, mean_molar_mass, &
        case_t, find_case, case_text, build_dynamics, initial_state, satellite_dynamics_t, &
        accelerations_t, loads_t, truth_arc_t, propagate_arc, simulator_t, new_simulator, observe, &
        observation_set_t, solution_t, estimate_offset, ESTIMATOR_NAMES, CASE_NAMES, &
        case_bound_t, bound_of_case, design_settings_t, manoeuvre_design_t, plan_manoeuvre, map_point_t, map_case, &
        LIBRARY_VERSION, rotation_z, rotation_matrix, quaternion_product, conjugate_quaternion, &
        STATE_POSITION, STATE_VELOCITY, STATE_ATTITUDE, moment_series_t, new_moment_series, take_measured_moments, &
        dipole_moment
    use gracecg, only: joint_run_t, joint_solution_t, joint_options_t, run_from_observations, estimate_runs, arc_chain_t, &
        estimate_chain
    use gracecg_files_file, only: make_directory
    use gracecg_interface_handles, only: live_objects, MAX_OBJECTS
    use gracecg_simulation_arc, only: MAX_STEPS
    use c_library
    use fixture, only: FOLDER, make_folder, make_file, check_fails
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_c_interface

    integer(c_int), parameter :: OK = 0, NULL_POINTER = 1, BAD_HANDLE = 2, BAD_SIZE = 3, BAD_VALUE = 4
    integer(c_int), parameter :: FAILED = 5, NOT_CONVERGED = 6, NO_MEMORY = 7
    integer(c_size_t), parameter :: ONE = 1, NONE = 0
    character(*), parameter :: DATE = '1989-01-02T00:00:00'
    real(dp), parameter :: PLACE(3) = [-1.2e6_dp, 5.3e6_dp, 4.1e6_dp]   !! m
    real(dp), parameter :: MASS = 420.0_dp
    integer, parameter :: W = 60        !! Width of a part of a message

contains

    subroutine collect_c_interface(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('constant-texts', test_constant_texts), &
                    new_unittest('time', test_time), &
                    new_unittest('gravity', test_gravity), &
                    new_unittest('geomagnetic-field', test_field), &
                    new_unittest('density-and-wind', test_air), &
                    new_unittest('sun-and-earth-radiation', test_light), &
                    new_unittest('surface', test_surface), &
                    new_unittest('case-text', test_case_text), &
                    new_unittest('force-model', test_force_model), &
                    new_unittest('torques-and-rate', test_torques), &
                    new_unittest('propagation', test_propagation), &
                    new_unittest('truth', test_truth), &
                    new_unittest('estimate-as-in-fortran', test_estimate), &
                    new_unittest('joint-estimate-as-in-fortran', test_joint_estimate), &
                    new_unittest('chain-as-in-fortran', test_chain), &
                    new_unittest('observations-from-arrays', test_arrays), &
                    new_unittest('observations-in-files', test_files), &
                    new_unittest('options', test_options), &
                    new_unittest('level1-estimate-misused', test_level1_misuse), &
                    new_unittest('optimal-and-sequential', test_details), &
                    new_unittest('bound', test_bound), &
                    new_unittest('design-and-map', test_design), &
                    new_unittest('design-misused', test_design_misuse), &
                    new_unittest('null-pointers', test_null), &
                    new_unittest('invalid-handles', test_handles), &
                    new_unittest('freed-twice', test_freed_twice), &
                    new_unittest('too-many-objects', test_too_many), &
                    new_unittest('wrong-names', test_names), &
                    new_unittest('values-not-finite', test_not_finite), &
                    new_unittest('samples-not-finite', test_bad_samples), &
                    new_unittest('wrong-sizes', test_sizes), &
                    new_unittest('states-out-of-range', test_states), &
                    new_unittest('long-texts', test_long_texts), &
                    new_unittest('not-converged', test_not_converged), &
                    new_unittest('nothing-is-left', test_nothing_left)]
    end subroutine collect_c_interface

    !> A call must have succeeded.
    subroutine check_ok(error, status, failure)
        type(error_type), allocatable, intent(out) :: error
        integer(c_int), intent(in) :: status
        type(error_struct), intent(in) :: failure

        call check(error, int(status), int(OK), message_text(failure))
        if (allocated(error)) return
        call check(error, message_text(failure), '', 'a message after success')
    end subroutine check_ok

    !> A call must have failed with a status and, in its message, a text.
    subroutine check_refused(error, status, expected, failure, part)
        type(error_type), allocatable, intent(inout) :: error
        integer(c_int), intent(in) :: status, expected
        type(error_struct), intent(in) :: failure
        character(*), intent(in) :: part

        if (allocated(error)) return
        call check(error, int(status), int(expected), 'status of "'//part//'": '//message_text(failure))
        if (allocated(error)) return
        call check(error, int(failure%status), int(expected), 'status in the error')
        if (allocated(error)) return
        call check(error, index(message_text(failure), part) > 0, &
                   '"'//part//'" is not in "'//trim(message_text(failure))//'"')
    end subroutine check_refused

    subroutine check_equal(error, actual, expected, what)
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in) :: actual(:), expected(:)
        character(*), intent(in) :: what

        if (allocated(error)) return
        call check(error, all(abs(actual - expected) <= 0) .and. any(abs(expected) > 0), &
                   what//': other numbers than those of the Fortran API')
    end subroutine check_equal

    subroutine test_constant_texts(error)
        type(error_type), allocatable, intent(out) :: error

        integer(c_int32_t) :: i

        call check(error, text_at(gracecg_version()), LIBRARY_VERSION)
        if (allocated(error)) return
        call check(error, int(gracecg_algorithm_count()), size(ESTIMATOR_NAMES))
        do i = 0, gracecg_algorithm_count() - 1
            if (allocated(error)) return
            call check(error, text_at(gracecg_algorithm_name(i)), trim(ESTIMATOR_NAMES(i + 1)))
        end do
        if (allocated(error)) return
        call check(error, int(gracecg_case_count()), size(CASE_NAMES))
        do i = 0, gracecg_case_count() - 1
            if (allocated(error)) return
            call check(error, text_at(gracecg_case_name(i)), trim(CASE_NAMES(i + 1)))
        end do
        if (allocated(error)) return
        call check(error,.not. (c_associated(gracecg_algorithm_name(-1)) .or. &
                                c_associated(gracecg_algorithm_name(gracecg_algorithm_count())) .or. &
                                c_associated(gracecg_case_name(-1)) .or. &
                                c_associated(gracecg_case_name(gracecg_case_count()))), 'no NULL outside')
        if (allocated(error)) return
        call check(error, text_at(gracecg_status_text(OK)), 'success')
        if (allocated(error)) return
        call check(error, text_at(gracecg_status_text(NO_MEMORY)), 'no memory')
        if (allocated(error)) return
        call check(error, text_at(gracecg_status_text(99)), 'unknown status')
        if (allocated(error)) return
        call check(error, text_at(gracecg_status_text(-1)), 'unknown status')
    end subroutine test_constant_texts

    subroutine test_time(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(utc_struct) :: before, after
        type(utc_t) :: time
        type(error_t), allocatable :: problem
        integer(c_int) :: status
        real(dp) :: seconds, angle, back(3)

        status = gracecg_utc_parse(c_string('1989-12-31T23:59:59'), before, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_utc_add(before, 2.0_dp, after, failure)    ! over a leap second
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call check(error, after%mjd == before%mjd + 1 .and. abs(after%seconds) <= 0, 'leap second')
        if (allocated(error)) return
        status = gracecg_utc_difference(before, after, seconds, failure)
        call check(error, abs(seconds - 2) <= 0, 'difference over a leap second')
        if (allocated(error)) return
        call parse_utc(DATE, time, problem)
        status = gracecg_sidereal_angle(utc_struct(time%mjd, time%seconds), -0.1_dp, angle, failure)
        call check_equal(error, [angle], [gmst_1982(time, -0.1_dp)], 'sidereal angle')
        if (allocated(error)) return
        status = gracecg_earth_fixed(angle, ONE, PLACE, back, failure)
        call check_equal(error, back, matmul(rotation_z(angle), PLACE), 'Earth-fixed')
        status = gracecg_earth_fixed(-angle, ONE, back, back, failure)
        call check(error, maxval(abs(back - PLACE)) < 1e-8_dp, 'the way back')
        status = gracecg_utc_parse(c_string('1989-13-02'), before, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'month 13')
        status = gracecg_sidereal_angle(after, 2.0_dp, angle, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'ut1_minus_utc')
        status = gracecg_utc_add(utc_struct(0, 0.0_dp), 2.0_dp, after, failure)
        call check_refused(error, status, BAD_VALUE, failure, '1900')
        status = gracecg_utc_add(utc_struct(47528, 0.0_dp), 1e12_dp, after, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'outside')
    end subroutine test_time

    subroutine test_gravity(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(geopotential_t) :: model
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: gravity
        integer(c_int) :: status
        real(dp) :: positions(3, 2), a(3, 2), u(2), g(9, 2), expected(3), potential, tensor(3, 3)
        integer :: i

        status = gracecg_gravity_open(c_string('egm96'), 30, 25, gravity, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        positions(:, 1) = PLACE
        positions(:, 2) = [6.9e6_dp, 0.0_dp, -1e5_dp]
        status = gracecg_gravity_evaluate(gravity, 2_c_size_t, positions, a, u, g, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
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
        status = gracecg_gravity_free(gravity, failure)
        if (allocated(error)) return
        call check(error, gravity == 0 .and. status == OK, 'the handle after free')
        if (allocated(error)) return

        status = gracecg_gravity_open(c_string('point-mass'), 0, 0, gravity, failure)
        status = gracecg_gravity_evaluate(gravity, ONE, PLACE, a, error=failure)
        call check_equal(error, a(:, 1), -398600.4415e9_dp/(dot_product(PLACE, PLACE)*norm2(PLACE))*PLACE, &
                         'point mass')
        status = gracecg_gravity_free(gravity)
        status = gracecg_gravity_open(c_string('point-mass'), 2, 0, gravity, failure)
        call check_refused(error, status, FAILED, failure, 'a point mass has degree')
        status = gracecg_gravity_open(c_string('egm96'), 71, 0, gravity, failure)
        call check_refused(error, status, FAILED, failure, 'degree = 71')
    end subroutine test_gravity

    subroutine test_field(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(utc_struct) :: date_of_field
        type(igrf_t) :: model
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: field
        integer(c_int) :: status
        real(dp) :: b(3), expected(3)

        status = gracecg_utc_parse(c_string(DATE), date_of_field)
        status = gracecg_field_open(c_string('igrf95'), date_of_field, field, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_field_evaluate(field, ONE, PLACE, b, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call igrf('igrf95', decimal_year(utc_t(date_of_field%mjd, date_of_field%seconds)), model, problem)
        call model%evaluate(PLACE, expected)
        call check_equal(error, b, expected, 'field')
        status = gracecg_field_free(field)
        status = gracecg_field_open(c_string('igrf95'), utc_struct(60000, 0.0_dp), field, failure)
        call check_refused(error, status, FAILED, failure, 'igrf14 covers')
    end subroutine test_field

    subroutine test_air(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
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
        integer(c_int) :: status
        real(dp) :: rho(1), t(1), numbers(3), longitude, blows(2), expected(2)
        real(dp), parameter :: SECONDS(1) = [5000.0_dp]

        status = gracecg_utc_parse(c_string(DATE), epoch)
        status = gracecg_density_open_indices(200.0_dp, 180.0_dp, 3.0_dp, density, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_density_evaluate(density, epoch, ONE, SECONDS, PLACE, rho, t, numbers, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call new_dtm('dtm77', 200.0_dp, 180.0_dp, 3.0_dp, model, problem)
        time = utc_plus(utc_t(epoch%mjd, epoch%seconds), SECONDS(1))
        call earth_fixed_to_geodetic(PLACE, point%latitude, longitude, point%height)
        point%local_solar_time = local_mean_solar_time(time, longitude)
        point%day_of_year = day_of_year(time)
        call model%evaluate(point, air)
        call check_equal(error, [rho, t, numbers], &
                         [air%density, air%temperature, air%n_he, air%n_o, air%n_n2], 'density')
        status = gracecg_density_evaluate(density, epoch, ONE, SECONDS, 0.945_dp*PLACE, rho, error=failure)
        call check_refused(error, status, BAD_VALUE, failure, '120 km')
        status = gracecg_density_free(density)
        status = gracecg_density_open(epoch, density, failure)
        call check(error, int(status), int(OK), 'indices of the table')
        if (allocated(error)) return
        status = gracecg_density_free(density)
        status = gracecg_density_open(utc_struct(50000, 0.0_dp), density, failure)
        call check_refused(error, status, FAILED, failure, 'no space weather')

        do i = 1, size(DENSITY_MODELS)
            status = gracecg_density_open_model(c_string(trim(DENSITY_MODELS(i))), epoch, density, failure)
            call check_ok(error, status, failure)
            if (allocated(error)) return
            status = gracecg_density_evaluate(density, epoch, ONE, SECONDS, PLACE, rho, t, numbers, failure)
            call new_density_model(trim(DENSITY_MODELS(i)), utc_t(epoch%mjd, epoch%seconds), density_settings_t(), &
                                   any_model, problem)
            call any_model%evaluate(point, air)
            call check_equal(error, [rho, t, numbers + 1], &
                             [air%density, air%temperature, air%n_he + 1, air%n_o + 1, air%n_n2 + 1], DENSITY_MODELS(i))
            if (allocated(error)) return
            status = gracecg_density_free(density)
        end do
        status = gracecg_density_open_model_indices(c_string('dtm94'), 200.0_dp, 180.0_dp, 12.0_dp, density, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'kp')
        if (allocated(error)) return
        status = gracecg_density_open_model(c_string('dtm95'), epoch, density, failure)
        call check_refused(error, status, FAILED, failure, 'dtm94')
        if (allocated(error)) return

        status = gracecg_wind_open(c_string('hwm93'), wind, failure)
        call check_equal(error, [real(status, dp) + 1], [1.0_dp], 'wind, status')
        status = gracecg_wind_evaluate(wind, epoch, ONE, SECONDS, PLACE, blows, failure)
        table = embedded_wind()
        call table%evaluate(point%latitude, point%local_solar_time, expected(1), expected(2))
        call check_equal(error, blows, expected, 'wind')
        status = gracecg_wind_free(wind)
    end subroutine test_air

    !> The flux is the sum over the segments; the Sun and its shadow are those of the Fortran API.
    subroutine test_light(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(utc_struct) :: epoch
        integer(c_intptr_t) :: model
        integer(c_int) :: status
        integer(c_size_t) :: n
        real(dp) :: sun(3), free(1), flux(3), irradiance(19), direction(3, 19), segment_sum(3)
        real(dp), parameter :: SECONDS(1) = [1000.0_dp]
        integer :: i

        status = gracecg_utc_parse(c_string(DATE), epoch)
        status = gracecg_sun_position(epoch, ONE, SECONDS, sun, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call check_equal(error, sun, sun_position(julian_centuries_tt( &
                                                  utc_plus(utc_t(epoch%mjd, epoch%seconds), SECONDS(1)))), 'Sun')
        status = gracecg_sun_illumination(ONE, PLACE, sun, free, failure)
        call check_equal(error, free + 1, [conical_shadow(PLACE, sun)] + 1, 'illumination')
        if (allocated(error)) return

        status = gracecg_earth_radiation_open(c_string('report'), 2, 1367.0_dp, model, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_earth_radiation_flux(model, epoch, ONE, SECONDS, PLACE, flux, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_earth_radiation_segments(model, epoch, SECONDS(1), PLACE, 19_c_size_t, n, &
                                                  irradiance, direction, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        segment_sum = 0
        do i = 1, int(n)
            segment_sum = segment_sum + irradiance(i)*direction(:, i)
        end do
        call check_equal(error, flux, segment_sum, 'sum over the segments')
        ! some 240 W/m^2 of heat, and reflected light; upwards
        if (.not. allocated(error)) call check(error, dot_product(flux, PLACE)/norm2(PLACE) > 150 .and. &
                                               dot_product(flux, PLACE)/norm2(PLACE) < 600, 'size of the flux')
        status = gracecg_earth_radiation_segments(model, epoch, SECONDS(1), PLACE, 18_c_size_t, n, &
                                                  irradiance, direction, failure)
        call check_refused(error, status, BAD_SIZE, failure, 'there are 19 segments')
        status = gracecg_earth_radiation_free(model)
        status = gracecg_earth_radiation_open(c_string('report'), 8, 1367.0_dp, model, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'rings = 8')
        status = gracecg_earth_radiation_open(c_string('report'), -1, 1367.0_dp, model, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'rings = -1')
        status = gracecg_earth_radiation_open(c_string('knoke'), 1, 1367.0_dp, model, failure)
        call check_refused(error, status, FAILED, failure, 'knocke')
    end subroutine test_light

    subroutine test_surface(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(satellite_surface_t) :: body
        type(surface_load_t) :: load
        type(satellite_dynamics_t) :: dynamics
        type(loads_t) :: acting
        type(case_t) :: case
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: surface, same, model
        integer(c_int) :: status
        real(dp) :: a(3), area, force(3), torque(3), flux(3), state(13)
        real(dp), parameter :: V(3) = [7600.0_dp, 30.0_dp, -20.0_dp], COM(3) = [1e-2_dp, 0.0_dp, 5e-2_dp]
        real(dp), parameter :: TO_SUN(3) = [1e11_dp, 5e10_dp, -9e10_dp], UP(3) = [0.6_dp, 0.0_dp, -0.8_dp]
        real(dp), parameter :: NUMBERS(3) = [1e12_dp, 5e13_dp, 2e12_dp]

        status = gracecg_surface_trapezoid(3.122_dp, 0.72_dp, 1.942_dp, 0.693_dp, 0.2_dp, 0.1_dp, surface, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call new_trapezoid(body, 3.122_dp, 0.72_dp, 1.942_dp, 0.693_dp, 0.2_dp, 0.1_dp, problem)
        status = gracecg_surface_area(surface, UP, area, failure)
        call check_equal(error, [area], [projected_area(body, UP)], 'area')
        status = gracecg_surface_drag(surface, MASS, 2.3_dp, 4e-12_dp, V, a, failure)
        call check_equal(error, a, drag_acceleration(body, MASS, 2.3_dp, 4e-12_dp, V), 'drag')
        status = gracecg_surface_sunlight(surface, MASS, 0.4_dp, 1367.0_dp, 0.5_dp, TO_SUN, a, failure)
        call check_equal(error, a, solar_radiation_acceleration(body, MASS, 0.4_dp, 1367.0_dp, 0.5_dp, TO_SUN), &
                         'sunlight')
        status = gracecg_surface_aerodynamic_load(surface, COM, 4e-12_dp, 1200.0_dp, NUMBERS, 300.0_dp, &
                                                  0.9_dp, V, force, torque, failure)
        load = aerodynamic_load(body, COM, gas_t(4e-12_dp, 1200.0_dp, mean_molar_mass(NUMBERS)), &
                                wall_t(300.0_dp, 0.9_dp), V)
        call check_equal(error, [force, torque], [load%force, load%torque], 'aerodynamic load')
        status = gracecg_surface_sunlight_load(surface, COM, 1367.0_dp, 1.0_dp, TO_SUN, force, torque, failure)
        load = solar_radiation_load(body, COM, 1367.0_dp, 1.0_dp, TO_SUN)
        call check_equal(error, [force, torque], [load%force, load%torque], 'load of sunlight')
        status = gracecg_surface_create(6_c_size_t, 0*normals(body), body%area(:6), centres(body), &
                                        body%specular(:6), body%diffuse(:6), same, failure)
        call check(error, status /= OK .and. same == 0, 'plates with normals that are none')
        if (allocated(error)) return
        status = gracecg_surface_create(6_c_size_t, normals(body), body%area(:6), centres(body), &
                                        body%specular(:6), body%diffuse(:6), same, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_surface_sunlight_load(same, COM, 1367.0_dp, 1.0_dp, TO_SUN, force, torque, failure)
        call check_equal(error, [force, torque], [load%force, load%torque], 'the same body, of plates')
        status = gracecg_surface_free(same)

        ! the Earth's light: what the dynamics of a case have, from the pieces
        call find_case('front-1', case, problem)
        call build_dynamics(case, dynamics, problem)
        state = initial_state(case)
        call dynamics%loads(0.0_dp, state, acting)
        status = gracecg_earth_radiation_open(c_string('constant-emissivity'), 2, case%solar_irradiance, model)
        status = gracecg_earth_radiation_flux(model, utc_struct(47528, 0.0_dp), ONE, [0.0_dp], state(:3), flux)
        status = gracecg_surface_earthlight(surface, case%satellite%mass, case%satellite%reflectivity_earth, flux, state(:3), &
                                            state(10:13), a, failure)
        call check(error, norm2(a - acting%erp) < 1e-12_dp*norm2(acting%erp), 'the Earth''s light')
        status = gracecg_earth_radiation_free(model)

        status = gracecg_surface_drag(surface, 0.0_dp, 2.3_dp, 4e-12_dp, V, a, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'mass')
        status = gracecg_surface_sunlight(surface, MASS, 0.4_dp, 1367.0_dp, 1.5_dp, TO_SUN, a, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'illumination = 1.5')
        status = gracecg_surface_sunlight(surface, MASS, 0.4_dp, 1367.0_dp, 0.5_dp, 0*TO_SUN, a, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'to_sun is zero')
        status = gracecg_surface_area(surface, 2*UP, area, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'unit vector')
        status = gracecg_surface_aerodynamic_load(surface, COM, 4e-12_dp, 1200.0_dp, 0*NUMBERS, 300.0_dp, &
                                                  0.9_dp, V, force, torque, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'number_density')
        status = gracecg_surface_create(33_c_size_t, normals(body), body%area, centres(body), &
                                        body%specular, body%diffuse, same, failure)
        call check_refused(error, status, BAD_SIZE, failure, 'n = 33')
        status = gracecg_surface_free(surface)
    end subroutine test_surface

    pure function normals(body) result(n)
        type(satellite_surface_t), intent(in) :: body
        real(dp) :: n(18)

        n = pack(transpose(body%normal(:6, :)), .true.)
    end function normals

    pure function centres(body) result(c)
        type(satellite_surface_t), intent(in) :: body
        real(dp) :: c(18)

        c = pack(transpose(body%centre(:6, :)), .true.)
    end function centres

    !> The text of a case is that of the Fortran API, and makes the same case again.
    subroutine test_case_text(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(calibration_t) :: calibration
        type(error_t), allocatable :: problem
        character(:), allocatable :: expected
        character(kind=c_char), allocatable, target :: text(:), again(:)
        integer(c_intptr_t) :: handle, copy
        integer(c_size_t) :: length
        integer(c_int) :: status

        status = gracecg_case_open(c_string('back-2'), handle, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_case_text(handle, size=NONE, length=length, error=failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call find_calibration('back-2', calibration, problem)
        call calibration_text(calibration, expected, problem)
        call check(error, int(length), len(expected), 'length')
        if (allocated(error)) return
        allocate (text(length + 1), again(length + 1))
        status = gracecg_case_text(handle, text, length, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'the text needs')
        call check(error, text(1) == c_null_char, 'no empty text after a failure')
        if (allocated(error)) return
        status = gracecg_case_text(handle, text, length + 1, error=failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call check(error, text_at(c_loc(text)) == expected, 'another text')
        if (allocated(error)) return
        status = gracecg_case_parse(text, copy, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_case_text(copy, again, length + 1, error=failure)
        call check(error, all(again == text), 'another case from the text')
        if (allocated(error)) return
        call check(error, copy /= handle, 'two cases of one handle')
        status = gracecg_case_free(handle)
        status = gracecg_case_free(copy)
        if (allocated(error)) return
        status = gracecg_case_parse(c_string('&truth positon = 1 /'), handle, failure)
        call check_refused(error, status, FAILED, failure, 'text')
    end subroutine test_case_text

    !> Two epochs at once, parts and sum; each output may be NULL.
    subroutine test_force_model(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(utc_struct) :: epoch
        type(case_t) :: case
        type(satellite_dynamics_t) :: dynamics
        type(accelerations_t) :: acting
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: handle, model
        integer(c_int) :: status
        real(dp) :: state(13), x(3, 2), v(3, 2), q(4, 2), g(3, 2), d(3, 2), s(3, 2), e(3, 2), total(3, 2)
        real(dp) :: alone(3, 2), angle
        real(dp), parameter :: SECONDS(2) = [0.0_dp, 12.5_dp]
        integer :: i

        status = gracecg_case_open(c_string('front-3'), handle)
        status = gracecg_force_model_open(handle, model, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_case_values(handle, state=state, error=failure)
        call find_case('front-3', case, problem)
        call check_equal(error, state, initial_state(case), 'initial state')
        x = spread(state(STATE_POSITION), 2, 2)
        v = spread(state(STATE_VELOCITY), 2, 2)
        q = spread(state(STATE_ATTITUDE), 2, 2)
        x(:, 2) = x(:, 2) + SECONDS(2)*v(:, 2)
        status = gracecg_force_model_evaluate(model, 2_c_size_t, SECONDS, x, v, q, g, d, s, e, total, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call build_dynamics(case, dynamics, problem)
        do i = 1, 2
            call dynamics%accelerations(SECONDS(i), x(:, i), v(:, i), q(:, i), acting)
            call check_equal(error, [g(:, i), d(:, i), e(:, i), total(:, i)], &
                             [acting%gravity, acting%drag, acting%earth_radiation, acting%total], 'forces')
            call check_equal(error, s(:, i) + 1, acting%solar_radiation + 1, 'sunlight')
        end do
        status = gracecg_force_model_evaluate(model, 2_c_size_t, SECONDS, x, v, q, total=alone, error=failure)
        call check_equal(error, [alone], [total], 'the sum alone')
        status = gracecg_force_model_epoch(model, epoch, angle, failure)
        call check_equal(error, [real(epoch%mjd, dp), epoch%seconds, angle], &
                         [real(case%epoch%mjd, dp), case%epoch%seconds, &
                             case%sidereal_angle], 'epoch')
        status = gracecg_force_model_free(model)
        status = gracecg_case_free(handle)
    end subroutine test_force_model

    subroutine test_torques(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(case_t) :: case
        type(satellite_dynamics_t) :: dynamics
        type(loads_t) :: acting
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: handle, model
        integer(c_int) :: status
        real(dp) :: state(13), rate(13), expected(13), air(3), sun(3), gradient(3), rods(3), b(3)
        real(dp), parameter :: T = 2.5_dp

        status = gracecg_case_open(c_string('back-1'), handle)
        status = gracecg_force_model_open(handle, model, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call find_case('back-1', case, problem)
        call build_dynamics(case, dynamics, problem)
        state = initial_state(case)
        call dynamics%loads(T, state, acting)
        status = gracecg_force_model_torques(model, T, state, air, sun, gradient, rods, b, failure)
        call check_equal(error, [air, sun, gradient, rods, b], &
                         [acting%torque_aero, acting%torque_solar, acting%torque_gravity, &
                          acting%torque_magnetic, acting%field], 'torques')
        call dynamics%rate(T, state, expected)
        status = gracecg_force_model_rate(model, T, state, rate, failure)
        call check_equal(error, rate, expected, 'rate')
        status = gracecg_force_model_free(model)
        status = gracecg_case_free(handle)
    end subroutine test_torques

    subroutine test_propagation(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: STEPS = 50
        type(error_struct) :: failure
        type(case_t) :: case
        type(satellite_dynamics_t) :: dynamics
        type(truth_arc_t) :: arc
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: handle, model
        integer(c_int) :: status
        real(dp) :: state(13), states(13, 0:STEPS)

        status = gracecg_case_open(c_string('front-2'), handle)
        status = gracecg_force_model_open(handle, model, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call find_case('front-2', case, problem)
        call build_dynamics(case, dynamics, problem)
        state = initial_state(case)
        call propagate_arc(dynamics, state, 0.2_dp, STEPS, arc, problem)
        status = gracecg_force_model_propagate(model, state, 0.2_dp, int(STEPS, c_size_t), 0.0_dp, states, failure)
        call check_equal(error, [states], [arc%state], 'fixed steps')
        call propagate_arc(dynamics, state, 0.2_dp, STEPS, arc, problem, 1e-12_dp)
        status = gracecg_force_model_propagate(model, state, 0.2_dp, int(STEPS, c_size_t), 1e-12_dp, states, failure)
        call check_equal(error, [states], [arc%state], 'with step-size control')
        states = 0
        status = gracecg_force_model_propagate(model, state, 0.2_dp, NONE, 0.0_dp, states, failure)
        call check_equal(error, states(:, 0), state, 'no step')
        status = gracecg_force_model_propagate(model, state, -0.2_dp, ONE, 0.0_dp, states, failure)
        call check_refused(error, status, FAILED, failure, 'interval')
        status = gracecg_force_model_propagate(model, state, 0.2_dp, ONE, -1.0_dp, states, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'tolerance')
        status = gracecg_force_model_propagate(model, state, 0.2_dp, int(MAX_STEPS + 1, c_size_t), 0.0_dp, &
                                               states, failure)
        call check_refused(error, status, BAD_SIZE, failure, 'steps')
        status = gracecg_force_model_propagate_nadir(model, state(1:3), -state(1:3), 1_c_int32_t, 1.0_dp, ONE, 0.0_dp, &
                                                     states, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'plane')
        status = gracecg_force_model_propagate_nadir(model, state(1:3), -state(1:3)*[1.0_dp, 1 + epsilon(1.0_dp), 1.0_dp], &
                                                     1_c_int32_t, 1.0_dp, ONE, 0.0_dp, states, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'plane')
        if (.not. allocated(error)) call compare_held(error, model, state)
        status = gracecg_force_model_free(model)
        status = gracecg_case_free(handle)
    end subroutine test_propagation

    !> Nadir pointing: body z to the Earth, body x along or against the orbit, near the attitude of the case, whose
    !> satellite pitches by a degree; the angular velocity turns the attitude as the states have it; the orbit's energy
    !> changes by a hundred-thousandth at most, whereas a free satellite's attitude would drift away.
    subroutine compare_held(error, model, state)
        type(error_type), allocatable, intent(inout) :: error
        integer(c_intptr_t), intent(in) :: model
        real(dp), intent(in) :: state(13)               ! of the leading satellite

        integer, parameter :: STEPS = 600
        real(dp), parameter :: INTERVAL = 1, DEGREES = 2
        type(error_struct) :: failure
        integer(c_int) :: status
        integer(c_int32_t) :: forward
        real(dp) :: states(13, 0:STEPS), axes(3, 3), turn(4), rate(3)
        integer :: k

        do forward = 0, 1
            status = gracecg_force_model_propagate_nadir(model, state(1:3), state(4:6), forward, INTERVAL, &
                                                         int(STEPS, c_size_t), 0.0_dp, states, failure)
            call check_ok(error, status, failure)
            if (allocated(error)) return
            do k = 0, STEPS, 60
                axes = rotation_matrix(states(10:13, k))
                call check(error, dot_product(axes(3, :), states(1:3, k)) < -(1 - 1e-14_dp)*norm2(states(1:3, k)) .and. &
                           (2*forward - 1)*dot_product(axes(1, :), states(4:6, k)) > 0.99_dp*norm2(states(4:6, k)), &
                           'axes')
                if (allocated(error)) return
            end do
            ! R(t + h) R(t)^T is the turn by h omega(t + h/2), to third order
            do k = 1, STEPS - 1, 60
                turn = quaternion_product(states(10:13, k + 1), conjugate_quaternion(states(10:13, k - 1)))
                rate = 2*turn(1:3)*sign(1.0_dp, turn(4))/(2*INTERVAL)
                call check(error, all(abs(rate - states(7:9, k)) < 1e-9_dp), 'angular velocity')
                if (allocated(error)) return
            end do
        end do
        status = gracecg_force_model_propagate_nadir(model, state(1:3), state(4:6), 0_c_int32_t, INTERVAL, ONE, 0.0_dp, &
                                                     states, failure)
        turn = quaternion_product(states(10:13, 0), conjugate_quaternion(state(10:13)))
        call check(error, 2*norm2(turn(1:3)) < DEGREES*atan(1.0_dp)/45, 'the attitude of the case')
    end subroutine compare_held

    subroutine test_truth(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(case_t) :: case
        type(simulator_t) :: expected
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: handle, simulator
        integer(c_size_t) :: n
        integer(c_int) :: status
        real(dp), allocatable :: t(:), states(:, :), turning(:, :), b(:, :), drag(:, :)

        status = gracecg_case_open(c_string('front-1'), handle)
        status = gracecg_simulator_open(handle, simulator, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_simulator_truth(simulator, NONE, n, error=failure)
        call check(error, int(n), 601, 'epochs')
        if (allocated(error)) return
        allocate (t(n), states(13, n), turning(3, n), b(3, n), drag(3, n))
        status = gracecg_simulator_truth(simulator, n, n, t, states, turning, b, drag, failure)
        call find_case('front-1', case, problem)
        call new_simulator(case, expected, problem)
        call check_equal(error, [states], [expected%arc%state], 'states')
        call check_equal(error, [turning], [expected%arc%omega_dot], 'angular acceleration')
        call check_equal(error, [b(:, n)], [expected%arc%loads(600)%field], 'field')
        call check_equal(error, drag(:, 301), expected%arc%loads(300)%drag + expected%arc%loads(300)%srp + &
                         expected%arc%loads(300)%erp, 'non-gravitational')
        call check_equal(error, [t(4), t(n)], [0.3_dp, 60.0_dp], 'times')
        status = gracecg_simulator_truth(simulator, n - 1, n, t, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'there are 601')
        status = gracecg_simulator_free(simulator)
        status = gracecg_case_free(handle)
    end subroutine test_truth

    !> A simulated observation set of a built-in case.
    subroutine simulate(name, seed, run, observations, status, failure)
        character(*), intent(in) :: name
        integer(c_int32_t), intent(in) :: seed, run
        integer(c_intptr_t), intent(out) :: observations
        integer(c_int), intent(out) :: status
        type(error_struct), intent(inout) :: failure

        integer(c_intptr_t) :: handle, simulator
        integer(c_int) :: ignored

        observations = 0
        status = gracecg_case_open(c_string(name), handle, failure)
        if (status == OK) status = gracecg_simulator_open(handle, simulator, failure)
        if (status == OK) status = gracecg_observations_simulate(simulator, seed, run, observations, failure)
        ignored = gracecg_simulator_free(simulator)
        ignored = gracecg_case_free(handle)
    end subroutine simulate

    !> Every algorithm, on the same observations through both interfaces.
    subroutine test_estimate(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(solution_struct) :: solution
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(observation_set_t) :: set
        type(solution_t) :: expected
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: observations
        integer(c_int) :: status
        integer :: i, k

        call simulate('front-3', 5, 2, observations, status, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call find_case('front-3', case, problem)
        call new_simulator(case, simulator, problem)
        call observe(simulator, 5, 2, set, problem)
        do i = 1, size(ESTIMATOR_NAMES)
            status = gracecg_estimate(c_string(trim(ESTIMATOR_NAMES(i))), observations, solution, &
                                      size=NONE, error=failure)
            call check_ok(error, status, failure)
            if (allocated(error)) return
            call estimate_offset(trim(ESTIMATOR_NAMES(i)), set, report_options('front-3'), expected, problem)
            call check_equal(error, [solution%offset, solution%covariance, solution%drift, solution%bias], &
                             [expected%offset, expected%covariance, expected%drift, expected%bias], 'offset')
            call check_equal(error, [solution%quaternion, solution%angular_velocity, solution%residual_rms, &
                                     solution%condition], &
                             [expected%quaternion, expected%angular_velocity, expected%residual_rms, &
                              expected%condition], 'the rest')
            call check_equal(error, solution%sigma, [(sqrt(expected%covariance(k, k)), k=1, 3)], 'sigma')
            if (allocated(error)) return
            call check(error, solution%iterations == expected%iterations .and. solution%converged == 1 .and. &
                       solution%warning_count == size(expected%warnings), &
                       'iterations, convergence, warnings')
            if (allocated(error)) return
        end do
        status = gracecg_observations_free(observations)
    end subroutine test_estimate

    subroutine test_joint_estimate(error)
        type(error_type), allocatable, intent(out) :: error

        character(7), parameter :: NAMES(2) = ['front-2', 'front-3']
        type(error_struct) :: failure
        type(joint_struct) :: joint
        type(joint_run_t) :: runs(2)
        type(joint_solution_t) :: expected
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(observation_set_t) :: set
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: observations(2)
        real(dp) :: difference(3, 2), difference_sigma(3, 2)
        integer(c_int) :: status
        integer :: i

        do i = 1, 2
            call simulate(NAMES(i), 5, 2, observations(i), status, failure)
            call check_ok(error, status, failure)
            if (allocated(error)) return
            call find_case(NAMES(i), case, problem)
            call new_simulator(case, simulator, problem)
            call observe(simulator, 5, 2, set, problem)
            call run_from_observations(set, report_options(NAMES(i)), runs(i), problem)
        end do
        call estimate_runs(runs, joint_options_t(), expected, problem)
        status = gracecg_estimate_joint(observations, 2_c_size_t, joint, difference, difference_sigma, failure)
        call check_ok(error, status, failure)
        call check_equal(error, [joint%offset, joint%covariance, joint%chi_square, joint%probability], &
                         [expected%offset, expected%covariance, expected%statistic, expected%probability], 'joint')
        call check_equal(error, [difference(:, 2), difference_sigma(:, 1)], &
                         [expected%runs(2)%difference, expected%runs(1)%difference_sigma], 'differences')
        if (allocated(error)) return
        call check(error, joint%degrees == 3 .and. joint%consistent == 1, 'agreement')
        status = gracecg_estimate_joint(observations, 0_c_size_t, joint, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'at least one')
        do i = 1, 2
            status = gracecg_observations_free(observations(i))
        end do
    end subroutine test_joint_estimate

    !> A minute in three arcs.
    subroutine test_chain(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(joint_struct) :: joint
        type(arc_chain_t) :: expected
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(observation_set_t) :: set
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: observations
        integer(c_size_t) :: arcs, joined
        integer(c_int) :: status

        call simulate('front-3', 5, 2, observations, status, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call find_case('front-3', case, problem)
        call new_simulator(case, simulator, problem)
        call observe(simulator, 5, 2, set, problem)
        call estimate_chain(set, report_options('front-3'), joint_options_t(), 20.0_dp, 1, expected, problem)
        status = gracecg_estimate_chain(observations, 20.0_dp, 2, joint, arcs, joined, size=0_c_size_t, error=failure)
        call check_ok(error, status, failure)
        call check_equal(error, [joint%offset, joint%covariance, joint%chi_square], &
                         [expected%solution%offset, expected%solution%covariance, expected%solution%statistic], 'chain')
        if (allocated(error)) return
        call check(error, arcs == 3 .and. joined == count(expected%arcs%joined), 'arcs')
        if (allocated(error)) return
        status = gracecg_estimate_chain(observations, 20.0_dp, 0, joint, size=0_c_size_t, error=failure)
        call check_refused(error, status, BAD_VALUE, failure, 'threads')
        status = gracecg_estimate_chain(observations, 1.0_dp, 1, joint, size=0_c_size_t, error=failure)
        call check_refused(error, status, FAILED, failure, 'arcs of 1 s')
        status = gracecg_estimate_chain(observations, 20.0_dp, 1, size=0_c_size_t, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'joint')
        status = gracecg_observations_free(observations)
    end subroutine test_chain

    !> Every argument NULL, or wrong: refused by name.
    subroutine test_level1_misuse(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(error_t), allocatable :: problem
        type(level1_struct) :: offset
        real(dp) :: spans(2, 1), bad(2, 1)
        integer(c_size_t) :: length
        integer(c_int) :: status

        call make_folder(error)
        call make_directory(FOLDER//'c_level1', problem)
        call make_file(error, 'c_level1_setup.nml', '&mass_properties'//new_line('a')//'mass = 580'//new_line('a')// &
                       'moments_of_inertia = 70, 345, 388'//new_line('a')//'products_of_inertia = -3, -0.3, -2.9'// &
                       new_line('a')//'/'//new_line('a')//'&level1'//new_line('a')//'/'//new_line('a'))
        spans(:, 1) = [633798600.0_dp, 60.0_dp]
        bad(:, 1) = [633798600.0_dp, ieee_value(1.0_dp, ieee_quiet_nan)]
        status = gracecg_estimate_level1(n_spans=NONE, size=NONE, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'offset')
        status = gracecg_estimate_level1(n_spans=NONE, size=NONE, offset=offset, setup=c_string('s'), error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'folder')
        status = gracecg_estimate_level1(c_string('f'), n_spans=NONE, size=NONE, offset=offset, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'setup')
        status = gracecg_estimate_level1(c_string('f'), c_string('s'), n_spans=ONE, size=NONE, offset=offset, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'spans')
        status = gracecg_estimate_level1(c_string('f'), c_string('s'), n_spans=-ONE, size=NONE, offset=offset, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'number of spans')
        status = gracecg_estimate_level1(c_string('f'), c_string('s'), n_spans=ONE, spans=bad, size=NONE, offset=offset, &
                                         error=failure)
        call check_refused(error, status, BAD_VALUE, failure, 'spans')
        status = gracecg_estimate_level1(c_string('f'), c_string('s'), c_string('CD'), NONE, size=NONE, offset=offset, &
                                         error=failure)
        call check_refused(error, status, BAD_VALUE, failure, 'satellite')
        status = gracecg_estimate_level1(c_string('f'), c_string('s'), n_spans=NONE, source=c_string('acc-cul'), size=NONE, &
                                         offset=offset, error=failure)
        call check_refused(error, status, FAILED, failure, 'acc-cal')
        status = gracecg_estimate_level1(c_string('f'), c_string('s'), n_spans=NONE, size=NONE, offset=offset, error=failure)
        call check_refused(error, status, FAILED, failure, 's:')
        status = gracecg_estimate_level1(c_string(FOLDER//'c_level1'), c_string(FOLDER//'c_level1_setup.nml'), &
                                         n_spans=ONE, spans=spans, size=NONE, length=length, offset=offset, error=failure)
        call check_refused(error, status, FAILED, failure, 'no Level-1 files')
        status = gracecg_estimate_level1_day(c_string(FOLDER//'c_level1'), c_string(FOLDER//'c_level1_setup.nml'), &
                                             day=c_string('2020-02-30'), n_spans=NONE, size=NONE, offset=offset, error=failure)
        call check_refused(error, status, FAILED, failure, 'no date')
        status = gracecg_estimate_level1_day(c_string(FOLDER//'c_level1'), c_string(FOLDER//'c_level1_setup.nml'), &
                                             day=c_string(repeat('2', 5000)), n_spans=NONE, size=NONE, offset=offset, &
                                             error=failure)
        call check_refused(error, status, BAD_VALUE, failure, 'day')
        status = gracecg_estimate_level1(n_spans=NONE, size=NONE)
        if (.not. allocated(error)) call check(error, int(status), int(NULL_POINTER), 'without an error to fill')
        if (.not. allocated(error)) call check(error, all(offset%offset < 0), 'nothing is filled in')
    end subroutine test_level1_misuse

    !> What was taken out of a set makes the same set again: same estimate, bit by bit. With gaps there
    !> are warnings.
    subroutine test_arrays(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(solution_struct) :: solution, again
        type(samples_struct) :: samples
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(observation_set_t) :: set
        type(solution_t) :: expected
        type(moment_series_t) :: series
        type(error_t), allocatable :: problem
        real(dp) :: time(121), moment(3, 121)
        integer(c_intptr_t) :: measured
        integer :: k
        integer(c_intptr_t) :: observations, copy, knowledge
        integer(c_size_t) :: n(4), length
        integer(c_int) :: status
        integer(c_int32_t), allocatable, target :: head(:)
        real(dp), allocatable, target :: ta(:), a(:, :), ts(:), q(:, :), tm(:), b(:, :), to(:), x(:, :)
        character(kind=c_char), target :: warnings(400), short(9)
        character(kind=c_char), allocatable :: text(:)

        call simulate('front-3', 1, 1, observations, status, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_observations_counts(observations, n, failure)
        call check(error, all(n == [600, 240, 60, 61]), 'counts')
        if (allocated(error)) return
        allocate (ta(n(1)), a(3, n(1)), ts(n(2)), q(4, n(2)), head(n(2)), tm(n(3)), b(3, n(3)), to(n(4)), x(3, n(4)))
        status = gracecg_observations_accelerometer(observations, n(1), ta, a, failure)
        status = max(status, gracecg_observations_star_camera(observations, n(2), ts, head, q, failure))
        status = max(status, gracecg_observations_magnetometer(observations, n(3), tm, b, failure))
        status = max(status, gracecg_observations_orbit(observations, n(4), to, x, failure))
        call check(error, int(status), int(OK), 'samples')
        if (allocated(error)) return
        samples = samples_struct(n(1), c_loc(ta), c_loc(a), n(2), c_loc(ts), c_loc(head), c_loc(q), &
                                 n(3), c_loc(tm), c_loc(b), n(4), c_loc(to), c_loc(x))
        ! the setup by way of its text
        status = gracecg_observations_setup(observations, knowledge, failure)
        status = gracecg_setup_text(knowledge, size=NONE, length=length, error=failure)
        allocate (text(length + 1))
        status = gracecg_setup_text(knowledge, text, length + 1, error=failure)
        status = gracecg_setup_free(knowledge, failure)
        status = gracecg_setup_parse(text, knowledge, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_observations_create(knowledge, samples, copy, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_estimate(c_string('ascfest'), observations, solution, size=NONE, error=failure)
        status = gracecg_estimate(c_string('ascfest'), copy, again, size=NONE, error=failure)
        call check_equal(error, [again%offset, again%covariance], [solution%offset, solution%covariance], &
                         'estimate of the copy')
        status = gracecg_observations_free(copy)
        if (allocated(error)) return

        ! measured moments: the numbers of the Fortran API
        call find_case('front-3', case, problem)
        call new_simulator(case, simulator, problem)
        call observe(simulator, 1, 1, set, problem)
        time = [(0.5_dp*k, k=0, 120)]
        do k = 1, size(time)
            moment(:, k) = 1.02_dp*dipole_moment(set%knowledge%rods, time(k))
        end do
        status = gracecg_setup_measured(knowledge, size(time, kind=c_size_t), time, moment, measured, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_observations_create(measured, samples, copy, failure)
        status = gracecg_estimate(c_string('assest-fde'), copy, again, size=NONE, error=failure)
        call new_moment_series(series, time, moment, problem)
        call take_measured_moments(series, set%knowledge%rods)
        call estimate_offset('assest-fde', set, report_options('front-3'), expected, problem)
        call check_equal(error, [again%offset, again%covariance], [expected%offset, expected%covariance], &
                         'estimate from measured moments')
        status = gracecg_observations_free(copy)
        status = gracecg_setup_free(measured)
        moment(1, 7) = 1e4_dp
        status = gracecg_setup_measured(knowledge, size(time, kind=c_size_t), time, moment, measured, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'have to be in A m^2')
        if (allocated(error)) return

        samples%accelerometer_count = 590       ! the last second is missing
        status = gracecg_observations_create(knowledge, samples, copy, failure)
        status = gracecg_estimate(c_string('assest-fde'), copy, again, warnings, size(warnings, kind=c_size_t), &
                                  failure)
        call check(error, status == OK .and. again%warning_count > 0, 'no warning of missing samples')
        if (allocated(error)) return
        call check(error, index(text_at(c_loc(warnings)), '10 of 600 samples are missing') > 0, &
                   text_at(c_loc(warnings)))
        if (allocated(error)) return
        short = '#'
        status = gracecg_estimate(c_string('assest-fde'), copy, again, short(:8), 8_c_size_t, failure)
        call check(error, short(8) == c_null_char .and. short(9) == '#', 'warnings are cut off')
        status = gracecg_observations_free(copy)

        ! without the orbit, and without a magnetometer: neither is too little
        samples%accelerometer_count = 600
        samples%orbit_count = 0
        status = gracecg_observations_create(knowledge, samples, copy, failure)
        if (.not. allocated(error)) call check_ok(error, status, failure)
        status = gracecg_observations_free(copy)
        samples%magnetometer_count = 0
        status = gracecg_observations_create(knowledge, samples, copy, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'magnetometer: fewer than two samples')
        status = gracecg_observations_create(knowledge, no_samples(), copy, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'accelerometer: fewer than two samples')
        status = gracecg_setup_free(knowledge)
        status = gracecg_observations_free(observations)
    end subroutine test_arrays

    subroutine test_files(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(solution_struct) :: solution, again
        integer(c_intptr_t) :: observations, copy, knowledge
        integer(c_int) :: status

        call make_folder(error)
        if (allocated(error)) return
        call simulate('back-3', 1, 1, observations, status, failure)
        status = gracecg_observations_write(observations, c_string(FOLDER//'c-interface'), failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_observations_read(c_string(FOLDER//'c-interface'), copy, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_estimate(c_string('assest-rde'), observations, solution, size=NONE)
        status = gracecg_estimate(c_string('assest-rde'), copy, again, size=NONE)
        call check_equal(error, [again%offset, again%covariance], [solution%offset, solution%covariance], &
                         'estimate from files')
        if (allocated(error)) return
        status = gracecg_setup_read(c_string(FOLDER//'c-interface/setup.nml'), knowledge, failure)
        call check_ok(error, status, failure)
        status = gracecg_setup_free(knowledge)
        status = gracecg_observations_free(copy)
        status = gracecg_observations_free(observations)
        if (allocated(error)) return
        status = gracecg_observations_read(c_string(FOLDER//'nowhere'), copy, failure)
        call check_refused(error, status, FAILED, failure, 'no such folder')
        status = gracecg_setup_read(c_string(FOLDER//'nowhere/setup.nml'), knowledge, failure)
        call check_refused(error, status, FAILED, failure, 'no such file')
    end subroutine test_files

    !> Every pointer that is needed, left out.
    subroutine test_null(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(utc_struct) :: utc
        type(solution_struct) :: solution
        integer(c_intptr_t) :: handle, case, model, gravity
        integer(c_int) :: status
        real(dp) :: x(13)

        status = gracecg_utc_parse(utc=utc, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'text')
        status = gracecg_utc_parse(c_string(DATE), error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'utc')
        status = gracecg_gravity_open(degree=2, order=0, gravity=gravity, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'name_or_file')
        status = gracecg_gravity_open(c_string('egm96'), 2, 2, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'gravity')
        status = gracecg_gravity_open(c_string('egm96'), 2, 2, gravity, failure)
        status = gracecg_gravity_evaluate(gravity, ONE, acceleration=x, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'position')
        status = gracecg_gravity_free(gravity)
        status = gracecg_gravity_free(error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'handle')
        status = gracecg_field_open(c_string('igrf95'), field=handle, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'date')
        status = gracecg_sun_position(n=ONE, seconds=[0.0_dp], position=x, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'epoch')
        status = gracecg_case_open(the_case=case, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'name_or_file')
        status = gracecg_case_open(c_string('front-1'), case, failure)
        status = gracecg_case_text(case, size=NONE, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'text')
        status = gracecg_case_text(case, size=ONE, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'text')
        status = gracecg_force_model_open(case, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'model')
        status = gracecg_force_model_open(case, model, failure)
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], x, x, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'quaternion')
        status = gracecg_force_model_rate(model, 0.0_dp, rate=x, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'state')
        status = gracecg_force_model_propagate(model, x, 1.0_dp, ONE, 0.0_dp, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'states')
        status = gracecg_force_model_free(model)
        status = gracecg_case_free(case)
        status = gracecg_observations_create(0_c_intptr_t, observations=handle, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'samples')
        status = gracecg_estimate(observations=0_c_intptr_t, solution=solution, size=NONE, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'algorithm')
        status = gracecg_estimate(c_string('ascfest'), 0_c_intptr_t, size=NONE, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'solution')
        status = gracecg_estimate(c_string('ascfest'), 0_c_intptr_t, solution, size=ONE, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'warnings')
        ! and nobody asks for the message
        if (allocated(error)) return
        status = gracecg_case_open()
        call check(error, int(status), int(NULL_POINTER))
    end subroutine test_null

    !> Numbers that are no handle, and handles of another kind.
    subroutine test_handles(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(solution_struct) :: solution
        type(utc_struct) :: epoch
        integer(c_intptr_t) :: case, wrong(6), out
        integer(c_size_t) :: n(4)
        integer(c_int) :: status
        integer :: i
        real(dp) :: x(39), number

        status = gracecg_case_open(c_string('front-1'), case, failure)
        wrong = [0_c_intptr_t, -1_c_intptr_t, huge(0_c_intptr_t), -huge(0_c_intptr_t), &
                 int(z'7fff12345678', c_intptr_t), case]
        x = 1e7_dp
        epoch = utc_struct(47528, 0.0_dp)
        do i = 1, size(wrong)
            status = gracecg_gravity_evaluate(wrong(i), ONE, x, x, error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'gravity model')
            status = gracecg_field_evaluate(wrong(i), ONE, x, x, error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'geomagnetic field')
            status = gracecg_density_evaluate(wrong(i), epoch, ONE, [0.0_dp], x, x, error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'density')
            status = gracecg_wind_evaluate(wrong(i), epoch, ONE, [0.0_dp], x, x, error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'wind')
            status = gracecg_earth_radiation_flux(wrong(i), epoch, ONE, [0.0_dp], x, x, error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'Earth radiation')
            status = gracecg_surface_area(wrong(i), [1.0_dp, 0.0_dp, 0.0_dp], number, failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'surface')
            status = gracecg_surface_drag(wrong(i), MASS, 2.0_dp, 1e-12_dp, x, x, failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'surface')
            status = gracecg_force_model_evaluate(wrong(i), ONE, [0.0_dp], x, x, x, error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'force model')
            status = gracecg_force_model_rate(wrong(i), 0.0_dp, x, x, failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'force model')
            status = gracecg_force_model_propagate(wrong(i), x, 1.0_dp, ONE, 0.0_dp, x, failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'force model')
            status = gracecg_force_model_epoch(wrong(i), epoch, error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'force model')
            status = gracecg_simulator_truth(wrong(i), NONE, error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'simulator')
            status = gracecg_observations_simulate(wrong(i), 1, 1, out, failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'simulator')
            status = gracecg_setup_text(wrong(i), size=NONE, length=n(1), error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'setup')
            status = gracecg_observations_create(wrong(i), no_samples(), out, failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'setup')
            status = gracecg_observations_counts(wrong(i), n, failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'observation set')
            status = gracecg_observations_setup(wrong(i), out, failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'observation set')
            status = gracecg_observations_accelerometer(wrong(i), NONE, error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'observation set')
            status = gracecg_observations_write(wrong(i), c_string(FOLDER//'never'), failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'observation set')
            status = gracecg_estimate(c_string('ascfest'), wrong(i), solution, size=NONE, error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'observation set')
            if (wrong(i) == case) cycle
            status = gracecg_case_text(wrong(i), size=NONE, length=n(1), error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'case')
            status = gracecg_case_values(wrong(i), error=failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'case')
            status = gracecg_force_model_open(wrong(i), out, failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'case')
            status = gracecg_simulator_open(wrong(i), out, failure)
            call check_refused(error, status, BAD_HANDLE, failure, 'case')
        end do
        status = gracecg_case_free(case)
    end subroutine test_handles

    !> A handle that was freed is never valid again, also when its place is taken by another object.
    subroutine test_freed_twice(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        integer(c_intptr_t) :: gravity, copy, other
        integer(c_int) :: status
        real(dp) :: a(3)
        integer :: i

        status = gracecg_gravity_open(c_string('egm96'), 2, 2, gravity, failure)
        copy = gravity
        status = gracecg_surface_free(copy, failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'surface')
        call check(error, copy == gravity, 'a refused free changes the handle')
        if (allocated(error)) return
        status = gracecg_gravity_evaluate(gravity, ONE, PLACE, a, error=failure)
        call check(error, int(status), int(OK), 'a refused free leaves the object')
        if (allocated(error)) return
        status = gracecg_gravity_free(gravity, failure)
        status = gracecg_gravity_free(gravity, failure)
        call check(error, int(status), int(OK), 'NULL may be freed')
        do i = 1, 3*MAX_OBJECTS     ! every place is taken three times
            status = gracecg_gravity_open(c_string('point-mass'), 0, 0, other, failure)
            if (other == copy) exit
            status = gracecg_gravity_free(other)
        end do
        if (.not. allocated(error)) call check(error, i > 3*MAX_OBJECTS, 'a handle was given out twice')
        status = gracecg_gravity_evaluate(copy, ONE, PLACE, a, error=failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'was freed')
        status = gracecg_gravity_free(copy, failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'was freed')
    end subroutine test_freed_twice

    subroutine test_too_many(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        integer(c_intptr_t) :: handles(MAX_OBJECTS + 1)
        integer(c_int) :: status
        integer :: i, n

        n = MAX_OBJECTS - live_objects()
        handles = 0
        do i = 1, n
            status = gracecg_gravity_open(c_string('point-mass'), 0, 0, handles(i), failure)
            if (status /= OK) exit
        end do
        call check_ok(error, status, failure)
        status = gracecg_gravity_open(c_string('point-mass'), 0, 0, handles(n + 1), failure)
        call check_refused(error, status, NO_MEMORY, failure, 'objects already')
        if (.not. allocated(error)) call check(error, handles(n + 1) == 0, 'a handle after a failure')
        do i = 1, n
            status = gracecg_gravity_free(handles(i), failure)
        end do
        if (.not. allocated(error)) call check(error, live_objects(), MAX_OBJECTS - n, 'objects are left')
    end subroutine test_too_many

    subroutine test_names(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(utc_struct) :: utc
        type(solution_struct) :: solution
        integer(c_intptr_t) :: handle
        integer(c_int) :: status

        status = gracecg_case_open(c_string('frnt-1'), handle, failure)
        call check_refused(error, status, FAILED, failure, 'did you mean "front-1"')
        status = gracecg_gravity_open(c_string('egm69'), 2, 2, handle, failure)
        call check_refused(error, status, FAILED, failure, 'did you mean "egm96"')
        status = gracecg_gravity_open(c_string(''), 2, 2, handle, failure)
        call check_refused(error, status, FAILED, failure, 'no gravity model ""')
        status = gracecg_gravity_open(c_string('test'), 2, 2, handle, failure)
        call check_refused(error, status, FAILED, failure, 'nor a file')
        status = gracecg_gravity_open(c_string('fpm.toml'), 2, 2, handle, failure)
        call check_refused(error, status, FAILED, failure, 'fpm.toml')
        status = gracecg_utc_parse(c_string(DATE), utc)
        status = gracecg_field_open(c_string('igrf59'), utc, handle, failure)
        call check_refused(error, status, FAILED, failure, 'did you mean "igrf95"')
        status = gracecg_wind_open(c_string('hwm39'), handle, failure)
        call check_refused(error, status, FAILED, failure, 'did you mean "hwm93"')
        if (.not. allocated(error)) call check(error, handle == 0, 'a handle after a failure')
        call simulate('front-1', 1, 1, handle, status, failure)
        status = gracecg_estimate(c_string('assest'), handle, solution, size=NONE, error=failure)
        call check_refused(error, status, FAILED, failure, 'no algorithm "assest"')
        status = gracecg_observations_free(handle)
    end subroutine test_names

    !> NaN and infinity at every place where a number comes in.
    subroutine test_not_finite(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(utc_struct) :: epoch
        integer(c_intptr_t) :: case, model, gravity, surface, handle
        integer(c_int) :: status
        real(dp) :: bad(2), state(13), x(13), a(13), s(1)
        integer :: i, k

        bad = [ieee_value(1.0_dp, ieee_quiet_nan), ieee_value(1.0_dp, ieee_positive_inf)]
        status = gracecg_utc_parse(c_string(DATE), epoch)
        status = gracecg_case_open(c_string('front-1'), case)
        status = gracecg_case_values(case, state=state)
        status = gracecg_force_model_open(case, model)
        status = gracecg_gravity_open(c_string('egm96'), 2, 2, gravity)
        status = gracecg_surface_trapezoid(3.0_dp, 1.0_dp, 1.0_dp, 1.0_dp, 0.0_dp, 0.0_dp, surface)
        do k = 1, 2
            do i = 1, 13
                x = state
                x(i) = bad(k)
                status = gracecg_force_model_rate(model, 0.0_dp, x, a, failure)
                call check_refused(error, status, BAD_VALUE, failure, 'of the state is NaN or infinite')
                status = gracecg_force_model_propagate(model, x, 0.1_dp, NONE, 0.0_dp, a, failure)
                call check_refused(error, status, BAD_VALUE, failure, 'is NaN or infinite')
                if (i >= 7 .and. i <= 9) cycle      ! the angular velocity
                status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], x(1:3), x(4:6), x(10:13), &
                                                      error=failure)
                call check_refused(error, status, BAD_VALUE, failure, 'is NaN or infinite')
            end do
            status = gracecg_force_model_evaluate(model, ONE, bad(k:k), state(1:3), state(4:6), state(10:13), &
                                                  error=failure)
            call check_refused(error, status, BAD_VALUE, failure, 'seconds')
            status = gracecg_force_model_propagate(model, state, bad(k), NONE, 0.0_dp, a, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'interval')
            status = gracecg_force_model_propagate(model, state, 0.1_dp, NONE, bad(k), a, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'tolerance')
            status = gracecg_gravity_evaluate(gravity, ONE, [PLACE(:2), bad(k)], a, error=failure)
            call check_refused(error, status, BAD_VALUE, failure, 'number 3 of position')
            status = gracecg_sun_position(epoch, ONE, bad(k:k), a, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'seconds')
            status = gracecg_sun_position(utc_struct(47528, bad(k)), ONE, [0.0_dp], a, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'outside the covered times')
            status = gracecg_sun_illumination(ONE, PLACE, [bad(k), 0.0_dp, 0.0_dp], a, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'sun')
            status = gracecg_surface_drag(surface, bad(k), 2.0_dp, 1e-12_dp, PLACE, a, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'mass')
            status = gracecg_surface_drag(surface, MASS, 2.0_dp, bad(k), PLACE, a, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'density')
            status = gracecg_surface_drag(surface, MASS, 2.0_dp, 1e-12_dp, [bad(k), 0.0_dp, 0.0_dp], a, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'velocity')
            status = gracecg_surface_trapezoid(bad(k), 1.0_dp, 1.0_dp, 1.0_dp, 0.0_dp, 0.0_dp, handle, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'NaN or infinite')
            status = gracecg_density_open_indices(bad(k), 150.0_dp, 2.0_dp, handle, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'f107')
            status = gracecg_earth_radiation_open(c_string('report'), 1, bad(k), handle, failure)
            call check_refused(error, status, FAILED, failure, 'irradiance')
            status = gracecg_earth_fixed(bad(k), ONE, PLACE, a, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'sidereal_angle')
            status = gracecg_utc_add(epoch, bad(k), epoch, failure)
            call check_refused(error, status, BAD_VALUE, failure, 'seconds')
        end do
        s = 0
        ! what overflows on the way
        status = gracecg_surface_drag(surface, MASS, 2.0_dp, 1e-12_dp, 1e200_dp*PLACE, a, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'would be NaN or infinite')
        status = gracecg_surface_free(surface)
        status = gracecg_gravity_free(gravity)
        status = gracecg_force_model_free(model)
        status = gracecg_case_free(case)
    end subroutine test_not_finite

    !> A NaN in any array of samples.
    subroutine test_bad_samples(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(samples_struct) :: samples
        integer(c_intptr_t) :: observations, copy, knowledge
        integer(c_size_t) :: n(4)
        integer(c_int) :: status
        integer(c_int32_t), allocatable, target :: head(:)
        real(dp), allocatable, target :: ta(:), a(:, :), ts(:), q(:, :), tm(:), b(:, :), to(:), x(:, :)
        real(dp) :: nan

        nan = ieee_value(nan, ieee_quiet_nan)
        call simulate('front-1', 1, 1, observations, status, failure)
        status = gracecg_observations_counts(observations, n, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        allocate (ta(n(1)), a(3, n(1)), ts(n(2)), q(4, n(2)), head(n(2)), tm(n(3)), b(3, n(3)), to(n(4)), x(3, n(4)))
        status = gracecg_observations_accelerometer(observations, n(1), ta, a)
        status = gracecg_observations_star_camera(observations, n(2), ts, head, q)
        status = gracecg_observations_magnetometer(observations, n(3), tm, b)
        status = gracecg_observations_orbit(observations, n(4), to, x)
        status = gracecg_observations_setup(observations, knowledge)
        samples = samples_struct(n(1), c_loc(ta), c_loc(a), n(2), c_loc(ts), c_loc(head), c_loc(q), &
                                 n(3), c_loc(tm), c_loc(b), n(4), c_loc(to), c_loc(x))
        call spoil(ta(7), 'accelerometer: time tag 7')
        call spoil(a(2, 600), 'accelerometer: the sample at 60 s')
        call spoil(ts(3), 'star camera')
        call spoil(q(4, 1), 'star camera')
        call spoil(tm(60), 'magnetometer')
        call spoil(b(1, 1), 'magnetometer')
        call spoil(to(1), 'orbit')
        call spoil(x(3, 61), 'orbit')
        head(5) = 3
        status = gracecg_observations_create(knowledge, samples, copy, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'head that does not exist')
        status = gracecg_setup_free(knowledge)
        status = gracecg_observations_free(observations)

    contains

        subroutine spoil(number, part)
            real(dp), intent(inout), target :: number
            character(*), intent(in) :: part
            real(dp) :: kept

            kept = number
            number = nan
            status = gracecg_observations_create(knowledge, samples, copy, failure)
            call check_refused(error, status, BAD_VALUE, failure, part)
            number = kept
        end subroutine spoil
    end subroutine test_bad_samples

    subroutine test_sizes(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(samples_struct) :: samples
        integer(c_intptr_t) :: gravity, observations, knowledge, copy
        integer(c_int) :: status
        real(dp), target :: x(3), t(1)

        x = PLACE
        t = 0
        status = gracecg_gravity_open(c_string('point-mass'), 0, 0, gravity)
        status = gracecg_gravity_evaluate(gravity, -1_c_size_t, x, x, error=failure)    ! SIZE_MAX
        call check_refused(error, status, BAD_SIZE, failure, 'n is too great')
        status = gracecg_gravity_evaluate(gravity, 3000000000_c_size_t, x, x, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'n = 3000000000 is too great')
        status = gracecg_gravity_free(gravity)
        call simulate('front-1', 1, 1, observations, status, failure)
        status = gracecg_observations_accelerometer(observations, 599_c_size_t, t, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'there are 600')
        status = gracecg_observations_star_camera(observations, NONE, t, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'there are 240')
        status = gracecg_observations_magnetometer(observations, ONE, t, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'there are 60')
        status = gracecg_observations_orbit(observations, -5_c_size_t, t, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'capacity')
        status = gracecg_observations_setup(observations, knowledge)
        samples = no_samples()
        samples%accelerometer_count = 100000000
        samples%accelerometer_time = c_loc(t)
        samples%acceleration = c_loc(x)
        status = gracecg_observations_create(knowledge, samples, copy, failure)
        call check_refused(error, status, BAD_SIZE, failure, 'samples of the accelerometer')
        samples = no_samples()
        samples%star_camera_count = -1
        status = gracecg_observations_create(knowledge, samples, copy, failure)
        call check_refused(error, status, BAD_SIZE, failure, 'samples of the star camera')
        samples = no_samples()
        samples%orbit_count = 4
        status = gracecg_observations_create(knowledge, samples, copy, failure)
        call check_refused(error, status, NULL_POINTER, failure, 'orbit')
        status = gracecg_setup_free(knowledge)
        status = gracecg_observations_free(observations)
    end subroutine test_sizes

    subroutine test_states(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        integer(c_intptr_t) :: case, model, gravity
        integer(c_int) :: status
        real(dp) :: state(13), a(3)

        status = gracecg_case_open(c_string('front-1'), case)
        status = gracecg_case_values(case, state=state)
        status = gracecg_force_model_open(case, model)
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], 0.94_dp*state(1:3), state(4:6), state(10:13), &
                                              total=a, error=failure)
        call check_refused(error, status, BAD_VALUE, failure, 'km high')
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], 0.5_dp*state(1:3), state(4:6), state(10:13), &
                                              total=a, error=failure)
        call check_refused(error, status, BAD_VALUE, failure, 'below the ground')
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], 0*state(1:3), state(4:6), state(10:13), &
                                              total=a, error=failure)
        call check_refused(error, status, BAD_VALUE, failure, 'centre of the Earth')
        status = gracecg_force_model_evaluate(model, ONE, [0.0_dp], state(1:3), state(4:6), 0*state(10:13), &
                                              total=a, error=failure)
        call check_refused(error, status, BAD_VALUE, failure, 'quaternion')
        status = gracecg_force_model_free(model)
        status = gracecg_case_free(case)
        status = gracecg_gravity_open(c_string('egm96'), 70, 70, gravity)
        status = gracecg_gravity_evaluate(gravity, ONE, [0.0_dp, 0.0_dp, 0.0_dp], a, error=failure)
        call check_refused(error, status, BAD_VALUE, failure, '1 km from')
        status = gracecg_gravity_free(gravity)
    end subroutine test_states

    !> A text without its end within the limit, and a message that is longer than its place.
    subroutine test_long_texts(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        integer(c_intptr_t) :: handle
        integer(c_int) :: status
        character(:), allocatable :: message

        status = gracecg_case_open(c_string(repeat('a', 4096)), handle, failure)
        call check_refused(error, status, BAD_VALUE, failure, 'longer than 4095 bytes')
        status = gracecg_case_open(c_string(repeat('a', 4095)), handle, failure)
        call check_refused(error, status, FAILED, failure, 'no case "aaa')
        if (allocated(error)) return
        message = trim(message_text(failure))
        call check(error, len(message) == 1019 .and. message(1017:) == '...', 'a message that is cut off')
    end subroutine test_long_texts

    !> The estimate from a hopeless initial guess does not pass for a good one.
    subroutine test_not_converged(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(solution_struct) :: solution
        type(samples_struct) :: samples
        integer(c_intptr_t) :: observations, copy, knowledge
        integer(c_size_t) :: n(4), length
        integer(c_int) :: status
        integer(c_int32_t), allocatable, target :: head(:)
        real(dp), allocatable, target :: ta(:), a(:, :), ts(:), q(:, :), tm(:), b(:, :)
        character(kind=c_char), allocatable, target :: text(:)
        character(:), allocatable :: changed
        integer :: first, last

        call simulate('front-1', 1, 1, observations, status, failure)
        status = gracecg_observations_counts(observations, n, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        allocate (ta(n(1)), a(3, n(1)), ts(n(2)), q(4, n(2)), head(n(2)), tm(n(3)), b(3, n(3)))
        status = gracecg_observations_accelerometer(observations, n(1), ta, a)
        status = gracecg_observations_star_camera(observations, n(2), ts, head, q)
        status = gracecg_observations_magnetometer(observations, n(3), tm, b)
        status = gracecg_observations_setup(observations, knowledge)
        status = gracecg_setup_text(knowledge, size=NONE, length=length)
        allocate (text(length + 1))
        status = gracecg_setup_text(knowledge, text, length + 1)
        status = gracecg_setup_free(knowledge)
        changed = text_at(c_loc(text))
        first = index(changed, 'guess_angular_velocity')
        last = first + index(changed(first:), new_line('a')) - 1
        changed = changed(:first - 1)//'guess_angular_velocity = 0.9, -0.9, 0.9'//changed(last:)
        status = gracecg_setup_parse(c_string(changed), knowledge, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        samples = samples_struct(n(1), c_loc(ta), c_loc(a), n(2), c_loc(ts), c_loc(head), c_loc(q), &
                                 n(3), c_loc(tm), c_loc(b), 0, c_loc(ta), c_loc(a))
        status = gracecg_observations_create(knowledge, samples, copy, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        status = gracecg_estimate(c_string('assest-fde'), copy, solution, size=NONE, error=failure)
        call check(error, status == NOT_CONVERGED .or. status == FAILED, &
                   'the estimate from a hopeless guess passes: '//trim(message_text(failure)))
        if (.not. allocated(error)) call check(error, message_text(failure) /= '', 'no message')
        status = gracecg_observations_free(copy)
        status = gracecg_observations_free(observations)
        status = gracecg_setup_free(knowledge)
    end subroutine test_not_converged

    !> Options travel with the objects, can be told and replaced; the object itself keeps its own.
    subroutine test_options(error)
        type(error_type), allocatable, intent(out) :: error

        character(*), parameter :: GAIN_TOO = '&optimal estimate_rod_gain = .true. /'
        type(error_struct) :: failure
        type(solution_struct) :: solution, other
        integer(c_intptr_t) :: observations, changed, knowledge, from_folder, case
        integer(c_int) :: status
        integer(c_int32_t) :: before

        call simulate('front-3', 1, 1, observations, status, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call check_text(observations, 'guess_quaternion = -0.7', .true.)
        call check_text(observations, 'estimate_rod_gain = .false.', .true.)
        status = gracecg_estimate(c_string('optimal'), observations, solution, size=NONE, error=failure)
        before = solution%parameter_count
        status = gracecg_options_replace(observations, c_string(GAIN_TOO), changed, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call check_text(changed, 'estimate_rod_gain = .true.', .true.)
        call check_text(changed, 'guess_quaternion = -0.7', .false.)
        call check_text(observations, 'estimate_rod_gain = .false.', .true.)
        status = gracecg_estimate(c_string('optimal'), changed, other, size=NONE, error=failure)
        call check_ok(error, status, failure)
        if (.not. allocated(error)) call check(error, other%parameter_count == before + 1, 'the gain is estimated')
        if (allocated(error)) return
        ! by way of a folder, a setup and a case
        status = gracecg_observations_write(changed, c_string(FOLDER//'c-options'), failure)
        status = gracecg_observations_read(c_string(FOLDER//'c-options'), from_folder, failure)
        call check_ok(error, status, failure)
        call check_text(from_folder, 'estimate_rod_gain = .true.', .true.)
        status = gracecg_observations_setup(changed, knowledge, failure)
        call check_text(knowledge, 'estimate_rod_gain = .true.', .true.)
        status = gracecg_observations_free(from_folder)
        status = gracecg_observations_free(changed)
        status = gracecg_observations_free(observations)
        status = gracecg_options_replace(knowledge, c_string('&estimation /'), changed, failure)
        call check_text(changed, 'estimate_rod_gain = .false.', .true.)
        status = gracecg_setup_free(changed)
        status = gracecg_setup_free(knowledge)
        status = gracecg_case_open(c_string('back-1'), case, failure)
        status = gracecg_options_replace(case, c_string(GAIN_TOO), changed, failure)
        call check_text(changed, 'estimate_rod_gain = .true.', .true.)
        status = gracecg_case_free(changed)
        if (allocated(error)) return

        status = gracecg_options_replace(case, c_string('&optimal sigma_rod_gain = 1 /'), changed, failure)
        call check_refused(error, status, FAILED, failure, '&a_priori')
        status = gracecg_options_replace(case, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'handle')
        status = gracecg_case_free(case)
        status = gracecg_options_replace(case, c_string('&estimation /'), changed, failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'observation set')
        status = gracecg_options_text(case, size=NONE, error=failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'observation set')

    contains

        subroutine check_text(object, part, there)
            integer(c_intptr_t), intent(in) :: object
            character(*), intent(in) :: part
            logical, intent(in) :: there

            character(kind=c_char), allocatable, target :: text(:)
            integer(c_size_t) :: length

            if (allocated(error)) return
            status = gracecg_options_text(object, size=NONE, length=length, error=failure)
            call check_ok(error, status, failure)
            if (allocated(error)) return
            allocate (text(length + 1))
            status = gracecg_options_text(object, text, length + 1, error=failure)
            call check(error, (index(text_at(c_loc(text)), part) > 0) .eqv. there, part)
        end subroutine check_text
    end subroutine test_options

    !> What `optimal` and `sequential` say beside the offset.
    subroutine test_details(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(solution_struct), target :: solution
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(observation_set_t) :: set
        type(solution_t) :: expected
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: observations
        integer(c_int) :: status
        character(10), parameter :: NAMES(3) = [character(10) :: 'optimal', 'sequential', 'ascfest']
        integer :: i, k

        call find_case('front-3', case, problem)
        call new_simulator(case, simulator, problem)
        call observe(simulator, 1, 1, set, problem)
        call simulate('front-3', 1, 1, observations, status, failure)
        call check_ok(error, status, failure)
        do i = 1, size(NAMES)
            if (allocated(error)) return
            call estimate_offset(trim(NAMES(i)), set, report_options('front-3'), expected, problem)
            status = gracecg_estimate(c_string(trim(NAMES(i))), observations, solution, size=NONE, error=failure)
            call check_ok(error, status, failure)
            call check_equal(error, [solution%offset, solution%sigma], &
                             [expected%offset, [(sqrt(expected%covariance(k, k)), k=1, 3)]], trim(NAMES(i)))
            if (allocated(error)) return
            if (i == 3) exit
            call check_equal(error, [solution%variance_factor, solution%noise_level, solution%noise_corner, &
                                     solution%star_camera_sigma], &
                             [expected%variance_factor, expected%noise_level, expected%noise_corner, &
                              expected%star_camera_sigma], 'variance factor and noise')
            if (allocated(error)) return
            call check(error, int(solution%parameter_count), size(expected%parameters))
            if (allocated(error)) return
            k = size(expected%parameters)
            call check_equal(error, [solution%parameter_value(:k), solution%parameter_sigma(:k)], &
                             [expected%parameters%value, expected%parameters%sigma], 'parameters')
            if (allocated(error)) return
            call check(error, text_at(c_loc(solution%parameter_name(:, 1))), 'torque_x')
        end do
        if (.not. allocated(error)) &
            call check(error, solution%parameter_count == 0 .and. abs(solution%variance_factor) <= 0, &
                       'ascfest has no such parameters')
        status = gracecg_observations_free(observations)
    end subroutine test_details

    subroutine test_bound(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(bound_struct) :: bound
        type(case_t) :: case
        type(case_bound_t) :: expected
        type(error_t), allocatable :: problem
        character(:), allocatable :: text
        integer(c_intptr_t) :: handle
        integer(c_int) :: status

        call find_case('front-2', case, problem)
        call bound_of_case(case, estimation_options_t(), expected, problem)
        status = gracecg_case_open(c_string('front-2'), handle)
        status = gracecg_case_bound(handle, bound, failure)
        call check_ok(error, status, failure)
        call check_equal(error, [[bound%covariance], bound%sigma, bound%principal_sigma, [bound%direction], &
                                 bound%consider_sigma, [bound%by_source]], &
                         [[expected%covariance], expected%sigma, expected%principal_sigma, [expected%direction], &
                          expected%consider_sigma, [expected%by_source]], 'bound')
        if (allocated(error)) return
        ! the eigenvectors belong to the eigenvalues
        call check(error, norm2(matmul(bound%covariance, bound%direction(:, 3)) - &
                                bound%principal_sigma(3)**2*bound%direction(:, 3)) < &
                   1e-9_dp*bound%principal_sigma(3)**2, 'worst direction')
        status = gracecg_case_bound(handle, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'bound')
        status = gracecg_case_free(handle)
        status = gracecg_case_bound(handle, bound, failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'case')
        status = gracecg_gravity_open(c_string('point-mass'), 0, 0, handle)
        status = gracecg_case_bound(handle, bound, failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'case')
        status = gracecg_gravity_free(handle)
        case%satellite%rods%count = 0
        call case_text(case, text, problem)
        status = gracecg_case_parse(c_string(text), handle)
        status = gracecg_case_bound(handle, bound, failure)
        call check_refused(error, status, FAILED, failure, 'rods are off')
        status = gracecg_case_free(handle)
    end subroutine test_bound

    subroutine test_design(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(design_settings_struct) :: settings
        type(design_struct) :: design
        type(rod_struct) :: rods(9)
        type(calibration_t) :: calibration, planned_case
        type(design_settings_t) :: own_settings
        type(manoeuvre_design_t) :: expected
        type(map_point_t), allocatable :: points(:)
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: handle, planned
        integer(c_size_t) :: count
        integer(c_int) :: status
        integer :: i
        real(dp), parameter :: TIMES(2) = [0.0_dp, 6000.0_dp]       ! the second in the second revolution
        real(dp), dimension(2) :: latitude, longitude, worst
        real(dp), dimension(3, 2) :: sigma, direction, wave, force
        real(dp) :: epoch_state(13), later_state(13)

        status = gracecg_case_open(c_string('back-1'), handle)
        status = gracecg_case_values(handle, state=epoch_state)
        status = gracecg_design_defaults(handle, settings, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call find_calibration('back-1', calibration, problem)
        call check(error, abs(settings%duration - calibration%case%duration) <= 0 .and. &
                   abs(settings%rate_limit - calibration%case%limits%rate) <= 0 .and. &
                   abs(settings%highest_frequency - own_settings%highest_frequency) <= 0 .and. &
                   all((settings%waveform_used /= 0) .eqv. own_settings%waveform_used), 'defaults')
        if (allocated(error)) return
        settings%start = 1400
        settings%duration = 50
        settings%rate_limit = 0.9_dp*settings%rate_limit
        settings%lowest_frequency = 5/50.0_dp       ! few candidates
        settings%highest_frequency = 6/50.0_dp
        settings%waveform_used = [1, 0, 0, 0]
        settings%threads = 2
        status = gracecg_design_manoeuvre(handle, settings, planned, design, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        calibration%case%duration = settings%duration
        calibration%case%limits%rate = settings%rate_limit
        own_settings%lowest_frequency = settings%lowest_frequency
        own_settings%highest_frequency = settings%highest_frequency
        own_settings%waveform_used = [.true., .false., .false., .false.]
        call plan_manoeuvre(calibration, 1400.0_dp, own_settings, planned_case, expected, problem)
        call check(error,.not. allocated(problem), message_of(problem))
        call check_equal(error, [design%sigma, design%wave, design%force, design%worst, design%rate, design%excursion], &
                         [expected%sigma, expected%wave, expected%force, expected%worst, expected%rate, &
                          expected%excursion], 'design')
        if (allocated(error)) return
        call check(error, design%rate <= settings%rate_limit .and. design%evaluations == expected%evaluations .and. &
                   planned_case%case%name == 'back-1-design', 'limits, evaluations, name')
        if (allocated(error)) return

        ! the case that flies it: later, elsewhere, with these rods
        status = gracecg_case_values(planned, state=later_state)
        call check(error, norm2(later_state(1:3) - epoch_state(1:3)) > 1e6_dp, 'at another place')
        if (allocated(error)) return
        status = gracecg_case_rods(planned, NONE, count, error=failure)
        call check(error, status == OK .and. count == 3, 'number of rods')
        if (allocated(error)) return
        status = gracecg_case_rods(planned, 9_c_size_t, count, rods, failure)
        call check_ok(error, status, failure)
        do i = 1, 3
            associate (rod => expected%rods%activations(i))
                call check_equal(error, [rods(i)%amplitude, rods(i)%frequency, rods(i)%phase, rods(i)%stop], &
                                 [rod%amplitude, rod%frequency, rod%phase, rod%stop], 'rod')
                if (.not. allocated(error)) call check(error, int(rods(i)%axis), i)
            end associate
        end do
        if (allocated(error)) return
        status = gracecg_case_rods(planned, 2_c_size_t, count, rods, failure)
        call check_refused(error, status, BAD_SIZE, failure, 'there are 3')
        if (allocated(error)) return

        status = gracecg_map(planned, 2_c_size_t, TIMES, 2, latitude, longitude, sigma, worst, direction, wave, &
                             force, failure)
        call check_ok(error, status, failure)
        if (allocated(error)) return
        call map_case(planned_case%case, TIMES, 1, points, problem)
        call check(error,.not. allocated(problem), message_of(problem))
        do i = 1, 2
            call check_equal(error, [latitude(i), longitude(i), sigma(:, i), worst(i), direction(:, i), wave(:, i), &
                                     force(:, i)], &
                             [points(i)%latitude, points(i)%longitude, points(i)%quality%sigma, &
                              points(i)%worst_sigma, points(i)%worst_direction, points(i)%quality%wave, &
                              points(i)%quality%force], 'map')
        end do
        if (allocated(error)) return
        call check(error, maxval(abs(sigma(:, 1)/design%sigma - 1)) < 1e-5_dp, 'the map at the place of the design')
        status = gracecg_map(planned, NONE, threads=1, error=failure)
        if (.not. allocated(error)) call check(error, int(status), int(OK), 'a map of no place')
        status = gracecg_case_free(planned)
        status = gracecg_case_free(handle)
    end subroutine test_design

    !> Every setting that is none, missing pointers, handles of another kind: refused, with no case made.
    subroutine test_design_misuse(error)
        type(error_type), allocatable, intent(out) :: error

        type(error_struct) :: failure
        type(design_settings_struct) :: settings, right
        type(design_struct) :: design
        integer(c_intptr_t) :: handle, planned
        integer(c_int) :: status
        real(dp) :: nan, sigma(3, 1)

        nan = 0
        nan = ieee_value(nan, ieee_quiet_nan)
        status = gracecg_case_open(c_string('front-1'), handle)
        status = gracecg_design_defaults(handle, right)
        settings = right
        settings%start = nan
        call refuse(BAD_VALUE, 'number 1 of the settings')
        settings%pointing_limit = nan
        call refuse(BAD_VALUE, 'number 9 of the settings')
        settings%threads = 0
        call refuse(BAD_VALUE, 'threads = 0')
        settings%threads = 2000
        call refuse(BAD_VALUE, 'threads = 2000')
        settings%start = -1
        call refuse(FAILED, 'time of the calibration')
        settings%start = 1e5_dp
        call refuse(FAILED, 'time of the calibration')
        settings%duration = 1e9_dp
        call refuse(FAILED, 'duration')
        settings%duration = 0
        call refuse(FAILED, 'duration')
        settings%rate_limit = 0
        call refuse(FAILED, 'limits of rate')
        settings%amplitude = 31
        call refuse(FAILED, '30 A m^2')
        settings%highest_frequency = 6
        settings%lowest_frequency = 5.9_dp
        call refuse(FAILED, 'half the sampling')
        settings%lowest_frequency = 0.3_dp
        call refuse(FAILED, 'frequencies')
        settings%rod_used = 0
        call refuse(FAILED, 'rods are off')
        settings%waveform_used = 0
        call refuse(FAILED, 'no waveform')
        if (allocated(error)) return
        status = gracecg_design_manoeuvre(handle, right, design=design, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'planned')
        status = gracecg_design_manoeuvre(handle, planned=planned, design=design, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'settings')
        status = gracecg_design_manoeuvre(handle, right, planned, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'design')
        status = gracecg_design_defaults(handle, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'settings')
        status = gracecg_map(handle, ONE, threads=1, sigma=sigma, error=failure)
        call check_refused(error, status, NULL_POINTER, failure, 'seconds')
        status = gracecg_map(handle, ONE, [nan], 1, sigma=sigma, error=failure)
        call check_refused(error, status, BAD_VALUE, failure, 'seconds')
        status = gracecg_map(handle, ONE, [-5.0_dp], 1, sigma=sigma, error=failure)
        call check_refused(error, status, FAILED, failure, 'time of the calibration')
        status = gracecg_map(handle, ONE, [1e9_dp], 1, sigma=sigma, error=failure)
        call check_refused(error, status, FAILED, failure, '150 revolutions')
        status = gracecg_map(handle, ONE, [0.0_dp], -1, sigma=sigma, error=failure)
        call check_refused(error, status, BAD_VALUE, failure, 'threads')
        status = gracecg_map(handle, -1_c_size_t, [0.0_dp], 1, sigma=sigma, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'n is too great')
        status = gracecg_case_rods(handle, -1_c_size_t, error=failure)
        call check_refused(error, status, BAD_SIZE, failure, 'capacity')
        status = gracecg_case_free(handle)
        planned = 77
        status = gracecg_design_manoeuvre(handle, right, planned, design, failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'case')
        if (.not. allocated(error)) call check(error, planned == 0, 'the handle after a failure')
        status = gracecg_design_defaults(handle, settings, failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'case')
        status = gracecg_map(handle, ONE, [0.0_dp], 1, sigma=sigma, error=failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'case')
        status = gracecg_case_rods(handle, NONE, error=failure)
        call check_refused(error, status, BAD_HANDLE, failure, 'case')

    contains

        subroutine refuse(expected, part)
            integer(c_int), intent(in) :: expected
            character(*), intent(in) :: part

            planned = 77
            status = gracecg_design_manoeuvre(handle, settings, planned, design, failure)
            call check_refused(error, status, expected, failure, part)
            if (.not. allocated(error)) call check(error, planned == 0, part//': a handle after a failure')
            settings = right
        end subroutine refuse
    end subroutine test_design_misuse

    !> The tests above have freed all that they made.
    subroutine test_nothing_left(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, live_objects(), 0, 'objects are left')
    end subroutine test_nothing_left
end module test_c_interface
