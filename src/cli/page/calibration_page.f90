!> The page of one calibration: what was observed, the result with its errors, where they come from, the
!> residuals, and a verdict. Made from the observation set and the fit, never from the truth.
module gracecg_cli_calibration_page
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: string_t, integer_text, rounded_text, padded
    use gracecg_files_file, only: make_directory, text_file_t, read_text_file
    use gracecg_environment_time, only: utc_text
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_observations_observation_set, only: observation_set_t, has_orbit
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_diagnostics, only: fit_diagnostics_t, diagnose
    use gracecg_estimation_verdict, only: verdict_t, judge, GRADE_GOOD, GRADE_DOUBTFUL, WANTED_ACCURACY
    use gracecg_cli_console, only: console_t
    use gracecg_cli_html, only: html_page_t, VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_cli_gnuplot, only: NO_GNUPLOT
    use gracecg_cli_calibration_figures, only: drawing_t, draw_manoeuvre, draw_ellipses, draw_residuals, draw_spectrum
    implicit none
    private
    public :: write_calibration_page, page_folder

    real(dp), parameter :: TWO_SIDED_95 = 1.959964_dp   !! 95 % of a normal distribution lie within +-
    character(*), parameter :: PAGE_END = '.html'

    !> The figures of a page.
    type :: drawings_t
        type(drawing_t) :: manoeuvre, ellipses, residuals, spectrum
    end type drawings_t

