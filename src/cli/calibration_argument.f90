!> A CASE on the command line: what is simulated, and how it is estimated.
module gracecg_cli_calibration_argument
    use gracecg_base_error, only: error_t, add_context
    use gracecg_spacecraft_torque_rods, only: check_rods_fire
    use gracecg_estimation_options, only: read_options
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_cli_arguments, only: arguments_t
    use gracecg_cli_console, only: console_t
    implicit none
    private
    public :: add_options_option, take_calibration, take_firing_calibration

contains

    !> The option --options FILE, of commands that take a CASE.
    subroutine add_options_option(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%add_option('--options', 'FILE', 'namelist file that says how to estimate, instead of the '// &
                                  'groups &estimation, &optimal and &sequential of the case file')
    end subroutine add_options_option

    !> The calibration of a name or path, with the options of --options if the command has it. Says on
    !> standard error what a file of version 0.1 has at another place.
    subroutine take_calibration(arguments, name, console, calibration, error)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: name            !! A built-in case or a case file
        type(console_t), intent(inout) :: console
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: path

        call find_calibration(name, calibration, error)
        if (allocated(error)) return
        if (allocated(calibration%warning)) call console%warn(calibration%warning%text)
        if (.not. arguments%has('--options')) return
        call arguments%get('--options', path, error)
        if (.not. allocated(error)) call read_options(path, calibration%options, error)
    end subroutine take_calibration

    !> The same for who estimates: fails, too, when all torque rods of the case are off.
    subroutine take_firing_calibration(arguments, name, console, calibration, error)
        type(arguments_t), intent(in) :: arguments
        character(*), intent(in) :: name            !! As of take_calibration
        type(console_t), intent(inout) :: console
        type(calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error

        call take_calibration(arguments, name, console, calibration, error)
        if (allocated(error)) return
        associate (case => calibration%case)
            call check_rods_fire(case%satellite%rods, case%duration, error)
            call add_context(error, 'case '//trim(case%name))
        end associate
    end subroutine take_firing_calibration
end module gracecg_cli_calibration_argument
