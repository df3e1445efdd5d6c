!> Inner loops over numbers that lie side by side in memory ("lanes"): functions of LANES of them, and over series, or
!> parameters, kernels in C (lanes.c), of which the variant for the processor's widest vectors is taken when the program runs.
module gracecg_base_lanes
    use, intrinsic :: iso_c_binding, only: c_double, c_int32_t
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    implicit none
    private
    public :: LANES, MOST_LANES, MOST_ROWS, POLES, LEFT_OUT, PREDICTED, USED, WIDEST
    public :: lanes_of, lanes_whiten, lanes_filter, lanes_add_products, lanes_carry, lanes_combine, lanes_reflect, &
        lanes_sines_cosines, lanes_exponentials, lanes_logarithms, lanes_erfc, total_of

    integer, parameter :: LANES = 8             !! Numbers of the widest vector: what lies side by side is a multiple of it
    integer, parameter :: MOST_LANES = 3*LANES  !! Series of one call
    integer, parameter :: MOST_ROWS = 16        !! Other rows of `lanes_reflect`
    integer, parameter :: POLES = 10            !! States of `lanes_whiten`
    integer(c_int32_t), parameter :: LEFT_OUT = 0, PREDICTED = 1, USED = 2
    !! What is done with a sample: nothing, it becomes 0; its innovation is given and the filter does not learn of it; both
    integer(c_int32_t), parameter :: WIDEST = LANES     !! Numbers of a vector; less where the processor has no such

    interface
        !> Kalman filter of series, every state with its own decay and with 1 as output: innovations by their deviations
        !> in place of the samples.
        pure subroutine lanes_whiten(widest, lanes, samples, carried, role, gain, inverse_deviation, decay, state, series) &
            bind(c, name='gracecg_lanes_whiten')
            import :: c_double, c_int32_t, POLES
            integer(c_int32_t), intent(in), value :: widest     !! Most numbers of a vector: 2, 4 or 8
            integer(c_int32_t), intent(in), value :: lanes      !! Series: LANES, 2 LANES or 3 LANES
            integer(c_int32_t), intent(in), value :: samples, carried   !! After how many of them there is a next one
            integer(c_int32_t), intent(in) :: role(samples)     !! LEFT_OUT, PREDICTED or USED
            real(c_double), intent(in) :: gain(POLES, samples)
            real(c_double), intent(in) :: inverse_deviation(samples)
            real(c_double), intent(in) :: decay(POLES, samples) !! To the next sample
            real(c_double), intent(inout) :: state(lanes, POLES)    !! Before the first sample, and after the last
            real(c_double), intent(inout) :: series(lanes, samples)
        end subroutine lanes_whiten

        !> The same for states of any output, coupled in pairs: the transition has three diagonals.
        pure subroutine lanes_filter(widest, states, lanes, samples, carried, role, coupled, output, gain, inverse_deviation, &
                                     below, on, above, state, series) bind(c, name='gracecg_lanes_filter')
            import :: c_double, c_int32_t
            integer(c_int32_t), intent(in), value :: widest     !! Most numbers of a vector: 2, 4 or 8
            integer(c_int32_t), intent(in), value :: states
            integer(c_int32_t), intent(in), value :: lanes      !! Series: LANES, 2 LANES or 3 LANES
            integer(c_int32_t), intent(in), value :: samples, carried   !! After how many of them there is a next one
            integer(c_int32_t), intent(in) :: role(samples)     !! LEFT_OUT, PREDICTED or USED
            integer(c_int32_t), intent(in) :: coupled(states)   !! Not 0: to a neighbour
            real(c_double), intent(in) :: output(states)
            real(c_double), intent(in) :: gain(states, samples)
            real(c_double), intent(in) :: inverse_deviation(samples)
            real(c_double), intent(in), dimension(states, samples) :: below, on, above  !! The diagonals, to the next sample
            real(c_double), intent(inout) :: state(lanes, states)   !! Before the first sample, and after the last
            real(c_double), intent(inout) :: series(lanes, samples)
        end subroutine lanes_filter

        !> Adds the products of observations, one after the other, to the upper triangle of a normal matrix and to its
        !> right-hand side. Below the diagonal anything may stand then.
        pure subroutine lanes_add_products(widest, n, stride, m, rows, observed, normal, rhs) &
            bind(c, name='gracecg_lanes_add_products')
            import :: c_double, c_int32_t
            integer(c_int32_t), intent(in), value :: widest     !! Most numbers of a vector: 2, 4 or 8
            integer(c_int32_t), intent(in), value :: n          !! Parameters
            integer(c_int32_t), intent(in), value :: stride     !! n made up to a multiple of LANES
            integer(c_int32_t), intent(in), value :: m          !! Observations, a multiple of 4
            real(c_double), intent(in) :: rows(stride, m), observed(m)
            real(c_double), intent(inout) :: normal(stride, n), rhs(stride)
        end subroutine lanes_add_products

        !> Carries pairs (u, w) of columns of three numbers along du/dt = w - omega x u, dw/dt = A u + B w + f by the
        !> classical method of Runge and Kutta, and gives dw/dt at the epochs, too.
        pure subroutine lanes_carry(widest, lanes, steps, interval, omega, a, b, f, columns) bind(c, name='gracecg_lanes_carry')
            import :: c_double, c_int32_t
            integer(c_int32_t), intent(in), value :: widest     !! Most numbers of a vector: 2, 4 or 8
            integer(c_int32_t), intent(in), value :: lanes      !! Pairs, made up to a multiple of LANES
            integer(c_int32_t), intent(in), value :: steps      !! At least 0
            real(c_double), intent(in), value :: interval       !! A step
            real(c_double), intent(in) :: omega(3, 0:2*steps), a(3, 3, 0:2*steps), b(3, 3, 0:2*steps)   !! At half steps
            real(c_double), intent(in) :: f(lanes, 3, 0:2*steps)    !! Of each pair, at half steps
            real(c_double), intent(inout) :: columns(lanes, 9, 0:steps)
            !! x, y, z of u, w and dw/dt; u and w at epoch 0 are given
        end subroutine lanes_carry

        !> Linear combinations of columns, each by weights of its own.
        pure subroutine lanes_combine(widest, lanes, stride, n, m, columns, weights, combined) bind(c, name='gracecg_lanes_combine')
            import :: c_double, c_int32_t
            integer(c_int32_t), intent(in), value :: widest     !! Most numbers of a vector: 2, 4 or 8
            integer(c_int32_t), intent(in), value :: lanes      !! Numbers of a column, any
            integer(c_int32_t), intent(in), value :: stride     !! From the first number of a column to that of the next
            integer(c_int32_t), intent(in), value :: n, m       !! Columns, at least 1, and combinations
            real(c_double), intent(in) :: columns(stride, *)
            real(c_double), intent(in) :: weights(m, n)
            real(c_double), intent(out) :: combined(lanes, m)
        end subroutine lanes_combine

        !> Householder's reflection of a row and others that makes the elements of the others in a column vanish. Elements
        !> before that column must be zero in all of them.
        pure subroutine lanes_reflect(widest, lanes, column, n, row, others) bind(c, name='gracecg_lanes_reflect')
            import :: c_double, c_int32_t
            integer(c_int32_t), intent(in), value :: widest     !! Most numbers of a vector: 2, 4 or 8
            integer(c_int32_t), intent(in), value :: lanes      !! Elements of a row, made up to a multiple of LANES
            integer(c_int32_t), intent(in), value :: column     !! From 1 on
            integer(c_int32_t), intent(in), value :: n          !! Other rows, at most MOST_ROWS
            real(c_double), intent(inout) :: row(lanes), others(lanes, n)
        end subroutine lanes_reflect
    end interface

