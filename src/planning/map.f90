!> A manoeuvre at many places of the nominal orbit: the generalisation of Figure 6.4 of CSR-TM-00-01.
module gracecg_planning_map
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context, number_text
    use gracecg_base_progress, only: progress_t, expect_pieces
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t
    use gracecg_planning_site, only: planned_arc_t, manoeuvre_site_t, new_manoeuvre_site, &
        manoeuvre_quality_t, evaluate_manoeuvre, worst_direction
    implicit none
    private
    public :: map_point_t, map_manoeuvre, new_manoeuvre_sites

    !> The manoeuvre at one place.
    type :: map_point_t
        real(dp) :: time = 0                !! Of the start, s from the epoch of the orbit
        real(dp) :: latitude = 0            !! Geodetic, rad
        real(dp) :: longitude = 0           !! Positive east, rad
        type(manoeuvre_quality_t) :: quality    !! Limit, errors and motion there
        real(dp) :: worst_sigma = 0         !! Of all directions, m
        real(dp) :: worst_direction(3) = 0  !! Unit vector, body axes
    end type map_point_t

    !> Places of the orbit as pieces of work.
    type, abstract, extends(parallel_work_t) :: places_t
        type(planned_arc_t), pointer :: arc => null()
        type(nominal_orbit_t), pointer :: orbit => null()
        real(dp), allocatable :: times(:)               !! s
    end type places_t

    type, extends(places_t) :: sites_t
        type(manoeuvre_site_t), allocatable :: sites(:)
    contains
        procedure :: do_one => tabulate_site
    end type sites_t

    type, extends(places_t) :: map_t
        type(torque_rods_t) :: rods
        type(map_point_t), allocatable :: points(:)
    contains
        procedure :: do_one => map_place
    end type map_t

contains

    !> The places of the orbit at some times. Fails when one lies outside of the orbit.
    subroutine new_manoeuvre_sites(arc, orbit, times, threads, sites, error)
        type(planned_arc_t), intent(in), target :: arc
        type(nominal_orbit_t), intent(in), target :: orbit
        real(dp), intent(in) :: times(:)                !! s
        integer, intent(in) :: threads                  !! 1 and more
        type(manoeuvre_site_t), allocatable, intent(out) :: sites(:)
        type(error_t), allocatable, intent(out) :: error

        type(sites_t) :: work

        work%arc => arc
        work%orbit => orbit
        work%times = times
        allocate (work%sites(size(times)))
        call run_parallel(work, size(times), threads, error)
        call move_alloc(work%sites, sites)
    end subroutine new_manoeuvre_sites

    subroutine tabulate_site(self, i, error)
        class(sites_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        call new_manoeuvre_site(self%arc, self%orbit, self%times(i), self%sites(i), error)
    end subroutine tabulate_site

    !> Evaluates a manoeuvre at places at some times, on `threads` threads. Where it leaves a direction
    !> unseen, the sigmas are huge(1.0). Fails when a time lies outside of the orbit.
    subroutine map_manoeuvre(arc, orbit, times, rods, threads, points, error, progress)
        type(planned_arc_t), intent(in), target :: arc
        type(nominal_orbit_t), intent(in), target :: orbit
        real(dp), intent(in) :: times(:)                !! s
        type(torque_rods_t), intent(in) :: rods         !! Times count from the start of the calibration
        integer, intent(in) :: threads                  !! 1 and more
        type(map_point_t), allocatable, intent(out) :: points(:)
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the places

        type(map_t) :: work

        work%arc => arc
        work%orbit => orbit
        work%times = times
        work%rods = rods
        allocate (work%points(size(times)))
        call expect_pieces(progress, size(times), 'places')
        call run_parallel(work, size(times), threads, error, progress)
        call move_alloc(work%points, points)
    end subroutine map_manoeuvre

    subroutine map_place(self, i, error)
        class(map_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(manoeuvre_site_t) :: site

        call new_manoeuvre_site(self%arc, self%orbit, self%times(i), site, error)
        if (.not. allocated(error)) then
            associate (point => self%points(i))
                point%time = site%time
                point%latitude = site%latitude
                point%longitude = site%longitude
                call evaluate_manoeuvre(self%arc, site, self%rods, point%quality)
                call worst_direction(point%quality, point%worst_sigma, point%worst_direction, error)
            end associate
        end if
        call add_context(error, 'calibration at '//number_text(self%times(i))//' s')
    end subroutine map_place
end module gracecg_planning_map
