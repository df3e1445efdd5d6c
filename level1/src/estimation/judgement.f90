!> The judgement of an estimate from Level-1 data: names of what is wrong, and flags of its solutions.
module gracecg_level1_judgement
    use gracecg_level1_basics
    use gracecg_base_text, only: join
    use gracecg_estimation_action, only: known_offset_t, decide, known_of, refuse_offset, listed_axes, CALIBRATE_AGAIN
    use gracecg_estimation_belief_report, only: CONTRADICTED
    use gracecg_estimation_belief_words, only: say_contradiction
    use gracecg_estimation_offset_movement, only: movement_words, axis_words
    use gracecg_level1_calibration, only: level1_calibration_t, name_of_span, signs_are_known
    use gracecg_level1_frames, only: ORDERS
    use gracecg_level1_held_currents, only: rod_accelerations
    use gracecg_level1_outcome, only: level1_estimate_t, level1_solution_t, milliseconds, sigma_of, WORST_CONDITION
    use gracecg_level1_setup, only: leakage_sigmas
    use gracecg_level1_time_shifts, only: say_shift, say_jump, say_exchange
    use gracecg_observations_parameters, only: ROD_GAIN, FIELD_DELAY
    use gracecg_spacecraft_rod_leakage, only: USUAL_LEAKAGE
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    implicit none
    private
    public :: name_faults, look_over_spans, judge, take_action, offset_remark, CLOSE_ENOUGH, VERDICTS, REQUIREMENT, UNSEEN

    !> What no test of a calibration sees
    character(*), parameter :: UNSEEN = 'a factor below 3 of all accelerometer axes, by which d goes; the mass, by which mass '// &
        'moments go; inertia and rod gains that are wrong alike: d does not go by them'
    real(dp), parameter :: CLOSE_ENOUGH = 10*MICROMETRE     !! Sources agree within this or three sigma
    character(24), parameter :: VERDICTS(0:2) = [character(24) :: 'good', 'to be used with care', 'not to be used'] !! By flag
    real(dp), parameter :: REQUIREMENT = 0.1_dp*MILLIMETRE  !! Of |d| by axis (GCMD, Remote Sensing 14(16) 4030)
    real(dp), parameter :: GOOD_SIGMA = 5*MICROMETRE        !! A source with a greater one is to be used with care
    real(dp), parameter :: POOR_SIGMA = 50*MICROMETRE       !! And with a greater one than this not at all

