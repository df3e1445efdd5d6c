!> The currents of the rods at any time, between the samples of the magnetometer's files: smooth, or held from tag to tag.
!>
!> Smooth currents have breaks, where a manoeuvre begins and ends: no polynomial goes across them. Where those of both
!> sides meet between the two samples, the current has a kink there; where they do not, it jumps, nobody knows when.
module gracecg_level1_drive
    use gracecg_base_kinds, only: dp
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_statistics, only: median_of
    use gracecg_level1_calibration, only: level1_calibration_t, keep_samples
    use gracecg_level1_firings, only: SAMPLE
    use gracecg_level1_series, only: interpolate, hold
    implicit none
    private
    public :: level1_drive_t, new_drive, mark_breaks, drop_jumps, join_at_steps, join

    real(dp), parameter :: AVERAGING = 0.05_dp          !! Held currents are averaged over it for the integrals, s
    real(dp), parameter :: RATE_WINDOW = 0.1_dp         !! Over which the rate of held currents is taken, s. Fitted to
                                                        !! the simulated set dirty: of three tried the one that gave
                                                        !! its true leakage by rates, K
    real(dp), parameter :: AROUND = 3                   !! Breaks are looked for so long before and behind a span's ends, s
    integer, parameter :: POINTS = 4                    !! Of a cubic

    type :: current_break_t
        !! Where the current of a rod goes over to another curve
        integer :: rod = 0
        integer :: before = 0               !! The last sample of the old curve
        real(dp) :: time = 0                !! Of the kink; of a jump the middle of its two samples, s from the epoch
        logical :: jump = .false.           !! The curves do not meet
    end type current_break_t

    type :: level1_drive_t
        !! The currents of the rods at any time
        logical :: steps = .false.                      !! Held from tag to tag; else smooth
        real(dp), allocatable :: time(:)                !! s from the epoch
        real(dp), allocatable :: current(:, :)          !! mA
        real(dp), allocatable :: charge(:, :)           !! Integral of held currents, mA s
        logical :: sharp = .false.                      !! Held currents as they are, not averaged
        type(current_break_t), allocatable :: breaks(:) !! Of smooth currents, by rod, in time
    contains
        procedure :: at => drive_at                     !! Currents and their rates at a time
    end type level1_drive_t

