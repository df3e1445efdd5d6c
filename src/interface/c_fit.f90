!> The C interface: an estimate with all that it can tell of itself. Documented in include/gracecg.h.
module gracecg_interface_c_fit
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int32_t, c_intptr_t, c_size_t
    use gracecg, only: dp, error_t, operator_knowledge_t, solution_t, estimate_offset
    use gracecg_base_kinds, only: i8
    use gracecg_base_error, only: add_context
    use gracecg_base_text, only: integer_text
    use gracecg_environment_time, only: time_tag
    use gracecg_estimation_solution, only: STATE
    use gracecg_estimation_fit_record, only: fit_record_t, NOISE_SOURCES
    use gracecg_estimation_diagnostics, only: fit_diagnostics_t, diagnose
    use gracecg_interface_handles, only: object_t, acquire, release
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, STATUS_BAD_SIZE, STATUS_NOT_CONVERGED, LONGEST_NAME, &
        start, raise, pass_on, need, check_count, check_result, fortran_text, give_text, give_warnings, keep, &
        refuse_handle, free_object
    use gracecg_interface_c_estimation, only: observations_object_t, c_solution_t, give_solution, check_capacity
    implicit none
    private
    public :: c_fit_tests_t
    public :: c_fit_open, c_fit_free, c_fit_solution, c_fit_counts, c_fit_series, c_fit_parameter, c_fit_covariance
    public :: c_fit_tests, c_fit_running

    !> gracecg_fit_tests
    type, bind(c) :: c_fit_tests_t
        real(c_double) :: torque_factor         !! Of the rods' torque
        real(c_double) :: torque_sigma          !! Its standard deviation; 0: not compared
        real(c_double) :: attitude_misfit       !! Standard deviations
        real(c_double) :: rms(3)                !! m/s^2
        real(c_double) :: expected_rms(3)       !! m/s^2; 0: the noise is not known
        real(c_double) :: ratio(3)              !! 1 if the noise is that of the setup
        real(c_double) :: ratio_sigma(3)        !! By chance
        real(c_double) :: probability(3)        !! Of Ljung and Box
        real(c_double) :: worst(3)              !! m/s^2
        real(c_double) :: worst_time(3)         !! s
        real(c_double) :: peak_frequency(3)     !! Hz
        real(c_double) :: peak_ratio(3)         !! Of the spectrum there to the expected one
        real(c_double) :: bound(3)              !! m; 0: not determined
        real(c_double) :: information_share(3, 3)               !! (component, axis)
        real(c_double) :: source_share(3, NOISE_SOURCES)        !! (component, source)
        real(c_double) :: semi_axis(3)          !! m
        real(c_double) :: direction(3, 3)       !! Columns, body axes
    end type c_fit_tests_t

    type, extends(object_t) :: fit_object_t
        type(solution_t) :: solution
        type(fit_record_t) :: record
        type(operator_knowledge_t) :: knowledge     !! Of the observations
    end type fit_object_t

    character(*), parameter :: FIT_NAME = 'fit'

