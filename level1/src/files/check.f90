!> What a day of Level-1 data looks like in numbers that tell whether it was understood: sampling, noise, frames,
!> rods, thrusters, gas. Each has a verdict: within what such data have, or not.
!>
!> Definitions. Rate of interval k: rotation vector of R(q_k+1) R(q_k)^T per second. Amplitude spectral density:
!> a line removed, Hann window w_i = sin^2(pi (i + 1/2)/n), one-sided periodogram 2 dt |F|^2/sum w^2, root of its
!> mean over the band, dt the mean interval. Quantum: the least step between different values.
module gracecg_level1_check
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: DEGREE, NANOTESLA
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_product, conjugate_quaternion, normalised
    use gracecg_base_spectrum, only: power_spectrum, HANN
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_base_vectors, only: cross, inverse_3x3
    use gracecg_environment_geomagnetic_field, only: igrf, igrf_t
    use gracecg_environment_time, only: utc_of_gps, decimal_year
    use gracecg_level1_folder, only: level1_folder_t
    use gracecg_level1_frames, only: ACCELEROMETER_AXES, srf_of_accelerometer, gracecg_quaternion, &
        continuous_quaternions, inertial_of_earth_fixed, inertial_of_earth_fixed_by_states, inertial_velocity
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_time, only: level1_clock_t, new_level1_clock, to_gps_time
    implicit none
    private
    public :: level1_check_t, check_row_t, check_level1

    integer, parameter :: NAME_LENGTH = 32
    integer, parameter :: MOST_RECORDS = 100000     !! Of a file: more are not looked at
    integer, parameter :: LONGEST_SEGMENT = 2048    !! Of a spectrum, samples
    real(dp), parameter :: LOW_BAND(2) = [0.15_dp, 0.6_dp], HIGH_BAND(2) = [2.0_dp, 5.0_dp]     !! Hz
    real(dp), parameter :: SAME_TAG = 1e-3_dp       !! Tags of 1A and 1B closer than that are of one sample, s
    character(1), parameter :: AXIS(3) = ['x', 'y', 'z']
    !> Inertia tensor about the proof mass, kg m^2: CSR-TM-00-01 section 5.2
    real(dp), parameter :: INERTIA(3, 3) = reshape([70.23_dp, -3.0_dp, -2.883_dp, -3.0_dp, 345.14_dp, -0.348_dp, &
                                                    -2.883_dp, -0.348_dp, 388.84_dp], [3, 3])
    integer, parameter :: GAIN_INTERVALS = 49       !! Of SCA1B, for the gain of the rods

    type :: check_row_t
        !! One number
        character(NAME_LENGTH) :: quantity = ''     !! Name
        real(dp) :: value = 0    !! In `unit`
        character(16) :: unit = ''                  !! Of the value; blank: none
        real(dp) :: allowed(2) = 0                  !! What such data have
    contains
        procedure :: is_usual                       !! The value is within
    end type check_row_t

    type :: level1_check_t
        !! All that was found
        type(check_row_t), allocatable :: rows(:)    !! The numbers
        type(string_t), allocatable :: warnings(:)  !! What could not be looked at, and what files say
    contains
        procedure :: add                            !! One more number
        procedure :: add_axes                       !! Three more, by axis
        procedure :: note                           !! One more warning, said once
    end type level1_check_t

    !> The products, read as they are needed
    type :: products_t
        type(level1_records_t) :: sca1b, gnv1b, gni1b, mag1b
        logical :: has_sca = .false., has_gnv = .false., has_gni = .false., has_mag = .false.
    end type products_t

