!> Isolated spikes in a smooth series, found before anything is fitted to it: F. R. Hampel's
!> identifier in a moving window (R. K. Pearson, IEEE Trans. Control Systems Technology 10 (2002)
!> 55-63). A median does not care how far a few samples are off.
module gracecg_estimation_spike_screen
    use gracecg_base_kinds, only: dp
    use gracecg_base_statistics, only: median_of
    implicit none
    private
    public :: is_spike

    integer, parameter :: HALF_WINDOW = 5               !! Samples on either side
    real(dp), parameter :: MAD_TO_SIGMA = 1.4826_dp     !! Of the median absolute deviation, normal distribution

contains

    !> True for the samples that lie farther from the median of their neighbourhood than `limit` times
    !> the larger of sigma and the spread of all such distances.
    pure function is_spike(values, sigma, limit) result(spike)
        real(dp), intent(in) :: values(:)    !! A series in the order of time
        real(dp), intent(in) :: sigma               !! Noise of a sample
        real(dp), intent(in) :: limit    !! In standard deviations
        logical :: spike(size(values))

        real(dp) :: distance(size(values))
        integer :: i, n

        n = size(values)
        do i = 1, n
            distance(i) = values(i) - median_of(values(max(1, i - HALF_WINDOW):min(n, i + HALF_WINDOW)))
        end do
        spike = abs(distance) > limit*max(sigma, MAD_TO_SIGMA*median_of(abs(distance)))
    end function is_spike
end module gracecg_estimation_spike_screen
