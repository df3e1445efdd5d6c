!> One span of a calibration from Level-1 files as an ordinary observation set: GPS time, SRF for body axes, the rods as they
!> were measured, with gains and delays by the estimate, accelerations without the rods' leakage where the spans together
!> determine it.
!>
!> The noise of these accelerometers rises with frequency, which level and corner cannot say: the samples are means
!> about every tenth epoch, whose noise is nearly white (docs/theory.md, 18.9), and the moments are smoothed likewise.
module gracecg_level1_preparation
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: integer_text
    use gracecg_base_vectors, only: cross
    use gracecg_environment_time, only: utc_plus
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, take_measured_moments, rod_moments
    use gracecg_level1_setup, only: level1_setup_t, QUIETEST
    use gracecg_observations_observation_set, only: observation_set_t, check_observations
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_gyros, only: gyro_axes_t
    use gracecg_level1_held_currents, only: rod_acceleration
    use gracecg_level1_means, only: mean_weights, find_means, APART
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_to_observations, only: arcs_of_spans
    implicit none
    private
    public :: prepare_observations

    real(dp), parameter :: MOMENT_STEP = 0.1_dp     !! Of the moments, s
    real(dp), parameter :: MOMENT_MARGIN = 1        !! Before and behind the arc, s
    integer, parameter :: HALF = 6                  !! A mean has so many samples on either side: less than apart, their noise is
                                                    !! independent
    integer, parameter :: FEWEST = 30               !! Means, or the samples stay as they are

contains

    !> The observation set of a span, of one that a firing cuts the longest piece. Fails when the span is not used, or no
    !> estimator could use the set.
    subroutine prepare_observations(calibration, setup, estimate, number, observations, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(level1_estimate_t), intent(in) :: estimate
        integer, intent(in) :: number               !! Of the span
        type(observation_set_t), intent(out) :: observations
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t), allocatable :: arcs(:)
        type(gyro_axes_t) :: no_gyros
        type(torque_rods_t) :: rods, shown          ! as they act, and as samples show them
        type(moment_series_t) :: moments
        real(dp), allocatable :: time(:), moment(:, :)
        real(dp) :: per_current(3), late, first, last, begin
        real(dp) :: weights(-HALF:HALF)
        integer, allocatable :: span_of(:)
        integer :: i, n

        if (.not. calibration%spans(number)%used) then
            call fail(error, 'span '//integer_text(number)//' is not usable: '//trim(calibration%spans(number)%reason))
            return
        end if
        call arcs_of_spans(calibration, setup, no_gyros, estimate%steps, arcs, span_of, error, with_unsure=.true.)
        if (.not. allocated(error) .and. all(span_of /= number)) call fail(error, 'span '//integer_text(number)//' is too short')
        if (allocated(error)) return
        observations = arcs(maxloc([(merge(arcs(i)%knowledge%duration, 0.0_dp, span_of(i) == number), i=1, size(arcs))], 1))
        if (allocated(observations%angular_acceleration)) deallocate (observations%angular_acceleration)
        associate (knowledge => observations%knowledge)
            knowledge%name = trim(knowledge%name)//' span '//integer_text(number)
            knowledge%camera = 1
            knowledge%star_camera_sigma = estimate%head_sigma
            knowledge%accelerometer_noise%level = 2*knowledge%accelerometer_interval*max(QUIETEST, estimate%solutions(1)%rms)**2
            knowledge%accelerometer_delay = estimate%accelerometer_delay
            knowledge%a_priori%sigma_magnetometer_bias = setup%field_sigma
            knowledge%a_priori%sigma_scale_factors = max(1e-6_dp, setup%scale_sigma)
            knowledge%a_priori%sigma_rod_gain = max(1e-4_dp, maxval(estimate%rods%gain_sigma))
            rods = knowledge%rods
            rods%gain = estimate%rods%gain
            rods%delay = estimate%rods%delay
            late = estimate%rods%delay + estimate%accelerometer_delay
            per_current = setup%rod_gain*setup%rod_sign
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
                do i = 1, size(observations%accelerometer_time)
                    associate (t => observations%accelerometer_time(i))
                        observations%acceleration(:, i) = observations%acceleration(:, i) + &
                            cross(rod_acceleration(observations, shown, t, .false.) - &
                                  rod_acceleration(observations, shown, t, .true.), estimate%solutions(1)%offset)
                    end associate
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
            call new_moment_series(moments, time - begin, moment, error)
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
end module gracecg_level1_preparation
