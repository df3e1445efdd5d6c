!> A manoeuvre at many places of the nominal orbit: the generalisation of Figure 6.4 of CSR-TM-00-01.
module gracecg_planning_map
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context, number_text
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t
    use gracecg_planning_site, only: accelerometer_view_t, manoeuvre_site_t, new_manoeuvre_site, &
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

contains

    !> The places of the orbit at some times. Fails when one lies outside of the orbit.
    subroutine new_manoeuvre_sites(view, orbit, times, threads, sites, error)
        type(accelerometer_view_t), intent(in) :: view
        type(nominal_orbit_t), intent(in) :: orbit
        real(dp), intent(in) :: times(:)                !! s
        integer, intent(in) :: threads                  !! 1 and more
        type(manoeuvre_site_t), allocatable, intent(out) :: sites(:)
        type(error_t), allocatable, intent(out) :: error

        type(error_t), allocatable :: failure
        integer :: i, first_failed

        allocate (sites(size(times)))
        first_failed = size(times) + 1
        !$omp parallel do schedule(dynamic) num_threads(threads) default(shared) private(failure)
        do i = 1, size(times)
            call new_manoeuvre_site(view, orbit, times(i), sites(i), failure)
            if (allocated(failure)) then
                !$omp critical (gracecg_manoeuvre_map_failure)
                if (i < first_failed) then
                    first_failed = i
                    error = failure
                end if
                !$omp end critical (gracecg_manoeuvre_map_failure)
            end if
        end do
        !$omp end parallel do
    end subroutine new_manoeuvre_sites

    !> Evaluates a manoeuvre at places at some times, on `threads` threads. Where it leaves a direction
    !> unseen, the sigmas are huge(1.0). Fails when a time lies outside of the orbit.
    subroutine map_manoeuvre(view, orbit, times, rods, threads, points, error)
        type(accelerometer_view_t), intent(in) :: view
        type(nominal_orbit_t), intent(in) :: orbit
        real(dp), intent(in) :: times(:)                !! s
        type(torque_rods_t), intent(in) :: rods         !! Times count from the start of the calibration
        integer, intent(in) :: threads                  !! 1 and more
        type(map_point_t), allocatable, intent(out) :: points(:)
        type(error_t), allocatable, intent(out) :: error

        type(manoeuvre_site_t) :: site
        type(error_t), allocatable :: failure
        integer :: i, first_failed

        allocate (points(size(times)))
        first_failed = size(times) + 1
        !$omp parallel do schedule(dynamic) num_threads(threads) default(shared) private(site, failure)
        do i = 1, size(times)
            call new_manoeuvre_site(view, orbit, times(i), site, failure)
            if (.not. allocated(failure)) then
                points(i)%time = site%time
                points(i)%latitude = site%latitude
                points(i)%longitude = site%longitude
                call evaluate_manoeuvre(view, site, rods, points(i)%quality)
                call worst_direction(points(i)%quality, points(i)%worst_sigma, points(i)%worst_direction, failure)
            end if
            if (allocated(failure)) then
                !$omp critical (gracecg_manoeuvre_map_failure)
                if (i < first_failed) then
                    first_failed = i
                    error = failure
                end if
                !$omp end critical (gracecg_manoeuvre_map_failure)
            end if
        end do
        !$omp end parallel do
        if (allocated(error)) call add_context(error, 'calibration at '//number_text(times(first_failed))//' s')
    end subroutine map_manoeuvre
end module gracecg_planning_map
