!> The C interface: loads on a satellite's surface. Documented in include/gracecg.h.
module gracecg_interface_surface
    use gracecg, only: dp, error_t, plate_t, satellite_surface_t, new_surface, earth_radiation_acceleration, earth_irradiance_t, &
        gas_t, wall_t, validate_wall, surface_load_t, mean_molar_mass, aerodynamic_load, solar_radiation_load, rotation_matrix
    use gracecg_interface_handles, only: object_t
    use gracecg_interface_outcome, only: outcome_t, STATUS_BAD_VALUE
    implicit none
    private
    public :: surface_object_t, surface_plates
    public :: surface_earthlight, surface_aerodynamic_load, surface_sunlight_load

    !> A surface behind a handle.
    type, extends(object_t) :: surface_object_t
        type(satellite_surface_t) :: plates     !! The body
    end type surface_object_t

contains

    !> A closed convex body of n plates: outward unit normals [n][3], areas [n] (m^2), centres [n][3] (m, from any origin),
    !> specular and diffuse reflectivities [n]; body axes.
    subroutine surface_plates(n, normal, area, centre, specular, diffuse, made, outcome)
        integer, intent(in) :: n                                        !! Plates
        real(dp), intent(in) :: normal(3, n), area(n), centre(3, n)     !! Outward unit vectors; m^2; m
        real(dp), intent(in) :: specular(n), diffuse(n)                 !! Reflected parts of the light
        type(surface_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure
        integer :: i

        call new_surface(made%plates, [(plate_t(normal(:, i), area(i), centre(:, i), specular(i), diffuse(i)), i=1, n)], failure)
        call outcome%take(failure, STATUS_BAD_VALUE)
    end subroutine surface_plates

    !> The Earth's light (m/s^2, body axes) with one reflectivity and the cross-section towards the Earth: all of the flux
    !> comes from one direction, which is what the sum over segments with a single cross-section amounts to.
    subroutine surface_earthlight(surface, mass, reflectivity, flux, position, quaternion, acceleration, outcome)
        class(surface_object_t), intent(in) :: surface
        real(dp), intent(in) :: mass, reflectivity          !! kg
        real(dp), intent(in) :: flux(3), position(3)        !! Inertial, W/m^2; m
        real(dp), intent(in) :: quaternion(4)               !! Inertial to body, scalar last
        real(dp), intent(inout) :: acceleration(3)          !! Body axes, m/s^2
        type(outcome_t), intent(inout) :: outcome

        type(earth_irradiance_t) :: light
        real(dp) :: body_from_inertial(3, 3), vertical(3)

        body_from_inertial = rotation_matrix(quaternion/norm2(quaternion))
        vertical = matmul(body_from_inertial, position/norm2(position))
        light%count = 1
        light%irradiance(1) = 1
        light%direction(:, 1) = flux
        acceleration = earth_radiation_acceleration(surface%plates, mass, reflectivity, body_from_inertial, vertical, light)
    end subroutine surface_earthlight

    !> Air in free-molecular flow, plate by plate: force (N) and torque (N m) about the centre of mass.
    subroutine surface_aerodynamic_load(surface, centre_of_mass, density, temperature, number_density, wall_temperature, &
                                        accommodation, velocity, force, torque, outcome)
        class(surface_object_t), intent(in) :: surface
        real(dp), intent(in) :: centre_of_mass(3)                   !! In the frame of the plates' centres, m
        real(dp), intent(in) :: density, temperature                !! kg/m^3, K
        real(dp), intent(in) :: number_density(3)                   !! He, O, N2, any unit
        real(dp), intent(in) :: wall_temperature, accommodation     !! K; 0 to 1
        real(dp), intent(in) :: velocity(3)                         !! Relative to the air, body axes, m/s
        real(dp), intent(inout) :: force(3), torque(3)              !! Body axes, N, N m
        type(outcome_t), intent(inout) :: outcome

        type(surface_load_t) :: load
        type(wall_t) :: wall
        type(error_t), allocatable :: failure

        wall = wall_t(wall_temperature, accommodation)
        call validate_wall(wall, failure)
        call outcome%take(failure, STATUS_BAD_VALUE)
        if (minval(number_density) < 0 .or. .not. maxval(number_density) > 0) &
            call outcome%refuse(STATUS_BAD_VALUE, 'number_density has to be positive in one component and negative in none')
        if (.not. outcome%good()) return
        load = aerodynamic_load(surface%plates, centre_of_mass, gas_t(density, temperature, mean_molar_mass(number_density)), &
                                wall, velocity)
        force = load%force
        torque = load%torque
    end subroutine surface_aerodynamic_load

    !> Sunlight, plate by plate: force (N) and torque (N m) about the centre of mass, body axes.
    subroutine surface_sunlight_load(surface, centre_of_mass, solar_irradiance, illumination, to_sun, force, torque, outcome)
        class(surface_object_t), intent(in) :: surface
        real(dp), intent(in) :: centre_of_mass(3)                   !! In the frame of the plates' centres, m
        real(dp), intent(in) :: solar_irradiance, illumination      !! At 1 au, W/m^2; 0 to 1
        real(dp), intent(in) :: to_sun(3)                           !! Body axes, m
        real(dp), intent(inout) :: force(3), torque(3)              !! Body axes, N, N m
        type(outcome_t), intent(inout) :: outcome

        type(surface_load_t) :: load

        load = solar_radiation_load(surface%plates, centre_of_mass, solar_irradiance, illumination, to_sun)
        force = load%force
        torque = load%torque
    end subroutine surface_sunlight_load

end module gracecg_interface_surface
