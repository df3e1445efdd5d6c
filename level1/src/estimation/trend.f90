!> How the offset changes with time, by calibrations of several dates: for each axis a weighted straight line with a
!> step at every change of the trim, beside what the gas used lets expect.
module gracecg_level1_trend
    use gracecg_level1_basics
    use gracecg_base_constants, only: JULIAN_YEAR
    use gracecg_level1_setup, only: level1_setup_t
    implicit none
    private
    public :: trend_point_t, level1_trend_t, fit_trend, predicted_change

    type :: trend_point_t
        !! The result of one calibration
        real(dp) :: time = 0            !! GPS, s past 2000-01-01 12:00
        real(dp) :: offset(3) = 0       !! d, m
        real(dp) :: sigma(3) = 0        !! m
        real(dp) :: gas(2) = -1         !! In tanks 1 and 2, kg; negative: not known
        integer :: flag = 0    !! 0 good, 1 with care, 2 not to be used
    end type trend_point_t

    type :: level1_trend_t
        !! The lines
        real(dp) :: reference = 0                   !! Weighted mean time, GPS s
        real(dp) :: level(3) = 0                    !! d at that time, behind all steps before it, m
        real(dp) :: rate(3) = 0, rate_sigma(3) = 0  !! m/s
        real(dp), allocatable :: step_time(:)       !! Of the steps that the dates see, GPS s
        real(dp), allocatable :: step(:, :), step_sigma(:, :)   !! (3, steps), m
        real(dp) :: chi_square(3) = 0    !! Of the residuals, by axis
        integer :: degrees = 0                      !! Of freedom, of each axis
        real(dp) :: passes = -1                     !! When a component of d exceeds 100 um, GPS s; -1: never in 50 years
    contains
        procedure :: at => trend_at                 !! d at a time
    end type level1_trend_t

contains

    !> Fits the lines. Steps before the first or behind the last date, and all but one between two dates, are left out.
    !> Fails with too few dates.
    subroutine fit_trend(points, step_times, limit, trend, error)
        type(trend_point_t), intent(in) :: points(:)    !! In order of time
        real(dp), intent(in) :: step_times(:)           !! Of changes of the trim, GPS s, in order
        real(dp), intent(in) :: limit                   !! Of each component of d, m
        type(level1_trend_t), intent(out) :: trend
        type(error_t), allocatable, intent(out) :: error

        integer, parameter :: YEARS = 50            ! That are looked ahead for the limit, day by day
        real(dp), allocatable :: rows(:, :), normal(:, :), rhs(:), x(:), covariance(:, :), weighted(:)
        real(dp) :: condition
        integer :: i, k, n, parameters, axis

        n = size(points)
        if (n < 2) then
            call fail(error, 'a trend needs the results of at least 2 dates: give those of earlier calibrations, too')
            return
        end if
        allocate (trend%step_time(0))
        do i = 1, size(step_times)
            if (.not. any(points%time < step_times(i)) .or. .not. any(points%time >= step_times(i))) cycle
            if (size(trend%step_time) > 0) then
                if (.not. any(points%time >= trend%step_time(size(trend%step_time)) .and. points%time < step_times(i))) cycle
            end if
            trend%step_time = [trend%step_time, step_times(i)]
        end do
        parameters = 2 + size(trend%step_time)
        if (n < parameters) then
            call fail(error, 'a trend with '//integer_text(size(trend%step_time))//' steps needs at least '// &
                      integer_text(parameters)//' dates, but there are '//integer_text(n))
            return
        end if
        trend%degrees = n - parameters
        trend%reference = sum(points%time)/n
        allocate (rows(parameters, n), normal(parameters, parameters), rhs(parameters), x(parameters), &
                  covariance(parameters, parameters), weighted(n), trend%step(3, parameters - 2), &
                  trend%step_sigma(3, parameters - 2))
        do axis = 1, 3
            rows(1, :) = 1
            rows(2, :) = (points%time - trend%reference)/JULIAN_YEAR
            do k = 1, size(trend%step_time)
                rows(2 + k, :) = merge(1.0_dp, 0.0_dp, points%time >= trend%step_time(k))
            end do
            weighted = points%offset(axis)/points%sigma(axis)
            rows = rows/spread(points%sigma(axis), 1, parameters)
            call normal_equations(rows, weighted, normal, rhs)
            call solve_normal_equations(normal, rhs, x, covariance, condition, error)
            if (allocated(error)) return
            trend%level(axis) = x(1)
            trend%rate(axis) = x(2)/JULIAN_YEAR
            trend%rate_sigma(axis) = sqrt(covariance(2, 2))/JULIAN_YEAR
            trend%step(axis, :) = x(3:)
            trend%step_sigma(axis, :) = sqrt([(covariance(k, k), k=3, parameters)])
            trend%chi_square(axis) = sum((weighted - matmul(x, rows))**2)
        end do
        do i = 0, nint(YEARS*JULIAN_YEAR/SECONDS_PER_DAY)
            if (.not. any(abs(trend%at(points(n)%time + i*SECONDS_PER_DAY)) > limit)) cycle
            trend%passes = points(n)%time + i*SECONDS_PER_DAY
            exit
        end do
    end subroutine fit_trend

    !> d by the line, m.
    pure function trend_at(self, time) result(offset)
        class(level1_trend_t), intent(in) :: self
        real(dp), intent(in) :: time            !! GPS s
        real(dp) :: offset(3)

        integer :: k

        offset = self%level + self%rate*(time - self%reference)
        do k = 1, size(self%step_time)
            if (time >= self%step_time(k)) offset = offset + self%step(:, k)
        end do
    end function trend_at

    !> The change of d between two dates by the gas used: - sum of X_i dm_i/M over the tanks, X_i from the centre of
    !> mass.
    pure function predicted_change(setup, gas_before, gas_after) result(change)
        type(level1_setup_t), intent(in) :: setup
        real(dp), intent(in) :: gas_before(2), gas_after(2)     !! kg
        real(dp) :: change(3)                                   !! m

        change = -matmul(setup%tank, gas_after - gas_before)/setup%mass
    end function predicted_change
end module gracecg_level1_trend
