!> The records of a Level-1 file in memory, or of the files of several days together: all of them, or those within
!> some spans of time; all fields, or those asked for; in order of time, each epoch once.
!>
!>     type(level1_records_t) :: acc
!>     call read_level1('ACC1A_2023-06-01_C_04.txt', acc, error, fields=[character(16) :: 'lin_accl_x', 'qualflg'], &
!>                      spans=reshape([738849600.0_dp, 738849660.0_dp], [2, 1]))
!>     call acc%times_since(738849600_i8, t)          ! s, to the microsecond of the tag
!>     x = acc%values(:, acc%field_of('lin_accl_x'))  ! m/s^2, in the axes of the file
module gracecg_level1_records
    use gracecg_level1_basics
    use gracecg_base_error, only: fail_unknown_name
    use gracecg_level1_products, only: level1_layout_t
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t, BLOCK_RECORDS
    implicit none
    private
    public :: level1_records_t, read_level1

    integer, parameter :: LEAST_ROOM = 4096     !! Records

    interface read_level1
        !! Records of one file, or of several of one product
        module procedure read_file
        module procedure read_files
    end interface read_level1

    type :: level1_records_t
        !! Records in order of time
        character(:), allocatable :: path               !! Of the file, of several the first
        type(level1_header_t) :: header                 !! What the header says
        type(level1_layout_t) :: layout                 !! All fields of the product
        character(1) :: satellite = ''                  !! A to D, by the records; blank when there is none
        character(1) :: time_ref = ''                   !! R or G, by the records; blank when they do not say
        integer :: count = 0                            !! Records
        character(16), allocatable :: fields(:)         !! The names of the columns of `values`
        integer(i8), allocatable :: seconds(:)          !! Whole seconds of the tags, past 2000-01-01 12:00
        real(dp), allocatable :: fraction(:)            !! The rest of the tags, s, 0 <= fraction < 1
        real(dp), allocatable :: values(:, :)           !! Record, field; NaN: not in that record
        integer(i8) :: outside = 0                      !! Records outside of the spans, left out
        integer :: duplicates = 0                       !! Records left out because their epoch came twice
        integer :: unsorted = 0                         !! Records that came before an earlier one
        type(string_t), allocatable :: warnings(:)      !! What is unusual, but no failure
        real(dp), allocatable, private :: series(:)     !! Of each record: head, gyro, tank, or form
    contains
        procedure :: field_of => column_of_field        !! The column of a field
        procedure :: times_since                        !! Time tags from an epoch
        procedure :: drop => drop_records               !! Leaves records out
    end type level1_records_t

