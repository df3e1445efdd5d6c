!> Reading and writing files, and what can go wrong there.
module test_file
    use gracecg_base_error, only: error_t, message_of
    use gracecg_files_file
    use fixture, only: check, FOLDER, make_folder, make_file, check_fails, check_passes
    use testdrive, only: new_unittest, unittest_type, error_type, skip_test
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
                    new_unittest('read-a-long-file', test_read_long), &
                    new_unittest('read-fails', test_read_fails), &
                    new_unittest('make-directory', test_make_directory), &
                    new_unittest('make-directory-fails', test_make_directory_fails), &
                    new_unittest('write-appears-at-commit', test_commit), &
                    new_unittest('write-discarded', test_discard), &
                    new_unittest('write-abandoned', test_finaliser), &
                    new_unittest('two-writers', test_two_writers), &
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

    subroutine test_read(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: file
        type(error_t), allocatable :: failure

        call make_file(error, 'read.txt', 'first'//LF//'second')
        if (allocated(error)) return
        call read_text_file(FOLDER//'read.txt  ', file, failure)
        call remove_file(FOLDER//'read.txt')
        call check_passes(error, message_of(failure))
        call check(error, file%name//' '//file%line(2), FOLDER//'read.txt second')
    end subroutine test_read

    !> Longer than the pieces in which a file is read.
    subroutine test_read_long(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: file
        type(error_t), allocatable :: failure
        integer, parameter :: N = 300000

        call make_file(error, 'long.txt', repeat('0123456789'//LF, N))
        if (allocated(error)) return
        call read_text_file(FOLDER//'long.txt', file, failure)
        call remove_file(FOLDER//'long.txt')
        call check_passes(error, message_of(failure))
        call check(error, file%line_count(), N)
        call check(error, file%line(N), '0123456789')
    end subroutine test_read_long

    subroutine test_read_fails(error)
        type(error_type), allocatable, intent(out) :: error
        type(text_file_t) :: file
        type(error_t), allocatable :: failure

        call read_text_file(FOLDER//'missing.txt', file, failure)
        call check_fails(error, message_of(failure), &
                         [character(40) :: FOLDER//'missing.txt', 'no such file'])
        call read_text_file('build', file, failure)
        call check_fails(error, message_of(failure), [character(40) :: 'build: is a folder'])
        call read_text_file('', file, failure)
        call check_fails(error, message_of(failure), [character(40) :: 'name of the file is empty'])
        if (allocated(error) .or. .not. file_exists('/proc/self/mem')) return
        ! A file that opens, but whose first byte cannot be read
        call read_text_file('/proc/self/mem', file, failure)
        call check_fails(error, message_of(failure), &
                         [character(40) :: '/proc/self/mem', 'cannot be read'])
    end subroutine test_read_fails

    subroutine test_make_directory(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure

        call make_directory(FOLDER//'deep/deeper//deepest/', failure)
        call check_passes(error, message_of(failure))
        call check(error, directory_exists(FOLDER//'deep/deeper/deepest'))
        call make_directory(FOLDER//'deep', failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call make_directory('.', failure)
        call check_passes(error, message_of(failure))
        call remove_file(FOLDER//'deep/deeper/deepest')
        call remove_file(FOLDER//'deep/deeper')
        call remove_file(FOLDER//'deep')
        if (allocated(error)) return
        call check(error,.not. directory_exists(FOLDER//'deep'))
    end subroutine test_make_directory

    subroutine test_make_directory_fails(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure

        call make_file(error, 'in-the-way', 'x')
        if (allocated(error)) return
        call make_directory(FOLDER//'in-the-way', failure)
        call check_fails(error, message_of(failure), &
                         [character(40) :: FOLDER//'in-the-way', 'a file of that name'])
        if (.not. allocated(error)) then
            call make_directory(FOLDER//'in-the-way/below', failure)
            call check_fails(error, message_of(failure), &
                             [character(40) :: FOLDER//'in-the-way', 'a file of that name'])
        end if
        call remove_file(FOLDER//'in-the-way')
        if (allocated(error)) return
        call make_directory('', failure)
        call check_fails(error, message_of(failure), &
                         [character(40) :: 'name of the folder is empty'])
        ! Nobody may make a folder there
        call make_directory('/proc/gracecg', failure)
        call check_fails(error, message_of(failure), [character(40) :: '/proc', 'permissions'])
    end subroutine test_make_directory_fails

    subroutine test_commit(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(text_file_t) :: file
        type(error_t), allocatable :: failure

        call make_file(error, 'out.txt', 'old')
        if (allocated(error)) return
        call output%open(FOLDER//'out.txt', failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call output%line('new')
        call output%line('')
        call read_text_file(FOLDER//'out.txt', file, failure)
        call check(error, file%text, 'old')
        call output%commit(failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call read_text_file(FOLDER//'out.txt', file, failure)
        call check(error, file%text, 'new'//LF//LF)
        call check(error,.not. file_exists(FOLDER//'out.txt.part1'))
        call remove_file(FOLDER//'out.txt')
        if (allocated(error)) return
        call output%commit(failure)
        call check_fails(error, message_of(failure), [character(40) :: 'closed already'])
    end subroutine test_commit

    subroutine test_discard(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure

        call make_folder(error)
        if (allocated(error)) return
        call output%open(FOLDER//'discarded.txt', failure)
        call check(error, file_exists(FOLDER//'discarded.txt.part1'))
        call output%discard()
        call check(error,.not. (file_exists(FOLDER//'discarded.txt') .or. &
                                file_exists(FOLDER//'discarded.txt.part1')))
    end subroutine test_discard

    !> A writer that goes out of scope uncommitted leaves nothing.
    subroutine test_finaliser(error)
        type(error_type), allocatable, intent(out) :: error

        call make_folder(error)
        if (allocated(error)) return
        call abandon()
        call check(error,.not. (file_exists(FOLDER//'abandoned.txt') .or. &
                                file_exists(FOLDER//'abandoned.txt.part1')))

    contains

        subroutine abandon()
            type(output_file_t) :: output
            type(error_t), allocatable :: failure

            call output%open(FOLDER//'abandoned.txt', failure)
            call output%line('half')
        end subroutine abandon
    end subroutine test_finaliser

    !> Two writers of one name do not mix; the last to commit wins.
    subroutine test_two_writers(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: one, two
        type(text_file_t) :: file
        type(error_t), allocatable :: failure

        call make_folder(error)
        if (allocated(error)) return
        call one%open(FOLDER//'shared.txt', failure)
        call two%open(FOLDER//'shared.txt', failure)
        call two%line('two')
        call one%line('one')
        call two%commit(failure)
        call one%commit(failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call read_text_file(FOLDER//'shared.txt', file, failure)
        call remove_file(FOLDER//'shared.txt')
        call check(error, file%text, 'one'//LF)
    end subroutine test_two_writers

    subroutine test_open_fails(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure

        call output%open('build/no-such-folder/a.txt', failure)
        call check_fails(error, message_of(failure), &
                         [character(60) :: 'build/no-such-folder/a.txt', &
                          'no folder build/no-such-folder'])
        call output%open('build', failure)
        call check_fails(error, message_of(failure), [character(60) :: 'build', 'is a folder'])
        call output%open('', failure)
        call check_fails(error, message_of(failure), [character(60) :: 'empty'])
        if (allocated(error) .or. .not. directory_exists('/proc')) return
        call output%open('/proc/gracecg.txt', failure)
        call check_fails(error, message_of(failure), &
                         [character(60) :: '/proc/gracecg.txt', 'permissions'])
    end subroutine test_open_fails

    subroutine test_rename_fails(error)
        type(error_type), allocatable, intent(out) :: error
        type(output_file_t) :: output
        type(error_t), allocatable :: failure

        call make_folder(error)
        if (allocated(error)) return
        call output%open(FOLDER//'taken', failure)
        call make_directory(FOLDER//'taken', failure)
        call output%commit(failure)
        call remove_file(FOLDER//'taken')
        call check_fails(error, message_of(failure), &
                         [character(60) :: FOLDER//'taken', 'could not be given its name'])
        call check(error,.not. file_exists(FOLDER//'taken.part1'))
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
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call output%line('x')
        call output%commit(failure)
        call check_fails(error, message_of(failure), [character(60) :: '/dev/full', 'free space'])
        call check(error, file_exists('/dev/full'), 'the device is gone')
    end subroutine test_disk_full
end module test_file
