!> Headers of Level-1 files: recognised by their first bytes, YAML (GRACE-FO text) or cards of 80 characters
!> (GRACE, and some products of GRACE-FO).
module gracecg_level1_header
    use gracecg_level1_basics
    use gracecg_base_error, only: fail_in_file
    use gracecg_level1_products, only: is_level1_product, FAMILIES, TITLES
    implicit none
    private
    public :: level1_header_t, parse_level1_header, product_of_file_name, satellite_of_file_name, &
        date_of_file_name, name_of, printable
    public :: YAML_FIRST, YAML_LAST, CARDS_LAST, CARD_LENGTH, LABEL_LENGTH

    integer, parameter :: FORM_YAML = 1, FORM_CARDS = 2             ! of headers
    !> First and last line of a header in YAML
    character(*), parameter :: YAML_FIRST = 'header:', YAML_LAST = '# End of YAML header'
    !> Last line of a header in cards
    character(*), parameter :: CARDS_LAST = 'END OF HEADER'
    character(20), parameter :: LAST_LINES(2) = [character(20) :: YAML_LAST, CARDS_LAST]        !! By form
    integer, parameter :: CARD_LENGTH = 80      !! Characters of a card, without its line feed
    integer, parameter :: LABEL_LENGTH = 30     !! Characters before the colon of a card
    character(1), parameter :: LF = achar(10), CR = achar(13)
    character(*), parameter :: PLATFORMS = 'ABCDXY'

    type :: level1_header_t
        !! What a header says; the records may say otherwise
        integer :: form = 0                         !! FORM_YAML or FORM_CARDS
        logical :: binary = .false.                 !! The records are binary
        character(5) :: product = ''                !! Blank: not said
        character(1) :: satellite = ''              !! A to D, X or Y for both; blank: not said
        integer :: records = -1                     !! Announced; -1: not said
        real(dp) :: first_time = 0, last_time = 0   !! Announced, s past 2000-01-01 12:00 GPS; 0: not said
        character(16) :: version = ''               !! Of the product
        integer :: lines = 0                        !! Of the header
        integer :: bytes = 0                        !! Of the header: the records begin behind it
        type(string_t), allocatable :: remarks(:)   !! What of it could not be read
    end type level1_header_t

