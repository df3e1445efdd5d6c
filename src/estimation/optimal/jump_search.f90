!> Does the non-gravitational acceleration jump, as it does where the satellite enters the shadow or the wind
!> turns within a sample? Of each candidate, a step of one accelerometer axis at one sample, the gain of the
!> weighted squares is Rao's score statistic, as that of a density wave (gracecg_estimation_wave_search): a chi-square
!> with one degree of freedom if there is no step.
!>
!> Candidates are MOST_CANDIDATES places over the arc and, around the best of them, its neighbours by bisection: the
!> work grows with the arc's length, not with its square.
module gracecg_estimation_jump_search
    use gracecg_base_error, only: number_text
    use gracecg_base_kinds, only: dp
    use gracecg_base_lapack, only: sum_of_products
    use gracecg_base_text, only: append, rounded_text, string_t
    use gracecg_environment_sun, only: edge_of_shadow
    use gracecg_environment_time, only: julian_centuries_tt
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_parameters, only: OFFSET, FORCE_JUMP
    use gracecg_estimation_whitened_problem, only: whitened_problem_t
    use gracecg_estimation_batch_problem, only: batch_solution_t
    implicit none
    private
    public :: force_jump_found_t, search_jump, report_jump

    real(dp), parameter :: LEAST_GAIN = 16
    !! Exceeded by chance with the probability 6e-5 at one place, and of the places of an arc some 60 in each of 3 axes are
    !! independent: an arc in a hundred gets a jump that it does not have, which costs nothing but a little of its sigma; and
    !! a smaller one that is there contradicts no belief
    real(dp), parameter :: MOST_LEFT = 1.5_dp
    !! Mean whitened square of the axis without what the jump explains: where more than that is left, residuals are no
    !! noise, and a jump is none
    real(dp), parameter :: PART_OF_WAVE = 0.5_dp
    !! Of the gain of a density wave, chosen: steps of 1 and 2e-8 m/s^2 beside a wave of 2.7e-9 m/s^2 have more
    real(dp), parameter :: LEAST_SEPARATE = 1e-4_dp !! Of a step's information, the part that other parameters do not take
    real(dp), parameter :: AS_GOOD = 4      !! Difference of gains of two standard deviations
    integer, parameter :: MOST_CANDIDATES = 60
    integer, parameter :: TOGETHER = 24             !! Steps that are whitened together

    !> A jump in the residuals.
    type :: force_jump_found_t
        logical :: found = .false.      !! It stands out of the noise
        integer :: epoch = 0            !! The first sample after it, in intervals from the epoch of the arc
        real(dp) :: gain = 0            !! Of the weighted squares
        integer :: earliest = 0, latest = 0
        !! The same of the places that the data can tell from the best by less than two standard deviations
    end type force_jump_found_t

