!> The report page: Tables 6.1 and 6.2 with Figures 6.2 and 6.3, the error of the offset.
module gracecg_cli_chapter_accuracy
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_cli_html, only: VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_estimation_estimators, only: REPORT_ESTIMATORS
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_simulation_simulator, only: simulator_t, new_simulator
    use gracecg_studies_campaign, only: campaign_t, new_campaign, add_case, run_entry, summarise, verdict_t, &
        campaign_verdict
    use gracecg_studies_campaign_files, only: write_table, write_runs
    use gracecg_cli_campaign_tables, only: REPORT_RUNS
    use gracecg_studies_published_rms, only: allowed_by_fifteen_runs, is_misprint
    use gracecg_studies_published_axes, only: published_axis_limits
    use gracecg_cli_console, only: console_t
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid, LINE_WIDTH_OF_POINTS
    use gracecg_cli_book, only: report_book_t, book_file, add_finding, add_figure, COMMAND
    use gracecg_cli_number_text, only: pick_text, fixed_text, percent_text, share_text
    implicit none
    private
    public :: add_accuracy_chapter

    character(5), parameter :: SATELLITES(2) = [character(5) :: 'front', 'back']
    integer, parameter :: CASES = 3                 !! Of each satellite
    character(*), parameter :: RUNS_FILE = 'montecarlo_runs.csv'
    integer, parameter :: LEAST_ALLOWED = 66        !! Of 72: as many or more are in 93 of 100 cases
    integer, parameter :: POINT_TYPES(CASES) = [3, 12, 4]       !! Star, diamond, square, as in the report

