!> Constants and smoothed processes of a series with coloured noise, against dense least squares and the dense Gaussian
!> posterior.
module test_square_root_information
    use vocabulary
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_base_gauss_markov
    use gracecg_estimation_square_root_information
    use gracecg_estimation_noise_whitening, only: process_filter_t, prepare_filter
    use gracecg_estimation_linearised_samples, only: filter_problem_t, whiten_axis, gather, smooth_axis
    implicit none
    private
    public :: collect_square_root_information

    integer, parameter :: STEPS = 60        !! Intervals; epochs 0..STEPS
    integer, parameter :: M = 3             !! Constants
    real(dp), parameter :: INTERVAL = 0.1_dp
    integer, private :: i
    integer, parameter :: EPOCHS(0:STEPS) = [(i, i=0, STEPS)]

contains

    subroutine collect_square_root_information(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('equals-least-squares', test_least_squares), &
                    new_unittest('whitening-is-the-inverse-covariance', test_whitening), &
                    new_unittest('equals-gaussian-posterior', test_posterior), &
                    new_unittest('every-sample-against-all-others', test_deletion), &
                    new_unittest('survives-ill-conditioning', test_ill_conditioned)]
    end subroutine collect_square_root_information

    !> A wander, an oscillation and exponentially correlated noise.
    function example_process() result(process)
        type(gauss_markov_t) :: process

        process = superposed(second_order_process(2.0_dp, 1.5_dp, 0.1_dp, INTERVAL), &
                             superposed(first_order_process(1.0_dp, 0.9_dp), &
                                        second_order_process(3.0_dp, 0.5_dp, 1.0_dp, INTERVAL)))
    end function example_process

    !> Partials [g, r] at epoch k; epochs 21 to 25 have no observation.
    pure function partials(k) result(g)
        integer, intent(in) :: k
        real(dp) :: g(M)

        g = [1.0_dp, k*INTERVAL - 3, sin(0.8_dp*k*INTERVAL)]
    end function partials

    pure logical function is_observed(k)
        integer, intent(in) :: k

        is_observed = k < 21 .or. k > 25
    end function is_observed

    !> Observations with unit noise, and the states they come from.
    subroutine simulate(process, run, observed, truth)
        type(gauss_markov_t), intent(in) :: process
        integer, intent(in) :: run
        real(dp), intent(out) :: observed(0:STEPS)
        real(dp), intent(out), optional :: truth(:, 0:)
        type(random_stream_t) :: stream
        real(dp) :: p(process%n), draws(process%n), e(1)
        integer :: k

        stream = new_stream(11, run, 0, 0, 0)
        call stream%normals(draws)
        p = 0
        do k = 1, process%n
            p(k) = sqrt(process%covariance(k, k))*draws(k)
        end do
        do k = 0, STEPS
            if (k > 0) then
                call stream%normals(draws)
                p = matmul(process%transition, p) + matmul(process%noise_root, draws)
            end if
            call stream%normals(e)
            observed(k) = dot_product(process%output, p) + dot_product(partials(k), [3.0_dp, -2.0_dp, 5.0_dp]) + e(1)
            if (present(truth)) truth(:, k) = p
        end do
    end subroutine simulate

    !> The whitened observations of the epochs up to `last`, and what they say of the constants.
    subroutine run_filter(process, observed, last, whitened, log_variance, constants)
        type(gauss_markov_t), intent(in) :: process
        real(dp), intent(in) :: observed(0:STEPS)
        integer, intent(in) :: last
        real(dp), intent(out) :: whitened(M + 1, 0:STEPS), log_variance
        type(constants_t), intent(out) :: constants
        type(process_filter_t) :: filter
        real(dp) :: rows(M + 1, 0:STEPS)
        integer :: k

        do k = 0, STEPS
            rows(:, k) = [partials(k), observed(k)]
        end do
        call prepare_filter(process, EPOCHS, [(is_observed(k) .and. k <= last, k=0, STEPS)], filter)
        whitened = rows
        call filter%whiten(whitened)
        log_variance = filter%log_variance
        constants = new_constants(M)
        call constants%fold_in_all(whitened)
    end subroutine run_filter

    !> Without a process: least squares by normal equations.
    subroutine test_least_squares(error)
        type(error_type), allocatable, intent(out) :: error
        type(constants_t) :: constants
        type(error_t), allocatable :: failure
        real(dp) :: observed(0:STEPS), rows(M, 0:STEPS), normal(M, M), rhs(M), y(M), covariance(M, M), condition
        real(dp) :: inverse(M, M), last(2), last_covariance(2, 2), left(0:STEPS), whitened(M + 1, 0:STEPS), unused
        integer :: k

        call simulate(example_process(), 1, observed)
        call run_filter(no_process(), observed, STEPS, whitened, unused, constants)
        do k = 0, STEPS
            rows(:, k) = merge(partials(k), 0.0_dp, is_observed(k))
        end do
        call normal_equations(rows, observed, normal, rhs)
        call solve_normal_equations(normal, rhs, y, covariance, condition, failure)
        inverse = constants%inverse_root()
        call check(error, maxval(abs(constants%solution()/y - 1)) < 1e-10_dp, 'estimate')
        call check(error, maxval(abs(matmul(inverse, transpose(inverse)) - covariance)) < &
                   1e-10_dp*maxval(covariance), 'covariance')
        call constants%last_covariance(last, last_covariance)
        call check(error, maxval(abs(last/y(2:) - 1)) < 1e-10_dp .and. &
                   maxval(abs(last_covariance/covariance(2:, 2:) - 1)) < 1e-9_dp, 'the last two')
        left = merge(observed - matmul(y, rows), 0.0_dp, [(is_observed(k), k=0, STEPS)])
        call check(error, abs(constants%squares/sum(left**2) - 1) < 1e-10_dp, 'sum of squares')
    end subroutine test_least_squares

    !> Dense: covariance of the outputs at two epochs, k >= l.
    function dense_covariance(process) result(covariance)
        type(gauss_markov_t), intent(in) :: process
        real(dp) :: covariance(0:STEPS, 0:STEPS)

        real(dp) :: p(process%n, process%n), cross(process%n, process%n)
        integer :: k, l

        p = process%covariance
        do l = 0, STEPS
            cross = p
            do k = l, STEPS
                covariance(k, l) = dot_product(process%output, matmul(cross, process%output))
                covariance(l, k) = covariance(k, l)
                cross = matmul(process%transition, cross)
            end do
            p = matmul(process%transition, matmul(p, transpose(process%transition))) + &
                matmul(process%noise_root, transpose(process%noise_root))
        end do
    end function dense_covariance

    !> W^T W is the inverse of the dense covariance of the samples in use, and the innovations' variances give its
    !> determinant.
    subroutine test_whitening(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: dense(0:STEPS, 0:STEPS), identity_rows(STEPS + 1, STEPS + 1), whitened(STEPS + 1, STEPS + 1)
        real(dp), allocatable :: inverse(:, :)
        type(process_filter_t) :: filter
        integer, allocatable :: used(:)
        real(dp) :: log_determinant
        integer :: k

        used = pack(EPOCHS, [(is_observed(k), k=0, STEPS)])
        dense = dense_covariance(example_process())
        call invert(dense, used, 0.0_dp, inverse, log_determinant)
        identity_rows = 0
        do k = 1, STEPS + 1
            identity_rows(k, k) = 1
        end do
        call prepare_filter(example_process(), EPOCHS, [(is_observed(k), k=0, STEPS)], filter)
        whitened = identity_rows
        call filter%whiten(whitened)
        associate (of_used => whitened(used + 1, :))
            call check(error, maxval(abs(matmul(of_used, transpose(of_used)) - inverse)) < 1e-11_dp, 'inverse')
        end associate
        call check(error, filter%log_variance, log_determinant, thr=1e-10_dp)
    end subroutine test_whitening

    !> The inverse of the covariance of the samples `used`: dense process, unit noise, constants of standard deviation
    !> `prior`; and the logarithm of its determinant, by Cholesky's factors.
    subroutine invert(dense, used, prior, inverse, log_determinant)
        real(dp), intent(in) :: dense(0:STEPS, 0:STEPS)
        integer, intent(in) :: used(:)
        real(dp), intent(in) :: prior
        real(dp), allocatable, intent(out) :: inverse(:, :)
        real(dp), intent(out) :: log_determinant
        real(dp) :: total(size(used), size(used)), root(size(used), size(used)), unused(size(used)), condition
        type(error_t), allocatable :: failure
        integer :: i, j

        total = dense(used, used)
        do i = 1, size(used)
            total(i, i) = total(i, i) + 1
            do j = 1, size(used)
                total(i, j) = total(i, j) + prior**2*dot_product(partials(used(i)), partials(used(j)))
            end do
        end do
        allocate (inverse(size(used), size(used)))
        call solve_normal_equations(total, spread(0.0_dp, 1, size(used)), unused, inverse, condition, failure)
        if (allocated(failure)) error stop failure%message
        root = 0
        log_determinant = 0
        do j = 1, size(used)
            root(j, j) = sqrt(total(j, j) - sum(root(j, :j - 1)**2))
            do i = j + 1, size(used)
                root(i, j) = (total(i, j) - dot_product(root(i, :j - 1), root(j, :j - 1)))/root(j, j)
            end do
            log_determinant = log_determinant + 2*log(root(j, j))
        end do
    end subroutine invert

    !> Generalised least squares with the dense covariance: the constants, their covariance, the likelihood; of all
    !> samples and of those up to the 30th.
    subroutine test_posterior(error)
        type(error_type), allocatable, intent(out) :: error
        type(constants_t) :: constants
        real(dp) :: observed(0:STEPS), dense(0:STEPS, 0:STEPS), whitened(M + 1, 0:STEPS), log_variance, log_determinant
        real(dp) :: normal(M, M), rhs(M), y(M), covariance(M, M), condition, root(M, M)
        real(dp), allocatable :: inverse(:, :), g(:, :), r(:)
        type(error_t), allocatable :: failure
        integer, allocatable :: used(:)
        integer :: k, last

        call simulate(example_process(), 2, observed)
        dense = dense_covariance(example_process())
        do last = 30, STEPS, 30
            call run_filter(example_process(), observed, last, whitened, log_variance, constants)
            used = pack(EPOCHS, [(is_observed(k) .and. k <= last, k=0, STEPS)])
            call invert(dense, used, 0.0_dp, inverse, log_determinant)
            if (allocated(g)) deallocate (g)
            allocate (g(M, size(used)))
            do k = 1, size(used)
                g(:, k) = partials(used(k))
            end do
            normal = matmul(g, matmul(inverse, transpose(g)))
            rhs = matmul(g, matmul(inverse, observed(used)))
            call solve_normal_equations(normal, rhs, y, covariance, condition, failure)
            call check(error, maxval(abs(constants%solution() - y)) < 1e-9_dp, 'constants')
            root = constants%inverse_root()
            call check(error, maxval(abs(matmul(root, transpose(root)) - covariance)) < 1e-9_dp*maxval(abs(covariance)), &
                       'their covariance')
            r = observed(used) - matmul(y, g)
            call check(error, log_variance + constants%squares, log_determinant + dot_product(r, matmul(inverse, r)), &
                       thr=1e-9_dp)
        end do
    end subroutine test_posterior

    !> The smoothed process, and what each sample differs by from what all others predict, in use or not: with C the
    !> dense covariance of the samples in use and the one, constants included, that is [C^-1 r]_k/[C^-1]_kk with the
    !> variance 1/[C^-1]_kk. Once with epochs that have no sample at all.
    subroutine test_deletion(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: PRIOR = 10
        type(filter_problem_t) :: problem, no_problem
        type(constants_t) :: constants
        type(gauss_markov_t) :: process
        real(dp) :: observed(0:STEPS), dense(0:STEPS, 0:STEPS), unused, expected
        real(dp), allocatable :: inverse(:, :), disturbance(:, :), residual(:), chi_square(:), remainder(:, :, :), signal(:, :)
        integer, allocatable :: used(:), with_it(:)
        integer :: n, k, place, round

        process = example_process()
        call simulate(process, 3, observed)
        dense = dense_covariance(process)
        do round = 1, 2
            problem = no_problem
            problem%m = M
            problem%steps = STEPS
            problem%interval = INTERVAL
            problem%epoch = pack(EPOCHS, round == 1 .or. EPOCHS < 21 .or. EPOCHS > 25)     ! counted from 1
            n = size(problem%epoch)
            allocate (problem%prior(M + 1, M), problem%acceleration(M + 1, n, 3), source=0.0_dp)
            allocate (problem%kept(n, 3), source=.false.)
            allocate (problem%star_time(0), problem%star(M + 1, 3, 0), problem%star_kept(0))
            allocate (remainder(M + 1, n, 3), source=0.0_dp)
            do k = 1, M
                problem%prior(k, k) = 1/PRIOR
            end do
            do k = 1, n
                problem%acceleration(:, k, 1) = [partials(problem%epoch(k)), observed(problem%epoch(k))]
                problem%kept(k, 1) = is_observed(problem%epoch(k))
            end do
            problem%process(1) = process
            problem%process(2) = no_process()
            problem%process(3) = no_process()
            call whiten_axis(problem, 1, remainder(:, :, 1))
            call gather(problem, constants, remainder)
            allocate (disturbance(1, n), residual(n), chi_square(n))
            signal = reshape(process%output, [process%n, 1])
            call smooth_axis(problem, 1, constants, signal, disturbance, residual, chi_square)
            used = pack(problem%epoch, problem%kept(:, 1))
            do k = 1, n
                with_it = used
                if (.not. problem%kept(k, 1)) with_it = [used, problem%epoch(k)]
                place = findloc(with_it, problem%epoch(k), 1)
                call invert(dense, with_it, PRIOR, inverse, unused)
                expected = dot_product(inverse(place, :), observed(with_it))**2/inverse(place, place)
                call check(error, abs(chi_square(k) - expected) < 1e-8_dp*(1 + expected), &
                           'chi-square of sample '//integer_text(k))
            end do
            call invert(dense, used, PRIOR, inverse, unused)
            do k = 1, n
                expected = dot_product(dense(problem%epoch(k), used), matmul(inverse, observed(used)))
                call check(error, abs(disturbance(1, k) - expected) < 1e-8_dp, 'smoothed process')
            end do
            deallocate (problem%prior, problem%acceleration, problem%kept, problem%star_time, problem%star, problem%star_kept, &
                        remainder, disturbance, residual, chi_square)
        end do
    end subroutine test_deletion

    !> Two constants that differ by 1e-9 of their partials: normal equations lose them altogether, the
    !> square root does not.
    subroutine test_ill_conditioned(error)
        type(error_type), allocatable, intent(out) :: error
        type(constants_t) :: constants
        real(dp), parameter :: TINY_PART = 1e-9_dp
        real(dp) :: y(2)
        integer :: i

        constants = new_constants(2)
        do i = 1, 20
            associate (t => i/10.0_dp)
                call constants%fold_in([1.0_dp, 1 + TINY_PART*t, 2 - (1 + TINY_PART*t)])
            end associate
        end do
        y = constants%solution()
        call check(error, maxval(abs(y - [2.0_dp, -1.0_dp])) < 1e-5_dp)
    end subroutine test_ill_conditioned
end module test_square_root_information
