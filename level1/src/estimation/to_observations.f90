!> Spans of a calibration from Level-1 files as observation sets, an arc each: SRF for body axes, times from the arc's first
!> sample of the accelerometer, the currents of the rods as measured moments, the gyros as head 2.
module gracecg_level1_to_observations
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_coloured_noise, only: ONE_SIDED
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_error, only: error_t, add_context
    use gracecg_base_statistics, only: median_of, sort
    use gracecg_base_text, only: integer_text
    use gracecg_environment_time, only: utc_of_gps
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series
    use gracecg_spacecraft_torque_rods, only: take_measured_moments
    use gracecg_estimation_physical_model, only: turned_by
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t, field_sigma
    use gracecg_level1_gyros, only: gyro_axes_t, gyro_attitude
    use gracecg_level1_setup, only: level1_setup_t
    implicit none
    private
    public :: arcs_of_spans, SAMPLE

    !> Of an arc, s: chosen. It has attitude, rate, torque and forces of its own, each with polynomials, which in a piece
    !> of less than two cycles of the rods (6 to 12 s each, usually) leave hardly anything to the offset
    real(dp), parameter :: SHORTEST = 15
    !> Left out about a firing, s: as much before it as by `veto_before`; behind it less than by `veto_after`, for attitude
    !> and rate begin anew there
    real(dp), parameter :: BEFORE = 0.3_dp, AFTER = 1.0_dp
    real(dp), parameter :: SAMPLE = 0.1_dp          !! Of the accelerometer, nominally, s
    real(dp), parameter :: UNSURE_DELAY = 4e-3_dp   !! By which delays may be off, s: two or three of their sigmas
    real(dp), parameter :: ENDS = 0.3_dp        !! Left out at the ends of a span, where currents may jump, s: some samples

