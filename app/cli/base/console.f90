!> What the commands say: results on standard output, messages and progress on standard error. The
!> only place of the program that prints.
module gracecg_cli_console
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_null_ptr, c_ptr
    use, intrinsic :: iso_fortran_env, only: error_unit
    use gracecg_base_kinds, only: i8
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_progress, only: progress_t
    use gracecg_base_text, only: string_t, append, parse_integer, split_words
    use gracecg_files_data_table, only: data_table_t
    use gracecg_cli_process, only: caught_signal
    implicit none
    private
    public :: console_t, console_width, wrapped, quoted_word, STATUS_NOT_TO_BE_USED

    integer, parameter :: STATUS_NOT_TO_BE_USED = 3     !! Exit status: done, but the result is not to be used

    type, extends(progress_t) :: console_t
        !! Where the texts of a command go: the standard units, or, captured, into two texts
        logical :: captured = .false.           !! Set it before use: nothing is printed
        character(4) :: format = 'text'         !! text: `line` writes; csv, json: `data` alone does
        logical :: logs_progress = .false.      !! Progress comes in lines now and then where there is no terminal
        integer :: log_interval = 60            !! From one such line to the next, and before the first, s
        type(string_t), allocatable :: warnings(:)  !! What `warn` has said
        character(:), allocatable :: output     !! Captured lines of standard output
        character(:), allocatable :: messages   !! Captured lines of standard error
        integer :: status_done = 0              !! Exit status where nothing fails
        character(16) :: commit = ''            !! Of the sources of the program; blank: not known
        logical, private :: failed = .false.    !! A write on standard output failed
        integer, private :: progress_length = 0 !! Of the progress line that is shown
        integer(i8), private :: logged = 0      !! Reading of the clock at the last line of progress without a terminal
    contains
        procedure :: line                       !! Writes a line for people on standard output
        procedure :: paragraph                  !! Writes words in lines that fit
        procedure :: table                      !! Writes a table for people
        procedure :: data                       !! Writes lines of CSV or JSON on standard output
        procedure :: message                    !! Writes a line on standard error
        procedure :: warn                       !! Writes a warning there
        procedure :: warn_all                   !! Writes several warnings there
        procedure :: progress                   !! Shows how far a long work is
        procedure :: stops => is_interrupted    !! Shall a long work stop?
        procedure :: finish                     !! Ends the output; fails when some was lost
        procedure, private :: clear_progress
    end type console_t

    interface
        integer(c_int) function c_isatty(descriptor) bind(c, name='isatty')
            import :: c_int
            integer(c_int), value :: descriptor
        end function c_isatty

        !> Writes a text and a line end on standard output. In place of Fortran's write because it
        !> tells when the disk is full.
        integer(c_int) function c_puts(text) bind(c, name='puts')
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: text(*)
        end function c_puts

        integer(c_int) function c_fflush(stream) bind(c, name='fflush')
            import :: c_int, c_ptr
            type(c_ptr), value :: stream    !! Null: all of them
        end function c_fflush
    end interface

    integer(c_int), parameter :: STANDARD_ERROR = 2     !! Its descriptor (POSIX)
    integer, parameter :: PROGRESS_WIDTH = 79           !! Of a progress line: longer ones would break
    character(1), parameter :: LF = achar(10), CR = achar(13)

