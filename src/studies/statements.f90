!> Statements of CSR-TM-00-01 that stand in its text without a table or a figure, examined: each is computed, and
!> its verdict follows from the numbers.
module gracecg_studies_statements
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE, ARCSECOND, AXES
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    use gracecg_base_quaternion, only: normalised
    use gracecg_base_text, only: integer_text, join
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_files_data_table, only: data_table_t
    use gracecg_files_value, only: did_you_mean
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_spacecraft_torque_rods, only: new_harmonic_manoeuvre
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_attitude_problem, only: attitude_problem_t, prepare_attitude
    use gracecg_estimation_batch_problem, only: batch_solution_t
    use gracecg_estimation_batch_processor, only: batch_settings_t, process_batch
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_simulation_arc, only: truth_arc_t
    use gracecg_simulation_case_models, only: case_star_catalogue
    use gracecg_simulation_dynamics, only: ATTITUDE
    use gracecg_simulation_report_cases, only: ROD_AMPLITUDE, ROD_FREQUENCY, REPORT_CASE_NAMES
    use gracecg_simulation_star_camera, only: star_camera_t, STAR_SELECTIONS
    use gracecg_simulation_star_catalogue, only: star_catalogue_t
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, observe_without_noise
    use gracecg_simulation_switches, only: error_switches_t, new_switched_simulator
    use gracecg_planning_bound, only: case_bound_t, bound_of_case
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_studies_monte_carlo, only: monte_carlo_t, run_monte_carlo, error_statistics_t, statistics_of, &
        prediction_t, predict_errors
    implicit none
    private
    public :: statement_t, statement_row_t, examine_statement, statement_table, STATEMENT_NAMES
    public :: HOLDS, HOLDS_IN_PART, HOLDS_NOT, VERDICT_WORDS

    !> The statements, as on the command line
    character(12), parameter :: STATEMENT_NAMES(9) = [character(12) :: 'one-rod', 'dominance', 'arc-length', 'weights', &
                                                      'accuracy', 'curved-force', 'condition', 'two-steps', 'stars']

    integer, parameter :: HOLDS = 1, HOLDS_IN_PART = 2, HOLDS_NOT = 3   !! Verdicts
    !> The verdicts in words, by HOLDS, HOLDS_IN_PART, HOLDS_NOT
    character(13), parameter :: VERDICT_WORDS(3) = [character(13) :: 'holds', 'holds in part', 'does not hold']

    !> One setting of a statement's study.
    type :: statement_row_t
        character(16) :: case_name = ''     !! Of the report, or several joined by +
        character(40) :: setting = ''       !! What is changed
        integer :: runs = 0                 !! Of the Monte Carlo; 0: theory alone
        real(dp) :: rms(3) = 0              !! Error of d in these runs, x, y, z, m
        real(dp) :: predicted(3) = 0        !! By theory, m; 0: not of errors
        real(dp) :: condition = 0           !! Of a normal matrix; 0: not asked for
        real(dp) :: torque_ratio = 0        !! Rods' torque over the sum of all others, RMS; 0: not asked for
        real(dp) :: stars = 0               !! In the field of a star camera, on average; 0: not asked for
        real(dp) :: camera_sigma(3) = 0     !! Of its attitude, about camera x, y, boresight, rad; 0: not asked for
    end type statement_row_t

    !> A statement and what is found.
    type :: statement_t
        character(12) :: name = ''          !! Of STATEMENT_NAMES
        character(40) :: place = ''         !! In the report
        character(240) :: claim = ''        !! What the report says
        character(200) :: method = ''       !! What is computed
        integer :: verdict = 0              !! HOLDS, HOLDS_IN_PART or HOLDS_NOT
        character(200) :: found = ''        !! The verdict in a sentence, with the numbers that make it
        character(400) :: details = ''      !! More of them
        type(statement_row_t), allocatable :: rows(:)   !! The numbers behind it
    end type statement_t

    !> What a study of statements is told.
    type :: settings_t
        integer :: runs = 0, threads = 1
        integer(i8) :: seed = 1
    end type settings_t

    character(7), parameter :: FRONT_CASES(3) = [character(7) :: 'front-1', 'front-2', 'front-3']
    character(*), parameter :: SINGLE_ALGORITHM = 'assest-fde', COMBINED_ALGORITHM = 'ascfest'
    real(dp), parameter :: BEST_ACCURACY(3) = [0.02_dp, 0.01_dp, 0.02_dp]*MILLIMETRE    !! Section 7.1(3), x, y, z
    ! What the verdicts ask for
    real(dp), parameter :: NO_CHANGE = 0.01_dp          !! Of errors, relative: so little is no dependence on a weight
    real(dp), parameter :: DEPENDENCE = 1.1_dp          !! Quotient of errors from which on they depend on a weight
    real(dp), parameter :: REGULAR = 1e8_dp, SINGULAR = 1e12_dp
    !! Condition with unit diagonal: below the first half of the digits is left, above the second hardly any
    real(dp), parameter :: STARS_OF_REPORT = 70, ROUGHLY = 0.25_dp      !! Stars in a field; a relative difference that is rough
    real(dp), parameter :: SMALL_SHARE = 0.1_dp         !! Of the variance of an error: a small impact, 5 % of the RMS
    real(dp), parameter :: DOMINATES = 10               !! Torque ratio from which on the rods' torque dominates
    integer, parameter :: STARS_AT_LEAST = 20           !! In every frame
    real(dp), parameter :: LENGTHS(6) = [60.0_dp, 90.0_dp, 120.0_dp, 180.0_dp, 240.0_dp, 300.0_dp]      !! Of arcs, s