contains

    !> Reads a file. Of equal epochs of one series (head, gyro, tank) the first record stays; of clocks and
    !> calibration histories (QSA1B, VCM1B, ...) the last. Fails when the file cannot be read, a record is
    !> broken, satellites or time frames are mixed, or a field is not of the product.
    subroutine read_file(path, records, error, fields, spans, most)
        character(*), intent(in) :: path                        !! Of the file
        type(level1_records_t), intent(out) :: records
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: fields(:)         !! Their names; without them: all
        real(dp), intent(in), optional :: spans(:, :)           !! (2, n): first and last tag, s past 2000-01-01 12:00
        integer, intent(in), optional :: most                   !! Not more records than that, and some thousand

        type(string_t) :: paths(1)      ! gfortran 12 loses the text of an array constructor

        paths(1)%text = path
        call read_files(paths, records, error, fields, spans, most)
    end subroutine read_file

    !> Reads files of one product and satellite as if they were one: those of days that follow one another, in that
    !> order. Where they overlap epochs are there once, as in one file. Fails as for one file, and when product,
    !> satellite or time frame are not those of the first.
    subroutine read_files(paths, records, error, fields, spans, most)
        type(string_t), intent(in) :: paths(:)                  !! Of the files, one at least
        type(level1_records_t), intent(out) :: records
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: fields(:)         !! Their names; without them: all
        real(dp), intent(in), optional :: spans(:, :)           !! (2, n): first and last tag, s past 2000-01-01 12:00
        integer, intent(in), optional :: most                   !! Not more records than that, and some thousand

        integer :: i

        do i = 1, size(paths)
            call read_on(trim(paths(i)%text), records, error, fields, spans, most)
            if (allocated(error)) return
            if (present(most)) then
                if (records%count >= most) exit
            end if
        end do
        call make_room(records, records%count)
        if (records%unsorted > 0) then
            call sort(records)
            call append(records%warnings, integer_text(records%unsorted)// &
                        ' records came before an earlier one: they are sorted')
        end if
        call drop_duplicates(records)
        if (records%duplicates > 0 .and. .not. records%layout%keeps_last) &
            call append(records%warnings, integer_text(records%duplicates)//' records have an epoch that came before: '// &
                        'the first of equal epochs is kept')
    end subroutine read_files

    !> Reads a file behind what is there.
    subroutine read_on(path, records, error, fields, spans, most)
        character(*), intent(in) :: path
        type(level1_records_t), intent(inout) :: records
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: fields(:)
        real(dp), intent(in), optional :: spans(:, :)
        integer, intent(in), optional :: most

        integer, parameter :: SHORTEST_RECORD = 20      ! bytes
        type(level1_reader_t) :: reader
        type(level1_block_t) :: block
        integer(i8) :: bytes
        integer, allocatable :: position(:)
        logical :: kept(BLOCK_RECORDS)
        integer :: room, i

        call reader%open(path, error)
        if (allocated(error)) return
        if (.not. allocated(records%path)) then
            records%path = path
            records%header = reader%header
            records%layout = reader%layout
            allocate (records%warnings(0))
        else if (reader%layout%product /= records%layout%product) then
            call fail(error, path//': is of product '//reader%layout%product//', not '//records%layout%product//' as '// &
                      records%path)
            return
        end if
        call choose_fields(reader%layout, path, records%fields, position, error, fields)
        if (allocated(error)) return
        room = LEAST_ROOM
        if (.not. (present(spans) .or. present(most))) then     ! what the header announces, but not more than the file can have
            inquire (file=path, size=bytes)
            room = int(max(int(room, i8), min(int(reader%header%records, i8), bytes/SHORTEST_RECORD)))
        end if
        call make_room(records, records%count + room)
        kept = .true.
        do
            call reader%next(block, error)
            if (allocated(error)) return
            if (block%count == 0) exit
            associate (n => block%count)
                if (present(spans)) then
                    associate (t => block%seconds(:n) + block%fraction(:n))
                        kept(:n) = [(any(t(i) >= spans(1, :) .and. t(i) <= spans(2, :)), i=1, n)]
                    end associate
                    records%outside = records%outside + count(.not. kept(:n))
                end if
                call add_records(records, block, pack([(i, i=1, n)], kept(:n)), position)
            end associate
            if (present(most)) then
                if (records%count >= most) exit
            end if
        end do
        call take_origin(path, reader, records, error)
    end subroutine read_on

    !> Satellite, time frame and warnings of a file that was read. Fails when they are mixed in it, or are not those of
    !> the files before.
    subroutine take_origin(path, reader, records, error)
        character(*), intent(in) :: path
        type(level1_reader_t), intent(in) :: reader
        type(level1_records_t), intent(inout) :: records
        type(error_t), allocatable, intent(out) :: error

        records%warnings = [records%warnings, reader%warnings]
        if (reader%of_other_satellites > 0) then
            call fail(error, path//': '//integer_text(reader%of_other_satellites)//' of '// &
                      integer_text(reader%records)//' records are of another satellite than '//reader%satellite// &
                      ', that of the first; use one file a satellite')
        else if (reader%of_other_time > 0) then
            call fail(error, path//': '//integer_text(reader%of_other_time)//' of '// &
                      integer_text(reader%records)//' records have another time frame than '//reader%time_ref// &
                      ', that of the first')
        else if (records%satellite /= '' .and. reader%records > 0 .and. reader%satellite /= records%satellite) then
            call fail(error, path//': its records are of satellite '//reader%satellite//', those of '//records%path// &
                      ' of '//records%satellite)
        else if (records%time_ref /= '' .and. reader%records > 0 .and. reader%time_ref /= records%time_ref) then
            call fail(error, path//': its records have time frame '//reader%time_ref//', those of '//records%path//' '// &
                      records%time_ref)
        end if
        if (records%satellite == '' .or. records%count == 0) records%satellite = reader%satellite
        if (records%time_ref == '') records%time_ref = reader%time_ref
    end subroutine take_origin

    !> Puts some records of a block behind those that are there.
    subroutine add_records(records, block, kept, position)
        type(level1_records_t), intent(inout) :: records
        type(level1_block_t), intent(in) :: block
        integer, intent(in) :: kept(:)      !! Their numbers in the block
        integer, intent(in) :: position(:)  !! Fields of the block that are wanted

        integer :: n, m, i

        n = records%count
        m = n + size(kept)
        if (m > size(records%seconds)) call make_room(records, max(m, 2*n))
        records%seconds(n + 1:m) = block%seconds(kept)
        records%fraction(n + 1:m) = block%fraction(kept)
        do i = 1, size(position)
            records%values(n + 1:m, i) = block%values(kept, position(i))
        end do
        records%series(n + 1:m) = 0
        if (records%layout%series > 0) records%series(n + 1:m) = block%values(kept, records%layout%series)
        records%count = m
        records%unsorted = records%unsorted + count([(is_before(records, i, i - 1), i=max(2, n + 1), m)])
    end subroutine add_records

    !> The positions of the wanted fields.
    subroutine choose_fields(layout, path, names, position, error, fields)
        type(level1_layout_t), intent(in) :: layout
        character(*), intent(in) :: path
        character(16), allocatable, intent(out) :: names(:)
        integer, allocatable, intent(out) :: position(:)
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: fields(:)

        integer :: i

        if (.not. present(fields)) then
            position = [(i, i=1, size(layout%fields))]
            names = layout%fields%name
            return
        end if
        allocate (position(size(fields)), names(size(fields)))
        do i = 1, size(fields)
            position(i) = layout%field_of(trim(fields(i)))
            if (position(i) > 0) then
                names(i) = layout%fields(position(i))%name
            else
                call fail_unknown_name(error, trim(path)//': field of '//layout%product, trim(fields(i)), &
                                       layout%fields%name)
                return
            end if
        end do
    end subroutine choose_fields

    !> Room for so many records; what is there stays.
    subroutine make_room(records, room)
        type(level1_records_t), intent(inout) :: records
        integer, intent(in) :: room     !! At least as many as there are

        real(dp), allocatable :: values(:, :), fraction(:), series(:)
        integer(i8), allocatable :: seconds(:)
        integer :: n

        n = records%count
        if (allocated(records%seconds)) then
            if (size(records%seconds) == room) return
        end if
        allocate (seconds(room), fraction(room), series(room), values(room, size(records%fields)))
        if (n > 0) then
            seconds(:n) = records%seconds(:n)
            fraction(:n) = records%fraction(:n)
            series(:n) = records%series(:n)
            values(:n, :) = records%values(:n, :)
        end if
        call move_alloc(seconds, records%seconds)
        call move_alloc(fraction, records%fraction)
        call move_alloc(series, records%series)
        call move_alloc(values, records%values)
    end subroutine make_room

    !> Whether record i has an earlier tag than record k.
    pure logical function is_before(records, i, k)
        type(level1_records_t), intent(in) :: records
        integer, intent(in) :: i, k

        is_before = records%seconds(i) < records%seconds(k) .or. &
                    (records%seconds(i) == records%seconds(k) .and. records%fraction(i) < records%fraction(k))
    end function is_before

    !> Order of time; records of equal epochs stay in theirs.
    subroutine sort(records)
        type(level1_records_t), intent(inout) :: records

        integer :: order(records%count), i

        order = [(i, i=1, size(order))]
        call merge_sort(records, order)
        call take(records, order)
    end subroutine sort

    !> Numbers of records by their tags: each half is sorted, then both are merged.
    recursive subroutine merge_sort(records, order)
        type(level1_records_t), intent(in) :: records
        integer, intent(inout) :: order(:)

        integer :: merged(size(order)), i, j, k, half
        logical :: of_second

        half = size(order)/2
        if (half == 0) return
        call merge_sort(records, order(:half))
        call merge_sort(records, order(half + 1:))
        i = 1
        j = half + 1
        do k = 1, size(order)
            of_second = i > half
            if (i <= half .and. j <= size(order)) of_second = is_before(records, order(j), order(i))
            if (of_second) then
                merged(k) = order(j)
                j = j + 1
            else
                merged(k) = order(i)
                i = i + 1
            end if
        end do
        order = merged
    end subroutine merge_sort

    !> The records of these numbers, in their order.
    subroutine take(records, order)
        type(level1_records_t), intent(inout) :: records
        integer, intent(in) :: order(:)

        integer :: i
        real(dp), allocatable :: values(:, :)

        records%seconds = records%seconds(order)
        records%fraction = records%fraction(order)
        records%series = records%series(order)
        allocate (values(size(order), size(records%fields)))
        do i = 1, size(records%fields)
            values(:, i) = records%values(order, i)
        end do
        call move_alloc(values, records%values)
        records%count = size(order)
    end subroutine take

    !> Of records of one series with equal epochs one stays.
    subroutine drop_duplicates(records)
        type(level1_records_t), intent(inout) :: records

        logical :: stays(records%count)
        integer :: first, i, k

        stays = .true.
        first = 1
        do i = 2, records%count
            if (is_before(records, first, i)) first = i
            do k = first, i - 1
                if (.not. stays(k) .or. abs(records%series(k) - records%series(i)) > 0) cycle
                if (records%layout%keeps_last) then
                    stays(k) = .false.
                else
                    stays(i) = .false.
                    exit
                end if
            end do
        end do
        records%duplicates = count(.not. stays)
        if (records%duplicates > 0) call records%drop(.not. stays)
    end subroutine drop_duplicates

    !> Leaves records out.
    subroutine drop_records(self, unwanted)
        class(level1_records_t), intent(inout) :: self
        logical, intent(in) :: unwanted(:)  !! As many as records

        integer :: i

        call take(self, pack([(i, i=1, self%count)], .not. unwanted))
    end subroutine drop_records

    !> The column of a field in `values`; 0 when it is not there.
    pure integer function column_of_field(self, name) result(column)
        class(level1_records_t), intent(in) :: self
        character(*), intent(in) :: name    !! As in the table of level1_products

        integer :: position

        column = findloc(self%fields == name, .true., 1)
        if (column > 0) return
        position = self%layout%field_of(name)
        if (position > 0) column = findloc(self%fields == self%layout%fields(position)%name, .true., 1)
    end function column_of_field

    !> Time tags in s since a whole second past 2000-01-01 12:00, in the time frame of the file: exact to rounding
    !> within some years.
    subroutine times_since(self, epoch, times)
        class(level1_records_t), intent(in) :: self
        integer(i8), intent(in) :: epoch                    !! s past 2000-01-01 12:00
        real(dp), allocatable, intent(out) :: times(:)      !! s, one a record

        times = real(self%seconds - epoch, dp) + self%fraction
    end subroutine times_since
end module gracecg_level1_records
