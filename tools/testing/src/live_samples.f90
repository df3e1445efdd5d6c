!> An observation set as a live estimate takes it.
module live_samples
    use vocabulary
    use gracecg_spacecraft_torque_rods, only: dipole_moment
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_interpolation, only: interpolation_at, interpolated, cubic_interpolated
    use gracecg_estimation_live_estimate, only: live_sample_t
    implicit none
    private
    public :: sample_of

contains

    !> What an observation set has in interval k. Its magnetometer begins after a second: before, its first two samples are
    !> carried back, as `sequential` does.
    function sample_of(observations, k) result(sample)
        type(observation_set_t), intent(in) :: observations
        integer, intent(in) :: k
        type(live_sample_t) :: sample

        integer :: i, j

        associate (o => observations, h => observations%knowledge%accelerometer_interval)
            sample%time = k*h
            sample%position = cubic_interpolated(o%orbit_time, o%orbit_position, sample%time)
            do j = 0, 2
                sample%moment(:, j) = dipole_moment(o%knowledge%rods, sample%time - (2 - j)*h/2)
            end do
            i = findloc(abs(o%accelerometer_time - sample%time) < h/10, .true., 1)
            sample%has_acceleration = i > 0
            if (i > 0) sample%acceleration = o%acceleration(:, i)
            i = findloc(abs(o%magnetometer_time - sample%time) < h/10, .true., 1)
            sample%has_field = i > 0 .or. k == 0
            if (sample%has_field) sample%field = &
                interpolated(o%field, interpolation_at(o%magnetometer_time, sample%time, o%knowledge%magnetometer_interval))
            do i = 1, size(o%star_camera_time)
                if (abs(o%star_camera_time(i) - (sample%time - 0.4_dp*h)) >= h/2) cycle
                associate (head => o%star_camera_head(i))
                    sample%has_attitude(head) = .true.
                    sample%attitude_time(head) = o%star_camera_time(i)
                    sample%quaternion(:, head) = o%quaternion(:, i)
                end associate
            end do
        end associate
    end function sample_of
end module live_samples
