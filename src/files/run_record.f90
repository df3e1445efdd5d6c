!> What the program has read and written in one run, so that no output takes the place of an input or of another output,
!> and every output can say what it was made of.
!>
!> Only the program keeps a record, from `begin_record` to `end_record`. For every other caller of the library nothing
!> here does anything, and nothing is kept.
module gracecg_files_run_record
    use, intrinsic :: iso_c_binding, only: c_int, c_null_ptr, c_ptr
    use gracecg_base_kinds, only: i8
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append
    use gracecg_files_path, only: IDENTITY_WORDS, identity_of, is_same, is_device, remove_file, c_fclose
    implicit none
    private
    public :: begin_record, end_record, note_input, note_file, note_hash, has_hash, note_output, reserve, &
        take_reserved, get_provenance, add_to_hash, EMPTY_HASH, UNFINISHED, UPDATED, WRITTEN

    character(*), parameter :: UNFINISHED = '.part1'    !! Behind the name of a file that is being written

    integer(i8), parameter :: EMPTY_HASH = -3750763034362895579_i8
    !! FNV-1a of no bytes, 14695981039346656037 as a signed number
    integer, parameter :: INPUT = 1, UPDATED = 2, RESERVED = 3, WRITTEN = 4     !! What a file is in this run

    type :: run_file_t
        !! One file of this run
        character(:), allocatable :: path           !! As it was given
        integer(c_int) :: identity(IDENTITY_WORDS)  !! Of RESERVED: that of the file so far, path//UNFINISHED
        integer :: role = INPUT
        character(16) :: hash = ''                  !! FNV-1a of its bytes, hexadecimal; blank: it was not read to its end
        type(c_ptr) :: stream = c_null_ptr          !! Of RESERVED: that file, open and locked
    end type run_file_t

    type(run_file_t), allocatable :: files(:)       !! Of this run; not allocated: no record is kept
    character(:), allocatable :: command            !! The command line of this run
    character(:), allocatable :: commit             !! Of the sources of the program; empty: not known

