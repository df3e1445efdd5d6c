!> The batch processor of CSR-TM-00-01 Figure 4.1, box by box: weighted least squares about a nominal trajectory,
!> iterated until the correction vanishes. ASSEST-FDE, ASSEST-RDE, ASCFEST and ASCREST use it and nothing else.
!>
!> The boxes are quoted from the figure, (A) and (B) are its connectors. The figure takes one observation after the
!> other; here a problem (gracecg_estimation_batch_problem) integrates once over the whole arc and gives all its
!> observations together, in the order of time: the sums are the same.
module gracecg_estimation_batch_processor
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, number_text, add_context
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_estimation_batch_problem, only: batch_problem_t, batch_solution_t, refuse_too_few, correct_and_note, &
        finish_batch
    implicit none
    private
    public :: batch_settings_t, process_batch

    !> When the iterations end.
    type :: batch_settings_t
        integer :: most_iterations = 20 !! After that the solution counts as not converged
        real(dp) :: tolerance = 1e-9_dp
        !! Converged when every change of the state is below tolerance times its parameter's scale
        character(32) :: history = ''
        !! What this fit is called in the history; blank: none is kept
    end type batch_settings_t

contains

    !> Runs the processor. Fails when the normal matrix is singular or a number is not finite; a
    !> solution that has not converged within the allowed iterations is returned as such.
    subroutine process_batch(problem, settings, solution, error)
        class(batch_problem_t), intent(inout) :: problem    !! At X*(t0); at the end, at its estimate
        type(batch_settings_t), intent(in) :: settings
        type(batch_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: h(:, :)    ! H_i, the observation i a column
        real(dp), allocatable :: y(:)       ! y_i, observed minus computed
        real(dp), allocatable :: w(:)       ! W_i
        real(dp), allocatable :: hwh(:, :)  ! sum of H_i^T W_i H_i
        real(dp), allocatable :: hwy(:)     ! sum of H_i^T W_i y_i
        real(dp), allocatable :: x(:)       ! x^(t0)
        integer :: n, m, iteration

        ! "START & Initialize at t0": the problem is at the initial guess X*(t0) of (4-45)
        call refuse_too_few(problem, error)
        if (allocated(error)) return
        n = size(problem%scales)
        m = problem%observations
        allocate (h(n, m), y(m), w(m), hwh(n, n), hwy(n), x(n), solution%inverse(n, n))

        do iteration = 1, settings%most_iterations
            ! (B) "Read next observation at ti": Y(ti) of (4-46)
            ! "Integrate nominal trajectory (4-45) and state transition matrix (4-47) from ti-1 to ti to get
            ! X*(ti) and Phi(ti, t0)": with A(t) of (4-48)
            ! "Form Hi = H~i Phi(ti, t0) where H~i is from (4-49)"
            call problem%linearise(h, y, w, error)
            if (allocated(error)) return

            ! "Accumulate sum Hi^T Wi Hi, sum Hi^T Wi yi where Wi is the observation weight, and yi is observation
            ! residual"; "If ti < tf go to B, otherwise go to A"
            call normal_equations(h, y, hwh, hwy, w)

            ! (A) "Solve Norm Equations for x^(t0) = [sum Hi^T Wi Hi]^-1 [sum Hi^T Wi yi]"
            call solve_normal_equations(hwh, hwy, x, solution%inverse, solution%condition, error, problem%names)
            call add_context(error, 'iteration '//number_text(real(iteration, dp)))
            if (allocated(error)) return

            ! "Update X^(t0) = X*(t0) + x^(t0)"
            call correct_and_note(problem, y, settings%history, x, solution%history)

            ! "Converged": "STOP", or "Initialization & Iteration" (B). What is linear needs no second solution
            solution%iterations = iteration
            solution%converged = problem%linear .or. all(abs(x) <= settings%tolerance*problem%scales)
            if (solution%converged) exit
        end do
        call finish_batch(h, y, w, x, solution)
    end subroutine process_batch
end module gracecg_estimation_batch_processor
