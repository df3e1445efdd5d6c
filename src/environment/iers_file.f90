!> UT1 and the pole from files of the IERS as they are published: finals2000A (all, data, daily; fixed columns) and
!> EOP C04 (series 14 and 20; fields between blanks).
!>
!> finals2000A: modified Julian day in columns 8-15, x_p 19-27 and y_p 38-46 (arcsec), UT1-UTC 59-68 (s); where the
!> prediction ends these are blank. C04: year, month, day, then the modified Julian day (series 14) or the hour and the
!> modified Julian day (series 20), then x_p, y_p (arcsec) and UT1-UTC (s). Lines before the first row are titles.
module gracecg_environment_iers_file
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: ARCSECOND, SECONDS_PER_DAY
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, split_words
    use gracecg_files_file, only: text_file_t, read_text_file
    use gracecg_files_value, only: real_from_text
    use gracecg_environment_time, only: utc_t, utc_text, tai_minus_utc
    use gracecg_environment_earth_orientation, only: earth_parameters_t
    implicit none
    private
    public :: read_earth_parameters

    integer, parameter :: MJD = 1, POLE_X = 2, POLE_Y = 3, UT1 = 4
    character(12), parameter :: NAMES(4) = [character(12) :: 'MJD', 'x of pole', 'y of pole', 'UT1-UTC']
    character(6), parameter :: UNITS(4) = [character(6) :: 'days', 'arcsec', 'arcsec', 's']
    real(dp), parameter :: LOW(4) = [33282.0_dp, -2.0_dp, -2.0_dp, -2.0_dp], HIGH(4) = [88433.0_dp, 2.0_dp, 2.0_dp, 2.0_dp]
    integer, parameter :: FIRST_COLUMN(4) = [8, 19, 38, 59], LAST_COLUMN(4) = [15, 27, 46, 68]  ! Of finals2000A
    integer, parameter :: FLAG_COLUMN = 17                                                      ! I or P

contains

    !> The parameters at a time, linear between the days (UT1-TAI, so that leap seconds do no harm). Fails, with file
    !> and line, for a file that is in neither format, for what is no number, days that do not rise, and a time outside.
    subroutine read_earth_parameters(path, utc, parameters, error)
        character(*), intent(in) :: path                !! Of the file
        type(utc_t), intent(in) :: utc
        type(earth_parameters_t), intent(out) :: parameters
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: file
        real(dp) :: row(4), before(4), slope(4), at_time(4), first, day
        integer :: i
        logical :: is_row, has_values, began

        call read_text_file(path, file, error)
        if (allocated(error)) return
        day = utc%mjd + utc%seconds/SECONDS_PER_DAY
        began = .false.
        first = 0
        before = 0
        do i = 1, file%line_count()
            call read_row(file, i, began, row, is_row, has_values, error)
            if (allocated(error)) return
            if (.not. is_row) cycle
            if (.not. has_values) exit
            if (began .and. .not. row(MJD) > before(MJD)) then
                call file%fail_at(i, 'the days must rise', error)
                return
            end if
            row(UT1) = row(UT1) - tai_minus_utc(utc_t(floor(row(MJD)), 0.0_dp))
            if (began .and. before(MJD) <= day .and. day <= row(MJD)) then
                slope = (row - before)/(row(MJD) - before(MJD))
                at_time = before + (day - before(MJD))*slope
                parameters%ut1_rate = slope(UT1)/SECONDS_PER_DAY
                parameters%ut1_minus_utc = at_time(UT1) + tai_minus_utc(utc)
                parameters%pole = at_time([POLE_X, POLE_Y])*ARCSECOND
                return
            end if
            if (.not. began) first = row(MJD)
            began = .true.
            before = row
        end do
        if (.not. began) then
            call fail(error, file%name//': no row of finals2000A or EOP C04 of the IERS was found')
        else
            call fail(error, file%name//': holds no UT1 and pole for '//utc_text(utc)//'; its days are '// &
                      day_text(first)//' to '//day_text(before(MJD)))
        end if
    end subroutine read_earth_parameters

    function day_text(day) result(text)
        real(dp), intent(in) :: day     !! Modified Julian
        character(10) :: text

        text = utc_text(utc_t(floor(day), 0.0_dp))
    end function day_text

    !> One line. Before the first row lines that are none are passed over.
    subroutine read_row(file, line, began, row, is_row, has_values, error)
        type(text_file_t), intent(in) :: file
        integer, intent(in) :: line
        logical, intent(in) :: began            !! A row was found before
        real(dp), intent(out) :: row(4)         !! MJD, x, y (arcsec), UT1-UTC (s)
        logical, intent(out) :: is_row, has_values
        type(error_t), allocatable, intent(out) :: error

        type(string_t) :: fields(4)
        type(string_t), allocatable :: words(:)
        character(:), allocatable :: text, problem
        integer :: k

        row = 0
        has_values = .true.
        text = file%line(line)
        is_row = text /= '' .and. index(adjustl(text), '#') /= 1
        if (.not. is_row) return
        if (is_of_finals(text)) then
            do k = 1, size(fields)
                fields(k)%text = trim(adjustl(text(min(FIRST_COLUMN(k), len(text) + 1):min(LAST_COLUMN(k), len(text)))))
            end do
            has_values = any([(fields(k)%text /= '', k=2, size(fields))])
            if (.not. has_values) return
        else
            words = split_words(text)
            is_row = size(words) >= 7
            if (is_row) is_row = verify(words(1)%text//words(2)%text//words(3)%text, '0123456789') == 0
            if (is_row) then
                k = merge(4, 5, len(words(4)%text) > 3)     ! the day of series 14, the hour of series 20
                is_row = size(words) >= k + 3
                if (is_row) fields = words(k:k + 3)
            end if
            if (.not. is_row) then
                if (began) call file%fail_at(line, 'is no row of finals2000A or EOP C04 of the IERS', error)
                return
            end if
        end if
        do k = 1, size(fields)
            call real_from_text(fields(k)%text, row(k), problem, LOW(k), HIGH(k), trim(UNITS(k)))
            if (.not. allocated(problem)) cycle
            call file%fail_at(line, trim(NAMES(k))//': '//problem, error)
            return
        end do
    end subroutine read_row

    !> A row of finals2000A: a day in its columns, and the flag of its pole.
    pure logical function is_of_finals(text) result(is)
        character(*), intent(in) :: text

        is = len(text) >= LAST_COLUMN(MJD)
        if (is) is = verify(text(FIRST_COLUMN(MJD):LAST_COLUMN(MJD)), '0123456789. ') == 0 .and. &
            text(FIRST_COLUMN(MJD) + 5:FIRST_COLUMN(MJD) + 5) == '.'
        if (is .and. len(text) >= FLAG_COLUMN) is = scan(text(FLAG_COLUMN:FLAG_COLUMN), 'IP ') == 1
    end function is_of_finals
end module gracecg_environment_iers_file
