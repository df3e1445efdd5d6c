!> Several calibrations together: the joint estimate against the stacked batch, its statistics, its tests of
!> agreement; and the history of offsets.
module test_joint
    use vocabulary
    use calibrations
    use gracecg_base_constants, only: YEAR => JULIAN_YEAR
    use gracecg_base_lapack, only: solve_normal_equations, normal_equations
    use gracecg_base_text, only: split
    use gracecg_environment_time, only: utc_t, utc_plus, seconds_between, parse_utc
    use gracecg_estimation_action, only: action_t, known_offset_t, DO_NOT_USE, NOT_TESTED, TRIM_IT
    use gracecg_estimation_joint_action, only: act_on_runs, known_of_runs
    use gracecg_estimation_information, only: information_t, eliminated_t, information_of, squares_of
    use gracecg_estimation_joint_estimate, only: joint_options_t, joint_solution_t, estimate_jointly
    use gracecg_estimation_joint_runs, only: joint_run_t, run_from_observations, estimate_runs
    use gracecg_estimation_offset_history, only: history_settings_t, tank_series_t, new_tank_series, offset_history_t, &
        trace_offset
    use gracecg_estimation_offset_change, only: offset_change_t, read_changes
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_options, only: WAVE_NONE
    use gracecg_observations_parameters
    use gracecg_estimation_parameters, only: a_priori_sigmas
    use gracecg_estimation_run_information, only: run_information_t
    use gracecg_estimation_saved_estimate, only: dated_offset_t, read_offsets
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, set_noise, with_parameters
    use test_offset_movement, only: movement_tests
    use statistics, only: chi_square_limits
    implicit none
    private
    public :: collect_joint

