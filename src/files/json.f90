!> JSON (RFC 8259): a writer of objects, arrays and values, and a reader of the lists of texts that the
!> program leaves beside its tables.
!>
!> Numbers are written so that they read back exactly. JSON has no NaN and no infinity: such a number is a
!> failure that `finish` reports with its key; what has no value is written by `nothing`, as null.
module gracecg_files_json
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append, integer_text, real_text, parse_real
    implicit none
    private
    public :: json_writer_t, json_quoted, read_json_list, read_json_numbers, read_json_text

    integer, parameter :: DEEPEST = 16          !! Objects and arrays within each other
    integer, parameter :: INDENT = 2            !! Blanks a level
    character(1), parameter :: LF = achar(10), QUOTE = '"', BACKSLASH = achar(92)
    character(4), parameter :: SPACES = ' '//achar(9)//LF//achar(13)
    !! What may stand between the pieces of a JSON text
    character(*), parameter :: HEX = '0123456789abcdef'

    type :: json_writer_t
        !! A JSON text in the making: begin, members, end, and last finish. In an array the keys are empty.
        private
        character(:), allocatable :: buffer
        integer :: length = 0                   !! Of the buffer's part that is in use
        integer :: depth = 0
        logical :: is_array(DEEPEST) = .false., is_empty(DEEPEST) = .true., on_one_line(DEEPEST) = .false.
        type(error_t), allocatable :: failure   !! The first thing that went wrong
    contains
        procedure :: begin => begin_object      !! Begins an object
        procedure :: begin_array                !! Begins an array
        procedure :: end => end_level           !! Ends the object or array that was begun last
        generic :: member => text_member, real_member, integer_member, long_integer_member, logical_member, &
            reals_member, matrix_member, texts_member, names_member     !! A value with its key
        procedure :: nothing                    !! A member without value: null
        procedure :: raw                        !! A member that is JSON already: a number's digits, true
        procedure :: finish                     !! The whole text
        procedure, private :: text_member, real_member, integer_member, long_integer_member, logical_member
        procedure, private :: reals_member, matrix_member, texts_member, names_member
        procedure, private :: put, open_member, open_level
    end type json_writer_t

