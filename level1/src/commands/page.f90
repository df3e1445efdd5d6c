!> The pages of `gracecg level1 estimate` and `gracecg level1 trend`.
module gracecg_level1_page
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: AXES, MILLIMETRE, MICROMETRE, NANOTESLA
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, rounded_text, padded
    use gracecg_base_version, only: VERSION
    use gracecg_environment_time, only: utc_of_gps, decimal_year
    use gracecg_files_file, only: make_directory
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_time, only: gps_date_text
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_judgement, only: offset_remark, VERDICTS, REQUIREMENT
    use gracecg_level1_outcome, only: level1_estimate_t, milliseconds
    use gracecg_level1_lines, only: rod_lines_t, find_rod_lines
    use gracecg_level1_offset, only: level1_solution_t, sigma_of
    use gracecg_level1_results, only: trim_command_t, trim_commands
    use gracecg_level1_trend, only: trend_point_t, level1_trend_t, JULIAN_YEAR
    use gracecg_cli_book, only: book_t, open_book
    use gracecg_cli_calibration_figures, only: add_ellipses_figure
    use gracecg_cli_calibration_page, only: page_folder
    use gracecg_cli_console, only: console_t
    use gracecg_cli_html, only: html_page_t, table_rows_t, head_cell, number_cell, number_cells, text_cell, verdict_cell, &
        VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_level1_figures, only: add_currents_figure, add_field_figure, add_fit_figure, add_level1_spectrum, &
        add_sources_figure, add_trend_figure
    use gracecg_cli_number_text, only: fixed_text, scientific_text, pick_text
    implicit none
    private
    public :: write_level1_page, write_trend_page

    real(dp), parameter :: TWO_SIDED_95 = 1.959964_dp   !! 95 % of a normal distribution lie within +-
    integer, parameter :: KINDS(0:2) = [VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED]        !! By flag