contains

    !> The arcs of all spans that are used; a firing inside, or the edge of the Earth's shadow, cuts a span in two. Fails as
    !> moments of rods do.
    subroutine arcs_of_spans(calibration, setup, axes, held, sets, span_of, error, with_unsure)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(gyro_axes_t), intent(in) :: axes       !! Of the gyros
        logical, intent(in) :: held                 !! The currents are, from tag to tag
        type(observation_set_t), allocatable, intent(out) :: sets(:)
        integer, allocatable, intent(out) :: span_of(:)     !! The span of each arc
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: with_unsure        !! Samples near steps of held currents stay; absent: they do not

        type(observation_set_t) :: set
        real(dp), allocatable :: cuts(:)
        logical :: unsure_stay
        integer :: i, k

        unsure_stay = .not. held
        if (present(with_unsure)) unsure_stay = unsure_stay .or. with_unsure
        allocate (sets(0), span_of(0))
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (.not. span%used) cycle
                cuts = [span%start + ENDS - AFTER, pack(span%firings, span%firings > span%start .and. &
                                                        span%firings < span%stop), span%shadow_edges, span%stop - ENDS + BEFORE]
                call sort(cuts)
                do k = 1, size(cuts) - 1
                    if (cuts(k + 1) - cuts(k) < SHORTEST) cycle
                    call make_arc(calibration, setup, axes, held, unsure_stay, span, cuts(k) + AFTER, cuts(k + 1) - BEFORE, &
                                  set, error)
                    call add_context(error, 'span '//integer_text(i))
                    if (allocated(error)) return
                    sets = [sets, set]
                    span_of = [span_of, i]
                end do
            end associate
        end do
    end subroutine arcs_of_spans

    subroutine make_arc(calibration, setup, axes, held, unsure_stay, span, from, to, set, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(gyro_axes_t), intent(in) :: axes
        logical, intent(in) :: held, unsure_stay
        type(level1_span_t), intent(in) :: span
        real(dp), intent(in) :: from, to            !! s from the epoch of the calibration
        type(observation_set_t), intent(out) :: set
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: NO_TURN(4) = [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
        type(moment_series_t) :: moments
        real(dp), allocatable :: times(:), moment(:, :)
        integer, allocatable :: wanted(:)
        real(dp) :: zero, interval
        integer :: k

        wanted = pack([(k, k=1, size(span%time))], span%time >= from .and. span%time <= to)
        if (.not. unsure_stay) wanted = pack(wanted, .not. unsure(calibration, setup, span%time(wanted)))
        times = span%time(wanted)
        zero = times(1)
        interval = median_of(times(2:) - times(:size(times) - 1))
        interval = (times(size(times)) - zero)/nint((times(size(times)) - zero)/interval)
        set%accelerometer_time = nint((times - zero)/interval)*interval
        set%acceleration = span%linear(:, wanted)
        if (calibration%has_angular) set%angular_acceleration = span%angular(:, wanted)
        associate (knowledge => set%knowledge)
            knowledge%name = 'GRACE-'//calibration%satellite//' '//calibration%date
            knowledge%epoch = utc_of_gps(calibration%epoch + floor(zero, i8), zero - floor(zero))
            knowledge%duration = set%accelerometer_time(size(times))
            knowledge%mass = setup%mass
            knowledge%inertia = setup%inertia
            knowledge%accelerometer_interval = interval
            knowledge%star_camera_interval = median_of(span%attitude_time(2:) - span%attitude_time(:size(span%attitude_time) - 1))
            knowledge%magnetometer_interval = maxval(span%attitude_time(2:) - span%attitude_time(:size(span%attitude_time) - 1))
            knowledge%mounting = spread(NO_TURN, 2, size(knowledge%mounting, 2))
            knowledge%camera = 0
            knowledge%accelerometer_noise%sides = ONE_SIDED
            knowledge%accelerometer_delay = setup%accelerometer_delay
            knowledge%a_priori%sigma_magnetometer_bias = field_sigma(calibration, setup)
            knowledge%a_priori%sigma_inertia = setup%inertia_sigma
            knowledge%a_priori%signs_known = setup%signs_known .or. all(calibration%follows == 1)
            knowledge%a_priori%sigma_torque = 1e-4_dp       ! a line of torque is the arc's own, of any size
            wanted = pack([(k, k=1, size(calibration%current_time))], &
                          calibration%current_time >= span%start .and. calibration%current_time <= span%stop)
            moment = spread(setup%rod_gain*setup%rod_sign, 2, size(wanted))*calibration%current(:, wanted)
            call new_moment_series(moments, calibration%current_time(wanted) - zero, moment, error, held)
            if (allocated(error)) return
            call take_measured_moments(moments, knowledge%rods)
            knowledge%rods%delay = setup%torque_delay
        end associate
        wanted = pack([(k, k=1, size(span%attitude_time))], &
                      span%attitude_time >= from - set%knowledge%star_camera_interval .and. &
                      span%attitude_time <= to + set%knowledge%star_camera_interval)
        set%magnetometer_time = span%attitude_time(wanted) - zero
        set%field = span%field(:, wanted)
        set%orbit_time = span%attitude_time - zero
        set%orbit_position = span%position
        wanted = pack(wanted, span%attitude_time(wanted) >= from .and. span%attitude_time(wanted) <= to)
        call take_heads(span, axes, wanted, zero, from, to, set)
    end subroutine make_arc

    !> Which samples of the accelerometer lie so near a step of held currents that they may show either side of it, or its rate
    !> or not.
    pure function unsure(calibration, setup, times)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        real(dp), intent(in) :: times(:)            !! s
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
            unsure(i) = any(distance < UNSURE_DELAY .or. abs(distance - SAMPLE/2) < UNSURE_DELAY)
        end do
    end function unsure

    !> Star cameras as head 1, and gyros, where their axes are known, as head 2: their angles from the first attitude on.
    subroutine take_heads(span, axes, wanted, zero, from, to, set)
        type(level1_span_t), intent(in) :: span
        type(gyro_axes_t), intent(in) :: axes
        integer, intent(in) :: wanted(:)            !! Samples of the cameras
        real(dp), intent(in) :: zero, from, to      !! s
        type(observation_set_t), intent(inout) :: set

        real(dp), allocatable :: gyro_time(:), angle(:, :), quaternion(:, :), q(:, :), time(:)
        integer, allocatable :: inside(:), head(:)
        integer :: i, k, n, m

        n = size(wanted)
        m = 0
        if (axes%known) then
            call gyro_attitude(span, axes, gyro_time, angle)
            inside = pack([(k, k=1, size(gyro_time))], gyro_time >= max(from, span%attitude_time(wanted(1))) .and. gyro_time <= to)
            m = size(inside)
        end if
        allocate (quaternion(4, m))
        do k = 1, m
            if (k == 1) then
                quaternion(:, 1) = turned_by((gyro_time(inside(1)) - span%attitude_time(wanted(1)))*span%rate(:, wanted(1)), &
                                             span%quaternion(:, wanted(1)))
            else
                quaternion(:, k) = turned_by(angle(:, inside(k)) - angle(:, inside(k - 1)), quaternion(:, k - 1))
            end if
        end do
        allocate (time(n + m), head(n + m), q(4, n + m))
        i = 1
        k = 1
        do while (i + k - 1 <= n + m)
            if (k > m) then
                head(i + k - 1) = 1
            else if (i > n) then
                head(i + k - 1) = 2
            else
                head(i + k - 1) = merge(1, 2, span%attitude_time(wanted(i)) <= gyro_time(inside(k)))
            end if
            if (head(i + k - 1) == 1) then
                time(i + k - 1) = span%attitude_time(wanted(i)) - zero
                q(:, i + k - 1) = span%quaternion(:, wanted(i))
                i = i + 1
            else
                time(i + k - 1) = gyro_time(inside(k)) - zero
                q(:, i + k - 1) = quaternion(:, k)
                k = k + 1
            end if
        end do
        set%star_camera_time = time
        set%star_camera_head = head
        set%quaternion = q
    end subroutine take_heads
end module gracecg_level1_to_observations
