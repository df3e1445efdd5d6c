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
    use gracecg_base_lanes, only: lanes_sines_cosines, lanes_of, LANES
    use gracecg_base_lapack, only: sum_of_products
    use gracecg_base_spectrum, only: strongest_line
    use gracecg_base_text, only: append, rounded_text, string_t
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    use gracecg_observations_parameters, only: WAVE_FREQUENCY, WAVE_SINE, WAVE_COSINE
    use gracecg_estimation_whitened_problem, only: whitened_problem_t
    use gracecg_estimation_batch_problem, only: batch_solution_t
    use gracecg_estimation_physical_model, only: airflow_at
    implicit none
    private
    public :: density_wave_found_t, search_wave, search_level, report_wave

    real(dp), parameter :: LEAST_GAIN = 25
    !! exp(-25/2) = 4e-6 at one frequency, and some 100 of them are independent: one false alarm in 2000 arcs
    real(dp), parameter :: LOUD = 1e-20_dp      !! Noise of the report's cases, m^2 s^-4/Hz: see search_level
    real(dp), parameter :: LEAST_CYCLES = 1.5_dp        !! In the arc: a slower wave looks like drift
    real(dp), parameter :: HIGHEST_FREQUENCY = 1.0_dp   !! Hz
    real(dp), parameter :: NEAR_LINE = 0.25_dp          !! Where the frequency is looked for, in units of 1/arc
    integer, parameter :: FREQUENCIES = 8
    !! Looked at there, side by side: a parabola through the best three has its top within 0.001/arc of the line's, from
    !! where the fit finds it
    real(dp), parameter :: LEAST_SEPARATE = 1e-12_dp    !! Determinant of S, its diagonal 1

    !> A wave in the residuals.
    type :: density_wave_found_t
        logical :: found = .false.    !! It stands out of the noise
        real(dp) :: frequency = 0           !! Hz
        real(dp) :: amplitude(2) = 0        !! Of sine and cosine, m/s^2
        real(dp) :: gain = 0                !! Of the weighted squares
    end type density_wave_found_t

