!> UTC and its leap seconds, sidereal time, and the ellipsoid.
module test_time
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use vocabulary
    use gracecg_base_constants, only: SECONDS_PER_DAY, EARTH_ROTATION_RATE, WGS84_SEMI_MAJOR_AXIS, WGS84_FLATTENING
    use gracecg_environment_time
    use gracecg_environment_earth_shape, only: earth_fixed_to_geodetic
    implicit none
    private
    public :: collect_time

contains

    subroutine collect_time(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('well-formed-times', test_well_formed), &
                    new_unittest('malformed-times-are-refused', test_malformed), &
                    new_unittest('every-day-1900-to-2100', test_calendar), &
                    new_unittest('text-to-the-nanosecond', test_text), &
                    new_unittest('range-check', test_range), &
                    new_unittest('elapsed-time-through-leap-seconds', test_leap_seconds), &
                    new_unittest('plus-and-between-are-inverse', test_inverse), &
                    new_unittest('atomic-and-terrestrial-time', test_tai), &
                    new_unittest('year-and-day-of-year', test_year), &
                    new_unittest('sidereal-time', test_sidereal_time), &
                    new_unittest('local-solar-time', test_local_time), &
                    new_unittest('ellipsoid-published-and-at-the-poles', test_ellipsoid_published), &
                    new_unittest('ellipsoid-there-and-back', test_ellipsoid_round_trip)]
    end subroutine collect_time

    !> A time that must be readable.
    type(utc_t) function utc_of(text)
        character(*), intent(in) :: text
        type(error_t), allocatable :: failure

        call parse_utc(text, utc_of, failure)
        if (allocated(failure)) utc_of = utc_t(0, NAN)
    end function utc_of

    subroutine check_time(error, text, mjd, seconds)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: text
        integer, intent(in) :: mjd
        real(dp), intent(in) :: seconds
        type(utc_t) :: utc

        utc = utc_of(text)
        call check(error, utc%mjd, mjd, text)
        call check(error, utc%seconds, seconds, text)
    end subroutine check_time

    subroutine test_well_formed(error)
        type(error_type), allocatable, intent(out) :: error

        call check_time(error, '1989-01-02', 47528, 0.0_dp)
        call check_time(error, '1989-01-02T00:00:00', 47528, 0.0_dp)
        call check_time(error, '  2000-01-01T12:00:00Z ', 51544, 43200.0_dp)
        call check_time(error, '2000-02-29T23:59:59.25', 51603, 86399.25_dp)
        call check_time(error, '1989-12-31T23:59:60.5Z', 47891, 86400.5_dp)
        ! nearer to the next day than a number can tell
        call check_time(error, '1989-01-01T23:59:59.9999999999999999', 47528, 0.0_dp)
    end subroutine test_well_formed

    !> Each with a word that its message must hold.
    subroutine test_malformed(error)
        type(error_type), allocatable, intent(out) :: error
        character(30), parameter :: BAD(2, 28) = reshape([character(30) :: &
            '', 'YYYY-MM-DD', &
            '1989', 'YYYY-MM-DD', &
            '1989-1-2', 'YYYY-MM-DD', &
            '89-01-02', 'YYYY-MM-DD', &
            '1989/01/02', 'YYYY-MM-DD', &
            '1989-0a-02', 'YYYY-MM-DD', &
            '+989-01-02', 'YYYY-MM-DD', &
            '1899-12-31', 'year 1899', &
            '2101-01-01', 'year 2101', &
            '1989-00-02', 'month 00', &
            '1989-13-02', 'month 13', &
            '1989-01-00', 'day 00', &
            '1989-04-31', '01 to 30 of 1989-04', &
            '1989-02-29', '01 to 28 of 1989-02', &
            '2100-02-29', '01 to 28 of 2100-02', &
            '1989-01-02 00:00:00', 'followed by T', &
            '1989-01-02T', 'hh:mm:ss', &
            '1989-01-02T00:00', 'hh:mm:ss', &
            '1989-01-02T00:00:0', 'hh:mm:ss', &
            '1989-01-02T00:00:00.', 'hh:mm:ss', &
            '1989-01-02T00:00:00,5', 'hh:mm:ss', &
            '1989-01-02T00:00:00+01:00', 'hh:mm:ss', &
            '1989-01-02T24:00:00', 'hour 24', &
            '1989-01-02T00:60:00', 'minute 60', &
            '1989-01-02T00:00:61', 'second 61', &
            '1989-12-31T22:59:60', 'second 60', &
            '1989-12-31T23:59:61', 'second 61', &
            '1988-12-31T23:59:60', 'no leap second'], [2, 28])
        type(error_t), allocatable :: failure
        type(utc_t) :: utc
        integer :: i

        do i = 1, size(BAD, 2)
            call parse_utc(trim(BAD(1, i)), utc, failure)
            call check_fails(error, failure, BAD(2, i))
        end do
    end subroutine test_malformed

    !> The days follow each other, none missing: 201 years with 49 leap days (1900 and 2100 have none).
    subroutine test_calendar(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_t) :: first, last, day
        character(10) :: previous, text
        integer :: mjd, year, month, date

        first = utc_of('1900-01-01')
        last = utc_of('2100-12-31')
        call check(error, last%mjd - first%mjd + 1, 201*365 + 49)
        previous = '1899-12-31'
        do mjd = first%mjd, last%mjd
            text = utc_text(utc_t(mjd, 0.0_dp))
            day = utc_of(text)
            call calendar_date(mjd, year, month, date)
            if (day%mjd /= mjd .or. .not. text > previous .or. &
                modified_julian_day(year, month, date) /= mjd) then
                call test_failed(error, 'calendar goes wrong at '//text)
                return
            end if
            previous = text
        end do
    end subroutine test_calendar

    subroutine test_text(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, utc_text(utc_t(47528, 0.0_dp)), '1989-01-02T00:00:00')
        call check(error, utc_text(utc_t(47528, 3723.1_dp)), '1989-01-02T01:02:03.1')
        call check(error, utc_text(utc_t(47528, 86399.123456789_dp)), &
                   '1989-01-02T23:59:59.123456789')
        call check(error, utc_text(utc_t(47528, nearest(86400.0_dp, -1.0_dp))), &
                   '1989-01-03T00:00:00')
        call check(error, utc_text(utc_t(47891, nearest(86400.0_dp, -1.0_dp))), &
                   '1989-12-31T23:59:60')
        call check(error, utc_text(utc_t(47891, 86400.25_dp)), '1989-12-31T23:59:60.25')
    end subroutine test_text

    subroutine test_range(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure
        type(utc_t) :: bad(6), epoch
        integer :: i

        epoch = utc_of('1989-01-02')
        call check_utc_in_range(epoch, failure)
        if (failed(error, failure)) return
        bad = [utc_plus(utc_of('1900-01-01'), -1.0_dp), &
               utc_plus(utc_of('2100-12-31'), 86400.0_dp), &
               utc_t(epoch%mjd, -1.0_dp), utc_t(epoch%mjd, 86400.0_dp), &
               utc_plus(epoch, NAN), &
               utc_plus(epoch, huge(0.0_dp))]
        do i = 1, size(bad)
            call check_utc_in_range(bad(i), failure)
            call check(error, allocated(failure))
            if (i == 3 .or. i == 4) call check_fails(error, failure, 'seconds are those of the day, from 0 to below 86400')
        end do
    end subroutine test_range

    !> The second before, in and after the leap second of 1990-12-31, both ways.
    subroutine test_leap_seconds(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_t) :: eve, new_year

        eve = utc_of('1990-12-31T23:59:59')
        new_year = utc_of('1991-01-01')
        call check(error, seconds_between(eve, new_year), 2.0_dp)
        call check(error, utc_text(utc_plus(eve, 1.5_dp)), '1990-12-31T23:59:60.5')
        call check(error, utc_text(utc_plus(eve, 2.0_dp)), '1991-01-01T00:00:00')
        call check(error, utc_text(utc_plus(new_year, -0.75_dp)), '1990-12-31T23:59:60.25')
        call check(error, utc_text(utc_plus(new_year, -2.0_dp)), '1990-12-31T23:59:59')
        ! 1989-01-02 to 2000-01-01: 4016 days and the eight leap seconds of 1990 to 1999
        call check(error, seconds_between(utc_of('1989-01-02'), utc_of('2000-01-01')), &
                   4016*SECONDS_PER_DAY + 8)
        call check(error, utc_text(utc_plus(utc_of('1989-01-02'), 4016*SECONDS_PER_DAY + 8)), &
                   '2000-01-01T00:00:00')
    end subroutine test_leap_seconds

    !> Spans of both signs from a tenth of a second to years, from seconds about leap seconds.
    subroutine test_inverse(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_t) :: start, finish
        type(error_t), allocatable :: failure
        real(dp) :: span
        integer :: i, sign

        start = utc_of('1989-12-31T23:59:58.5')
        do i = 0, 3000
            do sign = -1, 1, 2
                span = sign*0.1_dp*1.007_dp**i
                finish = utc_plus(start, span)
                if (abs(span) > 5e8_dp) cycle           ! leaves the covered years
                call check_utc_in_range(finish, failure)
                call check_passes(error, failure)
                call check(error, seconds_between(start, finish), span, &
                           thr=1e-10_dp + 4*spacing(span))
            end do
        end do
    end subroutine test_inverse

    !> IERS Bulletin C: 19 s when GPS time began, 24 s at the report's epoch, 32 s and 37 s after
    !> the leap seconds of 1998 and 2016.
    !> TT-UTC = 56.184 s at 1989-01-02: JD 2447528.500650278 TT.
    subroutine test_tai(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, all(nint(tai_minus_utc([ &
            utc_of('1972-01-01'), utc_of('1980-01-06'), utc_of('1989-01-02'), &
            utc_of('1998-12-31T23:59:60'), utc_of('1999-01-01'), utc_of('2017-01-01'), &
            utc_of('2099-01-01')])) == [10, 19, 24, 31, 32, 37, 37]))
        call check(error, 2451545 + 36525*julian_centuries_tt(utc_of('1989-01-02')), &
                   2447528.500650278_dp, thr=1e-9_dp)
        ! J2000 itself: 12 h TT is 11:58:55.816 UTC
        call check(error, julian_centuries_tt(utc_of('2000-01-01T11:58:55.816')), 0.0_dp, &
                   thr=1e-20_dp)
    end subroutine test_tai

    subroutine test_year(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, day_of_year(utc_of('1989-01-01')), 0.0_dp)
        call check(error, day_of_year(utc_of('1989-01-02T18:00:00')), 1.75_dp)
        call check(error, day_of_year(utc_of('1988-12-31')), 365.0_dp)
        call check(error, decimal_year(utc_of('1989-01-01')), 1989.0_dp)
        call check(error, decimal_year(utc_of('1988-07-02')), 1988.5_dp)         ! 183 of 366 days
        call check(error, decimal_year(utc_of('1989-07-02T12:00:00')), 1989.5_dp)
    end subroutine test_year

    !> Greenwich mean sidereal time. CSR-TM-00-01 section 5.2 has 101.60748558 deg at 1989-01-02;
    !> with UT1-UTC of IERS Bulletin A the expression gives 101.60748585. The other number is the
    !> check value of iauGmst82 in the SOFA library's t_sofa_c for MJD 53736.0 UT1.
    !> Over midnight, sidereal time gains 1.00273790935 revolutions a day (IAU 1982). The linear
    !> angle turns by the Earth's own rate, without the precession of the equinox: slower by 9e-12
    !> rad/s.
    subroutine test_sidereal_time(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_t) :: epoch, start, finish
        real(dp) :: turned, expected

        epoch = utc_of('1989-01-02')
        call check(error, gmst_1982(epoch, -0.1174047_dp)/DEGREE, 101.60748585_dp, thr=5e-9_dp)
        call check(error, gmst_1982(epoch, 0.0_dp)/DEGREE, 101.60797638_dp, thr=5e-9_dp)
        call check(error, gmst_1982(epoch, -0.11747_dp)/DEGREE, 101.60748558_dp, thr=1e-8_dp)
        call check(error, gmst_1982(utc_t(53736, 0.0_dp), 0.0_dp), 1.754174981860675096_dp, &
                   thr=1e-12_dp)
        start = utc_of('1989-01-02T23:00:00')
        finish = utc_plus(start, 7200.0_dp)
        turned = modulo(gmst_1982(finish, 0.0_dp) - gmst_1982(start, 0.0_dp), TWO_PI)
        expected = TWO_PI*1.00273790935_dp*7200/SECONDS_PER_DAY
        call check(error, turned, expected, thr=1e-11_dp)
        call check(error, sidereal_angle(1.5_dp, 7200.0_dp) - 1.5_dp, EARTH_ROTATION_RATE*7200, &
                   thr=1e-15_dp)
        call check(error, sidereal_angle(0.0_dp, 7200.0_dp), turned, thr=7200*9e-12_dp)
    end subroutine test_sidereal_time

    subroutine test_local_time(error)
        type(error_type), allocatable, intent(out) :: error
        type(utc_t) :: epoch

        epoch = utc_of('1989-01-02')
        call check(error, local_mean_solar_time(epoch, -101.6_dp*DEGREE), 17.226666666666667_dp, &
                   thr=1e-12_dp)
        call check(error, local_mean_solar_time(utc_of('1989-01-02T20:30:00'), 90*DEGREE), 2.5_dp, &
                   thr=1e-12_dp)
        call check(error, local_mean_solar_time(epoch, -1e-20_dp) < 24)
    end subroutine test_local_time

    !> Check values of iauGc2gd and iauGd2gc in the SOFA library's t_sofa_c, WGS-84.
    subroutine test_ellipsoid_published(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: latitude, longitude, height, polar_radius, sign

        call earth_fixed_to_geodetic([2e6_dp, 3e6_dp, 5.244e6_dp], latitude, longitude, height)
        call check(error, longitude, 0.9827937232473290680_dp, thr=1e-14_dp)
        call check(error, latitude, 0.97160184819075459_dp, thr=1e-14_dp)
        call check(error, height, 331.4172461426059892_dp, thr=1e-8_dp)
        call check(error, all(abs(geodetic_to_earth_fixed(-0.5_dp, 3.1_dp, 2500.0_dp) - &
                                     [-5599000.5577049947_dp, 233011.67223479203_dp, &
                                      -3040909.4706983363_dp]) < 1e-7_dp))
        polar_radius = WGS84_SEMI_MAJOR_AXIS*(1 - WGS84_FLATTENING)
        sign = 1
        do while (sign > -2)
            call earth_fixed_to_geodetic([0.0_dp, 0.0_dp, sign*(polar_radius + 466e3_dp)], &
                                         latitude, longitude, height)
            call check(error, latitude, sign*PI/2, thr=1e-15_dp)
            call check(error, height, 466e3_dp, thr=2e-9_dp)
            call check(error, .not. ieee_is_nan(longitude))
            sign = sign - 2
        end do
    end subroutine test_ellipsoid_published

    !> From 5 km below to 50,000 km above the ellipsoid, to rounding.
    subroutine test_ellipsoid_round_trip(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: HEIGHTS(*) = [-5e3_dp, 0.0_dp, 466e3_dp, 2e6_dp, 1e7_dp, 5e7_dp]
        real(dp) :: position(3), latitude, longitude, height, expected(2)
        integer :: i, j, k

        do k = 1, size(HEIGHTS)
            do j = -90, 90, 5
                do i = -17, 18
                    expected = [j, 10*i]*DEGREE
                    position = geodetic_to_earth_fixed(expected(1), expected(2), HEIGHTS(k))
                    call earth_fixed_to_geodetic(position, latitude, longitude, height)
                    if (abs(j) == 90) expected(2) = longitude
                    call check(error, height, HEIGHTS(k), thr=4*spacing(norm2(position)))
                    call check(error, all(abs([latitude, longitude] - expected) < 2e-15_dp))
                end do
            end do
        end do
    end subroutine test_ellipsoid_round_trip

    !> Earth-fixed coordinates of a geodetic place.
    pure function geodetic_to_earth_fixed(latitude, longitude, height) result(position)
        real(dp), intent(in) :: latitude, longitude, height
        real(dp) :: position(3)

        real(dp), parameter :: E2 = WGS84_FLATTENING*(2 - WGS84_FLATTENING)
        real(dp) :: radius

        radius = WGS84_SEMI_MAJOR_AXIS/sqrt(1 - E2*sin(latitude)**2)
        position(:2) = (radius + height)*cos(latitude)*[cos(longitude), sin(longitude)]
        position(3) = (radius*(1 - E2) + height)*sin(latitude)
    end function geodetic_to_earth_fixed
end module test_time
