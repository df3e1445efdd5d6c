!> The magnetometer: bias, noise, range and resolution.
module test_magnetometer
    use vocabulary
    use gracecg_simulation_magnetometer, only: magnetometer_t
    use statistics, only: Z_999, mean, variance, correlation
    implicit none
    private
    public :: collect_magnetometer

    integer, parameter :: N = 20000
    real(dp), parameter :: FIELD(3) = [28e-6_dp, -3e-6_dp, 12e-6_dp]    !! T

contains

    subroutine collect_magnetometer(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('bias-and-noise', test_noise), &
                    new_unittest('range-limit', test_range), &
                    new_unittest('resolution', test_resolution), &
                    new_unittest('rejects-bad-settings', test_settings), &
                    new_unittest('linearity', test_linearity), &
                    new_unittest('bandwidth', test_bandwidth)]
    end subroutine collect_magnetometer

    !> The departure from the straight line is odd, 0 in the middle and at the ends of the range, and at most the
    !> stated one, which it has at range/sqrt(3).
    subroutine test_linearity(error)
        type(error_type), allocatable, intent(out) :: error
        type(magnetometer_t) :: magnetometer
        real(dp) :: off(3), greatest
        integer :: i

        magnetometer%linearity = 25e-9_dp
        magnetometer%bias = 0
        off = magnetometer%response([0.0_dp, 50e-6_dp, -50e-6_dp]) - [0.0_dp, 50e-6_dp, -50e-6_dp]
        call check(error, maxval(abs(off)) < 1e-19_dp)
        greatest = 0
        do i = -1000, 1000
            off = magnetometer%response([1.0_dp, -1.0_dp, 0.5_dp]*i*50e-9_dp) - [1.0_dp, -1.0_dp, 0.5_dp]*i*50e-9_dp
            greatest = max(greatest, maxval(abs(off)))
            call check(error, off(1) + off(2), 0.0_dp, thr=1e-19_dp)
        end do
        call check(error, greatest, 25e-9_dp, thr=1e-5_dp, rel=.true.)
        off = magnetometer%response(spread(50e-6_dp/sqrt(3.0_dp), 1, 3)) - 50e-6_dp/sqrt(3.0_dp)
        call check(error, off(1), 25e-9_dp, thr=1e-10_dp, rel=.true.)
    end subroutine test_linearity

    !> Behind a low-pass filter of 4.5 Hz a ramp comes 1/(2 pi 4.5) s late and a sine of frequency f with the gain
    !> 1/sqrt[1 + (f/4.5)^2]; without one the field is as it was.
    subroutine test_bandwidth(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: SAMPLES = 20000
        real(dp), parameter :: STEP = 1e-3_dp, PI = acos(-1.0_dp)
        type(magnetometer_t) :: magnetometer
        real(dp) :: ramp(3, SAMPLES), wave(3, SAMPLES), seen(3, SAMPLES)
        integer :: i

        do i = 1, SAMPLES
            ramp(:, i) = FIELD + [1e-7_dp, -2e-7_dp, 3e-7_dp]*i*STEP
            wave(:, i) = 1e-5_dp*sin(2*PI*[1.0_dp, 4.5_dp, 20.0_dp]*i*STEP)
        end do
        seen = magnetometer%passed(ramp, STEP)
        call check(error, all(abs(seen - ramp) <= 0))
        magnetometer%bandwidth = 4.5_dp
        seen = magnetometer%passed(ramp, STEP)
        call check(error, maxval(abs(ramp - seen - spread([1e-7_dp, -2e-7_dp, 3e-7_dp]/(2*PI*4.5_dp), 2, SAMPLES))) < &
                   1e-18_dp)
        seen = magnetometer%passed(wave, STEP)
        do i = 1, 3
            associate (f => [1.0_dp, 4.5_dp, 20.0_dp])
                call check(error, sqrt(sum(seen(i, 10001:)**2)/sum(wave(i, 10001:)**2)), &
                           1/sqrt(1 + (f(i)/4.5_dp)**2), thr=2e-3_dp, rel=.true.)
            end associate
        end do
    end subroutine test_bandwidth

    subroutine take_samples(magnetometer, measured)
        type(magnetometer_t), intent(in) :: magnetometer
        real(dp), intent(out) :: measured(3, N)
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure

        stream = new_stream(31, 0, 0, 0, 0)
        call magnetometer%measure(spread(FIELD, 2, N), stream, measured, failure)
        call need(failure)
    end subroutine take_samples

    !> Bias [50, -30, 25] nT and 3 nT noise: CSR-TM-00-01 eq. (3-23), section 5.2.
    subroutine test_noise(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: BIAS(3) = [50e-9_dp, -30e-9_dp, 25e-9_dp], NOISE = 3e-9_dp
        type(magnetometer_t) :: magnetometer
        real(dp) :: measured(3, N)
        integer :: i

        call take_samples(magnetometer, measured)
        do i = 1, 3
            call check(error, mean(measured(i, :)) - FIELD(i), BIAS(i), &
                       thr=Z_999*NOISE/sqrt(real(N, dp)))
            call check(error, variance(measured(i, :))/NOISE**2, 1.0_dp, thr=Z_999*sqrt(2.0_dp/N))
            call check(error, abs(correlation(measured(i, :), measured(1 + mod(i, 3), :))) &
                       < Z_999/sqrt(real(N, dp)))
        end do
    end subroutine test_noise

    subroutine test_range(error)
        type(error_type), allocatable, intent(out) :: error
        type(magnetometer_t) :: magnetometer
        real(dp) :: measured(3, N)

        magnetometer%limited = .true.
        magnetometer%range = 20e-6_dp
        magnetometer%bias(2) = -1e-3_dp
        call take_samples(magnetometer, measured)
        call check(error, all(measured(1, :) == 20e-6_dp) .and. all(measured(2, :) == -20e-6_dp))
        call check(error, variance(measured(3, :)) > 0)
    end subroutine test_range

    !> Samples are multiples of the step, and half a step at most off where the noise (five sigma)
    !> alone would put them.
    subroutine test_resolution(error)
        type(error_type), allocatable, intent(out) :: error
        type(magnetometer_t) :: magnetometer
        real(dp) :: measured(3, N), steps(3, N)

        magnetometer%quantised = .true.
        call take_samples(magnetometer, measured)
        steps = measured/25e-9_dp
        call check(error, maxval(abs(steps - anint(steps))) < 1e-9_dp)
        call check(error, maxval(abs(measured - spread(FIELD + magnetometer%bias, 2, N))) &
                   < 28e-9_dp)
    end subroutine test_resolution

    subroutine test_settings(error)
        type(error_type), allocatable, intent(out) :: error
        type(magnetometer_t) :: magnetometer

        magnetometer%noise = -1e-9_dp
        call expect_failure('noise')
        magnetometer = magnetometer_t(noise=NAN)
        call expect_failure('noise')
        magnetometer = magnetometer_t(limited=.true., range=0.0_dp)
        call expect_failure('range')
        magnetometer = magnetometer_t(quantised=.true., resolution=-1.0_dp)
        call expect_failure('resolution')
        magnetometer = magnetometer_t(bias=[0.0_dp, NAN, 0.0_dp], limited=.true.)
        call expect_failure('not finite')

    contains

        subroutine expect_failure(word)
            character(*), intent(in) :: word
            type(random_stream_t) :: stream
            type(error_t), allocatable :: failure
            real(dp) :: measured(3, 2)

            call magnetometer%measure(spread(FIELD, 2, 2), stream, measured, failure)
            call check_fails(error, failure, word)
        end subroutine expect_failure
    end subroutine test_settings
end module test_magnetometer
