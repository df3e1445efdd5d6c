!> gracecg statements: statements of CSR-TM-00-01 that have neither table nor figure, examined.
module gracecg_cli_statements
    use gracecg_files_json, only: json_writer_t
    use gracecg_base_text, only: split_words
    use gracecg_files_value, only: did_you_mean
    use gracecg_studies_statements, only: statement_t, examine_statement, statement_table, &
        STATEMENT_NAMES, VERDICT_WORDS
    use gracecg_cli_work
    implicit none
    private
    public :: declare_statements, run_statements, put_statements

    character(*), parameter :: COMMAND = 'statements'

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
                                'gracecg statements one-rod --runs 10')
        call arguments%add_option('--runs', 'N', 'of every Monte Carlo; 0: the covariance analysis alone', default='60')
        call add_study_options(arguments, '--seed --threads --out --format')
    end subroutine declare_statements

    !> The work of `gracecg statements`.
    subroutine run_statements(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(statement_t), allocatable :: statements(:)
        type(string_t), allocatable :: names(:)
        type(results_t) :: results
        type(study_t) :: study
        integer :: i

        call take_options(arguments, console, study, misuse, 0)
        names = arguments%words
        if (size(names) == 0) names = split_words(join(STATEMENT_NAMES, ' '))
        do i = 1, size(names)
            call refuse_if(all(STATEMENT_NAMES /= names(i)%text), 'no statement "'//names(i)%text//'"; there are '// &
                           join(STATEMENT_NAMES, ', ')//did_you_mean(names(i)%text, STATEMENT_NAMES), misuse)
        end do
        if (allocated(misuse)) return
        call check_writable(study%path, error)
        if (allocated(error)) return
        allocate (statements(size(names)))
        call console%expect_parts(size(names), 'statements')
        do i = 1, size(names)
            call examine_statement(names(i)%text, study%runs, study%seed, study%threads, statements(i), error, console)
            if (allocated(error)) return
            call console%next_part()
            if (i > 1) call console%line('')
            call show(statements(i), console)
        end do
        call results%open(COMMAND)
        call results%member('seed', study%seed)
        call put_statements(statements, results)
        call results%publish(statement_table(statements), console, error, study%path, 'seed '//integer_text(study%seed)//'; 0 '// &
                             'runs: theory alone')
    end subroutine run_statements

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
