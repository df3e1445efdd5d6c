!> The accelerometer: kinematics at the proof mass, polynomial, noise, limits.
module test_accelerometer
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use vocabulary
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_from_axis_angle
    use gracecg_simulation_accelerometer, only: accelerometer_t, pmc_acceleration_t, pmc_acceleration
    implicit none
    private
    public :: collect_accelerometer

    real(dp), parameter :: OMEGA(3) = [1e-4_dp, -1.1e-3_dp, 3e-4_dp]        !! rad/s
    real(dp), parameter :: OMEGA_DOT(3) = [2e-5_dp, 6e-6_dp, -4e-6_dp]      !! rad/s^2
    real(dp), parameter :: D(3) = [3e-4_dp, -2e-4_dp, 5e-4_dp]              !! m
    real(dp), parameter :: A_NG(3) = [-6e-7_dp, 1e-8_dp, 3e-8_dp]           !! m/s^2
    real(dp), parameter :: R = 6837865.0_dp                                 !! m

contains

    subroutine collect_accelerometer(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('parts-by-printed-matrices', test_matrices), &
                    new_unittest('rotation-by-numerical-derivative', test_rotation), &
                    new_unittest('gravity-gradient-by-difference', test_gravity_gradient), &
                    new_unittest('polynomial', test_polynomial), &
                    new_unittest('rejects-bad-settings', test_settings), &
                    new_unittest('full-scale-and-resolution', test_digits)]
    end subroutine collect_accelerometer

    !> Samples stay within the full scale, stand on steps of the resolution, half a step off at most, and are
    !> those of before where neither is asked for.
    subroutine test_digits(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 400
        type(accelerometer_t) :: accelerometer
        type(error_t), allocatable :: failure
        type(random_stream_t) :: stream
        real(dp) :: truth(3, N), plain(3, N), digits(3, N)
        integer :: i

        truth = reshape([(1e-7_dp*(i - 600), i=1, 3*N)], [3, N])         ! to 6e-5 m/s^2
        stream = new_stream(3, 0, 0, 0, 0)
        call accelerometer%measure(truth, stream, plain, failure)
        call check(error, maxval(abs(plain)) > accelerometer%range, 'the full scale matters')
        accelerometer%limited = .true.
        accelerometer%quantised = .true.
        stream = new_stream(3, 0, 0, 0, 0)
        call accelerometer%measure(truth, stream, digits, failure)
        call check(error, maxval(abs(digits)), 5e-5_dp, thr=1e-20_dp)
        call check(error, all(abs(digits - plain) <= 0.5000001e-10_dp .or. abs(plain) > 5e-5_dp))
        call check(error, all(abs(digits/1e-10_dp - anint(digits/1e-10_dp)) < 1e-6_dp))
        call check(error, all(digits > 4.99e-5_dp .or. plain < 5e-5_dp), 'a saturated sample keeps its sign')
    end subroutine test_digits

    !> CSR-TM-00-01 eqs. (3-8), (3-9), (3-10) as matrices times d, and their sum (3-7).
    subroutine test_matrices(error)
        type(error_type), allocatable, intent(out) :: error
        type(pmc_acceleration_t) :: a
        real(dp) :: c(3), m(3, 3)
        integer :: i

        c = unit([0.1_dp, -0.2_dp, -0.9_dp])
        a = pmc_acceleration(OMEGA, OMEGA_DOT, D, c, EARTH_GM, R, A_NG)
        associate (w => OMEGA, wd => OMEGA_DOT)
            m(1, :) = [0.0_dp, -wd(3), wd(2)]
            m(2, :) = [wd(3), 0.0_dp, -wd(1)]
            m(3, :) = [-wd(2), wd(1), 0.0_dp]
            call check(error, maxval(abs(matmul(m, D) - a%acceleration)) < 1e-22_dp)
            m(1, :) = [-w(2)**2 - w(3)**2, w(1)*w(2), w(1)*w(3)]
            m(2, :) = [w(1)*w(2), -w(1)**2 - w(3)**2, w(2)*w(3)]
            m(3, :) = [w(1)*w(3), w(2)*w(3), -w(1)**2 - w(2)**2]
        end associate
        call check(error, maxval(abs(matmul(m, D) - a%velocity)) < 1e-24_dp)
        m = 0
        do i = 1, 3
            m(i, i) = 1
            m(i, :) = EARTH_GM/R**3*(m(i, :) - 3*c(i)*c)
        end do
        call check(error, maxval(abs(matmul(m, D) - a%gravity_gradient)) < 1e-23_dp)
        call check(error, maxval(abs(matmul(m, D) + a%velocity + a%acceleration + A_NG - a%total)) &
                   < 1e-21_dp)
    end subroutine test_matrices

    !> (3-3): the second derivative of a body-fixed point of a body that turns about a fixed axis with
    !> growing speed.
    subroutine test_rotation(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: SPEED = 0.4_dp, GROWTH = 0.7_dp, STEP = 1e-3_dp
        type(pmc_acceleration_t) :: a
        real(dp) :: axis(3), numerical(3)

        axis = unit([0.3_dp, -0.5_dp, 0.8_dp])
        a = pmc_acceleration(SPEED*axis, GROWTH*axis, D, axis, 0.0_dp, 1.0_dp, 0*A_NG)
        numerical = (inertial(STEP) - 2*inertial(0.0_dp) + inertial(-STEP))/STEP**2
        call check(error, maxval(abs(a%total - numerical)) < 1e-6_dp*norm2(D))

    contains

        function inertial(t) result(position)
            real(dp), intent(in) :: t
            real(dp) :: position(3)

            position = matmul(transpose(rotation_matrix( &
                quaternion_from_axis_angle(axis, SPEED*t + GROWTH*t**2/2))), D)
        end function inertial
    end subroutine test_rotation

    !> What is sensed, (3-4), (3-6), is gravity at the COM less gravity at the PMC; here with d of 1 km.
    subroutine test_gravity_gradient(error)
        type(error_type), allocatable, intent(out) :: error
        type(pmc_acceleration_t) :: a
        real(dp) :: zero(3), position(3), offset(3), difference(3)

        zero = 0
        position = R*unit([1.0_dp, 2.0_dp, -0.5_dp])
        offset = 1000*unit([0.4_dp, -0.1_dp, 0.7_dp])
        a = pmc_acceleration(zero, zero, offset, unit(position), EARTH_GM, R, zero)
        difference = gravity(position - offset/2) - gravity(position + offset/2)
        call check(error, norm2(a%total - difference)/norm2(difference) < 1e-7_dp)

    contains

        function gravity(x) result(g)
            real(dp), intent(in) :: x(3)
            real(dp) :: g(3)

            g = -EARTH_GM*x/norm2(x)**3
        end function gravity
    end subroutine test_gravity_gradient

    !> (3-1) for a = 2e-5, -1e-5, 4e-5 m/s^2 by hand.
    subroutine test_polynomial(error)
        type(error_type), allocatable, intent(out) :: error
        type(accelerometer_t) :: accelerometer

        accelerometer%scale1 = [1.01_dp, 0.98_dp, 1.0_dp]
        accelerometer%scale2 = [10.0_dp, -20.0_dp, 5.0_dp]
        accelerometer%scale3 = [1e4_dp, 2e5_dp, -1e4_dp]
        accelerometer%bias = [1e-6_dp, -3e-5_dp, 0.0_dp]
        associate (output => accelerometer%response([2e-5_dp, -1e-5_dp, 4e-5_dp]))
            call check(error, output(1), 2.12040800e-5_dp, thr=1e-18_dp)
            call check(error, output(2), -3.98022e-5_dp, thr=1e-18_dp)
            call check(error, output(3), 4.000736e-5_dp, thr=1e-18_dp)
        end associate
    end subroutine test_polynomial

    subroutine test_settings(error)
        type(error_type), allocatable, intent(out) :: error
        type(accelerometer_t) :: accelerometer

        accelerometer%noise(2)%level = -1
        call expect_failure('y axis')
        accelerometer = accelerometer_t()
        accelerometer%noise%sides = 0
        call expect_failure('sides')
        accelerometer = accelerometer_t(bias=ieee_value([0.0_dp, 0.0_dp, 0.0_dp], ieee_quiet_nan))
        call expect_failure('not finite')

    contains

        subroutine expect_failure(word)
            character(*), intent(in) :: word
            type(random_stream_t) :: stream
            type(error_t), allocatable :: failure
            real(dp) :: measured(3, 2)

            call accelerometer%measure(spread(A_NG, 2, 2), stream, measured, failure)
            call check_fails(error, failure, word)
        end subroutine expect_failure
    end subroutine test_settings
end module test_accelerometer
