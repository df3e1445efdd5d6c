!> Whitening of observations whose noise is white plus any Gauss-Markov process, by the process' Kalman
!> filter: the innovations divided by their standard deviations (T. Kailath, IEEE Trans. Automatic
!> Control 13 (1968) 646-655), the partials with them.
!>
!> It gives what the square-root information filter leaves of each observation
!> (gracecg_square_root_filter), up to sign, at a tenth of the work, since the gains do not depend on
!> the partials; but nothing for a smoother. It serves the search for a process by its likelihood.
module gracecg_process_whitening
    use gracecg_kinds, only: dp
    use gracecg_gauss_markov, only: gauss_markov_t
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

        real(dp) :: state(size(rows, 1), process%n), covariance(process%n, process%n)
        real(dp) :: noise(process%n, process%n), gain(process%n), variance
        integer :: i, j, k, n

        n = process%n
        log_variance = 0
        state = 0
        covariance = process%covariance
        noise = matmul(process%noise_root, transpose(process%noise_root))
        do i = 1, size(epoch)
            if (i > 1) then
                do k = epoch(i - 1) + 1, epoch(i)
                    call transit(process, noise, state, covariance)
                end do
            end if
            if (.not. kept(i)) then
                whitened(:, i) = 0
                cycle
            end if
            gain = matmul(covariance, process%output)
            variance = 1 + dot_product(process%output, gain)
            gain = gain/variance
            whitened(:, i) = rows(:, i)
            do j = 1, n
                if (abs(process%output(j)) > 0) whitened(:, i) = whitened(:, i) - process%output(j)*state(:, j)
            end do
            do j = 1, n
                state(:, j) = state(:, j) + gain(j)*whitened(:, i)
                covariance(:, j) = covariance(:, j) - variance*gain(j)*gain
            end do
            whitened(:, i) = whitened(:, i)/sqrt(variance)
            log_variance = log_variance + log(variance)
        end do
    end subroutine whiten_by_process

    !> State and covariance at the next epoch.
    pure subroutine transit(process, noise, state, covariance)
        type(gauss_markov_t), intent(in) :: process
        real(dp), intent(in) :: noise(:, :)             !! Q
        real(dp), intent(inout) :: state(:, :)          !! (values, n)
        real(dp), intent(inout) :: covariance(:, :)     !! n x n

        call times_transition(process%transition, state)
        call times_transition(process%transition, covariance)       ! P Phi^T
        covariance = transpose(covariance)                          ! Phi P
        call times_transition(process%transition, covariance)
        covariance = covariance + noise
    end subroutine transit

    !> a Phi^T in place of a, for a tridiagonal Phi.
    pure subroutine times_transition(phi, a)
        real(dp), intent(in) :: phi(:, :)
        real(dp), intent(inout) :: a(:, :)              !! (anything, n)

        real(dp) :: before(size(a, 1)), now(size(a, 1))
        integer :: j, n

        n = size(a, 2)
        do j = 1, n
            now = a(:, j)
            a(:, j) = phi(j, j)*now
            if (j > 1) then
                if (abs(phi(j, j - 1)) > 0) a(:, j) = a(:, j) + phi(j, j - 1)*before
            end if
            if (j < n) then
                if (abs(phi(j, j + 1)) > 0) a(:, j) = a(:, j) + phi(j, j + 1)*a(:, j + 1)
            end if
            before = now
        end do
    end subroutine times_transition
end module gracecg_process_whitening
