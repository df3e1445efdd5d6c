!> The square-root information filter against dense least squares and the dense Gaussian posterior.
module test_square_root_filter
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_base_gauss_markov
    use gracecg_estimation_square_root_filter
    use statistics, only: chi_square_limits, ljung_box, variance, mean, Z_999
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_square_root_filter

    integer, parameter :: STEPS = 60        !! Intervals; epochs 0..STEPS
    integer, parameter :: M = 3             !! Constants
    real(dp), parameter :: INTERVAL = 0.1_dp

contains

    subroutine collect_square_root_filter(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('equals-least-squares', test_least_squares), &
                    new_unittest('equals-gaussian-posterior', test_posterior), &
                    new_unittest('filter-equals-posterior-of-the-past', test_filter_on_the_way), &
                    new_unittest('likelihood-of-the-innovations', test_likelihood), &
                    new_unittest('innovations-white-and-chi-square', test_innovations), &
                    new_unittest('smoother-never-worse-than-filter', test_smoother_sigma), &
                    new_unittest('survives-ill-conditioning', test_ill_conditioned), &
                    new_unittest('undetermined-is-said', test_undetermined), &
                    new_unittest('bad-covariance-is-refused', test_bad_covariance)]
    end subroutine collect_square_root_filter

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

    !> Filters up to an epoch.
    subroutine run_filter(process, observed, last, filter, constants)
        type(gauss_markov_t), intent(in) :: process
        real(dp), intent(in) :: observed(0:STEPS)
        integer, intent(in) :: last
        type(process_filter_t), intent(out) :: filter
        type(constants_t), intent(out) :: constants

        type(error_t), allocatable :: failure
        real(dp) :: remainder(M + 1)
        integer :: k

        constants = new_constants(M)
        call new_process_filter(process, M, STEPS, filter, failure)
        if (allocated(failure)) error stop failure%message
        do k = 0, last
            if (k > 0) call filter%advance()
            if (.not. is_observed(k)) cycle
            call filter%observe(process%output, [partials(k), observed(k)], remainder)
            call constants%fold_in(remainder)
        end do
    end subroutine run_filter

    !> Without a process: least squares by normal equations.
    subroutine test_least_squares(error)
        type(error_type), allocatable, intent(out) :: error
        type(process_filter_t) :: filter
        type(constants_t) :: constants
        type(error_t), allocatable :: failure
        real(dp) :: observed(0:STEPS), rows(M, 0:STEPS), normal(M, M), rhs(M), y(M), covariance(M, M), condition
        real(dp) :: inverse(M, M), last(2), last_covariance(2, 2), left(0:STEPS)
        integer :: k

        call simulate(example_process(), 1, observed)
        call run_filter(no_process(), observed, STEPS, filter, constants)
        do k = 0, STEPS
            rows(:, k) = merge(partials(k), 0.0_dp, is_observed(k))
        end do
        call normal_equations(rows, observed, normal, rhs)
        call solve_normal_equations(normal, rhs, y, covariance, condition, failure)
        inverse = constants%inverse_root()
        call check(error, maxval(abs(constants%solution()/y - 1)) < 1e-10_dp, 'estimate')
        if (allocated(error)) return
        call check(error, maxval(abs(matmul(inverse, transpose(inverse)) - covariance)) < &
                   1e-10_dp*maxval(covariance), 'covariance')
        if (allocated(error)) return
        call constants%last_covariance(last, last_covariance)
        call check(error, maxval(abs(last/y(2:) - 1)) < 1e-10_dp .and. &
                   maxval(abs(last_covariance/covariance(2:, 2:) - 1)) < 1e-9_dp, 'the last two')
        if (allocated(error)) return
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

    !> The exact posterior of constants and outputs from the observations up to `last`, by inversion of
    !> the dense covariance matrix of the observations (generalised least squares, then kriging).
    subroutine dense_posterior(process, observed, last, y, y_covariance, output, output_variance, minus_two_log_likelihood)
        type(gauss_markov_t), intent(in) :: process
        real(dp), intent(in) :: observed(0:STEPS)
        integer, intent(in) :: last
        real(dp), intent(out) :: y(M), y_covariance(M, M), output(0:STEPS), output_variance(0:STEPS)
        real(dp), intent(out) :: minus_two_log_likelihood

        real(dp), allocatable :: total(:, :), inverse(:, :), unused(:), g(:, :), weighted(:, :), root(:, :), r(:)
        real(dp) :: dense(0:STEPS, 0:STEPS), normal(M, M), condition, influence(M)
        integer, allocatable :: used(:)
        type(error_t), allocatable :: failure
        integer :: i, j, k, n

        dense = dense_covariance(process)
        used = pack([(k, k=0, last)], [(is_observed(k), k=0, last)])
        n = size(used)
        allocate (total(n, n), inverse(n, n), unused(n), g(M, n), root(n, n), r(n))
        total = dense(used, used)
        do i = 1, n
            total(i, i) = total(i, i) + 1
            g(:, i) = partials(used(i))
        end do
        r = 0
        call solve_normal_equations(total, r, unused, inverse, condition, failure)
        if (allocated(failure)) error stop failure%message
        weighted = matmul(g, inverse)
        normal = matmul(weighted, transpose(g))
        call solve_normal_equations(normal, matmul(weighted, observed(used)), y, y_covariance, condition, failure)
        r = observed(used) - matmul(y, g)
        do k = 0, STEPS
            output(k) = dot_product(dense(k, used), matmul(inverse, r))
            influence = matmul(weighted, dense(used, k))
            output_variance(k) = dense(k, k) - dot_product(dense(k, used), matmul(inverse, dense(used, k))) + &
                                 dot_product(influence, matmul(y_covariance, influence))
        end do
        ! ln det of the covariance by Cholesky
        root = 0
        minus_two_log_likelihood = dot_product(r, matmul(inverse, r))
        do j = 1, n
            root(j, j) = sqrt(total(j, j) - sum(root(j, :j - 1)**2))
            do i = j + 1, n
                root(i, j) = (total(i, j) - dot_product(root(i, :j - 1), root(j, :j - 1)))/root(j, j)
            end do
            minus_two_log_likelihood = minus_two_log_likelihood + 2*log(root(j, j))
        end do
    end subroutine dense_posterior

    !> Output of the process and its variance from the smoother.
    subroutine smoothed_output(filter, constants, output, output_variance)
        type(process_filter_t), intent(in) :: filter
        type(constants_t), intent(in) :: constants
        real(dp), intent(out) :: output(0:STEPS), output_variance(0:STEPS)

        type(process_smoother_t) :: smoother
        real(dp) :: y(M), root(M, M), through(M)
        integer :: k

        y = constants%solution()
        root = constants%inverse_root()
        call start_smoother(filter, smoother)
        do k = filter%step, 0, -1
            associate (h => filter%process%output)
                output(k) = dot_product(h, smoother%mean + matmul(y, smoother%gain))
                through = matmul(matmul(smoother%gain, h), root)
                output_variance(k) = dot_product(h, matmul(smoother%covariance, h)) + sum(through**2)
            end associate
            if (k > 0) call smoother%step_back(filter)
        end do
    end subroutine smoothed_output

    subroutine test_posterior(error)
        type(error_type), allocatable, intent(out) :: error
        type(process_filter_t) :: filter
        type(constants_t) :: constants
        real(dp) :: observed(0:STEPS), y(M), y_covariance(M, M), output(0:STEPS), output_variance(0:STEPS), unused
        real(dp) :: smoothed(0:STEPS), smoothed_variance(0:STEPS), root(M, M)

        call simulate(example_process(), 2, observed)
        call dense_posterior(example_process(), observed, STEPS, y, y_covariance, output, output_variance, unused)
        call run_filter(example_process(), observed, STEPS, filter, constants)
        root = constants%inverse_root()
        call check(error, maxval(abs(constants%solution() - y)) < 1e-9_dp, 'constants')
        if (allocated(error)) return
        call check(error, maxval(abs(matmul(root, transpose(root)) - y_covariance)) < &
                   1e-9_dp*maxval(abs(y_covariance)), 'covariance of the constants')
        if (allocated(error)) return
        call smoothed_output(filter, constants, smoothed, smoothed_variance)
        call check(error, maxval(abs(smoothed - output)) < 1e-8_dp, 'smoothed process')
        if (allocated(error)) return
        call check(error, maxval(abs(smoothed_variance/output_variance - 1)) < 1e-8_dp, 'its variance')
    end subroutine test_posterior

    subroutine test_filter_on_the_way(error)
        type(error_type), allocatable, intent(out) :: error
        type(process_filter_t) :: filter
        type(constants_t) :: constants
        type(innovation_t) :: innovation
        real(dp) :: observed(0:STEPS), y(M), y_covariance(M, M), output(0:STEPS), output_variance(0:STEPS), unused
        real(dp) :: expected
        integer, parameter :: K = 30

        call simulate(example_process(), 3, observed)
        call dense_posterior(example_process(), observed, K, y, y_covariance, output, output_variance, unused)
        call run_filter(example_process(), observed, K, filter, constants)
        call check(error, maxval(abs(constants%solution() - y)) < 1e-9_dp, 'constants at epoch 30')
        if (allocated(error)) return
        call filter%advance()
        innovation = filter%predict_observation(constants, filter%process%output, &
                                                [partials(K + 1), observed(K + 1)])
        expected = observed(K + 1) - output(K + 1) - dot_product(partials(K + 1), y)
        call check(error, innovation%defined, 'innovation is defined')
        if (allocated(error)) return
        call check(error, abs(innovation%residual - expected) < 1e-9_dp, 'innovation')
    end subroutine test_filter_on_the_way

    subroutine test_likelihood(error)
        type(error_type), allocatable, intent(out) :: error
        type(process_filter_t) :: filter
        type(constants_t) :: constants
        real(dp) :: observed(0:STEPS), y(M), y_covariance(M, M), output(0:STEPS), output_variance(0:STEPS), expected

        call simulate(example_process(), 4, observed)
        call dense_posterior(example_process(), observed, STEPS, y, y_covariance, output, output_variance, expected)
        call run_filter(example_process(), observed, STEPS, filter, constants)
        call check(error, abs(filter%log_variance + constants%squares - expected) < 1e-8_dp*abs(expected))
    end subroutine test_likelihood

    !> Innovations of many runs, standardised: variance 1, no correlation in time.
    subroutine test_innovations(error)
        type(error_type), allocatable, intent(out) :: error
        type(process_filter_t) :: filter
        type(constants_t) :: constants
        type(innovation_t) :: innovation
        type(gauss_markov_t) :: process
        type(error_t), allocatable :: failure
        integer, parameter :: RUNS = 100, LAGS = 20
        real(dp) :: observed(0:STEPS), remainder(M + 1), limits(2), whiteness, squares
        real(dp) :: series(STEPS), per_run
        integer :: run, k, used, total

        process = example_process()
        whiteness = 0
        squares = 0
        total = 0
        do run = 1, RUNS
            call simulate(process, 100 + run, observed)
            constants = new_constants(M)
            call new_process_filter(process, M, 0, filter, failure)
            used = 0
            do k = 0, STEPS
                if (k > 0) call filter%advance()
                if (.not. is_observed(k)) cycle
                innovation = filter%predict_observation(constants, process%output, [partials(k), observed(k)])
                if (innovation%defined) then
                    used = used + 1
                    series(used) = innovation%residual/sqrt(innovation%variance)
                end if
                call filter%observe(process%output, [partials(k), observed(k)], remainder)
                call constants%fold_in(remainder)
            end do
            call check(error, used == 53, 'innovations of a run')
            if (allocated(error)) return
            per_run = sum(series(:used)**2)
            squares = squares + per_run
            total = total + used
            whiteness = whiteness + ljung_box(series(:used), LAGS)
        end do
        limits = chi_square_limits(total)
        call check(error, squares > limits(1) .and. squares < limits(2), 'chi-square of the innovations')
        if (allocated(error)) return
        limits = chi_square_limits(RUNS*LAGS)
        call check(error, whiteness > limits(1) .and. whiteness < limits(2), 'whiteness of the innovations')
    end subroutine test_innovations

    subroutine test_smoother_sigma(error)
        type(error_type), allocatable, intent(out) :: error
        type(process_filter_t) :: filter, whole
        type(constants_t) :: constants, final
        type(process_smoother_t) :: now
        real(dp) :: observed(0:STEPS), smoothed(0:STEPS), smoothed_variance(0:STEPS), root(M, M), through(M)
        real(dp) :: filtered_variance
        integer :: k

        call simulate(example_process(), 5, observed)
        call run_filter(example_process(), observed, STEPS, whole, final)
        call smoothed_output(whole, final, smoothed, smoothed_variance)
        do k = 10, STEPS, 5
            call run_filter(example_process(), observed, k, filter, constants)
            call start_smoother(filter, now)
            root = constants%inverse_root()
            through = matmul(matmul(now%gain, filter%process%output), root)
            filtered_variance = dot_product(filter%process%output, &
                                            matmul(now%covariance, filter%process%output)) + sum(through**2)
            call check(error, smoothed_variance(k) <= filtered_variance*(1 + 1e-10_dp), 'smoother against filter')
            if (allocated(error)) return
        end do
        call check(error, smoothed_variance(30) < 0.9_dp*filtered_variance, 'the middle is smoothed')
    end subroutine test_smoother_sigma

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

    subroutine test_undetermined(error)
        type(error_type), allocatable, intent(out) :: error
        type(constants_t) :: constants

        constants = new_constants(2)
        call constants%fold_in([1.0_dp, 0.5_dp, 3.0_dp])
        call check(error, .not. constants%is_determined(), 'one observation of two constants')
        if (allocated(error)) return
        call constants%fold_in([1.0_dp, -0.5_dp, 3.0_dp])
        call check(error, constants%is_determined(), 'two observations of two constants')
    end subroutine test_undetermined

    subroutine test_bad_covariance(error)
        type(error_type), allocatable, intent(out) :: error
        type(process_filter_t) :: filter
        type(gauss_markov_t) :: process
        type(error_t), allocatable :: failure

        process = first_order_process(0.0_dp, 0.5_dp)
        call new_process_filter(process, 1, 0, filter, failure)
        call check(error, allocated(failure), 'a process without variance has no information matrix')
    end subroutine test_bad_covariance
end module test_square_root_filter
