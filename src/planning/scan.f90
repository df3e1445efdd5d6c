!> Calibrations along the nominal orbit.
!>
!> When to calibrate: Figures 6.1 and 6.4 of CSR-TM-00-01. At places along the orbit, the angular acceleration that the
!> case's rods would give, and how well a calibration that starts there would determine the CG offset (scan_orbit).
!>
!> And the generalisation of Figure 6.4: a manoeuvre at many places (map_manoeuvre). It is the same at all of them, or two
!> rods as a rule of section 4.2 chooses them by the field at each.
module gracecg_planning_scan
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, add_context, number_text
    use gracecg_base_text, only: integer_text
    use gracecg_base_progress, only: progress_t, expect_pieces
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_spacecraft_rod_pattern, only: rod_pattern, AS_DRIVEN
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, dipole_moment, torque_of
    use gracecg_base_runge_kutta, only: rkf78_step
    use gracecg_environment_sun, only: edge_of_shadow
    use gracecg_environment_time, only: utc_plus, julian_centuries_tt
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, loads_t, STATE_SIZE, POSITION
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_report_problem, only: report_problem_t, prepare_problem
    use gracecg_estimation_batch_problem, only: batch_solution_t
    use gracecg_estimation_batch_processor, only: batch_settings_t, process_batch
    use gracecg_estimation_noise_propagation, only: accelerometer_noise_covariance
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_operator_view, only: operator_knowledge
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, ORBIT_INTERVAL
    use gracecg_planning_candidates, only: usual_amplitude, usual_manoeuvre
    use gracecg_planning_offset_bound, only: principal_axes
    use gracecg_planning_site, only: planned_arc_t, manoeuvre_site_t, new_manoeuvre_site, manoeuvre_quality_t, &
        evaluate_manoeuvre
    implicit none
    private
    public :: orbit_place_t, scan_orbit, x_is_weakest, map_point_t, map_manoeuvre, new_manoeuvre_sites

    !> A calibration that starts at one place of the orbit.
    type :: orbit_place_t
        integer :: time = 0                 !! Of its start, s from the epoch of the orbit
        real(dp) :: latitude = 0            !! Geodetic, rad
        real(dp) :: longitude = 0           !! Positive east, rad
        real(dp) :: field(3) = 0            !! At the start, body axes, T
        real(dp) :: acceleration(3) = 0     !! Amplitude of the angular acceleration, in the field of the start, rad/s^2
        real(dp) :: sigma(3) = 0            !! Predicted standard deviation of the CG offset, m
        logical :: at_edge = .false.        !! It passes the edge of the Earth's shadow, where the forces change
    end type orbit_place_t

    !> The places as pieces of work.
    type, extends(parallel_work_t) :: scan_t
        type(case_t), pointer :: case => null()
        type(nominal_orbit_t), pointer :: orbit => null()
        type(operator_knowledge_t) :: knowledge             !! What the operator knows of the case
        type(estimation_options_t) :: options               !! Of ASSEST
        integer, allocatable :: times(:)                    !! s
        type(orbit_place_t), allocatable :: places(:)
    contains
        procedure :: do_one => look_at_place
    end type scan_t

    !> The manoeuvre at one place.
    type :: map_point_t
        real(dp) :: time = 0                !! Of the start, s from the epoch of the orbit
        real(dp) :: latitude = 0            !! Geodetic, rad
        real(dp) :: longitude = 0           !! Positive east, rad
        logical :: at_edge = .false.        !! It passes the edge of the Earth's shadow
        type(manoeuvre_quality_t) :: quality    !! Limit, errors and motion there
        real(dp) :: worst_sigma = huge(1.0_dp)  !! Of all directions, m
        real(dp) :: worst_direction(3) = 0  !! Unit vector, body axes; 0 where a direction is unseen
    end type map_point_t

    !> Places of the orbit as pieces of work: to be tabulated, or judged with a manoeuvre.
    type, extends(parallel_work_t) :: places_t
        type(planned_arc_t), pointer :: arc => null()
        type(nominal_orbit_t), pointer :: orbit => null()
        real(dp), allocatable :: times(:)                   !! s
        type(torque_rods_t) :: rods                         !! The manoeuvre, unless there is a rule
        character(:), allocatable :: rule                   !! One of PATTERN_RULES, by which each place has its own
        type(manoeuvre_site_t), allocatable :: sites(:)     !! Not allocated: they are not wanted
        type(map_point_t), allocatable :: points(:)         !! Likewise
    contains
        procedure :: do_one => look_at_site
    end type places_t

