!> Simulated observations: their epochs, their noise, and that they are the same again.
module test_simulation
    use vocabulary
    use calibrations
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion, rotation_angle_between
    use statistics, only: chi_square_limits, Z_999
    use gracecg_environment_thermosphere, only: density_wave_t, REPORT_WAVE_AMPLITUDE, REPORT_WAVE_PERIOD
    use gracecg_simulation_dynamics, only: OMEGA, POSITION, ATTITUDE
    use gracecg_observations_observation_set, only: check_observations
    use gracecg_observations_knowledge, only: a_priori_t
    use gracecg_simulation_report_cases, only: report_case
    use gracecg_simulation_simulator, only: new_simulator, observe, &
        drawn_wave, flight_t, begin_flight, run_noise_t, begin_noise, observe_piece, operator_of_run
    use gracecg_simulation_simulation_files, only: simulation_order_t, simulation_summary_t, simulate_into
    use gracecg_observations_observation_files, only: read_observations
    use gracecg_files_file, only: file_exists, remove_file
    implicit none
    private
    public :: collect_simulation

    integer, parameter :: SEED_OF_RUNS = 1
    integer(i8), parameter :: SEED = SEED_OF_RUNS
    integer, parameter :: RUNS = 20     !! For statistics

contains

    subroutine collect_simulation(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('epochs', test_epochs), &
                    new_unittest('different-names-different-numbers', test_different), &
                    new_unittest('pieces-make-the-whole', test_pieces), &
                    new_unittest('files-are-those-of-the-whole', test_files), &
                    new_unittest('used-head-alone', test_used_head), &
                    new_unittest('observables-from-the-truth', test_observables), &
                    new_unittest('noise-of-each-instrument', test_noise), &
                    new_unittest('density-wave-in-the-acceleration', test_wave), &
                    new_unittest('drawn-wave', test_drawn_wave), &
                    new_unittest('wave-in-the-dynamics', test_wave_in_dynamics), &
                    new_unittest('the-truth-stays-behind', test_no_truth), &
                    new_unittest('intervals-are-refused', test_intervals), &
                    new_unittest('saturation-is-refused', test_saturation), &
                    new_unittest('scale-factors-age', test_aged)]
    end subroutine collect_simulation

    !> A short case whose magnetometer has a filter, and whose last second is not whole.
    subroutine short_case(case, failure)
        type(case_t), intent(out) :: case
        type(error_t), allocatable, intent(out) :: failure

        call report_case('front-1', case, failure)
        case%duration = 4.4_dp
        case%satellite%magnetometer%bandwidth = 0.5_dp
    end subroutine short_case

    !> A flight in pieces of any length, and what is drawn on it, are those of the whole arc, to the last bit.
    subroutine test_pieces(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: LENGTHS(6) = [1, 7, 10, 0, 9, 100]
        type(case_t) :: case
        type(flight_t) :: flight
        type(run_noise_t) :: noise
        type(simulator_t) :: whole, simulator
        type(observation_set_t) :: all_samples, piece
        type(error_t), allocatable :: failure
        integer :: i, at(4), n(4)

        call short_case(case, failure)
        if (.not. allocated(failure)) call new_simulator(case, whole, failure)
        if (.not. allocated(failure)) call observe(whole, SEED, 2, all_samples, failure)
        if (.not. allocated(failure)) call begin_flight(case, flight, simulator, failure)
        if (.not. allocated(failure)) call begin_noise(simulator, SEED, 2, noise, failure)
        if (failed(error, failure)) return
        at = 0
        do i = 1, size(LENGTHS)
            call flight%go_on(LENGTHS(i), simulator, failure)
            if (.not. allocated(failure)) &
                call observe_piece(simulator, operator_of_run(case, case%operator, SEED, 2), noise, piece, failure)
            if (failed(error, failure)) return
            if (i == 4) cycle   ! no new epoch: nothing is drawn, the epoch where it stands has no sample twice
            n = [size(piece%accelerometer_time), size(piece%magnetometer_time), size(piece%star_camera_time), &
                 size(piece%orbit_time)]
            call check(error, all(abs(piece%acceleration - all_samples%acceleration(:, at(1) + 1:at(1) + n(1))) <= 0) .and. &
                       all(abs(piece%field - all_samples%field(:, at(2) + 1:at(2) + n(2))) <= 0) .and. &
                       all(abs(piece%quaternion - all_samples%quaternion(:, at(3) + 1:at(3) + n(3))) <= 0) .and. &
                       all(abs(piece%star_camera_time - all_samples%star_camera_time(at(3) + 1:at(3) + n(3))) <= 0) .and. &
                       all(abs(piece%orbit_position - all_samples%orbit_position(:, at(4) + 1:at(4) + n(4))) <= 0))
            at = at + n
        end do
        call check(error, all(at == [44, 4, 16, 6]))
        call check(error, all(abs(simulator%arc%state(:, 44) - whole%arc%state(:, 44)) <= 0) .and. &
                   all(abs(simulator%star_camera_sigma - whole%star_camera_sigma) <= 0))
    end subroutine test_pieces

    !> The files of a run read back as what `observe` gives; an arc that cannot be flown leaves none.
    subroutine test_files(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: FOLDER = 'build/test-output/simulated'
        type(simulation_order_t) :: order
        type(simulation_summary_t) :: summary
        type(simulator_t) :: simulator
        type(observation_set_t) :: expected, found
        type(error_t), allocatable :: failure

        order%folder = FOLDER
        order%run = 3
        allocate (order%comments(1))
        order%comments(1) = 'a test'
        call short_case(order%case, failure)
        order%case%limits%rate = 1e-4_dp        ! less than nadir pointing takes
        if (.not. allocated(failure)) call simulate_into(order, summary, failure)
        call check_fails(error, failure, 'front-1 ... rate_deg_s')
        call check(error, .not. file_exists(FOLDER//'/truth.csv') .and. .not. file_exists(FOLDER//'/accelerometer.csv') .and. &
                   .not. file_exists(FOLDER//'/truth.csv.part1'))
        call short_case(order%case, failure)
        if (.not. allocated(failure)) call simulate_into(order, summary, failure)
        if (.not. allocated(failure)) call new_simulator(order%case, simulator, failure)
        if (.not. allocated(failure)) call observe(simulator, order%seed, order%run, expected, failure)
        if (.not. allocated(failure)) call read_observations(FOLDER, found, failure)
        if (failed(error, failure)) return
        call check(error, all(summary%rows == [44, 16, 4, 6, 0, 0, 0]) .and. summary%moves_rods)
        call check(error, all(abs(found%acceleration - expected%acceleration) <= 0) .and. &
                   all(abs(found%field - expected%field) <= 0) .and. &
                   all(abs(found%quaternion - expected%quaternion) <= 0) .and. &
                   all(abs(found%orbit_position - expected%orbit_position) <= 0) .and. &
                   all(abs(found%knowledge%star_camera_sigma - expected%knowledge%star_camera_sigma) <= 0))
        call remove_file(FOLDER//'/truth.csv')
        call remove_file(FOLDER//'/accelerometer.csv')
    end subroutine test_files

    !> An accelerometer whose full scale lies below its bias delivers samples at the full scale, and no estimator
    !> takes them; with the report's full scale nothing is refused. The same for the magnetometer.
    subroutine test_saturation(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure
        character(*), parameter :: PARTS = 'full scale ... 600 of 600 ... 0.1 s'

        call make_simulator('front-1', simulator)
        simulator%case%satellite%accelerometer%limited = .true.
        simulator%case%satellite%magnetometer%limited = .true.
        call observe(simulator, SEED, 1, observations, failure)
        if (.not. allocated(failure)) call check_observations(observations, failure)
        if (failed(error, failure)) return
        simulator%case%satellite%accelerometer%range = 2e-5_dp      ! bias y -2.28e-5 m/s^2
        call observe(simulator, SEED, 1, observations, failure)
        call check(error, abs(maxval(abs(observations%acceleration)) - 2e-5_dp) <= 0)
        call check_observations(observations, failure)
        call check_fails(error, failure, PARTS)
        observations%knowledge%accelerometer_range = 0              ! an operator who does not know it
        call check_observations(observations, failure)
        if (failed(error, failure)) return
        simulator%case%satellite%accelerometer%range = 5e-5_dp
        simulator%case%satellite%magnetometer%range = 2e-5_dp       ! the field has 2.4e-5 T along x
        call observe(simulator, SEED, 1, observations, failure)
        call check_observations(observations, failure)
        call check_fails(error, failure, 'magnetometer ... full scale')
    end subroutine test_saturation

    !> The scale factors three years after their calibration: section 3.2.1 lets y change by 1 % a year, x by 0.01
    !> and z by 0.2.
    subroutine test_aged(error)
        type(error_type), allocatable, intent(out) :: error
        type(a_priori_t) :: a_priori

        call check(error, all(abs(a_priori%aged_scale_sigmas() - a_priori%sigma_scale_factors) <= 0))
        a_priori%sigma_scale_factors = [4e-4_dp, 0.04_dp, 8e-3_dp]
        a_priori%years_since_calibration = 3
        call check(error, maxval(abs(a_priori%aged_scale_sigmas() - [5e-4_dp, 0.05_dp, 0.01_dp])) < 1e-15_dp)
    end subroutine test_aged

    subroutine test_epochs(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        integer :: i, head

        call make_simulator('front-1', simulator)
        call make_observations(simulator, SEED_OF_RUNS, 1, observations)
        if (unmet(error, all(shape(observations%acceleration) == [3, 600]) .and. &
                  all(shape(observations%quaternion) == [4, 240]) .and. all(shape(observations%field) == [3, 60]))) return
        call check(error, maxval(abs(observations%accelerometer_time - [(i/10.0_dp, i=1, 600)])), 0.0_dp, thr=1e-13_dp)
        call check(error, maxval(abs(observations%magnetometer_time - [(i, i=1, 60)])), 0.0_dp, thr=1e-13_dp)
        do head = 1, 2
            if (unmet(error, count(observations%star_camera_head == head), 120)) return
            associate (times => pack(observations%star_camera_time, observations%star_camera_head == head))
                call check(error, maxval(abs(times - [(i/2.0_dp, i=1, 120)])), 0.0_dp, thr=1e-13_dp)
            end associate
        end do
    end subroutine test_epochs

    !> Greatest differences of accelerations, quaternions and field, in that order.
    pure function differences(a, b) result(greatest)
        type(observation_set_t), intent(in) :: a, b
        real(dp) :: greatest(3)

        greatest = [maxval(abs(a%acceleration - b%acceleration)), &
                    maxval(abs(a%quaternion - b%quaternion)), maxval(abs(a%field - b%field))]
    end function differences

    !> Another run, seed, case number or satellite draws other numbers in every instrument. (The
    !> truth is the same simulator's, so that only the noise can differ.)
    subroutine test_different(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator, other
        type(observation_set_t) :: reference, changed

        call make_simulator('front-1', simulator)
        call make_observations(simulator, SEED_OF_RUNS, 7, reference)
        other = simulator
        call make_observations(other, SEED_OF_RUNS, 8, changed)
        call check_changed('run')
        call make_observations(other, SEED_OF_RUNS + 1, 7, changed)
        call check_changed('seed')
        other%case%number = 2
        call make_observations(other, SEED_OF_RUNS, 7, changed)
        call check_changed('case')
        other = simulator
        other%case%satellite%name = 'back'
        call make_observations(other, SEED_OF_RUNS, 7, changed)
        call check_changed('satellite')
        other%case%number = 0
        call make_observations(other, SEED_OF_RUNS, 7, reference)
        other%case%name = 'front-1a'
        call make_observations(other, SEED_OF_RUNS, 7, changed)
        call check_changed('name of a case without number')
        call check(error, simulator%case%label() == 1 .and. other%case%label() > 9999, 'labels')

    contains

        subroutine check_changed(what)
            character(*), intent(in) :: what

            call check(error, all(differences(reference, changed) > &
                       [1e-10_dp, 1e-7_dp, 1e-10_dp]), what)
        end subroutine check_changed
    end subroutine test_different

    subroutine test_used_head(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(observation_set_t) :: full, alone
        integer :: head, i

        call make_simulator('front-1', simulator)
        do head = 1, 2
            simulator%case%operator%head = head
            call make_observations(simulator, SEED_OF_RUNS, 4, full)
            call make_observations(simulator, SEED_OF_RUNS, 4, alone, only_used_head=.true.)
            if (unmet(error, all(alone%star_camera_head == head) .and. &
                      size(alone%star_camera_head) == 120)) return
            associate (used => pack([(i, i=1, 240)], full%star_camera_head == head))
                call check(error, maxval(abs(alone%quaternion - full%quaternion(:, used))), 0.0_dp)
                call check(error, maxval(abs(alone%star_camera_time - &
                           full%star_camera_time(used))), 0.0_dp)
            end associate
            call check(error, maxval(abs(alone%acceleration - full%acceleration)) + &
                       maxval(abs(alone%field - full%field)), 0.0_dp)
        end do
    end subroutine test_used_head

    !> Without noise: eqs. (3-1), (3-7)-(3-10) and (3-23) and the mounting, from the true arc.
    subroutine test_observables(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        real(dp) :: a(3), expected(3), d(3), radius
        integer :: i, k

        call make_simulator('front-1', simulator)
        call observe_without_noise(simulator, density_wave_t(), observations)
        d = simulator%case%satellite%offset
        associate (arc => simulator%arc, instrument => simulator%case%satellite%accelerometer)
            do k = 1, 600
                radius = norm2(arc%state(POSITION, k))
                a = arc%loads(k)%drag + arc%loads(k)%srp + arc%loads(k)%erp + &
                    cross(arc%omega_dot(:, k), d) + &
                    cross(arc%state(OMEGA, k), cross(arc%state(OMEGA, k), d)) + &
                    EARTH_GM/radius**3*(d - 3*dot_product(arc%loads(k)%vertical, &
                                        d)*arc%loads(k)%vertical)
                expected = instrument%bias + instrument%scale1*a + instrument%scale2*a**2 + &
                           instrument%scale3*a**3
                call check(error, maxval(abs(observations%acceleration(:, k) - expected)), 0.0_dp, &
                           thr=1e-19_dp)
            end do
            do i = 1, 60
                expected = arc%loads(10*i)%field + [50e-9_dp, -30e-9_dp, 25e-9_dp]
                call check(error, maxval(abs(observations%field(:, i) - expected)), 0.0_dp, &
                           thr=1e-19_dp)
            end do
            do i = 1, 120
                call check(error, rotation_angle_between(observations%quaternion(:, i), quaternion_product( &
                           simulator%case%satellite%star_camera%mounting(1), arc%state(ATTITUDE, 5*i))), 0.0_dp, thr=1e-14_dp)
            end do
        end associate
    end subroutine test_observables

    !> White noise of (3-2) with the corner at 0, whose variance is the two-sided level times 10 Hz; 3 nT of the
    !> magnetometer; turns about the star camera's axes as the operator is told, most about the boresight. Variance by
    !> chi-square, mean by the normal distribution, both with 99.9 % limits.
    subroutine test_noise(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SIGMA(3) = [3.16227766e-10_dp, 3.16227766e-9_dp, 3.16227766e-10_dp]
        type(simulator_t) :: simulator
        type(observation_set_t) :: clean, noisy
        real(dp) :: squares(3, 3), total(3, 3), turn(4)     ! of accelerometer, magnetometer, star camera
        integer :: run, i

        call make_simulator('front-1', simulator)
        simulator%case%satellite%accelerometer%noise%corner = 0
        squares = 0
        total = 0
        do run = 1, RUNS
            call make_observations(simulator, SEED_OF_RUNS, run, noisy, only_used_head=.true.)
            call observe_without_noise(simulator, drawn_wave(simulator, SEED, run), clean)
            call add(1, noisy%acceleration - clean%acceleration)
            call add(2, noisy%field - clean%field)
            do i = 1, 120
                turn = quaternion_product(noisy%quaternion(:, i), conjugate_quaternion(clean%quaternion(:, i)))
                call add(3, reshape(2*sign(1.0_dp, turn(4))*turn(:3), [3, 1]))
            end do
        end do
        associate (camera => noisy%knowledge%star_camera_sigma)
            call check_white(squares(:, 1)/SIGMA**2, total(:, 1)/SIGMA, 600*RUNS, error)
            call check_white(squares(:, 2)/3e-9_dp**2, total(:, 2)/3e-9_dp, 60*RUNS, error)
            call check_white(squares(:, 3)/camera**2, total(:, 3)/camera, 120*RUNS, error)
            call check(error, camera(3) > 3*max(camera(1), camera(2)))
        end associate

    contains

        subroutine add(instrument, noise)
            integer, intent(in) :: instrument
            real(dp), intent(in) :: noise(:, :)

            squares(:, instrument) = squares(:, instrument) + sum(noise**2, 2)
            total(:, instrument) = total(:, instrument) + sum(noise, 2)
        end subroutine add
    end subroutine test_noise

    subroutine check_white(squares, total, n, error)
        real(dp), intent(in) :: squares(3), total(3)    !! Sums of n numbers in units of sigma
        integer, intent(in) :: n
        type(error_type), allocatable, intent(inout) :: error
        real(dp) :: limits(2)
        character(80) :: found

        limits = chi_square_limits(n)
        write (found, '(a, 3f10.2, a, 2f10.2)') 'squares', squares, ' limits', limits
        call check(error, all(squares > limits(1) .and. squares < limits(2)), trim(found))
        call check(error, maxval(abs(total)), 0.0_dp, 'sum', thr=Z_999*sqrt(real(n, dp)))
    end subroutine check_white

    !> A wave of a tenth of the model's density adds a tenth of the drag over the density scale, as the
    !> accelerometer's slope shows it.
    subroutine test_wave(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: AMPLITUDE = 0.1_dp, PERIOD = 12, PHASE = 0.4_dp
        type(simulator_t) :: simulator
        type(observation_set_t) :: calm, waving
        real(dp) :: expected(3)
        integer :: k

        call make_simulator('front-1', simulator)
        call observe_without_noise(simulator, density_wave_t(), calm)
        call observe_without_noise(simulator, density_wave_t(AMPLITUDE, PERIOD, PHASE), waving)
        do k = 1, 600
            expected = AMPLITUDE*sin(TWO_PI*0.1_dp*k/PERIOD + PHASE)*simulator%arc%loads(k)%drag/ &
                       simulator%case%density_scale* &
                       simulator%case%satellite%accelerometer%scale1
            ! quadratic scale factors up to 33 s^2/m, drag up to 7e-7 m/s^2: slope good to 5e-5
            call check(error, maxval(abs(waving%acceleration(:, k) - calm%acceleration(:, k) - &
                       expected)), &
                       0.0_dp, thr=5e-5_dp*AMPLITUDE*norm2(simulator%arc%loads(k)%drag))
        end do
        call check(error, maxval(abs(waving%quaternion - calm%quaternion)) + &
                   maxval(abs(waving%field - calm%field)), 0.0_dp)
    end subroutine test_wave

    !> Amplitude and period are the case's; the phase is another in every run and spread over the
    !> circle.
    subroutine test_drawn_wave(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 400
        type(simulator_t) :: simulator
        type(density_wave_t) :: wave
        complex(dp) :: resultant
        integer :: run

        call make_simulator('front-1', simulator)
        resultant = 0
        do run = 1, N
            wave = drawn_wave(simulator, SEED, run)
            call check(error, abs(wave%amplitude - REPORT_WAVE_AMPLITUDE) <= 0 .and. &
                       abs(wave%period - REPORT_WAVE_PERIOD) <= 0 .and. wave%phase >= 0 .and. wave%phase <= TWO_PI)
            resultant = resultant + exp(cmplx(0.0_dp, wave%phase, dp))
        end do
        ! Rayleigh's test: P(|R|^2/n > z) = exp(-z); exp(-6.9) = 0.001
        call check(error, abs(resultant)**2/N < 6.9_dp)
        simulator%case%density_wave_random = .false.
        wave = drawn_wave(simulator, SEED, 1)
        call check(error, wave%amplitude, 0.0_dp)
    end subroutine test_drawn_wave

    !> A wave of known phase goes into the equations of motion. What it does to the rotation is too
    !> little to see, so the samples are those with the wave put on the drag.
    subroutine test_wave_in_dynamics(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: drawn, fixed
        type(case_t) :: case
        type(observation_set_t) :: a, b, calm
        type(error_t), allocatable :: failure

        call make_simulator('front-1', drawn)
        case = drawn%case
        case%density_wave_random = .false.
        case%density_wave%phase = 0.4_dp
        call new_simulator(case, fixed, failure)
        if (failed(error, failure)) return
        call observe_without_noise(fixed, drawn_wave(fixed, SEED, 1), a)
        call observe_without_noise(drawn, case%density_wave, b)
        call observe_without_noise(drawn, density_wave_t(), calm)
        call check(error, maxval(abs(b%acceleration - calm%acceleration)) > 1e-9_dp)
        call check(error, maxval(abs(a%acceleration - b%acceleration)), 0.0_dp, thr=1e-12_dp)
    end subroutine test_wave_in_dynamics

    !> What the operator is told is the setup, the instruments' nominal noise and the mounting.
    subroutine test_no_truth(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations

        call make_simulator('front-1', simulator)
        call make_observations(simulator, SEED_OF_RUNS, 1, observations)
        associate (knowledge => observations%knowledge, case => simulator%case)
            call check(error, all(knowledge%accelerometer_noise%level == &
                       case%satellite%accelerometer%noise%level) .and. &
                       all(knowledge%accelerometer_noise%corner == &
                           case%satellite%accelerometer%noise%corner) .and. &
                       all(knowledge%accelerometer_noise%sides == case%satellite%accelerometer%noise%sides) .and. &
                       all(knowledge%mounting(:, 1) == case%satellite%star_camera%mounting(1)) .and. &
                       all(knowledge%mounting(:, 2) == case%satellite%star_camera%mounting(2)))
        end associate
    end subroutine test_no_truth

    !> A sampling interval that is not a multiple of the arc's.
    subroutine test_intervals(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(case_t) :: case, bad
        type(error_t), allocatable :: failure

        call report_case('front-1', case, failure)
        bad = case
        bad%satellite%star_camera%sampling_interval = 0.25_dp
        call new_simulator(bad, simulator, failure)
        call check_fails(error, failure, 'front-1 ... star camera ... 0.25 s ... 0.1 s')
        bad = case
        bad%satellite%accelerometer%sampling_interval = 0.05_dp
        call new_simulator(bad, simulator, failure)
        call check_fails(error, failure, 'accelerometer ... 0.05 s ... 0.1 s')
        bad = case
        bad%satellite%magnetometer%sampling_interval = 1.04_dp
        call new_simulator(bad, simulator, failure)
        call check_fails(error, failure, 'magnetometer ... 1.04 s')
    end subroutine test_intervals
end module test_simulation
