!> The C interface as include/gracecg.h declares it, for tests that call it as C does. An absent argument
!> is NULL.
module c_library
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_f_pointer, c_int, c_int32_t, c_intptr_t, &
        c_loc, c_null_char, c_null_ptr, c_ptr, c_size_t
    implicit none
    private
    public :: error_struct, utc_struct, samples_struct, solution_struct
    public :: bound_struct, rod_struct, design_settings_struct, design_struct
    public :: gracecg_case_bound, gracecg_case_rods, gracecg_design_defaults, gracecg_design_manoeuvre, gracecg_map
    public :: gracecg_version, gracecg_status_text, gracecg_algorithm_count, gracecg_algorithm_name
    public :: gracecg_case_count, gracecg_case_name
    public :: gracecg_utc_parse, gracecg_utc_add, gracecg_utc_difference, gracecg_sidereal_angle
    public :: gracecg_earth_fixed
    public :: gracecg_gravity_open, gracecg_gravity_free, gracecg_gravity_evaluate
    public :: gracecg_field_open, gracecg_field_free, gracecg_field_evaluate
    public :: gracecg_density_open, gracecg_density_open_indices, gracecg_density_free
    public :: gracecg_density_evaluate, gracecg_density_open_model, gracecg_density_open_model_indices
    public :: gracecg_wind_open, gracecg_wind_free, gracecg_wind_evaluate
    public :: gracecg_sun_position, gracecg_sun_illumination
    public :: gracecg_earth_radiation_open, gracecg_earth_radiation_free, gracecg_earth_radiation_flux
    public :: gracecg_earth_radiation_segments
    public :: gracecg_surface_trapezoid, gracecg_surface_create, gracecg_surface_free
    public :: gracecg_surface_area, gracecg_surface_drag, gracecg_surface_sunlight
    public :: gracecg_surface_earthlight, gracecg_surface_aerodynamic_load, gracecg_surface_sunlight_load
    public :: gracecg_case_open, gracecg_case_parse, gracecg_case_free, gracecg_case_text
    public :: gracecg_case_values
    public :: gracecg_force_model_open, gracecg_force_model_free, gracecg_force_model_epoch
    public :: gracecg_force_model_evaluate, gracecg_force_model_torques, gracecg_force_model_rate
    public :: gracecg_force_model_propagate, gracecg_force_model_propagate_nadir
    public :: gracecg_simulator_open, gracecg_simulator_free, gracecg_simulator_truth
    public :: gracecg_setup_measured, gracecg_estimate_joint, gracecg_estimate_chain, joint_struct
    public :: gracecg_estimate_level1, gracecg_estimate_level1_day, level1_struct
    public :: gracecg_setup_read, gracecg_setup_parse, gracecg_setup_free, gracecg_setup_text
    public :: gracecg_observations_create, gracecg_observations_read, gracecg_observations_write
    public :: gracecg_observations_simulate, gracecg_observations_free, gracecg_observations_setup
    public :: gracecg_observations_counts, gracecg_observations_accelerometer
    public :: gracecg_observations_star_camera, gracecg_observations_magnetometer
    public :: gracecg_observations_orbit, gracecg_options_text, gracecg_options_replace, gracecg_estimate
    public :: message_text, text_at, c_string, no_samples

    type, bind(c) :: error_struct
        integer(c_int32_t) :: status = -1
        character(kind=c_char) :: message(1020) = '?'
    end type error_struct

    type, bind(c) :: joint_struct
        real(c_double) :: offset(3) = -1, covariance(3, 3) = -1, chi_square = -1, probability = -1
        integer(c_int32_t) :: degrees = -1, consistent = -1
    end type joint_struct

    type, bind(c) :: level1_struct
        real(c_double) :: offset(3) = -1, covariance(3, 3) = -1, time = -1, gain(3) = -1, gain_sigma(3) = -1
        real(c_double) :: torque_delay = -1, torque_delay_sigma = -1, accelerometer_delay = -1
        real(c_double) :: accelerometer_delay_sigma = -1, condition = -1, residual_rms(3) = -1, chi_square = -1
        integer(c_int32_t) :: degrees = -1, spans = -1, samples = -1, leakage = -1, flag = -1, reserved = -1
    end type level1_struct

    type, bind(c) :: utc_struct
        integer(c_int32_t) :: mjd = 0
        real(c_double) :: seconds = 0
    end type utc_struct

    type, bind(c) :: samples_struct
        integer(c_size_t) :: accelerometer_count
        type(c_ptr) :: accelerometer_time, acceleration
        integer(c_size_t) :: star_camera_count
        type(c_ptr) :: star_camera_time, star_camera_head, quaternion
        integer(c_size_t) :: magnetometer_count
        type(c_ptr) :: magnetometer_time, flux_density
        integer(c_size_t) :: orbit_count
        type(c_ptr) :: orbit_time, orbit_position
    end type samples_struct

    type, bind(c) :: solution_struct
        real(c_double) :: offset(3), sigma(3), covariance(3, 3), drift(3), bias(3), quaternion(4)
        real(c_double) :: angular_velocity(3), residual_rms(3), condition, variance_factor
        real(c_double) :: noise_level(3), noise_corner(3), star_camera_sigma(3)
        real(c_double) :: parameter_value(16), parameter_sigma(16)
        character(kind=c_char) :: parameter_name(16, 16)
        integer(c_int32_t) :: parameter_count, edited(2), iterations, converged, warning_count
    end type solution_struct

    type, bind(c) :: bound_struct
        real(c_double) :: covariance(3, 3), sigma(3), principal_sigma(3), direction(3, 3), consider_sigma(3)
        real(c_double) :: by_source(3, 5)
    end type bound_struct

    type, bind(c) :: rod_struct
        real(c_double) :: amplitude, frequency, phase, start, stop, taper, rise_time
        integer(c_int32_t) :: axis, waveform
    end type rod_struct

    type, bind(c) :: design_settings_struct
        real(c_double) :: start, duration, amplitude, lowest_frequency, highest_frequency, taper, rise_time
        real(c_double) :: rate_limit, pointing_limit
        integer(c_int32_t) :: rod_used(3), waveform_used(4), threads
    end type design_settings_struct

    type, bind(c) :: design_struct
        real(c_double) :: sigma(3), wave(3), force(3), worst, rate, excursion
        integer(c_int32_t) :: evaluations, reserved
    end type design_struct

    interface
        function gracecg_version() result(text) bind(c, name='gracecg_version')
            import :: c_ptr
            type(c_ptr) :: text
        end function gracecg_version

        function gracecg_status_text(status) result(text) bind(c, name='gracecg_status_text')
            import :: c_int, c_ptr
            integer(c_int), intent(in), value :: status
            type(c_ptr) :: text
        end function gracecg_status_text

        function gracecg_algorithm_count() result(n) bind(c, name='gracecg_algorithm_count')
            import :: c_int32_t
            integer(c_int32_t) :: n
        end function gracecg_algorithm_count

        function gracecg_algorithm_name(index) result(text) bind(c, name='gracecg_algorithm_name')
            import :: c_int32_t, c_ptr
            integer(c_int32_t), intent(in), value :: index
            type(c_ptr) :: text
        end function gracecg_algorithm_name

        function gracecg_case_count() result(n) bind(c, name='gracecg_case_count')
            import :: c_int32_t
            integer(c_int32_t) :: n
        end function gracecg_case_count

        function gracecg_case_name(index) result(text) bind(c, name='gracecg_case_name')
            import :: c_int32_t, c_ptr
            integer(c_int32_t), intent(in), value :: index
            type(c_ptr) :: text
        end function gracecg_case_name

        function gracecg_utc_parse(text, utc, error) result(status) bind(c, name='gracecg_utc_parse')
            import :: c_char, c_int, error_struct, utc_struct
            character(kind=c_char), intent(in), optional :: text(*)
            type(utc_struct), intent(inout), optional :: utc
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_utc_parse

        function gracecg_utc_add(utc, seconds, later, error) &
            result(status) bind(c, name='gracecg_utc_add')
            import :: c_double, c_int, error_struct, utc_struct
            type(utc_struct), intent(in), optional :: utc
            real(c_double), intent(in), value :: seconds
            type(utc_struct), intent(inout), optional :: later
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_utc_add

        function gracecg_utc_difference(start_time, finish, seconds, error) &
            result(status) bind(c, name='gracecg_utc_difference')
            import :: c_double, c_int, error_struct, utc_struct
            type(utc_struct), intent(in), optional :: start_time
            type(utc_struct), intent(in), optional :: finish
            real(c_double), intent(inout), optional :: seconds
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_utc_difference

        function gracecg_sidereal_angle(utc, ut1_minus_utc, angle, error) &
            result(status) bind(c, name='gracecg_sidereal_angle')
            import :: c_double, c_int, error_struct, utc_struct
            type(utc_struct), intent(in), optional :: utc
            real(c_double), intent(in), value :: ut1_minus_utc
            real(c_double), intent(inout), optional :: angle
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_sidereal_angle

        function gracecg_earth_fixed(sidereal_angle, n, inertial, fixed, error) &
            result(status) bind(c, name='gracecg_earth_fixed')
            import :: c_double, c_int, c_size_t, error_struct
            real(c_double), intent(in), value :: sidereal_angle
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: inertial(*)
            real(c_double), intent(inout), optional :: fixed(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_earth_fixed

        function gracecg_gravity_open(name_or_file, degree, order, gravity, error) &
            result(status) bind(c, name='gracecg_gravity_open')
            import :: c_char, c_int, c_int32_t, c_intptr_t, error_struct
            character(kind=c_char), intent(in), optional :: name_or_file(*)
            integer(c_int32_t), intent(in), value :: degree
            integer(c_int32_t), intent(in), value :: order
            integer(c_intptr_t), intent(inout), optional :: gravity
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_gravity_open

        function gracecg_gravity_free(gravity, error) &
            result(status) bind(c, name='gracecg_gravity_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: gravity
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_gravity_free

        function gracecg_gravity_evaluate(gravity, n, position, acceleration, potential, gradient, &
            error) result(status) bind(c, name='gracecg_gravity_evaluate')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: gravity
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: position(*)
            real(c_double), intent(inout), optional :: acceleration(*)
            real(c_double), intent(inout), optional :: potential(*)
            real(c_double), intent(inout), optional :: gradient(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_gravity_evaluate

        function gracecg_field_open(name_or_file, date, field, error) &
            result(status) bind(c, name='gracecg_field_open')
            import :: c_char, c_int, c_intptr_t, error_struct, utc_struct
            character(kind=c_char), intent(in), optional :: name_or_file(*)
            type(utc_struct), intent(in), optional :: date
            integer(c_intptr_t), intent(inout), optional :: field
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_field_open

        function gracecg_field_free(field, error) result(status) bind(c, name='gracecg_field_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: field
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_field_free

        function gracecg_field_evaluate(field, n, position, flux_density, error) &
            result(status) bind(c, name='gracecg_field_evaluate')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: field
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: position(*)
            real(c_double), intent(inout), optional :: flux_density(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_field_evaluate

        function gracecg_density_open(date, density, error) &
            result(status) bind(c, name='gracecg_density_open')
            import :: c_int, c_intptr_t, error_struct, utc_struct
            type(utc_struct), intent(in), optional :: date
            integer(c_intptr_t), intent(inout), optional :: density
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_density_open

        function gracecg_density_open_indices(f107, f107_mean, kp, density, error) &
            result(status) bind(c, name='gracecg_density_open_indices')
            import :: c_double, c_int, c_intptr_t, error_struct
            real(c_double), intent(in), value :: f107
            real(c_double), intent(in), value :: f107_mean
            real(c_double), intent(in), value :: kp
            integer(c_intptr_t), intent(inout), optional :: density
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_density_open_indices

        function gracecg_density_open_model(name, date, density, error) &
            result(status) bind(c, name='gracecg_density_open_model')
            import :: c_char, c_int, c_intptr_t, error_struct, utc_struct
            character(kind=c_char), intent(in), optional :: name(*)
            type(utc_struct), intent(in), optional :: date
            integer(c_intptr_t), intent(inout), optional :: density
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_density_open_model

        function gracecg_density_open_model_indices(name, f107, f107_mean, kp, density, error) &
            result(status) bind(c, name='gracecg_density_open_model_indices')
            import :: c_char, c_double, c_int, c_intptr_t, error_struct
            character(kind=c_char), intent(in), optional :: name(*)
            real(c_double), intent(in), value :: f107
            real(c_double), intent(in), value :: f107_mean
            real(c_double), intent(in), value :: kp
            integer(c_intptr_t), intent(inout), optional :: density
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_density_open_model_indices

        function gracecg_density_free(density, error) &
            result(status) bind(c, name='gracecg_density_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: density
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_density_free

        function gracecg_density_evaluate(density, epoch, n, seconds, position, mass_density, &
            temperature, number_density, error) result(status) bind(c, name='gracecg_density_evaluate')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct, utc_struct
            integer(c_intptr_t), intent(in), value :: density
            type(utc_struct), intent(in), optional :: epoch
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: seconds(*)
            real(c_double), intent(in), optional :: position(*)
            real(c_double), intent(inout), optional :: mass_density(*)
            real(c_double), intent(inout), optional :: temperature(*)
            real(c_double), intent(inout), optional :: number_density(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_density_evaluate

        function gracecg_wind_open(name_or_file, wind, error) &
            result(status) bind(c, name='gracecg_wind_open')
            import :: c_char, c_int, c_intptr_t, error_struct
            character(kind=c_char), intent(in), optional :: name_or_file(*)
            integer(c_intptr_t), intent(inout), optional :: wind
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_wind_open

        function gracecg_wind_free(wind, error) result(status) bind(c, name='gracecg_wind_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: wind
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_wind_free

        function gracecg_wind_evaluate(wind, epoch, n, seconds, position, east_north, error) &
            result(status) bind(c, name='gracecg_wind_evaluate')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct, utc_struct
            integer(c_intptr_t), intent(in), value :: wind
            type(utc_struct), intent(in), optional :: epoch
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: seconds(*)
            real(c_double), intent(in), optional :: position(*)
            real(c_double), intent(inout), optional :: east_north(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_wind_evaluate

        function gracecg_sun_position(epoch, n, seconds, position, error) &
            result(status) bind(c, name='gracecg_sun_position')
            import :: c_double, c_int, c_size_t, error_struct, utc_struct
            type(utc_struct), intent(in), optional :: epoch
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: seconds(*)
            real(c_double), intent(inout), optional :: position(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_sun_position

        function gracecg_sun_illumination(n, position, sun, illumination, error) &
            result(status) bind(c, name='gracecg_sun_illumination')
            import :: c_double, c_int, c_size_t, error_struct
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: position(*)
            real(c_double), intent(in), optional :: sun(*)
            real(c_double), intent(inout), optional :: illumination(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_sun_illumination

        function gracecg_earth_radiation_open(constants, rings, solar_irradiance, model, error) &
            result(status) bind(c, name='gracecg_earth_radiation_open')
            import :: c_char, c_double, c_int, c_int32_t, c_intptr_t, error_struct
            character(kind=c_char), intent(in), optional :: constants(*)
            integer(c_int32_t), intent(in), value :: rings
            real(c_double), intent(in), value :: solar_irradiance
            integer(c_intptr_t), intent(inout), optional :: model
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_earth_radiation_open

        function gracecg_earth_radiation_free(model, error) &
            result(status) bind(c, name='gracecg_earth_radiation_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: model
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_earth_radiation_free

        function gracecg_earth_radiation_flux(model, epoch, n, seconds, position, flux, error) &
            result(status) bind(c, name='gracecg_earth_radiation_flux')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct, utc_struct
            integer(c_intptr_t), intent(in), value :: model
            type(utc_struct), intent(in), optional :: epoch
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: seconds(*)
            real(c_double), intent(in), optional :: position(*)
            real(c_double), intent(inout), optional :: flux(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_earth_radiation_flux

        function gracecg_earth_radiation_segments(model, epoch, seconds, position, capacity, count, &
            irradiance, direction, error) &
            result(status) bind(c, name='gracecg_earth_radiation_segments')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct, utc_struct
            integer(c_intptr_t), intent(in), value :: model
            type(utc_struct), intent(in), optional :: epoch
            real(c_double), intent(in), value :: seconds
            real(c_double), intent(in), optional :: position(3)
            integer(c_size_t), intent(in), value :: capacity
            integer(c_size_t), intent(inout), optional :: count
            real(c_double), intent(inout), optional :: irradiance(*)
            real(c_double), intent(inout), optional :: direction(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_earth_radiation_segments

        function gracecg_surface_trapezoid(length, height, width_bottom, width_top, specular, &
            diffuse, surface, error) result(status) bind(c, name='gracecg_surface_trapezoid')
            import :: c_double, c_int, c_intptr_t, error_struct
            real(c_double), intent(in), value :: length
            real(c_double), intent(in), value :: height
            real(c_double), intent(in), value :: width_bottom
            real(c_double), intent(in), value :: width_top
            real(c_double), intent(in), value :: specular
            real(c_double), intent(in), value :: diffuse
            integer(c_intptr_t), intent(inout), optional :: surface
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_surface_trapezoid

        function gracecg_surface_create(n, normal, area, centre, specular, diffuse, surface, error) &
            result(status) bind(c, name='gracecg_surface_create')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: normal(*)
            real(c_double), intent(in), optional :: area(*)
            real(c_double), intent(in), optional :: centre(*)
            real(c_double), intent(in), optional :: specular(*)
            real(c_double), intent(in), optional :: diffuse(*)
            integer(c_intptr_t), intent(inout), optional :: surface
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_surface_create

        function gracecg_surface_free(surface, error) &
            result(status) bind(c, name='gracecg_surface_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: surface
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_surface_free

        function gracecg_surface_area(surface, direction, area, error) &
            result(status) bind(c, name='gracecg_surface_area')
            import :: c_double, c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: surface
            real(c_double), intent(in), optional :: direction(3)
            real(c_double), intent(inout), optional :: area
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_surface_area

        function gracecg_surface_drag(surface, mass, drag_coefficient, density, velocity, &
            acceleration, error) result(status) bind(c, name='gracecg_surface_drag')
            import :: c_double, c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: surface
            real(c_double), intent(in), value :: mass
            real(c_double), intent(in), value :: drag_coefficient
            real(c_double), intent(in), value :: density
            real(c_double), intent(in), optional :: velocity(3)
            real(c_double), intent(inout), optional :: acceleration(3)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_surface_drag

        function gracecg_surface_sunlight(surface, mass, reflectivity, solar_irradiance, &
            illumination, to_sun, acceleration, error) &
            result(status) bind(c, name='gracecg_surface_sunlight')
            import :: c_double, c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: surface
            real(c_double), intent(in), value :: mass
            real(c_double), intent(in), value :: reflectivity
            real(c_double), intent(in), value :: solar_irradiance
            real(c_double), intent(in), value :: illumination
            real(c_double), intent(in), optional :: to_sun(3)
            real(c_double), intent(inout), optional :: acceleration(3)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_surface_sunlight

        function gracecg_surface_earthlight(surface, mass, reflectivity, flux, position, &
            quaternion, acceleration, error) result(status) bind(c, name='gracecg_surface_earthlight')
            import :: c_double, c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: surface
            real(c_double), intent(in), value :: mass
            real(c_double), intent(in), value :: reflectivity
            real(c_double), intent(in), optional :: flux(3)
            real(c_double), intent(in), optional :: position(3)
            real(c_double), intent(in), optional :: quaternion(4)
            real(c_double), intent(inout), optional :: acceleration(3)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_surface_earthlight

        function gracecg_surface_aerodynamic_load(surface, centre_of_mass, density, temperature, &
            number_density, wall_temperature, accommodation, velocity, force, torque, error) &
            result(status) bind(c, name='gracecg_surface_aerodynamic_load')
            import :: c_double, c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: surface
            real(c_double), intent(in), optional :: centre_of_mass(3)
            real(c_double), intent(in), value :: density
            real(c_double), intent(in), value :: temperature
            real(c_double), intent(in), optional :: number_density(3)
            real(c_double), intent(in), value :: wall_temperature
            real(c_double), intent(in), value :: accommodation
            real(c_double), intent(in), optional :: velocity(3)
            real(c_double), intent(inout), optional :: force(3)
            real(c_double), intent(inout), optional :: torque(3)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_surface_aerodynamic_load

        function gracecg_surface_sunlight_load(surface, centre_of_mass, solar_irradiance, &
            illumination, to_sun, force, torque, error) &
            result(status) bind(c, name='gracecg_surface_sunlight_load')
            import :: c_double, c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: surface
            real(c_double), intent(in), optional :: centre_of_mass(3)
            real(c_double), intent(in), value :: solar_irradiance
            real(c_double), intent(in), value :: illumination
            real(c_double), intent(in), optional :: to_sun(3)
            real(c_double), intent(inout), optional :: force(3)
            real(c_double), intent(inout), optional :: torque(3)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_surface_sunlight_load

        function gracecg_case_open(name_or_file, the_case, error) &
            result(status) bind(c, name='gracecg_case_open')
            import :: c_char, c_int, c_intptr_t, error_struct
            character(kind=c_char), intent(in), optional :: name_or_file(*)
            integer(c_intptr_t), intent(inout), optional :: the_case
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_case_open

        function gracecg_case_parse(text, the_case, error) &
            result(status) bind(c, name='gracecg_case_parse')
            import :: c_char, c_int, c_intptr_t, error_struct
            character(kind=c_char), intent(in), optional :: text(*)
            integer(c_intptr_t), intent(inout), optional :: the_case
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_case_parse

        function gracecg_case_free(the_case, error) result(status) bind(c, name='gracecg_case_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: the_case
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_case_free

        function gracecg_case_text(the_case, text, size, length, error) &
            result(status) bind(c, name='gracecg_case_text')
            import :: c_char, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: the_case
            character(kind=c_char), intent(inout), optional :: text(*)
            integer(c_size_t), intent(in), value :: size
            integer(c_size_t), intent(inout), optional :: length
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_case_text

        function gracecg_case_values(the_case, epoch, duration, interval, state, offset, error) &
            result(status) bind(c, name='gracecg_case_values')
            import :: c_double, c_int, c_intptr_t, error_struct, utc_struct
            integer(c_intptr_t), intent(in), value :: the_case
            type(utc_struct), intent(inout), optional :: epoch
            real(c_double), intent(inout), optional :: duration
            real(c_double), intent(inout), optional :: interval
            real(c_double), intent(inout), optional :: state(13)
            real(c_double), intent(inout), optional :: offset(3)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_case_values

        function gracecg_force_model_open(the_case, model, error) &
            result(status) bind(c, name='gracecg_force_model_open')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: the_case
            integer(c_intptr_t), intent(inout), optional :: model
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_force_model_open

        function gracecg_force_model_free(model, error) &
            result(status) bind(c, name='gracecg_force_model_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: model
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_force_model_free

        function gracecg_force_model_epoch(model, epoch, sidereal_angle, error) &
            result(status) bind(c, name='gracecg_force_model_epoch')
            import :: c_double, c_int, c_intptr_t, error_struct, utc_struct
            integer(c_intptr_t), intent(in), value :: model
            type(utc_struct), intent(inout), optional :: epoch
            real(c_double), intent(inout), optional :: sidereal_angle
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_force_model_epoch

        function gracecg_force_model_evaluate(model, n, seconds, position, velocity, quaternion, &
            gravity, drag, solar_radiation, earth_radiation, total, error) &
            result(status) bind(c, name='gracecg_force_model_evaluate')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: model
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: seconds(*)
            real(c_double), intent(in), optional :: position(*)
            real(c_double), intent(in), optional :: velocity(*)
            real(c_double), intent(in), optional :: quaternion(*)
            real(c_double), intent(inout), optional :: gravity(*)
            real(c_double), intent(inout), optional :: drag(*)
            real(c_double), intent(inout), optional :: solar_radiation(*)
            real(c_double), intent(inout), optional :: earth_radiation(*)
            real(c_double), intent(inout), optional :: total(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_force_model_evaluate

        function gracecg_force_model_torques(model, seconds, state, aerodynamic, solar, &
            gravity_gradient, magnetic, flux_density, error) &
            result(status) bind(c, name='gracecg_force_model_torques')
            import :: c_double, c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: model
            real(c_double), intent(in), value :: seconds
            real(c_double), intent(in), optional :: state(13)
            real(c_double), intent(inout), optional :: aerodynamic(3)
            real(c_double), intent(inout), optional :: solar(3)
            real(c_double), intent(inout), optional :: gravity_gradient(3)
            real(c_double), intent(inout), optional :: magnetic(3)
            real(c_double), intent(inout), optional :: flux_density(3)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_force_model_torques

        function gracecg_force_model_rate(model, seconds, state, rate, error) &
            result(status) bind(c, name='gracecg_force_model_rate')
            import :: c_double, c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: model
            real(c_double), intent(in), value :: seconds
            real(c_double), intent(in), optional :: state(13)
            real(c_double), intent(inout), optional :: rate(13)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_force_model_rate

        function gracecg_force_model_propagate(model, state, interval, steps, tolerance, states, &
            error) result(status) bind(c, name='gracecg_force_model_propagate')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: model
            real(c_double), intent(in), optional :: state(13)
            real(c_double), intent(in), value :: interval
            integer(c_size_t), intent(in), value :: steps
            real(c_double), intent(in), value :: tolerance
            real(c_double), intent(inout), optional :: states(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_force_model_propagate

        function gracecg_force_model_propagate_nadir(model, position, velocity, forward, interval, steps, tolerance, &
            states, error) result(status) bind(c, name='gracecg_force_model_propagate_nadir')
            import :: c_double, c_int, c_int32_t, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: model
            real(c_double), intent(in), optional :: position(3), velocity(3)
            integer(c_int32_t), intent(in), value :: forward
            real(c_double), intent(in), value :: interval
            integer(c_size_t), intent(in), value :: steps
            real(c_double), intent(in), value :: tolerance
            real(c_double), intent(inout), optional :: states(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_force_model_propagate_nadir

        function gracecg_simulator_open(the_case, simulator, error) &
            result(status) bind(c, name='gracecg_simulator_open')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: the_case
            integer(c_intptr_t), intent(inout), optional :: simulator
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_simulator_open

        function gracecg_simulator_free(simulator, error) &
            result(status) bind(c, name='gracecg_simulator_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: simulator
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_simulator_free

        function gracecg_simulator_truth(simulator, capacity, count, seconds, states, &
            angular_acceleration, flux_density, non_gravitational, error) &
            result(status) bind(c, name='gracecg_simulator_truth')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: simulator
            integer(c_size_t), intent(in), value :: capacity
            integer(c_size_t), intent(inout), optional :: count
            real(c_double), intent(inout), optional :: seconds(*)
            real(c_double), intent(inout), optional :: states(*)
            real(c_double), intent(inout), optional :: angular_acceleration(*)
            real(c_double), intent(inout), optional :: flux_density(*)
            real(c_double), intent(inout), optional :: non_gravitational(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_simulator_truth

        function gracecg_setup_read(file, knowledge, error) &
            result(status) bind(c, name='gracecg_setup_read')
            import :: c_char, c_int, c_intptr_t, error_struct
            character(kind=c_char), intent(in), optional :: file(*)
            integer(c_intptr_t), intent(inout), optional :: knowledge
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_setup_read

        function gracecg_setup_parse(text, knowledge, error) &
            result(status) bind(c, name='gracecg_setup_parse')
            import :: c_char, c_int, c_intptr_t, error_struct
            character(kind=c_char), intent(in), optional :: text(*)
            integer(c_intptr_t), intent(inout), optional :: knowledge
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_setup_parse

        function gracecg_setup_free(knowledge, error) result(status) bind(c, name='gracecg_setup_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: knowledge
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_setup_free

        function gracecg_setup_measured(setup, n, time, moment, measured, error) &
            result(status) bind(c, name='gracecg_setup_measured')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: setup
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: time(*), moment(3, *)
            integer(c_intptr_t), intent(inout), optional :: measured
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_setup_measured

        function gracecg_setup_text(knowledge, text, size, length, error) &
            result(status) bind(c, name='gracecg_setup_text')
            import :: c_char, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: knowledge
            character(kind=c_char), intent(inout), optional :: text(*)
            integer(c_size_t), intent(in), value :: size
            integer(c_size_t), intent(inout), optional :: length
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_setup_text

        function gracecg_options_text(object, text, size, length, error) &
            result(status) bind(c, name='gracecg_options_text')
            import :: c_char, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: object
            character(kind=c_char), intent(inout), optional :: text(*)
            integer(c_size_t), intent(in), value :: size
            integer(c_size_t), intent(inout), optional :: length
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_options_text

        function gracecg_options_replace(object, text, changed, error) &
            result(status) bind(c, name='gracecg_options_replace')
            import :: c_char, c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: object
            character(kind=c_char), intent(in), optional :: text(*)
            integer(c_intptr_t), intent(inout), optional :: changed
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_options_replace

        function gracecg_observations_create(knowledge, samples, observations, error) &
            result(status) bind(c, name='gracecg_observations_create')
            import :: c_int, c_intptr_t, error_struct, samples_struct
            integer(c_intptr_t), intent(in), value :: knowledge
            type(samples_struct), intent(in), optional :: samples
            integer(c_intptr_t), intent(inout), optional :: observations
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_create

        function gracecg_observations_read(folder, observations, error) &
            result(status) bind(c, name='gracecg_observations_read')
            import :: c_char, c_int, c_intptr_t, error_struct
            character(kind=c_char), intent(in), optional :: folder(*)
            integer(c_intptr_t), intent(inout), optional :: observations
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_read

        function gracecg_observations_write(observations, folder, error) &
            result(status) bind(c, name='gracecg_observations_write')
            import :: c_char, c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: observations
            character(kind=c_char), intent(in), optional :: folder(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_write

        function gracecg_observations_simulate(simulator, seed, run, observations, error) &
            result(status) bind(c, name='gracecg_observations_simulate')
            import :: c_int, c_int32_t, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: simulator
            integer(c_int32_t), intent(in), value :: seed
            integer(c_int32_t), intent(in), value :: run
            integer(c_intptr_t), intent(inout), optional :: observations
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_simulate

        function gracecg_observations_free(observations, error) &
            result(status) bind(c, name='gracecg_observations_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: observations
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_free

        function gracecg_observations_setup(observations, knowledge, error) &
            result(status) bind(c, name='gracecg_observations_setup')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(in), value :: observations
            integer(c_intptr_t), intent(inout), optional :: knowledge
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_setup

        function gracecg_observations_counts(observations, counts, error) &
            result(status) bind(c, name='gracecg_observations_counts')
            import :: c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: observations
            integer(c_size_t), intent(inout), optional :: counts(4)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_counts

        function gracecg_observations_accelerometer(observations, capacity, time, acceleration, &
            error) result(status) bind(c, name='gracecg_observations_accelerometer')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: observations
            integer(c_size_t), intent(in), value :: capacity
            real(c_double), intent(inout), optional :: time(*)
            real(c_double), intent(inout), optional :: acceleration(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_accelerometer

        function gracecg_observations_star_camera(observations, capacity, time, head, quaternion, &
            error) result(status) bind(c, name='gracecg_observations_star_camera')
            import :: c_double, c_int, c_int32_t, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: observations
            integer(c_size_t), intent(in), value :: capacity
            real(c_double), intent(inout), optional :: time(*)
            integer(c_int32_t), intent(inout), optional :: head(*)
            real(c_double), intent(inout), optional :: quaternion(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_star_camera

        function gracecg_observations_magnetometer(observations, capacity, time, flux_density, error) &
            result(status) bind(c, name='gracecg_observations_magnetometer')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: observations
            integer(c_size_t), intent(in), value :: capacity
            real(c_double), intent(inout), optional :: time(*)
            real(c_double), intent(inout), optional :: flux_density(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_magnetometer

        function gracecg_observations_orbit(observations, capacity, time, position, error) &
            result(status) bind(c, name='gracecg_observations_orbit')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: observations
            integer(c_size_t), intent(in), value :: capacity
            real(c_double), intent(inout), optional :: time(*)
            real(c_double), intent(inout), optional :: position(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_observations_orbit

        function gracecg_estimate(algorithm, observations, solution, warnings, size, error) &
            result(status) bind(c, name='gracecg_estimate')
            import :: c_char, c_int, c_intptr_t, c_size_t, error_struct, solution_struct
            character(kind=c_char), intent(in), optional :: algorithm(*)
            integer(c_intptr_t), intent(in), value :: observations
            type(solution_struct), intent(inout), optional :: solution
            character(kind=c_char), intent(inout), optional :: warnings(*)
            integer(c_size_t), intent(in), value :: size
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_estimate

        function gracecg_estimate_joint(observations, count, joint, difference, difference_sigma, error) &
            result(status) bind(c, name='gracecg_estimate_joint')
            import :: c_double, c_int, c_intptr_t, c_size_t, error_struct, joint_struct
            integer(c_intptr_t), intent(inout), optional :: observations(*)
            integer(c_size_t), intent(in), value :: count
            type(joint_struct), intent(inout), optional :: joint
            real(c_double), intent(inout), optional :: difference(3, *), difference_sigma(3, *)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_estimate_joint

        function gracecg_estimate_chain(observations, arc, threads, joint, arcs, joined, warnings, size, error) &
            result(status) bind(c, name='gracecg_estimate_chain')
            import :: c_char, c_double, c_int, c_int32_t, c_intptr_t, c_size_t, error_struct, joint_struct
            integer(c_intptr_t), intent(in), value :: observations
            real(c_double), intent(in), value :: arc
            integer(c_int32_t), intent(in), value :: threads
            type(joint_struct), intent(inout), optional :: joint
            integer(c_size_t), intent(inout), optional :: arcs, joined
            character(kind=c_char), intent(inout), optional :: warnings(*)
            integer(c_size_t), intent(in), value :: size
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_estimate_chain

        function gracecg_estimate_level1(folder, setup, satellite, n_spans, spans, source, offset, text, size, length, &
                                         error) result(status) bind(c, name='gracecg_estimate_level1')
            import :: c_char, c_double, c_int, c_size_t, error_struct, level1_struct
            character(kind=c_char), intent(in), optional :: folder(*), setup(*), satellite(*), source(*)
            integer(c_size_t), intent(in), value :: n_spans, size
            real(c_double), intent(in), optional :: spans(2, *)
            type(level1_struct), intent(inout), optional :: offset
            character(kind=c_char), intent(inout), optional :: text(*)
            integer(c_size_t), intent(inout), optional :: length
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_estimate_level1

        function gracecg_estimate_level1_day(folder, setup, satellite, day, n_spans, spans, source, offset, text, size, &
                                             length, error) result(status) bind(c, name='gracecg_estimate_level1_day')
            import :: c_char, c_double, c_int, c_size_t, error_struct, level1_struct
            character(kind=c_char), intent(in), optional :: folder(*), setup(*), satellite(*), day(*), source(*)
            integer(c_size_t), intent(in), value :: n_spans, size
            real(c_double), intent(in), optional :: spans(2, *)
            type(level1_struct), intent(inout), optional :: offset
            character(kind=c_char), intent(inout), optional :: text(*)
            integer(c_size_t), intent(inout), optional :: length
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_estimate_level1_day

    end interface

    interface
        function gracecg_case_bound(the_case, bound, error) result(status) bind(c, name='gracecg_case_bound')
            import :: c_int, c_intptr_t, error_struct, bound_struct
            integer(c_intptr_t), intent(in), value :: the_case
            type(bound_struct), intent(inout), optional :: bound
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_case_bound

        function gracecg_case_rods(the_case, capacity, count, rods, error) &
            result(status) bind(c, name='gracecg_case_rods')
            import :: c_int, c_intptr_t, c_size_t, error_struct, rod_struct
            integer(c_intptr_t), intent(in), value :: the_case
            integer(c_size_t), intent(in), value :: capacity
            integer(c_size_t), intent(inout), optional :: count
            type(rod_struct), intent(inout), optional :: rods(*)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_case_rods

        function gracecg_design_defaults(the_case, settings, error) &
            result(status) bind(c, name='gracecg_design_defaults')
            import :: c_int, c_intptr_t, error_struct, design_settings_struct
            integer(c_intptr_t), intent(in), value :: the_case
            type(design_settings_struct), intent(inout), optional :: settings
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_design_defaults

        function gracecg_design_manoeuvre(the_case, settings, planned, design, error) &
            result(status) bind(c, name='gracecg_design_manoeuvre')
            import :: c_int, c_intptr_t, error_struct, design_settings_struct, design_struct
            integer(c_intptr_t), intent(in), value :: the_case
            type(design_settings_struct), intent(in), optional :: settings
            integer(c_intptr_t), intent(inout), optional :: planned
            type(design_struct), intent(inout), optional :: design
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_design_manoeuvre

        function gracecg_map(the_case, n, seconds, threads, latitude, longitude, sigma, worst_sigma, &
                             worst_direction, wave, force, error) result(status) bind(c, name='gracecg_map')
            import :: c_double, c_int, c_int32_t, c_intptr_t, c_size_t, error_struct
            integer(c_intptr_t), intent(in), value :: the_case
            integer(c_size_t), intent(in), value :: n
            real(c_double), intent(in), optional :: seconds(*)
            integer(c_int32_t), intent(in), value :: threads
            real(c_double), intent(inout), optional :: latitude(*), longitude(*), sigma(3, *), worst_sigma(*)
            real(c_double), intent(inout), optional :: worst_direction(3, *), wave(3, *), force(3, *)
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_map

        pure function c_strlen(text) result(n) bind(c, name='strlen')
            import :: c_ptr, c_size_t
            type(c_ptr), intent(in), value :: text
            integer(c_size_t) :: n
        end function c_strlen
    end interface

contains

    !> A text as C has it.
    pure function c_string(text) result(string)
        character(*), intent(in) :: text
        character(len(text) + 1) :: string

        string = text//c_null_char
    end function c_string

    !> The message of an error, filled up with blanks. Not of deferred length: gfortran keeps the length of
    !> such a result in static memory, where threads would share it.
    pure function message_text(error) result(text)
        type(error_struct), intent(in) :: error
        character(size(error%message)) :: text

        integer :: i

        text = ''
        do i = 1, size(error%message)
            if (error%message(i) == c_null_char) exit
            text(i:i) = error%message(i)
        end do
    end function message_text

    !> The text at an address.
    function text_at(address) result(text)
        type(c_ptr), intent(in) :: address
        character(:), allocatable :: text

        character(kind=c_char), pointer :: characters(:)
        integer :: i

        call c_f_pointer(address, characters, [c_strlen(address)])
        text = repeat(' ', size(characters))
        do i = 1, size(characters)
            text(i:i) = characters(i)
        end do
    end function text_at

    !> No samples of any instrument.
    function no_samples() result(samples)
        type(samples_struct) :: samples

        samples = samples_struct(0, c_null_ptr, c_null_ptr, 0, c_null_ptr, c_null_ptr, c_null_ptr, &
                                 0, c_null_ptr, c_null_ptr, 0, c_null_ptr, c_null_ptr)
    end function no_samples
end module c_library
