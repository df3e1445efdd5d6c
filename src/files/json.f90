!> JSON (RFC 8259): a writer of objects, arrays and values, and a reader of single members of what it wrote:
!> saved estimates, and what stands beside tables. The reader does not check what it passes over.
!>
!> Numbers are written so that they read back exactly. JSON has no NaN and no infinity: such a number is a
!> failure that `finish` reports with its key; what has no value is written by `nothing`, as null.
module gracecg_files_json
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append, split_words, integer_text, real_text, parse_real, logical_text
    use gracecg_files_file, only: text_file_t, read_text_file
    use gracecg_files_run_record, only: get_provenance
    implicit none
    private
    public :: json_writer_t, put_provenance, read_json_file, read_json_list, read_json_numbers, read_json_text

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

    !> The command line of the program and the hashes of its inputs as members of an object; nothing when the program is
    !> another.
    subroutine put_provenance(json)
        class(json_writer_t), intent(inout) :: json

        character(:), allocatable :: command, commit
        type(string_t), allocatable :: inputs(:)

        call get_provenance(command, inputs, commit)
        if (command == '') return
        if (commit /= '') call json%member('commit', commit)
        call json%member('command_line', command)
        call json%member('input_hashes', inputs)
    end subroutine put_provenance

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

        call self%raw(key, trim(logical_text(value)))
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

    !> The texts of a member that is an array of texts. Not ok: there is no such member.
    subroutine read_json_list(text, path, list, ok)
        character(*), intent(in) :: text        !! A JSON text
        character(*), intent(in) :: path        !! Keys from the outermost object on, with points: 'noise.level'
        type(string_t), allocatable, intent(out) :: list(:)
        logical, intent(out) :: ok              !! There is such a list

        character(:), allocatable :: piece
        integer :: at, last, end_of_list

        allocate (list(0))
        call find_member(text, path, at, end_of_list, ok)
        if (ok) ok = text(at:at) == '['
        if (.not. ok) return
        at = next_place(text, at + 1)
        do while (at < end_of_list)
            last = end_of_value(text, at)
            call unquote(text(at:last), piece, ok)
            if (.not. ok) return
            call append(list, piece)
            at = next_place(text, last + 1)
            ok = at == end_of_list .or. stands(text, at, ',')
            if (.not. ok) return
            if (at < end_of_list) at = next_place(text, at + 1)
        end do
    end subroutine read_json_list

    !> All numbers of a member, row by row where it is an array of arrays. Not ok: there is no such member, or it holds
    !> something else.
    subroutine read_json_numbers(text, path, values, ok, wrong)
        character(*), intent(in) :: text        !! A JSON text
        character(*), intent(in) :: path        !! As of read_json_list
        real(dp), allocatable, intent(out) :: values(:)    !! The numbers
        logical, intent(out) :: ok              !! There are such numbers
        character(:), allocatable, intent(inout), optional :: wrong
        !! ': "WORD" of "PATH" is no number', of the first word that is none; else as it was

        type(string_t), allocatable :: words(:)
        character(:), allocatable :: numbers
        integer :: first, last, i

        allocate (values(0))
        call find_member(text, path, first, last, ok)
        if (.not. ok) return
        numbers = text(first:last)
        do i = 1, len(numbers)
            if (index(SPACES//'[],', numbers(i:i)) > 0) numbers(i:i) = ' '
        end do
        words = split_words(numbers)
        deallocate (values)
        allocate (values(size(words)))
        ok = size(words) > 0
        do i = 1, size(words)
            if (.not. ok) exit
            call parse_real(words(i)%text, values(i), ok)
            if (.not. ok .and. present(wrong)) wrong = ': "'//words(i)%text//'" of "'//path//'" is no number'
        end do
    end subroutine read_json_numbers

    !> The text of a member. Not ok: there is no such member, or it is no text.
    subroutine read_json_text(text, path, value, ok)
        character(*), intent(in) :: text        !! A JSON text
        character(*), intent(in) :: path        !! As of read_json_list
        character(:), allocatable, intent(out) :: value    !! The text; empty when not ok
        logical, intent(out) :: ok              !! There is such a text

        integer :: first, last

        value = ''
        call find_member(text, path, first, last, ok)
        if (ok) call unquote(text(first:last), value, ok)
    end subroutine read_json_text

    !> Where the value of a member stands: text(first:last).
    pure subroutine find_member(text, path, first, last, ok)
        character(*), intent(in) :: text, path
        integer, intent(out) :: first, last
        logical, intent(out) :: ok              !! There is such a member, and its value has an end

        character(:), allocatable :: key
        character(1) :: before
        integer :: start, point

        start = 1
        first = next_place(text, 1)
        do      ! over the keys of the path, each in the object that begins at `first`
            point = start - 1 + index(path(start:)//'.', '.')
            before = '{'
            do      ! over the members
                ok = stands(text, first, before)
                if (.not. ok) return
                before = ','
                first = next_place(text, first + 1)
                last = end_of_value(text, first)
                call unquote(text(first:last), key, ok)
                first = next_place(text, last + 1)
                ok = ok .and. stands(text, first, ':')
                if (.not. ok) return
                first = next_place(text, first + 1)
                last = end_of_value(text, first)
                ok = last >= first
                if (.not. ok) return
                if (key == path(start:point - 1)) exit
                first = next_place(text, last + 1)
            end do
            if (point > len(path)) return
            start = point + 1
        end do
    end subroutine find_member

    pure logical function stands(text, at, letter)
        character(*), intent(in) :: text
        integer, intent(in) :: at
        character(1), intent(in) :: letter

        stands = at <= len(text)
        if (stands) stands = text(at:at) == letter
    end function stands

    !> The first place from `first` on where something stands; behind the text if there is none.
    pure integer function next_place(text, first) result(at)
        character(*), intent(in) :: text
        integer, intent(in) :: first

        do at = first, len(text)
            if (index(SPACES, text(at:at)) == 0) return
        end do
    end function next_place

    !> The text of a file, which has to be one whole value. Fails when it cannot be read, is cut off, or more stands behind
    !> the end of the value.
    subroutine read_json_file(path, text, error)
        character(*), intent(in) :: path        !! Of the file
        character(:), allocatable, intent(out) :: text  !! To be used where there is no error
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: file
        integer :: first, last

        text = ''
        call read_text_file(path, file, error)
        if (allocated(error)) return
        text = file%text
        first = next_place(text, 1)
        last = end_of_value(text, first)
        if (last < first .or. next_place(text, last + 1) <= len(text)) &
            call fail(error, path//': is no whole JSON file: it is cut off, or more stands behind its end')
    end subroutine read_json_file

    !> The last character of the value that begins at a place; before it if the value does not end.
    pure integer function end_of_value(text, first) result(last)
        character(*), intent(in) :: text
        integer, intent(in) :: first

        integer :: depth
        logical :: in_quotes

        depth = 0
        in_quotes = .false.
        last = first
        do while (last <= len(text))
            if (in_quotes) then
                if (text(last:last) == BACKSLASH) then
                    last = last + 1         ! what it escapes is passed over
                else
                    in_quotes = text(last:last) /= QUOTE
                end if
                if (depth == 0 .and. .not. in_quotes) return
            else
                select case (text(last:last))
                case (QUOTE)
                    in_quotes = .true.
                case ('{', '[')
                    depth = depth + 1
                case ('}', ']')
                    depth = depth - 1
                    if (depth == 0) return
                case (',', ' ', achar(9), LF, achar(13))
                    if (depth == 0) depth = -1
                end select
                if (depth < 0) exit         ! a number or word ended before
            end if
            last = last + 1
        end do
        last = merge(last, first, depth < 0) - 1
    end function end_of_value

    !> What stands in quotes, its escapes undone; of those by number ASCII alone, as json_quoted writes them.
    pure subroutine unquote(quoted, text, ok)
        character(*), intent(in) :: quoted
        character(:), allocatable, intent(out) :: text
        logical, intent(out) :: ok              !! It is such a text

        character(*), parameter :: ESCAPES = '"'//BACKSLASH//'/bfnrt', &
            MEANINGS = '"'//BACKSLASH//'/'//achar(8)//achar(12)//LF//achar(13)//achar(9)
        integer :: i, kind, code, status

        text = ''
        ok = len(quoted) >= 2
        if (ok) ok = quoted(1:1) == QUOTE
        i = 2
        do while (ok .and. i < len(quoted))
            kind = index(ESCAPES, quoted(i + 1:i + 1))
            if (quoted(i:i) /= BACKSLASH) then
                text = text//quoted(i:i)
                i = i + 1
            else if (kind > 0) then
                text = text//MEANINGS(kind:kind)
                i = i + 2
            else
                read (quoted(i + 1:min(i + 5, len(quoted))), '(1x, z4)', iostat=status) code
                ok = status == 0 .and. quoted(i + 1:i + 1) == 'u'
                if (ok) ok = code >= 0 .and. code < 128
                if (ok) text = text//achar(code)
                i = i + 6
            end if
        end do
    end subroutine unquote
end module gracecg_files_json
