!> The planner for one place of a case's orbit: what the command `design` does with --at and --map, in two
!> calls on cases.
module gracecg_planning_planner
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail, add_context, number_text
    use gracecg_base_quaternion, only: normalised
    use gracecg_spacecraft_torque_rods, only: take_manoeuvre, check_rod_sampling
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: REPORT_CASE_NAMES
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_planning_calibration, only: calibration_t
    use gracecg_planning_moved_case, only: later_case
    use gracecg_planning_site, only: accelerometer_view_t, new_accelerometer_view, manoeuvre_site_t, &
        new_manoeuvre_site
    use gracecg_planning_map, only: map_point_t, map_manoeuvre
    use gracecg_planning_design, only: design_settings_t, manoeuvre_design_t, design_manoeuvre
    implicit none
    private
    public :: plan_manoeuvre, take_design, map_case, moved_case, options_there
    public :: PLANNING_STEP, SHORTEST_ARC, LONGEST_ARC, MOST_REVOLUTIONS

    real(dp), parameter :: PLANNING_STEP = 10       !! Between the orbit's samples, s
    real(dp), parameter :: SHORTEST_ARC = 10        !! s
    real(dp), parameter :: LONGEST_ARC = 600        !! s
    integer, parameter :: MOST_REVOLUTIONS = 150    !! Of a map
    real(dp), parameter :: GUESS_DIGIT = 1e-3_dp
    !! To which an operator's guess of the attitude is rounded: the built-in cases have as many digits

