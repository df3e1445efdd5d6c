!> What becomes of a call of the C interface: a status, and a message if it is not that of success.
!>
!> The work and the checks of a call share one outcome. A check does nothing after an earlier one has failed, so that
!> checks can stand one after another.
module gracecg_interface_outcome
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int32_t, c_null_char
    use gracecg_base_error, only: error_t
    implicit none
    private
    public :: STATUS_OK, STATUS_NULL_POINTER, STATUS_BAD_HANDLE, STATUS_BAD_SIZE, STATUS_BAD_VALUE
    public :: STATUS_FAILED, STATUS_NOT_CONVERGED, STATUS_NO_MEMORY, STATUS_NOT_USABLE
    public :: outcome_t, c_error_t, MESSAGE_SIZE, reported, leaves_object

    integer(c_int), parameter :: STATUS_OK = 0              !! All went well
    integer(c_int), parameter :: STATUS_NULL_POINTER = 1    !! A needed argument is NULL
    integer(c_int), parameter :: STATUS_BAD_HANDLE = 2      !! Never made, freed, or of another kind
    integer(c_int), parameter :: STATUS_BAD_SIZE = 3        !! A count or an array is too small or too great
    integer(c_int), parameter :: STATUS_BAD_VALUE = 4       !! A number is not finite or out of its range
    integer(c_int), parameter :: STATUS_FAILED = 5          !! The work failed
    integer(c_int), parameter :: STATUS_NOT_CONVERGED = 6   !! An estimate did not converge
    integer(c_int), parameter :: STATUS_NO_MEMORY = 7       !! Memory ran out
    integer(c_int), parameter :: STATUS_NOT_USABLE = 8      !! An estimate was made that is not to be used

    integer, parameter :: MESSAGE_SIZE = 1020       !! Bytes of a message with its closing zero

    !> gracecg_error
    type, bind(c) :: c_error_t
        integer(c_int32_t) :: status                    !! A gracecg_status
        character(kind=c_char) :: message(MESSAGE_SIZE) !! Ends with a zero
    end type c_error_t

    !> Status and message of a call.
    type :: outcome_t
        integer(c_int) :: status = STATUS_OK            !! A gracecg_status
        character(:), allocatable :: message            !! Complete sentences; not allocated after success
    contains
        procedure :: good                               !! All went well so far
        procedure :: refuse                             !! Sets status and message, unless an earlier failure has
        procedure :: take                               !! Takes a failure of the library, if there is one
    end type outcome_t

contains

    pure logical function good(self)
        class(outcome_t), intent(in) :: self

        good = self%status == STATUS_OK
    end function good

    !> With this status an object is made, and can be asked.
    pure logical function leaves_object(status)
        integer(c_int), intent(in) :: status    !! A gracecg_status

        leaves_object = any(status == [STATUS_OK, STATUS_NOT_CONVERGED, STATUS_NOT_USABLE])
    end function leaves_object

    pure subroutine refuse(self, status, message)
        class(outcome_t), intent(inout) :: self
        integer(c_int), intent(in) :: status    !! The new status
        character(*), intent(in) :: message     !! Complete sentences

        if (.not. self%good()) return
        self%status = status
        self%message = message
    end subroutine refuse

    pure subroutine take(self, error, status)
        class(outcome_t), intent(inout) :: self
        type(error_t), allocatable, intent(in) :: error
        integer(c_int), intent(in), optional :: status      !! STATUS_FAILED when absent

        if (.not. allocated(error)) return
        if (present(status)) then
            call self%refuse(status, error%message)
        else
            call self%refuse(STATUS_FAILED, error%message)
        end if
    end subroutine take

    !> Fills the caller's error; gives the status.
    integer(c_int) function reported(outcome, error) result(status)
        type(outcome_t), intent(in) :: outcome
        type(c_error_t), intent(inout), optional :: error

        status = outcome%status
        if (.not. present(error)) return
        error%status = status
        if (allocated(outcome%message)) then
            call put_message(outcome%message, error)
        else
            call put_message('', error)
        end if
    end function reported

    !> Puts a text into the message of an error; cut off, it ends with three dots.
    pure subroutine put_message(text, error)
        character(*), intent(in) :: text            !! Any
        type(c_error_t), intent(inout) :: error

        character(*), parameter :: CUT = '...'
        integer :: i, n

        n = min(len(text), MESSAGE_SIZE - 1)
        do i = 1, n
            error%message(i) = text(i:i)
        end do
        if (n < len(text)) then
            do i = 1, len(CUT)
                error%message(n - len(CUT) + i) = CUT(i:i)
            end do
        end if
        error%message(n + 1) = c_null_char
    end subroutine put_message
end module gracecg_interface_outcome
