!> Coupled orbit and attitude of one satellite: the 13 equations of CSR-TM-00-01 eq. (2-31).
!>
!> State: position r (m) and velocity v (m/s) in the inertial frame, angular velocity omega (rad/s) in
!> body axes, attitude quaternion q (inertial to body, scalar last).
module gracecg_simulation_dynamics
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM, HOUR_ANGLE, &
        SECONDS_PER_DAY, DAYS_PER_CENTURY
    use gracecg_base_vectors, only: cross, transformed, transformed_back
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_rate
    use gracecg_base_runge_kutta, only: ode_system_t
    use gracecg_environment_time, only: utc_t
    use gracecg_environment_earth_orientation, only: earth_orientation_t
    use gracecg_environment_earth_shape, only: earth_fixed_to_geodetic
    use gracecg_environment_geopotential, only: gravity_model_t
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    use gracecg_environment_thermosphere, only: density_model_t, density_wave_t, atmosphere_point_t, &
        atmosphere_state_t
    use gracecg_environment_wind, only: wind_model_t
    use gracecg_environment_sun, only: sun_position, conical_shadow
    use gracecg_environment_earth_radiation, only: earth_radiation_t, earth_irradiance_t
    use gracecg_spacecraft_plates, only: satellite_surface_t
    use gracecg_spacecraft_surface_loads, only: drag_acceleration, solar_radiation_acceleration, &
        earth_flux_acceleration, aerodynamic_load, solar_radiation_load, earth_radiation_load, gas_t, wall_t, &
        surface_load_t, mean_molar_mass
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, dipole_moment, torque_of, next_rod_edge
    use gracecg_simulation_attitude_control, only: attitude_control_t
    use gracecg_spacecraft_gravity_gradient_torque, only: gravity_gradient_torque
    implicit none
    private
    public :: satellite_dynamics_t, loads_t, accelerations_t
    public :: STATE_SIZE, POSITION, VELOCITY, OMEGA, ATTITUDE

    !> Components of the state: position (m), velocity (m/s), both inertial; angular velocity (body axes,
    !> rad/s); attitude quaternion (inertial to body, scalar last)
    integer, parameter :: STATE_SIZE = 13
    !> Places of the parts in the state, as index vectors
    integer, parameter :: POSITION(3) = [1, 2, 3], VELOCITY(3) = [4, 5, 6], OMEGA(3) = [7, 8, 9]
    !> Place of the attitude quaternion in the state, as an index vector
    integer, parameter :: ATTITUDE(4) = [10, 11, 12, 13]

    !> One satellite with its models. Every effect can be left out. Its procedures neither change it
    !> nor allocate, so that one object serves any number of threads.
    type, extends(ode_system_t) :: satellite_dynamics_t
        ! when: all constant over an arc
        type(utc_t) :: epoch                        !! t = 0; for the caller, the angles below are used
        type(earth_orientation_t) :: earth          !! In inertial axes
        real(dp) :: local_time_greenwich = 0        !! Mean solar time at Greenwich at t = 0, h
        real(dp) :: day_of_year = 0                 !! At t = 0, with fraction, 1 January 0 h = 0
        real(dp) :: julian_centuries_tt = 0         !! Since J2000, at t = 0
        real(dp) :: earth_radiation_day = 0         !! Days at t = 0 since the epoch of its yearly terms
        ! the models
        class(gravity_model_t), allocatable :: gravity  !! Of the Earth, in the Earth-fixed frame
        class(geomagnetic_model_t), allocatable :: field    !! Of the Earth, for the rods
        class(density_model_t), allocatable :: atmosphere   !! Density and composition of the air
        class(wind_model_t), allocatable :: wind    !! Relative to the rotating Earth
        real(dp) :: density_scale = 1               !! Factor of the model's density
        type(density_wave_t) :: density_wave        !! Relative to the model's density, before the scale
        type(earth_radiation_t) :: earth_radiation  !! Reflected and emitted light of the Earth
        ! the satellite
        real(dp) :: mass = 0                        !! kg
        real(dp) :: inertia(3, 3) = 0               !! J, about the centre of mass, kg m^2
        real(dp) :: inverse_inertia(3, 3) = 0       !! 1/(kg m^2)
        type(torque_rods_t) :: rods                 !! The manoeuvre
        type(attitude_control_t) :: control         !! What rods and thrusters do beside
        type(satellite_surface_t) :: surface        !! The plates
        real(dp) :: centre_of_mass(3) = 0           !! In the frame of the surface's plates, m
        real(dp) :: drag_coefficient = 0            !! C_d of (2-6)
        type(wall_t) :: wall                        !! For the air's force and torque plate by plate
        logical :: forces_by_plates = .false.
        !! Air and light accelerate plate by plate, and not by (2-6), (2-8) and (2-10)
        real(dp) :: reflectivity_sun = 0            !! eta of (2-8)
        real(dp) :: reflectivity_earth = 0          !! eta_e of (2-10)
        real(dp) :: solar_irradiance = 0            !! At 1 au, W/m^2
        ! what acts
        logical :: with_drag = .true.               !! Drag and aerodynamic torque
        logical :: with_solar_radiation = .true.    !! Pressure and torque
        logical :: with_earth_radiation = .true.    !! Pressure
        logical :: with_gravity_gradient = .true.   !! Torque
        logical :: with_rods = .true.               !! Magnetic torque
    contains
        procedure :: rate                   !! dX/dt at a time and state
        procedure :: accelerations          !! Accelerations alone, for an integrator of one's own
        procedure :: loads                  !! Forces and torques at a time and state
        procedure :: rate_under             !! dX/dt under loads that are known
        procedure :: angular_acceleration   !! d omega/dt from the torques
        procedure :: actuate                !! What rods and thrusters do
        procedure :: next_edge              !! When that is another function of time next
    end type satellite_dynamics_t

    !> Accelerations of the centre of mass at one instant, inertial axes, m/s^2.
    type :: accelerations_t
        real(dp) :: gravity(3) = 0          !! Of the Earth
        real(dp) :: drag(3) = 0             !! Of the air
        real(dp) :: solar_radiation(3) = 0  !! By the pressure of sunlight
        real(dp) :: earth_radiation(3) = 0  !! By the pressure of the Earth's light
        real(dp) :: total(3) = 0            !! The sum of the four
    end type accelerations_t

    !> What acts at one instant, in body axes.
    type :: loads_t
        real(dp) :: gravity(3) = 0          !! Acceleration, inertial axes, m/s^2
        real(dp) :: drag(3) = 0             !! Accelerations, m/s^2
        real(dp) :: srp(3) = 0              !! Solar radiation pressure
        real(dp) :: erp(3) = 0              !! Earth radiation pressure
        real(dp) :: torque_aero(3) = 0      !! Torques about the centre of mass, N m
        real(dp) :: torque_solar(3) = 0     !! Of sunlight
        real(dp) :: torque_gravity(3) = 0   !! Of the gravity gradient
        real(dp) :: torque_magnetic(3) = 0  !! Of the rods in the field, or of torquers
        real(dp) :: field(3) = 0            !! Magnetic flux density, T
        real(dp) :: control_moment(3) = 0   !! Of the rods for the attitude, A m^2
        real(dp) :: torque_thrusters(3) = 0 !! N m
        real(dp) :: vertical(3) = 0         !! Unit vector away from the Earth's centre
        real(dp) :: body_from_inertial(3, 3) = 0    !! C: v_body = C v_inertial
    end type loads_t

