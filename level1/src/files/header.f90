!> Headers of Level-1 files: recognised by their first bytes, YAML (GRACE-FO text) or cards of 80 characters
!> (GRACE, and some products of GRACE-FO).
module gracecg_level1_header
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, fail_in_file
    use gracecg_base_text, only: string_t, append, parse_integer, parse_real, integer_text, lower_case
    use gracecg_level1_products, only: is_level1_product
    implicit none
    private
    public :: level1_header_t, parse_level1_header, product_of_file_name, satellite_of_file_name, &
        date_of_file_name
    public :: FORM_YAML, FORM_CARDS, YAML_FIRST, YAML_LAST, CARDS_LAST, CARD_LENGTH, LABEL_LENGTH

    integer, parameter :: FORM_YAML = 1, FORM_CARDS = 2             !! Of headers
    !> First and last line of a header in YAML
    character(*), parameter :: YAML_FIRST = 'header:', YAML_LAST = '# End of YAML header'
    !> Last line of a header in cards
    character(*), parameter :: CARDS_LAST = 'END OF HEADER'
    integer, parameter :: CARD_LENGTH = 80      !! Characters of a card, without its line feed
    integer, parameter :: LABEL_LENGTH = 30     !! Characters before the colon of a card
    character(1), parameter :: LF = achar(10), CR = achar(13)
    character(*), parameter :: PLATFORMS = 'ABCDXY'

    !> What titles of GRACE-FO say, longer texts first
    character(32), parameter :: TITLES(13) = [character(32) :: 'transformed accelerometer', &
                                              'accelerometer housekeeping', 'accelerometer', 'star camera', 'imu', &
                                              'magnetometer', 'mass', 'thruster', 'tank', 'clock offset', 'clock', &
                                              'intermediate gps navigation', 'gps navigation']
    character(3), parameter :: TITLE_PRODUCTS(13) = ['ACT', 'AHK', 'ACC', 'SCA', 'IMU', 'MAG', 'MAS', 'THR', 'TNK', &
                                                     'CLK', 'TIM', 'GNI', 'GNV']

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
            if (header%form == FORM_YAML) then
                ended = index(text(first:last), YAML_LAST) == 1
                if (.not. ended) call take_yaml(text(first:last), header)
            else
                ended = index(text(first:last), CARDS_LAST) == 1
                if (.not. ended) call take_card(path, header%lines, text(first:last), header, has_format, error)
            end if
            if (allocated(error)) return
            first = next
        end do
        header%bytes = min(first - 1, len(text))
        if (.not. ended) then
            call fail_in_file(error, path, header%lines, 'the header has no end: expected a line "'// &
                              merge(YAML_LAST, CARDS_LAST//'       ', header%form == FORM_YAML)//'"')
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

    !> Takes what is wanted of a line of a YAML header.
    subroutine take_yaml(line, header)
        character(*), intent(in) :: line
        type(level1_header_t), intent(inout) :: header

        integer :: colon, records
        real(dp) :: time
        character(:), allocatable :: key, value

        colon = index(line, ':')
        if (colon == 0 .or. colon == len(line)) return
        key = trim(adjustl(line(:colon - 1)))
        if (all(key /= [character(24) :: 'num_records', 'platform', 'start_time_epoch_secs', 'stop_time_epoch_secs', &
                        'product_version', 'title', 'processing_level'])) return
        value = trim(adjustl(line(colon + 1:)))
        select case (key)
        case ('num_records')
            call take_integer(value, records, header)
            header%records = records
        case ('platform')
            header%satellite = satellite_of_text(value)
        case ('start_time_epoch_secs')
            call take_real(value, time, header)
            header%first_time = time
        case ('stop_time_epoch_secs')
            call take_real(value, time, header)
            header%last_time = time
        case ('product_version')
            header%version = value
        case ('title')
            call take_title(value, header)
        end select
    end subroutine take_yaml

    !> The product by a title: GRACE-FO Level-1A Magnetometer and Torque Rod Data.
    pure subroutine take_title(title, header)
        character(*), intent(in) :: title
        type(level1_header_t), intent(inout) :: header

        integer :: i, level

        level = index(title, 'Level-1')
        if (level == 0 .or. level + 7 > len(title)) return
        do i = 1, size(TITLES)
            if (index(lower_case(title(level + 8:)), trim(TITLES(i))) == 0) cycle
            header%product = TITLE_PRODUCTS(i)//'1'//title(level + 7:level + 7)
            exit
        end do
        if (.not. is_level1_product(header%product)) header%product = ''
    end subroutine take_title

    !> Takes what is wanted of a card.
    subroutine take_card(path, number, line, header, has_format, error)
        character(*), intent(in) :: path, line
        integer, intent(in) :: number
        type(level1_header_t), intent(inout) :: header
        logical, intent(inout) :: has_format
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: value
        integer :: records
        real(dp) :: time

        if (len(line) <= LABEL_LENGTH) return
        value = trim(adjustl(line(LABEL_LENGTH + 2:)))
        select case (line(:LABEL_LENGTH))
        case ('FILE FORMAT 0=BINARY 1=ASCII')
            if (value /= '0' .and. value /= '1') then
                call fail_in_file(error, path, number, 'the file format is "'//printable(value)// &
                                  '"; allowed are 0 (binary) and 1 (text)', printable(line))
                return
            end if
            has_format = .true.
            header%binary = value == '0'
        case ('SATELLITE NAME')
            header%satellite = satellite_of_text(value)
        case ('NUMBER OF DATA RECORDS')
            call take_integer(value, records, header)
            header%records = records
        case ('TIME FIRST OBS(SEC PAST EPOCH)')
            call take_real(value, time, header)
            header%first_time = time
        case ('TIME LAST OBS(SEC PAST EPOCH)')
            call take_real(value, time, header)
            header%last_time = time
        case ('FILENAME')
            header%product = product_of_file_name(value)
        case ('SOFTWARE VERSION')
            header%version = value
        end select
    end subroutine take_card

    !> A number of records; one that cannot be read is noted and stays as it was.
    subroutine take_integer(value, number, header)
        character(*), intent(in) :: value
        integer, intent(out) :: number
        type(level1_header_t), intent(inout) :: header

        logical :: ok

        call parse_integer(first_word(value), number, ok)
        if (ok) ok = number >= 0
        if (ok) return
        number = -1
        call append(header%remarks, 'line '//integer_text(header%lines)//' of the header: "'//printable(value)// &
                    '" is no number of records')
    end subroutine take_integer

    !> A time; one that cannot be read is noted and is 0.
    subroutine take_real(value, number, header)
        character(*), intent(in) :: value
        real(dp), intent(out) :: number
        type(level1_header_t), intent(inout) :: header

        logical :: ok

        call parse_real(first_word(value), number, ok)
        if (.not. ok) call append(header%remarks, 'line '//integer_text(header%lines)//' of the header: "'// &
                                  printable(value)//'" is no time in seconds past 2000-01-01 12:00:00')
    end subroutine take_real

    pure integer function word_length(text) result(length)
        character(*), intent(in) :: text

        length = scan(text, ' (') - 1
        if (length < 0) length = len(text)
    end function word_length

    pure function first_word(text) result(word)
        character(*), intent(in) :: text
        character(word_length(text)) :: word

        word = text
    end function first_word

    !> A text for a message: bytes that are no printable characters as question marks, at most 200.
    pure function printable(text) result(shown)
        character(*), intent(in) :: text
        character(min(len(text), 200)) :: shown

        integer :: i

        do i = 1, len(shown)
            shown(i:i) = text(i:i)
            if (iachar(text(i:i)) < 32 .or. iachar(text(i:i)) > 126) shown(i:i) = '?'
        end do
    end function printable

    !> The satellite that 'GRACE C' names; blank when none.
    pure character(1) function satellite_of_text(text) result(satellite)
        character(*), intent(in) :: text

        satellite = ''
        if (len(text) == 0) return
        if (index(text, 'GRACE') /= 1) return
        if (scan(text(len(text):), PLATFORMS) == 1) satellite = text(len(text):)
    end function satellite_of_text

    !> Where the name of a file begins behind its folder.
    pure integer function start_of_name(path) result(start)
        character(*), intent(in) :: path

        start = index(path, '/', back=.true.) + 1
    end function start_of_name

    !> The product that a file's name begins with, as in ACC1A_2023-06-01_C_04.txt; blank when it does not.
    pure character(5) function product_of_file_name(path) result(product)
        character(*), intent(in) :: path    !! With or without folders

        integer :: start

        product = ''
        start = start_of_name(path)
        if (len(path) < start + 5) return
        if (path(start + 5:start + 5) == '_' .and. is_level1_product(path(start:start + 4))) &
            product = path(start:start + 4)
    end function product_of_file_name

    !> The satellite in a file's name, A to D, X or Y; blank when it is not of the form above.
    pure character(1) function satellite_of_file_name(path) result(satellite)
        character(*), intent(in) :: path    !! With or without folders

        integer :: start

        satellite = ''
        start = start_of_name(path)
        if (len(path) < start + 18) return
        if (path(start + 5:start + 5) /= '_' .or. path(start + 16:start + 16) /= '_' .or. &
            path(start + 18:start + 18) /= '_') return
        if (scan(path(start + 17:start + 17), PLATFORMS) == 1) satellite = path(start + 17:start + 17)
    end function satellite_of_file_name

    !> The date in a file's name, YYYY-MM-DD; blank when it is not of the form above.
    pure character(10) function date_of_file_name(path) result(date)
        character(*), intent(in) :: path    !! With or without folders

        integer :: start

        date = ''
        start = start_of_name(path)
        if (satellite_of_file_name(path) /= '') date = path(start + 6:start + 15)
    end function date_of_file_name
end module gracecg_level1_header
