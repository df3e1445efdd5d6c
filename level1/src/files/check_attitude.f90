!> Attitude, orbit, magnetic field and rods of a day of Level-1 data, in numbers with a verdict each.
!>
!> Rate of interval k: rotation vector of R(q_k+1) R(q_k)^T per second. Its noise: RMS of the differences of rates by
!> sqrt 6.
module gracecg_level1_check_attitude
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: NANOTESLA
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_base_quaternion, only: rotation_matrix, rotation_between
    use gracecg_base_text, only: integer_text
    use gracecg_base_vectors, only: cross, inverse_3x3
    use gracecg_environment_geomagnetic_field, only: igrf, igrf_t
    use gracecg_environment_time, only: utc_of_gps, decimal_year
    use gracecg_level1_between_records, only: orbit_at, attitude_at
    use gracecg_level1_check_rows, only: level1_check_t
    use gracecg_level1_frames, only: gracecg_quaternion, continuous_quaternions
    use gracecg_level1_records, only: level1_records_t
    implicit none
    private
    public :: check_attitude_and_field

    !> Inertia tensor about the proof mass, kg m^2: CSR-TM-00-01 section 5.2
    real(dp), parameter :: INERTIA(3, 3) = reshape([70.23_dp, -3.0_dp, -2.883_dp, -3.0_dp, 345.14_dp, -0.348_dp, &
                                                    -2.883_dp, -0.348_dp, 388.84_dp], [3, 3])
    integer, parameter :: GAIN_INTERVALS = 49       !! Of SCA1B, for the gain of the rods

    !> The products, as far as there are some
    type :: products_t
        type(level1_records_t) :: sca1b, gnv1b, gni1b, mag1b
    end type products_t

