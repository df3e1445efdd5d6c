!> The command line: words, options, typed values, and a message for every wrong usage.
module test_arguments
    use vocabulary
    use gracecg_cli_arguments
    use gracecg_cli_process, only: process_words
    use gracecg_base_text, only: split
    implicit none
    private
    public :: collect_arguments

contains

    subroutine collect_arguments(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('words-and-options', test_words), &
                    new_unittest('equals-sign-and-negative-values', test_equals), &
                    new_unittest('defaults', test_defaults), &
                    new_unittest('lists', test_lists), &
                    new_unittest('double-dash', test_double_dash), &
                    new_unittest('help-and-version', test_help_asked), &
                    new_unittest('wrong-usage', test_wrong_usage), &
                    new_unittest('wrong-values', test_wrong_values), &
                    new_unittest('first-failure', test_first_failure), &
                    new_unittest('help-text', test_help_text), &
                    new_unittest('process-words', test_process)]
    end subroutine collect_arguments

    !> A command with options of every kind, parsed; the words are separated by one blank.
    subroutine parse(line, arguments, failure)
        character(*), intent(in) :: line
        type(arguments_t), intent(out) :: arguments
        type(error_t), allocatable, intent(out) :: failure
        type(string_t), allocatable :: words(:)

        call arguments%describe('try', 'CASE [SECOND]', 1, 2, 'Tries the arguments.', &
                                'gracecg try front-1 --out run')
        call arguments%add_option('--out', 'DIR', 'folder for the results', required=.true.)
        call arguments%add_option('--runs', 'N', 'number of runs')
        call arguments%add_option('--position', 'X Y Z', 'Earth-fixed position, m')
        call arguments%add_option('--step', 'S', 'step, s', default='10')
        call arguments%add_option('--quiet', '', 'shows no progress')
        call arguments%add_option('--cases', 'LIST', 'names of cases, separated by commas', &
                                  choices=[character(7) :: 'front-1', 'back-1'], default='back-1,front-1')
        call arguments%add_option('--shape', 'NAME', 'of the path', choices=[character(5) :: 'runs', 'walks'])
        words = split(line, ' ')
        call arguments%parse(words, failure)
    end subroutine parse

    subroutine test_words(error)
        type(error_type), allocatable, intent(out) :: error
        type(arguments_t) :: arguments
        type(error_t), allocatable :: failure
        character(:), allocatable :: folder
        integer :: runs

        call parse('front-1 --runs 15 --quiet --out run other', arguments, failure)
        call arguments%get('--out', folder, failure)
        call arguments%get('--runs', runs, failure, low=1)
        call check_passes(error, failure)
        call check(error, arguments%positional_count() == 2 .and. &
                   arguments%positional(1) == 'front-1' .and. &
                   arguments%positional(2) == 'other' .and. arguments%positional(3) == '')
        call check(error, folder == 'run' .and. runs == 15 .and. arguments%has('--quiet') .and. &
                   .not. arguments%has('--step') .and. .not. arguments%wants_help)
    end subroutine test_words

    subroutine test_equals(error)
        type(error_type), allocatable, intent(out) :: error
        type(arguments_t) :: arguments
        type(error_t), allocatable :: failure
        character(:), allocatable :: folder
        real(dp) :: position(3), step

        call parse('front-1 --out=a=b --position=-1,2,3e6', arguments, failure)
        call arguments%get('--out', folder, failure)
        call arguments%get('--position', position, failure)
        call check_passes(error, failure)
        call check(error, folder == 'a=b' .and. all(abs(position - [-1.0_dp, 2.0_dp, 3e6_dp]) <= 0))
        call parse('-1 --position -1 -.5 -3e6 --out - --step -2', arguments, failure)
        call arguments%get('--position', position, failure)
        call arguments%get('--step', step, failure)
        call check_passes(error, failure)
        call check(error, all(abs(position - [-1.0_dp, -0.5_dp, -3e6_dp]) <= 0) .and. &
                   abs(step + 2) <= 0 .and. arguments%positional(1) == '-1')
    end subroutine test_equals

    subroutine test_defaults(error)
        type(error_type), allocatable, intent(out) :: error
        type(arguments_t) :: arguments
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: cases(:)
        character(:), allocatable :: text
        real(dp) :: step, position(3)
        integer :: runs

        call parse('front-1 --out run', arguments, failure)
        step = 1
        runs = 15
        position = 3
        call arguments%get('--step', step, failure)
        call arguments%get('--runs', runs, failure)
        call arguments%get('--position', position, failure)
        call arguments%get('--cases', cases, failure)
        call arguments%get('--shape', text, failure)
        call check_passes(error, failure)
        call check(error, abs(step - 10) <= 0 .and. runs == 15 .and. &
                   abs(position(3) - 3) <= 0 .and. &
                   size(cases) == 2 .and. text == '')
    end subroutine test_defaults

    subroutine test_lists(error)
        type(error_type), allocatable, intent(out) :: error
        type(arguments_t) :: arguments
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: cases(:)

        call parse('x --out run --cases Back-1,front-1', arguments, failure)
        call arguments%get('--cases', cases, failure)
        call check_passes(error, failure)
        call check(error, cases(1)%text//'|'//cases(2)%text, 'back-1|front-1')
        call parse('x --out run --cases front-1,fromt-1', arguments, failure)
        call arguments%get('--cases', cases, failure)
        call check_fails(error, failure, '--cases ... "fromt-1" ... front-1, back-1 ... did you mean "front-1"')
        call parse('x --out run --cases front-1,', arguments, failure)
        call arguments%get('--cases', cases, failure)
        call check_fails(error, failure, '--cases ... empty name')
    end subroutine test_lists

    subroutine test_double_dash(error)
        type(error_type), allocatable, intent(out) :: error
        type(arguments_t) :: arguments
        type(error_t), allocatable :: failure

        call parse('--out run -- --quiet --help', arguments, failure)
        call check_passes(error, failure)
        call check(error, arguments%positional(1) == '--quiet' .and. &
                   arguments%positional(2) == '--help' .and. &
                   .not. arguments%has('--quiet') .and. .not. arguments%wants_help)
    end subroutine test_double_dash

    subroutine test_help_asked(error)
        type(error_type), allocatable, intent(out) :: error
        type(arguments_t) :: arguments
        type(error_t), allocatable :: failure

        call parse('--unknown --help', arguments, failure)
        if (unmet(error, arguments%wants_help .and. .not. allocated(failure))) return
        call parse('-h', arguments, failure)
        if (unmet(error, arguments%wants_help .and. .not. allocated(failure))) return
        call parse('--version', arguments, failure)
        call check(error, arguments%wants_version .and. .not. allocated(failure))
    end subroutine test_help_asked

    subroutine test_wrong_usage(error)
        type(error_type), allocatable, intent(out) :: error

        call refused('front-1 --out run --rusn 3', &
                     'unknown option --rusn ... did you mean "--runs"? ... usage: gracecg try CASE [SECOND] --out DIR ... '// &
                     'gracecg try --help')
        call refused('front-1 --out run -x', 'unknown option -x')
        call refused('front-1 --out', '--out takes 1 value: DIR ... found 0')
        call refused('front-1 --out --quiet', '--out takes 1 value: DIR ... found 0')
        call refused('front-1 --out=', 'option --out: the value DIR is empty')
        call refused('front-1 --out run --position 1 2', '--position takes 3 values: X Y Z ... found 2')
        call refused('front-1 --out run --position=1,2,3,4', 'takes 3 values ... found 4')
        call refused('front-1 --out run --quiet=yes', '--quiet takes no value')
        call refused('front-1 --out run --out run', '--out is given twice')
        call refused('front-1', '--out DIR is required')
        call refused('--out run', 'an argument is missing: CASE')
        call refused('a b c --out run', 'unexpected argument "c"')

    contains

        subroutine refused(line, parts)
            character(*), intent(in) :: line, parts
            type(arguments_t) :: arguments
            type(error_t), allocatable :: failure

            call parse(line, arguments, failure)
            call check_fails(error, failure, parts)
        end subroutine refused
    end subroutine test_wrong_usage

    subroutine test_wrong_values(error)
        type(error_type), allocatable, intent(out) :: error
        type(arguments_t) :: arguments
        type(error_t), allocatable :: failure
        character(:), allocatable :: text
        real(dp) :: step, position(3)
        integer :: runs

        call parse('x --out run --step nan --runs 1.5 --position 1 2 3x --shape run', arguments, failure)
        call arguments%get('--step', step, failure, low=0.1_dp, high=60.0_dp, unit='s')
        call check_fails(error, failure, '--step ... "nan" ... from 0.1 to 60 s')
        call arguments%get('--runs', runs, failure, low=1)
        call check_fails(error, failure, '--runs ... "1.5" ... an integer of at least 1')
        call arguments%get('--position', position, failure, unit='m')
        call check_fails(error, failure, '--position ... "3x" ... in m')
        call arguments%get('--shape', text, failure)
        call check_fails(error, failure, '--shape ... one of runs, walks ... did you mean "runs"')
        call arguments%get('--step', step, failure)
        call check_fails(error, failure, 'step')
        call arguments%get('--undeclared', text, failure)
        call check_fails(error, failure, '--undeclared is not declared')
        call arguments%get('--position', step, failure)
        call check_fails(error, failure, '--position is declared with 3 values, not 1')
        call parse('x --out run --step 61', arguments, failure)
        call arguments%get('--step', step, failure, high=60.0_dp)
        call check_fails(error, failure, '--step ... 61 is outside ... at most 60')
    end subroutine test_wrong_values

    !> The first failure stays: the next values stay as they are, and nothing is looked up for them.
    subroutine test_first_failure(error)
        type(error_type), allocatable, intent(out) :: error
        type(arguments_t) :: arguments
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: cases(:)
        character(:), allocatable :: text
        real(dp) :: step
        integer :: runs, threads

        call parse('x --out run --runs many --step wide', arguments, failure)
        step = 10
        call arguments%get('--runs', runs, failure)
        call arguments%get('--step', step, failure)
        call arguments%get('--cases', cases, failure)
        call arguments%get('--undeclared', text, failure)
        call arguments%get_threads(threads, failure)
        call refuse_if(.true., 'a later one', failure)
        call check(error, index(message_of(failure), 'step') + index(message_of(failure), 'later'), 0)
        call check_fails(error, failure, '--runs ... "many"')
        call check(error, size(cases) == 0 .and. text == '' .and. abs(step - 10) <= 0)
        call refuse_if(.false., 'nothing wrong', failure)
        if (.not. allocated(failure)) call refuse_if(.true., 'wrong', failure)
        call check_fails(error, failure, 'wrong')
    end subroutine test_first_failure

    subroutine test_help_text(error)
        type(error_type), allocatable, intent(out) :: error
        type(arguments_t) :: arguments
        character(*), parameter :: LF = new_line('a')

        call arguments%describe('try', 'CASE', 1, 1, 'Tries.', 'gracecg try a'//LF//'gracecg try b')
        call arguments%add_option('--out', 'DIR', repeat('word ', 20), required=.true.)
        call arguments%add_option('--a-rather-long-name', 'X Y Z', 'three values')
        call check(error, arguments%help_text(), &
                   'usage: gracecg try CASE --out DIR [OPTIONS]'//LF//LF// &
                   'Tries.'//LF//LF// &
                   'options:'//LF// &
                   '  --out DIR              '//repeat('word ', 14)//'word'//LF// &
                   repeat(' ', 25)//repeat('word ', 4)//'word'//LF// &
                   '  --a-rather-long-name X Y Z'//LF// &
                   repeat(' ', 25)//'three values'//LF// &
                   '  --help                 shows this text'//LF//LF// &
                   'example:'//LF//'  gracecg try a'//LF//'  gracecg try b')
    end subroutine test_help_text

    !> The tester itself was called with some words, or none.
    subroutine test_process(error)
        type(error_type), allocatable, intent(out) :: error
        type(string_t), allocatable :: words(:)
        character(200) :: last

        words = process_words(1)
        call check(error, size(words), command_argument_count())
        call check(error, size(process_words(command_argument_count() + 2)), 0)
        if (allocated(error) .or. size(words) == 0) return
        call get_command_argument(size(words), last)
        call check(error, words(size(words))%text, trim(last))
    end subroutine test_process
end module test_arguments
