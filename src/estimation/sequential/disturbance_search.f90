!> Which Gauss-Markov processes the non-gravitational acceleration of an axis needs beside its straight
!> line, as the likelihood of the innovations tells.
!>
!> The likelihood is that of the observations with all constants integrated out (restricted maximum
!> likelihood: H. D. Patterson, R. Thompson, Biometrika 58 (1971) 545-554; by a filter: A. C. Harvey,
!> Forecasting, Structural Time Series Models and the Kalman Filter (1989) sections 3.4 and 4.2):
!>
!>     -2 ln L = sum ln s + sum e^2 + ln det R_y^T R_y,
!>
!> s the innovations' variances given the constants, e the residuals. A search begins only where the
!> spectrum of the whitened residuals has a line that noise would hardly make, so that where the drag
!> is a straight line nothing is lost; and a process must raise 2 ln L by a given amount to be taken.
!>
!> A tone has a likelihood in closed form. With c its cosine and sine, whitened, their amplitudes of the variance v a
!> priori, and the constants' estimate y from the whitened partials W and observations r without it,
!>
!>     2 ln L(tone) - 2 ln L = g^T P g - ln det(v S + I),   S = c^T c - c^T W (R_y^T R_y)^-1 W^T c,
!>     g = c^T (r - W y),   P = (S + I/v)^-1.
module gracecg_estimation_disturbance_search
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_spectrum, only: strongest_line
    use gracecg_base_gauss_markov, only: gauss_markov_t, second_order_process, superposed
    use gracecg_estimation_square_root_information, only: constants_t
    use gracecg_estimation_noise_whitening, only: process_filter_t, prepare_filter
    use gracecg_estimation_linearised_samples, only: filter_problem_t, SHARED, FREQUENCY, whiten_axis, gather, smooth_axis
    implicit none
    private
    public :: disturbance_t, disturbances_t, search_disturbances, with_disturbance, weigh_tone

    integer, parameter :: MOST_DISTURBANCES = 2         !! Processes of an axis

    !> A second-order Gauss-Markov process, for messages in the units of the search.
    type :: disturbance_t
        real(dp) :: sigma = 0           !! Standard deviation, in units of the white noise of a sample
        real(dp) :: frequency = 0       !! Of its undamped oscillation, Hz
        real(dp) :: damping = 0         !! Damping ratio
    end type disturbance_t

    !> The disturbances found in one axis.
    type :: found_t
        type(disturbance_t), allocatable :: list(:)
    end type found_t

    !> The disturbances found in all axes.
    type :: disturbances_t
        type(found_t) :: axis(3)                !! Not allocated: not searched for
        integer :: leading = 0                  !! Axis with the largest one; 0: none
        real(dp) :: shared_part(size(SHARED)) = 0
        !! A priori, the part of the leading axis' disturbance that the others see
    end type disturbances_t

    real(dp), parameter :: ALONG_THE_AIRFLOW = 0.7_dp   !! Cosine of the angle to an axis that drag acts along
    real(dp), parameter :: LEAST_CYCLES = 0.5_dp        !! Of a disturbance in the arc
    real(dp), parameter :: NEAR_LINE = 0.25_dp          !! First change of a frequency, in units of 1/arc
    real(dp), parameter :: HIGHEST_FREQUENCY = 0.5_dp   !! Of a disturbance, Hz
    real(dp), parameter :: LINE_LIKELY_NOISE = 20
    !! Below this no search: a line of the spectrum is a chi-square with 2 degrees of freedom, exceeds 20
    !! with the probability exp(-10), and some 30 frequencies in each of 3 axes are independent
    real(dp), parameter :: TONE = 1e-6_dp       !! Damping ratio of what does not wander
    real(dp), parameter :: WANDERING(3) = [0.003_dp, 0.05_dp, 1.0_dp]
    !! Where the search for other dampings begins: oscillations that wander more and more, a smooth wander
    real(dp), parameter :: COARSE = 2.5_dp, FINER = 1.5_dp  !! Steps of the search
    integer, parameter :: MOST_STEPS = 5
    real(dp), parameter :: WORTH = 1e-3_dp      !! Fall of -2 ln L below which a step is none: rounding must not decide
    real(dp), parameter :: CLEARLY = 10         !! Worse than another by so much of -2 ln L
    integer, parameter :: SIZE_OF = 1, DAMPING = 2
    integer, parameter :: ROUNDS_OF_VARIANCE = 6        !! To the most likely size of a tone

