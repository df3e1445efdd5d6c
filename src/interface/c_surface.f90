!> The C interface: loads on a satellite's surface. Documented in include/gracecg.h.
module gracecg_interface_c_surface
    use, intrinsic :: iso_c_binding, only: c_double, c_int, c_intptr_t, c_size_t
    use gracecg, only: dp, error_t, plate_t, satellite_surface_t, new_surface, new_trapezoid, &
        projected_area, drag_acceleration, solar_radiation_acceleration, earth_radiation_acceleration, &
        earth_irradiance_t, gas_t, wall_t, validate_wall, surface_load_t, mean_molar_mass, &
        aerodynamic_load, solar_radiation_load, rotation_matrix
    use gracecg_base_error, only: number_text
    use gracecg_base_kinds, only: i8
    use gracecg_spacecraft_plates, only: MAX_PLATES
    use gracecg_interface_handles, only: object_t, acquire, release
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, STATUS_BAD_VALUE, start, raise, pass_on, need, &
        check_count, check_finite, check_result, check_distance, keep_copy, refuse_handle, free_object
    implicit none
    private
    public :: c_surface_trapezoid, c_surface_create, c_surface_free, c_surface_area, c_surface_drag
    public :: c_surface_sunlight, c_surface_earthlight, c_surface_aerodynamic_load
    public :: c_surface_sunlight_load, check_attitude

    type, extends(object_t) :: surface_object_t
        type(satellite_surface_t) :: surface
    end type surface_object_t

    character(*), parameter :: NAME = 'surface'
    real(dp), parameter :: ATTITUDE_TOLERANCE = 1e-2_dp
    !! Of the length of a quaternion, which is normalised: an integrator lets it drift

