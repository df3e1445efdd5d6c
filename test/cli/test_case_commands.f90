!> Cases on the command line: the list, files of them, whole and broken, edited ones, and what refuses a case.
module test_case_commands
    use vocabulary
    use gracecg_base_text, only: split, split_words, real_text
    use gracecg_files_file, only: text_file_t, text_file_of, read_text_file, file_exists, remove_file
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use command_fixture
    implicit none
    private
    public :: collect_case_commands

    character(*), parameter :: LF = new_line('a')

contains

    subroutine collect_case_commands(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('a-satellite-of-one''s-own', test_own_satellite), &
                    new_unittest('what-is-next-works-as-typed', test_next), &
                    new_unittest('cases', test_cases), &
                    new_unittest('case-files', test_case_files), &
                    new_unittest('broken-case-files', test_broken_cases), &
                    new_unittest('long-case-names', test_long_names), &
                    new_unittest('edited-cases', test_edited_cases), &
                    new_unittest('rods-that-are-off', test_rods_off), &
                    new_unittest('case-groups', test_case_groups), &
                    new_unittest('instruments-beyond-their-limits', test_instruments), &
                    new_unittest('noise-as-a-table', test_noise_table), &
                    new_unittest('times-in-utc', test_utc)]
    end subroutine collect_case_commands

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
        words = split_words(list%line(5))
        call check(error, words(4)%text(:2) == '10' .and. words(5)%text(:2) == '67', list%line(5))
        call refused(error, 'cases show frnt-1', STATUS_FAILED, &
                     'no case "frnt-1" ... front-1, front-2 ... did you mean "front-1"?')
    end subroutine test_cases

    !> A case shown, saved and run gives exactly the numbers of the built-in case.
    subroutine test_case_files(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, messages
        character(*), parameter :: FILES(6) = [character(17) :: 'truth.csv', 'accelerometer.csv', 'star_camera.csv', &
            'magnetometer.csv', 'orbit.csv', 'setup.nml']
        integer :: i, k

        do i = 1, size(REPORT_CASE_NAMES)
            associate (name => REPORT_CASE_NAMES(i))
                call succeeds(error, 'cases show '//name, output)
                call make_file('case.nml', output)
                call succeeds(error, 'simulate '//name//' --out '//FOLDER//'named', output, messages)    ! another case's place
                call succeeds(error, 'simulate '//FOLDER//'case.nml --out '//FOLDER//'filed', output, messages)
            end associate
            do k = 1, size(FILES)
                call check_same_files(error, 'named/'//trim(FILES(k)), 'filed/'//trim(FILES(k)))
            end do
        end do
    end subroutine test_case_files

    !> The columns of montecarlo give way to a long name.
    subroutine test_long_names(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: NAME = 'with-physical-weights'
        character(:), allocatable :: output

        call edit_case(error, 'front-3', 'case.nml', 'front-3', NAME)
        call succeeds(error, 'montecarlo --runs 1 --algorithms ascrest --cases front-1,'//FOLDER//'case.nml', output)
        call check_says(error, output, LF//NAME//'  ascrest    x   ... '//LF//NAME//'  0.3000 ')
        call check_says(error, output, LF//'front-1'//repeat(' ', len(NAME) - 5)//'ascrest    x  ')
    end subroutine test_long_names

    !> Case files with one line changed: the message names file, line and key, and nothing is
    !> written.
    subroutine test_broken_cases(error)
        type(error_type), allocatable, intent(out) :: error

        call broken('mass =', 'mas = 420', 'mas ... mass')
        call broken('duration =', 'durration = 60', 'broken.nml:5 ... durration ... duration')
        call broken('mass =', 'mass = heavy', 'broken.nml:10 ... mass ... "heavy"')
        call broken('mass =', 'mass =', 'broken.nml:10 ... mass ... value')
        call broken('mass =', 'mass = -1', 'broken.nml:10 ... mass ... -1 ... 0.001 to')
        call broken('mass =', 'mass = nan', 'broken.nml:10 ... mass ... nan')
        call broken('mass =', 'mass = 0.5', 'broken.nml:10 ... radius of gyration of 28 m ... mass is in kg')
        call broken('position =', 'position = 7e6, 0', 'broken.nml: ... position ... 3')
        call broken('quaternion =', 'quaternion = 0.5, 0.5, 0.5, 0.6', 'broken.nml: ... quaternion ... not a unit quaternion')
        call broken('epoch =', 'epoch = ''1995-01-02T00:00:00''', &
                    'no space weather for 1995-01-02 ... 1988-12-01 to 1989-02-28')
        call broken('epoch =', 'epoch = ''2003-01-02T00:00:00''', 'igrf95 ... 1985 to 2000 ... igrf14')
        call broken('epoch =', 'epoch = ''1989-01-32''', 'broken.nml:4 ... epoch ... day 32')
        call broken('gravity =', 'gravity = ''file''', 'broken.nml: ... gravity_file ... names no file')
        call broken('solar_irradiance =', 'solar_irradiance = 0', 'broken.nml: ... solar_irradiance ... 1 to 10000')
        call broken('wind_file =', 'wind_file = ''wind.txt''', 'broken.nml: ... wind_file ... a file that is not used')
        call broken('density =', 'density = ''msis''', 'broken.nml: ... "msis" ... dtm77')

    contains

        subroutine broken(key, text, parts)
            character(*), intent(in) :: key, text, parts
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
            call make_file('broken.nml', good%text(:good%first(line) - 1)//text// &
                           good%text(good%last(line) + 1:))
            call refused(error, 'simulate '//FOLDER//'broken.nml --out '//FOLDER//'broken', &
                         STATUS_FAILED, parts)
            call check(error, .not. file_exists(FOLDER//'broken/truth.csv') .and. &
                       .not. file_exists(FOLDER//'broken/setup.nml'), 'a result stands after '// &
                       text)
        end subroutine broken
    end subroutine test_broken_cases

    !> A case is judged against what is published by its settings, whatever its name.
    subroutine test_edited_cases(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, text

        call edit_case(error, 'front-1', 'edited.nml', 'amplitude = 30 ', 'amplitude = 10 ')
        call edit_case(error, 'front-1', 'renamed.nml', 'front-1', 'mine')
        call succeeds(error, 'verify --cases '//FOLDER//'edited.nml,'//FOLDER//'renamed.nml', output)
        call check_says(error, output, 'front-1, edited: not the case of the report'//achar(10))
        call check_says(error, output, 'mine: curves and the printed axis')
        call check(error, index(output, 'mine, edited') == 0, output)
        call succeeds(error, 'montecarlo --runs 2 --algorithms ascfest --cases '// &
                      FOLDER//'edited.nml,'//FOLDER//'renamed.nml --out '//FOLDER// &
                      'edited.csv --runs-out '//FOLDER//'edited_runs.csv', output)
        call check_says(error, output, 'theory is right (95 %): 3 of 3 ... front-1: edited or switched, not the case')
        call succeeds(error, 'merge '//FOLDER//'edited_runs.csv', output)
        call check_says(error, output, 'front-1: edited or switched, not the case ... (95 %): 3 of 3')
    end subroutine test_edited_cases

    !> A satellite of one's own, as in the user guide: every command takes it, sigma follows its rods, and what is wrong is
    !> said with its remedy.
    subroutine test_own_satellite(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: OWN = FOLDER//'own.nml'
        character(*), parameter :: BEGINNING = "&calibration name = 'own', duration = 60, epoch = '"
        character(*), parameter :: SATELLITE = "T00:00:00' /"//LF//"&mass_properties mass = 100, "// &
            "moments_of_inertia = 8, 9, 10 /"//LF//"&rods largest_moment = 3 /"//LF
        character(*), parameter :: RODS = "&rod axis = 2, amplitude = 3, frequency = 0.1, stop = 60 /"//LF// &
            "&rod axis = 3, amplitude = 3, frequency = 0.1, stop = 60 /"//LF
        character(*), parameter :: ORBIT = "&truth orbit = 'kepler', semi_major_axis_km = 6870, eccentricity = 0.001, "//LF// &
            "inclination_deg = 89, node_deg = 120, perigee_deg = 90, mean_anomaly_deg = 10, attitude = 'nadir' /"//LF
        character(*), parameter :: WEATHER = "&atmosphere space_weather = 'given', f107 = 150, f107_mean = 150, kp = 2 /"
        character(:), allocatable :: output, messages

        call make_file('own.nml', BEGINNING//'2026-11-25'//SATELLITE//RODS//ORBIT//WEATHER)
        call prints(error, 'timing '//OWN//' --step 600', 'best all')
        call succeeds(error, 'verify '//OWN, output)
        call succeeds(error, 'design '//OWN//' --out '//FOLDER//'own-best.nml', output)
        call check(error, index(output, '     3.000  ') > 0 .and. index(output, '30.000  ') == 0, output)
        call succeeds(error, 'simulate '//FOLDER//'own-best.nml --out '//FOLDER//'own-run', output)
        call refused(error, 'design '//OWN//' --amplitude 4', STATUS_FAILED, 'at most 3 A m^2 (largest_moment')
        call make_file('own.nml', BEGINNING//'2026-11-25'//SATELLITE//RODS//ORBIT)
        call refused(error, 'timing '//OWN, STATUS_FAILED, "space_weather = 'given' ... space_weather = 'file'")
        call make_file('own.nml', BEGINNING//'2031-11-25'//SATELLITE//RODS//ORBIT//WEATHER)
        call succeeds(error, 'timing '//OWN//' --step 600', output, messages)
        call check_says(error, messages, 'is extrapolated: igrf14 ends')
    end subroutine test_own_satellite

    !> A table that samples level (1 + corner/f) gives bound and sigmas of the formula within 1 %; the observation set holds the
    !> table. Broken tables are refused with file and line.
    subroutine test_noise_table(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HEADER = 'frequency_hz,ax_m_s2_sqrt_hz,ay_m_s2_sqrt_hz,az_m_s2_sqrt_hz'//LF
        character(10), parameter :: ALGORITHMS(3) = [character(10) :: 'assest-fde', 'optimal', 'sequential']
        character(:), allocatable :: rows, formula, table, set
        type(text_file_t) :: setup
        type(string_t) :: of_formula(size(ALGORITHMS))
        type(error_t), allocatable :: failure
        real(dp) :: f
        integer :: i, status

        call edit_case(error, 'front-1', 'table.nml', 'noise_table = ''''', 'noise_table = '''//FOLDER//'noise.csv''')
        rows = ''
        do i = 1, 50
            f = 1e-4_dp*5e4_dp**((i - 1)/49.0_dp)
            rows = rows//real_text(f)//','//density(1e-20_dp, 0.005_dp)//','//density(1e-18_dp, 0.1_dp)//','// &
                   density(1e-20_dp, 0.005_dp)//LF
        end do
        call make_file('noise.csv', HEADER//rows)
        call succeeds(error, 'bound front-1 --format csv', formula)
        call succeeds(error, 'bound '//FOLDER//'table.nml --format csv', table)
        call compare(2)
        call succeeds(error, 'simulate '//FOLDER//'table.nml --out '//FOLDER//'table', set)
        call succeeds(error, 'simulate front-1 --out '//FOLDER//'formula', set)
        if (allocated(error)) return
        call remove_file(FOLDER//'noise.csv')
        call read_text_file(FOLDER//'table/setup.nml', setup, failure)
        call check_says(error, setup%text, 'noise_frequency = 0.0001, ')
        do i = 1, size(ALGORITHMS)
            call run('estimate '//FOLDER//'formula --format csv --algorithm '//trim(ALGORITHMS(i)), status, of_formula(i)%text, set)
        end do
        call make_file('formula/setup.nml', setup%text)
        do i = 1, size(ALGORITHMS)
            call run('estimate '//FOLDER//'formula --format csv --algorithm '//trim(ALGORITHMS(i)), status, table, set)
            formula = of_formula(i)%text
            call compare(5)
        end do
        call broken('1e-4,1e-9'//LF//'1e-2,1e-9'//LF//'1e-3,1e-9'//LF, ':4: the frequency 0.001 Hz stands behind 0.01 Hz')
        call broken('1e-4,1e-9'//LF//'1e-2,-1e-9'//LF//'1e-1,1e-9'//LF, ':3: amplitude density of x = -1.000000E-09; it must')
        call broken('1e-4,1e-9'//LF//'1e-2,nan'//LF, ':3: column a_m_s2_sqrt_hz: "nan"')
        call broken('1e-4,1e-9'//LF//'10,1e-9'//LF, ':3: the table of the noise has 2 rows; it must have from 4 to')
        call broken('1e-4,1e-9'//LF//'0.1,1e-9'//LF//'0.2,1e-9'//LF//'1,1e-9'//LF, 'axis x: last frequency of the table of the '// &
                    'noise = 1 Hz')

    contains

        function density(level, corner) result(text)
            real(dp), intent(in) :: level, corner
            character(:), allocatable :: text

            text = real_text(sqrt(level*(1 + corner/f)))
        end function density

        !> Three columns from one on, each within 1 %.
        subroutine compare(column)
            integer, intent(in) :: column
            type(string_t), allocatable :: lines(:), fields(:), others(:)
            real(dp) :: one, other
            integer :: k

            lines = split(formula, LF)
            fields = split(lines(2)%text, ',')
            lines = split(table, LF)
            others = split(lines(2)%text, ',')
            do k = column, column + 2
                read (fields(k)%text, *) one
                read (others(k)%text, *) other
                call check(error, abs(other/one - 1) < 0.01_dp, formula//table)
            end do
        end subroutine compare

        subroutine broken(text, part)
            character(*), intent(in) :: text, part

            call make_file('noise.csv', 'frequency_hz,a_m_s2_sqrt_hz'//LF//text)
            call refused(error, 'bound '//FOLDER//'table.nml', STATUS_FAILED, part)
        end subroutine broken
    end subroutine test_noise_table

    !> The command behind `next:` succeeds as it stands: after a case, after one that is estimated in arcs, and after a design
    !> for an observation set from 2000 on. A design that would not keep the limits in truth has a warning instead.
    subroutine test_next(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: text, output, messages

        call succeeds(error, 'cases show front-1', text)
        text = replaced(text, '''1989-01-02T00:00:00''', '''2005-01-02T00:00:00''')
        text = replaced(text, 'rotation = ''given''', 'rotation = ''gmst-1982''')
        text = replaced(text, 'magnetic_field = ''igrf95''', 'magnetic_field = ''igrf14''')
        text = replaced(text, 'space_weather = ''table''', 'space_weather = ''given''')
        call make_file('later.nml', text)
        call succeeds(error, 'simulate '//FOLDER//'later.nml --out '//FOLDER//'next-run', output)
        call follow()
        call succeeds(error, 'design '//FOLDER//'next-run --out '//FOLDER//'next.nml', output)
        call succeeds(error, 'simulate '//FOLDER//'next.nml --out '//FOLDER//'next-again', output)
        text = replaced(text, 'duration = 60 ', 'duration = 180 ')
        text = replaced(text, 'amplitude = 30 ', 'amplitude = 25 ')
        text = replaced(text, 'amplitude = 30 ', 'amplitude = 25 ')
        call make_file('held.nml', text//LF//'&control /')
        call succeeds(error, 'simulate '//FOLDER//'held.nml --out '//FOLDER//'held-run', output)
        call check_says(error, output, '--algorithm optimal --arc 60')
        call follow()
        call succeeds(error, 'design front-1 --duration 600 --out '//FOLDER//'long.nml', output, messages)
        call check_says(error, messages, 'cannot be simulated as it stands')
        call check(error, index(output, 'next:'), 0, output)

    contains

        subroutine follow()
            character(:), allocatable :: hint
            integer :: place

            place = index(output, 'next: gracecg ')
            call check(error, place > 0, output)
            hint = output(place + len('next: gracecg '):)
            hint = hint(:index(hint, LF) - 1)
            call succeeds(error, hint, output, messages)
        end subroutine follow
    end subroutine test_next

    !> Without a moment there is no calibration; the observations themselves can be simulated, with a
    !> warning.
    subroutine test_rods_off(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: text, messages, output

        call edit_case(error, 'front-3', 'off.nml', 'amplitude = 30', 'amplitude = 0', every=.true.)
        call refused(error, 'montecarlo --runs 2 --cases '//FOLDER//'off.nml', STATUS_FAILED, 'all torque rods are off')
        call refused(error, 'trim '//FOLDER//'off.nml', STATUS_FAILED, 'all torque rods are off')
        call refused(error, 'design --manoeuvre '//FOLDER//'off.nml', STATUS_FAILED, 'all torque rods are off')
        call succeeds(error, 'simulate '//FOLDER//'off.nml --out '//FOLDER//'off', output, messages)
        call check_says(error, messages, 'all torque rods are off')
        call refused(error, 'estimate '//FOLDER//'off --algorithm optimal', STATUS_FAILED, 'all torque rods are off')
    end subroutine test_rods_off

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
            call refused(error, trim(SINGLE(i))//' front', STATUS_MISUSED, '3 cases are named')
            call refused(error, trim(SINGLE(i))//' front-1 --cases front-2', STATUS_MISUSED, '2 cases are named')
        end do
        do i = 1, size(SEVERAL)
            call refused(error, trim(SEVERAL(i))//' front front-2', STATUS_FAILED, 'two cases have the name "front-2"')
            call refused(error, trim(SEVERAL(i))//' --cases all,back', STATUS_FAILED, 'two cases have the name "back-1"')
        end do
        call refused(error, 'bound middle', STATUS_FAILED, 'no case "middle"')

    contains

        !> The rows' cases, each once more or often, in this order.
        subroutine in_order(names, rows)
            character(*), intent(in) :: names(:)
            integer, intent(in) :: rows
            type(text_file_t) :: text
            type(string_t), allocatable :: fields(:)
            integer :: row, k, n

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
            end do
            call check(error, k == size(names) .and. n == rows, output)
        end subroutine in_order
    end subroutine test_case_groups

    !> Samples that are cut off at the full scale are warned of.
    subroutine test_instruments(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: text, output, messages

        call succeeds(error, 'simulate front-1 --out '//FOLDER//'keeps', output)
        call succeeds(error, 'cases show front-1', text)
        ! of the accelerometer, which comes first
        text = replaced(text, 'limited = .false.', 'limited = .true.')
        text = replaced(text, 'range = 0.00005', 'range = 0.00002')
        call make_file('beyond.nml', text)
        call succeeds(error, 'simulate '//FOLDER//'beyond.nml --out '//FOLDER//'beyond', output, messages)
        call check_says(error, messages, 'accelerometer: 600 of 600 samples are cut off at its full scale')
    end subroutine test_instruments

    !> Times of the orbit in UTC: 1400 s after midnight are 00:23:20; over the leap second at the end of 1990 a
    !> revolution takes a second longer on the clock.
    subroutine test_utc(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: text, output

        call prints(error, 'timing --step 600', 'case 2    1400  00:23:20 ... case 3    2658  00:44:18')
        call prints(error, 'timing --step 600 --format csv', LF//'1200,1989-01-02T00:20:00,')
        call prints(error, 'timing --step 600 --format json', '"all_utc": "1989-01-02T0 ... "utc": "1989-01-02T00:23:20"')
        call prints(error, 'design --manoeuvre front-1 --at 1400 --format csv', 'front-1,1400,1989-01-02T00:23:20,89.5')
        call succeeds(error, 'cases show front-1', text)
        text = replaced(text, '1989-01-02T00:00:00', '1990-12-31T23:50:00')
        call make_file('leap.nml', replaced(text, 'density = ''dtm77''', 'density = ''none'''))
        call succeeds(error, 'timing '//FOLDER//'leap.nml --step 600 --format csv', output)
        call check_says(error, output, LF//'600,1990-12-31T23:59:60, ... '//LF//'1200,1991-01-01T00:09:59,')
    end subroutine test_utc
end module test_case_commands
