!> A case moved along its nominal orbit: the same satellite, models and instruments, at a later time.
module gracecg_planning_moved_case
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_ROTATION_RATE, TWO_PI
    use gracecg_base_quaternion, only: normalised
    use gracecg_environment_time, only: utc_plus
    use gracecg_simulation_dynamics, only: STATE_SIZE, POSITION, VELOCITY, OMEGA, ATTITUDE
    use gracecg_simulation_case, only: case_t
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, states_from
    implicit none
    private
    public :: later_case

contains

    !> The case `time` seconds later on the orbit, with the nominal attitude. At time 0 it is the case
    !> itself. The density wave goes on; the manoeuvre stays, relative to the new epoch.
    function later_case(case, orbit, time) result(later)
        type(case_t), intent(in) :: case
        type(nominal_orbit_t), intent(in) :: orbit      !! Of this case
        real(dp), intent(in) :: time                    !! s, within the orbit
        type(case_t) :: later

        real(dp) :: state(STATE_SIZE, 0:0)

        later = case
        if (.not. time > 0) return
        state = states_from(orbit, time, 1.0_dp, 0)
        later%epoch = utc_plus(case%epoch, time)
        later%sidereal_angle = modulo(case%sidereal_angle + EARTH_ROTATION_RATE*time, TWO_PI)
        later%position = state(POSITION, 0)
        later%velocity = state(VELOCITY, 0)
        later%angular_velocity = state(OMEGA, 0)
        later%quaternion = normalised(state(ATTITUDE, 0))
        if (case%density_wave%period > 0) then
            later%density_wave%phase = modulo(case%density_wave%phase + &
                                              TWO_PI*modulo(time/case%density_wave%period, 1.0_dp), TWO_PI)
        end if
    end function later_case
end module gracecg_planning_moved_case
