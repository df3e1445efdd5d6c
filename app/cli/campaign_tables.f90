!> What montecarlo and merge print of a campaign: the layout of Tables 6.1 and 6.2 of CSR-TM-00-01.
module gracecg_cli_campaign_tables
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_statistics, only: sampling_error
    use gracecg_base_text, only: integer_text
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_studies_campaign, only: campaign_t, campaign_agreement_t, agreement_of
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t
    use gracecg_studies_campaign_files, only: campaign_table
    use gracecg_cli_number_text, only: percent_text
    implicit none
    private
    public :: show_campaign, publish_campaign, read_campaign_files, wide, REPORT_RUNS

    integer, parameter :: REPORT_RUNS = 15          !! Of every entry of the published tables
    integer, parameter :: NAME_WIDTH = 10           !! Of the column of the cases, for short names
    integer, parameter :: FEWEST_DIGITS = 5         !! That algorithms have alike who share a column

contains

    !> The files for the results, --out and --runs-out; empty where there shall be none.
    subroutine read_campaign_files(arguments, table_file, runs_file, misuse)
        type(arguments_t), intent(in) :: arguments
        character(:), allocatable, intent(out) :: table_file, runs_file !! As given; empty when not
        type(error_t), allocatable, intent(inout) :: misuse

        call arguments%get('--out', table_file, misuse, default='')
        call arguments%get('--runs-out', runs_file, misuse, default='')
        call refuse_if(table_file /= '' .and. table_file == runs_file, &
                       'options --out and --runs-out name the same file, '//table_file, misuse)
    end subroutine read_campaign_files

    !> RMS by case and axis: ours, of the report and of theory; then how they agree. Where all algorithms give the
    !> same, they share a column.
    subroutine show_campaign(campaign, console)
        type(campaign_t), intent(in) :: campaign
        type(console_t), intent(inout) :: console

        integer :: digits, width, most, i

        most = most_runs(campaign)
        call console%line('RMS error of the CG offset, mm: '//runs_text(campaign)//' here, '// &
                          integer_text(REPORT_RUNS)//' in CSR-TM-00-01 (Tables 6.1 and 6.2), and theory')
        width = max(NAME_WIDTH, maxval(len_trim(campaign%cases%name)) + 2)
        digits = digits_alike(campaign)
        if (size(campaign%algorithms) > 1 .and. digits >= FEWEST_DIGITS) then
            call show_alike(campaign, digits, width, console)
        else
            call show_each(campaign, width, console)
        end if
        call show_honesty(campaign, width, console)
        call show_agreement(agreement_of(campaign), most, console)
        do i = 1, size(campaign%cases)
            associate (case => campaign%cases(i))
                if (case%published == '' .and. any(REPORT_CASE_NAMES == case%name)) &
                    call console%paragraph(trim(case%name)//': edited or switched, not the case of the report: nothing is '// &
                                      'published for it')
            end associate
        end do
    end subroutine show_campaign

    !> The runs of the entry that has most.
    pure integer function most_runs(campaign) result(most)
        type(campaign_t), intent(in) :: campaign

        integer :: a, i

        most = maxval([((size(campaign%entries(a, i)%run), a=1, size(campaign%algorithms)), i=1, size(campaign%cases))])
    end function most_runs

    !> "15 runs", or of a campaign that was stopped "0 to 15 runs".
    function runs_text(campaign) result(text)
        type(campaign_t), intent(in) :: campaign
        character(:), allocatable :: text

        integer :: a, i, least

        least = minval([((size(campaign%entries(a, i)%run), a=1, size(campaign%algorithms)), i=1, size(campaign%cases))])
        text = integer_text(most_runs(campaign))//' runs'
        if (least < most_runs(campaign)) text = integer_text(least)//' to '//text
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

    !> One column for all algorithms, and the published values of each.
    subroutine show_alike(campaign, digits, width, console)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: digits           !! That are the same
        integer, intent(in) :: width            !! Of the column of the cases
        type(console_t), intent(inout) :: console

        character(160) :: row
        integer :: a, i, axis, n

        n = size(campaign%algorithms)
        call console%line('(the '//integer_text(n)//' algorithms work on the same observations here, and their RMS errors '// &
                          'agree to '//integer_text(digits)//' digits:')
        call console%line('one column stands for them; in the report each had its own observations)')
        row = 'axis        here      theory'
        if (any_published(campaign)) write (row(29:), '(*(a12))') (trim(campaign%algorithms(a)), a=1, n)
        if (any_published(campaign)) call console%line(repeat(' ', width + 28)//'  in the report:')
        call console%line(wide('case', width)//trim(row))
        do i = 1, size(campaign%cases)
            associate (entries => campaign%entries(:, i))
                do axis = 1, 3
                    write (row, '(a, t5, 2f12.5)') AXES(axis), entries(1)%statistics%rms(axis), entries(1)%predicted(axis)
                    if (any(entries%published(axis) > 0)) &
                        write (row(29:), '(*(a12))') (or_dash(entries(a)%published(axis)), a=1, n)
                    call console%line(wide(trim(campaign%cases(i)%name), width)//trim(row))
                end do
            end associate
        end do
    end subroutine show_alike

    pure logical function any_published(campaign)
        type(campaign_t), intent(in) :: campaign

        integer :: a, i

        any_published = .false.
        do i = 1, size(campaign%cases)
            do a = 1, size(campaign%algorithms)
                any_published = any_published .or. any(campaign%entries(a, i)%published > 0)
            end do
        end do
    end function any_published

    !> A column for each algorithm, with a row of ours, one of the report and one of theory.
    subroutine show_each(campaign, width, console)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: width            !! Of the column of the cases
        type(console_t), intent(inout) :: console

        character(:), allocatable :: label
        character(160) :: row
        integer :: a, i, axis, n

        n = size(campaign%algorithms)
        if (n > 1) call console%line('(here all algorithms work on the same observations; in the report '// &
                                     'each had its own)')
        write (row, '(a, t17, *(a12))') 'axis', (trim(campaign%algorithms(a)), a=1, n)
        call console%line(wide('case', width)//trim(row))
        do i = 1, size(campaign%cases)
            associate (entries => campaign%entries(:, i))
                do axis = 1, 3
                    label = wide(trim(campaign%cases(i)%name), width)
                    write (row, '(a, t6, a, t17, *(a12))') AXES(axis), 'here', &
                        (or_dash(merge(entries(a)%statistics%rms(axis), 0.0_dp, size(entries(a)%run) > 0)), a=1, n)
                    call console%line(label//trim(row))
                    label = wide('', width)
                    if (any(entries%published(axis) > 0)) then
                        write (row, '(t6, a, t17, *(a12))') 'report', (or_dash(entries(a)%published(axis)), a=1, n)
                        call console%line(label//trim(row))
                    end if
                    write (row, '(t6, a, t17, *(f12.5))') 'theory', entries%predicted(axis)
                    call console%line(label//trim(row))
                end do
            end associate
        end do
    end subroutine show_each

    !> A number, or a dash for 0.
    function or_dash(value) result(text)
        real(dp), intent(in) :: value
        character(12) :: text

        write (text, '(f12.5)') value
        if (.not. value > 0) text = repeat(' ', 11)//'-'
    end function or_dash

    !> How honest the sigmas are that estimators give with their estimates.
    subroutine show_honesty(campaign, width, console)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: width            !! Of the column of the cases
        type(console_t), intent(inout) :: console

        character(160) :: row
        integer :: a, i, n

        if (.not. any(campaign%entries%normalised > 0)) return
        n = size(campaign%algorithms)
        call console%line('')
        write (row, '(a, f0.2, a)') 'mean of the errors squared in units of the estimates'' own covariances (3 if '// &
            'those are honest; one sigma ', sqrt(6.0_dp/most_runs(campaign)), ')'
        call console%paragraph(row)
        do i = 1, size(campaign%cases)
            write (row, '(t17, *(a12))') (or_dash(campaign%entries(a, i)%normalised), a=1, n)
            call console%line(wide(trim(campaign%cases(i)%name), width)//trim(row))
        end do
    end subroutine show_honesty

    !> How ours, the report's and theory agree.
    subroutine show_agreement(found, runs, console)
        type(campaign_agreement_t), intent(in) :: found
        integer, intent(in) :: runs
        type(console_t), intent(inout) :: console

        call console%line('')
        if (found%published > 0) then
            call console%line('published values that 15 runs allow if theory is right (95 %): '// &
                              integer_text(found%allowed)//' of '//integer_text(found%published))
        end if
        if (found%misprint) then
            call console%line('front-1, ascrest, z is printed 0.01112 in the report: taken as 0.1112')
        end if
        call console%line('largest difference of an RMS here from theory: '// &
                          percent_text(found%worst_difference)//'; one sigma of '//integer_text(runs)// &
                          ' runs: '//percent_text(sampling_error(runs)))
        if (found%not_converged > 0) then
            call console%warn(integer_text(found%not_converged)//' runs did not converge')
        end if
    end subroutine show_agreement

    !> The same as CSV or JSON.
    subroutine publish_campaign(campaign, command, console, error)
        type(campaign_t), intent(in) :: campaign
        character(*), intent(in) :: command         !! As typed
        type(console_t), intent(inout) :: console
        type(error_t), allocatable, intent(out) :: error

        type(results_t) :: results
        type(campaign_agreement_t) :: found
        integer :: a, i

        found = agreement_of(campaign)
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
                if (campaign%entries(a, i)%normalised > 0) &
                    call results%member(trim(campaign%algorithms(a)), campaign%entries(a, i)%normalised)
            end do
            call results%end()
            call results%end()
        end do
        call results%end()
        call results%begin('agreement')
        call results%member('published', found%published)
        call results%member('allowed', found%allowed)
        call results%member('not_converged', found%not_converged)
        call results%member('worst_difference', found%worst_difference)
        call results%end()
        call results%publish(campaign_table(campaign), console, error)
    end subroutine publish_campaign

    !> A text with blanks behind it to a width; a longer one as it is.
    pure function wide(text, width) result(padded)
        character(*), intent(in) :: text    !! The text
        integer, intent(in) :: width        !! In characters
        character(:), allocatable :: padded

        padded = text//repeat(' ', max(0, width - len(text)))
    end function wide
end module gracecg_cli_campaign_tables