contains

    !> Looks at the places where the orbit is at the given times, on `threads` threads.
    !>
    !> Fails when a time lies outside of the revolution, or when the offset cannot be determined.
    subroutine scan_orbit(case, options, orbit, times, threads, places, error, progress)
        type(case_t), intent(in), target :: case
        type(estimation_options_t), intent(in) :: options       !! Of ASSEST, whose sigma is predicted
        type(nominal_orbit_t), intent(in), target :: orbit      !! Of this case
        integer, intent(in) :: times(:)                 !! Within one revolution, s
        integer, intent(in) :: threads                  !! How many to use
        type(orbit_place_t), allocatable, intent(out) :: places(:)
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the places

        type(scan_t) :: work

        if (any(times < 0 .or. times > orbit%revolution)) then
            call fail(error, 'times of calibrations: from 0 to '//integer_text(int(orbit%revolution))// &
                      ' s, one revolution, is allowed')
            return
        end if
        work%case => case
        work%orbit => orbit
        work%knowledge = operator_knowledge(case, case%operator)
        work%options = options
        work%times = times
        allocate (work%places(size(times)))
        call run_parallel(work, size(times), threads, error, progress)
        call move_alloc(work%places, places)
    end subroutine scan_orbit

    !> Is the angular acceleration about x smaller than about y and z? There the report expects the
    !> best estimate of the x component (section 6.2).
    elemental logical function x_is_weakest(place)
        type(orbit_place_t), intent(in) :: place

        x_is_weakest = place%acceleration(1) < minval(place%acceleration(2:3))
    end function x_is_weakest

    subroutine look_at_place(self, i, error)
        class(scan_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(loads_t) :: acting
        type(torque_rods_t) :: rods
        integer :: k, last, j

        associate (place => self%places(i), time => self%times(i), case => self%case, orbit => self%orbit, &
                   knowledge => self%knowledge)
            k = nint(time/ORBIT_INTERVAL)
            place%time = time
            call orbit%geodetic_place(k, place%latitude, place%longitude)
            call orbit%dynamics%loads(real(time, dp), orbit%state(:, k), acting)
            place%field = acting%field
            last = min(ubound(orbit%state, 2), k + ceiling(case%duration/ORBIT_INTERVAL))
            place%at_edge = edge_of_shadow(julian_centuries_tt(utc_plus(case%epoch, real(time, dp))), &
                                           [((j - k)*ORBIT_INTERVAL, j=k, last)], orbit%state(POSITION, k:last), &
                                           case%duration) >= 0
            place%acceleration = abs(matmul(inverse_3x3(knowledge%inertia), &
                                            torque_of(knowledge%rods, usual_amplitude(knowledge%rods)* &
                                                      knowledge%rods%gain*rod_pattern(case%pattern_rule, place%field), &
                                                      place%field)))
            call usual_manoeuvre(knowledge%rods, case%pattern_rule, place%field, real(time, dp), knowledge%duration, rods, error)
            if (case%pattern_rule == AS_DRIVEN) place%acceleration = greatest_acceleration(knowledge, rods, time, place%field)
            if (.not. allocated(error)) &
                call predict_sigma(knowledge, self%options, case%angular_velocity, &
                                   magnetic_torque(knowledge, rods, time, measured_field(case, orbit, rods, k)), &
                                   place%sigma, error)
            call add_context(error, 'calibration at '//integer_text(time)//' s')
        end associate
    end subroutine look_at_place

    !> The greatest of each component of the angular acceleration that rods give in one field, rad/s^2.
    pure function greatest_acceleration(knowledge, rods, start, field) result(greatest)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(torque_rods_t), intent(in) :: rods
        integer, intent(in) :: start                !! Of the calibration, s
        real(dp), intent(in) :: field(3)            !! Body axes, T
        real(dp) :: greatest(3)

        real(dp) :: inverse(3, 3), moment(3)
        integer :: j

        inverse = inverse_3x3(knowledge%inertia)
        greatest = 0
        do j = 0, 2*nint(knowledge%duration/knowledge%accelerometer_interval)
            moment = dipole_moment(rods, start + j*knowledge%accelerometer_interval/2)
            greatest = max(greatest, abs(matmul(inverse, torque_of(rods, moment, field))))
        end do
    end function greatest_acceleration

    !> The field that the magnetometer shows, without noise, during a calibration that starts at
    !> sample k of the orbit. The manoeuvre turns the satellite by 0.1 deg, which over the poles, as the
    !> magnetometer's bias does, changes the weak B_y by several per cent.
    function measured_field(case, orbit, rods, k) result(field)
        type(case_t), intent(in) :: case
        type(nominal_orbit_t), intent(in) :: orbit
        type(torque_rods_t), intent(in) :: rods
        integer, intent(in) :: k
        real(dp), allocatable :: field(:, :)    !! (3, 0:n), every magnetometer_interval, body axes, T

        type(satellite_dynamics_t) :: dynamics
        type(loads_t) :: acting
        real(dp) :: state(STATE_SIZE), next(STATE_SIZE), t
        integer :: i, n

        dynamics = orbit%dynamics
        dynamics%rods = rods
        state = orbit%state(:, k)
        associate (interval => case%satellite%magnetometer%sampling_interval)
            n = ceiling(case%duration/interval)
            allocate (field(3, 0:n))
            do i = 0, n
                t = k*ORBIT_INTERVAL + i*interval
                call dynamics%loads(t, state, acting)
                field(:, i) = acting%field + case%satellite%magnetometer%bias
                call rkf78_step(dynamics, t, state, interval, next)
                state = next
            end do
        end associate
    end function measured_field

    !> m x B at every half of the accelerometer's interval, the field linearly between its samples as
    !> in preprocessing: (3, 2n + 1), body axes, N m.
    pure function magnetic_torque(knowledge, rods, start, field) result(torque)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(torque_rods_t), intent(in) :: rods
        integer, intent(in) :: start                !! Of the calibration, s
        real(dp), intent(in) :: field(:, 0:)        !! Every magnetometer_interval, T
        real(dp), allocatable :: torque(:, :)

        real(dp) :: t, fraction
        integer :: j, n, i

        n = nint(knowledge%duration/knowledge%accelerometer_interval)
        allocate (torque(3, 2*n + 1))
        do j = 0, 2*n
            t = j*knowledge%accelerometer_interval/2
            i = min(int(t/knowledge%magnetometer_interval), ubound(field, 2) - 1)
            fraction = t/knowledge%magnetometer_interval - i
            torque(:, j + 1) = torque_of(rods, dipole_moment(rods, start + t), &
                                         (1 - fraction)*field(:, i) + fraction*field(:, i + 1))
        end do
    end function magnetic_torque

    !> Standard deviation of the CG offset by ASSEST under the accelerometer's true noise, along the
    !> rotation that the estimators' own dynamics give. The star camera's noise, which acts through
    !> the initial angular velocity, adds less than 1e-5 of it and is left out.
    subroutine predict_sigma(knowledge, options, angular_velocity, torque, sigma, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        real(dp), intent(in) :: angular_velocity(3)     !! At the start, rad/s
        real(dp), intent(in) :: torque(:, :)            !! (3, 2n + 1), N m
        real(dp), intent(out) :: sigma(3)               !! m
        type(error_t), allocatable, intent(out) :: error

        type(fitting_data_t) :: data
        type(report_problem_t) :: problem
        type(batch_solution_t) :: batch
        real(dp) :: covariance(3, 3)
        integer :: i

        data%torque = torque
        data%steps = (size(torque, 2) - 1)/2
        data%interval = knowledge%accelerometer_interval
        data%guess_angular_velocity = angular_velocity
        data%accelerometer_epoch = [(i, i=1, data%steps)]
        allocate (data%acceleration(3, data%steps), source=0.0_dp)  ! the covariance needs no values
        call prepare_problem(knowledge, options, data, .false., problem)
        call problem%choose(attitude=.false., offset=.true.)
        call process_batch(problem, batch_settings_t(), batch, error)
        if (allocated(error)) return
        call accelerometer_noise_covariance(knowledge, matmul(batch%inverse(1:3, :), batch%gain), &
                                            data%accelerometer_epoch, covariance, error)
        if (allocated(error)) return
        sigma = [(sqrt(covariance(i, i)), i=1, 3)]
    end subroutine predict_sigma

    !> The places of the orbit at some times. Fails when one lies outside of the orbit.
    subroutine new_manoeuvre_sites(arc, orbit, times, threads, sites, error)
        type(planned_arc_t), intent(in), target :: arc
        type(nominal_orbit_t), intent(in), target :: orbit
        real(dp), intent(in) :: times(:)                !! s
        integer, intent(in) :: threads                  !! 1 to 1024
        type(manoeuvre_site_t), allocatable, intent(out) :: sites(:)
        type(error_t), allocatable, intent(out) :: error

        type(places_t) :: work

        allocate (work%sites(size(times)))
        call look_at_all(work, arc, orbit, times, threads, error)
        call move_alloc(work%sites, sites)
    end subroutine new_manoeuvre_sites

    !> Evaluates a manoeuvre at places at some times, on `threads` threads: of some rods, or, with a rule, the case's usual
    !> manoeuvre on the rods that it chooses by the field at each place. Where it leaves a direction unseen, the sigmas are
    !> huge(1.0). Fails when a time lies outside of the orbit.
    subroutine map_manoeuvre(arc, orbit, times, rods, threads, points, error, progress, rule)
        type(planned_arc_t), intent(in), target :: arc
        type(nominal_orbit_t), intent(in), target :: orbit
        real(dp), intent(in) :: times(:)                !! s
        type(torque_rods_t), intent(in) :: rods         !! Times count from the start of the calibration
        integer, intent(in) :: threads                  !! 1 to 1024
        type(map_point_t), allocatable, intent(out) :: points(:)
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the places; with a rule the caller has
        character(*), intent(in), optional :: rule      !! One of PATTERN_RULES

        type(places_t) :: work

        work%rods = rods
        if (present(rule)) work%rule = rule
        allocate (work%points(size(times)))
        if (.not. present(rule)) call expect_pieces(progress, size(times), 'places')
        call look_at_all(work, arc, orbit, times, threads, error, progress)
        call move_alloc(work%points, points)
    end subroutine map_manoeuvre

    subroutine look_at_all(work, arc, orbit, times, threads, error, progress)
        type(places_t), intent(inout) :: work
        type(planned_arc_t), intent(in), target :: arc
        type(nominal_orbit_t), intent(in), target :: orbit
        real(dp), intent(in) :: times(:)
        integer, intent(in) :: threads
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        work%arc => arc
        work%orbit => orbit
        work%times = times
        call run_parallel(work, size(times), threads, error, progress)
    end subroutine look_at_all

    subroutine look_at_site(self, i, error)
        class(places_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(manoeuvre_site_t) :: site

        call new_manoeuvre_site(self%arc, self%orbit, self%times(i), site, error)
        if (.not. allocated(error) .and. allocated(self%points)) call judge_place(self%points(i))
        call add_context(error, 'calibration at '//number_text(self%times(i))//' s')
        if (allocated(self%sites)) self%sites(i) = site

    contains

        subroutine judge_place(point)
            type(map_point_t), intent(out) :: point

            type(torque_rods_t) :: rods
            real(dp) :: axes(3), directions(3, 3)

            point%time = site%time
            point%latitude = site%latitude
            point%longitude = site%longitude
            point%at_edge = site%at_edge
            rods = self%rods
            if (allocated(self%rule)) &
                call usual_manoeuvre(self%arc%knowledge%rods, self%rule, site%field(:, 0), 0.0_dp, &
                                     self%arc%knowledge%duration, rods, error)
            if (allocated(error)) return
            call evaluate_manoeuvre(self%arc, site, rods, point%quality)
            if (.not. point%quality%is_seen()) return
            call principal_axes(point%quality%covariance, axes, directions, error)
            point%worst_sigma = axes(3)
            point%worst_direction = directions(:, 3)
        end subroutine judge_place
    end subroutine look_at_site
end module gracecg_planning_scan
