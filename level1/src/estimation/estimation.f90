!> The estimate of the offset from Level-1 data, and a judgement that names what is wrong. All spans are arcs of one fit
!> (gracecg_estimation_arcs), with gains and delay of the rods, delay and angular channels of the accelerometer, leakage and all of
!> an arc's own.
module gracecg_level1_estimation
    use gracecg_level1_basics
    use gracecg_observations_observation_set, only: LARGEST_ACCELERATION
    use gracecg_level1_calibration, only: level1_calibration_t, name_of_span, NO_CURRENTS
    use gracecg_level1_gyros, only: gyro_axes_t, fit_gyro_axes
    use gracecg_level1_judgement, only: name_faults, look_over_spans, judge, take_action
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_span_fit, only: span_fit_t, fit_spans, take_fit
    use gracecg_level1_spans, only: find_spans
    use gracecg_level1_time, only: gps_date_text
    implicit none
    private
    public :: estimate_level1, fit_calibration, conclude

contains

    !> Estimates the offset. Fails when the data do not allow any estimate.
    subroutine estimate_level1(calibration, said, leakage, estimate, error)
        type(level1_calibration_t), intent(inout) :: calibration    !! Outliers are counted
        type(level1_setup_t), intent(in) :: said            !! What products say, too, is taken from them
        character(*), intent(in) :: leakage                 !! Of LEAKAGE_CHOICES
        type(level1_estimate_t), intent(out) :: estimate
        type(error_t), allocatable, intent(out) :: error

        type(span_fit_t) :: fit

        call fit_calibration(calibration, said, leakage, fit, estimate, error)
        if (.not. allocated(error)) call conclude(calibration, leakage, fit, estimate)
    end subroutine estimate_level1

    !> Fits the spans and names what their samples show to be wrong. Fails when the data do not allow any estimate.
    subroutine fit_calibration(calibration, said, leakage, fit, estimate, error)
        type(level1_calibration_t), intent(inout) :: calibration    !! Outliers are counted
        type(level1_setup_t), intent(in) :: said            !! What products say, too, is taken from them
        character(*), intent(in) :: leakage                 !! Of LEAKAGE_CHOICES
        type(span_fit_t), intent(out) :: fit
        type(level1_estimate_t), intent(out) :: estimate    !! Not judged
        type(error_t), allocatable, intent(out) :: error

        type(gyro_axes_t) :: axes
        type(error_t), allocatable :: failure
        real(dp), allocatable :: shown(:, :)        ! spans, by the currents
        integer :: i

        allocate (estimate%findings(0), estimate%remarks(0), estimate%solutions(0))
        if (.not. any(calibration%spans%used)) then
            call fail(error, 'no span is usable: the first, because of '//trim(calibration%spans(1)%reason))
            return
        end if
        calibration%setup = said
        if (calibration%mass > 0) calibration%setup%mass = calibration%mass
        call refuse_samples(calibration, error)
        if (allocated(error)) return
        call find_driven(calibration, estimate%rods%driven)
        if (.not. any(estimate%rods%driven)) then
            call fail(error, 'no manoeuvre found: '//pick_text(calibration%largest_current > 0, 'in no usable span the current '// &
                      'of a rod ranges over more than excitation_ma', NO_CURRENTS))
            call find_spans(calibration%current_time, calibration%current, calibration%setup, shown)
            if (size(shown) > 0) error%message = error%message//'; the currents show one, of '//integer_text(size(shown, 2))// &
                ' spans, from '//gps_date_text(calibration%epoch, shown(1, 1))//' GPS on: correct the times of '// &
                trim(calibration%spans_from)//', or leave it out'
            return
        end if
        if (calibration%all_day) call refuse_short_manoeuvre(calibration, error)
        if (allocated(error)) return
        call fit_gyro_axes(calibration, axes, failure)
        if (calibration%has_gyros .and. .not. axes%known) &
            call append(estimate%remarks, 'the gyros are not used: the star cameras do not tell their axes well enough')
        call fit_spans(calibration, axes, estimate, fit, error)
        if (.not. allocated(error)) call take_fit(calibration, fit, leakage, estimate, error)
        if (allocated(error)) return
        do i = 1, size(estimate%arcs)
            associate (span => calibration%spans(estimate%span_of(i)))
                span%outliers = span%outliers + size(estimate%arcs(i)%accelerometer_time) - count(estimate%residuals(i)%kept)
            end associate
        end do
        call name_faults(calibration, estimate)
    end subroutine fit_calibration

    !> Judges an estimate.
    subroutine conclude(calibration, leakage, fit, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        character(*), intent(in) :: leakage         !! Of LEAKAGE_CHOICES
        type(span_fit_t), intent(in) :: fit         !! That it is of
        type(level1_estimate_t), intent(inout) :: estimate      !! Its findings are those of the samples

        call look_over_spans(calibration, estimate)
        if (.not. calibration%all_day) call try_exchanged_moments(calibration, fit%axes, leakage, estimate)
        call judge(calibration, estimate)
        estimate%flag = estimate%solutions(1)%flag
        call take_action(calibration, estimate)
    end subroutine conclude

    !> Fails where samples of the accelerometer that are left are none: one is more than any satellite shows, or most of a span are
    !> one value.
    subroutine refuse_samples(calibration, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(error_t), allocatable, intent(out) :: error

        character(60) :: name       ! of the axis
        real(dp) :: usual
        integer :: i, k, n

        do i = 1, size(calibration%spans)
            if (.not. calibration%spans(i)%used) cycle
            do k = 1, 3
                associate (samples => calibration%spans(i)%linear(k, :), times => calibration%spans(i)%time, &
                           column => calibration%setup%accelerometer_axes(k))
                    if (size(samples) == 0) cycle
                    name = 'accelerometer '//AXES(k)//' of the SRF (lin_accl_'//AXES(abs(column))//' of ACC1A)'
                    n = maxloc(abs(samples), 1)
                    usual = median_of(samples)
                    if (abs(samples(n)) > LARGEST_ACCELERATION) then
                        call fail(error, trim(name)//': '//integer_text(count(abs(samples) > LARGEST_ACCELERATION))// &
                                  ' samples of '//trim(name_of_span(calibration, i))//' are larger than any satellite '// &
                                  'shows, as '//trim(rounded_text(sign(1, column)*samples(n), 4))//' m/s^2 at '//gps_date_text( &
                                  calibration%epoch + floor(times(n), i8), times(n) - floor(times(n)))//' GPS: fill values, '// &
                                  'or another unit; leave such records out, or set bits of their qualflg')
                    else if (2*count(.not. abs(samples - usual) > 0) > size(samples)) then
                        call fail(error, trim(name)//': most samples of '//trim(name_of_span(calibration, i))//' are '// &
                                  trim(rounded_text(sign(1, column)*usual, 4))//' m/s^2: the axis does not measure')
                    end if
                end associate
                if (allocated(error)) return
            end do
        end do
    end subroutine refuse_samples

    !> Where something is wrong, the same with two moments of inertia of the setup exchanged: if nothing is then, that is why.
    subroutine try_exchanged_moments(calibration, gyros, leakage, estimate)
        type(level1_calibration_t), intent(in) :: calibration
        type(gyro_axes_t), intent(in) :: gyros      !! Their axes
        character(*), intent(in) :: leakage         !! Of LEAKAGE_CHOICES
        type(level1_estimate_t), intent(inout) :: estimate      !! Its findings

        real(dp), parameter :: ALIKE = 0.03_dp      ! Relative: such moments are not told apart
        real(dp), parameter :: FACTOR = 1.5_dp      ! Of the gains of all rods, chosen: the exchanged moments have the same sum
        type(level1_calibration_t) :: other
        type(level1_estimate_t) :: tried
        type(span_fit_t) :: fit
        type(error_t), allocatable :: failure
        integer :: i, k

        if (size(estimate%findings) == 0 .or. .not. all(estimate%rods%driven)) return
        if (minval(estimate%rods%gain) > FACTOR .or. maxval(estimate%rods%gain) < 1/FACTOR) return     ! all moments are off
        if (.not. estimate%solutions(1)%beliefs%has_contradiction()) return
        do i = 1, 3
            k = mod(i, 3) + 1
            other = calibration
            associate (here => other%setup%inertia, said => calibration%setup%inertia)
                if (abs(said(i, i) - said(k, k)) < ALIKE*said(i, i)) cycle
                here(i, i) = said(k, k)
                here(k, k) = said(i, i)
            end associate
            tried = level1_estimate_t(rods=estimate%rods)
            allocate (tried%findings(0), tried%remarks(0), tried%solutions(0))
            call fit_spans(other, gyros, tried, fit, failure)
            if (.not. allocated(failure)) call take_fit(other, fit, leakage, tried, failure)
            if (allocated(failure)) cycle
            call name_faults(other, tried)
            call look_over_spans(other, tried)
            if (size(tried%findings) > 0 .or. tried%solutions(1)%beliefs%has_contradiction()) cycle
            estimate%findings = estimate%findings(:0)
            call append(estimate%findings, 'moments of inertia about '//AXES(i)//' and '//AXES(k)//' are exchanged in the '// &
                        'setup: the other way round nothing is contradicted')
            return
        end do
    end subroutine try_exchanged_moments

    !> Which rods some span drives.
    pure subroutine find_driven(calibration, driven)
        type(level1_calibration_t), intent(in) :: calibration
        logical, intent(out) :: driven(3)

        real(dp), parameter :: LEAST = 0.5_dp       ! mA, of rods that are driven all day: some steps of the telemetry's 0.05 mA
        logical :: inside(3, size(calibration%current_time))
        integer :: i

        driven = .false.
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (.not. span%used) cycle
                inside = spread(calibration%current_time >= span%start .and. calibration%current_time <= span%stop, 1, 3)
            end associate
            driven = driven .or. maxval(calibration%current, 2, inside) - minval(calibration%current, 2, inside) > &
                     merge(LEAST, calibration%setup%excitation_current, calibration%all_day)
        end do
    end subroutine find_driven

    !> Refuses currents of which some minutes are a manoeuvre and most are not, as driven all the time.
    subroutine refuse_short_manoeuvre(calibration, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: WINDOW = 60      ! s
        integer :: windows, driven, first, last

        windows = 0
        driven = 0
        first = 1
        associate (time => calibration%current_time, current => calibration%current, &
                   least => calibration%setup%excitation_current)
            do while (first <= size(time))
                last = last_not_after(time, time(first) + WINDOW)
                windows = windows + 1
                if (any(maxval(current(:, first:last), 2) - minval(current(:, first:last), 2) > least)) driven = driven + 1
                first = last + 1
            end do
        end associate
        if (driven > 0 .and. 2*driven < windows) call fail(error, 'option --every: rods are driven all the time, but their '// &
            'currents range over more than excitation_ma in '//integer_text(driven)//' of '//integer_text(windows)// &
            ' minutes only: these are spans of a manoeuvre; leave --every out')
    end subroutine refuse_short_manoeuvre

end module gracecg_level1_estimation
