!> Errors in the operator's knowledge, each alone: the bound's consider covariance, differences of estimates and
!> draws agree.
module test_knowledge_errors
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, message_of
    use statistics, only: Z_999
    use gracecg_estimation_report_options, only: report_options
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_operator_errors
    use gracecg_simulation_report_cases, only: report_case
    use gracecg_simulation_simulator, only: simulator_t, new_simulator
    use gracecg_studies_consider_check, only: consider_check_t, check_consider
    use gracecg_studies_knowledge_errors, only: knowledge_study_t, study_knowledge, source_sigma, size_text, &
        SIGMA_OF_CASE, SIGMA_A_PRIORI, SIGMA_BY_DEFAULT
    use fixture, only: check, check_passes
    use testdrive, only: new_unittest, unittest_type, error_type
    implicit none
    private
    public :: collect_knowledge_errors

contains

    subroutine collect_knowledge_errors(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('consider-covariance-against-draws', test_consider), &
                    new_unittest('sizes-and-where-they-come-from', test_sizes), &
                    new_unittest('every-source-in-every-estimator', test_estimators)]
    end subroutine collect_knowledge_errors

    !> Differences of estimates agree with the bound within 3 %, what is not linear in them; the draws besides
    !> within their own uncertainty, 1/sqrt(2 n) of an RMS of n.
    subroutine test_consider(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RUNS = 40, CHECKED(*) = [INERTIA, COMMON_ROD_GAIN, ACCELEROMETER_SCALE, &
            MAGNETOMETER_BIAS, TORQUE_CHANGE, PRINCIPAL_MOMENTS, ROD_GAIN, ROD_DIRECTION, ROD_DELAY, &
            ACCELEROMETER_DELAY]
        real(dp), parameter :: CURVATURE = 0.03_dp
        type(case_t) :: case
        type(consider_check_t) :: result
        type(error_t), allocatable :: failure
        integer :: i

        call report_case('front-1', case, failure)
        do i = 1, size(CHECKED)
            call check_consider(case, report_options('front-1'), CHECKED(i), 1_i8, RUNS, 2, result, failure)
            call check_passes(error, message_of(failure))
            if (allocated(error)) return
            associate (small => result%considered < 1e-4_dp*result%noise)
                call check(error, all(small .or. abs(result%predicted/result%considered - 1) < CURVATURE), &
                           'differences, '//SOURCES(CHECKED(i))%name)
                call check(error, all(small .or. abs(result%rms/result%considered - 1) < &
                                      CURVATURE + Z_999/sqrt(2.0_dp*RUNS)), 'draws, '//SOURCES(CHECKED(i))%name)
                call check(error, .not. all(small), 'no effect, '//SOURCES(CHECKED(i))%name)
            end associate
        end do
    end subroutine test_consider

    !> The case's sigma before the a-priori one before the default size.
    subroutine test_sizes(error)
        type(error_type), allocatable, intent(out) :: error
        type(operator_t) :: operator
        type(knowledge_study_t) :: study
        real(dp), allocatable :: sigma(:)
        integer :: origin

        call source_sigma(operator, COMMON_ROD_GAIN, sigma, origin)
        call check(error, origin == SIGMA_A_PRIORI .and. all(sigma == operator%a_priori%sigma_rod_gain))
        operator%sigma(1, COMMON_ROD_GAIN) = 0.02_dp
        call source_sigma(operator, COMMON_ROD_GAIN, sigma, origin)
        call check(error, origin == SIGMA_OF_CASE .and. all(sigma == 0.02_dp))
        study%source = MOUNTING
        call source_sigma(operator, MOUNTING, study%sigma, study%origin)
        call check(error, study%origin == SIGMA_BY_DEFAULT .and. size(study%sigma) == 6)
        if (allocated(error)) return
        call check(error, trim(size_text(study)) == 'mounting_arcsec: sigma 20 arcsec (default size)', size_text(study))
    end subroutine test_sizes

    !> No source makes an estimator fail, and the rods' gain changes the estimate of each.
    subroutine test_estimators(error)
        type(error_type), allocatable, intent(out) :: error
        character(10), parameter :: ALGORITHMS(4) = [character(10) :: 'assest-rde', 'ascfest', 'optimal', 'sequential']
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(knowledge_study_t) :: study
        type(error_t), allocatable :: failure
        integer :: i, k

        call report_case('back-1', case, failure)
        if (.not. allocated(failure)) call new_simulator(case, simulator, failure)
        call check_passes(error, message_of(failure))
        do k = 1, size(ALGORITHMS)
            do i = 1, size(SOURCES)
                if (allocated(error)) return
                call study_knowledge(simulator, trim(ALGORITHMS(k)), report_options('back-1'), i, 1_i8, 1, 2, study, failure)
                call check_passes(error, message_of(failure))
                if (allocated(error)) return
                if (i == COMMON_ROD_GAIN) call check(error, any(study%predicted > 1e-7_dp), ALGORITHMS(k))
            end do
        end do
    end subroutine test_estimators
end module test_knowledge_errors
