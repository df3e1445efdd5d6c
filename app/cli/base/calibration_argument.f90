!> The cases on a command line, what is simulated and how it is estimated, and the options that most studies share. One
!> way to name cases in every command: words CASE ... or --cases LIST, each a built-in case, a group of these, or a
!> namelist file.
module gracecg_cli_calibration_argument
    use gracecg_base_kinds, only: i8
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_text, only: string_t, integer_text, join, split, split_words
    use gracecg_files_file, only: check_writable
    use gracecg_environment_geomagnetic_field, only: is_extrapolated
    use gracecg_environment_time, only: utc_t, utc_text, decimal_year
    use gracecg_spacecraft_torque_rods, only: check_rods_fire
    use gracecg_estimation_estimators, only: ESTIMATOR_NAMES
    use gracecg_estimation_options, only: read_options
    use gracecg_simulation_report_cases, only: CASE_GROUPS, expanded_cases
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_cli_arguments, only: arguments_t, refuse_if, MOST_RUNS
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: add_format_option, take_format
    implicit none
    private
    public :: study_t, add_study_options, take_options, take_study
    public :: take_calibration, take_calibrations, warn_of_field, MOST_CASES

    integer, parameter :: MOST_CASES = 1000     !! Words CASE of a command that takes several

    !> What most studies are told.
    type :: study_t
        type(calibration_t), allocatable :: calibrations(:)     !! At least one
        type(string_t), allocatable :: algorithms(:)    !! Of --algorithm, --algorithms
        integer(i8) :: seed = 1                         !! Of the random numbers
        integer :: runs = 1         !! Of --runs
        integer :: threads = 1      !! Of --threads
        character(:), allocatable :: path               !! Of --out; empty: no file
    end type study_t

