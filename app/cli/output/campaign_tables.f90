!> What montecarlo and merge print of a campaign: Tables 6.1 and 6.2 of CSR-TM-00-01, ours and theory beside them.
module gracecg_cli_campaign_tables
    use gracecg_base_statistics, only: sampling_error
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_studies_campaign, only: campaign_t, campaign_agreement_t, agreement_of
    use gracecg_studies_campaign_files, only: campaign_table, write_table, write_runs
    use gracecg_cli_work
    implicit none
    private
    public :: show_campaign, publish_campaign, put_agreement, read_campaign_files, percent_text, REPORT_RUNS

    integer, parameter :: REPORT_RUNS = 15          !! Of every entry of the published tables

contains

    !> The files for the results, --out and --runs-out; empty where there shall be none.
    subroutine read_campaign_files(arguments, table_file, runs_file, misuse)
        type(arguments_t), intent(in) :: arguments
        character(:), allocatable, intent(out) :: table_file, runs_file !! As given; empty when not
        type(error_t), allocatable, intent(inout) :: misuse

        call arguments%get('--out', table_file, misuse)
        call arguments%get('--runs-out', runs_file, misuse)
        call refuse_if(table_file /= '' .and. table_file == runs_file, &
                       'options --out and --runs-out name the same file, '//table_file, misuse)
    end subroutine read_campaign_files

    !> RMS by case, algorithm and axis: ours, of theory and of the report; then how they agree.
    subroutine show_campaign(campaign, console)
        type(campaign_t), intent(in) :: campaign
        type(console_t), intent(inout) :: console

        integer :: a, i, most

        most = 0
        call show_first(campaign, console)
        call console%paragraph('RMS error of the CG offset, mm: here, by theory, and in CSR-TM-00-01 (Tables 6.1 and 6.2, '// &
                               integer_text(REPORT_RUNS)//' runs)')
        call console%table(campaign_table(campaign))
        if (size(campaign%algorithms) > 1) &
            call console%paragraph('(here all algorithms work on the same observations; in the report each had its own)')
        do i = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                associate (entry => campaign%entries(a, i))
                    most = max(most, size(entry%run))
                    if (entry%mean_normalised > 0) &
                        call console%paragraph(trim(campaign%cases(i)%name)//', '//trim(campaign%algorithms(a))// &
                                               ': mean of the errors squared in units of their own covariances '// &
                                               rounded_text(entry%mean_normalised, 3)//' (3 if honest, sigma '// &
                                               rounded_text(sqrt(6.0_dp/size(entry%run)), 2)//')')
                    if (size(entry%refused) > 0) call console%warn(trim(campaign%cases(i)%name)//', '// &
                        trim(campaign%algorithms(a))//': '//integer_text(size(entry%refused))//' of '// &
                        integer_text(size(entry%run) + size(entry%refused))//' runs refused and left out, the first: '// &
                        entry%refused(1)%text)
                end associate
            end do
        end do
        call show_agreement(agreement_of(campaign), most, console)
        do i = 1, size(campaign%cases)
            associate (case => campaign%cases(i))
                if (case%published == '' .and. any(REPORT_CASE_NAMES == case%name)) &
                    call console%paragraph(trim(case%name)//': edited or switched, not the case of the report: nothing is '// &
                                      'published for it')
            end associate
        end do
    end subroutine show_campaign

    !> The first calibration of each case, and what theory expects of it.
    subroutine show_first(campaign, console)
        type(campaign_t), intent(in) :: campaign
        type(console_t), intent(inout) :: console

        type(data_table_t) :: table
        integer :: axis, i

        call table%column('case', 'a', 'case')
        do axis = 1, size(AXES)
            call table%column('true', 'f10.4', 'd_'//AXES(axis)//'|true')
            call table%column('estimate', 'f10.4', '|estimate')
            call table%column('error', 'f10.4', '|error*')
        end do
        do i = 1, size(campaign%cases)
            associate (entry => campaign%entries(1, i), case => campaign%cases(i))
                if (size(entry%run) == 0) cycle
                call table%add(case%name)
                do axis = 1, 3
                    call table%add([case%offset(axis), entry%offset(axis, 1), entry%predicted(axis)])
                end do
            end associate
        end do
        call console%paragraph('CG offset d (centre of mass to proof mass, body axes, mm) of one simulated calibration: '// &
                               trim(campaign%algorithms(1))//', the first run, seed '//integer_text(campaign%seed))
        call console%table(table)
        call console%line('(* expected by theory: noise, systematic errors and drag that is not a straight line)')
        call console%line('')
    end subroutine show_first

    !> How ours, the report's and theory agree.
    subroutine show_agreement(found, runs, console)
        type(campaign_agreement_t), intent(in) :: found
        integer, intent(in) :: runs             !! Of the entry that has most
        type(console_t), intent(inout) :: console

        call console%line('')
        if (found%published > 0) &
            call console%line('published values that 15 runs allow if theory is right (95 %): '// &
                              integer_text(found%allowed)//' of '//integer_text(found%published))
        if (found%misprint) call console%line('front-1, ascrest, z is printed 0.01112 in the report: taken as 0.1112')
        call console%line('largest difference of an RMS here from theory: '// &
                          percent_text(found%worst_difference)//'; one sigma of '//integer_text(runs)// &
                          ' runs: '//percent_text(sampling_error(runs)))
        if (found%not_converged > 0) call console%warn(integer_text(found%not_converged)//' runs did not converge')
    end subroutine show_agreement

    !> A part of 1 as '12.3 %'.
    function percent_text(part) result(text)
        real(dp), intent(in) :: part            !! Of 1
        character(:), allocatable :: text

        character(12) :: digits

        write (digits, '(f12.1)') 100*part
        text = trim(adjustl(digits))//' %'
    end function percent_text

    !> The same as CSV or JSON, then into the files that are asked for.
    subroutine publish_campaign(campaign, command, table_file, runs_file, console, error)
        type(campaign_t), intent(in) :: campaign
        character(*), intent(in) :: command         !! As typed
        character(*), intent(in) :: table_file, runs_file   !! Of read_campaign_files
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results
        integer :: a, i

        call results%open(command)
        call results%member('seed', campaign%seed)
        call results%member('runs', campaign%runs)
        call results%member('shard', campaign%shard)
        call results%member('shards', campaign%shards)
        call results%begin_array('cases')
        do i = 1, size(campaign%cases)
            call results%begin(on_one_line=.true.)
            call results%member('case', trim(campaign%cases(i)%name))
            call results%member('true_offset_mm', campaign%cases(i)%offset)
            call results%begin('normalised')
            do a = 1, size(campaign%algorithms)
                if (campaign%entries(a, i)%mean_normalised > 0) &
                    call results%member(trim(campaign%algorithms(a)), campaign%entries(a, i)%mean_normalised)
            end do
            call results%end()
            call results%end()
        end do
        call results%end()
        call put_agreement(agreement_of(campaign), results)
        call results%publish(campaign_table(campaign), console, error)
        if (.not. allocated(error) .and. table_file /= '') call write_table(table_file, campaign, command, error)
        if (.not. allocated(error) .and. runs_file /= '') call write_runs(runs_file, campaign, command, error)
    end subroutine publish_campaign

    !> The member `agreement` of JSON.
    subroutine put_agreement(found, results)
        type(campaign_agreement_t), intent(in) :: found
        type(results_t), intent(inout) :: results

        call results%begin('agreement')
        call results%member('published', found%published)
        call results%member('allowed', found%allowed)
        call results%member('not_converged', found%not_converged)
        call results%member('refused', found%refused)
        call results%member('worst_difference', found%worst_difference)
        call results%end()
    end subroutine put_agreement
end module gracecg_cli_campaign_tables
