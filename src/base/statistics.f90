!> The median of numbers, and how an RMS scatters.
module gracecg_base_statistics
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: median_of, sampling_error

contains

    !> Relative standard deviation of the RMS of so many normal numbers of mean 0.
    elemental real(dp) function sampling_error(count)
        integer, intent(in) :: count            !! At least one

        sampling_error = 1/sqrt(2.0_dp*count)
    end function sampling_error

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
end module gracecg_base_statistics
