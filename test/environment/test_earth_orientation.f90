!> The Earth in inertial axes: published values of the IAU's routines, and the files of the IERS.
module test_earth_orientation
    use vocabulary
    use gracecg_base_constants, only: EARTH_ROTATION_RATE, SECONDS_PER_DAY
    use gracecg_base_vectors, only: rotation_z
    use gracecg_environment_time, only: utc_t, utc_plus
    use gracecg_environment_earth_orientation
    use gracecg_environment_iers_file, only: read_earth_parameters
    use c_library, only: utc_struct, gracecg_earth_parameters, gracecg_earth_orientation
    use gracecg_simulation_case, only: case_t, case_from_text, case_text, earth_orientation_name
    implicit none
    private
    public :: collect_earth_orientation

    character(*), parameter :: FIXTURES = 'test/fixtures/earth_orientation/'
    real(dp), parameter :: MAS = 1e-3_dp*ARCSECOND

contains

    subroutine collect_earth_orientation(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('published-nutation-and-precession', test_published), &
                    new_unittest('published-matrix', test_matrix), &
                    new_unittest('a-day-later', test_day), &
                    new_unittest('by-the-angle-alone', test_report), &
                    new_unittest('files-of-the-iers', test_files), &
                    new_unittest('through-a-leap-second', test_leap_second), &
                    new_unittest('corrupted-files', test_corrupted), &
                    new_unittest('setting-of-a-case', test_case), &
                    new_unittest('through-c', test_c)]
    end subroutine collect_earth_orientation

    !> Check values of SOFA (t_sofa_c: NUT00B, PFW06, ERA00, GMST06), as ERFA publishes them.
    subroutine test_published(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: t, longitude, obliquity, gamma, phi, psi, epsilon_a

        t = (53736.0_dp - 51544.5_dp)/36525
        call nutation_2000b(t, longitude, obliquity)
        call check(error, abs(longitude + 0.9632552291148362783e-5_dp) < 1e-13_dp .and. &
                   abs(obliquity - 0.4063197106621159367e-4_dp) < 1e-13_dp, 'NUT00B')
        call check(error, modulo(earth_rotation_angle(utc_t(53736, 0.0_dp), 0.0_dp) + &
                                 sidereal_minus_rotation_angle(t, 0.0_dp, 0.0_dp), 8*atan(1.0_dp)), &
                   1.754174971870091203_dp, thr=2e-8_dp)     ! the complementary terms are not in GMST
        call check(error, earth_rotation_angle(utc_t(54388, 0.0_dp), 0.0_dp), 0.4022837240028158102_dp, thr=1e-12_dp)
        t = (50123.9999_dp - 51544.5_dp)/36525
        call precession_2006(t, gamma, phi, psi, epsilon_a)
        call check(error, abs(gamma + 0.2243387670997995690e-5_dp) < 1e-16_dp .and. &
                   abs(phi - 0.4091014602391312808_dp) < 1e-12_dp .and. &
                   abs(psi + 0.9501954178013031895e-3_dp) < 1e-14_dp .and. &
                   abs(epsilon_a - 0.4091014316587367491_dp) < 1e-12_dp, 'PFW06')
    end subroutine test_published

    !> C2T06A of SOFA: IAU 2006/2000A, 2006-01-01 TT and UT1, with polar motion. 2000B and what is left out: 2 mas.
    subroutine test_matrix(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: ROWS(3, 2) = reshape([ &
            -0.1810332128305897282_dp, 0.9834769806938592296_dp, 0.6555550962998436505e-4_dp, &
            -0.9834768134136214897_dp, -0.1810332203649130832_dp, 0.5749800844905594110e-3_dp], [3, 2])
        real(dp), parameter :: TT_MINUS_UTC = 64.184_dp     ! s, on 2005-12-31
        type(earth_orientation_t) :: earth
        real(dp) :: c(3, 3)

        earth = iau_orientation(utc_t(53735, SECONDS_PER_DAY - TT_MINUS_UTC), &
                                earth_parameters_t(TT_MINUS_UTC, 0.0_dp, [2.55060238e-7_dp, 1.860359247e-6_dp]))
        c = earth%from_inertial(0.0_dp)
        call check(error, maxval(abs(transpose(c(:2, :)) - ROWS)) < 2*MAS)
        call check(error, maxval(abs(matmul(c, transpose(c)) - identity(3))) < 1e-14_dp)
        call check(error, abs(norm2(earth%axis()) - 1) < 1e-14_dp .and. norm2(matmul(c, earth%axis()) - &
                                                                              [0.0_dp, 0.0_dp, 1.0_dp]) < 2e-6_dp)
    end subroutine test_matrix

    !> The constants of an arc's beginning hold for a day: 10 mas are 0.3 m.
    subroutine test_day(error)
        type(error_type), allocatable, intent(out) :: error
        type(earth_orientation_t) :: early, late
        type(earth_parameters_t) :: parameters
        type(utc_t) :: epoch
        real(dp) :: t
        integer :: i

        parameters%ut1_minus_utc = 0.1_dp
        do i = 0, 20
            epoch = utc_plus(utc_t(51544, 0.0_dp), i*86400*500.3_dp)
            t = 86400*i/20.0_dp
            early = iau_orientation(epoch, parameters)
            late = iau_orientation(utc_plus(epoch, t), parameters)
            call check(error, maxval(abs(early%from_inertial(t) - late%from_inertial(0.0_dp))) < 10*MAS)
        end do
    end subroutine test_day

    !> Eq. (2-4), to the bit.
    subroutine test_report(error)
        type(error_type), allocatable, intent(out) :: error
        type(earth_orientation_t) :: earth
        type(error_t), allocatable :: failure

        call new_earth_orientation('report', utc_t(47528, 0.0_dp), 1.7_dp, earth_parameters_t(), earth, failure)
        call check(error, .not. any(abs(earth%from_inertial(60.0_dp) - rotation_z(1.7_dp + EARTH_ROTATION_RATE*60)) > 0))
        call new_earth_orientation('ptolemy', utc_t(47528, 0.0_dp), 1.7_dp, earth_parameters_t(), earth, failure)
        call check_fails(error, failure, 'ptolemy ... report, iau')
    end subroutine test_report

    !> The three formats, of the same days; rows of finals2000A and of series 20 are the published ones.
    subroutine test_files(error)
        type(error_type), allocatable, intent(out) :: error
        character(20), parameter :: FILES(3) = [character(20) :: 'finals2000A.txt', 'eopc04_14.txt', 'eopc04_20.txt']
        real(dp), parameter :: X(3) = [0.105059_dp, 0.105015_dp, 0.105015_dp], Y(3) = [0.389084_dp, 0.389153_dp, 0.389153_dp]
        real(dp), parameter :: UT1(3) = [0.0672036_dp, 0.0672285_dp, 0.0672285_dp]
        type(earth_parameters_t) :: parameters, noon
        type(error_t), allocatable :: failure
        integer :: i

        do i = 1, size(FILES)
            call read_earth_parameters(FIXTURES//trim(FILES(i)), utc_t(61100, 0.0_dp), parameters, failure)
            if (failed(error, failure)) return
            call check(error, abs(parameters%ut1_minus_utc - UT1(i)) < 1e-12_dp .and. &
                       all(abs(parameters%pole/ARCSECOND - [X(i), Y(i)]) < 1e-12_dp), FILES(i))
            call read_earth_parameters(FIXTURES//trim(FILES(i)), utc_t(61099, 43200.0_dp), noon, failure)
            call read_earth_parameters(FIXTURES//trim(FILES(i)), utc_t(61099, 0.0_dp), parameters, failure)
            call check(error, noon%ut1_minus_utc, parameters%ut1_minus_utc + 43200*noon%ut1_rate, thr=1e-12_dp)
        end do
        call read_earth_parameters(FIXTURES//'finals2000A.txt', utc_t(61103, 0.0_dp), parameters, failure)
        call check_fails(error, failure, 'finals2000A.txt ... 2026-03-04 ... 2026-02-27 to 2026-03-03')
    end subroutine test_files

    !> UT1 goes on where UTC jumps: 2016-12-31 has 86401 s.
    subroutine test_leap_second(error)
        type(error_type), allocatable, intent(out) :: error
        type(earth_parameters_t) :: parameters
        type(error_t), allocatable :: failure

        call read_earth_parameters(FIXTURES//'finals2000A_leap.txt', utc_t(57753, 43200.0_dp), parameters, failure)
        if (failed(error, failure)) return
        call check(error, parameters%ut1_minus_utc, (-0.4077601_dp + 0.5912821_dp - 1)/2, thr=1e-12_dp)
    end subroutine test_leap_second

    !> Each with a word that its message must hold.
    subroutine test_corrupted(error)
        type(error_type), allocatable, intent(out) :: error
        character(34), parameter :: BAD(2, 6) = reshape([character(34) :: &
            'missing.txt', 'no such file', &
            'empty.txt', 'no row of finals2000A or EOP C04', &
            'finals2000A_number.txt', 'txt:1: y of pole: "0.38x940"', &
            'finals2000A_order.txt', 'txt:3: the days must rise', &
            'eopc04_20_ut1.txt', 'txt:9: UT1-UTC: 9.0672285 is', &
            'eopc04_20_text.txt', 'txt:9: is no row of'], [2, 6])
        type(earth_parameters_t) :: parameters
        type(error_t), allocatable :: failure
        integer :: i

        do i = 1, size(BAD, 2)
            call read_earth_parameters(FIXTURES//trim(BAD(1, i)), utc_t(61101, 0.0_dp), parameters, failure)
            call check_fails(error, failure, joined(BAD(:, i)))
        end do
    end subroutine test_corrupted

    !> By date; what contradicts itself is refused; a file's values are those of the epoch, and a written case is the same.
    subroutine test_case(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case, again
        type(error_t), allocatable :: failure
        character(:), allocatable :: text

        call make_case('1999-12-31', '', case, failure)
        call check(error, message_of(failure) == '' .and. earth_orientation_name(case) == 'report', 'before 2000')
        call make_case('2000-01-01', '', case, failure)
        call check(error, message_of(failure) == '' .and. earth_orientation_name(case) == 'iau', 'from 2000 on')
        call make_case('2026-03-01', "rotation = 'given'", case, failure)
        call check(error, message_of(failure) == '' .and. earth_orientation_name(case) == 'report', 'angle that is given')
        call make_case('2026-03-01', "earth_orientation_file = '"//FIXTURES//"finals2000A.txt'", case, failure)
        if (failed(error, failure)) return
        call check(error, case%earth_parameters%ut1_minus_utc, 0.0672036_dp, thr=1e-12_dp)
        call case_text(case, text, failure)
        call case_from_text(text, 'written', again, failure)
        call check(error, message_of(failure) == '' .and. .not. any(abs(again%earth_parameters%pole - &
                                                                        case%earth_parameters%pole) > 0), 'written')
        call make_case('2026-03-01', "rotation = 'given', earth_orientation = 'iau'", case, failure)
        call check_fails(error, failure, 'earth_orientation ... rotation = ''given''')
        call make_case('1989-03-01', "earth_orientation_file = 'x'", case, failure)
        call check_fails(error, failure, 'earth_orientation_file ... not used')
        call make_case('2026-03-01', "ut1_minus_utc = 0.1, earth_orientation_file = 'x'", case, failure)
        call check_fails(error, failure, 'ut1_minus_utc ... leave one')
    end subroutine test_case

    !> The C entries give the same, a row of the matrix after the other, and refuse what is no angle.
    subroutine test_c(error)
        type(error_type), allocatable, intent(out) :: error
        type(earth_orientation_t) :: earth
        real(dp) :: rows(3, 3), ut1, pole(2)
        type(utc_struct) :: epoch

        epoch = utc_struct(61100, 0.0_dp)
        call check(error, gracecg_earth_parameters(FIXTURES//'eopc04_20.txt'//achar(0), epoch, ut1, pole) == 0)
        call check(error, gracecg_earth_orientation(epoch, ut1, pole, 600.0_dp, rows) == 0)
        earth = iau_orientation(utc_t(61100, 0.0_dp), earth_parameters_t(ut1, 0.0_dp, pole))
        call check(error, maxval(abs(transpose(rows) - earth%from_inertial(600.0_dp))) < 1e-15_dp)
        ! As far as it goes UT1-UTC may be held, on the longest day there was: to 1 m on the equator.
        call check(error, gracecg_earth_orientation(epoch, ut1, pole, 43200.0_dp, rows) == 0)
        earth = iau_orientation(utc_t(61100, 43200.0_dp), earth_parameters_t(ut1 - 2e-3_dp, 0.0_dp, pole))
        call check(error, maxval(abs(transpose(rows) - earth%from_inertial(0.0_dp)))*6378137 < 1)
        call check(error, gracecg_earth_orientation(epoch, 3.0_dp, pole, 0.0_dp, rows) /= 0 .and. &
                   gracecg_earth_orientation(epoch, 0.0_dp, [1.0_dp, 0.0_dp], 0.0_dp, rows) /= 0 .and. &
                   gracecg_earth_orientation(epoch, 0.0_dp, pole, 0.0_dp) /= 0 .and. &
                   gracecg_earth_orientation(epoch, ut1, pole, 86400.0_dp, rows) /= 0 .and. &
                   gracecg_earth_parameters(utc=epoch) /= 0)
    end subroutine test_c

    subroutine make_case(date, earth, case, failure)
        character(*), intent(in) :: date
        character(*), intent(in) :: earth       !! Lines of its group earth
        type(case_t), intent(out) :: case
        type(error_t), allocatable, intent(out) :: failure
        character(1), parameter :: NEW_LINE_ = achar(10)

        call case_from_text("&calibration name = 'x', epoch = '"//date//"T00:00:00', duration = 60 /"//NEW_LINE_// &
                            '&mass_properties mass = 420, moments_of_inertia = 80, 400, 430, '// &
                            'products_of_inertia = 0, 0, 0 /'//NEW_LINE_// &
                            '&truth position = 6.9e6, 0, 0, velocity = 0, 0, 7600, quaternion = 0, 0, 0, 1, '// &
                            'angular_velocity = 0, 0.0011, 0 /'//NEW_LINE_//'&earth '//earth//' /'//NEW_LINE_, 'text', &
                            case, failure)
    end subroutine make_case
end module test_earth_orientation
