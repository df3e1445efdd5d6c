!> What a day of Level-1 data looks like in numbers that tell whether it was understood: sampling, noise, frames,
!> rods, thrusters, gas. Each has a verdict: within what such data have, or not.
!>
!> Definitions. Amplitude spectral density: a line removed, Hann window w_i = sin^2(pi (i + 1/2)/n), one-sided
!> periodogram 2 dt |F|^2/sum w^2, root of its mean over the band, dt the mean interval; of segments of 2048 samples the median,
!> for firings are in some. Quantum: the least step between different values.
module gracecg_level1_check
    use gracecg_level1_basics
    use gracecg_base_spectrum, only: power_spectrum, HANN
    use gracecg_level1_check_attitude, only: check_attitude_and_field, level1_check_t, check_row_t
    use gracecg_level1_folder, only: level1_folder_t
    use gracecg_level1_frames, only: ACCELEROMETER_AXES, srf_of_accelerometer
    use gracecg_level1_records, only: level1_records_t
    use gracecg_level1_series, only: without_line, slope_of
    use gracecg_level1_time, only: level1_clock_t, new_level1_clock, to_gps_time
    implicit none
    private
    public :: level1_check_t, check_row_t, check_level1

    integer, parameter :: LONGEST_SEGMENT = 2048    !! Of a spectrum, samples
    real(dp), parameter :: LOW_BAND(2) = [0.15_dp, 0.6_dp], HIGH_BAND(2) = [2.0_dp, 5.0_dp]     !! Hz
    real(dp), parameter :: SAME_TAG = 1e-3_dp       !! Tags of 1A and 1B closer than that are of one sample, s
    real(dp), parameter :: NO_LIMIT = huge(1.0_dp)

