!> The Fortran 77 entry points: the numbers of the Fortran API, status and message.
module test_f77
    use vocabulary
    use calibrations
    use gracecg, only: LIBRARY_VERSION, utc_t, gmst_1982, earth_parameters_t, read_earth_parameters, earth_orientation_t, &
        new_earth_orientation, geopotential_t, egm96
    use gracecg, only: initial_state, satellite_dynamics_t, nadir_pointing_t, truth_arc_t, propagate_arc, accelerations_t, loads_t
    use gracecg, only: moment_series_t, new_moment_series, take_measured_moments, dipole_moment, report_options, joint_run_t, &
        run_from_observations, joint_options_t, joint_solution_t, estimate_runs, arc_chain_t, estimate_chain, case_bound_t, &
        bound_of_case, design_settings_t, manoeuvre_design_t, plan_manoeuvre, fit_record_t, fit_diagnostics_t, diagnose, &
        verdict_t, judge
    use gracecg_environment_time, only: time_tag
    use gracecg_estimation_belief_report, only: CONTRADICTED, UNTESTED
    use gracecg_interface_general, only: INTERFACE_VERSION
    use gracecg_interface_handles, only: live_objects
    use c_checks, only: check_answer, simulated_set
    use f77_interfaces
    implicit none
    private
    public :: collect_f77

    double precision, parameter :: PLACE(3) = [-1.2d6, 5.3d6, 4.1d6], SEC = 3600d0
    integer, parameter :: MJD = 47528

