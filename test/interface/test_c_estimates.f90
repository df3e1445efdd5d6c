!> The C interface to observation sets and estimates, called as C calls it: the numbers are those of the Fortran API.
module test_c_estimates
    use, intrinsic :: iso_c_binding, only: c_int, c_int32_t, c_intptr_t, c_size_t
    use vocabulary
    use gracecg, only: observation_set_t, solution_t, estimate_offset, report_options, ESTIMATOR_NAMES, moment_series_t, &
        new_moment_series, take_measured_moments, dipole_moment, joint_run_t, joint_solution_t, joint_options_t, &
        run_from_observations, estimate_runs, arc_chain_t, estimate_chain, fit_record_t, fit_diagnostics_t, diagnose, &
        verdict_t, judge, action_t, act_on_runs
    use c_library
    use c_checks
    implicit none
    private
    public :: collect_c_estimates

    !> What an observation set is made of.
    type :: samples_t
        integer :: n(4)
        integer(c_int32_t), allocatable :: head(:)
        real(dp), allocatable, dimension(:) :: ta, a, ts, q, tm, b, to, x
    end type samples_t

contains

    subroutine collect_c_estimates(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('estimate-as-in-fortran', test_estimate), &
                    new_unittest('joint-estimate-as-in-fortran', test_joint_estimate), &
                    new_unittest('chain-as-in-fortran', test_chain), &
                    new_unittest('observations-from-arrays', test_arrays), &
                    new_unittest('observations-in-files', test_files), &
                    new_unittest('options', test_options), &
                    new_unittest('optimal-and-sequential', test_details), &
                    new_unittest('samples-not-finite', test_bad_samples), &
                    new_unittest('not-converged', test_not_converged), &
                    new_unittest('not-to-be-used', test_not_usable)]
    end subroutine collect_c_estimates

    !> The samples of an observation set, and how many there are.
    subroutine take_samples(observations, samples)
        integer(c_intptr_t), intent(in) :: observations
        type(samples_t), intent(out) :: samples

        samples%n = nint(item(observations, 'counts', 4))
        associate (n => samples%n)
            samples%ta = item(observations, 'accelerometer_time', n(1))
            samples%a = item(observations, 'acceleration', 3*n(1))
            samples%ts = item(observations, 'star_camera_time', n(2))
            samples%head = nint(item(observations, 'star_camera_head', n(2)))
            samples%q = item(observations, 'quaternion', 4*n(2))
            samples%tm = item(observations, 'magnetometer_time', n(3))
            samples%b = item(observations, 'flux_density', 3*n(3))
            samples%to = item(observations, 'orbit_time', n(4))
            samples%x = item(observations, 'orbit_position', 3*n(4))
        end associate
    end subroutine take_samples

    !> An observation set of samples.
    subroutine create(setup, samples, made)
        integer(c_intptr_t), intent(in) :: setup
        type(samples_t), intent(in) :: samples
        integer(c_intptr_t), intent(inout) :: made

        associate (s => samples, n => int(samples%n, c_size_t))
            status = gracecg_observations_create(setup, n(1), s%ta, s%a, n(2), s%ts, s%head, s%q, n(3), s%tm, s%b, n(4), s%to, &
                                                 s%x, made, failure)
        end associate
    end subroutine create

    !> The offset and its covariance by an algorithm.
    subroutine estimate(algorithm, observations, numbers, warnings)
        character(*), intent(in) :: algorithm
        integer(c_intptr_t), intent(in) :: observations
        real(dp), intent(out) :: numbers(12)
        character(:), allocatable, intent(out), optional :: warnings
        integer(c_intptr_t) :: fit

        status = gracecg_estimate(c_string(algorithm), observations, fit, failure)
        numbers = [item(fit, 'offset', 3), item(fit, 'covariance', 9)]
        if (present(warnings)) call get_words(fit, 'warnings', warnings)
        if (gracecg_free(fit) /= OK) status = HAS_FAILED
    end subroutine estimate

    !> Every algorithm, on the same observations through both interfaces.
    subroutine test_estimate(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: set
        type(solution_t) :: expected
        type(error_t), allocatable :: problem
        character(:), allocatable :: warnings
        integer(c_intptr_t) :: observations, fit
        integer :: i, k

        call simulate('front-3', 5, 2, observations)
        call check_ok(error)
        set = simulated_set('front-3', 5, 2)
        do i = 1, size(ESTIMATOR_NAMES)
            call check_ok(error, gracecg_estimate(c_string(trim(ESTIMATOR_NAMES(i))), observations, fit, failure))
            call estimate_offset(trim(ESTIMATOR_NAMES(i)), set, report_options('front-3'), expected, problem)
            call check_equal(error, [item(fit, 'offset', 3), item(fit, 'covariance', 9), item(fit, 'drift', 3), &
                                     item(fit, 'bias', 3)], &
                             [expected%offset, expected%covariance, expected%drift, expected%bias], 'offset')
            call check_equal(error, [item(fit, 'quaternion', 4), item(fit, 'angular_velocity', 3), &
                                     item(fit, 'residual_rms', 3), item(fit, 'condition', 1)], &
                             [expected%quaternion, expected%angular_velocity, expected%residual_rms, &
                              expected%condition], 'the rest')
            call check_equal(error, item(fit, 'sigma', 3), [(sqrt(expected%covariance(k, k)), k=1, 3)], 'sigma')
            call check_equal(error, [item(fit, 'iterations', 1), item(fit, 'converged', 1)], &
                             [real(expected%iterations, dp), 1.0_dp], 'iterations, convergence')
            call get_words(fit, 'warnings', warnings)
            call check(error, count([(warnings(k:k) == new_line('a'), k=1, len(warnings))]), size(expected%warnings), 'warnings')
            status = gracecg_free(fit)
        end do
        status = gracecg_free(observations)
    end subroutine test_estimate

    subroutine test_joint_estimate(error)
        type(error_type), allocatable, intent(out) :: error
        character(7), parameter :: NAMES(2) = ['front-2', 'front-3']
        type(joint_run_t) :: runs(2)
        type(joint_solution_t) :: expected
        type(observation_set_t) :: set
        type(error_t), allocatable :: problem
        type(action_t) :: action
        integer(c_intptr_t) :: observations(2), joint, other
        integer :: i

        do i = 1, 2
            call simulate(NAMES(i), 5, 2, observations(i))
            call check_ok(error)
            set = simulated_set(NAMES(i), 5, 2)
            call run_from_observations(set, report_options(NAMES(i)), runs(i), problem)
        end do
        call estimate_runs(runs, joint_options_t(), expected, problem)
        call check_ok(error, gracecg_estimate_joint(2_c_size_t, observations, joint, failure))
        call check_equal(error, [item(joint, 'offset', 3), item(joint, 'covariance', 9), item(joint, 'chi_square', 1), &
                                 item(joint, 'probability', 1)], &
                         [expected%offset, expected%covariance, expected%statistic, expected%probability], 'joint')
        call check_equal(error, [item(joint, 'difference', 6), item(joint, 'difference_sigma', 6)], &
                         [expected%runs(1)%difference, expected%runs(2)%difference, expected%runs(1)%difference_sigma, &
                          expected%runs(2)%difference_sigma], 'differences')
        call check_equal(error, [item(joint, 'degrees', 1), item(joint, 'consistent', 1)], [3.0_dp, 1.0_dp], 'agreement')
        call act_on_runs(runs, joint_options_t(), [string_t('run 1'), string_t('run 2')], expected, action)
        call check_equal(error, [item(joint, 'action_kind', 1), item(joint, 'action_sigma', 3)], &
                         [real(action%kind, dp), action%sigma], 'action')
        status = gracecg_free(joint)
        call simulate('back-3', 5, 2, other)
        call check_refused(error, NOT_USABLE, 'run 2 minus run 1', &
                           gracecg_estimate_joint(2_c_size_t, [observations(2), other], joint, failure))
        call check_equal(error, item(joint, 'action_kind', 1), [4.0_dp], 'runs that do not agree')
        status = gracecg_free(joint)
        status = gracecg_free(other)
        call check_refused(error, BAD_SIZE, 'count = 0', gracecg_estimate_joint(NONE, observations, joint, failure))
        status = gracecg_free(observations(2))
        status = gracecg_estimate_joint(2_c_size_t, observations, joint, failure)
        call check_refused(error, BAD_HANDLE, 'observation set')
        status = gracecg_free(observations(1))
    end subroutine test_joint_estimate

    !> A minute in three arcs.
    subroutine test_chain(error)
        type(error_type), allocatable, intent(out) :: error
        type(arc_chain_t) :: expected
        type(observation_set_t) :: set
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: observations, chain

        call simulate('front-3', 5, 2, observations)
        call check_ok(error)
        set = simulated_set('front-3', 5, 2)
        call estimate_chain(set, report_options('front-3'), joint_options_t(), 20.0_dp, 1, expected, problem)
        call check_ok(error, gracecg_estimate_chain(observations, 20.0_dp, 2, chain, failure))
        call check_equal(error, [item(chain, 'offset', 3), item(chain, 'covariance', 9), item(chain, 'chi_square', 1)], &
                         [expected%solution%offset, expected%solution%covariance, expected%solution%statistic], 'chain')
        call check_equal(error, [item(chain, 'arcs', 1), item(chain, 'joined', 1)], [3.0_dp, 1.0_dp*count(expected%arcs%joined)], &
                         'arcs')
        status = gracecg_free(chain)
        call check_refused(error, BAD_VALUE, 'threads', gracecg_estimate_chain(observations, 20.0_dp, 0, chain, failure))
        call check_refused(error, HAS_FAILED, 'arcs of 1 s', gracecg_estimate_chain(observations, 1.0_dp, 1, chain, failure))
        call check_refused(error, NULL_POINTER, 'chain', gracecg_estimate_chain(observations, 20.0_dp, 1, error=failure))
        status = gracecg_free(observations)
    end subroutine test_chain

    !> What was taken out of a set makes the same set again: same estimate, bit by bit. With gaps there
    !> are warnings.
    subroutine test_arrays(error)
        type(error_type), allocatable, intent(out) :: error
        type(samples_t) :: samples, fewer
        type(observation_set_t) :: set
        type(solution_t) :: expected
        type(moment_series_t) :: series
        type(error_t), allocatable :: problem
        character(:), allocatable :: text, warnings
        real(dp) :: there(12), again(12), time(121), moment(3, 121)
        integer(c_intptr_t) :: observations, copy, knowledge, measured
        integer :: k

        call simulate('front-3', 1, 1, observations)
        call check_ok(error)
        call take_samples(observations, samples)
        call check(error, all(samples%n == [600, 240, 60, 61]), 'counts')
        ! the setup by way of its text
        status = gracecg_setup_from(observations, NONE, setup=knowledge, error=failure)
        call get_words(knowledge, 'text', text)
        status = gracecg_free(knowledge)
        call check_ok(error, gracecg_setup_open(c_string(text), knowledge, failure))
        call create(knowledge, samples, copy)
        call check_ok(error)
        call estimate('ascfest', observations, there)
        call estimate('ascfest', copy, again)
        call check_equal(error, again, there, 'estimate of the copy')
        status = gracecg_free(copy)

        ! measured moments: the numbers of the Fortran API
        set = simulated_set('front-3', 1, 1)
        time = [(0.5_dp*k, k=0, 120)]
        do k = 1, size(time)
            moment(:, k) = 1.02_dp*dipole_moment(set%knowledge%rods, time(k))
        end do
        call check_ok(error, gracecg_setup_from(knowledge, size(time, kind=c_size_t), time, moment, measured, failure))
        call create(measured, samples, copy)
        call estimate('assest-fde', copy, again)
        call new_moment_series(time, moment, series, problem)
        call take_measured_moments(series, set%knowledge%rods)
        call estimate_offset('assest-fde', set, report_options('front-3'), expected, problem)
        call check_equal(error, again, [expected%offset, expected%covariance], 'estimate from measured moments')
        call free(copy, measured)
        moment(1, 7) = 1e4_dp
        status = gracecg_setup_from(knowledge, size(time, kind=c_size_t), time, moment, measured, failure)
        call check_refused(error, BAD_VALUE, 'have to be in A m^2')
        status = gracecg_setup_from(knowledge, ONE, time, setup=measured, error=failure)
        call check_refused(error, NULL_POINTER, 'moment')

        fewer = samples
        fewer%n(1) = 590       ! the last second is missing
        call create(knowledge, fewer, copy)
        call estimate('assest-fde', copy, again, warnings)
        call check(error, status == OK .and. index(warnings, '10 of 600 samples are missing') > 0, warnings)
        status = gracecg_free(copy)

        ! without the orbit, and without a magnetometer: neither is too little
        fewer = samples
        fewer%n(4) = 0
        call create(knowledge, fewer, copy)
        call check_ok(error)
        status = gracecg_free(copy)
        fewer%n(3) = 0
        call create(knowledge, fewer, copy)
        call check_refused(error, BAD_VALUE, 'magnetometer: fewer than two samples')
        status = gracecg_observations_create(knowledge, NONE, star_camera_count=NONE, magnetometer_count=NONE, &
                                             orbit_count=NONE, observations=copy, error=failure)
        call check_refused(error, BAD_VALUE, 'accelerometer: fewer than two samples')
        call free(knowledge, observations)
    end subroutine test_arrays

    subroutine test_files(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: there(12), again(12)
        integer(c_intptr_t) :: observations, copy, knowledge

        call simulate('back-3', 1, 1, observations)
        call check_ok(error, gracecg_observations_write(observations, c_string(FOLDER//'c-interface'), failure))
        call check_ok(error, gracecg_observations_open(c_string(FOLDER//'c-interface'), copy, failure))
        call estimate('assest-rde', observations, there)
        call estimate('assest-rde', copy, again)
        call check_equal(error, again, there, 'estimate from files')
        call check_ok(error, gracecg_setup_open(c_string(FOLDER//'c-interface/setup.nml'), knowledge, failure))
        call free(knowledge, copy, observations)
        status = gracecg_observations_open(c_string(''), copy, failure)
        call check_refused(error, HAS_FAILED, 'name of the folder is empty')
        status = gracecg_observations_open(c_string(FOLDER//'nowhere'), copy, failure)
        call check_refused(error, HAS_FAILED, 'no such folder')
        status = gracecg_setup_open(c_string(FOLDER//'nowhere/setup.nml'), knowledge, failure)
        call check_refused(error, HAS_FAILED, 'no such file')
    end subroutine test_files

    !> Options travel with the objects, can be told and replaced; the object itself keeps its own.
    subroutine test_options(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: GAIN_TOO = '&optimal estimate_rod_gain = .true. /'
        integer(c_intptr_t) :: observations, changed, knowledge, from_folder, case, fit
        integer(c_size_t) :: before, after

        call simulate('front-3', 1, 1, observations)
        call check_ok(error)
        call check_text(observations, 'guess_quaternion = -0.7', .true.)
        call check_text(observations, 'estimate_rod_gain = .false.', .true.)
        status = gracecg_estimate(c_string('optimal'), observations, fit, failure)
        status = gracecg_get(fit, c_string('parameter_value'), NONE, count=before)
        status = gracecg_free(fit)
        call check_ok(error, gracecg_options_replace(observations, c_string(GAIN_TOO), changed, failure))
        call check_text(changed, 'estimate_rod_gain = .true.', .true.)
        call check_text(changed, 'guess_quaternion = -0.7', .false.)
        call check_text(observations, 'estimate_rod_gain = .false.', .true.)
        call check_ok(error, gracecg_estimate(c_string('optimal'), changed, fit, failure))
        status = gracecg_get(fit, c_string('parameter_value'), NONE, count=after)
        status = gracecg_free(fit)
        call check(error, after == before + 1, 'the gain is estimated')
        ! by way of a folder, a setup and a case
        status = gracecg_observations_write(changed, c_string(FOLDER//'c-options'), failure)
        call check_ok(error, gracecg_observations_open(c_string(FOLDER//'c-options'), from_folder, failure))
        call check_text(from_folder, 'estimate_rod_gain = .true.', .true.)
        status = gracecg_setup_from(changed, NONE, setup=knowledge, error=failure)
        call check_text(knowledge, 'estimate_rod_gain = .true.', .true.)
        call free(from_folder, changed, observations)
        status = gracecg_options_replace(knowledge, c_string('&estimation /'), changed, failure)
        call check_text(changed, 'estimate_rod_gain = .false.', .true.)
        call free(changed, knowledge)
        status = gracecg_case_open(c_string('back-1'), case, failure)
        status = gracecg_options_replace(case, c_string(GAIN_TOO), changed, failure)
        call check_text(changed, 'estimate_rod_gain = .true.', .true.)
        status = gracecg_free(changed)

        status = gracecg_options_replace(case, c_string('&optimal sigma_rod_gain = 1 /'), changed, failure)
        call check_refused(error, HAS_FAILED, '"sigma_rod_gain" is not known')
        call check_refused(error, NULL_POINTER, 'changed', gracecg_options_replace(case, error=failure))
        status = gracecg_free(case)
        status = gracecg_options_replace(case, c_string('&estimation /'), changed, failure)
        call check_refused(error, BAD_HANDLE, 'gracecg object')
        status = gracecg_gravity_open(c_string('point-mass'), 0, 0, case)
        status = gracecg_options_replace(case, c_string('&estimation /'), changed, failure)
        call check_refused(error, BAD_HANDLE, 'observation set')
        status = gracecg_setup_from(case, NONE, setup=changed, error=failure)
        call check_refused(error, BAD_HANDLE, 'observation set')
        status = gracecg_get_text(case, c_string('options'), size=NONE, length=before, error=failure)
        call check_refused(error, HAS_FAILED, 'has none')
        status = gracecg_free(case)

    contains

        subroutine check_text(object, part, there)
            integer(c_intptr_t), intent(in) :: object
            character(*), intent(in) :: part
            logical, intent(in) :: there
            character(:), allocatable :: text

            call get_words(object, 'options', text)
            call check(error, (index(text, part) > 0) .eqv. there, part)
        end subroutine check_text
    end subroutine test_options

    !> What `optimal` and `sequential` say beside the offset.
    subroutine test_details(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: set
        type(solution_t) :: expected
        type(fit_record_t) :: record
        type(fit_diagnostics_t) :: tests
        type(verdict_t) :: verdict
        type(error_t), allocatable :: problem
        character(:), allocatable :: names
        integer(c_intptr_t) :: observations, fit
        integer(c_size_t) :: n
        character(10), parameter :: NAMES_OF(3) = [character(10) :: 'optimal', 'sequential', 'ascfest']
        integer :: i, j, k

        set = simulated_set('front-3', 1, 1)
        call simulate('front-3', 1, 1, observations)
        call check_ok(error)
        do i = 1, size(NAMES_OF)
            call estimate_offset(trim(NAMES_OF(i)), set, report_options('front-3'), expected, problem, record)
            call check_ok(error, gracecg_estimate(c_string(trim(NAMES_OF(i))), observations, fit, failure))
            call check_equal(error, [item(fit, 'offset', 3), item(fit, 'sigma', 3)], &
                             [expected%offset, [(sqrt(expected%covariance(k, k)), k=1, 3)]], trim(NAMES_OF(i)))
            k = size(record%epoch)
            call check_equal(error, [item(fit, 'residual', 3*k), item(fit, 'angular_acceleration', 3*k)], &
                             [record%residual, record%angular_acceleration], 'series')
            call check_equal(error, item(fit, 'partials', 9*k), [([transpose(record%partials(:, :, j))], j=1, k)], 'partials')
            call check_equal(error, item(fit, 'fitted_covariance', size(record%covariance)), [record%covariance], 'covariance')
            call check_equal(error, item(fit, 'state_covariance', 225), [expected%state_covariance], 'covariance of the state')
            call diagnose(set%knowledge, expected, record, tests, problem)
            call check_equal(error, [item(fit, 'test_ratio', 3), item(fit, 'test_direction', 9), &
                                     item(fit, 'test_torque_factor', 1)], &
                             [tests%residuals%ratio, [tests%ellipsoid%direction], record%torque_factor], 'tests')
            verdict = judge(set%knowledge, expected, record, tests)
            call check_equal(error, [item(fit, 'action_kind', 1), item(fit, 'action_trim', 3), item(fit, 'action_again', 3)], &
                             [real(verdict%action%kind, dp), merge(1.0_dp, 0.0_dp, [verdict%action%trimmed, &
                                                                                   verdict%action%again])], 'action')
            call check_equal(error, item(fit, 'belief_undetected', 3), expected%beliefs%undetected(.false.), 'beliefs')
            if (i == 3 .or. allocated(error)) exit
            call check_equal(error, [item(fit, 'variance_factor', 1), item(fit, 'noise_level', 3), &
                                     item(fit, 'noise_corner', 3), item(fit, 'star_camera_sigma', 3)], &
                             [expected%variance_factor, expected%noise_level, expected%noise_corner, &
                              expected%star_camera_sigma], 'variance factor and noise')
            k = size(expected%parameters)
            call check_equal(error, [item(fit, 'parameter_value', k), item(fit, 'parameter_sigma', k)], &
                             [expected%parameters%value, expected%parameters%sigma], 'parameters')
            call get_words(fit, 'parameter_names', names)
            call check(error, index(names, 'torque_x'//new_line('a')), 1, names)
            if (i == 2) call check_equal(error, item(fit, 'running_offset', size(expected%running%offset)), &
                                         [expected%running%offset], 'running')
            status = gracecg_free(fit)
        end do
        status = gracecg_get(fit, c_string('parameter_value'), NONE, count=n)
        call check(error, n == 0 .and. abs(sum(item(fit, 'variance_factor', 1))) <= 0, &
                   'ascfest has no such parameters')
        call check_equal(error, item(fit, ' sigma  offset condition', 7), &
                         [item(fit, 'sigma', 3), item(fit, 'offset', 3), item(fit, 'condition', 1)], 'several items')
        status = gracecg_get(fit, c_string('sigma ofset'), 6_c_size_t, count=n, error=failure)
        call check_refused(error, HAS_FAILED, 'no item "ofset"; did you mean "offset"')
        status = gracecg_get(fit, c_string(''), 6_c_size_t, count=n, error=failure)
        call check_refused(error, HAS_FAILED, 'no item ""')
        status = gracecg_get(fit, c_string('offset warnings'), 6_c_size_t, count=n, error=failure)
        call check_refused(error, BAD_VALUE, '"warnings" is a text')
        status = gracecg_get(fit, c_string('ofset'), 3_c_size_t, count=n, error=failure)
        call check_refused(error, HAS_FAILED, 'did you mean "offset"')
        status = gracecg_get(fit, c_string('offset'), 2_c_size_t, tests%sigma, error=failure)
        call check_refused(error, BAD_SIZE, 'there are 3')
        call check_refused(error, BAD_VALUE, 'a text', gracecg_get(fit, c_string('warnings'), NONE, count=n, error=failure))
        status = gracecg_get_text(fit, c_string('offset'), size=NONE, length=n, error=failure)
        call check_refused(error, BAD_VALUE, 'numbers')
        call check_refused(error, NULL_POINTER, 'values', gracecg_get(fit, c_string('offset'), NONE, error=failure))
        call free(fit, observations)
    end subroutine test_details

    !> A NaN in any array of samples.
    subroutine test_bad_samples(error)
        type(error_type), allocatable, intent(out) :: error
        type(samples_t) :: samples
        integer(c_intptr_t) :: observations, copy, knowledge

        call simulate('front-1', 1, 1, observations)
        call check_ok(error)
        call take_samples(observations, samples)
        status = gracecg_setup_from(observations, NONE, setup=knowledge, error=failure)
        call spoil(samples%ta(7), 'number 7 of accelerometer_time')
        call spoil(samples%a(1799), 'number 1799 of acceleration')
        call spoil(samples%ts(3), 'star_camera_time')
        call spoil(samples%q(4), 'quaternion')
        call spoil(samples%tm(60), 'magnetometer_time')
        call spoil(samples%b(1), 'flux_density')
        call spoil(samples%to(1), 'orbit_time')
        call spoil(samples%x(183), 'orbit_position')
        samples%head(5) = 3
        call create(knowledge, samples, copy)
        call check_refused(error, BAD_VALUE, 'head that does not exist')
        status = gracecg_observations_create(knowledge, 100000000_c_size_t, samples%ta, samples%a, NONE, &
                                             magnetometer_count=NONE, orbit_count=NONE, observations=copy, error=failure)
        call check_refused(error, BAD_SIZE, 'accelerometer_count')
        status = gracecg_observations_create(knowledge, NONE, star_camera_count=-ONE, magnetometer_count=NONE, &
                                             orbit_count=NONE, observations=copy, error=failure)
        call check_refused(error, BAD_SIZE, 'star_camera_count')
        status = gracecg_observations_create(knowledge, NONE, star_camera_count=NONE, magnetometer_count=NONE, &
                                             orbit_count=ONE, observations=copy, error=failure)
        call check_refused(error, NULL_POINTER, 'orbit_time')
        call free(knowledge, observations)

    contains

        subroutine spoil(number, part)
            real(dp), intent(inout) :: number
            character(*), intent(in) :: part
            real(dp) :: kept

            kept = number
            number = NAN
            call create(knowledge, samples, copy)
            call check_refused(error, BAD_VALUE, part)
            number = kept
        end subroutine spoil
    end subroutine test_bad_samples

    !> The estimate from a hopeless initial guess does not pass for a good there.
    subroutine test_not_converged(error)
        type(error_type), allocatable, intent(out) :: error
        integer(c_intptr_t) :: observations, hopeless, fit

        call simulate('front-1', 1, 1, observations)
        call check_ok(error)
        status = gracecg_options_replace(observations, &
                                         c_string('&estimation guess_angular_velocity = 0.9, -0.9, 0.9 /'), hopeless, failure)
        call check_ok(error)
        status = gracecg_estimate(c_string('assest-fde'), hopeless, fit, failure)
        call check_refused(error, NOT_CONVERGED, 'did not converge')
        call check(error, fit /= 0 .and. nint(sum(item(fit, 'converged', 1))) == 0, 'a fit that did not converge')
        call free(fit, hopeless, observations)
    end subroutine test_not_converged

    !> A fit that the action forbids is made, and its status says so; one whose tests the options leave out is no such fit.
    subroutine test_not_usable(error)
        type(error_type), allocatable, intent(out) :: error
        type(samples_t) :: samples
        character(:), allocatable :: action
        real(dp) :: number(1)
        integer(c_intptr_t) :: observations, setup, halved, untested, fit

        call simulate('front-3', 1, 1, observations)
        call check_ok(error)
        call take_samples(observations, samples)
        samples%b = samples%b/2
        status = gracecg_setup_from(observations, NONE, setup=setup, error=failure)
        call create(setup, samples, halved)
        call check_ok(error)
        status = gracecg_estimate(c_string('assest-fde'), halved, fit, failure)
        call check_refused(error, NOT_USABLE, 'do not use: the data contradict what the setup says')
        call check(error, fit /= 0 .and. nint(sum(item(fit, 'action_kind', 1))) == 4, 'a fit that is not to be used')
        call free(fit, halved, setup)
        status = gracecg_options_replace(observations, c_string('&estimation test_beliefs = .false. /'), untested, failure)
        call check_ok(error, gracecg_estimate(c_string('assest-fde'), untested, fit, failure))
        call get_words(fit, 'action', action)
        call check(error, nint(sum(item(fit, 'action_kind', 1))) == 5 .and. index(action, 'not tested: the options') == 1, action)
        call check_refused(error, HAS_FAILED, 'the options leave out the tests', &
                           gracecg_get(fit, c_string('belief_tested'), ONE, number, error=failure))
        call free(fit, untested, observations)
    end subroutine test_not_usable
end module test_c_estimates
