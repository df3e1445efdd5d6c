!> Whether currents, attitude and accelerometer show the manoeuvre at the same time: tags of one of them that are seconds off (a
!> leap second, GPS time taken as UTC) look like wrong signs, axes or gains; those of the accelerometer may jump by less.
module gracecg_level1_time_shifts
    use gracecg_level1_basics
    use gracecg_base_text, only: join
    use gracecg_environment_time, only: utc_text
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, take_measured_moments
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series
    use gracecg_level1_frames, only: ORDERS
    use gracecg_level1_held_currents, only: rod_accelerations
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_series, only: interpolate
    implicit none
    private
    public :: say_shift, say_jump, say_exchange

    real(dp), parameter :: STEP = 0.5_dp        !! Of the times that are compared, s
    integer, parameter :: LAGS = 38             !! Shifts either way, in steps: 19 s
    integer, parameter :: MOST_ARCS = 8         !! So many tell
    real(dp), parameter :: AROUND = 2           !! Attitudes are differenced over so long either way, s
    real(dp), parameter :: ALIKE = 0.8_dp       !! Correlation of what is at the same time, chosen: sound days have 0.98 and more;
                                                !! heads alone (without SCA1B) have 0.5, and tell nothing
    real(dp), parameter :: SHORTEST = 40        !! Of all arcs, s: twice the largest shift
    real(dp), parameter :: BETTER = 0.15_dp     !! By which it is more with the shift, chosen

