!> Series of samples in order of time: interpolation, weighted means about every tenth sample (docs/theory.md, 18.9),
!> samples far off their neighbours, and what a combination of others explains.
module gracecg_level1_series
    use gracecg_level1_basics
    use gracecg_estimation_spike_screen, only: is_spike
    implicit none
    private
    public :: take_away, without_line, slope_of, interpolate, mean_weights, find_means, APART, find_strays

    integer, parameter :: APART = 10    !! Samples from mean to mean

contains

    !> Vectors between their samples, by the cubic through the four nearest (fewer where there are not so many), and
    !> their rate. Beyond the ends the same polynomials go on.
    pure subroutine interpolate(times, values, time, value, rate)
        real(dp), intent(in) :: times(:)            !! Rising, s; at least one
        real(dp), intent(in) :: values(:, :)        !! Component, sample
        real(dp), intent(in) :: time                !! s
        real(dp), intent(out) :: value(:)           !! At that time
        real(dp), intent(out), optional :: rate(:)  !! Its derivative, 1/s

        real(dp) :: weight, slope, term
        integer :: first, last, i, j, k

        first = max(1, min(last_not_after(times, time) - 1, size(times) - 3))
        last = min(size(times), first + 3)
        value = 0
        if (present(rate)) rate = 0
        do i = first, last
            weight = 1
            do j = first, last
                if (j /= i) weight = weight*(time - times(j))/(times(i) - times(j))
            end do
            value = value + weight*values(:, i)
            if (.not. present(rate)) cycle
            slope = 0
            do k = first, last
                if (k == i) cycle
                term = 1/(times(i) - times(k))
                do j = first, last
                    if (j /= i .and. j /= k) term = term*(time - times(j))/(times(i) - times(j))
                end do
                slope = slope + term
            end do
            rate = rate + slope*values(:, i)
        end do
    end subroutine interpolate

    !> Weights (a + b k**2) (1 + cos(pi k/(half + 1))) of a mean that keeps polynomials of the third degree as they are.
    pure function mean_weights(half) result(weights)
        integer, intent(in) :: half     !! Samples on either side
        real(dp) :: weights(-half:half)

        real(dp) :: k(-half:half), a, b
        integer :: i

        k = [(real(i, dp), i=-half, half)]
        weights = 1 + cos(TWO_PI*k/(2*half + 2))
        associate (zero => sum(weights), second => sum(weights*k**2), fourth => sum(weights*k**4))
            a = fourth/(zero*fourth - second**2)
            b = -second/(zero*fourth - second**2)
        end associate
        weights = (a + b*k**2)*weights
    end function mean_weights

    !> Means of samples, every tenth that misses none.
    pure subroutine find_means(epochs, samples, weights, centres, means, on_grid)
        integer, intent(in) :: epochs(:)            !! Rising
        real(dp), intent(in) :: samples(:, :)       !! (n, epochs)
        real(dp), intent(in) :: weights(:)          !! Of `mean_weights`
        integer, allocatable, intent(out) :: centres(:)     !! Epochs of the means
        real(dp), allocatable, intent(out) :: means(:, :)   !! (n, centres)
        logical, intent(in), optional :: on_grid    !! Behind missing samples, too, whole tens from the first one; absent: the
                                                    !! next that misses none

        integer :: i, n, half
        logical :: counts

        half = size(weights)/2
        allocate (centres(size(epochs)), means(size(samples, 1), size(epochs)))
        n = 0
        i = 1 + half
        do while (i + half <= size(epochs))
            counts = epochs(i + half) - epochs(i - half) == 2*half
            if (present(on_grid) .and. counts .and. n > 0) counts = .not. on_grid .or. modulo(epochs(i) - centres(1), APART) == 0
            if (counts) then
                n = n + 1
                centres(n) = epochs(i)
                means(:, n) = matmul(samples(:, i - half:i + half), weights)
                i = i + APART
            else
                i = i + 1
            end if
        end do
        centres = centres(:n)
        means = means(:, :n)
    end subroutine find_means

    !> Which samples are spikes: each is compared with the cubic through its four nearest neighbours. Where one is off by more
    !> than 20 times the noise, or what is usual there, one sample is looked for, or two side by side, without which all others
    !> there follow their neighbours. At a step there is none; the fit itself edits what is less far off.
    pure function find_strays(times, values, noise) result(stray)
        real(dp), intent(in) :: times(:)            !! Rising, s
        real(dp), intent(in) :: values(:, :)        !! Component, sample
        real(dp), intent(in) :: noise               !! At least, of a sample
        logical :: stray(size(times))

        real(dp), parameter :: LIMIT = 20
        integer, parameter :: WIDEST = 2            ! Samples in a row: without three, a cubic goes smoothly over a step
        integer, parameter :: MOST_ROUNDS = 10
        integer, allocatable :: left(:)             ! Samples that are no strays
        real(dp), allocatable :: t(:), x(:)         ! Theirs
        logical, allocatable :: suspicious(:)
        real(dp) :: usual
        integer :: component, round, width, i, n

        stray = .false.
        if (size(times) < 7) return
        usual = median_of(times(2:) - times(:size(times) - 1))
        do component = 1, size(values, 1)
            width = 1
            do round = 1, MOST_ROUNDS*WIDEST
                left = pack([(i, i=1, size(times))], .not. stray)
                n = size(left)
                if (n < 7) return
                t = times(left)
                x = values(component, left)
                suspicious = is_spike([(misfit(t, x, usual, i, i, i), i=1, n)], noise, LIMIT)
                do i = 1, n - width + 1
                    if (.not. any(suspicious(i:i + width - 1))) cycle
                    if (explains(t, x, usual, i, i + width - 1)) stray(left(i:i + width - 1)) = .true.
                end do
                if (count(stray) == size(times) - n) width = width + 1
                if (width > WIDEST .or. .not. any(suspicious)) exit
            end do
        end do
    end function find_strays

    !> Whether samples in a row are off, and those about them, without them, are not.
    pure logical function explains(times, values, usual, first, last)
        real(dp), intent(in) :: times(:), values(:)
        real(dp), intent(in) :: usual               !! Interval, s
        integer, intent(in) :: first, last

        real(dp), parameter :: REST = 0.25_dp       ! Of what they are off themselves; at a step 0.4 and more
        real(dp) :: off(first - 2:last + 2)
        integer :: i

        off = 0
        do i = max(1, first - 2), min(size(times), last + 2)
            off(i) = misfit(times, values, usual, i, first, last)
        end do
        explains = maxval(off(first:last)) > 0 .and. &
                   max(maxval(off(:first - 1)), maxval(off(last + 1:))) <= REST*maxval(off(first:last))
    end function explains

    !> How far a sample is off the cubic through its four nearest neighbours, leaving some out; 0 at ends and gaps.
    pure real(dp) function misfit(times, values, usual, place, first, last)
        real(dp), intent(in) :: times(:), values(:)
        real(dp), intent(in) :: usual               !! Interval, s
        integer, intent(in) :: place                !! Of the sample
        integer, intent(in) :: first, last          !! Left out

        real(dp), parameter :: LONGEST = 8          ! Intervals from the first to the last neighbour
        real(dp) :: expected(1)
        integer, allocatable :: others(:)
        integer :: i, before

        misfit = 0
        others = pack([(i, i=place - 6, place + 6)], [(i /= place .and. (i < first .or. i > last), i=place - 6, place + 6)])
        before = count(others < place)
        others = others(before - 1:before + 2)
        if (others(1) < 1 .or. others(4) > size(times)) return
        if (times(others(4)) - times(others(1)) > LONGEST*usual) return     ! a gap
        call interpolate(times(others), reshape(values(others), [1, 4]), times(place), expected)
        misfit = abs(values(place) - expected(1))
    end function misfit

    !> Values less the straight line through them.
    pure function without_line(times, values) result(rest)
        real(dp), intent(in) :: times(:), values(:)     !! s, any unit
        real(dp) :: rest(size(values))

        rest = values - sum(values)/size(values) - slope_of(times, values)*(times - sum(times)/size(times))
    end function without_line

    !> The slope of the straight line through some values.
    pure real(dp) function slope_of(times, values) result(slope)
        real(dp), intent(in) :: times(:), values(:)     !! s, any unit

        real(dp) :: t(size(times))

        t = times - sum(times)/size(times)
        slope = dot_product(t, values - sum(values)/size(values))/max(dot_product(t, t), tiny(1.0_dp))
    end function slope_of

    !> What the best combination of a basis leaves of some values. Fails when the basis is not independent.
    subroutine take_away(basis, values, error)
        real(dp), intent(in) :: basis(:, :)             !! (function, value)
        real(dp), intent(inout) :: values(:)            !! Any unit
        type(error_t), allocatable, intent(out) :: error

        real(dp), dimension(size(basis, 1), size(basis, 1)) :: normal, covariance
        real(dp), dimension(size(basis, 1)) :: rhs, coefficients
        real(dp) :: condition

        call normal_equations(basis, values, normal, rhs)
        call solve_normal_equations(normal, rhs, coefficients, covariance, condition, error)
        if (.not. allocated(error)) values = values - matmul(coefficients, basis)
    end subroutine take_away
end module gracecg_level1_series
