!> Writing files of numbers separated by commas: comment lines (#) first, then one line with the names
!> of the columns, then the rows. Read by gracecg_files_table.
module gracecg_files_csv
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_files_file, only: output_file_t
    use gracecg_base_text, only: string_t, split, join, padded, real_text, real_field, integer_text
    implicit none
    private
    public :: csv_writer_t

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
