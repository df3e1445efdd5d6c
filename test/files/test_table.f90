!> Text tables of fields: what counts as a row, and messages with the line of the file.
module test_table
    use vocabulary
    use gracecg_files_table
    use gracecg_base_text, only: split_words
    implicit none
    private
    public :: collect_table

    character(*), parameter :: LF = achar(10), TAB = achar(9)

contains

    subroutine collect_table(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('rows-and-fields', test_rows), &
                    new_unittest('wrong-rows', test_wrong_rows), &
                    new_unittest('unused-fields-are-numbers', test_unused), &
                    new_unittest('no-rows', test_no_rows), &
                    new_unittest('long-quoted-field', test_long_field)]
    end subroutine collect_table

    !> A file with two rows, in its lines 3 and 5.
    subroutine read_sample(file)
        type(table_file_t), intent(out) :: file
        type(error_t), allocatable :: failure

        call make_file('fields.txt', '# head'//LF//'  '//LF//' 1'//TAB//'-2.5e3 # note'// &
                       LF//TAB//'#'//LF//'three 4 5#6')
        call read_table(FOLDER//'fields.txt', file, failure)
        call need(failure)
    end subroutine read_sample

    subroutine test_rows(error)
        type(error_type), allocatable, intent(out) :: error
        type(table_file_t) :: file
        type(string_t), allocatable :: fields(:)
        type(error_t), allocatable :: failure
        real(dp) :: value

        call read_sample(file)
        call check(error, file%row_count(), 2)
        if (unmet(error, size(file%fields(0)) + size(file%fields(3)), 0)) return
        call file%get_fields(1, 2, 'a, b', fields, failure)
        if (failed(error, failure)) return
        call file%get_real(1, fields(2), 'b', value, failure, -2500.0_dp, 0.0_dp)
        call check_passes(error, failure)
        call check(error, value, -2500.0_dp)
        call file%get_fields(2, 3, 'a, b, c', fields, failure)
        call check_passes(error, failure)
        call check(error, fields(1)%text//'|'//fields(2)%text//'|'//fields(3)%text, 'three|4|5')
    end subroutine test_rows

    subroutine test_wrong_rows(error)
        type(error_type), allocatable, intent(out) :: error
        type(table_file_t) :: file
        type(string_t), allocatable :: fields(:)
        type(error_t), allocatable :: failure
        real(dp) :: value
        integer :: n

        call read_sample(file)
        call file%get_fields(1, 3, 'a, b, c', fields, failure)
        call check_says(error, message_of(failure), 'fields.txt:3: ... has 2 columns, expected 3: a, b, c ... |  1')
        if (unmet(error, size(fields) == 3 .and. len(fields(3)%text) == 0, 'fields after a failure')) return
        call file%get_real(1, string_t('x'), 'length', value, failure)
        call check_fails(error, failure, 'has 2 columns')     ! the first failure stays
        fields = file%fields(2)
        call file%get_real(2, fields(1), 'length', value, failure, unit='m')
        call check_fails(error, failure, 'fields.txt:5: ... length: "three" is not ... in m ... | three 4')
        call file%get_real(2, fields(2), 'length', value, failure, 0.0_dp, 3.0_dp)
        call check_fails(error, failure, 'fields.txt:5: ... 4 is outside ... from 0 to 3')
        call file%get_integer(2, fields(2), 'count', n, failure, 4, 4)
        if (unmet(error, n == 4 .and. .not. allocated(failure))) return
        call file%get_integer(2, fields(2), 'count', n, failure, 5)
        call check_fails(error, failure, 'fields.txt:5: ... count: 4 is outside ... at least 5')
        call file%fail_at(3, 'a row is missing', failure)
        call check_fails(error, failure, 'fields.txt:6: a row is missing')
    end subroutine test_wrong_rows

    !> What nobody uses must be a number, or the sign of none where that is allowed.
    subroutine test_unused(error)
        type(error_type), allocatable, intent(out) :: error
        character(6), parameter :: BAD(*) = [character(6) :: 'inf', 'nan', '--1', '12abc', '1.2.3', '1e', 'T', &
                                             '-', '1e999']
        type(table_file_t) :: file
        type(string_t), allocatable :: fields(:)
        type(error_t), allocatable :: failure
        integer :: i

        call read_sample(file)
        fields = split_words('1 -2.5d3 +.5')    ! an array constructor of these breaks gfortran 13
        call file%check_numbers(1, fields, 2, failure)
        if (failed(error, failure)) return
        fields = split_words('- 1')
        call file%check_numbers(1, fields, 2, failure, or_nothing=.true.)
        call check_passes(error, failure)
        do i = 1, size(BAD)
            fields = split_words('1 '//BAD(i))
            call file%check_numbers(1, fields, 2, failure)
            call check_fails(error, failure, 'fields.txt:3: column 3: "'//trim(BAD(i))//'" is not a finite number ... |  1')
        end do
    end subroutine test_unused

    subroutine test_no_rows(error)
        type(error_type), allocatable, intent(out) :: error
        type(table_file_t) :: file
        type(error_t), allocatable :: failure

        call read_table(FOLDER//'missing.txt', file, failure)
        call check_fails(error, failure, 'missing.txt: no such file')
        call make_file('fields.txt', '# only'//LF//LF)
        call read_table(FOLDER//'fields.txt', file, failure)
        call check_fails(error, failure, 'fields.txt: holds no data')
    end subroutine test_no_rows

    !> A field of 2 MB in quotes is read in linear time, with its quotes and commas.
    subroutine test_long_field(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 700000
        type(table_file_t) :: file
        type(string_t), allocatable :: fields(:)
        type(error_t), allocatable :: failure
        real(dp) :: before, after         ! Of the processor, which others may use, too

        call make_file('quoted.csv', 'a,b,c'//LF//'1,"'//repeat('"",', N)//'",3'//LF)
        call read_csv(FOLDER//'quoted.csv', ['a', 'b', 'c'], file, failure)
        if (failed(error, failure)) return
        call cpu_time(before)
        call file%get_fields(1, 3, 'a, b, c', fields, failure)
        call cpu_time(after)
        if (failed(error, failure)) return
        call check(error, fields(1)%text == '1' .and. fields(2)%text == repeat('",', N) .and. fields(3)%text == '3', 'fields')
        call check(error, after - before < 100, 'a long field takes too long')
    end subroutine test_long_field
end module test_table
