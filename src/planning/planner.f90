!> The plan of a calibration, the one recipe of the command `design`, the report's page and the interfaces to
!> C and Fortran 77: arc and nominal orbit of a case, the places where the manoeuvre is to be good, the
!> manoeuvre, and the calibration that flies it.
module gracecg_planning_planner
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI, EARTH_ROTATION_RATE, MILLIMETRE
    use gracecg_base_error, only: error_t, fail, add_context, number_text
    use gracecg_base_progress, only: progress_t
    use gracecg_spacecraft_torque_rods, only: take_manoeuvre, check_rod_sampling, torque_rods_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_limits, only: check_motion, exceeds_limits
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit, refuse_unplannable, last_time, &
        states_from, MOST_REVOLUTIONS
    use gracecg_planning_calibration, only: calibration_t, case_of_observations
    use gracecg_planning_site, only: planned_arc_t, new_planned_arc, manoeuvre_site_t, manoeuvre_quality_t, &
        evaluate_manoeuvre
    use gracecg_planning_scan, only: map_point_t, map_manoeuvre, new_manoeuvre_sites
    use gracecg_planning_candidates, only: design_settings_t, check_design_settings, pattern_567, usual_amplitude, &
        usual_shares
    use gracecg_planning_design, only: manoeuvre_design_t, design_manoeuvre, judge_manoeuvre, choose_place
    use gracecg_base_quaternion, only: normalised
    use gracecg_environment_time, only: utc_plus, utc_text
    use gracecg_simulation_dynamics, only: STATE_SIZE, POSITION, VELOCITY, OMEGA, ATTITUDE
    use gracecg_simulation_report_cases, only: report_case, REPORT_CASE_NAMES
    use gracecg_base_text, only: rounded_text, integer_text
    use gracecg_observations_observation_set, only: observation_set_t
    implicit none
    private
    public :: plan_request_t, AT_TIME, ANYWHERE, EVERYWHERE, plan_t, prepare_plan, find_manoeuvre, times_along, &
        planned_calibration, take_design, plan_manoeuvre, map_case, SHORTEST_ARC, LONGEST_ARC, &
        moved_case, moved_calibration, say_next_manoeuvre

    real(dp), parameter :: ORBIT_STEP = 10          !! Between the orbit's samples, s
    real(dp), parameter :: ANYWHERE_STEP = 100      !! Between the places to choose from, s
    real(dp), parameter :: EVERYWHERE_STEP = 240    !! Between the places of a manoeuvre for all, s
    real(dp), parameter :: SHORTEST_ARC = 10        !! s
    real(dp), parameter :: LONGEST_ARC = 600        !! s

    integer, parameter :: AT_TIME = 1, ANYWHERE = 2, EVERYWHERE = 3
    !! Where a manoeuvre is to be good: at a given time; at the place of the orbit that is best; at all places

    !> What a plan is asked for.
    type :: plan_request_t
        integer :: place = AT_TIME          !! Or ANYWHERE, EVERYWHERE
        real(dp) :: time = 0                !! Of the start unless ANYWHERE, s from the case's epoch
        integer :: revolutions = 1          !! Of the orbit, for ANYWHERE, EVERYWHERE and maps
        logical :: search = .true.          !! Else the case's own manoeuvre is judged, AT_TIME
        type(design_settings_t) :: settings = design_settings_t()    !! Of the search
    end type plan_request_t

    !> A plan, as far as it has come.
    type :: plan_t
        type(calibration_t) :: calibration  !! At its epoch; in the end with the arc and manoeuvre planned
        type(planned_arc_t) :: arc          !! Its samples, noise and limits
        type(nominal_orbit_t) :: orbit
        !! Nominal orbit of the case
        type(manoeuvre_site_t), allocatable :: sites(:)     !! Where the manoeuvre is to be good
        real(dp) :: time = 0                !! Of the start, s from the case's epoch
        type(manoeuvre_design_t) :: design  !! The manoeuvre, judged at all sites
    end type plan_t

    real(dp), parameter :: GUESS_DIGIT = 1e-3_dp
    !! To which an operator's guess of the attitude is rounded: the built-in cases have as many digits

