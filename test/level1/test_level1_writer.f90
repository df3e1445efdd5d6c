!> Level-1 files that are written: read again, they are what was written, in text and in binary.
module test_level1_writer
    use, intrinsic :: iso_fortran_env, only: real32
    use vocabulary
    use gracecg_base_text, only: padded, join, parse_real
    use gracecg_files_file, only: file_exists
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_products, only: level1_layout_t, level1_layout, level1_product_names, KIND_I1, KIND_I2, &
        KIND_I4, KIND_U1, KIND_U2, KIND_U4, KIND_F4, KIND_LETTER, KIND_NUMERAL, KIND_FLAG8, KIND_FLAG32
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t
    use gracecg_level1_field_forms, only: general_text
    use gracecg_level1_writer, only: level1_writer_t
    use gracecg_level1_summary, only: level1_summary_t, summarise_level1
    use gracecg_level1_conversion, only: convert_level1
    implicit none
    private
    public :: collect_level1_writer

    integer, parameter :: RECORDS = 40
    character(1), parameter :: LF = achar(10)
    character(*), parameter :: SAMPLES = '..'//'/shared/level1/samples/'

contains

    subroutine collect_level1_writer(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('every-product', test_products), &
                    new_unittest('forms-of-numbers', test_numbers), &
                    new_unittest('losses-and-what-is-refused', test_losses), &
                    new_unittest('summary', test_summary), &
                    new_unittest('official-files', test_samples)]
    end subroutine collect_level1_writer

    !> A value of a field, from all that the kind allows.
    real(dp) function any_value(kind, stream) result(value)
        integer, intent(in) :: kind
        type(random_stream_t), intent(inout) :: stream
        real(dp) :: u

        u = stream%uniform()
        select case (kind)
        case (KIND_I1)
            value = floor(256*u) - 128
        case (KIND_I2)
            value = floor(65536*u) - 32768
        case (KIND_I4)
            value = floor(4294967296.0_dp*u, i8) - 2147483648_i8
        case (KIND_U1, KIND_FLAG8)
            value = floor(256*u)
        case (KIND_U2)
            value = floor(65536*u)
        case (KIND_U4, KIND_FLAG32)
            value = floor(4294967296.0_dp*u, i8)
        case (KIND_LETTER)
            value = iachar('A') + floor(26*u)
        case (KIND_NUMERAL)
            value = 1 + floor(2*u)
        case (KIND_F4)
            value = real((u - 0.5_dp)*10.0_dp**floor(40*stream%uniform() - 20), real32)
        case default
            value = (u - 0.5_dp)*10.0_dp**floor(60*stream%uniform() - 40)
        end select
    end function any_value

    !> Records with anything that a layout allows.
    subroutine make_records(layout, satellite, values)
        type(level1_layout_t), intent(in) :: layout
        character(1), intent(in) :: satellite
        real(dp), intent(out) :: values(:, :)
        type(random_stream_t) :: stream
        integer :: i, k, bits
        integer(i8) :: flag

        stream = new_stream(5_i8, 0, 0, 1, iachar(satellite))
        do i = 1, size(values, 1)
            bits = maxval(layout%fields%bit) + 1
            flag = floor(stream%uniform()*2.0_dp**bits, i8)
            if (layout%channels > 0) flag = floor(33*stream%uniform())
            do k = 1, size(layout%fields)
                values(i, k) = any_value(layout%fields(k)%kind, stream)
                if (layout%fields(k)%bit >= 0) then
                    if (.not. btest(flag, layout%fields(k)%bit)) values(i, k) = NAN
                else if (layout%fields(k)%channel > flag) then
                    values(i, k) = NAN
                end if
            end do
            values(i, 1) = 633798000 + i
            values(i, layout%id) = iachar(satellite)
            if (layout%time_frac > 0) &
                values(i, layout%time_frac) = floor(stream%uniform()/layout%fraction_unit)
            if (layout%time_ref > 0) values(i, layout%time_ref) = iachar(merge('R', 'G', layout%product(5:5) == 'A'))
            if (layout%prod_flag > 0) values(i, layout%prod_flag) = real(flag, dp)
            if (layout%channels > 0) values(i, layout%channels) = real(flag, dp)
        end do
    end subroutine make_records

    subroutine write_records(path, layout, satellite, binary, values, failure)
        character(*), intent(in) :: path
        type(level1_layout_t), intent(in) :: layout
        character(1), intent(in) :: satellite
        logical, intent(in) :: binary
        real(dp), intent(in) :: values(:, :)
        type(error_t), allocatable, intent(out) :: failure
        type(level1_writer_t) :: writer
        type(level1_header_t) :: header
        integer :: i

        header%satellite = satellite
        header%records = size(values, 1)
        header%first_time = values(1, 1)
        header%last_time = values(size(values, 1), 1)
        call writer%open(path, layout, binary, header, failure)
        if (allocated(failure)) return
        do i = 1, size(values, 1)
            call writer%record(values(i, :))
        end do
        call writer%commit(failure)
    end subroutine write_records

    !> A file has these very values, in one block, and nothing unusual.
    subroutine check_file(error, path, values)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: path
        real(dp), intent(in) :: values(:, :)
        type(level1_reader_t) :: reader
        type(level1_block_t) :: block
        type(error_t), allocatable :: failure
        integer :: i, k

        call reader%open(path, failure)
        if (.not. allocated(failure)) call reader%next(block, failure)
        if (failed(error, failure)) return
        call check(error, block%count, size(values, 1), path)
        do k = 1, size(values, 2)
            do i = 1, size(values, 1)
                ! 16 digits of a number of single precision are not quite that number.
                if (abs(block%values(i, k) - values(i, k)) <= &
                    merge(6e-16_dp, 0.0_dp, reader%layout%fields(k)%kind == KIND_F4)*abs(values(i, k))) cycle
                if (block%values(i, k) /= block%values(i, k) .and. values(i, k) /= values(i, k)) cycle
                call check(error, block%values(i, k), values(i, k), path//': '//trim(reader%layout%fields(k)%name))
                return
            end do
        end do
        call reader%next(block, failure)
        call check_passes(error, failure)
        call check(error, size(reader%warnings), 0, path)
    end subroutine check_file

    !> Written and read, every product of both missions, text and binary; converted there and back, too.
    subroutine test_products(error)
        type(error_type), allocatable, intent(out) :: error
        character(5), allocatable :: names(:)
        character(1), parameter :: SATELLITE(2) = ['A', 'C']
        type(level1_layout_t) :: layout
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: warnings(:)
        character(:), allocatable :: text, binary
        real(dp), allocatable :: values(:, :)
        integer :: i, mission

        names = level1_product_names()
        do i = 1, size(names)
            do mission = 1, 2
                call level1_layout(names(i), mission == 2, layout, failure)
                allocate (values(RECORDS, size(layout%fields)))
                call make_records(layout, SATELLITE(mission), values)
                text = FOLDER//names(i)//'_2020-02-01_'//SATELLITE(mission)//'_04.txt'
                binary = text(:len(text) - 3)//'dat'
                call write_records(text, layout, SATELLITE(mission), .false., values, failure)
                call check_passes(error, failure)
                call check_file(error, text, values)
                if (allocated(error)) return
                if (layout%has_binary) then
                    call write_records(binary, layout, SATELLITE(mission), .true., values, failure)
                    call check_passes(error, failure)
                    call check_file(error, binary, values)
                    if (.not. allocated(error)) call convert_level1(text, binary, warnings, failure)
                    call check_passes(error, failure)
                    call check(error, size(warnings), 0, text)
                    call check_file(error, binary, values)
                    if (.not. allocated(error)) call convert_level1(binary, text, warnings, failure)
                    call check_passes(error, failure)
                    call check_file(error, text, values)
                    if (allocated(error)) return
                end if
                deallocate (values)
            end do
        end do
    end subroutine test_products

    subroutine test_numbers(error)
        type(error_type), allocatable, intent(out) :: error
        character(24), parameter :: NUMBERS(14) = [character(24) :: '0', '-1.064995712362181e-05', '1e+33', '0.0006', &
                                                   '65000', '-137.4900054931641', '0.0001192528009414673', '7.25e-05', &
                                                   '1.234567890123456e+16', '1234567890123456', '12345678901234.56', '-0.5', &
                                                   '1e-100', '0.1']
        real(dp) :: value
        integer :: i
        logical :: ok

        do i = 1, size(NUMBERS)
            call parse_real(trim(NUMBERS(i)), value, ok)
            call check(error, trim(general_text(value, .false.)), trim(NUMBERS(i)))
        end do
        call check(error, trim(general_text(real(221.8955993652344_real32, dp), .true.)), '221.8955993652344')
        call check(error, trim(general_text(NAN, .false.)), 'nan')
    end subroutine test_numbers

    !> What binary cannot keep is told.
    subroutine test_losses(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: FLAG = '00000100000000000000000000000001'
        character(*), parameter :: TNK = FOLDER//'TNK1B_2020-02-01_C_04.txt', OUT = FOLDER//'refused.dat'
        character(*), parameter :: HEAD = 'header:'//LF//'# End of YAML header'//LF
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: warnings(:)

        call make_file('ACC1A_2020-02-01_C_04.txt', 'header:'//LF//'# End of YAML header'//LF// &
                       '633798000 0 R C 00000000 '//FLAG//' 1 70000'//LF//'633798001 0 R C 00000000 '//FLAG//' 1 5'//LF)
        call convert_level1(FOLDER//'ACC1A_2020-02-01_C_04.txt', FOLDER//'ACC1A_2020-02-01_C_04.dat', warnings, failure)
        call check_passes(error, failure)
        call check_fails(error, join(padded(warnings), '; '), '1 block numbers are beyond the 16 bits')
        call make_file('TNK1B_2020-02-01_C_04.txt', 'header:'//LF//'# End of YAML header'//LF// &
                           '633798000 0 G C 1 00000000 00000011 221.7 1.507822036743164'//LF)
        call convert_level1(FOLDER//'TNK1B_2020-02-01_C_04.txt', FOLDER//'TNK1B_2020-02-01_C_04.dat', warnings, failure)
        call check_passes(error, failure)
        call check(error, size(warnings), 1)
        call check_fails(error, warnings(1)%text, '1 values of tank_pres were rounded')
        call make_file('TNK1B_2020-02-01_C_04.txt', HEAD//'633798000 0 G C 1 00000000 00000001 1e39'//LF)
        call convert_level1(TNK, OUT, warnings, failure)
        call check_fails(error, failure, 'record 1 ... tank_pres ... too large for single precision')
        call check(error, .not. file_exists(OUT), 'a file was left')
        call convert_level1(TNK, TNK, warnings, failure)
        call check_fails(error, failure, 'are the same file')
        call convert_level1(TNK, FOLDER//'no/such/folder.dat', warnings, failure)
        call check_fails(error, failure, 'there is no folder')
        call make_file('TNK1B_2020-02-01_C_04.txt', HEAD//'633798000 0 G C 1 00000000 00000001 1'//LF//'6337')
        call convert_level1(TNK, OUT, warnings, failure)
        call check_fails(error, failure, ':4: ... the line ends here')
        call check(error, .not. file_exists(OUT), 'a file was left')
        call make_file('IMU1B_2020-02-01_C_04.txt', HEAD//'633798000 0 G C 1 2 00000000'//LF)
        call convert_level1(FOLDER//'IMU1B_2020-02-01_C_04.txt', OUT, warnings, failure)
        call check_fails(error, failure, 'has no binary form')
    end subroutine test_losses

    !> Mean, extremes, gaps, doubles, disorder and flags of a file in one pass.
    subroutine test_summary(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_summary_t) :: summary
        type(error_t), allocatable :: failure

        call make_file('IMU1B_2020-02-01_C_04.txt', 'header:'//LF//'# End of YAML header'//LF// &
                       '633798000 0 G C 1 1e16 00000001'//LF//'633798000 0 G C 2 1 10000001'//LF// &
                       '633798001 0 G C 1 2 00000000'//LF//'633798001 0 G C 1 3 00000000'//LF// &
                       '633798002 0 G C 1 4 00000000'//LF//'633798003 0 G C 1 -1e16 00000000'//LF// &
                       '633798010 500000 G C 1 nan 00000000'//LF//'633798009 0 G C 1 5 00000000'//LF)
        call summarise_level1(FOLDER//'IMU1B_2020-02-01_C_04.txt', summary, failure, with_fields=.true.)
        call check_passes(error, failure)
        call check(error, summary%records == 8)
        call check(error, summary%interval, 1.0_dp)
        call check(error, all([summary%gaps, summary%duplicates, summary%unsorted] == 1))
        call check(error, all(summary%flags == [2, 0, 0, 0, 0, 0, 0, 1]))
        associate (angle => summary%fields(6))
            call check(error, angle%count == 7)
            call check(error, angle%mean(), 15.0_dp/7, 'sum without loss')
            call check(error, angle%least, -1e16_dp)
            call check(error, angle%first, 1e16_dp)
            call check(error, angle%last, 5.0_dp)
        end associate
    end subroutine test_summary

    !> Official files: text to binary to text keeps every number, and lines stay as they are but for blanks.
    subroutine test_samples(error)
        type(error_type), allocatable, intent(out) :: error
        character(5), parameter :: PRODUCTS(8) = ['MAG1A', 'THR1B', 'CLK1B', 'TNK1A', 'MAS1B', 'TIM1B', 'ACC1A', 'GNI1B']
        type(error_t), allocatable :: failure
        type(string_t), allocatable :: warnings(:)
        type(level1_reader_t) :: reader, again
        type(level1_block_t) :: block, other
        character(:), allocatable :: path
        integer :: i, k

        if (.not. file_exists(SAMPLES//'MAG1A_2023-06-01_C_04.txt')) then
            call skip_test(error, 'no official files at '//SAMPLES)
            return
        end if
        do i = 1, size(PRODUCTS)
            path = SAMPLES//PRODUCTS(i)//'_2023-06-01_C_04.txt'
            call convert_level1(path, FOLDER//'there.dat', warnings, failure)
            if (.not. allocated(failure)) call convert_level1(FOLDER//'there.dat', FOLDER//'back.txt', warnings, failure)
            if (.not. allocated(failure)) call reader%open(path, failure)
            if (.not. allocated(failure)) call again%open(FOLDER//'back.txt', failure)
            if (.not. allocated(failure)) call reader%next(block, failure)
            if (.not. allocated(failure)) call again%next(other, failure)
            call check_passes(error, failure)
            call check(error, block%count, other%count, PRODUCTS(i))
            do k = 1, size(block%values, 2)
                if (unmet(error, count(abs(block%values(:block%count, k) - other%values(:block%count, k)) > &
                                       6e-16_dp*abs(block%values(:block%count, k))), 0, &
                          PRODUCTS(i)//' '//reader%layout%fields(k)%name)) return
            end do
        end do
    end subroutine test_samples
end module test_level1_writer
