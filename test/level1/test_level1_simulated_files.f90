!> Simulated Level-1 files: every instrument's effect against a formula of its own; their headers, and text against binary.
module test_level1_simulated_files
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use vocabulary
    use gracecg_base_constants, only: MICROTESLA, NANOTESLA
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion, rotation_matrix, rotation_angle_between
    use gracecg_base_text, only: real_text
    use gracecg_level1_frames, only: gracecg_quaternion, mounting_of_head, inertial_of_earth_fixed_by_states
    use gracecg_level1_records, only: level1_records_t
    use gracecg_level1_setup, only: level1_setup_t, read_level1_setup
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_gathering, only: gather_calibration
    use gracecg_level1_simulation_settings, only: level1_settings_t
    use gracecg_level1_simulated_truth, only: level1_truth_t, truth_point_t
    use gracecg_simulation_dynamics, only: OMEGA, ATTITUDE, STATE_SIZE
    use statistics, only: chi_square_limits, Z_999
    use test_level1_simulation, only: clean, fly, write_files, prepare, read_product, START
    implicit none
    private
    public :: collect_level1_simulated_files

    real(dp), parameter :: CLOCK = -0.016667_dp, DRIFT = -1.5e-8_dp     !! GPS less receiver time of satellite C
    integer, parameter :: AF_OF_SRF(3) = [3, 1, 2]      !! Columns of ACC1A for x, y, z of SRF: SPEC of the mission

