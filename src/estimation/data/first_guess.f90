!> A first guess of attitude and angular velocity at the epoch, from the star-camera samples themselves.
module gracecg_estimation_first_guess
    use gracecg_base_kinds, only: dp
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion, normalised
    use gracecg_base_statistics, only: median_of
    implicit none
    private
    public :: guess_rotation

    integer, parameter :: MOST_SAMPLES = 20     !! From the beginning of the arc

contains

    !> A straight line through the turns of the first samples, by medians: a few samples that are wrong do not
    !> matter. The reference of the turns is the sample that agrees best with the others.
    pure subroutine guess_rotation(time, quaternion, attitude, angular_velocity)
        real(dp), intent(in) :: time(:)                 !! Increasing, s from the epoch
        real(dp), intent(in) :: quaternion(:, :)        !! (4, samples), inertial to body, unit, free of flips
        real(dp), intent(out) :: attitude(4)            !! At the epoch, inertial to body
        real(dp), intent(out) :: angular_velocity(3)    !! At the epoch, body axes, rad/s

        real(dp) :: turn(3, MOST_SAMPLES), slope(MOST_SAMPLES*(MOST_SAMPLES - 1)/2), relative(4), at_epoch(3)
        integer :: n, reference, axis, i, j, pairs

        n = min(size(time), MOST_SAMPLES)
        reference = central_sample(quaternion(:, :n))
        do i = 1, n
            relative = quaternion_product(quaternion(:, i), conjugate_quaternion(quaternion(:, reference)))
            turn(:, i) = 2*relative(1:3)*sign(1.0_dp, relative(4))     ! small
        end do
        angular_velocity = 0
        do axis = 1, 3
            pairs = 0
            do i = 1, n - 1
                do j = i + 1, n
                    if (.not. time(j) > time(i)) cycle
                    pairs = pairs + 1
                    slope(pairs) = (turn(axis, j) - turn(axis, i))/(time(j) - time(i))
                end do
            end do
            if (pairs > 0) angular_velocity(axis) = median_of(slope(:pairs))
            at_epoch(axis) = median_of(turn(axis, :n) - angular_velocity(axis)*time(:n))
        end do
        attitude = normalised(quaternion_product([at_epoch/2, 1.0_dp], quaternion(:, reference)))
    end subroutine guess_rotation

    !> The sample from which the others are turned least, in sum.
    pure integer function central_sample(quaternion) result(central)
        real(dp), intent(in) :: quaternion(:, :)    !! (4, samples)

        real(dp) :: agreement(size(quaternion, 2))
        integer :: i

        do i = 1, size(agreement)
            agreement(i) = sum(abs(matmul(quaternion(:, i), quaternion)))
        end do
        central = maxloc(agreement, 1)
    end function central_sample
end module gracecg_estimation_first_guess
