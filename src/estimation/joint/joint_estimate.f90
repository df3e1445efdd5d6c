!> One offset from several calibrations: the least squares of all of them together, out of the information of
!> each, and the tests of whether they agree.
!>
!> The offset is that of the last run. Earlier ones saw it before the changes that are known since (masses that
!> were moved), each with its standard deviation: d_run = d - sum (change + its error). Scale factors, rods' gain,
!> magnetometer bias and inertia are the satellite's: one value for all runs, its a-priori knowledge counted once,
!> unless a group is told to be each run's own.
!>
!> Whether a run agrees with the others is tested by giving it an offset of its own, d + delta (J. A. Hausman,
!> Econometrica 46 (1978) 1251-1271: estimates that agree but for chance differ with a covariance that the fit
!> knows): delta^T Cov(delta)^-1 delta has the chi-square distribution of three degrees of freedom.
module gracecg_estimation_joint_estimate
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, add_context, number_text
    use gracecg_base_statistics, only: chi_square_tail
    use gracecg_base_text, only: integer_text
    use gracecg_base_vectors, only: identity
    use gracecg_environment_time, only: utc_t, seconds_between
    use gracecg_estimation_information, only: information_t, eliminated_t, no_information, squares_of
    use gracecg_observations_parameters, only: parameter_names
    use gracecg_estimation_run_information, only: run_information_t, JOINED, JOINED_COUNT, SHARED_GROUPS, &
        GROUP_OF_JOINED, GROUP_OF_BELIEF
    use gracecg_estimation_offset_change, only: offset_change_t, is_between
    implicit none
    private
    public :: joint_options_t, joint_solution_t, joint_sigma, run_verdict_t, estimate_jointly, FAMILY_LEVEL

    real(dp), parameter :: FAMILY_LEVEL = 1e-3_dp       !! Of all tests of agreement together
    real(dp), parameter :: SAME_BELIEF = 1e-12_dp       !! Relative

    !> What runs have in common.
    type :: joint_options_t
        logical :: own(size(SHARED_GROUPS)) = .false.       !! A group of parameters is each run's own
        logical :: added(size(SHARED_GROUPS)) = .false.     !! A group is estimated though the runs did not
        type(offset_change_t), allocatable :: changes(:)    !! Known ones of the offset; not allocated: none
    end type joint_options_t

    !> A run beside the others. Body axes, m.
    type :: run_verdict_t
        real(dp) :: offset(3) = 0               !! d at the last run's time, by this run alone
        real(dp) :: sigma(3) = 0                !! Of it
        real(dp) :: difference(3) = 0           !! This run alone minus all others
        real(dp) :: difference_sigma(3) = 0     !! Of it, if they agree
        real(dp) :: statistic = 0               !! Chi square of the difference, 3 degrees of freedom
        real(dp) :: probability = 1             !! That chance makes so much
        logical :: agrees = .true.              !! Within the level of the family
        real(dp) :: squares = 0                 !! Weighted squares of its residuals at the joint estimate
        integer :: redundancy = 0               !! Their degrees of freedom
        real(dp) :: point(JOINED_COUNT) = 0     !! JOINED of this run at the joint estimate, SI units
    end type run_verdict_t

    !> The joint estimate.
    type :: joint_solution_t
        real(dp) :: offset(3) = 0               !! d at the time of the last run, body axes, m
        real(dp) :: covariance(3, 3) = 0        !! m^2
        real(dp) :: parameter(JOINED_COUNT) = 0         !! Shared ones beside the offset, SI units
        real(dp) :: parameter_sigma(JOINED_COUNT) = 0   !! 0 for those that are not estimated, or not shared
        type(run_verdict_t), allocatable :: runs(:)     !! In the order given
        real(dp) :: statistic = 0               !! Chi square of all differences
        integer :: degrees = 0                  !! Of freedom
        real(dp) :: probability = 1             !! That chance makes so much
        logical :: consistent = .true.          !! All runs agree
        integer :: last = 1                     !! The run whose time the offset is of
    end type joint_solution_t

    !> What runs share, and what each has of its own. The parameters of a run are those that are shared, then the errors
    !> of changes, then its own, then, of a run with an offset d + delta of its own, delta.
    type :: layout_t
        type(utc_t) :: time                     !! Which the offset is of
        type(offset_change_t), allocatable :: changes(:)    !! Known ones of the offset
        integer :: count = 0                    !! Of what all runs have in common: shared ones and errors of changes
        integer, allocatable :: shared(:)       !! Places among JOINED, the offset first
        integer, allocatable :: own(:)          !! Places among JOINED
        integer, allocatable :: change(:, :)    !! (2, .): number and axis of each change that is not exact
        character(12), allocatable :: names(:)  !! (count), for messages
    end type layout_t

    !> A run in what all have in common. Its own parameters meet no other run's, so that they are eliminated run by run,
    !> and the work grows with the number of runs.
    type :: part_t
        type(information_t) :: information      !! About what all have in common
        type(eliminated_t) :: own               !! What is its own
    end type part_t

