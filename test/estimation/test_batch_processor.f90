!> The batch processor and the iteration of `optimal` on a problem of known answer, and against each other.
module test_batch_processor
    use vocabulary
    use gracecg_estimation_iteration, only: iteration_t, rms_of
    use gracecg_estimation_batch_problem, only: batch_solution_t
    use gracecg_estimation_batch_processor, only: batch_settings_t, process_batch
    use gracecg_estimation_whitened_problem, only: whitened_problem_t
    use gracecg_estimation_simplified_newton, only: newton_settings_t, simplified_newton
    implicit none
    private
    public :: collect_batch_processor

    !> y = a exp(b t), t = 0 .. 1, with an error of alternating sign and the sigma 0.01. No satellite is in it.
    type, extends(whitened_problem_t) :: decay_t
        real(dp) :: a, b
        real(dp) :: disturbance = 0
        real(dp) :: slope = 0               !! Of the weights
        logical :: blind = .false.          !! Its partials do not depend on b
        logical :: poison = .false.
    contains
        procedure :: linearise => linearise_decay
        procedure :: compare => compare_decay
        procedure :: correct => correct_decay
        procedure :: describe_residuals => residuals_of_decay
        procedure :: describe_state => state_of_decay
    end type decay_t

    real(dp), parameter :: TRUE_A = 2, TRUE_B = -1.5_dp, SIGMA = 0.01_dp

