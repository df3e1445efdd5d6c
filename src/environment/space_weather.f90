!> Solar flux and geomagnetic activity, as the thermosphere models of the report's time take them.
!>
!> F10.7 is the observed flux (not reduced to 1 au), in solar flux units, 1 sfu = 1e-22 W/(m^2 Hz).
!> Kp comes in thirds and stands in the tables as ten times the value, rounded: 27 is 2 2/3. It is
!> given out as the printed tenths, 2.7, which is what programs of the time used.
!>
!> Files as they are published are read too, and told apart by their first row: SW-All.csv of CelesTrak (columns by
!> name; celestrak.org/SpaceData), and Kp_ap_Ap_SN_F107_since_1932.txt or _nowcast.txt of GFZ Potsdam (28 columns; Kp
!> in decimal thirds, missing values negative), which has no mean of the flux: it is formed here.
module gracecg_environment_space_weather
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, fail_unknown_name
    use gracecg_base_text, only: string_t, integer_text, split, join
    use gracecg_files_table, only: table_file_t, read_table
    use gracecg_environment_time, only: utc_t, parse_utc, utc_text, utc_plus, check_utc_in_range
    use gracecg_environment_table_space_weather, only: SPACE_WEATHER_MJD, SPACE_WEATHER_F107, &
        SPACE_WEATHER_F107_MEAN, SPACE_WEATHER_KP_TENTHS
    implicit none
    private
    public :: space_weather_t, embedded_space_weather, read_space_weather
    public :: space_weather_source_t, SPACE_WEATHER_SOURCES

    type :: space_weather_t
        !! Indices by day; the days rise but may have gaps
        private
        integer, allocatable :: mjd(:)              !! Modified Julian day
        real(dp), allocatable :: f107(:)            !! Observed flux of the day, sfu
        real(dp), allocatable :: f107_mean(:)       !! Mean over 81 days centred on the day, sfu
        real(dp), allocatable :: kp(:, :)           !! (8, day): UT 0-3 h, 3-6 h ... 21-24 h
    contains
        procedure :: indices_at !! F10.7, its mean and Kp at a time
    end type space_weather_t

    !> Where flux and Kp come from
    character(16), parameter :: SPACE_WEATHER_SOURCES(3) = [character(16) :: 'table', 'given', 'file']

    type :: space_weather_source_t
        !! Where the indices come from
        character(16) :: source = 'table'           !! One of SPACE_WEATHER_SOURCES: the embedded table, ...
        real(dp) :: f107 = 150, f107_mean = 150     !! sfu, if given
        real(dp) :: kp = 2                          !! If given
        character(256) :: file = ''                 !! Path of the table, if 'file'
    contains
        procedure :: indices_at => indices_of_source    !! F10.7, its mean and Kp at a time
    end type space_weather_source_t

    integer, parameter :: INTERVALS = 8                 !! of Kp in a day
    real(dp), parameter :: INTERVAL_LENGTH = 10800.0_dp !! s

    real(dp), parameter :: FLUX_RANGE(2) = [50.0_dp, 1000.0_dp]     !! sfu

    ! SW-All.csv of CelesTrak: the columns that are used
    character(18), parameter :: CELESTRAK(11) = [character(18) :: 'DATE', 'KP1', 'KP2', 'KP3', 'KP4', 'KP5', 'KP6', &
                                                 'KP7', 'KP8', 'F10.7_OBS', 'F10.7_OBS_CENTER81']
    ! GFZ: year, month, day, days, mid of day, rotation, its day, 8 Kp, 8 ap, Ap, sunspots, F10.7 observed, adjusted, D
    integer, parameter :: GFZ_COLUMNS = 28, GFZ_FIRST_KP = 8, GFZ_F107 = 26
    integer, parameter :: MEAN_DAYS = 40    !! Before and after a day, of its mean over 81
    integer, parameter :: DAYS_NEEDED = 73  !! Of the 81, where single days have no flux
    character(*), parameter :: REMEDY = 'give f107, f107_mean and kp; in a case file by space_weather = ''given'', or by '// &
        'space_weather = ''file'' and space_weather_file a table of that time as SW-All.csv of CelesTrak'
    real(dp), parameter :: NONE = 0         !! In the place of a mean that cannot be formed