contains

    !> Declares some of the options that studies share.
    subroutine add_study_options(arguments, names, algorithms, runs)
        type(arguments_t), intent(inout) :: arguments
        character(*), intent(in) :: names       !! Between blanks, in the order of the help: '--seed --threads --out'
        character(*), intent(in), optional :: algorithms
        !! Default of --algorithms; of --algorithm, which must be given without one
        character(*), intent(in), optional :: runs              !! Default of --runs

        type(string_t), allocatable :: list(:)
        integer :: i

        list = split_words(names)
        do i = 1, size(list)
            associate (name => list(i)%text)
                select case (name)
                case ('--cases')
                    call add_cases_option(arguments)
                case ('--algorithm')
                    call arguments%add_option(name, 'NAME', 'one of '//join(ESTIMATOR_NAMES, ', '), &
                                              required=.not. present(algorithms), choices=ESTIMATOR_NAMES, default=algorithms)
                case ('--algorithms')
                    call arguments%add_option(name, 'LIST', 'of '//join(ESTIMATOR_NAMES, ', '), &
                                              choices=ESTIMATOR_NAMES, default=algorithms)
                case ('--runs')
                    call arguments%add_option(name, 'N', 'of each simulation', default=runs)
                case ('--seed')
                    call arguments%add_option(name, 'S', 'of the random numbers', default='1')
                case ('--run')
                    call arguments%add_option(name, 'K', 'number of the run: other random numbers of the same seed', default='1')
                case ('--threads')
                    call arguments%add_option(name, 'N', 'to work on (default: the processors of the machine)')
                case ('--out')
                    call arguments%add_option(name, 'FILE', 'CSV file for the table')
                case ('--format')
                    call add_format_option(arguments)
                case ('--options')
                    call arguments%add_option(name, 'FILE', 'namelist file that says how to estimate, instead of the groups '// &
                                              '&estimation, &optimal and &sequential of the case file')
                end select
            end associate
        end do
    end subroutine add_study_options

    !> The option --cases LIST, of commands that take words CASE.
    subroutine add_cases_option(arguments)
        type(arguments_t), intent(inout) :: arguments

        character(*), parameter :: WORDS = 'another way to name '

        if (arguments%most == 1) then
            call arguments%add_option('--cases', 'CASE', WORDS//'the CASE: a built-in case, a namelist file, or the '// &
                                      'folder of an observation set')
        else
            call arguments%add_option('--cases', 'LIST', WORDS//'each CASE, separated by commas: built-in cases, groups of '// &
                                      'them ('//join(CASE_GROUPS, ', ')//'), namelist files, or folders of observation sets')
        end if
    end subroutine add_cases_option

    !> Takes those of the options that the command has.
    subroutine take_options(arguments, console, study, misuse, fewest)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(study_t), intent(inout) :: study
        type(error_t), allocatable, intent(inout) :: misuse     !! The words are wrong
        integer, intent(in) :: fewest           !! Runs

        if (arguments%declares('--algorithm')) call arguments%get('--algorithm', study%algorithms, misuse)
        if (arguments%declares('--algorithms')) call arguments%get('--algorithms', study%algorithms, misuse)
        if (arguments%declares('--runs')) call arguments%get('--runs', study%runs, misuse, low=fewest, high=MOST_RUNS)
        if (arguments%declares('--seed')) call arguments%get('--seed', study%seed, misuse)
        if (arguments%declares('--threads')) call arguments%get_threads(study%threads, misuse)
        study%path = ''
        if (arguments%declares('--out')) call arguments%get('--out', study%path, misuse)
        if (arguments%declares('--format')) call take_format(arguments, console, misuse)
    end subroutine take_options

    !> Takes those of the options that the command has, and its cases. Fails as take_calibrations does, and when the file
    !> for the table cannot be written.
    subroutine take_study(arguments, default, console, study, misuse, error, may_rest)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: default         !! Names of cases, by commas, when the user names none
        type(console_t), intent(inout) :: console
        type(study_t), intent(out) :: study
        type(error_t), allocatable, intent(inout) :: misuse     !! The words are wrong
        type(error_t), allocatable, intent(out) :: error        !! A case or the file is
        logical, intent(in), optional :: may_rest   !! As of take_calibrations

        call take_options(arguments, console, study, misuse, 1)
        if (allocated(misuse)) return
        call check_writable(study%path, error)
        if (allocated(error)) return
        call take_calibrations(arguments, default, study%calibrations, misuse, error, may_rest, console)
    end subroutine take_study

    !> Says when the field of a date is extrapolated.
    subroutine warn_of_field(model, date, console)
        character(*), intent(in) :: model           !! Of the geomagnetic field
        type(utc_t), intent(in) :: date
        type(console_t), intent(inout) :: console

        if (is_extrapolated(model, decimal_year(date))) &
            call console%warn('the magnetic field of '//trim(utc_text(date))//' is extrapolated: igrf14 ends with 2029; after '// &
                              'five years it may be wrong by some 100 nT; a later model can be given as a file')
    end subroutine warn_of_field

    !> All cases of a command that estimates, checked and each with a name of its own. Fails as
    !> take_calibration does for any of them, and when two have the same name.
    subroutine take_calibrations(arguments, default, calibrations, misuse, error, may_rest, console)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: default         !! Names, by commas, when the user names none
        type(calibration_t), allocatable, intent(out) :: calibrations(:)
        type(error_t), allocatable, intent(inout) :: misuse     !! The words are wrong
        type(error_t), allocatable, intent(out) :: error        !! A case is
        logical, intent(in), optional :: may_rest   !! The torque rods may be off; no when absent
        type(console_t), intent(inout), optional :: console     !! Is told of fields that are extrapolated

        type(string_t), allocatable :: listed(:), given(:), names(:)
        integer :: i, k

        call arguments%get('--cases', listed, misuse)
        given = [arguments%words, listed]
        if (size(given) == 0) given = split(default, ',')
        call expanded_cases(given, names)
        call refuse_if(size(names) > 1 .and. arguments%most == 1, integer_text(size(names))// &
                       ' cases are named; this command takes one', misuse)
        if (allocated(misuse)) return
        allocate (calibrations(size(names)))
        do i = 1, size(names)
            call take_calibration(arguments, names(i)%text, calibrations(i), error, may_rest)
            if (allocated(error)) return
            if (present(console)) call warn_of_field(calibrations(i)%case%field_model, calibrations(i)%case%epoch, console)
            do k = 1, i - 1
                if (calibrations(k)%case%name /= calibrations(i)%case%name) cycle
                call fail(error, 'two cases have the name "'//trim(calibrations(i)%case%name)//'" ('//names(k)%text// &
                          ' and '//names(i)%text//'): their results could not be told apart; change `name` in the '// &
                          'namelist file')
                return
            end do
        end do
    end subroutine take_calibrations

    !> The calibration of a name or path, with the options of --options if the command has it. Fails, too,
    !> when all torque rods of the case are off.
    subroutine take_calibration(arguments, name, calibration, error, may_rest)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: name            !! A built-in case or a case file
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: may_rest   !! All torque rods may be off; no when absent

        character(:), allocatable :: path

        call find_calibration(name, calibration, error)
        if (allocated(error)) return
        if (arguments%has('--options')) then
            call arguments%get('--options', path, error)
            if (.not. allocated(error)) call read_options(path, calibration%options, error)
        end if
        if (present(may_rest)) then
            if (may_rest) return
        end if
        if (allocated(error)) return
        associate (case => calibration%case)
            call check_rods_fire(case%satellite%rods, case%duration, error)
            call add_context(error, 'case '//trim(case%name))
        end associate
    end subroutine take_calibration
end module gracecg_cli_calibration_argument
