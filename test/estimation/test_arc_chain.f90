!> Long runs in arcs: an arc that is cut out is the run that begins there, the chain is the joint estimate of its arcs,
!> and what cannot be estimated is left out or refused.
module test_arc_chain
    use vocabulary
    use calibrations
    use gracecg_environment_earth_orientation, only: earth_orientation_t, new_earth_orientation
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_environment_time, only: utc_plus, sidereal_angle, parse_utc
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_activation_t, dipole_moment, moves_rods, begin_rods_at, &
        new_torque_rods
    use gracecg_observations_arc_of_run, only: arc_of_run
    use gracecg_estimation_arc_chain, only: arc_chain_t, estimate_chain
    use gracecg_estimation_joint_estimate, only: joint_options_t, joint_solution_t
    use gracecg_estimation_joint_runs, only: joint_run_t, run_from_observations, estimate_runs
    use gracecg_estimation_options, only: WAVE_NONE
    implicit none
    private
    public :: collect_arc_chain

    real(dp), parameter :: ARC = 20     !! s

contains

    subroutine collect_arc_chain(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('an-arc-is-the-run-that-begins-there', test_arc), &
                    new_unittest('rods-of-an-arc', test_rods), &
                    new_unittest('earth-of-an-arc', test_earth), &
                    new_unittest('chain-is-the-joint-estimate-of-its-arcs', test_chain), &
                    new_unittest('arcs-left-out', test_left_out), &
                    new_unittest('an-arc-that-disagrees', test_apart), &
                    new_unittest('an-arc-at-the-edge-of-the-shadow', test_shadow), &
                    new_unittest('refused', test_refused)]
    end subroutine collect_arc_chain

    !> Front 3 without a density wave.
    subroutine open_case(simulator, options, duration)
        type(simulator_t), intent(out) :: simulator
        type(estimation_options_t), intent(out) :: options
        real(dp), intent(in), optional :: duration      !! With rods that act all the time, s
        type(calibration_t) :: calibration

        call take_calibration('front-3', calibration)
        associate (case => calibration%case)
            case%density_wave%amplitude = 0
            case%density_wave_random = .false.
            if (present(duration)) then
                case%duration = duration
                case%satellite%rods%activations%stop = duration
                case%limits%pointing = 3
                case%limits%rate = 1
            end if
            call make_simulator(case, simulator)
        end associate
        options%optimal%density_wave = WAVE_NONE
        options%covariance = .false.
    end subroutine open_case

    !> The samples of an arc, without noise, are those of a simulation that begins at its time 0 with the state, the
    !> manoeuvre, the Earth's angle and the density wave of that time.
    subroutine test_arc(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: FROM = 16, LATER = 160        ! s, epochs
        type(calibration_t) :: calibration
        type(simulator_t) :: whole, part
        type(observation_set_t) :: run, cut, begun
        type(density_wave_t) :: wave
        integer :: n

        call take_calibration('front-3', calibration)
        calibration%case%duration = 40
        call make_simulator(calibration%case, whole)
        wave = density_wave_t(0.003_dp, 12.0_dp, 0.7_dp)
        call observe_without_noise(whole, wave, run)
        call arc_of_run(run, run%knowledge, real(FROM, dp), calibration%case%duration, cut)

        associate (case => calibration%case, state => whole%arc%state(:, LATER))
            case%position = state(1:3)
            case%velocity = state(4:6)
            case%angular_velocity = state(7:9)
            case%quaternion = state(10:13)
            case%duration = case%duration - FROM
            case%epoch = utc_plus(case%epoch, real(FROM, dp))
            case%sidereal_angle = sidereal_angle(case%sidereal_angle, real(FROM, dp))
            associate (acts => case%satellite%rods%activations)
                acts%start = acts%start - FROM
                acts%stop = acts%stop - FROM
            end associate
        end associate
        call make_simulator(calibration%case, part)
        wave%phase = wave%phase + TWO_PI*FROM/wave%period
        call observe_without_noise(part, wave, begun)

        if (unmet(error, size(cut%accelerometer_time) == size(begun%accelerometer_time) .and. &
                  size(cut%star_camera_time) == size(begun%star_camera_time), 'samples')) return
        call check(error, all(abs(cut%accelerometer_time - begun%accelerometer_time) < 1e-12_dp) .and. &
                   all(abs(cut%star_camera_time - begun%star_camera_time) < 1e-12_dp), 'time tags')
        call check(error, all(abs(cut%acceleration - begun%acceleration) < 1e-15_dp), 'accelerations')
        call check(error, all(abs(cut%quaternion - begun%quaternion) < 1e-12_dp), 'attitudes')
        n = findloc(cut%magnetometer_time > 0, .true., 1) - 1
        ! 2e-14 T: the field's change in 16 s
        call check(error, n == 3 .and. all(abs(cut%field(:, n + 1:) - begun%field) < 1e-13_dp), 'field')
        n = minloc(abs(cut%orbit_time), 1)
        call check(error, all(abs(cut%orbit_position(:, n:) - begun%orbit_position) < 1e-6_dp), 'orbit')
        call check(error, cut%knowledge%epoch%mjd == begun%knowledge%epoch%mjd .and. &
                   abs(cut%knowledge%epoch%seconds - begun%knowledge%epoch%seconds) < 1e-9_dp .and. &
                   abs(cut%knowledge%sidereal_angle - begun%knowledge%sidereal_angle) < 1e-15_dp .and. &
                   abs(cut%knowledge%duration - begun%knowledge%duration) < 1e-12_dp, 'knowledge')
    end subroutine test_arc

    !> Commanded or measured, a rod's moment at a time of an arc is that of the run, wherever the arc begins, also
    !> between samples and where a wave begins and ends.
    subroutine test_rods(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: FROM(4) = [0.0_dp, 7.3_dp, 12.0_dp, 31.77_dp], LENGTH = 25
        type(torque_rods_t) :: rods, cut
        type(moment_series_t) :: series
        type(error_t), allocatable :: failure
        real(dp) :: t
        integer :: i, k, measured

        call new_torque_rods([rod_activation_t(axis=2, amplitude=10, frequency=0.13_dp, phase=0.4_dp, start=9, stop=33), &
                              rod_activation_t(axis=3, amplitude=7, frequency=0.05_dp, start=30, stop=50, taper=3.0_dp)], &
                             rods, failure)
        if (failed(error, failure)) return
        rods%delay = [0.0_dp, 0.3_dp, 1.7_dp]
        call check(error, moves_rods(rods, 60.0_dp))
        cut = rods
        call begin_rods_at(rods%measured, 55.0_dp, 5.0_dp, cut)
        call check(error, .not. moves_rods(cut, 5.0_dp), 'all is over')
        do measured = 0, 1
            if (measured == 1) then
                call new_moment_series([(0.5_dp*i, i=0, 130)], &
                                       reshape([([0.1_dp*i, 8*sin(0.3_dp*i), cos(0.11_dp*i)], i=0, 130)], [3, 131]), &
                                       series, failure)
                call check_passes(error, failure)
                rods%measured = series
            end if
            do k = 1, size(FROM)
                cut = rods
                call begin_rods_at(rods%measured, FROM(k), LENGTH, cut)
                if (measured == 1 .and. .not. allocated(error)) &
                    call check(error, size(cut%measured%time) < 80, 'samples that the arc does not need')
                do i = 0, 1000
                    t = LENGTH*(i + 0.37_dp)/1001       ! not where a wave jumps
                    call check(error, all(abs(dipole_moment(cut, t) - dipole_moment(rods, FROM(k) + t)) < 1e-10_dp), 'moments')
                end do
            end do
        end do
    end subroutine test_rods

    !> The Earth stands as in the run, on the last day of 1998, too, which had a leap second: UT1 did not jump.
    subroutine test_earth(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: FROM = 7200, T = 33
        type(observation_set_t) :: run, cut
        type(earth_orientation_t) :: earth, of_arc
        type(error_t), allocatable :: failure

        allocate (run%accelerometer_time(0), run%acceleration(3, 0), run%star_camera_time(0), run%star_camera_head(0), &
                  run%quaternion(4, 0), run%magnetometer_time(0), run%field(3, 0))
        associate (knowledge => run%knowledge)
            knowledge%duration = 10000
            knowledge%torque_change = 1
            call parse_utc('1998-12-31T23:00:00', knowledge%epoch, failure)
            knowledge%earth_parameters%ut1_minus_utc = -0.28_dp
            call new_earth_orientation('iau', knowledge%epoch, 0.0_dp, knowledge%earth_parameters, earth, failure)
        end associate
        if (failed(error, failure)) return
        call arc_of_run(run, run%knowledge, FROM, FROM + 100, cut)
        associate (knowledge => cut%knowledge)
            call check(error, knowledge%earth_parameters%ut1_minus_utc, 0.72_dp, thr=1e-12_dp)
            call check(error, knowledge%torque_change(1), 0.01_dp, thr=1e-12_dp)
            call new_earth_orientation('iau', knowledge%epoch, 0.0_dp, knowledge%earth_parameters, of_arc, failure)
        end associate
        ! precession and nutation are those of the epoch: 2e-9 rad in two hours
        call check(error, all(abs(earth%from_inertial(FROM + T) - of_arc%from_inertial(T)) < 1e-8_dp))
    end subroutine test_earth

    !> The chain of arcs of 20 s, which must succeed; is there an error now, so that a test cannot go on?
    logical function chain_fails(error, observations, options, chain)
        type(error_type), allocatable, intent(inout) :: error
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(arc_chain_t), intent(out) :: chain
        type(error_t), allocatable :: failure

        call estimate_chain(observations, options, joint_options_t(), ARC, 2, chain, failure)
        chain_fails = failed(error, failure)
    end function chain_fails

    !> The chain of a run of 60 s is the joint estimate of its three arcs, linearised anew at it; on one thread and on two.
    subroutine test_chain(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations, part
        type(arc_chain_t) :: chain, again
        type(joint_run_t) :: runs(3)
        type(joint_solution_t) :: anew
        type(error_t), allocatable :: failure
        real(dp) :: sigma(3)
        integer :: i

        call open_case(simulator, options)
        call make_observations(simulator, 3, 1, observations)
        if (chain_fails(error, observations, options, chain)) return
        if (unmet(error, size(chain%arcs) == 3 .and. all(chain%arcs%joined) .and. size(chain%solution%runs) == 3)) return
        call check(error, maxval(abs(chain%arcs%to - [20, 40, 60])) + maxval(abs(chain%arcs%from - [0, 20, 40])) < 1e-9_dp)
        do i = 1, 3
            call arc_of_run(observations, observations%knowledge, (i - 1)*ARC, i*ARC, part)
            call run_from_observations(part, options, runs(i), failure)
            if (failed(error, failure)) return
        end do
        if (allocated(error)) return
        call estimate_runs(runs, joint_options_t(), anew, failure)
        call check_passes(error, failure)
        do i = 1, 3
            associate (matrix => runs(i)%information%matrix)
                call check(error, maxval(abs(matrix - chain%arcs(i)%information%matrix)) < 1e-2_dp*maxval(abs(matrix)), &
                           'information')
            end associate
        end do
        if (allocated(error)) return
        sigma = sigmas(anew%covariance)
        call check(error, all(abs(chain%solution%offset - anew%offset) < 0.02_dp*sigma), 'linearised anew')
        call check(error, all(abs(chain%solution%offset - simulator%case%satellite%offset) < 5*sigma) .and. &
                   chain%solution%consistent, 'offset')
        call estimate_chain(observations, options, joint_options_t(), ARC, 1, again, failure)
        call check(error, all(abs(again%solution%offset - chain%solution%offset) <= 0) .and. &
                   all(abs(again%solution%covariance - chain%solution%covariance) <= 0), 'threads')
    end subroutine test_chain

    !> An arc in which the star camera is blind is left out with a warning; the others are joined. An arc without rods
    !> stays in the chain.
    subroutine test_left_out(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(arc_chain_t) :: chain
        type(error_t), allocatable :: failure
        logical, allocatable :: seen(:)

        call open_case(simulator, options)
        call make_observations(simulator, 3, 1, observations)
        associate (acts => observations%knowledge%rods%activations)
            acts%stop = 40          ! the operator knows of no rods in the last arc
        end associate
        ! none was commanded either: the last third of the samples is dropped to be none of a manoeuvre
        seen = .not. (observations%star_camera_time > 40)
        observations%star_camera_head = pack(observations%star_camera_head, seen)
        observations%quaternion = reshape(pack(observations%quaternion, spread(seen, 1, 4)), [4, count(seen)])
        observations%star_camera_time = pack(observations%star_camera_time, seen)
        if (chain_fails(error, observations, options, chain)) return
        if (unmet(error, count(chain%arcs%joined) == 2 .and. .not. chain%arcs(3)%joined .and. &
                  .not. chain%arcs(3)%moves_rods .and. size(chain%solution%runs) == 2)) return
        call check(error, index(chain%warnings(1)%text, 'the arc from 40 to 60 s is left out: ') == 1, chain%warnings(1)%text)
        if (allocated(error)) return
        ! with a manoeuvre in it, one arc of three is too much
        observations%knowledge%rods%activations%stop = 60
        call estimate_chain(observations, options, joint_options_t(), ARC, 2, chain, failure)
        call check_fails(error, failure, '1 of 3 arcs with a manoeuvre are refused ... 40 to 60 s ... star camera')
    end subroutine test_left_out

    !> One arc of twenty, in which accelerometer z shows half of its changes too much, is left out with the reason, and the
    !> offset is that of the others.
    subroutine test_apart(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: SPOILT = 12
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(arc_chain_t) :: chain
        logical, allocatable :: touched(:)
        real(dp) :: mean
        integer :: i

        call open_case(simulator, options, 20*ARC)
        call make_observations(simulator, 3, 1, observations)
        touched = observations%accelerometer_time >= (SPOILT - 1)*ARC .and. observations%accelerometer_time < SPOILT*ARC
        associate (z => observations%acceleration(3, :))
            mean = sum(z, touched)/count(touched)
            where (touched) z = z + 0.5_dp*(z - mean)
        end associate
        if (chain_fails(error, observations, options, chain)) return
        if (unmet(error, size(chain%arcs) == 20 .and. .not. chain%arcs(SPOILT)%joined .and. count(chain%arcs%joined) > 15)) return
        if (unmet(error, any([(index(chain%warnings(i)%text, 'the arc from 220 to 240 s is left out: it disagrees') == 1, &
                               i=1, size(chain%warnings))]), 'the reason')) return
        call check(error, all(abs(chain%solution%offset - case_offset(simulator)) < &
                              5*sigmas(chain%solution%covariance) + 0.02_dp*abs(case_offset(simulator))), &
                   'the offset of the others')      ! the scale factors of the simulation are not those believed
    end subroutine test_apart

    !> An arc in which the light of the Sun goes out within twelve seconds, as an orbit can cross the edge of the Earth's
    !> shadow, is left out for its residuals; those behind it, in the dark, are not.
    subroutine test_shadow(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: DARK = 3
        real(dp), parameter :: LIGHT(3) = [1e-8_dp, -5e-8_dp, -2e-8_dp]     ! m/s^2
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations
        type(arc_chain_t) :: chain
        real(dp) :: part
        integer :: i

        call open_case(simulator, options, 6*ARC)
        call make_observations(simulator, 3, 1, observations)
        do i = 1, size(observations%accelerometer_time)
            part = min(1.0_dp, max(0.0_dp, (observations%accelerometer_time(i) - (DARK - 1)*ARC - 4)/12))
            observations%acceleration(:, i) = observations%acceleration(:, i) - LIGHT*part**2*(3 - 2*part)
        end do
        if (chain_fails(error, observations, options, chain)) return
        call check(error, all(chain%arcs%joined .eqv. [(i /= DARK, i=1, 6)]), 'arcs joined')
        call check(error, any([(index(chain%warnings(i)%text, 'the arc from 40 to 60 s is left out: its residuals') == 1, &
                                i=1, size(chain%warnings))]), 'the reason')
    end subroutine test_shadow

    pure function case_offset(simulator) result(offset)
        type(simulator_t), intent(in) :: simulator
        real(dp) :: offset(3)

        offset = simulator%case%satellite%offset
    end function case_offset

    subroutine test_refused(error)
        type(error_type), allocatable, intent(out) :: error
        type(simulator_t) :: simulator
        type(estimation_options_t) :: options
        type(observation_set_t) :: observations, broken
        type(arc_chain_t) :: chain
        type(error_t), allocatable :: failure

        call open_case(simulator, options)
        call make_observations(simulator, 3, 1, observations)
        call estimate_chain(observations, options, joint_options_t(), 5.0_dp, 1, chain, failure)
        call check_fails(error, failure, 'arcs of 5 s ... 10 s to 1')
        call estimate_chain(observations, options, joint_options_t(), 2000.0_dp, 1, chain, failure)
        call check_fails(error, failure, 'arcs of 2000 s')
        broken = observations
        broken%acceleration(2, 400) = NAN
        call estimate_chain(broken, options, joint_options_t(), ARC, 1, chain, failure)
        call check_fails(error, failure, 'accelerometer ... 40 s ... NaN')
        broken = observations
        broken%knowledge%rods%count = 0
        call estimate_chain(broken, options, joint_options_t(), ARC, 1, chain, failure)
        call check_fails(error, failure, 'all torque rods are off')
        options%largest_offset = 1e-6_dp
        call estimate_chain(observations, options, joint_options_t(), ARC, 1, chain, failure)
        call check_fails(error, failure, 'no arc tells an offset ... 0 to 20 s ... largest_offset_mm')
    end subroutine test_refused
end module test_arc_chain
