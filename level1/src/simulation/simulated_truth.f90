!> The truth behind simulated Level-1 files: one run of hours of flight with sub-manoeuvres of the torque rods.
!>
!> It is that of `simulate`: orbit and attitude of a case with all its forces and torques (gracecg_simulation_dynamics),
!> known at every time (gracecg_simulation_arc), and what a day has besides (gracecg_level1_day_dynamics).
!> Inertial axes are those of J2000; Earth-fixed ones follow by precession and nutation, and the orbit of a case is
!> taken to be in them.
module gracecg_level1_simulated_truth
    use gracecg_level1_basics
    use gracecg_base_constants, only: EARTH_GM
    use gracecg_base_quaternion, only: quaternion_of_matrix, quaternion_from_axis_angle
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_base_vectors, only: identity, unit
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    use gracecg_environment_space_weather, only: space_weather_source_t
    use gracecg_environment_time, only: GPS_EPOCH, seconds_between, parse_utc, utc_text
    use gracecg_simulation_accelerometer, only: pmc_acceleration, pmc_acceleration_t
    use gracecg_simulation_arc, only: DEFAULT_TOLERANCE, dense_arc_t, fly_densely
    use gracecg_simulation_attitude_control, only: orbital_axes
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_case_models, only: build_dynamics
    use gracecg_simulation_dynamics, only: loads_t, POSITION, OMEGA, ATTITUDE, STATE_SIZE
    use gracecg_level1_day_dynamics, only: day_dynamics_t, firing_t, PAIRS
    use gracecg_level1_simulation_settings, only: level1_settings_t, span_list, by_satellite
    implicit none
    private
    public :: level1_truth_t, level1_errors_t, truth_point_t, new_level1_truth, HOLD, FIRST_TAG, disturb_field

    integer, parameter :: LEAD = 4
    ! Seconds of truth before the files and after them: more than clocks and delays (up to 1 and 2 s) take tags away from them
    real(dp), parameter :: HOLD = 0.5_dp            !! From tag to tag of the currents, s of the on-board computer: GRACE-FO
    real(dp), parameter :: FIRST_TAG = 0.1_dp       !! Of them within a second of the on-board computer, s: GRACE-FO C, 2023-06-01
    real(dp), parameter :: SAMPLE = 0.1_dp          ! over which an accelerometer's sample sees jumps, s: its interval

    !> Sources of random numbers of a run that the truth draws from; the files' own follow
    integer, parameter :: GAINS = 1, CURRENTS = 2, THRUSTERS = 3, AIR = 4, FIELD = 5, ERRORS = 16, ALIGNMENT = 18

    type :: level1_errors_t
        !! What is drawn of the instruments of a run
        real(dp) :: scale(3) = 1            !! Of the accelerometer
        real(dp) :: angular_scale(3) = 1    !! Of its angular channels
        real(dp) :: leak(3, 3) = 0          !! L: axis, rod; m/s^2/mA
        real(dp) :: leak_rate(3, 3) = 0     !! K, m/s^2/(mA/s)
        real(dp) :: angular_leak(3, 3) = 0  !! La, rad/s^2/mA
        real(dp) :: angular_leak_rate(3, 3) = 0     !! Ka, rad/s^2/(mA/s)
        real(dp) :: gyro_bias(3) = 0        !! rad/s
        real(dp), allocatable :: alignment(:, :)    !! Turn of the accelerometer's axes against SRF, (axis, span), rad
        real(dp) :: inertia_factor = 1      !! What is said of the inertia, by the true one
    end type level1_errors_t

    type :: truth_point_t
        !! Everything at one instant
        real(dp) :: state(STATE_SIZE) = 0   !! See gracecg_simulation_dynamics
        type(loads_t) :: acting             !! Forces and torques; jumps of thrusters as a sample sees them
        real(dp) :: acceleration(3) = 0     !! Angular, body axes, rad/s^2
        real(dp) :: current(3) = 0          !! That flows, mA
        real(dp) :: current_rate(3) = 0     !! Mean over a sample of the accelerometer, mA/s
        real(dp) :: sensed(3) = 0           !! Linear acceleration at the proof mass, body axes, m/s^2
    end type truth_point_t

    type :: level1_truth_t
        !! The flight of one run. Times are GPS, s from the beginning of the files
        type(case_t) :: case                !! That is flown
        type(level1_settings_t) :: settings     !! What is flown and measured wrongly
        integer(i8) :: seed = 1             !! Of the random numbers
        integer :: run = 1                  !! Names them, too
        character(1) :: satellite = 'C'     !! A to D
        integer(i8) :: epoch = 0            !! The beginning of the files, GPS s past 2000-01-01 12:00
        integer :: duration = 0             !! Of the files, s
        character(:), allocatable :: remark !! What is to be known of the epoch
        real(dp) :: clock_offset = 0, clock_drift = 0   !! GPS less receiver time at the epoch, s; s/s
        type(level1_errors_t) :: errors     !! Of the instruments
        type(day_dynamics_t) :: dynamics    !! With gains, currents and firings of the run
        type(dense_arc_t) :: arc            !! Orbit and attitude
    contains
        procedure :: stream                 !! Random numbers of a source
        procedure :: at                     !! Everything at an instant
        procedure :: tagged_current         !! The currents that a tag names
        procedure :: control_at             !! The controller's
        procedure :: offset_at              !! d
        procedure :: as_aligned             !! A vector in the accelerometer's axes
        procedure :: obc_of_gps             !! Time of the on-board computer
        procedure :: gps_of_obc             !! And back
    end type level1_truth_t

    !> Waves of a component, and the length of each, m: chosen. Some waves for no pattern; so long that the error is one vector
    !> along a span of a minute (460 km), as estimates take it, and another one from span to span
    integer, parameter :: WAVES = 4
    real(dp), parameter :: LENGTH = 8000e3_dp

    !> For each Earth-fixed component waves over some thousand kilometres.
    type, extends(geomagnetic_model_t) :: disturbed_field_t
        class(geomagnetic_model_t), allocatable :: model
        real(dp) :: amplitude = 0                   !! Of a wave, T
        real(dp) :: vector(3, WAVES, 3) = 0         !! Wave vectors, Earth-fixed, rad/m
        real(dp) :: phase(WAVES, 3) = 0             !! rad
    contains
        procedure :: evaluate                       !! Model and waves
    end type disturbed_field_t

