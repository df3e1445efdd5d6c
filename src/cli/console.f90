!> What the commands say: results on standard output, messages and progress on standard error. The
!> only place of the program that prints.
module gracecg_cli_console
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_null_ptr, c_ptr
    use, intrinsic :: iso_fortran_env, only: error_unit
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_progress, only: progress_t
    use gracecg_base_text, only: string_t, join, padded, real_text, split
    use gracecg_cli_interruption, only: caught_signal
    implicit none
    private
    public :: console_t, number_fields

    type, extends(progress_t) :: console_t
        !! Where the texts of a command go: the standard units, or, captured, into two texts
        logical :: captured = .false.           !! Set it before use: nothing is printed
        character(:), allocatable :: output     !! Captured lines of standard output
        character(:), allocatable :: messages   !! Captured lines of standard error
        logical, private :: failed = .false.    !! A write on standard output failed
        integer, private :: progress_length = 0 !! Of the progress line that is shown
    contains
        procedure :: line                       !! Writes a line on standard output
        generic :: row => number_row, field_row !! Writes a row of CSV: numbers, or texts
        procedure :: message                    !! Writes a line on standard error
        procedure :: progress                   !! Shows how far a long work is
        procedure :: stops => is_interrupted    !! Shall a long work stop?
        procedure :: finish                     !! Ends the output; fails when some was lost
        procedure, private :: number_row
        procedure, private :: field_row
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
    character(9), parameter :: NOT_FINITE(3) = [character(9) :: 'NaN', 'Infinity', '-Infinity']
    character(1), parameter :: LF = achar(10), CR = achar(13)

contains

    !> Writes a line (or several) on standard output.
    subroutine line(self, text)
        class(console_t), intent(inout) :: self
        character(*), intent(in) :: text        !! Without the end of the line

        if (self%captured) then
            call append_line(self%output, text)
            return
        end if
        call self%clear_progress()
        if (c_puts(text//c_null_char) < 0) self%failed = .true.
    end subroutine line

    !> Writes header and row of a CSV table on standard output, with numbers that read back exactly.
    !> Fails, and writes nothing, when a number is not finite.
    subroutine number_row(self, header, values, error)
        class(console_t), intent(inout) :: self
        character(*), intent(in) :: header      !! Names of the columns, separated by commas
        real(dp), intent(in) :: values(:)
        type(error_t), allocatable, intent(out) :: error

        call self%row(header, number_fields(values), error)
    end subroutine number_row

    !> The same with texts; `number_fields` makes them of numbers.
    subroutine field_row(self, header, fields, error)
        class(console_t), intent(inout) :: self
        character(*), intent(in) :: header
        type(string_t), intent(in) :: fields(:)
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: columns(:)
        integer :: i

        columns = split(header, ',')
        do i = 1, size(fields)
            if (.not. any(NOT_FINITE == fields(i)%text)) cycle
            call fail(error, columns(i)%text//': the result is not a finite number')
            return
        end do
        call self%line(header)
        call self%line(join(padded(fields), ','))
    end subroutine field_row

    !> Numbers as texts that read back exactly.
    function number_fields(values) result(fields)
        real(dp), intent(in) :: values(:)   !! In the order of the row
        type(string_t), allocatable :: fields(:)

        integer :: i

        allocate (fields(size(values)))
        do i = 1, size(values)
            fields(i)%text = real_text(values(i))
        end do
    end function number_fields

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

    !> Shows how far a long work is: one line, written over again and again, and only when standard
    !> error is a terminal.
    subroutine progress(self, text)
        class(console_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Without a line end

        integer :: status, length

        if (self%captured) return
        if (c_isatty(STANDARD_ERROR) == 0) return
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
