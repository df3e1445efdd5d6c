!> The planner: the manoeuvre whose worst axis is best, at one place of the orbit or at several, under the
!> limits of rods, rate and pointing.
!>
!> Whole numbers of cycles are tried that differ little, with quarter-period phases where rods share a frequency, in
!> every waveform; the best are refined in frequency and phase by the simplex method of J. A. Nelder and R. Mead
!> (Computer Journal 7 (1965) 308-313). Nothing is random: the result does not depend on threads.
!>
!> How good a manoeuvre is changes with its frequency as rods, noise and density wave do, slowly, and with the
!> difference of the rods' cycles, cycle by cycle. So all differences are tried, but in a long arc not all lowest
!> cycles: MOST_LOWEST of them, and around the best then all that were left out. A search takes as long as the
!> arc, not its square.
!>
!> The many of the structured search are judged on a thinned arc where the arc is long: at QUICK_SAMPLES epochs, no
!> further apart than the edges and periods of the rods' moments allow. The PROMISING_COUNT best of them, and all
!> that come after, are judged at every sample.
module gracecg_planning_design
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_progress, only: progress_t, tell, expect_pieces, piece_done
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, dipole_moments, TAPERED, SQUARE
    use gracecg_simulation_dynamics, only: RATE => OMEGA
    use gracecg_simulation_limits, only: exceeds_limits, check_motion
    use gracecg_planning_site, only: planned_arc_t, manoeuvre_site_t, manoeuvre_quality_t, evaluate_manoeuvre, &
        evaluate_moments, thin_arc, thin_site
    use gracecg_planning_candidates, only: design_settings_t, candidate_t, check_design_settings, &
        structured_candidates, neighbours, candidate_567, allows_567, rods_of
    implicit none
    private
    public :: manoeuvre_design_t, design_manoeuvre, judge_manoeuvre, choose_place

    !> A judged manoeuvre.
    type :: manoeuvre_design_t
        type(torque_rods_t) :: rods                 !! Times count from the start of the calibration
        real(dp) :: sigma(3) = huge(1.0_dp)         !! Limit of every axis, the worst of the places, m
        real(dp) :: wave(3) = 0                     !! Error by the density wave likewise, m
        real(dp) :: force(3) = 0                    !! Error by curved drag and radiation likewise, m
        real(dp) :: rate = 0                        !! Greatest angular velocity, rad/s
        real(dp) :: excursion = 0                   !! Greatest turn from the nominal attitude, rad
        real(dp) :: worst = huge(1.0_dp)
        !! Greatest sqrt(sigma^2 + wave^2 + force^2) of axes and places, m
        real(dp) :: beyond = huge(1.0_dp)
        !! Rate or excursion in units of its limit, the greater; huge(1.0) where a direction is unseen
        logical :: allowed = .false.                !! Within the limits at all places
        integer :: evaluations = 0                  !! Of a manoeuvre at a place, for the whole search
    end type manoeuvre_design_t

    !> Candidates to be judged, as pieces of work.
    type, extends(parallel_work_t) :: judging_t
        type(planned_arc_t), pointer :: arc => null()
        type(manoeuvre_site_t), pointer :: sites(:) => null()
        type(design_settings_t) :: settings
        type(candidate_t), allocatable :: candidates(:)
        integer :: most_places = 0                  !! To judge one at
        logical :: refined = .false.                !! By the simplex method before they are judged
        type(manoeuvre_design_t), allocatable :: judged(:)
    contains
        procedure :: do_one => judge_one
    end type judging_t

    !> What the structured search judges at.
    type :: quick_look_t
        type(planned_arc_t), pointer :: arc => null()           !! Given or thinned
        type(manoeuvre_site_t), pointer :: sites(:) => null()   !! With the samples of that arc
        type(planned_arc_t) :: thinned_arc
        type(manoeuvre_site_t), allocatable :: thinned_sites(:)
    end type quick_look_t

    ! The search is a funnel: many manoeuvres are looked at coarsely, fewer and fewer of them closely. How many go on
    ! weighs the time of a search against the risk that the best is lost on the way.
    integer, parameter :: PROMISING_COUNT = 240     !! Judged at every sample after a look at fewer
    integer, parameter :: WIDENED_COUNT = 6     !! Whose lowest cycle is looked at more closely where some were left out
    integer, parameter :: FINAL_COUNT = 24      !! Judged at all places
    integer, parameter :: REFINED_COUNT = 6     !! Refined: what takes most of the time
    integer, parameter :: SEARCH_PLACES = 6
    !! Of the structured search, spread over all places: over a revolution one every 60 degrees, so that both poles and the
    !! equator are near one
    integer, parameter :: REFINE_PLACES = 12    !! Likewise of the simplex method, one every 30 degrees
    integer, parameter :: QUICK_SAMPLES = 1200
    !! Of the structured search, where the moments allow so few: twice those of the report's arc of 60 s at 10 Hz
    integer, parameter :: CHOSEN_COUNT = 3      !! Manoeuvres of each of SEARCH_PLACES that are tried at all places
    integer, parameter :: SCALINGS = 3          !! Attempts to bring a manoeuvre into its limits
    real(dp), parameter :: BELOW_LIMIT = 0.98_dp
    !! Of the amplitude that would just keep a limit: rate and turn are not quite proportional to it