contains

    !> Looks at SCA1B, GNV1B, GNI1B, MAG1B.
    subroutine check_attitude_and_field(check)
        type(level1_check_t), intent(inout) :: check

        type(products_t) :: products

        call check%take('SCA1B', products%sca1b)
        call check%take('GNV1B', products%gnv1b)
        call check%take('GNI1B', products%gni1b)
        call check%take('MAG1B', products%mag1b)
        call check_attitude(products, check)
        call check_magnetometer(products, check)
    end subroutine check_attitude_and_field

    !> SCA1B: rates and their noise; directions of the orbit in SRF at the first epoch that has both.
    subroutine check_attitude(products, check)
        type(products_t), intent(in) :: products
        type(level1_check_t), intent(inout) :: check

        real(dp), allocatable :: rates(:, :)
        real(dp) :: inertial(6), fixed(6), c(3, 3), to_body(3, 3), radial(3), velocity(3)
        integer :: i, first
        logical :: ok

        if (products%sca1b%count == 0) return
        call rates_of(products%sca1b, rates)
        if (size(rates, 2) > 2) then
            call check%add_axes('sca1b_rate', sum(rates, 2)/size(rates, 2), 'rad/s', -2e-3_dp, 2e-3_dp)
            call check%add_axes('sca1b_rate_noise', noise_of(rates), 'rad/s', 1e-9_dp, 1e-5_dp)
        end if
        first = products%sca1b%field_of('quatangle')
        do i = 1, products%sca1b%count
            call orbit_at(products%gnv1b, products%gni1b, products%sca1b%seconds(i), products%sca1b%fraction(i), inertial, &
                          fixed, c, ok)
            if (.not. ok) cycle
            to_body = rotation_matrix(gracecg_quaternion(products%sca1b%values(i, first:first + 3)))
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

    !> MAG1B: fields that are new, the difference to the IGRF, the currents, and the gain of the rods.
    subroutine check_magnetometer(products, check)
        type(products_t), intent(in) :: products
        type(level1_check_t), intent(inout) :: check

        real(dp), allocatable :: field(:, :), model(:, :), current(:, :)
        logical, allocatable :: known(:)
        real(dp) :: mean(3), deviation(3), gain, sigma
        integer :: i, first, n

        n = products%mag1b%count
        if (n == 0) return
        first = products%mag1b%field_of('MfvX_RAW')
        field = transpose(products%mag1b%values(:, first:first + 2))*1e3_dp        ! uT to nT
        current = transpose(abs(products%mag1b%values(:, first + 3:first + 5)) - &
                            abs(products%mag1b%values(:, first + 6:first + 8)))
        call check%add('mag1b_records', real(n, dp), '', 1.0_dp, huge(1.0_dp))
        call check%add('mag1b_new_fields', real(1 + count(any(abs(field(:, 2:) - field(:, :n - 1)) > 0, 1)), dp), '', &
                       1.0_dp, huge(1.0_dp))
        call model_field(products, model, known, check%failure)
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
        if (count(known) < n/2 .or. n < 10 .or. products%sca1b%count <= GAIN_INTERVALS) return
        call find_gain(products, current, model, gain, sigma, check)
        if (sigma <= 0) return
        ! a gain that the file does not tell is not unusual
        call check%add('rod_gain', gain, 'A m^2/mA', 0.05_dp - 3*sigma, 0.6_dp + 3*sigma)
        call check%add('rod_gain_sigma', sigma, 'A m^2/mA', 0.0_dp, huge(sigma))
    end subroutine check_magnetometer

    !> The IGRF of the 14th generation at the tags of MAG1B, along the axes of SRF, nT.
    subroutine model_field(products, field, known, error)
        type(products_t), intent(in) :: products
        real(dp), allocatable, intent(out) :: field(:, :)   !! (3, records)
        logical, allocatable, intent(out) :: known(:)       !! Orbit and attitude are there
        type(error_t), allocatable, intent(out) :: error

        type(igrf_t) :: model
        real(dp) :: b(3), q(4), c(3, 3), inertial(6), fixed(6)
        integer :: i

        associate (mag => products%mag1b)
            allocate (known(mag%count), source=.false.)
            allocate (field(3, mag%count), source=0.0_dp)
            if (products%sca1b%count == 0 .or. products%gnv1b%count == 0) return
            call igrf('igrf14', decimal_year(utc_of_gps(mag%seconds(1), 0.0_dp)), model, error)
            call add_context(error, 'MAG1B')
            if (allocated(error)) return
            do i = 1, mag%count
                call attitude_at(products%sca1b, mag%seconds(i), mag%fraction(i), q, known(i))
                if (known(i)) call orbit_at(products%gnv1b, products%gni1b, mag%seconds(i), mag%fraction(i), inertial, fixed, &
                                            c, known(i))
                if (.not. known(i)) cycle
                call model%evaluate(fixed(:3), b)
                field(:, i) = matmul(rotation_matrix(q), matmul(c, b))/NANOTESLA
            end do
        end associate
    end subroutine model_field

    !> The gain of the rods, one for all: rates of SCA1B in the first 49 s against the integral of J^-1 (I x B), B the
    !> IGRF's, each less a parabola and a step at each thruster firing by axis; weights by the noise of the rates.
    subroutine find_gain(products, current, field, gain, sigma, check)
        type(products_t), intent(in) :: products
        real(dp), intent(in) :: current(:, :), field(:, :)      !! (3, records of MAG1B): mA, nT
        real(dp), intent(out) :: gain, sigma                    !! A m^2/mA; sigma 0: not found
        type(level1_check_t), intent(inout) :: check

        integer, parameter :: MOST_FIRINGS = 8
        type(level1_records_t) :: thr1b
        type(error_t), allocatable :: error
        real(dp), allocatable :: rates(:, :), times(:), spin(:, :), basis(:, :), firings(:)
        real(dp) :: noise(3), middle(GAIN_INTERVALS), seen(GAIN_INTERVALS, 3), made(GAIN_INTERVALS, 3)
        integer(i8) :: start
        integer :: i, k

        gain = 0
        sigma = 0
        call rates_of(products%sca1b, rates)
        start = products%sca1b%seconds(1)
        if (size(rates, 2) <= GAIN_INTERVALS) return
        if (products%sca1b%seconds(GAIN_INTERVALS + 1) - start /= GAIN_INTERVALS) return
        call products%mag1b%times_since(start, times)
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

    !> What the best combination of a basis leaves of some values. Fails when the basis is not independent.
    subroutine take_away(basis, values, error)
        real(dp), intent(in) :: basis(:, :)             !! (function, value)
        real(dp), intent(inout) :: values(:)
        type(error_t), allocatable, intent(out) :: error

        real(dp), dimension(size(basis, 1), size(basis, 1)) :: normal, covariance
        real(dp), dimension(size(basis, 1)) :: rhs, coefficients
        real(dp) :: condition

        call normal_equations(basis, values, normal, rhs)
        call solve_normal_equations(normal, rhs, coefficients, covariance, condition, error)
        if (.not. allocated(error)) values = values - matmul(coefficients, basis)
    end subroutine take_away
end module gracecg_level1_check_attitude
