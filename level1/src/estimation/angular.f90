!> The angular acceleration in the spans of a calibration, from sources that check each other: the torque of the rods,
!> the accelerometer's angular channels (raw, or calibrated by the torque), the star cameras, the gyros.
module gracecg_level1_angular
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations, symmetric_eigen
    use gracecg_base_vectors, only: inverse_3x3, determinant_3x3
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_attitude, only: rod_calibration_t, rod_accelerations, known_acceleration, slow_quantities
    use gracecg_level1_basis, only: band_basis, orthonormalise, polynomial_columns, polynomial_curvature
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t
    use gracecg_level1_drive, only: level1_drive_t, join
    implicit none
    private
    public :: level1_motion_t, angular_calibration_t, rod_motion, calibrate_angular_channels, gains_by_channels, channels_at
    public :: differentiate_attitude, band_columns, NUISANCE_DEGREE

    integer, parameter :: NUISANCE_DEGREE = 2       !! Of the polynomial of each axis and span
    real(dp), parameter :: HIGHEST_LINE = 0.16_dp   !! Of the attitude's fit, Hz
    integer, parameter :: FIT_DEGREE = 5

    type :: level1_motion_t
        !! What a span's observation equations need, at the samples of the accelerometer
        real(dp), allocatable :: current(:, :)      !! mA
        real(dp), allocatable :: current_rate(:, :) !! mA/s
        real(dp), allocatable :: by_rod(:, :, :)    !! Angular acceleration of each rod, gains applied: axis, rod, sample
        real(dp), allocatable :: by_field(:, :, :)  !! Its change by 1 T in x, y, z of the field
        real(dp), allocatable :: torque(:, :)       !! Angular acceleration by all torques, rad/s^2
        real(dp), allocatable :: field(:, :)        !! Of the Earth, T
        real(dp), allocatable :: rate(:, :)         !! rad/s
        real(dp), allocatable :: up(:, :)    !! Unit vector from the Earth's centre, SRF
        real(dp), allocatable :: gradient(:)        !! 1/s^2
        real(dp), allocatable :: band(:, :)         !! Orthonormal basis of the band without polynomial and ends: sample, column
    end type level1_motion_t

    type :: angular_calibration_t
        !! What the angular channels are of the torque's acceleration
        logical :: separable = .false.          !! Matrix and leakage are estimated; else one common scale
        real(dp) :: scale(3, 3) = 0             !! S
        real(dp) :: leakage(3, 3) = 0           !! La: axis, rod; rad/s^2/mA
        real(dp) :: leakage_rate(3, 3) = 0      !! Ka: rad/s^2/(mA/s)
        real(dp) :: squares = 0                 !! Of the residuals, each axis by its variance
        real(dp) :: residual(3) = 0             !! RMS in the band, rad/s^2
        real(dp) :: explained(3) = 0            !! Share of the variance
        real(dp) :: common = 0                  !! The common scale
        real(dp) :: condition = 0    !! Of the normal matrix
    end type angular_calibration_t