contains

    !> The noise under which a wave is searched for first: one that is far above the noise drives a fit without it away. With
    !> 5e-24, 490 km up, one of 8 fits failed in 18 of 48 places, with this in none.
    elemental real(dp) function search_level(level)
        real(dp), intent(in) :: level   !! Of the accelerometer, m^2 s^-4/Hz; 0: not known

        search_level = merge(max(level, LOUD), level, level > 0)
    end function search_level

    !> Looks for a wave in the residuals of a fit that has converged.
    function search_wave(rods, problem, batch) result(wave)
        type(torque_rods_t), intent(in) :: rods         !! Of the manoeuvre
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch     !! Of this problem
        type(density_wave_found_t) :: wave

        type(density_wave_found_t) :: other
        real(dp) :: line, middle, at_rods, arc
        real(dp) :: along(3, size(problem%data%accelerometer_epoch))    ! the airflow, body axes
        integer :: i

        arc = problem%model%steps*problem%model%interval
        call line_along_airflow(problem, batch, arc, line, middle)
        if (line < LEAST_GAIN) return
        do i = 1, size(along, 2)
            along(:, i) = airflow_at(problem%model, problem%state%quaternion, problem%data%accelerometer_epoch(i))
        end do
        call look_near(problem, batch, along, arc, middle, wave)
        at_rods = likeliest_at_rods(rods, problem, batch, along, arc)
        if (abs(at_rods - middle)*arc < 1) return
        call look_near(problem, batch, along, arc, at_rods, other)
        if (other%gain > wave%gain) wave = other
    end function search_wave

    !> The best frequency near another.
    subroutine look_near(problem, batch, along, arc, middle, wave)
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch
        real(dp), intent(in) :: along(:, :), arc, middle        !! The airflow; s; Hz
        type(density_wave_found_t), intent(out) :: wave

        real(dp) :: spacing, gains(FREQUENCIES), one(1), amplitude(2, 1), curvature
        integer :: i

        spacing = 2*NEAR_LINE/arc/(FREQUENCIES - 1)
        call find_gains(problem, batch, along, [(middle - NEAR_LINE/arc + i*spacing, i=0, FREQUENCIES - 1)], gains)
        i = min(FREQUENCIES - 1, max(2, maxloc(gains, 1)))
        curvature = gains(i - 1) - 2*gains(i) + gains(i + 1)
        wave%frequency = middle - NEAR_LINE/arc + (i - 1)*spacing
        if (curvature < 0) wave%frequency = wave%frequency + &
            spacing*min(1.0_dp, max(-1.0_dp, (gains(i - 1) - gains(i + 1))/(2*curvature)))
        call find_gains(problem, batch, along, [wave%frequency], one, amplitude)
        wave%gain = one(1)
        wave%found = wave%gain >= LEAST_GAIN
        wave%amplitude = amplitude(:, 1)
    end subroutine look_near

    !> A wave at a rod's frequency is taken for an offset by a fit without it, and leaves but a harmonic of square moments, or
    !> beside a gap another line: of all frequencies up to that of the fastest rod, Hz, the one of most gain.
    real(dp) function likeliest_at_rods(rods, problem, batch, along, arc) result(frequency)
        type(torque_rods_t), intent(in) :: rods
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch
        real(dp), intent(in) :: along(:, :), arc        !! The airflow; s

        real(dp) :: at(FREQUENCIES), gains(FREQUENCIES), most, fastest
        integer :: i, k

        most = -1
        fastest = min(HIGHEST_FREQUENCY, maxval([0.0_dp, rods%activations(:rods%count)%frequency]))
        do k = 0, max(0, ceiling(2*(fastest*arc - LEAST_CYCLES)))/FREQUENCIES
            at = [((LEAST_CYCLES + 0.5_dp*(k*FREQUENCIES + i))/arc, i=0, FREQUENCIES - 1)]
            call find_gains(problem, batch, along, at, gains)
            i = maxloc(gains, 1)
            if (gains(i) <= most) cycle
            most = gains(i)
            frequency = at(i)
        end do
    end function likeliest_at_rods

    !> g^T S^-1 g at some frequencies, and S^-1 g. Their sines and cosines lie side by side.
    subroutine find_gains(problem, batch, along, at, gain, amplitude)
        type(whitened_problem_t), intent(in) :: problem
        type(batch_solution_t), intent(in) :: batch     !! Of this problem
        real(dp), intent(in) :: along(:, :)             !! The airflow, axis and sample
        real(dp), intent(in) :: at(:)                   !! Hz
        real(dp), intent(out) :: gain(:)                !! By frequency; 0: not told from other parameters
        real(dp), intent(out), optional :: amplitude(:, :)  !! Of sine and cosine, frequency; m/s^2

        real(dp), dimension(lanes_of(size(at)*size(along, 2))) :: turns, sines, cosines
        real(dp) :: columns(2*size(at), 3*size(along, 2)), with_others(size(batch%inverse, 1), 2*size(at))
        real(dp), dimension(size(at)) :: sine_sine, sine_cosine, cosine_cosine
        real(dp) :: score(2*size(at)), determinant, solution(2)
        integer :: i, k, axis, n, parameters, rows

        n = size(at)
        turns = 0
        do k = 1, size(along, 2)
            turns((k - 1)*n + 1:k*n) = at*(problem%data%accelerometer_epoch(k)*problem%model%interval)
        end do
        do k = 1, size(turns), LANES
            call lanes_sines_cosines(turns(k:k + LANES - 1), sines(k:k + LANES - 1), cosines(k:k + LANES - 1))
        end do
        do k = 1, size(along, 2)
            do axis = 1, 3
                columns(:n, 3*k - 3 + axis) = along(axis, k)*sines((k - 1)*n + 1:k*n)
                columns(n + 1:, 3*k - 3 + axis) = along(axis, k)*cosines((k - 1)*n + 1:k*n)
            end do
        end do
        do axis = 1, 3
            call problem%whiteners(axis)%whiten(columns(:, axis::3))
        end do
        parameters = size(with_others, 1)
        rows = problem%acceleration_rows
        associate (first => problem%star_rows)
            call sum_of_products(parameters, 2*n, rows, batch%gain(:, first + 1:first + rows), columns, with_others)
            score = 0
            sine_sine = 0
            sine_cosine = 0
            cosine_cosine = 0
            do k = 1, rows
                score = score + columns(:, k)*batch%residuals(first + k)
                sine_sine = sine_sine + columns(:n, k)**2
                sine_cosine = sine_cosine + columns(:n, k)*columns(n + 1:, k)
                cosine_cosine = cosine_cosine + columns(n + 1:, k)**2
            end do
        end associate
        gain = 0
        if (present(amplitude)) amplitude = 0
        do i = 1, n
            associate (sine => with_others(:, i), cosine => with_others(:, n + i), s => score(i), c => score(n + i))
                associate (ss => sine_sine(i) - dot_product(sine, matmul(batch%inverse, sine)), &
                           sc => sine_cosine(i) - dot_product(sine, matmul(batch%inverse, cosine)), &
                           cc => cosine_cosine(i) - dot_product(cosine, matmul(batch%inverse, cosine)))
                    determinant = ss*cc - sc**2
                    if (.not. determinant > LEAST_SEPARATE*ss*cc) cycle
                    solution = [cc*s - sc*c, ss*c - sc*s]/determinant
                    gain(i) = s*solution(1) + c*solution(2)
                end associate
            end associate
            if (present(amplitude)) amplitude(:, i) = solution
        end do
    end subroutine find_gains

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

    !> Warns of a wave that was found: as the fit with it has it, or, where that did not succeed, as the search has.
    subroutine report_wave(wave, problem, warnings)
        type(density_wave_found_t), intent(in) :: wave      !! `found`: the fit with it succeeded
        type(whitened_problem_t), intent(in) :: problem     !! That fit, or the one without it
        type(string_t), allocatable, intent(inout) :: warnings(:)

        character(48), parameter :: CONSEQUENCE(2) = [character(48) :: &
            'it is estimated, too, and a parabola of the drag', 'it cannot be estimated and is left in']
        real(dp) :: frequency, amplitude(2)

        frequency = wave%frequency
        amplitude = wave%amplitude
        if (wave%found) then
            frequency = problem%model%wave_frequency + problem%state%value(WAVE_FREQUENCY)
            amplitude = problem%state%value([WAVE_SINE, WAVE_COSINE])
        end if
        call append(warnings, 'the residuals of the accelerometer show a wave of period '//rounded_text(1/frequency, 4)// &
                    ' s and amplitude '//rounded_text(norm2(amplitude), 3)//' m/s^2 along the airflow: '// &
                    trim(CONSEQUENCE(merge(1, 2, wave%found))))
    end subroutine report_wave
end module gracecg_estimation_wave_search