contains

    !> dX/dt of (2-31): the orbit (2-1), Euler's equations (2-16), the attitude (2-20).
    pure subroutine rate(self, t, y, dydt)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t           !! Since the epoch, s
        real(dp), intent(in) :: y(:)        !! State, STATE_SIZE components
        real(dp), intent(out) :: dydt(:)    !! Its derivative by time, per s

        type(loads_t) :: acting

        call add_loads(self, t, y, .true., acting)
        call self%rate_under(y, acting, dydt)
    end subroutine rate

    !> dX/dt of (2-31) under the loads at a state.
    pure subroutine rate_under(self, y, acting, dydt)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: y(:)            !! State, STATE_SIZE components
        type(loads_t), intent(in) :: acting     !! At this state
        real(dp), intent(out) :: dydt(:)        !! Its derivative by time, per s

        real(dp) :: surface(3), angular_velocity(3), quaternion(4)

        surface = acting%drag + acting%srp + acting%erp
        angular_velocity = y(OMEGA)
        quaternion = y(ATTITUDE)
        dydt(POSITION) = y(VELOCITY)
        dydt(VELOCITY) = acting%gravity + transformed_back(acting%body_from_inertial, surface)
        dydt(OMEGA) = self%angular_acceleration(angular_velocity, acting)
        dydt(ATTITUDE) = quaternion_rate(quaternion, angular_velocity)
    end subroutine rate_under

    !> d omega/dt = J^-1 (T - omega x (J omega)), eq. (2-16), rad/s^2.
    pure function angular_acceleration(self, omega, acting) result(omega_dot)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: omega(3)        !! rad/s
        type(loads_t), intent(in) :: acting
        real(dp) :: omega_dot(3)

        omega_dot = transformed(self%inverse_inertia, acting%torque_aero + acting%torque_solar + &
                                acting%torque_gravity + acting%torque_magnetic + acting%torque_thrusters - &
                                cross(omega, transformed(self%inertia, omega)))
    end function angular_acceleration

    !> The force model for an orbit integrator of one's own: what accelerates the satellite at time t, in
    !> inertial axes. Torques are not computed.
    !>
    !> The state is not checked: see `check_state` in gracecg_simulation_arc. Numbers that are not finite
    !> come out as such.
    pure subroutine accelerations(self, t, position, velocity, quaternion, acting)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t               !! s since the epoch
        real(dp), intent(in) :: position(3)     !! Inertial, m
        real(dp), intent(in) :: velocity(3)     !! Inertial, m/s
        real(dp), intent(in) :: quaternion(4)   !! Inertial to body, scalar last
        type(accelerations_t), intent(out) :: acting

        type(loads_t) :: load

        call add_loads(self, t, [position, velocity, [0.0_dp, 0.0_dp, 0.0_dp], quaternion], .false., load)
        acting%gravity = load%gravity
        acting%drag = matmul(load%drag, load%body_from_inertial)
        acting%solar_radiation = matmul(load%srp, load%body_from_inertial)
        acting%earth_radiation = matmul(load%erp, load%body_from_inertial)
        acting%total = acting%gravity + acting%drag + acting%solar_radiation + acting%earth_radiation
    end subroutine accelerations

    !> Every force and torque at time t and state y.
    pure subroutine loads(self, t, y, acting)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s
        real(dp), intent(in) :: y(:)        !! State
        type(loads_t), intent(out) :: acting

        call add_loads(self, t, y, .true., acting)
    end subroutine loads

    !> Every force and, if wanted, the magnetic field and every torque. Gravity (2-3) and field (2-30) come
    !> from Earth-fixed axes, turned by the sidereal angle (2-4), (2-28), or as the IAU has it.
    pure subroutine add_loads(self, t, y, with_torques, acting)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t               !! s
        real(dp), intent(in) :: y(STATE_SIZE)   !! State
        logical, intent(in) :: with_torques
        type(loads_t), intent(inout) :: acting  !! As by default

        real(dp) :: earth_from_inertial(3, 3), place(3), quaternion(4), fixed_position(3), radius, gravity(3), field(3)

        place = y(POSITION)
        quaternion = y(ATTITUDE)
        earth_from_inertial = self%earth%from_inertial(t)
        fixed_position = transformed(earth_from_inertial, place)
        radius = sqrt(dot_product(place, place))
        acting%body_from_inertial = rotation_matrix(quaternion/sqrt(dot_product(quaternion, quaternion)))
        acting%vertical = transformed(acting%body_from_inertial, place/radius)

        if (allocated(self%gravity)) then
            call self%gravity%acceleration(fixed_position, gravity)
            acting%gravity = transformed_back(earth_from_inertial, gravity)
        end if
        if (with_torques .and. allocated(self%field)) then
            call self%field%evaluate(fixed_position, field)
            acting%field = transformed(acting%body_from_inertial, transformed_back(earth_from_inertial, field))
            if (self%with_rods) call self%actuate(t, y, acting)
        end if
        if (with_torques .and. self%with_gravity_gradient) then
            acting%torque_gravity = gravity_gradient_torque(EARTH_GM, radius, acting%vertical, self%inertia)
        end if
        if (self%with_drag .and. allocated(self%atmosphere)) then
            call air_loads(self, t, y, fixed_position, with_torques, acting)
        end if
        if (self%with_solar_radiation .or. self%with_earth_radiation) then
            call radiation_loads(self, t, y, with_torques, acting)
        end if
    end subroutine add_loads

    !> What rods and thrusters do in the field: the rods' torque is (2-25). Torquers are not there beside a control.
    pure subroutine actuate(self, t, y, acting)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t                   !! s
        real(dp), intent(in) :: y(STATE_SIZE)       !! State
        type(loads_t), intent(inout) :: acting      !! With the field

        if (self%control%acts) &
            call self%control%act(y, self%inertia, acting%field, acting%control_moment, acting%torque_thrusters)
        acting%torque_magnetic = torque_of(self%rods, dipole_moment(self%rods, t) + acting%control_moment, acting%field)
    end subroutine actuate

    !> The first time after t at which a rod's moment begins, ends or has an edge, s; huge(1.0) when there is none.
    pure real(dp) function next_edge(self, t) result(edge)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t           !! s

        edge = huge(edge)
        if (self%with_rods) edge = next_rod_edge(self%rods, t)
    end function next_edge

    !> Drag, by (2-6) or plate by plate, and aerodynamic torque (2-24), with the wind and the density wave.
    pure subroutine air_loads(self, t, y, fixed_position, with_torques, acting)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t, y(STATE_SIZE)
        real(dp), intent(in) :: fixed_position(3)       !! Earth-fixed, m
        logical, intent(in) :: with_torques
        type(loads_t), intent(inout) :: acting

        type(atmosphere_point_t) :: point
        type(atmosphere_state_t) :: air
        type(surface_load_t) :: load
        real(dp) :: longitude, place(3), velocity_in_air(3)

        call earth_fixed_to_geodetic(fixed_position, point%latitude, longitude, point%height)
        point%local_solar_time = self%local_time_greenwich + t/3600 + longitude/HOUR_ANGLE
        point%day_of_year = self%day_of_year + t/SECONDS_PER_DAY
        call self%atmosphere%evaluate(point, air)
        air%density = air%density*(self%density_scale + self%density_wave%relative_change(t))

        place = y(POSITION)
        velocity_in_air = y(VELOCITY) - air_velocity(self, place, point)
        velocity_in_air = transformed(acting%body_from_inertial, velocity_in_air)
        if (.not. (with_torques .or. self%forces_by_plates)) then
            acting%drag = drag_acceleration(self%surface, self%mass, self%drag_coefficient, air%density, velocity_in_air)
            return
        end if
        ! molecular oxygen, below 1 % of the mass above 300 km, is left out of the mean molar mass
        load = aerodynamic_load(self%surface, self%centre_of_mass, &
                                gas_t(air%density, air%temperature, mean_molar_mass([air%n_he, air%n_o, air%n_n2])), &
                                self%wall, velocity_in_air)
        acting%drag = drag_acceleration(self%surface, self%mass, self%drag_coefficient, air%density, velocity_in_air, &
                                        load%projected_area)
        if (self%forces_by_plates) acting%drag = load%force/self%mass
        if (with_torques) acting%torque_aero = load%torque
    end subroutine air_loads

    !> Velocity of the air in inertial axes: it turns with the Earth, and the wind adds to it. North is
    !> taken across the geocentric radius, at most 0.2 deg off the geodetic one.
    pure function air_velocity(self, inertial_position, point) result(velocity)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: inertial_position(3)    !! m
        type(atmosphere_point_t), intent(in) :: point
        real(dp) :: velocity(3)                         !! m/s

        real(dp) :: east(3), north(3), up(3), wind_east, wind_north, from_axis

        if (self%earth%turns_about_z) then
            velocity = self%earth%rate*[-inertial_position(2), inertial_position(1), 0.0_dp]
        else
            velocity = self%earth%rate*cross(self%earth%axis(), inertial_position)
        end if
        if (.not. allocated(self%wind)) return
        call self%wind%evaluate(point%latitude, point%local_solar_time, wind_east, wind_north)
        from_axis = hypot(inertial_position(1), inertial_position(2))
        east = [0.0_dp, 1.0_dp, 0.0_dp]                 ! at a pole, where no direction is east
        if (from_axis > 0) east = [-inertial_position(2), inertial_position(1), 0.0_dp]/from_axis
        up = inertial_position/norm2(inertial_position)
        north = cross(up, east)
        velocity = velocity + wind_east*east + wind_north*north
    end function air_velocity

    !> Solar (2-8) and Earth (2-10) radiation pressure, or both plate by plate, and the torque of sunlight (2-24).
    !> The Earth's light makes no torque, as in the report.
    pure subroutine radiation_loads(self, t, y, with_torques, acting)
        class(satellite_dynamics_t), intent(in) :: self
        real(dp), intent(in) :: t, y(STATE_SIZE)
        logical, intent(in) :: with_torques
        type(loads_t), intent(inout) :: acting

        type(earth_irradiance_t) :: earthlight
        type(surface_load_t) :: load
        real(dp) :: place(3), sun(3), to_sun(3), illumination, day, flux(3)

        place = y(POSITION)
        sun = sun_position(self%julian_centuries_tt + t/(SECONDS_PER_DAY*DAYS_PER_CENTURY))
        if (self%with_solar_radiation) then
            illumination = conical_shadow(place, sun)
            to_sun = transformed(acting%body_from_inertial, sun - place)
            if (with_torques .or. self%forces_by_plates) then
                load = solar_radiation_load(self%surface, self%centre_of_mass, self%solar_irradiance, illumination, to_sun)
                acting%srp = solar_radiation_acceleration(self%surface, self%mass, self%reflectivity_sun, &
                                                          self%solar_irradiance, illumination, to_sun, load%projected_area)
                if (self%forces_by_plates) acting%srp = load%force/self%mass
                if (with_torques) acting%torque_solar = load%torque
            else
                acting%srp = solar_radiation_acceleration(self%surface, self%mass, self%reflectivity_sun, &
                                                          self%solar_irradiance, illumination, to_sun)
            end if
        end if
        if (self%with_earth_radiation) then
            day = self%earth_radiation_day + t/SECONDS_PER_DAY
            if (self%forces_by_plates) then
                call self%earth_radiation%irradiance_at(place, sun, day, earthlight)
                load = earth_radiation_load(self%surface, self%centre_of_mass, acting%body_from_inertial, earthlight)
                acting%erp = load%force/self%mass
            else
                call self%earth_radiation%flux_at(place, sun, day, flux)
                acting%erp = earth_flux_acceleration(self%surface, self%mass, self%reflectivity_earth, &
                                                     acting%body_from_inertial, acting%vertical, flux)
            end if
        end if
    end subroutine radiation_loads
end module gracecg_simulation_dynamics
