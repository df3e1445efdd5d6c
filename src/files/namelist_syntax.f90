!> The syntax of namelist files: from a text to groups, keys and values, every one with its line.
module gracecg_files_namelist_syntax
    use gracecg_base_error, only: error_t, fail
    use gracecg_files_file, only: text_file_t
    use gracecg_base_text, only: lower_case, parse_integer, integer_text
    implicit none
    private
    public :: value_t, entry_t, group_t, read_groups, count_groups, position_of

    type :: value_t
        !! One value of a key
        character(:), allocatable :: text   !! As written; without its quotes
        logical :: quoted = .false.         !! It stood in quotes: a text
        integer :: line = 0                 !! Where it stands in the file, from 1
    end type value_t

    type :: entry_t
        !! key = values
        character(:), allocatable :: key        !! Name before the equals sign, in lower case
        integer :: line = 0                     !! Where it stands in the file, from 1
        type(value_t), allocatable :: values(:) !! In their order
        logical :: used = .false.               !! Somebody asked for it
    end type entry_t

    type :: group_t
        !! &name ... /
        character(:), allocatable :: name       !! Behind the ampersand, in lower case
        integer :: line = 0                     !! Where it begins in the file, from 1
        integer :: index = 0                    !! 1 for the first group of its name
        type(entry_t), allocatable :: entries(:)    !! Its keys, in their order
        logical :: used = .false.               !! Somebody asked for it
    end type group_t

    integer, parameter :: END_OF_TEXT = 0, GROUP_BEGIN = 1, GROUP_END = 2, WORD = 3, QUOTED = 4, &
        EQUALS = 5, COMMA = 6

    type :: token_t
        !! A piece of the text
        integer :: kind = END_OF_TEXT
        character(:), allocatable :: text       !! A group's name, a word, or what stood in quotes
        integer :: line = 0
        integer :: times = 1                    !! Repeat count
        logical :: begins_line = .false.        !! Nothing but blanks before it
    end type token_t

    type :: scanner_t
        !! The place reached in the text
        integer :: position = 1, line = 1
        integer :: line_of_last = 0             !! Line of the last token
    end type scanner_t

    character(*), parameter :: TAB = achar(9), LF = achar(10), CR = achar(13)
    character(*), parameter :: SEPARATORS = ' '//TAB//LF//CR//',=/!&''"'
    character(*), parameter :: LETTERS = 'abcdefghijklmnopqrstuvwxyz'
    character(*), parameter :: NAME_CHARACTERS = LETTERS//'_0123456789'
    !> Values of a key, keys of a group, groups of a file: far above what any file needs, and so few that the time to read
    !> a file that is none stays short
    integer, parameter :: MOST_VALUES = 1000, MOST_KEYS = 1000, MOST_GROUPS = 1000

