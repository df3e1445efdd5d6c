!> Small helpers for text: case, splitting, and numbers to and from text.
!>
!> No function of the library returns a text of deferred length (`character(:), allocatable`): gfortran
!> keeps the length of such a result in static memory where the function is called, so that two threads
!> that make texts at once cut each other's short. The length is a function of the arguments instead.
module gracecg_base_text
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp, i4, i8
    use gracecg_base_decimal, only: scan_real, scan_integer, shortest_digits
    implicit none
    private
    public :: string_t, lower_case, split, split_words, append, padded, join, quoted_text, pick_text, share_text
    public :: parse_real, parse_integer, real_text, real_field, LONGEST_REAL, rounded_text, integer_text, logical_text

    type :: string_t
        !! One text of an array of texts of different lengths
        character(:), allocatable :: text   !! Of any length
    end type string_t

    !> parse_integer(text, value, ok): the whole text as a decimal integer of kind i4 or i8.
    interface parse_integer
        module procedure parse_integer_i4
        module procedure parse_integer_i8
    end interface parse_integer

    !> integer_text(value): an integer of kind i4 or i8 without padding.
    interface integer_text
        module procedure integer_text_i4
        module procedure integer_text_i8
    end interface integer_text

    character(*), parameter :: BLANKS = ' '//achar(9), LF = achar(10)
    integer, parameter :: LONGEST_REAL = 32     !! Of real_text: sign, 17 digits, zeros, point, exponent
    integer, parameter :: LONGEST_INTEGER = 20  !! Of integer_text
    character(*), parameter :: ZEROS = '0000000000000000'