contains

    subroutine collect_joint(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('information-added-moved-reduced', test_information), &
                    new_unittest('stacked-batch', test_stacked), &
                    new_unittest('errors-are-those-predicted', test_statistics), &
                    new_unittest('disagreement-is-told', test_disagreement), &
                    new_unittest('own-or-shared', test_own), &
                    new_unittest('broken-files', test_broken), &
                    new_unittest('history-by-hand', test_history), &
                    new_unittest('history-of-tanks', test_tanks), &
                    new_unittest('history-of-level1', test_level1_offset), &
                    new_unittest('when-the-limit-is-left', test_leaving), &
                    movement_tests()]
    end subroutine collect_joint

    !> What is eliminated leaves the covariance of the others; a change by chance adds its variances, a known one moves the
    !> estimate; the squares fall by what the best values explain.
    subroutine test_information(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: P(3, 3) = reshape([4.0_dp, 1.0_dp, 0.5_dp, 1.0_dp, 9.0_dp, -2.0_dp, 0.5_dp, -2.0_dp, 1.0_dp], &
                                                 [3, 3])
        real(dp), parameter :: X(3) = [1.0_dp, -2.0_dp, 3.0_dp], STEP(3) = [0.1_dp, 0.0_dp, -0.2_dp]
        real(dp), parameter :: Q(3) = [2.0_dp, 0.0_dp, 1e-12_dp]
        type(information_t) :: information, moved
        type(eliminated_t) :: gone
        type(error_t), allocatable :: failure
        real(dp) :: value(3), covariance(3, 3)

        call information_of(X, P, information, failure)
        call check(error, information%squares_at(X), 0.0_dp, thr=1e-12_dp)
        call check(error, squares_of(X, P), information%squares, thr=1e-12_dp)
        moved = information
        call moved%propagate(STEP, Q, failure)
        call moved%solve(value, covariance, failure)
        call check(error, maxval(abs(value - X - STEP)) < 1e-12_dp .and. maxval(abs(covariance - P - diagonal(Q))) < 1e-10_dp, &
                   'a step with its variance')
        call information%eliminate(2, gone, failure)
        call information%solve(value(:2), covariance(:2, :2), failure)
        call check(error, maxval(abs(value(:2) - X(:2))) < 1e-12_dp .and. maxval(abs(covariance(:2, :2) - P(:2, :2))) < 1e-12_dp &
                   .and. abs(information%squares_at(X(:2))) < 1e-12_dp, 'the others')
        value(3:) = gone%value_at(X(:2))
        covariance(3:, 3:) = gone%covariance_with(P(:2, :2))
        call check(error, maxval(abs(value(3:) - X(3:))) < 1e-12_dp .and. abs(covariance(3, 3) - P(3, 3)) < 1e-12_dp, &
                   'what is eliminated')

    contains

        pure function diagonal(elements) result(matrix)
            real(dp), intent(in) :: elements(3)
            real(dp) :: matrix(3, 3)

            integer :: i

            matrix = 0
            do i = 1, 3
                matrix(i, i) = elements(i)
            end do
        end function diagonal
    end subroutine test_information

    subroutine open_case(name, simulator, options, moved)
        character(*), intent(in) :: name
        type(simulator_t), intent(out) :: simulator
        type(estimation_options_t), intent(out) :: options
        real(dp), intent(in), optional :: moved(3)      !! Change of the true offset, m
        type(calibration_t) :: calibration
        type(error_t), allocatable :: failure

        call take_calibration(name, calibration)
        if (.not. allocated(failure)) then
            calibration%case%density_wave%amplitude = 0
            calibration%case%density_wave_random = .false.
            if (present(moved)) calibration%case%satellite%offset = calibration%case%satellite%offset + moved
            call make_simulator(calibration%case, simulator)
        end if
        call need(failure)
        options%optimal%density_wave = WAVE_NONE
    end subroutine open_case

    subroutine run_of(simulator, options, seed, run, tested)
        type(simulator_t), intent(in) :: simulator
        type(estimation_options_t), intent(in) :: options
        integer, intent(in) :: seed
        type(joint_run_t), intent(out) :: run
        logical, intent(in), optional :: tested     ! Its beliefs are
        type(observation_set_t) :: observations
        type(estimation_options_t) :: own
        type(error_t), allocatable :: failure

        own = options
        own%covariance = present(tested)
        call make_observations(simulator, seed, 1, observations)
        call run_from_observations(observations, own, run, failure)
        call need(failure)
    end subroutine run_of

    !> One normal matrix of both runs with every parameter of each, linearised at the same points: the joint estimate from
    !> what is saved is its solution.
    subroutine test_stacked(error)
        type(error_type), allocatable, intent(out) :: error
        character(7), parameter :: NAMES(2) = ['front-2', 'front-3']
        integer, parameter :: SHARED(7) = [SCALE_FACTORS, ROD_GAIN, FIELD_BIAS], OWN(15) = &
            [ATTITUDE_ANGLES, RATE, TORQUE, DRIFT, BIAS]
        integer, parameter :: N = 3 + size(SHARED), ALL_OF_THEM = N + 2*size(OWN)
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(whitened_problem_t) :: problem, wider
        type(run_information_t) :: saved(2)
        type(joint_run_t) :: not_made(2)
        type(joint_options_t) :: asked
        type(joint_solution_t) :: joint
        type(error_t), allocatable :: failure
        real(dp), allocatable :: partials(:, :), residuals(:), weights(:), normal(:, :), rhs(:)
        real(dp) :: stacked(ALL_OF_THEM, ALL_OF_THEM), side(ALL_OF_THEM), value(ALL_OF_THEM), condition
        real(dp) :: covariance(ALL_OF_THEM, ALL_OF_THEM), sigma(PARAMETERS), start(PARAMETERS, 2), information(N, N)
        integer :: i, k, m, place(N + size(OWN))

        stacked = 0
        side = 0
        do i = 1, 2
            call open_case(NAMES(i), simulator, options)
            options%covariance = .false.
            options%optimal%estimate_within_limits = .false.    ! the parameters of the stacked batch alone
            options%optimal%estimate_scale_factors = .true.
            options%optimal%estimate_rod_gain = .true.
            options%optimal%estimate_magnetometer_bias = .true.
            call make_observations(simulator, 5, 1, observations)
            call estimate_optimal(observations, options, solution, failure, problem=problem)
            if (failed(error, failure)) return
            saved(i) = solution%information

            call with_parameters(observations%knowledge, options, problem, [OFFSET, SHARED, OWN], wider)
            call set_noise(wider, failure)
            m = wider%observations
            allocate (partials(N + size(OWN), m), residuals(m), weights(m), normal(N + size(OWN), N + size(OWN)), &
                      rhs(N + size(OWN)))
            call wider%linearise(partials, residuals, weights, failure)
            m = wider%star_rows + wider%acceleration_rows
            partials(:, m + 1:) = 0
            residuals(m + 1:) = 0
            call normal_equations(partials, residuals, normal, rhs)
            start(:, i) = wider%state%value
            place = [(k, k=1, N), (N + (i - 1)*size(OWN) + k, k=1, size(OWN))]
            stacked(place, place) = stacked(place, place) + normal
            ! the first run's point is that of the joint parameters
            side(place) = side(place) + rhs
            if (i == 2) then
                information = normal(:N, :N)
                side(:N) = side(:N) + matmul(information, &
                                             start([OFFSET, SHARED], 2) - start([OFFSET, SHARED], 1))
                side(place(N + 1:)) = side(place(N + 1:)) + matmul(normal(N + 1:, :N), &
                                             start([OFFSET, SHARED], 2) - start([OFFSET, SHARED], 1))
            end if
            deallocate (partials, residuals, weights, normal, rhs)
        end do
        sigma = a_priori_sigmas(observations%knowledge)
        do k = 1, size(SHARED)
            stacked(3 + k, 3 + k) = stacked(3 + k, 3 + k) + 1/sigma(SHARED(k))**2
            side(3 + k) = side(3 + k) - start(SHARED(k), 1)/sigma(SHARED(k))**2
        end do
        call solve_normal_equations(stacked, side, value, covariance, condition, failure)
        if (failed(error, failure)) return
        call estimate_jointly(saved, asked, joint, failure)
        if (failed(error, failure)) return
        do k = 1, 3
            call check(error, joint%offset(k), start(OFFSET(k), 1) + value(k), thr=1e-9_dp*abs(joint%offset(k)), &
                       more='offset')
            call check(error, joint%covariance(k, k), covariance(k, k), thr=1e-9_dp*covariance(k, k), more='variance')
        end do
        do k = 1, size(SHARED)
            call check(error, joint%parameter(3 + k), start(SHARED(k), 1) + value(3 + k), &
                       thr=1e-9_dp*sqrt(covariance(3 + k, 3 + k)) + 1e-9_dp*abs(joint%parameter(3 + k)), more='shared')
        end do
        call estimate_runs(not_made, asked, joint, failure)
        call check_fails(error, failure, 'run 1 has not been estimated')
    end subroutine test_stacked

    !> Over pairs of runs, front-2 with front-3: the squares of the errors in units of the covariance, and the statistic of
    !> agreement, have the mean of chi square with three degrees of freedom; the sigmas are what the information of both gives.
    subroutine test_statistics(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: PAIRS = 40
        type(simulator_t) :: simulators(2)
        type(estimation_options_t) :: options
        type(joint_run_t) :: runs(2)
        type(joint_options_t) :: asked
        type(joint_solution_t) :: joint
        type(error_t), allocatable :: failure
        real(dp) :: squares, statistic, limits(2), inverse(3, 3), weighted(3), condition
        integer :: i

        call open_case('front-2', simulators(1), options)
        call open_case('front-3', simulators(2), options)
        options%optimal%estimate_scale_factors = .true.
        options%optimal%estimate_magnetometer_bias = .true.
        squares = 0
        statistic = 0
        do i = 1, PAIRS
            call run_of(simulators(1), options, 2*i, runs(1))
            call run_of(simulators(2), options, 2*i + 1, runs(2))
            call estimate_runs(runs, asked, joint, failure)
            if (failed(error, failure)) return
            call solve_normal_equations(joint%covariance, joint%offset - simulators(1)%case%satellite%offset, weighted, &
                                        inverse, condition, failure)
            squares = squares + dot_product(joint%offset - simulators(1)%case%satellite%offset, weighted)
            statistic = statistic + joint%statistic
            call check(error, joint%consistent, 'sound runs disagree')
        end do
        limits = chi_square_limits(3*PAIRS)
        call check(error, statistic > limits(1) .and. statistic < limits(2), 'agreement')
        ! scale factors and bias are constants of the simulation, one to two of their sigmas: no draw, so only a bound
        call check(error, squares < 2*limits(2), 'errors')
    end subroutine test_statistics

    !> Masses moved by 0.2 mm between the runs, unknown: told. Known: agreed on, and the last offset is found.
    subroutine test_disagreement(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: CHANGE(3) = [0.0_dp, 0.0_dp, 0.2e-3_dp]
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(joint_run_t) :: runs(3)
        type(joint_options_t) :: asked
        type(joint_solution_t) :: joint
        type(string_t) :: names(3)
        type(action_t) :: action
        type(known_offset_t) :: known
        type(observation_set_t) :: observations
        real(dp) :: stated(3)
        type(error_t), allocatable :: failure

        names = split('first,second,third', ',')
        call open_case('front-3', simulator, options)
        call run_of(simulator, options, 1, runs(1), .true.)
        call run_of(simulator, options, 2, runs(2), .true.)
        call open_case('front-3', simulator, options, CHANGE)
        call run_of(simulator, options, 3, runs(3), .true.)
        runs(2)%information%epoch = utc_plus(runs(1)%information%epoch, 1e6_dp)
        runs(3)%information%epoch = utc_plus(runs(1)%information%epoch, 3e6_dp)
        call estimate_jointly(runs%information, asked, joint, failure)
        if (failed(error, failure)) return
        call check(error, .not. joint%consistent .and. .not. joint%runs(3)%agrees .and. joint%degrees == 6, 'not told')
        call check(error, minloc(joint%runs%probability, 1), 3)
        call check(error, all(abs(joint%runs(3)%difference - CHANGE) < 5*joint%runs(3)%difference_sigma), 'difference')
        call act_on_runs(runs, asked, names, joint, action)
        call check(error, action%kind == DO_NOT_USE .and. index(action%text, 'third differs from the rest by') > 0 .and. &
                   index(action%text, 'without it the others agree (') > 0, action%text)
        call estimate_jointly(runs(2:)%information, asked, joint, failure)
        call act_on_runs(runs(2:), asked, names(2:), joint, action)
        call check(error, action%kind == DO_NOT_USE .and. index(action%text, 'third minus second is ') > 0, &
                   'nobody knows which of two: '//action%text)
        call estimate_jointly(runs(:2)%information, asked, joint, failure)
        call act_on_runs(runs(:2), asked, names(:2), joint, action)
        call check(error, action%kind == TRIM_IT .and. all(action%trimmed), action%text)
        ! what both state of the same satellite does not average out
        known = known_of_runs(runs(:2), joint)
        stated = sqrt(known%sigma**2 - sigmas(joint%covariance)**2)
        associate (one => runs(1)%solution%beliefs%stated, other => runs(2)%solution%beliefs%stated)
            call check(error, all(stated > 0.999_dp*min(one, other) .and. stated < 1.001_dp*max(one, other)), 'what is stated')
        end associate
        deallocate (runs(2)%solution%beliefs)
        call act_on_runs(runs(:2), asked, names(:2), joint, action)
        call check(error, action%kind == NOT_TESTED .and. index(action%text, 'second: what its setup says was not tested') > 0, &
                   action%text)
        asked%changes = [offset_change_t(utc_plus(runs(1)%information%epoch, 2e6_dp), CHANGE, [1.0_dp, 1.0_dp, 1.0_dp]*1e-6_dp)]
        call estimate_jointly(runs%information, asked, joint, failure)
        if (failed(error, failure)) return
        call check(error, joint%consistent, 'a known change')
        call check(error, all(abs(joint%offset - simulator%case%satellite%offset) < &
                              5*sigmas(joint%covariance)), 'the last offset')
        ! a change whose size nobody knows: only the last run counts
        asked%changes(1)%sigma = 1
        call estimate_jointly(runs%information, asked, joint, failure)
        call check(error, all(abs(sigmas(joint%covariance)/joint%runs(3)%sigma - 1) < 1e-3_dp), &
                   'an unknown change')
        ! a negated run, so far off that no probability tells: it is named, and not what it would make of the others
        asked = joint_options_t()
        call open_case('front-3', simulator, options)
        call run_of(simulator, options, 3, runs(3), .true.)
        call make_observations(simulator, 2, 1, observations)
        observations%acceleration = -observations%acceleration
        call run_from_observations(observations, options, runs(2), failure)
        if (.not. allocated(failure)) call estimate_runs(runs, asked, joint, failure)
        if (failed(error, failure)) return
        call act_on_runs(runs, asked, names, joint, action)
        call check(error, index(action%text, 'second differs from the rest') > 0 .and. &
                   index(action%text, 'without it the others agree (') > 0, action%text)
    end subroutine test_disagreement

    !> What is shared is known better; runs that believe different things may not share.
    subroutine test_own(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(joint_run_t) :: runs(2)
        type(joint_options_t) :: asked
        type(joint_solution_t) :: shared, own
        type(error_t), allocatable :: failure
        integer :: i

        call open_case('front-2', simulator, options)
        options%optimal%estimate_scale_factors = .true.
        call run_of(simulator, options, 1, runs(1))
        call open_case('front-3', simulator, options)
        options%optimal%estimate_scale_factors = .true.
        call run_of(simulator, options, 2, runs(2))
        call estimate_jointly(runs%information, asked, shared, failure)
        asked%own(1) = .true.
        call estimate_jointly(runs%information, asked, own, failure)
        if (failed(error, failure)) return
        ! two scale factors of one sigma each average out, one does not
        call check(error, shared%covariance(3, 3) > own%covariance(3, 3), 'one scale factor for both')
        asked%own = .false.
        asked%added(4) = .true.     ! inertia
        call estimate_jointly(runs%information, asked, own, failure)
        if (failed(error, failure)) return
        call check(error, all([(own%covariance(i, i) > shared%covariance(i, i), i=1, 3)]) .and. &
                   all(own%parameter_sigma(11:) > 0), 'inertia')
        runs(2)%information%belief(1) = 1.01_dp
        call estimate_jointly(runs%information, asked, own, failure)
        call check_fails(error, failure, 'different scale-factors: 1 and 1.01 ... --own')
    end subroutine test_own

    !> Offsets in a file of this content must be refused.
    subroutine offsets_refused(error, name, content, parts)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name, content, parts
        type(dated_offset_t), allocatable :: offsets(:)
        type(error_t), allocatable :: failure

        call make_file(name, content)
        call read_offsets(FOLDER//name, offsets, failure)
        call check_fails(error, failure, parts)
    end subroutine offsets_refused

    subroutine test_broken(error)
        type(error_type), allocatable, intent(out) :: error
        type(offset_change_t), allocatable :: changes(:)
        type(error_t), allocatable :: failure
        character(1), parameter :: LF = new_line('a')
        character(*), parameter :: HEAD = 'time_utc,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm'//LF

        call offsets_refused(error, 'bound.json', '{"command": "bound"}', 'is no estimate ... --format json')
        call offsets_refused(error, 'bound.json', '{"command": "estimate", "epoch_utc": "1989-02-30"}', 'day 30')
        call offsets_refused(error, 'spoiled.json', '{"command": "estimate", "epoch_utc": "1989-01-02", '// &
                             '"action": {"kind": "do not use", "text": "do not use: axes"}, "offset_m": [0, 0, 0], '// &
                             '"covariance": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}}', &
                             'spoiled.json ... not to be used ... axes')
        call make_file('changes.csv', HEAD//'1989-01-02T00:00:00,1,2,3,-1,0,0'//LF)
        call read_changes(FOLDER//'changes.csv', changes, failure)
        call check_fails(error, failure, 'changes.csv:2 ... negative')
        call make_file('changes.csv', HEAD//'1989-13-02T00:00:00,1,2,3,1,0,0'//LF)
        call read_changes(FOLDER//'changes.csv', changes, failure)
        call check_fails(error, failure, 'changes.csv:2 ... column time_utc')
        call make_file('changes.csv', HEAD//'1989-01-02,1,2,3,0.1,0.2,0.3'//LF)
        call read_changes(FOLDER//'changes.csv', changes, failure)
        if (failed(error, failure)) return
        call check(error, all(abs([changes(1)%change, changes(1)%sigma]/MILLIMETRE - &
                                  [1.0_dp, 2.0_dp, 3.0_dp, 0.1_dp, 0.2_dp, 0.3_dp]) < 1e-12_dp))
        call offsets_refused(error, 'offsets.csv', HEAD//'1989-01-02,1,2,3,0.1,0,0.3'//LF, &
                             'offsets.csv:2 ... sigma_y_mm ... positive')
    end subroutine test_broken

    subroutine calibrations_of(offsets)
        type(dated_offset_t), intent(out) :: offsets(3)
        integer :: i, k

        do i = 1, 3
            offsets(i)%time = utc_plus(utc_t(52426, 0.0_dp), (i - 1)*YEAR/2)
            offsets(i)%offset = [0.02_dp, -0.01_dp*i, 0.005_dp*i**2]*MILLIMETRE
            do k = 1, 3
                offsets(i)%covariance(k, k) = (0.005_dp*MILLIMETRE*k)**2
            end do
        end do
        offsets(2)%covariance(1, 2) = 0.3_dp*sqrt(offsets(2)%covariance(1, 1)*offsets(2)%covariance(2, 2))
        offsets(2)%covariance(2, 1) = offsets(2)%covariance(1, 2)
    end subroutine calibrations_of

    !> Filter and smoother against the least squares of all offsets at once, and the change between that is known.
    subroutine test_history(error)
        type(error_type), allocatable, intent(out) :: error
        type(dated_offset_t) :: offsets(3)
        type(offset_change_t) :: changes(1)
        type(tank_series_t) :: no_tanks
        type(history_settings_t) :: settings
        type(offset_history_t) :: history
        type(error_t), allocatable :: failure
        real(dp), parameter :: MM = MILLIMETRE
        real(dp) :: normal(9, 9), rhs(9), value(9), covariance(9, 9), inverse(3, 3), unused(3), condition, walk
        integer :: i, k, n

        call calibrations_of(offsets)
        changes(1) = offset_change_t(utc_plus(offsets(1)%time, 0.7_dp*YEAR), [0.1_dp, 0.0_dp, 0.0_dp]*MM, &
                                     [0.002_dp, 0.0_dp, 0.0_dp]*MM)
        settings%futures = 10
        settings%walk = 0.01_dp*MM
        call trace_offset(offsets([3, 1, 2]), changes, no_tanks, settings, history, failure)
        if (failed(error, failure)) return
        ! in millimetres: three offsets, seen once each, tied by the walk
        normal = 0
        rhs = 0
        do i = 1, 3
            call solve_normal_equations(offsets(i)%covariance/MM**2, [0.0_dp, 0.0_dp, 0.0_dp], unused, inverse, condition, failure)
            normal(3*i - 2:3*i, 3*i - 2:3*i) = inverse
            rhs(3*i - 2:3*i) = matmul(inverse, offsets(i)%offset/MM)
        end do
        do i = 1, 2
            do k = 1, 3
                walk = 0.01_dp**2*seconds_between(offsets(i)%time, offsets(i + 1)%time)/YEAR
                n = 3*i - 3 + k
                if (i == 2 .and. k == 1) walk = walk + 0.002_dp**2
                normal(n, n) = normal(n, n) + 1/walk
                normal(n + 3, n + 3) = normal(n + 3, n + 3) + 1/walk
                normal(n, n + 3) = normal(n, n + 3) - 1/walk
                normal(n + 3, n) = normal(n + 3, n) - 1/walk
                if (i == 2 .and. k == 1) then
                    rhs(n) = rhs(n) - 0.1_dp/walk
                    rhs(n + 3) = rhs(n + 3) + 0.1_dp/walk
                end if
            end do
        end do
        call solve_normal_equations(normal, rhs, value, covariance, condition, failure)
        n = 0
        do i = 1, size(history%points)
            if (.not. history%points(i)%is_calibration) cycle
            n = n + 1
            call check(error, all(abs(history%points(i)%smoothed/MM - value(3*n - 2:3*n)) < 1e-8_dp), 'smoother')
            call check(error, all(abs(history%points(i)%smoothed_covariance/MM**2 - &
                                      covariance(3*n - 2:3*n, 3*n - 2:3*n)) < 1e-12_dp), 'its covariance')
        end do
        call check(error, n == 3 .and. history%degrees == 6, 'three calibrations')
        call check(error, all(abs(history%today%filtered/MM - value(7:9)) < 1e-8_dp), 'today')
        call trace_offset(offsets, changes, no_tanks, settings, history, failure, today=utc_t(52000, 0.0_dp))
        call check_fails(error, failure, 'before the last calibration')
        call trace_offset(offsets([1, 2, 3, 2]), changes, no_tanks, settings, history, failure)
        call check_fails(error, failure, 'is given twice')
        offsets(3)%time = offsets(2)%time       ! two satellites' methods, or two fits, of one time
        call trace_offset(offsets, changes, no_tanks, settings, history, failure)
        call check_passes(error, failure)
    end subroutine test_history

    !> A result of level1 estimate is an offset with its time: 2020-01-01 00:00:00 UTC is 18 s later in GPS time.
    subroutine test_level1_offset(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HEAD = '{"command": "level1 estimate", "epoch_gps_s": 631108818.5, '// &
            '"offset_mm": [0.1, -0.2, 0.3], '
        character(*), parameter :: MATRIX = '"covariance_mm2": [[4e-6, 1e-6, 0], [1e-6, 9e-6, 0], [0, 0, 1e-6]], '
        type(dated_offset_t), allocatable :: offsets(:)
        type(error_t), allocatable :: failure
        type(utc_t) :: epoch

        call make_file('level1_good.json', HEAD//MATRIX//'"flag": 1, "reason": "sigma"}')
        call read_offsets(FOLDER//'level1_good.json', offsets, failure)
        if (failed(error, failure)) return
        call parse_utc('2020-01-01T00:00:00.5', epoch, failure)
        call check(error, abs(seconds_between(epoch, offsets(1)%time)) < 1e-6_dp, 'time')
        call check(error, maxval(abs(offsets(1)%offset - [1e-4_dp, -2e-4_dp, 3e-4_dp])) < 1e-15_dp .and. &
                   abs(offsets(1)%covariance(1, 2) - 1e-12_dp) < 1e-20_dp .and. &
                   abs(offsets(1)%covariance(2, 2) - 9e-12_dp) < 1e-20_dp, 'offset and covariance')
        call check(error, offsets(1)%moves_masses, 'nothing against a trim')
        call make_file('level1_again.json', HEAD//MATRIX//'"flag": 1, "reason": "sign", "action": {"kind": "calibrate again"}}')
        call read_offsets(FOLDER//'level1_again.json', offsets, failure)
        call check(error, .not. allocated(failure) .and. .not. offsets(1)%moves_masses, 'it says itself to calibrate again')
        call offsets_refused(error, 'level1_bad.json', HEAD//MATRIX//'"flag": 2, "reason": "wrong sign"}', &
                             'level1_bad.json ... not to be used ... wrong sign')
        call offsets_refused(error, 'level1_cut.json', HEAD//MATRIX//'"flag": 1, "reason": "sigma"', &
                             'level1_cut.json: is no whole JSON file')
        call offsets_refused(error, 'level1_cut.json', &
                             HEAD//'"covariance_mm2": [[4e-6, 1e-6, 0], [2e-6, 9e-6, 0], [0, 0, 1e-6]], "flag": 0}', &
                             'not symmetric')
        call offsets_refused(error, 'level1_cut.json', HEAD//'"flag": 0}', 'covariance_mm2')
        call offsets_refused(error, 'level1_cut.json', HEAD//MATRIX//'"flag": 12abc}', '"12abc" of "flag" is no number')
        call offsets_refused(error, 'level1_cut.json', &
                             '{"command": "level1 estimate", "epoch_gps_s": 0, "offset_mm": [2e3, 0, 0], '// &
                             MATRIX//'"flag": 0}', &
                             'an offset of 2 m')
    end subroutine test_level1_offset

    !> Gas that leaves one tank moves the centre of mass to the other.
    subroutine test_tanks(error)
        type(error_type), allocatable, intent(out) :: error
        type(dated_offset_t) :: offsets(3)
        type(offset_change_t) :: none(0)
        type(tank_series_t) :: tanks
        type(history_settings_t) :: settings
        type(offset_history_t) :: history
        type(error_t), allocatable :: failure
        real(dp), parameter :: PLACES(3, 2) = reshape([0.5_dp, 0.0_dp, 0.0_dp, -0.5_dp, 0.0_dp, 0.0_dp], [3, 2])

        call calibrations_of(offsets)
        ! 0.1 kg more out of tank 1 in a year: the centre of mass goes back by 0.05 kg m/415.9 kg, d forward
        call new_tank_series([offsets(1)%time, offsets(3)%time], reshape([16.0_dp, 16.0_dp, 13.9_dp, 14.0_dp], [2, 2]), &
                             PLACES, 420.0_dp, tanks, failure)
        if (failed(error, failure)) return
        settings%walk = 1e-9_dp
        settings%futures = 10
        call trace_offset(offsets(1:1), none, tanks, settings, history, failure, today=offsets(3)%time)
        call check(error, history%today%filtered(1) - offsets(1)%offset(1), 0.05_dp/415.9_dp, thr=1e-9_dp)
        call new_tank_series([offsets(1)%time, offsets(1)%time], reshape([16.0_dp, 16.0_dp, 13.9_dp, 14.0_dp], [2, 2]), &
                             PLACES, 420.0_dp, tanks, failure)
        call check_fails(error, failure, 'times must rise')
        call new_tank_series([offsets(1)%time, offsets(3)%time], reshape([16.0_dp, -1.0_dp, 13.9_dp, 14.0_dp], [2, 2]), &
                             PLACES, 420.0_dp, tanks, failure)
        call check_fails(error, failure, 'is negative')
    end subroutine test_tanks

    !> A walk along one axis from the middle between two walls: half of the paths have left after t with 4/pi sum
    !> (-1)^k/(2k + 1) exp(-(2k + 1)^2 pi^2 q t/(8 a^2)) = 1/2, which is q t = 0.7577 a^2 (the first term alone gives it to
    !> 1e-3).
    subroutine test_leaving(error)
        type(error_type), allocatable, intent(out) :: error
        type(dated_offset_t) :: offsets(1)
        type(offset_change_t) :: none(0)
        type(tank_series_t) :: no_tanks
        type(history_settings_t) :: settings
        type(offset_history_t) :: history
        type(error_t), allocatable :: failure
        real(dp) :: expected, found
        integer :: k

        offsets(1)%time = utc_t(52426, 0.0_dp)
        do k = 1, 3
            offsets(1)%covariance(k, k) = 1e-18_dp
        end do
        settings%walk = [0.1e-3_dp, 1e-9_dp, 1e-9_dp]
        settings%step = 86400
        call trace_offset(offsets, none, no_tanks, settings, history, failure)
        if (failed(error, failure)) return
        expected = 0.7577_dp*YEAR
        found = seconds_between(offsets(1)%time, history%leaving(2))
        ! 2000 futures: 2 % of the time; steps of a day see 0.58 sqrt(q day) too little of the way: 6 %
        call check(error, history%leaves .and. abs(found/expected - 1.06_dp) < 0.08_dp, 'half of the paths')
        call check(error, seconds_between(history%calibrate_by, history%leaving(1)) > 0 .and. &
                   seconds_between(history%leaving(1), history%leaving(2)) > 0 .and. &
                   seconds_between(history%leaving(2), history%leaving(3)) > 0, 'order')
        call check(error, history%left_in_the_end, 1.0_dp)
        settings%limit = 10
        call trace_offset(offsets, none, no_tanks, settings, history, failure)
        call check_passes(error, failure)
        call check(error, history%left_in_the_end <= 0 .and. .not. history%leaves, 'a limit out of reach')
    end subroutine test_leaving
end module test_joint
