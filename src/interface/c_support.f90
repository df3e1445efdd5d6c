!> What the procedures of the C interface have in common: status, messages, texts, checks.
!>
!> The constants and types are those of include/gracecg.h. A check does nothing after an earlier one
!> has failed, so that checks can stand one after another.
module gracecg_interface_c_support
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int32_t, c_intptr_t, c_null_char, &
        c_size_t
    use gracecg, only: dp, error_t, utc_t, utc_plus, check_utc_in_range
    use gracecg_base_error, only: number_text
    use gracecg_base_text, only: integer_text, string_t
    use gracecg_base_kinds, only: i8
    use gracecg_interface_handles, only: object_t, no_object_t, store, acquire, release, remove, MAX_OBJECTS
    implicit none
    private
    public :: STATUS_OK, STATUS_NULL_POINTER, STATUS_BAD_HANDLE, STATUS_BAD_SIZE, STATUS_BAD_VALUE
    public :: STATUS_FAILED, STATUS_NOT_CONVERGED, STATUS_NO_MEMORY
    public :: MESSAGE_SIZE, LONGEST_NAME, LONGEST_TEXT, c_error_t, c_utc_t
    public :: start, raise, pass_on, need, check_count, check_finite, check_result, check_distance, check_threads
    public :: fortran_text, give_text, give_lines, give_warnings, time_of, later_time
    public :: keep, keep_copy, refuse_handle, free_object

    integer(c_int), parameter :: STATUS_OK = 0              !! All went well
    integer(c_int), parameter :: STATUS_NULL_POINTER = 1    !! A needed argument is NULL
    integer(c_int), parameter :: STATUS_BAD_HANDLE = 2      !! Never made, freed, or of another kind
    integer(c_int), parameter :: STATUS_BAD_SIZE = 3        !! A count or an array is too small or too great
    integer(c_int), parameter :: STATUS_BAD_VALUE = 4       !! A number is not finite or out of its range
    integer(c_int), parameter :: STATUS_FAILED = 5          !! The work failed
    integer(c_int), parameter :: STATUS_NOT_CONVERGED = 6   !! An estimate did not converge
    integer(c_int), parameter :: STATUS_NO_MEMORY = 7       !! Memory ran out

    integer, parameter :: MESSAGE_SIZE = 1020       !! Bytes of a message with its closing zero
    integer, parameter :: LONGEST_NAME = 4095       !! Bytes of a name or path
    integer, parameter :: LONGEST_TEXT = 2**20      !! Bytes of a text of settings
    integer, parameter :: MOST_THREADS = 1024
    real(dp), parameter :: NEAREST = 1e3_dp         !! Of a position to the Earth's centre, m

    !> gracecg_error
    type, bind(c) :: c_error_t
        integer(c_int32_t) :: status                    !! A gracecg_status
        character(kind=c_char) :: message(MESSAGE_SIZE) !! Ends with a zero
    end type c_error_t

    !> gracecg_utc
    type, bind(c) :: c_utc_t
        integer(c_int32_t) :: mjd       !! Modified Julian day number, UTC
        real(c_double) :: seconds       !! s
    end type c_utc_t

