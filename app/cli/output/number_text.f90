!> Numbers as the pages and the tables of the commands show them.
module gracecg_cli_number_text
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: fixed_text, decimal_exponent, percent_text

contains

    !> A number with a fixed count of decimals, 0 before the point; with an exponent from a million on.
    function fixed_text(value, decimals) result(text)
        real(dp), intent(in) :: value           !! Any
        integer, intent(in) :: decimals         !! Digits behind the point, 0 and more
        character(:), allocatable :: text

        character(40) :: digits
        character(12) :: form

        write (form, '(a, i0, a)') '(f40.', decimals, ')'
        if (abs(value) >= 1e6_dp) form = '(es40.3)'
        write (digits, form) value
        text = trim(adjustl(digits))
        if (text(len(text):) == '.') text = text(:len(text) - 1)
        if (text(1:1) == '.') text = '0'//text
        if (index(text, '-.') == 1) text = '-0'//text(2:)
        if (text(1:1) == '-' .and. verify(text, '-0.') == 0) text = text(2:)
    end function fixed_text

    !> The power of ten of a number: floor(log10(abs(value))), 0 for 0.
    pure integer function decimal_exponent(value) result(exponent)
        real(dp), intent(in) :: value           !! Any

        exponent = 0
        if (abs(value) > 0) exponent = floor(log10(abs(value)*(1 + 1e-12_dp)))
    end function decimal_exponent

    !> A part of 1 as '12.3 %'.
    function percent_text(part) result(text)
        real(dp), intent(in) :: part            !! Of 1
        character(:), allocatable :: text

        text = fixed_text(100*part, 1)//' %'
    end function percent_text
end module gracecg_cli_number_text
