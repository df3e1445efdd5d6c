!> Step 5 of CSR-TM-00-01 section 5.1, which the report did not simulate: adjust the CG offset by the
!> estimate, and calibrate again until the estimate is small.
!>
!> A round uses all earlier ones: what they say of the offset, less what was moved, with the error of moving it,
!> is what is known before the new calibration, and both are joined by their covariances. The masses are moved along the axes
!> that the action on such an estimate names, and no others.
!>
!> Moving masses changes d, and with it the inertia about the centre of mass, (2-18). It changes J_p,
!> the inertia about the proof-mass centre, too; that is left out: J_p is kept.
module gracecg_studies_trim
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_text, only: integer_text
    use gracecg_base_progress, only: progress_t, expect_pieces, piece_done
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_action, only: action_t, known_offset_t, decide, DO_NOT_USE
    use gracecg_estimation_iteration, only: rms_of
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_estimators, only: estimate_offset
    use gracecg_estimation_verdict, only: act_on
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, observe
    implicit none
    private
    public :: trim_settings_t, trim_round_t, trim_offset, trim_threshold, SIGMAS_OF_THRESHOLD
    public :: trim_statistics_t, repeat_trim

    real(dp), parameter :: SIGMAS_OF_THRESHOLD = 3
    !! Normal errors of three components stay below it together in 99 % of calibrations
    integer, parameter :: STREAM_BALANCE = 7        !! Random numbers of the mass balancing of one round

    !> When a trim ends, and how well the masses are moved.
    type :: trim_settings_t
        real(dp) :: threshold = 0.02e-3_dp      !! The trim ends when every |estimate| is below it, m
        logical :: by_sigma = .false.
        !! The threshold of an axis is instead SIGMAS_OF_THRESHOLD times the sigma of its latest estimate that its action rests on
        integer :: rounds = 10                  !! At most
        real(dp) :: balance_error = 0.01_dp     !! Relative, of the mass balancing of an axis
        real(dp) :: balance_noise = 0           !! Absolute, m
        logical :: joint = .true.               !! Earlier rounds count, too; else each alone
        integer(i8) :: seed = 1                     !! Of the random numbers; the run is the round
    end type trim_settings_t

    !> One calibration of the trim; body axes, m.
    type :: trim_round_t
        real(dp) :: offset(3)       !! True d
        real(dp) :: estimate(3)     !! Of d, from all rounds so far
        real(dp) :: sigma(3)        !! Of the estimate, under the noise of accelerometer and star camera
        real(dp) :: covariance(3, 3)    !! The same, m^2
        real(dp) :: wanted(3) = 0       !! By which the masses are to be moved
        type(action_t) :: action        !! Why so
    end type trim_round_t

    !> One round of many trims; RMS over the runs, body axes, m.
    type :: trim_statistics_t
        real(dp) :: offset(3) = 0           !! Of the true d
        real(dp) :: estimate_error(3) = 0   !! Of estimate minus true d
        real(dp) :: sigma(3) = 0            !! That the estimator states
    end type trim_statistics_t

    !> Many trims as pieces of work.
    type, extends(parallel_work_t) :: trims_t
        type(simulator_t) :: first                          !! Of the first round, before any mass is moved
        character(:), allocatable :: algorithm
        type(estimation_options_t) :: options
        type(trim_settings_t) :: settings
        type(trim_round_t), allocatable :: results(:, :)    !! (round, run)
    contains
        procedure :: do_one => do_trim
    end type trims_t

