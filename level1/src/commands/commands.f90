!> The commands `gracecg level1 ...`.
module gracecg_level1_commands
    use gracecg_cli_command, only: command_t
    use gracecg_level1_command_files, only: declare_level1_list, run_level1_list, declare_level1_dump, &
        run_level1_dump, declare_level1_convert, run_level1_convert, declare_level1_check, run_level1_check
    use gracecg_level1_command_estimate, only: declare_level1_estimate, run_level1_estimate, declare_level1_prepare, &
        run_level1_prepare
    use gracecg_level1_command_simulate, only: declare_level1_simulate, run_level1_simulate
    use gracecg_level1_command_trend, only: declare_level1_trend, run_level1_trend
    implicit none
    private
    public :: level1_commands

contains

    !> All of them, in the order of the help.
    function level1_commands() result(commands)
        type(command_t), allocatable :: commands(:)

        commands = [ &
            command_t('level1 list', 'what Level-1 files of GRACE and GRACE-FO hold', &
                      declare_level1_list, run_level1_list), &
            command_t('level1 dump', 'the values of a Level-1 file, or their statistics, as CSV', &
                      declare_level1_dump, run_level1_dump), &
            command_t('level1 check', 'a day of Level-1 data in numbers, with a verdict each', &
                      declare_level1_check, run_level1_check), &
            command_t('level1 estimate', 'the CG offset from Level-1 files of a manoeuvre', &
                      declare_level1_estimate, run_level1_estimate), &
            command_t('level1 prepare', 'a span of Level-1 files as an observation set', &
                      declare_level1_prepare, run_level1_prepare), &
            command_t('level1 trend', 'offsets from Level-1 data over time', &
                      declare_level1_trend, run_level1_trend), &
            command_t('level1 simulate', 'a folder of Level-1 files of a manoeuvre, simulated', &
                      declare_level1_simulate, run_level1_simulate), &
            command_t('level1 convert', 'Level-1 text as binary, binary as text', &
                      declare_level1_convert, run_level1_convert)]
    end function level1_commands
end module gracecg_level1_commands
