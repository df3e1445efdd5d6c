!> The models of the environment by name: list, factory and case file agree, and a model of one's own
!> needs nothing but its own file.
module test_models
    use vocabulary
    use calibrations
    use gracecg_base_constants, only: EARTH_RADIUS_EGM96
    use gracecg_environment_time, only: utc_t, parse_utc
    use gracecg_environment_geopotential, only: gravity_model_t, geopotential_t, new_geopotential
    use gracecg_environment_gravity_models, only: new_gravity_model, GRAVITY_MODELS
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model, GEOMAGNETIC_MODELS
    use gracecg_environment_space_weather, only: space_weather_source_t
    use gracecg_environment_thermosphere, only: density_model_t
    use gracecg_environment_density_models, only: new_density_model, density_settings_t, DENSITY_MODELS
    use gracecg_environment_wind, only: wind_model_t
    use gracecg_environment_wind_models, only: new_wind_model, WIND_MODELS
    use gracecg_simulation_case, only: case_from_text, case_text
    use gracecg_simulation_case_models, only: build_dynamics
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, accelerations_t
    implicit none
    private
    public :: collect_models

    !> U = mu/r - mu R^2 J2 (3 sin^2(latitude) - 1)/(2 r^3): the example of docs/development.md.
    type, extends(gravity_model_t) :: j2_gravity_t
        real(dp) :: mu = EARTH_GM                   !! m^3/s^2
        real(dp) :: radius = EARTH_RADIUS_EGM96     !! R, m
        real(dp) :: j2 = 1.0826267e-3_dp            !! Of EGM96
    contains
        procedure :: acceleration => j2_acceleration
        procedure :: potential => j2_potential
        procedure :: gradient_tensor => j2_gradient_tensor
    end type j2_gravity_t

