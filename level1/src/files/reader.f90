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
    use, intrinsic :: iso_fortran_env, only: real32
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use gracecg_base_kinds, only: dp, i4, i8
    use gracecg_base_error, only: error_t, fail, fail_in_file
    use gracecg_base_text, only: string_t, append, integer_text, lower_case
    use gracecg_base_decimal, only: scan_real, scan_integer, is_white
    use gracecg_files_file, only: input_stream_t
    use gracecg_level1_products, only: level1_layout_t, level1_layout, satellite_of_grace_fo, SATELLITES, &
        KIND_I1, KIND_I2, KIND_I4, KIND_U1, KIND_U2, KIND_U4, KIND_F4, KIND_F8, KIND_LETTER, KIND_NUMERAL, &
        KIND_FLAG8, KIND_FLAG32
    use gracecg_level1_header, only: level1_header_t, parse_level1_header, product_of_file_name, &
        satellite_of_file_name
    implicit none
    private
    public :: level1_reader_t, level1_block_t, BLOCK_RECORDS

    integer, parameter :: BUFFER_BYTES = 2**21      !! Read at once; a header must fit in
    integer, parameter :: LONGEST_LINE = 16384      !! Of a text file, behind the header
    integer, parameter :: BLOCK_RECORDS = 1024      !! Records that are decoded at once
    character(1), parameter :: LF = achar(10), CR = achar(13)

    !> Range of the integers of each kind. A block number of GRACE-FO text exceeds the 16 bits of GRACE
    integer(i8), parameter :: LOWEST(12) = [-128_i8, -32768_i8, -2147483648_i8, 0_i8, 0_i8, 0_i8, 0_i8, 0_i8, 0_i8, &
                                            0_i8, 0_i8, 0_i8]
    integer(i8), parameter :: HIGHEST(12) = [127_i8, 32767_i8, 2147483647_i8, 255_i8, 4294967295_i8, 4294967295_i8, &
                                             0_i8, 0_i8, 0_i8, 9_i8, 255_i8, 4294967295_i8]

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
        type(input_stream_t), private :: stream
        character(:), allocatable, private :: buffer
        integer, private :: at = 1          !! Next byte in buffer to decode
        integer, private :: filled = 0      !! Bytes of the buffer that are there
        logical, private :: at_end = .true. !! The stream has no more bytes
        integer(i8), private :: base = 0    !! Bytes of the file before the buffer
        integer, private :: line = 0        !! Lines before `at`
        integer, allocatable, private :: kind(:), bit(:), channel(:)    !! Of the fields
        integer(i8), private :: shape = -1  !! Of the record below: prod_flag or number of channels
        integer, allocatable, private :: offset(:)  !! Of each field in a binary record; -1: not there
        integer, private :: length = 0              !! Bytes of a binary record
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
        if (allocated(self%warnings)) deallocate (self%warnings)
        allocate (self%warnings(0))
        self%records = 0
        self%of_other_satellites = 0
        self%of_other_time = 0
        self%time_ref = ''
        self%shape = -1
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
            call fail(error, self%path//': neither header nor name say which product this is; name the file like '// &
                      'ACC1A_2023-06-01_C_04.txt')
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
        self%kind = self%layout%fields%kind
        self%bit = self%layout%fields%bit
        self%channel = self%layout%fields%channel
        self%offset = self%kind
        self%not_finite = int(0*self%kind, i8)
    end subroutine open_reader

    !> The satellite that the first record of a text names, which decides between the forms of GRACE and GRACE-FO.
    subroutine find_satellite(self, satellite)
        class(level1_reader_t), intent(inout) :: self
        character(1), intent(inout) :: satellite    !! Stays when no record tells

        integer, parameter :: MOST_WORDS = 4
        integer :: i, words
        character(1) :: letter

        if (self%header%binary) return
        words = 0
        do i = self%at, self%filled
            letter = self%buffer(i:i)
            if (is_white(letter) .or. letter == LF) cycle
            if (i > self%at) then
                if (.not. (is_white(self%buffer(i - 1:i - 1)) .or. self%buffer(i - 1:i - 1) == LF)) cycle
            end if
            words = words + 1
            if (words > MOST_WORDS) return
            if (i == self%filled) return
            if (.not. is_white(self%buffer(i + 1:i + 1))) cycle
            if (scan(letter, SATELLITES) == 0) cycle
            satellite = letter
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

        integer :: first, columns

        block%count = 0
        columns = size(self%layout%fields)
        if (allocated(block%values)) then
            if (size(block%values, 2) /= columns) deallocate (block%values, block%seconds, block%fraction)
        end if
        if (.not. allocated(block%values)) &
            allocate (block%values(BLOCK_RECORDS, columns), block%seconds(BLOCK_RECORDS), block%fraction(BLOCK_RECORDS))
        if (.not. allocated(self%buffer) .or. (self%at_end .and. self%filled == 0)) return
        do
            first = block%count
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

        real(dp) :: letter
        integer :: i

        associate (n => block%count)
            block%seconds(:n) = int(block%values(:n, 1), i8)
            block%fraction(:n) = 0
            if (self%layout%fraction > 0) &
                block%fraction(:n) = block%values(:n, self%layout%fraction)*self%layout%fraction_unit
            if (self%records == 0) then
                self%satellite = achar(nint(block%values(1, self%layout%id)))
                if (self%layout%time_ref > 0) self%time_ref = achar(nint(block%values(1, self%layout%time_ref)))
            end if
            letter = iachar(self%satellite)
            do i = 1, n
                if (abs(block%values(i, self%layout%id) - letter) > 0) &
                    self%of_other_satellites = self%of_other_satellites + 1
            end do
            if (self%layout%time_ref > 0) then
                letter = iachar(self%time_ref)
                do i = 1, n
                    if (abs(block%values(i, self%layout%time_ref) - letter) > 0) &
                        self%of_other_time = self%of_other_time + 1
                end do
            end if
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
            do while (is_white(self%buffer(self%at:self%at)))
                self%at = self%at + 1
            end do
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

        integer :: at, first, kind
        integer(i8) :: flag, number
        real(dp) :: value, missing
        logical :: ok

        missing = ieee_value(1.0_dp, ieee_quiet_nan)
        at = self%at
        flag = 0
        do field = 1, size(self%kind)
            if (self%bit(field) >= 0) then
                if (.not. btest(flag, self%bit(field))) then
                    values(record, field) = missing
                    cycle
                end if
            else if (self%channel(field) > 0) then
                if (self%channel(field) > flag) then
                    values(record, field) = missing
                    cycle
                end if
            end if
            do while (is_white(text(at:at)))
                at = at + 1
            end do
            if (text(at:at) == LF) then
                problem = 'the line ends here; '//integer_text(fields_of(self, flag))//' fields are expected'
                return
            end if
            first = at
            kind = self%kind(field)
            select case (kind)
            case (KIND_F8, KIND_F4)
                call scan_real(text, at, value, ok)
                if (.not. ok) then
                    if (.not. is_no_number(text(first:at - 1))) then
                        problem = '"'//shown(text(first:at - 1))//'" is not a decimal number'
                        return
                    end if
                    value = missing
                    self%not_finite(field) = self%not_finite(field) + 1
                end if
            case (KIND_LETTER)
                value = iachar(text(at:at))
                at = at + 1
                ok = value >= iachar('A') .and. value <= iachar('Z')
                if (ok) ok = is_white(text(at:at)) .or. text(at:at) == LF
                if (.not. ok) then
                    problem = '"'//word_at(text, first)//'" is not one letter, A to Z'
                    return
                end if
            case (KIND_FLAG8, KIND_FLAG32)
                call scan_flag(text, at, merge(8, 32, kind == KIND_FLAG8), number, ok)
                if (.not. ok) then
                    problem = '"'//word_at(text, first)//'" is not a flag of '// &
                        integer_text(merge(8, 32, kind == KIND_FLAG8))//' binary digits'
                    return
                end if
                value = real(number, dp)
            case default
                call scan_integer(text, at, number, ok)
                if (ok) ok = number >= LOWEST(kind) .and. number <= HIGHEST(kind)
                if (.not. ok) then
                    problem = '"'//word_at(text, first)//'" is not an integer from '// &
                        integer_text(LOWEST(kind))//' to '//integer_text(HIGHEST(kind))
                    return
                end if
                value = real(number, dp)
            end select
            values(record, field) = value
            if (field == self%layout%prod_flag .or. field == self%layout%channels) then
                flag = int(value, i8)
                call check_shape(self, flag, problem)
                if (allocated(problem)) return
            end if
        end do
        do while (is_white(text(at:at)))
            at = at + 1
        end do
        if (text(at:at) /= LF) then
            problem = '"'//word_at(text, at)//'" is more than the '//integer_text(fields_of(self, flag))// &
                ' fields that are expected'
            return
        end if
        call check_record(self, values, record, field, problem)
        self%at = at + 1
    end subroutine scan_record

    !> Flags of so many binary digits, bit 0 rightmost.
    pure subroutine scan_flag(text, at, digits, number, ok)
        character(*), intent(in) :: text
        integer, intent(inout) :: at
        integer, intent(in) :: digits
        integer(i8), intent(out) :: number
        logical, intent(out) :: ok

        integer :: i, digit

        number = 0
        ok = .false.
        do i = 1, digits
            digit = iachar(text(at:at)) - iachar('0')
            if (digit < 0 .or. digit > 1) return
            number = 2*number + digit
            at = at + 1
        end do
        ok = is_white(text(at:at)) .or. text(at:at) == LF
    end subroutine scan_flag

    !> How many fields a record with this prod_flag or number of channels has.
    pure integer function fields_of(self, flag) result(n)
        class(level1_reader_t), intent(in) :: self
        integer(i8), intent(in) :: flag

        integer :: i

        n = 0
        do i = 1, size(self%kind)
            if (self%bit(i) >= 0) then
                if (.not. btest(flag, self%bit(i))) cycle
            else if (self%channel(i) > flag) then
                cycle
            end if
            n = n + 1
        end do
    end function fields_of

    !> Whether a word stands for a value that is no finite number, as programs print it.
    pure logical function is_no_number(word)
        character(*), intent(in) :: word

        is_no_number = .false.
        if (len(word) > 4) return
        is_no_number = any(lower_case(word) == [character(4) :: 'nan', '+nan', '-nan', 'inf', '+inf', '-inf'])
    end function is_no_number

    pure integer function word_end(text, first) result(last)
        character(*), intent(in) :: text
        integer, intent(in) :: first

        last = first
        do while (.not. (is_white(text(last:last)) .or. text(last:last) == LF) .and. last < first + 60)
            last = last + 1
            if (last > len(text)) exit
        end do
        last = last - 1
    end function word_end

    !> The word that begins there, for a message.
    pure function word_at(text, first) result(word)
        character(*), intent(in) :: text
        integer, intent(in) :: first
        character(word_end(text, first) - first + 1) :: word

        word = shown(text(first:first + len(word) - 1))
    end function word_at

    !> A text for a message: bytes that are no printable characters as question marks, at most 200.
    pure function shown(text) result(printable)
        character(*), intent(in) :: text
        character(min(len(text), 200)) :: printable

        integer :: i

        do i = 1, len(printable)
            printable(i:i) = text(i:i)
            if (iachar(text(i:i)) < 32 .or. iachar(text(i:i)) > 126) printable(i:i) = '?'
        end do
    end function shown

    !> What holds in text and binary: satellite and time frame are told apart by value, a fraction of a second
    !> is less than one.
    subroutine check_record(self, values, record, field, problem)
        class(level1_reader_t), intent(in) :: self
        real(dp), intent(inout) :: values(:, :)
        integer, intent(in) :: record
        integer, intent(out) :: field                       !! Where it is wrong
        character(:), allocatable, intent(inout) :: problem !! Allocated when it is wrong

        character(1) :: id, frame
        real(dp) :: swap

        field = self%layout%id
        id = achar(int(values(record, field)))
        if (self%layout%time_ref > 0) then
            frame = achar(int(values(record, self%layout%time_ref)))
            if (frame /= 'R' .and. frame /= 'G') then
                if (id == 'R' .or. id == 'G') then      ! the other order
                    swap = values(record, field)
                    values(record, field) = values(record, self%layout%time_ref)
                    values(record, self%layout%time_ref) = swap
                    id = frame
                else
                    problem = '"'//shown(frame)//'" and "'//shown(id)//'": neither is a time frame, R or G'
                    return
                end if
            end if
        end if
        if (id /= 'A' .and. id /= 'B' .and. id /= 'C' .and. id /= 'D') then
            problem = '"'//shown(id)//'" is no satellite; allowed are A, B, C and D'
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

    !> prod_flag has no bits but those that stand for values; there are no more channels than satellites of GPS.
    subroutine check_shape(self, shape, problem)
        class(level1_reader_t), intent(in) :: self
        integer(i8), intent(in) :: shape                        !! prod_flag or the number of channels
        character(:), allocatable, intent(inout) :: problem     !! Allocated when it is wrong

        if (self%layout%prod_flag > 0) then
            if (shiftr(shape, maxval(self%bit) + 1) /= 0) &
                problem = 'bits are set above bit '//integer_text(maxval(self%bit))//', the last that stands for a value'
        else if (shape < 0 .or. shape > maxval(self%channel)) then
            problem = integer_text(shape)//' is no number of channels; allowed is 0 to '// &
                integer_text(maxval(self%channel))
        end if
    end subroutine check_shape

    !> A failure at a field of the record before self%line (text) or at self%at (binary).
    subroutine fail_at_field(self, field, problem, error)
        class(level1_reader_t), intent(in) :: self
        integer, intent(in) :: field
        character(*), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: name
        integer :: last

        name = 'end of the record'
        if (field >= 1 .and. field <= size(self%kind)) name = 'field '//trim(self%layout%fields(field)%name)
        if (self%header%binary) then
            call fail(error, self%path//': byte '//integer_text(self%base + self%at)//', record '// &
                      integer_text(self%records + 1)//' of '//self%layout%product//', '//name//': '//problem)
        else
            last = self%at + scan(self%buffer(self%at:), LF) - 2
            call fail_in_file(error, self%path, self%line, name//' of '//self%layout%product//': '//problem, &
                              shown(self%buffer(self%at:last)))
        end if
    end subroutine fail_at_field

    !> Decodes the complete records of the buffer, as far as the block has room: those of equal shape together.
    subroutine decode_binary(self, block, error)
        class(level1_reader_t), intent(inout) :: self
        type(level1_block_t), intent(inout) :: block
        type(error_t), allocatable, intent(out) :: error

        integer :: run, at, field, i
        integer(i8) :: shape
        logical :: complete
        character(:), allocatable :: problem

        do while (block%count < BLOCK_RECORDS .and. self%at <= self%filled)
            call read_shape(self, self%at, shape, complete)
            if (complete) then
                if (shape /= self%shape) call set_shape(self, shape, problem, field)
                if (allocated(problem)) then
                    call fail_at_field(self, field, problem, error)
                    return
                end if
                complete = self%at + self%length - 1 <= self%filled
            end if
            if (.not. complete) then
                if (self%at_end) call fail(error, self%path//': byte '//integer_text(self%base + self%at)// &
                                           ': the file ends within record '// &
                                           integer_text(self%records + block%count + 1)//' of '//self%layout%product// &
                                           ', after '//integer_text(self%filled - self%at + 1)//' bytes of it')
                return
            end if
            run = 1
            at = self%at + self%length
            do while (run < BLOCK_RECORDS - block%count .and. at + self%length - 1 <= self%filled)
                if (self%layout%prod_flag > 0 .or. self%layout%channels > 0) then
                    call read_shape(self, at, shape, complete)
                    if (.not. complete .or. shape /= self%shape) exit
                end if
                run = run + 1
                at = at + self%length
            end do
            do field = 1, size(self%kind)
                call decode_field(self%buffer(self%at:at - 1), self%offset(field), self%length, self%kind(field), &
                                  block%values(block%count + 1:block%count + run, field), self%not_finite(field))
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
            self%at = at
        end do
    end subroutine decode_binary

    !> prod_flag or number of channels of the binary record that begins at `at`.
    pure subroutine read_shape(self, at, shape, complete)
        class(level1_reader_t), intent(in) :: self
        integer, intent(in) :: at
        integer(i8), intent(out) :: shape   !! 0 for a product whose records are all alike
        logical, intent(out) :: complete    !! False when the buffer ends before

        integer :: field, first, bytes

        shape = 0
        complete = .true.
        field = max(self%layout%prod_flag, self%layout%channels)
        if (field == 0) return
        first = at + sum(self%layout%fields(:field - 1)%bytes)
        bytes = self%layout%fields(field)%bytes
        complete = first + bytes - 1 <= self%filled
        if (complete) shape = word_of(self%buffer(first:first + bytes - 1))
    end subroutine read_shape

    !> An unsigned integer of up to eight bytes, most significant first.
    pure integer(i8) function word_of(bytes) result(word)
        character(*), intent(in) :: bytes

        integer :: i

        word = 0
        do i = 1, len(bytes)
            word = ior(shiftl(word, 8), int(iachar(bytes(i:i)), i8))
        end do
    end function word_of

    !> Where the fields of records of a shape stand.
    subroutine set_shape(self, shape, problem, field)
        class(level1_reader_t), intent(inout) :: self
        integer(i8), intent(in) :: shape
        character(:), allocatable, intent(inout) :: problem
        integer, intent(out) :: field           !! Where a problem is

        integer :: i

        field = max(self%layout%prod_flag, self%layout%channels)
        if (field > 0) call check_shape(self, shape, problem)
        if (allocated(problem)) return
        self%shape = shape
        self%length = 0
        do i = 1, size(self%kind)
            self%offset(i) = -1
            if (self%bit(i) >= 0) then
                if (.not. btest(shape, self%bit(i))) cycle
            else if (self%channel(i) > shape) then
                cycle
            end if
            self%offset(i) = self%length
            self%length = self%length + self%layout%fields(i)%bytes
        end do
    end subroutine set_shape

    !> One field of records of equal length, one after the other.
    subroutine decode_field(bytes, offset, length, kind, values, not_finite)
        character(*), intent(in) :: bytes           !! The records
        integer, intent(in) :: offset, length       !! Of the field in a record, and of a record; offset -1: not there
        integer, intent(in) :: kind
        real(dp), intent(out) :: values(:)          !! As many as records
        integer(i8), intent(inout) :: not_finite    !! Counts the values that are no finite numbers

        integer :: i, at
        integer(i4) :: word4
        integer(i8) :: word8
        real(dp) :: missing

        missing = ieee_value(1.0_dp, ieee_quiet_nan)
        if (offset < 0) then
            values = missing
            return
        end if
        at = offset + 1
        select case (kind)
        case (KIND_F8)
            do i = 1, size(values)
                word8 = ior(shiftl(ior(ior(shiftl(iachar(bytes(at:at)), 24), shiftl(iachar(bytes(at + 1:at + 1)), 16)), &
                                       ior(shiftl(iachar(bytes(at + 2:at + 2)), 8), iachar(bytes(at + 3:at + 3)))) &
                                   *1_i8, 32), &
                            iand(ior(ior(shiftl(iachar(bytes(at + 4:at + 4)), 24), &
                                         shiftl(iachar(bytes(at + 5:at + 5)), 16)), &
                                     ior(shiftl(iachar(bytes(at + 6:at + 6)), 8), iachar(bytes(at + 7:at + 7))))*1_i8, &
                                 4294967295_i8))
                values(i) = transfer(word8, 1.0_dp)
                if (iand(shiftr(word8, 52), 2047_i8) == 2047) then
                    values(i) = missing
                    not_finite = not_finite + 1
                end if
                at = at + length
            end do
        case (KIND_F4)
            do i = 1, size(values)
                word4 = ior(ior(shiftl(iachar(bytes(at:at)), 24), shiftl(iachar(bytes(at + 1:at + 1)), 16)), &
                            ior(shiftl(iachar(bytes(at + 2:at + 2)), 8), iachar(bytes(at + 3:at + 3))))
                if (iand(shiftr(word4, 23), 255) == 255) then
                    values(i) = missing
                    not_finite = not_finite + 1
                else
                    values(i) = real(transfer(word4, 1.0_real32), dp)
                end if
                at = at + length
            end do
        case (KIND_I4, KIND_U4, KIND_FLAG32)
            do i = 1, size(values)
                word4 = ior(ior(shiftl(iachar(bytes(at:at)), 24), shiftl(iachar(bytes(at + 1:at + 1)), 16)), &
                            ior(shiftl(iachar(bytes(at + 2:at + 2)), 8), iachar(bytes(at + 3:at + 3))))
                values(i) = word4
                if (kind /= KIND_I4 .and. word4 < 0) values(i) = values(i) + 4294967296.0_dp
                at = at + length
            end do
        case (KIND_I2, KIND_U2)
            do i = 1, size(values)
                values(i) = ior(shiftl(iachar(bytes(at:at)), 8), iachar(bytes(at + 1:at + 1)))
                if (kind == KIND_I2 .and. values(i) >= 32768) values(i) = values(i) - 65536
                at = at + length
            end do
        case (KIND_NUMERAL)
            do i = 1, size(values)
                values(i) = iachar(bytes(at:at)) - iachar('0')
                at = at + length
            end do
        case default
            do i = 1, size(values)
                values(i) = iachar(bytes(at:at))
                if (kind == KIND_I1 .and. values(i) >= 128) values(i) = values(i) - 256
                at = at + length
            end do
        end select
    end subroutine decode_field

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