contains

    !> Standard deviation of the offset, body axes.
    pure function joint_sigma(solution) result(sigma)
        type(joint_solution_t), intent(in) :: solution
        real(dp) :: sigma(3)        !! m

        integer :: i

        sigma = [(sqrt(solution%covariance(i, i)), i=1, 3)]
    end function joint_sigma

    !> The joint estimate and its tests. Fails when there is no run, when beliefs differ about what is shared, or the
    !> runs together do not determine the offset.
    subroutine estimate_jointly(runs, options, solution, error)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(joint_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(layout_t) :: layout
        type(part_t) :: parts(size(runs))
        real(dp), allocatable :: value(:), covariance(:, :)
        integer :: i

        if (size(runs) == 0) then
            call fail(error, 'a joint estimate needs at least one run')
            return
        end if
        do i = 1, size(runs)
            if (.not. allocated(runs(i)%matrix)) call fail(error, 'run '//integer_text(i)//' has not been estimated')
            if (allocated(error)) return
        end do
        call check_beliefs(runs, options, error)
        if (allocated(error)) return
        do i = 2, size(runs)
            if (seconds_between(runs(solution%last)%epoch, runs(i)%epoch) > 0) solution%last = i
        end do
        call solve(runs, options, runs(solution%last)%epoch, layout, parts, value, covariance, error)
        call add_context(error, 'joint estimate')
        if (allocated(error)) return
        solution%offset = value(:3)
        solution%covariance = covariance(:3, :3)
        associate (beside => layout%shared(4:))
            solution%parameter(beside) = value(4:size(layout%shared))
            solution%parameter_sigma(beside) = [(sqrt(covariance(i, i)), i=4, size(layout%shared))]
        end associate
        allocate (solution%runs(size(runs)))
        do i = 1, size(runs)
            call place_run(runs(i), layout, parts(i), value, solution%runs(i))
            call look_at_run_alone(runs(i), options, layout, solution%runs(i), error)
            call add_context(error, 'run '//integer_text(i)//' alone')
            if (allocated(error)) return
        end do
        if (size(runs) > 1) call test_agreement(runs, layout, parts, value, solution, error)
    end subroutine estimate_jointly

    !> What is shared must be an error of the same belief in every run.
    subroutine check_beliefs(runs, options, error)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(error_t), allocatable, intent(out) :: error

        integer :: i, k, group

        do i = 2, size(runs)
            do k = 1, size(GROUP_OF_BELIEF)
                group = GROUP_OF_BELIEF(k)
                if (options%own(group) .or. .not. is_estimated(runs, options, group)) cycle
                if (abs(runs(i)%belief(k) - runs(1)%belief(k)) <= SAME_BELIEF*maxval(abs(runs(1)%belief))) cycle
                call fail(error, 'runs 1 and '//integer_text(i)//' ('//trim(runs(1)%name)//', '//trim(runs(i)%name)// &
                          ') believe different '//trim(SHARED_GROUPS(group))//': '//number_text(runs(1)%belief(k))// &
                          ' and '//number_text(runs(i)%belief(k))//'; they share the error of one belief: give both '// &
                          'the same, or let each have its own (--own '//trim(SHARED_GROUPS(group))//')')
                return
            end do
        end do
    end subroutine check_beliefs

    pure logical function is_estimated(runs, options, group)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        integer, intent(in) :: group

        integer :: i

        is_estimated = options%added(group)
        do i = 1, size(runs)
            is_estimated = is_estimated .or. any(runs(i)%estimated .and. GROUP_OF_JOINED == group)
        end do
    end function is_estimated

    !> Sorts the parameters.
    subroutine lay_out(runs, options, time, layout)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(utc_t), intent(in) :: time         !! Which the offset is of
        type(layout_t), intent(out) :: layout

        logical :: in_use(4:JOINED_COUNT), is_own(4:JOINED_COUNT)
        integer :: i, j

        in_use = [(is_estimated(runs, options, GROUP_OF_JOINED(j)), j=4, JOINED_COUNT)]
        is_own = options%own(GROUP_OF_JOINED(4:))
        layout%shared = [1, 2, 3, pack([(j, j=4, JOINED_COUNT)], in_use .and. .not. is_own)]
        layout%own = pack([(j, j=4, JOINED_COUNT)], in_use .and. is_own)
        layout%time = time
        allocate (layout%change(2, 0), layout%changes(0))
        if (allocated(options%changes)) layout%changes = options%changes
        do i = 1, size(layout%changes)
            do j = 1, 3
                if (layout%changes(i)%sigma(j) > 0) &
                    layout%change = reshape([layout%change, i, j], [2, size(layout%change, 2) + 1])
            end do
        end do
        layout%names = [character(12) :: parameter_names(JOINED(layout%shared)), &
                        spread('change', 1, size(layout%change, 2))]
        layout%count = size(layout%names)
    end subroutine lay_out

    !> The least squares of all runs together: what they share.
    subroutine solve(runs, options, time, layout, parts, value, covariance, error)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(utc_t), intent(in) :: time         !! Which the offset is of
        type(layout_t), intent(out) :: layout
        type(part_t), intent(out) :: parts(:)   !! The runs
        real(dp), allocatable, intent(out) :: value(:), covariance(:, :)
        type(error_t), allocatable, intent(out) :: error

        type(information_t) :: all_runs
        integer :: i

        call lay_out(runs, options, time, layout)
        all_runs = known_beforehand(runs(1), layout)
        do i = 1, size(runs)
            call take_part(runs(i), layout, .false., parts(i), error)
            if (allocated(error)) return
            call all_runs%add(parts(i)%information)
        end do
        allocate (value(layout%count), covariance(layout%count, layout%count))
        call all_runs%solve(value, covariance, error, layout%names)
    end subroutine solve

    !> A-priori knowledge of what is shared, counted once, and of the changes.
    pure function known_beforehand(first, layout) result(information)
        type(run_information_t), intent(in) :: first        !! Run
        type(layout_t), intent(in) :: layout
        type(information_t) :: information

        integer :: k

        information = no_information(layout%count)
        do k = 1, size(layout%shared)
            call information%expect(k, first%prior_sigma(layout%shared(k)))
        end do
        do k = 1, size(layout%change, 2)
            associate (change => layout%changes(layout%change(1, k)), axis => layout%change(2, k))
                call information%expect(size(layout%shared) + k, change%sigma(axis))
            end associate
        end do
    end function known_beforehand

    !> What a run says of what all have in common.
    subroutine take_part(run, layout, free, part, error)
        type(run_information_t), intent(in) :: run
        type(layout_t), intent(in) :: layout
        logical, intent(in) :: free             !! It has an offset of its own
        type(part_t), intent(out) :: part
        type(error_t), allocatable, intent(out) :: error

        character(12), allocatable :: names(:)
        real(dp), allocatable :: map(:, :)
        real(dp) :: fixed(JOINED_COUNT)
        integer :: k

        call map_of(run, layout, free, map, fixed)
        part%information = run%seen_through(map, fixed - run%point)
        do k = 1, size(layout%own)
            call part%information%expect(layout%count + k, run%prior_sigma(layout%own(k)))
        end do
        names = [character(12) :: parameter_names(JOINED(layout%own)), spread('offset', 1, merge(3, 0, free))]
        call part%information%eliminate(layout%count, part%own, error, names)
    end subroutine take_part

    !> JOINED of a run as a linear function of the parameters: map parameters + fixed.
    pure subroutine map_of(run, layout, free, map, fixed)
        type(run_information_t), intent(in) :: run
        type(layout_t), intent(in) :: layout
        logical, intent(in) :: free             !! The run has an offset of its own
        real(dp), allocatable, intent(out) :: map(:, :)
        real(dp), intent(out) :: fixed(JOINED_COUNT)

        real(dp), allocatable :: on_change(:, :)
        real(dp) :: unit(JOINED_COUNT, JOINED_COUNT), change(3), variance(3)
        integer :: k

        unit = identity(JOINED_COUNT)
        on_change = -unit(:, layout%change(2, :))
        do k = 1, size(on_change, 2)
            if (.not. is_between(layout%changes(layout%change(1, k)), run%epoch, layout%time)) on_change(:, k) = 0
        end do
        map = reshape([unit(:, layout%shared), on_change, unit(:, layout%own), unit(:, :merge(3, 0, free))], &
                      [JOINED_COUNT, layout%count + size(layout%own) + merge(3, 0, free)])
        call change_since(run, layout, change, variance)
        fixed = 0
        fixed(:3) = -change
    end subroutine map_of

    !> The known change of the offset since a run, m, and its variance, m^2.
    pure subroutine change_since(run, layout, change, variance)
        type(run_information_t), intent(in) :: run
        type(layout_t), intent(in) :: layout
        real(dp), intent(out) :: change(3), variance(3)

        integer :: k

        change = 0
        variance = 0
        do k = 1, size(layout%changes)
            if (.not. is_between(layout%changes(k), run%epoch, layout%time)) cycle
            change = change + layout%changes(k)%change
            variance = variance + layout%changes(k)%sigma**2
        end do
    end subroutine change_since

    !> A run at the joint estimate: its values and the squares of its residuals.
    subroutine place_run(run, layout, part, value, verdict)
        type(run_information_t), intent(in) :: run
        type(layout_t), intent(in) :: layout
        type(part_t), intent(in) :: part
        real(dp), intent(in) :: value(:)        !! Of what all have in common
        type(run_verdict_t), intent(inout) :: verdict

        real(dp), allocatable :: map(:, :)
        real(dp) :: fixed(JOINED_COUNT)

        call map_of(run, layout, .false., map, fixed)
        verdict%point = matmul(map, [value, part%own%value_at(value)]) + fixed
        verdict%squares = run%squares_at(verdict%point - run%point)
        verdict%redundancy = run%redundancy
    end subroutine place_run

    !> What a run says alone.
    subroutine look_at_run_alone(run, options, layout, verdict, error)
        type(run_information_t), intent(in) :: run
        type(joint_options_t), intent(in) :: options
        type(layout_t), intent(in) :: layout    !! Of all runs
        type(run_verdict_t), intent(inout) :: verdict
        type(error_t), allocatable, intent(out) :: error

        type(layout_t) :: own
        type(part_t) :: parts(1)
        real(dp), allocatable :: value(:), covariance(:, :)
        real(dp) :: change(3), variance(3)
        integer :: j

        call solve([run], options, run%epoch, own, parts, value, covariance, error)
        if (allocated(error)) return
        call change_since(run, layout, change, variance)
        verdict%offset = value(:3) + change
        verdict%sigma = sqrt([(covariance(j, j), j=1, 3)] + variance)
    end subroutine look_at_run_alone

    !> Each run against all others, and all against one offset: the sum of squares falls, when every run but the last
    !> has an offset of its own, by what x^T C^-1 x of all their differences is.
    subroutine test_agreement(runs, layout, parts, value, solution, error)
        type(run_information_t), intent(in) :: runs(:)
        type(layout_t), intent(in) :: layout
        type(part_t), intent(in) :: parts(:)
        real(dp), intent(in) :: value(:)        !! Of what all have in common
        type(joint_solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(part_t) :: free(size(runs))
        ! sums over the runs before each (and what is known beforehand), and over those after it: no difference of
        ! sums, in which a run that says little would be lost
        type(information_t) :: before(size(runs) + 1), after, with_free
        real(dp) :: covariance(layout%count, layout%count), shared(layout%count)
        integer :: i

        before(1) = known_beforehand(runs(1), layout)
        with_free = before(1)
        do i = 1, size(runs)
            call take_part(runs(i), layout, .true., free(i), error)
            if (allocated(error)) return
            before(i + 1) = before(i)
            call before(i + 1)%add(parts(i)%information)
            if (i == solution%last) call with_free%add(parts(i)%information)
            if (i /= solution%last) call with_free%add(free(i)%information)
        end do
        call with_free%solve(shared, covariance, error, layout%names)
        if (allocated(error)) return
        solution%statistic = before(size(runs) + 1)%squares_at(value) - with_free%squares_at(shared)
        solution%degrees = 3*(size(runs) - 1)
        solution%probability = chi_square_tail(max(0.0_dp, solution%statistic), solution%degrees)
        after = no_information(layout%count)
        do i = size(runs), 1, -1
            call before(i)%add(free(i)%information)
            call before(i)%add(after)
            call before(i)%solve(shared, covariance, error, layout%names)
            if (allocated(error)) return
            call judge(size(layout%own), free(i)%own, shared, covariance, FAMILY_LEVEL/size(runs), solution%runs(i))
            call after%add(parts(i)%information)
        end do
        solution%consistent = solution%probability > FAMILY_LEVEL .and. all(solution%runs%agrees)
    end subroutine test_agreement

    !> The difference of a run that has an offset of its own, behind its other parameters.
    subroutine judge(others, free, shared, covariance, level, verdict)
        integer, intent(in) :: others               !! Of its parameters
        type(eliminated_t), intent(in) :: free      !! What is its own
        real(dp), intent(in) :: shared(:), covariance(:, :)     !! What all runs then share
        real(dp), intent(in) :: level               !! Of the test
        type(run_verdict_t), intent(inout) :: verdict

        real(dp) :: own(others + 3), own_covariance(others + 3, others + 3)
        integer :: j

        own = free%value_at(shared)
        own_covariance = free%covariance_with(covariance)
        verdict%difference = own(others + 1:)
        verdict%difference_sigma = [(sqrt(own_covariance(j, j)), j=others + 1, others + 3)]
        verdict%statistic = squares_of(verdict%difference, own_covariance(others + 1:, others + 1:))
        verdict%probability = chi_square_tail(verdict%statistic, 3)
        verdict%agrees = verdict%probability > level
    end subroutine judge
end module gracecg_estimation_joint_estimate
