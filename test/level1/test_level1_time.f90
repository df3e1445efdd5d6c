!> Time and frames of Level-1 data: identities, and official files where they are at hand.
module test_level1_time
    use vocabulary
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_of_matrix, quaternion_from_axis_angle, &
        rotation_angle_between, conjugate_quaternion, quaternion_product
    use gracecg_environment_time, only: utc_t, utc_text, parse_utc, utc_of_gps
    use gracecg_files_file, only: file_exists
    use gracecg_level1_frames
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_time
    implicit none
    private
    public :: collect_level1_time

    character(1), parameter :: LF = achar(10)
    character(*), parameter :: HEAD = 'header:'//LF//'# End of YAML header'//LF
    character(*), parameter :: SAMPLES = '..'//'/shared/level1/samples/', DAY = '_2023-06-01_C_04.txt'

contains

    subroutine collect_level1_time(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('utc', test_utc), &
                    new_unittest('clock', test_clock), &
                    new_unittest('clock-refused', test_clock_refused), &
                    new_unittest('there-and-back', test_inverse), &
                    new_unittest('official-tags', test_tags), &
                    new_unittest('accelerometer-axes', test_axes), &
                    new_unittest('heads', test_heads), &
                    new_unittest('history', test_history), &
                    new_unittest('triads', test_triads), &
                    new_unittest('official-states', test_states)]
    end subroutine collect_level1_time

    !> GPS dates and UTC around the leap seconds of the GRACE years.
    subroutine test_utc(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, utc_text(utc_of_gps(0_i8, 0.0_dp)), '2000-01-01T11:59:47')
        call check(error, gps_date_text(738849600_i8, 0.0_dp), '2023-06-01T00:00:00.000000')
        call check(error, utc_text(utc_of_gps(738849600_i8, 0.5_dp)), '2023-05-31T23:59:42.5')
        call check(error, gps_date_text(116769599_i8, 0.9999999_dp), '2003-09-14T00:00:00.000000')
        call check(error, utc_text(utc_of_gps(116769600_i8, 0.0_dp)), '2003-09-13T23:59:47')
        ! 2006-01-01 0 h UTC is 14 s earlier in GPS than its calendar date, and the leap second before it exists.
        call check(error, utc_text(utc_of_gps(189345613_i8, 0.25_dp)), '2005-12-31T23:59:60.25')
        call check(error, utc_text(utc_of_gps(189345614_i8, 0.0_dp)), '2006-01-01T00:00:00')
    end subroutine test_utc

    !> A clock of two files: records of CLK1B every 10 s, of TIM1B every 8 s.
    subroutine make_clock(error, clock)
        type(error_type), allocatable, intent(inout) :: error
        type(level1_clock_t), intent(out) :: clock
        type(level1_records_t) :: clk1b, tim1b
        type(error_t), allocatable :: failure

        call make_file('CLK1B_2020-02-01_C_04.txt', HEAD// &
                       '633798000 C -1 -0.5 0 0 0 00000010'//LF//'633798000 C -1 -0.0625 0 -1e-6 0 00000000'//LF// &
                       '633798010 C -1 -0.125 0 1e-6 0 00000000'//LF//'633798020 C -1 -0.03125 0 0 0 00000000'//LF)
        call make_file('TIM1B_2020-02-01_C_04.txt', HEAD// &
                           '633798000 C 0 633798000 0 -1 -1 00000100'//LF// &
                           '633798008 C 0 633798008 800000000 -1 -1 00000100'//LF// &
                           '633798016 C 0 633798015 200000000 -1 -1 00000100'//LF)
        call read_level1(FOLDER//'CLK1B_2020-02-01_C_04.txt', clk1b, failure)
        if (.not. allocated(failure)) call read_level1(FOLDER//'TIM1B_2020-02-01_C_04.txt', tim1b, failure)
        if (.not. allocated(failure)) call new_level1_clock(clock, failure, clk1b, tim1b)
        call check_passes(error, failure)
    end subroutine make_clock

    subroutine check_time(error, seconds, fraction, expected)
        type(error_type), allocatable, intent(inout) :: error
        integer(i8), intent(in) :: seconds
        real(dp), intent(in) :: fraction, expected      !! s past 633798000

        call check(error, real(seconds - 633798000, dp) + fraction, expected, thr=1e-12_dp)
    end subroutine check_time

    !> The last record of the clock at or before the receiver time, the later of two at one time; TIM1B linear.
    subroutine test_clock(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_clock_t) :: clock
        integer(i8) :: seconds
        real(dp) :: fraction

        call make_clock(error, clock)
        if (allocated(error)) return
        seconds = 633798002
        fraction = 0.5_dp
        call clock%receiver_time(seconds, fraction)
        call check_time(error, seconds, fraction, 2.75_dp)      ! 2.5/8 of the way to +0.8 s
        seconds = 633798002
        fraction = 0.5_dp
        call clock%gps_time(seconds, fraction)
        call check_time(error, seconds, fraction, 2.75_dp - 0.0625_dp - 2.75e-6_dp)
        call check(error, fraction >= 0 .and. fraction < 1)
        seconds = 633798010        ! receiver time 10.4: the second record
        fraction = 0
        call clock%gps_time(seconds, fraction)
        call check_time(error, seconds, fraction, 10.4_dp - 0.125_dp + 0.4e-6_dp)
        seconds = 633797990        ! before all records: the first of the offsets, the first record
        fraction = 0
        call clock%gps_time(seconds, fraction)
        call check_time(error, seconds, fraction, -10 - 0.0625_dp + 1e-5_dp)
        call check(error, clock%is_extrapolated(633797990_i8))
        call check(error, .not. clock%is_extrapolated(633798025_i8))
        call check(error, clock%is_extrapolated(633798051_i8))
    end subroutine test_clock

    subroutine test_clock_refused(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_clock_t) :: clock
        type(level1_records_t) :: clk1b, tim1b
        type(error_t), allocatable :: failure

        call make_file('CLK1B_2020-02-01_C_04.txt', HEAD)
        call read_level1(FOLDER//'CLK1B_2020-02-01_C_04.txt', clk1b, failure)
        call new_level1_clock(clock, failure, clk1b)
        call check_fails(error, failure, 'CLK1B_2020-02-01_C_04.txt ... has no record')
        call make_file('CLK1B_2020-02-01_C_04.txt', HEAD//'633798000 C -1 0.1 0 0 0 00000000'//LF// &
                           '633798010 C -1 nan 0 0 0 00000000'//LF)
        call read_level1(FOLDER//'CLK1B_2020-02-01_C_04.txt', clk1b, failure)
        call new_level1_clock(clock, failure, clk1b)
        call check_fails(error, failure, 'eps_time ... record 2')
        call make_file('CLK1B_2020-02-01_C_04.txt', HEAD//'633798000 C -1 0.1 0 0 0 00000000'//LF)
        call make_file('TIM1B_2020-02-01_C_04.txt', HEAD//'633798000 C 0 633798005 0 -1 -1 00000100'//LF)
        call read_level1(FOLDER//'CLK1B_2020-02-01_C_04.txt', clk1b, failure)
        call read_level1(FOLDER//'TIM1B_2020-02-01_C_04.txt', tim1b, failure)
        call new_level1_clock(clock, failure, clk1b, tim1b)
        call check_fails(error, failure, 'differ by more than 1 s')
    end subroutine test_clock_refused

    !> The inverse of the chain.
    subroutine test_inverse(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_clock_t) :: clock
        integer(i8) :: seconds
        real(dp) :: fraction
        integer :: i

        call make_clock(error, clock)
        do i = 1, 7
            seconds = 633798000 + i
            fraction = 0.12345_dp
            call clock%obc_time(seconds, fraction)
            call check(error, fraction >= 0 .and. fraction < 1)
            call clock%gps_time(seconds, fraction)
            call check(error, real(seconds - 633798000, dp) + fraction, i + 0.12345_dp, thr=1e-4_dp)
        end do
    end subroutine test_inverse

    !> Tags of 1A files taken to GPS time are those of 1B, to the rounding of both (0.7 us: 0.5 of the microsecond,
    !> 0.12 of TIM1B's last digit).
    subroutine test_tags(error)
        type(error_type), allocatable, intent(out) :: error
        character(3), parameter :: PRODUCTS(3) = ['MAG', 'TNK', 'IMU']
        type(level1_records_t) :: clk1b, tim1b, a, b
        type(level1_clock_t) :: clock
        type(error_t), allocatable :: failure
        integer :: i, k, extrapolated, compared

        if (.not. file_exists(SAMPLES//'CLK1B'//DAY)) then
            call skip_test(error, 'no official files at '//SAMPLES)
            return
        end if
        call read_level1(SAMPLES//'CLK1B'//DAY, clk1b, failure)
        call read_level1(SAMPLES//'TIM1B'//DAY, tim1b, failure)
        call new_level1_clock(clock, failure, clk1b, tim1b)
        call check_passes(error, failure)
        do i = 1, size(PRODUCTS)
            call read_level1(SAMPLES//PRODUCTS(i)//'1A'//DAY, a, failure)
            call read_level1(SAMPLES//PRODUCTS(i)//'1B'//DAY, b, failure)
            call to_gps_time(a, clock, extrapolated)
            call check(error, extrapolated, 0, PRODUCTS(i))
            compared = 0
            do k = 1, a%count
                compared = compared + count(abs(real(a%seconds(k) - b%seconds, dp) + (a%fraction(k) - b%fraction)) < 7e-7_dp)
            end do
            call check(error, compared >= 97, PRODUCTS(i))
        end do
    end subroutine test_tags

    subroutine test_axes(error)
        type(error_type), allocatable, intent(out) :: error

        ! ACC1A of GRACE-C, 2023-06-01, against ACT1B of the same second
        real(dp), parameter :: AF(3) = [-1.065e-5_dp, -1.83e-7_dp, -2.78e-7_dp]

        call check(error, all(abs(srf_of_accelerometer(AF, ACCELEROMETER_AXES) - [-2.78e-7_dp, -1.065e-5_dp, -1.83e-7_dp]) <= 0))
        call check(error, all(abs(srf_of_accelerometer([1.0_dp, 2.0_dp, 3.0_dp], [-2, 1, 3]) - [-2, 1, 3]) <= 0))
        call check(error, signed_axes_valid([3, -1, 2]) .and. .not. signed_axes_valid([1, 1, 2]) &
                                               .and. .not. signed_axes_valid([0, 1, 2]))
    end subroutine test_axes

    !> A head that looks elsewhere: its attitude and its mounting give the satellite's attitude.
    subroutine test_heads(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: satellite(4), mounting(4), head(4), q(4, 3)

        satellite = quaternion_from_axis_angle([0.6_dp, 0.0_dp, 0.8_dp], 1.1_dp)
        mounting = quaternion_from_axis_angle([0.0_dp, 0.8_dp, -0.6_dp], 2.3_dp)     ! head to SRF
        head = quaternion_product(conjugate_quaternion(mounting), satellite)
        call check(error, rotation_angle_between(attitude_by_head(mounting, head), satellite), 0.0_dp, thr=1e-14_dp)
        ! Scalar first as in the files: the matrix takes inertial into body coordinates.
        q(:, 1) = gracecg_quaternion([cos(0.25_dp), 0.0_dp, 0.0_dp, sin(0.25_dp)])
        call check(error, norm2(matmul(rotation_matrix(q(:, 1)), [cos(0.5_dp), sin(0.5_dp), 0.0_dp]) - [1, 0, 0]), 0.0_dp, &
                   thr=1e-15_dp)
        q(:, 2) = -q(:, 1)
        q(:, 3) = q(:, 1)
        call continuous_quaternions(q)
        call check(error, all(abs(q(:, 2:3) - spread(q(:, 1), 2, 2)) <= 0))
    end subroutine test_heads

    !> Of a calibration history the last record at or before the time holds, of equal times the later line.
    subroutine test_history(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: qsa1b, vcm1b
        type(error_t), allocatable :: failure
        real(dp) :: q(4)

        call make_file('QSA1B_2018-05-22_C_04.txt', HEAD// &
                       '0 C 1 1 0 0 0 0 00000000'//LF//'0 C 2 0 1 0 0 0 00000000'//LF// &
                       '100 C 1 0 0 1 0 0 00000000'//LF//'100 C 1 0 0 0 1 0 00000000'//LF)
        call make_file('VCM1B_2020-02-01_C_04.txt', HEAD//'0 C 2e-3 0 0.6 0.8 00000000'//LF// &
                           '50 C 1e-3 1 0 0 00000000'//LF)
        call read_level1(FOLDER//'QSA1B_2018-05-22_C_04.txt', qsa1b, failure)
        if (failed(error, failure)) return
        q = mounting_of_head(qsa1b, 1, 99_i8)
        call check(error, q(4), 1.0_dp)
        q = mounting_of_head(qsa1b, 1, 100_i8)
        call check(error, q(3), 1.0_dp)
        q = mounting_of_head(qsa1b, 2, 1000_i8)
        call check(error, q(1), 1.0_dp)
        q = mounting_of_head(qsa1b, 3, 1000_i8)
        call check(error, norm2(q), 0.0_dp)
        call read_level1(FOLDER//'VCM1B_2020-02-01_C_04.txt', vcm1b, failure)
        call check(error, norm2(calibration_vector(vcm1b, 49_i8) - [0.0_dp, 1.2e-3_dp, 1.6e-3_dp]), 0.0_dp, thr=1e-18_dp)
        call check(error, norm2(calibration_vector(vcm1b, 50_i8) - [1e-3_dp, 0.0_dp, 0.0_dp]), 0.0_dp, thr=1e-18_dp)
    end subroutine test_history

    !> One state in both frames gives their rotation back; precession and sidereal time are a rotation, at J2000
    !> about z alone.
    subroutine test_triads(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: R(3) = [-2130715.0_dp, 215306.0_dp, -6542029.0_dp], V(3) = [7121.7_dp, -1163.1_dp, -2364.4_dp]
        real(dp) :: c(3, 3), fixed_r(3), fixed_v(3)
        type(utc_t) :: utc
        type(error_t), allocatable :: failure

        c = rotation_matrix(quaternion_from_axis_angle([0.36_dp, 0.48_dp, 0.8_dp], 1.2_dp))     ! fixed to inertial
        fixed_r = matmul(transpose(c), R)
        fixed_v = matmul(transpose(c), V) - cross([0.0_dp, 0.0_dp, 7.292115e-5_dp], fixed_r)
        call check(error, norm2(inertial_of_earth_fixed_by_states(R, V, fixed_r, fixed_v) - c), 0.0_dp, thr=1e-14_dp)
        call check(error, norm2(inertial_velocity(c, fixed_r, fixed_v) - V), 0.0_dp, thr=1e-9_dp)
        call parse_utc('2000-01-01T11:58:55.816', utc, failure)     ! J2000 in TT
        c = inertial_of_earth_fixed(utc)
        ! At J2000 the true pole is off that of J2000 by nutation: -5.7" about the equinox, -13.9" sin(eps) towards it
        call check(error, norm2(c(1:2, 3)/ARCSECOND - [-5.55_dp, -5.77_dp]), 0.0_dp, thr=0.1_dp)
        call parse_utc('2023-06-01', utc, failure)
        c = inertial_of_earth_fixed(utc)
        call check(error, norm2(matmul(transpose(c), c) - identity(3)), 0.0_dp, thr=1e-14_dp)
        ! The pole of date lies theta = 2004.3" T from that of J2000, towards the equinox of date, but for nutation.
        call check(error, acos(c(3, 3))/ARCSECOND, 2004.3109_dp*0.23411_dp, thr=10.0_dp)
        call check(error, c(1, 3) > 0 .and. abs(c(2, 3)) < 0.03_dp*c(1, 3))
    end subroutine test_triads

    !> Official states: triads and the orientation of the IAU differ by what is left out, the pole (0.5 arcsec) and UT1
    !> (0.6 arcsec), on that day; the SRF is that
    !> of a satellite that flies backwards, with its z axis to the Earth.
    subroutine test_states(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_records_t) :: gnv1b, gni1b, sca1b
        type(error_t), allocatable :: failure
        real(dp) :: c(3, 3), r(3), v(3), attitude(3, 3)
        integer :: p, s, q

        if (.not. file_exists(SAMPLES//'GNV1B'//DAY)) then
            call skip_test(error, 'no official files at '//SAMPLES)
            return
        end if
        call read_level1(SAMPLES//'GNV1B'//DAY, gnv1b, failure)
        call read_level1(SAMPLES//'GNI1B'//DAY, gni1b, failure)
        call read_level1(SAMPLES//'SCA1B'//DAY, sca1b, failure)
        if (failed(error, failure)) return
        p = gni1b%field_of('xpos')
        s = gni1b%field_of('xvel')
        q = sca1b%field_of('quatangle')
        r = gni1b%values(1, p:p + 2)
        v = gni1b%values(1, s:s + 2)
        c = inertial_of_earth_fixed_by_states(r, v, gnv1b%values(1, p:p + 2), gnv1b%values(1, s:s + 2))
        call check(error, rotation_angle_between(quaternion_of_matrix(c), &
                                                 quaternion_of_matrix(inertial_of_earth_fixed(utc_of_gps(gnv1b%seconds(1), &
                                                                                                         0.0_dp))))/ARCSECOND, &
                   0.0_dp, thr=1.0_dp)
        attitude = rotation_matrix(gracecg_quaternion(sca1b%values(1, q:q + 3)))
        call check(error, norm2(matmul(attitude, r/norm2(r)) - [-0.013826874_dp, 0.000378633_dp, -0.999904333_dp]), &
                       0.0_dp, thr=1e-9_dp)
        call check(error, norm2(matmul(attitude, v/norm2(v)) - [-0.999915330_dp, 0.000380942_dp, 0.013007213_dp]), &
                       0.0_dp, thr=1e-9_dp)
    end subroutine test_states
end module test_level1_time
