!> A manoeuvre at many places of the nominal orbit: the generalisation of Figure 6.4 of CSR-TM-00-01. It is the same at
!> all of them, or two rods as a rule of section 4.2 chooses them by the field at each.
module gracecg_planning_map
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context, number_text
    use gracecg_base_progress, only: progress_t, expect_pieces
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_spacecraft_rod_pattern, only: rod_pattern
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t
    use gracecg_planning_offset_bound, only: principal_axes
    use gracecg_planning_site, only: planned_arc_t, manoeuvre_site_t, new_manoeuvre_site, &
        manoeuvre_quality_t, evaluate_manoeuvre
    use gracecg_planning_usual_manoeuvre, only: usual_manoeuvre
    implicit none
    private
    public :: map_point_t, map_manoeuvre, new_manoeuvre_sites

    !> The manoeuvre at one place.
    type :: map_point_t
        real(dp) :: time = 0                !! Of the start, s from the epoch of the orbit
        real(dp) :: latitude = 0            !! Geodetic, rad
        real(dp) :: longitude = 0           !! Positive east, rad
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
        procedure :: do_one => look_at_place
    end type places_t

contains

    !> The places of the orbit at some times. Fails when one lies outside of the orbit.
    subroutine new_manoeuvre_sites(arc, orbit, times, threads, sites, error)
        type(planned_arc_t), intent(in), target :: arc
        type(nominal_orbit_t), intent(in), target :: orbit
        real(dp), intent(in) :: times(:)                !! s
        integer, intent(in) :: threads                  !! 1 and more
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
        integer, intent(in) :: threads                  !! 1 and more
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

    subroutine look_at_place(self, i, error)
        class(places_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(manoeuvre_site_t) :: site

        call new_manoeuvre_site(self%arc, self%orbit, self%times(i), site, error)
        if (.not. allocated(error) .and. allocated(self%points)) call judge_place(self, site, self%points(i), error)
        call add_context(error, 'calibration at '//number_text(self%times(i))//' s')
        if (allocated(self%sites)) self%sites(i) = site
    end subroutine look_at_place

    subroutine judge_place(self, site, point, error)
        class(places_t), intent(in) :: self
        type(manoeuvre_site_t), intent(in) :: site
        type(map_point_t), intent(out) :: point
        type(error_t), allocatable, intent(out) :: error

        type(torque_rods_t) :: rods
        real(dp) :: axes(3), directions(3, 3)

        point%time = site%time
        point%latitude = site%latitude
        point%longitude = site%longitude
        rods = self%rods
        if (allocated(self%rule)) &
            call usual_manoeuvre(self%arc%knowledge%rods, rod_pattern(self%rule, site%field(:, 0)), 0.0_dp, &
                                 self%arc%knowledge%duration, rods, error)
        if (allocated(error)) return
        call evaluate_manoeuvre(self%arc, site, rods, point%quality)
        if (.not. point%quality%is_seen()) return
        call principal_axes(point%quality%covariance, axes, directions, error)
        point%worst_sigma = axes(3)
        point%worst_direction = directions(:, 3)
    end subroutine judge_place
end module gracecg_planning_map