contains

    !> Looks for a jump in the residuals of a fit that has converged.
    function search_jump(problem, batch, of_wave) result(jump)
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch     !! Of this problem
        real(dp), intent(in), optional :: of_wave
        !! The gain of a wave that the residuals show, too: a jump has to have a large part of it, whatever it leaves
        type(force_jump_found_t) :: jump

        real(dp) :: most, allowed, gain(MOST_CANDIDATES), beside(2)
        integer :: axis, samples, spacing, i, best, places(MOST_CANDIDATES), near

        samples = size(problem%data%accelerometer_epoch)
        spacing = samples/(MOST_CANDIDATES + 1)
        if (spacing < 1) return
        places = [(1 + i*spacing, i=1, MOST_CANDIDATES)]
        most = LEAST_GAIN
        allowed = MOST_LEFT
        if (present(of_wave)) then
            most = PART_OF_WAVE*of_wave
            allowed = huge(allowed)
        end if
        do axis = 1, 3
            gain = gains_at(problem, batch, axis, places)
            best = maxloc(gain, 1)
            if (gain(best) < most/2) cycle
            i = places(best)
            near = spacing
            do while (near > 1)
                near = (near + 1)/2
                beside = gains_at(problem, batch, axis, [i - near, i + near])
                if (maxval(beside) > gain(best)) then
                    i = merge(i - near, i + near, beside(1) > beside(2))
                    gain(best) = maxval(beside)
                end if
            end do
            if (gain(best) < most .or. left_of(problem, batch, axis, gain(best)) > allowed) cycle
            most = gain(best)
            associate (epoch => problem%data%accelerometer_epoch, alike => gain > gain(best) - AS_GOOD)
                jump = force_jump_found_t(.true., epoch(i), most, &
                                          epoch(places(findloc(alike, .true., 1)) - spacing), &
                                          epoch(min(samples, places(findloc(alike, .true., 1, back=.true.)) + spacing)))
            end associate
        end do
    end function search_jump

    !> s^2/S of steps of an axis: s their scores, S their information with all other parameters eliminated.
    function gains_at(problem, batch, axis, places) result(gains)
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch
        integer, intent(in) :: axis
        integer, intent(in) :: places(:)        !! The first sample of each step, rising
        real(dp) :: gains(size(places))

        real(dp) :: information
        real(dp), dimension(min(TOGETHER, size(places)), size(problem%data%accelerometer_epoch)) :: steps
        real(dp) :: with_others(size(batch%inverse, 1), size(steps, 1)), score(size(steps, 1)), whole(size(steps, 1))
        integer :: done, count, from, first, i, n, samples

        gains = 0
        do done = 0, size(places) - 1, size(steps, 1)
            count = min(size(steps, 1), size(places) - done)
            from = max(1, places(done + 1))     ! before it all of them are 0
            samples = size(steps, 2) - from + 1
            first = problem%star_rows + 3*(from - 1) + axis
            n = size(with_others, 1)
            steps(:, :samples) = 0
            do i = 1, count
                steps(i, max(1, places(done + i)) - from + 1:samples) = 1
            end do
            call problem%whiteners(axis)%whiten(steps(:, :samples), from)
            call sum_of_products(n, size(steps, 1), samples, batch%gain(:, first:first + 3*(samples - 1):3), steps, with_others)
            score = 0
            whole = 0
            do i = 1, samples
                score = score + steps(:, i)*batch%residuals(first + 3*(i - 1))
                whole = whole + steps(:, i)**2
            end do
            do i = 1, count
                information = whole(i) - dot_product(with_others(:, i), matmul(batch%inverse, with_others(:, i)))
                if (information > LEAST_SEPARATE*whole(i)) gains(done + i) = score(i)**2/information
            end do
        end do
    end function gains_at

    !> Mean whitened square of an axis without a gain.
    pure real(dp) function left_of(problem, batch, axis, gain) result(left)
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch
        integer, intent(in) :: axis
        real(dp), intent(in) :: gain

        associate (first => problem%star_rows + axis, last => problem%star_rows + problem%acceleration_rows)
            left = (sum(batch%residuals(first:last:3)**2) - gain)/max(1, count(problem%acceleration_kept(axis, :)))
        end associate
    end function left_of

    !> Warns of a jump that was estimated: when, as far as the data tell, and whether the Sun rises or sets then. One whose time is
    !> not clear, and by which the offset hardly moves, is not worth a word.
    subroutine report_jump(knowledge, problem, batch, found, without, warnings)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(whitened_problem_t), intent(in) :: problem     !! Of the fit with it
        type(batch_solution_t), intent(in) :: batch
        type(force_jump_found_t), intent(in) :: found
        real(dp), intent(in) :: without(3)      !! The offset by the fit without it, m
        type(string_t), allocatable, intent(inout) :: warnings(:)

        real(dp), parameter :: SHARP = 3        ! s, between the earliest and the latest time of what is called a jump
        real(dp), parameter :: CLEAR = 64       ! Least gain of it. Forces that bend and do not jump have gains up to 58 in 120
                                                ! sound runs (six cases, four designed manoeuvres, seeds 1 to 12)
        real(dp), parameter :: HARDLY = 0.3_dp  ! Of the offset's sigma, chosen: in sound runs it is moved by 0.13 of it
        character(:), allocatable :: text, step
        real(dp) :: width, edge, moved(3)
        integer :: k

        moved = [(abs(problem%state%value(OFFSET(k)) - without(k))/sqrt(batch%inverse(OFFSET(k), OFFSET(k))), k=1, 3)]
        width = (found%latest - found%earliest)*problem%model%interval
        associate (jump => problem%state%value(FORCE_JUMP(1):FORCE_JUMP(3)))
            step = rounded_text(jump(1), 2)//', '//rounded_text(jump(2), 2)//', '//rounded_text(jump(3), 2)// &
                ' m/s^2 along x, y, z'
        end associate
        if (width <= SHARP .and. found%gain > CLEAR) then
            text = 'the non-gravitational acceleration jumps at '//number_text(problem%model%jump*problem%model%interval)// &
                ' s (within '//rounded_text(width/2, 2)//' s) by '//step//': it is estimated, too'
        else if (all(moved < HARDLY)) then
            return
        else
            text = 'the non-gravitational acceleration bends by more than a parabola: a step of '//step//' is estimated, too, '// &
                'whose time is not clear'
        end if
        associate (data => problem%data)
            edge = edge_of_shadow(julian_centuries_tt(knowledge%epoch), data%orbit_time, data%orbit_position, &
                                  data%steps*data%interval)
        end associate
        if (edge >= 0) text = text//'; the edge of the Earth''s shadow is passed at '//rounded_text(edge, 3)//' s'
        call append(warnings, text)
    end subroutine report_jump
end module gracecg_estimation_jump_search