contains

    !> Writes a line (or several) for people on standard output; nothing when CSV or JSON is asked for.
    subroutine line(self, text)
        class(console_t), intent(inout) :: self
        character(*), intent(in) :: text        !! Without the end of the line

        if (self%format == 'text') call self%data(text)
    end subroutine line

    !> Writes words in lines that fit the console.
    subroutine paragraph(self, text)
        class(console_t), intent(inout) :: self
        character(*), intent(in) :: text        !! Words between blanks

        call self%line(wrapped(text, 1, console_width()))
    end subroutine paragraph

    !> Writes a table for people; one that is too wide for the console comes in blocks.
    subroutine table(self, rows)
        class(console_t), intent(inout) :: self
        type(data_table_t), intent(in) :: rows

        type(string_t), allocatable :: text(:)
        integer :: i

        if (self%format /= 'text') return
        call rows%lines(console_width(), text)
        do i = 1, size(text)
            call self%line(trim(text(i)%text))
        end do
    end subroutine table

    !> Writes a line (or several) on standard output, whatever the format.
    subroutine data(self, text)
        class(console_t), intent(inout) :: self
        character(*), intent(in) :: text        !! Without the end of the line

        if (self%captured) then
            call append_line(self%output, text)
            return
        end if
        call self%clear_progress()
        if (c_puts(text//c_null_char) < 0) self%failed = .true.
    end subroutine data

    !> Writes a line on standard error.
    subroutine message(self, text)
        class(console_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Without a line end

        integer :: status

        if (self%captured) then
            call append_line(self%messages, text)
            return
        end if
        call self%clear_progress()
        write (error_unit, '(a)', iostat=status) text
    end subroutine message

    !> Writes a warning on standard error, and keeps it for JSON.
    subroutine warn(self, text)
        class(console_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Without a line end

        if (.not. allocated(self%warnings)) allocate (self%warnings(0))
        call append(self%warnings, text)
        call self%message('warning: '//text)
    end subroutine warn

    !> Writes several warnings, without those that an action has said.
    subroutine warn_all(self, texts, said)
        class(console_t), intent(inout) :: self
        type(string_t), intent(in) :: texts(:)      !! Without line ends
        character(*), intent(in), optional :: said  !! The action

        integer :: i

        do i = 1, size(texts)
            if (present(said)) then
                if (index(said, texts(i)%text) > 0) cycle
            end if
            call self%warn(texts(i)%text)
        end do
    end subroutine warn_all

    !> Characters in a line: the environment's COLUMNS, where it is a width that tables can have; else 100.
    integer function console_width() result(width)
        integer, parameter :: USUAL = 100, NARROWEST = 40
        character(12) :: text
        integer :: status
        logical :: ok

        call get_environment_variable('COLUMNS', text, status=status)
        call parse_integer(text, width, ok)
        if (status /= 0 .or. .not. ok) width = USUAL
        if (width < NARROWEST) width = USUAL
    end function console_width

    !> The words in lines of at most `width` characters that begin at `column`; the first line is taken to
    !> stand there already.
    function wrapped(words, column, width) result(text)
        character(*), intent(in) :: words       !! Between blanks
        integer, intent(in) :: column           !! From 1
        integer, intent(in) :: width            !! In characters
        character(:), allocatable :: text

        type(string_t), allocatable :: pieces(:)
        integer :: i, used

        pieces = split_words(words)
        text = ''
        used = column - 1
        do i = 1, size(pieces)
            if (i > 1 .and. used + 1 + len(pieces(i)%text) > width) then
                text = text//LF//repeat(' ', column - 1)
                used = column - 1
            else if (i > 1) then
                text = text//' '
                used = used + 1
            end if
            text = text//pieces(i)%text
            used = used + len(pieces(i)%text)
        end do
    end function wrapped

    !> A word as it can be pasted into a shell: in single quotes where it holds anything unusual.
    function quoted_word(word) result(text)
        character(*), intent(in) :: word        !! Of a command line
        character(:), allocatable :: text

        character(*), parameter :: PLAIN = 'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./+,:@%='//'-'
        integer :: i

        text = word
        if (verify(word, PLAIN) == 0 .and. word /= '') return
        text = ''''
        do i = 1, len(word)
            if (word(i:i) == '''') then
                text = text//'''\'''''
            else
                text = text//word(i:i)
            end if
        end do
        text = text//''''
    end function quoted_word

    !> Shows how far a long work is: one line, written over again and again, when standard error is a terminal; else a line
    !> a minute, from the first minute on, where `logs_progress` is set.
    subroutine progress(self, text)
        class(console_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Without a line end

        integer(i8) :: now, rate
        integer :: status, length

        if (self%captured .or. c_isatty(STANDARD_ERROR) == 0) then
            if (.not. self%logs_progress) return
            call system_clock(now, rate)
            if (self%logged == 0) self%logged = now
            if (now - self%logged < self%log_interval*rate) return
            self%logged = now
            call self%message(text)
            return
        end if
        length = min(len(text), PROGRESS_WIDTH)
        write (error_unit, '(a)', advance='no', iostat=status) &
            CR//text(:length)//repeat(' ', max(0, self%progress_length - length))
        flush (error_unit, iostat=status)
        self%progress_length = length
    end subroutine progress

    !> True when the command shall stop: after a signal that it catches, and when `stopped` is set.
    logical function is_interrupted(self)
        class(console_t), intent(in) :: self

        is_interrupted = self%stopped .or. caught_signal() /= 0
    end function is_interrupted

    subroutine clear_progress(self)
        class(console_t), intent(inout) :: self

        integer :: status

        if (self%progress_length == 0) return
        write (error_unit, '(a)', advance='no', iostat=status) &
            CR//repeat(' ', self%progress_length)//CR
        self%progress_length = 0
    end subroutine clear_progress

    !> Ends the output. Fails when standard output took less than it was given (a full disk).
    subroutine finish(self, error)
        class(console_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (self%captured) return
        call self%clear_progress()
        if (c_fflush(c_null_ptr) /= 0) self%failed = .true.
        if (self%failed) call fail(error, 'standard output could not be written completely')
    end subroutine finish

    subroutine append_line(text, line)
        character(:), allocatable, intent(inout) :: text
        character(*), intent(in) :: line

        if (.not. allocated(text)) text = ''
        text = text//line//LF
    end subroutine append_line
end module gracecg_cli_console
