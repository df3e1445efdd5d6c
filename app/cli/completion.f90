!> Completion of the command line in a shell. The scripts ask the program itself: `gracecg completion words -- WORD ...`
!> prints what may follow these words, made of what the commands declare.
!>
!> A value that an option names FILE or DIR is completed as a path, CASE as a built-in case or a file, one with
!> choices by these, a LIST after each comma anew; of numbers nothing is known.
module gracecg_cli_completion
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, join, split_words
    use gracecg_base_version, only: VERSION
    use gracecg_files_value, only: did_you_mean
    use gracecg_simulation_case_library, only: CASE_GROUPS
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_command, only: command_t, COMMAND_GROUPS, GROUP_SUMMARIES
    use gracecg_cli_console, only: console_t
    implicit none
    private
    public :: declare_completion, run_completion

    character(4), parameter :: SHELLS(2) = [character(4) :: 'bash', 'zsh']    !! That are completed
    character(*), parameter :: WORDS = 'words'      !! In place of a shell: what may follow
    integer, parameter :: MOST_WORDS = 1000
    character(*), parameter :: LF = new_line('a')

    !> Lines of `completion words` that ask the shell for more: paths, and completion after the last comma
    character(*), parameter :: FILES = '@files', FOLDERS = '@folders', LIST = '@list'

    character(*), parameter :: BASH = &
        '_gracecg()'//LF//'{'//LF// &
        '    local current=${COMP_WORDS[COMP_CWORD]} line before= words='//LF// &
        '    local last=$current'//LF// &
        '    COMPREPLY=()'//LF// &
        '    while IFS= read -r line; do'//LF// &
        '        [[ $line != -* && $current == -* || $line == -* && $current != -* ]] && continue'//LF// &
        '        case $line in'//LF// &
        '            @files) compopt -o filenames; mapfile -t COMPREPLY < <(compgen -f -- "$current") ;;'//LF// &
        '            @folders) compopt -o filenames; mapfile -t COMPREPLY < <(compgen -d -- "$current") ;;'//LF// &
        '            @list)'//LF// &
        '                last=${current##*,}'//LF// &
        '                before=${current%"$last"} ;;'//LF// &
        '            *) words+=" ${line%%:*}" ;;'//LF// &
        '        esac'//LF// &
        '    done < <("${COMP_WORDS[0]}" completion words -- "${COMP_WORDS[@]:1:COMP_CWORD-1}" 2> /dev/null)'//LF// &
        '    mapfile -t -O ${#COMPREPLY[@]} COMPREPLY < <(compgen -P "$before" -W "$words" -- "$last")'//LF// &
        '}'//LF//'complete -F _gracecg gracecg'

    character(*), parameter :: ZSH = &
        '_gracecg() {'//LF// &
        '    local line'//LF// &
        '    local -a offered'//LF// &
        '    for line in ${(f)"$($words[1] completion words -- ${words[2,CURRENT-1]} 2> /dev/null)"}; do'//LF// &
        '        case $line in'//LF// &
        '            @files) _files ;;'//LF// &
        '            @folders) _files -/ ;;'//LF// &
        '            @list) compset -P ''*,'' ;;'//LF// &
        '            -*) [[ $PREFIX == -* ]] && offered+=$line ;;'//LF// &
        '            *) offered+=$line ;;'//LF// &
        '        esac'//LF// &
        '    done'//LF// &
        '    (($#offered)) && _describe gracecg offered'//LF// &
        '}'//LF//'_gracecg "$@"'