contains

    subroutine collect_f77(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('models', test_models), &
                    new_unittest('forces', test_forces), &
                    new_unittest('propagation', test_propagation), &
                    new_unittest('estimation', test_estimation), &
                    new_unittest('answers-of-estimates', test_answers), &
                    new_unittest('bound-and-planner', test_planning), &
                    new_unittest('status-and-message', test_messages), &
                    new_unittest('nothing-is-left', test_nothing_left)]
    end subroutine collect_f77

    subroutine test_models(error)
        type(error_type), allocatable, intent(out) :: error
        character(120) :: msg
        character(5) :: version
        type(geopotential_t) :: model
        type(error_t), allocatable :: failure
        integer :: ih, istat, m
        double precision :: a(3), u, g(3, 3), b(3), rho, temp, xn(3), east, north, sun(3), free, flux(3), s, theta
        double precision :: expected(3), potential, many_places(3, 11), many(3, 11), potentials(11), pole(2)
        character(*), parameter :: IERS = 'test/fixtures/earth_orientation/eopc04_20.txt'
        type(earth_parameters_t) :: parameters
        type(earth_orientation_t) :: earth

        call gcvers(version)
        call check(error, version, LIBRARY_VERSION)
        call gcvint(m)
        call check(error, m, int(INTERFACE_VERSION), 'gcvint')
        call gcutc('1989-01-02T01:00:00', m, s, istat, msg)
        call check(error, istat == 0 .and. m == MJD .and. abs(s - SEC) <= 0 .and. msg == '', 'gcutc '//msg)
        call gcutcp(MJD, SEC, 86400d0, m, s, istat, msg)
        call check(error, istat == 0 .and. m == MJD + 1 .and. abs(s - SEC) <= 0, 'gcutcp '//msg)
        call gcutcd(MJD, SEC, m, s, u, istat, msg)
        call check(error, istat == 0 .and. abs(u - 86400) <= 0, 'gcutcd '//msg)
        call gcgmst(MJD, SEC, 0d0, theta, istat, msg)
        call check_answer(error, 'gcgmst', istat, [theta], [gmst_1982(utc_t(MJD, SEC), 0.0_dp)])
        call gceops(IERS, 61100, SEC, u, pole, istat, msg)
        call read_earth_parameters(IERS, utc_t(61100, SEC), parameters, failure)
        call check_answer(error, 'gceops', istat, [u, pole], [parameters%ut1_minus_utc, parameters%pole])
        parameters = earth_parameters_t(ut1_minus_utc=u, pole=pole)
        call gcornt(61100, SEC, u, pole, 100d0, g, istat, msg)
        call new_earth_orientation('iau', utc_t(61100, SEC), 0.0_dp, parameters, earth, failure)
        call check_answer(error, 'gcornt', istat, [g], [earth%from_inertial(100d0)])

        call gcgrvo('egm96', 20, 20, ih, istat, msg)
        call check(error, istat == 0 .and. ih > 0, 'gcgrvo '//msg)
        call gcgrav(ih, PLACE, a, u, istat, msg)
        call gcgrad(ih, PLACE, g, istat, msg)
        many_places = spread(PLACE, 2, 11)
        many_places(3, 11) = -many_places(3, 11)
        call gcgrvn(ih, 11, many_places, many, potentials, istat, msg)
        call check(error, istat == 0 .and. all(abs(many(:, :10) - spread(a, 2, 10)) <= 0) .and. &
                   all(abs(potentials(:10) - u) <= 0) .and. any(abs(many(:, 11) - a) > 0), 'gcgrvn '//msg)
        call gcfree(ih, istat, msg)
        call egm96(20, 20, model, failure)
        call model%acceleration(PLACE, expected)
        call model%potential(PLACE, potential)
        ! not to the last bit: products are fused in other places where potential and acceleration are asked for at once
        call check(error, norm2(a - expected) <= 2d-15*norm2(expected) .and. abs(u - potential) <= 2d-15*potential .and. &
                   ih == 0, 'gcgrav')
        ! Laplace's equation
        call check(error, abs(g(1, 1) + g(2, 2) + g(3, 3)) < 1d-12*norm2(g) .and. norm2(g) > 1d-6, 'gcgrad')

        call gcfldo('igrf95', MJD, SEC, ih, istat, msg)
        call gcfeld(ih, PLACE, b, istat, msg)
        call check(error, istat == 0 .and. norm2(b) > 2d-5 .and. norm2(b) < 7d-5, 'gcfeld '//msg)
        call gcfree(ih, istat, msg)
        call gcdeno(MJD, SEC, ih, istat, msg)
        call gcdens(ih, MJD, SEC, PLACE, rho, temp, xn, istat, msg)
        ! density from the composition: molar masses 4, 16 and 28 g, little oxygen molecules besides
        call check(error, istat == 0 .and. abs(rho/(dot_product([4d0, 16d0, 28d0], xn)*1.6603d-27) - 1) < 0.05d0 &
                   .and. temp > 700, 'gcdens '//msg)
        call gcfree(ih, istat, msg)
        call gcdeni(200d0, 180d0, 3d0, ih, istat, msg)
        call gcdens(ih, MJD, SEC, PLACE, potential, temp, xn, istat, msg)
        call check(error, istat == 0 .and. abs(potential - rho) > 0, 'gcdeni '//msg)
        call gcfree(ih, istat, msg)
        call gcdenm('dtm94', MJD, SEC, ih, istat, msg)
        call gcdens(ih, MJD, SEC, PLACE, potential, temp, xn, istat, msg)
        call check(error, istat == 0 .and. abs(potential/rho - 1) > 1d-3 .and. abs(potential/rho - 1) < 0.5d0, 'gcdenm '//msg)
        call gcfree(ih, istat, msg)
        call gcdnmi('dtm95', 200d0, 180d0, 3d0, ih, istat, msg)
        call check(error, istat /= 0 .and. index(msg, 'dtm94') > 0, 'gcdnmi '//msg)
        call gcfree(ih, istat, msg)
        call gcwndo('hwm93', ih, istat, msg)
        call gcwind(ih, MJD, SEC, PLACE, east, north, istat, msg)
        call check(error, istat == 0 .and. hypot(east, north) > 0 .and. hypot(east, north) < 500, 'gcwind '//msg)
        call gcfree(ih, istat, msg)
        call gcsun(MJD, SEC, sun, istat, msg)
        call gcshad(PLACE, sun, free, istat, msg)
        call check(error, istat == 0 .and. abs(norm2(sun)/1.496d11 - 1) < 0.02d0 .and. free >= 0 .and. free <= 1, &
                   'gcsun, gcshad '//msg)
        call gcshad(-7d6*sun/norm2(sun), sun, free, istat, msg)
        call check(error, abs(free) <= 0, 'behind the Earth')
        call gcerdo('knocke', 2, 1367d0, ih, istat, msg)
        call gcerad(ih, MJD, SEC, PLACE, flux, istat, msg)
        call check(error, istat == 0 .and. norm2(flux) > 100 .and. norm2(flux) < 1000, 'gcerad '//msg)
        call gcfree(ih, istat, msg)
    end subroutine test_models

    subroutine test_forces(error)
        type(error_type), allocatable, intent(out) :: error
        character(120) :: msg
        type(satellite_dynamics_t) :: dynamics
        type(case_t) :: case
        type(accelerations_t) :: acting
        type(loads_t) :: loads
        integer :: icas, ifrc, istat, m
        double precision :: s, dur, dt, x(13), d(3), g(3), drag(3), sun(3), earth(3), total(3), torques(3, 4), b(3)
        double precision :: rate(13), expected(13)
        double precision, parameter :: T = 2.5d0

        call gccase('back-1', icas, istat, msg)
        call check(error, istat, 0, msg)
        call gccini(icas, m, s, dur, dt, x, d, istat, msg)
        call take_case('back-1', case)
        call check(error, m == case%epoch%mjd .and. abs(dur - 60) <= 0 .and. abs(dt - case%interval) <= 0 &
                   .and. all(abs(x - initial_state(case)) <= 0) .and. all(abs(d - case%satellite%offset) <= 0), 'gccini')
        call make_dynamics(case, dynamics)
        call gcfrco(icas, ifrc, istat, msg)
        call gcfree(icas, istat, msg)       ! the force model does without the case
        call gcforc(ifrc, T, x(1:3), x(4:6), x(10:13), g, drag, sun, earth, total, istat, msg)
        call dynamics%accelerations(T, x(1:3), x(4:6), x(10:13), acting)
        call check(error, istat == 0 .and. all(abs(g - acting%gravity) <= 0) .and. all(abs(drag - acting%drag) <= 0) &
                   .and. all(abs(sun - acting%solar_radiation) <= 0) &
                   .and. all(abs(earth - acting%earth_radiation) <= 0) &
                   .and. all(abs(total - acting%total) <= 0) .and. norm2(drag) > 0, 'gcforc '//msg)
        call gcload(ifrc, T, x, torques, b, istat, msg)
        call dynamics%loads(T, x, loads)
        call check(error, istat == 0 .and. all(abs(torques(:, 1) - loads%torque_aero) <= 0) &
                   .and. all(abs(torques(:, 2) - loads%torque_solar) <= 0) &
                   .and. all(abs(torques(:, 3) - loads%torque_gravity) <= 0) &
                   .and. all(abs(torques(:, 4) - loads%torque_magnetic) <= 0) .and. norm2(torques(:, 4)) > 0 &
                   .and. all(abs(b - loads%field) <= 0), 'gcload '//msg)
        call gcrate(ifrc, T, x, rate, istat, msg)
        call dynamics%rate(T, x, expected)
        call check(error, istat == 0 .and. all(abs(rate - expected) <= 0), 'gcrate '//msg)
        call gcfree(ifrc, istat, msg)
    end subroutine test_forces

    subroutine test_propagation(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 600
        character(120) :: msg
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(error_t), allocatable :: failure
        integer :: icas, ifrc, istat
        double precision :: out(13, 0:N)
        type(nadir_pointing_t) :: held
        type(truth_arc_t) :: arc

        call gccase('front-3', icas, istat, msg)
        call gcfrco(icas, ifrc, istat, msg)
        call take_case('front-3', case)
        call gcprop(ifrc, initial_state(case), case%interval, N, out, istat, msg)
        call check(error, istat, 0, msg)
        call make_simulator(case, simulator)
        call check(error, all(abs(out - simulator%arc%state) <= 0), 'another arc than that of the simulator')
        call gcprop(ifrc, initial_state(case), case%interval, -1, out, istat, msg)
        call check(error, istat == 3 .and. index(msg, 'steps') > 0, 'a negative number of steps')
        call gcprna(ifrc, initial_state(case), 2, 1d0, 20, out, istat, msg)
        call make_dynamics(case, held%satellite_dynamics_t)
        held%forward = .false.
        call propagate_arc(held, initial_state(case), 1d0, 20, arc, failure)
        call check_answer(error, 'gcprna', istat, [out(:, :20)], [arc%state])
        call gcfree(ifrc, istat, msg)
        call gcfree(icas, istat, msg)
    end subroutine test_propagation

    !> By simulation, from files and from arrays: the same estimates as in Fortran.
    subroutine test_estimation(error)
        type(error_type), allocatable, intent(out) :: error
        character(200) :: msg
        type(observation_set_t) :: set
        type(solution_t) :: expected
        type(error_t), allocatable :: failure
        integer :: icas, isim, iobs, iset, istat, niter, iconv, i, n(4), istats(4)
        double precision :: d(3), cov(3, 3), rms(3), cond, time(601), moment(3, 601)
        type(moment_series_t) :: series
        integer :: isetm

        set = simulated_set('front-3', 3, 4)
        call gccase('front-3', icas, istats(1), msg)
        call gcsimo(icas, isim, istats(2), msg)
        call gcsimu(isim, 3, 4, iobs, istats(3), msg)
        call gcobsw(iobs, FOLDER//'f77', istats(4), msg)
        call check(error, all(istats == 0), msg)
        do i = 1, 3
            if (i == 2) call gcobsr(FOLDER//'f77', iobs, istat, msg)
            if (i == 3) then
                call gcsetr(FOLDER//'f77/setup.nml', iset, istat, msg)
                call gcobsc(iset, size(set%accelerometer_time), set%accelerometer_time, set%acceleration, &
                            size(set%star_camera_time), set%star_camera_time, set%star_camera_head, set%quaternion, &
                            size(set%magnetometer_time), set%magnetometer_time, set%field, &
                            size(set%orbit_time), set%orbit_time, set%orbit_position, iobs, istat, msg)
                call check(error, istat, 0, msg)
                call gcfree(iset, istat, msg)
            end if
            call gcobsn(iobs, n, istat, msg)
            call check(error, all(n == [600, 240, 60, 61]), 'gcobsn')
            call gcestm(ESTIMATOR_NAMES(i), iobs, d, cov, rms, cond, niter, iconv, istat, msg)
            call estimate_offset(trim(ESTIMATOR_NAMES(i)), set, report_options('front-3'), expected, failure)
            call check(error, istat == 0 .and. iconv == 1 .and. niter == expected%iterations .and. msg == '' &
                       .and. all(abs(d - expected%offset) <= 0) .and. all(abs(cov - expected%covariance) <= 0) &
                       .and. all(abs(rms - expected%residual_rms) <= 0) .and. abs(cond - expected%condition) <= 0, &
                       'gcestm '//trim(ESTIMATOR_NAMES(i))//' '//msg)
            call gcfree(iobs, istat, msg)
        end do
        ! measured moments: the numbers of the Fortran API
        call gcsetr(FOLDER//'f77/setup.nml', iset, istat, msg)
        time = [(0.1_dp*i, i=0, 600)]
        do i = 1, size(time)
            moment(:, i) = 1.02_dp*dipole_moment(set%knowledge%rods, time(i))
        end do
        call gcsetm(iset, size(time), time, moment, isetm, istat, msg)
        call check(error, istat, 0, msg)
        call gcobsc(isetm, size(set%accelerometer_time), set%accelerometer_time, set%acceleration, &
                    size(set%star_camera_time), set%star_camera_time, set%star_camera_head, set%quaternion, &
                    size(set%magnetometer_time), set%magnetometer_time, set%field, &
                    size(set%orbit_time), set%orbit_time, set%orbit_position, iobs, istat, msg)
        call gcestm('assest-fde', iobs, d, cov, rms, cond, niter, iconv, istat, msg)
        call new_moment_series(time, moment, series, failure)
        call take_measured_moments(series, set%knowledge%rods)
        call estimate_offset('assest-fde', set, report_options('front-3'), expected, failure)
        call check(error, istat == 0 .and. all(abs(d - expected%offset) <= 0), 'gcsetm')
        call gcfree(isetm, istat, msg)
        call gcfree(iobs, istat, msg)
        call gcsetm(iset, -1, time, moment, isetm, istat, msg)
        call check(error, istat /= 0 .and. isetm == 0, 'gcsetm, -1 samples')
        call gcfree(iset, istat, msg)
        ! a gap: the message has the warning
        call gcsetr(FOLDER//'f77/setup.nml', iset, istat, msg)
        call gcobsc(iset, 590, set%accelerometer_time, set%acceleration, size(set%star_camera_time), &
                    set%star_camera_time, set%star_camera_head, set%quaternion, size(set%magnetometer_time), &
                    set%magnetometer_time, set%field, 0, set%orbit_time, set%orbit_position, iobs, istat, msg)
        call gcestm('assest-fde', iobs, d, cov, rms, cond, niter, iconv, istat, msg)
        call check(error, istat == 0 .and. index(msg, '10 of 600 samples are missing') > 0, msg)
        call gcfree(iobs, istat, msg)
        call gcfree(iset, istat, msg)
        call gcfree(isim, istat, msg)
        call gcfree(icas, istat, msg)
    end subroutine test_estimation

    !> What an estimate tells, of one observation set, of two, and of arcs; with other options, and without convergence.
    subroutine test_answers(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: ALGO = 'sequential'
        integer, parameter :: NMAX = 2000
        character(200) :: msg
        character(4000) :: text
        type(simulator_t) :: simulator
        type(observation_set_t) :: set(2)
        type(solution_t) :: expected
        type(fit_record_t) :: record
        type(fit_diagnostics_t) :: tests
        type(verdict_t) :: verdict
        type(joint_run_t) :: runs(2)
        type(joint_solution_t) :: joint
        type(arc_chain_t) :: chain
        type(error_t), allocatable :: failure
        integer :: icas, isim, iobs(2), ifit, inew, istat, n, nd, icons, counts(3), i, k
        double precision :: t(NMAX), a(3, NMAX), b(3, NMAX), d(3), cov(3, 3), chi, prob

        call make_simulator('front-3', simulator)
        call gccase('front-3', icas, istat, msg)
        call gcsimo(icas, isim, istat, msg)
        do i = 1, 2
            call make_observations(simulator, 1, i, set(i))
            call gcsimu(isim, 1, i, iobs(i), istat, msg)
            call run_from_observations(set(i), report_options('front-3'), runs(i), failure)
        end do
        if (estimate_fails(error, ALGO, set(1), report_options('front-3'), expected, record)) return

        call gcesto(ALGO, iobs(1), ifit, istat, msg)
        call check(error, istat, 0, msg)
        call gcget(ifit, 'offset residual_rms', NMAX, n, t, istat, msg)
        call check_answer(error, 'gcget', istat, [dble(n), t(:6)], [6d0, expected%offset, expected%residual_rms])
        call gcget(ifit, 'offset', 2, n, t, istat, msg)
        call check(error, istat == 3 .and. n == 3, 'gcget without room '//msg)
        call gcgett(ifit, 'parameter_names', text, istat, msg)
        call check(error, istat == 0 .and. index(text, trim(expected%parameters(1)%name)//new_line('a')) == 1, 'gcgett '//msg)
        call gcgett(ifit, 'parameter_names', text(:5), istat, msg)
        call check(error, istat, 3, 'gcgett without room')
        call gcfree(ifit, istat, msg)

        k = size(record%epoch)
        call gcresd(ALGO, iobs(1), NMAX, n, t, a, istat, msg)
        call check_answer(error, 'gcresd', istat, [dble(n), t(:k), [a(:, :k)]], &
                          [dble(k), (time_tag(record%epoch(i), record%interval), i=1, k), [record%residual]])
        associate (running => expected%running)
            k = size(running%time)
            call gcrunn(iobs(1), NMAX, n, t, a, b, istat, msg)
            call check_answer(error, 'gcrunn', istat, [dble(n), t(:k), [a(:, :k)], [b(:, :k)]], &
                              [dble(k), running%time, [running%offset], [running%sigma]])
        end associate
        call gcblf(ALGO, iobs(1), d, t, counts(1), counts(2), counts(3), istat, msg)
        associate (beliefs => expected%beliefs)
            call check_answer(error, 'gcblf', istat, [d, t(:3), dble(counts)], &
                              [beliefs%undetected(.false.), beliefs%apart, &
                               dble([beliefs%how_many(), beliefs%how_many(CONTRADICTED), &
                                                                          beliefs%how_many(UNTESTED)])])
        end associate

        call gcact(ALGO, iobs(1), counts(1), d, t, istat, msg)
        call diagnose(set(1)%knowledge, expected, record, tests, failure)
        verdict = judge(set(1)%knowledge, expected, record, tests)
        call check_answer(error, 'gcact', istat, [dble(counts(1)), d, t(:3)], &
                          [dble(verdict%action%kind), merge(1d0, 0d0, [verdict%action%trimmed, verdict%action%again])])
        call check(error, len_trim(msg) > 10 .and. index(verdict%action%text, trim(msg)) == 1, msg)

        call estimate_runs(runs, joint_options_t(), joint, failure)
        call gcjnt(2, iobs, d, cov, chi, nd, prob, icons, istat, msg)
        call check_answer(error, 'gcjnt', istat, [d, [cov], chi, dble(nd), prob, dble(icons)], &
                          [joint%offset, [joint%covariance], joint%statistic, dble(joint%degrees), joint%probability, &
                           merge(1d0, 0d0, joint%consistent)])
        call estimate_chain(set(1), report_options('front-3'), joint_options_t(), 20d0, 1, chain, failure)
        call gcchn(iobs(1), 20d0, 2, d, cov, chi, nd, prob, icons, counts(1), counts(2), istat, msg)
        call check_answer(error, 'gcchn', istat, [d, [cov], chi, dble(nd), prob, dble(icons), dble(counts(:2))], &
                          [chain%solution%offset, [chain%solution%covariance], chain%solution%statistic, &
                           dble(chain%solution%degrees), chain%solution%probability, &
                           merge(1d0, 0d0, chain%solution%consistent), 3d0, dble(count(chain%arcs%joined))])

        call gcoptn(iobs(1), '&estimation guess_angular_velocity = 0.9, -0.9, 0.9 /', inew, istat, msg)
        call gcgett(inew, 'options', text, istat, msg)
        call check(error, istat == 0 .and. index(text, 'guess_angular_velocity = 0.9, -0.9, 0.9') > 0, 'gcoptn '//msg)
        n = -1
        call gcresd('assest-fde', inew, NMAX, n, t, a, istat, msg)
        call check(error, istat == 6 .and. n > 0 .and. n <= 600 .and. index(msg, 'did not converge') > 0, &
                   'gcresd of an estimate that does not converge '//msg)
        call gcfree(inew, istat, msg)
        do i = 1, 2
            call gcfree(iobs(i), istat, msg)
        end do
        call gcfree(isim, istat, msg)
        call gcfree(icas, istat, msg)
    end subroutine test_answers

    !> Bound, design with few candidates, its rods and its map: each other's numbers and those of the Fortran
    !> API.
    subroutine test_planning(error)
        type(error_type), allocatable, intent(out) :: error
        character(200) :: msg
        type(case_t) :: case
        type(case_bound_t) :: bound
        type(error_t), allocatable :: failure
        integer :: icas, jcas, istat, iopt(8), irod(2, 9), n, i
        double precision :: sig(3), cov(3, 3), psig(3), dir(3, 3), csig(3), opt(9), wave(3), frc(3), amot(2)
        double precision :: rod(7, 9), plc(2, 2), sigs(3, 2), wrst(4, 2), start, chosen
        type(calibration_t) :: calibration, planned
        type(manoeuvre_design_t) :: design

        call take_case('front-3', case)
        call bound_of_case(case, estimation_options_t(), bound, failure)
        call gccase('front-3', icas, istat, msg)
        call gcbnd(icas, sig, cov, psig, dir, csig, istat, msg)
        call check(error, istat == 0 .and. all(abs(sig - bound%sigma) <= 0) .and. all(sig > 0) .and. &
                   all(abs(cov - bound%covariance) <= 0) .and. all(abs(dir - bound%direction) <= 0) .and. &
                   all(abs(psig - bound%principal_sigma) <= 0) .and. all(csig > sig), 'gcbnd '//msg)

        call gcdsgd(icas, opt, iopt, istat, msg)
        call check(error, istat == 0 .and. abs(opt(2) - 60) <= 0 .and. all(iopt == [1, 1, 1, 1, 0, 1, 1, 1]), &
                   'gcdsgd '//msg)
        opt(4:5) = [6d0, 7d0]/60
        iopt(4:7) = [1, 0, 0, 0]
        call gcdsgn(icas, opt, iopt, jcas, sig, wave, frc, amot, istat, msg)
        call check(error, istat == 0 .and. jcas > 0 .and. all(sig > 0) .and. all(sig < 1d-5) .and. &
                   all(amot <= opt(8:9)) .and. all(amot > 0), 'gcdsgn '//msg)
        call gcrods(jcas, 9, n, rod, irod, istat, msg)
        call check(error, istat == 0 .and. n == 3 .and. all(irod(1, :3) == [1, 2, 3]) .and. all(irod(2, :3) == 1) .and. &
                   all(rod(2, :3) >= opt(4) .and. rod(2, :3) <= opt(5)) .and. all(abs(rod(5, :3) - 60) <= 0), &
                   'gcrods '//msg)
        call gcmap(jcas, 2, [0d0, 1400d0], 2, plc, sigs, wrst, istat, msg)
        call check(error, istat == 0 .and. all(abs(sigs(:, 1) - sig) < 1d-9*sig) .and. &
                   all(wrst(1, :) >= maxval(sigs, 1)*(1 - 1d-12)), 'gcmap '//msg)
        do i = 1, 2
            call check(error, abs(norm2(wrst(2:4, i)) - 1) < 1d-12, 'gcmap: a direction')
        end do

        call gcrods(jcas, 2, n, rod, irod, istat, msg)
        call check(error, istat == 3 .and. n == 3 .and. index(msg, 'there are 21 numbers') > 0, msg)
        call gcrods(jcas, -1, n, rod, irod, istat, msg)
        call check(error, istat, 3, 'a negative number of columns')
        call gcmap(jcas, -1, [0d0], 1, plc, sigs, wrst, istat, msg)
        call check(error, istat, 3, 'a negative number of places')
        call gcfree(jcas, istat, msg)
        call gcdsga(icas, opt, iopt, 2, 1, jcas, start, sig, wave, frc, amot, istat, msg)
        call take_calibration('front-3', calibration)
        call plan_manoeuvre(calibration, 0d0, design_settings_t(lowest_frequency=opt(4), highest_frequency=opt(5), &
                                                                waveform_used=[.true., .false., .false., .false.]), &
                            planned, design, failure, 2, 1, chosen)
        call check_answer(error, 'gcdsga', istat, [start, sig, wave, frc, amot], &
                          [chosen, design%sigma, design%wave, design%force, design%rate, design%excursion])
        call check(error, jcas > 0 .and. start > 0, 'gcdsga: the best start')
        call gcfree(jcas, istat, msg)
        iopt(1:3) = 0
        call gcdsgn(icas, opt, iopt, jcas, sig, wave, frc, amot, istat, msg)
        call check(error, istat == 5 .and. jcas == 0 .and. index(msg, 'rods are off') > 0, msg)
        call gcfree(icas, istat, msg)
        call gcbnd(icas, sig, cov, psig, dir, csig, istat, msg)
        call check(error, istat, 2, 'the bound of a case that was freed')
    end subroutine test_planning

    subroutine test_messages(error)
        type(error_type), allocatable, intent(out) :: error
        character(80) :: msg
        character(10) :: short
        character(0) :: none
        integer :: ih, istat, copy
        double precision :: a(3), u, nan

        msg = repeat('#', 80)
        call gcgrvo('egm69   ', 2, 2, ih, istat, msg)
        call check(error, istat == 5 .and. ih == 0 .and. index(msg, 'no gravity model "egm69"') == 1, msg)
        call gcgrvo('egm69', 2, 2, ih, istat, short)
        call check(error, short, 'no gravity')
        call gcgrvo('egm69', 2, 2, ih, istat, none)
        call check(error, istat, 5, 'without room for a message')
        call gcgrvo('egm96  ', 2, 2, ih, istat, msg)
        call check(error, istat == 0 .and. msg == '', msg)
        nan = -1
        nan = sqrt(nan)
        call gcgrav(ih, [7d6, nan, 0d0], a, u, istat, msg)
        call check(error, istat == 4 .and. index(msg, 'NaN') > 0, msg)
        call gcfeld(ih, PLACE, a, istat, msg)
        call check(error, istat == 2 .and. index(msg, 'geomagnetic field') > 0, msg)
        copy = ih
        call gcfree(ih, istat, msg)
        call check(error, istat == 0 .and. ih == 0, msg)
        call gcfree(ih, istat, msg)
        call check(error, istat, 0, 'nothing to free')
        call gcfree(copy, istat, msg)
        call check(error, istat, 2, 'freed twice')
        call gcgrav(-5, PLACE, a, u, istat, msg)
        call check(error, istat, 2, 'a negative handle')
        call gcutc('yesterday', ih, u, istat, msg)
        call check(error, istat == 4 .and. index(msg, 'yesterday') > 0, msg)
    end subroutine test_messages

    !> The tests above have freed all that they made.
    subroutine test_nothing_left(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, live_objects(), 0, 'objects are left')
    end subroutine test_nothing_left
end module test_f77
