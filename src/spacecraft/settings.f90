!> The groups of a namelist file that truth and knowledge of a satellite have in common: a case file states
!> with them how the satellite is, `setup.nml` what its operator believes.
module gracecg_spacecraft_settings
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: rounded_text
    use gracecg_files_settings, only: settings_t
    use gracecg_environment_time, only: utc_t, parse_utc, utc_text
    use gracecg_spacecraft_motion_limits, only: motion_limits_t
    use gracecg_spacecraft_rod_pattern, only: PATTERN_RULES
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_activation_t, new_torque_rods, take_manoeuvre, &
        MAX_ACTIVATIONS, WAVEFORM_NAMES
    use gracecg_spacecraft_moment_series, only: new_moment_series
    use gracecg_files_table, only: table_file_t, read_csv
    implicit none
    private
    public :: describe_calibration, describe_mass_properties, describe_manoeuvre, describe_limits, TORQUE_COLUMNS

    character(8), parameter :: TORQUE_COLUMNS(4) = [character(8) :: 'time_s', 'tx_n_m', 'ty_n_m', 'tz_n_m']
    !! Of a torque history, body axes
    real(dp), parameter :: GREATEST_TORQUE = 1      !! Of torquers, unless stated, N m

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
            'how timing takes the rods: y and z, or by the two weaker components of the field, or as driven', PATTERN_RULES)
        call settings%end_group()
    end subroutine describe_calibration

    !> Mass and inertia: group mass_properties.
    subroutine describe_mass_properties(settings, mass, inertia, mass_may_lack)
        class(settings_t), intent(inout) :: settings
        real(dp), intent(inout) :: mass             !! kg
        real(dp), intent(inout) :: inertia(3, 3)    !! J_p about the proof-mass centre, kg m^2
        logical, intent(in), optional :: mass_may_lack      !! The mass need not be said; absent: it has to be

        real(dp), parameter :: WIDEST = 10, NARROWEST = 0.01_dp     ! Radius of gyration of any satellite, m
        real(dp) :: moments(3), products(3), radius

        moments = [inertia(1, 1), inertia(2, 2), inertia(3, 3)]
        products = [inertia(1, 2), inertia(2, 3), inertia(1, 3)]
        call settings%group('mass_properties', 'Mass, and inertia about the proof-mass centre')
        call settings%real_value('mass', mass, 1e-3_dp, 1e6_dp, 'kg', unit='kg', required=.not. present(mass_may_lack))
        call settings%real_values('moments_of_inertia', moments, 1e-6_dp, 1e9_dp, &
                                  'Ixx, Iyy, Izz in kg m^2', unit='kg m^2', required=.true.)
        call settings%real_values('products_of_inertia', products, -1e9_dp, 1e9_dp, &
                                  'Ixy, Iyz, Izx in kg m^2, with the sign of Ixy = -integral of x y dm', &
                                  unit='kg m^2')
        radius = 0
        if (mass > 0) radius = sqrt(max(0.0_dp, maxval(moments))/mass)
        if (radius > WIDEST .or. (radius > 0 .and. radius < NARROWEST)) call settings%reject('mass', 'makes a radius of '// &
            'gyration of '//rounded_text(radius, 2)//' m with these moments of inertia; 0.01 to 10 m are allowed: '// &
            'mass is in kg, moments in kg m^2')
        call settings%end_group()
        inertia = reshape([moments(1), products(1), products(3), &
                           products(1), moments(2), products(2), &
                           products(3), products(2), moments(3)], [3, 3])
    end subroutine describe_mass_properties

    !> What turns the satellite: rods, groups rods and rod; or, where a file has group torquers or excitation, torquers.
    subroutine describe_manoeuvre(settings, rods)
        class(settings_t), intent(inout) :: settings
        type(torque_rods_t), intent(inout) :: rods

        if (settings%holds('torquers') .or. settings%holds('excitation')) then
            if (.not. rods%direct) rods%largest_moment = GREATEST_TORQUE
            rods%direct = .true.
        end if
        if (.not. rods%direct) then
            call settings%group('rods', 'The torque rods themselves, x, y, z: moment = gain commanded moment')
            call settings%real_value('largest_moment', rods%largest_moment, 1e-3_dp, 1e4_dp, 'A m^2, that each rod bears', &
                                     unit='A m^2')
            call describe_errors('x rod about y and z, of the y rod about z and x, of the z rod about x and y', 'moment')
            call describe_activations(settings, rods)
            return
        end if
        call settings%group('torquers', 'What turns the satellite in place of rods, about x, y, z: torque = gain commanded torque')
        if (settings%holds('rods') .or. settings%holds('rod')) call settings%reject('gain', &
            'stands beside a group &rods or &rod: a satellite is turned by torquers or by rods; leave one of them out')
        call settings%real_value('largest_torque', rods%largest_moment, 1e-12_dp, 1e4_dp, 'N m, about each axis', unit='N m')
        call describe_errors('x torque about y and z, of the y torque about z and x, of the z torque about x and y', 'torque')
        call describe_activations(settings, rods)

    contains

        !> The rest of the first group: what lies between command and moment.
        subroutine describe_errors(turns, what)
            character(*), intent(in) :: turns, what

            call settings%real_values('gain', rods%gain, -10.0_dp, 10.0_dp, &
                                      trim(merge('of each axis', 'of each rod ', rods%direct)))
            call settings%real_values('misalignment_deg', rods%misalignment, -180.0_dp, 180.0_dp, 'deg, turns of the '//turns, &
                                      DEGREE, 'deg')
            call settings%real_values('delay', rods%delay, -10.0_dp, 10.0_dp, 's, from command to '//what, unit='s')
            if (rods%direct) call describe_history(settings, rods)
            call settings%end_group()
        end subroutine describe_errors
    end subroutine describe_manoeuvre

    !> A torque history in the place of waveforms: key torque_file, in a case.
    subroutine describe_history(settings, rods)
        class(settings_t), intent(inout) :: settings
        type(torque_rods_t), intent(inout) :: rods

        type(table_file_t) :: file
        real(dp), allocatable :: rows(:, :)
        type(error_t), allocatable :: error

        if (rods%torque_file == '' .and. .not. settings%holds('torquers', 'torque_file')) return
        call settings%text_value('torque_file', rods%torque_file, 'CSV file of the torques that are commanded, in place of '// &
                                 'groups excitation')
        if (rods%torque_file == '' .or. allocated(rods%measured%time)) return
        call read_csv(trim(rods%torque_file), TORQUE_COLUMNS, file, error)
        if (.not. allocated(error)) call file%get_numbers(TORQUE_COLUMNS, rows, error)
        if (.not. allocated(error)) call new_moment_series(rows(:, 1), transpose(rows(:, 2:)), rods%measured, error, direct=.true.)
        if (allocated(error) .and. .not. allocated(settings%failure)) call move_alloc(error, settings%failure)
    end subroutine describe_history

    !> What rods or torquers are driven through: one group for each activation.
    subroutine describe_activations(settings, rods)
        class(settings_t), intent(inout) :: settings
        type(torque_rods_t), intent(inout) :: rods

        type(rod_activation_t) :: activations(MAX_ACTIVATIONS)
        type(torque_rods_t) :: driven
        type(error_t), allocatable :: problem
        character(len(WAVEFORM_NAMES)) :: waveform
        character(10) :: group
        character(5) :: unit
        integer :: n, i

        group = merge('excitation', 'rod       ', rods%direct)
        unit = merge('N m  ', 'A m^2', rods%direct)
        n = rods%count
        activations = rods%activations
        call settings%count(trim(group), n)
        if (n > MAX_ACTIVATIONS) then
            call settings%group(trim(group), '', MAX_ACTIVATIONS + 1)
            call settings%reject('axis', 'at most 16 groups &'//trim(group)//' are allowed')
            return
        end if
        do i = 1, n
            if (rods%direct) then
                call settings%group('excitation', 'Torque amplitude w(2 pi frequency (t - start) + phase)', i)
            else
                call settings%group('rod', 'Magnetic moment amplitude w(2 pi frequency (t - start) + phase)', i)
            end if
            call settings%integer_value('axis', activations(i)%axis, 1, 3, 'body axis: 1 x, 2 y, 3 z')
            call settings%real_value('amplitude', activations(i)%amplitude, -1e4_dp, 1e4_dp, trim(unit), unit=trim(unit), &
                                     required=.true.)
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
            call new_torque_rods(activations(:i), driven, problem, rods%largest_moment, rods%direct)
            if (allocated(problem)) call settings%reject('amplitude', problem%message)
            call settings%end_group()
        end do
        driven%measured = rods%measured
        call take_manoeuvre(driven, rods)
    end subroutine describe_activations

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
