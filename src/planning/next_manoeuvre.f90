!> What another calibration at the same place would give: all three rods, each at a frequency of its own, at the next passage.
module gracecg_planning_next_manoeuvre
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: rounded_text, integer_text
    use gracecg_environment_time, only: utc_text, utc_plus
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    use gracecg_simulation_limits, only: exceeds_limits
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_planning_candidates, only: pattern_567
    use gracecg_planning_observed_case, only: case_of_observations
    use gracecg_planning_planner, only: plan_request_t, plan_t, prepare_plan
    use gracecg_planning_site, only: manoeuvre_quality_t, evaluate_manoeuvre
    use gracecg_planning_usual_manoeuvre, only: usual_amplitude, usual_shares
    implicit none
    private
    public :: say_next_manoeuvre

contains

    !> Words for an operator: manoeuvre, time and the standard deviations that its bound promises. Nothing where that cannot be
    !> said: no orbit, no attitude, rods that are not known by amplitude, a motion beyond the limits; nor where it would be no
    !> better than what was flown.
    subroutine say_next_manoeuvre(observations, flown, text)
        type(observation_set_t), intent(in) :: observations
        real(dp), intent(in) :: flown(3)        !! Standard deviations of the offset by it, m; 0 on axes that need no other
        character(:), allocatable, intent(out) :: text      !! Without a full stop

        type(calibration_t) :: calibration
        type(plan_request_t) :: request
        type(plan_t) :: plan
        type(torque_rods_t) :: rods
        type(manoeuvre_quality_t) :: quality
        type(error_t), allocatable :: failure

        text = ''
        if (observations%knowledge%rods%count == 0) return
        request%settings%amplitude = usual_amplitude(observations%knowledge%rods)
        request%settings%share = usual_shares(observations%knowledge%rods)
        call case_of_observations(observations, calibration%case, failure)
        if (.not. allocated(failure)) call prepare_plan(calibration, request, plan, failure)
        if (allocated(failure)) return
        rods = pattern_567(request%settings, calibration%case%duration)
        call evaluate_manoeuvre(plan%arc, plan%sites(1), rods, quality)
        if (quality%is_seen() .and. .not. any(quality%sigma < flown)) return
        if (.not. quality%is_seen() .or. exceeds_limits(plan%arc%knowledge%limits, quality%motion)) return
        text = 'with rods x, y and z at '//rounded_text(rods%activations(1)%frequency, 3)//', '// &
            rounded_text(rods%activations(2)%frequency, 3)//' and '//rounded_text(rods%activations(3)%frequency, 3)// &
            ' Hz, '//rounded_text(request%settings%amplitude, 3)// &
            trim(merge(' N m  ', ' A m^2', observations%knowledge%rods%direct))//', for '// &
            integer_text(nint(calibration%case%duration))//' s at the next passage here ('// &
            utc_text(utc_plus(calibration%case%epoch, real(nint(plan%orbit%revolution), dp)))//' UTC): sigma by noise '// &
            'alone would be '// &
            rounded_text(quality%sigma(1)/MILLIMETRE, 2)//', '//rounded_text(quality%sigma(2)/MILLIMETRE, 2)//', '// &
            rounded_text(quality%sigma(3)/MILLIMETRE, 2)//' mm'
    end subroutine say_next_manoeuvre
end module gracecg_planning_next_manoeuvre
