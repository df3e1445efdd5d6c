!> What montecarlo and merge print of a campaign: the layout of Tables 6.1 and 6.2 of CSR-TM-00-01.
module gracecg_cli_campaign_tables
    use gracecg_base_constants, only: AXES
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_statistics, only: sampling_error
    use gracecg_base_text, only: integer_text
    use gracecg_studies_campaign, only: campaign_t, campaign_agreement_t, agreement_of
    use gracecg_cli_arguments, only: arguments_t, refuse_if
    use gracecg_cli_console, only: console_t
    use gracecg_cli_number_text, only: percent_text
    implicit none
    private
    public :: show_campaign, read_campaign_files, wide, REPORT_RUNS

    integer, parameter :: REPORT_RUNS = 15          !! Of every entry of the published tables
    integer, parameter :: NAME_WIDTH = 10           !! Of the column of the cases, for short names

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

    !> RMS by case and axis; a row of ours, one of the report and one of theory; then how they agree.
    subroutine show_campaign(campaign, console)
        type(campaign_t), intent(in) :: campaign
        type(console_t), intent(inout) :: console

        character(:), allocatable :: label
        character(160) :: row
        integer :: a, i, axis, n, runs, width

        n = size(campaign%algorithms)
        runs = size(campaign%entries(1, 1)%run)
        call console%line('RMS error of the CG offset, mm: '//integer_text(runs)//' runs here, '// &
                          integer_text(REPORT_RUNS)//' in CSR-TM-00-01 (Tables 6.1 and 6.2), and theory')
        if (n > 1) call console%line('(here all algorithms work on the same observations; in the report '// &
                                     'each had its own)')
        width = max(NAME_WIDTH, maxval(len_trim(campaign%cases%name)) + 2)
        write (row, '(a, t17, *(a12))') 'axis', (trim(campaign%algorithms(a)), a=1, n)
        call console%line(wide('case', width)//trim(row))
        do i = 1, size(campaign%cases)
            associate (entries => campaign%entries(:, i))
                do axis = 1, 3
                    label = wide(trim(campaign%cases(i)%name), width)
                    write (row, '(a, t6, a, t17, *(f12.5))') AXES(axis), 'here', entries%statistics%rms(axis)
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
        call show_honesty(campaign, width, console)
        call show_agreement(agreement_of(campaign), runs, console)
    end subroutine show_campaign

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
        integer :: a, i, n, runs

        if (.not. any(campaign%entries%normalised > 0)) return
        n = size(campaign%algorithms)
        runs = size(campaign%entries(1, 1)%run)
        call console%line('')
        write (row, '(a, f0.2, a)') 'mean of the errors squared in units of the estimates'' own covariances (3 if '// &
            'those are honest; one sigma ', sqrt(6.0_dp/runs), ')'
        call console%line(trim(row))
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

    !> A text with blanks behind it to a width; a longer one as it is.
    pure function wide(text, width) result(padded)
        character(*), intent(in) :: text    !! The text
        integer, intent(in) :: width        !! In characters
        character(:), allocatable :: padded

        padded = text//repeat(' ', max(0, width - len(text)))
    end function wide
end module gracecg_cli_campaign_tables
