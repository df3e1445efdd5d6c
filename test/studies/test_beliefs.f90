!> The tests of the operator's beliefs: their partials against altered observations, and their scores against what chance
!> makes of them.
module test_beliefs_of_operator
    use vocabulary
    use calibrations
    use gracecg_base_error, only: number_text
    use gracecg_base_statistics, only: normal_quantile
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_planning_calibration, only: calibration_from_text
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_simulation_dynamics, only: OMEGA_PLACES => OMEGA, ATTITUDE_PLACES => ATTITUDE
    use gracecg_observations_parameters
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, prepare_calibration, set_noise, with_parameters
    use gracecg_estimation_belief, only: apply_value, is_possible
    use gracecg_estimation_belief_words, only: say_contradiction
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_explanation, only: confirm_contradictions
    use statistics, only: chi_square_limits
    use belief_fixture, only: simulator_of, WAVE_NEAR_RODS
    implicit none
    private
    public :: collect_beliefs

contains

    subroutine collect_beliefs(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('normal-quantiles', test_quantiles), &
                    new_unittest('partials-are-those-of-altered-observations', test_partials), &
                    new_unittest('what-is-applied-is-taken-back', test_applied), &
                    new_unittest('scores-are-standard-normal', test_scores), &
                    new_unittest('what-is-left-of-a-belief', test_information_left), &
                    new_unittest('what-leaves-no-trace-is-not-counted', test_traces), &
                    new_unittest('scores-are-confirmed-by-fits', test_confirmation), &
                    new_unittest('long-arcs-are-sound', test_long_arcs), &
                    new_unittest('quiet-accelerometers-are-sound', test_quiet), &
                    new_unittest('much-drag-is-sound', test_much_drag), &
                    new_unittest('edge-of-shadow-is-sound', test_edge_of_shadow), &
                    new_unittest('bent-forces-are-no-scale-factor', test_bent_forces)]
    end subroutine collect_beliefs

    !> Abramowitz and Stegun, Table 26.5, and the relation of both tails.
    subroutine test_quantiles(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, normal_quantile(0.975_dp), 1.959963985_dp, thr=1e-8_dp)
        call check(error, normal_quantile(0.9995_dp), 3.290526731_dp, thr=1e-8_dp)
        call check(error, normal_quantile(0.8_dp), 0.841621234_dp, thr=1e-8_dp)
        call check(error, normal_quantile(1e-9_dp), -5.997807015_dp, thr=1e-7_dp)
        call check(error, normal_quantile(0.5_dp), 0.0_dp, thr=1e-15_dp)
    end subroutine test_quantiles

    !> What a belief's value would change in the whitened residuals, by its partials and by observations and knowledge
    !> that are changed by it, up and down. Samples that are shifted in time blur the abrupt edges of the rods.
    subroutine test_partials(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SIMILAR = 0.03_dp, BLURRED = 0.2_dp
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations, other
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        real(dp), allocatable :: partials(:, :), residuals(:), unused(:, :), up(:), down(:)
        real(dp) :: step, deviation, size_of_partials
        integer :: i

        call simulator_of('front-3', simulator, options)
        call observe_without_noise(simulator, density_wave_t(), observations)
        call estimate_offset('optimal', observations, options, solution, failure)
        call check_passes(error, failure)
        if (.not. allocated(error)) call whitened(observations, partials, residuals)
        do i = 1, size(BELIEFS)
            step = size_of(BELIEFS(i))
            other = observations
            call apply_value(BELIEFS(i), step, other)
            call whitened(other, unused, up)
            if (allocated(error)) return
            other = observations
            call apply_value(BELIEFS(i), -step, other)
            call whitened(other, unused, down)
            if (allocated(error)) return
            size_of_partials = norm2(partials(i, :))
            if (any(ACCELEROMETER_SWAPS == BELIEFS(i))) then  ! samples that are sound become wrong
                deviation = norm2(up - residuals - partials(i, :))
            else if (any(INTERCHANGES == BELIEFS(i))) then
                deviation = norm2(residuals - up - partials(i, :))
            else
                deviation = norm2((down - up)/(2*step) - partials(i, :))
            end if
            call check(error, deviation <= merge(BLURRED, SIMILAR, &
                       any([ACCELEROMETER_DELAYS, ROD_DELAYS, ALL_RODS_DELAY] == BELIEFS(i)))* &
                       size_of_partials, trim(belief_subject(BELIEFS(i)))//': partials '//number_text(size_of_partials)// &
                       ', off by '//number_text(deviation))
        end do

    contains

        subroutine whitened(set, rows, left)
            type(observation_set_t), intent(in) :: set
            real(dp), allocatable, intent(out) :: rows(:, :), left(:)
            type(fitting_data_t) :: data
            type(whitened_problem_t) :: problem
            real(dp), allocatable :: weights(:)
            integer :: known

            call preprocess(set, options, data, failure)
            if (.not. allocated(failure)) then
                call prepare_calibration(set%knowledge, options, data, BELIEFS, problem)
                problem%state%quaternion = simulator%arc%state(ATTITUDE_PLACES, 0)
                problem%state%value(RATE) = simulator%arc%state(OMEGA_PLACES, 0)
                problem%state%value(OFFSET) = simulator%case%satellite%offset
                problem%state%value(DRIFT) = solution%drift
                problem%state%value(BIAS) = solution%bias
                call set_noise(problem, failure)
                allocate (rows(size(BELIEFS), problem%observations), left(problem%observations), &
                          weights(problem%observations))
            end if
            if (.not. allocated(failure)) call problem%linearise(rows, left, weights, failure)
            if (failed(error, failure)) return
            known = problem%star_rows + problem%acceleration_rows
            rows = rows(:, :known)
            left = left(:known)
        end subroutine whitened
    end subroutine test_partials

    !> A small value of a parameter.
    pure real(dp) function size_of(parameter)
        integer, intent(in) :: parameter

        select case (KIND_OF(parameter))
        case (INERTIA(1))
            size_of = 0.1_dp
        case (TORQUE_CHANGE(1))
            size_of = 1e-6_dp
        case (FIELD_BIAS(1))
            size_of = 1e-8_dp
        case (ROD_FREQUENCIES(1), ALL_RODS_FREQUENCY)
            size_of = 1e-6_dp
        case (ROD_DELAYS(1), ALL_RODS_DELAY, ACCELEROMETER_DELAYS(1))
            size_of = 0.1_dp        ! what the torque's samples resolve
        case default
            size_of = 1e-3_dp
        end select
    end function size_of

    !> A delay of the accelerometer is a sine's, and leaves white noise what it is; skewness of the magnetometer is taken
    !> back by its negative.
    subroutine test_applied(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 2000
        real(dp), parameter :: DELAYS(3) = [0.05_dp, -0.03_dp, 0.237_dp], PERIOD = 5
        type(observation_set_t) :: observations, other
        type(random_stream_t) :: stream
        real(dp) :: sine(N), level
        integer :: i, k

        observations%accelerometer_time = [(0.1_dp*i, i=1, N)]
        allocate (observations%acceleration(3, N), observations%field(3, N))
        stream = new_stream(4717, 1, 1, 1, 1)
        call stream%normals(observations%acceleration(1, :))
        observations%acceleration(2, :) = sin(TWO_PI*observations%accelerometer_time/PERIOD)
        observations%field = spread([2e-5_dp, -1e-5_dp, 4e-5_dp], 2, N)
        do k = 1, size(DELAYS)
            other = observations
            other%knowledge%accelerometer_noise%level = 1
            call apply_value(ACCELEROMETER_DELAYS(1), DELAYS(k), other, noise_follows=.true.)
            call apply_value(ACCELEROMETER_DELAYS(2), DELAYS(k), other)
            level = sum(other%acceleration(1, :)**2)/sum(observations%acceleration(1, :)**2)
            call check(error, abs(level - 1) < 0.03_dp .and. abs(level - other%knowledge%accelerometer_noise(1)%level) < 0.02_dp, &
                       'noise')
            sine = sin(TWO_PI*(observations%accelerometer_time + DELAYS(k))/PERIOD)
            call check(error, maxval(abs(other%acceleration(2, 50:N - 50) - sine(50:N - 50))) < 1e-3_dp, 'a sine')
            call check(error, maxval(abs(other%acceleration(2, 5:N - 5) - sine(5:N - 5))) < 0.02_dp, 'near an end')
        end do
        other = observations
        do i = 1, 3
            call apply_value(FIELD_SHEARS(i), 0.5_dp, other)
            call apply_value(FIELD_SHEARS(i), -0.5_dp, other)
        end do
        call check(error, maxval(abs(other%field - observations%field)) < 1e-18_dp, 'skewness')
        other%knowledge%inertia = reshape([70, 0, 0, 0, 345, 0, 0, 0, 388], [3, 3])
        call check(error, all([is_possible(INERTIA(1), 20.0_dp, other%knowledge), is_possible(INERTIA(3), 20.0_dp, &
                                                                                                other%knowledge), &
                               is_possible(INERTIA(4), -20.0_dp, other%knowledge)]), 'moments that a body can have')
        call check(error, .not. any([is_possible(INERTIA(1), -71.0_dp, other%knowledge), &
                                     is_possible(INERTIA(1), -28.0_dp, other%knowledge), &
                                     is_possible(INERTIA(3), 28.0_dp, other%knowledge)]), 'and those that none has')
    end subroutine test_applied

    !> Over sound runs the scores are those of standard normal variables, and none contradicts.
    subroutine test_scores(error)
        type(error_type), allocatable, intent(out) :: error
        character(8), parameter :: NAMES(3) = [character(8) :: 'front-1', 'front-3', 'back-3']
        integer, parameter :: RUNS = 40
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        real(dp) :: limits(2)
        real(dp), allocatable :: squares(:)
        character(:), allocatable :: found
        integer :: run, i, k

        do k = 1, size(NAMES)
            call simulator_of(trim(NAMES(k)), simulator, options)
            allocate (squares(PARAMETERS), source=0.0_dp)
            do run = 1, RUNS
                call make_observations(simulator, 4712, run, observations)
                if (estimate_fails(error, 'optimal', observations, options, solution)) return
                call say_contradiction(solution%beliefs, found)
                call check(error, found, '', NAMES(k)//' run '//integer_text(run))
                do i = 1, size(solution%beliefs%values)
                    associate (test => solution%beliefs%values(i))
                        squares(test%belief) = squares(test%belief) + test%score**2
                    end associate
                end do
            end do
            limits = chi_square_limits(RUNS)
            do i = 1, size(BELIEFS)     ! one in a thousand would be beyond the limits by chance: hence 1.5
                call check(error, squares(BELIEFS(i)) < 1.5_dp*limits(2), NAMES(k)//' '//trim(belief_subject(BELIEFS(i)))// &
                           number_text(squares(BELIEFS(i))/RUNS))
            end do
            if (unmet(error, abs(sum(squares)/RUNS/count(squares > 0) - 1) < 0.3_dp, NAMES(k)//' mean square')) return
            deallocate (squares)
        end do
    end subroutine test_scores

    !> A turn of the accelerometer is a bias but for 1e-5 of it: what the data tell of it beside all that is estimated,
    !> against rows made orthogonal to those of the others, twice, as Gram and Schmidt do.
    subroutine test_information_left(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(whitened_problem_t) :: fitted, problem
        type(error_t), allocatable :: failure
        real(dp), allocatable :: rows(:, :), residuals(:), weights(:), sigma(:)
        real(dp) :: whole
        integer, allocatable :: tested(:)
        integer :: i, k, round, n, all_of

        call simulator_of('front-1', simulator, options)
        call make_observations(simulator, 77, 1, observations)
        call estimate_optimal(observations, options, solution, failure, problem=fitted)
        if (failed(error, failure)) return
        n = size(fitted%model%estimated)
        tested = pack(solution%beliefs%values%belief, &
                      [(all(fitted%model%estimated /= solution%beliefs%values(i)%belief), &
                        i=1, size(solution%beliefs%values))])
        sigma = pack(solution%beliefs%values%sigma, &
                     [(any(tested == solution%beliefs%values(i)%belief), &
                       i=1, size(solution%beliefs%values))])
        call with_parameters(observations%knowledge, options, fitted, [fitted%model%estimated, tested], problem)
        call set_noise(problem, failure)
        all_of = n + size(tested)
        allocate (rows(all_of, problem%observations), residuals(problem%observations), weights(problem%observations))
        if (.not. allocated(failure)) call problem%linearise(rows, residuals, weights, failure)
        if (failed(error, failure)) return
        rows(n + 1:, problem%star_rows + problem%acceleration_rows + 1:) = 0    ! what the operator states of them
        do i = 1, all_of
            whole = norm2(rows(i, :))
            if (i <= n) rows(i, :) = rows(i, :)/whole
            do round = 1, 2
                do k = 1, min(i - 1, n)
                    rows(i, :) = rows(i, :) - dot_product(rows(k, :), rows(i, :))*rows(k, :)
                end do
            end do
            if (i <= n) then
                rows(i, :) = rows(i, :)/norm2(rows(i, :))
            else if (sigma(i - n) > 0) then
                call check(error, norm2(rows(i, :))*sigma(i - n), 1.0_dp, thr=0.01_dp, &
                           message=trim(parameter_names(tested(i - n))))
            else
                call check(error, norm2(rows(i, :)) < 2e-6_dp*whole, 'undetermined: '//trim(parameter_names(tested(i - n))))
            end if
        end do
    end subroutine test_information_left

    !> Beliefs of a rod that does as good as nothing, or of partials that cancel but for their rounding, are none that the
    !> data could speak of: they change nothing.
    subroutine test_traces(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(solution_t) :: solution, with_trace
        type(error_t), allocatable :: failure
        integer :: axis

        call simulator_of('back-1', simulator, options)
        call make_observations(simulator, 77, 1, observations)
        call estimate_optimal(observations, options, solution, failure)
        if (.not. allocated(failure)) then
            associate (rods => observations%knowledge%rods)
                axis = findloc([(any(rods%activations(:rods%count)%axis == axis), axis=1, 3)], .false., 1)
                rods%count = rods%count + 1
                rods%activations(rods%count) = rods%activations(1)
                rods%activations(rods%count)%axis = axis
                rods%activations(rods%count)%amplitude = 1e-18_dp
            end associate
            call estimate_optimal(observations, options, with_trace, failure)
        end if
        if (failed(error, failure)) return
        call check(error, axis > 0 .and. all(solution%beliefs%values%belief > 0), 'a rod is free')
        call check(error, size(with_trace%beliefs%values), size(solution%beliefs%values))
        call check(error, with_trace%beliefs%critical, solution%beliefs%critical, thr=1e-12_dp)
    end subroutine test_traces

    !> A score that the fits do not bear out is none; one of a belief that is wrong stays, near to what it was.
    subroutine test_confirmation(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SIMILAR = 0.1_dp
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations, wrong
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        real(dp) :: score
        integer :: i

        call simulator_of('front-3', simulator, options, WAVE_NEAR_RODS)
        call make_observations(simulator, 4716, 1, observations)
        call estimate_optimal(observations, options, solution, failure)
        if (failed(error, failure)) return
        i = findloc(solution%beliefs%values%belief, ROD_FREQUENCIES(3), 1)
        wrong = observations
        call apply_value(ROD_FREQUENCIES(3), 1.4_dp*solution%beliefs%values(i)%detectable, wrong)
        solution%beliefs%values(i)%value = 6*solution%beliefs%values(i)%sigma
        call solution%beliefs%take_score(i, 6.0_dp)
        call check(error, solution%beliefs%has_contradiction(), 'score of 6')
        call confirm_contradictions(observations, options, solution%misfit, solution%beliefs)
        call check(error, .not. solution%beliefs%has_contradiction(), 'a score without a reason')

        call estimate_optimal(wrong, options, solution, failure)
        if (failed(error, failure)) return
        score = solution%beliefs%values(i)%score
        call check(error, solution%beliefs%has_contradiction(), 'wrong frequency')
        call check(error, maxval(abs(solution%beliefs%values%score)) < 8, 'a score within what is confirmed')
        call confirm_contradictions(wrong, options, solution%misfit, solution%beliefs)
        call check(error, solution%beliefs%has_contradiction(), 'wrong frequency, confirmed')
        call check(error, abs(solution%beliefs%values(i)%score/score - 1) < SIMILAR, &
                   number_text(score)//' becomes '//number_text(solution%beliefs%values(i)%score))
    end subroutine test_confirmation

    !> A force along x that bends by many of its a-priori sigmas, and an offset that hardly shows: the scale factor of
    !> the accelerometer, which would make more of both, is not contradicted for it.
    subroutine test_bent_forces(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        real(dp), allocatable :: x(:)
        integer :: i

        call take_calibration('front-1', calibration)
        calibration%case%satellite%offset = 1e-6_dp
        call make_observations(calibration%case, 4711, 1, observations)
        x = 2*observations%accelerometer_time/calibration%case%duration - 1
        observations%acceleration(1, :) = observations%acceleration(1, :) + 6e-10_dp*(35*x**4 - 30*x**2 + 3)/8
        if (estimate_fails(error, 'optimal', observations, calibration%options, solution)) return
        i = SCALE_FACTORS(1)
        associate (test => solution%beliefs%values(findloc(solution%beliefs%values%belief, i, 1)))
            call check(error, abs(test%score) < 4, 'scale factor '//number_text(test%score))
        end associate
    end subroutine test_bent_forces

    !> Forces that bend, and torques that change, over five minutes are no wrong beliefs.
    subroutine test_long_arcs(error)
        type(error_type), allocatable, intent(out) :: error
        character(8), parameter :: NAMES(2) = [character(8) :: 'front-1', 'front-3']
        real(dp), parameter :: LENGTH = 300
        type(calibration_t) :: calibration
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        character(:), allocatable :: found
        real(dp) :: sigma
        integer :: i, k

        do k = 1, size(NAMES)
            call take_calibration(NAMES(k), calibration)
            calibration%case%duration = LENGTH
            calibration%case%satellite%rods%activations%stop = LENGTH
            call make_observations(calibration%case, 4711, 1, observations)
            if (estimate_fails(error, 'optimal', observations, calibration%options, solution)) return
            call say_contradiction(solution%beliefs, found)
            call check(error, found, '', NAMES(k))
            do i = 1, 3
                sigma = sqrt(solution%covariance(i, i))
                call check(error, abs(solution%offset(i) - calibration%case%satellite%offset(i)) < 4*sigma, NAMES(k))
            end do
        end do
    end subroutine test_long_arcs

    !> A small satellite in more drag, with a quieter accelerometer than the report's: its lift is seen, and no kinks of the
    !> wind. Without either the mean normalised square is 15, and half of the calibrations were contradicted.
    subroutine test_quiet(error)
        type(error_type), allocatable, intent(out) :: error
        character(1), parameter :: LF = new_line('a')
        character(*), parameter :: QUIET = "&calibration name = 'quiet', epoch = '2025-03-20T06:00:00', duration = 90 /"//LF// &
            "&mass_properties mass = 212.5, moments_of_inertia = 31, 52, 60, products_of_inertia = 0.8, -0.5, 1.1 /"//LF// &
            "&rods largest_moment = 12 /"//LF//"&rod axis = 1, amplitude = 9, frequency = 0.1, stop = 90 /"//LF// &
            "&rod axis = 2, amplitude = 10, frequency = 0.1, phase_deg = 90, stop = 90 /"//LF// &
            "&rod axis = 3, amplitude = 9, frequency = 0.1333333, stop = 90 /"//LF// &
            "&truth offset_mm = 0.35, -0.22, 0.41, orbit = 'kepler', semi_major_axis_km = 6798.3, eccentricity = 0.0021"//LF// &
            "inclination_deg = 97.1, node_deg = 33, perigee_deg = 70, mean_anomaly_deg = 205, attitude = 'nadir' /"//LF// &
            "&surface length = 1.9, height = 0.7, width_bottom = 1.3, width_top = 0.8 /"//LF// &
            "&accelerometer noise_level = 9e-22, 4e-20, 9e-22, noise_corner = 8e-3, 0.05, 8e-3, noise_sides = 1 /"//LF// &
            "&atmosphere space_weather = 'given', f107 = 170, f107_mean = 165, kp = 3 /"//LF//"&a_priori signs_known = .true. /"
        integer, parameter :: RUNS = 8
        type(calibration_t) :: calibration
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        character(:), allocatable :: found
        real(dp) :: off(3), total, limits(2)
        integer :: run

        call calibration_from_text(QUIET, 'quiet', calibration, failure)
        if (failed(error, failure)) return
        total = 0
        do run = 1, RUNS
            call make_observations(calibration%case, 4711, run, observations)
            if (estimate_fails(error, 'optimal', observations, calibration%options, solution)) return
            call say_contradiction(solution%beliefs, found)
            call check(error, found, '', 'run '//number_text(real(run, dp)))
            off = solution%offset - calibration%case%satellite%offset
            total = total + dot_product(off, matmul(inverse_3x3(solution%covariance(:3, :3)), off))
        end do
        limits = chi_square_limits(3*RUNS)
        call check(error, total < limits(2), 'normalised squares: '//number_text(total))
    end subroutine test_quiet

    !> The Sun sets in the middle of two minutes, within ten seconds: the light that is seen is estimated. As a step its mean
    !> normalised square was 192.
    subroutine test_edge_of_shadow(error)
        type(error_type), allocatable, intent(out) :: error
        character(1), parameter :: LF = new_line('a')
        character(*), parameter :: SUNSET = "&calibration epoch = '2026-11-25T00:00:00', duration = 120 /"//LF// &
            "&mass_properties mass = 200, moments_of_inertia = 30, 60, 70 /"//LF//"&rods largest_moment = 10 /"//LF// &
            "&rod axis = 2, amplitude = 10, frequency = 0.1, stop = 120 /"//LF// &
            "&rod axis = 3, amplitude = 10, frequency = 0.13, stop = 120 /"//LF// &
            "&truth orbit = 'kepler', semi_major_axis_km = 6860, eccentricity = 0.001, inclination_deg = 89, node_deg = 241"//LF// &
            "perigee_deg = 90, mean_anomaly_deg = 134, attitude = 'nadir' /"//LF// &
            "&surface length = 1.2, height = 0.6, width_bottom = 0.7, width_top = 0.7 /"//LF// &
            "&atmosphere space_weather = 'given', f107 = 150, f107_mean = 150, kp = 2 /"
        integer, parameter :: RUNS = 4
        type(calibration_t) :: calibration
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        character(:), allocatable :: found
        real(dp) :: off(3), total, limits(2)
        integer :: run

        call calibration_from_text(SUNSET, 'sunset', calibration, failure)
        if (failed(error, failure)) return
        calibration%options%covariance = .false.
        total = 0
        do run = 1, RUNS
            call make_observations(calibration%case, 4711, run, observations)
            if (estimate_fails(error, 'optimal', observations, calibration%options, solution)) return
            off = solution%offset - calibration%case%satellite%offset
            total = total + dot_product(off, matmul(inverse_3x3(solution%covariance(:3, :3)), off))
        end do
        call check(error, any(solution%parameters%name == 'light_x'))
        limits = chi_square_limits(3*RUNS)
        call check(error, total < limits(2), 'normalised squares: '//number_text(total))
        associate (case => calibration%case)
            case%duration = 240
            case%satellite%rods%activations%stop = 240
            case%satellite%accelerometer%noise%level = 1e-22_dp
            case%satellite%accelerometer%noise%corner = 5e-3_dp
            calibration%options%covariance = .true.
            call make_observations(case, 4711, 1, observations)
        end associate
        if (estimate_fails(error, 'optimal', observations, calibration%options, solution)) return
        call say_contradiction(solution%beliefs, found)
        call check(error, found, '', 'the light turns against the body')
        if (allocated(error)) return
        observations%acceleration(1, :) = observations%acceleration(1, :) + 1e-9_dp*sin(3*observations%accelerometer_time)
        calibration%options%optimal%density_wave = 'none'
        if (estimate_fails(error, 'optimal', observations, calibration%options, solution)) return
        call check(error, maxval(abs(solution%beliefs%noises%score)) < 1e3_dp, 'a line that no probability tells has a score')
    end subroutine test_edge_of_shadow

    !> Ten times the report's drag, 320 km up: forces that are no straight line are larger, too, by what the case says of them.
    !> Six places of the orbit, where they differ. With sizes of the report's cases the mean normalised square is 34. Then a
    !> very quiet accelerometer 490 km up, where a fit without the density wave went astray.
    subroutine test_much_drag(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: PLACES = 6
        character(*), parameter :: ALGORITHMS(2) = [character(10) :: 'optimal', 'sequential']
        real(dp) :: limits(2), total, told_nothing
        integer :: i, k

        limits = chi_square_limits(3*PLACES)
        do k = 1, size(ALGORITHMS)
            total = 0
            told_nothing = 0
            do i = 1, PLACES
                total = total + square(6700.0_dp, '4e-20', 50.0_dp*i, 0.0_dp, ALGORITHMS(k))
                told_nothing = told_nothing + square(6700.0_dp, '4e-20', 50.0_dp*i, 3.5e-7_dp, ALGORITHMS(k))
            end do
            call check(error, total < limits(2), ALGORITHMS(k)//': normalised squares '//number_text(total))
            call check(error, told_nothing > 3*limits(2), ALGORITHMS(k)//', not told: '//number_text(told_nothing))
        end do
        total = 0
        do i = 1, PLACES
            total = total + square(6870.0_dp, '5e-24', 50.0_dp*i, 0.0_dp, 'optimal')
        end do
        call check(error, total < 3*limits(2), 'quiet: normalised squares '//number_text(total))

    contains

        !> The error of an estimate, squared in units of its covariance; huge if there is none.
        real(dp) function square(axis, noise, anomaly, drag, algorithm)
            real(dp), intent(in) :: axis, anomaly       ! km, deg
            character(*), intent(in) :: noise           ! m^2 s^-4/Hz
            real(dp), intent(in) :: drag                ! stated, m/s^2; 0: as it is
            character(*), intent(in) :: algorithm
            character(1), parameter :: LF = new_line('a')
            type(calibration_t) :: calibration
            type(observation_set_t) :: observations
            type(solution_t) :: solution
            type(error_t), allocatable :: failure
            real(dp) :: off(3)

            square = huge(square)
            call calibration_from_text("&calibration epoch = '2024-03-15T06:00:00', duration = 90 /"//LF// &
                "&mass_properties mass = 185, moments_of_inertia = 22, 48, 55, products_of_inertia = 0.8, -1.1, 0.5 /"//LF// &
                "&rods largest_moment = 12 /"//LF//"&rod axis = 1, amplitude = 8, frequency = 0.0777778, stop = 90 /"//LF// &
                "&rod axis = 2, amplitude = 10, frequency = 0.1, stop = 90 /"//LF// &
                "&rod axis = 3, amplitude = 10, frequency = 0.1222222, stop = 90 /"//LF// &
                "&truth offset_mm = 0.7, -0.35, 0.22, orbit = 'kepler', semi_major_axis_km = "//number_text(axis)//LF// &
                "eccentricity = 0.002, inclination_deg = 70, node_deg = "//number_text(360 - anomaly)//", perigee_deg = 40"//LF// &
                "mean_anomaly_deg = "//number_text(anomaly)//", attitude = 'nadir' /"//LF// &
                "&surface forces = 'plates', length = 2, height = 0.7, width_bottom = 1.2, width_top = 0.8 /"//LF// &
                "&accelerometer noise_level = 3*"//noise//", noise_corner = 3*0.01 /"//LF// &
                "&atmosphere space_weather = 'given', f107 = 180, f107_mean = 165, kp = 3 /"//LF// &
                "&a_priori drag = "//number_text(drag)//" /", 'low', calibration, failure)
            if (failed(error, failure)) return
            call make_observations(calibration%case, 4711, nint(anomaly), observations)
            calibration%options%covariance = .false.    ! nor tests: only the estimate
            if (estimate_fails(error, algorithm, observations, calibration%options, solution)) return
            off = solution%offset - calibration%case%satellite%offset
            square = dot_product(off, matmul(inverse_3x3(solution%covariance(:3, :3)), off))
        end function square
    end subroutine test_much_drag
end module test_beliefs_of_operator
