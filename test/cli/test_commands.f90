!> The commands, run in this process with what they say captured.
module test_commands
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, message_of
    use gracecg_base_version, only: VERSION
    use gracecg_base_constants, only: EARTH_GM, ASTRONOMICAL_UNIT
    use gracecg_base_text, only: string_t, split, split_words, parse_real
    use gracecg_files_file, only: text_file_t, read_text_file, text_file_of, file_exists, make_directory, &
        remove_file
    use gracecg_files_table, only: read_csv
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_studies_curves, only: CURVE_NAMES, curve_column
    use gracecg_cli_console, only: console_t, console_width
    use gracecg_cli_command_line, only: run_command_line, STATUS_DONE, STATUS_FAILED, STATUS_MISUSED
    use gracecg_level1_commands, only: level1_commands
    use command_fixture, only: run, succeeds, refused
    use testdrive, only: unittest_type, error_type, new_unittest
    use fixture, only: check, check_fails, FOLDER, make_file, make_folder, check_passes
    implicit none
    private
    public :: collect_commands

    integer, parameter :: W = 70
    character(*), parameter :: LF = new_line('a')
    character(*), parameter :: EQUATOR = ' --position 6837865 0 0'

contains

    subroutine collect_commands(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('overview', test_overview), &
                    new_unittest('version', test_version), &
                    new_unittest('wrong-usage', test_wrong_usage), &
                    new_unittest('examples', test_examples), &
                    new_unittest('cases', test_cases), &
                    new_unittest('case-files', test_case_files), &
                    new_unittest('broken-case-files', test_broken_cases), &
                    new_unittest('long-case-names', test_long_names), &
                    new_unittest('results-that-cannot-be-written', test_unwritable_results), &
                    new_unittest('simulate', test_simulate), &
                    new_unittest('estimate', test_estimate), &
                    new_unittest('running-estimate', test_running), &
                    new_unittest('no-convergence', test_no_convergence), &
                    new_unittest('options-in-an-old-setup', test_old_setup), &
                    new_unittest('verify', test_verify), &
                    new_unittest('edited-cases', test_edited_cases), &
                    new_unittest('timing', test_timing), &
                    new_unittest('design', test_design_command), &
                    new_unittest('rods-that-are-off', test_rods_off), &
                    new_unittest('unwritable', test_unwritable), &
                    new_unittest('json', test_json), &
                    new_unittest('help-command', test_help_command), &
                    new_unittest('case-groups', test_case_groups), &
                    new_unittest('lines-fit', test_lines_fit), &
                    new_unittest('instruments-beyond-their-limits', test_instruments), &
                    new_unittest('times-in-utc', test_utc), &
                    new_unittest('pattern', test_pattern), &
                    new_unittest('panels-as-json', test_panels), &
                    new_unittest('completion', test_completion), &
                    new_unittest('level1', test_level1), &
                    new_unittest('empty-and-wrong-paths', test_paths), &
                    new_unittest('gravity', test_gravity), &
                    new_unittest('field', test_field), &
                    new_unittest('density', test_density), &
                    new_unittest('wind', test_wind_model), &
                    new_unittest('sun', test_sun_model), &
                    new_unittest('star-camera', test_star_camera_model), &
                    new_unittest('impossible-places', test_impossible)]
    end subroutine collect_commands

    !> The header and the numbers of the row that a line prints.
    subroutine row_of(error, line, header, values)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: line, header
        real(dp), intent(out) :: values(:)

        type(text_file_t) :: text
        type(string_t), allocatable :: fields(:)
        character(:), allocatable :: output
        integer :: i
        logical :: ok

        values = 0
        call succeeds(error, line, output)
        if (allocated(error)) return
        text = text_file_of(output, 'output')
        call check(error, text%line(text%line_count() - 1), header, line)
        if (allocated(error)) return
        fields = split(text%line(text%line_count()), ',')
        call check(error, size(fields), size(values), line)
        if (allocated(error)) return
        do i = 1, size(values)
            call parse_real(fields(i)%text, values(i), ok)
            call check(error, ok, fields(i)%text)
            if (allocated(error)) return
        end do
    end subroutine row_of

    subroutine test_overview(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, same, help

        call succeeds(error, '--help', output)
        call succeeds(error, '', same)
        call check(error, output, same)
        call check(error, index(output, LF//'  simulate ') > 0 .and. &
                   index(output, LF//'  model star-camera ') > 0)
        call succeeds(error, 'simulate --help', help)
        call check(error, index(help, 'usage: gracecg simulate CASE --out DIR') == 1, help)
    end subroutine test_overview

    !> The version is that of fpm.toml (the tester runs in the project's folder).
    subroutine test_version(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: manifest
        type(error_t), allocatable :: failure
        character(:), allocatable :: output

        call succeeds(error, '--version', output)
        call check(error, output, 'gracecg '//VERSION//LF)
        if (allocated(error)) return
        call read_text_file('fpm.toml', manifest, failure)
        call check_passes(error, message_of(failure))
        call check(error, index(manifest%text, LF//'version = "'//VERSION//'"'//LF) > 0)
    end subroutine test_version

    subroutine test_wrong_usage(error)
        type(error_type), allocatable, intent(out) :: error

        call refused(error, 'simulat front-1', STATUS_MISUSED, &
                     [character(W) :: 'unknown command "simulat"', 'did you mean "simulate"?'])
        call refused(error, 'model fild', STATUS_MISUSED, [character(W) :: 'did you mean "model field"?'])
        call refused(error, 'model', STATUS_MISUSED, [character(W) :: 'gravity', 'star-camera'])
        call refused(error, 'level1', STATUS_MISUSED, [character(W) :: 'which level1?', 'list', 'dump'])
        call refused(error, 'level1 lst x', STATUS_MISUSED, [character(W) :: 'did you mean "level1 list"?'])
        call refused(error, 'level1 dump x --format json', STATUS_MISUSED, [character(W) :: 'one of csv, records'])
        call refused(error, 'level1 convert x', STATUS_MISUSED, [character(W) :: '--out FILE is required'])
        call refused(error, 'level1 convert x --out x', STATUS_MISUSED, [character(W) :: 'the same file as the input'])
        call refused(error, 'level1 dump no-such-file', STATUS_FAILED, [character(W) :: 'no such file'])
        call refused(error, 'simulate front-1', STATUS_MISUSED, &
                     [character(W) :: '--out DIR is required', 'usage: gracecg simulate'])
        call refused(error, 'simulate front-1 --out x --seed one', STATUS_MISUSED, &
                     [character(W) :: '--seed', '"one"'])
        call refused(error, 'simulate front-1 --out x --run -1', STATUS_MISUSED, [character(W) :: '--run'])
        call refused(error, 'estimate x', STATUS_MISUSED, [character(W) :: '--algorithm NAME is required'])
        call refused(error, 'estimate x --algorithm asest-fde', STATUS_MISUSED, &
                     [character(W) :: 'did you mean "assest-fde"?'])
        call refused(error, 'estimate x --algorithm assest-fde --format html', STATUS_MISUSED, &
                     [character(W) :: '--format', 'one of text, csv'])
        call refused(error, 'cases shw front-1', STATUS_MISUSED, [character(W) :: 'did you mean "show"?'])
        call refused(error, 'cases show', STATUS_MISUSED, [character(W) :: 'which case?'])
        call refused(error, 'model gravity', STATUS_MISUSED, [character(W) :: '--position X Y Z is required'])
        call refused(error, 'model gravity --position nan 0 0', STATUS_MISUSED, [character(W) :: '"nan"'])
        call refused(error, 'model gravity --position 7e6 0', STATUS_MISUSED, &
                     [character(W) :: '--position takes 3 values'])
        call refused(error, 'model sun --date 1989-13-01', STATUS_MISUSED, [character(W) :: 'month 13'])
        call refused(error, 'model density --date 1989-01-02 --kp 3'//EQUATOR, STATUS_MISUSED, &
                     [character(W) :: 'all three of --f107, --f107a and --kp'])
        call refused(error, 'model field --date 1989-01-02 --table igrf14 --file x'//EQUATOR, &
                     STATUS_MISUSED, [character(W) :: '--table or --file, not both'])
    end subroutine test_wrong_usage

    !> The example of every help works as printed (below the folder of the tests).
    subroutine test_examples(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: COMMANDS(10) = [character(17) :: 'verify', 'simulate', &
                                                   'estimate', 'timing', 'model gravity', &
                                                   'model field', 'model density', 'model wind', &
                                                   'model sun', 'model star-camera']
        type(text_file_t) :: help
        character(:), allocatable :: output, line
        integer :: i, k
        logical :: in_example

        do i = 1, size(COMMANDS)
            call succeeds(error, trim(COMMANDS(i))//' --help', output)
            if (allocated(error)) return
            help = text_file_of(output, 'help')
            in_example = .false.
            do k = 1, help%line_count()
                line = trim(adjustl(help%line(k)))
                if (in_example) then
                    line = below_folder(line(len('gracecg ') + 1:))
                    call succeeds(error, line, output)
                    if (allocated(error)) return
                end if
                in_example = in_example .or. line == 'example:'
            end do
            call check(error, in_example, trim(COMMANDS(i))//': no example')
        end do
    end subroutine test_examples

    !> The line with its files below the folder of the tests.
    function below_folder(line) result(moved)
        character(*), intent(in) :: line
        character(:), allocatable :: moved

        type(string_t), allocatable :: words(:)
        integer :: i

        words = split_words(line)
        moved = ''
        do i = 1, size(words)
            if (index(words(i)%text, 'run1') == 1 .or. words(i)%text == 'curves' .or. &
                words(i)%text == 'timing.csv') words(i)%text = FOLDER//words(i)%text
            moved = moved//' '//words(i)%text
        end do
        moved = moved(2:)
    end function below_folder

    !> The list has the places that CSR-TM-00-01 section 6.1 prints for the front satellite.
    subroutine test_cases(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: list
        type(string_t), allocatable :: words(:)
        character(:), allocatable :: output
        integer :: i

        call succeeds(error, 'cases', output)
        if (allocated(error)) return
        list = text_file_of(output, 'list')
        call check(error, list%line_count(), size(REPORT_CASE_NAMES) + 4)      ! a heading, a sentence
        do i = 1, size(REPORT_CASE_NAMES)
            call check(error, index(list%line(i + 2), REPORT_CASE_NAMES(i)), 1)
        end do
        if (allocated(error)) return
        words = split_words(list%line(4))
        call check(error, words(3)%text == '1989-01-02T00:23:20' .and. &
                   words(4)%text(:2) == '89' .and. words(5)%text(:4) == '-107' .and. words(9)%text == '-30', list%line(4))
        if (allocated(error)) return
        words = split_words(list%line(5))
        call check(error, words(4)%text(:2) == '10' .and. words(5)%text(:2) == '67', list%line(5))
        call refused(error, 'cases show frnt-1', STATUS_FAILED, &
                     [character(W) :: 'no case "frnt-1"', 'front-1, front-2', &
                     'did you mean "front-1"?'])
    end subroutine test_cases

    !> A case shown, saved and run gives exactly the numbers of the built-in case.
    subroutine test_case_files(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output
        character(*), parameter :: FILES(6) = [character(17) :: 'truth.csv', 'accelerometer.csv', 'star_camera.csv', &
            'magnetometer.csv', 'orbit.csv', 'setup.nml']
        integer :: i, k

        do i = 1, size(REPORT_CASE_NAMES)
            if (allocated(error)) return
            associate (name => REPORT_CASE_NAMES(i))
                call succeeds(error, 'cases show '//name, output)
                call make_file(error, 'case.nml', output)
                call succeeds(error, 'simulate '//name//' --out '//FOLDER//'named', output)
                call succeeds(error, 'simulate '//FOLDER//'case.nml --out '//FOLDER//'filed', output)
            end associate
            do k = 1, size(FILES)
                call same_file(error, 'named/', 'filed/', trim(FILES(k)))
            end do
        end do
    end subroutine test_case_files

    subroutine same_file(error, first, second, name)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: first, second, name
        type(text_file_t) :: a, b
        type(error_t), allocatable :: failure

        if (allocated(error)) return
        call read_text_file(FOLDER//first//name, a, failure)
        if (.not. allocated(failure)) call read_text_file(FOLDER//second//name, b, failure)
        call check_passes(error, message_of(failure))
        call check(error, a%text == b%text, name//' differs')
    end subroutine same_file

    !> The columns of montecarlo give way to a long name.
    subroutine test_long_names(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: NAME = 'with-physical-weights'
        character(:), allocatable :: output
        integer :: at

        call succeeds(error, 'cases show front-3', output)
        if (allocated(error)) return
        at = index(output, 'front-3')
        call make_file(error, 'case.nml', output(:at - 1)//NAME//output(at + len('front-3'):))
        call succeeds(error, 'montecarlo --runs 1 --algorithms ascrest --cases front-1,'//FOLDER//'case.nml', &
                      output)
        call check(error, index(output, LF//NAME//'  x     0.') > 0, output)
        call check(error, index(output, LF//NAME//'  0.3000 ') > 0, output)
        call check(error, index(output, LF//'front-1'//repeat(' ', len(NAME) - 5)//'x     0.') > 0, output)
    end subroutine test_long_names

    !> Refused before the work is done, so nothing is printed.
    subroutine test_unwritable_results(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: PATH = 'build/no-such-folder/x.csv'
        character(*), parameter :: PARTS(2) = [character(W) :: PATH, 'there is no folder']

        call refused(error, 'montecarlo --cases front-3 --runs 1 --out '//PATH, STATUS_FAILED, PARTS)
        call refused(error, 'montecarlo --cases front-3 --runs 1 --runs-out '//PATH, STATUS_FAILED, PARTS)
        call refused(error, 'errors --runs 1 --out '//PATH, STATUS_FAILED, PARTS)
        call refused(error, 'magnetometer-loss --runs 1 --out '//PATH, STATUS_FAILED, PARTS)
        call refused(error, 'timing --step 600 --out '//PATH, STATUS_FAILED, PARTS)
    end subroutine test_unwritable_results

    !> Case files with one line changed: the message names file, line and key, and nothing is
    !> written.
    subroutine test_broken_cases(error)
        type(error_type), allocatable, intent(out) :: error

        call broken('mass =', 'mas = 420', [character(W) :: 'mas', 'mass'])
        call broken('duration =', 'durration = 60', [character(W) :: 'broken.nml:5', 'durration', 'duration'])
        call broken('mass =', 'mass = heavy', [character(W) :: 'broken.nml:10', 'mass', '"heavy"'])
        call broken('mass =', 'mass =', [character(W) :: 'broken.nml:10', 'mass', 'value'])
        call broken('mass =', 'mass = -1', [character(W) :: 'broken.nml:10', 'mass', '-1', '0.001 to'])
        call broken('mass =', 'mass = nan', [character(W) :: 'broken.nml:10', 'mass', 'nan'])
        call broken('position =', 'position = 7e6, 0', [character(W) :: 'broken.nml:', 'position', '3'])
        call broken('quaternion =', 'quaternion = 0.5, 0.5, 0.5, 0.6', &
                    [character(W) :: 'broken.nml:', 'quaternion', 'not a unit quaternion'])
        call broken('epoch =', 'epoch = ''1995-01-02T00:00:00''', &
                    [character(W) :: 'no space weather for 1995-01-02', '1988-12-01 to 1989-02-28'])
        call broken('epoch =', 'epoch = ''2003-01-02T00:00:00''', &
                    [character(W) :: 'igrf95', '1985 to 2000', 'igrf14'])
        call broken('epoch =', 'epoch = ''1989-01-32''', [character(W) :: 'broken.nml:4', 'epoch', 'day 32'])
        call broken('gravity =', 'gravity = ''file''', [character(W) :: 'broken.nml:', &
                                                        'gravity_file', 'names no file'])
        call broken('solar_irradiance =', 'solar_irradiance = 0', [character(W) :: 'broken.nml:', &
                                                                   'solar_irradiance', '1 to 10000'])
        call broken('wind_file =', 'wind_file = ''wind.txt''', &
                    [character(W) :: 'broken.nml:', 'wind_file', 'a file that is not used'])
        call broken('density =', 'density = ''msis''', [character(W) :: 'broken.nml:', '"msis"', 'dtm77'])

    contains

        subroutine broken(key, text, parts)
            character(*), intent(in) :: key, text, parts(:)

            type(text_file_t) :: good
            character(:), allocatable :: output
            integer :: line

            call succeeds(error, 'cases show front-1', output)
            if (allocated(error)) return
            good = text_file_of(output, 'good')
            do line = 1, good%line_count()
                if (index(adjustl(good%line(line)), key) == 1) exit
            end do
            call check(error, line <= good%line_count(), 'no key '//key)
            call make_file(error, 'broken.nml', good%text(:good%first(line) - 1)//text// &
                           good%text(good%last(line) + 1:))
            call refused(error, 'simulate '//FOLDER//'broken.nml --out '//FOLDER//'broken', &
                         STATUS_FAILED, parts)
            call check(error, .not. file_exists(FOLDER//'broken/truth.csv') .and. &
                       .not. file_exists(FOLDER//'broken/setup.nml'), 'a result stands after '// &
                       text)
        end subroutine broken
    end subroutine test_broken_cases

    !> Columns and rows as documented; other runs have other noise and the same truth.
    subroutine test_simulate(error)
        type(error_type), allocatable, intent(out) :: error
        character(10), parameter :: COLUMNS(23) = [character(10) :: 'time_s', 'rx_m', 'ry_m', 'rz_m', 'vx_m_s', &
            'vy_m_s', 'vz_m_s', 'q1', 'q2', 'q3', 'q4', 'wx_rad_s', 'wy_rad_s', 'wz_rad_s', 'wdx_rad_s2', &
            'wdy_rad_s2', 'wdz_rad_s2', 'bx_tesla', 'by_tesla', 'bz_tesla', 'ngx_m_s2', 'ngy_m_s2', 'ngz_m_s2']
        type(error_t), allocatable :: failure
        type(text_file_t) :: file
        type(string_t), allocatable :: comments(:)
        real(dp), allocatable :: truth_1(:, :), truth_2(:, :), noisy_1(:, :), noisy_2(:, :)
        character(7), parameter :: ACCELEROMETER(4) = [character(7) :: 'time_s', 'ax_m_s2', 'ay_m_s2', 'az_m_s2']
        character(:), allocatable :: output

        call succeeds(error, 'simulate front-3 --out '//FOLDER//'run1 --seed 5', output)
        call succeeds(error, 'simulate front-3 --out '//FOLDER//'run2 --seed 5 --run 2', output)
        call check(error, index(output, 'next: gracecg estimate '//FOLDER//'run2 --algorithm ') > 0, output)
        if (allocated(error)) return
        call read_csv(FOLDER//'run1/truth.csv', COLUMNS, truth_1, failure, comments)
        if (.not. allocated(failure)) call read_csv(FOLDER//'run2/truth.csv', COLUMNS, truth_2, failure)
        if (.not. allocated(failure)) &
            call read_csv(FOLDER//'run1/accelerometer.csv', ACCELEROMETER, noisy_1, failure)
        if (.not. allocated(failure)) &
            call read_csv(FOLDER//'run2/accelerometer.csv', ACCELEROMETER, noisy_2, failure)
        if (.not. allocated(failure)) call read_text_file(FOLDER//'run1/accelerometer.csv', file, failure)
        call check_passes(error, message_of(failure))
        call check(error, comments(1)%text == 'gracecg '//VERSION//' simulate' .and. &
                   comments(2)%text == 'case front-3, seed 5, run 1')
        call check(error, size(truth_1, 1) == 601 .and. size(noisy_1, 1) == 600)
        call check(error, index(file%line(4), '0.3,') == 1, file%line(4))
        call check(error, all(abs(truth_1(:, :20) - truth_2(:, :20)) <= 0), 'the truth depends on the run')
        call check(error, any(abs(truth_1(:, 21) - truth_2(:, 21)) > 0), 'the density wave does not')
        call check(error, all(abs(noisy_1(:, 2) - noisy_2(:, 2)) > 0), 'the noise does not')
    end subroutine test_simulate

    !> The estimate from files: within five of its sigmas in the well observed axes of case 3, the
    !> same in both formats.
    subroutine test_estimate(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: TRUE_OFFSET(3) = [0.3_dp, 0.4_dp, -0.5_dp]   ! mm, section 6.2
        type(text_file_t) :: text
        type(string_t), allocatable :: fields(:)
        character(:), allocatable :: output, messages, line
        real(dp) :: value, sigma
        integer :: axis, status
        logical :: ok

        call succeeds(error, 'simulate front-3 --out '//FOLDER//'run3', output)
        call succeeds(error, 'estimate '//FOLDER//'run3 --algorithm assest-fde --format csv', output)
        if (allocated(error)) return
        text = text_file_of(output, 'output')
        call check(error, index(text%line(1), &
                   'algorithm,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm,iterations,'// &
                   'converged,condition,residual_rms_x_m_s2,residual_rms_y_m_s2,residual_rms_z_m_s2,alpha_x_m_s3,') == 1, &
                   text%line(1))
        if (allocated(error)) return
        fields = split(text%line(2), ',')
        call check(error, size(fields) == 46 .and. size(split(text%line(1), ',')) == 46 .and. &
                   fields(1)%text == 'assest-fde' .and. fields(9)%text == 'true' .and. fields(40)%text == '', text%line(2))
        do axis = 1, 3
            if (allocated(error)) return
            call parse_real(fields(1 + axis)%text, value, ok)
            call parse_real(fields(4 + axis)%text, sigma, ok)
            call check(error, ok .and. abs(value - TRUE_OFFSET(axis)) < 5*sigma .and. &
                       sigma < 0.1_dp, text%line(2))
        end do
        call succeeds(error, 'estimate '//FOLDER//'run3 --algorithm assest-fde', output)
        if (allocated(error)) return
        text = text_file_of(output, 'output')
        do axis = 1, 3
            line = text%line(1 + axis)
            read (line(4:16), *) sigma
            call parse_real(fields(1 + axis)%text, value, ok)
            call check(error, abs(sigma - value) < 1e-5_dp, line)
            if (allocated(error)) return
        end do
        call refused(error, 'estimate '//FOLDER//'none --algorithm assest-fde', STATUS_FAILED, &
                     [character(W) :: 'none: no such folder'])
        call estimate_without_stars()
        if (allocated(error)) return
        call remove_file(FOLDER//'run3/magnetometer.csv')
        call run('estimate '//FOLDER//'run3 --algorithm assest-fde', status, output, messages)
        call check(error, status, STATUS_DONE, messages)
        call check(error, index(messages, 'warning: magnetometer: no samples for 60 epochs'), 1, messages)
        call remove_file(FOLDER//'run3/orbit.csv')
        call refused(error, 'estimate '//FOLDER//'run3 --algorithm assest-fde', STATUS_FAILED, &
                     [character(W) :: 'run3/magnetometer.csv: no such file'])

    contains

        !> With the angular velocity of the setup, that of the truth file's first row: no star camera, no attitude.
        subroutine estimate_without_stars()
            type(text_file_t) :: setup, truth
            type(string_t), allocatable :: names(:), values(:)
            character(:), allocatable :: rates
            type(error_t), allocatable :: failure
            integer :: i, place, length

            call succeeds(error, 'simulate front-3 --out '//FOLDER//'run4', output)
            if (allocated(error)) return
            call remove_file(FOLDER//'run4/star_camera.csv')
            call refused(error, 'estimate '//FOLDER//'run4 --algorithm assest-fde', STATUS_FAILED, &
                         [character(W) :: 'run4/star_camera.csv: no such file'])
            call read_text_file(FOLDER//'run4/truth.csv', truth, failure)
            names = split(truth%line(1), ',')
            values = split(truth%line(2), ',')
            rates = ''
            do i = 1, size(names)
                if (index(names(i)%text, '_rad_s') > 0 .and. index(names(i)%text, 'wd') == 0) rates = rates//' '//values(i)%text
            end do
            call read_text_file(FOLDER//'run4/setup.nml', setup, failure)
            call make_file(error, 'run4/setup.nml', setup%text//'&angular_velocity value ='//rates// &
                           ' sigma = 3*1e-8 /'//new_line('a'))
            call run('estimate '//FOLDER//'run4 --algorithm assest-fde --format csv', status, output, messages)
            call check(error, status == STATUS_DONE .and. index(messages, 'from other means') > 0, messages)
            if (allocated(error)) return
            text = text_file_of(output, 'output')
            fields = split(text%line(2), ',')
            do axis = 1, 3
                call parse_real(fields(1 + axis)%text, value, ok)
                call parse_real(fields(4 + axis)%text, sigma, ok)
                call check(error, ok .and. abs(value - TRUE_OFFSET(axis)) < 5*sigma .and. sigma < 0.1_dp, text%line(2))
                if (allocated(error)) return
            end do
            names = split(text%line(1), ',')
            place = findloc([(names(i)%text == 'q1', i=1, size(names))], .true., 1)
            length = 0
            do i = place, place + 7
                length = length + len_trim(fields(i)%text)
            end do
            call check(error, length, 0, text%line(2))
            call refused(error, 'estimate '//FOLDER//'run4 --algorithm optimal', STATUS_FAILED, &
                         [character(W) :: 'ASSEST alone can do without'])
        end subroutine estimate_without_stars
    end subroutine test_estimate

    !> The running estimate: its columns, its last row the estimate; refused of a batch estimator, and not
    !> half-written.
    subroutine test_running(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: FILE = FOLDER//'running.csv'
        character(*), parameter :: COLUMNS(9) = [character(20) :: 'time_s', 'dx_mm', 'dy_mm', 'dz_mm', &
            'sigma_x_mm', 'sigma_y_mm', 'sigma_z_mm', 'edited_accelerometer', 'edited_star_camera']
        type(text_file_t) :: text
        type(string_t), allocatable :: fields(:)
        type(error_t), allocatable :: failure
        character(:), allocatable :: output, messages
        real(dp), allocatable :: table(:, :)
        real(dp) :: value
        integer :: status, i
        logical :: ok

        call succeeds(error, 'simulate back-3 --out '//FOLDER//'run6', output)
        call run('estimate '//FOLDER//'run6 --algorithm sequential --format csv --running '//FILE, status, &
                 output, messages)
        call check(error, status, STATUS_DONE, messages)
        if (allocated(error)) return
        call read_csv(FILE, COLUMNS, table, failure)
        call check_passes(error, message_of(failure))
        call check(error, size(table, 1), 601)
        if (allocated(error)) return
        text = text_file_of(output, 'output')
        fields = split(text%line(2), ',')
        do i = 2, 7
            call parse_real(fields(i)%text, value, ok)
            call check(error, ok .and. abs(table(601, i) - value) < 1e-5_dp, text%line(2))
            if (allocated(error)) return
        end do
        call remove_file(FILE)
        call refused(error, 'estimate '//FOLDER//'run6 --algorithm optimal --running '//FILE, STATUS_MISUSED, &
                     [character(W) :: '--running: optimal estimates from all samples at once'])
        call refused(error, 'estimate '//FOLDER//'none --algorithm sequential --running '//FILE, STATUS_FAILED, &
                     [character(W) :: 'none: no such folder'])
        call check(error, .not. file_exists(FILE), 'no file is left by a failure')
        call refused(error, 'estimate '//FOLDER//'run6 --algorithm sequential --running '//FOLDER//'no/x.csv', &
                     STATUS_FAILED, [character(W) :: 'there is no folder'])
    end subroutine test_running

    !> A hopeless initial guess: the result is shown, marked as not converged, and the status is 1.
    subroutine test_no_convergence(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: KEY = 'guess_angular_velocity = '
        type(text_file_t) :: knowledge
        type(error_t), allocatable :: failure
        character(:), allocatable :: output, messages
        integer :: status, place

        call succeeds(error, 'simulate front-1 --out '//FOLDER//'lost', output)
        if (allocated(error)) return
        call read_text_file(FOLDER//'lost/options.nml', knowledge, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        place = index(knowledge%text, KEY) + len(KEY)
        call make_file(error, 'lost/options.nml', knowledge%text(:place - 1)//'0.5, 0.4, 0.7 ! '// &
                       knowledge%text(place:))
        call run('estimate '//FOLDER//'lost --algorithm assest-fde --format csv --options '//FOLDER// &
                 'lost/options.nml', status, output, messages)
        call check(error, status, STATUS_FAILED, messages)
        call check(error, index(output, ',false,') > 0 .and. index(messages, 'did not converge') > 0, &
                   output//messages)
    end subroutine test_no_convergence

    !> A setup.nml of version 0.1 has options: they count, with a warning; --options takes their place.
    subroutine test_old_setup(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: setup, options
        type(error_t), allocatable :: failure
        character(:), allocatable :: output, messages, told, untold
        integer :: status

        call succeeds(error, 'simulate front-1 --out '//FOLDER//'old', output)
        call succeeds(error, 'estimate '//FOLDER//'old --algorithm ascfest --format csv', untold)
        call succeeds(error, 'estimate '//FOLDER//'old --algorithm ascfest --format csv --options '//FOLDER// &
                      'old/options.nml', told)
        if (allocated(error)) return
        call read_text_file(FOLDER//'old/setup.nml', setup, failure)
        if (.not. allocated(failure)) call read_text_file(FOLDER//'old/options.nml', options, failure)
        call check_passes(error, message_of(failure))
        call make_file(error, 'old/setup.nml', setup%text//options%text)
        call run('estimate '//FOLDER//'old --algorithm ascfest --format csv', status, output, messages)
        call check(error, status, STATUS_DONE, messages)
        call check(error, output == told .and. output /= untold, 'the groups of the setup count')
        call check_fails(error, messages, [character(W) :: 'warning: ', 'setup.nml', '&estimation, &optimal, &sequential', &
                                           '--options'])
        call make_file(error, 'old/empty.nml', '&estimation /')
        call run('estimate '//FOLDER//'old --algorithm ascfest --format csv --options '//FOLDER//'old/empty.nml', &
                 status, output, messages)
        call check(error, output == untold, '--options takes their place')
        call refused(error, 'estimate '//FOLDER//'old --algorithm ascfest --options '//FOLDER//'old/none.nml', &
                     STATUS_FAILED, [character(W) :: 'old/none.nml'])
    end subroutine test_old_setup

    subroutine test_verify(error)
        type(error_type), allocatable, intent(out) :: error
        character(32) :: columns(1 + 3*size(CURVE_NAMES))
        type(error_t), allocatable :: failure
        character(:), allocatable :: output
        real(dp), allocatable :: table(:, :)
        integer :: i, axis

        call succeeds(error, 'verify front-1 back-3 --out '//FOLDER//'curves', output)
        call check(error, index(output, 'attitude dynamics alone: 27 of 27 inside') > 0, output)
        call check(error, longest_line(output) <= 100, output)
        if (allocated(error)) return
        columns(1) = 'time_s'
        do i = 1, size(CURVE_NAMES)
            do axis = 1, 3
                columns(1 + 3*(i - 1) + axis) = curve_column(CURVE_NAMES(i), char(ichar('x') + axis - 1))
            end do
        end do
        call read_csv(FOLDER//'curves/verify_back-3.csv', columns, table, failure)
        call check_passes(error, message_of(failure))
        call check(error, size(table, 1), 601)
        if (allocated(error)) return
        ! a_total = a_vel + a_gg + a_acc
        call check(error, maxval(abs(table(:, 23:25) - table(:, 14:16) - table(:, &
                17:19) - table(:, 20:22))) < 1e-22_dp)
        call refused(error, 'verify front-1 front-1', STATUS_FAILED, &
                     [character(W) :: 'two cases have the name "front-1"'])
        call refused(error, 'verify front-4', STATUS_FAILED, [character(W) :: 'no case "front-4"'])
        call refused(error, 'verify front-1 --runs 20', STATUS_MISUSED, [character(W) :: '--runs'])
        call refused(error, 'verify --runs 14', STATUS_MISUSED, [character(W) :: '--runs'])
    end subroutine test_verify

    !> A case is judged against what is published by its settings, whatever its name.
    subroutine test_edited_cases(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, text
        integer :: place

        call succeeds(error, 'cases show front-1', text)
        if (allocated(error)) return
        place = index(text, 'amplitude = 30 ')
        call make_file(error, 'edited.nml', text(:place - 1)//'amplitude = 10 '//text(place + 15:))
        if (allocated(error)) return
        place = index(text, 'front-1')
        call make_file(error, 'renamed.nml', text(:place - 1)//'mine'//text(place + 7:))
        call succeeds(error, 'verify --cases '//FOLDER//'edited.nml,'//FOLDER//'renamed.nml', output)
        call check(error, index(output, 'front-1, edited: not the case of the report. Against front-1 it has '// &
                                'amplitude = 10'//achar(10)) > 0, output)
        call check(error, index(output, 'mine: curves and the printed axis') > 0, output)
        call check(error, index(output, 'mine, edited') == 0, output)
        call succeeds(error, 'montecarlo --runs 2 --algorithms ascfest --cases '// &
                      FOLDER//'edited.nml,'//FOLDER//'renamed.nml --out '//FOLDER// &
                      'edited.csv --runs-out '//FOLDER//'edited_runs.csv', output)
        call check(error, index(output, 'theory is right (95 %): 3 of 3') > 0, output)
        call check(error, index(output, 'front-1: edited or switched, not the case') > 0, output)
        call succeeds(error, 'merge '//FOLDER//'edited_runs.csv', output)
        call check(error, index(output, 'front-1: edited or switched, not the case') > 0 .and. &
                   index(output, '(95 %): 3 of 3') > 0, output)
    end subroutine test_edited_cases

    !> The file without its second column, which has to be `utc`.
    subroutine drop_utc(error, name)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name        !! In FOLDER

        type(text_file_t) :: file
        type(string_t), allocatable :: fields(:)
        type(error_t), allocatable :: failure
        character(:), allocatable :: rest
        integer :: i, k

        if (allocated(error)) return
        call read_text_file(FOLDER//name, file, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        rest = ''
        do i = 1, file%line_count()
            fields = split(file%line(i), ',')
            if (size(fields) < 2) cycle
            if (i == 1) call check(error, fields(2)%text, 'utc')
            if (allocated(error)) return
            rest = rest//fields(1)%text
            do k = 3, size(fields)
                rest = rest//','//fields(k)%text
            end do
            rest = rest//LF
        end do
        call make_file(error, name, rest)
    end subroutine drop_utc

    pure integer function longest_line(text) result(longest)
        character(*), intent(in) :: text

        integer :: i, start

        longest = 0
        start = 1
        do i = 1, len(text)
            if (text(i:i) /= achar(10)) cycle
            longest = max(longest, i - start)
            start = i + 1
        end do
    end function longest_line

    !> The designed case is a case like any other; the map has its columns; contradictions are refused.
    subroutine test_design_command(error)
        type(error_type), allocatable, intent(out) :: error

        character(*), parameter :: QUICK = 'design --frequencies 0.1 0.1 --waveforms sine --threads 1 '
        character(:), allocatable :: output
        real(dp), allocatable :: table(:, :)
        type(error_t), allocatable :: failure
        character(24), parameter :: FIRST_COLUMNS(10) = [character(24) :: 'time_s', 'latitude_deg', &
            'longitude_deg', 'sigma_x_mm', 'sigma_y_mm', 'sigma_z_mm', 'worst_sigma_mm', 'worst_x', 'worst_y', &
            'worst_z']

        call make_folder(error)
        call succeeds(error, QUICK//'--satellite back --at 1400 --out '//FOLDER// &
                      'design.nml --map '//FOLDER//'map.csv --step 600', output)
        call check(error, index(output, 'this manoeuvre') > 0 .and. index(output, '5, 6, 7 cycles') > 0 .and. &
                   index(output, 'worst place') > 0, output)
        call succeeds(error, 'cases show '//FOLDER//'design.nml', output)
        call check(error, index(output, '1989-01-02T00:23:20') > 0 .and. index(output, 'back-1-design') > 0, output)
        call succeeds(error, 'simulate '//FOLDER//'design.nml --out '//FOLDER//'design', output)
        call succeeds(error, 'estimate '//FOLDER//'design --algorithm assest-rde', output)
        call succeeds(error, 'bound '//FOLDER//'design.nml', output)
        call check(error, index(output, 'scale factors, magnetometer bias, which are estimated') > 0, output)
        call drop_utc(error, 'map.csv')
        if (allocated(error)) return
        call read_csv(FOLDER//'map.csv', [character(24) :: FIRST_COLUMNS, 'wave_x_mm', 'wave_y_mm', 'wave_z_mm', &
                                          'force_x_mm', 'force_y_mm', 'force_z_mm', 'rate_deg_s', &
                                          'pointing_deg'], table, failure)
        call check(error,.not. allocated(failure), message_of(failure))
        call check(error, size(table, 1), 10, 'a revolution has ten places 600 s apart')
        call succeeds(error, 'design --manoeuvre '//FOLDER//'design.nml --format csv', output)
        call check(error, index(output, 'case,time_s,utc,latitude_deg') == 1 .and. &
                   index(output, 'back-1-design,0,') > 0, output)

        call refused(error, QUICK//'front-1 --satellite back', STATUS_MISUSED, &
                     [character(W) :: '--satellite and a CASE'])
        call refused(error, QUICK//'--manoeuvre front-1', STATUS_MISUSED, [character(W) :: 'is for the search'])
        call refused(error, 'design --manoeuvre front-1 --frequencies 0.1 0.2', STATUS_MISUSED, &
                     [character(W) :: '--frequencies is for the search'])
        call refused(error, QUICK//'--rods w', STATUS_MISUSED, [character(W) :: '--rods', '"w"'])
        call refused(error, QUICK//'--anywhere --at 3', STATUS_MISUSED, [character(W) :: '--anywhere'])
        call refused(error, 'design --frequencies 0.1 5', STATUS_FAILED, [character(W) :: 'frequency = 5 Hz', &
                                                                          'below 5 Hz'])
        call refused(error, QUICK//'--rate-limit 0.06', STATUS_FAILED, [character(W) :: 'no manoeuvre stays', &
                                                                        'at most 0.06 deg/s'])
        call refused(error, QUICK//'--out '//FOLDER//'no/such.nml', STATUS_FAILED, [character(W) :: 'no folder'])
    end subroutine test_design_command

    !> Without a moment there is no calibration; the observations themselves can be simulated, with a
    !> warning.
    subroutine test_rods_off(error)
        type(error_type), allocatable, intent(out) :: error

        character(:), allocatable :: text, messages, output
        integer :: place, status

        call succeeds(error, 'cases show front-3', text)
        if (allocated(error)) return
        do
            place = index(text, 'amplitude = 30')
            if (place == 0) exit
            text = text(:place - 1)//'amplitude = 0'//text(place + len('amplitude = 30'):)
        end do
        call make_file(error, 'off.nml', text)
        call refused(error, 'montecarlo --runs 2 --cases '//FOLDER//'off.nml', STATUS_FAILED, &
                     [character(W) :: 'all torque rods are off'])
        call refused(error, 'trim '//FOLDER//'off.nml', STATUS_FAILED, [character(W) :: 'all torque rods are off'])
        call refused(error, 'design --manoeuvre '//FOLDER//'off.nml', STATUS_FAILED, &
                     [character(W) :: 'all torque rods are off'])
        call run('simulate '//FOLDER//'off.nml --out '//FOLDER//'off', status, output, messages)
        call check(error, status == STATUS_DONE .and. index(messages, 'all torque rods are off') > 0, messages)
        call refused(error, 'estimate '//FOLDER//'off --algorithm optimal', STATUS_FAILED, &
                     [character(W) :: 'all torque rods are off'])
    end subroutine test_rods_off

    !> The file's angular acceleration is what its field gives: rods y and z at 30 A m^2, opposed when
    !> B_y and B_z have one sign, on the inertia of CSR-TM-00-01 section 5.2.
    subroutine test_timing(error)
        type(error_type), allocatable, intent(out) :: error
        character(14), parameter :: COLUMNS(12) = [character(14) :: &
            'time_s', 'latitude_deg', 'longitude_deg', 'bx_nt', 'by_nt', 'bz_nt', 'alpha_x_rad_s2', &
            'alpha_y_rad_s2', 'alpha_z_rad_s2', 'sigma_x_mm', 'sigma_y_mm', 'sigma_z_mm']
        real(dp), parameter :: INERTIA_X = 70.23_dp     ! kg m^2
        real(dp), parameter :: BY_PRODUCTS = 2.1e-7_dp
        ! rad/s^2, what the products of inertia add at most: (3/345.14 + 2.883/388.84)/70.23 30 31e-6
        type(error_t), allocatable :: failure
        character(:), allocatable :: output
        real(dp), allocatable :: table(:, :), expected(:)

        call succeeds(error, 'timing --satellite back --step 300 --out '//FOLDER//'back.csv', output)
        call check(error, index(output, 'case 3') > 0 .and. index(output, 'best y') > 0, output)
        call drop_utc(error, 'back.csv')
        if (allocated(error)) return
        call read_csv(FOLDER//'back.csv', COLUMNS, table, failure)
        call check_passes(error, message_of(failure))
        call check(error, size(table, 1), 19)
        call check(error, table(19, 1), 5400.0_dp)
        if (allocated(error)) return
        expected = 30*(abs(table(:, 5)) + abs(table(:, 6)))*1e-9_dp/INERTIA_X
        call check(error, maxval(abs(table(:, 7) - expected)) < BY_PRODUCTS)
        call check(error, all(table(:, 10:12) > 0))
        call refused(error, 'timing --satellite middle', STATUS_MISUSED, &
                     [character(W) :: '--satellite', 'front, back'])
        call refused(error, 'timing --step 0', STATUS_MISUSED, [character(W) :: '--step'])
        call succeeds(error, 'timing --step 600', output)
    end subroutine test_timing

    !> Folders that cannot be made or written: below a file, below /proc, or with a folder in the
    !> way.
    subroutine test_unwritable(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: UNWRITABLE(1) = ['/proc/gracecg: cannot be written']
        character(:), allocatable :: output

        call make_file(error, 'a-file', 'text')
        call refused(error, 'simulate front-1 --out '//FOLDER//'a-file/run', STATUS_FAILED, &
                     [character(W) :: 'a-file: cannot make this folder: a file of that name'])
        call refused(error, 'simulate front-1 --out '//FOLDER//'a-file', STATUS_FAILED, &
                     [character(W) :: 'a-file: cannot make this folder: a file of that name'])
        call refused(error, 'simulate front-1 --out /proc/gracecg', STATUS_FAILED, &
                     [character(W) :: '/proc/gracecg: cannot make this folder'])
        call refused(error, 'verify front-1 --out /proc/gracecg', STATUS_FAILED, &
                     [character(W) :: '/proc/gracecg: cannot make this folder'])
        call refused(error, 'montecarlo --runs 1 --out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'montecarlo --runs 1 --runs-out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'errors --runs 1 --out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'magnetometer-loss --runs 1 --out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'trim --out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'timing --out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call succeeds(error, 'verify back-2 --out '//FOLDER//'held/setup.nml', output)
        call refused(error, 'simulate front-1 --out '//FOLDER//'held', STATUS_FAILED, &
                     [character(W) :: 'held/setup.nml: is a folder'])
        call check(error, .not. file_exists(FOLDER//'held/truth.csv') .and. &
                   .not. file_exists(FOLDER//'held/accelerometer.csv'), 'half a run stands')
    end subroutine test_unwritable

    !> One object with the version, the numbers of the CSV, units and warnings; nothing else is printed.
    subroutine test_json(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, csv, messages
        type(string_t), allocatable :: fields(:)
        type(text_file_t) :: text
        integer :: status

        call succeeds(error, 'simulate front-3 --out '//FOLDER//'json3', output)
        call run('estimate '//FOLDER//'json3 --algorithm optimal --format csv', status, csv, messages)
        call run('estimate '//FOLDER//'json3 --algorithm optimal --format json --verbose', status, output, messages)
        call check(error, status, STATUS_DONE, messages)
        if (allocated(error)) return
        text = text_file_of(csv, 'output')
        fields = split(text%line(2), ',')
        call check(error, output(:1) == '{' .and. output(len(output) - 1:) == '}'//LF)
        call holds('"version": "'//VERSION//'"')
        call holds('"command": "estimate"')
        call holds('"case": "front-3"')
        call holds('"dx_mm": '//fields(2)%text//',')
        call holds('"sigma_z_mm": '//fields(7)%text//',')
        call holds('"variance_factor": '//fields(40)%text//',')
        call holds('"converged": true')
        call holds('"dx_mm": "mm"')
        call holds('"names": ["d_x", "d_y", "d_z", "alpha_x"')
        call holds('"name": "torque_x", "value": ')
        call holds('"history": [')
        call holds('"warnings": [')
        call succeeds(error, 'timing --step 600 --format json', output)
        call holds('"best_places": {')
        call holds('"alpha_x_rad_s2": "rad/s^2"')
        call succeeds(error, 'bound front-3 --format json', output)
        call holds('"ellipsoid": {')
        call succeeds(error, 'statements two-steps --runs 0 --format json', output)
        call holds('"place": "section 6.2"')
        call holds('"verdict": "holds"')
        call holds('"setting": "case 2 + 3", "runs": 0, "rms_x_mm": null')
        call holds('"predicted_x_mm": "mm"')
        call refused(error, 'bound front-3 --format xml', STATUS_MISUSED, [character(W) :: '--format', 'text, csv, json'])

    contains

        subroutine holds(part)
            character(*), intent(in) :: part

            call check(error, index(output, part) > 0, part//' is not in '//output)
        end subroutine holds
    end subroutine test_json

    subroutine test_help_command(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: help, same

        call succeeds(error, 'simulate --help', help)
        call succeeds(error, 'help simulate', same)
        call check(error, same, help)
        call succeeds(error, 'model gravity --help', help)
        call succeeds(error, 'help model gravity', same)
        call check(error, same, help)
        call succeeds(error, 'help model', help)
        call check(error, index(help, 'usage: gracecg model NAME') == 1 .and. index(help, LF//'  model star-camera') > 0 &
                   .and. index(help, 'simulate') == 0, help)
        call succeeds(error, 'model --help', same)
        call check(error, same, help)
        call refused(error, 'help simulat', STATUS_MISUSED, [character(W) :: 'unknown command "simulat"', 'simulate'])
    end subroutine test_help_command

    !> Groups stand for their cases in their order, beside names and --cases; a name may not come twice, and a command of
    !> one case takes no group of several.
    subroutine test_case_groups(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: SINGLE(4) = [character(8) :: 'timing', 'design', 'errors', 'trim']
        character(*), parameter :: SEVERAL(4) = [character(40) :: 'bound', 'verify', 'magnetometer-loss --runs 1', &
                                                 'montecarlo --runs 1']
        character(:), allocatable :: output
        integer :: i

        call succeeds(error, 'bound front --format csv', output)
        call in_order([character(16) :: 'front-1', 'front-2', 'front-3'], 3)
        call succeeds(error, 'bound front-3 --cases back,front-1 --format csv', output)
        call in_order([character(16) :: 'front-3', 'back-1', 'back-2', 'back-3', 'front-1'], 5)
        call succeeds(error, 'bound ALL --format csv', output)
        call in_order([character(16) :: REPORT_CASE_NAMES], 6)
        call succeeds(error, 'bound printed front-1 --format csv', output)
        call in_order([character(16) :: 'front-1-printed', 'front-2-printed', 'front-3-printed', 'back-1-printed', &
                       'back-2-printed', 'back-3-printed', 'front-1'], 7)
        call succeeds(error, 'verify front-2 --cases back-2 --format csv', output)
        call in_order([character(16) :: 'front-2', 'back-2'], 90)
        do i = 1, size(SINGLE)
            call refused(error, trim(SINGLE(i))//' front', STATUS_MISUSED, [character(W) :: '3 cases are named'])
            call refused(error, trim(SINGLE(i))//' front-1 --cases front-2', STATUS_MISUSED, &
                         [character(W) :: '2 cases are named'])
        end do
        do i = 1, size(SEVERAL)
            call refused(error, trim(SEVERAL(i))//' front front-2', STATUS_FAILED, &
                         [character(W) :: 'two cases have the name "front-2"'])
            call refused(error, trim(SEVERAL(i))//' --cases all,back', STATUS_FAILED, &
                         [character(W) :: 'two cases have the name "back-1"'])
        end do
        call refused(error, 'bound middle', STATUS_FAILED, [character(W) :: 'no case "middle"'])

    contains

        !> The rows' cases, each once more or often, in this order.
        subroutine in_order(names, rows)
            character(*), intent(in) :: names(:)
            integer, intent(in) :: rows

            type(text_file_t) :: text
            type(string_t), allocatable :: fields(:)
            integer :: row, k, n

            if (allocated(error)) return
            text = text_file_of(output, 'output')
            k = 0
            n = 0
            do row = 2, text%line_count()
                if (text%line(row) == '') cycle
                n = n + 1
                fields = split(text%line(row), ',')
                if (k > 0) then
                    if (fields(1)%text == names(k)) cycle
                end if
                k = k + 1
                call check(error, k <= size(names), output)
                call check(error, fields(1)%text, trim(names(k)))
                if (allocated(error)) return
            end do
            call check(error, k == size(names) .and. n == rows, output)
        end subroutine in_order
    end subroutine test_case_groups

    !> What the commands print fits the console, 100 columns where COLUMNS is not set.
    subroutine test_lines_fit(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: LINES(17) = [character(96) :: '--help', 'help model', 'cases', 'errors --runs 1', &
            'bound front-1 --check 1', 'bound back', 'montecarlo --runs 1 --seed 1234567890123456', &
            'montecarlo printed --runs 1 --algorithms assest-fde,optimal', 'magnetometer-loss --runs 1', 'trim', &
            'trim --runs 2', 'timing --step 600', 'timing back-1 --step 20 --pattern general', 'verify front-1 back-2', &
            'statements --runs 1', 'design --frequencies 0.1 0.1 --waveforms sine', &
            'design --pattern y-z --at 2658 --map map.csv --step 600']
        character(:), allocatable :: output
        integer :: i

        call make_folder(error)
        do i = 1, size(LINES)
            if (allocated(error)) return
            if (index(LINES(i), 'map.csv') > 0) then
                call succeeds(error, 'design --pattern y-z --at 2658 --step 600 --map '//FOLDER//'fit.csv', output)
            else
                call succeeds(error, trim(LINES(i)), output)
            end if
            call check(error, longest_line(output) <= console_width(), trim(LINES(i))//LF//output)
        end do
    end subroutine test_lines_fit

    !> Settings and samples beyond what the report says of an instrument are warned of; its own ones are not.
    subroutine test_instruments(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: text, output, messages
        integer :: place, status

        call make_folder(error)
        call succeeds(error, 'simulate front-1 --out '//FOLDER//'keeps', output)
        call succeeds(error, 'cases show front-1', text)
        call change('bias_nt = 50', 'bias_nt = 150')
        call change('linearity_nt = 0', 'linearity_nt = 30')
        ! of the accelerometer, which comes first
        call change('limited = .false.', 'limited = .true.')
        call change('range = 0.00005', 'range = 0.00002')
        call change('quantised = .false.', 'quantised = .true.')
        call change('resolution = 1e-10', 'resolution = 1e-9')
        call make_file(error, 'beyond.nml', text)
        call run('simulate '//FOLDER//'beyond.nml --out '//FOLDER//'beyond', status, output, messages)
        call check(error, status == STATUS_DONE, messages)
        call says('bias, x axis: 150 nT exceeds the limit 100 nT')
        call says('linearity error: 30 nT exceeds the limit 25 nT')
        call says('accelerometer resolution: 1.000000E-09 m/s^2 exceeds the limit 1.000000E-10 m/s^2')
        call says('accelerometer: 600 of 600 samples are cut off at its full scale')
        call check(error, index(messages, 'scale1') == 0, messages)
        call change('limited = .true.', 'limited = .false.')        ! at full scale no estimate is made
        call make_file(error, 'beyond.nml', text)
        call run('montecarlo '//FOLDER//'beyond.nml --runs 1', status, output, messages)
        call check(error, status == STATUS_DONE, messages)
        call says('warning: case front-1: magnetometer linearity error')

    contains

        subroutine says(part)
            character(*), intent(in) :: part

            call check(error, index(messages, part) > 0, part//' is not in '//messages)
        end subroutine says

        subroutine change(old, new)
            character(*), intent(in) :: old, new

            if (allocated(error)) return
            place = index(text, old)
            call check(error, place > 0, old)
            if (place > 0) text = text(:place - 1)//new//text(place + len(old):)
        end subroutine change
    end subroutine test_instruments

    !> Times of the orbit in UTC: 1400 s after midnight are 00:23:20; over the leap second at the end of 1990 a
    !> revolution takes a second longer on the clock.
    subroutine test_utc(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: text, output
        integer :: place

        call make_folder(error)
        call succeeds(error, 'timing --step 600', output)
        call check(error, index(output, 'case 2    1400  00:23:20') > 0 .and. &
                   index(output, 'case 3    2658  00:44:18') > 0, output)
        call succeeds(error, 'timing --step 600 --format csv', output)
        call check(error, index(output, LF//'1200,1989-01-02T00:20:00,') > 0, output)
        call succeeds(error, 'timing --step 600 --format json', output)
        call check(error, index(output, '"all_utc": "1989-01-02T0') > 0 .and. &
                   index(output, '"utc": "1989-01-02T00:23:20"') > 0, output)
        call succeeds(error, 'design --manoeuvre front-1 --at 1400 --format csv', output)
        call check(error, index(output, 'front-1,1400,1989-01-02T00:23:20,89.5') > 0, output)
        call succeeds(error, 'cases show front-1', text)
        if (allocated(error)) return
        place = index(text, '1989-01-02T00:00:00')
        call check(error, place > 0, text)
        if (allocated(error)) return
        text(place:place + 18) = '1990-12-31T23:50:00'
        place = index(text, 'density = ''dtm77''')
        call check(error, place > 0, text)
        if (allocated(error)) return
        text = text(:place - 1)//'density = ''none'''//text(place + len('density = ''dtm77'''):)
        call make_file(error, 'leap.nml', text)
        call succeeds(error, 'timing '//FOLDER//'leap.nml --step 600 --format csv', output)
        call check(error, index(output, LF//'600,1990-12-31T23:59:60,') > 0 .and. &
                   index(output, LF//'1200,1991-01-01T00:09:59,') > 0, output)
    end subroutine test_utc

    !> Rods by a rule of section 4.2: y-z gives the report's case at its place; the general rule takes other rods where the
    !> field's weakest components are others, and both exclude what searches.
    subroutine test_pattern(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: by_rule, other

        call succeeds(error, 'timing --step 300', other)
        call succeeds(error, 'timing --step 300 --pattern y-z', by_rule)
        call check(error, by_rule, other)
        call succeeds(error, 'timing --step 300 --pattern general', by_rule)
        call check(error, by_rule /= other .and. index(by_rule, 'rods by the rule general') > 0, by_rule)
        call succeeds(error, 'design --pattern y-z --at 2658', by_rule)
        call succeeds(error, 'design --manoeuvre front-3 --satellite front --at 2658', other)
        call check(error, by_rule, other)
        call succeeds(error, 'design --pattern general --at 1400', other)
        call check(error, index(other, LF//'x    sine') > 0 .and. index(other, LF//'z    sine') == 0, other)
        call refused(error, 'design --pattern general --manoeuvre front-1', STATUS_MISUSED, &
                     [character(W) :: '--manoeuvre and --pattern exclude'])
        call refused(error, 'design --pattern general --anywhere', STATUS_MISUSED, [character(W) :: '--pattern does not search'])
        call refused(error, 'timing --pattern y', STATUS_MISUSED, [character(W) :: '--pattern', 'y-z, general'])
    end subroutine test_pattern

    !> JSON of `verify` has the panels of Figures 6.2, 6.3 and 6.6.
    subroutine test_panels(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output
        integer :: i, panels

        call succeeds(error, 'verify --format json', output)
        if (allocated(error)) return
        panels = 0
        do i = 1, len(output) - 10
            if (output(i:i + 9) == '"figure": ') panels = panels + 1
        end do
        call check(error, panels, 90 + 30)
        call check(error, index(output, '"figure": "6.6", "satellite": "front", "algorithm": '// &
                   '"ascrest", "axis": "z"') > 0 .and. index(output, '"low_mm": "mm"') > 0, output)
    end subroutine test_panels

    !> What may follow some words, of which shells complete; tools/check_install.py lets bash and zsh do it.
    subroutine test_completion(error)
        type(error_type), allocatable, intent(out) :: error
        !> Words that are typed, what is offered then, and what is not
        character(*), parameter :: OFFERED(3, 13) = reshape([character(36) :: &
            '', 'magnetometer-loss:', 'gravity', '', 'level1:Level-1 data', '--help', 'model', 'star-camera:', 'simulate', &
            'help', 'simulate:', '--help', 'help model', 'gravity:', 'simulate', 'level1', 'convert:', 'gravity', &
            'magnetometer-loss', '--field-error:', '@list', 'magnetometer-loss', 'back-3', '@folders', &
            'estimate run1 --algorithm', 'sequential', '--out', 'simulate front-1 --out', '@folders', 'front-1', &
            'simulate front-1 --seed', '', 'front-1', 'montecarlo --algorithms', '@list', '@files', &
            'bound --cases', 'printed', '--cases'], [3, 13])
        character(:), allocatable :: output
        integer :: i

        do i = 1, size(OFFERED, 2)
            call succeeds(error, 'completion words -- '//trim(OFFERED(1, i)), output)
            call check(error, index(output, trim(OFFERED(2, i))) > 0 .or. OFFERED(2, i) == '', OFFERED(2, i)//output)
            call check(error, index(output, trim(OFFERED(3, i))) == 0, output)
            if (allocated(error)) return
        end do
        call succeeds(error, 'completion zsh', output)
        call check(error, index(output, '#compdef gracecg'), 1)
        call refused(error, 'completion fish', STATUS_MISUSED, [character(W) :: 'unknown shell "fish"', 'bash and zsh'])
        call refused(error, 'completion bash zsh', STATUS_MISUSED, [character(W) :: 'unexpected argument "zsh"'])
    end subroutine test_completion

    !> Level-1 files are listed, shown, converted and checked; a broken one among others is told.
    subroutine test_level1(error)
        type(error_type), allocatable, intent(out) :: error

        character(*), parameter :: DAY = FOLDER//'level1-day', TNK = 'TNK1B_2020-02-01_C_04', MAS = 'MAS1B_2020-02-01_C_04'
        character(*), parameter :: HEAD = 'header:'//LF//'    platform: GRACE C'//LF//'# End of YAML header'//LF
        character(:), allocatable :: output
        type(console_t) :: console
        type(error_t), allocatable :: failure
        integer :: status

        call make_directory(DAY, failure)
        call make_file(error, 'level1-day/'//TNK//'.txt', HEAD//'633798000 250000 G C 2 00000100 00000011 221.75 1.5'//LF// &
                       '633798001 250000 G C 2 00000000 00000001 221.5'//LF)
        call make_file(error, 'level1-day/'//MAS//'.txt', HEAD//'633798600 0 G C 00000000 11000000 13.5 13.25'//LF// &
                       '633802200 0 G C 00000000 11000000 13.4990234375 13.248046875'//LF)
        call succeeds(error, 'level1 list '//DAY//' --format csv', output)
        call check(error, index(output, TNK//'.txt,TNK1B,C,text,2,633798000.25,633798001.25,2020-02-01T03:00:00.250000,'// &
                                '2020-02-01T03:00:01.250000,1,0,0,0,0,0,1,') > 0, output)
        call succeeds(error, 'level1 dump '//DAY//'/'//TNK//'.txt', output)
        call check(error, index(output, ',text,2,633798000.25,633798001.25,tank_pres,2,221.75,221.5,221.625,221.5,221.75') &
                   > 0 .and. index(output, ',reg_pres,1,1.5,1.5,1.5,1.5,1.5') > 0 .and. &
                   index(output, ',id,2,C,C,,,') > 0 .and. index(output, ',qualflg,2,4,0,2,0,4') > 0, output)
        call succeeds(error, 'level1 convert '//DAY//'/'//TNK//'.txt --out '//FOLDER//TNK//'.dat', output)
        call succeeds(error, 'level1 dump '//FOLDER//TNK//'.dat --format records', output)
        call check(error, index(output, '633798001,250000,G,C,2,0,1,221.5,,,,,,') > 0, output)
        call succeeds(error, 'level1 check '//DAY//' --format csv', output)
        call check(error, index(output, 'quantity,value,unit,verdict'//LF//'gas_used_1,0.0009765625,kg,ok'//LF// &
                                'gas_used_2,0.001953125,kg,ok') > 0, output)
        call make_file(error, 'level1-day/'//MAS//'.txt', HEAD//'633798600 0 G'//LF)
        call refused(error, 'level1 dump '//DAY//'/'//MAS//'.txt', STATUS_FAILED, [character(W) :: MAS//'.txt:4', &
                                                                                   'field id of MAS1B'])
        ! In a list the others are shown all the same.
        console%captured = .true.
        call run_command_line([string_t('level1'), string_t('list'), string_t(DAY)], console, status, &
                              level1_commands())
        call check(error, status == STATUS_FAILED .and. index(console%messages, MAS//'.txt:4') > 0 .and. &
                   index(console%output, TNK//'.txt        2') > 0, console%output//console%messages)
        call refused(error, 'level1 check '//DAY//' --satellite A', STATUS_FAILED, [character(W) :: 'files of satellite A'])
    end subroutine test_level1

    !> Sentences for an empty path, a folder where a file is expected, and the reverse.
    subroutine test_paths(error)
        type(error_type), allocatable, intent(out) :: error
        type(console_t) :: console
        integer :: status

        call make_folder(error)
        call make_file(error, 'a-file', 'x')
        if (allocated(error)) return
        console%captured = .true.
        call run_command_line([string_t('simulate'), string_t('front-1'), string_t('--out'), string_t('')], console, status)
        call check(error, status == STATUS_MISUSED .and. index(console%messages, 'the value DIR is empty') > 0, console%messages)
        if (allocated(error)) return
        call run_command_line([string_t('simulate'), string_t(''), string_t('--out'), string_t('x')], console, status)
        call check(error, status == STATUS_MISUSED .and. index(console%messages, 'an argument is empty: CASE') > 0, &
                   console%messages)
        call refused(error, 'estimate '//FOLDER//'a-file --algorithm optimal', STATUS_FAILED, &
                     [character(W) :: 'a-file', 'is a file'])
        call refused(error, 'simulate '//FOLDER//' --out '//FOLDER//'x', STATUS_FAILED, [character(W) :: 'is a folder'])
        call refused(error, 'simulate front-1 --out '//FOLDER//'a-file', STATUS_FAILED, &
                     [character(W) :: 'a-file', 'a file of that name is in the way'])
        call refused(error, 'timing --step 600 --out '//FOLDER, STATUS_FAILED, [character(W) :: 'is a folder; name a file'])
        call refused(error, 'simulate front-1 --out '//FOLDER//'a-file/below', STATUS_FAILED, &
                     [character(W) :: 'a file of that name is in the way'])
    end subroutine test_paths

    !> Degree 0 is the point mass; the whole model differs from it by the oblateness, some 1e-3.
    subroutine test_gravity(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HEADER = 'ax_m_s2,ay_m_s2,az_m_s2,potential_m2_s2'
        real(dp) :: point(4), full(4)
        real(dp), parameter :: R = 6837865.0_dp

        call row_of(error, 'model gravity --degree 0'//EQUATOR, HEADER, point)
        call row_of(error, 'model gravity'//EQUATOR, HEADER, full)
        call check(error, abs(point(1) + EARTH_GM/R**2) < 1e-14_dp*10 .and. &
                   abs(point(2)) <= 0 .and. abs(point(4) - EARTH_GM/R) < 1e-8_dp*10)
        call check(error, full(1)/point(1) > 1.0013_dp .and. full(1)/point(1) < 1.0015_dp)
        call refused(error, 'model gravity --degree 71'//EQUATOR, STATUS_FAILED, [character(W) :: '70'])
        call refused(error, 'model gravity --degree 5 --order 6'//EQUATOR, STATUS_FAILED, &
                     [character(W) :: 'order'])
        call refused(error, 'model gravity --file nowhere.gfc'//EQUATOR, STATUS_FAILED, &
                     [character(W) :: 'nowhere.gfc: no such file'])
    end subroutine test_gravity

    !> On the equator at Greenwich radial is x, south -z, east y. The two tables agree in 1989.
    subroutine test_field(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HEADER = &
            'bx_tesla,by_tesla,bz_tesla,b_radial_tesla,b_south_tesla,b_east_tesla'
        character(*), parameter :: IN_1989 = 'model field --date 1989-01-02T00:00:00'
        real(dp) :: old(6), new(6)

        call row_of(error, IN_1989//EQUATOR, HEADER, old)
        call row_of(error, IN_1989//' --table igrf14'//EQUATOR, HEADER, new)
        call check(error, maxval(abs(old(4:6) - [old(1), -old(3), old(2)])) <= 0)
        call check(error, maxval(abs(old - new)) < 1e-12_dp .and. norm2(old(:3)) > 2e-5_dp)
        call refused(error, 'model field --date 2005-06-01'//EQUATOR, STATUS_FAILED, &
                     [character(W) :: 'igrf95', '1985 to 2000', 'igrf14 covers 1900 to 2030'])
    end subroutine test_field

    !> The density is the sum over the constituents (with O2, a little more); the row of the table
    !> is that of the indices given.
    subroutine test_density(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HEADER = &
            'density_kg_m3,temperature_kelvin,exospheric_temperature_kelvin,n_he_per_m3,n_o_per_m3,n_n2_per_m3,'// &
            'height_km,latitude_deg,local_time_h,day,f107_sfu,f107a_sfu,kp'
        character(*), parameter :: AT = 'model density --date 1989-01-02T06:00:00'//EQUATOR
        real(dp), parameter :: ATOMIC_MASS_UNIT = 1.66054e-27_dp
        real(dp) :: air(13), same(13), sum_of_parts

        call row_of(error, AT, HEADER, air)
        call row_of(error, AT//' --f107 185.7 --f107a 210.6 --kp 2.7', HEADER, same)
        if (allocated(error)) return
        sum_of_parts = ATOMIC_MASS_UNIT*(4*air(4) + 16*air(5) + 28*air(6))
        call check(error, sum_of_parts/air(1) < 1.001_dp .and. sum_of_parts/air(1) > 0.98_dp)
        call check(error, air(1) > 1e-12_dp .and. air(1) < 1e-11_dp .and. air(2) < air(3))
        call check(error, all(abs(air(7:10) - [459.728_dp, 0.0_dp, 6.0_dp, 1.25_dp]) < 1e-9_dp))
        call refused(error, 'model density --date 1995-06-01'//EQUATOR, STATUS_FAILED, &
                     [character(W) :: '--f107, --f107a and --kp', '1988-12-01 to 1989-02-28'])
        call refused(error, AT//' --f107 10 --f107a 210 --kp 2', STATUS_FAILED, [character(W) :: '10', '50'])
        call refused(error, 'model density --date 1989-01-02 --position 6.4e6 0 0', STATUS_FAILED, &
                     [character(W) :: 'height 21.863 km', 'valid from 120 km'])
    end subroutine test_density

    subroutine test_wind_model(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: WIND_HEADER = 'east_m_s,north_m_s,height_km,latitude_deg,local_time_h'
        real(dp) :: wind(5), later(5)
        character(:), allocatable :: output

        call row_of(error, 'model wind --date 1989-01-02'//EQUATOR, WIND_HEADER, wind)
        ! a day later at the same place it is the same local time
        call row_of(error, 'model wind --date 1989-01-03'//EQUATOR, WIND_HEADER, later)
        call check(error, maxval(abs(wind - later)) <= 0 .and. norm2(wind(:2)) > 10 .and. norm2(wind(:2)) < 500)
        call succeeds(error, 'model wind --date 1989-01-02 --format json'//EQUATOR, output)
        call check(error, index(output, '"note": "HWM93 of 1989-01-02') > 0, output)
    end subroutine test_wind_model

    !> On 2 January 1989: right ascension 281.9 deg, declination -23 deg, near the perihelion.
    subroutine test_sun_model(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: sun(4)
        real(dp), parameter :: DEGREE = acos(-1.0_dp)/180

        call row_of(error, 'model sun --date 1989-01-02T00:00:00', 'x_m,y_m,z_m,distance_au', sun)
        call check(error, abs(norm2(sun(:3))/ASTRONOMICAL_UNIT - sun(4)) < 1e-14_dp*10)
        call check(error, abs(sun(4) - 0.9833_dp) < 1e-4_dp)
        call check(error, abs(atan2(sun(2), sun(1))/DEGREE + 360 - 282.75_dp) < 1 .and. &
                   abs(asin(sun(3)/norm2(sun(:3)))/DEGREE + 23) < 0.5_dp)
    end subroutine test_sun_model

    !> The error stays within five sigma of the boresight's, which is the greatest; other runs
    !> differ.
    subroutine test_star_camera_model(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HEADER = 'q1,q2,q3,q4,stars,angle_error_arcsec,quest_and_q_method_arcsec,'// &
                                   'sigma_x_arcsec,sigma_y_arcsec,sigma_boresight_arcsec'
        character(*), parameter :: AT = 'model star-camera --quaternion 0.5 -0.5 0.5 0.5'
        real(dp) :: first(10), second(10), other(10)

        call row_of(error, AT, HEADER, first)
        call row_of(error, AT//' --run 2', HEADER, second)
        call row_of(error, AT//' --head 2', HEADER, other)
        call check(error, abs(norm2(first(:4)) - 1) < 1e-14_dp .and. first(5) >= 2 .and. first(5) <= 20)
        call check(error, first(6) > 0 .and. first(6) < 50 .and. maxval(abs(first(:4) - second(:4))) > 0)
        call check(error, maxval(abs(first(:4) - other(:4))) > 0.1_dp)
        call refused(error, 'model star-camera --quaternion 0 0 0 0', STATUS_FAILED, &
                     [character(W) :: '--quaternion', 'not a unit quaternion'])
        call refused(error, 'model star-camera --quaternion 0.5 0.5 0.5 0.6', STATUS_FAILED, &
                     [character(W) :: 'not a unit quaternion'])
        call refused(error, AT//' --head 3', STATUS_MISUSED, [character(W) :: '--head', 'from 1 to 2'])
    end subroutine test_star_camera_model

    subroutine test_impossible(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: MODELS(4) = [character(27) :: 'gravity', &
                                                'field --date 1989-01-02', &
                                                'density --date 1989-01-02', &
                                                'wind --date 1989-01-02']
        integer :: i

        do i = 1, size(MODELS)
            call refused(error, 'model '//trim(MODELS(i))//' --position 0 0 0', STATUS_FAILED, &
                         [character(W) :: '--position', 'inside the Earth'])
            call refused(error, 'model '//trim(MODELS(i))//' --position 6370e3 0 0', &
                         STATUS_FAILED, [character(W) :: '--position', &
                         '8.137 km below the ellipsoid'])
            call refused(error, 'model '//trim(MODELS(i))//' --position 6837.865 0 0', &
                         STATUS_FAILED, [character(W) :: 'give Earth-fixed metres'])
        end do
    end subroutine test_impossible
end module test_commands
