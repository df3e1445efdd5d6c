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

    !> Which samples are spikes: each is compared with the cubic through its four nearest neighbours, and what is off by more
    !> than 20 times the noise, or what is usual there, is one. A step, off alike on both sides, is none; the fit itself edits
    !> what is less far off.
    pure subroutine find_strays(times, values, noise, stray)
        real(dp), intent(in) :: times(:)            !! Rising, s
        real(dp), intent(in) :: values(:, :)        !! Component, sample
        real(dp), intent(in) :: noise               !! At least, of a sample
        logical, intent(out) :: stray(:)            !! (samples)

        real(dp), parameter :: LIMIT = 20
        real(dp), parameter :: MORE = 1.25_dp       ! Times both neighbours: a spike 3/2, a step 1
        real(dp), parameter :: LONGEST = 8          ! Intervals from the first to the last neighbour
        integer, parameter :: MOST_ROUNDS = 10
        real(dp) :: usual
        real(dp) :: off(size(times)), expected(1)
        integer, allocatable :: left(:)
        logical, allocatable :: here(:)
        integer :: component, i, n, round

        stray = .false.
        if (size(times) < 7) return
        usual = median_of(times(2:) - times(:size(times) - 1))
        do component = 1, size(values, 1)
            do round = 1, MOST_ROUNDS
                left = pack([(i, i=1, size(times))], .not. stray)
                n = size(left)
                if (n < 7) return
                off = 0
                do i = 3, n - 2
                    if (times(left(i + 2)) - times(left(i - 2)) > LONGEST*usual) cycle      ! a gap
                    associate (others => [left(i - 2:i - 1), left(i + 1:i + 2)])
                        call interpolate(times(others), values([component], others), times(left(i)), expected)
                    end associate
                    off(i) = abs(values(component, left(i)) - expected(1))
                end do
                here = is_spike(off(:n), noise, LIMIT)
                here(2:n - 1) = here(2:n - 1) .and. off(2:n - 1) > MORE*max(off(:n - 2), off(3:n))
                here([1, n]) = .false.
                if (.not. any(here)) exit
                stray(pack(left, here)) = .true.
            end do
        end do
    end subroutine find_strays
end module gracecg_level1_strays
