!> A table of results, described once: the name of each column, which tells its unit, and how people read it.
!> It writes itself as lines for people, as CSV and as JSON.
module gracecg_files_data_table
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append, split, integer_text, logical_text, real_text
    use gracecg_files_csv, only: csv_writer_t, csv_field, unit_of_column
    use gracecg_files_json, only: json_writer_t
    implicit none
    private
    public :: data_table_t

    integer, parameter :: NOTHING = 0, TEXT = 1, NUMBER = 2     !! What a cell holds
    integer, parameter :: GAP = 2               !! Blanks between two columns

    !> One value: its text in files, and, of a number, the number itself.
    type :: cell_t
        integer :: kind = NOTHING
        character(:), allocatable :: text
        real(dp) :: value = 0
    end type cell_t

    !> A column: its name in files, and for people heading and format.
    type :: column_t
        character(:), allocatable :: name       !! As in the files, the unit at its end: sigma_x_mm
        character(:), allocatable :: heading    !! For people; a vertical bar parts two lines
        character(:), allocatable :: layout
        !! Fortran's format of a number; of a text 'a', or 'clock': of 1989-01-02T00:00:00 the time of day; empty: not shown
        real(dp) :: factor = 1                  !! For people: numbers are shown times this
    end type column_t

    type :: data_table_t
        !! Columns first, then row by row the values in the order of the columns
        private
        type(column_t), allocatable :: columns(:)
        character(:), allocatable :: header     !! Names of the columns, with commas
        type(cell_t), allocatable :: cells(:)
        integer :: used = 0                     !! Cells
        type(error_t), allocatable :: failure   !! The first value that no file can hold
    contains
        procedure :: column => add_column       !! Declares a column
        procedure :: columns_of => add_columns  !! Declares several columns that only files have
        generic :: add => add_texts, add_label, add_real, add_reals, add_integer, add_long_integer, add_logical
        !! Puts the next value, or the next values, into the row; real ones that are not known leave their cells empty
        procedure :: add_nothing                !! Leaves a cell empty
        procedure :: row_count                  !! How many rows there are
        procedure :: csv                        !! Header and rows as lines of CSV
        procedure :: write => write_file        !! Writes a CSV file
        procedure :: to_json                    !! Units and rows as members of a JSON object
        procedure :: lines                      !! For people
        procedure, private :: add_texts, add_label, add_real, add_reals, add_integer, add_long_integer, add_logical, put
    end type data_table_t

