!> Completion of the command line in a shell, made of what the commands declare.
!>
!> A value that an option names FILE or DIR is completed as a path, CASE as a built-in case or a file, one with
!> choices by these, a LIST after each comma anew; of numbers nothing is known.
module gracecg_cli_completion
    use gracecg_base_text, only: string_t, join, split_words
    use gracecg_base_version, only: VERSION
    use gracecg_simulation_case_library, only: CASE_GROUPS
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_cli_arguments, only: arguments_t, offered_t
    use gracecg_cli_command, only: command_t, COMMAND_GROUPS, GROUP_SUMMARIES
    implicit none
    private
    public :: completion_script, SHELLS

    character(4), parameter :: SHELLS(2) = [character(4) :: 'bash', 'zsh']    !! That are completed
    character(*), parameter :: LF = new_line('a')
    character(1), parameter :: BACKSLASH = achar(92)

contains

    !> The script of a shell.
    subroutine completion_script(shell, commands, script)
        character(*), intent(in) :: shell               !! One of SHELLS
        type(command_t), intent(in) :: commands(:)
        character(:), allocatable, intent(out) :: script    !! Without a line end

        if (shell == 'zsh') then
            call write_zsh(commands, script)
        else
            call write_bash(commands, script)
        end if
    end subroutine completion_script

    !> Their first words, each once, and what stands in their place.
    function first_words(commands) result(words)
        type(command_t), intent(in) :: commands(:)
        character(:), allocatable :: words

        integer :: i

        words = ''
        do i = 1, size(commands)
            if (in_group(commands(i))) cycle
            words = words//trim(commands(i)%name)//' '
        end do
        do i = 1, size(COMMAND_GROUPS)
            words = words//trim(COMMAND_GROUPS(i))//' '
        end do
        words = words//'help'
    end function first_words

    function words_of_group(group, commands) result(words)
        character(*), intent(in) :: group       !! First word
        type(command_t), intent(in) :: commands(:)
        character(:), allocatable :: words

        integer :: i

        words = ''
        do i = 1, size(commands)
            if (index(commands(i)%name, group//' ') == 1) words = words//' '//trim(commands(i)%name(len(group) + 2:))
        end do
        words = words(2:)
    end function words_of_group

    !> Whether a command has two words.
    pure logical function in_group(command)
        type(command_t), intent(in) :: command

        in_group = index(trim(command%name), ' ') > 0
    end function in_group

    function case_words() result(words)
        character(:), allocatable :: words

        integer :: i

        words = ''
        do i = 1, size(REPORT_CASE_NAMES)
            words = words//' '//trim(REPORT_CASE_NAMES(i))
        end do
        words = words(2:)
    end function case_words

    !> How a value is completed: files, folders, cases, nothing, or the words themselves behind `words `, of values
    !> with commas between them behind `list `.
    function kind_of(offered) result(kind)
        type(offered_t), intent(in) :: offered
        character(:), allocatable :: kind

        if (offered%placeholder == 'LIST' .and. (offered%choices /= '' .or. offered%name == '--cases')) then
            kind = 'list '//case_words()//' '//join(CASE_GROUPS, ' ')
            if (offered%choices /= '') kind = 'list '//offered%choices
        else if (offered%choices /= '') then
            kind = 'words '//offered%choices
        else if (index(offered%placeholder, 'FILE') > 0) then
            kind = 'files'
        else if (index(offered%placeholder, 'DIR') > 0) then
            kind = 'folders'
        else if (index(offered%placeholder, 'CASE') > 0 .or. offered%name == '--cases') then
            kind = 'cases'
        else
            kind = 'nothing'
        end if
    end function kind_of

    subroutine write_bash(commands, script)
        type(command_t), intent(in) :: commands(:)
        character(:), allocatable, intent(out) :: script

        type(arguments_t) :: arguments
        type(offered_t), allocatable :: offered(:)
        character(:), allocatable :: names, kinds
        integer :: i, k

        script = '# Completion of gracecg '//VERSION//' for bash, written by: gracecg completion bash'//LF// &
            '_gracecg()'//LF//'{'//LF// &
            '    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]}'//LF// &
            '    local command=${COMP_WORDS[1]} place=2 options= kind=nothing positional=nothing'//LF// &
            '    COMPREPLY=()'//LF// &
            '    if [[ $command == help ]]; then'//LF// &
            '        command=${COMP_WORDS[2]}'//LF// &
            '        place=3'//LF// &
            '    fi'//LF// &
            '    case $command in '//join(COMMAND_GROUPS, ' | ')//')'//LF// &
            '        command="$command ${COMP_WORDS[place]}"'//LF// &
            '        place=$((place + 1)) ;;'//LF// &
            '    esac'//LF// &
            '    if ((COMP_CWORD < place)); then'//LF// &
            '        options="'//first_words(commands)//' --help --version"'//LF
        do i = 1, size(COMMAND_GROUPS)
            script = script//'        [[ $command == "'//trim(COMMAND_GROUPS(i))//' "* ]] && options="'// &
                     words_of_group(trim(COMMAND_GROUPS(i)), commands)//'"'//LF
        end do
        script = script// &
            '        mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")'//LF// &
            '        return'//LF// &
            '    fi'//LF// &
            '    [[ ${COMP_WORDS[1]} == help ]] && return'//LF// &
            '    case $command in'//LF
        do i = 1, size(commands)
            call commands(i)%declare(arguments)
            call arguments%completion(offered)
            names = ''
            kinds = ''
            do k = 1, size(offered) - 1
                names = names//' '//offered(k)%name
                if (offered(k)%placeholder == '') cycle
                if (kind_of(offered(k)) == 'nothing') cycle
                kinds = kinds//'                '//offered(k)%name//") kind='"//kind_of(offered(k))//"' ;;"//LF
            end do
            script = script//"        '"//trim(commands(i)%name)//"')"//LF// &
                     "            options='"//names(2:)//"'"//LF// &
                     "            positional='"//kind_of(offered(size(offered)))//"'"//LF
            if (kinds /= '') script = script//'            case $previous in'//LF//kinds//'            esac'//LF
            script = script//"            case ' "//values_of(offered)//" ' in"//LF// &
                     '                *" $previous "*) ;;'//LF// &
                     '                *) kind=$positional ;;'//LF//'            esac'//LF//'            ;;'//LF
        end do
        script = script//'    esac'//LF// &
            '    if [[ $current == -* ]]; then'//LF// &
            '        mapfile -t COMPREPLY < <(compgen -W "$options" -- "$current")'//LF// &
            '        return'//LF// &
            '    fi'//LF// &
            '    case $kind in'//LF// &
            '        files) compopt -o filenames; mapfile -t COMPREPLY < <(compgen -f -- "$current") ;;'//LF// &
            '        folders) compopt -o filenames; mapfile -t COMPREPLY < <(compgen -d -- "$current") ;;'//LF// &
            '        cases)'//LF// &
            '            compopt -o filenames'//LF// &
            '            mapfile -t COMPREPLY < <(compgen -W "'//case_words()//'" -- "$current"; compgen -f -- "$current")'// &
            LF//'            ;;'//LF// &
            '        "words "*) mapfile -t COMPREPLY < <(compgen -W "${kind#words }" -- "$current") ;;'//LF// &
            '        "list "*)'//LF// &
            '            local before='//LF// &
            '            [[ $current == *,* ]] && before=${current%,*},'//LF// &
            '            mapfile -t COMPREPLY < <(compgen -P "$before" -W "${kind#list }" -- "${current##*,}")'//LF// &
            '            ;;'//LF// &
            '    esac'//LF//'}'//LF//'complete -F _gracecg gracecg'
    end subroutine write_bash

    !> The options that take a value.
    function values_of(offered) result(names)
        type(offered_t), intent(in) :: offered(:)
        character(:), allocatable :: names

        integer :: k

        names = ''
        do k = 1, size(offered) - 1
            if (offered(k)%placeholder /= '') names = names//' '//offered(k)%name
        end do
        names = trim(adjustl(names))
    end function values_of

    subroutine write_zsh(commands, script)
        type(command_t), intent(in) :: commands(:)
        character(:), allocatable, intent(out) :: script

        type(arguments_t) :: arguments
        type(offered_t), allocatable :: offered(:)
        integer :: i, k

        script = '#compdef gracecg'//LF// &
            '# Completion of gracecg '//VERSION//' for zsh, written by: gracecg completion zsh'//LF//LF// &
            '_gracecg_cases() {'//LF// &
            "    _alternative 'cases:built-in case:("//case_words()//")' 'files:case file:_files'"//LF//'}'//LF//LF// &
            '_gracecg() {'//LF//'    local -a commands '//join(COMMAND_GROUPS, ' ')//LF//'    local command'//LF// &
            '    commands=('//LF
        do i = 1, size(commands)
            if (in_group(commands(i))) cycle
            script = script//"        '"//trim(commands(i)%name)//':'//zsh_text(trim(commands(i)%summary))//"'"//LF
        end do
        do k = 1, size(COMMAND_GROUPS)
            script = script//"        '"//trim(COMMAND_GROUPS(k))//':'//trim(GROUP_SUMMARIES(k))//"'"//LF
        end do
        script = script//"        'help:shows the help of a command')"//LF
        do k = 1, size(COMMAND_GROUPS)
            script = script//'    '//trim(COMMAND_GROUPS(k))//'=('//LF
            do i = 1, size(commands)
                if (index(commands(i)%name, trim(COMMAND_GROUPS(k))//' ') /= 1) cycle
                script = script//"        '"//trim(commands(i)%name(len_trim(COMMAND_GROUPS(k)) + 2:))//':'// &
                         zsh_text(trim(commands(i)%summary))//"'"//LF
            end do
            script = script//'    )'//LF
        end do
        script = script// &
            '    if [[ $words[2] == help ]] && ((CURRENT > 2)); then'//LF// &
            '        shift words'//LF//'        ((CURRENT -= 1))'//LF// &
            '        ((CURRENT == 2)) && _describe command commands'//LF// &
            '        case $words[2] in '//join(COMMAND_GROUPS, ' | ')// &
            ') ((CURRENT == 3)) && _describe command $words[2] ;; esac'//LF// &
            '        return'//LF//'    fi'//LF// &
            '    if ((CURRENT == 2)); then'//LF//'        _describe command commands'//LF//'        return'//LF//'    fi'//LF// &
            '    command=$words[2]'//LF// &
            '    case $command in '//join(COMMAND_GROUPS, ' | ')//')'//LF// &
            '        if ((CURRENT == 3)); then'//LF//'            _describe command $command'//LF//'            return'//LF// &
            '        fi'//LF//'        command="$command $words[3]"'//LF//'        shift words'//LF// &
            '        ((CURRENT -= 1)) ;;'//LF//'    esac'//LF// &
            '    shift words'//LF//'    ((CURRENT -= 1))'//LF//'    case $command in'//LF
        do i = 1, size(commands)
            call commands(i)%declare(arguments)
            call arguments%completion(offered)
            script = script//"        '"//trim(commands(i)%name)//"') _arguments"
            do k = 1, size(offered) - 1
                script = script//' '//BACKSLASH//LF//"            '"//offered(k)%name//'['//zsh_text(offered(k)%help)//']'// &
                         zsh_values(offered(k))//"'"
            end do
            associate (words => offered(size(offered)))
                if (words%placeholder /= '') &
                    script = script//' '//BACKSLASH//LF//"            '*:"//zsh_text(words%placeholder)//':'// &
                             zsh_action(words)//"'"
            end associate
            script = script//' ;;'//LF
        end do
        script = script//'    esac'//LF//'}'//LF//LF//'_gracecg "$@"'
    end subroutine write_zsh

    !> `:NAME:action` for each value of an option.
    function zsh_values(offered) result(text)
        type(offered_t), intent(in) :: offered
        character(:), allocatable :: text

        type(string_t), allocatable :: names(:)
        integer :: i

        names = split_words(offered%placeholder)
        text = ''
        do i = 1, size(names)
            text = text//':'//names(i)%text//':'//zsh_action(offered)
        end do
    end function zsh_values

    function zsh_action(offered) result(action)
        type(offered_t), intent(in) :: offered
        character(:), allocatable :: action

        action = kind_of(offered)
        select case (action)
        case ('files')
            action = '_files'
        case ('folders')
            action = '_files -/'
        case ('cases')
            action = '_gracecg_cases'
        case ('nothing')
            action = ' '
        case default
            if (index(action, 'list ') == 1) then
                action = '_values -s , LIST '//action(len('list ') + 1:)
            else
                action = '('//action(len('words ') + 1:)//')'
            end if
        end select
    end function zsh_action

    !> A text within single quotes of zsh, its brackets and colons escaped.
    function zsh_text(text) result(escaped)
        character(*), intent(in) :: text
        character(:), allocatable :: escaped

        integer :: i

        escaped = ''
        do i = 1, len(text)
            select case (text(i:i))
            case ('[', ']', ':', BACKSLASH)
                escaped = escaped//BACKSLASH//text(i:i)
            case ("'")
                escaped = escaped//"'"//BACKSLASH//"''"
            case default
                escaped = escaped//text(i:i)
            end select
        end do
    end function zsh_text
end module gracecg_cli_completion
