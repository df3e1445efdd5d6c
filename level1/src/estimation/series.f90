!> Series of samples in order of time: interpolation.
module gracecg_level1_series
    use gracecg_base_kinds, only: dp
    use gracecg_base_increasing_numbers, only: last_not_after
    implicit none
    private
    public :: interpolate

contains

    !> Vectors between their samples, by the cubic through the four nearest (fewer where there are not so many), and
    !> their rate. Beyond the ends the same polynomials go on.
    pure subroutine interpolate(times, values, time, value, rate)
        real(dp), intent(in) :: times(:)            !! Rising, s; at least one
        real(dp), intent(in) :: values(:, :)        !! Component, sample
        real(dp), intent(in) :: time                !! s
        real(dp), intent(out) :: value(:)           !! At that time
        real(dp), intent(out), optional :: rate(:)  !! Its derivative, 1/s

        real(dp) :: weight, slope, term
        integer :: first, last, i, j, k

        first = max(1, min(last_not_after(times, time) - 1, size(times) - 3))
        last = min(size(times), first + 3)
        value = 0
        if (present(rate)) rate = 0
        do i = first, last
            weight = 1
            do j = first, last
                if (j /= i) weight = weight*(time - times(j))/(times(i) - times(j))
            end do
            value = value + weight*values(:, i)
            if (.not. present(rate)) cycle
            slope = 0
            do k = first, last
                if (k == i) cycle
                term = 1/(times(i) - times(k))
                do j = first, last
                    if (j /= i .and. j /= k) term = term*(time - times(j))/(times(i) - times(j))
                end do
                slope = slope + term
            end do
            rate = rate + slope*values(:, i)
        end do
    end subroutine interpolate
end module gracecg_level1_series
