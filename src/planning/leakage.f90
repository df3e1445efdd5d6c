!> What the leakage of the rods into the accelerometer does to a manoeuvre: the least standard deviation of the CG
!> offset when an acceleration in proportion to each rod's current and to its rate is estimated with it,
!>
!>     y_a = [A(wd, w) d]_a + bias + drift + sum_k (L_ak I_k + K_ak dI_k/dt) + noise.
!>
!> At one place the field is nearly constant: what L makes looks like d. Half a revolution later the field is reversed,
!> the signal of d turns its sign, and L does not: two flights there separate them.
module gracecg_planning_leakage
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM, TWO_PI
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_spacecraft_rod_leakage, only: USUAL_ROD_GAIN, USUAL_LEAKAGE
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, dipole_moment
    use gracecg_estimation_noise_whitening, only: weigh_series
    use gracecg_estimation_offset_model, only: offset_matrix
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_dynamics, only: POSITION, VELOCITY
    use gracecg_simulation_limits, only: attitude_motion_t
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit, last_time
    use gracecg_planning_site, only: planned_arc_t, new_planned_arc, manoeuvre_site_t, new_manoeuvre_site, &
        fly_manoeuvre
    implicit none
    private
    public :: leakage_pair_t, leakage_of_case, find_pair

    integer, parameter :: PARAMETERS = 21           !! d; L and K of each axis and rod
    real(dp), parameter :: AROUND = 600, STEP = 60  !! Places about half a revolution that are tried, s

    !> A manoeuvre alone and flown a second time half a revolution away. Standard deviations of d in body axes, m,
    !> without leakage and with it estimated, of which the a-priori sigmas are USUAL_LEAKAGE.
    type :: leakage_pair_t
        real(dp) :: without(3) = 0      !! One flight, leakage left out
        real(dp) :: with(3) = 0         !! One flight, leakage estimated
        real(dp) :: pair_without(3) = 0     !! Two flights, leakage left out
        real(dp) :: pair_with(3) = 0        !! Two flights, leakage estimated
        real(dp) :: time = 0            !! Start of the second flight, s from the epoch of the orbit
        real(dp) :: latitude = 0        !! Geodetic, of its place, rad
        real(dp) :: longitude = 0       !! Positive east, rad
        real(dp) :: opposite = 0        !! Cosine of the angle between both fields, body axes
    end type leakage_pair_t

