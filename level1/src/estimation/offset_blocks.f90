!> Observations and columns of the offset by span and axis, in the band; their normal equations, and their weights by the
!> density of the residuals.
module gracecg_level1_offset_blocks
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: NANOTESLA
    use gracecg_base_lapack, only: normal_equations
    use gracecg_base_vectors, only: cross_matrix, identity
    use gracecg_level1_angular, only: level1_motion_t
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_offset_solution, only: source_series_t, consider_t
    use gracecg_level1_series, only: interpolate
    implicit none
    private
    public :: block_t, signal_of, make_blocks, accumulate, residual_weights

    real(dp), parameter :: FULL_CURRENT = 120, FULL_FIELD = 30000*NANOTESLA     !! Of a proportional leakage: mA, T

    !> One span and axis in the band, each column divided by its amplitude
    type :: block_t
        integer :: axis = 0, span = 0           !! Of the calibration's
        real(dp), allocatable :: amplitude(:)   !! Of the noise, relative to the middle of the band
        real(dp), allocatable :: rows(:, :)     !! Parameter, band column
        real(dp), allocatable :: observed(:)    !! Acceleration, m/s^2: band column
        real(dp), allocatable :: others(:, :)   !! Considered accelerations: band column, each
        real(dp), allocatable :: patterns(:, :) !! Of the source's noise: band column, pattern
        real(dp) :: noise(3) = 0                !! Its sigma by axis of the source
        real(dp), allocatable :: products(:, :) !! I_k B_b of the rods driven, of 120 mA and 30 000 nT: band column, each
        real(dp), allocatable :: flow(:)        !! Angle of the air's flow towards the axis, but for its sign; x: 0; band column
    end type block_t

