!> What no test of the operator's beliefs would see in a designed manoeuvre, for the console and as results.
module gracecg_cli_reliable_manoeuvre
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_text, only: integer_text, rounded_text
    use gracecg_estimation_belief, only: BELIEFS
    use gracecg_estimation_belief_words, only: say_undetected
    use gracecg_planning_reliable_design, only: reliable_design_t
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t
    implicit none
    private
    public :: show_reliable, put_reliable

contains

    !> The largest undetected effects and whether they are as small as is wanted.
    subroutine show_reliable(reliable, console)
        type(reliable_design_t), intent(in) :: reliable
        type(console_t), intent(inout) :: console

        character(:), allocatable :: text

        call say_undetected(reliable%report, text)
        call console%line('')
        call console%paragraph('a single wrong belief could move the offset undetected by '//text//': '// &
                               trim(merge('as wanted,             ', 'this search found none,', reached(reliable)))//' at most '// &
                               rounded_text(reliable%report%wanted/MILLIMETRE, 3)//' mm; '// &
                               integer_text(reliable%evaluations)//' manoeuvres were tried')
    end subroutine show_reliable

    pure logical function reached(reliable)
        type(reliable_design_t), intent(in) :: reliable

        reached = all(reliable%effect <= reliable%report%wanted)
    end function reached

    !> The same as an object.
    subroutine put_reliable(reliable, results)
        type(reliable_design_t), intent(in) :: reliable
        type(results_t), intent(inout) :: results

        integer :: axis

        call results%begin('reliability')
        call results%member('wanted_mm', reliable%report%wanted/MILLIMETRE)
        call results%member('reached', reached(reliable))
        call results%member('evaluations', reliable%evaluations)
        call results%begin_array('undetected')
        do axis = 1, 3
            call results%begin(on_one_line=.true.)
            call results%member('effect_mm', reliable%effect(axis)/MILLIMETRE)
            associate (place => reliable%report%largest(axis))
                if (place > 0) &
                    call results%member('belief', trim(BELIEFS(reliable%report%values(place)%belief)%subject))
            end associate
            call results%end()
        end do
        call results%end()
        call results%end()
    end subroutine put_reliable
end module gracecg_cli_reliable_manoeuvre
