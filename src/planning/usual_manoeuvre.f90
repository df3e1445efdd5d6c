!> The manoeuvre by which places are compared: that of a case's own rods, with the signs that its rule gives the rods there;
!> of torquers that of the case.
module gracecg_planning_usual_manoeuvre
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_spacecraft_moment_series, only: has_moments
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_activation_t, new_torque_rods, take_manoeuvre, &
        amplitude_at_start
    use gracecg_simulation_report_cases, only: ROD_FREQUENCY
    implicit none
    private
    public :: usual_amplitude, usual_shares, usual_manoeuvre

contains

    !> What rods are driven to: the greatest sum of amplitudes on one rod; where nothing is commanded, the greatest moment
    !> that was measured, or what they bear. A m^2.
    pure real(dp) function usual_amplitude(rods) result(amplitude)
        type(torque_rods_t), intent(in) :: rods

        integer :: i

        amplitude = maxval([0.0_dp, (amplitude_at_start(rods, i), i=1, rods%count)])
        if (has_moments(rods%measured) .and. .not. amplitude > 0) amplitude = maxval(abs(rods%measured%moment))
        if (.not. amplitude > 0) amplitude = rods%largest_moment
    end function usual_amplitude

    !> What each rod has of that amplitude: all of it; torquers, which turn moments of inertia of their own, as much as the case
    !> drives them, where it does.
    pure function usual_shares(rods) result(share)
        type(torque_rods_t), intent(in) :: rods
        real(dp) :: share(3)

        integer :: i

        share = 1
        if (.not. rods%direct .or. rods%count == 0) return
        share = 0
        do i = 1, rods%count
            share(rods%activations(i)%axis) = max(share(rods%activations(i)%axis), amplitude_at_start(rods, i))
        end do
        share = share/usual_amplitude(rods)
        where (.not. share > 0) share = 1
    end function usual_shares

    !> That amplitude on the rods of a pattern, in the waveform, at the frequency and for as long as the strongest activation
    !> of the rods; where nothing is commanded, the report's sine over the whole arc. Fails as `new_torque_rods` does.
    subroutine usual_manoeuvre(rods, pattern, from, duration, manoeuvre, error)
        type(torque_rods_t), intent(in) :: rods
        integer, intent(in) :: pattern(3)       !! -1, 0 or 1 for each rod
        real(dp), intent(in) :: from, duration  !! Of the arc, s
        type(torque_rods_t), intent(out) :: manoeuvre   !! Of rods with the same gain, directions and delay
        type(error_t), allocatable, intent(out) :: error

        type(rod_activation_t) :: activations(3)
        type(torque_rods_t) :: driven

        if (rods%direct) then
            manoeuvre = rods
            manoeuvre%activations%start = from + rods%activations%start
            manoeuvre%activations%stop = from + rods%activations%stop
            if (has_moments(rods%measured)) manoeuvre%measured%time = from + rods%measured%time
            return
        end if
        activations = rod_activation_t(frequency=ROD_FREQUENCY, stop=duration)
        if (rods%count > 0) activations = rods%activations(maxloc(abs(rods%activations(:rods%count)%amplitude), 1))
        activations%axis = [1, 2, 3]
        activations%amplitude = pattern*usual_amplitude(rods)
        activations%start = from + activations%start
        activations%stop = from + activations%stop
        call new_torque_rods(driven, pack(activations, pattern /= 0), error, rods%largest_moment)
        manoeuvre = rods
        call take_manoeuvre(driven, manoeuvre)
    end subroutine usual_manoeuvre
end module gracecg_planning_usual_manoeuvre
