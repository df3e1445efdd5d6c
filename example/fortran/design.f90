!> Plans a manoeuvre: the best one at the place of case front-2, where the built-in one hardly sees the x
!> axis, and how good it is along the orbit.
!>
!>     gfortran design.f90 $(pkg-config --cflags --libs gracecg)
!>
!> The numbers are those of `gracecg design front-2 --waveforms sine`.
program design
    use gracecg, only: dp, DEGREE, MILLIMETRE, error_t, calibration_t, find_calibration, case_bound_t, &
        bound_of_case, &
        design_settings_t, manoeuvre_design_t, plan_manoeuvre, map_case, map_point_t, WAVEFORM_NAMES
    implicit none
    type(calibration_t) :: calibration, planned
    type(design_settings_t) :: settings             ! begins with what `gracecg design` begins with
    type(manoeuvre_design_t) :: best
    type(map_point_t), allocatable :: points(:)
    type(case_bound_t) :: limit
    type(error_t), allocatable :: error
    integer :: i

    call find_calibration('front-2', calibration, error)
    if (allocated(error)) error stop error%message
    settings%waveform_used = WAVEFORM_NAMES == 'sine'
    settings%threads = 2
    call plan_manoeuvre(calibration, 0.0_dp, settings, planned, best, error)
    if (allocated(error)) error stop error%message

    print '(a)', 'rod   amplitude, A m^2     frequency, Hz        phase, deg'
    do i = 1, best%rods%count
        associate (rod => best%rods%activations(i))
            print '(a, 3f19.6)', 'xyz'(rod%axis:rod%axis), rod%amplitude, rod%frequency, rod%phase/DEGREE
        end associate
    end do
    print '(a, 3es18.9, a)', 'sigma   ', best%sigma/MILLIMETRE, ' mm'
    print '(a, 3es18.9, a)', 'wave    ', best%wave/MILLIMETRE, ' mm'
    print '(a, 3es18.9, a)', 'force   ', best%force/MILLIMETRE, ' mm'

    ! `planned` is a case like any other, and how to estimate it: it can be simulated, written, and has a bound
    call bound_of_case(planned%case, planned%options, limit, error)
    if (allocated(error)) error stop error%message
    print '(a, 3es18.9, a)', 'bound   ', limit%sigma/MILLIMETRE, ' mm'

    ! the same manoeuvre every ten minutes along the orbit
    call map_case(planned%case, [(600.0_dp*i, i=0, 8)], settings%threads, points, error)
    if (allocated(error)) error stop error%message
    print '(a)', 'time, s  latitude, deg  sigma x, y, z, mm'
    do i = 1, size(points)
        print '(f8.1, f15.3, 3es18.9)', points(i)%time, points(i)%latitude/DEGREE, &
            points(i)%quality%sigma/MILLIMETRE
    end do
end program design
