!> Checks whose first failure stays, files that tests make below build/test-output, and checks of the messages of
!> failures.
!>
!> A test that goes on after a failed check tells of that one at its end; only what cannot go on has to return. A failure
!> of what is tested comes as the text of its message, empty when there is none, so that this module needs nothing of
!> what is tested.
module fixture
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char
    use, intrinsic :: iso_fortran_env, only: real64, int64
    use testdrive, only: error_type, check_now => check, fail_now => test_failed
    implicit none
    private
    public :: check, unmet, test_failed, FOLDER, make_folder, make_file, read_content, check_content, replaced, check_same_files
    public :: set_variable, has_parts, joined, check_says, check_fails, check_passes, failed

    character(*), parameter :: FOLDER = 'build/test-output/'
    character(*), parameter :: BETWEEN = ' ... '        !! Between the parts of a message

    !> The checks of testdrive; none is made once there is an error.
    interface check
        module procedure check_logical, check_real, check_integer, check_long, check_text
    end interface check

    !> unmet(error, ...): makes the check; is there an error now, or was there before, so that a test cannot go on?
    interface unmet
        module procedure unmet_logical, unmet_integer, unmet_text
    end interface unmet

    interface
        integer(c_int) function c_setenv(name, value, overwrite) bind(c, name='setenv')
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: name(*), value(*)
            integer(c_int), value :: overwrite
        end function c_setenv
    end interface

