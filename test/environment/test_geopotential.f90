!> The geopotential: identities, independently computed values, and the reader of .gfc files.
module test_geopotential
    use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan, ieee_is_nan
    use vocabulary
    use gracecg_environment_geopotential
    use gracecg_environment_gfc_file, only: read_gfc
    use gracecg_environment_spherical_harmonics, only: harmonic_function_t, new_harmonic_function
    implicit none
    private
    public :: collect_geopotential

    real(dp), parameter :: ROUNDING = 2e-15_dp      !! Relative, of sums that the compiler may round in other ways
    character(*), parameter :: FIXTURES = 'test/fixtures/gfc/'

    !> Earth-fixed places, m: of the orbit, on the axis of rotation, high, at the ground
    real(dp), parameter :: PLACES(3, 8) = reshape([ &
        -2014520.5_dp, 3411000.25_dp, 5502211.75_dp, &
        6700000.0_dp, -900000.0_dp, -1200000.0_dp, &
        -310000.0_dp, -20000.0_dp, -6820000.0_dp, &
        0.0_dp, 0.0_dp, 6838000.0_dp, &
        0.0_dp, 0.0_dp, -6800000.0_dp, &
        1e-3_dp, -2e-3_dp, 6838000.0_dp, &
        -11000000.0_dp, 38000000.0_dp, 15000000.0_dp, &
        0.0_dp, -6378137.0_dp, 0.0_dp], [3, 8])

