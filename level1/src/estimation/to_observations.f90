!> Spans of a calibration from Level-1 files as observation sets, an arc each: SRF for body axes, times from the arc's first
!> sample of the accelerometer, the currents of the rods as measured moments, the gyros as head 2.
module gracecg_level1_to_observations
    use gracecg_level1_basics
    use gracecg_base_coloured_noise, only: ONE_SIDED
    use gracecg_base_statistics, only: sort
    use gracecg_estimation_physical_model, only: turned_by
    use gracecg_observations_observation_set, only: observation_set_t, check_observations
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series
    use gracecg_spacecraft_torque_rods, only: take_measured_moments, torque_rods_t, rod_moments
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t, field_sigma, signs_are_known, utc_at
    use gracecg_level1_gyros, only: gyro_axes_t, gyro_attitude
    use gracecg_level1_held_currents, only: rod_accelerations
    use gracecg_level1_series, only: mean_weights, find_means, APART
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_setup, only: level1_setup_t, QUIETEST
    implicit none
    private
    public :: arcs_of_spans, SAMPLE, prepare_observations

    !> Of an arc, s: chosen. It has attitude, rate, torque and forces of its own, each with polynomials, which in a piece
    !> of less than two cycles of the rods (6 to 12 s each, usually) leave hardly anything to the offset
    real(dp), parameter :: SHORTEST = 15
    !> Left out about a firing, s: as much before it as by `veto_before`; behind it less than by `veto_after`, for attitude
    !> and rate begin anew there
    real(dp), parameter :: BEFORE = 0.3_dp, AFTER = 1.0_dp
    real(dp), parameter :: SAMPLE = 0.1_dp          !! Of the accelerometer, nominally, s
    real(dp), parameter :: UNSURE_DELAY = 4e-3_dp   !! By which delays may be off, s: two or three of their sigmas
    !> Of an arc where rods are driven all day, s: the polynomials of its torques and forces, chosen for spans of one to some
    !> minutes, follow no more of what is slow
    real(dp), parameter :: LONGEST = 300
    !> Samples on either side of a mean: tones of 0.1 Hz stay within 0.1 %, and what is near 1 Hz, which means of 1 Hz would show
    !> near the tones, goes
    integer, parameter :: HALF_OF_ARC = 12
    real(dp), parameter :: AROUND = 20              !! Currents are taken so long before and behind an arc, s
    real(dp), parameter :: ENDS = 0.3_dp        !! Left out at the ends of a span, where currents may jump, s: some samples

    real(dp), parameter :: MOMENT_STEP = 0.1_dp     !! Of the moments, s
    real(dp), parameter :: MOMENT_MARGIN = 1        !! Before and behind the arc, s
    integer, parameter :: HALF = 6                  !! A mean has so many samples on either side: less than apart, their noise is
                                                    !! independent
    integer, parameter :: FEWEST = 30               !! Means, or the samples stay as they are

