!> Level-1 text as binary and binary as text: the same records in the other form. And orbits, attitudes and other series as files of
!> others (GROOPS, CCSDS), and from them.
!>
!> Instrument files of GROOPS as text (and, to be read, its matrix files and bare columns with the same numbers): a first line
!> `groops instrument version=N`, type and number of arcs, and for each arc the number of its epochs and their lines: MJD in GPS
!> time, values in SI or, as it takes them from Level-1 files, in their units. An orbit is inertial and has accelerations behind
!> position and velocity, here 0; a quaternion turns SRF into inertial axes as an active rotation, which are the numbers of SCA1B.
!> Source: fileInstrument, fileMatrix, archiveAscii and rotary3d of github.com/groops-devs/groops.
!>
!> Orbits and attitudes as messages of CCSDS, lines `KEY = VALUE` (KVN): OEM (502.0-B) with km and km/s, AEM (504.0-B) with
!> quaternions from inertial to body axes, direction and order of the parts said. Epochs are written in GPS time; read are GPS,
!> TAI, TT and UTC. An AEM of version 2 has no ATTITUDE_DIR (it goes from A to B) and no QUATERNION_TYPE (the scalar is last).
module gracecg_level1_conversion
    use gracecg_level1_basics
    use gracecg_base_constants, only: KILOMETRE
    use gracecg_base_version, only: VERSION
    use gracecg_environment_time, only: parse_utc, utc_text, seconds_between, GPS_EPOCH
    use gracecg_files_file, only: input_stream_t, output_file_t, text_file_t, read_text_file
    use gracecg_level1_exchange_series, only: exchange_series_t, series_of_level1, write_as_level1, kind_of_product, &
        EXCHANGE_KINDS, ORBIT, ATTITUDE, make_room, keep_first
    use gracecg_level1_header, only: level1_header_t, product_of_file_name
    use gracecg_level1_products, only: SATELLITES
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t
    use gracecg_level1_summary, only: level1_summary_t, summarise_level1
    use gracecg_level1_time, only: gps_date_text
    use gracecg_level1_writer, only: level1_writer_t
    implicit none
    private
    public :: convert_level1, exchange_level1, FORMS

    !> Forms of a file that is written: the other one of Level-1 (of a file of others: Level-1 text), GROOPS, CCSDS
    character(6), parameter :: FORMS(3) = [character(6) :: 'level1', 'groops', 'ccsds']

    character(*), parameter :: GROOPS_VERSION = '20200123'
    integer(i8), parameter :: DAY = 86400, NOON = 43200
    integer, parameter :: MJD_2000 = 51544

    character(*), parameter :: CCSDS_MARK = 'CCSDS_'    !! What a message begins with
    real(dp), parameter :: TAI_LATER = 19, TT_LATER = 51.184_dp     ! than GPS time, s
    character(10), parameter :: DESIGNATORS(4) = [character(10) :: '2002-012A', '2002-012B', '2018-047A', '2018-047B']
    character(10), parameter :: NAMES(4) = [character(10) :: 'GRACE 1', 'GRACE 2', 'GRACE-FO 1', 'GRACE-FO 2']
    character(8), parameter :: INERTIAL(4) = [character(8) :: 'ICRF', 'GCRF', 'EME2000', 'J2000']
    !> Keys whose values count: the others are passed over
    character(16), parameter :: KEYS(8) = [character(16) :: 'OBJECT_ID', 'CENTER_NAME', 'REF_FRAME', 'TIME_SYSTEM', &
                                           'REF_FRAME_A', 'REF_FRAME_B', 'ATTITUDE_DIR', 'QUATERNION_TYPE']
    integer, parameter :: OBJECT = 1, CENTER = 2, FRAME = 3, TIME_SYSTEM = 4, FRAME_A = 5, FRAME_B = 6, DIRECTION = 7, ORDER = 8

    type :: segment_t
        !! What the metadata of a segment say
        character(24) :: value(size(KEYS)) = ''
        character(8) :: version = ''            !! Of an AEM
        logical :: of_body_first = .false.      !! Quaternions are from body to inertial axes
        logical :: scalar_last = .false.
        logical :: complete = .false.           !! META_STOP is behind
    end type segment_t