contains

    !> Begins an object, the outermost one or a member.
    subroutine begin_object(self, key, on_one_line)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in), optional :: key           !! Absent or empty: the outermost, or in an array
        logical, intent(in), optional :: on_one_line        !! All of it in one line

        call self%open_level(.false., key, on_one_line)
    end subroutine begin_object

    !> Begins an array.
    subroutine begin_array(self, key, on_one_line)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in), optional :: key           !! As of begin
        logical, intent(in), optional :: on_one_line        !! As of begin

        call self%open_level(.true., key, on_one_line)
    end subroutine begin_array

    subroutine open_level(self, is_array, key, on_one_line)
        class(json_writer_t), intent(inout) :: self
        logical, intent(in) :: is_array
        character(*), intent(in), optional :: key
        logical, intent(in), optional :: on_one_line

        logical :: one_line

        if (self%depth == DEEPEST) then
            if (.not. allocated(self%failure)) call fail(self%failure, 'JSON: more than '//integer_text(DEEPEST)// &
                                                         ' objects within each other')
            return
        end if
        one_line = .false.
        if (self%depth > 0) then
            one_line = self%on_one_line(self%depth)
            if (present(key)) then
                call self%open_member(key)
            else
                call self%open_member('')
            end if
        end if
        if (present(on_one_line)) one_line = one_line .or. on_one_line
        self%depth = self%depth + 1
        self%is_array(self%depth) = is_array
        self%is_empty(self%depth) = .true.
        self%on_one_line(self%depth) = one_line
        call self%put(merge('[', '{', is_array))
    end subroutine open_level

    !> Ends the object or array that was begun last.
    subroutine end_level(self)
        class(json_writer_t), intent(inout) :: self

        associate (depth => self%depth)
            if (depth == 0) return
            if (.not. self%on_one_line(depth) .and. .not. self%is_empty(depth)) &
                call self%put(LF//repeat(' ', INDENT*(depth - 1)))
            call self%put(merge(']', '}', self%is_array(depth)))
            depth = depth - 1
        end associate
    end subroutine end_level

    !> Comma, line and key of the next member.
    subroutine open_member(self, key)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key

        associate (depth => self%depth)
            if (.not. self%is_empty(depth)) call self%put(',')
            if (.not. self%on_one_line(depth)) then
                call self%put(LF//repeat(' ', INDENT*depth))
            else if (.not. self%is_empty(depth)) then
                call self%put(' ')
            end if
            self%is_empty(depth) = .false.
            if (.not. self%is_array(depth)) call self%put(json_quoted(key)//': ')
        end associate
    end subroutine open_member

    subroutine text_member(self, key, value)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, value

        call self%raw(key, json_quoted(value))
    end subroutine text_member

    subroutine texts_member(self, key, value)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        type(string_t), intent(in) :: value(:)

        integer :: i

        call self%begin_array(key)
        do i = 1, size(value)
            call self%member('', value(i)%text)
        end do
        call self%end()
    end subroutine texts_member

    !> Texts without the blanks behind them, in one line.
    subroutine names_member(self, key, value)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, value(:)

        integer :: i

        call self%begin_array(key, on_one_line=.true.)
        do i = 1, size(value)
            call self%member('', trim(value(i)))
        end do
        call self%end()
    end subroutine names_member

    subroutine real_member(self, key, value)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        real(dp), intent(in) :: value

        if (ieee_is_finite(value)) then
            call self%raw(key, real_text(value))
        else
            call self%nothing(key)
            if (.not. allocated(self%failure)) call fail(self%failure, key//': the result is not a finite number')
        end if
    end subroutine real_member

    subroutine reals_member(self, key, value)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        real(dp), intent(in) :: value(:)

        integer :: i

        call self%begin_array(key, on_one_line=.true.)
        do i = 1, size(value)
            call self%member(key, value(i))
        end do
        call self%end()
    end subroutine reals_member

    !> Row by row.
    subroutine matrix_member(self, key, value)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        real(dp), intent(in) :: value(:, :)

        integer :: i

        call self%begin_array(key)
        do i = 1, size(value, 1)
            call self%member(key, value(i, :))
        end do
        call self%end()
    end subroutine matrix_member

    subroutine integer_member(self, key, value)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        integer, intent(in) :: value

        call self%raw(key, integer_text(value))
    end subroutine integer_member

    subroutine long_integer_member(self, key, value)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        integer(i8), intent(in) :: value

        call self%raw(key, integer_text(value))
    end subroutine long_integer_member

    subroutine logical_member(self, key, value)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        logical, intent(in) :: value

        call self%raw(key, trim(merge('true ', 'false', value)))
    end subroutine logical_member

    !> A member without value.
    subroutine nothing(self, key)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key     !! Empty in an array

        call self%raw(key, 'null')
    end subroutine nothing

    !> A member whose value is JSON already.
    subroutine raw(self, key, value)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: key     !! Empty in an array
        character(*), intent(in) :: value   !! Its digits, true, a text with quotes

        call self%open_member(key)
        call self%put(value)
    end subroutine raw

    !> The whole text, without a line end. Fails when a number was not finite, or something begun was not ended.
    subroutine finish(self, text, error)
        class(json_writer_t), intent(inout) :: self
        character(:), allocatable, intent(out) :: text      !! The whole of the JSON text
        type(error_t), allocatable, intent(out) :: error

        text = ''
        if (allocated(self%failure)) then
            error = self%failure
        else if (self%depth > 0) then
            call fail(error, 'JSON: '//integer_text(self%depth)//' objects or arrays were not ended')
        else
            text = self%buffer(:self%length)
        end if
    end subroutine finish

    subroutine put(self, text)
        class(json_writer_t), intent(inout) :: self
        character(*), intent(in) :: text

        integer, parameter :: SMALLEST = 4096
        character(:), allocatable :: longer

        if (.not. allocated(self%buffer)) allocate (character(SMALLEST) :: self%buffer)
        if (self%length + len(text) > len(self%buffer)) then
            allocate (character(2*(self%length + len(text))) :: longer)
            longer(:self%length) = self%buffer(:self%length)
            call move_alloc(longer, self%buffer)
        end if
        self%buffer(self%length + 1:self%length + len(text)) = text
        self%length = self%length + len(text)
    end subroutine put

    pure integer function quoted_length(text) result(length)
        character(*), intent(in) :: text

        integer :: i

        length = len(text) + 2
        do i = 1, len(text)
            if (text(i:i) == QUOTE .or. text(i:i) == BACKSLASH) length = length + 1
            if (iachar(text(i:i)) < 32) length = length + 5
        end do
    end function quoted_length

    !> A text in quotes, with what JSON wants escaped. Bytes beyond ASCII stay: they are UTF-8.
    pure function json_quoted(text) result(json)
        character(*), intent(in) :: text        !! Any
        character(quoted_length(text)) :: json

        integer :: i, n, code

        json(1:1) = QUOTE
        n = 1
        do i = 1, len(text)
            code = iachar(text(i:i))
            if (text(i:i) == QUOTE .or. text(i:i) == BACKSLASH) then
                json(n + 1:n + 2) = BACKSLASH//text(i:i)
                n = n + 2
            else if (code < 32) then
                json(n + 1:n + 6) = BACKSLASH//'u00'//HEX(code/16 + 1:code/16 + 1)// &
                                    HEX(mod(code, 16) + 1:mod(code, 16) + 1)
                n = n + 6
            else
                json(n + 1:n + 1) = text(i:i)
                n = n + 1
            end if
        end do
        json(n + 1:) = QUOTE
    end function json_quoted

    !> The texts of the array that is the member `key` of the outermost object. Not ok: there is no such
    !> array of texts.
    subroutine read_json_list(text, key, list, ok)
        character(*), intent(in) :: text        !! A JSON text
        character(*), intent(in) :: key         !! Of the list
        type(string_t), allocatable, intent(out) :: list(:)
        logical, intent(out) :: ok              !! There is such a list

        character(:), allocatable :: piece
        integer :: position, depth
        logical :: found

        allocate (list(0))
        ok = .false.
        found = .false.
        position = 1
        depth = 0
        do      ! to the array
            call skip_spaces(text, position)
            if (position > len(text)) return
            select case (text(position:position))
            case (QUOTE)
                call read_quoted(text, position, piece, ok)
                if (.not. ok) return
                ok = .false.
                call skip_spaces(text, position)
                if (position > len(text)) return
                found = depth == 1 .and. piece == key .and. text(position:position) == ':'
                if (.not. found) cycle
                position = position + 1
                call skip_spaces(text, position)
                exit
            case ('{', '[')
                depth = depth + 1
            case ('}', ']')
                depth = depth - 1
            end select
            position = position + 1
        end do
        if (text(min(position, len(text)):min(position, len(text))) /= '[') return
        position = position + 1
        do      ! its texts
            call skip_spaces(text, position)
            if (position > len(text)) return
            if (text(position:position) == ']') exit
            call read_quoted(text, position, piece, ok)
            if (.not. ok) return
            ok = .false.
            call append(list, piece)
            call skip_spaces(text, position)
            if (position > len(text)) return
            if (text(position:position) == ',') position = position + 1
        end do
        ok = .true.
    end subroutine read_json_list

    !> All numbers of a member, row by row where it is an array of arrays. Not ok: there is no such member, or it holds
    !> something else.
    subroutine read_json_numbers(text, path, values, ok)
        character(*), intent(in) :: text        !! A JSON text
        character(*), intent(in) :: path        !! Keys from the outermost object on, with points: 'noise.level'
        real(dp), allocatable, intent(out) :: values(:)    !! The numbers; none when not ok
        logical, intent(out) :: ok              !! There are such numbers

        real(dp), allocatable :: grown(:)
        real(dp) :: value
        integer :: position, first, last, start, count

        allocate (values(16))
        count = 0
        call find_json_member(text, path, first, last, ok)
        position = first
        do while (ok .and. position <= last)
            if (index(SPACES//'[],', text(position:position)) > 0) then
                position = position + 1
                cycle
            end if
            start = position
            do while (position <= last)
                if (index(SPACES//'[],', text(position:position)) > 0) exit
                position = position + 1
            end do
            call parse_real(text(start:position - 1), value, ok)
            if (.not. ok) exit
            if (count == size(values)) then
                allocate (grown(2*count))
                grown(:count) = values
                call move_alloc(grown, values)
            end if
            count = count + 1
            values(count) = value
        end do
        values = values(:count)
        ok = ok .and. count > 0
    end subroutine read_json_numbers

    !> The text of a member. Not ok: there is no such member, or it is no text.
    subroutine read_json_text(text, path, value, ok)
        character(*), intent(in) :: text        !! A JSON text
        character(*), intent(in) :: path        !! As of read_json_numbers
        character(:), allocatable, intent(out) :: value    !! The text; empty when not ok
        logical, intent(out) :: ok              !! There is such a text

        integer :: first, last

        value = ''
        call find_json_member(text, path, first, last, ok)
        if (ok) call read_quoted(text, first, value, ok)
    end subroutine read_json_text

    !> Where the value of a member stands.
    subroutine find_json_member(text, path, first, last, ok)
        character(*), intent(in) :: text, path
        integer, intent(out) :: first, last     !! In the text
        logical, intent(out) :: ok              !! There is such a member

        integer :: start, dot, begin, end

        first = 1
        last = len(text)
        start = 1
        do
            dot = start - 1 + index(path(start:)//'.', '.')
            call find_key(text(first:last), path(start:dot - 1), begin, end, ok)
            if (.not. ok) return
            last = first - 1 + end
            first = first - 1 + begin
            if (dot > len(path)) return
            start = dot + 1
        end do
    end subroutine find_json_member

    !> Where the value of a key of an object stands.
    subroutine find_key(text, key, first, last, ok)
        character(*), intent(in) :: text        !! The object
        character(*), intent(in) :: key
        integer, intent(out) :: first, last     !! In the text
        logical, intent(out) :: ok              !! There is such a key

        character(:), allocatable :: found

        ok = .false.
        last = 0
        first = 1
        call skip_spaces(text, first)
        if (.not. follows('{')) return
        do
            call skip_spaces(text, first)
            if (first > len(text)) return
            call read_quoted(text, first, found, ok)
            if (.not. ok) return
            ok = .false.
            call skip_spaces(text, first)
            if (.not. follows(':')) return
            call skip_spaces(text, first)
            last = end_of_value(text, first)
            if (last > len(text) .or. last < first) return
            ok = found == key
            if (ok) return
            first = last + 1
            call skip_spaces(text, first)
            if (.not. follows(',')) return
        end do

    contains

        !> Passes a character that must come next.
        logical function follows(character)
            character(1), intent(in) :: character

            follows = .false.
            if (first <= len(text)) follows = text(first:first) == character
            first = first + 1
        end function follows
    end subroutine find_key

    !> The last character of the value that begins at a place; beyond the text if it does not end.
    integer function end_of_value(text, first) result(last)
        character(*), intent(in) :: text
        integer, intent(in) :: first

        character(:), allocatable :: piece
        integer :: depth, behind
        logical :: ok

        depth = 0
        last = first
        do while (last <= len(text))
            select case (text(last:last))
            case (QUOTE)
                behind = last
                call read_quoted(text, behind, piece, ok)
                last = behind - 1
                if (.not. ok) last = len(text)
                if (ok .and. depth == 0) return
            case ('{', '[')
                depth = depth + 1
            case ('}', ']')
                depth = depth - 1
                if (depth == 0) return
            case (',')
                if (depth == 0) depth = -1
            end select
            if (depth < 0) then     ! the number or word before has ended
                last = last - 1
                return
            end if
            last = last + 1
        end do
    end function end_of_value

    pure subroutine skip_spaces(text, position)
        character(*), intent(in) :: text
        integer, intent(inout) :: position

        do while (position <= len(text))
            if (index(SPACES, text(position:position)) == 0) exit
            position = position + 1
        end do
    end subroutine skip_spaces

    !> A text in quotes, from its first quote; `position` is then behind its last one. Escapes of control
    !> characters and of ASCII are undone; of others there are none in what `quoted` writes.
    subroutine read_quoted(text, position, piece, ok)
        character(*), intent(in) :: text
        integer, intent(inout) :: position
        character(:), allocatable, intent(out) :: piece
        logical, intent(out) :: ok

        character(*), parameter :: ESCAPES = '"'//BACKSLASH//'/bfnrt', &
            MEANINGS = '"'//BACKSLASH//'/'//achar(8)//achar(12)//LF//achar(13)//achar(9)
        integer :: kind, code, status

        piece = ''
        ok = .false.
        if (text(position:position) /= QUOTE) return
        position = position + 1
        do while (position <= len(text))
            if (text(position:position) == QUOTE) then
                position = position + 1
                ok = .true.
                return
            else if (text(position:position) /= BACKSLASH) then
                piece = piece//text(position:position)
                position = position + 1
                cycle
            end if
            if (position == len(text)) return
            kind = index(ESCAPES, text(position + 1:position + 1))
            if (kind > 0) then
                piece = piece//MEANINGS(kind:kind)
                position = position + 2
            else
                if (text(position + 1:position + 1) /= 'u' .or. position + 5 > len(text)) return
                read (text(position + 2:position + 5), '(z4)', iostat=status) code
                if (status /= 0 .or. code > 127) return
                piece = piece//achar(code)
                position = position + 6
            end if
        end do
    end subroutine read_quoted
end module gracecg_files_json
