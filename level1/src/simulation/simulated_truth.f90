!> The truth behind simulated Level-1 files: hours of flight with sub-manoeuvres of the torque rods.
!>
!> The orbit is propagated with all forces of the case and its attitude held (gracecg_simulation_nadir_pointing), second
!> by second. The attitude is integrated beside it, ten times a second and at every jump of a torque:
!>
!>     J w' = T_rods + T_gravity_gradient + T_air + T_sunlight + T_thrusters + T_control - w x J w
!>
!> with the rods' currents as they flow, in science mode too, and the field along the true axes. Between the
!> sub-manoeuvres a controller keeps the satellite near the attitude that is held; it lets go, smoothly, well before
!> each of them and takes over well after it. Torques of air and sunlight are those of the held attitude.
!>
!> Inertial axes are those of J2000; Earth-fixed ones follow by precession and nutation, and the orbit of a case
!> is taken to be in them.
module gracecg_level1_simulated_truth
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: EARTH_GM, TWO_PI
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_product, conjugate_quaternion, quaternion_rate, normalised, &
        quaternion_from_axis_angle
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_base_vectors, only: cross, inverse_3x3, unit
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model
    use gracecg_environment_space_weather, only: space_weather_source_t
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_environment_time, only: utc_of_gps, GPS_EPOCH, utc_t, decimal_year, seconds_between, parse_utc, utc_text, utc_plus
    use gracecg_level1_frames, only: inertial_of_earth_fixed
    use gracecg_spacecraft_gravity_gradient_torque, only: gravity_gradient_torque
    use gracecg_spacecraft_mass_properties, only: mass_properties_t, inertia_about_com
    use gracecg_simulation_accelerometer, only: pmc_acceleration, pmc_acceleration_t
    use gracecg_simulation_arc, only: truth_arc_t, propagate_arc, DEFAULT_TOLERANCE
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_case_models, only: build_dynamics, initial_state
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, POSITION, VELOCITY, OMEGA, ATTITUDE
    use gracecg_level1_simulation_settings, only: level1_settings_t, level1_span_settings_t, span_list, by_satellite
    use gracecg_simulation_nadir_pointing, only: nadir_pointing_t
    implicit none
    private
    public :: level1_truth_t, level1_orbit_t, truth_point_t, firing_t, new_level1_orbit, new_level1_truth
    public :: level1_stream, PAIRS, FIRING_TIME, LEAD

    integer, parameter :: LEAD = 4                      !! Seconds of truth before the files and after them
    integer, parameter :: STEPS_PER_SECOND = 10         !! Of the attitude
    real(dp), parameter :: STEP = 1.0_dp/STEPS_PER_SECOND
    real(dp), parameter :: HOLD = 0.5_dp                !! Of held currents, s
    real(dp), parameter :: FIRST_TAG = 0.1_dp           !! Of them within a second of the on-board computer, s
    real(dp), parameter :: FIRING_TIME = 0.05_dp        !! Of a thruster, s
    real(dp), parameter :: FREE = 25, TAKE_OVER = 60    !! The controller rests so long around a span, and so long
                                                        !! takes it to act fully, s
    real(dp), parameter :: BANDWIDTH = 0.02_dp          !! Of the controller, rad/s
    real(dp), parameter :: SLOWEST(2) = [1500.0_dp, 470.0_dp]   !! Periods of currents in science mode, s
    integer, parameter :: QUANTITIES = 19

    !> Pairs of thrusters that fire together (numbers of on_time); their places (m) and the force of one (N) along SRF:
    !> GRACEiolib.h, after SDSPSD v3.0
    integer, parameter :: PAIRS(2, 4) = reshape([1, 7, 3, 9, 5, 11, 6, 12], [2, 4])
    real(dp), parameter :: PLACES(3, 2, 4) = reshape([ &
        -1.450_dp, -0.719_dp, 0.0_dp, 1.450_dp, 0.719_dp, 0.0_dp, &
        -1.450_dp, 0.719_dp, 0.0_dp, 1.450_dp, -0.719_dp, 0.0_dp, &
        0.0_dp, -0.970_dp, 0.300_dp, 0.0_dp, 0.467_dp, -0.300_dp, &
        0.0_dp, -0.467_dp, -0.300_dp, 0.0_dp, 0.970_dp, 0.300_dp], [3, 2, 4])
    real(dp), parameter :: FORCES(2, 4) = 0.010_dp*reshape([1, -1, -1, 1, 1, -1, 1, -1], [2, 4])    !! Along y, N

    type :: firing_t
        !! One firing of a pair of thrusters
        real(dp) :: time = 0        !! When it begins, s from the beginning of the files
        integer :: pair = 1         !! Of PAIRS
        real(dp) :: mismatch = 0    !! Force left over along y, of that of one thruster
    end type firing_t

    type :: level1_orbit_t
        !! What no random number touches: orbit, forces and held attitude, second by second. Times are s from the
        !! beginning of the files
        type(case_t) :: case    !! That is flown
        type(level1_settings_t) :: settings    !! What is flown and measured wrongly
        character(1) :: satellite = 'C'     !! A to D
        integer(i8) :: epoch = 0            !! The beginning of the files, GPS s past 2000-01-01 12:00
        integer :: duration = 0             !! Of the files, s
        character(:), allocatable :: remark !! What is to be known of the epoch
        type(level1_span_settings_t), allocatable :: spans(:)    !! The sub-manoeuvres
        real(dp), allocatable :: position(:, :), velocity(:, :)     !! Inertial, m, m/s; (3, -LEAD:duration + LEAD)
        real(dp), allocatable :: field(:, :)                        !! IGRF-14, Earth-fixed, T
        real(dp), allocatable :: earth(:, :, :)                     !! Earth-fixed to inertial
        real(dp), allocatable :: force(:, :)                        !! Non-gravitational, body axes, m/s^2
        real(dp), allocatable :: drag(:, :)                         !! Part of it, by the air
        real(dp), allocatable :: torque(:, :)                       !! Of air and sunlight, N m
        real(dp), allocatable :: held_quaternion(:, :), held_rate(:, :)     !! Inertial to body; body axes, rad/s
    end type level1_orbit_t

    type :: truth_point_t
        !! Everything at one instant, body axes
        real(dp) :: quaternion(4) = 0       !! Inertial to body, scalar last
        real(dp) :: rate(3) = 0             !! rad/s
        real(dp) :: acceleration(3) = 0     !! Angular, rad/s^2
        real(dp) :: angle(3) = 0            !! Integral of the rate, rad
        real(dp) :: field(3) = 0            !! T
        real(dp) :: current(3) = 0          !! That flows, mA
        real(dp) :: current_rate(3) = 0     !! Mean over a sample of the accelerometer, mA/s
        real(dp) :: sensed(3) = 0           !! Linear acceleration at the proof mass, m/s^2
    end type truth_point_t

    type :: level1_truth_t
        !! The flight of one run
        type(level1_orbit_t) :: orbit    !! Without random numbers
        real(dp) :: clock_offset = 0, clock_drift = 0   !! GPS less receiver time at the epoch, s; s/s
        real(dp) :: gain(3) = 0             !! kappa of the rods, A m^2/mA
        real(dp) :: offset(3) = 0           !! d, m
        real(dp) :: inertia(3, 3) = 0       !! About the centre of mass, kg m^2
        type(firing_t), allocatable :: firings(:)   !! In order of time
        type(density_wave_t) :: wave        !! Of the air's density
        real(dp), private :: inverse(3, 3) = 0
        real(dp), private :: science(3, 3) = 0      !! Currents of science mode: two phases and a mean, by rod
        real(dp), allocatable :: state(:, :)        !! Rate, attitude, angle at every step; (10, 0:steps)
        real(dp), allocatable, private :: rates(:, :)   !! Their derivatives
        real(dp), allocatable, private :: slow(:, :)
        !! (QUANTITIES, seconds): position, field, force, torque, held attitude and rate
    contains
        procedure :: at                     !! Everything at an instant
        procedure :: motion                 !! Attitude, rate, angle at an instant
        procedure :: tagged_current         !! The currents that a tag names
        procedure :: obc_of_gps             !! Time of the on-board computer
        procedure :: gps_of_obc             !! And back
        procedure :: in_span                !! The span that a time lies in
        procedure :: firing_share           !! How much of a time a pair of thrusters fires
    end type level1_truth_t

