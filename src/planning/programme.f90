!> Programmes of several manoeuvres: which places and lengths, of many, together let the offset be known best,
!> by the sum of their information.
!>
!> One manoeuvre of the report sees x well or y and z, never all (section 6.2: "two steps"). The information of
!> several about one offset adds up, so a programme is judged by (sum of I)^-1 without flying anything.
module gracecg_planning_programme
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_progress, only: progress_t, expect_pieces
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_simulation_case, only: case_t
    use gracecg_planning_scan, only: map_point_t, map_manoeuvre
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t
    use gracecg_planning_offset_bound, only: invert_information
    use gracecg_planning_site, only: planned_arc_t, new_planned_arc
    implicit none
    private
    public :: candidate_t, programme_t, candidates_along, best_programme
    public :: programme_sigma, MOST_MANOEUVRES

    integer, parameter :: MOST_MANOEUVRES = 6           !! Of a programme

    !> A manoeuvre that a programme can have.
    type, extends(map_point_t) :: candidate_t
        real(dp) :: duration = 0            !! s
        real(dp) :: information(3, 3) = 0   !! About d, all else estimated beside it, 1/m^2
    end type candidate_t

    !> Manoeuvres that belong together, in the order in which they are best flown: each is the one that leaves
    !> the least after those before it.
    type :: programme_t
        integer, allocatable :: chosen(:)   !! Numbers of candidates
        real(dp), allocatable :: sigma(:, :)    !! Of d after each of them, (3, manoeuvres), m; huge(1.0): not known yet
    end type programme_t

contains

    !> The case's usual manoeuvre (the rods that its rule chooses by the field there) at places of an orbit, in arcs of
    !> several lengths. Those that pass the edge of the Earth's shadow, where the forces change, count for nothing. Fails when
    !> a time lies outside of the orbit, or an arc is too short.
    subroutine candidates_along(case, orbit, times, durations, threads, candidates, error, progress)
        type(case_t), intent(in) :: case
        type(nominal_orbit_t), intent(in) :: orbit
        real(dp), intent(in) :: times(:)            !! s
        real(dp), intent(in) :: durations(:)        !! s
        integer, intent(in) :: threads              !! 1 to 1024
        type(candidate_t), allocatable, intent(out) :: candidates(:)    !! (times, for each duration)
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Counts the places

        type(case_t) :: longer
        type(planned_arc_t) :: arc
        type(map_point_t), allocatable :: points(:)
        integer :: i, k

        allocate (candidates(0))
        call expect_pieces(progress, size(times)*size(durations), 'places')
        do i = 1, size(durations)
            longer = case
            longer%duration = durations(i)
            associate (rods => longer%satellite%rods)
                rods%activations%stop = rods%activations%stop + (durations(i) - case%duration)
            end associate
            call new_planned_arc(longer, arc, error)
            if (.not. allocated(error)) &
                call map_manoeuvre(arc, orbit, times, longer%satellite%rods, threads, points, error, progress, case%pattern_rule)
            if (allocated(error)) return
            candidates = [candidates, [(candidate_of_point(points(k), durations(i)), k=1, size(points))]]
        end do
    end subroutine candidates_along

    !> A place of a map as a candidate.
    pure type(candidate_t) function candidate_of_point(point, duration) result(candidate)
        type(map_point_t), intent(in) :: point
        real(dp), intent(in) :: duration        !! Of the manoeuvre's arc, s

        candidate%map_point_t = point
        candidate%duration = duration
        if (point%quality%is_seen() .and. .not. point%at_edge) candidate%information = inverse_3x3(point%quality%covariance)
    end function candidate_of_point

    !> Standard deviations of d after several manoeuvres, m; huge(1.0) when a direction is unseen.
    pure function programme_sigma(information) result(sigma)
        real(dp), intent(in) :: information(3, 3)   !! Their sum, 1/m^2
        real(dp) :: sigma(3)

        real(dp) :: covariance(3, 3)

        call invert_information(information, covariance, sigma)
    end function programme_sigma

    !> The programme of so many manoeuvres that leaves the least of the largest standard deviation; a candidate may be
    !> flown more than once. From every candidate as the first, the others are added one by one, each the best, and then
    !> exchanged for better ones until none is left: of two manoeuvres that finds the best of all pairs.
    pure subroutine best_programme(candidates, manoeuvres, programme)
        type(candidate_t), intent(in) :: candidates(:)      !! At least one
        integer, intent(in) :: manoeuvres                   !! At least one
        type(programme_t), intent(out) :: programme

        integer :: chosen(manoeuvres), best(manoeuvres), first, i, k, found
        real(dp) :: least, left, before

        least = huge(1.0_dp)
        best = 1
        do first = 1, size(candidates)
            chosen = 0
            chosen(1) = first
            left = worst(sum_of(candidates, chosen(:1)))
            do k = 2, manoeuvres
                call add_best(candidates, sum_of(candidates, chosen(:k - 1)), found, left)
                chosen(k) = found
            end do
            do
                before = left
                do k = manoeuvres, 1, -1
                    call add_best(candidates, sum_of(candidates, pack(chosen, [(i /= k, i=1, manoeuvres)])), &
                                  found, left)
                    chosen(k) = found
                end do
                if (.not. left < before*(1 - 1e-9_dp)) exit
            end do
            if (left < least) then
                least = left
                best = chosen
            end if
        end do
        call put_in_order(candidates, best, programme)
    end subroutine best_programme

    !> The candidate that, beside what is known, leaves the least.
    pure subroutine add_best(candidates, known, found, left)
        type(candidate_t), intent(in) :: candidates(:)
        real(dp), intent(in) :: known(3, 3)
        integer, intent(out) :: found
        real(dp), intent(out) :: left           !! The largest standard deviation with it, m

        real(dp) :: sigma
        integer :: i

        found = 1
        left = huge(1.0_dp)
        do i = 1, size(candidates)
            sigma = worst(known + candidates(i)%information)
            if (sigma >= left) cycle
            left = sigma
            found = i
        end do
    end subroutine add_best

    pure function sum_of(candidates, chosen) result(information)
        type(candidate_t), intent(in) :: candidates(:)
        integer, intent(in) :: chosen(:)
        real(dp) :: information(3, 3)

        integer :: i

        information = 0
        do i = 1, size(chosen)
            information = information + candidates(chosen(i))%information
        end do
    end function sum_of

    pure real(dp) function worst(information)
        real(dp), intent(in) :: information(3, 3)

        worst = maxval(programme_sigma(information))
    end function worst

    pure subroutine put_in_order(candidates, chosen, programme)
        type(candidate_t), intent(in) :: candidates(:)
        integer, intent(in) :: chosen(:)
        type(programme_t), intent(out) :: programme

        type(candidate_t) :: left_over(size(chosen))
        real(dp) :: known(3, 3), left
        integer :: i, found, place(size(chosen))

        place = chosen
        left_over = candidates(chosen)
        allocate (programme%chosen(size(chosen)), programme%sigma(3, size(chosen)))
        known = 0
        do i = 1, size(chosen)
            call add_best(left_over(i:), known, found, left)
            found = found + i - 1
            programme%chosen(i) = place(found)
            known = known + left_over(found)%information
            programme%sigma(:, i) = programme_sigma(known)
            place(found) = place(i)
            left_over(found) = left_over(i)
        end do
    end subroutine put_in_order
end module gracecg_planning_programme
