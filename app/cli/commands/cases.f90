!> gracecg cases: lists the built-in cases, or shows a case as a namelist.
module gracecg_cli_cases
    use gracecg_files_value, only: did_you_mean
    use gracecg_environment_earth_shape, only: earth_fixed_to_geodetic
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    use gracecg_simulation_dynamics, only: satellite_dynamics_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_case_models, only: build_dynamics
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES
    use gracecg_planning_calibration, only: find_calibration, calibration_text
    use gracecg_cli_work
    implicit none
    private
    public :: declare_cases, run_cases, case_place, amplitudes_of

contains

    !> Arguments and help of `gracecg cases`.
    subroutine declare_cases(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('cases', '[show CASE]', 0, 2, &
                                'Lists the built-in cases, those of CSR-TM-00-01 sections 5.2 '// &
                                'and 6.1. front-1-printed ... back-3-printed are the same with '// &
                                'the input cards of section 5.2 as printed, where the built-in '// &
                                'cases have constants that were fitted to its figures. '// &
                                '`cases show CASE` prints one as a namelist file, '// &
                                'which can be edited and stands wherever a CASE is asked for.', &
                                'gracecg cases show front-1 > my-case.nml'//new_line('a')// &
                                'gracecg simulate my-case.nml --out run1')
        call add_format_option(arguments)
    end subroutine declare_cases

    !> The work of `gracecg cases`.
    subroutine run_cases(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(calibration_t) :: calibration
        character(:), allocatable :: text

        if (arguments%positional_count() == 0) call take_format(arguments, console, misuse)
        if (allocated(misuse)) then
            return
        else if (arguments%positional_count() == 0) then
            call list_cases(console, error)
        else if (arguments%positional(1) /= 'show') then
            call fail(misuse, 'unknown word "'//arguments%positional(1)//'"'// &
                      did_you_mean(arguments%positional(1), ['show'])//new_line('a')// &
                      'usage: gracecg cases [show CASE]')
        else if (arguments%positional_count() == 1) then
            call fail(misuse, 'which case? usage: gracecg cases show CASE')
        else
            call find_calibration(arguments%positional(2), calibration, error)
            if (.not. allocated(error)) call calibration_text(calibration, text, error)
            if (.not. allocated(error)) call console%line(text)
        end if
    end subroutine run_cases

    subroutine list_cases(console, error)
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(case_t) :: case
        type(data_table_t) :: table
        type(results_t) :: results
        real(dp) :: latitude, longitude, height
        integer :: i

        call table%column('case', 'a', 'case')
        call table%column('satellite', 'a', 'satellite')
        call table%column('epoch_utc', 'a', 'epoch (UTC)')
        call table%column('latitude_deg', 'f8.1', 'latitude|deg')
        call table%column('longitude_deg', 'f8.1', 'longitude|deg')
        call table%column('height_km', 'f8.1', 'height|km')
        call table%column('rod_x_a_m2', 'i6', 'rods, A m^2|x')
        call table%column('rod_y_a_m2', 'i6', '|y')
        call table%column('rod_z_a_m2', 'i6', '|z')
        do i = 1, size(REPORT_CASE_NAMES)
            call report_case(REPORT_CASE_NAMES(i), case, error)
            if (.not. allocated(error)) call case_place(case, latitude, longitude, height, error)
            if (allocated(error)) return
            call table%add(case%name, case%satellite%name, utc_text(case%epoch))
            call table%add([latitude/DEGREE, longitude/DEGREE, height/1000, amplitudes_of(case%satellite%rods)])
        end do
        call console%table(table)
        call results%open('cases')
        call console%paragraph('NAME-printed: the same with the input cards of section 5.2 as printed, and nothing '// &
                          'fitted to density and wind')
        call results%publish(table, console, error)
    end subroutine list_cases

    !> Where the satellite stands at the epoch of a case. Fails when its models cannot be built.
    subroutine case_place(case, latitude, longitude, height, error)
        type(case_t), intent(in) :: case
        real(dp), intent(out) :: latitude, longitude    !! Geodetic, longitude positive east, rad
        real(dp), intent(out) :: height                 !! Above the ellipsoid, m
        type(error_t), allocatable, intent(out) :: error

        type(satellite_dynamics_t) :: dynamics

        latitude = 0
        longitude = 0
        height = 0
        call build_dynamics(case, dynamics, error)
        if (allocated(error)) return
        call earth_fixed_to_geodetic(matmul(dynamics%earth%from_inertial(0.0_dp), case%position), &
                                     latitude, longitude, height)
    end subroutine case_place

    !> The amplitudes of the rods along x, y, z.
    pure function amplitudes_of(rods) result(amplitude)
        type(torque_rods_t), intent(in) :: rods
        real(dp) :: amplitude(3)        !! A m^2

        integer :: i

        amplitude = 0
        do i = 1, rods%count
            amplitude(rods%activations(i)%axis) = amplitude(rods%activations(i)%axis) + rods%activations(i)%amplitude
        end do
    end function amplitudes_of
end module gracecg_cli_cases
