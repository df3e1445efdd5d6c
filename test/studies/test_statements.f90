!> Statements of the report that are examined by `gracecg statements`.
module test_statements
    use vocabulary
    use gracecg_files_data_table, only: data_table_t
    use gracecg_studies_statements
    implicit none
    private
    public :: collect_statements

contains

    subroutine collect_statements(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('one-rod', test_one_rod), &
                    new_unittest('dominance', test_dominance), &
                    new_unittest('arc-length', test_arc_length), &
                    new_unittest('weights', test_weights), &
                    new_unittest('accuracy', test_accuracy), &
                    new_unittest('curved-force', test_curved_force), &
                    new_unittest('condition', test_condition), &
                    new_unittest('two-steps', test_two_steps), &
                    new_unittest('stars', test_stars), &
                    new_unittest('table-and-unknown-name', test_table)]
    end subroutine collect_statements

    !> Examines a statement, which must give so many rows. Cannot the test go on?
    logical function fails(error, name, runs, rows, statement)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name
        integer, intent(in) :: runs, rows
        type(statement_t), intent(out) :: statement
        type(error_t), allocatable :: failure

        call examine_statement(name, runs, 1_i8, 2, statement, failure)
        fails = failed(error, failure)
        if (.not. fails) fails = unmet(error, size(statement%rows), rows, name)
    end function fails

    !> A rod does not turn the satellite about its own axis: a manoeuvre by one rod leaves the offset along it
    !> better than the others, and some other axis worse than two rods.
    subroutine test_one_rod(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s
        integer :: i

        if (fails(error, 'one-rod', 0, 12, s)) return
        call check(error, s%verdict == HOLDS_IN_PART .and. index(s%found, '4 of 27') > 0, s%found)
        do i = 1, 12, 4
            call check(error, maxval(s%rows(i)%predicted) < &
                minval([maxval(s%rows(i + 1)%predicted), maxval(s%rows(i + 2)%predicted), maxval(s%rows(i + 3)%predicted)]))
        end do
    end subroutine test_one_rod

    !> At the equator (front-3) the field lies along x: the rod along it makes next to no torque, y and z rods turn about
    !> z and y. Each of these dominates all other torques as both do, and leaves the axis that it turns about to noise.
    subroutine test_dominance(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s

        if (fails(error, 'dominance', 0, 12, s)) return
        call check(error, s%verdict == HOLDS_NOT .and. index(s%details, '6 of 9') > 0, s%found)
        call check(error, s%rows(10)%torque_ratio < 3 .and. &
                                               minval(s%rows([9, 11, 12])%torque_ratio) > 15)
        call check(error, maxloc(s%rows(11)%predicted, 1) == 3 .and. &
                                               maxloc(s%rows(12)%predicted, 1) == 2)
        call check(error, minval(s%rows(11:12)%condition) > 10*s%rows(9)%condition)
    end subroutine test_dominance

    !> A straight line in place of the forces never makes an error greater; over the pole, where little of the drag falls
    !> on the signal's axes, the least is gained, at case 1 the most. Runs agree with theory.
    subroutine test_curved_force(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s
        real(dp), dimension(3, 6) :: share, smooth
        integer :: i

        if (fails(error, 'curved-force', 60, 18, s)) return
        do i = 1, 6
            share(:, i) = 1 - (s%rows(3*i)%predicted/s%rows(3*i - 2)%predicted)**2
            smooth(:, i) = 1 - (s%rows(3*i)%predicted/s%rows(3*i - 1)%predicted)**2
            call check(error, all(abs(s%rows(3*i - 2)%rms/s%rows(3*i - 2)%predicted - 1) < &
                                                              4/sqrt(120.0_dp)), s%rows(3*i)%case_name)
        end do
        call check(error, s%verdict == HOLDS_IN_PART .and. all(share > 0), s%found)
        call check(error, all(share(:, [1, 4]) > 0.35_dp .and. share(:, [1, 4]) < 0.65_dp))
        call check(error, all(abs(smooth) < 0.1_dp), 'without the wave')
    end subroutine test_curved_force

    !> Noise alone falls as the arc grows; the y component of front-2, whose noise is least, shows that drag does not.
    subroutine test_arc_length(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s

        if (fails(error, 'arc-length', 0, 18, s)) return
        call check(error, maxval(s%rows(4)%predicted) < maxval(s%rows(1)%predicted)/3 .and. &
                   s%rows(12)%predicted(2) > s%rows(8)%predicted(2), s%found)
        call check(error, s%verdict == HOLDS_NOT .and. &
                                               index(s%found, 'at 60 s in 0 of 3 places') > 0, s%found)
    end subroutine test_arc_length

    !> The star camera alone fixes the rotation, whatever its weight; the accelerometer's weights decide how its axes
    !> share in d.
    subroutine test_weights(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s

        if (fails(error, 'weights', 0, 8, s)) return
        call check(error, all(abs(s%rows(4)%predicted/s%rows(1)%predicted - 1) < 1e-6_dp) .and. &
                   all(s%rows(6)%predicted > [5, 5, 4]*s%rows(1)%predicted), s%found)
        call check(error, s%verdict == HOLDS_IN_PART, s%found)
    end subroutine test_weights

    !> Better than 0.02, 0.01, 0.02 mm in the best case: Table 6.1; and the runs agree with theory.
    subroutine test_accuracy(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s
        integer :: i

        if (fails(error, 'accuracy', 40, 3, s)) return
        call check(error, s%verdict == HOLDS, s%found)
        do i = 1, 3
            call check(error, all(abs(s%rows(i)%rms/s%rows(i)%predicted - 1) < 4/sqrt(80.0_dp)), s%rows(i)%case_name)
        end do
    end subroutine test_accuracy

    !> Full and reduced state are equally well conditioned; across q alone the full one is singular to rounding.
    subroutine test_condition(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s

        if (fails(error, 'condition', 0, 9, s)) return
        call check(error, all(abs(s%rows(1::3)%condition/s%rows(2::3)%condition - 1) < 0.05_dp))
        call check(error, all(s%rows(3::3)%condition > 1e12_dp) .and. s%verdict == HOLDS, s%found)
    end subroutine test_condition

    !> More information is never worse: each set is at least as good as each of its parts, and the sum of all the best.
    subroutine test_two_steps(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s
        integer :: i

        if (fails(error, 'two-steps', 0, 14, s)) return
        do i = 1, 6
            call check(error, all(s%rows(7)%predicted <= s%rows(i)%predicted*(1 + 1e-9_dp)))
        end do
        call check(error, all(s%rows(4)%predicted <= min(s%rows(1)%predicted, &
                                                                                     s%rows(2)%predicted)))
        call check(error, s%verdict == HOLDS .and. &
                                               all(s%rows(6)%predicted < 0.01_dp*MILLIMETRE), s%found)
    end subroutine test_two_steps

    !> The mean number over all attitudes is that of the field's solid angle, 4 asin[sin(a/2) sin(b/2)] of 22 by 16 deg; a
    !> choice of 20 from n is better than the first 20 and not better than all n, whose sigma is smaller by the root of
    !> the number at best.
    subroutine test_stars(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: STARS_OF_CATALOGUE = 4616
        type(statement_t) :: s
        character(8) :: mean
        integer :: i

        if (fails(error, 'stars', 0, 12, s)) return
        write (mean, '(f8.1)') STARS_OF_CATALOGUE*4*asin(sin(11*DEGREE)*sin(8*DEGREE))/(4*PI)
        call check(error, s%verdict == HOLDS_IN_PART .and. index(s%found, trim(adjustl(mean))//' stars') > 0, s%found)
        do i = 1, 12, 2
            associate (first => s%rows(i), best => s%rows(i + 1))
                call check(error, abs(first%stars - best%stars) <= 0 .and. first%stars >= 20 .and. &
                           best%camera_sigma(3) < first%camera_sigma(3) .and. &
                           sum(best%camera_sigma**2) < sum(first%camera_sigma**2), first%case_name)
                ! no star says more than one angle about the boresight at the field's corner, 13.6 deg away
                call check(error, best%camera_sigma(3) > hypot(1.0_dp, 3.0_dp)*ARCSECOND/ &
                                                       sqrt(20.0_dp)/hypot(tan(11*DEGREE), tan(8*DEGREE)))
            end associate
        end do
    end subroutine test_stars

    !> For people the table has the columns that its statement fills; files have all, and empty cells.
    subroutine test_table(error)
        type(error_type), allocatable, intent(out) :: error
        type(statement_t) :: s(2), none
        type(data_table_t) :: table
        type(string_t), allocatable :: lines(:)
        type(error_t), allocatable :: failure

        if (fails(error, 'condition', 0, 9, s(1))) return
        if (fails(error, 'two-steps', 0, 14, s(2))) return
        table = statement_table(s(1:1))
        call table%lines(100, lines)
        call check(error, size(lines), 10)
        if (unmet(error, index(lines(1)%text, 'condition') > 0 .and. &
                                              index(lines(1)%text, 'sigma') == 0, lines(1)%text)) return
        table = statement_table(s)
        call table%csv(lines, failure)
        call check_passes(error, failure)
        if (unmet(error, size(lines), 1 + 9 + 14)) return
        call check(error, index(lines(2)%text, 'condition,front-1,full state (FDE),0,,,,,,,14.6') == 1 .and. &
                   index(lines(2)%text, ',,,,', back=.true.) == len(lines(2)%text) - 3, lines(2)%text)
        call examine_statement('two-rods', 0, 1_i8, 1, none, failure)
        call check_fails(error, failure, 'no statement "two-rods" ... one-rod')
    end subroutine test_table
end module test_statements
