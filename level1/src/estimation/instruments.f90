!> What the instruments of a folder of Level-1 files say in the spans of a manoeuvre: currents and field, firings,
!> accelerometer, gyros; in GPS time and SRF. Of a day of ACC1A nothing else is kept.
module gracecg_level1_instruments
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use gracecg_level1_basics
    use gracecg_level1_frames, only: srf_of_accelerometer
    use gracecg_level1_records, only: level1_records_t
    use gracecg_level1_calibration, only: level1_calibration_t, note, SPAN_MARGIN, find_files, read_product, without_bits
    use gracecg_level1_spans, only: find_spans
    use gracecg_level1_series, only: find_strays
    implicit none
    private
    public :: read_currents, read_firings, read_accelerometer, read_gyros

contains

    !> Net currents of the rods and the measured field, of MAG1B or MAG1A: of one file all; of several those around
    !> manoeuvres, which are looked for in one file after the other, and around the spans that are said.
    subroutine read_currents(said, calibration, error)
        real(dp), intent(in) :: said(:, :)      !! (2, n): begin and end of spans, s past 2000-01-01 12:00 GPS
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: AROUND = 600     ! s, of what is kept
        real(dp), parameter :: AT_ENDS = 60     ! s, of every file: a span may begin in one and end in the next
        type(string_t), allocatable :: found(:)
        type(level1_calibration_t) :: of_file
        real(dp), allocatable :: windows(:, :), spans(:, :)
        real(dp) :: epoch, ends(2)
        integer(i8) :: first
        integer :: i, n

        call find_files(calibration, ['MAG1B', 'MAG1A'], found)
        if (size(found) == 0) then
            call fail(error, 'no file of product MAG1B or MAG1A of satellite '//calibration%satellite//': the currents of the '// &
                      'torque rods are not known')
            return
        end if
        if (size(found) == 1) then
            call take_currents(found, calibration, error)
            return
        end if
        windows = said
        windows(1, :) = said(1, :) - AROUND
        windows(2, :) = said(2, :) + AROUND
        first = huge(first)
        of_file%satellite = calibration%satellite
        of_file%clock = calibration%clock
        allocate (of_file%notes(0))
        do i = 1, size(found)
            call take_currents(found(i:i), of_file, error)
            if (allocated(error)) return
            n = size(of_file%current_time)
            epoch = real(of_file%epoch, dp)
            ends = epoch + [0.0_dp, of_file%current_time(n)]
            call find_spans(of_file%current_time, of_file%current, calibration%setup, spans)
            if (size(spans) > 0 .or. any(said(1, :) < ends(2) .and. said(2, :) > ends(1))) first = min(first, of_file%epoch)
            spans = spans + epoch
            windows = reshape([windows, ends(1), ends(1) + AT_ENDS, ends(2) - AT_ENDS, ends(2)], [2, size(windows, 2) + 2])
            do n = 1, size(spans, 2)
                windows = reshape([windows, spans(1, n) - AROUND, spans(2, n) + AROUND], [2, size(windows, 2) + 1])
            end do
        end do
        calibration%largest_current = of_file%largest_current
        call take_currents(found, calibration, error, windows)
        if (allocated(error) .or. first == huge(first)) return
        calibration%current_time = calibration%current_time + real(calibration%epoch - first, dp)
        calibration%epoch = first
    end subroutine read_currents

    !> Net currents, |A| - |B|, and the measured field of some files.
    subroutine take_currents(found, calibration, error, windows)
        type(string_t), intent(in) :: found(:)
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: windows(:, :)     !! (2, n), s past 2000-01-01 12:00; absent: all

        character(10), parameter :: FIELDS(10) = [character(10) :: 'MfvX_RAW', 'MfvY_RAW', 'MfvZ_RAW', 'torque1A', 'torque2A', &
                                                  'torque3A', 'torque1B', 'torque2B', 'torque3B', 'qualflg']
        real(dp), parameter :: LEAST = 0.5_dp       ! mA: what has a sign
        type(level1_records_t) :: mag
        logical :: grace_fo, zero(3)                ! Of rods without any current
        integer :: negative_a, wrong_b, k

        call read_product(found, calibration, FIELDS, mag, error, windows)
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
        calibration%largest_current = max(calibration%largest_current, maxval(abs(calibration%current)))
        zero = [(.not. any(abs(calibration%current(k, :)) > 0), k=1, 3)]
        do k = 1, 3
            if (.not. zero(k) .or. all(zero)) cycle
            call note(calibration, mag%layout%product//': all currents of rod '//AXES(k)//' are zero (columns torque'// &
                      integer_text(k)//'A, torque'//integer_text(k)//'B): it is taken as off; if it was driven, take another file')
        end do
        grace_fo = any(calibration%satellite == ['C', 'D'])
        negative_a = count(mag%values(:, 4:6) < -LEAST)
        wrong_b = count(merge(mag%values(:, 7:9) > LEAST, mag%values(:, 7:9) < -LEAST, grace_fo))
        if (negative_a > 0) call note(calibration, mag%layout%product//': wrong sign of currents: '//integer_text(negative_a)// &
                                      ' A currents (positive direction) are negative; their sign is not used')
        if (wrong_b > 0) call note(calibration, mag%layout%product//': B currents with the wrong sign: '// &
                                   integer_text(wrong_b)//' are '//trim(merge('positive', 'negative', grace_fo))// &
                                   ', which is not the convention of this mission; the net current |A| - |B| does not use it')
    end subroutine take_currents

    !> Thruster firings at the spans.
    subroutine read_firings(calibration, error)
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error

        character(16) :: fields(14)
        type(level1_records_t) :: records
        real(dp), allocatable :: times(:)
        type(string_t), allocatable :: found(:)
        integer :: i

        do i = 1, size(calibration%spans)
            allocate (calibration%spans(i)%firings(0))
        end do
        call find_files(calibration, ['THR1B', 'THR1A'], found)
        if (size(found) == 0) then
            call note(calibration, 'no THR1B or THR1A: firings of thrusters are not known, and no sample is vetoed')
            return
        end if
        fields = [character(10) :: ('on_time_'//integer_text(i), i=1, 14)]
        call read_product(found, calibration, fields, records, error)
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
    subroutine read_accelerometer(calibration, windows, error)
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)    !! (2, n): begin and end, s
        type(error_t), allocatable, intent(out) :: error

        character(10), parameter :: FIELDS(7) = [character(10) :: 'lin_accl_x', 'lin_accl_y', 'lin_accl_z', 'ang_accl_x', &
                                                 'ang_accl_y', 'ang_accl_z', 'qualflg']
        type(level1_records_t) :: acc
        real(dp), allocatable :: times(:), steps(:)
        integer, allocatable :: wanted(:)
        logical, allocatable :: good(:)
        real(dp) :: interval, fraction
        integer(i8) :: second
        type(string_t), allocatable :: found(:)
        integer :: i, k

        second = calibration%epoch
        fraction = 0
        call calibration%clock%gps_time(second, fraction)
        calibration%clock_correction = real(second - calibration%epoch, dp) + fraction
        call find_files(calibration, ['ACC1A'], found)
        call read_product(found, calibration, FIELDS, acc, error, windows)
        if (allocated(error)) return
        if (acc%count < 10) then
            call fail(error, acc%path//': no samples within the spans of the manoeuvre')
            return
        end if
        good = without_bits(acc, [0, 1, 3, 4, 6]) .and. .not. any(ieee_is_nan(acc%values(:, 1:3)), 2)
        if (any(calibration%satellite == ['A', 'B'])) good = good .and. without_bits(acc, [7])
        call acc%times_since(calibration%epoch, times)
        steps = times(2:) - times(:size(times) - 1)
        interval = sum(steps, mask=steps < 0.5_dp)/max(1, count(steps < 0.5_dp))
        calibration%has_angular = .not. any(ieee_is_nan(pack(acc%values(:, 4:6), spread(good, 2, 3))))
        calibration%zero_angular = calibration%has_angular .and. &
            any([(.not. any(abs(acc%values(:, k)) > 0 .and. good), k=4, 6)])
        calibration%has_angular = calibration%has_angular .and. .not. calibration%zero_angular
        if (calibration%zero_angular) then
            call note(calibration, 'ACC1A: all angular accelerations about an axis are zero, as in transplanted data (ACT)')
        else if (.not. calibration%has_angular) then
            call note(calibration, 'ACC1A has no angular accelerations')
        end if
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                span%expected = nint((span%stop - span%start)/interval)
                span%flagged = count(times >= span%start .and. times <= span%stop .and. .not. good)
                wanted = pack([(k, k=1, size(times))], times >= span%start .and. times <= span%stop .and. good)
                span%time = times(wanted)
                allocate (span%linear(3, size(wanted)), span%angular(3, size(wanted)))
                do k = 1, size(wanted)
                    span%linear(:, k) = srf_of_accelerometer(acc%values(wanted(k), 1:3), calibration%setup%accelerometer_axes)
                    span%angular(:, k) = srf_of_accelerometer(acc%values(wanted(k), 4:6), calibration%setup%accelerometer_axes)
                end do
            end associate
        end do
    end subroutine read_accelerometer

    !> Angles of the gyros, where there are any.
    subroutine read_gyros(calibration, windows, error)
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)    !! (2, n): begin and end, s
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: GYROS = 4
        real(dp), parameter :: LEAST = 100      ! Samples in a span
        real(dp), parameter :: NOISE = 1e-6_dp  ! rad
        character(8), parameter :: FIELDS(3) = [character(8) :: 'gyro_id', 'FiltAng', 'qualflg']
        type(level1_records_t) :: imu
        real(dp), allocatable :: times(:)
        logical, allocatable :: wanted(:)
        type(string_t), allocatable :: found(:)
        logical, allocatable :: stray(:)
        integer :: i, k, n_stray

        do i = 1, size(calibration%spans)
            allocate (calibration%spans(i)%gyros(GYROS))
            do k = 1, GYROS
                allocate (calibration%spans(i)%gyros(k)%time(0), calibration%spans(i)%gyros(k)%angle(0))
            end do
        end do
        call find_files(calibration, ['IMU1B', 'IMU1A'], found)
        if (size(found) == 0) return
        call read_product(found, calibration, FIELDS, imu, error, windows)
        if (allocated(error)) return
        if (imu%count == 0) return
        call imu%drop(.not. without_bits(imu, [0, 1, 6]))
        call imu%times_since(calibration%epoch, times)
        calibration%has_gyros = .true.
        n_stray = 0
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                do k = 1, GYROS
                    wanted = nint(imu%values(:, 1)) == k .and. times >= span%start - SPAN_MARGIN .and. &
                        times <= span%stop + SPAN_MARGIN
                    if (count(wanted) < LEAST) cycle
                    span%gyros(k)%time = pack(times, wanted)
                    span%gyros(k)%angle = pack(imu%values(:, 2), wanted)*DEGREE
                    associate (gyro => span%gyros(k))
                        stray = find_strays(gyro%time, reshape(gyro%angle, [1, size(gyro%angle)]), NOISE)
                        n_stray = n_stray + count(stray)
                        gyro%time = pack(gyro%time, .not. stray)
                        gyro%angle = pack(gyro%angle, .not. stray)
                    end associate
                end do
                calibration%has_gyros = calibration%has_gyros .and. &
                    count([(size(span%gyros(k)%time) > 0, k=1, GYROS)]) >= 3
            end associate
        end do
        if (n_stray > 0) call note(calibration, 'gyros: '//integer_text(n_stray)// &
                                   ' angles are far off their neighbours and left out')
    end subroutine read_gyros
end module gracecg_level1_instruments
