!> Files in Fortran's namelist syntax, read so that every mistake is shown with file and line.
!>
!>     &spacecraft                         ! a comment
!>         mass = 432.0                    ! key = value
!>         com_offset = 1e-4, 2*0.0        ! several values, by comma or blank; repeat counts
!>         name = 'front', drag = .true.
!>     /
!>
!> The reader collects groups, keys and values; typed `get`s fetch them, with defaults and limits;
!> `check_all_used` then reports what nobody asked for: a misspelt key. A group may stand several
!> times and is then numbered by `index`. Keys and group names are blind to case. Not taken over
!> from Fortran: elements and components as keys (a(2), a%b), null values, texts over several lines
!> or without quotes.
module gracecg_namelist
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_kinds, only: dp
    use gracecg_error, only: error_t, fail, fail_in_file, nearest_name
    use gracecg_file, only: text_file_t, read_text_file, text_file_of, output_file_t
    use gracecg_text, only: string_t, lower_case, append, join, padded, parse_integer, real_text, &
        integer_text
    use gracecg_value, only: real_from_text, integer_from_text, logical_from_text, &
         choice_from_text, &
        allowed_real, allowed_integer, allowed_choice, did_you_mean
    implicit none
    private
    public :: namelist_file_t, namelist_writer_t

    type :: value_t
        !! One value of a key
        character(:), allocatable :: text   !! As written; without its quotes
        logical :: quoted = .false.
        integer :: line = 0
    end type value_t

    type :: entry_t
        !! key = values
        character(:), allocatable :: key
        integer :: line = 0
        type(value_t), allocatable :: values(:)
        logical :: used = .false.
    end type entry_t

    type :: group_t
        !! &name ... /
        character(:), allocatable :: name
        integer :: line = 0
        integer :: index = 0                    !! 1 for the first group of its name
        type(entry_t), allocatable :: entries(:)
        logical :: used = .false.
    end type group_t

    type :: known_t
        !! A key that was asked for
        character(:), allocatable :: group, key
    end type known_t

    type :: namelist_file_t
        !! The content of a namelist file
        private
        type(text_file_t) :: source
        type(group_t), allocatable :: groups(:)
        type(known_t), allocatable :: known(:)
    contains
        procedure :: read => read_namelist
        procedure :: parse => parse_namelist
        procedure :: group_count
        procedure :: has
        generic :: get => get_real, get_reals, get_integer, get_logical, get_text
        procedure :: reject
        procedure :: check_all_used
        ! The specific procedures of a generic stay public: gfortran 12 refuses to read the module files
        ! of two users of this type when they are private ("mismatch in components")
        procedure :: get_real
        procedure :: get_reals
        procedure :: get_integer
        procedure :: get_logical
        procedure :: get_text
    end type namelist_file_t

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

    type :: namelist_writer_t
        !! Writes groups and keys to a text, which can be saved as a file or shown
        private
        character(:), allocatable :: content
        type(error_t), allocatable :: failure   !! The first thing that cannot be written
    contains
        procedure :: comment => write_comment
        procedure :: group => write_group
        generic :: entry => write_real, write_reals, write_integer, write_logical, write_text
        procedure :: end_group => write_end_group
        procedure :: to_text
        procedure :: save => save_namelist
        procedure :: write_real
        procedure :: write_reals
        procedure :: write_integer
        procedure :: write_logical
        procedure :: write_text
    end type namelist_writer_t

    character(*), parameter :: TAB = achar(9), LF = achar(10), CR = achar(13)
    character(*), parameter :: SEPARATORS = ' '//TAB//LF//CR//',=/!&''"'
    character(*), parameter :: LETTERS = 'abcdefghijklmnopqrstuvwxyz'
    character(*), parameter :: NAME_CHARACTERS = LETTERS//'_0123456789'
    integer, parameter :: LARGEST_REPEAT = 100000