contains

    !> The text with the letters A-Z made small.
    pure function lower_case(text) result(lower)
        character(*), intent(in) :: text    !! In any case
        character(len(text)) :: lower

        integer :: i

        lower = text
        do i = 1, len(text)
            select case (text(i:i))
            case ('A':'Z')
                lower(i:i) = achar(iachar(text(i:i)) + 32)
            end select
        end do
    end function lower_case

    !> The pieces between the delimiters, as they stand: always one more than there are delimiters.
    pure function split(text, delimiter) result(pieces)
        character(*), intent(in) :: text        !! Any, blanks included
        character(1), intent(in) :: delimiter   !! One character
        type(string_t), allocatable :: pieces(:)

        integer :: i, n, first

        n = 1
        do i = 1, len(text)
            if (text(i:i) == delimiter) n = n + 1
        end do
        allocate (pieces(n))
        n = 0
        first = 1
        do i = 1, len(text)
            if (text(i:i) /= delimiter) cycle
            n = n + 1
            pieces(n)%text = text(first:i - 1)
            first = i + 1
        end do
        pieces(n + 1)%text = text(first:)
    end function split

    !> The words between blanks and tabs; none of them is empty.
    pure function split_words(text) result(words)
        character(*), intent(in) :: text    !! Any
        type(string_t), allocatable :: words(:)

        integer :: n, first, last

        n = 0
        last = 0
        do
            call next_word(text, last, first)
            if (first == 0) exit
            n = n + 1
        end do
        allocate (words(n))
        last = 0
        do n = 1, size(words)
            call next_word(text, last, first)
            words(n)%text = text(first:last)
        end do
    end function split_words

    !> Finds the word text(first:last) after position `last`; first = 0 when there is none.
    pure subroutine next_word(text, last, first)
        character(*), intent(in) :: text
        integer, intent(inout) :: last
        integer, intent(out) :: first

        integer :: length

        first = verify(text(last + 1:), BLANKS)
        if (first == 0) return
        first = last + first
        length = scan(text(first:), BLANKS) - 1
        if (length < 0) length = len(text) - first + 1
        last = first + length - 1
    end subroutine next_word

    !> Puts one more text at the end.
    pure subroutine append(strings, text)
        type(string_t), allocatable, intent(inout) :: strings(:)
        character(*), intent(in) :: text    !! The one to put there

        type(string_t), allocatable :: longer(:)

        allocate (longer(size(strings) + 1))
        longer(:size(strings)) = strings
        longer(size(longer))%text = text
        call move_alloc(longer, strings)
    end subroutine append

    !> The length of the longest text.
    pure integer function longest_of(strings) result(longest)
        type(string_t), intent(in) :: strings(:)

        integer :: i

        longest = 0
        do i = 1, size(strings)
            longest = max(longest, len(strings(i)%text))
        end do
    end function longest_of

    !> The texts as one array of equal length, padded with blanks.
    pure function padded(strings) result(array)
        type(string_t), intent(in) :: strings(:)
        character(longest_of(strings)) :: array(size(strings))

        integer :: i

        do i = 1, size(strings)
            array(i) = strings(i)%text
        end do
    end function padded

    !> The texts without trailing blanks, one after the other, with `separator` between them.
    pure function join(texts, separator) result(joined)
        character(*), intent(in) :: texts(:), separator !! The pieces, and what stands between them
        character(sum(len_trim(texts)) + max(0, size(texts) - 1)*len(separator)) :: joined

        integer :: i, last

        last = 0
        do i = 1, size(texts)
            if (i > 1) then
                joined(last + 1:last + len(separator)) = separator
                last = last + len(separator)
            end if
            joined(last + 1:last + len_trim(texts(i))) = texts(i)
            last = last + len_trim(texts(i))
        end do
    end function join

    pure integer function quoted_length(text, quote) result(length)
        character(*), intent(in) :: text
        character(1), intent(in) :: quote

        integer :: i

        length = len(text) + 2 + count([(text(i:i) == quote, i=1, len(text))])
    end function quoted_length

    !> A text between quotes, those within it doubled.
    pure function quoted_text(text, quote) result(quoted)
        character(*), intent(in) :: text    !! Any
        character(1), intent(in) :: quote   !! ' or "
        character(quoted_length(text, quote)) :: quoted

        integer :: i, n

        quoted(1:1) = quote
        n = 1
        do i = 1, len(text)
            quoted(n + 1:n + 2) = text(i:i)//quote
            n = n + merge(2, 1, text(i:i) == quote)
        end do
        quoted(n + 1:) = quote
    end function quoted_text

    !> The whole text as a finite number: blanks around it and a D exponent are allowed. Not ok:
    !> empty, anything else than a decimal number, NaN, infinity, a number too large for double
    !> precision.
    pure subroutine parse_real(text, value, ok)
        character(*), intent(in) :: text    !! Blanks around it are allowed
        real(dp), intent(out) :: value      !! 0 when not ok
        logical, intent(out) :: ok          !! False if it is no number

        integer :: first, last, at

        call find_word(text, first, last)
        at = 1
        call scan_real(text(first:last)//LF, at, value, ok)
        ok = ok .and. at == last - first + 2
        if (.not. ok) value = 0
    end subroutine parse_real

    !> The text without the blanks around it is text(first:last).
    pure subroutine find_word(text, first, last)
        character(*), intent(in) :: text
        integer, intent(out) :: first, last

        first = max(1, verify(text, BLANKS))
        last = verify(text, BLANKS, back=.true.)
    end subroutine find_word

    pure subroutine parse_integer_i8(text, value, ok)
        character(*), intent(in) :: text
        integer(i8), intent(out) :: value   !! 0 when not ok
        logical, intent(out) :: ok          !! False too for a number too large for the kind

        integer :: first, last, at

        call find_word(text, first, last)
        at = 1
        call scan_integer(text(first:last)//LF, at, value, ok)
        ok = ok .and. at == last - first + 2
        if (.not. ok) value = 0
    end subroutine parse_integer_i8

    pure subroutine parse_integer_i4(text, value, ok)
        character(*), intent(in) :: text
        integer(i4), intent(out) :: value
        logical, intent(out) :: ok

        integer(i8) :: long

        call parse_integer_i8(text, long, ok)
        ok = ok .and. abs(long) <= huge(value)
        value = 0
        if (ok) value = int(long, i4)
    end subroutine parse_integer_i4

    !> What real_text gives, with blanks behind it: quicker, for long tables.
    pure function real_field(value) result(field)
        real(dp), intent(in) :: value   !! NaN and infinity have their names
        character(LONGEST_REAL) :: field

        integer(i8) :: digits
        integer :: exponent
        character(25) :: buffer

        if (abs(value) <= 0) then
            field = '0'
            return
        else if (.not. ieee_is_finite(value)) then
            write (buffer, '(f25.0)') value
            field = adjustl(buffer)
            return
        end if
        call shortest_digits(abs(value), digits, exponent)
        field = decimal_text(value < 0, digits, exponent)
    end function real_field

    !> The shortest decimal that reads back as exactly the same number: 0.1 is '0.1'.
    pure function real_text(value) result(text)
        real(dp), intent(in) :: value   !! NaN and infinity have their names
        character(len_trim(real_field(value))) :: text

        text = real_field(value)
    end function real_text

    !> The number itself, rounded to so many digits.
    pure real(dp) function rounded(value, digits)
        real(dp), intent(in) :: value
        integer, intent(in) :: digits       !! 1 to 15

        character(32) :: buffer, layout
        integer :: status

        rounded = value
        if (.not. ieee_is_finite(value)) return
        write (layout, '(a, i0, a)') '(es32.', digits - 1, 'e3)'
        write (buffer, layout) value
        read (buffer, '(es32.0)', iostat=status) rounded
        if (status /= 0) rounded = value
    end function rounded

    !> A number rounded to so many digits, for people: 0.66439 with three digits is '0.664'.
    pure function rounded_text(value, digits) result(text)
        real(dp), intent(in) :: value       !! NaN and infinity have their names
        integer, intent(in) :: digits       !! 1 to 15
        character(len_trim(real_field(rounded(value, digits)))) :: text

        text = real_field(rounded(value, digits))
    end function rounded_text

    !> mantissa*10**exponent as text, without needless zeros; with an exponent only when the point
    !> would stand far from the digits.
    pure function decimal_text(negative, mantissa, exponent) result(text)
        logical, intent(in) :: negative
        integer(i8), intent(in) :: mantissa     !! Positive
        integer, intent(in) :: exponent
        character(LONGEST_REAL) :: text

        character(LONGEST_INTEGER) :: digits
        integer(i8) :: rest
        integer :: n, leading

        rest = mantissa
        leading = exponent
        do while (mod(rest, 10_i8) == 0)
            rest = rest/10
            leading = leading + 1
        end do
        digits = integer_field(rest)
        n = len_trim(digits)
        leading = leading + n - 1       ! exponent of the first digit
        if (leading >= 0 .and. leading < n - 1) then
            text = digits(:leading + 1)//'.'//digits(leading + 2:)
        else if (leading >= 0 .and. leading < 16) then
            text = digits(:n)//ZEROS(:leading + 1 - n)
        else if (leading < 0 .and. leading >= -5) then
            text = '0.'//ZEROS(:-leading - 1)//digits
        else if (n == 1) then
            text = digits(:1)//'e'//integer_field(int(leading, i8))
        else
            text = digits(:1)//'.'//digits(2:n)//'e'//integer_field(int(leading, i8))
        end if
        if (negative) text = '-'//text
    end function decimal_text

    !> An integer with blanks behind it.
    pure function integer_field(value) result(field)
        integer(i8), intent(in) :: value
        character(LONGEST_INTEGER) :: field

        character(LONGEST_INTEGER) :: digits
        integer(i8) :: rest, tenth
        integer :: first

        rest = value
        first = LONGEST_INTEGER + 1
        do
            tenth = rest/10
            first = first - 1
            digits(first:first) = achar(iachar('0') + abs(int(rest - 10*tenth)))
            rest = tenth
            if (rest == 0) exit
        end do
        if (value < 0) then
            first = first - 1
            digits(first:first) = '-'
        end if
        field = digits(first:)
    end function integer_field

    pure function integer_text_i8(value) result(text)
        integer(i8), intent(in) :: value
        character(len_trim(integer_field(value))) :: text

        text = integer_field(value)
    end function integer_text_i8

    pure function integer_text_i4(value) result(text)
        integer(i4), intent(in) :: value
        character(len_trim(integer_field(int(value, i8)))) :: text

        text = integer_field(int(value, i8))
    end function integer_text_i4

    !> One of two texts, each of its own length.
    pure function pick_text(condition, if_true, if_false) result(text)
        logical, intent(in) :: condition                !! Which of the two
        character(*), intent(in) :: if_true, if_false   !! The two
        character(count([condition])*len(if_true) + count([.not. condition])*len(if_false)) :: text

        if (condition) then
            text = if_true
        else
            text = if_false
        end if
    end function pick_text

    !> What share_text gives, with blanks behind it.
    pure function share_field(part, whole) result(field)
        integer, intent(in) :: part, whole
        character(28) :: field

        write (field, '(i0, a, i0)') part, ' of ', whole
    end function share_field

    !> Counts as '3 of 4'.
    pure function share_text(part, whole) result(text)
        integer, intent(in) :: part, whole      !! How many of how many
        character(len_trim(share_field(part, whole))) :: text

        text = share_field(part, whole)
    end function share_text

    !> true or false; true with a blank behind it.
    pure function logical_text(value) result(text)
        logical, intent(in) :: value    !! To be written
        character(5) :: text

        text = merge('true ', 'false', value)
    end function logical_text
end module gracecg_base_text
