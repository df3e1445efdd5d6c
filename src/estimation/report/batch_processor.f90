!> The batch processor of CSR-TM-00-01 Figure 4.1, as one general piece: weighted least squares about
!> a nominal trajectory, iterated until the correction vanishes.
!>
!> An estimator supplies the problem (its state, nominal trajectory, partials and update); the
!> processor accumulates the normal equations, solves them by Cholesky's factorisation and decides on
!> convergence.
module gracecg_estimation_batch_processor
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, number_text, add_context
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_estimation_iteration, only: iteration_t, append_iteration
    implicit none
    private
    public :: batch_problem_t, batch_settings_t, batch_solution_t, process_batch

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
        procedure :: describe_residuals => nothing_of_residuals !! For the history: RMS of the residuals
        procedure :: describe_state => nothing_of_state         !! For the history: the nominal state
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
    end interface

    !> When the iterations end.
    type :: batch_settings_t
        integer :: most_iterations = 20 !! After that the solution counts as not converged
        real(dp) :: tolerance = 1e-9_dp
        !! Converged when every change of the state is below tolerance times its parameter's scale
        character(32) :: history = ''
        !! What this fit is called in the history; blank: none is kept
    end type batch_settings_t

    !> What the processor knows at its end.
    type :: batch_solution_t
        integer :: iterations = 0                   !! Solutions of the normal equations
        logical :: converged = .false.              !! Within the allowed iterations
        real(dp) :: condition = 0                   !! Of the normal matrix with unit diagonal
        real(dp), allocatable :: inverse(:, :)      !! (H^T W H)^-1, parameters x parameters
        real(dp), allocatable :: gain(:, :)         !! W H as rows: parameters x observations
        real(dp), allocatable :: residuals(:)       !! After the last correction (linearised)
        real(dp), allocatable :: correction(:)      !! The last one
        type(iteration_t), allocatable :: history(:)    !! If the settings name it
    end type batch_solution_t

contains

    !> Runs the processor. Fails when the normal matrix is singular or a number is not finite; a
    !> solution that has not converged within the allowed iterations is returned as such.
    subroutine process_batch(problem, settings, solution, error)
        class(batch_problem_t), intent(inout) :: problem
        type(batch_settings_t), intent(in) :: settings
        type(batch_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: partials(:, :), residuals(:), weights(:)
        real(dp), allocatable :: normal(:, :), rhs(:), correction(:)
        type(iteration_t) :: note
        integer :: n, m, iteration, i

        n = size(problem%scales)
        m = problem%observations
        if (m < n) then
            call fail(error, number_text(real(m, dp))//' observations cannot determine '// &
                      number_text(real(n, dp))//' parameters')
            return
        end if
        allocate (partials(n, m), residuals(m), weights(m))
        allocate (normal(n, n), rhs(n), correction(n), solution%inverse(n, n))
        do iteration = 1, settings%most_iterations
            call problem%linearise(partials, residuals, weights, error)
            if (allocated(error)) return
            call normal_equations(partials, residuals, normal, rhs, weights)
            call solve_normal_equations(normal, rhs, correction, solution%inverse, &
                                        solution%condition, error, problem%names)
            if (allocated(error)) then
                call add_context(error, 'iteration '//number_text(real(iteration, dp)))
                return
            end if
            if (settings%history /= '') then
                call problem%describe_residuals(residuals, note)
                note%names = problem%names
            end if
            call problem%correct(correction)
            if (settings%history /= '') then
                note%correction = correction
                call problem%describe_state(note)
                call append_iteration(solution%history, note, settings%history)
            end if
            solution%iterations = iteration
            solution%converged = problem%linear .or. &
                                 all(abs(correction) <= settings%tolerance*problem%scales)
            if (solution%converged) exit
        end do
        solution%residuals = residuals - matmul(correction, partials)
        do i = 1, m
            partials(:, i) = partials(:, i)*weights(i)
        end do
        call move_alloc(partials, solution%gain)
        call move_alloc(correction, solution%correction)
    end subroutine process_batch

    !> A problem that says nothing of its residuals: their RMS.
    subroutine nothing_of_residuals(self, residuals, note)
        class(batch_problem_t), intent(in) :: self
        real(dp), intent(in) :: residuals(:)            !! As linearise gives them
        type(iteration_t), intent(inout) :: note

        note%residual_names = [character(12) :: 'all']
        note%residual_rms = [norm2(residuals)/sqrt(real(max(1, self%observations), dp))]
        note%residual_unit = '1'
    end subroutine nothing_of_residuals

    !> A problem that says nothing of its state.
    subroutine nothing_of_state(self, note)
        class(batch_problem_t), intent(in) :: self
        type(iteration_t), intent(inout) :: note

        note%state_names = self%names(:0)
        note%state = [real(dp) ::]
    end subroutine nothing_of_state
end module gracecg_estimation_batch_processor
