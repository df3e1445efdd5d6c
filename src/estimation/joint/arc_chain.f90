!> A long run as a chain of arcs: it is cut into arcs of equal length, each estimated by `optimal` with an epoch,
!> attitude, rate, bias, drag and torque of its own, and joined with the others (gracecg_estimation_joint_estimate).
!> Rotation without noise of the state is then followed through one arc only, however long the run is.
!>
!> Of an arc its information about the offset and what arcs share is kept, and where its fit has got to, not its samples
!> and partials, so that memory grows with the samples of the run alone. It is linearised anew at the joint estimate:
!> partials of the scale factors at each arc's own offset have the noise of that, by which those of 60 arcs and more went
!> wrong, and the offset with them.
module gracecg_estimation_arc_chain
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_base_progress, only: progress_t, expect_pieces
    use gracecg_base_statistics, only: median_of
    use gracecg_base_text, only: string_t, append, integer_text, rounded_text
    use gracecg_spacecraft_torque_rods, only: moves_rods, check_rods_fire
    use gracecg_observations_arc_of_run, only: arc_of_run, without_moments
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t, check_observations
    use gracecg_estimation_fitting_data, only: fitting_data_t, preprocess
    use gracecg_estimation_gather_information, only: move_joined
    use gracecg_estimation_joint_estimate, only: joint_options_t, joint_solution_t, run_verdict_t, estimate_jointly
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_options, only: estimation_options_t, check_options
    use gracecg_estimation_plausibility, only: refuse_implausible, longest_arc
    use gracecg_estimation_run_information, only: run_information_t, JOINED_COUNT
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, fit_point_t, point_of, problem_at
    implicit none
    private
    public :: arc_chain_t, chained_arc_t, estimate_chain, USUAL_ARC, SHORTEST_ARC

    real(dp), parameter :: USUAL_ARC = 60
    !! s. That of the report, in which a manoeuvre of a minute is whole. Of an hour under control arcs of 30 s leave the
    !! sigma of z 1.4 times as large; longer ones cost the same for a sample, and their forces and torques bend more
    !! than a fit follows where the satellite turns freely (docs/validation.md)
    real(dp), parameter :: SHORTEST_ARC = 10    !! s
    real(dp), parameter :: MANOEUVRE = 0.5_dp
    !! Of the run's greatest measured moment: what is more is a manoeuvre, not the control of the attitude
    real(dp), parameter :: MOST_REFUSED = 0.25_dp
    !! Part of the arcs with a manoeuvre that may be left out, as of a series of samples
    real(dp), parameter :: MISFIT = 1.25_dp
    !! Of an arc's residuals, times those of most arcs, beyond which it is left out. A choice: six hours under control
    !! have 2.4 to 2.9 in the six arcs at the edge of the Earth's shadow, at most 1.12 in the others
    real(dp), parameter :: MOST_APART = 0.05_dp
    !! Part of the arcs that may be left out because they disagree with the others: where more do, it is not single arcs
    !! that are wrong. A choice
    real(dp), parameter :: DISAGREEMENT = 1e-6_dp
    !! Probability of their chi square below which arcs are not joined. A choice: an hour under control had 2e-5 as long as
    !! arcs far off were in it, and a good offset

    integer, parameter :: MOST_ROUNDS = 4
    !! Of linearising anew, a choice
    real(dp), parameter :: SETTLED = 0.1_dp
    !! Change of the offset, or that which the next round would make, that ends them, in sigmas: a choice

    character(*), parameter :: SINGULAR = 'the normal matrix is singular'
    !! In the message of who solves normal equations that determine nothing

    !> One of the arcs.
    type :: chained_arc_t
        real(dp) :: from = 0, to = 0        !! s from the run's epoch
        logical :: joined = .false.         !! Its information is in the joint estimate
        logical :: apart = .false.          !! It is left out because it disagrees with the others
        logical :: empty = .false.
        !! It tells no offset: singular, or without a manoeuvre and refused, without convergence, or with an offset of its
        !! own that no satellite has, far from which its information would be used
        logical :: moves_rods = .false.     !! A manoeuvre is in it
        real(dp) :: variance_factor = 0     !! Weighted squares of its residuals by their redundancy
        character(:), allocatable :: reason !! Why it is left out
        type(run_information_t) :: information          !! At the joint estimate
        type(fit_point_t) :: fit                        !! Where its fit is, of an arc that is joined
        type(string_t), allocatable :: warnings(:)      !! Of its estimate
    end type chained_arc_t

    !> The estimate of a run in arcs.
    type :: arc_chain_t
        type(chained_arc_t), allocatable :: arcs(:)     !! In the order of time, those left out among them
        type(joint_solution_t) :: solution              !! Its runs are the arcs that are joined
        type(string_t), allocatable :: warnings(:)      !! Arcs left out, and what several arcs warn of
    end type arc_chain_t

    !> The arcs, as work for several threads.
    type, extends(parallel_work_t) :: arcs_work_t
        type(observation_set_t), pointer :: observations => null()
        type(operator_knowledge_t) :: knowledge         ! theirs, without measured moments
        type(estimation_options_t) :: options
        type(joint_options_t) :: joint
        real(dp) :: greatest_moment = 0                 ! Of those measured, A m^2; 0: none were
        type(chained_arc_t), allocatable :: arcs(:)
        real(dp), allocatable :: point(:, :)            ! JOINED at the joint estimate, (., arcs); none in the first round
    contains
        procedure :: do_one => estimate_arc
    end type arcs_work_t

