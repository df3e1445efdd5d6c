!> What the tests of the operator's beliefs are worth: simulated calibrations are spoiled by one wrong belief after
!> the other, and it is counted what an estimate says of it.
!>
!> Knowledge or samples are spoiled, the true arc and the noise stay. A result is silently wrong if a component of the
!> offset is off by more than five standard deviations and what the estimate says to be undetectable, while nothing is
!> contradicted.
module gracecg_studies_wrong_beliefs
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    use gracecg_base_statistics, only: normal_quantile
    use gracecg_base_text, only: rounded_text
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_observations_parameters
    use gracecg_estimation_belief, only: ALTERATIONS, apply_value, apply_alteration
    use gracecg_estimation_belief_report, only: belief_report_t, explanation_t, POWER, OF_VALUE, OF_ALTERATION, OF_NOISE, &
        NOISE_SUBJECTS, CONTRADICTED
    use gracecg_estimation_estimators, only: estimate_offset
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_explanation, only: confirm_contradictions
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_action, only: action_t
    use gracecg_estimation_verdict, only: act_on
    use gracecg_simulation_satellite, only: satellite_t
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, observe
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_planning_bound, only: reliability_of_case
    implicit none
    private
    public :: wrong_belief_t, tally_t, all_wrong_beliefs, try_wrong_beliefs, subject_of, size_text
    public :: SILENT_SIGMAS, FAR_BEYOND

    integer, parameter :: SOUND = 0     !! Kind of a belief beside OF_VALUE, OF_ALTERATION, OF_NOISE: nothing is wrong
    real(dp), parameter :: SILENT_SIGMAS = 5    !! Error, in standard deviations, beyond which a silent result is wrong
    real(dp), parameter :: HARMFUL = 4          !! Standard deviations of an error of a component along which masses are moved
    real(dp), parameter :: FAR_BEYOND = 2       !! Minimal detectable values, beyond which the tests shall not miss
    integer, parameter :: SIZES = 3             !! Of each belief with a value

    !> A belief that is wrong, and by how much.
    type :: wrong_belief_t
        integer :: kind = SOUND         !! SOUND, OF_VALUE, OF_ALTERATION or OF_NOISE
        integer :: place = 0            !! A parameter, or in ALTERATIONS, NOISE_SUBJECTS
        real(dp) :: value = 0           !! SI units; of a noise the level believed, standard deviation, by the true one
    end type wrong_belief_t

    !> What came of one wrong belief in the runs of a case.
    type :: tally_t
        character(10) :: algorithm = '' !! That estimated
        type(wrong_belief_t) :: wrong   !! What was made wrong
        integer :: runs = 0             !! How many
        integer :: refused = 0          !! Runs in which the estimate failed, or did not converge
        integer :: contradicted = 0     !! Runs with a contradiction, or refused
        integer :: found = 0            !! Runs in which the test of this very belief, with a value, contradicts it
        real(dp) :: stated = 0
        !! In how many runs of all it should, by the minimal detectable values that the estimates state themselves
        integer :: named = 0            !! Runs in which the cause is among the explanations given, also with a refusal
        integer :: silent = 0           !! Runs that are silently wrong
        integer :: trimmed = 0          !! Runs whose action is to trim along some axis
        integer :: harmful = 0          !! Of these, along one where the offset is wrong by more than HARMFUL sigma and what is
        !! tolerated unseen
        real(dp) :: times = 0           !! Value in minimal detectable values; 0: none is known
        real(dp) :: worst = 0           !! Largest error of a component, in standard deviations
    end type tally_t

    !> One run with one wrong belief.
    type :: outcome_t
        logical :: refused = .false., contradicted = .false., found = .false., named = .false., silent = .false.
        logical :: trimmed = .false., harmful = .false.
        real(dp) :: stated = 0      ! probability that the belief's own test contradicts it
        real(dp) :: worst = 0
    end type outcome_t

    !> All runs of a case, as pieces of work.
    type, extends(parallel_work_t) :: trials_t
        type(simulator_t), pointer :: simulator => null()
        character(10), allocatable :: algorithms(:)
        type(estimation_options_t) :: options
        integer(i8) :: seed = 1
        integer :: runs = 0
        logical :: explain = .true.
        type(wrong_belief_t), allocatable :: wrong(:)
        type(outcome_t), allocatable :: outcome(:, :)   !! (algorithm, runs of the first, of the second, ...)
    contains
        procedure :: do_one => try_one
    end type trials_t