contains

    !> From now on a record is kept. Not to be called while other threads work with files, as end_record.
    subroutine begin_record(command_line, commit_of_sources)
        character(*), intent(in) :: command_line    !! As it can be typed again
        character(*), intent(in), optional :: commit_of_sources     !! Blank or absent: not known

        call end_record()
        allocate (files(0))
        command = command_line
        commit = ''
        if (present(commit_of_sources)) commit = trim(commit_of_sources)
    end subroutine begin_record

    !> The run is over: what was reserved and not written leaves nothing behind.
    subroutine end_record()
        integer :: i
        integer(c_int) :: status

        if (.not. allocated(files)) return
        do i = 1, size(files)
            if (files(i)%role /= RESERVED) cycle
            status = c_fclose(files(i)%stream)
            call remove_file(files(i)%path//UNFINISHED)
        end do
        deallocate (files, command, commit)
    end subroutine end_record

    !> Notes a file that is about to be read. Fails when an output of this run is to take its place.
    subroutine note_input(path, error)
        character(*), intent(in) :: path        !! Of a file that is there
        type(error_t), allocatable, intent(out) :: error

        integer(c_int) :: identity(IDENTITY_WORDS)
        integer :: i

        if (.not. allocated(files)) return
        identity = identity_of(path)
        !$omp critical (gracecg_run_record)
        if (place_of(identity, [UPDATED, WRITTEN]) == 0) then
            do i = 1, size(files)
                if (files(i)%role /= RESERVED .or. allocated(error)) cycle
                if (is_same(identity_of(files(i)%path), identity)) call fail_as_input(files(i)%path, path, error)
            end do
            if (place_of(identity, [INPUT]) == 0) files = [files, run_file_t(trim(path), identity)]
        end if
        !$omp end critical (gracecg_run_record)
    end subroutine note_input

    !> Notes what was read of an input.
    subroutine note_hash(path, hash)
        character(*), intent(in) :: path        !! Of the input
        integer(i8), intent(in) :: hash         !! Of all its bytes, by add_to_hash

        integer :: place

        if (.not. allocated(files)) return
        !$omp critical (gracecg_run_record)
        place = place_of(identity_of(path), [UPDATED, INPUT])
        if (place > 0) write (files(place)%hash, '(z16.16)') hash
        !$omp end critical (gracecg_run_record)
    end subroutine note_hash

    !> Whether no hash of an input is wanted any more: it is noted, or no record is kept.
    logical function has_hash(path)
        character(*), intent(in) :: path        !! Of the input

        integer :: place

        has_hash = .true.
        if (.not. allocated(files)) return
        !$omp critical (gracecg_run_record)
        place = place_of(identity_of(path), [UPDATED, INPUT])
        if (place > 0) has_hash = files(place)%hash /= ''
        !$omp end critical (gracecg_run_record)
    end function has_hash

    !> Fails when a file that is to be written would take the place of an input, or of an output of this run.
    subroutine note_output(path, error)
        character(*), intent(in) :: path        !! Of the file to write
        type(error_t), allocatable, intent(out) :: error

        integer :: place

        if (.not. allocated(files) .or. is_device(path)) return
        !$omp critical (gracecg_run_record)
        place = place_of(identity_of(path), [UPDATED, INPUT, WRITTEN])
        if (place > 0) then
            if (files(place)%role == INPUT) call fail_as_input(path, files(place)%path, error)
            if (files(place)%role == WRITTEN) call fail(error, trim(path)//': this command has written this file already, '// &
                                                        'as '//files(place)%path//'; give each output a name of its own')
        end if
        !$omp end critical (gracecg_run_record)
    end subroutine note_output

    !> Notes a file that is read and then written anew with what it has, and may be replaced (UPDATED), or an output that is
    !> complete (WRITTEN).
    subroutine note_file(path, role)
        character(*), intent(in) :: path        !! Of the file; of one to be updated it may be missing
        integer, intent(in) :: role             !! UPDATED or WRITTEN

        if (.not. allocated(files) .or. is_device(path)) return
        !$omp critical (gracecg_run_record)
        files = [files, run_file_t(trim(path), identity_of(path), role)]
        !$omp end critical (gracecg_run_record)
    end subroutine note_file

    !> Keeps a file that has been begun, open and locked, until it is asked for: nobody else writes it meanwhile.
    !> The stream is null behind this when it is kept.
    subroutine reserve(path, stream)
        character(*), intent(in) :: path            !! Of the file; what there is of it is path//UNFINISHED
        type(c_ptr), intent(inout) :: stream

        if (.not. allocated(files) .or. is_device(path)) return
        !$omp critical (gracecg_run_record)
        files = [files, run_file_t(trim(path), identity_of(trim(path)//UNFINISHED), RESERVED, '', stream)]
        !$omp end critical (gracecg_run_record)
        stream = c_null_ptr
    end subroutine reserve

    !> What was reserved for a path, by whatever way it is named; null: nothing.
    subroutine take_reserved(path, stream)
        character(*), intent(in) :: path            !! Of the file
        type(c_ptr), intent(out) :: stream

        integer :: place

        stream = c_null_ptr
        if (.not. allocated(files)) return
        !$omp critical (gracecg_run_record)
        place = place_of(identity_of(trim(path)//UNFINISHED), [RESERVED])
        if (place > 0) then
            stream = files(place)%stream
            files = [files(:place - 1), files(place + 1:)]
        end if
        !$omp end critical (gracecg_run_record)
    end subroutine take_reserved

    !> The command line of this run, each input with its hash, and the commit; nothing when no record is kept.
    subroutine get_provenance(command_line, inputs, commit_of_sources)
        character(:), allocatable, intent(out) :: command_line      !! Empty: no record is kept
        type(string_t), allocatable, intent(out) :: inputs(:)       !! 'run1/sca1.csv fnv1a 85944171F73967E8'
        character(:), allocatable, intent(out) :: commit_of_sources     !! Of the program; empty where it is not known

        integer :: i

        command_line = ''
        commit_of_sources = ''
        allocate (inputs(0))
        if (.not. allocated(files)) return
        command_line = command
        commit_of_sources = commit
        do i = 1, size(files)
            if (files(i)%hash /= '') call append(inputs, files(i)%path//' fnv1a '//files(i)%hash)
        end do
    end subroutine get_provenance

    !> FNV-1a, 64 bits: h = (h xor byte) * (2^40 + 435) mod 2^64, in halves of 32 bits so that no sum overflows.
    pure subroutine add_to_hash(bytes, hash)
        character(*), intent(in) :: bytes       !! That follow
        integer(i8), intent(inout) :: hash      !! Begins with EMPTY_HASH

        integer(i8), parameter :: LOW_HALF = int(z'FFFFFFFF', i8), LOW_24 = int(z'FFFFFF', i8), FACTOR = 435
        integer(i8) :: low, high
        integer :: i

        do i = 1, len(bytes)
            low = ieor(iand(hash, LOW_HALF), iachar(bytes(i:i), i8))
            high = ishft(hash, -32)*FACTOR + ishft(iand(low, LOW_24), 8)
            low = low*FACTOR
            hash = ior(ishft(high + ishft(low, -32), 32), iand(low, LOW_HALF))
        end do
    end subroutine add_to_hash

    !> The last file of this run that is a given one, in one of some roles, and is still there under its path; 0: none.
    integer function place_of(identity, roles) result(place)
        integer(c_int), intent(in) :: identity(IDENTITY_WORDS)
        integer, intent(in) :: roles(:)

        do place = size(files), 1, -1
            if (.not. is_same(files(place)%identity, identity) .or. all(roles /= files(place)%role)) cycle
            if (files(place)%role == RESERVED .or. is_same(identity_of(files(place)%path), identity)) return
        end do
    end function place_of

    subroutine fail_as_input(output, input_path, error)
        character(*), intent(in) :: output, input_path      !! Paths of one file
        type(error_t), allocatable, intent(out) :: error

        call fail(error, trim(output)//': this command reads this file, as '//trim(input_path)// &
                  ', and would destroy it; name another file for the output')
    end subroutine fail_as_input
end module gracecg_files_run_record
