!> The manoeuvres that a search tries: what it may do, and which are known to be good beforehand. That are rods that
!> share neither frequency nor phase, so that the angular acceleration does not keep one direction, and whole cycles,
!> which do not disturb each other. And the manoeuvre by which places are compared (usual_manoeuvre): that of a case's own
!> rods, with the signs that its rule gives the rods there, or as they are driven; of torquers that of the case.
module gracecg_planning_candidates
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: PI
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: integer_text
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_activation_t, new_torque_rods, check_rod_sampling, &
        SINE, TAPERED, MAX_DIPOLE, WAVEFORM_NAMES, take_manoeuvre, amplitude_at_start
    use gracecg_planning_site, only: planned_arc_t
    use gracecg_spacecraft_moment_series, only: has_moments
    use gracecg_spacecraft_rod_pattern, only: rod_pattern, AS_DRIVEN
    use gracecg_simulation_report_cases, only: ROD_FREQUENCY
    implicit none
    private
    public :: design_settings_t, candidate_t, check_design_settings, structured_candidates, neighbours, candidate_567, &
        allows_567, pattern_567, rods_of, usual_amplitude, usual_shares, usual_manoeuvre

    integer, parameter :: WIDEST = 4        !! Difference of two rods' cycles in the structured search
    integer, parameter :: MOST_LOWEST = 12  !! Lowest cycles of the structured search

    !> What the search may do.
    type :: design_settings_t
        logical :: rod_used(3) = .true.             !! Rods along body x, y, z
        real(dp) :: amplitude = MAX_DIPOLE          !! Of a rod, A m^2
        real(dp) :: share(3) = 1                    !! Of it that each rod has
        real(dp) :: lowest_frequency = 0.05_dp      !! Hz
        real(dp) :: highest_frequency = 0.2_dp      !! Hz
        logical :: waveform_used(4) = [.true., .false., .true., .true.]
        !! Sine, cosine (a sine with another phase), tapered, square
        real(dp) :: taper = 5                       !! Of tapered waveforms, s
        real(dp) :: rise_time = 1                   !! Of square waves, s
        integer :: refinement_steps = 120           !! Of the simplex method, for each of the best, 0 and more
        integer :: threads = 1                      !! Of the search, 1 to 1024
    end type design_settings_t

    !> A manoeuvre in the numbers that the search changes.
    type :: candidate_t
        integer :: waveform = SINE                  !! Of all rods
        real(dp) :: cycles(3) = 0                   !! During the arc, of each rod
        real(dp) :: phase(3) = 0                    !! rad
        real(dp) :: amplitude = 0                   !! A m^2, before its shares
    end type candidate_t

