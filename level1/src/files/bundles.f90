!> Level-1 files as data centres give them out: by themselves, compressed (.gz), in bundles (.tar, .tgz, .tar.gz), in folders of
!> any depth. A file in a bundle has a path behind that of the bundle: day.tgz/ACC1A_2023-06-01_C_04.txt.
!>
!> Compressed files and bundles are read by zlib, which is loaded when the first one is opened.
module gracecg_level1_bundles
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_procpointer, c_int, c_long, c_null_char, &
        c_null_ptr, c_ptr
    use gracecg_level1_basics
    use gracecg_base_dynamic_library, only: load_library, symbol_in
    use gracecg_files_file, only: input_stream_t, text_file_t, text_file_of, file_exists, directory_exists
    use gracecg_files_path, only: files_in_folder
    use gracecg_files_run_record, only: has_hash
    implicit none
    private
    public :: level1_stream_t, find_level1_files, is_bundle, read_packed_text

    abstract interface
        !> Opens a file, compressed or not; null where that fails
        type(c_ptr) function gzopen(path, mode) bind(c)
            import :: c_char, c_ptr
            character(kind=c_char), intent(in) :: path(*), mode(*)
        end function gzopen

        !> The next bytes, decompressed; how many, negative where the file is broken
        integer(c_int) function gzread(file, bytes, length) bind(c)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: file
            character(kind=c_char), intent(out) :: bytes(*)
            integer(c_int), value :: length
        end function gzread

        !> Goes to a byte; negative where that fails
        integer(c_long) function gzseek(file, offset, origin) bind(c)
            import :: c_int, c_long, c_ptr
            type(c_ptr), value :: file
            integer(c_long), value :: offset
            integer(c_int), value :: origin
        end function gzseek

        !> Ends the reading; 0 where all that was read is whole
        integer(c_int) function gzclose(file) bind(c)
            import :: c_int, c_ptr
            type(c_ptr), value :: file
        end function gzclose
    end interface

    integer, parameter :: BLOCK = 512           !! Bytes; a tar file has whole ones
    integer, parameter :: DEEPEST = 16          !! Folders in folders: links may go round
    character(*), parameter :: BUNDLES(3) = [character(7) :: '.tar', '.tgz', '.tar.gz'], COMPRESSED = '.gz'

    type :: compressed_file_t
        !! A file that zlib reads
        character(:), allocatable :: path
        type(c_ptr) :: file = c_null_ptr
        procedure(gzread), pointer, nopass :: read_bytes => null()
        procedure(gzseek), pointer, nopass :: seek => null()
        procedure(gzclose), pointer, nopass :: close_file => null()
    contains
        procedure :: open => open_compressed
        procedure :: read => read_compressed
        procedure :: close => close_compressed
        final :: finalise_compressed
    end type compressed_file_t

    type :: member_t
        !! A file in a tar file
        character(:), allocatable :: name
        integer(i8) :: first = 0        !! Byte of the tar file that is its first one, from 0
        integer(i8) :: bytes = 0
    end type member_t

    type :: level1_stream_t
        !! A file that is read in large pieces, from wherever it is
        private
        type(input_stream_t) :: plain
        type(compressed_file_t) :: compressed
        integer(i8) :: left = 0         !! Bytes of it that are not read yet, in `compressed`; huge: not known
    contains
        procedure :: open => open_stream        !! Begins at its first byte
        procedure :: read => read_stream        !! The next bytes
        procedure :: close => close_stream      !! Ends it
    end type level1_stream_t

