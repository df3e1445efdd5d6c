!> Propagation of noise through a fit, against covariance matrices written out in full.
module test_noise_propagation
    use vocabulary
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, noise_spectrum_t, TWO_SIDED
    use gracecg_base_quaternion, only: normalised, quaternion_product, conjugate_quaternion, &
        quaternion_from_axis_angle
    use gracecg_estimation_interpolation, only: interpolation_t
    use gracecg_estimation_star_attitude, only: star_attitude_t
    use gracecg_estimation_noise_propagation
    implicit none
    private
    public :: collect_noise_propagation

contains

    subroutine collect_noise_propagation(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('stationary-noise', test_stationary), &
                    new_unittest('white-noise', test_white), &
                    new_unittest('star-noise', test_star)]
    end subroutine collect_noise_propagation

    !> Numbers without a pattern, of size one.
    elemental real(dp) function scatter(i)
        integer, intent(in) :: i

        scatter = sin(1.7_dp*i) + cos(0.31_dp*i*i)
    end function scatter

    !> G R G^T with the Toeplitz matrix R(i, j) = r(|k_i - k_j|) of flicker noise; some epochs are missing, others
    !> lie far away.
    subroutine test_stationary(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: EPOCH(12) = [1, 2, 3, 5, 8, 9, 10, 11, 20, 21, 30, 5000]
        type(coloured_noise_t) :: noise
        type(error_t), allocatable :: failure
        real(dp) :: gain(3, 12), toeplitz(12, 12), expected(3, 3), found(3, 3)
        integer :: i, j

        noise = coloured_noise(noise_spectrum_t(2.0_dp, 0.3_dp, TWO_SIDED), 0.1_dp, failure)
        gain = reshape([(scatter(i), i=1, 36)], [3, 12])
        do j = 1, 12
            toeplitz(:, j) = noise%autocovariance([(EPOCH(i) - EPOCH(j), i=1, 12)])
        end do
        expected = matmul(gain, matmul(toeplitz, transpose(gain)))
        found = stationary_noise_covariance(gain, EPOCH, noise)
        call check(error, maxval(abs(found - expected)), 0.0_dp, thr=1e-13_dp*maxval(abs(expected)))
        call check(error, maxval(abs(found - transpose(found))), 0.0_dp, &
                   thr=1e-15_dp*maxval(abs(found)))
    end subroutine test_stationary

    !> Without correlation sigma^2 G G^T, sigma^2 = S/h.
    subroutine test_white(error)
        type(error_type), allocatable, intent(out) :: error
        type(coloured_noise_t) :: noise
        type(error_t), allocatable :: failure
        real(dp) :: gain(2, 6), found(2, 2)
        integer :: i

        noise = coloured_noise(noise_spectrum_t(0.3_dp, 0.0_dp, TWO_SIDED), 0.1_dp, failure)
        gain = reshape([(scatter(i), i=1, 12)], [2, 6])
        found = stationary_noise_covariance(gain, [1, 2, 3, 4, 5, 6], noise)
        call check(error, maxval(abs(found - 3*matmul(gain, transpose(gain)))), 0.0_dp, &
                   thr=1e-13_dp)
    end subroutine test_white

    !> G L S L^T G^T: S the block-diagonal covariance of the samples, whose blocks come from turning
    !> each sample a little about each camera axis (4-68); L the matrix of linear interpolation.
    subroutine test_star(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: P = 3, SAMPLES = 4, PSEUDO = 9
        real(dp), parameter :: SIGMA(3) = [1e-5_dp, 2e-5_dp, 7e-5_dp], STEP = 1e-4_dp
        real(dp) :: mounting(4, 2), q(4, SAMPLES), gain(P, 4, PSEUDO), flat(P, 4*PSEUDO)
        real(dp) :: interpolation(4*PSEUDO, 4*SAMPLES), covariance(4*SAMPLES, 4*SAMPLES)
        real(dp) :: slope(4), expected(P, P), found(P, P)
        integer, parameter :: HEAD(SAMPLES) = [1, 2, 2, 1]
        type(interpolation_t) :: source(PSEUDO)
        type(star_attitude_t) :: stars
        integer :: i, s, axis, c

        mounting(:, 1) = normalised([0.3_dp, -0.2_dp, 0.5_dp, 0.7_dp])
        mounting(:, 2) = normalised([-0.4_dp, 0.1_dp, 0.2_dp, 0.6_dp])
        do s = 1, SAMPLES
            q(:, s) = normalised([(scatter(4*s + c), c=1, 4)])
        end do
        gain = reshape([(scatter(i), i=1, size(gain))], shape(gain))
        do i = 1, PSEUDO
            source(i) = interpolation_t(1 + (i - 1)/3, mod(i, 3)/3.0_dp - 0.2_dp, .true.)
        end do

        covariance = 0
        do s = 1, SAMPLES
            do axis = 1, 3
                slope = (turned(s, axis, STEP) - turned(s, axis, -STEP))/(2*STEP)
                do c = 1, 4
                    associate (column => covariance(4*s - 3:4*s, 4*s - 4 + c))
                        column = column + SIGMA(axis)**2*slope*slope(c)
                    end associate
                end do
            end do
        end do
        interpolation = 0
        do i = 1, PSEUDO
            s = source(i)%first
            do c = 1, 4
                interpolation(4*(i - 1) + c, 4*(s - 1) + c) = 1 - source(i)%fraction
                interpolation(4*(i - 1) + c, 4*s + c) = source(i)%fraction
            end do
        end do
        flat = reshape(gain, [P, 4*PSEUDO])
        flat(:, :4*SAMPLES) = matmul(flat, interpolation)
        expected = matmul(flat(:, :4*SAMPLES), matmul(covariance, transpose(flat(:, :4*SAMPLES))))
        stars%head = HEAD
        stars%quaternion = q
        found = star_noise_covariance(gain, source, SIGMA, mounting, stars)
        call check(error, maxval(abs(found - expected)), 0.0_dp, thr=1e-8_dp*maxval(abs(expected)))

    contains

        !> The attitude that the camera of a sample reports when turned by a small angle about its axis.
        pure function turned(sample, axis, angle) result(reported)
            integer, intent(in) :: sample, axis
            real(dp), intent(in) :: angle
            real(dp) :: reported(4), direction(3)

            direction = 0
            direction(axis) = 1
            associate (to_camera => mounting(:, HEAD(sample)))
                reported = quaternion_product(quaternion_from_axis_angle(direction, angle), &
                                              quaternion_product(to_camera, q(:, sample)))
                reported = quaternion_product(conjugate_quaternion(to_camera), reported)
            end associate
        end function turned
    end subroutine test_star
end module test_noise_propagation
