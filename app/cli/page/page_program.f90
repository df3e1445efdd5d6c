!> Pages are made by the Python package gracecg, of the JSON that a command writes: this module leaves the JSON beside
!> the page and starts Python.
module gracecg_cli_page_program
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: integer_text
    use gracecg_files_file, only: make_directory, output_file_t, text_file_t, read_text_file, remove_file, file_exists
    use gracecg_files_run_record, only: note_output
    use gracecg_cli_console, only: quoted_word
    implicit none
    private
    public :: make_page, page_folder, RESULT_FILE, PYTHON_VARIABLE

    character(*), parameter :: RESULT_FILE = 'result.json'          !! What a page is made of, in its folder
    character(*), parameter :: PYTHON_VARIABLE = 'GRACECG_PYTHON'   !! Of the environment: which Python
    character(*), parameter :: PAGE_END = '.html', LOG_FILE = 'python.log'
    character(*), parameter :: VENV(2) = [character(26) :: '../../.venv/bin/python', '../../../.venv/bin/python']
    !! Of tools/setup.sh, as seen from the program in build/bin and in fpm's folder
    character(1), parameter :: LF = achar(10)

contains

    !> The folder for what stands behind a page: NAME_files for NAME.html.
    pure function page_folder(path) result(folder)
        character(*), intent(in) :: path        !! Of the page
        character(:), allocatable :: folder

        integer :: last

        last = len_trim(path)
        if (last > len(PAGE_END)) then
            if (path(last - len(PAGE_END) + 1:last) == PAGE_END) last = last - len(PAGE_END)
        end if
        folder = path(:last)//'_files'
    end function page_folder

    !> Makes the page of a command's JSON, which stays as NAME_files/result.json. An older page is gone in any case; the
    !> new one is whole, or it is not there.
    !>
    !> Fails when a file cannot be written, Python or its packages are missing, or they fail; the message says what to do.
    subroutine make_page(path, json, error, folder, said)
        character(*), intent(in) :: path        !! Of the page
        character(*), intent(in) :: json        !! What the command writes with --format json
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: folder    !! For the JSON, in the place of NAME_files; exists
        character(:), allocatable, intent(out), optional :: said    !! What Python printed

        type(output_file_t) :: file
        type(text_file_t) :: printed
        type(error_t), allocatable :: unread
        character(:), allocatable :: beside, numbers, log, messages
        integer :: status, command_status

        call note_output(path, error)
        if (allocated(error)) return
        beside = page_folder(path)
        if (present(folder)) beside = folder
        call make_directory(beside, error)
        if (allocated(error)) return
        call remove_file(path)
        numbers = beside//'/'//RESULT_FILE
        log = beside//'/'//LOG_FILE
        call file%open(numbers, error)
        if (.not. allocated(error)) call file%line(json)
        if (.not. allocated(error)) call file%commit(error)
        if (allocated(error)) return
        call remove_file(log)       ! for a link of that name would lead the shell to another file
        status = 0
        call execute_command_line(quoted_word(python())//' -m gracecg.pages '//quoted_word(from_here(numbers))//' '// &
                                  quoted_word(from_here(path))//' </dev/null >'//quoted_word(from_here(log))//' 2>&1', &
                                  exitstat=status, cmdstat=command_status)
        call read_text_file(log, printed, unread)
        messages = ''
        if (.not. allocated(unread)) messages = printed%text
        call remove_file(log)
        if (present(said)) said = messages(:verify(messages, LF, back=.true.))
        if (status == 0 .and. command_status == 0 .and. file_exists(path)) return
        if (status == 127 .or. index(messages, 'No module named') > 0) then
            call fail(error, path//': not made, for it takes Python with the packages of gracecg[pages]: get them by '// &
                      'tools/setup.sh pages (in the sources) or pip install "gracecg[pages]", then: python3 -m '// &
                      'gracecg.pages '//numbers//' '//path//' ('//python()//' was used; '//PYTHON_VARIABLE//' names another)')
        else
            call fail(error, path//': not made; '//python()//' -m gracecg.pages ended with status '//integer_text(status)// &
                      ': '//last_line(messages))
        end if
    end subroutine make_page

    !> The Python to be used: that of the environment variable, that which tools/setup.sh made beside the sources that the
    !> program was built of, or python3.
    function python() result(command)
        character(:), allocatable :: command

        character(:), allocatable :: program
        integer :: length, status, i

        call get_environment_variable(PYTHON_VARIABLE, length=length, status=status)
        allocate (character(length) :: command)
        if (status == 0 .and. length > 0) then
            call get_environment_variable(PYTHON_VARIABLE, command)
            return
        end if
        call get_command_argument(0, length=length)
        allocate (character(length) :: program)
        call get_command_argument(0, program)
        do i = 1, merge(size(VENV), 0, index(program, '/') > 0)
            command = program(:index(program, '/', back=.true.))//trim(VENV(i))
            if (file_exists(command)) return
        end do
        command = 'python3'
    end function python

    !> A path that no program takes for an option.
    pure function from_here(path) result(safe)
        character(*), intent(in) :: path
        character(:), allocatable :: safe

        safe = path
        if (index(path, '-') == 1) safe = './'//path
    end function from_here

    pure function last_line(text) result(line)
        character(*), intent(in) :: text
        character(:), allocatable :: line

        integer :: last

        last = verify(text, LF//' ', back=.true.)
        line = text(index(text(:last), LF, back=.true.) + 1:last)
        if (line == '') line = '(no message)'
    end function last_line
end module gracecg_cli_page_program