contains

    !> Which tags are off, and by how much; empty: none by a second or more, or it is not clear.
    subroutine say_shift(arcs, with_channels, text)
        type(observation_set_t), intent(in) :: arcs(:)
        logical, intent(in) :: with_channels        !! The accelerometer has angular channels
        character(:), allocatable, intent(out) :: text      !! Without a full stop

        real(dp) :: by_attitude, by_channels
        logical :: clear(2)

        text = ''
        if (sum(arcs%knowledge%duration) < SHORTEST) return
        call find_lag(arcs, .false., by_attitude, clear(1))
        by_channels = 0
        clear(2) = .true.
        if (with_channels) call find_lag(arcs, .true., by_channels, clear(2))
        if (.not. all(clear) .or. max(abs(by_attitude), abs(by_channels)) < 1) return
        if (.not. with_channels) then
            text = rounded_text(by_attitude, 3)//' s between the tags of the attitude and those of the currents: the attitude'
        else if (abs(by_attitude - by_channels) < 1) then
            text = 'tags of the currents (MAG) are '//rounded_text(-by_attitude, 3)//' s off: attitude and accelerometer'
        else if (abs(by_channels) < 1) then
            text = 'tags of the attitude (SCA) are '//rounded_text(by_attitude, 3)//' s off: it'
        else if (abs(by_attitude) < 1) then
            text = 'tags of the accelerometer (ACC) are '//rounded_text(by_channels, 3)//' s off: it'
        else
            text = 'tags of the attitude are '//rounded_text(by_attitude, 3)//' s off, of the accelerometer '// &
                   rounded_text(by_channels, 3)//' s: they'
        end if
        text = text//' would follow the torque of the rods then; leap seconds, or GPS time taken as another'
    end subroutine say_shift

    !> Whether the delay of the accelerometer is another from some time on: its tags jump there. What its channels leave at the fit
    !> is then the rate of the rods' torque times what the delay is off, which is found before and behind every sample. The
    !> best place counts; by how much is told by the channels less the torque, for the fit takes up some of it.
    subroutine say_jump(estimate, before, text)
        type(level1_estimate_t), intent(in) :: estimate     !! With residuals of the channels
        integer, intent(in) :: before                       !! Spans before these
        character(:), allocatable, intent(out) :: text      !! Without a full stop; empty: they do not jump

        real(dp), parameter :: HALF = 0.5_dp        ! s: torques are differenced over as much either way
        ! s, chosen: by the first d moves by some 30 um, and a wrong inertia looks like 0.05; a rate holds no longer than the last
        ! (exchanged currents look like more)
        real(dp), parameter :: LEAST = 0.1_dp, MOST = 1
        ! Of white noise, chosen: 20 sound simulated days have at most 4.1, two with square currents 6.7, jumps of 0.3 s 83 and 161
        real(dp), parameter :: SIGMAS = 15
        integer, parameter :: FEWEST = 50           ! Samples on either side
        type(torque_rods_t) :: rods
        real(dp), allocatable :: product(:, :), square(:), gain(:), time(:)     ! products with what is left, and with `seen`
        real(dp), allocatable :: seen(:, :)         ! by the channels of an arc less the torque, about its mean
        integer, allocatable :: arc(:)
        real(dp) :: acted(3, 2), rate(3), squares, t, jump
        integer :: i, k, n, epoch

        text = ''
        n = sum([(size(estimate%arcs(i)%accelerometer_time), i=1, size(estimate%arcs))])
        allocate (product(0:n, 2), source=0.0_dp)
        allocate (square(0:n), gain(n), time(n), source=0.0_dp)
        allocate (arc(n))
        squares = 0
        n = 0
        do i = 1, size(estimate%arcs)
            associate (set => estimate%arcs(i), left => estimate%residuals(i))
                rods = set%knowledge%rods
                rods%gain = estimate%rods%gain
                rods%delay = estimate%rods%delay + estimate%accelerometer_delay
                seen = set%angular_acceleration - rod_accelerations(set, rods, set%accelerometer_time, .true.)
                seen = seen - spread(sum(seen, 2)/size(seen, 2), 2, size(seen, 2))
                do k = 1, size(seen, 2)     ! those samples, too, that the fit leaves out
                    t = set%accelerometer_time(k)
                    if (t < HALF .or. t > set%knowledge%duration - HALF) cycle
                    epoch = 1 + nint(t/set%knowledge%accelerometer_interval)
                    acted = rod_accelerations(set, rods, [t - HALF, t + HALF], .true.)
                    rate = (acted(:, 2) - acted(:, 1))/(2*HALF)
                    n = n + 1
                    product(n, :) = product(n - 1, :) - [sum(rate*left%angular(:, epoch)), sum(rate*seen(:, k))]
                    square(n) = square(n - 1) + sum(rate**2)
                    squares = squares + sum(left%angular(:, epoch)**2)
                    time(n) = t
                    arc(n) = i
                end do
            end associate
        end do
        if (n < 2*FEWEST) return
        gain = 0
        do k = FEWEST, n - FEWEST
            if (square(k) > 0 .and. square(n) > square(k)) gain(k) = jump_at(k, 1)**2*square(k)*(square(n) - square(k))/ &
                square(n)
        end do
        k = maxloc(gain, 1)
        jump = jump_at(k, 2)
        if (abs(jump_at(k, 1)) < LEAST .or. abs(jump) > MOST) return
        if (gain(k) < SIGMAS**2*(squares - product(n, 1)**2/square(n) - gain(k))/(3*n)) return
        text = 'the tags of the accelerometer jump by about '//trim(rounded_text(jump, 2))//' s at '// &
               trim(utc_text(utc_plus(estimate%arcs(arc(k))%knowledge%epoch, time(k))))//' UTC, in or behind span '// &
               integer_text(before + estimate%span_of(arc(k)))//': its delay is another from there on; correct the tags, or '// &
               'give the spans before or behind it alone'

    contains

        !> By how much the delay is more behind a sample than before it, s.
        pure real(dp) function jump_at(k, by)
            integer, intent(in) :: k, by            !! A sample; 1 by what the fit leaves, 2 by the channels less the torque

            jump_at = (product(n, by) - product(k, by))/(square(n) - square(k)) - product(k, by)/square(k)
        end function jump_at
    end subroutine say_jump

    !> By how much later than the torque of the rods the satellite turns as attitude or channels show.
    subroutine find_lag(arcs, by_channels, lag, clear)
        type(observation_set_t), intent(in) :: arcs(:)
        logical, intent(in) :: by_channels          !! Else by the attitude
        real(dp), intent(out) :: lag                !! s
        logical, intent(out) :: clear               !! They are alike with this lag, and less so with others

        real(dp) :: products(3, -LAGS:LAGS), seen(3, -LAGS:LAGS), acted(3, -LAGS:LAGS), correlation(-LAGS:LAGS)
        real(dp), allocatable :: torque(:, :), turned(:, :)
        real(dp) :: gain(3), share
        integer :: i, k, n, shift

        products = 0
        seen = tiny(1.0_dp)
        acted = tiny(1.0_dp)
        do i = 1, min(size(arcs), MOST_ARCS)
            n = floor(arcs(i)%knowledge%duration/STEP)
            allocate (turned(3, 0:n), torque(3, 0:n))
            torque = rod_accelerations(arcs(i), arcs(i)%knowledge%rods, [(k*STEP, k=0, n)], .true.)
            call take_turning(arcs(i), by_channels, turned)
            do shift = -LAGS, LAGS
                associate (a => torque(:, max(0, -shift):min(n, n - shift)), b => turned(:, max(0, shift):min(n, n + shift)))
                    products(:, shift) = products(:, shift) + covariance(a, b)
                    acted(:, shift) = acted(:, shift) + covariance(a, a)
                    seen(:, shift) = seen(:, shift) + covariance(b, b)
                end associate
            end do
            deallocate (torque, turned)
        end do
        correlation = sum(products/sqrt(acted*seen), 1)/3
        shift = maxloc(correlation, 1) - LAGS - 1
        if (correlation(shift) < max(correlation(0) + BETTER, -correlation(0))) shift = 0      ! or the sign is wrong
        call explain_turning(arcs, by_channels, [1, 2, 3], gain, share)
        if (minval(gain) < 0 .and. share > correlation(shift)**2) shift = 0     ! or that of a rod
        lag = shift*STEP
        clear = correlation(shift) > ALIKE
    end subroutine find_lag

    !> Whether the satellite turns as if the currents of rods were exchanged.
    subroutine say_exchange(arcs, with_channels, text)
        type(observation_set_t), intent(in) :: arcs(:)
        logical, intent(in) :: with_channels        !! The accelerometer has angular channels
        character(:), allocatable, intent(out) :: text      !! Without a full stop; empty: it does not

        real(dp) :: gain(3), share(size(ORDERS, 2))
        integer :: i

        text = ''
        do i = 1, size(share)
            call explain_turning(arcs, with_channels, ORDERS(:, i), gain, share(i))
            if (i > 1 .and. minval(gain) < 0) share(i) = 0      ! as they are, one may have the wrong sign
        end do
        i = maxloc(share, 1)
        if (share(i) < max(ALIKE**2, share(1) + BETTER)) return
        text = 'the currents of rods x, y, z are those of '//join(AXES(ORDERS(:, i)), ', ')//': so exchanged they explain '// &
               integer_text(nint(100*share(i)))//' % of how the satellite turns, as they are '// &
               integer_text(nint(100*share(1)))//' %; correct the files'
    end subroutine say_exchange

    !> How the rods explain how the satellite turns, each with a gain of its own.
    subroutine explain_turning(arcs, by_channels, order, gain, share)
        type(observation_set_t), intent(in) :: arcs(:)
        logical, intent(in) :: by_channels          !! As channels show it; else the attitude
        integer, intent(in) :: order(3)             !! Whose moments each rod has
        real(dp), intent(out) :: gain(3)            !! 0: it is not driven
        real(dp), intent(out) :: share              !! Of the squares

        real(dp), allocatable :: turned(:, :), by_rod(:, :, :)
        real(dp) :: normal(3, 3), rhs(3), squares, inverse(3, 3), condition
        type(moment_series_t) :: moments
        type(torque_rods_t) :: one
        type(error_t), allocatable :: failure
        integer :: i, k, n, rod

        normal = 0
        rhs = 0
        squares = tiny(squares)
        gain = 0
        share = 0
        do i = 1, min(size(arcs), MOST_ARCS)
            n = floor(arcs(i)%knowledge%duration/STEP)
            allocate (turned(3, 0:n), by_rod(3, 0:n, 3))
            one = arcs(i)%knowledge%rods
            associate (measured => arcs(i)%knowledge%rods%measured)
                call new_moment_series(measured%time, measured%moment(order, :), moments, failure, measured%held)
            end associate
            if (allocated(failure)) return
            call take_measured_moments(moments, one)
            do rod = 1, 3
                one%gain = 0
                one%gain(rod) = arcs(i)%knowledge%rods%gain(rod)
                by_rod(:, :, rod) = rod_accelerations(arcs(i), one, [(k*STEP, k=0, n)], .true.)
            end do
            call take_turning(arcs(i), by_channels, turned)
            squares = squares + sum(covariance(turned, turned))
            do rod = 1, 3
                rhs(rod) = rhs(rod) + sum(covariance(by_rod(:, :, rod), turned))
                do k = 1, 3
                    normal(k, rod) = normal(k, rod) + sum(covariance(by_rod(:, :, k), by_rod(:, :, rod)))
                end do
            end do
            deallocate (turned, by_rod)
        end do
        do rod = 1, 3
            if (.not. normal(rod, rod) > 0) normal(rod, rod) = 1        ! it is not driven
        end do
        call solve_normal_equations(normal, rhs, gain, inverse, condition, failure)
        if (.not. allocated(failure)) share = dot_product(gain, rhs)/squares
    end subroutine explain_turning

    !> How the satellite turns, every STEP.
    subroutine take_turning(arc, by_channels, turned)
        type(observation_set_t), intent(in) :: arc
        logical, intent(in) :: by_channels          !! As the angular channels show it; else the attitude
        real(dp), intent(out) :: turned(:, 0:)      !! (3, 0:n), rad/s^2

        integer :: k

        if (by_channels) then
            do k = 0, ubound(turned, 2)
                call interpolate(arc%accelerometer_time, arc%angular_acceleration, k*STEP, turned(:, k))
            end do
        else
            call difference_attitude(arc, turned)
        end if
    end subroutine take_turning

    !> What the attitude shows of the angular acceleration: second differences of its angles.
    subroutine difference_attitude(arc, turned)
        type(observation_set_t), intent(in) :: arc
        real(dp), intent(out) :: turned(:, 0:)      !! (3, 0:n), rad/s^2

        real(dp), allocatable :: angle(:, :), time(:)
        integer, allocatable :: cameras(:)
        real(dp) :: before(3), at(3), behind(3)
        integer :: i, k

        cameras = pack([(i, i=1, size(arc%star_camera_head))], arc%star_camera_head == 1)
        time = arc%star_camera_time(cameras)
        allocate (angle(3, size(cameras)), source=0.0_dp)
        do i = 2, size(cameras)
            angle(:, i) = angle(:, i - 1) + rotation_between(arc%quaternion(:, cameras(i - 1)), arc%quaternion(:, cameras(i)))
        end do
        do k = 0, ubound(turned, 2)
            associate (t => min(max(k*STEP, time(1) + AROUND), time(size(time)) - AROUND))
                call interpolate(time, angle, t - AROUND, before)
                call interpolate(time, angle, t, at)
                call interpolate(time, angle, t + AROUND, behind)
            end associate
            turned(:, k) = (before - 2*at + behind)/AROUND**2
        end do
    end subroutine difference_attitude

    !> Sums of the products of two series about their means, by axis.
    pure function covariance(a, b) result(sums)
        real(dp), intent(in) :: a(:, :), b(:, :)
        real(dp) :: sums(3)

        sums = sum(a*b, 2) - sum(a, 2)*sum(b, 2)/size(a, 2)
    end function covariance
end module gracecg_level1_time_shifts