contains

    !> What to do: nothing is moved by an offset that is not to be used.
    subroutine take_action(calibration, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(inout) :: estimate

        character(5), parameter :: TELLING(2) = ['SCA1B', 'GNV1B']     ! Files without which nothing is seen along the orbit
        type(known_offset_t) :: known
        logical :: missing(size(TELLING))
        integer :: k

        associate (first => estimate%solutions(1))
            if (first%flag > 1 .and. size(estimate%findings) > 0) then
                call refuse_offset(estimate%findings(1)%text, estimate%action)
            else if (first%flag > 1) then
                call refuse_offset(trim(first%reason), estimate%action)
            else if (.not. allocated(first%beliefs)) then
                call refuse_offset('what the setup says could not be tested', estimate%action)
            else
                known = known_of(first%offset, first%covariance, first%beliefs)
                known%signs_seen = all(calibration%follows == 1)
                call decide(known, calibration%setup%mass, estimate%action)
                if (estimate%action%kind == CALIBRATE_AGAIN .and. .not. any([known%signs_known, known%signs_seen])) then
                    missing = [(calibration%files%days_with(TELLING(k)) == 0, k=1, size(TELLING))]
                    do k = 1, size(TELLING)
                        if (missing(k)) estimate%action%text = estimate%action%text// &
                            '; '//TELLING(k)//' is missing, which with the others would tell the signs along the orbit'
                    end do
                    if (.not. any(missing)) estimate%action%text = estimate%action%text//'; air and light along the orbit '// &
                        'do not show clearly enough in accelerometer '//trim(listed_axes(calibration%follows /= 1))// &
                        ' (half an hour beside the spans, or another orbit, may tell)'
                end if
                if (first%flag == 1) estimate%action%text = estimate%action%text//'; with care: '//trim(first%reason)
            end if
        end associate
    end subroutine take_action

    !> Names what the samples of the spans show to be wrong with data or setup.
    subroutine name_faults(calibration, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(inout) :: estimate

        real(dp), parameter :: LEAST_CORRECTION = 5e-3_dp, WITHIN = 1e-3_dp, CERTAIN = 3e-3_dp      ! s
        real(dp), parameter :: HARDLY = 0.3_dp
        real(dp), parameter :: LEAST_TURN = 0.3_dp*DEGREE       ! Of a pole: of date and of 2000 are 0.2 deg apart until 2036
        character(:), allocatable :: shifted
        integer :: k, before

        if (calibration%field_turned /= '') then
            call append(estimate%findings, trim(calibration%field_turned))
            return
        end if
        if (any(calibration%order /= [1, 2, 3])) then
            if (calibration%has_angular) call check_axes(calibration%setup%accelerometer_axes, estimate)
            if (size(estimate%findings) > 0) return     ! angular ones are exchanged likewise
            associate (columns => abs(calibration%setup%accelerometer_axes))
                call append(estimate%findings, 'columns of ACC1A are exchanged, '//join('lin_accl_'//AXES(pack(columns, &
                            calibration%order /= [1, 2, 3])), ', ')//': with accelerometer x, y, z from those of '// &
                            join(AXES(columns(calibration%order)), ', ')//' all axes follow air and light along the orbit, '// &
                            'from those of '//join(AXES(columns), ', ')//' they do not; correct the file')
            end associate
            return
        end if
        call say_exchange(estimate%arcs, calibration%has_angular, shifted)
        if (shifted == '') call say_shift(estimate%arcs, calibration%has_angular, shifted)
        if (shifted == '' .and. calibration%has_angular) call say_jump(estimate, calibration%before, shifted)
        if (shifted /= '') then     ! what follows would blame signs, axes, gains
            call append(estimate%findings, shifted)
            return
        end if
        if (calibration%poles_apart > LEAST_TURN) then
            call append(estimate%findings, 'GNV1B and GNI1B do not belong together: by them the pole of the Earth is '// &
                        trim(rounded_text(calibration%poles_apart/DEGREE, 2))//' deg from where it is; tags that are 18 s '// &
                        'apart make 1.2 deg, a sign or a column more')
            return
        end if
        do k = 1, 3
            if (.not. estimate%rods%driven(k)) cycle
            if (estimate%rods%gain(k) < 0) call append(estimate%findings, 'wrong sign of rod '//AXES(k)// &
                ': the attitude gives it a gain of '//trim(rounded_text(estimate%rods%gain(k)*calibration%setup%rod_gain(k), 4))// &
                ' A m^2/mA; check rod_sign, or the sign of its currents')
        end do
        if (all(abs(estimate%rods%gain) < HARDLY .or. .not. estimate%rods%driven)) call append(estimate%findings, 'the '// &
            'currents do not explain the attitude: B currents with the wrong sign, currents or attitude of another '// &
            'satellite or another time')
        call look_along_orbit(calibration, estimate)
        if (calibration%has_angular) call look_for_stuck_rods(calibration, estimate)
        before = size(estimate%findings)
        if (calibration%has_angular) call check_axes(calibration%setup%accelerometer_axes, estimate)
        associate (correction => calibration%clock_correction)
            ! the delay of channels that do not follow the torque says nothing
            if (size(estimate%findings) == before .and. abs(correction) > LEAST_CORRECTION .and. &
                estimate%accelerometer_delay_sigma > 0 .and. estimate%accelerometer_delay_sigma < CERTAIN) then
                if (abs(estimate%accelerometer_delay + correction) < WITHIN + 2*estimate%accelerometer_delay_sigma) &
                    call append(estimate%findings, 'tags left in OBC time: the accelerometer lags by '// &
                                trim(milliseconds(estimate%accelerometer_delay))//' ms, which is the clock correction of '// &
                                trim(milliseconds(correction))//' ms that its tags lack')
                if (abs(estimate%accelerometer_delay - correction) < WITHIN + 2*estimate%accelerometer_delay_sigma) &
                    call append(estimate%findings, 'tags of ACC1A are in GPS time already, though they say OBC time: the '// &
                                'accelerometer is ahead by the clock correction, '//trim(milliseconds(correction))//' ms')
            end if
            if (abs(correction) > LEAST_CORRECTION .and. estimate%rods%delay_sigma < CERTAIN .and. &
                abs(estimate%rods%delay - correction) < WITHIN + 2*estimate%rods%delay_sigma) &
                call append(estimate%findings, 'tags left in OBC time: the torque is ahead of the currents by '// &
                            trim(milliseconds(-estimate%rods%delay))//' ms, the clock correction that the tags of the '// &
                            'currents lack')
        end associate
        if (.not. estimate%steps .and. estimate%rods%delay < -max(LEAST_CORRECTION, 5*estimate%rods%delay_sigma)) &
            call append(estimate%remarks, 'the torque is ahead of the currents by '//trim(milliseconds(-estimate%rods%delay))// &
                        ' ms, which no rod can be: tags left in OBC time, or a clock correction that does not hold')
        if (calibration%zero_angular) call append(estimate%findings, 'transplanted data (ACT) in place of ACC1A: all angular '// &
            'accelerations about an axis are zero, and the linear ones may be those of the other satellite')
    end subroutine name_faults

    !> Names what all spans together show, where their samples are not wrong: that the offset moves, or the setup is contradicted.
    subroutine look_over_spans(calibration, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(inout) :: estimate

        integer :: k

        associate (moved => estimate%movement)
            if (moved%kind /= 'none' .and. calibration%all_day .and. size(estimate%findings) == 0) &
                call append(estimate%findings, 'the offset is not the same all the time: '//trim(movement_words(moved))// &
                            '; in the end it is '//trim(axis_words(moved%offset/MILLIMETRE, &
                                                                   sqrt([(moved%covariance(k, k), k=1, 3)])/MILLIMETRE))//' mm')
        end associate
        k = count(estimate%disturbed)
        if (k > 0) call append(estimate%remarks, integer_text(k)//' of '//integer_text(size(estimate%disturbed))// &
                               ' arcs are disturbed: their noise is larger than that of the others, and they count less')
        if (size(estimate%findings) == 0) call look_at_beliefs(calibration, estimate)
        associate (moved => estimate%movement)      ! what else is wrong may look like it
            if (moved%kind /= 'none' .and. size(estimate%findings) == 0) call append(estimate%findings, 'd changes by '// &
                trim(axis_words(moved%change/MICROMETRE, moved%sigma/MICROMETRE))//' um between span '// &
                integer_text(estimate%span_of(moved%behind))//' and span '//integer_text(estimate%span_of(moved%behind + 1))// &
                ': were masses moved?')
        end associate
        if (.not. calibration%all_day .and. size(estimate%findings) == 0) then      ! what is wrong may be as smooth
            if (is_smoothed(estimate)) call append(estimate%findings, 'samples of ACC1A hardly differ from their neighbours: '// &
                'smoothed ones make the offset too small; take ACC1A as it was recorded')
        end if
    end subroutine look_over_spans

    !> Currents that read zero, or one value, in a part of a span in which the satellite goes on as if the rod was driven: what
    !> the angular channels show beside the torque of all rods is as large there as the rod's torque in the rest, and small in the
    !> rest. Rods that are so together are told together.
    subroutine look_for_stuck_rods(calibration, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(inout) :: estimate

        ! Chosen: two spoiled days (four60, dirty) are told, 18 sound ones are not
        real(dp), parameter :: SHORTEST = 5         ! s
        real(dp), parameter :: SAME = 1e-3_dp       ! Of the largest moment
        real(dp), parameter :: LIKE = 0.5_dp        ! Of the rod's own
        real(dp), parameter :: CLEARLY = 3          ! Times what is left in the rest
        type(torque_rods_t) :: one
        real(dp), allocatable :: left(:, :), own(:, :)
        logical, allocatable :: inside(:)
        logical :: stuck(3), together(3)
        real(dp) :: first(3), last(3), value(3), largest
        integer :: i, k

        do i = 1, size(estimate%arcs)
            associate (arc => estimate%arcs(i), times => estimate%arcs(i)%accelerometer_time, &
                       rods => estimate%arcs(i)%knowledge%rods)
                left = arc%angular_acceleration - rod_accelerations(arc, rods, times, .true.)
                stuck = .false.
                do k = 1, 3
                    one = rods
                    one%gain(pack([1, 2, 3], [1, 2, 3] /= k)) = 0
                    largest = maxval(abs(one%measured%moment(k, :)))
                    call longest_standstill(one%measured%time, one%measured%moment(k, :), SAME*largest, times(1), &
                                            times(size(times)), first(k), last(k), value(k))
                    if (last(k) - first(k) < SHORTEST .or. .not. largest > 0) cycle
                    value(k) = value(k)/largest
                    own = rod_accelerations(arc, one, times, .true.)
                    inside = times >= first(k) .and. times <= last(k)
                    if (count(.not. inside) < count(inside)/10 + 10) cycle
                    stuck(k) = scatter(left, inside) > max(LIKE*scatter(own, .not. inside), CLEARLY*scatter(left, .not. inside))
                end do
                do k = 1, 3
                    together = stuck .and. abs(first - first(k)) < 1 .and. abs(last - last(k)) < 1 .and. &
                        (abs(value) <= SAME .eqv. abs(value(k)) <= SAME)
                    if (.not. stuck(k) .or. findloc(together, .true., 1) < k) cycle
                    call append(estimate%findings, 'the currents of rod '//trim(listed_axes(together))//' '// &
                        pick_text(abs(value(k)) <= SAME, 'read zero', 'stay at one value')//' from '// &
                        trim(rounded_text(first(k), 3))//' to '//trim(rounded_text(last(k), 3))//' s of '// &
                        trim(name_of_span(calibration, estimate%span_of(i)))//', but the satellite turns as if the rod was '// &
                        'driven: currents are missing; correct the file, or give the spans without that part')
                end do
            end associate
        end do
    end subroutine look_for_stuck_rods

    !> The longest part between two times in which all samples are the same; first = last: none.
    pure subroutine longest_standstill(times, samples, same, start, stop_time, first, last, value)
        real(dp), intent(in) :: times(:), start, stop_time      !! s
        real(dp), intent(in) :: samples(:), same        !! What differs by less is the same
        real(dp), intent(out) :: first, last            !! s
        real(dp), intent(out) :: value                  !! The samples there

        integer :: j, since

        first = start
        last = start
        value = 0
        since = 1
        do j = 1, size(times)
            if (times(j) < start .or. times(j) > stop_time) cycle
            if (times(since) < start .or. abs(samples(j) - samples(since)) > same) since = j
            if (times(j) - times(since) <= last - first) cycle
            first = times(since)
            last = times(j)
            value = samples(since)
        end do
    end subroutine longest_standstill

    !> How far some samples of a vector lie about their middle: medians, for spikes may be among them.
    pure real(dp) function scatter(samples, counted)
        real(dp), intent(in) :: samples(:, :)           !! (3, n)
        logical, intent(in) :: counted(:)               !! (n)

        real(dp) :: squares(count(counted)), chosen(count(counted))
        integer :: axis

        squares = 0
        do axis = 1, 3
            chosen = pack(samples(axis, :), counted)
            squares = squares + (chosen - median_of(chosen))**2
        end do
        scatter = sqrt(median_of(squares))
    end function scatter

    !> Signs and unit of the linear accelerations, the mass by which light acts on them, and the tags of the orbit.
    subroutine look_along_orbit(calibration, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(inout) :: estimate

        real(dp), parameter :: LARGEST = 10*MILLIMETRE      ! No satellite of these missions has such an offset
        real(dp), parameter :: MOST = 3                     ! What light may be off, either way: surfaces are hardly known
        real(dp), parameter :: SIGMAS = 3, CERTAIN = 5      ! Chosen: light is seen at all
        real(dp), parameter :: CLEARLY = 1.3_dp             ! Chosen: tags explain 1.02 times, a turn of the attitude 1.8 times
        real(dp), parameter :: GYRATION(2) = [0.15_dp, 2.0_dp]      ! Least and greatest radius, m, chosen: GRACE has 0.9
        real(dp) :: radius
        character(:), allocatable :: by_orbit, by_setup     ! What explains the field
        integer :: k

        radius = sqrt(maxval(calibration%setup%inertia)/calibration%setup%mass)
        if (radius < GYRATION(1) .or. radius > GYRATION(2)) then
            call append(estimate%findings, 'mass ('//trim(rounded_text(calibration%setup%mass, 4))//' kg) and moments of '// &
                        'inertia are not of one such satellite: a radius of gyration of '//trim(rounded_text(radius, 2))// &
                        ' m; that of GRACE is 0.9 m')
            return      ! the unit of what light does is by the mass
        end if
        if (all(calibration%follows(:2) < 0) .and. calibration%follows(3) >= 0) call append(estimate%findings, &
            'accelerometer x and y follow air and light along the orbit with the opposite sign: ACC1A is of the other '// &
            'satellite, which flies the other way round, or setup or columns turn it by 180 deg about z')
        do k = 1, 3
            if (calibration%follows(k) < 0) call append(estimate%findings, 'sign of accelerometer '//AXES(k)//': along the '// &
                'orbit it follows air and light with the opposite sign; check accelerometer_axes, or the sign of its column')
        end do
        associate (seen => calibration%light_seen, known => &
                   calibration%light_seen(2, :) > 0 .and. abs(calibration%light_seen(1, :)) > CERTAIN*calibration%light_seen(2, :))
            if (any(known)) then
                k = minloc(seen(2, :)/max(abs(seen(1, :)), tiny(1.0_dp)), 1, mask=known)
                if (abs(seen(1, k)) + SIGMAS*seen(2, k) < 1/MOST .or. abs(seen(1, k)) - SIGMAS*seen(2, k) > MOST) &
                    call append(estimate%findings, 'unit of the linear accelerations: along the orbit light is '// &
                                trim(rounded_text(abs(seen(1, k)), 2))//' times what it makes in m/s^2 (accelerometer '// &
                                AXES(k)//'; in g it would be 0.1 times, in um/s^2 a million times)')
            end if
        end associate
        if (maxval(abs(estimate%solutions(1)%offset)) > LARGEST) call append(estimate%findings, 'an offset of '// &
            trim(rounded_text(maxval(abs(estimate%solutions(1)%offset))/MILLIMETRE, 3))//' mm is none of these satellites '// &
            '(at most 10 mm): check the unit of the linear accelerations, mass and inertia')
        if (.not. abs(calibration%orbit_delay) > 0) return
        by_orbit = 'tags of the orbit are '//trim(rounded_text(calibration%orbit_delay, 2))//' s off by the field that the '// &
            'magnetometer sees along it: GPS time less UTC is 18 s since 2017, 13 to 17 s before'
        if (is_contradicted(estimate%solutions(1))) then
            associate (report => estimate%solutions(1)%beliefs)
                call say_contradiction(report, by_setup)
                if (size(report%explanations) > 0) then     ! tags of the orbit look like those of the field
                    if (maxval(abs(report%values%score)) > &
                        CLEARLY*maxval(abs(report%values%score), mask=report%values%belief == FIELD_DELAY)) then
                        by_orbit = by_setup//'; or '//by_orbit
                    else
                        by_orbit = by_orbit//'; or '//by_setup
                    end if
                end if
            end associate
        end if
        call append(estimate%findings, by_orbit)
    end subroutine look_along_orbit

    !> What the samples contradict where no cause has a name: a fault if the offset would be another by more than sources may
    !> differ, nothing explains all, the rods' gain is contradicted, or a rod has no currents.
    subroutine look_at_beliefs(calibration, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(inout) :: estimate

        character(:), allocatable :: text
        real(dp) :: shift
        logical :: gain     ! Of the rods, by the inertia: then the mass is doubtful, too
        integer :: i, k

        do i = 1, size(estimate%solutions)
            if (.not. is_contradicted(estimate%solutions(i))) cycle
            if (any(silent_rods(calibration))) then
                call append(estimate%findings, 'all currents of rod '//trim(listed_axes(silent_rods(calibration)))// &
                            ' are zero, and the others do not explain how the satellite turns: its currents are missing; '// &
                            'take a file that has them, such as MAG1A')
                cycle
            end if
            associate (report => estimate%solutions(i)%beliefs)
                call say_contradiction(report, text)
                shift = 0
                gain = .false.
                do k = 1, size(report%values)
                    if (abs(report%values(k)%score) <= report%critical) cycle
                    shift = max(shift, maxval(abs(report%values(k)%shift)))
                    if (report%values(k)%state /= CONTRADICTED) cycle
                    gain = gain .or. report%values(k)%belief == ROD_GAIN .and. &
                        all(abs(estimate%rods%gain - 1) > calibration%setup%gain_sigma .or. .not. estimate%rods%driven)
                end do
                do k = 1, size(report%explanations)
                    shift = max(shift, maxval(abs(report%explanations(k)%offset - estimate%solutions(i)%offset)))
                end do
                if (gain .and. shift <= CLOSE_ENOUGH) then
                    call append(estimate%findings, text//'; d hardly moves by it, but trims are by the mass: correct '// &
                                'rod_gain, or mass and inertia if they are of another satellite')
                else if (shift > CLOSE_ENOUGH .or. .not. any(report%explanations%complete)) then     ! what is wrong is not known
                    call append(estimate%findings, text)
                else
                    call append(estimate%remarks, text//'; the offset would move by at most '// &
                                trim(rounded_text(shift/MICROMETRE, 2))//' um')
                end if
            end associate
        end do
    end subroutine look_at_beliefs

    !> Whether the offset is within the requirement, for people, with blanks behind it: by axis.
    pure function offset_remark(offset) result(text)
        real(dp), intent(in) :: offset(3)   !! d, m
        character(80) :: text

        integer :: k

        text = ''
        do k = 1, 3
            if (abs(offset(k)) > REQUIREMENT) text = trim(text)//' '//AXES(k)
        end do
        if (text == '') then
            text = 'the offset is below 0.1 mm on every axis'
        else
            text = 'the offset is above 0.1 mm on'//trim(text)
        end if
    end function offset_remark

    !> Whether the angular channels follow the torque in the axes that the setup says, and in their unit.
    subroutine check_axes(said, estimate)
        integer, intent(in) :: said(3)      !! accelerometer_axes of the setup
        type(level1_estimate_t), intent(inout) :: estimate

        real(dp), parameter :: HARDLY = 0.3_dp, CLEARLY = 0.3_dp, MOST = 3
        type(torque_rods_t) :: rods
        real(dp) :: correlation(3, 3), product(3, 3), seen(3), acted(3), best, given, score
        real(dp), allocatable :: angular(:, :), torque(:, :)
        integer :: i, k, axis, chosen, axes_found(3)

        product = 0
        seen = 0
        acted = 0
        do i = 1, size(estimate%arcs)
            associate (arc => estimate%arcs(i))
                rods = arc%knowledge%rods
                rods%gain = estimate%rods%gain
                rods%delay = estimate%rods%delay + estimate%accelerometer_delay
                angular = arc%angular_acceleration
                torque = rod_accelerations(arc, rods, arc%accelerometer_time, .true.)
            end associate
            do axis = 1, 3
                angular(axis, :) = angular(axis, :) - sum(angular(axis, :))/size(angular, 2)
                torque(axis, :) = torque(axis, :) - sum(torque(axis, :))/size(torque, 2)
            end do
            product = product + matmul(torque, transpose(angular))
            seen = seen + sum(angular**2, 2)
            acted = acted + sum(torque**2, 2)
        end do
        do axis = 1, 3
            correlation(:, axis) = product(:, axis)/sqrt(max(acted*seen(axis), tiny(1.0_dp)))
        end do
        given = sum([(correlation(k, k), k=1, 3)])/3
        best = given
        chosen = 1
        do i = 1, size(ORDERS, 2)
            score = sum([(abs(correlation(k, ORDERS(k, i))), k=1, 3)])/3
            if (score > best + epsilon(best)) then
                best = score
                chosen = i
            end if
        end do
        if (best < HARDLY) then
            call append(estimate%findings, 'the accelerometer does not show the torque of the rods: data of the other '// &
                        'satellite (transplanted ACT), or of another time')
        else if (best > given + CLEARLY) then
            axes_found = [(nint(sign(1.0_dp, correlation(k, ORDERS(k, chosen))))*said(ORDERS(k, chosen)), k=1, 3)]
            call append(estimate%findings, 'axes of the accelerometer are wrong (AF taken as SRF): its angular channels '// &
                        'follow the torque with accelerometer_axes = '//trim(axes_text(axes_found))//', not '// &
                        trim(axes_text(said)))
        else
            seen = [(product(k, k)/max(acted(k), tiny(1.0_dp)), k=1, 3)]
            k = maxloc(abs(seen), 1)
            if (seen(k) > MOST .or. seen(k) < 1/MOST) call append(estimate%findings, 'unit of the angular accelerations: '// &
                'about '//AXES(k)//' they are '//trim(rounded_text(seen(k), 3))//' times what the rods make in rad/s^2 (in '// &
                'deg/s^2 it would be 57 times)')
        end if
    end subroutine check_axes

    !> Three axes as in the setup, with blanks behind them.
    pure function axes_text(numbers) result(text)
        integer, intent(in) :: numbers(3)
        character(40) :: text

        text = integer_text(numbers(1))//', '//integer_text(numbers(2))//', '//integer_text(numbers(3))
    end function axes_text

    !> Rods without any current.
    pure function silent_rods(calibration) result(silent)
        type(level1_calibration_t), intent(in) :: calibration
        logical :: silent(3)

        silent = .not. any(abs(calibration%current) > 0, 2)
    end function silent_rods

    !> Does a test of what the setup says fail, however little the offset would move?
    pure logical function is_contradicted(solution)
        type(level1_solution_t), intent(in) :: solution

        is_contradicted = allocated(solution%beliefs)
        if (is_contradicted) is_contradicted = solution%beliefs%has_contradiction()
    end function is_contradicted

    !> Whether what the fit leaves of two axes of the accelerometer changes as little from sample to sample as means over some
    !> samples do: the squares of second differences are six times those of white noise. The rods' lines, too, are smaller in means.
    !> Of samples without noise nothing is said.
    pure logical function is_smoothed(estimate)
        type(level1_estimate_t), intent(in) :: estimate

        real(dp), parameter :: LITTLE = 0.35_dp     ! Chosen: three sound simulated days have 1.4 to 1.7, ten seconds of
                                                    ! GRACE-C (2023-06-01) 1.0 to 1.8; means of 1 s 0.22, 0.3
        real(dp), parameter :: NO_NOISE = 1e-11_dp  ! m/s^2, chosen: less is what the model leaves
        real(dp) :: squares(3), differences(3)
        integer :: i, k, n

        squares = 0
        differences = 0
        n = 0
        do i = 1, size(estimate%residuals)
            associate (left => estimate%residuals(i)%linear, kept => estimate%residuals(i)%kept)
                do k = 2, size(kept) - 1
                    if (.not. all(kept(k - 1:k + 1))) cycle
                    n = n + 1
                    squares = squares + left(:, k)**2
                    differences = differences + (left(:, k - 1) - 2*left(:, k) + left(:, k + 1))**2
                end do
            end associate
        end do
        is_smoothed = count(differences < 6*LITTLE*squares .and. squares > n*NO_NOISE**2) > 1
    end function is_smoothed

    !> Flags of the solutions: 0 good, 1 with care, 2 not to be used.
    subroutine judge(calibration, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_estimate_t), intent(inout) :: estimate

        real(dp), parameter :: SIGMAS = 3
        real(dp), parameter :: USUAL = 2e-7_dp, NOISY = 1e-6_dp     ! Noise of attitude as it is simulated; chosen, rad
        real(dp) :: sigma(3)
        logical :: mixed
        integer :: i

        do i = 1, size(estimate%solutions)
            associate (solution => estimate%solutions(i), first => estimate%solutions(1))
                sigma = sigma_of(solution)
                solution%flag = 0
                if (maxval(sigma) > GOOD_SIGMA) call lower(1, 'sigma above 5 um')
                mixed = solution%leakage == 'a priori' .and. solution%condition > WORST_CONDITION
                if (mixed) call lower(1, 'leakage and d are not separable')
                if (maxval(sigma) > POOR_SIGMA) then
                    call lower(2, 'sigma above 50 um')
                    if (any(silent_rods(calibration))) call lower(2, 'all currents of rod '// &
                        trim(listed_axes(silent_rods(calibration)))//' are zero: if it was driven, take a file that has them, '// &
                        'such as MAG1A; without it sigma is above 50 um')
                    if (any(leakage_sigmas(calibration%setup) < USUAL_LEAKAGE/10)) call lower(2, 'sigma above 50 um: '// &
                        'leakage_prior of the setup says that rods hardly leak, and the samples do not agree (usual are '// &
                        '1e-12 m/s^2/mA and 3e-11 m/s^2/(mA/s))')
                    if (mixed) solution%reason = 'leakage and d are not separable: '//trim(solution%reason)
                end if
                if (is_contradicted(solution)) call lower(1, 'the data contradict the setup')
                if (.not. estimate%settled) call lower(2, 'the fit does not settle'//pick_text(maxval(estimate%head_sigma) > &
                    NOISY, ': the star cameras have a noise of '//trim(rounded_text(maxval(estimate%head_sigma), 2))//' rad, '// &
                    trim(rounded_text(maxval(estimate%head_sigma)/USUAL, 2))//' times the usual of SCA1B', ''))
                if (size(estimate%findings) > 0) call lower(2, 'see what is wrong')
                if (.not. signs_are_known(calibration)) call lower(1, 'sign of the accelerometer not confirmed')
                if (.not. calibration%has_angular) call lower(1, 'the accelerometer has no angular channels')
                if (allocated(solution%beliefs)) then
                    if (any(solution%beliefs%undetected(.true.) > solution%beliefs%wanted)) &
                        call lower(1, 'what no test sees could move the offset')
                end if
                if (any(abs(solution%offset - first%offset) > max(CLOSE_ENOUGH, SIGMAS*hypot(sigma, sigma_of(first))))) then
                    call lower(2, 'disagrees with '//trim(first%source))
                    first%flag = 2
                    first%reason = trim(solution%source)//' disagrees'
                end if
                if (solution%degrees > 0) then
                    if (solution%chi_square > solution%degrees + 5*sqrt(2.0_dp*solution%degrees)) &
                        call lower(2, 'the spans disagree')
                end if
            end associate
        end do

    contains

        subroutine lower(flag, reason)
            integer, intent(in) :: flag
            character(*), intent(in) :: reason

            if (flag <= estimate%solutions(i)%flag .and. flag < 2) return
            estimate%solutions(i)%flag = flag
            estimate%solutions(i)%reason = reason
        end subroutine lower
    end subroutine judge
end module gracecg_level1_judgement