contains

    !> Arguments and help of `gracecg completion`.
    subroutine declare_completion(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('completion', 'bash|zsh', 1, MOST_WORDS, &
                                'Prints a script that completes commands, options and their values. `make install` '// &
                                'puts it where bash and zsh look; otherwise: source <(gracecg completion bash)', &
                                'gracecg completion bash > gracecg.bash', SHELLS)
    end subroutine declare_completion

    !> The work of `gracecg completion`.
    subroutine run_completion(arguments, commands, console, misuse)
        type(arguments_t), intent(in) :: arguments
        type(command_t), intent(in) :: commands(:)  !! That are completed
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(inout) :: misuse

        character(:), allocatable :: shell

        shell = arguments%positional(1)
        call refuse_if(all(shell /= SHELLS) .and. shell /= WORDS, 'unknown shell "'//shell//'"'// &
                       did_you_mean(shell, SHELLS)//'; there are bash and zsh', misuse)
        call refuse_if(arguments%positional_count() > 1 .and. shell /= WORDS, &
                       'unexpected argument "'//arguments%positional(2)//'"', misuse)
        if (allocated(misuse)) return
        select case (shell)
        case ('bash')
            call console%line('# Completion of gracecg '//VERSION//' for bash: gracecg completion bash'//LF//BASH)
        case ('zsh')
            call console%line('#compdef gracecg'//LF//'# Completion of gracecg '//VERSION//' for zsh: gracecg completion zsh'// &
                              LF//ZSH)
        case default
            call offer_words(arguments, commands, console)
        end select
    end subroutine run_completion

    !> What may follow the words behind `words`, a line each: the word, a colon, and what it is.
    subroutine offer_words(arguments, commands, console)
        type(arguments_t), intent(in) :: arguments
        type(command_t), intent(in) :: commands(:)
        type(console_t), intent(inout) :: console

        type(arguments_t) :: command
        character(:), allocatable :: name
        integer :: next, i

        next = 2
        if (arguments%positional(next) == 'help') next = next + 1
        name = arguments%positional(next)
        next = next + 1
        if (name == '') then
            call offer_commands('', commands, console)
            return
        else if (any(COMMAND_GROUPS == name)) then
            if (arguments%positional(next) == '') then
                call offer_commands(name//' ', commands, console)
                return
            end if
            name = name//' '//arguments%positional(next)
            next = next + 1
        end if
        i = findloc(commands%name == name, .true., 1)
        if (i == 0 .or. arguments%positional(2) == 'help') return
        call commands(i)%declare(command)
        call offer_arguments(command, arguments%positional(max(next - 1, arguments%positional_count())), console)
    end subroutine offer_words

    !> The commands that begin with the first word of a group, or all first words.
    subroutine offer_commands(group, commands, console)
        character(*), intent(in) :: group       !! With a blank behind; empty: none
        type(command_t), intent(in) :: commands(:)
        type(console_t), intent(inout) :: console

        character(:), allocatable :: name
        integer :: i

        do i = 1, size(commands)
            if (index(commands(i)%name, group) /= 1) cycle
            name = trim(commands(i)%name(len(group) + 1:))
            if (index(name, ' ') == 0) call console%line(name//':'//trim(commands(i)%summary))
        end do
        if (group /= '') return
        do i = 1, size(COMMAND_GROUPS)
            call console%line(trim(COMMAND_GROUPS(i))//':'//trim(GROUP_SUMMARIES(i)))
        end do
        call console%line('help:shows the help of a command')
    end subroutine offer_commands

    !> The values of an option that was typed last, else all options and the words that are none.
    subroutine offer_arguments(command, last, console)
        type(arguments_t), intent(in) :: command    !! As declared
        character(*), intent(in) :: last            !! The last word
        type(console_t), intent(inout) :: console

        integer :: i

        do i = 1, size(command%options)
            associate (option => command%options(i))
                if (option%name /= last .or. option%count == 0) cycle
                call offer_values(last, option%placeholder, option%choices, console)
                return
            end associate
        end do
        do i = 1, size(command%options)
            call console%line(command%options(i)%name//':'//command%options(i)%help)
        end do
        call console%line('--help:shows the help of the command')
        call offer_values('', command%positionals, command%choices, console)
    end subroutine offer_arguments

    subroutine offer_values(name, placeholder, choices, console)
        character(*), intent(in) :: name            !! Of the option; empty: a word that is none
        character(*), intent(in) :: placeholder     !! 'DIR'
        character(*), intent(in) :: choices         !! By blanks; empty: anything
        type(console_t), intent(inout) :: console

        type(string_t), allocatable :: values(:)
        logical :: cases
        integer :: i

        cases = choices == '' .and. (index(placeholder, 'CASE') > 0 .or. name == '--cases')
        if (placeholder == 'LIST' .and. (choices /= '' .or. cases)) call console%line(LIST)
        values = split_words(choices)
        if (cases) values = split_words(join(REPORT_CASE_NAMES, ' ')//' '//join(CASE_GROUPS, ' '))
        do i = 1, size(values)
            call console%line(values(i)%text)
        end do
        if (size(values) > 0 .and. .not. cases) return
        if (index(placeholder, 'DIR') > 0) call console%line(FOLDERS)
        if (index(placeholder, 'FILE') > 0 .or. cases) call console%line(FILES)
    end subroutine offer_values
end module gracecg_cli_completion
