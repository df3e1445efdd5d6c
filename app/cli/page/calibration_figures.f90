!> The figures of one calibration's page: each writes its numbers as CSV, a gnuplot script beside them,
!> and puts the drawing on the page.
module gracecg_cli_calibration_figures
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, NANOMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_version, only: file_comments
    use gracecg_base_text, only: real_text, rounded_text
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_environment_time, only: time_tag
    use gracecg_spacecraft_torque_rods, only: dipole_moment
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_diagnostics, only: fit_diagnostics_t, projected_ellipse, ELLIPSE_95
    use gracecg_cli_gnuplot, only: script_head
    use gracecg_cli_book, only: book_t, book_file, add_figure
    use gracecg_cli_number_text, only: fixed_text
    implicit none
    private
    public :: add_manoeuvre_figure, add_ellipses_figure, add_residuals_figure, add_spectrum_figure

    integer, parameter :: WIDTH = 560           !! Of all figures: on a phone of 390 pixels letters have 11
    integer, parameter :: ELLIPSE_POINTS = 181
    character(1), parameter :: LF = achar(10)
    character(*), parameter :: OMEGA = '\317\211', ROOT = '\342\210\232'
    !! Letter omega and root sign as gnuplot's escapes of UTF-8
    character(*), parameter :: PANEL_MARGINS = 'margins screen 0.15, screen 0.975, screen '

