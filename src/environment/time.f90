!> Time scales: UTC with its leap seconds, Terrestrial Time, and the turning of the Earth.
!>
!> A time is a `utc_t`: the day as a modified Julian day number and the seconds of that day, so that
!> nanoseconds survive. Only `parse_utc` makes one from text, and it refuses what the leap second
!> table does not cover; a time from elsewhere is checked by `check_utc_in_range`. The other
!> procedures here take checked times.
module gracecg_environment_time
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: TWO_PI, SECONDS_PER_DAY, DAYS_PER_CENTURY, HOUR_ANGLE, &
        EARTH_ROTATION_RATE
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: integer_text
    use gracecg_environment_table_leap_seconds, only: LEAP_SECOND_MJD, LEAP_SECOND_TAI_MINUS_UTC
    implicit none
    private
    public :: utc_t, parse_utc, check_utc_in_range, utc_text
    public :: utc_plus, seconds_between, time_tag, tai_minus_utc
    public :: julian_centuries_tt, decimal_year, day_of_year, local_mean_solar_time
    public :: gmst_1982, sidereal_angle
    public :: modified_julian_day, calendar_date
    public :: utc_of_gps, GPS_EPOCH

    type :: utc_t
        !! An instant of Coordinated Universal Time
        integer :: mjd = 0              !! Modified Julian day number of the UTC day
        real(dp) :: seconds = 0.0_dp
        !! SI seconds since 0 h of that day, 0 <= seconds < 86400 (86401 in a day that ends in a
        !! leap second)
    end type utc_t

    integer, parameter :: FIRST_YEAR = 1900, LAST_YEAR = 2100
    !! The oldest geomagnetic models are of 1900. UTC has whole leap seconds since 1972; before, a date
    !! counts as Universal Time with TAI - UTC held at its first value, so that TT is up to 45 s off
    integer, parameter :: FIRST_MJD = 15020     !! 1900-01-01
    integer, parameter :: LAST_MJD = 88433      !! 2100-12-31
    real(dp), parameter :: TT_MINUS_TAI = 32.184_dp     !! s (IAU 1991 resolution A4)
    real(dp), parameter :: MJD_J2000 = 51544.5_dp       !! 2000-01-01 12 h
    real(dp), parameter :: LONGEST_ELAPSED_TIME = 1e10_dp
    !! s, about 300 years: more than the covered span
    !> 2000-01-01 12:00:00 GPS, that is 11:59:47 UTC: where the seconds of GPS time of GRACE begin
    type(utc_t), parameter :: GPS_EPOCH = utc_t(51544, 43187.0_dp)
    character(*), parameter :: DIGITS = '0123456789'