contains

    !> Writes the page of an estimate, and into the folder beside it numbers and scripts of its figures.
    subroutine write_level1_page(path, source, calibration, setup, estimate, console, error)
        character(*), intent(in) :: path        !! Of the page
        character(*), intent(in) :: source      !! Folder of the Level-1 files
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(in) :: estimate
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(book_t) :: book
        character(:), allocatable :: about

        call make_directory(page_folder(path), error)
        if (allocated(error)) return
        call open_book(book, page_folder(path))
        about = 'level1 estimate, satellite '//calibration%satellite//', '//calibration%date
        call book%page%begin('CG offset of satellite '//calibration%satellite//', '//calibration%date, &
                             'Estimated from the Level-1 files of `'//source//'`: '// &
                             integer_text(count(calibration%spans%used))//' of '//integer_text(size(calibration%spans))// &
                             ' spans, from '//trim(calibration%spans_from)//'.')
        call write_result(setup, estimate, book%page)
        call write_sources(estimate, book%page)
        call add_sources_figure(book, about, estimate, error)
        if (allocated(error)) return
        call write_spans(calibration, estimate%solutions(1), book%page)
        call add_currents_figure(book, about, calibration, error)
        if (.not. allocated(error)) call add_field_figure(book, about, calibration, error)
        if (allocated(error)) return
        call book%page%chapter('fit', 'The fit')
        call add_fit_figure(book, about, calibration, estimate, error)
        if (.not. allocated(error)) call add_level1_spectrum(book, about, calibration, estimate, setup%band, error)
        if (.not. allocated(error)) call add_ellipses_figure(book, about, estimate%solutions(1)%offset, &
                                                            estimate%solutions(1)%covariance, error)
        if (allocated(error)) return
        call write_rods(setup, estimate, book%page)
        call write_notes(calibration, estimate, book%page)
        call book%page%paragraph('By gracecg '//VERSION//' level1 estimate. The numbers of the figures (CSV) and '// &
                                 'their gnuplot scripts are in `'//page_folder(path)//'`.')
        call finish(path, book, console, error)
    end subroutine write_level1_page

    subroutine finish(path, book, console, error)
        character(*), intent(in) :: path
        type(book_t), intent(inout) :: book
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        call book%page%write(path, error)
        if (allocated(error)) return
        do i = 1, size(book%reasons)
            call console%warn('the page lacks a figure: '//book%reasons(i)%text)
        end do
    end subroutine finish

    subroutine write_result(setup, estimate, page)
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(in) :: estimate
        type(html_page_t), intent(inout) :: page

        type(trim_command_t), allocatable :: commands(:)
        type(table_rows_t) :: rows
        real(dp) :: sigma(3), correlation(3)
        integer :: i

        associate (first => estimate%solutions(1))
            call page%chapter('result', 'Result')
            call page%verdict(KINDS(first%flag), trim(first%source)//': '//trim(VERDICTS(first%flag))//'.', &
                              trim(first%reason))
            do i = 1, size(estimate%findings)
                call page%verdict(VERDICT_MISSED, 'What is wrong:', estimate%findings(i)%text)
            end do
            sigma = sigma_of(first)
            do i = 1, 3
                associate (d => first%offset(i)/MILLIMETRE, s => sigma(i)/MILLIMETRE)
                    call rows%add(head_cell(AXES(i))//number_cells([d, s], 4)// &
                                  number_cell(fixed_text(d - TWO_SIDED_95*s, 4)//' to '//fixed_text(d + TWO_SIDED_95*s, 4))// &
                                  verdict_cell(merge(VERDICT_MISSED, VERDICT_MET, abs(first%offset(i)) > REQUIREMENT), &
                                               pick_text(abs(first%offset(i)) > REQUIREMENT, 'outside', 'within')))
                end associate
            end do
            call page%table('Offset from the centre of mass to the proof mass, SRF', &
                            [character(18) :: 'axis', 'd, mm', 'sigma, mm', '95 % interval, mm', 'limit 0.1 mm'], rows, &
                            fits=.true.)
            correlation = [first%covariance(1, 2)/(sigma(1)*sigma(2)), first%covariance(1, 3)/(sigma(1)*sigma(3)), &
                           first%covariance(2, 3)/(sigma(2)*sigma(3))]
            call page%paragraph('Correlations: xy '//fixed_text(correlation(1), 3)//', xz '//fixed_text(correlation(2), 3)// &
                                ', yz '//fixed_text(correlation(3), 3)//'. Sigma holds the noise, the leakage of the rods ('// &
                                trim(first%leakage)//') and what is known of scales, gains and field.')
            if (first%leakage == 'a priori') &
                call page%verdict(VERDICT_PARTLY, 'Leakage of the rods and offset are not separable with these spans:', &
                                  'the data determine least '//trim(first%weakest)//'; sigma is that with the a-priori '// &
                                  'leakage. Spans half a revolution apart, where the field is opposite, separate them.')
            call page%heading('What to do next')
            if (first%flag > 1) then
                call page%paragraph('Nothing is to be trimmed by this result.')
                return
            end if
            call page%paragraph('By the requirement, '//trim(offset_remark(first%offset))//'. The commands that take it away:')
            call trim_commands(setup, first%offset, commands)
            if (size(commands) > 0) call page%bullet_list(commands%text)
        end associate
    end subroutine write_result

    subroutine write_sources(estimate, page)
        type(level1_estimate_t), intent(in) :: estimate
        type(html_page_t), intent(inout) :: page

        type(table_rows_t) :: rows
        integer :: i

        call page%chapter('sources', 'Sources side by side')
        do i = 1, size(estimate%solutions)
            associate (one => estimate%solutions(i), first => estimate%solutions(1))
                call rows%add(head_cell(trim(one%source))//number_cells(one%offset/MILLIMETRE, 4)// &
                              number_cells(sigma_of(one)/MILLIMETRE, 4)// &
                              number_cells((one%offset - first%offset)/MICROMETRE, 1)// &
                              number_cells([maxval(abs(one%offset - first%offset)/sigma_of(one))], 1)// &
                              verdict_cell(KINDS(one%flag), trim(VERDICTS(one%flag)))//text_cell(trim(one%reason), wraps=.true.))
            end associate
        end do
        call page%table('Offset by each source of angular acceleration', &
                        [character(16) :: 'source', 'x, mm', 'y, mm', 'z, mm', 'sigma x, mm', 'sigma y, mm', 'sigma z, mm', &
                         'diff. x, um', 'diff. y, um', 'diff. z, um', 'largest, sigma', 'verdict', 'why'], rows)
    end subroutine write_sources

    subroutine write_spans(calibration, first, page)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_solution_t), intent(in) :: first
        type(html_page_t), intent(inout) :: page

        type(table_rows_t) :: rows, alone
        type(rod_lines_t) :: lines
        integer :: i

        call page%chapter('spans', 'Spans')
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                call find_rod_lines(calibration, span, lines)
                call rows%add(head_cell(integer_text(i))// &
                              number_cell(integer_text(calibration%epoch + floor(span%start, i8))//'.'// &
                              integer_text(floor(10*modulo(span%start, 1.0_dp))))// &
                              number_cells([span%stop - span%start], 1)//number_cell(integer_text(size(span%time)))// &
                              number_cell(integer_text(span%flagged))//number_cell(integer_text(span%vetoed))// &
                              number_cell(integer_text(span%outliers))//number_cell(integer_text(span%firings_inside))// &
                              number_cell(line_text(1))//number_cell(line_text(2))//number_cell(line_text(3))// &
                              number_cells(span%mean_field/NANOTESLA, 0)//text_cell(pick_text(span%used, 'yes', &
                                                                                              'no: '//trim(span%reason))))
                if (first%span_sigma(1, i) > 0) &
                    call alone%add(head_cell(integer_text(i))//number_cells(first%span_offset(:, i)/MILLIMETRE, 4)// &
                                   number_cells(first%span_sigma(:, i)/MILLIMETRE, 4)// &
                                   number_cells(first%span_rms(:, i)/1e-12_dp, 0))
            end associate
        end do
        call page%table('Sub-manoeuvres', [character(14) :: 'span', 'start, GPS s', 'length, s', 'samples', 'flagged', 'vetoed', &
                        'outliers', 'firings', 'rod x, Hz, mA', 'rod y', 'rod z', 'Bx, nT', 'By, nT', 'Bz, nT', 'used'], rows)
        if (any(first%span_sigma(1, :) > 0)) &
            call page%table('The offset by each span alone, with the leakage of all, and residuals in the band', &
                            [character(14) :: 'span', 'x, mm', 'y, mm', 'z, mm', 'sigma x, mm', 'sigma y, mm', 'sigma z, mm', &
                             'x, pm/s^{2}', 'y, pm/s^{2}', 'z, pm/s^{2}'], alone)
        if (first%degrees > 0) call page%paragraph('The spans about the result: chi square '// &
            trim(rounded_text(first%chi_square, 3))//' with '//integer_text(first%degrees)//' degrees of freedom.')

    contains

        function line_text(rod) result(text)
            integer, intent(in) :: rod
            character(:), allocatable :: text

            text = fixed_text(lines%frequency(rod), 4)//', '//fixed_text(lines%amplitude(rod), 1)
        end function line_text
    end subroutine write_spans

    subroutine write_rods(setup, estimate, page)
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(in) :: estimate
        type(html_page_t), intent(inout) :: page

        type(table_rows_t) :: rows, leakage
        integer :: k, axis

        call page%chapter('rods', 'Rods, delays, leakage')
        do k = 1, 3
            if (.not. estimate%rods%driven(k)) cycle
            call rows%add(head_cell(AXES(k))//number_cells([setup%rod_gain(k)*setup%rod_sign(k), &
                                                            estimate%rods%gain(k)*setup%rod_gain(k)*setup%rod_sign(k), &
                                                            estimate%rods%gain_sigma(k)*setup%rod_gain(k)], 5))
            do axis = 1, 3
                associate (first => estimate%solutions(1))
                    if (first%leakage == 'none') cycle
                    call leakage%add(head_cell(AXES(k)//' on '//AXES(axis))// &
                                     number_cell(scientific_text(first%leak(axis, k)))// &
                                     number_cell(scientific_text(first%leak_sigma(axis, k)))// &
                                     number_cell(scientific_text(first%leak_rate(axis, k)))// &
                                     number_cell(scientific_text(first%leak_rate_sigma(axis, k))))
                end associate
            end do
        end do
        call page%table('Gains of the rods, A m^{2}/mA', [character(15) :: 'rod', 'said', 'by the attitude', 'sigma'], rows, &
                        fits=.true.)
        call page%paragraph('Currents between samples: '//pick_text(estimate%steps, 'held', 'smooth')//'. The torque lies '// &
                            trim(milliseconds(estimate%rods%delay))//' +- '//trim(milliseconds(estimate%rods%delay_sigma))// &
                            ' ms behind the tags of its current'//pick_text(estimate%accelerometer_delay_sigma > 0, &
                            ', the accelerometer '//trim(milliseconds(estimate%accelerometer_delay))//' +- '// &
                            trim(milliseconds(estimate%accelerometer_delay_sigma))//' ms behind its tags.', '.'))
        if (estimate%solutions(1)%leakage /= 'none') &
            call page%table('Leakage of each rod into each axis of the accelerometer', &
                            [character(24) :: 'rod on axis', 'L, m/s^{2}/mA', 'sigma', 'K, m/s^{2}/(mA/s)', 'sigma'], leakage)
    end subroutine write_rods

    subroutine write_notes(calibration, estimate, page)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(html_page_t), intent(inout) :: page

        call page%chapter('notes', 'Notes')
        if (size(calibration%notes) + size(estimate%remarks) == 0) then
            call page%paragraph('The files gave no reason for a warning.')
            return
        end if
        if (size(calibration%notes) > 0) call page%bullet_list(padded(calibration%notes))
        if (size(estimate%remarks) > 0) call page%bullet_list(padded(estimate%remarks))
    end subroutine write_notes

    !> Writes the page of a trend.
    subroutine write_trend_page(path, satellite, points, trend, limit, console, error)
        character(*), intent(in) :: path            !! Of the page
        character(1), intent(in) :: satellite    !! A to D
        type(trend_point_t), intent(in) :: points(:)
        type(level1_trend_t), intent(in) :: trend
        real(dp), intent(in) :: limit               !! Of the offset, m
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(book_t) :: book
        type(table_rows_t) :: rows, dates, steps
        integer :: i, k

        call make_directory(page_folder(path), error)
        if (allocated(error)) return
        call open_book(book, page_folder(path))
        call book%page%begin('CG offset of satellite '//satellite//' over time', integer_text(size(points))// &
                             ' results of `gracecg level1 estimate`, from '//date_of(points(1)%time)//' to '// &
                             date_of(points(size(points))%time)//' (GPS).')
        call book%page%chapter('trend', 'Trend')
        do k = 1, 3
            call rows%add(head_cell(AXES(k))//number_cells([trend%rate(k), trend%rate_sigma(k)]*JULIAN_YEAR/MICROMETRE, 2)// &
                          number_cells([trend%chi_square(k)], 2)//number_cell(integer_text(trend%degrees)))
        end do
        call book%page%table('Weighted straight lines', [character(18) :: 'axis', 'rate, um/a', 'sigma, um/a', 'chi square', &
                             'degrees of freedom'], rows, fits=.true.)
        do i = 1, size(trend%step_time)
            call steps%add(head_cell(date_of(trend%step_time(i)))//number_cells(trend%step(:, i)/MICROMETRE, 2)// &
                           number_cells(trend%step_sigma(:, i)/MICROMETRE, 2))
        end do
        if (size(trend%step_time) > 0) &
            call book%page%table('Steps at changes of the trim, um', [character(8) :: 'date', 'x', 'y', 'z', 'sigma x', &
                                 'sigma y', 'sigma z'], steps)
        if (trend%passes < 0) then
            call book%page%paragraph('|d| stays below '//fixed_text(limit/MICROMETRE, 0)//' um for 50 years.')
        else if (trend%passes <= points(size(points))%time) then
            call book%page%paragraph('|d| is above '//fixed_text(limit/MICROMETRE, 0)//' um.')
        else
            call book%page%paragraph('|d| passes '//fixed_text(limit/MICROMETRE, 0)//' um on '//date_of(trend%passes)//'.')
        end if
        call add_trend_figure(book, 'level1 trend, satellite '//satellite, points, &
                              [(decimal_year(utc_of_gps(floor(points(i)%time, i8), 0.0_dp)), i=1, size(points))], trend, &
                              limit, error)
        if (allocated(error)) return
        do i = 1, size(points)
            call dates%add(head_cell(date_of(points(i)%time))//number_cells(points(i)%offset/MILLIMETRE, 4)// &
                           number_cells(points(i)%sigma/MILLIMETRE, 4)// &
                           verdict_cell(KINDS(points(i)%flag), trim(VERDICTS(points(i)%flag))))
        end do
        call book%page%table('The dates, mm', [character(8) :: 'date', 'x', 'y', 'z', 'sigma x', 'sigma y', 'sigma z', &
                             'verdict'], dates)
        call book%page%paragraph('By gracecg '//VERSION//' level1 trend. The numbers of the figure (CSV) and its gnuplot '// &
                                 'script are in `'//page_folder(path)//'`.')
        call finish(path, book, console, error)
    end subroutine write_trend_page

    function date_of(time) result(text)
        real(dp), intent(in) :: time    !! GPS s
        character(10) :: text

        character(26) :: full

        full = gps_date_text(floor(time, i8), 0.0_dp)
        text = full(:len(text))
    end function date_of
end module gracecg_level1_page