contains

    !> Reads the groups of a text. Fails when it breaks the syntax or has no group.
    subroutine read_groups(source, groups, error)
        type(text_file_t), intent(in) :: source
        type(group_t), allocatable, intent(out) :: groups(:)
        type(error_t), allocatable, intent(out) :: error

        type(scanner_t) :: scanner
        type(token_t) :: token

        allocate (groups(0))
        do
            call next_token(source, scanner, token, error)
            if (allocated(error)) return
            select case (token%kind)
            case (END_OF_TEXT)
                exit
            case (GROUP_BEGIN)
                call parse_group(source, groups, token, scanner, error)
                if (allocated(error)) return
            case default
                call source%fail_at(token%line, 'text outside a group; a group begins with '// &
                                    '&name and ends with /, a comment begins with !', error)
                return
            end select
        end do
        if (size(groups) == 0) &
            call fail(error, source%name//': there is no group (&name ... /) in it')
    end subroutine read_groups

    !> Reads a group from behind its name to its end.
    subroutine parse_group(source, groups, name, scanner, error)
        type(text_file_t), intent(in) :: source
        type(group_t), allocatable, intent(inout) :: groups(:)
        type(token_t), intent(in) :: name
        type(scanner_t), intent(inout) :: scanner
        type(error_t), allocatable, intent(out) :: error

        type(group_t) :: group
        type(token_t) :: token

        group%name = name%text
        group%line = name%line
        group%index = count_groups(groups, group%name) + 1
        allocate (group%entries(0))
        call next_token(source, scanner, token, error)
        if (size(groups) == MOST_GROUPS) &
            call source%fail_at(name%line, 'more than '//integer_text(MOST_GROUPS)//' groups', error)
        do
            if (allocated(error)) return
            select case (token%kind)
            case (GROUP_END)
                exit
            case (WORD)
                call parse_entry(source, group, token, scanner, error)
            case (GROUP_BEGIN, END_OF_TEXT)
                call source%fail_at(group%line, 'the group &'//group%name//' is not ended: a '// &
                                    'line with / is missing', error)
            case default
                call source%fail_at(token%line, 'expected key = value, or / to end the group &'// &
                                    group%name, error)
            end select
        end do
        call append_group(groups, group)
    end subroutine parse_group

    !> Reads `= values` of a key; afterwards `token` is what follows them: the next key or the end.
    subroutine parse_entry(source, group, token, scanner, error)
        type(text_file_t), intent(in) :: source
        type(group_t), intent(inout) :: group
        type(token_t), intent(inout) :: token       !! The key
        type(scanner_t), intent(inout) :: scanner
        type(error_t), allocatable, intent(out) :: error

        type(entry_t) :: entry

        call check_key(source, group, token, scanner, error)
        if (allocated(error)) return
        entry%key = lower_case(token%text)
        entry%line = token%line
        allocate (entry%values(0))
        call next_token(source, scanner, token, error)     ! the = sign
        if (allocated(error)) return
        call parse_values(source, entry%values, token, scanner, error)
        if (allocated(error)) return
        if (size(entry%values) == 0) then
            call source%fail_at(entry%line, 'the key "'//entry%key//'" has no value', error)
            return
        end if
        if (size(group%entries) == MOST_KEYS) then
            call source%fail_at(entry%line, 'more than '//integer_text(MOST_KEYS)//' keys in the group &'//group%name, &
                                error)
            return
        end if
        call append_entry(group%entries, entry)
    end subroutine parse_entry

    !> Reads values up to something else, which is then in `token`.
    subroutine parse_values(source, values, token, scanner, error)
        type(text_file_t), intent(in) :: source
        type(value_t), allocatable, intent(inout) :: values(:)
        type(token_t), intent(inout) :: token
        type(scanner_t), intent(inout) :: scanner
        type(error_t), allocatable, intent(out) :: error

        logical :: after_comma

        after_comma = .false.
        do
            call next_token(source, scanner, token, error)
            if (allocated(error)) return
            select case (token%kind)
            case (COMMA)
                if (after_comma .or. size(values) == 0) then
                    call source%fail_at(token%line, 'a value is missing before a comma', error)
                    return
                end if
            case (WORD)
                if (equals_follows(source, scanner)) return
                if (token%begins_line .and. looks_like_key(token%text)) then
                    call source%fail_at(token%line, '"'//token%text//'" is no value: an = is '// &
                                        'missing after a key, or quotes around a text', error)
                    return
                end if
                call append_values(source, values, token, error)
            case (QUOTED)
                call append_values(source, values, token, error)
            case default
                return
            end select
            if (allocated(error)) return
            after_comma = token%kind == COMMA
        end do
    end subroutine parse_values

    !> The key is a name, not yet in the group, and followed by an = sign.
    subroutine check_key(source, group, token, scanner, error)
        type(text_file_t), intent(in) :: source
        type(group_t), intent(in) :: group
        type(token_t), intent(in) :: token
        type(scanner_t), intent(in) :: scanner
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: key
        integer :: position

        key = '"'//lower_case(token%text)//'"'
        if (.not. equals_follows(source, scanner)) then
            call source%fail_at(token%line, 'expected key = value: no = after '//key, error)
        else if (scan(key, '(%') > 0) then
            call source%fail_at(token%line, key//': keys with an index or % are not read; give '// &
                                'all values of the key together, as in key = 1, 2, 3', error)
        else if (.not. is_name(token%text)) then
            call source%fail_at(token%line, key//' cannot be a key: a key begins with a letter '// &
                                'and has letters, digits and _', error)
        else
            position = position_of(group, lower_case(token%text))
            if (position == 0) return
            call source%fail_at(token%line, 'the key '//key//' stands twice in the group &'// &
                                group%name//', first in line '// &
                                integer_text(group%entries(position)%line), error)
        end if
    end subroutine check_key

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

    !> Is the next token an = sign? The scanner stays where it is.
    logical function equals_follows(source, scanner)
        type(text_file_t), intent(in) :: source
        type(scanner_t), intent(in) :: scanner

        type(scanner_t) :: ahead

        ahead = scanner
        call skip_blanks(source%text, ahead)
        equals_follows = .false.
        if (ahead%position <= len(source%text)) &
            equals_follows = source%text(ahead%position:ahead%position) == '='
    end function equals_follows

    !> Skips blanks, ends of lines and comments.
    pure subroutine skip_blanks(text, scanner)
        character(*), intent(in) :: text
        type(scanner_t), intent(inout) :: scanner

        integer :: length

        do while (scanner%position <= len(text))
            select case (text(scanner%position:scanner%position))
            case (LF)
                scanner%line = scanner%line + 1
            case ('!')
                length = index(text(scanner%position:), LF)
                if (length == 0) length = len(text) - scanner%position + 2
                scanner%position = scanner%position + length - 2    ! the last before the end
            case (' ', TAB, CR)
            case default
                exit
            end select
            scanner%position = scanner%position + 1
        end do
    end subroutine skip_blanks

    subroutine next_token(source, scanner, token, error)
        type(text_file_t), intent(in) :: source
        type(scanner_t), intent(inout) :: scanner
        type(token_t), intent(out) :: token
        type(error_t), allocatable, intent(out) :: error

        call skip_blanks(source%text, scanner)
        token%line = scanner%line
        token%begins_line = scanner%line /= scanner%line_of_last
        scanner%line_of_last = scanner%line
        token%text = ''
        if (scanner%position > len(source%text)) return
        select case (source%text(scanner%position:scanner%position))
        case ('=')
            token%kind = EQUALS
            scanner%position = scanner%position + 1
        case (',')
            token%kind = COMMA
            scanner%position = scanner%position + 1
        case ('/')
            token%kind = GROUP_END
            scanner%position = scanner%position + 1
        case ('&')
            scanner%position = scanner%position + 1
            call scan_group_name(source, scanner, token, error)
        case ('''', '"')
            call scan_quoted(source, scanner, token, error)
        case default
            call scan_word(source, scanner, token, error)
        end select
    end subroutine next_token

    !> &name, or &end.
    subroutine scan_group_name(source, scanner, token, error)
        type(text_file_t), intent(in) :: source
        type(scanner_t), intent(inout) :: scanner
        type(token_t), intent(inout) :: token
        type(error_t), allocatable, intent(out) :: error

        token%text = lower_case(word_at(source%text, scanner%position))
        scanner%position = scanner%position + len(token%text)
        token%kind = GROUP_BEGIN
        if (token%text == 'end') then
            token%kind = GROUP_END
        else if (.not. is_name(token%text)) then
            call source%fail_at(token%line, 'the name of a group must follow the &', error)
        end if
    end subroutine scan_group_name

    !> A text in quotes; a doubled quote within stands for one.
    subroutine scan_quoted(source, scanner, token, error)
        type(text_file_t), intent(in) :: source
        type(scanner_t), intent(inout) :: scanner
        type(token_t), intent(inout) :: token
        type(error_t), allocatable, intent(out) :: error

        character(1) :: quote
        integer :: begin, end, last, length, i

        token%kind = QUOTED
        quote = source%text(scanner%position:scanner%position)
        begin = scanner%position + 1
        last = source%last(scanner%line)
        end = begin                                 ! of the closing quote; a doubled one is passed over
        do while (end <= last)
            if (source%text(end:end) == quote) then
                if (source%text(end + 1:min(end + 1, last)) /= quote) exit
                end = end + 1
            end if
            end = end + 1
        end do
        if (end > last) then
            call source%fail_at(token%line, 'the text is not ended: a closing '//quote// &
                                ' is missing in this line', error)
            return
        end if
        scanner%position = end + 1
        token%text = source%text(begin:end - 1)
        length = 0
        i = begin
        do while (i < end)
            length = length + 1
            token%text(length:length) = source%text(i:i)
            if (source%text(i:i) == quote) i = i + 1
            i = i + 1
        end do
        token%text = token%text(:length)
    end subroutine scan_quoted

    !> A word, with the repeat count before it if there is one.
    subroutine scan_word(source, scanner, token, error)
        type(text_file_t), intent(in) :: source
        type(scanner_t), intent(inout) :: scanner
        type(token_t), intent(inout) :: token
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: word_text
        integer :: star, times
        logical :: ok

        token%kind = WORD
        word_text = word_at(source%text, scanner%position)
        token%text = word_text
        star = index(word_text, '*')
        if (star > 0) then
            call parse_integer(word_text(:star - 1), times, ok)
            if (.not. ok .or. times < 1 .or. times > MOST_VALUES) then
                call source%fail_at(token%line, '"'//word_text//'": before the * must stand a '// &
                                    'repeat count of 1 to '//integer_text(MOST_VALUES), error)
                return
            end if
            token%times = times
            token%text = word_text(star + 1:)
        end if
        scanner%position = scanner%position + len(word_text)
        if (star == 0 .or. token%text /= '') return
        if (scanner%position <= len(source%text)) then
            if (scan(source%text(scanner%position:scanner%position), '''"') == 1) then
                call scan_quoted(source, scanner, token, error)
                return
            end if
        end if
        call source%fail_at(token%line, 'a value is missing after "'//word_text//'"', error)
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

    subroutine append_values(source, values, token, error)
        type(text_file_t), intent(in) :: source
        type(value_t), allocatable, intent(inout) :: values(:)
        type(token_t), intent(in) :: token
        type(error_t), allocatable, intent(out) :: error

        type(value_t), allocatable :: longer(:)
        integer :: i, n

        n = size(values)
        if (n + token%times > MOST_VALUES) then
            call source%fail_at(token%line, 'more than '//integer_text(MOST_VALUES)//' values of one key', error)
            return
        end if
        allocate (longer(n + token%times))
        longer(:n) = values
        do i = n + 1, size(longer)
            longer(i)%text = token%text
            longer(i)%quoted = token%kind == QUOTED
            longer(i)%line = token%line
        end do
        call move_alloc(longer, values)
    end subroutine append_values

    subroutine append_entry(entries, entry)
        type(entry_t), allocatable, intent(inout) :: entries(:)
        type(entry_t), intent(in) :: entry

        type(entry_t), allocatable :: longer(:)

        allocate (longer(size(entries) + 1))
        longer(:size(entries)) = entries
        longer(size(longer)) = entry
        call move_alloc(longer, entries)
    end subroutine append_entry

    subroutine append_group(groups, group)
        type(group_t), allocatable, intent(inout) :: groups(:)
        type(group_t), intent(in) :: group

        type(group_t), allocatable :: longer(:)

        allocate (longer(size(groups) + 1))
        longer(:size(groups)) = groups
        longer(size(longer)) = group
        call move_alloc(longer, groups)
    end subroutine append_group

    !> How many groups of a name there are.
    pure integer function count_groups(groups, name) result(n)
        type(group_t), intent(in) :: groups(:)
        character(*), intent(in) :: name    !! Lower case

        integer :: i

        n = 0
        do i = 1, size(groups)
            if (groups(i)%name == name) n = n + 1
        end do
    end function count_groups

    !> Position of a key in a group; 0 when it is not there.
    pure integer function position_of(group, key) result(position)
        type(group_t), intent(in) :: group
        character(*), intent(in) :: key     !! Lower case

        do position = 1, size(group%entries)
            if (group%entries(position)%key == key) return
        end do
        position = 0
    end function position_of
end module gracecg_files_namelist_syntax
