!> What all samples say of a process and of each sample: the fixed-interval smoother of a series with coloured noise, by
!> the filter's transpose run backwards.
!>
!> A sample is r = h^T p + e, e white with variance 1, p(k+1) = Phi p(k) + noise. With the filter's innovations v, their
!> variances F and its gains K (gracecg_estimation_noise_whitening), and r' = Phi^T r, N' = Phi^T N Phi of the sample
!> after, 0 behind the last, P. de Jong (J. Am. Stat. Assoc. 84 (1989) 1085-1088) has
!>
!>     u = v/F - K^T r',                  D = 1/F + K^T N' K,
!>     r = r' + h u,                      N = N' - (N' K) h^T - h (N' K)^T + D h h^T,
!>
!> and where a sample is left out r = r', N = N', D = 1/(F - F^2 K^T N' K), u = (v - F K^T r') D. u is the smoothed e of a
!> sample in use, u/D what a sample differs by from what all others predict and 1/D the variance of that (P. de Jong,
!> J. Penzer, J. Am. Stat. Assoc. 93 (1998) 796-806). The smoothed process follows forwards: p = P r before the first sample,
!> p(k+1) = Phi p(k) + Q r (S. J. Koopman, Biometrika 80 (1993) 117-126).
module gracecg_estimation_process_smoother
    use gracecg_base_kinds, only: dp
    use gracecg_base_gauss_markov, only: gauss_markov_t
    use gracecg_base_lanes, only: LANES
    use gracecg_estimation_noise_whitening, only: process_filter_t, nonzero_rows
    implicit none
    private
    public :: smooth_errors, smooth_signals

