!> gracecg report: what the page is made of, its tables and files (test/fixtures/page_maker.sh stands for Python).
!> tools/check_report.py looks at the page.
module test_report
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, message_of
    use gracecg_base_text, only: split_words
    use gracecg_files_file, only: text_file_t, read_text_file, file_exists, remove_file
    use gracecg_studies_table_report_rms, only: RMS_VALUES
    use gracecg_cli_console, only: console_t
    use gracecg_cli_command_line, only: run_command_line, STATUS_DONE, STATUS_FAILED, STATUS_MISUSED
    use gracecg_cli_number_text, only: fixed_text, scaled_text, decimal_exponent, percent_text, share_text, pick_text
    use testdrive, only: new_unittest, unittest_type, error_type, check
    use fixture, only: FOLDER, make_folder, make_file, check_passes
    implicit none
    private
    public :: collect_report

contains

    subroutine collect_report(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('numbers-as-text', test_numbers), &
                    new_unittest('wrong-usage', test_wrong_usage), &
                    new_unittest('blocks-and-files', test_blocks)]
    end subroutine collect_report

    subroutine run(line, status, output, messages)
        character(*), intent(in) :: line
        integer, intent(out) :: status
        character(:), allocatable, intent(out) :: output, messages

        type(console_t) :: console

        console%captured = .true.
        call run_command_line(split_words(line), console, status)
        output = ''
        messages = ''
        if (allocated(console%output)) output = console%output
        if (allocated(console%messages)) messages = console%messages
    end subroutine run

    subroutine test_numbers(error)
        type(error_type), allocatable, intent(out) :: error

        call same(fixed_text(0.5_dp, 3), '0.500')
        call same(fixed_text(-0.25_dp, 2), '-0.25')
        call same(fixed_text(-1e-9_dp, 2), '0.00')
        call same(fixed_text(-12.4_dp, 0), '-12')
        call same(fixed_text(0.4_dp, 0), '0')
        call same(scaled_text(6.43e-7_dp, -7, 1), '6.4')
        call same(percent_text(0.184_dp), '18.4 %')
        call same(share_text(69, 72), '69 of 72')
        call same(pick_text(.true., 'yes', 'no'), 'yes')
        call same(pick_text(.false., 'yes', 'no'), 'no')
        if (allocated(error)) return
        call check(error, all([decimal_exponent(1e-7_dp), decimal_exponent(9.99e-8_dp), decimal_exponent(-3.0_dp), &
                               decimal_exponent(0.0_dp)] == [-7, -8, 0, 0]))

    contains

        subroutine same(found, expected)
            character(*), intent(in) :: found, expected

            if (allocated(error)) return
            call check(error, found == expected .and. len(found) == len(expected), found//' is not '//expected)
        end subroutine same
    end subroutine test_numbers

    subroutine test_wrong_usage(error)
        type(error_type), allocatable, intent(out) :: error

        call make_file(error, 'in-the-way', 'a file')
        call refused('report', STATUS_MISUSED, '--out')
        call refused('report --out '//FOLDER//'page --runs 14', STATUS_MISUSED, '--runs')
        call refused('report --out '//FOLDER//'page --threads 0', STATUS_MISUSED, '--threads')
        call refused('report --out '//FOLDER//'in-the-way', STATUS_FAILED, 'a file of that name is in the way')
        call refused('report --out /proc/gracecg', STATUS_FAILED, '/proc/gracecg')
        if (allocated(error)) return
        call check(error,.not. file_exists(FOLDER//'page/index.html'))

    contains

        subroutine refused(line, expected, part)
            character(*), intent(in) :: line, part
            integer, intent(in) :: expected

            character(:), allocatable :: output, messages
            integer :: status

            if (allocated(error)) return
            call run(line, status, output, messages)
            call check(error, status, expected, line//': '//messages)
            if (.not. allocated(error)) call check(error, index(messages, part) > 0, messages)
        end subroutine refused
    end subroutine test_wrong_usage

    !> Every table and every figure has its place; all published values; CSV files with their columns.
    subroutine test_blocks(error)
        type(error_type), allocatable, intent(out) :: error
        character(20), parameter :: IDS(37) = [character(20) :: &
            'findings', 'cases', 'table_1_1', 'table_1_2', 'figure_3_1', 'figure_5_2', 'figure_5_3', 'figure_5_4', &
            'figure_5_5', 'figure_5_6', 'figure_5_7', 'figure_5_8', 'figure_5_2_numbers', 'figure_5_3_numbers', &
            'figure_5_4_numbers', 'figure_5_5_numbers', 'figure_5_6_numbers', 'figure_5_7_numbers', &
            'figure_5_8_numbers', 'figure_6_1', 'figure_6_2', 'figure_6_3', 'figure_6_4', 'figure_6_5', 'figure_6_6', &
            'table_6_1', 'table_6_2', 'error_sources', 'magnetometer_loss', &
            'statement_one-rod', 'statement_two-steps', 'statement_stars', 'figure_bound', 'bound_table', &
            'figure_manoeuvre_map', 'designed_manoeuvres', 'designed_reached']
        character(96), parameter :: FILES(2, 13) = reshape([character(96) :: &
            'montecarlo.csv', 'case,algorithm,axis,runs,rms_mm,mean_error_mm,std_mm,predicted_mm,published_mm', &
            'montecarlo_runs.csv', 'case,algorithm,run,dx_mm,dy_mm,dz_mm,converged', &
            'errors.csv', 'source,axis,runs,rms_mm', &
            'magnetometer_loss.csv', 'case,algorithm,magnetometer,axis,runs,rms_mm', &
            'magnetometer_loss_runs.csv', 'case,algorithm,magnetometer,run,dx_mm,dy_mm,dz_mm', &
            'gravity_gradient.csv', 'time_s,central_r_m_s2,central_t_m_s2,central_n_m_s2,others_r_m_s2,others_t_m_s2', &
            'verify_front-1.csv', 'time_s,drag_x_m_s2,drag_y_m_s2,drag_z_m_s2,srp_x_m_s2', &
            'verify_back-1.csv', 'time_s,drag_x_m_s2,drag_y_m_s2,drag_z_m_s2,srp_x_m_s2', &
            'timing_back.csv', 'time_s,utc,latitude_deg,longitude_deg,bx_nt,by_nt,bz_nt,alpha_x_rad_s2', &
            'statements.csv', 'statement,case,setting,runs,rms_x_mm,rms_y_mm,rms_z_mm,predicted_x_mm', &
            'bound.csv', 'case,algorithm,axis,runs,rms_mm,bound_mm,ratio,sampling_error', &
            'design.csv', 'case,axis,bound_mm,runs,rms_mm,rms_after_trim_mm', &
            'manoeuvre_map_back.csv', 'time_s,latitude_deg,longitude_deg,report_x_mm'], [2, 13])
        character(:), allocatable :: output, messages, path
        type(text_file_t) :: page, file
        type(error_t), allocatable :: failure
        real(dp) :: value
        integer :: status, i

        call make_folder(error)
        if (allocated(error)) return
        path = FOLDER//'report/'
        call remove_file(path//'index.html')
        call run('report --out '//FOLDER//'report --runs 15', status, output, messages)
        call check(error, status == STATUS_DONE .and. messages == '', messages)
        if (.not. allocated(error)) call check(error, index(output, '71 of 72') > 0, output)
        if (allocated(error)) return

        call read_text_file(path//'index.html', page, failure)
        call check_passes(error, message_of(failure))
        do i = 1, size(IDS)
            if (allocated(error)) return
            call check(error, index(page%text, '"id":"'//trim(IDS(i))//'"') > 0, trim(IDS(i)))
        end do
        do i = 1, size(RMS_VALUES)
            if (allocated(error)) return
            value = RMS_VALUES(i)
            if (abs(value - 0.01112_dp) < 1e-9_dp) value = 0.1112_dp
            call check(error, index(page%text, '","number":"'//fixed_text(value, 5)//'"}') > 0, &
                       'published value '//fixed_text(value, 5))
        end do
        do i = 1, size(FILES, 2)
            if (allocated(error)) return
            call read_text_file(path//trim(FILES(1, i)), file, failure)
            call check_passes(error, message_of(failure))
            if (.not. allocated(error)) call check(error, index(file%text, trim(FILES(2, i))) == 1, &
                                                   trim(FILES(1, i)))
        end do
        if (.not. allocated(error)) call check(error, file_exists(path//'result.json'))
    end subroutine test_blocks
end module test_report
