!> JSON texts against what RFC 8259 asks for, written out by hand, and the names of units.
module test_json
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_positive_inf
    use vocabulary
    use gracecg_base_text, only: parse_real
    use gracecg_files_json, only: json_writer_t, read_json_list, read_json_numbers, read_json_text
    use gracecg_files_csv, only: unit_of_column
    implicit none
    private
    public :: collect_json

    character(*), parameter :: LF = achar(10), BACKSLASH = achar(92)

contains

    subroutine collect_json(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('document', test_document), &
                    new_unittest('escapes', test_escapes), &
                    new_unittest('numbers-are-exact', test_numbers), &
                    new_unittest('not-finite-and-not-ended-are-refused', test_not_finite), &
                    new_unittest('lists-are-read-or-refused', test_lists), &
                    new_unittest('members', test_members), &
                    new_unittest('units-of-columns', test_units)]
    end subroutine collect_json

    subroutine test_document(error)
        type(error_type), allocatable, intent(out) :: error
        type(json_writer_t) :: json
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call json%begin()
        call json%member('name', 'front-1')
        call json%member('runs', 15)
        call json%member('seed', 9007199254740993_i8)
        call json%member('converged', .true.)
        call json%nothing('published')
        call json%member('d', [1.5_dp, -2e-9_dp])
        call json%member('matrix', reshape([1.0_dp, 2.0_dp, 3.0_dp, 4.0_dp], [2, 2]))
        call json%begin_array('rows')
        call json%begin(on_one_line=.true.)
        call json%member('a', 1)
        call json%member('b', 'x')
        call json%end()
        call json%end()
        call json%member('texts', [string_t('one'), string_t('')])
        call json%begin('empty')
        call json%end()
        call json%begin_array('none')
        call json%end()
        call json%end()
        call json%finish(text, failure)
        call check_passes(error, failure)
        call check(error, text, '{'//LF//'  "name": "front-1",'//LF//'  "runs": 15,'//LF// &
                   '  "seed": 9007199254740993,'//LF//'  "converged": true,'//LF//'  "published": null,'//LF// &
                   '  "d": [1.5, -2e-9],'//LF//'  "matrix": ['//LF//'    [1, 3],'//LF//'    [2, 4]'//LF//'  ],'//LF// &
                   '  "rows": ['//LF//'    {"a": 1, "b": "x"}'//LF//'  ],'//LF// &
                   '  "texts": ['//LF//'    "one",'//LF//'    ""'//LF//'  ],'//LF//'  "empty": {},'//LF// &
                   '  "none": []'//LF//'}')
    end subroutine test_document

    !> Quotes, backslashes and control characters are escaped; UTF-8 stays; all of it reads back.
    subroutine test_escapes(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: HARD = 'a "quote", a '//BACKSLASH//', a tab'//achar(9)//', a line'//LF// &
                                   'and '//achar(195)//achar(164)//achar(1)
        type(json_writer_t) :: json
        type(string_t), allocatable :: list(:)
        type(error_t), allocatable :: failure
        character(:), allocatable :: text
        logical :: ok

        call json%begin()
        call json%member('about', [string_t(HARD), string_t('second')])
        call json%end()
        call json%finish(text, failure)
        call check(error, text, '{'//LF//'  "about": ['//LF//'    "a '//BACKSLASH//'"quote'//BACKSLASH//'", a '// &
                   BACKSLASH//BACKSLASH//', a tab'//BACKSLASH//'u0009, a line'//BACKSLASH//'u000aand '//achar(195)// &
                   achar(164)//BACKSLASH//'u0001",'//LF//'    "second"'//LF//'  ]'//LF//'}')
        call read_json_list(text, 'about', list, ok)
        call check(error, ok .and. size(list) == 2)
        call check(error, list(1)%text, HARD)
        call check(error, list(2)%text, 'second')
    end subroutine test_escapes

    !> Every number reads back as the same, and looks as JSON wants it: a digit before and behind the point.
    subroutine test_numbers(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: VALUES(9) = [0.0_dp, -0.1_dp, 1.0_dp/3, tiny(1.0_dp), huge(1.0_dp), 1e22_dp, 123456.789_dp, &
                                            -6.02e-23_dp, 4.9e-324_dp]
        type(json_writer_t) :: json
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, number
        real(dp) :: again
        integer :: i, point
        logical :: ok

        do i = 1, size(VALUES)
            json = json_writer_t()
            call json%begin(on_one_line=.true.)
            call json%member('v', VALUES(i))
            call json%end()
            call json%finish(text, failure)
            number = text(len('{"v": ') + 1:len(text) - 1)
            call parse_real(number, again, ok)
            call check(error, ok .and. abs(again - VALUES(i)) <= 0, text)
            point = index(number, '.')
            call check(error, scan(number(:1), '-0123456789') == 1 .and. index(number, '+.') == 0, number)
            if (point == 0) cycle
            call check(error, point > 1 .and. point < len(number), number)
            call check(error, scan(number(point - 1:point - 1), '0123456789') == 1 .and. &
                       scan(number(point + 1:point + 1), '0123456789') == 1, number)
        end do
    end subroutine test_numbers

    subroutine test_not_finite(error)
        type(error_type), allocatable, intent(out) :: error
        type(json_writer_t) :: json
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call json%begin()
        call json%member('sigma_x_mm', NAN)
        call json%member('dx_mm', ieee_value(1.0_dp, ieee_positive_inf))
        call json%end()
        call json%finish(text, failure)
        call check_fails(error, failure, 'sigma_x_mm ... not a finite number')
        call check(error, text, '')
        json = json_writer_t()
        call json%begin()
        call json%begin_array('rows')
        call json%end()
        call json%finish(text, failure)
        call check_fails(error, failure, 'not ended')
    end subroutine test_not_finite

    !> However it is laid out, and whatever stands beside; a member of an inner object is another.
    subroutine test_lists(error)
        type(error_type), allocatable, intent(out) :: error
        character(40), parameter :: BROKEN(8) = [character(40) :: '', '{', '{"about"', '{"about":"a"}', &
                                                 '{"about":["a","b}', '{"about":["a",1]}', '{"about":["a', &
                                                 '{"other":["a"]}']
        type(string_t), allocatable :: list(:)
        logical :: ok
        integer :: i

        call read_json_list('{"x":{"about":["no"]},"about":["a","b\u0041\n"],"y":[1,2]}', 'about', list, ok)
        call check(error, ok .and. size(list) == 2)
        call check(error, list(2)%text, 'bA'//LF)
        call read_json_list('  {'//LF//'"text": "about", "about" :'//LF//'[ ]}', 'about', list, ok)
        call check(error, ok .and. size(list) == 0)
        do i = 1, size(BROKEN)
            call read_json_list(trim(BROKEN(i)), 'about', list, ok)
            call check(error, .not. ok, BROKEN(i))
        end do
    end subroutine test_lists

    subroutine test_units(error)
        type(error_type), allocatable, intent(out) :: error
        character(20), parameter :: NAMES(2, 14) = reshape([character(20) :: 'dx_mm', 'mm', 'time_s', 's', 'ax_m_s2', 'm/s^2', &
            'omega_dot_x_rad_s2', 'rad/s^2', 'wx_rad_s', 'rad/s', 'bx_tesla', 'T', 'bx_nt', 'nT', 'latitude_deg', 'deg', &
            'rate_deg_s', 'deg/s', 'case', '', 'q1', '', 'worst_x', '', 'runs', '', 'rx_m', 'm'], [2, 14])
        integer :: i

        do i = 1, size(NAMES, 2)
            call check(error, unit_of_column(trim(NAMES(1, i))), trim(NAMES(2, i)), NAMES(1, i))
        end do
    end subroutine test_units

    subroutine test_members(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: TEXT = '{"a": "x,}\"", "b": [1, [2.5e-3 , -4]], "c": {"d": 7, "e":{"b" :[8]}}, "f": true}'
        real(dp), allocatable :: values(:)
        character(:), allocatable :: word
        logical :: ok

        call read_json_numbers(TEXT, 'b', values, ok)
        if (ok) ok = size(values) == 3
        if (ok) ok = all(abs(values - [1.0_dp, 2.5e-3_dp, -4.0_dp]) <= 0)
        call check(error, ok)
        call read_json_numbers(TEXT, 'c.e.b', values, ok)
        if (ok) ok = abs(values(1) - 8) <= 0
        call check(error, ok)
        call read_json_numbers(TEXT, 'c.d', values, ok)
        if (ok) ok = abs(values(1) - 7) <= 0
        call check(error, ok)
        call read_json_text(TEXT, 'a', word, ok)
        call check(error, ok .and. word == 'x,}"')
        word = ''
        call read_json_numbers(TEXT, 'f', values, ok, word)
        call check(error, .not. ok .and. word == ': "true" of "f" is no number', 'a logical is no number')
        call read_json_numbers(TEXT, 'c.g', values, ok)
        call check(error, .not. ok, 'no such member')
        call read_json_numbers(TEXT(:40), 'c.d', values, ok)
        call check(error, .not. ok, 'cut off')
        call read_json_text('', 'a', word, ok)
        call check(error, .not. ok, 'empty')
    end subroutine test_members
end module test_json
