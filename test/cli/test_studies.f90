!> The studies: error sources, loss of the magnetometer, trim, and campaigns on the command line.
module test_studies
    use vocabulary
    use calibrations
    use gracecg_files_file, only: text_file_t, read_text_file
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_simulation_simulator, only: disturbance_at
    use gracecg_simulation_operator_errors, only: ROD_DELAY
    use gracecg_simulation_accelerometer, only: pmc_acceleration_t
    use gracecg_studies_monte_carlo, only: monte_carlo_t, run_monte_carlo, error_statistics_t, statistics_of, &
        prediction_t, predict_errors
    use gracecg_studies_error_sources, only: study_switches, STUDY_NAMES
    use gracecg_studies_magnetometer_loss, only: field_model_t, predict_field_model, MODEL_FIELD_ERROR
    use gracecg_estimation_report_options, only: report_options
    use gracecg_estimation_action, only: DO_NOT_USE, WANTED_ACCURACY
    use gracecg_studies_trim, only: trim_settings_t, trim_round_t, trim_offset
    use command_fixture
    implicit none
    private
    public :: collect_studies

contains

    subroutine collect_studies(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('switches-leave-the-others-alone', test_switches), &
                    new_unittest('straight-force', test_straight_force), &
                    new_unittest('figure-6.5', test_error_sources), &
                    new_unittest('field-model', test_field_model), &
                    new_unittest('figure-6.6', test_magnetometer_loss), &
                    new_unittest('labels-of-the-back-satellite', test_back_labels), &
                    new_unittest('trim-within-sigma', test_trim), &
                    new_unittest('trim-with-its-own-threshold', test_chosen_threshold), &
                    new_unittest('trim-without-noise', test_exact_trim), &
                    new_unittest('merge-on-the-command-line', test_merge), &
                    new_unittest('hardly-observable', test_hardly_observable), &
                    new_unittest('wrong-usage', test_wrong_usage)]
    end subroutine collect_studies

    subroutine prepare(name, study, simulator)
        character(*), intent(in) :: name            !! Of the case
        character(*), intent(in) :: study           !! Of STUDY_NAMES
        type(simulator_t), intent(out) :: simulator
        type(case_t) :: case

        call take_case(name, case)
        call make_simulator(case, study_switches(study), simulator)
    end subroutine prepare

    !> A source that is off changes its own instrument and no other.
    subroutine test_switches(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(observation_set_t) :: all_noise, off
        logical :: same(3)
        integer :: i, k

        do i = 1, size(STUDY_NAMES)
            call prepare('front-1', STUDY_NAMES(i), simulator)
            call make_observations(simulator, 1, 1, off, only_used_head=.true.)
            if (i == 1) all_noise = off
            same = [all(abs(off%acceleration - all_noise%acceleration) <= 0), &
                    all(abs(off%quaternion - all_noise%quaternion) <= 0), &
                    all(abs(off%field - all_noise%field) <= 0)]
            select case (STUDY_NAMES(i))
            case ('all-noise')
                call check(error, all(same))
            case ('linear-ng', 'no-acc-noise')
                call check(error, all(same .eqv. [.false., .true., .true.]), STUDY_NAMES(i))
            case ('no-sca-noise')
                call check(error, all(same .eqv. [.true., .false., .true.]), STUDY_NAMES(i))
            case default
                call check(error, all(same .eqv. [.true., .true., .false.]), STUDY_NAMES(i))
                call check(error, all([(norm2(off%field(:, k) - simulator%arc%loads(10*k)%field), &
                                        k=1, 60)] <= 0), 'the true field')
            end select
        end do
    end subroutine test_switches

    !> Second differences vanish; what is taken away has neither mean nor slope.
    subroutine test_straight_force(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: curved, straight
        type(pmc_acceleration_t) :: a
        real(dp) :: before(3, 0:600), after(3, 0:600), difference(3, 0:600)
        integer :: k, i

        call prepare('front-1', 'all-noise', curved)
        call prepare('front-1', 'linear-ng', straight)
        do k = 0, 600
            a = disturbance_at(curved%case, curved%arc, density_wave_t(), k)
            before(:, k) = a%non_gravitational
            a = disturbance_at(straight%case, straight%arc, density_wave_t(), k)
            after(:, k) = a%non_gravitational
        end do
        call check(error, maxval(abs(after(:, :598) - 2*after(:, 1:599) + after(:, 2:))) < 1e-20_dp)
        difference = before - after
        call check(error, maxval(abs(difference)) > 1e-11_dp, 'there is something to straighten')
        call check(error, maxval(abs(sum(difference, 2))) < 1e-9_dp*sum(abs(difference)), 'mean')
        call check(error, maxval(abs([(sum(difference(k, :)*[(real(i - 300, dp), i=0, 600)]), k=1, 3)])) < &
                   1e-9_dp*300*sum(abs(difference)), 'slope')
    end subroutine test_straight_force

    !> By theory, mm: the values of Figure 6.5 lie within its axes (1.5e-4, 6e-5, 1e-4 m; 10 % are
    !> allowed, since 15 runs scatter by 18 %); taking a source away never makes the error larger by
    !> more than the correlation of biases allows; the noise of the accelerometer is the largest source, but in z, where
    !> by Table 6.1 itself something else must be as large: its 0.078 to 0.111 mm are 1.6 to 2.3 times what the noise does.
    subroutine test_error_sources(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: AXIS_LIMIT(3) = [0.15_dp, 0.06_dp, 0.1_dp]
        type(simulator_t) :: simulator
        type(prediction_t) :: prediction
        type(error_t), allocatable :: failure
        real(dp) :: rms(3, size(STUDY_NAMES))
        integer :: i

        do i = 1, size(STUDY_NAMES)
            call prepare('front-1', STUDY_NAMES(i), simulator)
            call predict_errors(simulator, 'ascfest', estimation_options_t(), prediction, failure)
            if (failed(error, failure)) return
            rms(:, i) = prediction%rms/MILLIMETRE
            call check(error, all(rms(:, i) < 1.1_dp*AXIS_LIMIT), STUDY_NAMES(i))
            call check(error, all(rms(:, i) < 1.001_dp*rms(:, 1)), STUDY_NAMES(i))
        end do
        do i = 1, size(STUDY_NAMES)
            call check(error, all(rms(:2, 3) <= rms(:2, i)), 'accelerometer noise against '//STUDY_NAMES(i))
        end do
        call check(error, all(rms(3, [2, 3]) < minval(rms(3, [1, 4, 5]))), 'noise and curved drag in z')
    end subroutine test_error_sources

    !> The model's error is constant over the arc, differs from run to run and has the asked size:
    !> 300 numbers, whose variance scatters by 8 %.
    subroutine test_field_model(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(observation_set_t) :: observations
        type(field_model_t) :: model
        real(dp) :: errors(3, 60), drawn(3, 100)
        integer :: run, i

        call prepare('front-2', 'all-noise', simulator)
        call make_observations(simulator, 1, 1, observations, only_used_head=.true.)
        do run = 1, 100
            call model%alter(simulator, 1_i8, run, observations)
            do i = 1, 60
                errors(:, i) = observations%field(:, i) - simulator%arc%loads(10*i)%field
            end do
            call check(error, maxval(abs(errors - spread(errors(:, 1), 2, 60))) < 1e-19_dp, 'constant')
            drawn(:, run) = errors(:, 1)/MODEL_FIELD_ERROR
        end do
        call check(error, sum(drawn**2)/300, 1.0_dp, thr=0.25_dp)
    end subroutine test_field_model

    !> "The impact on the estimation accuracy is very small": by theory below 3 % where the error is
    !> large (case 2 x, and y and z of case 3). Our x of case 3, 12 micrometres, becomes 18. 100 runs
    !> agree with theory (standard error of an RMS 7 %).
    subroutine test_magnetometer_loss(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(prediction_t) :: prediction
        type(monte_carlo_t) :: results
        type(error_statistics_t) :: statistics
        type(error_t), allocatable :: failure
        real(dp) :: rms(3)
        integer :: i

        call prepare('front-2', 'all-noise', simulator)
        call predict_errors(simulator, 'ascrest', estimation_options_t(), prediction, failure)
        if (.not. allocated(failure)) call predict_field_model(simulator, 'ascrest', estimation_options_t(), &
                                                               MODEL_FIELD_ERROR, rms, failure)
        if (failed(error, failure)) return
        call check(error, all(rms < 1.03_dp*prediction%rms), 'case 2')

        call prepare('front-3', 'all-noise', simulator)
        call predict_errors(simulator, 'assest-fde', estimation_options_t(), prediction, failure)
        if (.not. allocated(failure)) call predict_field_model(simulator, 'assest-fde', estimation_options_t(), &
                                                               MODEL_FIELD_ERROR, rms, failure)
        if (.not. allocated(failure)) &
            call run_monte_carlo(simulator, 'assest-fde', estimation_options_t(), 1_i8, [(i, i=1, 100)], 2, &
                                 results, failure, field_model_t())
        if (failed(error, failure)) return
        call check(error, all(rms(2:3) < 1.03_dp*prediction%rms(2:3)), 'case 3')
        call check(error, rms(1) > 1.2_dp*prediction%rms(1), 'x feels the field')
        statistics = statistics_of(results%offset, simulator%case%satellite%offset)
        call check(error, maxval(abs(statistics%rms/rms - 1)) < 0.22_dp, 'theory')
    end subroutine test_magnetometer_loss

    !> The true offset that remains is what the estimates err by.
    subroutine test_trim(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(trim_settings_t) :: settings
        type(trim_round_t), allocatable :: rounds(:)
        type(error_t), allocatable :: failure
        integer :: n

        call take_case('front-3', case)
        settings%threshold = 0.15_dp*MILLIMETRE
        call trim_offset(case, 'assest-fde', estimation_options_t(), settings, rounds, failure)
        if (failed(error, failure)) return
        n = size(rounds)
        call check(error, n > 1 .and. n < settings%rounds)
        call check(error, all(abs(rounds(n)%estimate) < settings%threshold))
        call check(error, all(abs(rounds(n)%offset) < settings%threshold + 4*rounds(n)%sigma))
        call check(error, any(abs(rounds(n - 1)%estimate) >= settings%threshold), 'no round too many')
        case%operator%value(:3, ROD_DELAY) = 0.5_dp     ! contradicted: no masses are moved, and no second round
        call trim_offset(case, 'optimal', estimation_options_t(), settings, rounds, failure)
        if (failed(error, failure)) return
        call check(error, size(rounds) == 1 .and. rounds(1)%action%kind == DO_NOT_USE, 'stops at a contradiction')
    end subroutine test_trim

    !> Without --threshold-mm the command takes three times the sigma of each axis, says so, and ends at the first
    !> round that is below on all axes.
    subroutine test_chosen_threshold(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(trim_settings_t) :: settings
        type(trim_round_t), allocatable :: rounds(:)
        type(error_t), allocatable :: failure
        character(:), allocatable :: output, messages
        integer :: n

        call take_case('front-3', case)
        settings%by_sigma = .true.
        call trim_offset(case, 'assest-fde', report_options('front-3'), settings, rounds, failure)
        if (failed(error, failure)) return
        n = size(rounds)
        call check(error, n > 1 .and. all(abs(rounds(n)%estimate) < 3*rounds(n)%sigma))
        call check(error, any(abs(rounds(n - 1)%estimate) >= 3*rounds(n - 1)%sigma))
        call succeeds(error, 'trim front-3', output, messages)
        call check(error, index(output, 'three times the sigma of each axis') > 0 .and. index(messages, 'warning') == 0, output)
        call check_says(error, output, 'x: converged ... z: converged')
    end subroutine test_chosen_threshold

    !> Without noise, density wave and balancing error only what scale factors and unmodelled torques make is left: a hundredth of
    !> the offset goes over from round to round. Such residuals are no noise, which tests would say.
    subroutine test_exact_trim(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(trim_settings_t) :: settings
        type(trim_round_t), allocatable :: rounds(:)
        type(error_t), allocatable :: failure

        call take_case('front-3', case)
        case%satellite%accelerometer%noise%level = 0
        case%satellite%star_camera%catalogue_noise = 0
        case%satellite%star_camera%measurement_noise = 0
        case%satellite%magnetometer%noise = 0
        case%density_wave%amplitude = 0
        settings%threshold = 0.01_dp*MILLIMETRE
        settings%balance_error = 0
        call trim_offset(case, 'ascrest', estimation_options_t(test_beliefs=.false.), settings, rounds, failure)
        if (failed(error, failure)) return
        call check(error, size(rounds), 2, rounds(1)%action%text)
        if (allocated(error)) return
        call check(error, maxval(abs(rounds(2)%offset - (rounds(1)%offset - rounds(1)%estimate))), 0.0_dp, &
                   thr=1e-18_dp)
        call check(error, norm2(rounds(2)%offset) < 0.03_dp*norm2(rounds(1)%offset))
    end subroutine test_exact_trim

    !> Names of different length keep all their letters in the file.
    subroutine test_back_labels(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output
        type(text_file_t) :: file
        type(error_t), allocatable :: failure

        call succeeds(error, 'magnetometer-loss back-2 back-3 --runs 1 --out '//FOLDER//'loss.csv', output)
        if (allocated(error)) return
        call read_text_file(FOLDER//'loss.csv', file, failure)
        if (failed(error, failure)) return
        call check(error, index(file%line(2), 'back-2,ascfest,measured,x,1,'), 1, file%line(2))
        call check(error, index(file%line(25), 'back-3,ascrest,model,z,1,'), 1, file%line(25))
    end subroutine test_back_labels

    !> All but the comment lines; a missing shard is said.
    subroutine test_merge(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: CAMPAIGN = 'montecarlo --cases back-3 --algorithms ascfest --runs 4'
        character(:), allocatable :: output, messages

        call succeeds(error, CAMPAIGN//' --out '//FOLDER//'t.csv --runs-out '//FOLDER//'r.csv', output)
        call succeeds(error, CAMPAIGN//' --shard 1/2 --runs-out '//FOLDER//'r1.csv', output)
        call succeeds(error, CAMPAIGN//' --shard 2/2 --runs-out '//FOLDER//'r2.csv', output)
        call succeeds(error, 'merge '//FOLDER//'r2.csv '//FOLDER//'r1.csv --out '//FOLDER//'tm.csv --runs-out '//FOLDER// &
                      'rm.csv', output)
        call check(error, without_comments('t.csv'), without_comments('tm.csv'))
        call check(error, without_comments('r.csv'), without_comments('rm.csv'))
        call succeeds(error, 'merge '//FOLDER//'r2.csv', output, messages)
        call check_says(error, messages, '2 of 4 estimates are missing')
    end subroutine test_merge

    function without_comments(name) result(text)
        character(*), intent(in) :: name
        character(:), allocatable :: text
        type(text_file_t) :: file
        type(error_t), allocatable :: failure
        integer :: i

        call read_text_file(FOLDER//name, file, failure)
        text = message_of(failure)
        if (allocated(failure)) return
        do i = 1, file%line_count()
            if (index(file%line(i), '#') /= 1) text = text//file%line(i)//new_line('a')
        end do
    end function without_comments

    !> In case 2 the trim says that it does not converge in x, and why; no masses are moved along it, whatever the estimate.
    subroutine test_hardly_observable(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, messages
        type(case_t) :: case
        type(trim_settings_t) :: settings
        type(trim_round_t), allocatable :: rounds(:)
        type(error_t), allocatable :: failure

        call take_case('front-2', case)
        settings%rounds = 2
        settings%balance_error = 0
        call trim_offset(case, 'assest-fde', estimation_options_t(), settings, rounds, failure)
        if (failed(error, failure)) return
        call check(error, all(rounds%sigma(1) > WANTED_ACCURACY) .and. any(abs(rounds%estimate(1)) > WANTED_ACCURACY), 'x')
        call check(error, rounds(2)%offset(1), rounds(1)%offset(1), 'x is not moved')
        call check(error, rounds(2)%offset(2), rounds(1)%offset(2) - rounds(1)%estimate(2), 'y is', thr=1e-15_dp)
        call succeeds(error, 'trim front-2 --rounds 2 --threshold-mm 0.1', output, messages)
        call check_says(error, output, 'round 2: ... calibrate again for x (sigma of x ... x: not determined ... y: converged')
        call check(error, index(messages, 'below the sigma of x') > 0 .and. &
                   index(messages, 'sigma of y') == 0, messages)
    end subroutine test_hardly_observable

    subroutine test_wrong_usage(error)
        type(error_type), allocatable, intent(out) :: error

        call refused(error, 'montecarlo --shard 0/2', STATUS_MISUSED, '"0/2" is not K/N')
        call refused(error, 'montecarlo --shard 3/2', STATUS_MISUSED, '"3/2" is not K/N')
        call refused(error, 'montecarlo --shard 2', STATUS_MISUSED, '"2" is not K/N')
        call refused(error, 'montecarlo --algorithms ascrest,ascfest,ascrest', STATUS_MISUSED, '"ascrest" is twice in the list')
        call refused(error, 'montecarlo --cases front-1,front-1', STATUS_MISUSED, '"front-1" is twice in the list')
        call refused(error, 'montecarlo --out a.csv --runs-out a.csv', STATUS_MISUSED, 'name the same file')
        call refused(error, 'merge b.csv --out a.csv --runs-out a.csv', STATUS_MISUSED, 'name the same file')
        call refused(error, 'montecarlo --runs 3 --shard 4/5', STATUS_MISUSED, 'shard 4/5 of 3 runs has none')
        call refused(error, 'merge', STATUS_MISUSED, 'FILE')
        call refused(error, 'errors --runs 0', STATUS_MISUSED, '--runs')
        call refused(error, 'trim --threshold-mm 0', STATUS_MISUSED, '--threshold-mm')
    end subroutine test_wrong_usage
end module test_studies
