!> Cases by name: the report's, or a user's own in a namelist file.
module gracecg_simulation_case_library
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append, join, lower_case
    use gracecg_files_file, only: file_exists
    use gracecg_files_value, only: did_you_mean
    use gracecg_simulation_case, only: case_t, read_case
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES
    implicit none
    private
    public :: find_case, is_built_in, CASE_GROUPS, cases_of_group

    character(5), parameter :: CASE_GROUPS(3) = [character(5) :: 'front', 'back', 'all']
    !! Names for the report's cases of one satellite, and for all of them

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

    !> The names of the cases of a group, in their order; none for a name that is no group.
    function cases_of_group(group) result(names)
        character(*), intent(in) :: group       !! One of CASE_GROUPS
        type(string_t), allocatable :: names(:)

        integer :: i

        allocate (names(0))
        do i = 1, size(REPORT_CASE_NAMES)
            if (group == 'all' .or. index(REPORT_CASE_NAMES(i), group//'-') == 1) &
                call append(names, trim(REPORT_CASE_NAMES(i)))
        end do
    end function cases_of_group

    !> Is it the name of a built-in case?
    logical function is_built_in(name)
        character(*), intent(in) :: name    !! In whatever case

        is_built_in = any(REPORT_CASE_NAMES == lower_case(name))
    end function is_built_in
end module gracecg_simulation_case_library
