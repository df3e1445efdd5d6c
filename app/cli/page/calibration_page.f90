!> The page of one calibration: what was observed, the result with its errors, where they come from, the
!> residuals, and a verdict. Made from the observation set and the fit, never from the truth. A refused estimate
!> has a page, too: it begins with the reason and shows what there is, the residuals before all.
module gracecg_cli_calibration_page
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: integer_text, rounded_text, padded
    use gracecg_files_file, only: make_directory, remove_file, file_exists, text_file_t, read_text_file
    use gracecg_environment_time, only: utc_t, utc_text, utc_plus
    use gracecg_spacecraft_moment_series, only: has_moments
    use gracecg_spacecraft_torque_rods, only: WAVEFORM_NAMES
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_observations_observation_set, only: observation_set_t, has_orbit
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_diagnostics, only: fit_diagnostics_t, diagnose
    use gracecg_estimation_verdict, only: verdict_t, judge, GRADE_GOOD, GRADE_DOUBTFUL, WANTED_ACCURACY
    use gracecg_cli_console, only: console_t
    use gracecg_cli_number_text, only: fixed_text, scientific_text, pick_text
    use gracecg_cli_html, only: html_page_t, table_rows_t, head_cell, number_cell, number_cells, text_cell, verdict_cell, &
        VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_cli_book, only: book_t, open_book
    use gracecg_cli_calibration_advice, only: advice_of
    use gracecg_cli_calibration_figures, only: add_manoeuvre_figure, add_ellipses_figure, add_residuals_figure, &
        add_spectrum_figure
    implicit none
    private
    public :: write_calibration_page, page_folder

    real(dp), parameter :: TWO_SIDED_95 = 1.959964_dp   !! 95 % of a normal distribution lie within +-
    character(*), parameter :: PAGE_END = '.html'

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
    !> With a refusal the page begins with the reason, shows no offset, and has what could be read and fitted;
    !> an older page of that name is gone in any case.
    !>
    !> Fails when a file cannot be written.
    subroutine write_calibration_page(path, source, options_file, algorithm, observations, solution, record, console, &
                                      error, refusal)
        character(*), intent(in) :: path                !! Of the page
        character(*), intent(in) :: source              !! Folder of the observation set
        character(*), intent(in) :: options_file        !! Of --options; empty: none
        character(*), intent(in) :: algorithm           !! That was asked for
        type(observation_set_t), intent(in) :: observations     !! Without samples where they could not be read
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record        !! Of the same estimate, as far as it came
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: refusal   !! Why there is no offset to be used

        type(fit_diagnostics_t) :: diagnostics
        type(verdict_t) :: verdict
        type(book_t) :: book
        logical :: fitted
        integer :: i

        fitted = .not. present(refusal) .or. has_fit(record)
        if (fitted) call diagnose(observations%knowledge, solution, record, diagnostics, error)
        if (present(refusal) .and. allocated(error)) then
            fitted = .false.
            deallocate (error)
        end if
        if (fitted .and. .not. allocated(error)) call make_directory(page_folder(path), error)
        if (allocated(error)) return
        if (.not. fitted) call remove_files(page_folder(path))
        call open_book(book, page_folder(path))
        if (fitted) verdict = judge(observations%knowledge, solution, record, diagnostics, refusal)
        associate (knowledge => observations%knowledge, page => book%page)
            call begin(source, algorithm, observations, present(refusal), page)
            if (present(refusal)) then
                call write_refusal(refusal, fitted, page)
            else
                call write_result(knowledge%mass, solution, diagnostics, verdict, page)
            end if
            if (fitted .and. present(refusal)) call write_residuals(observations, record, diagnostics, book, error)
            if (.not. allocated(error) .and. allocated(observations%accelerometer_time)) then
                call write_observed(observations, solution, page)
                call write_manoeuvre(observations, fitted, record, book, error)
            end if
            if (.not. present(refusal)) then
                if (.not. allocated(error)) call write_errors(observations, solution, diagnostics, book, error)
                if (.not. allocated(error)) call write_dependence(solution, record, diagnostics, page)
                if (.not. allocated(error)) call write_residuals(observations, record, diagnostics, book, error)
            end if
            if (.not. allocated(error) .and. fitted) call write_findings(verdict, page)
            if (.not. allocated(error)) &
                call write_provenance(path, source, options_file, algorithm, fitted, present(refusal), page, error)
            if (.not. allocated(error)) call page%write(path, error)
        end associate
        if (allocated(error)) return
        do i = 1, size(book%reasons)
            call console%warn('the page lacks a figure: '//book%reasons(i)%text)
        end do
    end subroutine write_calibration_page

    !> Whether the fit came so far that its residuals can be judged.
    pure logical function has_fit(record)
        type(fit_record_t), intent(in) :: record

        integer, parameter :: LEAST_SAMPLES = 40

        has_fit = allocated(record%residual) .and. allocated(record%covariance)
        if (has_fit) has_fit = size(record%epoch) >= LEAST_SAMPLES
    end function has_fit

    !> Files of an older page, which would be taken for those of this one.
    subroutine remove_files(folder)
        character(*), intent(in) :: folder

        character(14), parameter :: NAMES(5) = [character(14) :: 'manoeuvre', 'ellipses', 'residuals', 'spectrum', &
                                                'spectrum_bands']
        character(4), parameter :: ENDS(3) = [character(4) :: '.csv', '.gp', '.svg']
        character(:), allocatable :: path
        integer :: i, k

        do i = 1, size(NAMES)
            do k = 1, size(ENDS)
                path = folder//'/'//trim(NAMES(i))//trim(ENDS(k))
                if (file_exists(path)) call remove_file(path)
            end do
        end do
    end subroutine remove_files

    !> Title and first paragraph.
    subroutine begin(source, algorithm, observations, refused, page)
        character(*), intent(in) :: source, algorithm
        type(observation_set_t), intent(in) :: observations
        logical, intent(in) :: refused
        type(html_page_t), intent(inout) :: page

        character(:), allocatable :: name, lead

        name = source
        lead = 'Observations of `'//source//'`, to be estimated with `'//algorithm//'`.'
        if (allocated(observations%accelerometer_time)) then
            associate (knowledge => observations%knowledge)
                name = trim(knowledge%name)
                lead = 'Calibration of '//utc_text(knowledge%epoch)//' UTC, '//rounded_text(knowledge%duration, 6)// &
                       ' s long, estimated with `'//algorithm//'` from the observations alone.'
            end associate
        end if
        call page%begin('CG offset of '//name//pick_text(refused, ': refused', ''), lead)
    end subroutine begin

    !> Why there is no offset.
    subroutine write_refusal(refusal, fitted, page)
        character(*), intent(in) :: refusal
        logical, intent(in) :: fitted
        type(html_page_t), intent(inout) :: page

        call page%chapter('result', 'Result')
        call page%verdict(VERDICT_MISSED, 'Refused: there is no offset that may be used.', refusal)
        call page%heading('What to do next')
        if (fitted) then
            call page%bullet_list([character(200) :: &
                'Look at the residuals below: where they leave the noise tells which samples, which axis or which '// &
                'force is at fault.', &
                'Mend what is marked with a cross in the verdict, or leave the faulty samples out, and estimate again; '// &
                'if that is not possible, repeat the calibration.'])
        else
            call page%bullet_list([character(120) :: 'Mend what the message names, and estimate again.'])
            call page%paragraph('The estimate ended before there was a fit, so there are no residuals to show. An older '// &
                                'page of this name is gone, and so are its figures and numbers.')
        end if
    end subroutine write_refusal

    subroutine write_result(mass, solution, diagnostics, verdict, page)
        real(dp), intent(in) :: mass        !! Of the satellite, kg
        type(solution_t), intent(in) :: solution
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(verdict_t), intent(in) :: verdict
        type(html_page_t), intent(inout) :: page

        type(table_rows_t) :: rows
        character(:), allocatable :: determined
        integer :: axis

        call page%chapter('result', 'Result')
        call page%verdict(kind_of(verdict%grade), verdict_words(verdict%grade), verdict%summary)
        do axis = 1, 3
            associate (d => solution%offset(axis)/MILLIMETRE, s => diagnostics%sigma(axis)/MILLIMETRE)
                if (.not. diagnostics%sigma_known) then
                    determined = verdict_cell(VERDICT_PARTLY, 'not known')
                else if (diagnostics%sigma(axis) <= WANTED_ACCURACY) then
                    determined = verdict_cell(VERDICT_MET, 'determined')
                else
                    determined = verdict_cell(VERDICT_PARTLY, 'not determined')
                end if
                call rows%add(head_cell(AXES(axis))//number_cells([d, s], 4)// &
                              number_cell(fixed_text(d - TWO_SIDED_95*s, 3)//' to '// &
                                          fixed_text(d + TWO_SIDED_95*s, 3))//determined)
            end associate
        end do
        call page%table('Offset of the centre of gravity', [character(24) :: 'axis', 'd, mm', 'sigma, mm', &
                        '95 % interval, mm', 'wanted: '//rounded_text(WANTED_ACCURACY/MILLIMETRE, 2)//' mm'], rows, &
                        fits=.true.)
        call page%heading('What to do next')
        if (size(verdict%next_steps) == 0) then
            call page%paragraph('Nothing: the offset is within its errors of zero.')
        else
            call page%bullet_list(padded(advice_of(verdict, mass, solution)))
        end if
        call page%heading('What the numbers are')
        call page%paragraph('The offset d points from the centre of mass to the proof-mass centre of the '// &
                            'accelerometer, in body axes: x along the satellite, y across, z to the Earth.')
        call page%paragraph('Sigma is what the noise of accelerometer and star camera makes of the offset, by '// &
                            'the spectra that the setup gives (or, with `optimal`, the data where it gives none). It '// &
                            'holds neither scale factors nor the bias of the magnetometer nor forces that are not '// &
                            'a straight line in time, save what the fit estimates of them. The 95 % intervals '// &
                            'stand on it.')
    end subroutine write_result

    !> What each instrument delivered, and what was bridged.
    subroutine write_observed(observations, solution, page)
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(in) :: solution
        type(html_page_t), intent(inout) :: page

        type(table_rows_t) :: rows
        integer :: head, i

        call page%chapter('observed', 'What was observed')
        associate (o => observations, knowledge => observations%knowledge)
            call row('accelerometer', knowledge%accelerometer_interval, o%accelerometer_time)
            do head = 1, HEADS
                call row('star camera '//integer_text(head)//pick_text(head == knowledge%camera, ' (used)', ''), &
                         knowledge%star_camera_interval, pack(o%star_camera_time, o%star_camera_head == head))
            end do
            call row('magnetometer', knowledge%magnetometer_interval, o%magnetometer_time)
            if (has_orbit(o)) call row('orbit', 0.0_dp, o%orbit_time)
            call page%table('Samples', [character(15) :: 'instrument', 'interval, s', 'samples', 'full', &
                            'longest step, s', 'first, s', 'last, s', 'first, UTC', 'last, UTC'], rows)
            call page%paragraph('Satellite: '//rounded_text(knowledge%mass, 6)//' kg, moments of inertia about the '// &
                                'proof-mass centre '//rounded_text(knowledge%inertia(1, 1), 6)//', '// &
                                rounded_text(knowledge%inertia(2, 2), 6)//', '// &
                                rounded_text(knowledge%inertia(3, 3), 6)//' kg m^{2}. Seconds count from the epoch, '// &
                                utc_text(knowledge%epoch)//' UTC.')
        end associate
        if (.not. allocated(solution%warnings)) return
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

            character(:), allocatable :: ends
            integer :: n

            n = size(times)
            ends = repeat(number_cell('-'), 4)
            if (n > 0) ends = number_cell(rounded_text(times(1), 8))//number_cell(rounded_text(times(n), 8))// &
                              number_cell(clock_text(observations%knowledge%epoch, times(1)))// &
                              number_cell(clock_text(observations%knowledge%epoch, times(n)))
            call rows%add(head_cell(name)//number_or_dash(interval > 0, interval)//number_cell(integer_text(n))// &
                          number_or_dash(interval > 0, anint(observations%knowledge%duration/max(interval, 1e-9_dp)))// &
                          number_or_dash(n > 1, longest_step(times))//ends)
        end subroutine row
    end subroutine write_observed

    !> s; 0 for less than two samples.
    pure real(dp) function longest_step(times) result(step)
        real(dp), intent(in) :: times(:)

        step = 0
        if (size(times) > 1) step = maxval(times(2:) - times(:size(times) - 1))
    end function longest_step

    function number_or_dash(known, value) result(cell)
        logical, intent(in) :: known
        real(dp), intent(in) :: value
        character(:), allocatable :: cell

        cell = number_cell(pick_text(known, rounded_text(value, 6), '-'))
    end function number_or_dash

    !> The time of the day, hh:mm:ss with decimals as needed.
    function clock_text(epoch, seconds) result(text)
        type(utc_t), intent(in) :: epoch
        real(dp), intent(in) :: seconds         !! Since then
        character(:), allocatable :: text

        text = utc_text(utc_plus(epoch, seconds))
        text = text(index(text, 'T') + 1:)
    end function clock_text

    subroutine write_manoeuvre(observations, fitted, record, book, error)
        type(observation_set_t), intent(in) :: observations
        logical, intent(in) :: fitted           !! There is a fit, whose angular acceleration can be drawn
        type(fit_record_t), intent(in) :: record
        type(book_t), intent(inout) :: book
        type(error_t), allocatable, intent(out) :: error

        type(table_rows_t) :: rows
        integer :: i

        call book%page%chapter('manoeuvre', 'The manoeuvre')
        associate (rods => observations%knowledge%rods, epoch => observations%knowledge%epoch)
            do i = 1, rods%count
                associate (rod => rods%activations(i))
                    call rows%add(head_cell(AXES(rod%axis))//text_cell(trim(WAVEFORM_NAMES(rod%waveform)))// &
                                  number_cell(rounded_text(rod%amplitude, 6))// &
                                  number_cell(rounded_text(rod%frequency, 6))// &
                                  number_cell(rounded_text(rod%phase/DEGREE, 6))// &
                                  number_cell(rounded_text(rod%start, 6))//number_cell(rounded_text(rod%stop, 6))// &
                                  number_cell(clock_text(epoch, rod%start))//number_cell(clock_text(epoch, rod%stop)))
                end associate
            end do
        end associate
        call book%page%table('Activations of the torque rods: amplitude times the waveform at the angle '// &
                             '2 pi frequency (t - start) + phase', &
                             [character(19) :: 'rod', 'waveform', 'amplitude, A m^{2}', 'frequency, Hz', 'phase, deg', &
                              'start, s', 'stop, s', 'start, UTC', 'stop, UTC'], rows)
        if (has_moments(observations%knowledge%rods%measured)) &
            call book%page%paragraph('The moments were measured: '// &
                                     integer_text(size(observations%knowledge%rods%measured%time))//' samples stand in '// &
                                     'for the activations, which are what was commanded.')
        if (fitted) call add_manoeuvre_figure(book, observations%knowledge, record, error)
    end subroutine write_manoeuvre

    subroutine write_errors(observations, solution, diagnostics, book, error)
        type(observation_set_t), intent(in) :: observations
        type(solution_t), intent(in) :: solution
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(book_t), intent(inout) :: book
        type(error_t), allocatable, intent(out) :: error

        character(8), parameter :: LENGTHS(3) = [character(8) :: 'longest', 'middle', 'shortest']
        type(table_rows_t) :: rows
        integer :: k

        call book%page%chapter('ellipsoid', 'The error ellipsoid')
        do k = 1, 3
            call rows%add(head_cell(trim(LENGTHS(k)))// &
                          number_cells([diagnostics%ellipsoid%semi_axis(k)/MILLIMETRE], 4)// &
                          number_cells(diagnostics%ellipsoid%direction(:, k), 3))
        end do
        call book%page%table('Axes of the ellipsoid of one sigma', [character(13) :: 'axis', 'semi-axis, mm', &
                             'direction x', 'y', 'z'], rows)
        associate (correlation => diagnostics%correlation)
            call book%page%paragraph('The longest axis is the direction in which this calibration knows least. '// &
                                     'Correlations of the components: xy '//fixed_text(correlation(1, 2), 3)//', xz '// &
                                     fixed_text(correlation(1, 3), 3)//', yz '//fixed_text(correlation(2, 3), 3)//'.')
        end associate
        call add_ellipses_figure(book, 'estimate --report, '//trim(observations%knowledge%name), solution%offset, &
                                 solution%covariance, error)
    end subroutine write_errors

    subroutine write_dependence(solution, record, diagnostics, page)
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(html_page_t), intent(inout) :: page

        character(18), parameter :: COMPONENT_HEADS(4) = [character(18) :: 'component', 'accelerometer x', &
                                                          'accelerometer y', 'accelerometer z']
        type(table_rows_t) :: information, sources, parameters
        integer :: i, k

        call page%chapter('dependence', 'What each component depends on')
        do i = 1, 3
            call information%add(head_cell('d_{'//AXES(i)//'}')//number_cells(100*diagnostics%information_share(i, :), 1)// &
                                 number_cell(pick_text(diagnostics%bound_known, &
                                                       fixed_text(diagnostics%bound(i)/MILLIMETRE, 4), '-')))
            call sources%add(head_cell('d_{'//AXES(i)//'}')//number_cells(100*diagnostics%source_share(i, :), 1)// &
                             number_cells([diagnostics%sigma(i)/MILLIMETRE], 4))
        end do
        do k = 1, size(diagnostics%parameter_correlation, 2)
            call parameters%add(head_cell(parameter_name(record%names(k + 3)))// &
                                number_cells(diagnostics%parameter_correlation(:, k), 2))
        end do
        call page%table('Where the information comes from: share of each accelerometer axis, %', &
                        [character(18) :: COMPONENT_HEADS, 'sigma at best, mm'], information)
        call page%paragraph('An offset along one axis is felt by the two others, through the angular acceleration '// &
                            'about the third. Counted is what a component adds to an axis beyond a bias and a '// &
                            'drift of that axis, under its noise spectrum. Sigma at best is what all three axes '// &
                            'together allow if the rotation is known: no estimator gets below it, save by knowing '// &
                            'the forces better. A sigma far above it comes from weights, from the star camera or '// &
                            'from other parameters that are estimated.')

        call page%table('Which noise the error comes from: share of the variance, %', &
                        [character(18) :: COMPONENT_HEADS, 'star camera', 'a-priori knowledge', 'sigma, mm'], sources)
        call page%table('What it is hard to tell apart from: correlation with the other parameters of the fit', &
                        [character(9) :: 'parameter', 'd_{x}', 'd_{y}', 'd_{z}'], parameters)
        call page%paragraph('Near 1 or -1 both are known only together: an error of the one is an error of the other. '// &
                            'The bias carries the constant part of the centrifugal term, so it follows a weak '// &
                            'component. Estimated were: bias '//vector(solution%bias)//' m/s^{2}, drift '// &
                            vector(solution%drift)//' m/s^{3}, angular velocity at the epoch '// &
                            vector(solution%angular_velocity)//' rad/s.')
    end subroutine write_dependence

    subroutine write_residuals(observations, record, diagnostics, book, error)
        type(observation_set_t), intent(in) :: observations
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(in) :: diagnostics
        type(book_t), intent(inout) :: book
        type(error_t), allocatable, intent(out) :: error

        type(table_rows_t) :: rows
        character(:), allocatable :: against_noise
        integer :: axis

        call book%page%chapter('residuals-chapter', 'Residuals of the accelerometer')
        do axis = 1, 3
            associate (r => diagnostics%residuals(axis))
                against_noise = repeat(number_cell('-'), 4)
                if (r%noise_known) &
                    against_noise = number_cell(scientific_text(r%expected_rms))// &
                                    number_cells([r%ratio, r%autocorrelation(1)], 3)//number_cells([r%probability], 4)
                call rows%add(head_cell(AXES(axis))//number_cell(scientific_text(r%rms))//against_noise// &
                              number_cell(scientific_text(r%worst))//number_cell(rounded_text(r%worst_time, 6))// &
                              number_cell(clock_text(observations%knowledge%epoch, r%worst_time)))
            end associate
        end do
        call book%page%table('Residuals against the noise of the setup', [character(17) :: 'axis', 'RMS, m/s^{2}', &
                             'expected', 'whitened RMS', 'lag-1 correlation', 'P(white)', 'largest', 'at, s', 'at, UTC'], rows)
        call book%page%paragraph('Expected is the RMS of the setup''s noise at the frequencies of the record. For the '// &
                            'next columns the residuals were whitened with that noise: noise as the setup has it '// &
                            'gives an RMS of 1 and no correlation; P(white) is the '// &
                            'probability that white noise looks as correlated as this (Ljung and Box, 20 lags).')
        call add_residuals_figure(book, observations%knowledge, record, diagnostics, error)
        if (.not. allocated(error)) call add_spectrum_figure(book, observations%knowledge, diagnostics, error)
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

    !> What the page was made of and how to make it again. What cannot be read is left out of a refused one.
    subroutine write_provenance(path, source, options_file, algorithm, fitted, refused, page, error)
        character(*), intent(in) :: path, source, options_file, algorithm
        logical, intent(in) :: fitted, refused
        type(html_page_t), intent(inout) :: page
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: command

        command = 'gracecg estimate '//source//' --algorithm '//algorithm//' --report '//path
        if (options_file /= '') command = command//' --options '//options_file
        call page%chapter('provenance', 'How this page was made')
        call page%paragraph('By gracecg '//VERSION//':')
        call page%preformatted(command, 'Command')
        if (fitted) call page%paragraph('The numbers of the figures (CSV) and their gnuplot scripts are in `'// &
                                        page_folder(path)//'`; `gnuplot NAME.gp` there draws a figure again.')
        call fold('The setup of the observation set, setup.nml', source//'/setup.nml')
        if (.not. allocated(error) .and. options_file /= '') call fold('How it was estimated: the options', options_file)

    contains

        subroutine fold(summary, name)
            character(*), intent(in) :: summary, name

            type(text_file_t) :: file

            if (refused .and. .not. file_exists(name)) return
            call read_text_file(name, file, error)
            if (.not. allocated(error)) then
                call page%details(summary, file%text)
            else if (refused) then
                deallocate (error)
            end if
        end subroutine fold
    end subroutine write_provenance

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

        text = '('//scientific_text(values(1))//', '//scientific_text(values(2))//', '//scientific_text(values(3))//')'
    end function vector
end module gracecg_cli_calibration_page
