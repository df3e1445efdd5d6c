!> The report page: what is simulated, the six cases and their settings.
module gracecg_cli_chapter_simulation
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_environment_time, only: utc_text
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES, TIME_OF_CASE
    use gracecg_planning_calibration, only: calibration_t, find_calibration, calibration_text
    use gracecg_cli_cases, only: case_place, rods_text
    use gracecg_cli_document, only: table_rows_t, head_cell, number_cell, number_cells, text_cell
    use gracecg_cli_report_book, only: report_book_t
    use gracecg_cli_report_drawings, only: add_drawing, add_sources_table
    use gracecg_cli_number_text, only: fixed_text
    implicit none
    private
    public :: add_simulation_chapter

contains

    !> Adds the chapter on what is simulated. Fails when a case's models cannot be built.
    subroutine add_simulation_chapter(book, error)
        type(report_book_t), intent(inout) :: book
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: calibrations(size(REPORT_CASE_NAMES))
        type(table_rows_t) :: rows
        character(:), allocatable :: text
        real(dp) :: latitude, longitude, height
        integer :: i

        do i = 1, size(calibrations)
            call find_calibration(REPORT_CASE_NAMES(i), calibrations(i), error)
            if (.not. allocated(error)) call case_place(calibrations(i)%case, latitude, longitude, height, error)
            if (allocated(error)) return
            associate (case => calibrations(i)%case)
                call rows%add(head_cell(trim(case%name))//text_cell(trim(utc_text(case%epoch)))// &
                              number_cells([TIME_OF_CASE(case%number)], 0)// &
                              number_cell(fixed_text(abs(latitude)/DEGREE, 1)//merge(' N', ' S', latitude >= 0))// &
                              number_cell(fixed_text(abs(longitude)/DEGREE, 1)//merge(' E', ' W', longitude >= 0))// &
                              number_cells([height/1000], 0)//text_cell(without_unit(rods_text(case%satellite%rods)))// &
                              number_cells(case%satellite%offset/MILLIMETRE, 1))
            end associate
        end do
        call book%page%chapter('simulation', 'What is simulated')
        call book%page%paragraph('Two satellites fly behind each other at 460 km in a polar orbit, the '// &
                            'back one turned to face the front one. For a calibration the torque '// &
                            'rods of one satellite swing for 60 s at 0.1 Hz with 30 A m^{2} on two '// &
                            'axes and shake it against the geomagnetic field. Where the proof mass '// &
                            'of the accelerometer is off the centre of mass by d, the accelerometer '// &
                            'feels the angular acceleration times d; from its samples, from two '// &
                            'star cameras and from the magnetometer, d is estimated.')
        call book%page%paragraph('Truth: orbit and attitude by an RKF7(8) integration with EGM96 to '// &
                            'degree and order 20, IGRF-95, DTM-77 with a short-period density wave, '// &
                            'radiation of Sun and Earth, and all torques. Accelerometer at 10 Hz '// &
                            'with the coloured noise of (3-2), scale factors and bias; star cameras '// &
                            'at 2 Hz, attitude by QUEST from catalogued stars; magnetometer at 1 Hz '// &
                            'with noise and bias. The estimators see the samples and what an '// &
                            'operator knows, never the truth.')
        call add_drawing(book%page, '2.1', 'frames', 'The frames. The pitch of 1 degree is half the angle between the '// &
                         'satellites at the Earth''s centre, so that each looks along the line of sight.')
        call add_drawing(book%page, '2.2', 'radial_vector', 'The unit vector c in body axes, drawn far from the '// &
                         'vertical that it is in flight, and the offset d.')
        call add_drawing(book%page, '5.1', 'simulation', 'From a case to the errors of its estimates. The true arc is '// &
                         'propagated once; each run draws noise, and the phase of the density wave, anew.')
        call add_sources_table(book%page, calibrations)
        call add_drawing(book%page, '3.2', 'star_camera', 'Simulation of the star camera. The stars of all frames are '// &
                         'found once for an arc; a run only adds noise and solves.')
        call book%page%table('The six cases', [character(26) :: 'case', 'epoch (UTC)', 'orbit, s', 'latitude', &
                             'longitude', 'height, km', 'rods x, y, z, A m^{2}', 'true offset x, y, z, mm', '', ''], &
                             rows, 'cases')
        call book%page%paragraph('Every setting of a case, with unit and meaning, as `gracecg cases show CASE` prints it:')
        do i = 1, size(calibrations)
            call calibration_text(calibrations(i), text, error)
            if (allocated(error)) return
            call book%page%details(trim(REPORT_CASE_NAMES(i)), text)
        end do
    end subroutine add_simulation_chapter

    !> The rods' amplitudes without the unit, which stands in the head.
    pure function without_unit(text) result(numbers)
        character(*), intent(in) :: text
        character(:), allocatable :: numbers

        integer :: last

        last = index(text, ' A m^2')
        if (last == 0) last = len(text) + 1
        numbers = text(:last - 1)
    end function without_unit
end module gracecg_cli_chapter_simulation
