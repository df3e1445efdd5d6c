!> Files and folders by their paths: what is there, which file it is, and what is in a folder.
!>
!> The names in a folder come from `glob` of the C library, whose result begins with the number of paths and the address of
!> their list (so in the GNU C library and in musl).
module gracecg_files_path
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_ptr, c_size_t, c_f_pointer, c_null_ptr, &
        c_associated
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append
    implicit none
    private
    public :: file_exists, directory_exists, make_directory, remove_file, is_device, without_slashes, parent_of
    public :: IDENTITY_WORDS, identity_of, is_same, copy_permissions, c_fclose, files_in_folder

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
end module gracecg_files_path
