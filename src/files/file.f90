!> Files and folders: reading a text whole, making folders, and writing files that appear under
!> their name only when they are complete.
!>
!> The streams are those of the C library: they may be used from several threads, also on the same
!> file, and report a full disk when they are closed.
module gracecg_files_file
    use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_null_ptr, &
        c_ptr, c_size_t
    use gracecg_base_kinds, only: i8
    use gracecg_base_error, only: error_t, fail, fail_in_file
    use gracecg_files_path, only: file_exists, directory_exists, make_directory, remove_file, is_device, without_slashes, &
        parent_of, copy_permissions, IDENTITY_WORDS, identity_of, is_same, c_fclose
    use gracecg_files_run_record, only: note_input, note_hash, note_output, note_file, reserve, take_reserved, &
        add_to_hash, EMPTY_HASH, get_provenance, UNFINISHED, WRITTEN
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: string_t, join, padded, integer_text
    implicit none
    private
    public :: file_exists, directory_exists, make_directory, remove_file, check_writable, is_device, is_unfinished, &
        without_slashes
    public :: text_file_t, read_text_file, text_file_of, output_file_t, appended_file_t, input_stream_t

    type :: text_file_t
        !! A text and where its lines begin and end
        character(:), allocatable :: name   !! Path as the user gave it
        character(:), allocatable :: text   !! The whole content
        integer, allocatable :: first(:)    !! Line i is text(first(i):last(i)), without its end
        integer, allocatable :: last(:)     !! See `first`
    contains
        procedure :: line_count                 !! How many lines there are
        procedure :: line => line_of_text       !! One line without its end
        procedure :: fail_at => fail_at_line    !! A failure at a line
    end type text_file_t

    type :: stream_t
        !! A file that is open, or none
        private
        character(:), allocatable :: path
        type(c_ptr) :: stream = c_null_ptr
    contains
        procedure :: close => close_stream      !! Ends it; what was written stays
        final :: finalise_stream
    end type stream_t

    type, extends(stream_t) :: input_stream_t
        !! A file that is read in large pieces, for what is too long to be held whole
        integer(i8), private :: hash = EMPTY_HASH       !! Of what was read
    contains
        procedure :: open => open_input         !! Begins at its first byte
        procedure :: read => read_input         !! The next bytes
    end type input_stream_t

    type :: output_file_t
        !! A text file being written under a temporary name in the folder of the final one.
        !! `commit` gives it its name; without that, nothing is left.
        private
        character(:), allocatable :: path
        character(:), allocatable :: temporary  !! The name until commit; that of a device itself
        type(c_ptr) :: stream = c_null_ptr
        logical :: incomplete = .false.         !! A write failed
    contains
        procedure :: open => open_output        !! Begins the file
        procedure :: line => write_line         !! Writes a line
        procedure :: about => write_about       !! Writes what the file was made by and of
        procedure :: bytes => write_bytes       !! Writes what a text holds, without a line end
        procedure :: commit => commit_output    !! Ends the file and gives it its name
        procedure :: discard => discard_output  !! Leaves nothing behind
        final :: finalise_output
    end type output_file_t

    type, extends(stream_t) :: appended_file_t
        !! A text file that grows under its own name: each line is handed to the system at once, so that it is
        !! not lost when the program is killed, whatever the signal. Then at most the last line has no end.
    contains
        procedure :: open => open_appended      !! Goes on at the end of a file
        procedure :: line => append_line        !! Appends a line
    end type appended_file_t

    interface
        function c_fopen(path, mode) bind(c, name='fopen') result(stream)
            import :: c_char, c_ptr
            character(kind=c_char), intent(in) :: path(*), mode(*)
            type(c_ptr) :: stream
        end function c_fopen

        integer(c_size_t) function c_fread(buffer, size, count, stream) bind(c, name='fread')
            import :: c_char, c_ptr, c_size_t
            character(kind=c_char), intent(out) :: buffer(*)
            integer(c_size_t), value :: size, count
            type(c_ptr), value :: stream
        end function c_fread

        integer(c_size_t) function c_fwrite(buffer, size, count, stream) bind(c, name='fwrite')
            import :: c_char, c_ptr, c_size_t
            character(kind=c_char), intent(in) :: buffer(*)
            integer(c_size_t), value :: size, count
            type(c_ptr), value :: stream
        end function c_fwrite

        integer(c_int) function c_ferror(stream) bind(c, name='ferror')
            import :: c_int, c_ptr
            type(c_ptr), value :: stream
        end function c_ferror

        integer(c_int) function c_fflush(stream) bind(c, name='fflush')
            import :: c_int, c_ptr
            type(c_ptr), value :: stream
        end function c_fflush

        integer(c_int) function c_fileno(stream) bind(c, name='fileno')
            import :: c_int, c_ptr
            type(c_ptr), value :: stream
        end function c_fileno

        integer(c_int) function c_flock(descriptor, operation) bind(c, name='flock')
            import :: c_int
            integer(c_int), value :: descriptor, operation
        end function c_flock

        integer(c_int) function c_rename(old, new) bind(c, name='rename')
            import :: c_char, c_int
            character(kind=c_char), intent(in) :: old(*), new(*)
        end function c_rename

    end interface

    integer(c_int), parameter :: LOCK_WITHOUT_WAITING = 6   !! LOCK_EX and LOCK_NB of sys/file.h
    integer(c_size_t), parameter :: ONE_BYTE = 1
    character(1), parameter :: LF = achar(10), CR = achar(13)
    character(3), parameter :: BYTE_ORDER_MARK = char(239)//char(187)//char(191)

