!> The offset over months and years, from the calibrations of a mission: between them it changes by what is known
!> (masses that are moved, gas that the tanks lose) and by a random walk for what is not.
!>
!> With y = d less the known part of the tanks: y(t + dt) = y(t) + w, w ~ N(0, Q dt); at a movement y grows by the
!> change, its covariance by that of the change; a calibration observes y. The information of the calibrations up to a time
!> gives the offset from what was known then, and with that of all later ones, gathered backwards, the offset from all
!> calibrations (D. C. Fraser, J. E. Potter, IEEE Trans. Automat. Contr. 14 (1969) 387-390). Between two calibrations the
!> offset by those before and by those behind are independent: their difference is a jump that nobody knows of, or chance
!> (A. S. Willsky, H. L. Jones, IEEE Trans. Automat. Contr. 21 (1976) 108-112). When it will leave its limits is found from
!> many futures that are drawn.
module gracecg_estimation_offset_history
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: JULIAN_YEAR, SECONDS_PER_DAY
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_base_statistics, only: chi_square_tail, order_of
    use gracecg_base_vectors, only: identity
    use gracecg_environment_time, only: utc_t, utc_plus, seconds_between, utc_text
    use gracecg_estimation_information, only: information_t, information_of, no_information, squares_of
    use gracecg_estimation_offset_change, only: offset_change_t, is_between
    use gracecg_estimation_offset_movement, only: movement_t, likelier_movement, chance_of_jump
    use gracecg_estimation_saved_estimate, only: dated_offset_t
    implicit none
    private
    public :: history_settings_t, tank_series_t, new_tank_series, offset_history_t, history_point_t, trace_offset
    public :: LONGEST_FUTURE, DEFAULT_WALK

    real(dp), parameter :: DEFAULT_WALK = 10e-6_dp
    !! What the offset changes by in a year for reasons that nobody knows, standard deviation of each axis, m: in half a
    !! year 7 um, ten times the 0.7 um that CSR-TM-00-01 Table 1.2 has for the decrease of all mass, and a seventh of the
    !! 46 um that it has for unequal tanks, which is known where the tanks' masses are
    character(3), parameter :: NAMES(3) = ['d_x', 'd_y', 'd_z']     !! In messages
    real(dp), parameter :: LONGEST_FUTURE = 20*JULIAN_YEAR  !! That is looked at, s
    integer, parameter :: STREAM_FUTURES = 31       !! Random numbers of the futures

    !> How to trace the offset.
    type :: history_settings_t
        real(dp) :: walk(3) = DEFAULT_WALK      !! Standard deviation of the random walk in a year, m
        real(dp) :: limit = 0.1e-3_dp           !! Of every component, m: CSR-TM-00-01 section 1.2, per half year
        real(dp) :: risk = 0.05_dp              !! Of having left the limit, that calls for a calibration
        real(dp) :: step = 10*SECONDS_PER_DAY   !! Between the points that are given, s
        integer :: futures = 2000               !! That are drawn; 0: the future is not asked for
    end type history_settings_t

    !> What the gas of the two tanks does to the offset, at times; linear between, the last rate goes on.
    type :: tank_series_t
        type(utc_t), allocatable :: time(:)    !! UTC, ascending
        real(dp), allocatable :: shift(:, :)    !! Change of d since the first time, (3, n), m
    end type tank_series_t

    !> The offset at a time. Body axes, m.
    type :: history_point_t
        type(utc_t) :: time    !! UTC
        logical :: is_calibration = .false.    !! A calibration, not a time between
        real(dp) :: filtered(3) = 0             !! From the calibrations up to here
        real(dp) :: filtered_sigma(3) = 0       !! Of it
        real(dp) :: smoothed(3) = 0             !! From all calibrations
        real(dp) :: smoothed_sigma(3) = 0       !! Of it
        real(dp) :: filtered_covariance(3, 3) = 0, smoothed_covariance(3, 3) = 0    !! m^2
    end type history_point_t

    !> The whole history.
    type :: offset_history_t
        type(history_point_t), allocatable :: points(:)     !! From the first calibration to today, in order of time
        type(history_point_t) :: today          !! Filtered: from all that is known
        integer :: calibrations = 0         !! That are used
        real(dp) :: statistic = 0               !! Chi square of what each calibration brought that was not expected
        integer :: degrees = 0                  !! Of freedom: 3 for each calibration after the first
        real(dp) :: probability = 1             !! That chance makes so much
        type(movement_t) :: movement            !! That the calibrations show
        logical :: leaves = .false.             !! More than half of the futures leave the limit within 20 years
        type(utc_t) :: leaving(3)               !! When 16, 50, 84 % of the futures have left it; the end of the 20 years: later
        type(utc_t) :: calibrate_by             !! When the risk of having left it is reached; the end of the 20 years: later
        real(dp) :: left_in_the_end = 0         !! Part of the futures that leave the limit within 20 years
        real(dp) :: left_already = 0            !! Part of the futures that begin outside
    end type offset_history_t

    !> What happens at a node of the filter.
    type :: node_t
        real(dp) :: t = 0                       !! s from the first calibration
        integer :: calibration = 0, change = 0  !! Numbers; 0: none
    end type node_t

