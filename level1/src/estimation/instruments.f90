!> What the instruments of a folder of Level-1 files say in the spans of a manoeuvre: currents and field, firings,
!> accelerometer, attitude and orbit, gyros; in GPS time and SRF. Of a day of ACC1A nothing else is kept.
module gracecg_level1_instruments
    use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: DEGREE, EARTH_GM, MICROMETRE
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, integer_text
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion, rotation_matrix
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model
    use gracecg_environment_time, only: utc_of_gps, decimal_year
    use gracecg_level1_frames, only: srf_of_accelerometer, gracecg_quaternion, continuous_quaternions, &
        mounting_of_head, attitude_by_head, inertial_of_earth_fixed_by_states, inertial_of_earth_fixed
    use gracecg_level1_folder, only: level1_folder_t
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_time, only: level1_clock_t, to_gps_time
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t, level1_firing_t, leave_out, &
        note, middle_of, SPAN_MARGIN, FIRING_MARGIN
    use gracecg_level1_heads, only: combine_heads, rotation_vector
    use gracecg_level1_spans, only: find_spans
    implicit none
    private
    public :: find_files, read_currents, read_firings, read_accelerometer, read_attitude, read_gyros

    integer, parameter :: HEADS = 3
    real(dp), parameter :: ORBIT_MARGIN = 130   !! Orbits are read so much farther, s: two records of every product

