!> Writing files of numbers separated by commas: one line with the names of the columns, then the rows.
!>
!> What else is to be said of a file (version, seed, settings) stands beside it in FILE.meta.json, so that
!> every reader of CSV takes the file as it is. Read by gracecg_files_table. The names of the columns tell the unit:
!> sigma_x_mm, time_s, ax_m_s2.
module gracecg_files_csv
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: string_t, split, join, padded, quoted_text, real_text, real_field, integer_text
    use gracecg_files_file, only: output_file_t, remove_file, is_device
    use gracecg_files_json, only: json_writer_t, put_provenance
    implicit none
    private
    public :: csv_writer_t, csv_field, SIDE_ENDING, SIDE_COMMENTS, unit_of_column

    !> Ending of the name of the file that tells of a CSV file, and its member with the comments
    character(*), parameter :: SIDE_ENDING = '.meta.json', SIDE_COMMENTS = 'about'

    character(1), parameter :: QUOTE = '"'
    character(*), parameter :: SPECIAL = ',"'//achar(10)//achar(13)     !! What a field has in quotes alone

    type :: csv_writer_t
        !! Writes a CSV file that appears under its name when `commit` has succeeded. What goes
        !! wrong with a row (not a finite number, a wrong count) is remembered and reported by
        !! `commit`.
        private
        type(output_file_t) :: file
        character(:), allocatable :: path
        type(string_t), allocatable :: columns(:)
        type(string_t), allocatable :: about(:) !! For the side file; none: there is no such file
        integer :: rows = 0
        type(error_t), allocatable :: failure   !! The first thing that went wrong
    contains
        procedure :: open => open_csv       !! Begins a file with its header
        procedure :: row => write_row       !! Writes numbers
        procedure :: fields => write_fields !! Writes a row of texts
        procedure :: commit => commit_csv   !! Ends the file and gives it its name
        procedure :: discard => discard_csv !! Leaves nothing behind
    end type csv_writer_t

    !> How a name ends, and the unit that it means; of two endings that fit, the earlier
    character(16), parameter :: UNITS(2, 32) = reshape([character(16) :: &
        '_m_s2_sqrt_hz', 'm/s^2/sqrt(Hz)', &
        '_rad_s2', 'rad/s^2', '_rad_s', 'rad/s', '_deg_s', 'deg/s', '_m2_s4_hz', 'm^2/s^4/Hz', &
        '_m2_s2', 'm^2/s^2', '_m_s3', 'm/s^3', '_m_s2', 'm/s^2', '_m_s', 'm/s', '_kg_m3', 'kg/m^3', &
        '_per_m3', '1/m^3', '_n_m', 'N m', '_a_m2', 'A m^2', '_a_m', 'A/m', '_arcsec', 'arcsec', &
        '_kelvin', 'K', '_tesla', 'T', '_nt', 'nT', '_rad', 'rad', '_deg', 'deg', '_hz', 'Hz', &
        '_sfu', 'sfu', '_au', 'au', '_km', 'km', '_mm2', 'mm^2', '_mm', 'mm', '_um', 'um', '_m', 'm', &
        '_percent', '%', '_kg', 'kg', '_h', 'h', '_s', 's'], [2, 32])

