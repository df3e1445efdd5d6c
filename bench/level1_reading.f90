!> How fast Level-1 files are read: records a second of a day of ACC1A, text and binary, beside a plain copy.
!>
!>     fpm run --profile release --example level1_reading [-- FOLDER]
!>
!> A made day (864 000 records, 150 MB of text) is written into the folder (by default build/level1-bench) when it
!> is not there. Each number is the best of three; bench/level1_pandas.py reads the same text with pandas.
program level1_reading
    use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_files_file, only: file_exists, make_directory, input_stream_t, output_file_t
    use gracecg_level1_header, only: level1_header_t
    use gracecg_level1_products, only: level1_layout_t, level1_layout
    use gracecg_level1_reader, only: level1_reader_t, level1_block_t
    use gracecg_level1_writer, only: level1_writer_t
    implicit none

    integer, parameter :: RECORDS = 864000, TRIES = 3
    character(*), parameter :: NAME = '/ACC1A_2020-02-01_C_04.'
    type(error_t), allocatable :: error
    character(200) :: folder
    integer :: status

    call get_command_argument(1, folder, status=status)
    if (status /= 0) folder = 'build/level1-bench'
    call make_directory(trim(folder), error)
    if (.not. allocated(error)) call make_day(trim(folder)//NAME//'txt', .false., error)
    if (.not. allocated(error)) call make_day(trim(folder)//NAME//'dat', .true., error)
    if (.not. allocated(error)) call time_file(trim(folder)//NAME//'txt', 'text', error)
    if (.not. allocated(error)) call time_file(trim(folder)//NAME//'dat', 'binary', error)
    if (allocated(error)) then
        write (error_unit, '(a)') error%message
        error stop 1
    end if

contains

    !> Writes the day, if it is not there.
    subroutine make_day(path, binary, error)
        character(*), intent(in) :: path
        logical, intent(in) :: binary
        type(error_t), allocatable, intent(out) :: error

        type(level1_layout_t) :: layout
        type(level1_header_t) :: header
        type(level1_writer_t) :: writer
        type(random_stream_t) :: stream
        real(dp), allocatable :: values(:)
        integer :: i, k

        if (file_exists(path)) return
        call level1_layout('ACC1A', .true., layout, error)
        if (allocated(error)) return
        header%satellite = 'C'
        header%records = RECORDS
        header%first_time = 633787200
        header%last_time = 633873599.9_dp
        call writer%open(path, layout, binary, header, error)
        if (allocated(error)) return
        allocate (values(size(layout%fields)), source=0.0_dp)
        stream = new_stream(1_i8, 0, 0, 1, 1)
        values(layout%time_ref) = iachar('R')
        values(layout%id) = iachar('C')
        values(layout%prod_flag) = 2**26 + 63
        do i = 0, RECORDS - 1
            values(1) = 633787200 + i/10
            values(2) = 100000*mod(i, 10)
            do k = layout%prod_flag + 1, layout%prod_flag + 6
                values(k) = 1e-5_dp*(stream%uniform() - 0.5_dp)
            end do
            call writer%record(values)
        end do
        call writer%commit(error)
    end subroutine make_day

    !> Times a plain copy and the reader.
    subroutine time_file(path, form, error)
        character(*), intent(in) :: path, form
        type(error_t), allocatable, intent(out) :: error

        type(level1_reader_t) :: reader
        type(level1_block_t) :: block
        integer(i8) :: start, finish, rate, bytes
        real(dp) :: copying, reading, processor, before, after, total
        integer :: i

        copying = huge(1.0_dp)
        reading = huge(1.0_dp)
        processor = huge(1.0_dp)
        inquire (file=path, size=bytes)
        do i = 1, TRIES
            call system_clock(start, rate)
            call copy_file(path, error)
            if (allocated(error)) return
            call system_clock(finish)
            copying = min(copying, real(finish - start, dp)/rate)
            call system_clock(start)
            call cpu_time(before)
            call reader%open(path, error)
            total = 0
            do
                if (.not. allocated(error)) call reader%next(block, error)
                if (allocated(error)) return
                if (block%count == 0) exit
                total = total + sum(block%values(:block%count, 7))
            end do
            call system_clock(finish)
            reading = min(reading, real(finish - start, dp)/rate)
            call cpu_time(after)
            processor = min(processor, after - before)
        end do
        write (output_unit, '(a, t9, f6.1, a, f7.3, 2(a, f7.3, a, es9.2), a, es10.2, a)') form, real(bytes, dp)/1e6_dp, &
            ' MB: copied in', copying, ' s, read in', reading, ' s:', real(reader%records, dp)/reading, &
            ' records/s, of the processor', processor, ' s:', real(reader%records, dp)/processor, &
            ' records/s (sum of lin_accl_x', total, ')'
    end subroutine time_file

    !> The bytes of a file into another one.
    subroutine copy_file(path, error)
        character(*), intent(in) :: path
        type(error_t), allocatable, intent(out) :: error

        type(input_stream_t) :: input
        type(output_file_t) :: output
        character(:), allocatable :: buffer
        integer :: count

        allocate (character(2**21) :: buffer)
        call input%open(path, error)
        if (.not. allocated(error)) call output%open(path//'.copy', error)
        do
            if (allocated(error)) return
            call input%read(buffer, count, error)
            if (count == 0) exit
            call output%bytes(buffer(:count))
        end do
        if (.not. allocated(error)) call output%commit(error)
    end subroutine copy_file
end program level1_reading
