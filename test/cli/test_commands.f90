!> The commands, run in this process with what they say captured: usage, help, formats, what cannot be written,
!> and the commands that have no tests of their own.
module test_commands
    use vocabulary
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: split
    use gracecg_files_file, only: text_file_t, read_text_file, text_file_of, file_exists, make_directory
    use gracecg_files_table, only: read_csv
    use gracecg_studies_curves, only: CURVE_NAMES, curve_column
    use gracecg_cli_console, only: console_t, console_width
    use gracecg_cli_command_line, only: run_command_line
    use gracecg_level1_commands, only: level1_commands
    use gracecg_level1_simulation_settings, only: level1_settings_t, read_level1_settings
    use command_fixture
    implicit none
    private
    public :: collect_commands

    character(*), parameter :: LF = new_line('a')
    character(*), parameter :: EQUATOR = ' --position 6837865 0 0'

contains

    subroutine collect_commands(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('overview', test_overview), &
                    new_unittest('progress-in-a-log', test_progress_log), &
                    new_unittest('version', test_version), &
                    new_unittest('wrong-usage', test_wrong_usage), &
                    new_unittest('verify', test_verify), &
                    new_unittest('timing', test_timing), &
                    new_unittest('design', test_design_command), &
                    new_unittest('design-whisper', test_whisper_command), &
                    new_unittest('unwritable', test_unwritable), &
                    new_unittest('json', test_json), &
                    new_unittest('help-command', test_help_command), &
                    new_unittest('lines-fit', test_lines_fit), &
                    new_unittest('pattern', test_pattern), &
                    new_unittest('level1', test_level1), &
                    new_unittest('empty-and-wrong-paths', test_paths)]
    end subroutine collect_commands

    !> Without a terminal a line of progress a minute, where it is wanted.
    subroutine test_progress_log(error)
        type(error_type), allocatable, intent(out) :: error
        type(console_t) :: console

        console%captured = .true.
        call console%progress('unseen')
        call check(error, .not. allocated(console%messages))
        console%logs_progress = .true.
        call console%progress('1 of 3')
        if (unmet(error, .not. allocated(console%messages), 'a short work says nothing')) return
        console%log_interval = 0
        call console%progress('2 of 3')
        call check(error, console%messages, '2 of 3'//new_line('a'))
    end subroutine test_progress_log

    subroutine test_overview(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, same, help

        call succeeds(error, '--help', output)
        call succeeds(error, '', same)
        call check(error, output, same)
        call check_says(error, output, LF//'  simulate  ... '//LF//'  model orientation ')
        call succeeds(error, 'simulate --help', help)
        call check(error, index(help, 'usage: gracecg simulate CASE --out DIR') == 1, help)
    end subroutine test_overview

    !> The version is that of fpm.toml (the tester runs in the project's folder).
    subroutine test_version(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, manifest

        call succeeds(error, '--version', output)
        call check(error, output, 'gracecg '//VERSION//LF)
        call read_content(error, 'fpm.toml', manifest)
        call check_says(error, manifest, LF//'version = "'//VERSION//'"'//LF)
    end subroutine test_version

    subroutine test_wrong_usage(error)
        type(error_type), allocatable, intent(out) :: error

        call refused(error, 'simulat front-1', STATUS_MISUSED, 'unknown command "simulat" ... did you mean "simulate"?')
        call refused(error, 'model fild', STATUS_MISUSED, 'did you mean "model field"?')
        call refused(error, 'model', STATUS_MISUSED, 'gravity ... orientation')
        call refused(error, 'level1', STATUS_MISUSED, 'which level1? ... list ... dump')
        call refused(error, 'level1 lst x', STATUS_MISUSED, 'did you mean "level1 list"?')
        call refused(error, 'level1 dump x --format json', STATUS_MISUSED, 'one of csv, records')
        call refused(error, 'level1 convert x', STATUS_MISUSED, '--out FILE is required')
        call refused(error, 'level1 convert x --out x', STATUS_MISUSED, 'the same file as the input')
        call refused(error, 'level1 dump no-such-file', STATUS_FAILED, 'no such file')
        call refused(error, 'simulate front-1', STATUS_MISUSED, '--out DIR is required ... usage: gracecg simulate')
        call refused(error, 'simulate front-1 --out x --seed one', STATUS_MISUSED, '--seed ... "one"')
        call refused(error, 'simulate front-1 --out x --run -1', STATUS_MISUSED, '--run')
        call refused(error, 'estimate x', STATUS_MISUSED, '--algorithm NAME is required')
        call refused(error, 'estimate x --algorithm asest-fde', STATUS_MISUSED, 'did you mean "assest-fde"?')
        call refused(error, 'estimate x --algorithm assest-fde --format html', STATUS_MISUSED, '--format ... one of text, csv')
        call refused(error, 'cases shw front-1', STATUS_MISUSED, 'did you mean "show"?')
        call refused(error, 'cases show', STATUS_MISUSED, 'which case?')
        call refused(error, 'model gravity', STATUS_MISUSED, '--position X Y Z is required')
        call refused(error, 'model gravity --position nan 0 0', STATUS_MISUSED, '"nan"')
        call refused(error, 'model gravity --position 7e6 0', STATUS_MISUSED, '--position takes 3 values')
        call refused(error, 'model sun --date 1989-13-01', STATUS_MISUSED, 'month 13')
        call refused(error, 'model density --date 1989-01-02 --kp 3'//EQUATOR, STATUS_MISUSED, &
                     'all three of --f107, --f107a and --kp')
        call refused(error, 'model field --date 1989-01-02 --table igrf14 --file x'//EQUATOR, STATUS_MISUSED, &
                     '--table or --file, not both')
    end subroutine test_wrong_usage

    subroutine test_verify(error)
        type(error_type), allocatable, intent(out) :: error
        character(32) :: columns(1 + 3*size(CURVE_NAMES))
        type(error_t), allocatable :: failure
        character(:), allocatable :: output
        real(dp), allocatable :: table(:, :)
        integer :: i, axis

        call succeeds(error, 'verify front-1 back-3 --out '//FOLDER//'curves', output)
        call check_says(error, output, 'attitude dynamics alone: 27 of 27 inside')
        call check(error, longest_line(output) <= 100, output)
        columns(1) = 'time_s'
        do i = 1, size(CURVE_NAMES)
            do axis = 1, 3
                columns(1 + 3*(i - 1) + axis) = curve_column(CURVE_NAMES(i), char(ichar('x') + axis - 1))
            end do
        end do
        call read_csv(FOLDER//'curves/verify_back-3.csv', columns, table, failure)
        call check_passes(error, failure)
        if (unmet(error, size(table, 1), 601)) return
        ! a_total = a_vel + a_gg + a_acc
        call check(error, maxval(abs(table(:, 23:25) - table(:, 14:16) - table(:, &
                17:19) - table(:, 20:22))) < 1e-22_dp)
        call refused(error, 'verify front-1 front-1', STATUS_FAILED, 'two cases have the name "front-1"')
        call refused(error, 'verify front-4', STATUS_FAILED, 'no case "front-4"')
    end subroutine test_verify

    !> The file without its second column, which has to be `utc`.
    subroutine drop_utc(error, name)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name        !! In FOLDER
        type(text_file_t) :: file
        type(string_t), allocatable :: fields(:)
        type(error_t), allocatable :: failure
        character(:), allocatable :: rest
        integer :: i, k

        call read_text_file(FOLDER//name, file, failure)
        if (failed(error, failure)) return
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
        call make_file(name, rest)
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

        call prints(error, QUICK//'back-1 --at 1400 --out '//FOLDER// 'design.nml --map '//FOLDER//'map.csv --step 600', &
                    'this manoeuvre ... 5, 6, 7 cycles ... worst place')
        call prints(error, 'cases show '//FOLDER//'design.nml', '1989-01-02T00:23:20 ... back-1-design')
        call succeeds(error, 'simulate '//FOLDER//'design.nml --out '//FOLDER//'design', output)
        call succeeds(error, 'estimate '//FOLDER//'design --algorithm assest-rde', output)
        call prints(error, 'bound '//FOLDER//'design.nml', 'scale factors, magnetometer bias, which are estimated')
        call drop_utc(error, 'map.csv')
        if (allocated(error)) return
        call read_csv(FOLDER//'map.csv', [character(24) :: FIRST_COLUMNS, 'wave_x_mm', 'wave_y_mm', 'wave_z_mm', &
                                          'force_x_mm', 'force_y_mm', 'force_z_mm', 'rate_deg_s', &
                                          'pointing_deg'], table, failure)
        call check_passes(error, failure)
        call check(error, size(table, 1), 10, 'a revolution has ten places 600 s apart')
        call succeeds(error, 'design --manoeuvre '//FOLDER//'design.nml --format csv', output)
        call check(error, index(output, 'case,time_s,utc,latitude_deg') == 1 .and. &
                   index(output, 'back-1-design,0,') > 0, output)

        call refused(error, QUICK//'--manoeuvre front-1', STATUS_MISUSED, 'is for the search')
        call refused(error, 'design --manoeuvre front-1 --frequencies 0.1 0.2', STATUS_MISUSED, &
                     '--frequencies is for the search')
        call refused(error, QUICK//'--rods w', STATUS_MISUSED, '--rods ... "w"')
        call refused(error, QUICK//'--anywhere --at 3', STATUS_MISUSED, '--anywhere')
        call refused(error, 'design --frequencies 0.1 5', STATUS_FAILED, 'frequency = 5 Hz ... below 5 Hz')
        call refused(error, QUICK//'--rate-limit 0.06', STATUS_FAILED, 'no manoeuvre stays ... at most 0.06 deg/s')
        call refused(error, QUICK//'--out '//FOLDER//'no/such.nml', STATUS_FAILED, 'no folder')
    end subroutine test_design_command

    !> Tones all the time: a table of what they reach, members of JSON, a file that `level1 simulate` reads with what was printed.
    subroutine test_whisper_command(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_settings_t) :: level1
        type(error_t), allocatable :: failure
        character(:), allocatable :: output

        call succeeds(error, 'design front-3 --whisper --amplitude 0.5 --out '//FOLDER//'tones.nml', output)
        call check_says(error, output, 'week ... next: gracecg level1 simulate front-3')
        call read_level1_settings(FOLDER//'tones.nml', level1, failure)
        call check_passes(error, failure)
        call check(error, all(abs(level1%whisper - 2) < 1e-6_dp) .and. level1%rod_control .and. level1%spans == 0, 'settings')
        call check(error, all(level1%whisper_frequency >= 0.05_dp .and. level1%whisper_frequency <= 0.15_dp), 'frequencies')
        call prints(error, 'design front-3 --whisper --format json', '"tones": [ ... "range_m": ')
        call refused(error, 'design example/cases/nggm.nml --whisper', STATUS_FAILED, 'has torquers')
        call refused(error, 'design --whisper --at 3', STATUS_MISUSED, '--at is of a manoeuvre')
        call refused(error, 'design --whisper --frequencies 0.1 0.11', STATUS_FAILED, 'three tones need')
    end subroutine test_whisper_command

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

        call prints(error, 'timing back-1 --step 300 --out '//FOLDER//'back.csv', 'case 3 ... best y')
        call drop_utc(error, 'back.csv')
        if (allocated(error)) return
        call read_csv(FOLDER//'back.csv', COLUMNS, table, failure)
        call check_passes(error, failure)
        call check(error, size(table, 1), 19)
        call check(error, table(19, 1), 5400.0_dp)
        expected = 30*(abs(table(:, 5)) + abs(table(:, 6)))*1e-9_dp/INERTIA_X
        call check(error, maxval(abs(table(:, 7) - expected)) < BY_PRODUCTS)
        call check(error, all(table(:, 10:12) > 0))
        call refused(error, 'timing --step 0', STATUS_MISUSED, '--step')
        call succeeds(error, 'timing --step 600', output)
    end subroutine test_timing

    !> Folders that cannot be made or written: below a file, below /proc, or with a folder in the
    !> way. Of a simulation that gives way to that of another case is told. Refused before the work is done: nothing is printed.
    subroutine test_unwritable(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: UNWRITABLE = '/proc/gracecg: cannot be written'
        character(:), allocatable :: output, messages

        call make_file('a-file', 'text')
        call refused(error, 'simulate front-1 --out '//FOLDER//'a-file/run', STATUS_FAILED, &
                     'a-file: cannot make this folder: a file of that name')
        call refused(error, 'simulate front-1 --out '//FOLDER//'a-file', STATUS_FAILED, &
                     'a-file: cannot make this folder: a file of that name')
        call refused(error, 'simulate front-1 --out /proc/gracecg', STATUS_FAILED, '/proc/gracecg: cannot make this folder')
        call refused(error, 'verify front-1 --out /proc/gracecg', STATUS_FAILED, '/proc/gracecg: cannot make this folder')
        call refused(error, 'montecarlo --runs 1 --out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'montecarlo --runs 1 --runs-out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'errors --runs 1 --out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'magnetometer-loss --runs 1 --out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'trim --out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'timing --out /proc/gracecg', STATUS_FAILED, UNWRITABLE)
        call refused(error, 'timing --out build/no-such-folder/x.csv', STATUS_FAILED, 'x.csv ... there is no folder')
        call succeeds(error, 'simulate front-1 --out '//FOLDER//'replaced', output, messages)
        call succeeds(error, 'simulate front-1 --out '//FOLDER//'replaced --seed 2', output, messages)
        call check(error, messages, '')
        call succeeds(error, 'simulate front-3 --out '//FOLDER//'replaced', output, messages)
        call check_says(error, messages, 'replaced held a simulation of case front-1, seed 2, run 1')
        call succeeds(error, 'verify back-2 --out '//FOLDER//'held/setup.nml', output)
        call refused(error, 'simulate front-1 --out '//FOLDER//'held', STATUS_FAILED, 'held/setup.nml: is a folder')
        call check(error, .not. file_exists(FOLDER//'held/truth.csv') .and. &
                   .not. file_exists(FOLDER//'held/accelerometer.csv'), 'half a run stands')
    end subroutine test_unwritable

    !> One object with the version, the numbers of the CSV, units and warnings; nothing else is printed.
    subroutine test_json(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, csv, messages
        type(string_t), allocatable :: fields(:)
        type(text_file_t) :: text

        call succeeds(error, 'simulate front-3 --out '//FOLDER//'json3', output)
        call succeeds(error, 'estimate '//FOLDER//'json3 --algorithm optimal --format csv', csv, messages)
        call succeeds(error, 'estimate '//FOLDER//'json3 --algorithm optimal --format json --verbose', output, messages)
        text = text_file_of(csv, 'output')
        fields = split(text%line(2), ',')
        call check(error, output(:1) == '{' .and. output(len(output) - 1:) == '}'//LF)
        call check_says(error, output, '"version": "'//VERSION//'" ... "command": "estimate" ... "case": "front-3"')
        call check_says(error, output, '"dx_mm": '//fields(2)%text//', ... "sigma_z_mm": '//fields(7)%text//',')
        call check_says(error, output, '"variance_factor": '//fields(40)%text//', ... "converged": true ... "dx_mm": "mm"')
        call check_says(error, output, '"names": ["d_x", "d_y", "d_z", "alpha_x" ... "name": "torque_x", "value": ')
        call check_says(error, output, '"history": [ ... "warnings": [')
        call prints(error, 'timing --step 600 --format json', '"best_places": { ... "alpha_x_rad_s2": "rad/s^2"')
        call prints(error, 'bound front-3 --format json', '"ellipsoid": {')
        call succeeds(error, 'statements two-steps --runs 0 --format json', output)
        call check_says(error, output, '"place": "section 6.2" ... "verdict": "holds"')
        call check_says(error, output, '"setting": "case 2 + 3", "runs": 0, "rms_x_mm": null ... "predicted_x_mm": "mm"')
        call refused(error, 'bound front-3 --format xml', STATUS_MISUSED, '--format ... text, csv, json')
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
        call check(error, index(help, 'usage: gracecg model NAME') == 1 .and. index(help, LF//'  model orientation') > 0 &
                   .and. index(help, 'simulate') == 0, help)
        call succeeds(error, 'model --help', same)
        call check(error, same, help)
        call refused(error, 'help simulat', STATUS_MISUSED, 'unknown command "simulat" ... simulate')
    end subroutine test_help_command

    !> What the commands print fits the console, 100 columns where COLUMNS is not set.
    subroutine test_lines_fit(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: LINES(17) = [character(96) :: '--help', 'help model', 'cases', 'errors --runs 1', &
            'bound front-1', 'bound back', 'montecarlo --runs 1 --seed 1234567890123456', &
            'montecarlo printed --runs 1 --algorithms assest-fde,optimal', 'magnetometer-loss --runs 1', 'trim', &
            'trim --runs 2', 'timing --step 600', 'timing back-1 --step 20 --pattern general', 'verify front-1 back-2', &
            'statements --runs 1', 'design --frequencies 0.1 0.1 --waveforms sine', &
            'design --manoeuvre front-3 --map map.csv --step 600']
        character(:), allocatable :: output
        integer :: i

        do i = 1, size(LINES)
            if (index(LINES(i), 'map.csv') > 0) then
                call succeeds(error, 'design --manoeuvre front-3 --step 600 --map '//FOLDER//'fit.csv', output)
            else
                call succeeds(error, trim(LINES(i)), output)
            end if
            call check(error, longest_line(output) <= console_width(), trim(LINES(i))//LF//output)
        end do
    end subroutine test_lines_fit

    !> Rods by a rule of section 4.2: y-z gives the report's case at its place; the general rule takes other rods where the
    !> field's weakest components are others.
    subroutine test_pattern(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: by_rule, other

        call succeeds(error, 'timing --step 300', other)
        call succeeds(error, 'timing --step 300 --pattern y-z', by_rule)
        call check(error, by_rule, other)
        call succeeds(error, 'timing --step 300 --pattern general', by_rule)
        call check(error, by_rule /= other .and. index(by_rule, 'rods by the rule general') > 0, by_rule)
        call refused(error, 'timing --pattern y', STATUS_MISUSED, '--pattern ... y-z, general')
    end subroutine test_pattern

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
        call make_file('level1-day/'//TNK//'.txt', HEAD//'633798000 250000 G C 2 00000100 00000011 221.75 1.5'//LF// &
                       '633798001 250000 G C 2 00000000 00000001 221.5'//LF)
        call make_file('level1-day/'//MAS//'.txt', HEAD//'633798600 0 G C 00000000 11000000 13.5 13.25'//LF// &
                       '633802200 0 G C 00000000 11000000 13.4990234375 13.248046875'//LF)
        call succeeds(error, 'level1 list '//DAY//' --format csv', output)
        call check(error, index(output, TNK//'.txt,TNK1B,C,text,2,633798000.25,633798001.25,2020-02-01T03:00:00.250000,'// &
                                '2020-02-01T03:00:01.250000,1,0,0,0,0,0,1,') > 0, output)
        call succeeds(error, 'level1 dump '//DAY//'/'//TNK//'.txt', output)
        call check_says(error, output, &
                        ',text,2,633798000.25,633798001.25,tank_pres,2,221.75,221.5,221.625,221.5,221.75 ... '// &
                        ',reg_pres,1,1.5,1.5,1.5,1.5,1.5 ... ,id,2,C,C,,, ... ,qualflg,2,4,0,2,0,4')
        call succeeds(error, 'level1 convert '//DAY//'/'//TNK//'.txt --out '//FOLDER//TNK//'.dat', output)
        call prints(error, 'level1 dump '//FOLDER//TNK//'.dat --format records', '633798001,250000,G,C,2,0,1,221.5,,,,,,')
        call succeeds(error, 'level1 check '//DAY//' --format csv', output)
        call check_says(error, output, &
                        'quantity,value,unit,verdict'//LF//'gas_used_1,0.0009765625,kg,ok'//LF//'gas_used_2,0.001953125,kg,ok')
        call make_file('level1-day/'//MAS//'.txt', HEAD//'633798600 0 G'//LF)
        call refused(error, 'level1 dump '//DAY//'/'//MAS//'.txt', STATUS_FAILED, MAS//'.txt:4 ... field id of MAS1B')
        ! In a list the others are shown all the same.
        console%captured = .true.
        call run_command_line([string_t('level1'), string_t('list'), string_t(DAY)], console, status, &
                              level1_commands())
        call check(error, status == STATUS_FAILED .and. index(console%messages, MAS//'.txt:4') > 0 .and. &
                   index(console%output, TNK//'.txt        2') > 0, console%output//console%messages)
        call refused(error, 'level1 check '//DAY//' --satellite A', STATUS_FAILED, 'files of satellite A')
    end subroutine test_level1

    !> Sentences for an empty path, a folder where a file is expected, and the reverse.
    subroutine test_paths(error)
        type(error_type), allocatable, intent(out) :: error
        type(console_t) :: console
        integer :: status

        call make_file('a-file', 'x')
        console%captured = .true.
        call run_command_line([string_t('simulate'), string_t('front-1'), string_t('--out'), string_t('')], console, status)
        call check(error, status == STATUS_MISUSED .and. index(console%messages, 'the value DIR is empty') > 0, console%messages)
        call run_command_line([string_t('simulate'), string_t(''), string_t('--out'), string_t('x')], console, status)
        call check(error, status == STATUS_MISUSED .and. index(console%messages, 'an argument is empty: CASE') > 0, &
                   console%messages)
        call refused(error, 'estimate '//FOLDER//'a-file --algorithm optimal', STATUS_FAILED, 'a-file ... is a file')
        call refused(error, 'simulate '//FOLDER//' --out '//FOLDER//'x', STATUS_FAILED, 'is a folder')
        call refused(error, 'timing --step 600 --out '//FOLDER, STATUS_FAILED, 'is a folder; name a file')
    end subroutine test_paths
end module test_commands