contains

    !> Row a of the matrix that takes d into the acceleration: wd x, w x (w x, gravity gradient.
    pure function signal_of(acceleration, rate, up, gradient) result(matrix)
        real(dp), intent(in) :: acceleration(3)     !! wd, rad/s^2
        real(dp), intent(in) :: rate(3)             !! w, rad/s
        real(dp), intent(in) :: up(3)               !! c
        real(dp), intent(in) :: gradient            !! mu/r^3, 1/s^2
        real(dp) :: matrix(3, 3)

        real(dp) :: w(3, 3)
        integer :: i

        w = cross_matrix(rate)
        matrix = cross_matrix(acceleration) + matmul(w, w) + gradient*identity(3)
        do i = 1, 3
            matrix(:, i) = matrix(:, i) - 3*gradient*up*up(i)
        end do
    end function signal_of

    !> Everything in the band.
    subroutine make_blocks(calibration, motion, source, considered, rods, blocks)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_motion_t), intent(in) :: motion(:)
        type(source_series_t), intent(in) :: source(:)
        type(consider_t), intent(in) :: considered(:)
        integer, intent(in) :: rods(:)              !! That are driven
        type(block_t), allocatable, intent(out) :: blocks(:)

        integer, parameter :: ABOUT(3) = [0, 3, 2]  ! The axis about which the satellite turns an axis into the flow; 0: none
        real(dp), allocatable :: rows(:, :, :), turned(:, :)
        integer :: i, k, a, n, m, r, b, c, at

        r = size(rods)
        allocate (blocks(3*count(calibration%spans%used)))
        b = 0
        do i = 1, size(calibration%spans)
            if (.not. calibration%spans(i)%used) cycle
            n = size(calibration%spans(i)%time)
            m = size(motion(i)%band, 2)
            allocate (rows(3, 3, n), turned(0:3, n))
            turned(0, :) = 0
            do k = 1, n
                associate (span => calibration%spans(i))
                    call interpolate(span%attitude_time, span%angle, span%time(k), turned(1:, k))
                end associate
                rows(:, :, k) = signal_of(source(i)%acceleration(:, k), motion(i)%rate(:, k), motion(i)%up(:, k), &
                                          motion(i)%gradient(k))
            end do
            do a = 1, 3
                b = b + 1
                blocks(b)%axis = a
                blocks(b)%span = i
                allocate (blocks(b)%amplitude(m), source=1.0_dp)
                blocks(b)%observed = matmul(calibration%spans(i)%linear(a, :), motion(i)%band)
                allocate (blocks(b)%rows(3 + 6*r, m), source=0.0_dp)
                blocks(b)%rows(1:3, :) = matmul(rows(a, :, :), motion(i)%band)
                at = 3 + (a - 1)*2*r
                do k = 1, r
                    blocks(b)%rows(at + k, :) = matmul(motion(i)%current(rods(k), :), motion(i)%band)
                    blocks(b)%rows(at + r + k, :) = matmul(motion(i)%current_rate(rods(k), :), motion(i)%band)
                end do
                allocate (blocks(b)%products(m, 3*r))
                do k = 1, r
                    do c = 1, 3
                        blocks(b)%products(:, 3*(k - 1) + c) = &
                            matmul(motion(i)%current(rods(k), :)/FULL_CURRENT*motion(i)%field(c, :)/FULL_FIELD, motion(i)%band)
                    end do
                end do
                blocks(b)%flow = matmul(turned(ABOUT(a), :), motion(i)%band)
                blocks(b)%noise = source(i)%noise
                if (allocated(source(i)%patterns)) then
                    if (a == 1) blocks(b)%patterns = matmul(transpose(motion(i)%band), source(i)%patterns)
                    if (a > 1) blocks(b)%patterns = blocks(b - 1)%patterns
                end if
                ! Of what is considered the row that belongs to d: [change x d]_a, three columns each.
                allocate (blocks(b)%others(m, 3*size(considered)), source=0.0_dp)
                do c = 1, size(considered)
                    if (considered(c)%span /= 0 .and. considered(c)%span /= i) cycle
                    call cross_row(considered(c)%change(i)%acceleration, a, motion(i)%band, &
                                   blocks(b)%others(:, 3*c - 2:3*c))
                end do
            end do
            deallocate (rows, turned)
        end do
    end subroutine make_blocks

    !> Row a of the cross product with a series, in the band.
    pure subroutine cross_row(series, a, band, columns)
        real(dp), intent(in) :: series(:, :), band(:, :)
        integer, intent(in) :: a
        real(dp), intent(out) :: columns(:, :)

        integer :: next, last

        next = modulo(a, 3) + 1
        last = modulo(a + 1, 3) + 1
        columns = 0
        columns(:, last) = matmul(series(next, :), band)
        columns(:, next) = -matmul(series(last, :), band)
    end subroutine cross_row

    !> The normal equations of all blocks.
    subroutine accumulate(blocks, weight, normal, rhs)
        type(block_t), intent(in) :: blocks(:)
        real(dp), intent(in) :: weight(3)               !! By axis, s^4/m^2
        real(dp), intent(out) :: normal(:, :), rhs(:)   !! By parameter

        real(dp) :: part(size(rhs), size(rhs)), part_rhs(size(rhs))
        integer :: i

        normal = 0
        rhs = 0
        do i = 1, size(blocks)
            call normal_equations(blocks(i)%rows, blocks(i)%observed, part, part_rhs)
            normal = normal + weight(blocks(i)%axis)*part
            rhs = rhs + weight(blocks(i)%axis)*part_rhs
        end do
    end subroutine accumulate

    !> Where the columns of a band lie in it, from -1 to 1: they rise in frequency.
    pure function positions(columns) result(u)
        integer, intent(in) :: columns
        real(dp) :: u(columns)

        integer :: k

        u = [((2*k - 1 - columns)/real(columns, dp), k=1, columns)]
    end function positions

    !> Weights from the residuals: their density in the band is level*exp(tilt*u), u from -1 to 1, for each axis.
    !> The tilt makes the likelihood of their squares, exponential numbers with that mean (P. Whittle 1953), greatest:
    !> sum u (s/level - 1) = 0, s the squares by exp(tilt*u), which falls with the tilt.
    subroutine residual_weights(blocks, x, parameters, tilt, weight, rms)
        type(block_t), intent(inout) :: blocks(:)   !! The columns are divided by their amplitudes
        real(dp), intent(in) :: x(:)                !! Parameters
        integer, intent(in) :: parameters           !! How many were estimated
        real(dp), intent(inout) :: tilt(3)          !! By axis
        real(dp), intent(out) :: weight(3), rms(3)  !! RMS as observed, m/s^2

        integer, parameter :: STEPS = 20            ! Newton's
        real(dp), parameter :: LARGEST_STEP = 1, LARGEST_TILT = 8, SETTLED = 1e-6_dp
        real(dp), allocatable :: left(:), u(:)
        real(dp) :: moments(0:2), step, level
        integer :: axis, i, k, number, free

        free = nint(parameters/3.0_dp)
        do axis = 1, 3
            do k = 1, STEPS
                moments = 0
                level = 0
                number = 0
                do i = 1, size(blocks)
                    if (blocks(i)%axis /= axis) cycle
                    u = positions(size(blocks(i)%observed))
                    left = (blocks(i)%observed - matmul(x, blocks(i)%rows))**2
                    level = level + sum(left*blocks(i)%amplitude**2)
                    left = left*blocks(i)%amplitude**2*exp(-tilt(axis)*u)
                    moments = moments + [sum(left), sum(u*left), sum(u**2*left)]
                    number = number + size(u)
                end do
                if (.not. moments(2) > 0) exit
                step = moments(1)/moments(2)
                tilt(axis) = min(LARGEST_TILT, max(-LARGEST_TILT, tilt(axis) + min(LARGEST_STEP, max(-LARGEST_STEP, step))))
                if (abs(step) < SETTLED) exit
            end do
            rms(axis) = sqrt(level/max(1, number - free))
            weight(axis) = 0
            if (moments(0) > 0) weight(axis) = max(1, number - free)/moments(0)
        end do
        do i = 1, size(blocks)
            call divide_by_amplitude(blocks(i), exp(tilt(blocks(i)%axis)*positions(size(blocks(i)%observed))/2))
        end do
    end subroutine residual_weights

    !> Gives the columns of a block other amplitudes.
    pure subroutine divide_by_amplitude(block, amplitude)
        type(block_t), intent(inout) :: block
        real(dp), intent(in) :: amplitude(:)

        real(dp) :: factor(size(amplitude))
        integer :: k

        factor = block%amplitude/amplitude
        block%amplitude = amplitude
        block%observed = block%observed*factor
        do k = 1, size(factor)
            block%rows(:, k) = block%rows(:, k)*factor(k)
            block%others(k, :) = block%others(k, :)*factor(k)
            block%products(k, :) = block%products(k, :)*factor(k)
            if (allocated(block%patterns)) block%patterns(k, :) = block%patterns(k, :)*factor(k)
        end do
    end subroutine divide_by_amplitude
end module gracecg_level1_offset_blocks
