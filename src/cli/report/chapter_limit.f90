!> The report page, beyond the report: every estimator against the theoretical limit.
module gracecg_cli_chapter_limit
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_statistics, only: median_of
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_base_version, only: VERSION
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_cli_html, only: VERDICT_MET, VERDICT_MISSED, VERDICT_NONE
    use gracecg_estimation_estimators, only: ESTIMATOR_NAMES, REPORT_ESTIMATORS
    use gracecg_estimation_report_options, only: report_options
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES
    use gracecg_simulation_simulator, only: simulator_t
    use gracecg_simulation_switches, only: error_switches_t, new_switched_simulator, switch_off
    use gracecg_planning_bound, only: case_bound_t, bound_of_case
    use gracecg_studies_monte_carlo, only: monte_carlo_t, run_monte_carlo, error_statistics_t, statistics_of
    use gracecg_cli_console, only: console_t
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid
    use gracecg_cli_book, only: report_book_t, add_figure, add_finding, book_file, COMMAND
    use gracecg_cli_number_text, only: pick_text, fixed_text, percent_text, share_text
    implicit none
    private
    public :: add_limit_chapter, MOST_LIMIT_RUNS

    integer, parameter :: MOST_LIMIT_RUNS = 60
    !! Runs of a Monte Carlo of the chapters beyond the report, at most
    integer, parameter :: MOST_SEQUENTIAL_RUNS = 15     !! One takes as long as ten of the others
    integer, parameter :: CASES = size(REPORT_CASE_NAMES), ALGORITHMS = size(ESTIMATOR_NAMES)
    real(dp), parameter :: SIGMAS = 3               !! Of the sampling error: so far the bound counts as reached
    character(*), parameter :: BOUND_FILE = 'bound.csv'
    character(1), parameter :: LF = achar(10)
    character(32), parameter :: COLOURS(ALGORITHMS) = [character(32) :: 'linetype 1', 'linetype 2', &
        'linetype 3', 'linetype 4', 'linetype 1 linecolor rgb ink', 'linetype 1 linecolor rgb grey']
    integer, parameter :: LEGEND_TYPES(ALGORITHMS) = [1, 2, 3, 4, 0, 5]

    !> The limit of a case, and what the estimators reach.
    type :: limit_study_t
        real(dp) :: bound(3) = 0                    !! Cramer-Rao, m
        real(dp) :: rms(3, ALGORITHMS) = 0          !! m
        integer :: not_converged(ALGORITHMS) = 0    !! Runs
    end type limit_study_t

