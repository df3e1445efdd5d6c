!> The nominal flight of a case over one revolution, or several: its orbit, with the attitude that is
!> held outside of a calibration.
!>
!> The nominal attitude is the case's initial one, turned on at the constant initial angular velocity.
!> So CSR-TM-00-01 has it: its cases 2 and 3 are case 1 turned about body y by omega_y t.
module gracecg_planning_nominal_orbit
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: SECONDS_PER_DAY, TWO_PI
    use gracecg_base_error, only: error_t, fail, add_context, require_range
    use gracecg_base_quaternion, only: quaternion_product, quaternion_from_axis_angle
    use gracecg_environment_earth_shape, only: earth_fixed_to_geodetic
    use gracecg_base_runge_kutta, only: ode_system_t, rkf78_step, controlled_steps_t, begin_steps
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, accelerations_t, STATE_SIZE, POSITION, &
        VELOCITY, OMEGA, ATTITUDE
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_case_models, only: build_dynamics
    implicit none
    private
    public :: nominal_orbit_t, new_nominal_orbit, refuse_unplannable, states_from, last_time, ORBIT_INTERVAL, MOST_REVOLUTIONS

    real(dp), parameter :: ORBIT_INTERVAL = 1.0_dp      !! Between the samples of the orbit, s
    integer, parameter :: MOST_REVOLUTIONS = 150        !! That it covers

    !> Tolerance of the step control, and the size of each component
    real(dp), parameter :: TOLERANCE = 1e-11_dp, SCALES(6) = [1e7_dp, 1e7_dp, 1e7_dp, 1e4_dp, 1e4_dp, 1e4_dp]

    !> The first six of the 13 equations of motion, with the attitude prescribed.
    type, extends(ode_system_t) :: orbital_motion_t
        type(satellite_dynamics_t) :: dynamics
        real(dp) :: quaternion(4) = 0               !! At t = 0
        real(dp) :: angular_velocity(3) = 0         !! Constant, body axes, rad/s
    contains
        procedure :: rate => orbital_rate
        procedure :: full_state
    end type orbital_motion_t

    !> The flight of a case from its epoch, over one revolution or several.
    type :: nominal_orbit_t
        type(satellite_dynamics_t) :: dynamics      !! All models of the case
        real(dp) :: revolution = 0                  !! Duration of one revolution, s
        real(dp) :: interval = ORBIT_INTERVAL       !! Between the samples, s
        integer :: revolutions = 1                  !! That the samples cover
        real(dp), allocatable :: state(:, :)
        !! (13, 0:n), every interval from the case's epoch; see gracecg_simulation_dynamics
        type(orbital_motion_t), private :: motion
    contains
        procedure :: geodetic_place !! Latitude, longitude and height of a sample
    end type nominal_orbit_t