contains

    !> The arcs of all spans that are used; a firing inside, or the edge of the Earth's shadow, cuts a span in two. Fails as
    !> moments of rods do.
    subroutine arcs_of_spans(calibration, setup, axes, held, sets, span_of, error, with_unsure, of_means, seldom)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(gyro_axes_t), intent(in) :: axes       !! Of the gyros
        logical, intent(in) :: held                 !! The currents are, from tag to tag
        type(observation_set_t), allocatable, intent(out) :: sets(:)
        integer, allocatable, intent(out) :: span_of(:)     !! The span of each arc
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: with_unsure        !! Samples near steps of held currents stay; absent: they do not
        logical, intent(in), optional :: seldom             !! Held currents jump now and then, anywhere between two tags: samples
                                                            !! there do not stay; absent: at a tag
        logical, intent(in), optional :: of_means           !! Means, one a second, stand in for the samples; absent: they do not

        real(dp), allocatable :: cuts(:), pieces(:, :)
        logical :: unsure_stay, thinned, anywhere
        integer :: i, k

        unsure_stay = .not. held
        if (present(with_unsure)) unsure_stay = unsure_stay .or. with_unsure
        thinned = .false.
        if (present(of_means)) thinned = of_means
        anywhere = .false.
        if (present(seldom)) anywhere = seldom
        allocate (pieces(2, 0), span_of(0))
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (.not. span%used) cycle
                cuts = [span%start + ENDS - AFTER, pack(span%firings, span%firings > span%start .and. &
                                                        span%firings < span%stop), span%shadow_edges, span%stop - ENDS + BEFORE]
                call sort(cuts)
                if (calibration%all_day) cuts = shortened(cuts)
                do k = 1, size(cuts) - 1
                    if (cuts(k + 1) - cuts(k) < SHORTEST) cycle
                    pieces = reshape([pieces, cuts(k) + AFTER, cuts(k + 1) - BEFORE], [2, size(pieces, 2) + 1])
                    if (calibration%all_day) then
                        if (.not. suffices(setup, span, pieces(:, size(pieces, 2)))) pieces = pieces(:, :size(pieces, 2) - 1)
                    end if
                    if (size(pieces, 2) > size(span_of)) span_of = [span_of, i]
                end do
            end associate
        end do
        allocate (sets(size(span_of)))
        do k = 1, size(sets)
            call make_arc(calibration, setup, axes, held, unsure_stay, anywhere, calibration%spans(span_of(k)), pieces(1, k), &
                          pieces(2, k), sets(k), error)
            call add_context(error, 'span '//integer_text(span_of(k)))
            if (allocated(error)) return
            if (thinned) call thin_arc(sets(k))
        end do
    end subroutine arcs_of_spans

    !> Cuts with others between them: arcs of the same length, none longer than LONGEST.
    pure function shortened(cuts) result(more)
        real(dp), intent(in) :: cuts(:)             !! s, rising
        real(dp), allocatable :: more(:)

        integer :: i, k, parts

        more = cuts(:1)
        do k = 2, size(cuts)
            parts = max(1, ceiling((cuts(k) - cuts(k - 1))/LONGEST))
            more = [more, (cuts(k - 1) + i*(cuts(k) - cuts(k - 1))/parts, i=1, parts)]
        end do
    end function shortened

    !> Whether samples and attitudes of an arc suffice.
    pure logical function suffices(setup, span, arc)
        type(level1_setup_t), intent(in) :: setup
        type(level1_span_t), intent(in) :: span
        real(dp), intent(in) :: arc(2)              !! From and to, s

        real(dp) :: samples
        real(dp), allocatable :: attitude(:)

        samples = real(last_not_after(span%time, arc(2)) - last_not_after(span%time, arc(1)), dp)
        attitude = [arc(1), pack(span%attitude_time, span%attitude_time > arc(1) .and. span%attitude_time < arc(2)), arc(2)]
        suffices = samples*SAMPLE > setup%least_share*(arc(2) - arc(1)) .and. &
                   maxval(attitude(2:) - attitude(:size(attitude) - 1)) < setup%longest_attitude_gap
    end function suffices

    !> Takes means in place of the accelerometer's samples; time 0 stays that of the first sample, from where their epochs count.
    subroutine thin_arc(set)
        type(observation_set_t), intent(inout) :: set

        integer, allocatable :: epochs(:), centres(:)
        real(dp), allocatable :: means(:, :)
        real(dp) :: first

        associate (knowledge => set%knowledge)
            epochs = nint(set%accelerometer_time/knowledge%accelerometer_interval)
            call find_means(epochs, set%acceleration, mean_weights(HALF_OF_ARC), centres, means, .true.)
            first = centres(1)*knowledge%accelerometer_interval
            set%acceleration = means
            if (allocated(set%angular_acceleration)) then
                call find_means(epochs, set%angular_acceleration, mean_weights(HALF_OF_ARC), centres, means, .true.)
                set%angular_acceleration = means
            end if
            set%accelerometer_time = (centres - centres(1))*knowledge%accelerometer_interval
            knowledge%accelerometer_interval = APART*knowledge%accelerometer_interval
            knowledge%duration = set%accelerometer_time(size(centres))
            knowledge%epoch = utc_plus(knowledge%epoch, first)
            knowledge%rods%measured%time = knowledge%rods%measured%time - first
        end associate
        set%magnetometer_time = set%magnetometer_time - first
        set%orbit_time = set%orbit_time - first
        set%star_camera_time = set%star_camera_time - first
        associate (inside => set%star_camera_time >= 0 .and. set%star_camera_time <= set%knowledge%duration)
            set%quaternion = reshape(pack(set%quaternion, spread(inside, 1, 4)), [4, count(inside)])
            set%star_camera_head = pack(set%star_camera_head, inside)
            set%star_camera_time = pack(set%star_camera_time, inside)
        end associate
    end subroutine thin_arc

    subroutine make_arc(calibration, setup, axes, held, unsure_stay, anywhere, span, from, to, set, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(gyro_axes_t), intent(in) :: axes
        logical, intent(in) :: held, unsure_stay, anywhere
        type(level1_span_t), intent(in) :: span
        real(dp), intent(in) :: from, to            !! s from the epoch of the calibration
        type(observation_set_t), intent(out) :: set
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: NO_TURN(4) = [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
        type(moment_series_t) :: moments
        real(dp), allocatable :: times(:), attitude(:), moment(:, :)
        integer, allocatable :: wanted(:), near(:)
        real(dp) :: zero, interval
        integer :: k, first

        wanted = [(k, k=last_not_after(span%time, from) + 1, last_not_after(span%time, to))]
        if (.not. unsure_stay) wanted = pack(wanted, .not. unsure(calibration, setup, span%time(wanted), anywhere))
        times = span%time(wanted)
        zero = times(1)
        interval = median_of(times(2:) - times(:size(times) - 1))
        interval = (times(size(times)) - zero)/nint((times(size(times)) - zero)/interval)
        set%accelerometer_time = nint((times - zero)/interval)*interval
        set%acceleration = span%linear(:, wanted)
        if (calibration%has_angular) set%angular_acceleration = span%angular(:, wanted)
        near = [(k, k=max(1, last_not_after(span%attitude_time, from - AROUND)), last_not_after(span%attitude_time, to + AROUND))]
        attitude = span%attitude_time(near)
        associate (knowledge => set%knowledge)
            knowledge%name = 'GRACE-'//calibration%satellite//' '//calibration%date
            knowledge%epoch = utc_at(calibration, zero)
            knowledge%duration = set%accelerometer_time(size(times))
            knowledge%mass = setup%mass
            knowledge%inertia = setup%inertia
            knowledge%accelerometer_interval = interval
            associate (steps => attitude(2:) - attitude(:size(attitude) - 1))
                knowledge%star_camera_interval = median_of(steps)
                knowledge%magnetometer_interval = maxval(steps)
            end associate
            knowledge%mounting = spread(NO_TURN, 2, size(knowledge%mounting, 2))
            knowledge%camera = 0
            knowledge%accelerometer_noise%sides = ONE_SIDED
            knowledge%accelerometer_delay = setup%accelerometer_delay
            knowledge%a_priori%sigma_magnetometer_bias = field_sigma(calibration)
            knowledge%a_priori%sigma_inertia = setup%inertia_sigma
            knowledge%a_priori%signs_known = signs_are_known(calibration)
            knowledge%a_priori%sigma_torque = 1e-4_dp       ! a line of torque is the arc's own, of any size
            first = max(1, last_not_after(calibration%current_time, max(span%start, from - AROUND)))
            if (calibration%current_time(first) < span%start) first = first + 1
            wanted = [(k, k=first, last_not_after(calibration%current_time, min(span%stop, to + AROUND)))]
            moment = spread(setup%rod_gain*setup%rod_sign, 2, size(wanted))*calibration%current(:, wanted)
            call new_moment_series(calibration%current_time(wanted) - zero, moment, moments, error, held)
            if (allocated(error)) return
            call take_measured_moments(moments, knowledge%rods)
            knowledge%rods%delay = setup%torque_delay
        end associate
        wanted = pack([(k, k=1, size(span%attitude_time))], &
                      span%attitude_time >= from - set%knowledge%star_camera_interval .and. &
                      span%attitude_time <= to + set%knowledge%star_camera_interval)
        set%magnetometer_time = span%attitude_time(wanted) - zero
        set%field = span%field(:, wanted)
        set%orbit_time = attitude - zero
        set%orbit_position = span%position(:, near)
        wanted = pack(wanted, span%attitude_time(wanted) >= from .and. span%attitude_time(wanted) <= to)
        call take_heads(span, axes, wanted, zero, from, to, set)
    end subroutine make_arc

    !> Which samples of the accelerometer lie so near a step of held currents that they may show either side of it, or its rate
    !> or not.
    pure function unsure(calibration, setup, times, anywhere)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        real(dp), intent(in) :: times(:)            !! s
        logical, intent(in) :: anywhere             !! Steps are, between two tags
        logical :: unsure(size(times))

        real(dp), parameter :: LEAST = 1            ! mA: a step that is one
        real(dp) :: distance(2)                     ! to the steps before and behind, s
        integer :: i, k

        unsure = .false.
        do i = 1, size(times)
            associate (t => times(i) - setup%accelerometer_delay - setup%torque_delay, tag => calibration%current_time)
                k = last_not_after(tag, t)
                if (k < 2 .or. k >= size(tag)) cycle
                distance = merge([t - tag(k), tag(k + 1) - t], 1.0_dp, &
                                 [maxval(abs(calibration%current(:, k) - calibration%current(:, k - 1))), &
                                  maxval(abs(calibration%current(:, k + 1) - calibration%current(:, k)))] > LEAST)
            end associate
            unsure(i) = any(distance < merge(1.0_dp, UNSURE_DELAY, anywhere) .or. abs(distance - SAMPLE/2) < UNSURE_DELAY)
        end do
    end function unsure

    !> Star cameras as head 1, and gyros, where their axes are known, as head 2: their angles from the first attitude on.
    subroutine take_heads(span, axes, wanted, zero, from, to, set)
        type(level1_span_t), intent(in) :: span
        type(gyro_axes_t), intent(in) :: axes
        integer, intent(in) :: wanted(:)            !! Samples of the cameras
        real(dp), intent(in) :: zero, from, to      !! s
        type(observation_set_t), intent(inout) :: set

        real(dp), allocatable :: gyro_time(:), angle(:, :), quaternion(:, :)
        integer :: i, k, n, m

        n = size(wanted)
        allocate (gyro_time(0))
        if (axes%known) call gyro_attitude(span, axes, max(from, span%attitude_time(wanted(1))), to, gyro_time, angle)
        m = size(gyro_time)
        allocate (quaternion(4, m))
        do k = 1, m
            if (k == 1) then
                quaternion(:, 1) = turned_by((gyro_time(1) - span%attitude_time(wanted(1)))*span%rate(:, wanted(1)), &
                                             span%quaternion(:, wanted(1)))
            else
                quaternion(:, k) = turned_by(angle(:, k) - angle(:, k - 1), quaternion(:, k - 1))
            end if
        end do
        allocate (set%star_camera_time(n + m), set%star_camera_head(n + m), set%quaternion(4, n + m))
        associate (cameras => span%attitude_time(wanted))
            associate (places => [(i + count(gyro_time < cameras(i)), i=1, n)])
                set%star_camera_head(places) = 1
                set%star_camera_time(places) = cameras - zero
                set%quaternion(:, places) = span%quaternion(:, wanted)
            end associate
            associate (places => [(k + count(cameras <= gyro_time(k)), k=1, m)])
                set%star_camera_head(places) = 2
                set%star_camera_time(places) = gyro_time - zero
                set%quaternion(:, places) = quaternion
            end associate
        end associate
    end subroutine take_heads

    !> The observation set of a span, of one that a firing cuts the longest piece. Fails when the span is not used, or no
    !> estimator could use the set.
    subroutine prepare_observations(calibration, estimate, number, observations, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(in) :: estimate
        integer, intent(in) :: number               !! Of the span
        type(observation_set_t), intent(out) :: observations
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t), allocatable :: arcs(:)
        type(gyro_axes_t) :: no_gyros
        type(torque_rods_t) :: rods, shown          ! as they act, and as samples show them
        type(moment_series_t) :: moments
        real(dp), allocatable :: time(:), moment(:, :), turns(:, :)
        real(dp) :: per_current(3), late, first, last, begin
        real(dp) :: weights(-HALF:HALF)
        integer, allocatable :: span_of(:)
        integer :: i, n

        if (.not. calibration%spans(number)%used) then
            call fail(error, 'span '//integer_text(number)//' is not usable: '//trim(calibration%spans(number)%reason))
            return
        end if
        call arcs_of_spans(calibration, calibration%setup, no_gyros, estimate%steps, arcs, span_of, error, with_unsure=.true.)
        if (.not. allocated(error) .and. all(span_of /= number)) call fail(error, 'span '//integer_text(number)//' is too short')
        if (allocated(error)) return
        observations = arcs(maxloc([(merge(arcs(i)%knowledge%duration, 0.0_dp, span_of(i) == number), i=1, size(arcs))], 1))
        if (allocated(observations%angular_acceleration)) deallocate (observations%angular_acceleration)
        associate (knowledge => observations%knowledge)
            knowledge%name = trim(knowledge%name)//' span '//integer_text(number)
            knowledge%camera = 1
            knowledge%inertia = estimate%inertia
            knowledge%star_camera_sigma = estimate%head_sigma
            knowledge%accelerometer_noise%level = 2*knowledge%accelerometer_interval*max(QUIETEST, estimate%solutions(1)%rms)**2
            knowledge%accelerometer_delay = estimate%accelerometer_delay
            knowledge%a_priori%sigma_magnetometer_bias = calibration%setup%field_sigma
            knowledge%a_priori%sigma_scale_factors = max(1e-6_dp, calibration%setup%scale_sigma)
            knowledge%a_priori%sigma_rod_gain = max(1e-4_dp, maxval(estimate%rods%gain_sigma))
            rods = knowledge%rods
            rods%gain = estimate%rods%gain
            rods%delay = estimate%rods%delay
            late = estimate%rods%delay + estimate%accelerometer_delay
            per_current = calibration%setup%rod_gain*calibration%setup%rod_sign
            if (estimate%solutions(1)%leakage == 'estimated') then
                do i = 1, size(observations%accelerometer_time)
                    associate (t => observations%accelerometer_time(i) - estimate%accelerometer_delay, &
                               half => knowledge%accelerometer_interval/2, one => estimate%solutions(1))
                        observations%acceleration(:, i) = observations%acceleration(:, i) - &
                            matmul(one%leak, currents(t)) - matmul(one%leak_rate, currents(t + half) - currents(t - half))/(2*half)
                    end associate
                end do
            end if
            if (estimate%steps) then    ! steps as the moments of the set have them: 0.2 s long
                shown = rods
                shown%delay = late
                turns = rod_accelerations(observations, shown, observations%accelerometer_time, .false.) - &
                        rod_accelerations(observations, shown, observations%accelerometer_time, .true.)
                do i = 1, size(turns, 2)
                    observations%acceleration(:, i) = observations%acceleration(:, i) + &
                                                      cross(turns(:, i), estimate%solutions(1)%offset)
                end do
            end if
            weights = mean_weights(HALF)
            call take_means(estimate, weights, observations, begin)
            associate (measured => knowledge%rods%measured%time, n_measured => size(knowledge%rods%measured%time))
                ! as far as the series goes on by itself: a spacing beyond its ends
                first = max(-MOMENT_MARGIN, late + 2*measured(1) - measured(2))
                last = min(begin + knowledge%duration + MOMENT_MARGIN, late + 2*measured(n_measured) - measured(n_measured - 1))
                n = floor((last - first)/MOMENT_STEP) + 1
                time = [(first + (i - 1)*MOMENT_STEP, i=1, n)]
            end associate
            allocate (moment(3, n))
            do i = 1, n
                moment(:, i) = smooth_moments(time(i))
            end do
            call new_moment_series(time - begin, moment, moments, error)
            if (allocated(error)) return
            call take_measured_moments(moments, knowledge%rods)
        end associate
        call check_observations(observations, error)

    contains

        !> The currents at a time, mA.
        pure function currents(time) result(current)
            real(dp), intent(in) :: time
            real(dp) :: current(3)

            current = rod_moments(rods, time, .true.)/(rods%gain*per_current)
        end function currents

        !> The moments as the means of samples show them; not where the series does not reach.
        pure function smooth_moments(time) result(moments)
            real(dp), intent(in) :: time
            real(dp) :: moments(3)

            real(dp) :: reach
            integer :: k

            associate (measured => observations%knowledge%rods%measured%time, &
                       interval => observations%knowledge%accelerometer_interval)
                reach = HALF*interval
                if (time - late - reach < measured(1) .or. time - late + reach > measured(size(measured))) then
                    moments = rod_moments(rods, time)
                    return
                end if
                moments = 0
                do k = -HALF, HALF
                    moments = moments + weights(k)*rod_moments(rods, time + k*interval)
                end do
            end associate
        end function smooth_moments
    end subroutine prepare_observations

    !> Means in place of the samples, with the noise that the same means of what the estimate leaves have. Where too many
    !> miss a sample, samples stay as they are.
    subroutine take_means(estimate, weights, observations, begin)
        type(level1_estimate_t), intent(in) :: estimate
        real(dp), intent(in) :: weights(-HALF:)
        type(observation_set_t), intent(inout) :: observations
        real(dp), intent(out) :: begin      !! Time 0 of the means, where the first one is, s from that of the samples

        integer, parameter :: OWN = 4       ! Parameters of an arc and axis that follow its means: a cubic
        real(dp), allocatable :: means(:, :), left(:, :)
        real(dp) :: squares(3)
        integer, allocatable :: centres(:), places(:), others(:)
        integer :: i, k, free

        begin = 0
        associate (interval => observations%knowledge%accelerometer_interval)
            call find_means(nint(observations%accelerometer_time/interval), observations%acceleration, weights, centres, means)
            squares = 0
            free = 0
            do i = 1, size(estimate%residuals)
                places = pack([(k, k=1, size(estimate%residuals(i)%kept))], estimate%residuals(i)%kept)
                call find_means(places, estimate%residuals(i)%linear(:, places), weights, others, left)
                squares = squares + sum(left**2, 2)
                free = free + max(0, size(left, 2) - OWN)
            end do
            if (size(centres) < FEWEST .or. free < FEWEST) return
            begin = centres(1)*interval
            observations%accelerometer_time = (centres - centres(1))*interval
            observations%acceleration = means
            observations%magnetometer_time = observations%magnetometer_time - begin
            observations%orbit_time = observations%orbit_time - begin
            observations%star_camera_time = observations%star_camera_time - begin
            observations%knowledge%epoch = utc_plus(observations%knowledge%epoch, begin)
            observations%knowledge%duration = observations%accelerometer_time(size(centres))
            places = pack([(i, i=1, size(observations%star_camera_time))], observations%star_camera_time >= 0 .and. &
                          observations%star_camera_time <= observations%knowledge%duration)
            observations%star_camera_time = observations%star_camera_time(places)
            observations%star_camera_head = observations%star_camera_head(places)
            observations%quaternion = observations%quaternion(:, places)
            observations%knowledge%accelerometer_noise%level = 2*interval*max(QUIETEST**2/APART, squares/free)
        end associate
    end subroutine take_means
end module gracecg_level1_to_observations