contains

    !> Declares a column.
    subroutine add_column(self, name, layout, heading, factor)
        class(data_table_t), intent(inout) :: self
        character(*), intent(in) :: name                !! As in the files, the unit at its end: sigma_x_mm
        character(*), intent(in), optional :: layout    !! For people, of one value: 'f10.5', 'a', 'clock'; absent: not shown
        character(*), intent(in), optional :: heading
        !! For people; a vertical bar parts two lines, of which the first may reach over columns that have none
        real(dp), intent(in), optional :: factor        !! For people: numbers are shown times this

        type(column_t), allocatable :: longer(:)
        integer :: n

        if (.not. allocated(self%columns)) then
            allocate (self%columns(0), self%cells(0))
            self%header = ''
        end if
        n = size(self%columns) + 1
        if (n > 1) self%header = self%header//','
        self%header = self%header//name
        allocate (longer(n))
        longer(:n - 1) = self%columns
        longer(n)%name = name
        longer(n)%layout = ''
        longer(n)%heading = ''
        if (present(layout)) longer(n)%layout = layout
        if (present(heading)) longer(n)%heading = heading
        if (present(factor)) longer(n)%factor = factor
        call move_alloc(longer, self%columns)
    end subroutine add_column

    !> Declares several columns that only files have.
    subroutine add_columns(self, names)
        class(data_table_t), intent(inout) :: self
        character(*), intent(in) :: names       !! Separated by commas

        type(string_t), allocatable :: pieces(:)
        integer :: i

        pieces = split(names, ',')
        do i = 1, size(pieces)
            call self%column(pieces(i)%text)
        end do
    end subroutine add_columns

    subroutine put(self, kind, text, value)
        class(data_table_t), intent(inout) :: self
        integer, intent(in) :: kind
        character(*), intent(in) :: text
        real(dp), intent(in) :: value

        type(cell_t), allocatable :: longer(:)

        if (self%used == size(self%cells)) then
            allocate (longer(2*size(self%cells) + 64))
            longer(:self%used) = self%cells(:self%used)
            call move_alloc(longer, self%cells)
        end if
        self%used = self%used + 1
        associate (cell => self%cells(self%used))
            cell%kind = kind
            cell%text = text
            cell%value = value
        end associate
    end subroutine put

    subroutine add_texts(self, value, second, third, fourth)
        class(data_table_t), intent(inout) :: self
        character(*), intent(in) :: value
        character(*), intent(in), optional :: second, third, fourth

        call self%put(TEXT, trim(value), 0.0_dp)
        if (present(second)) call self%put(TEXT, trim(second), 0.0_dp)
        if (present(third)) call self%put(TEXT, trim(third), 0.0_dp)
        if (present(fourth)) call self%put(TEXT, trim(fourth), 0.0_dp)
    end subroutine add_texts

    !> A text and the numbers behind it.
    subroutine add_label(self, value, numbers)
        class(data_table_t), intent(inout) :: self
        character(*), intent(in) :: value
        real(dp), intent(in) :: numbers(:)

        call self%put(TEXT, trim(value), 0.0_dp)
        call self%add_reals(numbers)
    end subroutine add_label

    subroutine add_real(self, value, known)
        class(data_table_t), intent(inout) :: self
        real(dp), intent(in) :: value
        logical, intent(in), optional :: known

        call self%add_reals([value], known)
    end subroutine add_real

    subroutine add_reals(self, value, known)
        class(data_table_t), intent(inout) :: self
        real(dp), intent(in) :: value(:)
        logical, intent(in), optional :: known

        integer :: i

        if (present(known)) then
            if (.not. known) call self%add_nothing(size(value))
            if (.not. known) return
        end if
        do i = 1, size(value)
            if (.not. ieee_is_finite(value(i)) .and. .not. allocated(self%failure)) &
                call fail(self%failure, self%columns(mod(self%used, size(self%columns)) + 1)%name//': the result is not '// &
                          'a finite number')
            call self%put(NUMBER, real_text(value(i)), value(i))
        end do
    end subroutine add_reals

    subroutine add_integer(self, value)
        class(data_table_t), intent(inout) :: self
        integer, intent(in) :: value

        call self%put(NUMBER, integer_text(value), real(value, dp))
    end subroutine add_integer

    subroutine add_long_integer(self, value)
        class(data_table_t), intent(inout) :: self
        integer(i8), intent(in) :: value

        call self%put(NUMBER, integer_text(value), real(value, dp))
    end subroutine add_long_integer

    subroutine add_logical(self, value)
        class(data_table_t), intent(inout) :: self
        logical, intent(in) :: value

        call self%put(NUMBER, trim(logical_text(value)), merge(1.0_dp, 0.0_dp, value))
    end subroutine add_logical

    !> Leaves cells empty: nothing in CSV, null in JSON, a dash for people.
    subroutine add_nothing(self, cells)
        class(data_table_t), intent(inout) :: self
        integer, intent(in), optional :: cells      !! How many; one when absent

        integer :: i

        call self%put(NOTHING, '', 0.0_dp)
        if (.not. present(cells)) return
        do i = 2, cells
            call self%put(NOTHING, '', 0.0_dp)
        end do
    end subroutine add_nothing

    pure integer function row_count(self)
        class(data_table_t), intent(in) :: self

        row_count = 0
        if (allocated(self%columns)) row_count = self%used/size(self%columns)
    end function row_count

    !> Header and rows as lines of CSV. Fails when a number was not finite or the last row is not complete.
    subroutine csv(self, lines, error)
        class(data_table_t), intent(in) :: self
        type(string_t), allocatable, intent(out) :: lines(:)
        type(error_t), allocatable, intent(out) :: error

        integer :: i, k, columns

        call check_whole(self, error)
        if (allocated(error)) then
            allocate (lines(0))
            return
        end if
        columns = size(self%columns)
        allocate (lines(self%row_count() + 1))
        lines(1)%text = self%header
        do i = 1, self%row_count()
            lines(i + 1)%text = csv_field(self%cells((i - 1)*columns + 1)%text)
            do k = 2, columns
                lines(i + 1)%text = lines(i + 1)%text//','//csv_field(self%cells((i - 1)*columns + k)%text)
            end do
        end do
    end subroutine csv

    subroutine check_whole(self, error)
        class(data_table_t), intent(in) :: self
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) then
            error = self%failure
        else if (mod(self%used, size(self%columns)) /= 0) then
            call fail(error, 'the last row of a table has '//integer_text(mod(self%used, size(self%columns)))// &
                      ' values, expected '//integer_text(size(self%columns))//': '//self%header)
        end if
    end subroutine check_whole

    !> Writes a CSV file. Fails as `csv`, and when it cannot be written; there is then no file, or still an
    !> older one.
    subroutine write_file(self, path, about, error)
        class(data_table_t), intent(in) :: self
        character(*), intent(in) :: path        !! Of the file; an existing one is replaced
        character(*), intent(in) :: about(:)    !! Lines about it, for FILE.meta.json
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        type(string_t), allocatable :: fields(:)
        integer :: i, k, columns

        call check_whole(self, error)
        if (.not. allocated(error)) call file%open(path, self%header, about, error)
        if (allocated(error)) then
            error%message = path//': '//error%message
            return
        end if
        columns = size(self%columns)
        allocate (fields(columns))
        do i = 1, self%row_count()
            do k = 1, columns
                fields(k)%text = self%cells((i - 1)*columns + k)%text
            end do
            call file%fields(fields)
        end do
        call file%commit(error)
    end subroutine write_file

    !> The members `key_units` (of each column that has one) and `key`, an array with an object for each row.
    subroutine to_json(self, json, key, units)
        class(data_table_t), intent(in) :: self
        class(json_writer_t), intent(inout) :: json
        character(*), intent(in) :: key         !! Of the rows
        logical, intent(in), optional :: units  !! With the units; yes when absent

        logical :: told
        integer :: i, k, columns

        columns = size(self%columns)
        told = .true.
        if (present(units)) told = units
        if (told) then
            call json%begin(key//'_units', on_one_line=.true.)
            do k = 1, columns
                if (unit_of_column(self%columns(k)%name) /= '') &
                    call json%member(self%columns(k)%name, trim(unit_of_column(self%columns(k)%name)))
            end do
            call json%end()
        end if
        call json%begin_array(key)
        do i = 1, self%row_count()
            call json%begin(on_one_line=.true.)
            do k = 1, columns
                call cell_to_json(self%cells((i - 1)*columns + k), self%columns(k)%name, json)
            end do
            call json%end()
        end do
        call json%end()
    end subroutine to_json

    subroutine cell_to_json(cell, name, json)
        type(cell_t), intent(in) :: cell
        character(*), intent(in) :: name
        class(json_writer_t), intent(inout) :: json

        select case (cell%kind)
        case (NOTHING)
            call json%nothing(name)
        case (TEXT)
            call json%member(name, cell%text)
        case default
            if (ieee_is_finite(cell%value)) then
                call json%raw(name, cell%text)
            else
                call json%member(name, cell%value)      ! which is refused
            end if
        end select
    end subroutine cell_to_json

    !> Lines for people: headings above the columns that have a format. A table that is wider than `width`
    !> comes in blocks, one below the other, each with the first column.
    subroutine lines(self, width, text)
        class(data_table_t), intent(in) :: self
        integer, intent(in) :: width            !! In characters
        type(string_t), allocatable, intent(out) :: text(:)

        type(string_t), allocatable :: shown(:, :)      ! (column, row); rows -1 and 0 hold the headings
        integer, allocatable :: widths(:)
        integer :: columns, rows, first, last, total, i
        logical :: two_lines

        columns = size(self%columns)
        rows = self%row_count()
        allocate (shown(columns, -1:rows), widths(columns), text(0))
        call fill_texts(self, shown, widths)
        two_lines = .false.
        do i = 1, columns
            two_lines = two_lines .or. shown(i, -1)%text /= ''
        end do
        first = 2
        do
            total = widths(1)
            last = first
            do i = first, columns
                if (widths(i) == 0) then
                    last = i
                    cycle
                end if
                total = total + GAP + widths(i)
                if (total > width .and. i > first) exit
                last = i
            end do
            if (first > 2) call append(text, '')
            if (two_lines) call append(text, first_heading(shown(:, -1), widths, first, last))
            do i = 0, rows
                call append(text, line_of(self, shown(:, i), widths, first, last))
            end do
            first = last + 1
            if (first > columns) exit
        end do
    end subroutine lines

    subroutine fill_texts(self, shown, widths)
        type(data_table_t), intent(in) :: self
        type(string_t), intent(inout) :: shown(:, -1:)
        integer, intent(out) :: widths(:)

        character(40) :: buffer
        integer :: i, k, bar

        do k = 1, size(self%columns)
            associate (column => self%columns(k))
                shown(k, -1)%text = ''
                shown(k, 0)%text = ''
                widths(k) = 0
                if (column%layout == '') cycle
                bar = index(column%heading, '|')
                shown(k, -1)%text = column%heading(:bar - 1)
                shown(k, 0)%text = column%heading(bar + 1:)
                widths(k) = len(shown(k, 0)%text)
                do i = 1, ubound(shown, 2)
                    associate (cell => self%cells((i - 1)*size(self%columns) + k))
                        if (cell%kind == NOTHING) then
                            shown(k, i)%text = '-'
                        else if (column%layout == 'clock') then
                            shown(k, i)%text = cell%text(index(cell%text, 'T') + 1:)
                        else if (column%layout == 'a' .or. cell%kind == TEXT) then
                            shown(k, i)%text = cell%text
                        else if (column%layout(1:1) == 'i') then
                            write (buffer, '('//column%layout//')') nint(cell%value, i8)
                            shown(k, i)%text = trim(adjustl(buffer))
                        else
                            write (buffer, '('//column%layout//')') cell%value*column%factor
                            shown(k, i)%text = trim(adjustl(buffer))
                        end if
                        widths(k) = max(widths(k), len(shown(k, i)%text))
                    end associate
                end do
            end associate
        end do
        do k = 1, size(widths)
            if (shown(k, -1)%text == '') cycle
            if (reach(k) < len(shown(k, -1)%text)) widths(k) = widths(k) + len(shown(k, -1)%text) - reach(k)
        end do

    contains

        !> How far the first line of a heading may reach.
        integer function reach(first)
            integer, intent(in) :: first

            integer :: i

            reach = widths(first)
            do i = first + 1, size(widths)
                if (shown(i, -1)%text /= '') exit
                if (widths(i) > 0) reach = reach + GAP + widths(i)
            end do
        end function reach
    end subroutine fill_texts

    !> The first line of the headings: each begins where its column does, and may go on over the next ones.
    function first_heading(shown, widths, first, last) result(line)
        type(string_t), intent(in) :: shown(:)      !! First lines
        integer, intent(in) :: widths(:), first, last
        character(sum(widths) + GAP*size(widths)) :: line

        integer :: k, n

        line = ''
        n = 0
        do k = 1, last
            if (widths(k) == 0 .or. (k > 1 .and. k < first)) cycle
            if (shown(k)%text /= '') line(n + 1:) = shown(k)%text
            n = n + widths(k) + GAP
        end do
    end function first_heading

    !> Texts stand at the left of their columns, numbers at the right.
    function line_of(self, shown, widths, first, last) result(line)
        type(data_table_t), intent(in) :: self
        type(string_t), intent(in) :: shown(:)      !! Of a row
        integer, intent(in) :: widths(:), first, last
        character(sum(widths) + GAP*size(widths)) :: line

        integer :: k, n

        line = ''
        n = 0
        do k = 1, last
            if (widths(k) == 0 .or. (k > 1 .and. k < first)) cycle
            if (self%columns(k)%layout == 'a') then
                line(n + 1:n + widths(k)) = shown(k)%text
            else
                line(n + 1:n + widths(k)) = repeat(' ', widths(k) - len(shown(k)%text))//shown(k)%text
            end if
            n = n + widths(k) + GAP
        end do
    end function line_of
end module gracecg_files_data_table
