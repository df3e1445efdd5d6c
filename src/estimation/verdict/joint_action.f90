!> What an operator is to do with one offset of several runs: nothing where they do not agree, or one is contradicted.
module gracecg_estimation_joint_action
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, integer_text, rounded_text
    use gracecg_estimation_action, only: action_t, known_offset_t, decide, refuse_offset, NOT_TESTED
    use gracecg_estimation_belief_words, only: say_contradiction
    use gracecg_estimation_joint_estimate, only: joint_options_t, joint_solution_t, joint_sigma, estimate_jointly
    use gracecg_estimation_joint_runs, only: joint_run_t
    use gracecg_estimation_run_information, only: run_information_t
    implicit none
    private
    public :: act_on_runs, known_of_runs, say_disagreement

contains

    !> What to do with the joint estimate of runs.
    subroutine act_on_runs(runs, options, names, solution, action)
        type(joint_run_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(string_t), intent(in) :: names(:)          !! Of the runs
        type(joint_solution_t), intent(in) :: solution
        type(action_t), intent(out) :: action

        character(:), allocatable :: text
        integer :: i

        if (.not. solution%consistent) then
            call say_disagreement('runs', names, runs%information, options, solution, text)
            call refuse_offset(text, action)
            return
        end if
        do i = 1, size(runs)
            if (.not. allocated(runs(i)%solution%beliefs)) then
                action%kind = NOT_TESTED
                action%text = 'not tested: '//names(i)%text//': what its setup says was not tested against the data '// &
                    '(test_beliefs, covariance); estimate with them before masses move'
                return
            end if
            call say_contradiction(runs(i)%solution%beliefs, text)
            if (text == '') cycle
            call refuse_offset(names(i)%text//': '//text, action)
            return
        end do
        call decide(known_of_runs(runs, solution), runs(solution%last)%knowledge%mass, action)
    end subroutine act_on_runs

    !> What is known of the offset of runs whose beliefs were tested. What is stated of beliefs, and what could move the offset
    !> unseen, is that of each run, weighted as the runs determine each axis: a wrong belief that all share moves them all.
    pure function known_of_runs(runs, solution) result(known)
        type(joint_run_t), intent(in) :: runs(:)
        type(joint_solution_t), intent(in) :: solution
        type(known_offset_t) :: known

        real(dp) :: weight(size(runs)), part, largest, stated
        integer :: axis, i

        known%value = solution%offset
        known%sigma = joint_sigma(solution)
        known%signs_known = .true.
        do axis = 1, 3
            weight = 1/solution%runs%sigma(axis)**2
            weight = weight/sum(weight)
            largest = -1
            stated = 0
            do i = 1, size(runs)
                associate (report => runs(i)%solution%beliefs)
                    known%tolerated = report%wanted
                    known%signs_known = known%signs_known .and. report%signs_known
                    stated = stated + weight(i)*report%stated(axis)
                    if (size(report%values) == 0) cycle
                    associate (test => report%values(report%largest_within(axis)))
                        part = weight(i)*abs(test%within(axis))
                        known%unseen(axis) = known%unseen(axis) + part
                        if (part > largest) known%hidden(axis) = test%subject
                        largest = max(largest, part)
                    end associate
                end associate
            end do
            known%sigma(axis) = hypot(known%sigma(axis), stated)
        end do
    end function known_of_runs

    !> That runs or arcs do not agree on one offset: without which the others agree best, and whether they do. Of two
    !> nobody can say which is wrong.
    subroutine say_disagreement(kind, names, runs, options, solution, text)
        character(*), intent(in) :: kind                    !! runs or arcs
        type(string_t), intent(in) :: names(:)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(joint_solution_t), intent(in) :: solution      !! Of them
        character(:), allocatable, intent(out) :: text      !! Without a full stop

        type(joint_solution_t) :: others
        type(error_t), allocatable :: error
        integer :: i, worst

        ! by so much chi square falls when a run has an offset of its own, which leaves that of the others
        worst = merge(2, maxloc(solution%runs%statistic, 1), size(runs) == 2)
        text = 'the '//kind//' do not agree on one offset: chi square '//rounded_text(solution%statistic, 4)//' for '// &
            integer_text(solution%degrees)//' degrees of freedom, which chance reaches with a probability of '// &
            rounded_text(solution%probability, 2)//'; '//names(worst)%text
        if (size(runs) == 2) then
            text = text//' minus '//names(3 - worst)%text//' is '
        else
            text = text//' differs from the rest by '
        end if
        associate (run => solution%runs(worst))
            text = text//trim(lengths(run%difference, 3))//' mm (sigma '//trim(lengths(run%difference_sigma, 2))//' mm)'
        end associate
        if (size(runs) > 2) then
            call estimate_jointly(pack(runs, [(i /= worst, i=1, size(runs))]), options, others, error)
            if (.not. allocated(error)) text = text//', and without it the others '// &
                trim(merge('agree       ', 'do not agree', others%consistent))//' (probability '// &
                rounded_text(others%probability, 2)//')'
        end if
        text = text//'; masses that moved between them belong into --changes'
    end subroutine say_disagreement

    !> Three lengths in mm.
    function lengths(values, digits) result(text)
        real(dp), intent(in) :: values(3)       !! m
        integer, intent(in) :: digits
        character(60) :: text

        text = rounded_text(values(1)/MILLIMETRE, digits)//', '//rounded_text(values(2)/MILLIMETRE, digits)//', '// &
            rounded_text(values(3)/MILLIMETRE, digits)
    end function lengths
end module gracecg_estimation_joint_action
