!> The numbers that tell whether a day of Level-1 data was understood, each with the range that such data have; and those of
!> attitude, orbit, magnetic field and rods.
!>
!> Rate of interval k: rotation vector of R(q_k+1) R(q_k)^T per second. Its noise: RMS of the differences of rates by
!> sqrt 6.
module gracecg_level1_check_attitude
    use gracecg_level1_basics
    use gracecg_environment_geomagnetic_field, only: igrf, igrf_t
    use gracecg_environment_time, only: decimal_year
    use gracecg_level1_frames, only: orbit_at, attitude_at, gracecg_quaternion, continuous_quaternions
    use gracecg_level1_folder, only: level1_folder_t
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_series, only: take_away
    implicit none
    private
    public :: level1_check_t, check_row_t, check_attitude_and_field

    integer, parameter :: MOST_RECORDS = 100000     !! Of a product: more are not looked at

    type :: check_row_t
        !! One number
        character(32) :: quantity = ''              !! Name
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
        type(level1_folder_t) :: files              !! That are looked at
        type(error_t), allocatable :: failure       !! The first one: nothing is read behind it
    contains
        procedure :: add                            !! One more number
        procedure :: add_axes                       !! Three more, by axis
        procedure :: note                           !! One more warning, said once
        procedure :: take                           !! Reads a product
    end type level1_check_t

    !> Inertia tensor about the proof mass, kg m^2: CSR-TM-00-01 section 5.2
    real(dp), parameter :: INERTIA(3, 3) = reshape([70.23_dp, -3.0_dp, -2.883_dp, -3.0_dp, 345.14_dp, -0.348_dp, &
                                                    -2.883_dp, -0.348_dp, 388.84_dp], [3, 3])
    integer, parameter :: GAIN_INTERVALS = 49       !! Of SCA1B, for the gain of the rods

