!> Cases by name: the report's, or a user's own in a namelist file.
module gracecg_simulation_case_library
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: join, lower_case, string_t, append
    use gracecg_files_file, only: file_exists
    use gracecg_files_value, only: did_you_mean
    use gracecg_simulation_case, only: case_t, read_case
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES, PRINTED_CASE_NAMES
    implicit none
    private
    public :: find_case, is_built_in, expanded_cases, PRINTED_SET

    !> Stands for the six PRINTED_CASE_NAMES in a list of cases
    character(*), parameter :: PRINTED_SET = 'printed'

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

    !> A list of cases in which PRINTED_SET, unless it is a file, has given way to the six names it stands for.
    subroutine expanded_cases(names, expanded)
        type(string_t), intent(in) :: names(:)                  !! Names and paths
        type(string_t), allocatable, intent(out) :: expanded(:) !! At least as many

        integer :: i, k

        allocate (expanded(0))
        do i = 1, size(names)
            if (lower_case(names(i)%text) /= PRINTED_SET .or. file_exists(names(i)%text)) then
                call append(expanded, names(i)%text)
                cycle
            end if
            do k = 1, size(PRINTED_CASE_NAMES)
                call append(expanded, PRINTED_CASE_NAMES(k))
            end do
        end do
    end subroutine expanded_cases
end module gracecg_simulation_case_library
