!> What the tests of beliefs say of wrong ones: whether they are contradicted, by what name, and with what power.
module test_belief_verdicts
    use vocabulary
    use calibrations
    use gracecg_base_error, only: number_text
    use gracecg_spacecraft_torque_rods, only: new_torque_rods, rod_activation_t, SQUARE
    use gracecg_simulation_operator_errors, only: COMMON_ROD_GAIN, ROD_DIRECTION, INERTIA_ERRORS => INERTIA
    use gracecg_simulation_simulator, only: new_simulator, observe
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_parameters
    use gracecg_estimation_belief, only: apply_value, ALTERATIONS, apply_alteration
    use gracecg_base_quaternion, only: quaternion_product
    use gracecg_estimation_belief_report, only: belief_report_t, explanation_t, begin_report, add_value, add_score, &
        finish_report, CONFIRMED, UNTESTED, OF_VALUE, OF_ALTERATION, OF_NOISE, NOISE_SUBJECTS, POWER, CONTRADICTED, &
        FIELD_AGAINST_MODEL, HEADS_APART
    use gracecg_estimation_action, only: known_offset_t, known_of
    use gracecg_estimation_belief_words, only: say_contradiction
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_parameters, only: feels_air
    use gracecg_studies_wrong_beliefs, only: wrong_belief_t, tally_t, all_wrong_beliefs, try_wrong_beliefs, subject_of
    use belief_fixture, only: simulator_of, WAVE_NEAR_RODS
    implicit none
    private
    public :: collect_belief_verdicts

    integer, parameter :: SEEDS = 8
    real(dp), parameter :: QUIET = 1e-22_dp     ! m^2 s^-4/Hz; the report's is 1e-20 and more

