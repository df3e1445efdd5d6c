!> The Fortran 77 entry points: the numbers of the Fortran API, status and message.
module test_f77
    use gracecg, only: estimation_options_t, report_options
    use gracecg, only: dp, error_t, LIBRARY_VERSION, case_t, find_case, build_dynamics, &
        initial_state, satellite_dynamics_t, accelerations_t, loads_t, simulator_t, new_simulator, observe, &
        observation_set_t, solution_t, estimate_offset, write_observations, geopotential_t, egm96, &
        drag_acceleration, solar_radiation_acceleration, ESTIMATOR_NAMES, case_bound_t, bound_of_case, &
        moment_series_t, new_moment_series, take_measured_moments, dipole_moment
    use gracecg_interface_handles, only: live_objects
    use f77_interfaces
    use fixture, only: FOLDER, make_folder
    use testdrive, only: new_unittest, unittest_type, error_type, check
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
                    new_unittest('surface', test_surface), &
                    new_unittest('forces', test_forces), &
                    new_unittest('propagation', test_propagation), &
                    new_unittest('estimation', test_estimation), &
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
        double precision :: expected(3), potential, fixed(3), many_places(3, 11), many(3, 11), potentials(11)

        call gcvers(version)
        call check(error, version, LIBRARY_VERSION)
        if (allocated(error)) return
        call gcutc('1989-01-02T01:00:00', m, s, istat, msg)
        call check(error, istat == 0 .and. m == MJD .and. abs(s - SEC) <= 0 .and. msg == '', 'gcutc '//msg)
        if (allocated(error)) return
        call gcuadd(MJD, SEC, 86400d0, m, s, istat, msg)
        call gcudif(MJD, SEC, m, s, u, istat, msg)
        call check(error, istat == 0 .and. abs(u - 86400) <= 0 .and. m == MJD + 1, 'gcuadd, gcudif')
        if (allocated(error)) return
        call gcgmst(MJD, SEC, 0d0, theta, istat, msg)
        call gcrotz(theta, PLACE, fixed, istat, msg)
        call gcrotz(-theta, fixed, a, istat, msg)
        call check(error, istat == 0 .and. maxval(abs(a - PLACE)) < 1d-8 .and. norm2(fixed - PLACE) > 1d5, 'gcrotz')
        if (allocated(error)) return

        call gcgrvo('egm96', 20, 20, ih, istat, msg)
        call check(error, istat == 0 .and. ih > 0, 'gcgrvo '//msg)
        if (allocated(error)) return
        call gcgrav(ih, PLACE, a, u, istat, msg)
        call gcgrad(ih, PLACE, g, istat, msg)
        many_places = spread(PLACE, 2, 11)
        many_places(3, 11) = -many_places(3, 11)
        call gcgrvn(ih, 11, many_places, many, potentials, istat, msg)
        call check(error, istat == 0 .and. all(abs(many(:, :10) - spread(a, 2, 10)) <= 0) .and. &
                   all(abs(potentials(:10) - u) <= 0) .and. any(abs(many(:, 11) - a) > 0), 'gcgrvn '//msg)
        if (allocated(error)) return
        call gcfree(ih, istat, msg)
        call egm96(20, 20, model, failure)
        call model%acceleration(PLACE, expected)
        call model%potential(PLACE, potential)
        ! not to the last bit: products are fused in other places where potential and acceleration are asked for at once
        call check(error, norm2(a - expected) <= 2d-15*norm2(expected) .and. abs(u - potential) <= 2d-15*potential .and. &
                   ih == 0, 'gcgrav')
        if (allocated(error)) return
        ! Laplace's equation
        call check(error, abs(g(1, 1) + g(2, 2) + g(3, 3)) < 1d-12*norm2(g) .and. norm2(g) > 1d-6, 'gcgrad')
        if (allocated(error)) return

        call gcfldo('igrf95', MJD, SEC, ih, istat, msg)
        call gcfeld(ih, PLACE, b, istat, msg)
        call check(error, istat == 0 .and. norm2(b) > 2d-5 .and. norm2(b) < 7d-5, 'gcfeld '//msg)
        if (allocated(error)) return
        call gcfree(ih, istat, msg)
        call gcdeno(MJD, SEC, ih, istat, msg)
        call gcdens(ih, MJD, SEC, PLACE, rho, temp, xn, istat, msg)
        ! density from the composition: molar masses 4, 16 and 28 g, little oxygen molecules besides
        call check(error, istat == 0 .and. abs(rho/(dot_product([4d0, 16d0, 28d0], xn)*1.6603d-27) - 1) < 0.05d0 &
                   .and. temp > 700, 'gcdens '//msg)
        if (allocated(error)) return
        call gcfree(ih, istat, msg)
        call gcdeni(200d0, 180d0, 3d0, ih, istat, msg)
        call gcdens(ih, MJD, SEC, PLACE, potential, temp, xn, istat, msg)
        call check(error, istat == 0 .and. abs(potential - rho) > 0, 'gcdeni '//msg)
        if (allocated(error)) return
        call gcfree(ih, istat, msg)
        call gcdenm('dtm94', MJD, SEC, ih, istat, msg)
        call gcdens(ih, MJD, SEC, PLACE, potential, temp, xn, istat, msg)
        call check(error, istat == 0 .and. abs(potential/rho - 1) > 1d-3 .and. abs(potential/rho - 1) < 0.5d0, 'gcdenm '//msg)
        if (allocated(error)) return
        call gcfree(ih, istat, msg)
        call gcdnmi('dtm95', 200d0, 180d0, 3d0, ih, istat, msg)
        call check(error, istat /= 0 .and. index(msg, 'dtm94') > 0, 'gcdnmi '//msg)
        if (allocated(error)) return
        call gcfree(ih, istat, msg)
        call gcwndo('hwm93', ih, istat, msg)
        call gcwind(ih, MJD, SEC, PLACE, east, north, istat, msg)
        call check(error, istat == 0 .and. hypot(east, north) > 0 .and. hypot(east, north) < 500, 'gcwind '//msg)
        if (allocated(error)) return
        call gcfree(ih, istat, msg)
        call gcsun(MJD, SEC, sun, istat, msg)
        call gcshad(PLACE, sun, free, istat, msg)
        call check(error, istat == 0 .and. abs(norm2(sun)/1.496d11 - 1) < 0.02d0 .and. free >= 0 .and. free <= 1, &
                   'gcsun, gcshad '//msg)
        if (allocated(error)) return
        call gcshad(-7d6*sun/norm2(sun), sun, free, istat, msg)
        call check(error, abs(free) <= 0, 'behind the Earth')
        if (allocated(error)) return
        call gcerdo('knocke', 2, 1367d0, ih, istat, msg)
        call gcerad(ih, MJD, SEC, PLACE, flux, istat, msg)
        call check(error, istat == 0 .and. norm2(flux) > 100 .and. norm2(flux) < 1000, 'gcerad '//msg)
        call gcfree(ih, istat, msg)
    end subroutine test_models

    subroutine test_surface(error)
        type(error_type), allocatable, intent(out) :: error

        character(120) :: msg
        type(satellite_dynamics_t) :: dynamics
        type(case_t) :: case
        type(error_t), allocatable :: failure
        integer :: ih, istat
        double precision :: a(3), b(3)
        double precision, parameter :: V(3) = [7600d0, 30d0, -20d0], TO_SUN(3) = [1d11, 5d10, -9d10]
        double precision, parameter :: CUBE(3, 6) = reshape([1d0, 0d0, 0d0, -1d0, 0d0, 0d0, 0d0, 1d0, 0d0, &
                                                             0d0, -1d0, 0d0, 0d0, 0d0, 1d0, 0d0, 0d0, -1d0], [3, 6])
        integer :: i

        call find_case('front-1', case, failure)
        call build_dynamics(case, dynamics, failure)
        call gctrap(case%satellite%length, case%satellite%height, case%satellite%width_bottom, &
                    case%satellite%width_top, case%satellite%specular, case%satellite%diffuse, ih, &
                    istat, msg)
        call check(error, istat, 0, msg)
        if (allocated(error)) return
        call gcdrag(ih, 420d0, 2d0, 4d-12, V, a, istat, msg)
        call check(error, all(abs(a - drag_acceleration(dynamics%surface, 420d0, 2d0, 4d-12, V)) <= 0), 'gcdrag')
        if (allocated(error)) return
        call gcsrp(ih, 420d0, 0.5d0, 1367d0, 1d0, TO_SUN, a, istat, msg)
        call check(error, all(abs(a - solar_radiation_acceleration(dynamics%surface, 420d0, 0.5d0, 1367d0, 1d0, &
                                                                   TO_SUN)) <= 0), 'gcsrp')
        if (allocated(error)) return
        ! the Earth's light pushes along its flux
        call gcerp(ih, 420d0, 0.5d0, [0d0, 0d0, 250d0], [0d0, 0d0, 7d6], [0d0, 0d0, 0d0, 1d0], a, istat, msg)
        call check(error, istat == 0 .and. a(3) > 1d-9 .and. norm2(a(1:2)) <= 0, 'gcerp '//msg)
        if (allocated(error)) return
        call gcfree(ih, istat, msg)
        ! a cube of 2 m: drag along x as of its front
        call gcplat(6, CUBE, [(4d0, i=1, 6)], CUBE, [(0d0, i=1, 6)], [(0d0, i=1, 6)], ih, istat, msg)
        call gcdrag(ih, 420d0, 2d0, 4d-12, [7600d0, 0d0, 0d0], b, istat, msg)
        call check(error, istat == 0 .and. norm2(b - [-4d-12*4*7600d0**2/420, 0d0, 0d0]) < 1d-18, 'gcplat '//msg)
        call gcfree(ih, istat, msg)
    end subroutine test_surface

    subroutine test_forces(error)
        type(error_type), allocatable, intent(out) :: error

        character(120) :: msg
        type(satellite_dynamics_t) :: dynamics
        type(case_t) :: case
        type(accelerations_t) :: acting
        type(loads_t) :: loads
        type(error_t), allocatable :: failure
        integer :: icas, ifrc, istat, m
        double precision :: s, dur, dt, x(13), d(3), g(3), drag(3), sun(3), earth(3), total(3), torques(3, 4), b(3)
        double precision :: rate(13), expected(13)
        double precision, parameter :: T = 2.5d0

        call gccase('back-1', icas, istat, msg)
        call check(error, istat, 0, msg)
        if (allocated(error)) return
        call gccini(icas, m, s, dur, dt, x, d, istat, msg)
        call find_case('back-1', case, failure)
        call check(error, m == case%epoch%mjd .and. abs(dur - 60) <= 0 .and. abs(dt - case%interval) <= 0 &
                   .and. all(abs(x - initial_state(case)) <= 0) .and. all(abs(d - case%satellite%offset) <= 0), 'gccini')
        if (allocated(error)) return
        call build_dynamics(case, dynamics, failure)
        call gcfrco(icas, ifrc, istat, msg)
        call gcfree(icas, istat, msg)       ! the force model does without the case
        call gcforc(ifrc, T, x(1:3), x(4:6), x(10:13), g, drag, sun, earth, total, istat, msg)
        call dynamics%accelerations(T, x(1:3), x(4:6), x(10:13), acting)
        call check(error, istat == 0 .and. all(abs(g - acting%gravity) <= 0) .and. all(abs(drag - acting%drag) <= 0) &
                   .and. all(abs(sun - acting%solar_radiation) <= 0) &
                   .and. all(abs(earth - acting%earth_radiation) <= 0) &
                   .and. all(abs(total - acting%total) <= 0) .and. norm2(drag) > 0, 'gcforc '//msg)
        if (allocated(error)) return
        call gcload(ifrc, T, x, torques, b, istat, msg)
        call dynamics%loads(T, x, loads)
        call check(error, istat == 0 .and. all(abs(torques(:, 1) - loads%torque_aero) <= 0) &
                   .and. all(abs(torques(:, 2) - loads%torque_solar) <= 0) &
                   .and. all(abs(torques(:, 3) - loads%torque_gravity) <= 0) &
                   .and. all(abs(torques(:, 4) - loads%torque_magnetic) <= 0) .and. norm2(torques(:, 4)) > 0 &
                   .and. all(abs(b - loads%field) <= 0), 'gcload '//msg)
        if (allocated(error)) return
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

        call gccase('front-3', icas, istat, msg)
        call gcfrco(icas, ifrc, istat, msg)
        call find_case('front-3', case, failure)
        call gcprop(ifrc, initial_state(case), case%interval, N, out, istat, msg)
        call check(error, istat, 0, msg)
        if (allocated(error)) return
        call new_simulator(case, simulator, failure)
        call check(error, all(abs(out - simulator%arc%state) <= 0), 'another arc than that of the simulator')
        if (allocated(error)) return
        call gcprop(ifrc, initial_state(case), case%interval, -1, out, istat, msg)
        call check(error, istat == 3 .and. index(msg, 'steps') > 0, 'a negative number of steps')
        call gcfree(ifrc, istat, msg)
        call gcfree(icas, istat, msg)
    end subroutine test_propagation

    !> By simulation, from files and from arrays: the same estimates as in Fortran.
    subroutine test_estimation(error)
        type(error_type), allocatable, intent(out) :: error

        character(200) :: msg
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(observation_set_t) :: set
        type(solution_t) :: expected
        type(error_t), allocatable :: failure
        integer :: icas, isim, iobs, iset, istat, niter, iconv, i, n(4), istats(4)
        double precision :: d(3), cov(3, 3), rms(3), cond, time(601), moment(3, 601)
        type(moment_series_t) :: series
        integer :: isetm

        call make_folder(error)
        if (allocated(error)) return
        call find_case('front-3', case, failure)
        call new_simulator(case, simulator, failure)
        call observe(simulator, 3, 4, set, failure)
        call gccase('front-3', icas, istats(1), msg)
        call gcsimo(icas, isim, istats(2), msg)
        call gcsimu(isim, 3, 4, iobs, istats(3), msg)
        call gcobsw(iobs, FOLDER//'f77', istats(4), msg)
        call check(error, all(istats == 0), msg)
        if (allocated(error)) return
        do i = 1, 3
            if (i == 2) call gcobsr(FOLDER//'f77', iobs, istat, msg)
            if (i == 3) then
                call gcsetr(FOLDER//'f77/setup.nml', iset, istat, msg)
                call gcobsc(iset, size(set%accelerometer_time), set%accelerometer_time, set%acceleration, &
                            size(set%star_camera_time), set%star_camera_time, set%star_camera_head, set%quaternion, &
                            size(set%magnetometer_time), set%magnetometer_time, set%field, &
                            size(set%orbit_time), set%orbit_time, set%orbit_position, iobs, istat, msg)
                call check(error, istat, 0, msg)
                if (allocated(error)) return
                call gcfree(iset, istat, msg)
            end if
            call gcobsn(iobs, n, istat, msg)
            call check(error, all(n == [600, 240, 60, 61]), 'gcobsn')
            if (allocated(error)) return
            call gcestm(ESTIMATOR_NAMES(i), iobs, d, cov, rms, cond, niter, iconv, istat, msg)
            call estimate_offset(trim(ESTIMATOR_NAMES(i)), set, report_options('front-3'), expected, failure)
            call check(error, istat == 0 .and. iconv == 1 .and. niter == expected%iterations .and. msg == '' &
                       .and. all(abs(d - expected%offset) <= 0) .and. all(abs(cov - expected%covariance) <= 0) &
                       .and. all(abs(rms - expected%residual_rms) <= 0) .and. abs(cond - expected%condition) <= 0, &
                       'gcestm '//trim(ESTIMATOR_NAMES(i))//' '//msg)
            if (allocated(error)) return
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
        if (allocated(error)) return
        call gcobsc(isetm, size(set%accelerometer_time), set%accelerometer_time, set%acceleration, &
                    size(set%star_camera_time), set%star_camera_time, set%star_camera_head, set%quaternion, &
                    size(set%magnetometer_time), set%magnetometer_time, set%field, &
                    size(set%orbit_time), set%orbit_time, set%orbit_position, iobs, istat, msg)
        call gcestm('assest-fde', iobs, d, cov, rms, cond, niter, iconv, istat, msg)
        call new_moment_series(series, time, moment, failure)
        call take_measured_moments(series, set%knowledge%rods)
        call estimate_offset('assest-fde', set, report_options('front-3'), expected, failure)
        call check(error, istat == 0 .and. all(abs(d - expected%offset) <= 0), 'gcsetm')
        if (allocated(error)) return
        call gcfree(isetm, istat, msg)
        call gcfree(iobs, istat, msg)
        call gcsetm(iset, -1, time, moment, isetm, istat, msg)
        call check(error, istat /= 0 .and. isetm == 0, 'gcsetm, -1 samples')
        if (allocated(error)) return
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
        double precision :: rod(7, 9), plc(2, 2), sigs(3, 2), wrst(4, 2)

        call find_case('front-3', case, failure)
        call bound_of_case(case, estimation_options_t(), bound, failure)
        call gccase('front-3', icas, istat, msg)
        call gcbnd(icas, sig, cov, psig, dir, csig, istat, msg)
        call check(error, istat == 0 .and. all(abs(sig - bound%sigma) <= 0) .and. all(sig > 0) .and. &
                   all(abs(cov - bound%covariance) <= 0) .and. all(abs(dir - bound%direction) <= 0) .and. &
                   all(abs(psig - bound%principal_sigma) <= 0) .and. all(csig > sig), 'gcbnd '//msg)
        if (allocated(error)) return

        call gcdsgd(icas, opt, iopt, istat, msg)
        call check(error, istat == 0 .and. abs(opt(2) - 60) <= 0 .and. all(iopt == [1, 1, 1, 1, 0, 1, 1, 1]), &
                   'gcdsgd '//msg)
        if (allocated(error)) return
        opt(4:5) = [6d0, 7d0]/60
        iopt(4:7) = [1, 0, 0, 0]
        call gcdsgn(icas, opt, iopt, jcas, sig, wave, frc, amot, istat, msg)
        call check(error, istat == 0 .and. jcas > 0 .and. all(sig > 0) .and. all(sig < 1d-5) .and. &
                   all(amot <= opt(8:9)) .and. all(amot > 0), 'gcdsgn '//msg)
        if (allocated(error)) return
        call gcrods(jcas, 9, n, rod, irod, istat, msg)
        call check(error, istat == 0 .and. n == 3 .and. all(irod(1, :3) == [1, 2, 3]) .and. all(irod(2, :3) == 1) .and. &
                   all(rod(2, :3) >= opt(4) .and. rod(2, :3) <= opt(5)) .and. all(abs(rod(5, :3) - 60) <= 0), &
                   'gcrods '//msg)
        if (allocated(error)) return
        call gcmap(jcas, 2, [0d0, 1400d0], 2, plc, sigs, wrst, istat, msg)
        call check(error, istat == 0 .and. all(abs(sigs(:, 1) - sig) < 1d-9*sig) .and. &
                   all(wrst(1, :) >= maxval(sigs, 1)*(1 - 1d-12)), 'gcmap '//msg)
        if (allocated(error)) return
        do i = 1, 2
            call check(error, abs(norm2(wrst(2:4, i)) - 1) < 1d-12, 'gcmap: a direction')
            if (allocated(error)) return
        end do

        call gcrods(jcas, 2, n, rod, irod, istat, msg)
        call check(error, istat == 3 .and. n == 3 .and. index(msg, 'there are 21 numbers') > 0, msg)
        if (allocated(error)) return
        call gcrods(jcas, -1, n, rod, irod, istat, msg)
        call check(error, istat, 3, 'a negative number of columns')
        if (allocated(error)) return
        call gcmap(jcas, -1, [0d0], 1, plc, sigs, wrst, istat, msg)
        call check(error, istat, 3, 'a negative number of places')
        if (allocated(error)) return
        call gcfree(jcas, istat, msg)
        iopt(1:3) = 0
        call gcdsgn(icas, opt, iopt, jcas, sig, wave, frc, amot, istat, msg)
        call check(error, istat == 5 .and. jcas == 0 .and. index(msg, 'rods are off') > 0, msg)
        if (allocated(error)) return
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
        if (allocated(error)) return
        call gcgrvo('egm69', 2, 2, ih, istat, short)
        call check(error, short, 'no gravity')
        if (allocated(error)) return
        call gcgrvo('egm69', 2, 2, ih, istat, none)
        call check(error, istat, 5, 'without room for a message')
        if (allocated(error)) return
        call gcgrvo('egm96  ', 2, 2, ih, istat, msg)
        call check(error, istat == 0 .and. msg == '', msg)
        if (allocated(error)) return
        nan = -1
        nan = sqrt(nan)
        call gcgrav(ih, [7d6, nan, 0d0], a, u, istat, msg)
        call check(error, istat == 4 .and. index(msg, 'NaN') > 0, msg)
        if (allocated(error)) return
        call gcfeld(ih, PLACE, a, istat, msg)
        call check(error, istat == 2 .and. index(msg, 'geomagnetic field') > 0, msg)
        if (allocated(error)) return
        copy = ih
        call gcfree(ih, istat, msg)
        call check(error, istat == 0 .and. ih == 0, msg)
        if (allocated(error)) return
        call gcfree(ih, istat, msg)
        call check(error, istat, 0, 'nothing to free')
        if (allocated(error)) return
        call gcfree(copy, istat, msg)
        call check(error, istat, 2, 'freed twice')
        if (allocated(error)) return
        call gcgrav(-5, PLACE, a, u, istat, msg)
        call check(error, istat, 2, 'a negative handle')
        if (allocated(error)) return
        call gcutc('yesterday', ih, u, istat, msg)
        call check(error, istat == 4 .and. index(msg, 'yesterday') > 0, msg)
    end subroutine test_messages

    !> The tests above have freed all that they made.
    subroutine test_nothing_left(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, live_objects(), 0, 'objects are left')
    end subroutine test_nothing_left
end module test_f77
