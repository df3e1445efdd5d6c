!> The figures of an estimate from Level-1 data, and of a trend: each writes its numbers as CSV, a gnuplot script beside
!> them, and puts the drawing on the page.
module gracecg_level1_figures
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, MICROMETRE, NANOTESLA
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_base_version, only: file_comments
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_offset, only: sigma_of
    use gracecg_level1_residuals, only: span_residuals_t, residual_spectrum_t, find_residuals, find_spectrum
    use gracecg_level1_trend, only: trend_point_t, level1_trend_t, JULIAN_YEAR
    use gracecg_cli_book, only: book_t, book_file, add_figure
    use gracecg_cli_gnuplot, only: script_head
    use gracecg_cli_number_text, only: fixed_text, pick_text
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid
    implicit none
    private
    public :: add_currents_figure, add_field_figure, add_fit_figure, add_level1_spectrum, add_sources_figure, add_trend_figure

    integer, parameter :: MOST_PANELS = 8       !! Spans that are drawn
    integer, parameter :: WIDTH = 560           !! Of all figures
    character(1), parameter :: LF = achar(10)
    character(*), parameter :: ROOT = '\342\210\232', MU = '\302\265'   !! Root sign and mu as gnuplot's escapes of UTF-8
    type(legend_item_t), parameter :: AXES_LEGEND(3) = [legend_item_t('x', 1, 0), legend_item_t('y', 2, 0), &
                                                        legend_item_t('z', 3, 0)]

