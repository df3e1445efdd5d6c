!> The estimate from data in which rods are driven all the time. They are gathered and fitted in parts, of which what they say of
!> the offset and all that arcs share is kept, not the samples; what all parts say together is the estimate.
module gracecg_level1_driven_day
    use gracecg_level1_basics
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t, leave_out, signs_are_known
    use gracecg_level1_estimation, only: estimate_level1, fit_calibration, conclude
    use gracecg_level1_gathering, only: gather_calibration
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_span_fit, only: span_fit_t, take_fit, join_parts
    implicit none
    private
    public :: estimate_driven_day

    real(dp), parameter :: LONGEST_PART = 21600     !! s, chosen: four revolutions
    integer, parameter :: EVERY_FIELD = 60          !! Of the field of a span, that is shown, one sample of so many is kept

contains

    !> Gathers the data and estimates the offset. A part that cannot be fitted is left out with a note; fails when none can.
    subroutine estimate_driven_day(places, setup, satellite, given_span, field_choice, day, every, leakage, calibration, &
                                   estimate, error, longest)
        character(*), intent(in) :: places(:)       !! Of the Level-1 files: folders, bundles, files
        type(level1_setup_t), intent(in) :: setup
        character(*), intent(in) :: satellite       !! A to D; blank: the only one there is
        real(dp), intent(in) :: given_span(:, :)    !! Part of the files, (2, 1): start, GPS s past 2000-01-01 12:00, duration, s;
                                                    !! (2, 0): all
        character(*), intent(in) :: field_choice    !! model or magnetometer
        character(*), intent(in) :: day             !! That has part of the data, YYYY-MM-DD; empty: all files
        real(dp), intent(in) :: every               !! Length of the spans, s
        character(*), intent(in) :: leakage         !! Of LEAKAGE_CHOICES
        type(level1_calibration_t), intent(out) :: calibration      !! Of the first part, with the spans of all
        type(level1_estimate_t), intent(out) :: estimate
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: longest   !! Part, s; absent: six hours

        type(level1_calibration_t) :: gathered
        type(level1_estimate_t) :: of_part
        type(span_fit_t), allocatable :: fits(:)
        type(span_fit_t) :: whole
        type(level1_span_t), allocatable :: spans(:)
        type(error_t), allocatable :: failure
        real(dp) :: length
        integer :: part, parts, fitted

        length = LONGEST_PART
        if (present(longest)) length = longest
        allocate (spans(0), estimate%findings(0), estimate%remarks(0), estimate%solutions(0))
        parts = 1
        part = 0
        fitted = 0
        do while (part < parts)
            part = part + 1
            call gather_calibration(places, setup, satellite, '', given_span, field_choice, gathered, failure, day, every, part, &
                                    length)
            parts = max(parts, gathered%parts)
            if (parts == 1) then
                if (.not. allocated(failure)) call estimate_level1(gathered, setup, leakage, estimate, failure)
                calibration = gathered
                call move_alloc(failure, error)
                return
            end if
            if (.not. allocated(fits)) allocate (fits(parts))
            if (.not. allocated(failure)) &
                call fit_calibration(gathered, setup, leakage, fits(fitted + 1), of_part, failure)
            call lighten(gathered%spans)
            if (allocated(failure)) then
                if (.not. allocated(error)) error = failure
                call lose_part()
            else
                fitted = fitted + 1
                call keep_part(fits(fitted))
            end if
            of_part = level1_estimate_t()
            spans = [spans, gathered%spans]
        end do
        if (fitted == 0) return
        if (allocated(error)) deallocate (error)
        call move_alloc(spans, calibration%spans)
        call join_parts(fits(:fitted), signs_are_known(calibration), whole, error)
        if (.not. allocated(error)) call take_fit(calibration, whole, leakage, estimate, error)
        if (.not. allocated(error)) call conclude(calibration, leakage, whole, estimate)

    contains

        !> The part says nothing.
        subroutine lose_part()
            integer :: i

            do i = 1, size(gathered%spans)
                call leave_out(gathered%spans(i), failure%message)
            end do
            call append(estimate%remarks, 'part '//integer_text(part)//' of '//integer_text(parts)//' of the data is left out: '// &
                        failure%message)
        end subroutine lose_part

        !> Keeps what a part says; of the first one its samples, too, which stand for all in figures.
        subroutine keep_part(fit)
            type(span_fit_t), intent(inout) :: fit

            integer :: k

            fit%span_of = fit%span_of + gathered%before
            if (fitted == 1) then
                calibration = gathered
                calibration%before = 0
                estimate%rods%driven = of_part%rods%driven
            else
                deallocate (fit%arcs)
                deallocate (fit%fits(1)%residuals)
                call add_new(calibration%notes, gathered%notes)
                do k = 1, 3     ! signs that parts do not agree on are not known
                    if (calibration%follows(k) == 0) then
                        calibration%follows(k) = gathered%follows(k)
                    else if (calibration%follows(k)*gathered%follows(k) < 0) then
                        calibration%follows(k) = 0
                    end if
                end do
                estimate%rods%driven = estimate%rods%driven .or. of_part%rods%driven
            end if
            estimate%steps = estimate%steps .or. of_part%steps
            call add_new(estimate%findings, of_part%findings)
            call add_new(estimate%remarks, of_part%remarks)
        end subroutine keep_part
    end subroutine estimate_driven_day

    !> Adds texts that are not yet there.
    subroutine add_new(texts, more)
        type(string_t), allocatable, intent(inout) :: texts(:)
        type(string_t), intent(in) :: more(:)

        integer :: i, k

        do i = 1, size(more)
            if (.not. any([(texts(k)%text == more(i)%text, k=1, size(texts))])) call append(texts, more(i)%text)
        end do
    end subroutine add_new

    !> Leaves of spans what is shown of them.
    pure subroutine lighten(spans)
        type(level1_span_t), allocatable, intent(inout) :: spans(:)     !! None, where there are none

        type(level1_span_t) :: light
        integer :: i

        if (.not. allocated(spans)) allocate (spans(0))
        do i = 1, size(spans)
            associate (span => spans(i))
                light = level1_span_t(span%start, span%stop, span%used, span%reason, expected=span%expected, &
                                      samples=span%samples, flagged=span%flagged, vetoed=span%vetoed, outliers=span%outliers, &
                                      firings_inside=span%firings_inside, mean_field=span%mean_field)
                light%attitude_time = [real(dp) ::]
                light%field = reshape([real(dp) ::], [3, 0])
                if (allocated(span%field)) then
                    light%attitude_time = span%attitude_time(::EVERY_FIELD)
                    light%field = span%field(:, ::EVERY_FIELD)
                end if
                span = light
            end associate
        end do
    end subroutine lighten
end module gracecg_level1_driven_day
