!> The estimator `sequential` on simulated calibrations. Systematic errors (scale factors, biases) are off
!> but where said: they are not what filter and batch differ in.
module test_sequential
    use vocabulary
    use calibrations
    use gracecg_base_error, only: number_text
    use gracecg_base_gauss_markov, only: gauss_markov_t, first_order_process, second_order_process
    use gracecg_estimation_options, only: sequential_options_t, STRAIGHT_LINE
    use gracecg_estimation_square_root_information, only: constants_t, new_constants
    use gracecg_estimation_disturbance_search, only: disturbance_t, weigh_tone, with_disturbance
    use gracecg_estimation_noise_whitening, only: process_filter_t, prepare_filter
    use gracecg_simulation_simulator, only: observe, error_switches_t
    use statistics, only: chi_square_limits
    implicit none
    private
    public :: collect_sequential

    integer, parameter :: SEED = 3

contains

    subroutine collect_sequential(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('tone-in-closed-form', test_tone), &
                    new_unittest('straight-line-equals-optimal', test_straight), &
                    new_unittest('sigmas-are-honest', test_honest), &
                    new_unittest('wave-is-found-and-followed', test_wave), &
                    new_unittest('curved-drag-does-not-pull-a-wave', test_curved), &
                    new_unittest('wandering-drag-beats-the-batch', test_wander), &
                    new_unittest('spikes-are-edited', test_spikes), &
                    new_unittest('gaps-are-bridged', test_gaps), &
                    new_unittest('running-estimate', test_running), &
                    new_unittest('no-noise-level', test_no_noise_level), &
                    new_unittest('offset-not-determined', test_rods_off), &
                    new_unittest('unknown-disturbances-enlarge-the-sigmas', test_misfit)]
    end subroutine collect_sequential

    !> A case without systematic errors; its drag a straight line or as it is.
    subroutine prepare(name, straight, simulator, wave)
        character(*), intent(in) :: name
        logical, intent(in) :: straight
        type(simulator_t), intent(out) :: simulator
        real(dp), intent(in), optional :: wave(2)       !! Relative amplitude and period (s) of the density wave
        type(case_t) :: case
        type(error_switches_t) :: switches

        call take_case(name, case)
        case%satellite%accelerometer%scale1 = 1
        case%satellite%accelerometer%scale2 = 0
        case%satellite%accelerometer%scale3 = 0
        case%satellite%accelerometer%bias = 0
        case%satellite%magnetometer%bias = 0
        case%density_wave%amplitude = 0
        if (present(wave)) case%density_wave%amplitude = wave(1)
        if (present(wave)) case%density_wave%period = wave(2)
        switches%curved_force = .not. straight
        call make_simulator(case, switches, simulator)
    end subroutine prepare

    !> One simulated set of a case with straight drag.
    subroutine straight_set(name, run, observations, true_offset)
        character(*), intent(in) :: name
        integer, intent(in) :: run
        type(observation_set_t), intent(out) :: observations
        real(dp), intent(out) :: true_offset(3)
        type(simulator_t) :: simulator

        call prepare(name, .true., simulator)
        call make_observations(simulator, SEED, run, observations, only_used_head=.true.)
        true_offset = simulator%case%satellite%offset
    end subroutine straight_set

    logical function solve_fails(algorithm, observations, solution, error, options)
        character(*), intent(in) :: algorithm
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(out) :: solution
        type(error_type), allocatable, intent(inout) :: error
        type(sequential_options_t), intent(in), optional :: options
        type(estimation_options_t) :: own
        type(error_t), allocatable :: failure

        own%covariance = .false.
        own%optimal%search_jump = .false.   ! the model is the same in both
        if (present(options)) own%sequential = options
        call estimate_offset(algorithm, observations, own, solution, failure)
        if (allocated(failure)) then
            call test_failed(error, failure%message)
        else if (.not. solution%converged) then
            call test_failed(error, algorithm//' did not converge')
        end if
        solve_fails = allocated(error)
    end function solve_fails

    pure function sigma_of(solution) result(sigma)
        type(solution_t), intent(in) :: solution
        real(dp) :: sigma(3)

        sigma = sigmas(solution%covariance)
    end function sigma_of

    !> Error squared in units of the covariance: chi-square with 3 degrees of freedom.
    pure real(dp) function normalised_square(solution, true_offset) result(value)
        type(solution_t), intent(in) :: solution
        real(dp), intent(in) :: true_offset(3)

        associate (e => solution%offset - true_offset)
            value = dot_product(e, matmul(inverse_3x3(solution%covariance), e))
        end associate
    end function normalised_square

    !> What a tone adds to the likelihood is what its process adds, which takes another filter and fit; and no other size
    !> adds more.
    subroutine test_tone(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: M = 4, N = 200
        real(dp), parameter :: INTERVAL = 0.1_dp, FREQUENCY = 0.23_dp   ! s, Hz
        type(gauss_markov_t) :: noise
        type(random_stream_t) :: stream
        type(constants_t) :: constants
        type(process_filter_t) :: filter
        real(dp) :: rows(M + 1, N), whitened(M + 1, N), without, with, sigma, gain, others
        integer :: epoch(N), i
        logical :: kept(N)

        noise = first_order_process(2.0_dp, 0.9_dp)
        stream = new_stream(SEED, 2, 0, 0, 0)
        epoch = [(merge(i, i + 9, i <= 70), i=1, N)]            ! with a gap
        kept = [(mod(i, 13) /= 0, i=1, N)]
        do i = 1, N
            call stream%normals(rows(:, i))
            rows(M + 1, i) = rows(M + 1, i) + 3*cos(TWO_PI*FREQUENCY*epoch(i)*INTERVAL + 0.7_dp)
        end do
        call weigh(noise, without)
        sigma = 1
        call weigh_tone(filter, INTERVAL, whitened, constants%inverse_root(), constants%solution(), FREQUENCY, sigma, gain)
        call check(error, sigma > 1 .and. sigma < 4, 'size')
        call weigh(with_disturbance(noise, disturbance_t(sigma, FREQUENCY, 1e-9_dp), INTERVAL), with)
        call check(error, gain, without - with, thr=1e-4_dp)
        do i = 1, 2
            call weigh(with_disturbance(noise, disturbance_t(sigma*merge(0.9_dp, 1.1_dp, i == 1), FREQUENCY, 1e-9_dp), &
                                        INTERVAL), others)
            call check(error, others > with, 'the most likely size')
        end do

    contains

        !> -2 ln L, and the constants' estimate.
        subroutine weigh(process, value)
            type(gauss_markov_t), intent(in) :: process
            real(dp), intent(out) :: value
            integer :: k

            call prepare_filter(process, epoch, kept, filter)
            whitened = rows
            call filter%whiten(whitened)
            value = filter%log_variance
            constants = new_constants(M)
            do k = 1, M
                constants%array(k, k) = 1e-3_dp
            end do
            call constants%fold_in_all(whitened)
            value = value + constants%squares + constants%log_determinant()
        end subroutine weigh
    end subroutine test_tone

    !> Drag a straight line: estimate and sigma of the batch, in every case.
    subroutine test_straight(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: sequential, optimal, with, without
        real(dp) :: true_offset(3)
        integer :: i

        do i = 1, size(REPORT_CASE_NAMES)
            call straight_set(trim(REPORT_CASE_NAMES(i)), 1, observations, true_offset)
            if (solve_fails('optimal', observations, optimal, error)) return
            if (solve_fails('sequential', observations, sequential, error)) return
            call check(error, maxval(abs(sequential%offset - optimal%offset)/sigma_of(optimal)) < 0.02_dp, &
                       REPORT_CASE_NAMES(i)//': estimate, sigmas off: '// &
                       number_text(maxval(abs(sequential%offset - optimal%offset)/sigma_of(optimal))))
            call check(error, maxval(abs(sigma_of(sequential)/sigma_of(optimal) - 1)) < 0.002_dp, &
                       REPORT_CASE_NAMES(i)//': sigma')
            if (solve_fails('sequential', observations, with, error, sequential_options_t(estimate_within_limits=.false.))) return
            if (solve_fails('sequential', observations, without, error, &
                            sequential_options_t(STRAIGHT_LINE, estimate_within_limits=.false.))) return
            call check(error, maxval(abs(sigma_of(without)/sigma_of(with) - 1)) < 0.002_dp, &
                       REPORT_CASE_NAMES(i)//': sigma, without a parabola')
            call check(error, maxval(sigma_of(without)/sigma_of(with)) < 1 - 1e-6_dp, &
                       REPORT_CASE_NAMES(i)//': a parabola costs something')
        end do
    end subroutine test_straight

    !> A wave and a parabola of the drag: the wave is found with its own period and as a pure tone, so that
    !> the offset is moved by less than half a sigma.
    subroutine test_curved(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: PERIOD = 11.3_dp, AMPLITUDE = 0.006_dp, PARABOLA = 0.009_dp   ! of the drag
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: reference, solution
        integer :: k

        call prepare('front-3', .false., simulator)
        call make_observations(simulator, SEED, 1, observations, only_used_head=.true.)
        if (solve_fails('sequential', observations, reference, error)) return
        do k = 1, size(observations%accelerometer_time)
            associate (t => observations%accelerometer_time(k), drag => simulator%arc%loads(k)%drag)
                observations%acceleration(:, k) = observations%acceleration(:, k) + &
                                                  drag*(AMPLITUDE*sin(TWO_PI*t/PERIOD) + PARABOLA*(t/30 - 1)**2)
            end associate
        end do
        if (solve_fails('sequential', observations, solution, error)) return
        call check(error, found_period(solution), PERIOD, thr=0.06_dp)
        call check(error, maxval(abs(solution%offset - reference%offset)/sigma_of(reference)) < 0.5_dp, 'estimate')
        call check(error, maxval(sigma_of(solution)/sigma_of(reference)) < 1.3_dp, 'sigma')
    end subroutine test_curved

    !> The normalised error squared of 10 runs of each case: chi-square with 180 degrees of freedom. Neither do forces
    !> bend nor are instruments wrong, and the estimator knows it.
    subroutine test_honest(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RUNS = 10
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        real(dp) :: total, limits(2)
        integer :: i, run

        total = 0
        do i = 1, size(REPORT_CASE_NAMES)
            call prepare(trim(REPORT_CASE_NAMES(i)), .true., simulator)
            do run = 1, RUNS
                call make_observations(simulator, SEED, run, observations, only_used_head=.true.)
                if (solve_fails('sequential', observations, solution, error, &
                           sequential_options_t(estimate_within_limits=.false.))) return
                total = total + normalised_square(solution, simulator%case%satellite%offset)
            end do
        end do
        limits = chi_square_limits(3*RUNS*size(REPORT_CASE_NAMES))
        call check(error, total > limits(1) .and. total < limits(2))
    end subroutine test_honest

    !> The report's density wave: found in x with its period; without a process the wave ruins the
    !> estimate. That its frequency is estimated counts: the covariance is that of `optimal`, with the frequency among its
    !> parameters; were it known, the trace of one in units of
    !> the other would be 2.6 and 2.4 in runs 4 and 6.
    subroutine test_wave(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RUNS = 8
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution, batch
        real(dp) :: followed, ignored, limits(2), ratio(3, 3)
        integer :: run

        call prepare('front-1', .false., simulator, wave=[0.003_dp, 9.0_dp])
        followed = 0
        ignored = 0
        do run = 1, RUNS
            call make_observations(simulator, SEED, run, observations, only_used_head=.true.)
            if (solve_fails('sequential', observations, solution, error)) return
            call check(error, abs(found_period(solution) - 9) < 0.2_dp, 'a period of 9 s is found in x')
            followed = followed + normalised_square(solution, simulator%case%satellite%offset)
            if (solve_fails('optimal', observations, batch, error)) return
            ratio = matmul(inverse_3x3(batch%covariance), solution%covariance)
            call check(error, ratio(1, 1) + ratio(2, 2) + ratio(3, 3) > 2.95_dp, 'what is said of the errors')
            if (solve_fails('sequential', observations, solution, error, sequential_options_t(STRAIGHT_LINE))) return
            ignored = ignored + normalised_square(solution, simulator%case%satellite%offset)
        end do
        limits = chi_square_limits(3*RUNS)
        call check(error, followed < limits(2), 'errors within the sigmas')
        call check(error, ignored > 2*followed, 'the straight line does not follow the wave')
    end subroutine test_wave

    !> The period that a solution says of axis x; 0 if none.
    real(dp) function found_period(solution) result(period)
        type(solution_t), intent(in) :: solution
        character(*), parameter :: BEGIN = 'a period of '
        integer :: i, at

        period = 0
        do i = 1, size(solution%warnings)
            associate (text => solution%warnings(i)%text)
                at = index(text, BEGIN)
                if (index(text, 'of axis x') == 0 .or. at == 0) cycle
                read (text(at + len(BEGIN):), *) period
                return
            end associate
        end do
    end function found_period

    !> Adds a second-order Gauss-Markov process along the drag.
    subroutine add_wander(simulator, run, relative, period, damping, observations)
        type(simulator_t), intent(in) :: simulator
        integer, intent(in) :: run
        real(dp), intent(in) :: relative, period, damping
        type(observation_set_t), intent(inout) :: observations
        type(gauss_markov_t) :: process
        type(random_stream_t) :: stream
        real(dp) :: p(2), draws(2)
        integer :: k

        process = second_order_process(relative, TWO_PI/period, damping, simulator%arc%interval)
        stream = new_stream(SEED, run, 7, 0, 0)
        call stream%normals(p)
        p = relative*p
        do k = 1, size(observations%acceleration, 2)
            call stream%normals(draws)
            p = matmul(process%transition, p) + matmul(process%noise_root, draws)
            observations%acceleration(:, k) = observations%acceleration(:, k) + p(1)*simulator%arc%loads(k)%drag
        end do
    end subroutine add_wander

    !> Drag that is neither a straight line nor a wave: errors well below those of `optimal`, and the sigmas
    !> say so.
    subroutine test_wander(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RUNS = 10
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        real(dp) :: sequential, optimal, total, limits(2)
        integer :: run

        call prepare('front-1', .false., simulator)
        sequential = 0
        optimal = 0
        total = 0
        do run = 1, RUNS
            call make_observations(simulator, SEED, run, observations, only_used_head=.true.)
            call add_wander(simulator, run, 0.002_dp, 12.0_dp, 0.1_dp, observations)
            if (solve_fails('sequential', observations, solution, error)) return
            sequential = sequential + (solution%offset(3) - simulator%case%satellite%offset(3))**2
            total = total + normalised_square(solution, simulator%case%satellite%offset)
            if (solve_fails('optimal', observations, solution, error)) return
            optimal = optimal + (solution%offset(3) - simulator%case%satellite%offset(3))**2
        end do
        call check(error, sqrt(sequential) < 0.7_dp*sqrt(optimal), 'RMS of d_z against optimal')
        limits = chi_square_limits(3*RUNS)
        call check(error, total < limits(2), 'errors within the sigmas')
    end subroutine test_wander

    !> Spikes of all sizes, at the ends and in a row; wrong quaternions. The estimate hardly changes.
    subroutine test_spikes(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: AT(8) = [1, 100, 200, 201, 202, 350, 351, 600]
        real(dp), parameter :: SIZES(8) = [1e-6_dp, 4e-9_dp, 1e-5_dp, -1e-6_dp, 1e-8_dp, 5e-9_dp, 5e-9_dp, -1e-7_dp]
        type(observation_set_t) :: observations
        type(solution_t) :: clean, spiked
        real(dp) :: true_offset(3)

        call straight_set('front-3', 1, observations, true_offset)
        if (solve_fails('sequential', observations, clean, error)) return
        call check(error, all(clean%edited == 0), 'nothing to edit in clean samples')
        observations%acceleration(1, AT) = observations%acceleration(1, AT) + SIZES
        observations%acceleration(2, 333) = 1e-4_dp
        observations%quaternion(:, 50) = [0.0_dp, 0.6_dp, 0.0_dp, 0.8_dp]
        associate (q => observations%quaternion(:, 90))
            q(1) = q(1) + 3e-4_dp
            q = q/norm2(q)
        end associate
        if (solve_fails('sequential', observations, spiked, error)) return
        call check(error, spiked%edited(1), 9, 'values of the accelerometer edited')
        call check(error, spiked%edited(2), 2, 'samples of the star camera edited')
        call check(error, maxval(abs(spiked%offset - clean%offset)/sigma_of(clean)) < 0.3_dp, 'estimate')
        if (unmet(error, size(spiked%warnings), 3, 'a warning of each')) return
        associate (running => spiked%running)
            call check(error, running%edited_accelerometer(ubound(running%time, 1)) == 9 .and. &
                       running%edited_star_camera(ubound(running%time, 1)) == 2 .and. &
                       running%edited_accelerometer(150) == 2, 'counts of the running estimate')
        end associate
    end subroutine test_spikes

    !> Ten seconds without accelerometer, six without star camera.
    subroutine test_gaps(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: whole, with_gaps
        real(dp) :: true_offset(3)
        integer, allocatable :: kept(:)
        integer :: i

        call straight_set('back-3', 4, observations, true_offset)
        if (solve_fails('sequential', observations, whole, error)) return
        associate (times => observations%accelerometer_time)
            kept = pack([(i, i=1, size(times))], times < 20 .or. times > 30)
        end associate
        observations%accelerometer_time = observations%accelerometer_time(kept)
        observations%acceleration = observations%acceleration(:, kept)
        associate (times => observations%star_camera_time)
            kept = pack([(i, i=1, size(times))], times < 35 .or. times > 41)
        end associate
        observations%star_camera_time = observations%star_camera_time(kept)
        observations%star_camera_head = observations%star_camera_head(kept)
        observations%quaternion = observations%quaternion(:, kept)
        if (solve_fails('sequential', observations, with_gaps, error)) return
        associate (loss => sigma_of(with_gaps)/sigma_of(whole))
            call check(error, all(loss > 1) .and. all(loss < 1.5_dp), 'sigmas')
        end associate
        call check(error, maxval(abs(with_gaps%offset - whole%offset)/sigma_of(with_gaps)) < 2, 'estimate')
        call check(error, all(with_gaps%edited == 0), 'nothing edited')
    end subroutine test_gaps

    !> Ends with the estimate; the sigma never grows.
    subroutine test_running(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: solution, half
        real(dp) :: true_offset(3)
        integer :: n, k, stars

        call straight_set('front-2', 1, observations, true_offset)
        if (solve_fails('sequential', observations, solution, error)) return
        associate (running => solution%running)
            n = ubound(running%time, 1)
            call check(error, n, 600)
            call check(error, maxval(abs(running%offset(:, n) - solution%offset)) < 1e-9_dp .and. &
                       maxval(abs(running%sigma(:, n)/sigma_of(solution) - 1)) < 1e-9_dp, 'ends with the estimate')
            call check(error, all(running%sigma(:, 1:n) <= running%sigma(:, 0:n - 1)*(1 + 1e-12_dp)), &
                       'the sigma never grows')
            call check(error, all(running%sigma(:, 0) > 0.9_dp), 'nothing is known at first')
        end associate
        ! from the first half of the samples alone
        k = 300
        stars = count(observations%star_camera_time <= 30.01_dp)
        observations%accelerometer_time = observations%accelerometer_time(:k)
        observations%acceleration = observations%acceleration(:, :k)
        observations%star_camera_time = observations%star_camera_time(:stars)
        observations%star_camera_head = observations%star_camera_head(:stars)
        observations%quaternion = observations%quaternion(:, :stars)
        if (solve_fails('sequential', observations, half, error)) return
        associate (running => solution%running)
            call check(error, maxval(abs(running%offset(:, k) - half%offset)/sigma_of(half)) < 0.05_dp .and. &
                       maxval(abs(running%sigma(:, k)/sigma_of(half) - 1)) < 0.02_dp, 'half way')
        end associate
    end subroutine test_running

    subroutine test_no_noise_level(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        real(dp) :: true_offset(3)

        call straight_set('front-3', 1, observations, true_offset)
        observations%knowledge%accelerometer_noise(2)%level = 0
        call estimate_refused(error, 'sequential', observations, 'noise_level of accelerometer axis y')
        observations%knowledge%accelerometer_noise(2)%level = 1e-18_dp
        observations%knowledge%star_camera_sigma = 0
        call estimate_refused(error, 'sequential', observations, 'noise_about_axes')
    end subroutine test_no_noise_level

    !> A satellite that hardly turns does not show its offset.
    subroutine test_rods_off(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(error_t), allocatable :: failure

        call take_case('front-3', case)
        case%satellite%rods%count = 0
        call make_simulator(case, error_switches_t(curved_force=.false.), simulator)
        call observe(simulator, SEED, 1, observations, failure, only_used_head=.true.)
        if (.not. allocated(failure)) &
            call estimate_offset('sequential', observations, estimation_options_t(), solution, failure)
        if (allocated(failure)) then
            call check_says(error, failure%message, 'do not determine the offset')
        else
            call check(error, maxval(sigma_of(solution)) > 1e-3_dp, 'the sigma says that nothing is known')
        end if
    end subroutine test_rods_off

    !> A straight line asked for, and a wave in the drag: the sigmas are enlarged, with a warning.
    subroutine test_misfit(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution

        call prepare('front-1', .false., simulator, wave=[0.01_dp, 15.0_dp])
        call make_observations(simulator, SEED, 1, observations, only_used_head=.true.)
        if (solve_fails('sequential', observations, solution, error, sequential_options_t(STRAIGHT_LINE))) return
        call check(error, solution%variance_factor > 2, 'variance of the innovations')
        if (unmet(error, size(solution%warnings) == 1)) return
        call check_says(error, solution%warnings(1)%text, 'the innovations have a variance of')
    end subroutine test_misfit
end module test_sequential
