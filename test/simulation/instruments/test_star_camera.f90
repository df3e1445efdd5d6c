!> The star camera: mounting, field of view, noise of the attitudes.
module test_star_camera
    use vocabulary
    use test_quest, only: random_attitude
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_product, conjugate_quaternion, normalised
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_simulation_star_catalogue, only: star_catalogue_t, builtin_star_catalogue
    use gracecg_simulation_star_camera, only: star_camera_t, star_frame_t
    use statistics, only: chi_square_limits
    implicit none
    private
    public :: collect_star_camera

    real(dp), parameter :: ATTITUDE(4) = [-0.7008547308853075_dp, -3.115068773005844e-6_dp, &
                                          0.7133040348803767_dp, 3.059634305881649e-6_dp]
    !! Front satellite, case 1: CSR-TM-00-01 section 5.2 (not quite a unit quaternion)

contains

    subroutine collect_star_camera(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('mounting', test_mounting), &
                    new_unittest('stars-inside-the-field', test_field), &
                    new_unittest('errors-match-their-covariance', test_covariance), &
                    new_unittest('rejects-bad-settings', test_settings), &
                    new_unittest('best-stars', test_best)]
    end subroutine collect_star_camera

    !> The best stars are as many, of the same field, and the trace of their covariance is at most that of the
    !> first ones; in 200 attitudes it is mostly far below. Where the field has no more than are used, both are
    !> the same.
    subroutine test_best(error)
        type(error_type), allocatable, intent(out) :: error
        type(star_camera_t) :: camera, best_camera
        type(star_catalogue_t) :: catalogue
        type(star_frame_t) :: first, best
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: q(4), trace(2), gain
        integer :: i, tried

        catalogue = builtin_star_catalogue()
        best_camera%selection = 'best'
        stream = new_stream(12, 0, 0, 0, 0)
        gain = 0
        tried = 0
        do i = 1, 200
            q = random_attitude(stream)
            if (camera%stars_in_field(catalogue, q, 1) < 2) cycle
            call camera%see(catalogue, q, 1, first, failure)
            if (.not. allocated(failure)) call best_camera%see(catalogue, q, 1, best, failure)
            if (failed(error, failure)) return
            trace = [trace_of(first), trace_of(best)]
            if (unmet(error, size(best%reference, 2) == size(first%reference, 2) .and. trace(2) <= trace(1)*(1 + 1e-12_dp))) return
            if (camera%stars_in_field(catalogue, q, 1) <= camera%star_count) then
                call check(error, all(abs(best%reference - first%reference) <= 0), 'no choice')
                cycle
            end if
            tried = tried + 1
            gain = gain + sqrt(trace(2)/trace(1))
        end do
        call check(error, tried > 100 .and. gain/tried < 0.9_dp)

    contains

        real(dp) function trace_of(frame) result(trace)
            type(star_frame_t), intent(in) :: frame
            real(dp) :: information(3, 3), inverse(3, 3)
            integer :: k, j

            information = 0
            do k = 1, size(frame%line_of_sight, 2)
                associate (w => frame%line_of_sight(:, k))
                    do j = 1, 3
                        information(j, j) = information(j, j) + 1
                        information(:, j) = information(:, j) - w*w(j)
                    end do
                end associate
            end do
            inverse = inverse_3x3(information)
            trace = inverse(1, 1) + inverse(2, 2) + inverse(3, 3)
        end function trace_of
    end subroutine test_best

    !> Boresights at +-45 deg from -z in the y-z plane, camera x along body x.
    subroutine test_mounting(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: H = sqrt(0.5_dp)
        type(star_camera_t) :: camera
        real(dp) :: m(3, 3)

        m = transpose(rotation_matrix(camera%mounting(1)))      ! camera axes in columns
        call check(error, maxval(abs(m(:, 3) - [0.0_dp, H, -H])) < 1e-15_dp)
        call check(error, maxval(abs(m(:, 1) - [1.0_dp, 0.0_dp, 0.0_dp])) < 1e-15_dp)
        call check(error, maxval(abs(m(:, 2) - cross(m(:, 3), m(:, 1)))) < 1e-15_dp)
        m = transpose(rotation_matrix(camera%mounting(2)))
        call check(error, maxval(abs(m(:, 3) - [0.0_dp, -H, -H])) < 1e-15_dp)
        call check(error, maxval(abs(m(:, 1) - [1.0_dp, 0.0_dp, 0.0_dp])) < 1e-15_dp)
    end subroutine test_mounting

    !> Lines of sight lie in the field; they are the catalogue's directions through the mounting.
    subroutine test_field(error)
        type(error_type), allocatable, intent(out) :: error
        type(star_camera_t) :: camera
        type(star_frame_t) :: frame
        type(star_catalogue_t) :: catalogue
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: q(4), m(3, 3)
        integer :: i, head

        catalogue = builtin_star_catalogue()
        stream = new_stream(71, 0, 0, 0, 0)
        do i = 1, 100
            q = random_attitude(stream)
            head = 1 + mod(i, HEADS)
            call camera%see(catalogue, q, head, frame, failure)
            if (failed(error, failure)) return
            associate (v => frame%line_of_sight)
                if (unmet(error, size(v, 2) <= 20 .and. all(v(3, :) > 0) .and. &
                          all(abs(v(1, :)) <= v(3, :)*tan(11*DEGREE)) .and. &
                          all(abs(v(2, :)) <= v(3, :)*tan(8*DEGREE)))) return
                m = matmul(rotation_matrix(camera%mounting(head)), rotation_matrix(q))
                call check(error, maxval(abs(matmul(m, frame%reference) - v)) < 1e-15_dp)
            end associate
        end do
    end subroutine test_field

    !> Chi-square of the errors of many attitudes: the noise is 1" and 3" in quadrature.
    subroutine test_covariance(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ATTITUDES = 50, FRAMES = 40
        type(star_camera_t) :: camera
        type(star_frame_t) :: frame
        type(star_catalogue_t) :: catalogue
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: q(4), q_observed(4), covariance(3, 3), e(3), statistic, limits(2)
        integer :: i, k

        call check(error, camera%noise(), sqrt(10.0_dp)*ARCSECOND, thr=1e-20_dp)
        catalogue = builtin_star_catalogue()
        stream = new_stream(73, 0, 0, 0, 0)
        statistic = 0
        do i = 1, ATTITUDES
            q = random_attitude(stream)
            call camera%see(catalogue, q, 1, frame, failure)
            do k = 1, FRAMES
                call frame%draw(stream, q_observed, covariance, failure)
                e = error_vector(q_observed, quaternion_product(camera%mounting(1), q))
                statistic = statistic + dot_product(e, matmul(inverse_3x3(covariance), e))
            end do
        end do
        limits = chi_square_limits(3*ATTITUDES*FRAMES)
        call check(error, statistic > limits(1) .and. statistic < limits(2))
    end subroutine test_covariance

    !> Vector part of the small rotation from the true to the observed attitude.
    pure function error_vector(q_observed, q_true) result(e)
        real(dp), intent(in) :: q_observed(4), q_true(4)
        real(dp) :: e(3)

        real(dp) :: difference(4)

        difference = quaternion_product(q_observed, conjugate_quaternion(q_true))
        e = difference(1:3)*sign(1.0_dp, difference(4))
    end function error_vector

    subroutine test_settings(error)
        type(error_type), allocatable, intent(out) :: error
        type(star_camera_t) :: camera

        call expect_failure('head', normalised(ATTITUDE), 3)
        call expect_failure('quaternion', 2*ATTITUDE, 1)
        call expect_failure('quaternion', [nan, 0.0_dp, 0.0_dp, 1.0_dp], 1)
        camera = star_camera_t(field_of_view=[PI, 0.1_dp])
        call expect_failure('field of view', normalised(ATTITUDE), 1)
        camera = star_camera_t(field_of_view=[0.1_dp*DEGREE, 0.1_dp*DEGREE])
        call expect_failure('sees', normalised(ATTITUDE), 1)
        camera = star_camera_t(minimum_stars=1)
        call expect_failure('number of stars', normalised(ATTITUDE), 1)
        camera = star_camera_t(star_count=3, minimum_stars=4)
        call expect_failure('number of stars', normalised(ATTITUDE), 1)
        camera = star_camera_t(measurement_noise=-1.0_dp)
        call expect_failure('noise', normalised(ATTITUDE), 1)
        camera = star_camera_t(catalogue_noise=NAN)
        call expect_failure('noise', normalised(ATTITUDE), 1)
        camera = star_camera_t(elevation=[NAN, 0.0_dp])
        call expect_failure('elevation', normalised(ATTITUDE), 2)

    contains

        subroutine expect_failure(words, q, head)
            character(*), intent(in) :: words
            real(dp), intent(in) :: q(4)
            integer, intent(in) :: head
            type(star_frame_t) :: frame
            type(error_t), allocatable :: failure

            call camera%see(builtin_star_catalogue(), q, head, frame, failure)
            call check_fails(error, failure, words)
        end subroutine expect_failure
    end subroutine test_settings
end module test_star_camera
