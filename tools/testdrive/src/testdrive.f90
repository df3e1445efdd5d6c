!> A small test framework with the public names of test-drive (fortran-lang/test-drive), so that the
!> upstream package can take its place by one line in fpm.toml: unit tests are subroutines with one
!> `type(error_type), allocatable, intent(out) :: error`, gathered by `collect_*` procedures.
module testdrive
    use, intrinsic :: iso_fortran_env, only: real64, int64
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    implicit none
    private
    public :: error_type, unittest_type, testsuite_type, collect_interface
    public :: new_unittest, new_testsuite, run_selected, select_suite, select_test
    public :: check, test_failed, skip_test

    integer, parameter :: SUCCESS = 0, FAILURE = 1, SKIPPED = 77

    type :: error_type
        integer :: stat = SUCCESS
        character(:), allocatable :: message
    end type error_type

    abstract interface
        subroutine test_interface(error)
            import :: error_type
            type(error_type), allocatable, intent(out) :: error
        end subroutine test_interface
    end interface

    type :: unittest_type
        character(:), allocatable :: name
        procedure(test_interface), pointer, nopass :: test => null()
        logical :: should_fail = .false.
    end type unittest_type

    abstract interface
        subroutine collect_interface(testsuite)
            import :: unittest_type
            type(unittest_type), allocatable, intent(out) :: testsuite(:)
        end subroutine collect_interface
    end interface

    type :: testsuite_type
        character(:), allocatable :: name
        procedure(collect_interface), pointer, nopass :: collect => null()
    end type testsuite_type

    !> check(error, condition) or check(error, actual, expected [, thr] [, rel]): sets `error` when
    !> the check fails; NaN always fails. Without `thr` real numbers must be equal to rounding, those above 1 to the
    !> epsilon of 1, as upstream has it.
    interface check
        module procedure check_logical, check_real, check_integer, check_long, check_text
    end interface check

contains

    function new_unittest(name, test, should_fail) result(unittest)
        character(*), intent(in) :: name
        procedure(test_interface) :: test
        logical, intent(in), optional :: should_fail
        type(unittest_type) :: unittest

        unittest%name = name
        unittest%test => test
        if (present(should_fail)) unittest%should_fail = should_fail
    end function new_unittest

    function new_testsuite(name, collect) result(suite)
        character(*), intent(in) :: name
        procedure(collect_interface) :: collect
        type(testsuite_type) :: suite

        suite%name = name
        suite%collect => collect
    end function new_testsuite

    !> Runs the one test of a suite that has this name; `stat` becomes negative when there is none.
    subroutine run_selected(collect, name, unit, stat)
        procedure(collect_interface) :: collect
        character(*), intent(in) :: name
        integer, intent(in) :: unit
        integer, intent(inout) :: stat

        type(unittest_type), allocatable :: tests(:)
        integer :: position

        call collect(tests)
        position = select_test(tests, name)
        if (position == 0) then
            stat = -1
            return
        end if
        call run_unittest(tests(position), unit, stat)
    end subroutine run_selected

    subroutine run_unittest(test, unit, stat)
        type(unittest_type), intent(in) :: test
        integer, intent(in) :: unit
        integer, intent(inout) :: stat

        type(error_type), allocatable :: error
        logical :: failed

        call test%test(error)
        if (allocated(error)) then
            if (error%stat == SKIPPED) then
                write (unit, '(4x, a)') test%name//' [SKIPPED] '//error%message
                return
            end if
        end if
        failed = allocated(error) .neqv. test%should_fail
        if (failed) then
            stat = stat + 1
            write (unit, '(4x, a)') test%name//' [FAILED]'
            if (allocated(error)) then
                write (unit, '(8x, a)') error%message
            else
                write (unit, '(8x, a)') 'was expected to fail and passed'
            end if
        else
            write (unit, '(4x, a)') test%name//' [PASSED]'
        end if
    end subroutine run_unittest

    pure integer function select_suite(suites, name) result(position)
        type(testsuite_type), intent(in) :: suites(:)
        character(*), intent(in) :: name

        do position = 1, size(suites)
            if (suites(position)%name == name) return
        end do
        position = 0
    end function select_suite

    pure integer function select_test(tests, name) result(position)
        type(unittest_type), intent(in) :: tests(:)
        character(*), intent(in) :: name

        do position = 1, size(tests)
            if (tests(position)%name == name) return
        end do
        position = 0
    end function select_test

    subroutine test_failed(error, message, more)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: message
        character(*), intent(in), optional :: more

        allocate (error)
        error%stat = FAILURE
        error%message = message
        if (present(more)) error%message = message//': '//more
    end subroutine test_failed

    subroutine skip_test(error, message)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: message

        allocate (error)
        error%stat = SKIPPED
        error%message = message
    end subroutine skip_test

    subroutine check_logical(error, expression, message, more)
        type(error_type), allocatable, intent(out) :: error
        logical, intent(in) :: expression
        character(*), intent(in), optional :: message, more

        if (.not. expression) call explain(error, 'condition not met', message, more)
    end subroutine check_logical

    subroutine check_real(error, actual, expected, message, more, thr, rel)
        type(error_type), allocatable, intent(out) :: error
        real(real64), intent(in) :: actual, expected
        character(*), intent(in), optional :: message, more
        real(real64), intent(in), optional :: thr   !! Largest difference allowed
        logical, intent(in), optional :: rel        !! `thr` is relative to `expected`

        real(real64) :: difference, threshold
        character(100) :: found

        threshold = epsilon(expected)*min(max(abs(expected), tiny(expected)), 1.0_real64)
        if (present(thr)) threshold = thr
        difference = abs(actual - expected)
        if (present(rel)) then
            if (rel) difference = difference/abs(expected)
        end if
        if (.not. difference <= threshold) then     ! NaN fails here
            write (found, '(a, es23.15, a, es23.15, a, es10.2, a, es10.2)') 'found', actual, &
                ', expected', expected, ', differ by', difference, ' >', threshold
            call explain(error, trim(found), message, more)
        end if
    end subroutine check_real

    subroutine check_integer(error, actual, expected, message, more)
        type(error_type), allocatable, intent(out) :: error
        integer, intent(in) :: actual, expected
        character(*), intent(in), optional :: message, more

        call check_long(error, int(actual, int64), int(expected, int64), message, more)
    end subroutine check_integer

    subroutine check_long(error, actual, expected, message, more)
        type(error_type), allocatable, intent(out) :: error
        integer(int64), intent(in) :: actual, expected
        character(*), intent(in), optional :: message, more

        character(80) :: found

        if (actual /= expected) then
            write (found, '(a, i0, a, i0)') 'found ', actual, ', expected ', expected
            call explain(error, trim(found), message, more)
        end if
    end subroutine check_long

    subroutine check_text(error, actual, expected, message, more)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: actual, expected
        character(*), intent(in), optional :: message, more

        if (actual /= expected) then
            call explain(error, 'found "'//actual//'", expected "'//expected//'"', message, more)
        end if
    end subroutine check_text

    subroutine explain(error, found, message, more)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: found
        character(*), intent(in), optional :: message, more

        call test_failed(error, found, more)
        if (present(message)) error%message = message//' ('//error%message//')'
    end subroutine explain
end module testdrive
