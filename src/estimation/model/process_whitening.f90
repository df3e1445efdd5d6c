!> Whitening of observations whose noise is white plus any Gauss-Markov process, by the process' Kalman
!> filter: the innovations divided by their standard deviations (T. Kailath, IEEE Trans. Automatic
!> Control 13 (1968) 646-655), the partials with them.
!>
!> It gives what the square-root information filter leaves of each observation
!> (gracecg_estimation_square_root_filter), up to sign, at a tenth of the work, since the gains do not depend on
!> the partials; but nothing for a smoother. It serves the search for a process by its likelihood.
module gracecg_estimation_process_whitening
    use gracecg_base_kinds, only: dp
    use gracecg_base_gauss_markov, only: gauss_markov_t
    implicit none
    private
    public :: whiten_by_process

contains

    !> Whitens rows of observations with unit white noise. Rows that are not kept become zero.
    pure subroutine whiten_by_process(process, epoch, kept, rows, whitened, log_variance)
        type(gauss_markov_t), intent(in) :: process     !! Its transition matrix tridiagonal
        integer, intent(in) :: epoch(:)                 !! Of each row, in intervals, increasing
        logical, intent(in) :: kept(:)    !! (samples)
        real(dp), intent(in) :: rows(:, :)              !! (values, samples)
        real(dp), intent(out) :: whitened(:, :)         !! (values, samples)
        real(dp), intent(out) :: log_variance           !! Sum of the logarithms of the innovations' variances

        log_variance = 0
        call whiten_sized(process%n, size(rows, 1), size(epoch), process, epoch, kept, rows, whitened, log_variance)
    end subroutine whiten_by_process

    !> The work of whiten_by_process, with sizes that the compiler sees.
    pure subroutine whiten_sized(n, values, samples, process, epoch, kept, rows, whitened, log_variance)
        integer, intent(in) :: n, values, samples
        type(gauss_markov_t), intent(in) :: process
        integer, intent(in) :: epoch(samples)
        logical, intent(in) :: kept(samples)
        real(dp), intent(in) :: rows(values, samples)
        real(dp), intent(out) :: whitened(values, samples)
        real(dp), intent(inout) :: log_variance

        real(dp) :: state(values, n), covariance(n, n), noise(n, n), gain(n), variance
        real(dp) :: below(n), on(n), above(n)           ! Phi(j, j - 1), Phi(j, j), Phi(j, j + 1)
        integer :: i, j, k

        call diagonals(n, process%transition, below, on, above)
        state = 0
        covariance = process%covariance
        noise = matmul(process%noise_root, transpose(process%noise_root))
        do i = 1, samples
            if (i > 1) then
                do k = epoch(i - 1) + 1, epoch(i)
                    call times_transition(values, n, below, on, above, state)
                    call times_transition(n, n, below, on, above, covariance)       ! P Phi^T
                    covariance = transpose(covariance)                              ! Phi P
                    call times_transition(n, n, below, on, above, covariance)
                    covariance = covariance + noise
                end do
            end if
            if (.not. kept(i)) then
                whitened(:, i) = 0
                cycle
            end if
            gain = 0
            do j = 1, n
                if (abs(process%output(j)) > 0) gain = gain + process%output(j)*covariance(:, j)
            end do
            variance = 1 + dot_product(process%output, gain)
            gain = gain/variance
            whitened(:, i) = rows(:, i)
            do j = 1, n
                if (abs(process%output(j)) > 0) whitened(:, i) = whitened(:, i) - process%output(j)*state(:, j)
            end do
            do j = 1, n
                state(:, j) = state(:, j) + gain(j)*whitened(:, i)
                covariance(:, j) = covariance(:, j) - (variance*gain(j))*gain
            end do
            whitened(:, i) = whitened(:, i)/sqrt(variance)
            log_variance = log_variance + log(variance)
        end do
    end subroutine whiten_sized

    !> The three diagonals of a transition matrix.
    pure subroutine diagonals(n, phi, below, on, above)
        integer, intent(in) :: n
        real(dp), intent(in) :: phi(n, n)
        real(dp), intent(out) :: below(n), on(n), above(n)

        integer :: j

        below = 0
        above = 0
        do j = 1, n
            on(j) = phi(j, j)
            if (j > 1) below(j) = phi(j, j - 1)
            if (j < n) above(j) = phi(j, j + 1)
        end do
    end subroutine diagonals

    !> a Phi^T in place of a.
    pure subroutine times_transition(rows, n, below, on, above, a)
        integer, intent(in) :: rows, n
        real(dp), intent(in) :: below(n), on(n), above(n)   !! Diagonals of Phi
        real(dp), intent(inout) :: a(rows, n)

        real(dp) :: before(rows), now(rows)
        integer :: j

        do j = 1, n
            now = a(:, j)
            if (abs(below(j)) > 0) then
                a(:, j) = on(j)*now + below(j)*before
            else if (abs(above(j)) > 0) then
                a(:, j) = on(j)*now + above(j)*a(:, j + 1)
            else
                a(:, j) = on(j)*now
            end if
            if (abs(below(j)) > 0 .and. abs(above(j)) > 0) a(:, j) = a(:, j) + above(j)*a(:, j + 1)
            before = now
        end do
    end subroutine times_transition
end module gracecg_estimation_process_whitening