contains

    !> The tanks' part of the offset: d = -sum (m_i - m_i(0)) r_i/M, for the centre of mass lies millimetres from the
    !> origin. Fails when times do not rise or a mass is negative.
    subroutine new_tank_series(time, mass, position, satellite_mass, series, error)
        type(utc_t), intent(in) :: time(:)
        real(dp), intent(in) :: mass(:, :)          !! Of the gas, (2, size(time)), kg
        real(dp), intent(in) :: position(3, 2)      !! Of the tanks, body axes, m
        real(dp), intent(in) :: satellite_mass      !! With the gas of the first time, kg
        type(tank_series_t), intent(out) :: series
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        if (size(time) < 2) then
            call fail(error, 'tanks: at least two times are needed')
            return
        end if
        allocate (series%shift(3, size(time)))
        do i = 1, size(time)
            if (.not. all(mass(:, i) >= 0) .or. .not. sum(mass(:, i)) < satellite_mass) then
                call fail(error, 'tanks: a mass of '//trim(utc_text(time(i)))//' is negative, or more than the satellite''s')
                return
            else if (i > 1) then
                if (.not. seconds_between(time(i - 1), time(i)) > 0) then
                    call fail(error, 'tanks: times must rise, but '//trim(utc_text(time(i)))//' follows '// &
                              trim(utc_text(time(i - 1))))
                    return
                end if
            end if
            series%shift(:, i) = -matmul(position, mass(:, i) - mass(:, 1))/(satellite_mass - sum(mass(:, 1) - mass(:, i)))
        end do
        series%time = time
    end subroutine new_tank_series

    !> The tanks' part at a time; 0 without tanks.
    function tank_shift(tanks, time) result(shift)
        type(tank_series_t), intent(in) :: tanks
        type(utc_t), intent(in) :: time
        real(dp) :: shift(3)

        real(dp) :: t
        integer :: i, n

        shift = 0
        if (.not. allocated(tanks%time)) return
        n = size(tanks%time)
        associate (times => [(seconds_between(tanks%time(1), tanks%time(i)), i=1, n)])
            t = seconds_between(tanks%time(1), time)
            i = max(1, min(n - 1, last_not_after(times, t)))
            shift = tanks%shift(:, i) + (t - times(i))/(times(i + 1) - times(i))*(tanks%shift(:, i + 1) - tanks%shift(:, i))
        end associate
    end function tank_shift

    !> Filter, smoother, and what the future may bring. Fails without a calibration, when one is given twice, when today is
    !> before the last one, or a covariance is singular.
    subroutine trace_offset(offsets, changes, tanks, settings, history, error, today)
        type(dated_offset_t), intent(in) :: offsets(:)      !! Of the calibrations, in any order
        type(offset_change_t), intent(in) :: changes(:)     !! Known ones, in any order
        type(tank_series_t), intent(in) :: tanks            !! Empty: nothing is known of them
        type(history_settings_t), intent(in) :: settings
        type(offset_history_t), intent(out) :: history
        type(error_t), allocatable, intent(out) :: error
        type(utc_t), intent(in), optional :: today          !! When absent, the time of the last calibration

        type(node_t), allocatable :: nodes(:)
        type(utc_t) :: start, end
        integer :: i

        if (size(offsets) == 0) then
            call fail(error, 'a history needs at least one calibration')
            return
        end if
        start = offsets(1)%time
        end = start
        do i = 2, size(offsets)
            if (seconds_between(offsets(i)%time, start) > 0) start = offsets(i)%time
            if (seconds_between(end, offsets(i)%time) > 0) end = offsets(i)%time
        end do
        if (present(today)) then
            if (seconds_between(today, end) > 0) then
                call fail(error, 'today, '//trim(utc_text(today))//', lies before the last calibration, '// &
                          trim(utc_text(end)))
                return
            end if
            end = today
        end if
        history%calibrations = size(offsets)
        call lay_out(offsets, changes, start, seconds_between(start, end), settings%step, nodes)
        call refuse_repeated(offsets, nodes, error)
        if (.not. allocated(error)) call filter_and_smooth(offsets, changes, tanks, settings, start, nodes, history, error)
        if (.not. allocated(error)) call look_for_drift(offsets, changes, tanks, settings, start, nodes, history, error)
        if (allocated(error)) return
        history%today = history%points(size(history%points))
        if (settings%futures > 0) call draw_futures(changes, tanks, settings, history)
    end subroutine trace_offset

    !> A calibration that counts twice makes the sigma too small.
    subroutine refuse_repeated(offsets, nodes, error)
        type(dated_offset_t), intent(in) :: offsets(:)
        type(node_t), intent(in) :: nodes(:)        !! In order of time
        type(error_t), allocatable, intent(out) :: error

        integer :: i, k

        do i = 2, size(nodes)
            if (nodes(i)%calibration == 0) cycle
            do k = i - 1, 1, -1
                if (nodes(k)%t < nodes(i)%t) exit
                if (nodes(k)%calibration == 0) cycle
                if (any(abs(offsets(nodes(i)%calibration)%offset - offsets(nodes(k)%calibration)%offset) > 0)) cycle
                call fail(error, 'the calibration of '//trim(utc_text(offsets(nodes(i)%calibration)%time))//' is given twice '// &
                          '(same time, same offset): each counts once, leave one out')
                return
            end do
        end do
    end subroutine refuse_repeated

    !> All times of interest in order; a change comes before a calibration of the same time.
    subroutine lay_out(offsets, changes, start, length, step, nodes)
        type(dated_offset_t), intent(in) :: offsets(:)
        type(offset_change_t), intent(in) :: changes(:)
        type(utc_t), intent(in) :: start
        real(dp), intent(in) :: length, step        !! s
        type(node_t), allocatable, intent(out) :: nodes(:)

        type(node_t), allocatable :: unsorted(:)
        real(dp) :: t
        integer :: i, n

        n = ceiling(length/step)
        allocate (unsorted(0))
        do i = 1, size(changes)
            t = seconds_between(start, changes(i)%time)
            if (t > 0 .and. t <= length) unsorted = [unsorted, node_t(t, change=i)]
        end do
        unsorted = [unsorted, [(node_t(seconds_between(start, offsets(i)%time), calibration=i), i=1, size(offsets))], &
                    [(node_t(min(i*step, length)), i=1, n)]]
        nodes = unsorted(order_of(unsorted%t))
    end subroutine lay_out

    !> The points of the history. The first node is a calibration.
    subroutine filter_and_smooth(offsets, changes, tanks, settings, start, nodes, history, error)
        type(dated_offset_t), intent(in) :: offsets(:)
        type(offset_change_t), intent(in) :: changes(:)
        type(tank_series_t), intent(in) :: tanks
        type(history_settings_t), intent(in) :: settings
        type(utc_t), intent(in) :: start
        type(node_t), intent(in) :: nodes(:)
        type(offset_history_t), intent(inout) :: history
        type(error_t), allocatable, intent(out) :: error

        type(information_t) :: seen(size(nodes)), earlier(size(nodes)), later   ! of y
        real(dp) :: shift(3), first
        integer :: i, n

        n = size(nodes)
        allocate (history%points(n))
        do i = 1, n
            history%points(i)%time = utc_plus(start, nodes(i)%t)
            history%points(i)%is_calibration = nodes(i)%calibration > 0
            shift = tank_shift(tanks, history%points(i)%time)
            seen(i) = no_information(3)
            if (nodes(i)%calibration > 0) then
                associate (offset => offsets(nodes(i)%calibration))
                    call information_of(offset%offset - shift, offset%covariance, seen(i), error, NAMES)
                end associate
            end if
            earlier(i) = seen(i)
            if (i > 1 .and. .not. allocated(error)) then
                earlier(i) = earlier(i - 1)
                call pass(i, 1, earlier(i))
                call earlier(i)%add(seen(i))
            end if
            if (.not. allocated(error)) call estimate(earlier(i), history%points(i)%filtered, &
                history%points(i)%filtered_covariance, history%points(i)%filtered_sigma)
            if (allocated(error)) return
        end do
        first = earlier(1)%squares_at(history%points(1)%filtered - tank_shift(tanks, start))
        history%statistic = earlier(n)%squares_at(history%points(n)%filtered - shift) - first
        history%degrees = 3*(size(offsets) - 1)
        if (history%degrees > 0) history%probability = chi_square_tail(history%statistic, history%degrees)
        later = no_information(3)
        do i = n, 1, -1
            shift = tank_shift(tanks, history%points(i)%time)
            call earlier(i)%add(later)
            call estimate(earlier(i), history%points(i)%smoothed, history%points(i)%smoothed_covariance, &
                          history%points(i)%smoothed_sigma)
            if (allocated(error) .or. i == 1) return
            call later%add(seen(i))
            if (nodes(i)%calibration > 0) call look_for_jump(i)
            if (.not. allocated(error)) call pass(i, -1, later)
            if (allocated(error)) return
        end do

    contains

        !> From the node before to a node, or back.
        subroutine pass(i, direction, information)
            integer, intent(in) :: i, direction     ! The later node; 1: forwards, -1: back
            type(information_t), intent(inout) :: information

            real(dp) :: step(3), variance(3)

            step = 0
            variance = settings%walk**2*(nodes(i)%t - nodes(i - 1)%t)/JULIAN_YEAR
            if (nodes(i)%change > 0) then
                step = direction*changes(nodes(i)%change)%change
                variance = variance + changes(nodes(i)%change)%sigma**2
            end if
            call information%propagate(step, variance, error)
        end subroutine pass

        !> Whether the offset jumps between a calibration and the one before it: the likeliest place.
        subroutine look_for_jump(i)
            integer, intent(in) :: i                ! Node of the calibration

            type(information_t) :: before
            real(dp), dimension(3) :: from, to
            real(dp), dimension(3, 3) :: from_covariance, to_covariance
            real(dp) :: gain
            integer :: axis

            before = earlier(i - 1)
            call pass(i, 1, before)
            if (.not. allocated(error)) call before%solve(from, from_covariance, error, NAMES)
            if (.not. allocated(error)) call later%solve(to, to_covariance, error, NAMES)
            if (allocated(error)) return
            gain = squares_of(to - from, from_covariance + to_covariance)
            if (gain <= history%movement%gain) return
            history%movement = movement_t('jump', &
                history%points(findloc(history%points(:i - 1)%is_calibration, .true., 1, back=.true.))%time, &
                history%points(i)%time, to - from, sqrt([(from_covariance(axis, axis) + to_covariance(axis, axis), axis=1, 3)]), &
                gain, chance_of_jump(gain, size(offsets) - 1))
        end subroutine look_for_jump

        !> d at the node whose tanks' part is `shift`.
        subroutine estimate(information, offset, covariance, sigma)
            type(information_t), intent(in) :: information
            real(dp), intent(out) :: offset(3), covariance(3, 3), sigma(3)

            integer :: axis

            call information%solve(offset, covariance, error, NAMES)
            offset = offset + shift
            sigma = [(sqrt(covariance(axis, axis)), axis=1, 3)]
        end subroutine estimate
    end subroutine filter_and_smooth

    !> Whether a drift explains the calibrations, or explains them better than the likeliest jump. What is not expected is a
    !> parabola of the rate.
    subroutine look_for_drift(offsets, changes, tanks, settings, start, nodes, history, error)
        type(dated_offset_t), intent(in) :: offsets(:)
        type(offset_change_t), intent(in) :: changes(:)
        type(tank_series_t), intent(in) :: tanks
        type(history_settings_t), intent(in) :: settings
        type(utc_t), intent(in) :: start
        type(node_t), intent(in) :: nodes(:)
        type(offset_history_t), intent(inout) :: history    !! With the likeliest jump
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: UNIT_CHANGE = 10e-6_dp   ! m: of the change over all
        integer, parameter :: FEWEST = 4            ! Calibrations: of three a drift is a jump
        type(movement_t) :: drift
        real(dp) :: unit(3, 3), matrix(3, 3), covariance(3, 3), rhs(3), alone(3), length, condition
        integer :: i, k

        if (size(offsets) < FEWEST) then
            history%movement = movement_t()
            return
        end if
        length = maxval(nodes%t, mask=nodes%calibration > 0)
        unit = UNIT_CHANGE*identity(3)
        do i = 1, 3
            alone(i) = without(unit(:, i))
            rhs(i) = (without(-unit(:, i)) - alone(i))/4
            matrix(i, i) = alone(i) + 2*rhs(i) - history%statistic
        end do
        do i = 1, 3
            do k = 1, i - 1
                matrix(i, k) = (without(unit(:, i) + unit(:, k)) - alone(i) - alone(k) + history%statistic)/2
                matrix(k, i) = matrix(i, k)
            end do
        end do
        if (.not. allocated(error)) &
            call solve_normal_equations(matrix, rhs, drift%change, covariance, condition, error, NAMES)
        if (allocated(error)) return
        drift%kind = 'drift'
        drift%from = start
        drift%to = utc_plus(start, length)
        drift%gain = dot_product(drift%change, rhs)
        drift%change = UNIT_CHANGE*drift%change
        drift%sigma = UNIT_CHANGE*sqrt([(covariance(i, i), i=1, 3)])
        drift%probability = chi_square_tail(drift%gain, 3)
        history%movement = likelier_movement(history%movement, drift)

    contains

        !> What is not expected of the offsets less a drift.
        real(dp) function without(change) result(statistic)
            real(dp), intent(in) :: change(3)       ! Over all, m

            type(offset_history_t) :: other
            type(dated_offset_t) :: straight(size(offsets))
            integer :: node

            statistic = 0
            if (allocated(error)) return
            straight = offsets
            do node = 1, size(nodes)
                if (nodes(node)%calibration == 0) cycle
                associate (offset => straight(nodes(node)%calibration)%offset)
                    offset = offset - nodes(node)%t/length*change
                end associate
            end do
            call filter_and_smooth(straight, changes, tanks, settings, start, nodes, other, error)
            statistic = other%statistic
        end function without
    end subroutine look_for_drift

    !> Draws futures from today on, and asks when each first leaves the limit.
    subroutine draw_futures(changes, tanks, settings, history)
        type(offset_change_t), intent(in) :: changes(:)
        type(tank_series_t), intent(in) :: tanks
        type(history_settings_t), intent(in) :: settings
        type(offset_history_t), intent(inout) :: history

        real(dp) :: factor(3, 3), y(3, settings%futures), noise(3), base(3), shift(3)
        logical :: has_left(settings%futures)
        type(random_stream_t) :: stream
        type(utc_t) :: time
        integer, allocatable :: left(:)     ! futures that have left by each step
        integer :: i, k, change

        stream = new_stream(1_i8, 0, 0, 0, STREAM_FUTURES)
        factor = root_of(history%today%filtered_covariance)
        base = tank_shift(tanks, history%today%time)
        do i = 1, settings%futures
            call stream%normals(noise)
            y(:, i) = history%today%filtered - base + matmul(factor, noise)
        end do
        has_left = .false.
        allocate (left(0:int(LONGEST_FUTURE/settings%step)))
        do k = 0, ubound(left, 1)
            time = utc_plus(history%today%time, k*settings%step)
            shift = tank_shift(tanks, time)
            do change = 1, merge(size(changes), 0, k > 0)
                if (.not. is_between(changes(change), utc_plus(time, -settings%step), time)) cycle
                do i = 1, settings%futures
                    call stream%normals(noise)
                    y(:, i) = y(:, i) + changes(change)%change + changes(change)%sigma*noise
                end do
            end do
            do i = 1, settings%futures
                if (has_left(i)) cycle
                if (k > 0) then
                    call stream%normals(noise)
                    y(:, i) = y(:, i) + settings%walk*sqrt(settings%step/JULIAN_YEAR)*noise
                end if
                has_left(i) = any(abs(y(:, i) + shift) > settings%limit)
            end do
            left(k:) = count(has_left)
            if (all(has_left)) exit
        end do
        history%left_already = left(0)/real(settings%futures, dp)
        history%leaving = [time_of(0.16_dp), time_of(0.5_dp), time_of(0.84_dp)]
        history%calibrate_by = time_of(settings%risk)
        history%left_in_the_end = left(ubound(left, 1))/real(settings%futures, dp)
        history%leaves = history%left_in_the_end > 0.5_dp

    contains

        !> When a part of the futures has left.
        type(utc_t) function time_of(part)
            real(dp), intent(in) :: part

            k = findloc(left >= part*settings%futures, .true., 1) - 1
            if (k < 0) k = nint(LONGEST_FUTURE/settings%step)
            time_of = utc_plus(history%today%time, k*settings%step)
        end function time_of
    end subroutine draw_futures

    !> The lower triangular root of a covariance (Cholesky).
    pure function root_of(covariance) result(factor)
        real(dp), intent(in) :: covariance(3, 3)
        real(dp) :: factor(3, 3)

        integer :: i, j

        factor = 0
        do j = 1, 3
            factor(j, j) = sqrt(max(0.0_dp, covariance(j, j) - sum(factor(j, :j - 1)**2)))
            do i = j + 1, 3
                if (factor(j, j) > 0) factor(i, j) = (covariance(i, j) - dot_product(factor(i, :j - 1), factor(j, :j - 1)))/ &
                                                     factor(j, j)
            end do
        end do
    end function root_of
end module gracecg_estimation_offset_history
