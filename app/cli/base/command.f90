!> What every command is: a name, a declaration of its arguments, and its work.
module gracecg_cli_command
    use gracecg_base_error, only: error_t
    use gracecg_cli_arguments, only: arguments_t
    use gracecg_cli_console, only: console_t
    implicit none
    private
    public :: command_t, COMMAND_GROUPS, GROUP_SUMMARIES

    !> First words of commands of two words, and what stands behind them
    character(6), parameter :: COMMAND_GROUPS(2) = [character(6) :: 'model', 'level1']
    !> What the commands of each are, for the list of the commands
    character(40), parameter :: GROUP_SUMMARIES(2) = [character(40) :: 'single models of the environment', &
                                                      'Level-1 data of GRACE and GRACE-FO']

    !> A command of the program.
    type :: command_t
        character(20) :: name = ''          !! As typed, with one blank inside: 'model gravity'
        character(70) :: summary = ''       !! For the list of the commands
        procedure(declare_interface), pointer, nopass :: declare => null()  !! Its arguments and help
        procedure(run_interface), pointer, nopass :: run => null()  !! Its work
    end type command_t

    abstract interface
        !> Declares positional words, options, help and example.
        subroutine declare_interface(arguments)
            import :: arguments_t
            type(arguments_t), intent(inout) :: arguments
        end subroutine declare_interface

        !> Does the work, with the arguments parsed.
        subroutine run_interface(arguments, console, misuse, error)
            import :: arguments_t, console_t, error_t
            type(arguments_t), intent(in) :: arguments
            type(console_t), intent(inout) :: console
            type(error_t), allocatable, intent(out) :: misuse   !! The command is used wrongly
            type(error_t), allocatable, intent(out) :: error    !! The work failed
        end subroutine run_interface
    end interface
end module gracecg_cli_command
