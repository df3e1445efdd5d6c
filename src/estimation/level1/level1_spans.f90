!> The sub-manoeuvres of a calibration, found in the currents of the rods.
module gracecg_estimation_level1_spans
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_estimation_level1_basis, only: orthonormalise, remove_space
    implicit none
    private
    public :: find_spans, strongest_line

    real(dp), parameter :: WINDOW = 20, SHIFT = 4           !! s
    real(dp), parameter :: SLOWEST = 2/60.0_dp, FASTEST = 25/60.0_dp    !! Of lines, Hz
    real(dp), parameter :: LONGEST_PAUSE = 4                !! Below the science level within a span, s
    integer, parameter :: MOST_LINES = 3
    integer, parameter :: FEWEST_SAMPLES = 20
    real(dp), parameter :: SHORTEST = 10                    !! A span, s

contains

    !> Begin and end of the sub-manoeuvres: where in a window of 20 s some rod's current ranges over more than a
    !> manoeuvre's, and lines of 2 to 25 cycles a minute explain the variance of every such rod.
    subroutine find_spans(times, currents, science, excitation, share, spans)
        real(dp), intent(in) :: times(:)                    !! Rising, s
        real(dp), intent(in) :: currents(:, :)              !! (3, n), mA
        real(dp), intent(in) :: science, excitation         !! Level of science mode and least range, mA
        real(dp), intent(in) :: share                       !! Of the variance
        real(dp), allocatable, intent(out) :: spans(:, :)   !! (2, m): begin and end, s

        logical :: driven(size(times))
        real(dp) :: start, begun, last
        integer :: first, end_of, i
        logical :: running

        driven = .false.
        start = times(1)
        first = 1
        do while (start + WINDOW <= times(size(times)))
            do while (times(first) < start)
                first = first + 1
            end do
            end_of = first
            do while (end_of < size(times))
                if (times(end_of + 1) > start + WINDOW) exit
                end_of = end_of + 1
            end do
            if (end_of - first + 1 >= FEWEST_SAMPLES) then
                if (is_driven(times(first:end_of), currents(:, first:end_of), excitation, share)) driven(first:end_of) = .true.
            end if
            start = start + SHIFT
        end do
        ! A span is where currents are above the science level and some window says manoeuvre; windows at its ends hold
        ! quiet samples too, and those on its edges may fit no line.
        allocate (spans(2, 0))
        running = .false.
        begun = 0
        last = 0
        do i = 1, size(times)
            if (running .and. times(i) - last > LONGEST_PAUSE) then
                call add(begun, last)
                running = .false.
            end if
            if (maxval(abs(currents(:, i))) <= science) cycle
            if (.not. running) begun = times(i)
            running = .true.
            last = times(i)
        end do
        if (running) call add(begun, last)

    contains

        subroutine add(from, to)
            real(dp), intent(in) :: from, to

            if (to - from < SHORTEST) return
            if (2*count(driven .and. times >= from .and. times <= to) < count(times >= from .and. times <= to)) return
            spans = reshape([spans, from, to], [2, size(spans, 2) + 1])
        end subroutine add
    end subroutine find_spans

    logical function is_driven(times, currents, excitation, share)
        real(dp), intent(in) :: times(:), currents(:, :), excitation, share

        real(dp) :: left(size(times)), total, frequency, amplitude, phase
        integer :: rod, line
        logical :: some

        some = .false.
        is_driven = .false.
        do rod = 1, 3
            if (maxval(currents(rod, :)) - minval(currents(rod, :)) <= excitation) cycle
            some = .true.
            left = currents(rod, :) - sum(currents(rod, :))/size(times)
            total = sum(left**2)
            do line = 1, MOST_LINES
                call strongest_line(times, left, frequency, amplitude, phase)
                if (sum(left**2) < (1 - share)*total) exit
            end do
            if (sum(left**2) >= (1 - share)*total) return
        end do
        is_driven = some
    end function is_driven

    !> The line amplitude sin(2 pi frequency (t - t_1) + phase) that explains most of some samples, which are left
    !> without it, and without a mean.
    subroutine strongest_line(times, samples, frequency, amplitude, phase)
        real(dp), intent(in) :: times(:)            !! Rising, s
        real(dp), intent(inout) :: samples(:)       !! Any unit
        real(dp), intent(out) :: frequency          !! Hz
        real(dp), intent(out) :: amplitude          !! Unit of the samples
        real(dp), intent(out) :: phase              !! rad

        real(dp) :: best, explained, step, centre, u(size(times)), rest(size(times)), normal(2, 2), rhs(2), x(2)
        real(dp), allocatable :: basis(:, :)
        integer :: round, i

        u = times - times(1)
        step = 0.2_dp/max(WINDOW, u(size(u)))
        centre = SLOWEST
        best = -1
        frequency = SLOWEST
        do i = 0, int((FASTEST - SLOWEST)/step)
            explained = power(SLOWEST + i*step)
            if (explained > best) then
                best = explained
                frequency = SLOWEST + i*step
            end if
        end do
        do round = 1, 3
            centre = frequency
            step = step/4
            do i = -4, 4
                explained = power(centre + i*step)
                if (explained > best) then
                    best = explained
                    frequency = centre + i*step
                end if
            end do
        end do
        allocate (basis(size(times), 1), source=1.0_dp)
        call orthonormalise(basis)
        call remove_space(basis, samples)
        rest = sin(TWO_PI*frequency*u)
        normal(1, 1) = sum(rest**2)
        normal(1, 2) = sum(rest*cos(TWO_PI*frequency*u))
        normal(2, 2) = sum(cos(TWO_PI*frequency*u)**2)
        rhs = [sum(rest*samples), sum(cos(TWO_PI*frequency*u)*samples)]
        x(2) = (rhs(2)*normal(1, 1) - rhs(1)*normal(1, 2))/(normal(1, 1)*normal(2, 2) - normal(1, 2)**2)
        x(1) = (rhs(1) - normal(1, 2)*x(2))/normal(1, 1)
        amplitude = hypot(x(1), x(2))
        phase = atan2(x(2), x(1))
        samples = samples - x(1)*rest - x(2)*cos(TWO_PI*frequency*u)

    contains

        real(dp) function power(f)
            real(dp), intent(in) :: f

            real(dp), allocatable :: columns(:, :)

            allocate (columns(size(times), 3))
            columns(:, 1) = 1
            columns(:, 2) = sin(TWO_PI*f*u)
            columns(:, 3) = cos(TWO_PI*f*u)
            call orthonormalise(columns)
            power = sum(matmul(samples, columns(:, 2:))**2)
        end function power
    end subroutine strongest_line
end module gracecg_estimation_level1_spans
