!> Manoeuvres that let the data speak of what the operator believes: no single wrong belief shall move the offset by
!> more than is wanted without a test seeing it (gracecg_estimation_belief_tests).
!>
!> The accelerometer sees angular accelerations, of fast components; the star camera sees angles, of slow ones, which
!> tell of rods, inertia and field. Every rod gets both, a part of its moment each. All orders of a few slow cycles
!> over the rods and a few parts are tried beside the manoeuvre found by noise alone; from the best, frequencies,
!> phases and parts of all rods are changed one at a time and all together, with steps that are halved where nothing
!> improves. Nothing is random: the result does not depend on threads.
module gracecg_planning_reliable_design
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: PI, TWO_PI
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_activation_t, take_manoeuvre, SINE, TAPERED
    use gracecg_estimation_belief_report, only: belief_report_t, value_test_t
    use gracecg_planning_bound, only: reliability_of_case
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_planning_candidates, only: design_settings_t
    use gracecg_planning_design, only: manoeuvre_design_t, judge_manoeuvre
    use gracecg_planning_planner, only: plan_request_t, plan_t, planned_calibration
    implicit none
    private
    public :: reliable_design_t, make_reliable

    !> A manoeuvre and what no test would see.
    type :: reliable_design_t
        type(manoeuvre_design_t) :: design      !! The manoeuvre and its errors by noise and forces
        type(belief_report_t) :: report         !! Minimal detectable values and their effects
        real(dp) :: effect(3) = huge(1.0_dp)    !! The largest of them on each component of the offset, m
        real(dp) :: sum = huge(1.0_dp)
        !! What the search makes small: the number of effects, and errors by noise and forces, that are larger than wanted,
        !! softly counted
        integer :: evaluations = 0              !! Manoeuvres whose reliability was determined
    end type reliable_design_t

    integer, parameter :: N = 15            !! Numbers of a manoeuvre, each group one for each rod:
    integer, parameter :: SLOW_CYCLES(3) = [1, 2, 3], SLOW_PHASE(3) = [4, 5, 6]     !! During the arc; rad
    integer, parameter :: PART(3) = [7, 8, 9]                                       !! Of the moment that is slow
    integer, parameter :: FAST_CYCLES(3) = [10, 11, 12], FAST_PHASE(3) = [13, 14, 15]
    !> First changes of the numbers: of cycles a third of what separates whole ones, of phases a third of a quarter period,
    !> of parts a seventh of their range, so that a few rounds reach anything between two first manoeuvres
    real(dp), parameter :: STEPS(N) = [0.3_dp, 0.3_dp, 0.3_dp, 0.5_dp, 0.5_dp, 0.5_dp, 0.15_dp, 0.15_dp, 0.15_dp, &
                                       0.3_dp, 0.3_dp, 0.3_dp, 0.5_dp, 0.5_dp, 0.5_dp]
    integer, parameter :: HALVINGS = 3
    !! Of the steps: to an eighth, which is 4 degrees of a phase
    integer, parameter :: MOST_ROUNDS = 16
    !! Of changes of all numbers, 2N + 1 manoeuvres each: bounds the time of a search that improves little by little
    real(dp), parameter :: SIGMAS = 5
    !! Of the noise, that count as an effect, too: what is called silently wrong is beyond them
    real(dp), parameter :: LEAST_PART = 0.02_dp     !! Of a rod's moment that is worth an activation: 0.6 A m^2 of 30
    real(dp), parameter :: LEAST_CYCLES = 0.5_dp    !! Of a slow component: less is hard to tell from bias and drift
    real(dp), parameter :: WORTH = 0.995_dp         !! An improvement is to this part at least; less ends a step's size

    !> Manoeuvres to be judged, as pieces of work.
    type, extends(parallel_work_t) :: judging_t
        type(plan_t), pointer :: plan => null()
        type(calibration_t) :: flown            !! Flies the plan's manoeuvre at its place
        type(design_settings_t) :: settings
        integer :: waveform = SINE              !! Of the fast components
        real(dp), allocatable :: x(:, :)        !! (N, manoeuvres)
        type(reliable_design_t), allocatable :: judged(:)
    contains
        procedure :: do_one => judge_one
    end type judging_t