contains

    !> Normal equations of d, L and K at a place.
    subroutine normal_matrix(arc, site, rods, normal)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(in) :: site
        type(torque_rods_t), intent(in) :: rods         !! Times count from the start of the calibration
        real(dp), intent(out) :: normal(PARAMETERS, PARAMETERS)

        type(attitude_motion_t) :: motion
        real(dp) :: omega(3, arc%samples), omega_dot(3, arc%samples), theta(3, arc%samples)
        real(dp) :: rows(arc%samples, 9), weighed(arc%samples, 9), a(3, 3), part(9, 9)
        integer :: i, k, axis, number(9)

        call fly_manoeuvre(arc, site, rods, omega, omega_dot, theta, motion)
        do i = 1, arc%samples
            associate (t => i*arc%interval, h => arc%interval/2)
                rows(i, 4:6) = dipole_moment(rods, t)/USUAL_ROD_GAIN
                rows(i, 7:9) = (dipole_moment(rods, t + h) - dipole_moment(rods, t - h))/(2*h)/USUAL_ROD_GAIN
            end associate
        end do
        normal = 0
        do axis = 1, 3
            do i = 1, arc%samples
                a = offset_matrix(omega(:, i), omega_dot(:, i))
                rows(i, 1:3) = a(axis, :)
            end do
            weighed = rows
            do k = 1, 9
                call weigh_series(arc%whiteners(axis), weighed(:, k))
            end do
            part = matmul(transpose(rows), weighed)
            number = [1, 2, 3, (3 + 6*(axis - 1) + k, k=1, 6)]
            normal(number, number) = normal(number, number) + part
        end do
    end subroutine normal_matrix

    !> Standard deviations of d from normal equations, without leakage and with it. huge: not determined.
    subroutine sigmas_of(normal, without, with)
        real(dp), intent(in) :: normal(PARAMETERS, PARAMETERS)
        real(dp), intent(out) :: without(3), with(3)        !! m

        type(error_t), allocatable :: failure
        real(dp) :: bounded(PARAMETERS, PARAMETERS), covariance(PARAMETERS, PARAMETERS), x(PARAMETERS), condition
        real(dp) :: small(3, 3), y(3)
        integer :: k

        without = huge(1.0_dp)
        with = huge(1.0_dp)
        call solve_normal_equations(normal(:3, :3), [0.0_dp, 0.0_dp, 0.0_dp], y, small, condition, failure)
        if (.not. allocated(failure)) without = sqrt([(small(k, k), k=1, 3)])
        bounded = normal
        do k = 4, PARAMETERS
            bounded(k, k) = bounded(k, k) + 1/USUAL_LEAKAGE(merge(1, 2, modulo(k - 4, 6) < 3))**2
        end do
        call solve_normal_equations(bounded, spread(0.0_dp, 1, PARAMETERS), x, covariance, condition, failure)
        if (.not. allocated(failure)) with = sqrt([(covariance(k, k), k=1, 3)])
    end subroutine sigmas_of

    !> The pair of a case's own manoeuvre at its own place. Fails as the orbit does.
    subroutine leakage_of_case(case, pair, error)
        type(case_t), intent(in) :: case
        type(leakage_pair_t), intent(out) :: pair
        type(error_t), allocatable, intent(out) :: error

        type(planned_arc_t) :: arc
        type(nominal_orbit_t) :: orbit
        type(manoeuvre_site_t) :: site

        call new_planned_arc(case, arc, error)
        if (.not. allocated(error)) call new_nominal_orbit(case, orbit, error)
        if (.not. allocated(error)) call new_manoeuvre_site(arc, orbit, 0.0_dp, site, error)
        if (.not. allocated(error)) call find_pair(arc, orbit, site, case%satellite%rods, pair, error)
    end subroutine leakage_of_case

    !> The place about half a revolution later, or earlier where the orbit ends before that, at which a second flight of
    !> the manoeuvre gives the least worst axis with leakage estimated. Where the orbit has no such place, or the leakage
    !> cannot be told there either, `pair_with` is huge(1.0) and says so. Fails as new_manoeuvre_site does.
    subroutine find_pair(arc, orbit, site, rods, pair, error)
        type(planned_arc_t), intent(in) :: arc
        type(nominal_orbit_t), intent(in) :: orbit
        type(manoeuvre_site_t), intent(in) :: site      !! Of the first flight
        type(torque_rods_t), intent(in) :: rods         !! Times count from the start of the calibration
        type(leakage_pair_t), intent(out) :: pair
        type(error_t), allocatable, intent(out) :: error

        type(manoeuvre_site_t) :: second
        real(dp), dimension(PARAMETERS, PARAMETERS) :: first, other
        real(dp) :: semi_major_axis, half, time, without(3), with(3)
        integer :: i

        call normal_matrix(arc, site, rods, first)
        call sigmas_of(first, pair%without, pair%with)
        pair%pair_with = huge(1.0_dp)
        associate (r => site%state(POSITION), v => site%state(VELOCITY))
            semi_major_axis = 1/(2/norm2(r) - dot_product(v, v)/EARTH_GM)       ! by the energy
        end associate
        half = TWO_PI*sqrt(semi_major_axis**3/EARTH_GM)/2
        do i = -nint(AROUND/STEP), nint(AROUND/STEP)
            time = site%time + half + i*STEP
            if (site%time + half > last_time(orbit)) time = site%time - half + i*STEP
            if (time < 0 .or. time > last_time(orbit)) cycle
            call new_manoeuvre_site(arc, orbit, time, second, error)
            if (allocated(error)) return
            call normal_matrix(arc, second, rods, other)
            call sigmas_of(first + other, without, with)
            if (maxval(with) >= maxval(pair%pair_with)) cycle
            pair%pair_without = without
            pair%pair_with = with
            pair%time = time
            pair%latitude = second%latitude
            pair%longitude = second%longitude
            pair%opposite = dot_product(site%field(:, 0), second%field(:, 0))/ &
                (norm2(site%field(:, 0))*norm2(second%field(:, 0)))
        end do
    end subroutine find_pair
end module gracecg_planning_leakage
