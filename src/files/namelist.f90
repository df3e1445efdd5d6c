!> Fortran's namelist syntax: from a text to keys and values, every one with its line.
!>
!>     &spacecraft                         ! a comment
!>         mass = 432.0                    ! key = value
!>         com_offset = 1e-4, 2*0.0        ! several values, by comma or blank; repeat counts
!>         name = 'front', drag = .true.
!>     /
!>
!> Keys and names of groups are blind to case. A group may stand several times. Not taken over from Fortran:
!> elements and components as keys (a(2), a%b), null values, texts over several lines or without quotes.
module gracecg_files_namelist
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: lower_case, parse_integer, integer_text
    use gracecg_files_file, only: text_file_t
    implicit none
    private
    public :: value_t, entry_t, read_namelist

    type :: value_t
        !! One value of a key
        character(:), allocatable :: text   !! As written; without its quotes
        logical :: quoted = .false.         !! It stood in quotes: a text
        integer :: line = 0                 !! Where it stands in the file, from 1
    end type value_t

    type :: entry_t
        !! A key with its values; without key: a group, before its keys
        character(:), allocatable :: group      !! Its name, in lower case
        integer :: index = 0                    !! Which group of that name, from 1
        character(:), allocatable :: key        !! In lower case; empty: the group itself
        integer :: line = 0                     !! Where it stands in the file, from 1
        type(value_t), allocatable :: values(:) !! In their order
        logical :: used = .false.               !! Somebody asked for it
    end type entry_t

    !> Kinds of tokens: what a word is, what stood in quotes, or the sign itself
    character(1), parameter :: END_OF_TEXT = ' ', WORD = 'w', QUOTED = 'q', GROUP_BEGIN = '&', GROUP_END = '/', &
                               EQUALS = '=', COMMA = ','

    !> The place reached in a text, and the token there. After a failure every token is the end of the text.
    type :: parser_t
        type(text_file_t) :: source
        type(error_t), allocatable :: failure
        integer :: position = 1, line = 1       ! behind the token
        character(1) :: kind = END_OF_TEXT
        character(:), allocatable :: text       ! a group's name, a word, or what stood in quotes
        integer :: times = 1                    ! repeat count
        integer :: at = 0                       ! line of the token
        logical :: begins_line = .false.        ! nothing but blanks before it
        type(entry_t), allocatable :: entries(:)
        integer :: used = 0                     ! of them
        character(:), allocatable :: group      ! the present one
        integer :: number = 0                   ! which of that name
        integer :: header = 0                   ! its place among the entries
    end type parser_t

    character(*), parameter :: TAB = achar(9), LF = achar(10), CR = achar(13)
    character(*), parameter :: SEPARATORS = ' '//TAB//LF//CR//',=/!&''"'
    character(*), parameter :: LETTERS = 'abcdefghijklmnopqrstuvwxyz'
    character(*), parameter :: NAME_CHARACTERS = LETTERS//'_0123456789'
    !> Values of a key, groups and keys of a file: far above what any file needs, and so few that the time to read a
    !> file that is none stays short
    integer, parameter :: MOST_VALUES = 1000, MOST_ENTRIES = 5000