contains

    elemental logical function is_usual(self)
        class(check_row_t), intent(in) :: self

        is_usual = self%value >= self%allowed(1) .and. self%value <= self%allowed(2)
    end function is_usual

    subroutine add(self, quantity, value, unit, low, high)
        class(level1_check_t), intent(inout) :: self
        character(*), intent(in) :: quantity, unit    !! Name and unit of the number
        real(dp), intent(in) :: value, low, high
        !! The number, and the range in which it is as it should be

        type(check_row_t) :: row

        row%quantity = quantity
        row%value = value
        row%unit = unit
        row%allowed = [low, high]
        self%rows = [self%rows, row]
    end subroutine add

    subroutine add_axes(self, quantity, values, unit, low, high)
        class(level1_check_t), intent(inout) :: self
        character(*), intent(in) :: quantity, unit      !! The axis follows behind _
        real(dp), intent(in) :: values(3), low, high    !! Of x, y, z, and the range of each

        integer :: i

        do i = 1, 3
            call self%add(quantity//'_'//AXIS(i), values(i), unit, low, high)
        end do
    end subroutine add_axes

    subroutine note(self, text)
        class(level1_check_t), intent(inout) :: self
        character(*), intent(in) :: text    !! A warning; the same is kept once

        integer :: i

        do i = 1, size(self%warnings)
            if (self%warnings(i)%text == text) return
        end do
        call append(self%warnings, text)
    end subroutine note

    !> Looks at the files of a folder. Products that are not there are left out; fails when a file is broken.
    subroutine check_level1(files, check, error)
        type(level1_folder_t), intent(in) :: files      !! See open_level1_folder
        type(level1_check_t), intent(out) :: check
        type(error_t), allocatable, intent(out) :: error

        type(products_t) :: products
        integer :: i

        allocate (check%rows(0), check%warnings(0))
        do i = 1, size(files%warnings)
            call check%note(files%warnings(i)%text)
        end do
        call check_accelerometer(files, check, error)
        if (.not. allocated(error)) call check_tags(files, check, error)
        if (.not. allocated(error)) call read_products(files, products, check, error)
        if (.not. allocated(error)) call check_attitude(products, check)
        if (.not. allocated(error)) call check_magnetometer(files, products, check, error)
        if (.not. allocated(error)) call check_gyros(files, check, error)
        if (.not. allocated(error)) call check_thrusters(files, check, error)
        if (.not. allocated(error)) call check_gas(files, check, error)
    end subroutine check_level1

    !> Reads the files of a product, if there are some, as far as they are looked at.
    subroutine take(files, product, records, found, check, error)
        type(level1_folder_t), intent(in) :: files
        character(5), intent(in) :: product
        type(level1_records_t), intent(out) :: records
        logical, intent(out) :: found
        type(level1_check_t), intent(inout) :: check
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: paths(:)
        integer :: i

        call files%paths_of(product, paths)
        found = size(paths) > 0
        if (.not. found) return
        call read_level1(paths, records, error, most=MOST_RECORDS)
        if (allocated(error)) return
        do i = 1, size(records%warnings)
            call check%note(product//': '//records%warnings(i)%text)
        end do
        if (records%count >= MOST_RECORDS) &
            call check%note(product//': the first '//integer_text(records%count)//' records are looked at')
        found = records%count > 0
    end subroutine take

    subroutine read_products(files, products, check, error)
        type(level1_folder_t), intent(in) :: files
        type(products_t), intent(inout) :: products
        type(level1_check_t), intent(inout) :: check
        type(error_t), allocatable, intent(out) :: error

        call take(files, 'SCA1B', products%sca1b, products%has_sca, check, error)
        if (.not. allocated(error)) call take(files, 'GNV1B', products%gnv1b, products%has_gnv, check, error)
        if (.not. allocated(error)) call take(files, 'GNI1B', products%gni1b, products%has_gni, check, error)
        if (.not. allocated(error)) call take(files, 'MAG1B', products%mag1b, products%has_mag, check, error)
    end subroutine read_products

    !> ACC1A: sampling, means, noise, quanta, in SRF.
    subroutine check_accelerometer(files, check, error)
        type(level1_folder_t), intent(in) :: files
        type(level1_check_t), intent(inout) :: check
        type(error_t), allocatable, intent(out) :: error

        type(level1_records_t) :: acc
        real(dp), allocatable :: times(:), linear(:, :), angular(:, :)
        real(dp) :: interval, values(3), sample(6)
        logical :: found
        integer :: i, first

        call take(files, 'ACC1A', acc, found, check, error)
        if (allocated(error) .or. .not. found) return
        call acc%times_since(acc%seconds(1), times)
        call check%add('acc1a_samples', real(acc%count, dp), '', 1.0_dp, huge(1.0_dp))
        if (acc%count < 3) return
        interval = (times(acc%count) - times(1))/(acc%count - 1)
        call check%add('acc1a_interval', interval, 's', 0.0999_dp, 0.1001_dp)
        call check%add('acc1a_largest_step', maxval(times(2:) - times(:acc%count - 1)), 's', 0.0999_dp, 0.15_dp)
        allocate (linear(acc%count, 3), angular(acc%count, 3))
        first = acc%field_of('lin_accl_x')
        do i = 1, acc%count
            sample = acc%values(i, first:first + 5)
            linear(i, :) = srf_of_accelerometer(sample(:3), ACCELEROMETER_AXES)
            angular(i, :) = srf_of_accelerometer(sample(4:), ACCELEROMETER_AXES)
        end do
        if (any(.not. abs(linear) < 1) .or. any(.not. abs(angular) < 1)) then
            call check%note('ACC1A: some records have not all six accelerations: no means or noise')
            return
        end if
        call check%add_axes('linear_mean', sum(linear, 1)/acc%count, 'm/s^2', -2e-5_dp, 2e-5_dp)
        do i = 1, 3
            values(i) = amplitude_density(times, linear(:, i), interval, LOW_BAND)
        end do
        call check%add_axes('linear_asd_0.15_0.6_hz', values, 'm/s^2/sqrt(Hz)', 2e-11_dp, 3e-9_dp)
        do i = 1, 3
            values(i) = amplitude_density(times, linear(:, i), interval, HIGH_BAND)
        end do
        call check%add_axes('linear_asd_2_5_hz', values, 'm/s^2/sqrt(Hz)', 1e-10_dp, 1e-8_dp)
        call check%add_axes('angular_mean', sum(angular, 1)/acc%count, 'rad/s^2', -2e-3_dp, 2e-3_dp)
        do i = 1, 3
            values(i) = amplitude_density(times, angular(:, i), interval, LOW_BAND)
        end do
        call check%add_axes('angular_asd_0.15_0.6_hz', values, 'rad/s^2/sqrt(Hz)', 1e-9_dp, 1e-6_dp)
        do i = 1, 3
            values(i) = quantum(angular(:, i))
        end do
        call check%add_axes('angular_quantum', values, 'rad/s^2', 1e-10_dp, 1e-7_dp)
    end subroutine check_accelerometer

    !> Root of the mean one-sided spectral density over a band.
    function amplitude_density(times, values, interval, band) result(density)
        real(dp), intent(in) :: times(:), values(:)     !! s, anything
        real(dp), intent(in) :: interval                !! Mean, s
        real(dp), intent(in) :: band(2)                 !! Hz
        real(dp) :: density

        real(dp), allocatable :: frequency(:), spectrum(:)
        integer :: i, n

        call power_spectrum([(i, i=1, size(values))], without_line(times, values), interval, &
                            longest_segment=min(size(values), LONGEST_SEGMENT), taper=HANN, frequency=frequency, &
                            density=spectrum)
        n = count(frequency >= band(1) .and. frequency <= band(2))
        density = 0
        if (n > 0) density = sqrt(2*sum(spectrum, mask=frequency >= band(1) .and. frequency <= band(2))/n)
    end function amplitude_density

    !> Values less the straight line through them.
    pure function without_line(times, values) result(rest)
        real(dp), intent(in) :: times(:), values(:)
        real(dp) :: rest(size(values))

        rest = values - sum(values)/size(values) - slope_of(times, values)*(times - sum(times)/size(times))
    end function without_line

    pure real(dp) function slope_of(times, values) result(slope)
        real(dp), intent(in) :: times(:), values(:)

        real(dp) :: t(size(times))

        t = times - sum(times)/size(times)
        slope = dot_product(t, values - sum(values)/size(values))/max(dot_product(t, t), tiny(1.0_dp))
    end function slope_of

    !> The least step between different values, made exact by their whole range.
    pure real(dp) function quantum(values)
        real(dp), intent(in) :: values(:)

        integer, parameter :: MOST = 2000
        real(dp), parameter :: ROUNDING = 1e-4_dp   ! of the step: values differ that much by rounding only
        real(dp) :: step, range
        integer :: i, k, n, rounds

        n = min(size(values), MOST)
        range = maxval(values(:n)) - minval(values(:n))
        quantum = 0
        if (range <= 0) return
        step = range
        do rounds = 1, 2
            do i = 1, n
                do k = i + 1, n
                    if (abs(values(k) - values(i)) > ROUNDING*step .and. abs(values(k) - values(i)) < step) &
                        step = abs(values(k) - values(i))
                end do
            end do
        end do
        quantum = range/anint(range/step)
    end function quantum

    !> Tags of 1A taken to GPS time against those of 1B. The first number is of CLK1B alone and of seconds held in
    !> double precision; the second of the whole chain, with TIM1B, exact to a nanosecond.
    subroutine check_tags(files, check, error)
        type(level1_folder_t), intent(in) :: files
        type(level1_check_t), intent(inout) :: check
        type(error_t), allocatable, intent(out) :: error

        character(3), parameter :: PRODUCTS(5) = ['MAG', 'TNK', 'IMU', 'THR', 'AHK']
        type(level1_records_t) :: clk1b, tim1b, a, b
        type(level1_clock_t) :: clock
        real(dp) :: rough, exact
        integer :: i, extrapolated, compared
        logical :: found, has_tim

        call take(files, 'CLK1B', clk1b, found, check, error)
        if (allocated(error) .or. .not. found) return
        call take(files, 'TIM1B', tim1b, has_tim, check, error)
        if (allocated(error)) return
        if (has_tim) then
            call new_level1_clock(clock, error, clk1b, tim1b)
        else
            call check%note('no TIM1B: time of the on-board computer is taken as that of the receiver')
            call new_level1_clock(clock, error, clk1b)
        end if
        if (allocated(error)) return
        do i = 1, size(PRODUCTS)
            call take(files, PRODUCTS(i)//'1A', a, found, check, error)
            if (allocated(error)) return
            if (.not. found) cycle
            call take(files, PRODUCTS(i)//'1B', b, found, check, error)
            if (allocated(error)) return
            if (.not. found .or. a%time_ref /= 'R') cycle
            call a%drop(clock%is_extrapolated(a%seconds))
            call compare_tags(a, b, clock, .true., rough, compared)
            call to_gps_time(a, clock, extrapolated)
            call compare_tags(a, b, clock, .false., exact, compared)
            if (compared == 0) cycle
            call check%add(lower(PRODUCTS(i))//'_tags_compared', real(compared, dp), '', 1.0_dp, huge(1.0_dp))
            call check%add(lower(PRODUCTS(i))//'_tags_difference', rough*1e6_dp, 'us', 0.0_dp, 1.5_dp)
            call check%add(lower(PRODUCTS(i))//'_tags_difference_chain', exact*1e6_dp, 'us', 0.0_dp, 1.5_dp)
        end do
    end subroutine check_tags

    pure character(3) function lower(name)
        character(3), intent(in) :: name

        integer :: i

        do i = 1, 3
            lower(i:i) = achar(iachar(name(i:i)) + 32)
        end do
    end function lower

    !> The largest difference between tags of 1A and the nearest of 1B, of those that have one.
    subroutine compare_tags(a, b, clock, rough, largest, compared)
        type(level1_records_t), intent(in) :: a         !! In GPS time, or, rough, of the on-board computer
        type(level1_records_t), intent(in) :: b
        type(level1_clock_t), intent(in) :: clock
        logical, intent(in) :: rough                    !! By CLK1B alone, with seconds in double precision
        real(dp), intent(out) :: largest                !! s
        integer, intent(out) :: compared

        real(dp) :: difference, other, tag
        integer :: i, k, last

        largest = 0
        compared = 0
        last = 1
        k = 1
        do i = 1, a%count
            tag = 0
            if (rough) then
                tag = real(a%seconds(i), dp) + a%fraction(i)
                do while (k < size(clock%receiver_seconds))
                    if (real(clock%receiver_seconds(k + 1), dp) > tag) exit
                    k = k + 1
                end do
                tag = (tag + clock%eps_time(k)) + clock%eps_drift(k)*(tag - real(clock%receiver_seconds(k), dp))
            end if
            difference = huge(1.0_dp)
            do while (last <= b%count)
                other = distance(last)
                if (abs(other) < abs(difference)) difference = other
                if (other <= 0 .or. last == b%count) exit
                last = last + 1
            end do
            last = max(1, last - 1)
            if (abs(difference) > SAME_TAG) cycle
            compared = compared + 1
            largest = max(largest, abs(difference))
        end do

    contains

        !> By how much tag i of 1A is later than tag j of 1B.
        real(dp) function distance(j)
            integer, intent(in) :: j

            if (rough) then
                distance = tag - (real(b%seconds(j), dp) + b%fraction(j))
            else
                distance = real(a%seconds(i) - b%seconds(j), dp) + (a%fraction(i) - b%fraction(j))
            end if
        end function distance
    end subroutine compare_tags

    !> SCA1B: rates and their noise; directions of the orbit in SRF.
    subroutine check_attitude(products, check)
        type(products_t), intent(in) :: products
        type(level1_check_t), intent(inout) :: check

        real(dp), allocatable :: rates(:, :)
        real(dp) :: position(3), velocity(3), attitude(3, 3)
        integer :: i, k, p, v, q

        if (.not. products%has_sca) return
        call rates_of(products%sca1b, rates)
        if (size(rates, 2) > 2) then
            call check%add_axes('sca1b_rate', sum(rates, 2)/size(rates, 2), 'rad/s', -2e-3_dp, 2e-3_dp)
            call check%add_axes('sca1b_rate_noise', sqrt(sum((rates(:, 2:) - rates(:, :size(rates, 2) - 1))**2, 2)/ &
                                                         (6*(size(rates, 2) - 1))), 'rad/s', 1e-9_dp, 1e-5_dp)
        end if
        q = products%sca1b%field_of('quatangle')
        do i = 1, products%sca1b%count
            if (products%has_gni) then
                k = findloc(products%gni1b%seconds == products%sca1b%seconds(i), .true., 1)
                if (k == 0) cycle
                p = products%gni1b%field_of('xpos')
                v = products%gni1b%field_of('xvel')
                position = products%gni1b%values(k, p:p + 2)
                velocity = products%gni1b%values(k, v:v + 2)
            else if (products%has_gnv) then
                k = findloc(products%gnv1b%seconds == products%sca1b%seconds(i), .true., 1)
                if (k == 0) cycle
                p = products%gnv1b%field_of('xpos')
                v = products%gnv1b%field_of('xvel')
                attitude = inertial_of_earth_fixed(utc_of_gps(products%gnv1b%seconds(k), 0.0_dp))
                position = matmul(attitude, products%gnv1b%values(k, p:p + 2))
                velocity = inertial_velocity(attitude, products%gnv1b%values(k, p:p + 2), products%gnv1b%values(k, v:v + 2))
            else
                return
            end if
            attitude = rotation_matrix(gracecg_quaternion(products%sca1b%values(i, q:q + 3)))
            position = matmul(attitude, position/norm2(position))
            velocity = matmul(attitude, velocity/norm2(velocity))
            call check%add('radial_x', position(1), '', -0.1_dp, 0.1_dp)
            call check%add('radial_y', position(2), '', -0.1_dp, 0.1_dp)
            call check%add('radial_z', position(3), '', -1.0_dp, -0.99_dp)
            call check%add('velocity_x', velocity(1), '', -1.0_dp, 1.0_dp)
            call check%add('velocity_y', velocity(2), '', -0.1_dp, 0.1_dp)
            call check%add('velocity_z', velocity(3), '', -0.1_dp, 0.1_dp)
            return
        end do
    end subroutine check_attitude

    !> Rates of the intervals that are not longer than usual, rad/s.
    subroutine rates_of(sca1b, rates)
        type(level1_records_t), intent(in) :: sca1b
        real(dp), allocatable, intent(out) :: rates(:, :)

        real(dp) :: turn(4), step, usual
        real(dp), allocatable :: times(:), q(:, :)
        integer :: i, n, first

        call sca1b%times_since(sca1b%seconds(1), times)
        first = sca1b%field_of('quatangle')
        allocate (q(4, sca1b%count), rates(3, max(0, sca1b%count - 1)))
        do i = 1, sca1b%count
            turn = sca1b%values(i, first:first + 3)
            q(:, i) = gracecg_quaternion(turn)
        end do
        call continuous_quaternions(q)
        usual = 1
        if (sca1b%count > 1) usual = minval(times(2:) - times(:sca1b%count - 1))
        n = 0
        do i = 1, sca1b%count - 1
            step = times(i + 1) - times(i)
            if (step > 1.5_dp*usual) cycle
            turn = quaternion_product(q(:, i + 1), conjugate_quaternion(q(:, i)))
            n = n + 1
            rates(:, n) = rotation_vector(turn)/step
        end do
        rates = rates(:, :n)
    end subroutine rates_of

    !> Axis times angle of a rotation by less than half a turn, rad.
    pure function rotation_vector(q) result(phi)
        real(dp), intent(in) :: q(4)        !! Scalar last, positive
        real(dp) :: phi(3)

        real(dp) :: sine

        sine = norm2(q(:3))
        phi = 2*q(:3)
        if (sine > 0) phi = 2*atan2(sine, q(4))/sine*q(:3)
    end function rotation_vector

    !> MAG1B: fields that are new, the difference to the IGRF, the currents, and the gain of the rods.
    subroutine check_magnetometer(files, products, check, error)
        type(level1_folder_t), intent(in) :: files
        type(products_t), intent(in) :: products
        type(level1_check_t), intent(inout) :: check
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: field(:, :), model(:, :), current(:, :)
        logical, allocatable :: known(:)
        real(dp) :: mean(3), deviation(3), gain, sigma
        integer :: i, first, n

        if (.not. products%has_mag) return
        n = products%mag1b%count
        allocate (field(3, n), model(3, n), current(3, n), known(n))
        first = products%mag1b%field_of('MfvX_RAW')
        do i = 1, n
            field(:, i) = products%mag1b%values(i, first:first + 2)*1e3_dp      ! uT to nT
            current(:, i) = abs(products%mag1b%values(i, first + 3:first + 5)) - &
                abs(products%mag1b%values(i, first + 6:first + 8))
        end do
        call check%add('mag1b_records', real(n, dp), '', 1.0_dp, huge(1.0_dp))
        call check%add('mag1b_new_fields', real(1 + count([(any(abs(field(:, i) - field(:, i - 1)) > 0), i=2, n)]), dp), '', &
                       1.0_dp, huge(1.0_dp))
        call model_field(products, model, known, error)
        if (allocated(error)) return
        if (count(known) > 1) then
            do i = 1, 3
                mean(i) = sum(field(i, :) - model(i, :), mask=known)/count(known)
                deviation(i) = sqrt(sum((field(i, :) - model(i, :) - mean(i))**2, mask=known)/count(known))
            end do
            call check%add_axes('field_difference', mean, 'nT', -4000.0_dp, 4000.0_dp)
            call check%add_axes('field_difference_deviation', deviation, 'nT', 0.0_dp, 1500.0_dp)
        end if
        do i = 1, 3
            call check%add('current_'//integer_text(i), sum(current(i, :))/n, 'mA', -130.0_dp, 130.0_dp)
        end do
        do i = 1, 3
            call check%add('current_largest_'//integer_text(i), maxval(abs(current(i, :))), 'mA', 0.0_dp, 130.0_dp)
        end do
        call find_gain(files, products, current, model, known, gain, sigma, check, error)
        if (allocated(error) .or. sigma <= 0) return
        call check%add('rod_gain', gain, 'A m^2/mA', 0.05_dp, 0.6_dp)
        call check%add('rod_gain_sigma', sigma, 'A m^2/mA', 0.0_dp, 0.1_dp)
    end subroutine check_magnetometer

    !> The IGRF of the 14th generation at the tags of MAG1B, along the axes of SRF, nT.
    subroutine model_field(products, field, known, error)
        type(products_t), intent(in) :: products
        real(dp), intent(out) :: field(:, :)    !! (3, records)
        logical, intent(out) :: known(:)        !! Orbit and attitude are there
        type(error_t), allocatable, intent(out) :: error

        type(igrf_t) :: model
        real(dp) :: position(3), velocity(3), b(3), q(4), c(3, 3), inertial(6), fixed(6)
        integer :: i
        logical :: ok

        known = .false.
        field = 0
        if (.not. (products%has_sca .and. products%has_gnv)) return
        call igrf('igrf14', decimal_year(utc_of_gps(products%mag1b%seconds(1), 0.0_dp)), model, error)
        if (allocated(error)) then
            call add_context(error, 'MAG1B')
            return
        end if
        do i = 1, products%mag1b%count
            associate (seconds => products%mag1b%seconds(i), fraction => products%mag1b%fraction(i))
                call state_at(products%gnv1b, seconds, fraction, fixed, ok)
                if (.not. ok) cycle
                call attitude_at(products%sca1b, seconds, fraction, q, ok)
                if (.not. ok) cycle
                position = fixed(:3)
                velocity = fixed(4:)
                if (products%has_gni) then
                    call state_at(products%gni1b, seconds, fraction, inertial, ok)
                    if (.not. ok) cycle
                    c = inertial_of_earth_fixed_by_states(inertial(:3), inertial(4:), position, velocity)
                else
                    c = inertial_of_earth_fixed(utc_of_gps(seconds, fraction))
                end if
            end associate
            call model%evaluate(position, b)
            field(:, i) = matmul(rotation_matrix(q), matmul(c, b))/NANOTESLA
            known(i) = .true.
        end do
    end subroutine model_field

    !> The record at or before a time; 0 when there is none, or none follows within two seconds.
    pure integer function interval_at(records, seconds) result(k)
        type(level1_records_t), intent(in) :: records
        integer(i8), intent(in) :: seconds

        integer :: above, middle

        k = 0
        above = records%count + 1
        do while (above - k > 1)
            middle = k + (above - k)/2
            if (records%seconds(middle) <= seconds) then
                k = middle
            else
                above = middle
            end if
        end do
        if (k == records%count) k = 0
        if (k > 0) then
            if (records%seconds(k + 1) - records%seconds(k) > 60) k = 0
        end if
    end function interval_at

    !> Position and velocity between two records: the cubic through both.
    subroutine state_at(records, seconds, fraction, state, ok)
        type(level1_records_t), intent(in) :: records   !! GNV1B or GNI1B, at whole seconds
        integer(i8), intent(in) :: seconds
        real(dp), intent(in) :: fraction
        real(dp), intent(out) :: state(6)               !! m, m/s
        logical, intent(out) :: ok

        real(dp) :: h, u, p0(3), p1(3), v0(3), v1(3)
        integer :: k, p, v

        state = 0
        k = interval_at(records, seconds)
        ok = k > 0
        if (.not. ok) return
        p = records%field_of('xpos')
        v = records%field_of('xvel')
        h = real(records%seconds(k + 1) - records%seconds(k), dp)
        u = (real(seconds - records%seconds(k), dp) + fraction)/h
        p0 = records%values(k, p:p + 2)
        p1 = records%values(k + 1, p:p + 2)
        v0 = records%values(k, v:v + 2)
        v1 = records%values(k + 1, v:v + 2)
        state(:3) = (1 + 2*u)*(1 - u)**2*p0 + u*(1 - u)**2*h*v0 + u**2*(3 - 2*u)*p1 - u**2*(1 - u)*h*v1
        state(4:) = 6*u*(1 - u)*(p1 - p0)/h + (1 - u)*(1 - 3*u)*v0 + u*(3*u - 2)*v1
        ok = all(abs(state) < huge(1.0_dp))
    end subroutine state_at

    !> Attitude between two records.
    subroutine attitude_at(records, seconds, fraction, q, ok)
        type(level1_records_t), intent(in) :: records   !! SCA1B, at whole seconds
        integer(i8), intent(in) :: seconds
        real(dp), intent(in) :: fraction
        real(dp), intent(out) :: q(4)                   !! Inertial to SRF, scalar last
        logical, intent(out) :: ok

        real(dp) :: pair(4, 2), u
        integer :: i, k, first

        q = 0
        k = interval_at(records, seconds)
        ok = k > 0
        if (.not. ok) return
        first = records%field_of('quatangle')
        do i = 1, 2
            q = records%values(k + i - 1, first:first + 3)
            pair(:, i) = gracecg_quaternion(q)
        end do
        call continuous_quaternions(pair)
        u = (real(seconds - records%seconds(k), dp) + fraction)/real(records%seconds(k + 1) - records%seconds(k), dp)
        q = normalised((1 - u)*pair(:, 1) + u*pair(:, 2))
    end subroutine attitude_at

    !> The gain of the rods, one for all: rates of SCA1B in the first 49 s against the integral of J^-1 (I x B), B the
    !> IGRF's, with a parabola by axis and a step at each thruster firing; weights by the noise of the rates.
    subroutine find_gain(files, products, current, field, known, gain, sigma, check, error)
        type(level1_folder_t), intent(in) :: files
        type(products_t), intent(in) :: products
        real(dp), intent(in) :: current(:, :), field(:, :)      !! (3, records of MAG1B): mA, nT
        logical, intent(in) :: known(:)
        real(dp), intent(out) :: gain, sigma                    !! A m^2/mA; sigma 0: not found
        type(level1_check_t), intent(inout) :: check
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: MOST_FIRINGS = 8
        type(level1_records_t) :: thr1b
        real(dp), allocatable :: rates(:, :), times(:), spin(:, :), a(:, :), y(:), solution(:), covariance(:, :)
        real(dp) :: noise(3), t, firing(MOST_FIRINGS), inverse(3, 3), acceleration(3), before(3), variance
        integer(i8) :: start
        integer :: n, i, k, j, axis_number, unknowns, firings, row, column
        logical :: found

        gain = 0
        sigma = 0
        if (products%sca1b%count <= GAIN_INTERVALS .or. .not. products%has_sca) return
        if (count(known) < size(known)/2 .or. size(known) < 10) return
        call rates_of(products%sca1b, rates)
        if (size(rates, 2) <= GAIN_INTERVALS) return
        noise = sqrt(sum((rates(:, 2:) - rates(:, :size(rates, 2) - 1))**2, 2)/(6*(size(rates, 2) - 1)))
        start = products%sca1b%seconds(1)
        if (products%sca1b%seconds(GAIN_INTERVALS + 1) - start /= GAIN_INTERVALS) return
        call products%mag1b%times_since(start, times)
        if (times(1) > 1 .or. times(size(times)) < GAIN_INTERVALS - 0.5_dp) return
        call take(files, 'THR1B', thr1b, found, check, error)
        if (allocated(error)) return
        firings = 0
        if (found) then
            do i = 1, thr1b%count
                t = real(thr1b%seconds(i) - start, dp) + thr1b%fraction(i)
                if (t < 0.5_dp .or. t > GAIN_INTERVALS - 0.5_dp .or. firings == MOST_FIRINGS) cycle
                firings = firings + 1
                firing(firings) = t
            end do
        end if
        ! The spin-up of a gain of one, by trapezoids between the tags of the currents.
        inverse = inverse_3x3(INERTIA)
        allocate (spin(3, size(times)))
        spin(:, 1) = 0
        before = matmul(inverse, cross(current(:, 1), field(:, 1)))*NANOTESLA
        do i = 2, size(times)
            acceleration = matmul(inverse, cross(current(:, i), field(:, i)))*NANOTESLA
            spin(:, i) = spin(:, i - 1) + 0.5_dp*(before + acceleration)*(times(i) - times(i - 1))
            before = acceleration
        end do
        n = GAIN_INTERVALS
        unknowns = 1 + 3*(3 + firings)
        allocate (a(3*n, unknowns), source=0.0_dp)
        allocate (y(3*n))
        do axis_number = 1, 3
            column = 2 + (axis_number - 1)*(3 + firings)
            do i = 1, n
                row = (axis_number - 1)*n + i
                t = i - 0.5_dp
                k = min(max(1, count(times <= t)), size(times) - 1)
                a(row, 1) = spin(axis_number, k) + (t - times(k))/(times(k + 1) - times(k))* &
                    (spin(axis_number, k + 1) - spin(axis_number, k))
                a(row, column:column + 2) = [((2*t/n - 1)**j, j=0, 2)]
                do j = 1, firings
                    a(row, column + 2 + j) = merge(1.0_dp, 0.0_dp, t > firing(j))
                end do
                a(row, :) = a(row, :)/noise(axis_number)
                y(row) = rates(axis_number, i)/noise(axis_number)
            end do
        end do
        call least_squares(a, y, solution, covariance, variance, error)
        if (allocated(error)) then
            deallocate (error)
            call check%note('the gain of the rods cannot be found from these spans')
            return
        end if
        gain = solution(1)
        sigma = sqrt(variance*covariance(1, 1))
    end subroutine find_gain

    !> Least squares by the normal equations.
    subroutine least_squares(a, y, solution, covariance, variance, error)
        real(dp), intent(in) :: a(:, :), y(:)
        real(dp), allocatable, intent(out) :: solution(:), covariance(:, :)
        real(dp), intent(out) :: variance       !! Of unit weight, from the residuals
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: condition, rest(size(y))

        variance = 0
        allocate (solution(size(a, 2)), covariance(size(a, 2), size(a, 2)))
        call solve_normal_equations(matmul(transpose(a), a), matmul(transpose(a), y), solution, covariance, condition, error)
        if (allocated(error)) return
        rest = y - matmul(a, solution)
        variance = dot_product(rest, rest)/(size(y) - size(a, 2))
    end subroutine least_squares

    !> IMU1A: rate of each gyro and what a straight line leaves of its angle.
    subroutine check_gyros(files, check, error)
        type(level1_folder_t), intent(in) :: files
        type(level1_check_t), intent(inout) :: check
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: GYROS = 4
        real(dp), parameter :: LONGEST = 30     ! s: a longer span is no straight line
        type(level1_records_t) :: imu
        real(dp), allocatable :: times(:), t(:), angle(:), rest(:)
        logical, allocatable :: mine(:)
        integer :: gyro
        logical :: found

        call take(files, 'IMU1A', imu, found, check, error)
        if (allocated(error) .or. .not. found) return
        call imu%times_since(imu%seconds(1), times)
        do gyro = 1, GYROS
            mine = nint(imu%values(:, imu%field_of('gyro_id'))) == gyro .and. times <= times(1) + LONGEST
            if (count(mine) < 3) cycle
            t = pack(times, mine)
            angle = pack(imu%values(:, imu%field_of('FiltAng')), mine)*DEGREE
            rest = without_line(t, angle)
            call check%add('gyro_'//integer_text(gyro)//'_rate', slope_of(t, angle), 'rad/s', -2e-3_dp, 2e-3_dp)
            call check%add('gyro_'//integer_text(gyro)//'_residual', sqrt(sum(rest**2)/size(rest)), 'rad', 0.0_dp, 1e-5_dp)
        end do
    end subroutine check_gyros

    !> THR1A: records, on-time of all attitude thrusters, firings of each.
    subroutine check_thrusters(files, check, error)
        type(level1_folder_t), intent(in) :: files
        type(level1_check_t), intent(inout) :: check
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: THRUSTERS = 12
        type(level1_records_t) :: thr
        integer :: first, i
        logical :: found

        call take(files, 'THR1A', thr, found, check, error)
        if (allocated(error) .or. .not. found) return
        first = thr%field_of('on_time_1')
        call check%add('thr1a_records', real(thr%count, dp), '', 0.0_dp, 20000.0_dp)
        call check%add('thr1a_on_time', sum(thr%values(:, first:first + THRUSTERS - 1))*1e-3_dp, 's', 0.0_dp, 2000.0_dp)
        do i = 1, THRUSTERS
            call check%add('thr1a_firings_'//integer_text(i), real(count(thr%values(:, first + i - 1) > 0), dp), '', 0.0_dp, &
                           20000.0_dp)
        end do
    end subroutine check_thrusters

    !> MAS1A, or without it MAS1B: gas used from each tank between the first and the last record that have it.
    subroutine check_gas(files, check, error)
        type(level1_folder_t), intent(in) :: files
        type(level1_check_t), intent(inout) :: check
        type(error_t), allocatable, intent(out) :: error

        type(level1_records_t) :: mas
        real(dp), allocatable :: mass(:)
        integer :: tank, column
        logical :: found

        call take(files, 'MAS1A', mas, found, check, error)
        if (allocated(error)) return
        if (.not. found) call take(files, 'MAS1B', mas, found, check, error)
        if (allocated(error) .or. .not. found) return
        do tank = 1, 2
            column = mas%field_of('gas_mass_tnk'//integer_text(tank))
            mass = pack(mas%values(:, column), abs(mas%values(:, column)) < huge(1.0_dp))
            if (size(mass) < 2) cycle
            call check%add('gas_used_'//integer_text(tank), mass(1) - mass(size(mass)), 'kg', 0.0_dp, 0.05_dp)
        end do
    end subroutine check_gas
end module gracecg_level1_check
