!> Statistics of samples, and limits to judge them by: of generated noise and of residuals.
!>
!> Limits are for a confidence of 99.9 %: what follows the hypothesis exceeds them with a
!> probability of 0.001.
module statistics
    use, intrinsic :: iso_fortran_env, only: dp => real64
    implicit none
    private
    public :: Z_999, mean, variance, correlation, chi_square_limits, ljung_box

    real(dp), parameter :: Z_999 = 3.2905_dp    !! Two-sided 99.9 % point of the normal distribution

contains

    pure real(dp) function mean(x)
        real(dp), intent(in) :: x(:)

        mean = sum(x)/size(x)
    end function mean

    !> About the sample's mean.
    pure real(dp) function variance(x)
        real(dp), intent(in) :: x(:)

        variance = sum((x - mean(x))**2)/(size(x) - 1)
    end function variance

    pure real(dp) function correlation(x, y)
        real(dp), intent(in) :: x(:), y(:)

        correlation = sum((x - mean(x))*(y - mean(y)))/ &
            sqrt(sum((x - mean(x))**2)*sum((y - mean(y))**2))
    end function correlation

    !> Two-sided 99.9 % limits of a chi-square variable (E. B. Wilson, M. M. Hilferty, Proc. Nat.
    !> Acad. Sci. 17 (1931) 684-688).
    pure function chi_square_limits(degrees_of_freedom) result(limits)
        integer, intent(in) :: degrees_of_freedom
        real(dp) :: limits(2)

        real(dp) :: v

        v = 2.0_dp/(9.0_dp*degrees_of_freedom)
        limits = degrees_of_freedom*(1 - v + [-Z_999, Z_999]*sqrt(v))**3
    end function chi_square_limits

    !> Whiteness of a record: chi-square with `lags` degrees of freedom (G. M. Ljung, G. E. P. Box,
    !> Biometrika 65 (1978) 297-303).
    pure real(dp) function ljung_box(x, lags) result(statistic)
        real(dp), intent(in) :: x(:)
        integer, intent(in) :: lags
        real(dp) :: centred(size(x)), r
        integer :: k, n

        n = size(x)
        centred = x - mean(x)
        statistic = 0
        do k = 1, lags
            r = dot_product(centred(:n - k), centred(k + 1:))/dot_product(centred, centred)
            statistic = statistic + r**2/(n - k)
        end do
        statistic = statistic*n*(n + 2.0_dp)
    end function ljung_box
end module statistics
