!> The accelerometer's observation model of CSR-TM-00-01 section 4.4:
!> A_out = A~(omega, d omega/dt) d + alpha t + beta.
module gracecg_estimation_offset_model
    use gracecg_base_kinds, only: dp
    use gracecg_base_vectors, only: cross_matrix
    implicit none
    private
    public :: offset_matrix, offset_rate_partials

contains

    !> A~ of (4-17), (4-18): the acceleration of a point at d, per unit of d, in a rotating frame:
    !> A~ d = d omega/dt x d + omega x (omega x d).
    pure function offset_matrix(omega, omega_dot) result(a)
        real(dp), intent(in) :: omega(3)        !! rad/s
        real(dp), intent(in) :: omega_dot(3)    !! rad/s^2
        real(dp) :: a(3, 3)                     !! 1/s^2

        ! row by row: cross_matrix(omega_dot) + omega omega^T - omega^2 I
        a(1, :) = [-omega(3)**2 - omega(2)**2, omega(2)*omega(1) - omega_dot(3), omega(3)*omega(1) + omega_dot(2)]
        a(2, :) = [omega(1)*omega(2) + omega_dot(3), -omega(3)**2 - omega(1)**2, omega(3)*omega(2) - omega_dot(1)]
        a(3, :) = [omega(1)*omega(3) - omega_dot(2), omega(2)*omega(3) + omega_dot(1), -omega(2)**2 - omega(1)**2]
    end function offset_matrix

    !> d(A~ d)/d omega of (4-21), (4-27)-(4-32), where d omega/dt depends on omega through Lambda.
    !>
    !> d omega x (omega x d) = omega (omega.d) - d omega^2, hence the first three terms.
    pure function offset_rate_partials(omega, d, lambda) result(h)
        real(dp), intent(in) :: omega(3)        !! rad/s
        real(dp), intent(in) :: d(3)            !! m
        real(dp), intent(in), optional :: lambda(3, 3)  !! d(d omega/dt)/d omega, 1/s; absent: 0
        real(dp) :: h(3, 3)                     !! (m/s^2)/(rad/s)

        real(dp) :: along
        integer :: i, j

        h = 0
        if (present(lambda)) h = matmul(cross_matrix(d), lambda)
        along = dot_product(omega, d)
        do j = 1, 3
            do i = 1, 3
                h(i, j) = omega(i)*d(j) - 2*d(i)*omega(j) + merge(along, 0.0_dp, i == j) - h(i, j)
            end do
        end do
    end function offset_rate_partials
end module gracecg_estimation_offset_model
