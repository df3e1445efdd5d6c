!> Several runs to one joint estimate, at which they are linearised anew until it stays.
module gracecg_estimation_joint_runs
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_text, only: integer_text
    use gracecg_environment_time, only: seconds_between
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_gather_information, only: move_joined
    use gracecg_estimation_joint_estimate, only: joint_options_t, joint_solution_t, estimate_jointly
    use gracecg_estimation_optimal, only: estimate_optimal
    use gracecg_estimation_plausibility, only: judge_plausibility
    use gracecg_estimation_options, only: estimation_options_t, check_options
    use gracecg_estimation_run_information, only: run_information_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_whitened_problem, only: whitened_problem_t
    implicit none
    private
    public :: joint_run_t, run_from_observations, estimate_runs

    integer, parameter :: MOST_ROUNDS = 6           !! Of linearising anew
    real(dp), parameter :: SETTLED = 1e-4_dp        !! Change of the offset that ends them, in sigmas

    !> One of the runs.
    type :: joint_run_t
        type(run_information_t) :: information    !! What it says of the parameters that are joined
        type(solution_t) :: solution                !! Its own estimate
        type(operator_knowledge_t) :: knowledge     !! What its operator believes
        type(estimation_options_t), private :: options
        type(whitened_problem_t), private :: problem
    end type joint_run_t

contains

    !> A run from its samples, estimated by `optimal`. Fails as estimate_offset does, and when it does not converge.
    subroutine run_from_observations(observations, options, run, error)
        type(observation_set_t), intent(in) :: observations
        type(estimation_options_t), intent(in) :: options
        type(joint_run_t), intent(out) :: run
        type(error_t), allocatable, intent(out) :: error

        run%options = options
        call check_options(options, error)
        if (allocated(error)) return
        call estimate_optimal(observations, run%options, run%solution, error, problem=run%problem)
        call judge_plausibility(observations, options, run%solution, error)
        if (allocated(error)) return
        if (.not. run%solution%converged) then
            call fail(error, 'optimal did not converge: the run cannot be joined with others')
            return
        end if
        run%information = run%solution%information
        run%knowledge = observations%knowledge
    end subroutine run_from_observations

    !> The joint estimate. Fails as estimate_jointly does, and when the same samples are given twice.
    subroutine estimate_runs(runs, options, solution, error)
        type(joint_run_t), intent(inout) :: runs(:)     !! They move to the joint estimate, if they agree on one
        type(joint_options_t), intent(in) :: options
        type(joint_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(joint_solution_t) :: first
        real(dp) :: before(3)
        integer :: round, i, j

        call refuse_repeated(runs, error)
        if (.not. allocated(error)) call estimate_jointly(runs%information, options, solution, error)
        if (allocated(error) .or. .not. solution%consistent) return
        first = solution
        do round = 1, MOST_ROUNDS
            before = solution%offset
            do i = 1, size(runs)
                call move_joined(runs(i)%knowledge, runs(i)%options, solution%runs(i)%point, runs(i)%problem, &
                                 runs(i)%information, error)
                call add_context(error, trim(runs(i)%knowledge%name))
                if (allocated(error)) return
            end do
            call estimate_jointly(runs%information, options, solution, error)
            if (allocated(error)) return
            if (all(abs(solution%offset - before) <= SETTLED*[(sqrt(solution%covariance(j, j)), j=1, 3)])) exit
        end do
        do i = 1, size(runs)        ! what a run says alone belongs to its own estimate
            solution%runs(i)%offset = first%runs(i)%offset
            solution%runs(i)%sigma = first%runs(i)%sigma
        end do
    end subroutine estimate_runs

    !> Samples that count twice make the sigma too small.
    subroutine refuse_repeated(runs, error)
        type(joint_run_t), intent(in) :: runs(:)
        type(error_t), allocatable, intent(out) :: error

        integer :: i, k

        do i = 2, size(runs)
            if (.not. allocated(runs(i)%information%matrix)) return     ! estimate_jointly says so
            do k = 1, i - 1
                if (any(abs(runs(i)%solution%offset - runs(k)%solution%offset) > 0)) cycle
                if (abs(seconds_between(runs(i)%information%epoch, runs(k)%information%epoch)) > 0) cycle
                call fail(error, 'runs '//integer_text(k)//' and '//integer_text(i)//' are the same samples (same time, same '// &
                          'offset): each run counts once, leave one out')
                return
            end do
        end do
    end subroutine refuse_repeated
end module gracecg_estimation_joint_runs