contains

    subroutine collect_belief_verdicts(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('wrong-beliefs-are-found-and-named', test_wrong_beliefs), &
                    new_unittest('what-does-not-converge-is-refused', test_not_converged), &
                    new_unittest('samples-belong-to-one-satellite', test_other_satellite), &
                    new_unittest('a-long-arc-is-called-long', test_long_arc), &
                    new_unittest('the-air-is-felt-by-what-is-quiet', test_air), &
                    new_unittest('what-is-stated-limits-what-is-unseen', test_stated), &
                    new_unittest('what-is-stated-of-a-strange-field-limits-nothing', test_beside_the_fit), &
                    new_unittest('no-trim-by-a-skew-magnetometer', test_skew_magnetometer), &
                    new_unittest('nothing-is-tested-of-a-singular-fit', test_singular), &
                    new_unittest('all-as-wrong-as-stated', test_all_as_stated), &
                    new_unittest('a-wave-that-grows-with-the-drag', test_growing_wave), &
                    new_unittest('noise-nearly-as-stated', test_noise_nearly), &
                    new_unittest('power-is-that-stated', test_power), &
                    new_unittest('tried-one-after-the-other', test_trials)]
    end subroutine collect_belief_verdicts

    !> The orbit or the magnetometer of another time, and heads that are 720" apart: told by the model of the field, and by
    !> the heads. Of sound samples both are confirmed.
    subroutine test_other_satellite(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: APART = 0.2_dp*DEGREE
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations, wrong, others
        integer :: i

        call simulator_of('back-3', simulator, options)
        call make_observations(simulator, 7, 1, others)
        call simulator_of('front-3', simulator, options)
        call make_observations(simulator, 7, 1, observations)
        wrong = observations
        call tells('', 'magnetometer against field model')
        wrong%orbit_position = others%orbit_position
        call tells('another satellite or time', 'magnetometer against field model')
        wrong = observations
        wrong%field = others%field
        call tells('another satellite or time', 'magnetometer against field model')
        wrong = observations
        do i = 1, size(wrong%star_camera_time)
            if (wrong%star_camera_head(i) == 2) wrong%quaternion(:, i) = &
                quaternion_product([0.0_dp, sin(APART/2), 0.0_dp, cos(APART/2)], wrong%quaternion(:, i))
        end do
        call tells('the mounting of head 1', 'star-camera heads, each other')

    contains

        !> Nothing is contradicted where there are no words; else the test of that name is, with these words.
        subroutine tells(words, subject)
            character(*), intent(in) :: words, subject
            type(solution_t) :: solution
            type(error_t), allocatable :: refused
            character(:), allocatable :: text
            integer :: k

            call estimate_offset('optimal', wrong, options, solution, refused)
            if (unmet(error, allocated(solution%beliefs), subject//': no tests')) return
            call say_contradiction(solution%beliefs, text)
            k = findloc(NOISE_SUBJECTS(solution%beliefs%noises%subject) == subject, .true., 1)
            call check(error, k > 0, subject//': not tested')
            call check(error, (solution%beliefs%noises(k)%state == CONTRADICTED) .eqv. words /= '', subject//': '//text)
            call check_says(error, text, words)
        end subroutine tells
    end subroutine test_other_satellite

    !> Rods, inertia, scales and biases all as wrong as is stated of them, and noise so low that each is seen by itself: it is
    !> no contradiction, and the sigma that the action prints holds.
    subroutine test_all_as_stated(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(known_offset_t) :: known
        type(error_t), allocatable :: failure
        integer :: seed, refused, sharp, i
        real(dp) :: squares(3)

        call take_calibration('front-3', calibration)
        associate (case => calibration%case, stated => calibration%case%operator%a_priori)
            case%satellite%accelerometer%noise%level = QUIET
            call new_torque_rods([(rod_activation_t(axis=i, amplitude=30, frequency=(4 + i)/60.0_dp, stop=60), i=1, 3)], &
                                 case%satellite%rods, failure)
            case%operator%sigma(1, COMMON_ROD_GAIN) = stated%sigma_rod_gain
            case%operator%sigma(:, ROD_DIRECTION) = stated%sigma_directions(1)
            case%operator%sigma(:, INERTIA_ERRORS) = stated%sigma_inertia
        end associate
        call make_simulator(calibration%case, simulator)
        refused = 0
        sharp = 0
        squares = 0
        do seed = 1, SEEDS
            call make_observations(simulator, seed, 1, observations)
            if (estimate_fails(error, 'optimal', observations, calibration%options, solution)) return
            if (solution%beliefs%has_contradiction()) refused = refused + 1
            if (any(abs(solution%beliefs%values%score) > solution%beliefs%critical)) sharp = sharp + 1
            known = known_of(solution%offset, solution%covariance, solution%beliefs)
            squares = squares + ((solution%offset - calibration%case%satellite%offset)/known%sigma)**2/SEEDS
        end do
        call check(error, sharp > SEEDS/2, 'each by itself would be')
        call check(error, refused <= 1, 'no contradiction: '//integer_text(refused))
        call check(error, all(squares < 2), 'the sigma of the action')
    end subroutine test_all_as_stated

    !> Noise whose variance is a quarter more than the setup says is no contradiction, and the sigma grows by it; one of twice
    !> the variance is.
    subroutine test_noise_nearly(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(solution_t) :: solution, sound
        integer :: seed, refused, told

        call simulator_of('front-3', simulator, options)
        refused = 0
        told = 0
        do seed = 1, SEEDS
            call make_observations(simulator, seed, 1, observations)
            if (estimate_fails(error, 'optimal', observations, options, sound)) return
            associate (level => observations%knowledge%accelerometer_noise%level)
                level = level/1.25_dp
                if (estimate_fails(error, 'optimal', observations, options, solution)) return
                if (solution%beliefs%has_contradiction()) refused = refused + 1
                if (solution%covariance(2, 2) < sound%covariance(2, 2)) told = told + 1
                level = level*1.25_dp/2
            end associate
            if (estimate_fails(error, 'optimal', observations, options, solution)) return
            call check(error, solution%beliefs%has_contradiction(), 'twice the variance')
        end do
        call check(error, refused <= SEEDS/5, 'contradicted: '//integer_text(refused))
        call check(error, told <= SEEDS/5, 'a smaller sigma: '//integer_text(told))
    end subroutine test_noise_nearly

    !> Two minutes in which the drag changes by a tenth, and quiet instruments: the wave of the density is seen to grow.
    subroutine test_growing_wave(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(solution_t) :: solution

        call take_calibration('back-3', calibration)
        associate (case => calibration%case)
            case%duration = 120
            case%satellite%accelerometer%noise%level = QUIET
        end associate
        call make_simulator(calibration%case, simulator)
        call make_observations(simulator, 1, 1, observations)
        if (estimate_fails(error, 'optimal', observations, calibration%options, solution)) return
        call check(error, any(solution%parameters%name == 'wave_growth'), 'it grows')
        call check(error, .not. any(solution%beliefs%noises%state == CONTRADICTED), 'no line is left')
    end subroutine test_growing_wave

    !> A long arc that nothing explains wholly blames no belief.
    subroutine test_long_arc(error)
        type(error_type), allocatable, intent(out) :: error
        type(belief_report_t) :: report
        character(:), allocatable :: text

        call begin_report([0.0_dp, 0.0_dp, 0.0_dp], 5e-5_dp, .true., report)
        call add_score(report, 10, 14.0_dp, 0.05_dp, .false.)
        call add_score(report, 5, 3.0_dp, 0.0_dp, .false.)
        call finish_report(report)
        report%explanations = [explanation_t(OF_VALUE, INERTIA(3), 100.0_dp, -11.0_dp, 0.7_dp)]
        report%arc = 60
        call say_contradiction(report, text)
        call check_says(error, text, 'the inertia zz is 11 ... even then')
        report%arc = 600        ! the rotation fits: it is not the arc
        if (.not. allocated(error)) call say_contradiction(report, text)
        call check_says(error, text, 'the inertia zz is 11')
        report%noises(2)%state = CONTRADICTED
        if (.not. allocated(error)) call say_contradiction(report, text)
        call check(error, index(text, 'inertia') == 0 .and. &
                                               index(text, 'in shorter arcs (--algorithm optimal --arc 60)') > 0, text)
    end subroutine test_long_arc

    !> Residuals that are no noise may be the air's forces where the accelerometer is quiet for the drag that is stated; a belief
    !> that is farther off, or the star camera, is something else.
    subroutine test_air(error)
        type(error_type), allocatable, intent(out) :: error
        type(belief_report_t) :: report
        type(operator_knowledge_t) :: knowledge
        character(:), allocatable :: text
        integer :: subject

        do subject = 5, 7, 2        ! star camera, colour of the accelerometer's noise
            report = belief_report_t(feels_air=.true.)
            call begin_report([0.0_dp, 0.0_dp, 0.0_dp], 5e-5_dp, .true., report)
            call add_score(report, subject, 14.0_dp, 0.0_dp, .false.)
            call finish_report(report)
            call say_contradiction(report, text)
            call check(error, (index(text, 'forces of the air') > 0) .eqv. subject == 7, text)
        end do
        report%feels_air = .false.
        call say_contradiction(report, text)
        call check(error, index(text, 'forces of the air') == 0, text)
        knowledge%accelerometer_noise%level = 1e-22_dp
        call check(error, feels_air(knowledge), 'usual drag')
        knowledge%a_priori%drag = 1e-8_dp
        call check(error, .not. feels_air(knowledge), 'hardly any drag')
    end subroutine test_air

    !> A gain that is stated to 0.5 %, and found to 10 %: three times what is stated counts, until its score is suspicious; and
    !> again when fits do not bear the score out.
    subroutine test_stated(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: STATED = 0.005_dp, BY_ONE(3) = [1e-3_dp, 0.0_dp, 0.0_dp]
        real(dp), parameter :: SCORES(3) = [20.0_dp, 32.0_dp, 35.0_dp]      ! ten times T
        type(belief_report_t) :: report
        integer :: i, k

        do i = 1, size(SCORES)
            report = belief_report_t()
            call begin_report([0.0_dp, 0.0_dp, 0.0_dp], 5e-5_dp, .true., report)
            call add_value(report, ROD_GAIN, SCORES(i), 100.0_dp, STATED, STATED, BY_ONE, 2.0_dp, 3*STATED, .false.)
            do k = 1, 60        ! a family with which T = 3.5 is not yet contradicted
                call add_score(report, 7, 0.0_dp, 0.0_dp, .false.)
            end do
            call finish_report(report)
            associate (test => report%values(1))
                call check(error, test%effect(1), BY_ONE(1)*test%detectable, thr=1e-15_dp)
                if (i < 3) then
                    call check(error, test%state == CONFIRMED .and. abs(test%within(1) - 3*STATED*BY_ONE(1)) < 1e-15_dp)
                else
                    call check(error, test%state == UNTESTED .and. abs(test%within(1) - test%effect(1)) <= 0)
                end if
            end associate
        end do
        call check(error, maxval(report%undetected(.true.)) > 5e-5_dp)
        call report%take_score(1, 1.0_dp)
        call check(error, maxval(abs(report%undetected(.true.) - 3*STATED*BY_ONE)) < 1e-15_dp)
        call check(error, report%values(1)%state, CONFIRMED)
    end subroutine test_stated

    !> A magnetometer that does not follow the field model: what is stated of it limits nothing then, what is stated of rods
    !> and mounting still does. Star-camera heads apart: the other way round.
    subroutine test_beside_the_fit(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: STATED = 0.005_dp, BY_ONE(3) = [1e-3_dp, 0.0_dp, 0.0_dp], INFORMATION = 100
        type(belief_report_t) :: report
        logical :: free(3), wanted(3)
        integer :: subject, i, sign_of

        associate (places => [ROD_GAIN, FIELD_SHEARS(3), MOUNTING_2(1)])
            do subject = FIELD_AGAINST_MODEL, HEADS_APART
                do sign_of = -1, 1, 2
                    report = belief_report_t()
                    call begin_report([0.0_dp, 0.0_dp, 0.0_dp], 5e-5_dp, .true., report)
                    do i = 1, size(places)
                        call add_value(report, places(i), 0.0_dp, INFORMATION, STATED, STATED, BY_ONE, 2.0_dp, 3*STATED, .false.)
                    end do
                    call add_score(report, FIELD_AGAINST_MODEL + HEADS_APART - subject, 3.2_dp, 0.0_dp, .false.)
                    call add_score(report, subject, sign_of*3.4_dp, 0.0_dp, .false.)
                    call finish_report(report)
                    free = abs(report%values%within(1) - report%values%effect(1)) <= 0
                    wanted = [.false., subject == FIELD_AGAINST_MODEL, subject == HEADS_APART]
                    call check(error, all(free .eqv. wanted), NOISE_SUBJECTS(subject))
                end do
            end do
        end associate
    end subroutine test_beside_the_fit

    !> Axes z and x of the magnetometer are skew by 0.05 rad, six times what is stated and less than the fit can see: the field
    !> model tells, and x, which is 0.1 mm off, is not trimmed.
    subroutine test_skew_magnetometer(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(tally_t), allocatable :: tallies(:)
        type(error_t), allocatable :: failure

        call take_calibration('front-3', calibration)
        call try_wrong_beliefs(calibration, ['optimal'], .false., [wrong_belief_t(OF_VALUE, FIELD_SHEARS(3), 0.05_dp)], &
                               1_i8, 1, 1, tallies, failure)
        if (failed(error, failure)) return
        call check(error, tallies(1)%worst > 4, 'the offset is wrong')
        call check(error, tallies(1)%harmful, 0, 'trim')
    end subroutine test_skew_magnetometer

    !> Wrong beliefs of several kinds: contradicted, and the right one named first.
    subroutine test_wrong_beliefs(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations, wrong

        call check(error, all(len_trim(ALTERATIONS) < len(ALTERATIONS)), 'words are cut')
        call simulator_of('front-3', simulator, options)
        if (.not. allocated(error)) call sound(7)
        wrong%knowledge%rods%activations%frequency = 0.11_dp
        call named(OF_VALUE, 'frequency of all rods', -0.01_dp)
        wrong = observations
        wrong%knowledge%rods%gain(3) = 2
        call named(OF_VALUE, 'gain of rod z', -0.5_dp)
        wrong = observations
        call apply_alteration(find_alteration('accelerometer y and z'), wrong)
        call named(OF_ALTERATION, 'accelerometer y and z are interchanged', 0.0_dp)
        wrong = observations
        wrong%knowledge%accelerometer_noise%level = observations%knowledge%accelerometer_noise%level/100
        call named(OF_NOISE, 'noise of accelerometer', 10.0_dp)
        ! A delay of accelerometer x by a second would smooth its noise, a scale factor of 2.4 lower it: no explanations
        call simulator_of('front-1', simulator, options)
        if (.not. allocated(error)) call sound(7)
        wrong%knowledge%rods%delay(3) = 0.2_dp
        call named(OF_VALUE, 'delay of rod z', -0.2_dp)
        ! Rod y does nearly all: a delay of it and one of all rods are the same. Axes turned this far no step leads back
        call simulator_of('front-2', simulator, options, WAVE_NEAR_RODS)
        if (.not. allocated(error)) call sound(7)
        wrong%knowledge%rods%delay(2) = 0.2_dp
        call named(OF_VALUE, 'delay of rod y', -0.2_dp, together=.true.)
        call named(OF_VALUE, 'delay of all rods', -0.2_dp, together=.true.)
        wrong = observations
        call apply_value(ACCELEROMETER_TURN(2), 20*DEGREE, wrong)
        call named(OF_VALUE, 'direction of accelerometer about y', -20*DEGREE)

    contains

        subroutine sound(run)
            integer, intent(in) :: run

            call make_observations(simulator, 4713, run, observations)
            wrong = observations
        end subroutine sound

        integer function find_alteration(beginning) result(place)
            character(*), intent(in) :: beginning

            place = findloc(index(ALTERATIONS, beginning) == 1, .true., 1)
        end function find_alteration

        subroutine named(kind, subject, value, together)
            integer, intent(in) :: kind
            character(*), intent(in) :: subject
            real(dp), intent(in) :: value       !! SI units; its first digit counts
            logical, intent(in), optional :: together       !! With others, not before them
            type(solution_t) :: solution
            type(error_t), allocatable :: failure
            character(52) :: found
            integer :: i

            call estimate_offset('optimal', wrong, options, solution, failure)  ! may be refused
            if (unmet(error, allocated(solution%beliefs), subject//': no tests')) return
            call check(error, solution%beliefs%has_contradiction(), subject//': not contradicted')
            if (unmet(error, size(solution%beliefs%explanations) > 0, subject//': not explained')) return
            i = 1
            if (present(together)) then
                do i = 1, size(solution%beliefs%explanations) - 1
                    associate (one => solution%beliefs%explanations(i))
                        if (one%kind == OF_VALUE .and. belief_subject(one%place) == subject) exit
                    end associate
                end do
            end if
            associate (first => solution%beliefs%explanations(i))
                if (kind == OF_VALUE) then
                    found = belief_subject(first%place)
                else if (first%kind == OF_ALTERATION) then
                    found = ALTERATIONS(first%place)
                else
                    found = NOISE_SUBJECTS(first%place)
                end if
                if (unmet(error, first%kind == kind .and. index(found, subject) == 1, subject//' is named '//found)) return
                if (kind == OF_ALTERATION) return
                call check(error, abs(first%value - value) < 0.15_dp*abs(value), subject//': '//number_text(first%value))
            end associate
        end subroutine named
    end subroutine test_wrong_beliefs

    !> Sound runs, a rod of another frequency and noise believed too small by ten: told, and told by name. A frequency far
    !> beyond what is detectable counts as that.
    subroutine test_trials(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RUNS = 1
        type(calibration_t) :: calibration
        type(wrong_belief_t), allocatable :: list(:)
        type(tally_t), allocatable :: tallies(:)
        type(error_t), allocatable :: failure
        integer :: i

        call take_calibration('front-3', calibration)
        list = all_wrong_beliefs()
        list = pack(list, [(any([character(52) :: 'nothing is wrong', 'frequency of rod z', 'noise of accelerometer x'] == &
                                subject_of(list(i))), i=1, size(list))])
        call try_wrong_beliefs(calibration, ['optimal'], .true., list, 4715_i8, RUNS, 1, tallies, failure)
        if (failed(error, failure)) return
        call check(error, size(tallies), 1 + 3 + 3)
        call check(error, all(tallies%silent == 0), 'silent')
        call check(error, tallies(1)%contradicted, 0, 'nothing is wrong')
        call check(error, tallies(4)%times > 2, 'detectable')
        call check(error, tallies(4)%contradicted, RUNS, 'frequency')
        call check(error, tallies(4)%named, RUNS, 'frequency by name')
        call check(error, tallies(5)%contradicted, RUNS, 'noise')
        call check(error, tallies(5)%named, RUNS, 'noise by name')
    end subroutine test_trials

    !> Quaternions whose components stand in another order: `optimal` fits nothing, so that no belief is tested, and what
    !> `sequential` makes of them does not converge, which is no silent result.
    subroutine test_not_converged(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration
        type(wrong_belief_t), allocatable :: list(:)
        type(tally_t), allocatable :: tallies(:)
        type(error_t), allocatable :: failure
        integer :: i

        call take_calibration('back-1', calibration)
        list = all_wrong_beliefs()
        list = pack(list, [(subject_of(list(i)) == 'the quaternions have the scalar first', i=1, size(list))])
        call try_wrong_beliefs(calibration, ['sequential'], .false., list, 7001_i8, 2, 1, tallies, failure)
        if (failed(error, failure)) return
        call check(error, size(tallies) == 1 .and. tallies(1)%refused == 2 .and. tallies(1)%silent == 0)
    end subroutine test_not_converged

    !> Quaternions of another convention in the manoeuvre that `design` finds for front 1: among what might explain it are
    !> fits whose normal matrix with the forces' shapes is singular, of which no belief is tested.
    subroutine test_singular(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: FREQUENCY(3) = [0.18332252381644681_dp, 0.13355009605689397_dp, 0.18332868418778148_dp]   ! Hz
        real(dp), parameter :: PHASE(3) = [77.73997155859475_dp, 97.95996108970257_dp, 77.69514825950904_dp]     ! deg
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations, wrong
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        integer :: i, k

        call take_calibration('front-1', calibration)
        calibration%options%optimal%estimate_scale_factors = .true.
        calibration%options%optimal%estimate_magnetometer_bias = .true.
        options = calibration%options
        associate (rods => calibration%case%satellite%rods)
            call new_torque_rods([(rod_activation_t(axis=i, amplitude=30, frequency=FREQUENCY(i), phase=PHASE(i)*DEGREE, &
                                  stop=60, waveform=SQUARE), i=1, 3)], &
                                 rods, failure)
        end associate
        if (.not. allocated(failure)) call new_simulator(calibration%case, simulator, failure)
        if (.not. allocated(failure)) call observe(simulator, 1_i8, 1, observations, failure)
        call check_passes(error, failure)
        do k = 1, size(ALTERATIONS)
            if (index(ALTERATIONS(k), 'the quaternions') /= 1) cycle
            wrong = observations
            call apply_alteration(k, wrong)
            call estimate_offset('optimal', wrong, options, solution, failure)      ! may be refused
            if (allocated(failure)) cycle
            call check(error, allocated(solution%beliefs), 'no tests')
            call check(error, solution%beliefs%has_contradiction(), 'not contradicted')
        end do
    end subroutine test_singular

    !> A belief that is wrong by its minimal detectable value is contradicted with the power that is stated.
    subroutine test_power(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RUNS = 60, TESTED(3) = [ROD_FREQUENCIES(3), TORQUE_CHANGE(1), INERTIA(4)]
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations, wrong
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        integer :: run, i, k, found

        ! without a wave in the data the search takes what a wrong frequency does for one, which what is stated leaves out
        call simulator_of('front-3', simulator, options, WAVE_NEAR_RODS)
        do k = 1, size(TESTED)
            found = 0
            do run = 1, RUNS
                call make_observations(simulator, 4714, run, observations)
                call estimate_optimal(observations, options, solution, failure)
                if (failed(error, failure)) return
                i = findloc(solution%beliefs%values%belief, TESTED(k), 1)
                wrong = observations
                call apply_value(TESTED(k), solution%beliefs%values(i)%detectable, wrong)
                call estimate_optimal(wrong, options, solution, failure)
                if (.not. allocated(solution%beliefs)) cycle
                if (solution%beliefs%values(i)%state == CONTRADICTED) found = found + 1
            end do
            call check(error, abs(found/real(RUNS, dp) - POWER) < 3.5_dp*sqrt(POWER*(1 - POWER)/RUNS), &
                       parameter_names(TESTED(k))//integer_text(found))
        end do
    end subroutine test_power
end module test_belief_verdicts
