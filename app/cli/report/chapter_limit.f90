!> The report page, beyond the report: every estimator against the theoretical limit.
module gracecg_cli_chapter_limit
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_statistics, only: median_of, sampling_error
    use gracecg_base_text, only: integer_text
    use gracecg_estimation_estimators, only: ESTIMATOR_NAMES, REPORT_ESTIMATORS
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_studies_limit, only: limit_study_t, relative_error, at_the_bound, detectable_excess, &
        write_limits
    use gracecg_cli_document, only: table_rows_t, head_cell, number_cell, text_cell, VERDICT_MET, VERDICT_PARTLY, &
        VERDICT_MISSED, VERDICT_NONE
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid, curve, level
    use gracecg_cli_report_book, only: report_book_t, book_file, add_figure, add_claim, COMMAND
    use gracecg_cli_number_text, only: pick_text, fixed_text, percent_text, share_text
    implicit none
    private
    public :: add_limit_chapter

    integer, parameter :: CASES = size(REPORT_CASE_NAMES), ALGORITHMS = size(ESTIMATOR_NAMES)
    character(*), parameter :: BOUND_FILE = 'bound.csv'
    real(dp), parameter :: TELLING_EXCESS = 0.25_dp        !! Excess that runs must show for "at the bound" to be said
    integer, parameter :: STYLES = 6    !! Of the estimators, in turn; a seventh takes the first again
    integer, parameter :: COLOURS(STYLES) = [1, 2, 3, 4, 0, 5]