contains

    !> Reads groups and keys of a text. Fails when it breaks the syntax or has no group.
    subroutine read_namelist(source, entries, error)
        type(text_file_t), intent(in) :: source                 !! The whole text
        type(entry_t), allocatable, intent(out) :: entries(:)   !! In their order; of the group first
        type(error_t), allocatable, intent(out) :: error

        type(parser_t) :: parser

        parser%source = source
        allocate (parser%entries(0))
        call advance(parser)
        do while (parser%kind == GROUP_BEGIN)
            call read_group(parser)
        end do
        if (parser%kind /= END_OF_TEXT) &
            call refuse(parser, parser%at, 'text outside a group; a group begins with &name and ends with /, a '// &
                        'comment begins with !')
        entries = parser%entries(:parser%used)
        call move_alloc(parser%failure, error)
        if (.not. allocated(error) .and. size(entries) == 0) &
            call fail(error, source%name//': there is no group (&name ... /) in it')
    end subroutine read_namelist

    !> Reads a group from its name on; afterwards the token behind its end is the present one.
    subroutine read_group(parser)
        type(parser_t), intent(inout) :: parser

        integer :: line, i

        parser%group = parser%text
        line = parser%at
        parser%number = 1
        do i = 1, parser%used
            if (parser%entries(i)%key == '' .and. parser%entries(i)%group == parser%group) parser%number = parser%number + 1
        end do
        call add_entry(parser, '', line)
        parser%header = parser%used
        call advance(parser)
        do while (parser%kind == WORD)
            call read_entry(parser)
        end do
        select case (parser%kind)
        case (GROUP_END)
            call advance(parser)
        case (GROUP_BEGIN, END_OF_TEXT)
            call refuse(parser, line, 'the group &'//parser%group//' is not ended: a line with / is missing')
        case default
            call refuse(parser, parser%at, 'expected key = value, or / to end the group &'//parser%group)
        end select
    end subroutine read_group

    !> Reads key = values; afterwards the token behind them is the present one: the next key or the end.
    subroutine read_entry(parser)
        type(parser_t), intent(inout) :: parser

        type(value_t), allocatable :: values(:)
        character(:), allocatable :: key
        integer :: line

        call check_key(parser)
        key = lower_case(parser%text)
        line = parser%at
        call add_entry(parser, key, line)
        call advance(parser)    ! the = sign
        call read_values(parser, values)
        if (size(values) == 0) call refuse(parser, line, 'the key "'//key//'" has no value')
        parser%entries(parser%used)%values = values
    end subroutine read_entry

    !> The key is a name, not yet in the group, and followed by an = sign.
    subroutine check_key(parser)
        type(parser_t), intent(inout) :: parser

        character(:), allocatable :: key
        integer :: i

        key = '"'//lower_case(parser%text)//'"'
        if (.not. equals_follows(parser)) then
            call refuse(parser, parser%at, 'expected key = value: no = after '//key)
        else if (scan(key, '(%') > 0) then
            call refuse(parser, parser%at, key//': keys with an index or % are not read; give all values of the key '// &
                        'together, as in key = 1, 2, 3')
        else if (.not. is_name(parser%text)) then
            call refuse(parser, parser%at, key//' cannot be a key: a key begins with a letter and has letters, digits and _')
        end if
        do i = parser%header + 1, parser%used
            if ('"'//parser%entries(i)%key//'"' == key) &
                call refuse(parser, parser%at, 'the key '//key//' stands twice in the group &'//parser%group// &
                            ', first in line '//integer_text(parser%entries(i)%line))
        end do
    end subroutine check_key

    !> Reads values up to something else.
    subroutine read_values(parser, values)
        type(parser_t), intent(inout) :: parser
        type(value_t), allocatable, intent(out) :: values(:)

        logical :: after_comma

        allocate (values(0))
        after_comma = .false.
        do
            call advance(parser)
            select case (parser%kind)
            case (COMMA)
                if (after_comma .or. size(values) == 0) &
                    call refuse(parser, parser%at, 'a value is missing before a comma')
            case (WORD, QUOTED)
                if (parser%kind == WORD) then
                    if (equals_follows(parser)) return
                    if (parser%begins_line .and. looks_like_key(parser%text)) &
                        call refuse(parser, parser%at, '"'//parser%text//'" is no value: an = is missing after a key, or '// &
                                    'quotes around a text')
                end if
                call append_value(parser, values)
            case default
                return
            end select
            after_comma = parser%kind == COMMA
        end do
    end subroutine read_values

    !> Puts the present token at the end, as often as its repeat count says.
    subroutine append_value(parser, values)
        type(parser_t), intent(inout) :: parser
        type(value_t), allocatable, intent(inout) :: values(:)

        type(value_t), allocatable :: longer(:)
        integer :: i, n

        n = size(values)
        if (n + parser%times > MOST_VALUES) &
            call refuse(parser, parser%at, 'more than '//integer_text(MOST_VALUES)//' values of one key')
        if (allocated(parser%failure)) return
        allocate (longer(n + parser%times))
        longer(:n) = values
        do i = n + 1, size(longer)
            longer(i)%text = parser%text
            longer(i)%quoted = parser%kind == QUOTED
            longer(i)%line = parser%at
        end do
        call move_alloc(longer, values)
    end subroutine append_value

    !> True for a word that is a name and no value.
    pure logical function looks_like_key(text)
        character(*), intent(in) :: text

        looks_like_key = is_name(text)
        select case (lower_case(text))
        case ('t', 'f', 'true', 'false', 'nan', 'inf', 'infinity')
            looks_like_key = .false.
        end select
    end function looks_like_key

    pure logical function is_name(text)
        character(*), intent(in) :: text

        is_name = text /= '' .and. verify(lower_case(text), NAME_CHARACTERS) == 0
        if (is_name) is_name = scan(lower_case(text(1:1)), LETTERS) == 1
    end function is_name

    !> Is the next token an = sign? The parser stays where it is.
    logical function equals_follows(parser)
        type(parser_t), intent(in) :: parser

        integer :: position, line

        position = parser%position
        line = parser%line
        call skip_blanks(parser%source%text, position, line)
        equals_follows = .false.
        if (position <= len(parser%source%text)) equals_follows = parser%source%text(position:position) == EQUALS
    end function equals_follows

    !> Skips blanks, ends of lines and comments.
    pure subroutine skip_blanks(text, position, line)
        character(*), intent(in) :: text
        integer, intent(inout) :: position, line

        integer :: length

        do while (position <= len(text))
            select case (text(position:position))
            case (LF)
                line = line + 1
            case ('!')
                length = index(text(position:), LF)
                if (length == 0) length = len(text) - position + 2
                position = position + length - 2    ! the last before the end
            case (' ', TAB, CR)
            case default
                exit
            end select
            position = position + 1
        end do
    end subroutine skip_blanks

    !> Goes to the next token.
    subroutine advance(parser)
        type(parser_t), intent(inout) :: parser

        call skip_blanks(parser%source%text, parser%position, parser%line)
        parser%begins_line = parser%line /= parser%at
        parser%at = parser%line
        parser%text = ''
        parser%times = 1
        parser%kind = END_OF_TEXT
        if (allocated(parser%failure) .or. parser%position > len(parser%source%text)) return
        parser%kind = parser%source%text(parser%position:parser%position)
        select case (parser%kind)
        case (EQUALS, COMMA, GROUP_END)
            parser%position = parser%position + 1
        case (GROUP_BEGIN)
            parser%text = lower_case(word_at(parser%source%text, parser%position + 1))
            parser%position = parser%position + 1 + len(parser%text)
            if (parser%text == 'end') then
                parser%kind = GROUP_END
            else if (.not. is_name(parser%text)) then
                call refuse(parser, parser%at, 'the name of a group must follow the &')
            end if
        case ('''', '"')
            call scan_quoted(parser)
        case default
            call scan_word(parser)
        end select
    end subroutine advance

    !> A text in quotes; a doubled quote within stands for one.
    subroutine scan_quoted(parser)
        type(parser_t), intent(inout) :: parser

        character(1) :: quote
        integer :: begin, end, last, length, i

        associate (text => parser%source%text)
            begin = parser%position + 1
            quote = text(begin - 1:begin - 1)
            last = parser%source%last(parser%line)
            end = begin                                 ! of the closing quote; a doubled one is passed over
            do while (end <= last)
                if (text(end:end) == quote) then
                    if (text(end + 1:min(end + 1, last)) /= quote) exit
                    end = end + 1
                end if
                end = end + 1
            end do
            if (end > last) then
                call refuse(parser, parser%at, 'the text is not ended: a closing '//quote//' is missing in this line')
                return
            end if
            parser%kind = QUOTED
            parser%position = end + 1
            parser%text = text(begin:end - 1)
            length = 0
            i = begin
            do while (i < end)
                length = length + 1
                parser%text(length:length) = text(i:i)
                if (text(i:i) == quote) i = i + 1
                i = i + 1
            end do
            parser%text = parser%text(:length)
        end associate
    end subroutine scan_quoted

    !> A word, with the repeat count before it if there is one.
    subroutine scan_word(parser)
        type(parser_t), intent(inout) :: parser

        character(:), allocatable :: word_text
        integer :: star
        logical :: ok

        parser%kind = WORD
        word_text = word_at(parser%source%text, parser%position)
        parser%position = parser%position + len(word_text)
        star = index(word_text, '*')
        parser%text = word_text(star + 1:)
        if (star == 0) return
        call parse_integer(word_text(:star - 1), parser%times, ok)
        if (.not. ok .or. parser%times < 1 .or. parser%times > MOST_VALUES) then
            call refuse(parser, parser%at, '"'//word_text//'": before the * must stand a repeat count of 1 to '// &
                        integer_text(MOST_VALUES))
        else if (parser%text == '') then
            if (scan(parser%source%text(parser%position:), '''"') == 1) then
                call scan_quoted(parser)
            else
                call refuse(parser, parser%at, 'a value is missing after "'//word_text//'"')
            end if
        end if
    end subroutine scan_word

    pure integer function word_length(text, position) result(length)
        character(*), intent(in) :: text
        integer, intent(in) :: position

        length = scan(text(position:), SEPARATORS) - 1
        if (length < 0) length = len(text) - position + 1
    end function word_length

    !> The characters from `position` to the next separator.
    pure function word_at(text, position) result(found)
        character(*), intent(in) :: text
        integer, intent(in) :: position
        character(word_length(text, position)) :: found

        found = text(position:)
    end function word_at

    !> Puts the present group, or a key of it, at the end of the entries.
    subroutine add_entry(parser, key, line)
        type(parser_t), intent(inout) :: parser
        character(*), intent(in) :: key         !! Empty: the group
        integer, intent(in) :: line             !! Where it stands

        type(entry_t), allocatable :: longer(:)

        if (parser%used == MOST_ENTRIES) then
            call refuse(parser, line, 'more than '//integer_text(MOST_ENTRIES)//' groups and keys')
            return
        end if
        if (parser%used == size(parser%entries)) then
            allocate (longer(2*parser%used + 64))
            longer(:parser%used) = parser%entries
            call move_alloc(longer, parser%entries)
        end if
        parser%used = parser%used + 1
        associate (entry => parser%entries(parser%used))
            entry%group = parser%group
            entry%index = parser%number
            entry%key = key
            entry%line = line
            allocate (entry%values(0))
        end associate
    end subroutine add_entry

    !> Notes the first thing that is wrong.
    subroutine refuse(parser, line, message)
        type(parser_t), intent(inout) :: parser
        integer, intent(in) :: line
        character(*), intent(in) :: message

        parser%kind = END_OF_TEXT
        if (.not. allocated(parser%failure)) call parser%source%fail_at(line, message, parser%failure)
    end subroutine refuse
end module gracecg_files_namelist
