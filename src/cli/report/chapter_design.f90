!> The report page, beyond the report: the report's manoeuvre and a designed one over a revolution, and
!> what the designed one reaches in the six cases.
module gracecg_cli_chapter_design
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_base_version, only: VERSION
    use gracecg_files_file, only: output_file_t
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_cli_html, only: VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_spacecraft_torque_rods, only: take_manoeuvre, WAVEFORM_NAMES, SQUARE
    use gracecg_planning_calibration, only: calibration_t, find_calibration, calibration_text
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES, TIME_OF_CASE
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit, last_time
    use gracecg_planning_site, only: accelerometer_view_t, new_accelerometer_view, manoeuvre_site_t
    use gracecg_planning_map, only: map_point_t, map_manoeuvre, new_manoeuvre_sites
    use gracecg_planning_design, only: design_settings_t, manoeuvre_design_t, design_manoeuvre
    use gracecg_planning_planner, only: take_design
    use gracecg_simulation_simulator, only: simulator_t, new_simulator
    use gracecg_planning_bound, only: case_bound_t, bound_of_case
    use gracecg_studies_monte_carlo, only: monte_carlo_t, run_monte_carlo, error_statistics_t, statistics_of
    use gracecg_studies_trim, only: trim_settings_t, trim_statistics_t, repeat_trim
    use gracecg_cli_campaign_tables, only: REPORT_RUNS
    use gracecg_cli_console, only: console_t
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid
    use gracecg_cli_chapter_limit, only: MOST_LIMIT_RUNS
    use gracecg_cli_book, only: report_book_t, add_figure, add_finding, book_file, COMMAND
    use gracecg_cli_number_text, only: pick_text, fixed_text, share_text
    implicit none
    private
    public :: add_design_chapter

    character(5), parameter :: SATELLITES(2) = [character(5) :: 'front', 'back']
    character(8), parameter :: MANOEUVRES(2) = [character(8) :: 'report', 'designed']
    character(*), parameter :: ALGORITHM = 'optimal'
    integer, parameter :: CASES = size(REPORT_CASE_NAMES), TRIM_ROUNDS = 2
    real(dp), parameter :: GOAL = 10e-6_dp          !! RMS error of every component, m
    real(dp), parameter :: ORBIT_STEP = 10          !! Of the orbit's samples, s
    real(dp), parameter :: DESIGN_STEP = 240        !! Between the places that the manoeuvre is designed for, s
    real(dp), parameter :: MAP_STEP = 60            !! Between the places of the map, s
    real(dp), parameter :: LOWEST_FREQUENCY = 0.1_dp        !! Of the search, Hz
    character(*), parameter :: RESULT_FILE = 'design.csv'
    character(1), parameter :: LF = achar(10)

    !> The manoeuvres of one satellite over a revolution.
    type :: design_study_t
        type(calibration_t) :: calibration                    !! Case 1, the manoeuvre the designed one
        type(manoeuvre_design_t) :: design
        type(map_point_t), allocatable :: report(:)         !! The map of the report's manoeuvre
        type(map_point_t), allocatable :: designed(:)       !! Of the designed one
        integer :: places = 0                               !! That it is designed for
    end type design_study_t

    !> What the designed manoeuvre reaches in a case; m.
    type :: designed_case_t
        real(dp) :: bound(3) = 0        !! Cramer-Rao
        real(dp) :: rms(3) = 0          !! Of the errors of `optimal`, all errors on
        real(dp) :: trimmed(3) = 0      !! Likewise, when one trim has made the offset small
        integer :: not_converged = 0
    end type designed_case_t

