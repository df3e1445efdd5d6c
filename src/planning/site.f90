!> A calibration that starts at one place of the nominal orbit, and what a manoeuvre achieves there: the
!> theoretical limit of the CG offset's standard deviation, the errors that drag and radiation add where
!> they are not a straight line in time, and the motion of the attitude.
!>
!> Nothing is simulated: field, gravity gradient and forces along the nominal flight are tabulated once for
!> a place; a manoeuvre then costs one integration of the rotation and one pass of the whitening filter.
module gracecg_planning_site
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM, TWO_PI
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_base_quaternion, only: quaternion_product, quaternion_from_axis_angle
    use gracecg_environment_sun, only: edge_of_shadow
    use gracecg_environment_time, only: utc_plus, julian_centuries_tt
    use gracecg_environment_earth_shape, only: earth_fixed_to_geodetic
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, dipole_moments
    use gracecg_spacecraft_gravity_gradient_torque, only: gravity_gradient_torque
    use gracecg_simulation_dynamics, only: loads_t, STATE_SIZE, POSITION, VELOCITY, RATE => OMEGA, ATTITUDE
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_offset_model, only: offset_matrix
    use gracecg_estimation_noise_whitening, only: whitener_t, accelerometer_whiteners, weigh_series
    use gracecg_estimation_offset_information, only: gather_information
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_operator_view, only: operator_knowledge
    use gracecg_simulation_limits, only: attitude_motion_t, exceeds_limits
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, states_from, last_time
    use gracecg_planning_offset_bound, only: invert_information
    implicit none
    private
    public :: planned_arc_t, new_planned_arc, thin_arc
    public :: manoeuvre_site_t, new_manoeuvre_site, thin_site, fly_manoeuvre
    public :: manoeuvre_quality_t, evaluate_manoeuvre, evaluate_moments, fly_moments

    real(dp), parameter :: ORBIT_STEP = 5           !! Longest, of the integration of the orbit, s
    integer, parameter :: LOADS_PER_STEP = 5        !! Where field and forces are evaluated

    !> An arc to be planned, wherever it starts: its samples, the accelerometer's noise and the density wave.
    type :: planned_arc_t
        type(operator_knowledge_t) :: knowledge          !! What the operator knows
        integer :: samples = 0                      !! n, at k h for k = 1..n
        real(dp) :: interval = 0                    !! h, s
        type(whitener_t) :: whiteners(3)    !! Of accelerometer x, y, z
        real(dp) :: wave_amplitude = 0              !! Of the density wave, relative to the drag
        real(dp) :: wave_period = 0                 !! s
        real(dp), allocatable :: weighed_wave(:, :, :)
        !! Sine and cosine of the wave, weighed with the inverse covariance of the noise and freed of bias and
        !! drift: (2, n, axis), s^4/m^2
    contains
        procedure :: duration => duration_of_samples    !! s
    end type planned_arc_t

    !> One place of the nominal orbit.
    type :: manoeuvre_site_t
        real(dp) :: time = 0                        !! s from the epoch of the orbit
        real(dp) :: latitude = 0                    !! Geodetic, rad
        real(dp) :: longitude = 0                   !! Positive east, rad
        real(dp) :: state(STATE_SIZE) = 0           !! At the start
        real(dp) :: torque(3) = 0                   !! Of the gravity gradient at the start, body axes, N m
        logical :: at_edge = .false.                !! It passes the edge of the Earth's shadow, where the forces change
        real(dp) :: drag(3) = 0                     !! At the start, body axes, m/s^2
        real(dp), allocatable :: field(:, :)
        !! At every half sampling interval, nominal body axes, (3, 0:2n), T
        real(dp) :: force_slope(3, 3, 2) = 0
        !! Change of the non-gravitational acceleration by a turn about each axis (second index), by a
        !! positive and a negative one (third), body axes, m/s^2 per rad
        real(dp), allocatable :: force(:, :)
        !! Non-gravitational acceleration along the nominal flight, body axes: (3, 0:n), m/s^2
        real(dp), allocatable :: weighed_force(:, :)
        !! The same, weighed likewise: (3, n), s^2/m
    end type manoeuvre_site_t

    !> How good a manoeuvre is at a place.
    type :: manoeuvre_quality_t
        real(dp) :: covariance(3, 3) = 0            !! The limit: inverse of the information, m^2
        real(dp) :: sigma(3) = 0                    !! Its standard deviations, body axes, m
        real(dp) :: wave(3) = 0                     !! RMS error by the density wave, m
        real(dp) :: force(3) = 0
        !! Error by drag and radiation that are not a straight line in time, m: along the nominal flight, and
        !! because the manoeuvre turns the surface in the flow
        type(attitude_motion_t) :: motion           !! Of the manoeuvre
    contains
        procedure :: is_seen        !! Does the manoeuvre show all directions of the offset?
    end type manoeuvre_quality_t

