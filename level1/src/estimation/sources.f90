!> The sources of angular acceleration, the offset by each, and the samples that contradict it.
module gracecg_level1_sources
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_base_statistics, only: median_of
    use gracecg_level1_setup, only: level1_setup_t, leakage_sigmas
    use gracecg_level1_angular, only: calibrate_angular_channels, channels_at, differentiate_attitude
    use gracecg_level1_attitude, only: relative
    use gracecg_level1_basis, only: orthonormalise, remove_space, polynomial_columns
    use gracecg_level1_calibration, only: level1_calibration_t, field_sigma, keep_samples
    use gracecg_level1_drive, only: level1_drive_t
    use gracecg_level1_firings, only: SAMPLE
    use gracecg_level1_gyros, only: gyro_attitude
    use gracecg_level1_optimal_source, only: solve_optimal
    use gracecg_level1_offset, only: solve_offset, modelled_acceleration
    use gracecg_level1_offset_solution, only: level1_solution_t, source_series_t, consider_t
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_series, only: hold
    implicit none
    private
    public :: LEVEL1_SOURCES, solve_by_source, drop_outliers

    !> The sources; the first is the recommended one
    character(10), parameter :: LEVEL1_SOURCES(7) = [character(10) :: 'torque+cal', 'torque', 'acc-cal', 'acc-raw', 'sca', &
                                                     'imu', 'optimal']

