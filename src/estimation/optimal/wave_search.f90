!> Does the non-gravitational acceleration contain a wave, such as a short-period perturbation of the
!> air's density? A line in the spectrum of the whitened residuals that noise would hardly make says
!> so. Its frequency is then the one for which two more parameters, sine and cosine of an acceleration
!> along the airflow, lower the weighted sum of squares most.
!>
!> That gain, g^T S^-1 g with g the score of the two parameters and S their information with all others
!> eliminated, is Rao's score statistic (Proc. Camb. Phil. Soc. 44 (1948) 50-57); without a wave it is a
!> chi-square with two degrees of freedom at each frequency.
module gracecg_estimation_wave_search
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_lanes, only: lanes_combine, WIDEST
    use gracecg_base_spectrum, only: strongest_line
    use gracecg_estimation_whitened_problem, only: whitened_problem_t
    use gracecg_estimation_batch_processor, only: batch_solution_t
    use gracecg_estimation_physical_model, only: airflow_at
    implicit none
    private
    public :: density_wave_found_t, search_wave

    real(dp), parameter :: LEAST_GAIN = 25
    !! exp(-25/2) = 4e-6 at one frequency, and some 100 of them are independent: one false alarm in 2000 arcs
    real(dp), parameter :: LEAST_CYCLES = 1.5_dp        !! In the arc: a slower wave looks like drift
    real(dp), parameter :: HIGHEST_FREQUENCY = 1.0_dp   !! Hz
    real(dp), parameter :: NEAR_LINE = 0.25_dp          !! Where the frequency is looked for, in units of 1/arc
    integer, parameter :: REFINEMENTS = 8               !! Of the golden section: to 0.005/arc, from where the fit finds it
    real(dp), parameter :: GOLDEN = (sqrt(5.0_dp) - 1)/2

    !> A wave in the residuals.
    type :: density_wave_found_t
        logical :: found = .false.    !! It stands out of the noise
        real(dp) :: frequency = 0           !! Hz
        real(dp) :: amplitude(2) = 0        !! Of sine and cosine, m/s^2
    end type density_wave_found_t

contains

    !> Looks for a wave in the residuals of a fit that has converged.
    function search_wave(problem, batch) result(wave)
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch     !! Of this problem
        type(density_wave_found_t) :: wave

        real(dp) :: line, frequency, low, high, inner(2), value(2), arc
        real(dp) :: along(3, size(problem%data%accelerometer_epoch))    ! the airflow, body axes
        integer :: i

        arc = problem%model%steps*problem%model%interval
        call line_along_airflow(problem, batch, arc, line, frequency)
        if (line < LEAST_GAIN) return
        do i = 1, size(along, 2)
            along(:, i) = airflow_at(problem%model, problem%state%quaternion, problem%data%accelerometer_epoch(i))
        end do
        low = frequency - NEAR_LINE/arc
        high = frequency + NEAR_LINE/arc
        inner = [high - GOLDEN*(high - low), low + GOLDEN*(high - low)]
        value = [gain_at(inner(1)), gain_at(inner(2))]
        do i = 1, REFINEMENTS
            if (value(1) > value(2)) then
                high = inner(2)
                inner = [high - GOLDEN*(high - low), inner(1)]
                value = [gain_at(inner(1)), value(1)]
            else
                low = inner(1)
                inner = [inner(2), low + GOLDEN*(high - low)]
                value = [value(2), gain_at(inner(2))]
            end if
        end do
        wave%frequency = (low + high)/2
        wave%found = gain_at(wave%frequency, wave%amplitude) >= LEAST_GAIN

    contains

        !> g^T S^-1 g at a frequency, and S^-1 g.
        real(dp) function gain_at(at, amplitude) result(gain)
            real(dp), intent(in) :: at                          !! Hz
            real(dp), intent(out), optional :: amplitude(2)

            real(dp) :: columns(2, problem%acceleration_rows), with_others(size(batch%inverse, 1), 2)
            real(dp) :: information(2, 2), score(2), solution(2), wave(2), angle, determinant
            integer :: k, axis, first

            do k = 1, size(problem%data%accelerometer_epoch)
                angle = TWO_PI*at*problem%data%accelerometer_epoch(k)*problem%model%interval
                wave = [sin(angle), cos(angle)]
                do axis = 1, 3
                    columns(:, 3*k - 3 + axis) = along(axis, k)*wave
                end do
            end do
            do axis = 1, 3
                call problem%whiteners(axis)%whiten(columns(:, axis::3))
            end do
            first = problem%star_rows
            score = 0
            information = 0
            do k = 1, problem%acceleration_rows
                score = score + columns(:, k)*batch%residuals(first + k)
                do axis = 1, 2
                    information(:, axis) = information(:, axis) + columns(:, k)*columns(axis, k)
                end do
            end do
            associate (n => size(with_others, 1), rows => problem%acceleration_rows)
                call lanes_combine(WIDEST, n, n, rows, 2, batch%gain(:, first + 1:first + rows), columns, with_others)
            end associate
            information = information - matmul(transpose(with_others), matmul(batch%inverse, with_others))
            gain = 0
            solution = 0
            determinant = information(1, 1)*information(2, 2) - information(1, 2)**2
            if (determinant > 1e-12_dp*information(1, 1)*information(2, 2)) then
                solution = [information(2, 2)*score(1) - information(1, 2)*score(2), &
                            information(1, 1)*score(2) - information(1, 2)*score(1)]/determinant
                gain = dot_product(score, solution)
            end if
            if (present(amplitude)) amplitude = solution
        end function gain_at
    end function search_wave

    !> The strongest line in the periodogram of the whitened residuals, the axes weighted as a wave
    !> along the airflow would show in them.
    subroutine line_along_airflow(problem, batch, arc, line, frequency)
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch
        real(dp), intent(in) :: arc                     !! s
        real(dp), intent(out) :: line                   !! A chi-square with two degrees of freedom
        real(dp), intent(out) :: frequency              !! Hz

        real(dp) :: series(size(problem%data%accelerometer_epoch)), along(3), weight(3)
        integer :: axis, first

        first = problem%star_rows
        along = airflow_at(problem%model, problem%state%quaternion, 0)
        weight = along/sqrt(problem%noise%accelerometer%level)
        weight = weight/norm2(weight)
        series = 0
        do axis = 1, 3
            series = series + weight(axis)*batch%residuals(first + axis:first + problem%acceleration_rows:3)
        end do
        call strongest_line(problem%data%accelerometer_epoch, series, size(series), problem%model%interval, &
                            arc, LEAST_CYCLES, HIGHEST_FREQUENCY, line, frequency)
    end subroutine line_along_airflow
end module gracecg_estimation_wave_search
