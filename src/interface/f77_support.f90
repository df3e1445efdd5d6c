!> What the Fortran 77 entry points (f77.f90) have in common: they call the C interface.
module gracecg_interface_f77_support
    use, intrinsic :: iso_c_binding, only: c_intptr_t, c_int, c_null_char
    use gracecg_interface_c_support, only: c_error_t, c_utc_t, MESSAGE_SIZE, free_object
    implicit none
    private
    public :: c_text, c_handle, finish, finish_handle, free_any

contains

    !> A name as C wants it: without blanks at the end, closed by a zero.
    pure function c_text(name) result(text)
        character(*), intent(in) :: name    !! Blanks at the end do not count
        character(len_trim(name) + 1) :: text

        text = trim(name)//c_null_char
    end function c_text

    !> A handle as C knows it.
    pure integer(c_intptr_t) function c_handle(handle)
        integer, intent(in) :: handle   !! 0 when there is none

        c_handle = handle
    end function c_handle

    !> Status and message of a call; the message is filled up with blanks, or cut off.
    subroutine finish(status, error, istat, msg)
        integer(c_int), intent(in) :: status    !! A gracecg_status
        type(c_error_t), intent(in) :: error
        integer, intent(out) :: istat
        character(*), intent(inout) :: msg

        integer :: i

        istat = status
        msg = ' '
        do i = 1, min(len(msg), MESSAGE_SIZE)
            if (error%message(i) == c_null_char) exit
            msg(i:i) = error%message(i)
        end do
    end subroutine finish

    !> The same of a call that made an object.
    subroutine finish_handle(status, error, handle, ih, istat, msg)
        integer(c_int), intent(in) :: status        !! A gracecg_status
        type(c_error_t), intent(in) :: error
        integer(c_intptr_t), intent(in) :: handle   !! As C knows it
        integer, intent(out) :: ih                  !! As Fortran 77 knows it
        integer, intent(out) :: istat
        character(*), intent(inout) :: msg

        ih = int(handle)
        call finish(status, error, istat, msg)
    end subroutine finish_handle

    !> Frees an object of any kind.
    subroutine free_any(ih, status, error)
        integer, intent(inout) :: ih            !! 0 out
        integer(c_int), intent(out) :: status   !! A gracecg_status
        type(c_error_t), intent(inout) :: error

        integer(c_intptr_t) :: handle

        handle = ih
        call free_object(handle, 'gracecg object', status, error)
        ih = int(handle)
    end subroutine free_any
end module gracecg_interface_f77_support