contains

    !> Begins a file with its header.
    subroutine open_csv(self, path, header, comments, error)
        class(csv_writer_t), intent(inout) :: self
        character(*), intent(in) :: path        !! Of the file to write; an existing one is replaced
        character(*), intent(in) :: header      !! Names of the columns, separated by commas
        character(*), intent(in) :: comments(:) !! Lines about the file, for FILE.meta.json; may be none
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        if (allocated(self%failure)) deallocate (self%failure)
        self%rows = 0
        self%path = trim(path)
        self%columns = split(header, ',')
        call self%file%open(path, error)
        if (allocated(error)) return
        if (allocated(self%about)) deallocate (self%about)
        allocate (self%about(size(comments)))
        do i = 1, size(comments)
            self%about(i)%text = trim(comments(i))
        end do
        call self%file%line(header)
    end subroutine open_csv

    !> Writes a row of texts. One that holds a comma or a quote is put into quotes.
    subroutine write_fields(self, texts)
        class(csv_writer_t), intent(inout) :: self
        type(string_t), intent(in) :: texts(:)          !! As many as columns

        character(:), allocatable :: line
        integer :: i

        if (allocated(self%failure)) return
        self%rows = self%rows + 1
        call check_count(self, size(texts))
        if (allocated(self%failure)) return
        line = csv_field(texts(1)%text)
        do i = 2, size(texts)
            line = line//','//csv_field(texts(i)%text)
        end do
        call self%file%line(line)
    end subroutine write_fields

    !> A row has as many values as there are columns.
    subroutine check_count(self, values)
        class(csv_writer_t), intent(inout) :: self
        integer, intent(in) :: values

        if (values /= size(self%columns)) &
            call fail(self%failure, self%path//': row '//integer_text(self%rows)//' has '// &
                      integer_text(values)//' values, expected '// &
                      integer_text(size(self%columns))//': '//join(padded(self%columns), ','))
    end subroutine check_count

    !> Writes a row of numbers, each so that it reads back exactly.
    subroutine write_row(self, values)
        class(csv_writer_t), intent(inout) :: self
        real(dp), intent(in) :: values(:)               !! As many as columns, at least one

        integer, parameter :: WIDTH = 25    !! 17 digits, signs, point, exponent and comma
        character(WIDTH*size(values)) :: line
        integer :: i, length

        if (allocated(self%failure)) return
        self%rows = self%rows + 1
        call check_count(self, size(values))
        if (allocated(self%failure)) return
        length = 0
        do i = 1, size(values)
            if (.not. ieee_is_finite(values(i))) then
                call fail(self%failure, self%path//': row '//integer_text(self%rows)//', column '// &
                          self%columns(i)%text//': '//real_text(values(i))//' is not a finite number')
                return
            end if
            line(length + 1:length + WIDTH) = real_field(values(i))
            length = length + len_trim(line(length + 1:length + WIDTH)) + 1
            line(length:length) = ','
        end do
        call self%file%line(line(:length - 1))
    end subroutine write_row

    pure integer function field_length(text) result(length)
        character(*), intent(in) :: text

        length = len(text)
        if (scan(text, SPECIAL) > 0) length = len(quoted_text(text, QUOTE))
    end function field_length

    !> A text as a field: in quotes, doubled within, where it holds a comma, a quote or a line end.
    pure function csv_field(text) result(field)
        character(*), intent(in) :: text        !! Of a field
        character(field_length(text)) :: field

        field = text
        if (scan(text, SPECIAL) > 0) field = quoted_text(text, QUOTE)
    end function csv_field

    !> Completes the file, and what tells of it. After a failure there is no file, or still the older one of
    !> that name. What tells of an older file never stands beside a new one.
    subroutine commit_csv(self, error)
        class(csv_writer_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) then
            call move_alloc(self%failure, error)
            call self%file%discard()
        else
            if (.not. is_device(self%path)) call remove_file(self%path//SIDE_ENDING)
            call self%file%commit(error)
            if (.not. (allocated(error) .or. is_device(self%path) .or. size(self%about) == 0)) &
                call write_side_file(self, error)
        end if
    end subroutine commit_csv

    !> FILE.meta.json: the program, the units of the columns, and the comments.
    subroutine write_side_file(self, error)
        type(csv_writer_t), intent(in) :: self
        type(error_t), allocatable, intent(out) :: error

        type(json_writer_t) :: json
        type(output_file_t) :: file
        character(:), allocatable :: text
        integer :: i

        call json%begin()
        call json%member('program', 'gracecg')
        call json%member('version', VERSION)
        call json%member('file', self%path(index(self%path, '/', back=.true.) + 1:))
        call json%member(SIDE_COMMENTS, self%about)
        call put_provenance(json)
        call json%begin('units')
        do i = 1, size(self%columns)
            if (unit_of_column(self%columns(i)%text) /= '') &
                call json%member(self%columns(i)%text, trim(unit_of_column(self%columns(i)%text)))
        end do
        call json%end()
        call json%end()
        call json%finish(text, error)
        if (.not. allocated(error)) call file%open(self%path//SIDE_ENDING, error)
        if (allocated(error)) return
        call file%line(text)
        call file%commit(error)
    end subroutine write_side_file

    !> Gives the file up: nothing of it is left.
    subroutine discard_csv(self)
        class(csv_writer_t), intent(inout) :: self

        call self%file%discard()
    end subroutine discard_csv

    !> The unit that the name of a column ends with; blank: it has none, or is no number.
    pure function unit_of_column(name) result(unit)
        character(*), intent(in) :: name    !! Of a column: 'dx_mm'
        character(len(UNITS)) :: unit

        integer :: i, first

        unit = ''
        do i = 1, size(UNITS, 2)
            first = len_trim(name) - len_trim(UNITS(1, i)) + 1
            if (first < 2) cycle
            if (name(first:len_trim(name)) /= UNITS(1, i)) cycle
            unit = UNITS(2, i)
            return
        end do
    end function unit_of_column
end module gracecg_files_csv
