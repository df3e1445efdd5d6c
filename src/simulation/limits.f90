!> What a manoeuvre does to the attitude, and the limits of it: angular velocity about any axis
!> (CSR-TM-00-01 section 4.1 allows 0.1 deg/s, for the star cameras), and the turn away from the
!> nominal attitude, which is the initial one turned on at the initial angular velocity.
module gracecg_simulation_limits
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_quaternion, only: quaternion_product, quaternion_from_axis_angle, rotation_angle_between
    use gracecg_spacecraft_motion_limits, only: motion_limits_t
    use gracecg_spacecraft_torque_rods, only: moves_rods
    use gracecg_simulation_dynamics, only: OMEGA, ATTITUDE
    use gracecg_simulation_arc, only: truth_arc_t
    use gracecg_simulation_case, only: case_t
    implicit none
    private
    public :: attitude_motion_t, attitude_motion, exceeds_limits, check_motion, check_manoeuvre_limits

    !> The extremes of the attitude during an arc.
    type :: attitude_motion_t
        real(dp) :: rate = 0            !! Greatest angular velocity, rad/s
        real(dp) :: rate_time = 0       !! When, s
        real(dp) :: excursion = 0       !! Greatest turn away from the nominal attitude, rad
        real(dp) :: excursion_time = 0  !! When, s
    end type attitude_motion_t

contains

    !> The extremes of a rotation that is sampled at equal intervals.
    pure function attitude_motion(interval, angular_velocity, quaternion) result(motion)
        real(dp), intent(in) :: interval                !! s
        real(dp), intent(in) :: angular_velocity(:, 0:) !! (3, 0:n), body axes, rad/s
        real(dp), intent(in) :: quaternion(:, 0:)       !! (4, 0:n), inertial to body, scalar last
        type(attitude_motion_t) :: motion

        real(dp) :: speed, turn, axis(3), nominal_speed
        integer :: k

        nominal_speed = norm2(angular_velocity(:, 0))
        axis = [1, 0, 0]
        if (nominal_speed > 0) axis = angular_velocity(:, 0)/nominal_speed
        do k = 0, ubound(angular_velocity, 2)
            speed = norm2(angular_velocity(:, k))
            if (.not. speed <= motion%rate) then
                motion%rate = speed
                motion%rate_time = k*interval
            end if
            turn = rotation_angle_between(quaternion(:, k)/norm2(quaternion(:, k)), &
                                          quaternion_product(quaternion_from_axis_angle(axis, &
                                                             nominal_speed*k*interval), quaternion(:, 0)))
            if (.not. turn <= motion%excursion) then
                motion%excursion = turn
                motion%excursion_time = k*interval
            end if
        end do
    end function attitude_motion

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

    !> Fails when the manoeuvre of a case goes beyond its limits on an arc. An arc without a manoeuvre
    !> passes.
    subroutine check_manoeuvre_limits(case, arc, error)
        type(case_t), intent(in) :: case
        type(truth_arc_t), intent(in) :: arc
        type(error_t), allocatable, intent(out) :: error

        if (.not. moves_rods(case%satellite%rods, case%duration)) return
        call check_motion(case%limits, &
                          attitude_motion(arc%interval, arc%state(OMEGA, :), arc%state(ATTITUDE, :)), error)
    end subroutine check_manoeuvre_limits
end module gracecg_simulation_limits