contains

    !> gracecg_fit_open
    function c_fit_open(algorithm, observations, handle, error) result(status) bind(c, name='gracecg_fit_open')
        character(kind=c_char), intent(in), optional :: algorithm(*)
        integer(c_intptr_t), intent(in), value :: observations
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object, new_object
        type(fit_object_t), pointer :: made
        type(error_t), allocatable :: failure
        character(:), allocatable :: name
        integer :: memory

        call start(status, error)
        call need(present(handle), FIT_NAME, status, error)
        if (present(handle)) handle = 0
        call fortran_text(algorithm, LONGEST_NAME, 'algorithm', name, status, error)
        if (status /= STATUS_OK) return
        new_object => null()
        call acquire(int(observations, i8), object)
        select type (object)
        type is (observations_object_t)
            allocate (made, stat=memory)
            if (memory == 0) then
                new_object => made
                made%knowledge = object%set%knowledge
                call estimate_offset(name, object%set, object%options, made%solution, failure, made%record)
                call pass_on(failure, status, error)
                call check_result([made%solution%offset, [made%solution%covariance], made%solution%residual_rms], &
                                  'the estimate', status, error)
            end if
        class default
            call refuse_handle('observation set', status, error)
        end select
        call release(int(observations, i8), object)
        call keep(new_object, handle, status, error)
    end function c_fit_open

    !> gracecg_fit_free
    function c_fit_free(handle, error) result(status) bind(c, name='gracecg_fit_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(fit_object_t) :: mold

        call free_object(handle, FIT_NAME, status, error, mold)
    end function c_fit_free

    !> gracecg_fit_solution
    function c_fit_solution(handle, c_solution, warnings, size, error) result(status) &
        bind(c, name='gracecg_fit_solution')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_solution_t), intent(inout), optional :: c_solution
        character(kind=c_char), intent(inout), optional :: warnings(*)
        integer(c_size_t), intent(in), value :: size
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call need(present(c_solution), 'solution', status, error)
        call check_count(size, 'size', status, error)
        if (size /= 0) call need(present(warnings), 'warnings', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (fit_object_t)
            call give_solution(object%solution, c_solution)
            call give_warnings(object%solution%warnings, warnings, size)
            if (.not. object%solution%converged) call raise(STATUS_NOT_CONVERGED, 'the estimate did not converge in '// &
                integer_text(object%solution%iterations)//' iterations: the offset is not to be relied upon', status, error)
        class default
            call refuse_handle(FIT_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_fit_solution

    !> gracecg_fit_counts
    function c_fit_counts(handle, samples, parameters, running, error) result(status) &
        bind(c, name='gracecg_fit_counts')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(inout), optional :: samples, parameters, running
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call acquire(int(handle, i8), object)
        select type (object)
        type is (fit_object_t)
            if (present(samples)) samples = size(object%record%epoch)
            if (present(parameters)) parameters = size(object%record%names)
            if (present(running)) then
                running = 0
                if (allocated(object%solution%running)) running = size(object%solution%running%time)
            end if
        class default
            call refuse_handle(FIT_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_fit_counts

    !> gracecg_fit_series
    function c_fit_series(handle, capacity, time, residual, partials, angular_acceleration, error) result(status) &
        bind(c, name='gracecg_fit_series')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: capacity
        real(c_double), intent(inout), optional :: time(*), residual(3, *), partials(3, 3, *)
        real(c_double), intent(inout), optional :: angular_acceleration(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        integer :: i

        call start(status, error)
        call check_count(capacity, 'capacity', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (fit_object_t)
            associate (record => object%record)
                call check_capacity(size(record%epoch), capacity, status, error)
                if (status == STATUS_OK) then
                    do i = 1, size(record%epoch)
                        if (present(time)) time(i) = time_tag(record%epoch(i), record%interval)
                        if (present(residual)) residual(:, i) = record%residual(:, i)
                        ! A row of C's is a column here
                        if (present(partials)) partials(:, :, i) = transpose(record%partials(:, :, i))
                        if (present(angular_acceleration)) angular_acceleration(:, i) = record%angular_acceleration(:, i)
                    end do
                end if
            end associate
        class default
            call refuse_handle(FIT_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_fit_series

    !> gracecg_fit_parameter
    function c_fit_parameter(handle, index, text, size, length, error) result(status) &
        bind(c, name='gracecg_fit_parameter')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: index
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: size
        integer(c_size_t), intent(inout), optional :: length
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        character(:), allocatable :: name

        call start(status, error)
        call check_count(index, 'index', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (fit_object_t)
            if (index < ubound(object%record%names, 1)) then
                name = trim(object%record%names(index + 1))
            else
                call raise(STATUS_BAD_SIZE, 'index = '//integer_text(int(index))//': there are '// &
                           integer_text(ubound(object%record%names, 1))//' parameters', status, error)
            end if
        class default
            call refuse_handle(FIT_NAME, status, error)
        end select
        call release(int(handle, i8), object)
        if (status == STATUS_OK) call give_text(name, text, size, length, status, error)
    end function c_fit_parameter

    !> gracecg_fit_covariance
    function c_fit_covariance(handle, capacity, covariance, by_source, state_covariance, error) result(status) &
        bind(c, name='gracecg_fit_covariance')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: capacity
        real(c_double), intent(inout), optional :: covariance(*), by_source(3, 3, *), state_covariance(STATE, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        integer :: i, n

        call start(status, error)
        call check_count(capacity, 'capacity', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (fit_object_t)
            n = size(object%record%names)
            if (present(covariance)) then
                call check_capacity(n, capacity, status, error)
                if (status == STATUS_OK) then
                    do i = 1, n
                        covariance((i - 1)*n + 1:i*n) = object%record%covariance(:, i)
                    end do
                end if
            end if
            if (status == STATUS_OK) then
                if (present(by_source)) by_source(:, :, :NOISE_SOURCES) = object%record%covariance_by_source
                if (present(state_covariance)) state_covariance(:, :STATE) = object%solution%state_covariance
            end if
        class default
            call refuse_handle(FIT_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_fit_covariance

    !> gracecg_fit_test
    function c_fit_tests(handle, tests, error) result(status) bind(c, name='gracecg_fit_test')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_fit_tests_t), intent(inout), optional :: tests
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(fit_diagnostics_t) :: found
        type(error_t), allocatable :: failure

        call start(status, error)
        call need(present(tests), 'tests', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (fit_object_t)
            call diagnose(object%knowledge, object%solution, object%record, found, failure)
            call add_context(failure, 'tests of the fit')
            call pass_on(failure, status, error)
            if (status == STATUS_OK) call give_tests(object%record, found, tests)
        class default
            call refuse_handle(FIT_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_fit_tests

    subroutine give_tests(record, found, tests)
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(in) :: found
        type(c_fit_tests_t), intent(inout) :: tests

        tests%torque_factor = record%torque_factor
        tests%torque_sigma = record%torque_sigma
        tests%attitude_misfit = record%attitude_misfit
        tests%rms = found%residuals%rms
        tests%expected_rms = found%residuals%expected_rms
        tests%ratio = found%residuals%ratio
        tests%ratio_sigma = found%residuals%ratio_sigma
        tests%probability = found%residuals%probability
        tests%worst = found%residuals%worst
        tests%worst_time = found%residuals%worst_time
        tests%peak_frequency = found%residuals%peak_frequency
        tests%peak_ratio = found%residuals%peak_ratio
        tests%bound = found%bound
        tests%information_share = found%information_share
        tests%source_share = found%source_share
        tests%semi_axis = found%ellipsoid%semi_axis
        tests%direction = found%ellipsoid%direction
    end subroutine give_tests

    !> gracecg_fit_running
    function c_fit_running(handle, capacity, time, offset, sigma, error) result(status) &
        bind(c, name='gracecg_fit_running')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: capacity
        real(c_double), intent(inout), optional :: time(*), offset(3, *), sigma(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        integer :: n

        call start(status, error)
        call check_count(capacity, 'capacity', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (fit_object_t)
            n = 0
            if (allocated(object%solution%running)) n = size(object%solution%running%time)
            call check_capacity(n, capacity, status, error)
            if (status == STATUS_OK .and. n > 0) then
                if (present(time)) time(:n) = object%solution%running%time
                if (present(offset)) offset(:, :n) = object%solution%running%offset
                if (present(sigma)) sigma(:, :n) = object%solution%running%sigma
            end if
        class default
            call refuse_handle(FIT_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_fit_running
end module gracecg_interface_c_fit
