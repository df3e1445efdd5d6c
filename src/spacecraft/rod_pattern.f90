!> Which rods a manoeuvre drives: the rules of CSR-TM-00-01 section 4.2.
module gracecg_spacecraft_rod_pattern
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: rod_pattern, PATTERN_RULES, AS_DRIVEN

    character(*), parameter :: AS_DRIVEN = 'driven'
    !! No rule: the rods as a case drives them; where it drives none, 'y-z'
    character(8), parameter :: PATTERN_RULES(3) = [character(8) :: 'y-z', 'general', AS_DRIVEN]
    !! The rules of section 4.2 by name: the y and z rods as in the report, or the general one

contains

    !> Which rods to drive, and with what signs, by a rule of CSR-TM-00-01 section 4.2: m_k = 1 (the report leaves the
    !> common sign free), m_j = -m_k sign(B_j B_k), and the third rod rests; sign(0) = 0. By 'y-z', as the end of that
    !> section has it, the x rod rests, so that the x torques of both rods add up; all six printed patterns agree. By
    !> 'general' the rod along the greatest component rests and k is the smallest: near the poles, where the z component
    !> is the greatest, another pattern than the report's own.
    !>
    !> A field that is not finite gives the pattern zero, which new_harmonic_manoeuvre refuses.
    pure function rod_pattern(rule, field) result(pattern)
        character(*), intent(in) :: rule    !! One of PATTERN_RULES
        real(dp), intent(in) :: field(3)    !! Geomagnetic field in body axes at the start, any unit
        integer :: pattern(3)

        integer :: j, k

        pattern = 0
        if (.not. all(ieee_is_finite(field))) return
        k = 3
        if (rule == 'general') k = minloc(abs(field), 1, back=.true.)      ! the last one, to differ from the greatest in ties
        j = 2
        if (rule == 'general') j = 6 - k - maxloc(abs(field), 1)
        pattern(k) = 1
        pattern(j) = -signum(field(j))*signum(field(k))
    end function rod_pattern

    pure integer function signum(x)
        real(dp), intent(in) :: x

        signum = merge(1, 0, x > 0) - merge(1, 0, x < 0)
    end function signum
end module gracecg_spacecraft_rod_pattern
