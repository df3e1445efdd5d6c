!> The estimate of the offset from Level-1 data: rods calibrated by the attitude, delays, all sources of angular
!> acceleration side by side, and a judgement that names what is wrong.
module gracecg_estimation_level1_estimate
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, MICROMETRE, MILLIMETRE, NANOTESLA
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: solve_normal_equations, symmetric_eigen
    use gracecg_base_statistics, only: median_of
    use gracecg_base_text, only: string_t, append, integer_text, rounded_text
    use gracecg_observations_level1_setup, only: level1_setup_t
    use gracecg_estimation_level1_angular, only: level1_motion_t, angular_calibration_t, rod_motion, &
        calibrate_angular_channels, gains_by_channels, channels_at, differentiate_attitude, band_columns
    use gracecg_estimation_level1_attitude, only: rod_calibration_t, calibrate_rods
    use gracecg_estimation_level1_basis, only: orthonormalise, remove_space, polynomial_columns
    use gracecg_estimation_level1_calibration, only: level1_calibration_t, level1_span_t, keep_samples
    use gracecg_estimation_level1_drive, only: level1_drive_t, new_drive, mark_breaks, drop_jumps, join_at_steps
    use gracecg_estimation_level1_firings, only: accelerometer_lag, gyro_lag, SAMPLE
    use gracecg_estimation_level1_gyros, only: gyro_axes_t, fit_gyro_axes, gyro_attitude
    use gracecg_estimation_level1_series, only: hold
    use gracecg_estimation_level1_offset, only: level1_solution_t, source_series_t, consider_t, solve_offset, &
        modelled_acceleration, sigma_of
    implicit none
    private
    public :: level1_estimate_t, estimate_level1, LEVEL1_SOURCES, CLOSE_ENOUGH
    public :: milliseconds, offset_remark, VERDICTS, REQUIREMENT

    !> The sources; the first is the recommended one
    character(10), parameter :: LEVEL1_SOURCES(6) = [character(10) :: 'torque+cal', 'torque', 'acc-cal', 'acc-raw', 'sca', &
                                                     'imu']
    real(dp), parameter :: CLOSE_ENOUGH = 10*MICROMETRE     !! Sources agree within this or three sigma
    character(24), parameter :: VERDICTS(0:2) = [character(24) :: 'good', 'to be used with care', 'not to be used'] !! By flag
    real(dp), parameter :: REQUIREMENT = 0.1_dp*MILLIMETRE  !! Of |d| by axis (GCMD, Remote Sensing 14(16) 4030)
    real(dp), parameter :: STEP = 0.005_dp                  !! Of the search for the delay of held currents, s
    integer, parameter :: REACH = 10                        !! Of that search, steps: half a sample
    real(dp), parameter :: GOOD_SIGMA = 5*MICROMETRE        !! A source with a greater one is to be used with care
    real(dp), parameter :: POOR_SIGMA = 50*MICROMETRE       !! And with a greater one than this not at all

    type :: level1_estimate_t
        !! The result of a calibration
        type(rod_calibration_t) :: rods    !! Gains and delay of the rods
        type(level1_drive_t) :: drive                       !! Currents at any time
        logical :: steps = .false.                          !! Currents are held from tag to tag
        real(dp) :: accelerometer_delay = 0                 !! s
        real(dp) :: accelerometer_delay_sigma = 0           !! s; 0: not estimated
        type(angular_calibration_t) :: angular    !! The angular channels
        type(gyro_axes_t) :: gyros    !! Axes of the gyros
        type(level1_motion_t), allocatable :: motion(:)     !! Of each span, by the recommended source
        type(level1_solution_t), allocatable :: solutions(:)    !! By source, the recommended one first
        type(string_t), allocatable :: findings(:)          !! What is wrong, by name
        type(string_t), allocatable :: remarks(:)           !! What is to be known
        integer :: flag = 2                                 !! Of the first solution
    end type level1_estimate_t

