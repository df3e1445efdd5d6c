!> Section 5.3 of the report: the curves of Figures 5.2-5.8 against the printed axis windows.
module test_verification
    use vocabulary
    use calibrations
    use gracecg_planning_calibration, only: calibration_text, calibration_from_text
    use gracecg_studies_published
    use gracecg_studies_campaign, only: campaign_t, new_campaign
    use gracecg_studies_curves
    use gracecg_studies_estimate_windows
    use gracecg_studies_published, only: published_axis
    use gracecg_studies_published
    use gracecg_studies_table_axis_limits, only: LIMIT_FIGURE, LIMIT_LOW, LIMIT_HIGH, LIMIT_STEP
    use gracecg_studies_table_figure_windows, only: WINDOW_LOW, WINDOW_HIGH, WINDOW_STEP
    implicit none
    private
    public :: collect_verification

contains

    subroutine collect_verification(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('windows', test_windows), &
                    new_unittest('tick-marks', test_ticks), &
                    new_unittest('small-curves-miss-the-ticks', test_small), &
                    new_unittest('points-of-figures-6.2-and-6.3', test_estimates), &
                    new_unittest('a-case-by-its-settings', test_built_in), &
                    new_unittest('earthlight-by-the-distance-of-the-sun', test_earthlight), &
                    new_unittest('a-shifted-curve-misses-its-window', test_shifted)]
    end subroutine collect_verification

    logical function verify_fails(name, verification, error)
        character(*), intent(in) :: name
        type(verification_t), intent(out) :: verification
        type(error_type), allocatable, intent(inout) :: error
        type(case_t) :: case
        type(error_t), allocatable :: failure

        call take_case(name, case)
        call verify_case(case, verification, failure)
        verify_fails = failed(error, failure)
    end function verify_fails

    !> All 54 windows that depend on the attitude dynamics alone, and nearly all of them reached at both ends; of
    !> the 36 that need the
    !> environment and surface models at least 22, and the mean of at least 30 near the window's
    !> centre.
    subroutine test_windows(error)
        type(error_type), allocatable, intent(out) :: error
        type(verification_t) :: verification
        type(window_check_t), allocatable :: checks(:)
        logical, allocatable :: attitude_only(:), inside(:)

        if (verify_fails('front-1', verification, error)) return
        checks = check_windows('front', verification)
        if (verify_fails('back-1', verification, error)) return
        checks = [checks, check_windows('back', verification)]
        attitude_only = checks%attitude_only
        inside = checks%inside
        if (unmet(error, size(checks), 90)) return
        if (unmet(error, count(attitude_only), 54)) return
        if (unmet(error, count(attitude_only .and. inside), 54, &
                  'attitude windows met; missed:'//missed(attitude_only))) return
        if (unmet(error, count(attitude_only .and. checks%on_ticks) >= 50, 'too few end intervals reached')) return
        call check(error, all(checks%fill >= 0 .and. checks%fill <= 1) .and. &
                   minval(checks%fill, attitude_only) > 0.35_dp, 'fill')
        if (unmet(error, count(.not. attitude_only .and. inside) >= 22, &
                  'too few environment windows met; missed:'//missed(.not. attitude_only))) return
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

    !> The Earth's light, proportional to E_s, with that at the Earth's distance from the Sun: all six windows are met.
    !> With E_s at 1 au, as printed after (2-10), 0.9833^2 of it on 2 January, one is.
    subroutine test_earthlight(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SUN_DISTANCE = 0.9833_dp     !! au; perihelion is on 1 January 1989
        character(5), parameter :: SATELLITES(2) = [character(5) :: 'front', 'back']
        type(verification_t) :: verification
        type(window_check_t), allocatable :: checks(:)
        integer :: i, curve, met(2)

        met = 0
        do i = 1, 2
            if (verify_fails(trim(SATELLITES(i))//'-1', verification, error)) return
            curve = findloc(CURVE_NAMES == 'erp', .true., 1)
            checks = check_windows(trim(SATELLITES(i)), verification)
            met(1) = met(1) + count(checks%inside .and. checks%quantity == 'erp')
            verification%curve(:, curve, :) = SUN_DISTANCE**2*verification%curve(:, curve, :)
            checks = check_windows(trim(SATELLITES(i)), verification)
            met(2) = met(2) + count(checks%inside .and. checks%quantity == 'erp')
        end do
        call check(error, met(1), 6)
        call check(error, met(2), 1)
    end subroutine test_earthlight

    !> A twentieth of a window's width beyond its edge is allowed, a tenth is not.
    subroutine test_shifted(error)
        type(error_type), allocatable, intent(out) :: error
        type(verification_t) :: verification
        type(window_check_t), allocatable :: checks(:)
        real(dp), allocatable :: omega(:)
        real(dp) :: low, high
        integer :: curve, place

        if (verify_fails('front-1', verification, error)) return
        curve = findloc(CURVE_NAMES == 'omega', .true., 1)
        omega = verification%curve(1, curve, :)
        checks = check_windows('front', verification)
        place = findloc(checks%quantity == 'omega' .and. checks%axis == 'x', .true., 1)
        low = checks(place)%low
        high = checks(place)%high
        verification%curve(1, curve, :) = omega + high - maxval(omega) + 0.04_dp*(high - low)
        checks = check_windows('front', verification)
        call check(error, checks(place)%inside)
        verification%curve(1, curve, :) = omega + high - maxval(omega) + 0.10_dp*(high - low)
        checks = check_windows('front', verification)
        call check(error, .not. checks(place)%inside)
        call check(error, checks(place)%excess, 0.10_dp, thr=1e-10_dp)
    end subroutine test_shifted

    !> Limits by hand, and the share of an axis that a curve covers.
    !> The printed limits of all figures are marks of the printed step, 2 to 4 intervals apart.
    subroutine test_ticks(error)
        type(error_type), allocatable, intent(out) :: error
        integer :: i

        call check(error, same_limits(limits_on_ticks(-1.97_dp, 1.88_dp, 1.0_dp), [-2.0_dp, 2.0_dp], 1.0_dp))
        call check(error, same_limits(limits_on_ticks(0.0_dp, 4.0_dp, 2.0_dp), [0.0_dp, 4.0_dp], 2.0_dp), 'ends on marks')
        call check(error, share_covered(1.0_dp, 2.0_dp, 0.0_dp, 4.0_dp), 0.25_dp, thr=1e-15_dp)
        call check(error, abs(share_covered(5.0_dp, 6.0_dp, 0.0_dp, 4.0_dp)) <= 0)
        call check(error, size(WINDOW_STEP), 90)
        do i = 1, size(WINDOW_STEP)
            call check_axis(WINDOW_LOW(i), WINDOW_HIGH(i), WINDOW_STEP(i))
        end do
        do i = 1, size(LIMIT_STEP)
            if (any(LIMIT_FIGURE(i) == ['6.2', '6.3', '6.6'])) call check_axis(LIMIT_LOW(i), LIMIT_HIGH(i), LIMIT_STEP(i))
        end do

    contains

        subroutine check_axis(low, high, step)
            real(dp), intent(in) :: low, high, step

            call check(error, same_limits(limits_on_ticks(low, high, step), [low, high], step), 'ends on marks')
            call check(error, any(nint((high - low)/step) == [2, 3, 4]), 'intervals')
        end subroutine check_axis
    end subroutine test_ticks

    !> A tenth of the printed curve stays inside, but reaches the ends of few windows.
    subroutine test_small(error)
        type(error_type), allocatable, intent(out) :: error
        type(verification_t) :: verification
        type(window_check_t), allocatable :: checks(:)
        integer :: curve

        if (verify_fails('back-1', verification, error)) return
        curve = findloc(CURVE_NAMES == 'torque_magnetic', .true., 1)
        verification%curve(:, curve, :) = verification%curve(:, curve, :)/10
        checks = check_windows('back', verification)
        checks = pack(checks, checks%quantity == 'torque_magnetic')
        call check(error, size(checks), 3)
        call check(error, all(checks%inside) .and. .not. any(checks%on_ticks))
    end subroutine test_small

    !> Points made up: on the middle of each window, and of the first run at its ends.
    subroutine test_estimates(error)
        type(error_type), allocatable, intent(out) :: error
        type(campaign_t) :: campaign
        type(estimate_window_t) :: windows(12)
        real(dp) :: limits(3)
        integer :: a, i, axis, k

        campaign = new_campaign(REPORT_ESTIMATORS, 6, 1_i8, 20, 1, 1)
        do i = 1, 6
            do a = 1, 4
                campaign%entries(a, i)%run = [(k, k=1, 20)]
                campaign%entries(a, i)%offset = reshape([(0.0_dp, k=1, 60)], [3, 20])
                do axis = 1, 3
                    limits = published_axis(merge('6.2', '6.3', i <= 3), merge('front', 'back ', i <= 3), &
                                            REPORT_ESTIMATORS(a), AXES(axis))/MILLIMETRE
                    campaign%entries(a, i)%offset(axis, :) = sum(limits(:2))/2
                    campaign%entries(a, i)%offset(axis, :2) = limits(:2)*0.999_dp + sum(limits(:2))/2*0.001_dp
                end do
            end do
        end do
        windows = campaign_windows(campaign, 2)
        call check(error, size(windows) == 12 .and. sum(windows%points) == 12*60 .and. sum(windows%inside) == 12*60)
        call check(error, count(windows%on_ticks), 12)
        call check(error, minval(windows%fill), 0.999_dp, thr=1e-9_dp)
        ! three of 60 points beyond one window; they are no points of the figure but for the first
        campaign%entries(3, 5)%offset(1, [1, 16, 17]) = 1000
        windows = campaign_windows(campaign, 2)
        call check(error, windows(7)%inside == 57 .and. .not. windows(7)%on_ticks .and. windows(8)%inside == 60)
        do a = 1, 4
            campaign%entries(a, 4)%offset(:, :10) = 1000
        end do
        windows = campaign_windows(campaign, 2)
        call check(error, sum(windows%inside) < LEAST_SHARE_INSIDE*sum(windows%points), 'too many outside')
    end subroutine test_estimates

    !> A case is the report's by its settings: a name does not matter, any setting does.
    subroutine test_built_in(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration, back
        type(error_t), allocatable :: failure
        character(:), allocatable :: text
        character(16) :: name
        integer :: i, checksum

        do i = 1, size(REPORT_CASE_NAMES)
            call take_calibration(REPORT_CASE_NAMES(i), calibration)
            if (.not. allocated(failure)) then
                calibration%case%name = 'another name'
                call calibration_text(calibration, text, failure)
            end if
            if (.not. allocated(failure)) call calibration_from_text(text, 'text', back, failure)
            if (.not. allocated(failure)) call settings_checksum(back, checksum, failure)
            if (allocated(failure)) then
                call test_failed(error, failure%message)
                return
            end if
            call built_in_case(back%case, name)
            call check(error, trim(name), REPORT_CASE_NAMES(i), 'through a file')
            call built_in_calibration('another name', checksum, name)
            call check(error, trim(name), REPORT_CASE_NAMES(i), 'by checksum')
        end do
        back%case%name = 'back-3'
        back%options%accelerometer_weight(1) = 11
        call settings_checksum(back, checksum, failure)
        call built_in_calibration('back-3', checksum, name)
        call check(error, trim(name), '', 'other weights')
        call built_in_case(back%case, name)
        call check(error, trim(name), 'back-3', 'weights are not of the case')
        back%case%satellite%mass = 421
        call built_in_case(back%case, name)
        call check(error, trim(name), '', 'another mass')
    end subroutine test_built_in
end module test_verification
