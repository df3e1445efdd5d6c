!> Sequence-of-events files of GRACE and GRACE-FO (TN-01, TN-03): seconds spacecraft event N v1..vN comment.
module gracecg_level1_events
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, split_words, parse_real, parse_integer, integer_text
    use gracecg_files_file, only: text_file_t, read_text_file
    implicit none
    private
    public :: level1_event_t, read_events, manoeuvre_spans

    type :: level1_event_t
        !! One event; a state holds until the next event of its kind
        real(dp) :: time = 0                        !! s past 2000-01-01 12:00 GPS
        character(8) :: spacecraft = ''             !! GRACEA to GRACED, or GRACEX: both
        character(16) :: name = ''                  !! CMCAL, VCM, ...
        real(dp), allocatable :: values(:)          !! v1 to vN
    end type level1_event_t

contains

    !> Reads the events of a file, sorted by time (as they stand where times are equal); blank lines, those that begin
    !> with x (deleted) and with # (comments) are left out. Fails at a line that is no event.
    subroutine read_events(path, events, error)
        character(*), intent(in) :: path    !! Of the file
        type(level1_event_t), allocatable, intent(out) :: events(:)
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: file
        type(level1_event_t), allocatable :: grown(:)
        type(level1_event_t) :: event
        type(string_t), allocatable :: words(:)
        character(:), allocatable :: line
        integer :: i, k, count, values, used
        logical :: ok

        allocate (events(0))
        call read_text_file(path, file, error)
        if (allocated(error)) return
        used = 0
        do i = 1, file%line_count()
            line = adjustl(file%line(i))
            if (len_trim(line) == 0) cycle
            if (scan(line(1:1), 'xX#') > 0) cycle
            words = split_words(line)
            ok = size(words) >= 4
            if (ok) call parse_real(words(1)%text, event%time, ok)
            if (ok) call parse_integer(words(4)%text, values, ok)
            if (ok) ok = values >= 0 .and. values <= size(words) - 4
            if (.not. ok) then
                call file%fail_at(i, 'this is no event; expected: seconds spacecraft event N v1 ... vN comment', error)
                return
            end if
            event%spacecraft = words(2)%text
            event%name = words(3)%text
            if (allocated(event%values)) deallocate (event%values)
            allocate (event%values(values))
            do k = 1, values
                call parse_real(words(4 + k)%text, event%values(k), ok)
                if (.not. ok) then
                    call file%fail_at(i, 'value '//integer_text(k)//' of '//trim(event%name)//', "'//words(4 + k)%text// &
                                           '", is no number', error)
                    return
                end if
            end do
            if (used == size(events)) then
                count = max(16, 2*used)
                allocate (grown(count))
                grown(:used) = events(:used)
                call move_alloc(grown, events)
            end if
            used = used + 1
            events(used) = event
        end do
        grown = events(:used)
        call move_alloc(grown, events)
        call sort_by_time(events)
    end subroutine read_events

    !> Sorts by insertion: files are sorted but for a few lines.
    subroutine sort_by_time(events)
        type(level1_event_t), intent(inout) :: events(:)

        type(level1_event_t) :: event
        integer :: i, k

        do i = 2, size(events)
            if (events(i)%time >= events(i - 1)%time) cycle
            event = events(i)
            k = i
            do while (k > 1)
                if (events(k - 1)%time <= event%time) exit
                events(k) = events(k - 1)
                k = k - 1
            end do
            events(k) = event
        end do
    end subroutine sort_by_time

    !> Begin and end of the calibration manoeuvres of a satellite: CMCAL other than 0 begins one, 0 ends it.
    subroutine manoeuvre_spans(events, satellite, spans)
        type(level1_event_t), intent(in) :: events(:)
        character(1), intent(in) :: satellite               !! A to D
        real(dp), allocatable, intent(out) :: spans(:, :)   !! (2, n), s past 2000-01-01 12:00 GPS

        real(dp) :: start
        logical :: running
        integer :: i

        allocate (spans(2, 0))
        running = .false.
        start = 0
        do i = 1, size(events)
            if (events(i)%name /= 'CMCAL' .or. size(events(i)%values) == 0) cycle
            if (events(i)%spacecraft /= 'GRACE'//satellite .and. events(i)%spacecraft /= 'GRACEX') cycle
            if (running .and. events(i)%time > start) then
                spans = reshape([spans, start, events(i)%time], [2, size(spans, 2) + 1])
            end if
            running = abs(events(i)%values(1)) > 0
            start = events(i)%time
        end do
    end subroutine manoeuvre_spans
end module gracecg_level1_events