contains

    !> Adds the chapter on the accuracy of the estimates.
    subroutine add_accuracy_chapter(book, console, error)
        type(report_book_t), intent(inout) :: book
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(campaign_t) :: campaign, fifteen
        integer :: i

        call run_campaign(book, console, campaign, error)
        if (allocated(error)) return
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
                               'scatters by millimetres; in y and z it is the best.', &
                               error)
                if (allocated(error)) return
            end do
        end associate
    end subroutine add_accuracy_chapter

    !> All cases with all algorithms.
    subroutine run_campaign(book, console, campaign, error)
        type(report_book_t), intent(in) :: book
        type(console_t), intent(inout) :: console
        type(campaign_t), intent(out) :: campaign
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: calibration
        type(simulator_t) :: simulator
        integer :: a, i

        campaign = new_campaign(REPORT_ESTIMATORS, size(REPORT_CASE_NAMES), book%seed, book%runs, 1, 1)
        do i = 1, size(REPORT_CASE_NAMES)
            call find_calibration(REPORT_CASE_NAMES(i), calibration, error)
            if (.not. allocated(error)) call add_case(campaign, i, calibration, error)
            if (.not. allocated(error)) call new_simulator(calibration%case, simulator, error)
            if (allocated(error)) return
            do a = 1, size(REPORT_ESTIMATORS)
                call console%progress(COMMAND//': '//trim(REPORT_CASE_NAMES(i))//', '// &
                                      trim(REPORT_ESTIMATORS(a))//', '//integer_text(book%runs)//' runs')
                call run_entry(campaign, a, i, simulator, calibration%options, book%threads, error)
                if (allocated(error)) return
            end do
        end do
    end subroutine run_campaign

    !> The campaign of the first n runs: a run's numbers do not depend on the others.
    function first_runs(campaign, n) result(first)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: n
        type(campaign_t) :: first

        integer :: a, i

        first = campaign
        first%runs = n
        do i = 1, size(first%cases)
            do a = 1, size(first%algorithms)
                associate (entry => first%entries(a, i))
                    entry%run = entry%run(:n)
                    entry%offset = entry%offset(:, :n)
                    entry%converged = entry%converged(:n)
                end associate
                call summarise(first, a, i)
            end do
        end do
    end function first_runs

    subroutine add_verdict(book, campaign)
        type(report_book_t), intent(inout) :: book
        type(campaign_t), intent(in) :: campaign

        type(verdict_t) :: verdict
        real(dp) :: sigma
        integer :: kind

        verdict = campaign_verdict(campaign)
        kind = merge(VERDICT_MET, VERDICT_MISSED, verdict%allowed >= LEAST_ALLOWED)
        call book%page%verdict(kind, share_text(verdict%allowed, verdict%published)//' published values '// &
                               'inside.', &
                               'If theory is right, 68 or 69 are to be expected, and 66 or more in 93 '// &
                               'of 100 such reports.')
        call add_finding(book, 'Tables 6.1, 6.2', 'table_6_1', 'RMS errors of six cases and four '// &
                         'algorithms, 15 runs each', &
                       share_text(verdict%allowed, verdict%published)//' lie in the 95 % band of '// &
                       'theory', kind, &
                       pick_text(kind == VERDICT_MET, 'agrees', 'differs'))
        sigma = 1/sqrt(2.0_dp*book%runs)
        kind = merge(VERDICT_MET, VERDICT_PARTLY, verdict%worst_difference <= 4*sigma)
        call book%page%verdict(kind, 'Largest difference of an RMS of '// &
                               integer_text(book%runs)//' runs from theory: '// &
                               percent_text(verdict%worst_difference)//'.', 'One sigma of that many '// &
                               'runs is '// &
                               percent_text(sigma)//'; of '//integer_text(3*size(campaign%cases))// &
                               ' different values about one lies beyond two sigma.')
        call add_finding(book, 'Tables 6.1, 6.2', 'table_6_2', 'theory against '// &
                       integer_text(book%runs)//' runs of this program', &
                       'largest difference '//percent_text(verdict%worst_difference)//', one sigma '// &
                       percent_text(sigma), kind, pick_text(kind == VERDICT_MET, 'agrees', 'beyond 4 sigma'))
        if (verdict%not_converged > 0) then
            call book%page%verdict(VERDICT_MISSED, integer_text(verdict%not_converged)//' estimates did '// &
                                   'not converge.')
        end if
    end subroutine add_verdict

    !> A table of the report: for each case and axis a row as printed, two of ours, one of theory.
    subroutine add_table(book, satellite, campaign, fifteen)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: satellite
        type(campaign_t), intent(in) :: campaign, fifteen

        character(:), allocatable :: id
        logical :: misprint
        integer :: a, i, axis, k, rows
        logical :: inside

        id = 'table_6_'//integer_text(satellite)
        misprint = .false.
        rows = merge(4, 3, book%runs > REPORT_RUNS)
        associate (page => book%page)
            call page%heading('The '//trim(SATELLITES(satellite))//' satellite')
            call page%begin_table('Table 6.'//integer_text(satellite)//'. RMS of the CG offset error of '// &
                                  'the '// &
                                  trim(SATELLITES(satellite))//' satellite, mm', id)
            call page%begin_row()
            call page%column_head('case')
            call page%column_head('axis')
            call page%column_head('RMS')
            do a = 1, size(campaign%algorithms)
                call page%column_head(trim(campaign%algorithms(a)), numeric=.true.)
            end do
            call page%end_row()
            call page%head_end()
            do i = 1, CASES
                k = (satellite - 1)*CASES + i
                associate (ours => campaign%entries(:, k), short => fifteen%entries(:, k))
                    do axis = 1, 3
                        call page%begin_row(first_of_part=.true.)
                        call page%row_head(trim(campaign%cases(k)%name), rows=rows)
                        call page%row_head(AXES(axis), rows=rows)
                        call page%row_head('report, '//integer_text(REPORT_RUNS)//' runs')
                        do a = 1, size(ours)
                            inside = allowed_by_fifteen_runs(ours(a)%published(axis), ours(a)%predicted(axis))
                            misprint = misprint .or. is_misprint(ours(a)%published(axis))
                            call page%judged_cell(merge(VERDICT_MET, VERDICT_MISSED, inside), &
                                                  pick_text(inside, 'inside', 'outside'), &
                                                  fixed_text(ours(a)%published(axis), 5))
                        end do
                        call page%end_row()
                        if (book%runs > REPORT_RUNS) then
                            call add_row(book, 'here, the first '//integer_text(REPORT_RUNS)//' runs', &
                                         [(short(a)%statistics%rms(axis), a=1, size(short))])
                        end if
                        call add_row(book, 'here, '//integer_text(book%runs)//' runs', &
                                     [(ours(a)%statistics%rms(axis), a=1, size(ours))])
                        call add_row(book, 'theory', [(ours(a)%predicted(axis), a=1, size(ours))])
                    end do
                end associate
            end do
            call page%end_table()
            if (misprint) call page%paragraph('front-1, ascrest, z is printed 0.01112; the other '// &
                                              'algorithms and its own x and y say that 0.1112 is meant, '// &
                                              'which stands here.')
        end associate
    end subroutine add_table

    subroutine add_row(book, label, values)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: label
        real(dp), intent(in) :: values(:)           !! mm

        integer :: a

        call book%page%begin_row()
        call book%page%row_head(label)
        do a = 1, size(values)
            call book%page%number_cell(fixed_text(values(a), 5))
        end do
        call book%page%end_row()
    end subroutine add_row

    !> Figure 6.2 or 6.3: two algorithms side by side, x, y and z below each other.
    function script_of(satellite, campaign) result(script)
        integer, intent(in) :: satellite
        type(campaign_t), intent(in) :: campaign
        character(:), allocatable :: script

        type(panel_t) :: panels(3*size(REPORT_ESTIMATORS))
        type(legend_item_t) :: legend(CASES + 2)
        type(grid_t) :: grid
        real(dp) :: limits(2)
        character(:), allocatable :: name, case_name
        integer :: a, i, axis, place

        name = 'figure_6_'//integer_text(satellite + 1)
        grid%columns = 2
        grid%x_label = 'run'
        grid%x_high = REPORT_RUNS + 1
        grid%settings = 'set xtics 5'
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
                panels(place)%plot = real_text(campaign%cases(satellite*CASES)%offset(axis))// &
                                     ' with lines linetype 1 linecolor rgb ink linewidth 1'
                do i = 1, CASES
                    case_name = trim(SATELLITES(satellite))//'-'//integer_text(i)
                    panels(place)%plot = trim(panels(place)%plot)//', "'//RUNS_FILE//'" using '// &
                    '"run":(strcol("case") eq "'// &
                                         case_name//'" && strcol("algorithm") eq '// &
                                         '"'//trim(REPORT_ESTIMATORS(a))// &
                                         '" && column("run") <= '// &
                                         integer_text(REPORT_RUNS)//' ? column("d'//AXES(axis)// &
                                         '_mm") : NaN) with points linetype '// &
                                         integer_text(i)//LINE_WIDTH_OF_POINTS// &
                                         ' pointtype '//integer_text(POINT_TYPES(i))//' pointsize 0.6'
                end do
            end do
        end do
        do i = 1, CASES
            legend(i) = legend_item_t('case '//integer_text(i), i, POINT_TYPES(i))
        end do
        legend(CASES + 1) = legend_item_t('truth', 0)
        legend(CASES + 2) = legend_item_t('printed axis', 5)
        script = panel_grid(name, 'Estimates of the CG offset in 15 runs, '// &
                            trim(SATELLITES(satellite))//' satellite', &
                            grid, panels, legend)
    end function script_of
end module gracecg_cli_chapter_accuracy
