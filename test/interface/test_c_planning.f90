!> The C interface to bound and planner, called as C calls it: the numbers are those of the Fortran API.
module test_c_planning
    use, intrinsic :: iso_c_binding, only: c_int, c_int32_t, c_intptr_t, c_size_t
    use vocabulary
    use calibrations
    use gracecg, only: case_text, case_bound_t, bound_of_case, design_settings_t, manoeuvre_design_t, plan_manoeuvre, &
        map_point_t, map_case
    use c_library
    use c_checks
    implicit none
    private
    public :: collect_c_planning

contains

    subroutine collect_c_planning(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('bound', test_bound), &
                    new_unittest('design-and-map', test_design), &
                    new_unittest('design-misused', test_design_misuse)]
    end subroutine collect_c_planning

    subroutine test_bound(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(case_bound_t) :: expected
        type(error_t), allocatable :: problem
        character(:), allocatable :: text
        integer(c_intptr_t) :: handle, bound
        real(dp) :: covariance(9), direction(9)

        call take_case('front-2', case)
        call bound_of_case(case, estimation_options_t(), expected, problem)
        status = gracecg_case_open(c_string('front-2'), handle)
        call check_ok(error, gracecg_case_bound(handle, bound, failure))
        covariance = item(bound, 'covariance', 9)
        direction = item(bound, 'direction', 9)
        call check_equal(error, [covariance, item(bound, 'sigma', 3), item(bound, 'principal_sigma', 3), direction, &
                                 item(bound, 'consider_sigma', 3), item(bound, 'by_source', 15)], &
                         [[expected%covariance], expected%sigma, expected%principal_sigma, [expected%direction], &
                          expected%consider_sigma, [expected%by_source]], 'bound')
        ! the eigenvectors belong to the eigenvalues
        call check(error, norm2(matmul(reshape(covariance, [3, 3]), direction(7:)) - &
                                expected%principal_sigma(3)**2*direction(7:)) < &
                   1e-9_dp*expected%principal_sigma(3)**2, 'worst direction')
        status = gracecg_free(bound)
        call check_refused(error, NULL_POINTER, 'bound', gracecg_case_bound(handle, error=failure))
        status = gracecg_free(handle)
        call check_refused(error, BAD_HANDLE, 'case', gracecg_case_bound(handle, bound, failure))
        status = gracecg_gravity_open(c_string('point-mass'), 0, 0, handle)
        call check_refused(error, BAD_HANDLE, 'case', gracecg_case_bound(handle, bound, failure))
        status = gracecg_free(handle)
        case%satellite%rods%count = 0
        call case_text(case, text, problem)
        status = gracecg_case_open(c_string(text), handle)
        call check_refused(error, HAS_FAILED, 'rods are off', gracecg_case_bound(handle, bound, failure))
        status = gracecg_free(handle)
    end subroutine test_bound

    subroutine test_design(error)
        type(error_type), allocatable, intent(out) :: error
        type(calibration_t) :: calibration, planned_case
        type(design_settings_t) :: own_settings
        type(manoeuvre_design_t) :: expected
        type(map_point_t), allocatable :: points(:)
        type(error_t), allocatable :: problem
        integer(c_intptr_t) :: handle, planned, places
        integer(c_size_t) :: count
        integer :: i
        integer(c_int32_t) :: choices(8)
        real(dp), parameter :: TIMES(2) = [0.0_dp, 6000.0_dp]       ! the second in the second revolution
        real(dp) :: settings(9), epoch_state(13), later_state(13), sigma(6), rods(7, 3)

        status = gracecg_case_open(c_string('back-1'), handle)
        epoch_state = item(handle, 'state', 13)
        settings = item(handle, 'design_settings', 9)
        choices = nint(item(handle, 'design_choices', 8))
        call take_calibration('back-1', calibration)
        call check(error, abs(settings(2) - calibration%case%duration) <= 0 .and. &
                   abs(settings(8) - calibration%case%limits%rate) <= 0 .and. &
                   abs(settings(5) - own_settings%highest_frequency) <= 0 .and. &
                   all((choices(4:7) /= 0) .eqv. own_settings%waveform_used), 'defaults')
        settings(1:2) = [1400, 50]
        settings(4:5) = [5/50.0_dp, 6/50.0_dp]      ! few candidates
        settings(8) = 0.9_dp*settings(8)
        choices(4:) = [1, 0, 0, 0, 2]
        call check_ok(error, gracecg_design(handle, settings, choices, 1, 1, planned, failure))
        calibration%case%duration = settings(2)
        calibration%case%limits%rate = settings(8)
        own_settings%lowest_frequency = settings(4)
        own_settings%highest_frequency = settings(5)
        own_settings%waveform_used = [.true., .false., .false., .false.]
        call plan_manoeuvre(calibration, 1400.0_dp, own_settings, planned_case, expected, problem)
        call check_passes(error, problem)
        call check_equal(error, [item(planned, 'sigma', 3), item(planned, 'wave', 3), item(planned, 'force', 3), &
                                 item(planned, 'worst', 1), item(planned, 'rate', 1), item(planned, 'excursion', 1), &
                                 item(planned, 'evaluations', 1), item(planned, 'start', 1)], &
                         [expected%sigma, expected%wave, expected%force, expected%worst, expected%rate, &
                          expected%excursion, real(expected%evaluations, dp), 1400.0_dp], 'design')
        call check(error, expected%rate <= settings(8) .and. planned_case%case%name == 'back-1-design', 'limits, name')

        ! the case that flies it: later, elsewhere, with these rods
        later_state = item(planned, 'state', 13)
        call check(error, norm2(later_state(1:3) - epoch_state(1:3)) > 1e6_dp, 'at another place')
        status = gracecg_get(planned, c_string('rods'), NONE, count=count, error=failure)
        call check(error, status == OK .and. count == 21, 'number of rods')
        rods = reshape(item(planned, 'rods', 21), [7, 3])
        do i = 1, 3
            associate (rod => expected%rods%activations(i))
                call check_equal(error, [rods(1, i), rods(2, i), rods(3, i), rods(5, i)], &
                                 [rod%amplitude, rod%frequency, rod%phase, rod%stop], 'rod')
            end associate
        end do
        call check_equal(error, item(planned, 'rod_kinds', 6), [real(dp) :: 1, 1, 2, 1, 3, 1], 'axes and waveforms')
        status = gracecg_get(planned, c_string('rods'), 14_c_size_t, rods, count, failure)
        call check_refused(error, BAD_SIZE, 'there are 21')

        call check_ok(error, gracecg_map(planned, 2_c_size_t, TIMES, 2, places, failure))
        call map_case(planned_case%case, TIMES, 1, points, problem)
        call check_passes(error, problem)
        sigma = item(places, 'sigma', 6)
        call check_equal(error, [item(places, 'place', 4), sigma, item(places, 'worst', 8), item(places, 'wave', 6), &
                                 item(places, 'force', 6)], &
                         [(points(i)%latitude, points(i)%longitude, i=1, 2), (points(i)%quality%sigma, i=1, 2), &
                          (points(i)%worst_sigma, points(i)%worst_direction, i=1, 2), (points(i)%quality%wave, i=1, 2), &
                          (points(i)%quality%force, i=1, 2)], 'map')
        call check(error, maxval(abs(sigma(:3)/item(planned, 'sigma', 3) - 1)) < 1e-5_dp, 'the map at the place of the design')
        status = gracecg_free(places)
        status = gracecg_map(planned, NONE, threads=1, places=places, error=failure)
        call check(error, int(status), int(OK), 'a map of no place')
        call free(places, planned, handle)
    end subroutine test_design

    !> Every setting that is none, missing pointers, handles of another kind: refused, with no case made.
    subroutine test_design_misuse(error)
        type(error_type), allocatable, intent(out) :: error
        integer(c_intptr_t) :: handle, planned, places
        integer(c_int32_t) :: choices(8), right_choices(8)
        real(dp) :: settings(9), right(9)

        status = gracecg_case_open(c_string('front-1'), handle)
        right = item(handle, 'design_settings', 9)
        right_choices = nint(item(handle, 'design_choices', 8))
        settings = right
        choices = right_choices
        call refuse_setting(1, nan, BAD_VALUE, 'number 1 of settings')
        call refuse_setting(9, nan, BAD_VALUE, 'number 9 of settings')
        choices(8) = 0
        call refuse(BAD_VALUE, 'threads = 0')
        choices(8) = 2000
        call refuse(BAD_VALUE, 'threads = 2000')
        call refuse_setting(1, -1.0_dp, HAS_FAILED, 'time of the calibration')
        call refuse_setting(1, 1e5_dp, HAS_FAILED, 'time of the calibration')
        call refuse_setting(2, 1e9_dp, HAS_FAILED, 'duration')
        call refuse_setting(2, 0.0_dp, HAS_FAILED, 'duration')
        call refuse_setting(8, 0.0_dp, HAS_FAILED, 'limits of rate')
        call refuse_setting(3, 31.0_dp, HAS_FAILED, '30 A m^2')
        settings(5) = 6
        call refuse_setting(4, 5.9_dp, HAS_FAILED, 'half the sampling')
        call refuse_setting(4, 0.3_dp, HAS_FAILED, 'frequencies')
        choices(1:3) = 0
        call refuse(HAS_FAILED, 'rods are off')
        choices(4:7) = 0
        call refuse(HAS_FAILED, 'no waveform')
        call refuse(BAD_VALUE, 'place = 4', place=4)
        call refuse(BAD_VALUE, 'revolutions = 0', revolutions=0)
        call check_refused(error, NULL_POINTER, 'planned', gracecg_design(handle, right, right_choices, 1, 1, error=failure))
        status = gracecg_design(handle, choices=right_choices, place=1, revolutions=1, planned=planned, error=failure)
        call check_refused(error, NULL_POINTER, 'settings')
        status = gracecg_design(handle, right, place=1, revolutions=1, planned=planned, error=failure)
        call check_refused(error, NULL_POINTER, 'choices')
        call check_refused(error, NULL_POINTER, 'seconds', gracecg_map(handle, ONE, threads=1, places=places, error=failure))
        call check_refused(error, BAD_VALUE, 'seconds', gracecg_map(handle, ONE, [NAN], 1, places, failure))
        status = gracecg_map(handle, ONE, [-5.0_dp], 1, places, failure)
        call check_refused(error, HAS_FAILED, 'times of the map')
        call check_refused(error, HAS_FAILED, '150 revolutions', gracecg_map(handle, ONE, [1e9_dp], 1, places, failure))
        call check_refused(error, BAD_VALUE, 'threads', gracecg_map(handle, ONE, [0.0_dp], -1, places, failure))
        status = gracecg_map(handle, -1_c_size_t, [0.0_dp], 1, places, failure)
        call check_refused(error, BAD_SIZE, 'n is negative or too great')
        status = gracecg_free(handle)
        call refuse(BAD_HANDLE, 'case')
        call check_refused(error, BAD_HANDLE, 'case', gracecg_map(handle, ONE, [0.0_dp], 1, places, failure))

    contains

        subroutine refuse_setting(i, value, expected, part)
            integer, intent(in) :: i
            real(dp), intent(in) :: value
            integer(c_int), intent(in) :: expected
            character(*), intent(in) :: part

            settings(i) = value
            call refuse(expected, part)
        end subroutine refuse_setting

        subroutine refuse(expected, part, place, revolutions)
            integer(c_int), intent(in) :: expected
            character(*), intent(in) :: part
            integer, intent(in), optional :: place, revolutions
            integer(c_int32_t) :: where_to, turns

            where_to = 1
            if (present(place)) where_to = place
            turns = 1
            if (present(revolutions)) turns = revolutions
            planned = 77
            status = gracecg_design(handle, settings, choices, where_to, turns, planned, failure)
            call check_refused(error, expected, part)
            call check(error, planned == 0, part//': a handle after a failure')
            settings = right
            choices = right_choices
        end subroutine refuse
    end subroutine test_design_misuse
end module test_c_planning
