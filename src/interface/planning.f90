!> The C interface: bound of an estimate, planner of the manoeuvre. Documented in include/gracecg.h.
module gracecg_interface_planning
    use gracecg, only: dp, error_t, calibration_t, case_bound_t, bound_of_case, design_settings_t, manoeuvre_design_t, &
        plan_manoeuvre, map_case, map_point_t
    use gracecg_base_parallel, only: MOST_THREADS
    use gracecg_interface_handles, only: object_t
    use gracecg_interface_items, only: items_t
    use gracecg_interface_outcome, only: outcome_t, STATUS_BAD_VALUE
    use gracecg_interface_arguments, only: check_integer
    use gracecg_interface_cases, only: case_object_t
    implicit none
    private
    public :: bound_object_t, design_object_t, map_object_t, case_bound, design, map

    !> The bound of a case behind a handle.
    type, extends(object_t) :: bound_object_t
        type(case_bound_t) :: bound                     !! The least covariance and what it leads to
    contains
        procedure :: tell => tell_bound                 !! Puts its items
    end type bound_object_t

    !> A case with the manoeuvre of the planner behind a handle.
    type, extends(case_object_t) :: design_object_t
        type(manoeuvre_design_t) :: design              !! What the planner says of it
        real(dp) :: start = 0                           !! s from the epoch of the case that was given
    contains
        procedure :: tell => tell_design                !! Puts its items
    end type design_object_t

    !> A manoeuvre at places of an orbit behind a handle.
    type, extends(object_t) :: map_object_t
        type(map_point_t), allocatable :: points(:)     !! In the order of the times
    contains
        procedure :: tell => tell_map                   !! Puts its items
    end type map_object_t

contains

    !> The bound of a case.
    subroutine case_bound(the_case, made, outcome)
        class(case_object_t), intent(in) :: the_case
        type(bound_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        call bound_of_case(the_case%calibration%case, the_case%calibration%options, made%bound, failure)
        call outcome%take(failure)
        if (.not. all(abs([[made%bound%covariance], made%bound%sigma, made%bound%consider_sigma]) <= huge(1.0_dp))) &
            call outcome%refuse(STATUS_BAD_VALUE, 'the bound would be NaN or infinite')
    end subroutine case_bound

    subroutine tell_bound(self, items)
        class(bound_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        call items%put('covariance', self%bound%covariance)
        call items%put('sigma', self%bound%sigma)
        call items%put('principal_sigma', self%bound%principal_sigma)
        call items%put('direction', self%bound%direction)
        call items%put('consider_sigma', self%bound%consider_sigma)
        call items%put('by_source', self%bound%by_source)
    end subroutine tell_bound

    !> Searches the manoeuvre with the best worst axis for a case's satellite.
    subroutine design(the_case, settings, choices, place, revolutions, made, outcome)
        class(case_object_t), intent(in) :: the_case
        real(dp), intent(in) :: settings(9)                 !! In the order of gracecg_design
        integer, intent(in) :: choices(8)                   !! Rods, waveforms, threads
        integer, intent(in) :: place, revolutions           !! 1 there, 2 the best start, 3 one for all places; how many
        type(design_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(calibration_t) :: calibration
        type(error_t), allocatable :: failure

        call check_integer(maxval(choices(:7)), 'the largest of the choices of rods and waveforms', 0, 1, outcome)
        call check_integer(minval(choices(:7)), 'the least of them', 0, 1, outcome)
        call check_integer(choices(8), 'threads', 1, MOST_THREADS, outcome)
        if (.not. outcome%good()) return
        calibration = the_case%calibration
        calibration%case%duration = settings(2)
        calibration%case%limits%rate = settings(8)
        calibration%case%limits%pointing = settings(9)
        call plan_manoeuvre(calibration, settings(1), &
                            design_settings_t(amplitude=settings(3), lowest_frequency=settings(4), &
                                              highest_frequency=settings(5), taper=settings(6), rise_time=settings(7), &
                                              rod_used=choices(1:3) /= 0, waveform_used=choices(4:7) /= 0, &
                                              threads=choices(8)), &
                            made%calibration, made%design, failure, place, revolutions, made%start)
        call outcome%take(failure)
    end subroutine design

    subroutine tell_design(self, items)
        class(design_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        call self%case_object_t%tell(items)
        call items%put('start', self%start)
        call items%put('sigma', self%design%sigma)
        call items%put('wave', self%design%wave)
        call items%put('force', self%design%force)
        call items%put('worst', self%design%worst)
        call items%put('rate', self%design%rate)
        call items%put('excursion', self%design%excursion)
        call items%put('evaluations', real(self%design%evaluations, dp))
    end subroutine tell_design

    !> A case's manoeuvre at n places of its orbit, where a calibration starts `seconds`[n] from the epoch.
    subroutine map(the_case, n, seconds, threads, made, outcome)
        class(case_object_t), intent(in) :: the_case
        integer, intent(in) :: n                            !! Places
        real(dp), intent(in), optional :: seconds(n)        !! Starts of the calibration, from the case's epoch
        integer, intent(in) :: threads    !! To work on
        type(map_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        allocate (made%points(0))
        if (present(seconds) .and. n > 0) call map_case(the_case%calibration%case, seconds, threads, made%points, failure)
        call outcome%take(failure)
    end subroutine map

    subroutine tell_map(self, items)
        class(map_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        integer :: i

        associate (points => self%points, n => size(self%points))
            call items%put('place', [(points(i)%latitude, points(i)%longitude, i=1, n)])
            call items%put('sigma', [(points(i)%quality%sigma, i=1, n)])
            call items%put('wave', [(points(i)%quality%wave, i=1, n)])
            call items%put('force', [(points(i)%quality%force, i=1, n)])
            call items%put('worst', [(points(i)%worst_sigma, points(i)%worst_direction, i=1, n)])
        end associate
    end subroutine tell_map
end module gracecg_interface_planning
