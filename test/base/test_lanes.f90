!> The kernels over what lies side by side, against the same work done plainly.
module test_lanes
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use vocabulary
    use gracecg_base_lanes, only: LANES, lanes_of, lanes_filter, lanes_sines_cosines, total_of
    implicit none
    private
    public :: collect_lanes

    real(dp), parameter :: CLOSE = 1e-13_dp     ! relative, of sums of some hundred terms

contains

    subroutine collect_lanes(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('multiples-of-lanes', test_multiples), &
                    new_unittest('filter-of-separate-states', test_filter), &
                    new_unittest('filter-of-paired-states', test_pairs), &
                    new_unittest('filter-without-states', test_no_states), &
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

    !> What a filter does, plainly.
    subroutine filter_plainly(places, kept, predicts, output, gain, inverse_deviation, transition, series)
        integer, intent(in) :: places(:)
        logical, intent(in) :: kept(:), predicts
        real(dp), intent(in) :: output(:), gain(:, :), inverse_deviation(:), transition(:, :, :)
        real(dp), intent(inout) :: series(:, :)
        real(dp) :: state(size(output)), innovation
        integer :: i, k

        do k = 1, size(places)
            state = 0
            do i = 1, size(kept)
                innovation = series(places(k), i) - dot_product(output, state)
                series(places(k), i) = merge(innovation*inverse_deviation(i), 0.0_dp, kept(i) .or. predicts)
                if (.not. kept(i)) innovation = 0
                state = matmul(transition(:, :, i), state + gain(:, i)*innovation)
            end do
        end do
    end subroutine filter_plainly

    !> Series in other places stay as they are; what is not kept may be anything, a NaN, too.
    subroutine test_filter(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: SAMPLES = 50, STATES = 10, COUNTS(4) = [1, 8, LANES, 2*LANES + 5]
        real(dp), dimension(STATES, SAMPLES) :: gain, on
        real(dp) :: inverse_deviation(SAMPLES), output(STATES), transition(STATES, STATES, SAMPLES)
        real(dp), allocatable :: series(:, :), plain(:, :)
        integer, allocatable :: places(:)
        logical :: kept(SAMPLES)
        integer :: i, j, m

        gain = reshape(0.02_dp*numbers(size(gain), 1), shape(gain))
        on = reshape(exp(-abs(numbers(size(on), 2))), shape(on))
        inverse_deviation = abs(numbers(SAMPLES, 3))
        output = numbers(STATES, 5)
        kept = .true.
        kept([7, 8, 30]) = .false.
        transition = 0
        do i = 1, SAMPLES
            do j = 1, STATES
                transition(j, j, i) = on(j, i)
            end do
        end do
        do m = 1, size(COUNTS)
            places = [(2*i, i=COUNTS(m), 1, -1)]
            series = reshape(numbers((2*COUNTS(m) + 1)*SAMPLES, 4), [2*COUNTS(m) + 1, SAMPLES])
            plain = series
            call filter_plainly(places, kept, .true., output, gain, inverse_deviation, transition, plain)
            call lanes_filter(places, kept, .true., output, gain, inverse_deviation, on, series)
            call check(error, close_to(pack(series, .true.), pack(plain, .true.)), 'predicted')
            call filter_plainly(places, kept, .false., output, gain, inverse_deviation, transition, plain)
            series(2, 30) = NAN
            call lanes_filter(places, kept, .false., output, gain, inverse_deviation, on, series)
            call check(error, close_to(pack(series, .true.), pack(plain, .true.)), 'left out')
        end do
    end subroutine test_filter

    subroutine test_pairs(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: SAMPLES = 40, STATES = 6, SERIES = LANES + 3
        logical, parameter :: PAIRED(STATES) = [.false., .true., .false., .true., .false., .false.]
        real(dp), dimension(STATES, SAMPLES) :: gain, below, on, above
        real(dp) :: inverse_deviation(SAMPLES), output(STATES), transition(STATES, STATES, SAMPLES)
        real(dp) :: values(SERIES, SAMPLES), plain(SERIES, SAMPLES)
        logical :: kept(SAMPLES)
        integer :: i, j

        gain = reshape(0.1_dp*numbers(size(gain), 11), shape(gain))
        on = reshape(0.4_dp*numbers(size(gain), 12), shape(gain))
        below = reshape(0.4_dp*numbers(size(gain), 13), shape(gain))
        above = reshape(0.4_dp*numbers(size(gain), 14), shape(gain))
        inverse_deviation = abs(numbers(SAMPLES, 15))
        output = numbers(STATES, 16)
        kept = .true.
        kept([1, 9, 20]) = .false.
        transition = 0
        do i = 1, SAMPLES
            do j = 1, STATES
                transition(j, j, i) = on(j, i)
                if (.not. PAIRED(j)) cycle
                transition(j, j + 1, i) = above(j, i)
                transition(j + 1, j, i) = below(j + 1, i)
            end do
        end do
        values = reshape(numbers(size(values), 17), shape(values))
        plain = values
        call filter_plainly([(i, i=1, SERIES)], kept, .true., output, gain, inverse_deviation, transition, plain)
        call lanes_filter([(i, i=1, SERIES)], kept, .true., output, gain, inverse_deviation, on, values, PAIRED, below, above)
        call check(error, close_to(pack(values, .true.), pack(plain, .true.)))
    end subroutine test_pairs

    !> White noise: samples by their deviations, but those left out.
    subroutine test_no_states(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: SAMPLES = 5
        logical, parameter :: KEPT(SAMPLES) = [.true., .true., .false., .true., .true.]
        real(dp), dimension(0, SAMPLES) :: gain, on
        real(dp) :: output(0), inverse_deviation(SAMPLES), series(3, SAMPLES), plain(3, SAMPLES)

        inverse_deviation = abs(numbers(SAMPLES, 21))
        series = reshape(numbers(size(series), 22), shape(series))
        plain = series*spread(merge(inverse_deviation, 0.0_dp, KEPT), 1, 3)
        call lanes_filter([1, 2, 3], KEPT, .false., output, gain, inverse_deviation, on, series)
        call check(error, close_to(pack(series, .true.), pack(plain, .true.)))
    end subroutine test_no_states

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
            end do
            lane = 1 + modulo(i, LANES)
            turns(lane) = NAN
            call lanes_sines_cosines(turns, again, other)
            call check(error, ieee_is_nan(again(lane)) .and. ieee_is_nan(other(lane)) .and. &
                       count(abs(again - sines) <= 0 .and. abs(other - cosines) <= 0) == LANES - 1)
        end do
        call lanes_sines_cosines(all_turns(:, 2), sines, cosines)
        call check(error, abs(sines(1)) + abs(cosines(1) - 1) <= 0)
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
        end do
        x = [1e16_dp, 1.0_dp, 0.0_dp, 0.0_dp, -1e16_dp, 1.0_dp, 0.0_dp, 0.0_dp]
        call check(error, abs(total_of(x) - 2) <= 0)
    end subroutine test_total
end module test_lanes
