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
    use gracecg_base_text, only: integer_text
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_parameters
    use gracecg_spacecraft_torque_rods, only: gain_unit
    use gracecg_estimation_arc_problem, only: arc_t, prepare_arc, open_arc, first_noise, find_disturbed, &
        reduce_arc, refresh_and_edit, covariance_of, LEAST_ANGLE
    use gracecg_estimation_arcs_fit, only: arcs_fit_t, combine_arcs, test_arcs
    use gracecg_estimation_information, only: no_information
    use gracecg_estimation_iteration, only: rms_of
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_model_state, only: physical_model_t, correct_state
    use gracecg_estimation_whitened_problem, only: whitened_problem_t
    implicit none
    private
    public :: estimate_arcs

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
        result%residuals = arcs%residuals
        if (.not. present(stated)) return
        call gather_arcs(believed, options, arcs, result, error)
        if (.not. allocated(error)) &
            call test_arcs(believed(1)%knowledge, options%wanted_accuracy, prior, stated, result, error)
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
                own = count(IS_ROTATIONAL(arcs(k)%own) .and. KIND_OF(arcs(k)%own) /= FIELD_BIAS(1))/3
                if (head == 2) own = 2
                squares = squares + arcs(k)%head_squares(about, head)
                free = free + arcs(k)%head_samples(head) - own
            end do
            sigma = 0
            if (free > 0) sigma = sqrt(squares/free)
        end function sigma_of_head
    end subroutine find_noise

    !> What all arcs say of the shared parameters and of what is believed and not estimated, at the fit, their own eliminated.
    subroutine gather_arcs(sets, options, arcs, fit, error)
        type(observation_set_t), intent(in) :: sets(:)
        type(estimation_options_t), intent(in) :: options
        type(arc_t), intent(in) :: arcs(:)
        type(arcs_fit_t), intent(inout) :: fit      !! Knows the noise
        type(error_t), allocatable, intent(out) :: error

        type(arc_t) :: wider
        type(whitened_problem_t) :: problem
        integer :: i, k

        fit%about = fit%value
        fit%tested = [fit%shared, pack(BELIEFS, [(.not. any([fit%shared, arcs(1)%own] == BELIEFS(k)), k=1, size(BELIEFS))])]
        fit%information = no_information(size(fit%tested))
        do i = 1, size(arcs)
            wider%own = arcs(i)%own
            wider%held = arcs(i)%held
            call open_arc(arcs(i), sets(i), options, fit%linear_noise, fit%angular_noise, problem, fit%tested)
            call reduce_arc(wider, problem, size(fit%tested), error)
            if (allocated(error)) return
            call fit%information%add(wider%information)
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
end module gracecg_estimation_arcs