contains

    ! Reading: from the text to groups, keys and values

    !> Reads a file. Fails when it cannot be read or breaks the syntax.
    subroutine read_namelist(self, path, error)
        class(namelist_file_t), intent(out) :: self
        character(*), intent(in) :: path
        type(error_t), allocatable, intent(out) :: error

        call read_text_file(path, self%source, error)
        if (allocated(error)) return
        call parse_source(self, error)
    end subroutine read_namelist

    !> Reads a text in memory; `name` stands for the file in messages.
    subroutine parse_namelist(self, text, name, error)
        class(namelist_file_t), intent(out) :: self
        character(*), intent(in) :: text, name
        type(error_t), allocatable, intent(out) :: error

        self%source = text_file_of(text, name)
        call parse_source(self, error)
    end subroutine parse_namelist

    subroutine parse_source(self, error)
        class(namelist_file_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        type(scanner_t) :: scanner
        type(token_t) :: token

        allocate (self%groups(0), self%known(0))
        do
            call next_token(self%source, scanner, token, error)
            if (allocated(error)) return
            select case (token%kind)
            case (END_OF_TEXT)
                exit
            case (GROUP_BEGIN)
                call parse_group(self, token, scanner, error)
                if (allocated(error)) return
            case default
                call fail_at_line(self, token%line, &
                                  'text outside a group; a group begins with &name '// &
                                  'and ends with /, a comment begins with !', error)
                return
            end select
        end do
        if (size(self%groups) == 0) &
            call fail(error, self%source%name//': there is no group (&name ... /) in it')
    end subroutine parse_source

    !> Reads a group from behind its name to its end.
    subroutine parse_group(self, name, scanner, error)
        class(namelist_file_t), intent(inout) :: self
        type(token_t), intent(in) :: name
        type(scanner_t), intent(inout) :: scanner
        type(error_t), allocatable, intent(out) :: error

        type(group_t) :: group
        type(token_t) :: token

        group%name = name%text
        group%line = name%line
        group%index = count_groups(self, group%name) + 1
        allocate (group%entries(0))
        call next_token(self%source, scanner, token, error)
        do
            if (allocated(error)) return
            select case (token%kind)
            case (GROUP_END)
                exit
            case (WORD)
                call parse_entry(self, group, token, scanner, error)
            case (GROUP_BEGIN, END_OF_TEXT)
                call fail_at_line(self, group%line, 'the group &'//group%name//' is not ended: '// &
                                  'a line with / is missing', error)
            case default
                call fail_at_line(self, token%line, &
                                  'expected key = value, or / to end the group &'//group%name, &
                                  error)
            end select
        end do
        call append_group(self%groups, group)
    end subroutine parse_group

    !> Reads `= values` of a key; afterwards `token` is what follows them: the next key or the end.
    subroutine parse_entry(self, group, token, scanner, error)
        class(namelist_file_t), intent(in) :: self
        type(group_t), intent(inout) :: group
        type(token_t), intent(inout) :: token       !! The key
        type(scanner_t), intent(inout) :: scanner
        type(error_t), allocatable, intent(out) :: error

        type(entry_t) :: entry

        call check_key(self, group, token, scanner, error)
        if (allocated(error)) return
        entry%key = lower_case(token%text)
        entry%line = token%line
        allocate (entry%values(0))
        call next_token(self%source, scanner, token, error)     ! the = sign
        if (allocated(error)) return
        call parse_values(self, entry%values, token, scanner, error)
        if (allocated(error)) return
        if (size(entry%values) == 0) then
            call fail_at_line(self, entry%line, 'the key "'//entry%key//'" has no value', error)
            return
        end if
        call append_entry(group%entries, entry)
    end subroutine parse_entry

    !> Reads values up to something else, which is then in `token`.
    subroutine parse_values(self, values, token, scanner, error)
        class(namelist_file_t), intent(in) :: self
        type(value_t), allocatable, intent(inout) :: values(:)
        type(token_t), intent(inout) :: token
        type(scanner_t), intent(inout) :: scanner
        type(error_t), allocatable, intent(out) :: error

        logical :: after_comma

        after_comma = .false.
        do
            call next_token(self%source, scanner, token, error)
            if (allocated(error)) return
            select case (token%kind)
            case (COMMA)
                if (after_comma .or. size(values) == 0) then
                    call fail_at_line(self, token%line, 'a value is missing before a comma', error)
                    return
                end if
            case (WORD)
                if (equals_follows(self%source, scanner)) return
                if (token%begins_line .and. looks_like_key(token%text)) then
                    call fail_at_line(self, token%line, '"'//token%text//'" is no value: '// &
                                      'an = is missing after a key, or quotes around a text', error)
                    return
                end if
                call append_values(values, token)
            case (QUOTED)
                call append_values(values, token)
            case default
                return
            end select
            after_comma = token%kind == COMMA
        end do
    end subroutine parse_values

    !> The key is a name, not yet in the group, and followed by an = sign.
    subroutine check_key(self, group, token, scanner, error)
        class(namelist_file_t), intent(in) :: self
        type(group_t), intent(in) :: group
        type(token_t), intent(in) :: token
        type(scanner_t), intent(in) :: scanner
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: key
        integer :: position

        key = '"'//lower_case(token%text)//'"'
        if (.not. equals_follows(self%source, scanner)) then
            call fail_at_line(self, token%line, 'expected key = value: no = after '//key, error)
        else if (scan(key, '(%') > 0) then
            call fail_at_line(self, token%line, key//': keys with an index or % are not read; '// &
                              'give all values of the key together, as in key = 1, 2, 3', error)
        else if (.not. is_name(token%text)) then
            call fail_at_line(self, token%line, key//' cannot be a key: a key begins with a '// &
                              'letter and has letters, digits and _', error)
        else
            position = position_of(group, lower_case(token%text))
            if (position == 0) return
            call fail_at_line(self, token%line, 'the key '//key//' stands twice in the group &'// &
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
            call fail_in_file(error, source%name, token%line, &
                              'the name of a group must follow the &', source%line(token%line))
        end if
    end subroutine scan_group_name

    !> A text in quotes; a doubled quote within stands for one.
    subroutine scan_quoted(source, scanner, token, error)
        type(text_file_t), intent(in) :: source
        type(scanner_t), intent(inout) :: scanner
        type(token_t), intent(inout) :: token
        type(error_t), allocatable, intent(out) :: error

        character(1) :: quote
        integer :: length, last

        token%kind = QUOTED
        quote = source%text(scanner%position:scanner%position)
        last = source%last(scanner%line)
        do
            scanner%position = scanner%position + 1     ! behind the quote
            length = index(source%text(scanner%position:last), quote) - 1
            if (length < 0) then
                call fail_in_file(error, source%name, token%line, 'the text is not ended: '// &
                                  'a closing '//quote//' is missing in this line', &
                                  source%line(token%line))
                return
            end if
            token%text = token%text//source%text(scanner%position:scanner%position + length - 1)
            scanner%position = scanner%position + length + 1
            if (scanner%position > last) exit
            if (source%text(scanner%position:scanner%position) /= quote) exit
            token%text = token%text//quote
        end do
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
            if (.not. ok .or. times < 1 .or. times > LARGEST_REPEAT) then
                call fail_in_file(error, source%name, token%line, '"'//word_text//'": before '// &
                                  'the * must stand a repeat count of 1 to '// &
                                  integer_text(LARGEST_REPEAT), source%line(token%line))
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
        call fail_in_file(error, source%name, token%line, &
                          'a value is missing after "'//word_text//'"', source%line(token%line))
    end subroutine scan_word

    !> The characters from `position` to the next separator.
    pure function word_at(text, position) result(found)
        character(*), intent(in) :: text
        integer, intent(in) :: position
        character(:), allocatable :: found

        integer :: length

        length = scan(text(position:), SEPARATORS) - 1
        if (length < 0) length = len(text) - position + 1
        found = text(position:position + length - 1)
    end function word_at

    subroutine append_values(values, token)
        type(value_t), allocatable, intent(inout) :: values(:)
        type(token_t), intent(in) :: token

        type(value_t), allocatable :: longer(:)
        integer :: i, n

        n = size(values)
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

    ! Fetching values

    !> How often a group stands in the file.
    integer function group_count(self, group)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group       !! Its name, without the &

        integer :: i

        group_count = count_groups(self, lower_case(group))
        do i = 1, size(self%groups)
            if (self%groups(i)%name == lower_case(group)) self%groups(i)%used = .true.
        end do
        if (.not. any([(self%known(i)%group == lower_case(group), i=1, size(self%known))])) &
            call remember(self, lower_case(group), '')
    end function group_count

    pure integer function count_groups(self, name) result(n)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: name

        integer :: i

        n = 0
        do i = 1, size(self%groups)
            if (self%groups(i)%name == name) n = n + 1
        end do
    end function count_groups

    !> Does the key stand in the file? Asking does not mark it as used.
    logical function has(self, group, key, index)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: group, key
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        integer :: i

        i = group_position(self, group, index)
        has = i > 0
        if (has) has = position_of(self%groups(i), lower_case(key)) > 0
    end function has

    !> One real number. Fails when the key is missing and has no default, or its value is not one
    !> finite number within the limits (both ends included).
    subroutine get_real(self, group, key, value, error, default, low, high, unit, index)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key
        real(dp), intent(out) :: value
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: default, low, high
        character(*), intent(in), optional :: unit
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        type(entry_t) :: entry
        character(:), allocatable :: problem
        logical :: found

        value = 0
        if (present(default)) value = default
        call look_up(self, group, key, index, allowed_real(low, high, unit), 1, &
                     .not. present(default), entry, found, error)
        if (.not. found) return
        call real_from_value(entry%values(1), value, problem, low, high, unit)
        if (allocated(problem)) call reject(self, group, key, problem, error, index)
    end subroutine get_real

    !> As many real numbers as `value` has elements, each within the limits.
    subroutine get_reals(self, group, key, value, error, default, low, high, unit, index)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key
        real(dp), intent(out) :: value(:)
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: default(:)    !! As long as `value`
        real(dp), intent(in), optional :: low, high
        character(*), intent(in), optional :: unit
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        type(entry_t) :: entry
        character(:), allocatable :: problem
        logical :: found
        integer :: i

        value = 0
        if (present(default)) value = default
        call look_up(self, group, key, index, integer_text(size(value))//' numbers, each '// &
                     allowed_real(low, high, unit), size(value), .not. present(default), &
                     entry, found, error)
        if (.not. found) return
        do i = 1, size(value)
            call real_from_value(entry%values(i), value(i), problem, low, high, unit)
            if (.not. allocated(problem)) cycle
            call reject(self, group, key, 'value '//integer_text(i)//': '//problem, error, index, &
                        item=i)
            return
        end do
    end subroutine get_reals

    subroutine real_from_value(given, value, problem, low, high, unit)
        type(value_t), intent(in) :: given
        real(dp), intent(out) :: value
        character(:), allocatable, intent(out) :: problem
        real(dp), intent(in), optional :: low, high
        character(*), intent(in), optional :: unit

        if (given%quoted) then
            value = 0
            problem = 'a text in quotes; it must be '//allowed_real(low, high, unit)
        else
            call real_from_text(given%text, value, problem, low, high, unit)
        end if
    end subroutine real_from_value

    !> One integer.
    subroutine get_integer(self, group, key, value, error, default, low, high, index)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key
        integer, intent(out) :: value
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: default, low, high
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        type(entry_t) :: entry
        character(:), allocatable :: problem
        logical :: found

        value = 0
        if (present(default)) value = default
        call look_up(self, group, key, index, allowed_integer(low, high), 1, &
                     .not. present(default), entry, found, error)
        if (.not. found) return
        if (entry%values(1)%quoted) then
            problem = 'a text in quotes; it must be '//allowed_integer(low, high)
        else
            call integer_from_text(entry%values(1)%text, value, problem, low, high)
        end if
        if (allocated(problem)) call reject(self, group, key, problem, error, index)
    end subroutine get_integer

    !> One logical.
    subroutine get_logical(self, group, key, value, error, default, index)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key
        logical, intent(out) :: value
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: default
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        type(entry_t) :: entry
        character(:), allocatable :: problem
        logical :: found

        value = .false.
        if (present(default)) value = default
        call look_up(self, group, key, index, '.true. or .false.', 1, .not. present(default), &
                     entry, found, error)
        if (.not. found) return
        if (entry%values(1)%quoted) then
            problem = 'a text in quotes; it must be .true. or .false. without quotes'
        else
            call logical_from_text(entry%values(1)%text, value, problem)
        end if
        if (allocated(problem)) call reject(self, group, key, problem, error, index)
    end subroutine get_logical

    !> One text in quotes; with `choices`, one of these, in whatever case, returned in their
    !> spelling.
    subroutine get_text(self, group, key, value, error, default, choices, index)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key
        character(:), allocatable, intent(out) :: value
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: default
        character(*), intent(in), optional :: choices(:)
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        type(entry_t) :: entry
        character(:), allocatable :: problem, allowed
        logical :: found

        value = ''
        if (present(default)) value = default
        allowed = 'a text in quotes'
        if (present(choices)) allowed = allowed//', '//allowed_choice(choices)
        call look_up(self, group, key, index, allowed, 1, .not. present(default), entry, found, &
                     error)
        if (.not. found) return
        value = entry%values(1)%text
        if (.not. entry%values(1)%quoted) then
            problem = value//' is not in quotes; it must be '//allowed
        else if (present(choices)) then
            call choice_from_text(entry%values(1)%text, choices, value, problem)
        end if
        if (allocated(problem)) call reject(self, group, key, problem, error, index)
    end subroutine get_text

    !> Finds an entry and marks it as used. Fails when it is missing but required, or has another
    !> number of values.
    subroutine look_up(self, group, key, index, allowed, number_of_values, required, entry, &
                       found, error)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key
        integer, intent(in), optional :: index
        character(*), intent(in) :: allowed         !! What the value must be
        integer, intent(in) :: number_of_values
        logical, intent(in) :: required
        type(entry_t), intent(out) :: entry
        logical, intent(out) :: found               !! False too after a failure
        type(error_t), allocatable, intent(out) :: error

        integer :: i, j

        call remember(self, lower_case(group), lower_case(key))
        i = group_position(self, group, index)
        j = 0
        if (i > 0) then
            self%groups(i)%used = .true.
            j = position_of(self%groups(i), lower_case(key))
        end if
        found = j > 0
        if (.not. found) then
            if (required) &
                call fail_missing(self, lower_case(group), lower_case(key), i, index, allowed, &
                                  error)
            return
        end if
        self%groups(i)%entries(j)%used = .true.
        entry = self%groups(i)%entries(j)
        found = size(entry%values) == number_of_values
        if (.not. found) &
            call reject(self, group, key, integer_text(size(entry%values))//' values; it must '// &
                        'be '//allowed, error, index)
    end subroutine look_up

    subroutine fail_missing(self, group, key, position, index, allowed, error)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: group, key
        integer, intent(in) :: position             !! Of the group; 0 when that is missing too
        integer, intent(in), optional :: index
        character(*), intent(in) :: allowed
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: unused(:)
        character(:), allocatable :: needed, name, near
        integer :: j

        name = 'group &'//group
        if (present(index)) name = name//' number '//integer_text(index)
        needed = 'the key "'//key//'" ('//allowed//')'
        if (position == 0) then
            call fail_in_file(error, self%source%name, 0, 'the '//name// &
                              ' is missing; it must have '//needed)
            return
        end if
        allocate (unused(0))
        do j = 1, size(self%groups(position)%entries)
            associate (entry => self%groups(position)%entries(j))
                if (.not. entry%used) call append(unused, entry%key)
            end associate
        end do
        near = nearest_name(key, padded(unused))
        if (near /= '') near = '; is "'//near//'" there a misspelling of it?'
        call fail_at_line(self, self%groups(position)%line, needed//' is missing in the '//name// &
                          near, error)
    end subroutine fail_missing

    !> A failure about the value of a key, for a check of the caller's own: names file, line and
    !> key, and shows the line.
    subroutine reject(self, group, key, problem, error, index, item)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: group, key
        character(*), intent(in) :: problem     !! What is wrong with it, and what is allowed
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: index  !! Which group of that name; 1 if absent
        integer, intent(in), optional :: item   !! Which of the values; the first if absent

        character(:), allocatable :: message
        integer :: i, j, k

        message = 'key "'//lower_case(key)//'" of group &'//lower_case(group)//': '//problem
        i = group_position(self, group, index)
        j = 0
        if (i > 0) j = position_of(self%groups(i), lower_case(key))
        if (j == 0) then
            call fail_in_file(error, self%source%name, 0, message)
            return
        end if
        k = 1
        if (present(item)) k = item
        call fail_at_line(self, self%groups(i)%entries(j)%values(k)%line, message, error)
    end subroutine reject

    !> Fails for the first group or key of the file that nobody asked for.
    subroutine check_all_used(self, error)
        class(namelist_file_t), intent(in) :: self
        type(error_t), allocatable, intent(out) :: error

        integer :: i, j

        do i = 1, size(self%groups)
            if (.not. self%groups(i)%used) then
                call fail_unknown_group(self, self%groups(i), error)
                return
            end if
            do j = 1, size(self%groups(i)%entries)
                if (self%groups(i)%entries(j)%used) cycle
                call fail_unknown_key(self, self%groups(i)%name, self%groups(i)%entries(j), error)
                return
            end do
        end do
    end subroutine check_all_used

    subroutine fail_unknown_group(self, group, error)
        class(namelist_file_t), intent(in) :: self
        type(group_t), intent(in) :: group
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: names(:), problem

        names = known_names(self)
        if (any(names == group%name)) then
            problem = ' stands here once too often'
        else
            problem = ' is not known'//did_you_mean(group%name, names)// &
                      '; known: '//join(names, ', ')
        end if
        call fail_at_line(self, group%line, 'the group &'//group%name//problem, error)
    end subroutine fail_unknown_group

    subroutine fail_unknown_key(self, group, entry, error)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: group
        type(entry_t), intent(in) :: entry
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: names(:)

        names = known_names(self, group)
        call fail_at_line(self, entry%line, &
                          'the key "'//entry%key//'" is not known in the group &'//group// &
                          did_you_mean(entry%key, names)//'; known: '//join(names, ', '), error)
    end subroutine fail_unknown_key

    !> The keys of a group that were asked for; without `group`, the groups.
    function known_names(self, group) result(names)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in), optional :: group
        character(:), allocatable :: names(:)

        type(string_t), allocatable :: found(:)
        integer :: i

        allocate (found(0))
        do i = 1, size(self%known)
            associate (known => self%known(i))
                if (.not. present(group)) then
                    if (any(padded(found) == known%group)) cycle
                    call append(found, known%group)
                else if (known%group == group .and. known%key /= '') then
                    call append(found, known%key)
                end if
            end associate
        end do
        names = padded(found)
    end function known_names

    !> Notes that a key was asked for, once.
    subroutine remember(self, group, key)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key

        type(known_t), allocatable :: longer(:)
        integer :: i, n

        n = size(self%known)
        do i = 1, n
            if (self%known(i)%group == group .and. self%known(i)%key == key) return
        end do
        allocate (longer(n + 1))
        longer(:n) = self%known
        longer(n + 1)%group = group
        longer(n + 1)%key = key
        call move_alloc(longer, self%known)
    end subroutine remember

    !> Position of a group in the file's list; 0 when it is not there.
    pure integer function group_position(self, name, index) result(position)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: name
        integer, intent(in), optional :: index

        integer :: wanted

        wanted = 1
        if (present(index)) wanted = index
        do position = 1, size(self%groups)
            if (self%groups(position)%name == lower_case(name) .and. &
                self%groups(position)%index == wanted) return
        end do
        position = 0
    end function group_position

    !> Position of a key in a group; 0 when it is not there.
    pure integer function position_of(group, key) result(position)
        type(group_t), intent(in) :: group
        character(*), intent(in) :: key     !! Lower case

        do position = 1, size(group%entries)
            if (group%entries(position)%key == key) return
        end do
        position = 0
    end function position_of

    subroutine fail_at_line(self, line, message, error)
        class(namelist_file_t), intent(in) :: self
        integer, intent(in) :: line
        character(*), intent(in) :: message
        type(error_t), allocatable, intent(out) :: error

        call fail_in_file(error, self%source%name, line, message, self%source%line(line))
    end subroutine fail_at_line

    ! Writing

    !> A line of comment.
    subroutine write_comment(self, text)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: text

        call put(self, trim('! '//text))
    end subroutine write_comment

    !> Begins a group.
    subroutine write_group(self, name)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: name

        call put(self, '&'//name)
    end subroutine write_group

    subroutine write_end_group(self)
        class(namelist_writer_t), intent(inout) :: self

        call put(self, '/')
    end subroutine write_end_group

    subroutine write_real(self, key, value, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        real(dp), intent(in) :: value
        character(*), intent(in), optional :: comment

        call write_reals(self, key, [value], comment)
    end subroutine write_real

    subroutine write_reals(self, key, values, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        real(dp), intent(in) :: values(:)
        character(*), intent(in), optional :: comment

        character(:), allocatable :: text
        integer :: i

        if (.not. all(ieee_is_finite(values)) .or. size(values) == 0) &
            call refuse(self, 'key "'//key//'": its value is not a finite number')
        text = ''
        do i = 1, size(values)
            if (i > 1) text = text//', '
            text = text//real_text(values(i))
        end do
        call put_entry(self, key, text, comment)
    end subroutine write_reals

    subroutine write_integer(self, key, value, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        integer, intent(in) :: value
        character(*), intent(in), optional :: comment

        call put_entry(self, key, integer_text(value), comment)
    end subroutine write_integer

    subroutine write_logical(self, key, value, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key
        logical, intent(in) :: value
        character(*), intent(in), optional :: comment

        call put_entry(self, key, trim(merge('.true. ', '.false.', value)), comment)
    end subroutine write_logical

    subroutine write_text(self, key, value, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, value
        character(*), intent(in), optional :: comment

        character(:), allocatable :: text
        integer :: i

        if (scan(value, LF//CR) > 0) &
            call refuse(self, 'key "'//key//'": a text must stand in one line')
        text = ''
        do i = 1, len(value)
            text = text//value(i:i)
            if (value(i:i) == '''') text = text//''''
        end do
        call put_entry(self, key, ''''//text//'''', comment)
    end subroutine write_text

    subroutine put_entry(self, key, value, comment)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, value
        character(*), intent(in), optional :: comment

        if (present(comment)) then
            call put(self, '    '//key//' = '//value//'  ! '//trim(comment))
        else
            call put(self, '    '//key//' = '//value)
        end if
    end subroutine put_entry

    subroutine put(self, line)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: line

        if (allocated(self%content)) then
            self%content = self%content//LF//line
        else
            self%content = line
        end if
    end subroutine put

    !> Notes the first thing that cannot be written.
    subroutine refuse(self, message)
        class(namelist_writer_t), intent(inout) :: self
        character(*), intent(in) :: message

        if (.not. allocated(self%failure)) call fail(self%failure, message)
    end subroutine refuse

    !> What was written so far, without a line end at the end. Fails when something could not be
    !> written: a number that is not finite, a text of several lines.
    subroutine to_text(self, text, error)
        class(namelist_writer_t), intent(in) :: self
        character(:), allocatable, intent(out) :: text
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) error = self%failure
        text = ''
        if (allocated(self%content)) text = self%content
    end subroutine to_text

    !> Saves what was written; fails as `to_text` does, or when the file cannot be written.
    subroutine save_namelist(self, path, error)
        class(namelist_writer_t), intent(in) :: self
        character(*), intent(in) :: path
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: text

        call self%to_text(text, error)
        if (allocated(error)) then
            error%message = trim(path)//': '//error%message
            return
        end if
        call file%open(path, error)
        if (allocated(error)) return
        call file%line(text)
        call file%commit(error)
    end subroutine save_namelist
end module gracecg_namelist
