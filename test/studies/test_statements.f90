!> Statements of the report that are examined by `gracecg statements`.
module test_statements
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t, message_of
    use gracecg_studies_statements
    use testdrive, only: new_unittest, unittest_type, error_type, check
    use fixture, only: check_passes, check_fails
    implicit none
    private
    public :: collect_statements

contains

    subroutine collect_statements(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('one-rod', test_one_rod), &
                    new_unittest('accuracy', test_accuracy), &
                    new_unittest('condition', test_condition), &
                    new_unittest('two-steps', test_two_steps), &
                    new_unittest('unknown', test_unknown)]
    end subroutine collect_statements

    subroutine examine(error, name, runs, statement)
        type(error_type), allocatable, intent(out) :: error
        character(*), intent(in) :: name
        integer, intent(in) :: runs
        type(statement_t), intent(out) :: statement

        type(error_t), allocatable :: failure

        call examine_statement(name, runs, 1_i8, 2, statement, failure)
        call check_passes(error, message_of(failure))
    end subroutine examine

    !> A rod does not turn the satellite about its own axis: a manoeuvre by one rod leaves the offset along it
    !> better than the others, and some other axis worse than two rods.
    subroutine test_one_rod(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s
        integer :: i

        call examine(error, 'one-rod', 0, s)
        if (.not. allocated(error)) call check(error, size(s%rows), 12)
        if (allocated(error)) return
        call check(error, s%verdict == HOLDS_IN_PART .and. index(s%found, '4 of 27') > 0, s%found)
        do i = 1, 12, 4
            if (.not. allocated(error)) call check(error, maxval(s%rows(i)%predicted) < &
                minval([maxval(s%rows(i + 1)%predicted), maxval(s%rows(i + 2)%predicted), maxval(s%rows(i + 3)%predicted)]))
        end do
    end subroutine test_one_rod

    !> Better than 0.02, 0.01, 0.02 mm in the best case: Table 6.1; and the runs agree with theory.
    subroutine test_accuracy(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s
        integer :: i

        call examine(error, 'accuracy', 40, s)
        if (.not. allocated(error)) call check(error, s%verdict == HOLDS, s%found)
        do i = 1, 3
            if (allocated(error)) return
            call check(error, all(abs(s%rows(i)%rms/s%rows(i)%predicted - 1) < 4/sqrt(80.0_dp)), s%rows(i)%case_name)
        end do
    end subroutine test_accuracy

    !> Full and reduced state are equally well conditioned; across q alone the full one is singular to rounding.
    subroutine test_condition(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s

        call examine(error, 'condition', 0, s)
        if (.not. allocated(error)) call check(error, size(s%rows), 9)
        if (.not. allocated(error)) call check(error, all(abs(s%rows(1::3)%condition/s%rows(2::3)%condition - 1) < 0.05_dp))
        if (.not. allocated(error)) call check(error, all(s%rows(3::3)%condition > 1e12_dp) .and. s%verdict == HOLDS, s%found)
    end subroutine test_condition

    !> More information is never worse: each set is at least as good as each of its parts, and the sum of all the best.
    subroutine test_two_steps(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s
        integer :: i

        call examine(error, 'two-steps', 0, s)
        if (.not. allocated(error)) call check(error, size(s%rows), 14)
        if (allocated(error)) return
        do i = 1, 6
            if (.not. allocated(error)) call check(error, all(s%rows(7)%predicted <= s%rows(i)%predicted*(1 + 1e-9_dp)))
        end do
        if (.not. allocated(error)) call check(error, all(s%rows(4)%predicted <= min(s%rows(1)%predicted, &
                                                                                     s%rows(2)%predicted)))
        if (.not. allocated(error)) call check(error, s%verdict == HOLDS .and. &
                                               all(s%rows(6)%predicted < 0.01_dp*MILLIMETRE), s%found)
    end subroutine test_two_steps

    subroutine test_unknown(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s
        type(error_t), allocatable :: failure

        call examine_statement('two-rods', 0, 1_i8, 1, s, failure)
        call check_fails(error, message_of(failure), [character(40) :: 'no statement "two-rods"', 'one-rod'])
    end subroutine test_unknown
end module test_statements
