!> An offset that moves: jumps and drifts told from each other and from chance, of calibrations and of arcs.
module test_offset_movement
    use vocabulary
    use gracecg_environment_time, only: utc_t, seconds_between
    use gracecg_estimation_information, only: information_t, no_information, squares_of
    use gracecg_estimation_offset_change, only: offset_change_t
    use gracecg_estimation_offset_history, only: history_settings_t, tank_series_t, offset_history_t, trace_offset
    use gracecg_estimation_offset_movement, only: movement_t, movement_of_arcs, chance_of_jump
    use gracecg_estimation_saved_estimate, only: dated_offset_t
    use statistics, only: chi_square_limits
    implicit none
    private
    public :: movement_tests

contains

    !> Of the suite `joint`.
    function movement_tests() result(tests)
        type(unittest_type), allocatable :: tests(:)

        tests = [ &
                new_unittest('jump-or-drift', test_movement), &
                new_unittest('jump-or-drift-of-arcs', test_movement_of_arcs), &
                new_unittest('chance-of-a-jump', test_chance)]
    end function movement_tests

    !> Arcs that share the offset and two other parameters, each of which alone determines nothing: no movement, a jump, a drift.
    !> Each is told, with its place; squares of the change and of d in the end have the mean of chi square.
    subroutine test_movement_of_arcs(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: ARCS = 60, SAMPLES = 4, N = 5, RUNS = 100, NONE = 0, JUMP = 1, DRIFT = 2, BEFORE = 23
        real(dp), parameter :: UNIT = 1e-4_dp       ! m
        real(dp), parameter :: TRUE(N) = UNIT*[1.0_dp, -2.0_dp, 0.5_dp, 0.3_dp, -0.2_dp], CHANGE(3) = UNIT*[0.0_dp, 2.0_dp, 0.0_dp]
        real(dp), parameter :: PRIOR(N) = UNIT*[0.0_dp, 0.0_dp, 0.0_dp, 10.0_dp, 10.0_dp]
        type(information_t) :: arc(ARCS)
        type(utc_t) :: times(ARCS)
        type(movement_t) :: found, by_span
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: rows(N, SAMPLES), seen(SAMPLES), share, squares(2), limits(2)
        integer :: told(NONE:DRIFT), placed, kind, run, i, k

        stream = new_stream(1_i8, 1, 1, 1, 79)
        told = 0
        placed = 0
        squares = 0
        do run = 1, RUNS
            do kind = NONE, DRIFT
                do i = 1, ARCS
                    times(i) = utc_t(58880, 300.0_dp*i)
                    do k = 1, SAMPLES
                        call stream%normals(rows(:, k))
                    end do
                    rows = rows/UNIT
                    call stream%normals(seen)
                    share = 0
                    if (kind == JUMP .and. i > BEFORE) share = 1
                    if (kind == DRIFT) share = (i - 1)/(ARCS - 1.0_dp)
                    seen = seen + matmul(TRUE + share*[CHANGE, 0.0_dp, 0.0_dp], rows)
                    arc(i) = no_information(N)
                    arc(i)%matrix = matmul(rows, transpose(rows))
                    arc(i)%rhs = matmul(rows, seen)
                end do
                call movement_of_arcs(arc, times, PRIOR, spread(0.0_dp, 1, N), found, failure)
                if (failed(error, failure)) return
                if (kind /= DRIFT) then
                    call movement_of_arcs(arc, times, PRIOR, spread(0.0_dp, 1, N), by_span, failure, &
                                          [(1 + (i - 1)/BEFORE, i=1, ARCS)])
                    if (failed(error, failure)) return
                    call check(error, by_span%behind, merge(BEFORE, 0, kind == JUMP), 'between which spans')
                end if
                select case (found%kind)
                case ('none')
                    told(kind) = told(kind) + merge(1, 0, kind == NONE)
                case default
                    told(kind) = told(kind) + merge(1, 0, kind == JUMP .and. found%kind /= 'drift' .or. &
                                                    kind == DRIFT .and. found%kind /= 'jump')
                end select
                if (kind == JUMP .and. run == 1) then       ! the same of metres: no satellite's offset changes by so much
                    do i = 1, ARCS
                        arc(i)%matrix = arc(i)%matrix*UNIT**2
                        arc(i)%rhs = arc(i)%rhs*UNIT
                    end do
                    call movement_of_arcs(arc, times, PRIOR/UNIT, spread(0.0_dp, 1, N), by_span, failure)
                    if (failed(error, failure)) return
                    call check(error, by_span%kind == 'none' .and. by_span%offset(1) > 0, 'a change of metres')
                end if
                if (kind == JUMP .and. found%kind /= 'none') then
                    if (seconds_between(found%from, times(BEFORE)) > -1 .and. seconds_between(times(BEFORE + 1), found%to) > -1) &
                        placed = placed + 1
                    squares(1) = squares(1) + sum(((found%change - CHANGE)/found%sigma)**2)
                    squares(2) = squares(2) + squares_of(found%offset - TRUE(:3) - CHANGE, found%covariance)
                end if
            end do
        end do
        call check(error, told(NONE) >= RUNS - 5, 'false alarms')
        call check(error, all(told(JUMP:) >= RUNS - 5), 'told')
        call check(error, placed >= RUNS - 10, 'where')
        limits = chi_square_limits(3*RUNS)
        call check(error, all(squares > limits(1) .and. squares < limits(2)), 'squares of change and of the offset in the end')
    end subroutine test_movement_of_arcs

    !> Largest gains among 99 places of white noise in three dimensions: the chance that is said of them is hardly less than that
    !> which is found, and at most 2.5 times as large.
    subroutine test_chance(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: PLACES = 99, RUNS = 20000
        real(dp), parameter :: LEVELS(2) = [14.0_dp, 18.0_dp]
        type(random_stream_t) :: stream
        real(dp) :: walk(3, PLACES + 1), normal(3), gain(PLACES), found(2), said
        integer :: run, i

        stream = new_stream(1_i8, 1, 1, 1, 80)
        found = 0
        do run = 1, RUNS
            walk(:, 1) = 0
            do i = 1, PLACES + 1
                call stream%normals(normal)
                walk(:, i) = walk(:, max(1, i - 1)) + normal
            end do
            associate (n => PLACES + 1.0_dp)
                gain = [(sum((walk(:, i) - i/n*walk(:, PLACES + 1))**2)/(i*(n - i)/n), i=1, PLACES)]
            end associate
            where (maxval(gain) > LEVELS) found = found + 1.0_dp/RUNS
        end do
        do i = 1, size(LEVELS)
            said = chance_of_jump(LEVELS(i), PLACES)
            call check(error, said > 0.8_dp*found(i) .and. said < 2.5_dp*found(i), 'chance')
        end do
    end subroutine test_chance

    !> A day of 16 revolutions: of 200 without a movement at most 2 in 100 tell one (each of two tests one in 100, and five
    !> sigma of that count), a jump and a drift of 30 um (y: 8 sigma and more) are told by their names, where and by how much.
    subroutine test_movement(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: REVOLUTIONS = 16, RUNS = 200, NONE = 0, JUMP = 1, DRIFT = 2
        real(dp), parameter :: SIGMA(3) = [9e-6_dp, 3e-6_dp, 4e-6_dp], CHANGE(3) = [0.0_dp, 30e-6_dp, 0.0_dp]
        type(dated_offset_t) :: offsets(REVOLUTIONS)
        type(offset_change_t) :: not_known(0)
        type(tank_series_t) :: no_tanks
        type(history_settings_t) :: settings
        type(offset_history_t) :: history
        type(random_stream_t) :: stream
        type(error_t), allocatable :: failure
        real(dp) :: normal(3)
        integer :: told(NONE:DRIFT), placed, kind, run, i, k

        settings%futures = 0
        stream = new_stream(1_i8, 1, 1, 1, 77)
        told = 0
        placed = 0
        do run = 1, RUNS
            do kind = NONE, DRIFT
                do i = 1, REVOLUTIONS
                    offsets(i)%time = utc_t(58880, 5640.0_dp*i)
                    offsets(i)%covariance = 0
                    do k = 1, 3
                        offsets(i)%covariance(k, k) = SIGMA(k)**2
                    end do
                    call stream%normals(normal)
                    offsets(i)%offset = SIGMA*normal
                    if (kind == JUMP .and. i > 6) offsets(i)%offset = offsets(i)%offset + CHANGE
                    if (kind == DRIFT) offsets(i)%offset = offsets(i)%offset + CHANGE*(i - 1)/(REVOLUTIONS - 1.0_dp)
                end do
                call trace_offset(offsets, not_known, no_tanks, settings, history, failure)
                if (failed(error, failure)) return
                associate (found => history%movement)
                    select case (found%kind)
                    case ('jump', 'either')
                        told(kind) = told(kind) + merge(1, 0, kind == NONE .or. kind == JUMP .and. found%kind == 'jump')
                    case ('drift')
                        told(kind) = told(kind) + merge(1, 0, kind /= JUMP)
                    end select
                    if (kind == JUMP) placed = placed + merge(1, 0, abs(seconds_between(offsets(6)%time, found%from)) < 1 .and. &
                                                              abs(found%change(2) - CHANGE(2)) < 5*found%sigma(2))
                end associate
            end do
        end do
        call check(error, told(NONE) <= 14, 'false alarms')
        call check(error, told(JUMP) >= 0.95*RUNS .and. placed >= 0.95*RUNS, 'jumps')
        call check(error, told(DRIFT) >= 0.95*RUNS, 'drifts')
    end subroutine test_movement
end module test_offset_movement
