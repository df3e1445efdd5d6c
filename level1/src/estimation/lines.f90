!> The lines in the rods' currents of a span.
module gracecg_level1_lines
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t
    use gracecg_level1_spans, only: strongest_line
    implicit none
    private
    public :: rod_lines_t, find_rod_lines

    type :: rod_lines_t
        !! The strongest line of each rod: amplitude sin(2 pi frequency (t - start) + phase)
        real(dp) :: frequency(3) = 0        !! Hz
        real(dp) :: amplitude(3) = 0        !! mA
        real(dp) :: phase(3) = 0            !! deg
    end type rod_lines_t

contains

    !> Finds them. Zeros: the span has too few currents.
    subroutine find_rod_lines(calibration, span, lines)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_span_t), intent(in) :: span
        type(rod_lines_t), intent(out) :: lines

        integer, parameter :: FEWEST = 12
        real(dp), parameter :: LONGEST = 900        ! s: of a longer span that much
        real(dp), allocatable :: times(:), left(:)
        logical :: inside(size(calibration%current_time))
        integer :: rod

        inside = calibration%current_time >= span%start .and. calibration%current_time <= min(span%stop, span%start + LONGEST)
        if (count(inside) < FEWEST) return
        times = pack(calibration%current_time, inside)
        do rod = 1, 3
            left = pack(calibration%current(rod, :), inside)
            call strongest_line(times, left, lines%frequency(rod), lines%amplitude(rod), lines%phase(rod))
            lines%phase(rod) = lines%phase(rod)/DEGREE - 360*lines%frequency(rod)*(times(1) - span%start)
            lines%phase(rod) = modulo(lines%phase(rod) + 180, 360.0_dp) - 180
        end do
    end subroutine find_rod_lines
end module gracecg_level1_lines
