!> Small helpers for text: case, splitting, and numbers to and from text.
!>
!> No function of the library returns a text of deferred length (`character(:), allocatable`): gfortran
!> keeps the length of such a result in static memory where the function is called, so that two threads
!> that make texts at once cut each other's short. The length is a function of the arguments instead.
module gracecg_base_text
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_intptr_t, c_loc, c_null_char, c_null_ptr, &
        c_ptr
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp, i4, i8
    use gracecg_base_shortest_decimal, only: shortest_digits, MOST_DIGITS
    implicit none
    private
    public :: string_t, lower_case, split, split_words, append, padded, join, quoted_text
    public :: parse_real, parse_integer, real_text, real_field, LONGEST_REAL, rounded_text, integer_text, logical_text, &
        parse_logical

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

    interface
        !> The same, for a text that is one number to its end; `rest` is null.
        pure function c_value(text, rest) bind(c, name='strtod') result(value)
            import :: c_char, c_double, c_ptr
            character(kind=c_char), intent(in) :: text(*)
            type(c_ptr), intent(in), value :: rest
            real(c_double) :: value
        end function c_value
    end interface

    interface
        !> The C library's conversion: several times quicker than an internal read.
        function c_strtod(text, rest) bind(c, name='strtod') result(value)
            import :: c_char, c_double, c_ptr
            character(kind=c_char), intent(in) :: text(*)
            type(c_ptr), intent(out) :: rest    !! Address of the first character not used
            real(c_double) :: value
        end function c_strtod
    end interface

    character(*), parameter :: BLANKS = ' '//achar(9)
    integer, parameter :: LONGEST_NUMBER = 128  !! Longer texts are not taken for numbers
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
    subroutine parse_real(text, value, ok)
        character(*), intent(in) :: text    !! Blanks around it are allowed
        real(dp), intent(out) :: value  !! 0 when not ok
        logical, intent(out) :: ok      !! False if it is no number

        character(kind=c_char), target :: number(LONGEST_NUMBER + 1)
        type(c_ptr) :: rest
        integer :: length, status

        value = 0
        call scan_number(text, number, length)
        ok = length > 0
        if (.not. ok) return
        number(length + 1) = c_null_char
        value = c_strtod(number, rest)
        ! A host program may have set a locale with another decimal point: then C stops too early.
        if (transfer(rest, 0_c_intptr_t) - transfer(c_loc(number), 0_c_intptr_t) /= length) then
            read (text, *, iostat=status) value
            ok = status == 0
        end if
        ok = ok .and. ieee_is_finite(value)
        if (.not. ok) value = 0
    end subroutine parse_real

    !> Copies a decimal number to `number`, its exponent letter made an e; length = 0 when the text
    !> is anything else.
    subroutine scan_number(text, number, length)
        character(*), intent(in) :: text
        character(kind=c_char), intent(inout) :: number(:)
        integer, intent(out) :: length

        integer :: i, last, digits

        length = 0
        i = verify(text, BLANKS)
        if (i == 0) return
        last = verify(text, BLANKS, back=.true.)
        if (last - i + 1 > LONGEST_NUMBER) return
        digits = 0
        call take_sign()
        call take_digits()
        if (next() == '.') then
            call take('.')
            call take_digits()
        end if
        if (digits > 0 .and. scan(next(), 'eEdD') == 1) then
            digits = 0
            call take('e')
            call take_sign()
            call take_digits()
        end if
        if (digits == 0 .or. i <= last) length = 0

    contains

        character(1) function next()
            next = ' '
            if (i <= last) next = text(i:i)
        end function next

        subroutine take(letter)
            character(1), intent(in) :: letter

            length = length + 1
            number(length) = letter
            i = i + 1
        end subroutine take

        subroutine take_sign()
            if (next() == '+' .or. next() == '-') call take(next())
        end subroutine take_sign

        subroutine take_digits()
            do while (next() >= '0' .and. next() <= '9')
                digits = digits + 1
                call take(next())
            end do
        end subroutine take_digits
    end subroutine scan_number

    pure subroutine parse_integer_i8(text, value, ok)
        character(*), intent(in) :: text
        integer(i8), intent(out) :: value   !! 0 when not ok
        logical, intent(out) :: ok          !! False too for a number too large for the kind

        integer(i8) :: digit
        integer :: i, first, last

        value = 0
        ok = .false.
        first = verify(text, BLANKS)
        if (first == 0) return
        last = verify(text, BLANKS, back=.true.)
        if (scan(text(first:first), '+-') == 1) first = first + 1
        if (first > last) return
        do i = first, last
            digit = iachar(text(i:i)) - iachar('0')
            ok = digit >= 0 .and. digit <= 9 .and. value <= (huge(value) - digit)/10
            if (.not. ok) exit
            value = 10*value + digit
        end do
        if (.not. ok) value = 0
        if (first > 1) then
            if (text(first - 1:first - 1) == '-') value = -value
        end if
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

        integer(i8) :: mantissa
        integer :: exponent
        logical :: sure
        character(25) :: buffer

        if (abs(value) <= 0) then
            field = '0'
            return
        else if (.not. ieee_is_finite(value)) then
            write (buffer, '(f25.0)') value
            field = adjustl(buffer)
            return
        end if
        call shortest_digits(abs(value), mantissa, exponent, sure)
        if (sure) then
            field = decimal_text(value < 0, mantissa, exponent)
        else
            write (buffer, '(es25.16e3)') abs(value)
            call scan_scientific(buffer, mantissa, exponent)
            field = shortest(value, mantissa, exponent)
        end if
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

    !> The first of 15, 16 and 17 digits that reads back as `value`; blank when none does.
    pure function shortest(value, mantissa, exponent) result(field)
        real(dp), intent(in) :: value
        integer(i8), intent(in) :: mantissa     !! The first 17 digits of its absolute value
        integer, intent(in) :: exponent         !! Exponent of the first digit
        character(LONGEST_REAL) :: field

        integer(i8) :: unit
        integer :: excess

        do excess = 2, 0, -1
            unit = 10_i8**excess
            field = decimal_text(value < 0, (mantissa + unit/2)/unit, &
                                 exponent - MOST_DIGITS + 1 + excess)
            if (abs(value_of(field) - value) <= 0) return
        end do
        field = ''
    end function shortest

    !> The number that a field of decimal_text is.
    pure real(dp) function value_of(field) result(value)
        character(LONGEST_REAL), intent(in) :: field

        integer :: status

        ! A host program may have set a locale with another decimal point.
        if (c_value('0.5'//c_null_char, c_null_ptr) > 0) then
            value = c_value(field//c_null_char, c_null_ptr)     ! reads up to the first blank
        else
            read (field, *, iostat=status) value
            if (status /= 0) value = 0
        end if
    end function value_of

    !> Takes ' 1.2345678901234567E-012' apart: the digits as one integer, and the exponent.
    pure subroutine scan_scientific(buffer, mantissa, exponent)
        character(*), intent(in) :: buffer
        integer(i8), intent(out) :: mantissa
        integer, intent(out) :: exponent    !! Of the first digit

        integer :: i, letter
        logical :: ok

        letter = index(buffer, 'E')
        mantissa = 0
        do i = 1, letter - 1
            if (scan(buffer(i:i), '0123456789') == 1) &
                mantissa = 10*mantissa + iachar(buffer(i:i)) - iachar('0')
        end do
        call parse_integer(buffer(letter + 1:), exponent, ok)
    end subroutine scan_scientific

    !> mantissa*10**exponent as text, without needless zeros; with an exponent only when the point
    !> would stand far from the digits.
    pure function decimal_text(negative, mantissa, exponent) result(text)
        logical, intent(in) :: negative
        integer(i8), intent(in) :: mantissa     !! Positive
        integer, intent(in) :: exponent
        character(LONGEST_REAL) :: text

        character(LONGEST_INTEGER) :: digits
        integer(i8) :: rest
        integer :: sign_there, n, leading

        rest = mantissa
        leading = exponent
        do while (mod(rest, 10_i8) == 0)
            rest = rest/10
            leading = leading + 1
        end do
        call put_integer(rest, digits, n)
        leading = leading + n - 1       ! exponent of the first digit

        text = ''
        sign_there = merge(1, 0, negative)
        if (negative) text(1:1) = '-'
        associate (body => text(sign_there + 1:))
            if (leading >= 0 .and. leading < n - 1) then
                body(:leading + 1) = digits(:leading + 1)
                body(leading + 2:leading + 2) = '.'
                body(leading + 3:n + 1) = digits(leading + 2:n)
            else if (leading >= 0 .and. leading < 16) then
                body(:n) = digits(:n)
                body(n + 1:leading + 1) = ZEROS
            else if (leading < 0 .and. leading >= -5) then
                body(:1 - leading) = '0.'//ZEROS
                body(2 - leading:1 - leading + n) = digits(:n)
            else
                body(:1) = digits(:1)
                if (n > 1) body(2:n + 1) = '.'//digits(2:n)
                if (n > 1) n = n + 1
                body(n + 1:n + 1) = 'e'
                call put_integer(int(leading, i8), body(n + 2:), leading)
            end if
        end associate
    end function decimal_text

    !> The digits of an integer from the first place on, a minus before them; blanks behind.
    pure subroutine put_integer(value, text, length)
        integer(i8), intent(in) :: value
        character(*), intent(inout) :: text     !! Long enough
        integer, intent(out) :: length          !! Places taken

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
        length = LONGEST_INTEGER + 1 - first
        text = digits(first:)
    end subroutine put_integer

    !> An integer with blanks behind it.
    pure function integer_field(value) result(field)
        integer(i8), intent(in) :: value
        character(LONGEST_INTEGER) :: field

        integer :: length

        call put_integer(value, field, length)
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

    !> true or false; true with a blank behind it.
    pure function logical_text(value) result(text)
        logical, intent(in) :: value    !! To be written
        character(5) :: text

        text = merge('true ', 'false', value)
    end function logical_text

    !> true or false, as logical_text writes it, or as version 0.1 did: T, F, 1, 0. Not ok: anything else.
    pure subroutine parse_logical(text, value, ok)
        character(*), intent(in) :: text    !! With or without blanks around it
        logical, intent(out) :: value       !! False when not ok
        logical, intent(out) :: ok          !! The text is one of them

        value = any(lower_case(trim(adjustl(text))) == [character(5) :: 'true', 't', '1'])
        ok = value .or. any(lower_case(trim(adjustl(text))) == [character(5) :: 'false', 'f', '0'])
    end subroutine parse_logical
end module gracecg_base_text
