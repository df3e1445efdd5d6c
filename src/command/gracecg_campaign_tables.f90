!> What montecarlo and merge print of a campaign: the layout of Tables 6.1 and 6.2 of CSR-TM-00-01.
module gracecg_campaign_tables
    use gracecg_kinds, only: dp
    use gracecg_text, only: integer_text
    use gracecg_campaign, only: campaign_t, verdict_t, campaign_verdict, AXES
    use gracecg_console, only: console_t
    implicit none
    private
    public :: show_campaign, percent, REPORT_RUNS

    integer, parameter :: REPORT_RUNS = 15          !! Of every entry of the published tables

contains

    !> RMS by case and axis; a row of ours, one of the report and one of theory; then the verdict.
    subroutine show_campaign(campaign, console)
        type(campaign_t), intent(in) :: campaign
        type(console_t), intent(inout) :: console

        character(160) :: row
        integer :: a, i, axis, n, runs

        n = size(campaign%algorithms)
        runs = size(campaign%entries(1, 1)%run)
        call console%line('RMS error of the CG offset, mm: '//integer_text(runs)//' runs here, '// &
                          integer_text(REPORT_RUNS)//' in CSR-TM-00-01 (Tables 6.1 and 6.2), and theory')
        if (n > 1) call console%line('(here all algorithms work on the same observations; in the report '// &
                                     'each had its own)')
        write (row, '(a, t27, *(a12))') 'case      axis', (trim(campaign%algorithms(a)), a=1, n)
        call console%line(trim(row))
        do i = 1, size(campaign%cases)
            associate (entries => campaign%entries(:, i))
                do axis = 1, 3
                    write (row, '(a, t11, a, t16, a, t27, *(f12.5))') trim(campaign%cases(i)%name), &
                        AXES(axis), 'here', entries%statistics%rms(axis)
                    call console%line(trim(row))
                    if (any(entries%published(axis) > 0)) then
                        write (row, '(t16, a, t27, *(f12.5))') 'report', entries%published(axis)
                        call console%line(trim(row))
                    end if
                    write (row, '(t16, a, t27, *(f12.5))') 'theory', entries%predicted(axis)
                    call console%line(trim(row))
                end do
            end associate
        end do
        call show_verdict(campaign_verdict(campaign), runs, console)
    end subroutine show_campaign

    !> How ours, the report's and theory agree.
    subroutine show_verdict(verdict, runs, console)
        type(verdict_t), intent(in) :: verdict
        integer, intent(in) :: runs
        type(console_t), intent(inout) :: console

        call console%line('')
        if (verdict%published > 0) then
            call console%line('published values that 15 runs allow if theory is right (95 %): '// &
                              integer_text(verdict%allowed)//' of '//integer_text(verdict%published))
        end if
        if (verdict%misprint) then
            call console%line('front-1, ascrest, z is printed 0.01112 in the report: taken as 0.1112')
        end if
        call console%line('largest difference of an RMS here from theory: '// &
                          percent(verdict%worst_difference)//'; one sigma of '//integer_text(runs)// &
                          ' runs: '//percent(1/sqrt(2.0_dp*runs)))
        if (verdict%not_converged > 0) then
            call console%message('warning: '//integer_text(verdict%not_converged)//' runs did not converge')
        end if
    end subroutine show_verdict

    function percent(part) result(text)
        real(dp), intent(in) :: part
        character(:), allocatable :: text

        character(12) :: digits

        write (digits, '(f10.1)') 100*part
        text = trim(adjustl(digits))//' %'
    end function percent
end module gracecg_campaign_tables
