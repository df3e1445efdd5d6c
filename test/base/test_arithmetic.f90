!> The arithmetic that the flags of this build left.
module test_arithmetic
    use vocabulary
    use gracecg_base_arithmetic, only: check_arithmetic
    implicit none
    private
    public :: collect_arithmetic

contains

    subroutine collect_arithmetic(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [new_unittest('nan-infinity-and-small-numbers', test_flags)]
    end subroutine collect_arithmetic

    !> Fails in a build with -ffast-math.
    subroutine test_flags(error)
        type(error_type), allocatable, intent(out) :: error
        type(error_t), allocatable :: failure

        call check_arithmetic(failure)
        call check_passes(error, failure)
    end subroutine test_flags
end module test_arithmetic