contains

    !> The list: nothing wrong, each belief with a value at three sizes, all alterations, and noise levels.
    function all_wrong_beliefs() result(list)
        type(wrong_belief_t), allocatable :: list(:)

        real(dp), parameter :: LEVELS(3) = [0.1_dp, 0.3_dp, 10.0_dp]
        integer :: i, k

        list = [wrong_belief_t()]
        do i = 1, size(BELIEFS)
            if (any(INTERCHANGES == BELIEFS(i))) cycle     ! among the alterations
            list = [list, [(wrong_belief_t(OF_VALUE, BELIEFS(i), size_of(BELIEFS(i), k)*BELIEF_SIZE(BELIEFS(i))), k=1, SIZES)]]
        end do
        list = [list, [(wrong_belief_t(OF_ALTERATION, i, 1.0_dp), i=1, size(ALTERATIONS))]]
        do i = 1, 6
            list = [list, [(wrong_belief_t(OF_NOISE, i, LEVELS(k)), k=1, size(LEVELS))]]
        end do
    end function all_wrong_beliefs

    !> Sizes that are tried: small, middle, large, in the unit in which it is shown.
    pure real(dp) function size_of(parameter, k) result(wrong)
        integer, intent(in) :: parameter        !! Its place
        integer, intent(in) :: k                !! 1 to SIZES

        real(dp), parameter :: DELAYS(SIZES) = [0.05_dp, 0.2_dp, 0.8_dp]            ! s
        real(dp), parameter :: FREQUENCIES(SIZES) = [0.0005_dp, 0.002_dp, 0.01_dp]  ! Hz
        real(dp), parameter :: TURNS(SIZES) = [1.0_dp, 5.0_dp, 20.0_dp]             ! deg, kg m^2
        real(dp), parameter :: TORQUES(SIZES) = [5e-6_dp, 2e-5_dp, 1e-4_dp]         ! N m
        real(dp), parameter :: GAINS(SIZES) = [0.05_dp, 0.2_dp, 0.5_dp]

        select case (KIND_OF(parameter))
        case (ROD_DELAYS(1), ALL_RODS_DELAY, ACCELEROMETER_DELAYS(1), STAR_CAMERA_DELAY)
            wrong = DELAYS(k)
        case (ROD_FREQUENCIES(1), ALL_RODS_FREQUENCY)
            wrong = FREQUENCIES(k)
        case (ROD_TURNS(1), FIELD_TURN(1), ACCELEROMETER_TURN(1), INERTIA(1))
            wrong = TURNS(k)
        case (MOUNTING_1(1), MOUNTING_2(1))
            wrong = TURNS(k)/20
        case (TORQUE_CHANGE(1))
            wrong = TORQUES(k)
        case (FIELD_BIAS(1))
            wrong = 500*TURNS(k)
        case (FIELD_DELAY)
            wrong = 10*GAINS(k)
        case default
            wrong = GAINS(k)
        end select
    end function size_of

    !> Spoils `runs` simulated calibrations of a case by every wrong belief of a list, with either sign in turn.
    !> All algorithms estimate from the same observations. Fails when the case cannot be simulated, or its reliability
    !> is not determined; not when an estimate fails.
    subroutine try_wrong_beliefs(calibration, algorithms, explain, list, seed, runs, threads, tallies, error, progress)
        type(calibration_t), intent(in) :: calibration
        character(*), intent(in) :: algorithms(:)       !! Of ESTIMATOR_NAMES
        logical, intent(in) :: explain                  !! Whether causes are looked for: none is named else
        type(wrong_belief_t), intent(in) :: list(:)
        integer(i8), intent(in) :: seed                 !! Of the random numbers
        integer, intent(in) :: runs, threads            !! How many runs of each; in parallel
        type(tally_t), allocatable, intent(out) :: tallies(:)   !! In the order of the list, for each algorithm
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the estimates

        type(trials_t) :: work
        type(simulator_t), target :: simulator
        type(belief_report_t) :: report
        integer :: i, k, n

        call new_simulator(calibration%case, simulator, error)
        if (.not. allocated(error)) call reliability_of_case(calibration%case, calibration%options, report, error)
        if (allocated(error)) return
        work%simulator => simulator
        work%algorithms = algorithms
        work%options = calibration%options
        work%options%covariance = .true.
        work%explain = explain
        work%seed = seed
        work%runs = runs
        work%wrong = list
        allocate (work%outcome(size(algorithms), runs*size(list)))
        call expect_pieces(progress, size(work%outcome, 2), 'observation sets')
        call tell(progress, trim(calibration%case%name))
        call run_parallel(work, size(work%outcome, 2), threads, error, progress)
        call add_context(error, 'case '//trim(calibration%case%name))
        if (allocated(error)) return
        allocate (tallies(size(algorithms)*size(list)))
        do k = 1, size(algorithms)
            do i = 1, size(list)
                n = size(list)*(k - 1) + i
                associate (outcome => work%outcome(k, runs*(i - 1) + 1:runs*i), tally => tallies(n))
                    tally%algorithm = algorithms(k)
                    tally%wrong = list(i)
                    tally%runs = runs
                    tally%refused = count(outcome%refused)
                    tally%contradicted = count(outcome%contradicted)
                    tally%found = count(outcome%found)
                    tally%stated = sum(outcome%stated)
                    tally%named = count(outcome%named)
                    tally%silent = count(outcome%silent)
                    tally%trimmed = count(outcome%trimmed)
                    tally%harmful = count(outcome%harmful)
                    tally%worst = maxval(outcome%worst)
                    tally%times = times_detectable(report, list(i))
                end associate
            end do
        end do
    end subroutine try_wrong_beliefs

    !> The value of a wrong belief in minimal detectable values; 0: none is known.
    pure real(dp) function times_detectable(report, wrong) result(times)
        type(belief_report_t), intent(in) :: report
        type(wrong_belief_t), intent(in) :: wrong

        integer :: i

        times = 0
        i = test_of(wrong, report)
        if (i == 0) return
        if (report%values(i)%detectable > 0) times = abs(wrong%value)/report%values(i)%detectable
    end function times_detectable

    subroutine try_one(self, i, error)
        class(trials_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        type(solution_t) :: tested, solution
        type(error_t), allocatable :: tested_failure, failure
        type(estimation_options_t) :: untested
        integer :: run, k

        untested = self%options
        untested%test_beliefs = .false.
        run = modulo(i - 1, self%runs) + 1
        call observe(self%simulator, self%seed, run, observations, error)
        if (allocated(error)) return
        associate (wrong => self%wrong((i - 1)/self%runs + 1))
            call spoil(wrong, merge(1, -1, modulo(run, 2) == 1), observations)
            if (self%explain) then
                call estimate_offset('optimal', observations, self%options, tested, tested_failure)
            else
                call estimate_optimal(observations, self%options, tested, tested_failure)
                if (allocated(tested%beliefs)) &
                    call confirm_contradictions(observations, self%options, tested%misfit, tested%beliefs)
            end if
            do k = 1, size(self%algorithms)
                if (self%algorithms(k) == 'optimal') then
                    self%outcome(k, i) = outcome_of(wrong, self%simulator%case%satellite, tested, tested_failure)
                else
                    call estimate_offset(self%algorithms(k), observations, untested, solution, failure)
                    if (allocated(tested%beliefs)) then     ! as estimate_offset takes those of `optimal`
                        solution%beliefs = tested%beliefs
                        solution%beliefs%apart = abs(solution%offset - tested%offset)
                    end if
                    self%outcome(k, i) = outcome_of(wrong, self%simulator%case%satellite, solution, failure)
                end if
            end do
        end associate
    end subroutine try_one

    !> What an estimate says, and whether it is right.
    function outcome_of(wrong, truth, solution, failure) result(outcome)
        type(wrong_belief_t), intent(in) :: wrong
        type(satellite_t), intent(in) :: truth
        type(solution_t), intent(in) :: solution
        type(error_t), allocatable, intent(in) :: failure
        type(outcome_t) :: outcome

        type(action_t) :: action
        real(dp) :: deviation(3), sigma(3), score       ! which is expected of the belief's own test
        integer :: axis

        outcome%refused = allocated(failure)
        if (.not. allocated(failure)) outcome%refused = .not. solution%converged
        outcome%contradicted = outcome%refused
        if (allocated(solution%beliefs)) then
            associate (report => solution%beliefs, test => test_of(wrong, solution%beliefs))
                outcome%contradicted = outcome%contradicted .or. report%has_contradiction()
                if (test > 0) outcome%found = report%values(test)%state == CONTRADICTED
                score = times_detectable(report, wrong)*(report%critical + normal_quantile(POWER))
                if (score > 0) outcome%stated = report%power_at(score)
                outcome%named = is_named(wrong, report%explanations)
            end associate
        end if
        if (outcome%refused) return
        deviation = abs(solution%offset - truth%offset)
        sigma = [(sqrt(solution%covariance(axis, axis)), axis=1, 3)]
        outcome%worst = maxval(deviation/sigma)
        if (.not. allocated(solution%beliefs)) return
        associate (report => solution%beliefs)
            outcome%silent = .not. outcome%contradicted .and. any(deviation - report%undetected(.false.) > SILENT_SIGMAS*sigma)
            call act_on(solution, truth%mass, action)
            outcome%trimmed = any(action%trimmed)
            outcome%harmful = any(action%trimmed .and. deviation > HARMFUL*sqrt(sigma**2 + report%apart**2) + report%wanted)
        end associate
    end function outcome_of

    !> Makes a belief wrong.
    subroutine spoil(wrong, sign_of, observations)
        type(wrong_belief_t), intent(in) :: wrong
        integer, intent(in) :: sign_of              !! 1 or -1, of a value
        type(observation_set_t), intent(inout) :: observations

        associate (knowledge => observations%knowledge)
            select case (wrong%kind)
            case (OF_VALUE)
                call apply_value(wrong%place, sign_of*wrong%value, observations)
            case (OF_ALTERATION)
                call apply_alteration(wrong%place, observations)
            case (OF_NOISE)
                if (wrong%place <= 3) then
                    knowledge%accelerometer_noise(wrong%place)%level = wrong%value**2* &
                                                                       knowledge%accelerometer_noise(wrong%place)%level
                else
                    knowledge%star_camera_sigma(wrong%place - 3) = wrong%value*knowledge%star_camera_sigma(wrong%place - 3)
                end if
            end select
        end associate
    end subroutine spoil

    !> The place of its own test among those of a report; 0: there is none.
    pure integer function test_of(wrong, report)
        type(wrong_belief_t), intent(in) :: wrong
        type(belief_report_t), intent(in) :: report

        test_of = 0
        if (wrong%kind == OF_VALUE) test_of = findloc(report%values%belief, wrong%place, 1)
    end function test_of

    !> Is a wrong belief among the explanations? A sign is a gain or a scale factor of -1, too.
    pure logical function is_named(wrong, explanations) result(named)
        type(wrong_belief_t), intent(in) :: wrong
        type(explanation_t), intent(in) :: explanations(:)

        integer :: i

        named = .false.
        do i = 1, size(explanations)
            associate (e => explanations(i))
                if (e%kind == wrong%kind) then
                    named = named .or. e%place == wrong%place .or. e%kind == OF_NOISE
                else if (e%kind == OF_VALUE .and. wrong%kind == OF_ALTERATION) then
                    named = named .or. as_value(wrong%place) == e%place
                else if (e%kind == OF_ALTERATION .and. wrong%kind == OF_VALUE) then
                    named = named .or. as_value(e%place) == wrong%place
                end if
            end associate
        end do
    end function is_named

    !> The parameter whose value -2 is an alteration; 0: none.
    pure integer function as_value(alteration) result(parameter)
        integer, intent(in) :: alteration       !! Place in ALTERATIONS

        select case (alteration)
        case (1:3)
            parameter = ROD_GAINS(alteration)
        case (4)
            parameter = ROD_GAIN
        case (8:10)
            parameter = SCALE_FACTORS(alteration - 7)
        case (14:16)
            parameter = FIELD_SCALES(alteration - 13)
        case default
            parameter = 0
        end select
    end function as_value

    !> What a wrong belief is of: 'gain of rod x', 'noise of accelerometer y'.
    function subject_of(wrong) result(text)
        type(wrong_belief_t), intent(in) :: wrong
        character(52) :: text               !! Blanks behind it

        select case (wrong%kind)
        case (OF_VALUE)
            text = belief_subject(wrong%place)
        case (OF_ALTERATION)
            text = ALTERATIONS(wrong%place)
        case (OF_NOISE)
            text = NOISE_SUBJECTS(wrong%place)
        case default
            text = 'nothing is wrong'
        end select
    end function subject_of

    !> By how much a belief is wrong: '0.2 s', '10 times'; empty where there is no size.
    function size_text(wrong) result(text)
        type(wrong_belief_t), intent(in) :: wrong
        character(24) :: text               !! Blanks behind it

        text = ''
        if (wrong%kind == OF_VALUE) then
            text = rounded_text(wrong%value/BELIEF_SIZE(wrong%place), 3)//' '//BELIEF_UNIT(wrong%place)
        else if (wrong%kind == OF_NOISE) then
            text = rounded_text(wrong%value, 3)//' times'
        end if
    end function size_text
end module gracecg_studies_wrong_beliefs
