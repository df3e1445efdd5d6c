!> gracecg statements: statements of CSR-TM-00-01 that have neither table nor figure, examined.
module gracecg_cli_statements
    use gracecg_base_kinds, only: i8
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append, integer_text, join
    use gracecg_base_version, only: file_comments
    use gracecg_files_data_table, only: data_table_t
    use gracecg_files_json, only: json_writer_t
    use gracecg_files_value, only: did_you_mean
    use gracecg_files_file, only: check_writable
    use gracecg_studies_statements, only: statement_t, examine_statement, statement_table, &
        STATEMENT_NAMES, VERDICT_WORDS
    use gracecg_cli_arguments, only: arguments_t, MOST_RUNS
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t, add_format_option, take_format
    implicit none
    private
    public :: declare_statements, run_statements, put_statements

    character(*), parameter :: COMMAND = 'statements'
    integer, parameter :: DEFAULT_RUNS = 60

contains

    !> Arguments and help of `gracecg statements`.
    subroutine declare_statements(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe(COMMAND, '[NAME ...]', 0, size(STATEMENT_NAMES), &
                                'Examines statements of CSR-TM-00-01 that have neither table nor figure, and says whether '// &
                                'they hold: one-rod (one rod alone is not enough), dominance (since its torque does '// &
                                'not dominate), arc-length (60 s are the trade-off), weights (the accuracy depends on '// &
                                'them), accuracy (0.02, 0.01, 0.02 mm), curved-force (a small impact), condition (the full '// &
                                'state is not singular), two-steps (two places together), stars (70 in a field, and '// &
                                'the best 20 of them). The verdicts follow from '// &
                                'the covariance analysis; Monte Carlo runs stand beside it. All when none is named.', &
                                'gracecg statements one-rod --runs 10', STATEMENT_NAMES)
        call arguments%add_option('--runs', 'N', 'of every Monte Carlo (default '//integer_text(DEFAULT_RUNS)// &
                                  '); 0: the covariance analysis alone')
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--threads', 'N', 'to work on (default: the processors of the machine)')
        call arguments%add_option('--out', 'FILE', 'CSV file for the numbers')
        call add_format_option(arguments)
    end subroutine declare_statements

    !> The work of `gracecg statements`.
    subroutine run_statements(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(statement_t), allocatable :: statements(:)
        type(string_t), allocatable :: names(:)
        type(results_t) :: results
        type(data_table_t) :: table
        character(:), allocatable :: path
        integer :: i, runs, threads
        integer(i8) :: seed

        call arguments%get('--runs', runs, misuse, default=DEFAULT_RUNS, low=0, high=MOST_RUNS)
        call arguments%get('--seed', seed, misuse, default=1_i8)
        call arguments%get_threads(threads, misuse)
        call arguments%get('--out', path, misuse, default='')
        call take_format(arguments, console, misuse)
        call read_names(arguments, names, misuse)
        if (allocated(misuse)) return
        call check_writable(path, error)
        if (allocated(error)) return
        allocate (statements(size(names)))
        call console%expect_parts(size(names), 'statements')
        do i = 1, size(names)
            call examine_statement(names(i)%text, runs, seed, threads, statements(i), error, console)
            if (allocated(error)) return
            call console%next_part()
            if (i > 1) call console%line('')
            call show(statements(i), console)
        end do
        table = statement_table(statements)
        call results%open(COMMAND)
        call results%member('seed', seed)
        call put_statements(statements, results)
        call results%publish(table, console, error)
        if (allocated(error) .or. path == '') return
        call table%write(path, file_comments(COMMAND, 'seed '//integer_text(seed)//'; 0 runs: theory alone'), error)
    end subroutine run_statements

    !> The statements that are named, or all; refused when one is none of them.
    subroutine read_names(arguments, names, misuse)
        type(arguments_t), intent(in) :: arguments
        type(string_t), allocatable, intent(out) :: names(:)
        type(error_t), allocatable, intent(inout) :: misuse

        integer :: i

        allocate (names(0))
        do i = 1, arguments%positional_count()
            call append(names, arguments%positional(i))
            if (allocated(misuse)) return
            if (.not. any(STATEMENT_NAMES == names(i)%text)) &
                call fail(misuse, 'no statement "'//names(i)%text//'"; there are '//join(STATEMENT_NAMES, ', ')// &
                          did_you_mean(names(i)%text, STATEMENT_NAMES))
        end do
        do i = 1, size(STATEMENT_NAMES)
            if (arguments%positional_count() == 0) call append(names, trim(STATEMENT_NAMES(i)))
        end do
    end subroutine read_names

    !> What the report says, the numbers and the verdict.
    subroutine show(statement, console)
        type(statement_t), intent(in) :: statement
        type(console_t), intent(inout) :: console

        integer :: i

        call console%paragraph(trim(statement%name)//' ('//trim(statement%place)//'): '//trim(statement%claim))
        call console%paragraph('here: '//trim(statement%method))
        if (any(statement%rows%runs > 0)) then
            call console%line('errors of d: RMS of '//integer_text(maxval(statement%rows%runs))//' runs, and theory')
        else if (any([(any(statement%rows(i)%predicted > 0), i=1, size(statement%rows))])) then
            call console%line('errors of d by theory')
        end if
        call console%table(statement_table([statement]))
        call console%paragraph(trim(statement%found)//' '//trim(statement%details))
    end subroutine show

    !> What the report says and what is found, an object each.
    subroutine put_statements(statements, json)
        type(statement_t), intent(in) :: statements(:)
        class(json_writer_t), intent(inout) :: json

        integer :: i

        call json%begin_array('statements')
        do i = 1, size(statements)
            call json%begin()
            call json%member('statement', trim(statements(i)%name))
            call json%member('place', trim(statements(i)%place))
            call json%member('claim', trim(statements(i)%claim))
            call json%member('method', trim(statements(i)%method))
            call json%member('verdict', trim(VERDICT_WORDS(statements(i)%verdict)))
            call json%member('found', trim(statements(i)%found))
            call json%member('details', trim(statements(i)%details))
            call json%end()
        end do
        call json%end()
    end subroutine put_statements
end module gracecg_cli_statements
