!> The batch processor of CSR-TM-00-01 Figure 4.1, as one general piece: weighted least squares about
!> a nominal trajectory, iterated until the correction vanishes.
!>
!> An estimator supplies the problem (its state, nominal trajectory, partials and update); the
!> processor accumulates the normal equations, solves them by Cholesky's factorisation and decides on
!> convergence.
module gracecg_estimation_batch_processor
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, number_text, add_context
    use gracecg_base_lapack, only: normal_equations, grouped_normal_equations, solve_normal_equations
    use gracecg_estimation_iteration, only: iteration_t, append_iteration
    implicit none
    private
    public :: batch_problem_t, batch_settings_t, batch_solution_t, process_batch

    !> What an estimator must say of its problem.
    type, abstract :: batch_problem_t
        character(12), allocatable :: names(:)  !! Of the parameters, for messages
        real(dp), allocatable :: scales(:)      !! A typical size of each parameter, for convergence
        integer :: observations = 0             !! Number of scalar observations
        integer, allocatable :: groups(:, :)
        !! Observations that depend on the same parameters: first, last, step; see `grouped_normal_equations`. Not allocated: all
        logical :: linear = .false.             !! The observations are linear in the parameters
    contains
        procedure(linearise_interface), deferred :: linearise
        !! Partials, residuals and weights at the nominal state
        procedure :: compare => cannot_compare      !! Residuals alone, which cost less
        procedure :: inherit => inherits_nothing    !! Partials of another state, to begin with
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
    type :: batch_settings_t
        integer :: most_iterations = 20 !! After that the solution counts as not converged
        real(dp) :: tolerance = 1e-9_dp
        !! Converged when every change of the state is below tolerance times its parameter's scale
        logical :: keep_partials = .false.
        !! While they hardly change (the simplified method of Newton): the weights must be those of the noise, the
        !! problem must have `compare`, and the tolerance is in standard deviations
        logical :: rough = .false.
        !! With keep_partials: the solution only has to be near enough to look at its residuals, and its partials may be
        !! those of a state before
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
        real(dp) :: step, step_before, moved    ! in standard deviations; the last one since the partials
        real(dp) :: effect                      ! of new partials, by the way since the old ones; 1: not known
        type(iteration_t) :: note
        logical :: fresh, settled               ! the state was the solution with the partials before
        logical :: inherited                    ! the partials are those of another problem's last state
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
        fresh = .true.
        settled = .false.
        step_before = huge(step_before)
        moved = 0
        do iteration = 1, settings%most_iterations
            inherited = .false.
            if (iteration == 1 .and. settings%keep_partials) call problem%inherit(partials, residuals, weights, inherited)
            if (inherited) then
                call solve()
                inherited = .not. allocated(error)
                if (allocated(error)) deallocate (error)    ! those of this state may do
            else if (.not. fresh) then
                call problem%compare(residuals)
                correction = matmul(solution%inverse, matmul(partials, weights*residuals))
                if (.not. all(abs(correction) <= huge(1.0_dp))) call fail(error, 'a correction is not a finite number')
                fresh = step_before > FAR .and. .not. in_sigmas(correction) < GOOD*step_before
            end if
            if (fresh .and. .not. inherited .and. .not. allocated(error)) then
                call problem%linearise(partials, residuals, weights, error)
                if (allocated(error)) return
                call solve()
            end if
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
            if (settings%keep_partials) then
                step = in_sigmas(correction)
                effect = 1
                if (fresh .and. settled) effect = step/moved
                moved = step + merge(0.0_dp, moved, fresh)
                solution%converged = effect*step <= settings%tolerance .and. .not. inherited .and. &
                    (settings%rough .or. moved <= SAME .or. effect < 1)
                settled = effect < 1 .or. (step <= NEAR .and. moved > SAME)
                fresh = inherited .or. settled .or. step > POOR*step_before .or. (step > FAR .and. .not. settings%rough)
                step_before = step
            else
                solution%converged = problem%linear .or. all(abs(correction) <= settings%tolerance*problem%scales)
            end if
            if (solution%converged) exit
        end do
        solution%residuals = residuals - matmul(correction, partials)
        do i = 1, m
            partials(:, i) = partials(:, i)*weights(i)
        end do
        call move_alloc(partials, solution%gain)
        call move_alloc(correction, solution%correction)

    contains

        subroutine solve()
            if (allocated(problem%groups)) then
                call grouped_normal_equations(problem%groups, partials, residuals, normal, rhs, weights)
            else
                call normal_equations(partials, residuals, normal, rhs, weights)
            end if
            call solve_normal_equations(normal, rhs, correction, solution%inverse, solution%condition, error, problem%names)
        end subroutine solve

        !> The largest change, in its parameter's standard deviation.
        pure real(dp) function in_sigmas(change)
            real(dp), intent(in) :: change(:)

            integer :: k

            in_sigmas = maxval([(abs(change(k))/sqrt(solution%inverse(k, k)), k=1, n)])
        end function in_sigmas
    end subroutine process_batch

    !> A problem that has no residuals without partials.
    subroutine cannot_compare(self, residuals)
        class(batch_problem_t), intent(inout) :: self
        real(dp), intent(out) :: residuals(:)       !! At the nominal state, as linearise gives them

        residuals = ieee_value(residuals, ieee_quiet_nan)
        associate (not_used => self)
        end associate
    end subroutine cannot_compare

    !> A problem that has no partials before it is linearised.
    subroutine inherits_nothing(self, partials, residuals, weights, inherited)
        class(batch_problem_t), intent(inout) :: self
        real(dp), contiguous, intent(inout) :: partials(:, :)   !! Parameters x observations, of a state that is near
        real(dp), intent(inout) :: residuals(:), weights(:)     !! At the nominal state
        logical, intent(out) :: inherited           !! Whether there are any; if not, nothing is touched

        inherited = .false.
        associate (not_used => self)
        end associate
        associate (not_used => partials)
        end associate
        associate (not_used => residuals)
        end associate
        associate (not_used => weights)
        end associate
    end subroutine inherits_nothing

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