contains

    !> Designs a manoeuvre for each satellite, maps it, and calibrates the six cases with it.
    subroutine add_design_chapter(book, console, error)
        type(report_book_t), intent(inout) :: book
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(design_study_t) :: studies(2)
        type(designed_case_t) :: reached(CASES)
        integer :: i, runs

        runs = min(book%runs, MOST_LIMIT_RUNS)
        do i = 1, size(SATELLITES)
            call console%progress(COMMAND//': designed manoeuvre, '//trim(SATELLITES(i)))
            call study_design(trim(SATELLITES(i)), book%threads, studies(i), error)
            if (.not. allocated(error)) call write_map(book, studies(i), error)
            if (.not. allocated(error)) call write_case(book, studies(i), error)
            if (allocated(error)) return
        end do
        do i = 1, CASES
            call console%progress(COMMAND//': designed manoeuvre, '//trim(REPORT_CASE_NAMES(i))//', '// &
                                  integer_text(runs)//' runs')
            call calibrate_case(book, i, runs, studies, reached(i), error)
            if (allocated(error)) return
        end do
        call write_reached(book, runs, reached, error)
        if (allocated(error)) return

        call add_maps(book, studies, error)
        if (allocated(error)) return
        call add_manoeuvres(book, studies)
        call add_reached(book, runs, reached)
        call add_verdict(book, runs, reached)
    end subroutine add_design_chapter

    subroutine study_design(satellite, threads, study, error)
        character(*), intent(in) :: satellite
        integer, intent(in) :: threads
        type(design_study_t), intent(out) :: study
        type(error_t), allocatable, intent(out) :: error

        type(accelerometer_view_t) :: view
        type(nominal_orbit_t) :: orbit
        type(manoeuvre_site_t), allocatable :: sites(:)
        type(design_settings_t) :: settings
        real(dp), allocatable :: times(:)
        integer :: i

        call find_calibration(satellite//'-1', study%calibration, error)
        if (.not. allocated(error)) call new_accelerometer_view(study%calibration%case, view, error)
        if (.not. allocated(error)) call new_nominal_orbit(study%calibration%case, orbit, error, 1, ORBIT_STEP)
        if (allocated(error)) return
        settings%threads = threads
        settings%lowest_frequency = LOWEST_FREQUENCY
        settings%waveform_used = .false.
        settings%waveform_used(SQUARE) = .true.
        times = [(i*DESIGN_STEP, i=0, int(last_time(orbit)/DESIGN_STEP))]
        study%places = size(times)
        call new_manoeuvre_sites(view, orbit, times, threads, sites, error)
        if (.not. allocated(error)) call design_manoeuvre(view, sites, settings, study%design, error)
        if (allocated(error)) return
        times = [(i*MAP_STEP, i=0, int(last_time(orbit)/MAP_STEP))]
        call map_manoeuvre(view, orbit, times, study%calibration%case%satellite%rods, threads, study%report, error)
        if (allocated(error)) return
        call map_manoeuvre(view, orbit, times, study%design%rods, threads, study%designed, error)
        call take_design(study%design, study%calibration)
        study%calibration%case%name = satellite//'-design'
    end subroutine study_design

    subroutine write_map(book, study, error)
        type(report_book_t), intent(inout) :: book
        type(design_study_t), intent(in) :: study
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        integer :: i

        call file%open(book_file(book, map_file(study%calibration%case%satellite%name)), 'time_s,latitude_deg,longitude_deg,'// &
                       'report_x_mm,report_y_mm,report_z_mm,report_worst_mm,'// &
                       'designed_x_mm,designed_y_mm,designed_z_mm,designed_worst_mm', &
                       [character(120) :: 'gracecg '//VERSION//' '//COMMAND, trim(study%calibration%case%satellite%name)// &
                        ' satellite: theoretical limit of the CG offset, the worst direction last, of the '// &
                        'manoeuvre of case 1', 'and of the designed one, started there'], error)
        if (allocated(error)) return
        do i = 1, size(study%report)
            associate (a => study%report(i), b => study%designed(i))
                call file%row([a%time, a%latitude/DEGREE, a%longitude/DEGREE, a%quality%sigma/MILLIMETRE, &
                               a%worst_sigma/MILLIMETRE, b%quality%sigma/MILLIMETRE, b%worst_sigma/MILLIMETRE])
            end associate
        end do
        call file%commit(error)
    end subroutine write_map

    pure function map_file(satellite) result(name)
        character(*), intent(in) :: satellite
        character(:), allocatable :: name

        name = 'manoeuvre_map_'//trim(satellite)//'.csv'
    end function map_file

    !> Case 1 with the designed manoeuvre, as every command takes it.
    subroutine write_case(book, study, error)
        type(report_book_t), intent(inout) :: book
        type(design_study_t), intent(in) :: study
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: text

        call calibration_text(study%calibration, text, error)
        if (.not. allocated(error)) &
            call file%open(book_file(book, 'designed_'//trim(study%calibration%case%satellite%name)//'.nml'), error)
        if (allocated(error)) return
        call file%line(text)
        call file%commit(error)
    end subroutine write_case

    !> Bound and Monte Carlo of a case with the designed manoeuvre, and calibrations after one trim.
    subroutine calibrate_case(book, number, runs, studies, reached, error)
        type(report_book_t), intent(in) :: book
        integer, intent(in) :: number, runs
        type(design_study_t), intent(in) :: studies(2)
        type(designed_case_t), intent(out) :: reached
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: calibration
        type(manoeuvre_design_t) :: design
        type(case_bound_t) :: bound
        type(simulator_t) :: simulator
        type(monte_carlo_t) :: results
        type(error_statistics_t) :: statistics
        type(trim_settings_t) :: settings
        type(trim_statistics_t) :: rounds(TRIM_ROUNDS)
        integer :: k

        call find_calibration(REPORT_CASE_NAMES(number), calibration, error)
        if (allocated(error)) return
        design = studies(merge(1, 2, calibration%case%satellite%name == SATELLITES(1)))%design
        call take_manoeuvre(design%rods, calibration%case%satellite%rods)
        call bound_of_case(calibration%case, calibration%options, bound, error)
        call take_design(design, calibration)
        if (.not. allocated(error)) call new_simulator(calibration%case, simulator, error)
        if (.not. allocated(error)) call run_monte_carlo(simulator, ALGORITHM, calibration%options, book%seed, &
                                                         [(k, k=1, runs)], book%threads, results, error)
        if (allocated(error)) return
        statistics = statistics_of(results%offset/MILLIMETRE, calibration%case%satellite%offset/MILLIMETRE)
        settings%rounds = TRIM_ROUNDS
        settings%seed = book%seed
        call repeat_trim(calibration%case, ALGORITHM, calibration%options, settings, REPORT_RUNS, &
                         book%threads, rounds, error)
        if (allocated(error)) return
        reached%bound = bound%sigma
        reached%rms = statistics%rms*MILLIMETRE
        reached%not_converged = count(.not. results%converged)
        reached%trimmed = rounds(TRIM_ROUNDS)%estimate_error
    end subroutine calibrate_case

    subroutine write_reached(book, runs, reached, error)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: runs
        type(designed_case_t), intent(in) :: reached(:)
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        character(8) :: labels(2)
        integer :: i, axis

        call file%open(book_file(book, RESULT_FILE), 'case,axis,bound_mm,runs,rms_mm,trim_runs,rms_after_trim_mm', &
                       [character(120) :: 'gracecg '//VERSION//' '//COMMAND, 'the designed manoeuvre, '// &
                        ALGORITHM//', all errors on, seed '//integer_text(book%seed)], error)
        if (allocated(error)) return
        do i = 1, size(reached)
            labels(1) = REPORT_CASE_NAMES(i)
            do axis = 1, 3
                labels(2) = AXES(axis)
                call file%row([reached(i)%bound(axis)/MILLIMETRE, real(runs, dp), reached(i)%rms(axis)/MILLIMETRE, &
                               real(REPORT_RUNS, dp), reached(i)%trimmed(axis)/MILLIMETRE], labels)
            end do
        end do
        call file%commit(error)
    end subroutine write_reached

    !> The chapter's beginning: how it is designed, and the maps.
    subroutine add_maps(book, studies, error)
        type(report_book_t), intent(inout) :: book
        type(design_study_t), intent(in) :: studies(2)
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: best_report, worst_designed
        integer :: i, k

        call book%page%chapter('design', 'Beyond the report: a designed manoeuvre')
        call book%page%paragraph('The report''s two rods swing at one frequency: they turn the satellite about an '// &
                                 'axis that hardly moves, and along that axis the offset cannot be seen. Here '// &
                                 'one manoeuvre of all three rods is searched for each satellite, for the least '// &
                                 'error of the worst axis at '//integer_text(studies(1)%places)//' places along '// &
                                 'one revolution, within the limits of rods, rate and pointing: square waves '// &
                                 'with edges of 1 s, frequencies from '//fixed_text(LOWEST_FREQUENCY, 1)// &
                                 ' to 0.2 Hz, any phases. `gracecg design` searches more widely, for one '// &
                                 'place or for all.')
        call add_figure(book, 'figure_manoeuvre_map', map_script(studies), 'Theoretical limit of each component of the '// &
                       'offset, and of the worst direction, for a calibration that starts there (logarithmic): '// &
                       'the report''s manoeuvre of case 1 and the designed one. Dashed: 0.01 mm.', &
                       'Limits over one revolution, report''s and designed manoeuvre', &
                       'Four panels of four curves over one revolution. With the report''s manoeuvre the '// &
                       'curves vary by orders of magnitude and no place is good for all; with the designed '// &
                       'one all stay near or below 0.01 mm.', error)
        if (allocated(error)) return
        do i = 1, size(studies)
            best_report = minval([(maxval(studies(i)%report(k)%quality%sigma), k=1, size(studies(i)%report))])
            worst_designed = maxval([(maxval(studies(i)%designed(k)%quality%sigma), k=1, size(studies(i)%designed))])
            call book%page%verdict(merge(VERDICT_MET, VERDICT_PARTLY, worst_designed < best_report), &
                                   trim(SATELLITES(i))//': worst axis '//fixed_text(worst_designed/MILLIMETRE, 4)// &
                                   ' mm at the worst place of the designed manoeuvre.', &
                                   'The report''s manoeuvre: '//fixed_text(best_report/MILLIMETRE, 4)//' mm at '// &
                                   'its best.')
        end do
    end subroutine add_maps

    subroutine add_manoeuvres(book, studies)
        type(report_book_t), intent(inout) :: book
        type(design_study_t), intent(in) :: studies(2)

        integer :: i, k

        associate (page => book%page)
            call page%begin_table('The designed manoeuvres; as cases in `designed_front.nml` and '// &
                                  '`designed_back.nml`', 'designed_manoeuvres')
            call page%begin_row()
            call page%column_head('satellite')
            call page%column_head('cases')
            call page%column_head('rod')
            call page%column_head('waveform')
            call page%column_head('amplitude, A m^{2}', numeric=.true.)
            call page%column_head('frequency, Hz', numeric=.true.)
            call page%column_head('phase, deg', numeric=.true.)
            call page%column_head('from, s', numeric=.true.)
            call page%column_head('to, s', numeric=.true.)
            call page%end_row()
            call page%head_end()
            do i = 1, size(studies)
                associate (rods => studies(i)%design%rods)
                    do k = 1, rods%count
                        call page%begin_row(first_of_part=k == 1)
                        if (k == 1) then
                            call page%row_head(trim(SATELLITES(i)), rows=rods%count)
                            call page%row_head(trim(SATELLITES(i))//'-1 to -3', rows=rods%count)
                        end if
                        associate (rod => rods%activations(k))
                            call page%text_cell(AXES(rod%axis))
                            call page%text_cell(trim(WAVEFORM_NAMES(rod%waveform)))
                            call page%number_cell(fixed_text(rod%amplitude, 2))
                            call page%number_cell(fixed_text(rod%frequency, 5))
                            call page%number_cell(fixed_text(rod%phase/DEGREE, 1))
                            call page%number_cell(fixed_text(rod%start, 0))
                            call page%number_cell(fixed_text(rod%stop, 0))
                        end associate
                        call page%end_row()
                    end do
                end associate
            end do
            call page%end_table()
        end associate
    end subroutine add_manoeuvres

    subroutine add_reached(book, runs, reached)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: runs
        type(designed_case_t), intent(in) :: reached(:)

        logical :: good
        integer :: i, axis

        call book%page%paragraph('The six cases with these manoeuvres, all errors on: the noise, the scale '// &
                                 'factors, the bias of the magnetometer, the density wave, and drag and radiation '// &
                                 'as they are. Part of the error grows with the offset: scale factors and the '// &
                                 'magnetometer''s bias, which `'//ALGORITHM//'` estimates here, though hardly better '// &
                                 'than they are known. So the last columns show a second calibration, after the masses '// &
                                 'have been moved by the estimate of the first (1 % error of the mass balancing).')
        associate (page => book%page)
            call page%begin_table('RMS error of `'//ALGORITHM//'` with the designed manoeuvre, mm: '// &
                                  integer_text(runs)//' runs; after one trim '//integer_text(REPORT_RUNS)//' runs', &
                                  'designed_reached')
            call page%begin_row()
            call page%column_head('case')
            call page%column_head('bound x, y, z', columns=3)
            call page%column_head('RMS x, y, z', columns=3)
            call page%column_head('after one trim x, y, z', columns=3)
            call page%end_row()
            call page%head_end()
            do i = 1, size(reached)
                call page%begin_row()
                call page%row_head(trim(REPORT_CASE_NAMES(i)))
                do axis = 1, 3
                    call page%number_cell(fixed_text(reached(i)%bound(axis)/MILLIMETRE, 5))
                end do
                do axis = 1, 3
                    good = reached(i)%rms(axis) <= GOAL
                    call page%judged_cell(merge(VERDICT_MET, VERDICT_MISSED, good), pick_text(good, 'met', 'missed'), &
                                          fixed_text(reached(i)%rms(axis)/MILLIMETRE, 5))
                end do
                do axis = 1, 3
                    good = reached(i)%trimmed(axis) <= GOAL
                    call page%judged_cell(merge(VERDICT_MET, VERDICT_MISSED, good), pick_text(good, 'met', 'missed'), &
                                          fixed_text(reached(i)%trimmed(axis)/MILLIMETRE, 5))
                end do
                call page%end_row()
            end do
            call page%end_table()
        end associate
    end subroutine add_reached

    !> Ten micrometres in every axis of every case.
    subroutine add_verdict(book, runs, reached)
        type(report_book_t), intent(inout) :: book
        integer, intent(in) :: runs
        type(designed_case_t), intent(in) :: reached(:)

        real(dp) :: worst(size(reached)), worst_trimmed(size(reached))
        character(:), allocatable :: found
        integer :: i, good, good_trimmed, missing, kind

        do i = 1, size(reached)
            worst(i) = maxval(reached(i)%rms)
            worst_trimmed(i) = maxval(reached(i)%trimmed)
        end do
        good = count(worst <= GOAL)
        good_trimmed = count(worst_trimmed <= GOAL)
        missing = sum(reached%not_converged)
        kind = VERDICT_MISSED
        if (good_trimmed == size(reached) .and. missing == 0) kind = VERDICT_PARTLY
        if (good == size(reached) .and. missing == 0) kind = VERDICT_MET
        found = share_text(good, size(reached))//' cases at once (worst axis '// &
                fixed_text(maxval(worst)/MILLIMETRE, 4)//' mm), '//share_text(good_trimmed, size(reached))// &
                ' after one trim ('//fixed_text(maxval(worst_trimmed)/MILLIMETRE, 4)//' mm)'
        call book%page%verdict(kind, '0.01 mm in every axis: '//found//'.', 'RMS of '//integer_text(runs)//' runs '// &
                               'and, after the trim, of '//integer_text(REPORT_RUNS)//', which scatters by 18 %'// &
                               pick_text(missing > 0, '; '//integer_text(missing)//' runs did not converge', '')//'.')
        call add_finding(book, 'beyond: design', 'designed_reached', '0.01 mm in every axis of all six cases with one '// &
                       'designed manoeuvre per satellite (the report reaches about 0.1 mm)', found, kind, &
                       pick_text(kind == VERDICT_MET, 'reached', &
                                      pick_text(kind == VERDICT_PARTLY, 'reached after a trim', 'missed')))
    end subroutine add_verdict

    !> Report's and designed manoeuvre of either satellite below each other.
    function map_script(studies) result(script)
        type(design_study_t), intent(in) :: studies(2)
        character(:), allocatable :: script

        type(panel_t) :: panels(4)
        type(legend_item_t) :: legend(5)
        type(grid_t) :: grid
        integer :: i, m, axis, place

        grid%panel_height = 170
        grid%x_label = 'time, s'
        grid%x_high = studies(1)%report(size(studies(1)%report))%time
        grid%settings = 'set xtics 1000'//LF//'set logscale y'//LF//'set format y "10^{%L}"'//LF// &
                        'set yrange [1e-4:10]'
        do i = 1, 2
            do m = 1, size(MANOEUVRES)
                place = 2*(i - 1) + m
                panels(place)%title = trim(SATELLITES(i))//', '//pick_text(m == 1, 'report''s', 'designed')// &
                                      ' manoeuvre: limit, mm'
                panels(place)%plot = real_text(GOAL/MILLIMETRE)//' with lines linetype 5'
                panels(place)%plot = trim(panels(place)%plot)//', '//curve_of(i, m, 'worst')// &
                                     ' linecolor rgb ink linewidth 1'
                do axis = 1, 3
                    panels(place)%plot = trim(panels(place)%plot)//', '//curve_of(i, m, AXES(axis))// &
                                         ' linetype '//integer_text(axis)
                end do
            end do
        end do
        do axis = 1, 3
            legend(axis) = legend_item_t(AXES(axis), axis)
        end do
        legend(4) = legend_item_t('worst direction', 0)
        legend(5) = legend_item_t('0.01 mm', 5)
        script = panel_grid('figure_manoeuvre_map', 'Limit of the CG offset over one revolution, report''s and '// &
                            'designed manoeuvre', grid, panels, legend, TIME_OF_CASE, 'case')
    end function map_script

    pure function curve_of(satellite, manoeuvre, column) result(plot)
        integer, intent(in) :: satellite, manoeuvre
        character(*), intent(in) :: column
        character(:), allocatable :: plot

        plot = '"'//map_file(SATELLITES(satellite))//'" using "time_s":"'//trim(MANOEUVRES(manoeuvre))//'_'// &
               column//'_mm" with lines'
    end function curve_of
end module gracecg_cli_chapter_design
