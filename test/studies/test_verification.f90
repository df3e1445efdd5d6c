!> Section 5.3 of the report: the curves of Figures 5.2-5.8 against the printed axis windows.
module test_verification
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: report_case
    use gracecg_studies_curves
    use testdrive, only: new_unittest, unittest_type, error_type, check, test_failed
    implicit none
    private
    public :: collect_verification

contains

    subroutine collect_verification(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('windows', test_windows), &
                    new_unittest('curves-add-up', test_sums), &
                    new_unittest('a-shifted-curve-misses-its-window', test_shifted)]
    end subroutine collect_verification

    subroutine verify(name, verification, error)
        character(*), intent(in) :: name
        type(verification_t), intent(out) :: verification
        type(error_type), allocatable, intent(out) :: error

        type(case_t) :: case
        type(error_t), allocatable :: failure

        call report_case(name, case, failure)
        if (.not. allocated(failure)) call verify_case(case, verification, failure)
        if (allocated(failure)) call test_failed(error, failure%message)
    end subroutine verify

    !> All 48 windows that depend on the attitude dynamics alone; of the 36 that need the
    !> environment and surface models at least 22, and the mean of at least 30 near the window's
    !> centre.
    subroutine test_windows(error)
        type(error_type), allocatable, intent(out) :: error
        type(verification_t) :: verification
        type(window_check_t), allocatable :: checks(:)
        logical, allocatable :: attitude_only(:), inside(:)

        call verify('front-1', verification, error)
        if (allocated(error)) return
        checks = check_windows('front', verification)
        call verify('back-1', verification, error)
        if (allocated(error)) return
        checks = [checks, check_windows('back', verification)]
        attitude_only = checks%attitude_only
        inside = checks%inside
        call check(error, size(checks), 84)
        if (allocated(error)) return
        call check(error, count(attitude_only), 48)
        if (allocated(error)) return
        call check(error, count(attitude_only .and. inside), 48, &
                   'attitude windows met; missed:'//missed(attitude_only))
        if (allocated(error)) return
        call check(error, count(.not. attitude_only .and. inside) >= 22, &
                   'too few environment windows met; missed:'//missed(.not. attitude_only))
        if (allocated(error)) return
        call check(error, count(.not. attitude_only .and. checks%near_centre) >= 30, &
                   'too few environment curves near their window''s centre')

    contains

        function missed(selected) result(names)
            logical, intent(in) :: selected(:)
            character(:), allocatable :: names
            integer :: i

            names = ''
            do i = 1, size(checks)
                if (checks(i)%inside .or. .not. selected(i)) cycle
                names = names//' '//trim(checks(i)%figure)//' '//trim(checks(i)%quantity)//' '// &
                        checks(i)%axis
            end do
        end function missed
    end subroutine test_windows

    !> The curves that are sums of others.
    subroutine test_sums(error)
        type(error_type), allocatable, intent(out) :: error
        type(verification_t) :: verification

        call verify('front-1', verification, error)
        if (allocated(error)) return
        call check(error, size(verification%time), 601)
        if (allocated(error)) return
        call check(error, verification%time(600), 60.0_dp, thr=1e-12_dp)
        if (allocated(error)) return
        call check_sum('non_gravitational', [character(20) :: 'drag', 'srp', 'erp'], 1e-20_dp)
        if (allocated(error)) return
        call check_sum('a_total', [character(20) :: 'a_vel', 'a_gg', 'a_acc'], 1e-22_dp)
        if (allocated(error)) return
        call check_sum('torque_total', [character(20) :: 'torque_aero', 'torque_solar', &
                                        'torque_gravity', 'torque_magnetic'], 1e-17_dp)

    contains

        subroutine check_sum(total, parts, tolerance)
            character(*), intent(in) :: total, parts(:)
            real(dp), intent(in) :: tolerance
            real(dp) :: difference(3, 601)
            integer :: i

            difference = verification%curve(:, findloc(CURVE_NAMES == total, .true., 1), :)
            call check(error, maxval(abs(difference)) > 1e-10_dp)
            if (allocated(error)) return
            do i = 1, size(parts)
                difference = difference - &
                             verification%curve(:, findloc(CURVE_NAMES == parts(i), .true., 1), :)
            end do
            call check(error, maxval(abs(difference)), 0.0_dp, total, thr=tolerance)
        end subroutine check_sum
    end subroutine test_sums

    !> A twentieth of a window's width beyond its edge is allowed, a tenth is not.
    subroutine test_shifted(error)
        type(error_type), allocatable, intent(out) :: error
        type(verification_t) :: verification
        type(window_check_t), allocatable :: checks(:)
        real(dp), allocatable :: omega(:)
        real(dp) :: low, high
        integer :: curve, place

        call verify('front-1', verification, error)
        if (allocated(error)) return
        curve = findloc(CURVE_NAMES == 'omega', .true., 1)
        omega = verification%curve(1, curve, :)
        checks = check_windows('front', verification)
        place = findloc(checks%quantity == 'omega' .and. checks%axis == 'x', .true., 1)
        low = checks(place)%low
        high = checks(place)%high
        verification%curve(1, curve, :) = omega + high - maxval(omega) + 0.04_dp*(high - low)
        checks = check_windows('front', verification)
        call check(error, checks(place)%inside)
        if (allocated(error)) return
        verification%curve(1, curve, :) = omega + high - maxval(omega) + 0.10_dp*(high - low)
        checks = check_windows('front', verification)
        call check(error, .not. checks(place)%inside)
        if (allocated(error)) return
        call check(error, checks(place)%excess, 0.10_dp, thr=1e-10_dp)
    end subroutine test_shifted
end module test_verification
