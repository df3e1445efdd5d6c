!> What the tests of the operator's beliefs have found: for people, and as JSON.
module gracecg_cli_belief_results
    use gracecg_observations_parameters, only: BELIEF_UNIT, BELIEF_SIZE
    use gracecg_estimation_belief_report, only: belief_report_t, NOISE_SUBJECTS, FAMILY_LEVEL, POWER
    use gracecg_estimation_belief_words, only: say_counts, say_undetected, say_untested, say_contradiction
    use gracecg_cli_work
    implicit none
    private
    public :: show_beliefs, put_beliefs

contains

    !> What the data say of the operator's beliefs, in two lines; a contradiction is among the warnings.
    subroutine show_beliefs(report, console)
        type(belief_report_t), intent(in) :: report
        type(console_t), intent(inout) :: console

        character(:), allocatable :: text

        call say_counts(report, text)
        call console%line('beliefs           '//text)
        call say_undetected(report, .true., text)
        call console%line('undetected up to  '//text//': by three times what the setup states')
        call say_undetected(report, .false., text)
        call console%line('  if more is wrong '//text)
        call say_untested(report, text)
        if (text /= '') call console%line('not testable here '//text)
        if (any(report%apart > 0)) &
            call console%line('left out of sigma '//rounded_text(report%apart(1)/MILLIMETRE, 2)//', '// &
                              rounded_text(report%apart(2)/MILLIMETRE, 2)//', '// &
                              rounded_text(report%apart(3)/MILLIMETRE, 2)//' mm in x, y, z: the '// &
                              'difference from `optimal`, which knows forces that bend, scale factors and magnetometer bias')
    end subroutine show_beliefs

    !> The same, test by test, as the member `beliefs`.
    subroutine put_beliefs(report, results)
        type(belief_report_t), intent(in) :: report
        type(results_t), intent(inout) :: results

        character(16), parameter :: STATES(3) = [character(16) :: 'confirmed', 'not testable', 'contradicted']
        character(:), allocatable :: text
        integer :: i

        call results%begin('beliefs')
        call results%member('family_level', FAMILY_LEVEL)
        call results%member('power', POWER)
        call results%member('critical_score', report%critical)
        call results%begin_array('values')
        do i = 1, size(report%values)
            associate (t => report%values(i), unit => BELIEF_SIZE(report%values(i)%belief))
                call results%begin(on_one_line=.true.)
                call results%member('subject', trim(t%subject))
                call results%member('state', trim(STATES(t%state)))
                call results%member('score', t%score)
                call results%member('value', t%value/unit)
                call results%member('sigma', t%sigma/unit)
                call results%member('detectable', t%detectable/unit)
                call results%member('unit', trim(BELIEF_UNIT(t%belief)))
                call results%member('effect_mm', t%effect/MILLIMETRE)
                call results%member('effect_as_stated_mm', t%within/MILLIMETRE)
                call results%end()
            end associate
        end do
        call results%end()
        call results%begin_array('noises')
        do i = 1, size(report%noises)
            associate (t => report%noises(i))
                call results%begin(on_one_line=.true.)
                call results%member('subject', trim(NOISE_SUBJECTS(t%subject)))
                call results%member('state', trim(STATES(t%state)))
                call results%member('score', t%score)
                call results%member('factor', t%factor)
                if (t%frequency > 0) call results%member('frequency_hz', t%frequency)
                call results%end()
            end associate
        end do
        call results%end()
        call say_contradiction(report, text)
        call results%member('contradiction', text)
        call say_untested(report, text)
        call results%member('untested', text)
        call results%member('stated_mm', report%stated/MILLIMETRE)
        call results%member('undetected_mm', report%undetected(.false.)/MILLIMETRE)
        call results%member('undetected_as_stated_mm', report%undetected(.true.)/MILLIMETRE)
        call results%member('apart_from_optimal_mm', report%apart/MILLIMETRE)
        call results%end()
    end subroutine put_beliefs
end module gracecg_cli_belief_results
