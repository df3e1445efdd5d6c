!> Several threads at once: the numbers of one, and objects that are made and freed all the time.
module test_threads
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_size_t
    use vocabulary
    use omp_lib, only: omp_get_num_threads
    use gracecg, only: ESTIMATOR_NAMES
    use gracecg_interface_handles, only: live_objects
    use c_library
    implicit none
    private
    public :: collect_threads

    integer(c_int), parameter :: OK = 0, BAD_HANDLE = 2, HAS_FAILED = 5
    integer, parameter :: THREADS = 2

contains

    subroutine collect_threads(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('there-are-two', test_two), &
                    new_unittest('models', test_models), &
                    new_unittest('simulation-and-estimation', test_estimation), &
                    new_unittest('making-and-freeing', test_churn), &
                    new_unittest('freed-while-in-use', test_free_in_use), &
                    new_unittest('freed-by-two', test_freed_by_two), &
                    new_unittest('messages-of-ones-own', test_messages)]
    end subroutine collect_threads

    !> Otherwise the others show nothing.
    subroutine test_two(error)
        type(error_type), allocatable, intent(out) :: error
        integer :: n

        n = 0
        !$omp parallel num_threads(THREADS)
        !$omp single
        n = omp_get_num_threads()
        !$omp end single
        !$omp end parallel
        call check(error, n, THREADS, 'threads')
    end subroutine test_two

    !> One force model in two threads.
    subroutine test_models(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: POINTS = 4000
        integer(c_intptr_t) :: case, model, gravity
        integer(c_int) :: status
        real(dp) :: state(13)
        real(dp), allocatable :: x(:, :), one(:, :), two(:, :), g_one(:, :), g_two(:, :)
        integer :: i, failures

        status = gracecg_case_open(c_string('front-1'), case)
        state = item(case, 'state', 13)
        status = gracecg_force_model_open(case, model)
        status = max(status, gracecg_gravity_open(c_string('egm96'), 40, 40, gravity))
        if (unmet(error, int(status), int(OK))) return
        allocate (x(3, POINTS), one(3, POINTS), two(3, POINTS), g_one(3, POINTS), g_two(3, POINTS))
        do i = 1, POINTS
            x(:, i) = 6.85e6_dp*[cos(0.01_dp*i), sin(0.01_dp*i)*cos(0.1_dp*i), sin(0.01_dp*i)*sin(0.1_dp*i)]
        end do
        failures = 0
        do i = 1, POINTS
            failures = failures + evaluate(i, one, g_one)
        end do
        !$omp parallel do num_threads(THREADS) schedule(static, 1) reduction(+:failures)
        do i = 1, POINTS
            failures = failures + evaluate(i, two, g_two)
        end do
        !$omp end parallel do
        call check(error, failures, 0)
        if (.not. allocated(error)) &
            call check(error, all(abs(two - one) <= 0) .and. all(abs(g_two - g_one) <= 0) .and. &
                       minval(norm2(one, 1)) > 8, 'two threads give other numbers than one')
        status = gracecg_free(gravity)
        status = gracecg_free(model)
        status = gracecg_free(case)

    contains

        integer function evaluate(k, total, acceleration) result(failed)
            integer, intent(in) :: k
            real(dp), intent(inout) :: total(:, :), acceleration(:, :)
            integer(c_int) :: first, second

            first = gracecg_force_model_evaluate(model, 1_c_size_t, [0.01_dp*k], x(:, k), state(4:6), state(10:13), &
                                                 total=total(:, k))
            second = gracecg_gravity_evaluate(gravity, 1_c_size_t, x(:, k), acceleration(:, k))
            failed = merge(0, 1, first == OK .and. second == OK)
        end function evaluate
    end subroutine test_models

    !> Each thread simulates and estimates on its own, all algorithms.
    subroutine test_estimation(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RUNS = 4
        integer(c_intptr_t) :: case, simulator
        integer(c_int) :: status
        real(dp), dimension(12, size(ESTIMATOR_NAMES), RUNS) :: one, two
        integer :: i, failures

        status = gracecg_case_open(c_string('front-3'), case)
        status = gracecg_simulator_open(case, simulator)
        if (unmet(error, int(status), int(OK))) return
        failures = 0
        do i = 1, RUNS
            failures = failures + estimates(i, one(:, :, i))
        end do
        !$omp parallel do num_threads(THREADS) schedule(dynamic) reduction(+:failures)
        do i = 1, RUNS
            failures = failures + estimates(i, two(:, :, i))
        end do
        !$omp end parallel do
        call check(error, failures, 0)
        call check(error, all(abs(two - one) <= 0) .and. all(abs(one(:3, :, :)) > 0), &
                   'two threads give other numbers than one')
        status = gracecg_free(simulator)
        status = gracecg_free(case)

    contains

        integer function estimates(run, solutions) result(failed)
            integer, intent(in) :: run
            real(dp), intent(inout) :: solutions(:, :)      ! offset and covariance
            integer(c_intptr_t) :: observations, fit
            integer(c_int) :: state
            integer :: j

            failed = 0
            state = gracecg_simulate(simulator, 7, run, observations)
            if (state /= OK) failed = failed + 1
            do j = 1, size(ESTIMATOR_NAMES)
                state = gracecg_estimate(c_string(trim(ESTIMATOR_NAMES(j))), observations, fit)
                if (state /= OK) failed = failed + 1
                solutions(:, j) = [item(fit, 'offset', 3), item(fit, 'covariance', 9)]
                state = gracecg_free(fit)
            end do
            state = gracecg_free(observations)
            if (state /= OK) failed = failed + 1
        end function estimates
    end subroutine test_estimation

    !> Two threads open, use and free objects of several kinds.
    subroutine test_churn(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ROUNDS = 3000
        integer(c_intptr_t) :: gravity, light
        integer(c_int) :: status(5)
        real(dp) :: a(3), flux(3), share
        real(dp), parameter :: UP(3) = [7e6_dp, 0.0_dp, 0.0_dp]
        integer :: i, failures, before

        before = live_objects()
        status(1) = gracecg_earth_radiation_open(c_string('report'), 0, 1000.0_dp, light)
        status(2) = gracecg_earth_radiation_evaluate(light, utc_struct(47528, 0.0_dp), 1_c_size_t, [0.0_dp], UP, flux)
        status(3) = gracecg_free(light)
        share = flux(1)/1000
        failures = 0
        !$omp parallel do num_threads(THREADS) schedule(static, 1) reduction(+:failures) &
        !$omp& private(gravity, light, status, a, flux)
        do i = 1, ROUNDS
            status(1) = gracecg_gravity_open(c_string('point-mass'), 0, 0, gravity)
            status(2) = gracecg_earth_radiation_open(c_string('report'), 0, 1000.0_dp + i, light)
            status(3) = gracecg_gravity_evaluate(gravity, 1_c_size_t, [7e6_dp, 1.0_dp*i, 0.0_dp], a)
            status(4) = gracecg_earth_radiation_evaluate(light, utc_struct(47528, 0.0_dp), 1_c_size_t, [0.0_dp], UP, flux)
            status(5) = max(gracecg_free(gravity), gracecg_free(light))
            if (any(status /= OK) .or. abs(flux(1)/(1000 + i) - share) > 1e-12_dp) failures = failures + 1
        end do
        !$omp end parallel do
        if (unmet(error, failures, 0, 'failures')) return
        call check(error, live_objects(), before, 'objects are left')
    end subroutine test_churn

    !> One thread works with a model that the other frees: the work is done, or refused.
    subroutine test_free_in_use(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ROUNDS = 30, POINTS = 200
        integer(c_intptr_t) :: gravity, copy
        integer(c_int) :: status, freed, opened
        real(dp) :: x(3, POINTS), a(3, POINTS), expected(3, POINTS)
        integer :: i, k, done, refused, wrong

        x = spread([7e6_dp, 1e5_dp, -3e6_dp], 2, POINTS)
        opened = gracecg_gravity_open(c_string('egm96'), 20, 20, gravity)
        opened = gracecg_gravity_evaluate(gravity, int(POINTS, c_size_t), x, expected)
        freed = gracecg_free(gravity)
        done = 0
        refused = 0
        wrong = 0
        do i = 1, ROUNDS
            opened = gracecg_gravity_open(c_string('egm96'), 20, 20, gravity)
            copy = gravity
            freed = HAS_FAILED
            !$omp parallel sections num_threads(THREADS) private(status, k, a)
            !$omp section
            do k = 1, 200
                status = gracecg_gravity_evaluate(copy, int(POINTS, c_size_t), x, a)
                if (status == BAD_HANDLE) then
                    refused = refused + 1
                    exit
                end if
                done = done + 1
                if (status /= OK .or. any(abs(a - expected) > 0)) wrong = wrong + 1
            end do
            !$omp section
            freed = gracecg_free(gravity)
            !$omp end parallel sections
            if (freed /= OK) wrong = wrong + 1
        end do
        call check(error, wrong, 0, 'wrong numbers, or a free that failed')
        call check(error, done + refused > 0, 'nothing was tried')
    end subroutine test_free_in_use

    !> Of two threads that free one object, one succeeds.
    subroutine test_freed_by_two(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ROUNDS = 500
        integer(c_intptr_t) :: gravity, copy
        integer(c_int) :: status
        integer :: i, successes, others

        successes = 0
        others = 0
        do i = 1, ROUNDS
            status = gracecg_gravity_open(c_string('point-mass'), 0, 0, gravity)
            !$omp parallel num_threads(THREADS) private(copy, status) reduction(+:successes, others)
            copy = gravity
            status = gracecg_free(copy)
            if (status == OK) successes = successes + 1
            if (status /= OK .and. status /= BAD_HANDLE) others = others + 1
            !$omp end parallel
        end do
        call check(error, successes, ROUNDS, 'frees that succeeded')
        call check(error, others, 0, 'other failures')
    end subroutine test_freed_by_two

    !> Failures in two threads do not mix.
    subroutine test_messages(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ROUNDS = 500
        type(error_struct) :: failure
        integer(c_intptr_t) :: handle
        integer(c_int) :: status
        character(8) :: name
        integer :: i, mixed

        mixed = 0
        !$omp parallel do num_threads(THREADS) schedule(static, 1) private(failure, handle, status, name) &
        !$omp& reduction(+:mixed)
        do i = 1, ROUNDS
            write (name, '("case", i4.4)') i
            status = gracecg_case_open(c_string(name), handle, failure)
            if (status /= HAS_FAILED .or. index(message_text(failure), name) == 0) mixed = mixed + 1
        end do
        !$omp end parallel do
        call check(error, mixed, 0, 'messages of other calls')
    end subroutine test_messages
end module test_threads
