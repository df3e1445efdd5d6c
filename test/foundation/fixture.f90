!> Files that tests make below build/test-output, and checks of error messages.
module fixture
    use gracecg_error, only: error_t
    use gracecg_file, only: make_directory, remove_file
    use testdrive, only: error_type, check, test_failed
    implicit none
    private
    public :: FOLDER, make_folder, make_file, remove_file, check_fails, check_passes

    character(*), parameter :: FOLDER = 'build/test-output/'

contains

    !> Makes FOLDER.
    subroutine make_folder(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure

        call make_directory(FOLDER, failure)
        call check_passes(error, failure)
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
    subroutine check_fails(error, failure, parts)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable, intent(in) :: failure
        character(*), intent(in) :: parts(:)
        integer :: i

        call check(error, allocated(failure), 'no failure where one must be: '//trim(parts(1)))
        do i = 1, size(parts)
            if (allocated(error)) return
            call check(error, index(failure%message, trim(parts(i))) > 0, &
                       '"'//trim(parts(i))//'" is not in the message: '//failure%message)
        end do
    end subroutine check_fails

    subroutine check_passes(error, failure)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable, intent(in) :: failure

        if (allocated(failure)) call test_failed(error, failure%message)
    end subroutine check_passes
end module fixture
