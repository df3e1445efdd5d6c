!> The delay of the accelerometer by the firings of thrusters, which last 50 ms and lie anywhere between its samples:
!> held currents jump at few places between two samples, and tell less.
!>
!> A sample is the mean over its interval, so that a firing at tag T of length D is in the share of that interval which
!> [T + lag, T + lag + D] covers. The lag is that of the firing behind its tag, which the gyros see as a bend of their
!> angles, and that of the accelerometer.
module gracecg_level1_firings
    use gracecg_base_kinds, only: dp
    use gracecg_level1_basis, only: remove_space, polynomial_basis
    use gracecg_level1_calibration, only: level1_firing_t
    implicit none
    private
    public :: accelerometer_lag, gyro_lag, SAMPLE

    real(dp), parameter :: SAMPLE = 0.1_dp          !! Interval of ACC1A, s
    real(dp), parameter :: FARTHEST = 0.8_dp        !! Lag that is looked for, s
    real(dp), parameter :: FINE = 1e-3_dp           !! Step of the last search, s
    integer, parameter :: REACH = 60                !! Of it, steps
    integer, parameter :: FEWEST = 8                !! Firings

contains

    !> The lag of firings in the accelerometer behind their tags. A sigma of 0: they do not tell.
    subroutine accelerometer_lag(firings, lag, sigma)
        type(level1_firing_t), intent(in) :: firings(:)
        real(dp), intent(out) :: lag            !! s
        real(dp), intent(out) :: sigma          !! s

        real(dp), parameter :: COARSE = 0.025_dp, WIDE = 1.5_dp, NARROW = 0.35_dp
        real(dp) :: squares(-REACH:REACH), lowest, trial
        integer :: i
        logical :: seen

        sigma = 0
        lag = 0
        if (size(firings) < FEWEST) return
        lowest = huge(lowest)
        do i = -nint(FARTHEST/COARSE), nint(FARTHEST/COARSE)
            call squares_of_samples(firings, i*COARSE, 0.0_dp, WIDE, trial, seen)
            if (trial < lowest) lag = i*COARSE
            lowest = min(lowest, trial)
        end do
        call squares_of_samples(firings, lag, lag, NARROW, trial, seen)
        if (.not. seen) return
        do i = -REACH, REACH
            call squares_of_samples(firings, lag + i*FINE, lag, NARROW, squares(i), seen)
        end do
        call middle_by_likelihood(squares, FINE, lag, sigma)
    end subroutine accelerometer_lag

    !> Twice the logarithm of the likelihood of a lag, but for its sign and a constant: a line and an amplitude for each
    !> firing and axis, axes with the noise that is left.
    subroutine squares_of_samples(firings, lag, centre, half, squares, seen)
        type(level1_firing_t), intent(in) :: firings(:)
        real(dp), intent(in) :: lag             !! s
        real(dp), intent(in) :: centre, half    !! Of the samples that are used, s behind the tags
        real(dp), intent(out) :: squares
        logical, intent(out) :: seen            !! The firings are most of what there is, on some axis

        real(dp), parameter :: MOST = 0.5_dp
        real(dp), allocatable :: basis(:, :), column(:), values(:)
        integer, allocatable :: wanted(:)
        real(dp) :: left(3), total(3), start, free
        integer :: i, k, axis

        left = 0
        total = 0
        free = 0
        do i = 1, size(firings)
            associate (f => firings(i))
                wanted = pack([(k, k=1, size(f%sample_time))], abs(f%sample_time - f%time - centre) < half)
                if (size(wanted) < 5) cycle
                call polynomial_basis(f%sample_time(wanted), 1, basis)
                start = f%time + lag
                column = max(0.0_dp, min(f%sample_time(wanted) + SAMPLE/2, start + f%duration) - &
                             max(f%sample_time(wanted) - SAMPLE/2, start))
                call remove_space(basis, column)
                if (norm2(column) > 0) column = column/norm2(column)
                do axis = 1, 3
                    values = f%linear(axis, wanted)
                    call remove_space(basis, values)
                    total(axis) = total(axis) + sum(values**2)
                    left(axis) = left(axis) + sum(values**2) - dot_product(column, values)**2
                end do
                free = free + size(wanted) - 3
            end associate
        end do
        squares = free*sum(log(max(left, tiny(1.0_dp))))
        seen = any(left < (1 - MOST)*total)
    end subroutine squares_of_samples

    !> The lag of firings in the angles of gyros behind their tags. A sigma of 0: they do not tell.
    subroutine gyro_lag(firings, gyros, lag, sigma)
        type(level1_firing_t), intent(in) :: firings(:)
        integer, intent(in) :: gyros(:)         !! Those that see something
        real(dp), intent(out) :: lag            !! s
        real(dp), intent(out) :: sigma          !! s

        real(dp), parameter :: COARSE = 0.05_dp
        real(dp) :: squares(-REACH:REACH), lowest, trial
        integer :: i

        sigma = 0
        lag = 0
        if (size(firings) < FEWEST) return
        lowest = huge(lowest)
        do i = -nint(FARTHEST/COARSE), nint(FARTHEST/COARSE)
            call squares_of_gyros(firings, gyros, i*COARSE, trial)
            if (trial < lowest) lag = i*COARSE
            lowest = min(lowest, trial)
        end do
        if (.not. lowest < huge(lowest)) return
        do i = -REACH, REACH
            call squares_of_gyros(firings, gyros, lag + i*FINE, squares(i))
        end do
        call middle_by_likelihood(squares, FINE, lag, sigma)
    end subroutine gyro_lag

    !> The same as for the samples: a cubic and a bend for each firing and gyro.
    subroutine squares_of_gyros(firings, gyros, lag, squares)
        type(level1_firing_t), intent(in) :: firings(:)
        integer, intent(in) :: gyros(:)
        real(dp), intent(in) :: lag             !! s
        real(dp), intent(out) :: squares        !! huge(1.0) without angles

        integer, parameter :: DEGREE = 3
        real(dp), allocatable :: basis(:, :), column(:), values(:)
        real(dp) :: left, free
        integer :: i, k

        squares = huge(squares)
        left = 0
        free = 0
        do i = 1, size(firings)
            do k = 1, size(gyros)
                associate (time => firings(i)%gyros(gyros(k))%time, f => firings(i))
                    if (size(time) < 5*DEGREE) cycle
                    call polynomial_basis(time, DEGREE, basis)
                    column = max(0.0_dp, time - f%time - lag - f%duration/2)
                    call remove_space(basis, column)
                    if (norm2(column) > 0) column = column/norm2(column)
                    values = f%gyros(gyros(k))%angle
                    call remove_space(basis, values)
                    left = left + sum(values**2) - dot_product(column, values)**2
                    free = free + size(time) - DEGREE - 2
                end associate
            end do
        end do
        if (free > 0) squares = free*log(max(left, tiny(1.0_dp)))
    end subroutine squares_of_gyros

    !> Mean and standard deviation of a time by the likelihoods at equal steps about it.
    pure subroutine middle_by_likelihood(squares, step, time, sigma)
        real(dp), intent(in) :: squares(:)      !! -2 log likelihood; the middle one is at `time`
        real(dp), intent(in) :: step            !! s
        real(dp), intent(inout) :: time         !! s
        real(dp), intent(out) :: sigma          !! s; with that of the steps

        real(dp) :: weight(size(squares)), place(size(squares))
        integer :: i

        weight = exp(-(squares - minval(squares))/2)
        weight = weight/sum(weight)
        place = [((i - (size(squares) + 1)/2)*step, i=1, size(squares))]
        time = time + sum(weight*place)
        sigma = sqrt(sum(weight*(place - sum(weight*place))**2) + step**2/12)
    end subroutine middle_by_likelihood
end module gracecg_level1_firings