contains

    !> Examines one statement. Fails for a name that is none of STATEMENT_NAMES, and when a run fails.
    subroutine examine_statement(name, runs, seed, threads, statement, error, progress)
        character(*), intent(in) :: name            !! One of STATEMENT_NAMES
        integer, intent(in) :: runs, threads        !! Of each Monte Carlo, 0: theory alone; in parallel
        integer(i8), intent(in) :: seed             !! Of the random numbers
        type(statement_t), intent(out) :: statement
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(settings_t) :: settings

        settings = settings_t(runs, threads, seed)
        statement%name = name
        allocate (statement%rows(0))
        select case (name)
        case ('one-rod')
            call examine_one_rod(settings, statement, error, progress)
        case ('dominance')
            call examine_dominance(statement, error)
        case ('arc-length')
            call examine_arc_length(settings, statement, error, progress)
        case ('weights')
            call examine_weights(settings, statement, error, progress)
        case ('accuracy')
            call examine_accuracy(settings, statement, error, progress)
        case ('curved-force')
            call examine_curved_force(settings, statement, error, progress)
        case ('condition')
            call examine_condition(statement, error)
        case ('two-steps')
            call examine_two_steps(statement, error)
        case ('stars')
            call examine_stars(statement, error, progress)
        case default
            call fail(error, 'no statement "'//trim(name)//'"; there are '//join(STATEMENT_NAMES, ', ')// &
                      did_you_mean(name, STATEMENT_NAMES))
        end select
    end subroutine examine_statement

    !> Theory of a calibration with an algorithm, and runs beside it: a row.
    subroutine add_row(settings, calibration, algorithm, setting, statement, error, progress, switches)
        type(settings_t), intent(in) :: settings
        type(calibration_t), intent(in) :: calibration
        character(*), intent(in) :: algorithm, setting
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress
        type(error_switches_t), intent(in), optional :: switches    !! Error sources that act; all when absent

        type(error_switches_t) :: acting
        type(statement_row_t) :: row
        type(simulator_t) :: simulator
        type(prediction_t) :: prediction
        type(monte_carlo_t) :: results
        type(error_statistics_t) :: statistics
        integer :: i

        row%case_name = trim(calibration%case%name)     ! of the report: 7 letters
        row%setting = setting
        row%runs = settings%runs
        call tell(progress, trim(statement%name)//', '//trim(row%case_name)//', '//setting)
        if (present(switches)) acting = switches
        call new_switched_simulator(calibration%case, acting, simulator, error)
        if (.not. allocated(error)) call predict_errors(simulator, algorithm, calibration%options, prediction, error)
        if (allocated(error)) return
        row%predicted = prediction%rms
        if (settings%runs > 0) then
            call run_monte_carlo(simulator, algorithm, calibration%options, settings%seed, [(i, i=1, settings%runs)], &
                                 settings%threads, results, error, progress=progress)
            if (allocated(error)) return
            statistics = statistics_of(results%offset/MILLIMETRE, simulator%case%satellite%offset/MILLIMETRE)
            row%rms = statistics%rms*MILLIMETRE
        end if
        statement%rows = [statement%rows, row]
    end subroutine add_row

    !> One rod alone against both, at all places.
    subroutine examine_one_rod(settings, statement, error, progress)
        type(settings_t), intent(in) :: settings
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(calibration_t) :: calibration
        integer :: i, axis

        statement%place = 'sections 4.1 and 7.1(1)'
        statement%claim = 'activating the magnetic dipole moment along only one axis cannot yield good CG calibration accuracy'
        statement%method = 'one rod of 30 A m^2 at 0.1 Hz in place of the report''s two; '//SINGLE_ALGORITHM
        call expect_pieces(progress, size(FRONT_CASES)*(1 + 3)*settings%runs, 'runs')
        do i = 1, size(FRONT_CASES)
            call find_calibration(FRONT_CASES(i), calibration, error)
            if (.not. allocated(error)) call add_row(settings, calibration, SINGLE_ALGORITHM, 'both rods', statement, &
                                                     error, progress)
            do axis = 1, 3
                if (allocated(error)) return
                call leave_one_rod(calibration, axis, error)
                if (.not. allocated(error)) call add_row(settings, calibration, SINGLE_ALGORITHM, &
                                                         AXES(axis)//' rod alone', statement, error, progress)
            end do
            if (allocated(error)) return
        end do
        call judge_one_rod(statement)
    end subroutine examine_one_rod

    !> Rows in fours: both rods, then each alone. For all axes together the largest error counts.
    subroutine judge_one_rod(statement)
        type(statement_t), intent(inout) :: statement

        integer :: i, k, axis, together, better
        character(60) :: best

        together = 0
        better = 0
        best = ''
        do i = 1, size(statement%rows), 4
            do k = i + 1, i + 3
                associate (both => statement%rows(i)%predicted, alone => statement%rows(k)%predicted)
                    if (maxval(alone) <= maxval(both)) together = together + 1
                    do axis = 1, 3
                        if (alone(axis) >= both(axis)) cycle
                        better = better + 1
                        if (best == '') best = trim(statement%rows(k)%setting)//' in '//trim(statement%rows(k)%case_name)// &
                            ': '//AXES(axis)//' '//mm_text(alone(axis))//' against '//mm_text(both(axis))//' mm'
                    end do
                end associate
            end do
        end do
        if (together == 0 .and. better == 0) then
            statement%verdict = HOLDS
            statement%found = 'Holds: no axis is determined better by one rod.'
        else if (together == 0) then
            statement%verdict = HOLDS_IN_PART
            statement%found = 'Holds for all axes together only: the worst axis of one rod is always worse than that of '// &
                'two, but '//integer_text(better)//' of '//integer_text(3*3*size(statement%rows)/4)// &
                ' single components are better.'
            statement%details = 'The first of them: '//trim(best)//'.'
        else
            statement%verdict = HOLDS_NOT
            statement%found = 'Does not hold: in '//integer_text(together)//' of '//integer_text(3*size(statement%rows)/4)// &
                ' trials one rod has the better worst axis.'
        end if
    end subroutine judge_one_rod

    !> One rod at full moment in place of the manoeuvre.
    subroutine leave_one_rod(calibration, axis, error)
        type(calibration_t), intent(inout) :: calibration
        integer, intent(in) :: axis             !! Its number: 1 x, 2 y, 3 z
        type(error_t), allocatable, intent(out) :: error

        integer :: pattern(3)

        pattern = 0
        pattern(axis) = 1
        call new_harmonic_manoeuvre(calibration%case%satellite%rods, pattern, ROD_AMPLITUDE, ROD_FREQUENCY, 0.0_dp, &
                                    calibration%case%duration, error)
    end subroutine leave_one_rod

    !> Why one rod is poor: how far its torque exceeds all others, what the fit's errors make of the offset's, and what
    !> any estimator could know of it.
    subroutine examine_dominance(statement, error)
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: calibration
        real(dp) :: left_out(0:3, size(FRONT_CASES))    ! Part of the worst axis' variance
        integer :: i, rod

        statement%place = 'section 4.1'
        statement%claim = 'one axis alone is not good enough since the magnetic torque is no longer the dominating torque, '// &
            'the fitting attitude model is not good enough'
        statement%method = 'RMS of the rods'' torque over that of the sum of all others; Cramer-Rao bound of d, which knows '// &
            'all torques; condition of the information of d'
        do i = 1, size(FRONT_CASES)
            call find_calibration(FRONT_CASES(i), calibration, error)
            do rod = 0, 3
                if (rod > 0 .and. .not. allocated(error)) call leave_one_rod(calibration, rod, error)
                if (.not. allocated(error)) call add_dominance_row(calibration, rod, left_out(rod, i), statement, error)
                if (allocated(error)) return
            end do
        end do
        call judge_dominance(left_out(1:, :), statement)
    end subroutine examine_dominance

    !> A row of torque ratio, bound and condition.
    subroutine add_dominance_row(calibration, rod, left_out, statement, error)
        type(calibration_t), intent(in) :: calibration
        integer, intent(in) :: rod                      !! That is left, 0: both of the report
        real(dp), intent(out) :: left_out
        !! Part of the variance of the worst axis by all that the fit leaves out: other torques, scale factors, biases
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error

        type(statement_row_t) :: row
        type(simulator_t) :: simulator
        type(prediction_t) :: prediction
        type(case_bound_t) :: bound
        real(dp) :: of_rods, of_others, values(3), vectors(3, 3)
        integer :: k, worst

        left_out = 0
        row%case_name = trim(calibration%case%name)
        row%setting = 'both rods'
        if (rod > 0) row%setting = AXES(rod)//' rod alone'
        call new_simulator(calibration%case, simulator, error)
        if (.not. allocated(error)) call predict_errors(simulator, SINGLE_ALGORITHM, calibration%options, prediction, error)
        if (.not. allocated(error)) call bound_of_case(calibration%case, calibration%options, bound, error)
        if (.not. allocated(error)) call symmetric_eigen(bound%covariance/MILLIMETRE**2, values, vectors, error)
        if (allocated(error)) return
        worst = maxloc(prediction%rms, 1)
        left_out = (prediction%bias(worst)/prediction%rms(worst))**2
        of_rods = 0
        of_others = 0
        do k = 0, simulator%arc%steps
            associate (acting => simulator%arc%loads(k))
                of_rods = of_rods + sum(acting%torque_magnetic**2)
                of_others = of_others + sum((acting%torque_aero + acting%torque_solar + acting%torque_gravity)**2)
            end associate
        end do
        row%torque_ratio = sqrt(of_rods/of_others)
        row%predicted = [(sqrt(bound%covariance(k, k)), k=1, 3)]
        row%condition = maxval(values)/minval(values)
        statement%rows = [statement%rows, row]
    end subroutine add_dominance_row

    !> Rows in fours, as those of one rod. The reason does not hold where all that the fit leaves out is a small part of
    !> the errors, whatever the ratio of the torques.
    subroutine judge_dominance(left_out, statement)
        real(dp), intent(in) :: left_out(:, :)      !! Part of the worst axis' variance; (rods, places)
        type(statement_t), intent(inout) :: statement

        real(dp) :: loss
        integer :: i, k, weak, small

        loss = huge(loss)
        weak = 0
        do i = 1, size(statement%rows), 4
            do k = i + 1, i + 3
                if (statement%rows(k)%torque_ratio < DOMINATES) weak = weak + 1
                loss = min(loss, maxval(statement%rows(k)%predicted)/maxval(statement%rows(i)%predicted))
            end do
        end do
        small = count(left_out < SMALL_SHARE)
        statement%verdict = merge(HOLDS_NOT, merge(HOLDS, HOLDS_IN_PART, small == 0), small == size(left_out))
        select case (statement%verdict)
        case (HOLDS)
            statement%found = 'Holds:'
        case (HOLDS_NOT)
            statement%found = 'Does not hold:'
        case default
            statement%found = 'Holds for '//integer_text(size(left_out) - small)//' of '//integer_text(size(left_out))// &
                ' trials:'
        end select
        statement%found = trim(statement%found)//' what the fit leaves out (other torques, scale factors, biases) makes '// &
            'at most '//plain_text(100*maxval(left_out), '(f6.1)')//' % of the variance of one rod''s worst axis.'
        statement%details = 'One rod''s torque is more than '//plain_text(DOMINATES, '(f6.0)')//' times that of all others '// &
            'in '//integer_text(size(left_out) - weak)//' of '//integer_text(size(left_out))//' trials; in the rest the '// &
            'rod lies along the field. What is lacking is observability: with all torques known, the worst axis of one rod '// &
            'is still '//plain_text(loss, '(f8.1)')//' times that of two, or more.'
    end subroutine judge_dominance

    !> What the curvature of drag and light, and the density wave, do to the errors.
    subroutine examine_curved_force(settings, statement, error, progress)
        type(settings_t), intent(in) :: settings
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(calibration_t) :: calibration
        integer :: i

        statement%place = 'section 5.3'
        statement%claim = 'the non-linear non-gravitational acceleration has only a small impact upon the estimation '// &
            'accuracy when it is fitted by the linear function'
        statement%method = 'drag with the density wave and light as they are, without the wave, and their '// &
            'least-squares line in their place; '//COMBINED_ALGORITHM
        call expect_pieces(progress, 3*size(REPORT_CASE_NAMES)*settings%runs, 'runs')
        do i = 1, size(REPORT_CASE_NAMES)
            call find_calibration(REPORT_CASE_NAMES(i), calibration, error)
            if (.not. allocated(error)) call add_row(settings, calibration, COMBINED_ALGORITHM, 'curved', statement, &
                                                     error, progress)
            calibration%case%density_wave = density_wave_t()
            calibration%case%density_wave_random = .false.
            if (.not. allocated(error)) call add_row(settings, calibration, COMBINED_ALGORITHM, 'no wave', statement, &
                                                     error, progress)
            if (.not. allocated(error)) call add_row(settings, calibration, COMBINED_ALGORITHM, 'straight line', &
                                                     statement, error, progress, error_switches_t(curved_force=.false.))
            if (allocated(error)) return
        end do
        call judge_curved_force(statement)
    end subroutine examine_curved_force

    !> Rows in threes: the part of the variance that goes with the curvature, and that which stays without the wave.
    subroutine judge_curved_force(statement)
        type(statement_t), intent(inout) :: statement

        real(dp), dimension(3, size(statement%rows)/3) :: share, smooth
        integer :: i, small

        do i = 1, size(share, 2)
            associate (curved => statement%rows(3*i - 2), no_wave => statement%rows(3*i - 1), line => statement%rows(3*i))
                share(:, i) = 1 - (line%predicted/curved%predicted)**2
                smooth(:, i) = 1 - (line%predicted/no_wave%predicted)**2
            end associate
        end do
        small = count(share < SMALL_SHARE)
        statement%verdict = merge(HOLDS, merge(HOLDS_NOT, HOLDS_IN_PART, small == 0), small == size(share))
        select case (statement%verdict)
        case (HOLDS)
            statement%found = 'Holds:'
        case (HOLDS_NOT)
            statement%found = 'Does not hold:'
        case default
            statement%found = 'Holds for '//integer_text(small)//' of '//integer_text(size(share))//' components:'
        end select
        statement%found = trim(statement%found)//' the curvature makes '//plain_text(100*minval(share), '(f6.0)')//' to '// &
            plain_text(100*maxval(share), '(f6.0)')//' % of their variance, on average '// &
            plain_text(100*sum(share)/size(share), '(f6.0)')//' %.'
        statement%details = 'Without the density wave, whose size and period the report does not give, the curvature '// &
            'changes it by '//plain_text(100*minval(smooth), '(f6.0)')//' to '//plain_text(100*maxval(smooth), '(f6.0)')// &
            ' %: of smooth drag and light the statement holds.'
    end subroutine judge_curved_force

    !> Longer arcs with the report's rods and algorithm.
    subroutine examine_arc_length(settings, statement, error, progress)
        type(settings_t), intent(in) :: settings
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(calibration_t) :: calibration
        integer :: i, k

        statement%place = 'section 4.1'
        statement%claim = 'longer arcs do not yield good results, since the non-gravitational acceleration is no longer '// &
            'linear: 60 s are the trade-off'
        statement%method = 'the report''s rods for 60 to 300 s; '//SINGLE_ALGORITHM
        call expect_pieces(progress, size(FRONT_CASES)*size(LENGTHS)*settings%runs, 'runs')
        do i = 1, size(FRONT_CASES)
            call find_calibration(FRONT_CASES(i), calibration, error)
            if (allocated(error)) return
            do k = 1, size(LENGTHS)
                calibration%case%duration = LENGTHS(k)
                associate (rods => calibration%case%satellite%rods)
                    rods%activations(:rods%count)%stop = LENGTHS(k)
                end associate
                call add_row(settings, calibration, SINGLE_ALGORITHM, integer_text(nint(LENGTHS(k)))//' s', statement, &
                             error, progress)
                if (allocated(error)) return
            end do
        end do
        call judge_arc_length(statement)
    end subroutine examine_arc_length

    !> Rows by place and length: at which length the worst axis is best, and how many components are worse again in the
    !> longest arc than in a shorter one.
    subroutine judge_arc_length(statement)
        type(statement_t), intent(inout) :: statement

        real(dp) :: worst(size(LENGTHS))
        integer :: i, k, n, best, axis, turns, shortest
        character(240) :: lengths_text

        lengths_text = ''
        turns = 0
        shortest = 0
        n = size(statement%rows)/size(LENGTHS)
        do i = 1, n
            do k = 1, size(LENGTHS)
                worst(k) = maxval(statement%rows((i - 1)*size(LENGTHS) + k)%predicted)
            end do
            best = minloc(worst, 1)
            if (best == 1) shortest = shortest + 1
            if (i > 1) lengths_text = trim(lengths_text)//','
            lengths_text = trim(lengths_text)//' '//integer_text(nint(LENGTHS(best)))//' s in '// &
                trim(statement%rows(i*size(LENGTHS))%case_name)//' ('//mm_text(worst(best))//' mm; at 60 s '// &
                mm_text(worst(1))//')'
            do axis = 1, 3
                best = minloc([(statement%rows((i - 1)*size(LENGTHS) + k)%predicted(axis), k=1, size(LENGTHS))], 1)
                if (best < size(LENGTHS)) turns = turns + 1
            end do
        end do
        if (shortest == n) then
            statement%verdict = HOLDS
            statement%found = 'Holds: no longer arc is better.'
        else
            statement%verdict = merge(HOLDS_NOT, HOLDS_IN_PART, turns == 0)
            statement%found = 'Holds in part: '//integer_text(turns)//' of '//integer_text(3*n)//' components are worse '// &
                'again at 300 s than at a shorter arc, so the trade-off exists; it lies at 60 s in '// &
                integer_text(shortest)//' of '//integer_text(n)//' places.'
            if (turns == 0) statement%found = 'Does not hold: no component is worse at 300 s than at a shorter arc.'
            statement%details = 'The worst axis is best at'//trim(lengths_text)//'.'
        end if
    end subroutine judge_arc_length

    !> The weights of star camera and accelerometer in ASCFEST.
    subroutine examine_weights(settings, statement, error, progress)
        type(settings_t), intent(in) :: settings
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        real(dp), parameter :: STAR(5) = [90.0_dp, 1e-4_dp, 1e-8_dp, 1e-11_dp, 1e-16_dp]
        real(dp), parameter :: ACC(3, 3) = reshape([1.0_dp, 1.0_dp, 1.0_dp, 100.0_dp, 1.0_dp, 100.0_dp, &
                                                    0.1_dp, 100.0_dp, 1.0_dp], [3, 3])
        character(8), parameter :: STAR_TEXT(5) = [character(8) :: '90', '1e-4', '1e-8', '1e-11', '1e-16']
        character(12), parameter :: ACC_TEXT(3) = [character(12) :: '1 1 1', '100 1 100', '0.1 100 1']
        type(calibration_t) :: calibration
        type(estimation_options_t) :: options
        real(dp) :: change, range
        integer :: i, n

        statement%place = 'section 7.2(1)'
        statement%claim = 'the estimation accuracy is relatively highly dependent on the weight for the accelerometer '// &
            'data and star cameras data'
        statement%method = 'weights of the star camera, then of the accelerometer''s axes; '//COMBINED_ALGORITHM
        call expect_pieces(progress, (size(STAR) + size(ACC_TEXT))*settings%runs, 'runs')
        call find_calibration('front-1', calibration, error)
        if (allocated(error)) return
        options = calibration%options
        do i = 1, size(STAR)
            calibration%options%combined_star_camera_weight = STAR(i)
            call add_row(settings, calibration, COMBINED_ALGORITHM, 'star camera '//trim(STAR_TEXT(i)), statement, &
                         error, progress)
            if (allocated(error)) return
        end do
        calibration%options = options
        do i = 1, size(ACC_TEXT)
            calibration%options%accelerometer_weight = ACC(:, i)
            call add_row(settings, calibration, COMBINED_ALGORITHM, 'accelerometer '//trim(ACC_TEXT(i)), statement, &
                         error, progress)
            if (allocated(error)) return
        end do
        n = size(STAR)
        associate (rows => statement%rows)
            change = maxval([(abs(rows(i)%predicted/rows(1)%predicted - 1), i=2, n - 1)])
            range = maxval([(rows(i)%predicted/rows(1)%predicted, i=n + 1, size(rows))])
        end associate
        if (change < NO_CHANGE .and. range > DEPENDENCE) then
            statement%verdict = HOLDS_IN_PART
            statement%found = 'Holds for the accelerometer only: '
        else if (range > DEPENDENCE) then
            statement%verdict = HOLDS
            statement%found = 'Holds: '
        else if (change >= NO_CHANGE) then
            statement%verdict = HOLDS_IN_PART
            statement%found = 'Holds for the star camera only: '
        else
            statement%verdict = HOLDS_NOT
            statement%found = 'Does not hold: '
        end if
        statement%found = trim(statement%found)//' its weights change the errors by a factor of up to '// &
            plain_text(range, '(f6.1)')//'; that of the star camera, from 90 down to 1e-11, by '// &
            plain_text(change, '(es8.1)')//' of them at most.'
    end subroutine examine_weights

    !> The accuracy of section 7.1(3) in the best case of each axis.
    subroutine examine_accuracy(settings, statement, error, progress)
        type(settings_t), intent(in) :: settings
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(calibration_t) :: calibration
        real(dp) :: best(3)
        integer :: i, axis, place(3)

        statement%place = 'sections 6.2 and 7.1(3)'
        statement%claim = 'the accuracy can be better than 0.02 mm for x, 0.01 mm for y and 0.02 mm for z, in the best '// &
            'chance of each axis'
        statement%method = 'the cases of the front satellite; '//COMBINED_ALGORITHM
        call expect_pieces(progress, size(FRONT_CASES)*settings%runs, 'runs')
        do i = 1, size(FRONT_CASES)
            call find_calibration(FRONT_CASES(i), calibration, error)
            if (.not. allocated(error)) call add_row(settings, calibration, COMBINED_ALGORITHM, 'as in the report', &
                                                     statement, error, progress)
            if (allocated(error)) return
        end do
        do axis = 1, 3
            place(axis) = minloc(statement%rows%predicted(axis), 1)
            best(axis) = statement%rows(place(axis))%predicted(axis)
        end do
        associate (met => count(best <= BEST_ACCURACY))
            statement%verdict = merge(HOLDS, merge(HOLDS_NOT, HOLDS_IN_PART, met == 0), met == 3)
            statement%found = trim(merge('Holds:        ', 'Does not hold:', met == 3))//' by theory'
        end associate
        do axis = 1, 3
            statement%found = trim(statement%found)//' '//AXES(axis)//' '//mm_text(best(axis))//' mm in '// &
                trim(statement%rows(place(axis))%case_name)//merge('.', ',', axis == 3)
        end do
    end subroutine examine_accuracy

    !> Why the full state is not singular: the normal matrix of the attitude, full and reduced, and the full one
    !> when an observation counts only across its own quaternion, as its true covariance would have it.
    subroutine examine_condition(statement, error)
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error

        character(40), parameter :: SETTINGS(3) = [character(40) :: 'full state (FDE)', 'reduced state (RDE)', &
                                                   'full state weighed across q only']
        type(statement_row_t) :: row
        type(calibration_t) :: calibration
        real(dp) :: full, reduced, across
        integer :: i, k

        statement%place = 'section 4.6.1'
        statement%claim = 'the full state may cause a singular covariance matrix, since only three of the four '// &
            'quaternion components are independent; in several simulations there is no singular problem'
        statement%method = 'condition of the attitude''s normal matrix with unit diagonal, exact observations'
        do i = 1, size(FRONT_CASES)
            call find_calibration(FRONT_CASES(i), calibration, error)
            if (allocated(error)) return
            do k = 1, size(SETTINGS)
                row = statement_row_t(case_name=calibration%case%name, setting=SETTINGS(k))
                call condition_of(calibration, k, row%condition, error)
                if (allocated(error)) return
                statement%rows = [statement%rows, row]
            end do
        end do
        full = maxval(statement%rows(1::3)%condition)
        reduced = maxval(statement%rows(2::3)%condition)
        across = minval(statement%rows(3::3)%condition)
        statement%verdict = merge(HOLDS, HOLDS_NOT, full < REGULAR .and. across > SINGULAR)
        statement%found = trim(merge('Holds:        ', 'Does not hold:', statement%verdict == HOLDS))// &
            ' condition of the full state to '//plain_text(full, '(f10.1)')//', of the reduced one to '// &
            plain_text(reduced, '(f10.1)')//'.'
        statement%details = 'With unit weights every observation determines the length of q as well '// &
            'as its direction; weighed by its own covariance, which has rank three, the full state is singular '// &
            '(condition '//plain_text(across, '(es9.1)')//' and more).'
    end subroutine examine_condition

    !> Condition of the normal matrix of kind 1 full, 2 reduced, 3 full with every observation projected across its
    !> quaternion: the ratio of the largest and the least eigenvalue, at the solution.
    subroutine condition_of(calibration, kind, condition, error)
        type(calibration_t), intent(in) :: calibration
        integer, intent(in) :: kind
        real(dp), intent(out) :: condition
        type(error_t), allocatable, intent(out) :: error

        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(fitting_data_t) :: data
        type(attitude_problem_t) :: problem
        type(batch_settings_t) :: settings
        type(batch_solution_t) :: batch
        real(dp), allocatable :: partials(:, :), residuals(:), weights(:), normal(:, :), values(:), vectors(:, :), scale(:)
        real(dp) :: q(4)
        integer :: i, n

        condition = 0
        call new_simulator(calibration%case, simulator, error)
        if (allocated(error)) return
        call observe_without_noise(simulator, density_wave_t(), observations)
        call preprocess(observations, calibration%options, data, error)
        if (allocated(error)) return
        call prepare_attitude(observations%knowledge, data, kind == 2, problem)
        call process_batch(problem, settings, batch, error)
        if (allocated(error)) return
        n = problem%attitude_parameters()
        allocate (partials(n, problem%observations), residuals(problem%observations), weights(problem%observations), &
                  values(n), vectors(n, n))
        call problem%linearise(partials, residuals, weights, error)
        if (allocated(error)) return
        if (kind == 3) then
            do i = 1, size(data%attitude_epoch)
                associate (block => partials(:, 4*i - 3:4*i))
                    q = normalised(matmul(problem%quaternion, block(:4, :)))    ! of the fit, Phi_11 q(t0)
                    block = block - spread(matmul(block, q), 2, 4)*spread(q, 1, n)
                end associate
            end do
        end if
        normal = matmul(partials, transpose(partials))
        scale = [(1/sqrt(normal(i, i)), i=1, n)]
        normal = normal*spread(scale, 1, n)*spread(scale, 2, n)
        call symmetric_eigen(normal, values, vectors, error)
        if (allocated(error)) return
        condition = maxval(values)/max(minval(values), epsilon(1.0_dp)*maxval(values))
    end subroutine condition_of

    !> Two or three places together: the information of their bounds added, for both satellites.
    subroutine examine_two_steps(statement, error)
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: SETS(3, 7) = reshape([1, 0, 0, 2, 0, 0, 3, 0, 0, 1, 2, 0, 1, 3, 0, 2, 3, 0, 1, 2, 3], [3, 7])
        character(5), parameter :: SATELLITES(2) = [character(5) :: 'front', 'back']
        type(statement_row_t) :: row
        type(calibration_t) :: calibration
        type(case_bound_t) :: bound
        real(dp) :: information(3, 3, 3), covariance(3, 3)
        integer :: s, i, k, axis, best, single

        statement%place = 'section 6.2'
        statement%claim = 'the calibration can be done in two steps: y and z at one place, x at the other'
        statement%method = 'Cramer-Rao bounds of the report''s cases, their information added: theory of a joint solution'
        do s = 1, size(SATELLITES)
            do i = 1, 3
                call find_calibration(trim(SATELLITES(s))//'-'//integer_text(i), calibration, error)
                if (.not. allocated(error)) call bound_of_case(calibration%case, calibration%options, bound, error)
                if (allocated(error)) return
                information(:, :, i) = inverse_3x3(bound%covariance/MILLIMETRE**2)
            end do
            do k = 1, size(SETS, 2)
                row = statement_row_t(case_name=trim(SATELLITES(s)), setting='case')
                covariance = 0
                do i = 1, 3
                    if (SETS(i, k) == 0) cycle
                    if (i > 1) row%setting = trim(row%setting)//' +'
                    row%setting = trim(row%setting)//' '//integer_text(SETS(i, k))
                    covariance = covariance + information(:, :, SETS(i, k))
                end do
                covariance = inverse_3x3(covariance)
                row%predicted = [(sqrt(covariance(axis, axis))*MILLIMETRE, axis=1, 3)]
                statement%rows = [statement%rows, row]
            end do
        end do
        ! the front satellite, as in the report
        single = minloc([(maxval(statement%rows(k)%predicted), k=1, 3)], 1)
        best = 3 + minloc([(maxval(statement%rows(k)%predicted), k=4, 6)], 1)
        associate (two => statement%rows(best))
            statement%verdict = merge(HOLDS, HOLDS_NOT, all(two%predicted <= BEST_ACCURACY))
            statement%found = trim(merge('Holds:        ', 'Does not hold:', statement%verdict == HOLDS))// &
                ' by theory the front satellite''s '//trim(two%setting)//' together have '//mm_text(two%predicted(1))//', '// &
                mm_text(two%predicted(2))//' and '//mm_text(two%predicted(3))//' mm, the best single one, '// &
                trim(statement%rows(single)%setting)//', at its worst '// &
                mm_text(maxval(statement%rows(single)%predicted))//' mm.'
        end associate
    end subroutine examine_two_steps

    !> How many stars a camera has before it, and what a choice of those in use gains.
    subroutine examine_stars(statement, error, progress)
        type(statement_t), intent(inout) :: statement
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(statement_row_t) :: row
        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        type(star_catalogue_t) :: catalogue
        real(dp) :: mean
        real(dp) :: gain(size(REPORT_CASE_NAMES))       ! Part of the sigma about the boresight that goes
        integer :: i, k, range(2), seen(2)

        statement%place = 'section 3.3.2'
        statement%claim = 'every frame can contain roughly 70 stars, at least 20 will be observed; an optimal choice of 20 '// &
            'is preferred to increase the accuracy, the first 20 are taken'
        statement%method = 'stars of the catalogue in the used head''s field; noise of its attitude by QUEST''s '// &
            'covariance, mean over the frames of the arc; the best 20 have the least trace of it'
        range = [huge(1), 0]
        mean = 0
        do i = 1, size(REPORT_CASE_NAMES)
            call find_calibration(REPORT_CASE_NAMES(i), calibration, error)
            if (.not. allocated(error)) call case_star_catalogue(calibration%case, catalogue, error)
            if (allocated(error)) return
            call tell(progress, trim(statement%name)//', '//trim(calibration%case%name))
            mean = calibration%case%satellite%star_camera%mean_stars_in_field(catalogue)
            do k = 1, size(STAR_SELECTIONS)
                calibration%case%satellite%star_camera%selection = STAR_SELECTIONS(k)
                call new_simulator(calibration%case, simulator, error)
                if (allocated(error)) return
                associate (camera => calibration%case%satellite%star_camera, head => calibration%case%operator%head)
                    row = statement_row_t(case_name=calibration%case%name, setting=trim(STAR_SELECTIONS(k))//' '// &
                                          integer_text(camera%star_count)//' stars', &
                                          camera_sigma=simulator%star_camera_sigma)
                    call count_stars(camera, catalogue, simulator%arc, head, row%stars, seen)
                end associate
                statement%rows = [statement%rows, row]
            end do
            range = [min(range(1), seen(1)), max(range(2), seen(2))]
            associate (first => statement%rows(2*i - 1)%camera_sigma, best => statement%rows(2*i)%camera_sigma)
                gain(i) = 1 - best(3)/first(3)
            end associate
        end do
        call judge_stars(mean, range, gain, statement)
    end subroutine examine_stars

    !> The stars in a head's field over an arc.
    subroutine count_stars(camera, catalogue, arc, head, mean, range)
        type(star_camera_t), intent(in) :: camera
        type(star_catalogue_t), intent(in) :: catalogue
        type(truth_arc_t), intent(in) :: arc
        integer, intent(in) :: head
        real(dp), intent(out) :: mean
        integer, intent(out) :: range(2)        !! Fewest and most

        integer :: i
        integer, allocatable :: stars(:)

        stars = [(camera%stars_in_field(catalogue, arc%state(ATTITUDE, i), head), i=1, arc%steps, &
                  nint(camera%sampling_interval/arc%interval))]
        mean = real(sum(stars), dp)/size(stars)
        range = [minval(stars), maxval(stars)]
    end subroutine count_stars

    !> The number and the choice are two halves of the statement.
    subroutine judge_stars(mean, range, gain, statement)
        real(dp), intent(in) :: mean            !! Stars in a field, over all attitudes
        integer, intent(in) :: range(2)         !! In the cases, fewest and most
        real(dp), intent(in) :: gain(:)         !! Of sigma about the boresight by the best stars, each case
        type(statement_t), intent(inout) :: statement

        character(:), allocatable :: found
        logical :: so_many, better
        integer :: i

        so_many = abs(mean/STARS_OF_REPORT - 1) <= ROUGHLY .and. range(1) >= STARS_AT_LEAST
        better = all(gain > 0)
        statement%verdict = merge(HOLDS, merge(HOLDS_IN_PART, HOLDS_NOT, so_many .or. better), so_many .and. better)
        found = 'a field has '//plain_text(mean, '(f6.1)')//' stars on average of all attitudes, '// &
            integer_text(range(1))//' to '//integer_text(range(2))//' in the cases; the best '// &
            integer_text(STARS_AT_LEAST)//' lower sigma about the boresight by '//plain_text(100*minval(gain), '(f6.0)')// &
            ' to '//plain_text(100*maxval(gain), '(f6.0)')//' %.'
        select case (statement%verdict)
        case (HOLDS)
            statement%found = 'Holds: '//found
        case (HOLDS_NOT)
            statement%found = 'Does not hold: '//found
        case default
            statement%found = 'Holds for the '//trim(merge('number', 'choice', so_many))//' only: '//found
        end select
        statement%details = 'Across the boresight the choice gains '//plain_text(100*(1 - &
            sum([(sum(statement%rows(i)%camera_sigma(:2)), i=2, size(statement%rows), 2)])/ &
            sum([(sum(statement%rows(i)%camera_sigma(:2)), i=1, size(statement%rows), 2)])), '(f6.0)')// &
            ' % on average. The offset does not feel it: the star camera''s noise is hardly a part of its error (Figure 6.5).'
    end subroutine judge_stars

    !> A number without what stands before and behind its digits. Before the functions whose length it tells.
    pure function plain_field(value, form) result(text)
        real(dp), intent(in) :: value
        character(*), intent(in) :: form            !! Of Fortran, at most 16 columns
        character(16) :: text

        integer :: last

        write (text, form) value
        text = adjustl(text)
        last = len_trim(text)
        if (index(text, '.') == last) text(last:) = ''
    end function plain_field

    !> Millimetres with two significant digits and more.
    pure function mm_text(value) result(text)
        real(dp), intent(in) :: value               !! m
        character(len_trim(plain_field(value/MILLIMETRE, '(f10.4)'))) :: text

        text = plain_field(value/MILLIMETRE, '(f10.4)')
    end function mm_text

    pure function plain_text(value, form) result(text)
        real(dp), intent(in) :: value
        character(*), intent(in) :: form            !! As for plain_field
        character(len_trim(plain_field(value, form))) :: text

        text = plain_field(value, form)
    end function plain_text

    !> The rows of statements. For people it has the columns that some row fills; what a row has not stays empty.
    function statement_table(statements) result(table)
        type(statement_t), intent(in) :: statements(:)
        type(data_table_t) :: table

        character(8) :: errors, condition, ratio, stars, sigma, runs    ! Formats; blank: no column for people
        integer :: i, k

        errors = ''
        condition = ''
        ratio = ''
        stars = ''
        sigma = ''
        runs = ''
        do i = 1, size(statements)
            do k = 1, size(statements(i)%rows)
                associate (row => statements(i)%rows(k))
                    if (row%runs > 0) runs = 'f10.4'
                    if (any(row%predicted > 0)) errors = 'f10.4'
                    if (row%condition > 0) condition = 'es10.2'
                    if (row%torque_ratio > 0) ratio = 'f8.1'
                    if (row%stars > 0) stars = 'f8.1'
                    if (any(row%camera_sigma > 0)) sigma = 'f8.3'
                end associate
            end do
        end do
        call table%column('statement')
        call table%column('case', 'a', 'case')
        call table%column('setting', 'a', 'setting')
        call table%column('runs')
        call table%column('rms_x_mm', trim(runs), 'RMS of the runs, mm|x')
        call table%column('rms_y_mm', trim(runs), '|y')
        call table%column('rms_z_mm', trim(runs), '|z')
        call table%column('predicted_x_mm', trim(errors), 'theory, mm|x')
        call table%column('predicted_y_mm', trim(errors), '|y')
        call table%column('predicted_z_mm', trim(errors), '|z')
        call table%column('condition', trim(condition), '|condition')
        call table%column('torque_ratio', trim(ratio), '|torque ratio')
        call table%column('stars', trim(stars), '|stars')
        call table%column('sigma_x_arcsec', trim(sigma), 'sigma, arcsec|x')
        call table%column('sigma_y_arcsec', trim(sigma), '|y')
        call table%column('sigma_boresight_arcsec', trim(sigma), '|boresight')
        do i = 1, size(statements)
            do k = 1, size(statements(i)%rows)
                associate (row => statements(i)%rows(k))
                    call table%add(statements(i)%name)
                    call table%add(row%case_name)
                    call table%add(row%setting)
                    call table%add(row%runs)
                    call add_known(row%rms/MILLIMETRE, row%runs > 0)
                    call add_known(row%predicted/MILLIMETRE, any(row%predicted > 0))
                    call add_known([row%condition], row%condition > 0)
                    call add_known([row%torque_ratio], row%torque_ratio > 0)
                    call add_known([row%stars], row%stars > 0)
                    call add_known(row%camera_sigma/ARCSECOND, any(row%camera_sigma > 0))
                end associate
            end do
        end do

    contains

        subroutine add_known(values, known)
            real(dp), intent(in) :: values(:)
            logical, intent(in) :: known

            integer :: j

            do j = 1, size(values)
                if (known) then
                    call table%add(values(j))
                else
                    call table%add_nothing()
                end if
            end do
        end subroutine add_known
    end function statement_table
end module gracecg_studies_statements