contains

    !> The first half of a plan: arc, orbit and places, all but the search for the manoeuvre.
    !>
    !> Fails for an arc shorter than SHORTEST_ARC or longer than LONGEST_ARC, for a place that is none, a time outside of the
    !> orbit, when a limit is not positive, and for settings that allow no manoeuvre.
    subroutine prepare_plan(calibration, request, plan, error, progress)
        type(calibration_t), intent(in) :: calibration
        type(plan_request_t), intent(in) :: request
        type(plan_t), intent(out) :: plan
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the places to choose from

        call prepare_orbit(calibration%case, request, plan, error)
        plan%calibration = calibration
        if (.not. allocated(error)) call take_sites(request, plan, error, progress)
        call add_context(error, 'case '//trim(calibration%case%name))
    end subroutine prepare_plan

    subroutine prepare_orbit(case, request, plan, error)
        type(case_t), intent(in) :: case
        type(plan_request_t), intent(in) :: request
        type(plan_t), intent(out) :: plan
        type(error_t), allocatable, intent(out) :: error

        plan%time = request%time
        call refuse_unplannable(case, error)
        if (allocated(error)) return
        if (.not. (case%duration >= SHORTEST_ARC .and. case%duration <= LONGEST_ARC)) then
            call fail(error, 'duration = '//number_text(case%duration)//' s: a manoeuvre lasts from '// &
                      number_text(SHORTEST_ARC)//' to '//number_text(LONGEST_ARC)//' s')
        else if (.not. (case%limits%rate > 0 .and. case%limits%pointing > 0)) then
            call fail(error, 'the limits of rate and pointing are '//number_text(case%limits%rate)// &
                      ' rad/s and '//number_text(case%limits%pointing)//' rad: both have to be positive')
        end if
        if (.not. allocated(error)) call new_planned_arc(case, plan%arc, error)
        if (allocated(error)) return
        if (request%search) then
            call check_design_settings(plan%arc, request%settings, error)
        else
            call check_rod_sampling(case%satellite%rods, case%satellite%accelerometer%sampling_interval, error)
        end if
        if (.not. allocated(error)) &
            call new_nominal_orbit(case, plan%orbit, error, request%revolutions, ORBIT_STEP)
    end subroutine prepare_orbit

    subroutine take_sites(request, plan, error, progress)
        type(plan_request_t), intent(in) :: request
        type(plan_t), intent(inout) :: plan
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        real(dp), allocatable :: times(:)
        integer :: best

        select case (request%place)
        case (EVERYWHERE)
            times = times_along(plan%orbit, EVERYWHERE_STEP)
        case (ANYWHERE)
            times = times_along(plan%orbit, ANYWHERE_STEP)
        case (AT_TIME)
            times = [request%time]
        case default
            call fail(error, 'place = '//integer_text(request%place)//': it is 1 (AT_TIME), 2 (ANYWHERE) or 3 (EVERYWHERE)')
            return
        end select
        call new_manoeuvre_sites(plan%arc, plan%orbit, times, request%settings%threads, plan%sites, error)
        if (request%place /= ANYWHERE .or. allocated(error)) return
        call choose_place(plan%arc, plan%sites, request%settings, best, error, progress)
        plan%sites = [plan%sites(best)]
        plan%time = plan%sites(1)%time
    end subroutine take_sites

    !> Times from 0 to the end of the orbit.
    pure function times_along(orbit, step) result(times)
        type(nominal_orbit_t), intent(in) :: orbit
        real(dp), intent(in) :: step            !! From one to the next, s
        real(dp), allocatable :: times(:)       !! s

        integer :: i

        times = [(i*step, i=0, int(last_time(orbit)/step))]
    end function times_along

    !> The second half of a plan: searches the manoeuvre, or judges the case's own.
    !>
    !> Fails when no manoeuvre keeps the limits, or the case's own does not keep them.
    subroutine find_manoeuvre(request, plan, error, progress)
        type(plan_request_t), intent(in) :: request
        type(plan_t), intent(inout) :: plan             !! As prepare_plan gives it
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the manoeuvres looked at

        type(manoeuvre_quality_t) :: quality

        associate (arc => plan%arc, sites => plan%sites, case => plan%calibration%case)
            if (.not. request%search) then
                call judge_manoeuvre(arc, sites, case%satellite%rods, size(sites), plan%design)
                call evaluate_manoeuvre(arc, sites(1), case%satellite%rods, quality)
                call check_motion(arc%knowledge%limits, quality%motion, error)
            else
                call design_manoeuvre(arc, sites, request%settings, plan%design, error, progress)
            end if
            if (.not. allocated(error)) call take_manoeuvre(plan%design%rods, case%satellite%rods)
        end associate
        call add_context(error, 'case '//trim(plan%calibration%case%name))
    end subroutine find_manoeuvre

    !> The calibration that flies the manoeuvre of a plan at its time.
    function planned_calibration(request, plan) result(planned)
        type(plan_request_t), intent(in) :: request
        type(plan_t), intent(in) :: plan
        type(calibration_t) :: planned          !! Its name ends with -design when the manoeuvre was searched

        planned = moved_calibration(plan%calibration, plan%orbit, plan%time)
        if (request%search) call take_design(plan%design, planned)
    end function planned_calibration

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

    !> The best manoeuvre for a case's satellite on an arc of the case's duration, within the limits of its
    !> setup; and the calibration that flies it, `time` seconds later on the orbit, or where along the revolutions it is
    !> best: a plan in one call.
    !>
    !> Fails as prepare_plan and find_manoeuvre do.
    subroutine plan_manoeuvre(calibration, time, settings, planned, design, error, place, revolutions, chosen)
        type(calibration_t), intent(in) :: calibration  !! Its manoeuvre does not matter
        real(dp), intent(in) :: time                    !! Of the start, s from the case's epoch
        type(design_settings_t), intent(in) :: settings
        type(calibration_t), intent(out) :: planned     !! Its name ends with -design
        type(manoeuvre_design_t), intent(out) :: design
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: place          !! AT_TIME when absent; or ANYWHERE, EVERYWHERE
        integer, intent(in), optional :: revolutions    !! For these; 1 when absent
        real(dp), intent(out), optional :: chosen       !! The start that was chosen, s from the case's epoch

        type(plan_request_t) :: request
        type(plan_t) :: plan

        request%time = time
        request%settings = settings
        if (present(place)) request%place = place
        if (present(revolutions)) request%revolutions = revolutions
        if (present(chosen)) chosen = time
        call prepare_plan(calibration, request, plan, error)
        if (.not. allocated(error)) call find_manoeuvre(request, plan, error)
        if (allocated(error)) return
        planned = planned_calibration(request, plan)
        design = plan%design
        if (present(chosen)) chosen = plan%time
    end subroutine plan_manoeuvre

    !> A case's manoeuvre at places along its orbit, as the command `design --manoeuvre CASE --map` has it.
    !>
    !> Fails for times that are negative or after MOST_REVOLUTIONS, when the samples cannot follow the
    !> manoeuvre, and as map_manoeuvre does.
    subroutine map_case(case, times, threads, points, error)
        type(case_t), intent(in) :: case
        real(dp), intent(in) :: times(:)                    !! Of the start, s from the case's epoch
        integer, intent(in) :: threads                      !! 1 to 1024
        type(map_point_t), allocatable, intent(out) :: points(:)
        type(error_t), allocatable, intent(out) :: error

        type(plan_request_t) :: request
        type(plan_t) :: plan
        real(dp) :: revolution

        if (size(times) == 0) then
            allocate (points(0))
            return
        end if
        revolution = TWO_PI/norm2(case%angular_velocity)
        if (all(times >= 0 .and. times <= MOST_REVOLUTIONS*revolution)) then
            request%revolutions = max(1, ceiling(maxval(times)/revolution))
            request%search = .false.
            call prepare_orbit(case, request, plan, error)
        else
            call fail(error, 'times of the map: from 0 to '//number_text(MOST_REVOLUTIONS*revolution)//' s after the epoch, '// &
                      integer_text(MOST_REVOLUTIONS)//' revolutions, are allowed')
        end if
        if (.not. allocated(error)) &
            call map_manoeuvre(plan%arc, plan%orbit, times, case%satellite%rods, threads, points, error)
        call add_context(error, 'case '//trim(case%name))
    end subroutine map_case

    !> The case that starts `time` seconds later on the orbit, with the nominal attitude. At time 0 it is the
    !> case itself. The density wave goes on; the manoeuvre stays, relative to the new epoch. The constant wind
    !> of a built-in case was fitted to its place: away from it the wind is that of the table, as in the
    !> built-in cases 2 and 3.
    function moved_case(case, orbit, time) result(moved)
        type(case_t), intent(in) :: case
        type(nominal_orbit_t), intent(in) :: orbit      !! Of this case
        real(dp), intent(in) :: time                    !! s, within the orbit
        type(case_t) :: moved

        type(case_t) :: built_in                        ! of its name
        type(error_t), allocatable :: failure
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
        if (all(REPORT_CASE_NAMES /= case%name)) return
        call report_case(trim(case%name), built_in, failure)
        if (.not. allocated(failure) .and. case%wind_model == built_in%wind_model .and. &
            .not. norm2([case%wind_east - built_in%wind_east, case%wind_north - built_in%wind_north]) > 0) &
            moved%wind_model = 'hwm93'
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

    !> Words for an operator: manoeuvre, time and the standard deviations that its bound promises. Nothing where that cannot be
    !> said: no orbit, no attitude, rods that are not known by amplitude, a motion beyond the limits; nor where it would be no
    !> better than what was flown.
    subroutine say_next_manoeuvre(observations, flown, text)
        type(observation_set_t), intent(in) :: observations
        real(dp), intent(in) :: flown(3)        !! Standard deviations of the offset by it, m; 0 on axes that need no other
        character(:), allocatable, intent(out) :: text      !! Without a full stop

        type(calibration_t) :: calibration
        type(plan_request_t) :: request
        type(plan_t) :: plan
        type(torque_rods_t) :: rods
        type(manoeuvre_quality_t) :: quality
        type(error_t), allocatable :: failure

        text = ''
        if (observations%knowledge%rods%count == 0) return
        request%settings%amplitude = usual_amplitude(observations%knowledge%rods)
        request%settings%share = usual_shares(observations%knowledge%rods)
        call case_of_observations(observations, calibration%case, failure)
        if (.not. allocated(failure)) call prepare_plan(calibration, request, plan, failure)
        if (allocated(failure)) return
        rods = pattern_567(request%settings, calibration%case%duration)
        call evaluate_manoeuvre(plan%arc, plan%sites(1), rods, quality)
        if (quality%is_seen() .and. .not. any(quality%sigma < flown)) return
        if (.not. quality%is_seen() .or. exceeds_limits(plan%arc%knowledge%limits, quality%motion)) return
        text = 'with rods x, y and z at '//rounded_text(rods%activations(1)%frequency, 3)//', '// &
            rounded_text(rods%activations(2)%frequency, 3)//' and '//rounded_text(rods%activations(3)%frequency, 3)// &
            ' Hz, '//rounded_text(request%settings%amplitude, 3)// &
            trim(merge(' N m  ', ' A m^2', observations%knowledge%rods%direct))//', for '// &
            integer_text(nint(calibration%case%duration))//' s at the next passage here ('// &
            utc_text(utc_plus(calibration%case%epoch, real(nint(plan%orbit%revolution), dp)))//' UTC): sigma by noise '// &
            'alone would be '// &
            rounded_text(quality%sigma(1)/MILLIMETRE, 2)//', '//rounded_text(quality%sigma(2)/MILLIMETRE, 2)//', '// &
            rounded_text(quality%sigma(3)/MILLIMETRE, 2)//' mm'
    end subroutine say_next_manoeuvre
end module gracecg_planning_planner
