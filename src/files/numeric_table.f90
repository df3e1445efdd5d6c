!> Text tables: rows of fields between blanks or tabs. `#` begins a comment; lines that hold nothing
!> else are passed over. The rows are counted from 1, and failures name file and line.
module gracecg_files_numeric_table
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_files_file, only: text_file_t, read_text_file
    use gracecg_base_text, only: string_t, split_words, integer_text
    use gracecg_files_value, only: real_from_text
    implicit none
    private
    public :: field_file_t, read_field_file

    type :: field_file_t
        !! A text and which of its lines hold fields
        type(text_file_t) :: text           !! The whole file
        integer, allocatable :: line(:)     !! Line number of each row
    contains
        procedure :: row_count                  !! How many lines hold fields
        procedure :: fields => fields_of_row    !! The fields of a row
        procedure :: get_fields                 !! The same, of a row that must have so many
        procedure :: get_real                   !! A number out of a field
        procedure :: fail_at                    !! A failure at a row
    end type field_file_t

contains

    !> Reads a file. Fails when it cannot be read or has no row.
    subroutine read_field_file(path, file, error)
        character(*), intent(in) :: path    !! Of the file
        type(field_file_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        call read_text_file(path, file%text, error)
        if (allocated(error)) return
        file%line = pack([(i, i=1, file%text%line_count())], &
                         [(size(fields_of_line(file%text, i)) > 0, i=1, file%text%line_count())])
        if (file%row_count() == 0) &
            call fail(error, file%text%name//': holds no data (only blank lines and comments)')
    end subroutine read_field_file

    pure integer function row_count(self)
        class(field_file_t), intent(in) :: self

        row_count = size(self%line)
    end function row_count

    !> The fields of a row; none for a number that no row has.
    pure function fields_of_row(self, row) result(fields)
        class(field_file_t), intent(in) :: self
        integer, intent(in) :: row  !! Number of the row, from 1
        type(string_t), allocatable :: fields(:)

        fields = fields_of_line(self%text, line_of_row(self, row))
    end function fields_of_row

    pure function fields_of_line(text, line_number) result(fields)
        type(text_file_t), intent(in) :: text
        integer, intent(in) :: line_number
        type(string_t), allocatable :: fields(:)

        character(:), allocatable :: line

        line = text%line(line_number)
        fields = split_words(line(:index(line//'#', '#') - 1))
    end function fields_of_line

    !> The line number of a row; that behind the last line for a row that is missing.
    pure integer function line_of_row(file, row) result(line_number)
        type(field_file_t), intent(in) :: file
        integer, intent(in) :: row

        line_number = file%text%line_count() + 1
        if (row >= 1 .and. row <= file%row_count()) line_number = file%line(row)
    end function line_of_row

    !> The fields of a row that must have as many as `columns` says.
    subroutine get_fields(self, row, columns, meaning, fields, error)
        class(field_file_t), intent(in) :: self
        integer, intent(in) :: row              !! Number of the row, from 1
        integer, intent(in) :: columns          !! How many fields it must have
        character(*), intent(in) :: meaning     !! What the columns are, for the message
        type(string_t), allocatable, intent(out) :: fields(:)
        type(error_t), allocatable, intent(out) :: error

        fields = self%fields(row)
        if (size(fields) == columns) return
        call self%fail_at(row, 'has '//integer_text(size(fields))//' fields instead of '// &
                          integer_text(columns)//': '//meaning, error)
    end subroutine get_fields

    !> The number in a field of a row: finite and, with limits, within them (both ends included).
    subroutine get_real(self, row, field, name, value, error, low, high, unit)
        class(field_file_t), intent(in) :: self
        integer, intent(in) :: row              !! Number of the row, from 1
        type(string_t), intent(in) :: field
        character(*), intent(in) :: name        !! Of the quantity, for the message
        real(dp), intent(out) :: value          !! In the file's unit
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: low, high !! Allowed range, in the file's unit
        character(*), intent(in), optional :: unit  !! Of the range, for the message

        character(:), allocatable :: problem

        call real_from_text(field%text, value, problem, low, high, unit)
        if (allocated(problem)) call self%fail_at(row, name//': '//problem, error)
    end subroutine get_real

    !> A failure at a row.
    subroutine fail_at(self, row, message, error)
        class(field_file_t), intent(in) :: self
        integer, intent(in) :: row          !! Number of the row, from 1
        character(*), intent(in) :: message !! What is wrong there
        type(error_t), allocatable, intent(out) :: error

        call self%text%fail_at(line_of_row(self, row), message, error)
    end subroutine fail_at
end module gracecg_files_numeric_table
