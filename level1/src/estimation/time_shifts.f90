!> Whether currents, attitude and accelerometer show the manoeuvre at the same time: tags of one of them that are seconds off (a
!> leap second, GPS time taken as UTC) look like wrong signs, axes or gains.
module gracecg_level1_time_shifts
    use gracecg_level1_basics
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_level1_held_currents, only: rod_accelerations
    use gracecg_level1_series, only: interpolate
    implicit none
    private
    public :: say_shift

    real(dp), parameter :: STEP = 0.5_dp        !! Of the times that are compared, s
    integer, parameter :: LAGS = 38             !! Shifts either way, in steps: 19 s
    integer, parameter :: MOST_ARCS = 8         !! So many tell
    real(dp), parameter :: AROUND = 2           !! Attitudes are differenced over so long either way, s
    real(dp), parameter :: ALIKE = 0.8_dp       !! Correlation of what is at the same time, chosen: sound days have 0.98 and more;
                                                !! heads alone (without SCA1B) have 0.5, and tell nothing
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

    !> By how much later than the torque of the rods the satellite turns as attitude or channels show.
    subroutine find_lag(arcs, by_channels, lag, clear)
        type(observation_set_t), intent(in) :: arcs(:)
        logical, intent(in) :: by_channels          !! Else by the attitude
        real(dp), intent(out) :: lag                !! s
        logical, intent(out) :: clear               !! They are alike with this lag, and less so with others

        real(dp) :: products(3, -LAGS:LAGS), seen(3, -LAGS:LAGS), acted(3, -LAGS:LAGS), correlation(-LAGS:LAGS)
        real(dp), allocatable :: torque(:, :), turned(:, :)
        integer :: i, k, n, shift

        products = 0
        seen = tiny(1.0_dp)
        acted = tiny(1.0_dp)
        do i = 1, min(size(arcs), MOST_ARCS)
            n = floor(arcs(i)%knowledge%duration/STEP)
            allocate (torque(3, 0:n), turned(3, 0:n))
            torque(:, :) = rod_accelerations(arcs(i), arcs(i)%knowledge%rods, [(k*STEP, k=0, n)], .true.)
            if (by_channels) then
                do k = 0, n
                    call interpolate(arcs(i)%accelerometer_time, arcs(i)%angular_acceleration, k*STEP, turned(:, k))
                end do
            else
                call difference_attitude(arcs(i), turned)
            end if
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
        lag = shift*STEP
        clear = correlation(shift) > ALIKE
    end subroutine find_lag

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