contains

    !> A number made up to a multiple of LANES.
    pure integer function lanes_of(n)
        integer, intent(in) :: n        !! At least 0

        lanes_of = LANES*((n + LANES - 1)/LANES)
    end function lanes_of

    !> The sum of numbers that lie side by side, in pairs.
    pure real(dp) function total_of(x) result(total)
        real(dp), intent(in) :: x(LANES)

        real(dp) :: four(4)

        four = x(:4) + x(5:)
        total = (four(1) + four(3)) + (four(2) + four(4))
    end function total_of

    ! Functions of LANES numbers. Each stands in a procedure of its own, which is called from other files: of a loop that is no
    ! other's inner loop gfortran makes calls of the C library's vector functions (good to 4 units of the last place).

    !> Sines and cosines of angles less their nearest whole turns, 6e-16 off at most.
    pure subroutine lanes_sines_cosines(turns, sines, cosines)
        real(dp), intent(in) :: turns(LANES)    !! Of 360 deg; less than 2^51
        real(dp), intent(out) :: sines(LANES), cosines(LANES)

        real(dp), parameter :: NO_FRACTION = 1.5_dp*2.0_dp**52     ! numbers of this size are whole
        real(dp) :: angle(LANES)

        angle = TWO_PI*(turns - ((turns + NO_FRACTION) - NO_FRACTION))
        sines = sin(angle)
        cosines = cos(angle)
    end subroutine lanes_sines_cosines

    !> The exponential function.
    pure subroutine lanes_exponentials(x, y)
        real(dp), intent(in) :: x(LANES)
        real(dp), intent(out) :: y(LANES)

        y = exp(x)
    end subroutine lanes_exponentials

    !> The natural logarithm.
    pure subroutine lanes_logarithms(x, y)
        real(dp), intent(in) :: x(LANES)    !! Positive
        real(dp), intent(out) :: y(LANES)

        y = log(x)
    end subroutine lanes_logarithms

    !> The complementary error function.
    pure subroutine lanes_erfc(x, y)
        real(dp), intent(in) :: x(LANES)
        real(dp), intent(out) :: y(LANES)

        y = erfc(x)
    end subroutine lanes_erfc
end module gracecg_base_lanes