contains

    !> A stream of random numbers of its own for each source of errors of a run.
    pure function level1_stream(orbit, seed, run, source) result(stream)
        type(level1_orbit_t), intent(in) :: orbit
        integer(i8), intent(in) :: seed     !! Of the random numbers
        integer, intent(in) :: run          !! Names them, too
        integer, intent(in) :: source       !! Of errors: a number of its own
        type(random_stream_t) :: stream

        integer, parameter :: FIRST = 100   !! Instruments of observation sets have smaller numbers

        stream = new_stream(seed, orbit%case%number, merge(1, 2, orbit%case%satellite%name == 'front'), run, FIRST + source)
    end function level1_stream

    !> Propagates the orbit of a case for the time of the files, from the whole GPS second next to the case's epoch.
    !> Fails as the models of the case do.
    subroutine new_level1_orbit(case, settings, orbit, error)
        type(case_t), intent(in) :: case
        type(level1_settings_t), intent(in) :: settings
        type(level1_orbit_t), intent(out) :: orbit
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: AFTER = 300      ! s, behind the last span
        type(utc_t), parameter :: LATER = utc_t(58880, 0.0_dp)      ! 2020-02-01
        type(truth_arc_t) :: arc
        type(nadir_pointing_t) :: dynamics
        class(geomagnetic_model_t), allocatable :: model
        real(dp) :: b(3)
        integer :: n, k

        orbit%case = case
        orbit%settings = settings
        orbit%satellite = settings%satellite
        if (orbit%satellite == '') orbit%satellite = merge('C', 'D', case%satellite%name == 'front')
        call span_list(settings, orbit%spans)
        if (settings%epoch /= '') then
            call parse_utc(trim(settings%epoch), orbit%case%epoch, error)
            if (allocated(error)) return
        else if (seconds_between(GPS_EPOCH, case%epoch) < 0) then
            orbit%case%epoch = LATER
            orbit%remark = 'the case is of '//utc_text(case%epoch)//'; Level-1 files count from 2000 on: it is taken to '// &
                utc_text(LATER)//' (the key epoch of level1_simulation says otherwise)'
        end if
        orbit%epoch = nint(seconds_between(GPS_EPOCH, orbit%case%epoch), i8)
        if (orbit%epoch < 0) then
            call fail(error, 'epoch '//trim(settings%epoch)//' is before 2000-01-01 12:00 GPS, from which Level-1 files count')
            return
        end if
        orbit%duration = nint(settings%duration)
        if (orbit%duration == 0) then
            orbit%duration = nint(AFTER)
            if (size(orbit%spans) > 0) orbit%duration = ceiling(maxval(orbit%spans%start + orbit%spans%duration) + AFTER)
        end if
        call choose_space_weather(orbit)
        if (orbit%case%field_model /= 'file') orbit%case%field_model = 'igrf14'
        call build_dynamics(orbit%case, dynamics%satellite_dynamics_t, error)
        if (allocated(error)) return
        dynamics%forward = case%satellite%name /= 'front'
        dynamics%density_wave = density_wave_t(0.0_dp, 1.0_dp, 0.0_dp)
        dynamics%with_rods = .false.
        n = orbit%duration + LEAD
        call propagate_arc(dynamics, initial_state(case), 1.0_dp, n + LEAD, arc, error, DEFAULT_TOLERANCE)
        if (.not. allocated(error)) &
            call new_geomagnetic_model(trim(orbit%case%field_model), decimal_year(orbit%case%epoch), orbit%case%field_file, &
                                       model, error)
        if (allocated(error)) then
            call add_context(error, 'case '//trim(case%name))
            return
        end if
        allocate (orbit%position(3, -LEAD:n), orbit%velocity(3, -LEAD:n), orbit%field(3, -LEAD:n), orbit%force(3, -LEAD:n), &
                  orbit%drag(3, -LEAD:n), orbit%torque(3, -LEAD:n), orbit%held_quaternion(4, -LEAD:n), &
                  orbit%held_rate(3, -LEAD:n), orbit%earth(3, 3, -LEAD:n))
        do k = -LEAD, n
            associate (state => arc%state(:, k + LEAD), acting => arc%loads(k + LEAD))
                orbit%position(:, k) = state(POSITION)
                orbit%velocity(:, k) = state(VELOCITY)
                orbit%earth(:, :, k) = inertial_of_earth_fixed(utc_of_gps(orbit%epoch + k, 0.0_dp))
                call model%evaluate(matmul(state(POSITION), orbit%earth(:, :, k)), b)
                orbit%field(:, k) = b
                orbit%drag(:, k) = acting%drag
                orbit%force(:, k) = acting%drag + acting%srp + acting%erp
                orbit%torque(:, k) = acting%torque_aero + acting%torque_solar
                call pitched(settings%pitch, state(ATTITUDE), state(OMEGA), orbit%held_quaternion(:, k), orbit%held_rate(:, k))
                if (k > -LEAD) then
                    if (dot_product(orbit%held_quaternion(:, k), orbit%held_quaternion(:, k - 1)) < 0) &
                        orbit%held_quaternion(:, k) = -orbit%held_quaternion(:, k)
                end if
            end associate
        end do
    end subroutine new_level1_orbit

    !> Flux and Kp of the case where the embedded table does not hold the time of the files: they act on the air alone.
    subroutine choose_space_weather(orbit)
        type(level1_orbit_t), intent(inout) :: orbit

        type(space_weather_source_t) :: source
        type(error_t), allocatable :: at_begin, at_end
        real(dp) :: f107, f107_mean, kp

        if (orbit%case%space_weather /= 'table') return
        call source%indices_at(utc_plus(orbit%case%epoch, -real(LEAD, dp)), f107, f107_mean, kp, at_begin)
        call source%indices_at(utc_plus(orbit%case%epoch, real(orbit%duration + 2*LEAD, dp)), f107, f107_mean, kp, at_end)
        if (.not. (allocated(at_begin) .or. allocated(at_end))) return
        orbit%case%space_weather = 'given'
        if (.not. allocated(orbit%remark)) orbit%remark = 'the files are of '//utc_text(orbit%case%epoch)
        orbit%remark = orbit%remark//'; f107 and kp of the case act, for the table of space weather does not hold that time'
    end subroutine choose_space_weather

    !> The held attitude turned about body y.
    pure subroutine pitched(pitch, quaternion, rate, turned, turned_rate)
        real(dp), intent(in) :: pitch               !! rad; positive: x towards z
        real(dp), intent(in) :: quaternion(4), rate(3)
        real(dp), intent(out) :: turned(4), turned_rate(3)

        real(dp) :: turn(4)

        turn = quaternion_from_axis_angle([0.0_dp, 1.0_dp, 0.0_dp], -pitch)
        turned = quaternion_product(turn, quaternion)
        turned_rate = matmul(rotation_matrix(turn), rate)
    end subroutine pitched

    !> The attitude of a run, with its firings and what is drawn of satellite and field. Fails when it does not stay
    !> near the held one.
    subroutine new_level1_truth(orbit, seed, run, truth, error)
        type(level1_orbit_t), intent(in) :: orbit
        integer(i8), intent(in) :: seed         !! Of the random numbers
        integer, intent(in) :: run              !! Names them, too
        type(level1_truth_t), intent(out) :: truth
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: GAINS = 1, CURRENTS = 2, THRUSTERS = 3, AIR = 4, FIELD = 5
        real(dp), parameter :: CLOCKS(4) = [-75.4e-3_dp, -2.9e-3_dp, -16.667e-3_dp, -17.256e-3_dp]  ! s, A to D
        real(dp), parameter :: FARTHEST = 0.1_dp    ! rad
        type(random_stream_t) :: stream
        real(dp) :: error_field(3), turn(4)
        integer :: n, k, i

        truth%orbit = orbit
        associate (settings => orbit%settings, case => orbit%case)
            truth%clock_offset = settings%clock_offset
            if (truth%clock_offset < -1) truth%clock_offset = by_satellite(orbit%satellite, CLOCKS)
            truth%clock_drift = settings%clock_drift
            truth%offset = case%satellite%offset
            truth%inertia = inertia_about_com(mass_properties_t(case%satellite%mass, case%satellite%inertia, &
                                                                case%satellite%offset))
            truth%inverse = inverse_3x3(truth%inertia)
            stream = level1_stream(orbit, seed, run, GAINS)
            do k = 1, 3
                truth%gain(k) = settings%rod_gain(k)*(1 + settings%rod_gain_error*stream%normal())
            end do
            stream = level1_stream(orbit, seed, run, CURRENTS)
            do k = 1, 3
                do i = 1, 3
                    truth%science(i, k) = stream%uniform()
                end do
            end do
            stream = level1_stream(orbit, seed, run, AIR)
            truth%wave = density_wave_t(0.0_dp, 1.0_dp, 0.0_dp)
            if (settings%density_wave) then
                truth%wave = case%density_wave
                if (case%density_wave_random) truth%wave%phase = TWO_PI*stream%uniform()
            end if
            stream = level1_stream(orbit, seed, run, THRUSTERS)
            call draw_firings(orbit, stream, truth%firings)
        end associate
        n = orbit%duration + LEAD
        allocate (truth%slow(QUANTITIES, -LEAD:n))
        stream = level1_stream(orbit, seed, run, FIELD)
        truth%slow(1:3, :) = orbit%position
        truth%slow(4:6, :) = orbit%field
        call add_field_error(orbit, stream, truth%slow(4:6, :))
        do k = -LEAD, n
            error_field = matmul(orbit%earth(:, :, k), truth%slow(4:6, k))
            truth%slow(4:6, k) = error_field
        end do
        truth%slow(7:9, :) = orbit%force
        truth%slow(10:12, :) = orbit%torque
        truth%slow(13:16, :) = orbit%held_quaternion
        truth%slow(17:19, :) = orbit%held_rate
        call integrate_attitude(truth)
        do k = 0, ubound(truth%state, 2), STEPS_PER_SECOND
            turn = quaternion_product(truth%state(4:7, k), conjugate_quaternion(orbit%held_quaternion(:, k/STEPS_PER_SECOND - &
                                                                                                     LEAD)))
            if (norm2(turn(1:3)) < FARTHEST/2) cycle
            call fail(error, 'the manoeuvre turns the satellite by more than 0.1 rad: less amplitude, shorter spans, or '// &
                      'whole cycles that begin at phase 0')
            return
        end do
    end subroutine new_level1_truth

    !> Firings between the spans at random times, and one in each of some spans, on the grid of the tags.
    subroutine draw_firings(orbit, stream, firings)
        type(level1_orbit_t), intent(in) :: orbit
        type(random_stream_t), intent(inout) :: stream
        type(firing_t), allocatable, intent(out) :: firings(:)

        real(dp), parameter :: APART = 2        ! s, from spans and each other
        type(firing_t) :: one
        real(dp) :: time
        integer :: i, inside
        logical :: near

        allocate (firings(0))
        inside = 0
        associate (interval => orbit%settings%firing_interval)
            time = 10
            do while (time < orbit%duration .and. interval(2) > 0)
                time = time + interval(1) + (interval(2) - interval(1))*stream%uniform()
                call draw(time)
                near = time > orbit%duration - 1
                do i = 1, size(orbit%spans)
                    associate (span => orbit%spans(i))
                        near = near .or. (time > span%start - APART .and. time < span%start + span%duration + APART)
                    end associate
                end do
                if (.not. near) firings = [firings, one]
            end do
        end associate
        do i = 1, min(orbit%settings%firings_inside, size(orbit%spans))
            associate (span => orbit%spans(i))
                call draw(span%start + span%duration*(0.2_dp + 0.6_dp*stream%uniform()))
            end associate
            inside = count(firings%time < one%time)
            firings = [firings(:inside), one, firings(inside + 1:)]
        end do

    contains

        subroutine draw(about)
            real(dp), intent(in) :: about   !! s

            one%time = nint(about/HOLD)*HOLD + FIRST_TAG
            one%pair = 1 + min(size(PAIRS, 2) - 1, int(size(PAIRS, 2)*stream%uniform()))
            one%mismatch = orbit%settings%thrust_mismatch*stream%normal()
        end subroutine draw
    end subroutine draw_firings

    !> An error of the field's model, Earth-fixed: for each component four waves over some thousand kilometres, of random
    !> direction and phase, that together have the sigma asked for.
    subroutine add_field_error(orbit, stream, field)
        type(level1_orbit_t), intent(in) :: orbit
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(inout) :: field(:, -LEAD:)     !! T

        integer, parameter :: WAVES = 4
        real(dp), parameter :: LENGTH = 8000e3_dp       ! m
        real(dp) :: direction(3), phase
        integer :: axis, wave, i, k

        do axis = 1, 3
            do wave = 1, WAVES
                do i = 1, 3
                    direction(i) = stream%normal()
                end do
                direction = TWO_PI/LENGTH*unit(direction)
                phase = TWO_PI*stream%uniform()
                do k = -LEAD, ubound(field, 2)
                    field(axis, k) = field(axis, k) + orbit%settings%field_error*sqrt(2.0_dp/WAVES)* &
                        cos(dot_product(direction, matmul(orbit%position(:, k), orbit%earth(:, :, k))) + phase)
                end do
            end do
        end do
    end subroutine add_field_error

    !> Steps of Runge and Kutta's fourth order, cut at every jump of a torque.
    subroutine integrate_attitude(truth)
        type(level1_truth_t), intent(inout) :: truth

        real(dp), allocatable :: breaks(:)
        real(dp) :: y(10), now, last, next
        integer :: k, steps

        call list_breaks(truth, breaks)
        steps = (truth%orbit%duration + 2*LEAD)*STEPS_PER_SECOND
        allocate (truth%state(10, 0:steps), truth%rates(10, 0:steps))
        y(1:3) = truth%orbit%held_rate(:, -LEAD)
        y(4:7) = truth%orbit%held_quaternion(:, -LEAD)
        y(8:10) = 0
        truth%state(:, 0) = y
        call attitude_rates(truth, -real(LEAD, dp), -LEAD + STEP/2, y, truth%rates(:, 0))
        do k = 1, steps
            now = (k - 1)*STEP - LEAD
            last = k*STEP - LEAD
            do while (now < last)
                next = min(last, next_break(truth, breaks, now))
                call step_attitude(truth, now, next, y)
                now = next
            end do
            y(4:7) = normalised(y(4:7))
            truth%state(:, k) = y
            call attitude_rates(truth, last, last - STEP/2, y, truth%rates(:, k))
        end do
    end subroutine integrate_attitude

    subroutine step_attitude(truth, from, to, y)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: from, to        !! s
        real(dp), intent(inout) :: y(10)

        real(dp) :: h, middle, k1(10), k2(10), k3(10), k4(10)

        h = to - from
        middle = from + h/2
        call attitude_rates(truth, from, middle, y, k1)
        call attitude_rates(truth, middle, middle, y + h/2*k1, k2)
        call attitude_rates(truth, middle, middle, y + h/2*k2, k3)
        call attitude_rates(truth, to, middle, y + h*k3, k4)
        y = y + h/6*(k1 + 2*k2 + 2*k3 + k4)
    end subroutine step_attitude

    !> Where torques jump, but for the steps of held currents: begin and end of spans and firings.
    subroutine list_breaks(truth, breaks)
        type(level1_truth_t), intent(in) :: truth
        real(dp), allocatable, intent(out) :: breaks(:)     !! s

        integer :: i

        allocate (breaks(0))
        do i = 1, size(truth%orbit%spans)
            associate (span => truth%orbit%spans(i), delay => truth%orbit%settings%torque_delay)
                breaks = [breaks, span%start + delay, span%start + span%duration + delay]
            end associate
        end do
        do i = 1, size(truth%firings)
            breaks = [breaks, truth%firings(i)%time, truth%firings(i)%time + FIRING_TIME]
        end do
    end subroutine list_breaks

    pure real(dp) function next_break(truth, breaks, now) result(time)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: breaks(:), now      !! s

        real(dp), parameter :: NEAR = 1e-9_dp       ! s
        real(dp) :: tag

        time = huge(time)
        if (size(breaks) > 0) time = minval(breaks, mask=breaks > now + NEAR)
        if (.not. truth%orbit%settings%staircase) return
        associate (delay => truth%orbit%settings%torque_delay)
            tag = held_tag(truth%obc_of_gps(now - delay + NEAR))
            time = min(time, truth%gps_of_obc(tag + HOLD) + delay)
        end associate
    end function next_break

    !> The tag of the currents that are held at a time of the on-board computer.
    pure real(dp) function held_tag(time) result(tag)
        real(dp), intent(in) :: time    !! s

        real(dp), parameter :: NEAR = 1e-7_dp   ! s

        tag = floor((time - FIRST_TAG)/HOLD + NEAR)*HOLD + FIRST_TAG
    end function held_tag

    !> d/dt of rate, attitude and angle. Currents and firings are those of the piece of time in which `within` lies.
    subroutine attitude_rates(truth, time, within, y, dydt)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: time, within    !! s
        real(dp), intent(in) :: y(10)
        real(dp), intent(out) :: dydt(10)

        real(dp) :: slow(QUANTITIES), torque(3)

        call interpolate_slow(truth, time, slow)
        torque = torque_at(truth, time, slow, flowing_current(truth, time, within), y(1:3), y(4:7), &
                           truth%firing_share(within, 0.0_dp))
        dydt(1:3) = euler_acceleration(truth, torque, y(1:3))
        dydt(4:7) = quaternion_rate(y(4:7), y(1:3))
        dydt(8:10) = y(1:3)
    end subroutine attitude_rates

    !> J^-1 (T - w x J w), rad/s^2.
    pure function euler_acceleration(truth, torque, rate) result(acceleration)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: torque(3), rate(3)      !! N m, rad/s
        real(dp) :: acceleration(3)

        real(dp) :: momentum(3)

        momentum = matmul(truth%inertia, rate)
        acceleration = torque - cross(rate, momentum)
        acceleration = matmul(truth%inverse, acceleration)
    end function euler_acceleration

    !> All torques, N m.
    pure function torque_at(truth, time, slow, current, rate, quaternion, firing) result(torque)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: time            !! s
        real(dp), intent(in) :: slow(QUANTITIES), current(3), rate(3), quaternion(4)
        real(dp), intent(in) :: firing(2, 4)    !! Share of each pair; and its mismatch
        real(dp) :: torque(3)

        real(dp) :: c(3, 3), up(3), turn(4), r, share
        integer :: i, k

        c = rotation_matrix(quaternion/norm2(quaternion))
        r = norm2(slow(1:3))
        up = matmul(c, slow(1:3)/r)
        torque = cross(truth%gain*current, matmul(c, slow(4:6))) + gravity_gradient_torque(EARTH_GM, r, up, truth%inertia) + &
            slow(10:12)
        do k = 1, 4
            if (.not. firing(1, k) > 0) cycle
            do i = 1, 2
                torque = torque + firing(1, k)*cross(PLACES(:, i, k), [0.0_dp, FORCES(i, k), 0.0_dp])
            end do
        end do
        share = control_share(truth, time)
        if (.not. share > 0) return
        turn = quaternion_product(quaternion, conjugate_quaternion(slow(13:16)))
        if (turn(4) < 0) turn = -turn
        torque = torque - share*matmul(truth%inertia, BANDWIDTH**2*2*turn(1:3) + &
                                       2*BANDWIDTH*(rate - matmul(rotation_matrix(turn/norm2(turn)), slow(17:19))))
    end function torque_at

    !> How much the controller acts: 0 in and around the spans.
    pure real(dp) function control_share(truth, time) result(share)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: time        !! s

        real(dp) :: away
        integer :: i

        share = 1
        do i = 1, size(truth%orbit%spans)
            associate (span => truth%orbit%spans(i))
                away = max(span%start - FREE - time, time - span%start - span%duration - FREE)
            end associate
            away = max(0.0_dp, min(1.0_dp, away/TAKE_OVER))
            share = min(share, away**3*(10 - 15*away + 6*away**2))
        end do
    end function control_share

    !> Which thrusters fire: the share of a window that each pair does, 1 or 0 of an instant; and its mismatch.
    pure function firing_share(self, time, window) result(share)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s
        real(dp), intent(in) :: window      !! About it, s; 0: an instant
        real(dp) :: share(2, 4)

        real(dp) :: overlap
        integer :: i

        share = 0
        do i = 1, size(self%firings)
            associate (firing => self%firings(i))
                overlap = min(time + window/2, firing%time + FIRING_TIME) - max(time - window/2, firing%time)
                if (overlap < 0) cycle
                share(1, firing%pair) = merge(overlap/max(window, tiny(window)), 1.0_dp, window > 0)
                share(2, firing%pair) = firing%mismatch
            end associate
        end do
    end function firing_share

    !> Cubic through the four nearest seconds.
    pure subroutine interpolate_slow(truth, time, slow)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: time        !! s
        real(dp), intent(out) :: slow(QUANTITIES)

        real(dp) :: u, weight(4)
        integer :: k

        k = max(-LEAD + 1, min(truth%orbit%duration + LEAD - 2, floor(time)))
        u = time - k
        weight = [-u*(u - 1)*(u - 2)/6, (u + 1)*(u - 1)*(u - 2)/2, -(u + 1)*u*(u - 2)/2, (u + 1)*u*(u - 1)/6]
        slow = matmul(truth%slow(:, k - 1:k + 2), weight)
    end subroutine interpolate_slow

    !> The span that a time lies in; 0: none.
    pure integer function in_span(self, time) result(number)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s

        do number = size(self%orbit%spans), 1, -1
            associate (span => self%orbit%spans(number))
                if (time >= span%start .and. time < span%start + span%duration) return
            end associate
        end do
    end function in_span

    !> The currents that flow: those of a tag, later by the delay.
    pure function flowing_current(truth, time, within) result(current)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: time        !! s
        real(dp), intent(in) :: within      !! The piece of time between two jumps is that of this one
        real(dp) :: current(3)

        real(dp) :: tag

        associate (delay => truth%orbit%settings%torque_delay)
            if (truth%orbit%settings%staircase) then
                tag = truth%gps_of_obc(held_tag(truth%obc_of_gps(within - delay)))
                current = commanded(truth, tag, tag)
            else
                current = commanded(truth, time - delay, within - delay)
            end if
        end associate
    end function flowing_current

    !> The currents that a tag names.
    pure function tagged_current(self, time) result(current)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! Of the tag, s
        real(dp) :: current(3)

        current = commanded(self, time, time)
    end function tagged_current

    !> Sines or squares in a span, slow currents between.
    pure function commanded(truth, time, within) result(current)
        type(level1_truth_t), intent(in) :: truth
        real(dp), intent(in) :: time, within    !! s
        real(dp) :: current(3)

        integer :: number

        number = truth%in_span(within)
        if (number == 0) then
            current = truth%orbit%settings%science_current*(0.5_dp*sin(TWO_PI*(time/SLOWEST(1) + truth%science(1, :))) + &
                                                            0.3_dp*sin(TWO_PI*(time/SLOWEST(2) + truth%science(2, :))) + &
                                                            0.2_dp*(2*truth%science(3, :) - 1))
            return
        end if
        associate (span => truth%orbit%spans(number))
            current = sin(TWO_PI*span%cycles*(time - span%start)/span%duration + span%phase)
            if (truth%orbit%settings%waveform == 'square') current = sign(1.0_dp, current)
            current = span%amplitude*current
        end associate
    end function commanded

    !> Time of the on-board computer, s from the beginning of the files, at a GPS time.
    elemental real(dp) function obc_of_gps(self, time) result(obc)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s

        obc = (time - self%clock_offset)/(1 + self%clock_drift)
    end function obc_of_gps

    !> GPS time, s from the beginning of the files, at a time of the on-board computer.
    elemental real(dp) function gps_of_obc(self, time) result(gps)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s

        gps = time + self%clock_offset + self%clock_drift*time
    end function gps_of_obc

    !> Rate, attitude and angle: the cubic of Hermite between two steps.
    pure subroutine motion(self, time, rate, quaternion, angle)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time            !! s
        real(dp), intent(out) :: rate(3)        !! rad/s
        real(dp), intent(out) :: quaternion(4)  !! Inertial to body, scalar last
        real(dp), intent(out) :: angle(3)       !! rad

        real(dp) :: y(10), u
        integer :: k

        k = max(0, min(ubound(self%state, 2) - 1, floor((time + LEAD)/STEP)))
        u = (time + LEAD)/STEP - k
        y = (1 + 2*u)*(1 - u)**2*self%state(:, k) + u**2*(3 - 2*u)*self%state(:, k + 1) + &
            STEP*(u*(1 - u)**2*self%rates(:, k) - u**2*(1 - u)*self%rates(:, k + 1))
        rate = y(1:3)
        quaternion = normalised(y(4:7))
        angle = y(8:10)
    end subroutine motion

    !> Everything at an instant.
    subroutine at(self, time, point)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s
        type(truth_point_t), intent(out) :: point

        real(dp), parameter :: SAMPLE = 0.1_dp      ! Over which an accelerometer's sample sees jumps, s
        real(dp) :: slow(QUANTITIES), c(3, 3), share(2, 4), torque(3), force(3), r
        type(pmc_acceleration_t) :: sensed

        call self%motion(time, point%rate, point%quaternion, point%angle)
        call interpolate_slow(self, time, slow)
        c = rotation_matrix(point%quaternion)
        point%field = matmul(c, slow(4:6))
        point%current = flowing_current(self, time, time)
        point%current_rate = (flowing_current(self, time + SAMPLE/2, time + SAMPLE/2) - &
                              flowing_current(self, time - SAMPLE/2, time - SAMPLE/2))/SAMPLE
        share = self%firing_share(time, SAMPLE)
        torque = torque_at(self, time, slow, point%current, point%rate, point%quaternion, share)
        point%acceleration = euler_acceleration(self, torque, point%rate)
        force = slow(7:9)
        if (self%wave%amplitude > 0) force = force + self%orbit%drag(:, max(-LEAD, min(ubound(self%orbit%drag, 2), &
                                                                           nint(time))))*self%wave%relative_change(time)
        force(2) = force(2) + sum(share(1, :)*share(2, :))*FORCES(1, 1)/self%orbit%case%satellite%mass
        r = norm2(slow(1:3))
        sensed = pmc_acceleration(point%rate, point%acceleration, self%offset, matmul(c, slow(1:3)/r), EARTH_GM, r, force)
        point%sensed = sensed%total
    end subroutine at
end module gracecg_level1_simulated_truth