contains

    subroutine collect_geopotential(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('degree-0-and-far-away-a-point-mass', test_point_mass), &
                    new_unittest('independent-values', test_independent_values), &
                    new_unittest('highest-degree-in-closed-form', test_highest_degree), &
                    new_unittest('tensor-is-gradient-of-acceleration', test_tensor), &
                    new_unittest('all-derivatives-are-those-of-each', test_all_derivatives), &
                    new_unittest('many-places-give-what-each-gives', test_many_places), &
                    new_unittest('all-sums-of-lively-coefficients-agree', test_lively), &
                    new_unittest('no-number-in-no-number-out', test_no_number), &
                    new_unittest('poles-are-ordinary-places', test_poles), &
                    new_unittest('order-cuts-the-sum', test_order), &
                    new_unittest('bad-arguments-are-refused', test_bad_arguments), &
                    new_unittest('gfc-file', test_gfc_file), &
                    new_unittest('corrupted-gfc-files', test_corrupted_files)]
    end subroutine collect_geopotential

    subroutine test_point_mass(error)
        type(error_type), allocatable, intent(out) :: error
        type(geopotential_t) :: sphere, whole
        type(point_mass_gravity_t) :: point
        integer :: i

        call make_egm96(0, 0, sphere)
        do i = 1, size(PLACES, 2)
            call check_same(sphere, point, PLACES(:, i), 2e-15_dp, error)
        end do
        call make_egm96(70, 70, whole)
        call check_same(whole, point, [3e13_dp, -4e13_dp, 2e13_dp], 1e-14_dp, error)
    end subroutine test_point_mass

    !> Values of tools/reference_harmonics.py: from the definition (2-2), with 60 digits.
    subroutine test_independent_values(error)
        type(error_type), allocatable, intent(out) :: error

        call check_value(70, PLACES(:, 1), 58763605.928567090172_dp, &
                         [2.5678389571233584826_dp, -4.3482629179780556951_dp, &
                          -7.0341826230606550182_dp], error)
        call check_value(70, PLACES(:, 4), 58237269.104379094708_dp, &
                         [0.000095582666401714159361_dp, -0.000021080627972031441384_dp, &
                          -8.5007725111187633252_dp], error)
        call check_value(70, PLACES(:, 5), 58561800.436261638812_dp, &
                         [0.00015472516521194520321_dp, 0.000056536879484553903676_dp, &
                          8.5955700972299522691_dp], error)
        call check_value(20, PLACES(:, 2), 58080230.366135701053_dp, &
                         [-8.2612656539639121977_dp, 1.1097322801298736383_dp, &
                          1.483813081532904694_dp], error)
        call check_value(20, PLACES(:, 7), 9421380.918137811109_dp, &
                         [0.05789704411532077494_dp, -0.2000081724190522124_dp, &
                          -0.078956410195384659604_dp], error)
    end subroutine test_independent_values

    subroutine check_value(degree, place, potential, acceleration, error)
        integer, intent(in) :: degree
        real(dp), intent(in) :: place(3), potential, acceleration(3)
        type(error_type), allocatable, intent(inout) :: error
        type(geopotential_t) :: model
        real(dp) :: u, a(3)

        call make_egm96(degree, degree, model)
        call model%potential(place, u)
        call check(error, u, potential, thr=1e-14_dp, rel=.true.)
        call model%acceleration(place, a)
        call check(error, norm2(a - acceleration), 0.0_dp, thr=1e-14_dp*norm2(acceleration))
    end subroutine check_value

    !> Pbar_n0(1) = sqrt(2n + 1), and Pbar_nn(0)^2 = 2 (2n + 1)!!/(2n)!!, for n = 360.
    subroutine test_highest_degree(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 360
        real(dp), parameter :: MU = 4e14_dp, RADIUS = 6.4e6_dp, R = 6.41e6_dp, LONGITUDE = 0.3_dp
        type(geopotential_t) :: model
        type(error_t), allocatable :: failure
        real(dp), allocatable :: c(:, :), s(:, :)
        real(dp) :: u, sectorial
        integer :: k

        allocate (c(0:N, 0:N), s(0:N, 0:N), source=0.0_dp)
        c(N, 0) = 0.5_dp
        call new_geopotential('zonal', MU, RADIUS, c, s, N, 0, model, failure)
        if (failed(error, failure)) return
        call model%potential([0.0_dp, 0.0_dp, R], u)
        call check(error, u, MU/R*(RADIUS/R)**N*c(N, 0)*sqrt(2.0_dp*N + 1), &
                   thr=1e-12_dp, rel=.true.)

        c(N, 0) = 0
        s(N, N) = 0.25_dp
        call new_geopotential('sectorial', MU, RADIUS, c, s, N, N, model, failure)
        if (failed(error, failure)) return
        sectorial = sqrt(2*product([((2*k + 1)/(2.0_dp*k), k=1, N)]))
        call model%potential(R*[cos(LONGITUDE), sin(LONGITUDE), 0.0_dp], u)
        call check(error, u, MU/R*(RADIUS/R)**N*s(N, N)*sectorial*sin(N*LONGITUDE), &
                   thr=1e-12_dp, rel=.true.)
    end subroutine test_highest_degree

    subroutine test_tensor(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: STEP = 2000
        type(geopotential_t) :: model
        type(point_mass_gravity_t) :: point
        integer :: i

        call make_egm96(70, 70, model)
        do i = 1, size(PLACES, 2)
            if (.not. allocated(error)) call check_tensor(model, PLACES(:, i), error)
            if (.not. allocated(error)) call check_tensor(point, PLACES(:, i), error)
        end do

    contains

        subroutine check_tensor(model, place, error)
            class(gravity_model_t), intent(in) :: model
            real(dp), intent(in) :: place(3)
            type(error_type), allocatable, intent(inout) :: error
            real(dp) :: tensor(3, 3), a(3, -2:2), component(-2:2)
            integer :: axis, i, k

            call model%gradient_tensor(place, tensor)
            do axis = 1, 3
                do k = -2, 2
                    call model%acceleration(moved(place, axis, k*STEP), a(:, k))
                end do
                do i = 1, 3
                    component = a(i, :)
                    call check(error, tensor(i, axis), slope(component, STEP), thr=2e-16_dp)
                end do
            end do
        end subroutine check_tensor
    end subroutine test_tensor

    !> One recursion for all, and each by itself but for rounding (a compiler may fuse other products with sums); of a
    !> model that has the one by the others, too.
    subroutine test_all_derivatives(error)
        type(error_type), allocatable, intent(out) :: error
        type(geopotential_t) :: model
        type(point_mass_gravity_t) :: point
        integer :: i

        call make_egm96(70, 67, model)
        do i = 1, size(PLACES, 2)
            if (.not. allocated(error)) call compare(model, PLACES(:, i))
            if (.not. allocated(error)) call compare(point, PLACES(:, i))
        end do

    contains

        subroutine compare(model, place)
            class(gravity_model_t), intent(in) :: model
            real(dp), intent(in) :: place(3)
            real(dp) :: u(2), a(3, 2), tensor(3, 3, 2)

            call model%all_derivatives(place, u(1), a(:, 1), tensor(:, :, 1))
            call model%potential(place, u(2))
            call model%acceleration(place, a(:, 2))
            call model%gradient_tensor(place, tensor(:, :, 2))
            call check(error, abs(u(1) - u(2)) <= ROUNDING*abs(u(2)) .and. norm2(a(:, 1) - a(:, 2)) <= ROUNDING*norm2(a(:, 2)) &
                       .and. all(same(tensor(:, :, 1), tensor(:, :, 2))), 'other numbers')
        end subroutine compare
    end subroutine test_all_derivatives

    !> However many places are asked for at once: with the bits of one asked for, and but for rounding what `acceleration`
    !> and `potential` give.
    subroutine test_many_places(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: MOST = 19
        type(geopotential_t) :: model
        type(point_mass_gravity_t) :: point
        real(dp) :: places_of(3, MOST)
        integer :: i, n

        places_of = reshape([(PLACES(:, modulo(i, size(PLACES, 2)) + 1)*(1 + 0.01_dp*i), i=1, MOST)], [3, MOST])
        do n = 0, MOST
            call make_egm96(min(4*n, 70), 3*n, model)
            if (.not. allocated(error)) call compare(model, n)
            if (.not. allocated(error)) call compare(point, n)
        end do

    contains

        subroutine compare(model, n)
            class(gravity_model_t), intent(in) :: model
            integer, intent(in) :: n
            real(dp) :: a(3, n), b(3, n), u(n), v, single(3, 1)
            integer :: i

            call model%accelerations(places_of(:, :n), a, u)
            call model%accelerations(places_of(:, :n), b)
            call check(error, all(same(a, b)), 'with and without potential')
            do i = 1, n
                call model%accelerations(places_of(:, i:i), single)
                call model%acceleration(places_of(:, i), b(:, i))
                call model%potential(places_of(:, i), v)
                call check(error, all(same(a(:, i), single(:, 1))), 'other bits')
                call check(error, norm2(a(:, i) - b(:, i)) <= ROUNDING*norm2(b(:, i)) .and. abs(u(i) - v) <= ROUNDING*abs(v), &
                           'other numbers')
            end do
        end subroutine compare
    end subroutine test_many_places

    !> Every degree and order counts here: at one place, at many, and with second derivatives, whose trace is 0.
    subroutine test_lively(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 45
        type(harmonic_function_t) :: harmonic
        real(dp), dimension(0:N, 0:N) :: c, s
        real(dp) :: u, v, g(3), h(3), tensor(3, 3), many_u(size(PLACES, 2)), many_g(3, size(PLACES, 2))
        integer :: i

        call lively_coefficients(c, s)
        harmonic = new_harmonic_function(6.4e6_dp, 6e7_dp, c, s)
        call harmonic%gradients(PLACES, many_g, many_u)
        do i = 1, size(PLACES, 2)
            call harmonic%value(PLACES(:, i), v)
            call harmonic%gradient(PLACES(:, i), h)
            call harmonic%derivatives(PLACES(:, i), u, g, tensor)
            call check(error, max(abs(u - v), abs(many_u(i) - v))/abs(v), 0.0_dp, thr=1e-13_dp)
            call check(error, max(norm2(g - h), norm2(many_g(:, i) - h))/norm2(h), 0.0_dp, thr=1e-13_dp)
            call check(error, (tensor(1, 1) + tensor(2, 2) + tensor(3, 3))/norm2(tensor), 0.0_dp, thr=1e-13_dp)
        end do
    end subroutine test_lively

    !> A place that is not a number gives none, and leaves its neighbours alone; beyond all distances there is nothing.
    subroutine test_no_number(error)
        type(error_type), allocatable, intent(out) :: error
        type(geopotential_t) :: model
        real(dp) :: u, a(3), tensor(3, 3)
        real(dp), dimension(3, size(PLACES, 2)) :: places_of, many, expected
        integer :: axis, i

        call make_egm96(20, 20, model)
        call model%accelerations(PLACES, expected)
        do axis = 1, 3
            places_of = PLACES
            places_of(axis, 2) = NAN
            call model%all_derivatives(places_of(:, 2), u, a, tensor)
            call check(error, ieee_is_nan(u) .and. all(ieee_is_nan(a)) .and. all(ieee_is_nan(tensor)), 'a number at no place')
            call model%accelerations(places_of, many)
            call check(error, all(ieee_is_nan(many(:, 2))), 'a number at no place, among others')
            do i = 1, size(PLACES, 2)
                if (i == 2) cycle
                call check(error, all(same(many(:, i), expected(:, i))), 'the neighbour of no number')
            end do
        end do
        call model%all_derivatives([0.0_dp, 0.0_dp, 0.0_dp], u, a, tensor)
        call check(error, ieee_is_nan(u) .and. all(ieee_is_nan(a)) .and. all(ieee_is_nan(tensor)), 'a number at the centre')
        call model%all_derivatives(1e-3_dp*PLACES(:, 1), u, a, tensor)
        call check(error, ieee_is_nan(u) .and. all(ieee_is_nan(a)) .and. all(ieee_is_nan(tensor)), 'a number in kilometres')
        call model%all_derivatives([1e200_dp, 0.0_dp, -1e200_dp], u, a, tensor)
        call check(error, all(abs([u, a, tensor]) <= 0), 'gravity beyond all distances')
    end subroutine test_no_number

    elemental logical function same(a, b)
        real(dp), intent(in) :: a, b

        same = abs(a - b) <= 0
    end function same

    !> Over a metre and less a field changes as its tensor says, also across the axis of rotation.
    subroutine test_poles(error)
        type(error_type), allocatable, intent(out) :: error
        type(geopotential_t) :: model
        real(dp) :: tensor(3, 3), a(3), near(3), offset(3)
        integer :: i, pole

        call make_egm96(70, 70, model)
        do pole = 4, 5
            call model%gradient_tensor(PLACES(:, pole), tensor)
            call model%acceleration(PLACES(:, pole), a)
            do i = 0, 11
                offset = [cos(30*i*DEGREE), sin(30*i*DEGREE), 0.0_dp]*10.0_dp**(i - 11)
                call model%acceleration(PLACES(:, pole) + offset, near)
                call check(error, norm2(near - a - matmul(tensor, offset)), 0.0_dp, thr=5e-12_dp)
            end do
        end do
    end subroutine test_poles

    subroutine test_order(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 9, M = 5
        type(geopotential_t) :: cut, zeroed
        type(error_t), allocatable :: failure
        real(dp), dimension(0:N, 0:N) :: c, s
        integer :: i

        call lively_coefficients(c, s)
        call new_geopotential('a', 4e14_dp, 6.4e6_dp, c, s, N, M, cut, failure)
        if (failed(error, failure)) return
        c(:, M + 1:) = 0
        s(:, M + 1:) = 0
        call new_geopotential('b', 4e14_dp, 6.4e6_dp, c, s, N, N, zeroed, failure)
        call check_passes(error, failure)
        do i = 1, size(PLACES, 2)
            if (.not. allocated(error)) call check_same(cut, zeroed, PLACES(:, i), 1e-15_dp, error)
        end do
    end subroutine test_order

    subroutine test_bad_arguments(error)
        type(error_type), allocatable, intent(out) :: error
        type(geopotential_t) :: model, not_made
        type(error_t), allocatable :: failure
        real(dp) :: c(0:2, 0:2), s(0:2, 0:2), a(3)

        call egm96(71, 0, model, failure)
        call check_fails(error, failure, 'degree = 71 is outside the allowed range 0 to 70')
        call egm96(-1, 0, model, failure)
        call check_fails(error, failure, 'degree = -1')
        call egm96(20, 21, model, failure)
        call check_fails(error, failure, 'order = 21 is outside the allowed range 0 to 20')
        c = 0
        s = 0
        call new_geopotential('x', 4e14_dp, 6e6_dp, c, s, 3, 0, model, failure)
        call check_fails(error, failure, 'degree = 3')
        call new_geopotential('x', 4e14_dp, 6e6_dp, c(:, :1), s(:, :1), 2, 2, model, failure)
        call check_fails(error, failure, 'no coefficients up to order 2')
        call new_geopotential('x', -4e14_dp, 6e6_dp, c, s, 2, 2, model, failure)
        call check_fails(error, failure, 'must be positive')
        s(2, 1) = ieee_value(s(2, 1), ieee_quiet_nan)
        call new_geopotential('x', 4e14_dp, 6e6_dp, c, s, 2, 2, model, failure)
        call check_fails(error, failure, 'not a finite number')
        call not_made%acceleration([7e6_dp, 0.0_dp, 0.0_dp], a)
        call check(error, all(ieee_is_nan(a)), 'a model that was not made')
    end subroutine test_bad_arguments

    !> Files with the figures of EGM96: head complete or not, lines in order or not.
    subroutine test_gfc_file(error)
        type(error_type), allocatable, intent(out) :: error
        type(geopotential_t) :: from_file, embedded
        type(error_t), allocatable :: failure
        integer :: i

        call make_egm96(3, 3, embedded)
        call read_gfc(FIXTURES//'valid.gfc', 3, 3, from_file, failure)
        call check_passes(error, failure)
        call check(error, from_file%name, 'EGM96-to-degree-3')
        do i = 1, size(PLACES, 2)
            call check_same(from_file, embedded, PLACES(:, i), 1e-15_dp, error)
        end do
        call make_egm96(2, 1, embedded)
        call read_gfc(FIXTURES//'valid-without-end-of-head.gfc', 2, 1, from_file, failure)
        call check_passes(error, failure)
        call check_same(from_file, embedded, PLACES(:, 1), 1e-15_dp, error)
    end subroutine test_gfc_file

    subroutine test_corrupted_files(error)
        type(error_type), allocatable, intent(out) :: error

        call refuse('no-such-file', 'no-such-file.gfc', error)
        call refuse('corrupted-empty', 'empty.gfc: holds no data', error)
        call refuse('corrupted-no-gravity-constant', 'does not give earth_gravity_constant', error)
        call refuse('corrupted-no-radius', 'does not give radius', error)
        call refuse('corrupted-no-max-degree', 'does not give max_degree', error)
        call refuse('corrupted-negative-radius', '.gfc:7: radius = -6.3781363E+06', error)
        call refuse('corrupted-kilometres', '.gfc:6: earth_gravity_constant = 3.986004415E+05 cannot be used; allowed: 3.9e14 to', &
                    error)
        call refuse('corrupted-small-radius', '.gfc:7: radius = 0.5 cannot be used; allowed: 6.3e6 to 6.5e6, in m', error)
        call refuse('corrupted-norm', '.gfc:9: norm = unnormalized', error)
        call refuse('corrupted-product', '.gfc:4: product_type = topography', error)
        call refuse('corrupted-errors', '.gfc:11: errors = perhaps', error)
        call refuse('corrupted-no-coefficients', 'there is no line "gfc', error)
        call refuse('corrupted-nan', '.gfc:21: C: "NaN" is not a finite number', error)
        call refuse('corrupted-coefficient', '.gfc:18: C', error)
        call refuse('corrupted-number', 'is not a finite number', error)
        call refuse('corrupted-sigma', '.gfc:21: column 6: "1.3965165D-10x" is not a finite', error)
        call refuse('corrupted-beyond-degree', '.gfc:23: column 4: "--7.210726570570D-07"', error, degree=2)
        call refuse('corrupted-missing', 'no coefficient of degree 3, order 1', error)
        call refuse('corrupted-duplicate', '.gfc:22: this degree and order was given', error)
        call refuse('corrupted-order', '.gfc:21: order: ', error)
        call refuse('corrupted-time-variable', '.gfc:21: coefficients that change', error)
        call refuse('corrupted-key', '.gfc:21: expected a line "gfc n m C S"', error)
        call refuse('corrupted-truncated', '.gfc:23: expected at least 7 fields', error)
        call refuse('valid', 'degree = 4 is outside the allowed range 0 to 3', error, degree=4)
    end subroutine test_corrupted_files

    !> Checks that a file is refused with a message that holds `part`; does nothing after a failure.
    subroutine refuse(name, part, error, degree)
        character(*), intent(in) :: name, part
        type(error_type), allocatable, intent(inout) :: error
        integer, intent(in), optional :: degree
        type(geopotential_t) :: model
        type(error_t), allocatable :: failure
        integer :: n

        n = 3
        if (present(degree)) n = degree
        call read_gfc(FIXTURES//name//'.gfc', n, n, model, failure)
        call check_fails(error, failure, part)
    end subroutine refuse

    subroutine make_egm96(degree, order, model)
        integer, intent(in) :: degree, order
        type(geopotential_t), intent(out) :: model
        type(error_t), allocatable :: failure

        call egm96(degree, order, model, failure)
        call need(failure)
    end subroutine make_egm96

    !> Coefficients of arbitrary size and sign, around a central term.
    subroutine lively_coefficients(c, s)
        real(dp), intent(out) :: c(0:, 0:), s(0:, 0:)
        integer :: n, m

        do m = 0, ubound(c, 2)
            do n = 0, ubound(c, 1)
                c(n, m) = 0.02_dp*cos(1.7_dp*n + 2.9_dp*m)
                s(n, m) = 0.02_dp*sin(2.3_dp*n + 0.4_dp*m)
            end do
        end do
        c(0, 0) = 1
    end subroutine lively_coefficients

    subroutine check_same(model, other, place, tolerance, error)
        class(gravity_model_t), intent(in) :: model, other
        real(dp), intent(in) :: place(3), tolerance     !! m; relative
        type(error_type), allocatable, intent(inout) :: error
        real(dp) :: u, v, a(3), b(3), t(3, 3), w(3, 3)

        call model%potential(place, u)
        call other%potential(place, v)
        call check(error, u, v, thr=tolerance, rel=.true.)
        call model%acceleration(place, a)
        call other%acceleration(place, b)
        call check(error, norm2(a - b)/norm2(b), 0.0_dp, thr=tolerance)
        call model%gradient_tensor(place, t)
        call other%gradient_tensor(place, w)
        call check(error, norm2(t - w)/norm2(w), 0.0_dp, thr=tolerance)
    end subroutine check_same

    pure function moved(place, axis, distance)
        real(dp), intent(in) :: place(3), distance
        integer, intent(in) :: axis
        real(dp) :: moved(3)

        moved = place
        moved(axis) = moved(axis) + distance
    end function moved

    !> First derivative from five equidistant values; the error is of fourth order.
    pure real(dp) function slope(f, step)
        real(dp), intent(in) :: f(-2:2), step

        slope = (8*(f(1) - f(-1)) - (f(2) - f(-2)))/(12*step)
    end function slope
end module test_geopotential
