!> The iteration of `optimal`: Gauss-Newton steps whose partials are kept while they hardly change (the simplified
!> method of Newton). Partials cost most of a step; the residuals alone cost less. How far the state has moved since the
!> partials, and what new ones did to a step, say when new ones are worth it, and when a step was the last.
module gracecg_estimation_simplified_newton
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, number_text, add_context
    use gracecg_base_lapack, only: grouped_normal_equations, solve_normal_equations
    use gracecg_estimation_batch_problem, only: batch_solution_t, refuse_too_few, correct_and_note, finish_batch
    use gracecg_estimation_whitened_problem, only: whitened_problem_t
    implicit none
    private
    public :: newton_settings_t, simplified_newton

    real(dp), parameter :: FAR = 3
    !! A correction of more standard deviations than this asks for new partials
    real(dp), parameter :: GOOD = 0.01_dp
    !! but where the solution need only be rough and the next one, with the old partials, is smaller than it times this
    real(dp), parameter :: POOR = 0.3_dp
    !! So does one that is not smaller than the one before times this
    real(dp), parameter :: NEAR = 1e-4_dp
    !! So does the first that is smaller than this, in standard deviations: the last partials are those of the solution
    real(dp), parameter :: SAME = 1e-5_dp
    !! From the last partials to the solution, in standard deviations: so far their change does not matter. Farther, the
    !! first step with new partials shows what it does, and so what the change over that step may do: where that is within
    !! the tolerance, the step was the last

    !> When the iterations end.
    type :: newton_settings_t
        integer :: most_iterations = 20 !! After that the solution counts as not converged
        real(dp) :: tolerance = 1e-6_dp !! Largest correction of a parameter at the end, in its standard deviations
        logical :: rough = .false.
        !! The solution only has to be near enough to look at its residuals, and its partials may be those of a state before
        character(32) :: history = ''   !! What this fit is called in the history; blank: none is kept
    end type newton_settings_t

    !> What is known of the partials in use. Lengths are largest changes of a parameter in standard deviations.
    type :: progress_t
        logical :: fresh = .true.           !! The step takes new ones
        logical :: settled = .false.        !! The state was the solution with the partials before
        real(dp) :: step_before = huge(1.0_dp)
        real(dp) :: moved = 0               !! Since they are in use
    end type progress_t

contains

    !> Runs the iteration. Fails when the normal matrix is singular or a number is not finite; a solution that has not
    !> converged within the allowed iterations is returned as such.
    subroutine simplified_newton(problem, settings, solution, error)
        class(whitened_problem_t), intent(inout) :: problem     !! At the first guess; at the end, at its estimate
        type(newton_settings_t), intent(in) :: settings
        type(batch_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: partials(:, :), residuals(:), weights(:), correction(:)
        type(progress_t) :: progress
        integer :: n, m, iteration

        call refuse_too_few(problem, error)
        if (allocated(error)) return
        n = size(problem%scales)
        m = problem%observations
        allocate (partials(n, m), residuals(m), correction(n), solution%inverse(n, n))
        allocate (weights(m), source=1.0_dp)        ! of whitened rows
        do iteration = 1, settings%most_iterations
            call find_step()
            call add_context(error, 'iteration '//number_text(real(iteration, dp)))
            if (allocated(error)) return
            call correct_and_note(problem, residuals, settings%history, correction, solution%history)
            solution%iterations = iteration
            call judge_step(in_sigmas(correction), settings, progress, solution%converged)
            if (solution%converged) exit
        end do
        call finish_batch(partials, residuals, weights, correction, solution)

    contains

        !> The correction with the partials that suit best: those in use, or new ones.
        subroutine find_step()
            real(dp) :: normal(n, n), rhs(n)

            if (.not. progress%fresh) then
                call problem%compare(residuals)
                correction = matmul(solution%inverse, matmul(partials, residuals))
                if (.not. all(abs(correction) <= huge(1.0_dp))) call fail(error, 'a correction is not a finite number')
                progress%fresh = progress%step_before > FAR .and. &
                    .not. in_sigmas(correction) < GOOD*progress%step_before
            end if
            if (allocated(error) .or. .not. progress%fresh) return
            call problem%linearise(partials, residuals, weights, error)
            if (allocated(error)) return
            call grouped_normal_equations(problem%groups, partials, residuals, normal, rhs)
            call solve_normal_equations(normal, rhs, correction, solution%inverse, solution%condition, error, problem%names)
        end subroutine find_step

        !> The largest change, in its parameter's standard deviation.
        pure real(dp) function in_sigmas(change)
            real(dp), intent(in) :: change(:)

            integer :: k

            in_sigmas = maxval([(abs(change(k))/sqrt(solution%inverse(k, k)), k=1, n)])
        end function in_sigmas
    end subroutine simplified_newton

    !> Whether a step was the last, and if not, whether the next one takes new partials.
    pure subroutine judge_step(step, settings, progress, converged)
        real(dp), intent(in) :: step            !! In standard deviations
        type(newton_settings_t), intent(in) :: settings
        type(progress_t), intent(inout) :: progress
        logical, intent(out) :: converged

        real(dp) :: effect                      ! of new partials, by the way since the old ones; 1: not known

        associate (p => progress)
            effect = 1
            if (p%fresh .and. p%settled) effect = step/p%moved
            p%moved = step + merge(0.0_dp, p%moved, p%fresh)
            converged = effect*step <= settings%tolerance .and. &
                (settings%rough .or. p%moved <= SAME .or. effect < 1)
            p%settled = effect < 1 .or. (step <= NEAR .and. p%moved > SAME)
            p%fresh = p%settled .or. step > POOR*p%step_before .or. (step > FAR .and. .not. settings%rough)
            p%step_before = step
        end associate
    end subroutine judge_step
end module gracecg_estimation_simplified_newton
