!> Inner loops over series, or parameters, that lie side by side in memory ("lanes"), in arrays of fixed shape: the compiler
!> makes vectors of them, of the width of the processor that it compiles for. Sums have one order. Without `omp simd`
!> gfortran unrolls loops so short before it looks for vectors, and finds none (4 times slower).
module gracecg_base_lanes
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    implicit none
    private
    public :: LANES
    public :: lanes_of, lanes_filter, lanes_carry, lanes_sines_cosines, lanes_exponentials, lanes_logarithms, lanes_erfc, total_of

    integer, parameter :: LANES = 8             !! Numbers of the widest vector: what lies side by side is a multiple of it

contains

    !> A number made up to a multiple of LANES.
    pure integer function lanes_of(n)
        integer, intent(in) :: n        !! At least 0

        lanes_of = LANES*((n + LANES - 1)/LANES)
    end function lanes_of

    !> Kalman filter of series: innovations by their deviations in place of the samples. The transition of the states from
    !> one sample to the next is diagonal but for pairs of neighbours.
    pure subroutine lanes_filter(places, kept, predicts, output, gain, inverse_deviation, on, series, paired, below, above)
        integer, intent(in) :: places(:)            !! The series to filter, rows of `series`
        logical, intent(in) :: kept(:)              !! (samples); the filter does not learn of the others
        logical, intent(in) :: predicts             !! The others get the innovation that they would have, not 0
        real(dp), intent(in) :: output(:)           !! Of the states
        real(dp), contiguous, intent(in) :: gain(:, :)      !! (states, samples)
        real(dp), intent(in) :: inverse_deviation(:)        !! Of the innovations, (samples)
        real(dp), contiguous, intent(in) :: on(:, :)        !! Diagonal of the transition, (states, samples)
        real(dp), intent(inout) :: series(:, :)             !! (series, samples)
        logical, intent(in), optional :: paired(:)          !! States with the next one. Absent: none
        real(dp), contiguous, intent(in), optional :: below(:, :), above(:, :)  !! Phi(j, j - 1) and Phi(j, j + 1), as `on`

        real(dp) :: state(LANES, size(output)), expected(LANES), innovation(LANES)
        logical :: in_pairs(size(output))
        integer :: first, many, lane, i, j

        in_pairs = .false.
        if (present(paired)) in_pairs = paired
        do first = 0, size(places) - 1, LANES
            many = min(LANES, size(places) - first)
            state = 0
            expected = 0
            innovation = 0
            do i = 1, size(kept)
                do lane = 1, many
                    innovation(lane) = series(places(first + lane), i)
                end do
                innovation = innovation - expected
                if (.not. (kept(i) .or. predicts)) innovation = 0
                do lane = 1, many
                    series(places(first + lane), i) = innovation(lane)*inverse_deviation(i)
                end do
                if (.not. kept(i)) innovation = 0
                expected = 0
                j = 1
                do while (j <= size(output))
                    if (in_pairs(j)) then
                        call carry_pair(gain(j:, i), on(j:, i), below(j + 1, i), above(j, i), innovation, state(:, j:))
                        expected = expected + (output(j)*state(:, j) + output(j + 1)*state(:, j + 1))
                        j = j + 2
                        cycle
                    end if
                    !$omp simd
                    do lane = 1, LANES
                        state(lane, j) = on(j, i)*(state(lane, j) + gain(j, i)*innovation(lane))
                        expected(lane) = expected(lane) + output(j)*state(lane, j)
                    end do
                    j = j + 1
                end do
            end do
        end do
    end subroutine lanes_filter

    !> Two states that are coupled, from one sample to the next.
    pure subroutine carry_pair(gain, on, below, above, innovation, state)
        real(dp), intent(in) :: gain(2), on(2), below, above
        real(dp), intent(in) :: innovation(LANES)
        real(dp), intent(inout) :: state(LANES, 2)

        real(dp) :: one, other
        integer :: lane

        !$omp simd
        do lane = 1, LANES
            one = state(lane, 1) + gain(1)*innovation(lane)
            other = state(lane, 2) + gain(2)*innovation(lane)
            state(lane, 1) = on(1)*one + above*other
            state(lane, 2) = on(2)*other + below*one
        end do
    end subroutine carry_pair

    !> Carries pairs (u, w) of columns of three numbers along du/dt = w - omega x u, dw/dt = A u + B w + f by the classical
    !> method of Runge and Kutta, and gives dw/dt at the epochs, too.
    pure subroutine lanes_carry(pairs, steps, interval, omega, a, b, f, columns)
        integer, intent(in) :: pairs                !! A multiple of LANES
        integer, intent(in) :: steps                !! At least 0
        real(dp), intent(in) :: interval            !! A step
        real(dp), intent(in) :: omega(3, 0:2*steps), a(3, 3, 0:2*steps), b(3, 3, 0:2*steps)     !! At half steps
        real(dp), intent(in) :: f(pairs, 3, 0:2*steps)      !! Of each pair, at half steps
        real(dp), intent(inout) :: columns(pairs, 9, 0:steps)
        !! x, y, z of u, w and dw/dt; u and w at epoch 0 are given

        real(dp) :: x(LANES, 6), rate(LANES, 6, 0:4)
        integer :: first, last, k

        rate(:, :, 0) = 0
        do first = 1, pairs, LANES
            last = first + LANES - 1
            x = columns(first:last, :6, 0)
            do k = 0, steps
                call find_rate(2*k, 0.0_dp, rate(:, :, 0), rate(:, :, 1))
                columns(first:last, :6, k) = x
                columns(first:last, 7:, k) = rate(:, 4:, 1)
                if (k == steps) exit
                call find_rate(2*k + 1, interval/2, rate(:, :, 1), rate(:, :, 2))
                call find_rate(2*k + 1, interval/2, rate(:, :, 2), rate(:, :, 3))
                call find_rate(2*k + 2, interval, rate(:, :, 3), rate(:, :, 4))
                x = x + interval/6*((rate(:, :, 1) + rate(:, :, 4)) + 2*(rate(:, :, 2) + rate(:, :, 3)))
            end do
        end do

    contains

        !> The rates where another rate leads from x within a step. One loop: between its load and its store a lane stays in
        !> registers.
        pure subroutine find_rate(half, step, before, after)
            integer, intent(in) :: half
            real(dp), intent(in) :: step, before(LANES, 6)
            real(dp), intent(out) :: after(LANES, 6)

            real(dp) :: u1, u2, u3, w1, w2, w3
            integer :: l

            associate (o => omega(:, half), a => a(:, :, half), b => b(:, :, half), f => f(first:last, :, half))
                !$omp simd
                do l = 1, LANES
                    u1 = x(l, 1) + step*before(l, 1)
                    u2 = x(l, 2) + step*before(l, 2)
                    u3 = x(l, 3) + step*before(l, 3)
                    w1 = x(l, 4) + step*before(l, 4)
                    w2 = x(l, 5) + step*before(l, 5)
                    w3 = x(l, 6) + step*before(l, 6)
                    after(l, 1) = w1 - (o(2)*u3 - o(3)*u2)
                    after(l, 2) = w2 - (o(3)*u1 - o(1)*u3)
                    after(l, 3) = w3 - (o(1)*u2 - o(2)*u1)
                    after(l, 4) = (a(1, 1)*u1 + a(1, 2)*u2 + a(1, 3)*u3) + (b(1, 1)*w1 + b(1, 2)*w2 + b(1, 3)*w3) + f(l, 1)
                    after(l, 5) = (a(2, 1)*u1 + a(2, 2)*u2 + a(2, 3)*u3) + (b(2, 1)*w1 + b(2, 2)*w2 + b(2, 3)*w3) + f(l, 2)
                    after(l, 6) = (a(3, 1)*u1 + a(3, 2)*u2 + a(3, 3)*u3) + (b(3, 1)*w1 + b(3, 2)*w2 + b(3, 3)*w3) + f(l, 3)
                end do
            end associate
        end subroutine find_rate
    end subroutine lanes_carry

    !> The sum of numbers that lie side by side, in pairs.
    pure real(dp) function total_of(x) result(total)
        real(dp), intent(in) :: x(LANES)    !! Numbers

        real(dp) :: four(4)

        four = x(:4) + x(5:)
        total = (four(1) + four(3)) + (four(2) + four(4))
    end function total_of

    ! Functions of LANES numbers. Each stands in a procedure of its own, which is called from other files: of a loop that is no
    ! other's inner loop gfortran makes calls of the C library's vector functions (good to 4 units of the last place).

    !> Sines and cosines of angles less their nearest whole turns, 6e-16 off at most.
    pure subroutine lanes_sines_cosines(turns, sines, cosines)
        real(dp), intent(in) :: turns(LANES)    !! Of 360 deg; less than 2^51
        real(dp), intent(out) :: sines(LANES), cosines(LANES)   !! Of the angles

        real(dp), parameter :: NO_FRACTION = 1.5_dp*2.0_dp**52     ! numbers of this size are whole
        real(dp) :: angle(LANES)

        angle = TWO_PI*(turns - ((turns + NO_FRACTION) - NO_FRACTION))
        sines = sin(angle)
        cosines = cos(angle)
    end subroutine lanes_sines_cosines

    !> The exponential function.
    pure subroutine lanes_exponentials(x, y)
        real(dp), intent(in) :: x(LANES)    !! Any numbers
        real(dp), intent(out) :: y(LANES)   !! exp(x)

        y = exp(x)
    end subroutine lanes_exponentials

    !> The natural logarithm.
    pure subroutine lanes_logarithms(x, y)
        real(dp), intent(in) :: x(LANES)    !! Positive
        real(dp), intent(out) :: y(LANES)   !! log(x)

        y = log(x)
    end subroutine lanes_logarithms

    !> The complementary error function.
    pure subroutine lanes_erfc(x, y)
        real(dp), intent(in) :: x(LANES)    !! Any numbers
        real(dp), intent(out) :: y(LANES)   !! erfc(x)

        y = erfc(x)
    end subroutine lanes_erfc
end module gracecg_base_lanes
