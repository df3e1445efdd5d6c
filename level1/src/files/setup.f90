!> What the operator of a satellite says for an estimate from its Level-1 data: groups mass_properties and level1 of
!> a namelist. What no document confirms is a setting here, with its default.
module gracecg_level1_setup
    use gracecg_level1_basics
    use gracecg_files_file, only: text_file_t, text_file_of
    use gracecg_files_settings, only: settings_t
    use gracecg_spacecraft_settings, only: describe_mass_properties
    use gracecg_level1_header, only: name_of
    use gracecg_level1_frames, only: ACCELEROMETER_AXES, signed_axes_valid
    use gracecg_spacecraft_rod_leakage, only: USUAL_ROD_GAIN, USUAL_LEAKAGE
    implicit none
    private
    public :: level1_setup_t, origin_t, read_level1_setup, describe_level1, leakage_sigmas, QUIETEST

    real(dp), parameter :: QUIETEST = 5e-11_dp      !! No accelerometer of these missions is quieter, m/s^2

    type :: origin_t
        !! Where a value that an estimate uses is from
        character(32) :: name = ''              !! Key of the setup, or product
        character(80) :: value = ''             !! As it would stand in the setup
        character(100) :: meaning = ''          !! With its unit
        character(200) :: source = ''           !! File and line, files of a product, default, or how it is estimated
    end type origin_t

    type :: level1_setup_t
        !! Knowledge of the satellite, and limits for the data
        type(origin_t), allocatable :: origins(:)       !! Of all that follows, where it was read
        real(dp) :: mass = 0                    !! kg; 0: not said
        real(dp) :: inertia(3, 3) = 0           !! About the proof-mass centre, SRF, kg m^2
        integer :: accelerometer_axes(3) = ACCELEROMETER_AXES   !! Signed axis of AF for x, y, z of SRF
        real(dp) :: rod_gain(3) = USUAL_ROD_GAIN       !! kappa, A m^2/mA
        real(dp) :: rod_sign(3) = 1             !! 1, or -1 for a rod that is wired the other way round
        real(dp) :: torque_delay = 0            !! From current tag to torque where it is not estimated, s
        real(dp) :: accelerometer_delay = 0     !! Of the tags of ACC1A where it is not estimated, s
        character(8) :: currents = 'auto'       !! Between their samples: smooth, steps, or by the data
        character(256) :: field_file = ''       !! Coefficients of the field (SHC); blank: IGRF-14
        real(dp) :: science_current = 8         !! Largest of science mode: ends a span, mA
        real(dp) :: excitation_current = 20     !! Range of a rod in a manoeuvre, mA
        real(dp) :: sine_share = 0.9_dp         !! Of the variance that lines have to explain
        real(dp) :: veto_before = 0.3_dp        !! Samples before a firing's tag are not used, s
        real(dp) :: veto_after = 2              !! And behind it, s
        real(dp) :: least_share = 0.7_dp        !! Of a span's samples: with fewer it is left out
        real(dp) :: longest_attitude_gap = 3    !! s
        real(dp) :: leakage_prior(2) = USUAL_LEAKAGE     !! Sigma of L, m/s^2/mA, and K, m/s^2/(mA/s)
        real(dp) :: scale_sigma = 0.004_dp      !! Of the accelerometer's scale
        real(dp) :: inertia_sigma = 0.01_dp     !! Relative, of the moments of inertia
        real(dp) :: gain_sigma = 0.1_dp         !! Relative, of rod_gain
        real(dp) :: field_sigma = 150*NANOTESLA !! Of the field model by axis, T
        real(dp) :: lift_sigma = 3e-7_dp        !! Of the air's force along y and z by the angle of the flow, m/s^2
        logical :: signs_known = .false.        !! A trim has confirmed the signs of the accelerometer's axes
        real(dp) :: tank(3, 2) = reshape([-0.6_dp, 0.0_dp, 0.0_dp, 0.6_dp, 0.0_dp, 0.0_dp], [3, 2])    !! From the centre
                                                !! of mass, SRF, m
        real(dp) :: trim_mass = 4.8_dp          !! Moved by a step, kg
        real(dp) :: trim_step = 2.5_dp*MICROMETRE       !! m
        integer :: trim_most = 12000            !! Steps in one command
    end type level1_setup_t

    character(8), parameter :: CURRENT_FORMS(3) = [character(8) :: 'auto', 'smooth', 'steps']

