!> Orbits and attitudes as messages of CCSDS, lines `KEY = VALUE` (KVN): OEM (502.0-B) with km and km/s, AEM (504.0-B) with
!> quaternions from inertial to body axes, direction and order of the parts said. Epochs are written in GPS time; read are GPS,
!> TAI, TT and UTC. An AEM of version 2 has no ATTITUDE_DIR (it goes from A to B) and no QUATERNION_TYPE (the scalar is last).
module gracecg_level1_ccsds_form
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append, split_words, parse_real, integer_text, pick_text, real_text
    use gracecg_base_version, only: VERSION
    use gracecg_environment_time, only: utc_t, parse_utc, utc_plus, utc_text, seconds_between, GPS_EPOCH
    use gracecg_files_file, only: output_file_t, text_file_t, read_text_file
    use gracecg_level1_exchange_series, only: exchange_series_t, EXCHANGE_KINDS, ORBIT, ATTITUDE, make_room, keep_first
    use gracecg_level1_products, only: SATELLITES
    use gracecg_level1_time, only: gps_date_text
    implicit none
    private
    public :: write_ccsds, read_ccsds, CCSDS_MARK

    character(*), parameter :: CCSDS_MARK = 'CCSDS_'    !! What a message begins with
    real(dp), parameter :: KILOMETRE = 1e3_dp           ! m
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
        type(string_t), allocatable :: words(:)
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
            associate (key => words(1)%text)
                if (key == 'COMMENT' .or. key == 'DATA_START' .or. key == 'DATA_STOP') cycle
                if (key == 'META_START') segment = segment_t(version=segment%version)
                if (key == 'META_STOP') call check_segment(file, i, segment, series, error)
                if (key == 'META_START' .or. key == 'META_STOP') in_meta = key == 'META_START'
                if (index(key, 'COVARIANCE_ST') == 1) in_covariance = key == 'COVARIANCE_START'
                if (key == 'META_START' .or. key == 'META_STOP' .or. index(key, 'COVARIANCE_ST') == 1 .or. in_covariance) then
                    continue
                else if (index(file%line(i), '=') > 0) then
                    call take_key(file, i, words, segment, series, error)
                else if (in_meta .or. .not. segment%complete) then
                    call file%fail_at(i, 'expected: KEY = VALUE', error)
                else
                    n = n + 1
                    call take_sample(file, i, words, segment, series, n, error)
                end if
            end associate
            if (allocated(error)) return
        end do
        if (series%kind == 0) call fail(error, path//': has no data')
        if (series%kind > 0) call keep_first(series, n, path, error)
    end subroutine read_ccsds

    !> A line KEY = VALUE.
    subroutine take_key(file, at, words, segment, series, error)
        type(text_file_t), intent(in) :: file
        integer, intent(in) :: at
        type(string_t), intent(in) :: words(:)
        type(segment_t), intent(inout) :: segment
        type(exchange_series_t), intent(inout) :: series
        type(error_t), allocatable, intent(out) :: error

        character(24) :: key, value
        integer :: equals, i

        associate (line => file%text(file%first(at):file%last(at)))
            equals = index(line, '=')
            key = adjustl(line(:equals - 1))
            value = adjustl(line(equals + 1:))
        end associate
        i = findloc(KEYS, key, 1)
        if (i > 0) segment%value(i) = value
        select case (key)
        case ('CCSDS_OEM_VERS', 'CCSDS_AEM_VERS')
            series%kind = merge(ORBIT, ATTITUDE, key(7:7) == 'O')
            if (key(7:7) == 'A') segment%version = value
            call make_room(series, file%line_count())
        case ('ATTITUDE_TYPE')
            if (value /= 'QUATERNION') call file%fail_at(at, 'only QUATERNION is read', error)
        end select
        if (series%kind == 0) call file%fail_at(at, 'expected: CCSDS_OEM_VERS or CCSDS_AEM_VERS; no other message is read', error)
        if (size(words) > 0 .and. key == '') call file%fail_at(at, 'expected: KEY = VALUE', error)
    end subroutine take_key

    !> What the metadata have to say.
    subroutine check_segment(file, at, segment, series, error)
        type(text_file_t), intent(in) :: file
        integer, intent(in) :: at           !! Line of META_STOP
        type(segment_t), intent(inout) :: segment
        type(exchange_series_t), intent(inout) :: series
        type(error_t), allocatable, intent(out) :: error

        character(1) :: axes, satellite
        character(24) :: from
        integer :: number

        if (series%kind == 0) then
            call file%fail_at(at, 'the file does not begin with CCSDS_OEM_VERS or CCSDS_AEM_VERS', error)
            return
        end if
        number = findloc(DESIGNATORS == segment%value(OBJECT), .true., 1)
        satellite = ''
        if (number > 0) satellite = SATELLITES(number:number)
        if (series%satellite /= '' .and. series%satellite /= satellite) call file%fail_at(at, 'segments of two satellites', error)
        series%satellite = satellite
        if (all(segment%value(TIME_SYSTEM) /= [character(24) :: 'GPS', 'TAI', 'TT', 'UTC'])) &
            call file%fail_at(at, 'TIME_SYSTEM "'//trim(segment%value(TIME_SYSTEM))//'" is none of GPS, TAI, TT, UTC', error)
        from = segment%value(FRAME)
        if (series%kind == ATTITUDE) then
            from = segment%value(FRAME_A)
            segment%of_body_first = index(from, 'SC_BODY') == 1
            if (segment%of_body_first) from = segment%value(FRAME_B)
            if (index(segment%value(merge(FRAME_A, FRAME_B, segment%of_body_first)), 'SC_BODY') /= 1) &
                call file%fail_at(at, 'REF_FRAME_A and REF_FRAME_B: one has to be inertial, the other SC_BODY_n', error)
            if (segment%value(DIRECTION) == 'B2A') segment%of_body_first = .not. segment%of_body_first
            if (all(segment%value(DIRECTION) /= [character(24) :: '', 'A2B', 'B2A'])) &
                call file%fail_at(at, 'ATTITUDE_DIR "'//trim(segment%value(DIRECTION))//'" is neither A2B nor B2A', error)
            if (all(segment%value(ORDER) /= [character(24) :: '', 'FIRST', 'LAST'])) &
                call file%fail_at(at, 'QUATERNION_TYPE "'//trim(segment%value(ORDER))//'" is neither FIRST nor LAST', error)
            if (segment%version(:1) == '1' .and. any(segment%value([DIRECTION, ORDER]) == '')) &
                call file%fail_at(at, 'version 1 needs ATTITUDE_DIR and QUATERNION_TYPE', error)
            segment%scalar_last = segment%value(ORDER) /= 'FIRST'
        else if (segment%value(CENTER) /= 'EARTH' .and. segment%value(CENTER) /= 'Earth') then
            call file%fail_at(at, 'CENTER_NAME "'//trim(segment%value(CENTER))//'" is not EARTH', error)
        end if
        segment%complete = .true.
        axes = merge('I', 'E', any(INERTIAL == from))
        if (axes == 'E' .and. (series%kind == ATTITUDE .or. index(from, 'ITRF') /= 1)) call file%fail_at(at, 'frame "'// &
            trim(from)//'" is none of ICRF, GCRF, EME2000 (and, of an orbit, ITRF...)', error)
        if (size(series%remarks) > 0 .and. axes /= series%axes) call file%fail_at(at, 'segments in two frames', error)
        series%axes = axes
        if (size(series%remarks) == 0) call append(series%remarks, 'frame '//trim(from)//', '//trim(segment%value(TIME_SYSTEM))// &
            ' time'//pick_text(from == 'EME2000' .or. from == 'J2000', '; EME2000 is 0.02 arcsec off ICRF, which is not '// &
                               'counted', ''))
    end subroutine check_segment

    !> A sample: epoch and values, taken to GPS time, SI, and the quaternion's order and direction.
    subroutine take_sample(file, at, words, segment, series, number, error)
        type(text_file_t), intent(in) :: file
        integer, intent(in) :: at
        type(string_t), intent(in) :: words(:)
        type(segment_t), intent(in) :: segment
        type(exchange_series_t), intent(inout) :: series
        integer, intent(in) :: number       !! Of the sample
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: ACCELERATIONS = 3
        real(dp), parameter :: UNIT_WITHIN = 1e-3_dp
        type(utc_t) :: time
        real(dp) :: seconds, values(9)
        integer(i8) :: microseconds
        integer :: columns, k
        logical :: ok

        columns = EXCHANGE_KINDS(series%kind)%columns
        if (size(words) /= 1 + columns .and. .not. (series%kind == ORBIT .and. size(words) == 1 + columns + ACCELERATIONS)) then
            call file%fail_at(at, 'expected: an epoch and '//integer_text(columns)//' numbers', error)
            return
        end if
        call parse_utc(words(1)%text, time, error)
        if (allocated(error)) then
            call file%fail_at(at, 'the epoch is not of the form 2023-06-01T00:00:00.0', error)
            return
        end if
        seconds = 0
        if (segment%value(TIME_SYSTEM) == 'UTC') then
            microseconds = nint(seconds_between(utc_t(time%mjd, 0.0_dp), time)*1e6_dp, i8)
            series%seconds(number) = nint(seconds_between(GPS_EPOCH, utc_t(time%mjd, 0.0_dp)), i8)
        else
            if (segment%value(TIME_SYSTEM) == 'TAI') seconds = -TAI_LATER
            if (segment%value(TIME_SYSTEM) == 'TT') seconds = -TT_LATER
            microseconds = nint((time%seconds + seconds)*1e6_dp, i8)
            series%seconds(number) = (time%mjd - GPS_EPOCH%mjd)*86400_i8 - 43200_i8
        end if
        series%seconds(number) = series%seconds(number) + (microseconds - modulo(microseconds, 1000000_i8))/1000000_i8
        series%fraction(number) = real(modulo(microseconds, 1000000_i8), dp)/1e6_dp
        do k = 2, size(words)
            call parse_real(words(k)%text, values(k - 1), ok)
            if (.not. ok) call file%fail_at(at, '"'//words(k)%text//'" is no number', error)
            if (.not. ok) return
        end do
        if (series%kind == ORBIT) then
            series%values(:, number) = values(:columns)*KILOMETRE
            return
        end if
        if (segment%scalar_last) values(:4) = values([4, 1, 2, 3])
        if (segment%of_body_first) values(2:4) = -values(2:4)
        if (abs(norm2(values(:4)) - 1) > UNIT_WITHIN) call file%fail_at(at, 'the quaternion is not of length 1', error)
        series%values(:, number) = values(:4)
    end subroutine take_sample
end module gracecg_level1_ccsds_form
