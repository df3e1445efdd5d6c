!> What an accelerometer can tell of the CG offset along a known rotation, whoever estimates it: the
!> Fisher information, whose inverse is the bound of H. Cramer (1946) and C. R. Rao (1945).
module gracecg_estimation_offset_information
    use gracecg_base_kinds, only: dp
    use gracecg_estimation_offset_model, only: offset_matrix
    use gracecg_estimation_noise_whitening, only: whitener_t, row_state_t, ROW
    implicit none
    private
    public :: gather_information, gravity_gradient_matrix

contains

    !> Information of d under the accelerometer's coloured noise, a bias and a drift of each axis
    !> eliminated: the sum over the axes of A^T (I - Q Q^T) A, A the whitened rows of A~ + G and Q
    !> the whitened straight line.
    !>
    !> At d = 0 this is the whole of it: there the acceleration does not depend on the rotation to
    !> first order, so that attitude and angular velocity need not be known better than star camera
    !> and manoeuvre tell. Works without storage, in proportion to the number of samples.
    !>
    !> And what a disturbance e of the accelerometer adds to the normal vector: A^T (I - Q Q^T) e, e whitened. It is whitened
    !> beside the three columns of A~.
    pure subroutine gather_information(omega, omega_dot, whiteners, information, gradient, disturbance, effect)
        real(dp), intent(in) :: omega(:, :)         !! At the samples, (3, samples), rad/s
        real(dp), intent(in) :: omega_dot(:, :)     !! (3, samples), rad/s^2
        type(whitener_t), intent(in) :: whiteners(3)    !! Of the accelerometer's axes
        real(dp), intent(out) :: information(3, 3)  !! 1/m^2
        real(dp), intent(in), optional :: gradient(:, :, :)
        !! G of gravity_gradient_matrix, (3, 3, samples), 1/s^2; zero when absent
        real(dp), intent(in), optional :: disturbance(:, :)     !! Of the axes, (3, samples), m/s^2
        real(dp), intent(out), optional :: effect(3)            !! Of it, 1/m

        type(row_state_t) :: state(3)               ! of each axis: columns of A~, disturbance
        real(dp) :: a(3, 3), given(ROW), whitened(ROW), products(ROW, 3), on_line(ROW, 2, 3)
        integer :: i, k, axis

        products = 0
        on_line = 0
        given = 0
        do i = 1, size(omega, 2)
            a = offset_matrix(omega(:, i), omega_dot(:, i))
            if (present(gradient)) a = a + gradient(:, :, i)
            do axis = 1, 3
                given(1:3) = a(axis, :)
                if (present(disturbance)) given(4) = disturbance(axis, i)
                call whiteners(axis)%step_row(i, state(axis), given, whitened)
                do k = 1, 3
                    products(:, k) = products(:, k) + whitened*whitened(k)
                end do
                do k = 1, 2
                    on_line(:, k, axis) = on_line(:, k, axis) + whitened*whiteners(axis)%line(k, i)
                end do
            end do
        end do
        do axis = 1, 3
            do k = 1, 3
                products(:, k) = products(:, k) - (on_line(:, 1, axis)*on_line(k, 1, axis) + &
                                                   on_line(:, 2, axis)*on_line(k, 2, axis))
            end do
        end do
        information = products(1:3, :)
        if (present(effect)) effect = products(4, :)
    end subroutine gather_information

    !> Acceleration of a point at d by the gravity gradient of a sphere, per unit of d:
    !> mu/r^3 (I - 3 c c^T), CSR-TM-00-01 eq. (3-6).
    pure function gravity_gradient_matrix(rate_squared, vertical) result(g)
        real(dp), intent(in) :: rate_squared        !! mu/r^3, 1/s^2
        real(dp), intent(in) :: vertical(3)         !! c, unit vector upwards, body axes
        real(dp) :: g(3, 3)                         !! 1/s^2

        integer :: i

        do i = 1, 3
            g(:, i) = -3*rate_squared*vertical(i)*vertical
            g(i, i) = g(i, i) + rate_squared
        end do
    end function gravity_gradient_matrix
end module gracecg_estimation_offset_information
