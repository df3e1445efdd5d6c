!> The parts of the estimate from Level-1 files: lags of firings, heads together, axes of gyros, joined samples; noise.
module test_level1_parts
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, message_of
    use gracecg_base_text, only: real_text
    use gracecg_base_quaternion, only: rotation_matrix, normalised, quaternion_product, quaternion_from_axis_angle, &
        rotation_between
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_vectors, only: identity, inverse_3x3
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_level1_angular, only: differentiate_attitude
    use gracecg_level1_calibration, only: level1_calibration_t, level1_firing_t
    use gracecg_level1_drive, only: level1_drive_t, new_drive, join_at_steps
    use gracecg_level1_firings, only: accelerometer_lag, gyro_lag
    use gracecg_level1_gyros, only: gyro_axes_t, fit_gyro_axes
    use gracecg_level1_heads, only: combine_heads
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_offset, only: solve_offset
    use gracecg_level1_offset_solution, only: level1_solution_t, source_series_t, consider_t
    use testdrive, only: unittest_type, error_type, new_unittest
    use fixture, only: check, check_fails, check_passes
    use level1_day, only: flaws_t, setup_said, estimate_day, OFFSET
    implicit none
    private
    public :: collect_level1_parts

contains

    subroutine collect_level1_parts(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('lag-of-firings', test_firings), &
                    new_unittest('heads-together', test_heads), &
                    new_unittest('noise-of-angles', test_angle_noise), &
                    new_unittest('noise-that-rises', test_rising_noise), &
                    new_unittest('axes-of-gyros', test_gyro_axes), &
                    new_unittest('steps-between-samples', test_joined)]
    end subroutine collect_level1_parts

    !> Firings at any place between samples, of random sign and strength, in noise and drift: their lags.
    subroutine test_firings(error)
        type(error_type), allocatable, intent(out) :: error

        real(dp), parameter :: LAG = 0.087_dp, BENDS = 0.012_dp, LENGTH = 0.05_dp
        type(level1_firing_t) :: firings(25)
        type(random_stream_t) :: stream
        real(dp) :: lag_found, sigma, strength
        integer :: i, k, n

        stream = new_stream(7_i8, 1, 1, 1, 1)
        do i = 1, size(firings)
            associate (f => firings(i))
                f%time = 100*i + stream%uniform()
                f%duration = LENGTH
                f%sample_time = 100*i + [((k - 30)*0.099991_dp, k=0, 60)]
                n = size(f%sample_time)
                strength = 3e-7_dp*stream%normal()
                allocate (f%linear(3, n), f%gyros(2))
                do k = 1, n
                    f%linear(:, k) = 1e-9_dp*[stream%normal(), stream%normal(), stream%normal()] + &
                        1e-9_dp*(f%sample_time(k) - f%time)
                    ! the share of the sample's interval of 0.1 s
                    f%linear(2, k) = f%linear(2, k) + strength*max(0.0_dp, 0.075_dp - max(0.025_dp, abs(f%sample_time(k) - &
                                                                   f%time - LAG - LENGTH/2)))/0.1_dp
                end do
                f%gyros(1)%time = [real(dp) ::]
                f%gyros(1)%angle = [real(dp) ::]
                f%gyros(2)%time = f%time + [((k - 24)*0.125_dp, k=0, 48)]
                allocate (f%gyros(2)%angle(49))
                do k = 1, 49
                    associate (t => f%gyros(2)%time(k) - f%time)
                        f%gyros(2)%angle(k) = 1e-3_dp*t + 2e-6_dp*t**2 + 1e-7_dp*stream%normal() + &
                            4e-6_dp*max(0.0_dp, t - BENDS - LENGTH/2)
                    end associate
                end do
            end associate
        end do
        call accelerometer_lag(firings, lag_found, sigma)
        call check(error, sigma > 0 .and. sigma < 3e-3_dp .and. abs(lag_found - LAG) < 4*sigma, 'lag of the samples')
        call gyro_lag(firings, [1, 2], lag_found, sigma)
        call check(error, sigma > 0 .and. sigma < 2e-2_dp .and. abs(lag_found - BENDS) < 4*sigma, 'lag of the angles')
        call accelerometer_lag(firings(:5), lag_found, sigma)
        call check(error, .not. sigma > 0, 'too few tell nothing')
        do i = 1, size(firings)
            do k = 1, size(firings(i)%sample_time)
                firings(i)%linear(:, k) = 1e-9_dp*[stream%normal(), stream%normal(), stream%normal()]
            end do
        end do
        call accelerometer_lag(firings, lag_found, sigma)
        call check(error, .not. sigma > 0, 'what does not show tells nothing')
    end subroutine test_firings

    !> Two heads across each other, noisy about their boresights, one of them turned by 1e-3 rad and away half of the
    !> time: together they are as good on every axis as each across its boresight, and nothing jumps.
    subroutine test_heads(error)
        type(error_type), allocatable, intent(out) :: error

        real(dp), parameter :: ACROSS = 1e-5_dp, ABOUT = 1.2e-4_dp, TURNED(3) = [1e-3_dp, -5e-4_dp, 2e-4_dp]
        integer, parameter :: N = 400
        type(random_stream_t) :: stream
        real(dp) :: mounting(4, 2), q(4, 2*N), times(2*N), truth(4, N), e(3), left(3, N), mean(3, 2)
        real(dp), allocatable :: joint_times(:), joint_q(:, :)
        integer :: head(2*N), i, k, records

        stream = new_stream(11_i8, 1, 1, 1, 1)
        mounting(:, 1) = [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
        mounting(:, 2) = quaternion_from_axis_angle([1.0_dp, 0.0_dp, 0.0_dp], TWO_PI/4)
        records = 0
        do i = 1, N
            truth(:, i) = quaternion_from_axis_angle([0.6_dp, 0.0_dp, 0.8_dp], 1e-3_dp*i)
            do k = 1, 2
                if (k == 2 .and. i > N/2) cycle
                records = records + 1
                head(records) = k
                times(records) = 0.5_dp*i
                e = [ACROSS*stream%normal(), ACROSS*stream%normal(), ABOUT*stream%normal()]
                e = matmul(rotation_matrix(mounting(:, k)), e)
                if (k == 2) e = e + TURNED
                q(:, records) = quaternion_product(normalised([e/2, 1.0_dp]), truth(:, i))
            end do
        end do
        call combine_heads(times(:records), head(:records), q(:, :records), mounting, joint_times, joint_q)
        call check(error, size(joint_times), N, 'a time each')
        if (allocated(error)) return
        do i = 1, N
            left(:, i) = rotation_between(truth(:, i), joint_q(:, i))
        end do
        mean(:, 1) = sum(left(:, :N/2), 2)/(N/2)
        mean(:, 2) = sum(left(:, N/2 + 1:), 2)/(N - N/2)
        call check(error, all(abs(mean(:, 1) - mean(:, 2)) < 5*[ACROSS, ACROSS, ABOUT]*sqrt(4.0_dp/N)), 'nothing jumps')
        call check(error, all(sqrt(sum(left(:, :N/2)**2, 2)/(N/2) - mean(:, 1)**2) < 1.3_dp*ACROSS), 'both heads together')
        call check(error, sqrt(sum(left(3, N/2 + 1:)**2)/(N/2)) > 0.7_dp*ABOUT, 'one head alone')
    end subroutine test_heads

    !> Star cameras with noise: their offset is as far off as its sigma says; with more noise there is none, and why is said.
    subroutine test_angle_noise(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: DRAWS = 12
        real(dp), parameter :: SIGMA = 5e-7_dp, WHITE = 3e-10_dp    ! rad, m/s^2
        type(level1_calibration_t) :: calibration, noisy
        type(level1_estimate_t) :: estimate
        type(source_series_t), allocatable :: series(:)
        type(consider_t) :: nothing(0)
        type(level1_solution_t) :: solution
        type(error_t), allocatable :: failure
        type(random_stream_t) :: stream
        real(dp) :: squares, left(3), x(3), covariance(3, 3), condition, factor
        integer :: draw, i, k, axis

        call estimate_day('l1_noise', flaws_t(spans=2), setup_said(), calibration, estimate, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        stream = new_stream(71_i8, 1, 1, 1, 1)
        squares = 0
        do draw = 1, DRAWS + 1
            noisy = calibration
            solution = level1_solution_t(source='sca')
            factor = merge(1, 20, draw <= DRAWS)
            allocate (series(size(noisy%spans)))
            do i = 1, size(noisy%spans)
                associate (span => noisy%spans(i))
                    do axis = 1, 3
                        do k = 1, size(span%angle, 2)
                            span%angle(axis, k) = span%angle(axis, k) + factor*SIGMA*stream%normal()
                        end do
                        do k = 1, size(span%time)
                            span%linear(axis, k) = span%linear(axis, k) + WHITE*stream%normal()
                        end do
                    end do
                    call differentiate_attitude(span, span%attitude_time, span%angle, span%time, series(i)%acceleration, &
                                                series(i)%patterns, series(i)%noise)
                    call check(error, abs(series(i)%noise(1)/(factor*SIGMA) - 1) < 0.35_dp, 'noise of the angles')
                end associate
            end do
            call solve_offset(noisy, estimate%motion, series, nothing, [.true., .true., .true.], 'none', [1e-30_dp, 1e-30_dp], &
                              0.0_dp, solution, failure)
            deallocate (series)
            if (draw > DRAWS) exit
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            left = solution%offset - OFFSET
            call solve_normal_equations(solution%covariance, left, x, covariance, condition, failure)
            squares = squares + dot_product(left, x)/DRAWS
        end do
        call check_fails(error, message_of(failure), [character(60) :: 'the noise of its angles', 'of what would determine d'])
        ! 3 but for chance, 0.7 with 12 draws, and the tails that angles' noise in the columns of d makes
        call check(error, squares > 1.2_dp .and. squares < 6, real_text(squares))
    end subroutine test_angle_noise

    !> Noise whose density in the band rises sixfold: sigma is that at the frequencies of the rods, not the mean of the band's.
    subroutine test_rising_noise(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: DRAWS = 100
        real(dp), parameter :: WHITE = 2.5e-10_dp, DIFFERENCES = 2.6e-9_dp      ! m/s^2
        type(level1_calibration_t) :: calibration, noisy
        type(level1_estimate_t) :: estimate
        type(consider_t) :: nothing(0)
        type(level1_solution_t) :: solution
        type(error_t), allocatable :: failure
        type(random_stream_t) :: stream
        real(dp) :: squares, left(3), x(3), covariance(3, 3), condition, now, before
        integer :: draw, i, k, axis

        call estimate_day('l1_rising', flaws_t(spans=2), setup_said(), calibration, estimate, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        stream = new_stream(72_i8, 1, 1, 1, 1)
        squares = 0
        do draw = 1, DRAWS
            noisy = calibration
            solution = level1_solution_t(source='torque+cal')
            do i = 1, size(noisy%spans)
                do axis = 1, 3
                    before = stream%normal()
                    do k = 1, size(noisy%spans(i)%time)
                        now = stream%normal()
                        noisy%spans(i)%linear(axis, k) = noisy%spans(i)%linear(axis, k) + WHITE*stream%normal() + &
                            DIFFERENCES*(now - before)
                        before = now
                    end do
                end do
            end do
            call solve_offset(noisy, estimate%motion, estimate%solutions(1)%series, nothing, [.true., .true., .true.], 'none', &
                              [1e-30_dp, 1e-30_dp], 0.0_dp, solution, failure)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            left = solution%offset - OFFSET
            call solve_normal_equations(solution%covariance, left, x, covariance, condition, failure)
            squares = squares + dot_product(left, x)/DRAWS
        end do
        ! 3 but for chance, 0.25, and a slope that is not an exponential; 1.25 by the mean of the band
        call check(error, squares > 2 .and. squares < 3.5_dp, real_text(squares))
    end subroutine test_rising_noise

    !> Axes of gyros by star cameras with ten times their noise about x and z: none too small.
    subroutine test_gyro_axes(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: N = 600
        real(dp), parameter :: INTERVAL = 0.2_dp, NOISE = 1e-5_dp, TRUE_AXES(3, 4) = reshape( &
            [0.5_dp, 0.8165_dp, 0.3_dp, -0.4_dp, 0.1_dp, 0.9_dp, 0.6_dp, -0.8165_dp, 0.2_dp, 0.0_dp, 0.0_dp, 0.0_dp], [3, 4])
        type(level1_calibration_t) :: calibration
        type(gyro_axes_t) :: axes
        type(error_t), allocatable :: failure
        type(random_stream_t) :: stream
        real(dp) :: phi(3), time
        integer :: i, k, gyro

        stream = new_stream(72_i8, 1, 1, 1, 1)
        calibration%has_gyros = .true.
        allocate (calibration%spans(1))
        associate (span => calibration%spans(1))
            allocate (span%attitude_time(N), span%angle(3, N), span%gyros(4))
            do gyro = 1, 4
                allocate (span%gyros(gyro)%time(N), span%gyros(gyro)%angle(N))
            end do
            do i = 1, N
                time = i*INTERVAL
                phi = [3e-5_dp, 6e-6_dp, 6e-6_dp]*sin(TWO_PI*[0.1_dp, 0.083_dp, 0.117_dp]*time) + [0.0_dp, 1.1e-3_dp, 0.0_dp]*time
                span%attitude_time(i) = time
                do k = 1, 3
                    span%angle(k, i) = phi(k) + NOISE*stream%normal()
                end do
                do gyro = 1, 4
                    span%gyros(gyro)%time(i) = time
                    span%gyros(gyro)%angle(i) = dot_product(TRUE_AXES(:, gyro), phi)
                end do
            end do
        end associate
        call fit_gyro_axes(calibration, axes, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, axes%known .and. size(axes%gyro) == 3, 'the fourth is off')
        if (allocated(error)) return
        call check(error, maxval(abs(axes%noise/NOISE - 1)) < 0.15_dp, 'noise of the cameras')
        ! sigma of parts along z: 1e-5/(6e-6 sqrt(300)) = 0.1, which regression on the cameras would make half as large
        call check(error, maxval(abs(matmul(axes%axis, inverse_3x3(TRUE_AXES(:, :3))) - identity(3))) < 4*maxval(axes%noise)* &
                   sqrt(maxval([(axes%spread(k, k), k=1, 3)])), 'axes')
        call check(error, abs(sqrt(axes%spread(1, 1)) - 1/(3e-5_dp*sqrt(N/2.0_dp))) < 0.1_dp/(3e-5_dp*sqrt(N/2.0_dp)), 'spread')
    end subroutine test_gyro_axes

    !> A step of held currents between two samples is seen by their mean alone; one within a sample by that.
    subroutine test_joined(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: N = 40
        real(dp), parameter :: LATE = 0.02_dp       ! s
        type(level1_calibration_t) :: calibration
        type(level1_drive_t) :: drive
        integer :: i

        allocate (calibration%spans(1))
        associate (span => calibration%spans(1))
            span%time = [(0.1_dp*i + LATE, i=1, N)]
            span%linear = reshape([(1.0_dp*i**2, 2.0_dp*i, 3.0_dp, i=1, N)], [3, N])
            span%angular = -span%linear
            ! Steps at 0.549, 1.05 s: between 0.5 and 0.6, 1.0 and 1.1; at 1.5 s within a sample; at 2.05 s none
            calibration%current_time = [0.0_dp, 0.549_dp, 1.05_dp, 1.5_dp, 2.05_dp, 9.0_dp]
            calibration%current = reshape([(0.0_dp, 7.0_dp*min(i, 3), 0.0_dp, i=0, 5)], [3, 6])
            call new_drive(calibration, .true., drive)
            call join_at_steps(drive, LATE, 1e-3_dp, calibration)
            call check(error, count(span%joined) == 2 .and. span%joined(5) .and. span%joined(10), 'where')
            call check(error, all(abs(span%linear(:, 5) - [30.5_dp, 11.0_dp, 3.0_dp]) < 1e-12_dp) .and. &
                       all(abs(span%linear(:, 6) - span%linear(:, 5)) < 1e-12_dp) .and. &
                       all(abs(span%angular + span%linear) < 1e-12_dp), 'means')
            call check(error, all(abs(span%linear(1, [4, 7, 15, 16]) - [16, 49, 225, 256]) < 1e-12_dp), 'the others')
            ! Without the sample at 0.6 s that at 0.5 s may have the step or not
            span%time = [((0.1_dp*i + LATE), i=1, 5), (0.1_dp*i + LATE, i=7, N)]
            span%linear = span%linear(:, :N - 1)
            span%angular = -span%linear
            call join_at_steps(drive, LATE, 1e-3_dp, calibration)
            call check(error, size(span%time) == N - 2 .and. all(abs(span%time([4, 5]) - [0.4_dp, 0.7_dp] - LATE) < 1e-9_dp) .and. &
                       span%without_current == 1, 'without its neighbour')
        end associate
    end subroutine test_joined
end module test_level1_parts
