!> A case moved along its nominal orbit: the same satellite, models and instruments, at a later time.
module gracecg_planning_moved_case
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_ROTATION_RATE, TWO_PI
    use gracecg_base_error, only: error_t
    use gracecg_base_quaternion, only: normalised
    use gracecg_environment_time, only: utc_plus
    use gracecg_simulation_dynamics, only: STATE_SIZE, POSITION, VELOCITY, OMEGA, ATTITUDE
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, states_from
    implicit none
    private
    public :: moved_case, moved_calibration

    real(dp), parameter :: GUESS_DIGIT = 1e-3_dp
    !! To which an operator's guess of the attitude is rounded: the built-in cases have as many digits

contains

    !> The case that starts `time` seconds later on the orbit, with the nominal attitude. At time 0 it is the
    !> case itself. The density wave goes on; the manoeuvre stays, relative to the new epoch. The constant wind
    !> of a built-in case was fitted to its place: away from it the wind is that of the table, as in the
    !> built-in cases 2 and 3.
    function moved_case(case, orbit, time) result(moved)
        type(case_t), intent(in) :: case
        type(nominal_orbit_t), intent(in) :: orbit      !! Of this case
        real(dp), intent(in) :: time                    !! s, within the orbit
        type(case_t) :: moved

        real(dp) :: state(STATE_SIZE, 0:0)

        moved = case
        if (.not. time > 0) return
        state = states_from(orbit, time, 1.0_dp, 0)
        moved%epoch = utc_plus(case%epoch, time)
        moved%sidereal_angle = modulo(case%sidereal_angle + EARTH_ROTATION_RATE*time, TWO_PI)
        moved%earth_parameters%ut1_minus_utc = case%earth_parameters%ut1_minus_utc + case%earth_parameters%ut1_rate*time
        moved%position = state(POSITION, 0)
        moved%velocity = state(VELOCITY, 0)
        moved%angular_velocity = state(OMEGA, 0)
        moved%quaternion = normalised(state(ATTITUDE, 0))
        if (case%density_wave%period > 0) then
            moved%density_wave%phase = modulo(case%density_wave%phase + &
                                              TWO_PI*modulo(time/case%density_wave%period, 1.0_dp), TWO_PI)
        end if
        if (has_built_in_wind(case)) moved%wind_model = 'hwm93'
    end function moved_case

    !> The calibration of a moved case: a first guess of the attitude that is given is turned along.
    function moved_calibration(calibration, orbit, time) result(moved)
        type(calibration_t), intent(in) :: calibration
        type(nominal_orbit_t), intent(in) :: orbit      !! Of its case
        real(dp), intent(in) :: time                    !! s, within the orbit
        type(calibration_t) :: moved

        moved%case = moved_case(calibration%case, orbit, time)
        moved%options = calibration%options
        if (.not. time > 0 .or. all(abs(moved%options%guess_quaternion) <= 0)) return
        moved%options%guess_quaternion = normalised(GUESS_DIGIT*anint(moved%case%quaternion/GUESS_DIGIT))
    end function moved_calibration

    !> Is the wind that of the built-in case of this name?
    logical function has_built_in_wind(case) result(same)
        type(case_t), intent(in) :: case

        type(case_t) :: built_in
        type(error_t), allocatable :: failure

        same = any(REPORT_CASE_NAMES == case%name)
        if (same) call report_case(trim(case%name), built_in, failure)
        if (same .and. .not. allocated(failure)) &
            same = case%wind_model == built_in%wind_model .and. &
                   .not. norm2([case%wind_east - built_in%wind_east, case%wind_north - built_in%wind_north]) > 0
    end function has_built_in_wind
end module gracecg_planning_moved_case
