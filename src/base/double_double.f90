!> Products and powers of ten with twice the digits of double precision: a number is the sum of two.
!>
!> The exact product is T. J. Dekker's, Numer. Math. 18 (1971) 224-242.
module gracecg_base_double_double
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: exact_product, exact_power, POWER, EXACT_TENS, MOST_TENS

    integer, parameter :: EXACT_TENS = 22   !! Largest power of ten that is exact in double precision
    integer, parameter :: MOST_TENS = 45    !! Largest that is exact as a sum of two
    real(dp), parameter :: SPLITTER = 2.0_dp**27 + 1    ! of Dekker's product
    !> The powers of ten that are exact
    real(dp), parameter :: POWER(0:EXACT_TENS) = [1e0_dp, 1e1_dp, 1e2_dp, 1e3_dp, 1e4_dp, 1e5_dp, 1e6_dp, 1e7_dp, 1e8_dp, &
                                                  1e9_dp, 1e10_dp, 1e11_dp, 1e12_dp, 1e13_dp, 1e14_dp, 1e15_dp, 1e16_dp, &
                                                  1e17_dp, 1e18_dp, 1e19_dp, 1e20_dp, 1e21_dp, 1e22_dp]

contains

    !> 10^n as large + small, exactly.
    pure subroutine exact_power(n, large, small)
        integer, intent(in) :: n        !! 0 to MOST_TENS
        real(dp), intent(out) :: large, small    !! Leading part and what is left

        real(dp) :: product, error, more

        if (n <= EXACT_TENS) then
            large = POWER(n)
            small = 0
        else if (n <= 2*EXACT_TENS) then
            call exact_product(POWER(EXACT_TENS), POWER(n - EXACT_TENS), large, small)
        else
            call exact_product(POWER(EXACT_TENS), POWER(EXACT_TENS), product, error)
            call exact_product(product, POWER(n - 2*EXACT_TENS), large, more)
            small = more + error*POWER(n - 2*EXACT_TENS)
        end if
    end subroutine exact_power

    !> a b = product + error, exactly.
    pure subroutine exact_product(a, b, product, error)
        real(dp), intent(in) :: a, b    !! Factors
        real(dp), intent(out) :: product, error    !! Rounded product and what rounding left

        real(dp) :: a1, a2, b1, b2

        product = a*b
        a1 = SPLITTER*a
        a1 = a1 - (a1 - a)
        a2 = a - a1
        b1 = SPLITTER*b
        b1 = b1 - (b1 - b)
        b2 = b - b1
        error = (((a1*b1 - product) + a1*b2) + a2*b1) + a2*b2
    end subroutine exact_product
end module gracecg_base_double_double
