!> A value given as text by a person (in a case file or on the command line), made a number or a
!> choice and checked against what is allowed. A failure is a sentence, `problem`, that says what
!> the value is and what it must be; the caller puts the place before it.
module gracecg_files_value
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: nearest_name
    use gracecg_base_text, only: lower_case, join, parse_real, parse_integer, real_text, integer_text
    implicit none
    private
    public :: real_from_text, integer_from_text, logical_from_text, choice_from_text
    public :: allowed_real, allowed_integer, allowed_choice, did_you_mean

    integer, parameter :: LONGEST_RANGE = 160   !! Three words of real_text, and a unit

contains

    !> A finite number within a range, both ends included.
    subroutine real_from_text(text, value, problem, low, high, unit)
        character(*), intent(in) :: text                        !! As written
        real(dp), intent(out) :: value                          !! 0 when there is a problem
        character(:), allocatable, intent(out) :: problem       !! Not allocated: all is well
        real(dp), intent(in), optional :: low, high             !! Allowed range, in `unit`
        character(*), intent(in), optional :: unit              !! For the message

        logical :: ok

        call parse_real(text, value, ok)
        if (.not. ok) then
            problem = '"'//text//'" is not a finite number; it must be '// &
                      trim(allowed_real(low, high, unit))
            return
        end if
        if (present(low)) ok = value >= low
        if (present(high)) ok = ok .and. value <= high
        if (.not. ok) problem = text//' is outside the allowed range; it must be '// &
                                trim(allowed_real(low, high, unit))
        if (.not. ok) value = 0
    end subroutine real_from_text

    !> An integer within a range, both ends included.
    subroutine integer_from_text(text, value, problem, low, high)
        character(*), intent(in) :: text                        !! As written
        integer, intent(out) :: value                           !! 0 when there is a problem
        character(:), allocatable, intent(out) :: problem       !! Not allocated: all is well
        integer, intent(in), optional :: low, high              !! Allowed range

        logical :: ok

        call parse_integer(text, value, ok)
        if (.not. ok) then
            problem = '"'//text//'" is not an integer; it must be '//trim(allowed_integer(low, high))
            return
        end if
        if (present(low)) ok = value >= low
        if (present(high)) ok = ok .and. value <= high
        if (.not. ok) problem = text//' is outside the allowed range; it must be '// &
                                trim(allowed_integer(low, high))
        if (.not. ok) value = 0
    end subroutine integer_from_text

    !> .true., .t., true or t, and likewise for false.
    subroutine logical_from_text(text, value, problem)
        character(*), intent(in) :: text                        !! As written
        logical, intent(out) :: value                           !! False when there is a problem
        character(:), allocatable, intent(out) :: problem       !! Not allocated: all is well

        value = .false.
        select case (lower_case(text))
        case ('.true.', '.t.', 'true', 't')
            value = .true.
        case ('.false.', '.f.', 'false', 'f')
            value = .false.
        case default
            problem = '"'//text//'" is not a logical; it must be .true. or .false.'
        end select
    end subroutine logical_from_text

    !> One of the allowed texts, in whatever case it is given; `value` has the spelling of the list.
    subroutine choice_from_text(text, choices, value, problem)
        character(*), intent(in) :: text                        !! As written
        character(*), intent(in) :: choices(:)                  !! What is allowed
        character(:), allocatable, intent(out) :: value         !! One of `choices`
        character(:), allocatable, intent(out) :: problem       !! Not allocated: all is well

        integer :: i

        value = ''
        do i = 1, size(choices)
            if (lower_case(text) /= lower_case(choices(i))) cycle
            value = trim(choices(i))
            return
        end do
        problem = '"'//text//'" is not known; it must be '//allowed_choice(choices)// &
                  did_you_mean(text, choices)
    end subroutine choice_from_text

    !> What a real number must be: 'a number from 0 to 10 kg', with blanks behind it.
    function allowed_real(low, high, unit) result(text)
        real(dp), intent(in), optional :: low, high !! Allowed range, in `unit`
        character(*), intent(in), optional :: unit  !! For the message
        character(LONGEST_RANGE) :: text

        text = 'a number'
        if (present(low) .and. present(high)) then
            text = 'a number from '//real_text(low)//' to '//real_text(high)
        else if (present(low)) then
            text = 'a number of at least '//real_text(low)
        else if (present(high)) then
            text = 'a number of at most '//real_text(high)
        end if
        if (.not. present(unit)) return
        if (present(low) .or. present(high)) then
            text = trim(text)//' '//unit
        else
            text = trim(text)//' in '//unit
        end if
    end function allowed_real

    !> What an integer must be: 'an integer from 1 to 60', with blanks behind it.
    function allowed_integer(low, high) result(text)
        integer, intent(in), optional :: low, high  !! Allowed range
        character(LONGEST_RANGE) :: text

        text = 'an integer'
        if (present(low) .and. present(high)) then
            text = 'an integer from '//integer_text(low)//' to '//integer_text(high)
        else if (present(low)) then
            text = 'an integer of at least '//integer_text(low)
        else if (present(high)) then
            text = 'an integer of at most '//integer_text(high)
        end if
    end function allowed_integer

    !> What a text must be: 'one of egm96, file'.
    pure function allowed_choice(choices) result(text)
        character(*), intent(in) :: choices(:)  !! What is allowed
        character(len('one of ') + len(join(choices, ', '))) :: text

        text = 'one of '//join(choices, ', ')
    end function allowed_choice

    !> The hint at a name, with blanks behind it; blank without one.
    pure function hint(nearest) result(text)
        character(*), intent(in) :: nearest
        character(len(nearest) + len('; did you mean ""?')) :: text

        text = ''
        if (nearest /= '') text = '; did you mean "'//nearest//'"?'
    end function hint

    !> '; did you mean "x"?', or nothing when no known name is near.
    pure function did_you_mean(name, known) result(text)
        character(*), intent(in) :: name, known(:)  !! As written; names to compare with
        character(len_trim(hint(nearest_name(lower_case(name), known)))) :: text

        text = hint(nearest_name(lower_case(name), known))
    end function did_you_mean
end module gracecg_files_value
