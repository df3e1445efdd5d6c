!> Who wants to know how far a long work is, and whether it shall go on.
!>
!> A work is done in pieces (runs, places, evaluations), counted here; it may be a part of a larger one, which
!> has so many parts (chapters, say). The listener shows one line: what is done of all, in percent, the time
!> that is left at the speed so far, and what is worked on.
module gracecg_base_progress
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_text, only: integer_text
    implicit none
    private
    public :: progress_t, tell, expect_pieces, piece_done, is_stopped

    integer, parameter :: LABEL_LENGTH = 60, UNIT_LENGTH = 16
    real(dp), parameter :: SHORTEST_INTERVAL = 0.2_dp   !! Between two lines that only count on, s
    real(dp), parameter :: FIRST_FORECAST = 1           !! Of the time left: after this, s

    !> Something that shows progress: the console of the program, say.
    type, abstract :: progress_t
        logical :: stopped = .false.        !! The work shall stop; what is begun is ended
        character(LABEL_LENGTH), private :: label = ''          !! What is worked on
        character(UNIT_LENGTH), private :: pieces = '', parts = ''  !! What is counted, in the plural
        integer, private :: done = 0, all = 0                   !! Pieces; all is 0 where they are not counted
        integer, private :: part = 0, all_parts = 0             !! Of the larger work
        real(dp), private :: before = 0     !! Part of the whole that was done when the clock was started
        integer(i8), private :: started = 0, shown = 0          !! Readings of the clock
    contains
        procedure(progress_interface), deferred :: progress     !! Shows what is worked on
        procedure :: expect_parts       !! The work has so many parts; the first begins
        procedure :: next_part          !! A part is done, the next begins
        procedure :: expect             !! So many pieces follow
        procedure :: advance            !! A piece is done
        procedure :: stops              !! Shall the work stop?
        procedure, private :: progress_line      !! What is shown
    end type progress_t

    abstract interface
        subroutine progress_interface(self, text)
            import :: progress_t
            class(progress_t), intent(inout) :: self
            character(*), intent(in) :: text    !! How far, and what is worked on now, without a line end
        end subroutine progress_interface
    end interface

contains

    !> Tells a listener, where there is one, what is worked on now.
    subroutine tell(listener, text)
        class(progress_t), intent(inout), optional :: listener
        character(*), intent(in) :: text        !! What is worked on now

        if (.not. present(listener)) return
        listener%label = text
        call listener%progress(trim(listener%progress_line()))
    end subroutine tell

    !> Tells a listener, where there is one, how many pieces follow.
    subroutine expect_pieces(listener, all, pieces)
        class(progress_t), intent(inout), optional :: listener
        integer, intent(in) :: all              !! Their number
        character(*), intent(in) :: pieces      !! What they are, in the plural

        if (present(listener)) call listener%expect(all, pieces)
    end subroutine expect_pieces

    !> Tells a listener, where there is one, that a piece is done.
    subroutine piece_done(listener)
        class(progress_t), intent(inout), optional :: listener

        if (present(listener)) call listener%advance()
    end subroutine piece_done

    !> Whether a listener, where there is one, wants the work to stop.
    logical function is_stopped(listener)
        class(progress_t), intent(in), optional :: listener

        is_stopped = .false.
        if (present(listener)) is_stopped = listener%stops()
    end function is_stopped

    subroutine expect_parts(self, all, parts)
        class(progress_t), intent(inout) :: self
        integer, intent(in) :: all              !! Their number
        character(*), intent(in) :: parts       !! What they are, in the plural

        self%part = 1
        self%all_parts = all
        self%parts = parts
        self%done = 0
        self%all = 0
        self%before = 0
        call system_clock(self%started)
    end subroutine expect_parts

    subroutine next_part(self)
        class(progress_t), intent(inout) :: self

        self%part = min(self%part + 1, self%all_parts)
        self%done = 0
        self%all = 0
    end subroutine next_part

    subroutine expect(self, all, pieces, done)
        class(progress_t), intent(inout) :: self
        integer, intent(in) :: all              !! Their number
        character(*), intent(in) :: pieces      !! What they are, in the plural
        integer, intent(in), optional :: done   !! How many of them are done already

        self%done = 0
        if (present(done)) self%done = done
        self%all = all
        self%pieces = pieces
        if (self%all_parts > 0) return
        self%before = whole_done(self)
        call system_clock(self%started)
    end subroutine expect

    !> Counts a piece and, now and then, shows it. Not to be called from two threads at once.
    subroutine advance(self)
        class(progress_t), intent(inout) :: self

        integer(i8) :: now, rate

        if (self%all == 0) return
        self%done = min(self%done + 1, self%all)
        call system_clock(now, rate)
        if (now - self%shown < SHORTEST_INTERVAL*rate) return
        self%shown = now
        call self%progress(trim(self%progress_line()))
    end subroutine advance

    logical function stops(self)
        class(progress_t), intent(in) :: self

        stops = self%stopped
    end function stops

    !> What part of the whole work is done, 0 to 1.
    pure real(dp) function whole_done(self)
        class(progress_t), intent(in) :: self

        whole_done = real(self%done, dp)/max(1, self%all)
        if (self%all_parts > 0) whole_done = (self%part - 1 + whole_done)/self%all_parts
    end function whole_done

    !> "part 3 of 14, 45/360 runs, 17 %, 2 min left: front-1, assest-fde"
    function progress_line(self) result(line)
        class(progress_t), intent(in) :: self
        character(160) :: line

        integer(i8) :: now, rate
        real(dp) :: part, seconds

        line = self%label
        if (self%all == 0 .and. self%all_parts == 0) return
        line = ''
        if (self%all_parts > 0) line = integer_text(self%part)//'/'//integer_text(self%all_parts)//' '// &
                                       trim(self%parts)//','
        if (self%all > 0) line = trim(line)//' '//integer_text(self%done)//'/'//integer_text(self%all)//' '// &
                                 trim(self%pieces)//','
        part = whole_done(self)
        line = trim(adjustl(line))//' '//integer_text(int(100*part))//' %'
        call system_clock(now, rate)
        seconds = real(now - self%started, dp)/max(1_i8, rate)
        if (part > self%before .and. seconds > FIRST_FORECAST) &
            line = trim(line)//', '//trim(duration_text(seconds*(1 - part)/(part - self%before)))//' left'
        if (self%label /= '') line = trim(line)//': '//self%label
    end function progress_line

    !> A duration as one says it: "40 s", "12 min", "3.5 h".
    pure function duration_text(seconds) result(text)
        real(dp), intent(in) :: seconds
        character(16) :: text

        if (seconds < 100) then
            text = integer_text(nint(seconds))//' s'
        else if (seconds < 5940) then
            text = integer_text(nint(seconds/60))//' min'
        else
            write (text, '(i0, a, i1, a)') int(seconds/3600), '.', mod(int(seconds/360), 10), ' h'
        end if
    end function duration_text
end module gracecg_base_progress
