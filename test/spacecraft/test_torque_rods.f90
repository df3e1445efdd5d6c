!> The manoeuvre of the torque rods.
module test_torque_rods
    use vocabulary
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series, series_moments, check_moments_cover
    use gracecg_spacecraft_rod_pattern, only: rod_pattern
    use gracecg_spacecraft_torque_rods
    implicit none
    private
    public :: collect_torque_rods

    !> Field at the start of the report's six cases (front 1-3, back 1-3) in body axes, nT: IGRF at
    !> 1989.0 and the positions and attitudes of CSR-TM-00-01 sections 5.2 and 6.1, rounded
    real(dp), parameter :: FIELD(3, 6) = reshape( &
                           [-24390.0_dp, -3560.0_dp, 7490.0_dp, &
                            2370.0_dp, 640.0_dp, 46320.0_dp, &
                            30210.0_dp, -1330.0_dp, 2310.0_dp, &
                            24510.0_dp, 3640.0_dp, 4830.0_dp, &
                            -420.0_dp, -440.0_dp, 46430.0_dp, &
                            -30120.0_dp, 1140.0_dp, 5890.0_dp], [3, 6])

contains

    subroutine collect_torque_rods(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('pattern-makes-torques-add', test_torques_add), &
                    new_unittest('general-rule', test_general_rule), &
                    new_unittest('zero-and-undefined-field', test_zero_field), &
                    new_unittest('several-activations', test_several), &
                    new_unittest('all-times-at-once', test_all_times), &
                    new_unittest('edges-in-turn', test_rod_edges), &
                    new_unittest('refuses-impossible', test_refuses), &
                    new_unittest('limit-counts-what-is-active', test_limit), &
                    new_unittest('waveforms', test_waveforms), &
                    new_unittest('square-has-smooth-edges', test_edges), &
                    new_unittest('sampling-limit', test_sampling), &
                    new_unittest('rods-that-are-off', test_off), &
                    new_unittest('measured-moments', test_measured), &
                    new_unittest('held-moments', test_held_moments), &
                    new_unittest('refuses-impossible-measurements', test_refused_measurements)]
    end subroutine collect_torque_rods

    !> The torque m x B about x is |B_y| + |B_z|, the most that m_y, m_z = +-1 can give.
    subroutine test_torques_add(error)
        type(error_type), allocatable, intent(out) :: error
        integer :: i, m(3)

        do i = 1, 6
            m = rod_pattern('y-z', FIELD(:, i))
            call check(error, abs(m(2)*FIELD(3, i) - m(3)*FIELD(2, i)), abs(FIELD(2, i)) + abs(FIELD(3, i)))
        end do
    end subroutine test_torques_add

    !> All orders and signs of three magnitudes.
    subroutine test_general_rule(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ORDERS(3, 6) = reshape( &
                              [1, 2, 3, 1, 3, 2, 2, 1, 3, 2, 3, 1, 3, 1, 2, 3, 2, 1], [3, 6])
        real(dp) :: b(3)
        integer :: k, signs, m(3)

        do k = 1, 6
            do signs = 0, 7
                b(ORDERS(1, k)) = 300*(1 - 2*ibits(signs, 0, 1))
                b(ORDERS(2, k)) = 200*(1 - 2*ibits(signs, 1, 1))
                b(ORDERS(3, k)) = 100*(1 - 2*ibits(signs, 2, 1))
                m = rod_pattern('general', b)
                call check(error, m(ORDERS(1, k)), 0)
                call check(error, m(ORDERS(3, k)), 1)
                call check(error, m(ORDERS(2, k)), -nint(sign(1.0_dp, b(ORDERS(2, k))*b(ORDERS(3, k)))))
            end do
        end do
    end subroutine test_general_rule

    !> sign(0) = 0; NaN gives the empty pattern, and the manoeuvre refuses that.
    subroutine test_zero_field(error)
        type(error_type), allocatable, intent(out) :: error
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        real(dp) :: undefined(3)

        call check(error, all(rod_pattern('y-z', [1.0_dp, 0.0_dp, 2.0_dp]) == [0, 0, 1]))
        call check(error, all(rod_pattern('general', [1.0_dp, 1.0_dp, 1.0_dp]) == [0, -1, 1]))
        undefined = NAN
        call check(error, all(rod_pattern('y-z', undefined) == 0))
        call check(error, all(rod_pattern('general', undefined) == 0))
        call new_harmonic_manoeuvre(rod_pattern('y-z', undefined), 30.0_dp, 0.1_dp, 0.0_dp, 60.0_dp, rods, failure)
        call check_fails(error, failure, 'pattern')
    end subroutine test_zero_field

    !> The moments at equal times are those at each time: every waveform, rods that begin and end between the times,
    !> late, strong and misaligned.
    subroutine test_all_times(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 12000
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        real(dp) :: moment(3, 0:N), largest
        integer :: k

        call new_torque_rods([rod_activation_t(axis=1, amplitude=12.0_dp, frequency=0.13_dp, phase=0.4_dp, start=0.0_dp, &
                              stop=600.0_dp), &
                              rod_activation_t(axis=1, amplitude=10.0_dp, frequency=0.07_dp, start=3.33_dp, stop=500.0_dp, &
                              waveform=COSINE), &
                              rod_activation_t(axis=2, amplitude=30.0_dp, frequency=0.2_dp, start=10.01_dp, stop=590.0_dp, &
                              waveform=TAPERED, taper=5.0_dp), &
                              rod_activation_t(axis=3, amplitude=25.0_dp, frequency=0.05_dp, start=0.0_dp, stop=600.0_dp, &
                              waveform=SQUARE, rise_time=1.0_dp)], &
                             rods, failure)
        if (failed(error, failure)) return
        rods%gain = [1.02_dp, 0.97_dp, 1.0_dp]
        rods%misalignment(3:4) = [1e-3_dp, -2e-3_dp]
        rods%delay = [0.0_dp, 0.03_dp, 0.01_dp]
        call dipole_moments(rods, 0.05_dp, moment)
        largest = 0
        do k = 0, N
            largest = max(largest, maxval(abs(moment(:, k) - dipole_moment(rods, k*0.05_dp))))
        end do
        call check(error, largest, 0.0_dp, thr=1e-11_dp)
    end subroutine test_all_times

    !> The edges of a manoeuvre, one after the other: tapers, square waves with a phase, activations that begin inside
    !> another one, delays; and the samples of a series.
    subroutine test_rod_edges(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: EXPECTED(14) = [1.0_dp, 6.0_dp, 10.5_dp, 11.0_dp, 12.0_dp, 13.5_dp, 14.5_dp, 16.0_dp, &
                                               17.0_dp, 18.5_dp, 19.5_dp, 20.5_dp, 25.0_dp, 30.0_dp]
        type(torque_rods_t) :: rods
        type(moment_series_t) :: series
        type(error_t), allocatable :: failure
        real(dp) :: t
        integer :: i

        ! the square wave is 0.3 of a period on its way when it begins: its first zero is 1 s later, behind the delay
        call new_torque_rods([rod_activation_t(axis=2, amplitude=30.0_dp, frequency=0.1_dp, start=1.0_dp, stop=30.0_dp, &
                              taper=5.0_dp, waveform=TAPERED), &
                              rod_activation_t(axis=3, amplitude=30.0_dp, frequency=0.2_dp, start=10.25_dp, stop=20.25_dp, &
                              rise_time=1.0_dp, waveform=SQUARE, phase=0.6_dp*PI)], &
                             rods, failure)
        if (failed(error, failure)) return
        rods%delay(3) = 0.25_dp
        t = 0
        do i = 1, size(EXPECTED)
            call check(error, next_rod_edge(rods, t), EXPECTED(i), thr=1e-12_dp)
            t = EXPECTED(i) + 1e-9_dp
        end do
        call check(error, next_rod_edge(rods, t) >= huge(t), 'none is left')

        call new_moment_series([(0.5_dp*i, i=0, 9)], reshape([(1.0_dp*i, i=1, 30)], [3, 10]), series, failure)
        call take_measured_moments(series, rods)
        call check(error, next_rod_edge(rods, 0.0_dp), 0.5_dp)
        call check(error, next_rod_edge(rods, -3.0_dp), 0.0_dp)
        call check(error, next_rod_edge(rods, 4.5_dp) >= huge(t))
    end subroutine test_rod_edges

    !> Activations of one rod add up; phase and start count; frequency 0 with phase pi/2 is
    !> constant.
    subroutine test_several(error)
        type(error_type), allocatable, intent(out) :: error
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure

        call new_torque_rods([rod_activation_t(1, 10.0_dp, 0.1_dp, 0.3_dp, 5.0_dp, 25.0_dp), &
                              rod_activation_t(1, -4.0_dp, 0.25_dp, 0.0_dp, 0.0_dp, 20.0_dp), &
                              rod_activation_t(3, 7.0_dp, 0.0_dp, PI/2, 10.0_dp, 12.0_dp)], &
                             rods, failure)
        if (failed(error, failure)) return
        call check(error, maxval(abs(dipole_moment(rods, 11.0_dp) - &
                                     [10*sin(0.2_dp*PI*6 + 0.3_dp) - 4*sin(0.5_dp*PI*11), &
                                      0.0_dp, 7.0_dp])) < 1e-13_dp)
        call check(error, maxval(abs(dipole_moment(rods, 22.0_dp) - [10*sin(0.2_dp*PI*17 + 0.3_dp), 0.0_dp, 0.0_dp])) < 1e-13_dp)
    end subroutine test_several

    subroutine test_refuses(error)
        type(error_type), allocatable, intent(out) :: error
        type(rod_activation_t) :: good, bad
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure

        good = rod_activation_t(2, 1.0_dp, 0.1_dp, 0.0_dp, 0.0_dp, 60.0_dp)
        bad = good
        bad%axis = 4
        call check_refused(error, [good, bad], 'activation 2: axis = 4')
        bad = good
        bad%amplitude = NAN
        call check_refused(error, [bad], 'finite')
        bad = good
        bad%frequency = -0.1_dp
        call check_refused(error, [bad], 'frequency')
        bad = good
        bad%stop = 0
        call check_refused(error, [bad], 'stop')
        bad = good
        bad%amplitude = -31
        call check_refused(error, [bad], 'torque rod 2')
        call check_refused(error, spread(good, 1, MAX_ACTIVATIONS + 1), '17 activations')
        good = rod_activation_t(2, 1.0_dp, 0.1_dp, 0.0_dp, 0.0_dp, 60.0_dp, SQUARE, 0.0_dp, 5.0_dp)
        call new_torque_rods([good], rods, failure)
        if (failed(error, failure)) return
        bad = good
        bad%waveform = 5
        call check_refused(error, [bad], 'waveform = 5')
        bad = good
        bad%rise_time = 5.01_dp
        call check_refused(error, [bad], 'rise_time = 5.01')
        bad%rise_time = 0
        call check_refused(error, [bad], 'rise_time = 0')
        bad = good
        bad%frequency = 0
        call check_refused(error, [bad], 'frequency')
        bad = good
        bad%waveform = TAPERED
        call check_refused(error, [bad], 'needs a taper')
        bad%taper = 30.5_dp
        call check_refused(error, [bad], 'taper = 30.5')
        bad%taper = NAN
        call check_refused(error, [bad], 'finite')
    end subroutine test_refuses

    !> 20 and 15 A m^2 on one rod are too much together, not one after the other nor on two rods.
    subroutine test_limit(error)
        type(error_type), allocatable, intent(out) :: error
        type(rod_activation_t) :: pair(2)
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure

        pair = rod_activation_t(1, 20.0_dp, 0.1_dp, 0.0_dp, 0.0_dp, 30.0_dp)
        pair(2)%amplitude = 15
        pair(2)%start = 20
        pair(2)%stop = 50
        call check_refused(error, pair, '35 A m^2 at t = 20 s')
        call check_refused(error, pair([2, 1]), '35 A m^2')
        pair(2)%start = 31
        call new_torque_rods(pair, rods, failure)
        if (failed(error, failure)) return
        pair(2)%start = 20
        pair(2)%axis = 2
        call new_torque_rods(pair, rods, failure)
        if (failed(error, failure)) return
        pair(2)%axis = 1        ! of rods that are stronger, or weaker
        call new_torque_rods(pair, rods, failure, 35.0_dp)
        if (failed(error, failure)) return
        call new_torque_rods(pair, rods, failure, 3.0_dp)
        call check_fails(error, failure, 'at most 3 A m^2 (largest_moment of &rods)')
    end subroutine test_limit

    !> The first rod's moment of one activation.
    real(dp) function moment_of(activation, time)
        type(rod_activation_t), intent(in) :: activation
        real(dp), intent(in) :: time
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        real(dp) :: moment(3)

        call new_torque_rods([activation], rods, failure)
        moment = dipole_moment(rods, time)
        moment_of = moment(1)
        if (allocated(failure)) moment_of = NAN
    end function moment_of

    !> Cosine is the sine a quarter later; a tapered sine is the sine between its tapers, and starts
    !> and stops with the value and slope 0; away from its edges a square wave has the sign of the sine.
    subroutine test_waveforms(error)
        type(error_type), allocatable, intent(out) :: error
        type(rod_activation_t) :: sine_wave, other
        real(dp) :: t, phase
        integer :: i

        sine_wave = rod_activation_t(1, 20.0_dp, 0.1_dp, 0.4_dp, 5.0_dp, 65.0_dp)
        do i = 0, 600
            t = 5 + i/10.0_dp
            phase = 2*PI*0.1_dp*(t - 5) + 0.4_dp
            other = sine_wave
            other%waveform = COSINE
            other%phase = 0.4_dp - PI/2
            call check(error, moment_of(other, t), 20*sin(phase), thr=1e-12_dp)
            other%phase = 0.4_dp
            other%waveform = TAPERED
            other%taper = 8
            if (t >= 13 .and. t <= 57) call check(error, moment_of(other, t), 20*sin(phase), thr=1e-12_dp)
            call check(error, abs(moment_of(other, t)) <= 20*abs(sin(phase)) + 1e-12_dp)
            other%waveform = SQUARE
            other%taper = 0
            other%rise_time = 2
            ! the edge reaches 1 s to either side of a zero, 0.2 pi of phase
            if (abs(sin(phase)) > sin(0.2_dp*PI) + 1e-9_dp) &
                call check(error, moment_of(other, t), sign(20.0_dp, sin(phase)), thr=1e-12_dp)
            call check(error, moment_of(other, t)*sin(phase) >= -1e-9_dp)
        end do
        other = sine_wave
        other%waveform = TAPERED
        other%taper = 8
        call check(error, moment_of(other, 5.0_dp) == 0 .and. moment_of(other, 65.0_dp) == 0 .and. &
                   abs(moment_of(other, 5.01_dp)) < 1e-5_dp .and. abs(moment_of(other, 64.99_dp)) < 1e-5_dp)
    end subroutine test_waveforms

    !> Value and slope of a square wave are continuous: differences over 1 ms stay below the edge's
    !> greatest slope, 15/8 of the mean one, and change by no more than its curvature allows.
    subroutine test_edges(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: STEP = 1e-3_dp
        type(rod_activation_t) :: wave
        real(dp) :: now, next, difference, last_difference, steepest
        integer :: i

        wave = rod_activation_t(1, 30.0_dp, 0.1_dp, -0.7_dp, 0.0_dp, 60.0_dp, SQUARE, 0.0_dp, 1.0_dp)
        last_difference = 0
        steepest = 0
        do i = 0, 59998
            now = moment_of(wave, i*STEP)
            next = moment_of(wave, (i + 1)*STEP)
            difference = (next - now)/STEP
            steepest = max(steepest, abs(difference))
            if (i > 0) call check(error, abs(difference - last_difference) < 1.01_dp*60*10/sqrt(3.0_dp)*STEP)
            last_difference = difference
        end do
        call check(error, steepest, 60*15/8.0_dp, rel=.true., thr=1e-3_dp)
    end subroutine test_edges

    !> At 10 samples a second: frequencies below 5 Hz, edges and tapers from 0.5 s on.
    subroutine test_sampling(error)
        type(error_type), allocatable, intent(out) :: error
        type(rod_activation_t) :: wave

        wave = rod_activation_t(1, 1.0_dp, 4.99_dp, 0.0_dp, 0.0_dp, 60.0_dp)
        call check_passes(error, sampling_message(wave))
        wave%frequency = 5
        call check_fails(error, sampling_message(wave), 'activation 1 ... frequency = 5 Hz ... below 5 Hz')
        wave = rod_activation_t(1, 1.0_dp, 0.1_dp, 0.0_dp, 0.0_dp, 60.0_dp, SQUARE, 0.0_dp, 0.5_dp)
        call check_passes(error, sampling_message(wave))
        wave%rise_time = 0.4_dp
        call check_fails(error, sampling_message(wave), 'rise_time = 0.4 ... at least 0.5 s')
        wave%rise_time = 1
        wave%taper = 0.2_dp
        call check_fails(error, sampling_message(wave), 'taper = 0.2 ... at least 0.5 s')
    end subroutine test_sampling

    function sampling_message(activation) result(message)
        type(rod_activation_t), intent(in) :: activation
        character(:), allocatable :: message

        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure

        call new_torque_rods([activation], rods, failure)
        if (.not. allocated(failure)) call check_rod_sampling(rods, 0.1_dp, failure)
        message = message_of(failure)
    end function sampling_message

    !> No activation, amplitude 0, a start after the arc, a constant sine of 0: nothing moves.
    subroutine test_off(error)
        type(error_type), allocatable, intent(out) :: error
        type(torque_rods_t) :: rods
        type(rod_activation_t) :: wave
        type(error_t), allocatable :: failure

        call check_rods_fire(rods, 60.0_dp, failure)
        call check_fails(error, failure, 'all torque rods are off')
        wave = rod_activation_t(3, 1.0_dp, 0.1_dp, 0.0_dp, 10.0_dp, 90.0_dp)
        call check_moves(.true.)
        wave%start = 60
        call check_moves(.false.)
        wave%start = 0
        wave%amplitude = 0
        call check_moves(.false.)
        wave%amplitude = 1
        wave%frequency = 0
        call check_moves(.false.)
        wave%waveform = COSINE
        call check_moves(.true.)

    contains

        subroutine check_moves(expected)
            logical, intent(in) :: expected

            call new_torque_rods([wave], rods, failure)
            call check(error, moves_rods(rods, 60.0_dp) .eqv. expected)
            call check_rods_fire(rods, 60.0_dp, failure)
            call check(error, allocated(failure) .neqv. expected)
        end subroutine check_moves
    end subroutine test_off

    subroutine check_refused(error, activations, part_of_message)
        type(error_type), allocatable, intent(inout) :: error
        type(rod_activation_t), intent(in) :: activations(:)
        character(*), intent(in) :: part_of_message
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure

        call new_torque_rods(activations, rods, failure)
        call check_fails(error, failure, part_of_message)
    end subroutine check_refused

    !> A cubic is met exactly, a sine with an error of the fourth order, h^4/384 of the fourth derivative; moments stand
    !> in for activations, with directions but without gain and delay of the setup.
    subroutine test_measured(error)
        type(error_type), allocatable, intent(out) :: error
        type(moment_series_t) :: series
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        real(dp) :: time(0:40), moment(3, 0:40), t, worst, h
        integer :: i, k

        time = [(i + 0.3_dp*mod(i, 2), i=0, 40)]
        do i = 0, 40
            moment(:, i) = [1 + time(i) - (time(i)/20)**3, 2.0_dp, -time(i)/4]
        end do
        call new_moment_series(time, moment, series, failure)
        call check_passes(error, failure)
        do k = 0, 400
            t = k/10.0_dp
            call check(error, all(abs(series_moments(series, t) - [1 + t - (t/20)**3, 2.0_dp, -t/4]) < 1e-12_dp), 'a cubic')
        end do
        do k = 1, 2
            h = 0.5_dp/k
            do i = 0, 40
                time(i) = i*h
                moment(:, i) = 30*[0.0_dp, sin(0.2_dp*PI*time(i)), cos(0.2_dp*PI*time(i))]
            end do
            call new_moment_series(time, moment, series, failure)
            worst = 0
            do i = 40, 360
                t = i*h/10
                worst = max(worst, maxval(abs(series_moments(series, t) - &
                                              30*[0.0_dp, sin(0.2_dp*PI*t), cos(0.2_dp*PI*t)])))
            end do
            ! the slopes' error of h^4/30 of the fifth derivative adds 1.6 (2 pi 0.1 h)^2 of it: 0.16 and 0.04
            call check(error, worst < 1.2_dp*30*(0.2_dp*PI*h)**4/384 .and. worst > 0.8_dp*30*(0.2_dp*PI*h)**4/384, 'a sine')
        end do
        call new_harmonic_manoeuvre([0, 1, 1], 30.0_dp, 0.1_dp, 0.0_dp, 60.0_dp, rods, failure)
        rods%gain = 0.5_dp
        rods%delay = 2
        rods%misalignment(5) = PI/2         ! the z rod lies along -y
        call take_measured_moments(series, rods)
        moment(:, 0) = series_moments(series, 7.3_dp)
        moment(:, 1) = dipole_moment(rods, 7.3_dp)
        call check(error, all(abs(moment(:, 1) - [0.0_dp, moment(2, 0) - moment(3, 0), 0.0_dp]) < 1e-12_dp), 'directions')
        call check(error, moves_rods(rods, 10.0_dp))
    end subroutine test_measured

    !> Moments that are held jump at their samples; Runge-Kutta steps of 0.1 s integrate by Simpson's rule what was held, wherever
    !> they lie.
    subroutine test_held_moments(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: HALF = 0.05_dp       ! Of a Runge-Kutta step, s
        type(moment_series_t) :: series
        type(error_t), allocatable :: failure
        real(dp) :: moment(3, 12), sum_of_steps(3), from
        integer :: i, k

        moment = reshape([(modulo(7.0_dp*i*i, 11.0_dp), i=1, 36)], [3, 12])
        call new_moment_series([(0.5_dp*i, i=0, 11)], moment, series, failure, held=.true.)
        do i = 0, 8
            from = 0.12_dp + 0.03_dp*i              ! to 4 s later, away from steps by more than half of what they last
            call check(error, all(abs(series_moments(series, from + 0.5_dp, .true.) - moment(:, 2)) <= 0), 'a jump')
            sum_of_steps = 0
            do k = 0, 39
                sum_of_steps = sum_of_steps + series_moments(series, from + 2*k*HALF) + &
                    4*series_moments(series, from + (2*k + 1)*HALF) + series_moments(series, from + (2*k + 2)*HALF)
            end do
            call check(error, all(abs(sum_of_steps*HALF/3 - (0.5_dp - from)*moment(:, 1) - 0.5_dp*sum(moment(:, 2:8), 2) - &
                                      from*moment(:, 9)) < 1e-12_dp), 'the integral')
        end do
    end subroutine test_held_moments

    subroutine test_refused_measurements(error)
        type(error_type), allocatable, intent(out) :: error
        type(moment_series_t) :: series
        type(error_t), allocatable :: failure
        real(dp) :: time(20), moment(3, 20)
        integer :: i

        time = [(i - 1.0_dp, i=1, 20)]
        moment = 1
        call refused([0.0_dp, 1.0_dp, 2.0_dp, 3.0_dp], moment(:, :4), 'at least 5')
        call refused(time, moment(:, :19), 'but 19 samples')
        call refused([time(:9), 8.0_dp, time(11:)], moment, '8 s follows 8 s')
        call refused([time(:9), NAN, time(11:)], moment, 'time tag 10 is NaN')
        call refused([time(:9), 12 + time(10:)], moment, 'no samples between 8 s and 21 s')
        moment(2, 4) = 3e4_dp
        call refused(time, moment, 'have to be in A m^2')
        moment(2, 4) = NAN
        call refused(time, moment, 'at 3 s is NaN')
        moment = 1
        call new_moment_series(time, moment, series, failure)
        call check_moments_cover(series, 20.0_dp, failure)
        if (failed(error, failure)) return
        call check_moments_cover(series, 60.0_dp, failure)
        call check_fails(error, failure, 'from 0 s to 19 s ... arc from 0 to 60 s')

    contains

        subroutine refused(time, moment, part)
            real(dp), intent(in) :: time(:), moment(:, :)
            character(*), intent(in) :: part

            call new_moment_series(time, moment, series, failure)
            call check_fails(error, failure, 'moments of the torque rods ... '//part)
        end subroutine refused
    end subroutine test_refused_measurements
end module test_torque_rods