contains

    !> Every case with every estimator, the systematic errors off: RMS error, Cramer-Rao bound and their
    !> ratio, as a file, a figure and a table.
    subroutine add_limit_chapter(book, console, error)
        type(report_book_t), intent(inout) :: book
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(limit_study_t) :: studies(CASES)
        integer :: runs

        runs = min(book%runs, MOST_LIMIT_RUNS)
        call study_cases(book, console, runs, studies, error)
        if (.not. allocated(error)) call write_studies(book, runs, studies, error)
        if (allocated(error)) return
        call book%page%chapter('limit', 'Beyond the report: every estimator against the theoretical limit')
        call book%page%paragraph('No unbiased estimate of the offset can have a smaller standard deviation than '// &
                                 'the Cramer-Rao bound of the manoeuvre under the noise of the instruments. The '// &
                                 'bound knows no systematic errors, so here they are off: scale factors, bias '// &
                                 'of the magnetometer, and drag and radiation that are not a straight line in '// &
                                 'time. The four algorithms of the report are joined by `optimal`, which '// &
                                 'weighs all samples by the true noise spectra, and `sequential`, which works '// &
                                 'on them one after the other.')
        call book%page%paragraph('The RMS of '//integer_text(runs)//' runs scatters by '// &
                                 percent_text(sampling_error(runs))//' (one sigma): a ratio below 1 by that '// &
                                 'much is chance. All estimators see the same observations; `sequential`, which takes '// &
                                 'longest, those of the first '//integer_text(min(runs, MOST_SEQUENTIAL_RUNS))// &
                                 ' runs ('//percent_text(sampling_error(min(runs, MOST_SEQUENTIAL_RUNS)))//').')
        call add_figure(book, 'figure_bound', script_of(runs, studies), 'RMS error of the CG offset divided by the '// &
                       'Cramer-Rao bound, '//integer_text(runs)//' runs, systematic errors off (logarithmic). '// &
                       'Vertical lines: one sigma of the sampling error.', &
                       'RMS error of every estimator relative to the bound', &
                       'Three panels, x, y and z, of six groups of six bars, a group a case, a bar an '// &
                       'estimator, beside a line at 1, the bound. The table below has the numbers.', error)
        if (allocated(error)) return
        call add_table(book, runs, studies)
        call add_verdicts(book, runs, studies)
    end subroutine add_limit_chapter

    !> Relative standard deviation of an RMS of many runs.
    pure real(dp) function sampling_error(runs)
        integer, intent(in) :: runs

        sampling_error = 1/sqrt(2.0_dp*runs)
    end function sampling_error

    !> Runs of an estimator.
    pure integer function runs_of(a, runs)
        integer, intent(in) :: a, runs

        runs_of = runs
        if (ESTIMATOR_NAMES(a) == 'sequential') runs_of = min(runs, MOST_SEQUENTIAL_RUNS)
    end function runs_of

    subroutine study_cases(book, console, runs, studies, error)
        type(report_book_t), intent(in) :: book
        type(console_t), intent(inout) :: console
        integer, intent(in) :: runs
        type(limit_study_t), intent(out) :: studies(:)
        type(error_t), allocatable, intent(out) :: error

        type(case_t) :: case
        type(case_bound_t) :: bound
        type(error_switches_t) :: switches
        type(simulator_t) :: simulator
        type(monte_carlo_t) :: results
        type(error_statistics_t) :: statistics
        integer :: i, a, k

        call switch_off(switches, 'systematic', error)
        if (allocated(error)) return
        do i = 1, CASES
            call report_case(REPORT_CASE_NAMES(i), case, error)
            if (.not. allocated(error)) call bound_of_case(case, report_options(REPORT_CASE_NAMES(i)), bound, error)
            if (.not. allocated(error)) call new_switched_simulator(case, switches, simulator, error)
            if (allocated(error)) return
            studies(i)%bound = bound%sigma
            do a = 1, ALGORITHMS
                call console%progress(COMMAND//': bound, '//trim(REPORT_CASE_NAMES(i))//', '// &
                                      trim(ESTIMATOR_NAMES(a))//', '//integer_text(runs_of(a, runs))//' runs')
                call run_monte_carlo(simulator, trim(ESTIMATOR_NAMES(a)), report_options(REPORT_CASE_NAMES(i)), &
                                     book%seed, [(k, k=1, runs_of(a, runs))], book%threads, results, error)
                if (allocated(error)) return
                statistics = statistics_of(results%offset/MILLIMETRE, case%satellite%offset/MILLIMETRE)
                studies(i)%rms(:, a) = statistics%rms*MILLIMETRE
                studies(i)%not_converged(a) = count(.not. results%converged)
            end do
        end do
    end subroutine study_cases

    subroutine write_studies(book, runs, studies, error)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: runs
        type(limit_study_t), intent(in) :: studies(:)
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        character(16) :: labels(3)
        integer :: i, a, axis

        call file%open(book_file(book, BOUND_FILE), 'case,algorithm,axis,runs,rms_mm,bound_mm,ratio,sampling_error', &
                       [character(120) :: 'gracecg '//VERSION//' '//COMMAND, 'seed '//integer_text(book%seed)// &
                        '; systematic errors off; sampling_error: one sigma of the ratio'], error)
        if (allocated(error)) return
        do i = 1, size(studies)
            do a = 1, ALGORITHMS
                labels(1) = REPORT_CASE_NAMES(i)
                labels(2) = ESTIMATOR_NAMES(a)
                do axis = 1, 3
                    labels(3) = AXES(axis)
                    associate (rms => studies(i)%rms(axis, a), bound => studies(i)%bound(axis))
                        call file%row([real(runs_of(a, runs), dp), rms/MILLIMETRE, bound/MILLIMETRE, rms/bound, &
                                       rms/bound*sampling_error(runs_of(a, runs))], labels)
                    end associate
                end do
            end do
        end do
        call file%commit(error)
    end subroutine write_studies

    subroutine add_table(book, runs, studies)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: runs
        type(limit_study_t), intent(in) :: studies(:)

        real(dp) :: ratio
        integer :: i, a, axis

        associate (page => book%page)
            call page%begin_table('Cramer-Rao bound and RMS error of '//integer_text(runs)//' runs, mm; in '// &
                                  'brackets their ratio, to +- '//percent_text(sampling_error(runs)), 'bound_table')
            call page%begin_row()
            call page%column_head('case')
            call page%column_head('axis')
            call page%column_head('bound', numeric=.true.)
            do a = 1, ALGORITHMS
                call page%column_head(trim(ESTIMATOR_NAMES(a)), numeric=.true.)
            end do
            call page%end_row()
            call page%head_end()
            do i = 1, size(studies)
                do axis = 1, 3
                    call page%begin_row(first_of_part=axis == 1)
                    if (axis == 1) call page%row_head(trim(REPORT_CASE_NAMES(i)), rows=3)
                    call page%text_cell(AXES(axis))
                    call page%number_cell(fixed_text(studies(i)%bound(axis)/MILLIMETRE, 5))
                    do a = 1, ALGORITHMS
                        ratio = studies(i)%rms(axis, a)/studies(i)%bound(axis)
                        call page%number_cell(fixed_text(studies(i)%rms(axis, a)/MILLIMETRE, 5)//' ('// &
                                              fixed_text(ratio, 2)//')')
                    end do
                    call page%end_row()
                end do
            end do
            call page%end_table()
        end associate
    end subroutine add_table

    !> Each estimator: reached where all ratios lie within SIGMAS sampling errors of 1. That is the aim of
    !> `optimal` and `sequential`; for the others it is only told.
    subroutine add_verdicts(book, runs, studies)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: runs
        type(limit_study_t), intent(in) :: studies(:)

        real(dp) :: ratios(3, CASES)
        character(:), allocatable :: name, range
        integer :: i, a, reached, kind, missing

        do a = 1, ALGORITHMS
            name = trim(ESTIMATOR_NAMES(a))
            do i = 1, CASES
                ratios(:, i) = studies(i)%rms(:, a)/studies(i)%bound
            end do
            reached = count(abs(ratios - 1) <= SIGMAS*sampling_error(runs_of(a, runs)))
            missing = sum(studies%not_converged(a))
            range = fixed_text(minval(ratios), 2)//' to '//fixed_text(maxval(ratios), 2)
            kind = merge(VERDICT_MET, VERDICT_MISSED, reached == size(ratios) .and. missing == 0)
            if (any(REPORT_ESTIMATORS == ESTIMATOR_NAMES(a))) kind = VERDICT_NONE
            call book%page%verdict(kind, name//': '//share_text(reached, size(ratios))//' at the bound.', &
                                   'Ratios '//range//'; median '//fixed_text(median_of(reshape(ratios, [size(ratios)])), 2)// &
                                   pick_text(missing > 0, '; '//integer_text(missing)//' runs did not converge', &
                                             '')//'.')
            if (kind == VERDICT_NONE) cycle
            call add_finding(book, 'beyond: limit', 'bound_table', name//' reaches the Cramer-Rao bound (the report has '// &
                           'none)', share_text(reached, size(ratios))//' RMS errors within three sigma of '// &
                           'the bound; ratios '//range, kind, pick_text(kind == VERDICT_MET, 'reached', 'missed'))
        end do
    end subroutine add_verdicts

    !> Groups of bars from the file: a group a case, a bar an estimator.
    function script_of(runs, studies) result(script)
        integer, intent(in) :: runs
        type(limit_study_t), intent(in) :: studies(:)
        character(:), allocatable :: script

        real(dp), parameter :: BAR = 0.135_dp           !! Of the width of a group
        type(panel_t) :: panels(3)
        type(legend_item_t) :: legend(ALGORITHMS + 1)
        type(grid_t) :: grid
        character(:), allocatable :: tics
        real(dp) :: highest
        integer :: i, a, axis

        grid%panel_height = 170
        grid%x_low = 0.45_dp
        grid%x_high = CASES + 0.55_dp
        grid%settings = 'set boxwidth '//real_text(0.9_dp*BAR)//LF//'set style fill solid 1 noborder'//LF// &
                        'set logscale y 2'
        highest = 0
        do i = 1, CASES
            highest = max(highest, maxval(studies(i)%rms/spread(studies(i)%bound, 2, ALGORITHMS)))
        end do
        tics = ''
        do i = 1, CASES
            tics = tics//pick_text(i > 1, ', ', '')//'"'//trim(REPORT_CASE_NAMES(i))//'" '//integer_text(i)
        end do
        do axis = 1, 3
            panels(axis)%title = 'RMS error of d_'//AXES(axis)//' / bound'
            panels(axis)%settings = 'set yrange [0.5:'//real_text(1.1_dp*max(2.0_dp, highest))//']'//LF// &
                                    'set xtics ('//tics//')'
            if (axis < 3) panels(axis)%settings = 'set yrange [0.5:'//real_text(1.1_dp*max(2.0_dp, highest))// &
                                                  ']'//LF//'set xtics ("" 1, "" 2, "" 3, "" 4, "" 5, "" 6)'
            do a = 1, ALGORITHMS
                panels(axis)%plot = trim(panels(axis)%plot)//pick_text(a > 1, ',', '')//' '// &
                                    bars_of(axis, a, real_text((a - 0.5_dp*(ALGORITHMS + 1))*BAR))
            end do
            panels(axis)%plot = trim(panels(axis)%plot)//', 1 with lines linetype 5'
        end do
        do a = 1, ALGORITHMS
            legend(a) = legend_item_t(trim(ESTIMATOR_NAMES(a)), LEGEND_TYPES(a), 5)
        end do
        legend(ALGORITHMS + 1) = legend_item_t('bound', 5)
        script = panel_grid('figure_bound', 'RMS error of the CG offset relative to its bound, '// &
                            integer_text(runs)//' runs', grid, panels, legend, data=case_numbers())
    end function script_of

    !> A function of the script: the place of a case.
    function case_numbers() result(script)
        character(:), allocatable :: script

        integer :: i

        script = 'place(name) = '
        do i = 1, CASES
            script = script//'name eq "'//trim(REPORT_CASE_NAMES(i))//'" ? '//integer_text(i)//' : '
        end do
        script = script//'NaN'//LF
    end function case_numbers

    !> The bars of one estimator.
    function bars_of(axis, a, shift) result(plot)
        integer, intent(in) :: axis, a
        character(*), intent(in) :: shift
        character(:), allocatable :: plot

        plot = '"'//BOUND_FILE//'" using (strcol("axis") eq "'//AXES(axis)//'" && strcol("algorithm") eq "'// &
            trim(ESTIMATOR_NAMES(a))//'" ? place(strcol("case")) + ('//shift//') : NaN):"ratio":'// &
            '"sampling_error" with boxerrorbars '//trim(COLOURS(a))//' linewidth 1'
    end function bars_of
end module gracecg_cli_chapter_limit
