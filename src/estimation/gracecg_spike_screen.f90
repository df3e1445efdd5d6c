!> Isolated spikes in a smooth series, found before anything is fitted to it: F. R. Hampel's
!> identifier in a moving window (R. K. Pearson, IEEE Trans. Control Systems Technology 10 (2002)
!> 55-63). A median does not care how far a few samples are off.
module gracecg_spike_screen
    use gracecg_kinds, only: dp
    implicit none
    private
    public :: is_spike, median_of

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

    !> The median: the mean of the middle two of an even number.
    pure real(dp) function median_of(values) result(median)
        real(dp), intent(in) :: values(:)    !! At least one

        real(dp) :: sorted(size(values))
        integer :: n

        n = size(values)
        sorted = values
        call sort(sorted)
        median = (sorted((n + 1)/2) + sorted(n/2 + 1))/2
    end function median_of

    !> Heap sort.
    pure subroutine sort(a)
        real(dp), intent(inout) :: a(:)

        real(dp) :: held
        integer :: i, n

        n = size(a)
        do i = n/2, 1, -1
            call sift(a, i)
        end do
        do i = n, 2, -1
            held = a(i)
            a(i) = a(1)
            a(1) = held
            call sift(a(:i - 1), 1)
        end do
    end subroutine sort

    !> Lets an element sink to its place in the heap.
    pure subroutine sift(a, first)
        real(dp), intent(inout) :: a(:)
        integer, intent(in) :: first

        real(dp) :: moved
        integer :: parent, child

        parent = first
        moved = a(parent)
        do
            child = 2*parent
            if (child > size(a)) exit
            if (child < size(a)) then
                if (a(child + 1) > a(child)) child = child + 1
            end if
            if (.not. a(child) > moved) exit
            a(parent) = a(child)
            parent = child
        end do
        a(parent) = moved
    end subroutine sift
end module gracecg_spike_screen
