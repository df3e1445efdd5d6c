!> The Fortran 77 entry points of Level-1 files, with the numbers of the Fortran API.
module test_f77_level1
    use vocabulary
    use gracecg_level1, only: level1_records_t, read_level1, level1_setup_t, read_level1_setup, level1_calibration_t, &
        gather_calibration, level1_estimate_t, estimate_level1
    use f77_interfaces
    use level1_day, only: flaws_t, write_day, make_setup
    implicit none
    private
    public :: collect_f77_level1

contains

    subroutine collect_f77_level1(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [new_unittest('file-and-offset', test_level1)]
    end subroutine collect_f77_level1

    !> A Level-1 file, and the offset from a folder.
    subroutine test_level1(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: NMAX = 100000
        character(*), parameter :: SETUP = FOLDER//'l1_setup.nml'
        character(:), allocatable :: path
        character(200) :: msg, text
        type(level1_records_t) :: records
        type(level1_setup_t) :: settings
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(error_t), allocatable :: failure
        integer :: ih, istat, n, iflag(2)
        double precision, allocatable :: x(:)
        double precision :: d(3), cov(3, 3), gain(3), delay(2)

        call make_setup()
        call write_day('f77_level1', flaws_t(), path)
        allocate (x(NMAX))
        associate (file => path//'/MAG1B_2020-02-01_C_04.txt')
            call read_level1(file, records, failure)
            if (failed(error, failure)) return
            call gcl1op(file, ih, istat, msg)
        end associate
        call gcget(ih, 'time_seconds', NMAX, n, x, istat, msg)
        call check(error, istat == 0 .and. n == records%count, 'gcl1op: status and number')
        call check(error, all(abs(x(:records%count) - records%seconds(:records%count)) <= 0), 'gcl1op: times')
        call gcgett(ih, 'about', text, istat, msg)
        call check(error, index(text, 'MAG1B C'), 1, 'gcl1op: about '//text)
        call gcfree(ih, istat, msg)

        call read_level1_setup(SETUP, settings, failure)
        call gather_calibration([path], settings, '', '', reshape([double precision ::], [2, 0]), 'model', calibration, failure)
        call estimate_level1(calibration, settings, 'estimate', estimate, failure)
        if (failed(error, failure)) return
        call gcl1es(path, SETUP, ' ', d, cov, gain, delay, iflag, istat, msg)
        associate (first => estimate%solutions(1), rods => estimate%rods)
            call check(error, istat == 0 .and. iflag(1) == first%flag, 'gcl1es: status and flag')
            call check(error, all(abs([d - first%offset, [cov - first%covariance], delay - [rods%delay, &
                              estimate%accelerometer_delay]]) <= 0), 'gcl1es: offset, covariance, delays')
            call check(error, all(abs(gain - rods%gain*settings%rod_gain*settings%rod_sign) <= 0), 'gcl1es: gains')
            call check(error, index(msg, trim(first%reason)), 1, msg)
        end associate
        call check(error, iflag(2) >= 0 .and. iflag(2) <= 2, 'gcl1es: leakage')
    end subroutine test_level1
end module test_f77_level1
