!> The parts of the estimate from Level-1 files: heads together, axes of gyros, steps of held currents.
module test_level1_parts
    use vocabulary
    use gracecg_base_text, only: real_text
    use gracecg_base_quaternion, only: rotation_matrix, normalised, quaternion_product, quaternion_from_axis_angle, &
        rotation_between
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_gyros, only: gyro_axes_t, fit_gyro_axes
    use gracecg_level1_attitude_reading, only: combine_heads
    use gracecg_level1_series, only: find_strays
    use gracecg_level1_held_currents, only: find_steps, rod_accelerations
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_spacecraft_moment_series, only: new_moment_series
    use gracecg_spacecraft_torque_rods, only: take_measured_moments, torque_rods_t
    use gracecg_spacecraft_moment_series, only: moment_series_t
    use gracecg_level1_along_orbit, only: compare_axis
    implicit none
    private
    public :: collect_level1_parts

contains

    subroutine collect_level1_parts(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('air-and-light-of-an-axis', test_axis), &
                    new_unittest('strays', test_strays), &
                    new_unittest('heads-together', test_heads), &
                    new_unittest('axes-of-gyros', test_gyro_axes), &
                    new_unittest('steps-of-currents', test_steps)]
    end subroutine collect_level1_parts

    !> Spikes are found, each of several and next to nothing else; steps, noise and a rapid line are none.
    subroutine test_strays(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 300
        type(random_stream_t) :: stream
        real(dp) :: times(N), values(2, N)
        logical :: stray(N)
        integer :: i

        stream = new_stream(3_i8, 1, 1, 1, 1)
        do i = 1, N
            times(i) = 0.5_dp*i + merge(7.0_dp, 0.0_dp, i > 200)
            values(:, i) = [sin(TWO_PI*times(i)/4), 1e-3_dp*times(i)**2] + 0.01_dp*[stream%normal(), stream%normal()]
        end do
        values(2, 120:) = values(2, 120:) + 50      ! a step
        stray = find_strays(times, values, 0.01_dp)
        if (unmet(error, count(stray), 0, 'none')) return
        values(1, [40, 43, 250]) = values(1, [40, 43, 250]) + [100, -30, 1000000]
        values(2, 77) = values(2, 77) - 20
        stray = find_strays(times, values, 0.01_dp)
        if (unmet(error, count(stray) == 4 .and. all(stray([40, 43, 77, 250])), 'the four')) return
        values(1, 150:151) = values(1, 150:151) + [30, 25]
        values(2, 270:271) = values(2, 270:271) + [40, -40]
        stray = find_strays(times, values, 0.01_dp)
        call check(error, count(stray) == 8 .and. all(stray([150, 151, 270, 271])), 'side by side, too')
    end subroutine test_strays

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
        if (unmet(error, size(joint_times), N, 'a time each')) return
        do i = 1, N
            left(:, i) = rotation_between(truth(:, i), joint_q(:, i))
        end do
        mean(:, 1) = sum(left(:, :N/2), 2)/(N/2)
        mean(:, 2) = sum(left(:, N/2 + 1:), 2)/(N - N/2)
        call check(error, all(abs(mean(:, 1) - mean(:, 2)) < 5*[ACROSS, ACROSS, ABOUT]*sqrt(4.0_dp/N)), 'nothing jumps')
        call check(error, all(sqrt(sum(left(:, :N/2)**2, 2)/(N/2) - mean(:, 1)**2) < 1.3_dp*ACROSS), 'both heads together')
        call check(error, sqrt(sum(left(3, N/2 + 1:)**2)/(N/2)) > 0.7_dp*ABOUT, 'one head alone')
    end subroutine test_heads

    !> Axes of gyros by star cameras with more noise than the satellite turns about y and z: none too small. Cameras with twice
    !> as much do not tell them.
    subroutine test_gyro_axes(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 600
        real(dp), parameter :: INTERVAL = 0.2_dp, NOISE = 8e-7_dp, TURN = 5e-7_dp, TRUE_AXES(3, 4) = reshape( &
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
                phi = [5*TURN, TURN, TURN]*sin(TWO_PI*[0.1_dp, 0.083_dp, 0.117_dp]*time) + [0.0_dp, 1.1e-3_dp, 0.0_dp]*time
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
        if (failed(error, failure)) return
        if (unmet(error, axes%known .and. size(axes%gyro) == 3, 'the fourth is off')) return
        ! sigma of parts along z: 0.09; regression on the cameras would make them half as large
        call check(error, maxval(abs(matmul(axes%axis, inverse_3x3(TRUE_AXES(:, :3))) - identity(3))) < &
                   4*NOISE/(TURN*sqrt(N/2.0_dp)), 'axes')
        associate (angle => calibration%spans(1)%angle)
            angle(3, :) = angle(3, :) + NOISE*[(3*mod(i, 2), i=1, N)]
        end associate
        call fit_gyro_axes(calibration, axes, failure)
        if (failed(error, failure)) return
        call check(error, .not. axes%known, 'cameras that do not tell')
    end subroutine test_gyro_axes

    !> Angular channels with bias and noise show currents that are held, and how late, to a quarter of a sample; those of
    !> smooth ones show none.
    subroutine test_steps(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: LATE = 0.137_dp, NOISE = 5e-8_dp, TAG = 0.5_dp, INTERVAL = 0.099991_dp
        integer, parameter :: SAMPLES = 600, TAGS = 130
        type(observation_set_t) :: arcs(1)
        type(moment_series_t) :: moments
        type(torque_rods_t) :: truth
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: share, delay
        integer :: i, k

        stream = new_stream(73_i8, 1, 1, 1, 1)
        associate (set => arcs(1))
            set%knowledge%inertia = reshape([70.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, 345.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, 388.0_dp], [3, 3])
            set%magnetometer_time = [(real(k, dp), k=-5, 70)]
            set%field = spread([2e-5_dp, -1e-5_dp, 3e-5_dp], 2, size(set%magnetometer_time))
            set%accelerometer_time = [((k - 1)*INTERVAL, k=1, SAMPLES)]
            allocate (set%acceleration(3, SAMPLES), set%angular_acceleration(3, SAMPLES), source=0.0_dp)
            do i = 1, 2
                call new_moment_series([((k - 5)*TAG, k=1, TAGS)], &
                                       reshape([(30*sin(TWO_PI*[0.083_dp, 0.1_dp, 0.117_dp]*(k - 5)*TAG), k=1, TAGS)], [3, TAGS]), &
                                       moments, failure, held=i == 1)
                if (failed(error, failure)) return
                call take_measured_moments(moments, truth)
                set%knowledge%rods = truth
                truth%delay = LATE
                set%angular_acceleration = rod_accelerations(set, truth, set%accelerometer_time, .true.)
                do k = 1, SAMPLES
                    set%angular_acceleration(:, k) = set%angular_acceleration(:, k) + &
                        [7e-4_dp, -1e-5_dp, 1e-4_dp] + NOISE*[stream%normal(), stream%normal(), stream%normal()]
                end do
                call find_steps(arcs, share, delay)
                if (i == 1) then
                    call check(error, abs(share - 1) < 0.05_dp .and. abs(delay - LATE) < 0.025_dp, 'held: '// &
                               real_text(share)//' '//real_text(delay))
                else
                    call check(error, share < 0.1_dp, 'smooth')
                end if
            end do
        end associate
    end subroutine test_steps

    !> An axis that shows air and light has the sign that they have; one that shows a wave of 2e-9 m/s^2 a revolution, which is
    !> neither, has none, whatever its phase: a simulator of another project has no light, and its days were refused.
    subroutine test_axis(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: MINUTES = 100, PHASES = 24
        real(dp), parameter :: REVOLUTION = 94          ! min
        real(dp) :: times(MINUTES), phase(MINUTES), air(MINUTES), light(MINUTES), density, seen(2)
        integer :: follows, i

        times = [(60.0_dp*i, i=1, MINUTES)]
        phase = TWO_PI*times/(60*REVOLUTION)
        air = 3e-8_dp*(sin(phase + 0.4_dp) + 0.3_dp*cos(2*phase))
        light = merge(1e-8_dp*cos(phase), 0.0_dp, cos(phase - 0.3_dp) > -0.4_dp)
        do i = -1, 1, 2
            density = -1
            call compare_axis(times, i*(0.6_dp*air + 1.7_dp*light), air, light, density, follows, seen)
            call check(error, follows == i .and. abs(seen(1) - 1.7_dp) < 0.01_dp, 'air and light')
        end do
        do i = 1, PHASES
            density = -1
            call compare_axis(times, 2e-9_dp*sin(phase + i*TWO_PI/PHASES), air, light, density, follows, seen)
            call check(error, follows, 0)
            call check(error, .not. (seen(1) > 0.05_dp .and. seen(1) > 5*seen(2)), 'light')
        end do
    end subroutine test_axis
end module test_level1_parts
