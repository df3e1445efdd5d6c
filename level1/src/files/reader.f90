!> Reading Level-1 files, text and binary, in blocks of records: constant memory, whatever the length.
!>
!>     type(level1_reader_t) :: reader
!>     type(level1_block_t) :: block
!>     call reader%open('ACC1A_2023-06-01_C_04.txt', error)    ! header, product, layout
!>     x = reader%layout%field_of('lin_accl_x')                ! names: the table of level1_products
!>     do
!>         call reader%next(block, error)
!>         if (allocated(error) .or. block%count == 0) exit
!>         ... block%seconds(:block%count), block%fraction(...), block%values(:block%count, x)
!>     end do
!>     call reader%close()
!>
!> Behind the last record `reader%warnings` has what is unusual but no failure. For a whole file, or a part of
!> it, see `read_level1`.
!>
!> Every value is a real number: integers and flags up to 32 bits are exact in it, letters are their codes
!> (`achar(nint(value))`). A value that a record has not (prod_flag), or that is not finite, is NaN.
module gracecg_level1_reader
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_is_nan
    use gracecg_level1_basics
    use gracecg_base_error, only: fail_in_file
    use gracecg_level1_bundles, only: level1_stream_t
    use gracecg_level1_products, only: level1_layout_t, level1_layout, satellite_of_grace_fo, SATELLITES
    use gracecg_level1_header, only: level1_header_t, parse_level1_header, product_of_file_name, &
        satellite_of_file_name, printable
    use gracecg_level1_field_forms, only: read_bytes, unsigned_at, read_word, word_at, skip_white
    implicit none
    private
    public :: level1_reader_t, level1_block_t, BLOCK_RECORDS

    integer, parameter :: BUFFER_BYTES = 2**21      !! Read at once; a header must fit in
    integer, parameter :: LONGEST_LINE = 16384      !! Of a text file, behind the header
    integer, parameter :: BLOCK_RECORDS = 1024      !! Records that are decoded at once
    character(1), parameter :: LF = achar(10)

    type :: level1_block_t
        !! Some records, one after the other
        integer :: count = 0                        !! How many; 0 behind the last one
        integer(i8), allocatable :: seconds(:)      !! Whole seconds of the time tag, past 2000-01-01 12:00
        real(dp), allocatable :: fraction(:)        !! The rest of the time tag, s, 0 <= fraction < 1
        real(dp), allocatable :: values(:, :)       !! Record, field of the layout
    end type level1_block_t

    type :: level1_reader_t
        !! A Level-1 file being read
        character(:), allocatable :: path               !! As the user gave it
        type(level1_header_t) :: header                 !! What the header says
        type(level1_layout_t) :: layout                 !! The fields of the records
        character(1) :: satellite = ''                  !! That of the first record; blank when there is none
        character(1) :: time_ref = ''                   !! Of the first record, R or G; blank: by the product
        integer(i8) :: records = 0                      !! Read so far
        type(string_t), allocatable :: warnings(:)      !! Complete behind the last record
        integer(i8), allocatable :: not_finite(:)       !! Values that are no finite numbers, by field
        integer(i8) :: of_other_satellites = 0          !! Records of another satellite than the first
        integer(i8) :: of_other_time = 0                !! Records in another time frame than the first
        type(level1_stream_t), private :: stream
        character(:), allocatable, private :: buffer
        integer, private :: at = 1          !! Next byte in buffer to decode
        integer, private :: filled = 0      !! Bytes of the buffer that are there
        logical, private :: at_end = .true. !! The stream has no more bytes
        integer(i8), private :: base = 0    !! Bytes of the file before the buffer
        integer, private :: line = 0        !! Lines before `at`
        integer(i8), private :: shape = 0   !! Of the last record: prod_flag or number of channels
        integer, allocatable, private :: there(:)       !! Fields of records of that shape
        integer, allocatable, private :: kind(:)        !! Of these
        integer, allocatable, private :: offset(:)      !! Of these in a binary record
        integer, private :: length = 0                  !! Bytes of a binary record
    contains
        procedure :: open => open_reader        !! Header, product and layout of a file
        procedure :: next => next_block         !! The next records
        procedure :: close => close_reader      !! Ends it
        procedure :: warn                       !! Notes what is unusual
    end type level1_reader_t

