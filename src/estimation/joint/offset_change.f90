!> Known changes of the offset: masses that were moved, at a time, with how well that is known.
module gracecg_estimation_offset_change
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, join
    use gracecg_environment_time, only: utc_t, parse_utc, seconds_between
    use gracecg_files_table, only: table_file_t, read_csv
    implicit none
    private
    public :: offset_change_t, read_changes, read_offset_rows, read_dated_rows, is_between

    type :: offset_change_t
        !! One movement of masses
        type(utc_t) :: time    !! When it happened, UTC
        real(dp) :: change(3) = 0   !! Of d, body axes, m
        real(dp) :: sigma(3) = 0    !! Of the change, m; 0: exact
    end type offset_change_t

    character(11), parameter :: COLUMNS(7) = [character(11) :: 'time_utc', 'dx_mm', 'dy_mm', 'dz_mm', 'sigma_x_mm', &
                                              'sigma_y_mm', 'sigma_z_mm']

contains

    !> Reads changes from a CSV file. Fails as read_offset_rows does.
    subroutine read_changes(path, changes, error)
        character(*), intent(in) :: path        !! Of the file
        type(offset_change_t), allocatable, intent(out) :: changes(:)
        type(error_t), allocatable, intent(out) :: error

        call read_offset_rows(path, .true., changes, error)
    end subroutine read_changes

    !> Reads changes, or offsets, from a CSV file: time_utc (ISO 8601), d and its standard deviations in mm. Fails, with file
    !> and line, when something is not a time or a number, or a standard deviation is negative or, where it must not be, 0.
    subroutine read_offset_rows(path, may_be_exact, changes, error)
        character(*), intent(in) :: path        !! Of the file
        logical, intent(in) :: may_be_exact     !! A standard deviation may be 0
        type(offset_change_t), allocatable, intent(out) :: changes(:)
        type(error_t), allocatable, intent(out) :: error

        type(table_file_t) :: file
        type(utc_t), allocatable :: time(:)
        real(dp), allocatable :: values(:, :)
        integer :: i, axis

        call read_dated_rows(path, COLUMNS, file, time, values, error)
        if (allocated(error)) return
        values = values*MILLIMETRE
        changes = [(offset_change_t(time(i), values(:3, i), values(4:, i)), i=1, size(time))]
        do i = 1, size(time)
            do axis = 1, 3
                if (changes(i)%sigma(axis) > 0 .or. may_be_exact .and. .not. changes(i)%sigma(axis) < 0) cycle
                call file%fail_at(i, 'column '//trim(COLUMNS(4 + axis))//': a standard deviation '// &
                                  trim(merge('is negative        ', 'has to be positive ', may_be_exact)), error)
                return
            end do
        end do
    end subroutine read_offset_rows

    !> Did a change come after one time and not after another?
    elemental logical function is_between(change, from, to)
        type(offset_change_t), intent(in) :: change
        type(utc_t), intent(in) :: from, to

        is_between = seconds_between(from, change%time) > 0 .and. seconds_between(change%time, to) >= 0
    end function is_between

    !> Rows of a CSV file that begin with a time in ISO 8601, all else numbers.
    subroutine read_dated_rows(path, columns, file, time, values, error)
        character(*), intent(in) :: path, columns(:)    !! The file; names of its columns
        type(table_file_t), intent(out) :: file
        type(utc_t), allocatable, intent(out) :: time(:)
        real(dp), allocatable, intent(out) :: values(:, :)      !! (column - 1, row), in the file's units
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: fields(:)
        type(error_t), allocatable :: problem
        integer :: i, k

        call read_csv(path, columns, file, error)
        if (allocated(error)) return
        allocate (time(file%row_count()), values(size(columns) - 1, file%row_count()))
        do i = 1, size(time)
            call file%get_fields(i, size(columns), join(columns, ','), fields, error)
            if (allocated(error)) return
            call parse_utc(trim(fields(1)%text), time(i), problem)
            if (allocated(problem)) then
                call file%fail_at(i, 'column '//trim(columns(1))//': '//problem%message, error)
                return
            end if
            do k = 2, size(columns)
                call file%get_real(i, fields(k), 'column '//trim(columns(k)), values(k - 1, i), error)
                if (allocated(error)) return
            end do
        end do
    end subroutine read_dated_rows
end module gracecg_estimation_offset_change
