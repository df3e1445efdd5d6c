!> Places in increasing numbers, such as the times of a series.
module gracecg_base_increasing_numbers
    use gracecg_base_kinds, only: dp, i8
    implicit none
    private
    public :: last_not_after

    !> How many of increasing numbers are not greater than x, by bisection.
    interface last_not_after
        module procedure last_real_not_after, last_integer_not_after
    end interface last_not_after

contains

    pure integer function last_real_not_after(numbers, x) result(low)
        real(dp), intent(in) :: numbers(:), x       !! Increasing; both in one unit

        integer :: high, middle

        low = 0
        high = size(numbers) + 1
        do while (high - low > 1)
            middle = (low + high)/2
            if (numbers(middle) <= x) then
                low = middle
            else
                high = middle
            end if
        end do
    end function last_real_not_after

    pure integer function last_integer_not_after(numbers, x) result(low)
        integer(i8), intent(in) :: numbers(:), x    !! Increasing; both in one unit

        integer :: high, middle

        low = 0
        high = size(numbers) + 1
        do while (high - low > 1)
            middle = (low + high)/2
            if (numbers(middle) <= x) then
                low = middle
            else
                high = middle
            end if
        end do
    end function last_integer_not_after
end module gracecg_base_increasing_numbers
