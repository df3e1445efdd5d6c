!> The report's six cases: consistent in themselves and with what the report says of them.
module test_report_cases
    use vocabulary
    use calibrations
    use gracecg_base_constants, only: EARTH_ROTATION_RATE
    use gracecg_base_vectors, only: rotation_z
    use gracecg_environment_time, only: seconds_between, gmst_1982
    use gracecg_environment_earth_shape, only: earth_fixed_to_geodetic
    use gracecg_spacecraft_rod_pattern, only: rod_pattern
    use gracecg_spacecraft_torque_rods, only: dipole_moment
    use gracecg_estimation_report_options, only: report_options
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, loads_t, POSITION, VELOCITY
    use gracecg_simulation_case, only: read_case, case_text
    use gracecg_simulation_case_models, only: build_dynamics, initial_state
    use gracecg_simulation_report_cases, only: report_case, PRINTED_CASE_NAMES, published_name, find_case, &
        is_built_in, expanded_cases
    use gracecg_files_file, only: remove_file
    implicit none
    private
    public :: collect_report_cases

contains

    subroutine collect_report_cases(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('names', test_names), &
                    new_unittest('unit-quaternions', test_quaternions), &
                    new_unittest('rods-follow-the-rule', test_rods), &
                    new_unittest('places', test_places), &
                    new_unittest('sidereal-angles', test_sidereal_angles), &
                    new_unittest('pair', test_pair), &
                    new_unittest('written-and-read', test_round_trip), &
                    new_unittest('cards-as-printed', test_printed)]
    end subroutine collect_report_cases

    subroutine test_names(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(error_t), allocatable :: failure
        integer :: i

        do i = 1, 6
            call take_case(REPORT_CASE_NAMES(i), case)
            call check(error, case%name == REPORT_CASE_NAMES(i) .and. &
                       case%satellite%name == merge('front', 'back ', i <= 3) .and. &
                       case%number == mod(i - 1, 3) + 1)
        end do
        call report_case('front-4', case, failure)
        call check_fails(error, failure, 'front-4')
    end subroutine test_names

    !> The cards RADPR, EM and the models' own density and wind, from the pages of section 5.2; the rest, above
    !> all state and manoeuvre, is that of the case of the same number.
    subroutine test_printed(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: printed, case
        type(string_t), allocatable :: names(:)
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, other
        integer :: i

        do i = 1, 6
            call find_case(PRINTED_CASE_NAMES(i), printed, failure)
            if (failed(error, failure)) return
            call check(error, printed%satellite%reflectivity_sun == 0.45_dp .and. printed%density_scale == 1 .and. &
                       printed%wind_model == 'hwm93' .and. printed%earth_radiation_constants == 'report' .and. &
                       printed%satellite%drag_coefficient == 2 .and. printed%satellite%reflectivity_earth == 0.5_dp, &
                       PRINTED_CASE_NAMES(i))
            call check(error, is_built_in(PRINTED_CASE_NAMES(i)) .and. &
                       published_name(PRINTED_CASE_NAMES(i)) == REPORT_CASE_NAMES(i))
            call take_case(REPORT_CASE_NAMES(i), case)
            case%name = printed%name
            case%satellite%reflectivity_sun = 0.45_dp
            case%density_scale = 1
            case%wind_model = 'hwm93'
            case%wind_east = 0
            case%earth_radiation_constants = 'report'
            call case_text(case, other, failure)
            if (.not. allocated(failure)) call case_text(printed, text, failure)
            call check_passes(error, failure)
            call check(error, text == other, 'nothing else differs')
        end do
        call expanded_cases([string_t('back-1'), string_t('printed'), string_t('x.nml')], names)
        if (unmet(error, size(names) == 8 .and. names(2)%text == 'front-1-printed' .and. &
                  names(7)%text == 'back-3-printed' .and. names(8)%text == 'x.nml')) return
        call find_case('front-1-print', printed, failure)
        call check_fails(error, failure, 'front-1-printed')
        call find_case('', printed, failure)
        call check_fails(error, failure, 'name of the case is empty')
    end subroutine test_printed

    subroutine test_quaternions(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(estimation_options_t) :: options
        integer :: i

        do i = 1, 6
            call take_case(REPORT_CASE_NAMES(i), case)
            options = report_options(REPORT_CASE_NAMES(i))
            call check(error, norm2(case%quaternion), 1.0_dp, thr=1e-15_dp)
            call check(error, norm2(options%guess_quaternion), 1.0_dp, thr=1e-15_dp)
            ! the guess is one of the true attitude: within some degrees
            call check(error, dot_product(case%quaternion, options%guess_quaternion) > &
                       cos(3*DEGREE/2))
        end do
    end subroutine test_quaternions

    !> The signs printed for the rods are those of section 4.2 for the field where the case begins.
    subroutine test_rods(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(satellite_dynamics_t) :: dynamics
        type(loads_t) :: acting
        type(error_t), allocatable :: failure
        integer :: pattern(3), i

        do i = 1, 6
            call take_case(REPORT_CASE_NAMES(i), case)
            call build_dynamics(case, dynamics, failure)
            if (failed(error, failure)) return
            call dynamics%loads(0.0_dp, initial_state(case), acting)
            pattern = rod_pattern('y-z', acting%field)
            associate (moment => dipole_moment(case%satellite%rods, 2.5_dp))
                call check(error, min(maxval(abs(moment - 30*pattern)), &
                                      maxval(abs(moment + 30*pattern))), 0.0_dp, &
                           REPORT_CASE_NAMES(i), thr=1e-13_dp)
            end associate
        end do
    end subroutine test_rods

    !> Of the front satellite: 101 W 0 N, 107 W 89 N, 67 E 10 N, printed in whole degrees; (2-4), (2-28).
    subroutine test_places(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: LONGITUDE(3) = [-101.0_dp, -107.0_dp, 67.0_dp]
        real(dp), parameter :: LATITUDE(3) = [0.0_dp, 89.0_dp, 10.0_dp]
        type(case_t) :: case
        real(dp) :: lon, lat, height
        integer :: i

        do i = 1, 3
            call take_case(REPORT_CASE_NAMES(i), case)
            call earth_fixed_to_geodetic(matmul(rotation_z(case%sidereal_angle), case%position), &
                                         lat, lon, height)
            call check(error, lon/DEGREE, LONGITUDE(i), thr=1.0_dp)
            call check(error, lat/DEGREE, LATITUDE(i), thr=1.0_dp)
            call check(error, height > 440e3_dp .and. height < 490e3_dp)
        end do
    end subroutine test_places

    !> The printed angle of case 1 is Greenwich mean sidereal time with the UT1 - UTC of that day,
    !> -0.117 s; it runs on at the Earth's rate.
    subroutine test_sidereal_angles(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: first, case
        real(dp) :: angle
        integer :: i

        call take_case('front-1', first)
        angle = gmst_1982(first%epoch, -0.1174_dp)
        call check(error, modulo(angle - first%sidereal_angle + 180*DEGREE, 360*DEGREE), &
                   180*DEGREE, &
                   thr=1e-6_dp*DEGREE)
        do i = 1, 6
            call take_case(REPORT_CASE_NAMES(i), case)
            call check(error, case%sidereal_angle - first%sidereal_angle, EARTH_ROTATION_RATE* &
                       seconds_between(first%epoch, case%epoch), thr=1e-14_dp)
        end do
    end subroutine test_sidereal_angles

    !> The satellites fly 220 km apart within 50 km, in opposite attitudes, at nearly one speed.
    subroutine test_pair(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: front, back
        integer :: i

        do i = 1, 3
            call take_case(REPORT_CASE_NAMES(i), front)
            call take_case(REPORT_CASE_NAMES(i + 3), back)
            call check(error, norm2(front%position - back%position), 220e3_dp, thr=50e3_dp)
            call check(error, norm2(front%velocity), norm2(back%velocity), thr=10.0_dp)
            call check(error, front%angular_velocity(2), -back%angular_velocity(2), thr=1e-7_dp)
            ! half a turn about the vertical, and the angle between the verticals
            call check(error, abs(dot_product(front%quaternion, back%quaternion)) < 0.05_dp)
        end do
    end subroutine test_pair

    !> Every case as a file and back: the same text again, and the same numbers to the last digit
    !> where the file has no unit of its own.
    subroutine test_round_trip(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case, again
        type(error_t), allocatable :: failure
        character(:), allocatable :: text, text_again
        integer :: i

        do i = 1, 6
            call take_case(REPORT_CASE_NAMES(i), case)
            call case_text(case, text, failure)
            if (failed(error, failure)) return
            call make_file('case.nml', text)
            call read_case(FOLDER//'case.nml', again, failure)
            if (failed(error, failure)) return
            call check_same(case, again)
            again%quaternion = case%quaternion      ! normalised again: another last digit
            call case_text(again, text_again, failure)
            call check(error, text_again == text, 'the text of '//REPORT_CASE_NAMES(i)//' changes')
        end do
        call remove_file(FOLDER//'case.nml')

    contains

        subroutine check_same(a, b)
            type(case_t), intent(in) :: a, b
            real(dp) :: difference

            call check(error, a%name == b%name .and. a%satellite%name == b%satellite%name .and. &
                       a%number == b%number .and. a%wind_model == b%wind_model .and. &
                       a%earth_radiation_constants == b%earth_radiation_constants .and. &
                       (a%density_wave_random .eqv. b%density_wave_random))
            call check(error, seconds_between(a%epoch, b%epoch), 0.0_dp)
            difference = maxval(abs(a%position - b%position)) + &
                                maxval(abs(a%velocity - b%velocity)) + &
                         maxval(abs(a%angular_velocity - b%angular_velocity)) + &
                         maxval(abs(a%satellite%inertia - b%satellite%inertia)) + &
                         maxval(abs(a%satellite%centre_of_mass - b%satellite%centre_of_mass)) + &
                         maxval(abs(a%satellite%accelerometer%scale3 - b%satellite%accelerometer%scale3)) + &
                         maxval(abs(a%satellite%accelerometer%noise%level - b%satellite%accelerometer%noise%level)) + &
                         maxval(abs(dipole_moment(a%satellite%rods, 1.3_dp) - &
                                dipole_moment(b%satellite%rods, 1.3_dp)))
            call check(error, difference, 0.0_dp)
            call check(error, maxval(abs(a%quaternion - b%quaternion)), 0.0_dp, thr=4e-16_dp)
            call check(error, maxval(abs(a%satellite%offset - b%satellite%offset)), 0.0_dp, thr=1e-18_dp)
            call check(error, maxval(abs(a%satellite%magnetometer%bias - b%satellite%magnetometer%bias)), 0.0_dp, &
                       thr=1e-22_dp)
            call check(error, a%sidereal_angle, b%sidereal_angle, thr=2e-14_dp)
        end subroutine check_same
    end subroutine test_round_trip
end module test_report_cases
