!> Offsets with their covariance at a time: estimates that were saved with `--format json`, or rows of a CSV file.
module gracecg_estimation_saved_estimate
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, fail, add_context, number_text
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_environment_time, only: utc_of_gps, utc_t, parse_utc
    use gracecg_files_json, only: read_json_file, read_json_numbers, read_json_text
    use gracecg_estimation_offset_change, only: offset_change_t, read_offset_rows
    implicit none
    private
    public :: dated_offset_t, read_offsets

    real(dp), parameter :: SYMMETRIC = 1e-6_dp  !! Relative difference of elements that are the same but for rounding
    real(dp), parameter :: MOST_OFFSET = 1      !! Of a satellite, m

    type :: dated_offset_t
        !! An offset that was estimated
        type(utc_t) :: time    !! Epoch of the calibration, UTC
        real(dp) :: offset(3) = 0           !! Body axes, m
        real(dp) :: covariance(3, 3) = 0    !! m^2
        character(1) :: satellite = ''      !! Of Level-1 data; empty: not said
        logical :: moves_masses = .true.    !! Its own action is not to calibrate again; rows of CSV files have none
    end type dated_offset_t

contains

    !> Reads offsets with their times: one from a saved estimate (of `gracecg estimate` or `level1 estimate`), or all rows
    !> of a CSV file (read_offset_rows). Fails when the file is neither, or an offset has no covariance.
    subroutine read_offsets(path, offsets, error)
        character(*), intent(in) :: path        !! Of the file; a name that ends with .csv is that of a CSV file
        type(dated_offset_t), allocatable, intent(out) :: offsets(:)
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: text, command
        logical :: ok
        integer :: i

        if (index(path, '.csv', back=.true.) == len_trim(path) - 3 .and. len_trim(path) > 4) then
            call read_csv_offsets(path, offsets, error)
            return
        end if
        allocate (offsets(1))
        call read_json_file(path, text, error)
        if (allocated(error)) return
        call read_json_text(text, 'command', command, ok)
        if (command == 'level1 estimate') then
            call read_level1_offset(text, offsets(1), error)
        else
            call read_offset(text, offsets(1), error)
        end if
        call read_json_text(text, 'action.kind', command, ok)
        if (ok) offsets(1)%moves_masses = command /= 'calibrate again'
        if (.not. allocated(error)) then
            if (.not. all([(offsets(1)%covariance(i, i), i=1, 3)] > 0)) then
                call fail(error, 'the offset has no covariance; estimate it with noise levels in setup.nml')
            else if (any(abs(offsets(1)%covariance - transpose(offsets(1)%covariance)) > &
                         SYMMETRIC*maxval(abs(offsets(1)%covariance)))) then
                call fail(error, 'the covariance of the offset is not symmetric: the file has been changed')
            else if (.not. all(abs(offsets(1)%offset) <= MOST_OFFSET)) then
                call fail(error, 'an offset of '//number_text(maxval(abs(offsets(1)%offset)))//' m: at most 1 m is allowed')
            end if
        end if
        call add_context(error, path)
    end subroutine read_offsets

    !> Of what `gracecg estimate --format json` prints. Fails when its action says that it is not to be used.
    subroutine read_offset(text, offset, error)
        character(*), intent(in) :: text
        type(dated_offset_t), intent(inout) :: offset
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: value, wrong
        real(dp), allocatable :: values(:), elements(:), matrix(:, :)
        logical :: ok
        integer :: n

        call read_json_text(text, 'command', value, ok)
        if (ok) ok = value == 'estimate'
        if (ok) call read_json_text(text, 'epoch_utc', value, ok)
        if (.not. ok) then
            call fail(error, 'is no estimate: save one with gracecg estimate DIR --algorithm NAME --format json')
            return
        end if
        call parse_utc(value, offset%time, error)
        if (allocated(error)) return
        call read_json_text(text, 'action.kind', value, ok)
        if (value == 'do not use' .or. value == 'not tested') then
            call read_json_text(text, 'action.text', value, ok)
            call fail(error, 'this estimate is not to be used ('//value//'): leave it out')
            return
        end if
        wrong = ''
        call read_json_numbers(text, 'offset_m', values, ok, wrong)
        if (ok) call read_json_numbers(text, 'covariance.matrix', elements, ok, wrong)
        n = 0
        if (ok) n = nint(sqrt(real(size(elements), dp)))
        if (.not. ok .or. n < 3 .or. n**2 /= size(elements) .or. size(values) /= 3) then
            call fail(error, 'has no members "offset_m" and "covariance" of numbers'//wrong// &
                      ': save the estimate with this version')
            return
        end if
        matrix = reshape(elements, [n, n])
        offset%offset = values
        offset%covariance = matrix(:3, :3)
    end subroutine read_offset

    !> The first source of what `gracecg level1 estimate --format json` prints, SRF being body axes. Fails when its flag
    !> says that it is not to be used.
    subroutine read_level1_offset(text, offset, error)
        character(*), intent(in) :: text
        type(dated_offset_t), intent(inout) :: offset
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: epoch(:), values(:), matrix(:), flag(:)
        character(:), allocatable :: reason, wrong, satellite
        integer(i8) :: second
        logical :: ok

        wrong = ''
        call read_json_numbers(text, 'epoch_gps_s', epoch, ok, wrong)
        if (ok) call read_json_numbers(text, 'offset_mm', values, ok, wrong)
        if (ok) call read_json_numbers(text, 'covariance_mm2', matrix, ok, wrong)
        if (ok) call read_json_numbers(text, 'flag', flag, ok, wrong)
        if (ok) ok = size(epoch) == 1 .and. size(values) == 3 .and. size(matrix) == 9 .and. size(flag) == 1
        if (.not. ok) then
            call fail(error, 'has no members "epoch_gps_s", "offset_mm", "covariance_mm2" and "flag"'//wrong//' as '// &
                      'gracecg level1 estimate --format json prints them')
            return
        end if
        if (flag(1) > 1) then
            call read_json_text(text, 'reason', reason, ok)
            call fail(error, 'this estimate is not to be used (flag 2: '//reason//'): leave it out')
            return
        end if
        call read_json_text(text, 'satellite', satellite, ok)
        if (ok) offset%satellite = satellite
        second = floor(epoch(1), i8)
        offset%time = utc_of_gps(second, epoch(1) - real(second, dp))
        offset%offset = values*MILLIMETRE
        offset%covariance = reshape(matrix, [3, 3])*MILLIMETRE**2
    end subroutine read_level1_offset

    subroutine read_csv_offsets(path, offsets, error)
        character(*), intent(in) :: path
        type(dated_offset_t), allocatable, intent(out) :: offsets(:)
        type(error_t), allocatable, intent(out) :: error

        type(offset_change_t), allocatable :: rows(:)
        integer :: i, axis

        call read_offset_rows(path, .false., rows, error)
        if (allocated(error)) return
        allocate (offsets(size(rows)))
        do i = 1, size(rows)
            offsets(i)%time = rows(i)%time
            offsets(i)%offset = rows(i)%change
            do axis = 1, 3
                offsets(i)%covariance(axis, axis) = rows(i)%sigma(axis)**2
            end do
        end do
    end subroutine read_csv_offsets
end module gracecg_estimation_saved_estimate
