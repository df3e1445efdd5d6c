!> Samples far off their neighbours: what one of them would do to everything that is found from all.
module gracecg_level1_strays
    use gracecg_base_kinds, only: dp
    use gracecg_base_statistics, only: median_of
    use gracecg_estimation_spike_screen, only: is_spike
    use gracecg_level1_series, only: interpolate
    implicit none
    private
    public :: find_strays

contains

    !> Which samples are spikes: each is compared with the cubic through its four nearest neighbours. Where one is off by more
    !> than 20 times the noise, or what is usual there, one sample is looked for, or two side by side, without which all others
    !> there follow their neighbours. At a step there is none; the fit itself edits what is less far off.
    pure subroutine find_strays(times, values, noise, stray)
        real(dp), intent(in) :: times(:)            !! Rising, s
        real(dp), intent(in) :: values(:, :)        !! Component, sample
        real(dp), intent(in) :: noise               !! At least, of a sample
        logical, intent(out) :: stray(:)            !! (samples)

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
    end subroutine find_strays

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
end module gracecg_level1_strays
