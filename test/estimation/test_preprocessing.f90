!> Preprocessing: the report's interpolation formulae, sign flips, mounting, gaps, refusals.
module test_preprocessing
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_positive_inf
    use vocabulary
    use calibrations
    use gracecg_base_constants, only: SOLAR_RADIUS, WGS84_SEMI_MAJOR_AXIS
    use gracecg_base_quaternion, only: normalised, quaternion_product, quaternion_from_axis_angle
    use gracecg_spacecraft_torque_rods, only: new_harmonic_manoeuvre
    use gracecg_observations_observation_set, only: SAMPLE_TOLERANCE, check_observations
    use gracecg_environment_sun, only: sun_position, edge_of_shadow
    use gracecg_environment_time, only: utc_t, parse_utc, julian_centuries_tt
    use gracecg_estimation_fitting_data
    implicit none
    private
    public :: collect_preprocessing

    real(dp), parameter :: MOUNTING(4) = [0.6_dp, 0.0_dp, 0.0_dp, 0.8_dp]

contains

    subroutine collect_preprocessing(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('quaternions-as-printed', test_quaternions), &
                    new_unittest('torque-as-printed', test_torque), &
                    new_unittest('mounting-is-undone', test_mounting), &
                    new_unittest('one-lost-frame-is-bridged-and-the-last-kept', test_bridge), &
                    new_unittest('star-camera-gap-is-not-bridged', test_gap), &
                    new_unittest('times-are-refused', test_times), &
                    new_unittest('values-are-refused', test_values), &
                    new_unittest('too-few-samples-and-gaps-are-refused', test_too_few), &
                    new_unittest('stuck-magnetometer-has-a-gap', test_stuck_magnetometer), &
                    new_unittest('inconsistent-sizes-and-impossible-setups-are-refused', test_sizes), &
                    new_unittest('the-edge-of-the-shadow', test_shadow)]
    end subroutine collect_preprocessing

    !> A minute of curves that no interpolation reproduces; body attitudes (4, 120) beside it.
    subroutine example(observations, attitudes)
        type(observation_set_t), intent(out) :: observations
        real(dp), intent(out), optional :: attitudes(4, 120)
        real(dp) :: attitude(4)
        type(error_t), allocatable :: failure
        integer :: i

        associate (knowledge => observations%knowledge)
            knowledge%duration = 60
            knowledge%mass = 420
            knowledge%inertia = reshape([70.0_dp, -3.0_dp, 0.0_dp, -3.0_dp, 345.0_dp, 0.0_dp, &
                                     0.0_dp, 0.0_dp, 389.0_dp], [3, 3])
            knowledge%mounting(:, 1) = MOUNTING
            knowledge%mounting(:, 2) = [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
            call new_harmonic_manoeuvre([0, -1, 1], 30.0_dp, 0.1_dp, 0.0_dp, 60.0_dp, knowledge%rods, failure)
        end associate
        call need(failure)
        observations%accelerometer_time = [(0.1_dp*i, i=1, 600)]
        observations%acceleration = reshape([(1e-6_dp*cos(0.37_dp*i), i=1, 1800)], [3, 600])
        observations%magnetometer_time = [(1.0_dp*i, i=1, 60)]
        observations%field = reshape([(3e-5_dp*sin(0.11_dp*i**2), i=1, 180)], [3, 60])
        observations%star_camera_time = [(0.5_dp*i, i=1, 120)]
        observations%star_camera_head = [(1, i=1, 120)]
        allocate (observations%quaternion(4, 120))
        do i = 1, 120
            attitude = quaternion_product(quaternion_from_axis_angle(unit([1.0_dp, cos(0.1_dp*i), 0.3_dp]), &
                                                                     0.02_dp*i + 0.1_dp*sin(0.9_dp*i)), &
                                          normalised([-0.7_dp, 0.1_dp, 0.7_dp, 0.1_dp]))
            observations%quaternion(:, i) = quaternion_product(MOUNTING, attitude)
            if (present(attitudes)) attitudes(:, i) = attitude
        end do
    end subroutine example

    !> Preprocesses, which must succeed; is there an error now, so that a test cannot go on?
    logical function preprocess_fails(error, observations, data)
        type(error_type), allocatable, intent(inout) :: error
        type(observation_set_t), intent(in) :: observations
        type(fitting_data_t), intent(out) :: data
        type(error_t), allocatable :: failure

        call preprocess(observations, estimation_options_t(), data, failure)
        preprocess_fails = failed(error, failure)
    end function preprocess_fails

    !> Formulae (4-38), (4-40), (4-42) with k = int(t/0.5) + 1, then (4-44). They are written for
    !> t(k) = 0.5 k. (At a sample two of them meet, so rounding of t does not matter.)
    subroutine test_quaternions(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(fitting_data_t) :: data
        real(dp) :: q(4, 120), expected(4), t
        integer :: i, k

        call example(observations, q)
        if (preprocess_fails(error, observations, data)) return
        if (unmet(error, size(data%attitude_epoch), 600)) return
        do i = 1, 600
            call check(error, data%attitude_epoch(i), i)
            t = 0.1_dp*i
            k = floor(t/0.5_dp) + 1
            if (k == 1) then
                expected = q(:, 1) - 2*(q(:, 2) - q(:, 1))*(0.5_dp - t)
            else if (k < 121) then
                expected = q(:, k - 1) + 2*(q(:, k) - q(:, k - 1))*(t - 0.5_dp*(k - 1))
            else
                expected = q(:, 120)
            end if
            expected = expected/norm2(expected)
            call check(error, maxval(abs(data%quaternion(:, i) - expected)), 0.0_dp, thr=1e-14_dp)
        end do
    end subroutine test_quaternions

    !> m x B at every half step, B after (4-39), (4-41), (4-43) with k = int(t) + 1.
    subroutine test_torque(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(fitting_data_t) :: data
        real(dp) :: field(3), moment(3), t
        integer :: j, k

        call example(observations)
        if (preprocess_fails(error, observations, data)) return
        if (unmet(error, size(data%torque, 2), 1201)) return
        do j = 0, 1200
            t = 0.05_dp*j
            k = floor(t) + 1
            associate (b => observations%field)
                if (k == 1) then
                    field = b(:, 1) - (b(:, 2) - b(:, 1))*(1 - t)
                else if (k < 61) then
                    field = b(:, k - 1) + (b(:, k) - b(:, k - 1))*(t - k + 1)
                else
                    field = b(:, 60)
                end if
            end associate
            moment = [0, -1, 1]*30*sin(TWO_PI*0.1_dp*t)
            call check(error, maxval(abs(data%torque(:, j + 1) - cross(moment, field))), 0.0_dp, &
                       thr=1e-16_dp)
        end do
    end subroutine test_torque

    !> Quaternions in body axes (4-33), of unit length (4-37).
    subroutine test_mounting(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(fitting_data_t) :: data
        real(dp) :: q(4, 120)

        call example(observations, q)
        if (preprocess_fails(error, observations, data)) return
        call check(error, maxval(abs(data%stars%quaternion - q)), 0.0_dp, thr=1e-15_dp)
        observations%quaternion = (1 + 0.9_dp*SAMPLE_TOLERANCE)*observations%quaternion
        if (preprocess_fails(error, observations, data)) return
        call check(error, maxval(abs(data%stars%quaternion - q)), 0.0_dp, thr=1e-15_dp)
    end subroutine test_mounting

    !> Without some star-camera samples.
    subroutine drop_stars(observations, keep)
        type(observation_set_t), intent(inout) :: observations
        logical, intent(in) :: keep(:)
        integer :: i

        observations%quaternion = observations%quaternion(:, pack([(i, i=1, size(keep))], keep))
        observations%star_camera_time = pack(observations%star_camera_time, keep)
        observations%star_camera_head = pack(observations%star_camera_head, keep)
    end subroutine drop_stars

    !> Without the sample at 10 s, the straight line from 9.5 s to 10.5 s.
    !> After the last sample, at 50 s, its value is kept for one interval and no longer.
    subroutine test_bridge(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(fitting_data_t) :: data
        real(dp) :: q(4, 120)

        call example(observations, q)
        call drop_stars(observations, abs(observations%star_camera_time - 10) > 0.01_dp)
        if (preprocess_fails(error, observations, data)) return
        if (unmet(error, size(data%attitude_epoch), 600)) return
        call check(error, maxval(abs(data%quaternion(:, 98) - &
                                     normalised(0.7_dp*q(:, 19) + 0.3_dp*q(:, 21)))), 0.0_dp, &
                   thr=1e-14_dp)
        call example(observations, q)
        call drop_stars(observations, observations%star_camera_time < 50.1_dp)
        if (preprocess_fails(error, observations, data)) return
        call check(error, maxval(data%attitude_epoch), 505)
        call check(error, maxval(abs(data%quaternion(:, 503) - q(:, 100))), 0.0_dp, thr=1e-15_dp)
    end subroutine test_bridge

    !> Six lost frames: no pseudo-observation between 20 s and 23 s, all others there and unchanged.
    subroutine test_gap(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(fitting_data_t) :: whole, data
        type(error_t), allocatable :: failure
        integer :: i, k

        call example(observations)
        call preprocess(observations, estimation_options_t(), whole, failure)
        call drop_stars(observations, abs(observations%star_camera_time - 21.5_dp) > 1.4_dp)
        if (preprocess_fails(error, observations, data)) return
        call check(error, .not. any(data%attitude_epoch > 200 .and. data%attitude_epoch < 230))
        call check(error, all([(any(data%attitude_epoch == k), k=1, 199)]) .and. &
                   all([(any(data%attitude_epoch == k), k=231, 600)]))
        if (unmet(error, size(data%quaternion, 2) == size(data%attitude_epoch) .and. &
                  size(data%attitude_source) == size(data%attitude_epoch))) return
        do i = 1, size(data%attitude_epoch)
            k = data%attitude_epoch(i)
            if (k == 230) cycle     ! the first one after the gap
            call check(error, maxval(abs(data%quaternion(:, i) - whole%quaternion(:, k))), 0.0_dp)
        end do
    end subroutine test_gap

    subroutine test_times(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: good, bad
        integer :: i

        call example(good)
        bad = good
        bad%accelerometer_time(300:301) = [30.1_dp, 30.0_dp]
        call refused(bad, good, 'accelerometer ... must increase ... 30 s follows 30.1 s', error)
        bad%accelerometer_time(301) = bad%accelerometer_time(300)
        call refused(bad, good, 'accelerometer ... must increase ... 30 s follows 30 s with another value', error)
        bad%accelerometer_time(300:) = bad%accelerometer_time(300:) - 1
        call refused(bad, good, 'accelerometer ... must increase ... 29 s follows 29.9 s', error)
        bad%magnetometer_time(7) = 6
        call refused(bad, good, 'magnetometer ... must increase ... 6 s follows 6 s with another value', error)
        bad%magnetometer_time(7) = 5.5_dp
        call refused(bad, good, 'magnetometer ... must increase ... 5.5 s follows 6 s', error)
        bad%accelerometer_time(7) = 0.6001_dp
        call refused(bad, good, 'accelerometer ... two samples near 0.6001 s', error)
        bad%star_camera_time(7) = 2
        call refused(bad, good, 'star camera 1 ... must increase', error)
        bad%star_camera_time(9) = bad%star_camera_time(8)
        call refused(bad, good, 'star camera 1 ... 4 s follows 4 s with another value', error)
        bad%star_camera_head(9:10) = 2
        bad%star_camera_time(10) = bad%star_camera_time(9)
        call refused(bad, good, 'star camera 2 ... 4.5 s follows 4.5 s with another value', error)
        bad%accelerometer_time(300) = 30.03_dp
        call refused(bad, good, 'accelerometer ... 30.03 s ... not a multiple ... 0.1 s', error)
        bad%accelerometer_time(600) = 60.1_dp
        call refused(bad, good, 'accelerometer ... 60.1 s ... outside ... 60 s', error)
        bad%accelerometer_time(1) = -0.1_dp
        call refused(bad, good, 'accelerometer ... -0.1 s ... outside', error)
        bad%star_camera_time(4) = NAN
        call refused(bad, good, 'star camera ... NaN', error)
        bad%accelerometer_time(3) = NAN
        call refused(bad, good, 'accelerometer ... time tag 3 ... NaN', error)
        bad%orbit_time = [(1.0_dp*i, i=0, 60)]
        bad%orbit_time(30:) = bad%orbit_time(30:) - 1.5_dp
        bad%orbit_position = spread([7e6_dp, 0.0_dp, 0.0_dp], 2, 61)
        call refused(bad, good, 'orbit ... must increase ... 27.5 s follows 28 s', error)
    end subroutine test_times

    subroutine test_values(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: good, bad

        call example(good)
        bad = good
        bad%acceleration(2, 17) = NAN
        call refused(bad, good, 'accelerometer ... at 1.7 s ... NaN ... leave it out', error)
        bad%field(1, 60) = NAN
        call refused(bad, good, 'magnetometer ... at 60 s ... NaN', error)
        bad%field(3, 17) = ieee_value(1.0_dp, ieee_positive_inf)
        call refused(bad, good, 'magnetometer ... infinite', error)
        bad%field = 1e9_dp*bad%field
        call refused(bad, good, 'magnetometer ... have to be in T', error)
        bad%acceleration(2, 17) = 1e300_dp
        call refused(bad, good, 'accelerometer ... have to be in m/s^2', error)
        bad%quaternion(1, 17) = NAN
        call refused(bad, good, 'star camera 1 ... at 8.5 s ... NaN', error)
        bad%quaternion(:, 17) = 1.01_dp*bad%quaternion(:, 17)
        call refused(bad, good, 'star camera ... unit length', error)
        bad%quaternion(:, 17) = 0
        call refused(bad, good, 'star camera ... unit length', error)
    end subroutine test_values

    subroutine test_too_few(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: good, bad
        integer :: i

        call example(good)
        bad = good
        bad%acceleration = bad%acceleration(:, :1)
        bad%accelerometer_time = bad%accelerometer_time(:1)
        call refused(bad, good, 'accelerometer ... fewer than two', error)
        bad%field = bad%field(:, :0)
        bad%magnetometer_time = bad%magnetometer_time(:0)
        call refused(bad, good, 'magnetometer ... fewer than two', error)
        call drop_stars(bad, [(i <= 1, i=1, 120)])
        call refused(bad, good, 'star camera ... fewer than two', error)
        call drop_stars(bad, [(i == 20 .or. i == 70, i=1, 120)])
        call refused(bad, good, 'star camera ... too few', error)
        bad%knowledge%camera = 3
        call refused(bad, good, 'star camera ... head 3', error)
        bad%magnetometer_time = pack(good%magnetometer_time, abs(good%magnetometer_time - 31) > 2.5_dp)
        bad%field = good%field(:, nint(bad%magnetometer_time))
        call refused(bad, good, 'magnetometer ... no samples near 28', error)
        bad%magnetometer_time = good%magnetometer_time(:50)
        bad%field = good%field(:, :50)
        call refused(bad, good, 'magnetometer ... no samples near 51', error)
        bad%magnetometer_time = good%magnetometer_time(5:)
        bad%field = good%field(:, 5:)
        call refused(bad, good, 'magnetometer ... no samples near 0 s', error)
    end subroutine test_too_few

    !> A magnetometer that keeps its value for 4 s has a gap there; 3 s pass.
    subroutine test_stuck_magnetometer(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: good, bad
        type(fitting_data_t) :: data
        type(error_t), allocatable :: failure

        call example(good)
        bad = good
        bad%field(:, 31:33) = spread(good%field(:, 30), 2, 3)
        call preprocess(bad, estimation_options_t(), data, failure)
        call check_passes(error, failure)
        if (unmet(error, size(data%warnings), 0)) return
        bad%field(:, 34) = good%field(:, 30)
        call refused(bad, good, 'magnetometer ... no samples near 30 ... repetitions of one value', error)
        bad%field(:, 31:) = spread(good%field(:, 30), 2, 30)
        call refused(bad, good, 'magnetometer ... no samples near 31 ... repetitions of one value', error)
    end subroutine test_stuck_magnetometer

    subroutine test_sizes(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: good, bad

        call example(good)
        bad = good
        bad%acceleration = bad%acceleration(:, :599)
        call refused(bad, good, 'accelerometer ... 600 ... 599', error)
        bad%field = bad%field(:, :59)
        call refused(bad, good, 'magnetometer ... 60 ... 59', error)
        bad%quaternion = bad%quaternion(:, :119)
        call refused(bad, good, 'star camera ... 120 ... 119', error)
        bad%star_camera_head = bad%star_camera_head(:119)
        call refused(bad, good, 'star camera ... 120 ... 119', error)
        deallocate (bad%field)
        call refused(bad, good, 'not all of magnetometer_time, field are allocated', error)
        deallocate (bad%quaternion)
        call refused(bad, good, 'not all of star_camera_time, star_camera_head, quaternion are', error)
        bad%knowledge%duration = 0
        call refused(bad, good, 'duration', error)
        bad%knowledge%duration = NAN
        call refused(bad, good, 'duration', error)
        bad%knowledge%accelerometer_interval = 0
        call refused(bad, good, 'sampling intervals ... positive', error)
        bad%knowledge%inertia = 0
        call refused(bad, good, 'inertia ... positive definite', error)
        bad%knowledge%inertia(1, 2) = 5
        call refused(bad, good, 'inertia ... symmetric', error)
        bad%knowledge%inertia(3, 3) = 800
        call refused(bad, good, 'inertia ... sum of the two others', error)
    end subroutine test_sizes

    !> Preprocessing must fail with a message that has every one of the parts; then the observations are good again.
    subroutine refused(bad, good, parts, error)
        type(observation_set_t), intent(inout) :: bad
        type(observation_set_t), intent(in) :: good
        character(*), intent(in) :: parts
        type(error_type), allocatable, intent(inout) :: error
        type(fitting_data_t) :: data
        type(error_t), allocatable :: failure

        if (index(parts, 'no samples near') == 0 .and. index(parts, 'too few') == 0) then   ! those an estimate alone finds
            call check_observations(bad, failure)
            call check_fails(error, failure, parts)
        end if
        call preprocess(bad, estimation_options_t(), data, failure)
        call check_fails(error, failure, parts)
        bad = good
    end subroutine refused

    !> A flight across the edge of the shadow, 7000 km behind the Earth, where the penumbra is wider than the Earth by the angle
    !> of half the Sun and the Earth's radius at its distance; and one in full light.
    subroutine test_shadow(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: BEHIND = 7e6_dp, SPEED = 5e3_dp, INSIDE = 1e5_dp    ! m, m/s
        real(dp), allocatable :: time(:), position(:, :)        ! s, m
        type(utc_t) :: epoch
        type(error_t), allocatable :: failure
        real(dp) :: sun(3), across(3), centuries, reached
        integer :: i

        call parse_utc('1989-01-02T00:00:00', epoch, failure)
        centuries = julian_centuries_tt(epoch)
        sun = sun_position(centuries)
        across = unit(cross(sun, [0.0_dp, 0.0_dp, 1.0_dp]))
        time = [(real(i, dp), i=-5, 65)]
        allocate (position(3, size(time)))
        do i = 1, size(time)
            position(:, i) = -BEHIND*unit(sun) + (WGS84_SEMI_MAJOR_AXIS - INSIDE + SPEED*time(i))*across
        end do
        reached = (INSIDE + BEHIND*(SOLAR_RADIUS + WGS84_SEMI_MAJOR_AXIS)/norm2(sun))/SPEED
        call check(error, edge_of_shadow(centuries, time, position, 60.0_dp) - reached, 0.5_dp, thr=0.6_dp)
        call check(error, edge_of_shadow(centuries, time, position, reached - 2) >= 0, 'ends in the penumbra')
        position = -position
        call check(error, edge_of_shadow(centuries, time, position, 60.0_dp) < 0)
        call check(error, edge_of_shadow(centuries, time(:0), position(:, :0), 60.0_dp) < 0)
    end subroutine test_shadow
end module test_preprocessing
