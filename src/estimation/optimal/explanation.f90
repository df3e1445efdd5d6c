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
    use gracecg_base_statistics, only: order_of
    use gracecg_observations_arc_of_run, only: arc_of_run, without_moments
    use gracecg_observations_observation_set, only: observation_set_t, check_observations
    use gracecg_estimation_options, only: estimation_options_t, WAVE_GIVEN, WAVE_SEARCHED
    use gracecg_observations_parameters, only: ROD_GAINS, ROD_GAIN, ROD_DELAYS, ALL_RODS_DELAY, ROD_FREQUENCIES, &
        ALL_RODS_FREQUENCY, ACCELEROMETER_TURN, FIELD_TURN, FIELD_SHEARS, FIELD_BIAS, FIELD_SCALES, MOUNTING_1, MOUNTING_2, &
        INTERCHANGES, LARGEST_ERROR
    use gracecg_estimation_belief, only: ALTERATIONS, OF_QUATERNIONS, apply_value, apply_alteration, is_possible
    use gracecg_estimation_belief_report, only: belief_report_t, explanation_t, noise_test_t, CONTRADICTED, OF_VALUE, &
        OF_ALTERATION, OF_NOISE, FIELD_AGAINST_MODEL, HEADS_APART, SAME
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_optimal, only: estimate_optimal
    implicit none
    private
    public :: explain, explain_failure, confirm_contradictions

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

    !> A search for explanations.
    type :: search_t
        type(observation_set_t) :: observations     !! In which
        type(estimation_options_t) :: options, coarse   !! Of fits, and of coarse ones
        real(dp) :: misfit = 0                      !! Weighted squares of the fit that is contradicted
        type(explanation_t), allocatable :: found(:)
    end type search_t

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

        type(solution_t) :: solution
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
                    call fit_under(OF_VALUE, test%belief, value, observations, without_tests(options), solution, left)
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

        type(search_t) :: search
        type(noise_test_t), allocatable :: noises(:)
        real(dp) :: part
        integer :: i

        call begin_search(observations, options, fitted, misfit, search)
        associate (rods => observations%knowledge%rods)
            part = SEARCHED
            if (rods%count > 0) part = part + max(0.0_dp, minval(rods%activations(:rods%count)%start))
        end associate
        noises = pack(fitted%noises, fitted%noises%state == CONTRADICTED .and. fitted%noises%gain > 0)
        if (size(noises) > 0) then      ! all levels that are off together, named by the worst
            i = maxloc(noises%gain, 1)
            search%found = [explanation_t(kind=OF_NOISE, place=noises(i)%subject, gain=sum(noises%gain), &
                                          value=noises(i)%factor, offset=fitted%offset)]
        end if
        call try_values(fitted, search)
        call try_side()
        if (observations%knowledge%duration > 2*part) then
            call search_part(part, search)
        else
            call try_alterations(search)
            call examine_alterations(search)
            call try_far_values(search)
        end if
        call try_relatives(search)
        associate (found => search%found)
            explanations = found(order_of(-found%gain))
        end associate
        if (size(explanations) > 0) explanations = pack(explanations, explanations%gain > explanations(1)%gain - SAME .and. &
                                                                      explanations%gain > 0)

    contains

        !> A bias or a scale factor of the magnetometer where the field is not that of the model, a turn of a star-camera head
        !> where heads are apart.
        subroutine try_side()
            integer :: axis

            associate (seen => fitted%field_seen, modelled => fitted%field_modelled, turn => fitted%head_turn)
                axis = maxloc(abs(seen - modelled), 1)
                if (is_contradicted(FIELD_AGAINST_MODEL)) then
                    call try_value(FIELD_BIAS(axis), seen(axis) - modelled(axis), search)
                    call try_value(FIELD_SCALES(axis), 1 - modelled(axis)/seen(axis), search)
                end if
                axis = maxloc(abs(turn), 1)
                if (is_contradicted(HEADS_APART)) then
                    call try_value(MOUNTING_1(axis), -turn(axis), search)
                    call try_value(MOUNTING_2(axis), turn(axis), search)
                end if
            end associate
        end subroutine try_side

        pure logical function is_contradicted(subject)
            integer, intent(in) :: subject      !! Of the noises

            is_contradicted = any(fitted%noises%subject == subject .and. fitted%noises%state == CONTRADICTED)
        end function is_contradicted
    end subroutine explain

    !> Of a fit that failed, so that no belief could be tested: whether the quaternions mean something else by which the data can
    !> be fitted and contradict nothing.
    subroutine explain_failure(observations, options, text)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        character(:), allocatable, intent(out) :: text      !! Empty if there is no explanation

        type(observation_set_t) :: others(size(OF_QUATERNIONS))
        type(error_t), allocatable :: invalid       ! there is nothing to be fitted
        type(solution_t) :: solution
        real(dp) :: left(size(OF_QUATERNIONS)), misfit
        integer :: i

        text = ''
        call check_observations(observations, invalid)
        if (allocated(invalid)) return
        others = observations
        do i = 1, size(others)
            call apply_alteration(OF_QUATERNIONS(i), others(i))
            left(i) = coarse_misfit(others(i), without_tests(options))
        end do
        i = minloc(left, 1)
        if (.not. left(i) < WORST) return
        call refit(others(i), options, solution, misfit)
        if (.not. allocated(solution%beliefs) .or. .not. misfit < WORST) return
        if (.not. solution%beliefs%has_contradiction()) text = 'the data fit if '//trim(ALTERATIONS(OF_QUATERNIONS(i)))
    end subroutine explain_failure

    !> A search in which nothing is found yet. In coarse fits a density wave that the contradicted fit had found has its
    !> frequency.
    subroutine begin_search(observations, options, fitted, misfit, search)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(belief_report_t), intent(in) :: fitted
        real(dp), intent(in) :: misfit
        type(search_t), intent(out) :: search

        search%observations = observations
        search%options = options
        search%misfit = misfit
        allocate (search%found(0))
        search%coarse = without_tests(options)
        if (options%optimal%density_wave /= WAVE_SEARCHED .or. .not. fitted%wave_frequency > 0) return
        search%coarse%optimal%density_wave = WAVE_GIVEN
        search%coarse%optimal%density_wave_period = 1/fitted%wave_frequency
    end subroutine begin_search

    !> Hypotheses that are the most likely in the beginning of an arc, fitted to the whole. Those that are tried
    !> already are left out.
    subroutine search_part(length, search)
        real(dp), intent(in) :: length      !! Of the beginning, s
        type(search_t), intent(inout) :: search

        type(search_t) :: part
        type(observation_set_t) :: beginning
        type(solution_t) :: solution
        integer, allocatable :: order(:)
        real(dp) :: misfit
        integer :: i

        associate (whole => search%observations)
            call arc_of_run(whole, without_moments(whole%knowledge), 0.0_dp, length, beginning)
        end associate
        call refit(beginning, search%options, solution, misfit)
        if (allocated(solution%beliefs)) then
            call begin_search(beginning, search%options, solution%beliefs, min(misfit, WORST), part)
            call try_values(solution%beliefs, part)
        else
            call begin_search(beginning, search%options, belief_report_t(), min(misfit, WORST), part)
        end if
        call try_far_values(part)
        call try_alterations(part)
        order = order_of(-part%found%gain)
        do i = 1, min(SHORTLIST, size(order))
            associate (one => part%found(order(i)))
                if (any(search%found%kind == one%kind .and. search%found%place == one%place)) cycle
                if (one%kind == OF_ALTERATION) then
                    call try_alteration(one%place, search)
                else
                    call try_value(one%place, one%value, search)
                end if
            end associate
        end do
        call examine_alterations(search)
    end subroutine search_part

    !> The beliefs with a value that are contradicted most.
    subroutine try_values(fitted, search)
        type(belief_report_t), intent(in) :: fitted
        type(search_t), intent(inout) :: search

        integer, allocatable :: order(:)
        integer :: i

        order = order_of(-abs(fitted%values%fair))
        do i = 1, min(MOST_CANDIDATES, size(order))
            associate (test => fitted%values(order(i)))
                if (test%state /= CONTRADICTED) exit
                if (all(INTERCHANGES /= test%belief)) call try_value(test%belief, 0.0_dp, search)  ! else among the alterations
            end associate
        end do
    end subroutine try_values

    !> Values from all over their range where no step leads to them from 0: a frequency of the rods that is off by a cycle
    !> of the arc, and, if nothing so far explains all, axes that are turned by tens of degrees, or that far from square.
    subroutine try_far_values(search)
        type(search_t), intent(inout) :: search

        real(dp), parameter :: FAR(7) = [-0.6_dp, -0.4_dp, -0.2_dp, 0.0_dp, 0.2_dp, 0.4_dp, 0.6_dp]    ! rad, or ratio
        integer, parameter :: FAR_OFF(*) = [ACCELEROMETER_TURN, FIELD_TURN, FIELD_SHEARS]
        real(dp), allocatable :: frequencies(:)
        integer :: i, steps

        associate (rods => search%observations%knowledge%rods, step => 0.25_dp/search%observations%knowledge%duration)
            associate (acts => rods%activations(:rods%count))
                steps = ceiling(FREQUENCY_RANGE*maxval([0.0_dp, acts%frequency])/step)
                frequencies = [(step*i, i=-steps, steps)]
                call try_best(ALL_RODS_FREQUENCY, frequencies)
                do i = 1, 3
                    if (any(acts%axis == i) .and. any(acts%axis /= i)) call try_best(ROD_FREQUENCIES(i), frequencies)
                end do
            end associate
        end associate
        if (any(search%found%complete)) return
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
            call try_value(parameter, best, search)
        end subroutine try_best

        !> What a coarse fit leaves; a full one where the accelerometer is turned: the wave that the contradicted fit has
        !> found may not be there in axes that are right.
        real(dp) function left_by(parameter, value) result(left)
            integer, intent(in) :: parameter
            real(dp), intent(in) :: value

            type(observation_set_t) :: other
            type(solution_t) :: solution

            other = search%observations
            call apply_value(parameter, value, other)
            if (any(ACCELEROMETER_TURN == parameter)) then
                call refit(other, without_tests(search%options), solution, left)
            else
                left = coarse_misfit(other, search%coarse)
            end if
        end function left_by
    end subroutine try_far_values

    !> Of a value of one rod, or of all, that explains as much as anything: the other rods' and that of all, from there.
    !> Where one rod does nearly all, what is of it and what is of all is the same to the data.
    subroutine try_relatives(search)
        type(search_t), intent(inout) :: search

        integer, parameter :: FAMILIES(4, 3) = reshape([ROD_GAINS, ROD_GAIN, ROD_DELAYS, ALL_RODS_DELAY, ROD_FREQUENCIES, &
                                                        ALL_RODS_FREQUENCY], [4, 3])
        type(explanation_t), allocatable :: best(:)
        integer :: i, k, family, belief

        best = search%found
        if (size(best) > 0) best = pack(best, best%kind == OF_VALUE .and. best%gain > maxval(best%gain) - SAME)
        do i = 1, size(best)
            do family = 1, size(FAMILIES, 2)
                if (.not. any(FAMILIES(:, family) == best(i)%place)) cycle
                do k = 1, size(FAMILIES, 1)
                    belief = FAMILIES(k, family)
                    associate (found => search%found)
                        if (any(found%kind == OF_VALUE .and. found%place == belief .and. found%gain > best(i)%gain - SAME)) cycle
                    end associate
                    call try_value(belief, best(i)%value, search)
                end do
            end do
        end do
    end subroutine try_relatives

    !> Fits a belief with a value by Newton's steps from a first value.
    subroutine try_value(belief, first, search)
        integer, intent(in) :: belief
        real(dp), intent(in) :: first
        type(search_t), intent(inout) :: search

        type(explanation_t) :: tried
        type(solution_t) :: solution
        real(dp) :: left, value
        integer :: step, i

        tried = explanation_t(kind=OF_VALUE, place=belief, gain=-huge(1.0_dp))
        value = first
        do step = 1, MOST_STEPS
            call fit_under(OF_VALUE, belief, value, search%observations, search%options, solution, left)
            if (.not. allocated(solution%beliefs)) exit
            i = findloc(solution%beliefs%values%belief, belief, 1)
            if (i == 0) exit
            associate (test => solution%beliefs%values(i), gain => (search%misfit - left)/2)
                if (gain > tried%gain .and. left < huge(1.0_dp)) then
                    tried%gain = gain
                    tried%value = value
                    tried%sigma = test%sigma
                    tried%offset = solution%offset
                    tried%complete = .not. solution%beliefs%has_contradiction()
                end if
                if (.not. test%sigma > 0 .or. abs(test%value) < SETTLED*test%sigma) exit
                if (left < huge(1.0_dp) .and. gain + HOPE*(test%value/test%sigma)**2/2 < &
                    maxval([0.0_dp, search%found%gain]) - SAME) exit        ! another belief explains more
                value = value + test%value
                if (abs(value) > LARGEST_ERROR(belief)) exit
            end associate
        end do
        if (.not. is_possible(belief, tried%value, search%observations%knowledge)) return
        if (tried%gain > 0) search%found = [search%found, tried]
    end subroutine try_value

    !> The alterations that leave least, by a coarse fit of each.
    subroutine try_alterations(search)
        type(search_t), intent(inout) :: search

        type(observation_set_t) :: other
        real(dp) :: left(size(ALTERATIONS))
        integer :: order(size(ALTERATIONS)), i

        do i = 1, size(ALTERATIONS)
            other = search%observations
            call apply_alteration(i, other)
            left(i) = coarse_misfit(other, search%coarse)
        end do
        order = order_of(left)
        do i = 1, SHORTLIST
            if (left(order(i)) > HOPELESS*left(order(1))) exit
            call try_alteration(order(i), search)
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

    subroutine try_alteration(alteration, search)
        integer, intent(in) :: alteration       !! Place in ALTERATIONS
        type(search_t), intent(inout) :: search

        type(solution_t) :: solution
        real(dp) :: left

        call fit_under(OF_ALTERATION, alteration, 0.0_dp, search%observations, without_tests(search%options), solution, left)
        if (left < search%misfit) search%found = [search%found, explanation_t(kind=OF_ALTERATION, place=alteration, &
                                                                              gain=(search%misfit - left)/2, &
                                                                              offset=solution%offset)]
    end subroutine try_alteration

    !> Whether the alterations that may be the best explanation leave nothing contradicted.
    subroutine examine_alterations(search)
        type(search_t), intent(inout) :: search

        type(solution_t) :: solution
        real(dp) :: left
        integer :: i

        do i = 1, size(search%found)
            associate (one => search%found(i))
                if (one%kind /= OF_ALTERATION .or. one%gain < maxval(search%found%gain) - SAME) cycle
                call fit_under(OF_ALTERATION, one%place, 0.0_dp, search%observations, search%options, solution, left)
                if (allocated(solution%beliefs)) one%complete = .not. solution%beliefs%has_contradiction()
            end associate
        end do
    end subroutine examine_alterations

    !> Options of a fit whose beliefs are not tested.
    pure function without_tests(options) result(fewer)
        type(estimation_options_t), intent(in) :: options
        type(estimation_options_t) :: fewer

        fewer = options
        fewer%test_beliefs = .false.
        fewer%covariance = .false.      ! nor is the fit checked
    end function without_tests

    !> The fit under another belief. Epochs of the accelerometer that a delay loses count as they would in the mean: fits are
    !> compared by the same number of samples.
    subroutine fit_under(kind, place, value, observations, options, solution, left)
        integer, intent(in) :: kind, place      !! OF_VALUE, a parameter; or OF_ALTERATION, a place in ALTERATIONS
        real(dp), intent(in) :: value           !! Of a parameter, SI units
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(out) :: solution
        real(dp), intent(out) :: left           !! Weighted squares

        type(observation_set_t) :: other

        other = observations
        if (kind == OF_VALUE) call apply_value(place, value, other, noise_follows=.true.)
        if (kind == OF_ALTERATION) call apply_alteration(place, other)
        call refit(other, options, solution, left)
        left = left + 3*(size(observations%accelerometer_time) - size(other%accelerometer_time))
    end subroutine fit_under

    !> A fit, and what it leaves: huge(1.0) when it fails altogether.
    subroutine refit(observations, options, solution, misfit)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(solution_t), intent(out) :: solution
        real(dp), intent(out) :: misfit

        type(error_t), allocatable :: error

        call estimate_optimal(observations, options, solution, error)
        misfit = huge(1.0_dp)
        if (solution%converged .and. solution%misfit > 0) misfit = solution%misfit
    end subroutine refit
end module gracecg_estimation_explanation
