!> gracecg level1 check: a day of Level-1 data in numbers that tell whether it was understood.
module gracecg_level1_command_check
    use gracecg_level1_check, only: level1_check_t, check_level1
    use gracecg_level1_folder, only: level1_folder_t, open_level1_folder
    use gracecg_level1_command_estimate, only: add_day_options, MOST_PLACES, PLACES_ARE
    use gracecg_cli_work
    implicit none
    private
    public :: declare_level1_check, run_level1_check

contains

    !> Arguments and help of `gracecg level1 check`.
    subroutine declare_level1_check(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('level1 check', 'PLACE ...', 1, MOST_PLACES, &
                                'Numbers of a day of Level-1 data that tell whether files, time and frames were understood: '// &
                                'sampling, means and noise of the accelerometer, tags of 1A against 1B, rates and noise of '// &
                                'the attitude, orbit in body axes, magnetometer against the IGRF, rod currents and their '// &
                                'gain, gyros, thrusters, gas. Each has a verdict: ok, or unusual for such data. '//PLACES_ARE, &
                                'gracecg level1 check day')
        call add_day_options(arguments)
        call add_format_option(arguments)
    end subroutine declare_level1_check

    !> The work of `gracecg level1 check`.
    subroutine run_level1_check(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(level1_folder_t) :: files
        type(level1_check_t) :: check
        type(data_table_t) :: table
        type(results_t) :: results
        character(:), allocatable :: satellite, day
        integer :: i, unusual

        call arguments%get('--satellite', satellite, misuse)
        call arguments%get('--day', day, misuse)
        call take_format(arguments, console, misuse)
        if (allocated(misuse)) return
        if (satellite == '') satellite = ' '
        call open_level1_folder(padded(arguments%words), satellite(1:1), files, error, day)
        if (.not. allocated(error)) call check_level1(files, check, error)
        if (allocated(error)) return
        call table%column('quantity', 'a', 'quantity')
        call table%column('value', 'es16.8', 'value')
        call table%column('unit', 'a', 'unit')
        call table%column('verdict', 'a', 'verdict')
        unusual = 0
        do i = 1, size(check%rows)
            call table%add(check%rows(i)%quantity)
            call table%add(check%rows(i)%value)
            call table%add(check%rows(i)%unit)
            if (check%rows(i)%is_usual()) then
                call table%add('ok')
            else
                call table%add('unusual')
                unusual = unusual + 1
            end if
        end do
        call console%warn_all(check%warnings)
        call console%line('satellite '//files%satellite//', '//files%date)
        call console%table(table)
        call console%line(integer_text(unusual)//' of '//integer_text(size(check%rows))//' numbers are unusual')
        call results%open('level1 check')
        call results%member('satellite', files%satellite)
        call results%member('date', files%date)
        call results%publish(table, console, error)
    end subroutine run_level1_check
end module gracecg_level1_command_check
