!> CSV files: one corrupted file for each failure, and exact round trips.
module test_csv
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_positive_inf
    use vocabulary
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_files_table, only: read_csv, table_file_t
    use gracecg_files_file, only: file_exists, remove_file, text_file_t, read_text_file
    implicit none
    private
    public :: collect_csv

    character(*), parameter :: LF = achar(10), CR = achar(13), PATH = FOLDER//'table.csv'
    character(6), parameter :: COLUMNS(3) = [character(6) :: 'time_s', 'ax', 'ay']

contains

    subroutine collect_csv(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('read', test_read), &
                    new_unittest('refused', test_refused), &
                    new_unittest('round-trip-is-exact', test_round_trip), &
                    new_unittest('quotes', test_quotes), &
                    new_unittest('writer-refuses', test_writer_refuses)]
    end subroutine collect_csv

    !> Reads a file with the given content.
    subroutine read_table(content, table, failure, comments)
        character(*), intent(in) :: content
        real(dp), allocatable, intent(out) :: table(:, :)
        type(error_t), allocatable, intent(out) :: failure
        type(string_t), allocatable, intent(out), optional :: comments(:)
        type(table_file_t) :: file
        type(error_t), allocatable :: other

        call make_file('table.csv', content)
        call read_csv(PATH, COLUMNS, table, failure)
        if (present(comments)) call read_csv(PATH, COLUMNS, file, other)
        if (present(comments)) comments = file%comments
        call remove_file(PATH)
    end subroutine read_table

    !> The content must be refused with all of the parts in the message.
    subroutine check_refused(error, content, parts)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: content, parts
        real(dp), allocatable :: table(:, :)
        type(error_t), allocatable :: failure

        call read_table(content, table, failure)
        call check_fails(error, failure, PATH//' ... '//parts)
    end subroutine check_refused

    subroutine test_read(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), allocatable :: table(:, :)
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: comments(:)

        call read_table('# seed 1'//LF//'#'//LF//'time_s,ax,ay'//LF//'0,1e-9,-2.5D-3'// &
                          LF//'0.1, 3 ,4'//LF//LF//'  '//LF, table, failure, comments)
        call check_passes(error, failure)
        call check(error, all(shape(table) == [2, 3]) .and. &
                   all(abs(table(1, :) - [0.0_dp, 1e-9_dp, -2.5e-3_dp]) <= 0) .and. &
                   all(abs(table(2, :) - [0.1_dp, 3.0_dp, 4.0_dp]) <= 0))
        call check(error, size(comments) == 2 .and. comments(1)%text == 'seed 1' .and. &
                   comments(2)%text == '')
        call read_table('time_s,ax,ay'//CR//LF//'1,2,3'//CR//LF//'4,5,6', table, failure)
        call check_passes(error, failure)
        call check(error, all(abs(table(:, 3) - [3.0_dp, 6.0_dp]) <= 0))
    end subroutine test_read

    subroutine test_refused(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: BEGIN = 'time_s,ax,ay'//LF//'1,2,3'//LF
        character(8), parameter :: BAD(*) = [character(8) :: 'NaN', '-inf', '1.2.3', 'abc', &
                                             '1e999', '', '1 2']
        integer :: i
        real(dp), allocatable :: table(:, :)
        type(error_t), allocatable :: failure

        call check_refused(error, '# x'//LF//'time_s,ay,ax'//LF//'1,2,3'//LF, &
                           ':2: ... column 2 is "ay", expected "ax" ... time_s,ax,ay ... | time_s,ay,ax')
        call check_refused(error, 'time_s,ax'//LF//'1,2'//LF, ':1: ... 2 columns, expected 3')
        call check_refused(error, 'time_s,ax,ay,az'//LF//'1,2,3,4'//LF, ':1: ... 4 columns, expected 3')
        call check_refused(error, '1,2,3'//LF, ':1: ... column 1 is "1"')
        call check_refused(error, BEGIN//'4,5', ':3: ... 2 columns, expected 3 ... | 4,5')
        call check_refused(error, BEGIN//'4,5,6,7'//LF, ':3: ... 4 columns, expected 3')
        call check_refused(error, BEGIN//'4,5,'//LF, ':3: ... column ay: ""')
        do i = 1, size(BAD)
            call check_refused(error, 'time_s,ax,ay'//LF//'1,2,3'//LF//'4,'//trim(BAD(i))//',6'// LF, &
                               ':3: ... column ax: "'//trim(BAD(i))//'" ... not a finite number')
        end do
        call check_refused(error, '', 'is empty ... time_s,ax,ay')
        call check_refused(error, '# only'//LF//'# comments'//LF//LF, 'is empty')
        call check_refused(error, 'time_s,ax,ay'//LF, 'no row')
        call read_csv(FOLDER//'missing.csv', COLUMNS, table, failure)
        call check_fails(error, failure, FOLDER//'missing.csv ... no such file')
        call check_refused(error, 'time_s,ax,ay'//LF//'1,2,3'//LF//LF//'4,5,6'//LF, ':3: ... 1 columns, expected 3')
    end subroutine test_refused

    subroutine test_round_trip(error)
        type(error_type), allocatable, intent(out) :: error
        type(csv_writer_t) :: writer
        type(error_t), allocatable :: failure, other
        type(table_file_t) :: read_back
        type(text_file_t) :: file
        type(string_t), allocatable :: comments(:)
        real(dp), allocatable :: table(:, :)
        real(dp) :: rows(50, 3)
        integer :: i

        do i = 1, size(rows, 1)
            rows(i, :) = [0.1_dp*i, sin(1.0_dp*i)*10.0_dp**(-i), -exp(13.7_dp*i)]
        end do
        rows(1, :) = [tiny(1.0_dp), huge(1.0_dp), 0.0_dp]
        call writer%open(PATH, 'time_s,ax,ay', [character(8) :: 'seed 1', 'two'], failure)
        do i = 1, size(rows, 1)
            call writer%row(rows(i, :))
        end do
        call check(error, .not. file_exists(PATH))
        call writer%commit(failure)
        if (allocated(error)) return
        call check_passes(error, failure)
        call check(error, file_exists(PATH//'.meta.json'))
        call read_csv(PATH, COLUMNS, table, failure)
        call read_csv(PATH, COLUMNS, read_back, other)
        comments = read_back%comments
        call read_text_file(PATH, file, failure)
        call check_passes(error, failure)
        call check(error, all(abs(table - rows) <= 0) .and. comments(2)%text == 'two')
        call check(error, index(file%text, ' ') == 0 .and. file%line(1) == 'time_s,ax,ay', 'the header comes first')
        call writer%open(PATH, 'time_s,ax,ay', [character(1) ::], failure)      ! what told of it is of the past
        call writer%commit(failure)
        call remove_file(PATH)
        call check(error, .not. file_exists(PATH//'.meta.json'))
    end subroutine test_round_trip

    !> Fields with a comma or a quote are quoted, and read back as they were.
    subroutine test_quotes(error)
        type(error_type), allocatable, intent(out) :: error
        type(csv_writer_t) :: writer
        type(table_file_t) :: rows
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: fields(:)

        call writer%open(PATH, 'case,said,runs', [character(1) ::], failure)
        call writer%fields([string_t('a, b'), string_t('he said "x"'), string_t('15')])
        call writer%fields([string_t('"'), string_t(''), string_t(',')])
        call writer%commit(failure)
        if (failed(error, failure)) return
        call read_csv(PATH, [character(4) :: 'case', 'said', 'runs'], rows, failure)
        call remove_file(PATH)
        call check(error, rows%text%line(2), '"a, b","he said ""x""",15')
        fields = rows%fields(1)
        call check(error, fields(1)%text == 'a, b' .and. fields(2)%text == 'he said "x"' .and. fields(3)%text == '15')
        fields = rows%fields(2)
        call check(error, fields(1)%text == '"' .and. fields(2)%text == '' .and. fields(3)%text == ',')
    end subroutine test_quotes

    subroutine test_writer_refuses(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: infinity

        infinity = ieee_value(infinity, ieee_positive_inf)
        call check_row_refused(error, [1.0_dp, nan, nan], 'row 2 ... column ax ... NaN')
        call check_row_refused(error, [1.0_dp, 2.0_dp, infinity], 'row 2 ... column ay ... Inf')
        call check_row_refused(error, [1.0_dp, 2.0_dp], 'row 2 ... 2 values, expected 3')
    end subroutine test_writer_refuses

    !> A bad row after a good one: the failure comes at commit, and there is no file.
    subroutine check_row_refused(error, row, parts)
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in) :: row(:)
        character(*), intent(in) :: parts
        type(csv_writer_t) :: writer
        type(error_t), allocatable :: failure

        call writer%open(PATH, 'time_s,ax,ay', [character(1) ::], failure)
        call writer%row([1.0_dp, 2.0_dp, 3.0_dp])
        call writer%row(row)
        call writer%row([1.0_dp, 2.0_dp, 3.0_dp])
        call writer%commit(failure)
        call check_fails(error, failure, PATH//' ... '//parts)
        call check(error, .not. (file_exists(PATH) .or. file_exists(PATH//'.part1')))
    end subroutine check_row_refused
end module test_csv