contains

    !> The folder for the numbers and scripts behind a page: NAME_files for NAME.html.
    pure function page_folder(path) result(folder)
        character(*), intent(in) :: path        !! Of the page
        character(:), allocatable :: folder

        integer :: last

        last = len_trim(path)
        if (last > len(PAGE_END)) then
            if (path(last - len(PAGE_END) + 1:last) == PAGE_END) last = last - len(PAGE_END)
        end if
        folder = path(:last)//'_files'
    end function page_folder

    !> Writes the page, and into its folder the CSV files and gnuplot scripts of its figures. Without
    !> gnuplot the page has its tables only, and the console a warning. The page itself comes last: it
    !> is whole, or it is not there.
    !>
    !> Fails when a file cannot be written.
    subroutine write_calibration_page(path, source, options_file, observations, solution, record, console, error)
        character(*), intent(in) :: path                !! Of the page
        character(*), intent(in) :: source              !! Folder of the observation set
        character(*), intent(in) :: options_file        !! Of --options; empty: none
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record        !! Of the same estimate
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(fit_diagnostics_t) :: diagnostics
        type(verdict_t) :: verdict
        type(drawings_t) :: drawings
        type(html_page_t) :: page

        call diagnose(observations%knowledge, solution, record, diagnostics, error)
        if (allocated(error)) return
        verdict = judge(observations%knowledge, solution, record, diagnostics)
        call draw_all(page_folder(path), observations, solution, record, diagnostics, drawings, console, error)
        if (allocated(error)) return
        associate (knowledge => observations%knowledge)
            call page%begin('CG offset of '//trim(knowledge%name), &
                            'Calibration of '//utc_text(knowledge%epoch)//' UTC, '//rounded_text(knowledge%duration, 6)// &
                            ' s long, estimated with `'//solution%algorithm//'` from the observations alone. The '// &
                            'offset d points from the centre of mass to the proof-mass centre of the '// &
                            'accelerometer, in body axes: x along the satellite, y across, z to the Earth.')
        end associate
        call write_result(solution, diagnostics, verdict, page)
        call write_observed(observations, solution, page)
        call write_manoeuvre(observations, drawings%manoeuvre, page)
        call write_errors(solution, diagnostics, drawings%ellipses, page)
        call write_dependence(solution, record, diagnostics, page)
        call write_residuals(diagnostics, drawings, page)
        call write_findings(verdict, page)
        call write_provenance(path, source, options_file, solution, page, error)
        if (.not. allocated(error)) call page%write(path, error)
    end subroutine write_calibration_page

    subroutine draw_all(folder, observations, solution, record, diagnostics, drawings, console, error)
        character(*), intent(in) :: folder
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(drawings_t), intent(out) :: drawings
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        logical :: told

        associate (knowledge => observations%knowledge)
            call make_directory(folder, error)
            if (.not. allocated(error)) call draw_manoeuvre(folder, knowledge, record, drawings%manoeuvre, error)
            if (.not. allocated(error)) call draw_ellipses(folder, knowledge, solution, drawings%ellipses, error)
            if (.not. allocated(error)) &
                call draw_residuals(folder, knowledge, record, diagnostics, drawings%residuals, error)
            if (.not. allocated(error)) call draw_spectrum(folder, knowledge, diagnostics, drawings%spectrum, error)
        end associate
        if (allocated(error)) return
        told = .false.
        call tell(drawings%manoeuvre)
        call tell(drawings%ellipses)
        call tell(drawings%residuals)
        call tell(drawings%spectrum)

    contains

        !> A missing gnuplot is told of once.
        subroutine tell(drawing)
            type(drawing_t), intent(in) :: drawing

            if (drawing%reason == '' .or. (told .and. drawing%reason == NO_GNUPLOT)) return
            call console%message('warning: the page lacks a figure: '//drawing%reason)
            told = drawing%reason == NO_GNUPLOT
        end subroutine tell
    end subroutine draw_all

    subroutine write_result(solution, diagnostics, verdict, page)
        type(solution_t), intent(in) :: solution
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(verdict_t), intent(in) :: verdict
        type(html_page_t), intent(inout) :: page

        integer :: axis

        call page%chapter('result', 'Result')
        call page%verdict(kind_of(verdict%grade), verdict_words(verdict%grade), verdict%summary)
        call page%begin_table('Offset of the centre of gravity')
        call page%begin_row()
        call page%column_head('axis')
        call page%column_head('d, mm', numeric=.true.)
        call page%column_head('sigma, mm', numeric=.true.)
        call page%column_head('95 % interval, mm', numeric=.true.)
        call page%column_head('wanted: '//rounded_text(WANTED_ACCURACY/MILLIMETRE, 2)//' mm')
        call page%end_row()
        call page%head_end()
        do axis = 1, 3
            associate (d => solution%offset(axis)/MILLIMETRE, s => diagnostics%sigma(axis)/MILLIMETRE)
                call page%begin_row()
                call page%row_head(AXES(axis))
                call page%number_cell(fixed(d, 4))
                call page%number_cell(fixed(s, 4))
                call page%number_cell(fixed(d - TWO_SIDED_95*s, 3)//' to '//fixed(d + TWO_SIDED_95*s, 3))
                if (.not. diagnostics%sigma_known) then
                    call page%verdict_cell(VERDICT_PARTLY, 'not known')
                else if (diagnostics%sigma(axis) <= WANTED_ACCURACY) then
                    call page%verdict_cell(VERDICT_MET, 'determined')
                else
                    call page%verdict_cell(VERDICT_PARTLY, 'not determined')
                end if
                call page%end_row()
            end associate
        end do
        call page%end_table()
        call page%paragraph('Sigma is what the noise of accelerometer and star camera makes of the offset, by '// &
                            'the spectra that the setup gives (or, with `optimal`, the data where it gives none). It '// &
                            'holds neither scale factors nor the bias of the magnetometer nor forces that are not '// &
                            'a straight line in time, save what the fit estimates of them. The 95 % intervals '// &
                            'stand on it.')
        call page%heading('What to do next')
        if (size(verdict%next_steps) == 0) then
            call page%paragraph('Nothing: the offset is within its errors of zero.')
        else
            call page%bullet_list(padded(verdict%next_steps))
        end if
    end subroutine write_result

    !> What each instrument delivered, and what was bridged.
    subroutine write_observed(observations, solution, page)
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(in) :: solution
        type(html_page_t), intent(inout) :: page

        integer :: head, i

        call page%chapter('observed', 'What was observed')
        associate (o => observations, knowledge => observations%knowledge)
            call page%begin_table('Samples')
            call page%begin_row()
            call page%column_head('instrument')
            call page%column_head('interval, s', numeric=.true.)
            call page%column_head('samples', numeric=.true.)
            call page%column_head('full', numeric=.true.)
            call page%column_head('first, s', numeric=.true.)
            call page%column_head('last, s', numeric=.true.)
            call page%column_head('longest step, s', numeric=.true.)
            call page%end_row()
            call page%head_end()
            call row('accelerometer', knowledge%accelerometer_interval, o%accelerometer_time)
            do head = 1, HEADS
                call row('star camera '//integer_text(head)//trim(merge(' (used)', '       ', &
                    head == knowledge%camera)), &
                         knowledge%star_camera_interval, &
                         pack(o%star_camera_time, o%star_camera_head == head))
            end do
            call row('magnetometer', knowledge%magnetometer_interval, o%magnetometer_time)
            if (has_orbit(o)) call row('orbit', 0.0_dp, o%orbit_time)
            call page%end_table()
            call page%paragraph('Satellite: '//rounded_text(knowledge%mass, &
                6)//' kg, moments of inertia about the '// &
                                'proof-mass centre '//rounded_text(knowledge%inertia(1, 1), 6)//', '// &
                                rounded_text(knowledge%inertia(2, 2), &
                                    6)//', '//rounded_text(knowledge%inertia(3, 3), 6)// &
                                ' kg m^{2}.')
        end associate
        if (size(solution%warnings) == 0) then
            call page%paragraph('The observations gave no reason for a warning.')
        else
            call page%heading('Warnings')
            do i = 1, size(solution%warnings)
                call page%verdict(VERDICT_PARTLY, 'Warning:', solution%warnings(i)%text)
            end do
        end if

    contains

        subroutine row(name, interval, times)
            character(*), intent(in) :: name
            real(dp), intent(in) :: interval    !! s; 0: free
            real(dp), intent(in) :: times(:)    !! s

            integer :: n

            n = size(times)
            call page%begin_row()
            call page%row_head(name)
            call page%number_cell(merge_text(interval > 0, rounded_text(interval, 6), '-'))
            call page%number_cell(integer_text(n))
            if (interval > 0) then
                call page%number_cell(integer_text(nint(observations%knowledge%duration/interval)))
            else
                call page%number_cell('-')
            end if
            if (n == 0) then
                call page%number_cell('-')
                call page%number_cell('-')
            else
                call page%number_cell(rounded_text(times(1), 8))
                call page%number_cell(rounded_text(times(n), 8))
            end if
            if (n > 1) then
                call page%number_cell(rounded_text(maxval(times(2:) - times(:n - 1)), 4))
            else
                call page%number_cell('-')
            end if
            call page%end_row()
        end subroutine row
    end subroutine write_observed

    subroutine write_manoeuvre(observations, drawing, page)
        type(observation_set_t), intent(in) :: observations
        type(drawing_t), intent(in) :: drawing
        type(html_page_t), intent(inout) :: page

        integer :: i

        call page%chapter('manoeuvre', 'The manoeuvre')
        associate (rods => observations%knowledge%rods)
            call page%begin_table('Activations of the torque rods: amplitude sin(2 pi frequency (t - start) + phase)')
            call page%begin_row()
            call page%column_head('rod')
            call page%column_head('amplitude, A m^{2}', numeric=.true.)
            call page%column_head('frequency, Hz', numeric=.true.)
            call page%column_head('phase, deg', numeric=.true.)
            call page%column_head('start, s', numeric=.true.)
            call page%column_head('stop, s', numeric=.true.)
            call page%end_row()
            call page%head_end()
            do i = 1, rods%count
                associate (rod => rods%activations(i))
                    call page%begin_row()
                    call page%row_head(AXES(rod%axis))
                    call page%number_cell(rounded_text(rod%amplitude, 6))
                    call page%number_cell(rounded_text(rod%frequency, 6))
                    call page%number_cell(rounded_text(rod%phase/DEGREE, 6))
                    call page%number_cell(rounded_text(rod%start, 6))
                    call page%number_cell(rounded_text(rod%stop, 6))
                    call page%end_row()
                end associate
            end do
            call page%end_table()
        end associate
        call show(page, 'manoeuvre', drawing, &
                  'The rods'' dipole moment in body axes, and the angular acceleration that it makes in the '// &
                  'Earth''s field, as the fit has it. The component of the offset along the angular '// &
                  'acceleration cannot be seen: where all rods swing in phase, it keeps one direction.', &
                  'The manoeuvre', 'Two panels over time: dipole moment of the rods, and angular acceleration')
    end subroutine write_manoeuvre

    subroutine write_errors(solution, diagnostics, drawing, page)
        type(solution_t), intent(in) :: solution
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(drawing_t), intent(in) :: drawing
        type(html_page_t), intent(inout) :: page

        integer :: i, k

        call page%chapter('ellipsoid', 'The error ellipsoid')
        call page%begin_table('Axes of the ellipsoid of one sigma')
        call page%begin_row()
        call page%column_head('axis')
        call page%column_head('semi-axis, mm', numeric=.true.)
        call page%column_head('direction x', numeric=.true.)
        call page%column_head('y', numeric=.true.)
        call page%column_head('z', numeric=.true.)
        call page%end_row()
        call page%head_end()
        do k = 1, 3
            call page%begin_row()
            call page%row_head(trim(merge('longest ', merge('shortest', 'middle  ', k == 3), k == 1)))
            call page%number_cell(fixed(diagnostics%ellipsoid%semi_axis(k)/MILLIMETRE, 4))
            do i = 1, 3
                call page%number_cell(fixed(diagnostics%ellipsoid%direction(i, k), 3))
            end do
            call page%end_row()
        end do
        call page%end_table()
        call page%paragraph('The longest axis is the direction in which this calibration knows least. Correlations '// &
                            'of the components: xy '//fixed(diagnostics%correlation(1, 2), 3)//', xz '// &
                            fixed(diagnostics%correlation(1, 3), 3)//', yz '// &
                            fixed(diagnostics%correlation(2, 3), 3)//'.')
        call show(page, 'ellipses', drawing, &
                  'The ellipsoid cast on the planes of the body axes, about the estimate ('// &
                  fixed(solution%offset(1)/MILLIMETRE, 4)//', '//fixed(solution%offset(2)/MILLIMETRE, 4)//', '// &
                  fixed(solution%offset(3)/MILLIMETRE, 4)//') mm. Every axis has a scale of its own.', &
                  'Error ellipses', 'Ellipses of one sigma and of 95 % in the planes xy, xz and yz')
    end subroutine write_errors

    subroutine write_dependence(solution, record, diagnostics, page)
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(html_page_t), intent(inout) :: page

        integer :: i, k

        call page%chapter('dependence', 'What each component depends on')
        call page%begin_table('Where the information comes from: share of each accelerometer axis, %')
        call component_head('sigma at best, mm')
        do i = 1, 3
            call page%begin_row()
            call page%row_head('d_{'//AXES(i)//'}')
            do k = 1, 3
                call page%number_cell(fixed(100*diagnostics%information_share(i, k), 1))
            end do
            if (diagnostics%bound_known) then
                call page%number_cell(fixed(diagnostics%bound(i)/MILLIMETRE, 4))
            else
                call page%number_cell('-')
            end if
            call page%end_row()
        end do
        call page%end_table()
        call page%paragraph('An offset along one axis is felt by the two others, through the angular acceleration '// &
                            'about the third. Counted is what a component adds to an axis beyond a bias and a '// &
                            'drift of that axis, under its noise spectrum. Sigma at best is what all three axes '// &
                            'together allow if the rotation is known: no estimator gets below it, save by knowing '// &
                            'the forces better. A sigma far above it comes from weights, from the star camera or '// &
                            'from other parameters that are estimated.')

        call page%begin_table('Which noise the error comes from: share of the variance, %')
        call component_head('star camera', 'a-priori knowledge', 'sigma, mm')
        do i = 1, 3
            call page%begin_row()
            call page%row_head('d_{'//AXES(i)//'}')
            do k = 1, size(diagnostics%source_share, 2)
                call page%number_cell(fixed(100*diagnostics%source_share(i, k), 1))
            end do
            call page%number_cell(fixed(diagnostics%sigma(i)/MILLIMETRE, 4))
            call page%end_row()
        end do
        call page%end_table()

        call page%begin_table('What it is hard to tell apart from: correlation with the other parameters of the fit')
        call page%begin_row()
        call page%column_head('parameter')
        do i = 1, 3
            call page%column_head('d_{'//AXES(i)//'}', numeric=.true.)
        end do
        call page%end_row()
        call page%head_end()
        do k = 1, size(diagnostics%parameter_correlation, 2)
            call page%begin_row()
            call page%row_head(parameter_name(record%names(k + 3)))
            do i = 1, 3
                call page%number_cell(fixed(diagnostics%parameter_correlation(i, k), 2))
            end do
            call page%end_row()
        end do
        call page%end_table()
        call page%paragraph('Near 1 or -1 both are known only together: an error of the one is an error of the other. '// &
                            'The bias carries the constant part of the centrifugal term, so it follows a weak '// &
                            'component. Estimated were: bias '//vector(solution%bias)//' m/s^{2}, drift '// &
                            vector(solution%drift)//' m/s^{3}, angular velocity at the epoch '// &
                            vector(solution%angular_velocity)//' rad/s.')

    contains

        subroutine component_head(first, second, third)
            character(*), intent(in) :: first
            character(*), intent(in), optional :: second, third

            integer :: axis

            call page%begin_row()
            call page%column_head('component')
            do axis = 1, 3
                call page%column_head('accelerometer '//AXES(axis), numeric=.true.)
            end do
            call page%column_head(first, numeric=.true.)
            if (present(second)) call page%column_head(second, numeric=.true.)
            if (present(third)) call page%column_head(third, numeric=.true.)
            call page%end_row()
            call page%head_end()
        end subroutine component_head
    end subroutine write_dependence

    subroutine write_residuals(diagnostics, drawings, page)
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(drawings_t), intent(in) :: drawings
        type(html_page_t), intent(inout) :: page

        integer :: axis

        call page%chapter('residuals-chapter', 'Residuals of the accelerometer')
        call page%begin_table('Residuals against the noise of the setup')
        call page%begin_row()
        call page%column_head('axis')
        call page%column_head('RMS, m/s^{2}', numeric=.true.)
        call page%column_head('expected', numeric=.true.)
        call page%column_head('whitened RMS', numeric=.true.)
        call page%column_head('lag-1 correlation', numeric=.true.)
        call page%column_head('P(white)', numeric=.true.)
        call page%column_head('largest', numeric=.true.)
        call page%column_head('at, s', numeric=.true.)
        call page%end_row()
        call page%head_end()
        do axis = 1, 3
            associate (r => diagnostics%residuals(axis))
                call page%begin_row()
                call page%row_head(AXES(axis))
                call page%number_cell(scientific(r%rms))
                if (r%noise_known) then
                    call page%number_cell(scientific(r%expected_rms))
                    call page%number_cell(fixed(r%ratio, 3))
                    call page%number_cell(fixed(r%autocorrelation(1), 3))
                    call page%number_cell(merge_text(r%probability < 5e-5_dp, '0.0000', fixed(r%probability, 4)))
                else
                    call page%number_cell('-')
                    call page%number_cell('-')
                    call page%number_cell('-')
                    call page%number_cell('-')
                end if
                call page%number_cell(scientific(r%worst))
                call page%number_cell(rounded_text(r%worst_time, 6))
                call page%end_row()
            end associate
        end do
        call page%end_table()
        call page%paragraph('Expected is the RMS of the setup''s noise at the frequencies of the record. For the '// &
                            'next columns the residuals were whitened with that noise: noise as the setup has it '// &
                            'gives an RMS of 1 and no correlation; P(white) is the '// &
                            'probability that white noise looks as correlated as this (Ljung and Box, 20 lags).')
        call show(page, 'residuals', drawings%residuals, &
                  'Observed minus fitted. Dashed: two standard deviations of the noise of the setup.', &
                  'Residuals over time', 'Three panels over time: residuals of accelerometer axes x, y, z')
        call show(page, 'spectrum', drawings%spectrum, &
                  'Amplitude spectrum of the residuals, one-sided: periodogram with Hann''s taper, and its means '// &
                  'over thirds of octaves; beside it that of the noise of the setup. Vertical, dashed: the '// &
                  'frequencies of the rods, where the fit has taken the signal out. Lines above the noise '// &
                  'elsewhere are forces that the fit does not know.', &
                  'Spectrum of the residuals', &
                  'Three panels over frequency: spectrum of the residuals and of the expected noise, x, y, z')
    end subroutine write_residuals

    subroutine write_findings(verdict, page)
        type(verdict_t), intent(in) :: verdict
        type(html_page_t), intent(inout) :: page

        integer :: i

        call page%chapter('verdict', 'Verdict')
        call page%verdict(kind_of(verdict%grade), verdict_words(verdict%grade), verdict%summary)
        call page%heading('What it rests on')
        do i = 1, size(verdict%findings)
            associate (finding => verdict%findings(i))
                call page%verdict(kind_of(finding%grade), finding%subject//', '//grade_words(finding%grade)//':', &
                                  finding%text)
            end associate
        end do
    end subroutine write_findings

    !> What the page was made of and how to make it again.
    subroutine write_provenance(path, source, options_file, solution, page, error)
        character(*), intent(in) :: path, source, options_file
        type(solution_t), intent(in) :: solution
        type(html_page_t), intent(inout) :: page
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: setup, options
        character(:), allocatable :: command

        call read_text_file(source//'/setup.nml', setup, error)
        if (.not. allocated(error) .and. options_file /= '') call read_text_file(options_file, options, error)
        if (allocated(error)) return
        command = 'gracecg estimate '//source//' --algorithm '//solution%algorithm//' --report '//path
        if (options_file /= '') command = command//' --options '//options_file
        call page%chapter('provenance', 'How this page was made')
        call page%paragraph('By gracecg '//VERSION//':')
        call page%preformatted(command)
        call page%paragraph('The numbers of the figures (CSV) and their gnuplot scripts are in `'// &
                            page_folder(path)//'`; `gnuplot NAME.gp` there draws a figure again. The setup of the '// &
                            'observation set:')
        call page%preformatted(setup%text)
        if (options_file == '') return
        call page%paragraph('How it was estimated:')
        call page%preformatted(options%text)
    end subroutine write_provenance

    !> A figure, or its place.
    subroutine show(page, id, drawing, caption, title, description)
        type(html_page_t), intent(inout) :: page
        character(*), intent(in) :: id, caption, title, description
        type(drawing_t), intent(in) :: drawing

        if (drawing%svg == '') then
            call page%missing_figure(id, drawing%reason, caption)
        else
            call page%figure(id, drawing%svg, caption, title, description)
        end if
    end subroutine show

    pure integer function kind_of(grade) result(kind)
        integer, intent(in) :: grade

        kind = VERDICT_MISSED
        if (grade == GRADE_GOOD) kind = VERDICT_MET
        if (grade == GRADE_DOUBTFUL) kind = VERDICT_PARTLY
    end function kind_of

    !> Of one finding.
    pure function grade_words(grade) result(words)
        integer, intent(in) :: grade
        character(:), allocatable :: words

        words = 'bad'
        if (grade == GRADE_GOOD) words = 'good'
        if (grade == GRADE_DOUBTFUL) words = 'mind this'
    end function grade_words

    !> Of the whole.
    pure function verdict_words(grade) result(words)
        integer, intent(in) :: grade
        character(:), allocatable :: words

        words = 'Not usable.'
        if (grade == GRADE_GOOD) words = 'Good.'
        if (grade == GRADE_DOUBTFUL) words = 'Usable with care.'
    end function verdict_words

    !> 'd_x' as it is set: d with a lowered x.
    function parameter_name(name) result(text)
        character(*), intent(in) :: name
        character(:), allocatable :: text

        integer :: place

        place = index(name, '_')
        select case (name(:max(0, place - 1)))
        case ('alpha')
            text = 'drift '//trim(name(place + 1:))
        case ('beta')
            text = 'bias '//trim(name(place + 1:))
        case ('omega')
            text = 'angular velocity '//trim(name(place + 1:))
        case ('zeta')
            text = 'attitude '//trim(name(place + 1:))
        case ('torque')
            text = 'unknown torque '//trim(name(place + 1:))
        case ('wave')
            text = 'density wave, '//trim(name(place + 1:))
        case ('shared')
            text = 'part of the disturbance in another axis, '//trim(name(place + 1:))
        case default
            text = trim(name)
        end select
    end function parameter_name

    function vector(values) result(text)
        real(dp), intent(in) :: values(3)
        character(:), allocatable :: text

        text = '('//scientific(values(1))//', '//scientific(values(2))//', '//scientific(values(3))//')'
    end function vector

    !> A number with so many decimals, or with an exponent where it is too large for that.
    function fixed(value, decimals) result(text)
        real(dp), intent(in) :: value
        integer, intent(in) :: decimals
        character(:), allocatable :: text

        character(24) :: buffer

        write (buffer, '(f24.'//integer_text(decimals)//')') value
        if (abs(value) >= 1e6_dp) write (buffer, '(es24.3)') value
        text = trim(adjustl(buffer))
        if (verify(text, '-0.') == 0 .and. text(1:1) == '-') text = text(2:)    ! no minus zero
    end function fixed

    !> A number with three digits and an exponent.
    function scientific(value) result(text)
        real(dp), intent(in) :: value
        character(:), allocatable :: text

        character(16) :: buffer

        write (buffer, '(es16.2)') value
        text = trim(adjustl(buffer))
    end function scientific

    pure function merge_text(first, text, other) result(chosen)
        logical, intent(in) :: first
        character(*), intent(in) :: text, other
        character(:), allocatable :: chosen

        chosen = other
        if (first) chosen = text
    end function merge_text
end module gracecg_cli_calibration_page
