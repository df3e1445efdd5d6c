!> What follows from an offset by Level-1 files: residuals and their spectrum, steps of the trim masses, the trend.
module test_level1_results
    use vocabulary
    use gracecg_base_constants, only: JULIAN_YEAR
    use gracecg_files_file, only: file_exists, make_directory, remove_file
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_estimation, only: estimate_level1
    use gracecg_level1_gathering, only: gather_calibration
    use gracecg_level1_results, only: find_origins, residual_spectrum_t, fitted_samples, &
        find_spectrum, trim_command_t, trim_commands
    use gracecg_level1_setup, only: level1_setup_t, origin_t, read_level1_setup
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_trend, only: trend_point_t, level1_trend_t, fit_trend, predicted_change
    use command_fixture, only: refused, succeeds, STATUS_FAILED
    use level1_day, only: flaws_t, setup_said, day_fails, write_day
    implicit none
    private
    public :: collect_level1_results

contains

    subroutine collect_level1_results(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('trim-steps', test_trim), &
                    new_unittest('origins', test_origins), &
                    new_unittest('residuals', test_residuals), &
                    new_unittest('trend', test_trend), &
                    new_unittest('refused-before-anything-is-lost', test_refused)]
    end subroutine collect_level1_results

    !> steps = nint(change/2.5 um M/4.8 kg), in commands of at most 12000.
    subroutine test_trim(error)
        type(error_type), allocatable, intent(out) :: error
        type(trim_command_t), allocatable :: commands(:)

        call trim_commands(setup_said(), [310e-6_dp, 0.0_dp, -25e-6_dp], commands)
        if (unmet(error, size(commands), 3, 'commands')) return
        call check(error, all(commands%steps == [12000, 2983, -1208]), 'steps')
        call check(error, index(commands(3)%text, '1208 steps NEG') > 0, 'direction')
    end subroutine test_trim

    !> Every value has its source: a line of the setup, default, or product; the mass of MAS1B goes before that of the setup, and
    !> one of them has to say it.
    subroutine test_origins(error)
        type(error_type), allocatable, intent(out) :: error
        character(1), parameter :: LF = achar(10)
        character(*), parameter :: INERTIA = 'moments_of_inertia = 70, 345, 388'//LF//'products_of_inertia = -3, -0.3, -2.9'//LF// &
            '/'//LF//'&level1'//LF//LF//'science_ma = 9'//LF//'/'//LF
        character(*), parameter :: MAS = 'MAS1B_2020-02-01_C_04.txt'
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(level1_setup_t) :: setup
        type(origin_t), allocatable :: origins(:)
        type(error_t), allocatable :: failure
        character(:), allocatable :: path

        call write_day('l1_origins', flaws_t(spans=2), path)
        call remove_file(path//'/'//MAS)        ! of a run before
        call make_file('l1_origins.nml', '! what is said'//LF//'&mass_properties'//LF//'mass = 580'//LF//INERTIA)
        call make_file('l1_massless.nml', '&mass_properties'//LF//INERTIA)
        call gather(FOLDER//'l1_massless.nml')
        call check_fails(error, failure, 'the mass is not known')
        call make_file('l1_elsewhere.nml', '&mass_properties'//LF//'mass = 580'//LF//INERTIA//'&a_priori'//LF// &
                       'signs_known = .true.'//LF//'/'//LF)
        call gather(FOLDER//'l1_elsewhere.nml')
        call check_fails(error, failure, 'the group &a_priori is not known; known: mass_properties, level1')
        call gather(FOLDER//'l1_origins.nml')
        if (.not. allocated(failure)) call estimate_level1(calibration, setup, 'prior', estimate, failure)
        if (failed(error, failure)) return
        call find_origins(calibration, estimate, origins)
        call expect('mass', '580', 'l1_origins.nml, line 3')
        call expect('products_of_inertia', '-3, -0.3, -2.9', 'l1_origins.nml, line 5')
        call expect('science_ma', '9', 'l1_origins.nml, line 9')
        call expect('veto_after', '2', 'default')
        call expect('ACC1A', '', 'ACC1A_2020-02-01_C_04.txt')
        call expect('CLK1B', '', 'CLK1B_2020-02-01_C_04.txt')
        call expect('firings', '0', 'no file')
        call check(error, count(origins%source == '' .or. (origins%value == '' .and. origins%meaning == '')), 0, 'without a source')
        call make_file('l1_origins/'//MAS, 'header:'//LF//'# End of YAML header'//LF// &
                       '633798000 0 G C 00000000 11000101 590.5 590.25 13.4 13.5'//LF)
        call gather(FOLDER//'l1_massless.nml')
        if (failed(error, failure)) return
        call check(error, calibration%setup%mass, 590.5_dp, 'mass of MAS1B')
        call find_origins(calibration, estimate, origins)
        call expect('mass', '590.5', MAS)
        call expect('gas', '13.4, 13.5', MAS)
        call gather(FOLDER//'l1_origins.nml')
        call check(error, index(calibration%notes(size(calibration%notes))%text, 'the setup says a mass of 580') > 0, 'not told')

    contains

        subroutine gather(setup_file)
            character(*), intent(in) :: setup_file

            call read_level1_setup(setup_file, setup, failure)
            if (.not. allocated(failure)) call gather_calibration([path], setup, '', '', reshape([real(dp) ::], [2, 0]), 'model', &
                                                                  calibration, failure)
        end subroutine gather

        subroutine expect(name, value, source)
            character(*), intent(in) :: name, value, source
            integer :: i

            i = findloc(origins%name == name, .true., 1)
            call check(error, i > 0, name//' is not there')
            call check(error, trim(origins(i)%value), value, name)
            call check(error, trim(origins(i)%source), source, name)
        end subroutine expect
    end subroutine test_origins

    !> Residuals of a noiseless day are small beside the signal, and their spectrum has their squares (Parseval).
    subroutine test_residuals(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(residual_spectrum_t) :: spectrum
        real(dp), allocatable :: time(:), observed(:, :), residual(:, :)
        real(dp) :: power, squares
        integer :: i, k

        if (day_fails(error, 'l1_left', flaws_t(spans=2), setup_said(), calibration, estimate)) return
        do i = 1, 2
            estimate%residuals(i)%linear(2, :) = estimate%residuals(i)%linear(2, :) + &
                1e-9_dp*[(sin(TWO_PI*0.08_dp*k), k=1, size(estimate%residuals(i)%kept))]
        end do
        call fitted_samples(estimate, 2, time, observed, residual)
        call check(error, size(time) > 500 .and. maxval(abs(observed(2, :))) > 3e-9_dp .and. &
                   maxval(abs(residual(1, :))) < 0.1_dp*maxval(abs(observed(1, :))), 'the fit follows')
        estimate%residuals(1)%kept([1, 2]) = .false.    ! a span that is shorter by that
        call find_spectrum(estimate, spectrum)
        if (unmet(error, size(spectrum%density, 2), size(spectrum%frequency))) return
        i = maxloc(spectrum%density(2, :), 1)
        call check(error, abs(spectrum%frequency(i) - 0.8_dp) < 1.01_dp*spectrum%frequency(2), 'a line that is left')
        power = sum(spectrum%density(2, :)**2)*spectrum%frequency(2)
        squares = sum(residual(2, :)**2)/size(time)
        call check(error, power, squares, thr=0.1_dp, rel=.true., message='its power')
    end subroutine test_residuals

    !> A line with a step is found again, and what the gas does.
    subroutine test_trend(error)
        type(error_type), allocatable, intent(out) :: error
        type(trend_point_t) :: points(6)
        type(level1_trend_t) :: trend
        type(error_t), allocatable :: failure
        real(dp), parameter :: RATE(3) = [12e-6_dp, -3e-6_dp, 0.0_dp], JUMP(3) = [-40e-6_dp, 5e-6_dp, 1e-6_dp]    ! m/a, m
        real(dp) :: at
        integer :: i

        do i = 1, size(points)
            points(i)%time = 6e8_dp + 0.5_dp*i*JULIAN_YEAR
            points(i)%sigma = [2, 1, 1]*MICROMETRE
            points(i)%offset = [30e-6_dp, 10e-6_dp, 0.0_dp] + RATE*0.5_dp*i
            if (i > 3) points(i)%offset = points(i)%offset + JUMP
        end do
        at = 6e8_dp + 1.75_dp*JULIAN_YEAR
        call fit_trend(points(:1), [5e8_dp], 100e-6_dp, trend, failure)
        call check_fails(error, failure, 'at least 2 dates')
        call fit_trend(points, [5e8_dp, at, at + 60, 9e8_dp], 100e-6_dp, trend, failure)
        if (failed(error, failure)) return
        if (unmet(error, size(trend%step_time), 1, 'steps that the dates see')) return
        call check(error, maxval(abs(trend%rate*JULIAN_YEAR - RATE)) < 1e-11_dp .and. &
                   maxval(abs(trend%step(:, 1) - JUMP)) < 1e-11_dp, 'rate and step')
        call check(error, maxval(trend%chi_square) < 1e-8_dp .and. trend%degrees == 3, 'chi square')
        call check(error, maxval(abs(trend%at(trend%passes))) > 100e-6_dp .and. &
                   maxval(abs(trend%at(trend%passes - 86400))) <= 100e-6_dp, &
                   'the date of 100 um')
        ! 1 g less in tank 1 at -0.6 m: the centre of mass moves by +1.03 um along x, d by -1.03 um
        call check(error, maxval(abs(predicted_change(setup_said(), [13.0_dp, 13.0_dp], [12.999_dp, 13.0_dp]) - &
                                     [-0.6e-3_dp/580, 0.0_dp, 0.0_dp])) < 1e-15_dp, 'by gas')
        call fit_trend(points(:1), [real(dp) ::], 100e-6_dp, trend, failure)
        call check_fails(error, failure, 'at least 2 dates')
    end subroutine test_trend

    !> A trend of results that are not to be used, or counted twice; a simulation among files of other days.
    subroutine test_refused(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: RESULT = '"satellite": "C", "offset_mm": [0.1, 0.2, 0.3], "sigma_mm": [0.01, 0.01, 0.01], '// &
            '"gas_kg": [13, 13], "reason": "wrong sign", '
        character(*), parameter :: DAY = 'l1_other_day/ACC1A_2019-01-01_C_04.txt'
        type(error_t), allocatable :: failure

        call make_file('l1_one.json', '{'//RESULT//'"epoch_gps_s": 6e8, "flag": 1}')
        call make_file('l1_bad.json', '{'//RESULT//'"epoch_gps_s": 7e8, "flag": 2}')
        call refused(error, 'level1 trend '//FOLDER//'l1_one.json '//FOLDER//'l1_bad.json', STATUS_FAILED, &
                     'l1_bad.json ... not to be used ... sign')
        call refused(error, 'level1 trend '//FOLDER//'l1_one.json '//FOLDER//'l1_one.json', STATUS_FAILED, &
                     'of the same time')
        call make_directory(FOLDER//'l1_other_day', failure)
        call make_file(DAY, 'samples')
        call refused(error, 'level1 simulate front-1 --out '//FOLDER//'l1_other_day', STATUS_FAILED, &
                     'ACC1A_2019-01-01_C_04.txt ... join both')
        call check(error, .not. file_exists(FOLDER//'l1_other_day/truth.csv'), 'nothing is written')
        call make_directory(FOLDER//'l1_measured', failure)
        call make_file('l1_measured/setup.nml', 'of somebody')
        call make_file('l1_measured/accelerometer.csv', 'samples')
        call refused(error, 'level1 simulate front-1 --out '//FOLDER//'l1_measured', STATUS_FAILED, &
                     'l1_measured holds an observation set')
        call refused(error, 'level1 prepare '//FOLDER//' --setup '//FOLDER//'none.nml --out '//FOLDER//'l1_measured', &
                     STATUS_FAILED, 'level1 prepare did not write')
        call make_file('l1_short.nml', '&level1_simulation spans = 1, span_duration = 30, first_start = 130 /'//achar(10))
        call make_file('l1_shorter.nml', '&level1_simulation spans = 1, span_duration = 24, first_start = 130 /'//achar(10))
        call execute_command_line('rm -rf '//FOLDER//'l1_again')
        call simulates('front-1 --seed 1 --level1 '//FOLDER//'l1_short.nml', .false.)
        call simulates('front-1 --seed 2 --level1 '//FOLDER//'l1_short.nml', .false.)
        call simulates('front-1 --seed 2 --level1 '//FOLDER//'l1_shorter.nml', .true.)
        call simulates('front-3 --seed 2 --level1 '//FOLDER//'l1_shorter.nml', .true.)

    contains

        !> Simulates into one folder; is it told that another scenario was there?
        subroutine simulates(words, is_told)
            character(*), intent(in) :: words
            logical, intent(in) :: is_told
            character(:), allocatable :: output, messages

            call succeeds(error, 'level1 simulate '//words//' --out '//FOLDER//'l1_again', output, messages)
            call check(error, (index(messages, 'of another scenario') > 0) .eqv. is_told, words)
        end subroutine simulates


    end subroutine test_refused
end module test_level1_results
