!> Where an axis ends that a plotting program chose by itself.
!>
!> The axes of CSR-TM-00-01 end at tick marks, 2 to 4 intervals of 1, 2 or 5 times a power of ten. A printed axis
!> therefore says more than that its curve stayed inside: the curve reached into the first and into the last
!> interval.
module gracecg_studies_axis_ticks
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: limits_on_ticks, same_limits, share_covered

    real(dp), parameter :: ROUNDING = 1e-9_dp   !! Of a step: so near to a mark counts as on it

contains

    !> The tick marks next outside a curve: the limits of an axis that ends at tick marks.
    pure function limits_on_ticks(least, greatest, step) result(limits)
        real(dp), intent(in) :: least, greatest     !! Of the curve
        real(dp), intent(in) :: step                !! Distance of the tick marks, same unit, positive
        real(dp) :: limits(2)

        real(dp) :: low, high

        low = least/step
        high = greatest/step
        limits = step*[marks_below(low), -marks_below(-high)]
    end function limits_on_ticks

    !> The tick mark at or below a number of steps.
    pure real(dp) function marks_below(steps) result(mark)
        real(dp), intent(in) :: steps

        mark = anint(steps)
        if (mark > steps + ROUNDING) mark = mark - 1
    end function marks_below

    !> Whether two axes end at the same tick marks.
    pure logical function same_limits(a, b, step) result(same)
        real(dp), intent(in) :: a(2), b(2)          !! Lower and upper limits
        real(dp), intent(in) :: step                !! Distance of the tick marks, same unit

        same = all(abs(a - b) < step/1000)
    end function same_limits

    !> The share of an axis that its curve covers: 1 when it reaches both ends or beyond.
    pure real(dp) function share_covered(least, greatest, low, high) result(share)
        real(dp), intent(in) :: least, greatest     !! Of the curve
        real(dp), intent(in) :: low, high           !! Limits of the axis

        share = max(0.0_dp, min(greatest, high) - max(least, low))/(high - low)
    end function share_covered
end module gracecg_studies_axis_ticks
