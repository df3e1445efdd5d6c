!> A calibration that starts at one place of the nominal orbit, and what a manoeuvre achieves there: the
!> theoretical limit of the CG offset's standard deviation, the error that the density wave adds, and
!> the motion of the attitude.
!>
!> Nothing is simulated: field, gravity gradient and drag along the nominal flight are tabulated once for
!> a place; a manoeuvre then costs one integration of the rotation and one pass of the whitening filter.
module gracecg_manoeuvre_site
    use gracecg_kinds, only: dp
    use gracecg_constants, only: EARTH_GM, EARTH_ROTATION_RATE, TWO_PI
    use gracecg_error, only: error_t, fail, number_text
    use gracecg_vectors, only: cross, inverse_3x3, determinant_3x3, rotation_z
    use gracecg_quaternion, only: rotation_matrix, quaternion_product, quaternion_from_axis_angle
    use gracecg_lapack, only: symmetric_eigen
    use gracecg_earth_shape, only: earth_fixed_to_geodetic
    use gracecg_torque_rods, only: torque_rods_t, dipole_moment
    use gracecg_torques, only: gravity_gradient_torque
    use gracecg_equations_of_motion, only: loads_t, STATE_SIZE, POSITION, RATE => OMEGA, ATTITUDE
    use gracecg_observation_set, only: calibration_setup_t
    use gracecg_offset_model, only: offset_matrix
    use gracecg_noise_whitening, only: whitener_t, accelerometer_whiteners
    use gracecg_offset_information, only: offset_information
    use gracecg_calibration_case, only: calibration_case_t
    use gracecg_case_models, only: operator_setup
    use gracecg_nominal_orbit, only: nominal_orbit_t, states_from, last_time
    use gracecg_manoeuvre_limits, only: attitude_motion_t
    implicit none
    private
    public :: accelerometer_view_t, new_accelerometer_view
    public :: manoeuvre_site_t, new_manoeuvre_site, fly_manoeuvre
    public :: manoeuvre_quality_t, evaluate_manoeuvre, worst_direction

    real(dp), parameter :: LONGEST_STEP = 5         !! Between the tabulated fields, s
    integer, parameter :: BLOCK = 64                !! Unit vectors that are whitened together

    !> What the accelerometer makes of an arc: its noise, and the disturbance by the density wave.
    type :: accelerometer_view_t
        type(calibration_setup_t) :: setup          !! What the operator knows
        integer :: samples = 0                      !! n, at k h for k = 1..n
        real(dp) :: interval = 0                    !! h, s
        type(whitener_t) :: whiteners(3)
        real(dp) :: wave_amplitude = 0              !! Of the density wave, relative to the drag
        real(dp), allocatable :: seen_wave(:, :, :)
        !! R^-1 (without bias and drift) times sine and cosine of the wave: (2, n, axis), R the
        !! covariance matrix of an axis; s^4/m^2
    end type accelerometer_view_t

    !> One place of the nominal orbit.
    type :: manoeuvre_site_t
        real(dp) :: time = 0                        !! s from the epoch of the orbit
        real(dp) :: latitude = 0                    !! Geodetic, rad
        real(dp) :: longitude = 0                   !! Positive east, rad
        real(dp) :: state(STATE_SIZE) = 0           !! At the start
        real(dp) :: torque(3) = 0                   !! Of the gravity gradient at the start, body axes, N m
        real(dp) :: drag(3) = 0                     !! At the start, body axes, m/s^2
        real(dp), allocatable :: field(:, :)
        !! At every half sampling interval, nominal body axes, (3, 0:2n), T
    end type manoeuvre_site_t

    !> How good a manoeuvre is at a place.
    type :: manoeuvre_quality_t
        real(dp) :: covariance(3, 3) = 0            !! The limit: inverse of the information, m^2
        real(dp) :: sigma(3) = 0                    !! Its standard deviations, body axes, m
        real(dp) :: wave(3) = 0                     !! RMS error by the density wave, m
        type(attitude_motion_t) :: motion
    end type manoeuvre_quality_t

