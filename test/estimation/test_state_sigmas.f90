!> What every estimator delivers: attitude, angular velocity, drift and bias with their standard deviations,
!> against the scatter of many calibrations; and the history of the iterations.
module test_state_sigmas
    use vocabulary
    use calibrations
    use gracecg_base_quaternion, only: normalised, rotation_matrix
    use gracecg_base_text, only: real_text
    use gracecg_estimation_solution, only: solution_t, state_sigmas, quaternion_sigmas, STATE, STATE_NAMES, STATE_OFFSET, &
        STATE_RATE, STATE_ATTITUDE, STATE_DRIFT, STATE_BIAS
    use gracecg_simulation_simulator, only: error_switches_t, new_switched_simulator, switch_off
    implicit none
    private
    public :: collect_state_sigmas

    integer, parameter :: RUNS = 30
    !> 99.99 % limits of sqrt(chi^2/29) for the scatter of 30 runs, from tables of chi^2: 9.2 and 65.5 of 29
    !> degrees of freedom; and 10 % for what the estimators' covariances leave out
    real(dp), parameter :: LEAST = 0.9_dp*0.563_dp, MOST = 1.1_dp*1.503_dp

contains

    subroutine collect_state_sigmas(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('sigmas-against-scatter', test_scatter), &
                    new_unittest('covariance-of-the-state', test_covariance), &
                    new_unittest('history', test_history)]
    end subroutine collect_state_sigmas

    !> A case of the report without what is systematic: the wave of the density, errors of the magnetometer.
    subroutine simulate(simulator, options)
        type(simulator_t), intent(out) :: simulator
        type(estimation_options_t), intent(out) :: options
        type(calibration_t) :: calibration
        type(error_switches_t) :: switches
        type(error_t), allocatable :: failure

        call take_calibration('front-3', calibration)
        call switch_off(switches, 'systematic', failure)
        if (.not. allocated(failure)) call switch_off(switches, 'magnetometer-noise', failure)
        if (.not. allocated(failure)) call new_switched_simulator(calibration%case, switches, simulator, failure)
        call need(failure)
        options = calibration%options
        options%optimal%estimate_within_limits = .false.        ! only noise is drawn
        options%sequential%estimate_within_limits = .false.
    end subroutine simulate

    subroutine test_scatter(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        real(dp) :: found(STATE, RUNS), sigma(STATE), mean(STATE), ratio, quaternion(4), q_found(4, RUNS), q_sigma(4)
        integer :: a, run, i

        call simulate(simulator, options)
        do a = 1, size(ESTIMATOR_NAMES)
            sigma = 0
            q_sigma = 0
            do run = 1, RUNS
                call make_observations(simulator, 3, run, observations)
                if (estimate_fails(error, ESTIMATOR_NAMES(a), observations, options, solution)) return
                if (run == 1) quaternion = solution%quaternion
                found(STATE_OFFSET, run) = solution%offset
                found(STATE_DRIFT, run) = solution%drift
                found(STATE_BIAS, run) = solution%bias
                found(STATE_RATE, run) = solution%angular_velocity
                found(STATE_ATTITUDE, run) = angles_between(solution%quaternion, quaternion)
                q_found(:, run) = solution%quaternion*sign(1.0_dp, dot_product(solution%quaternion, quaternion))
                sigma = sigma + state_sigmas(solution)**2/RUNS
                q_sigma = q_sigma + quaternion_sigmas(solution)**2/RUNS
            end do
            mean = sum(found, 2)/RUNS
            do i = 1, STATE
                ratio = sqrt(sum((found(i, :) - mean(i))**2)/(RUNS - 1)/sigma(i))
                call check(error, ratio > LEAST .and. ratio < MOST, trim(ESTIMATOR_NAMES(a))//': the scatter of '// &
                           trim(STATE_NAMES(i))//' is '//real_text(ratio)//' of its sigma')
            end do
            do i = 1, 4
                ratio = sqrt(sum((q_found(i, :) - sum(q_found(i, :))/RUNS)**2)/(RUNS - 1)/q_sigma(i))
                call check(error, ratio > LEAST .and. ratio < MOST, trim(ESTIMATOR_NAMES(a))//': the scatter of q is '// &
                           real_text(ratio)//' of its sigma')
            end do
        end do
    end subroutine test_scatter

    !> Small angles about the body axes that turn one attitude into the other.
    pure function angles_between(q, reference) result(angles)
        real(dp), intent(in) :: q(4), reference(4)
        real(dp) :: angles(3)       ! rad

        real(dp) :: c(3, 3)

        c = matmul(rotation_matrix(normalised(q)), transpose(rotation_matrix(normalised(reference))))
        angles = [c(2, 3) - c(3, 2), c(3, 1) - c(1, 3), c(1, 2) - c(2, 1)]/2
    end function angles_between

    !> Its first block is the covariance of the offset; it is symmetric, and no correlation exceeds 1.
    subroutine test_covariance(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        real(dp) :: sigma(STATE)
        integer :: a, i, k

        call simulate(simulator, options)
        call make_observations(simulator, 3, 1, observations)
        do a = 1, size(ESTIMATOR_NAMES)
            if (estimate_fails(error, ESTIMATOR_NAMES(a), observations, options, solution)) return
            sigma = state_sigmas(solution)
            associate (p => solution%state_covariance)
                call check(error, all(abs(p(:3, :3) - solution%covariance) <= 1e-12_dp*maxval(solution%covariance)) .and. &
                           all(sigma > 0), ESTIMATOR_NAMES(a))
                do i = 1, STATE
                    do k = 1, i - 1
                        call check(error, abs(p(i, k) - p(k, i)) <= 1e-9_dp*sigma(i)*sigma(k) .and. &
                                   abs(p(i, k)) < sigma(i)*sigma(k), trim(ESTIMATOR_NAMES(a))//': '// &
                                   trim(STATE_NAMES(i))//' and '//trim(STATE_NAMES(k)))
                    end do
                end do
            end associate
        end do
    end subroutine test_covariance

    !> Nothing is kept unless it is asked for; what is kept changes nothing, is as long as the iterations, and ends
    !> with the estimate.
    subroutine test_history(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(solution_t) :: solution, again
        type(error_t), allocatable :: failure
        integer :: a, i, last, place

        call simulate(simulator, options)
        call make_observations(simulator, 3, 1, observations)
        do a = 1, size(ESTIMATOR_NAMES)
            options%history = .false.
            call estimate_offset(ESTIMATOR_NAMES(a), observations, options, solution, failure)
            options%history = .true.
            if (estimate_fails(error, ESTIMATOR_NAMES(a), observations, options, again)) return
            if (unmet(error, .not. allocated(solution%history) .and. all(abs(solution%offset - again%offset) <= 0))) return
            last = size(again%history)
            call check(error, last >= 2 .and. again%history(1)%number == 1, ESTIMATOR_NAMES(a))
            do i = 1, last
                associate (it => again%history(i))
                    if (unmet(error, size(it%names) == size(it%correction) .and. &
                              size(it%state_names) == size(it%state) .and. &
                              size(it%residual_names) == size(it%residual_rms) .and. all(it%residual_rms > 0), &
                              ESTIMATOR_NAMES(a))) return
                end associate
            end do
            associate (it => again%history(last))
                do i = 1, 3
                    place = findloc(it%state_names, STATE_NAMES(STATE_OFFSET(i)), 1)
                    call check(error, place > 0, ESTIMATOR_NAMES(a))
                    call check(error, it%state(place), again%offset(i), thr=1e-7_dp, rel=.false.)
                end do
            end associate
        end do
    end subroutine test_history
end module test_state_sigmas