contains

    !> The offset by one source.
    subroutine solve_by_source(calibration, setup, estimate, source, leakage, solution, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(inout) :: estimate
        character(*), intent(in) :: source          !! Of LEVEL1_SOURCES
        character(*), intent(in) :: leakage         !! estimate, prior or none
        type(level1_solution_t), intent(out) :: solution
        type(error_t), allocatable, intent(out) :: error

        type(source_series_t), allocatable :: series(:)
        type(consider_t), allocatable :: considered(:)
        real(dp), allocatable :: times(:), angles(:, :)
        integer :: i, k, n
        logical :: needs_angular

        solution%source = source
        n = size(calibration%spans)
        allocate (series(n), considered(0))
        needs_angular = source == 'acc-cal' .or. source == 'acc-raw'
        if (needs_angular .and. .not. calibration%has_angular) then
            call fail(error, 'the accelerometer has no angular channels')
            return
        end if
        if (source == 'imu' .and. .not. estimate%gyros%known) then
            if (.not. calibration%has_gyros) then
                call fail(error, 'no IMU1A or IMU1B whose gyros show angles in all spans')
            else
                call fail(error, 'there are no three gyros with known axes')
            end if
            return
        end if
        if (source == 'acc-cal') then
            call calibrate_angular_channels(calibration, estimate%motion, estimate%rods%driven, estimate%angular, error)
            if (allocated(error)) return
        end if
        do i = 1, n
            associate (span => calibration%spans(i), motion => estimate%motion(i))
                if (.not. span%used) cycle
                select case (source)
                case ('torque+cal', 'optimal')
                    series(i)%acceleration = motion%torque
                case ('torque')
                    series(i)%acceleration = motion%torque
                    do k = 1, 3
                        series(i)%acceleration = series(i)%acceleration + motion%by_rod(:, k, :)* &
                            (1/estimate%rods%gain(k) - 1)
                    end do
                case ('acc-cal')
                    call channels_at(span, motion, estimate%angular, series(i)%acceleration, error)
                case ('acc-raw')
                    series(i)%acceleration = span%angular
                    do k = 1, 3
                        series(i)%acceleration(k, :) = span%angular(k, :) - sum(span%angular(k, :))/size(span%time)
                    end do
                case ('sca')
                    call differentiate_attitude(span, span%attitude_time, span%angle, span%time - estimate%accelerometer_delay, &
                                                series(i)%acceleration, series(i)%patterns, series(i)%noise)
                case ('imu')
                    call gyro_attitude(span, estimate%gyros, times, angles)
                    call differentiate_attitude(span, times, angles, span%time - estimate%accelerometer_delay, &
                                                series(i)%acceleration, series(i)%patterns, series(i)%noise)
                case default
                    call fail(error, 'there is no source "'//source//'"')
                end select
                if (allocated(error)) return
            end associate
        end do
        if (source == 'optimal') then
            call solve_optimal(calibration, setup, estimate%gyros, estimate%rods%driven, leakage, estimate%steps, &
                               solution, error)
            call move_alloc(series, solution%series)
            return
        end if
        call list_considered(calibration, setup, estimate, source, series, considered)
        call solve_offset(calibration, estimate%motion, series, considered, estimate%rods%driven, leakage, &
                          leakage_sigmas(setup), setup%scale_sigma, solution, error, &
                          [setup%proportional_leakage, setup%lift_sigma])
        call move_alloc(series, solution%series)
    end subroutine solve_by_source

    !> What is not estimated and changes the angular acceleration of a source, with its sigma.
    subroutine list_considered(calibration, setup, estimate, source, series, considered)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(in) :: estimate
        character(*), intent(in) :: source
        type(source_series_t), intent(in) :: series(:)
        type(consider_t), allocatable, intent(out) :: considered(:)

        type(consider_t) :: one
        type(error_t), allocatable :: failure
        real(dp) :: gains(3, 3), squares(3), directions(3, 3)
        integer :: i, k, n, rod, axis

        allocate (considered(0))
        n = size(series)
        select case (source)
        case ('torque+cal', 'torque', 'acc-cal')
            gains = 0           ! relative covariance
            do k = 1, 3
                if (estimate%rods%driven(k)) gains(k, k) = setup%gain_sigma**2
            end do
            if (source /= 'torque') gains = relative(estimate%rods%covariance, estimate%rods%gain)
            call symmetric_eigen(gains, squares, directions, failure)
            do k = 1, 3         ! its principal axes
                if (allocated(failure) .or. .not. squares(k) > 0) cycle
                one = consider_t(sigma=sqrt(squares(k)), span=0)
                allocate (one%change(n))
                do i = 1, n
                    if (.not. calibration%spans(i)%used) cycle
                    one%change(i)%acceleration = 0*series(i)%acceleration
                    do rod = 1, 3
                        one%change(i)%acceleration = one%change(i)%acceleration + &
                            directions(rod, k)*estimate%motion(i)%by_rod(:, rod, :)
                    end do
                end do
                considered = [considered, one]
                deallocate (one%change)
            end do
            do i = 1, n         ! the field of each place
                if (.not. calibration%spans(i)%used) cycle
                do k = 1, 3
                    one = consider_t(sigma=field_sigma(calibration, setup), span=i)
                    allocate (one%change(n))
                    one%change(i)%acceleration = estimate%motion(i)%by_field(:, k, :)
                    considered = [considered, one]
                    deallocate (one%change)
                end do
            end do
            if (source == 'torque') call by_axis(setup%inertia_sigma)
        case ('acc-raw')
            call by_axis(setup%angular_scale_sigma)
        case ('imu')
            call symmetric_eigen(estimate%gyros%spread, squares, directions, failure)
            do axis = 1, 3      ! whose angle by the gyros is wrong by a share of all three
                do k = 1, 3
                    if (allocated(failure) .or. .not. squares(k) > 0) cycle
                    one = consider_t(sigma=estimate%gyros%noise(axis)*sqrt(squares(k)), span=0)
                    allocate (one%change(n))
                    do i = 1, n
                        if (.not. calibration%spans(i)%used) cycle
                        one%change(i)%acceleration = 0*series(i)%acceleration
                        one%change(i)%acceleration(axis, :) = matmul(directions(:, k), series(i)%acceleration)
                    end do
                    considered = [considered, one]
                    deallocate (one%change)
                end do
            end do
        end select

    contains

        !> A scale of each axis.
        subroutine by_axis(sigma)
            real(dp), intent(in) :: sigma

            integer :: axis, j

            do axis = 1, 3
                one = consider_t(sigma=sigma, span=0)
                allocate (one%change(n))
                do j = 1, n
                    if (.not. calibration%spans(j)%used) cycle
                    one%change(j)%acceleration = 0*series(j)%acceleration
                    one%change(j)%acceleration(axis, :) = series(j)%acceleration(axis, :)
                end do
                considered = [considered, one]
                deallocate (one%change)
            end do
        end subroutine by_axis
    end subroutine list_considered

    !> Takes samples out whose residual exceeds five robust sigmas on some axis.
    subroutine drop_outliers(calibration, drive, estimate, solution, dropped)
        type(level1_calibration_t), intent(inout) :: calibration
        type(level1_drive_t), intent(in) :: drive
        type(level1_estimate_t), intent(in) :: estimate
        type(level1_solution_t), intent(in) :: solution
        integer, intent(out) :: dropped             !! How many

        real(dp), parameter :: LIMIT = 5, TO_SIGMA = 1.4826_dp
        real(dp), parameter :: QUIETEST = 5e-11_dp      ! m/s^2: no accelerometer of these missions is quieter
        integer, parameter :: DEGREE = 6        ! What is slower than the manoeuvre is no residual
        ! Steps of held currents leak as spikes into samples near them, which are no outliers: their amplitude at -LAGS
        ! to LAGS samples from a step is taken out. Fitted to the simulated set dirty: with fewer, samples at steps went.
        integer, parameter :: LAGS = 2
        real(dp), allocatable :: left(:, :), basis(:, :), modelled(:, :)
        logical, allocatable :: stays(:)
        real(dp) :: sigma, now(3), before(3)
        integer :: i, k, axis, n, lag, steps

        dropped = 0
        steps = merge(3*(2*LAGS + 1), 0, estimate%steps)
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i), motion => estimate%motion(i))
                if (.not. span%used) cycle
                n = size(span%time)
                allocate (basis(n, DEGREE + 1 + steps), stays(n))
                call modelled_acceleration(motion, solution%series(i), solution, modelled)
                left = transpose(span%linear - modelled)
                call polynomial_columns(span%time, DEGREE, basis)
                if (estimate%steps) then
                    do k = 1, n
                        do lag = -LAGS, LAGS
                            associate (t => span%time(k) - estimate%accelerometer_delay - estimate%rods%delay + lag*SAMPLE)
                                now = hold(drive%time, drive%current, t + SAMPLE/2)
                                before = hold(drive%time, drive%current, t - SAMPLE/2)
                            end associate
                            basis(k, DEGREE + 2 + 3*(lag + LAGS):DEGREE + 4 + 3*(lag + LAGS)) = now - before
                        end do
                    end do
                    do k = 1, n - 1
                        if (span%joined(k)) basis(k:k + 1, DEGREE + 2:) = spread(sum(basis(k:k + 1, DEGREE + 2:), 1)/2, 1, 2)
                    end do
                end if
                call orthonormalise(basis)
                stays = .true.
                do axis = 1, 3
                    call remove_space(basis, left(:, axis))
                    sigma = max(QUIETEST, TO_SIGMA*median_of(abs(left(:, axis))))
                    stays = stays .and. abs(left(:, axis)) <= LIMIT*sigma
                end do
                do k = 1, merge(n - 1, 0, estimate%steps)
                    if (span%joined(k)) stays(k:k + 1) = all(stays(k:k + 1))
                end do
                if (.not. all(stays)) then
                    dropped = dropped + count(.not. stays)
                    span%outliers = span%outliers + count(.not. stays)
                    call keep_samples(span, stays)
                end if
                deallocate (basis, stays)
            end associate
        end do
    end subroutine drop_outliers
end module gracecg_level1_sources
