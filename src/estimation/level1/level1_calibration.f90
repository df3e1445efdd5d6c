!> The data of a calibration gathered from a folder of Level-1 files: in GPS time and SRF, what lies in the spans of
!> the manoeuvre and a little around them; of a day of ACC1A nothing else is kept.
module gracecg_estimation_level1_calibration
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: DEGREE, EARTH_GM, MICROMETRE
    use gracecg_base_error, only: error_t, fail, add_context
    use gracecg_base_text, only: string_t, append, integer_text, lower_case, real_text
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion, rotation_matrix, normalised
    use gracecg_files_folder, only: files_in_folder
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model
    use gracecg_environment_time, only: decimal_year
    use gracecg_observations_level1_events, only: level1_event_t, read_events, manoeuvre_spans
    use gracecg_observations_level1_frames, only: srf_of_accelerometer, gracecg_quaternion, continuous_quaternions, &
        mounting_of_head, attitude_by_head, inertial_of_earth_fixed_by_states, inertial_of_earth_fixed
    use gracecg_observations_level1_folder, only: level1_folder_t, open_level1_folder
    use gracecg_observations_level1_records, only: level1_records_t, read_level1
    use gracecg_observations_level1_setup, only: level1_setup_t
    use gracecg_observations_level1_time, only: level1_clock_t, new_level1_clock, to_gps_time, utc_of_gps
    use gracecg_estimation_level1_series, only: interpolate, node_before
    use gracecg_estimation_level1_spans, only: find_spans
    implicit none
    private
    public :: level1_calibration_t, level1_span_t, level1_gyro_t, gather_calibration
    public :: SPAN_MARGIN, keep_samples

    real(dp), parameter :: SPAN_MARGIN = 20     !! Attitude is used so long before and behind a span, s
    real(dp), parameter :: READ_MARGIN = 8      !! And read so much farther, s
    integer, parameter :: HEADS = 3

    type :: level1_gyro_t
        !! Angles of one gyro in a span and its margins
        real(dp), allocatable :: time(:)        !! s from the epoch
        real(dp), allocatable :: angle(:)       !! rad
    end type level1_gyro_t

    type :: level1_span_t
        !! One sub-manoeuvre; times in s from the epoch of the calibration, vectors in SRF
        real(dp) :: start = 0, stop = 0             !! s
        logical :: used = .true.    !! Its samples suffice
        character(80) :: reason = ''                !! Why it is not used
        real(dp), allocatable :: time(:)            !! Of the accelerometer's samples that are left
        real(dp), allocatable :: linear(:, :)       !! m/s^2
        real(dp), allocatable :: angular(:, :)      !! rad/s^2; NaN: none
        real(dp), allocatable :: attitude_time(:)   !! Of the attitude, with margins
        real(dp), allocatable :: quaternion(:, :)   !! Inertial to SRF, scalar last
        real(dp), allocatable :: position(:, :)     !! Inertial, m
        real(dp), allocatable :: angle(:, :)        !! phi, rotation vector summed up, rad
        real(dp), allocatable :: rate(:, :)         !! Angular velocity, rad/s
        real(dp), allocatable :: field(:, :)        !! Of the Earth, T
        real(dp), allocatable :: up(:, :)           !! Unit vector from the Earth's centre
        real(dp), allocatable :: gradient(:)        !! mu/r^3, 1/s^2
        type(level1_gyro_t), allocatable :: gyros(:)    !! Those that there are
        real(dp), allocatable :: firings(:)         !! Times of thruster firings, with margins
        integer :: expected = 0                     !! Samples of the accelerometer
        integer :: flagged = 0                      !! Left out for their quality flags
        integer :: vetoed = 0                       !! For firings
        integer :: without_current = 0              !! For gaps in the currents
        integer :: outliers = 0                     !! As outliers
        integer :: firings_inside = 0    !! Thruster firings between start and stop
        real(dp) :: mean_field(3) = 0               !! T
    end type level1_span_t

    type :: level1_calibration_t
        !! What a folder says of a calibration manoeuvre
        character(1) :: satellite = ''    !! A to D
        character(10) :: date = ''                      !! Of the epoch, GPS
        integer(i8) :: epoch = 0                        !! s past 2000-01-01 12:00 GPS
        character(24) :: spans_from = ''                !! Where the spans come from
        type(level1_span_t), allocatable :: spans(:)    !! The sub-manoeuvres, in time
        real(dp), allocatable :: current_time(:)        !! s from the epoch
        real(dp), allocatable :: current(:, :)          !! Net current of each rod, mA
        real(dp), allocatable :: measured_field(:, :)   !! T
        real(dp) :: clock_correction = 0                !! GPS less OBC time at the epoch, s
        real(dp) :: field_difference = -1               !! RMS of magnetometer, corrected, less model, T; -1: not known
        real(dp) :: gas(2) = -1                         !! In tanks 1 and 2, kg; -1: not known
        logical :: has_angular = .false.                !! The accelerometer has angular channels
        logical :: zero_angular = .false.               !! It has them, and they are zero: transplanted data (ACT)
        logical :: has_gyros = .false.    !! There are IMU files
        type(string_t), allocatable :: notes(:)         !! What is unusual
    end type level1_calibration_t

