!> Forces and torques of air and light on a satellite.
!>
!> Two kinds: the conventional accelerations of CSR-TM-00-01 section 2.3.2, which know one
!> cross-section and one coefficient, and forces and torques plate by plate, which stand in for
!> the report's tables of normalised loads. All directions are in body axes. A torque is about the
!> centre of mass, with each plate's force at its centroid. The body is convex: no plate shades
!> another.
module gracecg_spacecraft_surface_loads
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: PI, SPEED_OF_LIGHT, ASTRONOMICAL_UNIT
    use gracecg_base_lanes, only: LANES, lanes_exponentials, lanes_erfc, total_of
    use gracecg_base_error, only: error_t, fail_out_of_range
    use gracecg_environment_earth_radiation, only: earth_irradiance_t
    use gracecg_spacecraft_plates, only: satellite_surface_t, projected_area
    use gracecg_base_vectors, only: transformed
    implicit none
    private
    public :: drag_acceleration, solar_radiation_acceleration, earth_radiation_acceleration
    public :: earth_flux_acceleration
    public :: gas_t, wall_t, surface_load_t, validate_wall, mean_molar_mass
    public :: aerodynamic_load, solar_radiation_load, earth_radiation_load

    real(dp), parameter :: GAS_CONSTANT = 8.31446261815324_dp
    !! J/(mol K), exact (SI 2019)
    real(dp), parameter :: MOLAR_MASS(3) = [4.002602e-3_dp, 15.999e-3_dp, 28.014e-3_dp]
    !! Helium, atomic oxygen, molecular nitrogen, kg/mol (IUPAC standard atomic weights)

    type :: gas_t
        !! The air around the satellite
        real(dp) :: density         !! kg/m^3
        real(dp) :: temperature     !! K
        real(dp) :: molar_mass      !! Mean, kg/mol; see mean_molar_mass
    end type gas_t

    type :: wall_t
        !! How the air's molecules leave the plates
        real(dp) :: temperature = 300       !! K (assumed)
        real(dp) :: accommodation = 1       !! Energy accommodation coefficient, 0 to 1 (assumed)
    end type wall_t

    !> What acts on the whole surface.
    type :: surface_load_t
        real(dp) :: force(3) = 0          !! Body axes, N
        real(dp) :: torque(3) = 0         !! About the centre of mass, body axes, N m
        real(dp) :: projected_area = 0
        !! That of `projected_area`, of the velocity, m^3/s, or of the direction to the light, m^2
    end type surface_load_t

    !> Light of one direction.
    type :: light_t
        real(dp) :: to_source(3) = 0      !! u, unit vector, body axes
        real(dp) :: pressure = 0          !! P, N/m^2
    end type light_t

