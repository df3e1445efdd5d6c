!> Sequence-of-events files of GRACE and GRACE-FO (TN-01, TN-03): seconds spacecraft event N v1..vN comment.
module gracecg_level1_events
    use gracecg_level1_basics
    use gracecg_files_file, only: text_file_t
    use gracecg_level1_bundles, only: read_packed_text
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
        type(level1_event_t), allocatable :: sorted(:)
        type(level1_event_t) :: event
        character(:), allocatable :: line, problem
        integer :: i, k, used

        allocate (events(0))
        call read_packed_text(path, file, error)
        if (allocated(error)) return
        allocate (sorted(file%line_count()))
        used = 0
        do i = 1, size(sorted)
            line = adjustl(file%line(i))//' '
            if (scan(line(1:1), ' xX#') > 0) cycle
            call parse_event(split_words(line), event, problem)
            if (allocated(problem)) then
                call file%fail_at(i, problem, error)
                return
            end if
            do k = used, 1, -1      ! insertion: files are sorted but for a few lines
                if (sorted(k)%time <= event%time) exit
                sorted(k + 1) = sorted(k)
            end do
            sorted(k + 1) = event
            used = used + 1
        end do
        events = sorted(:used)
    end subroutine read_events

    !> The event of a line.
    subroutine parse_event(words, event, problem)
        type(string_t), intent(in) :: words(:)
        type(level1_event_t), intent(out) :: event
        character(:), allocatable, intent(out) :: problem   !! Allocated when it is none

        integer :: k, values
        logical :: ok

        ok = size(words) >= 4
        if (ok) call parse_real(words(1)%text, event%time, ok)
        if (ok) call parse_integer(words(4)%text, values, ok)
        if (ok) ok = values >= 0 .and. values <= size(words) - 4
        if (.not. ok) then
            problem = 'this is no event; expected: seconds spacecraft event N v1 ... vN comment'
            return
        end if
        event%spacecraft = words(2)%text
        event%name = words(3)%text
        allocate (event%values(values))
        do k = 1, values
            call parse_real(words(4 + k)%text, event%values(k), ok)
            if (.not. ok .and. .not. allocated(problem)) problem = 'value '//integer_text(k)//' of '//trim(event%name)// &
                ', "'//words(4 + k)%text//'", is no number'
        end do
    end subroutine parse_event

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
