!> The report page: Tables 6.1 and 6.2 with Figures 6.2 and 6.3, the error of the offset.
module gracecg_cli_chapter_accuracy
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_statistics, only: sampling_error
    use gracecg_base_text, only: integer_text, join
    use gracecg_estimation_estimators, only: REPORT_ESTIMATORS
    use gracecg_studies_campaign, only: campaign_t, first_runs, campaign_agreement_t, agreement_of
    use gracecg_studies_campaign_files, only: write_table, write_runs
    use gracecg_studies_published_rms, only: allowed_by_fifteen_runs, is_misprint
    use gracecg_studies_published_axes, only: published_axis_limits
    use gracecg_studies_estimate_windows, only: estimate_counts_t, campaign_windows, count_estimate_windows
    use gracecg_cli_verify, only: estimate_counts_words
    use gracecg_cli_campaign_tables, only: REPORT_RUNS
    use gracecg_cli_document, only: table_rows_t, head_cell, number_cells, text_cell, judged_cell, VERDICT_MET, &
        VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid, curve, level
    use gracecg_cli_report_book, only: report_book_t, book_file, add_figure, add_claim, COMMAND, SATELLITES
    use gracecg_cli_report_drawings, only: add_drawing
    use gracecg_cli_number_text, only: pick_text, fixed_text, percent_text, share_text
    implicit none
    private
    public :: add_accuracy_chapter

    integer, parameter :: CASES = 3                 !! Of each satellite
    integer, parameter :: DECIMALS = 5              !! Of the report's tables
    character(*), parameter :: RUNS_FILE = 'montecarlo_runs.csv'
    integer, parameter :: LEAST_ALLOWED = 66
    !! Of 72: as many or more in 96 of 100 reports drawn with their correlations, tools/wave_likelihood.py
    character(1), parameter :: MARKERS(CASES) = ['*', 'D', 'S']         !! Star, diamond, square, as in the report

