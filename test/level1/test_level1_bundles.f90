!> Level-1 files as data centres give them out: bundles, compressed files, folders in folders, releases, parts.
module test_level1_bundles
    use vocabulary
    use gracecg_files_file, only: text_file_t, read_text_file
    use gracecg_files_run_record, only: begin_record, end_record, get_provenance
    use gracecg_level1_bundles, only: find_level1_files, level1_stream_t
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_estimation, only: estimate_level1
    use gracecg_level1_gathering, only: gather_calibration
    use gracecg_level1_outcome, only: level1_estimate_t
    use command_fixture, only: succeeds
    use level1_day, only: flaws_t, setup_said, day_fails, says
    implicit none
    private
    public :: collect_level1_bundles

    character(*), parameter :: PLACE = FOLDER//'l1_shipped'

contains

    subroutine collect_level1_bundles(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('as-shipped', test_shipped), &
                    new_unittest('streams', test_streams), &
                    new_unittest('hashes', test_hashes), &
                    new_unittest('long-names', test_long_names), &
                    new_unittest('broken-bundles', test_broken)]
    end subroutine collect_level1_bundles

    !> A day in bundles, compressed, in two parts, with an older release, reports and other products beside, gives to the last
    !> bit what its files give; `list` and `check` take the same places.
    subroutine test_shipped(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_calibration_t) :: whole, shipped
        type(level1_estimate_t) :: expected, found
        type(error_t), allocatable :: failure
        character(:), allocatable :: output, messages

        if (day_fails(error, 'l1_unshipped', flaws_t(spans=2, leakage=1e-12_dp), setup_said(), whole, &
                      expected)) return
        call shell('rm -rf '//PLACE//' && mkdir -p '//PLACE//'/1B/deep && cp '//FOLDER//'l1_unshipped/* '//PLACE// &
                   ' && cd '//PLACE//' && rm -f *.nml && tar czf a_1A.tgz ACC1A* SOE.txt && rm ACC1A* SOE.txt'// &
                   ' && tar cf 1B/deep/b.tar CLK1B* MAG1B* && rm CLK1B* MAG1B* && gzip SCA1B*'// &
                   ' && for f in GNV1B*; do cp $f 1B/${f%_04.txt}_03.txt; done'// &
                   ' && f=$(ls GNI1B*) && split_at=$(grep -n "# End of YAML" $f | cut -d: -f1)'// &
                   ' && n=$(wc -l < $f) && m=$(( (n + split_at)/2 ))'// &
                   ' && head -n $m $f > ${f%.txt}_1.txt && (head -n $split_at $f; tail -n +$((m + 1)) $f) > ${f%.txt}_2.txt'// &
                   ' && rm $f && echo report > ACC1A_2020-02-01_C_04.rpt && echo x > KBR1B_2020-02-01_X_04.txt', error)
        if (allocated(error)) return
        call gather_calibration([PLACE], setup_said(), '', '', reshape([real(dp) ::], [2, 0]), 'model', shipped, failure)
        if (.not. allocated(failure)) call estimate_level1(shipped, setup_said(), 'estimate', found, failure)
        if (failed(error, failure)) return
        call check(error, all(abs(found%solutions(1)%offset - expected%solutions(1)%offset) <= 0) .and. &
                   all(abs(found%solutions(1)%covariance - expected%solutions(1)%covariance) <= 0), 'the same')
        call check(error, says(shipped%notes, 'GNV1B_2020-02-01_C_03.txt has the newer release GNV1B_2020-02-01_C_04.txt, '// &
                               'which is taken'), 'releases')
        call gather_calibration([character(80) :: PLACE//'/a_1A.tgz', PLACE//'/1B', FOLDER//'l1_unshipped'], setup_said(), '', &
                                '', reshape([real(dp) ::], [2, 0]), 'model', shipped, failure)
        call check_passes(error, failure)
        call succeeds(error, 'level1 list '//PLACE, output, messages)
        call check_says(error, output, 'MAG1B')
        call succeeds(error, 'level1 check '//PLACE, output, messages)
        call check_says(error, output, 'acc1a_samples')
    end subroutine test_shipped

    !> The bytes of a file, whatever it is in, in pieces of any length; and none behind the end.
    subroutine test_streams(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: TEXT = 'one'//achar(10)//'two'//achar(10)
        character(24), parameter :: PATHS(4) = [character(24) :: 'stream.txt', 'stream.txt.gz', 'stream.tar/stream.txt', &
                                                'stream.tar.gz/stream.txt']
        type(level1_stream_t) :: stream
        type(error_t), allocatable :: failure
        character(3) :: piece
        character(:), allocatable :: all_bytes
        integer :: i, count

        call make_file('stream.txt', TEXT)
        call make_file('behind.txt', repeat('x', 2000))
        if (.not. allocated(error)) call shell('cd '//FOLDER//' && gzip -kf stream.txt && '// &
            'tar cf stream.tar behind.txt stream.txt behind.txt && tar czf stream.tar.gz behind.txt stream.txt', error)
        if (allocated(error)) return
        do i = 1, size(PATHS)
            call stream%open(FOLDER//trim(PATHS(i)), failure)
            all_bytes = ''
            count = 1
            do while (count > 0 .and. .not. allocated(failure))
                call stream%read(piece, count, failure)
                all_bytes = all_bytes//piece(:count)
            end do
            call check_passes(error, failure)
            call check(error, all_bytes, TEXT)
        end do
        call stream%close()
    end subroutine test_streams

    !> Of what was read in a bundle the hash is that of the whole bundle, counted once.
    subroutine test_hashes(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_stream_t) :: stream
        type(string_t), allocatable :: inputs(:)
        type(error_t), allocatable :: failure
        character(:), allocatable :: command_line, commit
        character(100) :: bytes
        integer :: i, count

        call make_file('hashed.txt', 'foobar')
        if (.not. allocated(error)) call shell('cd '//FOLDER//' && tar cf hashed.tar hashed.txt', error)
        if (allocated(error)) return
        call begin_record('test')
        do i = 1, 2     ! twice: it is counted once
            call stream%open(FOLDER//'hashed.tar/hashed.txt', failure)
            if (.not. allocated(failure)) call stream%read(bytes, count, failure)
        end do
        call get_provenance(command_line, inputs, commit)
        call end_record()
        call check_passes(error, failure)
        if (unmet(error, size(inputs), 1)) return
        call check(error, index(inputs(1)%text, FOLDER//'hashed.tar fnv1a ') == 1, inputs(1)%text)
        call check(error, hash_of(FOLDER//'hashed.tar') == inputs(1)%text(len(inputs(1)%text) - 15:), inputs(1)%text)

    contains

        !> That of a file read by itself.
        function hash_of(path) result(text)
            character(*), intent(in) :: path
            character(16) :: text

            type(text_file_t) :: file
            type(string_t), allocatable :: alone(:)

            call begin_record('test')
            call read_text_file(path, file, failure)
            call get_provenance(command_line, alone, commit)
            call end_record()
            text = alone(1)%text(len(alone(1)%text) - 15:)
        end function hash_of
    end subroutine test_hashes

    !> Names of more than 100 letters, by GNU and by POSIX, and folders in the bundle.
    subroutine test_long_names(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: DEEP = repeat('d', 70)//'/'//repeat('e', 70)
        character(5), parameter :: FORMS(2) = [character(5) :: 'gnu', 'ustar']
        type(string_t), allocatable :: paths(:)
        type(level1_stream_t) :: stream
        type(error_t), allocatable :: failure
        character(4) :: bytes
        integer :: i, count

        do i = 1, size(FORMS)
            call shell('cd '//FOLDER//' && mkdir -p '//DEEP//' && echo abc > '//DEEP//'/f.txt && tar --format='//trim(FORMS(i))// &
                       ' -cf deep.tar '//DEEP(:70), error)
            if (allocated(error)) return
            if (allocated(paths)) deallocate (paths)
            allocate (paths(0))
            call find_level1_files(FOLDER//'deep.tar', paths, failure)
            call check_passes(error, failure)
            if (unmet(error, size(paths) == 1)) return
            call check(error, paths(1)%text, FOLDER//'deep.tar/'//DEEP//'/f.txt')
            call stream%open(paths(1)%text, failure)
            if (.not. allocated(failure)) call stream%read(bytes, count, failure)
            call check_passes(error, failure)
            call check(error, bytes, 'abc'//achar(10))
        end do
    end subroutine test_long_names

    !> Bundles and compressed files that are cut off, are none, or have not what is wanted, fail by name.
    subroutine test_broken(error)
        type(error_type), allocatable, intent(out) :: error

        call shell('cd '//FOLDER//' && head -c 30000 /dev/urandom > noise.txt && tar czf noise.tgz noise.txt && '// &
                   'head -c 20000 noise.tgz > cut.tgz && gzip -kf noise.txt && head -c 20000 noise.txt.gz > cut.txt.gz && '// &
                   'tar cf whole.tar noise.txt && head -c 20000 whole.tar > cut.tar && cp noise.txt none.tar', error)
        call read_all('cut.tgz/noise.txt', 'cut.tgz: is broken, or not whole')
        call read_all('cut.txt.gz', 'cut.txt.gz: is broken, or not whole')
        call read_all('cut.tar/noise.txt', 'cut.tar: is not whole')
        call read_all('none.tar/noise.txt', 'none.tar: is no tar file, or broken, at byte 0')
        call read_all('noise.tgz/other.txt', 'noise.tgz/other.txt: no such file in the bundle')
        call read_all('no-such.tgz/noise.txt', 'no-such.tgz/noise.txt: no such file')

    contains

        subroutine read_all(path, message)
            character(*), intent(in) :: path, message
            type(level1_stream_t) :: stream
            type(error_t), allocatable :: failure
            character(1000) :: bytes
            integer :: count

            count = 1
            call stream%open(FOLDER//path, failure)
            do while (count > 0 .and. .not. allocated(failure))
                call stream%read(bytes, count, failure)
            end do
            call check_says(error, message_of(failure), message)
        end subroutine read_all
    end subroutine test_broken

    !> Runs a line of the shell, which has to succeed.
    subroutine shell(line, error)
        character(*), intent(in) :: line
        type(error_type), allocatable, intent(inout) :: error
        integer :: status

        call execute_command_line(line, exitstat=status)
        call check(error, status, 0)
    end subroutine shell
end module test_level1_bundles
