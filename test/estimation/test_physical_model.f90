!> The physical calibration model: partials of every parameter against differences, torques against the
!> dynamics of the simulation, conservation of angular momentum.
module test_physical_model
    use vocabulary
    use calibrations
    use gracecg_base_vectors, only: cross_matrix
    use gracecg_base_quaternion, only: normalised, rotation_matrix
    use gracecg_spacecraft_gravity_gradient_torque, only: gravity_gradient_torque
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series
    use gracecg_spacecraft_torque_rods, only: take_measured_moments
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_observations_parameters
    use gracecg_estimation_physical_model, only: physical_model_t, model_state_t, model_trajectory_t, &
        prepare_model, integrate_trajectory, predict_accelerations, predict_channels, star_angles, turned_by, &
        turn_between, correct_state
    use gracecg_estimation_torque_shapes, only: take_moments
    use test_estimators, only: example, OMEGA_0, Q_0
    implicit none
    private
    public :: collect_physical_model, add_orbit

    real(dp), parameter :: STAR_TIMES(4) = [0.26_dp, 17.0_dp, 33.33_dp, 59.9_dp]    ! s; steps of 0.2 s
    integer, parameter :: STAR_HEADS(4) = [2, 1, 2, 1]
contains

    subroutine collect_physical_model(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('partials-of-every-parameter-against-differences', test_partials), &
                    new_unittest('gravity-gradient-torque-is-that-of-the-dynamics', test_gravity_torque), &
                    new_unittest('turns-and-rotation-vectors-are-inverse', test_turns), &
                    new_unittest('no-orbit-no-gravity-gradient', test_no_orbit), &
                    new_unittest('rates-of-moments-at-any-interval', test_moment_rates)]
    end subroutine collect_physical_model

    !> A circular orbit that the satellite of the example follows, every 5 s.
    subroutine add_orbit(observations)
        type(observation_set_t), intent(inout) :: observations
        real(dp), parameter :: RADIUS = 6838e3_dp, MOTION = 1.117e-3_dp
        integer :: i

        observations%orbit_time = [(5.0_dp*i, i=0, 12)]
        allocate (observations%orbit_position(3, 13))
        do i = 1, 13
            associate (angle => MOTION*observations%orbit_time(i))
                observations%orbit_position(:, i) = RADIUS*[cos(angle), 0.1_dp*sin(angle), sin(angle)]
            end associate
        end do
    end subroutine add_orbit

    subroutine prepare(model, data, with_orbit)
        type(physical_model_t), intent(out) :: model
        type(fitting_data_t), intent(out) :: data
        logical, intent(in) :: with_orbit
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure
        integer :: i

        call example(observations, interval=0.2_dp)
        if (with_orbit) call add_orbit(observations)
        call preprocess(observations, estimation_options_t(), data, failure)
        call need(failure)
        call prepare_model(observations%knowledge, data, [(i, i=1, PARAMETERS)], model)
        model%wave_frequency = 1/13.0_dp
        model%jump = model%steps/3
        if (allocated(model%light)) model%light(:) = 0.7_dp     ! the Sun is seen, though it is not there
    end subroutine prepare

    !> A state in which no parameter is zero that is not an error of a belief in proportion to which all acts.
    function general_state() result(state)
        type(model_state_t) :: state

        state%quaternion = normalised(Q_0)
        state%value(RATE) = OMEGA_0
        state%value(TORQUE) = [1e-5_dp, -2e-5_dp, 3e-5_dp]
        state%value(OFFSET) = [0.3e-3_dp, 0.4e-3_dp, -0.5e-3_dp]
        state%value(DRIFT) = [1e-10_dp, -2e-10_dp, 3e-10_dp]
        state%value(BIAS) = [-6e-7_dp, -2.3e-5_dp, 1e-6_dp]
        state%value(SCALE_FACTORS) = [0.0101_dp, -0.0159_dp, -0.0119_dp]
        state%value(ROD_GAIN) = 0.02_dp
        state%value(FIELD_BIAS) = [50e-9_dp, -30e-9_dp, 25e-9_dp]
        state%value(DRAG_CURVATURE) = 2e-8_dp
        state%value(WAVE_SINE) = 1e-8_dp
        state%value(WAVE_COSINE) = -3e-8_dp
        state%value(WAVE_FREQUENCY) = 0.002_dp
        state%value(WAVE_GROWTH) = 0.2_dp
        state%value(INERTIA) = [0.1_dp, -0.2_dp, 0.3_dp, 0.1_dp, -0.1_dp, 0.2_dp]
        state%value(TORQUE_CHANGE) = [-1e-6_dp, 2e-6_dp, 1e-6_dp]
        state%value(FORCE_JUMP) = [2e-9_dp, -1e-8_dp, 3e-9_dp]
    end function general_state

    !> What a change of a parameter to measure its effect may be, SI units: a thousandth of its typical size, if the effect is
    !> far above the rounding of what is shown.
    pure real(dp) function step_of(parameter) result(step)
        integer, intent(in) :: parameter        !! Its place

        step = sum(typical_sizes([parameter], 60.0_dp))/1000
        if (any([ATTITUDE_ANGLES, TORQUE, FIELD_BIAS] == parameter)) step = 100*step
    end function step_of

    !> Each kind of parameter (but those of further accelerometers, which the example has not) shows in some instrument, as its
    !> partials say.
    subroutine test_partials(error)
        type(error_type), allocatable, intent(out) :: error
        type(physical_model_t) :: model
        type(model_state_t) :: state, changed
        type(model_trajectory_t) :: trajectory, other
        type(fitting_data_t) :: data
        real(dp), allocatable :: partials(:, :, :), predicted(:, :, :), of_channels(:, :, :), shown(:, :, :)
        real(dp) :: star_partials(PARAMETERS, 3, size(STAR_TIMES)), angles(3, size(STAR_TIMES), 2)
        real(dp) :: change(PARAMETERS), effect(PARAMETERS)
        integer :: p, i, side, n

        effect = 0
        call prepare(model, data, .true.)
        state = general_state()
        n = size(data%accelerometer_epoch)
        allocate (partials(PARAMETERS, 3, n), predicted(3, n, 2), of_channels(PARAMETERS, 3, n), shown(3, n, 2))
        call integrate_trajectory(model, state, trajectory)
        call predict_accelerations(model, state, trajectory, data%accelerometer_epoch, predicted(:, :, 1), partials)
        call predict_channels(model, state, trajectory, data%accelerometer_epoch, shown(:, :, 1), of_channels)
        do i = 1, size(STAR_TIMES)
            call star_angles(model, state, trajectory, STAR_TIMES(i), STAR_HEADS(i), trajectory%q(:, nint(STAR_TIMES(i)/0.2_dp)), &
                             angles(:, i, 1), star_partials(:, :, i))
        end do
        do p = 1, PARAMETERS
            do side = 1, 2
                change = 0
                change(p) = merge(step_of(p), -step_of(p), side == 1)
                changed = state
                call correct_state(model, change, changed)
                call integrate_trajectory(model, changed, other)
                call predict_accelerations(model, changed, other, data%accelerometer_epoch, predicted(:, :, side))
                call predict_channels(model, changed, other, data%accelerometer_epoch, shown(:, :, side))
                do i = 1, size(STAR_TIMES)          ! computed minus nominal
                    call star_angles(model, changed, other, STAR_TIMES(i), STAR_HEADS(i), &
                                     trajectory%q(:, nint(STAR_TIMES(i)/0.2_dp)), angles(:, i, side))
                end do
            end do
            predicted(:, :, 1) = (predicted(:, :, 1) - predicted(:, :, 2))/(2*step_of(p))
            call check_close(partials(p, :, :), predicted(:, :, 1), 2e-6_dp, ', accelerometer')
            shown(:, :, 1) = (shown(:, :, 1) - shown(:, :, 2))/(2*step_of(p))
            call check_close(of_channels(p, :, :), shown(:, :, 1), 2e-5_dp, ', angular channels')
            angles(:, :, 1) = -(angles(:, :, 1) - angles(:, :, 2))/(2*step_of(p))
            call check_close(star_partials(p, :, :), angles(:, :, 1), 2e-4_dp, ', star camera')
        end do
        do p = 1, PARAMETERS
            call check(error, effect(KIND_OF(p)) > 0 .or. any([LINE_SCALES, LINE_BIAS, LINE_DRIFT] == p), &
                       trim(parameter_names(p))//' shows in nothing')
        end do

    contains

        !> Within a tolerance of the greatest value; nothing where there must be nothing.
        subroutine check_close(found, expected, tolerance, which)
            real(dp), intent(in) :: found(:, :), expected(:, :), tolerance
            character(*), intent(in) :: which

            effect(KIND_OF(p)) = max(effect(KIND_OF(p)), maxval(abs(expected)))
            call check(error, maxval(abs(found - expected)) <= tolerance*maxval(abs(expected)), &
                       trim(parameter_names(p))//which)
        end subroutine check_close
    end subroutine test_partials

    !> At the epoch, without rods: J d omega/dt + omega x J omega is the simulation's torque (2-23).
    subroutine test_gravity_torque(error)
        type(error_type), allocatable, intent(out) :: error
        type(physical_model_t) :: model
        type(model_state_t) :: state
        type(model_trajectory_t) :: trajectory
        type(fitting_data_t) :: data
        real(dp) :: torque(3), expected(3), r

        call prepare(model, data, .true.)
        model%magnetic_torque = 0
        state%quaternion = normalised([0.3_dp, -0.5_dp, 0.2_dp, 0.7_dp])
        state%value(RATE) = OMEGA_0
        call integrate_trajectory(model, state, trajectory)
        torque = matmul(model%inertia, trajectory%omega_dot(:, 0)) + &
                 cross(OMEGA_0, matmul(model%inertia, OMEGA_0))
        r = norm2(data%orbit_position(:, 1))
        expected = gravity_gradient_torque(EARTH_GM, r, matmul(rotation_matrix(state%quaternion), &
                                                               data%orbit_position(:, 1)/r), model%inertia)
        call check(error, norm2(expected) > 1e-5_dp)
        call check(error, norm2(torque - expected) < 1e-12_dp*norm2(expected))
    end subroutine test_gravity_torque

    subroutine test_turns(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: q(4), zeta(3), turned(3, 3)
        integer :: i

        q = normalised(Q_0)
        do i = 0, 10
            zeta = 0.25_dp*i*[0.6_dp, -0.64_dp, 0.48_dp]
            call check(error, maxval(abs(turn_between(q, turned_by(zeta, q)) - zeta)) < 1e-14_dp)
            call check(error, maxval(abs(turn_between(q, -turned_by(zeta, q)) - zeta)) < 1e-14_dp, 'sign')
        end do
        zeta = 1e-5_dp*[1, -2, 3]
        turned = matmul(identity(3) - cross_matrix(zeta), rotation_matrix(q))
        call check(error, maxval(abs(rotation_matrix(turned_by(zeta, q)) - turned)) < 1e-9_dp, 'C(zeta) R(q)')
    end subroutine test_turns

    subroutine test_no_orbit(error)
        type(error_type), allocatable, intent(out) :: error
        type(physical_model_t) :: model
        type(fitting_data_t) :: data
        integer :: before

        call prepare(model, data, .true.)
        before = size(data%warnings)
        call check(error, all(model%rate_squared > 1.2e-6_dp .and. model%rate_squared < 1.3e-6_dp))
        call prepare(model, data, .false.)
        call check(error, all(abs(model%rate_squared) <= 0))
        if (unmet(error, size(data%warnings) == before + 1)) return
        call check_says(error, data%warnings(size(data%warnings))%text, 'no orbit')
    end subroutine test_no_orbit

    !> Moments of 0.1 Hz, known every half second: their rates, by which rods leak, are those of the sine within 0.1 % of the
    !> largest one, at samples of 0.1 s and at means of 1 s.
    subroutine test_moment_rates(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: RATE = TWO_PI*0.1_dp, INTERVALS(2) = [0.1_dp, 1.0_dp], LENGTH = 60
        type(operator_knowledge_t) :: knowledge
        type(moment_series_t) :: series
        type(physical_model_t) :: model
        type(error_t), allocatable :: failure
        real(dp) :: times(-10:130)
        integer :: i, k

        times = [(k/2.0_dp, k=-10, 130)]
        call new_moment_series(times, spread(sin(RATE*times), 1, 3), series, failure)
        call need(failure)
        call take_measured_moments(series, knowledge%rods)
        do i = 1, size(INTERVALS)
            model = physical_model_t(steps=nint(LENGTH/INTERVALS(i)), interval=INTERVALS(i), estimated=[LEAKAGE_RATE(1)])
            call take_moments(knowledge, fitting_data_t(), model)
            do k = 0, model%steps
                call check(error, all(abs(model%moment_rate(:, k) - RATE*cos(RATE*k*INTERVALS(i))) < 1e-3_dp*RATE), 'rate')
            end do
        end do
    end subroutine test_moment_rates
end module test_physical_model