contains

    !> Currents of a calibration, smooth or held.
    pure subroutine new_drive(calibration, steps, drive)
        type(level1_calibration_t), intent(in) :: calibration
        logical, intent(in) :: steps    !! Held from sample to sample, not smooth
        type(level1_drive_t), intent(out) :: drive

        integer :: i

        drive%steps = steps
        drive%time = calibration%current_time
        drive%current = calibration%current
        allocate (drive%charge(3, size(drive%time)), drive%breaks(0))
        drive%charge(:, 1) = 0
        do i = 2, size(drive%time)
            drive%charge(:, i) = drive%charge(:, i - 1) + (drive%time(i) - drive%time(i - 1))*drive%current(:, i - 1)
        end do
        if (.not. steps) call find_breaks(calibration, drive)
    end subroutine new_drive

    !> The currents at a time: the cubic between the samples, or the held ones; and their rates, of held ones between
    !> samples of the accelerometer.
    pure subroutine drive_at(self, time, current, rate)
        class(level1_drive_t), intent(in) :: self
        real(dp), intent(in) :: time                    !! s from the epoch
        real(dp), intent(out) :: current(3)             !! mA
        real(dp), intent(out), optional :: rate(:)      !! 3, mA/s

        real(dp) :: slope(3)
        integer :: rod, first, last, middle

        if (.not. self%steps) then
            middle = last_not_after(self%time, time)
            call samples_at(0, first, last)
            call interpolate(self%time(first:last), self%current(:, first:last), time, current, rate)
            if (.not. any(abs(self%breaks%before - middle) <= POINTS)) return
            do rod = 1, 3
                call samples_at(rod, first, last)
                call interpolate(self%time(first:last), self%current(rod:rod, first:last), time, current(rod:rod), &
                                 slope(rod:rod))
            end do
            if (present(rate)) rate = slope
            return
        end if
        if (self%sharp) then
            current = hold(self%time, self%current, time)
        else
            current = (charge_at(self, time + AVERAGING/2) - charge_at(self, time - AVERAGING/2))/AVERAGING
        end if
        if (present(rate)) rate = (hold(self%time, self%current, time + RATE_WINDOW/2) - &
                                   hold(self%time, self%current, time - RATE_WINDOW/2))/RATE_WINDOW

    contains

        !> The samples of the cubic: the four nearest that no break of a rod (0: none) parts from the time.
        pure subroutine samples_at(rod, first, last)
            integer, intent(in) :: rod
            integer, intent(out) :: first, last

            integer :: low, high, i

            low = 1
            high = size(self%time)
            do i = 1, size(self%breaks)
                if (self%breaks(i)%rod /= rod) cycle
                if (self%breaks(i)%time <= time) then
                    low = max(low, self%breaks(i)%before + 1)
                else
                    high = min(high, self%breaks(i)%before)
                end if
            end do
            first = max(low, min(middle - 1, high - POINTS + 1))
            last = min(high, first + POINTS - 1)
        end subroutine samples_at
    end subroutine drive_at

    pure function charge_at(self, time) result(charge)
        class(level1_drive_t), intent(in) :: self
        real(dp), intent(in) :: time
        real(dp) :: charge(3)

        integer :: k

        k = max(1, last_not_after(self%time, time))
        charge = self%charge(:, k) + (time - self%time(k))*self%current(:, k)
    end function charge_at

    !> The breaks near the ends of the spans: where samples are not what the cubic through their four predecessors says,
    !> by much more than elsewhere there.
    pure subroutine find_breaks(calibration, drive)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_drive_t), intent(inout) :: drive

        real(dp) :: edge
        integer :: i, rod, side

        do rod = 1, 3
            do i = 1, size(calibration%spans)
                do side = 1, 2
                    edge = merge(calibration%spans(i)%start, calibration%spans(i)%stop, side == 1)
                    call find_break(drive, rod, edge - AROUND, edge + AROUND)
                end do
            end do
        end do
    end subroutine find_breaks

    !> The break of a rod between two times, if there is one.
    pure subroutine find_break(drive, rod, from, to)
        type(level1_drive_t), intent(inout) :: drive
        integer, intent(in) :: rod
        real(dp), intent(in) :: from, to            !! s

        real(dp), parameter :: LEAST = 3            ! mA: a jump of 1 mA
        real(dp), parameter :: TIMES = 5            ! The usual one on either side
        integer, parameter :: BESIDE = 20           ! Samples on either side that say what is usual
        type(current_break_t) :: found
        real(dp), allocatable :: surprise(:)        ! At a sample and the four before it, mA
        real(dp) :: predicted(1), usual, squares, lowest
        integer :: low, high, first, last, i

        low = last_not_after(drive%time, from)
        high = last_not_after(drive%time, to)
        first = max(POINTS + 1, low - BESIDE)
        last = min(size(drive%time), high + BESIDE + POINTS)
        if (high - low < POINTS .or. low - first < POINTS .or. last - high < 2*POINTS) return
        allocate (surprise(first:last))
        do i = first, last
            call interpolate(drive%time(i - POINTS:i - 1), drive%current(rod:rod, i - POINTS:i - 1), drive%time(i), predicted)
            surprise(i) = abs(drive%current(rod, i) - predicted(1))
        end do
        usual = max(median_of(surprise(first:low)), median_of(surprise(high + POINTS:last)))
        if (maxval(surprise(low + 1:high)) < max(LEAST, TIMES*usual)) return
        ! Without the samples whose cubic lies across the break nothing surprises.
        lowest = huge(lowest)
        do i = low, high - 1
            squares = sum(surprise(low + 1:i)**2) + sum(surprise(i + POINTS + 1:high + POINTS)**2)
            if (squares >= lowest) cycle
            lowest = squares
            found%before = i
        end do
        if (any(drive%breaks%rod == rod .and. drive%breaks%before == found%before)) return
        found%rod = rod
        call place(drive, found)
        drive%breaks = [drive%breaks, found]
    end subroutine find_break

    !> Where the curves before and behind a break meet, if they do.
    pure subroutine place(drive, break)
        type(level1_drive_t), intent(in) :: drive
        type(current_break_t), intent(inout) :: break

        integer, parameter :: PARTS = 50
        real(dp) :: before(1), behind(1), difference, last_difference, step
        integer :: i, k

        k = break%before
        step = (drive%time(k + 1) - drive%time(k))/PARTS
        last_difference = 0
        do i = 0, PARTS
            break%time = drive%time(k) + i*step
            call interpolate(drive%time(k - POINTS + 1:k), drive%current(break%rod:break%rod, k - POINTS + 1:k), break%time, before)
            call interpolate(drive%time(k + 1:k + POINTS), drive%current(break%rod:break%rod, k + 1:k + POINTS), break%time, behind)
            difference = behind(1) - before(1)
            if (difference*last_difference < 0) return
            last_difference = difference
        end do
        break%jump = .true.
        break%time = drive%time(k) + PARTS*step/2
    end subroutine place

    !> Tells the spans of the breaks of their currents: the attitude gets a step of its rate there, for what flows within
    !> half a second is not known well enough.
    pure subroutine mark_breaks(drive, delay, calibration)
        type(level1_drive_t), intent(in) :: drive
        real(dp), intent(in) :: delay               !! Of the torque, s
        type(level1_calibration_t), intent(inout) :: calibration

        real(dp), parameter :: SAME = 0.3_dp        ! s
        real(dp) :: time
        integer :: i, k

        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                span%breaks = [real(dp) ::]
                do k = 1, size(drive%breaks)
                    time = drive%breaks(k)%time + delay
                    if (time < span%start - AROUND .or. time > span%stop + AROUND) cycle
                    if (any(abs(span%breaks - time) < SAME)) cycle
                    span%breaks = [span%breaks, time]
                end do
            end associate
        end do
    end subroutine mark_breaks

    !> Leaves out the samples between two of a current that jumps between them.
    subroutine drop_jumps(drive, delay, calibration)
        type(level1_drive_t), intent(in) :: drive
        real(dp), intent(in) :: delay               !! Of torque and accelerometer, s
        type(level1_calibration_t), intent(inout) :: calibration

        real(dp), parameter :: BESIDE = 0.1_dp      ! s
        logical, allocatable :: stays(:)
        integer :: i, k

        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (.not. span%used) cycle
                allocate (stays(size(span%time)), source=.true.)
                do k = 1, size(drive%breaks)
                    associate (break => drive%breaks(k))
                        if (break%jump) stays = stays .and. .not. &
                            (span%time - delay > drive%time(break%before) - BESIDE .and. &
                             span%time - delay < drive%time(break%before + 1) + BESIDE)
                    end associate
                end do
                span%without_current = span%without_current + count(.not. stays)
                if (.not. all(stays)) call keep_samples(span, stays)
                deallocate (stays)
            end associate
        end do
    end subroutine drop_jumps

    !> Takes samples of the accelerometer two by two where a step of held currents lies between them, so near that the delay
    !> does not tell which of them shows it: both get their mean, as what they are compared with does. Where one of the two is
    !> not there, the other is left out.
    subroutine join_at_steps(drive, delay, delay_sigma, calibration)
        type(level1_drive_t), intent(in) :: drive
        real(dp), intent(in) :: delay               !! Of torque and accelerometer, s
        real(dp), intent(in) :: delay_sigma         !! Its sigma, s
        type(level1_calibration_t), intent(inout) :: calibration

        real(dp), parameter :: SIGMAS = 3, LARGEST = 0.04_dp    ! s: not both ends of a sample
        real(dp), parameter :: LONGEST_STEP = 0.15_dp           ! s, of samples that follow one another
        real(dp), parameter :: LEAST = 1                        ! mA: a step that is one
        real(dp) :: around
        logical, allocatable :: alone(:), stays(:)      ! alone: no sample follows at once
        integer :: i, k, n

        around = min(SIGMAS*delay_sigma, LARGEST)
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (.not. span%used) cycle
                n = size(span%time)
                alone = [span%time(2:) - span%time(:n - 1) > LONGEST_STEP, .true.]
                stays = [(.true., k=1, n)]
                span%joined = [(.false., k=1, n)]
                do k = 1, n
                    if (alone(k)) then
                        if (is_step(span%time(k) + SAMPLE/2)) stays(k) = .false.
                        if (k == n) exit
                        if (is_step(span%time(k + 1) - SAMPLE/2)) stays(k + 1) = .false.
                    else if (is_step((span%time(k) + span%time(k + 1))/2)) then
                        span%joined(k) = .true.
                        call join(span%linear(:, k:k + 1))
                        call join(span%angular(:, k:k + 1))
                    end if
                end do
                if (is_step(span%time(1) - SAMPLE/2)) stays(1) = .false.
                span%without_current = span%without_current + count(.not. stays)
                if (.not. all(stays)) call keep_samples(span, stays)
            end associate
        end do

    contains

        !> Is there a step as near as the delay tells to what a sample at some time shows?
        pure logical function is_step(time)
            real(dp), intent(in) :: time

            integer :: step

            is_step = .false.
            step = last_not_after(drive%time, time - delay + around)
            if (step <= 1) return
            if (drive%time(step) < time - delay - around) return
            is_step = any(abs(drive%current(:, step) - drive%current(:, step - 1)) >= LEAST)
        end function is_step
    end subroutine join_at_steps

    !> Gives two columns their mean.
    pure subroutine join(pair)
        real(dp), intent(inout) :: pair(:, :)       !! Two columns

        pair = spread(sum(pair, 2)/2, 2, 2)
    end subroutine join
end module gracecg_level1_drive
