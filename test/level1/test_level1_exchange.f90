!> Level-1 files as files of others and back: GROOPS, CCSDS. Forms by their definitions, units, frames, directions, and files that
!> are broken.
module test_level1_exchange
    use vocabulary
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_base_text, only: join, padded
    use gracecg_files_file, only: text_file_t, read_text_file
    use gracecg_level1_conversion, only: exchange_level1
    use gracecg_level1_records, only: level1_records_t, read_level1
    implicit none
    private
    public :: collect_level1_exchange

    character(1), parameter :: LF = achar(10)
    character(*), parameter :: HEAD = 'header:'//LF//'# End of YAML header'//LF
    character(*), parameter :: DAY = '_2020-02-01_C_04.txt', LATER = '_2020-02-02_C_04.txt'
    integer(i8), parameter :: EPOCH = 633787200_i8      ! 2020-02-01 0 h GPS, MJD 58880

    !> Meta data of an AEM that ours are made of
    character(*), parameter :: META = 'META_START'//LF//'OBJECT_ID = 2018-047A'//LF//'CENTER_NAME = EARTH'//LF

contains

    subroutine collect_level1_exchange(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [new_unittest('there-and-back', test_round_trips), &
                     new_unittest('groops', test_groops), &
                     new_unittest('oem', test_oem), &
                     new_unittest('aem', test_aem), &
                     new_unittest('written', test_written), &
                     new_unittest('broken', test_broken)]
    end subroutine collect_level1_exchange

    !> Every product through every form that has it: times to the microsecond, values to the last digits.
    subroutine test_round_trips(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: STATE = ' 6378136.123456789 -1234.5 5e-3 0.001 0.001 0.001 '// &
            '-1.25 7638.807717665099 12 1e-6 1e-6 1e-6 '
        character(*), parameter :: FLAG = '00000000'

        call there_and_back('GNI1B', '633787200 C I'//STATE//FLAG//LF//'633787205 C I'//STATE//FLAG//LF, 'groops')
        call there_and_back('GNI1B', '633787200 C I'//STATE//FLAG//LF//'633787205 C I'//STATE//FLAG//LF, 'ccsds')
        call there_and_back('GNV1B', '633787200 C E'//STATE//FLAG//LF//'633787205 C E'//STATE//FLAG//LF, 'ccsds')
        call there_and_back('SCA1B', '633787200 C 23 0.1 -0.7 0.1 0.7 1e-6 '//FLAG//LF//'633787201 C 23 -0.5 0.5 -0.5 0.5 0 '// &
                            FLAG//LF, 'ccsds')
        call there_and_back('SCA1B', '633787200 C 23 0.1 -0.7 0.1 0.7 1e-6 '//FLAG//LF, 'groops')
        call there_and_back('ACT1B', '633787201 C -2.77938114592582e-07 -1.064874232988739e-05 1e-9 0 0 0 0 0 0 '//FLAG//LF, &
                            'groops')
        call there_and_back('MAG1B', '633787199 999999 C G 20.5 -1.25 3.5 4 0 0 0 -5 0 0 65000 -65000 -137.4900054931641 '// &
                            FLAG//LF//'633787200 83329 C G 20.5 -1.25 3.5 4 0 0 0 -5 0 0 65000 -65000 -137.4900054931641 '// &
                            FLAG//LF, 'groops')
        call there_and_back('MAS1B', '633787200 500000 G C '//FLAG//' 00000101 482.18 482.16'//LF, 'groops')
        call there_and_back('THR1B', '633787220 100000 G C '//repeat('7 ', 14)//'50 0 0 0 0 0 50 '//repeat('0 ', 7)// &
                            repeat('9 ', 14)//FLAG//LF, 'groops')

    contains

        subroutine there_and_back(product, lines, form)
            character(*), intent(in) :: product, lines, form
            type(level1_records_t) :: before, after
            type(error_t), allocatable :: failure
            type(string_t), allocatable :: warnings(:)
            character(16), parameter :: NOT_KEPT(4) = [character(16) :: 'qualflg', 'qual_rss', 'sca_id', 'prod_flag']
            integer :: i

            call make_file(product//DAY, HEAD//lines)
            call exchange_level1(FOLDER//product//DAY, FOLDER//'other.txt', form, warnings, failure)
            if (.not. allocated(failure)) &
                call exchange_level1(FOLDER//'other.txt', FOLDER//product//LATER, 'level1', warnings, failure)
            if (.not. allocated(failure)) call read_level1(FOLDER//product//DAY, before, failure)
            if (.not. allocated(failure)) call read_level1(FOLDER//product//LATER, after, failure)
            if (failed(error, failure)) return
            call check(error, after%count, before%count, product)
            call check(error, all(after%seconds == before%seconds) .and. all(abs(after%fraction - before%fraction) < 1e-9_dp), &
                       product//' '//form//': other times')
            do i = 1, size(before%fields)
                if (any(NOT_KEPT == before%fields(i)) .or. index(before%fields(i), '_err') > 0 .or. &
                    index(before%fields(i), 'thrust_count') > 0 .or. index(before%fields(i), 'accum_dur') > 0) cycle
                call check(error, .not. any(abs(after%values(:, i) - before%values(:, i)) > 4e-16_dp*abs(before%values(:, i))), &
                           product//' '//form//': '//trim(before%fields(i)))
            end do
        end subroutine there_and_back
    end subroutine test_round_trips

    !> Converts a text of others into a Level-1 file and reads that.
    subroutine read_text(text, product, records, message, remarks)
        character(*), intent(in) :: text, product
        type(level1_records_t), intent(out) :: records
        character(:), allocatable, intent(out) :: message       !! Of the failure; empty: there was none
        character(:), allocatable, intent(out), optional :: remarks
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: warnings(:)

        message = ''
        call make_file('others.txt', text)
        call exchange_level1(FOLDER//'others.txt', FOLDER//product//DAY, 'level1', warnings, failure)
        if (.not. allocated(failure) .and. present(remarks)) remarks = join(padded(warnings), '; ')
        if (.not. allocated(failure)) call read_level1(FOLDER//product//DAY, records, failure)
        message = message_of(failure)
    end subroutine read_text

    !> An instrument file with two arcs and comments as the program's documents show it, and the same numbers as a matrix.
    subroutine test_groops(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: LINES(2) = [character(90) :: &
            ' 58880.000000000000000000  1.5e-07 -2.50e-08 +3.0e-09', &
            ' 58880.000011574074074074  1.6e-07 -2.60e-08 3.1E-09']
        type(level1_records_t) :: acc
        character(:), allocatable :: message
        integer :: attempt

        do attempt = 1, 3
            if (attempt == 1) call read_text('groops instrument version=20200123'//LF//'# ACCELEROMETER'//LF// &
                '         -8          2  # instrument type, number of arcs'//LF//'# Time [MJD]'//LF//'# ====='//LF// &
                ' 1 # number of epochs of 1. arc'//LF//trim(LINES(1))//LF//'          1 # number of epochs of 2. arc'//LF// &
                trim(LINES(2))//LF, 'ACT1B', acc, message)
            if (attempt == 2) call read_text('groops matrix version=20200123'//LF//'Matrix( 2 x 4 )'//LF// &
                                             trim(LINES(1))//LF//trim(LINES(2))//LF, 'ACT1B', acc, message)
            if (attempt == 3) call read_text(trim(LINES(1))//LF//trim(LINES(2))//LF, 'ACT1B', acc, message)
            if (failed(error, message)) return
            call check(error, acc%count, 2)
            call check(error, all(acc%seconds == [EPOCH, EPOCH + 1]), 'other times')
            call check(error, acc%values(2, acc%field_of('lin_accl_y')), -2.6e-8_dp, 'column')
            call check(error, acc%values(1, acc%field_of('lin_accl_z')), 3e-9_dp, 'column')
        end do
    end subroutine test_groops

    !> Kilometres, and times of other scales: 0 h GPS is 23:59:42 UTC, 0:00:19 TAI, 0:01:10.184 TT... less 19 s.
    subroutine test_oem(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: SCALES(4) = [character(3) :: 'GPS', 'UTC', 'TAI', 'TT']
        character(*), parameter :: EPOCHS(4) = [character(26) :: '2020-02-01T00:00:00', '2020-01-31T23:59:42.000', &
                                                '2020-02-01T00:00:19.0Z', '2020-02-01T00:00:51.184']
        type(level1_records_t) :: orbit
        character(:), allocatable :: message, remarks
        integer :: i

        do i = 1, size(SCALES)
            call read_text('CCSDS_OEM_VERS = 2.0'//LF//'COMMENT of a test'//LF//META//'REF_FRAME = EME2000'//LF// &
                           'TIME_SYSTEM = '//trim(SCALES(i))//LF//'META_STOP'//LF//LF//trim(EPOCHS(i))// &
                           ' 6378.1361 -2.5 0.001 0 7.5 -1 0 0 0'//LF//'COVARIANCE_START'//LF//'EPOCH = 2020-02-01T00:00:00'//LF// &
                           '1 2 3'//LF//'COVARIANCE_STOP'//LF, 'GNI1B', orbit, message, remarks)
            if (failed(error, message)) return
            call check(error, orbit%count, 1)
            call check(error, orbit%seconds(1) == EPOCH, trim(SCALES(i))//': another time, '//integer_text(orbit%seconds(1)))
            call check(error, maxval(abs([orbit%values(1, orbit%field_of('xpos')) - 6378136.1_dp, &
                                          orbit%values(1, orbit%field_of('yvel')) - 7500])) < 1e-8_dp, 'not km, km/s')
            call check_fails(error, remarks, 'EME2000 is 0.02 arcsec off')
        end do
    end subroutine test_oem

    !> A satellite turned by 90 deg about z, whose x is inertial y, said in every direction and order.
    subroutine test_aem(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: BODY = 'SC_BODY_1', SPACE = 'ICRF'
        character(*), parameter :: TO_BODY = ' 0 0 0.70710678118654752 0.70710678118654752'
        character(*), parameter :: TO_SPACE = ' 0 0 -0.70710678118654752 0.70710678118654752'
        character(*), parameter :: SCALAR_FIRST = ' 0.70710678118654752 0 0 0.70710678118654752'

        call expect('1.0', SPACE, BODY, 'A2B', 'LAST', TO_BODY)
        call expect('1.0', SPACE, BODY, 'A2B', 'FIRST', SCALAR_FIRST)
        call expect('1.0', SPACE, BODY, 'B2A', 'LAST', TO_SPACE)
        call expect('1.0', BODY, SPACE, 'A2B', 'LAST', TO_SPACE)
        call expect('1.0', BODY, SPACE, 'B2A', 'LAST', TO_BODY)
        call expect('2.0', SPACE, BODY, '', '', TO_BODY)
        call expect('2.0', BODY, SPACE, '', '', TO_SPACE)

    contains

        subroutine expect(version, a, b, direction, order, quaternion)
            character(*), intent(in) :: version, a, b, direction, order, quaternion
            type(level1_records_t) :: sca
            character(:), allocatable :: message, text
            real(dp) :: axes(3, 3)

            text = 'CCSDS_AEM_VERS = '//version//LF//META//'REF_FRAME_A = '//a//LF//'REF_FRAME_B = '//b//LF
            if (direction /= '') text = text//'ATTITUDE_DIR = '//direction//LF
            if (order /= '') text = text//'QUATERNION_TYPE = '//order//LF
            text = text//'TIME_SYSTEM = GPS'//LF//'ATTITUDE_TYPE = QUATERNION'//LF//'META_STOP'//LF//'DATA_START'//LF// &
                '2020-02-01T00:00:00'//quaternion//LF//'DATA_STOP'//LF
            call read_text(text, 'SCA1B', sca, message)
            if (failed(error, message)) return
            associate (q => sca%values(1, [sca%field_of('quaticoeff'), sca%field_of('quatjcoeff'), sca%field_of('quatkcoeff'), &
                                           sca%field_of('quatangle')]))
                axes = rotation_matrix(q)
            end associate
            call check(error, norm2(axes(1, :) - [0, 1, 0]) < 1e-15_dp .and. norm2(axes(2, :) - [-1, 0, 0]) < 1e-15_dp, &
                       'x is not inertial y: '//version//' '//a//' '//direction//' '//order)
        end subroutine expect
    end subroutine test_aem

    !> What is written has the keys that the definitions demand.
    subroutine test_written(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: warnings(:)
        type(text_file_t) :: file

        call make_file('SCA1B'//DAY, HEAD//'633787200 C 23 0.5 0.5 -0.5 0.5 0 00000000'//LF)
        call exchange_level1(FOLDER//'SCA1B'//DAY, FOLDER//'other.txt', 'ccsds', warnings, failure)
        if (.not. allocated(failure)) call read_text_file(FOLDER//'other.txt', file, failure)
        if (failed(error, failure)) return
        call check_fails(error, file%text, &
                         'CCSDS_AEM_VERS = 1.0 ... CREATION_DATE = 2 ... ORIGINATOR =  ... OBJECT_NAME = GRACE-FO 1 ... '// &
                         'OBJECT_ID = 2018-047A ... REF_FRAME_A = GCRF ... REF_FRAME_B = SC_BODY_1 ... '// &
                         'ATTITUDE_DIR = A2B ... TIME_SYSTEM = GPS ... START_TIME = 2020-02-01T00:00:00.000000 ... '// &
                         'STOP_TIME = 2020-02-01T00 ... ATTITUDE_TYPE = QUATERNION ... QUATERNION_TYPE = FIRST ... '// &
                         'DATA_START ... 2020-02-01T00:00:00.000000 0.5 0.5 -0.5 0.5')
    end subroutine test_written

    !> Each kind of broken file is refused, by its line and with what is wrong.
    subroutine test_broken(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: GROOPS = 'groops instrument version=20200123'//LF
        character(*), parameter :: OEM = 'CCSDS_OEM_VERS = 2.0'//LF//META//'REF_FRAME = ICRF'//LF
        character(*), parameter :: AEM = 'CCSDS_AEM_VERS = 1.0'//LF//META//'REF_FRAME_A = ICRF'//LF//'REF_FRAME_B = SC_BODY_1'//LF
        character(*), parameter :: STATE = ' 6378.1361 -2.5 0.001 0 7.5 -1'//LF
        character(*), parameter :: GPS = 'TIME_SYSTEM = GPS'//LF//'META_STOP'//LF
        character(*), parameter :: LINE = '58880.0 1 2 3'//LF

        call refused('ACT1B', GROOPS//'-8'//LF, 'instrument type and number of arcs')
        call refused('ACT1B', GROOPS//'-9 1'//LF//'1'//LF//LINE, 'instrument type -9')
        call refused('ACT1B', GROOPS//'-8 1'//LF//'x'//LF//LINE, 'number of epochs')
        call refused('ACT1B', GROOPS//'-8 1'//LF//'900000000'//LF//LINE, 'here are 0')
        call refused('ACT1B', GROOPS//'-8 1'//LF//'2'//LF//LINE, 'here are 0')
        call refused('ACT1B', GROOPS//'-8 1'//LF//'1'//LF//'58880.0 1 2'//LF, 'MJD and 3 numbers')
        call refused('ACT1B', GROOPS//'-8 1'//LF//'1'//LF//'58880.0 1 2 nan'//LF, '"nan", is no number')
        call refused('ACT1B', GROOPS//'-8 1'//LF//'1'//LF//'2020-02-01 1 2 3'//LF, 'is no MJD')
        call refused('ACT1B', GROOPS//'-8 0'//LF, 'has no data')
        call refused('ACT1B', GROOPS//'-8 1'//LF//'1'//LF//'58880.00001 1 2 3'//LF, 'tags of ACT1B are whole seconds')
        call refused('SCA1B', GROOPS//'-8 1'//LF//'1'//LF//LINE, 'a product of the kind of the series')
        call refused('GNV1B', OEM//GPS//'2020-02-01T00:00:00'//STATE, 'the orbit is inertial')
        call refused('GNI1B', OEM//GPS, 'has no data')
        call refused('GNI1B', OEM//'TIME_SYSTEM = GPS'//LF//'2020-02-01T00:00:00'//STATE, 'expected: KEY = VALUE')
        call refused('GNI1B', OEM//GPS//'2020-02-01T00:00:00 1 2 3'//LF, 'an epoch and 6 numbers')
        call refused('GNI1B', OEM//GPS//'2020-13-01T00:00:00'//STATE, 'the epoch is not of the form')
        call refused('GNI1B', OEM//GPS//'2020-02-01T00:00:00 6378.1361 x 0 0 0 0'//LF, '"x" is no number')
        call refused('GNI1B', OEM//'TIME_SYSTEM = GMST'//LF//'META_STOP'//LF//'2020-02-01T00:00:00'//STATE, 'TIME_SYSTEM "GMST"')
        call refused('GNI1B', 'CCSDS_OEM_VERS = 2.0'//LF//META//'REF_FRAME = TEME'//LF//GPS//'2020-02-01T00:00:00'//STATE, &
                     'frame "TEME"')
        call refused('GNI1B', 'CCSDS_OPM_VERS = 2.0'//LF//META, 'CCSDS_OEM_VERS or CCSDS_AEM_VERS')
        call refused('SCA1B', AEM//GPS//'2020-02-01T00:00:00 0 0 0 1'//LF, 'version 1 needs ATTITUDE_DIR')
        call refused('SCA1B', AEM//'ATTITUDE_TYPE = SPIN'//LF, 'only QUATERNION')
        call refused('SCA1B', AEM//'ATTITUDE_DIR = AB'//LF//'QUATERNION_TYPE = LAST'//LF//GPS, 'neither A2B nor B2A')
        call refused('SCA1B', AEM//'ATTITUDE_DIR = A2B'//LF//'QUATERNION_TYPE = LAST'//LF//GPS// &
                     '2020-02-01T00:00:00 0 0 0 1.2'//LF, 'not of length 1')

    contains

        subroutine refused(product, text, reason)
            character(*), intent(in) :: product, text, reason
            type(level1_records_t) :: records
            character(:), allocatable :: message

            call read_text(text, product, records, message)
            call check_fails(error, message, reason)
        end subroutine refused
    end subroutine test_broken
end module test_level1_exchange
