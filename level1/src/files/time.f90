!> The time of Level-1 data: on-board computer -> receiver -> GPS -> UTC.
!>
!> Times are whole seconds past 2000-01-01 12:00:00 and a fraction of a second, 0 <= fraction < 1, in the time
!> frame that is said. GPS time begins there at 11:59:47 UTC. A tag of time frame R of a 1A file is one of the
!> on-board computer:
!>
!>     receiver time = t + (rcvtime - obctime)(t)              TIM1B, between its records linear
!>     GPS time      = t_r + eps_time + eps_drift (t_r - t_k)  CLK1B, its last record at or before t_r
module gracecg_level1_time
    use gracecg_level1_basics
    use gracecg_environment_time, only: GPS_EPOCH, calendar_date
    use gracecg_level1_records, only: level1_records_t
    implicit none
    private
    public :: level1_clock_t, new_level1_clock, gps_date_text, gps_day, to_gps_time

    integer(i8), parameter :: DAY = 86400, NOON = 43200

    type :: level1_clock_t
        !! What takes tags to GPS time
        integer(i8), allocatable :: obc_seconds(:)      !! Times of TIM1B in time of the on-board computer; may be none
        real(dp), allocatable :: receiver_offset(:)     !! Receiver time less that, s
        integer(i8), allocatable :: receiver_seconds(:) !! Times of CLK1B in receiver time; at least one
        real(dp), allocatable :: eps_time(:)            !! GPS time less receiver time there, s
        real(dp), allocatable :: eps_drift(:)           !! Its rate, s/s
        real(dp) :: longest_reach = 0                   !! Beyond the last record before: more is told as extrapolated, s
    contains
        procedure :: gps_time                           !! Of one tag
        procedure :: receiver_time                      !! Of one tag
        procedure :: obc_time                           !! Of one GPS time: the inverse of `gps_time`
        procedure :: is_extrapolated                    !! No record of CLK1B near a tag
    end type level1_clock_t

