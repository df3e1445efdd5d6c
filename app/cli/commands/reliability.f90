!> gracecg reliability: what the tests of the operator's beliefs are worth, tried.
module gracecg_cli_reliability
    use gracecg_studies_wrong_beliefs, only: wrong_belief_t, tally_t, all_wrong_beliefs, try_wrong_beliefs, subject_of, &
        size_text, SILENT_SIGMAS, FAR_BEYOND
    use gracecg_cli_work
    implicit none
    private
    public :: declare_reliability, run_reliability

contains

    !> Arguments and help of `gracecg reliability`.
    subroutine declare_reliability(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('reliability', '[CASE ...]', 0, MOST_CASES, 'Spoils simulated calibrations (default front-3) '// &
                                'by one wrong belief of the operator after the other (gains, delays, directions, signs, '// &
                                'interchanged axes, conventions, noise levels), each at up to three sizes, and counts how '// &
                                'often the estimate contradicts it, names it, or is wrong without a word. `bound` says '// &
                                'beforehand what can be detected.', 'gracecg reliability front-3 --only quaternions --runs 1')
        call add_study_options(arguments, '--cases --algorithms --runs', 'optimal', '2')
        call arguments%add_option('--only', 'TEXT', 'wrong beliefs in whose name TEXT stands, e.g. rod, sign, delay')
        call arguments%add_option('--no-causes', '', 'do not look for the causes of contradictions, which takes most of the time')
        call add_study_options(arguments, '--seed --threads --out --format --options')
    end subroutine declare_reliability

    !> The work of `gracecg reliability`.
    subroutine run_reliability(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(study_t) :: study
        type(wrong_belief_t), allocatable :: list(:)
        type(tally_t), allocatable :: tallies(:), all_tallies(:)
        type(data_table_t) :: table
        type(results_t) :: results
        character(:), allocatable :: only, names
        logical :: causes       ! They are looked for
        integer :: i

        causes = .not. arguments%has('--no-causes')
        call arguments%get('--only', only, misuse)
        call take_study(arguments, 'front-3', console, study, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        list = all_wrong_beliefs()
        list = pack(list, [(index(subject_of(list(i)), only) > 0, i=1, size(list))])
        call refuse_if(size(list) == 0, '--only "'//only//'": no wrong belief has that in its name; try rod, '// &
                       'accelerometer, magnetometer, star camera, head, inertia, delay, sign or noise', misuse)
        if (allocated(misuse)) return
        call table%columns_of('case,algorithm,belief,size,runs,detectable_values,refused,contradicted,'// &
                              'own_test,named,silently_wrong,worst_sigmas,own_test_stated,trim,harmful_trim')
        allocate (all_tallies(0))
        call console%expect_parts(size(study%calibrations), 'cases')
        do i = 1, size(study%calibrations)
            call try_wrong_beliefs(study%calibrations(i), padded(study%algorithms), causes, list, study%seed, study%runs, &
                                   study%threads, tallies, error, console)
            if (allocated(error)) return
            call add_rows(trim(study%calibrations(i)%case%name), tallies, table)
            call console%next_part()
            all_tallies = [all_tallies, tallies]
        end do
        do i = 1, size(study%algorithms)
            call show(study%algorithms(i)%text, pack(all_tallies, all_tallies%algorithm == study%algorithms(i)%text), causes, &
                      console)
        end do
        names = join(padded(study%algorithms), ',')
        call results%open('reliability')
        call results%member('algorithms', names)
        call results%member('seed', study%seed)
        call results%publish(table, console, error, study%path, names//', seed '//integer_text(study%seed))
    end subroutine run_reliability

    subroutine add_rows(name, tallies, table)
        character(*), intent(in) :: name        !! Of the case
        type(tally_t), intent(in) :: tallies(:)
        type(data_table_t), intent(inout) :: table

        integer :: i

        do i = 1, size(tallies)
            associate (t => tallies(i))
                call table%add(name, t%algorithm, subject_of(t%wrong), size_text(t%wrong))
                call table%add([real(t%runs, dp), t%times, real([t%refused, t%contradicted, t%found, t%named, t%silent], dp), &
                                t%worst, t%stated, real([t%trimmed, t%harmful], dp)])
            end associate
        end do
    end subroutine add_rows

    !> What is wrong without a word, case by case, and the sums.
    subroutine show(algorithm, tallies, causes, console)
        character(*), intent(in) :: algorithm
        type(tally_t), intent(in) :: tallies(:)     !! Of all cases
        logical, intent(in) :: causes               !! They were looked for
        type(console_t), intent(inout) :: console

        type(tally_t), allocatable :: far(:)

        far = pack(tallies, tallies%times > FAR_BEYOND)
        call console%line(algorithm//': '//integer_text(sum(tallies%runs))//' estimates, each with the one wrong belief of its row')
        call line('contradicted or refused', sum(tallies%contradicted), sum(tallies%runs))
        call line('contradicted by the test of the very belief', sum(tallies%found), sum(tallies%runs))
        call console%line('  '//rounded_text(sum(tallies%stated), 3)//' of them expected of it, by the detectable values '// &
                          'that the estimates state')
        call line('silently wrong, by more than '//rounded_text(SILENT_SIGMAS, 2)//' sigma and what is undetectable', &
                  sum(tallies%silent), sum(tallies%runs))
        call line('with the advice to trim', sum(tallies%trimmed), sum(tallies%runs))
        call line('of these along an axis that is wrong by more than is tolerated', sum(tallies%harmful), sum(tallies%trimmed))
        call line('wrong by more than '//rounded_text(FAR_BEYOND, 2)//' detectable values: contradicted or refused', &
                  sum(far%contradicted), sum(far%runs))
        if (causes) call line('of these the right cause among those named', sum(far%named), sum(far%contradicted))

    contains

        subroutine line(what, number, of_all)
            character(*), intent(in) :: what
            integer, intent(in) :: number, of_all

            call console%line('  '//integer_text(number)//' of '//integer_text(of_all)//' '//what)
        end subroutine line
    end subroutine show
end module gracecg_cli_reliability