contains

    !> The offset of a run in arcs of `length` at most, cut at epochs that all instruments share as far as these have such.
    !>
    !> An arc that `optimal` refuses, or that tells no offset by itself, is left out with a warning. Fails when the
    !> observations or options are refused, no rod acts in the run, an arc would be longer than a fit holds, more than a quarter of
    !> the arcs with a manoeuvre is refused, the arcs disagree beyond all chance, or the offset is not determined or not plausible.
    subroutine estimate_chain(observations, options, joint, length, threads, chain, error, progress)
        type(observation_set_t), intent(in), target :: observations
        type(estimation_options_t), intent(in) :: options   !! First guesses are those of the first arc
        type(joint_options_t), intent(in) :: joint          !! What arcs have their own; no changes
        real(dp), intent(in) :: length                      !! s, e.g. USUAL_ARC
        integer, intent(in) :: threads                      !! 1 to 1024
        type(arc_chain_t), intent(out) :: chain
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Arcs are counted

        type(arcs_work_t) :: work
        real(dp) :: longest

        allocate (chain%warnings(0))
        call check_options(options, error)
        if (.not. allocated(error)) call check_observations(observations, error)
        if (.not. allocated(error)) call check_rods_fire(observations%knowledge%rods, observations%knowledge%duration, error)
        if (allocated(error)) return
        longest = longest_arc(observations%knowledge)
        if (.not. (length >= SHORTEST_ARC .and. length <= longest)) then
            call fail(error, 'arcs of '//rounded_text(length, 4)//' s: they have to last from '// &
                      rounded_text(SHORTEST_ARC, 3)//' s to '//rounded_text(longest, 4)//' s, to which a fit holds')
            return
        end if
        work%observations => observations
        work%knowledge = without_moments(observations%knowledge)
        if (allocated(observations%knowledge%rods%measured%moment)) &
            work%greatest_moment = maxval(abs(observations%knowledge%rods%measured%moment))
        work%options = options
        work%options%history = .false.
        work%options%test_beliefs = .false.     ! nobody would read a test in every arc
        work%joint = joint
        call cut(observations%knowledge, length, work%arcs)
        call expect_pieces(progress, size(work%arcs), 'arcs')
        call run_parallel(work, size(work%arcs), threads, error, progress)
        if (allocated(error)) return
        call leave_out_misfits(work%arcs)
        call judge_arcs(work%arcs, error)
        if (.not. allocated(error)) call join(work, threads, chain%solution, error, progress)
        if (.not. allocated(error)) call check_agreement(chain%solution, error)
        if (.not. allocated(error)) call refuse_implausible('optimal', chain%solution%offset, chain%solution%covariance, &
                                                            options%largest_offset, error)
        if (.not. allocated(error)) call judge_arcs(work%arcs, error)
        call move_alloc(work%arcs, chain%arcs)
        if (allocated(error)) return
        call warn_of_arcs(chain)
        call gather_warnings(chain)
    end subroutine estimate_chain

    !> Leaves out arcs with residuals larger than those of most (that of all are larger says something of the noise): in
    !> them a force acts that the model does not follow, as while the satellite goes through the edge of the Earth's
    !> shadow, which takes half a minute where its orbit crosses that aslant.
    subroutine leave_out_misfits(arcs)
        type(chained_arc_t), intent(inout) :: arcs(:)

        real(dp) :: usual
        integer :: i

        if (.not. any(arcs%joined)) return
        usual = sqrt(median_of(pack(arcs%variance_factor, arcs%joined)))
        do i = 1, size(arcs)
            associate (arc => arcs(i), size_of => sqrt(arcs(i)%variance_factor))
                if (.not. (arc%joined .and. size_of > MISFIT*usual)) cycle
                arc%joined = .false.
                arc%reason = 'its residuals are '//rounded_text(size_of/usual, 3)//' times those of most arcs, as where a '// &
                             'force changes that the model does not follow: at the edge of the Earth''s shadow'
            end associate
        end do
    end subroutine leave_out_misfits

    !> The joint estimate, about which the arcs are linearised until it stays. What an arc says alone is that of its own
    !> estimate.
    subroutine join(work, threads, solution, error, progress)
        type(arcs_work_t), intent(inout) :: work
        integer, intent(in) :: threads
        type(joint_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(run_verdict_t) :: alone(size(work%arcs))
        real(dp) :: before(3), change, last_change
        integer, allocatable :: which(:)    ! arcs that are joined
        integer :: round, i

        call estimate_jointly(pack(work%arcs%information, work%arcs%joined), work%joint, solution, error)
        if (allocated(error)) return
        which = places_of(work%arcs%joined)
        alone(which) = solution%runs
        ! first about the mean of what the arcs say alone: the joint estimate of many is worse (theory.md, 19.1)
        allocate (work%point(JOINED_COUNT, size(work%arcs)), source=0.0_dp)
        do i = 1, 3
            before(i) = sum(solution%runs%offset(i)/solution%runs%sigma(i)**2)/sum(1/solution%runs%sigma(i)**2)
        end do
        do i = 1, size(which)
            work%point(:, which(i)) = [before, work%arcs(which(i))%information%point(size(before) + 1:)]
        end do
        do round = 1, MOST_ROUNDS
            call expect_pieces(progress, size(work%arcs), 'arcs once more')
            call run_parallel(work, size(work%arcs), threads, error, progress)
            if (allocated(error)) return
            if (.not. any(work%arcs%joined)) then
                call fail(error, 'no arc tells an offset where all arcs agree: '//work%arcs(1)%reason)
                return
            end if
            call estimate_jointly(pack(work%arcs%information, work%arcs%joined), work%joint, solution, error)
            if (.not. allocated(error)) call leave_out_apart(work, solution, error)
            if (allocated(error)) return
            which = places_of(work%arcs%joined)
            change = maxval(abs(solution%offset - before)/[(sqrt(solution%covariance(i, i)), i=1, 3)])
            if (change <= SETTLED) exit
            if (round > 1) then         ! the next change, as this one came after the last
                if (change < last_change .and. change*change/last_change <= SETTLED) exit
            end if
            last_change = change
            before = solution%offset
            do i = 1, size(which)
                work%point(:, which(i)) = solution%runs(i)%point
            end do
        end do
        do i = 1, size(which)
            solution%runs(i)%offset = alone(which(i))%offset
            solution%runs(i)%sigma = alone(which(i))%sigma
        end do
    end subroutine join

    pure function places_of(chosen) result(places)
        logical, intent(in) :: chosen(:)
        integer, allocatable :: places(:)

        integer :: i

        places = pack([(i, i=1, size(chosen))], chosen)
    end function places_of

    !> Leaves out the arc that differs most from the others, as long as one differs beyond the level of all tests: in it
    !> something happens that the model does not know, and a few such arcs pull the offset by many sigmas. No more than a
    !> part of the arcs.
    subroutine leave_out_apart(work, solution, error)
        type(arcs_work_t), intent(inout) :: work
        type(joint_solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        integer, allocatable :: which(:)
        integer :: worst

        do while (count(work%arcs%apart) < int(MOST_APART*(size(solution%runs) + count(work%arcs%apart))))
            if (all(solution%runs%agrees)) return
            worst = maxloc(solution%runs%statistic, 1)
            which = places_of(work%arcs%joined)
            associate (arc => work%arcs(which(worst)))
                arc%joined = .false.
                arc%apart = .true.
                arc%reason = 'it disagrees with the others, chi square '// &
                             rounded_text(solution%runs(worst)%statistic, 3)//' for 3 degrees of freedom'
            end associate
            call estimate_jointly(pack(work%arcs%information, work%arcs%joined), work%joint, solution, error)
            if (allocated(error)) return
        end do
    end subroutine leave_out_apart

    !> Where arcs begin and end: equal lengths but for rounding to an interval at which all instruments sample.
    subroutine cut(knowledge, length, arcs)
        type(operator_knowledge_t), intent(in) :: knowledge
        real(dp), intent(in) :: length
        type(chained_arc_t), allocatable, intent(out) :: arcs(:)

        real(dp) :: common
        integer :: i, n

        associate (own => knowledge%accelerometer_interval)
            common = own*max(1, nint(max(knowledge%star_camera_interval, knowledge%magnetometer_interval)/own))
            if (common > length/SHORTEST_ARC) common = own
        end associate
        n = max(1, ceiling(knowledge%duration/length - 1e-9_dp))
        allocate (arcs(n))
        do i = 1, n
            arcs(i)%to = common*anint(knowledge%duration/common*i/n)
        end do
        arcs(n)%to = knowledge%duration
        arcs(2:)%from = arcs(:n - 1)%to
    end subroutine cut

    !> One arc: never an error of the chain, but a reason to leave the arc out.
    subroutine estimate_arc(self, i, error)
        class(arcs_work_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t) :: observations
        type(joint_solution_t) :: alone
        type(error_t), allocatable :: refusal

        associate (arc => self%arcs(i), anew => allocated(self%point))
            if (anew .and. .not. arc%joined) return
            call arc_of_run(self%observations, self%knowledge, arc%from, arc%to, observations)
            if (anew) then
                call linearise_anew(observations, options_of(self%options, i), self%point(:, i), arc, refusal)
            else
                call estimate_alone(observations, options_of(self%options, i), self%greatest_moment, arc, refusal)
            end if
            if (.not. allocated(refusal) .and. .not. allocated(arc%reason)) &
                call estimate_jointly([arc%information], self%joint, alone, refusal)
            arc%joined = .not. (allocated(refusal) .or. allocated(arc%reason))
            if (.not. allocated(refusal)) return
            arc%reason = refusal%message
            arc%empty = index(arc%reason, SINGULAR) > 0 .or. (anew .or. self%greatest_moment > 0) .and. .not. arc%moves_rods
        end associate
    end subroutine estimate_arc

    !> The estimate of an arc. One without convergence, or with an offset that no satellite has, gets a reason.
    subroutine estimate_alone(observations, options, greatest_moment, arc, refusal)
        type(observation_set_t), intent(in) :: observations     !! Of the arc
        type(estimation_options_t), intent(in) :: options
        real(dp), intent(in) :: greatest_moment                 !! Of those measured in the run, A m^2; 0: none were
        type(chained_arc_t), intent(inout) :: arc
        type(error_t), allocatable, intent(out) :: refusal

        type(solution_t) :: solution
        type(whitened_problem_t) :: problem

        arc%moves_rods = moves_rods(observations%knowledge%rods, arc%to - arc%from)
        if (greatest_moment > 0) arc%moves_rods = maxval(abs(observations%knowledge%rods%measured%moment)) > &
                                                  MANOEUVRE*greatest_moment
        call estimate_optimal(observations, options, solution, refusal, problem=problem)
        arc%variance_factor = solution%variance_factor
        call move_alloc(solution%warnings, arc%warnings)
        if (allocated(refusal)) return
        if (.not. solution%converged) then
            arc%reason = 'optimal did not converge'
        else
            arc%information = solution%information
            arc%fit = point_of(problem)
            if (any(abs(solution%offset) > options%largest_offset)) arc%reason = 'its offset is beyond largest_offset_mm'
        end if
        arc%empty = allocated(arc%reason) .and. .not. arc%moves_rods
    end subroutine estimate_alone

    !> The information of an arc at the joint estimate.
    subroutine linearise_anew(observations, options, point, arc, refusal)
        type(observation_set_t), intent(in) :: observations     !! Of the arc
        type(estimation_options_t), intent(in) :: options
        real(dp), intent(in) :: point(JOINED_COUNT)             !! JOINED there
        type(chained_arc_t), intent(inout) :: arc
        type(error_t), allocatable, intent(out) :: refusal

        type(fitting_data_t) :: data
        type(whitened_problem_t) :: problem

        call preprocess(observations, options, data, refusal)
        if (allocated(refusal)) return
        call problem_at(observations%knowledge, options, data, arc%fit, problem)
        call move_joined(observations%knowledge, options, point, problem, arc%information, refusal)
        if (.not. allocated(refusal)) arc%fit = point_of(problem)
    end subroutine linearise_anew

    !> First guesses are those of the first arc.
    pure function options_of(options, i) result(own)
        type(estimation_options_t), intent(in) :: options
        integer, intent(in) :: i
        type(estimation_options_t) :: own

        own = options
        if (i == 1) return
        own%guess_quaternion = 0
        own%guess_angular_velocity = 0
    end function options_of

    !> Fails when too many arcs with a manoeuvre are refused, or none is left. Arcs that are singular do no harm by being
    !> left out, nor do those with a part of a manoeuvre.
    subroutine judge_arcs(arcs, error)
        type(chained_arc_t), intent(in) :: arcs(:)
        type(error_t), allocatable, intent(out) :: error

        logical :: refused(size(arcs))
        integer :: moving

        refused = arcs%moves_rods .and. .not. (arcs%joined .or. arcs%empty .or. arcs%apart)
        moving = count(arcs%moves_rods .and. .not. arcs%empty)
        if (.not. any(arcs%joined)) then
            call fail(error, 'no arc tells an offset; '//trim(arc_text(arcs(1)))//': '//arcs(1)%reason)
        else if (count(refused) > MOST_REFUSED*moving) then
            associate (first => arcs(findloc(refused, .true., 1)))
                call fail(error, integer_text(count(refused))//' of '//integer_text(moving)//' arcs with a manoeuvre are '// &
                          'refused; '//trim(arc_text(first))//': '//first%reason)
            end associate
        end if
    end subroutine judge_arcs

    !> Warns of arcs that are left out.
    subroutine warn_of_arcs(chain)
        type(arc_chain_t), intent(inout) :: chain

        character(:), allocatable :: cause
        integer :: i, empty, moving

        associate (arcs => chain%arcs)
            do i = 1, size(arcs)
                if (arcs(i)%joined .or. arcs(i)%empty) cycle
                call append(chain%warnings, trim(arc_text(arcs(i)))//' is left out: '//arcs(i)%reason)
            end do
            empty = count(arcs%empty)
            if (empty == 0) return
            moving = count(arcs%empty .and. arcs%moves_rods)
            cause = ', for want of a manoeuvre'
            if (moving > 0) cause = ', '//integer_text(moving)//' of them with rods that act'
            call append(chain%warnings, integer_text(empty)//' of '//integer_text(size(arcs))//' arcs, '// &
                        trim(arc_text(arcs(findloc(arcs%empty, .true., 1))))//' first, tell no offset by themselves'//cause// &
                        ', and are left out')
        end associate
    end subroutine warn_of_arcs

    pure function arc_text(arc) result(text)
        type(chained_arc_t), intent(in) :: arc
        character(60) :: text       ! blanks behind it

        text = 'the arc from '//rounded_text(arc%from, 6)//' to '//rounded_text(arc%to, 6)//' s'
    end function arc_text

    !> Arcs that disagree a little are told; where they do beyond all chance, the model does not hold over the run, and
    !> what many arcs share goes wrong with great certainty.
    subroutine check_agreement(solution, error)
        type(joint_solution_t), intent(in) :: solution
        type(error_t), allocatable, intent(out) :: error

        if (.not. solution%probability < DISAGREEMENT) return
        call fail(error, 'the arcs do not agree: chi square '//rounded_text(solution%statistic, 4)//' for '// &
                  integer_text(solution%degrees)//' degrees of freedom, '// &
                  integer_text(count(.not. solution%runs%agrees))//' of '//integer_text(size(solution%runs))// &
                  ' arcs apart from the others; no offset of all is given: the model does not hold over this run. Estimate '// &
                  'its manoeuvres one by one, or an hour of it')
    end subroutine check_agreement

    !> A warning that several arcs give, with other numbers perhaps, is told once.
    subroutine gather_warnings(chain)
        type(arc_chain_t), intent(inout) :: chain

        type(string_t), allocatable :: told(:)
        integer, allocatable :: arcs(:), first(:)
        integer :: i, j, k

        allocate (told(0), arcs(0), first(0))
        do i = 1, size(chain%arcs)
            if (.not. chain%arcs(i)%joined) cycle
            do j = 1, size(chain%arcs(i)%warnings)
                associate (text => chain%arcs(i)%warnings(j)%text)
                    do k = 1, size(told)
                        if (same_words(text, told(k)%text)) exit
                    end do
                    if (k > size(told)) then
                        call append(told, text)
                        arcs = [arcs, 0]
                        first = [first, i]
                    end if
                    arcs(k) = arcs(k) + 1
                end associate
            end do
        end do
        do k = 1, size(told)
            call append(chain%warnings, integer_text(arcs(k))//' of '//integer_text(count(chain%arcs%joined))// &
                        ' arcs, '//trim(arc_text(chain%arcs(first(k))))//' first: '//told(k)%text)
        end do
    end subroutine gather_warnings

    !> Do texts begin with the same words, up to the first digit?
    pure logical function same_words(a, b)
        character(*), intent(in) :: a, b

        character(*), parameter :: DIGITS = '0123456789'

        same_words = a(:modulo(scan(a, DIGITS) - 1, len(a) + 1)) == b(:modulo(scan(b, DIGITS) - 1, len(b) + 1))
    end function same_words
end module gracecg_estimation_arc_chain
