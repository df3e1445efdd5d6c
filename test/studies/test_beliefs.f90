!> The tests of the operator's beliefs: their partials against altered observations, their scores against what chance
!> makes of them, and what they say of beliefs that are wrong.
module test_beliefs_of_operator
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, message_of
    use gracecg_base_text, only: integer_text
    use gracecg_base_statistics, only: normal_quantile
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, observe, observe_without_noise
    use gracecg_simulation_dynamics, only: OMEGA_PLACES => OMEGA, ATTITUDE_PLACES => ATTITUDE
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_estimation_estimators, only: estimate_offset
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_parameters
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, prepare_calibration, set_noise
    use gracecg_estimation_belief, only: BELIEFS, apply_value, ALTERATIONS, apply_alteration
    use gracecg_estimation_belief_report, only: belief_report_t, CONTRADICTED, FAMILY_LEVEL
    use fixture, only: check_passes
    use testdrive, only: new_unittest, unittest_type, error_type, check, test_failed
    implicit none
    private
    public :: collect_beliefs

contains

    subroutine collect_beliefs(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('normal-quantiles', test_quantiles), &
                    new_unittest('partials-are-those-of-altered-observations', test_partials), &
                    new_unittest('scores-are-standard-normal', test_scores)]
    end subroutine collect_beliefs

    !> Abramowitz and Stegun, Table 26.5, and the relation of both tails.
    subroutine test_quantiles(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, normal_quantile(0.975_dp), 1.959963985_dp, thr=1e-8_dp)
        if (.not. allocated(error)) call check(error, normal_quantile(0.9995_dp), 3.290526731_dp, thr=1e-8_dp)
        if (.not. allocated(error)) call check(error, normal_quantile(0.8_dp), 0.841621234_dp, thr=1e-8_dp)
        if (.not. allocated(error)) call check(error, normal_quantile(1e-9_dp), -5.997807015_dp, thr=1e-7_dp)
        if (.not. allocated(error)) call check(error, normal_quantile(0.5_dp), 0.0_dp, thr=1e-15_dp)
    end subroutine test_quantiles

    subroutine simulator_of(name, simulator, options, error)
        character(*), intent(in) :: name
        type(simulator_t), intent(out) :: simulator
        type(estimation_options_t), intent(out) :: options
        type(error_type), allocatable, intent(out) :: error

        type(calibration_t) :: calibration
        type(error_t), allocatable :: failure

        call find_calibration(name, calibration, failure)
        if (.not. allocated(failure)) call new_simulator(calibration%case, simulator, failure)
        call check_passes(error, message_of(failure))
        options = calibration%options
    end subroutine simulator_of

    !> What a belief's value would change in the whitened residuals, by its partials and by observations and knowledge
    !> that are changed by it.
    subroutine test_partials(error)
        type(error_type), allocatable, intent(out) :: error

        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations, other
        type(error_t), allocatable :: failure
        real(dp), allocatable :: partials(:, :), residuals(:), altered(:, :), changed(:)
        real(dp) :: step, deviation
        integer :: i

        call simulator_of('front-3', simulator, options, error)
        if (allocated(error)) return
        call observe_without_noise(simulator, density_wave_t(), observations)
        call whitened(observations, partials, residuals)
        if (.not. allocated(error)) then
            do i = 1, size(BELIEFS)
                if (BELIEFS(i)%parameter == DRAG_CURVATURE) cycle    ! no setting knows it
                step = size_of(BELIEFS(i)%parameter)
                other = observations
                call apply_value(BELIEFS(i)%parameter, step, other)
                call whitened(other, altered, changed)
                if (allocated(error)) return
                deviation = norm2((residuals - changed)/step - partials(i, :))
                if (deviation > 0.02_dp*norm2(partials(i, :))) then
                    call test_failed(error, trim(BELIEFS(i)%subject)//': partials off by '//text_of(deviation)//' of '// &
                                     text_of(norm2(partials(i, :)))//', product '// &
                                     text_of(dot_product((residuals - changed)/step, partials(i, :))))
                    print *, error%message
                    deallocate (error)
                end if
            end do
        end if

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
                call prepare_calibration(set%knowledge, options, data, BELIEFS%parameter, problem)
                problem%state%quaternion = simulator%arc%state(ATTITUDE_PLACES, 0)
                problem%state%value(RATE) = simulator%arc%state(OMEGA_PLACES, 0)
                problem%state%value(OFFSET) = simulator%case%satellite%offset
                call set_noise(problem, failure)
                allocate (rows(size(BELIEFS), problem%observations), left(problem%observations), &
                          weights(problem%observations))
            end if
            if (.not. allocated(failure)) call problem%linearise(rows, left, weights, failure)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            known = problem%star_rows + problem%acceleration_rows
            rows = rows(:, :known)
            left = left(:known)
        end subroutine whitened
    end subroutine test_partials

    !> A small value of a parameter.
    pure real(dp) function size_of(parameter)
        integer, intent(in) :: parameter

        select case (parameter)
        case (INERTIA(1):INERTIA(6))
            size_of = 0.1_dp
        case (TORQUE_CHANGE(1):TORQUE_CHANGE(3))
            size_of = 1e-6_dp
        case (FIELD_BIAS(1):FIELD_BIAS(3))
            size_of = 1e-8_dp
        case (ROD_FREQUENCIES(1):ROD_FREQUENCIES(3))
            size_of = 1e-6_dp
        case default
            size_of = 1e-3_dp
        end select
    end function size_of

    function text_of(value) result(text)
        real(dp), intent(in) :: value
        character(12) :: text

        write (text, '(es12.4)') value
    end function text_of

    !> Over runs, the scores of right beliefs have the mean square 1.
    subroutine test_scores(error)
        type(error_type), allocatable, intent(out) :: error

        character(8), parameter :: NAMES(6) = [character(8) :: 'front-1', 'front-2', 'front-3', 'back-1', 'back-2', 'back-3']
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        integer, parameter :: RUNS = 100
        integer :: run, i, found, k
        real(dp) :: square(49), noises(6), worst, effect(3), t0, t1, t2, ta, tb, nees

        do k = 1, 6
        call simulator_of(trim(NAMES(k)), simulator, options, error)
        if (allocated(error)) return
        square = 0; noises = 0; found = 0; effect = 0; ta = 0; tb = 0; nees = 0
        do run = 1, RUNS
            call observe(simulator, 4711, run, observations, failure)
            options%covariance = .false.
            call cpu_time(t0)
            call estimate_offset('optimal', observations, options, solution, failure)
            call cpu_time(t1)
            options%covariance = .true.
            call estimate_offset('optimal', observations, options, solution, failure)
            call cpu_time(t2)
            ta = ta + t1 - t0
            tb = tb + t2 - t1
            if (allocated(failure)) then
              print *, failure%message; cycle
            end if
            associate (b => solution%beliefs)
            if (b%has_contradiction()) found = found + 1
            do i = 1, size(b%values)
                square(b%values(i)%belief) = square(b%values(i)%belief) + b%values(i)%score**2/RUNS
            end do
            do i = 1, 6
                noises(i) = noises(i) + b%noises(i)%score**2/RUNS
            end do
            effect = effect + b%undetected()/RUNS
            end associate
        end do
        print '(a, 2f8.3, i6)', trim(NAMES(k)), ta, tb, found
        print '(12f6.2)', square
        print '(6f6.2, 3es12.3)', noises, effect
        end do
    end subroutine test_scores
end module test_beliefs_of_operator
