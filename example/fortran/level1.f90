!> Reads a Level-1 file of GRACE or GRACE-FO: what it holds, and the mean of each of its fields.
!>
!>     fpm run --example level1 -- MAG1A_2023-06-01_C_04.txt
!>
!> Without an argument it writes a small file of its own first, and reads that.
program level1
    use gracecg
    use gracecg_level1
    implicit none

    type(level1_records_t) :: records
    type(error_t), allocatable :: error
    character(500) :: path
    integer :: i, there

    call get_command_argument(1, path)
    if (path == '') then
        path = 'USO1B_2020-02-01_C_04.txt'
        call write_small_file(trim(path), error)
        if (allocated(error)) error stop error%message
    end if
    call read_level1(trim(path), records, error)
    if (allocated(error)) error stop error%message

    print '(3a, i0, a)', records%layout%product, ' of satellite ', records%satellite//': ', records%count, ' records'
    if (records%count == 0) stop
    print '(4a)', 'from ', gps_date_text(records%seconds(1), records%fraction(1)), ' to ', &
        gps_date_text(records%seconds(records%count), records%fraction(records%count))
    do i = 1, size(records%warnings)
        print '(2a)', 'warning: ', records%warnings(i)%text
    end do
    do i = 1, size(records%fields)
        there = count(abs(records%values(:, i)) <= huge(1.0_dp))        ! NaN: not in that record
        if (there > 0) print '(a, es24.15)', records%fields(i), &
            sum(records%values(:, i), mask=abs(records%values(:, i)) <= huge(1.0_dp))/there
    end do

contains

    !> Three records of the ultra-stable oscillator.
    subroutine write_small_file(path, error)
        character(*), intent(in) :: path
        type(error_t), allocatable, intent(out) :: error

        type(level1_layout_t) :: layout
        type(level1_header_t) :: header
        type(level1_writer_t) :: writer
        integer :: i

        call level1_layout('USO1B', .true., layout, error)
        if (allocated(error)) return
        header%satellite = 'C'
        header%records = 3
        header%first_time = 633798000
        header%last_time = 633798020
        call writer%open(path, layout, binary=.false., header=header, error=error)
        if (allocated(error)) return
        do i = 0, 2
            call writer%record([633798000.0_dp + 10*i, real(iachar('C'), dp), 1.0_dp, 4832000.25_dp, 24.5e9_dp, 32.7e9_dp, &
                                0.0_dp])
        end do
        call writer%commit(error)
    end subroutine write_small_file
end program level1
