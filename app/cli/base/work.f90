!> What commands are written with: `use` of this module in place of a list of a dozen. It has nothing of its own.
module gracecg_cli_work
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: AXES, MILLIMETRE, DEGREE
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_text, only: string_t, integer_text, real_text, rounded_text, append, join, padded
    use gracecg_base_progress, only: tell
    use gracecg_files_data_table, only: data_table_t
    use gracecg_files_file, only: check_writable
    use gracecg_environment_time, only: utc_text, utc_plus
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t, add_format_option, take_format, axis_columns
    use gracecg_cli_calibration_argument, only: study_t, add_study_options, take_options, take_study, MOST_CASES
    implicit none
    private
    public :: dp, i8, AXES, MILLIMETRE, DEGREE, error_t, fail, add_context, string_t, integer_text, real_text, rounded_text, &
        append, join, padded, tell, data_table_t, check_writable, utc_text, utc_plus, calibration_t, arguments_t, refuse_if, &
        console_t, results_t, add_format_option, take_format, axis_columns, study_t, add_study_options, take_options, &
        take_study, MOST_CASES
end module gracecg_cli_work