contains

    !> Reads a setup. Fails when it cannot be read, a value is out of range, or a key is not known.
    subroutine read_level1_setup(path, setup, error)
        character(*), intent(in) :: path    !! Of the namelist file
        type(level1_setup_t), intent(out) :: setup
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: settings

        call settings%open(path, error)
        if (allocated(error)) return
        call describe_level1(settings, setup)
        call settings%finish(error, only=[character(16) :: 'mass_properties', 'level1', 'a_priori'])       ! that of estimate
        if (.not. allocated(error)) call find_origins(settings, path, setup)
    end subroutine read_level1_setup

    !> Where each setting is from: all that would be written, by the lines that were read.
    subroutine find_origins(settings, path, setup)
        type(settings_t), intent(in) :: settings        !! As read
        character(*), intent(in) :: path
        type(level1_setup_t), intent(inout) :: setup

        type(settings_t) :: written
        type(text_file_t) :: file
        type(error_t), allocatable :: ignored
        type(origin_t) :: origin
        character(:), allocatable :: text
        character(24) :: group
        integer :: i, equals, remark, number

        allocate (setup%origins(0))
        call describe_level1(written, setup)
        call written%to_text(text, ignored)
        file = text_file_of(text, '')
        group = ''
        do i = 1, file%line_count()
            associate (line => file%text(file%first(i):file%last(i)))
                if (index(line, '&') == 1) group = line(2:)
                equals = index(line, ' = ')
                remark = index(line, '  ! ')
                if (equals == 0 .or. remark == 0) cycle
                origin%name = adjustl(line(:equals))
                origin%value = line(equals + 3:remark)
                origin%meaning = line(remark + 4:)
            end associate
            number = settings%line_of(trim(group), trim(origin%name))
            origin%source = 'default'
            if (number > 0) origin%source = trim(name_of(path))//', line '//integer_text(number)
            setup%origins = [setup%origins, origin]
        end do
    end subroutine find_origins

    !> What is known of the leakage beforehand: sigma of L, m/s^2/mA, and of K, m/s^2/(mA/s). One of 0 counts as a millionth of
    !> the usual one, so that its inverse square is a number.
    pure function leakage_sigmas(setup) result(sigmas)
        type(level1_setup_t), intent(in) :: setup
        real(dp) :: sigmas(2)

        sigmas = max(setup%leakage_prior, 1e-6_dp*USUAL_LEAKAGE)
    end function leakage_sigmas

    !> The settings, for reading and writing.
    subroutine describe_level1(settings, setup)
        class(settings_t), intent(inout) :: settings
        type(level1_setup_t), intent(inout) :: setup

        real(dp) :: axes(3), most

        call describe_mass_properties(settings, setup%mass, setup%inertia, mass_may_lack=.true.)
        call settings%group('level1', 'Estimate from Level-1 data')
        axes = setup%accelerometer_axes
        call settings%real_values('accelerometer_axes', axes, -3.0_dp, 3.0_dp, 'axis of AF, with its sign, that x, y and '// &
                                  'z of SRF are')
        setup%accelerometer_axes = nint(axes)
        if (any(abs(axes - nint(axes)) > 0) .or. .not. signed_axes_valid(setup%accelerometer_axes)) &
            call settings%reject('accelerometer_axes', 'has to name each of the axes 1, 2, 3 once, with its sign')
        call settings%real_values('rod_gain', setup%rod_gain, 1e-6_dp, 1e3_dp, 'x, y, z: moment by current, A m^2/mA', &
                                  unit='A m^2/mA')
        call settings%real_values('rod_sign', setup%rod_sign, -1.0_dp, 1.0_dp, 'x, y, z: 1 or -1')
        if (any(abs(abs(setup%rod_sign) - 1) > 0)) call settings%reject('rod_sign', 'has to be 1 or -1 for every rod')
        call settings%real_value('torque_delay', setup%torque_delay, -2.0_dp, 2.0_dp, 's, of the torque behind the tag '// &
                                 'of its current, where it is not estimated', unit='s')
        call settings%real_value('accelerometer_delay', setup%accelerometer_delay, -2.0_dp, 2.0_dp, 's, of the samples '// &
                                 'behind their tags, where it is not estimated', unit='s')
        call settings%text_value('currents', setup%currents, 'between their samples', CURRENT_FORMS)
        call settings%text_value('field_file', setup%field_file, 'coefficients of the field (SHC) in place of IGRF-14')
        call settings%real_value('science_ma', setup%science_current, 0.0_dp, 1000.0_dp, 'mA, largest current of science '// &
                                 'mode', unit='mA')
        call settings%real_value('excitation_ma', setup%excitation_current, 0.0_dp, 1000.0_dp, 'mA, range of a rod that '// &
                                 'is driven', unit='mA')
        call settings%real_value('sine_share', setup%sine_share, 0.0_dp, 1.0_dp, 'of the variance of currents that lines '// &
                                 'have to explain')
        call settings%real_value('veto_before', setup%veto_before, 0.0_dp, 60.0_dp, 's, before a firing', unit='s')
        call settings%real_value('veto_after', setup%veto_after, 0.0_dp, 60.0_dp, 's, behind a firing', unit='s')
        call settings%real_value('least_share', setup%least_share, 0.1_dp, 1.0_dp, 'of the samples of a span')
        call settings%real_value('longest_attitude_gap', setup%longest_attitude_gap, 1.0_dp, 60.0_dp, 's', unit='s')
        call settings%real_values('leakage_prior', setup%leakage_prior, 0.0_dp, 1.0_dp, 'sigma of L, m/s^2/mA, and of K, '// &
                                  'm/s^2/(mA/s)')
        call settings%real_value('scale_sigma', setup%scale_sigma, 0.0_dp, 1.0_dp, 'of the accelerometer')
        call settings%real_value('inertia_sigma', setup%inertia_sigma, 0.0_dp, 1.0_dp, 'relative')
        call settings%real_value('gain_sigma', setup%gain_sigma, 0.0_dp, 10.0_dp, 'relative, of rod_gain')
        call settings%real_value('field_sigma_nt', setup%field_sigma, 0.0_dp, 1e5_dp, 'nT, of the field by axis', NANOTESLA, &
                                 'nT')
        call settings%real_value('lift_sigma', setup%lift_sigma, 0.0_dp, 1e-3_dp, 'm/s^2, of the air''s force along y and '// &
                                 'z by the angle of its flow', unit='m/s^2')
        call settings%logical_value('signs_known', setup%signs_known, 'a trim has confirmed the signs of the accelerometer''s '// &
                                    'axes')
        call settings%real_values('tank_1', setup%tank(:, 1), -10.0_dp, 10.0_dp, 'm, from the centre of mass, SRF', unit='m')
        call settings%real_values('tank_2', setup%tank(:, 2), -10.0_dp, 10.0_dp, 'm, from the centre of mass, SRF', unit='m')
        call settings%real_value('trim_mass', setup%trim_mass, 0.1_dp, 1e3_dp, 'kg, moved by a step', unit='kg')
        call settings%real_value('trim_step_um', setup%trim_step, 0.1_dp, 1e3_dp, 'um, of that mass', MICROMETRE, 'um')
        most = setup%trim_most
        call settings%real_value('trim_most', most, 1.0_dp, 1e9_dp, 'steps in one command')
        setup%trim_most = nint(most)
        call settings%end_group()
    end subroutine describe_level1
end module gracecg_level1_setup
