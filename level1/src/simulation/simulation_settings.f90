!> What a simulated folder of Level-1 files is made with: groups `level1_simulation` and `level1_span` of a namelist.
!> Every effect has its setting, and can be switched off by it; the defaults are those measured on files of GRACE-FO
!> C and D of 2023 and GRACE A and B of 2003, where nothing else is said.
module gracecg_level1_simulation_settings
    use gracecg_level1_basics
    use gracecg_base_constants, only: ARCSECOND
    use gracecg_environment_time, only: parse_utc
    use gracecg_files_settings, only: settings_t
    use gracecg_spacecraft_rod_leakage, only: USUAL_ROD_GAIN, USUAL_LEAKAGE
    use gracecg_simulation_case, only: LEVEL1_GROUPS
    implicit none
    private
    public :: level1_settings_t, level1_span_settings_t, read_level1_settings, describe_level1_simulation, span_list
    public :: by_satellite

    integer, parameter :: MAX_SPANS = 32            ! sub-manoeuvres of a folder
    !> What may be wrong on purpose, for tests of those who look for it: currents of rod y with the other sign, SRF
    !> written in the columns of AF, tags of ACC1A that say GPS and are OBC, B currents with the sign of the other mission,
    !> angular channels that are zero as in ACT files
    character(16), parameter :: LEVEL1_FAULTS(6) = [character(16) :: 'none', 'rod-sign', 'srf-as-af', 'obc-tags', 'b-sign', &
                                                    'transplanted']
    character(8), parameter :: WAVEFORMS(2) = [character(8) :: 'sine', 'square']

    type :: level1_span_settings_t
        !! One sub-manoeuvre
        real(dp) :: start = 0               !! s from the beginning of the files
        real(dp) :: duration = 60           !! s
        real(dp) :: amplitude(3) = 120      !! Of the rods' currents, mA
        real(dp) :: cycles(3) = [5, 6, 7]   !! In the span
        real(dp) :: phase(3) = 0            !! At the start, rad
    end type level1_span_settings_t

    type :: level1_settings_t
        !! Satellite, manoeuvre, and errors of all instruments
        character(1) :: satellite = ''              !! A to D; blank: C of a front satellite, D of a back one
        character(40) :: epoch = ''                 !! UTC of the beginning; blank: the case's, or 2020-02-01 of one before 2000
        real(dp) :: duration = 0                    !! Of the files, s; 0: to the end of the last span and a little more
        integer :: spans = 4                        !! Alike, but for their start
        real(dp) :: first_start = 300               !! Of the first span, s from the beginning
        real(dp) :: spacing = 1410                  !! From start to start, s: a quarter of a revolution
        type(level1_span_settings_t) :: span = level1_span_settings_t() !! What they are like
        type(level1_span_settings_t), allocatable :: list(:)    !! Spans named one by one; they stand in for the others
        character(8) :: waveform = 'sine'           !! Of the currents
        logical :: staircase = .false.              !! Currents are held from tag to tag, 0.5 s
        real(dp) :: science_current = 4             !! Largest between the spans, mA
        real(dp) :: whisper(3) = 0                  !! Amplitudes of tones that rods have all the time between the spans, mA
        real(dp) :: whisper_frequency(3) = [0.08_dp, 0.1_dp, 0.12_dp]   !! Of them, Hz
        real(dp) :: whisper_phase(3) = 0            !! At the beginning of the files, rad
        logical :: rod_control = .false.            !! Rods hold the attitude between the spans, and thrusters what is along the
                                                    !! field; else a torque without currents does
        real(dp) :: control_frequency = 0.02_dp/TWO_PI
        !! Of the controller as an oscillator, Hz: slow beside the rods' lines, and back within the minutes between spans
        real(dp) :: moved_at = 0                    !! When the centre of mass jumps, s; 0: it does not
        real(dp) :: moved(3) = 0                    !! By which d is another from then on, m
        real(dp) :: drift(3) = 0                    !! By which d grows all the time, as when a tank empties faster, m/s; what
                                                    !! is said of d is that of the middle of the files
        real(dp) :: alignment = 0                   !! Of the accelerometer's axes to those of the star cameras about each axis,
                                                    !! sigma, another in each span, rad
        real(dp) :: pitch = 0.75_dp*DEGREE          !! Of body x towards the other satellite, downwards, rad
        real(dp) :: rod_gain(3) = USUAL_ROD_GAIN           !! As said, A m^2/mA
        real(dp) :: rod_gain_error = 0.02_dp        !! Relative, sigma: the true one is said times 1 + error
        real(dp) :: inertia_error = 0.01_dp         !! Relative, sigma: what is said is the true one times 1 + error
        real(dp) :: torque_delay = 0                !! Of the true current behind the tags, s
        real(dp) :: field_error = 30*NANOTESLA      !! Of the field model by axis, sigma, T
        logical :: density_wave = .false.           !! The case's short-period density wave acts
        ! accelerometer
        real(dp) :: accelerometer_delay = 0         !! Of what is sensed behind the tags, s
        real(dp) :: bias(3) = [-2.8e-7_dp, -1.065e-5_dp, -1.83e-7_dp]   !! m/s^2
        real(dp) :: scale_error = 0.004_dp          !! Sigma
        real(dp) :: noise_low(3) = [2.7e-10_dp, 1.3e-10_dp, 0.64e-10_dp]    !! One-sided ASD at 0.1 Hz, m/s^2/sqrt(Hz)
        real(dp) :: noise_high(3) = [6.7e-10_dp, 2.4e-10_dp, 9.2e-10_dp]    !! RMS of the ASD between 2 and 5 Hz
        real(dp) :: noise_factor = -1               !! Of linear and angular noise; negative: 1, and 6 of D
        real(dp) :: angular_bias(3) = [-7.8e-4_dp, 1.3e-5_dp, 1.2e-4_dp]    !! rad/s^2
        real(dp) :: angular_scale_error = 0.03_dp   !! Sigma
        real(dp) :: angular_noise(3) = [2.9e-8_dp, 1.1e-8_dp, 1.7e-8_dp]    !! One-sided ASD, rad/s^2/sqrt(Hz)
        real(dp) :: angular_quantum(3) = [1.0133e-8_dp, 6.109e-10_dp, 1.0133e-8_dp]     !! rad/s^2; 0: none
        real(dp) :: leakage(2) = USUAL_LEAKAGE   !! Of the rods: sigma of L, m/s^2/mA, and of K, m/s^2/(mA/s)
        real(dp) :: angular_leakage(2) = 0          !! Likewise of the angular channels, rad/s^2/mA, rad/s^2/(mA/s)
        integer :: flagged = 0                      !! Samples in each span with wrong values and a bad flag
        integer :: gaps = 0                         !! Spans in which samples of the accelerometer are missing
        real(dp) :: gap = 2                         !! Length of each gap, s
        ! magnetometer and currents
        real(dp) :: magnetometer_noise = 5*NANOTESLA    !! T
        real(dp) :: magnetometer_bias = 1           !! Factor of the bias of the satellite
        real(dp) :: magnetometer_leakage = 1        !! Factor of what the rods add
        real(dp) :: stuck(2) = 0                    !! Start and length of a time without a new value, s
        real(dp) :: current_quantum = 0.0537_dp     !! mA; 0: none
        ! attitude
        real(dp) :: attitude_noise = 2e-7_dp        !! Of SCA1B by axis, rad
        real(dp) :: head_noise(3) = [2.6_dp, 1.5_dp, 25.0_dp]*ARCSECOND     !! Of SCA1A about x, y, boresight, rad
        real(dp) :: gyro_noise = 7e-6_dp*DEGREE     !! rad
        real(dp) :: gyro_bias = 1e-6_dp             !! Sigma, rad/s
        ! clocks
        real(dp) :: clock_offset = -10              !! GPS less receiver time, s; less than -1: that of the satellite
        real(dp) :: clock_drift = -1.5e-8_dp        !! s/s
        ! thrusters
        real(dp) :: firing_interval(2) = [90, 300]  !! Least and greatest time between firings, s; 0: none
        integer :: firings_inside = 0               !! Spans that a firing falls into
        real(dp) :: thrust_mismatch = 0.05_dp       !! Sigma, relative: the force of a pair that is left over
        character(16) :: fault = 'none'             !! One of LEVEL1_FAULTS
    end type level1_settings_t

