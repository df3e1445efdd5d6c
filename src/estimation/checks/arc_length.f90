!> Whether an arc is short enough for estimators that follow the rotation from its initial state.
module gracecg_estimation_arc_length
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: rounded_text
    use gracecg_observations_knowledge, only: operator_knowledge_t
    implicit none
    private
    public :: refuse_long_arc, longest_arc

    real(dp), parameter :: MOST_DRIFT = 2.5e-3_dp
    !! rad. Found with front 1, its rods on all the time: ASSEST and `optimal` still follow an arc of 900 s (a drift of
    !! 1.9e-3 by sigma_torque's default), none of 1200 s (3.4e-3); ASSEST of 2400 s gives a wrong offset with a small sigma

contains

    !> Fails when a torque that nobody models may turn the satellite, during the arc, farther than the fits hold, which
    !> are linear about a rotation without noise of the state. A torque that grows steadily to s in a time T turns the
    !> smallest moment of inertia I by s T^2/(6 I).
    subroutine refuse_long_arc(knowledge, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: longest

        longest = longest_arc(knowledge)
        if (.not. knowledge%duration > longest) return
        call fail(error, 'the arc of '//rounded_text(knowledge%duration, 4)//' s is too long: rotation is followed '// &
                  'from its initial state, without state noise, and torques that nobody models, of '// &
                  rounded_text(knowledge%a_priori%sigma_torque, 3)//' N m (sigma_torque of &a_priori), turn the satellite by '// &
                  rounded_text(MOST_DRIFT*(knowledge%duration/longest)**2/DEGREE, 3)//' deg in it; the fits hold to '// &
                  rounded_text(MOST_DRIFT/DEGREE, 3)//' deg, '//rounded_text(longest, 4)//' s. gracecg estimate '// &
                  '--algorithm optimal takes such a run in arcs and joins them; level1 estimate takes files of hours')
    end subroutine refuse_long_arc

    !> The longest arc that is not refused, s.
    pure real(dp) function longest_arc(knowledge) result(duration)
        type(operator_knowledge_t), intent(in) :: knowledge

        real(dp) :: smallest
        integer :: i

        smallest = minval([(knowledge%inertia(i, i), i=1, 3)])
        duration = huge(duration)
        if (knowledge%a_priori%sigma_torque > 0 .and. smallest > 0) &
            duration = sqrt(6*smallest*MOST_DRIFT/knowledge%a_priori%sigma_torque)
    end function longest_arc
end module gracecg_estimation_arc_length
