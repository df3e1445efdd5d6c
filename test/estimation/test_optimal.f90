!> The estimator optimal: editing, noise levels, waves and extra parameters on observations made from
!> known dynamics, noise drawn here.
module test_optimal
    use vocabulary
    use calibrations
    use gracecg_base_error, only: number_text
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_quaternion, only: quaternion_product, quaternion_from_axis_angle
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, noise_spectrum_t, TWO_SIDED
    use gracecg_spacecraft_torque_rods, only: new_torque_rods, rod_activation_t
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, information_matrix
    use gracecg_estimation_variance_components, only: estimate_spectrum
    use test_estimators, only: example, OFFSET
    implicit none
    private
    public :: collect_optimal

    real(dp), parameter :: LEVEL(3) = [1e-20_dp, 1e-18_dp, 1e-20_dp]    ! m^2 s^-4/Hz
    real(dp), parameter :: CORNER(3) = [0.005_dp, 0.1_dp, 0.005_dp]     ! Hz
    real(dp), parameter :: SIGMA(3) = [5e-6_dp, 5e-6_dp, 4e-5_dp]       ! Star camera, rad

contains

    subroutine collect_optimal(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('star-camera-between-the-steps', test_own_epochs), &
                    new_unittest('spikes-and-wrong-quaternions-are-left-out', test_editing), &
                    new_unittest('clean-data-stay-whole', test_clean), &
                    new_unittest('half-a-series-of-outliers-is-refused', test_too_many), &
                    new_unittest('noise-spectrum-from-data', test_spectrum), &
                    new_unittest('noise-levels-of-a-calibration-from-its-data', test_levels), &
                    new_unittest('a-wave-is-found-and-removed', test_wave), &
                    new_unittest('a-wave-beside-a-gap', test_gap), &
                    new_unittest('a-jump-is-found-and-removed', test_jump), &
                    new_unittest('a-jump-beside-a-wave', test_large_jump), &
                    new_unittest('another-step-changes-nothing', test_settled), &
                    new_unittest('curved-drag-does-not-pull-a-wave', test_curved_drag), &
                    new_unittest('rod-gain-and-magnetometer-bias-are-estimated', test_extra), &
                    new_unittest('a-belief-is-estimated-by-its-name', test_by_name), &
                    new_unittest('without-rods', test_without_rods), &
                    new_unittest('rods-that-did-not-fire', test_not_fired)]
    end subroutine collect_optimal

    !> The example with noise of the spectra above.
    subroutine noisy_example(observations, run)
        type(observation_set_t), intent(out) :: observations
        integer, intent(in) :: run              !! Of the random numbers
        type(random_stream_t) :: stream
        type(coloured_noise_t) :: noise
        type(error_t), allocatable :: failure
        real(dp), allocatable :: samples(:)
        real(dp) :: turn(3)
        integer :: axis, i

        call example(observations, interval=0.2_dp, star_camera_interval=1.0_dp)
        observations%knowledge%accelerometer_noise%level = LEVEL
        observations%knowledge%accelerometer_noise%corner = CORNER
        observations%knowledge%star_camera_sigma = SIGMA
        allocate (samples(size(observations%accelerometer_time)))
        stream = new_stream(31, 1, 1, run, 1)
        do axis = 1, 3
            noise = coloured_noise(noise_spectrum_t(LEVEL(axis), CORNER(axis), TWO_SIDED), 0.2_dp, failure)
            call noise%generate(stream, samples)
            observations%acceleration(axis, :) = observations%acceleration(axis, :) + samples
        end do
        do i = 1, size(observations%quaternion, 2)
            call stream%normals(turn)
            turn = SIGMA*turn
            observations%quaternion(:, i) = quaternion_product(quaternion_from_axis_angle(unit(turn), norm2(turn)), &
                                                               observations%quaternion(:, i))
        end do
    end subroutine noisy_example

    logical function fit_fails(observations, solution, error, with_checks, options)
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(out) :: solution
        type(error_type), allocatable, intent(inout) :: error
        logical, intent(in), optional :: with_checks
        type(estimation_options_t), intent(in), optional :: options
        type(estimation_options_t) :: own
        type(error_t), allocatable :: failure

        if (present(options)) own = options
        own%covariance = .false.
        own%optimal%estimate_within_limits = .false.
        if (present(with_checks)) own%covariance = with_checks
        call estimate_offset('optimal', observations, own, solution, failure)
        call check_passes(error, failure)
        call check(error, solution%converged)
        fit_fails = allocated(error)
    end function fit_fails

    !> Star-camera epochs that are no multiples of the accelerometer's interval.
    subroutine test_own_epochs(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: fine, observations
        type(solution_t) :: solution
        integer :: i

        call example(fine, interval=0.1_dp)
        observations = fine
        observations%accelerometer_time = fine%accelerometer_time(2::2)     ! every 0.2 s
        observations%acceleration = fine%acceleration(:, 2::2)
        observations%knowledge%accelerometer_interval = 0.2_dp
        observations%knowledge%star_camera_interval = 0.6_dp                    ! at 0.1, 0.7, 1.3 ... s
        observations%star_camera_time = fine%star_camera_time(1::6)
        observations%star_camera_head = fine%star_camera_head(1::6)
        observations%quaternion = fine%quaternion(:, 1::6)
        i = size(observations%star_camera_time)
        if (fit_fails(observations, solution, error)) return
        call check(error, norm2(solution%offset - OFFSET), 0.0_dp, thr=1e-9_dp)
        call check(error, solution%variance_factor < 1e-4_dp)
    end subroutine test_own_epochs

    !> A large spike, a small one, a run of three, and two wrong quaternions: found, and without
    !> influence: the estimate differs from that of the clean data by what the lost samples would have
    !> told.
    subroutine test_editing(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: clean, observations
        type(solution_t) :: reference, solution
        integer :: i

        call noisy_example(clean, 1)
        if (fit_fails(clean, reference, error)) return
        call check(error, sum(reference%edited), 0)
        observations = clean
        observations%acceleration(1, 50) = observations%acceleration(1, 50) + 1e-5_dp
        observations%acceleration(1, 200) = observations%acceleration(1, 200) - 5e-9_dp
        observations%acceleration(2, 120:122) = observations%acceleration(2, 120:122) + 2e-7_dp
        do i = 20, 21
            observations%quaternion(:, i) = quaternion_product( &
                quaternion_from_axis_angle([0.0_dp, 1.0_dp, 0.0_dp], 0.01_dp*i), observations%quaternion(:, i))
        end do
        if (fit_fails(observations, solution, error)) return
        call check(error, all(solution%edited == [5, 2]), 'samples left out')
        if (unmet(error, size(solution%warnings) >= 3)) return
        do i = 1, 3
            call check(error, abs(solution%offset(i) - reference%offset(i)) < 0.5_dp*sqrt(solution%covariance(i, i)))
            call check(error, solution%covariance(i, i) >= reference%covariance(i, i))
        end do
        observations = clean        ! beyond what a fit with it comes back from
        observations%acceleration(1, 200) = observations%acceleration(1, 200) + 1e-3_dp
        if (fit_fails(observations, solution, error)) return
        call check(error, all(solution%edited == [1, 0]), 'a spike of 1e-3 m/s^2')
        call check(error, all(abs(solution%offset - reference%offset) < 1e-6_dp), 'its offset')
    end subroutine test_editing

    !> In 60 arcs nothing is left out and no wave is found.
    subroutine test_clean(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        integer :: run

        do run = 1, 60
            call noisy_example(observations, run)
            if (fit_fails(observations, solution, error)) return
            call check(error, sum(solution%edited), 0)
            if (unmet(error, size(solution%parameters), 3)) return
            call check(error, abs(solution%variance_factor - 1) < 5*sqrt(2/900.0_dp), 'variance factor')
        end do
    end subroutine test_clean

    !> Where a third of an axis is scattered, the samples cannot be told from the faults.
    subroutine test_too_many(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        call noisy_example(observations, 1)
        observations%acceleration(3, ::6) = observations%acceleration(3, ::6) + 1e-6_dp
        observations%acceleration(3, 3::6) = observations%acceleration(3, 3::6) - 1e-6_dp
        call estimate_refused(error, 'optimal', observations, 'optimal ... axis z ... samples ... noise levels')
    end subroutine test_too_many

    !> Level and corner of 80 records of a minute with a straight line in them. A level's standard
    !> deviation is some 6 % a record, so the mean must come out within 3 %; the corner of the weak
    !> flicker cannot be seen in a minute, that of the strong one only roughly.
    subroutine test_spectrum(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RECORDS = 80, N = 600
        type(random_stream_t) :: stream
        type(coloured_noise_t) :: noise
        type(error_t), allocatable :: failure
        type(noise_spectrum_t) :: found(RECORDS)
        real(dp) :: series(N), line(2, N)
        logical :: kept(N)
        integer :: i, k, which

        kept = .true.
        kept(100:105) = .false.
        line(1, :) = 1
        line(2, :) = [(k/600.0_dp, k=1, N)]
        stream = new_stream(32, 1, 1, 1, 1)
        do which = 1, 2
            noise = coloured_noise(noise_spectrum_t(LEVEL(which), CORNER(which), TWO_SIDED), 0.1_dp, failure)
            do i = 1, RECORDS
                call noise%restart()
                call noise%generate(stream, series)
                series = series + 1e-6_dp*line(1, :) - 2e-7_dp*line(2, :)
                series(100:105) = 1
                call estimate_spectrum(0.1_dp, TWO_SIDED, [(k, k=1, N)], kept, series, line, found(i), failure)
                if (failed(error, failure)) return
            end do
            call check(error, abs(sum(found%level)/RECORDS/LEVEL(which) - 1) < 0.03_dp, 'level')
            if (which == 1) then
                call check(error, count(found%corner < 0.05_dp) > 0.9_dp*RECORDS, 'small corner')
            else
                call check(error, abs(sum(found%corner)/RECORDS/CORNER(which) - 1) < 0.25_dp, 'corner')
            end if
        end do
    end subroutine test_spectrum

    !> The setup says nothing of the noise: mean levels of 20 calibrations, and the estimate.
    subroutine test_levels(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RUNS = 20
        type(observation_set_t) :: observations
        type(estimation_options_t) :: options
        type(solution_t) :: known, solution
        real(dp) :: levels(3), angles(3)
        integer :: run, i

        levels = 0
        angles = 0
        do run = 1, RUNS
            call noisy_example(observations, run)
            if (fit_fails(observations, known, error)) return
            options = estimation_options_t()
            if (mod(run, 2) == 0) then
                options%optimal%noise = 'estimate'
                observations%knowledge%accelerometer_noise%level = 3*LEVEL
            else
                observations%knowledge%accelerometer_noise%level = 0
                observations%knowledge%star_camera_sigma = 0
            end if
            if (fit_fails(observations, solution, error, options=options)) return
            levels = levels + solution%noise_level/LEVEL/RUNS
            angles = angles + solution%star_camera_sigma**2/SIGMA**2/RUNS
            do i = 1, 3
                call check(error, abs(solution%offset(i) - known%offset(i)) < sqrt(known%covariance(i, i)), 'offset')
                call check(error, abs(solution%covariance(i, i)/known%covariance(i, i) - 1) < 1, 'sigma')
            end do
        end do
        ! a level's relative standard deviation is sqrt(2/300), more with a corner; of 60 angles sqrt(2/60)
        call check(error, maxval(abs(levels - 1)) < 0.1_dp, 'levels')
        call check(error, maxval(abs(angles - 1)) < 4*sqrt(2.0_dp/(60*RUNS)), 'angles')
    end subroutine test_levels

    !> A wave along x (without an orbit the airflow is taken along x) of unknown period.
    subroutine test_wave(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: PERIOD = 12.7_dp, AMPLITUDE = 2e-9_dp
        type(observation_set_t) :: clean, observations
        type(estimation_options_t) :: options
        type(solution_t) :: reference, solution
        integer :: i, n

        call noisy_example(clean, 5)
        if (fit_fails(clean, reference, error)) return
        observations = clean
        observations%acceleration(1, :) = clean%acceleration(1, :) + &
                                          AMPLITUDE*sin(TWO_PI*clean%accelerometer_time/PERIOD + 1)
        if (fit_fails(observations, solution, error)) return
        n = size(solution%parameters)
        call check(error, n, 7)         ! torque, sine and cosine, frequency, parabola
        call check(error, norm2(solution%parameters(4:5)%value), AMPLITUDE, thr=0.1_dp*AMPLITUDE)
        do i = 1, 3
            call check(error, abs(solution%offset(i) - reference%offset(i)) < 0.5_dp*sqrt(solution%covariance(i, i)))
        end do
        options%optimal%density_wave = 'none'
        if (fit_fails(observations, solution, error, options=options)) return
        if (unmet(error, size(solution%parameters), 3)) return
        call check(error, solution%variance_factor > 2, 'the wave is left in the residuals')
        options%optimal%density_wave = 'given'
        options%optimal%density_wave_period = PERIOD
        if (fit_fails(observations, solution, error, options=options)) return
        call check(error, solution%variance_factor < 1.2_dp)
    end subroutine test_wave

    !> The density wave of a run without its middle half: a fit without it takes it for an offset, and leaves a line of 14 s.
    subroutine test_gap(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        integer, allocatable :: left(:)
        integer :: i

        call take_calibration('back-2', calibration)
        call make_observations(calibration%case, 7, 1, observations)
        left = pack([(i, i=1, size(observations%accelerometer_time))], abs(observations%accelerometer_time - 30) > 15)
        observations%accelerometer_time = observations%accelerometer_time(left)
        observations%acceleration = observations%acceleration(:, left)
        if (fit_fails(observations, solution, error)) return
        call check(error, any([(index(solution%warnings(i)%text, 'wave of period 19.') > 0, i=1, size(solution%warnings))]))
        call check(error, all(abs(solution%offset - calibration%case%satellite%offset) < &
                              4*[(sqrt(solution%covariance(i, i)), i=1, 3)]))
    end subroutine test_gap

    !> A step of the acceleration along x is found at its sample, estimated with its size, and does not move the offset;
    !> noise has none, and what is no noise is not taken for one.
    subroutine test_jump(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: JUMP = 2e-9_dp
        integer, parameter :: PLACE = 84
        type(observation_set_t) :: clean, observations
        type(estimation_options_t) :: options
        type(solution_t) :: reference, solution
        integer :: i, run

        options%covariance = .false.
        do run = 1, 20
            call noisy_example(observations, run)
            if (estimate_fails(error, 'optimal', observations, options, solution)) return
            call check(error, .not. any(solution%parameters%name == 'jump_x'), 'none is there')
            if (run /= 5) cycle
            reference = solution
            clean = observations
        end do
        observations = clean
        observations%acceleration(1, PLACE:) = clean%acceleration(1, PLACE:) + JUMP
        if (estimate_fails(error, 'optimal', observations, options, solution)) return
        i = findloc(solution%parameters%name, 'jump_x', 1)
        call check(error, i > 0, 'found')
        call check(error, abs(solution%parameters(i)%value - JUMP) < 4*solution%parameters(i)%sigma, 'its size')
        call check(error, abs(solution%parameters(i + 1)%value) < 4*solution%parameters(i + 1)%sigma, 'none along y')
        if (unmet(error, any([(index(solution%warnings(i)%text, 'jumps at') > 0, i=1, size(solution%warnings))]), 'warning')) return
        do i = 1, 3
            call check(error, abs(solution%offset(i) - reference%offset(i)) < 0.5_dp*sqrt(solution%covariance(i, i)))
        end do
        ! One that is small, and as good at other times, does not move the offset, and is no warning
        observations%acceleration(1, PLACE:) = clean%acceleration(1, PLACE:) + JUMP/4
        if (estimate_fails(error, 'optimal', observations, options, solution)) return
        if (unmet(error, any(solution%parameters%name == 'jump_x'), 'a small one')) return
        call check(error, .not. any([(index(solution%warnings(i)%text, 'whose time') > 0, i=1, size(solution%warnings))]), 'silent')
        observations%acceleration(1, :) = clean%acceleration(1, :) + 1e-8_dp*sin(TWO_PI*clean%accelerometer_time/3)
        options%optimal%density_wave = 'none'
        if (estimate_fails(error, 'optimal', observations, options, solution)) return
        call check(error, .not. any(solution%parameters%name == 'jump_x'), 'a wave is none')
    end subroutine test_jump

    !> A step beside a density wave, and larger: it was taken for a long wave, and noise blamed.
    subroutine test_large_jump(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: JUMPS(2) = [1e-8_dp, 2e-8_dp], TIME = 33
        type(calibration_t) :: calibration
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        integer :: i, k

        call take_calibration('front-3', calibration)
        do k = 1, size(JUMPS)
            call make_observations(calibration%case, 3, 1, observations)
            where (observations%accelerometer_time > TIME) observations%acceleration(1, :) = &
                observations%acceleration(1, :) + JUMPS(k)
            if (estimate_fails(error, 'optimal', observations, estimation_options_t(), solution)) return
            if (unmet(error, any([(index(solution%warnings(i)%text, 'jumps at 33') > 0, i=1, size(solution%warnings))]), &
                      'the time')) return
            call check(error, any([(index(solution%warnings(i)%text, 'wave of period 19.') > 0, i=1, size(solution%warnings))]))
            call check(error, .not. solution%beliefs%has_contradiction(), 'nothing is blamed')
            call check(error, all(abs(solution%offset - calibration%case%satellite%offset) < &
                                  4*[(sqrt(solution%covariance(i, i)), i=1, 3)]))
        end do
    end subroutine test_large_jump

    !> The estimate solves the normal equations with partials of its own state, though the fit takes most of its steps
    !> with those of an earlier one: another step of Gauss and Newton moves no parameter by 1e-5 of its sigma.
    subroutine test_settled(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(estimation_options_t) :: options
        type(solution_t) :: solution
        type(whitened_problem_t) :: problem
        type(error_t), allocatable :: failure
        real(dp), allocatable :: information(:, :), rhs(:), residuals(:), change(:), covariance(:, :)
        real(dp) :: condition
        integer :: run, i, n

        options%covariance = .false.
        do run = 1, 3       ! without a wave, and with two
            call noisy_example(observations, run)
            observations%acceleration(1, :) = observations%acceleration(1, :) + &
                                              (run - 1)*1e-9_dp*sin(TWO_PI*observations%accelerometer_time/12 + run)
            call estimate_optimal(observations, options, solution, failure, problem=problem)
            if (failed(error, failure)) return
            call check(error, any(solution%parameters%name == 'wave_sin') .eqv. run > 1)
            call information_matrix(problem, information, rhs, residuals)
            n = size(rhs)
            allocate (change(n), covariance(n, n))
            call solve_normal_equations(information, rhs, change, covariance, condition, failure)
            if (failed(error, failure)) return
            call check(error, all(abs(change) < 1e-5_dp*[(sqrt(covariance(i, i)), i=1, n)]), 'run '//integer_text(run))
            deallocate (change, covariance)
        end do
    end subroutine test_settled

    !> Without noise: a wave and a parabola of the drag together are recognised as what they are. A wave alone,
    !> which the parabola pulls, leaves an error of the offset of several sigma.
    subroutine test_curved_drag(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: PERIOD = 11.3_dp, AMPLITUDE = 2e-9_dp, PARABOLA = 3e-9_dp
        type(observation_set_t) :: clean, observations
        type(solution_t) :: reference, solution
        integer :: i

        call example(clean, interval=0.2_dp, star_camera_interval=0.2_dp)
        if (fit_fails(clean, reference, error)) return
        observations = clean
        associate (t => clean%accelerometer_time)
            observations%acceleration(1, :) = clean%acceleration(1, :) + AMPLITUDE*sin(TWO_PI*t/PERIOD + 1) + &
                                              PARABOLA*(t/30 - 1)**2
        end associate
        if (fit_fails(observations, solution, error)) return
        if (unmet(error, size(solution%parameters), 7)) return
        call check(error, solution%parameters(7)%value, 2*PARABOLA/3, thr=0.01_dp*PARABOLA)    ! of P2
        do i = 1, 3
            call check(error, abs(solution%offset(i) - reference%offset(i)) < 0.02_dp*sqrt(solution%covariance(i, i)))
        end do
    end subroutine test_curved_drag

    !> Rods that are 2 % stronger than the setup says, then a magnetometer's bias: the offset is wrong by
    !> a per cent, or right when the parameter is estimated. (Both together cannot be told apart while
    !> the rods are in phase; of the bias, only what changes the torque can be seen: b_y - b_z.)
    subroutine test_extra(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: GAIN = 0.02_dp, FIELD(3) = [0.0_dp, 3e-7_dp, -2e-7_dp]
        type(observation_set_t) :: clean, observations
        type(estimation_options_t) :: options
        type(solution_t) :: solution
        integer :: i

        call example(clean, interval=0.2_dp, star_camera_interval=0.2_dp)
        clean%knowledge%a_priori%sigma_rod_gain = 1
        clean%knowledge%a_priori%sigma_magnetometer_bias = 1e-4_dp
        clean%knowledge%a_priori%sigma_scale_factors = 1e-6_dp
        options%optimal%estimate_scale_factors = .true.

        observations = clean
        observations%knowledge%rods%activations%amplitude = clean%knowledge%rods%activations%amplitude/(1 + GAIN)
        call check_offset(.false., 'gain not estimated')
        options%optimal%estimate_rod_gain = .true.
        call check_offset(.true., 'gain estimated')
        call check(error, value_of('rod_gain'), GAIN, thr=1e-4_dp)
        do i = 1, size(solution%parameters)     ! known a priori, and nothing says otherwise
            if (index(solution%parameters(i)%name, 'scale') /= 1) cycle
            call check(error, abs(solution%parameters(i)%value) < 1e-6_dp .and. &
                       solution%parameters(i)%sigma <= 1e-6_dp .and. solution%parameters(i)%sigma > 0.99e-6_dp)
        end do

        observations = clean
        options%optimal%estimate_rod_gain = .false.
        do i = 1, size(observations%field, 2)
            observations%field(:, i) = observations%field(:, i) + FIELD
        end do
        call check_offset(.false., 'bias not estimated')
        options%optimal%estimate_magnetometer_bias = .true.
        call check_offset(.true., 'bias estimated')
        call check(error, value_of('field_bias_y') - value_of('field_bias_z'), FIELD(2) - FIELD(3), thr=2e-9_dp)

    contains

        subroutine check_offset(right, name)
            logical, intent(in) :: right
            character(*), intent(in) :: name

            if (fit_fails(observations, solution, error, options=options)) return
            associate (difference => norm2(solution%offset - OFFSET)/norm2(OFFSET))
                call check(error, merge(difference < 1e-4_dp, difference > 5e-3_dp, right), name)
            end associate
        end subroutine check_offset

        real(dp) function value_of(name) result(value)
            character(*), intent(in) :: name

            value = sum(solution%parameters%value, mask=solution%parameters%name == name)
        end function value_of
    end subroutine test_extra

    !> A gain of one rod and a delay of all that are believed wrong, named in the options, are found, and d with them.
    subroutine test_by_name(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: GAIN = 2, LATE = 0.3_dp     ! Of rod y, believed by true; of all rods, s
        type(observation_set_t) :: observations
        type(estimation_options_t) :: options
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        character(14), parameter :: NAMES(2) = [character(14) :: 'rod_gain_y', 'rod_delay']
        real(dp) :: expected(2), sigma(3)
        integer :: i, k

        call noisy_example(observations, 3)
        observations%knowledge%rods%gain(2) = GAIN*observations%knowledge%rods%gain(2)
        observations%knowledge%rods%delay = observations%knowledge%rods%delay - LATE
        expected = [1/GAIN - 1, LATE]
        options%optimal%also = 'rod_gain_y, rod_delay'
        options%covariance = .false.
        call estimate_optimal(observations, options, solution, failure)
        if (failed(error, failure)) return
        do i = 1, size(NAMES)
            k = findloc(solution%parameters%name, NAMES(i)(:12), 1)
            associate (one => solution%parameters(k))
                call check(error, abs(one%value - expected(i)) < 4*one%sigma + 1e-3_dp*abs(expected(i)) .and. &
                           one%sigma < 0.3_dp*abs(expected(i)), trim(NAMES(i))//number_text(one%value)//number_text(one%sigma))
            end associate
        end do
        sigma = sigmas(solution%covariance)
        call check(error, all(abs(solution%offset - OFFSET) < 4*sigma), 'offset')
    end subroutine test_by_name

    !> Rods at rest: the offset is hardly observable, or not at all; said, or an error.
    subroutine test_without_rods(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure
        type(rod_activation_t) :: none(0)
        type(estimation_options_t) :: options

        call noisy_example(observations, 1)
        call new_torque_rods(none, observations%knowledge%rods, failure)
        observations%knowledge%inertia = 0
        observations%knowledge%inertia(1, 1) = 70
        observations%knowledge%inertia(2, 2) = 345
        observations%knowledge%inertia(3, 3) = 388
        options%guess_angular_velocity = [0.0_dp, 1.1e-3_dp, 0.0_dp]
        observations%quaternion = spread(observations%quaternion(:, 1), 2, size(observations%quaternion, 2))
        call estimate_refused(error, 'optimal', observations, 'optimal ... singular ... d_', options)
    end subroutine test_without_rods

    !> The satellite turned by its rods, but the setup has them at rest during most of the arc.
    subroutine test_not_fired(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        call noisy_example(observations, 1)
        observations%knowledge%rods%activations%amplitude = -observations%knowledge%rods%activations%amplitude
        call estimate_refused(error, 'optimal', observations, 'optimal')
    end subroutine test_not_fired
end module test_optimal