contains

    !> Reads a file with group level1_simulation and, where wanted, level1_span; other groups are others' (a case file
    !> may hold both). Fails when it cannot be read, a value is out of range, or spans overlap.
    subroutine read_level1_settings(path, level1, error)
        character(*), intent(in) :: path    !! Of the namelist file
        type(level1_settings_t), intent(out) :: level1
        type(error_t), allocatable, intent(out) :: error

        type(settings_t) :: settings

        call settings%open(path, error)
        if (allocated(error)) return
        call describe_level1_simulation(settings, level1)
        call settings%finish(error, only=LEVEL1_GROUPS)
        if (.not. allocated(error)) call check_spans(level1, error)
        call add_context(error, path)
    end subroutine read_level1_settings

    !> The value of a satellite out of four, for A, B, C, D.
    pure real(dp) function by_satellite(satellite, values) result(value)
        character(1), intent(in) :: satellite   !! A to D
        real(dp), intent(in) :: values(4)       !! Any unit

        value = values(max(1, index('ABCD', satellite)))
    end function by_satellite

    !> The spans, in their order.
    pure subroutine span_list(level1, spans)
        type(level1_settings_t), intent(in) :: level1
        type(level1_span_settings_t), allocatable, intent(out) :: spans(:)

        integer :: i

        if (allocated(level1%list)) then
            if (size(level1%list) > 0) then
                spans = level1%list
                return
            end if
        end if
        allocate (spans(level1%spans))
        do i = 1, level1%spans
            spans(i) = level1%span
            spans(i)%start = level1%first_start + (i - 1)*level1%spacing
        end do
    end subroutine span_list

    !> Spans follow each other, with time to hold the attitude in between.
    subroutine check_spans(level1, error)
        type(level1_settings_t), intent(in) :: level1
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: LEAST = 120      ! s
        type(level1_span_settings_t), allocatable :: spans(:)
        integer :: i

        call span_list(level1, spans)
        do i = 1, size(spans)
            if (spans(i)%start < LEAST) then
                call fail(error, 'span '//integer_text(i)//' starts earlier than '//integer_text(nint(LEAST))// &
                          ' s after the beginning of the files: there is no attitude before it')
                return
            end if
            if (i == 1) cycle
            if (spans(i)%start >= spans(i - 1)%start + spans(i - 1)%duration + LEAST) cycle
            call fail(error, 'span '//integer_text(i)//' starts less than '//integer_text(nint(LEAST))//' s after the end of '// &
                      'the one before')
            return
        end do
        if (level1%duration > 0 .and. size(spans) > 0) then
            if (level1%duration < spans(size(spans))%start + spans(size(spans))%duration + LEAST/2) &
                call fail(error, 'duration: the files end before, or less than '//integer_text(nint(LEAST/2))// &
                          ' s after, the last span')
        end if
    end subroutine check_spans

    !> The settings, for reading and writing.
    subroutine describe_level1_simulation(settings, level1)
        class(settings_t), intent(inout) :: settings
        type(level1_settings_t), intent(inout) :: level1

        character(1), parameter :: LETTERS(5) = [' ', 'A', 'B', 'C', 'D']
        real(dp), parameter :: SHORTEST = 10    ! s: so that no product is without records
        type(utc_t) :: ignored
        type(error_t), allocatable :: problem

        call settings%group('level1_simulation', 'Simulated Level-1 files')
        call settings%text_value('satellite', level1%satellite, 'A, B, C, D; empty: C of a front, D of a back satellite', &
                                 LETTERS)
        call settings%text_value('epoch', level1%epoch, 'UTC; empty: of the case, or 2020-02-01 of a case before 2000')
        if (level1%epoch /= '') then
            call parse_utc(trim(level1%epoch), ignored, problem)
            if (allocated(problem)) call settings%reject('epoch', problem%message)
        end if
        call settings%real_value('duration', level1%duration, 0.0_dp, 864000.0_dp, 's, of the files; 0: as the spans need', &
                                 unit='s')
        if (level1%duration > 0 .and. level1%duration < SHORTEST) &
            call settings%reject('duration', 'is below 10 s; 0: as the spans need')
        call settings%integer_value('spans', level1%spans, 0, MAX_SPANS, 'alike but for their start')
        call settings%real_value('first_start', level1%first_start, 0.0_dp, 864000.0_dp, 's, of the first span', unit='s')
        call settings%real_value('spacing', level1%spacing, 0.0_dp, 864000.0_dp, 's, from start to start', unit='s')
        call describe_span(settings, level1%span)
        call settings%text_value('waveform', level1%waveform, 'of the currents', WAVEFORMS)
        call settings%logical_value('staircase', level1%staircase, 'currents are held for 0.5 s, from tag to tag')
        call settings%real_value('science_ma', level1%science_current, 0.0_dp, 100.0_dp, 'mA, largest between the spans', &
                                 unit='mA')
        call settings%real_values('whisper_ma', level1%whisper, 0.0_dp, 1000.0_dp, 'mA, of rods x, y, z all the time '// &
                                  'between the spans', unit='mA')
        call settings%real_values('whisper_hz', level1%whisper_frequency, 1e-3_dp, 0.5_dp, 'Hz, of these tones', unit='Hz')
        call settings%real_values('whisper_phase_deg', level1%whisper_phase, -360.0_dp, 360.0_dp, 'deg, at the beginning', &
                                  DEGREE, 'deg')
        call settings%logical_value('rod_control', level1%rod_control, 'rods hold the attitude between the spans')
        if (level1%rod_control .and. level1%staircase) &
            call settings%reject('rod_control', 'goes with smooth currents: set staircase = .false.')
        call settings%real_value('control_hz', level1%control_frequency, 1e-5_dp, 1e-2_dp, 'Hz, of the controller as an '// &
                                 'oscillator', unit='Hz')
        call settings%real_value('moved_at', level1%moved_at, 0.0_dp, 864000.0_dp, 's, when the centre of mass jumps; 0: '// &
                                 'it does not', unit='s')
        call settings%real_values('moved_um', level1%moved, -1000.0_dp, 1000.0_dp, 'um, by which d is another then', &
                                  MICROMETRE, 'um')
        call settings%real_values('drift_um_h', level1%drift, -100.0_dp, 100.0_dp, 'um/h, by which d grows', MICROMETRE/3600, &
                                  'um/h')
        call settings%real_value('alignment_deg', level1%alignment, 0.0_dp, 1.0_dp, 'deg, sigma by axis, of the accelerometer '// &
                                 'to the star cameras, another in each span', DEGREE, 'deg')
        call settings%real_value('pitch_deg', level1%pitch, -5.0_dp, 5.0_dp, 'deg', DEGREE, 'deg')
        call settings%real_values('rod_gain', level1%rod_gain, 1e-6_dp, 1e3_dp, 'A m^2/mA, x, y, z, as said', unit='A m^2/mA')
        call settings%real_value('rod_gain_error', level1%rod_gain_error, 0.0_dp, 1.0_dp, 'relative, sigma')
        call settings%real_value('inertia_error', level1%inertia_error, 0.0_dp, 0.5_dp, 'relative, sigma, of what is said')
        call settings%real_value('torque_delay', level1%torque_delay, -2.0_dp, 2.0_dp, 's, of true currents behind the tags', &
                                 unit='s')
        call settings%real_value('field_error_nt', level1%field_error, 0.0_dp, 1e4_dp, 'nT, of the model by axis, sigma', &
                                 NANOTESLA, 'nT')
        call settings%logical_value('density_wave', level1%density_wave, 'that of the case acts')
        ! accelerometer
        call settings%real_value('accelerometer_delay', level1%accelerometer_delay, -2.0_dp, 2.0_dp, 's, behind the tags', &
                                 unit='s')
        call settings%real_values('bias', level1%bias, -1.0_dp, 1.0_dp, 'm/s^2, SRF', unit='m/s^2')
        call settings%real_value('scale_error', level1%scale_error, 0.0_dp, 0.5_dp, 'sigma')
        call settings%real_values('noise_low', level1%noise_low, 0.0_dp, 1.0_dp, 'm/s^2/sqrt(Hz), one-sided, at 0.1 Hz')
        call settings%real_values('noise_high', level1%noise_high, 0.0_dp, 1.0_dp, 'm/s^2/sqrt(Hz), RMS from 2 to 5 Hz')
        if (any(level1%noise_high < level1%noise_low)) call settings%reject('noise_high', 'is below noise_low')
        call settings%real_value('noise_factor', level1%noise_factor, -1.0_dp, 1e3_dp, 'of linear and angular noise; '// &
                                 'negative: 1, and 6 of satellite D')
        call settings%real_values('angular_bias', level1%angular_bias, -1.0_dp, 1.0_dp, 'rad/s^2, SRF', unit='rad/s^2')
        call settings%real_value('angular_scale_error', level1%angular_scale_error, 0.0_dp, 0.5_dp, 'sigma')
        call settings%real_values('angular_noise', level1%angular_noise, 0.0_dp, 1.0_dp, 'rad/s^2/sqrt(Hz), one-sided')
        call settings%real_values('angular_quantum', level1%angular_quantum, 0.0_dp, 1.0_dp, 'rad/s^2; 0: none', &
                                  unit='rad/s^2')
        call settings%real_values('leakage', level1%leakage, 0.0_dp, 1.0_dp, 'sigma of L, m/s^2/mA, and K, m/s^2/(mA/s)')
        call settings%real_values('angular_leakage', level1%angular_leakage, 0.0_dp, 1.0_dp, 'sigma of La, rad/s^2/mA, and '// &
                                  'Ka, rad/s^2/(mA/s)')
        call settings%integer_value('flagged', level1%flagged, 0, 1000, 'samples in each span: wrong, and flagged')
        call settings%integer_value('gaps', level1%gaps, 0, MAX_SPANS, 'spans with a gap of the accelerometer')
        call settings%real_value('gap', level1%gap, 0.0_dp, 600.0_dp, 's, length of each', unit='s')
        ! magnetometer, attitude, clocks, thrusters
        call settings%real_value('magnetometer_noise_nt', level1%magnetometer_noise, 0.0_dp, 1e5_dp, 'nT', NANOTESLA, 'nT')
        call settings%real_value('magnetometer_bias', level1%magnetometer_bias, 0.0_dp, 100.0_dp, 'factor of the satellite''s')
        call settings%real_value('magnetometer_leakage', level1%magnetometer_leakage, 0.0_dp, 100.0_dp, 'factor of what the '// &
                                 'rods add')
        call settings%real_values('stuck', level1%stuck, 0.0_dp, 864000.0_dp, 's, start and length of a time without new '// &
                                  'values', unit='s')
        call settings%real_value('current_quantum_ma', level1%current_quantum, 0.0_dp, 100.0_dp, 'mA; 0: none', unit='mA')
        call settings%real_value('attitude_noise', level1%attitude_noise, 0.0_dp, 1.0_dp, 'rad, of SCA1B', unit='rad')
        call settings%real_values('head_noise_arcsec', level1%head_noise, 0.0_dp, 3600.0_dp, 'arcsec, of SCA1A about x, y, '// &
                                  'boresight', ARCSECOND, 'arcsec')
        call settings%real_value('gyro_noise_deg', level1%gyro_noise, 0.0_dp, 1.0_dp, 'deg', DEGREE, 'deg')
        call settings%real_value('gyro_bias', level1%gyro_bias, 0.0_dp, 1.0_dp, 'rad/s, sigma', unit='rad/s')
        call settings%real_value('clock_offset', level1%clock_offset, -10.0_dp, 0.9_dp, 's, GPS less receiver time; less '// &
                                 'than -1: that of the satellite', unit='s')
        call settings%real_value('clock_drift', level1%clock_drift, -1e-4_dp, 1e-4_dp, 's/s')
        call settings%real_values('firing_interval', level1%firing_interval, 0.0_dp, 1e5_dp, 's, least and greatest; 0: no '// &
                                  'firings between the spans', unit='s')
        if (level1%firing_interval(2) < level1%firing_interval(1)) call settings%reject('firing_interval', 'has to rise')
        call settings%integer_value('firings_inside', level1%firings_inside, 0, MAX_SPANS, 'spans with a firing')
        call settings%real_value('thrust_mismatch', level1%thrust_mismatch, 0.0_dp, 1.0_dp, 'relative, sigma')
        call settings%text_value('fault', level1%fault, 'put in on purpose', LEVEL1_FAULTS)
        call settings%end_group()
        call describe_list(settings, level1)
    end subroutine describe_level1_simulation

    !> What a span has but its start.
    subroutine describe_span(settings, span)
        class(settings_t), intent(inout) :: settings
        type(level1_span_settings_t), intent(inout) :: span

        call settings%real_value('span_duration', span%duration, 10.0_dp, 3600.0_dp, 's', unit='s')
        call settings%real_values('amplitude_ma', span%amplitude, -1000.0_dp, 1000.0_dp, 'mA, of rods x, y, z', unit='mA')
        call settings%real_values('cycles', span%cycles, 0.0_dp, 1000.0_dp, 'of rods x, y, z in the span')
        call settings%real_values('phase_deg', span%phase, -360.0_dp, 360.0_dp, 'deg, at the start', DEGREE, 'deg')
    end subroutine describe_span

    !> Spans named one by one.
    subroutine describe_list(settings, level1)
        class(settings_t), intent(inout) :: settings
        type(level1_settings_t), intent(inout) :: level1

        integer :: i, n

        n = 0
        if (allocated(level1%list)) n = size(level1%list)
        call settings%count('level1_span', n)
        if (n > MAX_SPANS) then
            call settings%group('level1_span', 'One sub-manoeuvre', 1)
            call settings%reject('start', 'there are '//integer_text(n)//' such groups; at most '//integer_text(MAX_SPANS)// &
                                 ' are allowed')
            return
        end if
        if (.not. allocated(level1%list)) then
            allocate (level1%list(n))
            level1%list = level1%span
        end if
        do i = 1, n
            call settings%group('level1_span', 'One sub-manoeuvre', i)
            call settings%real_value('start', level1%list(i)%start, 0.0_dp, 864000.0_dp, 's, from the beginning', unit='s', &
                                     required=.true.)
            call describe_span(settings, level1%list(i))
            call settings%end_group()
        end do
    end subroutine describe_list
end module gracecg_level1_simulation_settings
