!> Numbers as the pages and the tables of the commands show them.
module gracecg_cli_number_text
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: integer_text
    implicit none
    private
    public :: fixed_text, scaled_text, decimal_exponent, percent_text, share_text, pick_text

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

    !> A number without its power of ten.
    function scaled_text(value, exponent, decimals) result(text)
        real(dp), intent(in) :: value           !! Any
        integer, intent(in) :: exponent         !! Of the power of ten that is taken out
        integer, intent(in) :: decimals         !! Digits behind the point, 0 and more
        character(:), allocatable :: text

        text = fixed_text(value/10.0_dp**exponent, decimals)
    end function scaled_text

    !> The power of ten of a number: floor(log10(abs(value))), 0 for 0.
    pure integer function decimal_exponent(value) result(exponent)
        real(dp), intent(in) :: value           !! Any

        exponent = 0
        if (abs(value) > 0) exponent = floor(log10(abs(value)*(1 + 1e-12_dp)))
    end function decimal_exponent

    !> One of two texts.
    pure function pick_text(condition, if_true, if_false) result(text)
        logical, intent(in) :: condition                !! Which of the two
        character(*), intent(in) :: if_true, if_false   !! The two
        character(:), allocatable :: text

        if (condition) then
            text = if_true
        else
            text = if_false
        end if
    end function pick_text

    !> A part of 1 as '12.3 %'.
    function percent_text(part) result(text)
        real(dp), intent(in) :: part            !! Of 1
        character(:), allocatable :: text

        text = fixed_text(100*part, 1)//' %'
    end function percent_text

    !> Counts as '3 of 4'.
    function share_text(part, whole) result(text)
        integer, intent(in) :: part, whole      !! Counts
        character(:), allocatable :: text

        text = integer_text(part)//' of '//integer_text(whole)
    end function share_text
end module gracecg_cli_number_text