contains

    !> Dipole moments of the rods and the angular acceleration that the fit makes of them.
    subroutine add_manoeuvre_figure(book, knowledge, record, error)
        type(book_t), intent(inout) :: book
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fit_record_t), intent(in) :: record
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        real(dp) :: t
        integer :: i

        call open_table(file, book, 'manoeuvre', 'time_s,mx_a_m2,my_a_m2,mz_a_m2,wdx_rad_s2,wdy_rad_s2,wdz_rad_s2', &
                        knowledge, 'dipole moment of the rods, angular acceleration, body axes', error)
        if (allocated(error)) return
        do i = 1, size(record%epoch)
            t = time_tag(record%epoch(i), record%interval)
            call file%row([t, dipole_moment(knowledge%rods, t), record%angular_acceleration(:, i)])
        end do
        call file%commit(error)
        if (allocated(error)) return
        call add_figure(book, 'manoeuvre', &
                         script_head('manoeuvre', 'The manoeuvre', WIDTH, 560)// &
                         'set multiplot layout 2,1 '//PANEL_MARGINS//'0.10, screen 0.93 spacing screen 0.08'//LF// &
                         time_axis(knowledge)//'set key horizontal outside top right samplen 1.5'//LF// &
                         'set ylabel "moment, A m^2" offset 1.5,0'//LF//'set format x ""'//LF// &
                         'set yrange [*<-1:1<*]'//LF// &
                         three_curves('manoeuvre.csv', 2, '1', 3.0_dp, ' dashtype (6,6)')// &
                         'set format x'//LF//'set xlabel "time, s"'//LF//'unset key'//LF//'set yrange [*:*]'//LF// &
                         'set ylabel "d'//OMEGA//'/dt, 10^{-6} rad/s^2" offset 1.5,0'//LF// &
                         three_curves('manoeuvre.csv', 5, '1e6', 1.5_dp)//'unset multiplot'//LF, &
                        'The rods'' dipole moment in body axes, and the angular acceleration that it makes in the Earth''s '// &
                        'field, as the fit has it. The component of the offset along the angular acceleration cannot '// &
                        'be seen: where all rods swing in phase, it keeps one direction.', 'The manoeuvre', &
                        'Two panels over time: dipole moment of the rods, and angular acceleration', error)
    end subroutine add_manoeuvre_figure

    !> The error ellipsoid, cast on the three planes.
    subroutine add_ellipses_figure(book, about, offset, covariance, error)
        type(book_t), intent(inout) :: book
        character(*), intent(in) :: about           !! The command and what it estimated, for the file
        real(dp), intent(in) :: offset(3)           !! d, m
        real(dp), intent(in) :: covariance(3, 3)    !! m^2
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: PLANES(2, 3) = reshape([1, 2, 1, 3, 2, 3], [2, 3])
        type(csv_writer_t) :: file
        character(:), allocatable :: script
        real(dp) :: points(2, ELLIPSE_POINTS, 3)
        integer :: k, plane

        do plane = 1, 3
            points(:, :, plane) = projected_ellipse(covariance, PLANES(1, plane), PLANES(2, plane), &
                                                    1.0_dp, ELLIPSE_POINTS)/MILLIMETRE
        end do
        call file%open(book_file(book, 'ellipses.csv'), 'xy_x_mm,xy_y_mm,xz_x_mm,xz_z_mm,yz_y_mm,yz_z_mm', &
                       file_comments(about, 'projections of the error ellipsoid of one sigma, about 0'), error)
        if (allocated(error)) return
        do k = 1, ELLIPSE_POINTS
            call file%row([points(:, k, :)])
        end do
        call file%commit(error)
        if (allocated(error)) return
        script = script_head('ellipses', 'Error ellipses of the offset', WIDTH, 560)// &
            'set multiplot layout 2,2 margins screen 0.19, screen 0.97, screen 0.115, screen 0.98 '// &
            'spacing screen 0.2, screen 0.14'//LF//'set grid xtics ytics'//LF//'unset key'//LF// &
            'set xtics autofreq'//LF//'k95 = '//real_text(ELLIPSE_95)//LF
        do plane = 1, 3
            associate (i => PLANES(1, plane), j => PLANES(2, plane))
                script = script//panel('d_'//AXES(i)//', mm', 'd_'//AXES(j)//', mm', offset([i, j])/MILLIMETRE, &
                                       maxval(abs(points(:, :, plane)), 2), 2*plane - 1)
            end associate
        end do
        script = script//'set border 0'//LF//'unset tics'//LF//'unset grid'//LF//'unset label'//LF// &
            'set xlabel ""'//LF//'set ylabel ""'//LF//'set xrange [0:1]'//LF//'set yrange [0:1]'//LF// &
            'set key at graph 0.5, graph 0.7 center'//LF// &
            'plot NaN with points linetype 1 pointtype 7 linecolor rgb ink title "estimate", \'//LF// &
            '    NaN with lines linetype 1 title "one sigma", \'//LF// &
            '    NaN with lines linetype 2 title "95 %"'//LF//'unset multiplot'//LF
        call add_figure(book, 'ellipses', script, &
                        'The ellipsoid cast on the planes of the body axes, about the estimate ('// &
                        fixed_text(offset(1)/MILLIMETRE, 4)//', '//fixed_text(offset(2)/MILLIMETRE, 4)// &
                        ', '//fixed_text(offset(3)/MILLIMETRE, 4)//') mm. Every axis has a scale of its own.', &
                        'Error ellipses', 'Ellipses of one sigma and of 95 % in the planes xy, xz and yz', error)

    contains

        function panel(x_label, y_label, centre, extent, column) result(text)
            character(*), intent(in) :: x_label, y_label
            real(dp), intent(in) :: centre(2), extent(2)    !! mm
            integer, intent(in) :: column
            character(:), allocatable :: text

            real(dp) :: half(2)
            character(:), allocatable :: x, y

            half = 1.15_dp*ELLIPSE_95*max(extent, 1e-3_dp)
            x = real_text(centre(1))
            y = real_text(centre(2))
            text = 'set xlabel "'//x_label//'"'//LF//'set ylabel "'//y_label//'" offset 1,0'//LF// &
                'set xtics '//tic_step(half(1))//LF//'set ytics '//tic_step(half(2))//LF// &
                'set xrange ['//real_text(centre(1) - half(1))//':'//real_text(centre(1) + half(1))//']'//LF// &
                'set yrange ['//real_text(centre(2) - half(2))//':'//real_text(centre(2) + half(2))//']'//LF// &
                'plot "ellipses.csv" using ('//x//' + k95*$'//digit(column)//'):('//y//' + k95*$'// &
                digit(column + 1)//') with lines linetype 2, \'//LF// &
                '    "" using ('//x//' + $'//digit(column)//'):('//y//' + $'//digit(column + 1)// &
                ') with lines linetype 1, \'//LF// &
                '    "+" using ('//x//'):('//y//') every ::0::0 with points pointtype 7 linecolor rgb ink'//LF
        end function panel

        !> At most four tics over an axis of this half length.
        function tic_step(half) result(text)
            real(dp), intent(in) :: half
            character(:), allocatable :: text

            real(dp) :: power, lead

            power = 10.0_dp**floor(log10(half/2))
            lead = 10
            if (half/2 <= 5*power) lead = 5
            if (half/2 <= 2*power) lead = 2
            text = rounded_text(lead*power, 1)
        end function tic_step

        character(1) function digit(number)
            integer, intent(in) :: number

            digit = achar(iachar('0') + number)
        end function digit
    end subroutine add_ellipses_figure

    !> Residuals of the accelerometer over time, with two standard deviations of the setup's noise.
    subroutine add_residuals_figure(book, knowledge, record, diagnostics, error)
        type(book_t), intent(inout) :: book
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        character(:), allocatable :: script
        integer :: i, axis

        call open_table(file, book, 'residuals', 'time_s,x_m_s2,y_m_s2,z_m_s2', knowledge, &
                        'residuals of the accelerometer, observed minus fitted, body axes', error)
        if (allocated(error)) return
        do i = 1, size(record%epoch)
            call file%row([time_tag(record%epoch(i), record%interval), record%residual(:, i)])
        end do
        call file%commit(error)
        if (allocated(error)) return
        script = script_head('residuals', 'Residuals of the accelerometer', WIDTH, 700)// &
            'set multiplot layout 3,1 '//PANEL_MARGINS//'0.08, screen 0.985 spacing screen 0.035'//LF// &
            time_axis(knowledge)//'unset key'//LF//'set format x ""'//LF
        do axis = 1, 3
            if (axis == 3) script = script//'set format x'//LF//'set xlabel "time, s"'//LF
            script = script//'set ylabel "'//AXES(axis)//', 10^{-9} m/s^2" offset 1.5,0'//LF// &
                'plot "residuals.csv" using 1:(1e9*$'//achar(iachar('1') + axis)//') with lines linetype '// &
                achar(iachar('0') + axis)//' linewidth 1'
            if (diagnostics%residuals(axis)%noise_known) &
                script = script//', \'//LF//'    '//limit(2*diagnostics%residuals(axis)%expected_rms)//', \'//LF// &
                '    '//limit(-2*diagnostics%residuals(axis)%expected_rms)
            script = script//LF
        end do
        call add_figure(book, 'residuals', script//'unset multiplot'//LF, &
                        'Observed minus fitted. Dashed: two standard deviations of the noise of the setup.', &
                        'Residuals over time', 'Three panels over time: residuals of accelerometer axes x, y, z', error)

    contains

        function limit(value) result(text)
            real(dp), intent(in) :: value
            character(:), allocatable :: text

            text = rounded_text(value/NANOMETRE, 6)//' with lines linetype 5'
        end function limit
    end subroutine add_residuals_figure

    !> Amplitude spectrum of the residuals beside that of the setup's noise, one-sided.
    subroutine add_spectrum_figure(book, knowledge, diagnostics, error)
        type(book_t), intent(inout) :: book
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        character(:), allocatable :: script, column
        integer :: k, axis, i

        associate (d => diagnostics)
            call open_table(file, book, 'spectrum', 'frequency_hz,x_m_s2_sqrt_hz,y_m_s2_sqrt_hz,z_m_s2_sqrt_hz,'// &
                            'expected_x_m_s2_sqrt_hz,expected_y_m_s2_sqrt_hz,expected_z_m_s2_sqrt_hz', knowledge, &
                            'amplitude spectrum of the residuals and of the noise of the setup, one-sided', error)
            if (allocated(error)) return
            do k = 2, size(d%frequency)         ! 0 has no place on a logarithmic axis
                call file%row([d%frequency(k), one_sided(d%density(:, k)), one_sided(d%expected_density(:, k))])
            end do
            call file%commit(error)
            if (allocated(error)) return
            call open_table(file, book, 'spectrum_bands', &
                            'frequency_hz,x_m_s2_sqrt_hz,y_m_s2_sqrt_hz,z_m_s2_sqrt_hz', knowledge, &
                            'the same, means of the power over thirds of octaves', error)
            if (allocated(error)) return
            do k = 1, size(d%band_frequency)
                call file%row([d%band_frequency(k), one_sided(d%band_density(:, k))])
            end do
            call file%commit(error)
            if (allocated(error)) return
        end associate
        script = script_head('spectrum', 'Spectrum of the residuals', WIDTH, 860)// &
            'set multiplot layout 3,1 margins screen 0.185, screen 0.975, screen 0.07, screen 0.925 '// &
            'spacing screen 0.03'//LF// &
            'set logscale xy'//LF//'set format y "10^{%L}"'//LF//'set format x ""'//LF// &
            'set grid xtics ytics'//LF// &
            'set xrange ['//rounded_text(0.9_dp*diagnostics%frequency(2), 4)//':'// &
            rounded_text(1.05_dp*diagnostics%frequency(size(diagnostics%frequency)), 4)//']'//LF// &
            'set key horizontal at screen 0.985, screen 0.992 right top samplen 1.2 maxrows 2'//LF
        do i = 1, knowledge%rods%count
            if (knowledge%rods%activations(i)%frequency > 0) script = script//'set arrow from first '// &
                rounded_text(knowledge%rods%activations(i)%frequency, 6)//', graph 0 to first '// &
                rounded_text(knowledge%rods%activations(i)%frequency, &
                    6)//', graph 1 nohead back linetype 5 linewidth 1'//LF
        end do
        do axis = 1, 3
            if (axis == 2) script = script//'unset key'//LF
            if (axis == 3) script = script//'set format x "%g"'//LF//'set xlabel "frequency, Hz"'//LF
            column = achar(iachar('1') + axis)
            script = script//'set ylabel "'//AXES(axis)//', m/s^2/'//ROOT//'Hz" offset 1,0'//LF// &
                'plot "spectrum.csv" using 1:'//column//' with lines linetype 5 dashtype 1 linewidth 0.8 '// &
                'title "residuals", \'//LF
            if (diagnostics%residuals(axis)%noise_known) &
                script = script//'    "" using 1:'//achar(iachar('4') + axis)// &
                ' with lines linetype 2 linewidth 2 title "noise of setup", \'//LF
            script = script//'    "spectrum_bands.csv" using 1:'//column//' with linespoints linetype 1 '// &
                'pointtype 7 pointsize 0.4 title "band means"'//LF
        end do
        call add_figure(book, 'spectrum', script//'unset multiplot'//LF, &
                        'Amplitude spectrum of the residuals, one-sided: periodogram with Hann''s taper, and its means over '// &
                        'thirds of octaves; beside it that of the noise of the setup. Vertical, dashed: the '// &
                        'frequencies of the rods, where the fit has taken the signal out. Lines above the noise '// &
                        'elsewhere are forces that the fit does not know.', 'Spectrum of the residuals', &
                        'Three panels over frequency: spectrum of the residuals and of the expected noise, x, y, z', &
                        error)

    contains

        elemental real(dp) function one_sided(density)
            real(dp), intent(in) :: density     !! Two-sided power

            one_sided = sqrt(2*density)
        end function one_sided
    end subroutine add_spectrum_figure

    !> Begins DIR/NAME.csv.
    subroutine open_table(file, book, name, columns, knowledge, contents, error)
        type(csv_writer_t), intent(inout) :: file
        type(book_t), intent(inout) :: book
        character(*), intent(in) :: name, columns, contents
        type(operator_knowledge_t), intent(in) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        call file%open(book_file(book, name//'.csv'), columns, &
                       file_comments('estimate --report, '//trim(knowledge%name), contents), error)
    end subroutine open_table

    function time_axis(knowledge) result(script)
        type(operator_knowledge_t), intent(in) :: knowledge
        character(:), allocatable :: script

        script = 'set xrange [0:'//real_text(knowledge%duration)//']'//LF
    end function time_axis

    !> Columns `first` to `first` + 2 over the first one, as x, y and z. Where curves may lie on each
    !> other, the last one is dashed.
    function three_curves(file, first, factor, width, last_one) result(script)
        character(*), intent(in) :: file, factor
        integer, intent(in) :: first
        real(dp), intent(in) :: width
        character(*), intent(in), optional :: last_one      !! How z is drawn besides
        character(:), allocatable :: script

        integer :: axis

        script = 'plot'
        do axis = 1, 3
            script = script//' "'//file//'" using 1:('//factor//'*$'//achar(iachar('0') + first + axis - 1)// &
                ') with lines linetype '//achar(iachar('0') + axis)//' linewidth '//rounded_text(width, 3)
            if (axis == 3 .and. present(last_one)) script = script//last_one
            script = script//' title "'//AXES(axis)//'"'
            if (axis < 3) script = script//', \'//LF//'    '
        end do
        script = script//LF
    end function three_curves
end module gracecg_cli_calibration_figures
