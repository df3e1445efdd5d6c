!> gracecg report: the numbers that the page is made of (test/fixtures/page_maker.sh stands for Python).
!> tools/check_report.py looks at the page.
module test_report
    use vocabulary
    use gracecg_base_text, only: real_text, share_text, pick_text
    use gracecg_files_file, only: file_exists, make_directory, remove_file
    use gracecg_studies_table_report_rms, only: RMS_VALUES
    use gracecg_cli_campaign_tables, only: percent_text
    use command_fixture
    implicit none
    private
    public :: collect_report

contains

    subroutine collect_report(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('numbers-as-text', test_numbers), &
                    new_unittest('wrong-usage', test_wrong_usage), &
                    new_unittest('stopped', test_stopped), &
                    new_unittest('tables', test_tables)]
    end subroutine collect_report

    subroutine test_numbers(error)
        type(error_type), allocatable, intent(out) :: error

        call same(percent_text(0.184_dp), '18.4 %')
        call same(share_text(69, 72), '69 of 72')
        call same(pick_text(.true., 'yes', 'no'), 'yes')
        call same(pick_text(.false., 'yes', 'no'), 'no')

    contains

        subroutine same(found, expected)
            character(*), intent(in) :: found, expected

            call check(error, found == expected .and. len(found) == len(expected), found//' is not '//expected)
        end subroutine same
    end subroutine test_numbers

    subroutine test_wrong_usage(error)
        type(error_type), allocatable, intent(out) :: error

        call make_file('in-the-way', 'a file')
        call refused(error, 'report', STATUS_MISUSED, '--out')
        call refused(error, 'report --out '//FOLDER//'page --runs 14', STATUS_MISUSED, '--runs')
        call refused(error, 'report --out '//FOLDER//'page --threads 0', STATUS_MISUSED, '--threads')
        call refused(error, 'report --out '//FOLDER//'in-the-way', STATUS_FAILED, 'a file of that name is in the way')
        call refused(error, 'report --out /proc/gracecg', STATUS_FAILED, '/proc/gracecg')
        call check(error, .not. file_exists(FOLDER//'page/index.html'))
    end subroutine test_wrong_usage

    !> A report that fails on its way leaves no page and no result.json of an earlier one beside its new tables.
    subroutine test_stopped(error)
        type(error_type), allocatable, intent(out) :: error
        character(*), parameter :: PATH = FOLDER//'stopped-report/'
        character(:), allocatable :: output, messages
        type(error_t), allocatable :: failure
        integer :: status

        call make_directory(PATH//'com_budget.csv', failure)        ! in the way of the second table
        call check_passes(error, failure)
        call make_file('stopped-report/index.html', 'a page of before')
        call make_file('stopped-report/result.json', '{}')
        call run('report --runs 15 --out '//FOLDER//'stopped-report', status, output, messages)
        call check(error, status, STATUS_FAILED, messages)
        call check_says(error, messages, 'com_budget.csv')
        call check(error, file_exists(PATH//'cases.csv') .and. .not. file_exists(PATH//'index.html') .and. &
                   .not. file_exists(PATH//'result.json'))
    end subroutine test_stopped

    !> A table of numbers for each study, as CSV files with their columns; result.json names them. Published values stand in
    !> montecarlo.csv, the misprint mended.
    subroutine test_tables(error)
        type(error_type), allocatable, intent(out) :: error
        character(96), parameter :: FILES(2, 22) = reshape([character(96) :: &
            'cases.csv', 'case,epoch_utc,orbit_time_s,latitude_deg,longitude_deg,height_km,rod_x_a_m2', &
            'com_budget.csv', 'table,effect,dx_mm,dy_mm,dz_mm', &
            'printed_axes.csv', 'figure,satellite,panel,axis,low,high,step', &
            'revolutions.csv', 'satellite,step_s,strongest_field_nt,largest_acceleration_rad_s2,x_strongest,x_weakest_s', &
            'windows.csv', 'case,quantity,axis,unit,least,greatest,mean,figure,low,high,fill,inside,on_ticks', &
            'estimate_windows.csv', 'figure,satellite,algorithm,axis,low_mm,high_mm,least_mm,greatest_mm,fill,points,inside', &
            'montecarlo.csv', 'case,algorithm,axis,runs,rms_mm,mean_error_mm,std_mm,predicted_mm,published_mm', &
            'montecarlo_first_runs.csv', 'case,algorithm,axis,runs,rms_mm,mean_error_mm,std_mm,predicted_mm,published_mm', &
            'montecarlo_runs.csv', 'case,algorithm,run,dx_mm,dy_mm,dz_mm,converged,normalised', &
            'errors.csv', 'source,axis,runs,rms_mm', &
            'magnetometer_loss.csv', 'case,algorithm,magnetometer,axis,runs,rms_mm', &
            'magnetometer_loss_runs.csv', 'case,algorithm,magnetometer,run,dx_mm,dy_mm,dz_mm', &
            'gravity_gradient.csv', 'time_s,central_r_m_s2,central_t_m_s2,central_n_m_s2,others_r_m_s2,others_t_m_s2', &
            'verify_front-1.csv', 'time_s,drag_x_m_s2,drag_y_m_s2,drag_z_m_s2,srp_x_m_s2', &
            'verify_back-1.csv', 'time_s,drag_x_m_s2,drag_y_m_s2,drag_z_m_s2,srp_x_m_s2', &
            'timing_back.csv', 'time_s,utc,latitude_deg,longitude_deg,bx_nt,by_nt,bz_nt,alpha_x_rad_s2', &
            'places_front.csv', 'place,time_s,utc,latitude_deg,longitude_deg,bx_nt,by_nt,bz_nt,alpha_x_rad_s2', &
            'statements.csv', 'statement,case,setting,runs,rms_x_mm,rms_y_mm,rms_z_mm,predicted_x_mm', &
            'bound.csv', 'case,algorithm,axis,runs,rms_mm,bound_mm,ratio,sampling_error,at_the_bound,not_converged', &
            'design.csv', 'case,axis,bound_mm,runs,rms_mm,rms_after_trim_mm', &
            'designed_manoeuvres.csv', 'satellite,rod,waveform,amplitude_a_m2,frequency_hz,phase_deg,start_s,stop_s', &
            'manoeuvre_map_back.csv', 'time_s,latitude_deg,longitude_deg,report_x_mm'], [2, 22])
        character(:), allocatable :: output, messages, path, page, file
        real(dp) :: value
        integer :: status, i

        path = FOLDER//'report/'
        call remove_file(path//'index.html')
        call run('report --out '//FOLDER//'report --runs 15', status, output, messages)
        call check(error, status == STATUS_DONE .and. index(messages, 'warning') == 0, messages)   ! but lines of progress
        call read_content(error, path//'index.html', page)      ! which is result.json here
        call check_says(error, page, '"allowed": 71')
        do i = 1, size(FILES, 2)
            call read_content(error, path//trim(FILES(1, i)), file)
            call check(error, index(file, trim(FILES(2, i))) == 1 .and. &
                                                   index(page, '"'//trim(FILES(1, i))//'"') > 0, trim(FILES(1, i)))
        end do
        call read_content(error, path//'montecarlo.csv', file)
        do i = 1, size(RMS_VALUES)
            value = RMS_VALUES(i)
            if (abs(value - 0.01112_dp) < 1e-9_dp) value = 0.1112_dp
            call check(error, index(file, ','//real_text(value)//new_line('a')) > 0, 'published value '//real_text(value))
        end do
    end subroutine test_tables
end module test_report