contains

    !> Makes the clock of CLK1B and, where there is one, TIM1B. Fails when CLK1B has no record.
    subroutine new_level1_clock(clock, error, clk1b, tim1b)
        type(level1_clock_t), intent(out) :: clock
        type(error_t), allocatable, intent(out) :: error
        type(level1_records_t), intent(in) :: clk1b             !! All fields
        type(level1_records_t), intent(in), optional :: tim1b   !! All fields; without it, or its records, receiver time is
                                                                !! taken as that of the on-board computer

        real(dp), parameter :: USUAL_STEPS = 3      !! Of records: what is farther is extrapolated
        integer :: n

        n = clk1b%count
        if (n == 0) then
            call fail(error, clk1b%path//': has no record; CLK1B is needed to go from receiver to GPS time')
            return
        end if
        clock%receiver_seconds = clk1b%seconds
        clock%eps_time = clk1b%values(:, clk1b%field_of('eps_time'))
        clock%eps_drift = clk1b%values(:, clk1b%field_of('eps_drift'))
        if (any(.not. (abs(clock%eps_time) < 1 .and. abs(clock%eps_drift) < 1e-3_dp))) then
            call fail(error, clk1b%path//': eps_time or eps_drift is missing or beyond 1 s and 1e-3 s/s in record '// &
                      integer_text(findloc(abs(clock%eps_time) < 1 .and. abs(clock%eps_drift) < 1e-3_dp, .false., 1)))
            return
        end if
        clock%longest_reach = SECONDS_PER_DAY
        if (n > 1) clock%longest_reach = USUAL_STEPS*real(clk1b%seconds(n) - clk1b%seconds(1), dp)/(n - 1)
        allocate (clock%obc_seconds(0), clock%receiver_offset(0))
        if (.not. present(tim1b)) return
        if (tim1b%count == 0) return
        clock%obc_seconds = tim1b%seconds
        clock%receiver_offset = (tim1b%values(:, tim1b%field_of('rcvtime_intg')) - real(tim1b%seconds, dp)) + &
            tim1b%values(:, tim1b%field_of('time_frac'))*tim1b%layout%fraction_unit
        if (any(.not. abs(clock%receiver_offset) < 1)) &
            call fail(error, tim1b%path//': receiver time and time of the on-board computer differ by more than 1 s in '// &
                      'record '//integer_text(findloc(abs(clock%receiver_offset) < 1, .false., 1)))
    end subroutine new_level1_clock

    !> Makes 0 <= fraction < 1.
    elemental subroutine carry_fraction(seconds, fraction)
        integer(i8), intent(inout) :: seconds   !! s
        real(dp), intent(inout) :: fraction     !! s

        integer(i8) :: carry

        carry = floor(fraction, i8)
        fraction = fraction - real(carry, dp)
        seconds = seconds + carry
        if (fraction >= 1) then     ! a tiny negative fraction rounds up
            fraction = 0
            seconds = seconds + 1
        end if
    end subroutine carry_fraction

    !> Receiver time of a tag in time of the on-board computer; beyond TIM1B its first or last offset holds.
    pure subroutine receiver_time(self, seconds, fraction)
        class(level1_clock_t), intent(in) :: self
        integer(i8), intent(inout) :: seconds       !! Whole seconds of the tag
        real(dp), intent(inout) :: fraction         !! The rest, s

        real(dp) :: weight
        integer :: k, n

        n = size(self%obc_seconds)
        if (n == 0) return
        k = last_not_after(self%obc_seconds, seconds)
        if (k == 0 .or. k == n) then
            fraction = fraction + self%receiver_offset(max(1, min(k, n)))
        else
            weight = (real(seconds - self%obc_seconds(k), dp) + fraction)/ &
                real(self%obc_seconds(k + 1) - self%obc_seconds(k), dp)
            fraction = fraction + (1 - weight)*self%receiver_offset(k) + weight*self%receiver_offset(k + 1)
        end if
        call carry_fraction(seconds, fraction)
    end subroutine receiver_time

    !> GPS time of a tag in time of the on-board computer.
    pure subroutine gps_time(self, seconds, fraction)
        class(level1_clock_t), intent(in) :: self
        integer(i8), intent(inout) :: seconds       !! Whole seconds of the tag
        real(dp), intent(inout) :: fraction         !! The rest, s

        integer :: k

        call self%receiver_time(seconds, fraction)
        k = max(1, last_not_after(self%receiver_seconds, seconds))
        fraction = fraction + self%eps_time(k) + &
            self%eps_drift(k)*(real(seconds - self%receiver_seconds(k), dp) + fraction)
        call carry_fraction(seconds, fraction)
    end subroutine gps_time

    !> The time of the on-board computer at a GPS time: `gps_time` of it is that time, to rounding, but at the
    !> instants where the clock corrections step.
    pure subroutine obc_time(self, seconds, fraction)
        class(level1_clock_t), intent(in) :: self
        integer(i8), intent(inout) :: seconds       !! Whole seconds of the GPS time
        real(dp), intent(inout) :: fraction         !! The rest, s

        integer, parameter :: ROUNDS = 4
        integer(i8) :: mapped, wanted
        real(dp) :: mapped_fraction, wanted_fraction
        integer :: i

        wanted = seconds
        wanted_fraction = fraction
        do i = 1, ROUNDS
            mapped = seconds
            mapped_fraction = fraction
            call self%gps_time(mapped, mapped_fraction)
            fraction = fraction + (real(wanted - mapped, dp) + (wanted_fraction - mapped_fraction))
            call carry_fraction(seconds, fraction)
        end do
    end subroutine obc_time

    !> Whether CLK1B has no record close before a tag.
    elemental logical function is_extrapolated(self, seconds)
        class(level1_clock_t), intent(in) :: self
        integer(i8), intent(in) :: seconds          !! Whole seconds of the tag

        integer :: k

        k = last_not_after(self%receiver_seconds, seconds)
        is_extrapolated = k == 0
        if (k > 0) is_extrapolated = real(seconds - self%receiver_seconds(k), dp) > self%longest_reach
    end function is_extrapolated

    !> Takes the tags of records to GPS time; nothing happens when they are in it. `extrapolated` counts those
    !> that CLK1B does not cover.
    subroutine to_gps_time(records, clock, extrapolated)
        type(level1_records_t), intent(inout) :: records
        type(level1_clock_t), intent(in) :: clock
        integer, intent(out) :: extrapolated    !! Records without one of CLK1B near

        integer :: i

        extrapolated = 0
        if (records%time_ref == 'G' .or. (records%time_ref == '' .and. records%layout%product(5:5) == 'B')) return
        extrapolated = count(clock%is_extrapolated(records%seconds))
        do i = 1, records%count
            call clock%gps_time(records%seconds(i), records%fraction(i))
        end do
        records%time_ref = 'G'
    end subroutine to_gps_time

    !> The date of a GPS time in the GPS calendar, to the microsecond: 2023-06-01T00:00:00.007739.
    function gps_date_text(seconds, fraction) result(text)
        integer(i8), intent(in) :: seconds      !! Whole seconds past 2000-01-01 12:00:00 GPS
        real(dp), intent(in) :: fraction        !! The rest, s
        character(26) :: text

        integer :: year, month, date
        integer(i8) :: rest, microseconds, whole

        microseconds = nint(fraction*1e6_dp, i8)
        whole = seconds + NOON + microseconds/1000000
        microseconds = modulo(microseconds, 1000000_i8)
        rest = modulo(whole, DAY)
        call calendar_date(GPS_EPOCH%mjd + int((whole - rest)/DAY), year, month, date)
        write (text, '(i4.4, 2("-", i2.2), "T", i2.2, 2(":", i2.2), ".", i6.6)') year, month, date, rest/3600, &
            modulo(rest/60, 60_i8), modulo(rest, 60_i8), microseconds
    end function gps_date_text

    !> The day of a GPS time: 2023-06-01.
    function gps_day(seconds) result(day)
        integer(i8), intent(in) :: seconds      !! Past 2000-01-01 12:00:00 GPS
        character(10) :: day

        day = gps_date_text(seconds, 0.0_dp)
    end function gps_day
end module gracecg_level1_time
