!> The report page, beyond the report: the report's manoeuvre and a designed one over a revolution, and
!> what the designed one reaches in the six cases.
module gracecg_cli_chapter_design
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_statistics, only: sampling_error
    use gracecg_base_text, only: integer_text
    use gracecg_files_file, only: output_file_t
    use gracecg_spacecraft_torque_rods, only: WAVEFORM_NAMES
    use gracecg_planning_calibration, only: calibration_text
    use gracecg_simulation_report_cases, only: TIME_OF_CASE
    use gracecg_studies_designed_manoeuvre, only: design_study_t, worst_at_best_place, worst_at_worst_place, &
        designed_calibration_t, write_design_map, write_designed_calibrations, LOWEST_FREQUENCY, &
        ALGORITHM => DESIGN_ALGORITHM
    use gracecg_cli_document, only: table_rows_t, head_cell, number_cell, number_cells, judged_cell, text_cell, &
        VERDICT_MET, VERDICT_PARTLY, VERDICT_MISSED
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid, curve, level
    use gracecg_cli_report_book, only: report_book_t, book_file, add_figure, add_claim, COMMAND, SATELLITES
    use gracecg_cli_number_text, only: pick_text, fixed_text, percent_text, share_text
    implicit none
    private
    public :: add_design_chapter

    character(8), parameter :: MANOEUVRES(2) = [character(8) :: 'report', 'designed']
    real(dp), parameter :: GOAL = 10e-6_dp          !! RMS error of every component, m
    character(*), parameter :: RESULT_FILE = 'design.csv'

