!> The arguments of a command: words that stand by their position, and options.
!>
!> A command describes itself and its options with their defaults, parses the words behind its name and fetches
!> typed values, one after the other; the first failure stays, so that one test behind them is enough. Help,
!> parsing and manual page come from that one description.
!> Options are `--name`, followed by as many values as declared, or `--name=value` (several
!> values then by comma). A word that begins with a minus sign and a digit is a value. Behind `--`
!> everything is a word. Every failure here is wrong usage.
module gracecg_cli_arguments
    use omp_lib, only: omp_get_num_procs
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_parallel, only: MOST_THREADS
    use gracecg_base_text, only: string_t, append, join, padded, parse_integer, split, split_words, integer_text
    use gracecg_cli_console, only: wrapped, quoted_word
    use gracecg_files_value, only: real_from_text, integer_from_text, choice_from_text, did_you_mean
    implicit none
    private
    public :: arguments_t, option_t, refuse_if, MOST_RUNS

    type :: option_t
        !! One option: as declared, and as given
        character(:), allocatable :: name           !! With its two minus signs
        character(:), allocatable :: placeholder    !! The values in the help: 'X Y Z'; empty: a switch
        character(:), allocatable :: help           !! What it is for
        character(:), allocatable :: choices        !! What a value may be, by blanks; empty: anything
        character(:), allocatable :: default        !! Its values where it is not given, by blanks; empty: none
        integer :: count = 0                        !! Number of values
        logical :: required = .false.               !! The command cannot do without it
        logical :: given = .false.                  !! It stands on the command line
        type(string_t), allocatable :: values(:)    !! As given
    end type option_t

    type :: arguments_t
        !! The arguments of one command
        logical :: wants_help = .false.             !! --help or -h was given: nothing else counts
        logical :: wants_version = .false.          !! --version was given
        character(:), allocatable :: positionals    !! In the usage line: 'CASE', '[CASE ...]', ''
        type(option_t), allocatable :: options(:)   !! In the order of the help
        character(:), allocatable, private :: command, summary, example
        integer, private :: fewest = 0
        integer :: most = 0                         !! Positional words, at most
        type(string_t), allocatable :: words(:)     !! That are no option
        character(:), allocatable, private :: typed     !! Command and words as given
    contains
        procedure :: describe           !! Begins the declaration
        procedure :: add_option         !! Declares an option
        procedure :: parse              !! Takes the words of the command line
        procedure :: positional_count   !! How many words are no option
        procedure :: positional         !! One of these words
        procedure :: has                !! Was an option given?
        procedure :: declares           !! Has the command an option?
        generic :: get => get_real, get_reals, get_integer, get_long, get_text, get_list
        !! The value or values of an option. What is neither given nor has a default stays as it is; after a failure all do
        procedure :: get_threads        !! The value of --threads
        procedure :: command_line       !! The command with its words, to be typed again
        procedure :: help_text          !! What --help prints
        procedure, private :: get_real, get_reals, get_integer, get_long, get_text, get_list
    end type arguments_t

    integer, parameter :: MOST_RUNS = 10000000  !! Of a Monte Carlo
    character(*), parameter :: PROGRAM_NAME = 'gracecg'
    character(*), parameter :: LF = new_line('a')
    integer, parameter :: HELP_COLUMN = 26      !! Where the texts of the options begin
    integer, parameter :: HELP_WIDTH = 100      !! Longest line of the help

