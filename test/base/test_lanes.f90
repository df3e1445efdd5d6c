!> The kernels over what lies side by side: against the same work done plainly, and that the bits do not depend on the
!> width of the vectors. A vector that the processor does not have is not tested: the next narrower one is taken.
module test_lanes
    use, intrinsic :: iso_c_binding, only: c_int32_t
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_is_nan
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_lanes, only: LANES, POLES, LEFT_OUT, PREDICTED, USED, lanes_of, lanes_whiten, lanes_filter, &
        lanes_add_products, lanes_carry, lanes_combine, lanes_reflect, lanes_sines_cosines, total_of
    use gracecg_base_random, only: random_stream_t, new_stream
    use testdrive, only: new_unittest, unittest_type, error_type, check
    implicit none
    private
    public :: collect_lanes

    integer(c_int32_t), parameter :: WIDTHS(3) = [2, 4, 8]
    real(dp), parameter :: CLOSE = 1e-13_dp     ! relative, of sums of some hundred terms

contains

    subroutine collect_lanes(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('multiples-of-lanes', test_multiples), &
                    new_unittest('whitening-by-poles', test_whitening), &
                    new_unittest('filter-of-coupled-states', test_filter), &
                    new_unittest('filter-without-states', test_no_states), &
                    new_unittest('sums-of-products', test_products), &
                    new_unittest('carried-columns', test_carry), &
                    new_unittest('combinations-of-columns', test_combine), &
                    new_unittest('reflection-of-rows', test_reflect), &
                    new_unittest('sines-and-cosines', test_sines), &
                    new_unittest('sum-in-pairs', test_total)]
    end subroutine collect_lanes

    !> Normal random numbers, the same for the same place in a test.
    function numbers(count, place) result(values)
        integer, intent(in) :: count, place
        real(dp) :: values(count)

        type(random_stream_t) :: stream

        stream = new_stream(20261123_i8, 1, 1, place, 1)
        call stream%normals(values)
    end function numbers

    logical function close_to(found, expected)
        real(dp), intent(in) :: found(:), expected(:)

        close_to = maxval(abs(found - expected)) <= CLOSE*maxval(abs(expected))
    end function close_to

    subroutine test_multiples(error)
        type(error_type), allocatable, intent(out) :: error

        integer :: n

        call check(error, all([(lanes_of(n), n=0, 17)] == [0, [(8, n=1, 8)], [(16, n=9, 16)], 24]))
    end subroutine test_multiples

    !> What a filter does, plainly. The last sample has no next one.
    subroutine filter_plainly(role, output, gain, inverse_deviation, transition, series)
        integer(c_int32_t), intent(in) :: role(:)
        real(dp), intent(in) :: output(:), gain(:, :), inverse_deviation(:), transition(:, :, :)
        real(dp), intent(inout) :: series(:, :)

        real(dp) :: state(size(output)), innovation
        integer :: i, lane

        do lane = 1, size(series, 1)
            state = 0
            do i = 1, size(series, 2)
                innovation = series(lane, i) - dot_product(output, state)
                series(lane, i) = merge(0.0_dp, innovation*inverse_deviation(i), role(i) == LEFT_OUT)
                if (role(i) /= USED) innovation = 0
                if (i < size(series, 2)) state = matmul(transition(:, :, i), state + gain(:, i)*innovation)
            end do
        end do
    end subroutine filter_plainly

    subroutine test_whitening(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: SAMPLES = 50
        real(dp) :: gain(POLES, SAMPLES), decay(POLES, SAMPLES), inverse_deviation(SAMPLES), output(POLES)
        real(dp) :: transition(POLES, POLES, SAMPLES)
        real(dp), allocatable :: series(:, :, :), plain(:, :), state(:, :)
        integer(c_int32_t) :: role(SAMPLES), blocks
        integer :: i, j, width

        gain = reshape(0.02_dp*numbers(size(gain), 1), shape(gain))
        decay = reshape(exp(-abs(numbers(size(decay), 2))), shape(decay))
        inverse_deviation = abs(numbers(SAMPLES, 3))
        role = USED
        role([7, 8, 30]) = LEFT_OUT
        role([11, 31]) = PREDICTED
        output = 1
        transition = 0
        do i = 1, SAMPLES
            do j = 1, POLES
                transition(j, j, i) = decay(j, i)
            end do
        end do
        do blocks = 1, 3
            allocate (series(blocks*LANES, SAMPLES, size(WIDTHS)), state(blocks*LANES, POLES))
            do width = 1, size(WIDTHS)
                series(:, :, width) = reshape(numbers(size(series(:, :, 1)), 4), shape(series(:, :, 1)))
                if (width == 1) then
                    plain = series(:, :, 1)
                    call filter_plainly(role, output, gain, inverse_deviation, transition, plain)
                end if
                state = 0   ! in two pieces, as the library does
                call lanes_whiten(WIDTHS(width), blocks*LANES, 20, 20, role, gain, inverse_deviation, decay, state, &
                                  series(:, :20, width))
                call lanes_whiten(WIDTHS(width), blocks*LANES, SAMPLES - 20, SAMPLES - 21, role(21:), gain(:, 21:), &
                                  inverse_deviation(21:), decay(:, 21:), state, series(:, 21:, width))
            end do
            call check(error, close_to(pack(series(:, :, 1), .true.), pack(plain, .true.)), 'plain')
            if (.not. allocated(error)) call check_widths(error, reshape(series, [size(plain), size(WIDTHS)]))
            if (allocated(error)) return
            deallocate (series, state)
        end do
    end subroutine test_whitening

    !> Every width gives the bits of the first one.
    subroutine check_widths(error, values)
        type(error_type), allocatable, intent(out) :: error
        real(dp), intent(in) :: values(:, :)        ! (values, width)

        integer :: width

        do width = 2, size(values, 2)
            call check(error, all(transfer(values(:, width), [0_i8]) == transfer(values(:, 1), [0_i8])), 'bits')
            if (allocated(error)) return
        end do
    end subroutine check_widths

    subroutine test_filter(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: SAMPLES = 40, STATES = 5
        real(dp), dimension(STATES, SAMPLES) :: gain, below, on, above
        real(dp) :: inverse_deviation(SAMPLES), output(STATES), transition(STATES, STATES, SAMPLES)
        real(dp) :: series(2*LANES, SAMPLES, size(WIDTHS)), plain(2*LANES, SAMPLES), state(2*LANES, STATES)
        integer(c_int32_t), parameter :: COUPLED(STATES) = [0, 1, 1, 1, 1]
        integer(c_int32_t) :: role(SAMPLES)
        integer :: i, j, width

        gain = reshape(0.1_dp*numbers(size(gain), 11), shape(gain))
        on = reshape(0.4_dp*numbers(size(gain), 12), shape(gain))
        below = reshape(0.4_dp*numbers(size(gain), 13), shape(gain))
        above = reshape(0.4_dp*numbers(size(gain), 14), shape(gain))
        below([1, 2, 4], :) = 0         ! pairs 2, 3 and 4, 5
        above([1, 3, 5], :) = 0
        inverse_deviation = abs(numbers(SAMPLES, 15))
        output = numbers(STATES, 16)
        role = USED
        role([1, 9]) = PREDICTED
        role(20) = LEFT_OUT
        transition = 0
        do i = 1, SAMPLES
            do j = 1, STATES
                transition(j, j, i) = on(j, i)
                if (j > 1) transition(j, j - 1, i) = below(j, i)
                if (j < STATES) transition(j, j + 1, i) = above(j, i)
            end do
        end do
        do width = 1, size(WIDTHS)
            series(:, :, width) = reshape(numbers(size(plain), 17), shape(plain))
            if (width == 1) then
                plain = series(:, :, 1)
                call filter_plainly(role, output, gain, inverse_deviation, transition, plain)
            end if
            state = 0
            call lanes_filter(WIDTHS(width), STATES, 2*LANES, SAMPLES, SAMPLES - 1, role, COUPLED, output, gain, &
                              inverse_deviation, below, on, above, state, series(:, :, width))
        end do
        call check(error, close_to(pack(series(:, :, 1), .true.), pack(plain, .true.)), 'plain')
        if (.not. allocated(error)) call check_widths(error, reshape(series, [size(plain), size(WIDTHS)]))
    end subroutine test_filter

    !> White noise: samples by their deviations, but those left out.
    subroutine test_no_states(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: SAMPLES = 5
        real(dp), dimension(0, SAMPLES) :: gain, below, on, above
        real(dp) :: output(0), state(LANES, 0), inverse_deviation(SAMPLES), series(LANES, SAMPLES), plain(LANES, SAMPLES)
        integer(c_int32_t), parameter :: ROLE(SAMPLES) = [USED, PREDICTED, LEFT_OUT, USED, USED]
        integer(c_int32_t) :: coupled(0)
        integer :: width

        inverse_deviation = abs(numbers(SAMPLES, 21))
        do width = 1, size(WIDTHS)
            series = reshape(numbers(size(series), 22), shape(series))
            plain = series*spread(merge(0.0_dp, inverse_deviation, ROLE == LEFT_OUT), 1, LANES)
            call lanes_filter(WIDTHS(width), 0, LANES, SAMPLES, SAMPLES - 1, ROLE, coupled, output, gain, &
                              inverse_deviation, below, on, above, state, series)
            call check(error, close_to(pack(series, .true.), pack(plain, .true.)))
            if (allocated(error)) return
        end do
    end subroutine test_no_states

    subroutine test_products(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: N = 13, STRIDE = 16, M = 24
        real(dp) :: rows(STRIDE, M), observed(M), sums(STRIDE, N), side(STRIDE), results(N*(N + 1)/2 + N, size(WIDTHS))
        real(dp) :: plain(N, N)
        integer :: width, i

        rows = 0
        rows(:N, :) = reshape(numbers(N*M, 21), [N, M])
        observed = numbers(M, 22)
        plain = matmul(rows(:N, :), transpose(rows(:N, :)))
        do width = 1, size(WIDTHS)
            sums = 0
            side = 0
            call lanes_add_products(WIDTHS(width), N, STRIDE, M, rows, observed, sums, side)
            results(:, width) = [([sums(:i, i)], i=1, N), side(:N)]
        end do
        call check(error, close_to(results(:, 1), [([plain(:i, i)], i=1, N), matmul(rows(:N, :), observed)]), 'plain')
        if (.not. allocated(error)) call check_widths(error, results)
    end subroutine test_products

    subroutine test_carry(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: STEPS = 7
        real(dp), parameter :: INTERVAL = 0.1_dp
        real(dp) :: omega(3, 0:2*STEPS), a(3, 3, 0:2*STEPS), b(3, 3, 0:2*STEPS), f(LANES, 3, 0:2*STEPS)
        real(dp) :: columns(LANES, 9, 0:STEPS), results(size(columns), size(WIDTHS)), plain(LANES, 9, 0:STEPS)
        real(dp) :: x(6), slope(6, 4)
        integer :: width, lane, k

        omega = reshape(numbers(size(omega), 31), shape(omega))
        a = reshape(numbers(size(a), 32), shape(a))
        b = reshape(numbers(size(b), 33), shape(b))
        f = reshape(numbers(size(f), 34), shape(f))
        columns = 0
        columns(:, :6, 0) = reshape(numbers(6*LANES, 35), [LANES, 6])
        plain = columns
        do lane = 1, LANES
            x = plain(lane, :6, 0)
            do k = 0, STEPS
                slope(:, 1) = slope_of(x, 2*k)
                plain(lane, :6, k) = x
                plain(lane, 7:, k) = slope(4:, 1)
                if (k == STEPS) exit
                slope(:, 2) = slope_of(x + INTERVAL/2*slope(:, 1), 2*k + 1)
                slope(:, 3) = slope_of(x + INTERVAL/2*slope(:, 2), 2*k + 1)
                slope(:, 4) = slope_of(x + INTERVAL*slope(:, 3), 2*k + 2)
                x = x + INTERVAL/6*matmul(slope, [1.0_dp, 2.0_dp, 2.0_dp, 1.0_dp])
            end do
        end do
        do width = 1, size(WIDTHS)
            call lanes_carry(WIDTHS(width), LANES, STEPS, INTERVAL, omega, a, b, f, columns)
            results(:, width) = pack(columns, .true.)
        end do
        call check(error, close_to(results(:, 1), pack(plain, .true.)), 'plain')
        if (.not. allocated(error)) call check_widths(error, results)

    contains

        function slope_of(x, half) result(slope)
            real(dp), intent(in) :: x(6)
            integer, intent(in) :: half
            real(dp) :: slope(6)

            slope(:3) = x(4:) - [omega(2, half)*x(3) - omega(3, half)*x(2), omega(3, half)*x(1) - omega(1, half)*x(3), &
                                 omega(1, half)*x(2) - omega(2, half)*x(1)]
            slope(4:) = matmul(a(:, :, half), x(:3)) + matmul(b(:, :, half), x(4:)) + f(lane, :, half)
        end function slope_of
    end subroutine test_carry

    !> Columns of any length and number, some of them apart from each other.
    subroutine test_combine(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: LENGTHS(3) = [8, 13, 41], COUNTS(4) = [1, 9, 64, 150], GAP = 5
        real(dp), allocatable :: columns(:, :), weights(:, :), combined(:, :), results(:, :)
        integer :: i, j, m, width

        do i = 1, size(LENGTHS)
            do j = 1, size(COUNTS)
                do m = 1, 7
                    associate (length => LENGTHS(i), n => COUNTS(j))
                        columns = reshape(numbers((length + GAP)*n, 41), [length + GAP, n])
                        weights = reshape(numbers(m*n, 42), [m, n])
                        if (allocated(combined)) deallocate (combined, results)
                        allocate (combined(length, m), results(length*m, size(WIDTHS)))
                        do width = 1, size(WIDTHS)
                            call lanes_combine(WIDTHS(width), length, length + GAP, n, m, columns, weights, combined)
                            results(:, width) = pack(combined, .true.)
                        end do
                        combined = matmul(columns(:length, :), transpose(weights))
                    end associate
                    call check(error, close_to(results(:, 1), pack(combined, .true.)), 'plain')
                    if (.not. allocated(error)) call check_widths(error, results)
                    if (allocated(error)) return
                end do
            end do
        end do
    end subroutine test_combine

    !> The elements vanish, and no scalar product of two columns changes: the reflection is orthogonal.
    subroutine test_reflect(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: OTHERS = 11
        real(dp) :: rows(2*LANES, 0:OTHERS), reflected(2*LANES, 0:OTHERS), results(size(rows), size(WIDTHS))
        integer :: column, width

        do column = 1, 2*LANES, 5
            rows = reshape(numbers(size(rows), 50 + column), shape(rows))
            rows(:column - 1, :) = 0
            do width = 1, size(WIDTHS)
                reflected = rows
                call lanes_reflect(WIDTHS(width), 2*LANES, column, OTHERS, reflected(:, 0), reflected(:, 1:))
                results(:, width) = pack(reflected, .true.)
            end do
            call check(error, all(abs(reflected(:column, 1:)) <= 0), 'zeros')
            if (.not. allocated(error)) call check(error, all(abs(reflected(:column - 1, 0)) <= 0), 'zeros before')
            if (.not. allocated(error)) call check(error, close_to(pack(matmul(reflected, transpose(reflected)), .true.), &
                                                                   pack(matmul(rows, transpose(rows)), .true.)), 'products')
            if (.not. allocated(error)) call check_widths(error, results)
            if (allocated(error)) return
        end do
    end subroutine test_reflect

    !> Against the intrinsic functions of the angle less its whole turns, one by one; NaN stays NaN, and beside it nothing
    !> changes.
    subroutine test_sines(error)
        type(error_type), allocatable, intent(out) :: error

        integer, parameter :: MANY = 512
        real(dp), parameter :: NEAR = 6e-16_dp
        real(dp), dimension(LANES) :: turns, sines, cosines, again, other
        real(dp) :: all_turns(LANES, MANY), angle
        integer :: i, lane

        all_turns = 100*reshape(numbers(LANES*MANY, 1), [LANES, MANY])
        all_turns(:, 1) = [(0.25_dp*i, i=-3, 4)]
        all_turns(:2, 2) = [0.0_dp, 1e-9_dp]
        do i = 1, MANY
            turns = all_turns(:, i)
            call lanes_sines_cosines(turns, sines, cosines)
            do lane = 1, LANES
                angle = TWO_PI*(turns(lane) - anint(turns(lane)))
                call check(error, abs(sines(lane) - sin(angle)) < NEAR .and. abs(cosines(lane) - cos(angle)) < NEAR)
                if (allocated(error)) return
            end do
            lane = 1 + modulo(i, LANES)
            turns(lane) = ieee_value(angle, ieee_quiet_nan)
            call lanes_sines_cosines(turns, again, other)
            call check(error, ieee_is_nan(again(lane)) .and. ieee_is_nan(other(lane)) .and. &
                       count(abs(again - sines) <= 0 .and. abs(other - cosines) <= 0) == LANES - 1)
            if (allocated(error)) return
        end do
        call lanes_sines_cosines(all_turns(:, 2), sines, cosines)
        call check(error, abs(sines(1)) + abs(cosines(1) - 1) <= 0)
        if (allocated(error)) return
        call check(error, sines(2), TWO_PI*1e-9_dp, thr=1e-23_dp)
    end subroutine test_sines

    !> Numbers of which every sum is exact, each in every place; and that a small one beside a great one and its opposite stays
    !> in pairs.
    subroutine test_total(error)
        type(error_type), allocatable, intent(out) :: error

        real(dp) :: x(LANES)
        integer :: i

        x = [(2.0_dp**i, i=1, LANES)]
        do i = 1, LANES
            x = cshift(x, 1)
            call check(error, abs(total_of(x) - (2.0_dp**(LANES + 1) - 2)) <= 0)
            if (allocated(error)) return
        end do
        x = [1e16_dp, 1.0_dp, 0.0_dp, 0.0_dp, -1e16_dp, 1.0_dp, 0.0_dp, 0.0_dp]
        call check(error, abs(total_of(x) - 2) <= 0)
    end subroutine test_total
end module test_lanes