contains

    !> The view of a case's accelerometer on an arc of its duration. Fails when the noise cannot be
    !> whitened (level 0), or when the arc has too few samples.
    subroutine new_accelerometer_view(case, view, error)
        type(calibration_case_t), intent(in) :: case
        type(accelerometer_view_t), intent(out) :: view
        type(error_t), allocatable, intent(out) :: error

        integer :: k, axis

        view%setup = operator_setup(case)
        view%interval = view%setup%accelerometer_interval
        view%samples = nint(view%setup%duration/view%interval)
        call accelerometer_whiteners(view%setup, [(k, k=1, view%samples)], view%whiteners, error)
        if (allocated(error)) return
        allocate (view%seen_wave(2, view%samples, 3))
        view%seen_wave = 0
        if (case%density_model == 'none' .or. .not. case%density_scale > 0 .or. &
            .not. case%density_wave%period > 0) return
        view%wave_amplitude = case%density_wave%amplitude/case%density_scale
        if (.not. view%wave_amplitude > 0) return
        do axis = 1, 3
            call see_wave(view%whiteners(axis), view%interval, case%density_wave%period, &
                          view%seen_wave(:, :, axis))
        end do
    end subroutine new_accelerometer_view

    !> L^-T P L^-1 applied to sine and cosine, P taking bias and drift out. L^-T needs the columns of
    !> L^-1, the whitened unit vectors.
    subroutine see_wave(whitener, interval, period, seen)
        type(whitener_t), intent(in) :: whitener
        real(dp), intent(in) :: interval, period    !! s
        real(dp), intent(out) :: seen(:, :)         !! (2, samples)

        real(dp) :: wave(2, size(seen, 2)), unit_vectors(BLOCK, size(seen, 2)), angle
        integer :: k, first, last

        do k = 1, size(wave, 2)
            angle = TWO_PI*k*interval/period
            wave(:, k) = [sin(angle), cos(angle)]
        end do
        call whitener%whiten(wave)
        wave = wave - matmul(matmul(wave, transpose(whitener%line)), whitener%line)
        do first = 1, size(wave, 2), BLOCK
            last = min(first + BLOCK - 1, size(wave, 2))
            unit_vectors = 0
            do k = first, last
                unit_vectors(k - first + 1, k) = 1
            end do
            call whitener%whiten(unit_vectors)
            seen(:, first:last) = matmul(wave, transpose(unit_vectors(:last - first + 1, :)))
        end do
    end subroutine see_wave

    !> Tabulates the nominal flight from `time` on. Fails when the time lies outside of the orbit.
    subroutine new_manoeuvre_site(view, orbit, time, site, error)
        type(accelerometer_view_t), intent(in) :: view
        type(nominal_orbit_t), intent(in) :: orbit
        real(dp), intent(in) :: time                !! Of the start, s from the epoch of the orbit
        type(manoeuvre_site_t), intent(out) :: site
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: states(:, :), field(:, :)
        type(loads_t) :: acting
        real(dp) :: fixed_position(3), height, step, place, fraction
        real(dp) :: to_inertial(3, 3), inertial(3)
        integer :: i, j, steps

        if (.not. (time >= 0 .and. time <= last_time(orbit))) then
            call fail(error, 'time of the calibration = '//number_text(time)//' s: from 0 to '// &
                      number_text(last_time(orbit))//' s after the epoch of the orbit is allowed')
            return
        end if
        site%time = time
        associate (duration => view%samples*view%interval)
            steps = max(1, ceiling(duration/LONGEST_STEP))
            step = duration/steps
        end associate
        allocate (states(STATE_SIZE, 0:steps), field(3, 0:steps))
        states(:, :) = states_from(orbit, time, step, steps)
        site%state = states(:, 0)
        call earth_fixed_to_geodetic(matmul(rotation_z(orbit%dynamics%sidereal_angle + EARTH_ROTATION_RATE*time), &
                                            site%state(POSITION)), site%latitude, site%longitude, height)
        do i = 0, steps
            call field_in_inertial_axes(orbit, time + i*step, states(:, i), field(:, i))
        end do
        call orbit%dynamics%loads(time, site%state, acting)
        site%drag = acting%drag
        site%torque = gravity_gradient_torque(EARTH_GM, norm2(site%state(POSITION)), acting%vertical, &
                                              view%setup%inertia)
        allocate (site%field(3, 0:2*view%samples))
        do j = 0, 2*view%samples
            place = j*view%interval/(2*step)
            i = min(int(place), steps - 1)
            fraction = place - i
            inertial = (1 - fraction)*field(:, i) + fraction*field(:, i + 1)
            to_inertial = transpose(rotation_matrix(nominal_attitude(site%state, j*view%interval/2)))
            site%field(:, j) = matmul(inertial, to_inertial)
        end do
    end subroutine new_manoeuvre_site

    !> Geomagnetic flux density, inertial axes, T.
    pure subroutine field_in_inertial_axes(orbit, time, state, field)
        type(nominal_orbit_t), intent(in) :: orbit
        real(dp), intent(in) :: time, state(:)
        real(dp), intent(out) :: field(3)

        real(dp) :: earth_from_inertial(3, 3), fixed(3)

        earth_from_inertial = rotation_z(orbit%dynamics%sidereal_angle + EARTH_ROTATION_RATE*time)
        call orbit%dynamics%field%evaluate(matmul(earth_from_inertial, state(POSITION)), fixed)
        field = matmul(fixed, earth_from_inertial)
    end subroutine field_in_inertial_axes

    !> The attitude that is held, `later` seconds after the start: turned on at the angular velocity.
    pure function nominal_attitude(state, later) result(q)
        real(dp), intent(in) :: state(:)
        real(dp), intent(in) :: later               !! s
        real(dp) :: q(4)

        associate (speed => norm2(state(RATE)))
            q = quaternion_product(quaternion_from_axis_angle(state(RATE)/speed, speed*later), &
                                   state(ATTITUDE))
        end associate
    end function nominal_attitude

    !> The rotation under a manoeuvre: rigid body with magnetic and gravity-gradient torque, (2-16), and
    !> small angles theta from the nominal to the true body axes,
    !>
    !>     d theta/dt = omega - omega_nominal - omega_nominal x theta,   B = B_nominal - theta x B_nominal,
    !>
    !> by the classical Runge-Kutta method with one step a sampling interval. The rods' time counts
    !> from the start of the calibration.
    pure subroutine fly_manoeuvre(view, site, rods, omega, omega_dot, motion)
        type(accelerometer_view_t), intent(in) :: view
        type(manoeuvre_site_t), intent(in) :: site
        type(torque_rods_t), intent(in) :: rods
        real(dp), intent(out) :: omega(:, :)        !! At the samples, (3, n), rad/s
        real(dp), intent(out) :: omega_dot(:, :)    !! (3, n), rad/s^2
        type(attitude_motion_t), intent(out) :: motion

        real(dp) :: inertia(3, 3), inverse(3, 3), nominal(3), y(6), slope(6, 4)
        real(dp) :: moment(3), middle_moment(3), next_moment(3)
        integer :: k

        inertia = view%setup%inertia
        inverse = inverse_3x3(inertia)
        nominal = site%state(RATE)
        y = [nominal, 0.0_dp, 0.0_dp, 0.0_dp]
        motion%rate = norm2(nominal)
        moment = dipole_moment(rods, 0.0_dp)
        associate (h => view%interval)
            slope(:, 1) = derivative(moment, 0, y)
            do k = 1, view%samples
                middle_moment = dipole_moment(rods, (k - 0.5_dp)*h)
                next_moment = dipole_moment(rods, k*h)
                slope(:, 2) = derivative(middle_moment, 2*k - 1, y + h/2*slope(:, 1))
                slope(:, 3) = derivative(middle_moment, 2*k - 1, y + h/2*slope(:, 2))
                slope(:, 4) = derivative(next_moment, 2*k, y + h*slope(:, 3))
                y = y + h/6*(slope(:, 1) + 2*slope(:, 2) + 2*slope(:, 3) + slope(:, 4))
                slope(:, 1) = derivative(next_moment, 2*k, y)
                omega(:, k) = y(1:3)
                omega_dot(:, k) = slope(1:3, 1)
                if (.not. norm2(y(1:3)) <= motion%rate) then
                    motion%rate = norm2(y(1:3))
                    motion%rate_time = k*h
                end if
                if (.not. norm2(y(4:6)) <= motion%excursion) then
                    motion%excursion = norm2(y(4:6))
                    motion%excursion_time = k*h
                end if
            end do
        end associate

    contains

        pure function derivative(m, half, at) result(change)
            real(dp), intent(in) :: m(3)            ! A m^2
            integer, intent(in) :: half             ! time in half intervals
            real(dp), intent(in) :: at(6)
            real(dp) :: change(6)

            real(dp) :: b(3)

            b = site%field(:, half)
            b = b - cross(at(4:6), b)
            change(1:3) = matmul(inverse, cross(m, b) + site%torque - cross(at(1:3), matmul(inertia, at(1:3))))
            change(4:6) = at(1:3) - nominal - cross(nominal, at(4:6))
        end function derivative
    end subroutine fly_manoeuvre

    !> The limit at d = 0 and the error by the density wave. A manoeuvre that leaves a direction unseen
    !> gets huge(1.0) for all sigmas.
    pure subroutine evaluate_manoeuvre(view, site, rods, quality)
        type(accelerometer_view_t), intent(in) :: view
        type(manoeuvre_site_t), intent(in) :: site
        type(torque_rods_t), intent(in) :: rods
        type(manoeuvre_quality_t), intent(out) :: quality

        real(dp), parameter :: SINGULAR = 1e-12_dp  ! of the determinant with unit diagonal
        real(dp) :: omega(3, view%samples), omega_dot(3, view%samples)
        real(dp) :: information(3, 3), on_wave(3, 2), a(3, 3), product_of_diagonal
        integer :: i, axis

        call fly_manoeuvre(view, site, rods, omega, omega_dot, quality%motion)
        information = offset_information(omega, omega_dot, view%whiteners)
        product_of_diagonal = information(1, 1)*information(2, 2)*information(3, 3)
        quality%sigma = huge(1.0_dp)
        quality%wave = huge(1.0_dp)
        if (.not. determinant_3x3(information) > SINGULAR*product_of_diagonal) return
        quality%covariance = inverse_3x3(information)
        quality%sigma = [(sqrt(quality%covariance(i, i)), i=1, 3)]
        quality%wave = 0
        if (.not. view%wave_amplitude > 0) return
        on_wave = 0
        do i = 1, view%samples
            a = offset_matrix(omega(:, i), omega_dot(:, i))
            do axis = 1, 3
                on_wave(:, 1) = on_wave(:, 1) + a(axis, :)*view%seen_wave(1, i, axis)*site%drag(axis)
                on_wave(:, 2) = on_wave(:, 2) + a(axis, :)*view%seen_wave(2, i, axis)*site%drag(axis)
            end do
        end do
        ! a wave of random phase: the mean of the squares of sine and cosine
        quality%wave = view%wave_amplitude*norm2(matmul(quality%covariance, on_wave), 2)/sqrt(2.0_dp)
    end subroutine evaluate_manoeuvre

    !> The direction in which the offset is least known, and its standard deviation.
    subroutine worst_direction(quality, sigma, direction, error)
        type(manoeuvre_quality_t), intent(in) :: quality
        real(dp), intent(out) :: sigma              !! m
        real(dp), intent(out) :: direction(3)       !! Unit vector, body axes, largest component positive
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: values(3), vectors(3, 3)

        sigma = huge(1.0_dp)
        direction = 0
        if (.not. all(quality%sigma < huge(1.0_dp))) return
        call symmetric_eigen(quality%covariance, values, vectors, error)
        if (allocated(error)) return
        sigma = sqrt(max(0.0_dp, values(3)))
        direction = vectors(:, 3)
        direction = direction*sign(1.0_dp, direction(maxloc(abs(direction), 1)))
    end subroutine worst_direction
end module gracecg_manoeuvre_site
