!> The live estimate: against `sequential` on the same samples, in what it leaves out and refuses, and in loops that it ends.
module test_live_estimate
    use vocabulary
    use calibrations
    use live_samples, only: sample_of
    use gracecg_base_error, only: number_text
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    use gracecg_estimation_live_estimate, only: live_estimate_t, live_sample_t, begin_live_estimate
    use gracecg_estimation_offset_information, only: gather_information
    use gracecg_estimation_options, only: STRAIGHT_LINE
    use gracecg_planning_next_seconds, only: next_seconds_t, begin_planning
    use gracecg_planning_site, only: fly_moments
    use gracecg_simulation_dynamics, only: OMEGA, ATTITUDE
    use gracecg_simulation_limits, only: attitude_motion_t
    use gracecg_simulation_simulator, only: observe, error_switches_t
    use gracecg_studies_closed_loop, only: loop_settings_t, loop_t, loop_statistics_t, run_loops, statistics_of_loops
    use statistics, only: chi_square_limits
    implicit none
    private
    public :: collect_live_estimate

    integer, parameter :: SEED = 5

contains

    subroutine collect_live_estimate(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('is-the-sequential-estimate', test_sequential_estimate), &
                    new_unittest('is-honest-with-a-wave', test_wave), &
                    new_unittest('two-heads', test_two_heads), &
                    new_unittest('what-is-left-out', test_left_out), &
                    new_unittest('refusals', test_refusals), &
                    new_unittest('plans', test_plans), &
                    new_unittest('loops-stop-with-the-sigma-they-state', test_loops)]
    end subroutine collect_live_estimate

    !> A set of a case with straight drag and all errors of the instruments, and a live estimate that begins near its truth.
    subroutine prepare(name, observations, live, both_heads)
        character(*), intent(in) :: name
        type(observation_set_t), intent(out) :: observations
        type(live_estimate_t), intent(out) :: live
        logical, intent(in), optional :: both_heads     !! Absent: that which the case uses
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(error_t), allocatable :: failure

        call take_case(name, case)
        case%density_wave%amplitude = 0
        call make_simulator(case, error_switches_t(curved_force=.false.), simulator)
        call observe(simulator, SEED, 1, observations, failure, only_used_head=.not. present(both_heads))
        if (.not. allocated(failure)) &
            call begin_live_estimate(observations%knowledge, simulator%arc%state(ATTITUDE, 0), &
                                     simulator%arc%state(OMEGA, 0) + [1, -1, 1]*1e-4_dp, live, failure)
        call need(failure)
    end subroutine prepare

    !> Feeds a set.
    subroutine feed(observations, live, error)
        type(observation_set_t), intent(in) :: observations
        type(live_estimate_t), intent(inout) :: live
        type(error_type), allocatable, intent(inout) :: error
        type(error_t), allocatable :: failure
        integer :: k

        do k = 0, nint(observations%knowledge%duration/observations%knowledge%accelerometer_interval)
            call live%add(sample_of(observations, k), failure)
            if (failed(error, failure)) return
        end do
    end subroutine feed

    !> With 5 s of the accelerometer missing: estimate and sigma of `sequential` under straight drag. That linearises all samples
    !> about the last estimate, this only the first ten seconds about their own: of manoeuvres that leave a direction nearly
    !> unseen, as the report's do, a sigma may differ by some per cent.
    subroutine test_sequential_estimate(error)
        type(error_type), allocatable, intent(out) :: error
        character(7), parameter :: CASES(4) = ['front-1', 'front-3', 'back-1 ', 'back-2 ']
        type(observation_set_t) :: observations
        type(live_estimate_t) :: live
        type(estimation_options_t) :: options
        type(solution_t) :: solution
        integer, allocatable :: kept(:)
        real(dp) :: offset(3), covariance(3, 3), variance, sigma(3), off
        integer :: c, i

        options%covariance = .false.
        options%sequential%acceleration = STRAIGHT_LINE
        do c = 1, size(CASES)
            call prepare(trim(CASES(c)), observations, live)
            associate (time => observations%accelerometer_time)
                kept = pack([(i, i=1, size(time))], time < 20 .or. time > 25)
            end associate
            observations%accelerometer_time = observations%accelerometer_time(kept)
            observations%acceleration = observations%acceleration(:, kept)
            call feed(observations, live, error)
            if (estimate_fails(error, 'sequential', observations, options, solution)) return
            call live%now(offset, covariance, variance)
            sigma = sigmas(solution%covariance)
            off = maxval(abs(offset - solution%offset)/sigma)
            call check(error, off < 0.2_dp, CASES(c)//': estimate, sigmas off: '//number_text(off))
            off = maxval(abs(sigmas(covariance)/sigma - 1))
            call check(error, off < 0.1_dp, CASES(c)//': sigma, off: '//number_text(off))
            call check(error, variance > 0.8_dp .and. variance < 1.2_dp, CASES(c)//': variance of the innovations')
            call check(error, live%edited, 0, 'edited')
        end do
    end subroutine test_sequential_estimate

    !> Of a built-in case, forces as they bend and a density wave whose frequency is half a per cent wrong: no run is lost, and the
    !> normalised squares are those of the same runs without a wave. Whose frequency nobody knows, loses them.
    subroutine test_wave(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RUNS = 50
        real(dp), parameter :: WRONG = 1.005_dp
        type(case_t) :: case
        real(dp) :: total(0:1), limits(2), frequency
        integer :: with_wave, lost

        limits = chi_square_limits(3*RUNS)
        do with_wave = 0, 1
            call take_case('front-3', case)
            frequency = WRONG/case%density_wave%period
            if (with_wave == 0) case%density_wave%amplitude = 0
            call run_all(merge(frequency, 0.0_dp, with_wave == 1), RUNS, total(with_wave), lost)
            call check(error, lost, 0, 'nothing is known')
            call check(error, total(with_wave) > limits(1) .and. total(with_wave) < limits(2), &
                       'normalised squares: '//number_text(total(with_wave)/RUNS))
        end do
        call run_all(0.0_dp, 4, total(0), lost)
        call check(error, lost, 4, 'without the frequency')

    contains

        subroutine run_all(frequency, runs, total, lost)
            real(dp), intent(in) :: frequency
            integer, intent(in) :: runs
            real(dp), intent(out) :: total
            integer, intent(out) :: lost
            type(simulator_t) :: simulator
            type(observation_set_t) :: observations
            type(live_estimate_t) :: live
            type(error_t), allocatable :: failure
            real(dp) :: offset(3), covariance(3, 3)
            integer :: run

            ! scale factors and bias of the magnetometer are the same in all runs
            call make_simulator(case, error_switches_t(scale_factors=.false., magnetometer_bias=.false.), simulator)
            total = 0
            lost = 0
            do run = 1, runs
                call observe(simulator, SEED, run, observations, failure, only_used_head=.true.)
                if (.not. allocated(failure)) &
                    call begin_live_estimate(observations%knowledge, simulator%arc%state(ATTITUDE, 0), &
                                             simulator%arc%state(OMEGA, 0) + [1, -1, 1]*1e-4_dp, live, failure, frequency)
                call need(failure)
                call feed(observations, live, error)
                call live%now(offset, covariance)
                offset = offset - case%satellite%offset
                total = total + dot_product(offset, matmul(inverse_3x3(covariance), offset))
                if (covariance(1, 1) >= 1) lost = lost + 1
            end do
        end subroutine run_all
    end subroutine test_wave

    !> Samples of both heads at once are all taken, and tell the same offset as those of one.
    subroutine test_two_heads(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(live_estimate_t) :: one, two
        type(live_sample_t) :: sample
        type(error_t), allocatable :: failure
        real(dp), dimension(3) :: of_one, of_two, ratio
        real(dp), dimension(3, 3) :: known_by_one, known_by_two
        integer :: k, used

        call prepare('back-1', observations, one, both_heads=.true.)
        two = one
        used = max(1, observations%knowledge%camera)
        do k = 0, nint(observations%knowledge%duration/observations%knowledge%accelerometer_interval)
            sample = sample_of(observations, k)
            call two%add(sample, failure)
            sample%has_attitude(3 - used) = .false.
            if (.not. allocated(failure)) call one%add(sample, failure)
            if (failed(error, failure)) return
        end do
        call one%now(of_one, known_by_one)
        call two%now(of_two, known_by_two)
        call check(error, two%innovations - one%innovations, 3*count(observations%star_camera_head /= used), 'of the other head')
        call check(error, two%innovations > one%innovations, 'the other head has samples')
        ratio = sigmas(known_by_two)/sigmas(known_by_one)      ! the accelerometer tells nearly all
        call check(error, minval(ratio) > 0.8_dp .and. maxval(ratio) < 1.02_dp, 'sigma: '//number_text(maxval(ratio)))
        call check(error, maxval(abs(of_two - of_one)/sigmas(known_by_one)) < 2, 'offset')
    end subroutine test_two_heads

    !> A spike of each instrument is left out, and changes next to nothing.
    subroutine test_left_out(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(live_estimate_t) :: live, spiked
        real(dp) :: offset(3), covariance(3, 3), with(3), unused(3, 3)

        call prepare('front-3', observations, live)
        spiked = live
        call feed(observations, live, error)
        associate (a => observations%acceleration(:, 300), q => observations%quaternion(:, 60))
            a(2) = a(2) + 1e-6_dp
            q = q([2, 1, 4, 3])
        end associate
        call feed(observations, spiked, error)
        if (allocated(error)) return
        call live%now(offset, covariance)
        call spiked%now(with, unused)
        call check(error, spiked%edited, 2, 'left out')
        call check(error, maxval(abs(with - offset)/sigmas(covariance)) < 0.2_dp, 'estimate')
        ! A density wave is no outlier: the offset is then not known.
        call prepare('front-1', observations, live)
        observations%acceleration(1, :) = observations%acceleration(1, :) + &
            5e-9_dp*sin(TWO_PI*observations%accelerometer_time/20)
        call feed(observations, live, error)
        call live%now(offset, covariance)
        call check(error, covariance(3, 3) >= 1, 'a wave')
    end subroutine test_left_out

    !> What cannot be taken is refused, and nothing of it is taken.
    subroutine test_refusals(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: HERE(4) = [0, 0, 0, 1], REST(3) = 0
        type(observation_set_t) :: observations
        type(live_estimate_t) :: live, none
        type(live_sample_t) :: sample
        type(error_t), allocatable :: failure
        real(dp) :: offset(3), covariance(3, 3)
        integer :: k

        call prepare('front-3', observations, live)
        call none%add(sample_of(observations, 0), failure)
        call check_fails(error, failure, 'has not begun')
        call none%now(offset, covariance)
        call check(error, covariance(1, 1) >= 1, 'nothing is known')
        sample = sample_of(observations, 0)
        sample%has_field = .false.
        call refused('needs the field')
        call live%add(sample_of(observations, 0), failure)
        call check_passes(error, failure)
        sample = sample_of(observations, 2)
        call refused('the next sample is that at 0.1')
        sample = sample_of(observations, 1)
        sample%acceleration(2) = NAN
        call refused('not finite')
        sample = sample_of(observations, 1)
        sample%has_attitude(1) = .true.
        sample%attitude_time = 0.3_dp
        call refused('star camera at 0.3')
        sample = sample_of(observations, 1)
        sample%position = sample%position/1000
        call refused('check their units')
        sample = sample_of(observations, 1)
        sample%moment(2, 2) = 301        ! ten times what a rod bears, and more
        call refused('check their units')
        call check(error, live%samples, 1, 'samples taken')
        do k = 1, 301
            sample = sample_of(observations, k)
            sample%has_field = .false.
            if (k == 301) exit
            call live%add(sample, failure)
            call check_passes(error, failure)
        end do
        call refused('silent since')
        sample%has_field = .true.
        sample%position = -norm2(sample%position)*unit(live%sun)        ! behind the Earth
        call refused('the Sun rises or sets')
        call begin_live_estimate(observations%knowledge, HERE, [2.0_dp, 0.0_dp, 0.0_dp], live, failure)
        call check_fails(error, failure, '2 rad/s')
        call begin_live_estimate(observations%knowledge, HERE, REST, live, failure, wave_frequency=6.0_dp)
        call check_fails(error, failure, 'wave_frequency = 6 Hz')
        observations%knowledge%accelerometer_noise(2)%level = 0
        call begin_live_estimate(observations%knowledge, HERE, REST, live, failure)
        call check_fails(error, failure, 'noise_level')

    contains

        subroutine refused(part)
            character(*), intent(in) :: part

            call live%add(sample, failure)
            call check_fails(error, failure, part)
        end subroutine refused
    end subroutine test_refusals

    !> A plan looks after the axis that needs it, better than any other manoeuvre that it may choose, and rests where nothing is
    !> allowed.
    subroutine test_plans(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: FIELD(3) = [1e-5_dp, 5e-6_dp, 3e-5_dp], REST(3) = 0, TURNING(3) = [0.0_dp, -1.1e-3_dp, 0.0_dp]
        type(observation_set_t) :: observations
        type(live_estimate_t) :: unused
        type(next_seconds_t) :: planner
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        real(dp) :: covariance(3, 3), first(3), then(3), known(3, 3)
        integer :: axis, k, i

        call prepare('front-3', observations, unused)
        call begin_planning(observations%knowledge, 10.0_dp, 30.0_dp, planner, failure)
        if (failed(error, failure)) return
        covariance = 0
        do k = 1, 3
            covariance(k, k) = 1
        end do
        call planner%plan(covariance, FIELD, REST, TURNING, TURNING, rods, first)
        call check(error, rods%count, 3, 'rods')
        call check(error, all(first < 1e-3_dp .and. first > 0), 'expected')
        do axis = 1, 3
            known = 0
            do k = 1, 3
                known(k, k) = merge(1e-4_dp, 1e-6_dp, k == axis)**2
            end do
            call planner%plan(known, FIELD, REST, TURNING, TURNING, rods, then)
            call check(error, maxloc(then, 1), axis, 'the axis that needs it')
            call check(error, minval([(worst_after(i), i=1, size(planner%candidates))]), maxval(then), thr=1e-12_dp, rel=.true.)
        end do
        call planner%plan(covariance, FIELD, [1.0_dp, 0.0_dp, 0.0_dp], TURNING, TURNING, rods, then)
        call check(error, rods%count, 0, 'beyond the limit of pointing the rods rest')
        call check(error, maxval(abs(then - 1)) < 1e-12_dp, 'nothing is learnt')

    contains

        !> The worst standard deviation after a manoeuvre; all of these keep the limits.
        real(dp) function worst_after(manoeuvre) result(worst)
            integer, intent(in) :: manoeuvre
            real(dp), dimension(3, planner%arc%samples) :: rate, rate_change, turn
            real(dp) :: information(3, 3), after(3, 3)
            type(attitude_motion_t) :: motion

            call fly_moments(planner%arc, planner%site, planner%dipole(:, :, manoeuvre), rate, rate_change, turn, motion)
            call gather_information(rate, rate_change, planner%arc%whiteners, information)
            after = inverse_3x3(inverse_3x3(known) + information)
            worst = sqrt(max(after(1, 1), after(2, 2), after(3, 3)))
        end function worst_after
    end subroutine test_plans

    !> Loops of two cases: their normalised squares at the moment of stopping are a chi-square with three degrees of freedom
    !> each.
    subroutine test_loops(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: LOOPS = 60
        type(case_t) :: case
        type(loop_settings_t) :: settings
        type(loop_t), allocatable :: results(:)
        type(loop_statistics_t) :: statistics
        type(error_t), allocatable :: failure
        real(dp) :: total, limits(2)
        integer :: c

        total = 0
        settings%places = 12
        do c = 1, 2
            call take_case(merge('front-3', 'back-1 ', c == 1), case)
            call run_loops(case, settings, LOOPS, 1, results, failure)
            if (.not. allocated(failure)) call statistics_of_loops(results, statistics, failure)
            if (failed(error, failure)) return
            call check(error, statistics%stopped, LOOPS, 'stopped')
            call check(error, maxval(abs(statistics%bias)) < 4/sqrt(real(LOOPS, dp)), 'no bias')
            total = total + LOOPS*statistics%square
        end do
        limits = chi_square_limits(3*2*LOOPS)
        call check(error, total > limits(1) .and. total < limits(2), 'normalised squares: '//number_text(total/(2*LOOPS)))
    end subroutine test_loops
end module test_live_estimate
