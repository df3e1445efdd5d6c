!> Files and folders by their paths: what is there, and which file it is.
module gracecg_files_path
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_ptr
    use gracecg_base_error, only: error_t, fail
    implicit none
    private
    public :: file_exists, directory_exists, make_directory, remove_file, is_device, without_slashes, parent_of
    public :: IDENTITY_WORDS, identity_of, is_same, copy_permissions, c_fclose

    interface
        integer(c_int) function c_stat(path, about) bind(c, name='stat')
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: path(*)
            integer(c_int), intent(inout) :: about(*)
        end function c_stat

        integer(c_int) function c_chmod(path, mode) bind(c, name='chmod')
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: path(*)
            integer(c_int), value :: mode
        end function c_chmod

        !> Closes a stream of C's library; 0 where that went well
        integer(c_int) function c_fclose(stream) bind(c, name='fclose')
            import :: c_int, c_ptr
            type(c_ptr), value :: stream
        end function c_fclose

        integer(c_int) function c_remove(path) bind(c, name='remove')
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: path(*)
        end function c_remove

        integer(c_int) function c_mkdir(path, mode) bind(c, name='mkdir')
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: path(*)
            integer(c_int), value :: mode
        end function c_mkdir
    end interface

    integer(c_int), parameter :: ALL_PERMISSIONS = int(o'777', c_int)
    integer, parameter :: IDENTITY_WORDS = 4    !! Of them: the first, where every C library has device and number of the file
    integer, parameter :: STAT_WORDS = 64       !! More than the C library's struct stat has anywhere
    integer, parameter :: MODE_WORDS(3) = [7, 5, 2]
    !! Where its mode may stand: x86-64; ARM, RISC-V and 32 bits; macOS.
    integer(c_int), parameter :: KIND_BITS = int(o'170000', c_int), FOLDER_KIND = int(o'40000', c_int)
    integer(c_int), parameter :: PERMISSION_BITS = int(o'777', c_int)

contains

    !> True for anything that is not a folder.
    logical function file_exists(path)
        character(*), intent(in) :: path    !! Of file or folder

        inquire (file=trim(path), exist=file_exists)
        if (file_exists) file_exists = .not. directory_exists(path)
    end function file_exists

    !> True for a folder.
    logical function directory_exists(path)
        character(*), intent(in) :: path    !! With or without a slash at the end

        inquire (file=trim(path)//'/.', exist=directory_exists)
    end function directory_exists

    !> Removes a file or an empty folder; nothing happens when it is not there.
    subroutine remove_file(path)
        character(*), intent(in) :: path    !! Of the file or empty folder

        integer(c_int) :: status

        status = c_remove(trim(path)//c_null_char)
    end subroutine remove_file

    !> Makes a folder, and the folders above it as needed. One that exists is left as it is.
    recursive subroutine make_directory(path, error)
        character(*), intent(in) :: path    !! Of the folder
        type(error_t), allocatable, intent(out) :: error

        integer(c_int) :: status

        if (path == '') then
            call fail(error, 'the name of the folder is empty')
            return
        end if
        if (directory_exists(path)) return
        if (file_exists(without_slashes(path))) then
            call fail(error, trim(path)// &
                      ': cannot make this folder: a file of that name is in the way')
            return
        end if
        call make_directory(parent_of(path), error)
        if (allocated(error)) return
        status = c_mkdir(trim(path)//c_null_char, ALL_PERMISSIONS)
        if (directory_exists(path)) return
        call fail(error, trim(path)//': cannot make this folder; check the permissions and the '// &
                  'free space of '//parent_of(path))
    end subroutine make_directory

    !> Where the last character stands that is no slash; 1 if there is none.
    pure integer function length_without_slashes(path) result(length)
        character(*), intent(in) :: path

        length = max(1, verify(trim(path), '/', back=.true.))
    end function length_without_slashes

    !> The path without slashes at its end, but / itself.
    pure function without_slashes(path) result(shorter)
        character(*), intent(in) :: path    !! Of a folder
        character(length_without_slashes(path)) :: shorter

        shorter = path
    end function without_slashes

    !> What parent_of gives, with blanks behind it.
    pure function parent_field(path) result(parent)
        character(*), intent(in) :: path
        character(len(path) + 1) :: parent

        integer :: last

        parent = without_slashes(path)
        last = index(parent, '/', back=.true.)
        if (last == 0) then
            parent = '.'
        else
            parent = without_slashes(parent(:last))
        end if
    end function parent_field

    !> The folder in which a file or folder stands.
    pure function parent_of(path) result(parent)
        character(*), intent(in) :: path        !! Of a file or folder
        character(len_trim(parent_field(path))) :: parent

        parent = parent_field(path)
    end function parent_of

    !> A path below /dev, except its folder for shared memory, where ordinary files stand.
    pure logical function is_device(path)
        character(*), intent(in) :: path        !! Of a file

        is_device = index(path, '/dev/') == 1 .and. index(path, '/dev/shm/') /= 1
    end function is_device

    !> Which file stands at a path, behind all links; 0 where there is none.
    function identity_of(path) result(identity)
        character(*), intent(in) :: path    !! Of file or folder
        integer(c_int) :: identity(IDENTITY_WORDS)

        integer(c_int) :: about(STAT_WORDS)

        about = 0
        if (c_stat(trim(path)//c_null_char, about) /= 0) about = 0
        identity = about(:IDENTITY_WORDS)
    end function identity_of

    !> Are they of one file that is there?
    pure logical function is_same(one, other)
        integer(c_int), intent(in) :: one(IDENTITY_WORDS), other(IDENTITY_WORDS)    !! By identity_of

        is_same = all(one == other) .and. any(one /= 0)
    end function is_same

    !> Gives a file the permissions of another one; does nothing where that one is not there.
    subroutine copy_permissions(from, to)
        character(*), intent(in) :: from, to    !! Paths

        integer(c_int) :: root(STAT_WORDS), about(STAT_WORDS), status
        integer :: i

        if (.not. file_exists(from)) return
        root = 0
        about = 0
        if (c_stat('/'//c_null_char, root) /= 0 .or. c_stat(trim(from)//c_null_char, about) /= 0) return
        do i = 1, size(MODE_WORDS)
            if (iand(root(MODE_WORDS(i)), KIND_BITS) /= FOLDER_KIND) cycle      ! the mode of a folder does not stand here
            status = c_chmod(trim(to)//c_null_char, iand(about(MODE_WORDS(i)), PERMISSION_BITS))
            return
        end do
    end subroutine copy_permissions
end module gracecg_files_path
