!> Whether a case is one of the report's: by all its settings, not by its name. What CSR-TM-00-01 publishes judges
!> those alone; an edited case that kept the name has nothing published.
module gracecg_studies_published_case
    use gracecg_base_kinds, only: i8
    use gracecg_base_error, only: error_t
    use gracecg_simulation_case, only: case_t, case_text
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES, PRINTED_CASE_NAMES
    use gracecg_planning_calibration, only: calibration_t, find_calibration, calibration_text
    implicit none
    private
    public :: built_in_case, built_in_calibration, settings_checksum

    !> The cases that are the report's: as they are built in, and with the cards as printed
    character(15), parameter :: CASES(12) = [character(15) :: REPORT_CASE_NAMES, PRINTED_CASE_NAMES]

contains

    !> The name of the built-in case that has every setting of a case but its name; empty when there is none.
    subroutine built_in_case(case, name)
        type(case_t), intent(in) :: case
        character(*), intent(out) :: name           !! 'front-1' ... 'back-3-printed', or empty

        type(case_t) :: candidate
        character(:), allocatable :: text, other
        type(error_t), allocatable :: error
        integer :: i

        name = ''
        call case_text(case, text, error)
        do i = 1, size(CASES)
            if (.not. allocated(error)) call report_case(trim(CASES(i)), candidate, error)
            candidate%name = case%name
            if (.not. allocated(error)) call case_text(candidate, other, error)
            if (allocated(error)) return            ! a setting that is not finite is none of the report's
            if (text /= other) cycle
            name = CASES(i)
            return
        end do
    end subroutine built_in_case

    !> The same of a calibration, case and options, that is known by name and checksum.
    subroutine built_in_calibration(calibration_name, checksum, name)
        character(*), intent(in) :: calibration_name    !! Its name, which the checksum contains
        integer, intent(in) :: checksum                 !! Of `settings_checksum`
        character(*), intent(out) :: name               !! As of `built_in_case`

        type(calibration_t) :: candidate
        type(error_t), allocatable :: error
        integer :: i, other

        name = ''
        do i = 1, size(CASES)
            call find_calibration(trim(CASES(i)), candidate, error)
            if (allocated(error)) return
            candidate%case%name = calibration_name
            call settings_checksum(candidate, other, error)
            if (allocated(error)) return
            if (other /= checksum) cycle
            name = CASES(i)
            return
        end do
    end subroutine built_in_calibration

    !> A number of all settings of a calibration, its name among them, which differs from that of other settings
    !> but for one chance in two thousand million. Fails when a setting is not finite.
    subroutine settings_checksum(calibration, checksum, error)
        type(calibration_t), intent(in) :: calibration
        integer, intent(out) :: checksum            !! From 0 to 2147483646
        type(error_t), allocatable, intent(out) :: error

        integer(i8), parameter :: PRIME = 2147483647_i8, FACTOR = 48271_i8
        character(:), allocatable :: text
        integer(i8) :: total
        integer :: i

        checksum = 0
        call calibration_text(calibration, text, error)
        if (allocated(error)) return
        total = 1
        do i = 1, len(text)
            total = mod(total*FACTOR + iachar(text(i:i)), PRIME)
        end do
        checksum = int(total)
    end subroutine settings_checksum
end module gracecg_studies_published_case
