!> A calibration gathered from Level-1 files, and edited: samples at firings and gaps, spans with too little.
module gracecg_level1_gathering
    use gracecg_level1_basics
    use gracecg_environment_sun, only: sun_position, conical_shadow
    use gracecg_environment_time, only: julian_centuries_tt
    use gracecg_estimation_outlier_editing, only: leave_out_worst, MEDIAN_OF_ONE
    use gracecg_level1_folder, only: open_level1_folder
    use gracecg_level1_records, only: level1_records_t, read_level1
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_time, only: new_level1_clock, gps_day
    use gracecg_level1_calibration, only: level1_calibration_t, name_of_span, keep_samples, leave_out, note, middle_of, &
        utc_at, SPAN_MARGIN, find_files, note_product, check_satellite
    use gracecg_level1_along_orbit, only: compare_along_orbit
    use gracecg_level1_attitude_reading, only: read_attitude
    use gracecg_level1_instruments, only: read_currents, read_firings, read_accelerometer, read_gyros
    use gracecg_level1_series, only: interpolate, find_strays, take_away
    use gracecg_level1_spans, only: said_spans, choose_spans, equal_spans
    implicit none
    private
    public :: gather_calibration

    real(dp), parameter :: READ_MARGIN = 8      !! Records are read so much farther than SPAN_MARGIN, s
    real(dp), parameter :: LONGEST_SPAN = 900   !! In s; the parabola of a span follows no more of what is slow

