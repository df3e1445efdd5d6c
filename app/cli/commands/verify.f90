!> gracecg verify: the verification of CSR-TM-00-01 section 5.3.
module gracecg_cli_verify
    use gracecg_base_text, only: share_text
    use gracecg_base_version, only: file_comments
    use gracecg_files_file, only: make_directory
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: published_name
    use gracecg_studies_curves, only: verification_t, verify_case, &
        check_windows, window_counts_t, count_windows, curves_table, curves_file_name, &
        begin_windows, add_window_rows, CURVE_NAMES, curve_column
    use gracecg_studies_published, only: built_in_case
    use gracecg_cli_calibration_argument, only: take_calibrations
    use gracecg_cli_campaign_tables, only: percent_text
    use gracecg_files_csv, only: unit_of_column
    use gracecg_cli_work
    implicit none
    private
    public :: declare_verify, run_verify

    character(*), parameter :: DEFAULT_CASES = 'front-1,back-1'
    integer, parameter :: CASE_WITH_WINDOWS = 1     !! Figures 5.2-5.8 show case 1 of each satellite

contains

    !> Arguments and help of `gracecg verify`.
    subroutine declare_verify(arguments)
        type(arguments_t), intent(inout) :: arguments

        call arguments%describe('verify', '[CASE ...]', 0, MOST_CASES, &
                                'Computes the curves of Figures 5.2-5.8 of CSR-TM-00-01 along '// &
                                'the arcs of the cases (front-1 and back-1 when none is '// &
                                'named). Case 1 of a satellite is compared with the axis '// &
                                'windows that the report prints: a curve is inside when it '// &
                                'leaves its window by at most 5 % of its width; `fill` is the share of the '// &
                                'window that it covers; `ticks` says whether it reaches into the first and the '// &
                                'last interval between the printed tick marks, as a curve does for which a '// &
                                'program chose the axis. A case file with other settings than the built-in case '// &
                                'is compared, too, and named as edited: that measures what the comparison can '// &
                                'see. The points of Figures 6.2, 6.3 and 6.6 are compared by `report`.', &
                                'gracecg verify front-1 back-1 --out curves')
        call add_study_options(arguments, '--cases')
        call arguments%add_option('--out', 'DIR', 'folder for the curves, verify_CASE.csv; made if it is not there')
        call add_study_options(arguments, '--format')
    end subroutine declare_verify

    !> The work of `gracecg verify`.
    subroutine run_verify(arguments, console, misuse, error)
        type(arguments_t), intent(in) :: arguments
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: misuse, error

        type(study_t) :: study
        type(verification_t) :: verification
        type(results_t) :: results
        type(data_table_t) :: table, curves
        character(:), allocatable :: path
        integer :: i

        call take_options(arguments, console, study, misuse, 1)
        if (allocated(misuse)) return
        call take_calibrations(arguments, DEFAULT_CASES, study%calibrations, misuse, error, may_rest=.true., &
                               console=console)
        if (allocated(misuse)) return
        if (.not. allocated(error) .and. study%path /= '') call make_directory(study%path, error)
        if (allocated(error)) return
        call begin_windows(table, .true.)
        do i = 1, size(study%calibrations)
            associate (case => study%calibrations(i)%case)
                call tell(console, 'verify: '//trim(case%name))
                call verify_case(case, verification, error)
                if (allocated(error)) return
                call add_rows(case, verification, table)
                if (i > 1) call console%line('')
                call show(case, verification, console)
                if (study%path == '') cycle
                path = study%path//'/'//curves_file_name(case%name)
                curves = curves_table(verification)
                call curves%write(path, file_comments('verify', 'case '//trim(case%name)//'; body axes'), error)
                if (allocated(error)) return
                call console%line('written: '//path)
            end associate
        end do
        call results%open('verify')
        call results%publish(table, console, error)
    end subroutine run_verify

    !> The curves of a case as rows, with the windows of case 1.
    subroutine add_rows(case, verification, table)
        type(case_t), intent(in) :: case
        type(verification_t), intent(in) :: verification
        type(data_table_t), intent(inout) :: table

        integer, parameter :: OF_WINDOWS = 10       ! Columns that other cases leave empty
        integer :: curve, axis

        if (case%number == CASE_WITH_WINDOWS) then
            call add_window_rows(case%name, check_windows(trim(case%satellite%name), verification), table)
            return
        end if
        do curve = 1, size(CURVE_NAMES)
            do axis = 1, size(AXES)
                call table%add(case%name, CURVE_NAMES(curve), AXES(axis), &
                               unit_of_column(trim(curve_column(CURVE_NAMES(curve), AXES(axis)))))
                associate (values => verification%curve(axis, curve, :))
                    call table%add([minval(values), maxval(values), sum(values)/size(values)])
                end associate
                call table%add_nothing(OF_WINDOWS)
            end do
        end do
    end subroutine add_rows

    !> The curves of a case; of case 1 how they meet the windows.
    subroutine show(case, verification, console)
        type(case_t), intent(in) :: case
        type(verification_t), intent(in) :: verification
        type(console_t), intent(inout) :: console

        type(data_table_t) :: table
        type(window_counts_t) :: counts
        character(:), allocatable :: reference
        character(16) :: published

        reference = trim(case%satellite%name)//'-'//integer_text(CASE_WITH_WINDOWS)
        call built_in_case(case, published)
        if (case%number /= CASE_WITH_WINDOWS) then
            call console%line(trim(case%name)//': curves, SI units, body axes')
        else if (published_name(published) == reference) then
            call console%line(trim(case%name)//': curves and the printed axis windows, SI units, body axes')
        else
            call console%line(trim(case%name)//', edited: not the case of the report')
            call console%line('Its curves and the axis windows printed for '//reference//', SI units, body axes')
        end if
        call begin_windows(table, case%number == CASE_WITH_WINDOWS)
        call add_rows(case, verification, table)
        call console%table(table)
        if (case%number /= CASE_WITH_WINDOWS) return
        counts = count_windows(check_windows(trim(case%satellite%name), verification))
        call console%line('attitude dynamics alone: '//share_text(counts%attitude_inside, counts%attitude)// &
                          ' inside, '//integer_text(counts%attitude_on_ticks)//' on the ticks; least fill '// &
                          percent_text(counts%attitude_fill))
        call console%line('surface forces and torques: '//share_text(counts%surface_inside, counts%surface)// &
                          ' inside, '//integer_text(counts%surface_on_ticks)//' on the ticks')
        call console%line('surface forces and torques, mean within 15 % of the window''s centre: '// &
                          share_text(counts%surface_near, counts%surface))
    end subroutine show
end module gracecg_cli_verify