contains

    !> An arc of a case's duration. Fails when the noise cannot be whitened (level 0), or when the arc has too
    !> few samples.
    subroutine new_planned_arc(case, arc, error)
        type(case_t), intent(in) :: case
        type(planned_arc_t), intent(out) :: arc
        type(error_t), allocatable, intent(out) :: error

        arc%knowledge = operator_knowledge(case, case%operator)
        arc%interval = arc%knowledge%accelerometer_interval
        arc%samples = nint(arc%knowledge%duration/arc%interval)
        if (case%density_wave_random .and. case%density_model /= 'none' .and. case%density_scale > 0 .and. &
            case%density_wave%period > 0) then          ! else it is in the drag of the flight
            arc%wave_amplitude = case%density_wave%amplitude/case%density_scale
            arc%wave_period = case%density_wave%period
        end if
        call weigh_arc(arc, error)
    end subroutine new_planned_arc

    !> The same arc with fewer samples, under noise of the same spectrum: what it says of a manoeuvre is nearly the same, and
    !> takes less time. Fails as new_planned_arc does.
    subroutine thin_arc(arc, samples, thinned, error)
        type(planned_arc_t), intent(in) :: arc
        integer, intent(in) :: samples                  !! Of the thinned one
        type(planned_arc_t), intent(out) :: thinned
        type(error_t), allocatable, intent(out) :: error

        thinned%knowledge = arc%knowledge
        thinned%samples = samples
        thinned%interval = arc%samples*arc%interval/samples
        thinned%wave_amplitude = arc%wave_amplitude
        thinned%wave_period = arc%wave_period
        call weigh_arc(thinned, error)
    end subroutine thin_arc

    pure real(dp) function duration_of_samples(self) result(duration)
        class(planned_arc_t), intent(in) :: self

        duration = self%samples*self%interval
    end function duration_of_samples

    !> Whiteners and density wave for the samples of an arc.
    subroutine weigh_arc(arc, error)
        type(planned_arc_t), intent(inout) :: arc
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: angle
        integer :: k, axis

        call accelerometer_whiteners(arc%knowledge%accelerometer_noise, arc%interval, [(k, k=1, arc%samples)], &
                                     arc%whiteners, error)
        if (allocated(error)) return
        allocate (arc%weighed_wave(2, arc%samples, 3))
        arc%weighed_wave = 0
        if (.not. arc%wave_amplitude > 0) return
        do axis = 1, 3
            do k = 1, arc%samples
                angle = TWO_PI*k*arc%interval/arc%wave_period
                arc%weighed_wave(:, k, axis) = [sin(angle), cos(angle)]
            end do
            call weigh_series(arc%whiteners(axis), arc%weighed_wave(1, :, axis))
            call weigh_series(arc%whiteners(axis), arc%weighed_wave(2, :, axis))
        end do
    end subroutine weigh_arc

    !> Tabulates the nominal flight from `time` on. Fails when the time lies outside of the orbit.
    subroutine new_manoeuvre_site(arc, orbit, time, site, error)
        type(planned_arc_t), intent(in) :: arc
        type(nominal_orbit_t), intent(in) :: orbit
        real(dp), intent(in) :: time                !! Of the start, s from the epoch of the orbit
        type(manoeuvre_site_t), intent(out) :: site
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: states(:, :), field(:, :), force(:, :)
        type(loads_t) :: acting
        real(dp) :: height, step, fine_step
        integer :: i, j, steps, fine_steps

        if (.not. (time >= 0 .and. time <= last_time(orbit))) then
            call fail(error, 'time of the calibration = '//number_text(time)//' s: from 0 to '// &
                      number_text(last_time(orbit))//' s after the epoch of the orbit is allowed')
            return
        end if
        site%time = time
        steps = max(1, ceiling(arc%duration()/ORBIT_STEP))
        step = arc%duration()/steps
        fine_steps = LOADS_PER_STEP*steps
        fine_step = step/LOADS_PER_STEP
        allocate (states(STATE_SIZE, 0:steps), field(3, 0:fine_steps), force(3, 0:fine_steps))
        states(:, :) = states_from(orbit, time, step, steps)
        site%state = states(:, 0)
        call earth_fixed_to_geodetic(matmul(orbit%dynamics%earth%from_inertial(time), site%state(POSITION)), &
                                     site%latitude, site%longitude, height)
        do j = 0, fine_steps
            i = min(j/LOADS_PER_STEP, steps - 1)
            call orbit%dynamics%loads(time + j*fine_step, &
                                      state_between(states(:, i), states(:, i + 1), step, &
                                                    (j - i*LOADS_PER_STEP)/real(LOADS_PER_STEP, dp)), acting)
            field(:, j) = acting%field
            force(:, j) = acting%drag + acting%srp + acting%erp
            if (j > 0) cycle
            site%drag = acting%drag
            site%torque = gravity_gradient_torque(EARTH_GM, norm2(site%state(POSITION)), acting%vertical, &
                                                  arc%knowledge%inertia)
        end do
        site%at_edge = edge_of_shadow(julian_centuries_tt(utc_plus(arc%knowledge%epoch, time)), [(i*step, i=0, steps)], &
                                      states(POSITION, :), arc%duration()) >= 0
        call find_force_slopes(orbit, time, states(:, 0), force(:, 0), site%force_slope)
        allocate (site%field(3, 0:2*arc%samples), site%force(3, 0:arc%samples))
        call resample(field, arc%interval/(2*fine_step), site%field)
        call resample(force, arc%interval/fine_step, site%force)
        call weigh_force(arc, site)
    end subroutine new_manoeuvre_site

    !> The same place for an arc with fewer samples, of thin_arc.
    subroutine thin_site(arc, site, thinned_arc, thinned)
        type(planned_arc_t), intent(in) :: arc, thinned_arc
        type(manoeuvre_site_t), intent(in) :: site          !! With the samples of `arc`
        type(manoeuvre_site_t), intent(out) :: thinned

        thinned = site
        deallocate (thinned%field, thinned%force, thinned%weighed_force)
        allocate (thinned%field(3, 0:2*thinned_arc%samples), thinned%force(3, 0:thinned_arc%samples))
        associate (ratio => real(arc%samples, dp)/thinned_arc%samples)
            call resample(site%field, ratio, thinned%field)
            call resample(site%force, ratio, thinned%force)
        end associate
        call weigh_force(thinned_arc, thinned)
    end subroutine thin_site

    !> Another table of the same series, linear between the points of the first.
    pure subroutine resample(given, ratio, wanted)
        real(dp), intent(in) :: given(:, 0:)
        real(dp), intent(in) :: ratio               ! of the steps: wanted/given
        real(dp), intent(out) :: wanted(:, 0:)

        real(dp) :: place, fraction
        integer :: i, j

        do j = 0, ubound(wanted, 2)
            place = j*ratio
            i = min(int(place), ubound(given, 2) - 1)
            fraction = place - i
            wanted(:, j) = (1 - fraction)*given(:, i) + fraction*given(:, i + 1)
        end do
    end subroutine resample

    !> Weighs the forces along the nominal flight.
    subroutine weigh_force(arc, site)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(inout) :: site

        real(dp) :: series(arc%samples)
        integer :: axis

        allocate (site%weighed_force(3, arc%samples))
        do axis = 1, 3
            series = site%force(axis, 1:)
            call weigh_series(arc%whiteners(axis), series)
            site%weighed_force(axis, :) = series
        end do
    end subroutine weigh_force

    !> How the non-gravitational acceleration changes when the satellite is turned a little. The plates of
    !> one side come into the flow by a positive turn, those of the other by a negative one.
    subroutine find_force_slopes(orbit, time, state, force, slope)
        type(nominal_orbit_t), intent(in) :: orbit
        real(dp), intent(in) :: time
        real(dp), intent(in) :: state(:), force(3)  !! At that time; m/s^2
        real(dp), intent(out) :: slope(3, 3, 2)

        real(dp), parameter :: TURN = 2e-4_dp       ! rad, as a manoeuvre turns the satellite
        type(loads_t) :: acting
        real(dp) :: turned(size(state)), axis(3), angle
        integer :: i, side

        do side = 1, 2
            angle = merge(TURN, -TURN, side == 1)
            do i = 1, 3
                axis = 0
                axis(i) = 1
                turned = state
                turned(ATTITUDE) = quaternion_product(quaternion_from_axis_angle(axis, angle), state(ATTITUDE))
                call orbit%dynamics%loads(time, turned, acting)
                slope(:, i, side) = (acting%drag + acting%srp + acting%erp - force)/angle
            end do
        end do
    end subroutine find_force_slopes

    !> The state between two states `step` seconds apart: the orbit by the cubic that has both positions and
    !> velocities, the attitude turned on from the first.
    pure function state_between(first, second, step, fraction) result(state)
        real(dp), intent(in) :: first(STATE_SIZE), second(STATE_SIZE)
        real(dp), intent(in) :: step                !! s
        real(dp), intent(in) :: fraction            !! Of the step, from 0 to 1
        real(dp) :: state(STATE_SIZE)

        state = first
        associate (u => fraction, v => 1 - fraction, speed => norm2(first(RATE)))
            state(POSITION) = v**2*(1 + 2*u)*first(POSITION) + u**2*(1 + 2*v)*second(POSITION) + &
                              step*u*v*(v*first(VELOCITY) - u*second(VELOCITY))
            state(VELOCITY) = 6*u*v*(second(POSITION) - first(POSITION))/step + &
                              v*(1 - 3*u)*first(VELOCITY) + u*(1 - 3*v)*second(VELOCITY)
            state(ATTITUDE) = quaternion_product(quaternion_from_axis_angle(first(RATE)/speed, &
                                                                            speed*u*step), first(ATTITUDE))
        end associate
    end function state_between

    !> The rotation under a manoeuvre. The rods' time counts from the start of the calibration.
    subroutine fly_manoeuvre(arc, site, rods, omega, omega_dot, theta, motion)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(in) :: site
        type(torque_rods_t), intent(in) :: rods
        real(dp), intent(out) :: omega(:, :)        !! At the samples, (3, n), rad/s
        real(dp), intent(out) :: omega_dot(:, :)    !! (3, n), rad/s^2
        real(dp), intent(out) :: theta(:, :)        !! (3, n), rad
        type(attitude_motion_t), intent(out) :: motion

        real(dp) :: dipole(3, 0:2*arc%samples)

        call dipole_moments(rods, arc%interval/2, dipole)
        call fly_moments(arc, site, dipole, omega, omega_dot, theta, motion)
    end subroutine fly_manoeuvre

    !> The rotation under the moments of the rods: rigid body with magnetic and gravity-gradient torque, (2-16), and
    !> small angles theta from the nominal to the true body axes,
    !>
    !>     d theta/dt = omega - omega_nominal - omega_nominal x theta,   B = B_nominal - theta x B_nominal.
    pure subroutine fly_moments(arc, site, dipole, omega, omega_dot, theta, motion)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(in) :: site
        real(dp), intent(in) :: dipole(3, 0:2*arc%samples)  !! At every half interval, body axes, A m^2; torquers': N m
        real(dp), intent(out), dimension(3, arc%samples) :: omega, omega_dot, theta     !! rad/s, rad/s^2, rad
        type(attitude_motion_t), intent(out) :: motion

        real(dp) :: inertia(3, 3), inverse_inertia(3, 3), nominal(3), h, fastest, furthest, square
        real(dp), dimension(6) :: y, slope_1, slope_2, slope_3, slope_4
        real(dp), dimension(3, 0:2*arc%samples) :: torque, moment       ! that do not hang on the field, and that do
        integer :: k

        torque = spread(site%torque, 2, size(torque, 2))
        moment = dipole
        if (arc%knowledge%rods%direct) then
            torque = torque + dipole
            moment = 0
        end if
        h = arc%interval
        inertia = arc%knowledge%inertia
        inverse_inertia = inverse_3x3(inertia)
        nominal = site%state(RATE)
        y(1:3) = nominal
        y(4:6) = 0
        fastest = 0
        furthest = 0
        do k = 0, arc%samples
            call rate_of_flight(inertia, inverse_inertia, nominal, torque(:, 2*k), moment(:, 2*k), site%field(:, 2*k), &
                                y, slope_1)
            square = y(1)**2 + y(2)**2 + y(3)**2
            if (.not. square <= fastest) then
                fastest = square
                motion%rate_time = k*h
            end if
            if (k > 0) then
                square = y(4)**2 + y(5)**2 + y(6)**2
                if (.not. square <= furthest) then
                    furthest = square
                    motion%excursion_time = k*h
                end if
                omega(:, k) = y(1:3)
                omega_dot(:, k) = slope_1(1:3)
                theta(:, k) = y(4:6)
            end if
            if (k == arc%samples) exit
            call rate_of_flight(inertia, inverse_inertia, nominal, torque(:, 2*k + 1), moment(:, 2*k + 1), &
                                site%field(:, 2*k + 1), y + h/2*slope_1, slope_2)
            call rate_of_flight(inertia, inverse_inertia, nominal, torque(:, 2*k + 1), moment(:, 2*k + 1), &
                                site%field(:, 2*k + 1), y + h/2*slope_2, slope_3)
            call rate_of_flight(inertia, inverse_inertia, nominal, torque(:, 2*k + 2), moment(:, 2*k + 2), &
                                site%field(:, 2*k + 2), y + h*slope_3, slope_4)
            y = y + h/6*slope_1 + h/3*slope_2 + h/3*slope_3 + h/6*slope_4
        end do
        motion%rate = sqrt(fastest)
        motion%excursion = sqrt(furthest)
    end subroutine fly_moments

    !> The equations of that flight, written out component by component, so that all of it stays in registers: some
    !> eighty operations.
    pure subroutine rate_of_flight(inertia, inverse_inertia, nominal, torque, dipole, field, state, slope)
        real(dp), intent(in) :: inertia(3, 3), inverse_inertia(3, 3)
        real(dp), intent(in) :: nominal(3), torque(3), dipole(3), field(3)
        real(dp), intent(in) :: state(6)            ! omega, theta
        real(dp), intent(out) :: slope(6)

        real(dp) :: omega(3), theta(3), b(3), momentum(3), t(3)

        omega = state(1:3)
        theta = state(4:6)
        b(1) = field(1) - (theta(2)*field(3) - theta(3)*field(2))
        b(2) = field(2) - (theta(3)*field(1) - theta(1)*field(3))
        b(3) = field(3) - (theta(1)*field(2) - theta(2)*field(1))
        momentum = inertia(:, 1)*omega(1) + inertia(:, 2)*omega(2) + inertia(:, 3)*omega(3)
        t(1) = torque(1) + (dipole(2)*b(3) - dipole(3)*b(2)) - (omega(2)*momentum(3) - omega(3)*momentum(2))
        t(2) = torque(2) + (dipole(3)*b(1) - dipole(1)*b(3)) - (omega(3)*momentum(1) - omega(1)*momentum(3))
        t(3) = torque(3) + (dipole(1)*b(2) - dipole(2)*b(1)) - (omega(1)*momentum(2) - omega(2)*momentum(1))
        slope(1:3) = inverse_inertia(:, 1)*t(1) + inverse_inertia(:, 2)*t(2) + inverse_inertia(:, 3)*t(3)
        slope(4) = omega(1) - nominal(1) - (nominal(2)*theta(3) - nominal(3)*theta(2))
        slope(5) = omega(2) - nominal(2) - (nominal(3)*theta(1) - nominal(1)*theta(3))
        slope(6) = omega(3) - nominal(3) - (nominal(1)*theta(2) - nominal(2)*theta(1))
    end subroutine rate_of_flight

    !> The limit at d = 0 and the errors by drag and radiation, of the estimate that reaches the limit.
    !> A manoeuvre that leaves a direction unseen gets huge(1.0) for all sigmas.
    subroutine evaluate_manoeuvre(arc, site, rods, quality)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(in) :: site
        type(torque_rods_t), intent(in) :: rods
        type(manoeuvre_quality_t), intent(out) :: quality

        real(dp) :: dipole(3, 0:2*arc%samples)

        call dipole_moments(rods, arc%interval/2, dipole)
        call evaluate_moments(arc, site, dipole, .false., quality)
    end subroutine evaluate_manoeuvre

    !> The same of the rods' moments. Where only a motion within the limits is to be weighed, what goes beyond them
    !> gets huge(1.0) for all errors, and its motion is told.
    pure subroutine evaluate_moments(arc, site, dipole, within_limits, quality)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(in) :: site
        real(dp), intent(in) :: dipole(3, 0:2*arc%samples)  !! At every half interval, body axes, A m^2
        logical, intent(in) :: within_limits                !! Weighs only what keeps the limits
        type(manoeuvre_quality_t), intent(out) :: quality

        real(dp), dimension(3, arc%samples) :: omega, omega_dot, theta, turned
        real(dp) :: information(3, 3), on_wave(3, 2), on_force(3), on_turned(3), a(3, 3)
        integer :: i, k, axis

        call fly_moments(arc, site, dipole, omega, omega_dot, theta, quality%motion)
        quality%sigma = huge(1.0_dp)
        quality%wave = huge(1.0_dp)
        quality%force = huge(1.0_dp)
        if (within_limits .and. exceeds_limits(arc%knowledge%limits, quality%motion)) return
        do i = 1, arc%samples
            turned(:, i) = 0
            do k = 1, 3
                turned(:, i) = turned(:, i) + site%force_slope(:, k, merge(1, 2, theta(k, i) > 0))*theta(k, i)
            end do
        end do
        call gather_information(omega, omega_dot, arc%whiteners, information, disturbance=turned, effect=on_turned)
        call invert_information(information, quality%covariance, quality%sigma)
        if (.not. quality%is_seen()) return
        on_wave = 0
        on_force = on_turned
        do i = 1, arc%samples
            a = offset_matrix(omega(:, i), omega_dot(:, i))
            do axis = 1, 3
                on_force = on_force + a(axis, :)*site%weighed_force(axis, i)
                on_wave(:, 1) = on_wave(:, 1) + a(axis, :)*(arc%weighed_wave(1, i, axis)*site%drag(axis))
                on_wave(:, 2) = on_wave(:, 2) + a(axis, :)*(arc%weighed_wave(2, i, axis)*site%drag(axis))
            end do
        end do
        quality%force = abs(matmul(quality%covariance, on_force))
        ! a wave of random phase: the mean of the squares of sine and cosine
        quality%wave = arc%wave_amplitude*norm2(matmul(quality%covariance, on_wave), 2)/sqrt(2.0_dp)
    end subroutine evaluate_moments

    pure logical function is_seen(self)
        class(manoeuvre_quality_t), intent(in) :: self

        is_seen = all(self%sigma < huge(1.0_dp))
    end function is_seen
end module gracecg_planning_site