contains

    !> Looks at the files of a folder. Products that are not there are left out; fails when a file is broken.
    subroutine check_level1(files, check, error)
        type(level1_folder_t), intent(in) :: files      !! See open_level1_folder
        type(level1_check_t), intent(out) :: check
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        allocate (check%rows(0), check%warnings(0))
        check%files = files
        do i = 1, size(files%warnings)
            call check%note(files%warnings(i)%text)
        end do
        call check_accelerometer(check)
        call check_tags(check)
        call check_attitude_and_field(check)
        call check_gyros(check)
        call check_thrusters(check)
        call check_gas(check)
        call move_alloc(check%failure, error)
    end subroutine check_level1

    !> ACC1A: sampling, means, noise, quanta, in SRF.
    subroutine check_accelerometer(check)
        type(level1_check_t), intent(inout) :: check

        type(level1_records_t) :: acc
        real(dp), allocatable :: times(:), linear(:, :), angular(:, :)
        real(dp) :: interval
        integer :: i, n, first

        call check%take('ACC1A', acc)
        n = acc%count
        if (n == 0) return
        call acc%times_since(acc%seconds(1), times)
        call check%add('acc1a_samples', real(n, dp), '', 1.0_dp, NO_LIMIT)
        if (n < 3) return
        interval = (times(n) - times(1))/(n - 1)
        call check%add('acc1a_interval', interval, 's', 0.0999_dp, 0.1001_dp)
        call check%add('acc1a_largest_step', maxval(times(2:) - times(:n - 1)), 's', 0.0999_dp, 0.15_dp)
        allocate (linear(n, 3), angular(n, 3))
        first = acc%field_of('lin_accl_x')
        do i = 1, n
            linear(i, :) = srf_of_accelerometer(acc%values(i, first:first + 2), ACCELEROMETER_AXES)
            angular(i, :) = srf_of_accelerometer(acc%values(i, first + 3:first + 5), ACCELEROMETER_AXES)
        end do
        if (any(.not. abs(linear) < 1) .or. any(.not. abs(angular) < 1)) then
            call check%note('ACC1A: some records have not all six accelerations: no means or noise')
            return
        end if
        call check%add_axes('linear_mean', sum(linear, 1)/n, 'm/s^2', -2e-5_dp, 2e-5_dp)
        call check%add_axes('linear_asd_0.15_0.6_hz', amplitude_densities(times, linear, interval, LOW_BAND), &
                            'm/s^2/sqrt(Hz)', 2e-11_dp, 3e-9_dp)
        call check%add_axes('linear_asd_2_5_hz', amplitude_densities(times, linear, interval, HIGH_BAND), &
                            'm/s^2/sqrt(Hz)', 1e-10_dp, 1e-8_dp)
        call check%add_axes('angular_mean', sum(angular, 1)/n, 'rad/s^2', -2e-3_dp, 2e-3_dp)
        call check%add_axes('angular_asd_0.15_0.6_hz', amplitude_densities(times, angular, interval, LOW_BAND), &
                            'rad/s^2/sqrt(Hz)', 1e-9_dp, 1e-6_dp)
        call check%add_axes('angular_quantum', [(quantum(angular(:, i)), i=1, 3)], 'rad/s^2', 1e-10_dp, 1e-7_dp)
    end subroutine check_accelerometer

    !> Root of the mean one-sided spectral density over a band, of each axis: the median of segments that overlap by half.
    function amplitude_densities(times, values, interval, band) result(density)
        real(dp), intent(in) :: times(:), values(:, :)  !! s; anything, (time, axis)
        real(dp), intent(in) :: interval                !! Mean, s
        real(dp), intent(in) :: band(2)                 !! Hz
        real(dp) :: density(3)

        real(dp), allocatable :: series(:)
        integer :: first, axis, length

        length = min(size(times), LONGEST_SEGMENT)
        do axis = 1, 3
            series = without_line(times, values(:, axis))
            density(axis) = sqrt(median_of([(mean_over_band(series(first:first + length - 1)), &
                                             first=1, size(series) - length + 1, max(1, length/2))]))
        end do

    contains

        pure real(dp) function mean_over_band(segment) result(mean)
            real(dp), intent(in) :: segment(:)

            real(dp), allocatable :: frequency(:), spectrum(:)
            integer :: i

            call power_spectrum([(i, i=1, length)], segment, interval, length, HANN, frequency, spectrum)
            associate (inside => frequency >= band(1) .and. frequency <= band(2))
                mean = 2*sum(spectrum, mask=inside)/max(1, count(inside))
            end associate
        end function mean_over_band
    end function amplitude_densities

    !> The least step between different values, made exact by their whole range.
    pure real(dp) function quantum(values)
        real(dp), intent(in) :: values(:)

        integer, parameter :: MOST = 2000
        real(dp), parameter :: ROUNDING = 1e-4_dp   ! of the step: values differ that much by rounding only
        real(dp) :: step, range
        integer :: i, n, rounds

        n = min(size(values), MOST)
        range = maxval(values(:n)) - minval(values(:n))
        quantum = 0
        if (range <= 0) return
        step = range
        do rounds = 1, 2
            do i = 1, n - 1
                associate (steps => abs(values(i + 1:n) - values(i)))
                    step = min(step, minval(steps, mask=steps > ROUNDING*step))
                end associate
            end do
        end do
        quantum = range/anint(range/step)
    end function quantum

    !> Tags of 1A taken to GPS time against those of 1B. The first number is of CLK1B alone and of seconds held in
    !> double precision; the second of the whole chain, with TIM1B, exact to a nanosecond.
    subroutine check_tags(check)
        type(level1_check_t), intent(inout) :: check

        character(3), parameter :: PRODUCTS(5) = ['MAG', 'TNK', 'IMU', 'THR', 'AHK']
        type(level1_records_t) :: clk1b, tim1b, a, b
        type(level1_clock_t) :: clock
        real(dp), allocatable :: of_a(:), received(:)
        real(dp) :: rough, exact
        integer :: i, k, product, extrapolated, compared

        call check%take('CLK1B', clk1b)
        if (clk1b%count == 0) return
        call check%take('TIM1B', tim1b)
        if (allocated(check%failure)) return
        if (tim1b%count == 0) call check%note('no TIM1B: time of the on-board computer is taken as that of the receiver')
        call new_level1_clock(clock, check%failure, clk1b, tim1b)
        if (allocated(check%failure)) return
        received = real(clock%receiver_seconds, dp)
        do product = 1, size(PRODUCTS)
            call check%take(PRODUCTS(product)//'1A', a)
            call check%take(PRODUCTS(product)//'1B', b)
            if (a%count == 0 .or. b%count == 0 .or. a%time_ref /= 'R') cycle
            call a%drop(clock%is_extrapolated(a%seconds))
            of_a = real(a%seconds, dp) + a%fraction
            do i = 1, a%count
                k = max(1, last_not_after(received, of_a(i)))
                of_a(i) = (of_a(i) + clock%eps_time(k)) + clock%eps_drift(k)*(of_a(i) - received(k))
            end do
            call compare_tags(0*a%seconds, of_a, 0*b%seconds, real(b%seconds, dp) + b%fraction, rough, compared)
            call to_gps_time(a, clock, extrapolated)
            call compare_tags(a%seconds, a%fraction, b%seconds, b%fraction, exact, compared)
            if (compared == 0) cycle
            associate (name => lower_case(PRODUCTS(product))//'_tags_')
                call check%add(name//'compared', real(compared, dp), '', 1.0_dp, NO_LIMIT)
                call check%add(name//'difference', rough*1e6_dp, 'us', 0.0_dp, 1.5_dp)
                call check%add(name//'difference_chain', exact*1e6_dp, 'us', 0.0_dp, 1.5_dp)
            end associate
        end do
    end subroutine check_tags

    !> The largest difference between tags of 1A and the nearest of 1B, of those that have one.
    pure subroutine compare_tags(seconds_a, a, seconds_b, b, largest, compared)
        integer(i8), intent(in) :: seconds_a(:), seconds_b(:)   !! Whole seconds, s
        real(dp), intent(in) :: a(:), b(:)                      !! The rest, s
        real(dp), intent(out) :: largest                        !! s
        integer, intent(out) :: compared

        real(dp) :: difference, tags_b(size(b))
        integer :: i, k

        largest = 0
        compared = 0
        tags_b = real(seconds_b, dp) + b
        do i = 1, size(a)
            k = last_not_after(tags_b, real(seconds_a(i), dp) + a(i))
            associate (near => [max(1, k), min(size(b), k + 1)])
                difference = minval(abs(real(seconds_a(i) - seconds_b(near), dp) + (a(i) - b(near))))
            end associate
            if (difference > SAME_TAG) cycle
            compared = compared + 1
            largest = max(largest, difference)
        end do
    end subroutine compare_tags

    !> IMU1A: rate of each gyro and what a straight line leaves of its angle.
    subroutine check_gyros(check)
        type(level1_check_t), intent(inout) :: check

        integer, parameter :: GYROS = 4
        real(dp), parameter :: LONGEST = 30     ! s: a longer span is no straight line
        type(level1_records_t) :: imu
        real(dp), allocatable :: times(:), t(:), angle(:)
        logical, allocatable :: mine(:)
        integer :: gyro

        call check%take('IMU1A', imu)
        if (imu%count == 0) return
        call imu%times_since(imu%seconds(1), times)
        do gyro = 1, GYROS
            mine = nint(imu%values(:, imu%field_of('gyro_id'))) == gyro .and. times <= times(1) + LONGEST
            if (count(mine) < 3) cycle
            t = pack(times, mine)
            angle = pack(imu%values(:, imu%field_of('FiltAng')), mine)*DEGREE
            call check%add('gyro_'//integer_text(gyro)//'_rate', slope_of(t, angle), 'rad/s', -2e-3_dp, 2e-3_dp)
            call check%add('gyro_'//integer_text(gyro)//'_residual', norm2(without_line(t, angle))/sqrt(real(size(t), dp)), &
                           'rad', 0.0_dp, 1e-5_dp)
        end do
    end subroutine check_gyros

    !> THR1A: records, on-time of all attitude thrusters, firings of each.
    subroutine check_thrusters(check)
        type(level1_check_t), intent(inout) :: check

        integer, parameter :: THRUSTERS = 12
        real(dp), parameter :: MOST = 20000
        type(level1_records_t) :: thr
        integer :: first, i

        call check%take('THR1A', thr)
        if (thr%count == 0) return
        first = thr%field_of('on_time_1')
        call check%add('thr1a_records', real(thr%count, dp), '', 0.0_dp, MOST)
        call check%add('thr1a_on_time', sum(thr%values(:, first:first + THRUSTERS - 1))*1e-3_dp, 's', 0.0_dp, 2000.0_dp)
        do i = 1, THRUSTERS
            call check%add('thr1a_firings_'//integer_text(i), real(count(thr%values(:, first + i - 1) > 0), dp), '', 0.0_dp, &
                           MOST)
        end do
    end subroutine check_thrusters

    !> MAS1A, or without it MAS1B: gas used from each tank between the first and the last record that have it.
    subroutine check_gas(check)
        type(level1_check_t), intent(inout) :: check

        type(level1_records_t) :: mas
        real(dp), allocatable :: mass(:)
        integer :: tank

        call check%take('MAS1A', mas)
        if (mas%count == 0) call check%take('MAS1B', mas)
        if (mas%count == 0) return
        do tank = 1, 2
            mass = mas%values(:, mas%field_of('gas_mass_tnk'//integer_text(tank)))
            mass = pack(mass, abs(mass) < huge(1.0_dp))
            if (size(mass) < 2) cycle
            call check%add('gas_used_'//integer_text(tank), mass(1) - mass(size(mass)), 'kg', 0.0_dp, 0.05_dp)
        end do
    end subroutine check_gas
end module gracecg_level1_check
