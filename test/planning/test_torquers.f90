!> Satellites that are turned by torques of their own: the examples nggm and taiji-1 against an independent least squares and over
!> 100 seeds, torque histories, and what is refused.
module test_torquers
    use vocabulary
    use calibrations
    use gracecg_estimation_action, only: action_t, known_offset_t, known_of, decide
    use gracecg_base_error, only: number_text
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_observations_accelerometer_line, only: accelerometer_line_t
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion, quaternion_from_axis_angle
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_files_file, only: remove_file
    use gracecg_spacecraft_torque_rods
    use gracecg_observations_observation_files, only: write_observations, read_observations
    use gracecg_simulation_case, only: case_from_text, case_text
    use gracecg_simulation_simulator, only: new_simulator, observe, measure_rods
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_planning_bound, only: case_bound_t, bound_of_case
    use gracecg_planning_calibration, only: find_calibration, calibration_from_text, calibration_text
    use gracecg_planning_candidates, only: design_settings_t, usual_amplitude, usual_shares
    use gracecg_planning_design, only: manoeuvre_design_t
    use gracecg_planning_planner, only: plan_manoeuvre
    implicit none
    private
    public :: collect_torquers

    character(32), parameter :: EXAMPLES(2) = [character(32) :: 'example/cases/nggm.nml', 'example/cases/taiji-1.nml']
    character(*), parameter :: SET = FOLDER//'torquers'

