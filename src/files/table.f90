!> Tables in text files: rows of fields between blanks or tabs, or, in a CSV file, between commas.
!>
!> Whatever reads a table takes its rows, fields and numbers from here, so that a number is always a
!> finite one that fills its field, and every failure names file and line and shows the line. What takes a row apart does
!> nothing when `error` is set already: so a row is read first and the error asked for once, behind it.
module gracecg_files_table
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, fail_in_file
    use gracecg_base_text, only: string_t, split, split_words, integer_text, join, parse_real
    use gracecg_files_file, only: text_file_t, read_text_file
    use gracecg_files_value, only: real_from_text, integer_from_text
    use gracecg_files_json, only: read_json_list
    use gracecg_files_csv, only: SIDE_ENDING, SIDE_COMMENTS
    implicit none
    private
    public :: table_file_t, read_table, read_csv, csv_of_text

    character(*), parameter :: BLANKS = ' '//achar(9)
    character(1), parameter :: COMMA = ',', COMMENT = '#', NOTHING = '-', QUOTE = '"'

    type :: table_file_t
        !! A text and which of its lines are rows, counted from 1
        type(text_file_t) :: text                       !! The whole file
        integer, allocatable :: line(:)                 !! Line number of each row
        type(string_t), allocatable :: comments(:)
        !! Of a CSV file: those of FILE.meta.json or its first lines, without the #
        logical, private :: is_csv = .false.
        integer, private :: header = 0                  !! Number of the line with the columns' names
    contains
        procedure :: row_count                  !! How many rows there are
        procedure :: fields => fields_of_row    !! The fields of a row
        procedure :: get_fields                 !! The same, of a row that must have so many
        procedure :: get_real                   !! A number out of a field
        procedure :: get_integer                !! An integer out of a field
        procedure :: check_numbers              !! Are fields that nobody uses numbers?
        procedure :: get_numbers                !! All fields of all rows as numbers
        procedure :: fail_at                    !! A failure at a row
    end type table_file_t

    !> Reads a CSV file: its rows, or all of it as numbers
    interface read_csv
        module procedure read_csv_rows, read_csv_numbers
    end interface read_csv

