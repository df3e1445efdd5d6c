!> One fit of several arcs: least squares of the physical model in all of them, what they share estimated once.
!>
!> Each arc is a whitened problem of its own (gracecg_estimation_whitened_problem) with an attitude, rate, torque, bias and
!> drift of its own. Its own parameters are eliminated from its normal equations, and what is left about the shared ones is
!> added up: the work grows with the number of arcs. Arcs that alone determine nothing count with the others.
!>
!> Noise is autoregressive, of one spectrum for all arcs, found in turn with the fit from the residuals and from what the
!> errors of the fit have taken out of them. Delays act on the model in proportion; what is found of them is put into what is
!> believed, and the fit is done anew, until they or the offset stay.
!>
!> What is believed and not estimated is tested at the fit, all arcs together (gracecg_estimation_belief_tests).
module gracecg_estimation_arcs
    use gracecg_base_kinds, only: dp
    use gracecg_base_autoregression, only: autoregression_t, autocovariances_t, bridge_t, new_bridge, predictors_of
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_text, only: integer_text
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_parameters
    use gracecg_spacecraft_torque_rods, only: gain_unit
    use gracecg_estimation_arc_problem, only: arc_t, arc_residuals_t, prepare_arc, open_arc, first_noise, find_disturbed, &
        reduce_arc, refresh_and_edit, covariance_of, LEAST_ANGLE
    use gracecg_estimation_information, only: information_t, gathered, no_information
    use gracecg_estimation_iteration, only: rms_of
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_parameters, only: a_priori_sigmas, conceivable_errors
    use gracecg_estimation_belief, only: is_possible
    use gracecg_estimation_belief_report, only: belief_report_t, value_test_t, explanation_t, begin_report, finish_report, &
        OF_VALUE, SAME
    use gracecg_estimation_belief_tests, only: test_values
    use gracecg_estimation_model_state, only: physical_model_t, correct_state
    use gracecg_estimation_whitened_problem, only: whitened_problem_t
    implicit none
    private
    public :: arcs_fit_t, estimate_arcs, combine_arcs, offset_of

    integer, parameter :: ORDER = 32                !! Of the noise: 3 s of samples
    integer, parameter :: MOST_ROUNDS = 8           !! Of fits with other delays
    integer, parameter :: MOST_STEPS = 10           !! Of Gauss and Newton
    integer, parameter :: NOISE_ROUNDS = 12         !! Of noise and editing within a fit
    real(dp), parameter :: SAME_SIGMA = 5e-3_dp     !! Relative change of the offset's sigma from noise to noise at the end
    real(dp), parameter :: SMALL_STEP = 1e-2_dp      !! Largest step of a shared parameter at the end, standard deviations
    real(dp), parameter :: SAME_DELAY = 2e-5_dp, SAME_SHARE = 0.05_dp   !! s; of its standard deviation
    real(dp), parameter :: LEAST_LINEAR = 1e-11_dp, LEAST_ANGULAR = 1e-10_dp
    !! Noise of the accelerometer, m/s^2 and rad/s^2: samples without noise weigh no more. With a tenth of that linear one the
    !! elimination of an arc's own parameters leaves nothing but rounding
    integer, parameter :: MOST_TRIED = 6            !! Beliefs that may explain what is contradicted

    !> The result.
    type :: arcs_fit_t
        integer, allocatable :: shared(:)           !! Places of the shared parameters; the offset's are the first three
        real(dp), allocatable :: value(:)           !! Of them, SI units: errors of what was believed
        real(dp), allocatable :: covariance(:, :)   !! Of the values, SI units
        real(dp), allocatable :: at(:)              !! Values about which the arcs are linearised
        type(information_t), allocatable :: arcs(:) !! Of the samples of each arc about corrections of these
        real(dp), allocatable :: arc_offset(:, :)   !! By each arc alone with the other shared values of all, (3, arcs), m
        real(dp), allocatable :: arc_covariance(:, :, :)    !! Of these, m^2; 0 where an arc alone does not tell
        real(dp) :: chi_square = 0                  !! Of the arcs about the common offset
        integer :: degrees = 0                      !! Of freedom of it
        real(dp) :: rms(3) = 0                      !! Of the accelerometer's noise, m/s^2
        real(dp), allocatable :: arc_rms(:, :)      !! Of each arc, (3, arcs), m/s^2
        logical, allocatable :: disturbed(:)        !! Arcs that count less, for their noise is larger
        type(arc_residuals_t), allocatable :: residuals(:)      !! Of each arc
        real(dp) :: head_sigma(3) = 0               !! Of the first star-camera head about its axes, rad
        type(autoregression_t) :: linear_noise(3), angular_noise(3)     !! Of the accelerometer and its angular channels
        integer :: samples = 0                      !! Of the accelerometer that count
        logical :: converged = .false.              !! The last fit settled, and the delays stay
        type(belief_report_t), allocatable :: beliefs   !! Where they were to be tested
    end type arcs_fit_t