contains

    subroutine collect_torquers(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('torque-of-rods-and-torquers', test_torque), &
                    new_unittest('bound-by-independent-least-squares', test_bound), &
                    new_unittest('hundred-seeds-at-the-bound', test_seeds), &
                    new_unittest('mean-and-contrasts', test_contrasts), &
                    new_unittest('several-accelerometers', test_several), &
                    new_unittest('several-quiet-ones-are-sound', test_several_quiet), &
                    new_unittest('gains-of-a-swing', test_gains), &
                    new_unittest('wrong-beliefs-are-named', test_beliefs), &
                    new_unittest('history-beside-the-observations', test_history), &
                    new_unittest('history-as-a-case', test_torque_file), &
                    new_unittest('case-files', test_case_files), &
                    new_unittest('design', test_design)]
    end subroutine collect_torquers

    !> The calibration of an example; with everything known exactly but what the noise hides, or as it is.
    subroutine take_example(path, exact, calibration)
        character(*), intent(in) :: path
        logical, intent(in) :: exact
        type(calibration_t), intent(out) :: calibration

        call take_calibration(path, calibration)
        calibration%options%covariance = .false.        ! the fit is not checked
        if (.not. exact) return
        calibration%case%operator%sigma = 0
        calibration%case%satellite%line%scale_sigma = 1e-9_dp
        calibration%case%operator%a_priori%sigma_rod_gain = 1e-9_dp
        calibration%options%optimal%estimate_scale_factors = .false.
        calibration%options%optimal%estimate_rod_gain = .false.
        calibration%options%optimal%also = ''
    end subroutine take_example

    !> The torque of rods depends on the field by (2-25), that of torquers does not; a moment in a constant field and a
    !> torquer driven by the product do the same.
    subroutine test_torque(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: MOMENT(3) = [1.0_dp, -2.0_dp, 3.0_dp], FIELD(3) = [2e-5_dp, 1e-5_dp, -4e-5_dp]
        type(torque_rods_t) :: rods, torquers

        torquers%direct = .true.
        call check(error, norm2(torque_of(rods, MOMENT, FIELD) - cross(MOMENT, FIELD)) <= 0)
        call check(error, norm2(torque_of(torquers, MOMENT, FIELD) - MOMENT) <= 0)
        call check(error, norm2(torque_of(torquers, cross(MOMENT, FIELD), -FIELD) - torque_of(rods, MOMENT, FIELD)) <= 0)
    end subroutine test_torque

    !> The bound of both examples, and of the first with two and one of its three accelerometers, by numerical partials of
    !> simulated samples and a dense covariance of the noise: nothing of the estimators is used. With gains and scale factors
    !> known exactly, and within their limits.
    subroutine test_bound(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(case_bound_t) :: bound
        type(error_t), allocatable :: failure
        real(dp) :: covariance(3, 3), sigma(3)
        integer, parameter :: EXAMPLE(4) = [1, 1, 1, 2], ACCELEROMETERS(4) = [3, 2, 1, 1]
        integer :: i, exact

        do i = 1, size(EXAMPLE)
            do exact = 0, 1
                call take_example(EXAMPLES(EXAMPLE(i)), exact == 1, calibration)
                calibration%case%satellite%line%number = ACCELEROMETERS(i)
                call bound_of_case(calibration%case, calibration%options, bound, failure)
                if (failed(error, failure)) return
                call least_squares(calibration, covariance)
                sigma = sigmas(covariance)
                call check(error, all(abs(bound%sigma/sigma - 1) < 0.05_dp), trim(calibration%case%name)//', '// &
                           integer_text(ACCELEROMETERS(i)))
            end do
        end do
    end subroutine test_bound

    !> Samples M (d + r) + f at three places and at two: the mean is M d + f, the first contrast rho M e, the second 0; the
    !> weights are orthonormal and sum to 0.
    subroutine test_contrasts(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: M(3, 3) = reshape([1e-6_dp, 2e-6_dp, -3e-6_dp, -4e-6_dp, 5e-6_dp, 6e-6_dp, 7e-6_dp, -8e-6_dp, &
                                                  9e-6_dp], [3, 3])
        real(dp), parameter :: D(3) = [1e-4_dp, -2e-4_dp, 3e-4_dp], F(3) = [1e-8_dp, -2e-8_dp, 3e-8_dp]
        type(accelerometer_line_t) :: line
        real(dp) :: first(3, 1), further(3, 1, 2)
        real(dp), allocatable :: contrasts(:, :)
        integer :: k, n

        line%spacing = [0.3_dp, -0.1_dp, 0.2_dp]
        do n = 3, 2, -1
            line%number = n
            associate (c => line%weights())
                call check(error, all(abs(matmul(transpose(c), c) - identity(n - 1)) < 1e-15_dp), 'orthonormal')
                call check(error, all(abs(sum(c, 1)) < 1e-15_dp), 'sums')
            end associate
            first(:, 1) = matmul(M, D + line%place(1)) + F
            do k = 2, n
                further(:, 1, k - 1) = matmul(M, D + line%place(k)) + F
            end do
            call line%combine(first, further(:, :, :n - 1), contrasts)
            call check(error, norm2(first(:, 1) - matmul(M, D) - F) < 1e-20_dp, 'mean')
            call check(error, norm2(contrasts(:3, 1) - line%reach()*matmul(M, line%direction())) < 1e-20_dp, 'first contrast')
            call check(error, norm2(contrasts(4:, 1)) < 1e-20_dp, 'second contrast')
        end do
    end subroutine test_contrasts

    !> Samples of three accelerometers are the same from files; lost rows, files and series, and values of another unit are
    !> refused.
    subroutine test_several(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations, again
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        character(:), allocatable :: good
        integer :: last

        call take_example(EXAMPLES(1), .false., calibration)
        call make_simulator(calibration%case, simulator)
        call make_observations(simulator, 5, 1, observations)
        call write_observations(SET, observations, [character(1) ::], failure)
        if (.not. allocated(failure)) call read_observations(SET, again, failure)
        if (failed(error, failure)) return
        call estimate_offset('sequential', again, calibration%options, solution, failure)
        call check_fails(error, failure, 'sequential is for one')
        call check(error, all(abs(again%further_acceleration - observations%further_acceleration) <= 0), 'samples')
        call check(error, norm2(again%knowledge%line%spacing - [0.3_dp, 0.0_dp, 0.0_dp]) < 1e-15_dp, 'spacing')
        call read_content(error, SET//'/further_accelerometers.csv', good)
        if (allocated(error)) return
        last = index(good(:len(good) - 1), new_line('a'), back=.true.)
        call make_file('torquers/further_accelerometers.csv', good(:last))
        call read_observations(SET, again, failure)
        call check_fails(error, failure, 'further_accelerometers.csv:1200: ... 1199 rows, but 1200 are needed')
        last = index(good, new_line('a')//'1,')
        call make_file('torquers/further_accelerometers.csv', good(:last)//good(index(good, new_line('a')//'1.5,') + 1:))
        call read_observations(SET, again, failure)
        call check_fails(error, failure, 'further_accelerometers.csv:4: ... every time of accelerometer.csv a row')
        call remove_file(SET//'/further_accelerometers.csv')
        call read_observations(SET, again, failure)
        call check_fails(error, failure, 'further_accelerometers.csv ... no such file')
        again = observations
        again%further_acceleration(1, 7, 2) = 2
        call estimate_offset('optimal', again, calibration%options, solution, failure)
        call check_fails(error, failure, 'accelerometer 3: the sample at 3.5 s has a component of 2')
        deallocate (again%further_acceleration)
        call estimate_offset('optimal', again, calibration%options, solution, failure)
        call check_fails(error, failure, 'further_acceleration are allocated')
        call case_text(calibration%case, good, failure)
        if (failed(error, failure)) return
        call case_from_text(good, 'again', calibration%case, failure)
        call check_passes(error, failure)
        last = index(good, 'spacing = ')
        call case_from_text(good(:last - 1)//'spacing = 0, 1e-4, 0'//good(last + index(good(last:), ' !') - 1:), &
                            'close', calibration%case, failure)
        call check_fails(error, failure, 'spacing ... less than 1 mm')
    end subroutine test_several

    !> Three quiet accelerometers on a satellite in air and sunlight, each torquer's gain another: without the latter the mean
    !> normalised square is 187, without what the forces change by all angles 24.
    subroutine test_several_quiet(error)
        type(error_type), allocatable, intent(out) :: error
        character(1), parameter :: LF = new_line('a')
        character(*), parameter :: QUIET = "&calibration name = 'k300', epoch = '2024-06-15T06:00:00', duration = 60 /"//LF// &
            "&mass_properties mass = 420, moments_of_inertia = 70, 345, 389, products_of_inertia = -3, -0.35, -2.9 /"//LF// &
            "&torquers largest_torque = 0.01 /"//LF// &
            "&excitation axis = 1, amplitude = 0.001, frequency = 0.05, stop = 60 /"//LF// &
            "&excitation axis = 2, amplitude = 0.002, frequency = 0.0666666667, stop = 60 /"//LF// &
            "&excitation axis = 3, amplitude = 0.002, frequency = 0.0833333333, stop = 60 /"//LF// &
            "&truth offset_mm = 0.3, 0.4, -0.5, orbit = 'kepler', semi_major_axis_km = 6878, eccentricity = 0.001"//LF// &
            "inclination_deg = 89, node_deg = 50, perigee_deg = 40, mean_anomaly_deg = 300, attitude = 'nadir' /"//LF// &
            "&surface length = 3.12, height = 0.72, width_bottom = 1.94, width_top = 0.69 /"//LF// &
            "&accelerometer noise_level = 1e-22, 1e-22, 1e-22, noise_corner = 0.005, 0.005, 0.005 /"//LF// &
            "&atmosphere space_weather = 'given', f107 = 150, f107_mean = 150, kp = 2 /"//LF// &
            "&operator accelerometer_scale_sigma = 0.0101, 0.0159, 0.0119, rod_gain_sigma = 0.003, 0.003, 0.003 /"//LF// &
            "&accelerometers number = 3, spacing = 0.4, 0, 0, scale_sigma = 0.002, 0.002, 0.002 /"
        integer, parameter :: RUNS = 8
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        real(dp) :: wrong(3), squares
        integer :: run

        call calibration_from_text(QUIET, 'quiet', calibration, failure)
        if (failed(error, failure)) return
        calibration%options%covariance = .false.
        call make_simulator(calibration%case, simulator)
        squares = 0
        do run = 1, RUNS
            call make_observations(simulator, 1, run, observations)
            call estimate_offset('optimal', observations, calibration%options, solution, failure)
            if (failed(error, failure)) return
            wrong = solution%offset - calibration%case%satellite%offset
            squares = squares + dot_product(wrong, matmul(inverse_3x3(solution%covariance(:3, :3)*1e12_dp), wrong))*1e12_dp
        end do
        ! the forces are one draw at one place
        call check(error, squares < 6*RUNS, 'normalised squares: '//number_text(squares/RUNS))
    end subroutine test_several_quiet

    !> The covariance of d by least squares of all samples of accelerometers and star camera: d, attitude, rate, torque, bias and
    !> drift of every accelerometer, and gains and scale factors where the options ask for them.
    subroutine least_squares(calibration, covariance)
        type(calibration_t), intent(in) :: calibration
        real(dp), intent(out) :: covariance(3, 3)
        type(observation_set_t) :: base
        type(case_t) :: case
        type(error_t), allocatable :: failure
        real(dp), allocatable :: rows(:, :), factor(:, :), normal(:, :), rhs(:), solution(:), inverse(:, :), seen(:)
        real(dp) :: condition
        integer :: n, p, c, k, axis, sensor, last, scales, many, gains

        call see(calibration%case, base)
        if (allocated(failure)) return
        n = size(base%accelerometer_time)
        p = size(base%star_camera_time)
        last = 3*n*calibration%case%satellite%line%number
        allocate (rows(last + 3*p, 48), source=0.0_dp)
        c = 0
        do k = 1, 3
            case = calibration%case
            case%satellite%offset(k) = case%satellite%offset(k) + 1e-4_dp
            call add_column(1e-4_dp)
        end do
        do k = 1, 3
            case = calibration%case
            case%angular_velocity(k) = case%angular_velocity(k) + 1e-7_dp
            call add_column(1e-7_dp)
            case = calibration%case
            case%quaternion = quaternion_product(quaternion_from_axis_angle(unit_vector(k), 1e-5_dp), case%quaternion)
            call add_column(1e-5_dp)
            case = calibration%case
            associate (rods => case%satellite%rods)
                rods%count = rods%count + 1
                rods%activations(rods%count) = rod_activation_t(axis=k, amplitude=1e-7_dp, stop=case%duration, waveform=COSINE)
            end associate
            call add_column(1e-7_dp)
        end do
        do sensor = 0, last - 1, 3*n
            do axis = 1, 3
                rows(sensor + axis:sensor + 3*n:3, c + axis) = 1
                rows(sensor + axis:sensor + 3*n:3, c + 3 + axis) = base%accelerometer_time/case%duration
            end do
            c = c + 6
        end do
        associate (asked => calibration%options%optimal)
            gains = merge(3, 0, index(asked%also, 'rod_gain_x') > 0 .or. asked%estimate_rod_gain)
            do k = 1, gains
                case = calibration%case
                case%satellite%rods%gain(k) = 1.001_dp
                call add_column(1e-3_dp)
            end do
            seen = accelerations(base)
            scales = c
            do sensor = 0, merge(last, 0, asked%estimate_scale_factors) - 1, 3*n
                do axis = 1, 3
                    c = c + 1
                    rows(sensor + axis:sensor + 3*n:3, c) = seen(sensor + axis:sensor + 3*n:3)
                end do
            end do
        end associate
        call need(failure)
        factor = noise_factor(calibration%case, n)
        do k = 1, c
            do axis = 1, 3
                do sensor = 0, last - 1, 3*n
                    rows(sensor + axis:sensor + 3*n:3, k) = forward(factor, rows(sensor + axis:sensor + 3*n:3, k))
                end do
                rows(last + axis::3, k) = rows(last + axis::3, k)/base%knowledge%star_camera_sigma(axis)
            end do
        end do
        normal = matmul(transpose(rows(:, :c)), rows(:, :c))
        associate (known => calibration%case%operator%a_priori)
            many = calibration%case%satellite%line%number
            do k = scales + 1, c
                axis = modulo(k - scales - 1, 3) + 1
                ! s_c^2 of all alike, and s^2 (1 - 1/N) of each with -s^2/N between them: the inverse
                normal(k, scales + axis:c:3) = normal(k, scales + axis:c:3) + 1/(many*known%sigma_scale_factors(axis))**2 - &
                                               1/calibration%case%satellite%line%scale_sigma(axis)**2/many
                normal(k, k) = normal(k, k) + 1/calibration%case%satellite%line%scale_sigma(axis)**2
            end do
            do k = scales - gains + 1, scales
                normal(k, k) = normal(k, k) + 1/known%sigma_rod_gain**2
            end do
        end associate
        allocate (rhs(c), source=0.0_dp)
        allocate (solution(c), inverse(c, c))
        call solve_normal_equations(normal, rhs, solution, inverse, condition, failure)
        call need(failure)
        covariance = inverse(:3, :3)

    contains

        !> Samples without noise.
        subroutine see(of_case, samples)
            type(case_t), intent(in) :: of_case
            type(observation_set_t), intent(out) :: samples
            type(simulator_t) :: simulator

            if (allocated(failure)) return
            call make_simulator(of_case, simulator)
            if (.not. allocated(failure)) call observe_without_noise(simulator, density_wave_t(), samples)
        end subroutine see

        !> The partials by what was changed in `case`.
        subroutine add_column(step)
            real(dp), intent(in) :: step
            type(observation_set_t) :: other
            real(dp) :: turn(4)
            integer :: i

            c = c + 1
            call see(case, other)
            if (allocated(failure)) return
            rows(:last, c) = (accelerations(other) - accelerations(base))/step
            do i = 1, p
                turn = quaternion_product(other%quaternion(:, i), conjugate_quaternion(base%quaternion(:, i)))
                rows(last + 3*i - 2:last + 3*i, c) = 2*turn(:3)*sign(1.0_dp, turn(4))/step
            end do
        end subroutine add_column

        !> Of all accelerometers, one behind the other.
        function accelerations(samples) result(all)
            type(observation_set_t), intent(in) :: samples
            real(dp) :: all(last)

            all(:3*n) = reshape(samples%acceleration, [3*n])
            if (last > 3*n) all(3*n + 1:) = reshape(samples%further_acceleration, [last - 3*n])
        end function accelerations
    end subroutine least_squares

    pure function unit_vector(axis) result(vector)
        integer, intent(in) :: axis
        real(dp) :: vector(3)

        vector = 0
        vector(axis) = 1
    end function unit_vector

    !> Cholesky's factor of the covariance of the noise of accelerometer x, from the one-sided spectrum as it is published.
    function noise_factor(case, n) result(factor)
        type(case_t), intent(in) :: case
        integer, intent(in) :: n
        real(dp), allocatable :: factor(:, :)

        real(dp), parameter :: STEP = 2e-5_dp       ! Hz
        real(dp) :: lag(0:n - 1), f, density, h
        integer :: i, j, k

        h = case%satellite%accelerometer%sampling_interval
        lag = 0
        do i = 1, nint(0.5_dp/h/STEP)
            f = (i - 0.5_dp)*STEP
            if (case%name == 'nggm') then
                density = 4e-24_dp*(1.2_dp + 0.002_dp/max(f, 5e-4_dp) + 6000*f**4)
            else
                density = 1e-20_dp*(1 + 0.01_dp/f)
            end if
            do k = 0, n - 1
                lag(k) = lag(k) + density*STEP*cos(TWO_PI*f*h*k)
            end do
        end do
        allocate (factor(n, n), source=0.0_dp)
        do j = 1, n
            do i = j, n
                f = lag(i - j) - dot_product(factor(i, :j - 1), factor(j, :j - 1))
                if (i == j) factor(j, j) = sqrt(f)
                if (i > j) factor(i, j) = f/factor(j, j)
            end do
        end do
    end function noise_factor

    !> L^-1 v.
    pure function forward(factor, v) result(x)
        real(dp), intent(in) :: factor(:, :), v(:)
        real(dp) :: x(size(v))

        integer :: i

        do i = 1, size(v)
            x(i) = (v(i) - dot_product(factor(i, :i - 1), x(:i - 1)))/factor(i, i)
        end do
    end function forward

    !> 100 seeds of each example by `optimal`: errors, normalised by the bound's covariance, of which 300 squares have the mean
    !> 1 +- 0.08, and by the estimate's own.
    subroutine test_seeds(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: SEEDS = 100
        type(calibration_t) :: calibration
        type(case_bound_t) :: bound
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        real(dp) :: wrong(3), by_bound, by_own, squares(3)
        integer :: i, exact, seed

        do i = 1, size(EXAMPLES)
            do exact = 0, 1
                call take_example(EXAMPLES(i), exact == 1, calibration)
                call bound_of_case(calibration%case, calibration%options, bound, failure)
                if (.not. allocated(failure)) call new_simulator(calibration%case, simulator, failure)
                by_bound = 0
                by_own = 0
                squares = 0
                do seed = 1, SEEDS
                    if (.not. allocated(failure)) call observe(simulator, seed, 1, observations, failure)
                    if (.not. allocated(failure)) &
                        call estimate_offset('optimal', observations, calibration%options, solution, failure)
                    if (failed(error, failure)) return
                    wrong = solution%offset - calibration%case%satellite%offset
                    squares = squares + wrong**2/SEEDS
                    by_bound = by_bound + dot_product(wrong, matmul(inverse_3x3(bound%covariance*1e12_dp), wrong))*1e12_dp
                    by_own = by_own + dot_product(wrong, matmul(inverse_3x3(solution%covariance*1e12_dp), wrong))*1e12_dp
                end do
                by_bound = sqrt(by_bound/(3*SEEDS))
                by_own = sqrt(by_own/(3*SEEDS))
                call check(error, abs(by_bound - 1) < 0.1_dp, trim(calibration%case%name)//': RMS over the bound')
                call check(error, abs(by_own - 1) < 0.1_dp, trim(calibration%case%name)//': RMS over sigma')
                call check(error, all(abs(sqrt(squares)/bound%sigma - 1) < 0.25_dp), trim(calibration%case%name))
            end do
        end do
    end subroutine test_seeds

    !> A swing whose torques are believed up to 30 % wrong: the estimate, with all its checks and the record of the fit, finds the
    !> gains that are true, and contradicts nothing.
    subroutine test_gains(error)
        type(error_type), allocatable, intent(out) :: error
        character(10), parameter :: NAMES(3) = ['rod_gain_x', 'rod_gain_y', 'rod_gain_z']
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(fit_record_t) :: record
        real(dp) :: found
        integer :: i, k, seed

        call take_example(EXAMPLES(2), .false., calibration)
        calibration%options%covariance = .true.
        call make_simulator(calibration%case, simulator)
        do seed = 1, 5
            call make_observations(simulator, seed, 1, observations)
            if (estimate_fails(error, 'optimal', observations, calibration%options, solution, record)) return
            call check(error, solution%converged .and. size(record%epoch) > 300, 'converged, with a record')
            call check(error, .not. solution%beliefs%has_contradiction(), 'nothing is contradicted')
            call check(error, maxval(abs(observations%knowledge%rods%gain - 1)) > 0.1_dp, 'the beliefs are wrong')
            do i = 1, 3
                k = findloc(solution%parameters%name, NAMES(i), 1)
                found = observations%knowledge%rods%gain(i)*(1 + solution%parameters(k)%value)
                call check(error, found, 1.0_dp, thr=0.02_dp, message=NAMES(i))
                call check(error, abs(solution%offset(i) - calibration%case%satellite%offset(i)) < &
                           4*sqrt(solution%covariance(i, i)), 'offset')
            end do
        end do
        ! A swing shows the lift in any noise; and without an orbit no magnetometer is doubted, which is none of torquers
        calibration%options%optimal%estimate_within_limits = .true.
        deallocate (observations%orbit_time, observations%orbit_position)
        if (estimate_fails(error, 'optimal', observations, calibration%options, solution)) return
        call check(error, any(solution%parameters%name == 'lift_y'), 'lift')
        call check(error, .not. any(index(solution%beliefs%values%subject, '(no orbit)') > 0), 'magnetometer')
    end subroutine test_gains

    !> A delay, a gain and a direction of the torquers that are believed wrongly contradict the data, and the warning names what is
    !> right, and the offset with it.
    subroutine test_beliefs(error)
        type(error_type), allocatable, intent(out) :: error
        character(40), parameter :: NAMED(3) = [character(40) :: 'the delay of torquer y is ', 'the gain of torquer y is 0.9', &
                                                'the direction of torquer x about y is ']
        type(calibration_t) :: calibration
        type(observation_set_t) :: observations, wrong
        type(solution_t) :: solution
        type(known_offset_t) :: known
        type(action_t) :: action
        integer :: i, k
        logical :: found

        call take_example(EXAMPLES(2), .true., calibration)
        calibration%options%covariance = .true.
        call make_observations(calibration%case, 1, 1, observations)
        do i = 1, 3
            wrong = observations
            if (i == 1) wrong%knowledge%rods%delay(2) = 0.5_dp
            if (i == 2) wrong%knowledge%rods%gain(2) = 1.1_dp
            if (i == 3) wrong%knowledge%rods%misalignment(1) = 6*DEGREE
            if (estimate_fails(error, 'optimal', wrong, calibration%options, solution)) return
            found = .false.
            do k = 1, size(solution%warnings)
                found = found .or. index(solution%warnings(k)%text, trim(NAMED(i))) > 0 .and. &
                        index(solution%warnings(k)%text, 'd would be -0.19 0.6') > 0
            end do
            call check(error, found .and. solution%beliefs%has_contradiction(), NAMED(i))
        end do
        ! What all beliefs together allow is no contradiction; then the sigma of the action holds where masses would be moved
        do i = 1, 2
            wrong = observations
            if (i == 1) wrong%knowledge%rods%gain(2) = 1.02_dp
            if (i == 2) wrong%knowledge%rods%misalignment(1) = 3*DEGREE
            if (estimate_fails(error, 'optimal', wrong, calibration%options, solution)) return
            if (solution%beliefs%has_contradiction()) cycle
            known = known_of(solution%offset, solution%covariance, solution%beliefs)
            call decide(known, wrong%knowledge%mass, action)
            call check(error, .not. any(action%trimmed .and. abs(solution%offset - calibration%case%satellite%offset) > &
                                        4*known%sigma + known%tolerated), action%text)
        end do
    end subroutine test_beliefs

    !> A set with torque.csv gives the estimate of the set with waveforms, though gain and delay lie behind the command and the
    !> magnetometer is lost. Files that contradict the setup, or are damaged, are refused by name.
    subroutine test_history(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations, again
        type(solution_t) :: solution, other
        type(error_t), allocatable :: failure
        character(:), allocatable :: good, setup
        integer :: k

        call take_example(EXAMPLES(2), .true., calibration)
        calibration%case%duration = 100
        calibration%case%satellite%rods%gain = [1.2_dp, 1.1_dp, 0.9_dp]
        calibration%case%satellite%rods%delay = 0.3_dp
        call make_simulator(calibration%case, simulator)
        call make_observations(simulator, 5, 1, observations)
        call estimate_offset('optimal', observations, calibration%options, solution, failure)
        if (.not. allocated(failure)) call measure_rods(simulator, 0.5_dp, observations, failure)
        if (.not. allocated(failure)) call write_observations(SET, observations, [character(1) ::], failure)
        call remove_file(SET//'/magnetometer.csv')
        call remove_file(SET//'/orbit.csv')
        if (.not. allocated(failure)) call read_observations(SET, again, failure)
        if (failed(error, failure)) return
        call check(error, .not. allocated(again%orbit_time), 'an orbit')
        again%orbit_time = observations%orbit_time      ! for the gravity gradient alone
        again%orbit_position = observations%orbit_position
        if (estimate_fails(error, 'optimal', again, calibration%options, other)) return
        call check(error, all(abs(again%knowledge%rods%gain - calibration%case%satellite%rods%gain) <= 0), 'gain')
        do k = 1, 3
            call check(error, abs(other%offset(k) - solution%offset(k)) < 0.02_dp*sqrt(solution%covariance(k, k)), 'estimate')
            call check(error, abs(other%offset(k) - calibration%case%satellite%offset(k)) < &
                       4*sqrt(solution%covariance(k, k)), 'truth')
        end do

        calibration%options%covariance = .true.         ! twice the torque that is believed: refused
        again%knowledge%rods%gain = again%knowledge%rods%gain/2
        call estimate_offset('optimal', again, calibration%options, other, failure)
        call check_fails(error, failure, 'torque of the torquers ... setup and command')
        call read_content(error, SET//'/torque.csv', good)
        call read_content(error, SET//'/setup.nml', setup)
        call make_file('torquers/torque.csv', good(:len(good) - 30)//'nan'//new_line('a'))
        call refused('torque.csv: ... is not a finite number')
        call make_file('torquers/torque.csv', 'time_s,tx,ty,tz'//new_line('a')//'0,0,0,0'//new_line('a'))
        call refused('torque.csv ... tx_n_m')
        call make_file('torquers/torque.csv', good(:index(good, new_line('a')//'50') + 20)//new_line('a'))
        call refused('torque.csv')
        call make_file('torquers/torque.csv', good)
        call make_file('torquers/rods.csv', 'time_s,mx_a_m2,my_a_m2,mz_a_m2'//new_line('a')//'0,0,0,0'//new_line('a'))
        call refused('rods.csv ... with torquers')
        call remove_file(SET//'/rods.csv')
        k = index(setup, '&torquers')
        call make_file('torquers/setup.nml', setup(:k - 1)//setup(index(setup, '&limits'):))
        call refused('torque.csv ... without torquers')

    contains

        subroutine refused(parts)
            character(*), intent(in) :: parts

            call read_observations(SET, again, failure)
            call check_fails(error, failure, parts)
        end subroutine refused
    end subroutine test_history

    !> A case whose torques are a file has the bound of the case whose waveforms the file samples.
    subroutine test_torque_file(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration, other
        type(case_bound_t) :: bound, of_file
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, history, blocks
        character(120) :: line
        integer :: k

        call take_example(EXAMPLES(2), .true., calibration)
        history = 'time_s,tx_n_m,ty_n_m,tz_n_m'//new_line('a')
        do k = 0, 400
            write (line, '(f7.2, 3(",", es22.14))') 0.5_dp*k, dipole_moment(calibration%case%satellite%rods, 0.5_dp*k)
            history = history//trim(adjustl(line))//new_line('a')
        end do
        call make_file('swing.csv', history)
        call read_content(error, trim(EXAMPLES(2)), text)
        if (allocated(error)) return
        blocks = text(:index(text, '&excitation') - 1)
        k = index(blocks, '    largest_torque')
        blocks = blocks(:k - 1)//"    torque_file = '"//FOLDER//"swing.csv'"//new_line('a')//blocks(k:)
        call make_file('swing.nml', blocks//text(index(text, '&truth'):))
        call take_example(FOLDER//'swing.nml', .true., other)
        call bound_of_case(calibration%case, calibration%options, bound, failure)
        if (.not. allocated(failure)) call bound_of_case(other%case, other%options, of_file, failure)
        if (failed(error, failure)) return
        call check(error, all(abs(of_file%sigma/bound%sigma - 1) < 1e-3_dp), 'bound')
        call calibration_text(other, text, failure)
        call check(error, index(text, 'torque_file = ') > 0, 'the written case names no file')
        call make_file('swing.csv', history(:index(history, new_line('a')//'101.00')))
        call find_calibration(FOLDER//'swing.nml', other, failure)
        call check_fails(error, failure, 'torques: samples from ... do not cover the arc')
    end subroutine test_torque_file

    !> A case of torquers is read as it was written; with rods beside, too strong a torque, or control by rods it is refused.
    subroutine test_case_files(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(case_t) :: again
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, twice

        call take_example(EXAMPLES(1), .false., calibration)
        call case_text(calibration%case, text, failure)
        call check(error, index(text, '&rod') == 0 .and. index(text, '&excitation') > 0, 'groups')
        call case_from_text(text, 'again', again, failure)
        if (failed(error, failure)) return
        call case_text(again, twice, failure)
        call check(error, text == twice .and. again%satellite%rods%direct, 'round trip')
        call case_from_text(text//new_line('a')//'&rod axis = 1, amplitude = 1.0, frequency = 0.1, stop = 60.0 /'//new_line('a'), &
                            'both', again, failure)
        call check_fails(error, failure, 'both ... by torquers or by rods')
        call case_from_text(text//new_line('a')//'&control /'//new_line('a'), 'controlled', again, failure)
        call check_fails(error, failure, 'controlled ... &torquers')
        calibration%case%satellite%rods%largest_moment = 1e-3_dp
        call case_text(calibration%case, text, failure)
        call case_from_text(text, 'strong', again, failure)
        call check_fails(error, failure, 'strong ... N m ... largest_torque')
        calibration%case%satellite%rods%count = 0
        call check_rods_fire(calibration%case%satellite%rods, 60.0_dp, failure)
        call check_fails(error, failure, 'no torque acts ... &excitation ... torque.csv')
    end subroutine test_case_files

    !> The manoeuvre that is designed for the torquers of an example is not worse than the example's own, and flies by torquers.
    subroutine test_design(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration, planned
        type(manoeuvre_design_t) :: design
        type(design_settings_t) :: settings
        type(case_bound_t) :: bound, own
        type(error_t), allocatable :: failure

        call take_example(EXAMPLES(1), .true., calibration)
        calibration%case%duration = 100
        calibration%case%satellite%rods%activations%stop = 100
        settings%amplitude = usual_amplitude(calibration%case%satellite%rods)
        settings%share = usual_shares(calibration%case%satellite%rods)
        settings%lowest_frequency = 0.06_dp
        settings%highest_frequency = 0.1_dp
        settings%waveform_used = [.true., .false., .false., .false.]
        settings%refinement_steps = 0
        call plan_manoeuvre(calibration, 0.0_dp, settings, planned, design, failure)
        call check_fails(error, failure, 'several accelerometers: manoeuvres are planned for one')
        calibration%case%satellite%line%number = 1
        call bound_of_case(calibration%case, calibration%options, own, failure)
        call check(error, maxval(abs(settings%amplitude*settings%share - [3.676e-4_dp, 1.9316e-3_dp, 2.1612e-3_dp])) < 1e-12_dp)
        if (.not. allocated(failure)) call plan_manoeuvre(calibration, 0.0_dp, settings, planned, design, failure)
        planned%options = calibration%options
        if (.not. allocated(failure)) call bound_of_case(planned%case, planned%options, bound, failure)
        if (failed(error, failure)) return
        call check(error, planned%case%satellite%rods%direct .and. design%rods%direct, 'torquers')
        call check(error, maxval(bound%sigma) < 1.02_dp*maxval(own%sigma), 'design')
        call check(error, all(abs(design%sigma/bound%sigma - 1) < 0.05_dp), 'the planner''s limit')
    end subroutine test_design
end module test_torquers
