!> A batch least-squares problem about a nominal trajectory: what an estimator must say of it, and what its solution
!> is. Who solves it: the batch processor of CSR-TM-00-01 Figure 4.1 (gracecg_estimation_batch_processor), or for
!> `optimal` gracecg_estimation_simplified_newton.
module gracecg_estimation_batch_problem
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_estimation_iteration, only: iteration_t, append_iteration
    implicit none
    private
    public :: batch_problem_t, batch_solution_t, refuse_too_few, correct_and_note, finish_batch

    !> What an estimator must say of its problem.
    type, abstract :: batch_problem_t
        character(12), allocatable :: names(:)  !! Of the parameters, for messages
        real(dp), allocatable :: scales(:)      !! A typical size of each parameter, for convergence
        integer :: observations = 0             !! Number of scalar observations
        logical :: linear = .false.             !! The observations are linear in the parameters
    contains
        procedure(linearise_interface), deferred :: linearise
        !! Partials, residuals and weights at the nominal state
        procedure(correct_interface), deferred :: correct   !! Puts a correction on the nominal state
        procedure(describe_residuals_interface), deferred :: describe_residuals !! For the history: RMS of the residuals
        procedure(describe_state_interface), deferred :: describe_state         !! For the history: the nominal state
    end type batch_problem_t

    abstract interface
        !> Integrates the nominal trajectory and its state transition matrix (4-45), (4-47), (4-48) and gives,
        !> for every scalar observation (4-46), the partials H = H~ Phi (4-49), the residual and the weight.
        subroutine linearise_interface(self, partials, residuals, weights, error)
            import :: batch_problem_t, dp, error_t
            class(batch_problem_t), intent(inout) :: self
            real(dp), contiguous, intent(out) :: partials(:, :) !! Parameters x observations
            real(dp), intent(out) :: residuals(:)               !! Observed minus computed
            real(dp), intent(out) :: weights(:)
            type(error_t), allocatable, intent(out) :: error
        end subroutine linearise_interface

        !> Applies the correction to the nominal initial state: X* + x. A problem whose parameters are
        !> not independent returns the change that is left of the correction.
        subroutine correct_interface(self, correction)
            import :: batch_problem_t, dp
            class(batch_problem_t), intent(inout) :: self
            real(dp), intent(inout) :: correction(:)
        end subroutine correct_interface

        subroutine describe_residuals_interface(self, residuals, note)
            import :: batch_problem_t, dp, iteration_t
            class(batch_problem_t), intent(in) :: self
            real(dp), intent(in) :: residuals(:)            !! As linearise gives them
            type(iteration_t), intent(inout) :: note
        end subroutine describe_residuals_interface

        subroutine describe_state_interface(self, note)
            import :: batch_problem_t, iteration_t
            class(batch_problem_t), intent(in) :: self
            type(iteration_t), intent(inout) :: note
        end subroutine describe_state_interface
    end interface

    !> What is known at the end.
    type :: batch_solution_t
        integer :: iterations = 0                   !! Solutions of the normal equations
        logical :: converged = .false.              !! Within the allowed iterations
        real(dp) :: condition = 0                   !! Of the normal matrix with unit diagonal
        real(dp), allocatable :: inverse(:, :)      !! (H^T W H)^-1, parameters x parameters
        real(dp), allocatable :: gain(:, :)         !! W H as rows: parameters x observations
        real(dp), allocatable :: residuals(:)       !! After the last correction (linearised)
        real(dp), allocatable :: correction(:)      !! The last one
        type(iteration_t), allocatable :: history(:)    !! If it was asked for
    end type batch_solution_t

contains

    !> Fails when there are fewer observations than parameters.
    subroutine refuse_too_few(problem, error)
        class(batch_problem_t), intent(in) :: problem
        type(error_t), allocatable, intent(out) :: error

        associate (n => size(problem%scales), m => problem%observations)
            if (m < n) call fail(error, number_text(real(m, dp))//' observations cannot determine '// &
                                 number_text(real(n, dp))//' parameters')
        end associate
    end subroutine refuse_too_few

    !> Corrects the nominal state and, where the fit has a name, notes the iteration in the history: residuals
    !> before the correction, state after it.
    subroutine correct_and_note(problem, residuals, fit, correction, history)
        class(batch_problem_t), intent(inout) :: problem
        real(dp), intent(in) :: residuals(:)            !! Before the correction
        character(*), intent(in) :: fit                 !! What is fitted; blank: nothing is noted
        real(dp), intent(inout) :: correction(:)        !! See correct_interface
        type(iteration_t), allocatable, intent(inout) :: history(:)

        type(iteration_t) :: note

        if (fit == '') then
            call problem%correct(correction)
            return
        end if
        call problem%describe_residuals(residuals, note)
        note%names = problem%names
        call problem%correct(correction)
        note%correction = correction
        call problem%describe_state(note)
        call append_iteration(history, note, fit)
    end subroutine correct_and_note

    !> Puts the residuals that the last correction leaves, and the weighted partials, into the solution.
    subroutine finish_batch(partials, residuals, weights, correction, solution)
        real(dp), allocatable, intent(inout) :: partials(:, :)  !! Parameters x observations; no longer allocated at the end
        real(dp), intent(in) :: residuals(:)                    !! Before the last correction
        real(dp), intent(in) :: weights(:)      !! Of the observations
        real(dp), intent(in) :: correction(:)                   !! The last one
        type(batch_solution_t), intent(inout) :: solution

        integer :: i

        solution%correction = correction
        solution%residuals = residuals - matmul(correction, partials)
        do i = 1, size(weights)
            partials(:, i) = partials(:, i)*weights(i)
        end do
        call move_alloc(partials, solution%gain)
    end subroutine finish_batch
end module gracecg_estimation_batch_problem
