!> Is an arc short enough for estimators that follow the rotation from its initial state, and an estimate one that a
!> satellite can have?
module gracecg_estimation_plausibility
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, DEGREE, MILLIMETRE
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: append, rounded_text
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_solution, only: solution_t
    implicit none
    private
    public :: judge_plausibility, refuse_implausible, refuse_long_arc, longest_arc

    real(dp), parameter :: SIGMAS = 5       !! Of an estimate that may still belong to a plausible offset
    real(dp), parameter :: MOST_ACCELERATION = 1e-3_dp      !! m/s^2: biases are 1e-5, forces 1e-6
    real(dp), parameter :: MOST_DRIFT = 2.5e-3_dp
    !! rad. Found with front 1, its rods on all the time: ASSEST and `optimal` still follow an arc of 900 s (a drift of
    !! 1.9e-3 by sigma_torque's default), none of 1200 s (3.4e-3); ASSEST of 2400 s gives a wrong offset with a small sigma

contains

    !> Of the estimate of a run: refuses an implausible one, if its covariance is propagated, and tells of accelerations of
    !> another unit, as a warning or in the error.
    subroutine judge_plausibility(observations, options, solution, error)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(inout) :: error      !! Of the estimate

        character(:), allocatable :: text

        if (options%covariance .and. solution%converged .and. .not. allocated(error)) &
            call refuse_implausible(solution%algorithm, solution%offset, solution%covariance, options%largest_offset, error)
        if (.not. allocated(observations%acceleration)) return
        associate (samples => observations%acceleration)
            if (2*count(maxval(abs(samples), 1) > MOST_ACCELERATION) <= size(samples, 2)) return
            text = 'accelerations reach '//rounded_text(maxval(abs(samples)), 2)//' m/s^2, a hundred times what such an '// &
                   'instrument shows: are they in m/s^2?'
        end associate
        if (allocated(error)) then
            error%message = error%message//'; '//text
        else
            call append(solution%warnings, text)
        end if
    end subroutine judge_plausibility

    !> Mass and accelerometer of such a satellite are balanced to a millimetre: an offset beyond a centimetre
    !> tells of wrong units, axes or times, unless the noise alone can make it. To be asked of one's own
    !> observations: a study of a weak manoeuvre may well find such offsets.
    subroutine refuse_implausible(algorithm, offset, covariance, largest, error)
        character(*), intent(in) :: algorithm   !! That estimated it
        real(dp), intent(in) :: offset(3), covariance(3, 3)     !! Of an estimate that has converged, m, m^2
        real(dp), intent(in) :: largest         !! Of each component, m: largest_offset of the options
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: beyond(3)                   ! m
        integer :: axis

        beyond = [(abs(offset(axis)) - SIGMAS*sqrt(covariance(axis, axis)), axis=1, 3)]
        axis = maxloc(beyond, 1)
        if (beyond(axis) <= largest) return
        call fail(error, algorithm//': the CG offset on '//AXES(axis)//' would be '// &
                  number_text(offset(axis)/MILLIMETRE)//' mm; beyond '//number_text(largest/MILLIMETRE)// &
                  ' mm it is not plausible: check units, axes and time tags of the samples and the rods of the setup, or '// &
                  'raise largest_offset_mm of the group estimation of the options')
    end subroutine refuse_implausible

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
end module gracecg_estimation_plausibility
