!> Text helpers: strict numbers, and numbers as text that read back exactly.
module test_text
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use vocabulary
    use gracecg_base_error, only: add_context, number_text
    use gracecg_base_text
    implicit none
    private
    public :: collect_text

contains

    subroutine collect_text(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('messages', test_messages), &
                    new_unittest('lower-case', test_lower_case), &
                    new_unittest('split-and-join', test_split), &
                    new_unittest('reals', test_reals), &
                    new_unittest('integers', test_integers), &
                    new_unittest('numbers-as-short-texts', test_short)]
    end subroutine collect_text

    !> A context is said once, however many callers add it; numbers of any size have an exponent.
    subroutine test_messages(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure

        call add_context(failure, 'case a')
        call check(error, .not. allocated(failure), 'nothing failed')
        failure = error_t('no mass')
        call add_context(failure, 'case a')
        call add_context(failure, 'case a')
        call check(error, failure%message, 'case a: no mass')
        call check(error, number_text(1e300_dp), '1.000000E+300')
        call check(error, number_text(-2.5e-200_dp), '-2.500000E-200')
        call check(error, number_text(2.5e-20_dp), '2.500000E-20')
    end subroutine test_messages

    subroutine test_lower_case(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, lower_case('AZ az[@`{09'), 'az az[@`{09')
    end subroutine test_lower_case

    subroutine test_split(error)
        type(error_type), allocatable, intent(out) :: error
        type(string_t), allocatable :: pieces(:), joins(:)

        pieces = split('a,, b ,', ',')
        if (unmet(error, size(pieces), 4)) return
        call check(error, pieces(1)%text == 'a' .and. len(pieces(2)%text) == 0 .and. &
                   pieces(3)%text == ' b ' .and. len(pieces(4)%text) == 0)
        call check(error, size(split('', ',')), 1)
        pieces = split_words('  one'//achar(9)//' two  t')
        if (unmet(error, size(pieces), 3)) return
        call check(error, pieces(1)%text//'|'//pieces(2)%text//'|'//pieces(3)%text, 'one|two|t')
        call check(error, size(split_words('  ')) + size(split_words('')), 0)
        allocate (joins(0))
        call append(joins, 'time')
        call append(joins, '')
        call append(joins, 'x')
        call check(error, join(padded(joins), ','), 'time,,x')
        call check(error, len(padded(joins)), 4)
    end subroutine test_split

    subroutine test_reals(error)
        type(error_type), allocatable, intent(out) :: error
        character(24), parameter :: TEXTS(*) = [character(24) :: '1', '+1.5', '-.5', '5.', '1e3', &
                                                '1.25D-2', '2d+1', '  7 ', '0.1', '1e-400', &
                                                '1.7976931348623157e308', '0012']
        real(dp), parameter :: VALUES(*) = [1.0_dp, 1.5_dp, -0.5_dp, 5.0_dp, 1000.0_dp, 0.0125_dp, &
                                            20.0_dp, 7.0_dp, 0.1_dp, 0.0_dp, huge(1.0_dp), 12.0_dp]
        character(12), parameter :: REFUSED(*) = [character(12) :: '', '   ', 'NaN', 'nan', 'Inf', &
                                                  '-infinity', '1.2.3', '1.5x', 'x1', '1 2', '1,5', &
                                                  '.', '-', '+-1', 'e5', '1e', '1e+', '1e5.0', '1e400', &
                                                  '0x10', '1_8', '2*3', '1e5e5']
        real(dp) :: value
        logical :: ok
        integer :: i

        do i = 1, size(TEXTS)
            call parse_real(TEXTS(i), value, ok)
            call check(error, ok .and. abs(value - VALUES(i)) <= 0, 'value of '//TEXTS(i))
        end do
        do i = 1, size(REFUSED)
            value = 1
            call parse_real(trim(REFUSED(i)), value, ok)
            call check(error, .not. ok .and. abs(value) <= 0, 'accepted: '//REFUSED(i))
        end do
        call parse_real(repeat('1', 1000), value, ok)
        call check(error, .not. ok, 'accepted a thousand digits')
    end subroutine test_reals

    subroutine test_integers(error)
        type(error_type), allocatable, intent(out) :: error
        character(24), parameter :: TEXTS(*) = [character(24) :: '', ' ', '+', '-', '1.0', '1e3', &
                                                '12x', '1 2', '2147483648', &
                                                '9223372036854775808', '99999999999999999999']
        integer :: value, i
        integer(i8) :: long
        logical :: ok

        call parse_integer(' -2147483647 ', value, ok)
        call check(error, ok .and. value == -2147483647)
        call parse_integer('+007', value, ok)
        call check(error, ok .and. value == 7)
        call parse_integer('9223372036854775807', long, ok)
        call check(error, ok .and. long == huge(long))
        do i = 1, size(TEXTS)
            call parse_integer(trim(TEXTS(i)), value, ok)
            call check(error, .not. ok .and. value == 0, 'accepted: '//TEXTS(i))
        end do
        call parse_integer('9223372036854775808', long, ok)
        call check(error, .not. ok .and. long == 0)
    end subroutine test_integers

    subroutine test_short(error)
        type(error_type), allocatable, intent(out) :: error
        character(24), parameter :: TEXTS(*) = [character(24) :: '0', '0.1', '-0.3', '60', &
                                                '432.5', &
                                                '6378136.3', '1e-10', '-1.5e-7', '0.00001', &
                                                '1e16', '1e22', '1e23', '1e300', &
                                                '0.30000000000000004', '1e-300', &
                                                '100000', '123456789012345.6', &
                                                '2.2250738585072014e-308']
        real(dp) :: value
        character(24) :: text
        integer :: i

        do i = 1, size(TEXTS)
            text = TEXTS(i)
            read (text, *) value
            call check(error, real_text(value), trim(TEXTS(i)))
        end do
        call check(error, real_text(3.986004415e14_dp), '398600441500000')
        call check(error, real_text(9007199254740993.0_dp), '9007199254740992')
        call check(error, real_text(ieee_value(value, ieee_quiet_nan)), 'NaN')
        call check(error, integer_text(-12)//' '//integer_text(huge(1_i8)), &
                   '-12 9223372036854775807')
    end subroutine test_short
end module test_text