contains

    !> Begins the declaration of a command.
    subroutine describe(self, command, positionals, fewest, most, summary, example)
        class(arguments_t), intent(out) :: self
        character(*), intent(in) :: command         !! As typed: 'model gravity'; may be empty
        character(*), intent(in) :: positionals     !! In the usage line: 'CASE', '[CASE ...]', ''
        integer, intent(in) :: fewest, most         !! Allowed number of positional words
        character(*), intent(in) :: summary         !! What the command does
        character(*), intent(in) :: example         !! One or more command lines, by new_line('a')

        self%command = trim(PROGRAM_NAME//' '//command)
        self%positionals = positionals
        self%fewest = fewest
        self%most = most
        self%summary = summary
        self%example = example
        allocate (self%options(0), self%words(0))
    end subroutine describe

    !> Declares an option. It takes as many values as `placeholder` has words: '' for a switch.
    subroutine add_option(self, name, placeholder, help, required, choices, default)
        class(arguments_t), intent(inout) :: self
        character(*), intent(in) :: name            !! '--out'
        character(*), intent(in) :: placeholder     !! 'DIR'
        character(*), intent(in) :: help            !! What it does, for the help
        logical, intent(in), optional :: required   !! The command cannot do without it
        character(*), intent(in), optional :: choices(:)    !! What a value, or each of a LIST, may be
        character(*), intent(in), optional :: default       !! Its values where it is not given, by blanks; the help tells it

        type(option_t) :: option
        type(option_t), allocatable :: longer(:)

        option%name = name
        option%placeholder = placeholder
        option%help = help
        option%count = size(split_words(placeholder))
        option%choices = ''
        option%default = ''
        if (present(choices)) option%choices = join(choices, ' ')
        if (present(required)) option%required = required
        if (present(default)) option%default = default
        if (option%default /= '') option%help = help//' (default '//default//')'
        allocate (option%values(0))
        allocate (longer(size(self%options) + 1))       ! gfortran 12 writes beyond a constructor's texts
        longer(:size(self%options)) = self%options
        longer(size(longer)) = option
        call move_alloc(longer, self%options)
    end subroutine add_option

    !> Sorts the words into options and positional words. Fails for an unknown option, a missing
    !> value, an option given twice, a required one not given, and too few or too many positional
    !> words. With --help or --version among the words nothing else is looked at.
    subroutine parse(self, words, error)
        class(arguments_t), intent(inout) :: self
        type(string_t), intent(in) :: words(:)      !! Without the name of the command
        type(error_t), allocatable, intent(out) :: error

        integer :: i
        logical :: only_words

        self%typed = self%command
        do i = 1, size(words)
            self%typed = self%typed//' '//quoted_word(words(i)%text)
        end do
        do i = 1, size(words)
            if (words(i)%text == '--') exit
            if (words(i)%text == '--help' .or. words(i)%text == '-h') self%wants_help = .true.
            if (words(i)%text == '--version') self%wants_version = .true.
        end do
        if (self%wants_help .or. self%wants_version) return
        only_words = .false.
        i = 1
        do while (i <= size(words))
            if (words(i)%text == '--' .and. .not. only_words) then
                only_words = .true.
                i = i + 1
            else if (is_option(words(i)%text) .and. .not. only_words) then
                call take_option(self, words, i, error)
                if (allocated(error)) exit
            else
                call append(self%words, words(i)%text)
                i = i + 1
            end if
        end do
        if (.not. allocated(error)) call check_complete(self, error)
        if (allocated(error)) &
            error%message = error%message//LF//'usage: '//usage_line(self)//LF// &
                            'more: '//self%command//' --help'
    end subroutine parse

    !> A minus sign with something behind it that is not a number.
    pure logical function is_option(word)
        character(*), intent(in) :: word

        is_option = .false.
        if (len(word) < 2) return
        is_option = word(1:1) == '-' .and. scan(word(2:2), '0123456789.') == 0
    end function is_option

    !> Takes option words(i) with its values; `i` is then the word behind them.
    subroutine take_option(self, words, i, error)
        class(arguments_t), intent(inout) :: self
        type(string_t), intent(in) :: words(:)
        integer, intent(inout) :: i
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: name
        integer :: position, equals

        name = words(i)%text
        equals = index(name, '=')
        if (equals > 0) name = name(:equals - 1)
        position = option_position(self, name)
        call refuse_if(position == 0, 'unknown option '//name//did_you_mean(name, option_names(self)), error)
        if (allocated(error)) return
        associate (option => self%options(position))
            call refuse_if(option%given, 'option '//name//' is given twice', error)
            call refuse_if(equals > 0 .and. option%count == 0, 'option '//name//' takes no value', error)
            option%given = .true.
            if (equals == 0) then
                call take_values(option, words, i)
            else if (option%count == 1) then
                call append(option%values, words(i)%text(equals + 1:))
            else
                option%values = split(words(i)%text(equals + 1:), ',')
            end if
            i = i + 1
            call refuse_if(size(option%values) == option%count .and. any_empty(option%values), &
                           'option '//name//': the value '//option%placeholder//' is empty', error)
            call refuse_if(size(option%values) /= option%count, 'option '//name//' takes '//integer_text(option%count)// &
                           trim(merge(' value: ', ' values:', option%count == 1))//' '//option%placeholder//' (found '// &
                           integer_text(size(option%values))//')', error)
        end associate
    end subroutine take_option

    !> Takes the words behind words(i) that are values, at most as many as the option has; `i` is
    !> then the last of them.
    subroutine take_values(option, words, i)
        type(option_t), intent(inout) :: option
        type(string_t), intent(in) :: words(:)
        integer, intent(inout) :: i

        do while (size(option%values) < option%count .and. i < size(words))
            if (is_option(words(i + 1)%text)) exit
            i = i + 1
            call append(option%values, words(i)%text)
        end do
    end subroutine take_values

    pure logical function any_empty(strings)
        type(string_t), intent(in) :: strings(:)

        integer :: i

        any_empty = .false.
        do i = 1, size(strings)
            any_empty = any_empty .or. strings(i)%text == ''
        end do
    end function any_empty

    !> The required options are given, and the number of positional words is right.
    subroutine check_complete(self, error)
        class(arguments_t), intent(in) :: self
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        call refuse_if(size(self%words) > self%most, 'unexpected argument "'//self%positional(self%most + 1)//'"', error)
        call refuse_if(size(self%words) < self%fewest, 'an argument is missing: '//self%positionals, error)
        call refuse_if(any_empty(self%words), 'an argument is empty: '//self%positionals, error)
        do i = 1, size(self%options)
            associate (option => self%options(i))
                call refuse_if(option%required .and. .not. option%given, 'option '//option%name//' '//option%placeholder// &
                               ' is required', error)
            end associate
        end do
    end subroutine check_complete

    pure integer function option_position(self, name) result(position)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name

        do position = 1, size(self%options)
            if (self%options(position)%name == name) return
        end do
        position = 0
    end function option_position

    pure function option_names(self) result(names)
        class(arguments_t), intent(in) :: self
        character(:), allocatable :: names(:)

        type(string_t) :: found(size(self%options) + 2)
        integer :: i

        do i = 1, size(self%options)
            found(i)%text = self%options(i)%name
        end do
        found(i)%text = '--help'
        found(i + 1)%text = '--version'
        names = padded(found)
    end function option_names

    pure integer function positional_count(self)
        class(arguments_t), intent(in) :: self

        positional_count = size(self%words)
    end function positional_count

    !> A positional word; empty when there are fewer.
    pure function positional(self, number) result(word)
        class(arguments_t), intent(in) :: self
        integer, intent(in) :: number       !! Counted from 1
        character(:), allocatable :: word

        word = ''
        if (number >= 1 .and. number <= size(self%words)) word = self%words(number)%text
    end function positional

    !> The command and its words, as they can be typed in a shell; empty before they are parsed.
    function command_line(self) result(line)
        class(arguments_t), intent(in) :: self
        character(:), allocatable :: line

        line = ''
        if (allocated(self%typed)) line = self%typed
    end function command_line

    !> Was the option given?
    pure logical function has(self, name)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name    !! '--out'

        has = self%declares(name)
        if (has) has = self%options(option_position(self, name))%given
    end function has

    !> Has the command such an option?
    pure logical function declares(self, name)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name    !! '--out'

        declares = option_position(self, name) > 0
    end function declares

    !> One real number. Fails when it is not a finite number within the limits (both ends included).
    subroutine get_real(self, name, value, error, low, high, unit)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name
        real(dp), intent(inout) :: value
        type(error_t), allocatable, intent(inout) :: error
        real(dp), intent(in), optional :: low, high
        character(*), intent(in), optional :: unit

        real(dp) :: values(1)

        values = value
        call self%get_reals(name, values, error, low, high, unit)
        value = values(1)
    end subroutine get_real

    !> As many real numbers as the option takes, each within the limits.
    subroutine get_reals(self, name, value, error, low, high, unit)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name
        real(dp), intent(inout) :: value(:)
        type(error_t), allocatable, intent(inout) :: error
        real(dp), intent(in), optional :: low, high
        character(*), intent(in), optional :: unit

        type(string_t), allocatable :: given(:)
        character(:), allocatable :: problem
        integer :: i

        call look_up(self, name, size(value), given, error)
        do i = 1, size(given)
            call real_from_text(given(i)%text, value(i), problem, low, high, unit)
            call refuse(name, problem, error)
            if (allocated(error)) return
        end do
    end subroutine get_reals

    !> On how many threads to work; by default as many as there are processors.
    subroutine get_threads(self, threads, error)
        class(arguments_t), intent(in) :: self
        integer, intent(out) :: threads         !! At least 1
        type(error_t), allocatable, intent(inout) :: error

        threads = omp_get_num_procs()
        call self%get('--threads', threads, error, low=1, high=MOST_THREADS)
    end subroutine get_threads

    !> One integer.
    subroutine get_integer(self, name, value, error, low, high)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name
        integer, intent(inout) :: value
        type(error_t), allocatable, intent(inout) :: error
        integer, intent(in), optional :: low, high

        type(string_t), allocatable :: given(:)
        character(:), allocatable :: problem

        call look_up(self, name, 1, given, error)
        if (size(given) == 0) return
        call integer_from_text(given(1)%text, value, problem, low, high)
        call refuse(name, problem, error)
    end subroutine get_integer

    !> One integer of 64 bits, with its sign.
    subroutine get_long(self, name, value, error)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name
        integer(i8), intent(inout) :: value
        type(error_t), allocatable, intent(inout) :: error

        type(string_t), allocatable :: given(:)
        logical :: ok

        call look_up(self, name, 1, given, error)
        if (size(given) == 0) return
        call parse_integer(given(1)%text, value, ok)
        if (.not. ok) call fail(error, 'option '//name//': "'//given(1)%text//'" is not an integer; it must be an '// &
                                'integer from '//integer_text(-huge(value))//' to '//integer_text(huge(value)))
    end subroutine get_long

    !> One text, empty where there is none; of choices one, in whatever case, in their spelling.
    subroutine get_text(self, name, value, error)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name
        character(:), allocatable, intent(out) :: value
        type(error_t), allocatable, intent(inout) :: error

        type(string_t), allocatable :: given(:)

        value = ''
        call look_up(self, name, 1, given, error)
        if (size(given) == 0) return
        value = given(1)%text
        call choose(self, name, value, error)
    end subroutine get_text

    !> A list of different texts, separated by commas in one value; of choices, each one of these.
    subroutine get_list(self, name, value, error)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name
        type(string_t), allocatable, intent(out) :: value(:)
        type(error_t), allocatable, intent(inout) :: error

        type(string_t), allocatable :: given(:)
        integer :: i, k

        allocate (value(0))
        call look_up(self, name, 1, given, error)
        if (size(given) > 0) value = split(given(1)%text, ',')
        do i = 1, size(value)
            call refuse_if(value(i)%text == '', 'option '//name//': an empty name in the list', error)
            call choose(self, name, value(i)%text, error)
            do k = 1, i - 1
                call refuse_if(value(k)%text == value(i)%text, 'option '//name//': "'//value(i)%text// &
                               '" is twice in the list', error)
            end do
        end do
    end subroutine get_list

    !> Makes a text the choice that it means, where the option has choices.
    subroutine choose(self, name, text, error)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name
        character(:), allocatable, intent(inout) :: text
        type(error_t), allocatable, intent(inout) :: error

        character(:), allocatable :: chosen, problem

        if (allocated(error)) return
        associate (choices => self%options(option_position(self, name))%choices)
            if (choices == '') return
            call choice_from_text(text, padded(split_words(choices)), chosen, problem)
        end associate
        call refuse(name, problem, error)
        if (.not. allocated(error)) text = chosen
    end subroutine choose

    !> What is wrong with the value of an option, if anything.
    subroutine refuse(name, problem, error)
        character(*), intent(in) :: name
        character(:), allocatable, intent(in) :: problem    !! Not allocated: nothing
        type(error_t), allocatable, intent(inout) :: error

        if (allocated(problem)) call fail(error, 'option '//name//': '//problem)
    end subroutine refuse

    !> Notes a wrong usage, unless there is an earlier one.
    subroutine refuse_if(condition, message, error)
        logical, intent(in) :: condition            !! The usage is wrong
        character(*), intent(in) :: message         !! Said when the condition holds
        type(error_t), allocatable, intent(inout) :: error

        if (condition .and. .not. allocated(error)) call fail(error, message)
    end subroutine refuse_if

    !> The values given for an option, else its default ones; none where there are neither, and after an earlier failure.
    subroutine look_up(self, name, count, given, error)
        class(arguments_t), intent(in) :: self
        character(*), intent(in) :: name
        integer, intent(in) :: count            !! How many values the caller wants
        type(string_t), allocatable, intent(out) :: given(:)
        type(error_t), allocatable, intent(inout) :: error

        allocate (given(0))
        call refuse_if(.not. self%declares(name), 'option '//name//' is not declared by '//self%command, error)
        if (allocated(error)) return
        associate (option => self%options(option_position(self, name)))
            call refuse_if(option%count /= count, 'option '//name//' is declared with '//integer_text(option%count)// &
                           ' values, not '//integer_text(count), error)
            if (allocated(error)) return
            given = split_words(option%default)
            if (option%given) given = option%values
        end associate
    end subroutine look_up

    !> gracecg simulate CASE --out DIR [OPTIONS]
    function usage_line(self) result(line)
        class(arguments_t), intent(in) :: self
        character(:), allocatable :: line

        integer :: i

        line = trim(self%command//' '//self%positionals)
        do i = 1, size(self%options)
            if (self%options(i)%required) &
                line = line//' '//trim(self%options(i)%name//' '//self%options(i)%placeholder)
        end do
        line = line//' [OPTIONS]'
    end function usage_line

    !> Usage, what the command does, its options and an example. Ends without a line end.
    function help_text(self) result(text)
        class(arguments_t), intent(in) :: self
        character(:), allocatable :: text

        type(string_t), allocatable :: lines(:)
        integer :: i

        text = 'usage: '//usage_line(self)//LF//LF//wrapped(self%summary, 1, HELP_WIDTH)//LF//LF//'options:'
        do i = 1, size(self%options)
            text = text//LF//option_help(self%options(i)%name//' '//self%options(i)%placeholder, &
                                         self%options(i)%help)
        end do
        text = text//LF//option_help('--help', 'shows this text')
        if (self%example == '') return
        text = text//LF//LF//'example:'
        lines = split(self%example, LF)
        do i = 1, size(lines)
            text = text//LF//'  '//lines(i)%text
        end do
    end function help_text

    !> An option and, from HELP_COLUMN on, what it is for; in the next line when the name is long.
    function option_help(name, help) result(text)
        character(*), intent(in) :: name, help
        character(:), allocatable :: text

        text = '  '//trim(name)
        if (len(text) < HELP_COLUMN - 2) then
            text = text//repeat(' ', HELP_COLUMN - 1 - len(text))
        else
            text = text//LF//repeat(' ', HELP_COLUMN - 1)
        end if
        text = text//wrapped(help, HELP_COLUMN, HELP_WIDTH)
    end function option_help
end module gracecg_cli_arguments