contains

    subroutine collect_batch_processor(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('converges-to-truth', test_truth), &
                    new_unittest('optimality-and-covariance', test_optimality), &
                    new_unittest('linear-problem-in-one-iteration', test_linear), &
                    new_unittest('iterations-agree', test_same), &
                    new_unittest('not-converged-is-said', test_not_converged), &
                    new_unittest('refusals', test_refusals)]
    end subroutine collect_batch_processor

    function example() result(problem)
        type(decay_t) :: problem

        problem%names = [character(12) :: 'a', 'b']
        problem%scales = [1.0_dp, 1.0_dp]
        problem%observations = 21
        problem%groups = reshape([1, 21, 2, 2, 20, 2], [3, 2])
        problem%a = 1
        problem%b = 0
        problem%disturbance = 0.01_dp
    end function example

    subroutine linearise_decay(self, partials, residuals, weights, error)
        class(decay_t), intent(inout) :: self
        real(dp), contiguous, intent(out) :: partials(:, :)
        real(dp), intent(out) :: residuals(:), weights(:)
        type(error_t), allocatable, intent(out) :: error
        real(dp) :: t
        integer :: i

        do i = 1, self%observations
            t = (i - 1)/20.0_dp
            partials(:, i) = [exp(self%b*t), self%a*t*exp(self%b*t)]/SIGMA
            weights(i) = 1 + self%slope*t
        end do
        if (self%blind) partials(2, :) = 0
        call self%compare(residuals)
    end subroutine linearise_decay

    subroutine compare_decay(self, residuals)
        class(decay_t), intent(inout) :: self
        real(dp), intent(out) :: residuals(:)
        real(dp) :: t
        integer :: i

        do i = 1, self%observations
            t = (i - 1)/20.0_dp
            residuals(i) = (TRUE_A*exp(TRUE_B*t) + self%disturbance*(-1)**i - self%a*exp(self%b*t))/SIGMA
        end do
        if (self%poison) residuals(5) = NAN
    end subroutine compare_decay

    subroutine correct_decay(self, correction)
        class(decay_t), intent(inout) :: self
        real(dp), intent(inout) :: correction(:)

        self%a = self%a + correction(1)
        self%b = self%b + correction(2)
    end subroutine correct_decay

    subroutine residuals_of_decay(self, residuals, note)
        class(decay_t), intent(in) :: self
        real(dp), intent(in) :: residuals(:)
        type(iteration_t), intent(inout) :: note

        note%residual_names = self%names(:1)
        note%residual_rms = [rms_of(residuals)]
    end subroutine residuals_of_decay

    subroutine state_of_decay(self, note)
        class(decay_t), intent(in) :: self
        type(iteration_t), intent(inout) :: note

        note%state_names = self%names
        note%state = [self%a, self%b]
    end subroutine state_of_decay

    subroutine test_truth(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem
        type(batch_solution_t) :: solution
        type(error_t), allocatable :: failure

        problem = example()
        problem%disturbance = 0
        call process_batch(problem, batch_settings_t(), solution, failure)
        if (unmet(error, .not. allocated(failure) .and. solution%converged)) return
        call check(error, abs(problem%a - TRUE_A) + abs(problem%b - TRUE_B) < 1e-12_dp)
        call check(error, solution%iterations > 2 .and. maxval(abs(solution%residuals)) < 1e-12_dp/SIGMA)
    end subroutine test_truth

    !> At the minimum the residuals are orthogonal to the partials in the metric of the weights, and
    !> inverse times (H^T W H) is one.
    subroutine test_optimality(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem
        type(batch_solution_t) :: solution
        type(error_t), allocatable :: failure
        real(dp) :: partials(2, 21), residuals(21), weights(21), product(2, 2)

        problem = example()
        problem%slope = 1
        call process_batch(problem, batch_settings_t(), solution, failure)
        call problem%linearise(partials, residuals, weights, failure)
        call check(error, maxval(abs(matmul(partials, weights*residuals))) < 1e-7_dp/SIGMA**2)
        call check(error, maxval(abs(solution%residuals - residuals)) < 1e-8_dp/SIGMA)
        product = matmul(solution%inverse, matmul(solution%gain, transpose(partials)))
        call check(error, abs(product(1, 1) - 1) + abs(product(2, 2) - 1) + abs(product(1, 2)) < 1e-6_dp)
    end subroutine test_optimality

    subroutine test_linear(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem
        type(batch_solution_t) :: solution
        type(error_t), allocatable :: failure

        problem = example()
        problem%linear = .true.
        call process_batch(problem, batch_settings_t(), solution, failure)
        call check(error, solution%iterations, 1)
        call check(error, solution%converged)
    end subroutine test_linear

    !> The minimum does not depend on the way to it: estimate, covariance, gain and residuals are those of Figure 4.1.
    subroutine test_same(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem, other
        type(batch_solution_t) :: solution, expected
        type(error_t), allocatable :: failure

        other = example()
        call process_batch(other, batch_settings_t(), expected, failure)
        if (.not. allocated(failure)) then
            problem = example()
            call simplified_newton(problem, newton_settings_t(), solution, failure)
        end if
        if (unmet(error, .not. allocated(failure) .and. solution%converged .and. expected%converged)) return
        call check(error, abs(other%a - problem%a) < 1e-6_dp*sqrt(expected%inverse(1, 1)) .and. &
                   abs(other%b - problem%b) < 1e-6_dp*sqrt(expected%inverse(2, 2)), 'estimate')
        call check(error, maxval(abs(solution%inverse - expected%inverse)) < 1e-5_dp*maxval(abs(expected%inverse)), &
                   'covariance')
        call check(error, maxval(abs(solution%residuals - expected%residuals)) < 1e-6_dp, 'residuals')
        call check(error, maxval(abs(solution%gain - expected%gain)) < 1e-5_dp*maxval(abs(expected%gain)), 'gain')
    end subroutine test_same

    !> Each of the two in turn.
    subroutine solve(newton, problem, solution, failure, most_iterations)
        logical, intent(in) :: newton           !! That of `optimal`
        type(decay_t), intent(inout) :: problem
        type(batch_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: failure
        integer, intent(in), optional :: most_iterations
        type(batch_settings_t) :: settings
        type(newton_settings_t) :: newton_settings

        if (present(most_iterations)) then
            settings%most_iterations = most_iterations
            newton_settings%most_iterations = most_iterations
        end if
        if (newton) call simplified_newton(problem, newton_settings, solution, failure)
        if (.not. newton) call process_batch(problem, settings, solution, failure)
    end subroutine solve

    subroutine test_not_converged(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem
        type(batch_solution_t) :: solution
        type(error_t), allocatable :: failure
        integer :: i

        do i = 1, 2
            problem = example()
            call solve(i == 2, problem, solution, failure, most_iterations=2)
            call check(error, .not. allocated(failure) .and. .not. solution%converged .and. solution%iterations == 2)
        end do
    end subroutine test_not_converged

    subroutine test_refusals(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem

        problem = example()
        problem%blind = .true.
        call refused(error, problem, 'singular ...  b (')
        problem = example()
        problem%observations = 1
        call refused(error, problem, '1 observ')
        problem = example()
        problem%poison = .true.
        call refused(error, problem, 'NaN')
    end subroutine test_refusals

    !> By both.
    subroutine refused(error, problem, parts)
        type(error_type), allocatable, intent(inout) :: error
        type(decay_t), intent(in) :: problem
        character(*), intent(in) :: parts    !! Of the message
        type(decay_t) :: own
        type(batch_solution_t) :: solution
        type(error_t), allocatable :: failure
        integer :: i

        do i = 1, 2
            own = problem
            call solve(i == 2, own, solution, failure)
            call check_fails(error, failure, parts)
        end do
    end subroutine refused
end module test_batch_processor
