!> From a case to its models: the satellite's dynamics, its initial state.
module gracecg_simulation_case_models
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: SECONDS_PER_DAY, MJD_TO_JD
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_environment_earth_orientation, only: earth_parameters_t, new_earth_orientation
    use gracecg_environment_time, only: decimal_year, day_of_year, julian_centuries_tt, local_mean_solar_time
    use gracecg_environment_gravity_models, only: new_gravity_model
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model
    use gracecg_environment_space_weather, only: space_weather_source_t
    use gracecg_environment_density_models, only: new_density_model, density_settings_t
    use gracecg_environment_wind_models, only: new_wind_model
    use gracecg_environment_earth_radiation, only: new_earth_radiation, standard_rings, EARTH_RADIATION_EPOCH_JD
    use gracecg_spacecraft_mass_properties, only: mass_properties_t, inertia_about_com, validate_mass_properties
    use gracecg_spacecraft_plates, only: new_trapezoid
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, STATE_SIZE
    use gracecg_simulation_star_catalogue, only: star_catalogue_t, builtin_star_catalogue, read_star_catalogue
    use gracecg_simulation_attitude_control, only: check_control
    use gracecg_simulation_case, only: case_t, earth_orientation_name, find_earth_parameters, sidereal_angle_at_epoch
    implicit none
    private
    public :: build_dynamics, initial_state, case_star_catalogue

contains

    !> The satellite's dynamics with every model of the case.
    !>
    !> The density wave is left out when its phase is drawn anew for every run: the simulation then
    !> applies it to the sampled drag, where its effect is linear (on the torque it is below 1e-4 of
    !> the magnetic one).
    subroutine build_dynamics(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(out) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        call set_time(case, dynamics, error)
        if (.not. allocated(error)) call set_mass(case, dynamics, error)
        if (.not. allocated(error)) &
            call new_gravity_model(trim(case%gravity_model), case%gravity_degree, case%gravity_order, case%gravity_file, &
                                   dynamics%gravity, error)
        if (.not. allocated(error)) &
            call new_geomagnetic_model(trim(case%field_model), decimal_year(case%epoch), case%field_file, dynamics%field, error)
        if (.not. allocated(error)) call set_atmosphere(case, dynamics, error)
        if (.not. allocated(error)) call set_surface(case, dynamics, error)
        call add_context(error, 'case '//trim(case%name))
    end subroutine build_dynamics

    !> The 13 components of the state at the epoch.
    pure function initial_state(case) result(state)
        type(case_t), intent(in) :: case
        real(dp) :: state(STATE_SIZE)

        state = [case%position, case%velocity, case%angular_velocity, case%quaternion]
    end function initial_state

    !> The catalogue of stars: that of the case's file, or the embedded one. Fails as `read_star_catalogue`.
    subroutine case_star_catalogue(case, catalogue, error)
        type(case_t), intent(in) :: case
        type(star_catalogue_t), intent(out) :: catalogue
        type(error_t), allocatable, intent(out) :: error

        if (case%star_catalogue_file == '') then
            catalogue = builtin_star_catalogue()
        else
            call read_star_catalogue(trim(case%star_catalogue_file), catalogue, error)
        end if
    end subroutine case_star_catalogue

    subroutine set_time(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        type(earth_parameters_t) :: parameters

        call find_earth_parameters(case, parameters, error)
        if (allocated(error)) return
        call new_earth_orientation(trim(earth_orientation_name(case)), case%epoch, sidereal_angle_at_epoch(case), &
                                   parameters, dynamics%earth, error)
        associate (epoch => case%epoch)
            dynamics%epoch = epoch
            dynamics%local_time_greenwich = local_mean_solar_time(epoch, 0.0_dp)
            dynamics%day_of_year = day_of_year(epoch)
            dynamics%julian_centuries_tt = julian_centuries_tt(epoch)
            dynamics%earth_radiation_day = epoch%mjd + epoch%seconds/SECONDS_PER_DAY + &
                                           (MJD_TO_JD - EARTH_RADIATION_EPOCH_JD)
        end associate
    end subroutine set_time

    subroutine set_mass(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        type(mass_properties_t) :: properties

        properties = mass_properties_t(case%satellite%mass, case%satellite%inertia, case%satellite%offset)
        call validate_mass_properties(properties, error)
        if (allocated(error)) return
        dynamics%mass = properties%mass
        dynamics%inertia = inertia_about_com(properties)
        dynamics%inverse_inertia = inverse_3x3(dynamics%inertia)
        dynamics%rods = case%satellite%rods
        call check_control(case%control, dynamics%rods, error)
        if (allocated(error)) return
        dynamics%control = case%control
        call dynamics%control%hold(initial_state(case))
    end subroutine set_mass

    subroutine set_atmosphere(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        type(density_settings_t) :: settings

        dynamics%with_drag = case%density_model /= 'none'
        dynamics%density_scale = case%density_scale
        if (.not. case%density_wave_random) dynamics%density_wave = case%density_wave
        if (dynamics%with_drag) then
            settings%space_weather = space_weather_source_t(case%space_weather, case%f107, case%f107_mean, &
                                                            case%kp, case%space_weather_file)
            settings%reference_density = case%reference_density
            settings%reference_height = case%reference_height
            settings%scale_height = case%scale_height
            call new_density_model(trim(case%density_model), case%epoch, settings, &
                                   dynamics%atmosphere, error)
        end if
        if (case%wind_model /= 'none' .and. .not. allocated(error)) &
            call new_wind_model(trim(case%wind_model), case%wind_east, case%wind_north, case%wind_file, &
                                dynamics%wind, error)
    end subroutine set_atmosphere

    subroutine set_surface(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        call new_trapezoid(case%satellite%length, case%satellite%height, case%satellite%width_bottom, &
                           case%satellite%width_top, case%satellite%specular, case%satellite%diffuse, dynamics%surface, &
                           error)
        if (allocated(error)) return
        dynamics%centre_of_mass = case%satellite%centre_of_mass
        dynamics%drag_coefficient = case%satellite%drag_coefficient
        dynamics%wall = case%satellite%wall
        dynamics%forces_by_plates = case%satellite%forces == 'plates'
        dynamics%reflectivity_sun = case%satellite%reflectivity_sun
        dynamics%reflectivity_earth = case%satellite%reflectivity_earth
        dynamics%solar_irradiance = case%solar_irradiance
        call new_earth_radiation(trim(case%earth_radiation_constants), standard_rings(case%earth_radiation_rings), &
                                 case%solar_irradiance, dynamics%earth_radiation, error, &
                                 trim(case%earth_radiation_centres))
    end subroutine set_surface
end module gracecg_simulation_case_models
