!> Which wrong belief explains the data best, once some belief is contradicted: the hypotheses are fitted, one after
!> the other, and compared by the likelihood that they give to the data.
!>
!> A score tells near its fit which belief is wrong. Of a belief that is far off, or that has no value (which axis is
!> which, a sign, a convention), only a fit under the other belief tells: its gain of log-likelihood is half of what
!> the weighted squares of the residuals fall. A wrong noise level gains chi^2/2 - nu/2 (1 + ln(chi^2/nu)). Hypotheses
!> whose gains differ by less than SAME cannot be told apart by the data and are named together.
!>
!> Alterations, and values far off from a grid, are fitted coarsely first, and the most likely of them fully. In a long
!> arc this is done in its beginning, in which the rods have turned a few times; the most likely of what is found are
!> then fitted to the whole.
module gracecg_estimation_explanation
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_observations_arc_of_run, only: arc_of_run, without_moments
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_options, only: estimation_options_t, WAVE_GIVEN, WAVE_SEARCHED
    use gracecg_observations_parameters, only: ROD_GAINS, ROD_GAIN, ROD_DELAYS, ALL_RODS_DELAY, ROD_FREQUENCIES, &
        ALL_RODS_FREQUENCY, ACCELEROMETER_TURN, FIELD_TURN, FIELD_SHEARS, FIELD_BIAS, FIELD_SCALES, MOUNTING_1, MOUNTING_2, &
        largest_error
    use gracecg_estimation_belief, only: ALTERATIONS, apply_value, apply_alteration, &
        is_interchange
    use gracecg_estimation_belief_report, only: belief_report_t, explanation_t, noise_test_t, CONTRADICTED, OF_VALUE, &
        OF_ALTERATION, OF_NOISE, FIELD_AGAINST_MODEL, HEADS_APART
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_optimal, only: estimate_optimal
    implicit none
    private
    public :: explain, confirm_contradictions

    real(dp), parameter :: SAME = 7             !! Of log-likelihoods: one is a thousand times as likely as the other
    real(dp), parameter :: BEYOND_DOUBT = 8     !! Score of a contradiction that no fit need confirm
    integer, parameter :: MOST_CANDIDATES = 10  !! Beliefs with a value whose fits are tried
    integer, parameter :: MOST_STEPS = 6        !! Of such a fit
    real(dp), parameter :: SETTLED = 0.05_dp    !! Of a step, in standard deviations, that ends it
    real(dp), parameter :: FREQUENCY_RANGE = 0.25_dp    !! Of the rods', relative, that is searched
    real(dp), parameter :: SEARCHED = 60        !! From when the first rod acts: the part of an arc that is searched, s
    integer, parameter :: SHORTLIST = 6         !! Alterations tried; hypotheses found in this part that are fitted to the whole
    real(dp), parameter :: HOPELESS = 10        !! Times what the best alteration leaves, by coarse fits
    real(dp), parameter :: WORST = 1e12_dp      !! Weighted squares that stand for a fit that failed
    real(dp), parameter :: HOPE = 3     !! Times the gain that a score promises, beyond which no fit is expected to come