contains

    !> Opens a file, reads its header and finds its product and layout. Fails when it is no Level-1 file, or
    !> its product is not known.
    subroutine open_reader(self, path, error)
        class(level1_reader_t), intent(inout) :: self
        character(*), intent(in) :: path    !! Of the file
        type(error_t), allocatable, intent(out) :: error

        character(5) :: product, named
        character(1) :: satellite
        integer :: i

        call self%close()
        self%path = trim(path)
        self%warnings = [string_t ::]
        self%records = 0
        self%of_other_satellites = 0
        self%of_other_time = 0
        self%time_ref = ''
        self%base = 0
        self%at = 1
        self%filled = 0
        self%at_end = .false.
        call self%stream%open(path, error)
        if (allocated(error)) return
        if (.not. allocated(self%buffer)) allocate (character(BUFFER_BYTES + 1) :: self%buffer)
        call refill(self, error)
        if (.not. allocated(error)) &
            call parse_level1_header(self%path, self%buffer(:self%filled), self%header, error)
        if (allocated(error)) then
            call self%close()
            return
        end if
        self%at = self%header%bytes + 1
        self%line = self%header%lines
        do i = 1, size(self%header%remarks)
            call self%warn(self%header%remarks(i)%text)
        end do
        named = product_of_file_name(path)
        product = self%header%product
        if (product == '') product = named
        if (named /= '' .and. named /= product) &
            call self%warn('the name of the file says '//named//', its header '//product//', which is taken')
        if (product == '') then
            call fail(error, self%path//': the header does not say which product this is, and the name does not begin with '// &
                      'one that is read and "_"; name the file like ACC1A_2023-06-01_C_04.txt')
            call self%close()
            return
        end if
        satellite = self%header%satellite
        if (scan(satellite, SATELLITES) == 0) satellite = satellite_of_file_name(path)
        call find_satellite(self, satellite)
        self%satellite = satellite
        call level1_layout(product, satellite_of_grace_fo(satellite), self%layout, error)
        if (allocated(error)) return
        if (self%header%binary .and. .not. self%layout%has_binary) then
            call fail(error, self%path//': '//product//' of this satellite has no binary form')
            call self%close()
            return
        end if
        call set_shape(self, 0_i8)
        self%not_finite = int(0*self%layout%fields%kind, i8)
    end subroutine open_reader

    !> The satellite that the first record of a text names among its first words, which decides between the forms of
    !> GRACE and GRACE-FO.
    subroutine find_satellite(self, satellite)
        class(level1_reader_t), intent(in) :: self
        character(1), intent(inout) :: satellite    !! Stays when no record tells

        integer, parameter :: MOST_WORDS = 4, BEGINNING = 200
        type(string_t), allocatable :: words(:)
        integer :: i

        if (self%header%binary) return
        words = split_words(self%buffer(self%at:min(self%filled, self%at + BEGINNING)))
        do i = 1, min(size(words), MOST_WORDS)
            if (len(words(i)%text) /= 1 .or. scan(words(i)%text, SATELLITES) == 0) cycle
            satellite = words(i)%text
            return
        end do
    end subroutine find_satellite

    !> Moves what is left to the beginning of the buffer and fills it up. Behind what is there stands a line feed.
    subroutine refill(self, error)
        class(level1_reader_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        integer :: left, got

        left = self%filled - self%at + 1
        if (left > 0 .and. self%at > 1) self%buffer(:left) = self%buffer(self%at:self%filled)
        self%base = self%base + self%at - 1
        self%at = 1
        self%filled = left
        call self%stream%read(self%buffer(left + 1:BUFFER_BYTES), got, error)
        self%filled = left + got
        self%at_end = self%filled < BUFFER_BYTES
        self%buffer(self%filled + 1:self%filled + 1) = LF
    end subroutine refill

    !> The next records, at most some thousand; none behind the last one. Fails at a record that is broken, with
    !> its line or byte, field, value and what is allowed; then the file is closed.
    subroutine next_block(self, block, error)
        class(level1_reader_t), intent(inout) :: self
        type(level1_block_t), intent(inout) :: block
        type(error_t), allocatable, intent(out) :: error

        integer :: columns

        block%count = 0
        columns = size(self%layout%fields)
        if (allocated(block%values)) then
            if (size(block%values, 2) /= columns) deallocate (block%values, block%seconds, block%fraction)
        end if
        if (.not. allocated(block%values)) &
            allocate (block%values(BLOCK_RECORDS, columns), block%seconds(BLOCK_RECORDS), block%fraction(BLOCK_RECORDS))
        if (.not. allocated(self%buffer) .or. (self%at_end .and. self%filled == 0)) return
        if (self%layout%shape > 0) block%values(:, self%layout%shape + 1:) = ieee_value(1.0_dp, ieee_quiet_nan)
        do
            if (self%header%binary) then
                call decode_binary(self, block, error)
            else
                call decode_text(self, block, error)
            end if
            if (allocated(error) .or. block%count == BLOCK_RECORDS) exit
            if (self%at_end) then
                if (block%count == 0) call finish(self)
                exit
            end if
            call refill(self, error)
            if (allocated(error)) exit
        end do
        if (allocated(error)) then
            call self%close()
            return
        end if
        if (block%count > 0) call take_time(self, block)
        self%records = self%records + block%count
    end subroutine next_block

    !> Time tags, satellites and time frames of decoded records.
    subroutine take_time(self, block)
        class(level1_reader_t), intent(inout) :: self
        type(level1_block_t), intent(inout) :: block

        associate (n => block%count, layout => self%layout)
            block%seconds(:n) = int(block%values(:n, 1), i8)
            block%fraction(:n) = 0
            if (layout%fraction > 0) block%fraction(:n) = block%values(:n, layout%fraction)*layout%fraction_unit
            if (self%records == 0) self%satellite = achar(nint(block%values(1, layout%id)))
            self%of_other_satellites = self%of_other_satellites + &
                count(abs(block%values(:n, layout%id) - iachar(self%satellite)) > 0)
            if (layout%time_ref == 0) return
            if (self%records == 0) self%time_ref = achar(nint(block%values(1, layout%time_ref)))
            self%of_other_time = self%of_other_time + &
                count(abs(block%values(:n, layout%time_ref) - iachar(self%time_ref)) > 0)
        end associate
    end subroutine take_time

    !> Decodes the complete lines of the buffer, as far as the block has room.
    subroutine decode_text(self, block, error)
        class(level1_reader_t), intent(inout) :: self
        type(level1_block_t), intent(inout) :: block
        type(error_t), allocatable, intent(out) :: error

        integer :: end_of_lines, field
        character(:), allocatable :: problem

        end_of_lines = self%filled + 1
        if (.not. self%at_end) then
            end_of_lines = index(self%buffer(self%at:self%filled), LF, back=.true.) + self%at - 1
            if (end_of_lines < self%at .and. self%filled - self%at + 1 > LONGEST_LINE) then
                call fail_in_file(error, self%path, self%line + 1, 'the line is longer than '// &
                                  integer_text(LONGEST_LINE)//' characters: this is no text file of records')
                return
            end if
        end if
        do while (block%count < BLOCK_RECORDS .and. self%at <= end_of_lines)
            call skip_white(self%buffer, self%at)
            if (self%buffer(self%at:self%at) == LF) then
                if (self%at <= self%filled) self%line = self%line + 1
                self%at = self%at + 1
                cycle
            end if
            block%count = block%count + 1
            call scan_record(self, self%buffer(:end_of_lines), block%values, block%count, field, problem)
            self%line = self%line + 1
            if (allocated(problem)) then
                call fail_at_field(self, field, problem, error)
                return
            end if
        end do
        self%at = min(self%at, self%filled + 1)
    end subroutine decode_text

    !> Decodes the record that begins at self%at, up to its line feed and beyond it.
    subroutine scan_record(self, text, values, record, field, problem)
        class(level1_reader_t), intent(inout) :: self
        character(*), intent(in) :: text                !! Ends with a line feed
        real(dp), intent(inout) :: values(:, :)
        integer, intent(in) :: record                   !! Its row
        integer, intent(out) :: field                   !! Where it is wrong
        character(:), allocatable, intent(out) :: problem   !! Allocated when it is wrong

        integer :: at, i

        at = self%at
        i = 0
        do while (i < size(self%there))
            i = i + 1
            field = self%there(i)
            call skip_white(text, at)
            if (text(at:at) == LF) then
                problem = 'the line ends here; '//integer_text(size(self%there))//' fields are expected'
                return
            end if
            call read_word(text, at, self%kind(i), values(record, field), problem)
            if (allocated(problem)) return
            if (ieee_is_nan(values(record, field))) self%not_finite(field) = self%not_finite(field) + 1
            if (field /= self%layout%shape) cycle
            call take_shape(self, int(values(record, field), i8), problem)
            if (allocated(problem)) return
        end do
        field = 0
        call skip_white(text, at)
        if (text(at:at) /= LF) then
            problem = '"'//word_at(text, at)//'" is more than the '//integer_text(size(self%there))// &
                ' fields that are expected'
            return
        end if
        call check_record(self, values, record, field, problem)
        self%at = at + 1
    end subroutine scan_record

    !> What holds in text and binary: satellite and time frame are told apart by value, a fraction of a second
    !> is less than one.
    subroutine check_record(self, values, record, field, problem)
        class(level1_reader_t), intent(in) :: self
        real(dp), intent(inout) :: values(:, :)
        integer, intent(in) :: record
        integer, intent(out) :: field                       !! Where it is wrong
        character(:), allocatable, intent(inout) :: problem !! Allocated when it is wrong

        character(1) :: id, frame

        field = self%layout%id
        id = achar(int(values(record, field)))
        if (self%layout%time_ref > 0) then
            frame = achar(int(values(record, self%layout%time_ref)))
            if (frame /= 'R' .and. frame /= 'G') then
                if (id == 'R' .or. id == 'G') then      ! the other order
                    values(record, [field, self%layout%time_ref]) = values(record, [self%layout%time_ref, field])
                    id = frame
                else
                    problem = '"'//printable(frame)//'" and "'//printable(id)//'": neither is a time frame, R or G'
                    return
                end if
            end if
        end if
        if (scan(id, SATELLITES) == 0) then
            problem = '"'//printable(id)//'" is no satellite; allowed are A, B, C and D'
            return
        end if
        field = self%layout%time_frac
        if (field > 0) then
            if (values(record, field) < 0 .or. values(record, field)*self%layout%fraction_unit >= 1) then
                problem = integer_text(int(values(record, field), i8))//' is no fraction of a second; allowed is 0 to '// &
                    integer_text(nint(1/self%layout%fraction_unit) - 1)
                return
            end if
        end if
    end subroutine check_record

    !> Takes the shape of a record, if it is another than that of the one before: prod_flag has no bits but those that
    !> stand for values, and there are no more channels than satellites of GPS.
    subroutine take_shape(self, shape, problem)
        class(level1_reader_t), intent(inout) :: self
        integer(i8), intent(in) :: shape                        !! prod_flag or the number of channels
        character(:), allocatable, intent(inout) :: problem     !! Allocated when it is wrong

        integer :: most

        if (shape == self%shape) return
        if (self%layout%prod_flag > 0) then
            most = maxval(self%layout%fields%bit)
            if (shiftr(shape, most + 1) /= 0) &
                problem = 'bits are set above bit '//integer_text(most)//', the last that stands for a value'
        else
            most = maxval(self%layout%fields%channel)
            if (shape < 0 .or. shape > most) &
                problem = integer_text(shape)//' is no number of channels; allowed is 0 to '//integer_text(most)
        end if
        if (.not. allocated(problem)) call set_shape(self, shape)
    end subroutine take_shape

    !> Which fields the records of a shape have, and where in binary.
    subroutine set_shape(self, shape)
        class(level1_reader_t), intent(inout) :: self
        integer(i8), intent(in) :: shape        !! prod_flag or the number of channels; 0: all records are alike

        integer :: i

        self%shape = shape
        associate (fields => self%layout%fields)
            self%there = pack([(i, i=1, size(fields))], fields%in_records_of(shape))
            self%kind = fields(self%there)%kind
            self%offset = [(sum(fields(self%there(:i - 1))%bytes), i=1, size(self%there))]
            self%length = sum(fields(self%there)%bytes)
        end associate
    end subroutine set_shape

    !> A failure at a field of the record before self%line (text) or at self%at (binary).
    subroutine fail_at_field(self, field, problem, error)
        class(level1_reader_t), intent(in) :: self
        integer, intent(in) :: field
        character(*), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: name
        integer :: last

        name = 'end of the record'
        if (field >= 1) name = 'field '//trim(self%layout%fields(field)%name)
        if (self%header%binary) then
            call fail(error, self%path//': byte '//integer_text(self%base + self%at)//', record '// &
                      integer_text(self%records + 1)//' of '//self%layout%product//', '//name//': '//problem)
        else
            last = self%at + scan(self%buffer(self%at:), LF) - 2
            call fail_in_file(error, self%path, self%line, name//' of '//self%layout%product//': '//problem, &
                              printable(self%buffer(self%at:last)))
        end if
    end subroutine fail_at_field

    !> Decodes the complete records of the buffer, as far as the block has room: those of equal shape together.
    subroutine decode_binary(self, block, error)
        class(level1_reader_t), intent(inout) :: self
        type(level1_block_t), intent(inout) :: block
        type(error_t), allocatable, intent(out) :: error

        integer :: run, field, i
        integer(i8) :: shape
        logical :: complete
        character(:), allocatable :: problem

        do while (block%count < BLOCK_RECORDS .and. self%at <= self%filled)
            call read_shape(self, self%at, shape, complete)
            if (complete) call take_shape(self, shape, problem)
            if (allocated(problem)) then
                self%records = self%records + block%count
                call fail_at_field(self, self%layout%shape, problem, error)
                return
            end if
            if (complete) complete = self%at + self%length - 1 <= self%filled
            if (.not. complete) then
                if (self%at_end) call fail(error, self%path//': byte '//integer_text(self%base + self%at)// &
                                           ': the file ends within record '// &
                                           integer_text(self%records + block%count + 1)//' of '//self%layout%product// &
                                           ', after '//integer_text(self%filled - self%at + 1)//' bytes of it')
                return
            end if
            run = records_alike(self, BLOCK_RECORDS - block%count)
            do i = 1, size(self%there)
                field = self%there(i)
                call read_bytes(self%buffer(self%at:self%at + run*self%length - 1), self%offset(i), self%length, &
                                self%kind(i), block%values(block%count + 1:block%count + run, field), &
                                self%not_finite(field))
            end do
            do i = 1, run
                call check_record(self, block%values, block%count + i, field, problem)
                if (allocated(problem)) then
                    self%at = self%at + (i - 1)*self%length
                    self%records = self%records + block%count + i - 1
                    call fail_at_field(self, field, problem, error)
                    return
                end if
            end do
            block%count = block%count + run
            self%at = self%at + run*self%length
        end do
    end subroutine decode_binary

    !> How many complete records from self%at on have the shape of the first.
    integer function records_alike(self, most) result(run)
        class(level1_reader_t), intent(in) :: self
        integer, intent(in) :: most

        integer(i8) :: shape
        integer :: room
        logical :: complete

        room = min(most, (self%filled - self%at + 1)/self%length)
        run = room
        if (self%layout%shape == 0) return
        do run = 1, room - 1
            call read_shape(self, self%at + run*self%length, shape, complete)
            if (.not. complete .or. shape /= self%shape) return
        end do
    end function records_alike

    !> prod_flag or number of channels of the binary record that begins at `at`.
    pure subroutine read_shape(self, at, shape, complete)
        class(level1_reader_t), intent(in) :: self
        integer, intent(in) :: at
        integer(i8), intent(out) :: shape   !! 0 for a product whose records are all alike
        logical, intent(out) :: complete    !! False when the buffer ends before

        integer :: first, last

        shape = 0
        complete = .true.
        if (self%layout%shape == 0) return
        first = at + self%offset(self%layout%shape)     ! what stands before it is in every record
        last = first + self%layout%fields(self%layout%shape)%bytes - 1
        complete = last <= self%filled
        if (complete) shape = unsigned_at(self%buffer(first:last))
    end subroutine read_shape

    !> Notes what is unusual about a whole file, behind its last record.
    subroutine finish(self)
        class(level1_reader_t), intent(inout) :: self

        character(1) :: named
        integer :: i

        if (self%header%records >= 0 .and. self%header%records /= self%records) &
            call self%warn('the header announces '//integer_text(self%header%records)//' records, the file has '// &
                           integer_text(self%records))
        if (self%records > 0) then
            if (scan(self%header%satellite, SATELLITES) == 1 .and. self%header%satellite /= self%satellite) &
                call self%warn('the header says satellite '//self%header%satellite//', the records say '// &
                               self%satellite//', which is taken')
            named = satellite_of_file_name(self%path)
            if (scan(named, SATELLITES) == 1 .and. named /= self%satellite) &
                call self%warn('the name of the file says satellite '//named//', the records say '//self%satellite// &
                               ', which is taken')
            if (self%of_other_satellites > 0) &
                call self%warn(integer_text(self%of_other_satellites)//' records are of another satellite than '// &
                               self%satellite//', that of the first')
            if (self%of_other_time > 0) &
                call self%warn(integer_text(self%of_other_time)//' records have another time frame than '// &
                               self%time_ref//', that of the first')
            if (index(self%layout%product, 'ACT') == 1 .and. self%satellite == 'D') &
                call self%warn(self%layout%product//' of satellite D is that of C transplanted, with other signs: it is no '// &
                               'measurement of D')
            if ((self%time_ref == 'R' .and. self%layout%product(5:5) == 'B') .or. &
                (self%time_ref == 'G' .and. self%layout%product(5:5) == 'A')) &
                call self%warn('the time frame '//self%time_ref//' is unusual for '//self%layout%product)
        end if
        do i = 1, size(self%not_finite)
            if (self%not_finite(i) > 0) &
                call self%warn(integer_text(self%not_finite(i))//' values of '//trim(self%layout%fields(i)%name)// &
                               ' are no finite numbers: they are taken as missing')
        end do
        call self%close()
    end subroutine finish

    !> Notes what is unusual.
    subroutine warn(self, text)
        class(level1_reader_t), intent(inout) :: self
        character(*), intent(in) :: text    !! One sentence, without the name of the file

        call append(self%warnings, text)
    end subroutine warn

    !> Ends it; header, layout and warnings stay.
    subroutine close_reader(self)
        class(level1_reader_t), intent(inout) :: self

        call self%stream%close()
        self%at = 1
        self%filled = 0
        self%at_end = .true.
    end subroutine close_reader
end module gracecg_level1_reader
