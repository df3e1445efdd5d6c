!> How good a manoeuvre is at a place, against the true arc and by identities.
module test_site
    use vocabulary
    use calibrations
    use gracecg_spacecraft_torque_rods
    use gracecg_simulation_dynamics, only: OMEGA
    use gracecg_simulation_arc, only: truth_arc_t
    use gracecg_estimation_offset_model, only: offset_matrix
    use gracecg_estimation_offset_information, only: gather_information
    use gracecg_estimation_noise_whitening, only: weigh_series
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t
    use gracecg_simulation_limits, only: attitude_motion_t
    use gracecg_planning_site
    use gracecg_planning_leakage, only: leakage_pair_t, find_pair
    implicit none
    private
    public :: site_tests, stand, three_rods

contains

    !> Of the suite `design`.
    function site_tests() result(tests)
        type(unittest_type), allocatable :: tests(:)

        tests = [ &
                new_unittest('weighing-is-whitening-twice', test_weighing), &
                new_unittest('a-disturbance-is-weighed-with-the-partials', test_disturbance), &
                new_unittest('a-thinned-arc-says-nearly-the-same', test_thinned), &
                new_unittest('rotation-is-that-of-the-true-arc', test_rotation), &
                new_unittest('forces-act-as-in-the-true-arc', test_forces), &
                new_unittest('leakage-of-the-rods', test_leakage)]
    end function site_tests

    !> View and start of a case.
    subroutine stand(case, planned, site)
        type(case_t), intent(in) :: case
        type(planned_arc_t), intent(out) :: planned
        type(manoeuvre_site_t), intent(out) :: site
        type(nominal_orbit_t) :: orbit
        type(error_t), allocatable :: failure

        call make_plan(case, planned)
        call make_orbit(case, orbit, interval=60.0_dp)
        call new_manoeuvre_site(planned, orbit, 0.0_dp, site, failure)
        call need(failure)
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
        call new_torque_rods(activations, rods, failure)
    end function three_rods

    !> x^T (weighed y) is the scalar product of both whitened, freed of the whitened straight line; a
    !> straight line is weighed to nothing.
    subroutine test_weighing(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(random_stream_t) :: stream
        real(dp), allocatable :: series(:, :), weighed(:)
        real(dp) :: expected
        integer :: axis, k

        call take_case('front-1', case)
        call make_plan(case, planned)
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

    !> What a disturbance adds to the normal vector, whitened beside the partials, is the sum of the partials over the
    !> weighed disturbance; and the information is that without a disturbance.
    subroutine test_disturbance(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t) :: site
        type(attitude_motion_t) :: motion
        type(random_stream_t) :: stream
        real(dp), allocatable, dimension(:, :) :: omega, omega_dot, theta, disturbance
        real(dp), allocatable :: series(:)
        real(dp) :: information(3, 3), alone(3, 3), effect(3), expected(3), a(3, 3), scale(3)
        integer :: axis, k

        call take_case('front-3', case)
        call stand(case, planned, site)
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
        call gather_information(omega, omega_dot, planned%whiteners, alone)
        call check(error, all(abs(information - alone) <= 0), 'information beside a disturbance')
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

        call take_case('front-1', case)
        call stand(case, planned, site)
        call evaluate_manoeuvre(planned, site, three_rods([5, 6, 7], SQUARE), quality)
        all_errors = hypot(hypot(quality%sigma, quality%wave), quality%force)
        do part = 1, 5, 4
            call thin_arc(planned, planned%samples/part, thinned, failure)
            if (failed(error, failure)) return
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

    !> Angular velocity and motion of the planner against those of the true arc with all forces, and the
    !> limit along either.
    subroutine test_rotation(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(planned_arc_t) :: planned
        type(manoeuvre_site_t) :: site
        type(manoeuvre_quality_t) :: quality
        type(truth_arc_t) :: arc
        type(attitude_motion_t) :: motion
        real(dp), allocatable :: omega_fit(:, :), omega_dot(:, :), theta(:, :)
        real(dp) :: covariance(3, 3)
        integer :: number, waveform, axis

        do number = 1, 6
            call take_case(REPORT_CASE_NAMES(number), case)
            waveform = merge(SQUARE, SINE, modulo(number, 2) == 0)
            case%satellite%rods = three_rods([9, 7, 8], waveform)
            case%satellite%offset = 0
            call stand(case, planned, site)
            call make_arc(case, arc)
            omega_fit = arc%state(OMEGA, 1:)
            omega_dot = omega_fit
            theta = omega_fit
            call fly_manoeuvre(planned, site, case%satellite%rods, omega_fit, omega_dot, theta, motion)
            ! air and sunlight turn the satellite by some 1e-7 rad/s^2
            call check(error, maxval(abs(omega_fit - arc%state(OMEGA, 1:))) < 1e-5_dp, case%name)
            call check(error, maxval(abs(omega_dot - arc%omega_dot(:, 1:))) < 3e-7_dp, case%name)
            call evaluate_manoeuvre(planned, site, case%satellite%rods, quality)
            call gather_information(arc%state(OMEGA, 1:), arc%omega_dot(:, 1:), planned%whiteners, covariance)
            covariance = inverse_3x3(covariance)
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
        real(dp), allocatable :: force(:, :)
        real(dp) :: found(3)
        integer :: k, axis, low_or_high

        call take_case('back-2', case)
        case%satellite%offset = 0
        do low_or_high = 1, 2
            case%satellite%rods = three_rods(merge([3, 4, 3], [9, 10, 9], low_or_high == 1), SQUARE)
            case%satellite%rods%activations(:3)%phase = [90, 0, 90]*DEGREE
            call stand(case, planned, site)
            call make_arc(case, arc)
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
        end do
    end subroutine test_forces

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
        call take_case('front-1', case)
        call make_plan(case, planned)
        call make_orbit(case, orbit)
        call new_manoeuvre_site(planned, orbit, 0.0_dp, site, failure)
        if (.not. allocated(failure)) &
            call find_pair(planned, orbit, site, three_rods([5, 6, 7], SINE), pair, failure)
        if (failed(error, failure)) return
        call evaluate_manoeuvre(planned, site, three_rods([5, 6, 7], SINE), quality)
        call check(error, maxval(abs(pair%without/quality%sigma - 1)) < 1e-6_dp, 'sigma without leakage')
        call check(error, all(pair%with > 2*pair%without), 'at one place leakage is not to be told from d')
        call check(error, pair%opposite < -0.5_dp, 'the field is opposite')
        call check(error, all(pair%pair_with < 1.3_dp*pair%pair_without), 'leakage for nothing')
        call check(error, all(pair%pair_without < pair%without), 'two flights')
    end subroutine test_leakage
end module test_site
