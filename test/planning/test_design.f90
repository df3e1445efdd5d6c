!> The planner: how good manoeuvres are at a place, against the numbers of an independent covariance
!> analysis and against the true arc; the search and its guarantees.
module test_design
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MICROMETRE
    use gracecg_base_error, only: error_t, message_of
    use gracecg_base_text, only: integer_text
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_spacecraft_torque_rods
    use gracecg_base_quaternion, only: rotation_angle_between
    use gracecg_simulation_dynamics, only: OMEGA
    use gracecg_simulation_arc, only: truth_arc_t
    use gracecg_estimation_offset_model, only: offset_matrix
    use gracecg_estimation_offset_information, only: offset_information, gather_information
    use gracecg_estimation_noise_whitening, only: weigh_series
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_simulation_case, only: case_t, read_case, case_text
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES, TIME_OF_CASE
    use gracecg_simulation_simulator, only: propagate_case
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit
    use gracecg_planning_moved_case, only: moved_case
    use gracecg_simulation_limits, only: attitude_motion_t
    use gracecg_planning_site
    use gracecg_planning_leakage, only: leakage_pair_t, leakage_sigmas, find_pair
    use gracecg_planning_map
    use gracecg_planning_candidates
    use gracecg_planning_design
    use gracecg_planning_planner
    use gracecg_planning_reliable_design, only: reliable_design_t, make_reliable
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use fixture, only: check, check_fails, check_passes, make_file, FOLDER
    use testdrive, only: new_unittest, unittest_type, error_type
    implicit none
    private
    public :: collect_design

    integer, parameter :: W = 60