contains

    !> u in place of several series, and the samples' D.
    pure subroutine smooth_errors(filter, series, information)
        type(process_filter_t), intent(in) :: filter
        real(dp), intent(inout) :: series(:, :)         !! (series, samples), white noise = 1
        real(dp), intent(out) :: information(:)         !! D, (samples)

        integer, allocatable :: places(:)
        integer :: first

        call filter%whiten(series, predicts=.true.)
        associate (n => filter%process%n, samples => size(filter%epoch), output => filter%process%output)
            call go_back(n, samples, filter%kept, output, filter%gain, filter%inverse_deviation, filter%below, filter%on, &
                         filter%above, information)
            places = nonzero_rows(series)
            do first = 1, size(places), LANES
                call smooth_lanes(n, samples, filter%kept, output, filter%gain, filter%inverse_deviation, filter%below, &
                                  filter%on, filter%above, information, &
                                  places(first:min(first + LANES - 1, size(places))), series)
            end do
        end associate
    end subroutine smooth_errors

    !> D of every sample.
    pure subroutine go_back(n, samples, kept, output, gain, inverse_deviation, below, on, above, information)
        integer, intent(in) :: n, samples
        logical, intent(in) :: kept(samples)
        real(dp), intent(in) :: output(n), inverse_deviation(samples)
        real(dp), intent(in), dimension(n, samples) :: gain, below, on, above
        real(dp), intent(out) :: information(:)

        real(dp) :: later(n, n), half(n, n), seen(n)
        integer :: i, j

        later = 0
        do i = samples, 1, -1
            if (i < samples) then       ! N' = Phi^T (N Phi)
                do j = 1, n
                    half(:, j) = on(j, i)*later(:, j)
                    if (j < n) half(:, j) = half(:, j) + below(j + 1, i)*later(:, j + 1)
                    if (j > 1) half(:, j) = half(:, j) + above(j - 1, i)*later(:, j - 1)
                end do
                do j = 1, n
                    later(:, j) = on(:, i)*half(:, j)
                    later(:n - 1, j) = later(:n - 1, j) + below(2:, i)*half(2:, j)
                    later(2:, j) = later(2:, j) + above(:n - 1, i)*half(:n - 1, j)
                end do
            end if
            seen = matmul(later, gain(:, i))
            information(i) = inverse_deviation(i)**2 + dot_product(gain(:, i), seen)
            if (.not. kept(i)) then
                information(i) = inverse_deviation(i)**4/(inverse_deviation(i)**2 - dot_product(gain(:, i), seen))
                cycle
            end if
            do j = 1, n
                later(:, j) = later(:, j) - output*seen(j)
                if (abs(output(j)) > 0) later(:, j) = later(:, j) - output(j)*seen + information(i)*output(j)*output
            end do
        end do
    end subroutine go_back

    !> u in place of v/sqrt F, of a few series side by side.
    pure subroutine smooth_lanes(n, samples, kept, output, gain, inverse_deviation, below, on, above, information, places, &
                                 series)
        integer, intent(in) :: n, samples
        logical, intent(in) :: kept(samples)
        real(dp), intent(in) :: output(n), inverse_deviation(samples), information(samples)
        real(dp), intent(in), dimension(n, samples) :: gain, below, on, above
        integer, intent(in) :: places(:)                ! of the series, at most LANES
        real(dp), intent(inout) :: series(:, :)         ! (series, samples)

        real(dp) :: later(LANES, n), moved(LANES, n)
        real(dp), dimension(LANES) :: error
        integer :: i, j, lane

        later = 0
        error = 0
        do i = samples, 1, -1
            if (i < samples) then
                do j = 1, n
                    moved(:, j) = on(j, i)*later(:, j)
                    if (j < n) then
                        if (abs(below(j + 1, i)) > 0) moved(:, j) = moved(:, j) + below(j + 1, i)*later(:, j + 1)
                    end if
                    if (j > 1) then
                        if (abs(above(j - 1, i)) > 0) moved(:, j) = moved(:, j) + above(j - 1, i)*later(:, j - 1)
                    end if
                end do
                later = moved
            end if
            do lane = 1, size(places)
                error(lane) = inverse_deviation(i)*series(places(lane), i)
            end do
            do j = 1, n
                error = error - gain(j, i)*later(:, j)
            end do
            if (.not. kept(i)) error = error*information(i)/inverse_deviation(i)**2
            do lane = 1, size(places)
                series(places(lane), i) = error(lane)
            end do
            if (.not. kept(i)) cycle
            do j = 1, n
                later(:, j) = later(:, j) + output(j)*error
            end do
        end do
    end subroutine smooth_lanes

    !> The smoothed process: chosen parts of its state at the samples.
    pure subroutine smooth_signals(process, epoch, kept, errors, signals, values)
        type(gauss_markov_t), intent(in) :: process
        integer, intent(in) :: epoch(:)                 !! Of the samples, in intervals, increasing
        logical, intent(in) :: kept(:)                  !! (samples)
        real(dp), intent(in) :: errors(:)               !! u, (samples)
        real(dp), intent(in) :: signals(:, :)           !! Of the states those wanted, (states, signals)
        real(dp), intent(out) :: values(:, :)           !! signals^T p, (signals, samples)

        real(dp) :: later(process%n, size(epoch))       ! r before the sample
        real(dp) :: noise(process%n, process%n), state(process%n)
        real(dp), allocatable :: between(:, :)          ! r before every epoch from one sample to the next
        integer :: i, k, steps

        do i = size(epoch), 1, -1
            later(:, i) = 0
            if (i < size(epoch)) then
                later(:, i) = later(:, i + 1)
                do k = epoch(i) + 1, epoch(i + 1)
                    later(:, i) = matmul(later(:, i), process%transition)
                end do
            end if
            if (kept(i)) later(:, i) = later(:, i) + process%output*errors(i)
        end do
        noise = process%noise
        state = matmul(process%covariance, later(:, 1))
        values(:, 1) = matmul(state, signals)
        do i = 2, size(epoch)
            steps = epoch(i) - epoch(i - 1)
            if (allocated(between)) then
                if (size(between, 2) /= steps) deallocate (between)
            end if
            if (.not. allocated(between)) allocate (between(process%n, steps))
            between(:, steps) = later(:, i)
            do k = steps - 1, 1, -1
                between(:, k) = matmul(between(:, k + 1), process%transition)
            end do
            do k = 1, steps
                state = matmul(process%transition, state) + matmul(noise, between(:, k))
            end do
            values(:, i) = matmul(state, signals)
        end do
    end subroutine smooth_signals
end module gracecg_estimation_process_smoother
