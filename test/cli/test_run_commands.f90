!> `simulate` and `estimate` on the command line: what they write, and what an estimate says of itself.
module test_run_commands
    use vocabulary
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: split, parse_real
    use gracecg_files_file, only: text_file_t, read_text_file, text_file_of, file_exists, make_directory, remove_file
    use gracecg_files_table, only: read_csv, table_file_t
    use gracecg_cli_console, only: STATUS_NOT_TO_BE_USED
    use command_fixture
    implicit none
    private
    public :: collect_run_commands

contains

    subroutine collect_run_commands(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('simulate', test_simulate), &
                    new_unittest('simulate-nothing-by-halves', test_blocked_options), &
                    new_unittest('estimate', test_estimate), &
                    new_unittest('running-estimate', test_running), &
                    new_unittest('calibrations-that-contradict-each-other', test_contradiction), &
                    new_unittest('no-convergence', test_no_convergence), &
                    new_unittest('options-in-a-setup', test_options_in_setup)]
    end subroutine collect_run_commands

    !> Columns and rows as documented; other runs have other noise and the same truth.
    subroutine test_simulate(error)
        type(error_type), allocatable, intent(out) :: error
        character(10), parameter :: COLUMNS(23) = [character(10) :: 'time_s', 'rx_m', 'ry_m', 'rz_m', 'vx_m_s', &
            'vy_m_s', 'vz_m_s', 'q1', 'q2', 'q3', 'q4', 'wx_rad_s', 'wy_rad_s', 'wz_rad_s', 'wdx_rad_s2', &
            'wdy_rad_s2', 'wdz_rad_s2', 'bx_tesla', 'by_tesla', 'bz_tesla', 'ngx_m_s2', 'ngy_m_s2', 'ngz_m_s2']
        type(error_t), allocatable :: failure
        type(text_file_t) :: file
        type(table_file_t) :: rows
        real(dp), allocatable :: truth_1(:, :), truth_2(:, :), noisy_1(:, :), noisy_2(:, :)
        character(7), parameter :: ACCELEROMETER(4) = [character(7) :: 'time_s', 'ax_m_s2', 'ay_m_s2', 'az_m_s2']
        character(:), allocatable :: output

        call succeeds(error, 'simulate front-3 --out '//FOLDER//'run1 --seed 5', output)
        call succeeds(error, 'simulate front-3 --out '//FOLDER//'run2 --seed 5 --run 2', output)
        call check_says(error, output, 'next: gracecg estimate '//FOLDER//'run2 --algorithm ')
        call refused(error, 'estimate '//FOLDER//'run1 '//FOLDER//'run1 --algorithm optimal', STATUS_FAILED, &
                     'runs 1 and 2 are the same samples')
        call check_measured(error)
        call check_apart(error)
        if (allocated(error)) return
        call read_csv(FOLDER//'run1/truth.csv', COLUMNS, rows, failure)
        if (.not. allocated(failure)) call read_csv(FOLDER//'run1/truth.csv', COLUMNS, truth_1, failure)
        if (.not. allocated(failure)) call read_csv(FOLDER//'run2/truth.csv', COLUMNS, truth_2, failure)
        if (.not. allocated(failure)) &
            call read_csv(FOLDER//'run1/accelerometer.csv', ACCELEROMETER, noisy_1, failure)
        if (.not. allocated(failure)) &
            call read_csv(FOLDER//'run2/accelerometer.csv', ACCELEROMETER, noisy_2, failure)
        if (.not. allocated(failure)) call read_text_file(FOLDER//'run1/accelerometer.csv', file, failure)
        call check_passes(error, failure)
        call check(error, rows%comments(1)%text == 'gracecg '//VERSION//' simulate' .and. &
                   rows%comments(2)%text == 'case front-3, seed 5, run 1')
        call check(error, size(truth_1, 1) == 601 .and. size(noisy_1, 1) == 600)
        call check(error, index(file%line(4), '0.3,') == 1, file%line(4))
        call check(error, all(abs(truth_1(:, :20) - truth_2(:, :20)) <= 0), 'the truth depends on the run')
        call check(error, any(abs(truth_1(:, 21) - truth_2(:, 21)) > 0), 'the density wave does not')
        call check(error, all(abs(noisy_1(:, 2) - noisy_2(:, 2)) > 0), 'the noise does not')
    end subroutine test_simulate

    !> No masses are moved by a history whose calibrations differ by more than the walk explains; nor where an axis is not known.
    subroutine test_contradiction(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HEAD = 'time_utc,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm'//new_line('a')
        character(:), allocatable :: output, messages
        integer :: status, i

        call make_file('apart.csv', HEAD//'2020-01-01T00:00:00,0.3,0.4,0.0,0.01,0.01,0.01'//new_line('a')// &
                       '2020-02-01T00:00:00,-0.3,-0.4,0.0,0.01,0.01,0.01'//new_line('a'))
        call run('history '//FOLDER//'apart.csv', status, output, messages)
        call check(error, status, STATUS_NOT_TO_BE_USED)
        call check_says(error, output, 'no masses are to be moved')
        call make_file('near.csv', HEAD//'2020-01-01T00:00:00,0.3,0.4,0.0,0.01,0.2,0.01'//new_line('a'))
        call prints(error, 'history '//FOLDER//'near.csv', 'move masses along x (gracecg trim) ... y: not known')
        do i = 1, 2
            call make_file('of_'//'CD'(i:i)//'.json', '{"command": "level1 estimate", "satellite": "'//'CD'(i:i)//'", '// &
                           '"epoch_gps_s": 63378720'//'18'(i:i)//', "offset_mm": [0.1, 0.1, 0.1], "flag": 0, '// &
                           '"covariance_mm2": [1e-4, 0, 0, 0, 1e-4, 0, 0, 0, 1e-4]}')
        end do
        call refused(error, 'history '//FOLDER//'of_C.json '//FOLDER//'of_D.json', STATUS_FAILED, &
                     'of_D.json is of satellite D ... of C ... one satellite')
        call make_file('same.csv', HEAD//'2020-01-01T00:00:00,0.1,0.1,0.1,0.01,0.01,0.01'//new_line('a'))
        call succeeds(error, 'history '//FOLDER//'same.csv '//FOLDER//'of_C.json', output)
    end subroutine test_contradiction

    !> Runs that are months apart are joined with a warning. A contradiction is said by the action, and not again.
    subroutine check_apart(error)
        type(error_type), allocatable, intent(inout) :: error
        character(*), parameter :: SETUP = 'run2/setup.nml'
        type(text_file_t) :: good
        type(error_t), allocatable :: failure
        character(:), allocatable :: output, messages
        integer :: status

        call read_text_file(FOLDER//SETUP, good, failure)
        if (failed(error, failure)) return
        call make_file(SETUP, replaced(good%text, '1989-01-02T', '1989-05-02T'))
        call run('estimate '//FOLDER//'run1 '//FOLDER//'run2 --algorithm optimal', status, output, messages)
        call check_says(error, messages, 'the runs are up to 120 days apart ... gracecg history')
        call make_file(SETUP, replaced(good%text, 'noise_level = 1e-20, 1e-18, 1e-20', 'noise_level = 3e-21, 3e-19, 3e-21'))
        call run('estimate '//FOLDER//'run2 --algorithm optimal', status, output, messages)
        call check(error, status, STATUS_NOT_TO_BE_USED, messages)
        call check_says(error, output, 'do not use: the data contradict what the setup')
        call check(error, index(messages, 'contradict'), 0, messages)
        call make_file(SETUP, good%text)
    end subroutine check_apart

    !> Samples that are no simulation's stay where one would take their place.
    subroutine check_measured(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: setup, still
        type(error_t), allocatable :: failure

        call read_text_file(FOLDER//'run1/setup.nml', setup, failure)
        call make_directory(FOLDER//'measured', failure)
        call make_file('measured/setup.nml', setup%text)
        call refused(error, 'simulate front-3 --out '//FOLDER//'measured', STATUS_FAILED, 'no simulation ... would be lost')
        call read_text_file(FOLDER//'measured/setup.nml', still, failure)
        call check(error, still%text == setup%text, 'it stays')
        call make_file('measured/truth.csv', 'of a Level-1 day')
        call refused(error, 'simulate front-3 --out '//FOLDER//'measured', STATUS_FAILED, 'without ... would be lost')
    end subroutine check_measured

    !> Where one of the files cannot be written none is.
    subroutine test_blocked_options(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: BLOCKED = FOLDER//'blocked'
        type(error_t), allocatable :: failure

        call make_directory(BLOCKED//'/options.nml', failure)
        call check_passes(error, failure)
        call refused(error, 'simulate front-3 --out '//BLOCKED, STATUS_FAILED, 'options.nml ... is a folder')
        call check(error, .not. any([file_exists(BLOCKED//'/truth.csv'), file_exists(BLOCKED//'/setup.nml'), &
                                     file_exists(BLOCKED//'/accelerometer.csv')]))
    end subroutine test_blocked_options

    !> The estimate from files: within five of its sigmas in the well observed axes of case 3, the
    !> same in both formats.
    subroutine test_estimate(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: TRUE_OFFSET(3) = [0.3_dp, 0.4_dp, -0.5_dp]   ! mm, section 6.2
        type(text_file_t) :: text
        type(string_t), allocatable :: fields(:)
        character(:), allocatable :: output, messages, line
        real(dp) :: value, sigma
        integer :: axis, status, first
        logical :: ok

        call succeeds(error, 'simulate front-3 --out '//FOLDER//'run3', output)
        call succeeds(error, 'estimate '//FOLDER//'run3 --algorithm assest-fde --format csv', output)
        if (allocated(error)) return
        text = text_file_of(output, 'output')
        if (unmet(error, index(text%line(1), &
                  'algorithm,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm,iterations,'// &
                  'converged,condition,residual_rms_x_m_s2,residual_rms_y_m_s2,residual_rms_z_m_s2,alpha_x_m_s3,') == 1, &
                  text%line(1))) return
        fields = split(text%line(2), ',')
        call check(error, size(fields) == 48 .and. size(split(text%line(1), ',')) == 48 .and. &
                   fields(1)%text == 'assest-fde' .and. fields(9)%text == 'true' .and. fields(40)%text == '' .and. &
                   fields(47)%text == 'trim' .and. fields(48)%text == 'x y z', &
                   text%line(2))
        do axis = 1, 3
            call parse_real(fields(1 + axis)%text, value, ok)
            call parse_real(fields(4 + axis)%text, sigma, ok)
            call check(error, ok .and. abs(value - TRUE_OFFSET(axis)) < 5*sigma .and. &
                       sigma < 0.1_dp, text%line(2))
        end do
        call succeeds(error, 'estimate '//FOLDER//'run3 --algorithm assest-fde', output)
        if (allocated(error)) return
        text = text_file_of(output, 'output')
        first = findloc([(index(text%line(axis), ', assest-fde: CG offset') > 0, axis=1, 10)], .true., 1)
        call check(error, first > 1 .and. index(text%line(1), 'trim: ') == 1, text%line(1))
        do axis = 1, 3
            line = text%line(first + axis)
            read (line(4:16), *) sigma
            call parse_real(fields(1 + axis)%text, value, ok)
            call check(error, abs(sigma - value) < 1e-5_dp, line)
        end do
        call refused(error, 'estimate '//FOLDER//'none --algorithm assest-fde', STATUS_FAILED, 'none: no such folder')
        call estimate_without_stars()
        if (allocated(error)) return
        call remove_file(FOLDER//'run3/magnetometer.csv')
        call succeeds(error, 'estimate '//FOLDER//'run3 --algorithm assest-fde', output, messages)
        call check_says(error, messages, 'warning: magnetometer: no samples for 60 epochs')
        call remove_file(FOLDER//'run3/orbit.csv')
        call refused(error, 'estimate '//FOLDER//'run3 --algorithm assest-fde', STATUS_FAILED, &
                     'run3/magnetometer.csv: no such file')

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
                         'run4/star_camera.csv: no such file')
            call read_text_file(FOLDER//'run4/truth.csv', truth, failure)
            names = split(truth%line(1), ',')
            values = split(truth%line(2), ',')
            rates = ''
            do i = 1, size(names)
                if (index(names(i)%text, '_rad_s') > 0 .and. index(names(i)%text, 'wd') == 0) rates = rates//' '//values(i)%text
            end do
            call read_text_file(FOLDER//'run4/setup.nml', setup, failure)
            call make_file('run4/setup.nml', setup%text//'&angular_velocity value ='//rates// &
                           ' sigma = 3*1e-8 /'//new_line('a'))
            call run('estimate '//FOLDER//'run4 --algorithm assest-fde --format csv', status, output, messages)
            if (unmet(error, status == STATUS_NOT_TO_BE_USED .and. index(messages, 'from other means') > 0, messages)) return
            text = text_file_of(output, 'output')
            fields = split(text%line(2), ',')
            do axis = 1, 3
                call parse_real(fields(1 + axis)%text, value, ok)
                call parse_real(fields(4 + axis)%text, sigma, ok)
                call check(error, ok .and. abs(value - TRUE_OFFSET(axis)) < 5*sigma .and. sigma < 0.1_dp, text%line(2))
            end do
            names = split(text%line(1), ',')
            place = findloc([(names(i)%text == 'q1', i=1, size(names))], .true., 1)
            length = 0
            do i = place, place + 7
                length = length + len_trim(fields(i)%text)
            end do
            call check(error, length, 0, text%line(2))
            call refused(error, 'estimate '//FOLDER//'run4 --algorithm optimal', STATUS_FAILED, 'assest-rde alone do without')
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
        integer :: i
        logical :: ok

        call succeeds(error, 'simulate back-3 --out '//FOLDER//'run6', output)
        call succeeds(error, 'estimate '//FOLDER//'run6 --algorithm sequential --format csv --running '//FILE, output, messages)
        call read_csv(FILE, COLUMNS, table, failure)
        call check_passes(error, failure)
        if (unmet(error, size(table, 1), 601)) return
        text = text_file_of(output, 'output')
        fields = split(text%line(2), ',')
        do i = 2, 7
            call parse_real(fields(i)%text, value, ok)
            call check(error, ok .and. abs(table(601, i) - value) < 1e-5_dp, text%line(2))
        end do
        call remove_file(FILE)
        call refused(error, 'estimate '//FOLDER//'run6 --algorithm optimal --running '//FILE, STATUS_MISUSED, &
                     '--running: optimal estimates from all samples at once')
        call refused(error, 'estimate '//FOLDER//'none --algorithm sequential --running '//FILE, STATUS_FAILED, &
                     'none: no such folder')
        call check(error, .not. file_exists(FILE), 'no file is left by a failure')
        call refused(error, 'estimate '//FOLDER//'run6 --algorithm sequential --running '//FOLDER//'no/x.csv', STATUS_FAILED, &
                     'there is no folder')
    end subroutine test_running

    !> A hopeless initial guess: the result is shown, marked as not converged, and the status is 1.
    subroutine test_no_convergence(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: KEY = 'guess_angular_velocity = '
        character(:), allocatable :: knowledge, output, messages
        integer :: status

        call succeeds(error, 'simulate front-1 --out '//FOLDER//'lost', output)
        if (allocated(error)) return
        call read_content(error, FOLDER//'lost/options.nml', knowledge)
        if (allocated(error)) return
        call make_file('lost/options.nml', replaced(knowledge, KEY, KEY//'0.5, 0.4, 0.7 ! '))
        call run('estimate '//FOLDER//'lost --algorithm assest-fde --format csv --options '//FOLDER// &
                 'lost/options.nml', status, output, messages)
        call check(error, status, STATUS_FAILED, messages)
        call check(error, index(output, ',false,') > 0 .and. index(messages, 'did not converge') > 0, &
                   output//messages)
    end subroutine test_no_convergence

    !> Options in a setup.nml count; --options takes their place.
    subroutine test_options_in_setup(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: setup, options, output, messages, told, untold
        integer :: status

        call succeeds(error, 'simulate front-1 --out '//FOLDER//'old', output)
        call succeeds(error, 'estimate '//FOLDER//'old --algorithm ascfest --format csv --options default', untold)
        call succeeds(error, 'estimate '//FOLDER//'old --algorithm ascfest --format csv', told, messages)
        call check_says(error, messages, 'options of '//FOLDER//'old/options.nml')
        if (allocated(error)) return
        call read_content(error, FOLDER//'old/setup.nml', setup)
        call read_content(error, FOLDER//'old/options.nml', options)
        call make_file('old/setup.nml', setup//options)
        call succeeds(error, 'estimate '//FOLDER//'old --algorithm ascfest --format csv --options default', output, messages)
        call check(error, output == told .and. output /= untold, 'the groups of the setup count')
        call make_file('old/empty.nml', '&estimation /')
        call run('estimate '//FOLDER//'old --algorithm ascfest --format csv --options '//FOLDER//'old/empty.nml', &
                 status, output, messages)
        call check(error, output == untold, '--options takes their place')
        call refused(error, 'estimate '//FOLDER//'old --algorithm ascfest --options '//FOLDER//'old/none.nml', STATUS_FAILED, &
                     'old/none.nml')
    end subroutine test_options_in_setup
end module test_run_commands