contains

    !> Reads a whole text and finds its lines; fails when the file is missing, is a folder, is too long (told by its size,
    !> before it is read), or cannot be read.
    subroutine read_text_file(path, file, error, largest)
        character(*), intent(in) :: path    !! Of the file
        type(text_file_t), intent(out) :: file
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: largest    !! That is read, MB; absent: 1024

        integer, parameter :: MEGABYTE = 2**20, USUAL = 1024
        character(:), allocatable :: content
        integer(i8) :: length, most
        type(c_ptr) :: stream
        integer(i8) :: hash
        integer(c_int) :: status
        logical :: failed

        call open_to_read(path, stream, error)
        if (allocated(error)) return
        most = USUAL
        if (present(largest)) most = largest
        length = size_of(path)
        if (length <= most*MEGABYTE) then
            call read_stream(stream, length, most*MEGABYTE, content, failed)
            if (.not. failed) length = len(content, i8)
        end if
        status = c_fclose(stream)
        if (length > most*MEGABYTE) then
            call fail(error, trim(path)//': is longer than '//integer_text(most)//' MB, the most that is read of such a file: '// &
                      'is it the right one?')
            return
        else if (failed) then
            call fail(error, trim(path)//': cannot be read as a text file')
            return
        end if
        hash = EMPTY_HASH
        call add_to_hash(content, hash)
        call note_hash(path, hash)
        file = text_file_of(content, trim(path))
    end subroutine read_text_file

    !> Opens a file. Fails when it is missing, is a folder, or may not be read.
    subroutine open_to_read(path, stream, error)
        character(*), intent(in) :: path
        type(c_ptr), intent(out) :: stream
        type(error_t), allocatable, intent(out) :: error

        stream = c_null_ptr
        if (path == '') then
            call fail(error, 'the name of the file is empty')
        else if (directory_exists(path)) then
            call fail(error, trim(path)//': is a folder, not a file')
        else if (.not. file_exists(path)) then
            call fail(error, trim(path)//': no such file')
        end if
        if (.not. allocated(error)) call note_input(path, error)
        if (allocated(error)) return
        stream = c_fopen(trim(path)//c_null_char, 'rb'//c_null_char)
        if (.not. c_associated(stream)) &
            call fail(error, trim(path)//': cannot be opened; check that you may read it')
    end subroutine open_to_read

    !> Begins a file at its first byte. Fails when it is missing, is a folder, or may not be read.
    subroutine open_input(self, path, error)
        class(input_stream_t), intent(inout) :: self
        character(*), intent(in) :: path    !! Of the file
        type(error_t), allocatable, intent(out) :: error

        call self%close()
        self%path = trim(path)
        self%hash = EMPTY_HASH
        call open_to_read(path, self%stream, error)
    end subroutine open_input

    !> The next bytes, as many as the text holds; fewer at the end of the file alone.
    subroutine read_input(self, bytes, count, error)
        class(input_stream_t), intent(inout) :: self
        character(*), intent(inout) :: bytes    !! Its first `count` characters are what was read
        integer, intent(out) :: count           !! 0 behind the end
        type(error_t), allocatable, intent(out) :: error

        count = 0
        if (.not. c_associated(self%stream) .or. len(bytes) == 0) return
        count = int(c_fread(bytes, ONE_BYTE, len(bytes, c_size_t), self%stream))
        call add_to_hash(bytes(:count), self%hash)
        if (count < len(bytes)) then
            if (c_ferror(self%stream) /= 0) call fail(error, self%path//': cannot be read to its end')
            if (.not. allocated(error)) call note_hash(self%path, self%hash)
        end if
    end subroutine read_input

    !> Ends it. Does nothing when none is open.
    subroutine close_stream(self)
        class(stream_t), intent(inout) :: self

        integer(c_int) :: status

        if (c_associated(self%stream)) status = c_fclose(self%stream)
        self%stream = c_null_ptr
    end subroutine close_stream

    subroutine finalise_stream(self)
        type(stream_t), intent(inout) :: self

        call self%close()
    end subroutine finalise_stream

    !> Bytes of a file; 0 where that has no meaning.
    integer(i8) function size_of(path)
        character(*), intent(in) :: path

        inquire (file=trim(path), size=size_of)
        size_of = max(0_i8, size_of)
    end function size_of

    !> Reads to the end of a stream, whatever its length (a pipe has none beforehand).
    subroutine read_stream(stream, expected, most, content, failed)
        type(c_ptr), intent(in) :: stream
        integer(i8), intent(in) :: expected                     !! Bytes, if known
        integer(i8), intent(in) :: most                         !! Bytes that are wanted; one more tells that there are more
        character(:), allocatable, intent(out) :: content
        logical, intent(out) :: failed                          !! Also without memory

        integer(i8), parameter :: SMALLEST = 65536
        character(:), allocatable :: larger
        integer(i8) :: used, got
        integer :: memory

        failed = .true.
        allocate (character(min(most + 1, max(SMALLEST, expected + 1))) :: content, stat=memory)
        if (memory /= 0) return
        used = 0
        do
            got = c_fread(content(used + 1:), ONE_BYTE, len(content, c_size_t) - used, stream)
            used = used + got
            if (used < len(content, i8)) exit
            if (used > most) exit
            allocate (character(min(most + 1, 2*used)) :: larger, stat=memory)
            if (memory /= 0) return
            larger(:used) = content
            call move_alloc(larger, content)
        end do
        failed = c_ferror(stream) /= 0
        content = content(:used)
    end subroutine read_stream

    !> A text in memory as a text file: lines end with LF or CR LF, the last one with or without; a
    !> byte order mark of UTF-8 is dropped.
    function text_file_of(text, name) result(file)
        character(*), intent(in) :: text, name  !! Content; what stands for the file in messages
        type(text_file_t) :: file

        integer :: i, n, begin, end

        file%name = name
        file%text = text
        if (len(text) >= 3) then
            if (text(:3) == BYTE_ORDER_MARK) file%text = text(4:)
        end if
        n = 0
        do i = 1, len(file%text)
            if (file%text(i:i) == LF) n = n + 1
        end do
        if (len(file%text) > 0) then
            if (file%text(len(file%text):) /= LF) n = n + 1
        end if
        allocate (file%first(n), file%last(n))
        begin = 1
        do i = 1, n
            end = begin - 1 + index(file%text(begin:), LF)
            if (end < begin) end = len(file%text) + 1
            file%first(i) = begin
            file%last(i) = end - 1
            if (end > begin) then
                if (file%text(end - 1:end - 1) == CR) file%last(i) = end - 2
            end if
            begin = end + 1
        end do
    end function text_file_of

    pure integer function line_count(self)
        class(text_file_t), intent(in) :: self

        line_count = size(self%first)
    end function line_count

    !> The length of a line; 0 for a number that no line has.
    pure integer function line_length(self, number) result(length)
        class(text_file_t), intent(in) :: self
        integer, intent(in) :: number

        length = 0
        if (number >= 1 .and. number <= self%line_count()) &
            length = max(0, self%last(number) - self%first(number) + 1)
    end function line_length

    !> Line `number` without its end; empty for a number that no line has.
    pure function line_of_text(self, number) result(line)
        class(text_file_t), intent(in) :: self
        integer, intent(in) :: number       !! Counted from 1
        character(line_length(self, number)) :: line

        if (len(line) > 0) line = self%text(self%first(number):self%last(number))
    end function line_of_text

    !> A failure at a line of the text; shows the line if there is one of that number.
    subroutine fail_at_line(self, number, message, error)
        class(text_file_t), intent(in) :: self
        integer, intent(in) :: number       !! Counted from 1
        character(*), intent(in) :: message !! What is wrong there
        type(error_t), allocatable, intent(out) :: error

        if (number >= 1 .and. number <= self%line_count()) then
            call fail_in_file(error, self%name, number, message, self%line(number))
        else
            call fail_in_file(error, self%name, number, message)
        end if
    end subroutine fail_at_line

    !> Fails when a file of that name could not be written: to be asked before long work. An empty name
    !> stands for no file. The program keeps the name for this run: nobody else writes the file meanwhile.
    subroutine check_writable(path, error)
        character(*), intent(in) :: path    !! Of the file that will be written
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        type(c_ptr) :: reserved

        if (path == '') return
        call take_reserved(path, reserved)
        if (c_associated(reserved)) then
            call reserve(path, reserved)
            call fail(error, trim(path)//': two outputs of this command have this name; give each a name of its own')
            return
        end if
        call file%open(path, error)
        if (.not. allocated(error)) call reserve(path, file%stream)
        call file%discard()
    end subroutine check_writable

    !> Begins a file. Fails when it cannot be written in its folder, another program is writing it, or it is an input of
    !> this run. A path below /dev is written directly: a device must not be replaced by a file.
    subroutine open_output(self, path, error)
        class(output_file_t), intent(inout) :: self
        character(*), intent(in) :: path    !! Of the file to write; an existing one is replaced
        type(error_t), allocatable, intent(out) :: error

        call self%discard()
        self%incomplete = .false.
        self%path = trim(path)
        if (path == '') then
            call fail(error, 'the name of the output file is empty')
        else if (directory_exists(path)) then
            call fail(error, self%path//': is a folder; name a file')
        else if (.not. directory_exists(parent_of(path))) then
            call fail(error, self%path//': cannot be written: there is no folder '//parent_of(path))
        else if (is_device(path)) then
            self%temporary = self%path
            self%stream = c_fopen(self%path//c_null_char, 'wb'//c_null_char)
        else
            call note_output(path, error)
            if (.not. allocated(error)) call open_temporary(self, error)
        end if
        if (allocated(error)) return
        if (.not. c_associated(self%stream)) &
            call fail(error, self%path//': cannot be written; check the permissions of '// &
                      parent_of(path))
    end subroutine open_output

    !> Is it the name of a file that output_file_t has not completed? One that was left is of a program that was ended.
    pure logical function is_unfinished(path)
        character(*), intent(in) :: path    !! With or without folders

        is_unfinished = index(trim(path)//'/', UNFINISHED//'/') > 0
    end function is_unfinished

    !> Begins PATH.part1 and locks it; the system ends the lock with the program, so that a file which is not locked is
    !> left of one that was killed, and goes. Fails when another writer has locked it.
    subroutine open_temporary(self, error)
        class(output_file_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: ATTEMPTS = 10     !! While others come and go
        type(c_ptr) :: left
        integer(c_int) :: before(IDENTITY_WORDS)
        integer(c_int) :: status
        integer :: i

        self%temporary = self%path//UNFINISHED
        call take_reserved(self%path, self%stream)
        if (c_associated(self%stream)) return
        do i = 1, ATTEMPTS
            self%stream = c_fopen(self%temporary//c_null_char, 'wbx'//c_null_char)
            if (c_associated(self%stream)) then
                status = c_flock(c_fileno(self%stream), LOCK_WITHOUT_WAITING)
                return
            end if
            before = identity_of(self%temporary)
            left = c_fopen(self%temporary//c_null_char, 'r+b'//c_null_char)
            if (.not. c_associated(left)) cycle
            status = c_flock(c_fileno(left), LOCK_WITHOUT_WAITING)
            if (status == 0 .and. is_same(identity_of(self%temporary), before)) call remove_file(self%temporary)
            status = status + c_fclose(left)
            if (status /= 0) exit
        end do
        if (file_exists(self%temporary)) &
            call fail(error, self%path//': another program, or another output of this one, is writing this file; wait '// &
                      'for its end, or remove '//self%temporary//' if there is none')
    end subroutine open_temporary

    !> Writes a line. A failure is remembered and reported by `commit`.
    subroutine write_line(self, text)
        class(output_file_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Without the end of the line; may hold several lines

        call self%bytes(text)
        call self%bytes(LF)
    end subroutine write_line

    !> Writes comment lines with the version and command line of the program and the hashes of its inputs; nothing when
    !> the program is another.
    subroutine write_about(self, mark)
        class(output_file_t), intent(inout) :: self
        character(*), intent(in) :: mark    !! That begins a comment

        character(:), allocatable :: command, commit
        type(string_t), allocatable :: inputs(:)

        call get_provenance(command, inputs, commit)
        if (command == '') return
        call self%line(mark//' gracecg '//trim(VERSION//' '//commit)//': '//command)
        if (size(inputs) > 0) call self%line(mark//' inputs: '//join(padded(inputs), '; '))
    end subroutine write_about

    !> Writes what a text holds. A failure is remembered and reported by `commit`.
    subroutine write_bytes(self, text)
        class(output_file_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Any bytes

        integer(c_size_t) :: length

        self%incomplete = self%incomplete .or. .not. c_associated(self%stream)
        if (self%incomplete) return
        length = len(text, c_size_t)
        if (c_fwrite(text, ONE_BYTE, length, self%stream) /= length) self%incomplete = .true.
    end subroutine write_bytes

    !> Completes the file and gives it its name, in place of an older file of that name. After a
    !> failure (disk full, no permission) an older file is still there, unharmed.
    subroutine commit_output(self, error)
        class(output_file_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (.not. c_associated(self%stream)) then
            call fail(error, 'the output file was not opened, or is closed already')
            return
        end if
        if (c_fclose(self%stream) /= 0) self%incomplete = .true.
        self%stream = c_null_ptr
        if (self%incomplete) then
            call fail(error, self%path// &
                      ': could not be written completely; check the free space of the disk')
        else if (.not. is_device(self%path)) then
            call copy_permissions(self%path, self%temporary)
            if (c_rename(self%temporary//c_null_char, self%path//c_null_char) /= 0) &
                call fail(error, self%path// &
                          ': the finished file could not be given its name; check '// &
                          'the permissions of '//parent_of(self%path))
            if (.not. allocated(error)) call note_file(self%path, WRITTEN)
        end if
        if (allocated(error) .and. .not. is_device(self%path)) call remove_file(self%temporary)
    end subroutine commit_output

    !> Gives the file up: nothing of it is left. Does nothing when none is open.
    subroutine discard_output(self)
        class(output_file_t), intent(inout) :: self

        integer(c_int) :: status

        if (.not. c_associated(self%stream)) return
        status = c_fclose(self%stream)
        self%stream = c_null_ptr
        if (.not. is_device(self%path)) call remove_file(self%temporary)
    end subroutine discard_output

    !> Opens a file to go on at its end. Fails when that cannot be done.
    subroutine open_appended(self, path, error)
        class(appended_file_t), intent(inout) :: self
        character(*), intent(in) :: path    !! Of a file that exists and ends with a line end, or is made
        type(error_t), allocatable, intent(out) :: error

        call self%close()
        self%path = trim(path)
        self%stream = c_fopen(self%path//c_null_char, 'ab'//c_null_char)
        if (.not. c_associated(self%stream)) &
            call fail(error, self%path//': cannot be written; check the permissions of '//parent_of(path))
    end subroutine open_appended

    !> Appends a line. Fails when the system does not take it (a full disk).
    subroutine append_line(self, text, error)
        class(appended_file_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Without the end of the line
        type(error_t), allocatable, intent(out) :: error

        integer(c_size_t) :: length
        logical :: taken

        taken = .false.
        length = len(text, c_size_t) + 1
        if (c_associated(self%stream)) then
            taken = c_fwrite(text//LF, ONE_BYTE, length, self%stream) == length
            if (c_fflush(self%stream) /= 0) taken = .false.
        end if
        if (.not. taken) call fail(error, self%path//': could not be written completely; check the free space of '// &
                                   'the disk')
    end subroutine append_line

    subroutine finalise_output(self)
        type(output_file_t), intent(inout) :: self

        call self%discard()
    end subroutine finalise_output
end module gracecg_files_file