contains

    !> Gathers a calibration. Fails when a file that is needed is missing or broken, and when there is no manoeuvre.
    subroutine gather_calibration(folder, setup, satellite, spans_file, given_span, field_choice, calibration, error)
        character(*), intent(in) :: folder          !! Of the Level-1 files
        type(level1_setup_t), intent(in) :: setup
        character(*), intent(in) :: satellite       !! A to D; blank: the only one there is
        character(*), intent(in) :: spans_file      !! SOE, or lines of start and duration; blank: SOE of the folder, or
                                                    !! by the currents
        real(dp), intent(in) :: given_span(:, :)    !! (2, n): start and duration, s past 2000-01-01 12:00 GPS
        character(*), intent(in) :: field_choice    !! model or magnetometer
        type(level1_calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error

        type(level1_folder_t) :: paths
        type(level1_records_t) :: records
        type(level1_clock_t) :: clock
        real(dp), allocatable :: spans(:, :), windows(:, :)
        character(:), allocatable :: path
        integer :: i

        allocate (calibration%notes(0))
        call open_files(folder, satellite, paths, calibration, error)
        if (.not. allocated(error)) call make_clock(paths, calibration, clock, error)
        if (.not. allocated(error)) call read_currents(paths, clock, calibration, error)
        if (.not. allocated(error)) call choose_spans(paths, spans_file, given_span, setup, calibration, spans, error)
        if (allocated(error)) return
        allocate (calibration%spans(size(spans, 2)))
        do i = 1, size(spans, 2)
            calibration%spans(i)%start = spans(1, i)
            calibration%spans(i)%stop = spans(2, i)
        end do
        windows = spans + real(calibration%epoch, dp)
        windows(1, :) = windows(1, :) - SPAN_MARGIN - READ_MARGIN
        windows(2, :) = windows(2, :) + SPAN_MARGIN + READ_MARGIN
        call read_firings(paths, clock, calibration, windows, error)
        if (.not. allocated(error)) call read_accelerometer(paths, setup, clock, calibration, windows, error)
        if (.not. allocated(error)) call read_attitude(paths, setup, clock, calibration, windows, error)
        if (.not. allocated(error)) call read_gyros(paths, clock, calibration, windows, error)
        if (allocated(error)) return
        call fit_magnetometer(calibration, field_choice == 'magnetometer', error)
        if (allocated(error)) return
        call edit_spans(setup, calibration)
        call find_file(paths, ['MAS1B', 'MAS1A'], path)
        if (path == '') return
        call read_level1(path, records, error)
        if (.not. allocated(error)) call take_gas(records, calibration)
    end subroutine gather_calibration

    subroutine note(calibration, text)
        type(level1_calibration_t), intent(inout) :: calibration
        character(*), intent(in) :: text

        call append(calibration%notes, text)
    end subroutine note

    !> The file of the first of some products that is there; empty: none.
    subroutine find_file(files, products, path)
        type(level1_folder_t), intent(in) :: files
        character(5), intent(in) :: products(:)
        character(:), allocatable, intent(out) :: path

        integer :: i

        do i = 1, size(products)
            call files%path_of(products(i), path)
            if (path /= '') return
        end do
    end subroutine find_file

    !> The files of the satellite that is asked for, or of the first one. Fails without ACC1A.
    subroutine open_files(folder, satellite, files, calibration, error)
        character(*), intent(in) :: folder, satellite
        type(level1_folder_t), intent(out) :: files
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: path
        character(1) :: wanted
        integer :: i

        wanted = satellite
        call open_level1_folder(folder, wanted, files, error)
        if (allocated(error)) return
        calibration%satellite = files%satellite
        calibration%date = files%date
        do i = 1, size(files%warnings)
            call note(calibration, files%warnings(i)%text)
        end do
        call files%path_of('ACC1A', path)
        if (path /= '') return
        call fail(error, trim(folder)//': no file of product ACC1A of satellite '//files%satellite//', which is the '// &
                  'observation; its name is like ACC1A_2020-02-01_C_04.txt')
        call find_file(files, ['ACT1A', 'ACT1B'], path)
        if (path /= '') error%message = error%message//'. ACT data are no observation: they may be transplanted from '// &
            'the other satellite, and have no angular accelerations'
    end subroutine open_files

    !> Time: CLK1B, TIM1B. Without CLK1B tags are taken as they are, and that is said.
    subroutine make_clock(paths, calibration, clock, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_calibration_t), intent(inout) :: calibration
        type(level1_clock_t), intent(out) :: clock
        type(error_t), allocatable, intent(out) :: error

        type(level1_records_t) :: clk, tim
        character(:), allocatable :: path, other

        call find_file(paths, ['CLK1B'], path)
        call find_file(paths, ['TIM1B'], other)
        if (path == '') then
            call fail(error, 'no file of product CLK1B of satellite '//calibration%satellite//': the tags of ACC1A cannot be '// &
                      'taken to GPS time')
            return
        end if
        call read_level1(path, clk, error)
        if (allocated(error)) return
        if (other /= '') then
            call read_level1(other, tim, error)
            if (.not. allocated(error)) call new_level1_clock(clock, error, clk, tim)
        else
            call note(calibration, 'no TIM1B: receiver time is taken as that of the on-board computer')
            call new_level1_clock(clock, error, clk)
        end if
    end subroutine make_clock

    !> Reads the wanted fields of a product in GPS time.
    subroutine read_product(path, clock, calibration, fields, records, error, windows)
        character(*), intent(in) :: path, fields(:)
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        type(level1_records_t), intent(out) :: records
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: windows(:, :)     !! s past 2000-01-01 12:00; absent: all

        integer :: extrapolated, i

        call read_level1(path, records, error, fields, windows)
        if (allocated(error)) return
        if (records%count == 0) return
        if (records%satellite /= calibration%satellite) then
            call fail(error, path//': its records are of satellite '//records%satellite//', not '//calibration%satellite)
            return
        end if
        call to_gps_time(records, clock, extrapolated)
        if (extrapolated > 0) call note(calibration, records%layout%product//': '//integer_text(extrapolated)// &
                                        ' tags are beyond CLK1B, which is extrapolated')
        do i = 1, size(records%warnings)
            call note(calibration, records%layout%product//': '//records%warnings(i)%text)
        end do
    end subroutine read_product

    !> Which records have none of some bits set in the quality flag.
    pure function without_bits(records, bits) result(good)
        type(level1_records_t), intent(in) :: records
        integer, intent(in) :: bits(:)
        logical :: good(records%count)

        integer :: i, column, flag

        column = records%field_of('qualflg')
        do i = 1, records%count
            flag = nint(records%values(i, column))
            good(i) = .not. any(btest(flag, bits))
        end do
    end function without_bits

    !> Net currents of the rods, |A| - |B|, and the measured field, of MAG1B or MAG1A.
    subroutine read_currents(paths, clock, calibration, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error

        character(10), parameter :: FIELDS(10) = [character(10) :: 'MfvX_RAW', 'MfvY_RAW', 'MfvZ_RAW', 'torque1A', 'torque2A', &
                                                  'torque3A', 'torque1B', 'torque2B', 'torque3B', 'qualflg']
        real(dp), parameter :: LEAST = 0.5_dp       ! mA: what has a sign
        type(level1_records_t) :: mag
        logical :: grace_fo
        character(:), allocatable :: path
        integer :: negative_a, wrong_b

        call find_file(paths, ['MAG1B', 'MAG1A'], path)
        if (path == '') then
            call fail(error, 'no file of product MAG1B or MAG1A of satellite '//calibration%satellite//': the currents of the '// &
                      'torque rods are not known')
            return
        end if
        call read_product(path, clock, calibration, FIELDS, mag, error)
        if (allocated(error)) return
        call mag%drop(.not. without_bits(mag, [0, 6]) .or. any(ieee_is_nan(mag%values), 2))
        if (mag%count < 10) then
            call fail(error, mag%path//': only '//integer_text(mag%count)//' usable records')
            return
        end if
        calibration%epoch = mag%seconds(1)
        calibration%current_time = real(mag%seconds - calibration%epoch, dp) + mag%fraction
        calibration%measured_field = transpose(mag%values(:, 1:3))*MICROMETRE
        calibration%current = transpose(abs(mag%values(:, 4:6)) - abs(mag%values(:, 7:9)))
        grace_fo = any(calibration%satellite == ['C', 'D'])
        negative_a = count(mag%values(:, 4:6) < -LEAST)
        wrong_b = count(merge(mag%values(:, 7:9) > LEAST, mag%values(:, 7:9) < -LEAST, grace_fo))
        if (negative_a > 0) call note(calibration, mag%layout%product//': wrong sign of currents: '//integer_text(negative_a)// &
                                      ' A currents (positive direction) are negative; their sign is not used')
        if (wrong_b > 0) call note(calibration, mag%layout%product//': B currents with the wrong sign: '// &
                                   integer_text(wrong_b)//' are '//trim(merge('positive', 'negative', grace_fo))// &
                                   ', which is not the convention of this mission; the net current |A| - |B| does not use it')
    end subroutine read_currents

    !> The spans, s from the epoch: given, of a file, of the SOE file in the folder, or of the currents.
    subroutine choose_spans(paths, spans_file, given_span, setup, calibration, spans, error)
        type(level1_folder_t), intent(in) :: paths
        character(*), intent(in) :: spans_file
        real(dp), intent(in) :: given_span(:, :)
        type(level1_setup_t), intent(in) :: setup
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), allocatable, intent(out) :: spans(:, :)
        type(error_t), allocatable, intent(out) :: error

        type(level1_event_t), allocatable :: events(:)
        type(string_t), allocatable :: found(:)
        real(dp) :: first, last
        integer :: i

        spans = given_span
        if (size(spans, 2) > 0) then
            spans(2, :) = spans(1, :) + spans(2, :)
            calibration%spans_from = 'the command line'
        else if (spans_file /= '') then
            call read_spans(spans_file, calibration%satellite, spans, error)
            if (allocated(error)) return
            calibration%spans_from = 'a file'
        else
            call files_in_folder(paths%folder, found, error)
            if (allocated(error)) return
            do i = 1, size(found)
                if (.not. is_soe(found(i)%text)) cycle
                call read_events(found(i)%text, events, error)
                if (allocated(error)) return
                call manoeuvre_spans(events, calibration%satellite, spans)
                calibration%spans_from = 'the SOE file (CMCAL)'
            end do
        end if
        spans = spans - real(calibration%epoch, dp)
        first = calibration%current_time(1)
        last = calibration%current_time(size(calibration%current_time))
        if (size(spans, 2) > 0) then
            spans = reshape(pack(spans, spread(spans(2, :) > first .and. spans(1, :) < last, 1, 2)), &
                            [2, count(spans(2, :) > first .and. spans(1, :) < last)])
            if (size(spans, 2) == 0) call note(calibration, 'no span of '//trim(calibration%spans_from)//' lies within the data')
        end if
        if (size(spans, 2) == 0) then
            call find_spans(calibration%current_time, calibration%current, setup%science_current, setup%excitation_current, &
                            setup%sine_share, spans)
            calibration%spans_from = 'the currents'
        end if
        if (size(spans, 2) == 0) call fail(error, 'no manoeuvre found: no span is given, no SOE file has CMCAL events within '// &
                                           'the data, and the currents of the rods (at most '// &
                                           real_text(nint(10*maxval(abs(calibration%current)))/10.0_dp)// &
                                           ' mA) are those of science mode')
    end subroutine choose_spans

    pure logical function is_soe(path)
        character(*), intent(in) :: path

        character(:), allocatable :: name

        name = lower_case(path(index(path, '/', back=.true.) + 1:))
        is_soe = index(name, 'soe') == 1 .or. index(name, 'tn-01') == 1 .or. index(name, 'tn01') == 1 .or. &
            index(name, '_soe') > 0
    end function is_soe

    !> A file of spans: SOE, or lines of start and duration, s past 2000-01-01 12:00 GPS.
    subroutine read_spans(path, satellite, spans, error)
        character(*), intent(in) :: path
        character(1), intent(in) :: satellite
        real(dp), allocatable, intent(out) :: spans(:, :)
        type(error_t), allocatable, intent(out) :: error

        type(level1_event_t), allocatable :: events(:)
        type(error_t), allocatable :: other

        allocate (spans(2, 0))
        call read_span_lines(path, spans, other)
        if (.not. allocated(other)) return
        call read_events(path, events, error)
        if (allocated(error)) return
        call manoeuvre_spans(events, satellite, spans)
        if (size(spans, 2) == 0) call fail(error, path//': no CMCAL event of satellite '//satellite)
    end subroutine read_spans

    subroutine read_span_lines(path, spans, error)
        use gracecg_base_text, only: split_words, parse_real
        use gracecg_files_file, only: text_file_t, read_text_file
        character(*), intent(in) :: path
        real(dp), allocatable, intent(inout) :: spans(:, :)
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: file
        type(string_t), allocatable :: words(:)
        real(dp) :: start, duration
        integer :: i
        logical :: ok

        call read_text_file(path, file, error)
        if (allocated(error)) return
        do i = 1, file%line_count()
            words = split_words(file%line(i))
            if (size(words) == 0) cycle
            ok = size(words) == 2
            if (ok) call parse_real(words(1)%text, start, ok)
            if (ok) call parse_real(words(2)%text, duration, ok)
            if (ok) ok = duration > 0
            if (.not. ok) then
                call file%fail_at(i, 'expected start and duration of a span, s', error)
                return
            end if
            spans = reshape([spans, start, start + duration], [2, size(spans, 2) + 1])
        end do
    end subroutine read_span_lines

    !> Thruster firings.
    subroutine read_firings(paths, clock, calibration, windows, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)
        type(error_t), allocatable, intent(out) :: error

        character(16) :: fields(14)
        type(level1_records_t) :: records
        real(dp), allocatable :: times(:)
        character(:), allocatable :: path
        integer :: i

        do i = 1, size(calibration%spans)
            allocate (calibration%spans(i)%firings(0))
        end do
        call find_file(paths, ['THR1B', 'THR1A'], path)
        if (path == '') then
            call note(calibration, 'no THR1B or THR1A: firings of thrusters are not known, and no sample is vetoed')
            return
        end if
        fields = [('on_time_'//integer_text(i), i=1, 14)]
        call read_product(path, clock, calibration, fields, records, error, windows)
        if (allocated(error)) return
        if (records%count == 0) return
        call records%drop(.not. any(records%values > 0, 2))
        call records%times_since(calibration%epoch, times)
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                span%firings = pack(times, times > span%start - SPAN_MARGIN - 2 .and. times < span%stop + SPAN_MARGIN)
                span%firings_inside = count(span%firings > span%start .and. span%firings < span%stop)
            end associate
        end do
    end subroutine read_firings

    !> Samples of ACC1A in SRF.
    subroutine read_accelerometer(paths, setup, clock, calibration, windows, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_setup_t), intent(in) :: setup
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)
        type(error_t), allocatable, intent(out) :: error

        character(10), parameter :: FIELDS(7) = [character(10) :: 'lin_accl_x', 'lin_accl_y', 'lin_accl_z', 'ang_accl_x', &
                                                 'ang_accl_y', 'ang_accl_z', 'qualflg']
        type(level1_records_t) :: acc
        real(dp), allocatable :: times(:), steps(:)
        integer, allocatable :: wanted(:)
        logical, allocatable :: good(:)
        real(dp) :: interval
        integer(i8) :: second
        real(dp) :: fraction
        character(:), allocatable :: path
        integer :: i, k

        second = calibration%epoch
        fraction = 0
        call clock%gps_time(second, fraction)
        calibration%clock_correction = real(second - calibration%epoch, dp) + fraction
        call find_file(paths, ['ACC1A'], path)
        call read_product(path, clock, calibration, FIELDS, acc, error, windows)
        if (allocated(error)) return
        if (acc%count < 10) then
            call fail(error, acc%path//': no samples within the spans of the manoeuvre')
            return
        end if
        if (any(calibration%satellite == ['C', 'D'])) then
            good = without_bits(acc, [0, 1, 3, 4, 6])
        else
            good = without_bits(acc, [0, 1, 3, 4, 6, 7])
        end if
        good = good .and. .not. any(ieee_is_nan(acc%values(:, 1:3)), 2)
        call acc%times_since(calibration%epoch, times)
        steps = times(2:) - times(:size(times) - 1)
        interval = sum(steps, mask=steps < 0.5_dp)/max(1, count(steps < 0.5_dp))
        calibration%has_angular = .not. any(ieee_is_nan(pack(acc%values(:, 4:6), spread(good, 2, 3)))) .and. &
            maxval(abs(acc%values(:, 4:6)), mask=spread(good, 2, 3)) > 0
        calibration%zero_angular = .not. calibration%has_angular .and. &
            .not. any(ieee_is_nan(pack(acc%values(:, 4:6), spread(good, 2, 3))))
        if (calibration%zero_angular) then
            call note(calibration, 'ACC1A: all angular accelerations are zero, as in transplanted data (ACT)')
        else if (.not. calibration%has_angular) then
            call note(calibration, 'ACC1A has no angular accelerations: acc-cal and acc-raw are no sources')
        end if
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                span%expected = nint((span%stop - span%start)/interval)
                span%flagged = count(times >= span%start .and. times <= span%stop .and. .not. good)
                wanted = pack([(k, k=1, size(times))], times >= span%start .and. times <= span%stop .and. good)
                span%time = times(wanted)
                allocate (span%linear(3, size(wanted)), span%angular(3, size(wanted)))
                do k = 1, size(wanted)
                    span%linear(:, k) = srf_of_accelerometer(acc%values(wanted(k), 1:3), setup%accelerometer_axes)
                    span%angular(:, k) = srf_of_accelerometer(acc%values(wanted(k), 4:6), setup%accelerometer_axes)
                end do
            end associate
        end do
    end subroutine read_accelerometer

    !> Attitude by SCA1B, or SCA1A and QSA1B, and with the orbit what depends on it: field, vertical, gradient.
    subroutine read_attitude(paths, setup, clock, calibration, windows, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_setup_t), intent(in) :: setup
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)
        type(error_t), allocatable, intent(out) :: error

        type(level1_records_t) :: fixed, inertial
        class(geomagnetic_model_t), allocatable :: model
        real(dp), allocatable :: times(:), q(:, :)
        character(:), allocatable :: path, other
        integer :: i

        call star_cameras(paths, clock, calibration, windows, times, q, error)
        if (allocated(error)) return
        call find_file(paths, ['GNV1B'], path)
        if (path == '') then
            call fail(error, 'no file of product GNV1B of satellite '//calibration%satellite//': the orbit is not known')
            return
        end if
        call read_orbit(path, fixed)
        call find_file(paths, ['GNI1B'], other)
        if (other /= '' .and. .not. allocated(error)) call read_orbit(other, inertial)
        if (allocated(error)) return
        if (setup%field_file == '') then
            call new_geomagnetic_model('igrf14', decimal_year(utc_of_gps(calibration%epoch, 0.0_dp)), '', model, error)
        else
            call new_geomagnetic_model('file', decimal_year(utc_of_gps(calibration%epoch, 0.0_dp)), trim(setup%field_file), &
                                       model, error)
        end if
        if (allocated(error)) return
        if (other == '') call note(calibration, 'no GNI1B: Earth-fixed to inertial axes by precession and mean sidereal time '// &
                              '(some 20 arcsec)')
        do i = 1, size(calibration%spans)
            call span_attitude(calibration, calibration%spans(i), times, q, fixed, inertial, other /= '', model)
        end do

    contains

        subroutine read_orbit(path, orbit)
            character(*), intent(in) :: path
            type(level1_records_t), intent(out) :: orbit

            character(4), parameter :: STATE(6) = ['xpos', 'ypos', 'zpos', 'xvel', 'yvel', 'zvel']
            real(dp), parameter :: ORBIT_MARGIN = 130   ! s: two records of every product
            real(dp) :: wider(2, size(windows, 2))

            wider(1, :) = windows(1, :) - ORBIT_MARGIN
            wider(2, :) = windows(2, :) + ORBIT_MARGIN
            call read_product(path, clock, calibration, STATE, orbit, error, wider)
            if (allocated(error)) return
            if (orbit%count < 2) call fail(error, path//': no orbit within the spans of the manoeuvre')
        end subroutine read_orbit
    end subroutine read_attitude

    !> Times and quaternions, inertial to SRF, scalar last.
    subroutine star_cameras(paths, clock, calibration, windows, times, q, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)
        real(dp), allocatable, intent(out) :: times(:), q(:, :)
        type(error_t), allocatable, intent(out) :: error

        character(10), parameter :: FIELDS(7) = [character(10) :: 'quatangle', 'quaticoeff', 'quatjcoeff', 'quatkcoeff', &
                                                 'sca_id', 'qualflg', 'sca_mode']
        type(level1_records_t) :: sca, qsa
        real(dp) :: mounting(4)
        character(:), allocatable :: path, other
        integer :: i, k, head, number(HEADS)

        call find_file(paths, ['SCA1B'], path)
        if (path /= '') then
            call read_product(path, clock, calibration, FIELDS(:6), sca, error, windows)
            if (allocated(error)) return
            if (sca%count > 0) call sca%drop(.not. without_bits(sca, [0]))
        else
            call find_file(paths, ['SCA1A'], path)
            call find_file(paths, ['QSA1B'], other)
            if (path == '' .or. other == '') then
                call fail(error, 'no file of product SCA1B, or SCA1A with QSA1B, of satellite '//calibration%satellite// &
                          ': the attitude is not known')
                return
            end if
            call read_level1(other, qsa, error)
            if (allocated(error)) return
            call read_product(path, clock, calibration, FIELDS, sca, error, windows)
            if (allocated(error)) return
            if (sca%count > 0) call sca%drop([(.not. btest(nint(sca%values(k, 7)), 0), k=1, sca%count)])
            do head = 1, HEADS
                number(head) = count(nint(sca%values(:, 5)) == head)
            end do
            head = maxloc(number, 1)
            call note(calibration, 'no SCA1B: attitude by head '//integer_text(head)//' of SCA1A')
            call sca%drop(nint(sca%values(:, 5)) /= head)
        end if
        if (sca%count < 30) then
            call fail(error, sca%path//': no attitude within the spans of the manoeuvre')
            return
        end if
        call sca%times_since(calibration%epoch, times)
        allocate (q(4, sca%count))
        mounting = [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
        if (sca%layout%product == 'SCA1A') then
            mounting = mounting_of_head(qsa, head, calibration%epoch)
            if (norm2(mounting) < 0.5_dp) then
                call fail(error, qsa%path//': no mounting of head '//integer_text(head))
                return
            end if
        end if
        do i = 1, sca%count
            q(:, i) = attitude_by_head(mounting, gracecg_quaternion(sca%values(i, 1:4)))
        end do
        call continuous_quaternions(q)
    end subroutine star_cameras

    !> Attitude, rate, field, vertical and gradient of one span.
    subroutine span_attitude(calibration, span, times, q, fixed, inertial, has_inertial, model)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_span_t), intent(inout) :: span
        real(dp), intent(in) :: times(:), q(:, :)
        type(level1_records_t), intent(in) :: fixed, inertial
        logical, intent(in) :: has_inertial
        class(geomagnetic_model_t), intent(in) :: model

        integer, allocatable :: wanted(:)
        real(dp) :: turn(4), c(3, 3), r(3), v(3), rf(3), vf(3), b(3), to_body(3, 3)
        integer :: n, i, first, last
        integer(i8) :: second

        wanted = pack([(i, i=1, size(times))], times >= span%start - SPAN_MARGIN - 2 .and. times <= span%stop + SPAN_MARGIN + 2)
        n = size(wanted)
        span%attitude_time = times(wanted)
        span%quaternion = q(:, wanted)
        allocate (span%angle(3, n), span%rate(3, n), span%field(3, n), span%up(3, n), span%gradient(n), span%position(3, n))
        if (n < 10) then
            call leave_out(span, 'no attitude')
            return
        end if
        span%angle(:, 1) = 0
        do i = 2, n
            turn = quaternion_product(q(:, wanted(i)), conjugate_quaternion(q(:, wanted(i - 1))))
            if (turn(4) < 0) turn = -turn
            span%angle(:, i) = span%angle(:, i - 1) + rotation_vector(turn)
        end do
        do i = 1, n
            first = max(1, i - 1)
            last = min(n, i + 1)
            span%rate(:, i) = (span%angle(:, last) - span%angle(:, first))/(span%attitude_time(last) - span%attitude_time(first))
            call state_at(fixed, calibration%epoch, span%attitude_time(i), rf, vf)
            if (has_inertial) then
                call state_at(inertial, calibration%epoch, span%attitude_time(i), r, v)
                c = inertial_of_earth_fixed_by_states(r, v, rf, vf)
            else
                second = floor(span%attitude_time(i), i8)
                c = inertial_of_earth_fixed(utc_of_gps(calibration%epoch + second, span%attitude_time(i) - real(second, dp)))
            end if
            call model%evaluate(rf, b)
            span%position(:, i) = matmul(c, rf)
            to_body = matmul(rotation_matrix(q(:, wanted(i))), c)
            span%field(:, i) = matmul(to_body, b)
            span%up(:, i) = matmul(to_body, rf/norm2(rf))
            span%gradient(i) = EARTH_GM/norm2(rf)**3
        end do
        span%mean_field = sum(span%field, 2)/n
    end subroutine span_attitude

    !> The rotation vector of a quaternion with scalar part not negative.
    pure function rotation_vector(q) result(phi)
        real(dp), intent(in) :: q(4)
        real(dp) :: phi(3)

        real(dp) :: s

        s = norm2(q(1:3))
        phi = 2*q(1:3)
        if (s > 1e-8_dp) phi = 2*atan2(s, q(4))/s*q(1:3)
    end function rotation_vector

    !> Position and velocity between two records, by Hermite's cubic.
    pure subroutine state_at(orbit, epoch, time, r, v)
        type(level1_records_t), intent(in) :: orbit
        integer(i8), intent(in) :: epoch
        real(dp), intent(in) :: time                !! s from the epoch
        real(dp), intent(out) :: r(3), v(3)

        real(dp) :: h, u
        integer :: k

        k = int(max(1, min(orbit%count - 1, count(real(orbit%seconds - epoch, dp) + orbit%fraction <= time))))
        h = real(orbit%seconds(k + 1) - orbit%seconds(k), dp) + orbit%fraction(k + 1) - orbit%fraction(k)
        u = (time - real(orbit%seconds(k) - epoch, dp) - orbit%fraction(k))/h
        associate (r1 => orbit%values(k, 1:3), r2 => orbit%values(k + 1, 1:3), v1 => orbit%values(k, 4:6), &
                   v2 => orbit%values(k + 1, 4:6))
            r = (1 + 2*u)*(1 - u)**2*r1 + u**2*(3 - 2*u)*r2 + h*(u*(1 - u)**2*v1 - u**2*(1 - u)*v2)
            v = 6*u*(u - 1)/h*(r1 - r2) + (1 - u)*(1 - 3*u)*v1 + u*(3*u - 2)*v2
        end associate
    end subroutine state_at

    !> Angles of the gyros, where there are any.
    subroutine read_gyros(paths, clock, calibration, windows, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: GYROS = 4
        real(dp), parameter :: LEAST = 100      ! Samples in a span
        character(8), parameter :: FIELDS(3) = [character(8) :: 'gyro_id', 'FiltAng', 'qualflg']
        type(level1_records_t) :: imu
        real(dp), allocatable :: times(:)
        logical, allocatable :: wanted(:)
        character(:), allocatable :: path
        integer :: i, k

        do i = 1, size(calibration%spans)
            allocate (calibration%spans(i)%gyros(GYROS))
            do k = 1, GYROS
                allocate (calibration%spans(i)%gyros(k)%time(0), calibration%spans(i)%gyros(k)%angle(0))
            end do
        end do
        call find_file(paths, ['IMU1B', 'IMU1A'], path)
        if (path == '') return
        call read_product(path, clock, calibration, FIELDS, imu, error, windows)
        if (allocated(error)) return
        if (imu%count == 0) return
        call imu%drop(.not. without_bits(imu, [0, 1, 6]))
        call imu%times_since(calibration%epoch, times)
        calibration%has_gyros = .true.
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                do k = 1, GYROS
                    wanted = nint(imu%values(:, 1)) == k .and. times >= span%start - SPAN_MARGIN .and. &
                        times <= span%stop + SPAN_MARGIN
                    if (count(wanted) < LEAST) cycle
                    span%gyros(k)%time = pack(times, wanted)
                    span%gyros(k)%angle = pack(imu%values(:, 2), wanted)*DEGREE
                end do
                calibration%has_gyros = calibration%has_gyros .and. &
                    count([(size(span%gyros(k)%time) > 0, k=1, GYROS)]) >= 3
            end associate
        end do
    end subroutine read_gyros

    !> Bias of the magnetometer and the rods' part in it by least squares against the model, b = B + bias + K_mag I,
    !> and how far both fields then are apart: with spans at several places that is an upper bound of the model's error,
    !> but for a constant along SRF. Where it is wanted, the corrected field stands in for the model's.
    subroutine fit_magnetometer(calibration, replace, error)
        use gracecg_base_lapack, only: normal_equations, solve_normal_equations
        type(level1_calibration_t), intent(inout) :: calibration
        logical, intent(in) :: replace
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: STUCK = 2.5_dp   ! s without a new value
        integer, parameter :: FEWEST = 40       ! Values
        real(dp), allocatable :: rows(:, :), differences(:, :), good(:, :), good_time(:)
        real(dp) :: normal(4, 4), rhs(4), x(4), covariance(4, 4), condition, b(3), fit(4, 3), left(3), since
        integer :: i, k, axis, span, n
        logical :: fresh

        n = size(calibration%current_time)
        allocate (rows(4, n), differences(n, 3), good(3, n), good_time(n))
        n = 0
        since = -huge(since)
        do i = 2, size(calibration%current_time)
            fresh = any(abs(calibration%measured_field(:, i) - calibration%measured_field(:, i - 1)) > 0)
            if (.not. fresh) cycle
            associate (t => calibration%current_time(i))
                do span = 1, size(calibration%spans)
                    associate (s => calibration%spans(span))
                        if (size(s%attitude_time) < 4) cycle
                        if (t < s%attitude_time(1) .or. t > s%attitude_time(size(s%attitude_time))) cycle
                        call interpolate(s%attitude_time, s%field, t, b)
                    end associate
                    n = n + 1
                    rows(:, n) = [1.0_dp, calibration%current(:, i)]
                    differences(n, :) = calibration%measured_field(:, i) - b
                    good_time(n) = t
                    good(:, n) = calibration%measured_field(:, i)
                    exit
                end do
            end associate
        end do
        if (n < FEWEST) then
            if (replace) call fail(error, 'the magnetometer has no new values within the spans: use the field of the model')
            return
        end if
        do axis = 1, 3
            call normal_equations(rows(:, :n), differences(:n, axis), normal, rhs)
            call solve_normal_equations(normal, rhs, x, covariance, condition, error)
            if (allocated(error)) return
            fit(:, axis) = x
            left(axis) = sum((differences(:n, axis) - matmul(x, rows(:, :n)))**2)/n
        end do
        calibration%field_difference = sqrt(maxval(left))
        if (.not. replace) return
        do i = 1, n
            good(:, i) = good(:, i) - matmul(rows(:, i), fit)
        end do
        do span = 1, size(calibration%spans)
            associate (s => calibration%spans(span))
                do i = 1, size(s%attitude_time)
                    k = node_before(good_time(:n), s%attitude_time(i))
                    if (k < 1 .or. k >= n) cycle
                    if (good_time(k + 1) - good_time(k) > STUCK) then
                        if (s%attitude_time(i) > s%start .and. s%attitude_time(i) < s%stop .and. since < s%start) then
                            call note(calibration, 'the magnetometer sticks in span '//integer_text(span)// &
                                      ': there the field is the model''s')
                            since = s%start
                        end if
                        cycle
                    end if
                    call interpolate(good_time(:n), good(:, :n), s%attitude_time(i), b)
                    s%field(:, i) = b
                end do
            end associate
        end do
    end subroutine fit_magnetometer

    !> Leaves out samples at firings and at gaps of the currents, and spans with too little.
    subroutine edit_spans(setup, calibration)
        type(level1_setup_t), intent(in) :: setup
        type(level1_calibration_t), intent(inout) :: calibration

        real(dp), parameter :: LONGEST_STEP = 1.5_dp    ! Intervals of the currents
        logical, allocatable :: stays(:)
        real(dp) :: interval, gap
        integer :: i, k, n, before

        n = size(calibration%current_time)
        interval = median_step(calibration%current_time)
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                allocate (stays(size(span%time)), source=.true.)
                do k = 1, size(span%firings)
                    stays = stays .and. .not. (span%time > span%firings(k) - setup%veto_before .and. &
                                               span%time < span%firings(k) + setup%veto_after)
                end do
                span%vetoed = count(.not. stays)
                do k = 1, size(span%time)
                    before = node_before(calibration%current_time, span%time(k))
                    if (before < 1 .or. before >= n) then
                        stays(k) = .false.
                    else
                        if (calibration%current_time(before + 1) - calibration%current_time(before) > LONGEST_STEP*interval) &
                            stays(k) = .false.
                    end if
                end do
                span%without_current = count(.not. stays) - span%vetoed
                call keep_samples(span, stays)
                deallocate (stays)
                if (.not. span%used) cycle
                if (size(span%time) < setup%least_share*span%expected) then
                    call leave_out(span, 'only '//integer_text(size(span%time))//' of '//integer_text(span%expected)// &
                                   ' samples')
                    cycle
                end if
                gap = maxval(span%attitude_time(2:) - span%attitude_time(:size(span%attitude_time) - 1), &
                             mask=span%attitude_time(2:) > span%start .and. &
                             span%attitude_time(:size(span%attitude_time) - 1) < span%stop)
                if (gap > setup%longest_attitude_gap .or. span%attitude_time(1) > span%start .or. &
                    span%attitude_time(size(span%attitude_time)) < span%stop) &
                    call leave_out(span, 'a gap in the attitude')
            end associate
        end do
    end subroutine edit_spans

    pure real(dp) function median_step(times) result(step)
        use gracecg_base_statistics, only: median_of
        real(dp), intent(in) :: times(:)

        integer :: n

        n = min(size(times), 2000)
        step = median_of(times(2:n) - times(:n - 1))
    end function median_step

    !> Keeps some of the samples of the accelerometer.
    subroutine keep_samples(span, stays)
        type(level1_span_t), intent(inout) :: span
        logical, intent(in) :: stays(:)    !! Which, by sample

        integer, allocatable :: wanted(:)
        integer :: k

        wanted = pack([(k, k=1, size(stays))], stays)
        span%time = span%time(wanted)
        span%linear = span%linear(:, wanted)
        span%angular = span%angular(:, wanted)
    end subroutine keep_samples

    subroutine leave_out(span, reason)
        type(level1_span_t), intent(inout) :: span
        character(*), intent(in) :: reason

        span%used = .false.
        span%reason = reason
    end subroutine leave_out

    !> The gas in the tanks at the middle of the manoeuvre.
    subroutine take_gas(records, calibration)
        type(level1_records_t), intent(in) :: records
        type(level1_calibration_t), intent(inout) :: calibration

        real(dp) :: nearest, distance, middle
        integer :: i, tank, column

        middle = (calibration%spans(1)%start + calibration%spans(size(calibration%spans))%stop)/2
        do tank = 1, 2
            column = records%field_of('gas_mass_tnk'//integer_text(tank))
            nearest = huge(nearest)
            do i = 1, records%count
                distance = abs(real(records%seconds(i) - calibration%epoch, dp) - middle)
                if (ieee_is_nan(records%values(i, column)) .or. distance >= nearest) cycle
                nearest = distance
                calibration%gas(tank) = records%values(i, column)
            end do
        end do
    end subroutine take_gas
end module gracecg_estimation_level1_calibration
