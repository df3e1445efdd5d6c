!> Which beliefs of the operator a fit contradicts, which it confirms, and which it cannot test.
!>
!> A belief with a value theta (0: as believed) would add h theta to the whitened observations. With the parameters x
!> of the fit, information N, and its covariance N^-1, the score statistic (C. R. Rao, Proc. Camb. Phil. Soc. 44
!> (1948) 50-57) needs no other fit:
!>
!>     g = h^T r,   S = h^T h - h^T A N^-1 A^T h,   theta = g/S,   T = theta/sqrt(1/S + sigma_0^2),
!>
!> a standard normal variable if the belief is right to the sigma_0 that the operator states (0 if none is). What a
!> wrong value does to the parameters is N^-1 A^T h theta. The smallest value that a test of level alpha finds with
!> the probability beta is (k_alpha + z_beta) sqrt(1/S + sigma_0^2): W. Baarda, A testing procedure for use in geodetic
!> networks, Netherlands Geodetic Commission, Publications on Geodesy 2 (5), 1968: the minimal detectable value
!> (internal reliability) and its effect on the offset (external reliability).
!>
!> The level is that of all tests together: each of n has 1 - (1 - alpha)^(1/n) (Z. Sidak, J. Am. Stat. Assoc. 62
!> (1967) 626-633), which holds the family's at alpha or below, however the tests depend on each other.
module gracecg_estimation_belief_tests
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: NANOTESLA
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_spectrum, only: strongest_line
    use gracecg_base_statistics, only: normal_quantile
    use gracecg_spacecraft_torque_rods, only: torque_rods_t
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_parameters
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_parameters, only: a_priori_sigmas, conceivable_errors, feels_air
    use gracecg_estimation_whitened_problem, only: whitened_problem_t, with_parameters, set_noise, information_matrix
    use gracecg_estimation_belief_report
    implicit none
    private
    public :: test_beliefs, test_values, side_scores

    real(dp), parameter :: DETERMINED = 1e-12_dp
    !! Of a belief's information: the least part of it that is not taken by the other parameters, for it to count. A turn
    !! of the accelerometer has 1e-10 of it left; the rounding of the refined difference is some 1e-15.

    real(dp), parameter :: SEEN = 1e-12_dp
    !! Chi-square of the data under the largest conceivable wrong value, for a belief to have to do with them: with fused
    !! multiply-add, partials that cancel leave 1e-28 of rounding.

