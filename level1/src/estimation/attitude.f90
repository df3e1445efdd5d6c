!> Gains of the torque rods, and the delay of their torque, from the attitude: its scale is geometry.
!>
!>     phi_a(t) = sum_k g_k [integral integral N_k I_k(t - tau)]_a + polynomial of degree 5 + ramps at firings and breaks
!>     N_k = J^-1 kappa_k e_k x B
!>
!> with one g_k per rod and one tau for all spans.
module gracecg_level1_attitude
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_base_vectors, only: cross, identity, inverse_3x3
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_basis, only: orthonormalise, remove_space, polynomial_columns
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t
    use gracecg_level1_drive, only: level1_drive_t
    use gracecg_level1_gyros, only: gyro_axes_t, gyro_attitude
    use gracecg_level1_series, only: interpolate, integrate_twice
    implicit none
    private
    public :: rod_calibration_t, calibrate_rods, rod_accelerations, known_acceleration, slow_quantities, relative

    real(dp), parameter :: GRID_STEP = 0.05_dp          !! Of the integrals, s
    integer, parameter :: ATTITUDE_DEGREE = 5
    real(dp), parameter :: FIT_MARGIN = 3               !! Attitude used before and behind a span, s. Fitted to the
                                                        !! simulated set four60: with 20 s the polynomial did not follow
                                                        !! science mode and left residuals of 1e-6 rad about x
    real(dp), parameter :: EARLIEST = -0.6_dp, LATEST = 0.8_dp  !! Delays that are searched, s

    type :: rod_calibration_t
        !! What the attitude says of the rods
        logical :: driven(3) = .false.                  !! Some span drives the rod: it has a gain
        real(dp) :: gain(3) = 1                         !! g, of the moment said: kappa = g kappa_said
        real(dp) :: gain_sigma(3) = 0                   !! Of g
        real(dp) :: covariance(3, 3) = 0                !! Of g; 0: of a rod that is not driven
        logical :: by_channels = .false.                !! The angular channels have their part in the ratios of gains
        real(dp) :: delay = 0                           !! tau, s
        real(dp) :: delay_sigma = 0                     !! s
        real(dp) :: gyro_delay = 0                      !! The same by the gyros, s
        logical :: by_gyros = .false.                   !! Gyros have a part in the gains
        real(dp) :: rms(3) = 0                          !! Of the attitude's residuals by axis, rad
        real(dp) :: gyro_rms = 0                        !! Of the gyros' about y, rad
        real(dp) :: explained(3) = 0                    !! Share of the variance that the rods explain, by axis
        real(dp) :: weighted_squares = 0                !! Of the residuals, by degree of freedom of the first fit
        logical :: estimated = .false.    !! There was an attitude to estimate from
    end type rod_calibration_t

    integer, parameter :: CAMERAS = 1, GYROS = 2        !! Whose angles

    !> What of a span's angles does not depend on the delay
    type :: fit_span_t
        integer :: kind = CAMERAS
        logical :: axes(3) = .true.                     !! Which are used
        real(dp), allocatable :: grid(:)                !! Times of the integrals, s
        real(dp), allocatable :: response(:, :, :)      !! N: axis, rod, time
        real(dp), allocatable :: time(:)                !! Of the attitude, s
        real(dp), allocatable :: angle(:, :)            !! Without the known torques' part and the nuisances: sample, axis
        real(dp), allocatable :: basis(:, :)            !! Nuisances
    end type fit_span_t

