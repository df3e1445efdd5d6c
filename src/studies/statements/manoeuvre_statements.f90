!> What CSR-TM-00-01 states of the manoeuvre: one rod alone, why it is poor, and how long an arc should be.
module gracecg_studies_manoeuvre_statements
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: MILLIMETRE, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_base_progress, only: progress_t, expect_pieces
    use gracecg_base_text, only: integer_text, pick_text, share_text
    use gracecg_spacecraft_torque_rods, only: new_harmonic_manoeuvre
    use gracecg_simulation_report_cases, only: ROD_AMPLITUDE, ROD_FREQUENCY
    use gracecg_simulation_simulator, only: simulator_t, new_simulator
    use gracecg_planning_bound, only: case_bound_t, bound_of_case
    use gracecg_planning_calibration, only: calibration_t, find_calibration
    use gracecg_studies_monte_carlo, only: prediction_t, predict_errors
    use gracecg_studies_examination, only: examination_t, statement_row_t, mm_text, plain_text, &
        HOLDS, HOLDS_IN_PART, HOLDS_NOT, SINGLE_ALGORITHM, FRONT_CASES, SMALL_SHARE
    implicit none
    private
    public :: examine_one_rod, examine_dominance, examine_arc_length

    real(dp), parameter :: DOMINATES = 10               !! Torque ratio from which on the rods' torque dominates
    integer, parameter :: LENGTHS(6) = [60, 90, 120, 180, 240, 300]     !! Of arcs, s

