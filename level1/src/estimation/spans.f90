!> The sub-manoeuvres of a calibration: given, of an SOE file, or found in the currents of the rods; and the lines in these.
module gracecg_level1_spans
    use gracecg_level1_basics
    use gracecg_files_file, only: text_file_t, read_text_file
    use gracecg_level1_calibration, only: level1_calibration_t, note, SPAN_MARGIN, level1_span_t
    use gracecg_level1_events, only: level1_event_t, read_events, manoeuvre_spans
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_time, only: gps_date_text
    implicit none
    private
    public :: said_spans, choose_spans, find_spans, equal_spans, strongest_line, rod_lines_t, find_rod_lines

    real(dp), parameter :: WINDOW = 20, SHIFT = 4           !! s
    real(dp), parameter :: SLOWEST = 2/60.0_dp, FASTEST = 25/60.0_dp    !! Of lines, Hz
    real(dp), parameter :: LONGEST_PAUSE = 4                !! Below the science level within a span, s
    character(*), parameter :: FROM_EVENTS = 'the SOE file (CMCAL)'
    integer, parameter :: MOST_LINES = 3
    integer, parameter :: FEWEST_SAMPLES = 20
    real(dp), parameter :: SHORTEST = 10                    !! A span, s

    type :: rod_lines_t
        !! The strongest line of each rod: amplitude sin(2 pi frequency (t - start) + phase)
        real(dp) :: frequency(3) = 0        !! Hz
        real(dp) :: amplitude(3) = 0        !! mA
        real(dp) :: phase(3) = 0            !! deg
    end type rod_lines_t

