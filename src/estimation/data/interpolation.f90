!> Interpolation in a series of samples: linear, CSR-TM-00-01 section 4.5, and cubic for an orbit.
module gracecg_estimation_interpolation
    use gracecg_base_kinds, only: dp
    use gracecg_base_increasing_numbers, only: last_not_after
    implicit none
    private
    public :: interpolation_t, interpolation_at, interpolated, is_covered
    public :: cubic_interpolated, lagrange_weights, LONGEST_GAP, REACH, LONGEST_ORBIT_SPACING

    !> A value by linear interpolation: (1 - fraction) v(first) + fraction v(first + 1).
    type :: interpolation_t
        integer :: first = 1            !! Number of the sample before
        real(dp) :: fraction = 0        !! Part of the way to the next one
        logical :: supported = .true.   !! False in a gap or far outside of the samples
    end type interpolation_t

    ! In sampling intervals of an instrument
    real(dp), parameter :: LONGEST_GAP = 2.5_dp     !! Between samples, that is still bridged
    real(dp), parameter :: REACH = 1.01_dp          !! Before the first and after the last sample

    real(dp), parameter :: LONGEST_ORBIT_SPACING = 60.0_dp
    !! Between positions of the orbit that a cubic is laid through, s

contains

    !> Linear interpolation between the neighbours of t, (4-40), (4-41); before the first sample it
    !> extrapolates backwards (4-38), (4-39), after the last one it keeps the last value (4-42), (4-43).
    !> Fewer than two samples support nothing.
    pure function interpolation_at(times, t, interval, bridged) result(source)
        real(dp), intent(in) :: times(:)            !! Increasing, s
        real(dp), intent(in) :: t                   !! s
        real(dp), intent(in) :: interval            !! Nominal sampling interval, s
        real(dp), intent(in), optional :: bridged
        !! The longest time between samples that is bridged, s; LONGEST_GAP intervals when absent
        type(interpolation_t) :: source

        real(dp) :: longest
        integer :: n

        n = size(times)
        if (n < 2) then
            source%supported = .false.
            return
        end if
        longest = LONGEST_GAP*interval
        if (present(bridged)) longest = bridged
        source%first = max(1, min(n - 1, last_not_after(times, t)))
        associate (before => times(source%first), after => times(source%first + 1))
            source%fraction = min(1.0_dp, (t - before)/(after - before))
            source%supported = after - before <= longest .and. &
                               t >= times(1) - REACH*interval .and. t <= times(n) + REACH*interval
        end associate
    end function interpolation_at

    !> True when a series needs no sample of another source at t: there is one of its own within half
    !> an interval, or interpolation is supported.
    pure logical function is_covered(times, t, interval)
        real(dp), intent(in) :: times(:)    !! Increasing, s
        real(dp), intent(in) :: t           !! s
        real(dp), intent(in) :: interval    !! Nominal sampling interval, s

        type(interpolation_t) :: source
        integer :: before

        source = interpolation_at(times, t, interval)
        before = last_not_after(times, t)
        is_covered = source%supported .or. &
                     any(abs(times(max(1, before):min(size(times), before + 1)) - t) < interval/2)
    end function is_covered

    !> Lagrange's cubic through the two samples before and the two after t (the nearest four at an end).
    pure function cubic_interpolated(times, values, t) result(value)
        real(dp), intent(in) :: times(:)        !! Increasing, at least four
        real(dp), intent(in) :: values(:, :)    !! (3, samples)
        real(dp), intent(in) :: t    !! s
        real(dp) :: value(3)

        integer :: first

        first = max(1, min(size(times) - 3, last_not_after(times, t) - 1))
        value = matmul(values(:, first:first + 3), lagrange_weights(times(first:first + 3), t))
    end function cubic_interpolated

    !> Weights of the values at some times, for the value at t of the polynomial through them.
    pure function lagrange_weights(times, t) result(weights)
        real(dp), intent(in) :: times(:), t     !! All different, s
        real(dp) :: weights(size(times))

        integer :: i, j

        weights = 1
        do i = 1, size(times)
            do j = 1, size(times)
                if (j /= i) weights(i) = weights(i)*(t - times(j))/(times(i) - times(j))
            end do
        end do
    end function lagrange_weights

    !> Interpolates all components of a series.
    pure function interpolated(values, source) result(value)
        real(dp), intent(in) :: values(:, :)    !! (components, samples)
        type(interpolation_t), intent(in) :: source
        real(dp) :: value(size(values, 1))

        value = (1 - source%fraction)*values(:, source%first) + &
                source%fraction*values(:, source%first + 1)
    end function interpolated
end module gracecg_estimation_interpolation