contains

    !> A stream of random numbers of its own for each source of errors of a run.
    pure type(random_stream_t) function stream(self, source)
        class(level1_truth_t), intent(in) :: self
        integer, intent(in) :: source       !! Of errors: a number of its own

        integer, parameter :: FIRST = 100   !! Instruments of observation sets have smaller numbers

        stream = new_stream(self%seed, self%case%label(), self%case%satellite%place(), self%run, FIRST + source)
    end function stream

    !> Flies a case for the time of the files, from the whole GPS second next to the case's epoch. Fails as the models of
    !> the case do, and when the attitude does not stay near the one that is held.
    subroutine new_level1_truth(case, settings, seed, run, truth, error)
        type(case_t), intent(in) :: case
        type(level1_settings_t), intent(in) :: settings
        integer(i8), intent(in) :: seed         !! Of the random numbers
        integer, intent(in) :: run              !! Names them, too
        type(level1_truth_t), intent(out) :: truth
        type(error_t), allocatable, intent(out) :: error

        truth%case = case
        truth%settings = settings
        truth%seed = seed
        truth%run = run
        truth%satellite = settings%satellite
        if (truth%satellite == '') truth%satellite = merge('C', 'D', case%satellite%place() == 1)
        call span_list(settings, truth%dynamics%spans)
        if (case%satellite%rods%direct) then
            call fail(error, 'case '//trim(case%name)//': torquers (groups &torquers, &excitation); Level-1 files know rods alone')
            return
        end if
        call choose_time(truth, error)
        if (allocated(error)) return
        call draw_satellite(truth)
        call fly(truth, error)
        call add_context(error, 'case '//trim(case%name))
    end subroutine new_level1_truth

    !> Epoch and duration of the files, and what of the case's models hangs on them. Level-1 files count from 2000 on: a
    !> case before that is taken to a later date.
    subroutine choose_time(truth, error)
        type(level1_truth_t), intent(inout) :: truth
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: AFTER = 300      ! s, behind the last span, as before the first: quiet time for noise and clocks
        type(utc_t), parameter :: LATER = utc_t(58880, 0.0_dp)      ! 2020-02-01, a day of GRACE-FO that IGRF-14 holds

        associate (case => truth%case, settings => truth%settings, spans => truth%dynamics%spans)
            if (settings%epoch /= '') then
                call parse_utc(trim(settings%epoch), case%epoch, error)
                if (allocated(error)) return
            else if (seconds_between(GPS_EPOCH, case%epoch) < 0) then
                truth%remark = 'the case is of '//utc_text(case%epoch)//'; Level-1 files count from 2000 on: it is taken to '// &
                               utc_text(LATER)//' (the key epoch of level1_simulation says otherwise)'
                case%epoch = LATER
            end if
            truth%epoch = nint(seconds_between(GPS_EPOCH, case%epoch), i8)
            if (truth%epoch < 0) then
                call fail(error, 'epoch '//trim(settings%epoch)//' is before 2000-01-01 12:00 GPS, from which Level-1 files count')
                return
            end if
            case%epoch = utc_of_gps(truth%epoch, 0.0_dp)
            truth%duration = nint(settings%duration)
            if (truth%duration == 0) then
                truth%duration = nint(AFTER)
                if (size(spans) > 0) truth%duration = ceiling(maxval(spans%start + spans%duration) + AFTER)
            end if
            case%earth_rotation = 'gmst-1982'
            case%earth_orientation = 'iau'
            if (case%field_model /= 'file') case%field_model = 'igrf14'
        end associate
        call choose_space_weather(truth)
    end subroutine choose_time

    !> Flux and Kp of the case where the embedded table does not hold the time of the files: they act on the air alone.
    subroutine choose_space_weather(truth)
        type(level1_truth_t), intent(inout) :: truth

        type(space_weather_source_t) :: source
        type(error_t), allocatable :: at_begin, at_end
        real(dp) :: f107, f107_mean, kp

        if (truth%case%space_weather /= 'table') return
        call source%indices_at(utc_plus(truth%case%epoch, -real(LEAD, dp)), f107, f107_mean, kp, at_begin)
        call source%indices_at(utc_plus(truth%case%epoch, real(truth%duration + 2*LEAD, dp)), f107, f107_mean, kp, at_end)
        if (.not. (allocated(at_begin) .or. allocated(at_end))) return
        truth%case%space_weather = 'given'
        if (.not. allocated(truth%remark)) truth%remark = 'the files are of '//utc_text(truth%case%epoch)
        truth%remark = truth%remark//'; f107 and kp of the case act, for the table of space weather does not hold that time'
    end subroutine choose_space_weather

    !> What is drawn of clocks, rods, currents, thrusters, air and instruments.
    subroutine draw_satellite(truth)
        type(level1_truth_t), intent(inout) :: truth

        !> s, A to D: CLK1B of 2003-09-14 and 2023-06-01
        real(dp), parameter :: CLOCKS(4) = [-75.4e-3_dp, -2.9e-3_dp, -16.667e-3_dp, -17.256e-3_dp]
        real(dp), parameter :: NONE_GIVEN = -1  ! s: no clock is farther off
        type(random_stream_t) :: random
        real(dp) :: normal(3)
        integer :: i, k

        associate (settings => truth%settings, flight => truth%dynamics)
            truth%clock_offset = settings%clock_offset
            if (truth%clock_offset < NONE_GIVEN) truth%clock_offset = by_satellite(truth%satellite, CLOCKS)
            truth%clock_drift = settings%clock_drift
            flight%tag = truth%gps_of_obc(FIRST_TAG)
            flight%tag_interval = HOLD*(1 + truth%clock_drift)
            flight%settings = settings
            random = truth%stream(GAINS)
            call random%normals(normal)
            flight%gain = settings%rod_gain*(1 + settings%rod_gain_error*normal)
            random = truth%stream(CURRENTS)
            do k = 1, 3
                do i = 1, 3
                    flight%science(i, k) = random%uniform()
                end do
            end do
            random = truth%stream(AIR)
            if (truth%case%density_wave_random) truth%case%density_wave%phase = TWO_PI*random%uniform()
            truth%case%density_wave_random = .false.
            if (.not. settings%density_wave) truth%case%density_wave%amplitude = 0
            random = truth%stream(THRUSTERS)
            call draw_firings(truth, random, flight%firings)
            random = truth%stream(ERRORS)
            call draw_errors(settings, random, truth%errors)
            random = truth%stream(ALIGNMENT)
            allocate (truth%errors%alignment(3, size(flight%spans)))
            do k = 1, size(flight%spans)
                call random%normals(normal)
                truth%errors%alignment(:, k) = settings%alignment*normal
            end do
        end associate
    end subroutine draw_satellite

    !> Firings between the spans at random times, and one in each of some spans, on the grid of the tags.
    subroutine draw_firings(truth, random, firings)
        type(level1_truth_t), intent(in) :: truth
        type(random_stream_t), intent(inout) :: random
        type(firing_t), allocatable, intent(out) :: firings(:)

        real(dp), parameter :: APART = 2        ! s, from spans and each other: no sample sees two of them
        real(dp), parameter :: FIRST = 10       ! s: no firing before it
        real(dp), parameter :: BEFORE = 0.2_dp, MIDDLE = 0.6_dp     ! parts of a span: a firing in it falls into its middle
        type(firing_t) :: one
        real(dp) :: time
        integer :: i, inside

        allocate (firings(0))
        associate (interval => truth%settings%firing_interval, spans => truth%dynamics%spans)
            time = FIRST
            do while (time < truth%duration .and. interval(2) > 0)
                time = time + max(APART, interval(1) + (interval(2) - interval(1))*random%uniform())
                call draw(time)
                if (time > truth%duration - 1 .or. any(time > spans%start - APART .and. &
                                                       time < spans%start + spans%duration + APART)) cycle
                firings = [firings, one]
            end do
            do i = 1, min(truth%settings%firings_inside, size(spans))
                call draw(spans(i)%start + spans(i)%duration*(BEFORE + MIDDLE*random%uniform()))
                inside = count(firings%time < one%time)
                firings = [firings(:inside), one, firings(inside + 1:)]
            end do
        end associate

    contains

        subroutine draw(about)
            real(dp), intent(in) :: about   !! s

            one%time = nint(about/HOLD)*HOLD + FIRST_TAG
            one%pair = 1 + min(size(PAIRS, 2) - 1, int(size(PAIRS, 2)*random%uniform()))
            one%mismatch = truth%settings%thrust_mismatch*random%normal()
        end subroutine draw
    end subroutine draw_firings

    !> Draws what instruments of a run have wrong.
    subroutine draw_errors(settings, random, errors)
        type(level1_settings_t), intent(in) :: settings
        type(random_stream_t), intent(inout) :: random
        type(level1_errors_t), intent(out) :: errors

        integer :: axis, rod

        do axis = 1, 3
            errors%scale(axis) = 1 + settings%scale_error*random%normal()
            errors%angular_scale(axis) = 1 + settings%angular_scale_error*random%normal()
            errors%gyro_bias(axis) = settings%gyro_bias*random%normal()
            do rod = 1, 3
                errors%leak(axis, rod) = settings%leakage(1)*random%normal()
                errors%leak_rate(axis, rod) = settings%leakage(2)*random%normal()
                errors%angular_leak(axis, rod) = settings%angular_leakage(1)*random%normal()
                errors%angular_leak_rate(axis, rod) = settings%angular_leakage(2)*random%normal()
            end do
        end do
        errors%inertia_factor = 1 + settings%inertia_error*random%normal()
    end subroutine draw_errors

    !> Orbit and attitude, from nadir with the pitch that is held, body x along the orbit (back) or against it (front).
    subroutine fly(truth, error)
        type(level1_truth_t), intent(inout) :: truth
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: FARTHEST = 0.1_dp            ! rad: far beyond the degree that a manoeuvre is allowed
        type(random_stream_t) :: random
        real(dp) :: attitude(3, 3), state(STATE_SIZE)
        integer :: k

        associate (case => truth%case, flight => truth%dynamics)
            call build_dynamics(case, flight%satellite_dynamics_t, error)
            if (allocated(error)) return
            random = truth%stream(FIELD)
            call disturb_field(truth%settings%field_error, random, flight%field)
            flight%control%frequency = truth%settings%control_frequency
            attitude = identity(3)
            if (case%satellite%place() == 1) attitude(:2, :) = -attitude(:2, :)
            flight%control%body_from_orbit = matmul(rotation_matrix(quaternion_from_axis_angle( &
                                                    [0.0_dp, 1.0_dp, 0.0_dp], -truth%settings%pitch)), attitude)
            attitude = matmul(flight%control%body_from_orbit, orbital_axes(case%position, case%velocity))
            state = [case%position, case%velocity, matmul(attitude, cross(case%position, case%velocity))/ &
                     dot_product(case%position, case%position), quaternion_of_matrix(attitude)]
            call fly_densely(flight, state, -real(LEAD, dp), real(truth%duration + LEAD, dp), DEFAULT_TOLERANCE, truth%arc, error)
            if (allocated(error)) return
            do k = 0, truth%duration
                if (all(abs(flight%control%turn(truth%arc%state_at(real(k, dp))) - identity(3)) < FARTHEST)) cycle
                call fail(error, 'the manoeuvre turns the satellite by more than 0.1 rad: less amplitude, shorter spans, or '// &
                          'whole cycles that begin at phase 0')
                return
            end do
            flight%window = SAMPLE
        end associate
    end subroutine fly

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

    !> Everything at an instant.
    pure subroutine at(self, time, point)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s
        type(truth_point_t), intent(out) :: point

        real(dp) :: force(3)
        type(pmc_acceleration_t) :: sensed

        point%state = self%arc%state_at(time)
        associate (flight => self%dynamics, acting => point%acting, rate => point%state(OMEGA))
            call flight%loads(time, point%state, acting)
            point%acceleration = flight%angular_acceleration(rate, acting)
            point%current = flight%flowing_current(time) + flight%control_current(time, point%state)
            point%current_rate = (flight%flowing_current(time + SAMPLE/2) - flight%flowing_current(time - SAMPLE/2) + &
                                  self%control_at(time + SAMPLE/2) - self%control_at(time - SAMPLE/2))/SAMPLE
            force = acting%drag + acting%srp + acting%erp
            force(2) = force(2) + flight%thrust(time)/flight%mass
            sensed = pmc_acceleration(rate, point%acceleration, self%offset_at(time), acting%vertical, EARTH_GM, &
                                      norm2(point%state(POSITION)), force)
        end associate
        point%sensed = sensed%total
    end subroutine at

    !> The currents that a tag names: those that flow later by the delay.
    pure function tagged_current(self, time) result(current)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! Of the tag, s
        real(dp) :: current(3)              !! mA

        current = self%dynamics%tagged_current(time) + self%control_at(time + self%settings%torque_delay)
    end function tagged_current

    !> The controller's currents.
    pure function control_at(self, time) result(current)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s
        real(dp) :: current(3)              !! mA

        current = self%dynamics%control_current(time, self%arc%state_at(time))
    end function control_at

    !> The offset at a time, body axes.
    pure function offset_at(self, time) result(offset)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s
        real(dp) :: offset(3)               !! m

        offset = self%case%satellite%offset + self%settings%drift*(time - self%duration/2.0_dp)
        if (self%settings%moved_at > 0 .and. time >= self%settings%moved_at) offset = offset + self%settings%moved
    end function offset_at

    !> A vector of SRF as the accelerometer's axes see it, turned by the small angles of the span that is nearest.
    pure function as_aligned(self, time, vector) result(seen)
        class(level1_truth_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s
        real(dp), intent(in) :: vector(3)   !! Of any unit, SRF
        real(dp) :: seen(3)                 !! Likewise, axes of the accelerometer

        seen = vector
        if (size(self%errors%alignment, 2) == 0) return
        associate (spans => self%dynamics%spans)
            seen = vector - cross(self%errors%alignment(:, minloc(abs(spans%start + spans%duration/2 - time), 1)), vector)
        end associate
    end function as_aligned

    !> Puts waves of random direction and phase on a model, that together have the sigma asked for.
    subroutine disturb_field(sigma, stream, field)
        real(dp), intent(in) :: sigma               !! Of each component, T
        type(random_stream_t), intent(inout) :: stream
        class(geomagnetic_model_t), allocatable, intent(inout) :: field

        type(disturbed_field_t), allocatable :: disturbed
        integer :: axis, wave

        allocate (disturbed)
        disturbed%amplitude = sigma*sqrt(2.0_dp/WAVES)
        do axis = 1, 3
            do wave = 1, WAVES
                call stream%normals(disturbed%vector(:, wave, axis))
                disturbed%vector(:, wave, axis) = TWO_PI/LENGTH*unit(disturbed%vector(:, wave, axis))
                disturbed%phase(wave, axis) = TWO_PI*stream%uniform()
            end do
        end do
        call move_alloc(field, disturbed%model)
        call move_alloc(disturbed, field)
    end subroutine disturb_field

    pure subroutine evaluate(self, position, b)
        class(disturbed_field_t), intent(in) :: self
        real(dp), intent(in) :: position(3)     !! Earth-fixed, m
        real(dp), intent(out) :: b(3)           !! Earth-fixed, T

        integer :: axis

        call self%model%evaluate(position, b)
        do axis = 1, 3
            b(axis) = b(axis) + self%amplitude*sum(cos(matmul(position, self%vector(:, :, axis)) + self%phase(:, axis)))
        end do
    end subroutine evaluate
end module gracecg_level1_simulated_truth
