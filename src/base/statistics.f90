!> The median and the order of numbers, how an RMS scatters, quantiles of the normal and tails of the chi-square distribution.
module gracecg_base_statistics
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: median_of, sort, order_of, sampling_error, normal_quantile, chi_square_tail

contains

    !> Relative standard deviation of the RMS of so many normal numbers of mean 0.
    elemental real(dp) function sampling_error(count)
        integer, intent(in) :: count            !! At least one

        sampling_error = 1/sqrt(2.0_dp*count)
    end function sampling_error

    !> The number below which a standard normal variable lies with a probability: the root of
    !> erfc(-z/sqrt(2))/2 = p by Newton's method, on the smaller of the two tails.
    elemental real(dp) function normal_quantile(probability) result(z)
        real(dp), intent(in) :: probability     !! Between 0 and 1

        real(dp), parameter :: ROOT_TWO = sqrt(2.0_dp), ROOT_TWO_PI = sqrt(8*atan(1.0_dp))
        integer, parameter :: MOST = 100
        real(dp) :: tail, step
        integer :: i

        tail = min(probability, 1 - probability)
        z = 0
        if (.not. tail > tiny(1.0_dp)) then
            z = huge(1.0_dp)
        else
            do i = 1, MOST          ! from 0 upwards: the tail is convex there, so no step goes too far
                step = (erfc(z/ROOT_TWO)/2 - tail)*ROOT_TWO_PI*exp(z**2/2)
                z = z + step
                if (abs(step) <= 1e-14_dp*max(1.0_dp, z)) exit
            end do
        end if
        if (probability < 0.5_dp) z = -z
    end function normal_quantile

    !> The probability that a chi-square variable exceeds a value: from one degree of freedom, erfc(sqrt(x/2)), or two,
    !> exp(-x/2), upwards by Q(k + 2) = Q(k) + (x/2)^(k/2) exp(-x/2)/Gamma(k/2 + 1).
    pure real(dp) function chi_square_tail(x, degrees) result(tail)
        real(dp), intent(in) :: x           !! The value
        integer, intent(in) :: degrees      !! Of freedom, at least one

        integer :: k

        tail = 1
        if (.not. x > 0) return
        if (mod(degrees, 2) == 1) then
            tail = erfc(sqrt(x/2))
        else
            tail = exp(-x/2)
        end if
        do k = merge(1, 2, mod(degrees, 2) == 1), degrees - 2, 2
            tail = tail + exp(k/2.0_dp*log(x/2) - x/2 - log_gamma(k/2.0_dp + 1))
        end do
        tail = min(1.0_dp, tail)
    end function chi_square_tail

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

    !> Shell's sort: D. L. Shell, Commun. ACM 2 (1959) 30-32.
    pure subroutine sort(a)
        real(dp), intent(inout) :: a(:)     !! In any order; then increasing

        real(dp) :: held
        integer :: gap, i, k

        gap = size(a)
        do while (gap > 1)
            gap = max(1, int(gap/2.2_dp))
            do i = gap + 1, size(a)
                held = a(i)
                k = i - gap
                do while (k >= 1)
                    if (.not. a(k) > held) exit
                    a(k + gap) = a(k)
                    k = k - gap
                end do
                a(k + gap) = held
            end do
        end do
    end subroutine sort

    !> The places of numbers by their size, the least first; of equals the first. By halves that are merged.
    pure recursive function order_of(values) result(order)
        real(dp), intent(in) :: values(:)    !! Any unit
        integer :: order(size(values))

        integer :: halves(size(values)), i, k, n, half
        logical :: of_second

        n = size(values)
        half = n/2
        order = [(i, i=1, n)]
        if (n < 2) return
        halves = [order_of(values(:half)), half + order_of(values(half + 1:))]
        i = 1
        k = half + 1
        do while (i <= half)
            of_second = k <= n
            if (of_second) of_second = values(halves(k)) < values(halves(i))
            order(i + k - half - 1) = halves(merge(k, i, of_second))
            if (of_second) k = k + 1
            if (.not. of_second) i = i + 1
        end do
        order(k:) = halves(k:)
    end function order_of
end module gracecg_base_statistics