contains

    !> A look at manoeuvres that takes less time: with fewer samples where they are more than QUICK_SAMPLES, else with
    !> those of the arc itself. Fails as thin_arc does.
    subroutine new_quick_look(arc, sites, settings, look, error)
        type(planned_arc_t), intent(in), target :: arc
        type(manoeuvre_site_t), intent(in), target :: sites(:)
        type(design_settings_t), intent(in) :: settings
        type(quick_look_t), intent(out), target :: look
        type(error_t), allocatable, intent(out) :: error

        ! from one epoch to the next, at most: ten epochs a period, and one within every edge
        real(dp), parameter :: OF_PERIOD = 0.1_dp, OF_EDGE = 0.5_dp
        real(dp) :: longest
        integer :: samples, i

        look%arc => arc
        look%sites => sites
        longest = OF_PERIOD/settings%highest_frequency
        if (settings%waveform_used(SQUARE)) longest = min(longest, OF_EDGE*settings%rise_time)
        if (settings%waveform_used(TAPERED)) longest = min(longest, OF_EDGE*settings%taper)
        samples = max(QUICK_SAMPLES, ceiling(arc%duration()/longest - 1e-9_dp))
        if (samples >= arc%samples) return
        call thin_arc(arc, samples, look%thinned_arc, error)
        if (allocated(error)) return
        allocate (look%thinned_sites(size(sites)))
        do i = 1, size(sites)
            call thin_site(arc, sites(i), look%thinned_arc, look%thinned_sites(i))
        end do
        look%arc => look%thinned_arc
        look%sites => look%thinned_sites
    end subroutine new_quick_look

    !> The best manoeuvre for the worst axis at all given places. It is at least as good as that with
    !> 5, 6 and 7 cycles on the three rods, in the limit of the worst axis as well as with the errors
    !> by drag and radiation, when that is allowed.
    !>
    !> Fails as check_design_settings does, and when no manoeuvre stays within the limits.
    subroutine design_manoeuvre(arc, sites, settings, design, error, progress)
        type(planned_arc_t), intent(in), target :: arc
        type(manoeuvre_site_t), intent(in), target :: sites(:)
        type(design_settings_t), intent(in) :: settings
        type(manoeuvre_design_t), intent(out) :: design
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the manoeuvres looked at

        type(candidate_t), allocatable :: candidates(:), finalists(:)
        type(candidate_t) :: cycles_567
        type(manoeuvre_design_t), allocatable :: judged(:), refined(:), near(:)
        type(manoeuvre_design_t) :: pattern
        type(quick_look_t), target :: look
        integer, allocatable :: order(:)
        integer :: i, spent

        call check_design_settings(arc, settings, error)
        if (.not. allocated(error)) call new_quick_look(arc, sites, settings, look, error)
        if (allocated(error)) return
        candidates = structured_candidates(arc, settings)
        call tell(progress, 'search, stage 1 of 3')
        call judge_all(look%arc, look%sites, settings, candidates, SEARCH_PLACES, judged, error, progress)
        if (allocated(error)) return
        spent = sum(judged%evaluations)
        if (allocated(look%thinned_sites)) then
            order = best_first(judged, PROMISING_COUNT)
            candidates = candidates(order)
            call judge_all(arc, sites, settings, candidates, SEARCH_PLACES, judged, error, progress)
            if (allocated(error)) return
            spent = spent + sum(judged%evaluations)
        end if
        order = best_first(judged, WIDENED_COUNT)
        finalists = neighbours(arc, settings, candidates(order))
        if (size(finalists) > 0) then
            call judge_all(arc, sites, settings, finalists, SEARCH_PLACES, near, error, progress)
            if (allocated(error)) return
            spent = spent + sum(near%evaluations)
            candidates = [candidates, finalists]
            judged = [judged, near]
        end if
        order = best_first(judged, FINAL_COUNT)
        finalists = candidates(order)
        call tell(progress, 'search, stage 2 of 3')
        call judge_all(arc, sites, settings, finalists, size(sites), judged, error, progress)
        if (allocated(error)) return
        spent = spent + sum(judged%evaluations)
        order = best_first(judged, REFINED_COUNT)
        finalists = finalists(order)
        design = judged(order(1))
        call tell(progress, 'search, stage 3 of 3')
        call judge_all(arc, sites, settings, finalists, size(sites), refined, error, progress, refine_first=.true.)
        if (allocated(error)) return
        cycles_567 = candidate_567(settings)
        call judge(arc, sites, settings, cycles_567, size(sites), pattern)
        pattern%allowed = pattern%allowed .and. allows_567(settings, arc%duration())
        spent = spent + sum(refined%evaluations) + pattern%evaluations
        do i = 1, size(finalists)
            if (better(refined(i), design)) design = refined(i)
        end do
        ! at least as good as 5, 6, 7 cycles, also in the noise alone
        if (pattern%allowed .and. maxval(design%sigma) > maxval(pattern%sigma)) then
            design = pattern
            judged = [judged, refined]
            do i = 1, size(judged)
                if (maxval(judged(i)%sigma) <= maxval(pattern%sigma) .and. better(judged(i), design)) &
                    design = judged(i)
            end do
        end if
        design%evaluations = spent
        if (design%allowed) return
        call refuse(arc, sites, design, error)
    end subroutine design_manoeuvre

    !> Says which limit no manoeuvre keeps.
    subroutine refuse(arc, sites, design, error)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(in) :: sites(:)
        type(manoeuvre_design_t), intent(in) :: design
        type(error_t), allocatable, intent(out) :: error

        type(manoeuvre_quality_t) :: quality
        integer :: i

        do i = 1, size(sites)
            call evaluate_manoeuvre(arc, sites(i), design%rods, quality)
            call check_motion(arc%knowledge%limits, quality%motion, error)
            if (.not. allocated(error)) cycle
            error%message = 'no manoeuvre stays within the limits, not even a weaker one. The best: '// &
                error%message
            return
        end do
        call fail(error, 'no manoeuvre shows all components of the offset: more rods, other frequencies or '// &
                  'a longer arc are needed')
    end subroutine refuse

    !> Does `a` come before `b`: allowed before not allowed, then the better worst axis; of those that are not
    !> allowed the one that is less beyond the limits?
    pure logical function better(a, b)
        type(manoeuvre_design_t), intent(in) :: a, b

        if (a%allowed .neqv. b%allowed) then
            better = a%allowed
        else if (a%allowed) then
            better = a%worst < b%worst
        else
            better = a%beyond < b%beyond
        end if
    end function better

    !> Numbers of the best designs, at most `most`, best first; of equals the first.
    pure function best_first(designs, most) result(order)
        type(manoeuvre_design_t), intent(in) :: designs(:)
        integer, intent(in) :: most
        integer, allocatable :: order(:)

        logical :: taken(size(designs))
        integer :: i, k, best

        allocate (order(min(most, size(designs))))
        taken = .false.
        do k = 1, size(order)
            best = 0
            do i = 1, size(designs)
                if (taken(i)) cycle
                if (best == 0) then
                    best = i
                else if (better(designs(i), designs(best))) then
                    best = i
                end if
            end do
            order(k) = best
            taken(best) = .true.
        end do
    end function best_first

    subroutine judge_all(arc, sites, settings, candidates, most_places, judged, error, progress, refine_first)
        type(planned_arc_t), intent(in), target :: arc
        type(manoeuvre_site_t), intent(in), target :: sites(:)
        type(design_settings_t), intent(in) :: settings
        type(candidate_t), intent(in) :: candidates(:)
        integer, intent(in) :: most_places
        type(manoeuvre_design_t), allocatable, intent(out) :: judged(:)
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the manoeuvres looked at
        logical, intent(in), optional :: refine_first   !! By the simplex method; no when absent

        type(judging_t) :: work

        work%arc => arc
        work%sites => sites
        work%settings = settings
        work%candidates = candidates
        work%most_places = most_places
        if (present(refine_first)) work%refined = refine_first
        allocate (work%judged(size(candidates)))
        call expect_pieces(progress, size(candidates), 'manoeuvres')
        call run_parallel(work, size(candidates), settings%threads, error, progress)
        call move_alloc(work%judged, judged)
    end subroutine judge_all

    subroutine judge_one(self, i, error)
        class(judging_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(candidate_t) :: candidate
        integer :: spent

        candidate = self%candidates(i)
        spent = 0
        if (self%refined) call refine(self%arc, self%sites, self%settings, candidate, spent)
        call judge(self%arc, self%sites, self%settings, candidate, self%most_places, self%judged(i))
        self%judged(i)%evaluations = self%judged(i)%evaluations + spent
    end subroutine judge_one

    !> Judges a candidate at no more than `most_places` places, spread over all. Where it goes beyond
    !> the limits, its amplitude is lowered; what stays beyond them is not weighed.
    subroutine judge(arc, sites, settings, candidate, most_places, design)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(in) :: sites(:)
        type(design_settings_t), intent(in) :: settings
        type(candidate_t), intent(inout) :: candidate
        integer, intent(in) :: most_places
        type(manoeuvre_design_t), intent(out) :: design

        real(dp), dimension(3, 0:2*arc%samples) :: dipole
        integer :: attempt, spent, i
        real(dp) :: nominal, factor

        spent = 0
        call dipole_moments(rods_of(settings, arc%duration(), candidate), arc%interval/2, dipole)
        do attempt = 0, SCALINGS
            call judge_moments(arc, sites, dipole, most_places, .true., design)
            design%rods = rods_of(settings, arc%duration(), candidate)
            design%rods%direct = arc%knowledge%rods%direct
            spent = spent + design%evaluations
            if (design%allowed) exit
            ! what the manoeuvre adds to rate and turn is proportional to its amplitude
            nominal = maxval([(norm2(sites(i)%state(RATE)), i=1, size(sites))])
            factor = 1
            if (design%rate > arc%knowledge%limits%rate) then
                if (nominal >= arc%knowledge%limits%rate) exit
                factor = (arc%knowledge%limits%rate - nominal)/(design%rate - nominal)
            end if
            if (design%excursion > arc%knowledge%limits%pointing) &
                factor = min(factor, arc%knowledge%limits%pointing/design%excursion)
            candidate%amplitude = BELOW_LIMIT*factor*candidate%amplitude
            dipole = BELOW_LIMIT*factor*dipole
        end do
        design%evaluations = spent
    end subroutine judge

    !> Judges a manoeuvre at no more than `most_places` places, spread over all: the worst of them.
    subroutine judge_manoeuvre(arc, sites, rods, most_places, design)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(in) :: sites(:)
        type(torque_rods_t), intent(in) :: rods
        integer, intent(in) :: most_places    !! At most so many of the places are tried
        type(manoeuvre_design_t), intent(out) :: design

        real(dp) :: dipole(3, 0:2*arc%samples)

        call dipole_moments(rods, arc%interval/2, dipole)
        call judge_moments(arc, sites, dipole, most_places, .false., design)
        design%rods = rods
    end subroutine judge_manoeuvre

    !> The same of the rods' moments, all but what rods they are of.
    pure subroutine judge_moments(arc, sites, dipole, most_places, within_limits, design)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(in) :: sites(:)
        real(dp), intent(in) :: dipole(:, 0:)           ! at every half interval, A m^2
        integer, intent(in) :: most_places
        logical, intent(in) :: within_limits            ! of what goes beyond them only the motion is told
        type(manoeuvre_design_t), intent(out) :: design

        type(manoeuvre_quality_t) :: quality
        integer :: i, k, places

        places = min(most_places, size(sites))
        design%sigma = 0
        design%worst = 0
        design%beyond = 0
        design%allowed = .true.
        design%evaluations = places
        do k = 1, places
            i = 1 + ((k - 1)*size(sites))/places
            call evaluate_moments(arc, sites(i), dipole, within_limits, quality)
            design%sigma = max(design%sigma, quality%sigma)
            design%wave = max(design%wave, quality%wave)
            design%force = max(design%force, quality%force)
            design%rate = max(design%rate, quality%motion%rate)
            design%excursion = max(design%excursion, quality%motion%excursion)
            design%beyond = max(design%beyond, quality%motion%rate/arc%knowledge%limits%rate, &
                                quality%motion%excursion/arc%knowledge%limits%pointing)
            if (quality%is_seen()) then
                design%worst = max(design%worst, maxval(hypot(hypot(quality%sigma, quality%wave), &
                                                              quality%force)))
            else
                design%worst = huge(1.0_dp)
                design%allowed = .false.
            end if
            if (exceeds_limits(arc%knowledge%limits, quality%motion)) then
                design%allowed = .false.
            else if (.not. quality%is_seen()) then
                design%beyond = huge(1.0_dp)
            end if
        end do
    end subroutine judge_moments

    !> The simplex method over cycles and phases of the rods in use, from a candidate. The phase of the
    !> first rod is changed too: what a rod does at the start and the end of the arc depends on it.
    subroutine refine(arc, sites, settings, candidate, evaluations)
        type(planned_arc_t), intent(in) :: arc
        type(manoeuvre_site_t), intent(in) :: sites(:)
        type(design_settings_t), intent(in) :: settings
        type(candidate_t), intent(inout) :: candidate
        integer, intent(out) :: evaluations

        integer, parameter :: N = 6
        ! Of the first simplex: a fifth of what separates whole cycles; rad, a quarter of the quarter period that separates
        ! the phases tried before
        real(dp), parameter :: CYCLE_STEP = 0.2_dp, PHASE_STEP = 0.4_dp
        real(dp) :: vertex(N, 0:N), value(0:N), centre(N), trial(N), trial_value, further(N), further_value
        type(candidate_t) :: start
        integer :: i, step, worst, best

        evaluations = 0
        start = candidate
        vertex(:, 0) = [candidate%cycles, candidate%phase]
        do i = 1, N
            vertex(:, i) = vertex(:, 0)
            vertex(i, i) = vertex(i, i) + merge(CYCLE_STEP, PHASE_STEP, i <= 3)
        end do
        do i = 0, N
            value(i) = objective(vertex(:, i))
        end do
        do step = 1, settings%refinement_steps
            worst = maxloc(value, 1) - 1
            best = minloc(value, 1) - 1
            centre = (sum(vertex, 2) - vertex(:, worst))/N
            trial = 2*centre - vertex(:, worst)
            trial_value = objective(trial)
            if (trial_value < value(best)) then
                further = 3*centre - 2*vertex(:, worst)
                further_value = objective(further)
                if (further_value < trial_value) then
                    trial = further
                    trial_value = further_value
                end if
            else if (trial_value >= second_worst()) then
                if (trial_value < value(worst)) then
                    further = (centre + trial)/2
                else
                    further = (centre + vertex(:, worst))/2
                end if
                further_value = objective(further)
                if (further_value < min(trial_value, value(worst))) then
                    trial = further
                    trial_value = further_value
                else if (trial_value >= value(worst)) then
                    do i = 0, N
                        if (i == best) cycle
                        vertex(:, i) = (vertex(:, i) + vertex(:, best))/2
                        value(i) = objective(vertex(:, i))
                    end do
                    cycle
                end if
            end if
            vertex(:, worst) = trial
            value(worst) = trial_value
        end do
        best = minloc(value, 1) - 1
        candidate = candidate_at(vertex(:, best))

    contains

        real(dp) function second_worst()
            real(dp) :: others(0:N)

            others = value
            others(worst) = -huge(1.0_dp)
            second_worst = maxval(others)
        end function second_worst

        function candidate_at(x) result(at)
            real(dp), intent(in) :: x(N)
            type(candidate_t) :: at

            at = start
            at%cycles = x(1:3)
            at%phase = modulo(x(4:6), TWO_PI)
        end function candidate_at

        !> The worst axis; huge outside of the frequencies allowed and beyond the limits.
        real(dp) function objective(x)
            real(dp), intent(in) :: x(N)

            type(manoeuvre_design_t) :: design
            real(dp) :: frequency(3), dipole(3, 0:2*arc%samples)

            objective = huge(1.0_dp)
            frequency = x(1:3)/(arc%duration())
            if (any(settings%rod_used .and. (frequency < settings%lowest_frequency .or. &
                                             frequency > settings%highest_frequency))) return
            call dipole_moments(rods_of(settings, arc%duration(), candidate_at(x)), arc%interval/2, dipole)
            call judge_moments(arc, sites, dipole, REFINE_PLACES, .true., design)
            evaluations = evaluations + design%evaluations
            if (design%allowed) objective = design%worst
        end function objective
    end subroutine refine

    !> The place where a calibration can be best: that with the least worst axis under the best of the
    !> few manoeuvres whose rods have different cycles or share them in all combinations of signs.
    subroutine choose_place(arc, sites, settings, best, error, progress)
        type(planned_arc_t), intent(in), target :: arc
        type(manoeuvre_site_t), intent(in), target :: sites(:)
        type(design_settings_t), intent(in) :: settings
        integer, intent(out) :: best                !! In sites
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress      !! Counts the places

        type(candidate_t), allocatable :: candidates(:), chosen(:)
        type(manoeuvre_design_t), allocatable :: judged(:)
        type(manoeuvre_design_t) :: at_place(size(sites))
        type(quick_look_t), target :: look
        integer, allocatable :: order(:)
        integer :: i, k

        best = 1
        call check_design_settings(arc, settings, error)
        if (.not. allocated(error)) call new_quick_look(arc, sites, settings, look, error)
        if (allocated(error)) return
        ! what is good at a few places one by one is good at others too
        candidates = structured_candidates(arc, settings)
        allocate (chosen(0))
        call tell(progress, 'choice of the place')
        call expect_pieces(progress, SEARCH_PLACES + size(sites), 'places')
        do k = 1, SEARCH_PLACES
            i = 1 + ((k - 1)*size(sites))/SEARCH_PLACES
            call judge_all(look%arc, look%sites(i:i), settings, candidates, 1, judged, error)
            if (allocated(error)) return
            order = best_first(judged, CHOSEN_COUNT)
            chosen = [chosen, candidates(order)]
            call piece_done(progress)
        end do
        do i = 1, size(sites)
            call judge_all(look%arc, look%sites(i:i), settings, chosen, 1, judged, error)
            if (allocated(error)) return
            order = best_first(judged, 1)
            at_place(i) = judged(order(1))
            call piece_done(progress)
        end do
        order = best_first(at_place, 1)
        best = order(1)
    end subroutine choose_place
end module gracecg_planning_design
