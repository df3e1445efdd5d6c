!> How to estimate: what needs no telling, files of options, and options beside other settings.
module test_options
    use vocabulary
    use calibrations
    use gracecg_base_quaternion, only: quaternion_product, quaternion_from_axis_angle, rotation_angle_between
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_files, only: setup_text, setup_from_text
    use gracecg_estimation_options, only: read_options, options_from_text, options_text, optimal_options_t
    use gracecg_estimation_report_options, only: report_options
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_planning_calibration, only: find_calibration, calibration_text
    implicit none
    private
    public :: collect_options

    character(*), parameter :: LF = new_line('a')

contains

    subroutine collect_options(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('guess-of-the-samples', test_guess), &
                    new_unittest('guess-despite-wrong-samples', test_wrong_samples), &
                    new_unittest('estimates-without-telling', test_no_telling), &
                    new_unittest('observations-stay', test_observations_stay), &
                    new_unittest('written-and-read', test_round_trip), &
                    new_unittest('mistakes', test_mistakes), &
                    new_unittest('setup-with-options', test_setup_with_options), &
                    new_unittest('case-with-options', test_case_with_options)]
    end subroutine collect_options

    subroutine simulate(name, observations, simulator)
        character(*), intent(in) :: name            !! Of a built-in case
        type(observation_set_t), intent(out) :: observations
        type(simulator_t), intent(out) :: simulator
        type(calibration_t) :: calibration

        call take_calibration(name, calibration)
        call make_simulator(calibration%case, simulator)
        call make_observations(simulator, 3, 1, observations)
    end subroutine simulate

    !> Within the noise of the samples; what the options give is taken as it is.
    subroutine test_guess(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(fitting_data_t) :: data
        type(error_t), allocatable :: failure
        integer :: i

        do i = 1, size(REPORT_CASE_NAMES)
            call simulate(REPORT_CASE_NAMES(i), observations, simulator)
            call preprocess(observations, estimation_options_t(), data, failure)
            if (failed(error, failure)) return
            associate (case => simulator%case)
                call check(error, rotation_angle_between(data%guess_quaternion, case%quaternion) < 1e-3_dp, 'attitude')
                call check(error, norm2(data%guess_angular_velocity - case%angular_velocity) < 3e-4_dp, 'rate')
            end associate
        end do
        options%guess_quaternion = [0.0_dp, 0.0_dp, 3.0_dp, 4.0_dp]
        options%guess_angular_velocity = [0.0_dp, 0.0_dp, 1e-3_dp]
        call preprocess(observations, options, data, failure)
        call check(error, maxval(abs(data%guess_quaternion - [0.0_dp, 0.0_dp, 0.6_dp, 0.8_dp])), 0.0_dp, thr=1e-15_dp)
        call check(error, norm2(data%guess_angular_velocity - options%guess_angular_velocity), 0.0_dp)
    end subroutine test_guess

    !> The first samples of the star camera are wrong by tens of degrees, and some have the other sign.
    subroutine test_wrong_samples(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(simulator_t) :: simulator
        type(fitting_data_t) :: data
        type(error_t), allocatable :: failure
        integer :: i

        call simulate('front-2', observations, simulator)
        do i = 1, 6             ! of both heads
            observations%quaternion(:, i) = quaternion_product( &
                                            quaternion_from_axis_angle([0.6_dp, 0.0_dp, 0.8_dp], 20*i*DEGREE), &
                                            observations%quaternion(:, i))
        end do
        observations%quaternion(:, 5::3) = -observations%quaternion(:, 5::3)
        call preprocess(observations, estimation_options_t(), data, failure)
        if (failed(error, failure)) return
        call check(error, rotation_angle_between(data%guess_quaternion, simulator%case%quaternion) < 2e-3_dp, 'attitude')
        call check(error, norm2(data%guess_angular_velocity - simulator%case%angular_velocity) < 3e-4_dp, 'rate')
    end subroutine test_wrong_samples

    !> The report's first guesses and those of the samples lead to one estimate.
    subroutine test_no_telling(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(solution_t) :: told, untold
        type(error_t), allocatable :: failure
        integer :: i, a

        do i = 1, size(REPORT_CASE_NAMES)
            call simulate(REPORT_CASE_NAMES(i), observations, simulator)
            options = report_options(REPORT_CASE_NAMES(i))
            do a = 1, merge(size(ESTIMATOR_NAMES), size(REPORT_ESTIMATORS), i == 1)
                call estimate_offset(trim(ESTIMATOR_NAMES(a)), observations, options, told, failure)
                if (.not. allocated(failure)) &
                    call estimate_offset(trim(ESTIMATOR_NAMES(a)), observations, estimation_options_t(), untold, &
                                         failure)
                if (failed(error, failure)) return
                call check(error, told%converged .and. untold%converged)
                if (a <= size(REPORT_ESTIMATORS)) then  ! in x of case 2, hardly determined, rounding makes 1e-9 sigma
                    call check(error, all(abs(untold%offset - told%offset) < &
                                          1e-8_dp*sigmas(told%covariance)), &
                               REPORT_CASE_NAMES(i)//' '//ESTIMATOR_NAMES(a))
                else        ! sequential ends when corrections are below 1e-3 sigma
                    call check(error, norm2(untold%offset - told%offset) < &
                               merge(1e-6_dp, 1e-4_dp, ESTIMATOR_NAMES(a) == 'optimal')*sqrt(told%covariance(1, 1)), &
                               REPORT_CASE_NAMES(i)//' '//ESTIMATOR_NAMES(a))
                end if
            end do
        end do
    end subroutine test_no_telling

    subroutine test_observations_stay(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations, before
        type(simulator_t) :: simulator
        type(solution_t) :: solution
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, text_before
        integer :: a

        call simulate('back-3', observations, simulator)
        before = observations
        do a = 1, size(ESTIMATOR_NAMES)
            if (estimate_fails(error, trim(ESTIMATOR_NAMES(a)), observations, estimation_options_t(), &
                               solution)) return
        end do
        call setup_text(observations%knowledge, text, failure)
        call setup_text(before%knowledge, text_before, failure)
        call check(error, text == text_before .and. all(observations%quaternion == before%quaternion) .and. &
                   all(observations%acceleration == before%acceleration) .and. all(observations%field == before%field))
    end subroutine test_observations_stay

    subroutine test_round_trip(error)
        type(error_type), allocatable, intent(out) :: error
        type(estimation_options_t) :: options, again
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, text_again

        call make_file('options.nml', '&estimation /')
        call read_options(FOLDER//'options.nml', again, failure)
        if (failed(error, failure)) return
        call options_text(options, text, failure)
        call options_text(again, text_again, failure)
        call check(error, text == text_again, 'a group without keys')
        options = report_options('back-2')
        options%guess_offset = [1e-3_dp/3, -2e-3_dp/7, 0.123456789e-4_dp]
        options%accelerometer_weight = [1/3.0_dp, 2.0_dp, 1e9_dp]
        options%combined_star_camera_weight = 7.5_dp
        options%optimal%noise = 'estimate'
        options%sequential%edit_sigma = 6
        call options_text(options, text, failure)
        if (.not. allocated(failure)) call options_from_text(text, 'memory', again, failure)
        if (failed(error, failure)) return
        call check(error, all(abs(again%guess_offset - options%guess_offset) <= 0) .and. &
                   all(abs(again%accelerometer_weight - options%accelerometer_weight) <= 0) .and. &
                   abs(again%combined_star_camera_weight - 7.5_dp) <= 0 .and. again%optimal%noise == 'estimate' .and. &
                   abs(again%sequential%edit_sigma - 6) <= 0)
        call options_text(again, text_again, failure)
        call check(error, text == text_again)
    end subroutine test_round_trip

    !> File, line, key, and what to do; the same words of options in memory.
    subroutine test_mistakes(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: nothing

        call refused('&estimation'//LF//'    star_camera_weigth = 2'//LF//'/', &
                     'options.nml:2 ... star_camera_weigth ... star_camera_weight')
        call refused('&estimation star_camera_weight = -1 /', 'options.nml:1 ... star_camera_weight')
        call refused('&estimation guess_quaternion = 0.1, 0, 0, 0.1 /', 'guess_quaternion ... unit')
        call refused(LF//'&optimall /', 'options.nml:2 ... &optimall ... optimal')
        call refused('&optimal noise = ''guess'' /', 'noise ... estimate')
        call refused('&mass_properties mass = 3 /', '&mass_properties ... not known')
        call not_taken(estimation_options_t(guess_offset=1e30_dp), 'guess_offset_mm ... -1000 to 1000 mm')
        call not_taken(estimation_options_t(largest_offset=-1.0_dp), 'largest_offset_mm ... 0.001')
        call not_taken(estimation_options_t(accelerometer_weight=[1.0_dp, -1.0_dp, 1.0_dp]), 'accelerometer_weight')
        call not_taken(estimation_options_t(optimal=optimal_options_t(noise='guess')), 'noise ... estimate')

    contains

        subroutine refused(content, parts)
            character(*), intent(in) :: content, parts
            type(estimation_options_t) :: options
            type(error_t), allocatable :: failure

            call make_file('options.nml', content)
            call read_options(FOLDER//'options.nml', options, failure)
            call check_fails(error, failure, parts)
        end subroutine refused

        subroutine not_taken(options, parts)
            type(estimation_options_t), intent(in) :: options
            character(*), intent(in) :: parts
            type(solution_t) :: solution
            type(error_t), allocatable :: failure

            call estimate_offset('assest-fde', nothing, options, solution, failure)
            call check_fails(error, failure, parts)
        end subroutine not_taken
    end subroutine test_mistakes

    !> A setup may have options beside. What is misspelt there is refused.
    subroutine test_setup_with_options(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: GROUPS = LF//'&estimation guess_quaternion = 1, 0, 0, 0, accelerometer_weight = 3*2 /'// &
                                         LF//'&optimal noise = ''estimate'' /'//LF
        type(observation_set_t) :: observations
        type(simulator_t) :: simulator
        type(operator_knowledge_t) :: knowledge
        type(estimation_options_t) :: options
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call simulate('front-3', observations, simulator)
        call setup_text(observations%knowledge, text, failure)
        if (unmet(error, index(text, '&a_priori') > 0 .and. index(text, '&estimation') == 0 .and. &
                  index(text, '&optimal') == 0 .and. index(text, '&sequential') == 0, 'knowledge only')) return
        call options_from_text(text, 'setup.nml', options, failure, beside=.true.)
        if (failed(error, failure)) return
        text = text//GROUPS
        call setup_from_text(text, 'setup.nml', knowledge, failure)
        if (.not. allocated(failure)) call options_from_text(text, 'setup.nml', options, failure, beside=.true.)
        if (failed(error, failure)) return
        call check(error, options%optimal%noise == 'estimate' .and. all(abs(options%accelerometer_weight - 2) <= 0) .and. &
                   all(abs(options%guess_quaternion - [1, 0, 0, 0]) <= 0))
        call options_from_text(text//'&sequential edit_sgma = 4 /', 'setup.nml', options, failure, beside=.true.)
        call check_fails(error, failure, 'setup.nml: ... edit_sgma ... edit_sigma')
        call setup_from_text(text//'&spurious /', 'setup.nml', knowledge, failure)
        call check_fails(error, failure, 'setup.nml: ... &spurious')
    end subroutine test_setup_with_options

    !> A case file has its options beside it.
    subroutine test_case_with_options(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration, again
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call take_calibration('back-1', calibration)
        calibration%options%optimal%estimate_rod_gain = .true.
        calibration%options%star_camera_weight = 3
        call calibration_text(calibration, text, failure)
        call make_file('options.nml', text)
        if (.not. allocated(failure)) call find_calibration(FOLDER//'options.nml', again, failure)
        if (failed(error, failure)) return
        call check(error, again%options%optimal%estimate_rod_gain .and. &
                   abs(again%options%star_camera_weight - 3) <= 0 .and. &
                   all(abs(again%options%guess_quaternion - calibration%options%guess_quaternion) <= 0))

        call make_file('options.nml', text//LF//'&optimall /')
        call find_calibration(FOLDER//'options.nml', again, failure)
        call check_fails(error, failure, 'options.nml: ... &optimall ... "optimal"')
    end subroutine test_case_with_options
end module test_options
