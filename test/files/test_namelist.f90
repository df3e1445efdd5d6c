!> Namelist files: the syntax, the typed values, and a message for every mistake.
module test_namelist
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, message_of
    use gracecg_files_file, only: remove_file
    use gracecg_files_namelist
    use fixture, only: FOLDER, make_folder, make_file, check_fails, check_passes
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_namelist

    character(*), parameter :: LF = achar(10), CR = achar(13)
    integer, parameter :: W = 80    !! Length of the parts of a message

    character(*), parameter :: SAMPLE = &
        '! a case'//LF// &                                              ! 1
        '&Spacecraft'//LF// &                                           ! 2
        '    Mass = 432.5, name=''front ! /''  ! kg'//LF// &            ! 3
        '    offset = 1d-4 2*0.0'//LF// &                               ! 4
        '    inertia ='//LF// &                                         ! 5
        '        1.0, 2.0,  ! first row'//LF// &                        ! 6
        '        3.0'//LF// &                                           ! 7
        '    drag = .TRUE., plates = 6,'//LF// &                        ! 8
        '    quote = "it''s", other = ''it''''s'''//LF// &              ! 9
        '/'//LF// &                                                     ! 10
        '&rod moment = -1.0 / &rod'//LF// &                             ! 11
        '    moment = 1.0 &end'                                         ! 12