contains

    !> The embedded table: December 1988 to February 1989 (the report's epoch) and the year 2000.
    function embedded_space_weather() result(table)
        type(space_weather_t) :: table

        allocate (table%mjd, source=SPACE_WEATHER_MJD)
        allocate (table%f107, source=SPACE_WEATHER_F107)
        allocate (table%f107_mean, source=SPACE_WEATHER_F107_MEAN)
        allocate (table%kp(INTERVALS, size(SPACE_WEATHER_MJD)))
        table%kp = reshape(SPACE_WEATHER_KP_TENTHS/10.0_dp, shape(table%kp))
    end function embedded_space_weather

    !> The indices a thermosphere model wants at a time: the flux of the day before, the 81-day mean
    !> of the day, and Kp of the interval that holds the time three hours earlier. Fails outside the
    !> table.
    subroutine indices_at(self, utc, f107_previous_day, f107_mean, kp_3h_before, error, kp_6h_before)
        class(space_weather_t), intent(in) :: self
        type(utc_t), intent(in) :: utc
        real(dp), intent(out) :: f107_previous_day      !! Observed F10.7, sfu
        real(dp), intent(out) :: f107_mean              !! Observed F10.7, sfu
        real(dp), intent(out) :: kp_3h_before           !! 0 to 9
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(out), optional :: kp_6h_before !! Likewise six hours earlier

        character(:), allocatable :: spans
        integer :: today, yesterday

        f107_previous_day = 0
        f107_mean = 0
        kp_3h_before = 0
        if (present(kp_6h_before)) kp_6h_before = 0
        call check_utc_in_range(utc, error)
        if (allocated(error)) return
        today = row_of(self, utc%mjd)
        yesterday = row_of(self, utc%mjd - 1)
        if (today == 0 .or. yesterday == 0) then
            call write_spans(self%mjd, spans)
            call fail(error, 'no space weather for '//utc_text(utc)//': the table holds '// &
                      spans//', and the day before is needed too; '//REMEDY)
            return
        end if
        if (.not. self%f107_mean(today) > NONE) then
            call fail(error, 'no 81-day mean of F10.7 for '//date_text(utc%mjd)//': it needs the fluxes of the 40 days '// &
                      'before and after, and the table holds '//date_text(self%mjd(1))//' to '// &
                      date_text(self%mjd(size(self%mjd)))//'; '//REMEDY)
            return
        end if
        f107_previous_day = self%f107(yesterday)
        f107_mean = self%f107_mean(today)
        kp_3h_before = kp_earlier(INTERVAL_LENGTH)
        if (present(kp_6h_before)) kp_6h_before = kp_earlier(2*INTERVAL_LENGTH)

    contains

        real(dp) function kp_earlier(delay) result(kp)
            real(dp), intent(in) :: delay   !! s, at most a day

            type(utc_t) :: earlier
            integer :: interval

            earlier = utc_plus(utc, -delay)
            interval = min(int(earlier%seconds/INTERVAL_LENGTH) + 1, INTERVALS) ! leap second: the last
            kp = self%kp(interval, merge(today, yesterday, earlier%mjd == utc%mjd))
        end function kp_earlier
    end subroutine indices_at

    !> The same from where the source says.
    subroutine indices_of_source(self, utc, f107, f107_mean, kp, error, kp_6h_before)
        class(space_weather_source_t), intent(in) :: self
        type(utc_t), intent(in) :: utc
        real(dp), intent(out) :: f107, f107_mean    !! Observed F10.7, of the day before and mean, sfu
        real(dp), intent(out) :: kp                 !! 0 to 9
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(out), optional :: kp_6h_before !! Six hours earlier, if given: kp

        type(space_weather_t) :: table

        f107 = self%f107
        f107_mean = self%f107_mean
        kp = self%kp
        if (present(kp_6h_before)) kp_6h_before = self%kp
        select case (self%source)
        case ('given')
            return
        case ('table')
            table = embedded_space_weather()
        case ('file')
            call read_space_weather(trim(self%file), table, error)
        case default
            call fail_unknown_name(error, 'source of the space weather', trim(self%source), &
                                   SPACE_WEATHER_SOURCES)
        end select
        if (.not. allocated(error)) call table%indices_at(utc, f107, f107_mean, kp, error, kp_6h_before)
    end subroutine indices_of_source

    !> The row of a day, 0 when the table has none.
    pure integer function row_of(table, mjd) result(row)
        type(space_weather_t), intent(in) :: table
        integer, intent(in) :: mjd

        row = findloc(table%mjd, mjd, 1)
    end function row_of

    !> `1988-12-01 to 1989-02-28 and 2000-01-01 to 2000-12-31`.
    subroutine write_spans(mjd, text)
        integer, intent(in) :: mjd(:)
        character(:), allocatable, intent(out) :: text

        integer :: i, first

        text = ''
        first = 1
        do i = 1, size(mjd)
            if (i < size(mjd)) then
                if (mjd(i + 1) == mjd(i) + 1) cycle
            end if
            if (text /= '') text = text//' and '
            text = text//date_text(mjd(first))//' to '//date_text(mjd(i))
            first = i + 1
        end do
    end subroutine write_spans

    function date_text(mjd) result(text)
        integer, intent(in) :: mjd
        character(10) :: text

        text = utc_text(utc_t(mjd, 0.0_dp))
    end function date_text

    !> Reads SW-All.csv of CelesTrak or a file of GFZ. Fails with file and line for one that is neither, what is no
    !> number or out of range, and days that do not rise.
    subroutine read_space_weather(file, table, error)
        character(*), intent(in) :: file    !! Path of the table
        type(space_weather_t), intent(out) :: table
        type(error_t), allocatable, intent(out) :: error

        type(table_file_t) :: rows
        type(string_t), allocatable :: first(:)
        integer :: n        ! days so far

        call read_table(file, rows, error)
        if (allocated(error)) return
        first = rows%fields(1)
        n = rows%row_count()
        allocate (table%mjd(n), table%f107(n), table%f107_mean(n), table%kp(INTERVALS, n))
        n = 0
        if (index(first(1)%text, trim(CELESTRAK(1))//',') == 1) then
            call take_celestrak(rows, table, n, error)
        else
            call take_gfz(rows, table, n, error)
        end if
        if (allocated(error)) return
        table = space_weather_t(table%mjd(:n), table%f107(:n), table%f107_mean(:n), table%kp(:, :n))
        if (all(table%f107_mean <= NONE)) call form_means(table)
        if (n == 0) call fail(error, rows%text%name//': no day has Kp and F10.7')
    end subroutine read_space_weather

    !> SW-All.csv. Rows without Kp or flux, the monthly predictions, are passed over.
    subroutine take_celestrak(rows, table, n, error)
        type(table_file_t), intent(in) :: rows
        type(space_weather_t), intent(inout) :: table
        integer, intent(inout) :: n             ! days so far
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: words(:), fields(:)
        integer :: place(size(CELESTRAK)), i, k, mjd, before

        fields = rows%fields(1)
        words = split(fields(1)%text, ',')
        do k = 1, size(CELESTRAK)
            place(k) = findloc([(words(i)%text == CELESTRAK(k), i=1, size(words))], .true., 1)
            if (place(k) > 0) cycle
            call rows%fail_at(1, 'there is no column '//trim(CELESTRAK(k))//'; SW-All.csv of CelesTrak has '// &
                              join(CELESTRAK, ', '), error)
            return
        end do
        before = 0
        do i = 2, rows%row_count()
            fields = rows%fields(i)
            fields = split(fields(1)%text, ',')
            if (size(fields) /= size(words)) then
                call rows%fail_at(i, 'has '//integer_text(size(fields))//' columns, the header '// &
                                  integer_text(size(words)), error)
                return
            end if
            call read_day(rows, i, fields(place(1))%text, before, mjd, error)
            if (.not. any([(fields(place(k))%text == '', k=2, 10)])) &
                call add_day(table, n, rows, i, mjd, fields(place(2:9)), 0.1_dp, fields(place(10)), fields(place(11)), error)
            if (allocated(error)) return
        end do
    end subroutine take_celestrak

    !> Kp_ap_Ap_SN_F107_*.txt. Days of which a Kp or the flux is missing (negative) are passed over.
    subroutine take_gfz(rows, table, n, error)
        type(table_file_t), intent(in) :: rows
        type(space_weather_t), intent(inout) :: table
        integer, intent(inout) :: n             ! days so far
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: fields(:)
        real(dp) :: numbers(4:GFZ_COLUMNS)
        integer :: i, k, mjd, before

        before = 0
        do i = 1, rows%row_count()
            call rows%get_fields(i, GFZ_COLUMNS, 'year, month, day, days, middle of the day, rotation, its day, 8 Kp, '// &
                                 '8 ap, Ap, SN, F10.7 observed and adjusted, D, as in Kp_ap_Ap_SN_F107_since_1932.txt '// &
                                 '(or is it SW-All.csv of CelesTrak without its first line?)', fields, error)
            call read_day(rows, i, two_digits(fields(1)%text)//'-'//two_digits(fields(2)%text)//'-'// &
                          two_digits(fields(3)%text), before, mjd, error)
            do k = 4, GFZ_COLUMNS
                call rows%get_real(i, fields(k), 'column '//integer_text(k), numbers(k), error)
            end do
            if (.not. any(numbers([(GFZ_FIRST_KP + k, k=0, INTERVALS - 1), GFZ_F107]) < 0)) &
                call add_day(table, n, rows, i, mjd, fields(GFZ_FIRST_KP:GFZ_FIRST_KP + INTERVALS - 1), 1.0_dp, &
                             fields(GFZ_F107), string_t(''), error)
            if (allocated(error)) return
        end do
    end subroutine take_gfz

    !> Puts a day at the end of the table.
    subroutine add_day(table, n, rows, row, mjd, kp, unit, f107, f107_mean, error)
        type(space_weather_t), intent(inout) :: table
        integer, intent(inout) :: n
        type(table_file_t), intent(in) :: rows
        integer, intent(in) :: row, mjd
        type(string_t), intent(in) :: kp(INTERVALS), f107, f107_mean    ! fields; no mean: empty
        real(dp), intent(in) :: unit                                    ! Kp of a 1
        type(error_t), allocatable, intent(inout) :: error

        integer :: k

        n = n + 1
        table%mjd(n) = mjd
        do k = 1, INTERVALS
            call kp_of(rows, row, kp(k), unit, table%kp(k, n), error)
        end do
        call rows%get_real(row, f107, 'F10.7', table%f107(n), error, FLUX_RANGE(1), FLUX_RANGE(2), 'sfu')
        table%f107_mean(n) = NONE
        if (f107_mean%text /= '') call rows%get_real(row, f107_mean, '81-day mean of F10.7', table%f107_mean(n), error, &
                                                     FLUX_RANGE(1), FLUX_RANGE(2), 'sfu')
    end subroutine add_day

    !> The means over 81 days, where the table reaches over them and at most a tenth of them is missing.
    pure subroutine form_means(table)
        type(space_weather_t), intent(inout) :: table

        integer :: i, first, last, n

        n = size(table%mjd)
        first = 1
        last = 0
        do i = 1, n
            do while (table%mjd(first) < table%mjd(i) - MEAN_DAYS)
                first = first + 1
            end do
            do while (last < n)
                if (table%mjd(last + 1) > table%mjd(i) + MEAN_DAYS) exit
                last = last + 1
            end do
            if (table%mjd(1) > table%mjd(i) - MEAN_DAYS .or. table%mjd(n) < table%mjd(i) + MEAN_DAYS) cycle
            if (last - first + 1 >= DAYS_NEEDED) table%f107_mean(i) = sum(table%f107(first:last))/(last - first + 1)
        end do
    end subroutine form_means

    !> The day of a date, YYYY-MM-DD, which must follow the one before.
    subroutine read_day(rows, row, text, before, mjd, error)
        type(table_file_t), intent(in) :: rows
        integer, intent(in) :: row
        character(*), intent(in) :: text
        integer, intent(inout) :: before    ! the day of the row before; then of this one
        integer, intent(out) :: mjd
        type(error_t), allocatable, intent(inout) :: error

        type(utc_t) :: day
        type(error_t), allocatable :: complaint

        mjd = 0
        if (allocated(error)) return
        call parse_utc(text, day, complaint)
        mjd = day%mjd
        if (allocated(complaint)) then
            call rows%fail_at(row, complaint%message, error)
        else if (.not. mjd > before) then
            call rows%fail_at(row, 'the days must rise, and '//date_text(mjd)//' follows '//date_text(before), error)
        end if
        before = mjd
    end subroutine read_day

    !> A number of one digit with a 0 before it.
    pure function two_digits(text) result(padded)
        character(*), intent(in) :: text
        character(max(2, len(text))) :: padded

        padded = text
        if (len(text) == 1) padded = '0'//text
    end function two_digits

    !> Kp as printed tenths, of a number that is `unit` times Kp or rounded thirds of it.
    subroutine kp_of(rows, row, field, unit, kp, error)
        type(table_file_t), intent(in) :: rows
        integer, intent(in) :: row
        type(string_t), intent(in) :: field
        real(dp), intent(in) :: unit            !! Kp of a 1
        real(dp), intent(out) :: kp
        type(error_t), allocatable, intent(inout) :: error

        real(dp), parameter :: ROUNDING = 0.051_dp      ! of thirds in tenths
        real(dp) :: third

        call rows%get_real(row, field, 'Kp', kp, error)
        if (allocated(error)) return
        kp = unit*kp
        third = nint(3*max(-1.0_dp, min(10.0_dp, kp)))/3.0_dp
        if (third < 0 .or. third > 9 .or. abs(kp - third) > ROUNDING) then
            call rows%fail_at(row, 'Kp is given in thirds from 0 to 9, not "'//field%text//'"', error)
        end if
        kp = nint(10*third)/10.0_dp
    end subroutine kp_of
end module gracecg_environment_space_weather
