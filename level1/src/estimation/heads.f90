!> The attitude by all heads of the star cameras together: each sees the sky well across its boresight and badly about
!> it, and one that comes or goes must not turn the satellite.
module gracecg_level1_heads
    use gracecg_base_kinds, only: dp
    use gracecg_base_quaternion, only: quaternion_product, rotation_matrix, normalised, rotation_between
    use gracecg_base_vectors, only: inverse_3x3
    implicit none
    private
    public :: combine_heads

    !> Of a head across its boresight and about it; their ratio alone counts (GRACE-FO C and D at 2 Hz: 1 to 4 and 20 to
    !> 42 arcsec)
    real(dp), parameter :: ACROSS = 2.5_dp, ABOUT = 30

contains

    !> One attitude for each time at which some head has one. What a head is turned from the one with most records in
    !> the mean of their common times is taken away; then
    !>
    !>     q = dq(e) q_1,  e = (sum_h W_h)^-1 sum_h W_h e_h,  W_h = R_h diag(1/s_x^2, 1/s_x^2, 1/s_z^2) R_h^T
    !>
    !> with e_h the rotation vector of head h from the first head of that time, and R_h its mounting.
    subroutine combine_heads(times, head, q, mounting, joint_times, joint_q)
        real(dp), intent(in) :: times(:)            !! Not falling, s
        integer, intent(in) :: head(:)              !! Its number, of each record
        real(dp), intent(in) :: q(:, :)             !! (4, n): inertial to SRF by that head, scalar last
        real(dp), intent(in) :: mounting(:, :)      !! (4, heads): head to SRF, scalar last
        real(dp), allocatable, intent(out) :: joint_times(:)    !! Rising, s
        real(dp), allocatable, intent(out) :: joint_q(:, :)     !! (4, times)

        real(dp), parameter :: EQUAL = 1e-3_dp      ! s
        real(dp) :: turned(3, size(mounting, 2)), weight(3, 3, size(mounting, 2)), sum_of_weights(3, 3), weighted(3), r(3, 3)
        integer :: common(size(mounting, 2)), reference, i, k, n, first, last

        reference = 1
        do i = 2, size(mounting, 2)
            if (count(head == i) > count(head == reference)) reference = i
        end do
        do i = 1, size(mounting, 2)
            r = rotation_matrix(mounting(:, i))
            weight(:, :, i) = matmul(r, reshape([1/ACROSS**2, 0.0_dp, 0.0_dp, 0.0_dp, 1/ACROSS**2, 0.0_dp, 0.0_dp, 0.0_dp, &
                                                 1/ABOUT**2], [3, 3]))
            weight(:, :, i) = matmul(weight(:, :, i), transpose(r))
        end do
        turned = 0
        common = 0
        allocate (joint_times(size(times)), joint_q(4, size(times)))
        first = 1
        do while (first <= size(times))         ! means of the common times
            last = last_of_equal(first)
            do i = first, last
                if (head(i) /= reference) cycle
                do k = first, last
                    turned(:, head(k)) = turned(:, head(k)) + rotation_between(q(:, i), q(:, k))
                    common(head(k)) = common(head(k)) + 1
                end do
            end do
            first = last + 1
        end do
        do i = 1, size(common)
            turned(:, i) = turned(:, i)/max(1, common(i))
        end do
        n = 0
        first = 1
        do while (first <= size(times))
            last = last_of_equal(first)
            sum_of_weights = 0
            weighted = 0
            do k = first, last
                sum_of_weights = sum_of_weights + weight(:, :, head(k))
                weighted = weighted + matmul(weight(:, :, head(k)), rotation_between(q(:, first), q(:, k)) - turned(:, head(k)))
            end do
            n = n + 1
            joint_times(n) = times(first)
            joint_q(:, n) = quaternion_product(small_turn(matmul(inverse_3x3(sum_of_weights), weighted)), q(:, first))
            first = last + 1
        end do
        joint_times = joint_times(:n)
        joint_q = joint_q(:, :n)

    contains

        pure integer function last_of_equal(first) result(last)
            integer, intent(in) :: first

            last = first
            do while (last < size(times))
                if (times(last + 1) - times(first) > EQUAL) exit
                last = last + 1
            end do
        end function last_of_equal
    end subroutine combine_heads

    !> The quaternion of a small rotation vector, to its third power.
    pure function small_turn(phi) result(q)
        real(dp), intent(in) :: phi(3)
        real(dp) :: q(4)

        q = normalised([phi/2, 1 - dot_product(phi, phi)/8])
    end function small_turn
end module gracecg_level1_heads
