!> gracecg statements: statements of CSR-TM-00-01 that have neither table nor figure, examined.
module gracecg_cli_statements
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append, integer_text, join
    use gracecg_files_value, only: did_you_mean
    use gracecg_files_file, only: check_writable
    use gracecg_studies_statements, only: statement_t, examine_statement, write_statements, STATEMENT_NAMES
    use gracecg_cli_arguments, only: arguments_t, MOST_RUNS
    use gracecg_cli_console, only: console_t
    implicit none
    private
    public :: declare_statements, run_statements

    character(*), parameter :: COMMAND = 'statements'
    integer, parameter :: DEFAULT_RUNS = 60

contains

    !> Arguments and help of `gracecg statements`.
    subroutine declare_statements(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe(COMMAND, '[NAME ...]', 0, size(STATEMENT_NAMES), &
                                'Examines statements of CSR-TM-00-01 that have neither table nor figure, and says whether '// &
                                'they hold: one-rod (one rod alone is not enough), arc-length (60 s are the trade-off), '// &
                                'weights (the accuracy depends on them), accuracy (0.02, 0.01, 0.02 mm), condition (the '// &
                                'full state is not singular), two-steps (two places together). The verdicts follow from '// &
                                'the covariance analysis; Monte Carlo runs stand beside it. All when none is named.', &
                                'gracecg statements one-rod --runs 10')
        call arguments%add_option('--runs', 'N', 'of every Monte Carlo (default '//integer_text(DEFAULT_RUNS)// &
                                  '); 0: the covariance analysis alone')
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--threads', 'N', 'to work on (default: the processors of the machine)')
        call arguments%add_option('--out', 'FILE', 'CSV file for the numbers')
    end subroutine declare_statements

    !> The work of `gracecg statements`.
    subroutine run_statements(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(statement_t), allocatable :: statements(:)
        type(string_t), allocatable :: names(:)
        character(:), allocatable :: path
        integer :: i, runs, threads
        integer(i8) :: seed

        call arguments%get('--runs', runs, misuse, default=DEFAULT_RUNS, low=0, high=MOST_RUNS)
        call arguments%get('--seed', seed, misuse, default=1_i8)
        call arguments%get_threads(threads, misuse)
        call arguments%get('--out', path, misuse, default='')
        call read_names(arguments, names, misuse)
        if (allocated(misuse)) return
        call check_writable(path, error)
        if (allocated(error)) return
        allocate (statements(size(names)))
        do i = 1, size(names)
            call examine_statement(names(i)%text, runs, seed, threads, statements(i), error, console)
            if (allocated(error)) return
            if (i > 1) call console%line('')
            call show(statements(i), console)
        end do
        if (path /= '') call write_statements(path, COMMAND, seed, statements, error)
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

        character(100) :: line
        integer :: i, axis

        call say(trim(statement%name)//' ('//trim(statement%place)//'): '//trim(statement%claim))
        call say('here: '//trim(statement%method))
        if (any(statement%rows%condition > 0)) then
            call console%line('case      setting                                  condition')
        else if (any(statement%rows%runs > 0)) then
            call console%line('errors of d, mm: RMS of '//integer_text(maxval(statement%rows%runs))//' runs, and theory')
            call console%line('case      setting                      x here  theory    y here  theory    z here  theory')
        else
            call console%line('errors of d by theory, mm')
            call console%line('case      setting                           x         y         z')
        end if
        do i = 1, size(statement%rows)
            associate (row => statement%rows(i))
                line = row%case_name(:10)//row%setting
                if (row%condition > 0) then
                    write (line(46:), '(es14.3)') row%condition
                else if (row%runs > 0) then
                    write (line(34:), '(3(2f9.4, 2x))') (row%rms(axis)/MILLIMETRE, row%predicted(axis)/MILLIMETRE, axis=1, 3)
                else
                    write (line(34:), '(3f10.4)') row%predicted/MILLIMETRE
                end if
            end associate
            call console%line(trim(line))
        end do
        call say(trim(statement%found))

    contains

        !> A sentence in lines of the console's width.
        subroutine say(text)
            character(*), intent(in) :: text

            integer, parameter :: WIDTH = 98
            integer :: first, last

            first = 1
            do while (len(text) - first + 1 > WIDTH)
                last = first + index(text(first:first + WIDTH), ' ', back=.true.) - 1
                call console%line(text(first:last - 1))
                first = last + 1
            end do
            call console%line(text(first:))
        end subroutine say
    end subroutine show
end module gracecg_cli_statements
