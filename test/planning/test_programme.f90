!> Programmes of several manoeuvres: what the report's cases give together, and the search against all programmes.
module test_programme
    use vocabulary
    use calibrations
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t
    use gracecg_planning_programme, only: candidate_t, programme_t, candidates_along, best_programme, programme_sigma
    use gracecg_simulation_report_cases, only: TIME_OF_CASE
    use gracecg_estimation_offset_history, only: history_settings_t
    use mission_check, only: mission_result_t, check_mission
    use statistics, only: chi_square_limits
    implicit none
    private
    public :: collect_programme

contains

    subroutine collect_programme(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('report-in-two-steps', test_two_steps), &
                    new_unittest('search-finds-the-best', test_search), &
                    new_unittest('one-of-each', test_one_of_each), &
                    new_unittest('five-years', test_five_years)]
    end subroutine collect_programme

    logical function places_fail(times, durations, candidates, error)
        real(dp), intent(in) :: times(:), durations(:)
        type(candidate_t), allocatable, intent(out) :: candidates(:)
        type(error_type), allocatable, intent(inout) :: error
        type(calibration_t) :: calibration
        type(nominal_orbit_t) :: orbit
        type(error_t), allocatable :: failure

        call take_calibration('front-1', calibration)
        call make_orbit(calibration%case, orbit)
        call candidates_along(calibration%case, orbit, times, durations, 1, candidates, failure)
        places_fail = failed(error, failure)
    end function places_fail

    !> Front-2 with front-3: 7.2, 0.9, 6.4 micrometres, from the error ellipsoids that `bound` prints of each; all three
    !> cases 5.7, 0.9, 5.2.
    subroutine test_two_steps(error)
        type(error_type), allocatable, intent(out) :: error
        type(candidate_t), allocatable :: candidates(:)
        real(dp) :: two(3), three(3)

        if (places_fail(TIME_OF_CASE, [60.0_dp], candidates, error)) return
        two = programme_sigma(candidates(2)%information + candidates(3)%information)/MILLIMETRE
        three = programme_sigma(candidates(1)%information + candidates(2)%information + candidates(3)%information)/MILLIMETRE
        call check(error, all(abs(two - [0.0072_dp, 0.0009_dp, 0.0064_dp]) < 0.00011_dp), 'front-2 and front-3')
        call check(error, all(abs(three - [0.0057_dp, 0.0009_dp, 0.0052_dp]) < 0.00011_dp), 'all three')
    end subroutine test_two_steps

    !> Against all programmes of two and of three manoeuvres, 46 places with two lengths: within 2 %.
    subroutine test_search(error)
        type(error_type), allocatable, intent(out) :: error
        type(candidate_t), allocatable :: candidates(:)
        type(programme_t) :: programme
        real(dp) :: least
        integer :: i, j, k

        if (places_fail([(i*120.0_dp, i=0, 45)], [30.0_dp, 60.0_dp], candidates, error)) return
        least = huge(1.0_dp)
        do i = 1, size(candidates)
            do j = i, size(candidates)
                least = min(least, maxval(programme_sigma(candidates(i)%information + candidates(j)%information)))
            end do
        end do
        call best_programme(candidates, 2, programme)
        call check(error, maxval(programme%sigma(:, 2)) <= 1.000001_dp*least, 'two')
        least = huge(1.0_dp)
        do i = 1, size(candidates)
            do j = i, size(candidates)
                do k = j, size(candidates)
                    least = min(least, maxval(programme_sigma(candidates(i)%information + candidates(j)%information + &
                                                              candidates(k)%information)))
                end do
            end do
        end do
        call best_programme(candidates, 3, programme)
        call check(error, maxval(programme%sigma(:, 3)) <= 1.02_dp*least, 'three')
        call check(error, maxval(programme%sigma(:, 3)) >= least*(1 - 1e-9_dp), 'better than the best')
    end subroutine test_search

    subroutine test_one_of_each(error)
        type(error_type), allocatable, intent(out) :: error
        type(candidate_t) :: candidates(3)
        type(programme_t) :: programme
        integer :: i

        do i = 1, 3         ! each sees one axis well and the others hardly
            candidates(i)%information(1, 1) = 1
            candidates(i)%information(2, 2) = 1
            candidates(i)%information(3, 3) = 1
            candidates(i)%information(i, i) = 100
        end do
        call best_programme(candidates, 3, programme)
        call check(error, all(programme%sigma(:, 3) < 0.1_dp) .and. &
                   sum(programme%chosen) == 6 .and. product(programme%chosen) == 6)
    end subroutine test_one_of_each

    !> Five years with half-yearly calibrations by the best programme of two manoeuvres: at any time the RMS error is at most
    !> 10 micrometres an axis, the normalised squares of filter and smoother are 3.
    subroutine test_five_years(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: RUNS = 200
        type(candidate_t), allocatable :: candidates(:)
        type(programme_t) :: programme
        real(dp) :: covariance(3, 3)
        type(history_settings_t) :: settings
        type(mission_result_t) :: result
        type(error_t), allocatable :: failure
        real(dp) :: limits(2)
        integer :: i

        if (places_fail([(i*120.0_dp, i=0, 45)], [60.0_dp], candidates, error)) return
        call best_programme(candidates, 2, programme)
        covariance = inverse_3x3(candidates(programme%chosen(1))%information + &
                                 candidates(programme%chosen(2))%information)
        call check_mission(covariance, settings, RUNS, 3_i8, result, failure)
        if (failed(error, failure)) return
        call check(error, all(result%worst <= 10e-6_dp) .and. all(result%smoothed < result%filtered), '10 micrometres')
        ! eleven calibrations: some ten independent errors of three axes a run
        limits = chi_square_limits(3*10*RUNS)/(10*RUNS)
        call check(error, result%filtered_squares > limits(1) .and. result%filtered_squares < limits(2), 'filter')
        call check(error, result%smoothed_squares > limits(1) .and. result%smoothed_squares < limits(2), 'smoother')
        limits = chi_square_limits(30*RUNS)/(30*RUNS)
        call check(error, result%statistic > limits(1) .and. result%statistic < limits(2), 'innovations')
        ! a history that trusts too small a walk is found out
        settings%walk = 30e-6_dp
        call check_mission(covariance, settings, 20, 3_i8, result, failure)
        call check(error, any(result%worst > 10e-6_dp), 'a larger walk')
    end subroutine test_five_years
end module test_programme