contains

    !> The header at the beginning of a file. Fails when there is none, or it has no end within the text.
    subroutine parse_level1_header(path, text, header, error)
        character(*), intent(in) :: path    !! For messages
        character(*), intent(in) :: text    !! The beginning of the file
        type(level1_header_t), intent(out) :: header
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: problem
        integer :: first, last, next
        logical :: ended, has_format

        allocate (header%remarks(0))
        if (len(text) == 0) then
            call fail(error, path//': is empty; expected the header of a Level-1 file')
            return
        end if
        call line_at(text, 1, last, next)
        if (text(:last) == YAML_FIRST) then
            header%form = FORM_YAML
        else if (is_card(text(:last))) then
            header%form = FORM_CARDS
        else
            call fail_in_file(error, path, 1, 'this is no Level-1 file: it begins neither with "'//YAML_FIRST// &
                              '" nor with a line of 30 characters and a colon', printable(text(:min(last, CARD_LENGTH))))
            return
        end if
        has_format = header%form == FORM_YAML
        ended = .false.
        first = 1
        do while (first <= len(text) .and. .not. ended)
            call line_at(text, first, last, next)
            header%lines = header%lines + 1
            ended = index(text(first:last), trim(LAST_LINES(header%form))) == 1
            if (.not. ended) call take_line(text(first:last), header, has_format, problem)
            if (allocated(problem)) then
                call fail_in_file(error, path, header%lines, problem, printable(text(first:last)))
                return
            end if
            first = next
        end do
        header%bytes = min(first - 1, len(text))
        if (.not. ended) then
            call fail_in_file(error, path, header%lines, 'the header has no end: expected a line "'// &
                              trim(LAST_LINES(header%form))//'"')
        else if (.not. has_format) then
            call fail_in_file(error, path, header%lines, 'the header has no line "FILE FORMAT 0=BINARY 1=ASCII", '// &
                              'which says how the records are written')
        end if
    end subroutine parse_level1_header

    !> The line that begins at `first`: its last character without its end, and where the next one begins.
    pure subroutine line_at(text, first, last, next)
        character(*), intent(in) :: text
        integer, intent(in) :: first
        integer, intent(out) :: last, next

        integer :: length

        length = index(text(first:), LF)
        if (length == 0) length = len(text) - first + 2
        next = first + length
        last = next - 2
        if (last >= first) then
            if (text(last:last) == CR) last = last - 1
        end if
    end subroutine line_at

    pure logical function is_card(line)
        character(*), intent(in) :: line

        is_card = .false.
        if (len(line) > LABEL_LENGTH .and. len(line) <= CARD_LENGTH) &
            is_card = line(LABEL_LENGTH + 1:LABEL_LENGTH + 1) == ':'
    end function is_card

    !> Takes what is wanted of a line: key or label of a card, a colon, value. A number that cannot be read is noted.
    subroutine take_line(line, header, has_format, problem)
        character(*), intent(in) :: line
        type(level1_header_t), intent(inout) :: header
        logical, intent(inout) :: has_format                    !! The file format is known
        character(:), allocatable, intent(out) :: problem       !! Allocated when it is not allowed

        character(LABEL_LENGTH) :: key
        character(:), allocatable :: value, expected
        integer :: colon
        logical :: ok

        colon = index(line, ':')
        if (header%form == FORM_CARDS) colon = LABEL_LENGTH + 1
        if (colon == 0 .or. colon >= len(line)) return
        key = adjustl(line(:colon - 1))
        ok = .true.
        expected = 'time in seconds past 2000-01-01 12:00:00'
        value = trim(adjustl(line(colon + 1:)))
        select case (key)
        case ('FILE FORMAT 0=BINARY 1=ASCII')
            has_format = .true.
            header%binary = value == '0'
            if (value /= '0' .and. value /= '1') &
                problem = 'the file format is "'//printable(value)//'"; allowed are 0 (binary) and 1 (text)'
        case ('num_records', 'NUMBER OF DATA RECORDS')
            call parse_integer(first_word(value), header%records, ok)
            if (ok) ok = header%records >= 0
            if (.not. ok) header%records = -1
            expected = 'number of records'
        case ('platform', 'SATELLITE NAME')
            header%satellite = ''
            if (index(value, 'GRACE') == 1 .and. scan(value(max(1, len(value)):), PLATFORMS) == 1) &
                header%satellite = value(len(value):)       ! C of 'GRACE C'
        case ('start_time_epoch_secs', 'TIME FIRST OBS(SEC PAST EPOCH)')
            call parse_real(first_word(value), header%first_time, ok)
        case ('stop_time_epoch_secs', 'TIME LAST OBS(SEC PAST EPOCH)')
            call parse_real(first_word(value), header%last_time, ok)
        case ('product_version', 'SOFTWARE VERSION')
            header%version = value
        case ('title')
            call take_title(value, header)
        case ('FILENAME')
            header%product = product_of_file_name(value)
        end select
        if (.not. ok) call append(header%remarks, 'line '//integer_text(header%lines)//' of the header: "'// &
                                  printable(value)//'" is no '//expected)
    end subroutine take_line

    !> The product by a title: GRACE-FO Level-1A Magnetometer and Torque Rod Data.
    pure subroutine take_title(title, header)
        character(*), intent(in) :: title
        type(level1_header_t), intent(inout) :: header

        integer :: i, level

        level = index(title, 'Level-1')
        if (level == 0 .or. level + 7 > len(title)) return
        do i = 1, size(TITLES)
            if (index(lower_case(title(level + 8:)), lower_case(trim(TITLES(i)))) == 0) cycle
            header%product = FAMILIES(i)//'1'//title(level + 7:level + 7)
            exit
        end do
        if (.not. is_level1_product(header%product)) header%product = ''
    end subroutine take_title

    !> What stands before a blank or bracket.
    pure function first_word(text) result(word)
        character(*), intent(in) :: text
        character(scan(text//' ', ' (') - 1) :: word

        word = text(:scan(text//' ', ' (') - 1)
    end function first_word

    !> A text for a message: bytes that are no printable characters as question marks, at most 200.
    pure function printable(text) result(shown)
        character(*), intent(in) :: text    !! Any bytes
        character(min(len(text), 200)) :: shown

        integer :: i

        do i = 1, len(shown)
            shown(i:i) = text(i:i)
            if (iachar(text(i:i)) < 32 .or. iachar(text(i:i)) > 126) shown(i:i) = '?'
        end do
    end function printable

    !> How many letters of a path name folders.
    pure integer function folders_in(path)
        character(*), intent(in) :: path

        folders_in = index(path, '/', back=.true.)
    end function folders_in

    !> A file's name without its folders.
    pure function name_of(path) result(name)
        character(*), intent(in) :: path    !! With or without folders
        character(len(path) - folders_in(path)) :: name

        name = path(folders_in(path) + 1:)
    end function name_of

    !> The product that a file's name begins with, as in ACC1A_2023-06-01_C_04.txt; blank when it does not, and of the reports
    !> (.rpt) that stand beside the files of GRACE.
    pure character(5) function product_of_file_name(path) result(product)
        character(*), intent(in) :: path    !! With or without folders

        character(6) :: name

        name = name_of(path)
        product = ''
        if (name(6:6) == '_') product = name(:5)
        if (.not. is_level1_product(product) .or. lower_case(path(max(1, len_trim(path) - 3):)) == '.rpt') product = ''
    end function product_of_file_name

    !> The satellite in a file's name, A to D, X or Y; blank when it is not of the form above.
    pure character(1) function satellite_of_file_name(path) result(satellite)
        character(*), intent(in) :: path    !! With or without folders

        character(19) :: name

        name = name_of(path)
        satellite = ''
        if (name(6:6)//name(17:17)//name(19:19) == '___' .and. scan(name(18:18), PLATFORMS) == 1) satellite = name(18:18)
    end function satellite_of_file_name

    !> The date in a file's name, YYYY-MM-DD; blank when it is not of the form above.
    pure character(10) function date_of_file_name(path) result(date)
        character(*), intent(in) :: path    !! With or without folders

        character(16) :: name

        name = name_of(path)
        date = ''
        if (satellite_of_file_name(path) /= '') date = name(7:16)
    end function date_of_file_name
end module gracecg_level1_header