contains

    !> Reads a time in ISO 8601, `1989-01-02T00:00:00`, with optional decimals of the second and an
    !> optional Z, or a date alone (its 0 h). Fails on any other form, on a day or time that does
    !> not exist (second 60 exists only in a leap second), and outside 1900-01-01 to 2100-12-31.
    subroutine parse_utc(text, utc, error)
        character(*), intent(in) :: text    !! ISO 8601
        type(utc_t), intent(out) :: utc
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: word, complaint
        real(dp) :: seconds
        integer :: mjd

        word = trim(adjustl(text))
        seconds = 0
        call parse_date(word(:min(10, len(word))), mjd, complaint)
        if (complaint == '' .and. len(word) > 10) then
            if (word(11:11) == 'T') then
                call parse_time_of_day(word(12:), mjd, seconds, complaint)
            else
                complaint = 'the date is not followed by T and a time'
            end if
        end if
        if (complaint /= '') then
            call fail(error, '"'//word//'" is not a time in UTC: '//complaint// &
                      '; write it like 1989-01-02T00:00:00 or 1989-01-02')
            return
        end if
        utc = utc_plus(utc_t(mjd, 0.0_dp), seconds)
    end subroutine parse_utc

    !> Reads YYYY-MM-DD. `complaint` says what is wrong, or is empty.
    subroutine parse_date(text, mjd, complaint)
        character(*), intent(in) :: text
        integer, intent(out) :: mjd     !! Modified Julian day
        character(:), allocatable, intent(out) :: complaint

        integer :: year, month, day

        mjd = 0
        complaint = 'the date is not of the form YYYY-MM-DD'
        if (len(text) /= 10) return
        if (text(5:5)//text(8:8) /= '--') return
        if (verify(text(1:4)//text(6:7)//text(9:10), DIGITS) /= 0) return
        read (text, '(i4, 1x, i2, 1x, i2)') year, month, day
        if (year < FIRST_YEAR .or. year > LAST_YEAR) then
            complaint = 'year '//text(1:4)//' is outside 1900 to 2100'
        else if (month < 1 .or. month > 12) then
            complaint = 'month '//text(6:7)//' is outside 01 to 12'
        else if (day < 1 .or. day > days_in_month(year, month)) then
            complaint = 'day '//text(9:10)//' is outside 01 to '// &
                        integer_text(days_in_month(year, month))//' of '//text(1:7)
        else
            complaint = ''
            mjd = modified_julian_day(year, month, day)
        end if
    end subroutine parse_date

    !> Reads hh:mm:ss[.fff][Z]. `complaint` says what is wrong, or is empty.
    subroutine parse_time_of_day(text, mjd, seconds, complaint)
        character(*), intent(in) :: text
        integer, intent(in) :: mjd              !! The day: it may have a leap second
        real(dp), intent(out) :: seconds        !! Since 0 h
        character(:), allocatable, intent(out) :: complaint

        character(:), allocatable :: clock
        real(dp) :: second
        integer :: hour, minute, whole_second
        logical :: leap_second

        seconds = 0
        clock = text
        if (len(clock) > 0) then
            if (clock(len(clock):) == 'Z') clock = clock(:len(clock) - 1)
        end if
        complaint = 'the time of day is not of the form hh:mm:ss or hh:mm:ss.fff, with or without Z'
        if (len(clock) < 8 .or. len(clock) == 9) return
        if (clock(3:3)//clock(6:6) /= '::') return
        if (verify(clock(1:2)//clock(4:5)//clock(7:8)//clock(10:), DIGITS) /= 0) return
        if (len(clock) > 9) then
            if (clock(9:9) /= '.') return
        end if
        read (clock, '(i2, 1x, i2, 1x, i2)') hour, minute, whole_second
        read (clock(7:), *) second
        leap_second = hour == 23 .and. minute == 59 .and. whole_second == 60
        if (hour > 23) then
            complaint = 'hour '//clock(1:2)//' is outside 00 to 23'
        else if (minute > 59) then
            complaint = 'minute '//clock(4:5)//' is outside 00 to 59'
        else if (whole_second > 59 .and. .not. leap_second) then
            complaint = 'second '//clock(7:8)//' is outside 00 to 59'
        else if (leap_second .and. day_length(mjd) <= nint(SECONDS_PER_DAY)) then
            complaint = 'no leap second was inserted at the end of that day'
        else
            complaint = ''
            seconds = 60*(60*hour + minute) + second
        end if
    end subroutine parse_time_of_day

    !> Refuses a time outside 1900-01-01 to 2100-12-31 and seconds that are not of the day (NaN
    !> too).
    subroutine check_utc_in_range(utc, error)
        type(utc_t), intent(in) :: utc
        type(error_t), allocatable, intent(out) :: error

        if (is_in_range(utc)) return
        if (utc%mjd >= FIRST_MJD .and. utc%mjd <= LAST_MJD) then
            call fail(error, utc_text(utc)//': seconds are those of the day, from 0 to below '// &
                      integer_text(day_length(utc%mjd))//'; utc_plus goes from day to day')
        else
            call fail(error, utc_text(utc)//' is outside the covered times, 1900-01-01T00:00:00 to the end of 2100-12-31 UTC')
        end if
    end subroutine check_utc_in_range

    elemental logical function is_in_range(utc)
        type(utc_t), intent(in) :: utc

        is_in_range = utc%mjd >= FIRST_MJD .and. utc%mjd <= LAST_MJD .and. &
                      utc%seconds >= 0 .and. utc%seconds < day_length(utc%mjd)
    end function is_in_range

    !> What utc_text gives, with blanks behind it.
    pure function utc_field(utc) result(text)
        type(utc_t), intent(in) :: utc
        character(64) :: text

        integer(i8), parameter :: NANO = 1000000000_i8
        integer(i8) :: nanoseconds
        integer :: mjd, whole, minutes, year, month, day
        character(19) :: seconds_resolution
        character(10) :: decimals

        if (.not. is_in_range(utc)) then
            text = 'MJD '//integer_text(utc%mjd)//' + '//number_text(utc%seconds)//' s'
            return
        end if
        mjd = utc%mjd
        nanoseconds = nint(utc%seconds*NANO, i8)
        if (nanoseconds >= day_length(mjd)*NANO) then
            mjd = mjd + 1
            nanoseconds = 0
        end if
        whole = int(nanoseconds/NANO)
        minutes = min(whole/60, 24*60 - 1)      ! a leap second is second 60 of 23:59
        call calendar_date(mjd, year, month, day)
        write (seconds_resolution, '(i4.4, 2("-", i2.2), "T", i2.2, 2(":", i2.2))') &
            year, month, day, minutes/60, mod(minutes, 60), whole - 60*minutes
        write (decimals, '(".", i9.9)') mod(nanoseconds, NANO)
        text = seconds_resolution//decimals(:verify(decimals, '.0', back=.true.))
    end function utc_field

    !> A time in ISO 8601, with as many decimals as the nearest nanosecond needs.
    pure function utc_text(utc) result(text)
        type(utc_t), intent(in) :: utc
        character(len_trim(utc_field(utc))) :: text

        text = utc_field(utc)
    end function utc_text

    !> The time a number of SI seconds later (or, negative, earlier), leap seconds counted. A span
    !> that is not a number or longer than 300 years gives seconds that are not a number, which
    !> `check_utc_in_range` refuses.
    elemental type(utc_t) function utc_plus(utc, elapsed_seconds) result(later)
        type(utc_t), intent(in) :: utc
        real(dp), intent(in) :: elapsed_seconds !! May be negative

        real(dp) :: seconds
        integer :: days

        seconds = utc%seconds + elapsed_seconds
        if (.not. abs(seconds) < LONGEST_ELAPSED_TIME) then
            later = utc_t(utc%mjd, ieee_value(seconds, ieee_quiet_nan))
            return
        end if
        days = floor(seconds/SECONDS_PER_DAY)
        later%mjd = utc%mjd + days
        later%seconds = seconds - days*SECONDS_PER_DAY - &
                        (whole_tai_minus_utc(later%mjd) - whole_tai_minus_utc(utc%mjd))
        do while (later%seconds < 0)
            later%mjd = later%mjd - 1
            later%seconds = later%seconds + day_length(later%mjd)
        end do
        do while (later%seconds >= day_length(later%mjd))
            later%seconds = later%seconds - day_length(later%mjd)
            later%mjd = later%mjd + 1
        end do
    end function utc_plus

    !> SI seconds from one time to another, leap seconds counted.
    elemental real(dp) function seconds_between(start, finish)
        type(utc_t), intent(in) :: start, finish

        real(dp) :: whole

        whole = (finish%mjd - start%mjd)*SECONDS_PER_DAY + &
                (whole_tai_minus_utc(finish%mjd) - whole_tai_minus_utc(start%mjd))
        seconds_between = whole + (finish%seconds - start%seconds)
    end function seconds_between

    !> The time of sample k of a series of equal intervals, in s from its beginning: k times the
    !> interval to the nanosecond, so that the third tenth of a second is 0.3 and no
    !> 0.30000000000000004.
    elemental real(dp) function time_tag(k, interval)
        integer, intent(in) :: k            !! From 0
        real(dp), intent(in) :: interval    !! s

        real(dp), parameter :: PER_SECOND = 1e9_dp

        time_tag = anint(k*interval*PER_SECOND)/PER_SECOND
    end function time_tag

    !> TAI-UTC in s. After the last known leap second the last value holds.
    elemental real(dp) function tai_minus_utc(utc)
        type(utc_t), intent(in) :: utc

        tai_minus_utc = whole_tai_minus_utc(utc%mjd)
    end function tai_minus_utc

    !> TAI-UTC on a day in s; before 1972 the first value, so that differences remain defined.
    elemental integer function whole_tai_minus_utc(mjd)
        integer, intent(in) :: mjd

        whole_tai_minus_utc = LEAP_SECOND_TAI_MINUS_UTC(max(1, count(LEAP_SECOND_MJD <= mjd)))
    end function whole_tai_minus_utc

    !> Length of a UTC day in SI seconds.
    elemental integer function day_length(mjd)
        integer, intent(in) :: mjd

        day_length = nint(SECONDS_PER_DAY) + whole_tai_minus_utc(mjd + 1) - whole_tai_minus_utc(mjd)
    end function day_length

    !> Julian centuries of Terrestrial Time since J2000 (JD 2451545.0 TT).
    elemental real(dp) function julian_centuries_tt(utc) result(centuries)
        type(utc_t), intent(in) :: utc

        real(dp) :: seconds

        seconds = utc%seconds + tai_minus_utc(utc) + TT_MINUS_TAI
        centuries = ((utc%mjd - MJD_J2000) + seconds/SECONDS_PER_DAY)/DAYS_PER_CENTURY
    end function julian_centuries_tt

    !> The year with its fraction: 1989.0 is 1989-01-01 0 h UTC, 1990.0 that of the next year.
    elemental real(dp) function decimal_year(utc)
        type(utc_t), intent(in) :: utc

        integer :: year, month, day, first, next

        call calendar_date(utc%mjd, year, month, day)
        first = modified_julian_day(year, 1, 1)
        next = modified_julian_day(year + 1, 1, 1)
        decimal_year = year + day_of_year(utc)/(next - first)
    end function decimal_year

    !> Days since 1 January 0 h UTC of the year, with fraction: 0.0 at that instant.
    elemental real(dp) function day_of_year(utc)
        type(utc_t), intent(in) :: utc

        integer :: year, month, day

        call calendar_date(utc%mjd, year, month, day)
        day_of_year = (utc%mjd - modified_julian_day(year, 1, 1)) + utc%seconds/SECONDS_PER_DAY
    end function day_of_year

    !> Local mean solar time, UT + longitude/15, in hours, 0 <= t < 24. UTC stands for UT: they
    !> differ by less than 0.9 s.
    elemental real(dp) function local_mean_solar_time(utc, longitude) result(hours)
        type(utc_t), intent(in) :: utc
        real(dp), intent(in) :: longitude   !! rad, positive east

        hours = modulo(utc%seconds/3600 + longitude/HOUR_ANGLE, 24.0_dp)
        if (hours >= 24) hours = 0          ! modulo of a tiny negative number rounds to 24
    end function local_mean_solar_time

    !> Greenwich mean sidereal time in rad, 0 <= angle < 2 pi, by the IAU 1982 expression (S. Aoki
    !> et al., Astron. Astrophys. 105 (1982) 359-361): 24110.54841 s + 8640184.812866 s T + 0.093104
    !> s T^2 - 6.2e-6 s T^3 at 0 h UT1, T in Julian centuries of UT1 since J2000, plus the time of
    !> day. T is taken at the instant itself, which gives the same angle to rounding.
    elemental real(dp) function gmst_1982(utc, ut1_minus_utc) result(angle)
        type(utc_t), intent(in) :: utc
        real(dp), intent(in) :: ut1_minus_utc   !! s

        real(dp) :: day_fraction, t, seconds

        day_fraction = (utc%seconds + ut1_minus_utc)/SECONDS_PER_DAY
        t = ((utc%mjd - MJD_J2000) + day_fraction)/DAYS_PER_CENTURY
        seconds = 24110.54841_dp + t*(8640184.812866_dp + t*(0.093104_dp - t*6.2e-6_dp))
        angle = modulo(TWO_PI*(seconds/SECONDS_PER_DAY + day_fraction), TWO_PI)
    end function gmst_1982

    !> The sidereal angle of CSR-TM-00-01 eq. (2-4): linear from its value at the epoch, in
    !> rad.
    elemental real(dp) function sidereal_angle(initial_angle, elapsed_seconds) result(angle)
        real(dp), intent(in) :: initial_angle       !! At the epoch, rad
        real(dp), intent(in) :: elapsed_seconds     !! Since the epoch, s

        angle = initial_angle + EARTH_ROTATION_RATE*elapsed_seconds
    end function sidereal_angle

    !> Modified Julian day number of a date of the Gregorian calendar (H. F. Fliegel and T. C. Van
    !> Flandern, Comm. ACM 11 (1968) 657; all divisions are of integers).
    elemental integer function modified_julian_day(year, month, day) result(mjd)
        integer, intent(in) :: year, month, day !! Month 1 to 12, day 1 to 31

        integer, parameter :: JULIAN_DAY_NUMBER_OF_MJD_ZERO = 2400001
        integer :: shift    ! -1 in January and February, which count to the year before

        shift = (month - 14)/12
        mjd = day - 32075 + 1461*(year + 4800 + shift)/4 + 367*(month - 2 - 12*shift)/12 &
              - 3*((year + 4900 + shift)/100)/4 - JULIAN_DAY_NUMBER_OF_MJD_ZERO
    end function modified_julian_day

    !> Date of the Gregorian calendar of a modified Julian day (Fliegel and Van Flandern, as above).
    elemental subroutine calendar_date(mjd, year, month, day)
        integer, intent(in) :: mjd                  !! Modified Julian day number
        integer, intent(out) :: year, month, day    !! Month 1 to 12, day 1 to 31

        integer :: rest, century, year_of_century, month_from_march

        rest = mjd + 2400001 + 68569
        century = 4*rest/146097
        rest = rest - (146097*century + 3)/4
        year_of_century = 4000*(rest + 1)/1461001
        rest = rest - 1461*year_of_century/4 + 31
        month_from_march = 80*rest/2447
        day = rest - 2447*month_from_march/80
        month = month_from_march + 2 - 12*(month_from_march/11)
        year = 100*(century - 49) + year_of_century + month_from_march/11
    end subroutine calendar_date

    elemental integer function days_in_month(year, month)
        integer, intent(in) :: year
        integer, intent(in) :: month    !! 1 to 12

        integer :: next_year, next_month

        next_year = year + month/12
        next_month = mod(month, 12) + 1
        days_in_month = modified_julian_day(next_year, next_month, 1) - &
                        modified_julian_day(year, month, 1)
    end function days_in_month

    !> UTC of a GPS time.
    elemental type(utc_t) function utc_of_gps(seconds, fraction) result(utc)
        integer(i8), intent(in) :: seconds      !! Whole seconds past 2000-01-01 12:00:00 GPS
        real(dp), intent(in) :: fraction        !! The rest, s

        integer(i8), parameter :: DAY = 86400      ! s
        integer(i8) :: days

        ! Whole days first, so that no digit of the fraction is lost.
        days = seconds/DAY
        utc = utc_plus(GPS_EPOCH, real(days*DAY, dp))
        utc = utc_plus(utc, real(seconds - days*DAY, dp) + fraction)
    end function utc_of_gps
end module gracecg_environment_time
