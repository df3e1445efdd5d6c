!> Whether the compiler's flags left the arithmetic what this project counts on (IEEE 754): infinities and NaN can be
!> told from numbers, numbers below `tiny` are not taken for zero, and a sum that was rounded is not put right
!> (`gracecg_base_decimal` lives on what rounding leaves).
!>
!> Flags such as `-ffast-math` let a compiler take it that there is no NaN. Then a test for it is no test: what is not
!> a number would be read, and handed out as a result.
module gracecg_base_arithmetic
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_is_finite
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, fail
    implicit none
    private
    public :: check_arithmetic

contains

    !> Fails where this file was compiled with flags that break the arithmetic.
    subroutine check_arithmetic(error)
        type(error_t), allocatable, intent(out) :: error

        ! Read anew at each use: what the compiler does not know it cannot work out beforehand
        real(dp), volatile :: not_a_number, infinity, smallest, small
        real(dp) :: a, b, total

        not_a_number = transfer(int(z'7FF8000000000000', i8), 1.0_dp)
        infinity = transfer(int(z'7FF0000000000000', i8), 1.0_dp)
        smallest = tiny(1.0_dp)
        smallest = smallest/2
        small = epsilon(1.0_dp)/8
        b = small
        small = 1
        a = small
        total = a + b
        if (.not. ieee_is_nan(not_a_number) .or. not_a_number <= 0 .or. not_a_number > 0 .or. &
            ieee_is_finite(infinity) .or. ieee_is_finite(not_a_number)) then
            call fail(error, 'gracecg was compiled with a flag such as -ffast-math or -ffinite-math-only, which makes '// &
                      'numbers of what are none: compile it without')
        else if (.not. smallest > 0) then
            call fail(error, 'gracecg runs with numbers below 2e-308 taken for zero, as -ffast-math and -Ofast have it: '// &
                      'compile and link it without')
        else if (total - a < 0 .or. total - a > 0) then
            call fail(error, 'gracecg was compiled with a flag such as -ffast-math or -fassociative-math, which puts '// &
                      'rounded sums in another order: compile it without')
        end if
    end subroutine check_arithmetic
end module gracecg_base_arithmetic
