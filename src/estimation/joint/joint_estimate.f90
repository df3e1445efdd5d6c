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
    use gracecg_estimation_parameters, only: PARAMETER_NAMES
    use gracecg_estimation_run_information, only: run_information_t, JOINED, JOINED_COUNT, SHARED_GROUPS, &
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

    !> Places of the joint parameters.
    type :: layout_t
        integer :: count = 0
        integer, allocatable :: place(:, :)     !! (JOINED_COUNT, runs); 0: not estimated
        integer, allocatable :: change(:, :)    !! (3, changes): errors of changes; 0: exact
        integer, allocatable :: free(:, :)      !! (3, runs): an offset of its own; 0: none
    end type layout_t

contains

    !> The joint estimate and its tests. Fails when there is no run, when beliefs differ about what is shared, or the
    !> runs together do not determine the offset.
    subroutine estimate_jointly(runs, options, solution, error)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(joint_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(layout_t) :: layout
        real(dp), allocatable :: value(:), covariance(:, :)
        logical :: free(size(runs))
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
        free = .false.
        call solve(runs, options, solution%last, free, layout, value, covariance, error)
        call add_context(error, 'joint estimate')
        if (allocated(error)) return
        solution%offset = value(:3)
        solution%covariance = covariance(:3, :3)
        do j = 4, JOINED_COUNT
            associate (k => layout%place(j, 1))
                if (k == 0 .or. options%own(GROUP_OF_JOINED(j))) cycle
                solution%parameter(j) = value(k)
                solution%parameter_sigma(j) = sqrt(covariance(k, k))
            end associate
        end do
        allocate (solution%runs(size(runs)))
        do i = 1, size(runs)
            call place_run(runs, options, layout, value, i, solution)
            call look_at_run_alone(runs, options, i, solution, error)
            if (allocated(error)) return
        end do
        if (size(runs) > 1) call test_all(runs, options, solution, error)
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

    !> Numbers the joint parameters.
    subroutine lay_out(runs, options, free, layout)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        logical, intent(in) :: free(:)          !! (runs): has an offset of its own
        type(layout_t), intent(out) :: layout

        integer :: i, j, changes

        changes = 0
        if (allocated(options%changes)) changes = size(options%changes)
        allocate (layout%place(JOINED_COUNT, size(runs)), layout%change(3, changes), layout%free(3, size(runs)), source=0)
        layout%place(:3, :) = spread([1, 2, 3], 2, size(runs))
        layout%count = 3
        do j = 4, JOINED_COUNT
            if (.not. is_estimated(runs, options, GROUP_OF_JOINED(j))) cycle
            do i = 1, size(runs)
                if (i == 1 .or. options%own(GROUP_OF_JOINED(j))) layout%count = layout%count + 1
                layout%place(j, i) = layout%count
            end do
        end do
        do i = 1, changes
            do j = 1, 3
                if (.not. options%changes(i)%sigma(j) > 0) cycle
                layout%count = layout%count + 1
                layout%change(j, i) = layout%count
            end do
        end do
        do i = 1, size(runs)
            if (.not. free(i)) cycle
            layout%free(:, i) = layout%count + [1, 2, 3]
            layout%count = layout%count + 3
        end do
    end subroutine lay_out

    !> The least squares of all runs together.
    subroutine solve(runs, options, last, free, layout, value, covariance, error)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        integer, intent(in) :: last             !! The run whose time the offset is of
        logical, intent(in) :: free(:)          !! (runs): has an offset of its own
        type(layout_t), intent(out) :: layout
        real(dp), allocatable, intent(out) :: value(:), covariance(:, :)
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: normal(:, :), rhs(:), map(:, :)
        character(12), allocatable :: names(:)
        real(dp) :: condition, fixed(JOINED_COUNT)
        integer :: i, j, k

        call lay_out(runs, options, free, layout)
        allocate (normal(layout%count, layout%count), rhs(layout%count), source=0.0_dp)
        allocate (value(layout%count), covariance(layout%count, layout%count), names(layout%count))
        names = 'change'
        do i = 1, size(runs)
            call map_of(runs, options, layout, runs(last)%epoch, i, map, fixed)
            normal = normal + matmul(transpose(map), matmul(runs(i)%matrix, map))
            rhs = rhs + matmul(transpose(map), runs(i)%rhs + matmul(runs(i)%matrix, runs(i)%point - fixed))
            do j = 1, JOINED_COUNT
                k = layout%place(j, i)
                if (k == 0) cycle
                names(k) = PARAMETER_NAMES(JOINED(j))
                if (i > 1 .and. k == layout%place(j, 1)) cycle      ! counted already
                if (runs(i)%prior_sigma(j) > 0) normal(k, k) = normal(k, k) + 1/runs(i)%prior_sigma(j)**2
            end do
        end do
        do i = 1, size(layout%change, 2)
            do j = 1, 3
                k = layout%change(j, i)
                if (k > 0) normal(k, k) = normal(k, k) + 1/options%changes(i)%sigma(j)**2
            end do
        end do
        call solve_normal_equations(normal, rhs, value, covariance, condition, error, names)
    end subroutine solve

    !> JOINED of a run as a linear function of the joint parameters: map parameters + fixed.
    subroutine map_of(runs, options, layout, time, i, map, fixed)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(layout_t), intent(in) :: layout
        type(utc_t), intent(in) :: time         !! Which the offset is of
        integer, intent(in) :: i                !! The run
        real(dp), allocatable, intent(out) :: map(:, :)
        real(dp), intent(out) :: fixed(JOINED_COUNT)

        real(dp) :: change(3), variance(3)
        integer :: j, k

        allocate (map(JOINED_COUNT, layout%count), source=0.0_dp)
        do j = 1, JOINED_COUNT
            if (layout%place(j, i) > 0) map(j, layout%place(j, i)) = 1
        end do
        call change_between(options, runs(i)%epoch, time, change, variance)
        fixed = 0
        fixed(:3) = -change
        do k = 1, size(layout%change, 2)
            if (.not. is_between(options%changes(k), runs(i)%epoch, time)) cycle
            do j = 1, 3
                if (layout%change(j, k) > 0) map(j, layout%change(j, k)) = -1
            end do
        end do
        do j = 1, 3
            if (layout%free(j, i) > 0) map(j, layout%free(j, i)) = 1
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
    subroutine place_run(runs, options, layout, value, i, solution)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(layout_t), intent(in) :: layout
        real(dp), intent(in) :: value(:)
        integer, intent(in) :: i
        type(joint_solution_t), intent(inout) :: solution

        real(dp), allocatable :: map(:, :)
        real(dp) :: fixed(JOINED_COUNT), away(JOINED_COUNT)

        call map_of(runs, options, layout, runs(solution%last)%epoch, i, map, fixed)
        associate (run => solution%runs(i))
            run%point = matmul(map, value) + fixed
            away = run%point - runs(i)%point
            run%squares = runs(i)%squares - 2*dot_product(runs(i)%rhs, away) + &
                          dot_product(away, matmul(runs(i)%matrix, away))
            run%redundancy = runs(i)%redundancy
        end associate
    end subroutine place_run

    !> What a run says alone, and by how much that differs from what the others say.
    subroutine look_at_run_alone(runs, options, i, solution, error)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        integer, intent(in) :: i
        type(joint_solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(layout_t) :: layout
        real(dp), allocatable :: value(:), covariance(:, :)
        real(dp) :: change(3), variance(3)
        logical :: free(size(runs))
        integer :: j

        associate (run => solution%runs(i))
            call solve(runs(i:i), options, 1, [.false.], layout, value, covariance, error)
            call add_context(error, 'run '//integer_text(i)//' alone')
            if (allocated(error)) return
            call change_between(options, runs(i)%epoch, runs(solution%last)%epoch, change, variance)
            run%offset = value(:3) + change
            run%sigma = sqrt([(covariance(j, j), j=1, 3)] + variance)
            if (size(runs) == 1) return
            free = .false.
            free(i) = .true.
            call solve(runs, options, solution%last, free, layout, value, covariance, error)
            if (allocated(error)) return
            associate (k => layout%free(:, i))
                run%difference = value(layout%free(1, i):layout%free(3, i))
                run%difference_sigma = [(sqrt(covariance(k(j), k(j))), j=1, 3)]
                run%statistic = wald(run%difference, &
                                     covariance(layout%free(1, i):layout%free(3, i), layout%free(1, i):layout%free(3, i)))
            end associate
            run%probability = chi_square_tail(run%statistic, 3)
            run%agrees = run%probability > FAMILY_LEVEL/size(runs)
        end associate
    end subroutine look_at_run_alone

    !> All runs against one offset.
    subroutine test_all(runs, options, solution, error)
        type(run_information_t), intent(in) :: runs(:)
        type(joint_options_t), intent(in) :: options
        type(joint_solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(layout_t) :: layout
        real(dp), allocatable :: value(:), covariance(:, :)
        logical :: free(size(runs))
        integer :: first, n

        free = .true.
        free(solution%last) = .false.
        call solve(runs, options, solution%last, free, layout, value, covariance, error)
        if (allocated(error)) return
        n = layout%count
        solution%degrees = 3*(size(runs) - 1)
        first = n - solution%degrees + 1
        solution%statistic = wald(value(first:), covariance(first:, first:))
        solution%probability = chi_square_tail(solution%statistic, solution%degrees)
        solution%consistent = solution%probability > FAMILY_LEVEL .and. all(solution%runs%agrees)
    end subroutine test_all

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
