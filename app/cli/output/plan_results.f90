!> What commands say of planned manoeuvres, for people and as JSON: programmes of several, and the leakage of the rods into
!> the accelerometer (sigma without it and with it estimated, of one flight and of two half a revolution apart).
module gracecg_cli_plan_results
    use gracecg_environment_time, only: utc_t
    use gracecg_files_json, only: json_writer_t
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, WAVEFORM_NAMES
    use gracecg_simulation_case, only: case_t
    use gracecg_planning_leakage, only: leakage_pair_t
    use gracecg_planning_programme, only: candidate_t, programme_t
    use gracecg_cli_work
    implicit none
    private
    public :: rods_table, add_programme, add_leakage

contains

    !> The activations of the rods, or of torquers; with an epoch their times in UTC, too.
    function rods_table(rods, epoch) result(table)
        type(torque_rods_t), intent(in) :: rods
        type(utc_t), intent(in), optional :: epoch      !! From which the times count
        type(data_table_t) :: table

        integer :: i

        call table%column('axis', 'a', 'rod')
        call table%column('waveform', 'a', 'waveform')
        if (rods%direct) call table%column('amplitude_n_m', 'es17.3', 'amplitude, N m')
        if (.not. rods%direct) call table%column('amplitude_a_m2', 'f17.3', 'amplitude, A m^2')
        call table%column('frequency_hz', 'f15.6', 'frequency, Hz')
        call table%column('phase_deg', 'f12.2', 'phase, deg')
        call table%column('start_s', 'f8.2', 'start')
        call table%column('stop_s', 'f9.2', 'stop, s')
        if (present(epoch)) call table%columns_of('start_utc,stop_utc')
        do i = 1, rods%count
            associate (rod => rods%activations(i))
                call table%add(AXES(rod%axis), WAVEFORM_NAMES(rod%waveform))
                call table%add([rod%amplitude, rod%frequency, rod%phase/DEGREE, rod%start, rod%stop])
                if (present(epoch)) &
                    call table%add(utc_text(utc_plus(epoch, rod%start)), utc_text(utc_plus(epoch, rod%stop)))
            end associate
        end do
    end function rods_table

    !> A programme: a table, and `programme` in JSON.
    subroutine add_programme(candidates, programme, console, json)
        type(candidate_t), intent(in) :: candidates(:)
        type(programme_t), intent(in) :: programme
        type(console_t), intent(inout) :: console
        class(json_writer_t), intent(inout) :: json     !! In an object

        real(dp), parameter :: UNSEEN = 1e3_dp      ! m: beyond, a direction is not seen yet
        type(data_table_t) :: table
        integer :: i, axis

        call console%line('')
        call console%line('programme of '//integer_text(size(programme%chosen))//' manoeuvre'// &
                          trim(merge('s', ' ', size(programme%chosen) > 1))//', in the order of flight')
        call table%column('time_s', 'i8', 'time|s')
        call table%column('duration_s', 'f8.1', 'length|s')
        call table%column('latitude_deg', 'f8.1', 'lat.|deg')
        call table%column('longitude_deg', 'f8.1', 'long.|deg')
        call axis_columns(table, 'sigma_', '_mm', 'f9.5', 'sigma, mm')
        do i = 1, size(programme%chosen)
            associate (candidate => candidates(programme%chosen(i)))
                call table%add([anint(candidate%time), candidate%duration, [candidate%latitude, candidate%longitude]/DEGREE])
            end associate
            do axis = 1, 3
                call table%add(programme%sigma(axis, i)/MILLIMETRE, programme%sigma(axis, i) < UNSEEN)
            end do
        end do
        call console%table(table)
        call console%line('(sigma of all manoeuvres up to this one together, by information)')
        call table%to_json(json, 'programme')
    end subroutine add_programme

    !> The leakage of the rods, and `leakage` in JSON.
    subroutine add_leakage(pair, case, console, json)
        type(leakage_pair_t), intent(in) :: pair
        type(case_t), intent(in) :: case    !! Whose epoch the time counts from
        type(console_t), intent(inout) :: console
        class(json_writer_t), intent(inout) :: json     !! In an object

        call console%line('')
        call console%line('leakage of the rods into the accelerometer, sigma in mm:    left out          estimated')
        call json%begin('leakage')
        call add('one flight                       ', '', pair%without, pair%with)
        if (pair%pair_with(1) < huge(1.0_dp)) then
            call add('and one half a revolution away   ', 'pair_', pair%pair_without, pair%pair_with)
            call console%paragraph('the second flight: '//utc_text(utc_plus(case%epoch, anint(pair%time)))//' UTC, '// &
                                   integer_text(nint(pair%time))//' s after the epoch ('// &
                                   trim(place_text(pair%latitude, 'N', 'S'))//', '//trim(place_text(pair%longitude, 'E', 'W'))// &
                                   '), where the field is '//integer_text(nint(acos(max(-1.0_dp, min(1.0_dp, pair%opposite)))/ &
                                   DEGREE))//' deg away in body axes. Leakage that is estimated has the a-priori sigmas of '// &
                                   'level1 estimate.')
            call json%member('pair_time_s', pair%time)
            call json%member('pair_latitude_deg', pair%latitude/DEGREE)
            call json%member('pair_longitude_deg', pair%longitude/DEGREE)
        end if
        call json%end()

    contains

        subroutine add(name, key, without, with)
            character(*), intent(in) :: name, key       !! For people, and in JSON before sigma_
            real(dp), intent(in) :: without(3), with(3)     !! m

            character(100) :: line

            write (line, '(a, 2(3f9.4, 4x))') name, min(without/MILLIMETRE, 999.0_dp), min(with/MILLIMETRE, 999.0_dp)
            call console%line(trim(line))
            if (all(without < huge(1.0_dp))) call json%member(key//'sigma_without_mm', without/MILLIMETRE)
            if (all(with < huge(1.0_dp))) call json%member(key//'sigma_with_mm', with/MILLIMETRE)
        end subroutine add
    end subroutine add_leakage

    function place_text(angle, positive, negative) result(text)
        real(dp), intent(in) :: angle               !! rad
        character(1), intent(in) :: positive, negative
        character(7) :: text

        write (text, '(f5.1, 1x, a1)') abs(angle)/DEGREE, merge(positive, negative, angle >= 0)
        text = adjustl(text)
    end function place_text
end module gracecg_cli_plan_results