contains

    !> A case of the report with one rod at full moment in place of its manoeuvre.
    subroutine take_rod(case_name, rod, calibration, setting, error)
        character(*), intent(in) :: case_name
        integer, intent(in) :: rod                  !! 1 x, 2 y, 3 z; 0: both rods of the report
        type(calibration_t), intent(out) :: calibration
        character(:), allocatable, intent(out) :: setting       !! In words
        type(error_t), allocatable, intent(inout) :: error

        integer :: pattern(3)

        setting = 'both rods'
        if (allocated(error)) return
        call find_calibration(case_name, calibration, error)
        if (allocated(error) .or. rod == 0) return
        setting = AXES(rod)//' rod alone'
        pattern = 0
        pattern(rod) = 1
        call new_harmonic_manoeuvre(pattern, ROD_AMPLITUDE, ROD_FREQUENCY, 0.0_dp, calibration%case%duration, &
                                    calibration%case%satellite%rods, error)
    end subroutine take_rod

    !> One rod alone against both, at all places.
    subroutine examine_one_rod(work, error, progress)
        type(examination_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(calibration_t) :: calibration
        character(:), allocatable :: setting
        integer :: i, rod

        call expect_pieces(progress, size(FRONT_CASES)*(1 + 3)*work%runs, 'runs')
        do i = 1, size(FRONT_CASES)
            do rod = 0, 3
                call take_rod(FRONT_CASES(i), rod, calibration, setting, error)
                call work%add_errors(calibration, SINGLE_ALGORITHM, setting, error, progress)
            end do
        end do
        if (.not. allocated(error)) call judge_one_rod(work)
    end subroutine examine_one_rod

    !> Rows in fours: both rods, then each alone. For all axes together the largest error counts.
    subroutine judge_one_rod(work)
        type(examination_t), intent(inout) :: work

        character(:), allocatable :: first
        integer :: i, k, axis, together, better

        together = 0
        better = 0
        do i = 1, size(work%rows), 4
            do k = i + 1, i + 3
                associate (both => work%rows(i)%predicted, alone => work%rows(k)%predicted)
                    if (maxval(alone) <= maxval(both)) together = together + 1
                    do axis = 1, 3
                        if (alone(axis) >= both(axis)) cycle
                        better = better + 1
                        if (better == 1) first = trim(work%rows(k)%setting)//' in '//trim(work%rows(k)%case_name)// &
                            ': '//AXES(axis)//' '//trim(mm_text(alone(axis)))//' against '//trim(mm_text(both(axis)))//' mm'
                    end do
                end associate
            end do
        end do
        if (together > 0) then
            work%verdict = HOLDS_NOT
            work%found = 'Does not hold: in '//share_text(together, 3*size(work%rows)/4)// &
                ' trials one rod has the better worst axis.'
        else if (better == 0) then
            work%verdict = HOLDS
            work%found = 'Holds: no axis is determined better by one rod.'
        else
            work%verdict = HOLDS_IN_PART
            work%found = 'Holds for all axes together only: the worst axis of one rod is always worse than that of '// &
                'two, but '//share_text(better, 3*3*size(work%rows)/4)//' single components are better.'
            work%details = 'The first of them: '//first//'.'
        end if
    end subroutine judge_one_rod

    !> Why one rod is poor: how far its torque exceeds all others, what the fit's errors make of the offset's, and what
    !> any estimator could know of it.
    subroutine examine_dominance(work, error)
        type(examination_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error

        type(calibration_t) :: calibration
        character(:), allocatable :: setting
        real(dp) :: left_out(0:3, size(FRONT_CASES))    ! Part of the worst axis' variance
        integer :: i, rod

        do i = 1, size(FRONT_CASES)
            do rod = 0, 3
                call take_rod(FRONT_CASES(i), rod, calibration, setting, error)
                call add_dominance(calibration, setting, left_out(rod, i), work, error)
                if (allocated(error)) return
            end do
        end do
        call judge_dominance(left_out(1:, :), work)
    end subroutine examine_dominance

    !> A row of torque ratio, bound and condition.
    subroutine add_dominance(calibration, setting, left_out, work, error)
        type(calibration_t), intent(in) :: calibration
        character(*), intent(in) :: setting
        real(dp), intent(out) :: left_out
        !! Part of the variance of the worst axis by all that the fit leaves out: other torques, scale factors, biases
        type(examination_t), intent(inout) :: work
        type(error_t), allocatable, intent(inout) :: error

        type(statement_row_t) :: row
        type(simulator_t) :: simulator
        type(prediction_t) :: prediction
        type(case_bound_t) :: bound
        real(dp) :: of_rods, of_others, values(3), vectors(3, 3)
        integer :: k, worst

        left_out = 0
        if (.not. allocated(error)) call new_simulator(calibration%case, simulator, error)
        if (.not. allocated(error)) call predict_errors(simulator, SINGLE_ALGORITHM, calibration%options, prediction, error)
        if (.not. allocated(error)) call bound_of_case(calibration%case, calibration%options, bound, error)
        if (.not. allocated(error)) call symmetric_eigen(bound%covariance/MILLIMETRE**2, values, vectors, error)
        if (allocated(error)) return
        worst = maxloc(prediction%rms, 1)
        left_out = (prediction%bias(worst)/prediction%rms(worst))**2
        of_rods = 0
        of_others = 0
        do k = 0, simulator%arc%steps
            associate (acting => simulator%arc%loads(k))
                of_rods = of_rods + sum(acting%torque_magnetic**2)
                of_others = of_others + sum((acting%torque_aero + acting%torque_solar + acting%torque_gravity)**2)
            end associate
        end do
        row%case_name = trim(calibration%case%name)
        row%setting = setting
        row%torque_ratio = sqrt(of_rods/of_others)
        row%predicted = [(sqrt(bound%covariance(k, k)), k=1, 3)]
        row%condition = maxval(values)/minval(values)
        work%rows = [work%rows, row]
    end subroutine add_dominance

    !> Rows in fours, as those of one rod. The reason does not hold where all that the fit leaves out is a small part of
    !> the errors, whatever the ratio of the torques.
    subroutine judge_dominance(left_out, work)
        real(dp), intent(in) :: left_out(:, :)      !! Part of the worst axis' variance; (rods, places)
        type(examination_t), intent(inout) :: work

        real(dp) :: loss
        integer :: i, k, weak

        loss = huge(loss)
        weak = 0
        do i = 1, size(work%rows), 4
            do k = i + 1, i + 3
                if (work%rows(k)%torque_ratio < DOMINATES) weak = weak + 1
                loss = min(loss, maxval(work%rows(k)%predicted)/maxval(work%rows(i)%predicted))
            end do
        end do
        call work%conclude(count(left_out >= SMALL_SHARE), size(left_out), 'trials', 'what the fit leaves out (other '// &
            'torques, scale factors, biases) makes at most '//trim(plain_text(100*maxval(left_out), '(f10.1)'))// &
            ' % of the variance of one rod''s worst axis.')
        work%details = 'One rod''s torque is more than '//trim(plain_text(DOMINATES, '(f10.0)'))// &
            ' times that of all others in '// &
            share_text(size(left_out) - weak, size(left_out))//' trials. With all torques known, the worst axis of one rod is '// &
            'at least '//trim(plain_text(loss, '(f10.1)'))//' times that of two'// &
            pick_text(loss > 1 .and. work%verdict == HOLDS_NOT, ': what is lacking is observability.', '.')
    end subroutine judge_dominance

    !> Longer arcs with the report's rods and algorithm.
    subroutine examine_arc_length(work, error, progress)
        type(examination_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress

        type(calibration_t) :: calibration
        integer :: i, k

        call expect_pieces(progress, size(FRONT_CASES)*size(LENGTHS)*work%runs, 'runs')
        do i = 1, size(FRONT_CASES)
            call find_calibration(FRONT_CASES(i), calibration, error)
            if (allocated(error)) return
            do k = 1, size(LENGTHS)
                calibration%case%duration = LENGTHS(k)
                associate (rods => calibration%case%satellite%rods)
                    rods%activations(:rods%count)%stop = LENGTHS(k)
                end associate
                call work%add_errors(calibration, SINGLE_ALGORITHM, integer_text(LENGTHS(k))//' s', error, progress)
            end do
            if (allocated(error)) return
        end do
        call judge_arc_length(work)
    end subroutine examine_arc_length

    !> Rows by place and length: at which length the worst axis is best, and how many components are worse again in the
    !> longest arc than in a shorter one.
    subroutine judge_arc_length(work)
        type(examination_t), intent(inout) :: work

        real(dp) :: errors(size(LENGTHS), 3), worst(size(LENGTHS))      ! By length
        integer :: i, k, n, best, turns, shortest
        character(:), allocatable :: best_lengths

        best_lengths = ''
        turns = 0
        shortest = 0
        n = size(work%rows)/size(LENGTHS)
        do i = 1, n
            associate (rows => work%rows((i - 1)*size(LENGTHS) + 1:i*size(LENGTHS)))
                errors = transpose(reshape([(rows(k)%predicted, k=1, size(rows))], [3, size(rows)]))
                worst = maxval(errors, 2)
                best = minloc(worst, 1)
                if (best == 1) shortest = shortest + 1
                turns = turns + count(minloc(errors, 1) < size(LENGTHS))
                best_lengths = best_lengths//pick_text(i > 1, ', ', ' ')//integer_text(LENGTHS(best))//' s in '// &
                    trim(rows(1)%case_name)//' ('//trim(mm_text(worst(best)))//' mm; at 60 s '//trim(mm_text(worst(1)))//')'
            end associate
        end do
        call work%conclude(shortest, n, 'places', 'the worst axis is best at 60 s in '//share_text(shortest, n)// &
            ' places; '//share_text(turns, 3*n)//' components are worse at 300 s than at a shorter arc.')
        work%details = 'The worst axis is best at'//best_lengths//'.'
    end subroutine judge_arc_length
end module gracecg_studies_manoeuvre_statements