contains

    !> The best manoeuvre for a case's satellite on an arc of the case's duration, within the limits of its
    !> setup; and the calibration that flies it, `time` seconds later on the orbit.
    !>
    !> Fails for an arc shorter than SHORTEST_ARC or longer than LONGEST_ARC, for a time outside of one
    !> revolution, as design_manoeuvre does, and when a limit is not positive.
    subroutine plan_manoeuvre(calibration, time, settings, planned, design, error)
        type(calibration_t), intent(in) :: calibration      !! Its manoeuvre does not matter
        real(dp), intent(in) :: time                        !! Of the start, s from the case's epoch
        type(design_settings_t), intent(in) :: settings
        type(calibration_t), intent(out) :: planned         !! Its name ends with -design
        type(manoeuvre_design_t), intent(out) :: design
        type(error_t), allocatable, intent(out) :: error

        type(nominal_orbit_t) :: orbit
        type(accelerometer_view_t) :: view
        type(manoeuvre_site_t) :: site(1)

        associate (case => calibration%case)
            call check_limits(case, error)
            if (.not. allocated(error)) call new_accelerometer_view(case, view, error)
            if (.not. allocated(error)) call new_nominal_orbit(case, orbit, error, interval=PLANNING_STEP)
            if (.not. allocated(error)) call new_manoeuvre_site(view, orbit, time, site(1), error)
            if (.not. allocated(error)) call design_manoeuvre(view, site, settings, design, error)
            call add_context(error, 'case '//trim(case%name))
            if (allocated(error)) return
            planned%case = moved_case(case, orbit, time, any(REPORT_CASE_NAMES == case%name))
            planned%options = calibration%options
            if (time > 0) planned%options = options_there(calibration%options, planned%case)
        end associate
        call take_design(design, planned)
    end subroutine plan_manoeuvre

    !> Makes a calibration fly a designed manoeuvre; its name then ends with -design. `optimal` is asked to
    !> estimate scale factors and magnetometer bias, too: the noise of such a calibration is so small that they,
    !> in proportion to the offset, would make the largest errors and be missing in its sigmas.
    subroutine take_design(design, calibration)
        type(manoeuvre_design_t), intent(in) :: design
        type(calibration_t), intent(inout) :: calibration

        call take_manoeuvre(design%rods, calibration%case%satellite%rods)
        calibration%case%name = trim(calibration%case%name)//'-design'
        calibration%options%optimal%estimate_scale_factors = .true.
        calibration%options%optimal%estimate_magnetometer_bias = .true.
    end subroutine take_design

    subroutine check_limits(case, error)
        type(case_t), intent(in) :: case
        type(error_t), allocatable, intent(out) :: error

        if (.not. (case%duration >= SHORTEST_ARC .and. case%duration <= LONGEST_ARC)) then
            call fail(error, 'duration = '//number_text(case%duration)//' s: a manoeuvre lasts from '// &
                      number_text(SHORTEST_ARC)//' to '//number_text(LONGEST_ARC)//' s')
        else if (.not. (case%limits%rate > 0 .and. case%limits%pointing > 0)) then
            call fail(error, 'the limits of rate and pointing are '//number_text(case%limits%rate)// &
                      ' rad/s and '//number_text(case%limits%pointing)//' rad: both have to be positive')
        end if
    end subroutine check_limits

    !> A case's manoeuvre at places along its orbit, as the command `design --manoeuvre CASE --map` has it.
    !>
    !> Fails for times that are negative or after MOST_REVOLUTIONS, when the samples cannot follow the
    !> manoeuvre, and as map_manoeuvre does.
    subroutine map_case(case, times, threads, points, error)
        type(case_t), intent(in) :: case
        real(dp), intent(in) :: times(:)                    !! Of the start, s from the case's epoch
        integer, intent(in) :: threads                      !! 1 and more
        type(map_point_t), allocatable, intent(out) :: points(:)
        type(error_t), allocatable, intent(out) :: error

        type(nominal_orbit_t) :: orbit
        type(accelerometer_view_t) :: view
        real(dp) :: revolutions

        if (size(times) == 0) then
            allocate (points(0))
            return
        end if
        revolutions = maxval(abs(times))*norm2(case%angular_velocity)/TWO_PI
        if (.not. revolutions <= MOST_REVOLUTIONS) then
            call fail(error, 'the latest time of the map, '//number_text(maxval(abs(times)))//' s, is more '// &
                      'than '//number_text(real(MOST_REVOLUTIONS, dp))//' revolutions after the epoch')
        else
            call check_limits(case, error)
        end if
        if (.not. allocated(error)) &
            call check_rod_sampling(case%satellite%rods, case%satellite%accelerometer%sampling_interval, error)
        if (.not. allocated(error)) call new_accelerometer_view(case, view, error)
        if (.not. allocated(error)) &
            call new_nominal_orbit(case, orbit, error, max(1, ceiling(revolutions)), PLANNING_STEP)
        if (.not. allocated(error)) &
            call map_manoeuvre(view, orbit, times, case%satellite%rods, threads, points, error)
        call add_context(error, 'case '//trim(case%name))
    end subroutine map_case

    !> The case `time` seconds later on its orbit. A built-in case away from its own place takes the
    !> wind of the table, as the built-in cases 2 and 3 do: the constant one was fitted to case 1.
    function moved_case(case, orbit, time, built_in) result(moved)
        type(case_t), intent(in) :: case
        type(nominal_orbit_t), intent(in) :: orbit      !! Of this case
        real(dp), intent(in) :: time                    !! s, within the orbit
        logical, intent(in) :: built_in                 !! The orbit is that of a built-in case
        type(case_t) :: moved

        moved = later_case(case, orbit, time)
        if (built_in .and. time > 0) moved%wind_model = 'hwm93'
    end function moved_case

    !> The options for a moved case: a first guess of the attitude that is given is turned along.
    pure function options_there(options, moved) result(there)
        type(estimation_options_t), intent(in) :: options
        type(case_t), intent(in) :: moved
        type(estimation_options_t) :: there

        there = options
        if (all(abs(options%guess_quaternion) <= 0)) return
        there%guess_quaternion = normalised(GUESS_DIGIT*anint(moved%quaternion/GUESS_DIGIT))
    end function options_there
end module gracecg_planning_planner
