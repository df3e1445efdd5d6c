!> The report page: Figures 6.1 and 6.4, the field and the angular acceleration over one revolution.
module gracecg_cli_chapter_timing
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, NANOTESLA, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text
    use gracecg_simulation_report_cases, only: TIME_OF_CASE
    use gracecg_planning_scan, only: orbit_place_t
    use gracecg_studies_published_axes, only: published_axis_limits
    use gracecg_studies_timing, only: timing_study_t, timing_summary_t, summary_of, best_places, write_places
    use gracecg_cli_document, only: table_rows_t, head_cell, number_cell, number_cells, VERDICT_MET, VERDICT_PARTLY, &
        VERDICT_MISSED
    use gracecg_cli_panels, only: panel_t, legend_item_t, grid_t, panel_grid, curve
    use gracecg_cli_report_book, only: report_book_t, book_file, add_figure, add_claim, COMMAND, SATELLITES
    use gracecg_cli_number_text, only: pick_text, fixed_text, scaled_text, percent_text
    implicit none
    private
    public :: add_field_chapter, add_timing_chapter

    real(dp), parameter :: MICRO = 1e-6_dp

contains

    pure function file_of(satellite) result(name)
        character(*), intent(in) :: satellite
        character(:), allocatable :: name

        name = 'timing_'//trim(satellite)//'.csv'
    end function file_of

    !> Figure 6.1; writes timing_SATELLITE.csv, which Figure 6.4 needs, too.
    subroutine add_field_chapter(book, studies, error)
        type(report_book_t), intent(inout) :: book
        type(timing_study_t), intent(in) :: studies(2)      !! Front, back
        type(error_t), allocatable, intent(out) :: error

        type(timing_summary_t) :: summary
        character(:), allocatable :: strongest(:)
        real(dp) :: limits(2)
        logical :: met
        integer :: i

        limits = published_axis_limits('6.1', 'front', 'field', 'all')
        met = .true.
        allocate (character(12) :: strongest(2))
        do i = 1, 2
            call write_places(book_file(book, file_of(SATELLITES(i))), COMMAND, studies(i)%case, studies(i)%places, error)
            if (allocated(error)) return
            summary = summary_of(studies(i))
            strongest(i) = fixed_text(summary%strongest_field/NANOTESLA, 0)
            met = met .and. summary%strongest_field/NANOTESLA <= limits(2)
        end do

        call book%page%chapter('field', 'Where: the magnetic field of the three cases, Figure 6.1')
        call book%page%paragraph('Torque rods push against the geomagnetic field, so the field along the satellite''s '// &
                                 'axes decides on the manoeuvre. The report''s cases lie near the equator, near the '// &
                                 'north pole and between both, all on the orbit of case 1: case 2 is reached 1400 s '// &
                                 'and case 3 2658 s after it.')
        call add_figure(book, 'figure_6_1', field_script(studies, limits), 'Figure 6.1. Geomagnetic field in body '// &
                        'axes over one revolution, front satellite (top) and back satellite (bottom), with the places '// &
                        'of the three cases. The vertical axis is the printed one.', &
                        'Figure 6.1, magnetic field over one revolution', 'Two panels of three curves over one '// &
                        'revolution. The field along x and z swings between plus and minus 48 thousand nanotesla; '// &
                        'along y it stays small.')
        call book%page%verdict(merge(VERDICT_MET, VERDICT_MISSED, met), &
                               pick_text(met, 'Within the printed axis.', 'Beyond the printed axis.'), &
                               'Strongest component '//trim(strongest(1))//' nT (front) and '//trim(strongest(2))// &
                               ' nT (back); the axis ends at '//fixed_text(limits(2), 0)//' nT.')
        call add_claim(book, 'Figure 6.1', 'figure_6_1', 'the field stays within 50000 nT', 'strongest component '// &
                       trim(strongest(1))//' and '//trim(strongest(2))//' nT', merge(VERDICT_MET, VERDICT_MISSED, met), &
                       pick_text(met, 'agrees', 'differs'))
    end subroutine add_field_chapter

    !> Field, angular acceleration and sigma at the places of the cases and at the best ones.
    subroutine add_places(book, studies)
        type(report_book_t), intent(inout) :: book
        type(timing_study_t), intent(in) :: studies(2)

        character(5), parameter :: BEST_FOR(4) = [character(5) :: AXES, 'all']
        type(table_rows_t) :: rows
        integer :: best(4), i, k

        do i = 1, 2
            do k = 1, size(studies(i)%of_cases)
                call rows%add(place_cells(SATELLITES(i), 'case '//integer_text(k), studies(i)%of_cases(k)))
            end do
            best = best_places(studies(i)%places)
            do k = 1, size(best)
                call rows%add(place_cells(SATELLITES(i), 'best for '//trim(BEST_FOR(k)), studies(i)%places(best(k))))
            end do
        end do
        call book%page%table('Places of the cases and best places', [character(48) :: 'satellite', 'place', 'time, s', &
                             'latitude', 'longitude', 'field x, y, z, nT', '', '', &
                             'angular acceleration x, y, z, 10^{-6} rad/s^{2}', '', '', &
                             'predicted sigma x, y, z, mm', '', ''], rows, 'places')
        call book%page%paragraph('Best for all: the place where the largest of the three standard deviations is '// &
                                 'least. Places every '//integer_text(studies(1)%step)//' s.')
    end subroutine add_places

    function place_cells(satellite, label, place) result(cells)
        character(*), intent(in) :: satellite, label
        type(orbit_place_t), intent(in) :: place
        character(:), allocatable :: cells

        cells = head_cell(trim(satellite))//head_cell(label)//number_cell(integer_text(place%time))// &
                number_cell(fixed_text(abs(place%latitude/DEGREE), 1)//merge(' N', ' S', place%latitude >= 0))// &
                number_cell(fixed_text(abs(place%longitude/DEGREE), 1)//merge(' E', ' W', place%longitude >= 0))// &
                number_cells(place%field/NANOTESLA, 0)//number_cells(place%acceleration/MICRO, 2)// &
                number_cells(place%sigma/MILLIMETRE, 4)
    end function place_cells

    !> Figure 6.4, and the standard deviations that follow.
    subroutine add_timing_chapter(book, studies, error)
        type(report_book_t), intent(inout) :: book
        type(timing_study_t), intent(in) :: studies(2)      !! Front, back
        type(error_t), allocatable, intent(out) :: error

        type(timing_summary_t) :: summary(2)
        real(dp) :: limits(2)
        logical :: on_axis, met
        integer :: i

        summary = [(summary_of(studies(i)), i=1, 2)]
        limits = published_axis_limits('6.4', 'front', 'acceleration', 'all')
        on_axis = all(summary%largest <= limits(2))
        met = all(summary%x_strongest > 0.5_dp) .and. all(summary%x_weakest >= 50 .and. summary%x_weakest <= 200)

        call book%page%chapter('timing', 'When: the angular acceleration over one revolution, Figure 6.4')
        call book%page%paragraph('Along the direction of the angular acceleration the offset cannot be seen. So x is '// &
                                 'determined well where the angular acceleration about x is small, and y and z where '// &
                                 'it is large.')
        call add_figure(book, 'figure_6_4', acceleration_script(studies, limits), 'Figure 6.4. Amplitude of the '// &
                        'angular acceleration if the rods are activated along y and z, over one revolution, front '// &
                        'satellite (top) and back satellite (bottom). The vertical axis is the printed one.', &
                        'Figure 6.4, angular acceleration over one revolution', 'Two panels of three curves over one '// &
                        'revolution. About x the angular acceleration is largest nearly everywhere, and falls below '// &
                        'the others for about 100 s.')
        call book%page%verdict(merge(VERDICT_MET, VERDICT_MISSED, on_axis), &
                               pick_text(on_axis, 'Within the printed axis.', 'Beyond the printed axis.'), &
                               'Largest amplitude '//scaled_text(summary(1)%largest, -5, 2)//' (front) and '// &
                               scaled_text(summary(2)%largest, -5, 2)//' x 10^{-5} rad/s^{2} (back); the axis ends at '// &
                               scaled_text(limits(2), -5, 1)//'.')
        call book%page%verdict(merge(VERDICT_MET, VERDICT_PARTLY, met), 'Larger about x than about y and z in '// &
                               percent_text(summary(1)%x_strongest)//' (front) and '// &
                               percent_text(summary(2)%x_strongest)//' (back) of the revolution, smaller for '// &
                               integer_text(summary(1)%x_weakest)//' s and '//integer_text(summary(2)%x_weakest)//' s.', &
                               'The report: "most of time" and "in a very small period (~100 sec.)".')
        call add_claim(book, 'Figure 6.4', 'figure_6_4', 'amplitude below 2.5 x 10^{-5} rad/s^{2}; about x mostly '// &
                       'the largest, the smallest for about 100 s', 'to '// &
                       scaled_text(maxval(summary%largest), -5, 2)//' x 10^{-5}; largest about x in '// &
                       percent_text(summary(1)%x_strongest)//' and '//percent_text(summary(2)%x_strongest)// &
                       ', smallest for '//integer_text(summary(1)%x_weakest)//' and '// &
                       integer_text(summary(2)%x_weakest)//' s', merge(VERDICT_MET, VERDICT_PARTLY, met .and. on_axis), &
                       pick_text(met .and. on_axis, 'agrees', 'agrees in part'))
        call add_figure(book, 'figure_6_4_sigma', sigma_script(studies), 'In addition to the report: predicted '// &
                        'standard deviation of each component of the offset for a calibration that starts there '// &
                        '(logarithmic). No place is good for all three.', 'Predicted standard deviation over one '// &
                        'revolution', 'Two panels of three curves. The standard deviation of x is least near 2700 s, '// &
                        'where that of y and z is largest.')
        if (.not. allocated(error)) call add_places(book, studies)
    end subroutine add_timing_chapter

    function field_script(studies, limits) result(script)
        type(timing_study_t), intent(in) :: studies(2)
        real(dp), intent(in) :: limits(2)
        character(:), allocatable :: script

        script = orbit_script(grid_t(y_low=limits(1)*1e-4_dp, y_high=limits(2)*1e-4_dp, y_step=2.5_dp), studies, &
                              'field, 10^4 nT', [character(8) :: 'bx_nt', 'by_nt', 'bz_nt'], 1e-4_dp, &
                              [character(6) :: 'B_x', 'B_y', 'B_z'])
    end function field_script

    function acceleration_script(studies, limits) result(script)
        type(timing_study_t), intent(in) :: studies(2)
        real(dp), intent(in) :: limits(2)
        character(:), allocatable :: script

        script = orbit_script(grid_t(y_low=limits(1)*1e5_dp, y_high=limits(2)*1e5_dp, y_step=0.5_dp), studies, &
                              'angular acceleration, 10^{-5} rad/s^2', &
                              [character(14) :: 'alpha_x_rad_s2', 'alpha_y_rad_s2', 'alpha_z_rad_s2'], 1e5_dp, &
                              [character(6) :: 'x', 'y', 'z'])
    end function acceleration_script

    function sigma_script(studies) result(script)
        type(timing_study_t), intent(in) :: studies(2)
        character(:), allocatable :: script

        script = orbit_script(grid_t(logarithmic=.true., y_low=1e-4_dp, y_high=10.0_dp), studies, 'standard deviation, mm', &
                              [character(10) :: 'sigma_x_mm', 'sigma_y_mm', 'sigma_z_mm'], 1.0_dp, &
                              [character(6) :: 'x', 'y', 'z'])
    end function sigma_script

    !> Two panels of three curves, the cases marked.
    function orbit_script(axes_of, studies, title, columns, factor, labels) result(script)
        type(grid_t), intent(in) :: axes_of             !! Its ordinates
        type(timing_study_t), intent(in) :: studies(2)
        character(*), intent(in) :: title               !! Quantity and unit
        character(*), intent(in) :: columns(3), labels(3)
        real(dp), intent(in) :: factor                  !! From the file's unit to that of the plot
        character(:), allocatable :: script

        type(panel_t) :: panels(2)
        type(legend_item_t) :: legend(3)
        type(grid_t) :: grid
        integer :: i, axis

        grid = axes_of
        grid%panel_height = 250
        grid%x_label = 'time, s'
        grid%x_high = studies(1)%places(size(studies(1)%places))%time
        grid%x_step = 1000
        do i = 1, 2
            panels(i)%title = trim(SATELLITES(i))//': '//title
            do axis = 1, 3
                panels(i)%curves = trim(panels(i)%curves)// &
                                   curve(file_of(SATELLITES(i)), 'time_s', trim(columns(axis)), axis, factor)
            end do
        end do
        do axis = 1, 3
            legend(axis) = legend_item_t(labels(axis), axis)
        end do
        script = panel_grid(grid, panels, legend, TIME_OF_CASE, 'case')
    end function orbit_script
end module gracecg_cli_chapter_timing
