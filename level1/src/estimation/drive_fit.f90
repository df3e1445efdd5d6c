!> The drive of the rods as the data show it: currents held or smooth between their samples, gains of the rods by
!> attitude and angular channels, delay of the accelerometer, and the motion of all spans that follows.
module gracecg_level1_drive_fit
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_text, only: append
    use gracecg_level1_setup, only: level1_setup_t, leakage_sigmas
    use gracecg_level1_angular, only: rod_motion, calibrate_angular_channels, gains_by_channels, band_columns
    use gracecg_level1_attitude, only: calibrate_rods, relative
    use gracecg_level1_calibration, only: level1_calibration_t, field_sigma
    use gracecg_level1_drive, only: level1_drive_t, new_drive, mark_breaks, drop_jumps, join_at_steps
    use gracecg_level1_firings, only: accelerometer_lag, gyro_lag, SAMPLE
    use gracecg_level1_offset, only: solve_offset
    use gracecg_level1_offset_solution, only: level1_solution_t, source_series_t, consider_t
    use gracecg_level1_outcome, only: level1_estimate_t, milliseconds
    implicit none
    private
    public :: choose_drive, make_motion, tie_gains, heed_steps

    real(dp), parameter :: STEP = 0.005_dp, FINE = 0.001_dp !! Of the searches for the delay of held currents, s
    real(dp), parameter :: REACH = 0.05_dp                  !! Of these searches, s: half a sample