contains

    !> Reads a table with fields between blanks or tabs. `#` begins a comment; lines that hold nothing
    !> else are passed over. Fails when the file cannot be read or has no row.
    subroutine read_table(path, file, error)
        character(*), intent(in) :: path    !! Of the file
        type(table_file_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        call read_text_file(path, file%text, error)
        if (allocated(error)) return
        file%line = pack([(i, i=1, file%text%line_count())], &
                         [(has_fields(file%text, i), i=1, file%text%line_count())])
        if (file%row_count() == 0) &
            call fail(error, file%text%name//': holds no data (only blank lines and comments)')
    end subroutine read_table

    pure logical function has_fields(text, line_number)
        type(text_file_t), intent(in) :: text
        integer, intent(in) :: line_number

        integer :: i

        i = text%first(line_number) - 1 + verify(text%text(text%first(line_number):text%last(line_number)), BLANKS)
        has_fields = i >= text%first(line_number)
        if (has_fields) has_fields = text%text(i:i) /= COMMENT
    end function has_fields

    !> Reads a CSV file: the line of the columns' names, which must be `columns`, and the rows. Lines above that begin
    !> with # are comments. Fails when the header differs or, where rows are needed, there is none. Lines may end as on
    !> Windows; blank lines are allowed at the end.
    subroutine read_csv_rows(path, columns, file, error)
        character(*), intent(in) :: path        !! Of the file
        character(*), intent(in) :: columns(:)  !! Names in the header, in their order
        type(table_file_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: text

        call read_text_file(path, text, error)
        if (.not. allocated(error)) call csv_of_text(text, columns, file, error)
    end subroutine read_csv_rows

    !> The same of a text in memory.
    subroutine csv_of_text(text, columns, file, error, rows_needed)
        type(text_file_t), intent(in) :: text
        character(*), intent(in) :: columns(:)  !! Names in the header, in their order
        type(table_file_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: rows_needed    !! True when absent

        integer :: header, last, i
        logical :: needed

        file%is_csv = .true.
        file%text = text
        header = 1
        do while (index(file%text%line(header), COMMENT) == 1)
            header = header + 1
        end do
        do last = file%text%line_count(), 1, -1
            if (file%text%line(last) /= '') exit
        end do
        file%header = header
        call find_comments(file)
        file%line = [(i, i=header + 1, last)]
        if (last < header) then
            call fail_in_file(error, file%text%name, 0, 'the file is empty; expected a line with '// &
                              'the columns '//join(columns, ','))
            return
        end if
        call check_header(file%text, header, columns, error)
        needed = .true.
        if (present(rows_needed)) needed = rows_needed
        if (.not. allocated(error) .and. needed .and. last == header) &
            call fail_in_file(error, file%text%name, 0, 'the file has no row below its header')
    end subroutine csv_of_text

    !> The comments above the header; where there are none, those of FILE.meta.json.
    subroutine find_comments(file)
        type(table_file_t), intent(inout) :: file

        type(text_file_t) :: side
        type(error_t), allocatable :: error
        logical :: ok
        integer :: i

        allocate (file%comments(file%header - 1))
        do i = 1, size(file%comments)
            file%comments(i)%text = trim(adjustl(file%text%text(file%text%first(i) + 1:file%text%last(i))))
        end do
        if (file%header > 1) return
        call read_text_file(file%text%name//SIDE_ENDING, side, error)
        if (.not. allocated(error)) call read_json_list(side%text, SIDE_COMMENTS, file%comments, ok)
    end subroutine find_comments

    !> All numbers of a CSV file. Fails as `read_csv_rows` and `get_numbers`.
    subroutine read_csv_numbers(path, columns, numbers, error)
        character(*), intent(in) :: path                                    !! Of the file
        character(*), intent(in) :: columns(:)                              !! Names in the header
        real(dp), allocatable, intent(out) :: numbers(:, :)                 !! (row, column)
        type(error_t), allocatable, intent(out) :: error

        type(table_file_t) :: file

        call read_csv_rows(path, columns, file, error)
        call file%get_numbers(columns, numbers, error)
    end subroutine read_csv_numbers

    subroutine check_header(text, line_number, columns, error)
        type(text_file_t), intent(in) :: text
        integer, intent(in) :: line_number
        character(*), intent(in) :: columns(:)
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: found(:)
        character(:), allocatable :: problem
        integer :: i

        allocate (found, source=split(text%line(line_number), COMMA))
        do i = 1, min(size(found), size(columns))
            if (trim(adjustl(found(i)%text)) == columns(i)) cycle
            problem = 'column '//integer_text(i)//' is "'//trim(adjustl(found(i)%text))// &
                      '", expected "'//trim(columns(i))//'"'
            exit
        end do
        if (.not. allocated(problem)) then
            if (size(found) == size(columns)) return
            problem = integer_text(size(found))//' columns, expected '//integer_text(size(columns))
        end if
        call text%fail_at(line_number, problem//'; the columns must be '//join(columns, ','), error)
    end subroutine check_header

    pure integer function row_count(self)
        class(table_file_t), intent(in) :: self

        row_count = size(self%line)
    end function row_count

    !> The fields of a row; none for a number that no row has.
    pure function fields_of_row(self, row) result(fields)
        class(table_file_t), intent(in) :: self
        integer, intent(in) :: row  !! Number of the row, from 1
        type(string_t), allocatable :: fields(:)

        character(:), allocatable :: line

        line = self%text%line(line_of_row(self, row))
        if (row < 1 .or. row > self%row_count()) then
            allocate (fields(0))
        else if (self%is_csv) then
            fields = split_csv(line)
        else
            fields = split_words(line(:index(line//COMMENT, COMMENT) - 1))
        end if
    end function fields_of_row

    !> The fields of a line of CSV; one in quotes may hold commas, and quotes doubled.
    pure function split_csv(line) result(fields)
        character(*), intent(in) :: line
        type(string_t), allocatable :: fields(:)

        character(:), allocatable :: field
        logical :: within
        integer :: i, n, length

        fields = split(line, COMMA)     ! with quotes there may be fewer
        if (index(line, QUOTE) == 0) return
        allocate (character(len(line)) :: field)
        within = .false.
        n = 0
        length = 0
        i = 1
        do while (i <= len(line))
            if (line(i:i) == COMMA .and. .not. within) then
                n = n + 1
                fields(n)%text = field(:length)
                length = 0
            else if (line(i:i) == QUOTE .and. .not. (within .and. line(i + 1:min(i + 1, len(line))) == QUOTE)) then
                within = .not. within
            else
                length = length + 1
                field(length:length) = line(i:i)
                if (line(i:i) == QUOTE) i = i + 1       ! the second of two
            end if
            i = i + 1
        end do
        n = n + 1
        fields(n)%text = field(:length)
        fields = fields(:n)
    end function split_csv

    !> The line number of a row; that behind the last line for a row that is missing.
    pure integer function line_of_row(file, row) result(line_number)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: row

        line_number = file%text%line_count() + 1
        if (row >= 1 .and. row <= file%row_count()) line_number = file%line(row)
    end function line_of_row

    !> The fields of a row that must have as many as `columns` says.
    subroutine get_fields(self, row, columns, meaning, fields, error)
        class(table_file_t), intent(in) :: self
        integer, intent(in) :: row              !! Number of the row, from 1
        integer, intent(in) :: columns          !! How many fields it must have
        character(*), intent(in) :: meaning     !! What the columns are, for the message
        type(string_t), allocatable, intent(out) :: fields(:)  !! After a failure as many, empty
        type(error_t), allocatable, intent(inout) :: error

        integer :: i

        if (.not. allocated(error)) then
            fields = self%fields(row)
            if (size(fields) == columns) return
            call self%fail_at(row, 'has '//integer_text(size(fields))//' columns, expected '// &
                              integer_text(columns)//': '//meaning, error)
            deallocate (fields)
        end if
        allocate (fields(columns))
        do i = 1, columns
            fields(i)%text = ''
        end do
    end subroutine get_fields

    !> The number in a field of a row: finite and, with limits, within them (both ends included).
    subroutine get_real(self, row, field, name, value, error, low, high, unit)
        class(table_file_t), intent(in) :: self
        integer, intent(in) :: row              !! Number of the row, from 1
        type(string_t), intent(in) :: field
        character(*), intent(in) :: name        !! Of the quantity, for the message
        real(dp), intent(out) :: value          !! In the file's unit
        type(error_t), allocatable, intent(inout) :: error
        real(dp), intent(in), optional :: low, high !! Allowed range, in the file's unit
        character(*), intent(in), optional :: unit  !! Of the range, for the message

        character(:), allocatable :: problem

        value = 0
        if (allocated(error)) return
        call real_from_text(field%text, value, problem, low, high, unit)
        if (allocated(problem)) call self%fail_at(row, name//': '//problem, error)
    end subroutine get_real

    !> The integer in a field of a row, with limits within them (both ends included).
    subroutine get_integer(self, row, field, name, value, error, low, high)
        class(table_file_t), intent(in) :: self
        integer, intent(in) :: row              !! Number of the row, from 1
        type(string_t), intent(in) :: field
        character(*), intent(in) :: name        !! Of the quantity, for the message
        integer, intent(out) :: value           !! 0 after a failure
        type(error_t), allocatable, intent(inout) :: error
        integer, intent(in), optional :: low, high      !! Allowed range

        character(:), allocatable :: problem

        value = 0
        if (allocated(error)) return
        call integer_from_text(field%text, value, problem, low, high)
        if (allocated(problem)) call self%fail_at(row, name//': '//problem, error)
    end subroutine get_integer

    !> Fails unless every field, which nobody uses, is a finite number: what is none there tells of a
    !> file that is not what it is taken for.
    subroutine check_numbers(self, row, fields, first, error, or_nothing)
        class(table_file_t), intent(in) :: self
        integer, intent(in) :: row                      !! Number of the row, from 1
        type(string_t), intent(in) :: fields(:)
        integer, intent(in) :: first                    !! Column of the first of them, for the message
        type(error_t), allocatable, intent(inout) :: error
        logical, intent(in), optional :: or_nothing     !! A single - stands for no number

        real(dp) :: value
        logical :: ok
        integer :: i

        if (allocated(error)) return
        do i = 1, size(fields)
            call parse_real(fields(i)%text, value, ok)
            if (.not. ok .and. present(or_nothing)) ok = or_nothing .and. fields(i)%text == NOTHING
            if (ok) cycle
            call self%fail_at(row, 'column '//integer_text(first + i - 1)//': "'//fields(i)%text// &
                              '" is not a finite number', error)
            return
        end do
    end subroutine check_numbers

    !> All fields of all rows as numbers. Fails, naming the column, when a row has too few or too many, or one is not a
    !> finite number.
    subroutine get_numbers(self, columns, numbers, error)
        class(table_file_t), intent(in) :: self
        character(*), intent(in) :: columns(:)                  !! Their names
        real(dp), allocatable, intent(out) :: numbers(:, :)     !! (row, column)
        type(error_t), allocatable, intent(inout) :: error

        type(string_t), allocatable :: fields(:)
        character(:), allocatable :: names
        integer :: row, k

        if (allocated(error)) return
        allocate (numbers(self%row_count(), size(columns)))
        names = join(columns, ',')
        do row = 1, self%row_count()
            call self%get_fields(row, size(columns), names, fields, error)
            do k = 1, size(columns)
                call self%get_real(row, fields(k), 'column '//trim(columns(k)), numbers(row, k), error)
            end do
            if (allocated(error)) return
        end do
    end subroutine get_numbers

    !> A failure at a row.
    subroutine fail_at(self, row, message, error)
        class(table_file_t), intent(in) :: self
        integer, intent(in) :: row          !! Number of the row, from 1
        character(*), intent(in) :: message !! What is wrong there
        type(error_t), allocatable, intent(out) :: error

        call self%text%fail_at(line_of_row(self, row), message, error)
    end subroutine fail_at
end module gracecg_files_table