contains

    !> Angular acceleration by 1 mA in each rod: N = J^-1 kappa_k e_k x B, rad/s^2/mA.
    pure function rod_accelerations(setup, field) result(response)
        type(level1_setup_t), intent(in) :: setup
        real(dp), intent(in) :: field(3)        !! T, SRF
        real(dp) :: response(3, 3)              !! Axis, rod

        real(dp) :: inverse(3, 3), unit(3, 3)
        integer :: k

        inverse = inverse_3x3(setup%inertia)
        unit = identity(3)
        do k = 1, 3
            response(:, k) = setup%rod_gain(k)*setup%rod_sign(k)*matmul(inverse, cross(unit(:, k), field))
        end do
    end function rod_accelerations

    !> The angular acceleration that needs no rod: J^-1 (-w x J w + 3 mu/r^3 c x J c).
    pure function known_acceleration(setup, rate, up, gradient) result(acceleration)
        type(level1_setup_t), intent(in) :: setup
        real(dp), intent(in) :: rate(3)         !! w, rad/s
        real(dp), intent(in) :: up(3)           !! c
        real(dp), intent(in) :: gradient        !! mu/r^3, 1/s^2
        real(dp) :: acceleration(3)             !! rad/s^2

        acceleration = matmul(inverse_3x3(setup%inertia), 3*gradient*cross(up, matmul(setup%inertia, up)) - &
                              cross(rate, matmul(setup%inertia, rate)))
    end function known_acceleration

    !> Gains and delay. Fails when the attitude does not determine them.
    !>
    !> The delay is that by the star cameras. Where there are gyros, and the cameras tell their axes well enough, their angle
    !> about the axis of the orbital rate, the scale of which that rate gives, has its part in the gains, with a delay of its
    !> own.
    subroutine calibrate_rods(calibration, setup, drive, axes, rods, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(in) :: drive
        type(gyro_axes_t), intent(in) :: axes
        type(rod_calibration_t), intent(out) :: rods
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: COARSE = 0.1_dp, FINE = 0.02_dp
        real(dp), parameter :: LEAST_RATE = 5e-4_dp     ! rad/s: scales are safe above
        real(dp), parameter :: LEAST_SIGNAL = 2e4_dp    ! Of squares over those of noise: 1 % of other axes, two of them
        type(fit_span_t), allocatable :: fits(:)
        real(dp), allocatable :: times(:), angles(:, :)
        real(dp) :: weight(3, 2), delays(2), lowest, squares
        integer :: i, used

        used = count(calibration%spans%used)
        call find_driven(calibration, setup, rods%driven)
        if (used == 0 .or. .not. any(rods%driven)) then
            call fail(error, 'no manoeuvre found: in no usable span the current of a rod ranges over more than excitation_ma')
            return
        end if
        allocate (fits(used))
        used = 0
        do i = 1, size(calibration%spans)
            if (.not. calibration%spans(i)%used) cycle
            used = used + 1
            call prepare(calibration%spans(i), setup, calibration%spans(i)%attitude_time, calibration%spans(i)%angle, &
                         fits(used))
        end do
        weight = 1
        delays = setup%torque_delay
        lowest = huge(lowest)
        do i = 0, nint((LATEST - EARLIEST)/COARSE)
            delays(CAMERAS) = EARLIEST + i*COARSE
            call fit(fits, drive, delays, weight, rods, squares, error)
            if (allocated(error)) return
            if (squares < lowest) rods%delay = delays(CAMERAS)
            lowest = min(lowest, squares)
        end do
        delays = rods%delay
        do i = 1, 3     ! weights by axis from the residuals, at the best delay so far
            call refine(CAMERAS, merge(COARSE, FINE, i == 1), rods%delay_sigma)
            if (allocated(error)) return
        end do
        rods%delay = delays(CAMERAS)
        rods%estimated = .true.
        if (.not. axes%known) return
        ! The gyros' axes come from the cameras: what their angle about y has of the others is known as well as these say
        if (.not. rods%explained(2)/(1 - rods%explained(2))*sum([(size(fits(i)%time), i=1, used)]) > LEAST_SIGNAL) return
        rods%by_gyros = .true.
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (.not. span%used) cycle
                rods%by_gyros = rods%by_gyros .and. abs(sum(span%rate(2, :)))/size(span%rate, 2) > LEAST_RATE
                if (.not. rods%by_gyros) return
                call gyro_attitude(span, axes, times, angles)
                fits = [fits, fit_span_t(kind=GYROS, axes=[.false., .true., .false.])]
                call prepare(span, setup, times, angles, fits(size(fits)))
            end associate
        end do
        delays(GYROS) = rods%delay
        weight(:, GYROS) = weight(:, CAMERAS)
        do i = 1, 3
            call refine(GYROS, merge(2*FINE, FINE, i == 1), lowest)
            if (allocated(error)) return
        end do
        rods%gyro_delay = delays(GYROS)

    contains

        !> One delay by a parabola through three; and its sigma.
        subroutine refine(kind, step, sigma)
            integer, intent(in) :: kind
            real(dp), intent(in) :: step            !! s
            real(dp), intent(inout) :: sigma        !! s

            real(dp) :: at(-1:1), curvature, centre
            integer :: k

            centre = delays(kind)
            do k = -1, 1
                delays(kind) = centre + k*step
                call fit(fits, drive, delays, weight, rods, at(k), error)
                if (allocated(error)) return
            end do
            curvature = at(-1) - 2*at(0) + at(1)
            delays(kind) = centre
            if (curvature > 0) &
                delays(kind) = centre + max(-1.0_dp, min(1.0_dp, (at(-1) - at(1))/(2*curvature)))*step
            call fit(fits, drive, delays, weight, rods, at(0), error)
            if (allocated(error)) return
            if (curvature > 0) sigma = sqrt(2*step**2/curvature*rods%weighted_squares)
            do k = 1, 3
                weight(k, CAMERAS) = 1/rods%rms(k)**2
            end do
            if (rods%by_gyros) weight(2, GYROS) = 1/rods%gyro_rms**2
        end subroutine refine
    end subroutine calibrate_rods

    !> Which rods some span drives.
    pure subroutine find_driven(calibration, setup, driven)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        logical, intent(out) :: driven(3)

        integer :: i, k
        logical :: inside(size(calibration%current_time))

        driven = .false.
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (.not. span%used) cycle
                inside = calibration%current_time >= span%start .and. calibration%current_time <= span%stop
                do k = 1, 3
                    driven(k) = driven(k) .or. maxval(calibration%current(k, :), mask=inside) - &
                        minval(calibration%current(k, :), mask=inside) > setup%excitation_current
                end do
            end associate
        end do
    end subroutine find_driven

    !> What of a span does not depend on the delay.
    subroutine prepare(span, setup, times, angles, fitted)
        type(level1_span_t), intent(in) :: span
        type(level1_setup_t), intent(in) :: setup
        real(dp), intent(in) :: times(:)            !! s
        real(dp), intent(in) :: angles(:, :)        !! (3, n), rad
        type(fit_span_t), intent(inout) :: fitted   !! Its kind and axes are kept

        integer, allocatable :: wanted(:)
        real(dp), allocatable :: known(:, :), twice(:), ramps(:)
        real(dp) :: slow(10), last
        integer :: i, k, n, axis

        ramps = [span%firings, span%breaks]
        wanted = pack([(i, i=1, size(times))], times >= span%start - FIT_MARGIN .and. times <= span%stop + FIT_MARGIN)
        fitted%time = times(wanted)
        fitted%angle = transpose(angles(:, wanted))
        last = fitted%time(size(fitted%time))
        n = ceiling((last - fitted%time(1))/GRID_STEP - 1e-6_dp) + 1
        fitted%grid = fitted%time(1) + [(i*GRID_STEP, i=0, n - 1)]
        allocate (fitted%response(3, 3, n), known(n, 3), twice(n))
        do i = 1, n
            call slow_quantities(span, fitted%grid(i), slow)
            fitted%response(:, :, i) = rod_accelerations(setup, slow(1:3))
            known(i, :) = known_acceleration(setup, slow(4:6), slow(7:9), slow(10))
        end do
        do axis = 1, 3
            call integrate_twice(GRID_STEP, known(:, axis), twice)
            fitted%angle(:, axis) = fitted%angle(:, axis) - on_samples(twice, fitted)
        end do
        allocate (fitted%basis(size(fitted%time), ATTITUDE_DEGREE + 1 + size(ramps)))
        call polynomial_columns(fitted%time, ATTITUDE_DEGREE, fitted%basis)
        do k = 1, size(ramps)
            fitted%basis(:, ATTITUDE_DEGREE + 1 + k) = max(0.0_dp, fitted%time - ramps(k))
        end do
        call orthonormalise(fitted%basis)
        do axis = 1, 3
            call remove_space(fitted%basis, fitted%angle(:, axis))
        end do
    end subroutine prepare

    !> Field, rate, vertical and gradient of a span at a time.
    pure subroutine slow_quantities(span, time, slow)
        type(level1_span_t), intent(in) :: span
        real(dp), intent(in) :: time    !! s
        real(dp), intent(out) :: slow(10)    !! Field (T), rate (rad/s), vertical, gradient (1/s^2)

        real(dp) :: gradient(1)

        call interpolate(span%attitude_time, span%field, time, slow(1:3))
        call interpolate(span%attitude_time, span%rate, time, slow(4:6))
        call interpolate(span%attitude_time, span%up, time, slow(7:9))
        call interpolate(span%attitude_time, reshape(span%gradient, [1, size(span%gradient)]), time, gradient)
        slow(10) = gradient(1)
    end subroutine slow_quantities

    !> A series of the grid at the attitude's samples.
    pure function on_samples(series, fitted) result(values)
        real(dp), intent(in) :: series(:)
        type(fit_span_t), intent(in) :: fitted
        real(dp) :: values(size(fitted%time))

        real(dp) :: place
        integer :: i, k

        do i = 1, size(values)
            place = (fitted%time(i) - fitted%grid(1))/GRID_STEP + 1
            k = max(1, min(size(series) - 1, int(place)))
            values(i) = series(k) + (place - k)*(series(k + 1) - series(k))
        end do
    end function on_samples

    !> Gains at some delays, and the weighted squares of the residuals.
    subroutine fit(fits, drive, delays, weight, rods, squares, error)
        type(fit_span_t), intent(in) :: fits(:)
        type(level1_drive_t), intent(in) :: drive
        real(dp), intent(in) :: delays(2)           !! Of cameras and gyros, s
        real(dp), intent(in) :: weight(3, 2)        !! Of their axes, 1/rad^2
        type(rod_calibration_t), intent(inout) :: rods
        real(dp), intent(out) :: squares
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: rows(:, :), observed(:), current(:, :), twice(:), column(:), normal(:, :), rhs(:), x(:), &
            covariance(:, :), residuals(:), root(:)
        integer, allocatable :: class_of(:), number(:)      ! class: axis, or 3 + axis of gyros
        real(dp) :: condition, total, free(6)
        integer :: i, k, axis, m, n, first, parameters, class

        number = pack([1, 2, 3], rods%driven)
        parameters = size(number)
        n = sum([(count(fits(i)%axes)*size(fits(i)%time), i=1, size(fits))])
        allocate (rows(parameters, n), observed(n), class_of(n), normal(parameters, parameters), rhs(parameters), &
                  x(parameters), covariance(parameters, parameters))
        first = 1
        free = 0
        do i = 1, size(fits)
            associate (f => fits(i))
                allocate (current(3, size(f%grid)), twice(size(f%grid)))
                do k = 1, size(f%grid)
                    call drive%at(f%grid(k) - delays(f%kind), current(:, k))
                end do
                m = size(f%time)
                do axis = 1, 3
                    if (.not. f%axes(axis)) cycle
                    class = axis + 3*(f%kind - 1)
                    class_of(first:first + m - 1) = class
                    free(class) = free(class) + m - size(f%basis, 2)
                    column = f%angle(:, axis)
                    do k = 1, 3     ! a rod that is not driven acts as said
                        if (rods%driven(k)) cycle
                        call integrate_twice(GRID_STEP, f%response(axis, k, :)*current(k, :), twice)
                        column = column - on_samples(twice, f)
                    end do
                    call remove_space(f%basis, column)
                    observed(first:first + m - 1) = column
                    do k = 1, parameters
                        call integrate_twice(GRID_STEP, f%response(axis, number(k), :)*current(number(k), :), twice)
                        column = on_samples(twice, f)
                        call remove_space(f%basis, column)
                        rows(k, first:first + m - 1) = column
                    end do
                    first = first + m
                end do
                deallocate (current, twice)
            end associate
        end do
        root = [(sqrt(weight(modulo(class_of(k) - 1, 3) + 1, (class_of(k) - 1)/3 + 1)), k=1, n)]
        call normal_equations(rows*spread(root, 1, parameters), observed*root, normal, rhs)
        call solve_normal_equations(normal, rhs, x, covariance, condition, error)
        if (allocated(error)) return
        residuals = observed - matmul(x, rows)
        squares = sum((root*residuals)**2)
        rods%weighted_squares = squares/(sum(free) - parameters)
        rods%gain = 1
        rods%gain_sigma = 0
        rods%covariance = 0
        rods%gain(number) = x
        rods%covariance(number, number) = covariance*rods%weighted_squares
        rods%gain_sigma = sqrt([(rods%covariance(k, k), k=1, 3)])
        do axis = 1, 3
            total = sum(observed**2, mask=class_of == axis)
            rods%rms(axis) = sqrt(sum(residuals**2, mask=class_of == axis)/(free(axis) - parameters/3.0_dp))
            rods%explained(axis) = 1 - sum(residuals**2, mask=class_of == axis)/max(total, tiny(total))
        end do
        if (free(5) > 0) rods%gyro_rms = sqrt(sum(residuals**2, mask=class_of == 5)/free(5))
    end subroutine fit

    !> A matrix over the products of some gains.
    pure function relative(matrix, gain)
        real(dp), intent(in) :: matrix(:, :)        !! n by n, as of covariances of gains
        real(dp), intent(in) :: gain(:)             !! n, g of the rods
        real(dp) :: relative(size(gain), size(gain))

        real(dp), parameter :: LEAST = 1e-3_dp      ! A rod that does nothing
        real(dp) :: divisor(size(gain))

        divisor = sign(max(abs(gain), LEAST), gain)
        relative = matrix/(spread(divisor, 1, size(gain))*spread(divisor, 2, size(gain)))
    end function relative
end module gracecg_level1_attitude