contains

    !> The manoeuvre of a plan for one place, made reliable as far as this search can. It ends when no wrong belief can
    !> move a component by more than is wanted. Fails when the reliability of the plan's own manoeuvre cannot be
    !> determined.
    subroutine make_reliable(request, plan, wanted, found, error, progress)
        type(plan_request_t), intent(in) :: request
        type(plan_t), intent(in), target :: plan        !! With its manoeuvre
        real(dp), intent(in) :: wanted                  !! Largest undetected effect on a component, m
        type(reliable_design_t), intent(out) :: found
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the manoeuvres looked at

        type(judging_t) :: work
        type(reliable_design_t) :: single
        real(dp) :: x(N), best(N), scale
        integer :: i, spent, round

        work%plan => plan
        work%flown = planned_calibration(request, plan)
        work%flown%options%wanted_accuracy = wanted
        work%settings = request%settings
        x = 0
        x(SLOW_CYCLES) = 1
        associate (rods => plan%design%rods)
            work%waveform = rods%activations(1)%waveform
            work%settings%rod_used = [(any(rods%activations(:rods%count)%axis == i), i=1, 3)]
            do i = 1, rods%count
                associate (rod => rods%activations(i))
                    x(FAST_CYCLES(rod%axis)) = rod%frequency*plan%arc%knowledge%duration
                    x(FAST_PHASE(rod%axis)) = rod%phase
                end associate
            end do
        end associate
        work%x = reshape(x, [N, 1])
        call judge_all(work, error)
        if (allocated(error)) return
        found = work%judged(1)
        spent = 1
        if (any(found%effect > wanted)) then
            work%x = starts(x)
            call tell(progress, 'reliability, first manoeuvres')
            call judge_all(work, error, progress)
            if (allocated(error)) return
            i = minloc(work%judged%sum, 1)
            if (work%judged(i)%sum < found%sum) then
                x = work%x(:, i)
                found = work%judged(i)
            end if
            spent = spent + size(work%judged)
        end if
        scale = 1
        do round = 1, min(MOST_ROUNDS, request%settings%refinement_steps)
            if (all(found%effect <= wanted) .or. scale < 0.9_dp*0.5_dp**HALVINGS) exit   ! 0.9: rounding
            work%x = neighbours(x, scale)
            call tell(progress, 'reliability, refinement')
            call judge_all(work, error, progress)
            if (allocated(error)) return
            i = minloc(work%judged%sum, 1)
            single = work%judged(i)
            best = work%x(:, i)
            work%x = reshape(x + together(work%x, x, work%judged%sum, found%sum), [N, 1])
            spent = spent + size(work%judged) + 1
            call judge_all(work, error)
            if (allocated(error)) return
            if (work%judged(1)%sum < single%sum) then
                single = work%judged(1)
                best = work%x(:, 1)
            end if
            if (single%sum < WORTH*found%sum) then
                x = best
                found = single
            else
                scale = scale/2
            end if
        end do
        found%evaluations = spent
        if (.not. found%design%allowed) call fail(error, 'no manoeuvre whose reliability can be determined was found')
    end subroutine make_reliable

    subroutine judge_all(work, error, progress)
        type(judging_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        if (allocated(work%judged)) deallocate (work%judged)
        allocate (work%judged(size(work%x, 2)))
        call expect_pieces(progress, size(work%judged), 'manoeuvres')
        call run_parallel(work, size(work%judged), work%settings%threads, error, progress)
    end subroutine judge_all

    !> A manoeuvre with a slow component: all orders of few cycles over the rods, begun as sines and as
    !> cosines, with several parts.
    pure function starts(x) result(list)
        real(dp), intent(in) :: x(N)
        real(dp), allocatable :: list(:, :)

        real(dp), parameter :: CYCLES(3) = [1.0_dp, 2.0_dp, 3.0_dp], PARTS(2) = [0.2_dp, 0.5_dp]
        integer, parameter :: ORDERS(3, 6) = reshape([1, 2, 3, 1, 3, 2, 2, 1, 3, 2, 3, 1, 3, 1, 2, 3, 2, 1], [3, 6])
        integer :: order, k, start, i

        allocate (list(N, 2*size(ORDERS, 2)*size(PARTS)))
        list = spread(x, 2, size(list, 2))
        i = 0
        do k = 1, size(PARTS)
            do start = 0, 1
                do order = 1, size(ORDERS, 2)
                    i = i + 1
                    list(PART, i) = PARTS(k)
                    list(SLOW_PHASE, i) = start*PI/2
                    list(SLOW_CYCLES, i) = CYCLES(ORDERS(:, order))
                end do
            end do
        end do
    end function starts

    !> Each number changed by a step, up and down.
    pure function neighbours(x, scale) result(list)
        real(dp), intent(in) :: x(N), scale
        real(dp) :: list(N, 2*N)

        integer :: i

        list = spread(x, 2, 2*N)
        do i = 1, N
            list(i, 2*i - 1) = x(i) + scale*STEPS(i)
            list(i, 2*i) = x(i) - scale*STEPS(i)
        end do
    end function neighbours

    !> Half of all single changes that are better than what is there: of each number the better one.
    pure function together(list, x, sums, present_sum) result(change)
        real(dp), intent(in) :: list(:, :), x(N), sums(:), present_sum
        real(dp) :: change(N)

        integer :: i, k

        change = 0
        do i = 1, N
            k = 2*i - 2 + minloc(sums(2*i - 1:2*i), 1)
            if (sums(k) < present_sum) change(i) = (list(i, k) - x(i))/2
        end do
    end function together

    !> The manoeuvre of its numbers.
    function rods_of(work, x) result(rods)
        type(judging_t), intent(in) :: work
        real(dp), intent(in) :: x(N)
        type(torque_rods_t) :: rods

        integer :: axis

        associate (duration => work%plan%arc%knowledge%duration, settings => work%settings)
            do axis = 1, 3
                if (.not. settings%rod_used(axis)) cycle
                call add(SINE, x(PART(axis)), x(SLOW_CYCLES(axis)), x(SLOW_PHASE(axis)))
                call add(work%waveform, 1 - x(PART(axis)), x(FAST_CYCLES(axis)), x(FAST_PHASE(axis)))
            end do
        end associate

    contains

        subroutine add(waveform, part_of, cycles, phase)
            integer, intent(in) :: waveform
            real(dp), intent(in) :: part_of, cycles, phase

            type(rod_activation_t) :: rod

            if (part_of < LEAST_PART) return
            rod%axis = axis
            rod%amplitude = part_of*work%settings%amplitude
            rod%frequency = cycles/work%plan%arc%knowledge%duration
            rod%phase = modulo(phase, TWO_PI)
            rod%stop = work%plan%arc%knowledge%duration
            rod%waveform = waveform
            if (waveform == TAPERED) rod%taper = work%settings%taper
            rod%rise_time = work%settings%rise_time
            rods%count = rods%count + 1
            rods%activations(rods%count) = rod
        end subroutine add
    end function rods_of

    subroutine judge_one(self, i, error)
        class(judging_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: flown
        real(dp) :: fast(3)
        integer :: k

        associate (x => self%x(:, i), judged => self%judged(i), settings => self%settings)
            fast = x(FAST_CYCLES)/self%plan%arc%knowledge%duration
            if (any(x(PART) < 0) .or. any(x(PART) > 1) .or. any(x(SLOW_CYCLES) < LEAST_CYCLES) .or. &
                any(settings%rod_used .and. (fast < settings%lowest_frequency .or. fast > settings%highest_frequency))) return
            call judge_manoeuvre(self%plan%arc, self%plan%sites, rods_of(self, x), 1, judged%design)
            if (.not. judged%design%allowed) return
            flown = self%flown
            call take_manoeuvre(judged%design%rods, flown%case%satellite%rods)
            call reliability_of_case(flown%case, flown%options, judged%report, error)
            if (allocated(error)) then
                deallocate (error)      ! this manoeuvre does not do, others may
                return
            end if
            judged%effect = judged%report%undetected(.false.)
            associate (wanted => judged%report%wanted)
                judged%sum = sum(part_beyond(SIGMAS*judged%design%sigma, wanted)) + part_beyond(judged%design%worst, wanted)
                do k = 1, size(judged%report%values)
                    judged%sum = judged%sum + sum(part_beyond(free_effect(judged%report%values(k)), wanted))
                end do
            end associate
        end associate
    end subroutine judge_one

    !> 0 for effects far below what is wanted, 1 for those far above: what cannot be reached does not hide the rest.
    elemental real(dp) function part_beyond(effect, wanted) result(part_of)
        real(dp), intent(in) :: effect, wanted      !! m

        part_of = effect**2/(effect**2 + wanted**2)
    end function part_beyond

    !> The effect of a minimal detectable value, even one that is not conceivable: so that the search sees it fall.
    pure function free_effect(test) result(effect)
        type(value_test_t), intent(in) :: test
        real(dp) :: effect(3)       !! m

        effect = test%effect
        if (test%sigma > 0 .and. .not. test%all_or_nothing .and. test%detectable > test%largest) &
            effect = effect*(test%detectable/test%largest)
    end function free_effect
end module gracecg_planning_reliable_design
