!> From a case to its models: the satellite's dynamics, its initial state, the operator's knowledge.
module gracecg_simulation_case_models
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM, SECONDS_PER_DAY
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_environment_time, only: utc_t, gmst_1982, decimal_year, day_of_year, julian_centuries_tt, &
        local_mean_solar_time
    use gracecg_environment_geopotential, only: geopotential_t, point_mass_gravity_t, egm96
    use gracecg_environment_gfc_file, only: read_gfc
    use gracecg_environment_geomagnetic_field, only: igrf_t, igrf
    use gracecg_environment_shc_file, only: read_shc
    use gracecg_environment_space_weather, only: space_weather_t, embedded_space_weather, read_space_weather
    use gracecg_environment_thermosphere, only: dtm77_t, new_dtm77, exponential_density_t, new_exponential_density
    use gracecg_environment_wind, only: constant_wind_t, tabulated_wind_t, embedded_wind, read_wind
    use gracecg_environment_earth_radiation, only: new_earth_radiation, standard_rings, EARTH_RADIATION_EPOCH_JD
    use gracecg_spacecraft_mass_properties, only: mass_properties_t, inertia_about_com, validate_mass_properties
    use gracecg_spacecraft_plates, only: new_trapezoid
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, STATE_SIZE
    use gracecg_simulation_star_catalogue, only: star_catalogue_t, builtin_star_catalogue, read_star_catalogue
    use gracecg_simulation_star_camera, only: N_HEADS
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_simulation_case, only: case_t
    implicit none
    private
    public :: build_dynamics, initial_state, operator_setup, case_star_catalogue

    real(dp), parameter :: MJD_TO_JD = 2400000.5_dp

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

        call set_time(case, dynamics)
        call set_mass(case, dynamics, error)
        if (.not. allocated(error)) call set_gravity(case, dynamics, error)
        if (.not. allocated(error)) call set_magnetic_field(case, dynamics, error)
        if (.not. allocated(error)) call set_atmosphere(case, dynamics, error)
        if (.not. allocated(error)) call set_surface(case, dynamics, error)
        call add_context(error, 'case '//trim(case%knowledge%name))
    end subroutine build_dynamics

    !> The 13 components of the state at the epoch.
    pure function initial_state(case) result(state)
        type(case_t), intent(in) :: case
        real(dp) :: state(STATE_SIZE)

        state = [case%position, case%velocity, case%angular_velocity, case%quaternion]
    end function initial_state

    !> What the operator knows: the case's setup with the instruments' nominal performance, and the
    !> field model of the case to stand in for the magnetometer (IGRF-14 for one from a file).
    function operator_setup(case) result(knowledge)
        type(case_t), intent(in) :: case
        type(operator_knowledge_t) :: knowledge

        integer :: head

        knowledge = case%knowledge
        knowledge%accelerometer_interval = case%accelerometer%sampling_interval
        knowledge%accelerometer_noise = case%accelerometer%noise
        knowledge%sidereal_angle = sidereal_angle_at_epoch(case)
        knowledge%field_model = case%field_model
        if (case%field_model == 'file') knowledge%field_model = 'igrf14'
        do head = 1, N_HEADS
            knowledge%mounting(:, head) = case%star_camera%mounting(head)
        end do
    end function operator_setup

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

    subroutine set_time(case, dynamics)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics

        associate (epoch => case%knowledge%epoch)
            dynamics%epoch = epoch
            dynamics%sidereal_angle = sidereal_angle_at_epoch(case)
            dynamics%local_time_greenwich = local_mean_solar_time(epoch, 0.0_dp)
            dynamics%day_of_year = day_of_year(epoch)
            dynamics%julian_centuries_tt = julian_centuries_tt(epoch)
            dynamics%earth_radiation_day = epoch%mjd + epoch%seconds/SECONDS_PER_DAY + &
                                           (MJD_TO_JD - EARTH_RADIATION_EPOCH_JD)
        end associate
    end subroutine set_time

    !> Of Greenwich, rad.
    pure real(dp) function sidereal_angle_at_epoch(case) result(angle)
        type(case_t), intent(in) :: case

        if (case%earth_rotation == 'given') then
            angle = case%sidereal_angle
        else
            angle = gmst_1982(case%knowledge%epoch, case%ut1_minus_utc)
        end if
    end function sidereal_angle_at_epoch

    subroutine set_mass(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        type(mass_properties_t) :: properties

        properties = mass_properties_t(case%knowledge%mass, case%knowledge%inertia, case%offset)
        call validate_mass_properties(properties, error)
        if (allocated(error)) return
        dynamics%mass = properties%mass
        dynamics%inertia = inertia_about_com(properties)
        dynamics%inverse_inertia = inverse_3x3(dynamics%inertia)
        dynamics%rods = case%knowledge%rods
    end subroutine set_mass

    subroutine set_gravity(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        type(geopotential_t) :: geopotential

        select case (case%gravity_model)
        case ('egm96')
            call egm96(case%gravity_degree, case%gravity_order, geopotential, error)
        case ('file')
            call read_gfc(trim(case%gravity_file), case%gravity_degree, case%gravity_order, &
                          geopotential, error)
        case default
            dynamics%gravity = point_mass_gravity_t(EARTH_GM)
            return
        end select
        if (.not. allocated(error)) dynamics%gravity = geopotential
    end subroutine set_gravity

    subroutine set_magnetic_field(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        type(igrf_t) :: model
        real(dp) :: year

        year = decimal_year(case%knowledge%epoch)
        if (case%field_model == 'file') then
            call read_shc(trim(case%field_file), year, model, error)
        else
            call igrf(trim(case%field_model), year, model, error)
        end if
        if (.not. allocated(error)) dynamics%field = model
    end subroutine set_magnetic_field

    subroutine set_atmosphere(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        type(dtm77_t) :: dtm77
        type(exponential_density_t) :: exponential
        real(dp) :: f107, f107_mean, kp

        dynamics%with_drag = case%density_model /= 'none'
        dynamics%density_scale = case%density_scale
        if (.not. case%density_wave_random) dynamics%density_wave = case%density_wave
        select case (case%density_model)
        case ('dtm77')
            call take_space_weather(case, f107, f107_mean, kp, error)
            if (allocated(error)) return
            call new_dtm77(f107, f107_mean, kp, dtm77, error)
            if (allocated(error)) return
            dynamics%atmosphere = dtm77
        case ('exponential')
            call new_exponential_density(case%reference_density, case%reference_height, &
                                         case%scale_height, exponential, error)
            if (allocated(error)) return
            dynamics%atmosphere = exponential
        end select
        call set_wind(case, dynamics, error)
    end subroutine set_atmosphere

    subroutine take_space_weather(case, f107, f107_mean, kp, error)
        type(case_t), intent(in) :: case
        real(dp), intent(out) :: f107, f107_mean    !! sfu
        real(dp), intent(out) :: kp
        type(error_t), allocatable, intent(out) :: error

        type(space_weather_t) :: table

        f107 = case%f107
        f107_mean = case%f107_mean
        kp = case%kp
        if (case%space_weather == 'given') return
        if (case%space_weather == 'file') then
            call read_space_weather(trim(case%space_weather_file), table, error)
            if (allocated(error)) return
        else
            table = embedded_space_weather()
        end if
        call table%indices_at(case%knowledge%epoch, f107, f107_mean, kp, error)
    end subroutine take_space_weather

    subroutine set_wind(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        type(tabulated_wind_t) :: table

        select case (case%wind_model)
        case ('hwm93')
            dynamics%wind = embedded_wind()
        case ('file')
            call read_wind(trim(case%wind_file), table, error)
            if (.not. allocated(error)) dynamics%wind = table
        case ('constant')
            dynamics%wind = constant_wind_t(case%wind_east, case%wind_north)
        end select
    end subroutine set_wind

    subroutine set_surface(case, dynamics, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(inout) :: dynamics
        type(error_t), allocatable, intent(out) :: error

        call new_trapezoid(dynamics%surface, case%length, case%height, case%width_bottom, &
                           case%width_top, case%specular, case%diffuse, error)
        if (allocated(error)) return
        dynamics%centre_of_mass = case%centre_of_mass
        dynamics%drag_coefficient = case%drag_coefficient
        dynamics%wall = case%wall
        dynamics%reflectivity_sun = case%reflectivity_sun
        dynamics%reflectivity_earth = case%reflectivity_earth
        dynamics%solar_irradiance = case%solar_irradiance
        call new_earth_radiation(dynamics%earth_radiation, trim(case%earth_radiation_constants), &
                                 standard_rings(case%earth_radiation_rings), case%solar_irradiance, error)
    end subroutine set_surface
end module gracecg_simulation_case_models