contains

    !> gracecg_surface_trapezoid
    function c_surface_trapezoid(length, height, width_bottom, width_top, specular, diffuse, handle, &
                                 error) result(status) bind(c, name='gracecg_surface_trapezoid')
        real(c_double), intent(in), value :: length, height, width_bottom, width_top, specular, diffuse
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(satellite_surface_t) :: surface
        type(error_t), allocatable :: failure

        call start(status, error)
        call need(present(handle), NAME, status, error)
        if (present(handle)) handle = 0
        call check_finite([length, height, width_bottom, width_top, specular, diffuse], 6_c_size_t, &
                          'the arguments', status, error)
        if (status /= STATUS_OK) return
        call new_trapezoid(surface, length, height, width_bottom, width_top, specular, diffuse, failure)
        call pass_on(failure, status, error, STATUS_BAD_VALUE)
        if (status == STATUS_OK) call keep_surface(surface, handle, status, error)
    end function c_surface_trapezoid

    !> gracecg_surface_create
    function c_surface_create(n, normal, area, centre, specular, diffuse, handle, error) result(status) &
        bind(c, name='gracecg_surface_create')
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: normal(3, *), area(*), centre(3, *), specular(*), diffuse(*)
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(satellite_surface_t) :: surface
        type(plate_t) :: plates(MAX_PLATES)
        type(error_t), allocatable :: failure
        integer :: i

        call start(status, error)
        call need(present(handle), NAME, status, error)
        if (present(handle)) handle = 0
        call check_count(n, 'n', status, error, MAX_PLATES)
        call need(present(normal), 'normal', status, error)
        call need(present(area), 'area', status, error)
        call need(present(centre), 'centre', status, error)
        call need(present(specular), 'specular', status, error)
        call need(present(diffuse), 'diffuse', status, error)
        if (status /= STATUS_OK) return
        do i = 1, int(n)
            plates(i) = plate_t(normal(:, i), area(i), centre(:, i), specular(i), diffuse(i))
        end do
        call new_surface(surface, plates(:n), failure)
        call pass_on(failure, status, error, STATUS_BAD_VALUE)
        if (status == STATUS_OK) call keep_surface(surface, handle, status, error)
    end function c_surface_create

    subroutine keep_surface(surface, handle, status, error)
        type(satellite_surface_t), intent(in) :: surface
        integer(c_intptr_t), intent(inout) :: handle
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        type(surface_object_t) :: made

        made%surface = surface
        call keep_copy(made, handle, status, error)
    end subroutine keep_surface

    !> gracecg_surface_free
    function c_surface_free(handle, error) result(status) bind(c, name='gracecg_surface_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(surface_object_t) :: mold

        call free_object(handle, NAME, status, error, mold)
    end function c_surface_free

    !> gracecg_surface_area
    function c_surface_area(handle, direction, area, error) result(status) &
        bind(c, name='gracecg_surface_area')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), optional :: direction(3)
        real(c_double), intent(inout), optional :: area
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        real(dp), parameter :: UNIT_TOLERANCE = 1e-6_dp
        class(object_t), pointer :: object

        call start(status, error)
        call need(present(direction), 'direction', status, error)
        call need(present(area), 'area', status, error)
        if (status /= STATUS_OK) return
        if (.not. abs(norm2(direction) - 1) <= UNIT_TOLERANCE) then
            call raise(STATUS_BAD_VALUE, 'direction has to be a unit vector; its length is '// &
                       number_text(norm2(direction)), status, error)
            return
        end if
        call acquire(int(handle, i8), object)
        select type (object)
        type is (surface_object_t)
            area = projected_area(object%surface, direction)
        class default
            call refuse_handle(NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_surface_area

    !> gracecg_surface_drag
    function c_surface_drag(handle, mass, drag_coefficient, density, velocity, acceleration, error) &
        result(status) bind(c, name='gracecg_surface_drag')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), value :: mass, drag_coefficient, density
        real(c_double), intent(in), optional :: velocity(3)
        real(c_double), intent(inout), optional :: acceleration(3)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call need(present(velocity), 'velocity', status, error)
        call need(present(acceleration), 'acceleration', status, error)
        call check_positive(mass, 'mass', status, error)
        call check_not_negative(drag_coefficient, 'drag_coefficient', status, error)
        call check_not_negative(density, 'density', status, error)
        if (status == STATUS_OK) call check_finite(velocity, 3_c_size_t, 'velocity', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (surface_object_t)
            call give(drag_acceleration(object%surface, mass, drag_coefficient, density, velocity), &
                      acceleration, status, error)
        class default
            call refuse_handle(NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_surface_drag

    !> gracecg_surface_sunlight
    function c_surface_sunlight(handle, mass, reflectivity, solar_irradiance, illumination, to_sun, &
                                acceleration, error) result(status) &
        bind(c, name='gracecg_surface_sunlight')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), value :: mass, reflectivity, solar_irradiance, illumination
        real(c_double), intent(in), optional :: to_sun(3)
        real(c_double), intent(inout), optional :: acceleration(3)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call need(present(to_sun), 'to_sun', status, error)
        call need(present(acceleration), 'acceleration', status, error)
        call check_positive(mass, 'mass', status, error)
        call check_not_negative(reflectivity, 'reflectivity', status, error)
        if (status == STATUS_OK) call check_sunlight(solar_irradiance, illumination, to_sun, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (surface_object_t)
            call give(solar_radiation_acceleration(object%surface, mass, reflectivity, solar_irradiance, &
                                                   illumination, to_sun), acceleration, status, error)
        class default
            call refuse_handle(NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_surface_sunlight

    !> gracecg_surface_earthlight. All of the flux comes from one direction, which is what the sum
    !> over segments with a single cross-section amounts to.
    function c_surface_earthlight(handle, mass, reflectivity, flux, position, quaternion, acceleration, &
                                  error) result(status) bind(c, name='gracecg_surface_earthlight')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), value :: mass, reflectivity
        real(c_double), intent(in), optional :: flux(3), position(3), quaternion(4)
        real(c_double), intent(inout), optional :: acceleration(3)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(earth_irradiance_t) :: light
        real(dp) :: body_from_inertial(3, 3), vertical(3)

        call start(status, error)
        call need(present(flux), 'flux', status, error)
        call need(present(position), 'position', status, error)
        call need(present(quaternion), 'quaternion', status, error)
        call need(present(acceleration), 'acceleration', status, error)
        call check_positive(mass, 'mass', status, error)
        call check_not_negative(reflectivity, 'reflectivity', status, error)
        if (status /= STATUS_OK) return
        call check_finite(flux, 3_c_size_t, 'flux', status, error)
        call check_distance(position, 1_c_size_t, status, error)
        call check_attitude(quaternion, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (surface_object_t)
            body_from_inertial = rotation_matrix(quaternion/norm2(quaternion))
            vertical = matmul(body_from_inertial, position/norm2(position))
            light%count = 1
            light%irradiance(1) = 1
            light%direction(:, 1) = flux
            call give(earth_radiation_acceleration(object%surface, mass, reflectivity, body_from_inertial, &
                                                   vertical, light), acceleration, status, error)
        class default
            call refuse_handle(NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_surface_earthlight

    !> gracecg_surface_aerodynamic_load
    function c_surface_aerodynamic_load(handle, centre_of_mass, density, temperature, number_density, &
                                        wall_temperature, accommodation, velocity, force, torque, error) &
        result(status) bind(c, name='gracecg_surface_aerodynamic_load')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), optional :: centre_of_mass(3), number_density(3), velocity(3)
        real(c_double), intent(in), value :: density, temperature, wall_temperature, accommodation
        real(c_double), intent(inout), optional :: force(3), torque(3)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(wall_t) :: wall
        type(error_t), allocatable :: failure

        call start(status, error)
        call need(present(centre_of_mass), 'centre_of_mass', status, error)
        call need(present(number_density), 'number_density', status, error)
        call need(present(velocity), 'velocity', status, error)
        call need(present(force), 'force', status, error)
        call need(present(torque), 'torque', status, error)
        call check_not_negative(density, 'density', status, error)
        call check_positive(temperature, 'temperature', status, error)
        if (status /= STATUS_OK) return
        call check_finite(centre_of_mass, 3_c_size_t, 'centre_of_mass', status, error)
        call check_finite(velocity, 3_c_size_t, 'velocity', status, error)
        call check_finite(number_density, 3_c_size_t, 'number_density', status, error)
        wall = wall_t(wall_temperature, accommodation)
        call validate_wall(wall, failure)
        call pass_on(failure, status, error, STATUS_BAD_VALUE)
        if (status /= STATUS_OK) return
        if (minval(number_density) < 0 .or. .not. maxval(number_density) > 0) then
            call raise(STATUS_BAD_VALUE, 'number_density has to be positive in one component and negative '// &
                       'in none', status, error)
            return
        end if
        call acquire(int(handle, i8), object)
        select type (object)
        type is (surface_object_t)
            call give_load(aerodynamic_load(object%surface, centre_of_mass, &
                                            gas_t(density, temperature, mean_molar_mass(number_density)), &
                                            wall, velocity), force, torque, status, error)
        class default
            call refuse_handle(NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_surface_aerodynamic_load

    !> gracecg_surface_sunlight_load
    function c_surface_sunlight_load(handle, centre_of_mass, solar_irradiance, illumination, to_sun, &
                                     force, torque, error) result(status) &
        bind(c, name='gracecg_surface_sunlight_load')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), optional :: centre_of_mass(3), to_sun(3)
        real(c_double), intent(in), value :: solar_irradiance, illumination
        real(c_double), intent(inout), optional :: force(3), torque(3)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call need(present(centre_of_mass), 'centre_of_mass', status, error)
        call need(present(to_sun), 'to_sun', status, error)
        call need(present(force), 'force', status, error)
        call need(present(torque), 'torque', status, error)
        if (status /= STATUS_OK) return
        call check_finite(centre_of_mass, 3_c_size_t, 'centre_of_mass', status, error)
        call check_sunlight(solar_irradiance, illumination, to_sun, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (surface_object_t)
            call give_load(solar_radiation_load(object%surface, centre_of_mass, solar_irradiance, &
                                                illumination, to_sun), force, torque, status, error)
        class default
            call refuse_handle(NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_surface_sunlight_load

    !> A quaternion of about unit length: it is normalised before use.
    subroutine check_attitude(quaternion, status, error)
        real(dp), intent(in) :: quaternion(4)   !! Inertial to body, scalar last
        integer(c_int), intent(inout) :: status !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        if (status /= STATUS_OK) return
        if (abs(norm2(quaternion) - 1) <= ATTITUDE_TOLERANCE) return
        call raise(STATUS_BAD_VALUE, 'the quaternion has the length '//number_text(norm2(quaternion))// &
                   '; allowed is 1 within '//number_text(ATTITUDE_TOLERANCE), status, error)
    end subroutine check_attitude

    subroutine check_sunlight(solar_irradiance, illumination, to_sun, status, error)
        real(dp), intent(in) :: solar_irradiance, illumination, to_sun(3)
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        call check_not_negative(solar_irradiance, 'solar_irradiance', status, error)
        call check_finite(to_sun, 3_c_size_t, 'to_sun', status, error)
        if (status /= STATUS_OK) return
        if (.not. (illumination >= 0 .and. illumination <= 1)) then
            call raise(STATUS_BAD_VALUE, 'illumination = '//number_text(illumination)// &
                       ' is outside 0 to 1', status, error)
        else if (.not. norm2(to_sun) > 0) then
            call raise(STATUS_BAD_VALUE, 'to_sun is zero', status, error)
        end if
    end subroutine check_sunlight

    subroutine check_positive(value, name, status, error)
        real(dp), intent(in) :: value
        character(*), intent(in) :: name
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        if (status /= STATUS_OK .or. (value > 0 .and. value <= huge(value))) return
        call raise(STATUS_BAD_VALUE, name//' = '//number_text(value)//' has to be positive', status, error)
    end subroutine check_positive

    subroutine check_not_negative(value, name, status, error)
        real(dp), intent(in) :: value
        character(*), intent(in) :: name
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        if (status /= STATUS_OK .or. (value >= 0 .and. value <= huge(value))) return
        call raise(STATUS_BAD_VALUE, name//' = '//number_text(value)//' must not be negative', status, error)
    end subroutine check_not_negative

    !> Gives a vector out if it is finite.
    subroutine give(vector, place, status, error)
        real(dp), intent(in) :: vector(3)
        real(dp), intent(inout) :: place(3)
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        call check_result(vector, 'the load', status, error)
        if (status == STATUS_OK) place = vector
    end subroutine give

    subroutine give_load(load, force, torque, status, error)
        type(surface_load_t), intent(in) :: load
        real(dp), intent(inout) :: force(3), torque(3)
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        call check_result([load%force, load%torque], 'the load', status, error)
        if (status /= STATUS_OK) return
        force = load%force
        torque = load%torque
    end subroutine give_load
end module gracecg_interface_c_surface
