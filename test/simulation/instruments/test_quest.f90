!> QUEST against the exact eigenvector, and its covariance against its scatter.
module test_quest
    use vocabulary
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_product, conjugate_quaternion, &
        quaternion_from_axis_angle, normalised
    use gracecg_simulation_quest, only: quest, q_method
    use statistics, only: Z_999, chi_square_limits
    implicit none
    private
    public :: collect_quest, random_attitude

    integer, parameter :: QUADRUPLE = selected_real_kind(33), EXTENDED = selected_real_kind(18)
    integer, parameter :: qp = max(dp, merge(QUADRUPLE, EXTENDED, QUADRUPLE > 0))    !! The longest kind of the compiler
    real(dp), parameter :: TOLERANCE = 1e-12_dp
    real(dp), parameter :: NOISE = 3*ARCSECOND

contains

    subroutine collect_quest(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('exact-directions', test_exact), &
                    new_unittest('agrees-for-random-attitudes-and-clustered-stars', test_random_attitudes), &
                    new_unittest('agrees-near-180-deg', test_half_turns), &
                    new_unittest('agrees-for-two-stars', test_two_stars), &
                    new_unittest('agrees-for-gross-errors', test_gross_errors), &
                    new_unittest('loss-is-minimal', test_minimum), &
                    new_unittest('covariance-is-that-of-the-errors', test_covariance), &
                    new_unittest('loss-distribution', test_loss), &
                    new_unittest('rejects-what-has-no-attitude', test_failures)]
    end subroutine collect_quest

    !> Stars within a cone about the camera's z axis, and noisy observations of them.
    subroutine make_stars(stream, q, radius, noise, observed, reference)
        type(random_stream_t), intent(inout) :: stream
        real(dp), intent(in) :: q(4)            !! Reference to camera frame
        real(dp), intent(in) :: radius          !! Of the cone, rad
        real(dp), intent(in) :: noise           !! rad
        real(dp), intent(out) :: observed(:, :), reference(:, :)
        real(dp) :: m(3, 3), v(3), x(3), height, azimuth
        integer :: i

        m = rotation_matrix(q)
        do i = 1, size(observed, 2)
            height = 1 - stream%uniform()*(1 - cos(radius))
            azimuth = 2*PI*stream%uniform()
            v = [sqrt(1 - height**2)*[cos(azimuth), sin(azimuth)], height]
            reference(:, i) = matmul(transpose(m), v)
            call stream%normals(x)
            observed(:, i) = unit(v + noise*(x - dot_product(x, v)*v))
        end do
    end subroutine make_stars

    function random_attitude(stream) result(q)
        type(random_stream_t), intent(inout) :: stream
        real(dp) :: q(4)

        call stream%normals(q)
        q = normalised(q)
        if (q(4) < 0) q = -q
    end function random_attitude

    !> Davenport's eigenproblem in the longest precision that the compiler has: Rayleigh quotient iteration on K summed from
    !> the stars, started from an approximate q.
    function exact_attitude(observed, reference, deviation, start) result(q)
        real(dp), intent(in) :: observed(:, :), reference(:, :), deviation(:), start(4)
        real(dp) :: q(4)

        real(qp) :: k(4, 4), b(3, 3), a(size(deviation)), x(4), shifted(4, 4)
        integer :: i, j, l

        a = 1/real(deviation, qp)**2
        a = a/sum(a)
        b = 0
        do i = 1, size(a)
            do j = 1, 3
                do l = 1, 3
                    b(l, j) = b(l, j) + a(i)*real(observed(l, i), qp)*real(reference(j, i), qp)
                end do
            end do
        end do
        k(1:3, 1:3) = b + transpose(b) - (b(1, 1) + b(2, 2) + b(3, 3))*real(identity(3), qp)
        k(4, 1:3) = [b(2, 3) - b(3, 2), b(3, 1) - b(1, 3), b(1, 2) - b(2, 1)]
        k(1:3, 4) = k(4, 1:3)
        k(4, 4) = b(1, 1) + b(2, 2) + b(3, 3)
        x = start
        do i = 1, 3
            x = unit_of(x)
            ! A shift a little off the eigenvalue keeps the matrix regular.
            shifted = k - (dot_product(x, matmul(k, x)) + max(1e-25_qp, 10*epsilon(1.0_qp)))*real(identity(4), qp)
            x = solution(shifted, x)
        end do
        q = real(unit_of(x), dp)
        if (q(4) < 0) q = -q
    end function exact_attitude

    !> A square root in double precision and two steps of Newton: a compiler may have the longest kind, but no root of it
    !> (flang 22 of Debian).
    pure function unit_of(x) result(unit)
        real(qp), intent(in) :: x(4)
        real(qp) :: unit(4)

        real(qp) :: scaled(4), squared, length
        integer :: i

        scaled = x/maxval(abs(x))
        squared = dot_product(scaled, scaled)
        length = sqrt(real(squared, dp))
        do i = 1, 2
            length = (length + squared/length)/2
        end do
        unit = scaled/length
    end function unit_of

    !> Gaussian elimination with row exchange.
    function solution(matrix, right_hand_side) result(x)
        real(qp), intent(in) :: matrix(4, 4), right_hand_side(4)
        real(qp) :: x(4)

        real(qp) :: m(4, 5), row(5)
        integer :: i, j, pivot

        m(:, :4) = matrix
        m(:, 5) = right_hand_side
        do i = 1, 4
            pivot = i - 1 + maxloc(abs(m(i:, i)), 1)
            row = m(pivot, :)
            m(pivot, :) = m(i, :)
            m(i, :) = row/row(i)
            do j = 1, 4
                if (j /= i) m(j, :) = m(j, :) - m(j, i)*m(i, :)
            end do
        end do
        x = m(:, 5)
    end function solution

    !> Checks quest and q_method against the exact eigenvector for these stars. The sign of q is free
    !> where q(4) is near zero.
    subroutine compare(observed, reference, deviation, error)
        real(dp), intent(in) :: observed(:, :), reference(:, :), deviation(:)
        type(error_type), allocatable, intent(inout) :: error
        type(error_t), allocatable :: failure
        real(dp) :: q(4), q_reference(4), q_exact(4), covariance(3, 3), loss, loss_reference

        call q_method(observed, reference, deviation, q_reference, covariance, loss_reference, &
                      failure)
        if (failed(error, failure)) return
        call quest(observed, reference, deviation, q, covariance, loss, failure)
        if (failed(error, failure)) return
        q_exact = exact_attitude(observed, reference, deviation, q_reference)
        call check(error, distance(q, q_exact), 0.0_dp, thr=TOLERANCE, message='quest')
        call check(error, distance(q_reference, q_exact), 0.0_dp, thr=TOLERANCE, message='q_method')
        call check(error, q(4) >= 0 .and. q_reference(4) >= 0)
        call check(error, loss, loss_reference, thr=4e-15_dp, message='loss')
    end subroutine compare

    pure real(dp) function distance(p, q)
        real(dp), intent(in) :: p(4), q(4)

        distance = min(norm2(p - q), norm2(p + q))
    end function distance

    !> Directions without noise are met: (3-11).
    subroutine test_exact(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: observed(3, 20), reference(3, 20), deviation(20), q(4), q_found(4)
        real(dp) :: covariance(3, 3), loss
        integer :: i

        stream = new_stream(61, 0, 0, 0, 0)
        deviation = NOISE
        do i = 1, 200
            q = random_attitude(stream)
            call make_stars(stream, q, 12*DEGREE, 0.0_dp, observed, reference)
            call quest(observed, reference, deviation, q_found, covariance, loss, failure)
            call check(error, distance(q, q_found), 0.0_dp, thr=2e-14_dp)
            call check(error, loss, 0.0_dp, thr=4e-15_dp)
        end do
    end subroutine test_exact

    !> The eigenvector (3-14) of (3-15)-(3-18), against quadruple precision.
    !> Twenty stars within 4 deg: rounding of K weighs as the inverse square of their spread.
    subroutine test_random_attitudes(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: stream
        real(dp) :: observed(3, 20), reference(3, 20), deviation(20)
        integer :: i, j

        stream = new_stream(62, 0, 0, 0, 0)
        do i = 1, 500
            call make_stars(stream, random_attitude(stream), 12*DEGREE, NOISE, observed, reference)
            do j = 1, 20
                deviation(j) = NOISE*(1 + stream%uniform())
            end do
            call compare(observed, reference, deviation, error)
        end do
        stream = new_stream(65, 0, 0, 0, 0)
        deviation = NOISE
        do i = 1, 200
            call make_stars(stream, random_attitude(stream), 2*DEGREE, NOISE, observed, reference)
            call compare(observed, reference, deviation, error)
        end do
    end subroutine test_random_attitudes

    !> Turns by 180 deg less 0, 1e-9, 1e-6, 1e-3 rad about the axes and about random directions.
    subroutine test_half_turns(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: LESS(4) = [0.0_dp, 1e-9_dp, 1e-6_dp, 1e-3_dp]
        type(random_stream_t) :: stream
        real(dp) :: observed(3, 20), reference(3, 20), deviation(20), axis(3), q(4)
        integer :: i, j

        stream = new_stream(63, 0, 0, 0, 0)
        deviation = NOISE
        do i = 1, 40
            call stream%normals(axis)
            if (i <= 3) axis = 0
            if (i <= 3) axis(i) = 1
            do j = 1, size(LESS)
                q = quaternion_from_axis_angle(unit(axis), PI - LESS(j))
                call make_stars(stream, q, 12*DEGREE, 0.0_dp, observed, reference)
                call compare(observed, reference, deviation, error)
                call make_stars(stream, q, 12*DEGREE, NOISE, observed, reference)
                call compare(observed, reference, deviation, error)
            end do
        end do
    end subroutine test_half_turns

    !> Two stars 3 to 24 deg apart.
    subroutine test_two_stars(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: stream
        real(dp) :: observed(3, 2), reference(3, 2)
        integer :: i

        stream = new_stream(64, 0, 0, 0, 0)
        i = 0
        do while (i < 300)
            call make_stars(stream, random_attitude(stream), 12*DEGREE, NOISE, observed, reference)
            if (norm2(reference(:, 1) - reference(:, 2)) < 3*DEGREE) cycle
            i = i + 1
            call compare(observed, reference, [NOISE, 2*NOISE], error)
        end do
    end subroutine test_two_stars

    !> Directions over the whole sphere with errors of 30 deg: the loss is no longer small.
    subroutine test_gross_errors(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: stream
        real(dp) :: observed(3, 8), reference(3, 8), deviation(8)
        integer :: i

        stream = new_stream(66, 0, 0, 0, 0)
        deviation = 1
        do i = 1, 200
            call make_stars(stream, random_attitude(stream), PI, 0.5_dp, observed, reference)
            call compare(observed, reference, deviation, error)
        end do
    end subroutine test_gross_errors

    !> The loss is Wahba's (3-12) with weights of sum 1 (3-13), and every attitude nearby has a greater one.
    subroutine test_minimum(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: observed(3, 6), reference(3, 6), deviation(6), q(4), axis(3), turned(4)
        real(dp) :: covariance(3, 3), loss
        integer :: i

        stream = new_stream(67, 0, 0, 0, 0)
        deviation = [1.0_dp, 2.0_dp, 3.0_dp, 1.0_dp, 0.5_dp, 2.0_dp]
        call make_stars(stream, random_attitude(stream), 60*DEGREE, 0.1_dp, observed, reference)
        call quest(observed, reference, deviation, q, covariance, loss, failure)
        call check(error, loss, wahba_loss(q), thr=1e-15_dp)
        do i = 1, 100
            call stream%normals(axis)
            turned = quaternion_product(quaternion_from_axis_angle(unit(axis), 1e-4_dp), q)
            call check(error, wahba_loss(turned) > loss)
        end do

    contains

        real(dp) function wahba_loss(attitude) result(total)
            real(dp), intent(in) :: attitude(4)
            real(dp) :: difference(3, 6)

            difference = observed - matmul(rotation_matrix(attitude), reference)
            total = sum(sum(difference**2, 1)/deviation**2)/sum(1/deviation**2)/2
        end function wahba_loss
    end subroutine test_minimum

    !> e' P^-1 e of the errors e is chi-square of three degrees of freedom each, which they are only about
    !> 0 (3-19); every element of the sample covariance (3-20) is that of (3-21), (3-22).
    subroutine test_covariance(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 6, FRAMES = 4000
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: exact(3, N), observed(3, N), reference(3, N), deviation(N), x(3)
        real(dp) :: q(4), q_found(4), difference(4), p(3, 3), p_frame(3, 3), sample(3, 3)
        real(dp) :: loss, statistic, limits(2)
        integer :: i, j, k

        stream = new_stream(68, 0, 0, 0, 0)
        q = random_attitude(stream)
        deviation = NOISE*[1.0_dp, 2.0_dp, 0.5_dp, 1.5_dp, 1.0_dp, 3.0_dp]
        call make_stars(stream, q, 12*DEGREE, 0.0_dp, exact, reference)
        call quest(exact, reference, deviation, q_found, p, loss, failure)
        sample = 0
        statistic = 0
        do i = 1, FRAMES
            do j = 1, N
                call stream%normals(x)
                observed(:, j) = unit(exact(:, j) + deviation(j)*cross(exact(:, j), x))
            end do
            call quest(observed, reference, deviation, q_found, p_frame, loss, failure)
            difference = quaternion_product(q_found, conjugate_quaternion(q))
            x = difference(1:3)*sign(1.0_dp, difference(4))
            statistic = statistic + dot_product(x, matmul(inverse_3x3(p_frame), x))
            do k = 1, 3
                sample(:, k) = sample(:, k) + x*x(k)/FRAMES
            end do
        end do
        limits = chi_square_limits(3*FRAMES)
        call check(error, statistic > limits(1) .and. statistic < limits(2))
        do j = 1, 3
            do k = 1, j
                call check(error, sample(k, j), p(k, j), &
                           thr=Z_999*sqrt((p(j, j)*p(k, k) + p(k, j)**2)/FRAMES))
            end do
        end do
    end subroutine test_covariance

    !> 2 loss/s_tot^2 is chi-square of 2n - 3 degrees of freedom (M. D. Shuster's TASTE).
    subroutine test_loss(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 20, FRAMES = 1000
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: observed(3, N), reference(3, N), deviation(N), q(4), p(3, 3), loss
        real(dp) :: total, limits(2)
        integer :: i

        stream = new_stream(69, 0, 0, 0, 0)
        deviation = NOISE
        total = 0
        do i = 1, FRAMES
            call make_stars(stream, random_attitude(stream), 12*DEGREE, NOISE, observed, reference)
            call quest(observed, reference, deviation, q, p, loss, failure)
            total = total + 2*loss/(NOISE**2/N)
        end do
        limits = chi_square_limits((2*N - 3)*FRAMES)
        call check(error, total > limits(1) .and. total < limits(2))
    end subroutine test_loss

    subroutine test_failures(error)
        type(error_type), allocatable, intent(out) :: error
        type(random_stream_t) :: stream
        real(dp) :: w(3, 3), v(3, 3), deviation(3)

        stream = new_stream(70, 0, 0, 0, 0)
        call make_stars(stream, random_attitude(stream), 12*DEGREE, NOISE, w, v)
        deviation = NOISE
        call expect_failure(w(:, :1), v(:, :1), deviation(:1), 'at least two stars')
        call expect_failure(w(:, :0), v(:, :0), deviation(:0), 'at least two stars')
        call expect_failure(w, v(:, :2), deviation, 'equal in number')
        call expect_failure(w, v, deviation(:2), 'equal in number')
        call expect_failure(w, v, [NOISE, 0.0_dp, NOISE], 'must be positive')
        call expect_failure(w, v, [NOISE, NAN, NOISE], 'must be positive')
        call expect_failure(spread(w(:, 1), 2, 3), v, deviation, 'collinear')
        call expect_failure(w, spread(v(:, 1), 2, 3), deviation, 'collinear')
        call expect_failure(w(:, [1, 1]), reshape([v(:, 1), -v(:, 1)], [3, 2]), deviation(:2), &
                            'collinear')
        call expect_failure(identity(3), -identity(3), deviation, 'contradict')
        w(2, 2) = NAN
        call expect_failure(w, v, deviation, 'not finite')

    contains

        subroutine expect_failure(observed, reference, sigma, words)
            real(dp), intent(in) :: observed(:, :), reference(:, :), sigma(:)
            character(*), intent(in) :: words
            type(error_t), allocatable :: failure, failure_reference
            real(dp) :: q(4), p(3, 3), loss

            call quest(observed, reference, sigma, q, p, loss, failure)
            call q_method(observed, reference, sigma, q, p, loss, failure_reference)
            call check_fails(error, failure, words)
            call check(error, allocated(failure_reference), 'q_method accepted: '//words)
        end subroutine expect_failure
    end subroutine test_failures
end module test_quest