contains

    subroutine check_logical(error, expression, message, more)
        type(error_type), allocatable, intent(inout) :: error
        logical, intent(in) :: expression
        character(*), intent(in), optional :: message, more

        if (.not. allocated(error)) call check_now(error, expression, message, more)
    end subroutine check_logical

    subroutine check_real(error, actual, expected, message, more, thr, rel)
        type(error_type), allocatable, intent(inout) :: error
        real(real64), intent(in) :: actual, expected
        character(*), intent(in), optional :: message, more
        real(real64), intent(in), optional :: thr   !! Largest difference allowed
        logical, intent(in), optional :: rel        !! `thr` is relative to `expected`

        if (.not. allocated(error)) call check_now(error, actual, expected, message, more, thr, rel)
    end subroutine check_real

    subroutine check_integer(error, actual, expected, message, more)
        type(error_type), allocatable, intent(inout) :: error
        integer, intent(in) :: actual, expected
        character(*), intent(in), optional :: message, more

        if (.not. allocated(error)) call check_now(error, actual, expected, message, more)
    end subroutine check_integer

    subroutine check_long(error, actual, expected, message, more)
        type(error_type), allocatable, intent(inout) :: error
        integer(int64), intent(in) :: actual, expected
        character(*), intent(in), optional :: message, more

        if (.not. allocated(error)) call check_now(error, actual, expected, message, more)
    end subroutine check_long

    subroutine check_text(error, actual, expected, message, more)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: actual, expected
        character(*), intent(in), optional :: message, more

        if (.not. allocated(error)) call check_now(error, actual, expected, message, more)
    end subroutine check_text

    logical function unmet_logical(error, expression, message)
        type(error_type), allocatable, intent(inout) :: error
        logical, intent(in) :: expression
        character(*), intent(in), optional :: message

        call check(error, expression, message)
        unmet_logical = allocated(error)
    end function unmet_logical

    logical function unmet_integer(error, actual, expected, message)
        type(error_type), allocatable, intent(inout) :: error
        integer, intent(in) :: actual, expected
        character(*), intent(in), optional :: message

        call check(error, actual, expected, message)
        unmet_integer = allocated(error)
    end function unmet_integer

    logical function unmet_text(error, actual, expected, message)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: actual, expected
        character(*), intent(in), optional :: message

        call check(error, actual, expected, message)
        unmet_text = allocated(error)
    end function unmet_text

    !> Fails, unless something failed before.
    subroutine test_failed(error, message)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: message

        if (.not. allocated(error)) call fail_now(error, message)
    end subroutine test_failed

    !> Gives a variable of the environment a value.
    subroutine set_variable(name, value)
        character(*), intent(in) :: name, value

        if (c_setenv(name//c_null_char, value//c_null_char, 1_c_int) /= 0) error stop 'a variable could not be set'
    end subroutine set_variable

    !> Makes FOLDER; without it no test can be made.
    subroutine make_folder()
        integer :: status
        logical :: made

        inquire (file=FOLDER//'.', exist=made)
        if (made) return
        call execute_command_line('mkdir -p '//FOLDER, exitstat=status)
        if (status /= 0) error stop 'the folder build/test-output could not be made'
    end subroutine make_folder

    !> Writes a file below FOLDER with exactly the given content.
    subroutine make_file(name, content)
        character(*), intent(in) :: name, content
        integer :: unit

        call make_folder()
        open (newunit=unit, file=FOLDER//name, access='stream', form='unformatted', &
              status='replace')
        write (unit) content
        close (unit)
    end subroutine make_file

    !> Reads a file that has to be there.
    subroutine read_content(error, path, content)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: path
        character(:), allocatable, intent(out) :: content   !! Empty after a failure
        integer :: unit, length, status

        content = ''
        open (newunit=unit, file=path, access='stream', form='unformatted', status='old', action='read', iostat=status)
        call check(error, status, 0, path//' cannot be read')
        if (status /= 0) return
        inquire (unit, size=length)
        content = repeat(' ', length)
        read (unit) content
        close (unit)
    end subroutine read_content

    !> A file below FOLDER must have exactly this content.
    subroutine check_content(error, name, expected)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name, expected
        character(:), allocatable :: content

        call read_content(error, FOLDER//name, content)
        call check(error, content, expected)
    end subroutine check_content

    !> A text with the first `old`, or every one, in another form; a text that has none becomes a complaint, which nothing reads.
    pure function replaced(text, old, new, every) result(changed)
        character(*), intent(in) :: text, old, new
        logical, intent(in), optional :: every
        character(:), allocatable :: changed
        integer :: at, step

        at = index(text, old)
        if (at == 0) then
            changed = 'the text has no '//old
            return
        end if
        changed = text(:at - 1)//new//text(at + len(old):)
        if (.not. present(every)) return
        do
            at = at + len(new)
            step = index(changed(at:), old) - 1
            if (step < 0) return
            at = at + step
            changed = changed(:at - 1)//new//changed(at + len(old):)
        end do
    end function replaced

    !> Two files below FOLDER must have the same content, but for the lines at the top that tell what command made a namelist.
    subroutine check_same_files(error, first, second)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: first, second
        character(:), allocatable :: one, other

        call read_content(error, FOLDER//first, one)
        call read_content(error, FOLDER//second, other)
        call check(error, behind_head(one) == behind_head(other), first//' differs from '//second)

    contains

        function behind_head(content) result(rest)
            character(*), intent(in) :: content
            character(:), allocatable :: rest

            rest = content
            do while (index(rest, '! gracecg ') == 1 .or. index(rest, '! inputs: ') == 1)
                rest = rest(index(rest, achar(10)) + 1:)
            end do
        end function behind_head
    end subroutine check_same_files

    !> Has a text every one of the parts, between which stands ' ... '? In whatever order.
    pure logical function has_parts(text, parts)
        character(*), intent(in) :: text, parts

        has_parts = lacks(text, trim(parts)) == 0
    end function has_parts

    !> Where the first of the parts begins that a text has not; 0: it has all.
    pure integer function lacks(text, parts)
        character(*), intent(in) :: text, parts
        integer :: length

        lacks = 1
        do while (lacks <= len(parts))
            length = index(parts(lacks:)//BETWEEN, BETWEEN) - 1
            if (index(text, parts(lacks:min(lacks + length - 1, len(parts)))) == 0) return
            lacks = lacks + length + len(BETWEEN)
        end do
        lacks = 0
    end function lacks

    !> The parts of a table's column as one text.
    pure function joined(parts) result(text)
        character(*), intent(in) :: parts(:)
        character(:), allocatable :: text
        integer :: i

        text = trim(parts(1))
        do i = 2, size(parts)
            text = text//BETWEEN//trim(parts(i))
        end do
    end function joined

    !> A text must have every one of the parts.
    subroutine check_says(error, text, parts)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: text, parts
        integer :: missing

        missing = lacks(text, parts)
        call check(error, missing == 0, '"'//parts(max(missing, 1):)//'" is not in: '//text)
    end subroutine check_says

    !> There must be a failure, and its message must have every one of the parts.
    subroutine check_fails(error, message, parts)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: message     !! Of the failure; empty: there was none
        character(*), intent(in) :: parts

        call check(error, message /= '', 'no failure where one must be: '//parts)
        call check_says(error, message, trim(parts))
    end subroutine check_fails

    !> There must be no failure.
    subroutine check_passes(error, message)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: message     !! Of the failure; empty: there was none

        if (message /= '') call test_failed(error, message)
    end subroutine check_passes

    !> There must be no failure; is there one now, or was there before, so that a test cannot go on?
    logical function failed(error, message)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: message     !! Of the failure; empty: there was none

        call check_passes(error, message)
        failed = allocated(error)
    end function failed
end module fixture
