!> The offset from a folder of Level-1 files of GRACE or GRACE-FO, by all instruments, and without some.
!>
!>     gracecg level1 simulate front-1 --out day
!>     fpm run --example level1_estimate -- day day/setup.nml
program level1_estimate
    use gracecg
    use gracecg_level1
    implicit none

    type(level1_setup_t) :: setup
    type(level1_calibration_t) :: calibration
    type(level1_estimate_t) :: estimate
    type(error_t), allocatable :: error
    real(dp) :: no_spans(2, 0)
    character(500) :: folder, setup_file
    integer :: i, k

    if (command_argument_count() /= 2) error stop 'usage: level1_estimate FOLDER SETUP'
    call get_command_argument(1, folder)
    call get_command_argument(2, setup_file)
    call read_level1_setup(trim(setup_file), setup, error)
    ! Any satellite; spans of the SOE file or by the currents; field of the model
    if (.not. allocated(error)) &
        call gather_calibration([trim(folder)], setup, '', '', no_spans, 'model', calibration, error)
    if (.not. allocated(error)) call estimate_level1(calibration, setup, 'estimate', estimate, error)
    if (allocated(error)) error stop error%message
    print '(3a, i0, a)', 'satellite ', calibration%satellite, ': ', count(calibration%spans%used), ' spans'
    do i = 1, size(estimate%solutions)
        associate (one => estimate%solutions(i))
            print '(a, 3f10.5, a, 3f9.5, a, i0, 1x, a)', one%source, one%offset*1e3_dp, ' +-', &
                [(sqrt(one%covariance(k, k))*1e3_dp, k=1, 3)], ' mm, flag ', one%flag, trim(one%reason)
        end associate
    end do
    do i = 1, size(estimate%findings)
        print '(2a)', 'wrong: ', estimate%findings(i)%text
    end do
end program level1_estimate