contains

    !> Gathers a calibration. Fails when a file that is needed is missing or broken, and when there is no manoeuvre.
    subroutine gather_calibration(places, setup, satellite, spans_file, given_span, field_choice, calibration, error, day, &
                                  every, part, longest)
        character(*), intent(in) :: places(:)       !! Of the Level-1 files: folders, bundles, files
        type(level1_setup_t), intent(in) :: setup
        character(*), intent(in) :: satellite       !! A to D; blank: the only one there is
        character(*), intent(in) :: spans_file      !! SOE, or lines of start and duration; blank: an SOE file beside them, or
                                                    !! by the currents
        real(dp), intent(in) :: given_span(:, :)    !! (2, n): start and duration, s past 2000-01-01 12:00 GPS
        character(*), intent(in) :: field_choice    !! model or magnetometer
        type(level1_calibration_t), intent(out) :: calibration
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: day   !! That has part of the manoeuvre, YYYY-MM-DD; absent or empty: all files
        real(dp), intent(in), optional :: every     !! Rods are driven all the time: spans of so many seconds throughout the
                                                    !! files, or the first one given; absent or 0: a manoeuvre
        integer, intent(in), optional :: part       !! Of these spans, that alone is read; absent: all
        real(dp), intent(in), optional :: longest   !! Part, s; absent: all are one

        real(dp), allocatable :: said(:, :), spans(:, :), windows(:, :)
        character(:), allocatable :: wanted
        integer :: i

        wanted = ''
        if (present(day)) wanted = day
        calibration%setup = setup
        call open_files(places, satellite, wanted, calibration, error)
        if (.not. allocated(error)) call make_clock(calibration, error)
        if (present(every)) calibration%all_day = every > 0
        if (calibration%all_day) then
            said = reshape([0.0_dp, huge(1.0_dp)/2], [2, 1])
            if (size(given_span) > 0) said = reshape([given_span(1, 1), sum(given_span(:, 1))], [2, 1])
            if (.not. allocated(error)) call read_currents(said, calibration, error)
            if (allocated(error)) return
            spans = equal_spans(calibration%current_time, said(:, 1) - real(calibration%epoch, dp), every)
            if (present(part) .and. present(longest)) call take_part(part, longest, calibration, spans)
            calibration%spans_from = merge('a part of the files   ', 'the whole of the files', size(given_span) > 0)
        else
            if (.not. allocated(error)) call said_spans(spans_file, given_span, calibration, said, error)
            if (.not. allocated(error)) call read_currents(said, calibration, error)
            if (.not. allocated(error)) call choose_spans(said, wanted, calibration, spans, error)
            if (allocated(error)) return
        end if
        if (size(calibration%files%days) > 1) calibration%date = gps_day(calibration%epoch + floor(spans(1, 1), i8))
        allocate (calibration%spans(size(spans, 2)))
        do i = 1, size(spans, 2)
            calibration%spans(i)%start = spans(1, i)
            calibration%spans(i)%stop = spans(2, i)
            if (spans(2, i) - spans(1, i) > LONGEST_SPAN .and. .not. calibration%all_day) &
                call leave_out(calibration%spans(i), 'longer than '// &
                integer_text(nint(LONGEST_SPAN))//' s: give its sub-manoeuvres')
        end do
        windows = spans + real(calibration%epoch, dp)
        windows(1, :) = windows(1, :) - SPAN_MARGIN - READ_MARGIN
        windows(2, :) = windows(2, :) + SPAN_MARGIN + READ_MARGIN
        call read_firings(calibration, error)
        if (.not. allocated(error)) call read_accelerometer(calibration, windows, error)
        if (.not. allocated(error)) call read_attitude(calibration, windows, error)
        if (.not. allocated(error)) call read_gyros(calibration, windows, error)
        if (allocated(error)) return
        call fit_magnetometer(calibration, field_choice == 'magnetometer', error)
        if (allocated(error)) return
        call edit_spans(calibration)
        call find_shadow_edges(calibration)
        call read_masses(calibration, error)
        if (allocated(error)) return
        call compare_along_orbit(calibration)
    end subroutine gather_calibration

    !> The spans of a part.
    subroutine take_part(part, longest, calibration, spans)
        integer, intent(in) :: part                 !! From 1 on
        real(dp), intent(in) :: longest             !! s
        type(level1_calibration_t), intent(inout) :: calibration
        real(dp), allocatable, intent(inout) :: spans(:, :)     !! (2, n): begin and end, s

        integer :: n

        n = size(spans, 2)
        calibration%parts = min(n, ceiling((spans(2, n) - spans(1, 1))/longest))
        calibration%before = (part - 1)*n/calibration%parts
        spans = spans(:, calibration%before + 1:part*n/calibration%parts)
    end subroutine take_part

    !> The files of the satellite that is asked for, or of the first one. Fails without ACC1A.
    subroutine open_files(places, satellite, day, calibration, error)
        character(*), intent(in) :: places(:), satellite, day
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: found(:)

        associate (files => calibration%files)
            call open_level1_folder(places, satellite, files, error, day)
            if (allocated(error)) return
            calibration%satellite = files%satellite
            calibration%date = files%date
            calibration%notes = files%warnings
            call files%paths_of('ACC1A', found)
            if (size(found) > 0) return
            call fail(error, files%places//': no file of product ACC1A of satellite '//files%satellite//', which is the '// &
                      'observation; its name is like ACC1A_2020-02-01_C_04.txt')
        end associate
        call find_files(calibration, ['ACT1A', 'ACT1B'], found)
        if (size(found) > 0) error%message = error%message//'. ACT data are no observation: they may be transplanted from '// &
            'the other satellite, and have no angular accelerations'
    end subroutine open_files

    !> Time: CLK1B, TIM1B. Without CLK1B tags are taken as they are, and that is said.
    subroutine make_clock(calibration, error)
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error

        type(level1_records_t) :: clk, tim
        type(string_t), allocatable :: found(:), others(:)

        call calibration%files%paths_of('CLK1B', found)
        call calibration%files%paths_of('TIM1B', others)
        if (size(found) == 0) then
            call fail(error, 'no file of product CLK1B of satellite '//calibration%satellite//': the tags of ACC1A cannot be '// &
                      'taken to GPS time')
            return
        end if
        call read_level1(found, clk, error)
        if (.not. allocated(error)) call check_satellite(clk, calibration%satellite, error)
        if (allocated(error)) return
        call note_product(calibration, 'CLK1B', found)
        if (size(others) > 0) then
            call note_product(calibration, 'TIM1B', others)
            call read_level1(others, tim, error)
            if (.not. allocated(error)) call check_satellite(tim, calibration%satellite, error)
        else
            call note(calibration, 'no TIM1B: receiver time is taken as that of the on-board computer')
        end if
        if (.not. allocated(error)) call new_level1_clock(calibration%clock, error, clk, tim)
    end subroutine make_clock

    !> Bias of the magnetometer and the rods' part in it by least squares against the model, b = B + bias + K_mag I +
    !> R dI/dt (for currents flow, and the field is read, some time before or behind their tags), and how far both fields
    !> then are apart: with spans at several places that is an upper bound of the model's error, but for a constant along
    !> SRF. Where it is wanted, the corrected field stands in for the model's.
    subroutine fit_magnetometer(calibration, replace, error)
        type(level1_calibration_t), intent(inout) :: calibration
        logical, intent(in) :: replace
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: STUCK = 2.5_dp   ! s without a new value
        integer, parameter :: FEWEST = 40       ! Values
        real(dp), parameter :: FAR_OFF = 20     ! Standard deviations
        real(dp), parameter :: NOISE = 100*NANOTESLA    ! At least: rods whose currents are held look like 1 uT
        real(dp), allocatable :: rows(:, :), differences(:, :), rates(:, :), good(:, :), good_time(:)
        integer, parameter :: COLUMNS = 7       ! Bias, currents, their rates
        real(dp) :: normal(COLUMNS, COLUMNS), rhs(COLUMNS), x(COLUMNS), covariance(COLUMNS, COLUMNS), condition, b(3), &
            fit(COLUMNS, 3), left(3), since, rate(3)
        integer :: i, k, axis, span, n
        logical, allocatable :: kept(:), before(:)
        logical :: fresh, changed

        n = size(calibration%current_time)
        allocate (rows(COLUMNS, n), differences(n, 6), rates(n, 3), good(3, n), good_time(n))
        n = 0
        since = -huge(since)
        do i = 2, size(calibration%current_time) - 1
            fresh = any(abs(calibration%measured_field(:, i) - calibration%measured_field(:, i - 1)) > 0)
            if (.not. fresh) cycle
            associate (t => calibration%current_time(i))
                do span = 1, size(calibration%spans)
                    associate (s => calibration%spans(span))
                        if (.not. s%used .or. size(s%attitude_time) < 4) cycle
                        if (t < s%attitude_time(1) .or. t > s%attitude_time(size(s%attitude_time))) cycle
                        call interpolate(s%attitude_time, s%field, t, b)
                        call interpolate(s%attitude_time, s%field_rate, t, rate)
                    end associate
                    n = n + 1
                    rates(n, :) = rate
                    rows(:, n) = [1.0_dp, calibration%current(:, i), &
                                  (calibration%current(:, i + 1) - calibration%current(:, i - 1))/ &
                                  (calibration%current_time(i + 1) - calibration%current_time(i - 1))]
                    differences(n, :3) = calibration%measured_field(:, i) - b
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
        call compare_fields(good(:, :n), good(:, :n) - transpose(differences(:n, :3)), replace, calibration, error)
        if (allocated(error)) return
        allocate (kept(n), source=.true.)
        do
            do axis = 1, 3
                call normal_equations(rows(:, pack([(k, k=1, n)], kept)), pack(differences(:n, axis), kept), normal, rhs)
                do k = 2, COLUMNS
                    if (.not. normal(k, k) > 0) normal(k, k) = 1        ! a rod that has no currents does nothing
                end do
                call solve_normal_equations(normal, rhs, x, covariance, condition, error)
                if (allocated(error)) return
                fit(:, axis) = x
                differences(:n, 3 + axis) = abs(differences(:n, axis) - matmul(x, rows(:, :n)))/NOISE
                left(axis) = sum((differences(:n, 3 + axis)*NOISE)**2, mask=kept)/count(kept)
            end do
            changed = .false.
            before = kept
            do axis = 4, 6
                call leave_out_worst(differences(:n, axis), FAR_OFF, MEDIAN_OF_ONE, before, changed)
                kept = kept .and. before
            end do
            if (.not. changed) exit
        end do
        call find_orbit_delay(rows(:, :n), differences(:n, :3), rates(:n, :), kept, calibration)
        if (any(.not. kept)) then
            call note(calibration, 'magnetometer: '//integer_text(count(.not. kept))//' of '//integer_text(n)// &
                      ' fields are far off the others and left out')
            good_time(:count(kept)) = pack(good_time(:n), kept)
            good(:, :count(kept)) = good(:, pack([(k, k=1, n)], kept))
            rows(:, :count(kept)) = rows(:, pack([(k, k=1, n)], kept))
            n = count(kept)
        end if
        calibration%field_difference = sqrt(maxval(left))
        if (.not. replace) return
        do i = 1, n
            good(:, i) = good(:, i) - matmul(rows(:, i), fit)
        end do
        do span = 1, size(calibration%spans)
            associate (s => calibration%spans(span))
                do i = 1, size(s%attitude_time)
                    k = last_not_after(good_time(:n), s%attitude_time(i))
                    if (k < 1 .or. k >= n) cycle
                    if (good_time(k + 1) - good_time(k) > STUCK) then
                        if (s%attitude_time(i) > s%start .and. s%attitude_time(i) < s%stop .and. since < s%start) then
                            call note(calibration, 'the magnetometer sticks in '//trim(name_of_span(calibration, span))// &
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

    !> Looks whether the measured field has the size and the directions of the model's: nanotesla for microtesla, a satellite that
    !> is turned round. Fails where a field of another unit is to be used.
    subroutine compare_fields(measured, modelled, used, calibration, error)
        real(dp), intent(in) :: measured(:, :), modelled(:, :)      !! (3, n), SRF, T
        logical, intent(in) :: used                 !! The measured field stands in for the model's
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: MOST = 2             ! Times the model's, either way, chosen: biases and rods make some of 30 uT
        real(dp), parameter :: CLEARLY = 4          ! Times the squares of what is left as it is
        real(dp), parameter :: FAR = 10000*NANOTESLA
        real(dp) :: factor, left(0:3), signs(3)
        character(:), allocatable :: text
        integer :: k

        factor = norm2(measured)/norm2(modelled)
        if (factor > MOST .or. factor < 1/MOST) then
            text = 'magnetometer: its field is '//trim(rounded_text(factor, 3))//' times that of the model: its columns are '// &
                   'in uT (in nT they would be 1000 times as much), in SRF'
            if (used) then
                call fail(error, text)
            else
                call note(calibration, text//'; the model''s is used')
            end if
            return
        end if
        left(0) = sum((measured - modelled)**2)
        do k = 1, 3
            signs = -1
            signs(k) = 1
            left(k) = sum((measured - spread(signs, 2, size(modelled, 2))*modelled)**2)
        end do
        k = minloc(left(1:), 1)
        if (CLEARLY*left(k) < left(0) .and. left(0) > size(modelled, 2)*FAR**2) calibration%field_turned = 'the magnetometer '// &
            'shows the field of a satellite that is turned by 180 deg about '//AXES(k)//': the attitude'// &
            pick_text(k == 3, ' is of the other satellite, which flies the other way round, or its quaternions have another '// &
                      'order, or the magnetometer''s file is of the other', &
                      ' is turned, or two columns of the magnetometer have the wrong sign')
    end subroutine compare_fields

    !> How late the tags of the orbit are: what the change of the field along it explains of what currents and biases leave.
    !> It counts where it explains most, and is more than the error of a model can look like.
    subroutine find_orbit_delay(rows, differences, rates, kept, calibration)
        real(dp), intent(in) :: rows(:, :)          !! Bias and currents, (column, field)
        real(dp), intent(in) :: differences(:, :), rates(:, :)      !! (field, axis), T, T/s
        logical, intent(in) :: kept(:)              !! Which fields count
        type(level1_calibration_t), intent(inout) :: calibration

        real(dp), parameter :: LEAST = 5            ! s: 200 nT
        real(dp), parameter :: SHARE = 0.75_dp      ! Of the squares
        type(error_t), allocatable :: singular
        real(dp) :: product, square, total, series(count(kept), 2)
        integer, allocatable :: which(:)
        integer :: axis, i

        which = pack([(i, i=1, size(kept))], kept)
        product = 0
        square = tiny(square)
        total = 0
        do axis = 1, 3
            series(:, 1) = differences(which, axis)
            series(:, 2) = rates(which, axis)
            do i = 1, 2
                call take_away(rows(:, which), series(:, i), singular)
                if (allocated(singular)) return
            end do
            product = product + sum(series(:, 1)*series(:, 2))
            square = square + sum(series(:, 2)**2)
            total = total + sum(series(:, 1)**2)
        end do
        if (abs(product/square) > LEAST .and. product**2/square > SHARE*total) calibration%orbit_delay = -product/square
    end subroutine find_orbit_delay

    !> Leaves out samples at firings and at gaps of the currents, and spans with too little.
    subroutine edit_spans(calibration)
        type(level1_calibration_t), intent(inout) :: calibration

        real(dp), parameter :: LONGEST_STEP = 1.5_dp    ! Intervals of the currents
        integer, parameter :: MOST_STEPS = 2000         ! That give the usual interval
        real(dp), parameter :: LINEAR_NOISE = 1e-8_dp, ANGULAR_NOISE = 1e-6_dp      ! m/s^2, rad/s^2
        logical, allocatable :: stays(:), stray(:)
        real(dp) :: interval, gap
        integer :: i, k, n, before

        n = size(calibration%current_time)
        associate (t => calibration%current_time(:min(n, MOST_STEPS)))
            interval = median_of(t(2:) - t(:size(t) - 1))
        end associate
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                stays = spread(.true., 1, size(span%time))
                do k = 1, size(span%firings)
                    stays = stays .and. .not. (span%time > span%firings(k) - calibration%setup%veto_before .and. &
                                               span%time < span%firings(k) + calibration%setup%veto_after)
                end do
                span%vetoed = count(.not. stays)
                do k = 1, size(span%time)
                    before = last_not_after(calibration%current_time, span%time(k))
                    if (before < 1 .or. before >= n) then
                        stays(k) = .false.
                    else if (calibration%current_time(before + 1) - calibration%current_time(before) > LONGEST_STEP*interval) then
                        stays(k) = .false.
                    end if
                end do
                call keep_samples(span, stays)
                stray = find_strays(span%time, span%linear, LINEAR_NOISE)
                if (calibration%has_angular) stray = stray .or. find_strays(span%time, span%angular, ANGULAR_NOISE)
                span%outliers = count(stray)
                call keep_samples(span, .not. stray)
                span%samples = size(span%time)
                if (.not. span%used) cycle
                if (calibration%all_day) cycle      ! arcs without them are none
                if (span%samples < calibration%setup%least_share*span%expected) then
                    call leave_out(span, 'only '//integer_text(span%samples)//' of '//integer_text(span%expected)// &
                                   ' samples')
                    cycle
                end if
                gap = maxval(span%attitude_time(2:) - span%attitude_time(:size(span%attitude_time) - 1), &
                             mask=span%attitude_time(2:) > span%start .and. &
                             span%attitude_time(:size(span%attitude_time) - 1) < span%stop)
                if (gap > calibration%setup%longest_attitude_gap .or. span%attitude_time(1) > span%start .or. &
                    span%attitude_time(size(span%attitude_time)) < span%stop) &
                    call leave_out(span, 'a gap in the attitude')
            end associate
        end do
    end subroutine edit_spans

    !> Where the satellite passes through the edge of the Earth's shadow, by times of the attitude: the Sun's light, some
    !> 3e-8 m/s^2, goes within some 10 s, which neither polynomials nor the noise of other samples describe.
    subroutine find_shadow_edges(calibration)
        type(level1_calibration_t), intent(inout) :: calibration

        real(dp) :: sun(3), light, before
        logical, allocatable :: edge(:)
        integer :: i, k

        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                allocate (span%shadow_edges(0))
                if (.not. span%used) cycle
                edge = spread(.false., 1, size(span%attitude_time))
                before = -1
                do k = 1, size(edge)
                    sun = sun_position(julian_centuries_tt(utc_at(calibration, span%attitude_time(k))))
                    light = conical_shadow(span%position(:, k), sun)
                    if (k > 1 .and. abs(light - before) > 0) edge(k - 1:k) = .true.
                    before = light
                end do
                edge = edge .and. span%attitude_time > span%start .and. span%attitude_time < span%stop
                span%shadow_edges = pack(span%attitude_time, edge)
                if (any(edge)) call note(calibration, trim(name_of_span(calibration, i))//': the satellite passes the edge of '// &
                                         'the Earth''s shadow; samples there are left out, and what lies before and behind '// &
                                         'it has forces of its own')
            end associate
        end do
    end subroutine find_shadow_edges

    !> The masses of MAS1B or MAS1A: gas, and that of the satellite. Fails where neither they nor the setup say the latter.
    subroutine read_masses(calibration, error)
        type(level1_calibration_t), intent(inout) :: calibration
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: APART = 0.01_dp      ! relative: more is told
        real(dp), parameter :: MOST_GAS = 100       ! kg, of a tank, chosen: those of GRACE and GRACE-FO hold less than 20
        type(level1_records_t) :: records
        type(string_t), allocatable :: found(:)
        integer :: i

        call find_files(calibration, ['MAS1B', 'MAS1A'], found)
        if (size(found) > 0) then
            call read_level1(found, records, error)
            if (.not. allocated(error)) call check_satellite(records, calibration%satellite, error)
            if (allocated(error)) return
            call note_product(calibration, records%layout%product, found)
            do i = 1, 2
                call take_mass('gas_mass_tnk'//integer_text(i), calibration%gas(i))
            end do
            call take_mass('mass_tnk', calibration%mass)
            call take_mass('mass_thr', calibration%mass)
            if (maxval(calibration%gas) > MOST_GAS) call note(calibration, records%layout%product//': '// &
                trim(rounded_text(maxval(calibration%gas), 5))//' kg of gas in a tank, which holds some 20 kg: another unit?')
        end if
        associate (said => calibration%setup%mass)
            if (calibration%mass < 0 .and. .not. said > 0) then
                call fail(error, 'the mass is not known: MAS1B does not have it (that of GRACE-FO has the gas alone); say mass '// &
                          'in &mass_properties of the setup, in kg')
            else if (calibration%mass > 0 .and. abs(said - calibration%mass) > APART*calibration%mass .and. said > 0) then
                call note(calibration, 'the setup says a mass of '//trim(rounded_text(said, 5))//' kg, MAS1B '// &
                          trim(rounded_text(calibration%mass, 5))//' kg, which is taken')
            end if
            if (calibration%mass > 0) said = calibration%mass
        end associate

    contains

        !> A mass in the middle of the manoeuvre; where no record has it, it stays what it is.
        subroutine take_mass(field, mass)
            character(*), intent(in) :: field           !! Of MAS1A, MAS1B
            real(dp), intent(inout) :: mass             !! kg

            real(dp) :: nearest, distance
            integer :: i, column

            column = records%field_of(field)
            nearest = huge(nearest)
            do i = 1, records%count
                distance = abs(real(records%seconds(i), dp) - middle_of(calibration))
                if (.not. records%values(i, column) > 0 .or. distance >= nearest) cycle
                nearest = distance
                mass = records%values(i, column)
            end do
        end subroutine take_mass
    end subroutine read_masses
end module gracecg_level1_gathering