contains

    !> Writes a file in a form: a Level-1 file in that of others, a file of others, which is recognised by its first bytes, as a
    !> Level-1 file. Fails as reading and writing do.
    subroutine exchange_level1(path, out, form, warnings, error)
        character(*), intent(in) :: path                        !! Of the file to read
        character(*), intent(in) :: out                         !! Of the file to write; of Level-1 its name says the product
        character(*), intent(in) :: form                        !! One of FORMS
        type(string_t), allocatable, intent(out) :: warnings(:) !! What is to be known
        type(error_t), allocatable, intent(out) :: error

        type(exchange_series_t) :: series
        type(input_stream_t) :: stream
        character(64) :: first
        integer :: n, wanted

        call stream%open(path, error)
        if (.not. allocated(error)) call stream%read(first, n, error)
        if (allocated(error)) return
        call stream%close()
        first(n + 1:) = ' '
        wanted = kind_of_product(product_of_file_name(out))
        if (form /= 'level1') then
            call series_of_level1(path, series, error)
            if (.not. allocated(error) .and. form == 'groops') call write_groops(series, out, error)
            if (.not. allocated(error) .and. form == 'ccsds') call write_ccsds(series, out, error)
            if (series%axes == 'E' .and. .not. allocated(error)) &
                call append(series%remarks, 'Level-1 files do not say which ITRF the orbit is in: ITRF2014 is written')
        else if (index(first, CCSDS_MARK) == 1 .or. index(first, 'groops ') == 1 .or. &
                 (wanted > 0 .and. scan(first, '0123456789') == verify(first, ' '))) then
            if (index(first, CCSDS_MARK) == 1) then
                call read_ccsds(path, series, error)
            else
                call read_groops(path, wanted, series, error)
            end if
            if (.not. allocated(error)) call write_as_level1(series, out, error)
        else
            call convert_level1(path, out, warnings, error)
            return
        end if
        if (.not. allocated(error)) call move_alloc(series%remarks, warnings)
    end subroutine exchange_level1

    !> Writes the records of a file in the other form: of text binary, of binary text (that of GRACE-FO for
    !> satellites C and D). Fails when the file is broken, its product has no binary form, or it cannot be written.
    subroutine convert_level1(path, out, warnings, error)
        character(*), intent(in) :: path                        !! Of the file to read
        character(*), intent(in) :: out                         !! Of the file to write
        type(string_t), allocatable, intent(out) :: warnings(:) !! Of reading, and what could not be kept
        type(error_t), allocatable, intent(out) :: error

        type(level1_summary_t) :: summary
        type(level1_reader_t) :: reader
        type(level1_block_t) :: block
        type(level1_writer_t) :: writer
        type(level1_header_t) :: header
        integer :: i

        allocate (warnings(0))
        if (path == out) then
            call fail(error, trim(path)//': input and output are the same file')
            return
        end if
        call summarise_level1(path, summary, error, with_fields=.false.)    ! the header tells what will follow
        if (allocated(error)) return
        header = summary%header
        header%satellite = summary%satellite
        if (scan(header%satellite, SATELLITES) == 0) header%satellite = 'C'
        header%records = int(summary%records)
        if (summary%records > 0) then
            header%first_time = real(summary%first_seconds, dp) + summary%first_fraction
            header%last_time = real(summary%last_seconds, dp) + summary%last_fraction
        end if
        call reader%open(path, error)
        if (.not. allocated(error)) call writer%open(out, reader%layout, .not. header%binary, header, error)
        if (allocated(error)) return
        do
            call reader%next(block, error)
            if (allocated(error)) then
                call writer%discard()
                return
            end if
            if (block%count == 0) exit
            do i = 1, block%count
                call writer%record(block%values(i, :))
            end do
        end do
        call writer%commit(error)
        if (allocated(error)) return
        warnings = [reader%warnings, writer%losses()]
    end subroutine convert_level1

    !> Writes a series as one arc. Fails for an Earth-fixed orbit, and when the file cannot be written.
    subroutine write_groops(series, path, error)
        type(exchange_series_t), intent(in) :: series
        character(*), intent(in) :: path    !! Of the file
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: line
        character(20) :: part
        integer(i8) :: since
        integer :: i, k

        if (series%kind == ORBIT .and. series%axes /= 'I') then
            call fail(error, path//': an orbit of GROOPS is inertial; take GNI1B, or write GNV1B as an OEM')
            return
        end if
        call file%open(path, error)
        if (allocated(error)) return
        associate (about => EXCHANGE_KINDS(series%kind))
            call file%line('groops instrument version='//GROOPS_VERSION)
            call file%line('# '//trim(about%name))
            call file%line(integer_text(about%code)//' 1 # instrument type, number of arcs')
            call file%line('# Time [MJD], GPS; '//trim(about%fields)//' as in Level-1 files')
        end associate
        call file%line(integer_text(size(series%seconds))//' # number of epochs of 1. arc')
        do i = 1, size(series%seconds)
            since = series%seconds(i) + NOON
            write (part, '(f20.18)') (real(modulo(since, DAY), dp) + series%fraction(i))/real(DAY, dp)
            line = integer_text(MJD_2000 + (since - modulo(since, DAY))/DAY)//part(2:)
            do k = 1, size(series%values, 1)
                line = line//' '//real_text(series%values(k, i))
            end do
            if (series%kind == ORBIT) line = line//' 0 0 0'
            call file%line(line)
        end do
        call file%commit(error)
    end subroutine write_groops

    !> Reads a series; arcs follow each other. Fails at the first line that is not as it has to be, and when the type is none of
    !> EXCHANGE_KINDS, or, of a matrix, another one than is wanted.
    subroutine read_groops(path, wanted, series, error)
        character(*), intent(in) :: path    !! Of the file
        integer, intent(in) :: wanted       !! Kind that a matrix file, which does not say its own, holds
        type(exchange_series_t), intent(out) :: series
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: file
        type(string_t), allocatable :: words(:)     ! of line `at`
        integer :: at, type, arcs, arc, epochs, i, n

        allocate (series%remarks(0))
        series%kind = wanted
        call read_text_file(path, file, error)
        if (allocated(error)) return
        at = 0
        n = 0
        call next_words()
        if (size(words) > 1 .and. index(file%line(1), 'instrument') > 0) then
            call next_words()
            call take_integers('instrument type and number of arcs', type, arcs)
            if (allocated(error)) return
            series%kind = findloc(EXCHANGE_KINDS%code, type, 1)
            if (series%kind == 0) call file%fail_at(at, 'instrument type '//integer_text(type)//' has no Level-1 product '// &
                                                    'here; -6, -7, -8, -16, -17 and -18 have', error)
            if (allocated(error)) return
            call make_room(series, file%line_count())
            do arc = 1, arcs
                call next_words()
                call take_integers('number of epochs', epochs)
                do i = 1, epochs
                    if (allocated(error)) return
                    call next_words()
                    call take_epoch()
                end do
                if (allocated(error)) return
            end do
        else
            call make_room(series, file%line_count())
            do while (size(words) > 0)
                if (scan(words(1)%text(1:1), '0123456789') > 0) call take_epoch()
                if (allocated(error)) return
                call next_words()
            end do
        end if
        call keep_first(series, n, path, error)

    contains

        !> The words of the next line that has any, without comments; none at the end.
        subroutine next_words()
            integer :: comment

            words = split_words('')
            do while (at < file%line_count() .and. size(words) == 0)
                at = at + 1
                comment = index(file%line(at)//'#', '#')
                associate (line => file%text(file%first(at):file%last(at)))
                    words = split_words(line(:min(len(line), comment - 1)))
                end associate
            end do
        end subroutine next_words

        !> One or two whole numbers that a line begins with.
        subroutine take_integers(what, first, second)
            character(*), intent(in) :: what
            integer, intent(out) :: first
            integer, intent(out), optional :: second

            logical :: ok

            first = 0
            ok = size(words) == merge(2, 1, present(second))
            if (ok) call parse_integer(words(1)%text, first, ok)
            if (ok .and. present(second)) call parse_integer(words(2)%text, second, ok)
            if (ok .and. .not. present(second)) ok = first >= 0
            if (.not. ok) call file%fail_at(at, 'expected: '//what, error)
        end subroutine take_integers

        !> A sample: MJD and values, in whole microseconds.
        subroutine take_epoch()
            real(dp) :: part, value
            integer :: k, point, mjd
            logical :: ok

            n = n + 1
            if (.not. fits(words, series%kind)) then
                associate (kind => EXCHANGE_KINDS(series%kind))
                    call file%fail_at(at, 'expected: MJD and '//integer_text(kind%columns)//' numbers of '// &
                                      trim(kind%name)//', here are '//integer_text(size(words)), error)
                end associate
                return
            end if
            associate (kind => EXCHANGE_KINDS(series%kind), word => words(1)%text)
                call parse_real(word, part, ok)
                if (ok) ok = part > MJD_2000 .and. part < 2*MJD_2000
                if (ok) mjd = floor(part)
                point = index(word, '.')
                if (ok .and. point > 1 .and. verify(word, '0123456789.') == 0) then     ! so that no digit of the day is lost
                    call parse_real('0'//word(point:)//'0', part, ok)
                else
                    part = part - floor(part)
                end if
                if (.not. ok) then
                    call file%fail_at(at, '"'//word//'" is no MJD since 2000', error)
                    return
                end if
                call put_time(series, n, (mjd - MJD_2000)*DAY - NOON, nint(part*real(DAY, dp)*1e6_dp, i8))
                do k = 2, size(words)
                    call parse_real(words(k)%text, value, ok)
                    if (.not. ok) then
                        call file%fail_at(at, 'column '//integer_text(k)//', "'//words(k)%text//'", is no number', error)
                        return
                    end if
                    if (k <= 1 + kind%columns) series%values(k - 1, n) = value
                end do
            end associate
        end subroutine take_epoch
    end subroutine read_groops

    !> Whether a line has an epoch and the numbers of a kind; behind an orbit's velocity may stand accelerations.
    pure logical function fits(words, kind)
        type(string_t), intent(in) :: words(:)
        integer, intent(in) :: kind         !! Of EXCHANGE_KINDS

        integer, parameter :: ACCELERATIONS = 3

        fits = size(words) == 1 + EXCHANGE_KINDS(kind)%columns .or. &
               (kind == ORBIT .and. size(words) == 1 + EXCHANGE_KINDS(kind)%columns + ACCELERATIONS)
    end function fits

    !> Puts the time of a sample.
    pure subroutine put_time(series, number, second, microseconds)
        type(exchange_series_t), intent(inout) :: series
        integer, intent(in) :: number               !! Of the sample
        integer(i8), intent(in) :: second           !! Whole seconds past 2000-01-01 12:00 GPS
        integer(i8), intent(in) :: microseconds     !! From there, any number

        integer(i8), parameter :: MILLION = 1000000

        series%seconds(number) = second + (microseconds - modulo(microseconds, MILLION))/MILLION
        series%fraction(number) = real(modulo(microseconds, MILLION), dp)/1e6_dp
    end subroutine put_time

    !> Writes an orbit as OEM, an attitude as AEM of version 1. Fails for other kinds, and when the file cannot be written.
    subroutine write_ccsds(series, path, error)
        type(exchange_series_t), intent(in) :: series
        character(*), intent(in) :: path    !! Of the file
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: line
        character(1) :: which
        integer :: i, k, satellite, n, now(8)
        real(dp) :: unit

        if (series%kind /= ORBIT .and. series%kind /= ATTITUDE) then
            call fail(error, path//': '//trim(EXCHANGE_KINDS(series%kind)%name)//' has no message of CCSDS; orbits (GNI1B, '// &
                      'GNV1B) and attitudes (SCA1B) have')
            return
        end if
        which = merge('O', 'A', series%kind == ORBIT)
        call file%open(path, error)
        if (allocated(error)) return
        satellite = max(1, index(SATELLITES, series%satellite))
        n = size(series%seconds)
        call date_and_time(values=now)
        call file%line('CCSDS_'//which//'EM_VERS = '//merge('2.0', '1.0', series%kind == ORBIT))
        call file%line('CREATION_DATE = '//utc_text(utc_plus(utc_of(now), -60.0_dp*now(4))))
        call file%line('ORIGINATOR = gracecg '//VERSION)
        call file%line('META_START')
        call file%line('OBJECT_NAME = '//trim(NAMES(satellite)))
        call file%line('OBJECT_ID = '//trim(DESIGNATORS(satellite)))
        call file%line('CENTER_NAME = EARTH')
        if (series%kind == ORBIT) then
            call file%line('REF_FRAME = '//trim(merge('GCRF    ', 'ITRF2014', series%axes == 'I')))
        else
            call file%line('REF_FRAME_A = GCRF')
            call file%line('REF_FRAME_B = SC_BODY_1')
            call file%line('ATTITUDE_DIR = A2B')
        end if
        call file%line('TIME_SYSTEM = GPS')
        call file%line('START_TIME = '//gps_date_text(series%seconds(1), series%fraction(1)))
        call file%line('STOP_TIME = '//gps_date_text(series%seconds(n), series%fraction(n)))
        if (series%kind == ATTITUDE) call file%line('ATTITUDE_TYPE = QUATERNION')
        if (series%kind == ATTITUDE) call file%line('QUATERNION_TYPE = FIRST')
        call file%line('META_STOP')
        if (series%kind == ATTITUDE) call file%line('DATA_START')
        unit = merge(KILOMETRE, 1.0_dp, series%kind == ORBIT)
        do i = 1, n
            line = gps_date_text(series%seconds(i), series%fraction(i))
            do k = 1, size(series%values, 1)
                line = line//' '//real_text(series%values(k, i)/unit)
            end do
            call file%line(line)
        end do
        if (series%kind == ATTITUDE) call file%line('DATA_STOP')
        call file%commit(error)
    end subroutine write_ccsds

    !> A time of the calendar as date_and_time gives it.
    type(utc_t) function utc_of(now) result(utc)
        integer, intent(in) :: now(8)

        character(19) :: text
        type(error_t), allocatable :: ignored

        write (text, '(i4.4, 2("-", i2.2), "T", i2.2, 2(":", i2.2))') now(1:3), now(5:7)
        call parse_utc(text, utc, ignored)
    end function utc_of
    !> Reads an orbit or an attitude; segments follow each other, covariances are passed over. Fails at the first line that is not
    !> as it has to be.
    subroutine read_ccsds(path, series, error)
        character(*), intent(in) :: path    !! Of the file
        type(exchange_series_t), intent(out) :: series
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: file
        type(segment_t) :: segment
        type(string_t), allocatable :: words(:)     ! of line i
        logical :: in_meta, in_covariance
        integer :: i, n

        allocate (series%remarks(0))
        call read_text_file(path, file, error)
        if (allocated(error)) return
        in_meta = .false.
        in_covariance = .false.
        n = 0
        do i = 1, file%line_count()
            words = split_words(file%line(i))
            if (size(words) == 0) cycle
            select case (words(1)%text)
            case ('COMMENT', 'DATA_START', 'DATA_STOP')
                cycle
            case ('META_START')
                segment = segment_t(version=segment%version)
                in_meta = .true.
            case ('META_STOP')
                call check_segment()
                in_meta = .false.
            case default
                if (index(words(1)%text, 'COVARIANCE_ST') == 1) then
                    in_covariance = words(1)%text == 'COVARIANCE_START'
                else if (in_covariance) then
                    cycle
                else if (index(file%line(i), '=') > 0) then
                    call take_key()
                else if (in_meta .or. .not. segment%complete) then
                    call file%fail_at(i, 'expected: KEY = VALUE', error)
                else
                    n = n + 1
                    call take_sample()
                end if
            end select
            if (allocated(error)) return
        end do
        if (series%kind == 0) call fail(error, path//': has no data')
        if (series%kind > 0) call keep_first(series, n, path, error)

    contains

        !> A line KEY = VALUE.
        subroutine take_key()
            character(24) :: key, value
            integer :: equals, k

            associate (line => file%text(file%first(i):file%last(i)))
                equals = index(line, '=')
                key = adjustl(line(:equals - 1))
                value = adjustl(line(equals + 1:))
            end associate
            k = findloc(KEYS, key, 1)
            if (k > 0) segment%value(k) = value
            select case (key)
            case ('CCSDS_OEM_VERS', 'CCSDS_AEM_VERS')
                series%kind = merge(ORBIT, ATTITUDE, key(7:7) == 'O')
                if (key(7:7) == 'A') segment%version = value
                call make_room(series, file%line_count())
            case ('ATTITUDE_TYPE')
                if (value /= 'QUATERNION') call file%fail_at(i, 'only QUATERNION is read', error)
            end select
            if (series%kind == 0) &
                call file%fail_at(i, 'expected: CCSDS_OEM_VERS or CCSDS_AEM_VERS; no other message is read', error)
            if (key == '') call file%fail_at(i, 'expected: KEY = VALUE', error)
        end subroutine take_key

        !> What the metadata have to say, at META_STOP.
        subroutine check_segment()
            character(1) :: axes, satellite
            character(24) :: from
            integer :: number

            if (series%kind == 0) then
                call file%fail_at(i, 'the file does not begin with CCSDS_OEM_VERS or CCSDS_AEM_VERS', error)
                return
            end if
            number = findloc(DESIGNATORS == segment%value(OBJECT), .true., 1)
            satellite = ''
            if (number > 0) satellite = SATELLITES(number:number)
            if (series%satellite /= '' .and. series%satellite /= satellite) &
                call file%fail_at(i, 'segments of two satellites', error)
            series%satellite = satellite
            call check_choice('TIME_SYSTEM', TIME_SYSTEM, [character(24) :: 'GPS', 'TAI', 'TT', 'UTC'], &
                              'is none of GPS, TAI, TT, UTC')
            from = segment%value(FRAME)
            if (series%kind == ATTITUDE) then
                from = segment%value(FRAME_A)
                segment%of_body_first = index(from, 'SC_BODY') == 1
                if (segment%of_body_first) from = segment%value(FRAME_B)
                if (index(segment%value(merge(FRAME_A, FRAME_B, segment%of_body_first)), 'SC_BODY') /= 1) &
                    call file%fail_at(i, 'REF_FRAME_A and REF_FRAME_B: one has to be inertial, the other SC_BODY_n', error)
                if (segment%value(DIRECTION) == 'B2A') segment%of_body_first = .not. segment%of_body_first
                call check_choice('ATTITUDE_DIR', DIRECTION, [character(24) :: '', 'A2B', 'B2A'], 'is neither A2B nor B2A')
                call check_choice('QUATERNION_TYPE', ORDER, [character(24) :: '', 'FIRST', 'LAST'], 'is neither FIRST nor LAST')
                if (segment%version(:1) == '1' .and. any(segment%value([DIRECTION, ORDER]) == '')) &
                    call file%fail_at(i, 'version 1 needs ATTITUDE_DIR and QUATERNION_TYPE', error)
                segment%scalar_last = segment%value(ORDER) /= 'FIRST'
            else
                call check_choice('CENTER_NAME', CENTER, [character(24) :: 'EARTH', 'Earth'], 'is not EARTH')
            end if
            segment%complete = .true.
            axes = merge('I', 'E', any(INERTIAL == from))
            if (axes == 'E' .and. (series%kind == ATTITUDE .or. index(from, 'ITRF') /= 1)) call file%fail_at(i, 'frame "'// &
                trim(from)//'" is none of ICRF, GCRF, EME2000 (and, of an orbit, ITRF...)', error)
            if (size(series%remarks) > 0 .and. axes /= series%axes) call file%fail_at(i, 'segments in two frames', error)
            series%axes = axes
            if (size(series%remarks) == 0) call append(series%remarks, 'frame '//trim(from)//', '// &
                trim(segment%value(TIME_SYSTEM))//' time'//pick_text(from == 'EME2000' .or. from == 'J2000', &
                '; EME2000 is 0.02 arcsec off ICRF, which is not counted', ''))
        end subroutine check_segment

        !> Fails when a key has another value than is allowed.
        subroutine check_choice(key, place, allowed, problem)
            character(*), intent(in) :: key, allowed(:), problem
            integer, intent(in) :: place        !! In KEYS

            if (all(allowed /= segment%value(place))) &
                call file%fail_at(i, key//' "'//trim(segment%value(place))//'" '//problem, error)
        end subroutine check_choice

        !> A sample: epoch and values, taken to GPS time, SI, and the quaternion's order and direction.
        subroutine take_sample()
            real(dp), parameter :: UNIT_WITHIN = 1e-3_dp
            type(utc_t) :: time
            real(dp) :: later, values(9)
            integer :: columns, k
            logical :: ok

            columns = EXCHANGE_KINDS(series%kind)%columns
            if (.not. fits(words, series%kind)) then
                call file%fail_at(i, 'expected: an epoch and '//integer_text(columns)//' numbers', error)
                return
            end if
            call parse_utc(words(1)%text, time, error)
            if (allocated(error)) then
                call file%fail_at(i, 'the epoch is not of the form 2023-06-01T00:00:00.0', error)
                return
            end if
            if (segment%value(TIME_SYSTEM) == 'UTC') then
                call put_time(series, n, nint(seconds_between(GPS_EPOCH, utc_t(time%mjd, 0.0_dp)), i8), &
                              nint(seconds_between(utc_t(time%mjd, 0.0_dp), time)*1e6_dp, i8))
            else
                later = 0
                if (segment%value(TIME_SYSTEM) == 'TAI') later = TAI_LATER
                if (segment%value(TIME_SYSTEM) == 'TT') later = TT_LATER
                call put_time(series, n, (time%mjd - MJD_2000)*DAY - NOON, nint((time%seconds - later)*1e6_dp, i8))
            end if
            do k = 2, size(words)
                call parse_real(words(k)%text, values(k - 1), ok)
                if (.not. ok) call file%fail_at(i, '"'//words(k)%text//'" is no number', error)
                if (.not. ok) return
            end do
            if (series%kind == ORBIT) then
                series%values(:, n) = values(:columns)*KILOMETRE
                return
            end if
            if (segment%scalar_last) values(:4) = values([4, 1, 2, 3])
            if (segment%of_body_first) values(2:4) = -values(2:4)
            if (abs(norm2(values(:4)) - 1) > UNIT_WITHIN) call file%fail_at(i, 'the quaternion is not of length 1', error)
            series%values(:, n) = values(:4)
        end subroutine take_sample
    end subroutine read_ccsds
end module gracecg_level1_conversion
