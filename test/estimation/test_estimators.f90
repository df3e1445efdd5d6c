!> The estimators on observations made from their own fitting dynamics, so that the answer is known
!> exactly.
module test_estimators
    use vocabulary
    use calibrations
    use gracecg_base_quaternion, only: normalised, quaternion_product, quaternion_from_axis_angle, &
        rotation_angle_between
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise
    use statistics, only: chi_square_limits
    use gracecg_spacecraft_torque_rods, only: new_harmonic_manoeuvre, new_torque_rods, rod_activation_t, rod_moments, &
        take_measured_moments
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series
    use gracecg_estimation_information, only: squares_of
    use gracecg_estimation_report_options, only: report_options
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_attitude_fit, only: attitude_fit_t, fitted_rotation_t, &
        new_attitude_fit
    use gracecg_estimation_offset_model, only: offset_matrix
    implicit none
    private
    public :: collect_estimators
    public :: example, OFFSET, DRIFT, BIAS, OMEGA_0, Q_0

    real(dp), parameter :: OFFSET(3) = [0.3e-3_dp, 0.4e-3_dp, -0.5e-3_dp]       !! m
    real(dp), parameter :: DRIFT(3) = [1e-11_dp, -3e-11_dp, 2e-11_dp]           !! m/s^3
    real(dp), parameter :: BIAS(3) = [-6e-7_dp, -2.3e-5_dp, 1e-6_dp]            !! m/s^2
    real(dp), parameter :: OMEGA_0(3) = [2e-6_dp, 1.1149e-3_dp, -1e-6_dp]       !! rad/s
    real(dp), parameter :: Q_0(4) = [-0.70085473_dp, -3.1e-6_dp, 0.71330403_dp, 3.1e-6_dp]
    integer, parameter :: RUNS = 100            !! Of a Monte Carlo
    !> CSR-TM-00-01 section 5.2, kg m^2
    real(dp), parameter :: INERTIA(3, 3) = reshape([70.23_dp, -3.0_dp, -2.883_dp, &
                                                    -3.0_dp, 345.14_dp, -0.348_dp, &
                                                    -2.883_dp, -0.348_dp, 388.84_dp], [3, 3])

