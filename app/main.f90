!> The program `gracecg`: the words of the command line to the command, its status to the system.
!>
!> The status goes out by C's `exit`: Fortran 2008's `stop` with a code would add a line of its own
!> to standard error.
program gracecg_main
    use, intrinsic :: iso_c_binding, only: c_int
    use gracecg_cli_console, only: console_t
    use gracecg_cli_process, only: keep_memory, process_words
    use gracecg_cli_command_line, only: run_command_line
    use gracecg_level1_commands, only: level1_commands
    implicit none

    interface
        subroutine c_exit(status) bind(c, name='exit')
            import :: c_int
            integer(c_int), value :: status
        end subroutine c_exit
    end interface

    include 'build_commit.inc'

    type(console_t) :: console
    integer :: status

    console%commit = COMMIT
    call keep_memory()
    call run_command_line(process_words(1), console, status, level1_commands())
    call c_exit(int(status, c_int))
end program gracecg_main