contains

    !> The currents between their samples, gains and delays.
    subroutine choose_drive(calibration, setup, drive, estimate, error)
        type(level1_calibration_t), intent(inout) :: calibration    !! Samples at jumps of the currents are taken out
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(out) :: drive
        type(level1_estimate_t), intent(inout) :: estimate
        type(error_t), allocatable, intent(out) :: error

        estimate%steps = setup%currents /= 'smooth'
        if (setup%currents == 'auto' .and. .not. calibration%has_angular) then
            estimate%steps = .false.
            call append(estimate%remarks, 'currents are taken as smooth: without angular channels nothing tells')
        end if
        call calibrate(error)
        if (allocated(error)) return
        if (.not. estimate%steps) return
        if (setup%currents == 'auto') estimate%steps = shows_steps(calibration, estimate)
        if (estimate%steps) then
            call join_at_steps(drive, estimate%rods%delay + estimate%accelerometer_delay, estimate%accelerometer_delay_sigma, &
                               calibration)
            call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay, .true.)
        else
            call calibrate(error)
        end if

    contains

        subroutine calibrate(error)
            type(error_t), allocatable, intent(out) :: error

            call new_drive(calibration, estimate%steps, drive)
            call mark_breaks(drive, setup%torque_delay, calibration)
            call calibrate_rods(calibration, setup, drive, estimate%gyros, estimate%rods, error)
            if (allocated(error)) return
            call drop_jumps(drive, estimate%rods%delay + setup%accelerometer_delay, calibration)
            call find_accelerometer_delay(calibration, setup, drive, estimate, error)
        end subroutine calibrate
    end subroutine choose_drive

    !> Motion of all spans with an accelerometer that lags by some time.
    subroutine make_motion(calibration, setup, drive, estimate, delay, with_bands)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(in) :: drive
        type(level1_estimate_t), intent(inout) :: estimate
        real(dp), intent(in) :: delay               !! s
        logical, intent(in) :: with_bands           !! The samples are others: their bands too

        integer :: i

        if (.not. allocated(estimate%motion)) allocate (estimate%motion(size(calibration%spans)))
        do i = 1, size(calibration%spans)
            if (.not. calibration%spans(i)%used) cycle
            call rod_motion(calibration%spans(i), setup, drive, estimate%rods, delay, estimate%motion(i))
            if (with_bands) call band_columns(calibration%spans(i)%time, setup%band, estimate%motion(i)%band)
        end do
    end subroutine make_motion

    !> Gains by the attitude and the angular channels together: these, whose scale is not known, tell the ratios of the
    !> gains where rods turn the satellite about the same axis, as far as matrix and leakage are separable.
    subroutine tie_gains(calibration, setup, drive, estimate, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(in) :: drive
        type(level1_estimate_t), intent(inout) :: estimate
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: ROUNDS = 2
        real(dp), allocatable :: by_attitude(:), known(:, :), gain(:), change(:), covariance(:, :), normal(:, :)
        real(dp) :: information(3, 3), right(3), condition
        integer, allocatable :: number(:)
        integer :: round, n, k

        if (.not. calibration%has_angular .or. .not. estimate%rods%estimated) return
        number = pack([1, 2, 3], estimate%rods%driven)
        n = size(number)
        by_attitude = estimate%rods%gain(number)
        allocate (known(n, n), covariance(n, n), change(n), normal(n, n))
        call solve_normal_equations(estimate%rods%covariance(number, number), 0*by_attitude, change, known, condition, error)
        if (allocated(error)) return
        do round = 1, ROUNDS
            call calibrate_angular_channels(calibration, estimate%motion, estimate%rods%driven, estimate%angular, error)
            if (allocated(error) .or. .not. estimate%angular%separable) return
            call gains_by_channels(calibration, estimate%motion, estimate%rods%driven, estimate%angular, &
                                   field_sigma(calibration, setup), information, right, error)
            if (allocated(error)) return
            gain = estimate%rods%gain(number)
            normal = relative(information(number, number), gain) + known
            call solve_normal_equations(normal, right(number)/gain + matmul(known, by_attitude - gain), change, covariance, &
                                        condition, error)
            if (allocated(error)) return
            estimate%rods%gain(number) = gain + change
            estimate%rods%covariance(number, number) = covariance
            estimate%rods%gain_sigma = sqrt([(estimate%rods%covariance(k, k), k=1, 3)])
            call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay, .false.)
        end do
        estimate%rods%by_channels = .true.
    end subroutine tie_gains

    !> The delay of the accelerometer by its angular channels against the torque.
    subroutine find_accelerometer_delay(calibration, setup, drive, estimate, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(inout) :: drive    !! Steps of held currents are taken as sharp where they are
        type(level1_estimate_t), intent(inout) :: estimate
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: REACH = 0.4_dp, STEPS(4) = [0.1_dp, 0.05_dp, 0.02_dp, 0.01_dp]
        real(dp) :: squares(-1:1), noise(3), lowest, best, curvature, trial, sigma
        integer :: i, k, size_of_band
        logical :: usable

        estimate%accelerometer_delay = setup%accelerometer_delay
        estimate%accelerometer_delay_sigma = 0
        call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay, .true.)
        if (.not. calibration%has_angular) return
        size_of_band = 0
        do i = 1, size(calibration%spans)
            if (calibration%spans(i)%used) size_of_band = size_of_band + size(estimate%motion(i)%band, 2)
        end do
        lowest = huge(lowest)
        best = 0
        usable = .false.
        do i = -nint(REACH/STEPS(1)), nint(REACH/STEPS(1))
            call squares_at(i*STEPS(1), trial)
            if (allocated(error)) return
            if (trial < lowest) best = i*STEPS(1)
            lowest = min(lowest, trial)
            usable = usable .or. maxval(estimate%angular%explained) > 0.5_dp
        end do
        if (.not. usable) then      ! the channels do not follow the torque: there is no delay to be had from them
            call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay, .false.)
            return
        end if
        do k = 2, size(STEPS)
            call squares_at(best, trial)
            if (allocated(error)) return
            noise = estimate%angular%residual
            do i = -1, 1
                call squares_at(best + i*STEPS(k), trial)
                if (allocated(error)) return
                squares(i) = sum((estimate%angular%residual/noise)**2)*size_of_band
            end do
            curvature = squares(-1) - 2*squares(0) + squares(1)
            if (.not. curvature > 0) exit
            best = best + max(-1.0_dp, min(1.0_dp, (squares(-1) - squares(1))/(2*curvature)))*STEPS(k)
            estimate%accelerometer_delay_sigma = sqrt(2*STEPS(k)**2/curvature)
        end do
        call squares_at(best, trial)
        estimate%accelerometer_delay = best
        ! The torque it is compared with has a delay with a sigma of its own, and held currents jump between two samples.
        estimate%accelerometer_delay_sigma = hypot(estimate%accelerometer_delay_sigma, estimate%rods%delay_sigma)
        if (.not. estimate%steps) return
        estimate%accelerometer_delay_sigma = hypot(estimate%accelerometer_delay_sigma, SAMPLE/ &
                                                   sqrt(12.0_dp*count(calibration%spans%used)))
        call find_sharp_steps(calibration, setup, drive, estimate, error)
        if (allocated(error)) return
        call delay_by_firings(calibration, setup, estimate, best, sigma)
        if (sigma > 0 .and. sigma < estimate%accelerometer_delay_sigma) then
            estimate%accelerometer_delay = best
            estimate%accelerometer_delay_sigma = sigma
            if (drive%sharp) call heed_steps(calibration, setup, drive, estimate, error)
            if (allocated(error)) return
            call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay, .false.)
        else
            call refine_by_leakage(calibration, setup, drive, estimate, error)
        end if

    contains

        subroutine squares_at(delay, squares)
            real(dp), intent(in) :: delay
            real(dp), intent(out) :: squares

            call make_motion(calibration, setup, drive, estimate, delay, .false.)
            call calibrate_angular_channels(calibration, estimate%motion, estimate%rods%driven, estimate%angular, error)
            squares = estimate%angular%squares
        end subroutine squares_at
    end subroutine find_accelerometer_delay

    !> The delay by the firings, and by the angular channels as well: on which side of a step a sample lies they see at once,
    !> and tags drift so slowly through the steps that all of a span may lie within a millisecond. The mean over the
    !> likelihood of both within three sigma; sigma is left as it is.
    subroutine heed_steps(calibration, setup, drive, estimate, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(in) :: drive               !! With sharp steps
        type(level1_estimate_t), intent(inout) :: estimate      !! Its delay, that by the firings with its sigma, changes
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: SIGMAS = 3
        real(dp), allocatable :: change(:), squares(:), weight(:)
        integer :: i, most

        associate (sigma => estimate%accelerometer_delay_sigma)
            most = max(1, nint(min(SIGMAS*sigma, REACH)/FINE))
            change = [(i*FINE, i=-most, most)]
            squares = (change/sigma)**2
            do i = 1, size(change)
                call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay + change(i), .false.)
                call calibrate_angular_channels(calibration, estimate%motion, estimate%rods%driven, estimate%angular, error)
                if (allocated(error)) return
                squares(i) = squares(i) + estimate%angular%squares
            end do
        end associate
        weight = exp(-(squares - minval(squares))/2)
        estimate%accelerometer_delay = estimate%accelerometer_delay + sum(weight*change)/sum(weight)
    end subroutine heed_steps

    !> Whether the angular channels follow sharp steps of held currents better than averaged ones, and their delay then:
    !> sharp steps are seen between two samples, wherever they are there.
    subroutine find_sharp_steps(calibration, setup, drive, estimate, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(inout) :: drive
        type(level1_estimate_t), intent(inout) :: estimate
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: squares(:)
        real(dp) :: averaged, delay, sigma
        integer :: i, most
        logical :: inside

        averaged = estimate%angular%squares
        drive%sharp = .true.
        most = nint(REACH/STEP)
        allocate (squares(-most:most))
        do i = -most, most
            call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay + i*STEP, .false.)
            call calibrate_angular_channels(calibration, estimate%motion, estimate%rods%driven, estimate%angular, error)
            if (allocated(error)) return
            squares(i) = estimate%angular%squares
        end do
        call middle_of_best(squares, STEP, count(calibration%spans%used), delay, sigma, inside)
        if (minval(squares) < averaged .and. inside) then
            estimate%accelerometer_delay = estimate%accelerometer_delay + delay
            estimate%accelerometer_delay_sigma = hypot(sigma, estimate%rods%delay_sigma)
        else
            drive%sharp = .false.
        end if
        call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay, .false.)
        call calibrate_angular_channels(calibration, estimate%motion, estimate%rods%driven, estimate%angular, error)
    end subroutine find_sharp_steps

    !> The middle of the delays of a search that are as good as the best but for chance, and its sigma: samples of n spans
    !> lie at n places between two of the accelerometer, and see a step or not.
    pure subroutine middle_of_best(squares, step, spans, delay, sigma, inside)
        real(dp), intent(in) :: squares(:)          !! Over their variance; the middle one is that of no change
        real(dp), intent(in) :: step                !! From one to the next, s
        integer, intent(in) :: spans
        real(dp), intent(out) :: delay              !! From the middle of the search, s
        real(dp), intent(out) :: sigma              !! s
        logical, intent(out) :: inside              !! Of the search, not at its ends

        real(dp), parameter :: BY_CHANCE = 4        ! Two sigma
        integer :: low, high

        low = minloc(squares, 1)
        high = low
        do while (low > 1)
            if (squares(low - 1) > minval(squares) + BY_CHANCE) exit
            low = low - 1
        end do
        do while (high < size(squares))
            if (squares(high + 1) > minval(squares) + BY_CHANCE) exit
            high = high + 1
        end do
        delay = (low + high - size(squares) - 1)*step/2
        sigma = norm2([(high - low + 1)*step, SAMPLE/spans])/sqrt(12.0_dp)
        inside = low > 1 .and. high < size(squares)
    end subroutine middle_of_best

    !> The delay of the accelerometer by its linear channels, where the steps of held currents leak as spikes: the delays
    !> with which d and leakage leave least, the middle of those that are as good but for chance. It replaces that by the
    !> angular channels where it is the better one.
    !>
    !> Steps that are sharp lie in one sample or in the next for linear and angular channels alike: both are taken
    !> together, and finely, for the tags drift through the steps within a span, so that less than STEP is seen.
    subroutine refine_by_leakage(calibration, setup, drive, estimate, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(in) :: drive
        type(level1_estimate_t), intent(inout) :: estimate
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: squares(:)
        real(dp) :: delay, sigma, step_of_search
        integer :: i, most
        logical :: inside

        step_of_search = merge(FINE, STEP, drive%sharp)
        most = nint(REACH/step_of_search)
        allocate (squares(-most:most))
        do i = -most, most
            call squares_at(estimate%accelerometer_delay + i*step_of_search, squares(i))
            if (allocated(error)) return
        end do
        call middle_of_best(squares, step_of_search, count(calibration%spans%used), delay, sigma, inside)
        sigma = hypot(sigma, estimate%rods%delay_sigma)
        if (sigma < estimate%accelerometer_delay_sigma .and. inside) then
            estimate%accelerometer_delay = estimate%accelerometer_delay + delay
            estimate%accelerometer_delay_sigma = sigma
        end if
        call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay, .false.)

    contains

        !> Twice the logarithm of the likelihood, but for its sign and a constant.
        subroutine squares_at(delay, squares)
            real(dp), intent(in) :: delay
            real(dp), intent(out) :: squares

            type(source_series_t) :: series(size(calibration%spans))
            type(consider_t) :: nothing(0)
            type(level1_solution_t) :: solution
            integer :: k, columns

            call make_motion(calibration, setup, drive, estimate, delay, .false.)
            columns = 0
            do k = 1, size(series)
                if (.not. calibration%spans(k)%used) cycle
                series(k)%acceleration = estimate%motion(k)%torque
                columns = columns + size(estimate%motion(k)%band, 2)
            end do
            call solve_offset(calibration, estimate%motion, series, nothing, estimate%rods%driven, 'prior', &
                              leakage_sigmas(setup), setup%scale_sigma, solution, error)
            squares = 2*columns*sum(log(max(solution%rms, tiny(1.0_dp))))
            if (allocated(error) .or. .not. drive%sharp) return
            call calibrate_angular_channels(calibration, estimate%motion, estimate%rods%driven, estimate%angular, error)
            squares = squares + estimate%angular%squares
        end subroutine squares_at
    end subroutine refine_by_leakage

    !> The delay of the accelerometer by the firings of thrusters: their lag in its samples less that behind their tags,
    !> which is what the setup says or, where the gyros contradict it, what these show. A sigma of 0: not known.
    subroutine delay_by_firings(calibration, setup, estimate, delay, sigma)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(inout) :: estimate
        real(dp), intent(out) :: delay      !! s
        real(dp), intent(out) :: sigma      !! s

        real(dp), parameter :: CONTRADICTION = 4        ! Sigma
        real(dp) :: shown, shown_sigma, fired, fired_sigma, weight

        sigma = 0
        delay = 0
        if (.not. (estimate%gyros%known .and. estimate%rods%by_gyros)) return   ! nothing says when they fired
        call gyro_lag(calibration%firings, estimate%gyros%gyro, shown, shown_sigma)
        call accelerometer_lag(calibration%firings, delay, sigma)
        if (.not. (sigma > 0 .and. shown_sigma > 0)) then
            sigma = 0
            return
        end if
        shown = shown - (estimate%rods%gyro_delay - estimate%rods%delay)
        shown_sigma = hypot(shown_sigma, estimate%rods%delay_sigma)
        fired = shown
        fired_sigma = shown_sigma
        if (abs(shown - setup%firing_delay) < CONTRADICTION*hypot(shown_sigma, setup%firing_delay_sigma)) then
            weight = setup%firing_delay_sigma**2/(setup%firing_delay_sigma**2 + shown_sigma**2)
            fired = setup%firing_delay + weight*(shown - setup%firing_delay)
            fired_sigma = sqrt(weight)*shown_sigma
        else
            call append(estimate%remarks, 'the gyros show thrusters to fire '//trim(milliseconds(shown))//' +- '// &
                        trim(milliseconds(shown_sigma))//' ms behind their tags, not firing_delay')
        end if
        delay = delay - fired
        sigma = hypot(sigma, fired_sigma)
    end subroutine delay_by_firings

    !> Whether the angular channels show the steps of held currents: what of both a moving mean does not follow is the
    !> same.
    logical function shows_steps(calibration, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate

        integer, parameter :: HALF = 2          ! Of the moving mean, samples
        real(dp), parameter :: SHARE = 0.4_dp
        real(dp) :: product, square, model(3), seen(3), weight(3)
        integer :: i, k, axis

        product = 0
        square = 0
        weight = 1/max(estimate%angular%residual, tiny(1.0_dp))**2
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i), motion => estimate%motion(i))
                if (.not. span%used) cycle
                do k = 1 + HALF, size(span%time) - HALF
                    model = motion%torque(:, k) - sum(motion%torque(:, k - HALF:k + HALF), 2)/(2*HALF + 1)
                    seen = span%angular(:, k) - sum(span%angular(:, k - HALF:k + HALF), 2)/(2*HALF + 1)
                    do axis = 1, 3
                        product = product + weight(axis)*model(axis)*seen(axis)*estimate%angular%common
                        square = square + weight(axis)*(model(axis)*estimate%angular%common)**2
                    end do
                end do
            end associate
        end do
        shows_steps = product > SHARE*square
    end function shows_steps
end module gracecg_level1_drive_fit