contains

    !> Fails for a case that no plan is for: with several accelerometers, whose scale factors no plan takes into account, or with
    !> an attitude that does not turn at least once a day.
    subroutine refuse_unplannable(case, error)
        type(case_t), intent(in) :: case
        type(error_t), allocatable, intent(out) :: error

        if (case%satellite%line%number > 1) then
            call fail(error, 'several accelerometers: manoeuvres are planned for one; give number = 1 in &accelerometers, '// &
                      'then gracecg bound with all of them')
        else if (.not. norm2(case%angular_velocity) > TWO_PI/SECONDS_PER_DAY) then
            call fail(error, 'angular_velocity: the nominal attitude has to turn with the orbit, at least once a day')
        end if
    end subroutine refuse_unplannable

    !> Propagates the orbit of a case with its gravity and surface forces.
    !>
    !> Fails for less than one revolution or more than MOST_REVOLUTIONS, as refuse_unplannable, when the models of the case cannot
    !> be built, or when the orbit does not stay finite.
    subroutine new_nominal_orbit(case, orbit, error, revolutions, interval)
        type(case_t), intent(in) :: case
        type(nominal_orbit_t), intent(out) :: orbit
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: revolutions    !! One when absent
        real(dp), intent(in), optional :: interval
        !! Between the samples, s: ORBIT_INTERVAL when absent. 10 s are still exact to 1e-5 m

        type(orbital_motion_t) :: motion
        type(controlled_steps_t) :: flight
        integer :: k, steps

        call refuse_unplannable(case, error)
        if (.not. allocated(error)) call build_dynamics(case, motion%dynamics, error)
        if (present(revolutions)) orbit%revolutions = revolutions
        call require_range('revolutions', real(orbit%revolutions, dp), real([1, MOST_REVOLUTIONS], dp), '', error)
        call add_context(error, 'orbit of case '//trim(case%name))
        if (allocated(error)) return
        motion%quaternion = case%quaternion
        motion%angular_velocity = case%angular_velocity

        orbit%dynamics = motion%dynamics
        orbit%motion = motion
        orbit%revolution = TWO_PI/norm2(case%angular_velocity)
        if (present(interval)) orbit%interval = interval
        steps = ceiling(orbit%revolutions*orbit%revolution/orbit%interval)
        allocate (orbit%state(STATE_SIZE, 0:steps))
        orbit%state(:, 0) = motion%full_state(0.0_dp, [case%position, case%velocity])
        call begin_steps(0.0_dp, [case%position, case%velocity], TOLERANCE, SCALES, orbit%interval, flight)
        do k = 1, steps
            do while (flight%to < k*orbit%interval)
                call flight%advance(motion, steps*orbit%interval, error)
                if (allocated(error)) then
                    call add_context(error, 'orbit of case '//trim(case%name))
                    return
                end if
            end do
            orbit%state(:, k) = motion%full_state(k*orbit%interval, flight%state_at(k*orbit%interval))
        end do
        if (.not. all(abs(orbit%state) <= huge(1.0_dp))) then
            call fail(error, 'orbit of case '//trim(case%name)//': it does not stay finite')
        end if
    end subroutine new_nominal_orbit

    !> Where the satellite stands at sample k.
    pure subroutine geodetic_place(self, k, latitude, longitude)
        class(nominal_orbit_t), intent(in) :: self
        integer, intent(in) :: k                !! Number of the sample, from 0
        real(dp), intent(out) :: latitude       !! rad
        real(dp), intent(out) :: longitude      !! Positive east, rad

        real(dp) :: height

        call earth_fixed_to_geodetic(matmul(self%dynamics%earth%from_inertial(k*self%interval), self%state(POSITION, k)), &
                                     latitude, longitude, height)
    end subroutine geodetic_place

    !> The states at `time` and at every `step` after it, with the attitude held; body and inertial
    !> axes as in `state`.
    pure function states_from(self, time, step, steps) result(state)
        type(nominal_orbit_t), intent(in) :: self
        real(dp), intent(in) :: time            !! From 0 to last_time(), s
        real(dp), intent(in) :: step            !! s, at most 10 or so
        integer, intent(in) :: steps    !! Number of steps
        real(dp) :: state(STATE_SIZE, 0:steps)

        real(dp) :: orbital(6), next(6), remainder
        integer :: k

        k = max(0, min(ubound(self%state, 2), floor(time/self%interval + 1e-9_dp)))
        orbital = self%state([POSITION, VELOCITY], k)
        remainder = time - k*self%interval
        if (abs(remainder) > 1e-9_dp) then
            call rkf78_step(self%motion, k*self%interval, orbital, remainder, next)
            orbital = next
        end if
        state(:, 0) = self%motion%full_state(time, orbital)
        do k = 1, steps
            call rkf78_step(self%motion, time + (k - 1)*step, orbital, step, next)
            orbital = next
            state(:, k) = self%motion%full_state(time + k*step, orbital)
        end do
    end function states_from

    !> The end of the revolutions that the samples cover, s from the epoch.
    pure real(dp) function last_time(self)
        type(nominal_orbit_t), intent(in) :: self

        last_time = self%revolutions*self%revolution
    end function last_time

    !> Position and velocity of (2-31).
    pure subroutine orbital_rate(self, t, y, dydt)
        class(orbital_motion_t), intent(in) :: self
        real(dp), intent(in) :: t
        real(dp), intent(in) :: y(:)            !! 6
        real(dp), intent(out) :: dydt(:)

        type(accelerations_t) :: acting
        real(dp) :: state(STATE_SIZE)

        state = self%full_state(t, y)
        call self%dynamics%accelerations(t, state(POSITION), state(VELOCITY), state(ATTITUDE), acting)
        dydt = [state(VELOCITY), acting%total]
    end subroutine orbital_rate

    !> The 13 components of the state: the orbit's six with the nominal attitude.
    pure function full_state(self, t, y) result(state)
        class(orbital_motion_t), intent(in) :: self
        real(dp), intent(in) :: t               !! s
        real(dp), intent(in) :: y(:)            !! Position and velocity
        real(dp) :: state(STATE_SIZE)

        associate (speed => norm2(self%angular_velocity))
            state([POSITION, VELOCITY]) = y
            state(OMEGA) = self%angular_velocity
            state(ATTITUDE) = quaternion_product(quaternion_from_axis_angle( &
                                                 self%angular_velocity/speed, speed*t), self%quaternion)
        end associate
    end function full_state
end module gracecg_planning_nominal_orbit