contains

    subroutine collect_namelist(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('values', test_values), &
                    new_unittest('groups-of-one-name', test_groups), &
                    new_unittest('defaults', test_defaults), &
                    new_unittest('windows-line-ends', test_windows), &
                    new_unittest('fortran-reads-ours', test_fortran_reads), &
                    new_unittest('ours-reads-fortran', test_reads_fortran), &
                    new_unittest('syntax-errors', test_syntax_errors), &
                    new_unittest('missing', test_missing), &
                    new_unittest('wrong-real', test_wrong_real), &
                    new_unittest('wrong-reals', test_wrong_reals), &
                    new_unittest('wrong-integer', test_wrong_integer), &
                    new_unittest('wrong-logical', test_wrong_logical), &
                    new_unittest('wrong-text', test_wrong_text), &
                    new_unittest('reject', test_reject), &
                    new_unittest('endless-files', test_endless), &
                    new_unittest('long-lines', test_long_lines), &
                    new_unittest('unknown-key', test_unknown_key), &
                    new_unittest('unknown-group', test_unknown_group), &
                    new_unittest('files', test_files), &
                    new_unittest('write-and-read', test_write), &
                    new_unittest('writer-refuses', test_writer_refuses)]
    end subroutine collect_namelist

    !> Parses a text that must be right.
    subroutine parse(error, text, file)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: text
        type(namelist_file_t), intent(out) :: file
        type(error_t), allocatable :: failure

        call file%parse(text, 'case.nml', failure)
        call check_passes(error, message_of(failure))
    end subroutine parse

    subroutine test_values(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        real(dp) :: mass, offset(3), inertia(3)
        character(:), allocatable :: name, quote, other
        integer :: plates, rod
        logical :: drag
        real(dp) :: moment(2)

        call parse(error, SAMPLE, file)
        if (allocated(error)) return
        call file%get('spacecraft', 'MASS', mass, failure, low=1.0_dp, high=432.5_dp, unit='kg')
        if (.not. allocated(failure)) call file%get('spacecraft', 'name', name, failure)
        if (.not. allocated(failure)) call file%get('spacecraft', 'offset', offset, failure)
        if (.not. allocated(failure)) call file%get('spacecraft', 'inertia', inertia, failure)
        if (.not. allocated(failure)) call file%get('spacecraft', 'drag', drag, failure)
        if (.not. allocated(failure)) call file%get('spacecraft', 'plates', plates, failure, &
                                                    low=6, high=6)
        if (.not. allocated(failure)) call file%get('spacecraft', 'quote', quote, failure)
        if (.not. allocated(failure)) call file%get('spacecraft', 'other', other, failure)
        do rod = 1, 2
            if (.not. allocated(failure)) call file%get('rod', 'moment', moment(rod), failure, &
                                                        index=rod)
        end do
        if (.not. allocated(failure)) call file%check_all_used(failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, abs(mass - 432.5_dp) <= 0 .and. drag .and. plates == 6 .and. &
                   all(abs(offset - [1e-4_dp, 0.0_dp, 0.0_dp]) <= 0) .and. &
                   all(abs(inertia - [1.0_dp, 2.0_dp, 3.0_dp]) <= 0) .and. &
                   all(abs(moment - [-1.0_dp, 1.0_dp]) <= 0))
        if (allocated(error)) return
        call check(error, name//'|'//quote//'|'//other, 'front ! /|it''s|it''s')
    end subroutine test_values

    subroutine test_groups(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file

        call parse(error, SAMPLE, file)
        if (allocated(error)) return
        call check(error, file%group_count('rod'), 2)
        if (allocated(error)) return
        call check(error, file%group_count('SPACECRAFT'), 1)
        if (allocated(error)) return
        call check(error, file%group_count('none'), 0)
        if (allocated(error)) return
        call check(error, file%has('rod', 'Moment', index=2) .and. &
                   .not. file%has('rod', 'moment', index=3) &
                   .and. .not. file%has('rod', 'mass') .and. .not. file%has('none', 'mass'))
    end subroutine test_groups

    subroutine test_defaults(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        real(dp) :: x, v(2)
        integer :: i
        logical :: l
        character(:), allocatable :: t

        call parse(error, '&a /', file)
        if (allocated(error)) return
        call file%get('a', 'x', x, failure, default=1.5_dp)
        call file%get('a', 'v', v, failure, default=[1.0_dp, 2.0_dp])
        call file%get('b', 'i', i, failure, default=3)
        call file%get('a', 'l', l, failure, default=.true.)
        call file%get('a', 't', t, failure, default='text')
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, abs(x - 1.5_dp) <= 0 .and. abs(v(2) - 2) <= 0 .and. i == 3 .and. &
                   l .and. t == 'text')
    end subroutine test_defaults

    subroutine test_windows(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call parse(error, '&a'//CR//LF//'t = ''x'' ! note'//CR//LF//'/'//CR//LF, file)
        if (allocated(error)) return
        call file%get('a', 't', text, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, text, 'x')
    end subroutine test_windows

    !> What the writer makes, the compiler's namelist reader reads to the same values.
    subroutine test_fortran_reads(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_writer_t) :: writer
        type(error_t), allocatable :: failure
        real(dp) :: mass, offset(3)
        character(20) :: name
        logical :: drag
        integer :: plates, unit, status
        namelist /spacecraft/ mass, offset, name, drag, plates

        call writer%group('spacecraft')
        call writer%entry('mass', 0.1_dp, comment='kg')
        call writer%entry('offset', [1e-4_dp/3, -2e300_dp, 0.0_dp])
        call writer%entry('name', 'it''s')
        call writer%entry('drag', .true.)
        call writer%entry('plates', -6)
        call writer%end_group()
        call make_folder(error)
        if (allocated(error)) return
        call writer%save(FOLDER//'ours.nml', failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        open (newunit=unit, file=FOLDER//'ours.nml', status='old', action='read')
        read (unit, nml=spacecraft, iostat=status)
        close (unit, status='delete')
        call check(error, status, 0)
        if (allocated(error)) return
        call check(error, abs(mass - 0.1_dp) <= 0 .and. drag .and. plates == -6 .and. &
                   name == 'it''s' .and. all(abs(offset - [1e-4_dp/3, -2e300_dp, 0.0_dp]) <= 0))
    end subroutine test_fortran_reads

    !> What the compiler's namelist writer makes, ours reads.
    subroutine test_reads_fortran(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        real(dp) :: mass, offset(3), mass_read, offset_read(3)
        character(5) :: name
        character(:), allocatable :: name_read
        logical :: drag, drag_read
        integer :: unit
        namelist /spacecraft/ mass, offset, name, drag

        mass = 1/3.0_dp
        offset = [0.0_dp, 0.0_dp, -1e-90_dp]
        name = 'it''s'
        drag = .true.
        call make_folder(error)
        if (allocated(error)) return
        open (newunit=unit, file=FOLDER//'theirs.nml', status='replace', action='write', &
              delim='apostrophe')
        write (unit, nml=spacecraft)
        close (unit)
        call file%read(FOLDER//'theirs.nml', failure)
        call remove_file(FOLDER//'theirs.nml')
        if (.not. allocated(failure)) call file%get('spacecraft', 'mass', mass_read, failure)
        if (.not. allocated(failure)) call file%get('spacecraft', 'offset', offset_read, failure)
        if (.not. allocated(failure)) call file%get('spacecraft', 'name', name_read, failure)
        if (.not. allocated(failure)) call file%get('spacecraft', 'drag', drag_read, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, abs(mass_read - mass) <= 0 .and. &
                   all(abs(offset_read - offset) <= 0) .and. &
                   name_read == name .and. drag_read)
    end subroutine test_reads_fortran

    !> Every breach of the syntax, with the line where it is.
    subroutine test_syntax_errors(error)
        type(error_type), allocatable, intent(out) :: error

        call refused('', [character(W) :: 'case.nml', 'no group'])
        call refused('! only a comment', [character(W) :: 'case.nml', 'no group'])
        call refused('mass = 1'//LF//'&a /', [character(W) :: 'case.nml:1:', 'outside a group', &
                                              '| mass = 1'])
        call refused('&a /'//LF//'rest', [character(W) :: 'case.nml:2:', 'outside a group'])
        call refused('&a'//LF//' x = 1'//LF, [character(W) :: 'case.nml:1:', '&a', 'not ended', &
                                              '/'])
        call refused('&a'//LF//' x = 1'//LF//'&b'//LF//'/', [character(W) :: 'case.nml:1:', '&a', &
                                                             'not ended'])
        call refused('&'//LF//'/', [character(W) :: 'case.nml:1:', 'name of a group'])
        call refused('&1a /', [character(W) :: 'case.nml:1:', 'name of a group'])
        call refused('&a'//LF//' t = ''x'//LF//'/', [character(W) :: 'case.nml:2:', 'not ended', &
                                                     't = ''x'])
        call refused('&a'//LF//' t = "x'''//LF//'"/', [character(W) :: 'case.nml:2:', 'closing "'])
        call refused('&a'//LF//' x 1'//LF//'/', [character(W) :: 'case.nml:2:', 'no = after "x"'])
        call refused('&a'//LF//' x = 1'//LF//' mass 2'//LF//' y = 3 /', &
                     [character(W) :: 'case.nml:3:', '"mass"', '= is missing', '|  mass 2'])
        call refused('&a'//LF//' x ='//LF//' y = 3 /', [character(W) :: 'case.nml:2:', &
                                                        '"x" has no value'])
        call refused('&a'//LF//' x = /', [character(W) :: 'case.nml:2:', '"x" has no value'])
        call refused('&a'//LF//' x = = 3 /', [character(W) :: 'case.nml:2:', '"x" has no value'])
        call refused('&a'//LF//' = 3 /', [character(W) :: 'case.nml:2:', 'expected key = value'])
        call refused('&a'//LF//' ''x'' = 3 /', [character(W) :: 'case.nml:2:', &
                                                'expected key = value'])
        call refused('&a'//LF//' x = 1,,3 /', [character(W) :: 'case.nml:2:', 'value is missing'])
        call refused('&a'//LF//' x = ,3 /', [character(W) :: 'case.nml:2:', 'value is missing'])
        call refused('&a'//LF//' x = 3* /', [character(W) :: 'case.nml:2:', &
                                             'value is missing after "3*"'])
        call refused('&a'//LF//' x = 0*1 /', [character(W) :: 'case.nml:2:', '"0*1"', &
                                              'repeat count'])
        call refused('&a'//LF//' x = 2.5*1 /', [character(W) :: 'case.nml:2:', '"2.5*1"', &
                                                'repeat count'])
        call refused('&a'//LF//' x = 999999999*1 /', [character(W) :: 'case.nml:2:', &
                                                      'repeat count'])
        call refused('&a'//LF//' x(2) = 3 /', [character(W) :: 'case.nml:2:', '"x(2)"', 'index'])
        call refused('&a'//LF//' x%y = 3 /', [character(W) :: 'case.nml:2:', '"x%y"'])
        call refused('&a'//LF//' 2x = 3 /', [character(W) :: 'case.nml:2:', '"2x" cannot be a key'])
        call refused('&a'//LF//' x = 1'//LF//' X = 2 /', &
                     [character(W) :: 'case.nml:3:', '"x" stands twice', 'in line 2', '|  X = 2'])

    contains

        subroutine refused(text, parts)
            character(*), intent(in) :: text, parts(:)
            type(namelist_file_t) :: file
            type(error_t), allocatable :: failure

            if (allocated(error)) return
            call file%parse(text, 'case.nml', failure)
            call check_fails(error, message_of(failure), parts)
        end subroutine refused
    end subroutine test_syntax_errors

    !> Far more values, keys or groups than any file has are refused at once, not read in a time that grows with the
    !> square of their number.
    subroutine test_endless(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: MANY = 500000
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure

        call file%parse('&a x = '//repeat('1,', MANY)//'1 /', 'case.nml', failure)
        call check_fails(error, message_of(failure), [character(W) :: 'case.nml:1:', 'more than 1000 values'])
        if (allocated(error)) return
        call file%parse('&a x = 600*1, 600*1 /', 'case.nml', failure)
        call check_fails(error, message_of(failure), [character(W) :: 'case.nml:1:', 'more than 1000 values'])
        if (allocated(error)) return
        call file%parse(repeat('&a /'//LF, MANY), 'case.nml', failure)
        call check_fails(error, message_of(failure), [character(W) :: 'case.nml:1001:', 'more than 1000 groups'])
        if (allocated(error)) return
        call file%parse('&a'//LF//many_keys()//'/', 'case.nml', failure)
        call check_fails(error, message_of(failure), [character(W) :: 'case.nml:1002:', 'more than 1000 keys'])

    contains

        function many_keys() result(text)
            character(:), allocatable :: text

            character(16) :: line
            integer :: i

            allocate (character(16*2000) :: text)
            do i = 1, 2000
                write (line, '("k", i0.5, " = 1")') i
                line(16:) = LF
                text(16*i - 15:16*i) = line
            end do
        end function many_keys
    end subroutine test_endless

    !> Lines of 64 kB and of 10 MB: the time grows with the length and not with its square, which for a line 156 times as
    !> long would be hours. Messages show the beginning of such a line.
    subroutine test_long_lines(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: LENGTHS(2) = [64000, 10000000]
        character(6), parameter :: LINES(5) = [character(6) :: '&a x=''', '&a x=1', '&a !', '&a', '&a x=']
        character(4), parameter :: FILLING(5) = [character(4) :: '''''', ',', 'x', 'x', 'y=1,']
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        character(:), allocatable :: message, line
        integer(i8) :: before, after, rate
        integer :: i, k

        do i = 1, size(LINES)
            do k = 1, size(LENGTHS)
                ! Written in place: flang has the parts of such a text on the stack
                line = repeat(trim(FILLING(i)), LENGTHS(k)/len_trim(FILLING(i)))
                line(:8) = '  '//LINES(i)
                line(:8) = adjustr(line(:8))
                call system_clock(before, rate)
                call file%parse(line, 'case.nml', failure)
                call system_clock(after)
                message = message_of(failure)
                call check(error, message /= '' .and. len(message) < 3000, 'a line '//trim(LINES(i))//trim(FILLING(i)))
                if (.not. allocated(error)) &
                    call check(error, after - before < 10*rate, 'a line '//trim(LINES(i))//trim(FILLING(i))//' takes too long')
                if (allocated(error)) return
            end do
        end do
        call file%parse('&a x='''//repeat('''''', 500000)//''' /', 'case.nml', failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call file%get('a', 'x', message, failure)
        call check(error, len(message), 500000)
        if (.not. allocated(error)) call check(error, verify(message, ''''), 0)
    end subroutine test_long_lines

    subroutine test_missing(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        real(dp) :: x, v(3)
        character(:), allocatable :: text

        call parse(error, LF//'&craft'//LF//' mas = 1 /', file)
        if (allocated(error)) return
        call file%get('craft', 'mass', x, failure, low=1.0_dp, high=1e4_dp, unit='kg')
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:2:', '&craft', '"mass"', &
                          'a number from 1 to 10000 kg', '"mas" there a misspelling'])
        if (allocated(error)) return
        call file%get('craft', 'position', v, failure, unit='m')
        call check_fails(error, message_of(failure), &
                         [character(W) :: '"position"', '3 numbers', 'in m'])
        if (allocated(error)) return
        call file%get('field', 'model', text, failure, choices=[character(6) :: 'igrf95', 'none'])
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml: ', '&field is missing', '"model"', &
                          'one of igrf95, none'])
        if (allocated(error)) return
        call file%get('craft', 'mas', x, failure, index=2)
        call check_fails(error, message_of(failure), [character(W) :: '&craft number 2 is missing'])
    end subroutine test_missing

    subroutine test_wrong_real(error)
        type(error_type), allocatable, intent(out) :: error

        call refused('12x', [character(W) :: '"12x" is not a finite number'])
        call refused('1.2.3', [character(W) :: '"1.2.3" is not a finite number'])
        call refused('abc', [character(W) :: '"abc" is not a finite number'])
        call refused('NaN', [character(W) :: '"NaN" is not a finite number'])
        call refused('-Inf', [character(W) :: '"-Inf" is not a finite number'])
        call refused('''2''', [character(W) :: 'text in quotes'])
        call refused('.true.', [character(W) :: '".true."'])
        call refused('(1.0,2.0)', [character(W) :: '2 values'])
        call refused('1 2', [character(W) :: '2 values'])
        call refused('10.000000000000002', [character(W) :: '10.000000000000002 is outside'])
        call refused('0.999', [character(W) :: '0.999 is outside'])

    contains

        subroutine refused(value, parts)
            character(*), intent(in) :: value, parts(:)
            type(namelist_file_t) :: file
            type(error_t), allocatable :: failure
            real(dp) :: x

            if (allocated(error)) return
            call parse(error, '&craft'//LF//'mass = '//value//' /', file)
            if (allocated(error)) return
            call file%get('Craft', 'Mass', x, failure, low=1.0_dp, high=10.0_dp, unit='kg')
            call check_fails(error, message_of(failure), &
                             [character(W) :: 'case.nml:2:', 'key "mass" of group &craft', &
                              'a number from 1 to 10 kg', '| mass = ', parts])
            if (allocated(error)) return
            ! A default does not excuse a wrong value
            call file%get('craft', 'mass', x, failure, default=2.0_dp, low=1.0_dp, high=10.0_dp, &
                          unit='kg')
            call check_fails(error, message_of(failure), parts)
        end subroutine refused
    end subroutine test_wrong_real

    subroutine test_wrong_reals(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        real(dp) :: v(3)

        call parse(error, '&a'//LF//' few = 1 2'//LF//' many = 4*0.0'//LF//' bad = 1 2x 3'//LF// &
                   ' out = 0 0'//LF//'nan /', file)
        if (allocated(error)) return
        call file%get('a', 'few', v, failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:2:', '2 values', '3 numbers'])
        if (allocated(error)) return
        call file%get('a', 'many', v, failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:3:', '4 values', '3 numbers'])
        if (allocated(error)) return
        call file%get('a', 'bad', v, failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:4:', 'value 2', '"2x"'])
        if (allocated(error)) return
        call file%get('a', 'out', v, failure, low=0.0_dp)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:6:', 'value 3', '"nan"', 'at least 0'])
    end subroutine test_wrong_reals

    subroutine test_wrong_integer(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        integer :: n

        call parse(error, '&a'//LF//' real = 1.5'//LF//' long = 99999999999'//LF//' out = 71'// &
                   LF//' text = ''7'' /', file)
        if (allocated(error)) return
        call file%get('a', 'real', n, failure, low=0, high=70)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:2:', '"1.5" is not an integer', &
                          'from 0 to 70'])
        if (allocated(error)) return
        call file%get('a', 'long', n, failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:3:', '"99999999999"'])
        if (allocated(error)) return
        call file%get('a', 'out', n, failure, low=0, high=70)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:4:', '71 is outside', 'from 0 to 70'])
        if (allocated(error)) return
        call file%get('a', 'text', n, failure, high=70)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:5:', 'in quotes', 'at most 70'])
    end subroutine test_wrong_integer

    subroutine test_wrong_logical(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        logical :: l

        call parse(error, '&a'//LF//' number = 1'//LF//' text = ''true''/', file)
        if (allocated(error)) return
        call file%get('a', 'number', l, failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:2:', '"1"', '.true. or .false.'])
        if (allocated(error)) return
        call file%get('a', 'text', l, failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:3:', 'quotes', '.true. or .false.'])
    end subroutine test_wrong_logical

    subroutine test_wrong_text(error)
        type(error_type), allocatable, intent(out) :: error
        character(6), parameter :: CHOICES(2) = [character(6) :: 'igrf95', 'dipole']
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call parse(error, '&a'//LF//' near = ''igrf96'''//LF//' bare = dipole'//LF// &
                   ' fine = ''IGRF95''/', file)
        if (allocated(error)) return
        call file%get('a', 'near', text, failure, choices=CHOICES)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:2:', '"igrf96"', 'one of igrf95, dipole', &
                          'did you mean "igrf95"'])
        if (allocated(error)) return
        call file%get('a', 'bare', text, failure, choices=CHOICES)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:3:', 'dipole is not in quotes'])
        if (allocated(error)) return
        call file%get('a', 'fine', text, failure, choices=CHOICES)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, text, 'igrf95')
    end subroutine test_wrong_text

    subroutine test_reject(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure

        call parse(error, SAMPLE, file)
        if (allocated(error)) return
        call file%reject('rod', 'moment', 'too strong', failure, index=2)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:12:', '"moment"', 'too strong', &
                          '|     moment'])
        if (allocated(error)) return
        call file%reject('rod', 'axis', 'is needed', failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml: ', '"axis"', 'is needed'])
    end subroutine test_reject

    subroutine test_unknown_key(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        real(dp) :: x

        call parse(error, '&a'//LF//' mass = 1'//LF//'lenght = 2 /', file)
        if (allocated(error)) return
        call file%get('a', 'mass', x, failure)
        call file%get('a', 'length', x, failure, default=1.0_dp)
        call file%check_all_used(failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:3:', '"lenght" is not known', '&a', &
                          'did you mean "length"?', 'known: mass, length', '| lenght = 2'])
    end subroutine test_unknown_key

    subroutine test_unknown_group(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure
        real(dp) :: x

        call parse(error, '&craft mass = 1 /'//LF//'&crafd /', file)
        if (allocated(error)) return
        call file%get('craft', 'mass', x, failure)
        call file%check_all_used(failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:2:', '&crafd is not known', &
                          'did you mean "craft"?'])
        if (allocated(error)) return
        call parse(error, '&craft mass = 1 /'//LF//'&craft mass = 2 /', file)
        if (allocated(error)) return
        call file%get('craft', 'mass', x, failure)
        call file%check_all_used(failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'case.nml:2:', '&craft', 'once too often'])
    end subroutine test_unknown_group

    subroutine test_files(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_file_t) :: file
        type(error_t), allocatable :: failure

        call file%read(FOLDER//'missing.nml', failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: FOLDER//'missing.nml', 'no such file'])
        if (allocated(error)) return
        call make_file(error, 'broken.nml', '&a'//LF//' x')
        if (allocated(error)) return
        call file%read(FOLDER//'broken.nml', failure)
        call remove_file(FOLDER//'broken.nml')
        call check_fails(error, message_of(failure), &
                         [character(W) :: FOLDER//'broken.nml:2:', '"x"'])
    end subroutine test_files

    subroutine test_write(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_writer_t) :: writer
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call writer%comment('a case')
        call writer%group('craft')
        call writer%entry('mass', 432.0_dp, comment='kg')
        call writer%entry('offset', [0.1_dp, -1e-10_dp])
        call writer%entry('plates', 6)
        call writer%entry('drag', .false.)
        call writer%entry('name', 'it''s')
        call writer%end_group()
        call writer%to_text(text, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, text, '! a case'//LF//'&craft'//LF//'    mass = 432  ! kg'//LF// &
                   '    offset = 0.1, -1e-10'//LF//'    plates = 6'//LF//'    drag = .false.'// &
                   LF//'    name = ''it''''s'''//LF//'/')
        if (allocated(error)) return
        call writer%save('build/no-such-folder/a.nml', failure)
        call check_fails(error, message_of(failure), [character(W) :: 'build/no-such-folder/a.nml'])
    end subroutine test_write

    subroutine test_writer_refuses(error)
        type(error_type), allocatable, intent(out) :: error
        type(namelist_writer_t) :: number, text
        type(error_t), allocatable :: failure
        real(dp) :: nan

        nan = ieee_value(nan, ieee_quiet_nan)
        call number%entry('mass', nan)
        call number%save(FOLDER//'refused.nml', failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'refused.nml', '"mass"', 'finite'])
        if (allocated(error)) return
        call text%entry('name', 'two'//LF//'lines')
        call text%save(FOLDER//'refused.nml', failure)
        call check_fails(error, message_of(failure), &
                         [character(W) :: 'refused.nml', '"name"', 'one line'])
    end subroutine test_writer_refuses
end module test_namelist