contains

    !> Estimates by the sources asked for. Fails when the data do not allow any estimate.
    subroutine estimate_level1(calibration, setup, sources, leakage, estimate, error)
        type(level1_calibration_t), intent(inout) :: calibration    !! Outliers are taken out
        type(level1_setup_t), intent(in) :: setup
        character(*), intent(in) :: sources(:)              !! Of LEVEL1_SOURCES
        character(*), intent(in) :: leakage                 !! estimate, prior or none
        type(level1_estimate_t), intent(out) :: estimate
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: EDIT_ROUNDS = 3
        type(level1_drive_t) :: drive
        type(level1_solution_t) :: solution
        type(error_t), allocatable :: failure
        integer :: i, round, dropped

        allocate (estimate%findings(0), estimate%remarks(0), estimate%solutions(0))
        if (.not. any(calibration%spans%used)) then
            call fail(error, 'no span is usable: the first, because of '//trim(calibration%spans(1)%reason))
            return
        end if
        call fit_gyro_axes(calibration, estimate%gyros, failure)
        call choose_drive(calibration, setup, drive, estimate, error)
        if (.not. allocated(error)) call tie_gains(calibration, setup, drive, estimate, error)
        if (allocated(error)) return
        do round = 1, EDIT_ROUNDS
            solution%source = LEVEL1_SOURCES(1)
            call solve_by_source(calibration, setup, estimate, LEVEL1_SOURCES(1), leakage, solution, error)
            if (allocated(error)) return
            call drop_outliers(calibration, drive, estimate, solution, dropped)
            if (dropped == 0) exit
            call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay, .true.)
        end do
        do i = 1, size(sources)
            call solve_by_source(calibration, setup, estimate, sources(i), leakage, solution, failure)
            if (allocated(failure)) then
                call append(estimate%remarks, trim(sources(i))//': '//failure%message)
                deallocate (failure)
                cycle
            end if
            estimate%solutions = [estimate%solutions, solution]
        end do
        estimate%drive = drive
        if (size(estimate%solutions) == 0) then
            call fail(error, 'no source gives an offset: '//estimate%remarks(size(estimate%remarks))%text)
            return
        end if
        call name_faults(calibration, setup, estimate)
        call judge(calibration, estimate)
        estimate%flag = estimate%solutions(1)%flag
    end subroutine estimate_level1

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
            call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay, .false.)
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

    !> A matrix over the products of some gains.
    pure function relative(matrix, gain)
        real(dp), intent(in) :: matrix(:, :)
        real(dp), intent(in) :: gain(:)
        real(dp) :: relative(size(gain), size(gain))

        real(dp), parameter :: LEAST = 1e-3_dp      ! A rod that does nothing
        real(dp) :: divisor(size(gain))

        divisor = sign(max(abs(gain), LEAST), gain)
        relative = matrix/(spread(divisor, 1, size(gain))*spread(divisor, 2, size(gain)))
    end function relative

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
            call make_motion(calibration, setup, drive, estimate, best, .false.)
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

    !> Whether the angular channels follow sharp steps of held currents better than averaged ones, and their delay then:
    !> sharp steps are seen between two samples, wherever they are there.
    subroutine find_sharp_steps(calibration, setup, drive, estimate, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(inout) :: drive
        type(level1_estimate_t), intent(inout) :: estimate
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: squares(-REACH:REACH), averaged, delay, sigma
        integer :: i
        logical :: inside

        averaged = estimate%angular%squares
        drive%sharp = .true.
        do i = -REACH, REACH
            call make_motion(calibration, setup, drive, estimate, estimate%accelerometer_delay + i*STEP, .false.)
            call calibrate_angular_channels(calibration, estimate%motion, estimate%rods%driven, estimate%angular, error)
            if (allocated(error)) return
            squares(i) = estimate%angular%squares
        end do
        call middle_of_best(squares, count(calibration%spans%used), delay, sigma, inside)
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
    pure subroutine middle_of_best(squares, spans, delay, sigma, inside)
        real(dp), intent(in) :: squares(-REACH:)    !! Over their variance, at -REACH to REACH steps
        integer, intent(in) :: spans
        real(dp), intent(out) :: delay              !! From the middle of the search, s
        real(dp), intent(out) :: sigma              !! s
        logical, intent(out) :: inside              !! Of the search, not at its ends

        real(dp), parameter :: BY_CHANCE = 4        ! Two sigma
        integer :: low, high

        low = minloc(squares, 1) - 1 - REACH
        high = low
        do while (low > -REACH)
            if (squares(low - 1) > minval(squares) + BY_CHANCE) exit
            low = low - 1
        end do
        do while (high < REACH)
            if (squares(high + 1) > minval(squares) + BY_CHANCE) exit
            high = high + 1
        end do
        delay = (low + high)*STEP/2
        sigma = norm2([(high - low + 1)*STEP, SAMPLE/spans])/sqrt(12.0_dp)
        inside = low > -REACH .and. high < REACH
    end subroutine middle_of_best

    !> The delay of the accelerometer by its linear channels, where the steps of held currents leak as spikes: the delays
    !> with which d and leakage leave least, the middle of those that are as good but for chance. It replaces that by the
    !> angular channels where it is the better one.
    subroutine refine_by_leakage(calibration, setup, drive, estimate, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_drive_t), intent(in) :: drive
        type(level1_estimate_t), intent(inout) :: estimate
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: squares(-REACH:REACH), delay, sigma
        integer :: i
        logical :: inside

        do i = -REACH, REACH
            call squares_at(estimate%accelerometer_delay + i*STEP, squares(i))
            if (allocated(error)) return
        end do
        call middle_of_best(squares, count(calibration%spans%used), delay, sigma, inside)
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
                              setup%leakage_prior, setup%scale_sigma, solution, error)
            squares = 2*columns*sum(log(max(solution%rms, tiny(1.0_dp))))
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

    !> The offset by one source.
    subroutine solve_by_source(calibration, setup, estimate, source, leakage, solution, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(inout) :: estimate
        character(*), intent(in) :: source, leakage
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
                case ('torque+cal')
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
        call list_considered(calibration, setup, estimate, source, series, considered)
        call solve_offset(calibration, estimate%motion, series, considered, estimate%rods%driven, leakage, &
                          setup%leakage_prior, setup%scale_sigma, solution, error, setup%proportional_leakage)
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

    !> The sigma of the field of a place: that of the setup, or less where spans at several places show that the corrected
    !> magnetometer is closer to the model: PLACES and LEAST are fitted to the simulated sets four60 and dirty, where that
    !> difference is 5 nT and the model's field is the true one.
    pure real(dp) function field_sigma(calibration, setup) result(sigma)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup

        integer, parameter :: PLACES = 3
        real(dp), parameter :: LEAST = 10*NANOTESLA     ! What no difference shows: a constant along SRF of that size

        sigma = setup%field_sigma
        if (calibration%field_difference < 0 .or. count(calibration%spans%used) < PLACES) return
        sigma = min(sigma, max(LEAST, calibration%field_difference))
    end function field_sigma

    !> Takes samples out whose residual exceeds five robust sigmas on some axis.
    subroutine drop_outliers(calibration, drive, estimate, solution, dropped)
        type(level1_calibration_t), intent(inout) :: calibration
        type(level1_drive_t), intent(in) :: drive
        type(level1_estimate_t), intent(in) :: estimate
        type(level1_solution_t), intent(in) :: solution
        integer, intent(out) :: dropped

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

    !> Names what is wrong with data or setup.
    subroutine name_faults(calibration, setup, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(inout) :: estimate

        real(dp), parameter :: LEAST_CORRECTION = 5e-3_dp, WITHIN = 3e-3_dp, CERTAIN = 3e-3_dp      ! s
        real(dp), parameter :: HARDLY = 0.3_dp
        integer :: k

        do k = 1, 3
            if (.not. estimate%rods%driven(k)) cycle
            if (estimate%rods%gain(k) < 0) call append(estimate%findings, 'wrong sign of rod '//AXES(k)// &
                ': the attitude gives it a gain of '//trim(rounded_text(estimate%rods%gain(k)*setup%rod_gain(k), 4))// &
                ' A m^2/mA; check rod_sign, or the sign of its currents')
        end do
        if (maxval(estimate%rods%explained) < HARDLY) call append(estimate%findings, 'the currents do not explain the '// &
            'attitude: B currents with the wrong sign, currents or attitude of another satellite or another time')
        associate (correction => calibration%clock_correction)
            if (abs(correction) > LEAST_CORRECTION .and. estimate%accelerometer_delay_sigma > 0 .and. &
                estimate%accelerometer_delay_sigma < CERTAIN) then
                if (abs(estimate%accelerometer_delay + correction) < WITHIN + 2*estimate%accelerometer_delay_sigma) &
                    call append(estimate%findings, 'tags left in OBC time: the accelerometer lags by '// &
                                trim(milliseconds(estimate%accelerometer_delay))//' ms, which is the clock correction of '// &
                                trim(milliseconds(correction))//' ms that its tags lack')
                if (abs(estimate%accelerometer_delay - correction) < WITHIN + 2*estimate%accelerometer_delay_sigma) &
                    call append(estimate%findings, 'tags of ACC1A are in GPS time already, though they say OBC time: the '// &
                                'accelerometer is ahead by the clock correction, '//trim(milliseconds(correction))//' ms')
            end if
            if (abs(correction) > LEAST_CORRECTION .and. estimate%rods%delay_sigma < CERTAIN .and. &
                abs(estimate%rods%delay - correction) < WITHIN + 2*estimate%rods%delay_sigma) &
                call append(estimate%findings, 'tags left in OBC time: the torque is ahead of the currents by '// &
                            trim(milliseconds(-estimate%rods%delay))//' ms, the clock correction that the tags of the '// &
                            'currents lack')
        end associate
        if (.not. estimate%steps .and. estimate%rods%delay < -max(LEAST_CORRECTION, 5*estimate%rods%delay_sigma)) &
            call append(estimate%remarks, 'the torque is ahead of the currents by '//trim(milliseconds(-estimate%rods%delay))// &
                        ' ms, which no rod can be: tags left in OBC time, or a clock correction that does not hold')
        if (calibration%zero_angular) call append(estimate%findings, 'transplanted data (ACT) in place of ACC1A: all angular '// &
            'accelerations are zero, and the linear ones may be those of the other satellite')
        if (calibration%has_angular) call check_axes(calibration, setup, estimate)
    end subroutine name_faults

    !> A time in milliseconds, to a tenth, with blanks behind it.
    pure function milliseconds(time) result(text)
        real(dp), intent(in) :: time        !! s
        character(24) :: text

        write (text, '(f24.1)') time*1e3_dp
        text = adjustl(text)
    end function milliseconds

    !> Whether the offset is within the requirement, for people, with blanks behind it: by axis.
    pure function offset_remark(offset) result(text)
        real(dp), intent(in) :: offset(3)   !! d, m
        character(80) :: text

        integer :: k

        text = ''
        do k = 1, 3
            if (abs(offset(k)) > REQUIREMENT) text = trim(text)//' '//AXES(k)
        end do
        if (text == '') then
            text = 'the offset is below 0.1 mm on every axis'
        else
            text = 'the offset is above 0.1 mm on'//trim(text)
        end if
    end function offset_remark

    !> Whether the angular channels follow the torque in the axes that the setup says.
    subroutine check_axes(calibration, setup, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(inout) :: estimate

        integer, parameter :: PERMUTATIONS(3, 6) = reshape([1, 2, 3, 2, 3, 1, 3, 1, 2, 1, 3, 2, 2, 1, 3, 3, 2, 1], [3, 6])
        real(dp), parameter :: HARDLY = 0.3_dp, CLEARLY = 0.3_dp
        real(dp) :: correlation(3, 3), product(3, 3), seen(3), acted(3), best, given, score
        real(dp), allocatable :: angular(:, :), torque(:, :)
        integer :: i, k, axis, chosen, axes_found(3), signs(3)

        product = 0
        seen = 0
        acted = 0
        do i = 1, size(calibration%spans)
            if (.not. calibration%spans(i)%used) cycle
            angular = matmul(calibration%spans(i)%angular, estimate%motion(i)%band)
            torque = matmul(estimate%motion(i)%torque, estimate%motion(i)%band)
            product = product + matmul(torque, transpose(angular))
            seen = seen + sum(angular**2, 2)
            acted = acted + sum(torque**2, 2)
        end do
        do axis = 1, 3
            correlation(:, axis) = product(:, axis)/sqrt(max(acted*seen(axis), tiny(1.0_dp)))
        end do
        given = sum([(correlation(k, k), k=1, 3)])/3
        best = given
        chosen = 1
        do i = 1, size(PERMUTATIONS, 2)
            score = sum([(abs(correlation(k, PERMUTATIONS(k, i))), k=1, 3)])/3
            if (score > best + epsilon(best)) then
                best = score
                chosen = i
            end if
        end do
        if (best < HARDLY) then
            call append(estimate%findings, 'the accelerometer does not show the torque of the rods: data of the other '// &
                        'satellite (transplanted ACT), or of another time')
        else if (best > given + CLEARLY) then
            do k = 1, 3
                signs(k) = nint(sign(1.0_dp, correlation(k, PERMUTATIONS(k, chosen))))
                axes_found(k) = signs(k)*setup%accelerometer_axes(PERMUTATIONS(k, chosen))
            end do
            call append(estimate%findings, 'axes of the accelerometer are wrong (AF taken as SRF): its angular channels '// &
                        'follow the torque with accelerometer_axes = '//trim(axes_text(axes_found))//', not '// &
                        trim(axes_text(setup%accelerometer_axes)))
        end if
    end subroutine check_axes

    !> Three axes as in the setup, with blanks behind them.
    pure function axes_text(numbers) result(text)
        integer, intent(in) :: numbers(3)
        character(40) :: text

        text = integer_text(numbers(1))//', '//integer_text(numbers(2))//', '//integer_text(numbers(3))
    end function axes_text

    !> Flags of the solutions: 0 good, 1 with care, 2 not to be used.
    subroutine judge(calibration, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(inout) :: estimate

        real(dp), parameter :: WORST_CONDITION = 1e6_dp, SIGMAS = 3
        ! Fitted to the simulated set four60: 5 flagged `sca`, which was 1 to 2 um off
        real(dp), parameter :: MOST_COLOURED = 8
        real(dp) :: sigma(3), difference(3), allowed(3)
        logical :: mixed
        integer :: i, k

        do i = 1, size(estimate%solutions)
            associate (solution => estimate%solutions(i), first => estimate%solutions(1))
                sigma = sigma_of(solution)
                solution%flag = 0
                if (maxval(sigma) > GOOD_SIGMA) call lower(1, 'sigma above 5 um')
                mixed = solution%leakage == 'a priori' .and. solution%condition > WORST_CONDITION
                if (mixed) call lower(1, 'leakage and d are not separable')
                if (maxval(sigma) > POOR_SIGMA) then
                    call lower(2, 'sigma above 50 um')
                    if (mixed) solution%reason = 'leakage and d are not separable: '//trim(solution%reason)
                end if
                if (solution%leakage == 'none') call lower(1, 'leakage is left out')
                if (size(estimate%findings) > 0) call lower(2, 'see what is wrong')
                if (abs(log(solution%whiteness)) > log(MOST_COLOURED)) call lower(1, 'the residuals are not white in the band')
                if (.not. calibration%has_angular) call lower(1, 'the accelerometer has no angular channels')
                do k = 1, 3
                    difference(k) = abs(solution%offset(k) - first%offset(k))
                    allowed(k) = max(CLOSE_ENOUGH, SIGMAS*hypot(sigma(k), sqrt(first%covariance(k, k))))
                end do
                if (any(difference > allowed)) then
                    call lower(2, 'disagrees with '//trim(first%source))
                    ! A scale that is only said, of rods or angular channels, does not speak against one that is measured.
                    if (solution%source /= 'torque' .and. solution%source /= 'acc-raw') then
                        first%flag = max(first%flag, 1)
                        first%reason = trim(solution%source)//' disagrees'
                    end if
                end if
                if (solution%degrees > 0) then
                    if (solution%chi_square > solution%degrees + 5*sqrt(2.0_dp*solution%degrees)) &
                        call lower(1, 'the spans disagree')
                end if
            end associate
        end do

    contains

        subroutine lower(flag, reason)
            integer, intent(in) :: flag
            character(*), intent(in) :: reason

            if (flag <= estimate%solutions(i)%flag .and. flag < 2) return
            estimate%solutions(i)%flag = flag
            estimate%solutions(i)%reason = reason
        end subroutine lower
    end subroutine judge
end module gracecg_estimation_level1_estimate
