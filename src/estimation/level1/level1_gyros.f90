!> The rotation of the satellite by its gyros, whose axes come from the star cameras.
module gracecg_estimation_level1_gyros
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_base_vectors, only: inverse_3x3, determinant_3x3
    use gracecg_estimation_level1_basis, only: orthonormalise, remove_space, polynomial_columns
    use gracecg_estimation_level1_calibration, only: level1_calibration_t, level1_span_t
    use gracecg_estimation_level1_series, only: interpolate
    implicit none
    private
    public :: gyro_axes_t, fit_gyro_axes, gyro_attitude

    type :: gyro_axes_t
        !! Directions of the gyros with their scales: angle = a . phi + bias
        logical :: known = .false.    !! They could be found
        integer, allocatable :: gyro(:)         !! Those that see something
        real(dp), allocatable :: axis(:, :)     !! a: (3, gyro)
    end type gyro_axes_t

contains

    !> The axes of the gyros, by regression of their angles on those of the star cameras over all spans.
    subroutine fit_gyro_axes(calibration, axes, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(gyro_axes_t), intent(out) :: axes
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: LEAST = 0.05_dp      ! Of a: a gyro that is off sees nothing
        real(dp) :: normal(3, 3), rhs(3), part(3, 3), part_rhs(3), x(3), covariance(3, 3), condition, angle(1)
        real(dp), allocatable :: rows(:, :), observed(:), basis(:, :)
        integer, allocatable :: wanted(:)
        integer :: gyro, i, k, n

        allocate (axes%gyro(0), axes%axis(3, 0))
        if (.not. calibration%has_gyros) return
        do gyro = 1, 4
            normal = 0
            rhs = 0
            do i = 1, size(calibration%spans)
                associate (span => calibration%spans(i))
                    if (.not. span%used .or. size(span%gyros(gyro)%time) < 10) cycle
                    wanted = pack([(k, k=1, size(span%attitude_time))], &
                                  span%attitude_time > span%gyros(gyro)%time(2) .and. &
                                  span%attitude_time < span%gyros(gyro)%time(size(span%gyros(gyro)%time) - 1))
                    n = size(wanted)
                    if (n < 20) cycle
                    rows = span%angle(:, wanted)
                    allocate (observed(n), basis(n, 2))
                    do k = 1, n
                        call interpolate(span%gyros(gyro)%time, reshape(span%gyros(gyro)%angle, &
                                         [1, size(span%gyros(gyro)%angle)]), span%attitude_time(wanted(k)), angle)
                        observed(k) = angle(1)
                    end do
                    call polynomial_columns(span%attitude_time(wanted), 1, basis)
                end associate
                ! Bias and drift of the gyro; the mean rate of the satellite goes with them but where spans differ, so
                ! that only the offset is taken away.
                basis = basis(:, :1)
                call orthonormalise(basis)
                call remove_space(basis, observed)
                do k = 1, 3
                    call remove_row(basis, rows, k)
                end do
                call normal_equations(rows, observed, part, part_rhs)
                normal = normal + part
                rhs = rhs + part_rhs
                deallocate (observed, basis)
            end do
            if (.not. any(normal > 0)) cycle
            call solve_normal_equations(normal, rhs, x, covariance, condition, error)
            if (allocated(error)) return
            if (norm2(x) < LEAST) cycle
            axes%gyro = [axes%gyro, gyro]
            axes%axis = reshape([axes%axis, x], [3, size(axes%gyro)])
        end do
        if (size(axes%gyro) < 3) return
        axes%known = abs(determinant_3x3(matmul(axes%axis, transpose(axes%axis)))) > LEAST**2
    end subroutine fit_gyro_axes

    subroutine remove_row(basis, rows, k)
        real(dp), intent(in) :: basis(:, :)
        real(dp), intent(inout) :: rows(:, :)
        integer, intent(in) :: k

        real(dp) :: row(size(rows, 2))

        row = rows(k, :)
        call remove_space(basis, row)
        rows(k, :) = row
    end subroutine remove_row

    !> The rotation of the satellite by the gyros in a span, least squares at the times of the first.
    subroutine gyro_attitude(span, axes, times, angles)
        type(level1_span_t), intent(in) :: span
        type(gyro_axes_t), intent(in) :: axes
        real(dp), allocatable, intent(out) :: times(:)    !! s
        real(dp), allocatable, intent(out) :: angles(:, :)      !! (3, n), rad

        real(dp) :: inverse(3, 3), seen(size(axes%gyro)), angle(1)
        integer :: i, k

        inverse = inverse_3x3(matmul(axes%axis, transpose(axes%axis)))
        times = span%gyros(axes%gyro(1))%time
        times = times(3:size(times) - 2)
        allocate (angles(3, size(times)))
        do i = 1, size(times)
            do k = 1, size(axes%gyro)
                associate (gyro => span%gyros(axes%gyro(k)))
                    call interpolate(gyro%time, reshape(gyro%angle, [1, size(gyro%angle)]), times(i), angle)
                    seen(k) = angle(1) - gyro%angle(1)
                end associate
            end do
            angles(:, i) = matmul(inverse, matmul(axes%axis, seen))
        end do
    end subroutine gyro_attitude
end module gracecg_estimation_level1_gyros
