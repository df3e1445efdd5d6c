!> Errors in the operator's knowledge, each alone: the bound's consider covariance and differences of estimates agree.
module test_knowledge_errors
    use vocabulary
    use calibrations
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_estimation_options, only: NOISE_GIVEN
    use gracecg_estimation_report_options, only: report_options
    use gracecg_planning_bound, only: case_bound_t, bound_of_case, OPERATOR_PLACES
    use gracecg_simulation_operator_errors
    use gracecg_simulation_simulator, only: tell_operator, error_switches_t, new_switched_simulator
    implicit none
    private
    public :: collect_knowledge_errors

contains

    subroutine collect_knowledge_errors(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('consider-covariance-against-estimates', test_consider), &
                    new_unittest('every-source-in-every-estimator', test_estimators)]
    end subroutine collect_knowledge_errors

    !> Differences of estimates agree with the bound within 3 %, what is not linear in them.
    subroutine test_consider(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: CHECKED(*) = [INERTIA, COMMON_ROD_GAIN, ACCELEROMETER_SCALE, MAGNETOMETER_BIAS, &
            TORQUE_CHANGE, PRINCIPAL_MOMENTS, ROD_GAIN, ROD_DIRECTION, ROD_DELAY, ACCELEROMETER_DELAY]
        real(dp), parameter :: CURVATURE = 0.03_dp
        type(case_t) :: case
        type(case_bound_t) :: bound
        type(estimation_options_t) :: options
        type(simulator_t) :: simulator
        type(error_t), allocatable :: failure
        real(dp) :: considered(3), found(3)
        integer :: i, place

        options = report_options('front-1')
        do i = 1, size(CHECKED)
            call take_case('front-1', case)
            associate (sigma => sizes_of(case%operator, CHECKED(i)))
                case%operator%sigma = 0
                case%operator%sigma(:size(sigma), CHECKED(i)) = sigma
            end associate
            call bound_of_case(case, options, bound, failure)
            if (.not. allocated(failure)) &
                call new_switched_simulator(case, error_switches_t(curved_force=.false., scale_factors=.false., &
                                                                   magnetometer_bias=.false.), simulator, failure)
            options%optimal%estimate_within_limits = .false.    ! but considered
            if (.not. allocated(failure)) call differences(simulator, 'optimal', options, CHECKED(i), found, failure)
            options = report_options('front-1')
            if (failed(error, failure)) return
            place = findloc(OPERATOR_PLACES, CHECKED(i), 1)
            considered = bound%by_knowledge(:, CHECKED(i))
            if (place > 0) considered = bound%by_source(:, place)
            associate (small => considered < 1e-4_dp*bound%sigma)
                call check(error, all(small .or. abs(found/considered - 1) < CURVATURE), SOURCES(CHECKED(i))%name)
                call check(error, .not. all(small), 'no effect, '//SOURCES(CHECKED(i))%name)
            end associate
        end do
    end subroutine test_consider

    !> Standard deviations of a source, SI: a priori where the operator has one, else its usual size.
    pure function sizes_of(operator, source) result(sigma)
        type(operator_t), intent(in) :: operator
        integer, intent(in) :: source
        real(dp), allocatable :: sigma(:)

        integer :: n

        n = SOURCES(source)%components
        select case (source)
        case (INERTIA)
            sigma = spread(operator%a_priori%sigma_inertia, 1, n)
        case (COMMON_ROD_GAIN)
            sigma = [operator%a_priori%sigma_rod_gain]
        case (ACCELEROMETER_SCALE)
            sigma = operator%a_priori%aged_scale_sigmas()
        case (MAGNETOMETER_BIAS)
            sigma = operator%a_priori%sigma_magnetometer_bias
        case (TORQUE_CHANGE)
            sigma = spread(operator%a_priori%sigma_torque, 1, n)
        case default
            sigma = spread(SOURCES(source)%size*SOURCES(source)%factor, 1, n)
        end select
    end function sizes_of

    !> Half of the differences of the offset with each component of a source one sigma up and down, added in squares, m.
    subroutine differences(simulator, algorithm, options, source, found, failure)
        type(simulator_t), intent(in) :: simulator
        character(*), intent(in) :: algorithm
        type(estimation_options_t), intent(in) :: options
        integer, intent(in) :: source
        real(dp), intent(out) :: found(3)
        type(error_t), allocatable, intent(out) :: failure
        type(observation_set_t) :: observations, told
        type(estimation_options_t) :: own
        type(operator_t) :: wrong
        type(solution_t) :: solution
        real(dp) :: offset(3, 2)
        integer :: i, k

        own = options
        own%covariance = .false.
        own%optimal%noise = NOISE_GIVEN         ! there is none to estimate
        call observe_without_noise(simulator, density_wave_t(), observations)
        found = 0
        associate (sigma => sizes_of(simulator%case%operator, source))
            do i = 1, size(sigma)
                do k = 1, 2
                    wrong = simulator%case%operator
                    wrong%sigma = 0
                    wrong%value(i, source) = wrong%value(i, source) + merge(sigma(i), -sigma(i), k == 1)
                    told = observations
                    call tell_operator(simulator, wrong, told)
                    call estimate_offset(algorithm, told, own, solution, failure)
                    if (allocated(failure)) return
                    offset(:, k) = solution%offset
                end do
                found = sqrt(found**2 + ((offset(:, 1) - offset(:, 2))/2)**2)
            end do
        end associate
    end subroutine differences

    !> No source makes an estimator fail, and the rods' gain changes the estimate of each.
    subroutine test_estimators(error)
        type(error_type), allocatable, intent(out) :: error
        character(10), parameter :: ALGORITHMS(4) = [character(10) :: 'assest-rde', 'ascfest', 'optimal', 'sequential']
        type(simulator_t) :: simulator
        type(error_t), allocatable :: failure
        real(dp) :: found(3)
        integer :: i, k

        call make_simulator('back-1', simulator)
        do k = 1, size(ALGORITHMS)
            do i = 1, size(SOURCES)
                call differences(simulator, trim(ALGORITHMS(k)), report_options('back-1'), i, found, failure)
                call check_passes(error, failure)
                if (i == COMMON_ROD_GAIN) call check(error, any(found > 1e-7_dp), ALGORITHMS(k))
            end do
        end do
    end subroutine test_estimators
end module test_knowledge_errors
