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
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_statistics, only: chi_square_tail
    use gracecg_base_text, only: integer_text
    use gracecg_environment_time, only: utc_t, seconds_between
    use gracecg_observations_parameters, only: parameter_names
    use gracecg_estimation_parameters, only: JOINED
    use gracecg_estimation_run_information, only: run_information_t, JOINED_COUNT, SHARED_GROUPS, &
        GROUP_OF_JOINED, GROUP_OF_BELIEF
    use gracecg_estimation_offset_change, only: offset_change_t, is_between
    implicit none
    private
    public :: joint_options_t, joint_solution_t, run_verdict_t, estimate_jointly, FAMILY_LEVEL

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

    !> Places of what runs share, and of what each has of its own.
    type :: layout_t
        integer :: count = 0                    !! Of shared parameters
        integer :: place(JOINED_COUNT) = 0      !! Of JOINED among them; 0: elsewhere
        integer, allocatable :: change(:, :)    !! (3, changes): errors of changes; 0: exact
        integer :: own_count = 0                !! Of a run's own parameters
        integer :: own(JOINED_COUNT) = 0        !! Of JOINED among them; 0: elsewhere
    end type layout_t

    !> The normal equations of a run, reduced to what is shared: a run's own parameters meet no other run's, so that
    !> they are eliminated run by run, and the work grows with the number of runs.
    type :: equations_t
        real(dp), allocatable :: normal(:, :), rhs(:)   !! Of the shared parameters
        real(dp), allocatable :: inverse(:, :)          !! Of its own parameters, the shared ones kept
        real(dp), allocatable :: own(:)                 !! Their values where the shared ones are 0
        real(dp), allocatable :: gain(:, :)             !! By which they fall with the shared ones, (shared, own)
        real(dp) :: squares = 0                         !! By which they lower the sum of squares
    end type equations_t