contains

    !> The spans that are said, s past 2000-01-01 12:00 GPS: given, of a file, or of the SOE files in the folder.
    subroutine said_spans(spans_file, given_span, calibration, spans, error)
        character(*), intent(in) :: spans_file    !! A file of spans; empty: none
        real(dp), intent(in) :: given_span(:, :)    !! (2, n): begin and duration, s; of size 0: none
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), allocatable, intent(out) :: spans(:, :)    !! (2, m): begin and end, s; of size 0: nobody says
        type(error_t), allocatable, intent(out) :: error

        type(level1_event_t), allocatable :: events(:)
        real(dp), allocatable :: of_file(:, :)
        integer :: i

        spans = given_span
        if (size(spans, 2) > 0) then
            if (any(.not. spans(2, :) > 0)) then
                call fail(error, 'a span''s duration is '//real_text(minval(spans(2, :)))//' s: it has to be positive')
                return
            end if
            spans(2, :) = spans(1, :) + spans(2, :)
            calibration%spans_from = 'the command line'
        else if (spans_file /= '') then
            call read_spans(spans_file, calibration%satellite, spans, error)
            if (allocated(error)) return
            calibration%spans_from = 'a file'
        else
            do i = 1, size(calibration%files%events)
                call read_events(calibration%files%events(i)%text, events, error)
                if (allocated(error)) return
                call manoeuvre_spans(events, calibration%satellite, of_file)
                spans = joined(spans, of_file)
                calibration%spans_from = FROM_EVENTS
            end do
        end if
    end subroutine said_spans

    !> Spans of two files in order of time; where they overlap, those of the latter.
    pure function joined(earlier, latter) result(spans)
        real(dp), intent(in) :: earlier(:, :), latter(:, :)     !! (2, .): begin and end, s; each in order of time
        real(dp), allocatable :: spans(:, :)

        integer :: i, before

        spans = latter
        do i = 1, size(earlier, 2)
            if (any(latter(1, :) < earlier(2, i) .and. latter(2, :) > earlier(1, i))) cycle
            before = count(spans(1, :) < earlier(1, i))
            spans = reshape([spans(:, :before), earlier(:, i), spans(:, before + 1:)], [2, size(spans, 2) + 1])
        end do
    end function joined

    !> The spans, s from the epoch: those that are said and lie within the data, else those that the currents show.
    subroutine choose_spans(said, day, calibration, spans, error)
        real(dp), intent(in) :: said(:, :)      !! (2, n): begin and end, s past 2000-01-01 12:00 GPS
        character(*), intent(in) :: day         !! The manoeuvre that this day has part of, YYYY-MM-DD; empty: the only one
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), allocatable, intent(out) :: spans(:, :)    !! (2, m): begin and end, s
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: first, last
        integer :: outside

        spans = said - real(calibration%epoch, dp)
        first = calibration%current_time(1)
        last = calibration%current_time(size(calibration%current_time))
        if (size(spans, 2) > 0) then
            spans = some_of(spans, spans(2, :) > first .and. spans(1, :) < last)
            outside = size(said, 2) - size(spans, 2)
            if (outside > 0 .and. calibration%spans_from /= FROM_EVENTS) then
                call fail(error, integer_text(outside)//' of '//integer_text(size(said, 2))//' spans of '// &
                          trim(calibration%spans_from)//' lie outside of the data, which go from '//real_text(anint(first + &
                          calibration%epoch))//' to '//real_text(anint(last + calibration%epoch))//' s: a span begins at GPS '// &
                          'seconds past 2000-01-01 12:00')
                return
            end if
            if (size(spans, 2) == 0) call note(calibration, 'no span of '//trim(calibration%spans_from)//' lies within the data')
        end if
        if (calibration%spans_from == FROM_EVENTS) call narrow_by_currents(calibration, spans)
        if (size(spans, 2) == 0) then
            call find_spans(calibration%current_time, calibration%current, calibration%setup, spans)
            calibration%spans_from = 'the currents'
        end if
        if (size(spans, 2) == 0) then
            call fail(error, 'no manoeuvre found: no span is given, no SOE file has CMCAL events within '// &
                      'the data, and the currents of the rods (at most '// &
                      real_text(nint(10*calibration%largest_current)/10.0_dp)//' mA) are those of science mode')
        else if (calibration%spans_from == FROM_EVENTS .or. calibration%spans_from == 'the currents') then
            call choose_manoeuvre(calibration, day, spans, error)
        end if
    end subroutine choose_spans

    !> Spans of equal length throughout the currents, or a part of them, as long as wanted or a little less; where attitude may be
    !> missing, at the ends, there is none.
    pure function equal_spans(times, part, length) result(spans)
        real(dp), intent(in) :: times(:)        !! Of the currents, s
        real(dp), intent(in) :: part(2)         !! Begin and end, s
        real(dp), intent(in) :: length          !! s
        real(dp), allocatable :: spans(:, :)    !! (2, n): begin and end, s

        real(dp) :: first, last
        integer :: i, n

        first = max(part(1), times(1) + SPAN_MARGIN)
        last = min(part(2), times(size(times)) - SPAN_MARGIN)
        n = max(1, ceiling((last - first)/length))
        allocate (spans(2, n))
        spans(1, :) = [(first + (i - 1)*(last - first)/n, i=1, n)]
        spans(2, :) = spans(1, :) + (last - first)/n
    end function equal_spans

    !> The spans of one manoeuvre: half a day without a span parts two, between which the masses may have been moved.
    !> Fails when there are several, and the day does not tell which is meant.
    subroutine choose_manoeuvre(calibration, day, spans, error)
        type(level1_calibration_t), intent(in) :: calibration
        character(*), intent(in) :: day
        real(dp), allocatable, intent(inout) :: spans(:, :)     !! (2, m): begin and end in time, s from the epoch
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: LONGEST_PAUSE = 43200    ! s
        integer, parameter :: MOST_TOLD = 5
        integer :: number(size(spans, 2)), i, first
        logical :: meant(size(spans, 2))
        character(:), allocatable :: list

        number = 1
        do i = 2, size(number)
            number(i) = number(i - 1)
            if (spans(1, i) - maxval(spans(2, :i - 1)) > LONGEST_PAUSE) number(i) = number(i) + 1
        end do
        meant = .true.
        if (day /= '') then
            meant = [(index(date_at(spans(1, i)), day) == 1 .or. index(date_at(spans(2, i)), day) == 1, i=1, size(number))]
            meant = [(any(meant .and. number == number(i)), i=1, size(number))]
        end if
        first = max(1, findloc(meant, .true., 1))
        if (all(meant .eqv. number == number(first))) then
            spans = some_of(spans, meant)
            return
        end if
        list = ''
        do i = 1, min(MOST_TOLD, maxval(number))
            first = findloc(number, i, 1)
            list = list//date_at(spans(1, first))//' ('//integer_text(count(number == i))//' spans), '
        end do
        list = list(:len(list) - 2)
        if (maxval(number) > MOST_TOLD) list = list//', ...'
        if (.not. any(meant)) then
            call fail(error, 'no manoeuvre found on '//day//', but at '//list)
        else if (day == '') then
            call fail(error, 'the files have '//integer_text(maxval(number))//' manoeuvres, between which the masses may '// &
                      'have been moved: '//list//'; choose one by its day (--day), or give the spans (--spans)')
        else
            call fail(error, day//' has part of several manoeuvres: '//list//'; give the spans (--spans)')
        end if

    contains

        !> The date of a time from the epoch, to the minute.
        character(16) function date_at(time)
            real(dp), intent(in) :: time    ! s

            character(26) :: full

            full = gps_date_text(calibration%epoch + floor(time, i8), 0.0_dp)
            date_at = full(:len(date_at))
        end function date_at
    end subroutine choose_manoeuvre

    !> Some of some spans.
    pure function some_of(spans, wanted) result(chosen)
        real(dp), intent(in) :: spans(:, :)     !! (2, n)
        logical, intent(in) :: wanted(:)
        real(dp) :: chosen(2, count(wanted))

        chosen(1, :) = pack(spans(1, :), wanted)
        chosen(2, :) = pack(spans(2, :), wanted)
    end function some_of

    !> Events are said, currents flow: where an event is longer than what its currents show, or holds several
    !> sub-manoeuvres, these are the spans.
    subroutine narrow_by_currents(calibration, spans)
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), allocatable, intent(inout) :: spans(:, :)     !! (2, m): begin and end, s

        real(dp), parameter :: AROUND = 30      ! s, of currents that are looked at
        real(dp), parameter :: ENOUGH = 2       ! s, that an event may be longer at either end
        real(dp), allocatable :: found(:, :), narrowed(:, :)
        integer, allocatable :: near(:)
        integer :: i, k, changed

        allocate (narrowed(2, 0))
        changed = 0
        do i = 1, size(spans, 2)
            near = pack([(k, k=1, size(calibration%current_time))], calibration%current_time > spans(1, i) - AROUND .and. &
                        calibration%current_time < spans(2, i) + AROUND)
            call find_spans(calibration%current_time(near), calibration%current(:, near), calibration%setup, found)
            found = some_of(found, found(1, :) > spans(1, i) - ENOUGH .and. found(2, :) < spans(2, i) + ENOUGH)
            if (size(found, 2) == 1) then
                if (found(1, 1) < spans(1, i) + ENOUGH .and. found(2, 1) > spans(2, i) - ENOUGH) found = spans(:, i:i)
            end if
            if (size(found, 2) == 0) found = spans(:, i:i)
            if (size(found, 2) > 1 .or. abs(found(1, 1) - spans(1, i)) + abs(found(2, 1) - spans(2, i)) > 0) &
                changed = changed + 1
            narrowed = reshape([narrowed, found], [2, size(narrowed, 2) + size(found, 2)])
        end do
        if (changed > 0) call note(calibration, integer_text(changed)//' of '//integer_text(size(spans, 2))//' CMCAL events '// &
                                   'are longer than what the currents show, or hold several sub-manoeuvres: the spans are '// &
                                   'those of the currents within them')
        call move_alloc(narrowed, spans)
    end subroutine narrow_by_currents

    !> A file of spans: SOE, or lines of start and duration, s past 2000-01-01 12:00 GPS.
    subroutine read_spans(path, satellite, spans, error)
        character(*), intent(in) :: path
        character(1), intent(in) :: satellite
        real(dp), allocatable, intent(out) :: spans(:, :)
        type(error_t), allocatable, intent(out) :: error

        type(level1_event_t), allocatable :: events(:)
        type(error_t), allocatable :: other

        allocate (spans(2, 0))
        call read_span_lines(path, spans, other)
        if (size(spans, 2) > 0 .and. allocated(other)) call move_alloc(other, error)      ! the first line is of spans
        if (allocated(error) .or. size(spans, 2) > 0) return
        call read_events(path, events, error)
        if (allocated(error)) return
        call manoeuvre_spans(events, satellite, spans)
        if (size(spans, 2) == 0) call fail(error, path//': no CMCAL event of satellite '//satellite)
    end subroutine read_spans

    subroutine read_span_lines(path, spans, error)
        character(*), intent(in) :: path
        real(dp), allocatable, intent(inout) :: spans(:, :)
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: file
        type(string_t), allocatable :: words(:)
        real(dp) :: start, duration
        integer :: i
        logical :: ok

        call read_text_file(path, file, error)
        if (allocated(error)) return
        do i = 1, file%line_count()
            words = split_words(file%line(i))
            if (size(words) == 0) cycle
            ok = size(words) == 2
            if (ok) call parse_real(words(1)%text, start, ok)
            if (ok) call parse_real(words(2)%text, duration, ok)
            if (ok) ok = duration > 0
            if (.not. ok) then
                call file%fail_at(i, 'expected start and duration of a span, s', error)
                return
            end if
            spans = reshape([spans, start, start + duration], [2, size(spans, 2) + 1])
        end do
    end subroutine read_span_lines

    !> Begin and end of the sub-manoeuvres: where in a window of 20 s some rod's current ranges over more than a
    !> manoeuvre's, and lines of 2 to 25 cycles a minute explain the variance of every such rod.
    subroutine find_spans(times, currents, setup, spans)
        real(dp), intent(in) :: times(:)                    !! Rising, s
        real(dp), intent(in) :: currents(:, :)              !! (3, n), mA
        type(level1_setup_t), intent(in) :: setup           !! Level of science mode, least range, share of the variance
        real(dp), allocatable, intent(out) :: spans(:, :)   !! (2, m): begin and end, s

        logical :: driven(size(times))
        real(dp) :: start, begun, last
        integer :: first, end_of, i
        logical :: running

        driven = .false.
        start = times(1)
        do while (start + WINDOW <= times(size(times)))
            first = last_not_after(times, start)
            if (times(first) < start) first = first + 1
            end_of = last_not_after(times, start + WINDOW)
            if (end_of - first + 1 >= FEWEST_SAMPLES) then
                if (is_driven(first, end_of)) driven(first:end_of) = .true.
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
            if (maxval(abs(currents(:, i))) <= setup%science_current) cycle
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

        !> Whether lines explain the current of every rod that ranges over more than a manoeuvre's in some samples, one at least.
        logical function is_driven(first, last)
            integer, intent(in) :: first, last

            real(dp) :: left(last - first + 1), total, frequency, amplitude, phase
            integer :: rod, line

            is_driven = .false.
            do rod = 1, 3
                left = currents(rod, first:last)
                if (maxval(left) - minval(left) <= setup%excitation_current) cycle
                left = left - sum(left)/size(left)
                total = sum(left**2)
                do line = 1, MOST_LINES
                    call strongest_line(times(first:last), left, frequency, amplitude, phase)
                    is_driven = sum(left**2) < (1 - setup%sine_share)*total
                    if (is_driven) exit
                end do
                if (.not. is_driven) return
            end do
        end function is_driven
    end subroutine find_spans

    !> The line amplitude sin(2 pi frequency (t - t_1) + phase) that explains most of some samples, which are left
    !> without it, and without a mean.
    subroutine strongest_line(times, samples, frequency, amplitude, phase)
        real(dp), intent(in) :: times(:)            !! Rising, s
        real(dp), intent(inout) :: samples(:)       !! Any unit
        real(dp), intent(out) :: frequency          !! Hz
        real(dp), intent(out) :: amplitude          !! Unit of the samples
        real(dp), intent(out) :: phase              !! rad

        real(dp) :: best, explained, step, centre, x(3), rows(3, size(times))
        integer :: round, i

        step = 0.2_dp/max(WINDOW, times(size(times)) - times(1))
        centre = SLOWEST
        best = -1
        frequency = SLOWEST
        do i = 0, int((FASTEST - SLOWEST)/step)
            call try(SLOWEST + i*step)
        end do
        do round = 1, 3
            centre = frequency
            step = step/4
            do i = -4, 4
                call try(centre + i*step)
            end do
        end do
        call fit(frequency)
        amplitude = hypot(x(2), x(3))
        phase = atan2(x(3), x(2))
        samples = samples - matmul(x, rows)

    contains

        !> Whether a line of a frequency explains more than the best so far.
        subroutine try(f)
            real(dp), intent(in) :: f

            call fit(f)
            if (.not. explained > best) return
            best = explained
            frequency = f
        end subroutine try

        !> A constant and a line of a frequency, and the squares that the line explains.
        subroutine fit(f)
            real(dp), intent(in) :: f

            real(dp) :: normal(3, 3), rhs(3), covariance(3, 3), condition
            type(error_t), allocatable :: failure

            rows(1, :) = 1
            rows(2, :) = sin(TWO_PI*f*(times - times(1)))
            rows(3, :) = cos(TWO_PI*f*(times - times(1)))
            call normal_equations(rows, samples, normal, rhs)
            call solve_normal_equations(normal, rhs, x, covariance, condition, failure)
            explained = -1
            if (.not. allocated(failure)) explained = dot_product(x, rhs) - rhs(1)**2/size(times)
        end subroutine fit
    end subroutine strongest_line

    !> Finds them. Zeros: the span has too few currents.
    subroutine find_rod_lines(calibration, span, lines)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_span_t), intent(in) :: span
        type(rod_lines_t), intent(out) :: lines

        integer, parameter :: FEWEST = 12
        real(dp), parameter :: LONGEST = 900        ! s: of a longer span that much
        real(dp), allocatable :: times(:), left(:)
        logical :: inside(size(calibration%current_time))
        integer :: rod

        inside = calibration%current_time >= span%start .and. calibration%current_time <= min(span%stop, span%start + LONGEST)
        if (count(inside) < FEWEST) return
        times = pack(calibration%current_time, inside)
        do rod = 1, 3
            left = pack(calibration%current(rod, :), inside)
            call strongest_line(times, left, lines%frequency(rod), lines%amplitude(rod), lines%phase(rod))
            lines%phase(rod) = lines%phase(rod)/DEGREE - 360*lines%frequency(rod)*(times(1) - span%start)
            lines%phase(rod) = modulo(lines%phase(rod) + 180, 360.0_dp) - 180
        end do
    end subroutine find_rod_lines
end module gracecg_level1_spans
