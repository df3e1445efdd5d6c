!> Settings: the syntax of namelist files; one description, written and read; units, ranges, and a message for every
!> mistake.
module test_settings
    use vocabulary
    use gracecg_files_settings
    use gracecg_files_file, only: remove_file
    implicit none
    private
    public :: collect_settings

    character(*), parameter :: LF = achar(10), CR = achar(13), PLACE = FOLDER//'settings.nml'
    integer, parameter :: W = 70        !! Length of the parts of a message

    !> A record with a setting of every kind.
    type :: record_t
        real(dp) :: mass = 420
        real(dp) :: bias(3) = [50e-9_dp, -30e-9_dp, 25e-9_dp]       !! T
        real(dp) :: angle = 0.3_dp                                  !! rad
        integer :: stars = 20
        logical :: limited = .true.
        character(8) :: model = 'dtm77', name = 'front'
        integer :: rods = 0
        real(dp) :: amplitude(3) = 0
    end type record_t

contains

    subroutine collect_settings(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('syntax', test_syntax), &
                    new_unittest('fortran-reads-ours', test_fortran_reads), &
                    new_unittest('ours-reads-fortran', test_reads_fortran), &
                    new_unittest('syntax-errors', test_syntax_errors), &
                    new_unittest('endless-files', test_endless), &
                    new_unittest('long-lines', test_long_lines), &
                    new_unittest('written-and-read', test_round_trip), &
                    new_unittest('units-of-the-file', test_units), &
                    new_unittest('defaults-stay-and-groups-of-one-name', test_defaults), &
                    new_unittest('wrong-values', test_wrong), &
                    new_unittest('reject-and-what-is-not-written', test_reject), &
                    new_unittest('groups-of-others', test_others), &
                    new_unittest('files', test_files)]
    end subroutine collect_settings

    subroutine describe(settings, record)
        class(settings_t), intent(inout) :: settings
        type(record_t), intent(inout) :: record
        integer :: i

        call settings%group('satellite', 'The satellite')
        call settings%real_value('mass', record%mass, 1.0_dp, 1e4_dp, 'kg', unit='kg', &
                                 required=.true.)
        if (record%mass == 13) call settings%reject('mass', 'brings bad luck')
        call settings%real_values('bias_nt', record%bias, -1e5_dp, 1e5_dp, 'nT', 1e-9_dp, 'nT')
        call settings%real_value('angle_deg', record%angle, -180.0_dp, 180.0_dp, 'deg', DEGREE, &
                                 'deg')
        call settings%integer_value('stars', record%stars, 2, 70, 'of a frame')
        call settings%logical_value('limited', record%limited, 'saturates')
        call settings%text_value('model', record%model, 'of density', &
                                 [character(8) :: 'dtm77', 'none'])
        call settings%text_value('name', record%name, 'of the satellite')
        call settings%end_group()
        call settings%count('rod', record%rods)
        do i = 1, record%rods
            call settings%group('rod', 'A rod', i)
            call settings%real_value('amplitude', record%amplitude(i), -30.0_dp, 30.0_dp, 'A m^2', &
                                     unit='A m^2', required=.true.)
            call settings%end_group()
        end do
    end subroutine describe

    !> The text of a record.
    subroutine write_text(record, text, failure)
        type(record_t), intent(in) :: record
        character(:), allocatable, intent(out) :: text
        type(error_t), allocatable, intent(out) :: failure
        type(settings_t) :: settings
        type(record_t) :: copy

        copy = record
        call describe(settings, copy)
        call settings%to_text(text, failure)
    end subroutine write_text

    !> Reads a text.
    subroutine read_text(text, record, failure)
        character(*), intent(in) :: text
        type(record_t), intent(out) :: record
        type(error_t), allocatable, intent(out) :: failure
        type(settings_t) :: settings

        call settings%open_text(text, 'case.nml', failure)
        if (allocated(failure)) return
        call describe(settings, record)
        call settings%finish(failure)
    end subroutine read_text

    !> Reads a text that must be right.
    subroutine take(error, text, record)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: text
        type(record_t), intent(out) :: record
        type(error_t), allocatable :: failure

        call read_text(text, record, failure)
        call check_passes(error, failure)
    end subroutine take

    !> Each text (of a row the first; ^ ends a line) must be refused with a message that has the other parts.
    subroutine refuse_all(error, cases)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: cases(:, :)
        type(record_t) :: record
        type(error_t), allocatable :: failure
        integer :: i

        do i = 1, size(cases, 2)
            call read_text(lines_of(cases(1, i)), record, failure)
            call check_fails(error, failure, joined(cases(2:, i)))
        end do
    end subroutine refuse_all

    pure function lines_of(text) result(lines)
        character(*), intent(in) :: text
        character(len_trim(text)) :: lines
        integer :: i

        do i = 1, len(lines)
            lines(i:i) = text(i:i)
            if (text(i:i) == '^') lines(i:i) = LF
        end do
    end function lines_of

    !> Cases, comments, repeat counts, quotes, values over several lines, ends of groups, ends of lines as on Windows.
    subroutine test_syntax(error)
        type(error_type), allocatable, intent(out) :: error
        type(record_t) :: record

        call take(error, '! a case'//LF//'&Satellite'//LF//'  Mass = 432.5, name=''a! / b''  ! kg'//LF// &
                  '  bias_nt ='//LF//'    1d1, 2*0.0  ! of three'//CR//LF//'  limited = .F., stars= +6,'//LF//'/'//LF// &
                  '&rod amplitude = -1.0 / &rod'//LF//'  AMPLITUDE = 1.0 &end', record)
        call check(error, record%mass == 432.5_dp .and. record%name == 'a! / b' .and. record%rods == 2 .and. &
                   all(record%bias == [1e-8_dp, 0.0_dp, 0.0_dp]) .and. .not. record%limited .and. record%stars == 6 .and. &
                   all(record%amplitude(:2) == [-1, 1]))
        call take(error, '&satellite mass=2 name = "it''s" /', record)
        call check(error, record%name, 'it''s')
        call take(error, '&satellite mass=2 name = ''it''''s'' model=''DTM77'' /', record)
        call check(error, record%name//record%model, 'it''s    dtm77')
    end subroutine test_syntax

    !> What we write, the compiler's namelist reader reads to the same values.
    subroutine test_fortran_reads(error)
        type(error_type), allocatable, intent(out) :: error
        type(settings_t) :: settings
        type(record_t) :: record
        type(error_t), allocatable :: failure
        real(dp) :: mass, bias_nt(3), angle_deg
        character(20) :: name, model
        logical :: limited
        integer :: stars, unit, status
        namelist /satellite/ mass, bias_nt, angle_deg, name, model, limited, stars

        record%mass = 0.1_dp
        record%bias = [1e-4_dp/3, -2e200_dp, 0.0_dp]
        record%name = 'it''s'
        record%stars = -6
        call make_file('settings.nml', '')
        call describe(settings, record)
        call settings%save(PLACE, failure)
        if (failed(error, failure)) return
        open (newunit=unit, file=PLACE, status='old', action='read')
        read (unit, nml=satellite, iostat=status)
        close (unit, status='delete')
        call check(error, status, 0)
        call check(error, abs(mass - 0.1_dp) <= 0 .and. limited .and. stars == -6 .and. name == 'it''s' .and. &
                   all(abs(bias_nt/1e9_dp - record%bias) <= 0))
    end subroutine test_fortran_reads

    !> What the compiler's namelist writer makes, ours reads.
    subroutine test_reads_fortran(error)
        type(error_type), allocatable, intent(out) :: error
        type(settings_t) :: settings
        type(record_t) :: record
        type(error_t), allocatable :: failure
        real(dp) :: mass, bias_nt(3)
        character(5) :: name
        logical :: limited
        integer :: unit
        namelist /satellite/ mass, bias_nt, name, limited

        mass = 4/3.0_dp
        bias_nt = [0.0_dp, 0.0_dp, -1e-90_dp]
        name = 'it''s'
        limited = .false.
        call make_file('settings.nml', '')
        open (newunit=unit, file=PLACE, status='replace', action='write', delim='apostrophe')
        write (unit, nml=satellite)
        close (unit)
        call settings%open(PLACE, failure)
        call remove_file(PLACE)
        if (.not. allocated(failure)) call describe(settings, record)
        if (.not. allocated(failure)) call settings%finish(failure)
        call check_passes(error, failure)
        call check(error, abs(record%mass - mass) <= 0 .and. all(abs(record%bias - bias_nt/1e9_dp) <= 0) .and. &
                   record%name == name .and. .not. record%limited)
    end subroutine test_reads_fortran

    !> Every breach of the syntax, with the line where it is.
    subroutine test_syntax_errors(error)
        type(error_type), allocatable, intent(out) :: error
        character(W), parameter :: CASES(4, 31) = reshape([character(W) :: &
            '', 'case.nml', 'no group', '', &
            '! only a comment', 'case.nml', 'no group', '', &
            'mass = 1^&a /', 'case.nml:1:', 'outside a group', '| mass = 1', &
            '&a /^rest', 'case.nml:2:', 'outside a group', '', &
            '&a^ x = 1^', 'case.nml:1:', '&a is not ended', '/', &
            '&a^ x = 1^&b^/', 'case.nml:1:', '&a is not ended', '', &
            '&^/', 'case.nml:1:', 'name of a group', '', &
            '&1a /', 'case.nml:1:', 'name of a group', '', &
            '&a^ t = ''x^/', 'case.nml:2:', 'not ended', 't = ''x', &
            '&a^ t = "x''^"/', 'case.nml:2:', 'closing "', '', &
            '&a^ x 1^/', 'case.nml:2:', 'no = after "x"', '', &
            '&a^ x = 1^ mass 2^ y = 3 /', 'case.nml:3:', '"mass" is no value: an = is missing', '|  mass 2', &
            '&a^ x =^ y = 3 /', 'case.nml:2:', '"x" has no value', '', &
            '&a^ x = /', 'case.nml:2:', '"x" has no value', '', &
            '&a^ x = = 3 /', 'case.nml:2:', '"x" has no value', '', &
            '&a^ = 3 /', 'case.nml:2:', 'expected key = value', '', &
            '&a^ ''x'' = 3 /', 'case.nml:2:', 'expected key = value', '', &
            '&a^ x = 1,,3 /', 'case.nml:2:', 'value is missing', '', &
            '&a^ x = ,3 /', 'case.nml:2:', 'value is missing', '', &
            '&a^ x = 3* /', 'case.nml:2:', 'value is missing after "3*"', '', &
            '&a^ x = 0*1 /', 'case.nml:2:', '"0*1"', 'repeat count', &
            '&a^ x = 2.5*1 /', 'case.nml:2:', '"2.5*1"', 'repeat count', &
            '&a^ x = 999999999*1 /', 'case.nml:2:', 'repeat count', '', &
            '&a^ x(2) = 3 /', 'case.nml:2:', '"x(2)"', 'index', &
            '&a^ x%y = 3 /', 'case.nml:2:', '"x%y"', '', &
            '&a^ 2x = 3 /', 'case.nml:2:', '"2x" cannot be a key', '', &
            '&a^ x = 1^ X = 2 /', 'case.nml:3:', '"x" stands twice', 'in line 2', &
            '&a^ x = 2*''b'' 2*''c /', 'case.nml:2:', 'closing ''', '', &
            '&a x = 600*1^ 600*1 /', 'case.nml:2:', 'more than 1000 values', '', &
            '&a^ x^', 'case.nml:2:', 'no = after "x"', '', &
            '&a^ x = 1 ''y', 'case.nml:2:', 'closing ''', ''], [4, 31])

        call refuse_all(error, CASES)
    end subroutine test_syntax_errors

    !> Far more values, keys or groups than any file has are refused at once, not read in a time that grows with the
    !> square of their number.
    subroutine test_endless(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: MANY = 500000, KEYS = 6000
        type(record_t) :: record
        type(error_t), allocatable :: failure
        character(16*KEYS) :: text
        integer :: i

        call read_text('&a x = '//repeat('1,', MANY)//'1 /', record, failure)
        call check_fails(error, failure, 'case.nml:1: ... more than 1000 values')
        call read_text(repeat('&a /'//LF, MANY), record, failure)
        call check_fails(error, failure, 'case.nml:5001: ... more than 5000 groups and keys')
        do i = 1, KEYS
            write (text(16*i - 15:16*i), '("k", i0.5, " = 1", a)') i, LF
        end do
        call read_text('&a'//LF//text//'/', record, failure)
        call check_fails(error, failure, 'more than 5000 groups and keys')
    end subroutine test_endless

    !> Lines of 64 kB and of 10 MB: the time grows with the length and not with its square, which for a line 156 times as
    !> long would be hours. Messages show the beginning of such a line.
    subroutine test_long_lines(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: LENGTHS(2) = [64000, 10000000]
        character(6), parameter :: LINES(5) = [character(6) :: '&a x=''', '&a x=1', '&a !', '&a', '&a x=']
        character(4), parameter :: FILLING(5) = [character(4) :: '''''', ',', 'x', 'x', 'y=1,']
        type(settings_t) :: settings
        type(record_t) :: record
        type(error_t), allocatable :: failure
        character(:), allocatable :: message, line
        character(500000) :: value
        real(dp) :: before, after         ! Of the processor, which others may use, too
        integer :: i, k

        do i = 1, size(LINES)
            do k = 1, size(LENGTHS)
                ! Written in place: flang has the parts of such a text on the stack
                line = repeat(trim(FILLING(i)), LENGTHS(k)/len_trim(FILLING(i)))
                line(:8) = '  '//LINES(i)
                line(:8) = adjustr(line(:8))
                call cpu_time(before)
                call read_text(line, record, failure)
                call cpu_time(after)
                message = message_of(failure)
                call check(error, message /= '' .and. len(message) < 3000, 'a line '//trim(LINES(i))//trim(FILLING(i)))
                call check(error, after - before < 100, 'a line '//trim(LINES(i))//trim(FILLING(i))//' takes too long')
            end do
        end do
        call settings%open_text('&a x='''//repeat('''''', len(value))//''' /', 'case.nml', failure)
        if (failed(error, failure)) return
        call settings%group('a', '')
        call settings%text_value('x', value, '')
        call settings%finish(failure)
        call check_passes(error, failure)
        call check(error, verify(value, ''''), 0)
    end subroutine test_long_lines

    subroutine test_round_trip(error)
        type(error_type), allocatable, intent(out) :: error
        type(record_t) :: record, again
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, text_again

        record = record_t(432.123456789012345_dp, [1e-9_dp/3, -2e-8_dp, 0.0_dp], -1.234567_dp, 33, &
                          .false., 'none', 'it''s', 2, [30.0_dp, -0.1_dp, 0.0_dp])
        call write_text(record, text, failure)
        call check_passes(error, failure)
        call take(error, text, again)
        call check(error, again%mass == record%mass .and. again%stars == 33 .and. &
                   .not. again%limited &
                   .and. again%model == 'none' .and. again%name == 'it''s' .and. again%rods == 2 .and. &
                   all(again%amplitude == record%amplitude))
        call check(error, maxval(abs(again%bias - record%bias)), 0.0_dp, thr=1e-22_dp)
        call check(error, again%angle, record%angle, thr=1e-14_dp)
        call write_text(again, text_again, failure)
        call check(error, text_again, text)
    end subroutine test_round_trip

    !> How it looks; 50 nT stand as 50 in the file, not as 50.00000000000001.
    subroutine test_units(error)
        type(error_type), allocatable, intent(out) :: error
        type(record_t) :: record
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        record%angle = 45*DEGREE
        record%rods = 1
        call write_text(record, text, failure)
        call check_passes(error, failure)
        call check(error, text, &
                   '! The satellite'//LF//'&satellite'//LF//'    mass = 420  ! kg'//LF// &
                   '    bias_nt = 50, -30, 25  ! nT'//LF//'    angle_deg = 45  ! deg'//LF//'    stars = 20  ! of a frame'//LF// &
                   '    limited = .true.  ! saturates'//LF//'    model = ''dtm77''  ! of density: dtm77 none'//LF// &
                   '    name = ''front''  ! of the satellite'//LF//'/'//LF//'! A rod'//LF//'&rod'//LF// &
                   '    amplitude = 0  ! A m^2'//LF//'/')
        call take(error, '&satellite mass = 1 bias_nt = 7 8 9 angle_deg = 180 /', record)
        call check(error, maxval(abs(record%bias - [7e-9_dp, 8e-9_dp, 9e-9_dp])), 0.0_dp, &
                   thr=1e-23_dp)
        call check(error, record%angle, acos(-1.0_dp), thr=1e-15_dp)
    end subroutine test_units

    subroutine test_defaults(error)
        type(error_type), allocatable, intent(out) :: error
        type(record_t) :: record

        call take(error, '&satellite mass = 99 /', record)
        call check(error, record%mass == 99 .and. all(record%bias == [50e-9_dp, -30e-9_dp, &
                   25e-9_dp]) &
                   .and. record%angle == 0.3_dp .and. record%stars == 20 .and. &
                       record%limited .and. &
                   record%model == 'dtm77' .and. record%rods == 0)
        call take(error, '&rod amplitude = 1 /'//LF//'&satellite mass = 99 /'//LF// &
                  '&rod amplitude = 2 / &rod amplitude = 3 /', record)
        call check(error, record%rods == 3 .and. all(record%amplitude == [1, 2, 3]))
    end subroutine test_defaults

    !> Ranges are in the file's unit. Of two mistakes the first in the description is told, whatever its place in the
    !> file; a wrong value comes before an unknown key, for which the nearest known one is shown.
    subroutine test_wrong(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: S = '&satellite mass = 2^ '
        character(W), parameter :: CASES(4, 42) = reshape([character(W) :: &
            '&satellite^mass = 12x /', 'case.nml:2:', 'key "mass" of group &satellite: "12x" is not a finite number', 'kg', &
            '&satellite^Mass = 1.2.3 /', '| Mass =', '"1.2.3" is not a finite number', 'a number from 1 to 10000 kg', &
            '&satellite mass = abc /', '"abc" is not a finite number', '', '', &
            '&satellite mass = NaN /', '"NaN" is not a finite number', '', '', &
            '&satellite mass = -Inf /', '"-Inf" is not a finite number', '', '', &
            '&satellite mass = ''2'' /', 'text in quotes', 'a number from 1 to 10000 kg', '', &
            '&satellite mass = .true. /', '".true."', '', '', &
            '&satellite mass = (1.0,2.0) /', '2 values', 'a number from 1 to 10000 kg', '', &
            '&satellite^mass = 1 2 /', 'case.nml:2:', '2 values', '', &
            '&satellite^mass = 10000.000000000002 /', 'case.nml:2:', '10000.000000000002 is outside', '1 to 10000 kg', &
            '&satellite^mass = 0.999 /', 'case.nml:2:', '0.999 is outside', '1 to 10000 kg', &
            S//'angle_deg = 181 /', 'case.nml:2:', 'angle_deg', '181 is outside the allowed range', &
            S//'bias_nt = 1 2 /', 'case.nml:2:', '2 values', '3 numbers, each a number from -100000 to 100000 nT', &
            S//'bias_nt = 4*0.0 /', 'case.nml:2:', '4 values', '3 numbers', &
            S//'bias_nt = 1 2x 3 /', 'case.nml:2:', 'value 2: "2x"', '', &
            S//'bias_nt = 1^2e5 3/', 'case.nml:3:', 'value 2: 2e5 is outside', '-100000 to 100000 nT', &
            S//'bias_nt = 1 2^nan /', 'case.nml:3:', 'value 3: "nan"', '', &
            S//'bias_nt = 1 2 ''3'' /', 'case.nml:2:', 'text in quotes', '3 numbers', &
            S//'stars = 1.5 /', 'case.nml:2:', '"1.5" is not an integer', 'from 2 to 70', &
            S//'stars = 99999999999 /', 'case.nml:2:', '"99999999999"', '', &
            S//'stars = 71 /', 'case.nml:2:', '71 is outside', 'from 2 to 70', &
            S//'stars = ''7'' /', 'case.nml:2:', 'in quotes', 'from 2 to 70', &
            S//'limited = 1 /', 'case.nml:2:', '"1" is not a logical', '.true. or .false.', &
            S//'limited = ''true''/', 'case.nml:2:', 'quotes', '.true. or .false.', &
            S//'model = ''dtm78'' /', 'case.nml:2:', '"dtm78" is not known; it must be one of dtm77, none', &
            'did you mean "dtm77"?', &
            S//'model = none /', 'case.nml:2:', 'none is not in quotes', 'one of dtm77, none', &
            S//'name = ''far too long'' /', 'case.nml:2:', 'name', 'more than 8 characters', &
            S//'name = 3 /', 'case.nml:2:', '3 is not in quotes', 'a text in quotes', &
            '^&satellite^ mas = 1 /', 'case.nml:2:', 'the key "mass" (a number from 1 to 10000 kg) is missing', &
            'is "mas" there a misspelling of it?', &
            '&rod amplitude = 3 /', 'case.nml: ', 'the group &satellite is missing', '"mass"', &
            S//'/^&rod amplitude = 1 /^&rod /', 'case.nml:4:', '&rod number 2', '"amplitude"', &
            S//'/^&rod amplitude = 1 /^&rod amplitude = 31 /', 'case.nml:4:', '31', '-30 to 30 A m^2', &
            S//'starz = 3 /', 'case.nml:2:', '"starz" is not known in the group &satellite', 'did you mean "stars"?', &
            S//'bais_nt = 3 4 5 /', 'case.nml:2:', 'did you mean "bias_nt"?', 'known: mass, bias_nt, angle_deg,', &
            S//'foo_bar = 3 /', 'case.nml:2:', '"foo_bar"', '|  foo_bar = 3', &
            S//'/^&rodd amplitude = 3 /', 'case.nml:3:', '&rodd is not known; did you mean "rod"?', 'known: satellite, rod', &
            S//'/^&satellite mass = 3 /', 'case.nml:3:', '&satellite stands here once too often', '', &
            S//'limited = ''t''^stars = 1 /', 'case.nml:3:', 'stars', '', &
            '&satellite stars = 99^mass = 0^foo = 1 /', 'case.nml:2:', 'mass', '', &
            '&satellite^^mass = 13 /', 'case.nml:3:', '"mass"', 'brings bad luck', &
            S//'name = ''a'' ''b'' /', 'case.nml:2:', '2 values', 'a text in quotes', &
            S//'^^limited = 3*T /', 'case.nml:4:', '3 values', '.true. or .false.'], [4, 42])

        call refuse_all(error, CASES)
    end subroutine test_wrong

    !> A refusal of the caller's own: a writer takes no notice, and a key that is not there has no line.
    subroutine test_reject(error)
        type(error_type), allocatable, intent(out) :: error
        type(settings_t) :: settings, writer
        type(record_t) :: record
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        record%mass = 13
        call write_text(record, text, failure)
        if (failed(error, failure)) return
        call settings%open_text('&rod /', 'case.nml', failure)
        call settings%group('rod', '')
        call settings%reject('axis', 'is needed')
        call settings%finish(failure)
        call check_fails(error, failure, 'case.nml: key "axis" of group &rod: is needed')
        record%name = 'two'//LF//'lines'
        call write_text(record, text, failure)
        call check_fails(error, failure, '"name" ... one line')
        record%bias(2) = NAN
        call describe(writer, record)
        call writer%save(FOLDER//'refused.nml', failure)
        call check_fails(error, failure, 'refused.nml ... "bias_nt" ... not a finite number')
    end subroutine test_reject

    !> Groups that belong to others are theirs to check; what is asked for by `holds` is not thereby known.
    subroutine test_others(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: TEXT = '&others x = 1 /'//LF//'&satellite mass = 2 /'
        type(settings_t) :: settings
        type(record_t) :: record
        type(error_t), allocatable :: failure

        call settings%open_text(TEXT, 'case.nml', failure)
        call describe(settings, record)
        call settings%finish(failure, others=['others'])
        call check_passes(error, failure)
        call settings%finish(failure, only=[character(9) :: 'satellite', 'rod'])
        call check_passes(error, failure)
        call check(error, settings%holds('others') .and. settings%holds('others', 'x') .and. settings%holds('satellite', 'ma') &
                   .and. .not. settings%holds('others', 'xy') .and. .not. settings%holds('rod'))
        call settings%finish(failure, others=['another'])
        call check_fails(error, failure, 'case.nml:1: ... &others is not known ... known: satellite, rod, another')
        call settings%finish(failure, only=['other'])       ! misspelt
        call check_fails(error, failure, 'case.nml:1: ... &others is not known')
    end subroutine test_others

    subroutine test_files(error)
        type(error_type), allocatable, intent(out) :: error
        type(settings_t) :: settings, writer
        type(record_t) :: record
        type(error_t), allocatable :: failure

        call settings%open(FOLDER//'missing.nml', failure)
        call check_fails(error, failure, FOLDER//'missing.nml ... no such file')
        call make_file('settings.nml', '&a'//LF//' x')
        call settings%open(PLACE, failure)
        call remove_file(PLACE)
        call check_fails(error, failure, PLACE//':2: ... "x"')
        call describe(writer, record)
        call writer%save('build/no-such-folder/a.nml', failure)
        call check_fails(error, failure, 'build/no-such-folder/a.nml')
    end subroutine test_files
end module test_settings