contains

    subroutine collect_design(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('facts-of-the-covariance-analysis', test_facts), &
                    new_unittest('weighing-is-whitening-twice', test_weighing), &
                    new_unittest('a-disturbance-is-weighed-with-the-partials', test_disturbance), &
                    new_unittest('a-thinned-arc-says-nearly-the-same', test_thinned), &
                    new_unittest('rotation-is-that-of-the-true-arc', test_rotation), &
                    new_unittest('forces-act-as-in-the-true-arc', test_forces), &
                    new_unittest('ten-micrometres-in-all-cases', test_all_cases), &
                    new_unittest('ten-micrometres-everywhere', test_everywhere), &
                    new_unittest('limits-are-kept', test_limits), &
                    new_unittest('shortest-arc', test_shortest), &
                    new_unittest('best-place', test_place), &
                    new_unittest('threads', test_threads), &
                    new_unittest('leakage-of-the-rods', test_leakage), &
                    new_unittest('moved-case', test_moved_case), &
                    new_unittest('plan', test_plan), &
                    new_unittest('reliable-manoeuvre', test_reliable), &
                    new_unittest('plan-of-the-shortest-arc', test_shortest_plan), &
                    new_unittest('refuses-impossible', test_refused)]
    end subroutine collect_design

    !> A manoeuvre that is reliable enough stays as it is; else one is found that is better, with the moments and
    !> frequencies allowed.
    subroutine test_reliable(error)
        type(error_type), allocatable, intent(out) :: error

        type(calibration_t) :: calibration
        type(plan_request_t) :: request
        type(plan_t) :: plan
        type(reliable_design_t) :: same, other
        type(error_t), allocatable :: failure
        real(dp) :: wanted
        integer :: axis

        call find_calibration('front-3', calibration, failure)
        calibration%case%duration = 30
        request%search = .false.
        request%settings%refinement_steps = 1
        if (.not. allocated(failure)) call prepare_plan(calibration, request, plan, failure)
        if (.not. allocated(failure)) call find_manoeuvre(request, plan, failure)
        if (.not. allocated(failure)) call make_reliable(request, plan, 1.0_dp, same, failure)
        wanted = 0.1_dp*maxval(same%effect)
        if (.not. allocated(failure)) call make_reliable(request, plan, wanted, other, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, same%evaluations, 1)
        call check(error, same%design%rods%count, plan%design%rods%count)
        call check(error, beyond(other) < beyond(same), 'not better')
        do axis = 1, 3
            if (allocated(error)) return
            associate (rods => other%design%rods%activations(:other%design%rods%count))
                call check(error, sum(rods%amplitude, mask=rods%axis == axis) <= 30*(1 + 1e-12_dp), 'moment')
            end associate
        end do

    contains

        !> Beliefs that could move some component by more than is wanted.
        pure integer function beyond(design)
            type(reliable_design_t), intent(in) :: design

            integer :: i

            beyond = count([(any(abs(design%report%values(i)%effect) > wanted), i=1, size(design%report%values))])
        end function beyond
    end subroutine test_reliable

    !> View and start of a case.
    subroutine stand(case, planned, site, error)
        type(case_t), intent(in) :: case
        type(planned_arc_t), intent(out) :: planned
        type(manoeuvre_site_t), intent(out) :: site
        type(error_type), allocatable, intent(inout) :: error

        type(nominal_orbit_t) :: orbit
        type(error_t), allocatable :: failure

        call new_planned_arc(case, planned, failure)
        if (.not. allocated(failure)) call new_nominal_orbit(case, orbit, failure, interval=60.0_dp)
        if (.not. allocated(failure)) call new_manoeuvre_site(planned, orbit, 0.0_dp, site, failure)
        call check_passes(error, message_of(failure))
    end subroutine stand

    !> All three rods with 30 A m^2 at some cycles a minute.
    function three_rods(cycles, waveform) result(rods)
        integer, intent(in) :: cycles(3), waveform
        type(torque_rods_t) :: rods

        type(rod_activation_t) :: activations(3)
        type(error_t), allocatable :: failure
        integer :: axis

        do axis = 1, 3
            activations(axis) = rod_activation_t(axis, 30.0_dp, cycles(axis)/60.0_dp, 0.0_dp, 0.0_dp, 60.0_dp, &
                                                 waveform)
        end do
        call new_torque_rods(rods, activations, failure)
    end function three_rods

    !> Leakage that is estimated costs much at one place, and hardly anything with a second flight half a revolution away,
    !> where the field is opposite. Without it the sigma is that of the manoeuvre, and two flights are more than one.
    subroutine test_leakage(error)
        type(error_type), allocatable, intent(out) :: error

        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(nominal_orbit_t) :: orbit
        type(manoeuvre_site_t) :: site
        type(manoeuvre_quality_t) :: quality
        type(leakage_pair_t) :: pair
        type(error_t), allocatable :: failure
        real(dp) :: without(3), with(3)

        call report_case('front-1', case, failure)
        if (.not. allocated(failure)) call new_planned_arc(case, planned, failure)
        if (.not. allocated(failure)) call new_nominal_orbit(case, orbit, failure)
        if (.not. allocated(failure)) call new_manoeuvre_site(planned, orbit, 0.0_dp, site, failure)
        if (.not. allocated(failure)) &
            call find_pair(planned, orbit, site, three_rods([5, 6, 7], SINE), pair, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call evaluate_manoeuvre(planned, site, three_rods([5, 6, 7], SINE), quality)
        call check(error, maxval(abs(pair%without/quality%sigma - 1)) < 1e-6_dp, 'sigma without leakage')
        call leakage_sigmas(planned, site, three_rods([5, 6, 7], SINE), without, with)
        call check(error, maxval(abs(with/pair%with - 1)) < 1e-12_dp, 'one flight')
        call check(error, all(pair%with > 2*pair%without), 'at one place leakage is not to be told from d')
        call check(error, pair%opposite < -0.5_dp, 'the field is opposite')
        call check(error, all(pair%pair_with < 1.3_dp*pair%pair_without), 'leakage for nothing')
        call check(error, all(pair%pair_without < pair%without), 'two flights')
    end subroutine test_leakage

    !> Limits by an independent covariance analysis, one-sided noise, 60 s, 30 A m^2 a rod, in
    !> micrometres as printed: the report's manoeuvre; y sine and z cosine at 0.1 Hz; x, y, z at 5, 6
    !> and 7 cycles. Three rods agree to the last digit printed; two rods see the offset near the pole (front
    !> 2) only through the slow turn of the field, which the analyses have alike to a tenth.
    subroutine test_facts(error)
        type(error_type), allocatable, intent(out) :: error

        real(dp), parameter :: FACTS(3, 3, 3) = reshape([ &
            84.0_dp, 32.0_dp, 30.0_dp, 6.6_dp, 3.0_dp, 6.3_dp, 6.2_dp, 3.0_dp, 5.9_dp, &
            777.0_dp, 1.6_dp, 9.3_dp, 62.0_dp, 0.9_dp, 9.2_dp, 3.3_dp, 0.7_dp, 3.1_dp, &
            8.8_dp, 25.0_dp, 22.0_dp, 5.3_dp, 5.6_dp, 5.1_dp, 5.3_dp, 5.6_dp, 5.1_dp], [3, 3, 3])
        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t) :: site
        type(manoeuvre_quality_t) :: quality
        type(torque_rods_t) :: rods(3)
        type(error_t), allocatable :: failure
        real(dp) :: tolerance
        integer :: number, manoeuvre, axis

        call new_torque_rods(rods(2), [ &
                             rod_activation_t(2, 30.0_dp, 0.1_dp, 0.0_dp, 0.0_dp, 60.0_dp), &
                             rod_activation_t(3, 30.0_dp, 0.1_dp, 0.0_dp, 0.0_dp, 60.0_dp, COSINE)], failure)
        rods(3) = three_rods([5, 6, 7], SINE)
        do number = 1, 3
            call report_case(REPORT_CASE_NAMES(number), case, failure)
            case%satellite%accelerometer%noise%sides = 1
            call stand(case, planned, site, error)
            if (allocated(error)) return
            rods(1) = case%satellite%rods
            do manoeuvre = 1, 3
                call evaluate_manoeuvre(planned, site, rods(manoeuvre), quality)
                do axis = 1, 3
                    if (number == 2 .and. manoeuvre == 1 .and. axis == 2) cycle     ! follows x, see below
                    associate (ours => quality%sigma(axis)/MICROMETRE, fact => FACTS(axis, manoeuvre, number))
                        tolerance = 0.02_dp*fact + 0.05_dp
                        if (manoeuvre < 3) tolerance = 0.12_dp*fact
                        call check(error, ours, fact, thr=tolerance, &
                                   message='front-'//integer_text(number)//', manoeuvre '// &
                                   integer_text(manoeuvre)//', axis '//integer_text(axis))
                    end associate
                end do
                ! y of front 2: 1.6 printed, of an error ellipsoid 777 long and 1 wide: its tilt makes the rest
                if (number == 2 .and. manoeuvre == 1) &
                    call check(error, quality%sigma(2) > 0.7_dp*MICROMETRE .and. quality%sigma(2) < 4*MICROMETRE)
                if (allocated(error)) return
            end do
        end do
    end subroutine test_facts

    !> What a disturbance adds to the normal vector, whitened beside the partials, is the sum of the partials over the
    !> weighed disturbance; and the information is that without a disturbance.
    subroutine test_disturbance(error)
        type(error_type), allocatable, intent(out) :: error

        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t) :: site
        type(error_t), allocatable :: failure
        type(attitude_motion_t) :: motion
        type(random_stream_t) :: stream
        real(dp), allocatable, dimension(:, :) :: omega, omega_dot, theta, disturbance
        real(dp), allocatable :: series(:)
        real(dp) :: information(3, 3), effect(3), expected(3), a(3, 3), scale(3)
        integer :: axis, k

        call report_case('front-3', case, failure)
        call check_passes(error, message_of(failure))
        if (.not. allocated(error)) call stand(case, planned, site, error)
        if (allocated(error)) return
        allocate (omega(3, planned%samples), omega_dot(3, planned%samples), theta(3, planned%samples))
        call fly_manoeuvre(planned, site, three_rods([5, 6, 7], SINE), omega, omega_dot, theta, motion)
        stream = new_stream(2, 7, 1, 8, 2)
        allocate (disturbance(3, planned%samples))
        do axis = 1, 3
            call stream%normals(disturbance(axis, :))
        end do
        call gather_information(omega, omega_dot, planned%whiteners, information, disturbance=disturbance, &
                                effect=effect)
        expected = 0
        scale = 0
        do axis = 1, 3
            series = disturbance(axis, :)
            call weigh_series(planned%whiteners(axis), series)
            do k = 1, planned%samples
                a = offset_matrix(omega(:, k), omega_dot(:, k))
                expected = expected + a(axis, :)*series(k)
                scale = scale + abs(a(axis, :)*series(k))
            end do
        end do
        call check(error, maxval(abs(effect - expected)/scale) < 1e-13_dp, 'effect of a disturbance')
        call check(error, all(abs(information - offset_information(omega, omega_dot, planned%whiteners)) <= 0), &
                   'information beside a disturbance')
    end subroutine test_disturbance

    !> An arc with a fifth of the samples under noise of the same spectrum: the limit to 2 %, by which only manoeuvres
    !> are chosen that are then looked at again, the errors of the forces to 5 % of all, the motion to 1e-3. With all
    !> samples it is the arc itself.
    subroutine test_thinned(error)
        type(error_type), allocatable, intent(out) :: error

        type(case_t) :: case
        type(planned_arc_t) :: planned, thinned
        type(manoeuvre_site_t) :: site, thinned_site
        type(manoeuvre_quality_t) :: quality, quick
        type(error_t), allocatable :: failure
        integer :: part
        real(dp) :: all_errors(3), quick_errors(3)

        call report_case('front-1', case, failure)
        call check_passes(error, message_of(failure))
        if (.not. allocated(error)) call stand(case, planned, site, error)
        if (allocated(error)) return
        call evaluate_manoeuvre(planned, site, three_rods([5, 6, 7], SQUARE), quality)
        all_errors = hypot(hypot(quality%sigma, quality%wave), quality%force)
        do part = 1, 5, 4
            call thin_arc(planned, planned%samples/part, thinned, failure)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            call thin_site(planned, site, thinned, thinned_site)
            call evaluate_manoeuvre(thinned, thinned_site, three_rods([5, 6, 7], SQUARE), quick)
            quick_errors = hypot(hypot(quick%sigma, quick%wave), quick%force)
            call check(error, maxval(abs(quick%sigma/quality%sigma - 1)) < merge(1e-12_dp, 0.02_dp, part == 1), 'sigma')
            call check(error, maxval(abs(quick_errors/all_errors - 1)) < merge(1e-12_dp, 0.05_dp, part == 1), 'errors')
            call check(error, abs(quick%motion%rate/quality%motion%rate - 1) < merge(1e-12_dp, 1e-3_dp, part == 1), 'rate')
            call check(error, abs(quick%motion%excursion/quality%motion%excursion - 1) < &
                       merge(1e-12_dp, 1e-3_dp, part == 1), 'excursion')
        end do
    end subroutine test_thinned

    !> x^T (weighed y) is the scalar product of both whitened, freed of the whitened straight line; a
    !> straight line is weighed to nothing.
    subroutine test_weighing(error)
        type(error_type), allocatable, intent(out) :: error

        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(error_t), allocatable :: failure
        type(random_stream_t) :: stream
        real(dp), allocatable :: series(:, :), weighed(:)
        real(dp) :: expected
        integer :: axis, k

        call report_case('front-1', case, failure)
        call new_planned_arc(case, planned, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        stream = new_stream(3, 1, 4, 1, 5)
        allocate (series(2, planned%samples))
        do axis = 1, 3
            do k = 1, 2
                call stream%normals(series(k, :))
            end do
            weighed = series(2, :)
            call weigh_series(planned%whiteners(axis), weighed)
            expected = dot_product(series(1, :), weighed)
            call planned%whiteners(axis)%whiten(series)
            associate (line => planned%whiteners(axis)%line)
                call check(error, dot_product(series(1, :), series(2, :)) - &
                           dot_product(matmul(line, series(1, :)), matmul(line, series(2, :))), &
                           expected, thr=1e-10_dp*norm2(series(1, :))*norm2(series(2, :)))
            end associate
            weighed = [(2.5_dp - 0.3_dp*k, k=1, planned%samples)]
            call weigh_series(planned%whiteners(axis), weighed)
            series(1, :) = 1
            call check(error, maxval(abs(weighed)) < 1e-9_dp*abs(maxval(weighed_ones())))
        end do

    contains

        !> A single 1 in the middle, weighed: the scale of the weights.
        function weighed_ones() result(ones)
            real(dp) :: ones(planned%samples)

            ones = 0
            ones(planned%samples/2) = 1
            call weigh_series(planned%whiteners(axis), ones)
        end function weighed_ones
    end subroutine test_weighing

    !> Angular velocity and motion of the planner against those of the true arc with all forces, and the
    !> limit along either.
    subroutine test_rotation(error)
        type(error_type), allocatable, intent(out) :: error

        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t) :: site
        type(manoeuvre_quality_t) :: quality
        type(truth_arc_t) :: arc
        type(error_t), allocatable :: failure
        type(attitude_motion_t) :: motion
        real(dp), allocatable :: omega_fit(:, :), omega_dot(:, :), theta(:, :)
        real(dp) :: covariance(3, 3)
        integer :: number, waveform, axis

        do number = 1, 6
            call report_case(REPORT_CASE_NAMES(number), case, failure)
            waveform = merge(SQUARE, SINE, modulo(number, 2) == 0)
            case%satellite%rods = three_rods([9, 7, 8], waveform)
            case%satellite%offset = 0
            call stand(case, planned, site, error)
            if (allocated(error)) return
            call propagate_case(case, arc, failure)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            omega_fit = arc%state(OMEGA, 1:)
            omega_dot = omega_fit
            theta = omega_fit
            call fly_manoeuvre(planned, site, case%satellite%rods, omega_fit, omega_dot, theta, motion)
            ! air and sunlight turn the satellite by some 1e-7 rad/s^2
            call check(error, maxval(abs(omega_fit - arc%state(OMEGA, 1:))) < 1e-5_dp, case%name)
            call check(error, maxval(abs(omega_dot - arc%omega_dot(:, 1:))) < 3e-7_dp, case%name)
            call evaluate_manoeuvre(planned, site, case%satellite%rods, quality)
            covariance = inverse_3x3(offset_information(arc%state(OMEGA, 1:), arc%omega_dot(:, 1:), &
                                                        planned%whiteners))
            do axis = 1, 3
                call check(error, quality%sigma(axis), sqrt(covariance(axis, axis)), rel=.true., thr=2e-3_dp)
            end do
        end do
    end subroutine test_rotation

    !> The error by drag and radiation that the planner foresees is what the estimate that reaches the limit
    !> makes of the true forces along the true arc, d = 0: with square waves of 3 cycles over the pole, where the
    !> turning surfaces matter, and with 9 cycles.
    subroutine test_forces(error)
        type(error_type), allocatable, intent(out) :: error

        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t) :: site
        type(manoeuvre_quality_t) :: quality
        type(truth_arc_t) :: arc
        type(error_t), allocatable :: failure
        real(dp), allocatable :: force(:, :)
        real(dp) :: found(3)
        integer :: k, axis, low_or_high

        call report_case('back-2', case, failure)
        case%satellite%offset = 0
        do low_or_high = 1, 2
            case%satellite%rods = three_rods(merge([3, 4, 3], [9, 10, 9], low_or_high == 1), SQUARE)
            case%satellite%rods%activations(:3)%phase = [90, 0, 90]*DEGREE
            call stand(case, planned, site, error)
            if (allocated(error)) return
            call propagate_case(case, arc, failure)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            if (allocated(force)) deallocate (force)
            allocate (force(planned%samples, 3))
            do k = 1, planned%samples
                force(k, :) = arc%loads(k)%drag + arc%loads(k)%srp + arc%loads(k)%erp
            end do
            do axis = 1, 3
                call weigh_series(planned%whiteners(axis), force(:, axis))
            end do
            found = 0
            do k = 1, planned%samples
                found = found + matmul(force(k, :), offset_matrix(arc%state(OMEGA, k), arc%omega_dot(:, k)))
            end do
            call evaluate_manoeuvre(planned, site, case%satellite%rods, quality)
            found = abs(matmul(quality%covariance, found))
            call check(error, maxval(abs(quality%force - found)) < 0.1_dp*maxval(found) + 0.3_dp*MICROMETRE)
            if (low_or_high == 1) call check(error, maxval(found) > 5*MICROMETRE)
            if (low_or_high == 2) call check(error, maxval(found) < 3*MICROMETRE)
            if (allocated(error)) return
        end do
    end subroutine test_forces

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
            call report_case(REPORT_CASE_NAMES(number), case, failure)
            call stand(case, planned, site, error)
            if (allocated(error)) return
            settings = quick_settings(merge(SQUARE, SINE, modulo(number, 2) == 1))
            settings%lowest_frequency = 5/60.0_dp
            call design_manoeuvre(planned, [site], settings, design, failure)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
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
            call report_case(REPORT_CASE_NAMES(s), case, failure)
            call new_planned_arc(case, planned, failure)
            if (.not. allocated(failure)) call new_nominal_orbit(case, orbit, failure, interval=30.0_dp)
            rods = three_rods([12, 8, 9], SQUARE)
            rods%activations%phase = 90*DEGREE
            if (.not. allocated(failure)) &
                call map_manoeuvre(planned, orbit, [(120.0_dp*i, i=0, 46)], rods, 2, points, failure)
            if (.not. allocated(failure)) &
                call map_manoeuvre(planned, orbit, [(120.0_dp*i, i=0, 46)], case%satellite%rods, 2, of_report, failure)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
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

        call report_case('front-3', case, failure)
        call stand(case, planned, site, error)
        if (allocated(error)) return
        settings = quick_settings(SINE)
        call design_manoeuvre(planned, [site], settings, free, failure)
        if (.not. allocated(failure)) then
            planned%knowledge%limits%pointing = free%excursion
            planned%knowledge%limits%rate = norm2(case%angular_velocity) + &
                                    0.5_dp*(free%rate - norm2(case%angular_velocity))
            call design_manoeuvre(planned, [site], settings, bound, failure)
        end if
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, bound%rate <= planned%knowledge%limits%rate .and. &
                   bound%excursion <= planned%knowledge%limits%pointing .and. bound%worst > free%worst .and. &
                   bound%rods%activations(1)%amplitude < 30)
        planned%knowledge%limits%rate = 0.99_dp*norm2(case%angular_velocity)
        call design_manoeuvre(planned, [site], settings, bound, failure)
        call check_fails(error, message_of(failure), [character(W) :: 'no manoeuvre stays within the limits', &
                                                      'rate_deg_s'])
    end subroutine test_limits

    !> The shortest arc meets the target, and one step less does not.
    subroutine test_shortest(error)
        type(error_type), allocatable, intent(out) :: error

        real(dp), parameter :: STEP = 12, TARGET = 8*MICROMETRE
        type(case_t) :: case
        type(nominal_orbit_t) :: orbit
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t) :: site
        type(manoeuvre_design_t) :: design, shorter
        type(design_settings_t) :: settings
        type(error_t), allocatable :: failure

        settings = quick_settings(SQUARE)
        call report_case('front-1', case, failure)
        call new_nominal_orbit(case, orbit, failure, interval=60.0_dp)
        if (.not. allocated(failure)) call shortest_manoeuvre(case, orbit, 0.0_dp, settings, 60.0_dp, STEP, &
                                                              TARGET, planned, design, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        case%duration = planned%knowledge%duration
        call check(error, design%worst <= TARGET .and. case%duration < 60)
        case%duration = case%duration - STEP
        if (case%duration > 0) then
            call stand(case, planned, site, error)
            if (allocated(error)) return
            call design_manoeuvre(planned, [site], settings, shorter, failure)
            call check(error, allocated(failure) .or. shorter%worst > TARGET)
            if (allocated(error)) return
        end if
        call shortest_manoeuvre(case, orbit, 0.0_dp, settings, 60.0_dp, STEP, MICROMETRE/10, planned, design, failure)
        call check_fails(error, message_of(failure), [character(W) :: 'target of 1.000000E-04 mm', 'out of reach'])
    end subroutine test_shortest

    !> Among the three places of the report, that over the pole is best: the field is the strongest.
    subroutine test_place(error)
        type(error_type), allocatable, intent(out) :: error

        type(case_t) :: case
        type(nominal_orbit_t) :: orbit
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t), allocatable :: sites(:)
        type(error_t), allocatable :: failure
        integer :: best

        call report_case('front-1', case, failure)
        call new_planned_arc(case, planned, failure)
        if (.not. allocated(failure)) call new_nominal_orbit(case, orbit, failure, interval=60.0_dp)
        if (.not. allocated(failure)) call new_manoeuvre_sites(planned, orbit, TIME_OF_CASE, 1, sites, failure)
        if (.not. allocated(failure)) call choose_place(planned, sites, quick_settings(SINE), best, failure)
        call check_passes(error, message_of(failure))
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

        call report_case('back-1', case, failure)
        call stand(case, planned, site, error)
        if (allocated(error)) return
        settings = quick_settings(TAPERED)
        call design_manoeuvre(planned, [site], settings, one, failure)
        settings%threads = 2
        if (.not. allocated(failure)) call design_manoeuvre(planned, [site], settings, two, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
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

        call report_case('front-1', case, failure)
        call report_case('front-2', printed, failure)
        call new_nominal_orbit(case, orbit, failure, interval=10.0_dp)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        later = moved_case(case, orbit, TIME_OF_CASE(2))
        call check(error, maxval(abs(later%position([1, 3]) - printed%position([1, 3]))) < 1.2_dp)
        call check(error, rotation_angle_between(later%quaternion, printed%quaternion) < 2e-4_dp)
        call check(error, modulo(later%sidereal_angle, 360*DEGREE), modulo(printed%sidereal_angle, 360*DEGREE), &
                   thr=1e-9_dp)
        call check(error, later%epoch%seconds, printed%epoch%seconds, thr=1e-6_dp)
        call case_text(later, text, failure)
        call make_file(error, 'later.nml', text)
        if (allocated(error)) return
        call read_case(FOLDER//'later.nml', again, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
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

        call find_calibration('back-1', calibration, failure)
        request%place = ANYWHERE
        request%settings = quick_settings(SINE)
        request%settings%highest_frequency = 0.1_dp
        call prepare_plan(calibration, request, plan, failure)
        if (.not. allocated(failure)) call find_manoeuvre(request, plan, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, any(.not. abs(times_along(plan%orbit, 100.0_dp) - plan%time) > 0) .and. &
                   size(plan%sites) == 1 .and. .not. abs(plan%sites(1)%time - plan%time) > 0)
        if (allocated(error)) return
        planned = planned_calibration(request, plan)
        call plan_manoeuvre(calibration, plan%time, request%settings, again, design, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, .not. abs(design%worst - plan%design%worst) > 0 .and. &
                   .not. any(abs(planned%case%position - again%case%position) > 0), 'another plan in one call')
        request = plan_request_t(search=.false.)
        call prepare_plan(planned, request, judged, failure)
        if (.not. allocated(failure)) call find_manoeuvre(request, judged, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, maxval(abs(judged%design%sigma/plan%design%sigma - 1)) < 1e-3_dp)
    end subroutine test_plan

    !> With a target the sites of a plan are those of the shorter arc.
    subroutine test_shortest_plan(error)
        type(error_type), allocatable, intent(out) :: error

        type(plan_request_t) :: request
        type(plan_t) :: plan
        type(calibration_t) :: calibration
        type(manoeuvre_design_t) :: judged
        type(error_t), allocatable :: failure

        call find_calibration('front-1', calibration, failure)
        request%settings = quick_settings(SQUARE)
        request%target = 8*MICROMETRE
        call prepare_plan(calibration, request, plan, failure)
        if (.not. allocated(failure)) call find_manoeuvre(request, plan, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, plan%design%worst <= request%target .and. plan%calibration%case%duration < 60)
        call judge_manoeuvre(plan%arc, plan%sites, plan%design%rods, 1, judged)
        call check(error, maxval(abs(judged%force - plan%design%force)) <= 1e-12_dp*maxval(judged%force))
    end subroutine test_shortest_plan

    subroutine test_refused(error)
        type(error_type), allocatable, intent(out) :: error

        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(nominal_orbit_t) :: orbit
        type(manoeuvre_site_t) :: site
        type(design_settings_t) :: settings
        type(error_t), allocatable :: failure

        call report_case('front-1', case, failure)
        call new_planned_arc(case, planned, failure)
        if (.not. allocated(failure)) call new_nominal_orbit(case, orbit, failure, interval=60.0_dp)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call new_manoeuvre_site(planned, orbit, 6000.0_dp, site, failure)
        call check_fails(error, message_of(failure), [character(W) :: '6000 s', 'from 0 to 5635'])
        settings%rod_used = .false.
        call refused([character(W) :: 'all torque rods are off'])
        settings = design_settings_t(amplitude=0.0_dp)
        call refused([character(W) :: 'all torque rods are off', 'amplitude is 0'])
        settings = design_settings_t(amplitude=31.0_dp)
        call refused([character(W) :: 'at most 30 A m^2'])
        settings = design_settings_t(highest_frequency=5.0_dp)
        call refused([character(W) :: 'frequency = 5 Hz', 'half the sampling frequency'])
        settings = design_settings_t(lowest_frequency=0.3_dp)
        call refused([character(W) :: 'frequencies from 0.3 to 0.2 Hz'])
        settings = design_settings_t(lowest_frequency=0.101_dp, highest_frequency=0.11_dp)
        call refused([character(W) :: 'no whole number of cycles'])
        settings = design_settings_t(rise_time=3.0_dp)
        call refused([character(W) :: 'rise_time = 3'])
        settings = design_settings_t(taper=0.0_dp)
        call refused([character(W) :: 'needs a taper'])
        if (allocated(error)) return
        case%satellite%accelerometer%noise%level = 0
        call new_planned_arc(case, planned, failure)
        call check_fails(error, message_of(failure), [character(W) :: 'axis x', 'noise_level'])

    contains

        subroutine refused(parts)
            character(*), intent(in) :: parts(:)

            if (allocated(error)) return
            call check_design_settings(planned, settings, failure)
            call check_fails(error, message_of(failure), parts)
        end subroutine refused
    end subroutine test_refused
end module test_design