contains

    elemental logical function is_usual(self)
        class(check_row_t), intent(in) :: self

        is_usual = self%value >= self%allowed(1) .and. self%value <= self%allowed(2)
    end function is_usual

    subroutine add(self, quantity, value, unit, low, high)
        class(level1_check_t), intent(inout) :: self
        character(*), intent(in) :: quantity, unit      !! Name and unit of the number
        real(dp), intent(in) :: value, low, high        !! The number, and the range in which it is as it should be

        self%rows = [self%rows, check_row_t(quantity, value, unit, [low, high])]
    end subroutine add

    subroutine add_axes(self, quantity, values, unit, low, high)
        class(level1_check_t), intent(inout) :: self
        character(*), intent(in) :: quantity, unit      !! The axis follows behind _
        real(dp), intent(in) :: values(3), low, high    !! Of x, y, z, and the range of each

        integer :: i

        do i = 1, 3
            call self%add(quantity//'_'//AXES(i), values(i), unit, low, high)
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

    !> Reads the files of a product, as far as they are looked at.
    subroutine take(self, product, records)
        class(level1_check_t), intent(inout) :: self
        character(5), intent(in) :: product                 !! 'ACC1A'
        type(level1_records_t), intent(out) :: records      !! None without files, and after a failure

        type(string_t), allocatable :: paths(:)
        integer :: i

        if (allocated(self%failure)) return
        call self%files%paths_of(product, paths)
        if (size(paths) == 0) return
        call read_level1(paths, records, self%failure, most=MOST_RECORDS)
        if (allocated(self%failure)) then
            records%count = 0
            return
        end if
        do i = 1, size(records%warnings)
            call self%note(product//': '//records%warnings(i)%text)
        end do
        if (records%count >= MOST_RECORDS) &
            call self%note(product//': the first '//integer_text(records%count)//' records are looked at')
    end subroutine take

    !> Looks at SCA1B, GNV1B, GNI1B, MAG1B.
    subroutine check_attitude_and_field(check)
        type(level1_check_t), intent(inout) :: check

        type(level1_records_t) :: sca1b, gnv1b, gni1b, mag1b

        call check%take('SCA1B', sca1b)
        call check%take('GNV1B', gnv1b)
        call check%take('GNI1B', gni1b)
        call check%take('MAG1B', mag1b)
        call check_attitude()
        call check_magnetometer()

    contains

        !> SCA1B: rates and their noise; directions of the orbit in SRF at the first epoch that has both.
        subroutine check_attitude()
            real(dp), allocatable :: rates(:, :)
            real(dp) :: inertial(6), fixed(6), c(3, 3), to_body(3, 3), radial(3), velocity(3)
            integer :: i, first
            logical :: ok

            if (sca1b%count == 0) return
            call rates_of(sca1b, rates)
            if (size(rates, 2) > 2) then
                call check%add_axes('sca1b_rate', sum(rates, 2)/size(rates, 2), 'rad/s', -2e-3_dp, 2e-3_dp)
                call check%add_axes('sca1b_rate_noise', noise_of(rates), 'rad/s', 1e-9_dp, 1e-5_dp)
            end if
            first = sca1b%field_of('quatangle')
            do i = 1, sca1b%count
                call orbit_at(gnv1b, gni1b, sca1b%seconds(i), sca1b%fraction(i), inertial, fixed, c, ok)
                if (.not. ok) cycle
                to_body = rotation_matrix(gracecg_quaternion(sca1b%values(i, first:first + 3)))
                radial = matmul(to_body, inertial(:3)/norm2(inertial(:3)))
                velocity = matmul(to_body, inertial(4:)/norm2(inertial(4:)))
                call check%add('radial_x', radial(1), '', -0.1_dp, 0.1_dp)
                call check%add('radial_y', radial(2), '', -0.1_dp, 0.1_dp)
                call check%add('radial_z', radial(3), '', -1.0_dp, -0.99_dp)
                call check%add('velocity_x', velocity(1), '', -1.0_dp, 1.0_dp)
                call check%add('velocity_y', velocity(2), '', -0.1_dp, 0.1_dp)
                call check%add('velocity_z', velocity(3), '', -0.1_dp, 0.1_dp)
                return
            end do
        end subroutine check_attitude

        !> MAG1B: fields that are new, the difference to the IGRF, the currents, and the gain of the rods.
        subroutine check_magnetometer()
            real(dp), parameter :: NOT_TOLD = 0.1_dp    ! Sigma of a gain, A m^2/mA, chosen: usual ones are 0.2 to 0.25
            real(dp), allocatable :: field(:, :), model(:, :), current(:, :)
            logical, allocatable :: known(:)
            real(dp) :: mean(3), deviation(3), gain, sigma
            integer :: i, first, n

            n = mag1b%count
            if (n == 0) return
            first = mag1b%field_of('MfvX_RAW')
            field = transpose(mag1b%values(:, first:first + 2))*1e3_dp        ! uT to nT
            current = transpose(abs(mag1b%values(:, first + 3:first + 5)) - &
                                abs(mag1b%values(:, first + 6:first + 8)))
            call check%add('mag1b_records', real(n, dp), '', 1.0_dp, huge(1.0_dp))
            call check%add('mag1b_new_fields', real(1 + count(any(abs(field(:, 2:) - field(:, :n - 1)) > 0, 1)), dp), '', &
                           1.0_dp, huge(1.0_dp))
            call model_field(model, known)
            if (allocated(check%failure)) return
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
            if (count(known) < n/2 .or. n < 10 .or. sca1b%count <= GAIN_INTERVALS) return
            call find_gain(current, model, gain, sigma)
            if (sigma <= 0) return
            if (sigma > NOT_TOLD) then
                call check%note('MAG1B: currents of its beginning are too small to tell the gain of the rods')
                return
            end if
            call check%add('rod_gain', gain, 'A m^2/mA', 0.05_dp - 3*sigma, 0.6_dp + 3*sigma)
            call check%add('rod_gain_sigma', sigma, 'A m^2/mA', 0.0_dp, NOT_TOLD)
        end subroutine check_magnetometer

        !> The IGRF of the 14th generation at the tags of MAG1B, along the axes of SRF, nT.
        subroutine model_field(field, known)
            real(dp), allocatable, intent(out) :: field(:, :)   !! (3, records)
            logical, allocatable, intent(out) :: known(:)       !! Orbit and attitude are there

            type(igrf_t) :: model
            real(dp) :: b(3), q(4), c(3, 3), inertial(6), fixed(6)
            integer :: i

            allocate (known(mag1b%count), source=.false.)
            allocate (field(3, mag1b%count), source=0.0_dp)
            if (sca1b%count == 0 .or. gnv1b%count == 0) return
            call igrf('igrf14', decimal_year(utc_of_gps(mag1b%seconds(1), 0.0_dp)), model, check%failure)
            call add_context(check%failure, 'MAG1B')
            if (allocated(check%failure)) return
            do i = 1, mag1b%count
                call attitude_at(sca1b, mag1b%seconds(i), mag1b%fraction(i), q, known(i))
                if (known(i)) call orbit_at(gnv1b, gni1b, mag1b%seconds(i), mag1b%fraction(i), inertial, fixed, c, &
                                            known(i))
                if (.not. known(i)) cycle
                call model%evaluate(fixed(:3), b)
                field(:, i) = matmul(rotation_matrix(q), matmul(c, b))/NANOTESLA
            end do
        end subroutine model_field

        !> The gain of the rods, one for all: rates of SCA1B in the first 49 s against the integral of J^-1 (I x B), B the
        !> IGRF's, each less a parabola and a step at each thruster firing by axis; weights by the noise of the rates.
        subroutine find_gain(current, field, gain, sigma)
            real(dp), intent(in) :: current(:, :), field(:, :)      !! (3, records of MAG1B): mA, nT
            real(dp), intent(out) :: gain, sigma                    !! A m^2/mA; sigma 0: not found

            integer, parameter :: MOST_FIRINGS = 8
            type(level1_records_t) :: thr1b
            type(error_t), allocatable :: error
            real(dp), allocatable :: rates(:, :), times(:), spin(:, :), basis(:, :), firings(:)
            real(dp) :: noise(3), middle(GAIN_INTERVALS), seen(GAIN_INTERVALS, 3), made(GAIN_INTERVALS, 3)
            integer(i8) :: start
            integer :: i, k

            gain = 0
            sigma = 0
            call rates_of(sca1b, rates)
            start = sca1b%seconds(1)
            if (size(rates, 2) <= GAIN_INTERVALS) return
            if (sca1b%seconds(GAIN_INTERVALS + 1) - start /= GAIN_INTERVALS) return
            call mag1b%times_since(start, times)
            if (times(1) > 1 .or. times(size(times)) < GAIN_INTERVALS - 0.5_dp) return
            call check%take('THR1B', thr1b)
            if (allocated(check%failure)) return
            allocate (firings(0))
            if (thr1b%count > 0) call thr1b%times_since(start, firings)
            firings = pack(firings, firings >= 0.5_dp .and. firings <= GAIN_INTERVALS - 0.5_dp)
            firings = firings(:min(size(firings), MOST_FIRINGS))
            call spin_up(times, current, field, spin)
            middle = [(i - 0.5_dp, i=1, GAIN_INTERVALS)]
            do i = 1, GAIN_INTERVALS
                k = min(max(1, last_not_after(times, middle(i))), size(times) - 1)
                made(i, :) = spin(:, k) + (middle(i) - times(k))/(times(k + 1) - times(k))*(spin(:, k + 1) - spin(:, k))
            end do
            allocate (basis(3 + size(firings), GAIN_INTERVALS))
            do i = 0, 2
                basis(1 + i, :) = (2*middle/GAIN_INTERVALS - 1)**i
            end do
            do i = 1, size(firings)
                basis(3 + i, :) = merge(1.0_dp, 0.0_dp, middle > firings(i))
            end do
            noise = noise_of(rates)
            seen = transpose(rates(:, :GAIN_INTERVALS))
            do i = 1, 3
                call take_away(basis, made(:, i), error)
                if (.not. allocated(error)) call take_away(basis, seen(:, i), error)
                if (allocated(error)) then
                    call check%note('the gain of the rods cannot be found from these spans')
                    return
                end if
                made(:, i) = made(:, i)/noise(i)
                seen(:, i) = seen(:, i)/noise(i)
            end do
            gain = sum(made*seen)/sum(made**2)
            sigma = norm2(seen - gain*made)/norm2(made)/sqrt(real(size(seen) - 1 - 3*size(basis, 1), dp))
        end subroutine find_gain
    end subroutine check_attitude_and_field

    !> Rates of the intervals that are not longer than usual, (3, n), rad/s.
    subroutine rates_of(sca1b, rates)
        type(level1_records_t), intent(in) :: sca1b
        real(dp), allocatable, intent(out) :: rates(:, :)

        real(dp) :: step, usual
        real(dp), allocatable :: times(:), q(:, :)
        integer :: i, n, first

        n = sca1b%count
        call sca1b%times_since(sca1b%seconds(1), times)
        first = sca1b%field_of('quatangle')
        allocate (q(4, n))
        do i = 1, n
            q(:, i) = gracecg_quaternion(sca1b%values(i, first:first + 3))
        end do
        call continuous_quaternions(q)
        usual = 1
        if (n > 1) usual = minval(times(2:) - times(:n - 1))
        allocate (rates(3, count(times(2:) - times(:n - 1) <= 1.5_dp*usual)))
        n = 0
        do i = 1, sca1b%count - 1
            step = times(i + 1) - times(i)
            if (step > 1.5_dp*usual) cycle
            n = n + 1
            rates(:, n) = rotation_between(q(:, i), q(:, i + 1))/step
        end do
    end subroutine rates_of

    pure function noise_of(rates) result(noise)
        real(dp), intent(in) :: rates(:, :)
        real(dp) :: noise(3)

        integer :: n

        n = size(rates, 2)
        noise = sqrt(sum((rates(:, 2:) - rates(:, :n - 1))**2, 2)/(6*(n - 1)))
    end function noise_of

    !> The rate that rods of a gain of one give from the first tag on, by trapezoids.
    subroutine spin_up(times, current, field, spin)
        real(dp), intent(in) :: times(:)                        !! s
        real(dp), intent(in) :: current(:, :), field(:, :)      !! (3, times): mA, nT
        real(dp), allocatable, intent(out) :: spin(:, :)        !! (3, times), rad/s by A m^2/mA

        real(dp) :: acceleration(3, size(times)), inverse(3, 3)
        integer :: i

        inverse = inverse_3x3(INERTIA)
        do i = 1, size(times)
            acceleration(:, i) = matmul(inverse, cross(current(:, i), field(:, i)))*NANOTESLA
        end do
        allocate (spin(3, size(times)), source=0.0_dp)
        do i = 2, size(times)
            spin(:, i) = spin(:, i - 1) + 0.5_dp*(acceleration(:, i - 1) + acceleration(:, i))*(times(i) - times(i - 1))
        end do
    end subroutine spin_up
end module gracecg_level1_check_attitude
