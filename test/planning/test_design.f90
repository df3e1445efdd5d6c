!> The planner: the search and its guarantees, places and plans. How good manoeuvres are at a place: test_site.
module test_design
    use vocabulary
    use calibrations
    use gracecg_spacecraft_torque_rods
    use gracecg_base_quaternion, only: rotation_angle_between
    use gracecg_simulation_case, only: read_case, case_text
    use gracecg_simulation_report_cases, only: TIME_OF_CASE
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit
    use gracecg_planning_planner, only: moved_case
    use gracecg_planning_site
    use gracecg_planning_scan
    use gracecg_planning_candidates
    use gracecg_planning_design
    use gracecg_planning_planner
    use test_site, only: site_tests, stand, three_rods
    use test_whisper, only: whisper_tests
    implicit none
    private
    public :: collect_design

contains

    subroutine collect_design(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    site_tests(), &
                    whisper_tests(), &
                    new_unittest('ten-micrometres-in-all-cases', test_all_cases), &
                    new_unittest('ten-micrometres-everywhere', test_everywhere), &
                    new_unittest('limits-are-kept', test_limits), &
                    new_unittest('best-place', test_place), &
                    new_unittest('threads', test_threads), &
                    new_unittest('moved-case', test_moved_case), &
                    new_unittest('plan', test_plan), &
                    new_unittest('refuses-impossible', test_refused)]
    end subroutine collect_design

    !> A quick search: cycles 6 and 7 only.
    function quick_settings(waveform) result(settings)
        integer, intent(in) :: waveform
        type(design_settings_t) :: settings

        settings%lowest_frequency = 0.1_dp
        settings%highest_frequency = 7/60.0_dp
        settings%refinement_steps = 25
        settings%waveform_used = .false.
        settings%waveform_used(waveform) = .true.
    end function quick_settings

    !> Two-sided noise: every axis is below 10 micrometres, with the errors by the forces; and the search is at
    !> least as good as 5, 6, 7 cycles where these are allowed, noise alone and with the errors.
    subroutine test_all_cases(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t) :: site
        type(manoeuvre_design_t) :: design, pattern
        type(design_settings_t) :: settings
        type(error_t), allocatable :: failure
        integer :: number

        do number = 1, size(REPORT_CASE_NAMES)
            call take_case(REPORT_CASE_NAMES(number), case)
            call stand(case, planned, site)
            settings = quick_settings(merge(SQUARE, SINE, modulo(number, 2) == 1))
            settings%lowest_frequency = 5/60.0_dp
            call design_manoeuvre(planned, [site], settings, design, failure)
            if (failed(error, failure)) return
            call check(error, design%worst < 10*MICROMETRE .and. maxval(design%sigma) <= design%worst, &
                       REPORT_CASE_NAMES(number))
            call judge_manoeuvre(planned, [site], three_rods([5, 6, 7], SINE), 1, pattern)
            call check(error, maxval(design%sigma) <= maxval(pattern%sigma) .and. design%worst <= pattern%worst, &
                       REPORT_CASE_NAMES(number))
            call check(error, all(abs(design%rods%activations(:3)%amplitude) <= MAX_DIPOLE))
        end do
    end subroutine test_all_cases

    !> One manoeuvre for the whole revolution: square waves of 12, 8 and 9 cycles that start in mid
    !> edge-to-edge stay below 10 micrometres; the report's rods, all the way, exceed a millimetre.
    subroutine test_everywhere(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(nominal_orbit_t) :: orbit
        type(planned_arc_t) :: planned
        type(map_point_t), allocatable :: points(:), of_report(:)
        type(torque_rods_t) :: rods
        type(error_t), allocatable :: failure
        real(dp) :: greatest, of_report_greatest
        integer :: i, s

        do s = 1, 4, 3
            call take_case(REPORT_CASE_NAMES(s), case)
            call make_plan(case, planned)
            call make_orbit(case, orbit, interval=30.0_dp)
            rods = three_rods([12, 8, 9], SQUARE)
            rods%activations%phase = 90*DEGREE
            call map_manoeuvre(planned, orbit, [(120.0_dp*i, i=0, 46)], rods, 2, points, failure)
            if (.not. allocated(failure)) &
                call map_manoeuvre(planned, orbit, [(120.0_dp*i, i=0, 46)], case%satellite%rods, 2, of_report, failure)
            if (failed(error, failure)) return
            greatest = 0
            of_report_greatest = 0
            do i = 1, size(points)
                greatest = max(greatest, maxval(points(i)%quality%sigma))
                of_report_greatest = max(of_report_greatest, maxval(of_report(i)%quality%sigma))
                ! no direction is better than the worst, and the worst is no better than any axis
                call check(error, points(i)%worst_sigma >= maxval(points(i)%quality%sigma)*(1 - 1e-9_dp) .and. &
                           points(i)%worst_sigma <= norm2(points(i)%quality%sigma)*(1 + 1e-9_dp))
                call check(error, norm2(points(i)%worst_direction), 1.0_dp, thr=1e-12_dp)
            end do
            call check(error, greatest < 10*MICROMETRE .and. of_report_greatest > 1000*MICROMETRE)
        end do
    end subroutine test_everywhere

    !> A tight pointing limit is met with weaker rods; one below what the free satellite does is not.
    subroutine test_limits(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t) :: site
        type(manoeuvre_design_t) :: free, bound
        type(design_settings_t) :: settings
        type(error_t), allocatable :: failure

        call take_case('front-3', case)
        call stand(case, planned, site)
        settings = quick_settings(SINE)
        call design_manoeuvre(planned, [site], settings, free, failure)
        if (.not. allocated(failure)) then
            planned%knowledge%limits%pointing = free%excursion
            planned%knowledge%limits%rate = norm2(case%angular_velocity) + &
                                    0.5_dp*(free%rate - norm2(case%angular_velocity))
            call design_manoeuvre(planned, [site], settings, bound, failure)
        end if
        if (failed(error, failure)) return
        call check(error, bound%rate <= planned%knowledge%limits%rate .and. &
                   bound%excursion <= planned%knowledge%limits%pointing .and. bound%worst > free%worst .and. &
                   bound%rods%activations(1)%amplitude < 30)
        planned%knowledge%limits%rate = 0.99_dp*norm2(case%angular_velocity)
        call design_manoeuvre(planned, [site], settings, bound, failure)
        call check_fails(error, failure, 'no manoeuvre stays within the limits ... rate_deg_s')
    end subroutine test_limits

    !> Among the three places of the report, that over the pole is best: the field is the strongest.
    subroutine test_place(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(nominal_orbit_t) :: orbit
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t), allocatable :: sites(:)
        type(error_t), allocatable :: failure
        integer :: best

        call take_case('front-1', case)
        call make_plan(case, planned)
        call make_orbit(case, orbit, interval=60.0_dp)
        call new_manoeuvre_sites(planned, orbit, TIME_OF_CASE, 1, sites, failure)
        if (.not. allocated(failure)) call choose_place(planned, sites, quick_settings(SINE), best, failure)
        call check_passes(error, failure)
        call check(error, best, 2)
    end subroutine test_place

    subroutine test_threads(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t) :: site
        type(manoeuvre_design_t) :: one, two
        type(design_settings_t) :: settings
        type(error_t), allocatable :: failure

        call take_case('back-1', case)
        call stand(case, planned, site)
        settings = quick_settings(TAPERED)
        call design_manoeuvre(planned, [site], settings, one, failure)
        settings%threads = 2
        if (.not. allocated(failure)) call design_manoeuvre(planned, [site], settings, two, failure)
        if (failed(error, failure)) return
        call check(error, one%worst == two%worst .and. one%evaluations == two%evaluations .and. &
                   all(one%rods%activations%frequency == two%rods%activations%frequency) .and. &
                   all(one%rods%activations%phase == two%rods%activations%phase))
    end subroutine test_threads

    !> Front case 1 moved to the time of front case 2 is that case, but for what is printed rounded; it can
    !> be written and read.
    subroutine test_moved_case(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case, later, printed, again
        type(nominal_orbit_t) :: orbit
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call take_case('front-1', case)
        call take_case('front-2', printed)
        call make_orbit(case, orbit, interval=10.0_dp)
        later = moved_case(case, orbit, TIME_OF_CASE(2))
        call check(error, maxval(abs(later%position([1, 3]) - printed%position([1, 3]))) < 1.2_dp)
        call check(error, rotation_angle_between(later%quaternion, printed%quaternion) < 2e-4_dp)
        call check(error, modulo(later%sidereal_angle, 360*DEGREE), modulo(printed%sidereal_angle, 360*DEGREE), &
                   thr=1e-9_dp)
        call check(error, later%epoch%seconds, printed%epoch%seconds, thr=1e-6_dp)
        call case_text(later, text, failure)
        call make_file('later.nml', text)
        call read_case(FOLDER//'later.nml', again, failure)
        if (failed(error, failure)) return
        call check(error, all(again%position == later%position) .and. &
                   again%sidereal_angle == later%sidereal_angle .and. all(again%quaternion == later%quaternion))
        call check(error, later%wind_model, 'hwm93', 'the wind fitted to case 1 goes along')
        case%wind_east = case%wind_east + 1
        later = moved_case(case, orbit, TIME_OF_CASE(2))
        call check(error, later%wind_model, 'constant', 'a wind of one''s own does not go along')
        again = moved_case(case, orbit, 0.0_dp)
        call check(error, all(again%quaternion == case%quaternion))
    end subroutine test_moved_case

    !> The two halves of a plan and the one call give the same; the place that is chosen is one of the orbit; the
    !> case that flies a plan, judged as it stands, has the limit that the plan says.
    subroutine test_plan(error)
        type(error_type), allocatable, intent(out) :: error
        type(plan_request_t) :: request
        type(plan_t) :: plan, judged
        type(calibration_t) :: calibration, planned, again
        type(manoeuvre_design_t) :: design
        type(error_t), allocatable :: failure

        call take_calibration('back-1', calibration)
        request%place = ANYWHERE
        request%settings = quick_settings(SINE)
        request%settings%highest_frequency = 0.1_dp
        call prepare_plan(calibration, request, plan, failure)
        if (.not. allocated(failure)) call find_manoeuvre(request, plan, failure)
        if (failed(error, failure)) return
        if (unmet(error, any(.not. abs(times_along(plan%orbit, 100.0_dp) - plan%time) > 0) .and. &
                  size(plan%sites) == 1 .and. .not. abs(plan%sites(1)%time - plan%time) > 0)) return
        planned = planned_calibration(request, plan)
        call plan_manoeuvre(calibration, plan%time, request%settings, again, design, failure)
        if (failed(error, failure)) return
        call check(error, .not. abs(design%worst - plan%design%worst) > 0 .and. &
                   .not. any(abs(planned%case%position - again%case%position) > 0), 'another plan in one call')
        request = plan_request_t(search=.false.)
        call prepare_plan(planned, request, judged, failure)
        if (.not. allocated(failure)) call find_manoeuvre(request, judged, failure)
        if (failed(error, failure)) return
        call check(error, maxval(abs(judged%design%sigma/plan%design%sigma - 1)) < 1e-3_dp)
    end subroutine test_plan

    subroutine test_refused(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(nominal_orbit_t) :: orbit
        type(manoeuvre_site_t) :: site
        type(design_settings_t) :: settings
        type(calibration_t) :: calibration, planned_one
        type(manoeuvre_design_t) :: design
        type(error_t), allocatable :: failure

        call take_case('front-1', case)
        call make_plan(case, planned)
        call make_orbit(case, orbit, interval=60.0_dp)
        call new_manoeuvre_site(planned, orbit, 6000.0_dp, site, failure)
        call check_fails(error, failure, '6000 s ... from 0 to 5635')
        call new_nominal_orbit(case, orbit, failure, revolutions=-3)
        call check_fails(error, failure, 'front-1 ... revolutions = -3 ... 1 to 150')
        call take_calibration('front-1', calibration)
        call plan_manoeuvre(calibration, 0.0_dp, settings, planned_one, design, failure, place=7)
        call check_fails(error, failure, 'place = 7')
        settings = design_settings_t(refinement_steps=-5)
        call refused('refinement_steps = -5')
        settings%rod_used = .false.
        call refused('all torque rods are off')
        settings = design_settings_t(amplitude=0.0_dp)
        call refused('all torque rods are off ... amplitude is 0')
        settings = design_settings_t(amplitude=31.0_dp)
        call refused('at most 30 A m^2')
        settings = design_settings_t(highest_frequency=5.0_dp)
        call refused('frequency = 5 Hz ... half the sampling frequency')
        settings = design_settings_t(lowest_frequency=0.3_dp)
        call refused('frequencies from 0.3 to 0.2 Hz')
        settings = design_settings_t(lowest_frequency=0.101_dp, highest_frequency=0.11_dp)
        call refused('no whole number of cycles')
        settings = design_settings_t(rise_time=3.0_dp)
        call refused('rise_time = 3')
        settings = design_settings_t(taper=0.0_dp)
        call refused('needs a taper')
        case%satellite%accelerometer%noise%level = 0
        call new_planned_arc(case, planned, failure)
        call check_fails(error, failure, 'axis x ... noise_level')

    contains

        subroutine refused(parts)
            character(*), intent(in) :: parts

            call check_design_settings(planned, settings, failure)
            call check_fails(error, failure, parts)
        end subroutine refused
    end subroutine test_refused
end module test_design
