!> The running estimate of a filter as a CSV file.
module gracecg_cli_running_file
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_estimation_running_estimate, only: running_estimate_t
    implicit none
    private
    public :: write_running_estimate

    character(*), parameter :: COLUMNS = &
        'time_s,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,sigma_z_mm,edited_accelerometer,edited_star_camera'

contains

    !> Writes a row an epoch. Fails when the file cannot be written, and then leaves none half-written.
    subroutine write_running_estimate(path, running, error)
        character(*), intent(in) :: path    !! Of the CSV file
        type(running_estimate_t), intent(in) :: running
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        integer :: k

        call file%open(path, COLUMNS, [character(1) ::], error)
        if (allocated(error)) return
        do k = lbound(running%time, 1), ubound(running%time, 1)
            call file%row([running%time(k), running%offset(:, k)/MILLIMETRE, running%sigma(:, k)/MILLIMETRE, &
                           real(running%edited_accelerometer(k), dp), real(running%edited_star_camera(k), dp)])
        end do
        call file%commit(error)
    end subroutine write_running_estimate
end module gracecg_cli_running_file
