!> The command line: finds the command, has it declare and parse its arguments, and runs it.
module gracecg_cli_command_line
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_arithmetic, only: check_arithmetic
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: string_t
    use gracecg_files_run_record, only: begin_record, end_record
    use gracecg_files_value, only: did_you_mean
    use gracecg_cli_arguments, only: arguments_t
    use gracecg_cli_console, only: console_t
    use gracecg_cli_process, only: caught_signal, INTERRUPTED
    use gracecg_cli_command, only: command_t, COMMAND_GROUPS, GROUP_SUMMARIES
    use gracecg_cli_cases, only: declare_cases, run_cases
    use gracecg_cli_verify, only: declare_verify, run_verify
    use gracecg_cli_simulate, only: declare_simulate, run_simulate
    use gracecg_cli_estimate, only: declare_estimate, run_estimate
    use gracecg_cli_bound, only: declare_bound, run_bound
    use gracecg_cli_montecarlo, only: declare_montecarlo, run_montecarlo, declare_merge, run_merge
    use gracecg_cli_errors, only: declare_errors, run_errors
    use gracecg_cli_reliability, only: declare_reliability, run_reliability
    use gracecg_cli_magnetometer_loss, only: declare_magnetometer_loss, run_magnetometer_loss
    use gracecg_cli_statements, only: declare_statements, run_statements
    use gracecg_cli_history, only: declare_history, run_history
    use gracecg_cli_trim, only: declare_trim, run_trim
    use gracecg_cli_timing, only: declare_timing, run_timing
    use gracecg_cli_report, only: declare_report, run_report
    use gracecg_cli_design, only: declare_design, run_design
    use gracecg_cli_model, only: declare_gravity, run_gravity, declare_field, run_field, &
        declare_density, run_density, declare_wind, run_wind, declare_sun, run_sun, declare_orientation, run_orientation
    implicit none
    private
    public :: run_command_line, STATUS_DONE, STATUS_FAILED, STATUS_MISUSED

    !> Exit statuses: done, the work failed, wrong usage
    integer, parameter :: STATUS_DONE = 0, STATUS_FAILED = 1, STATUS_MISUSED = 2
    character(*), parameter :: LF = new_line('a')
    character(*), parameter :: OF_VERSION = 'gracecg '//VERSION

