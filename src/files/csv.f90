!> Files of numbers separated by commas: comment lines (#) first, then one line with the names of
!> the columns, then the rows.
module gracecg_files_csv
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, fail_in_file
    use gracecg_files_file, only: text_file_t, read_text_file, output_file_t
    use gracecg_base_text, only: string_t, split, join, padded, parse_real, real_text, real_field, integer_text
    implicit none
    private
    public :: read_csv, csv_writer_t

    type :: csv_writer_t
        !! Writes a CSV file that appears under its name when `commit` has succeeded. What goes
        !! wrong with a row (not a finite number, a wrong count) is remembered and reported by
        !! `commit`.
        private
        type(output_file_t) :: file
        character(:), allocatable :: path
        type(string_t), allocatable :: columns(:)
        integer :: rows = 0
        type(error_t), allocatable :: failure   !! The first thing that went wrong
    contains
        procedure :: open => open_csv       !! Begins a file with its header
        procedure :: row => write_row       !! Writes labels and numbers
        procedure :: commit => commit_csv   !! Ends the file and gives it its name
        procedure :: discard => discard_csv !! Leaves nothing behind
    end type csv_writer_t

contains

    !> Reads a file whose columns must be `expected_columns`, in their order. Fails, naming file,
    !> line and column, when the header differs, a row has too few or too many columns, a value is
    !> not a finite number, or there is no row. Lines may end as on Windows; blank lines are allowed
    !> at the end.
    subroutine read_csv(path, expected_columns, table, error, comments)
        character(*), intent(in) :: path                                    !! Of the file
        character(*), intent(in) :: expected_columns(:)                     !! Names in the header
        real(dp), allocatable, intent(out) :: table(:, :)                   !! (row, column)
        type(error_t), allocatable, intent(out) :: error
        type(string_t), allocatable, intent(out), optional :: comments(:)   !! Lines without the #

        type(text_file_t) :: file
        integer :: header, last, i

        call read_text_file(path, file, error)
        if (allocated(error)) return
        header = 1
        do while (index(file%line(header), '#') == 1)
            header = header + 1
        end do
        do last = file%line_count(), 1, -1
            if (file%line(last) /= '') exit
        end do
        if (present(comments)) then
            allocate (comments(header - 1))
            do i = 1, header - 1
                comments(i)%text = trim(adjustl(file%text(file%first(i) + 1:file%last(i))))
            end do
        end if
        if (last < header) then
            call fail_in_file(error, file%name, 0, 'the file is empty; expected a line with '// &
                              'the columns '//join(expected_columns, ','))
            return
        end if
        call check_header(file, header, expected_columns, error)
        if (allocated(error)) return
        if (last == header) then
            call fail_in_file(error, file%name, 0, 'the file has no row below its header')
            return
        end if
        allocate (table(last - header, size(expected_columns)))
        do i = header + 1, last
            call read_row(file, i, expected_columns, table(i - header, :), error)
            if (allocated(error)) return
        end do
    end subroutine read_csv

    subroutine check_header(file, line_number, expected_columns, error)
        type(text_file_t), intent(in) :: file
        integer, intent(in) :: line_number
        character(*), intent(in) :: expected_columns(:)
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: found(:)
        character(:), allocatable :: problem
        integer :: i

        allocate (found, source=split(file%line(line_number), ','))
        do i = 1, min(size(found), size(expected_columns))
            if (trim(adjustl(found(i)%text)) == expected_columns(i)) cycle
            problem = 'column '//integer_text(i)//' is "'//trim(adjustl(found(i)%text))// &
                      '", expected "'//trim(expected_columns(i))//'"'
            exit
        end do
        if (.not. allocated(problem)) then
            if (size(found) == size(expected_columns)) return
            problem = integer_text(size(found))//' columns, expected '// &
                      integer_text(size(expected_columns))
        end if
        call file%fail_at(line_number, problem//'; the columns must be '// &
                          join(expected_columns, ','), error)
    end subroutine check_header

    subroutine read_row(file, line_number, columns, row, error)
        type(text_file_t), intent(in) :: file
        integer, intent(in) :: line_number
        character(*), intent(in) :: columns(:)
        real(dp), intent(out) :: row(:)
        type(error_t), allocatable, intent(out) :: error

        integer :: column, first, last, comma
        logical :: ok

        first = file%first(line_number)
        last = file%last(line_number)
        column = 0
        do
            comma = first
            do while (comma <= last)
                if (file%text(comma:comma) == ',') exit
                comma = comma + 1
            end do
            column = column + 1
            if (column > size(row)) exit
            call parse_real(file%text(first:comma - 1), row(column), ok)
            if (.not. ok) then
                call file%fail_at(line_number, 'column '//trim(columns(column))//': "'// &
                                  file%text(first:comma - 1)//'" is not a finite number', error)
                return
            end if
            if (comma > last) exit
            first = comma + 1
        end do
        if (column == size(row)) return
        call file%fail_at(line_number, integer_text(size(split(file%line(line_number), ',')))// &
                          ' columns, expected '//integer_text(size(row))//': '// &
                          join(columns, ','), error)
    end subroutine read_row

    !> Begins a file with its comment lines and its header.
    subroutine open_csv(self, path, header, comments, error)
        class(csv_writer_t), intent(inout) :: self
        character(*), intent(in) :: path        !! Of the file to write; an existing one is replaced
        character(*), intent(in) :: header      !! Names of the columns, separated by commas
        character(*), intent(in) :: comments(:) !! Lines without the #; may be none
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        if (allocated(self%failure)) deallocate (self%failure)
        self%rows = 0
        self%path = trim(path)
        self%columns = split(header, ',')
        call self%file%open(path, error)
        if (allocated(error)) return
        do i = 1, size(comments)
            call self%file%line('# '//trim(comments(i)))
        end do
        call self%file%line(header)
    end subroutine open_csv

    !> Writes a row: its labels (the leading columns, texts), then its numbers, each so that it
    !> reads back exactly.
    subroutine write_row(self, values, labels)
        class(csv_writer_t), intent(inout) :: self
        real(dp), intent(in) :: values(:)               !! As many as columns are left by the labels
        character(*), intent(in), optional :: labels(:) !! Of the leading columns

        integer, parameter :: WIDTH = 25    !! 17 digits, signs, point, exponent and comma
        character(WIDTH*size(values)) :: line
        integer :: i, labelled, length

        if (allocated(self%failure)) return
        self%rows = self%rows + 1
        labelled = 0
        if (present(labels)) labelled = size(labels)
        if (labelled + size(values) /= size(self%columns)) then
            call fail(self%failure, self%path//': row '//integer_text(self%rows)//' has '// &
                      integer_text(labelled + size(values))//' values, expected '// &
                      integer_text(size(self%columns))//': '//join(padded(self%columns), ','))
            return
        end if
        length = 0
        do i = 1, size(values)
            if (.not. ieee_is_finite(values(i))) then
                call fail(self%failure, self%path//': row '//integer_text(self%rows)// &
                          ', column '//self%columns(labelled + i)%text//': '// &
                          real_text(values(i))//' is not a finite number')
                return
            end if
            line(length + 1:length + WIDTH) = real_field(values(i))
            length = length + len_trim(line(length + 1:length + WIDTH)) + 1
            line(length:length) = ','
        end do
        if (labelled == 0) then
            call self%file%line(line(:length - 1))
        else if (size(values) == 0) then
            call self%file%line(join(labels, ','))
        else
            call self%file%line(join(labels, ',')//','//line(:length - 1))
        end if
    end subroutine write_row

    !> Completes the file. After a failure there is no file, or still the older one of that name.
    subroutine commit_csv(self, error)
        class(csv_writer_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) then
            call move_alloc(self%failure, error)
            call self%file%discard()
        else
            call self%file%commit(error)
        end if
    end subroutine commit_csv

    !> Gives the file up: nothing of it is left.
    subroutine discard_csv(self)
        class(csv_writer_t), intent(inout) :: self

        call self%file%discard()
    end subroutine discard_csv
end module gracecg_files_csv
