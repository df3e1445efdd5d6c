!> What commands say of the leakage of the rods into the accelerometer: sigma without it and with it estimated, of one
!> flight and of two half a revolution apart.
module gracecg_cli_leakage
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE
    use gracecg_base_text, only: integer_text
    use gracecg_environment_time, only: utc_plus, utc_text
    use gracecg_planning_leakage, only: leakage_pair_t
    use gracecg_simulation_case, only: case_t
    use gracecg_cli_console, only: console_t
    use gracecg_cli_results, only: results_t
    implicit none
    private
    public :: show_leakage, put_leakage

contains

    !> For people.
    subroutine show_leakage(pair, case, console)
        type(leakage_pair_t), intent(in) :: pair
        type(case_t), intent(in) :: case    !! Whose epoch the time counts from
        type(console_t), intent(inout) :: console

        call console%line('')
        call console%line('leakage of the rods into the accelerometer, sigma in mm:    left out          estimated')
        call row('one flight                       ', pair%without, pair%with)
        if (pair%pair_with(1) < huge(1.0_dp)) then
            call row('and one half a revolution away   ', pair%pair_without, pair%pair_with)
            call console%paragraph('the second flight: '//utc_text(utc_plus(case%epoch, anint(pair%time)))//' UTC, '// &
                                   integer_text(nint(pair%time))//' s after the epoch ('// &
                                   trim(place_text(pair%latitude, 'N', 'S'))//', '//trim(place_text(pair%longitude, 'E', 'W'))// &
                                   '), where the field is '//turn_text(pair%opposite)//' deg away in body axes. Leakage that '// &
                                   'is estimated has the a-priori sigmas of level1 estimate.')
        end if

    contains

        subroutine row(name, without, with)
            character(*), intent(in) :: name
            real(dp), intent(in) :: without(3), with(3)

            character(100) :: line

            write (line, '(a, 2(3f9.4, 4x))') name, min(without/MILLIMETRE, 999.0_dp), min(with/MILLIMETRE, 999.0_dp)
            call console%line(trim(line))
        end subroutine row
    end subroutine show_leakage

    function place_text(angle, positive, negative) result(text)
        real(dp), intent(in) :: angle               !! rad
        character(1), intent(in) :: positive, negative
        character(7) :: text

        write (text, '(f5.1, 1x, a1)') abs(angle)/DEGREE, merge(positive, negative, angle >= 0)
        text = adjustl(text)
    end function place_text

    function turn_text(cosine) result(text)
        real(dp), intent(in) :: cosine
        character(:), allocatable :: text

        text = integer_text(nint(acos(max(-1.0_dp, min(1.0_dp, cosine)))/DEGREE))
    end function turn_text

    !> For programs: an object `leakage`.
    subroutine put_leakage(pair, results)
        type(leakage_pair_t), intent(in) :: pair
        type(results_t), intent(inout) :: results

        call results%begin('leakage')
        call put('sigma_without_mm', pair%without)
        call put('sigma_with_mm', pair%with)
        if (pair%pair_with(1) < huge(1.0_dp)) then
            call put('pair_sigma_without_mm', pair%pair_without)
            call put('pair_sigma_with_mm', pair%pair_with)
            call results%member('pair_time_s', pair%time)
            call results%member('pair_latitude_deg', pair%latitude/DEGREE)
            call results%member('pair_longitude_deg', pair%longitude/DEGREE)
        end if
        call results%end()

    contains

        subroutine put(name, sigma)
            character(*), intent(in) :: name
            real(dp), intent(in) :: sigma(3)

            if (all(sigma < huge(1.0_dp))) call results%member(name, sigma/MILLIMETRE)
        end subroutine put
    end subroutine put_leakage
end module gracecg_cli_leakage
