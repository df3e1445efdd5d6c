!> What the page of one calibration is made of: complete, honest about what is missing, and handed to Python. Instead of
!> Python test/fixtures/page_maker.sh makes the page here: it is a copy of the JSON. The pages: python/tests/test_pages.py.
module test_calibration_page
    use vocabulary
    use calibrations
    use gracecg_files_file, only: text_file_t, read_text_file, file_exists, remove_file
    use gracecg_files_json, only: read_json_numbers
    use gracecg_cli_page_program, only: page_folder, RESULT_FILE, PYTHON_VARIABLE
    use command_fixture
    implicit none
    private
    public :: collect_calibration_page

    character(*), parameter :: RUN_1 = FOLDER//'page-run'
    character(9), parameter :: MEMBERS(7) = [character(9) :: 'inputs', 'samples', 'manoeuvre', 'verdict', 'fit', 'tables', &
                                             'results']

contains

    subroutine collect_calibration_page(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('folder-beside-the-page', test_folder), &
                    new_unittest('json-of-every-algorithm', test_page), &
                    new_unittest('numbers-behind-the-figures', test_numbers), &
                    new_unittest('estimate-says-the-same', test_same_output), &
                    new_unittest('without-python', test_no_python), &
                    new_unittest('warnings-stand-on-the-page', test_warnings), &
                    new_unittest('no-convergence', test_no_convergence), &
                    new_unittest('unwritable', test_unwritable), &
                    new_unittest('in-the-place-of-an-input', test_input_named), &
                    new_unittest('corrupted-observations', test_corrupted), &
                    new_unittest('refused-fit', test_refused)]
    end subroutine collect_calibration_page

    !> An observation set of front-3 in a folder.
    subroutine observe(error, name)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name
        character(:), allocatable :: messages

        call succeeds(error, 'simulate front-3 --out '//name, messages=messages)
    end subroutine observe

    subroutine has_not(error, html, part)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: html, part

        call check(error, index(html, part), 0, '"'//part//'" is on the page')
    end subroutine has_not

    integer function count_of(text, part) result(n)
        character(*), intent(in) :: text, part
        integer :: from, step

        n = 0
        from = 1
        do
            step = index(text(from:), part)
            if (step == 0) return
            n = n + 1
            from = from + step + len(part) - 1
        end do
    end function count_of

    subroutine test_folder(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, page_folder('a/b.html'), 'a/b_files')
        call check(error, page_folder('b.htm'), 'b.htm_files')
        call check(error, page_folder('.html'), '.html_files')
    end subroutine test_folder

    !> Everything that the page shows, no number that is none, and what --format json prints is the same.
    subroutine test_page(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: json, output, messages, name
        integer :: i, k

        call observe(error, RUN_1)
        do i = 1, size(ESTIMATOR_NAMES)
            name = trim(ESTIMATOR_NAMES(i))
            call succeeds(error, 'estimate '//RUN_1//' --algorithm '//name//' --format json --report '//FOLDER// &
                          'page.html', output, messages)
            call read_content(error, FOLDER//'page.html', json)
            do k = 1, size(MEMBERS)
                call check_says(error, json, '"'//trim(MEMBERS(k))//'": ')
            end do
            call check_says(error, json, '"algorithm": "'//name//'" ... "observations": "'//RUN_1//'"')
            call check_says(error, json, 'moments_of_inertia = 70.23, 345.14, 388.84')
            call has_not(error, json, 'NaN')
            call has_not(error, json, '***')
            call check(error, output == json)
        end do
    end subroutine test_page

    !> The series hold what the estimate says: the RMS of the residuals is that of the estimate, and the
    !> integral of the spectrum (Hann's taper, white residuals of y) is near its square.
    subroutine test_numbers(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), allocatable :: residuals(:), frequency(:), spectrum(:), sigma(:), axes(:), moment(:), none(:)
        character(:), allocatable :: output, messages, json
        real(dp) :: power

        call observe(error, RUN_1)
        call succeeds(error, 'estimate '//RUN_1//' --algorithm assest-rde --report '//FOLDER//'page.html', output, messages)
        call read_content(error, page_folder(FOLDER//'page.html')//'/'//RESULT_FILE, json)
        call take('tables.residuals.y_m_s2', residuals)
        call take('tables.spectrum.frequency_hz', frequency)
        call take('tables.spectrum.y_m_s2_sqrt_hz', spectrum)
        call take('tables.manoeuvre.mx_a_m2', none)
        call take('tables.manoeuvre.my_a_m2', moment)
        call take('covariance.matrix', sigma)
        call take('fit.ellipsoid.semi_axes_m', axes)
        if (allocated(error)) return
        call check(error, size(residuals) == 600 .and. size(moment) == 600 .and. size(spectrum) == 300)
        call check_says(error, output, '3.351E-09')
        call check(error, norm2(residuals)/sqrt(600.0_dp), 3.351e-9_dp, thr=1e-12_dp)
        power = sum(spectrum**2)*frequency(1)
        call check(error, power/(norm2(residuals)**2/600), 1.0_dp, thr=0.1_dp)
        call check(error, norm2(axes), sqrt(sigma(1) + sigma(17) + sigma(33)), thr=1e-12_dp)    ! the trace, of 15 x 15
        call check(error, maxval(moment) > 29.9_dp .and. all(abs(none) <= 0))

    contains

        subroutine take(path, values)
            character(*), intent(in) :: path
            real(dp), allocatable, intent(out) :: values(:)
            logical :: ok

            call read_json_numbers(json, path, values, ok)
            call check(error, ok, path)
        end subroutine take
    end subroutine test_numbers

    !> With and without the page: the same lines, but for the one that names the page.
    subroutine test_same_output(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: alone, with_page, messages

        call observe(error, RUN_1)
        call succeeds(error, 'estimate '//RUN_1//' --algorithm ascrest', alone, messages)
        call succeeds(error, 'estimate '//RUN_1//' --algorithm ascrest --report '//FOLDER//'page.html', with_page, messages)
        call check(error, index(with_page, alone//'written: '//FOLDER//'page.html'), 1, with_page)
        call succeeds(error, 'estimate '//RUN_1//' --algorithm ascrest --format csv', alone, messages)
        call succeeds(error, 'estimate '//RUN_1//' --algorithm ascrest --format csv --report '//FOLDER//'page.html', &
                      with_page, messages)
        call check(error, with_page, alone)
    end subroutine test_same_output

    !> No Python, or one that fails: status 1, in one line what to do; the JSON is there, an older page is not.
    subroutine test_no_python(error)
        type(error_type), allocatable, intent(out) :: error
        character(12), parameter :: PYTHONS(2) = [character(12) :: '/nowhere/py', 'false']
        character(60), parameter :: SAID(2) = [character(60) :: 'tools/setup.sh pages', 'ended with status 1: (no message)']
        character(:), allocatable :: output, messages
        character(4096) :: usual
        integer :: status, i

        call observe(error, RUN_1)
        call get_environment_variable(PYTHON_VARIABLE, usual)
        do i = 1, size(PYTHONS)
            if (.not. allocated(error)) call make_file('bare.html', 'an older page')
            call set_variable(PYTHON_VARIABLE, trim(PYTHONS(i)))
            call run('estimate '//RUN_1//' --algorithm ascfest --options default --report '//FOLDER//'bare.html', &
                     status, output, messages)
            call set_variable(PYTHON_VARIABLE, trim(usual))
            call check(error, status == STATUS_FAILED .and. index(output, 'CG offset') > 0 .and. &
                       index(messages, trim(SAID(i))) > 0 .and. count_of(messages, new_line('a')) == 1, messages)
            call check(error, file_exists(FOLDER//'bare_files/result.json') .and. .not. file_exists(FOLDER//'bare.html'))
        end do
    end subroutine test_no_python

    !> A lost magnetometer: the warning is on standard error and on the page.
    subroutine test_warnings(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: html, output, messages

        call observe(error, FOLDER//'page-lost')
        call remove_file(FOLDER//'page-lost/magnetometer.csv')
        call succeeds(error, 'estimate '//FOLDER//'page-lost --algorithm assest-fde --report '//FOLDER//'lost.html', &
                      output, messages)
        call check_says(error, messages, 'warning: magnetometer: no samples for 60 epochs')
        call read_content(error, FOLDER//'lost.html', html)
        call check_says(error, html, 'magnetometer: no samples for 60 epochs ... "remarks": [')
    end subroutine test_warnings

    !> The status is 1, and the page says that the offset is not to be used.
    subroutine test_no_convergence(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: KEY = 'guess_angular_velocity = '
        character(:), allocatable :: knowledge, html, output, messages
        integer :: status

        call observe(error, FOLDER//'page-astray')
        call read_content(error, FOLDER//'page-astray/options.nml', knowledge)
        if (allocated(error)) return
        call make_file('page-astray/options.nml', replaced(knowledge, KEY, KEY//'0.5, 0.4, 0.7 ! '))
        call run('estimate '//FOLDER//'page-astray --algorithm assest-fde --options '//FOLDER// &
                 'page-astray/options.nml --report '//FOLDER//'astray.html', &
                 status, output, messages)
        call check(error, status, STATUS_FAILED, messages)
        call check_says(error, messages, 'did not converge')
        call read_content(error, FOLDER//'astray.html', html)
        call check_says(error, html, '"refusal": "assest-fde did not converge in 20 iterations')
        call has_not(error, html, '"offset_m"')
        call check_says(error, html, '"tables":  ... "options_file": "'//FOLDER//'page-astray/options.nml" ... &estimation')
        call check_says(error, html, 'not converged in 20 iterations')
        call has_not(error, html, 'move the centre of mass')
    end subroutine test_no_convergence

    !> Refused before the work, with nothing printed; where only the folder of the figures cannot be
    !> made, there is no page either.
    subroutine test_unwritable(error)
        type(error_type), allocatable, intent(out) :: error
        character(:), allocatable :: output, messages
        integer :: status

        call observe(error, RUN_1)
        call refused(error, 'estimate '//RUN_1//' --algorithm assest-fde --report build/no-such-folder/x.html', STATUS_FAILED, &
                     'build/no-such-folder/x.html: cannot be written: there is no folder')
        call refused(error, 'estimate '//RUN_1//' --algorithm assest-fde --report '//FOLDER, STATUS_FAILED, 'is a folder')
        call make_file('blocked_files', 'in the way')
        call run('estimate '//RUN_1//' --algorithm assest-fde --report '//FOLDER//'blocked.html', status, output, messages)
        call check(error, status == STATUS_FAILED .and. index(messages, 'blocked_files: cannot make this folder') > 0, &
                   messages)
        call check(error, .not. file_exists(FOLDER//'blocked.html') .and. &
                   .not. file_exists(FOLDER//'blocked.html.part1'), 'a page is there')
    end subroutine test_unwritable

    !> An output that is named like an input, in another way or by a link: refused, and every input as it was.
    subroutine test_input_named(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: RUN_2 = FOLDER//'page-inputs'
        character(*), parameter :: OUTPUTS(5) = [character(80) :: 'optimal --report '//RUN_2//'/setup.nml', &
            'sequential --running '//RUN_2//'/star_camera.csv', 'sequential --running ./'//RUN_2//'//accelerometer.csv', &
            'sequential --running '//RUN_2//'/soft.csv', 'optimal --report '//RUN_2//'/hard.nml']
        character(*), parameter :: INPUTS(3) = [character(17) :: 'setup.nml', 'star_camera.csv', 'accelerometer.csv']
        type(text_file_t) :: before(3), after
        type(error_t), allocatable :: failure
        character(:), allocatable :: output, messages
        integer :: status, i, k

        call observe(error, RUN_2)
        call execute_command_line('cd '//RUN_2//' && ln -sf star_camera.csv soft.csv && ln -f setup.nml hard.nml')
        do k = 1, size(INPUTS)
            call read_text_file(RUN_2//'/'//trim(INPUTS(k)), before(k), failure)
        end do
        do i = 1, size(OUTPUTS)
            call run('estimate '//RUN_2//' --algorithm '//trim(OUTPUTS(i)), status, output, messages)
            call check(error, status == STATUS_FAILED .and. index(messages, 'would destroy it; name another file') > 0, messages)
            do k = 1, size(INPUTS)
                if (.not. allocated(failure)) call read_text_file(RUN_2//'/'//trim(INPUTS(k)), after, failure)
                call check_passes(error, failure)
                call check(error, after%text == before(k)%text, trim(OUTPUTS(i))//' has changed '//INPUTS(k))
            end do
        end do
    end subroutine test_input_named

    !> Observations that cannot be read: the message of their fault, and a page that says so in the place of an older one.
    subroutine test_corrupted(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: ESTIMATE = 'estimate '//FOLDER//'page-bad --algorithm assest-fde --report '//FOLDER//'bad.html'
        type(text_file_t) :: samples
        type(error_t), allocatable :: failure
        character(:), allocatable :: html, output, messages

        call observe(error, FOLDER//'page-bad')
        call succeeds(error, ESTIMATE, output, messages)
        call read_text_file(FOLDER//'page-bad/accelerometer.csv', samples, failure)
        if (failed(error, failure)) return
        call make_file('page-bad/accelerometer.csv', samples%text(:samples%first(20) - 1)//'1.8,nan,0,0'// &
                       samples%text(samples%last(20) + 1:))
        call refused(error, ESTIMATE, STATUS_FAILED, 'accelerometer.csv:20 ... bad.html, the page of a refused estimate')
        call read_content(error, FOLDER//'bad.html', html)
        call check_says(error, html, '"refusal": " ... accelerometer.csv:20')
        call has_not(error, html, '"samples"')
        call has_not(error, html, '"tables"')
    end subroutine test_corrupted

    !> A fit that the checks refuse, for each estimator: the reason on top, no offset, but the residuals.
    subroutine test_refused(error)
        type(error_type), allocatable, intent(out) :: error
        character(10), parameter :: ALGORITHMS(4) = [character(10) :: 'assest-fde', 'ascfest', 'optimal', 'sequential']
        character(*), parameter :: KEY = 'amplitude = '
        character(:), allocatable :: text, html, output, messages
        integer :: status, i

        call succeeds(error, 'simulate front-1 --out '//FOLDER//'page-refused', output, messages)
        if (allocated(error)) return
        call read_content(error, FOLDER//'page-refused/setup.nml', text)
        text = replaced(text, KEY//'30', KEY//'14', every=.true.)   ! the rods fired with more than twice what the setup says
        call make_file('page-refused/setup.nml', text)
        do i = 1, size(ALGORITHMS)
            call run('estimate '//FOLDER//'page-refused --algorithm '//trim(ALGORITHMS(i))//' --report '//FOLDER// &
                     'refused.html', status, output, messages)
            call check(error, status == STATUS_FAILED .and. index(output, 'do not use: ') == 1 .and. &
                       index(messages, 'did the rods fire') > 0, trim(ALGORITHMS(i))//': '//messages)
            call read_content(error, FOLDER//'refused.html', html)
            call check_says(error, html, 'did the rods fire as the setup says?')
            call check_says(error, html, '"algorithm": "'//trim(ALGORITHMS(i))//'" ... "residuals": {')
            call has_not(error, html, '"offset_m"')
        end do
        call run('estimate '//FOLDER//'page-refused --algorithm optimal --format json', status, output, messages)
        call check_says(error, output, '"kind": "do not use"')
        call has_not(error, output, '"offset_m"')
    end subroutine test_refused
end module test_calibration_page
