!> The batch processor on problems of known answer.
module test_batch_processor
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_estimation_batch_problem, only: batch_problem_t, batch_solution_t
    use gracecg_estimation_batch_processor, only: batch_settings_t, process_batch
    use fixture, only: check
    use testdrive, only: new_unittest, unittest_type, error_type
    implicit none
    private
    public :: collect_batch_processor

    !> y = a exp(b t), t = 0 .. 1; residuals of size `disturbance` alternate in sign.
    type, extends(batch_problem_t) :: decay_t
        real(dp) :: a, b
        real(dp) :: disturbance = 0
        logical :: blind = .false.          !! The observations do not depend on b
        logical :: poison = .false.
    contains
        procedure :: linearise => linearise_decay
        procedure :: correct => correct_decay
    end type decay_t

    real(dp), parameter :: TRUE_A = 2, TRUE_B = -1.5_dp

contains

    subroutine collect_batch_processor(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('converges-to-truth', test_truth), &
                    new_unittest('optimality-and-covariance', test_optimality), &
                    new_unittest('linear-problem-in-one-iteration', test_linear), &
                    new_unittest('not-converged-is-said', test_not_converged), &
                    new_unittest('singular-names-the-parameter', test_singular), &
                    new_unittest('too-few-observations', test_too_few), &
                    new_unittest('nan-is-refused', test_nan)]
    end subroutine collect_batch_processor

    function example() result(problem)
        type(decay_t) :: problem

        problem%names = [character(12) :: 'a', 'b']
        problem%scales = [1.0_dp, 1.0_dp]
        problem%observations = 21
        problem%a = 1
        problem%b = 0
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
            partials(:, i) = [exp(self%b*t), self%a*t*exp(self%b*t)]
            residuals(i) = TRUE_A*exp(TRUE_B*t) + self%disturbance*(-1)**i - self%a*exp(self%b*t)
            weights(i) = 1 + t
        end do
        if (self%blind) partials(2, :) = 0
        if (self%poison) residuals(5) = ieee_value(1.0_dp, ieee_quiet_nan)
    end subroutine linearise_decay

    subroutine correct_decay(self, correction)
        class(decay_t), intent(inout) :: self
        real(dp), intent(inout) :: correction(:)

        self%a = self%a + correction(1)
        self%b = self%b + correction(2)
    end subroutine correct_decay

    subroutine test_truth(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem
        type(batch_solution_t) :: solution
        type(error_t), allocatable :: failure

        problem = example()
        call process_batch(problem, batch_settings_t(), solution, failure)
        call check(error,.not. allocated(failure) .and. solution%converged)
        if (allocated(error)) return
        call check(error, abs(problem%a - TRUE_A) + abs(problem%b - TRUE_B) < 1e-12_dp)
        call check(error, solution%iterations > 2 .and. maxval(abs(solution%residuals)) < 1e-12_dp)
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
        problem%disturbance = 0.1_dp
        call process_batch(problem, batch_settings_t(), solution, failure)
        call problem%linearise(partials, residuals, weights, failure)
        call check(error, maxval(abs(matmul(partials, weights*residuals))) < 1e-7_dp)
        call check(error, maxval(abs(solution%residuals - residuals)) < 1e-8_dp)
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

    subroutine test_not_converged(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem
        type(batch_solution_t) :: solution
        type(error_t), allocatable :: failure

        problem = example()
        call process_batch(problem, batch_settings_t(most_iterations=2), solution, failure)
        call check(error,.not. allocated(failure) .and. .not. solution%converged)
        if (allocated(error)) return
        call check(error, solution%iterations, 2)
    end subroutine test_not_converged

    subroutine test_singular(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem
        type(batch_solution_t) :: solution
        type(error_t), allocatable :: failure

        problem = example()
        problem%blind = .true.
        call process_batch(problem, batch_settings_t(), solution, failure)
        call check(error, allocated(failure))
        if (allocated(error)) return
        call check(error, index(failure%message, 'singular') > 0 .and. index(failure%message, ' b (') > 0)
    end subroutine test_singular

    subroutine test_too_few(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem
        type(batch_solution_t) :: solution
        type(error_t), allocatable :: failure

        problem = example()
        problem%observations = 1
        call process_batch(problem, batch_settings_t(), solution, failure)
        call check(error, allocated(failure))
    end subroutine test_too_few

    subroutine test_nan(error)
        type(error_type), allocatable, intent(out) :: error
        type(decay_t) :: problem
        type(batch_solution_t) :: solution
        type(error_t), allocatable :: failure

        problem = example()
        problem%poison = .true.
        call process_batch(problem, batch_settings_t(), solution, failure)
        call check(error, allocated(failure))
    end subroutine test_nan
end module test_batch_processor