contains

    !> The process with a disturbance added.
    function with_disturbance(process, disturbance, interval) result(sum_of_both)
        type(gauss_markov_t), intent(in) :: process
        type(disturbance_t), intent(in) :: disturbance
        real(dp), intent(in) :: interval            !! s
        type(gauss_markov_t) :: sum_of_both

        sum_of_both = superposed(process, second_order_process(disturbance%sigma, TWO_PI*disturbance%frequency, &
                                                               disturbance%damping, interval))
    end function with_disturbance

    !> Searches all axes for disturbances and adds them to their processes. Drag varies along its own
    !> direction: of what the axis with the largest disturbance shows, the others see a part that is estimated,
    !> even where it is too small to be found by itself. So that axis comes first, and the others know of it.
    subroutine search_disturbances(needed_gain, white_sigma, airflow, problem, remainder, found)
        real(dp), intent(in) :: needed_gain             !! Of 2 ln L
        real(dp), intent(in) :: white_sigma(3)          !! Of the accelerometer, m/s^2
        real(dp), intent(in) :: airflow(3)              !! Its direction, body axes
        class(filter_problem_t), intent(inout) :: problem
        real(dp), intent(inout) :: remainder(:, :, :)   !! Of all axes with their processes
        type(disturbances_t), intent(out) :: found

        type(gauss_markov_t) :: noise(3)
        real(dp) :: largest(3)
        integer :: axis

        noise = problem%process
        problem%acceleration([SHARED, FREQUENCY], :, :) = 0
        do axis = 1, 3
            call search_axis(problem, axis, needed_gain, remainder, found%axis(axis)%list)
            largest(axis) = white_sigma(axis)*maxval([0.0_dp, found%axis(axis)%list%sigma])
        end do
        if (.not. maxval(largest) > 0) return
        found%leading = maxloc(largest, 1)
        call share_disturbance(found%leading, found%axis(found%leading)%list, noise(found%leading)%n, white_sigma, airflow, &
                               problem, remainder, found%shared_part)
        do axis = 1, 3
            if (axis == found%leading) cycle
            problem%process(axis) = noise(axis)
            call whiten_axis(problem, axis, remainder(:, :, axis))
            call search_axis(problem, axis, needed_gain, remainder, found%axis(axis)%list)
        end do
    end subroutine search_disturbances

    !> Smooths the disturbance of the leading axis and lets the other two see a part of it: a priori that
    !> of an acceleration along the airflow, if that is anywhere near the leading axis.
    !>
    !> A tone x(t), which wanders by less than a radian in the arc, is known no better than its frequency: an error of it
    !> by c cycles in the arc T, which is estimated, adds c dx/dc = 2 pi c (t - T/2)/T x'/omega, the process' second state.
    subroutine share_disturbance(leading, list, noise_states, white_sigma, airflow, problem, remainder, part)
        integer, intent(in) :: leading              !! Axis
        type(disturbance_t), intent(in) :: list(:)  !! Its disturbances
        integer, intent(in) :: noise_states         !! Of its process: those of the instrument's noise
        real(dp), intent(in) :: white_sigma(3), airflow(3)
        class(filter_problem_t), intent(inout) :: problem
        real(dp), intent(in) :: remainder(:, :, :)
        real(dp), intent(out) :: part(:)            !! A priori

        type(constants_t) :: constants
        real(dp) :: disturbance(2, size(problem%epoch))     ! and its partial by the frequency
        real(dp), dimension(size(problem%epoch)) :: unused_residual, unused_chi_square
        real(dp) :: signals(problem%process(leading)%n, 2), arc
        integer :: axis, other, largest, i

        part = 0
        call gather(problem, constants, remainder)
        signals = 0
        signals(noise_states + 1:, 1) = problem%process(leading)%output(noise_states + 1:)
        largest = maxloc(list%sigma, 1)
        arc = problem%steps*problem%interval
        if (list(largest)%damping*TWO_PI*list(largest)%frequency*arc < 1) signals(noise_states + 2*largest, 2) = TWO_PI
        call smooth_axis(problem, leading, constants, signals, disturbance, unused_residual, &
                         unused_chi_square)
        do i = 1, size(problem%epoch)
            disturbance(2, i) = disturbance(2, i)*(problem%epoch(i)/real(problem%steps, dp) - 0.5_dp)
        end do
        problem%acceleration(FREQUENCY, :, leading) = disturbance(2, :)
        other = 0
        do axis = 1, 3
            if (axis == leading) cycle
            other = other + 1
            if (abs(airflow(leading)) > ALONG_THE_AIRFLOW) part(other) = airflow(axis)/airflow(leading)
            associate (units => white_sigma(leading)/white_sigma(axis))
                problem%acceleration(SHARED(other), :, axis) = disturbance(1, :)*units
                problem%acceleration(FREQUENCY, :, axis) = disturbance(2, :)*units*part(other)
            end associate
        end do
    end subroutine share_disturbance

    !> Finds the disturbances of one axis and adds them to its process.
    subroutine search_axis(problem, axis, needed_gain, remainder, found)
        class(filter_problem_t), intent(inout) :: problem
        integer, intent(in) :: axis    !! 1, 2, 3
        real(dp), intent(in) :: needed_gain             !! Of 2 ln L
        real(dp), intent(inout) :: remainder(:, :, :)   !! Of all axes with their processes
        type(disturbance_t), allocatable, intent(out) :: found(:)

        type(constants_t) :: others, constants
        type(disturbance_t) :: best
        real(dp) :: current, value, line, frequency, amplitude

        allocate (found(0))
        call gather(problem, others, remainder, without=axis)
        call weigh
        do while (size(found) < MOST_DISTURBANCES)
            call line_of_residuals(problem, axis, constants, remainder(:, :, axis), line, frequency, amplitude)
            if (line < LINE_LIKELY_NOISE) exit
            call best_disturbance(problem, axis, others, constants, remainder(:, :, axis), current, frequency, amplitude, &
                                  best, value)
            if (.not. current - value > needed_gain) exit
            problem%process(axis) = with_disturbance(problem%process(axis), best, problem%interval)
            call prepare_filter(problem%process(axis), problem%epoch, problem%kept(:, axis), problem%filter(axis))
            found = [found, best]
            call weigh
        end do

    contains

        !> The likelihood of the process as it is now.
        subroutine weigh
            call minus_two_log_likelihood(problem, axis, problem%filter(axis), others, remainder(:, :, axis), &
                                          constants, current)
        end subroutine weigh
    end subroutine search_axis

    !> -2 ln L of all observations, apart from terms that do not depend on the axis' process.
    subroutine minus_two_log_likelihood(problem, axis, filter, others, remainder, constants, value)
        class(filter_problem_t), intent(in) :: problem
        integer, intent(in) :: axis
        type(process_filter_t), intent(in) :: filter    !! Of the axis' process
        type(constants_t), intent(in) :: others         !! From all but this axis
        real(dp), intent(out) :: remainder(:, :)        !! Of this axis
        type(constants_t), intent(out) :: constants     !! From all
        real(dp), intent(out) :: value

        remainder = problem%acceleration(:, :, axis)
        call filter%whiten(remainder)
        constants = others
        call constants%fold_in_all(remainder)
        value = filter%log_variance + constants%squares + constants%log_determinant()
    end subroutine minus_two_log_likelihood

    !> The strongest line in the spectrum of an axis' whitened residuals.
    subroutine line_of_residuals(problem, axis, constants, remainder, line, frequency, amplitude)
        class(filter_problem_t), intent(in) :: problem
        integer, intent(in) :: axis
        type(constants_t), intent(in) :: constants      !! From all observations
        real(dp), intent(in) :: remainder(:, :)
        real(dp), intent(out) :: line                   !! A chi-square with two degrees of freedom
        real(dp), intent(out) :: frequency              !! Hz
        real(dp), intent(out) :: amplitude              !! Of the whitened residuals

        real(dp) :: residual(size(remainder, 2)), y(problem%m)
        integer :: i, m, kept

        m = problem%m
        y = constants%solution()
        do i = 1, size(residual)
            residual(i) = remainder(m + 1, i) - dot_product(remainder(:m, i), y)
        end do
        kept = count(problem%kept(:, axis))
        call strongest_line(problem%epoch, residual, kept, problem%interval, problem%steps*problem%interval, &
                            LEAST_CYCLES, HIGHEST_FREQUENCY, line, frequency)
        amplitude = sqrt(2*line/kept)
    end subroutine line_of_residuals

    !> The disturbance near a line of the spectrum that makes the observations most likely: the best tone, and for each of
    !> a few dampings the size; if one of these is better than the tone, its frequency, damping and size.
    subroutine best_disturbance(problem, axis, others, constants, remainder, current, frequency, amplitude, best, value)
        class(filter_problem_t), intent(in) :: problem
        integer, intent(in) :: axis
        type(constants_t), intent(in) :: others         !! From all but this axis
        type(constants_t), intent(in) :: constants      !! From all observations, without the disturbance
        real(dp), intent(in) :: remainder(:, :)         !! Of the axis, without the disturbance
        real(dp), intent(in) :: current                 !! -2 ln L without it
        real(dp), intent(in) :: frequency, amplitude    !! Of the line
        type(disturbance_t), intent(out) :: best
        real(dp), intent(out) :: value                  !! -2 ln L

        type(disturbance_t) :: trial
        real(dp) :: root(problem%m, problem%m), y(problem%m), trial_value, shift
        real(dp), allocatable :: unused(:, :)
        integer :: i

        root = constants%inverse_root()
        y = constants%solution()
        best = disturbance_t(amplitude, frequency, TONE)
        call evaluate(best, value)
        call improve_frequencies(NEAR_LINE/(problem%steps*problem%interval))
        allocate (unused, mold=remainder)
        do i = 1, size(WANDERING)
            trial = disturbance_t(amplitude, best%frequency, WANDERING(i))
            call evaluate(trial, trial_value)
            call improve(SIZE_OF, COARSE, trial, trial_value)
            if (trial_value > value + CLEARLY) exit     ! what wanders even more is farther off
            if (trial_value < value) then
                value = trial_value
                best = trial
            end if
        end do
        if (.not. best%damping > TONE) return
        shift = max(best%damping*best%frequency, NEAR_LINE/(problem%steps*problem%interval))
        call improve_frequencies(shift)
        call improve(DAMPING, FINER*FINER, best, value)
        call improve(SIZE_OF, FINER, best, value)

    contains

        !> A tone gets its most likely size.
        subroutine evaluate(disturbance, result)
            type(disturbance_t), intent(inout) :: disturbance
            real(dp), intent(out) :: result

            type(process_filter_t) :: filter
            type(constants_t) :: with_it

            if (disturbance%damping > TONE) then
                call prepare_filter(with_disturbance(problem%process(axis), disturbance, problem%interval), problem%epoch, &
                                    problem%kept(:, axis), filter)
                call minus_two_log_likelihood(problem, axis, filter, others, unused, with_it, result)
            else
                call weigh_tone(problem%filter(axis), problem%interval, remainder, root, y, disturbance%frequency, &
                                disturbance%sigma, result)
                result = current - result
            end if
        end subroutine evaluate

        !> Finer and finer.
        subroutine improve_frequencies(shift)
            real(dp), intent(in) :: shift           ! First change, Hz

            integer :: k

            do k = 0, 2
                call improve_frequency(best, value, shift/4**k)
            end do
        end subroutine improve_frequencies

        !> Size or damping larger by factors as long as that helps; else smaller.
        subroutine improve(which, factor, disturbance, lowest)
            integer, intent(in) :: which                !! SIZE_OF or DAMPING
            real(dp), intent(in) :: factor
            type(disturbance_t), intent(inout) :: disturbance
            real(dp), intent(inout) :: lowest           !! Of this disturbance on entry

            type(disturbance_t) :: changed
            real(dp) :: result, step
            integer :: n

            step = factor
            do n = 1, MOST_STEPS
                changed = disturbance
                if (which == SIZE_OF) then
                    changed%sigma = disturbance%sigma*step
                else
                    changed%damping = min(1.0_dp, disturbance%damping*step)
                end if
                call evaluate(changed, result)
                if (result < lowest - WORTH) then
                    lowest = result
                    disturbance = changed
                else if (n == 1) then
                    step = 1/factor
                else
                    exit
                end if
            end do
        end subroutine improve

        !> To the vertex of the parabola through the likelihoods at three frequencies.
        subroutine improve_frequency(disturbance, lowest, change)
            type(disturbance_t), intent(inout) :: disturbance
            real(dp), intent(inout) :: lowest           !! Of this disturbance on entry
            real(dp), intent(in) :: change              !! Hz

            type(disturbance_t) :: left, right, vertex
            real(dp) :: at_left, at_right, at_vertex, curvature

            left = disturbance
            right = disturbance
            vertex = disturbance
            left%frequency = disturbance%frequency - min(change, disturbance%frequency/2)
            right%frequency = disturbance%frequency + (disturbance%frequency - left%frequency)
            call evaluate(left, at_left)
            call evaluate(right, at_right)
            curvature = at_left - 2*lowest + at_right
            if (curvature > 0) then
                vertex%frequency = disturbance%frequency + (right%frequency - disturbance%frequency)* &
                                   max(-1.0_dp, min(1.0_dp, (at_left - at_right)/(2*curvature)))
                call evaluate(vertex, at_vertex)
                if (at_vertex < min(lowest, at_left, at_right)) then
                    lowest = at_vertex
                    disturbance = vertex
                    return
                end if
            end if
            if (min(at_left, at_right) < lowest) then
                disturbance = merge(left, right, at_left < at_right)
                lowest = min(at_left, at_right)
            end if
        end subroutine improve_frequency
    end subroutine best_disturbance

    !> By how much a tone raises 2 ln L, at the size that raises it most: by rounds of expectation and maximisation
    !> (A. P. Dempster, N. M. Laird, D. B. Rubin, J. R. Stat. Soc. B 39 (1977) 1-38).
    subroutine weigh_tone(filter, interval, remainder, root, y, frequency, sigma, gain)
        type(process_filter_t), intent(in) :: filter    !! Of the axis' process without the tone
        real(dp), intent(in) :: interval                !! s
        real(dp), intent(in) :: remainder(:, :)         !! Whitened by the process: (m + 1, samples)
        real(dp), intent(in) :: root(:, :), y(:)        !! R_y^-1 and estimate of the constants from all observations
        real(dp), intent(in) :: frequency               !! Hz
        real(dp), intent(inout) :: sigma                !! Of the tone, white noise = 1
        real(dp), intent(out) :: gain                   !! Of 2 ln L

        real(dp) :: whitened(2, size(filter%epoch))
        real(dp) :: seen(size(y), 2), s(2, 2), p(2, 2), g(2), a(2), v, angle
        integer :: i, m, round

        m = size(y)
        do i = 1, size(filter%epoch)
            angle = TWO_PI*frequency*filter%epoch(i)*interval
            whitened(:, i) = [cos(angle), sin(angle)]
        end do
        call filter%whiten(whitened)
        seen = matmul(remainder(:m, :), transpose(whitened))
        g = matmul(whitened, remainder(m + 1, :)) - matmul(y, seen)
        seen = matmul(transpose(root), seen)
        s = matmul(whitened, transpose(whitened)) - matmul(transpose(seen), seen)
        v = sigma**2
        do round = 0, ROUNDS_OF_VARIANCE
            p = inverse_of(s + reshape([1/v, 0.0_dp, 0.0_dp, 1/v], [2, 2]))
            a = matmul(p, g)
            if (round < ROUNDS_OF_VARIANCE) v = (sum(a**2) + p(1, 1) + p(2, 2))/2
        end do
        sigma = sqrt(v)
        gain = dot_product(g, a) - log((1 + v*s(1, 1))*(1 + v*s(2, 2)) - v**2*s(1, 2)*s(2, 1))
    end subroutine weigh_tone

    !> Of a matrix of two rows.
    pure function inverse_of(m) result(inverse)
        real(dp), intent(in) :: m(2, 2)
        real(dp) :: inverse(2, 2)

        inverse = reshape([m(2, 2), -m(2, 1), -m(1, 2), m(1, 1)], [2, 2])/(m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1))
    end function inverse_of
end module gracecg_estimation_disturbance_search
