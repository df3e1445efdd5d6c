!> Files that tests make below build/test-output, and checks of the messages of failures.
!>
!> A failure comes as the text of its message, empty when there is none, so that this module needs
!> nothing of what is tested.
module fixture
    use testdrive, only: error_type, check, test_failed
    implicit none
    private
    public :: FOLDER, make_folder, make_file, check_fails, check_passes

    character(*), parameter :: FOLDER = 'build/test-output/'

contains

    !> Makes FOLDER.
    subroutine make_folder(error)
        type(error_type), allocatable, intent(out) :: error
        integer :: status
        logical :: made

        inquire (file=FOLDER//'.', exist=made)
        if (made) return
        call execute_command_line('mkdir -p '//FOLDER, exitstat=status)
        call check(error, status, 0, 'the folder '//FOLDER//' could not be made')
    end subroutine make_folder

    !> Writes a file below FOLDER with exactly the given content.
    subroutine make_file(error, name, content)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: name, content
        integer :: unit

        call make_folder(error)
        if (allocated(error)) return
        open (newunit=unit, file=FOLDER//name, access='stream', form='unformatted', &
              status='replace')
        write (unit) content
        close (unit)
    end subroutine make_file

    !> There must be a failure, and its message must have every one of the parts.
    subroutine check_fails(error, message, parts)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: message     !! Of the failure; empty: there was none
        character(*), intent(in) :: parts(:)
        integer :: i

        call check(error, message /= '', 'no failure where one must be: '//trim(parts(1)))
        do i = 1, size(parts)
            if (allocated(error)) return
            call check(error, index(message, trim(parts(i))) > 0, &
                       '"'//trim(parts(i))//'" is not in the message: '//message)
        end do
    end subroutine check_fails

    !> There must be no failure.
    subroutine check_passes(error, message)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: message     !! Of the failure; empty: there was none

        if (message /= '') call test_failed(error, message)
    end subroutine check_passes
end module fixture
