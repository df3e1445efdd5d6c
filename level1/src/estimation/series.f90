!> Series of samples in order of time: interpolation, and integrals.
module gracecg_level1_series
    use gracecg_base_kinds, only: dp
    use gracecg_base_increasing_numbers, only: last_not_after
    implicit none
    private
    public :: interpolate, hold, integrate_twice

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

    !> The last sample at or before a time; before the first one that one.
    pure function hold(times, values, time) result(value)
        real(dp), intent(in) :: times(:)        !! Rising, s; at least one
        real(dp), intent(in) :: values(:, :)    !! Component, sample
        real(dp), intent(in) :: time            !! s
        real(dp) :: value(size(values, 1))

        value = values(:, max(1, last_not_after(times, time)))
    end function hold

    !> The double integral of samples at equal steps by trapezoids; it and its rate begin at 0.
    pure subroutine integrate_twice(step, values, twice)
        real(dp), intent(in) :: step            !! s
        real(dp), intent(in) :: values(:)    !! At equal steps
        real(dp), intent(out) :: twice(:)    !! Their integral of the integral, 0 at the first

        real(dp) :: once, before
        integer :: i

        once = 0
        twice(1) = 0
        do i = 2, size(values)
            before = once
            once = once + step*(values(i - 1) + values(i))/2
            twice(i) = twice(i - 1) + step*(before + once)/2
        end do
    end subroutine integrate_twice
end module gracecg_level1_series
