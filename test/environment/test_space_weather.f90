!> Solar flux and geomagnetic activity by time, and the reader of such tables.
module test_space_weather
    use vocabulary
    use gracecg_environment_time, only: utc_t, parse_utc, utc_plus
    use gracecg_environment_space_weather
    implicit none
    private
    public :: collect_space_weather

    character(*), parameter :: FIXTURES = 'test/fixtures/space_weather'

contains

    subroutine collect_space_weather(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('epoch-of-the-report-and-kp-intervals', test_epoch), &
                    new_unittest('81-day-mean-is-the-mean', test_mean), &
                    new_unittest('outside-the-table', test_outside), &
                    new_unittest('file-of-the-user', test_file), &
                    new_unittest('file-of-celestrak', test_celestrak), &
                    new_unittest('file-of-gfz', test_gfz), &
                    new_unittest('corrupted-files', test_corrupted)]
    end subroutine collect_space_weather

    subroutine check_indices(error, table, time, f107, f107_mean, kp)
        type(error_type), allocatable, intent(inout) :: error
        type(space_weather_t), intent(in) :: table
        character(*), intent(in) :: time
        real(dp), intent(in) :: f107, f107_mean, kp
        type(utc_t) :: utc
        type(error_t), allocatable :: failure
        real(dp) :: found(3)

        call parse_utc(time, utc, failure)
        if (.not. allocated(failure)) then
            call table%indices_at(utc, found(1), found(2), found(3), failure)
        end if
        call check_passes(error, failure)
        call check(error, all(abs(found - [f107, f107_mean, kp]) < 1e-12_dp), time)
    end subroutine check_indices

    !> Ottawa flux of 1989-01-01 and Kp of its last three hours, 3-.
    !> 2000-01-04 closes with Kp 4-, the next day's are 40 33 33 33 23 30 37 40 tenths.
    subroutine test_epoch(error)
        type(error_type), allocatable, intent(out) :: error
        type(space_weather_t) :: table

        call check_indices(error, embedded_space_weather(), '1989-01-02T00:00:00', &
                           185.7_dp, 210.6_dp, 2.7_dp)
        table = embedded_space_weather()
        call check_indices(error, table, '2000-01-05T02:59:59', 134.7_dp, 165.0_dp, 3.7_dp)
        call check_indices(error, table, '2000-01-05T03:00:00', 134.7_dp, 165.0_dp, 4.0_dp)
        call check_indices(error, table, '2000-01-05T17:59:59.9', 134.7_dp, 165.0_dp, 2.3_dp)
        call check_indices(error, table, '2000-01-05T23:59:59.9', 134.7_dp, 165.0_dp, 3.7_dp)
        call check_indices(error, table, '2000-01-06T00:00:00', 136.5_dp, 164.8_dp, 4.0_dp)
    end subroutine test_epoch

    !> The mean of a day against the daily values of the 40 days before to the 40 after it.
    subroutine test_mean(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: DAYS = 366
        type(space_weather_t) :: table
        type(error_t), allocatable :: failure
        type(utc_t) :: first
        real(dp) :: flux(DAYS), means(DAYS), kp, unused
        integer :: i

        table = embedded_space_weather()
        call parse_utc('2000-01-01', first, failure)
        do i = 2, DAYS
            call table%indices_at(utc_plus(first, (i - 1)*86400.0_dp), flux(i - 1), means(i), kp, &
                                  failure)
            call check_passes(error, failure)
        end do
        do i = 41, DAYS - 41
            call check(error, sum(flux(i - 40:i + 40))/81, means(i), thr=0.0501_dp)
        end do
        ! the day after the last row has its flux in the table, but no mean
        call table%indices_at(utc_plus(first, DAYS*86400.0_dp), flux(DAYS), unused, kp, failure)
        call check(error, allocated(failure))
    end subroutine test_mean

    !> The message names the spans of the table and the keys that can stand in for it. The first day
    !> has no day before.
    subroutine test_outside(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: TIMES(*) = ['1988-12-01', '1989-03-01', '1999-12-31', &
                                               '2000-01-01', '2001-01-01', '1975-06-01']
        type(space_weather_t) :: table
        type(error_t), allocatable :: failure
        type(utc_t) :: utc
        real(dp) :: found(3)
        integer :: i

        table = embedded_space_weather()
        do i = 1, size(TIMES)
            call parse_utc(TIMES(i), utc, failure)
            call table%indices_at(utc, found(1), found(2), found(3), failure)
            call check_fails(error, failure, TIMES(i)//' ... 1988-12-01 to 1989-02-28 and 2000-01-01 to 2000-12-31 ... '// &
                             "f107, f107_mean and kp ... space_weather = 'given'")
        end do
        call table%indices_at(utc_t(47528, -1.0_dp), found(1), found(2), found(3), failure)
        call check(error, allocated(failure))
    end subroutine test_outside

    !> Its lines may end as on Windows, and the last one without.
    subroutine test_file(error)
        type(error_type), allocatable, intent(out) :: error
        type(space_weather_t) :: table
        type(error_t), allocatable :: failure
        type(utc_t) :: utc
        real(dp) :: found(3)

        call read_space_weather(FIXTURES//'.csv', table, failure)
        call check_passes(error, failure)
        call check_indices(error, table, '2001-03-31T06:00:00', 256.9_dp, 186.7_dp, 9.0_dp)
        call parse_utc('2001-04-02', utc, failure)
        call table%indices_at(utc, found(1), found(2), found(3), failure)
        call check(error, allocated(failure), 'a day after a gap needs the day before')
        call read_space_weather(FIXTURES//'_crlf.csv', table, failure)
        call check_passes(error, failure)
        call check_indices(error, table, '2001-03-31T01:00:00', 256.9_dp, 186.7_dp, 4.0_dp)
    end subroutine test_file

    !> Rows of SW-All.csv; the last day has no mean yet, and the month's prediction no Kp.
    subroutine test_celestrak(error)
        type(error_type), allocatable, intent(out) :: error
        type(space_weather_t) :: table
        type(error_t), allocatable :: failure
        type(utc_t) :: utc
        real(dp) :: found(3)

        call read_space_weather(FIXTURES//'_celestrak.csv', table, failure)
        call check_passes(error, failure)
        call check_indices(error, table, '2026-03-02T05:00:00', 147.0_dp, 140.3_dp, 1.3_dp)
        call parse_utc('2026-03-04', utc, failure)
        call table%indices_at(utc, found(1), found(2), found(3), failure)
        call check_fails(error, failure, 'no 81-day mean of F10.7 for 2026-03-04 ... 2026-02-28 to 2026-03-04')
    end subroutine test_celestrak

    !> The figures of the embedded table in the layout of GFZ: the same indices, and means that agree with the
    !> published ones to their rounding, with a day's flux missing too.
    subroutine test_gfz(error)
        type(error_type), allocatable, intent(out) :: error
        type(space_weather_t) :: table, gap, embedded
        type(error_t), allocatable :: failure
        type(utc_t) :: utc
        real(dp) :: a(3), b(3), c(3)
        integer :: i

        embedded = embedded_space_weather()
        call read_space_weather(FIXTURES//'_gfz.txt', table, failure)
        if (.not. allocated(failure)) call read_space_weather(FIXTURES//'_gfz_gap.txt', gap, failure)
        if (failed(error, failure)) return
        call parse_utc('1989-01-10T04:00:00', utc, failure)
        do i = 0, 9
            call embedded%indices_at(utc_plus(utc, 86400.0_dp*i), a(1), a(2), a(3), failure)
            call table%indices_at(utc_plus(utc, 86400.0_dp*i), b(1), b(2), b(3), failure)
            call check_passes(error, failure)
            call check(error, all(abs(a - b) < [1e-12_dp, 0.0501_dp, 1e-12_dp]))
            call gap%indices_at(utc_plus(utc, 86400.0_dp*i), c(1), c(2), c(3), failure)
            call check(error, .not. allocated(failure) .and. abs(c(2) - b(2)) < 1 .and. abs(c(2) - b(2)) > 1e-3_dp)
        end do
        call table%indices_at(utc_plus(utc, 864000.0_dp), b(1), b(2), b(3), failure)
        call check_fails(error, failure, 'no 81-day mean ... 1988-12-01 to 1989-02-28')
    end subroutine test_gfz

    !> Each with a word that its message must hold.
    subroutine test_corrupted(error)
        type(error_type), allocatable, intent(out) :: error
        character(24), parameter :: BAD(2, 13) = reshape([character(24) :: &
            '_missing.txt', 'no such file', &
            '_empty.txt', 'holds no data', &
            '_date.csv', '01 to 28 of 2001-02', &
            '_repeated.csv', 'the days must rise', &
            '_number.csv', '"NaN" is not a finite', &
            '_flux.csv', 'csv:3: F10.7: 0.0 is', &
            '_mean.csv', 'csv:2: 81-day mean', &
            '_celestrak_header.csv', 'no column KP5', &
            '_celestrak_columns.csv', 'csv:3: has 30 columns', &
            '_celestrak_kp.csv', 'csv:3: Kp is given', &
            '_celestrak_order.csv', 'csv:3: the days must', &
            '_gfz_kp.txt', 'txt:5: Kp is given', &
            '_gfz_columns.txt', 'txt:6: has 27 columns'], [2, 13])
        type(space_weather_t) :: table
        type(error_t), allocatable :: failure
        integer :: i

        do i = 1, size(BAD, 2)
            call read_space_weather(FIXTURES//trim(BAD(1, i)), table, failure)
            call check_fails(error, failure, joined(BAD(:, i)))
        end do
    end subroutine test_corrupted
end module test_space_weather
