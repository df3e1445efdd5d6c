!> The report page: Figure 6.6, the field model in place of the magnetometer.
module gracecg_cli_chapter_loss
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text
    use gracecg_studies_magnetometer_loss, only: field_study_t, LOSS_STUDIES, MODEL_FIELD_ERROR, FIELD_SOURCES, &
        ALGORITHMS => LOSS_ALGORITHMS, write_field_studies, write_field_runs
    use gracecg_studies_published_axes, only: published_axis_limits
    use gracecg_studies_estimate_windows, only: estimate_counts_t, loss_windows, count_estimate_windows
    use gracecg_cli_verify, only: estimate_counts_words
    use gracecg_cli_campaign_tables, only: REPORT_RUNS
    use gracecg_cli_document, only: table_rows_t, head_cell, text_cell, VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid, curve, level
    use gracecg_cli_report_book, only: report_book_t, book_file, add_figure, add_claim, add_rms_table, rms_cells, COMMAND
    use gracecg_cli_number_text, only: pick_text, fixed_text, percent_text
    implicit none
    private
    public :: add_loss_chapter

    character(7), parameter :: CASE_NAMES(2) = [character(7) :: 'front-2', 'front-3']
    character(*), parameter :: RUNS_FILE = 'magnetometer_loss_runs.csv'
    character(1), parameter :: MARKERS(2, 2) = reshape(['D', 'd', 'S', 's'], [2, 2])
    !! (measured or model, case): open and filled diamond and square

