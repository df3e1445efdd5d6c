!> The report page: Figures 2.1, 2.2, 3.2, 4.1 and 5.1 as drawn for docs/theory.md, and Table 5.1, what acts in
!> the simulation.
module gracecg_cli_report_drawings
    use gracecg_base_text, only: integer_text, rounded_text
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_simulation_case, only: case_t
    use gracecg_cli_document, only: document_t, table_rows_t, head_cell, text_cell
    use gracecg_cli_number_text, only: pick_text
    implicit none
    private
    public :: add_drawing, add_sources_table

contains

    !> One of the report's drawings.
    subroutine add_drawing(page, number, name, caption)
        type(document_t), intent(inout) :: page
        character(3), intent(in) :: number          !! Of the figure in the report: '2.1'
        character(*), intent(in) :: name            !! Of the drawing: its file in docs/images
        character(*), intent(in) :: caption         !! Behind the number

        call page%figure('figure_'//number(1:1)//'_'//number(3:3), name, 'Figure '//number//'. '//caption)
    end subroutine add_drawing

    !> Table 5.1 with the settings of the report's cases.
    subroutine add_sources_table(page, calibrations)
        type(document_t), intent(inout) :: page
        type(calibration_t), intent(in) :: calibrations(:)  !! Of the report's cases, the first of each place first

        type(table_rows_t) :: rows
        character(:), allocatable :: winds
        integer :: i

        winds = ''
        do i = 1, size(calibrations)
            associate (case => calibrations(i)%case)
                winds = winds//pick_text(i > 1, '; ', '')//trim(case%name)//' '//wind_text(case)
            end associate
        end do
        associate (case => calibrations(1)%case, body => calibrations(1)%case%satellite)
            call row('Earth''s gravitation', 'spherical harmonics', 'gravity gradient of a sphere (2-23)', &
                     trim(case%gravity_model)//' to degree '//integer_text(case%gravity_degree)//' and order '// &
                     integer_text(case%gravity_order))
            call row('air', 'drag (2-6) with one cross-section', 'plate by plate (report: AMA/LaRC)', &
                     trim(case%density_model)//' times '//rounded_text(case%density_scale, 6)//'; C_{d} = '// &
                     rounded_text(body%drag_coefficient, 4))
            call row('wind', 'in the drag', 'in the torque of the air', winds)
            call row('density wave', pick_text(case%density_wave_random, 'none; only in the drag that the accelerometer '// &
                                               'samples', 'in the drag'), 'none', &
                     'amplitude '//rounded_text(case%density_wave%amplitude, 4)//' of the density, period '// &
                     rounded_text(case%density_wave%period, 4)//' s, phase '// &
                     pick_text(case%density_wave_random, 'of each run random', 'given'))
            call row('sunlight', 'pressure (2-8)', 'plate by plate (report: AMA/LaRC)', 'eta = '// &
                     rounded_text(body%reflectivity_sun, 4)//'; plates '//rounded_text(body%specular, 4)//' specular, '// &
                     rounded_text(body%diffuse, 4)//' diffuse')
            call row('Earth radiation', 'pressure (2-10)', 'none', &
                     integer_text(1 + 3*case%earth_radiation_rings*(case%earth_radiation_rings + 1))// &
                     ' segments, '//trim(case%earth_radiation_constants)//'; eta_{e} = '// &
                     rounded_text(body%reflectivity_earth, 4))
            call row('Earth''s magnetic field', 'none', 'torque rods, m x B (2-25)', trim(case%field_model)//'; rods to '// &
                     rounded_text(maxval(abs(body%rods%activations%amplitude)), 4)//' A m^{2}')
        end associate
        call page%table('Table 5.1. What acts, and with which settings in the six cases', [character(26) :: 'source', &
                        'acceleration of the orbit', 'torque of the attitude', 'settings'], rows, 'table_5_1')

    contains

        subroutine row(source, acceleration, torque, settings)
            character(*), intent(in) :: source, acceleration, torque, settings

            call rows%add(head_cell(source)//text_cell(acceleration, wraps=.true.)//text_cell(torque, wraps=.true.)// &
                          text_cell(settings, wraps=.true.))
        end subroutine row
    end subroutine add_sources_table

    !> The wind of a case in a few words.
    function wind_text(case) result(text)
        type(case_t), intent(in) :: case
        character(:), allocatable :: text

        text = trim(case%wind_model)
        if (text == 'constant') text = rounded_text(case%wind_east, 4)//' m/s eastward, '// &
                                       rounded_text(case%wind_north, 4)//' m/s northward'
    end function wind_text
end module gracecg_cli_report_drawings
