!> What a manoeuvre does to the attitude, and the limits of it: angular velocity about any axis
!> (CSR-TM-00-01 section 4.1 allows 0.1 deg/s, for the star cameras), and the turn away from the
!> nominal attitude, which is the initial one turned on at the initial angular velocity.
module gracecg_simulation_limits
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_quaternion, only: quaternion_product, quaternion_from_axis_angle, rotation_angle_between
    use gracecg_spacecraft_motion_limits, only: motion_limits_t
    implicit none
    private
    public :: attitude_motion_t, follow_motion, exceeds_limits, check_motion

    !> The extremes of the attitude during an arc.
    type :: attitude_motion_t
        real(dp) :: rate = 0            !! Greatest angular velocity, rad/s
        real(dp) :: rate_time = 0       !! When, s
        real(dp) :: excursion = 0       !! Greatest turn away from the nominal attitude, rad
        real(dp) :: excursion_time = 0  !! When, s
    end type attitude_motion_t

contains

    !> The extremes of a rotation that is sampled at equal intervals, piece by piece: those so far, and those of some
    !> further epochs.
    pure subroutine follow_motion(interval, rate, attitude, from, angular_velocity, quaternion, motion)
        real(dp), intent(in) :: interval                    !! s
        real(dp), intent(in) :: rate(3), attitude(4)        !! At t = 0: body axes, rad/s; inertial to body
        integer, intent(in) :: from                         !! Number of the first of these epochs
        real(dp), intent(in) :: angular_velocity(:, from:)  !! (3, from:n), body axes, rad/s
        real(dp), intent(in) :: quaternion(:, from:)        !! (4, from:n), inertial to body, scalar last
        type(attitude_motion_t), intent(inout) :: motion

        real(dp) :: speed, turn, axis(3), nominal_speed
        integer :: k

        nominal_speed = norm2(rate)
        axis = [1, 0, 0]
        if (nominal_speed > 0) axis = rate/nominal_speed
        do k = from, ubound(angular_velocity, 2)
            speed = norm2(angular_velocity(:, k))
            if (.not. speed <= motion%rate) then
                motion%rate = speed
                motion%rate_time = k*interval
            end if
            turn = rotation_angle_between(quaternion(:, k)/norm2(quaternion(:, k)), &
                                          quaternion_product(quaternion_from_axis_angle(axis, &
                                                             nominal_speed*k*interval), attitude))
            if (.not. turn <= motion%excursion) then
                motion%excursion = turn
                motion%excursion_time = k*interval
            end if
        end do
    end subroutine follow_motion

    !> Does a motion go beyond the limits of a satellite?
    pure logical function exceeds_limits(limits, motion)
        type(motion_limits_t), intent(in) :: limits
        type(attitude_motion_t), intent(in) :: motion

        exceeds_limits = .not. (motion%rate <= limits%rate .and. motion%excursion <= limits%pointing)
    end function exceeds_limits

    !> Fails when a motion goes beyond the limits of a satellite.
    subroutine check_motion(limits, motion, error)
        type(motion_limits_t), intent(in) :: limits
        type(attitude_motion_t), intent(in) :: motion
        type(error_t), allocatable, intent(out) :: error

        if (.not. motion%rate <= limits%rate) then
            call fail(error, 'limits: the manoeuvre turns the satellite at '// &
                      number_text(motion%rate/DEGREE)//' deg/s at t = '//number_text(motion%rate_time)// &
                      ' s; at most '//number_text(limits%rate/DEGREE)//' deg/s is allowed (rate_deg_s '// &
                      'of the group &limits): take a smaller amplitude, a higher frequency or a taper')
        else if (.not. motion%excursion <= limits%pointing) then
            call fail(error, 'limits: the manoeuvre turns the satellite '// &
                      number_text(motion%excursion/DEGREE)//' deg away from its attitude, at t = '// &
                      number_text(motion%excursion_time)//' s; at most '// &
                      number_text(limits%pointing/DEGREE)//' deg is allowed (pointing_deg of the '// &
                      'group &limits): take a smaller amplitude, a higher frequency or a taper')
        end if
    end subroutine check_motion
end module gracecg_simulation_limits