contains

    !> The files of one of some products, on every day that has one: the first product that is there on as many days as
    !> any of them.
    subroutine find_files(files, products, paths)
        type(level1_folder_t), intent(in) :: files
        character(5), intent(in) :: products(:)    !! Names of products, the preferred first
        type(string_t), allocatable, intent(out) :: paths(:)    !! In order of the days; none: there is none

        type(string_t), allocatable :: others(:)
        integer :: i

        allocate (paths(0))
        do i = 1, size(products)
            call files%paths_of(products(i), others)
            if (size(others) > size(paths)) call move_alloc(others, paths)
        end do
    end subroutine find_files

    !> Reads the wanted fields of a product in GPS time.
    subroutine read_product(paths, clock, calibration, fields, records, error, windows)
        type(string_t), intent(in) :: paths(:)
        character(*), intent(in) :: fields(:)
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        type(level1_records_t), intent(out) :: records
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: windows(:, :)     !! (2, n), s past 2000-01-01 12:00; absent: all

        integer :: extrapolated, i

        call read_level1(paths, records, error, fields, windows)
        if (allocated(error)) return
        if (records%count == 0) return
        if (records%satellite /= calibration%satellite) then
            call fail(error, records%path//': its records are of satellite '//records%satellite//', not '// &
                      calibration%satellite)
            return
        end if
        if (records%layout%product(5:5) == 'A' .and. records%time_ref == 'G') call note(calibration, records%layout%product// &
            ': its tags say GPS time, a 1A product has those of the on-board computer: they may be tags left in OBC time')
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

    !> Net currents of the rods and the measured field, of MAG1B or MAG1A: of one file all; of several those around
    !> manoeuvres, which are looked for in one file after the other, and around the spans that are said.
    subroutine read_currents(paths, clock, setup, said, calibration, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_clock_t), intent(in) :: clock
        type(level1_setup_t), intent(in) :: setup
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

        call find_files(paths, ['MAG1B', 'MAG1A'], found)
        if (size(found) == 0) then
            call fail(error, 'no file of product MAG1B or MAG1A of satellite '//calibration%satellite//': the currents of the '// &
                      'torque rods are not known')
            return
        end if
        if (size(found) == 1) then
            call take_currents(found, clock, calibration, error)
            return
        end if
        windows = said
        windows(1, :) = said(1, :) - AROUND
        windows(2, :) = said(2, :) + AROUND
        first = huge(first)
        of_file%satellite = calibration%satellite
        allocate (of_file%notes(0))
        do i = 1, size(found)
            call take_currents(found(i:i), clock, of_file, error)
            if (allocated(error)) return
            n = size(of_file%current_time)
            epoch = real(of_file%epoch, dp)
            ends = epoch + [0.0_dp, of_file%current_time(n)]
            call find_spans(of_file%current_time, of_file%current, setup%science_current, setup%excitation_current, &
                            setup%sine_share, spans)
            if (size(spans) > 0 .or. any(said(1, :) < ends(2) .and. said(2, :) > ends(1))) first = min(first, of_file%epoch)
            spans = spans + epoch
            windows = reshape([windows, ends(1), ends(1) + AT_ENDS, ends(2) - AT_ENDS, ends(2)], [2, size(windows, 2) + 2])
            do n = 1, size(spans, 2)
                windows = reshape([windows, spans(1, n) - AROUND, spans(2, n) + AROUND], [2, size(windows, 2) + 1])
            end do
        end do
        calibration%largest_current = of_file%largest_current
        call take_currents(found, clock, calibration, error, windows)
        if (allocated(error) .or. first == huge(first)) return
        calibration%current_time = calibration%current_time + real(calibration%epoch - first, dp)
        calibration%epoch = first
    end subroutine read_currents

    !> Net currents, |A| - |B|, and the measured field of some files.
    subroutine take_currents(found, clock, calibration, error, windows)
        type(string_t), intent(in) :: found(:)
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: windows(:, :)     !! (2, n), s past 2000-01-01 12:00; absent: all

        character(10), parameter :: FIELDS(10) = [character(10) :: 'MfvX_RAW', 'MfvY_RAW', 'MfvZ_RAW', 'torque1A', 'torque2A', &
                                                  'torque3A', 'torque1B', 'torque2B', 'torque3B', 'qualflg']
        real(dp), parameter :: LEAST = 0.5_dp       ! mA: what has a sign
        type(level1_records_t) :: mag
        logical :: grace_fo
        integer :: negative_a, wrong_b

        call read_product(found, clock, calibration, FIELDS, mag, error, windows)
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
        grace_fo = any(calibration%satellite == ['C', 'D'])
        negative_a = count(mag%values(:, 4:6) < -LEAST)
        wrong_b = count(merge(mag%values(:, 7:9) > LEAST, mag%values(:, 7:9) < -LEAST, grace_fo))
        if (negative_a > 0) call note(calibration, mag%layout%product//': wrong sign of currents: '//integer_text(negative_a)// &
                                      ' A currents (positive direction) are negative; their sign is not used')
        if (wrong_b > 0) call note(calibration, mag%layout%product//': B currents with the wrong sign: '// &
                                   integer_text(wrong_b)//' are '//trim(merge('positive', 'negative', grace_fo))// &
                                   ', which is not the convention of this mission; the net current |A| - |B| does not use it')
    end subroutine take_currents

    !> Thruster firings: those at the spans, and of the others outside of them the nearest, which tell of delays.
    subroutine read_firings(paths, clock, calibration, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: MOST = 40
        real(dp), parameter :: MILLISECOND = 1e-3_dp
        character(16) :: fields(14)
        type(level1_records_t) :: records
        real(dp), allocatable :: times(:), away(:)
        logical, allocatable :: alone(:)
        type(string_t), allocatable :: found(:)
        integer :: i, n

        allocate (calibration%firings(0))
        do i = 1, size(calibration%spans)
            allocate (calibration%spans(i)%firings(0))
        end do
        call find_files(paths, ['THR1B', 'THR1A'], found)
        if (size(found) == 0) then
            call note(calibration, 'no THR1B or THR1A: firings of thrusters are not known, and no sample is vetoed')
            return
        end if
        fields = [character(10) :: ('on_time_'//integer_text(i), i=1, 14)]
        call read_product(found, clock, calibration, fields, records, error)
        if (allocated(error)) return
        if (records%count == 0) return
        call records%drop(.not. any(records%values > 0, 2))
        call records%times_since(calibration%epoch, times)
        n = size(times)
        allocate (alone(n), source=.true.)
        alone(2:) = alone(2:) .and. times(2:) - times(:n - 1) > 2*FIRING_MARGIN
        alone(:n - 1) = alone(:n - 1) .and. times(2:) - times(:n - 1) > 2*FIRING_MARGIN
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                span%firings = pack(times, times > span%start - SPAN_MARGIN - 2 .and. times < span%stop + SPAN_MARGIN)
                span%firings_inside = count(span%firings > span%start .and. span%firings < span%stop)
                alone = alone .and. (times < span%start - FIRING_MARGIN .or. times > span%stop + FIRING_MARGIN)
            end associate
        end do
        away = abs(times + real(calibration%epoch, dp) - middle_of(calibration))
        do while (size(calibration%firings) < MOST .and. any(alone))
            i = minloc(away, 1, mask=alone)
            alone(i) = .false.
            calibration%firings = [calibration%firings, level1_firing_t(time=times(i), &
                                                                        duration=maxval(records%values(i, :))*MILLISECOND)]
        end do
    end subroutine read_firings

    !> The times of firings with their margins, beside those of the spans.
    pure function with_firings(windows, calibration) result(wider)
        real(dp), intent(in) :: windows(:, :)       !! (2, n), s past 2000-01-01 12:00
        type(level1_calibration_t), intent(in) :: calibration
        real(dp), allocatable :: wider(:, :)

        integer :: i, n

        n = size(windows, 2)
        allocate (wider(2, n + size(calibration%firings)))
        wider(:, :n) = windows
        do i = 1, size(calibration%firings)
            wider(:, n + i) = real(calibration%epoch, dp) + calibration%firings(i)%time + &
                (FIRING_MARGIN + 1)*[-1, 1]         ! tags are up to a second from GPS time
        end do
    end function with_firings

    !> Samples of ACC1A in SRF.
    subroutine read_accelerometer(paths, setup, clock, calibration, windows, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_setup_t), intent(in) :: setup
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)    !! (2, n): begin and end, s
        type(error_t), allocatable, intent(out) :: error

        character(10), parameter :: FIELDS(7) = [character(10) :: 'lin_accl_x', 'lin_accl_y', 'lin_accl_z', 'ang_accl_x', &
                                                 'ang_accl_y', 'ang_accl_z', 'qualflg']
        type(level1_records_t) :: acc
        real(dp), allocatable :: times(:), steps(:)
        integer, allocatable :: wanted(:)
        logical, allocatable :: good(:)
        real(dp) :: interval, sample(6)
        integer(i8) :: second
        real(dp) :: fraction
        type(string_t), allocatable :: found(:)
        integer :: i, k

        second = calibration%epoch
        fraction = 0
        call clock%gps_time(second, fraction)
        calibration%clock_correction = real(second - calibration%epoch, dp) + fraction
        call find_files(paths, ['ACC1A'], found)
        call read_product(found, clock, calibration, FIELDS, acc, error, with_firings(windows, calibration))
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
                    sample = acc%values(wanted(k), 1:6)
                    span%linear(:, k) = srf_of_accelerometer(sample(:3), setup%accelerometer_axes)
                    span%angular(:, k) = srf_of_accelerometer(sample(4:), setup%accelerometer_axes)
                end do
            end associate
        end do
        do i = 1, size(calibration%firings)
            associate (firing => calibration%firings(i))
                wanted = pack([(k, k=1, size(times))], abs(times - firing%time) < FIRING_MARGIN .and. good)
                firing%sample_time = times(wanted)
                allocate (firing%linear(3, size(wanted)))
                do k = 1, size(wanted)
                    sample(:3) = acc%values(wanted(k), 1:3)
                    firing%linear(:, k) = srf_of_accelerometer(sample(:3), setup%accelerometer_axes)
                end do
            end associate
        end do
    end subroutine read_accelerometer

    !> Leaves a span out that the records of an orbit do not reach around, or with a gap.
    subroutine check_orbit(orbit, epoch, span)
        type(level1_records_t), intent(in) :: orbit
        integer(i8), intent(in) :: epoch
        type(level1_span_t), intent(inout) :: span

        real(dp), parameter :: NEEDED = 5       ! s, around the span
        real(dp) :: times(orbit%count), first, last

        times = real(orbit%seconds - epoch, dp) + orbit%fraction
        first = span%start - NEEDED
        last = span%stop + NEEDED
        if (times(1) <= first .and. times(size(times)) >= last) then
            if (all(times(2:) - times(:size(times) - 1) < ORBIT_MARGIN .or. times(2:) < first .or. &
                    times(:size(times) - 1) > last)) return
        end if
        call leave_out(span, 'a gap in the orbit')
    end subroutine check_orbit

    !> Attitude by SCA1B, or SCA1A and QSA1B, and with the orbit what depends on it: field, vertical, gradient.
    subroutine read_attitude(paths, setup, clock, calibration, windows, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_setup_t), intent(in) :: setup
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)    !! (2, n): begin and end, s
        type(error_t), allocatable, intent(out) :: error

        type(level1_records_t) :: fixed, inertial
        class(geomagnetic_model_t), allocatable :: model
        real(dp), allocatable :: times(:), q(:, :)
        type(string_t), allocatable :: found(:), others(:)
        logical :: has_fixed, has_inertial
        integer :: i

        call star_cameras(paths, clock, calibration, windows, times, q, error)
        if (allocated(error)) return
        call find_files(paths, ['GNV1B'], found)
        call find_files(paths, ['GNI1B'], others)
        has_fixed = size(found) > 0
        has_inertial = size(others) > 0
        if (.not. (has_fixed .or. has_inertial)) then
            call fail(error, 'no file of product GNV1B or GNI1B of satellite '//calibration%satellite//': the orbit is not known')
            return
        end if
        if (has_fixed) call read_orbit(found, fixed)
        if (has_inertial .and. .not. allocated(error)) call read_orbit(others, inertial)
        if (allocated(error)) return
        if (setup%field_file == '') then
            call new_geomagnetic_model('igrf14', decimal_year(utc_of_gps(calibration%epoch, 0.0_dp)), '', model, error)
        else
            call new_geomagnetic_model('file', decimal_year(utc_of_gps(calibration%epoch, 0.0_dp)), trim(setup%field_file), &
                                       model, error)
        end if
        if (allocated(error)) return
        if (.not. (has_fixed .and. has_inertial)) call note(calibration, 'no '//merge('GNI1B', 'GNV1B', has_fixed)// &
            ': Earth-fixed to inertial axes by precession, nutation and UT1 = UTC (some arcsec)')
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (has_fixed) call check_orbit(fixed, calibration%epoch, span)
                if (has_inertial) call check_orbit(inertial, calibration%epoch, span)
                call span_attitude(calibration, span, times, q, fixed, inertial, has_fixed, has_inertial, model)
            end associate
        end do

    contains

        subroutine read_orbit(found, orbit)
            type(string_t), intent(in) :: found(:)
            type(level1_records_t), intent(out) :: orbit

            character(4), parameter :: STATE(6) = ['xpos', 'ypos', 'zpos', 'xvel', 'yvel', 'zvel']
            real(dp) :: wider(2, size(windows, 2))

            wider(1, :) = windows(1, :) - ORBIT_MARGIN
            wider(2, :) = windows(2, :) + ORBIT_MARGIN
            call read_product(found, clock, calibration, STATE, orbit, error, wider)
            if (allocated(error)) return
            if (orbit%count < 2) call fail(error, orbit%path//': no orbit within the spans of the manoeuvre')
        end subroutine read_orbit
    end subroutine read_attitude

    !> Times and quaternions, inertial to SRF, scalar last.
    subroutine star_cameras(paths, clock, calibration, windows, times, q, error)
        type(level1_folder_t), intent(in) :: paths
        type(level1_clock_t), intent(in) :: clock
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), intent(in) :: windows(:, :)    !! (2, n): begin and end, s
        real(dp), allocatable, intent(out) :: times(:), q(:, :)
        type(error_t), allocatable, intent(out) :: error

        character(10), parameter :: FIELDS(7) = [character(10) :: 'quatangle', 'quaticoeff', 'quatjcoeff', 'quatkcoeff', &
                                                 'sca_id', 'qualflg', 'sca_mode']
        type(level1_records_t) :: sca, qsa
        real(dp), allocatable :: joint_times(:), joint_q(:, :)
        real(dp) :: mounting(4, HEADS), sample(4)
        type(string_t), allocatable :: found(:), others(:)
        character(:), allocatable :: names
        logical :: heads_alone, known(HEADS)
        integer :: i, k, head

        call find_files(paths, ['SCA1B'], found)
        heads_alone = size(found) == 0
        if (.not. heads_alone) then
            call read_product(found, clock, calibration, FIELDS(:6), sca, error, windows)
            if (allocated(error)) return
            if (sca%count > 0) call sca%drop(.not. without_bits(sca, [0]))
        else
            call find_files(paths, ['SCA1A'], found)
            call find_files(paths, ['QSA1B'], others)
            if (size(found) == 0 .or. size(others) == 0) then
                call fail(error, 'no file of product SCA1B, or SCA1A with QSA1B, of satellite '//calibration%satellite// &
                          ': the attitude is not known')
                return
            end if
            call read_level1(others, qsa, error)
            if (allocated(error)) return
            call read_product(found, clock, calibration, FIELDS, sca, error, windows)
            if (allocated(error)) return
            if (sca%count > 0) call sca%drop([(.not. btest(nint(sca%values(k, 7)), 0), k=1, sca%count)])
            names = ''
            do head = 1, HEADS
                mounting(:, head) = mounting_of_head(qsa, head, calibration%epoch)
                known(head) = norm2(mounting(:, head)) > 0.5_dp
                if (any(nint(sca%values(:sca%count, 5)) == head) .and. known(head)) names = names//' '//integer_text(head)
            end do
            if (sca%count > 0) call sca%drop([(.not. any(nint(sca%values(k, 5)) == pack([1, 2, 3], known)), k=1, sca%count)])
            if (sca%count > 0) call note(calibration, 'no SCA1B: attitude by the heads of SCA1A together:'//names)
        end if
        if (sca%count < 30) then
            call fail(error, sca%path//': no attitude within the spans of the manoeuvre')
            return
        end if
        call sca%times_since(calibration%epoch, times)
        allocate (q(4, sca%count))
        do i = 1, sca%count
            sample = sca%values(i, 1:4)
            q(:, i) = gracecg_quaternion(sample)
            if (heads_alone) q(:, i) = attitude_by_head(mounting(:, nint(sca%values(i, 5))), q(:, i))
        end do
        if (heads_alone) then
            call combine_heads(times, nint(sca%values(:sca%count, 5)), q, mounting, joint_times, joint_q)
            call move_alloc(joint_times, times)
            call move_alloc(joint_q, q)
        end if
        call continuous_quaternions(q)
    end subroutine star_cameras

    !> Attitude, rate, field, vertical and gradient of one span.
    subroutine span_attitude(calibration, span, times, q, fixed, inertial, has_fixed, has_inertial, model)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_span_t), intent(inout) :: span
        real(dp), intent(in) :: times(:), q(:, :)
        type(level1_records_t), intent(in) :: fixed, inertial
        logical, intent(in) :: has_fixed, has_inertial      ! One of both at least
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
            if (has_fixed) call state_at(fixed, calibration%epoch, span%attitude_time(i), rf, vf)
            if (has_inertial) call state_at(inertial, calibration%epoch, span%attitude_time(i), r, v)
            if (has_fixed .and. has_inertial) then
                c = inertial_of_earth_fixed_by_states(r, v, rf, vf)
            else
                second = floor(span%attitude_time(i), i8)
                c = inertial_of_earth_fixed(utc_of_gps(calibration%epoch + second, span%attitude_time(i) - real(second, dp)))
                if (.not. has_fixed) rf = matmul(r, c)
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
        real(dp), intent(in) :: windows(:, :)    !! (2, n): begin and end, s
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: GYROS = 4
        real(dp), parameter :: LEAST = 100      ! Samples in a span
        character(8), parameter :: FIELDS(3) = [character(8) :: 'gyro_id', 'FiltAng', 'qualflg']
        type(level1_records_t) :: imu
        real(dp), allocatable :: times(:)
        logical, allocatable :: wanted(:)
        type(string_t), allocatable :: found(:)
        integer :: i, k

        do i = 1, size(calibration%spans)
            allocate (calibration%spans(i)%gyros(GYROS))
            do k = 1, GYROS
                allocate (calibration%spans(i)%gyros(k)%time(0), calibration%spans(i)%gyros(k)%angle(0))
            end do
        end do
        do i = 1, size(calibration%firings)
            allocate (calibration%firings(i)%gyros(GYROS))
            do k = 1, GYROS
                allocate (calibration%firings(i)%gyros(k)%time(0), calibration%firings(i)%gyros(k)%angle(0))
            end do
        end do
        call find_files(paths, ['IMU1B', 'IMU1A'], found)
        if (size(found) == 0) return
        call read_product(found, clock, calibration, FIELDS, imu, error, with_firings(windows, calibration))
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
        do i = 1, size(calibration%firings)
            associate (firing => calibration%firings(i))
                do k = 1, GYROS
                    wanted = nint(imu%values(:, 1)) == k .and. abs(times - firing%time) < FIRING_MARGIN
                    firing%gyros(k)%time = pack(times, wanted)
                    firing%gyros(k)%angle = pack(imu%values(:, 2), wanted)*DEGREE
                end do
            end associate
        end do
    end subroutine read_gyros
end module gracecg_level1_instruments
