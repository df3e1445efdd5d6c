!> What can go wrong, said so that a person can mend it.
!>
!> Every fallible procedure has `type(error_t), allocatable, intent(out) :: error`: not allocated
!> means success. The library never stops and never prints. A message is one or more lines: what is
!> wrong and where (file, line, key, value), what is allowed, and what to do.
module gracecg_base_error
    use gracecg_base_kinds, only: dp
    use gracecg_base_text, only: integer_text, join, real_field, LONGEST_REAL
    implicit none
    private
    public :: error_t, fail, fail_in_file, fail_out_of_range, require_range, fail_unknown_name
    public :: add_context, message_of, nearest_name, number_text

    !> Of a message about a file and of the line that it shows, characters: a file that is none may have one line of
    !> many megabytes
    integer, parameter :: LONGEST_MESSAGE = 2000, LONGEST_LINE = 300
    character(*), parameter :: CUT_OFF = ' ...'

    type :: error_t
        !! One failure
        character(:), allocatable :: message    !! Complete sentences; lines end with new_line('a')
    end type error_t

contains

    !> Allocates `error` with a message.
    subroutine fail(error, message)
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in) :: message !! A sentence for the user

        allocate (error)
        error%message = message
    end subroutine fail

    !> A failure at a place in a text file; shows the line itself.
    subroutine fail_in_file(error, file, line_number, message, line)
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in) :: file            !! Path as the user gave it
        integer, intent(in) :: line_number          !! Counted from 1; 0 when no line applies
        character(*), intent(in) :: message         !! What is wrong there
        character(*), intent(in), optional :: line  !! The offending line

        character(:), allocatable :: place

        place = file
        if (line_number > 0) place = file//':'//integer_text(line_number)
        call fail(error, place//': '//shortened(message, LONGEST_MESSAGE))
        if (present(line)) error%message = error%message//new_line('a')//'  | '//shortened(trim(line), LONGEST_LINE)
    end subroutine fail_in_file

    pure integer function shown_length(text, longest) result(length)
        character(*), intent(in) :: text
        integer, intent(in) :: longest

        length = len(text)
        if (length > longest) length = longest + len(CUT_OFF)
    end function shown_length

    !> A text as a message shows it: what is longer than `longest` is cut off.
    pure function shortened(text, longest) result(shown)
        character(*), intent(in) :: text
        integer, intent(in) :: longest      !! Characters
        character(shown_length(text, longest)) :: shown

        shown = text
        if (len(text) > longest) shown(longest + 1:) = CUT_OFF
    end function shortened

    !> A number outside its allowed range.
    subroutine fail_out_of_range(error, name, value, low, high, unit)
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in) :: name            !! Name of the quantity, as the user knows it
        real(dp), intent(in) :: value               !! As it was given
        real(dp), intent(in) :: low, high           !! The allowed range, both ends included
        character(*), intent(in), optional :: unit  !! Of value and range

        character(:), allocatable :: suffix

        suffix = ''
        if (present(unit)) then
            if (len_trim(unit) > 0) suffix = ' '//trim(unit)
        end if
        call fail(error, name//' = '//number_text(value)//suffix// &
                  ' is outside the allowed range '//number_text(low)//' to '// &
                  number_text(high)//suffix)
    end subroutine fail_out_of_range

    !> Sets `error`, unless it is set already, when a number (NaN too) is outside a range.
    subroutine require_range(name, value, allowed, unit, error)
        character(*), intent(in) :: name        !! Of the quantity, as the user knows it
        real(dp), intent(in) :: value           !! As it was given
        real(dp), intent(in) :: allowed(2)      !! Both ends included
        character(*), intent(in) :: unit        !! Of value and range; may be empty
        type(error_t), allocatable, intent(inout) :: error

        if (allocated(error)) return
        if (value >= allowed(1) .and. value <= allowed(2)) return
        call fail_out_of_range(error, name, value, allowed(1), allowed(2), unit)
    end subroutine require_range

    !> A name that stands for nothing known.
    subroutine fail_unknown_name(error, what, name, known)
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in) :: what, name  !! The kind of thing; as it was given
        character(*), intent(in) :: known(:)    !! The names there are

        character(:), allocatable :: near

        call fail(error, what//': "'//name//'" is not known; there are '//join(known, ', '))
        near = nearest_name(name, known)
        if (near /= '') error%message = error%message//'; did you mean "'//near//'"?'
    end subroutine fail_unknown_name

    !> Puts `context: ` before the message of an error that is set and does not begin so.
    subroutine add_context(error, context)
        type(error_t), allocatable, intent(inout) :: error
        character(*), intent(in) :: context !! What was being done or read

        if (.not. allocated(error)) return
        if (index(error%message, context//': ') /= 1) error%message = context//': '//error%message
    end subroutine add_context

    pure integer function message_length(error) result(length)
        type(error_t), allocatable, intent(in) :: error

        length = 0
        if (allocated(error)) length = len(error%message)
    end function message_length

    !> The message of an error, or an empty text when there is none.
    pure function message_of(error) result(message)
        type(error_t), allocatable, intent(in) :: error
        character(message_length(error)) :: message

        if (allocated(error)) message = error%message
    end function message_of

    !> What number_text gives, with blanks behind it.
    pure function number_field(value) result(field)
        real(dp), intent(in) :: value
        character(LONGEST_REAL) :: field

        real(dp), parameter :: MILLION = 1e6_dp

        if (abs(value) < 1e7_dp .and. abs(value - anint(value)) <= 0) then
            field = integer_text(nint(value))
        else if (abs(value) >= 1e-3_dp .and. abs(value) < 1e5_dp) then
            field = real_field(anint(value*MILLION)/MILLION)
        else
            write (field, merge('(es15.6e3)', '(es14.6)  ', abs(log10(max(abs(value), tiny(value)))) >= 99)) value
            field = adjustl(field)
        end if
    end function number_field

    !> The shortest text that shows a number to about seven digits, without padding.
    pure function number_text(value) result(text)
        real(dp), intent(in) :: value   !! May be NaN or infinite
        character(len_trim(number_field(value))) :: text

        text = number_field(value)
    end function number_text

    !> What nearest_name gives, with blanks behind it.
    pure function nearest_field(name, known) result(nearest)
        character(*), intent(in) :: name
        character(*), intent(in) :: known(:)
        character(len(known)) :: nearest

        integer :: i, distance, best

        nearest = ''
        best = max(1, min(2, len_trim(name)/2))     ! letters that may differ
        do i = 1, size(known)
            distance = edit_distance(trim(name), trim(known(i)))
            if (distance <= best) then
                best = distance - 1
                nearest = known(i)
            end if
        end do
    end function nearest_field

    !> The name of a list that is nearest to a misspelt one (Levenshtein distance), or an empty text
    !> when none is near: for "did you mean".
    pure function nearest_name(name, known) result(nearest)
        character(*), intent(in) :: name        !! As it was written
        character(*), intent(in) :: known(:)    !! Names to compare with
        character(len_trim(nearest_field(name, known))) :: nearest

        nearest = nearest_field(name, known)
    end function nearest_name

    !> Levenshtein distance: insertions, deletions and replacements that turn `a` into `b`.
    pure integer function edit_distance(a, b) result(distance)
        character(*), intent(in) :: a, b

        integer :: row(0:len(b)), i, j, diagonal, above

        row = [(j, j=0, len(b))]
        do i = 1, len(a)
            diagonal = row(0)
            row(0) = i
            do j = 1, len(b)
                above = row(j)
                row(j) = min(above + 1, row(j - 1) + 1, diagonal + merge(0, 1, a(i:i) == b(j:j)))
                diagonal = above
            end do
        end do
        distance = row(len(b))
    end function edit_distance
end module gracecg_base_error