contains

    !> Drag, CSR-TM-00-01 eqs. (2-6), (2-7), body axes, m/s^2: v_r A_d(v_r/v_r) = A_d(v_r), that of a vector scales with
    !> its length.
    pure function drag_acceleration(surface, mass, drag_coefficient, density, velocity, area) result(acceleration)
        type(satellite_surface_t), intent(in) :: surface
        real(dp), intent(in) :: mass                !! m_S, kg
        real(dp), intent(in) :: drag_coefficient    !! C_d
        real(dp), intent(in) :: density             !! rho, kg/m^3
        real(dp), intent(in) :: velocity(3)         !! v_r, relative to the air, body axes, m/s
        real(dp), intent(in), optional :: area      !! Projected area of the velocity, where it is known, m^3/s
        real(dp) :: acceleration(3)

        real(dp) :: seen

        if (present(area)) then
            seen = area
        else
            seen = projected_area(surface, velocity)
        end if
        acceleration = -0.5_dp*drag_coefficient*density/mass*seen*velocity
    end function drag_acceleration

    !> Pressure of sunlight, CSR-TM-00-01 eqs. (2-8), (2-9), at the true distance, body axes, m/s^2.
    pure function solar_radiation_acceleration(surface, mass, reflectivity, irradiance_1au, illumination, to_sun, area) &
        result(acceleration)
        type(satellite_surface_t), intent(in) :: surface
        real(dp), intent(in) :: mass                !! m_S, kg
        real(dp), intent(in) :: reflectivity        !! eta
        real(dp), intent(in) :: irradiance_1au      !! Sunlight at 1 au, P c, W/m^2
        real(dp), intent(in) :: illumination        !! Eclipse factor nu, 0 to 1
        real(dp), intent(in) :: to_sun(3)           !! From satellite to Sun, body axes, m
        real(dp), intent(in), optional :: area      !! Projected area towards the Sun, where it is known, m^2
        real(dp) :: acceleration(3)

        type(light_t) :: light
        real(dp) :: seen

        light = sunlight(irradiance_1au, illumination, to_sun)
        if (present(area)) then
            seen = area
        else
            seen = projected_area(surface, light%to_source)
        end if
        acceleration = -light%pressure*(1 + reflectivity)/mass*seen*light%to_source
    end function solar_radiation_acceleration

    !> Pressure of the Earth's light, CSR-TM-00-01 eq. (2-10), body axes, m/s^2. As there, the
    !> satellite has one cross-section A_e for all segments: that of (2-15) towards the Earth's centre.
    !> (`earth_radiation_load` follows each segment's light onto each plate.)
    pure function earth_radiation_acceleration(surface, mass, reflectivity, body_from_inertial, &
                                               vertical, radiation) result(acceleration)
        type(satellite_surface_t), intent(in) :: surface
        real(dp), intent(in) :: mass                        !! m_S, kg
        real(dp), intent(in) :: reflectivity                !! eta_e
        real(dp), intent(in) :: body_from_inertial(3, 3)    !! Rotation matrix, eq. (2-29)
        real(dp), intent(in) :: vertical(3)                 !! Unit vector upwards, body axes
        type(earth_irradiance_t), intent(in) :: radiation   !! At the satellite
        real(dp) :: acceleration(3)

        real(dp) :: flux(3)     ! inertial axes, W/m^2
        integer :: j

        flux = 0
        do j = 1, radiation%count
            flux = flux + radiation%irradiance(j)*radiation%direction(:, j)
        end do
        acceleration = earth_flux_acceleration(surface, mass, reflectivity, body_from_inertial, vertical, flux)
    end function earth_radiation_acceleration

    !> The same, given the sum over the segments: `flux_at` of the Earth's radiation.
    pure function earth_flux_acceleration(surface, mass, reflectivity, body_from_inertial, vertical, flux) result(acceleration)
        type(satellite_surface_t), intent(in) :: surface
        real(dp), intent(in) :: mass                        !! m_S, kg
        real(dp), intent(in) :: reflectivity                !! eta_e
        real(dp), intent(in) :: body_from_inertial(3, 3)    !! Rotation matrix, eq. (2-29)
        real(dp), intent(in) :: vertical(3)                 !! Unit vector upwards, body axes
        real(dp), intent(in) :: flux(3)                     !! Away from the Earth, inertial axes, W/m^2
        real(dp) :: acceleration(3)

        acceleration = (1 + reflectivity)/(mass*SPEED_OF_LIGHT)*projected_area(surface, -vertical)* &
                       transformed(body_from_inertial, flux)
    end function earth_flux_acceleration

    !> Mean molar mass of a mixture of helium, atomic oxygen and molecular nitrogen, kg/mol.
    pure real(dp) function mean_molar_mass(number_density)
        real(dp), intent(in) :: number_density(3)   !! He, O, N2, any unit

        mean_molar_mass = dot_product(MOLAR_MASS, number_density)/sum(number_density)
    end function mean_molar_mass

    !> Fails when a wall's temperature or accommodation coefficient is impossible.
    subroutine validate_wall(wall, error)
        type(wall_t), intent(in) :: wall
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: COLDEST = 0.0_dp, HOTTEST = 3000.0_dp

        if (.not. (wall%temperature >= COLDEST .and. wall%temperature <= HOTTEST)) then
            call fail_out_of_range(error, 'wall temperature', wall%temperature, COLDEST, &
                                   HOTTEST, 'K')
        else if (.not. (wall%accommodation >= 0 .and. wall%accommodation <= 1)) then
            call fail_out_of_range(error, 'accommodation coefficient', wall%accommodation, &
                                   0.0_dp, 1.0_dp)
        end if
    end subroutine validate_wall

    !> The air's force in free-molecular flow, and the torque, eq. (2-24). Force per area, N/m^2, by L. H. Sentman,
    !> Lockheed LMSC-448514, 1961, with diffuse re-emission at a temperature set by the energy accommodation as in
    !> G. Koppenwallner, 2009 (the bulk motion alone counts as incident energy).
    !>
    !> With c = sqrt(2 R T/M), the normal speed ratio w = n.v/c and the incident mass flux
    !> f = rho c/2 [exp(-w^2)/sqrt(pi) + w (1 + erf w)], it is
    !>
    !>     -f v - [rho c^2 (1 + erf w)/4 + sqrt(pi)/2 c_r f] n,
    !>
    !> c_r^2 = (1 - alpha) v^2/2 + 2 alpha R T_w/M being that of the molecules that leave.
    pure function aerodynamic_load(surface, centre_of_mass, gas, wall, velocity) result(load)
        type(satellite_surface_t), intent(in) :: surface
        real(dp), intent(in) :: centre_of_mass(3)   !! In the frame of the plates' centres, m
        type(gas_t), intent(in) :: gas
        type(wall_t), intent(in) :: wall
        real(dp), intent(in) :: velocity(3)         !! v, relative to the air, body axes, m/s
        type(surface_load_t) :: load

        real(dp), parameter :: ROOT_PI = sqrt(PI)
        real(dp), dimension(LANES) :: along_normal, w, bell, one_plus_erf, mass_flux, pressure
        real(dp) :: force(LANES, 3), total(LANES, 7), thermal_speed, leaving_speed      ! c, c_r
        integer :: first, last, i

        thermal_speed = sqrt(2*GAS_CONSTANT*gas%temperature/gas%molar_mass)
        leaving_speed = sqrt((1 - wall%accommodation)*dot_product(velocity, velocity)/2 + &
                             2*wall%accommodation*GAS_CONSTANT*wall%temperature/gas%molar_mass)
        total = 0
        do first = 1, surface%count, LANES
            last = first + LANES - 1
            along_normal = along_normals(surface, first, velocity)
            w = along_normal/thermal_speed
            call lanes_exponentials(-w**2, bell)
            call lanes_erfc(-w, one_plus_erf)
            mass_flux = gas%density*thermal_speed/2*(bell/ROOT_PI + w*one_plus_erf)
            pressure = gas%density*thermal_speed**2/4*one_plus_erf + ROOT_PI/2*leaving_speed*mass_flux
            do i = 1, 3
                force(:, i) = -surface%area(first:last)*(mass_flux*velocity(i) + pressure*surface%normal(first:last, i))
            end do
            call add_forces(surface, first, centre_of_mass, force, surface%area(first:last)*max(0.0_dp, along_normal), total)
        end do
        load = load_of(total)
    end function aerodynamic_load

    !> Force of sunlight, and the torque, eq. (2-24).
    pure function solar_radiation_load(surface, centre_of_mass, irradiance_1au, illumination, to_sun) result(load)
        type(satellite_surface_t), intent(in) :: surface
        real(dp), intent(in) :: centre_of_mass(3)   !! In the frame of the plates' centres, m
        real(dp), intent(in) :: irradiance_1au      !! Sunlight at 1 au, W/m^2
        real(dp), intent(in) :: illumination        !! Eclipse factor nu, 0 to 1
        real(dp), intent(in) :: to_sun(3)           !! From satellite to Sun, body axes, m
        type(surface_load_t) :: load

        load = light_load(surface, centre_of_mass, sunlight(irradiance_1au, illumination, to_sun))
    end function solar_radiation_load

    !> Force of the Earth's reflected and emitted light on each plate, and the torque. The plates'
    !> reflectivities are taken to be the same for sunlight and heat.
    pure function earth_radiation_load(surface, centre_of_mass, body_from_inertial, radiation) &
        result(load)
        type(satellite_surface_t), intent(in) :: surface
        real(dp), intent(in) :: centre_of_mass(3)       !! In the frame of the plates' centres, m
        real(dp), intent(in) :: body_from_inertial(3, 3)    !! Rotation matrix, eq. (2-29)
        type(earth_irradiance_t), intent(in) :: radiation   !! At the satellite
        type(surface_load_t) :: load

        type(surface_load_t) :: part
        integer :: j

        do j = 1, radiation%count
            part = light_load(surface, centre_of_mass, light_t(-transformed(body_from_inertial, radiation%direction(:, j)), &
                                                               radiation%irradiance(j)/SPEED_OF_LIGHT))
            load%force = load%force + part%force
            load%torque = load%torque + part%torque
        end do
    end function earth_radiation_load

    !> Light on plates that mirror (rho_s), scatter after Lambert (rho_d) and absorb:
    !> -P A cos(theta) [(1 - rho_s) u + 2 (rho_s cos(theta) + rho_d/3) n] on each plate
    !> that faces the source (e.g. O. Montenbruck, E. Gill, Satellite Orbits, 2000, section 3.4,
    !> with the diffuse part).
    pure function light_load(surface, centre_of_mass, light) result(load)
        type(satellite_surface_t), intent(in) :: surface
        real(dp), intent(in) :: centre_of_mass(3)   !! In the frame of the plates' centres, m
        type(light_t), intent(in) :: light
        type(surface_load_t) :: load

        real(dp), dimension(LANES) :: cosine, lit_area, thrust, along_light, along_normal
        real(dp) :: force(LANES, 3), total(LANES, 7)
        integer :: first, last, i

        total = 0
        do first = 1, surface%count, LANES
            last = first + LANES - 1
            associate (specular => surface%specular(first:last), diffuse => surface%diffuse(first:last))
                cosine = max(0.0_dp, along_normals(surface, first, light%to_source))
                lit_area = surface%area(first:last)*cosine
                thrust = -light%pressure*lit_area
                along_light = thrust*(1 - specular)
                along_normal = thrust*(2*(specular*cosine + diffuse/3))
            end associate
            do i = 1, 3
                force(:, i) = along_light*light%to_source(i) + along_normal*surface%normal(first:last, i)
            end do
            call add_forces(surface, first, centre_of_mass, force, lit_area, total)
        end do
        load = load_of(total)
    end function light_load

    !> A vector along the normals of LANES plates.
    pure function along_normals(surface, first, vector) result(along)
        type(satellite_surface_t), intent(in) :: surface
        integer, intent(in) :: first            ! Plate
        real(dp), intent(in) :: vector(3)
        real(dp) :: along(LANES)

        associate (n => surface%normal(first:first + LANES - 1, :))
            along = n(:, 1)*vector(1) + n(:, 2)*vector(2) + n(:, 3)*vector(3)
        end associate
    end function along_normals

    !> Adds forces on LANES plates, their torques about the centre of mass and the areas that are seen.
    pure subroutine add_forces(surface, first, centre_of_mass, force, seen, total)
        type(satellite_surface_t), intent(in) :: surface
        integer, intent(in) :: first                ! Plate
        real(dp), intent(in) :: centre_of_mass(3), force(LANES, 3), seen(LANES)
        real(dp), intent(inout) :: total(LANES, 7)  ! By place in surface_load_t

        real(dp) :: arm(LANES, 3)
        integer :: i

        do i = 1, 3
            arm(:, i) = surface%centre(first:first + LANES - 1, i) - centre_of_mass(i)
        end do
        total(:, 1:3) = total(:, 1:3) + force
        total(:, 4) = total(:, 4) + (arm(:, 2)*force(:, 3) - arm(:, 3)*force(:, 2))
        total(:, 5) = total(:, 5) + (arm(:, 3)*force(:, 1) - arm(:, 1)*force(:, 3))
        total(:, 6) = total(:, 6) + (arm(:, 1)*force(:, 2) - arm(:, 2)*force(:, 1))
        total(:, 7) = total(:, 7) + seen
    end subroutine add_forces

    pure function load_of(total) result(load)
        real(dp), intent(in) :: total(LANES, 7)
        type(surface_load_t) :: load

        real(dp) :: sum_of(7)
        integer :: i

        do i = 1, 7
            sum_of(i) = total_of(total(:, i))
        end do
        load = surface_load_t(sum_of(:3), sum_of(4:6), sum_of(7))
    end function load_of

    !> Direction and pressure of sunlight at the satellite.
    pure function sunlight(irradiance_1au, illumination, to_sun) result(light)
        real(dp), intent(in) :: irradiance_1au      ! W/m^2
        real(dp), intent(in) :: illumination        ! Eclipse factor nu, 0 to 1
        real(dp), intent(in) :: to_sun(3)           ! From satellite to Sun, m
        type(light_t) :: light

        real(dp) :: distance

        distance = sqrt(dot_product(to_sun, to_sun))
        light%to_source = to_sun/distance
        light%pressure = illumination*irradiance_1au*(ASTRONOMICAL_UNIT/distance)**2/SPEED_OF_LIGHT
    end function sunlight
end module gracecg_spacecraft_surface_loads