contains

    !> Net currents of the rods, a panel for each of the first spans.
    subroutine add_currents_figure(book, about, calibration, error)
        type(book_t), intent(inout) :: book
        character(*), intent(in) :: about           !! The command and what it estimated, for the files
        type(level1_calibration_t), intent(in) :: calibration
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: AROUND = 2           ! s, before and behind a span
        type(csv_writer_t) :: file
        type(panel_t), allocatable :: panels(:)
        real(dp) :: longest
        integer :: i, k, n

        n = min(MOST_PANELS, size(calibration%spans))
        allocate (panels(n))
        call file%open(book_file(book, 'currents.csv'), 'span,time_s,rod_x_ma,rod_y_ma,rod_z_ma', &
                       file_comments(about, 'net currents of the rods, time from the begin of each span'), error)
        if (allocated(error)) return
        longest = 0
        do i = 1, n
            associate (span => calibration%spans(i), t => calibration%current_time)
                longest = max(longest, span%stop - span%start)
                do k = 1, size(t)
                    if (t(k) < span%start - AROUND .or. t(k) > span%stop + AROUND) cycle
                    call file%row([real(i, dp), t(k) - span%start, calibration%current(:, k)])
                end do
                panels(i)%title = 'span '//integer_text(i)//pick_text(span%used, '', ', not used')//', mA'
                panels(i)%plot = by_number('currents.csv', i, 2, 3)
                panels(i)%settings = 'set ytics 100'
            end associate
        end do
        call file%commit(error)
        if (allocated(error)) return
        call add_figure(book, 'currents', panel_grid('currents', 'Currents of the rods', &
                        grid_t(panel_height=100, x_label='time from the begin of the span, s', x_low=-AROUND, &
                               x_high=longest + AROUND), panels, AXES_LEGEND), &
                        'Net currents of the rods in '//first_of(n, size(calibration%spans))//'.', 'Currents and spans', &
                        'A panel for each span: currents of the three rods over time', error)
    end subroutine add_currents_figure

    !> Field of the Earth in SRF over the spans.
    subroutine add_field_figure(book, about, calibration, error)
        type(book_t), intent(inout) :: book
        character(*), intent(in) :: about           !! The command and what it estimated, for the files
        type(level1_calibration_t), intent(in) :: calibration
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        type(panel_t) :: panels(1)
        character(:), allocatable :: plot
        real(dp) :: first, last
        integer :: i, k

        call file%open(book_file(book, 'field.csv'), 'span,time_min,x_nt,y_nt,z_nt', &
                       file_comments(about, 'field of the Earth in SRF, time from the begin of the first span'), error)
        if (allocated(error)) return
        first = calibration%spans(1)%start
        last = (calibration%spans(size(calibration%spans))%stop - first)/60
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                do k = 1, size(span%attitude_time)
                    call file%row([real(i, dp), (span%attitude_time(k) - first)/60, span%field(:, k)/NANOTESLA])
                end do
            end associate
        end do
        call file%commit(error)
        if (allocated(error)) return
        plot = ''
        do k = 1, 3
            plot = plot//pick_text(k == 1, '"field.csv"', ', \'//LF//'    ""')//' using 2:($'//integer_text(2 + k)// &
                '/1000) with points pointtype 7 pointsize 0.35 linetype '//integer_text(k)
        end do
        panels(1)%title = 'field in SRF, '//MU//'T'
        panels(1)%plot = plot
        call add_figure(book, 'field', panel_grid('field', 'Field over the spans', &
                        grid_t(panel_height=220, x_label='minutes from the begin of the first', &
                               x_low=-0.03_dp*last - 0.5_dp, x_high=1.03_dp*last + 0.5_dp), panels, AXES_LEGEND), &
                        'The field of the Earth in SRF at the places of the spans. Leakage of the rods and the offset are '// &
                        'told apart where it differs, best where it is opposite.', 'The field over the spans', &
                        'Three components over time', error)
    end subroutine add_field_figure

    !> Acceleration and fit in one span.
    subroutine add_fit_figure(book, about, calibration, estimate, error)
        type(book_t), intent(inout) :: book
        character(*), intent(in) :: about           !! The command and what it estimated, for the files
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        type(span_residuals_t) :: residuals
        type(panel_t) :: panels(3)
        integer :: number, k

        number = findloc(calibration%spans%used, .true., 1)
        call find_residuals(calibration%spans(number), estimate%motion(number), estimate%solutions(1), number, residuals)
        call file%open(book_file(book, 'fit.csv'), 'time_s,observed_x_m_s2,observed_y_m_s2,observed_z_m_s2,band_x_m_s2,'// &
                       'band_y_m_s2,band_z_m_s2,model_x_m_s2,model_y_m_s2,model_z_m_s2', &
                       file_comments(about, 'span '//integer_text(number)//', SRF: accelerations without a parabola, in '// &
                                     'the band of the estimate, and the model there'), error)
        if (allocated(error)) return
        do k = 1, size(residuals%time)
            call file%row([residuals%time(k), residuals%observed(:, k), residuals%observed_band(:, k), &
                           residuals%modelled_band(:, k)])
        end do
        call file%commit(error)
        if (allocated(error)) return
        do k = 1, 3
            panels(k)%title = AXES(k)//', 10^{-9} m/s^2'
            panels(k)%plot = '"fit.csv" using 1:(1e9*$'//integer_text(1 + k)//') with points linetype 5 dashtype 1 '// &
                'pointtype 7 pointsize 0.2, \'//LF// &
                '    "" using 1:(1e9*$'//integer_text(4 + k)//') with lines linetype 1, \'//LF// &
                '    "" using 1:(1e9*$'//integer_text(7 + k)//') with lines linetype 2'
        end do
        call add_figure(book, 'fit', panel_grid('fit', 'Acceleration and fit', &
                        grid_t(panel_height=180, x_label='time from the begin of the span, s', x_low=0.0_dp, &
                               x_high=calibration%spans(number)%stop - calibration%spans(number)%start), panels, &
                        [legend_item_t('samples', 5, 7), legend_item_t('in the band', 1, 0), legend_item_t('model', 2, 0)]), &
                        'Span '//integer_text(number)//': samples of the accelerometer without bias and drift, what of them '// &
                        'lies in the band of the estimate, and the model of it, offset and leakage, by '// &
                        trim(estimate%solutions(1)%source)//'.', 'Acceleration and fit', &
                        'Three panels over time: x, y, z', error)
    end subroutine add_fit_figure

    !> Amplitude spectrum of the residuals.
    subroutine add_level1_spectrum(book, about, calibration, estimate, band, error)
        type(book_t), intent(inout) :: book
        character(*), intent(in) :: about           !! The command and what it estimated, for the files
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        real(dp), intent(in) :: band(2)             !! Of the estimate, Hz
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file, means
        type(residual_spectrum_t) :: spectrum
        type(panel_t) :: panels(3)
        integer :: k

        call find_spectrum(calibration, estimate%motion, estimate%solutions(1), spectrum)
        call file%open(book_file(book, 'spectrum.csv'), 'frequency_hz,x_m_s2_sqrt_hz,y_m_s2_sqrt_hz,z_m_s2_sqrt_hz', &
                       file_comments(about, 'amplitude spectrum of the residuals, one-sided, mean of the spans'), error)
        if (allocated(error)) return
        do k = 2, size(spectrum%frequency)      ! 0 has no place on a logarithmic axis
            call file%row([spectrum%frequency(k), spectrum%density(:, k)])
        end do
        call file%commit(error)
        if (allocated(error)) return
        call means%open(book_file(book, 'spectrum_bands.csv'), 'frequency_hz,x_m_s2_sqrt_hz,y_m_s2_sqrt_hz,z_m_s2_sqrt_hz', &
                        file_comments(about, 'the same, means of the power over thirds of octaves'), error)
        if (allocated(error)) return
        do k = 1, size(spectrum%band_frequency)
            call means%row([spectrum%band_frequency(k), spectrum%band_density(:, k)])
        end do
        call means%commit(error)
        if (allocated(error)) return
        do k = 1, 3
            panels(k)%title = AXES(k)//', m/s^2/'//ROOT//'Hz'
            panels(k)%plot = '"spectrum.csv" using 1:'//integer_text(1 + k)// &
                ' with lines linetype 3 linewidth 0.8, \'//LF// &
                '    "spectrum_bands.csv" using 1:'//integer_text(1 + k)//' with linespoints linetype 1 pointtype 7 pointsize 0.4'
        end do
        call add_figure(book, 'spectrum', panel_grid('spectrum', 'Spectrum of the residuals', &
                        grid_t(panel_height=190, x_label='frequency, Hz', x_low=0.9_dp*spectrum%frequency(2), &
                               x_high=1.05_dp*spectrum%frequency(size(spectrum%frequency)), &
                               settings='set logscale xy'//LF//'set format y "10^{%L}"'//LF//'set grid xtics ytics'//LF// &
                               'set object 2 rectangle from '//trim(fixed_text(band(1), 4))//', graph 0 to '// &
                               trim(fixed_text(band(2), 4))//', graph 1 behind fillcolor rgb band fillstyle solid noborder'), &
                        panels, [legend_item_t('residuals', 3, 0), legend_item_t('means over thirds of octaves', 1, 0)]), &
                        'Amplitude spectrum of what the first source leaves of the accelerations, one-sided, mean of the '// &
                        'spans; shaded, the band that the estimate uses.', 'Spectrum of the residuals', &
                        'Three panels over frequency: x, y, z', error)
    end subroutine add_level1_spectrum

    !> Differences of the sources from the first, with their sigmas.
    subroutine add_sources_figure(book, about, estimate, error)
        type(book_t), intent(inout) :: book
        character(*), intent(in) :: about           !! The command and what it estimated, for the files
        type(level1_estimate_t), intent(in) :: estimate
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: ROW = 26, GAP = 64, LEFT = 110, BOTTOM = 58, TOP = 12
        type(csv_writer_t) :: file
        character(:), allocatable :: script, tics
        real(dp) :: low, high
        integer :: i, k, n, height

        n = size(estimate%solutions)
        call file%open(book_file(book, 'sources.csv'), 'source,dx_um,dy_um,dz_um,sigma_x_um,sigma_y_um,sigma_z_um', &
                       file_comments(about, 'offset by each source less that by the first'), error)
        if (allocated(error)) return
        tics = ''
        do i = 1, n
            associate (one => estimate%solutions(i), first => estimate%solutions(1))
                call file%row([(one%offset - first%offset)/MICROMETRE, sigma_of(one)/MICROMETRE], [one%source])
                if (i > 1) tics = tics//', '
                tics = tics//'"'//trim(one%source)//'" '//integer_text(-i)
            end associate
        end do
        call file%commit(error)
        if (allocated(error)) return
        height = TOP + 3*ROW*(n + 1) + 2*GAP + BOTTOM
        script = script_head('sources', 'Sources side by side', WIDTH, height)// &
            'set multiplot layout 3,1 margins screen '//real_text(real(LEFT, dp)/WIDTH)//', screen 0.965, screen '// &
            real_text(real(BOTTOM, dp)/height)//', screen '//real_text(1 - real(TOP, dp)/height)//' spacing screen '// &
            real_text(real(GAP, dp)/height)//LF//'unset key'//LF//'set ytics ('//tics//')'//LF// &
            'set yrange ['//integer_text(-n - 1)//':0]'//LF//'set grid xtics noytics'//LF// &
            'set arrow from 0, graph 0 to 0, graph 1 nohead linetype 5'//LF
        do k = 1, 3
            low = 0
            high = 0
            do i = 1, n
                associate (one => estimate%solutions(i), first => estimate%solutions(1))
                    low = min(low, one%offset(k) - first%offset(k) - sqrt(one%covariance(k, k)))
                    high = max(high, one%offset(k) - first%offset(k) + sqrt(one%covariance(k, k)))
                end associate
            end do
            script = script//'set xlabel "d_'//AXES(k)//' less that by '//trim(estimate%solutions(1)%source)//', '//MU//'m"'// &
                LF//'set xrange ['//fixed_text((low - 0.06_dp*(high - low))/MICROMETRE, 4)//':'// &
                fixed_text((high + 0.06_dp*(high - low))/MICROMETRE, 4)//']'//LF// &
                'plot "sources.csv" using '//integer_text(1 + k)//':(-$0-1):'//integer_text(4 + k)// &
                ' every ::1 with xerrorbars linetype '//integer_text(k)//' pointtype 7 pointsize 0.6'//LF
        end do
        call add_figure(book, 'sources', script//'unset multiplot'//LF, &
                        'The offset by each source of angular acceleration less that by the first, with one sigma. Sources '// &
                        'agree when they differ by less than three sigma or 10 micrometres.', 'Sources side by side', &
                        'Three panels: x, y, z; a line for each source', error)
    end subroutine add_sources_figure

    !> Offsets of several dates with their lines.
    subroutine add_trend_figure(book, about, points, years, trend, limit, error)
        type(book_t), intent(inout) :: book
        character(*), intent(in) :: about           !! The command and what it estimated, for the files
        type(trend_point_t), intent(in) :: points(:)
        real(dp), intent(in) :: years(:)            !! Dates of the points, decimal
        type(level1_trend_t), intent(in) :: trend
        real(dp), intent(in) :: limit               !! Of the offset, m
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: LINE_POINTS = 400
        type(csv_writer_t) :: file
        type(panel_t) :: panels(3)
        character(:), allocatable :: level
        real(dp) :: time, before, length, low, high
        integer :: i, k

        length = points(size(points))%time - points(1)%time
        call file%open(book_file(book, 'trend.csv'), 'year,dx_um,dy_um,dz_um,sigma_x_um,sigma_y_um,sigma_z_um', &
                       file_comments(about, 'offsets of the dates'), error)
        if (allocated(error)) return
        do i = 1, size(points)
            call file%row([years(i), points(i)%offset/MICROMETRE, points(i)%sigma/MICROMETRE])
        end do
        call file%commit(error)
        if (allocated(error)) return
        call file%open(book_file(book, 'trend_lines.csv'), 'year,dx_um,dy_um,dz_um', &
                       file_comments(about, 'the lines, with a step at every change of the trim'), error)
        if (allocated(error)) return
        do i = 0, LINE_POINTS
            time = points(1)%time + i*length/LINE_POINTS
            call file%row([years(1) + (time - points(1)%time)/JULIAN_YEAR, trend%at(time)/MICROMETRE])
        end do
        call file%commit(error)
        if (allocated(error)) return
        level = fixed_text(limit/MICROMETRE, 0)
        before = 0.03_dp*length/JULIAN_YEAR
        do k = 1, 3
            low = min(minval(points%offset(k) - points%sigma(k)), 0.0_dp)
            high = max(maxval(points%offset(k) + points%sigma(k)), 0.0_dp)
            panels(k)%title = 'd_'//AXES(k)//', '//MU//'m'
            panels(k)%plot = '"trend_lines.csv" using 1:'//integer_text(1 + k)//' with lines linetype 1, \'//LF// &
                '    "trend.csv" using 1:'//integer_text(1 + k)//':'//integer_text(4 + k)// &
                ' with yerrorbars linetype 2 pointtype 7 pointsize 0.5'
            if (high > limit/2) panels(k)%plot = trim(panels(k)%plot)//', \'//LF//'    '//level//' with lines linetype 5'
            if (low < -limit/2) panels(k)%plot = trim(panels(k)%plot)//', \'//LF//'    -'//level//' with lines linetype 5'
        end do
        call add_figure(book, 'trend', panel_grid('trend', 'Offsets of several dates', &
                        grid_t(panel_height=160, x_label='year', x_low=years(1) - before, &
                               x_high=years(1) + length/JULIAN_YEAR + before), panels, &
                        [legend_item_t('line', 1, 0), legend_item_t('result, one sigma', 2, 7), &
                         legend_item_t(level//' um', 5, 0)]), &
                        'The offset at each date with one sigma, and the line with its steps; dashed, the limit, where '// &
                        'it is near.', &
                        'The offset over time', 'Three panels over the years: x, y, z', error)
    end subroutine add_trend_figure

    !> Three columns over one, of the rows whose first column is a number, in the colours of x, y, z.
    function by_number(name, number, x, first) result(plot)
        character(*), intent(in) :: name        !! Of the file
        integer, intent(in) :: number, x, first     !! Row's number, columns of abscissa and first ordinate
        character(:), allocatable :: plot

        integer :: k

        plot = ''
        do k = 0, 2
            plot = plot//pick_text(k == 0, '"'//name//'"', ', \'//LF//'    ""')// &
                ' using ($1=='//integer_text(number)//'?$'//integer_text(x)//':NaN):'//integer_text(first + k)// &
                ' with lines linetype '//integer_text(k + 1)
        end do
    end function by_number

    function first_of(shown, all) result(text)
        integer, intent(in) :: shown, all       !! Spans
        character(:), allocatable :: text

        text = 'all spans'
        if (shown < all) text = 'the first '//integer_text(shown)//' of '//integer_text(all)//' spans'
    end function first_of
end module gracecg_level1_figures