contains

    !> All files of a place: a folder with all folders in it, where bundles stand for what they hold; a bundle; or a file. In
    !> alphabetic order of each folder. Fails when there is no such place, or a bundle cannot be read.
    recursive subroutine find_level1_files(place, paths, error, depth)
        character(*), intent(in) :: place           !! Its path
        type(string_t), allocatable, intent(inout) :: paths(:)      !! What is found stands behind what is there
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: depth      !! Of the folder below the one that was asked for; absent: 0

        type(string_t), allocatable :: found(:), folders(:)
        type(compressed_file_t) :: archive
        type(member_t), allocatable :: members(:)
        integer :: i, level

        level = 0
        if (present(depth)) level = depth
        if (level > DEEPEST) return
        if (directory_exists(place)) then
            call files_in_folder(place, found, error, folders)
            if (allocated(error)) return
            found = [found, folders]
            do i = 1, size(found)
                call find_level1_files(found(i)%text, paths, error, level + 1)
                if (allocated(error)) return
            end do
        else if (.not. file_exists(place)) then
            if (level > 0) return       ! a link that leads nowhere
            call fail(error, trim(place)//': no such folder or file')
        else if (.not. is_bundle(place)) then
            call append(paths, trim(place))
        else
            call read_members(place, archive, members, error)
            if (allocated(error)) return
            do i = 1, size(members)
                call append(paths, trim(place)//'/'//members(i)%name)
            end do
        end if
    end subroutine find_level1_files

    !> Whether a path is named like a bundle.
    pure logical function is_bundle(path)
        character(*), intent(in) :: path        !! Of a file that need not be there

        is_bundle = ends_with(path, BUNDLES)
    end function is_bundle

    !> Whether a path ends with one of some endings, in small or large letters.
    pure logical function ends_with(path, endings)
        character(*), intent(in) :: path, endings(:)

        integer :: i, n

        ends_with = .false.
        do i = 1, size(endings)
            n = len_trim(endings(i))
            if (len_trim(path) < n) cycle
            ends_with = ends_with .or. lower_case(path(len_trim(path) - n + 1:len_trim(path))) == endings(i)
        end do
    end function ends_with

    !> The files in a bundle, as its headers say (POSIX ustar; names of GNU that are longer than 100 letters, too).
    subroutine read_members(path, archive, members, error, wanted)
        character(*), intent(in) :: path            !! Of the bundle
        type(compressed_file_t), intent(inout) :: archive   !! It, open
        type(member_t), allocatable, intent(out) :: members(:)
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: wanted        !! The name of one: nothing behind it is looked at

        integer, parameter :: LONGEST_NAME = 4096
        type(member_t), allocatable :: more(:)
        type(member_t) :: one
        character(BLOCK) :: header
        character(LONGEST_NAME) :: long_name
        integer(i8) :: at
        integer :: count, n, status

        allocate (members(0))
        long_name = ''
        at = 0
        call archive%open(path, error)
        do while (.not. allocated(error))
            call archive%read(at, header, count, error)
            if (allocated(error) .or. count == 0) exit
            if (count == BLOCK .and. header == repeat(achar(0), BLOCK)) exit
            one = member_t('', at + BLOCK, 0)
            read (header(125:135), '(o11)', iostat=status) one%bytes
            if (count < BLOCK .or. header(258:262) /= 'ustar' .or. status /= 0) then
                call fail(error, trim(path)//': is no tar file, or broken, at byte '//integer_text(at))
                exit
            end if
            if (header(157:157) == 'L') then        ! the name of the next one
                call archive%read(one%first, long_name(:min(one%bytes, int(LONGEST_NAME, i8))), count, error)
                long_name = up_to_zero(long_name(:count))
            else if (scan(header(157:157), '0'//achar(0)) == 1) then
                one%name = trim(up_to_zero(header(:100)))
                if (header(346:346) /= achar(0) .and. header(263:263) == achar(0)) &
                    one%name = trim(up_to_zero(header(346:500)))//'/'//one%name
                if (long_name /= '') one%name = trim(long_name)
                long_name = ''
                n = size(members)
                allocate (more(n + 1))
                more(:n) = members
                more(n + 1) = one
                call move_alloc(more, members)
                if (present(wanted)) then
                    if (one%name == wanted) exit
                end if
            end if
            at = one%first + (one%bytes + BLOCK - 1)/BLOCK*BLOCK
        end do

    contains

        !> A text without a zero byte and what follows it.
        pure function up_to_zero(text)
            character(*), intent(in) :: text
            character(len(text)) :: up_to_zero

            up_to_zero = text(:index(text//achar(0), achar(0)) - 1)
        end function up_to_zero

    end subroutine read_members

    !> Opens a file that zlib reads. Fails when it may not be read, or there is no zlib.
    subroutine open_compressed(self, path, error)
        class(compressed_file_t), intent(inout) :: self
        character(*), intent(in) :: path
        type(error_t), allocatable, intent(out) :: error

        character(13), parameter :: NAMES(3) = [character(13) :: 'libz.so.1', 'libz.so', 'libz.1.dylib']
        type(input_stream_t) :: bytes
        type(c_ptr) :: library
        character(65536) :: some
        procedure(gzopen), pointer :: open_file
        integer :: i, count

        call self%close()
        self%path = trim(path)
        call bytes%open(path, error)        ! it may be read
        count = merge(0, 1, has_hash(path))
        do while (count > 0 .and. .not. allocated(error))       ! to its end, for the hash
            call bytes%read(some, count, error)
        end do
        call bytes%close()
        if (allocated(error)) return
        do i = 1, size(NAMES)
            library = load_library(NAMES(i))
            if (c_associated(library)) exit
        end do
        if (.not. c_associated(library)) then
            call fail(error, self%path//': takes the library zlib ('//trim(NAMES(1))//'), which is not installed; install it, '// &
                      'or unpack the file')
            return
        end if
        call c_f_procpointer(symbol_in(library, 'gzopen'), open_file)
        call c_f_procpointer(symbol_in(library, 'gzread'), self%read_bytes)
        call c_f_procpointer(symbol_in(library, 'gzseek'), self%seek)
        call c_f_procpointer(symbol_in(library, 'gzclose'), self%close_file)
        self%file = open_file(self%path//c_null_char, 'rb'//c_null_char)
        if (.not. c_associated(self%file)) call fail(error, self%path//': cannot be opened; check that you may read it')
    end subroutine open_compressed

    !> Bytes from a place on, as many as the text holds; fewer at the end of the file alone. Fails where it is broken.
    subroutine read_compressed(self, first, bytes, count, error)
        class(compressed_file_t), intent(inout) :: self
        integer(i8), intent(in) :: first        !! Byte, from 0; negative: the next one
        character(*), intent(inout) :: bytes
        integer, intent(out) :: count           !! How many were read
        type(error_t), allocatable, intent(out) :: error

        integer(c_long) :: place
        integer(c_int) :: status

        count = 0
        if (.not. c_associated(self%file)) return
        place = 0
        if (first >= 0) place = self%seek(self%file, int(first, c_long), 0_c_int)
        if (place >= 0) count = self%read_bytes(self%file, bytes, len(bytes, c_int))
        if (place >= 0 .and. count == len(bytes)) return
        status = self%close_file(self%file)     ! which alone says that a file ends too early
        self%file = c_null_ptr
        if (place >= 0 .and. count >= 0 .and. status == 0) return
        count = 0
        call fail(error, self%path//': is broken, or not whole: it cannot be decompressed to its end')
    end subroutine read_compressed

    subroutine close_compressed(self)
        class(compressed_file_t), intent(inout) :: self

        integer(c_int) :: status

        if (c_associated(self%file)) status = self%close_file(self%file)
        self%file = c_null_ptr
    end subroutine close_compressed

    subroutine finalise_compressed(self)
        type(compressed_file_t), intent(inout) :: self

        call self%close()
    end subroutine finalise_compressed

    !> Begins a file at its first byte. Fails when it is missing, is a folder, or cannot be read.
    subroutine open_stream(self, path, error)
        class(level1_stream_t), intent(inout) :: self
        character(*), intent(in) :: path        !! Of the file, which may be in a bundle
        type(error_t), allocatable, intent(out) :: error

        type(member_t), allocatable :: members(:)
        character(0) :: nothing
        integer :: i, slash, count

        call self%close()
        slash = len_trim(path)
        do while (slash > 1)        ! what is a file, or its path up to a folder that is one
            if (file_exists(path(:slash)) .or. directory_exists(path(:slash))) exit
            slash = index(path(:slash), '/', back=.true.) - 1
        end do
        if (slash <= 1 .or. slash == len_trim(path) .or. .not. is_bundle(path(:max(1, slash)))) then
            if (.not. ends_with(path, [COMPRESSED])) then
                call self%plain%open(path, error)
            else
                call self%compressed%open(path, error)
                self%left = huge(self%left)
            end if
            return
        end if
        call read_members(path(:slash), self%compressed, members, error, path(slash + 2:))
        if (allocated(error)) return
        i = size(members)       ! the one that is wanted, if it is there
        if (i > 0) then
            if (members(i)%name /= path(slash + 2:)) i = 0
        end if
        if (i == 0) then
            call fail(error, trim(path)//': no such file in the bundle')
            call self%close()
            return
        end if
        self%left = members(i)%bytes
        call self%compressed%read(members(i)%first, nothing, count, error)
    end subroutine open_stream

    !> The next bytes, as many as the text holds; fewer at the end of the file alone.
    subroutine read_stream(self, bytes, count, error)
        class(level1_stream_t), intent(inout) :: self
        character(*), intent(inout) :: bytes        !! Its first `count` characters are what was read
        integer, intent(out) :: count               !! 0 behind the end
        type(error_t), allocatable, intent(out) :: error

        integer :: wanted

        if (.not. c_associated(self%compressed%file)) then
            call self%plain%read(bytes, count, error)
            return
        end if
        wanted = int(min(self%left, len(bytes, i8)))
        call self%compressed%read(-1_i8, bytes(:wanted), count, error)
        if (self%left < huge(self%left)) then
            if (count < wanted .and. .not. allocated(error)) &
                call fail(error, self%compressed%path//': is not whole: it ends in the middle of a file')
            self%left = self%left - count
        end if
    end subroutine read_stream

    !> Reads a whole text, from wherever it is. Fails as the stream does.
    subroutine read_packed_text(path, file, error)
        character(*), intent(in) :: path        !! Of the file, which may be in a bundle
        type(text_file_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error

        type(level1_stream_t) :: stream
        character(65536) :: some
        character(:), allocatable :: content
        integer :: count

        content = ''
        count = 1
        call stream%open(path, error)
        do while (count > 0 .and. .not. allocated(error))
            call stream%read(some, count, error)
            content = content//some(:count)
        end do
        call stream%close()
        if (.not. allocated(error)) file = text_file_of(content, path)
    end subroutine read_packed_text

    !> Ends it. Does nothing when none is open.
    subroutine close_stream(self)
        class(level1_stream_t), intent(inout) :: self

        call self%plain%close()
        call self%compressed%close()
        self%left = 0
    end subroutine close_stream
end module gracecg_level1_bundles
