!> The tables that only the report page has: its cases with what acts in them, the designed manoeuvres.
module gracecg_cli_report_tables
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, DEGREE, MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_environment_time, only: utc_text
    use gracecg_files_data_table, only: data_table_t
    use gracecg_spacecraft_torque_rods, only: WAVEFORM_NAMES
    use gracecg_simulation_report_cases, only: TIME_OF_CASE
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_studies_designed_manoeuvre, only: design_study_t
    use gracecg_cli_cases, only: case_place, amplitudes_of
    implicit none
    private
    public :: report_cases_table, manoeuvres_table

contains

    !> Where, when and with which settings of the models each case is. Fails when a case's models cannot be built.
    subroutine report_cases_table(calibrations, table, error)
        type(calibration_t), intent(in) :: calibrations(:)
        type(data_table_t), intent(out) :: table
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: latitude, longitude, height
        integer :: i

        call table%columns_of('case,epoch_utc,orbit_time_s,latitude_deg,longitude_deg,height_km,rod_x_a_m2,rod_y_a_m2,'// &
                              'rod_z_a_m2,offset_x_mm,offset_y_mm,offset_z_mm,gravity_model,gravity_degree,gravity_order,'// &
                              'density_model,density_scale,drag_coefficient,wind_model,wind_east_m_s,wind_north_m_s,'// &
                              'wave_random,wave_amplitude,wave_period_s,reflectivity_sun,specular,diffuse,earth_segments,'// &
                              'earth_constants,reflectivity_earth,field_model,strongest_rod_a_m2,accommodation,centre_x_mm,'// &
                              'centre_y_mm,centre_z_mm')
        do i = 1, size(calibrations)
            call case_place(calibrations(i)%case, latitude, longitude, height, error)
            if (allocated(error)) return
            associate (case => calibrations(i)%case, body => calibrations(i)%case%satellite, &
                       rings => calibrations(i)%case%earth_radiation_rings)
                call table%add(case%name)
                call table%add(utc_text(case%epoch))
                call table%add(TIME_OF_CASE(case%number))
                call table%add([latitude/DEGREE, longitude/DEGREE, height/1000])
                call table%add(amplitudes_of(body%rods))
                call table%add(body%offset/MILLIMETRE)
                call table%add(case%gravity_model)
                call table%add(case%gravity_degree)
                call table%add(case%gravity_order)
                call table%add(case%density_model)
                call table%add([case%density_scale, body%drag_coefficient])
                call table%add(case%wind_model)
                call table%add([case%wind_east, case%wind_north])
                call table%add(case%density_wave_random)
                call table%add([case%density_wave%amplitude, case%density_wave%period])
                call table%add([body%reflectivity_sun, body%specular, body%diffuse])
                call table%add(1 + 3*rings*(rings + 1))
                call table%add(case%earth_radiation_constants)
                call table%add(body%reflectivity_earth)
                call table%add(case%field_model)
                call table%add([maxval(abs(body%rods%activations%amplitude)), body%wall%accommodation])
                call table%add(body%centre_of_mass/MILLIMETRE)
            end associate
        end do
    end subroutine report_cases_table

    !> The designed manoeuvres, a row each activation of a rod.
    function manoeuvres_table(studies) result(table)
        type(design_study_t), intent(in) :: studies(:)
        type(data_table_t) :: table

        integer :: i, k

        call table%columns_of('satellite,rod,waveform,amplitude_a_m2,frequency_hz,phase_deg,start_s,stop_s')
        do i = 1, size(studies)
            do k = 1, studies(i)%design%rods%count
                associate (rod => studies(i)%design%rods%activations(k))
                    call table%add(studies(i)%calibration%case%satellite%name)
                    call table%add(AXES(rod%axis))
                    call table%add(WAVEFORM_NAMES(rod%waveform))
                    call table%add([rod%amplitude, rod%frequency, rod%phase/DEGREE, rod%start, rod%stop])
                end associate
            end do
        end do
    end function manoeuvres_table
end module gracecg_cli_report_tables
