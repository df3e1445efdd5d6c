!> Cases by name: the report's, or a user's own in a namelist file.
module gracecg_simulation_case_library
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: join, lower_case
    use gracecg_files_file, only: file_exists
    use gracecg_files_value, only: did_you_mean
    use gracecg_simulation_case, only: case_t, read_case
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES
    implicit none
    private
    public :: find_case, is_built_in

contains

    !> The case of a name: a built-in one, else the one in the namelist file of that path. Fails
    !> when it is neither, and where `read_case` fails.
    subroutine find_case(name_or_path, case, error)
        character(*), intent(in) :: name_or_path    !! 'front-1' ... 'back-3', or a path
        type(case_t), intent(out) :: case
        type(error_t), allocatable, intent(out) :: error

        if (is_built_in(name_or_path)) then
            call report_case(lower_case(name_or_path), case, error)
        else if (file_exists(name_or_path)) then
            call read_case(name_or_path, case, error)
        else
            call fail(error, 'no case "'//trim(name_or_path)// &
                      '": it is neither a built-in case ('//join(REPORT_CASE_NAMES, ', ')// &
                      ') nor a namelist file'//did_you_mean(name_or_path, REPORT_CASE_NAMES))
        end if
    end subroutine find_case

    !> Is it the name of a built-in case?
    logical function is_built_in(name)
        character(*), intent(in) :: name    !! In whatever case

        is_built_in = any(REPORT_CASE_NAMES == lower_case(name))
    end function is_built_in
end module gracecg_simulation_case_library
