!> What the Fortran 77 entry points have in common; they themselves (f77_entries.f90) are generated.
!>
!> `fetch` and its kin take an item of an object by gracecg_get. They do nothing after a failure; an estimate that did not
!> converge is asked nevertheless.
module gracecg_interface_f77_support
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_intptr_t, c_null_char, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_outcome, only: c_error_t, outcome_t, reported, MESSAGE_SIZE, STATUS_OK, leaves_object
    use gracecg_interface_general, only: c_free
    use gracecg_interface_c_functions, only: c_get, c_get_text
    implicit none
    private
    public :: c_text, c_handle, start_call, finish, discard
    public :: fetch, fetch_count, fetch_text, fetch_message

contains

    !> A name as C wants it: without blanks at the end, closed by a zero.
    pure function c_text(name) result(text)
        character(*), intent(in) :: name    !! Blanks at the end do not count
        character(len_trim(name) + 1) :: text

        text = trim(name)//c_null_char
    end function c_text

    !> A handle as C knows it.
    elemental integer(c_intptr_t) function c_handle(handle)
        integer, intent(in) :: handle   !! 0 when there is none

        c_handle = handle
    end function c_handle

    !> Begins an entry that calls no function of C.
    subroutine start_call(status, error)
        integer(c_int), intent(out) :: status   !! STATUS_OK
        type(c_error_t), intent(out) :: error

        type(outcome_t) :: outcome

        status = reported(outcome, error)
    end subroutine start_call

    !> Status and message of a call; the message is filled up with blanks, or cut off.
    subroutine finish(status, error, istat, msg)
        integer(c_int), intent(in) :: status    !! A gracecg_status
        type(c_error_t), intent(in) :: error
        integer, intent(out) :: istat
        character(*), intent(inout) :: msg

        istat = status
        msg = ' '
        call copy_text(error%message, msg)
    end subroutine finish

    !> A text of C's, as far as there is room for it.
    subroutine copy_text(from, to)
        character(kind=c_char), intent(in) :: from(:)   !! Ends with a zero
        character(*), intent(inout) :: to

        integer :: i

        do i = 1, min(len(to), size(from))
            if (from(i) == c_null_char) exit
            to(i:i) = from(i)
        end do
    end subroutine copy_text

    !> Gives an object back that the entry had for itself, and leaves status and message as they are.
    subroutine discard(handle)
        integer(c_intptr_t), intent(inout) :: handle    !! 0 out

        integer(c_int) :: status

        status = c_free(handle)
    end subroutine discard

    !> The numbers of an item, into an array with room for n.
    subroutine fetch(handle, item, n, values, status, error)
        integer(c_intptr_t), intent(in) :: handle       !! Of the object that is asked
        character(*), intent(in) :: item                !! Its name
        integer, intent(in) :: n                        !! Room in the array
        real(dp), intent(inout) :: values(*)            !! In the item's unit
        integer(c_int), intent(inout) :: status         !! A gracecg_status
        type(c_error_t), intent(inout) :: error

        type(c_error_t) :: failure
        integer(c_int) :: fetched

        if (.not. leaves_object(status)) return
        fetched = c_get(handle, c_text(item), int(n, c_size_t), values, error=failure)
        call take_over(fetched, failure, status, error)
    end subroutine fetch

    !> How many columns an item has.
    subroutine fetch_count(handle, item, rows, columns, status, error)
        integer(c_intptr_t), intent(in) :: handle       !! Of the object that is asked
        character(*), intent(in) :: item                !! Its name
        integer, intent(in) :: rows                     !! Numbers of a column
        integer, intent(inout) :: columns               !! How many there are
        integer(c_int), intent(inout) :: status         !! A gracecg_status
        type(c_error_t), intent(inout) :: error

        type(c_error_t) :: failure
        integer(c_int) :: fetched
        integer(c_size_t) :: count

        if (.not. leaves_object(status)) return
        count = 0
        fetched = c_get(handle, c_text(item), 0_c_size_t, count=count, error=failure)
        call take_over(fetched, failure, status, error)
        if (fetched == STATUS_OK) columns = int(count)/rows
    end subroutine fetch_count

    !> A failure of fetching takes the place of what was before it; a success leaves that.
    subroutine take_over(fetched, failure, status, error)
        integer(c_int), intent(in) :: fetched           !! A gracecg_status
        type(c_error_t), intent(in) :: failure          !! Its message
        integer(c_int), intent(inout) :: status         !! A gracecg_status
        type(c_error_t), intent(inout) :: error

        if (fetched == STATUS_OK) return
        status = fetched
        error = failure
    end subroutine take_over

    !> A text that has to fit.
    subroutine fetch_text(handle, item, text, status, error)
        integer(c_intptr_t), intent(in) :: handle       !! Of the object that is asked
        character(*), intent(in) :: item                !! Its name
        character(*), intent(inout) :: text             !! Filled up with blanks
        integer(c_int), intent(inout) :: status         !! A gracecg_status
        type(c_error_t), intent(inout) :: error

        character(kind=c_char) :: found(len(text) + 1)

        status = c_get_text(handle, c_text(item), found, size(found, kind=c_size_t), error=error)
        if (status /= STATUS_OK) return
        text = ' '
        call copy_text(found, text)
    end subroutine fetch_text

    !> A text that goes into the message, cut off where this ends.
    subroutine fetch_message(handle, item, status, error)
        integer(c_intptr_t), intent(in) :: handle       !! Of the object that is asked
        character(*), intent(in) :: item                !! Its name
        integer(c_int), intent(inout) :: status         !! A gracecg_status
        type(c_error_t), intent(inout) :: error

        character(kind=c_char), allocatable :: text(:)
        integer(c_size_t) :: length

        if (status /= STATUS_OK) return
        status = c_get_text(handle, c_text(item), size=0_c_size_t, length=length, error=error)
        if (status /= STATUS_OK) return
        allocate (text(length + 1))
        status = c_get_text(handle, c_text(item), text, length + 1, error=error)
        length = min(length, int(MESSAGE_SIZE - 1, c_size_t))
        error%message(:length) = text(:length)
        error%message(length + 1) = c_null_char
    end subroutine fetch_message
end module gracecg_interface_f77_support
