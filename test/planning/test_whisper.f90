!> Weak tones all the time: what they reach, against the flown rotation and the whitened samples of arcs along the orbit.
module test_whisper
    use vocabulary
    use calibrations
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_activation_t, new_torque_rods
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit
    use gracecg_planning_site
    use gracecg_planning_whisper, only: whisper_limits_t, whisper_plan_t, plan_whisper
    implicit none
    private
    public :: whisper_tests

contains

    !> Of the suite `design`.
    function whisper_tests() result(tests)
        type(unittest_type), allocatable :: tests(:)

        tests = [ &
                new_unittest('tones-all-the-time-against-flown-arcs', test_reached), &
                new_unittest('tones-keep-their-limits', test_limits)]
    end function whisper_tests

    !> By the noise alone: arcs of 300 s over a revolution, flown and whitened, together. After n times as long it is about
    !> 1/sqrt(n) of that; the leakage makes it larger.
    subroutine test_reached(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ARCS = 19
        type(case_t) :: case
        type(whisper_plan_t) :: plan
        type(planned_arc_t) :: arc
        type(nominal_orbit_t) :: orbit
        type(manoeuvre_site_t) :: site
        type(manoeuvre_quality_t) :: quality
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        real(dp) :: information(3, 3), covariance(3, 3), sigma(3)
        integer :: i, k

        call take_case('front-3', case)
        call plan_whisper(case, whisper_limits_t(), plan, failure)
        case%duration = 300
        if (.not. allocated(failure)) call new_planned_arc(case, arc, failure)
        if (.not. allocated(failure)) call new_nominal_orbit(case, orbit, failure)
        if (.not. allocated(failure)) call new_torque_rods([(rod_activation_t(k, plan%tones(k)%moment, &
                                                            plan%tones(k)%frequency, 0.0_dp, 0.0_dp, case%duration), k=1, 3)], &
                                                           rods, failure)
        information = 0
        do i = 1, ARCS
            if (.not. allocated(failure)) call new_manoeuvre_site(arc, orbit, (i - 1)*orbit%revolution/ARCS, site, failure)
            if (failed(error, failure)) return
            call evaluate_manoeuvre(arc, site, rods, quality)
            information = information + inverse_3x3(quality%covariance)
        end do
        covariance = inverse_3x3(information)*ARCS*case%duration/orbit%revolution
        sigma = sigmas(covariance)
        call check(error, maxval(abs(plan%sigma_alone(:, 1)/sigma - 1)) < 0.05_dp, 'a revolution')
        sigma = sigma*sqrt(orbit%revolution/86400)          ! the field of a day's revolutions is about that of the first
        call check(error, maxval(abs(plan%sigma_alone(:, 2)/sigma - 1)) < 0.1_dp .and. &
                   maxval(abs(plan%sigma_alone(:, 3)*sqrt(7.0_dp)/sigma - 1)) < 0.1_dp, 'a day, and a week')
        call check(error, all(plan%sigma > plan%sigma_alone) .and. all(plan%sigma(:, 3) < plan%sigma(:, 2)), 'leakage')
        call check(error, all(plan%sigma(:, 2) < 10*MICROMETRE), 'a day')
    end subroutine test_reached

    !> Moment, turn and range keep their limits, and one of them is reached; the band is kept, or refused.
    subroutine test_limits(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(whisper_plan_t) :: plan, tight
        type(whisper_limits_t) :: limits
        type(error_t), allocatable :: failure

        call take_case('front-1', case)
        call plan_whisper(case, limits, plan, failure)
        if (.not. allocated(failure)) then
            limits%range = plan%range/10
            call plan_whisper(case, limits, tight, failure)
        end if
        if (failed(error, failure)) return
        associate (f => plan%tones%frequency)
            call check(error, all(f >= limits%band(1)) .and. all(f < limits%band(2) + 1e-9_dp), 'band')
            call check(error, min(abs(f(1) - f(2)), abs(f(2) - f(3)), abs(f(1) - f(3))) > 0.01_dp - 1e-9_dp, 'apart')
        end associate
        call check(error, maxval(plan%tones%moment), limits%moment, thr=1e-12_dp, more='moment')
        call check(error, plan%range < 1e-9_dp .and. tight%range < limits%range*(1 + 1e-9_dp), 'range')
        call check(error, all(tight%sigma(:, 2) > plan%sigma(:, 2)), 'less moment tells less')
        limits%moment = 31
        call plan_whisper(case, limits, plan, failure)
        call check_fails(error, failure, 'bears 30')
        limits%moment = 1
        limits%band = [0.1_dp, 0.11_dp]
        call plan_whisper(case, limits, plan, failure)
        call check_fails(error, failure, 'three tones need')
        limits%band = [0.1_dp, 6.0_dp]
        call plan_whisper(case, limits, plan, failure)
        call check_fails(error, failure, 'half of the sampling')
    end subroutine test_limits
end module test_whisper