contains

    subroutine collect_models(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('every-name-gives-its-model', test_names), &
                    new_unittest('other-names-are-refused', test_unknown), &
                    new_unittest('space-weather-by-its-source', test_space_weather), &
                    new_unittest('a-case-takes-every-name', test_case_names), &
                    new_unittest('a-model-of-ones-own', test_own_model)]
    end subroutine collect_models

    subroutine test_names(error)
        type(error_type), allocatable, intent(out) :: error
        class(gravity_model_t), allocatable :: gravity
        class(geomagnetic_model_t), allocatable :: field
        class(density_model_t), allocatable :: density
        class(wind_model_t), allocatable :: wind
        type(error_t), allocatable :: failure
        integer :: i

        do i = 1, size(GRAVITY_MODELS)
            call new_gravity_model(trim(GRAVITY_MODELS(i)), 4, 4, '', gravity, failure)
            call check(error, allocated(gravity), trim(GRAVITY_MODELS(i))//message_of(failure))
        end do
        do i = 1, size(GEOMAGNETIC_MODELS)
            call new_geomagnetic_model(trim(GEOMAGNETIC_MODELS(i)), 1989.0_dp, '', field, failure)
            call check(error, allocated(field), trim(GEOMAGNETIC_MODELS(i))//message_of(failure))
        end do
        do i = 1, size(DENSITY_MODELS)
            call new_density_model(trim(DENSITY_MODELS(i)), epoch(), density_settings_t(), density, failure)
            call check(error, allocated(density), trim(DENSITY_MODELS(i))//message_of(failure))
        end do
        do i = 1, size(WIND_MODELS)
            call new_wind_model(trim(WIND_MODELS(i)), 1.0_dp, 2.0_dp, '', wind, failure)
            call check(error, allocated(wind), trim(WIND_MODELS(i))//message_of(failure))
        end do
    end subroutine test_names

    function epoch()
        type(utc_t) :: epoch
        type(error_t), allocatable :: failure

        call parse_utc('1989-01-02T00:00:00', epoch, failure)
    end function epoch

    !> The message has the name, the names there are, and the nearest; nothing is made.
    subroutine test_unknown(error)
        type(error_type), allocatable, intent(out) :: error
        class(gravity_model_t), allocatable :: gravity
        class(geomagnetic_model_t), allocatable :: field
        class(density_model_t), allocatable :: density
        class(wind_model_t), allocatable :: wind
        type(error_t), allocatable :: failure

        call new_gravity_model('egm69', 4, 4, '', gravity, failure)
        call check_fails(error, failure, 'gravity model ... "egm69" ... egm96, point-mass, file ... did you mean "egm96"')
        call new_geomagnetic_model('igrf15', 1989.0_dp, '', field, failure)
        call check_fails(error, failure, 'geomagnetic field ... "igrf15" ... igrf95, igrf14, file ... did you mean "igrf')
        call new_density_model('dtm7', epoch(), density_settings_t(), density, failure)
        call check_fails(error, failure, &
                         'density model ... "dtm7" ... dtm77, dtm78, dtm94, exponential ... did you mean "dtm77"')
        call new_wind_model('hwm39', 0.0_dp, 0.0_dp, '', wind, failure)
        call check_fails(error, failure, 'wind model ... "hwm39" ... hwm93, hwm93-smooth, constant, file ... did you mean "hwm93"')
        if (unmet(error, .not. (allocated(gravity) .or. allocated(field) .or. allocated(density) .or. &
                                allocated(wind)))) return
        call new_gravity_model('file', 4, 4, 'missing.gfc', gravity, failure)
        call check_fails(error, failure, 'missing.gfc ... no such file')
        call new_geomagnetic_model('igrf95', 2020.0_dp, '', field, failure)
        call check_fails(error, failure, 'igrf95 ... 1985 to 2000')
    end subroutine test_unknown

    !> Given indices need no date; the embedded table knows the report's; others are refused.
    subroutine test_space_weather(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: given(3), table(3)
        type(error_t), allocatable :: failure

        call indices(space_weather_source_t('given', 80.0_dp, 90.0_dp, 3.0_dp), given)
        call check_passes(error, failure)
        call check(error, maxval(abs(given - [80, 90, 3])), 0.0_dp)
        call indices(space_weather_source_t(), table)
        call check_passes(error, failure)
        call check(error, all(table(:2) > 150) .and. table(3) >= 0)
        call indices(space_weather_source_t('file', file='missing.txt'), table)
        call check_fails(error, failure, 'missing.txt')
        call indices(space_weather_source_t('tabel'), table)
        call check_fails(error, failure, '"tabel" ... table, given, file')

    contains

        subroutine indices(source, values)
            type(space_weather_source_t), intent(in) :: source
            real(dp), intent(out) :: values(3)

            call source%indices_at(epoch(), values(1), values(2), values(3), failure)
        end subroutine indices
    end subroutine test_space_weather

    !> Every name of a list is a value of the case file, and the case's models can be built.
    subroutine test_case_names(error)
        type(error_type), allocatable, intent(out) :: error

        call check_names('gravity = ''', GRAVITY_MODELS)
        call check_names('magnetic_field = ''', GEOMAGNETIC_MODELS)
        call check_names('density = ''', DENSITY_MODELS)
        call check_names('wind = ''', WIND_MODELS)

    contains

        subroutine check_names(key, names)
            character(*), intent(in) :: key, names(:)   !! Up to the value's first quote
            type(case_t) :: case
            type(satellite_dynamics_t) :: dynamics
            type(error_t), allocatable :: failure
            character(:), allocatable :: text
            integer :: i, first, last

            do i = 1, size(names)
                call take_case('front-1', case)
                call case_text(case, text, failure)
                if (failed(error, failure)) return
                first = index(text, ' '//key) + len(key)
                last = first + index(text(first + 1:), '''')
                text = text(:first)//trim(names(i))//text(last:)
                call case_from_text(text, 'text', case, failure)
                if (.not. allocated(failure)) call build_dynamics(case, dynamics, failure)
                call check_passes(error, failure)
            end do
        end subroutine check_names
    end subroutine test_case_names

    !> J2 alone, written here, is the geopotential of the same one coefficient, and serves a
    !> satellite's equations of motion in place of a model of the library.
    subroutine test_own_model(error)
        type(error_type), allocatable, intent(out) :: error
        type(j2_gravity_t) :: j2
        type(geopotential_t) :: harmonics
        type(satellite_dynamics_t) :: dynamics
        type(accelerations_t) :: acting(2)
        type(case_t) :: case
        type(error_t), allocatable :: failure
        real(dp) :: c(0:2, 0:0), a(3), b(3), u(2), tensor(3, 3), tensor_b(3, 3)
        real(dp), parameter :: PLACE(3) = [-2014520.5_dp, 3411000.25_dp, 5502211.75_dp]

        c(:, 0) = [1.0_dp, 0.0_dp, -j2%j2/sqrt(5.0_dp)]
        call new_geopotential('J2', j2%mu, j2%radius, c, 0*c, 2, 0, harmonics, failure)
        if (failed(error, failure)) return
        call j2%acceleration(PLACE, a)
        call harmonics%acceleration(PLACE, b)
        call check(error, norm2(a - b)/norm2(b), 0.0_dp, thr=1e-14_dp)
        call j2%potential(PLACE, u(1))
        call harmonics%potential(PLACE, u(2))
        call check(error, u(1)/u(2), 1.0_dp, thr=1e-14_dp)
        call j2%gradient_tensor(PLACE, tensor)
        call harmonics%gradient_tensor(PLACE, tensor_b)
        call check(error, maxval(abs(tensor - tensor_b))/maxval(abs(tensor_b)), 0.0_dp, thr=1e-13_dp)

        call take_case('front-1', case)
        call make_dynamics(case, dynamics)
        call dynamics%accelerations(0.0_dp, case%position, case%velocity, case%quaternion, acting(1))
        deallocate (dynamics%gravity)
        allocate (dynamics%gravity, source=j2)
        call dynamics%accelerations(0.0_dp, case%position, case%velocity, case%quaternion, acting(2))
        call check(error, norm2(acting(2)%gravity - acting(1)%gravity)/norm2(acting(1)%gravity), 0.0_dp, &
                   thr=3e-5_dp)
    end subroutine test_own_model

    pure subroutine j2_acceleration(self, position, a)
        class(j2_gravity_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: a(3)
        real(dp) :: r, factor, sine_squared

        r = norm2(position)
        sine_squared = (position(3)/r)**2
        factor = 1.5_dp*self%j2*(self%radius/r)**2
        a = -self%mu/r**3*position*(1 + factor*([1, 1, 3] - 5*sine_squared))
    end subroutine j2_acceleration

    pure subroutine j2_potential(self, position, u)
        class(j2_gravity_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: u
        real(dp) :: r

        r = norm2(position)
        u = self%mu/r*(1 - self%j2*(self%radius/r)**2*(3*(position(3)/r)**2 - 1)/2)
    end subroutine j2_potential

    !> Of the acceleration above by the chain rule.
    pure subroutine j2_gradient_tensor(self, position, tensor)
        class(j2_gravity_t), intent(in) :: self
        real(dp), intent(in) :: position(3)
        real(dp), intent(out) :: tensor(3, 3)
        real(dp) :: r, u(3), pole(3), unit(3, 3), k
        integer :: i, j

        r = norm2(position)
        u = position/r
        unit = identity(3)
        pole = unit(:, 3)
        k = 1.5_dp*self%j2*(self%radius/r)**2
        do j = 1, 3
            do i = 1, 3
                tensor(i, j) = 3*u(i)*u(j) - unit(i, j) - &
                    k*((1 - 5*u(3)**2)*unit(i, j) + (35*u(3)**2 - 5)*u(i)*u(j) - &
                       10*u(3)*(u(i)*pole(j) + pole(i)*u(j)) + 2*pole(i)*pole(j))
            end do
        end do
        tensor = self%mu/r**3*tensor
    end subroutine j2_gradient_tensor
end module test_models
