!> The files of a folder.
!>
!> Names come from `glob` of the C library, whose result begins with the number of paths and the address of
!> their list (so in the GNU C library and in musl).
module gracecg_files_folder
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_ptr, c_size_t, c_f_pointer, c_null_ptr, &
        c_associated
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append
    use gracecg_files_file, only: directory_exists, without_slashes
    implicit none
    private
    public :: files_in_folder

    type, bind(c) :: glob_t
        !! Number of paths, their list, and room for what the library keeps behind them
        integer(c_size_t) :: count = 0
        type(c_ptr) :: paths = c_null_ptr
        integer(c_size_t) :: own(30) = 0
    end type glob_t

    interface
        integer(c_int) function c_glob(pattern, flags, on_error, found) bind(c, name='glob')
            import :: c_char, c_int, c_ptr, glob_t
            character(kind=c_char), intent(in) :: pattern(*)
            integer(c_int), value :: flags
            type(c_ptr), value :: on_error
            type(glob_t), intent(inout) :: found
        end function c_glob

        subroutine c_globfree(found) bind(c, name='globfree')
            import :: glob_t
            type(glob_t), intent(inout) :: found
        end subroutine c_globfree

        integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
            import :: c_ptr, c_size_t
            type(c_ptr), value :: text
        end function c_strlen
    end interface

contains

    !> The paths of the files in a folder, in alphabetic order; no folders, and none whose name begins with a
    !> point. Fails when there is no such folder.
    subroutine files_in_folder(folder, paths, error, folders)
        character(*), intent(in) :: folder      !! With or without a slash at the end
        type(string_t), allocatable, intent(out) :: paths(:)
        type(error_t), allocatable, intent(out) :: error
        type(string_t), allocatable, intent(out), optional :: folders(:)    !! The paths of the folders in it

        type(glob_t) :: found
        type(c_ptr), pointer :: list(:)
        character(kind=c_char), pointer :: letters(:)
        character(:), allocatable :: path
        integer :: i, k
        integer(c_int) :: status

        allocate (paths(0))
        if (present(folders)) allocate (folders(0))
        if (.not. directory_exists(folder)) then
            call fail(error, trim(folder)//': no such folder')
            return
        end if
        status = c_glob(escaped(without_slashes(folder))//'/*'//c_null_char, 0_c_int, c_null_ptr, found)
        if (status == 0 .and. c_associated(found%paths)) then
            call c_f_pointer(found%paths, list, [found%count])
            do i = 1, size(list)
                call c_f_pointer(list(i), letters, [c_strlen(list(i))])
                allocate (character(size(letters)) :: path)
                do k = 1, size(letters)
                    path(k:k) = letters(k)
                end do
                if (.not. directory_exists(path)) then
                    call append(paths, path)
                else if (present(folders)) then
                    call append(folders, path)
                end if
                deallocate (path)
            end do
        end if
        call c_globfree(found)
    end subroutine files_in_folder

    pure integer function escaped_length(path) result(length)
        character(*), intent(in) :: path

        integer :: i

        length = len(path) + count([(scan(path(i:i), '*?[\') == 1, i=1, len(path))])
    end function escaped_length

    !> A path in which no letter has a meaning of its own.
    pure function escaped(path) result(pattern)
        character(*), intent(in) :: path
        character(escaped_length(path)) :: pattern

        integer :: i, n

        n = 0
        do i = 1, len(path)
            if (scan(path(i:i), '*?[\') == 1) then
                n = n + 1
                pattern(n:n) = '\'
            end if
            n = n + 1
            pattern(n:n) = path(i:i)
        end do
    end function escaped
end module gracecg_files_folder