contains

    !> An orthonormal basis of the band at a span's samples, without its polynomial and its ends.
    subroutine band_columns(times, band, columns)
        real(dp), intent(in) :: times(:)            !! s
        real(dp), intent(in) :: band(2)             !! Hz
        real(dp), allocatable, intent(out) :: columns(:, :)    !! Sample, column

        real(dp) :: unwanted(size(times), NUISANCE_DEGREE + 2)
        real(dp), allocatable :: basis(:, :), nuisance(:, :)
        integer :: k

        call band_basis(times, band(1), band(2), basis)
        call polynomial_columns(times, NUISANCE_DEGREE, unwanted(:, :NUISANCE_DEGREE + 1))
        ! Noise above the band, cut off at both ends, comes into it: int y cos(2 pi k t/T) dt has the difference of int y dt at
        ! the ends, alike for all k, as a sample there would have it.
        unwanted(:, NUISANCE_DEGREE + 2) = 0
        unwanted([1, size(times)], NUISANCE_DEGREE + 2) = 1
        ! The polynomial and the ends as the band sees them are estimated with the rest: what remains of the band is used.
        nuisance = matmul(transpose(basis), unwanted)
        call orthonormalise(nuisance)
        allocate (columns(size(times), size(basis, 2)))
        columns = basis
        do k = 1, size(nuisance, 2)
            columns = columns - matmul(reshape(matmul(basis, nuisance(:, k)), [size(times), 1]), &
                                       reshape(nuisance(:, k), [1, size(basis, 2)]))
        end do
        call orthonormalise(columns)
        if (size(columns, 2) > size(basis, 2) - size(nuisance, 2)) columns = columns(:, :size(basis, 2) - size(nuisance, 2))
    end subroutine band_columns

    !> Currents, torques and slow quantities at a span's samples, which lie `delay` behind what they show.
    subroutine rod_motion(span, setup, drive, rods, delay, motion)
        type(level1_span_t), intent(in) :: span
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(in) :: drive
        type(rod_calibration_t), intent(in) :: rods
        real(dp), intent(in) :: delay               !! Of the accelerometer, s
        type(level1_motion_t), intent(inout) :: motion

        real(dp) :: slow(10), response(3, 3), unit_field(3)
        integer :: i, k, n

        n = size(span%time)
        if (allocated(motion%current)) then
            if (size(motion%current, 2) /= n) deallocate (motion%current, motion%current_rate, motion%by_rod, &
                                                         motion%by_field, motion%torque, motion%field, motion%rate, motion%up, &
                                                         motion%gradient)
        end if
        if (.not. allocated(motion%current)) &
            allocate (motion%current(3, n), motion%current_rate(3, n), motion%by_rod(3, 3, n), motion%by_field(3, 3, n), &
                      motion%torque(3, n), motion%field(3, n), motion%rate(3, n), motion%up(3, n), motion%gradient(n))
        do i = 1, n
            call drive%at(span%time(i) - delay - rods%delay, motion%current(:, i), motion%current_rate(:, i))
        end do
        if (allocated(span%joined)) then
            do i = 1, n - 1
                if (.not. span%joined(i)) cycle
                call join(motion%current(:, i:i + 1))
                call join(motion%current_rate(:, i:i + 1))
            end do
        end if
        do i = 1, n
            call slow_quantities(span, span%time(i) - delay, slow)
            motion%field(:, i) = slow(1:3)
            motion%rate(:, i) = slow(4:6)
            motion%up(:, i) = slow(7:9)
            motion%gradient(i) = slow(10)
            response = rod_accelerations(setup, slow(1:3))
            do k = 1, 3
                motion%by_rod(:, k, i) = rods%gain(k)*response(:, k)*motion%current(k, i)
            end do
            do k = 1, 3
                unit_field = 0
                unit_field(k) = 1
                motion%by_field(:, k, i) = matmul(rod_accelerations(setup, unit_field), rods%gain*motion%current(:, i))
            end do
            motion%torque(:, i) = sum(motion%by_rod(:, :, i), 2) + known_acceleration(setup, slow(4:6), slow(7:9), slow(10))
        end do
    end subroutine rod_motion

    !> Matrix S and leakage of the angular channels by least squares against the torque, in the band, over all spans:
    !> ang = S wd + La I + Ka dI/dt. Where wd and the currents cannot be told apart: one common scale.
    subroutine calibrate_angular_channels(calibration, motion, driven, result, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_motion_t), intent(in) :: motion(:)      !! Of each span
        logical, intent(in) :: driven(3)                    !! Rods
        type(angular_calibration_t), intent(out) :: result
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: WORST = 1e4_dp               ! Condition number with which S and La are told apart
        real(dp), allocatable :: rows(:, :), observed(:, :), normal(:, :), rhs(:), x(:), covariance(:, :), scaled(:, :), &
            values(:), vectors(:, :)
        integer, allocatable :: number(:)
        real(dp) :: condition, total(3), product(3), square(3), left
        integer :: i, k, axis, n, parameters, rods
        logical :: driven_axis(3)

        number = pack([1, 2, 3], driven)
        rods = size(number)
        call band_rows(calibration, motion, number, rows, observed)
        parameters = size(rows, 1)
        n = size(rows, 2)
        allocate (normal(parameters, parameters), rhs(parameters), x(parameters), covariance(parameters, parameters))
        total = sum(observed**2, 1)
        call normal_equations(rows, observed(:, 1), normal, rhs)
        driven_axis = [(normal(k, k) > 0, k=1, 3)]
        scaled = normal
        do i = 1, parameters
            do k = 1, parameters
                if (normal(i, i) > 0 .and. normal(k, k) > 0) scaled(k, i) = normal(k, i)/sqrt(normal(i, i)*normal(k, k))
            end do
        end do
        allocate (values(parameters), vectors(parameters, parameters))
        call symmetric_eigen(scaled, values, vectors, error)
        if (allocated(error)) return
        result%condition = huge(1.0_dp)
        if (values(1) > values(parameters)*epsilon(1.0_dp)) result%condition = values(parameters)/values(1)
        result%separable = result%condition < WORST .and. all(driven_axis)
        product = [(sum(rows(axis, :)*observed(:, axis)), axis=1, 3)]
        square = [(sum(rows(axis, :)**2), axis=1, 3)]
        result%common = sum(product/max(total, tiny(1.0_dp)))/sum(square/max(total, tiny(1.0_dp)))
        if (.not. result%separable) then
            do axis = 1, 3
                result%scale(axis, axis) = result%common
            end do
        else
            do axis = 1, 3
                call normal_equations(rows, observed(:, axis), normal, rhs)
                call solve_normal_equations(normal, rhs, x, covariance, condition, error)
                if (allocated(error)) return
                result%scale(axis, :) = x(1:3)
                do k = 1, rods
                    result%leakage(axis, number(k)) = x(3 + k)
                    result%leakage_rate(axis, number(k)) = x(3 + rods + k)
                end do
            end do
        end if
        do axis = 1, 3
            left = 0
            do k = 1, n
                left = left + (observed(k, axis) - dot_product(rows(1:3, k), result%scale(axis, :)) - &
                               dot_product(rows(4:3 + rods, k), result%leakage(axis, number)) - &
                               dot_product(rows(4 + rods:, k), result%leakage_rate(axis, number)))**2
            end do
            result%explained(axis) = 1 - left/max(total(axis), tiny(1.0_dp))
            result%residual(axis) = sqrt(left/n)
            result%squares = result%squares + log(max(left, tiny(left)))*n
        end do
    end subroutine calibrate_angular_channels

    !> Of all spans in the band: wd, currents of some rods and their rates (a row each), and the angular channels.
    pure subroutine band_rows(calibration, motion, number, rows, observed)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_motion_t), intent(in) :: motion(:)
        integer, intent(in) :: number(:)                            !! Of the rods
        real(dp), allocatable, intent(out) :: rows(:, :)            !! Parameter, band column
        real(dp), allocatable, intent(out) :: observed(:, :)        !! Band column, axis

        integer :: i, first, last, rods

        rods = size(number)
        last = 0
        do i = 1, size(motion)
            if (calibration%spans(i)%used) last = last + size(motion(i)%band, 2)
        end do
        allocate (rows(3 + 2*rods, last), observed(last, 3))
        last = 0
        do i = 1, size(motion)
            if (.not. calibration%spans(i)%used) cycle
            first = last + 1
            last = last + size(motion(i)%band, 2)
            rows(1:3, first:last) = matmul(motion(i)%torque, motion(i)%band)
            rows(4:3 + rods, first:last) = matmul(motion(i)%current(number, :), motion(i)%band)
            rows(4 + rods:, first:last) = matmul(motion(i)%current_rate(number, :), motion(i)%band)
            observed(first:last, :) = transpose(matmul(calibration%spans(i)%angular, motion(i)%band))
        end do
    end subroutine band_rows

    !> Relative changes e of the gains that the angular channels ask for, with S, La and Ka of `result`: information N and
    !> right-hand side b of N e = b, where matrix and leakage go along, and the field's error of each span by axis, with
    !> its sigma,
    !>
    !>     ang = S [sum_k (1 + e_k) N_k I_k + sum_c db_jc dwd/dB_c] + La I + Ka dI/dt.
    !>
    !> A common e goes into S: N says nothing of it. All zero where S and La are not separable.
    subroutine gains_by_channels(calibration, motion, driven, result, field_sigma, information, right, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_motion_t), intent(in) :: motion(:)              !! Of each span
        logical, intent(in) :: driven(3)                            !! Rods
        type(angular_calibration_t), intent(in) :: result           !! Of this motion
        real(dp), intent(in) :: field_sigma                         !! T, of a span by axis
        real(dp), intent(out) :: information(3, 3), right(3)        !! By rod
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: rows(:, :), observed(:, :), effect(:, :), normal(:, :), rhs(:), x(:), covariance(:, :), &
            left(:), mixed(:, :), n(:, :), b(:), by_field(:), inverse(:, :)
        integer, allocatable :: number(:)
        real(dp) :: condition, weight
        integer :: i, k, axis, first, last, parameters, fields

        information = 0
        right = 0
        if (.not. result%separable) return
        number = pack([1, 2, 3], driven)
        call band_rows(calibration, motion, number, rows, observed)
        parameters = size(rows, 1)
        fields = 3*size(motion)
        allocate (effect(3 + fields, size(rows, 2)), normal(parameters, parameters), rhs(parameters), x(parameters), &
                  covariance(parameters, parameters), by_field(fields), inverse(fields, fields))
        allocate (n(3 + fields, 3 + fields), b(3 + fields), source=0.0_dp)
        do axis = 1, 3
            effect = 0
            last = 0
            do i = 1, size(motion)
                if (.not. calibration%spans(i)%used) cycle
                first = last + 1
                last = last + size(motion(i)%band, 2)
                do k = 1, 3
                    if (driven(k)) effect(k, first:last) = &
                        matmul(matmul(result%scale(axis, :), motion(i)%by_rod(:, k, :)), motion(i)%band)
                    effect(3*i + k, first:last) = &
                        matmul(matmul(result%scale(axis, :), motion(i)%by_field(:, k, :)), motion(i)%band)*field_sigma
                end do
            end do
            call normal_equations(rows, observed(:, axis), normal, rhs)
            call solve_normal_equations(normal, rhs, x, covariance, condition, error)
            if (allocated(error)) return
            left = observed(:, axis) - matmul(x, rows)
            weight = (size(left) - size(x))/sum(left**2)
            mixed = matmul(effect, transpose(rows))
            n = n + weight*(matmul(effect, transpose(effect)) - matmul(mixed, matmul(covariance, transpose(mixed))))
            b = b + weight*matmul(effect, left)
        end do
        do k = 4, size(b)       ! errors of the field, in their sigma
            n(k, k) = n(k, k) + 1
        end do
        call solve_normal_equations(n(4:, 4:), b(4:), by_field, inverse, condition, error)
        if (allocated(error)) return
        information = n(:3, :3) - matmul(n(:3, 4:), matmul(inverse, n(4:, :3)))
        right = b(:3) - matmul(n(:3, 4:), by_field)
    end subroutine gains_by_channels

    !> The angular acceleration that the channels show, S^-1 (ang - La I - Ka dI/dt), without its mean.
    subroutine channels_at(span, motion, result, acceleration, error)
        type(level1_span_t), intent(in) :: span
        type(level1_motion_t), intent(in) :: motion
        type(angular_calibration_t), intent(in) :: result
        real(dp), allocatable, intent(out) :: acceleration(:, :)    !! (3, samples), SRF, rad/s^2
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: inverse(3, 3)
        integer :: i

        if (.not. abs(determinant_3x3(result%scale)) > 1e-6_dp) then
            call fail(error, 'the angular channels do not follow the torque: their matrix has no inverse')
            return
        end if
        inverse = inverse_3x3(result%scale)
        acceleration = span%angular
        do i = 1, size(span%time)
            acceleration(:, i) = matmul(inverse, span%angular(:, i) - matmul(result%leakage, motion%current(:, i)) - &
                                        matmul(result%leakage_rate, motion%current_rate(:, i)))
        end do
        do i = 1, 3
            acceleration(i, :) = acceleration(i, :) - sum(acceleration(i, :))/size(span%time)
        end do
    end subroutine channels_at

    !> The second derivative of angles at some times: of a fit by a polynomial, ramps at firings and breaks, and within the span
    !> lines of whole cycles and a parabola of the angular acceleration, so that its jumps at the ends do no harm.
    !>
    !> Columns and their second derivatives are made orthonormal together, by the columns: of long spans polynomial,
    !> parabola and lines are too much alike for normal equations.
    subroutine differentiate_attitude(span, times, angles, wanted, acceleration, patterns, noise)
        type(level1_span_t), intent(in) :: span
        real(dp), intent(in) :: times(:)                    !! Of the angles, s
        real(dp), intent(in) :: angles(:, :)                !! (3, n), rad
        real(dp), intent(in) :: wanted(:)                   !! Within the span, s
        real(dp), allocatable, intent(out) :: acceleration(:, :)    !! rad/s^2
        real(dp), allocatable, intent(out) :: patterns(:, :)        !! (wanted, n): how white noise of the angles about an
                                                                    !! axis, of 1 rad, shows, as n independent numbers, 1/s^2
        real(dp), intent(out) :: noise(3)                           !! That noise, by the residuals of the fit, rad

        integer, parameter :: POWERS = 3
        real(dp), allocatable :: columns(:, :), fired(:), amplitudes(:)
        real(dp) :: duration, omega, s(size(times)), u(size(times)), inside(size(wanted))
        integer :: lines, n, k, axis, column, firings

        duration = span%stop - span%start
        lines = max(1, floor(HIGHEST_LINE*duration))
        ! A ramp that begins before the angles do, or with their last, is none
        fired = [span%firings, span%breaks]
        fired = pack(fired, fired > times(1) .and. fired < times(size(times) - 1))
        firings = size(fired)
        n = FIT_DEGREE + 1 + firings + POWERS + 2*lines
        allocate (columns(size(times), n), patterns(size(wanted), n), source=0.0_dp)
        allocate (acceleration(3, size(wanted)))
        call polynomial_columns(times, FIT_DEGREE, columns(:, :FIT_DEGREE + 1))
        call polynomial_curvature(times, wanted, FIT_DEGREE, patterns(:, :FIT_DEGREE + 1))
        do k = 1, firings
            columns(:, FIT_DEGREE + 1 + k) = max(0.0_dp, times - fired(k))
        end do
        s = max(0.0_dp, min(duration, times - span%start))
        u = max(0.0_dp, times - span%stop)
        inside = wanted - span%start
        column = FIT_DEGREE + 1 + firings
        do k = 0, POWERS - 1
            columns(:, column + k + 1) = s**(k + 2)/((k + 1)*(k + 2)) + s**(k + 1)/(k + 1)*u
            patterns(:, column + k + 1) = inside**k
        end do
        column = column + POWERS
        do k = 1, lines
            omega = TWO_PI*k/duration
            columns(:, column + 2*k - 1) = (1 - cos(omega*s))/omega**2 + sin(omega*s)/omega*u
            columns(:, column + 2*k) = s/omega - sin(omega*s)/omega**2 + (1 - cos(omega*s))/omega*u
            patterns(:, column + 2*k - 1) = cos(omega*inside)
            patterns(:, column + 2*k) = sin(omega*inside)
        end do
        call orthonormalise(columns, patterns)
        do axis = 1, 3
            amplitudes = matmul(angles(axis, :), columns)
            acceleration(axis, :) = matmul(patterns, amplitudes)
            noise(axis) = norm2(angles(axis, :) - matmul(columns, amplitudes))/sqrt(real(max(1, size(times) - n), dp))
        end do
    end subroutine differentiate_attitude
end module gracecg_level1_angular
