!> What montecarlo and merge print of a campaign: the layout of Tables 6.1 and 6.2 of CSR-TM-00-01.
module gracecg_cli_campaign_tables
    use gracecg_base_statistics, only: sampling_error
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_studies_campaign, only: campaign_t, campaign_agreement_t, agreement_of
    use gracecg_studies_campaign_files, only: campaign_table
    use gracecg_cli_work
    implicit none
    private
    public :: show_campaign, publish_campaign, put_agreement, read_campaign_files, percent_text, REPORT_RUNS

    integer, parameter :: REPORT_RUNS = 15          !! Of every entry of the published tables
    integer, parameter :: FEWEST_DIGITS = 5         !! That algorithms have alike who work alike

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

    !> RMS by case and axis: ours, of the report and of theory; then how they agree.
    subroutine show_campaign(campaign, console)
        type(campaign_t), intent(in) :: campaign
        type(console_t), intent(inout) :: console

        logical :: alike
        integer :: digits, i

        call console%line('RMS error of the CG offset, mm: '//runs_text(campaign)//' here, '// &
                          integer_text(REPORT_RUNS)//' in CSR-TM-00-01 (Tables 6.1 and 6.2), and theory')
        digits = digits_alike(campaign)
        alike = size(campaign%algorithms) == 1 .or. digits >= FEWEST_DIGITS
        if (size(campaign%algorithms) > 1) &
            call console%paragraph('(here all algorithms work on the same observations; in the report each had its own)')
        if (size(campaign%algorithms) > 1 .and. alike) &
            call console%paragraph('(the RMS errors of the '//integer_text(size(campaign%algorithms))//' algorithms agree to '// &
                                   integer_text(digits)//' digits here: one column stands for them)')
        call show_errors(campaign, merge(1, size(campaign%algorithms), alike), console)
        call show_honesty(campaign, console)
        call show_agreement(agreement_of(campaign), maxval(runs_of(campaign)), console)
        do i = 1, size(campaign%cases)
            associate (case => campaign%cases(i))
                if (case%published == '' .and. any(REPORT_CASE_NAMES == case%name)) &
                    call console%paragraph(trim(case%name)//': edited or switched, not the case of the report: nothing is '// &
                                      'published for it')
            end associate
        end do
    end subroutine show_campaign

    !> How many runs each entry has.
    pure function runs_of(campaign) result(runs)
        type(campaign_t), intent(in) :: campaign
        integer :: runs(size(campaign%algorithms), size(campaign%cases))

        integer :: a, i

        do i = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                runs(a, i) = size(campaign%entries(a, i)%run)
            end do
        end do
    end function runs_of

    !> "15 runs", or of a campaign that was stopped "0 to 15 runs".
    function runs_text(campaign) result(text)
        type(campaign_t), intent(in) :: campaign
        character(:), allocatable :: text

        associate (runs => runs_of(campaign))
            text = integer_text(maxval(runs))//' runs'
            if (minval(runs) < maxval(runs)) text = integer_text(minval(runs))//' to '//text
        end associate
    end function runs_text

    !> To how many digits the RMS errors of all algorithms are the same, in every case and axis; 0 when not all
    !> have the same runs.
    pure integer function digits_alike(campaign) result(digits)
        type(campaign_t), intent(in) :: campaign

        integer, parameter :: MOST_DIGITS = 12
        real(dp) :: difference
        integer :: a, i

        digits = 0
        difference = 10.0_dp**(-MOST_DIGITS)
        do i = 1, size(campaign%cases)
            associate (first => campaign%entries(1, i))
                do a = 1, size(campaign%algorithms)
                    associate (entry => campaign%entries(a, i))
                        if (size(entry%run) == 0 .or. size(entry%run) /= size(first%run)) return
                        if (any(entry%run /= first%run)) return
                        difference = max(difference, maxval(abs(entry%statistics%rms/first%statistics%rms - 1)), &
                                         maxval(abs(entry%predicted/first%predicted - 1)))
                    end associate
                end do
            end associate
        end do
        digits = floor(-log10(difference))
    end function digits_alike

    !> A row for each case and axis: ours, theory, the report, by algorithm.
    subroutine show_errors(campaign, different, console)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: different        !! Algorithms that have columns of their own here: the first one, or all
        type(console_t), intent(inout) :: console

        type(data_table_t) :: table
        logical :: published
        integer :: a, i, axis

        published = any([((any(campaign%entries(a, i)%published > 0), a=1, size(campaign%algorithms)), i=1, size(campaign%cases))])
        call table%column('case', 'a', 'case')
        call table%column('axis', 'a', 'axis')
        call add_columns('here', campaign%algorithms(:different), different > 1, table)
        call add_columns('theory', campaign%algorithms(:different), different > 1, table)
        if (published) call add_columns('in the report', campaign%algorithms, .true., table)
        do i = 1, size(campaign%cases)
            associate (entries => campaign%entries(:, i))
                do axis = 1, 3
                    call table%add(campaign%cases(i)%name)
                    call table%add(AXES(axis))
                    call add_positive([(merge(entries(a)%statistics%rms(axis), 0.0_dp, size(entries(a)%run) > 0), &
                                        a=1, different)], table)
                    call add_positive(entries(:different)%predicted(axis), table)
                    if (published) call add_positive(entries%published(axis), table)
                end do
            end associate
        end do
        call console%table(table)
    end subroutine show_errors

    !> A column for each algorithm below one heading.
    subroutine add_columns(heading, algorithms, named, table)
        character(*), intent(in) :: heading
        character(*), intent(in) :: algorithms(:)
        logical, intent(in) :: named            !! The algorithms are told
        type(data_table_t), intent(inout) :: table

        integer :: a

        do a = 1, size(algorithms)
            if (.not. named) then
                call table%column(heading, 'f12.5', heading)
            else if (a == 1) then
                call table%column(heading, 'f12.5', heading//'|'//trim(algorithms(a)))
            else
                call table%column(heading, 'f12.5', '|'//trim(algorithms(a)))
            end if
        end do
    end subroutine add_columns

    !> Numbers of a row; nothing for 0.
    subroutine add_positive(values, table)
        real(dp), intent(in) :: values(:)
        type(data_table_t), intent(inout) :: table

        integer :: a

        do a = 1, size(values)
            if (values(a) > 0) then
                call table%add(values(a))
            else
                call table%add_nothing()
            end if
        end do
    end subroutine add_positive

    !> How honest the sigmas are that estimators give with their estimates.
    subroutine show_honesty(campaign, console)
        type(campaign_t), intent(in) :: campaign
        type(console_t), intent(inout) :: console

        type(data_table_t) :: table
        character(160) :: line
        integer :: i

        if (.not. any(campaign%entries%mean_normalised > 0)) return
        call console%line('')
        write (line, '(a, f0.2, a)') 'mean of the errors squared in units of the estimates'' own covariances (3 if '// &
            'those are honest; one sigma ', sqrt(6.0_dp/maxval(runs_of(campaign))), ')'
        call console%paragraph(line)
        call table%column('case', 'a', 'case')
        call add_columns('', campaign%algorithms, .true., table)
        do i = 1, size(campaign%cases)
            call table%add(campaign%cases(i)%name)
            call add_positive(campaign%entries(:, i)%mean_normalised, table)
        end do
        call console%table(table)
    end subroutine show_honesty

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

    !> The same as CSV or JSON.
    subroutine publish_campaign(campaign, command, console, error)
        type(campaign_t), intent(in) :: campaign
        character(*), intent(in) :: command         !! As typed
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
    end subroutine publish_campaign

    !> The member `agreement` of JSON.
    subroutine put_agreement(found, results)
        type(campaign_agreement_t), intent(in) :: found
        type(results_t), intent(inout) :: results

        call results%begin('agreement')
        call results%member('published', found%published)
        call results%member('allowed', found%allowed)
        call results%member('not_converged', found%not_converged)
        call results%member('worst_difference', found%worst_difference)
        call results%end()
    end subroutine put_agreement
end module gracecg_cli_campaign_tables
