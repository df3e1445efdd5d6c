!> The rotation of the satellite by its gyros, whose axes come from the star cameras.
module gracecg_level1_gyros
    use gracecg_level1_basics
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_base_vectors, only: determinant_3x3
    use gracecg_estimation_outlier_editing, only: leave_out_worst
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t, level1_gyro_t
    use gracecg_level1_series, only: interpolate
    implicit none
    private
    public :: gyro_axes_t, fit_gyro_axes, gyro_attitude

    type :: gyro_axes_t
        !! Directions of the gyros with their scales: angle = a . phi + bias
        logical :: known = .false.    !! They could be found, well enough to be of use
        integer, allocatable :: gyro(:)         !! Those that see something
        real(dp), allocatable :: axis(:, :)     !! a: (3, gyro)
    end type gyro_axes_t

contains

    !> The axes of the gyros, by regression over all spans. Angles of star cameras have more noise than those of gyros: they
    !> are what is observed, phi = B s, of the three directions s = U^T g in which the gyros move most, so that a = (U B^-1)^T
    !> is not too small. Angles far off what the gyros say, as of some bad attitudes in a row, are left out.
    subroutine fit_gyro_axes(calibration, axes, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(gyro_axes_t), intent(out) :: axes
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: LEAST = 0.05_dp      ! Of a: a gyro that is off sees nothing
        real(dp), parameter :: TO_SIGMA = 1.4826_dp     ! Of the median of normal magnitudes
        real(dp), parameter :: FAR_OFF = 20         ! Times the median, to which drifts of the gyros belong; chosen
        real(dp), parameter :: LEAST_ANGLE = 1e-9_dp    ! rad: files without noise
        real(dp), parameter :: QUIET = 1e-6_dp
        ! Noise of cameras that tell the axes, rad, chosen: with 6e-6 (heads alone) d was 18 um off, 8 sigma, in one of four days of
        ! four minutes, with 2e-7 (SCA1B) it is not. Rods turn the satellite by some 5e-6 about y (30 A m^2, 3e-5 T, 500 kg m^2,
        ! 0.1 Hz)
        real(dp), allocatable :: rows(:, :), gyros(:, :), squares(:, :), values(:), vectors(:, :), moved(:, :), left(:, :), off(:)
        logical, allocatable :: kept(:)
        real(dp) :: normal(3, 3), rhs(3), x(3), inverse(3, 3), condition, map(3, 3), noise(3)
        integer, allocatable :: list(:)
        integer :: gyro, axis
        logical :: again

        allocate (axes%gyro(0), axes%axis(3, 0))
        if (.not. calibration%has_gyros) return
        do gyro = 1, 4      ! which see something
            call common_angles(calibration, [gyro], rows, gyros)
            if (size(rows, 2) == 0) cycle
            call normal_equations(rows, gyros(1, :), normal, rhs)
            call solve_normal_equations(normal, rhs, x, inverse, condition, error)
            if (allocated(error)) return
            if (norm2(x) > LEAST) axes%gyro = [axes%gyro, gyro]
        end do
        list = axes%gyro
        if (size(list) < 3) return
        call common_angles(calibration, list, rows, gyros)
        if (size(rows, 2) == 0) return
        squares = matmul(gyros, transpose(gyros))
        allocate (values(size(list)), vectors(size(list), size(list)))
        call symmetric_eigen(squares, values, vectors, error)
        if (allocated(error)) return
        associate (turned => vectors(:, size(list) - 2:))
            moved = matmul(transpose(turned), gyros)
            kept = spread(.true., 1, size(moved, 2))
            again = .true.
            do while (again)
                do axis = 1, 3
                    call normal_equations(moved, rows(axis, :), normal, rhs, merge(1.0_dp, 0.0_dp, kept))
                    call solve_normal_equations(normal, rhs, x, inverse, condition, error)
                    if (allocated(error)) return
                    map(axis, :) = x
                end do
                left = rows - matmul(map, moved)
                off = spread(0.0_dp, 1, size(kept))
                do axis = 1, 3
                    off = max(off, abs(left(axis, :))/max(LEAST_ANGLE, median_of(abs(left(axis, :)))))
                end do
                again = .false.
                call leave_out_worst(off, FAR_OFF, 1.0_dp, kept, again)
            end do
            ! with the gyros' drifts: by differences
            noise = [(TO_SIGMA*median_of(abs(left(axis, 2:) - left(axis, :size(kept) - 1)))/sqrt(2.0_dp), axis=1, 3)]
            if (.not. abs(determinant_3x3(map)) > 0) return
            axes%axis = transpose(matmul(turned, inverse_3x3(map)))
        end associate
        axes%known = abs(determinant_3x3(matmul(axes%axis, transpose(axes%axis)))) > LEAST**2 .and. maxval(noise) < QUIET
    end subroutine fit_gyro_axes

    !> Angles of the star cameras and of some gyros at the same times, without their means by span; none where some gyro has
    !> too few.
    subroutine common_angles(calibration, list, rows, gyros)
        type(level1_calibration_t), intent(in) :: calibration
        integer, intent(in) :: list(:)              !! Numbers of gyros
        real(dp), allocatable, intent(out) :: rows(:, :)    !! (3, n), rad
        real(dp), allocatable, intent(out) :: gyros(:, :)   !! (gyros, n), rad

        integer, parameter :: FEWEST = 20
        integer, allocatable :: wanted(:)
        real(dp), allocatable :: angles(:, :)
        real(dp) :: first, last
        integer :: i, j, k

        allocate (rows(3, 0), gyros(size(list), 0))
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (.not. span%used .or. any([(size(span%gyros(list(j))%time) < 10, j=1, size(list))])) cycle
                first = maxval([(span%gyros(list(j))%time(2), j=1, size(list))])
                last = minval([(span%gyros(list(j))%time(size(span%gyros(list(j))%time) - 1), j=1, size(list))])
                wanted = pack([(k, k=1, size(span%attitude_time))], span%attitude_time > first .and. span%attitude_time < last)
                if (size(wanted) < FEWEST) cycle
                allocate (angles(3 + size(list), size(wanted)))
                angles(:3, :) = span%angle(:, wanted)
                do j = 1, size(list)
                    angles(3 + j, :) = angles_at(span%gyros(list(j)), span%attitude_time(wanted))
                end do
                ! Bias and drift of the gyros; the mean rate of the satellite goes with them but where spans differ, so that
                ! only the offset is taken away.
            end associate
            do j = 1, size(angles, 1)
                angles(j, :) = angles(j, :) - sum(angles(j, :))/size(angles, 2)
            end do
            rows = reshape([rows, angles(:3, :)], [3, size(rows, 2) + size(angles, 2)])
            gyros = reshape([gyros, angles(4:, :)], [size(list), size(gyros, 2) + size(angles, 2)])
            deallocate (angles)
        end do
    end subroutine common_angles

    !> The rotation of the satellite by the gyros in a part of a span, least squares at the times of the first.
    subroutine gyro_attitude(span, axes, from, to, times, angles)
        type(level1_span_t), intent(in) :: span
        type(gyro_axes_t), intent(in) :: axes
        real(dp), intent(in) :: from, to                !! The part, s
        real(dp), allocatable, intent(out) :: times(:)    !! s
        real(dp), allocatable, intent(out) :: angles(:, :)      !! (3, n), rad

        real(dp), allocatable :: seen(:, :)
        integer :: k, first, last

        associate (all => span%gyros(axes%gyro(1))%time)
            first = max(3, last_not_after(all, from))
            if (all(first) < from) first = first + 1
            last = min(size(all) - 2, last_not_after(all, to))
            times = all(first:last)
        end associate
        allocate (seen(size(axes%gyro), size(times)))
        do k = 1, size(axes%gyro)
            seen(k, :) = angles_at(span%gyros(axes%gyro(k)), times) - span%gyros(axes%gyro(k))%angle(1)
        end do
        angles = matmul(inverse_3x3(matmul(axes%axis, transpose(axes%axis))), matmul(axes%axis, seen))
    end subroutine gyro_attitude

    !> The angles of a gyro between its samples.
    pure function angles_at(gyro, times) result(angles)
        type(level1_gyro_t), intent(in) :: gyro
        real(dp), intent(in) :: times(:)        !! s
        real(dp) :: angles(size(times))         !! rad

        integer :: i

        do i = 1, size(times)
            call interpolate(gyro%time, reshape(gyro%angle, [1, size(gyro%angle)]), times(i), angles(i:i))
        end do
    end function angles_at
end module gracecg_level1_gyros
