!> The estimate of the offset from Level-1 data, and a judgement that names what is wrong.
module gracecg_level1_estimation
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_increasing_numbers, only: last_not_after
    use gracecg_base_text, only: append, integer_text
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_fit, only: fit_spans
    use gracecg_level1_gyros, only: gyro_axes_t, fit_gyro_axes
    use gracecg_level1_judgement, only: name_faults, judge, take_action
    use gracecg_level1_origins, only: take_from_products
    use gracecg_level1_outcome, only: level1_estimate_t
    implicit none
    private
    public :: estimate_level1

contains

    !> Estimates the offset. Fails when the data do not allow any estimate.
    subroutine estimate_level1(calibration, said, leakage, estimate, error)
        type(level1_calibration_t), intent(inout) :: calibration    !! Outliers are counted
        type(level1_setup_t), intent(in) :: said            !! What products say, too, is taken from them
        character(*), intent(in) :: leakage                 !! Of LEAKAGE_CHOICES
        type(level1_estimate_t), intent(out) :: estimate
        type(error_t), allocatable, intent(out) :: error

        type(level1_setup_t) :: setup
        type(gyro_axes_t) :: axes
        type(error_t), allocatable :: failure
        integer :: i

        allocate (estimate%findings(0), estimate%remarks(0), estimate%solutions(0))
        if (.not. any(calibration%spans%used)) then
            call fail(error, 'no span is usable: the first, because of '//trim(calibration%spans(1)%reason))
            return
        end if
        setup = said
        call take_from_products(calibration, setup)
        call find_driven(calibration, setup, estimate%rods%driven)
        if (.not. any(estimate%rods%driven)) then
            call fail(error, 'no manoeuvre found: in no usable span the current of a rod ranges over more than excitation_ma')
            return
        end if
        if (calibration%all_day) call refuse_short_manoeuvre(calibration, setup, error)
        if (allocated(error)) return
        call fit_gyro_axes(calibration, axes, failure)
        if (calibration%has_gyros .and. .not. axes%known) &
            call append(estimate%remarks, 'the gyros are not used: the star cameras do not tell their axes well enough')
        call fit_spans(calibration, setup, axes, leakage, estimate, error)
        if (allocated(error)) return
        do i = 1, size(estimate%arcs)
            associate (span => calibration%spans(estimate%span_of(i)))
                span%outliers = span%outliers + size(estimate%arcs(i)%accelerometer_time) - count(estimate%residuals(i)%kept)
            end associate
        end do
        call name_faults(calibration, setup, estimate)
        call judge(calibration, setup, estimate)
        estimate%flag = estimate%solutions(1)%flag
        call take_action(calibration, setup%mass, estimate)
    end subroutine estimate_level1

    !> Which rods some span drives.
    pure subroutine find_driven(calibration, setup, driven)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        logical, intent(out) :: driven(3)

        real(dp), parameter :: LEAST = 0.5_dp       ! mA, of rods that are driven all day: some steps of the telemetry's 0.05 mA
        logical :: inside(size(calibration%current_time))
        integer :: i, k

        driven = .false.
        do i = 1, size(calibration%spans)
            associate (span => calibration%spans(i))
                if (.not. span%used) cycle
                inside = calibration%current_time >= span%start .and. calibration%current_time <= span%stop
                do k = 1, 3
                    driven(k) = driven(k) .or. maxval(calibration%current(k, :), mask=inside) - &
                        minval(calibration%current(k, :), mask=inside) > merge(LEAST, setup%excitation_current, calibration%all_day)
                end do
            end associate
        end do
    end subroutine find_driven

    !> Refuses currents of which some minutes are a manoeuvre and most are not, as driven all the time.
    subroutine refuse_short_manoeuvre(calibration, setup, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: WINDOW = 60      ! s
        integer :: windows, driven, first, last

        windows = 0
        driven = 0
        first = 1
        associate (time => calibration%current_time, current => calibration%current)
            do while (first <= size(time))
                last = last_not_after(time, time(first) + WINDOW)
                windows = windows + 1
                if (any(maxval(current(:, first:last), 2) - minval(current(:, first:last), 2) > setup%excitation_current)) &
                    driven = driven + 1
                first = last + 1
            end do
        end associate
        if (driven > 0 .and. 2*driven < windows) call fail(error, 'option --every: rods are driven all the time, but their '// &
            'currents range over more than excitation_ma in '//integer_text(driven)//' of '//integer_text(windows)// &
            ' minutes only: these are spans of a manoeuvre; leave --every out')
    end subroutine refuse_short_manoeuvre
end module gracecg_level1_estimation