contains

    !> Adds the chapter on the designed manoeuvres and what they reach.
    subroutine add_design_chapter(book, studies, reached, error)
        type(report_book_t), intent(inout) :: book
        type(design_study_t), intent(in) :: studies(2)              !! Front, back
        type(designed_calibration_t), intent(in) :: reached(:)      !! In the report's cases
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        do i = 1, size(studies)
            call write_design_map(book_file(book, map_file(SATELLITES(i))), COMMAND, studies(i), error)
            if (.not. allocated(error)) call write_case(book, SATELLITES(i), studies(i), error)
            if (allocated(error)) return
        end do
        call write_designed_calibrations(book_file(book, RESULT_FILE), COMMAND, book%seed, reached, error)
        if (allocated(error)) return
        call add_maps(book, studies)
        call add_manoeuvres(book, studies)
        call add_reached(book, reached)
        call add_verdict(book, reached)
    end subroutine add_design_chapter

    pure function map_file(satellite) result(name)
        character(*), intent(in) :: satellite
        character(:), allocatable :: name

        name = 'manoeuvre_map_'//trim(satellite)//'.csv'
    end function map_file

    !> Case 1 with the designed manoeuvre, as every command takes it.
    subroutine write_case(book, satellite, study, error)
        type(report_book_t), intent(inout) :: book
        character(*), intent(in) :: satellite
        type(design_study_t), intent(in) :: study
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: text

        call calibration_text(study%calibration, text, error)
        if (.not. allocated(error)) call file%open(book_file(book, 'designed_'//trim(satellite)//'.nml'), error)
        if (allocated(error)) return
        call file%line(text)
        call file%commit(error)
    end subroutine write_case

    !> The chapter's beginning: how it is designed, and the maps.
    subroutine add_maps(book, studies)
        type(report_book_t), intent(inout) :: book
        type(design_study_t), intent(in) :: studies(2)

        real(dp) :: best_report, worst_designed
        integer :: i

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
                       'one all stay near or below 0.01 mm.')
        do i = 1, size(studies)
            best_report = worst_at_best_place(studies(i)%report)
            worst_designed = worst_at_worst_place(studies(i)%designed)
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

        type(table_rows_t) :: rows
        character(:), allocatable :: cells
        integer :: i, k

        do i = 1, size(studies)
            associate (rods => studies(i)%design%rods)
                cells = head_cell(trim(SATELLITES(i)), rows=rods%count)// &
                        head_cell(trim(SATELLITES(i))//'-1 to -3', rows=rods%count)
                do k = 1, rods%count
                    associate (rod => rods%activations(k))
                        call rows%add(cells//text_cell(AXES(rod%axis))//text_cell(trim(WAVEFORM_NAMES(rod%waveform)))// &
                                      number_cells([rod%amplitude], 2)//number_cells([rod%frequency], 5)// &
                                      number_cells([rod%phase/DEGREE], 1)//number_cells([rod%start, rod%stop], 0))
                    end associate
                    cells = ''
                end do
            end associate
        end do
        call book%page%table('The designed manoeuvres; as cases in `designed_front.nml` and `designed_back.nml`', &
                             [character(18) :: 'satellite', 'cases', 'rod', 'waveform', 'amplitude, A m^{2}', &
                              'frequency, Hz', 'phase, deg', 'from, s', 'to, s'], rows, 'designed_manoeuvres')
    end subroutine add_manoeuvres

    subroutine add_reached(book, reached)
        type(report_book_t), intent(inout) :: book
        type(designed_calibration_t), intent(in) :: reached(:)

        type(table_rows_t) :: rows
        integer :: i

        call book%page%paragraph('The six cases with these manoeuvres, all errors on: the noise, the scale '// &
                                 'factors, the bias of the magnetometer, the density wave, and drag and radiation '// &
                                 'as they are. Part of the error grows with the offset: scale factors and the '// &
                                 'magnetometer''s bias, which `'//ALGORITHM//'` estimates here, though hardly better '// &
                                 'than they are known. So the last columns show a second calibration, after the masses '// &
                                 'have been moved by the estimate of the first (1 % error of the mass balancing).')
        do i = 1, size(reached)
            call rows%add(head_cell(trim(reached(i)%case_name))//number_cells(reached(i)%bound/MILLIMETRE, 5)// &
                          goal_cells(reached(i)%rms)//goal_cells(reached(i)%trimmed))
        end do
        call book%page%table('RMS error of `'//ALGORITHM//'` with the designed manoeuvre, mm: '// &
                             integer_text(reached(1)%runs)//' runs', [character(22) :: 'case', 'bound x, y, z', &
                             '', '', 'RMS x, y, z', '', '', 'after one trim x, y, z', '', ''], rows, 'designed_reached')
    end subroutine add_reached

    !> RMS errors, each judged by the goal.
    function goal_cells(rms) result(cells)
        real(dp), intent(in) :: rms(3)          !! m
        character(:), allocatable :: cells

        logical :: met
        integer :: axis

        cells = ''
        do axis = 1, 3
            met = rms(axis) <= GOAL
            cells = cells//judged_cell(merge(VERDICT_MET, VERDICT_MISSED, met), pick_text(met, 'met', 'missed'), &
                                       fixed_text(rms(axis)/MILLIMETRE, 5))
        end do
    end function goal_cells

    !> Ten micrometres in every axis of every case.
    subroutine add_verdict(book, reached)
        type(report_book_t), intent(inout) :: book
        type(designed_calibration_t), intent(in) :: reached(:)

        real(dp) :: worst(size(reached)), worst_trimmed(size(reached))
        character(:), allocatable :: found
        integer :: i, good, good_trimmed, kind

        do i = 1, size(reached)
            worst(i) = maxval(reached(i)%rms)
            worst_trimmed(i) = maxval(reached(i)%trimmed)
        end do
        good = count(worst <= GOAL)
        good_trimmed = count(worst_trimmed <= GOAL)
        kind = VERDICT_MISSED
        if (good_trimmed == size(reached)) kind = VERDICT_PARTLY
        if (good == size(reached)) kind = VERDICT_MET
        found = share_text(good, size(reached))//' cases at once (worst axis '// &
                fixed_text(maxval(worst)/MILLIMETRE, 4)//' mm), '//share_text(good_trimmed, size(reached))// &
                ' after one trim ('//fixed_text(maxval(worst_trimmed)/MILLIMETRE, 4)//' mm)'
        call book%page%verdict(kind, '0.01 mm in every axis: '//found//'.', 'RMS of '//integer_text(reached(1)%runs)// &
                               ' runs, which scatters by '//percent_text(sampling_error(reached(1)%runs))//'.')
        call add_claim(book, 'beyond: design', 'designed_reached', '0.01 mm in every axis of all six cases with one '// &
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
        grid%x_step = 1000
        grid%logarithmic = .true.
        grid%y_low = 1e-4_dp
        grid%y_high = 10
        do i = 1, 2
            do m = 1, size(MANOEUVRES)
                place = 2*(i - 1) + m
                panels(place)%title = trim(SATELLITES(i))//', '//pick_text(m == 1, 'report''s', 'designed')// &
                                      ' manoeuvre: limit, mm'
                panels(place)%curves = level(GOAL/MILLIMETRE, 5)//curve_of(i, m, 'worst', 0)
                do axis = 1, 3
                    panels(place)%curves = trim(panels(place)%curves)//curve_of(i, m, AXES(axis), axis)
                end do
            end do
        end do
        do axis = 1, 3
            legend(axis) = legend_item_t(AXES(axis), axis)
        end do
        legend(4) = legend_item_t('worst direction', 0)
        legend(5) = legend_item_t('0.01 mm', 5)
        script = panel_grid(grid, panels, legend, TIME_OF_CASE, 'case')
    end function map_script

    function curve_of(satellite, manoeuvre, column, colour) result(json)
        integer, intent(in) :: satellite, manoeuvre, colour
        character(*), intent(in) :: column
        character(:), allocatable :: json

        json = curve(map_file(SATELLITES(satellite)), 'time_s', trim(MANOEUVRES(manoeuvre))//'_'//column//'_mm', colour)
    end function curve_of
end module gracecg_cli_chapter_design