contains

    !> Tests all beliefs at a fit. Fails when the fit's normal matrix is singular.
    subroutine test_beliefs(knowledge, options, fitted, report, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(whitened_problem_t), intent(in) :: fitted  !! At its solution
        type(belief_report_t), intent(out) :: report
        type(error_t), allocatable, intent(out) :: error

        type(whitened_problem_t) :: problem
        real(dp), allocatable :: information(:, :), rhs(:), residuals(:)
        real(dp), allocatable :: covariance(:, :), correction(:)
        real(dp) :: sigma(PARAMETERS), condition
        integer, allocatable :: estimated(:), tested(:)
        integer :: n, i

        estimated = fitted%model%estimated          ! and drag that bends, of which nobody believes anything
        do i = 1, size(FORCE_SHAPES)
            if (.not. any(estimated == FORCE_SHAPES(i))) estimated = [estimated, FORCE_SHAPES(i)]
        end do
        n = size(estimated)
        tested = pack(BELIEFS, [(.not. any(estimated == BELIEFS(i)), i=1, size(BELIEFS))])
        call with_parameters(knowledge, options, fitted, [estimated, tested], problem)
        call set_noise(problem, error)
        if (allocated(error)) return
        call information_matrix(problem, information, rhs, residuals)
        sigma = a_priori_sigmas(knowledge)
        do i = 1, size(tested)      ! what the operator states of them is no observation here
            if (sigma(tested(i)) > 0) information(n + i, n + i) = information(n + i, n + i) - 1/sigma(tested(i))**2
        end do
        allocate (covariance(n, n), correction(n))
        call solve_normal_equations(information(:n, :n), rhs(:n), correction, covariance, condition, error, &
                                    parameter_names(estimated))
        if (allocated(error)) return
        call begin_report(fitted%state%value(OFFSET), options%wanted_accuracy, knowledge%a_priori%signs_known, report)
        associate (values => fitted%state%value)        ! gfortran 12 without optimisation fails on its element
            if (any(fitted%model%estimated == WAVE_SINE)) &
                report%wave_frequency = fitted%model%wave_frequency + values(WAVE_FREQUENCY)
        end associate
        call test_values(problem%model%estimated, n, information, rhs, covariance, sigma, conceivable_errors(knowledge), &
                         fitted%state%value(estimated), report)
        if (knowledge%rods%direct) call name_torquers(report%values%subject)
        call test_noise(fitted, residuals, report)
        call test_spectra(knowledge%rods, fitted, residuals, report)
        associate (scores => side_scores(knowledge, fitted%data))
            if (fitted%data%field_compared) call add_score(report, FIELD_AGAINST_MODEL, farthest(scores(:3)), 0.0_dp, .false.)
            if (fitted%data%stars%pairs > 0) call add_score(report, HEADS_APART, farthest(scores(4:)), 0.0_dp, .false.)
        end associate
        report%arc = knowledge%duration
        report%feels_air = feels_air(knowledge)
        report%field_seen = fitted%data%field_seen
        report%field_modelled = fitted%data%field_modelled
        report%head_turn = fitted%data%stars%head_turn
        call finish_report(report)
    end subroutine test_beliefs

    !> A satellite that torquers turn has no rods.
    elemental subroutine name_torquers(subject)
        character(*), intent(inout) :: subject

        integer :: i

        i = index(subject, 'rod')
        if (i > 0) subject = subject(:i - 1)//'torquer'//subject(i + 3:)
    end subroutine name_torquers

    !> The beliefs with a value. The first n of the parameters are estimated: an a-priori value that the data
    !> contradict is a wrong belief, too.
    subroutine test_values(places, n, information, rhs, covariance, sigma, conceivable, state, report)
        integer, intent(in) :: places(:), n                 !! Parameters; the estimated ones come first. Others are not tested
        real(dp), intent(in) :: information(:, :), rhs(:)   !! Of all of them, (places), SI units
        real(dp), intent(in) :: covariance(:, :)            !! Of the estimated ones, (n, n)
        real(dp), intent(in) :: sigma(:)                    !! A priori, (PARAMETERS); 0: none is stated
        real(dp), intent(in) :: conceivable(:)              !! Largest errors within what the operator states, (PARAMETERS)
        real(dp), intent(in) :: state(:)                    !! Values of the estimated ones, (n)
        type(belief_report_t), intent(inout) :: report      !! Begun; their tests are added

        real(dp) :: on_fit(n, size(places)), left, score, by_one(3), stated, scatter, known(size(places))
        integer :: i, k, c, d(3)

        d = [(findloc(places(:n), OFFSET(i), 1), i=1, 3)]
        known = known_to(places, sigma(places), conceivable(places))
        known(:n) = 0
        on_fit(:, :n) = 0
        do c = n + 1, size(places)
            on_fit(:, c) = moved_by(c)
        end do
        report%stated = [(norm2(on_fit(d(i), :)*known), i=1, 3)]
        do i = 1, size(BELIEFS)
            c = findloc(places, BELIEFS(i), 1)
            if (c == 0) cycle
            stated = sigma(BELIEFS(i))
            if (c <= n) then
                if (.not. stated > 0) cycle             ! nothing is believed of it
                left = 1/covariance(c, c) - 1/stated**2
                by_one = covariance(d, c)/stated**2
                score = state(c)/covariance(c, c)       ! what the estimate owes to the data
                scatter = norm2(on_fit(c, :)*known)/covariance(c, c)
            else
                ! it has nothing to do with these data
                if (.not. information(c, c)*LARGEST_ERROR(BELIEFS(i))**2 > SEEN) cycle
                ! so that the error of on_fit enters by its square
                left = information(c, c) - dot_product(2*information(:n, c) - matmul(information(:n, :n), on_fit(:, c)), &
                                                       on_fit(:, c))
                score = rhs(c) - dot_product(on_fit(:, c), rhs(:n))
                by_one = on_fit(d, c)
                if (left < DETERMINED*information(c, c)) left = 0
                scatter = norm2([(known(k)*(information(k, c) - dot_product(on_fit(:, k), information(:n, c))), &
                                  k=n + 1, size(places))])
            end if
            if (left > 0) scatter = scatter/left
            if (c <= n) scatter = hypot(scatter, stated)
            call add_value(report, BELIEFS(i), score, left, stated, scatter, by_one, LARGEST_ERROR(BELIEFS(i)), &
                           conceivable(BELIEFS(i)), any(INTERCHANGES == BELIEFS(i)))
        end do

    contains

        !> What an error of 1 of a belief that is not estimated moves the estimated parameters by. What is left of its
        !> information may be 1e-10 of the whole (a turn of the accelerometer is nearly a bias): refined once.
        function moved_by(c) result(moved)
            integer, intent(in) :: c                ! Its place
            real(dp) :: moved(n)

            moved = matmul(covariance, information(:n, c))
            moved = moved + matmul(covariance, information(:n, c) - matmul(information(:n, :n), moved))
        end function moved_by
    end subroutine test_values

    !> Standard deviations to which beliefs are known; 0 where nothing is stated, or where it is stated of all rods together.
    elemental real(dp) function known_to(place, sigma, conceivable)
        integer, intent(in) :: place                ! Of the parameter
        real(dp), intent(in) :: sigma, conceivable  ! A priori; the largest error within what is stated

        real(dp), parameter :: SIGMAS = 3           ! As of conceivable_errors

        known_to = sigma
        if (.not. sigma > 0 .and. conceivable < LARGEST_ERROR(place)) known_to = conceivable/SIGMAS
        if (any([INTERCHANGES, ROD_GAINS, ROD_DELAYS, ROD_FREQUENCIES] == place)) known_to = 0
    end function known_to

    !> Whether the whitened residuals of each accelerometer axis are white: the correlation of neighbours, of which a
    !> parameter that follows low frequencies takes 1/n, and the strongest line of the spectrum. Of a line, a
    !> chi-square with two degrees of freedom, the largest of n independent ones has the distribution
    !> (1 - exp(-x/2))^n; four times as many frequencies are tried, which are hardly more than twice as many
    !> independent ones.
    subroutine test_spectra(rods, fitted, residuals, report)
        type(torque_rods_t), intent(in) :: rods
        type(whitened_problem_t), intent(in) :: fitted
        real(dp), intent(in) :: residuals(:)            !! Whitened, of all observations
        type(belief_report_t), intent(inout) :: report

        real(dp), parameter :: LEAST_CYCLES = 3, CORRELATED_FREQUENCIES = 2.2_dp
        real(dp), allocatable :: series(:)
        real(dp) :: score, arc, tail, taken, lines(3), frequencies(3)
        integer :: axis, used, n

        arc = fitted%model%steps*fitted%model%interval
        associate (stars => fitted%star_rows, accelerations => fitted%acceleration_rows)
            taken = size(fitted%model%estimated)/3.0_dp
            do axis = 1, 3
                used = count(fitted%acceleration_kept(axis, :))
                series = residuals(stars + axis:stars + accelerations:3)
                n = size(series)
                if (used < 2*taken) return
                series = series/norm2(series)
                score = (dot_product(series(:n - 1), series(2:)) + taken/used)*sqrt(real(used, dp))
                call add_score(report, 6 + axis, score, 0.0_dp, .false.)
                call strongest_line(fitted%data%accelerometer_epoch, series, 1, fitted%model%interval, arc, LEAST_CYCLES, &
                                    0.5_dp/fitted%model%interval, lines(axis), frequencies(axis))
            end do
            do axis = 1, 3
                used = count(fitted%acceleration_kept(axis, :))
                tail = CORRELATED_FREQUENCIES*used/2*exp(-lines(axis)/2)
                score = 0
                if (tail < 0.5_dp) score = -normal_quantile(max(tail, 4*tiny(1.0_dp))/2)     ! up to 37
                call add_score(report, 9 + axis, score, frequencies(axis), at_a_rod(frequencies(axis)))
            end do
        end associate

    contains

        pure logical function at_a_rod(line_frequency)
            real(dp), intent(in) :: line_frequency

            at_a_rod = any(abs(rods%activations(:rods%count)%frequency - line_frequency) < 1/arc)
        end function at_a_rod
    end subroutine test_spectra

    !> What the fit does not look at, in standard deviations of what is known: how far the magnetometer's mean is off the
    !> model's, by bias, scale factors and directions of the magnetometer, and the model, which leaves out the crust and
    !> currents outside; and how far the two star-camera heads are apart, by their mounting and noise. 0 where not compared.
    pure function side_scores(knowledge, data) result(scores)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(in) :: data
        real(dp) :: scores(6)                       !! Field along body axes, turn about them

        real(dp), parameter :: OF_MODEL = 300*NANOTESLA     ! twice what section 6.4 of the report assumes of its model
        real(dp) :: across(3), of_heads

        scores = 0
        associate (known => knowledge%a_priori, field => data%field_modelled)
            if (data%field_compared) then
                across = sqrt(max(0.0_dp, sum(field**2) - field**2))
                scores(:3) = (data%field_seen - field)/sqrt(known%sigma_magnetometer_bias**2 + &
                                                           (known%sigma_magnetometer_scale*field)**2 + &
                                                           (known%sigma_directions(3)*across)**2 + OF_MODEL**2)
            end if
            if (data%stars%pairs == 0) return
            of_heads = sqrt(2*(known%sigma_mounting**2 + maxval(knowledge%star_camera_sigma)**2/data%stars%pairs))
            scores(4:) = data%stars%head_turn/of_heads
        end associate
    end function side_scores

    !> The score that is farthest from 0.
    pure real(dp) function farthest(scores)
        real(dp), intent(in) :: scores(:)

        farthest = scores(maxloc(abs(scores), 1))
    end function farthest

    !> Whether the noise of each accelerometer axis, and of the star camera about each of its axes, is that which the
    !> fit was weighted with: the sum of squares of the whitened residuals is a chi-square.
    subroutine test_noise(fitted, residuals, report)
        type(whitened_problem_t), intent(in) :: fitted
        real(dp), intent(in) :: residuals(:)            !! Whitened, of all observations
        type(belief_report_t), intent(inout) :: report

        real(dp) :: share
        integer :: axis, used

        share = real(size(fitted%model%estimated), dp)/ &
                max(1, count(fitted%acceleration_kept) + 3*count(fitted%star_kept))
        associate (stars => fitted%star_rows, accelerations => fitted%acceleration_rows)
            do axis = 1, 3
                used = count(fitted%acceleration_kept(axis, :))
                call add_noise(report, axis, sum(residuals(stars + axis:stars + accelerations:3)**2), used*(1 - share))
            end do
            do axis = 1, 3
                call add_noise(report, 3 + axis, sum(residuals(axis:stars:3)**2), count(fitted%star_kept)*(1 - share))
            end do
        end associate
    end subroutine test_noise
end module gracecg_estimation_belief_tests