contains

    !> Adds the chapter on the accuracy of the estimates.
    subroutine add_accuracy_chapter(book, campaign, error)
        type(report_book_t), intent(inout) :: book
        type(campaign_t), intent(in) :: campaign    !! Of the report's cases and algorithms
        type(error_t), allocatable, intent(out) :: error

        type(campaign_t) :: fifteen
        integer :: i

        call write_table(book_file(book, 'montecarlo.csv'), campaign, COMMAND, error)
        if (.not. allocated(error)) call write_runs(book_file(book, RUNS_FILE), campaign, COMMAND, error)
        if (allocated(error)) return
        fifteen = first_runs(campaign, REPORT_RUNS)

        associate (page => book%page)
            call page%chapter('accuracy', 'How well: Tables 6.1 and 6.2, Figures 6.2 and 6.3')
            call page%paragraph('Many calibrations of each case are simulated, each with its own noise, '// &
                                'and the offset is estimated from each by the report''s four '// &
                                'algorithms. The root mean square (RMS) of the errors over 15 runs is '// &
                                'what the report publishes. It scatters by 18 %: if theory is right, 95 '// &
                                'of 100 published values lie between 0.646 and 1.354 times the RMS that '// &
                                'theory predicts, and here such a value is called inside.')
            call page%paragraph('Theory is a covariance analysis under the instruments'' true noise '// &
                                'spectra, with the bias by scale factors, magnetometer and unmodelled '// &
                                'torques and the short-period density wave. All algorithms here work on '// &
                                'the same observations and, with the report''s weights, agree to five '// &
                                'digits; in the report each had its own random numbers.')
            call add_drawing(page, '4.1', 'batch_processor', 'The batch processor, on which the four algorithms stand. '// &
                             'ASSEST runs it twice, for the attitude and then for the offset; ASCFEST and ASCREST once.')
            call add_verdict(book, campaign)
            do i = 1, size(SATELLITES)
                call add_table(book, i, campaign, fifteen)
                call add_figure(book, 'figure_6_'//integer_text(i + 1), script_of(i, campaign), 'Figure '// &
                                '6.'//integer_text(i + 1)// &
                               '. Estimates of the CG offset of the '//trim(SATELLITES(i))//' satellite '// &
                               'in 15 runs: case 1 (star), case 2 (diamond), case 3 (square). Grey '// &
                               'band: the printed axis. As in the report, the scatter of case 2 sets '// &
                               'the scale of x.', &
                               'Figure 6.'//integer_text(i + 1)//', estimates of 15 runs', &
                               'Twelve panels, four algorithms by three components, of 15 estimates for '// &
                               'each of three cases, scattered about the true offset. In x case 2 '// &
                               'scatters by millimetres; in y and z it is the best.')
                call add_windows_verdict(book, i, campaign)
            end do
        end associate
    end subroutine add_accuracy_chapter

    !> The points of Figure 6.2 or 6.3 against its printed axes.
    subroutine add_windows_verdict(book, satellite, campaign)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: satellite
        type(campaign_t), intent(in) :: campaign

        type(estimate_counts_t) :: counts
        character(:), allocatable :: figure
        integer :: kind

        counts = count_estimate_windows(campaign_windows(campaign, satellite))
        figure = 'Figure 6.'//integer_text(satellite + 1)
        kind = merge(VERDICT_MET, VERDICT_MISSED, counts%met)
        call book%page%verdict(kind, figure//', printed axes: '//estimate_counts_words(counts)//'.', 'Of '// &
                               integer_text(book%runs)//' runs. The report''s own points are inside by the choice of its '// &
                               'axes; a further point of the same distribution need not be. The first 15 runs cover at '// &
                               'least '//percent_text(counts%fill)//' of an axis; that their end intervals are reached '// &
                               'is a matter of chance for so few points, and not judged.')
        call add_claim(book, figure, 'figure_6_'//integer_text(satellite + 1), 'estimates lie within the printed axes', &
                       percent_text(real(counts%inside, dp)/counts%points)//' of '//integer_text(counts%points)// &
                       ' estimates inside', kind, pick_text(counts%met, 'agrees', 'differs'))
    end subroutine add_windows_verdict

    subroutine add_verdict(book, campaign)
        type(report_book_t), intent(inout) :: book
        type(campaign_t), intent(in) :: campaign

        type(campaign_agreement_t) :: found
        character(:), allocatable :: inside, difference
        real(dp) :: sigma
        integer :: kind

        found = agreement_of(campaign)
        inside = share_text(found%allowed, found%published)
        kind = merge(VERDICT_MET, VERDICT_MISSED, found%allowed >= LEAST_ALLOWED)
        call book%page%verdict(kind, inside//' published values inside.', 'If theory is right, 70 are to be '// &
                               'expected, and 66 or more in 96 of 100 such reports.')
        call add_claim(book, 'Tables 6.1, 6.2', 'table_6_1', 'RMS errors of six cases and four algorithms, 15 runs '// &
                       'each', inside//' lie in the 95 % band of theory', kind, &
                       pick_text(kind == VERDICT_MET, 'agrees', 'differs'))
        sigma = sampling_error(book%runs)
        difference = percent_text(found%worst_difference)
        kind = merge(VERDICT_MET, VERDICT_PARTLY, found%worst_difference <= 4*sigma)
        call book%page%verdict(kind, 'Largest difference of an RMS of '//integer_text(book%runs)//' runs from theory: '// &
                               difference//'.', 'One sigma of that many runs is '//percent_text(sigma)//'; of '// &
                               integer_text(3*size(campaign%cases))//' different values about one lies beyond two sigma.')
        call add_claim(book, 'Tables 6.1, 6.2', 'table_6_2', 'theory against '//integer_text(book%runs)//' runs of this '// &
                       'program', 'largest difference '//difference//', one sigma '//percent_text(sigma), kind, &
                       pick_text(kind == VERDICT_MET, 'agrees', 'beyond 4 sigma'))
        if (found%not_converged > 0) call book%page%verdict(VERDICT_MISSED, integer_text(found%not_converged)// &
                                                            ' estimates did not converge.')
    end subroutine add_verdict

    !> A table of the report: for each case and axis what is found here, theory, and what is printed. Where the
    !> algorithms agree here to the digits shown, they have one column.
    subroutine add_table(book, satellite, campaign, fifteen)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: satellite
        type(campaign_t), intent(in) :: campaign, fifteen

        type(table_rows_t) :: rows
        character(24), allocatable :: heads(:)
        character(:), allocatable :: cells
        logical :: misprint, inside, agree
        integer :: a, i, axis, k, columns

        misprint = .false.
        agree = all([((algorithms_agree(campaign, k, axis) .and. algorithms_agree(fifteen, k, axis), axis=1, 3), &
                      k=(satellite - 1)*CASES + 1, satellite*CASES)])
        columns = merge(1, size(campaign%algorithms), agree)
        call book%page%heading('The '//trim(SATELLITES(satellite))//' satellite')
        do i = 1, CASES
            k = (satellite - 1)*CASES + i
            associate (ours => campaign%entries(:, k), short => fifteen%entries(:, k))
                do axis = 1, 3
                    cells = pick_text(axis == 1, head_cell(trim(campaign%cases(k)%name), rows=3), '')// &
                            text_cell(AXES(axis))// &
                            number_cells([(ours(a)%statistics%rms(axis), a=1, columns)], DECIMALS)
                    if (book%runs > REPORT_RUNS) &
                        cells = cells//number_cells([(short(a)%statistics%rms(axis), a=1, columns)], DECIMALS)
                    cells = cells//number_cells([(ours(a)%predicted(axis), a=1, columns)], DECIMALS)
                    do a = 1, size(ours)
                        inside = allowed_by_fifteen_runs(ours(a)%published(axis), ours(a)%predicted(axis))
                        misprint = misprint .or. is_misprint(ours(a)%published(axis))
                        cells = cells//judged_cell(merge(VERDICT_MET, VERDICT_MISSED, inside), &
                                                   pick_text(inside, 'inside', 'outside'), &
                                                   fixed_text(ours(a)%published(axis), DECIMALS))
                    end do
                    call rows%add(cells)
                end do
            end associate
        end do
        heads = [character(24) :: 'case', 'axis', over('here, '//integer_text(book%runs)//' runs')]
        if (book%runs > REPORT_RUNS) heads = [heads, over('the first '//integer_text(REPORT_RUNS)//' of them')]
        heads = [heads, over('theory')]
        do a = 1, size(campaign%algorithms)
            heads = [character(24) :: heads, 'report: '//campaign%algorithms(a)]
        end do
        call book%page%table('Table 6.'//integer_text(satellite)//'. RMS of the CG offset error of the '// &
                             trim(SATELLITES(satellite))//' satellite, mm', heads, rows, 'table_6_'//integer_text(satellite))
        if (agree) then
            call book%page%paragraph('The four algorithms agree here to all digits shown, in every line, and so does '// &
                                     'theory: one column stands for them. The report''s are runs of their own.')
        else
            call book%page%paragraph('Under each head the columns are '//join(campaign%algorithms, ', ')//', in this order.')
        end if
        if (misprint) call book%page%paragraph('front-1, ascrest, z is printed 0.01112; the other algorithms and its '// &
                                               'own x and y say that 0.1112 is meant, which stands here.')

    contains

        !> A head over the columns of the algorithms.
        function over(title) result(titles)
            character(*), intent(in) :: title
            character(24) :: titles(columns)

            titles = ''
            titles(1) = title
        end function over
    end subroutine add_table

    !> Whether all algorithms show the same digits, RMS and theory.
    logical function algorithms_agree(campaign, k, axis) result(agree)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: k, axis              !! Case, component

        integer :: a

        agree = .true.
        associate (entries => campaign%entries(:, k))
            do a = 2, size(entries)
                agree = agree .and. fixed_text(entries(a)%statistics%rms(axis), DECIMALS) == &
                        fixed_text(entries(1)%statistics%rms(axis), DECIMALS) .and. &
                        fixed_text(entries(a)%predicted(axis), DECIMALS) == fixed_text(entries(1)%predicted(axis), DECIMALS)
            end do
        end associate
    end function algorithms_agree

    !> Figure 6.2 or 6.3: two algorithms side by side, x, y and z below each other.
    function script_of(satellite, campaign) result(script)
        integer, intent(in) :: satellite
        type(campaign_t), intent(in) :: campaign
        character(:), allocatable :: script

        type(panel_t) :: panels(3*size(REPORT_ESTIMATORS))
        type(legend_item_t) :: legend(CASES + 2)
        type(grid_t) :: grid
        real(dp) :: limits(2)
        integer :: a, i, axis, place

        grid%columns = 2
        grid%x_label = 'run'
        grid%x_high = REPORT_RUNS + 1
        grid%x_step = 5
        do a = 1, size(REPORT_ESTIMATORS)
            do axis = 1, 3
                place = 6*((a - 1)/2) + 2*(axis - 1) + 1 + mod(a - 1, 2)
                limits = published_axis_limits('6.'//integer_text(satellite + 1), trim(SATELLITES(satellite)), &
                                      trim(REPORT_ESTIMATORS(a)), AXES(axis))/MILLIMETRE
                panels(place)%title = trim(REPORT_ESTIMATORS(a))//': d_'//AXES(axis)//', mm'
                panels(place)%has_limits = any(abs(limits) > 0)
                panels(place)%low = limits(1)
                panels(place)%high = limits(2)
                panels(place)%least = minval([(minval(campaign%entries(a, i)%offset(axis, :REPORT_RUNS)), &
                                               i=(satellite - 1)*CASES + 1, satellite*CASES)])
                panels(place)%greatest = maxval([(maxval(campaign%entries(a, i)%offset(axis, :REPORT_RUNS)), &
                                                  i=(satellite - 1)*CASES + 1, satellite*CASES)])
                panels(place)%curves = level(campaign%cases(satellite*CASES)%offset(axis), 0)
                do i = 1, CASES
                    panels(place)%curves = trim(panels(place)%curves)// &
                        curve(RUNS_FILE, 'run', 'd'//AXES(axis)//'_mm', i, marker=MARKERS(i), most=REPORT_RUNS, &
                              only='case='//trim(SATELLITES(satellite))//'-'//integer_text(i)//',algorithm='// &
                              trim(REPORT_ESTIMATORS(a)))
                end do
            end do
        end do
        do i = 1, CASES
            legend(i) = legend_item_t('case '//integer_text(i), i, MARKERS(i))
        end do
        legend(CASES + 1) = legend_item_t('truth', 0)
        legend(CASES + 2) = legend_item_t('printed axis', 5)
        script = panel_grid(grid, panels, legend)
    end function script_of
end module gracecg_cli_chapter_accuracy
