!> The groups of a namelist file that truth and knowledge of a satellite have in common: a case file states
!> with them how the satellite is, `setup.nml` what its operator believes.
module gracecg_spacecraft_settings
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE
    use gracecg_base_error, only: error_t
    use gracecg_files_settings, only: settings_t
    use gracecg_environment_time, only: utc_t, parse_utc, utc_text
    use gracecg_spacecraft_motion_limits, only: motion_limits_t
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_activation_t, new_torque_rods, take_manoeuvre, &
        MAX_ACTIVATIONS, WAVEFORM_NAMES, PATTERN_RULES
    implicit none
    private
    public :: describe_calibration, describe_mass_properties, describe_manoeuvre, describe_limits

contains

    !> Name and time of a calibration: group calibration.
    subroutine describe_calibration(settings, name, epoch, duration, pattern_rule)
        class(settings_t), intent(inout) :: settings
        character(*), intent(inout) :: name     !! Of the calibration
        type(utc_t), intent(inout) :: epoch     !! Time 0
        real(dp), intent(inout) :: duration     !! Of the arc, s
        character(*), intent(inout), optional :: pattern_rule  !! By which `timing` chooses the rods

        character(40) :: text
        type(error_t), allocatable :: problem

        text = utc_text(epoch)
        call settings%group('calibration', 'The calibration: arc and time')
        call settings%text_value('name', name, 'of the calibration')
        call settings%text_value('epoch', text, 'UTC, ISO 8601: time 0 of all time tags', required=.true.)
        call parse_utc(trim(text), epoch, problem)
        if (allocated(problem)) call settings%reject('epoch', problem%message)
        call settings%real_value('duration', duration, 1.0_dp, 86400.0_dp, 's, length of the arc', unit='s')
        if (present(pattern_rule)) call settings%text_value('pattern', pattern_rule, &
            'rule by which timing chooses the rods: y and z, or the two weaker components of the field', PATTERN_RULES)
        call settings%end_group()
    end subroutine describe_calibration

    !> Mass and inertia: group mass_properties.
    subroutine describe_mass_properties(settings, mass, inertia, mass_may_lack)
        class(settings_t), intent(inout) :: settings
        real(dp), intent(inout) :: mass             !! kg
        real(dp), intent(inout) :: inertia(3, 3)    !! J_p about the proof-mass centre, kg m^2
        logical, intent(in), optional :: mass_may_lack      !! The mass need not be said; absent: it has to be

        real(dp) :: moments(3), products(3)

        moments = [inertia(1, 1), inertia(2, 2), inertia(3, 3)]
        products = [inertia(1, 2), inertia(2, 3), inertia(1, 3)]
        call settings%group('mass_properties', 'Mass, and inertia about the proof-mass centre')
        call settings%real_value('mass', mass, 1e-3_dp, 1e6_dp, 'kg', unit='kg', required=.not. present(mass_may_lack))
        call settings%real_values('moments_of_inertia', moments, 1e-6_dp, 1e9_dp, &
                                  'Ixx, Iyy, Izz in kg m^2', unit='kg m^2', required=.true.)
        call settings%real_values('products_of_inertia', products, -1e9_dp, 1e9_dp, &
                                  'Ixy, Iyz, Izx in kg m^2, with the sign of Ixy = -integral of x y dm', &
                                  unit='kg m^2')
        call settings%end_group()
        inertia = reshape([moments(1), products(1), products(3), &
                           products(1), moments(2), products(2), &
                           products(3), products(2), moments(3)], [3, 3])
    end subroutine describe_mass_properties

    !> The rods and what they are driven through: group rods, and one group rod for each activation.
    subroutine describe_manoeuvre(settings, rods)
        class(settings_t), intent(inout) :: settings
        type(torque_rods_t), intent(inout) :: rods

        type(rod_activation_t) :: activations(MAX_ACTIVATIONS)
        type(torque_rods_t) :: driven
        type(error_t), allocatable :: problem
        character(len(WAVEFORM_NAMES)) :: waveform
        integer :: n, i

        call settings%group('rods', 'The torque rods themselves, x, y, z: moment = gain commanded moment')
        call settings%real_value('largest_moment', rods%largest_moment, 1e-3_dp, 1e4_dp, 'A m^2, that each rod bears', &
                                 unit='A m^2')
        call settings%real_values('gain', rods%gain, -10.0_dp, 10.0_dp, 'of each rod')
        call settings%real_values('misalignment_deg', rods%misalignment, -180.0_dp, 180.0_dp, 'deg, turns of the '// &
                                  'x rod about y and z, of the y rod about z and x, of the z rod about x and y', &
                                  DEGREE, 'deg')
        call settings%real_values('delay', rods%delay, -10.0_dp, 10.0_dp, 's, from command to moment', unit='s')
        call settings%end_group()
        n = rods%count
        activations = rods%activations
        call settings%count('rod', n)
        if (n > MAX_ACTIVATIONS) then
            call settings%group('rod', '', MAX_ACTIVATIONS + 1)
            call settings%reject('axis', 'at most 16 groups &rod are allowed')
            return
        end if
        do i = 1, n
            call settings%group('rod', 'Magnetic moment amplitude w(2 pi frequency (t - start) + phase)', i)
            call settings%integer_value('axis', activations(i)%axis, 1, 3, 'body axis: 1 x, 2 y, 3 z')
            call settings%real_value('amplitude', activations(i)%amplitude, -1e4_dp, 1e4_dp, &
                                     'A m^2', unit='A m^2', required=.true.)
            call settings%real_value('frequency', activations(i)%frequency, 0.0_dp, 10.0_dp, 'Hz', &
                                     unit='Hz', required=.true.)
            call settings%real_value('phase_deg', activations(i)%phase, -360.0_dp, 360.0_dp, 'deg', &
                                     DEGREE, 'deg')
            call settings%real_value('start', activations(i)%start, 0.0_dp, 86400.0_dp, 's', unit='s')
            call settings%real_value('stop', activations(i)%stop, 0.0_dp, 86400.0_dp, 's', unit='s', &
                                     required=.true.)
            waveform = WAVEFORM_NAMES(activations(i)%waveform)
            call settings%text_value('waveform', waveform, 'w', WAVEFORM_NAMES)
            activations(i)%waveform = max(1, findloc(WAVEFORM_NAMES, waveform, 1))
            call settings%real_value('taper', activations(i)%taper, 0.0_dp, 86400.0_dp, &
                                     's, of a smooth start and stop; 0: abrupt', unit='s')
            call settings%real_value('rise_time', activations(i)%rise_time, 0.0_dp, 86400.0_dp, &
                                     's, of each edge of a square wave', unit='s')
            if (allocated(settings%failure)) return
            call new_torque_rods(driven, activations(:i), problem, rods%largest_moment)
            if (allocated(problem)) call settings%reject('amplitude', problem%message)
            call settings%end_group()
        end do
        call take_manoeuvre(driven, rods)
    end subroutine describe_manoeuvre

    !> What a manoeuvre may do: group limits.
    subroutine describe_limits(settings, limits)
        class(settings_t), intent(inout) :: settings
        type(motion_limits_t), intent(inout) :: limits

        call settings%group('limits', 'What the manoeuvre may do to the satellite')
        call settings%real_value('rate_deg_s', limits%rate, 1e-6_dp, 1e3_dp, &
                                 'deg/s, angular velocity about any axis (star cameras)', DEGREE, 'deg/s')
        call settings%real_value('pointing_deg', limits%pointing, 1e-6_dp, 180.0_dp, &
                                 'deg, turn away from the attitude held without a manoeuvre', DEGREE, 'deg')
        call settings%end_group()
    end subroutine describe_limits
end module gracecg_spacecraft_settings
