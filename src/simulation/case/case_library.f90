!> Cases by name: the report's, or a user's own in a namelist file.
module gracecg_simulation_case_library
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append, join, lower_case
    use gracecg_files_file, only: file_exists, directory_exists
    use gracecg_files_value, only: did_you_mean
    use gracecg_simulation_case, only: case_t, read_case
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES, PRINTED_CASE_NAMES
    implicit none
    private
    public :: find_case, is_built_in, expanded_cases, CASE_GROUPS

    !> Names for several built-in cases: the report's of one satellite, all six of them, and the six with the input
    !> cards as printed
    character(7), parameter :: CASE_GROUPS(4) = [character(7) :: 'front', 'back', 'all', 'printed']

contains

    !> The case of a name: a built-in one, else the one in the namelist file of that path. Fails
    !> when it is neither, and where `read_case` fails.
    subroutine find_case(name_or_path, case, error)
        character(*), intent(in) :: name_or_path    !! 'front-1' ... 'back-3-printed', or a path
        type(case_t), intent(out) :: case
        type(error_t), allocatable, intent(out) :: error

        if (is_built_in(name_or_path)) then
            call report_case(lower_case(name_or_path), case, error)
        else if (file_exists(name_or_path)) then
            call read_case(name_or_path, case, error)
        else if (directory_exists(name_or_path)) then
            call fail(error, trim(name_or_path)//': is a folder, not a case file')
        else
            call fail(error, 'no case "'//trim(name_or_path)// &
                      '": it is neither a built-in case ('//join(REPORT_CASE_NAMES, ', ')// &
                      ', or one of these with -printed behind it) nor a namelist file'// &
                      did_you_mean(name_or_path, [character(15) :: REPORT_CASE_NAMES, PRINTED_CASE_NAMES]))
        end if
    end subroutine find_case

    !> Is it the name of a built-in case?
    logical function is_built_in(name)
        character(*), intent(in) :: name    !! In whatever case

        is_built_in = any(REPORT_CASE_NAMES == lower_case(name)) .or. any(PRINTED_CASE_NAMES == lower_case(name))
    end function is_built_in

    !> A list of cases in which each of CASE_GROUPS, unless it is a file, has given way to the names it stands for.
    subroutine expanded_cases(names, expanded)
        type(string_t), intent(in) :: names(:)                  !! Names and paths
        type(string_t), allocatable, intent(out) :: expanded(:) !! At least as many

        integer :: i

        allocate (expanded(0))
        do i = 1, size(names)
            if (any(CASE_GROUPS == lower_case(names(i)%text)) .and. .not. file_exists(names(i)%text)) then
                call append_group(lower_case(names(i)%text), expanded)
            else
                call append(expanded, names(i)%text)
            end if
        end do
    end subroutine expanded_cases

    subroutine append_group(group, names)
        character(*), intent(in) :: group       !! One of CASE_GROUPS
        type(string_t), allocatable, intent(inout) :: names(:)

        integer :: i

        do i = 1, size(REPORT_CASE_NAMES)
            if (group == 'printed') then
                call append(names, trim(PRINTED_CASE_NAMES(i)))
            else if (group == 'all' .or. index(REPORT_CASE_NAMES(i), group//'-') == 1) then
                call append(names, trim(REPORT_CASE_NAMES(i)))
            end if
        end do
    end subroutine append_group
end module gracecg_simulation_case_library
