!> Whitening against Cholesky's factor of the covariance matrix, and the information of the offset
!> against plain least squares and published sigmas.
module test_noise_whitening
    use vocabulary
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, noise_spectrum_t, TWO_SIDED
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_offset_model, only: offset_matrix
    use gracecg_estimation_noise_whitening, only: whitener_t, new_whitener, accelerometer_whiteners
    use gracecg_estimation_offset_information, only: gather_information, gravity_gradient_matrix
    implicit none
    private
    public :: collect_noise_whitening

    real(dp), parameter :: INTERVAL = 0.1_dp    ! s
    real(dp), parameter :: LEVEL = 1e-18_dp, CORNER = 0.1_dp

contains

    subroutine collect_noise_whitening(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('whitened-covariance-is-identity', test_identity), &
                    new_unittest('whitening-is-the-inverse-of-choleskys-factor', test_cholesky), &
                    new_unittest('offset-information-against-normal-matrix', test_information), &
                    new_unittest('gravity-gradient-is-traceless', test_gradient), &
                    new_unittest('refuses-what-cannot-be-whitened', test_refused)]
    end subroutine collect_noise_whitening

    function noise_of(level, corner) result(noise)
        real(dp), intent(in) :: level, corner
        type(coloured_noise_t) :: noise

        type(error_t), allocatable :: failure

        noise = coloured_noise(noise_spectrum_t(level, corner, TWO_SIDED), INTERVAL, failure)
    end function noise_of

    !> Epochs with gaps, and samples left out.
    subroutine gappy(epoch, kept)
        integer, allocatable, intent(out) :: epoch(:)
        logical, allocatable, intent(out) :: kept(:)
        integer :: k

        epoch = [[(k, k=1, 40)], 43, 44, 50, [(k, k=120, 170)]]
        allocate (kept(size(epoch)), source=.true.)
        kept([1, 7, 8, 42, size(epoch)]) = .false.
    end subroutine gappy

    !> The covariance matrix of the noise by its autocovariance, which another test compares with
    !> samples and spectrum.
    function covariance_matrix(noise, epoch) result(r)
        type(coloured_noise_t), intent(in) :: noise
        integer, intent(in) :: epoch(:)
        real(dp) :: r(size(epoch), size(epoch))

        integer :: i

        do i = 1, size(epoch)
            r(:, i) = noise%autocovariance(epoch - epoch(i))
        end do
    end function covariance_matrix

    !> L^-1 R L^-T = I on the samples kept, 0 elsewhere.
    subroutine test_identity(error)
        type(error_type), allocatable, intent(out) :: error
        type(whitener_t) :: whitener
        type(coloured_noise_t) :: noise
        type(error_t), allocatable :: failure
        integer, allocatable :: epoch(:)
        logical, allocatable :: kept(:)
        real(dp), allocatable :: r(:, :)
        integer :: i, j

        call gappy(epoch, kept)
        noise = noise_of(LEVEL, CORNER)
        call compare(1e-11_dp)
        ! a table of noise that rises with frequency, with variances of either sign
        noise = coloured_noise(noise_spectrum_t(LEVEL, frequency=[1e-4_dp, 0.1_dp, 5.0_dp], shape=[1.0_dp, 1.0_dp, 1e4_dp]), &
                               INTERVAL, failure)
        call check_passes(error, failure)
        call compare(1e-6_dp)

    contains

        subroutine compare(tolerance)
            real(dp), intent(in) :: tolerance

            call new_whitener(noise, epoch, whitener, failure, kept)
            if (failed(error, failure)) return
            r = covariance_matrix(noise, epoch)
            call whitener%whiten(r)
            r = transpose(r)
            call whitener%whiten(r)
            do j = 1, size(epoch)
                do i = 1, size(epoch)
                    call check(error, r(i, j), merge(1.0_dp, 0.0_dp, i == j .and. kept(i)), thr=tolerance)
                end do
            end do
        end subroutine compare
    end subroutine test_identity

    !> Forward substitution with Cholesky's factor, written out, on the samples kept.
    subroutine test_cholesky(error)
        type(error_type), allocatable, intent(out) :: error
        type(whitener_t) :: whitener
        type(coloured_noise_t) :: noise
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        integer, allocatable :: epoch(:), used(:)
        logical, allocatable :: kept(:)
        real(dp), allocatable :: l(:, :), values(:), expected(:), found(:)
        integer :: i, j, n

        call gappy(epoch, kept)
        noise = noise_of(LEVEL, CORNER)
        used = pack([(i, i=1, size(epoch))], kept)
        l = covariance_matrix(noise, epoch(used))
        n = size(used)
        do j = 1, n
            l(j, j) = sqrt(l(j, j) - sum(l(j, :j - 1)**2))
            do i = j + 1, n
                l(i, j) = (l(i, j) - dot_product(l(i, :j - 1), l(j, :j - 1)))/l(j, j)
            end do
        end do
        stream = new_stream(1, 1, 1, 1, 1)
        allocate (values(size(epoch)), expected(n))
        call stream%normals(values)
        values = 1e-9_dp*values
        do i = 1, n
            expected(i) = (values(used(i)) - dot_product(l(i, :i - 1), expected(:i - 1)))/l(i, i)
        end do
        call new_whitener(noise, epoch, whitener, failure, kept)
        found = values
        call whitener%whiten_series(found)
        call check(error, maxval(abs(found(used) - expected)) < 1e-11_dp*maxval(abs(expected)), 'L^-1 v')
        call check(error, maxval(abs(pack(found,.not. kept))), 0.0_dp)
        call check(error, whitener%log_determinant, 2*sum(log([(l(i, i), i=1, n)])), 'determinant', &
                   thr=1e-9_dp)
        call check(error, whitener%kept, n)
    end subroutine test_cholesky

    !> The information is the inverse of the offset's block of the inverse normal matrix of all nine
    !> parameters.
    subroutine test_information(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 600
        type(operator_knowledge_t) :: knowledge
        type(whitener_t) :: whiteners(3)
        type(error_t), allocatable :: failure
        real(dp) :: omega(3, N), omega_dot(3, N), gradient(3, 3, N), rows(9, 3*N), observed(3*N), a(3, 3)
        real(dp) :: normal(9, 9), rhs(9), solution(9), covariance(9, 9), condition, found(3, 3), t
        integer :: k, axis, side

        knowledge%accelerometer_noise%level = [1e-20_dp, 1e-18_dp, 1e-20_dp]
        knowledge%accelerometer_noise%corner = [0.005_dp, 0.1_dp, 0.005_dp]
        call accelerometer_whiteners(knowledge%accelerometer_noise, knowledge%accelerometer_interval, &
                                     [(k, k=1, N)], whiteners, failure)
        if (failed(error, failure)) return
        do k = 1, N
            t = k*INTERVAL
            omega(:, k) = [1e-5_dp*cos(t), 1.1e-3_dp, 2e-5_dp*sin(t/2)]
            omega_dot(:, k) = [2e-5_dp*sin(0.6_dp*t), 3e-6_dp*cos(0.7_dp*t), 3e-6_dp*sin(0.8_dp*t)]
            gradient(:, :, k) = gravity_gradient_matrix(1.2e-6_dp, unit([0.01_dp*t/60, 0.02_dp, -1.0_dp]))
        end do
        do side = 1, 2          ! without and with the gradient
            rows = 0
            do k = 1, N
                a = offset_matrix(omega(:, k), omega_dot(:, k))
                if (side == 2) a = a + gradient(:, :, k)
                rows(1:3, 3*k - 2:3*k) = transpose(a)
                do axis = 1, 3
                    rows(3 + axis, 3*k - 3 + axis) = k*INTERVAL
                    rows(6 + axis, 3*k - 3 + axis) = 1
                end do
            end do
            do axis = 1, 3
                call whiteners(axis)%whiten(rows(:, axis::3))
            end do
            observed = 0
            call normal_equations(rows, observed, normal, rhs)
            call solve_normal_equations(normal, rhs, solution, covariance, condition, failure)
            if (failed(error, failure)) return
            if (side == 1) then
                call gather_information(omega, omega_dot, whiteners, found)
            else
                call gather_information(omega, omega_dot, whiteners, found, gradient)
            end if
            call check(error, maxval(abs(matmul(found, covariance(:3, :3)) - &
                                         reshape([1, 0, 0, 0, 1, 0, 0, 0, 1], [3, 3]))) < 1e-7_dp)
        end do
    end subroutine test_information

    !> Laplace's equation: no trace; upwards the tension is twice the pressure across.
    subroutine test_gradient(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp) :: g(3, 3), c(3)

        c = unit([0.3_dp, -0.4_dp, 0.8_dp])
        g = gravity_gradient_matrix(2.0_dp, c)
        call check(error, g(1, 1) + g(2, 2) + g(3, 3), 0.0_dp, thr=1e-15_dp)
        call check(error, maxval(abs(matmul(g, c) + 4*c)) < 1e-15_dp)
    end subroutine test_gradient

    subroutine test_refused(error)
        type(error_type), allocatable, intent(out) :: error
        type(operator_knowledge_t) :: knowledge
        type(whitener_t) :: whitener, whiteners(3)
        type(error_t), allocatable :: failure

        call new_whitener(noise_of(0.0_dp, 0.0_dp), [1, 2, 3, 4], whitener, failure)
        call check_fails(error, failure, 'level is 0')
        call new_whitener(noise_of(LEVEL, CORNER), [1, 3, 3, 4], whitener, failure)
        call check_fails(error, failure, 'increase')
        call new_whitener(noise_of(LEVEL, CORNER), [1, 2, 3, 4], whitener, failure, &
                          [.true., .false., .true., .false.])
        call check_fails(error, failure, '2 samples')
        knowledge%accelerometer_noise%level = [1e-20_dp, -1e-18_dp, 1e-20_dp]
        call accelerometer_whiteners(knowledge%accelerometer_noise, knowledge%accelerometer_interval, &
                                     [1, 2, 3, 4], whiteners, failure)
        call check_fails(error, failure, 'axis y ... noise_level ... positive')
        knowledge%accelerometer_noise%level = 1e-20_dp
        knowledge%accelerometer_noise%corner = [0.1_dp, 0.1_dp, -0.1_dp]
        call accelerometer_whiteners(knowledge%accelerometer_noise, knowledge%accelerometer_interval, &
                                     [1, 2, 3, 4], whiteners, failure)
        call check_fails(error, failure, 'axis z ... corner')
    end subroutine test_refused
end module test_noise_whitening