contains

    !> The joint estimate and its tests. Fails when there is no run, when beliefs differ about what is shared, or the
    !> runs together do not determine the offset.
    subroutine estimate_jointly(runs, options, solution, error)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(joint_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(layout_t) :: layout
        type(equations_t), allocatable :: equations(:)
        real(dp), allocatable :: value(:), covariance(:, :)
        integer :: i, j

        if (size(runs) == 0) then
            call fail(error, 'a joint estimate needs at least one run')
            return
        end if
        call check_beliefs(runs, options, error)
        if (allocated(error)) return
        solution%last = 1
        do i = 2, size(runs)
            if (seconds_between(runs(solution%last)%epoch, runs(i)%epoch) > 0) solution%last = i
        end do
        call solve(runs, options, runs(solution%last)%epoch, layout, equations, value, covariance, error)
        call add_context(error, 'joint estimate')
        if (allocated(error)) return
        solution%offset = value(:3)
        solution%covariance = covariance(:3, :3)
        do j = 4, JOINED_COUNT
            associate (k => layout%place(j))
                if (k == 0) cycle
                solution%parameter(j) = value(k)
                solution%parameter_sigma(j) = sqrt(covariance(k, k))
            end associate
        end do
        allocate (solution%runs(size(runs)))
        do i = 1, size(runs)
            call place_run(runs(i), options, layout, equations(i), value, runs(solution%last)%epoch, solution%runs(i))
            call look_at_run_alone(runs(i), options, runs(solution%last)%epoch, solution%runs(i), error)
            call add_context(error, 'run '//integer_text(i)//' alone')
            if (allocated(error)) return
        end do
        if (size(runs) > 1) call test_agreement(runs, options, layout, equations, value, solution, error)
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

    !> Numbers the parameters.
    subroutine lay_out(runs, options, layout)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(layout_t), intent(out) :: layout

        integer :: i, j, changes

        changes = 0
        if (allocated(options%changes)) changes = size(options%changes)
        allocate (layout%change(3, changes), source=0)
        layout%place(:3) = [1, 2, 3]
        layout%count = 3
        do j = 4, JOINED_COUNT
            if (.not. is_estimated(runs, options, GROUP_OF_JOINED(j))) cycle
            if (options%own(GROUP_OF_JOINED(j))) then
                layout%own_count = layout%own_count + 1
                layout%own(j) = layout%own_count
            else
                layout%count = layout%count + 1
                layout%place(j) = layout%count
            end if
        end do
        do i = 1, changes
            do j = 1, 3
                if (.not. options%changes(i)%sigma(j) > 0) cycle
                layout%count = layout%count + 1
                layout%change(j, i) = layout%count
            end do
        end do
    end subroutine lay_out

    !> The least squares of all runs together: what they share.
    subroutine solve(runs, options, time, layout, equations, value, covariance, error)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(utc_t), intent(in) :: time         !! Which the offset is of
        type(layout_t), intent(out) :: layout
        type(equations_t), allocatable, intent(out) :: equations(:)     !! Of each run
        real(dp), allocatable, intent(out) :: value(:), covariance(:, :)
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: normal(:, :), rhs(:)
        integer :: i

        call lay_out(runs, options, layout)
        allocate (equations(size(runs)), value(layout%count), covariance(layout%count, layout%count), rhs(layout%count))
        normal = known_beforehand(runs(1), options, layout)
        rhs = 0
        do i = 1, size(runs)
            call set_up(runs(i), options, layout, time, .false., equations(i), error)
            if (allocated(error)) return
            normal = normal + equations(i)%normal
            rhs = rhs + equations(i)%rhs
        end do
        call solve_shared(layout, normal, rhs, value, covariance, error)
    end subroutine solve

    subroutine solve_shared(layout, normal, rhs, value, covariance, error)
        type(layout_t), intent(in) :: layout
        real(dp), intent(in) :: normal(:, :), rhs(:)
        real(dp), intent(out) :: value(:), covariance(:, :)
        type(error_t), allocatable, intent(out) :: error

        character(12) :: names(layout%count)
        real(dp) :: condition
        integer :: j

        names = 'change'
        do j = 1, JOINED_COUNT
            if (layout%place(j) > 0) names(layout%place(j)) = parameter_names(JOINED(j))
        end do
        call solve_normal_equations(normal, rhs, value, covariance, condition, error, names)
    end subroutine solve_shared

    !> A-priori knowledge of what is shared, counted once, and of the changes.
    function known_beforehand(first, options, layout) result(normal)
        type(run_information_t), intent(in) :: first        !! Run
        type(joint_options_t), intent(in) :: options
        type(layout_t), intent(in) :: layout
        real(dp) :: normal(layout%count, layout%count)

        integer :: i, j, k

        normal = 0
        do j = 1, JOINED_COUNT
            k = layout%place(j)
            if (k > 0 .and. first%prior_sigma(j) > 0) normal(k, k) = 1/first%prior_sigma(j)**2
        end do
        do i = 1, size(layout%change, 2)
            do j = 1, 3
                k = layout%change(j, i)
                if (k > 0) normal(k, k) = 1/options%changes(i)%sigma(j)**2
            end do
        end do
    end function known_beforehand

    !> The equations of a run, which may have an offset of its own, d + delta: delta stands behind its other parameters.
    subroutine set_up(run, options, layout, time, free, equations, error)
        type(run_information_t), intent(in) :: run
        type(joint_options_t), intent(in) :: options
        type(layout_t), intent(in) :: layout
        type(utc_t), intent(in) :: time         !! Which the offset is of
        logical, intent(in) :: free             !! It has an offset of its own
        type(equations_t), intent(out) :: equations
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: map(:, :), normal(:, :), rhs(:)
        character(12), allocatable :: names(:)
        real(dp) :: fixed(JOINED_COUNT), condition
        integer :: j, k, n, own

        call map_of(run, options, layout, time, free, map, fixed)
        n = layout%count
        own = size(map, 2) - n
        normal = matmul(transpose(map), matmul(run%matrix, map))
        rhs = matmul(transpose(map), run%rhs + matmul(run%matrix, run%point - fixed))
        equations%normal = normal(:n, :n)
        equations%rhs = rhs(:n)
        allocate (equations%inverse(own, own), equations%own(own), equations%gain(n, own), names(own))
        if (own == 0) return
        names = 'offset'
        do j = 1, JOINED_COUNT
            k = layout%own(j)
            if (k == 0) cycle
            names(k) = parameter_names(JOINED(j))
            if (run%prior_sigma(j) > 0) normal(n + k, n + k) = normal(n + k, n + k) + 1/run%prior_sigma(j)**2
        end do
        call solve_normal_equations(normal(n + 1:, n + 1:), rhs(n + 1:), equations%own, equations%inverse, condition, error, &
                                    names)
        if (allocated(error)) return
        equations%gain = matmul(normal(:n, n + 1:), equations%inverse)
        equations%normal = equations%normal - matmul(equations%gain, normal(n + 1:, :n))
        equations%rhs = equations%rhs - matmul(equations%gain, rhs(n + 1:))
        equations%squares = dot_product(rhs(n + 1:), equations%own)
    end subroutine set_up

    !> JOINED of a run as a linear function of shared and own parameters: map parameters + fixed.
    subroutine map_of(run, options, layout, time, free, map, fixed)
        type(run_information_t), intent(in) :: run
        type(joint_options_t), intent(in) :: options
        type(layout_t), intent(in) :: layout
        type(utc_t), intent(in) :: time         !! Which the offset is of
        logical, intent(in) :: free             !! The run has an offset of its own
        real(dp), allocatable, intent(out) :: map(:, :)
        real(dp), intent(out) :: fixed(JOINED_COUNT)

        real(dp) :: change(3), variance(3)
        integer :: j, k

        associate (before => layout%count + layout%own_count)
            allocate (map(JOINED_COUNT, before + merge(3, 0, free)), source=0.0_dp)
            do j = 1, JOINED_COUNT
                if (layout%place(j) > 0) map(j, layout%place(j)) = 1
                if (layout%own(j) > 0) map(j, layout%count + layout%own(j)) = 1
                if (free .and. j <= 3) map(j, before + j) = 1
            end do
        end associate
        call change_between(options, run%epoch, time, change, variance)
        fixed = 0
        fixed(:3) = -change
        do k = 1, size(layout%change, 2)
            if (.not. is_between(options%changes(k), run%epoch, time)) cycle
            do j = 1, 3
                if (layout%change(j, k) > 0) map(j, layout%change(j, k)) = -1
            end do
        end do
    end subroutine map_of

    !> The known change of the offset from one time to a later one, m, and its variance, m^2.
    subroutine change_between(options, from, to, change, variance)
        type(joint_options_t), intent(in) :: options
        type(utc_t), intent(in) :: from, to
        real(dp), intent(out) :: change(3), variance(3)

        integer :: k

        change = 0
        variance = 0
        if (.not. allocated(options%changes)) return
        do k = 1, size(options%changes)
            if (.not. is_between(options%changes(k), from, to)) cycle
            change = change + options%changes(k)%change
            variance = variance + options%changes(k)%sigma**2
        end do
    end subroutine change_between

    !> A run at the joint estimate: its values and the squares of its residuals.
    subroutine place_run(run, options, layout, equations, value, time, verdict)
        type(run_information_t), intent(in) :: run
        type(joint_options_t), intent(in) :: options
        type(layout_t), intent(in) :: layout
        type(equations_t), intent(in) :: equations
        real(dp), intent(in) :: value(:)        !! Of what is shared
        type(utc_t), intent(in) :: time         !! Which the offset is of
        type(run_verdict_t), intent(inout) :: verdict

        real(dp), allocatable :: map(:, :)
        real(dp) :: fixed(JOINED_COUNT), away(JOINED_COUNT)

        call map_of(run, options, layout, time, .false., map, fixed)
        verdict%point = matmul(map, [value, equations%own - matmul(value, equations%gain)]) + fixed
        away = verdict%point - run%point
        verdict%squares = run%squares - 2*dot_product(run%rhs, away) + dot_product(away, matmul(run%matrix, away))
        verdict%redundancy = run%redundancy
    end subroutine place_run

    !> What a run says alone.
    subroutine look_at_run_alone(run, options, time, verdict, error)
        type(run_information_t), intent(in) :: run
        type(joint_options_t), intent(in) :: options
        type(utc_t), intent(in) :: time         !! Which the offset is of
        type(run_verdict_t), intent(inout) :: verdict
        type(error_t), allocatable, intent(out) :: error

        type(layout_t) :: layout
        type(equations_t), allocatable :: equations(:)
        real(dp), allocatable :: value(:), covariance(:, :)
        real(dp) :: change(3), variance(3)
        integer :: j

        call solve([run], options, run%epoch, layout, equations, value, covariance, error)
        if (allocated(error)) return
        call change_between(options, run%epoch, time, change, variance)
        verdict%offset = value(:3) + change
        verdict%sigma = sqrt([(covariance(j, j), j=1, 3)] + variance)
    end subroutine look_at_run_alone

    !> Each run against all others, and all against one offset: the sum of squares falls, when every run but the last
    !> has an offset of its own, by what x^T C^-1 x of all their differences is.
    subroutine test_agreement(runs, options, layout, equations, value, solution, error)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(layout_t), intent(in) :: layout
        type(equations_t), intent(in) :: equations(:)
        real(dp), intent(in) :: value(:)        !! Of what is shared
        type(joint_solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(equations_t) :: free(size(runs))
        ! sums over the runs before each (and what is known beforehand), and over those after it: no difference of
        ! sums, in which a run that says little would be lost
        real(dp), allocatable :: before(:, :, :), before_rhs(:, :)
        real(dp), dimension(layout%count, layout%count) :: after, covariance, normal
        real(dp), dimension(layout%count) :: after_rhs, rhs, shared
        integer :: i

        allocate (before(layout%count, layout%count, size(runs)), before_rhs(layout%count, size(runs)))
        before(:, :, 1) = known_beforehand(runs(1), options, layout)
        before_rhs(:, 1) = 0
        normal = before(:, :, 1)
        rhs = 0
        do i = 1, size(runs)
            call set_up(runs(i), options, layout, runs(solution%last)%epoch, .true., free(i), error)
            if (allocated(error)) return
            if (i > 1) then
                before(:, :, i) = before(:, :, i - 1) + equations(i - 1)%normal
                before_rhs(:, i) = before_rhs(:, i - 1) + equations(i - 1)%rhs
            end if
            if (i == solution%last) then
                normal = normal + equations(i)%normal
                rhs = rhs + equations(i)%rhs
            else
                normal = normal + free(i)%normal
                rhs = rhs + free(i)%rhs
                solution%statistic = solution%statistic + (free(i)%squares - equations(i)%squares)
            end if
        end do
        call solve_shared(layout, normal, rhs, shared, covariance, error)
        if (allocated(error)) return
        solution%statistic = solution%statistic + dot_product(rhs, shared) - &
                             dot_product(before_rhs(:, size(runs)) + equations(size(runs))%rhs, value)
        solution%degrees = 3*(size(runs) - 1)
        solution%probability = chi_square_tail(max(0.0_dp, solution%statistic), solution%degrees)
        after = 0
        after_rhs = 0
        do i = size(runs), 1, -1
            call solve_shared(layout, before(:, :, i) + free(i)%normal + after, before_rhs(:, i) + free(i)%rhs + after_rhs, &
                              shared, covariance, error)
            if (allocated(error)) return
            call judge(layout, free(i), shared, covariance, FAMILY_LEVEL/size(runs), solution%runs(i))
            after = after + equations(i)%normal
            after_rhs = after_rhs + equations(i)%rhs
        end do
        solution%consistent = solution%probability > FAMILY_LEVEL .and. all(solution%runs%agrees)
    end subroutine test_agreement

    !> The difference of a run that has an offset of its own.
    subroutine judge(layout, free, shared, covariance, level, verdict)
        type(layout_t), intent(in) :: layout
        type(equations_t), intent(in) :: free       !! Of the run
        real(dp), intent(in) :: shared(:), covariance(:, :)     !! What all runs then share
        real(dp), intent(in) :: level               !! Of the test
        type(run_verdict_t), intent(inout) :: verdict

        real(dp) :: own(size(free%own)), own_covariance(size(free%own), size(free%own))
        integer :: j

        own = free%own - matmul(shared, free%gain)
        own_covariance = free%inverse + matmul(transpose(free%gain), matmul(covariance, free%gain))
        associate (d => layout%own_count)
            verdict%difference = own(d + 1:)
            verdict%difference_sigma = [(sqrt(own_covariance(d + j, d + j)), j=1, 3)]
            verdict%statistic = wald(verdict%difference, own_covariance(d + 1:, d + 1:))
        end associate
        verdict%probability = chi_square_tail(verdict%statistic, 3)
        verdict%agrees = verdict%probability > level
    end subroutine judge

    !> x^T C^-1 x.
    real(dp) function wald(x, covariance)
        real(dp), intent(in) :: x(:), covariance(:, :)

        real(dp) :: weighted(size(x)), inverse(size(x), size(x)), condition
        type(error_t), allocatable :: singular

        call solve_normal_equations(covariance, x, weighted, inverse, condition, singular)
        wald = 0
        if (.not. allocated(singular)) wald = dot_product(x, weighted)
    end function wald
end module gracecg_estimation_joint_estimate
