!> gracecg reliability: what the tests of the operator's beliefs are worth, tried.
module gracecg_cli_reliability
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, join, padded, rounded_text, string_t
    use gracecg_estimation_estimators, only: ESTIMATOR_NAMES
    use gracecg_files_file, only: check_writable
    use gracecg_files_data_table, only: data_table_t
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_studies_detectable_values, only: beliefs_with_value, find_detectable_values
    use gracecg_studies_wrong_beliefs, only: wrong_belief_t, tally_t, all_wrong_beliefs, try_wrong_beliefs, subject_of, &
        size_text, SILENT_SIGMAS, FAR_BEYOND
    use gracecg_cli_calibration_argument, only: add_options_option, add_cases_option, take_calibrations, MOST_CASES
    use gracecg_cli_arguments, only: arguments_t, refuse_if, MOST_RUNS
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t, add_format_option, take_format
    implicit none
    private
    public :: declare_reliability, run_reliability

contains

    !> Arguments and help of `gracecg reliability`.
    subroutine declare_reliability(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('reliability', '[CASE ...]', 0, MOST_CASES, &
                                'Spoils simulated calibrations by one wrong belief of the operator after the other (gains, '// &
                                'delays, directions, signs, interchanged axes, conventions, noise levels), each at up to '// &
                                'three sizes, and counts how often the estimate contradicts it, names it, or is wrong '// &
                                'without a word. `bound` says beforehand what can be detected.', &
                                'gracecg reliability front-3 --only quaternions --runs 1')
        call add_cases_option(arguments, 'front-3')
        call arguments%add_option('--algorithms', 'LIST', 'of '//join(ESTIMATOR_NAMES, ', ')//' (default optimal)', &
                                  choices=ESTIMATOR_NAMES)
        call arguments%add_option('--only', 'TEXT', 'wrong beliefs in whose name TEXT stands, e.g. rod, sign, delay')
        call arguments%add_option('--runs', 'N', 'of each wrong belief and size (default 2)')
        call arguments%add_option('--power', '', 'each belief with a value wrong by what its own test finds in 80 of 100 runs, '// &
                                  'as fits without noise say, instead of three sizes')
        call arguments%add_option('--no-causes', '', 'do not look for the causes of contradictions, which takes most of the time')
        call arguments%add_option('--seed', 'S', 'of the random numbers (default 1)')
        call arguments%add_option('--threads', 'N', 'to work on (default: the processors of the machine)')
        call arguments%add_option('--out', 'FILE', 'CSV file for the counts')
        call add_format_option(arguments)
        call add_options_option(arguments)
    end subroutine declare_reliability

    !> The work of `gracecg reliability`.
    subroutine run_reliability(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_t), allocatable :: calibrations(:)
        type(wrong_belief_t), allocatable :: list(:)
        type(tally_t), allocatable :: tallies(:), all_tallies(:)
        type(data_table_t) :: table
        type(results_t) :: results
        type(string_t), allocatable :: algorithms(:)
        character(:), allocatable :: only, path
        integer(i8) :: seed
        integer :: runs, threads, with_value, i

        call arguments%get('--algorithms', algorithms, misuse, default='optimal', choices=ESTIMATOR_NAMES)
        call arguments%get('--only', only, misuse, default='')
        call arguments%get('--runs', runs, misuse, default=2, low=1, high=MOST_RUNS)
        call arguments%get('--seed', seed, misuse, default=1_i8)
        call arguments%get_threads(threads, misuse)
        call arguments%get('--out', path, misuse, default='')
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return
        call check_writable(path, error)
        if (.not. allocated(error)) call take_calibrations(arguments, 'front-3', console, calibrations, misuse, error)
        if (allocated(misuse) .or. allocated(error)) return
        list = chosen(all_wrong_beliefs())
        call refuse_if(size(list) == 0, '--only "'//only//'": no wrong belief has that in its name; try rod, '// &
                       'accelerometer, magnetometer, star camera, head, inertia, delay, sign or noise', misuse)
        if (allocated(misuse)) return
        call table%columns_of('case,algorithm,belief,size,runs,detectable_values,refused,contradicted,'// &
                              'own_test,named,silently_wrong,worst_sigmas,own_test_stated')
        allocate (all_tallies(0))
        call console%expect_parts(size(calibrations), 'cases')
        do i = 1, size(calibrations)
            if (arguments%has('--power')) then
                call beliefs_with_value(calibrations(i), list, error)
                if (allocated(error)) return
                list = chosen(list)
                with_value = size(list)
                call find_detectable_values(calibrations(i), threads, list, error, console)
                if (allocated(error)) return
            end if
            call try_wrong_beliefs(calibrations(i), padded(algorithms), .not. arguments%has('--no-causes'), list, seed, runs, &
                                   threads, tallies, error, console)
            if (allocated(error)) return
            call console%next_part()
            call add_rows(trim(calibrations(i)%case%name), tallies, table)
            all_tallies = [all_tallies, tallies]
            if (arguments%has('--power')) &
                call show_power(trim(calibrations(i)%case%name), with_value, size(list), tallies, console)
        end do
        do i = 1, size(algorithms)
            call show(algorithms(i)%text, pack(all_tallies, all_tallies%algorithm == algorithms(i)%text), console)
        end do
        call results%open('reliability')
        call results%member('algorithms', join(padded(algorithms), ','))
        call results%member('seed', seed)
        call results%publish(table, console, error)
        if (.not. allocated(error) .and. path /= '') &
            call table%write(path, [character(80) :: 'gracecg reliability', &
                                                      join(padded(algorithms), ', ')//', seed '//integer_text(seed)], error)

    contains

        !> Those whose name has the text asked for.
        function chosen(from) result(some)
            type(wrong_belief_t), intent(in) :: from(:)
            type(wrong_belief_t), allocatable :: some(:)

            integer :: k

            some = pack(from, [(index(subject_of(from(k)), only) > 0, k=1, size(from))])
        end function chosen
    end subroutine run_reliability

    subroutine add_rows(name, tallies, table)
        character(*), intent(in) :: name        !! Of the case
        type(tally_t), intent(in) :: tallies(:)
        type(data_table_t), intent(inout) :: table

        integer :: i

        do i = 1, size(tallies)
            associate (t => tallies(i))
                call table%add(name)
                call table%add(trim(t%algorithm))
                call table%add(trim(subject_of(t%wrong)))
                call table%add(trim(size_text(t%wrong)))
                call table%add(t%runs)
                call table%add(t%times)
                call table%add(t%refused)
                call table%add(t%contradicted)
                call table%add(t%found)
                call table%add(t%named)
                call table%add(t%silent)
                call table%add(t%worst)
                call table%add(t%stated)
            end associate
        end do
    end subroutine add_rows

    !> How often each belief's own test found it in a case.
    subroutine show_power(name, with_value, looked_for, tallies, console)
        character(*), intent(in) :: name        !! Of the case
        integer, intent(in) :: with_value       !! Beliefs of which `bound` states a value
        integer, intent(in) :: looked_for       !! Those of which fits find one
        type(tally_t), intent(in) :: tallies(:)
        type(console_t), intent(inout) :: console

        character(120) :: line
        integer :: i

        call console%line(name//': '//integer_text(looked_for)//' of '//integer_text(with_value)// &
                          ' beliefs have a value that fits without noise find in 80 of 100 runs')
        write (line, '(t3, a, t40, a, t56, a, t70, a, t82, a)') 'belief', 'wrong by', 'times bound''s', 'algorithm', &
            'found by its own test'
        call console%line(trim(line))
        do i = 1, size(tallies)
            associate (t => tallies(i))
                write (line, '(t3, a, t40, a, t56, f6.2, t70, a, t82, f6.1, a)') trim(subject_of(t%wrong)), &
                    trim(size_text(t%wrong)), t%times, trim(t%algorithm), 100*t%found/real(t%runs, dp), ' %'
                call console%line(trim(line))
            end associate
        end do
    end subroutine show_power

    !> What is wrong without a word, case by case, and the sums.
    subroutine show(algorithm, tallies, console)
        character(*), intent(in) :: algorithm
        type(tally_t), intent(in) :: tallies(:)     !! Of all cases
        type(console_t), intent(inout) :: console

        type(tally_t), allocatable :: far(:)

        far = pack(tallies, tallies%times > FAR_BEYOND)
        call console%line(algorithm//': '//integer_text(sum(tallies%runs))//' estimates with one wrong belief each')
        call line('contradicted or refused', sum(tallies%contradicted), sum(tallies%runs))
        call line('contradicted by the test of the very belief', sum(tallies%found), sum(tallies%runs))
        call console%line('  '//rounded_text(sum(tallies%stated), 3)//' of them expected of it, by the detectable values '// &
                          'that the estimates state')
        call line('silently wrong, by more than '//rounded_text(SILENT_SIGMAS, 2)//' sigma and what is undetectable', &
                  sum(tallies%silent), sum(tallies%runs))
        call line('wrong by more than '//rounded_text(FAR_BEYOND, 2)//' detectable values: contradicted or refused', &
                  sum(far%contradicted), sum(far%runs))
        call line('of these the right cause among those named', sum(far%named), sum(far%contradicted))

    contains

        subroutine line(what, number, of_all)
            character(*), intent(in) :: what
            integer, intent(in) :: number, of_all

            call console%line('  '//integer_text(number)//' of '//integer_text(of_all)//' '//what)
        end subroutine line
    end subroutine show
end module gracecg_cli_reliability