contains

    !> Every case with every estimator, the systematic errors off: RMS error, Cramer-Rao bound and their
    !> ratio, as a file, a figure and a table.
    subroutine add_limit_chapter(book, studies, error)
        type(report_book_t), intent(inout) :: book
        type(limit_study_t), intent(in) :: studies(CASES)   !! Of the report's cases
        type(error_t), allocatable, intent(out) :: error

        integer :: runs

        runs = maxval(studies(1)%runs)
        call write_limits(book_file(book, BOUND_FILE), COMMAND, book%seed, studies, error)
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
                                 'much is chance. All estimators see the same observations. "At the bound" is an RMS '// &
                                 'within three sigma of it; so many runs would tell an excess of '// &
                                 percent_text(detectable_excess(runs))//' with a probability of 80 %, a smaller one less '// &
                                 'often.')
        call add_figure(book, 'figure_bound', script_of(studies), 'RMS error of the CG offset divided by the '// &
                       'Cramer-Rao bound, '//integer_text(runs)//' runs, systematic errors off (logarithmic). '// &
                       'Vertical lines: one sigma of the sampling error.', &
                       'RMS error of every estimator relative to the bound', &
                       'Three panels, x, y and z, of six groups of six points, a group a case, a point an '// &
                       'estimator, beside a line at 1, the bound. The table below has the numbers.')
        call add_table(book, runs, studies)
        call add_verdicts(book, studies)
    end subroutine add_limit_chapter

    !> Where the report's algorithms agree to the digits shown, they have one column.
    subroutine add_table(book, runs, studies)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: runs
        type(limit_study_t), intent(in) :: studies(:)

        type(table_rows_t) :: rows
        character(16), allocatable :: heads(:)
        character(:), allocatable :: cells
        logical :: agree, shown(ALGORITHMS)
        integer :: i, a, axis

        agree = all([(((rms_text(studies(i), a, axis) == rms_text(studies(i), 1, axis), axis=1, 3), i=1, size(studies)), &
                      a=2, size(REPORT_ESTIMATORS))])
        shown = [(a == 1 .or. a > size(REPORT_ESTIMATORS) .or. .not. agree, a=1, ALGORITHMS)]
        do i = 1, size(studies)
            do axis = 1, 3
                cells = pick_text(axis == 1, head_cell(trim(studies(i)%case_name), rows=3), '')//text_cell(AXES(axis))// &
                        number_cell(fixed_text(studies(i)%bound(axis)/MILLIMETRE, 5))
                do a = 1, ALGORITHMS
                    if (shown(a)) cells = cells//number_cell(rms_text(studies(i), a, axis))
                end do
                call rows%add(cells)
            end do
        end do
        heads = ESTIMATOR_NAMES
        if (agree) heads(1) = 'the report''s'
        call book%page%table('Cramer-Rao bound and RMS error of '//integer_text(runs)//' runs, mm; in brackets their '// &
                             'ratio, to +- '//percent_text(sampling_error(runs)), [character(16) :: 'case', 'axis', &
                             'bound', pack(heads, shown)], rows, 'bound_table')
        if (agree) call book%page%paragraph('The report''s four algorithms agree to all digits shown, in every line: one '// &
                                            'column stands for them.')
    end subroutine add_table

    !> RMS error in mm, and its ratio to the bound.
    function rms_text(study, a, axis) result(text)
        type(limit_study_t), intent(in) :: study
        integer, intent(in) :: a, axis              !! Algorithm, component
        character(16) :: text

        text = fixed_text(study%rms(axis, a)/MILLIMETRE, 5)//' ('//fixed_text(relative_error(study, a, axis), 2)//')'
    end function rms_text

    !> Each estimator: reached where all ratios are 1 but for the sampling error. That is the aim of
    !> `optimal` and `sequential`; for the others it is only told.
    subroutine add_verdicts(book, studies)
        type(report_book_t), intent(inout) :: book
        type(limit_study_t), intent(in) :: studies(:)

        real(dp) :: ratios(3*CASES)
        character(:), allocatable :: name, range
        integer :: i, a, axis, reached, kind, missing
        logical :: telling

        do a = 1, ALGORITHMS
            name = trim(ESTIMATOR_NAMES(a))
            ratios = [((relative_error(studies(i), a, axis), axis=1, 3), i=1, CASES)]
            reached = count(at_the_bound(ratios, studies(1)%runs(a)))
            missing = sum(studies%not_converged(a))
            range = fixed_text(minval(ratios), 2)//' to '//fixed_text(maxval(ratios), 2)
            kind = merge(VERDICT_MET, VERDICT_MISSED, reached == size(ratios) .and. missing == 0)
            telling = detectable_excess(studies(1)%runs(a)) <= TELLING_EXCESS
            if (kind == VERDICT_MET .and. .not. telling) kind = VERDICT_PARTLY
            if (any(REPORT_ESTIMATORS == ESTIMATOR_NAMES(a))) kind = VERDICT_NONE
            call book%page%verdict(kind, name//': '//share_text(reached, size(ratios))// &
                                   pick_text(telling, ' at the bound.', ' not told apart from the bound by so few runs.'), &
                                   'Ratios '//range//'; median '//fixed_text(median_of(ratios), 2)// &
                                   pick_text(missing > 0, '; '//integer_text(missing)//' runs did not converge', &
                                             '')//'.')
            if (kind == VERDICT_NONE) cycle
            call add_claim(book, 'beyond: limit', 'bound_table', name//' reaches the Cramer-Rao bound (the report has '// &
                           'none)', share_text(reached, size(ratios))//' RMS errors within three sigma of '// &
                           'the bound, which would show an excess of '// &
                           percent_text(detectable_excess(studies(1)%runs(a)))//'; ratios '//range, kind, &
                           pick_text(kind == VERDICT_MISSED, 'missed', pick_text(telling, 'reached', 'too few runs')))
        end do
    end subroutine add_verdicts

    !> Groups of points from the file: a group a case, a point an estimator.
    function script_of(studies) result(script)
        type(limit_study_t), intent(in) :: studies(:)
        character(:), allocatable :: script

        real(dp), parameter :: STEP = 0.135_dp          !! Between the points of a group
        type(panel_t) :: panels(3)
        type(legend_item_t) :: legend(ALGORITHMS + 1)
        type(grid_t) :: grid
        real(dp) :: highest
        integer :: i, a, axis

        grid%panel_height = 170
        grid%x_low = 0.45_dp
        grid%x_high = CASES + 0.55_dp
        grid%logarithmic = .true.
        grid%x_names = [character(16) :: REPORT_CASE_NAMES]
        highest = 0
        do i = 1, CASES
            highest = max(highest, maxval(studies(i)%rms/spread(studies(i)%bound, 2, ALGORITHMS)))
        end do
        grid%y_low = 0.5_dp
        grid%y_high = 1.1_dp*max(2.0_dp, highest)
        do axis = 1, 3
            panels(axis)%title = 'RMS error of d_'//AXES(axis)//' / bound'
            do a = 1, ALGORITHMS
                panels(axis)%curves = trim(panels(axis)%curves)// &
                    curve(BOUND_FILE, '', 'ratio', COLOURS(1 + modulo(a - 1, STYLES)), marker='o', error='sampling_error', &
                          only='axis='//AXES(axis)//',algorithm='//trim(ESTIMATOR_NAMES(a)), &
                          shift=(a - 0.5_dp*(ALGORITHMS + 1))*STEP)
            end do
            panels(axis)%curves = trim(panels(axis)%curves)//level(1.0_dp, 5)
        end do
        do a = 1, ALGORITHMS
            legend(a) = legend_item_t(trim(ESTIMATOR_NAMES(a)), COLOURS(1 + modulo(a - 1, STYLES)), 'o')
        end do
        legend(ALGORITHMS + 1) = legend_item_t('bound', 5)
        script = panel_grid(grid, panels, legend)
    end function script_of
end module gracecg_cli_chapter_limit