contains

    !> Fails for settings that allow no manoeuvre.
    subroutine check_design_settings(arc, settings, error)
        type(planned_arc_t), intent(in) :: arc
        type(design_settings_t), intent(in) :: settings
        type(error_t), allocatable, intent(out) :: error

        type(torque_rods_t) :: rods
        type(rod_activation_t) :: rod
        real(dp) :: duration
        integer :: waveform

        duration = arc%duration()
        if (.not. any(settings%rod_used)) then
            call fail(error, 'all torque rods are off: at least one has to be used')
        else if (.not. settings%amplitude > 0) then
            call fail(error, 'all torque rods are off: the amplitude is '//number_text(settings%amplitude)// &
                      ' A m^2, it has to be more than 0')
        else if (.not. any(settings%waveform_used)) then
            call fail(error, 'no waveform is allowed')
        else if (.not. settings%lowest_frequency > 0 .or. &
                 .not. settings%highest_frequency >= settings%lowest_frequency) then
            call fail(error, 'frequencies from '//number_text(settings%lowest_frequency)//' to '// &
                      number_text(settings%highest_frequency)//' Hz: the first has to be positive and at '// &
                      'most the second')
        else if (settings%refinement_steps < 0) then
            call fail(error, 'refinement_steps = '//integer_text(settings%refinement_steps)//': it must not be negative')
        else if (most_cycles(settings, duration) < fewest_cycles(settings, duration)) then
            call fail(error, 'frequencies from '//number_text(settings%lowest_frequency)//' to '// &
                      number_text(settings%highest_frequency)//' Hz leave no whole number of cycles in '// &
                      number_text(duration)//' s')
        end if
        do waveform = 1, size(WAVEFORM_NAMES)
            if (allocated(error)) return
            if (.not. settings%waveform_used(waveform)) cycle
            rod = rod_activation_t(axis=1, amplitude=settings%amplitude, &
                                   frequency=settings%highest_frequency, stop=duration, waveform=waveform, &
                                   taper=merge(settings%taper, 0.0_dp, waveform == TAPERED), &
                                   rise_time=settings%rise_time)
            call new_torque_rods([rod], rods, error, arc%knowledge%rods%largest_moment)
            if (.not. allocated(error)) call check_rod_sampling(rods, arc%interval, error)
        end do
    end subroutine check_design_settings

    pure integer function fewest_cycles(settings, duration) result(cycles)
        type(design_settings_t), intent(in) :: settings
        real(dp), intent(in) :: duration

        cycles = max(1, ceiling(settings%lowest_frequency*duration - 1e-9_dp))
    end function fewest_cycles

    pure integer function most_cycles(settings, duration) result(cycles)
        type(design_settings_t), intent(in) :: settings
        real(dp), intent(in) :: duration

        cycles = floor(settings%highest_frequency*duration + 1e-9_dp)
    end function most_cycles

    !> Whole numbers of cycles that differ by at most WIDEST, in every waveform, all rods starting
    !> as a sine or all as a cosine; where rods share a frequency, in all quarters of the period.
    function structured_candidates(arc, settings) result(candidates)
        type(planned_arc_t), intent(in) :: arc
        type(design_settings_t), intent(in) :: settings
        type(candidate_t), allocatable :: candidates(:)

        integer :: pass, n, waveform, x, y, z, low, high, step

        low = fewest_cycles(settings, arc%duration())
        high = most_cycles(settings, arc%duration())
        step = lowest_step(settings, arc%duration())
        do pass = 1, 2      ! count, then store
            n = 0
            do waveform = 1, size(settings%waveform_used)
                if (.not. settings%waveform_used(waveform)) cycle
                do x = low, merge(high, low, settings%rod_used(1))
                    do y = low, merge(high, low, settings%rod_used(2))
                        do z = low, merge(high, low, settings%rod_used(3))
                            if (is_tried([x, y, z])) call add_phases([x, y, z])
                        end do
                    end do
                end do
            end do
            if (pass == 1) allocate (candidates(n))
        end do

    contains

        pure logical function is_tried(cycles)
            integer, intent(in) :: cycles(3)

            associate (fewest => minval(cycles, mask=settings%rod_used), most => maxval(cycles, mask=settings%rod_used))
                is_tried = most - fewest <= WIDEST .and. modulo(fewest - low, step) == 0
            end associate
        end function is_tried

        subroutine add_phases(cycles)
            integer, intent(in) :: cycles(3)

            integer :: start, y_later, z_later

            do start = 0, 1
                do y_later = 0, merge(3, 0, shares(cycles, 2))
                    do z_later = 0, merge(3, 0, shares(cycles, 3))
                        n = n + 1
                        if (pass == 1) cycle
                        candidates(n) = candidate_t(waveform, real(cycles, dp), &
                                                    PI/2*modulo(start + [0, y_later, z_later], 4), settings%amplitude)
                    end do
                end do
            end do
        end subroutine add_phases

        !> Does a rod share its frequency with one before it, both in use?
        pure logical function shares(cycles, rod)
            integer, intent(in) :: cycles(3), rod

            shares = settings%rod_used(rod) .and. any(cycles(:rod - 1) == cycles(rod) .and. settings%rod_used(:rod - 1))
        end function shares
    end function structured_candidates

    !> From one lowest cycle of the structured search to the next: 1 where all are few enough.
    pure integer function lowest_step(settings, duration) result(step)
        type(design_settings_t), intent(in) :: settings
        real(dp), intent(in) :: duration        !! s

        step = 1 + (most_cycles(settings, duration) - fewest_cycles(settings, duration))/MOST_LOWEST
    end function lowest_step

    !> The candidates with all their cycles moved to where the structured search left some out, as far as the next
    !> one that it tried.
    function neighbours(arc, settings, candidates) result(moved)
        type(planned_arc_t), intent(in) :: arc
        type(design_settings_t), intent(in) :: settings
        type(candidate_t), intent(in) :: candidates(:)
        type(candidate_t), allocatable :: moved(:)

        type(candidate_t) :: candidate
        real(dp) :: duration
        integer :: i, shift, step

        allocate (moved(0))
        duration = arc%duration()
        step = lowest_step(settings, duration)
        do i = 1, size(candidates)
            do shift = 1 - step, step - 1
                candidate = candidates(i)
                candidate%amplitude = settings%amplitude
                where (settings%rod_used) candidate%cycles = candidate%cycles + shift
                if (shift == 0) cycle
                if (any(settings%rod_used .and. (nint(candidate%cycles) < fewest_cycles(settings, duration) .or. &
                                                 nint(candidate%cycles) > most_cycles(settings, duration)))) cycle
                moved = [moved, candidate]
            end do
        end do
    end function neighbours

    !> The manoeuvre of a candidate for an arc that starts at 0.
    pure function rods_of(settings, duration, candidate) result(rods)
        type(design_settings_t), intent(in) :: settings
        real(dp), intent(in) :: duration    !! Of the arc, s
        type(candidate_t), intent(in) :: candidate
        type(torque_rods_t) :: rods

        integer :: axis

        do axis = 1, 3
            if (.not. settings%rod_used(axis)) cycle
            rods%count = rods%count + 1
            associate (rod => rods%activations(rods%count))
                rod%axis = axis
                rod%amplitude = candidate%amplitude*settings%share(axis)
                rod%frequency = candidate%cycles(axis)/duration
                rod%phase = candidate%phase(axis)
                rod%stop = duration
                rod%waveform = candidate%waveform
                if (candidate%waveform == TAPERED) rod%taper = settings%taper
                rod%rise_time = settings%rise_time
            end associate
        end do
    end function rods_of

    !> Three rods at 5, 6 and 7 cycles in the arc, with the first allowed waveform.
    pure function pattern_567(settings, duration) result(rods)
        type(design_settings_t), intent(in) :: settings
        real(dp), intent(in) :: duration        !! s
        type(torque_rods_t) :: rods

        rods = rods_of(settings, duration, candidate_567(settings))
    end function pattern_567

    !> 5, 6 and 7 cycles in the arc, with the first allowed waveform.
    pure type(candidate_t) function candidate_567(settings) result(candidate)
        type(design_settings_t), intent(in) :: settings

        candidate = candidate_t(findloc(settings%waveform_used, .true., 1), [5.0_dp, 6.0_dp, 7.0_dp], &
                                amplitude=settings%amplitude)
    end function candidate_567

    !> Are 5, 6 and 7 cycles of all rods allowed?
    pure logical function allows_567(settings, duration) result(allows)
        type(design_settings_t), intent(in) :: settings
        real(dp), intent(in) :: duration        !! s

        allows = all(settings%rod_used) .and. 5 >= fewest_cycles(settings, duration) .and. &
                 7 <= most_cycles(settings, duration)
    end function allows_567

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

    !> That amplitude on the rods that a rule chooses, in the waveform, at the frequency and for as long as the strongest
    !> activation of the rods; where nothing is commanded, the report's sine over the whole arc. Torquers, and rods as driven,
    !> do there what the case has them do. Fails as `new_torque_rods` does.
    subroutine usual_manoeuvre(rods, rule, field, from, duration, manoeuvre, error)
        type(torque_rods_t), intent(in) :: rods
        character(*), intent(in) :: rule        !! One of PATTERN_RULES
        real(dp), intent(in) :: field(3)        !! At the start, body axes, T
        real(dp), intent(in) :: from, duration  !! Of the arc, s
        type(torque_rods_t), intent(out) :: manoeuvre   !! Of rods with the same gain, directions and delay
        type(error_t), allocatable, intent(out) :: error

        type(rod_activation_t) :: activations(3)
        type(torque_rods_t) :: driven
        integer :: pattern(3)

        if (rods%direct .or. (rule == AS_DRIVEN .and. rods%count > 0)) then
            manoeuvre = rods
            manoeuvre%activations%start = from + rods%activations%start
            manoeuvre%activations%stop = from + rods%activations%stop
            if (has_moments(rods%measured)) manoeuvre%measured%time = from + rods%measured%time
            return
        end if
        activations = rod_activation_t(frequency=ROD_FREQUENCY, stop=duration)
        if (rods%count > 0) activations = rods%activations(maxloc(abs(rods%activations(:rods%count)%amplitude), 1))
        activations%axis = [1, 2, 3]
        pattern = rod_pattern(rule, field)
        activations%amplitude = pattern*usual_amplitude(rods)
        activations%start = from + activations%start
        activations%stop = from + activations%stop
        call new_torque_rods(pack(activations, pattern /= 0), driven, error, rods%largest_moment)
        manoeuvre = rods
        call take_manoeuvre(driven, manoeuvre)
    end subroutine usual_manoeuvre
end module gracecg_planning_candidates
