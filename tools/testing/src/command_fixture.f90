!> Commands run in this process, with what they say captured.
module command_fixture
    use vocabulary
    use gracecg_base_text, only: split_words
    use gracecg_cli_console, only: console_t
    use gracecg_cli_command_line, only: run_command_line, STATUS_DONE, STATUS_FAILED, STATUS_MISUSED
    use gracecg_level1_commands, only: level1_commands
    implicit none
    private
    public :: run, succeeds, prints, refused, edit_case, STATUS_DONE, STATUS_FAILED, STATUS_MISUSED

contains

    !> Runs a line of words; gives what went to standard output and standard error.
    subroutine run(line, status, output, messages)
        character(*), intent(in) :: line
        integer, intent(out) :: status
        character(:), allocatable, intent(out) :: output, messages
        type(console_t) :: console

        console%captured = .true.
        call run_command_line(split_words(line), console, status, level1_commands())
        output = ''
        messages = ''
        if (allocated(console%output)) output = console%output
        if (allocated(console%messages)) messages = console%messages
    end subroutine run

    !> The line must succeed and, unless the messages are asked for, say nothing on standard error. After a failed check nothing
    !> is run.
    subroutine succeeds(error, line, output, messages)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: line
        character(:), allocatable, intent(out), optional :: output, messages
        character(:), allocatable :: printed, said
        integer :: status

        printed = ''
        said = ''
        if (.not. allocated(error)) then
            call run(line, status, printed, said)
            call check(error, status, STATUS_DONE, line//': '//said)
            if (.not. present(messages)) &        ! of every run estimate says whose options it has taken
                call check(error, said(merge(index(said, new_line('a')), 0, index(said, 'options of ') == 1) + 1:), '', line)
        end if
        if (present(output)) output = printed
        if (present(messages)) messages = said
    end subroutine succeeds

    !> The line must succeed, say nothing on standard error and print every one of the parts.
    subroutine prints(error, line, parts)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: line, parts
        character(:), allocatable :: output

        call succeeds(error, line, output)
        call check_says(error, output, parts)
    end subroutine prints

    !> Makes a file of a built-in case in which a text is another one.
    subroutine edit_case(error, case, file, old, new, every)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: case, old, new
        character(*), intent(in) :: file            !! Below FOLDER
        logical, intent(in), optional :: every      !! As `replaced` has it
        character(:), allocatable :: text

        call succeeds(error, 'cases show '//case, text)
        call make_file(file, replaced(text, old, new, every))
    end subroutine edit_case

    !> The line must end with a status, write no result and say every one of the parts.
    subroutine refused(error, line, expected_status, parts)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: line, parts
        integer, intent(in) :: expected_status
        character(:), allocatable :: output, messages
        integer :: status

        if (allocated(error)) return
        call run(line, status, output, messages)
        call check(error, status, expected_status, line//': '//messages)
        call check(error, output == '' .or. index(output, 'do not use: ') == 1, line)
        call check_says(error, messages, trim(parts))
    end subroutine refused
end module command_fixture
