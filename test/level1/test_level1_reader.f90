!> Level-1 files: text and binary are read, and every broken file is refused with its place.
module test_level1_reader
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use vocabulary
    use gracecg_base_text, only: join, padded
    use gracecg_level1_products, only: level1_layout_t, level1_layout, level1_product_names
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t
    use gracecg_level1_records, only: level1_records_t, read_level1
    implicit none
    private
    public :: collect_level1_reader

    character(1), parameter :: LF = achar(10), CR = achar(13), TAB = achar(9)
    character(*), parameter :: ACC_FLAG = '00000100000000000000000000111111'
    character(*), parameter :: ACC_VALUES = ' -1.25e-05 -2.5e-07 -5e-07 1e-05 0.0001 -0.00075 '

contains

    subroutine collect_level1_reader(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('products', test_products), &
                    new_unittest('text', test_text), &
                    new_unittest('binary', test_binary), &
                    new_unittest('long-text', test_long_text), &
                    new_unittest('satellite-and-frame-by-value', test_order), &
                    new_unittest('prod-flag', test_prod_flag), &
                    new_unittest('forms-of-star-camera', test_star_camera), &
                    new_unittest('channels', test_channels), &
                    new_unittest('sorted-once-or-last-of-history', test_sorted), &
                    new_unittest('spans-and-fields', test_spans), &
                    new_unittest('warnings', test_warnings), &
                    new_unittest('broken-headers', test_broken_headers), &
                    new_unittest('broken-lines', test_broken_lines), &
                    new_unittest('broken-bytes-and-mixed-records', test_broken_bytes)]
    end subroutine collect_level1_reader

    !> A YAML header.
    pure function yaml(records, title) result(text)
        character(*), intent(in) :: records, title
        character(:), allocatable :: text

        text = 'header:'//LF//'  dimensions:'//LF//'    num_records: '//records//LF//'  global_attributes:'//LF// &
            '    history:'//LF//'      - "a: b"'//LF//'    platform: GRACE C'//LF//'    title: '//title//LF// &
            '  non-standard_attributes:'//LF//'    start_time_epoch_secs: 738849600.5'//LF// &
            '# End of YAML header'//LF
    end function yaml

    !> A header of cards of 80 characters.
    pure function cards(format, satellite, records) result(text)
        character(1), intent(in) :: format      !! 0 binary, 1 text
        character(*), intent(in) :: satellite, records
        character(:), allocatable :: text

        text = card('PRODUCER AGENCY', 'GRACECG')//card('FILE FORMAT 0=BINARY 1=ASCII', format)// &
            card('SATELLITE NAME', satellite)//card('NUMBER OF DATA RECORDS', records)// &
            card('TIME FIRST OBS(SEC PAST EPOCH)', '116769600.000000 (2003-09-14 00:00:00.00)')
        text = text//'END OF HEADER'//repeat(' ', 67)//LF
    end function cards

    pure function card(label, value) result(line)
        character(*), intent(in) :: label, value
        character(81) :: line

        line = label
        line(31:) = ': '//value
        line(81:) = LF
    end function card

    !> The bytes of an integer, most significant first.
    pure function big(number, bytes) result(text)
        integer(i8), intent(in) :: number
        integer, intent(in) :: bytes
        character(bytes) :: text

        integer :: i

        do i = 1, bytes
            text(i:i) = achar(int(ibits(number, 8*(bytes - i), 8)))
        end do
    end function big

    pure function big_real(number) result(text)
        real(dp), intent(in) :: number
        character(8) :: text

        text = big(transfer(number, 0_i8), 8)
    end function big_real

    pure function big_single(number) result(text)
        real, intent(in) :: number
        character(4) :: text

        text = big(int(transfer(number, 0), i8), 4)
    end function big_single

    !> Reads a file of this content.
    subroutine read_records(error, name, content, records, failure)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name, content
        type(level1_records_t), intent(out) :: records
        type(error_t), allocatable, intent(out) :: failure

        call make_file(name, content)
        if (.not. allocated(error)) call read_level1(FOLDER//name, records, failure)
    end subroutine read_records

    !> The same; it must be read.
    subroutine read_well(error, name, content, records)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name, content
        type(level1_records_t), intent(out) :: records
        type(error_t), allocatable :: failure

        call read_records(error, name, content, records, failure)
        call check_passes(error, failure)
    end subroutine read_well

    subroutine check_warned(error, records, parts)
        type(error_type), allocatable, intent(inout) :: error
        type(level1_records_t), intent(in) :: records
        character(*), intent(in) :: parts        !! Of the warnings

        call check_fails(error, join(padded(records%warnings), '; '), parts)
    end subroutine check_warned

    !> Every product has a layout with time, satellite and, where it has one, a quality flag at its end.
    subroutine test_products(error)
        type(error_type), allocatable, intent(out) :: error
        character(5), parameter :: MEASURED(9) = ['ACC1B', 'SCA1B', 'GNV1B', 'MAG1B', 'CLK1B', 'TIM1B', 'THR1B', 'USO1B', &
                                                  'VKB1B']
        integer, parameter :: LENGTHS(9) = [78, 47, 103, 63, 39, 26, 179, 31, 38]
        character(5), allocatable :: names(:)
        type(level1_layout_t) :: layout
        type(error_t), allocatable :: failure
        integer :: i, k

        names = level1_product_names()
        do i = 1, size(names)
            do k = 1, 2
                call level1_layout(names(i), k == 2, layout, failure)
                if (failed(error, failure)) return
                call check(error, layout%id > 0 .and. all(layout%fields%kind > 0) .and. layout%qualflg > 0, names(i))
            end do
        end do
        ! The lengths of binary records in bytes that official files have.
        do i = 1, size(LENGTHS)
            call level1_layout(MEASURED(i), .false., layout, failure)
            call check(error, sum(layout%fields%bytes), LENGTHS(i), MEASURED(i))
        end do
        call level1_layout('AHK1A', .true., layout, failure)
        call check(error, layout%field_of('TSU_Y+'), layout%field_of('tesu'))
        call check(error, layout%field_of('Sync_Qual'), layout%field_of('Mhz_count'))
        call check(error, layout%field_of('TSU_X'), 0)
        call level1_layout('ACC1C', .false., layout, failure)
        call check_fails(error, failure, '"ACC1C" ... ACC1A')
    end subroutine test_products

    !> Text: white space of any kind, blank lines, flags; header facts.
    !> The last line may lack its line feed; no record at all is legal.
    subroutine test_text(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: records

        call read_well(error, 'renamed.txt', yaml('2', 'GRACE-FO Level-1A Accelerometer Data')// &
                       '738849600  7739  R  C  00000000   '//ACC_FLAG//ACC_VALUES//'0'//LF//LF// &
                       TAB//'738849600 107733'//TAB//'R C 10000101 '//ACC_FLAG//ACC_VALUES//'70000  '//CR//LF, &
                       records)
        if (allocated(error)) return
        call check(error, records%layout%product, 'ACC1A')
        call check(error, records%satellite//records%time_ref, 'CR')
        call check(error, records%count, 2)
        call check(error, size(records%warnings), 0)
        call check(error, records%fraction(2), 0.107733_dp)
        call check(error, records%values(2, records%field_of('lin_accl_x')), -1.25e-5_dp)
        call check(error, nint(records%values(2, records%field_of('qualflg'))), 133)
        call check(error, nint(records%values(2, records%field_of('icu_blk_nr'))), 70000)
        call check(error, ieee_is_nan(records%values(1, records%field_of('bias_vol'))), 'a value that is not there')
        call check(error, records%header%records, 2)
        call check(error, records%header%first_time, 738849600.5_dp)
        call read_well(error, 'VCM1B_2020-02-01_C_04.txt', cards('1', 'GRACE C', '1')// &
                       '633798000 C 0.5 1 0 0 00000000', records)
        call check(error, records%count, 1)
        call read_well(error, 'VCM1B_2020-02-01_C_04.txt', cards('1', 'GRACE C', '0'), records)
        call check(error, records%count, 0)
        call check(error, size(records%warnings), 0)
    end subroutine test_text

    !> Binary: every kind of number, with its sign.
    subroutine test_binary(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: records
        character(:), allocatable :: content
        integer :: i

        content = cards('0', 'GRACE A', '2')
        do i = 0, 1
            content = content//big(116769600_i8 + i, 4)//'A'//big(-2_i8, 1)//big_real(-0.0754_dp)//big_real(1e-11_dp)// &
                big_real(-1.5e-8_dp/3)//big_real(2.0_dp)//achar(129)
        end do
        call read_well(error, 'CLK1B_2003-09-14_A_02.dat', content, records)
        if (allocated(error)) return
        call check(error, records%count, 2)
        call check(error, records%seconds(2) == 116769601)
        call check(error, nint(records%values(1, records%field_of('clock_id'))), -2)
        call check(error, abs(records%values(2, records%field_of('eps_drift')) + 1.5e-8_dp/3) <= 0)
        call check(error, nint(records%values(2, records%field_of('qualflg'))), 129)
        content = cards('0', 'GRACE A', '1')//big(116769600_i8, 4)//big(999999_i8, 4)//'GA'// &
            repeat(big(4294967295_i8, 4), 14)//repeat(big(50_i8, 4), 14)//repeat(big(2147483648_i8, 4), 14)//achar(0)
        call read_well(error, 'THR1B_2003-09-14_A_02.dat', content, records)
        if (allocated(error)) return
        call check(error, records%values(1, records%field_of('thrust_count_14')), 4294967295.0_dp)
        call check(error, records%values(1, records%field_of('accum_dur_1')), 2147483648.0_dp)
        call check(error, records%fraction(1), 0.999999_dp)
    end subroutine test_binary

    !> Text beyond the buffer of the reader; the blocks are all there, in order.
    subroutine test_long_text(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 60000
        type(level1_reader_t) :: reader
        type(level1_block_t) :: block
        type(error_t), allocatable :: failure
        character(60*N) :: lines
        character(60) :: line
        integer :: i, length
        integer(i8) :: expected

        length = 0
        do i = 1, N
            write (line, '(i0, " 250000 G C 1 ", i0, ".125 00000000")') 633798000 + i, i
            lines(length + 1:) = trim(line)//LF
            length = length + len_trim(line) + 1
        end do
        call make_file('IMU1B_2020-02-01_C_04.txt', yaml('60000', 'any')//lines(:length))
        call reader%open(FOLDER//'IMU1B_2020-02-01_C_04.txt', failure)
        expected = 633798001
        do
            if (.not. allocated(failure)) call reader%next(block, failure)
            call check_passes(error, failure)
            if (allocated(error) .or. block%count == 0) exit
            do i = 1, block%count
                call check(error, block%seconds(i) == expected .and. &
                           abs(block%values(i, 6) - (expected - 633798000 + 0.125_dp)) <= 0, line)
                expected = expected + 1
            end do
        end do
        call check(error, expected == 633798001 + N)
        call check(error, size(reader%warnings), 0)
    end subroutine test_long_text

    !> Satellite and time frame in either order, as headers and products differ.
    subroutine test_order(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: records
        type(error_t), allocatable :: failure
        character(*), parameter :: MAG = ' 1 2 3 4 0 0 0 0 0 54 54 53 120 00000000'

        call read_well(error, 'MAG1B_2020-02-01_C_04.txt', yaml('2', 'any')//'633798000 83329 C G'//MAG//LF// &
                       '633798000 583329 G C'//MAG//LF, records)
        if (allocated(error)) return
        call check(error, records%satellite//records%time_ref, 'CG')
        call check(error, all(abs(records%values(:, records%field_of('id')) - iachar('C')) <= 0))
        call read_records(error, 'MAG1B_2020-02-01_C_04.txt', yaml('1', 'any')//'633798000 83329 C D'//MAG//LF, &
                          records, failure)
        call check_fails(error, failure, 'MAG1B_2020-02-01_C_04.txt:12 ... neither is a time frame, R or G')
    end subroutine test_order

    !> Columns that change from record to record, text and binary.
    subroutine test_prod_flag(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: records
        character(:), allocatable :: content
        integer :: form

        do form = 0, 1
            if (form == 0) then
                content = cards('0', 'GRACE A', '2')// &
                    big(116769600_i8, 4)//big(0_i8, 4)//'GA'//achar(0)//achar(51)//big_real(482.5_dp)//big_real(0.5_dp)// &
                    big_real(14.5_dp)//big_real(14.25_dp)// &
                    big(116769600_i8, 4)//big(0_i8, 4)//'GA'//achar(0)//achar(204)//big_real(480.5_dp)//big_real(0.25_dp)// &
                    big_real(13.5_dp)//big_real(13.25_dp)
            else
                content = cards('1', 'GRACE A', '2')// &
                    '116769600 0 G A 00000000 00110011 482.5 0.5 14.5 14.25'//LF// &
                    '116769600 0 G A 00000000 11001100 480.5 0.25 13.5 13.25'//LF
            end if
            call read_well(error, 'MAS1B_2003-09-14_A_02.dat', content, records)
            if (allocated(error)) return
            call check(error, records%count, 2)
            call check(error, records%values(1, records%field_of('gas_mass_thr2')), 14.25_dp)
            call check(error, records%values(2, records%field_of('mass_tnk')), 480.5_dp)
            call check(error, records%values(2, records%field_of('gas_mass_tnk1')), 13.5_dp)
            call check(error, ieee_is_nan(records%values(2, records%field_of('mass_thr'))))
        end do
    end subroutine test_prod_flag

    !> GRACE has no fraction of the second and GRACE-FO has one. A tank's number is a character in binary.
    subroutine test_star_camera(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: records
        character(*), parameter :: REST = ' 1 P 1 0 0 0 0 47 1 0 0 11000001 11000000'

        call read_well(error, 'SCA1A_2023-06-01_C_04.txt', yaml('1', 'any')//'738849600 29992 C'//REST//LF, records)
        if (allocated(error)) return
        call check(error, records%fraction(1), 0.029992_dp)
        call check(error, nint(records%values(1, records%field_of('sca_mode'))), 193)
        call read_well(error, 'SCA1A_2003-09-14_B_02.asc', cards('1', 'GRACE B', '1')//'116769600 B'//REST//LF, &
                       records)
        if (allocated(error)) return
        call check(error, records%satellite, 'B')
        call check(error, nint(records%values(1, records%field_of('nstars'))), 47)
        call read_well(error, 'TNK1B_2003-09-14_A_02.dat', cards('0', 'GRACE A', '1')//big(116769600_i8, 4)// &
                       big(381000_i8, 4)//'GA2'//achar(0)//achar(3)//big_single(221.75)//big_single(1.5), records)
        if (allocated(error)) return
        call check(error, nint(records%values(1, records%field_of('tank_id'))), 2)
        call check(error, records%values(1, records%field_of('tank_pres')), 221.75_dp)
    end subroutine test_star_camera

    !> A navigation record has as many channels as it says.
    subroutine test_channels(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: records
        type(error_t), allocatable :: failure
        character(*), parameter :: STATE = ' A 0.5 2 300 1 2 3 0 0 0 4 5 6 0 0 0 0.0166 0 0 0 00000000'

        call read_well(error, 'GNV1A_2003-09-14_A_02.asc', cards('1', 'GRACE A', '2')//'116769600 2'//STATE// &
                       ' 7 45.5 90 31 10 180'//LF//'116769610 0'//STATE//LF, records)
        if (allocated(error)) return
        call check(error, nint(records%values(1, records%field_of('prn_2'))), 31)
        call check(error, records%values(1, records%field_of('elevation_1')), 45.5_dp)
        call check(error, ieee_is_nan(records%values(2, records%field_of('prn_1'))))
        call read_records(error, 'GNV1A_2003-09-14_A_02.asc', cards('1', 'GRACE A', '1')//'116769600 33'//STATE//LF, &
                          records, failure)
        call check_fails(error, failure, 'n_prns')
    end subroutine test_channels

    !> Passes overlap: sorted, the first of equal epochs stays, both counted; heads are apart.
    !> Of calibration histories and clocks the last of equal epochs stays.
    subroutine test_sorted(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: records

        call read_well(error, 'IMU1A_2020-02-01_C_04.txt', yaml('6', 'any')// &
                       '633798002 0 R C 1 10 00000000'//LF//'633798002 0 R C 2 20 00000000'//LF// &
                       '633798003 0 R C 1 11 00000000'//LF//'633798002 0 R C 1 12 00000000'//LF// &
                       '633798001 500000 R C 1 13 00000000'//LF//'633798004 0 R C 1 14 00000000'//LF, records)
        call check(error, records%count, 5)
        call check(error, records%duplicates, 1)
        call check(error, records%unsorted, 2)
        call check(error, all(nint(records%values(:, records%field_of('FiltAng'))) == [13, 10, 20, 11, 14]))
        call check_warned(error, records, '2 records came before ... 1 records have an epoch')
        call read_well(error, 'CLK1B_2020-02-01_C_04.txt', cards('1', 'GRACE C', '2')// &
                       '633798000 C -1 -0.25 0 0 0 00000010'//LF//'633798000 C -1 -0.5 0 0 0 00000000'//LF, records)
        if (allocated(error)) return
        call check(error, records%count, 1)
        call check(error, records%values(1, records%field_of('eps_time')), -0.5_dp)
        call check(error, size(records%warnings), 0)
    end subroutine test_sorted

    subroutine test_spans(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: records
        type(error_t), allocatable :: failure
        real(dp), allocatable :: times(:)
        character(:), allocatable :: content
        integer :: i

        content = yaml('9', 'any')
        do i = 1, 9
            content = content//'63379800'//achar(iachar('0') + i)//' 500000 R C 1 1'//achar(iachar('0') + i)//' 00000000'//LF
        end do
        call make_file('IMU1A_2020-02-01_C_04.txt', content)
        call read_level1(FOLDER//'IMU1A_2020-02-01_C_04.txt', records, failure, &
                         fields=[character(12) :: 'FiltAng', 'GRACEFO_id'], &
                         spans=reshape([633798001.5_dp, 633798002.5_dp, 633798008.0_dp, 633798020.0_dp], [2, 2]))
        if (failed(error, failure)) return
        call records%times_since(633798000_i8, times)
        call check(error, all(abs(times - [1.5_dp, 2.5_dp, 8.5_dp, 9.5_dp]) <= 0))
        call check(error, all(nint(records%values(:, 1)) == [11, 12, 18, 19]))
        call check(error, records%outside == 5)
        call check(error, records%field_of('id'), 2)
        call check(error, records%field_of('gyro_id'), 0)
        call read_level1(FOLDER//'IMU1A_2020-02-01_C_04.txt', records, failure, fields=[character(12) :: 'FiltAngle'])
        call check_fails(error, failure, '"FiltAngle" ... did you mean "FiltAng"')
    end subroutine test_spans

    !> What is unusual, but no failure: counts, satellites, frames, values that are no numbers, names.
    subroutine test_warnings(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: records
        character(:), allocatable :: text

        call read_well(error, 'CLK1B_2020-02-01_C_04.txt', cards('1', 'GRACE C', '-5'), records)
        call check_warned(error, records, 'line 4 of the header: "-5" is no number of records')
        text = yaml('many', 'any')
        text = text(:index(text, '738849600.5') - 1)//'soon'//LF//'# End of YAML header'//LF
        call read_well(error, 'CLK1B_2020-02-01_C_04.txt', text, records)
        call check_warned(error, records, &
                          'line 3 of the header: "many" is no number ... line 10 of the header: "soon" is no time')
        call read_well(error, 'VGN1B_2018-05-22_A_04.txt', cards('1', 'GRACE C', '864078')// &
                       '633798000 D 0.5 1 nan 0 00000000'//LF, records)
        call check(error, records%satellite, 'D')
        call check_warned(error, records, &
                          'announces 864078 records, the file has 1 ... header says satellite C, the records say D ... '// &
                          'name of the file says satellite A ... 1 values of cosy are no finite numbers')
        call read_well(error, 'IMU1A_2020-02-01_C_04.txt', yaml('1', 'GRACE-FO Level-1B IMU Data')// &
                       '633798000 0 R C 1 10 00000000'//LF, records)
        call check_warned(error, records, 'name of the file says IMU1A, its header IMU1B ... time frame R is unusual for IMU1B')
        call read_well(error, 'ACT1B_2020-02-01_D_04.txt', cards('1', 'GRACE D', '1')// &
                       '633798000 D 1 2 3 0 0 0 0 0 0 00000000'//LF, records)
        call check_warned(error, records, 'is that of C transplanted')
    end subroutine test_warnings

    subroutine check_refused(error, name, content, parts)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name, content, parts
        type(level1_records_t) :: records
        type(error_t), allocatable :: failure

        call read_records(error, name, content, records, failure)
        call check_fails(error, failure, name//' ... '//parts)
    end subroutine check_refused

    subroutine test_broken_headers(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: NAME = 'CLK1B_2020-02-01_C_04.txt'

        call check_refused(error, NAME, '', 'is empty')
        call check_refused(error, NAME, 'time,x,y'//LF//'1,2,3'//LF, ':1: ... no Level-1 file ... time,x,y')
        call check_refused(error, NAME, LF, 'no Level-1 file')
        call check_refused(error, NAME, 'header:'//LF//'  platform: GRACE C'//LF, ':2: ... no end ... # End of YAML header')
        call check_refused(error, NAME, card('SATELLITE NAME', 'GRACE C'), ':1: ... no end ... END OF HEADER')
        call check_refused(error, NAME, card('SATELLITE NAME', 'GRACE C')//'END OF HEADER'//LF, 'FILE FORMAT 0=BINARY 1=ASCII')
        call check_refused(error, NAME, cards('2', 'GRACE C', '1'), ':2: ... "2" ... 0 (binary) and 1 (text)')
        call check_refused(error, 'any.txt', yaml('0', 'any'), 'the header does not say which product')
        call check_refused(error, 'IMU1A_2020-02-01_C_04.dat', cards('0', 'GRACE C', '1'), 'no binary form')
    end subroutine test_broken_headers

    subroutine test_broken_lines(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: NAME = 'CLK1B_2020-02-01_C_04.txt'
        character(:), allocatable :: head

        head = cards('1', 'GRACE C', '1')//'633798000 C -1 -0.25 0 0 0 00000010'//LF
        call refused('633798010 C -1 -0.25 0 0 0', &
                     'field qualflg of CLK1B ... the line ends here; 8 fields are expected ... | 633798010 C')
        call refused('633798010 C -1 -0.25 0 0 0 00000000 7', '"7" is more than the 8 fields')
        call refused('633798010 C -1 -0,25 0 0 0 00000000', 'eps_time ... "-0,25" is not a decimal number')
        call refused('633798010 C -1 ****** 0 0 0 00000000', 'eps_time ... stars stand where a number')
        call refused('633798010 C 200 0 0 0 0 00000000', 'clock_id ... "200" ... -128 to 127')
        call refused('6337980.5 C 2 0 0 0 0 00000000', 'rcv_time ... "6337980.5"')
        call refused('633798010 E 2 0 0 0 0 00000000', 'id ... "E" is no satellite')
        call refused('633798010 CC 2 0 0 0 0 00000000', '"CC" is not one letter')
        call refused('633798010 C 2 0 0 0 0 0000000', '"0000000" is not a flag of 8')
        call refused('633798010 C 2 0 0 0 0 00000020', '"00000020" is not a flag of 8')
        call check_refused(error, NAME, head//'633798010 C 2 0 0 0 0 00000000'//achar(0)//LF, &
                           ':8: ... "00000000?" is not a flag')
        call check_refused(error, NAME, head//repeat('7', 3000000), ':8: ... longer than 16384')
        call check_refused(error, 'MAS1B_2020-02-01_C_04.txt', &
                           cards('1', 'GRACE C', '1')// '633798010 1000000 G C 00000000 11000000 1 2'//LF, &
                           ':7: ... time_frac ... allowed is 0 to 999999')
        call check_refused(error, 'TNK1B_2020-02-01_C_04.txt', &
                           cards('1', 'GRACE C', '1')// '633798010 0 G C 1 00000000 10000001 1 2'//LF, &
                           ':7: ... prod_flag ... above bit 6')
        call check_refused(error, 'TIM1B_2020-02-01_C_04.txt', &
                           cards('1', 'GRACE C', '1')// '633798010 C 0 633798010 1000000000 -1 -1 00000100'//LF, &
                           ':7: ... time_frac ... allowed is 0 to 999999999')

    contains

        !> The second record is refused, with its line.
        subroutine refused(record, parts)
            character(*), intent(in) :: record, parts

            call check_refused(error, NAME, head//record//LF, ':8: ... '//parts)
        end subroutine refused
    end subroutine test_broken_lines

    !> Satellites or time frames mixed in one file are refused for use.
    subroutine test_broken_bytes(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: NAME = 'VKB1B_2003-09-14_A_02.dat'
        character(:), allocatable :: head, record

        head = cards('0', 'GRACE A', '2')
        record = big(116769600_i8, 4)//'A'//big_real(1.0_dp)//big_real(1.0_dp)//big_real(0.0_dp)//big_real(0.0_dp)//achar(0)
        call check_refused(error, NAME, head//record//record(:20), 'byte 525: ... within record 2 of VKB1B ... after 20 bytes')
        call check_refused(error, NAME, head//record//record(:4)//'Z'//record(6:), 'byte 525 ... record 2 ... field id ... "Z"')
        call check_refused(error, 'ACC1A_2003-09-14_A_02.dat', &
                           head//big(116769600_i8, 4)//big(0_i8, 4)//'RA'// achar(0)//achar(128)//repeat(achar(0), 80), &
                           'prod_flag ... above bit 29')
        record = big(116769600_i8, 4)//big(0_i8, 4)//'RA'//achar(0)
        call check_refused(error, 'ACC1A_2003-09-14_A_02.dat', &
                           head//record//big(0_i8, 4)//record//achar(128)// repeat(achar(0), 80), &
                           'byte 502, ... record 2 ... prod_flag')
        call check_refused(error, 'MAG1B_2003-09-14_A_02.dat', &
                           head//big(116769600_i8, 4)//big(-1_i8, 4)//'GA'// repeat(achar(0), 53), 'time_frac ... -1')
        call check_refused(error, 'IMU1A_2020-02-01_C_04.txt', &
                           yaml('2', 'any')//'633798002 0 R C 1 10 00000000'//LF// '633798003 0 R D 1 10 00000000'//LF, &
                           '1 of 2 records are of another satellite')
        call check_refused(error, 'IMU1A_2020-02-01_C_04.txt', &
                           yaml('2', 'any')//'633798002 0 R C 1 10 00000000'//LF// '633798003 0 G C 1 10 00000000'//LF, &
                           '1 of 2 records have another time frame')
    end subroutine test_broken_bytes
end module test_level1_reader