contains

    !> Fits all arcs. Fails when an arc is refused or the shared parameters are not determined.
    subroutine estimate_arcs(sets, options, shared, prior, own, result, error, stated, without)
        type(observation_set_t), intent(in) :: sets(:)      !! The arcs: samples, and what is believed
        type(estimation_options_t), intent(in) :: options
        integer, intent(in) :: shared(:)            !! Places of shared parameters, the offset first
        real(dp), intent(in) :: prior(:)            !! Their a-priori standard deviations, SI units; 0: none
        integer, intent(in) :: own(:)               !! Places of the others, each arc's own
        type(arcs_fit_t), intent(out) :: result
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: stated(:)
        !! To which what is believed and not estimated is right, standard deviations by place, SI units; 0: as
        !! a_priori_sigmas says. Absent: it is not tested
        type(arcs_fit_t), intent(out), optional :: without(2)
        !! The same without the second star-camera head, and without the angular channels; where there are none nothing

        type(observation_set_t), allocatable :: believed(:)
        type(arc_t), allocatable :: arcs(:)
        real(dp) :: moved(size(shared))             ! What of the values is in the beliefs by now
        real(dp) :: last(size(shared))              ! What was put there the last time
        real(dp) :: before(3)
        integer :: i, axis, round
        logical :: settled

        result%shared = shared
        believed = sets
        moved = 0
        last = 0
        before = huge(before)
        allocate (arcs(size(sets)), result%arcs(size(sets)), result%arc_rms(3, size(sets)))
        result%linear_noise = first_noise(of_channels=.false.)
        result%angular_noise = first_noise(of_channels=.true.)
        do round = 1, MOST_ROUNDS
            do i = 1, size(arcs)
                call prepare_arc(believed(i), options, shared, own, arcs(i), error)
                call add_context(error, 'arc '//integer_text(i))
                if (allocated(error)) return
            end do
            call fit(believed, options, arcs, prior, moved, result, settled, error)
            if (allocated(error)) return
            call move_delays(arcs, result, before, believed, moved, last)
            if (result%converged) exit
        end do
        result%converged = result%converged .and. settled
        result%disturbed = [(any(arcs(i)%excess > 1), i=1, size(arcs))]
        do i = 1, size(arcs)
            associate (left => arcs(i)%residuals)
                result%samples = result%samples + count(left%kept)
                result%arc_rms(:, i) = [(rms_of(pack(left%linear(axis, :), left%kept)), axis=1, 3)]
            end associate
        end do
        result%head_sigma = arcs(size(arcs))%point%noise%star_camera_sigma
        if (present(without)) then
            if (any(arcs%head_samples(2) > 0)) &
                call leave_out(believed, options, arcs, prior, result, .true., without(1), error)
            if (all([(size(arcs(i)%residuals%angular) > 0, i=1, size(arcs))]) .and. .not. allocated(error)) &
                call leave_out(believed, options, arcs, prior, result, .false., without(2), error)
            if (allocated(error)) return
        end if
        if (present(stated)) call test_arcs(believed, options, arcs, prior, stated, result, error)
        result%residuals = arcs%residuals
    end subroutine estimate_arcs

    !> Fits with the beliefs as they are: steps of Gauss and Newton, noise, editing.
    subroutine fit(believed, options, arcs, prior, moved, result, settled, error)
        type(observation_set_t), intent(in) :: believed(:)
        type(estimation_options_t), intent(in) :: options
        type(arc_t), intent(inout) :: arcs(:)
        real(dp), intent(in) :: prior(:), moved(:)
        type(arcs_fit_t), intent(inout) :: result
        logical, intent(out) :: settled             !! The last steps became small
        type(error_t), allocatable, intent(out) :: error

        type(whitened_problem_t) :: problem
        real(dp) :: largest
        integer :: round, step, i
        real(dp) :: sigma(3), before(3)
        logical :: changed

        settled = .false.
        before = 0
        do round = 1, NOISE_ROUNDS
            do step = 1, MOST_STEPS
                do i = 1, size(arcs)
                    call open_arc(arcs(i), believed(i), options, result%linear_noise, result%angular_noise, problem)
                    call reduce_arc(arcs(i), problem, size(prior), error)
                    if (allocated(error)) return
                end do
                call step_all(arcs, prior, moved, result, largest, error)
                if (allocated(error)) return
                settled = largest < SMALL_STEP
                if (settled) exit
            end do
            changed = .false.
            do i = 1, size(arcs)
                call open_arc(arcs(i), believed(i), options, result%linear_noise, result%angular_noise, problem)
                call refresh_and_edit(arcs(i), problem, changed)
            end do
            sigma = [(sqrt(result%covariance(i, i)), i=1, 3)]
            if (.not. changed .and. all(abs(sigma - before) <= SAME_SIGMA*sigma)) exit
            before = sigma
            call find_disturbed(arcs)
            call find_noise(believed, options, arcs, result)
        end do
    end subroutine fit

    !> A step of all parameters.
    subroutine step_all(arcs, prior, moved, result, largest, error)
        type(arc_t), intent(inout) :: arcs(:)
        real(dp), intent(in) :: prior(:), moved(:)
        type(arcs_fit_t), intent(inout) :: result
        real(dp), intent(out) :: largest            !! Of the shared ones, standard deviations
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: step(size(prior))
        integer :: i, k

        result%at = arcs(1)%point%state%value(result%shared) + moved
        do i = 1, size(arcs)
            result%arcs(i) = arcs(i)%information
        end do
        call combine_arcs(result, prior, error)
        if (allocated(error)) return
        step = result%value - result%at
        largest = maxval([(abs(step(k))/sqrt(result%covariance(k, k)), k=1, size(step))])
        do i = 1, size(arcs)
            call correct_state(physical_model_t(estimated=arcs(i)%point%estimated), [step, arcs(i)%eliminated%value_at(step)], &
                               arcs(i)%point%state)
        end do
    end subroutine step_all

    !> The noise of all arcs together.
    subroutine find_noise(believed, options, arcs, result)
        type(observation_set_t), intent(in) :: believed(:)
        type(estimation_options_t), intent(in) :: options
        type(arc_t), intent(inout) :: arcs(:)
        type(arcs_fit_t), intent(inout) :: result

        type(autocovariances_t) :: linear(3), angular(3)
        type(bridge_t) :: bridge                    ! Over the samples of an arc that are left out
        type(whitened_problem_t) :: problem
        real(dp), allocatable :: partials(:, :)
        real(dp) :: first_head(3), second_head(3)
        logical :: found_before     ! Errors of the fit are those by the noise, not by a first guess
        integer :: axis, i

        found_before = result%linear_noise(1)%order == ORDER
        do axis = 1, 3
            call linear(axis)%begin(ORDER)
            call angular(axis)%begin(ORDER)
        end do
        do i = 1, size(arcs)
            if (found_before .and. .not. all(arcs(i)%excess(:3) > 1)) then
                call open_arc(arcs(i), believed(i), options, result%linear_noise, result%angular_noise, problem)
                call problem%predict()
            end if
            associate (left => arcs(i)%residuals, excess => arcs(i)%excess)
                do axis = 1, 3
                    if (.not. excess(axis) > 1) then
                        bridge = new_bridge(result%linear_noise(axis), left%kept)
                        call add_series(left%linear(axis, :), linear(axis))
                        if (found_before) then
                            partials = problem%acceleration_partials(:, axis, :)
                            call bridge%fill(partials)
                            call linear(axis)%add_errors(partials, covariance_of(arcs(i), result%covariance))
                        end if
                    end if
                    if (size(left%angular) == 0 .or. excess(3 + axis) > 1) cycle
                    bridge = new_bridge(result%angular_noise(axis), left%kept)
                    call add_series(left%angular(axis, :), angular(axis))
                end do
            end associate
        end do
        do axis = 1, 3
            linear(axis)%sums(0) = linear(axis)%sums(0) + linear(axis)%count*LEAST_LINEAR**2
            angular(axis)%sums(0) = angular(axis)%sums(0) + angular(axis)%count*LEAST_ANGULAR**2
            result%linear_noise(axis) = predictors_of(linear(axis), real(linear(axis)%count, dp))
            result%rms(axis) = result%linear_noise(axis)%deviation(0)
            result%angular_noise(axis) = predictors_of(angular(axis), angular(axis)%count - &
                                                       3.0_dp*count([(.not. arcs(i)%excess(3 + axis) > 1, i=1, size(arcs))]))
            first_head(axis) = max(LEAST_ANGLE, sigma_of_head(1, axis))
            second_head(axis) = max(LEAST_ANGLE, sigma_of_head(2, axis))
        end do
        do i = 1, size(arcs)
            arcs(i)%point%noise%star_camera_sigma = first_head
            arcs(i)%point%noise%second_head_sigma = second_head
        end do

    contains

        !> Adds residuals, those of missing samples with what is expected of them.
        subroutine add_series(residuals, sums)
            real(dp), intent(in) :: residuals(:)
            type(autocovariances_t), intent(inout) :: sums

            real(dp) :: filled(1, size(residuals))

            filled(1, :) = residuals
            call bridge%fill(filled)
            call sums%add(filled(1, :))
            call sums%add_missing(bridge)
        end subroutine add_series

        !> The noise of a head about an axis, rad; 0: it has no samples.
        real(dp) function sigma_of_head(head, about) result(sigma)
            integer, intent(in) :: head, about

            real(dp) :: squares, free
            integer :: k, own

            sigma = 1
            if (head == 2 .and. about /= 2) return      ! any axis of the gyros would do: within 0.2 um in 24 days
            squares = 0
            free = 0
            do k = 1, size(arcs)
                if (arcs(k)%head_samples(head) == 0) cycle
                own = count(is_rotational(arcs(k)%own) .and. KIND_OF(arcs(k)%own) /= OF_FIELD_BIAS)/3
                if (head == 2) own = 2
                squares = squares + arcs(k)%head_squares(about, head)
                free = free + arcs(k)%head_samples(head) - own
            end do
            sigma = 0
            if (free > 0) sigma = sqrt(squares/free)
        end function sigma_of_head
    end subroutine find_noise

    !> Tests what is believed of all arcs and is not estimated. A belief explains the samples if nothing is contradicted
    !> when it is estimated, too; the likeliest are tried.
    subroutine test_arcs(sets, options, arcs, prior, stated, result, error)
        type(observation_set_t), intent(in) :: sets(:)
        type(estimation_options_t), intent(in) :: options
        type(arc_t), intent(in) :: arcs(:)
        real(dp), intent(in) :: prior(:), stated(:)
        type(arcs_fit_t), intent(inout) :: result
        type(error_t), allocatable, intent(out) :: error

        type(information_t) :: all
        real(dp) :: sigma(PARAMETERS), conceivable(PARAMETERS)
        real(dp), allocatable :: gain(:)
        logical, allocatable :: left(:)
        integer, allocatable :: places(:)
        integer :: k, n, best

        n = size(prior)
        places = [result%shared, pack(BELIEFS, [(.not. any([result%shared, arcs(1)%own] == BELIEFS(k)), k=1, size(BELIEFS))])]
        call gather_arcs(sets, options, arcs, places, result, all, error)
        if (allocated(error)) return
        do k = 1, n
            call all%expect(k, prior(k), result%value(k))
        end do
        sigma = a_priori_sigmas(sets(1)%knowledge)
        where (stated > 0) sigma = stated
        sigma(result%shared) = prior
        conceivable = conceivable_errors(sets(1)%knowledge, stated)
        allocate (result%beliefs)
        call test_with(n, result%beliefs, error)
        if (allocated(error) .or. .not. result%beliefs%has_contradiction()) return
        associate (tests => result%beliefs%values)
            left = tests%sigma > 0 .and. .not. tests%all_or_nothing .and. &
                [(is_possible(tests(k)%belief, tests(k)%value, sets(1)%knowledge), k=1, size(tests))]
            allocate (gain(size(tests)), source=0.0_dp)
            where (left) gain = (tests%value/tests%sigma)**2/2
            where (left .and. [(any(result%shared == tests(k)%belief), k=1, size(tests))]) gain = tests%score**2/2
            left = left .and. 2*gain > result%beliefs%critical**2       ! what may as well be as believed explains nothing
        end associate
        do k = 1, min(MOST_TRIED, count(left))
            best = maxloc(gain, 1, left)
            left(best) = .false.
            associate (found => result%beliefs%explanations)
                if (any(found%complete .and. found%gain > gain(best) + SAME)) exit
            end associate
            call try(result%beliefs%values(best), gain(best))
        end do

    contains

        !> The tests with the first so many parameters estimated.
        subroutine test_with(first, report, failed)
            integer, intent(in) :: first
            type(belief_report_t), intent(out) :: report
            type(error_t), allocatable, intent(out) :: failed

            real(dp) :: step(first), covariance(first, first), value(first), condition

            value = 0
            value(:n) = result%value
            call solve_normal_equations(all%matrix(:first, :first), all%rhs(:first), step, covariance, condition, failed)
            if (allocated(failed)) return
            value = value + step
            call begin_report(value(:3), options%wanted_accuracy, sets(1)%knowledge%a_priori%signs_known, report)
            call test_values(places, first, all%matrix, all%rhs, covariance, sigma, conceivable, value, report)
            call finish_report(report)
        end subroutine test_with

        !> A belief that may explain what is contradicted: the first one, or those with which nothing is. Of one that is
        !> estimated with what is said of it, that is left out.
        subroutine try(test, likelier)
            type(value_test_t), intent(in) :: test
            real(dp), intent(in) :: likelier        !! Gain of the log-likelihood

            type(explanation_t) :: explanation
            type(belief_report_t) :: other
            type(error_t), allocatable :: failure
            type(information_t) :: with_said
            real(dp) :: said
            integer :: p

            p = findloc(places, test%belief, 1)
            said = sigma(test%belief)
            sigma(test%belief) = 0                  ! what was said of it does not count
            if (p <= n) then
                with_said = all
                all%matrix(p, p) = all%matrix(p, p) - 1/said**2
                all%rhs(p) = all%rhs(p) + result%value(p)/said**2
                call test_with(n, other, failure)
                all = with_said
            else
                call interchange(n + 1, p)
                call test_with(n + 1, other, failure)
                call interchange(n + 1, p)
            end if
            sigma(test%belief) = said
            if (allocated(failure)) return
            explanation = explanation_t(OF_VALUE, test%belief, likelier, test%value, test%sigma, other%offset, &
                                        .not. other%has_contradiction())
            associate (beliefs => result%beliefs)
                if (explanation%complete .or. size(beliefs%explanations) == 0) beliefs%explanations = &
                    [pack(beliefs%explanations, beliefs%explanations%complete), explanation]
            end associate
        end subroutine try

        subroutine interchange(one, other)
            integer, intent(in) :: one, other       !! Places among the parameters

            places([one, other]) = places([other, one])
            all%matrix([one, other], :) = all%matrix([other, one], :)
            all%matrix(:, [one, other]) = all%matrix(:, [other, one])
            all%rhs([one, other]) = all%rhs([other, one])
        end subroutine interchange
    end subroutine test_arcs

    !> What all arcs say of shared parameters at the fit, their own eliminated.
    subroutine gather_arcs(sets, options, arcs, places, fit, all, error)
        type(observation_set_t), intent(in) :: sets(:)
        type(estimation_options_t), intent(in) :: options
        type(arc_t), intent(in) :: arcs(:)
        integer, intent(in) :: places(:)            !! Of the parameters
        type(arcs_fit_t), intent(in) :: fit         !! Knows the noise
        type(information_t), intent(out) :: all
        type(error_t), allocatable, intent(out) :: error

        type(arc_t) :: wider
        type(whitened_problem_t) :: problem
        integer :: i

        all = no_information(size(places))
        do i = 1, size(arcs)
            wider%own = arcs(i)%own
            wider%held = arcs(i)%held
            call open_arc(arcs(i), sets(i), options, fit%linear_noise, fit%angular_noise, problem, places)
            call reduce_arc(wider, problem, size(places), error)
            if (allocated(error)) return
            call all%add(wider%information)
        end do
    end subroutine gather_arcs

    !> The estimate without the second head, or without the angular channels: from the same samples by a step of Gauss and
    !> Newton from the fit of all.
    subroutine leave_out(believed, options, arcs, prior, all, second_head, result, error)
        type(observation_set_t), intent(in) :: believed(:)
        type(estimation_options_t), intent(in) :: options
        type(arc_t), intent(in) :: arcs(:)
        real(dp), intent(in) :: prior(:)
        type(arcs_fit_t), intent(in) :: all
        logical, intent(in) :: second_head          !! Else the channels
        type(arcs_fit_t), intent(out) :: result
        type(error_t), allocatable, intent(out) :: error

        type(arc_t) :: arc
        type(whitened_problem_t) :: problem
        integer :: i

        result%shared = all%shared
        result%at = all%value
        allocate (result%arcs(size(arcs)))
        do i = 1, size(arcs)
            arc = arcs(i)
            call open_arc(arc, believed(i), options, all%linear_noise, all%angular_noise, problem)
            if (second_head) problem%star_kept = problem%star_kept .and. problem%data%stars%head /= 2
            call reduce_arc(arc, problem, size(prior), error, channels=second_head)
            if (allocated(error)) return
            result%arcs(i) = arc%information
        end do
        call combine_arcs(result, prior, error)
        result%converged = .not. allocated(error)
    end subroutine leave_out

    !> Puts the delays and gains of rods that were found into what is believed, and takes them from the state: torque that is later
    !> by a delay is so by the gains that are believed. Where moments are held, samples keep their places between the steps. What
    !> would go back is halved: star cameras with much noise alone tell torque and samples that are later and earlier alike.
    subroutine move_delays(arcs, result, before, believed, moved, last)
        type(arc_t), intent(inout) :: arcs(:)
        type(arcs_fit_t), intent(inout) :: result       !! Has converged if nothing is moved, or the offset stays
        real(dp), intent(inout) :: before(3)            !! The offset with the delays before these, m
        type(observation_set_t), intent(inout) :: believed(:)
        real(dp), intent(inout) :: moved(:), last(:)

        real(dp) :: value
        integer :: i, k, place

        result%converged = all([(abs(result%value(k) - before(k)) < SAME_SHARE*sqrt(result%covariance(k, k)), k=1, 3)])
        before = result%value(:3)
        if (result%converged) return
        result%converged = .true.
        do k = 1, size(result%shared)
            place = result%shared(k)
            if (.not. any(place == [ALL_RODS_DELAY, SAMPLING_DELAY, ROD_GAINS])) cycle
            value = arcs(1)%point%state%value(place)
            if (abs(value) < max(SAME_DELAY, SAME_SHARE*sqrt(result%covariance(k, k)))) cycle
            result%converged = .false.
            if (value*last(k) < 0) value = value/2
            last(k) = value
            moved(k) = moved(k) + value
            do i = 1, size(arcs)
                arcs(i)%point%state%value(place) = arcs(i)%point%state%value(place) - value
                associate (knowledge => believed(i)%knowledge)
                    if (place == SAMPLING_DELAY) then
                        knowledge%accelerometer_delay = knowledge%accelerometer_delay + value
                    else if (any(place == ROD_GAINS)) then
                        associate (gain => knowledge%rods%gain(MEMBER_OF(place)))
                            gain = gain + value*gain_unit(gain)
                        end associate
                    else
                        knowledge%rods%delay = knowledge%rods%delay + value
                        if (arcs(i)%held) knowledge%accelerometer_delay = knowledge%accelerometer_delay - value
                    end if
                end associate
            end do
        end do
    end subroutine move_delays

    !> The shared parameters by what all arcs say and what is known beforehand; the offset by each arc, and how far they are
    !> from each other. Fails when the shared parameters are not determined.
    subroutine combine_arcs(fit, prior, error)
        type(arcs_fit_t), intent(inout) :: fit
        real(dp), intent(in) :: prior(:)            !! Their a-priori standard deviations, SI units; 0: none
        type(error_t), allocatable, intent(out) :: error

        type(error_t), allocatable :: singular
        type(information_t) :: all
        real(dp) :: step(size(prior)), change(3)
        integer :: i, k

        all = gathered(fit%arcs, prior, fit%at)
        fit%covariance = all%matrix
        call all%solve(step, fit%covariance, error, parameter_names(fit%shared))
        call add_context(error, 'what the arcs share')
        if (allocated(error)) return
        fit%value = fit%at + step
        fit%arc_offset = spread(fit%value(:3), 2, size(fit%arcs))
        fit%arc_covariance = reshape([(0.0_dp, i=1, 9*size(fit%arcs))], [3, 3, size(fit%arcs)])
        fit%chi_square = 0
        fit%degrees = -3
        do i = 1, size(fit%arcs)
            call offset_of(fit, [(k == i, k=1, size(fit%arcs))], fit%arc_offset(:, i), fit%arc_covariance(:, :, i), singular)
            if (allocated(singular)) cycle
            change = fit%arc_offset(:, i) - fit%value(:3)
            fit%chi_square = fit%chi_square + dot_product(change, matmul(fit%arcs(i)%matrix(:3, :3), change))
            fit%degrees = fit%degrees + 3
        end do
        fit%degrees = max(0, fit%degrees)
    end subroutine combine_arcs

    !> The offset by some arcs alone, with the other shared values of all. Fails where they do not determine it, which is then
    !> that of all.
    subroutine offset_of(fit, which, offset, covariance, error)
        type(arcs_fit_t), intent(in) :: fit         !! With its values
        logical, intent(in) :: which(:)             !! Of the arcs
        real(dp), intent(out) :: offset(3)          !! m
        real(dp), intent(out) :: covariance(3, 3)   !! m^2; 0 where they do not tell
        type(error_t), allocatable, intent(out) :: error

        type(information_t) :: alone
        real(dp) :: change(3)
        integer :: i

        alone = no_information(3)
        do i = 1, size(fit%arcs)
            if (.not. which(i)) cycle
            alone%matrix = alone%matrix + fit%arcs(i)%matrix(:3, :3)
            alone%rhs = alone%rhs + fit%arcs(i)%rhs(:3) - matmul(fit%arcs(i)%matrix(:3, :), fit%value - fit%at)
        end do
        offset = fit%value(:3)
        covariance = 0
        call alone%solve(change, covariance, error)
        if (.not. allocated(error)) offset = offset + change
    end subroutine offset_of
end module gracecg_estimation_arcs