contains

    !> Whether fits bear out the scores that contradict a value: a score is what the likelihood gains if the fit is as
    !> straight as its partials, which it is not where a partial has the offset in it, and that is badly known. The
    !> likelihood is looked at with the value found, with half and with a quarter of it, and the score becomes that
    !> of its largest gain (S. S. Wilks, Ann. Math. Statist. 9 (1938) 60-62). Where a test is beyond doubt nothing is done:
    !> there is a contradiction.
    subroutine confirm_contradictions(observations, options, misfit, report)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        real(dp), intent(in) :: misfit      !! Of the fit that is tested; 0 when it is not known
        type(belief_report_t), intent(inout) :: report

        type(observation_set_t) :: other
        type(solution_t) :: solution
        type(error_t), allocatable :: error
        real(dp) :: value, left, gain
        integer :: i, k

        if (.not. misfit > 0 .or. .not. report%has_contradiction()) return
        if (any(abs(report%values%score) > BEYOND_DOUBT) .or. any(report%noises%state == CONTRADICTED)) return
        do i = 1, size(report%values)
            if (report%values(i)%state /= CONTRADICTED) cycle
            associate (test => report%values(i))
                gain = 0
                value = test%value
                do k = 1, 3
                    other = observations
                    call apply_value(test%belief, value, other, noise_follows=.true.)
                    call refit(other, without_tests(options), solution, left, error)
                    left = left + left_by_lost(observations, other)
                    gain = max(gain, (misfit - left)/2)
                    if (2*gain > report%critical**2 .or. test%all_or_nothing) exit
                    value = value/2
                end do
                call report%take_score(i, sign(min(sqrt(2*gain), abs(test%score)), test%score))
            end associate
        end do
    end subroutine confirm_contradictions

    !> Explanations of what contradicts the operator's beliefs, the most likely first: those that cannot be told
    !> apart from it. None if the fits of all others fail.
    subroutine explain(observations, options, fitted, misfit, explanations)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(belief_report_t), intent(in) :: fitted         !! Of the fit that is contradicted
        real(dp), intent(in) :: misfit
        !! Its weighted squares; huge(1.0) when it failed
        type(explanation_t), allocatable, intent(out) :: explanations(:)

        type(explanation_t), allocatable :: found(:)
        type(noise_test_t), allocatable :: noises(:)
        integer, allocatable :: order(:)
        type(estimation_options_t) :: coarse
        real(dp) :: part
        integer :: i

        allocate (found(0))
        associate (rods => observations%knowledge%rods)
            part = SEARCHED
            if (rods%count > 0) part = part + max(0.0_dp, minval(rods%activations(:rods%count)%start))
        end associate
        noises = pack(fitted%noises, fitted%noises%state == CONTRADICTED .and. fitted%noises%gain > 0)
        if (size(noises) > 0) then      ! all levels that are off together, named by the worst
            i = maxloc(noises%gain, 1)
            found = [found, explanation_t(kind=OF_NOISE, place=noises(i)%subject, gain=sum(noises%gain), &
                                          value=noises(i)%factor, offset=fitted%offset)]
        end if
        coarse = coarse_options(options, fitted)
        call try_values(observations, options, fitted, misfit, found)
        call try_side()
        if (observations%knowledge%duration > 2*part) then
            call search_part(observations, options, part, misfit, found)
        else
            call try_alterations(observations, options, coarse, misfit, found)
            call examine_alterations(observations, options, found)
            call try_far_values(observations, options, coarse, misfit, found)
        end if
        call try_relatives(observations, options, misfit, found)
        order = by_gain(found%gain)
        explanations = found(order)
        if (size(found) > 0) explanations = pack(explanations, explanations%gain > explanations(1)%gain - SAME .and. &
                                                               explanations%gain > 0)

    contains

        !> A bias or a scale factor of the magnetometer where the field is not that of the model, a turn of a star-camera head
        !> where heads are apart.
        subroutine try_side()
            integer :: axis

            associate (seen => fitted%field_seen, modelled => fitted%field_modelled, turn => fitted%head_turn)
                axis = maxloc(abs(seen - modelled), 1)
                if (is_contradicted(FIELD_AGAINST_MODEL)) then
                    call try_value(observations, options, FIELD_BIAS(axis), seen(axis) - modelled(axis), misfit, found)
                    call try_value(observations, options, FIELD_SCALES(axis), 1 - modelled(axis)/seen(axis), misfit, found)
                end if
                axis = maxloc(abs(turn), 1)
                if (is_contradicted(HEADS_APART)) then
                    call try_value(observations, options, MOUNTING_1(axis), -turn(axis), misfit, found)
                    call try_value(observations, options, MOUNTING_2(axis), turn(axis), misfit, found)
                end if
            end associate
        end subroutine try_side

        pure logical function is_contradicted(subject)
            integer, intent(in) :: subject      !! Of the noises

            is_contradicted = any(fitted%noises%subject == subject .and. fitted%noises%state == CONTRADICTED)
        end function is_contradicted
    end subroutine explain

    !> Places of numbers, the largest first.
    pure function by_gain(gain) result(order)
        real(dp), intent(in) :: gain(:)
        integer :: order(size(gain))

        logical :: left(size(gain))
        integer :: i

        left = .true.
        do i = 1, size(gain)
            order(i) = maxloc(gain, 1, left)
            left(order(i)) = .false.
        end do
    end function by_gain

    !> Hypotheses that are the most likely in the beginning of an arc, fitted to the whole. Those that are tried
    !> already are left out.
    subroutine search_part(observations, options, length, misfit, found)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        real(dp), intent(in) :: length      !! Of the beginning, s
        real(dp), intent(in) :: misfit      !! Of the whole
        type(explanation_t), allocatable, intent(inout) :: found(:)

        type(observation_set_t) :: part
        type(solution_t) :: solution
        type(error_t), allocatable :: error
        type(explanation_t), allocatable :: likely(:)
        type(estimation_options_t) :: coarse
        integer, allocatable :: order(:)
        real(dp) :: part_misfit
        integer :: i

        call arc_of_run(observations, without_moments(observations%knowledge), 0.0_dp, length, part)
        call refit(part, options, solution, part_misfit, error)
        part_misfit = min(part_misfit, WORST)
        allocate (likely(0))
        coarse = coarse_options(options, belief_report_t())
        if (allocated(solution%beliefs)) then
            coarse = coarse_options(options, solution%beliefs)
            call try_values(part, options, solution%beliefs, part_misfit, likely)
        end if
        call try_far_values(part, options, coarse, part_misfit, likely)
        call try_alterations(part, options, coarse, part_misfit, likely)
        order = by_gain(likely%gain)
        do i = 1, min(SHORTLIST, size(order))
            associate (one => likely(order(i)))
                if (any(found%kind == one%kind .and. found%place == one%place)) cycle
                if (one%kind == OF_ALTERATION) then
                    call try_alteration(observations, options, one%place, misfit, found)
                else
                    call try_value(observations, options, one%place, one%value, misfit, found)
                end if
            end associate
        end do
        call examine_alterations(observations, options, found)
    end subroutine search_part

    !> The beliefs with a value whose scores are largest.
    subroutine try_values(observations, options, fitted, misfit, found)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(belief_report_t), intent(in) :: fitted
        real(dp), intent(in) :: misfit
        type(explanation_t), allocatable, intent(inout) :: found(:)

        integer, allocatable :: order(:)
        integer :: i, parameter

        order = by_gain(abs(fitted%values%score))
        do i = 1, min(MOST_CANDIDATES, size(order))
            if (fitted%values(order(i))%state /= CONTRADICTED) exit
            parameter = fitted%values(order(i))%belief
            if (is_interchange(parameter)) cycle    ! among the alterations
            call try_value(observations, options, fitted%values(order(i))%belief, 0.0_dp, misfit, found)
        end do
    end subroutine try_values

    !> Values from all over their range where no step leads to them from 0: a frequency of the rods that is off by a cycle
    !> of the arc, and, if nothing so far explains all, axes that are turned by tens of degrees, or that far from square.
    subroutine try_far_values(observations, options, coarse, misfit, found)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options, coarse
        real(dp), intent(in) :: misfit
        type(explanation_t), allocatable, intent(inout) :: found(:)

        real(dp), parameter :: FAR(7) = [-0.6_dp, -0.4_dp, -0.2_dp, 0.0_dp, 0.2_dp, 0.4_dp, 0.6_dp]    ! rad, or ratio
        integer, parameter :: FAR_OFF(*) = [ACCELEROMETER_TURN, FIELD_TURN, FIELD_SHEARS]
        real(dp), allocatable :: frequencies(:)
        integer :: i, steps

        associate (rods => observations%knowledge%rods, step => 0.25_dp/observations%knowledge%duration)
            associate (acts => rods%activations(:rods%count))
                steps = ceiling(FREQUENCY_RANGE*maxval([0.0_dp, acts%frequency])/step)
                frequencies = [(step*i, i=-steps, steps)]
                call try_best(ALL_RODS_FREQUENCY, frequencies)
                do i = 1, 3
                    if (any(acts%axis == i) .and. any(acts%axis /= i)) call try_best(ROD_FREQUENCIES(i), frequencies)
                end do
            end associate
        end associate
        if (any(found%complete)) return
        do i = 1, size(FAR_OFF)
            call try_best(FAR_OFF(i), FAR)
        end do

    contains

        !> A belief from that of some equidistant values which leaves least, or from the vertex of the parabola there: where
        !> noise is mixed, it is the noise that tells.
        subroutine try_best(parameter, values)
            integer, intent(in) :: parameter
            real(dp), intent(in) :: values(:)

            real(dp) :: left(size(values)), best, curvature, at_vertex
            integer :: k

            do k = 1, size(values)
                left(k) = left_by(parameter, values(k))
            end do
            k = minloc(left, 1)
            best = values(k)
            if (k > 1 .and. k < size(values) .and. left(k) < WORST) then
                curvature = left(k - 1) - 2*left(k) + left(k + 1)
                if (curvature > 0 .and. curvature < WORST) then
                    at_vertex = values(k) + (values(k + 1) - values(k))*(left(k - 1) - left(k + 1))/(2*curvature)
                    if (left_by(parameter, at_vertex) < left(k)) best = at_vertex
                end if
            end if
            call try_value(observations, options, parameter, best, misfit, found)
        end subroutine try_best

        !> What a coarse fit leaves; a full one where the accelerometer is turned: the wave that the contradicted fit has
        !> found may not be there in axes that are right.
        real(dp) function left_by(parameter, value) result(left)
            integer, intent(in) :: parameter
            real(dp), intent(in) :: value

            type(observation_set_t) :: other
            type(solution_t) :: solution
            type(error_t), allocatable :: error

            other = observations
            call apply_value(parameter, value, other)
            if (any(ACCELEROMETER_TURN == parameter)) then
                call refit(other, without_tests(options), solution, left, error)
            else
                left = coarse_misfit(other, coarse)
            end if
        end function left_by
    end subroutine try_far_values

    !> Of a value of one rod, or of all, that explains as much as anything: the other rods' and that of all, from there.
    !> Where one rod does nearly all, what is of it and what is of all is the same to the data.
    subroutine try_relatives(observations, options, misfit, found)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        real(dp), intent(in) :: misfit
        type(explanation_t), allocatable, intent(inout) :: found(:)

        integer, parameter :: FAMILIES(4, 3) = reshape([ROD_GAINS, ROD_GAIN, ROD_DELAYS, ALL_RODS_DELAY, ROD_FREQUENCIES, &
                                                        ALL_RODS_FREQUENCY], [4, 3])
        type(explanation_t), allocatable :: best(:)
        integer :: i, k, family, belief

        best = found
        if (size(found) > 0) best = pack(found, found%kind == OF_VALUE .and. found%gain > maxval(found%gain) - SAME)
        do i = 1, size(best)
            do family = 1, size(FAMILIES, 2)
                if (.not. any(FAMILIES(:, family) == best(i)%place)) cycle
                do k = 1, size(FAMILIES, 1)
                    belief = FAMILIES(k, family)
                    if (any(found%kind == OF_VALUE .and. found%place == belief .and. found%gain > best(i)%gain - SAME)) cycle
                    call try_value(observations, options, belief, best(i)%value, misfit, found)
                end do
            end do
        end do
    end subroutine try_relatives

    !> Fits a belief with a value by Newton's steps from a first value.
    subroutine try_value(observations, options, belief, first, misfit, found)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        integer, intent(in) :: belief
        real(dp), intent(in) :: first
        real(dp), intent(in) :: misfit
        type(explanation_t), allocatable, intent(inout) :: found(:)

        type(explanation_t) :: tried
        type(observation_set_t) :: other
        type(solution_t) :: solution
        type(error_t), allocatable :: error
        real(dp) :: left
        integer :: step, i

        tried%kind = OF_VALUE
        tried%place = belief
        tried%gain = -huge(1.0_dp)
        tried%value = first
        do step = 1, MOST_STEPS
            other = observations
            call apply_value(belief, tried%value, other, noise_follows=.true.)
            call refit(other, options, solution, left, error)
            if (.not. allocated(solution%beliefs)) exit
            left = left + left_by_lost(observations, other)
            i = findloc(solution%beliefs%values%belief, belief, 1)
            if (i == 0) exit
            associate (test => solution%beliefs%values(i))
                if ((misfit - left)/2 > tried%gain .and. left < huge(1.0_dp)) then
                    tried%gain = (misfit - left)/2
                    tried%sigma = test%sigma
                    tried%fitted = tried%value
                    tried%offset = solution%offset
                    tried%complete = .not. solution%beliefs%has_contradiction()
                end if
                if (.not. test%sigma > 0 .or. abs(test%value) < SETTLED*test%sigma) exit
                if (left < huge(1.0_dp) .and. (misfit - left)/2 + HOPE*(test%value/test%sigma)**2/2 < &
                    maxval([0.0_dp, found%gain]) - SAME) exit       ! another belief explains more
                tried%value = tried%value + test%value
                if (abs(tried%value) > largest_error(belief)) exit
            end associate
        end do
        tried%value = tried%fitted
        if (tried%gain > 0) found = [found, tried]
    end subroutine try_value

    !> What the epochs of the accelerometer that a delay has lost would leave in the mean: fits are compared by the same
    !> number of samples.
    pure real(dp) function left_by_lost(observations, other) result(left)
        type(observation_set_t), intent(in) :: observations     !! As they are
        type(observation_set_t), intent(in) :: other            !! Under a belief

        left = 3*(size(observations%accelerometer_time) - size(other%accelerometer_time))
    end function left_by_lost

    !> The alterations that leave least, by a coarse fit of each.
    subroutine try_alterations(observations, options, coarse, misfit, found)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options, coarse
        real(dp), intent(in) :: misfit
        type(explanation_t), allocatable, intent(inout) :: found(:)

        type(observation_set_t) :: other
        real(dp) :: left(size(ALTERATIONS))
        integer :: order(size(ALTERATIONS)), i

        do i = 1, size(ALTERATIONS)
            other = observations
            call apply_alteration(i, other)
            left(i) = coarse_misfit(other, coarse)
        end do
        order = by_gain(-left)
        do i = 1, SHORTLIST
            if (left(order(i)) > HOPELESS*left(order(1))) exit
            call try_alteration(observations, options, order(i), misfit, found)
        end do
    end subroutine try_alterations

    !> What a coarse fit leaves: huge(1.0) when it fails.
    real(dp) function coarse_misfit(observations, options) result(misfit)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options

        type(solution_t) :: solution
        type(error_t), allocatable :: error

        call estimate_optimal(observations, options, solution, error, once=.true.)
        misfit = huge(1.0)
        if (solution%misfit > 0) misfit = min(misfit, solution%misfit)
    end function coarse_misfit

    subroutine try_alteration(observations, options, alteration, misfit, found)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        integer, intent(in) :: alteration       !! Place in ALTERATIONS
        real(dp), intent(in) :: misfit
        type(explanation_t), allocatable, intent(inout) :: found(:)

        type(observation_set_t) :: other
        type(solution_t) :: solution
        type(error_t), allocatable :: error
        real(dp) :: left

        other = observations
        call apply_alteration(alteration, other)
        call refit(other, without_tests(options), solution, left, error)
        if (.not. left < misfit) return
        found = [found, explanation_t(kind=OF_ALTERATION, place=alteration, gain=(misfit - left)/2, offset=solution%offset)]
    end subroutine try_alteration

    !> Whether the alterations that may be the best explanation leave nothing contradicted.
    subroutine examine_alterations(observations, options, found)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(explanation_t), intent(inout) :: found(:)

        type(observation_set_t) :: other
        type(solution_t) :: solution
        type(error_t), allocatable :: error
        real(dp) :: left
        integer :: i

        do i = 1, size(found)
            if (found(i)%kind /= OF_ALTERATION .or. found(i)%gain < maxval(found%gain) - SAME) cycle
            other = observations
            call apply_alteration(found(i)%place, other)
            call refit(other, options, solution, left, error)
            if (allocated(solution%beliefs)) found(i)%complete = .not. solution%beliefs%has_contradiction()
        end do
    end subroutine examine_alterations

    !> Options of coarse fits: the density wave, if the contradicted fit had found one, with its frequency.
    pure function coarse_options(options, fitted) result(coarse)
        type(estimation_options_t), intent(in) :: options
        type(belief_report_t), intent(in) :: fitted
        type(estimation_options_t) :: coarse

        coarse = without_tests(options)
        if (coarse%optimal%density_wave /= WAVE_SEARCHED .or. .not. fitted%wave_frequency > 0) return
        coarse%optimal%density_wave = WAVE_GIVEN
        coarse%optimal%density_wave_period = 1/fitted%wave_frequency
    end function coarse_options

    !> Options of a fit whose beliefs are not tested.
    pure function without_tests(options) result(fewer)
        type(estimation_options_t), intent(in) :: options
        type(estimation_options_t) :: fewer

        fewer = options
        fewer%test_beliefs = .false.
        fewer%covariance = .false.      ! nor is the fit checked
    end function without_tests

    !> The fit under another belief. What it leaves: huge(1.0) when it fails altogether.
    subroutine refit(observations, options, solution, misfit, error)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(out) :: solution
        real(dp), intent(out) :: misfit
        type(error_t), allocatable, intent(out) :: error

        call estimate_optimal(observations, options, solution, error)
        misfit = huge(1.0_dp)
        if (solution%converged .and. solution%misfit > 0) misfit = solution%misfit
    end subroutine refit
end module gracecg_estimation_explanation
