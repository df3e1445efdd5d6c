!> The page of `gracecg history`: the offset over time, with its error.
module gracecg_cli_history_page
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, rounded_text
    use gracecg_base_version, only: VERSION
    use gracecg_environment_time, only: utc_text, decimal_year
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_files_file, only: make_directory
    use gracecg_estimation_offset_history, only: offset_history_t, history_settings_t
    use gracecg_cli_book, only: book_t, open_book, book_file, add_figure
    use gracecg_cli_calibration_page, only: page_folder
    use gracecg_cli_console, only: console_t
    use gracecg_cli_gnuplot, only: script_head
    use gracecg_cli_html, only: table_rows_t, head_cell, number_cells
    implicit none
    private
    public :: write_history_page

    character(1), parameter :: LF = achar(10)

contains

    !> Writes the page, and its numbers and script into the folder beside it.
    subroutine write_history_page(path, history, settings, console, error)
        character(*), intent(in) :: path        !! Of the page
        type(offset_history_t), intent(in) :: history
        type(history_settings_t), intent(in) :: settings
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(book_t) :: book
        type(table_rows_t) :: rows, each
        integer :: i

        call make_directory(page_folder(path), error)
        if (allocated(error)) return
        call open_book(book, page_folder(path))
        associate (page => book%page, today => history%today)
            call page%begin('History of the CG offset', integer_text(history%calibrations)//' calibrations, the last state '// &
                            'of '//trim(utc_text(today%time))//' UTC')
            call page%chapter('today', 'Today')
            do i = 1, 3
                call rows%add(head_cell(AXES(i))//number_cells([today%filtered(i)/MILLIMETRE, &
                                                                today%filtered_sigma(i)/MILLIMETRE], 4))
            end do
            call page%table('The offset, from the centre of mass to the proof mass, body axes', &
                            [character(9) :: 'axis', 'd, mm', 'sigma, mm'], rows)
            if (history%left_already > 0.5_dp) then
                call page%paragraph('It lies outside of its limit of '//rounded_text(settings%limit/MILLIMETRE, 4)//' mm.')
            else
                if (history%leaves) &
                    call page%paragraph('It will leave '//rounded_text(settings%limit/MILLIMETRE, 4)//' mm on '// &
                                        day_of(2)//'; of '//integer_text(settings%futures)//' futures that were drawn, 68 % '// &
                                        'leave it between '//day_of(1)//' and '//day_of(3)//'.')
                call page%paragraph('Calibrate by '//first_ten(utc_text(history%calibrate_by))//': then it has left the limit '// &
                                    'with a probability of '//rounded_text(settings%risk, 3)//'.')
            end if
            call page%chapter('time', 'Over time')
            call draw(history, settings, book, error)
            if (allocated(error)) return
            call page%paragraph('Between calibrations the offset walks at random, '// &
                                rounded_text(maxval(settings%walk)/1e-6_dp, 4)//' micrometres in a year, beside what is known '// &
                                'of masses that were moved and of the tanks. The band is one sigma of what was known at the '// &
                                'time, the line what all calibrations say.')
            if (history%degrees > 0) &
                call page%paragraph('What the calibrations brought that was not expected has a chi square of '// &
                                    rounded_text(history%statistic, 4)//' for '//integer_text(history%degrees)// &
                                    ' degrees of freedom: probability '//rounded_text(history%probability, 3)//'.')
            call page%chapter('calibrations', 'The calibrations')
            do i = 1, size(history%points)
                associate (point => history%points(i))
                    if (.not. point%is_calibration) cycle
                    call each%add(head_cell(first_ten(utc_text(point%time)))// &
                                  number_cells(point%filtered/MILLIMETRE, 4)//number_cells(point%filtered_sigma/MILLIMETRE, 4)// &
                                  number_cells(point%smoothed/MILLIMETRE, 4))
                end associate
            end do
            call page%table('The offset after each calibration, mm: from those so far, its sigma, from all', &
                            [character(10) :: 'date', 'x', 'y', 'z', 'sigma x', 'sigma y', 'sigma z', 'x, all', 'y, all', &
                             'z, all'], each)
            call page%paragraph('gracecg '//VERSION//' history')
            call page%write(path, error)
        end associate
        if (allocated(error)) return
        do i = 1, size(book%reasons)
            call console%warn('the page lacks a figure: '//book%reasons(i)%text)
        end do

    contains

        function day_of(k) result(text)
            integer, intent(in) :: k
            character(10) :: text

            text = first_ten(utc_text(history%leaving(k)))
        end function day_of
    end subroutine write_history_page

    pure function first_ten(whole) result(text)
        character(*), intent(in) :: whole
        character(10) :: text

        text = whole
    end function first_ten

    subroutine draw(history, settings, book, error)
        type(offset_history_t), intent(in) :: history
        type(history_settings_t), intent(in) :: settings
        type(book_t), intent(inout) :: book
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        character(:), allocatable :: script, limit
        character(1), parameter :: NO_COMMENTS(0) = [character(1) ::]
        character(2) :: mean, sigma, all
        integer :: i

        call file%open(book_file(book, 'history.csv'), 'year,calibration,dx_mm,dy_mm,dz_mm,sigma_x_mm,sigma_y_mm,'// &
                       'sigma_z_mm,smoothed_x_mm,smoothed_y_mm,smoothed_z_mm', NO_COMMENTS, error)
        if (allocated(error)) return
        do i = 1, size(history%points)
            associate (point => history%points(i))
                call file%row([decimal_year(point%time), merge(1.0_dp, 0.0_dp, point%is_calibration), &
                               [point%filtered, point%filtered_sigma, point%smoothed]/MILLIMETRE])
            end associate
        end do
        call file%commit(error)
        if (allocated(error)) return
        limit = rounded_text(settings%limit/MILLIMETRE, 6)
        script = script_head('history', 'The CG offset over time', 760, 620)// &
                 'set multiplot layout 3,1 margins screen 0.13, screen 0.97, screen 0.1, screen 0.97 spacing screen 0.03'//LF// &
                 'set key autotitle columnhead'//LF//'unset key'//LF//'set format x ""'//LF
        do i = 1, 3
            mean = integer_text(2 + i)
            sigma = integer_text(5 + i)
            all = integer_text(8 + i)
            if (i == 3) script = script//'set format x "%.1f"'//LF//'set xlabel "year"'//LF
            script = script//'set ylabel "d_'//AXES(i)//', mm" offset 1,0'//LF// &
                     'plot "history.csv" using 1:($'//trim(mean)//'-$'//trim(sigma)//'):($'//trim(mean)//'+$'//trim(sigma)// &
                     ') with filledcurves linecolor rgb band, \'//LF// &
                     '    "" using 1:'//trim(all)//' with lines linetype 1, \'//LF// &
                     '    "" using ($2 > 0 ? $1 : NaN):'//trim(mean)//':'//trim(sigma)// &
                     ' with yerrorbars linetype 2 pointtype 7 pointsize 0.5, \'//LF// &
                     '    '//limit//' with lines linetype 5, -'//limit//' with lines linetype 5'//LF
        end do
        script = script//'unset multiplot'//LF
        call add_figure(book, 'history', script, 'The offset of each axis: band, one sigma about what was known at the time; '// &
                        'line, from all calibrations; points, after each calibration; dashed, the limit.', &
                        'The CG offset over time', 'Three panels, x, y and z, over the years', error)
    end subroutine draw
end module gracecg_cli_history_page