contains

    !> Adds the chapter on the loss of the magnetometer.
    subroutine add_loss_chapter(book, study, error)
        type(report_book_t), intent(inout) :: book
        type(field_study_t), intent(in) :: study(LOSS_STUDIES)  !! Of the front satellite
        type(error_t), allocatable, intent(out) :: error

        call write_field_studies(book_file(book, 'magnetometer_loss.csv'), COMMAND, book%seed, &
                                 MODEL_FIELD_ERROR, &
                                 study, error)
        if (.not. allocated(error)) call write_field_runs(book_file(book, RUNS_FILE), COMMAND, book%seed, &
                                                          MODEL_FIELD_ERROR, &
                                                          study, error)
        if (allocated(error)) return

        call book%page%chapter('loss', 'When the magnetometer fails: Figure 6.6')
        call book%page%paragraph('The estimators need the field for the magnetic torque. Without '// &
                                 'magnetometer the spherical harmonic model takes its place. As in the '// &
                                 'report the model is wrong by 150 nT (standard deviation) along each '// &
                                 'axis, constant over a calibration; ASCFEST and ASCREST, cases 2 and 3.')
        call add_figure(book, 'figure_6_6', script_of(study(1)%true_offset, study), 'Figure 6.6. Loss of '// &
                        'magnetometer data: estimates of the CG offset in 15 runs, front satellite, '// &
                        'with the measured field (open) and with that of the model (LM, filled). Grey '// &
                        'band: the printed axis.', 'Figure 6.6, estimates with and without magnetometer', &
                       'Six panels, two algorithms by three components, of 15 estimates for cases 2 and '// &
                       '3 with measured and with modelled field. Open and filled marks lie together.')
        call add_table(book, study)
        call add_verdict(book, study)
        call add_windows_verdict(book, study)
    end subroutine add_loss_chapter

    !> The points against the printed axes.
    subroutine add_windows_verdict(book, study)
        type(report_book_t), intent(inout) :: book
        type(field_study_t), intent(in) :: study(LOSS_STUDIES)

        type(estimate_counts_t) :: counts
        integer :: kind

        counts = count_estimate_windows(loss_windows(study))
        kind = merge(VERDICT_MET, VERDICT_MISSED, counts%met)
        call book%page%verdict(kind, 'Figure 6.6, printed axes: '//estimate_counts_words(counts)//'.', 'The first 15 '// &
                               'runs cover at least '//percent_text(counts%fill)//' of an axis.')
        call add_claim(book, 'Figure 6.6', 'figure_6_6', 'estimates lie within the printed axes', &
                       percent_text(real(counts%inside, dp)/counts%points)//' of '//integer_text(counts%points)// &
                       ' estimates inside', kind, pick_text(counts%met, 'agrees', 'differs'))
    end subroutine add_windows_verdict

    subroutine add_table(book, study)
        type(report_book_t), intent(inout) :: book
        type(field_study_t), intent(in) :: study(:)

        type(table_rows_t) :: rows
        integer :: i

        do i = 1, size(study)
            call rows%add(head_cell(trim(study(i)%case_name))//text_cell(trim(study(i)%algorithm))// &
                          text_cell(trim(FIELD_SOURCES(merge(2, 1, study(i)%with_model))))// &
                          rms_cells(study(i)%rms, study(i)%predicted))
        end do
        call add_rms_table(book, 'Figure 6.6', 'magnetometer_loss', [character(16) :: 'case', 'algorithm', 'field'], rows)
    end subroutine add_table

    !> "The impact on the estimation accuracy is very small": by theory, at most a tenth in every component,
    !> or the exceptions are named.
    subroutine add_verdict(book, study)
        type(report_book_t), intent(inout) :: book
        type(field_study_t), intent(in) :: study(:)

        real(dp), parameter :: SMALL = 0.1_dp
        real(dp) :: change(3, size(study)/2)
        character(:), allocatable :: exceptions
        integer :: i, axis, kind

        exceptions = ''
        do i = 1, size(change, 2)
            change(:, i) = study(2*i)%predicted/study(2*i - 1)%predicted - 1
            do axis = 1, 3
                if (change(axis, i) <= SMALL .or. study(2*i)%algorithm /= ALGORITHMS(1)) cycle
                if (exceptions /= '') exceptions = exceptions//', '
                exceptions = exceptions//AXES(axis)//' in '//trim(study(2*i)%case_name)//' (by '// &
                             percent_text(change(axis, i))//' to '// &
                             fixed_text(study(2*i)%predicted(axis)/MILLIMETRE, 4)//' mm)'
            end do
        end do
        if (exceptions == '') then
            kind = VERDICT_MET
            call book%page%verdict(kind, 'The loss hardly matters.', 'By theory no component loses more '// &
                                   'than '// &
                                   percent_text(maxval(change))//'.')
            call add_claim(book, 'Figure 6.6', 'figure_6_6', 'the impact on the accuracy is very small', &
                           'no component loses more than '//percent_text(maxval(change)), kind, 'agrees')
        else
            kind = VERDICT_PARTLY
            call book%page%verdict(kind, 'The loss hardly matters, but for '//exceptions//'.', 'That is '// &
                                   'the best determined component of all; the printed plots, whose x '// &
                                   'axes reach from -4 to 4 mm, cannot show it.')
            call add_claim(book, 'Figure 6.6', 'figure_6_6', 'the impact on the accuracy is very small', &
                           'less than 10 %, but for '//exceptions, kind, 'agrees but for one')
        end if
    end subroutine add_verdict

    function script_of(offset, study) result(script)
        real(dp), intent(in) :: offset(3)           !! True, m
        type(field_study_t), intent(in) :: study(:)
        character(:), allocatable :: script

        type(panel_t) :: panels(3*size(ALGORITHMS))
        type(legend_item_t) :: legend(6)
        type(grid_t) :: grid
        real(dp) :: limits(2)
        integer :: a, i, f, axis, place

        grid%columns = 2
        grid%x_label = 'run'
        grid%x_high = REPORT_RUNS + 1
        grid%x_step = 5
        do a = 1, size(ALGORITHMS)
            do axis = 1, 3
                place = 2*(axis - 1) + a
                limits = published_axis_limits('6.6', 'front', ALGORITHMS(a), AXES(axis))/MILLIMETRE
                panels(place)%title = ALGORITHMS(a)//': d_'//AXES(axis)//', mm'
                panels(place)%has_limits = any(abs(limits) > 0)
                panels(place)%low = limits(1)
                panels(place)%high = limits(2)
                panels(place)%least = minval([(minval(study(i)%offset(axis, :REPORT_RUNS)), &
                                               i=1, size(study))])/MILLIMETRE
                panels(place)%greatest = maxval([(maxval(study(i)%offset(axis, :REPORT_RUNS)), &
                                                  i=1, size(study))])/MILLIMETRE
                panels(place)%curves = level(offset(axis)/MILLIMETRE, 0)
                do i = 1, size(CASE_NAMES)
                    do f = 1, size(FIELD_SOURCES)
                        panels(place)%curves = trim(panels(place)%curves)//points_of(i, a, f, axis)
                    end do
                end do
            end do
        end do
        do i = 1, size(CASE_NAMES)
            legend(2*i - 1) = legend_item_t('case '//integer_text(i + 1), i + 1, MARKERS(1, i))
            legend(2*i) = legend_item_t('case '//integer_text(i + 1)//' LM', i + 1, MARKERS(2, i))
        end do
        legend(5) = legend_item_t('truth', 0)
        legend(6) = legend_item_t('printed axis', 5)
        script = panel_grid(grid, panels, legend)
    end function script_of

    !> The estimates of one case, algorithm and source of the field; the model's a little to the right.
    function points_of(i, a, f, axis) result(plot)
        integer, intent(in) :: i, a, f, axis
        character(:), allocatable :: plot

        plot = curve(RUNS_FILE, 'run', 'd'//AXES(axis)//'_mm', i + 1, marker=MARKERS(f, i), most=REPORT_RUNS, &
                     only='case='//CASE_NAMES(i)//',algorithm='//ALGORITHMS(a)//',magnetometer='//trim(FIELD_SOURCES(f)), &
                     shift=merge(0.3_dp, 0.0_dp, f == 2))
    end function points_of
end module gracecg_cli_chapter_loss