contains

    !> Trims a case many times, with the seeds from settings%seed on, settings%rounds rounds each
    !> whatever the threshold, on `threads` threads.
    !>
    !> Fails when a trim fails: the error is that of the failed run with the lowest number.
    subroutine repeat_trim(case, algorithm, options, settings, runs, threads, statistics, error, progress)
        type(case_t), intent(in) :: case
        character(*), intent(in) :: algorithm    !! One of ESTIMATOR_NAMES
        type(estimation_options_t), intent(in) :: options
        type(trim_settings_t), intent(in) :: settings
        integer, intent(in) :: runs, threads    !! Number of runs, and how many in parallel
        type(trim_statistics_t), intent(out) :: statistics(:)   !! (settings%rounds)
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the trims

        type(trims_t) :: work
        integer :: i, axis

        work%algorithm = algorithm
        work%options = options
        work%options%test_beliefs = .false.     ! their verdicts are not in these statistics
        work%settings = settings
        work%settings%threshold = 0
        work%settings%by_sigma = .false.
        allocate (work%results(settings%rounds, runs))
        call new_simulator(case, work%first, error)
        if (allocated(error)) return
        call run_parallel(work, runs, threads, error, progress)
        if (allocated(error)) return
        do i = 1, settings%rounds
            do axis = 1, 3
                associate (results => work%results(i, :))
                    statistics(i)%offset(axis) = rms_of(results%offset(axis))
                    statistics(i)%estimate_error(axis) = rms_of(results%estimate(axis) - results%offset(axis))
                    statistics(i)%sigma(axis) = rms_of(results%sigma(axis))
                end associate
            end do
        end do
    end subroutine repeat_trim

    subroutine do_trim(self, i, error)
        class(trims_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(trim_settings_t) :: own
        type(trim_round_t), allocatable :: rounds(:)

        own = self%settings
        own%seed = own%seed + i - 1
        call trim_from(self%first, self%algorithm, self%options, own, rounds, error)
        call add_context(error, 'run '//integer_text(i))
        if (.not. allocated(error)) self%results(:, i) = rounds
    end subroutine do_trim

    !> Calibrates and trims a case. The last round is the one whose estimate is known well enough and lies below the threshold,
    !> or is not to be used, or the last one allowed.
    !>
    !> Fails when the simulation or an estimate fails, or an estimate does not converge.
    subroutine trim_offset(case, algorithm, options, settings, rounds, error, progress)
        type(case_t), intent(in) :: case
        character(*), intent(in) :: algorithm   !! One of ESTIMATOR_NAMES
        type(estimation_options_t), intent(in) :: options
        type(trim_settings_t), intent(in) :: settings
        type(trim_round_t), allocatable, intent(out) :: rounds(:)
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the rounds, of all that are allowed

        type(simulator_t) :: first

        allocate (rounds(0))
        call new_simulator(case, first, error)
        call add_context(error, 'round 1')
        if (.not. allocated(error)) call trim_from(first, algorithm, options, settings, rounds, error, progress)
    end subroutine trim_offset

    !> The same from the simulation of the first round on.
    subroutine trim_from(first, algorithm, options, settings, rounds, error, progress)
        type(simulator_t), intent(in) :: first
        character(*), intent(in) :: algorithm
        type(estimation_options_t), intent(in) :: options
        type(trim_settings_t), intent(in) :: settings
        type(trim_round_t), allocatable, intent(out) :: rounds(:)
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(simulator_t) :: simulator
        type(case_t) :: current
        type(trim_round_t) :: latest
        type(solution_t) :: solution
        integer :: i

        allocate (rounds(0))
        current = first%case
        simulator = first
        call expect_pieces(progress, settings%rounds, 'rounds')
        do i = 1, settings%rounds
            if (i > 1) call new_simulator(current, simulator, error)
            if (.not. allocated(error)) call calibrate(simulator, algorithm, options, settings%seed, i, latest, solution, error)
            call add_context(error, 'round '//integer_text(i))
            if (settings%joint .and. i > 1 .and. .not. allocated(error)) call join_earlier(rounds(i - 1), settings, latest, error)
            if (allocated(error)) return
            call take_action(solution, current%satellite%mass, latest)
            rounds = [rounds, latest]
            call piece_done(progress)
            if (latest%action%kind == DO_NOT_USE) return
            if (all(abs(latest%estimate) < trim_threshold(settings, latest) .and. .not. latest%action%again)) return
            current%satellite%offset = current%satellite%offset - mass_balance(current, settings, i, latest%wanted)
        end do
    end subroutine trim_from

    !> What the joined estimate of a round allows, by the tests of its solution where there are some. Moves of the masses show
    !> the signs of the accelerometer.
    subroutine take_action(solution, mass, latest)
        type(solution_t), intent(inout) :: solution
        real(dp), intent(in) :: mass            !! Of the satellite, kg
        type(trim_round_t), intent(inout) :: latest

        if (allocated(solution%beliefs)) then
            solution%offset = latest%estimate
            solution%covariance = latest%covariance
            solution%beliefs%signs_known = .true.
            call act_on(solution, mass, latest%action)
        else
            call decide(known_offset_t(latest%estimate, latest%sigma, signs_known=.true.), mass, latest%action)
        end if
        latest%wanted = merge(latest%estimate, 0*latest%estimate, latest%action%trimmed)
    end subroutine take_action

    !> Below what the estimates of a round must be, each axis, m.
    pure function trim_threshold(settings, latest) result(threshold)
        type(trim_settings_t), intent(in) :: settings
        type(trim_round_t), intent(in) :: latest
        real(dp) :: threshold(3)

        threshold = settings%threshold
        if (settings%by_sigma) threshold = SIGMAS_OF_THRESHOLD*max(latest%sigma, latest%action%sigma)
    end function trim_threshold

    subroutine calibrate(simulator, algorithm, options, seed, run, latest, solution, error)
        type(simulator_t), intent(in) :: simulator
        character(*), intent(in) :: algorithm
        type(estimation_options_t), intent(in) :: options
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: run
        type(trim_round_t), intent(out) :: latest
        type(solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        integer :: i

        call observe(simulator, seed, run, observations, error, only_used_head=.true.)
        if (allocated(error)) return
        call estimate_offset(algorithm, observations, options, solution, error)
        if (allocated(error)) return
        if (.not. solution%converged) then
            call fail(error, algorithm//' did not converge: there is no estimate to trim by')
            return
        end if
        latest%offset = simulator%case%satellite%offset
        latest%estimate = solution%offset
        latest%covariance = solution%covariance
        latest%sigma = [(sqrt(solution%covariance(i, i)), i=1, 3)]
    end subroutine calibrate

    !> Joins a round with what is known before it: what was estimated less what was moved is expected, with the covariance of
    !> that estimate and of the movement. With P of what is expected and R of the round alone, P (P + R)^-1 of how far the
    !> round's estimate is from it remains, with the covariance P (P + R)^-1 R. To a round without noise earlier ones add nothing.
    subroutine join_earlier(before, settings, latest, error)
        type(trim_round_t), intent(in) :: before
        type(trim_settings_t), intent(in) :: settings
        type(trim_round_t), intent(inout) :: latest
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: expected(3, 3), inverse(3, 3), gain(3, 3), unused(3), condition
        integer :: i

        if (.not. any(latest%sigma > 0)) return
        expected = before%covariance
        do i = 1, 3
            expected(i, i) = expected(i, i) + (settings%balance_error*before%wanted(i))**2 + settings%balance_noise**2
        end do
        call solve_normal_equations(expected + latest%covariance, [0.0_dp, 0.0_dp, 0.0_dp], unused, inverse, condition, error)
        if (allocated(error)) return
        gain = matmul(expected, inverse)
        associate (left => before%estimate - before%wanted)
            latest%estimate = left + matmul(gain, latest%estimate - left)
        end associate
        latest%covariance = matmul(gain, latest%covariance)
        latest%covariance = (latest%covariance + transpose(latest%covariance))/2
        latest%sigma = [(sqrt(latest%covariance(i, i)), i=1, 3)]
    end subroutine join_earlier

    !> What the mass balancing makes of a wanted change of d.
    function mass_balance(case, settings, round, wanted) result(done)
        type(case_t), intent(in) :: case
        type(trim_settings_t), intent(in) :: settings
        integer, intent(in) :: round
        real(dp), intent(in) :: wanted(3)       !! m
        real(dp) :: done(3)                     !! m

        type(random_stream_t) :: stream
        real(dp) :: relative(3), absolute(3)

        stream = new_stream(settings%seed, case%label(), case%satellite%place(), round, STREAM_BALANCE)
        call stream%normals(relative)
        call stream%normals(absolute)
        done = wanted*(1 + settings%balance_error*relative) + settings%balance_noise*absolute
    end function mass_balance
end module gracecg_studies_trim
