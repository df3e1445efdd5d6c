!> Reading and writing files, and what can go wrong there.
module test_file
    use vocabulary
    use gracecg_base_kinds, only: i8
    use gracecg_files_file
    use gracecg_files_settings, only: settings_t
    use gracecg_files_run_record, only: begin_record, end_record, note_file, UPDATED
    implicit none
    private
    public :: collect_file

    character(*), parameter :: LF = achar(10), CR = achar(13)

contains

    subroutine collect_file(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('lines-of-a-text', test_lines), &
                    new_unittest('read-a-file', test_read), &
                    new_unittest('read-fails', test_read_fails), &
                    new_unittest('too-long-a-file', test_too_long), &
                    new_unittest('make-directory', test_make_directory), &
                    new_unittest('make-directory-fails', test_make_directory_fails), &
                    new_unittest('write-appears-at-commit', test_commit), &
                    new_unittest('write-discarded', test_discard), &
                    new_unittest('write-abandoned', test_finaliser), &
                    new_unittest('two-writers', test_two_writers), &
                    new_unittest('left-of-a-killed-run', test_left), &
                    new_unittest('permissions-stay', test_permissions), &
                    new_unittest('output-that-is-an-input', test_output_as_input), &
                    new_unittest('two-outputs-of-one-name', test_two_outputs), &
                    new_unittest('names-kept-for-a-run', test_kept), &
                    new_unittest('what-a-file-was-made-of', test_about), &
                    new_unittest('write-cannot-open', test_open_fails), &
                    new_unittest('write-cannot-rename', test_rename_fails), &
                    new_unittest('write-disk-full', test_disk_full)]
    end subroutine collect_file

    subroutine test_lines(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: file

        file = text_file_of('one'//CR//LF//LF//CR//LF//'four', 'memory')
        call check(error, file%line_count(), 4)
        call check(error, file%line(1)//'|'//file%line(2)//'|'//file%line(3)//'|'//file%line(4), &
                   'one|||four')
        call check(error, file%line(0)//file%line(5), '')
        file = text_file_of('a'//LF, 'memory')
        call check(error, file%line_count(), 1)
        file = text_file_of('', 'memory')
        call check(error, file%line_count(), 0)
        file = text_file_of(char(239)//char(187)//char(191)//'marked', 'memory')
        call check(error, file%line(1), 'marked')
    end subroutine test_lines

    !> Longer than the pieces in which a file is read.
    subroutine test_read(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 300000
        type(text_file_t) :: file
        type(error_t), allocatable :: failure

        call make_file('read.txt', 'first'//LF//'second')
        call read_text_file(FOLDER//'read.txt  ', file, failure)
        call check_passes(error, failure)
        call check(error, file%name//' '//file%line(2), FOLDER//'read.txt second')
        call make_file('long.txt', repeat('0123456789'//LF, N))
        call read_text_file(FOLDER//'long.txt', file, failure)
        call check_passes(error, failure)
        call check(error, file%line_count(), N)
        call check(error, file%line(N), '0123456789')
    end subroutine test_read

    subroutine test_read_fails(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: file
        type(error_t), allocatable :: failure

        call read_text_file(FOLDER//'missing.txt', file, failure)
        call check_fails(error, failure, FOLDER//'missing.txt ... no such file')
        call read_text_file('build', file, failure)
        call check_fails(error, failure, 'build: is a folder')
        call read_text_file('', file, failure)
        call check_fails(error, failure, 'name of the file is empty')
        if (allocated(error) .or. .not. file_exists('/proc/self/mem')) return
        ! A file that opens, but whose first byte cannot be read
        call read_text_file('/proc/self/mem', file, failure)
        call check_fails(error, failure, '/proc/self/mem ... cannot be read')
    end subroutine test_read_fails

    !> Files with holes, which take no room on the disk: refused by their size, of a device without one after as many bytes.
    subroutine test_too_long(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: file
        type(settings_t) :: settings
        type(error_t), allocatable :: failure

        call make_hollow(2_i8**30 + 1)
        call read_text_file(FOLDER//'hollow.txt', file, failure)
        call check_fails(error, failure, 'hollow.txt ... longer than 1024 MB')
        call make_hollow(2_i8**20)
        call read_text_file(FOLDER//'hollow.txt', file, failure, 1)
        call check_passes(error, failure)
        call make_hollow(2_i8**24 + 1)
        call settings%open(FOLDER//'hollow.txt', failure)
        call check_fails(error, failure, 'hollow.txt ... longer than 16 MB')
        call remove_file(FOLDER//'hollow.txt')
        if (.not. file_exists('/dev/zero')) return
        call read_text_file('/dev/zero', file, failure, 1)
        call check_fails(error, failure, '/dev/zero ... longer than 1 MB')

    contains

        subroutine make_hollow(length)
            integer(i8), intent(in) :: length       ! bytes
            integer :: unit

            open (newunit=unit, file=FOLDER//'hollow.txt', access='stream', form='unformatted', status='replace')
            write (unit, pos=length) LF
            close (unit)
        end subroutine make_hollow
    end subroutine test_too_long

    subroutine test_make_directory(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure

        call make_directory(FOLDER//'deep/deeper//deepest/', failure)
        call check_passes(error, failure)
        call check(error, directory_exists(FOLDER//'deep/deeper/deepest'))
        call make_directory(FOLDER//'deep', failure)
        if (failed(error, failure)) return
        call make_directory('.', failure)
        call check_passes(error, failure)
        call remove_file(FOLDER//'deep/deeper/deepest')
        call remove_file(FOLDER//'deep/deeper')
        call remove_file(FOLDER//'deep')
        call check(error, .not. directory_exists(FOLDER//'deep'))
    end subroutine test_make_directory

    subroutine test_make_directory_fails(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure

        call make_file('in-the-way', 'x')
        call make_directory(FOLDER//'in-the-way', failure)
        call check_fails(error, failure, FOLDER//'in-the-way ... a file of that name')
        call make_directory(FOLDER//'in-the-way/below', failure)
        call check_fails(error, failure, FOLDER//'in-the-way ... a file of that name')
        call make_directory('', failure)
        call check_fails(error, failure, 'name of the folder is empty')
        ! Nobody may make a folder there
        call make_directory('/proc/gracecg', failure)
        call check_fails(error, failure, '/proc ... permissions')
    end subroutine test_make_directory_fails

    subroutine test_commit(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure

        call make_file('out.txt', 'old')
        call output%open(FOLDER//'out.txt', failure)
        if (failed(error, failure)) return
        call output%line('new')
        call output%line('')
        call check_content(error, 'out.txt', 'old')
        call output%commit(failure)
        if (failed(error, failure)) return
        call check_content(error, 'out.txt', 'new'//LF//LF)
        call check(error, .not. file_exists(FOLDER//'out.txt.part1'))
        call output%commit(failure)
        call check_fails(error, failure, 'closed already')
    end subroutine test_commit

    subroutine test_discard(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure

        call output%open(FOLDER//'discarded.txt', failure)
        call check(error, file_exists(FOLDER//'discarded.txt.part1'))
        call output%discard()
        call check(error, .not. (file_exists(FOLDER//'discarded.txt') .or. &
                                file_exists(FOLDER//'discarded.txt.part1')))
    end subroutine test_discard

    !> A writer that goes out of scope uncommitted leaves nothing.
    subroutine test_finaliser(error)
        type(error_type), allocatable, intent(out) :: error

        call abandon()
        call check(error, .not. (file_exists(FOLDER//'abandoned.txt') .or. &
                                file_exists(FOLDER//'abandoned.txt.part1')))

    contains

        subroutine abandon()
            type(output_file_t) :: output
            type(error_t), allocatable :: failure

            call output%open(FOLDER//'abandoned.txt', failure)
            call output%line('half')
        end subroutine abandon
    end subroutine test_finaliser

    !> Of two writers of one name the second is refused, until the first has ended.
    subroutine test_two_writers(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: one, two
        type(error_t), allocatable :: failure

        call one%open(FOLDER//'shared.txt', failure)
        call two%open(FOLDER//'./shared.txt', failure)
        call check_fails(error, failure, 'shared.txt ... is writing this file ... part1')
        call one%line('one')
        call one%commit(failure)
        if (failed(error, failure)) return
        call check_content(error, 'shared.txt', 'one'//LF)
        call remove_file(FOLDER//'shared.txt')
        call two%open(FOLDER//'shared.txt', failure)
        call check_passes(error, failure)
        call two%discard()
    end subroutine test_two_writers

    !> What a program that was killed has left goes with the next one that writes the file; a link of its name leads nowhere.
    subroutine test_left(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure

        call make_file('left.txt.part1', 'half of a line that is longer')
        call output%open(FOLDER//'left.txt', failure)
        call output%line('whole')
        call output%commit(failure)
        call check_passes(error, failure)
        call check_content(error, 'left.txt', 'whole'//LF)
        call check(error, .not. file_exists(FOLDER//'left.txt.part1'))
        call make_file('other.txt', 'other')
        call execute_command_line('ln -s other.txt '//FOLDER//'left.txt.part1')
        call output%open(FOLDER//'left.txt', failure)
        call output%line('more')
        call output%commit(failure)
        call check_content(error, 'other.txt', 'other')
        call remove_file(FOLDER//'other.txt')
        call remove_file(FOLDER//'left.txt')
    end subroutine test_left

    !> A file that is replaced keeps its permissions.
    subroutine test_permissions(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure
        integer :: status

        call make_file('private.txt', 'old')
        call execute_command_line('chmod 640 '//FOLDER//'private.txt')
        call output%open(FOLDER//'private.txt', failure)
        call output%commit(failure)
        call check_passes(error, failure)
        call execute_command_line('test -n "$(find '//FOLDER//'private.txt -perm 640)"', exitstat=status)
        call remove_file(FOLDER//'private.txt')
        call check(error, status, 0)
    end subroutine test_permissions

    !> While a record is kept nothing is written in the place of an input, by whatever path or link.
    subroutine test_output_as_input(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: NAMES(4) = [character(20) :: 'in.txt', './in.txt', 'hard.txt', 'soft.txt']
        type(output_file_t) :: output
        type(input_stream_t) :: stream
        type(text_file_t) :: file
        type(error_t), allocatable :: failure
        integer :: i

        call make_file('in.txt', 'input')
        call execute_command_line('cd '//FOLDER//' && ln -f in.txt hard.txt && ln -sf in.txt soft.txt')
        call begin_record('test')
        call read_text_file(FOLDER//'in.txt', file, failure)
        do i = 1, size(NAMES)
            call output%open(FOLDER//NAMES(i), failure)
            call check(error, index(message_of(failure), FOLDER//trim(NAMES(i))//': ') == 1)
            call check_fails(error, failure, 'reads this file ... name another file')
            call check_writable(FOLDER//NAMES(i), failure)
            call check_fails(error, failure, 'reads this file')
        end do
        call begin_record('test')       ! the output is named first
        call check_writable(FOLDER//'soft.txt', failure)
        call check_passes(error, failure)
        call read_text_file(FOLDER//'in.txt', file, failure)
        call check_fails(error, failure, 'soft.txt ... in.txt ... reads this file')
        call stream%open(FOLDER//'hard.txt', failure)
        call check_fails(error, failure, 'soft.txt ... hard.txt ... reads this file')
        call begin_record('test')       ! what is to be brought up to date
        call note_file(FOLDER//'in.txt', UPDATED)
        call check_writable(FOLDER//'in.txt', failure)
        call read_text_file(FOLDER//'in.txt', file, failure)
        call check_passes(error, failure)
        call end_record()
        call output%open(FOLDER//'in.txt', failure)
        call check_passes(error, failure)
        call output%discard()
        do i = size(NAMES), 1, -1
            call remove_file(FOLDER//NAMES(i))
        end do
    end subroutine test_output_as_input

    !> Two outputs of a run have two names; what a run has written it does not write again.
    subroutine test_two_outputs(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure

        call begin_record('test')
        call check_writable(FOLDER//'two.txt', failure)
        call check_writable(FOLDER//'./two.txt', failure)
        call check_fails(error, failure, 'two.txt ... two outputs')
        call output%open(FOLDER//'two.txt', failure)
        call output%commit(failure)
        call check_passes(error, failure)
        call output%open(FOLDER//'./two.txt', failure)
        call check_fails(error, failure, 'two.txt ... written this file already')
        call end_record()
        call remove_file(FOLDER//'two.txt')
    end subroutine test_two_outputs

    !> A name is kept until the run ends, and nothing is left of it then.
    subroutine test_kept(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure
        integer :: status

        call begin_record('test')
        call check_writable(FOLDER//'kept.txt', failure)
        call check_passes(error, failure)
        call execute_command_line('flock -n '//FOLDER//'kept.txt.part1 true', exitstat=status)
        call check(error, status /= 0, 'another program may write it')
        call end_record()
        call check(error, .not. (file_exists(FOLDER//'kept.txt') .or. file_exists(FOLDER//'kept.txt.part1')))
    end subroutine test_kept

    !> Command line and inputs with their hashes: those of FNV-1a that Fowler, Noll and Vo publish.
    subroutine test_about(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(input_stream_t) :: stream
        type(text_file_t) :: file
        type(error_t), allocatable :: failure
        character(6) :: bytes
        integer :: count

        call make_file('a.txt', 'a')
        call make_file('foobar.txt', 'foobar')
        call begin_record('gracecg test a.txt', 'abc123')
        call read_text_file(FOLDER//'a.txt', file, failure)
        call stream%open(FOLDER//'foobar.txt', failure)
        call stream%read(bytes, count, failure)
        call stream%read(bytes, count, failure)
        call output%open(FOLDER//'about.txt', failure)
        call output%about('!')
        call output%commit(failure)
        call end_record()
        call read_text_file(FOLDER//'about.txt', file, failure)
        call check_passes(error, failure)
        call check(error, index(file%line(1), '! gracecg ') == 1 .and. index(file%line(1), ' abc123: gracecg test a.txt') > 0)
        call check(error, file%line(2), '! inputs: '//FOLDER//'a.txt fnv1a AF63DC4C8601EC8C; '//FOLDER// &
                   'foobar.txt fnv1a 85944171F73967E8')
    end subroutine test_about

    subroutine test_open_fails(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure

        call output%open('build/no-such-folder/a.txt', failure)
        call check_fails(error, failure, 'build/no-such-folder/a.txt ... no folder build/no-such-folder')
        call output%open('build', failure)
        call check_fails(error, failure, 'build ... is a folder')
        call output%open('', failure)
        call check_fails(error, failure, 'empty')
        if (allocated(error) .or. .not. directory_exists('/proc')) return
        call output%open('/proc/gracecg.txt', failure)
        call check_fails(error, failure, '/proc/gracecg.txt ... permissions')
    end subroutine test_open_fails

    subroutine test_rename_fails(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure

        call output%open(FOLDER//'taken', failure)
        call make_directory(FOLDER//'taken', failure)
        call output%commit(failure)
        call remove_file(FOLDER//'taken')
        call check_fails(error, failure, FOLDER//'taken ... could not be given its name')
        call check(error, .not. file_exists(FOLDER//'taken.part1'))
    end subroutine test_rename_fails

    !> /dev/full is a device on which every write fails.
    subroutine test_disk_full(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure

        if (.not. file_exists('/dev/full')) then
            call skip_test(error, 'there is no /dev/full')
            return
        end if
        call output%open('/dev/full', failure)
        if (failed(error, failure)) return
        call output%line('x')
        call output%commit(failure)
        call check_fails(error, failure, '/dev/full ... free space')
        call check(error, file_exists('/dev/full'), 'the device is gone')
    end subroutine test_disk_full
end module test_file