contains

    subroutine collect_level1_simulated_files(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('samples-and-clocks', test_samples), &
                    new_unittest('leakage', test_leakage), &
                    new_unittest('noise', test_noise), &
                    new_unittest('quanta', test_quanta), &
                    new_unittest('delays-and-staircase', test_delays), &
                    new_unittest('magnetometer', test_magnetometer), &
                    new_unittest('heads', test_heads), &
                    new_unittest('gyros', test_gyros), &
                    new_unittest('orbit', test_orbit), &
                    new_unittest('firings', test_firings), &
                    new_unittest('gaps-and-flags', test_gaps), &
                    new_unittest('headers', test_headers), &
                    new_unittest('binary', test_binary)]
    end subroutine collect_level1_simulated_files

    !> ACC1A in SRF, and the GPS times of its samples by the formula of CLK1B.
    subroutine accelerations(path, truth, times, linear, angular)
        character(*), intent(in) :: path
        type(level1_truth_t), intent(in) :: truth
        real(dp), allocatable, intent(out) :: times(:), linear(:, :), angular(:, :)
        type(level1_records_t) :: acc
        integer :: first

        call read_product(path, 'ACC1A', acc)
        times = real(acc%seconds - truth%epoch, dp) + acc%fraction
        times = times + CLOCK + DRIFT*times
        first = acc%field_of('lin_accl_x') - 1
        linear = transpose(acc%values(:, first + AF_OF_SRF))
        angular = transpose(acc%values(:, first + 3 + AF_OF_SRF))
    end subroutine accelerations

    !> Each sample is the truth at the GPS time of its tag, through scale and bias, in the axes of AF; the interval is
    !> that of the instrument. Tags of MAG1B are those of MAG1A through the clock; the other instrument's likewise.
    subroutine test_samples(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_truth_t) :: truth
        type(level1_settings_t) :: settings
        type(level1_records_t) :: mag, mag_gps, clk
        type(truth_point_t) :: point
        character(:), allocatable :: path
        real(dp), allocatable :: times(:), linear(:, :), angular(:, :), tag(:), tag_gps(:)
        integer :: i

        settings = clean()
        settings%scale_error = 0.004_dp
        settings%angular_scale_error = 0.03_dp
        call prepare(settings, 'l1s_samples', truth, path)
        call accelerations(path, truth, times, linear, angular)
        call check(error, any(abs(truth%errors%scale - 1) > 1e-4_dp) .and. any(abs(truth%errors%angular_scale - 1) > 1e-3_dp), &
                   'scales')
        if (unmet(error, abs((times(size(times)) - times(1))/(size(times) - 1) - 0.0999910_dp) < 2e-9_dp, 'interval')) return
        do i = 1, size(times), 37
            call truth%at(times(i), point)
            call check(error, maxval(abs(linear(:, i) - [-2.8e-7_dp, -1.065e-5_dp, -1.83e-7_dp] - &
                                         truth%errors%scale*point%sensed)) < 1e-15_dp, 'linear acceleration')
            call check(error, maxval(abs(angular(:, i) - [-7.8e-4_dp, 1.3e-5_dp, 1.2e-4_dp] - &
                                         truth%errors%angular_scale*point%acceleration)) < 1e-12_dp, 'angular acceleration')
        end do
        call read_product(path, 'MAG1A', mag)
        call read_product(path, 'MAG1B', mag_gps)
        call read_product(path, 'CLK1B', clk)
        tag = real(mag%seconds - truth%epoch, dp) + mag%fraction
        tag_gps = real(mag_gps%seconds - truth%epoch, dp) + mag_gps%fraction
        call check(error, maxval(abs(tag + CLOCK + DRIFT*tag - tag_gps)) < 6e-7_dp, 'tags of MAG')
        call check(error, all(abs(modulo(tag, 0.5_dp) - 0.1_dp) < 1e-7_dp) .and. mag%time_ref == 'R', 'grid of MAG1A')
        call check(error, maxval(abs(clk%values(:, clk%field_of('eps_time')) - CLOCK - &
                                     DRIFT*real(clk%seconds - truth%epoch, dp))) < 1e-15_dp, 'clock')
        call check(error, clk%duplicates, 1, 'the first epoch of CLK1B stands twice')
    end subroutine test_samples

    !> What a run with leakage has more than one without is L I + K dI/dt, with sines known in closed form; those of a controller
    !> that acts by the rods leak, too.
    subroutine test_leakage(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_truth_t) :: truth
        type(level1_settings_t) :: settings
        type(truth_point_t) :: now, before, behind
        character(:), allocatable :: path
        real(dp), allocatable :: times(:), without(:, :), angular_without(:, :), linear(:, :), angular(:, :)
        real(dp) :: current(3), rate(3), omega(3)
        integer :: i

        settings = clean()
        call prepare(settings, 'l1s_no_leak', truth, path)
        call accelerations(path, truth, times, without, angular_without)
        settings%leakage = [1e-12_dp, 3e-11_dp]
        settings%angular_leakage = [1e-10_dp, 3e-9_dp]
        call prepare(settings, 'l1s_leak', truth, path)
        call accelerations(path, truth, times, linear, angular)
        call check(error, all(abs(truth%errors%leak) > 0) .and. maxval(abs(truth%errors%leak)) < 5e-12_dp .and. &
                   maxval(abs(truth%errors%leak_rate)) < 1.5e-10_dp, 'elements of their size')
        omega = TWO_PI*[5, 6, 7]/60
        do i = 1, size(times)
            if (times(i) < START + 0.1_dp .or. times(i) > START + 59.9_dp) cycle
            current = 120*sin(omega*(times(i) - START))
            rate = 120*omega*cos(omega*(times(i) - START))*(sin(omega*0.05_dp)/(omega*0.05_dp))     ! mean over a sample
            call check(error, maxval(abs(linear(:, i) - without(:, i) - matmul(truth%errors%leak, current) - &
                                         matmul(truth%errors%leak_rate, rate))) < 1e-18_dp, 'linear')
            call check(error, maxval(abs(angular(:, i) - angular_without(:, i) - matmul(truth%errors%angular_leak, current) - &
                                         matmul(truth%errors%angular_leak_rate, rate))) < 1e-16_dp, 'angular')
        end do
        settings%rod_control = .true.
        call prepare(settings, 'l1s_leak', truth, path)
        call accelerations(path, truth, times, linear, angular)
        do i = 100, size(times) - 100, 37
            call truth%at(times(i), now)
            call truth%at(times(i) - 0.05_dp, before)
            call truth%at(times(i) + 0.05_dp, behind)
            call check(error, maxval(abs(linear(:, i) - settings%bias - truth%errors%scale*now%sensed - &
                                         matmul(truth%errors%leak, now%current) - &
                                         matmul(truth%errors%leak_rate, behind%current - before%current)/0.1_dp)) < 1e-18_dp, &
                       'linear, controlled by rods')
        end do
    end subroutine test_leakage

    !> Noise has the spectrum asked for: its variance r0 and its covariance r1 between neighbours give the one-sided
    !> density 2 dt (r0 + 2 r1 cos(2 pi f dt)), which is compared at 0.1 Hz and, as a mean, from 2 to 5 Hz; D is six
    !> times as noisy.
    subroutine test_noise(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: LOW(3) = [2.7e-10_dp, 1.3e-10_dp, 0.64e-10_dp], HIGH(3) = [6.7e-10_dp, 2.4e-10_dp, 9.2e-10_dp]
        real(dp), parameter :: TURNING(3) = [2.9e-8_dp, 1.1e-8_dp, 1.7e-8_dp], DT = 0.0999910_dp
        type(level1_truth_t) :: truth
        type(level1_settings_t) :: settings
        character(:), allocatable :: path
        real(dp), allocatable :: times(:), without(:, :), angular_without(:, :), linear(:, :), angular(:, :), noise(:)
        real(dp) :: r0, r1, at_low, at_high, factor
        integer :: axis, n, satellite, i

        settings = clean()
        settings%spans = 0
        settings%duration = 600
        call prepare(settings, 'l1s_quiet', truth, path)
        call accelerations(path, truth, times, without, angular_without)
        do satellite = 1, 2
            settings%noise_factor = merge(-1, 6, satellite == 1)
            factor = merge(1, 6, satellite == 1)
            call prepare(settings, 'l1s_noise', truth, path)
            call accelerations(path, truth, times, linear, angular)
            n = size(times)
            do axis = 1, 3
                noise = linear(axis, :) - without(axis, :)
                r0 = sum(noise**2)/n
                r1 = sum(noise(2:)*noise(:n - 1))/(n - 1)
                at_low = sqrt(max(0.0_dp, 2*DT*(r0 + 2*r1*cos(TWO_PI*0.1_dp*DT))))
                at_high = sqrt(2*DT*(r0 + 2*r1*sum([(cos(TWO_PI*(2 + 0.01_dp*i)*DT), i=0, 300)])/301))
                ! Sampling error of r0 and r1 is some r0/sqrt(n): of the density at low frequency, where both cancel, much more
                call check(error, abs(at_low**2 - (factor*LOW(axis))**2) < 4*2*DT*2*r0/sqrt(real(n, dp)), 'at 0.1 Hz')
                call check(error, abs(at_high/(factor*HIGH(axis)) - 1) < 0.05_dp, 'from 2 to 5 Hz')
                r0 = sum((angular(axis, :) - angular_without(axis, :))**2)/n
                call check(error, abs(sqrt(2*DT*r0)/(factor*TURNING(axis)) - 1) < Z_999/sqrt(2.0_dp*n), 'angular')
            end do
        end do
    end subroutine test_noise

    !> Angular accelerations and currents come in quanta; B currents are negative of GRACE-FO.
    subroutine test_quanta(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: QUANTA(3) = [1.0133e-8_dp, 6.109e-10_dp, 1.0133e-8_dp]
        type(level1_truth_t) :: truth
        type(level1_settings_t) :: settings
        type(level1_records_t) :: mag
        character(:), allocatable :: path
        real(dp), allocatable :: times(:), linear(:, :), angular(:, :)
        real(dp) :: steps(3)
        integer :: i, first

        settings = clean()
        settings%angular_quantum = QUANTA
        settings%current_quantum = 0.0537_dp
        call prepare(settings, 'l1s_quanta', truth, path)
        call accelerations(path, truth, times, linear, angular)
        call read_product(path, 'MAG1B', mag)
        do i = 1, size(times)
            steps = angular(:, i)/QUANTA
            if (maxval(abs(steps - anint(steps))) < 1e-6_dp) cycle
            call check(error, .false., 'whole quanta of angular acceleration')
            return
        end do
        first = mag%field_of('torque1A')
        call check(error, all(mag%values(:, first:first + 2) >= 0) .and. all(mag%values(:, first + 3:first + 5) <= 0), 'signs')
        call check(error, all(abs(mag%values(:, first:first + 2)*mag%values(:, first + 3:first + 5)) <= 0), 'A or B')
        do i = 1, mag%count
            steps = (mag%values(i, first:first + 2) + mag%values(i, first + 3:first + 5))/0.0537_dp
            call check(error, maxval(abs(steps - anint(steps))) < 2e-4_dp, 'whole quanta of current')
        end do
    end subroutine test_quanta

    !> A delay of the torque lets currents flow later than their tags say, one of the accelerometer lets samples show
    !> what was earlier; held currents are those of the tag before.
    subroutine test_delays(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: LAG = 0.13_dp, LATER = 0.07_dp      ! s
        type(level1_truth_t) :: truth
        type(level1_settings_t) :: settings
        type(truth_point_t) :: point
        type(level1_setup_t) :: setup
        type(level1_calibration_t) :: calibration
        type(error_t), allocatable :: failure
        character(:), allocatable :: path
        real(dp), allocatable :: times(:), linear(:, :), angular(:, :)
        real(dp) :: time, tag
        integer :: i

        settings = clean()
        settings%torque_delay = LATER
        settings%accelerometer_delay = LAG
        settings%magnetometer_leakage = 1
        call prepare(settings, 'l1s_delays', truth, path)
        call accelerations(path, truth, times, linear, angular)
        do i = 1400, size(times), 41
            call truth%at(times(i) - LAG, point)
            call check(error, maxval(abs(angular(:, i) - [-7.8e-4_dp, 1.3e-5_dp, 1.2e-4_dp] - point%acceleration)) < 1e-12_dp, &
                       'a sample shows what was')
        end do
        call truth%at(START + 20, point)
        call check(error, maxval(abs(point%current - truth%dynamics%tagged_current(START + 20 - LATER))) < 1e-9_dp, &
                   'currents flow later')
        ! Though rods of up to 37 nT/mA and 80 mA/s are seen 70 ms later, magnetometer and model agree.
        call read_level1_setup(path//'/setup.nml', setup, failure)
        if (.not. allocated(failure)) call gather_calibration([path], setup, '', '', reshape([real(dp) ::], [2, 0]), 'model', &
                                                              calibration, failure)
        if (failed(error, failure)) return
        call check(error, calibration%field_difference > 0 .and. calibration%field_difference < 40*NANOTESLA, &
                   real_text(calibration%field_difference/NANOTESLA))
        settings = clean()
        settings%staircase = .true.
        call fly(settings, truth)
        do i = 1, 40
            time = START + 1 + 0.173_dp*i
            tag = 0.5_dp*floor((time - CLOCK - 0.1_dp)/0.5_dp) + 0.1_dp
            tag = tag + CLOCK + DRIFT*tag
            call truth%at(time, point)
            call check(error, maxval(abs(point%current - 120*sin(TWO_PI*[5, 6, 7]*(tag - START)/60))) < 1e-6_dp, 'held')
        end do
    end subroutine test_delays

    !> The magnetometer: the field, its bias, what the rods add by the table of GRACE-A; new every second; stuck.
    subroutine test_magnetometer(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: K_MAG(3, 3) = reshape([3.1_dp, -37.7_dp, 37.3_dp, -3.0_dp, -5.1_dp, -1.4_dp, -23.2_dp, &
                                                      -1.0_dp, 2.4_dp], [3, 3])     ! nT/mA
        real(dp), parameter :: BIAS(3) = [-530, 16, 250]        ! nT
        type(level1_truth_t) :: truth
        type(level1_settings_t) :: settings
        type(level1_records_t) :: mag
        type(truth_point_t) :: point
        character(:), allocatable :: path
        real(dp) :: time, expected(3)
        integer :: i, stuck

        settings = clean()
        settings%magnetometer_bias = 1
        settings%magnetometer_leakage = 1
        settings%stuck = [200.0_dp, 10.0_dp]
        call prepare(settings, 'l1s_magnetometer', truth, path)
        call read_product(path, 'MAG1B', mag)
        stuck = 0
        do i = 1, mag%count - 1, 2
            time = real(mag%seconds(i) - truth%epoch, dp) + mag%fraction(i)
            call truth%at(time, point)
            expected = point%acting%field/MICROTESLA + (BIAS + matmul(K_MAG, point%current))*1e-3_dp
            associate (first => mag%field_of('MfvX_RAW'))
                call check(error, all(abs(mag%values(i, first:first + 2) - mag%values(i + 1, first:first + 2)) <= 0), &
                           'the field is new every second only')
                if (time > 200 .and. time < 210) then
                    if (all(abs(mag%values(i, first:first + 2) - mag%values(i - 2, first:first + 2)) <= 0)) stuck = stuck + 1
                    cycle
                end if
                call check(error, maxval(abs(mag%values(i, first:first + 2) - expected)) < 1e-5_dp, 'field, bias, rods')
            end associate
        end do
        call check(error, stuck, 10, 'stuck for ten seconds')
    end subroutine test_magnetometer

    !> Three heads through QSA1B give SCA1B's attitude at their times; their noise is that asked for; boresights are those
    !> of GRACE-FO.
    subroutine test_heads(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: BORESIGHT(3, 3) = reshape([0.508_dp, 0.0_dp, -0.861_dp, -0.460_dp, 0.763_dp, -0.454_dp, &
                                                          -0.444_dp, -0.769_dp, -0.459_dp], [3, 3])
        real(dp), parameter :: SIGMA(3) = [2.6_dp, 1.5_dp, 25.0_dp]*ARCSECOND
        type(level1_truth_t) :: truth
        type(level1_settings_t) :: settings
        type(level1_records_t) :: sca, qsa, body
        character(:), allocatable :: path
        real(dp) :: mounting(4, 3), c(3, 3), state(STATE_SIZE), q(4), turn(4), squares(3, 3), limits(2), time, worst
        integer :: head, i, number(3), axis

        settings = clean()
        settings%head_noise = SIGMA
        settings%attitude_noise = 2e-7_dp
        call prepare(settings, 'l1s_heads', truth, path)
        call read_product(path, 'SCA1A', sca)
        call read_product(path, 'QSA1B', qsa)
        call read_product(path, 'SCA1B', body)
        do head = 1, 3
            mounting(:, head) = mounting_of_head(qsa, head, truth%epoch)
            c = rotation_matrix(mounting(:, head))
            call check(error, maxval(abs(c(:, 3) - BORESIGHT(:, head)/norm2(BORESIGHT(:, head)))) < 1e-12_dp, 'boresight')
        end do
        squares = 0
        number = 0
        do i = 1, sca%count
            time = real(sca%seconds(i) - truth%epoch, dp) + sca%fraction(i)
            head = nint(sca%values(i, sca%field_of('sca_id')))
            state = truth%arc%state_at(time + CLOCK + DRIFT*time)
            q = state(ATTITUDE)
            associate (first => sca%field_of('quatangle'))
                turn = quaternion_product(gracecg_quaternion(sca%values(i, first:first + 3)), &
                                          conjugate_quaternion(quaternion_product(conjugate_quaternion(mounting(:, head)), q)))
            end associate
            if (turn(4) < 0) turn = -turn
            squares(:, head) = squares(:, head) + (2*turn(1:3))**2
            number(head) = number(head) + 1
        end do
        do head = 1, 3
            limits = chi_square_limits(number(head))
            do axis = 1, 3
                call check(error, squares(axis, head)/SIGMA(axis)**2 > limits(1) .and. squares(axis, head)/SIGMA(axis)**2 < &
                           limits(2), 'noise of head '//integer_text(head))
            end do
        end do
        worst = 0
        do i = 1, body%count
            state = truth%arc%state_at(real(body%seconds(i) - truth%epoch, dp))
            q = state(ATTITUDE)
            associate (first => body%field_of('quatangle'))
                worst = max(worst, rotation_angle_between(q, gracecg_quaternion(body%values(i, first:first + 3))))
            end associate
        end do
        call check(error, worst < 1.2e-6_dp .and. worst > 2e-7_dp, 'noise of SCA1B')
    end subroutine test_heads

    !> Gyros 1 and 3 see 0.8165 of the pitch rate with both signs, gyro 2 none; their angle is the integral of the rate.
    subroutine test_gyros(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_truth_t) :: truth
        type(level1_settings_t) :: settings
        type(level1_records_t) :: imu
        character(:), allocatable :: path
        real(dp) :: seen(3), first(3), before(3), state(STATE_SIZE), mean_rate, since, time
        integer :: i, gyro, last
        real(dp), parameter :: SHARE(3) = [0.8165_dp, 0.0_dp, -0.8165_dp]

        settings = clean()
        settings%spans = 0
        settings%duration = 300
        settings%science_current = 0
        call prepare(settings, 'l1s_gyros', truth, path)
        call read_product(path, 'IMU1A', imu)
        call check(error, imu%count, 3*8*299, 'three gyros, eight a second')
        last = 0
        do i = 1, imu%count
            gyro = nint(imu%values(i, imu%field_of('gyro_id')))
            time = real(imu%seconds(i) - truth%epoch, dp) + imu%fraction(i)
            if (last < 3) then
                first(gyro) = imu%values(i, imu%field_of('FiltAng'))
                before(gyro) = time
                last = last + 1
            end if
            if (time > 280) exit
            seen(gyro) = (imu%values(i, imu%field_of('FiltAng')) - first(gyro))*DEGREE/max(time - before(gyro), 1e-3_dp)
            since = time
        end do
        mean_rate = 0
        do i = 1, 280
            state = truth%arc%state_at(since*(i - 0.5_dp)/280)
            mean_rate = mean_rate + state(8)/280
        end do
        do gyro = 1, 3
            call check(error, abs(seen(gyro) - SHARE(gyro)*mean_rate) < 2e-5_dp, 'gyro '//integer_text(gyro))
        end do
        call check(error, abs(mean_rate) > 1e-3_dp, 'the orbital rate')
    end subroutine test_gyros

    !> GNV1B and GNI1B are one orbit: positions change by the velocities, and the triad of both is the turn of the Earth.
    subroutine test_orbit(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_truth_t) :: truth
        type(level1_records_t) :: fixed, inertial
        character(:), allocatable :: path
        real(dp) :: c(3, 3), change(3)
        integer :: i, r, v

        call prepare(clean(), 'l1s_orbit', truth, path)
        call read_product(path, 'GNV1B', fixed)
        call read_product(path, 'GNI1B', inertial)
        r = fixed%field_of('xpos')
        v = fixed%field_of('xvel')
        do i = 2, fixed%count - 1, 20
            change = (fixed%values(i + 1, r:r + 2) - fixed%values(i - 1, r:r + 2))/2
            call check(error, maxval(abs(change - fixed%values(i, v:v + 2))) < 2e-3_dp, 'Earth-fixed velocity')
            change = (inertial%values(i + 1, r:r + 2) - inertial%values(i - 1, r:r + 2))/2
            call check(error, maxval(abs(change - inertial%values(i, v:v + 2))) < 2e-3_dp, 'inertial velocity')
            c = inertial_of_earth_fixed_by_states(inertial%values(i, r:r + 2), inertial%values(i, v:v + 2), &
                                                  fixed%values(i, r:r + 2), fixed%values(i, v:v + 2))
            call check(error, maxval(abs(transpose(c) - truth%dynamics%earth%from_inertial(i - 1.0_dp))) < 1e-8_dp, &
                       'turn of the Earth')
        end do
    end subroutine test_orbit

    !> A pair of thrusters turns the satellite by its torque for 50 ms: (1, 7) yaws by -29 mN m. Firings stand in THR1A and
    !> THR1B, on the grid of the on-board computer, and take gas.
    subroutine test_firings(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: TORQUES(3, 4) = reshape([0.0_dp, 0.0_dp, -0.029_dp, 0.0_dp, 0.0_dp, 0.029_dp, &
                                                        -0.006_dp, 0.0_dp, 0.0_dp, 0.006_dp, 0.0_dp, 0.0_dp], [3, 4])   ! N m
        integer, parameter :: FIRST_OF(4) = [1, 3, 5, 6]
        type(level1_truth_t) :: with, without
        type(level1_settings_t) :: settings
        type(level1_records_t) :: thr, mas
        character(:), allocatable :: path
        real(dp) :: state(STATE_SIZE), state_without(STATE_SIZE), change(3)
        integer :: i, on, before

        settings = clean()
        settings%spans = 3
        settings%spacing = 200
        settings%duration = 700
        call fly(settings, without)
        settings%firings_inside = 3
        call prepare(settings, 'l1s_firings', with, path)
        call read_product(path, 'THR1B', thr)
        call read_product(path, 'MAS1B', mas)
        call check(error, thr%count, 3, 'a firing in each span')
        on = thr%field_of('on_time_1') - 1
        state = with%arc%state_at(with%dynamics%firings(1)%time + 0.2_dp)
        state_without = without%arc%state_at(with%dynamics%firings(1)%time + 0.2_dp)
        change = matmul(with%dynamics%inertia, state(OMEGA) - state_without(OMEGA))
        call check(error, maxval(abs(change - 0.05_dp*TORQUES(:, with%dynamics%firings(1)%pair))) < 2e-3_dp*maxval(abs(change)), &
                   'change of the angular momentum')
        do i = 1, 3
            call check(error, abs(real(thr%seconds(i) - with%epoch, dp) + thr%fraction(i) - with%dynamics%firings(i)%time) < &
                       1e-6_dp, 'tag')
            before = FIRST_OF(with%dynamics%firings(i)%pair)
            call check(error, nint(thr%values(i, on + before)) == 50 .and. nint(thr%values(i, on + before + 6)) == 50 .and. &
                       nint(sum(thr%values(i, on + 1:on + 14))) == 100, 'on-time')
        end do
        associate (tank => mas%field_of('gas_mass_tnk1'))
            call check(error, mas%values(1, tank) > mas%values(mas%count, tank), 'gas is used')
        end associate
    end subroutine test_firings

    !> Gaps and flagged samples are where and as many as asked for; the clean samples are those of a run without.
    subroutine test_gaps(error)
        type(error_type), allocatable, intent(out) :: error
        type(level1_truth_t) :: truth
        type(level1_settings_t) :: settings
        type(level1_records_t) :: acc, all_of_them
        character(:), allocatable :: path
        integer :: flag, wrong, i, bad

        settings = clean()
        call prepare(settings, 'l1s_no_gaps', truth, path)
        call read_product(path, 'ACC1A', all_of_them)
        settings%gaps = 1
        settings%gap = 3
        settings%flagged = 7
        call prepare(settings, 'l1s_gaps', truth, path)
        call read_product(path, 'ACC1A', acc)
        call check(error, abs(all_of_them%count - acc%count - 30) <= 1, 'three seconds are missing')
        flag = acc%field_of('qualflg')
        bad = count(acc%values(:, flag) > 0)
        call check(error, bad <= 7 .and. bad >= 5, 'flagged samples, but for those in the gap')
        wrong = 0
        do i = 1, acc%count
            if (acc%values(i, flag) > 0) then
                wrong = wrong + 1
            else if (.not. any(abs(all_of_them%values(:, acc%field_of('lin_accl_x')) - &
                                   acc%values(i, acc%field_of('lin_accl_x'))) <= 0)) then
                call check(error, .false., 'a sample without flag is changed')
                return
            end if
        end do
        call check(error, wrong, bad, 'wrong are those with a flag')
    end subroutine test_gaps

    !> Headers announce number and times of the records: tags of 1A are not those of 1B.
    subroutine test_headers(error)
        type(error_type), allocatable, intent(out) :: error
        character(5), parameter :: OF_BOTH(13) = ['ACC1A', 'MAG1A', 'MAG1B', 'SCA1A', 'SCA1B', 'QSA1B', 'GNV1B', 'CLK1B', 'TIM1B', &
                                                  'THR1A', 'THR1B', 'MAS1B', 'TNK1B'], OF_GRACE_FO(2) = ['IMU1A', 'GNI1B']
        character(5), allocatable :: products(:)
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_records_t) :: records
        character(:), allocatable :: path
        real(dp) :: announced(2)
        integer :: i, satellite

        do satellite = 1, 2
            settings = clean()
            settings%clock_offset = CLOCK
            settings%firings_inside = 1
            products = [OF_BOTH, OF_GRACE_FO]
            if (satellite == 2) then
                settings%satellite = 'A'
                products = pack(OF_BOTH, OF_BOTH /= 'MAG1A')
            end if
            call prepare(settings, 'l1s_headers'//integer_text(satellite), truth, path)
            do i = 1, size(products)
                call read_product(path, products(i), records, merge('_2020-02-01_C_04.txt', '_2020-02-01_A_02.asc', &
                                                                    satellite == 1))
                call check(error, records%header%records, records%count + records%duplicates, products(i))
                associate (n => records%count, header => records%header)
                    announced = [header%first_time, header%last_time] - real(truth%epoch, dp)
                    call check(error, all(abs(announced - (records%seconds([1, n]) - truth%epoch) - records%fraction([1, n])) < &
                                          1.1e-6_dp), products(i)//' of '//truth%satellite)
                end associate
            end do
        end do
    end subroutine test_headers

    !> Binary has the values of text, to the 16 digits that text has; satellite C, but for what has no binary form, and A.
    subroutine test_binary(error)
        type(error_type), allocatable, intent(out) :: error
        character(5), parameter :: BOTH(12) = ['ACC1A', 'MAG1B', 'SCA1B', 'QSA1B', 'GNV1B', 'CLK1B', 'TIM1B', 'THR1A', 'THR1B', &
                                               'MAS1B', 'TNK1B', 'SCA1A']
        type(level1_settings_t) :: settings
        type(level1_truth_t) :: truth
        type(level1_records_t) :: text, bytes
        character(:), allocatable :: path, binary_path
        character(20) :: name
        integer :: i, satellite

        do satellite = 1, 2
            settings = level1_settings_t()
            settings%spans = 1
            settings%first_start = START
            settings%duration = 240
            if (satellite == 2) settings%satellite = 'A'
            name = merge('_2020-02-01_C_04', '_2020-02-01_A_02', satellite == 1)
            call fly(settings, truth)
            call write_files(truth, 'l1s_text'//integer_text(satellite), path)
            call write_files(truth, 'l1s_bytes'//integer_text(satellite), binary_path, .true.)
            do i = 1, size(BOTH)
                if (satellite == 1 .and. BOTH(i) == 'SCA1A') cycle
                call read_product(path, BOTH(i), text, trim(name)//merge('.txt', '.asc', satellite == 1))
                call read_product(binary_path, BOTH(i), bytes, trim(name)//'.dat')
                call check(error, bytes%header%binary .and. text%count == bytes%count, BOTH(i)//': form and number')
                call check(error, all(text%seconds == bytes%seconds) .and. all(abs(text%fraction - bytes%fraction) <= 0), &
                           BOTH(i)//': tags')
                ! Text has at most 16 digits of a number of single precision
                call check(error, all(abs(text%values - bytes%values) <= 4*epsilon(1.0_dp)*abs(bytes%values) .or. &
                                      (ieee_is_nan(text%values) .and. ieee_is_nan(bytes%values))), BOTH(i)//': values')
            end do
        end do
    end subroutine test_binary
end module test_level1_simulated_files
