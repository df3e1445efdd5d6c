!> What the Fortran 77 entry points of Level-1 data need beside the C interface.
module gracecg_level1_f77_support
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_null_char, c_size_t
    use gracecg_base_kinds, only: dp
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, MESSAGE_SIZE
    use gracecg_level1_c_estimate, only: c_level1_offset_t, c_estimate_level1_day
    implicit none
    private
    public :: level1_arrays

contains

    !> The offset from Level-1 files; with STATUS_OK the message says why its flag is not 0.
    function level1_arrays(dir, setup, sat, day, src, d, cov, gain, delay, iflag, error) result(status)
        character(*), intent(in) :: dir, setup, sat, day, src   !! As C wants them
        real(dp), intent(inout) :: d(3), cov(3, 3)          !! Offset and covariance, SRF, m, m^2
        real(dp), intent(inout) :: gain(3), delay(2)        !! Of the rods, A m^2/mA; torque, accelerometer, s
        integer, intent(inout) :: iflag(2)                  !! Flag; what was done about leakage
        type(c_error_t), intent(inout) :: error
        integer(c_int) :: status                            !! A gracecg_status

        integer, parameter :: TEXT_SIZE = 16*MESSAGE_SIZE   ! More than all findings together
        character(kind=c_char) :: words(TEXT_SIZE)
        type(c_level1_offset_t) :: offset

        words(1) = c_null_char
        status = c_estimate_level1_day(dir, setup, sat, day, 0_c_size_t, source=src, c_offset=offset, text=words, &
                                       size=size(words, kind=c_size_t), error=error)
        if (status /= STATUS_OK) return
        error%message = words(:MESSAGE_SIZE)
        error%message(MESSAGE_SIZE) = c_null_char
        d = offset%offset
        cov = offset%covariance
        gain = offset%gain
        delay = [offset%torque_delay, offset%accelerometer_delay]
        iflag = [offset%flag, offset%leakage]
    end function level1_arrays
end module gracecg_level1_f77_support
