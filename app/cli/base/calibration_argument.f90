!> The cases on a command line: what is simulated, and how it is estimated. One way to name them in every command:
!> words CASE ... or --cases LIST, each a built-in case, a group of these, or a namelist file.
module gracecg_cli_calibration_argument
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_text, only: string_t, append, integer_text, join
    use gracecg_spacecraft_torque_rods, only: check_rods_fire
    use gracecg_estimation_options, only: read_options
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_instrument_limits, only: instrument_warnings
    use gracecg_simulation_case_library, only: CASE_GROUPS, expanded_cases
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_console, only: console_t
    implicit none
    private
    public :: add_options_option, add_cases_option, take_calibration, take_firing_calibration
    public :: take_calibrations, take_one_calibration, warn_of_instruments, MOST_CASES

    integer, parameter :: MOST_CASES = 1000     !! Words CASE of a command that takes several

contains

    !> The option --options FILE, of commands that take a CASE.
    subroutine add_options_option(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%add_option('--options', 'FILE', 'namelist file that says how to estimate, instead of the '// &
                                  'groups &estimation, &optimal and &sequential of the case file')
    end subroutine add_options_option

    !> The option --cases LIST, of commands that take words CASE.
    subroutine add_cases_option(arguments, default, single)
        type(arguments_t), intent(inout) :: arguments
        character(*), intent(in) :: default             !! What is taken when no case is named, for the help
        logical, intent(in), optional :: single         !! The command takes one case only; no when absent

        logical :: one

        one = .false.
        if (present(single)) one = single
        if (one) then
            call arguments%add_option('--cases', 'CASE', 'another way to name the CASE: a built-in case or a '// &
                                      'namelist file (default '//default//')')
        else
            call arguments%add_option('--cases', 'LIST', 'another way to name each CASE, separated by commas: '// &
                                      'built-in cases, groups of them ('//join(CASE_GROUPS, ', ')// &
                                      ') or namelist files (default '//default//')')
        end if
    end subroutine add_cases_option

    !> All cases of a command that estimates, checked and each with a name of its own. Fails as
    !> take_firing_calibration does for any of them, and when two have the same name.
    subroutine take_calibrations(arguments, default, console, calibrations, misuse, error, may_rest)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: default         !! Names, by commas, when the user names none
        type(console_t), intent(inout) :: console
        type(calibration_t), allocatable, intent(out) :: calibrations(:)
        type(error_t), allocatable, intent(inout) :: misuse     !! The words are wrong
        type(error_t), allocatable, intent(out) :: error        !! A case is
        logical, intent(in), optional :: may_rest   !! The torque rods may be off; no when absent

        type(string_t), allocatable :: names(:)
        logical :: resting
        integer :: i, k

        call take_names(arguments, default, names, misuse)
        if (allocated(misuse)) return
        resting = .false.
        if (present(may_rest)) resting = may_rest
        allocate (calibrations(size(names)))
        do i = 1, size(names)
            if (resting) then
                call take_calibration(arguments, names(i)%text, console, calibrations(i), error)
            else
                call take_firing_calibration(arguments, names(i)%text, console, calibrations(i), error)
            end if
            if (allocated(error)) return
            do k = 1, i - 1
                if (calibrations(k)%case%name /= calibrations(i)%case%name) cycle
                call fail(error, 'two cases have the name "'//trim(calibrations(i)%case%name)//'" ('//names(k)%text// &
                          ' and '//names(i)%text//'): their results could not be told apart; change `name` in the '// &
                          'namelist file')
                return
            end do
        end do
    end subroutine take_calibrations

    !> The case of a command that takes one only.
    subroutine take_one_calibration(arguments, default, console, calibration, misuse, error, may_rest)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: default             !! As of take_calibrations
        type(console_t), intent(inout) :: console
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(inout) :: misuse
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: may_rest       !! As of take_calibrations

        type(string_t), allocatable :: names(:)
        type(calibration_t), allocatable :: calibrations(:)

        call take_names(arguments, default, names, misuse)
        if (allocated(misuse)) return
        call refuse_if(size(names) > 1, integer_text(size(names))//' cases are named; this command takes one', misuse)
        if (allocated(misuse)) return
        call take_calibrations(arguments, default, console, calibrations, misuse, error, may_rest)
        if (.not. (allocated(misuse) .or. allocated(error))) calibration = calibrations(1)
    end subroutine take_one_calibration

    !> The names of the cases: the words, those of --cases and of the older --case, groups as their members.
    subroutine take_names(arguments, default, names, misuse)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: default
        type(string_t), allocatable, intent(out) :: names(:)
        type(error_t), allocatable, intent(inout) :: misuse

        type(string_t), allocatable :: given(:), listed(:)
        character(:), allocatable :: older
        integer :: i

        allocate (given(0))
        do i = 1, arguments%positional_count()
            call append(given, arguments%positional(i))
        end do
        if (arguments%has('--case')) then
            call arguments%get('--case', older, misuse)
            call append(given, older)
        end if
        if (arguments%has('--cases') .or. size(given) == 0) then
            call arguments%get('--cases', listed, misuse, default=default)
            do i = 1, size(listed)
                call append(given, listed(i)%text)
            end do
        end if
        call expanded_cases(given, names)
    end subroutine take_names

    !> The calibration of a name or path, with the options of --options if the command has it. Says on
    !> standard error what a file of version 0.1 has at another place.
    subroutine take_calibration(arguments, name, console, calibration, error)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: name            !! A built-in case or a case file
        type(console_t), intent(inout) :: console
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: path

        call find_calibration(name, calibration, error)
        if (allocated(error)) return
        if (allocated(calibration%warning)) call console%warn(calibration%warning%text)
        if (.not. arguments%has('--options')) return
        call arguments%get('--options', path, error)
        if (.not. allocated(error)) call read_options(path, calibration%options, error)
    end subroutine take_calibration

    !> Warns of the settings of a case's instruments that are beyond what the report says of them: for commands that
    !> draw their samples.
    subroutine warn_of_instruments(case, console)
        type(case_t), intent(in) :: case
        type(console_t), intent(inout) :: console

        type(string_t), allocatable :: warnings(:)
        integer :: i

        call instrument_warnings(case%satellite, warnings)
        do i = 1, size(warnings)
            call console%warn('case '//trim(case%name)//': '//warnings(i)%text)
        end do
    end subroutine warn_of_instruments

    !> The same for who estimates: fails, too, when all torque rods of the case are off.
    subroutine take_firing_calibration(arguments, name, console, calibration, error)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: name            !! As of take_calibration
        type(console_t), intent(inout) :: console
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error

        call take_calibration(arguments, name, console, calibration, error)
        if (allocated(error)) return
        associate (case => calibration%case)
            call check_rods_fire(case%satellite%rods, case%duration, error)
            call add_context(error, 'case '//trim(case%name))
        end associate
    end subroutine take_firing_calibration
end module gracecg_cli_calibration_argument