contains

    !> Begins a function: nothing has gone wrong yet.
    subroutine start(status, error)
        integer(c_int), intent(out) :: status   !! STATUS_OK
        type(c_error_t), intent(inout), optional :: error

        status = STATUS_OK
        if (.not. present(error)) return
        error%status = STATUS_OK
        error%message(1) = c_null_char
    end subroutine start

    !> Sets status and message.
    subroutine raise(code, message, status, error)
        integer(c_int), intent(in) :: code      !! The new status
        character(*), intent(in) :: message     !! Complete sentences
        integer(c_int), intent(out) :: status   !! The new status
        type(c_error_t), intent(inout), optional :: error

        character(*), parameter :: CUT = '...'
        integer :: i, n

        status = code
        if (.not. present(error)) return
        error%status = code
        n = min(len(message), MESSAGE_SIZE - 1)
        do i = 1, n
            error%message(i) = message(i:i)
        end do
        if (n < len(message)) then
            do i = 1, len(CUT)
                error%message(n - len(CUT) + i) = CUT(i:i)
            end do
        end if
        error%message(n + 1) = c_null_char
    end subroutine raise

    !> Passes a failure of the library on, if there is one.
    subroutine pass_on(failure, status, error, code)
        type(error_t), allocatable, intent(in) :: failure
        integer(c_int), intent(inout) :: status
        !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error
        integer(c_int), intent(in), optional :: code        !! STATUS_FAILED when absent

        integer(c_int) :: kind_of_failure

        if (status /= STATUS_OK .or. .not. allocated(failure)) return
        kind_of_failure = STATUS_FAILED
        if (present(code)) kind_of_failure = code
        call raise(kind_of_failure, failure%message, status, error)
    end subroutine pass_on

    !> An argument that must be there.
    subroutine need(given, name, status, error)
        logical, intent(in) :: given            !! It is not NULL
        character(*), intent(in) :: name        !! Of the argument, for the message
        integer(c_int), intent(inout) :: status !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        if (status /= STATUS_OK .or. given) return
        call raise(STATUS_NULL_POINTER, 'the argument '//name//' is NULL', status, error)
    end subroutine need

    !> A number of elements.
    subroutine check_count(n, name, status, error, highest)
        integer(c_size_t), intent(in) :: n              !! The count
        character(*), intent(in) :: name                !! Of the argument, for the message
        integer(c_int), intent(inout) :: status         !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error
        integer, intent(in), optional :: highest        !! That is allowed; 2^31 - 1 when absent

        integer :: most

        if (status /= STATUS_OK) return
        most = huge(0)
        if (present(highest)) most = highest
        if (n >= 0 .and. n <= most) return
        if (n < 0) then     ! 2^63 and more
            call raise(STATUS_BAD_SIZE, name//' is too great: at most '//integer_text(most)//' is allowed', &
                       status, error)
        else
            call raise(STATUS_BAD_SIZE, name//' = '//integer_text(int(n, i8))//' is too great: at most '// &
                       integer_text(most)//' is allowed', status, error)
        end if
    end subroutine check_count

    !> Numbers that come in.
    subroutine check_finite(values, n, name, status, error)
        real(dp), intent(in) :: values(*)       !! In any unit
        integer(c_size_t), intent(in) :: n      !! Their number
        character(*), intent(in) :: name        !! Of the argument, for the message
        integer(c_int), intent(inout) :: status !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        integer(c_size_t) :: i

        if (status /= STATUS_OK) return
        do i = 1, n
            if (abs(values(i)) <= huge(1.0_dp)) cycle
            call raise(STATUS_BAD_VALUE, 'number '//integer_text(int(i, i8))//' of '//name// &
                       ' is NaN or infinite', status, error)
            return
        end do
    end subroutine check_finite

    !> Numbers that go out.
    subroutine check_result(values, name, status, error)
        real(dp), intent(in) :: values(:)       !! In any unit
        character(*), intent(in) :: name        !! Of the result, for the message
        integer(c_int), intent(inout) :: status !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        if (status /= STATUS_OK) return
        if (all(abs(values) <= huge(1.0_dp))) return
        call raise(STATUS_BAD_VALUE, name//' would be NaN or infinite: the arguments are far outside what '// &
                   'the model is for', status, error)
    end subroutine check_result

    !> Positions: finite, and not at the Earth's centre.
    subroutine check_distance(position, n, status, error)
        real(dp), intent(in) :: position(3, *)  !! From the Earth's centre, m
        integer(c_size_t), intent(in) :: n      !! Their number
        integer(c_int), intent(inout) :: status !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        integer(c_size_t) :: i

        call check_finite(position, 3*n, 'position', status, error)
        if (status /= STATUS_OK) return
        do i = 1, n
            if (maxval(abs(position(:, i))) >= NEAREST) cycle
            call raise(STATUS_BAD_VALUE, 'position '//integer_text(int(i, i8))//' is less than 1 km from '// &
                       'the centre of the Earth; positions have to be in metres', status, error)
            return
        end do
    end subroutine check_distance

    !> A text of the caller's. Fails when it is NULL or has no end within the longest length.
    subroutine fortran_text(c_text, longest, name, text, status, error)
        character(kind=c_char), intent(in), optional :: c_text(*)   !! Ends with a zero
        integer, intent(in) :: longest
        !! Greatest number of bytes before the zero
        character(*), intent(in) :: name                            !! Of the argument, for the message
        character(:), allocatable, intent(out) :: text              !! Without the zero
        integer(c_int), intent(inout) :: status
        !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        integer :: i, n

        text = ''
        call need(present(c_text), name, status, error)
        if (status /= STATUS_OK) return
        n = 0
        do
            if (c_text(n + 1) == c_null_char) exit
            n = n + 1
            if (n <= longest) cycle
            call raise(STATUS_BAD_VALUE, name//' is longer than '//integer_text(longest)//' bytes', &
                       status, error)
            return
        end do
        deallocate (text)
        allocate (character(n) :: text)
        do i = 1, n
            text(i:i) = c_text(i)
        end do
    end subroutine fortran_text

    !> Gives a text to the caller's buffer of `size` bytes.
    subroutine give_text(text, buffer, size, length, status, error)
        character(*), intent(in) :: text                        !! Any
        character(kind=c_char), intent(inout), optional :: buffer(*)    !! Receives it with a zero behind it
        integer(c_size_t), intent(in) :: size                   !! Of the buffer, bytes
        integer(c_size_t), intent(inout), optional :: length    !! Receives the text's
        integer(c_int), intent(inout) :: status
        !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        integer :: i

        if (status /= STATUS_OK) return
        if (present(length)) length = len(text, c_size_t)
        if (size == 0) then
            call need(present(buffer) .or. present(length), 'text', status, error)
            if (present(buffer) .and. status == STATUS_OK) &
                call raise(STATUS_BAD_SIZE, 'the size of the text is 0', status, error)
            return
        end if
        call need(present(buffer), 'text', status, error)
        if (status /= STATUS_OK) return
        buffer(1) = c_null_char
        if (size > 0 .and. size <= len(text)) then
            call raise(STATUS_BAD_SIZE, 'the text needs '//integer_text(len(text) + 1)//' bytes; there are '// &
                       integer_text(int(size, i8)), status, error)
            return
        end if
        do i = 1, len(text)
            buffer(i) = text(i:i)
        end do
        buffer(len(text) + 1) = c_null_char
    end subroutine give_text

    !> A time of the caller's.
    subroutine time_of(c_utc, name, utc, status, error)
        type(c_utc_t), intent(in), optional :: c_utc
        character(*), intent(in) :: name        !! Of the argument, for the message
        type(utc_t), intent(out) :: utc
        integer(c_int), intent(inout) :: status !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        type(error_t), allocatable :: failure

        call need(present(c_utc), name, status, error)
        if (status /= STATUS_OK) return
        utc = utc_t(c_utc%mjd, c_utc%seconds)
        call check_utc_in_range(utc, failure)
        call pass_on(failure, status, error, STATUS_BAD_VALUE)
    end subroutine time_of

    !> The time `seconds` after an epoch.
    subroutine later_time(epoch, seconds, utc, status, error)
        type(utc_t), intent(in) :: epoch
        real(dp), intent(in) :: seconds         !! s; may be negative
        type(utc_t), intent(out) :: utc
        integer(c_int), intent(inout) :: status !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        type(error_t), allocatable :: failure

        if (status /= STATUS_OK) return
        if (.not. abs(seconds) <= huge(1.0_dp)) then
            call raise(STATUS_BAD_VALUE, 'seconds is NaN or infinite', status, error)
            return
        end if
        utc = utc_plus(epoch, seconds)
        call check_utc_in_range(utc, failure)
        call pass_on(failure, status, error, STATUS_BAD_VALUE)
    end subroutine later_time

    !> Stores a new object and gives its handle out; without room the object is deallocated.
    subroutine keep(object, handle, status, error)
        class(object_t), pointer, intent(inout) :: object
        integer(c_intptr_t), intent(out) :: handle  !! Of the object; 0 without room
        integer(c_int), intent(inout) :: status     !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        integer :: number

        handle = 0
        if (.not. associated(object)) then
            if (status == STATUS_OK) call raise(STATUS_NO_MEMORY, 'no memory for a new object', status, error)
            return
        end if
        number = 0
        if (status == STATUS_OK) then
            call store(object, number)
            if (number == 0) call raise(STATUS_NO_MEMORY, 'there are '//integer_text(MAX_OBJECTS)// &
                                        ' objects already; free those that are not needed', status, error)
        end if
        if (number == 0) deallocate (object)
        handle = number
    end subroutine keep

    !> Stores a copy of an object that is not large, and gives its handle out; nothing after a failure.
    subroutine keep_copy(object, handle, status, error)
        class(object_t), intent(in) :: object
        integer(c_intptr_t), intent(inout) :: handle    !! Of the copy; 0 without room
        integer(c_int), intent(inout) :: status         !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        class(object_t), pointer :: copy
        integer :: memory

        if (status /= STATUS_OK) return
        allocate (copy, source=object, stat=memory)
        if (memory /= 0) copy => null()
        call keep(copy, handle, status, error)
    end subroutine keep_copy

    !> The handle is not what it should be.
    subroutine refuse_handle(name, status, error)
        character(*), intent(in) :: name        !! Of the object that is wanted
        integer(c_int), intent(inout) :: status !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        if (status /= STATUS_OK) return
        call raise(STATUS_BAD_HANDLE, 'the handle is not that of a '//name//': it was never made, was freed, '// &
                   'or is of another kind', status, error)
    end subroutine refuse_handle

    !> Frees an object if it is of the type of `mold`, or of any type without one.
    subroutine free_object(handle, name, status, error, mold)
        integer(c_intptr_t), intent(inout), optional :: handle      !! 0 out
        character(*), intent(in) :: name                            !! Of the kind of object, for the message
        integer(c_int), intent(out) :: status                       !! What became of it
        type(c_error_t), intent(inout), optional :: error
        class(object_t), intent(in), optional :: mold

        class(object_t), pointer :: object
        logical :: right

        call start(status, error)
        call need(present(handle), 'handle', status, error)
        if (status /= STATUS_OK) return
        if (handle == 0) return
        call acquire(int(handle, i8), object)
        if (present(mold)) then
            right = same_type_as(object, mold)
        else
            select type (object)
            type is (no_object_t)
                right = .false.
            class default
                right = .true.
            end select
        end if
        call release(int(handle, i8), object)
        if (right) right = remove(int(handle, i8))
        if (.not. right) call refuse_handle(name, status, error)
        if (right) handle = 0
    end subroutine free_object
    !> The warnings as lines, cut off where the buffer ends.
    subroutine give_warnings(warnings, buffer, size_of_buffer)
        type(string_t), allocatable, intent(in) :: warnings(:)
        character(kind=c_char), intent(inout), optional :: buffer(*)    !! Of characters, ended by a null
        integer(c_size_t), intent(in) :: size_of_buffer    !! Bytes of it

        character(:), allocatable :: text
        integer :: i

        if (size_of_buffer == 0) return
        text = ''
        if (allocated(warnings)) then
            do i = 1, size(warnings)
                text = text//warnings(i)%text//new_line('a')
            end do
        end if
        call give_lines(text, buffer, size_of_buffer)
    end subroutine give_warnings

    !> A text, cut off where the buffer ends.
    subroutine give_lines(text, buffer, size_of_buffer)
        character(*), intent(in) :: text    !! Lines, each ended by a newline
        character(kind=c_char), intent(inout), optional :: buffer(*)    !! Of characters, ended by a null
        integer(c_size_t), intent(in) :: size_of_buffer    !! Bytes of it

        integer :: i

        if (size_of_buffer == 0) return
        do i = 1, min(len(text), int(size_of_buffer) - 1)
            buffer(i) = text(i:i)
        end do
        buffer(min(len(text), int(size_of_buffer) - 1) + 1) = c_null_char
    end subroutine give_lines

    !> A number of threads in its range.
    subroutine check_threads(threads, status, error)
        integer(c_int32_t), intent(in) :: threads   !! As asked for
        integer(c_int), intent(inout) :: status !! Of the call so far: nothing is done after a failure
        type(c_error_t), intent(inout), optional :: error

        if (status /= STATUS_OK) return
        if (threads >= 1 .and. threads <= MOST_THREADS) return
        call raise(STATUS_BAD_VALUE, 'threads = '//integer_text(int(threads))//' has to be from 1 to '// &
                   integer_text(MOST_THREADS), status, error)
    end subroutine check_threads
end module gracecg_interface_c_support