contains

    subroutine collect_estimators(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('exact-recovery', test_exact), &
                    new_unittest('poor-guesses', test_guesses), &
                    new_unittest('no-scalar-part-and-sign-flips', test_zero_q4), &
                    new_unittest('missing-samples', test_missing_samples), &
                    new_unittest('singular-without-rods', test_singular), &
                    new_unittest('covariance-of-coloured-accelerometer-noise', &
                                 test_accelerometer_noise), &
                    new_unittest('covariance-of-star-camera-noise', test_star_noise), &
                    new_unittest('measured-moments-stand-in', test_measured_moments), &
                    new_unittest('known-angular-velocity', test_known_rate), &
                    new_unittest('unknown-attitude', test_unknown_attitude), &
                    new_unittest('refusals-go-through', test_refusals)]
    end subroutine collect_estimators

    !> A minute without noise. The fitting dynamics are driven by the interpolated field itself, and
    !> the quaternions are free of interpolation when the star camera is as fast as the
    !> accelerometer.
    subroutine example(observations, interval, star_camera_interval, quaternion)
        type(observation_set_t), intent(out) :: observations
        real(dp), intent(in), optional :: interval                  !! Of the accelerometer, s
        real(dp), intent(in), optional :: star_camera_interval      !! s
        real(dp), intent(in), optional :: quaternion(4)             !! At the epoch
        type(error_t), allocatable :: failure
        integer :: i

        associate (knowledge => observations%knowledge)
            knowledge%duration = 60
            knowledge%mass = 420
            knowledge%inertia = INERTIA
            knowledge%accelerometer_interval = 0.1_dp
            if (present(interval)) knowledge%accelerometer_interval = interval
            knowledge%star_camera_interval = knowledge%accelerometer_interval
            if (present(star_camera_interval)) knowledge%star_camera_interval = star_camera_interval
            knowledge%magnetometer_interval = 1
            knowledge%mounting(:, 1) = quaternion_from_axis_angle([1.0_dp, 0.0_dp, 0.0_dp], -2.356_dp)
            knowledge%mounting(:, 2) = quaternion_from_axis_angle([1.0_dp, 0.0_dp, 0.0_dp], -3.927_dp)
            knowledge%accelerometer_noise%level = 1e-20_dp
            knowledge%star_camera_sigma = 1*ARCSECOND
            call new_harmonic_manoeuvre([0, 1, 1], 30.0_dp, 0.1_dp, 0.0_dp, 60.0_dp, knowledge%rods, failure)
            call need(failure)
            observations%accelerometer_time = [(i*knowledge%accelerometer_interval, &
                                                i=1, nint(60/knowledge%accelerometer_interval))]
            observations%star_camera_time = [(i*knowledge%star_camera_interval, &
                                              i=1, nint(60/knowledge%star_camera_interval))]
        end associate
        observations%magnetometer_time = [(1.0_dp*i, i=1, 60)]
        allocate (observations%field(3, 60))
        do i = 1, 60
            observations%field(:, i) = 1e-9_dp*[25000 + 30*i, 4000 - 15*i, -9000 + 20*i]
        end do
        observations%star_camera_head = [(1, i=1, size(observations%star_camera_time))]
        if (present(quaternion)) then
            call fill(observations, normalised(quaternion))
        else
            call fill(observations, normalised(Q_0))
        end if
    end subroutine example

    !> Accelerations and quaternions along the fitting dynamics.
    subroutine fill(observations, quaternion)
        type(observation_set_t), intent(inout) :: observations
        real(dp), intent(in) :: quaternion(4)       !! At the epoch
        type(fitting_data_t) :: data
        type(attitude_fit_t) :: fit
        type(fitted_rotation_t) :: rotation
        type(error_t), allocatable :: failure
        real(dp) :: t
        integer :: i, k

        observations%quaternion = spread([0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], 2, &
                                         size(observations%star_camera_time))
        observations%acceleration = spread([0.0_dp, 0.0_dp, 0.0_dp], 2, &
                                           size(observations%accelerometer_time))
        call preprocess(observations, estimation_options_t(), data, failure)        ! for the torque
        call need(failure)
        fit = new_attitude_fit(observations%knowledge%inertia, data%interval, data%torque)
        call fit%integrate(quaternion, OMEGA_0, rotation)
        do i = 1, size(observations%accelerometer_time)
            t = observations%accelerometer_time(i)
            observations%acceleration(:, i) = &
                matmul(offset_matrix(rotation%omega(:, i), rotation%omega_dot(:, i)), OFFSET) + &
                DRIFT*t + BIAS
        end do
        do i = 1, size(observations%star_camera_time)
            k = nint(observations%star_camera_time(i)/data%interval)
            observations%quaternion(:, i) = quaternion_product(observations%knowledge%mounting(:, 1), &
                                                               normalised(rotation%q(:, k)))
        end do
    end subroutine fill

    !> Estimates with every algorithm, and compares with what went in.
    subroutine recover(observations, offset_tolerance, error, quaternion, options)
        type(observation_set_t), intent(in) :: observations
        real(dp), intent(in) :: offset_tolerance        !! m
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in), optional :: quaternion(4)
        type(estimation_options_t), intent(in), optional :: options
        type(estimation_options_t) :: own
        type(solution_t) :: solution
        real(dp) :: q(4)
        integer :: i

        q = normalised(Q_0)
        if (present(quaternion)) q = quaternion
        if (present(options)) own = options
        own%covariance = .false.
        own%sequential%estimate_within_limits = .false.     ! the instruments are exact, too
        do i = 1, size(ESTIMATOR_NAMES)
            if (estimate_fails(error, trim(ESTIMATOR_NAMES(i)), observations, own, solution)) return
            call check(error, solution%converged, ESTIMATOR_NAMES(i))
            call check_recovered(solution, offset_tolerance, q, error)
        end do
    end subroutine recover

    !> The rotation makes an acceleration of some 1e-5 m/s^2 of an offset of 1 m, hence the
    !> tolerances of bias and drift.
    subroutine check_recovered(solution, offset_tolerance, quaternion, error)
        type(solution_t), intent(in) :: solution
        real(dp), intent(in) :: offset_tolerance        !! m
        real(dp), intent(in) :: quaternion(4)
        type(error_type), allocatable, intent(inout) :: error

        call check(error, norm2(solution%offset - OFFSET), 0.0_dp, 'offset', solution%algorithm, &
                   thr=offset_tolerance)
        call check(error, norm2(solution%bias - BIAS), 0.0_dp, 'bias', solution%algorithm, &
                   thr=1e-5_dp*offset_tolerance)
        call check(error, norm2(solution%drift - DRIFT), 0.0_dp, 'drift', solution%algorithm, &
                   thr=1e-5_dp*offset_tolerance/60)
        call check(error, norm2(solution%angular_velocity - OMEGA_0), 0.0_dp, 'angular velocity', &
                   solution%algorithm, thr=1e-8_dp)
        call check(error, rotation_angle_between(solution%quaternion, quaternion), 0.0_dp, &
                   'attitude', solution%algorithm, thr=1e-6_dp)
        call check(error, maxval(solution%residual_rms), 0.0_dp, 'residuals', solution%algorithm, &
                   thr=1e-15_dp)
    end subroutine check_recovered

    !> From the guess that the samples give, and from the report's initial guess: the nominal trajectory
    !> (4-45), then d, drift and bias from (4-80)-(4-82) or together. Interpolation of quaternions
    !> every 0.5 s costs less than a nanometre. Weights do not matter without noise.
    subroutine test_exact(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(estimation_options_t) :: options

        call example(observations)
        call recover(observations, 1e-11_dp, error)
        call recover(observations, 1e-11_dp, error, options=report_options('front-1'))
        call example(observations, star_camera_interval=0.5_dp)
        call recover(observations, 1e-9_dp, error)
        call example(observations, interval=0.2_dp)
        options%accelerometer_weight = [1e20_dp, 1e18_dp, 3e20_dp]
        options%star_camera_weight = 1e10_dp
        call recover(observations, 1e-11_dp, error, options=options)
    end subroutine test_exact

    !> Section 4.6: with the angular velocity from other means ASSEST needs no star camera. What its error does to
    !> the offset is found by trying; the covariance must say the same.
    subroutine test_known_rate(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SIGMAS(3) = [1e-6_dp, 2e-6_dp, 0.5e-6_dp], NONE(3) = 1e-12_dp    ! rad/s
        type(observation_set_t) :: observations, altered
        type(solution_t) :: sure, unsure, moved
        type(error_t), allocatable :: failure
        real(dp) :: expected(3, 3), by_rate(3)
        integer :: axis, i

        call example(observations)
        call leave_out_stars(observations)
        observations%knowledge%angular_velocity = OMEGA_0
        do i = 1, 2
            call estimate(REPORT_ESTIMATORS(i), OMEGA_0, NONE, sure)
            if (allocated(error)) return
            call check(error, all(abs(sure%offset - OFFSET) < 1e-11_dp) .and. sure%converged, 'offset')
            call check(error, all(abs(sure%quaternion) <= 0) .and. size(sure%warnings) == 2, 'attitude, and '// &
                       'what could not be tested')
            if (.not. allocated(error)) call estimate(REPORT_ESTIMATORS(i), OMEGA_0, SIGMAS, unsure)
            expected = 0
            do axis = 1, 3
                call estimate(REPORT_ESTIMATORS(i), OMEGA_0 + 0.01_dp*SIGMAS*unit_of(axis), NONE, moved)
                by_rate = 100*(moved%offset - sure%offset)
                expected = expected + spread(by_rate, 2, 3)*spread(by_rate, 1, 3)
            end do
            call check(error, all(abs(unsure%covariance - sure%covariance - expected) < &
                                  0.01_dp*sqrt(expected(1, 1)*expected(2, 2))), 'covariance')
        end do

    contains

        subroutine estimate(algorithm, value, sigma, solution)
            character(*), intent(in) :: algorithm
            real(dp), intent(in) :: value(3), sigma(3)
            type(solution_t), intent(out) :: solution

            altered = observations
            altered%knowledge%angular_velocity = value
            altered%knowledge%angular_velocity_sigma = sigma
            call estimate_offset(algorithm, altered, estimation_options_t(), solution, failure)
            call check_passes(error, failure)
        end subroutine estimate

        pure function unit_of(axis) result(e)
            integer, intent(in) :: axis
            real(dp) :: e(3)

            e = 0
            e(axis) = 1
        end function unit_of
    end subroutine test_known_rate

    !> Without a star camera: ASSEST is refused unless the angular velocity is known, the others always.
    subroutine test_unknown_attitude(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        integer :: i

        call example(observations)
        call leave_out_stars(observations)
        do i = 1, size(ESTIMATOR_NAMES)
            observations%knowledge%angular_velocity_sigma = 0
            call estimate_refused(error, ESTIMATOR_NAMES(i), observations, 'star camera ... no angular velocity in the setup')
            if (i <= 2) cycle
            observations%knowledge%angular_velocity_sigma = 1e-6_dp
            call estimate_refused(error, ESTIMATOR_NAMES(i), observations, 'star camera ... assest-rde alone')
        end do
    end subroutine test_unknown_attitude

    subroutine leave_out_stars(observations)
        type(observation_set_t), intent(inout) :: observations

        observations%star_camera_time = observations%star_camera_time(:0)
        observations%star_camera_head = observations%star_camera_head(:0)
        observations%quaternion = observations%quaternion(:, :0)
    end subroutine leave_out_stars

    !> Attitude 60 deg off about any axis, angular velocity off by 5e-3 rad/s, offset from nothing
    !> and from a decimetre: corrections as in (4-75), (4-79), (4-103) come to the truth.
    subroutine test_guesses(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(estimation_options_t) :: options
        real(dp) :: axis(3)
        integer :: i

        call example(observations, interval=0.2_dp)
        do i = 1, 6
            axis = unit([cos(0.7_dp*i), sin(1.3_dp*i), cos(2.1_dp*i + 0.3_dp)])
            options%guess_quaternion = &
                quaternion_product(quaternion_from_axis_angle(axis, TWO_PI/6), normalised(Q_0))
            options%guess_angular_velocity = OMEGA_0 + 5e-3_dp*axis
            options%guess_offset = 0.1_dp*(i - 1)*axis
            call recover(observations, 1e-11_dp, error, options=options)
        end do
    end subroutine test_guesses

    !> q4 = 0 at the epoch, and a guess with the other sign of q4; samples with either sign.
    subroutine test_zero_q4(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: Q(4) = [-0.8_dp, 0.0_dp, 0.6_dp, 0.0_dp]
        type(observation_set_t) :: observations
        type(estimation_options_t) :: options
        integer :: i

        call example(observations, interval=0.2_dp, quaternion=Q)
        call recover(observations, 1e-11_dp, error, Q)
        options%guess_quaternion = normalised([-0.79_dp, 0.0_dp, 0.6_dp, -1e-3_dp])
        call recover(observations, 1e-11_dp, error, Q, options)
        options%guess_quaternion = -Q
        call recover(observations, 1e-11_dp, error, Q, options)
        call example(observations, interval=0.2_dp)
        do i = 1, size(observations%quaternion, 2)
            if (mod(i*i, 7) < 3) observations%quaternion(:, i) = -observations%quaternion(:, i)
        end do
        call recover(observations, 1e-11_dp, error)
    end subroutine test_zero_q4

    !> Every seventh accelerometer sample and ten seconds of them, and five seconds of the star
    !> camera.
    subroutine test_missing_samples(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        integer, allocatable :: kept(:)
        integer :: i

        call example(observations, interval=0.2_dp)
        kept = pack([(i, i=1, 300)], [(mod(i, 7) /= 0 .and. (i < 100 .or. i > 150), i=1, 300)])
        observations%accelerometer_time = observations%accelerometer_time(kept)
        observations%acceleration = observations%acceleration(:, kept)
        kept = pack([(i, i=1, 300)], [(i < 200 .or. i > 225, i=1, 300)])
        observations%star_camera_time = observations%star_camera_time(kept)
        observations%star_camera_head = observations%star_camera_head(kept)
        observations%quaternion = observations%quaternion(:, kept)
        call recover(observations, 1e-11_dp, error)
    end subroutine test_missing_samples

    !> Without torque a principal-axes satellite in a steady turn about y shows d_x, d_z only as
    !> part of the bias, and d_y not at all.
    subroutine test_singular(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(error_t), allocatable :: failure
        type(rod_activation_t) :: none(0)
        integer :: i

        call example(observations, interval=0.2_dp)
        call new_torque_rods(none, observations%knowledge%rods, failure)
        if (failed(error, failure)) return
        do i = 1, 3
            observations%knowledge%inertia(:i - 1, i) = 0
            observations%knowledge%inertia(i + 1:, i) = 0
        end do
        call fill(observations, normalised(Q_0))
        do i = 1, size(REPORT_ESTIMATORS)
            call estimate_refused(error, REPORT_ESTIMATORS(i), observations, 'AS ... singular ... d_')
        end do
    end subroutine test_singular

    !> Normalised error squared of all runs: chi-square with three degrees of freedom a run if the
    !> covariance is that of the errors (99.9 % limits). The noise is coloured, the weights are not
    !> its inverse.
    subroutine test_accelerometer_noise(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: clean
        type(random_stream_t) :: stream

        call example(clean, interval=0.5_dp)
        clean%knowledge%accelerometer_noise%level = [1e-20_dp, 1e-18_dp, 1e-20_dp]
        clean%knowledge%accelerometer_noise%corner = [0.005_dp, 0.1_dp, 0.005_dp]
        clean%knowledge%star_camera_sigma = 0
        stream = new_stream(20, 1, 1, 1, 1)
        call check_normalised_errors(error, clean, draw)

    contains

        subroutine draw(observations)
            type(observation_set_t), intent(inout) :: observations
            type(coloured_noise_t) :: noise
            type(error_t), allocatable :: failure
            real(dp) :: samples(size(clean%acceleration, 2))
            integer :: axis

            observations = clean
            do axis = 1, 3
                noise = coloured_noise(clean%knowledge%accelerometer_noise(axis), &
                                       clean%knowledge%accelerometer_interval, failure)
                call noise%generate(stream, samples)
                observations%acceleration(axis, :) = clean%acceleration(axis, :) + samples
            end do
        end subroutine draw
    end subroutine test_accelerometer_noise

    !> The same for noise of the star camera about its three axes, every 1 s: five
    !> pseudo-observations of the fit share each pair of samples.
    subroutine test_star_noise(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SIGMA(3) = [5e-5_dp, 5e-5_dp, 2e-4_dp]      !! rad
        type(observation_set_t) :: clean
        type(random_stream_t) :: stream

        call example(clean, interval=0.2_dp, star_camera_interval=1.0_dp)
        clean%knowledge%accelerometer_noise%level = 0
        clean%knowledge%star_camera_sigma = SIGMA
        stream = new_stream(20, 1, 1, 1, 4)
        call check_normalised_errors(error, clean, draw)

    contains

        subroutine draw(observations)
            type(observation_set_t), intent(inout) :: observations
            real(dp) :: turn(3)
            integer :: i

            observations = clean
            do i = 1, size(clean%quaternion, 2)
                call stream%normals(turn)
                turn = SIGMA*turn
                observations%quaternion(:, i) = quaternion_product( &
                                                quaternion_from_axis_angle(unit(turn), &
                                                    norm2(turn)), &
                                                clean%quaternion(:, i))
            end do
        end subroutine draw
    end subroutine test_star_noise

    !> Errors of every algorithm about its estimate without noise (interpolation may shift it)
    !> against its covariance.
    subroutine check_normalised_errors(error, clean, draw)
        type(error_type), allocatable, intent(inout) :: error
        type(observation_set_t), intent(in) :: clean
        interface
            subroutine draw(observations)
                import :: observation_set_t
                type(observation_set_t), intent(inout) :: observations
            end subroutine draw
        end interface

        type(observation_set_t) :: observations
        type(solution_t) :: reference, solution
        real(dp) :: total, limits(2)
        character(80) :: found
        integer :: run, i

        limits = chi_square_limits(3*RUNS)
        do i = 1, size(REPORT_ESTIMATORS)
            if (estimate_fails(error, trim(REPORT_ESTIMATORS(i)), clean, estimation_options_t(), reference)) return
            total = 0
            do run = 1, RUNS
                call draw(observations)
                if (estimate_fails(error, trim(REPORT_ESTIMATORS(i)), observations, &
                                   estimation_options_t(covariance=.false.), solution)) return
                total = total + squares_of(solution%offset - reference%offset, reference%covariance)
            end do
            write (found, '(2a, f9.2, a, 2f9.2)') REPORT_ESTIMATORS(i), ': chi-square', total, &
                ', limits', limits
            call check(error, total > limits(1) .and. total < limits(2), trim(found))
        end do
    end subroutine check_normalised_errors

    subroutine test_refusals(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(estimation_options_t) :: options

        call example(observations, interval=0.5_dp)
        observations%accelerometer_time(7) = observations%accelerometer_time(6)
        call estimate_refused(error, 'assest-fde', observations, 'must increase')
        call example(observations, interval=0.5_dp)
        options%guess_angular_velocity = NAN
        call estimate_refused(error, 'assest-fde', observations, 'guess_angular_velocity ... not a finite number', options)
        call estimate_refused(error, 'optimal', observation_set_t(), 'accelerometer_time ... allocated')
    end subroutine test_refusals

    !> Measured samples of the sine give what the sine itself gives: within the interpolation's error h^4/384 of the
    !> fourth derivative, that is of (2 pi 0.1 h)^4/384 of the moment. And they are used: twice the moments give half
    !> the offset, which only the report's estimators do not refuse.
    subroutine test_measured_moments(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SPACING(2) = [0.1_dp, 1.0_dp]
        type(observation_set_t) :: commanded, measured
        type(solution_t) :: expected, solution
        type(error_t), allocatable :: failure
        type(estimation_options_t) :: options
        integer :: i, k

        call example(commanded, star_camera_interval=0.5_dp)
        options%covariance = .false.
        do i = 1, size(ESTIMATOR_NAMES)
            call estimate_offset(trim(ESTIMATOR_NAMES(i)), commanded, options, expected, failure)
            call check_passes(error, failure)
            do k = 1, size(SPACING)
                call measure(SPACING(k), 1.0_dp)
                if (allocated(error)) return
                if (estimate_fails(error, trim(ESTIMATOR_NAMES(i)), measured, options, solution)) return
                call check(error, norm2(solution%offset - expected%offset) < &
                           2*(0.1_dp*TWO_PI*SPACING(k))**4/384*norm2(OFFSET), trim(ESTIMATOR_NAMES(i)))
            end do
        end do
        call measure(0.1_dp, 2.0_dp)
        call estimate_offset('assest-fde', measured, options, solution, failure)
        call check_passes(error, failure)
        call check(error, norm2(solution%offset - expected%offset/2) < 0.1_dp*norm2(OFFSET), 'twice the moments')

    contains

        subroutine measure(spacing, factor)
            real(dp), intent(in) :: spacing, factor
            type(moment_series_t) :: series
            real(dp), allocatable :: time(:), moment(:, :)
            integer :: j

            time = [(j*spacing, j=0, nint(60/spacing))]
            allocate (moment(3, size(time)))
            do j = 1, size(time)
                moment(:, j) = factor*rod_moments(commanded%knowledge%rods, time(j))
            end do
            call new_moment_series(time, moment, series, failure)
            call check_passes(error, failure)
            measured = commanded
            call take_measured_moments(series, measured%knowledge%rods)
            measured%knowledge%rods%activations%amplitude = 0      ! nothing of them is used
        end subroutine measure
    end subroutine test_measured_moments
end module test_estimators