contains

    !> The commands of this package, in the order of the help.
    function own_commands() result(commands)
        type(command_t), allocatable :: commands(:)

        commands = [ &
            command_t('cases', 'lists the built-in cases, or shows one as a namelist', declare_cases, run_cases), &
            command_t('verify', 'the curves of CSR-TM-00-01 section 5.3 against their windows', declare_verify, run_verify), &
            command_t('simulate', 'writes the true arc and a noisy observation set of a case', declare_simulate, run_simulate), &
            command_t('estimate', 'the CG offset from an observation set', declare_estimate, run_estimate), &
            command_t('bound', 'the least error that a manoeuvre allows (Cramer-Rao)', declare_bound, run_bound), &
            command_t('montecarlo', 'RMS errors over many calibrations: Tables 6.1 and 6.2', declare_montecarlo, run_montecarlo), &
            command_t('merge', 'puts the shards of a Monte Carlo together', declare_merge, run_merge), &
            command_t('errors', 'RMS errors with one error source off at a time: Figure 6.5', declare_errors, run_errors), &
            command_t('reliability', 'what is found of wrong beliefs of the operator, tried', &
                      declare_reliability, run_reliability), &
            command_t('magnetometer-loss', 'the field model instead of the magnetometer: Figure 6.6', &
                      declare_magnetometer_loss, run_magnetometer_loss), &
            command_t('statements', 'what CSR-TM-00-01 states without a table or figure, examined', &
                      declare_statements, run_statements), &
            command_t('history', 'the CG offset over months and years', declare_history, run_history), &
            command_t('trim', 'calibrates and moves masses until the offset is small', declare_trim, run_trim), &
            command_t('timing', 'the best time for a calibration: Figures 6.1 and 6.4', declare_timing, run_timing), &
            command_t('report', 'everything that CSR-TM-00-01 shows, as one HTML page', declare_report, run_report), &
            command_t('design', 'plans the manoeuvre of the torque rods', declare_design, run_design), &
            command_t('model gravity', 'gravitational acceleration and potential', declare_gravity, run_gravity), &
            command_t('model field', 'geomagnetic field', declare_field, run_field), &
            command_t('model density', 'thermosphere: density, temperature, composition', declare_density, run_density), &
            command_t('model wind', 'horizontal wind of the thermosphere', declare_wind, run_wind), &
            command_t('model sun', 'position of the Sun', declare_sun, run_sun), &
            command_t('model orientation', 'Earth-fixed from inertial axes', declare_orientation, run_orientation)]
    end function own_commands

    !> Runs the command of some words. Everything that goes wrong is said on the console.
    subroutine run_command_line(words, console, status, others)
        type(string_t), intent(in) :: words(:)
        !! Of the command line, without the program's name
        type(console_t), intent(inout) :: console
        integer, intent(out) :: status              !! STATUS_DONE, STATUS_FAILED, STATUS_MISUSED, or the console's
        type(command_t), intent(in), optional :: others(:)  !! Commands of other packages, behind those of this one

        type(command_t), allocatable :: commands(:)
        type(error_t), allocatable :: misuse, error, output_error
        type(string_t), allocatable :: asked(:)
        character(:), allocatable :: text
        integer :: position, used

        commands = own_commands()
        if (present(others)) commands = [commands, others]
        asked = words
        if (size(words) > 1) then
            if (words(1)%text == 'help') asked = [words(2:), string_t('--help')]
        end if
        call find_command(asked, commands, position, used, text, misuse)
        if (position > 0) then
            call run_command(commands(position), asked(used + 1:), console, misuse, error)
        else if (.not. allocated(misuse)) then
            call console%line(text)
        end if
        call console%finish(output_error)

        status = console%status_done
        if (allocated(misuse)) then
            call console%message('gracecg: '//misuse%message)
            status = STATUS_MISUSED
        else if (allocated(error)) then
            call console%message('gracecg: '//error%message)
            status = STATUS_FAILED
            if (caught_signal() /= 0) status = INTERRUPTED + caught_signal()
        else if (allocated(output_error)) then
            call console%message('gracecg: '//output_error%message)
            status = STATUS_FAILED
        end if
    end subroutine run_command_line

    !> The work of `gracecg command`.
    subroutine run_command(command, words, console, misuse, error)
        type(command_t), intent(in) :: command
        type(string_t), intent(in) :: words(:)      !! Behind its name
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(arguments_t) :: arguments

        call command%declare(arguments)
        call arguments%parse(words, misuse)
        if (allocated(misuse)) return
        if (arguments%wants_help) then
            call console%line(arguments%help_text())
        else if (arguments%wants_version) then
            call console%line(OF_VERSION)
        else
            call check_arithmetic(error)
            call begin_record(arguments%command_line(), console%commit)
            if (.not. allocated(error)) call command%run(arguments, console, misuse, error)
            call end_record()
        end if
    end subroutine run_command

    !> The command that the first word, or that of a group and the second word, names. Position 0: none is named, but
    !> help or the version is asked for.
    subroutine find_command(words, commands, position, used, text, misuse)
        type(string_t), intent(in) :: words(:)
        type(command_t), intent(in) :: commands(:)
        integer, intent(out) :: position    !! In commands
        integer, intent(out) :: used        !! Words that make its name
        character(:), allocatable, intent(out) :: text      !! What is asked for where the position is 0
        type(error_t), allocatable, intent(out) :: misuse

        character(len(commands%name)), allocatable :: names(:)
        character(:), allocatable :: name, group

        position = 0
        text = overview(commands)
        name = ''
        group = ''
        do used = 1, min(2, size(words))
            associate (word => words(used)%text)
                if (word == '--help' .or. word == '-h' .or. word == 'help') return
                if (word == '--version') text = OF_VERSION
                if (word == '--version') return
                name = trim(name//' '//word)
                if (used == 1) name = word
                if (used == 2 .or. all(COMMAND_GROUPS /= word)) exit
                group = word
                text = list_of(commands, group)
            end associate
        end do
        if (size(words) == 0) return
        if (name == group) then
            call fail(misuse, 'which '//name//'?'//LF//text)
            return
        end if
        names = commands%name
        position = findloc(names == name, .true., 1)
        if (position == 0) &
            call fail(misuse, 'unknown command "'//name//'"'//did_you_mean(name, names)// &
                      LF//'commands: gracecg --help')
    end subroutine find_command

    !> The help of the program itself.
    function overview(commands) result(text)
        type(command_t), intent(in) :: commands(:)
        character(:), allocatable :: text

        text = 'gracecg '//VERSION//': centre-of-gravity calibration of GRACE-type satellites'//LF//LF// &
            list_of(commands, '')//LF//LF//'gracecg help COMMAND shows the options of a command and an example.'//LF// &
            'Exit status: 0 done, 1 the work failed, 2 wrong usage, 3 done, but not to be used,'//LF// &
            '             130 stopped by Ctrl-C, 143 by kill.'//LF//LF// &
            'example: simulate a calibration and estimate the offset from it'//LF// &
            '  gracecg simulate front-1 --out run1'//LF// &
            '  gracecg estimate run1 --algorithm assest-fde'
    end function overview

    !> Usage and names of all commands, or of one group.
    function list_of(commands, group) result(text)
        type(command_t), intent(in) :: commands(:)
        character(*), intent(in) :: group       !! Of COMMAND_GROUPS; empty: all commands
        character(:), allocatable :: text

        integer :: i

        text = 'usage: gracecg COMMAND [ARGUMENTS] [OPTIONS]'//LF//LF//'commands:'
        if (group /= '') text = 'usage: gracecg '//group//' NAME [OPTIONS]'//LF//LF// &
                                trim(GROUP_SUMMARIES(findloc(COMMAND_GROUPS == group, .true., 1)))//':'
        do i = 1, size(commands)
            if (group == '' .or. index(commands(i)%name, group//' ') == 1) &
                text = text//LF//'  '//commands(i)%name//trim(commands(i)%summary)
        end do
        if (group /= '') text = text//LF//LF//'gracecg help '//group//' NAME shows the options of one of them and an example.'
    end function list_of
end module gracecg_cli_command_line
