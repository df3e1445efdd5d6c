!> What a calibration tells of itself: identities of its parts, known noise, and the verdict.
module test_fit_diagnostics
    use vocabulary
    use calibrations
    use gracecg_base_quaternion, only: normalised, rotation_matrix
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, noise_spectrum_t, TWO_SIDED
    use gracecg_estimation_noise_whitening, only: whitener_t, new_whitener
    use gracecg_estimation_fit_record, only: fit_record_t
    use gracecg_estimation_diagnostics
    use gracecg_estimation_action, only: action_t, known_offset_t, decide, TRIM_IT, LEAVE_IT, CALIBRATE_AGAIN, &
        DO_NOT_USE, NOT_TESTED
    use gracecg_base_text, only: append
    use gracecg_estimation_belief_report, only: CONTRADICTED
    use gracecg_estimation_belief_words, only: FAILED_TESTS
    use gracecg_estimation_verdict, only: verdict_t, judge, act_on, GRADE_GOOD, GRADE_DOUBTFUL, GRADE_BAD
    use statistics, only: Z_999
    implicit none
    private
    public :: collect_fit_diagnostics

    real(dp), parameter :: H = 0.1_dp       !! Sampling interval, s

contains

    subroutine collect_fit_diagnostics(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('ellipsoid-of-a-known-covariance', test_ellipsoid), &
                    new_unittest('information-sums-to-the-whole', test_information), &
                    new_unittest('record-of-every-estimator', test_record), &
                    new_unittest('known-noise-looks-like-noise', test_known_noise), &
                    new_unittest('what-is-no-noise-is-seen', test_other_noise), &
                    new_unittest('noise-not-known', test_unknown_noise), &
                    new_unittest('good-verdict', test_good), &
                    new_unittest('doubtful-verdicts', test_doubtful), &
                    new_unittest('bad-verdict', test_bad), &
                    new_unittest('what-is-small-is-left', test_leave)]
    end subroutine collect_fit_diagnostics

    !> Semi-axes 3, 2, 1 mm along the columns of a rotation.
    function turned_covariance(axes) result(covariance)
        real(dp), intent(out) :: axes(3, 3)
        real(dp) :: covariance(3, 3)

        axes = transpose(rotation_matrix(normalised([0.3_dp, -0.2_dp, 0.5_dp, 0.7_dp])))
        covariance = 1e-6_dp*matmul(axes*spread([9.0_dp, 4.0_dp, 1.0_dp], 1, 3), transpose(axes))
    end function turned_covariance

    subroutine test_ellipsoid(error)
        type(error_type), allocatable, intent(out) :: error
        type(ellipsoid_t) :: ellipsoid
        type(error_t), allocatable :: failure
        real(dp) :: axes(3, 3), covariance(3, 3)
        integer :: k

        covariance = turned_covariance(axes)
        call error_ellipsoid(covariance, ellipsoid, failure)
        if (failed(error, failure)) return
        call check(error, maxval(abs(ellipsoid%semi_axis - 1e-3_dp*[3, 2, 1])), 0.0_dp, thr=1e-15_dp)
        do k = 1, 3
            call check(error, abs(dot_product(ellipsoid%direction(:, k), axes(:, k))), 1.0_dp, thr=1e-12_dp)
            associate (v => ellipsoid%direction(:, k))
                call check(error, v(maxloc(abs(v), 1)) > 0, 'the largest component is not positive')
            end associate
        end do
    end subroutine test_ellipsoid

    !> The sum over the axes is the information of the whole: what is left of the normal matrix of d and
    !> of bias and drift of each axis, with the inverse of the covariance matrix of all samples as
    !> weight, when bias and drift are eliminated. Some samples are missing.
    subroutine test_information(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 40
        real(dp), parameter :: LEVELS(3) = [1e-20_dp, 1e-18_dp, 2e-20_dp], CORNERS(3) = [0.5_dp, 2.0_dp, 0.0_dp]
        type(coloured_noise_t) :: noise
        type(whitener_t) :: whitener
        type(error_t), allocatable :: failure
        real(dp) :: partials(3, 3, N), total(3, 3), whole(9, 9), inverse(9, 9), solved(9), condition
        real(dp) :: matrix(N, N), weight(N, N), rows(9, N), unused(N), expected(3, 3)
        integer :: epoch(N), i, j, axis

        do i = 1, N
            epoch(i) = i + i/7 + 3*(i/20)
        end do
        partials = reshape([(1e-6_dp*(sin(1.7_dp*i) + cos(0.31_dp*i*i)), i=1, 9*N)], [3, 3, N])
        total = 0
        whole = 0
        do axis = 1, 3
            noise = coloured_noise(noise_spectrum_t(LEVELS(axis), CORNERS(axis), TWO_SIDED), H, failure)
            call new_whitener(noise, epoch, whitener, failure)
            if (failed(error, failure)) return
            total = total + information_by_axis(epoch, partials(axis, :, :), whitener)
            do j = 1, N
                matrix(:, j) = noise%autocovariance(abs(epoch - epoch(j)))
            end do
            call solve_normal_equations(matrix, [(0.0_dp, i=1, N)], unused, weight, condition, failure)
            if (failed(error, failure)) return
            rows = 0
            rows(:3, :) = partials(axis, :, :)
            rows(2*axis + 2, :) = 1
            rows(2*axis + 3, :) = epoch*H
            whole = whole + matmul(rows, matmul(weight, transpose(rows)))
        end do
        call solve_normal_equations(whole, [(0.0_dp, i=1, 9)], solved, inverse, condition, failure)
        if (failed(error, failure)) return
        expected = inverse_3x3(inverse(:3, :3))
        call check(error, maxval(abs(total - expected)), 0.0_dp, thr=1e-8_dp*maxval(abs(expected)))
        ! white noise of variance 1: the partials without their straight line
        expected = information_by_axis(epoch, partials(1, :, :))
        call check(error, maxval(abs(expected - information_by_axis(epoch, partials(1, :, :) + &
                                                                    spread(1e-6_dp*epoch - 3e-5_dp, 1, 3)))), 0.0_dp, &
                   thr=1e-8_dp*maxval(abs(expected)))
    end subroutine test_information

    !> One run of a case of the report.
    subroutine simulate(name, quiet, observations)
        character(*), intent(in) :: name
        logical, intent(in) :: quiet        !! Without the density wave and scale factors
        type(observation_set_t), intent(out) :: observations
        type(case_t) :: case

        call take_case(name, case)
        if (quiet) case%density_wave%amplitude = 0
        call make_observations(case, 1, 1, observations)
    end subroutine simulate

    !> What every estimator has to put into the record: complete, and in agreement with its solution,
    !> which is the same as without a record.
    subroutine test_record(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: solution, alone
        type(fit_record_t) :: record
        type(fit_diagnostics_t) :: diagnostics
        type(error_t), allocatable :: failure
        character(:), allocatable :: name
        integer :: i, n

        call simulate('front-3', .false., observations)
        n = size(observations%accelerometer_time)
        do i = 1, size(ESTIMATOR_NAMES)
            name = trim(ESTIMATOR_NAMES(i))
            call estimate_offset(name, observations, estimation_options_t(), alone, failure)
            if (.not. allocated(failure)) &
                call estimate_offset(name, observations, estimation_options_t(), solution, failure, record=record)
            if (.not. allocated(failure)) &
                call diagnose(observations%knowledge, solution, record, diagnostics, failure)
            if (failed(error, failure)) return
            call check(error, maxval(abs(solution%offset - alone%offset)), 0.0_dp, name)
            call check(error, maxval(abs(solution%covariance - alone%covariance)), 0.0_dp, name, &
                       thr=1e-12_dp*maxval(abs(alone%covariance)))
            if (unmet(error, size(record%epoch) == n .and. all(shape(record%residual) == [3, n]) .and. &
                      all(shape(record%partials) == [3, 3, n]) .and. &
                      all(shape(record%angular_acceleration) == [3, n]) .and. &
                      all(shape(record%covariance) == size(record%names)), name)) return
            call check(error, all(record%names(:3) == [character(12) :: 'd_x', 'd_y', 'd_z']), name)
            call check(error, maxval(abs(norm2(record%residual, 2)/sqrt(real(n, dp))/solution%residual_rms - 1)), &
                       0.0_dp, name, thr=1e-10_dp)
            call check(error, maxval(abs(record%covariance(:3, :3) - solution%covariance)), 0.0_dp, name, &
                       thr=1e-12_dp*maxval(abs(solution%covariance)))
            call check(error, maxval(abs(sum(record%covariance_by_source, 3) - solution%covariance)), 0.0_dp, &
                       name, thr=1e-10_dp*maxval(abs(solution%covariance)))
            call check(error, record%torque_checked .and. abs(record%torque_factor - 1) < &
                       4*record%torque_sigma, name)
            call check_shares(diagnostics, name, error)
        end do
    end subroutine test_record

    !> Shares add up to 1, no sigma is below the bound, and an offset is not felt along its own axis but
    !> by the centrifugal term.
    subroutine check_shares(diagnostics, name, error)
        type(fit_diagnostics_t), intent(in) :: diagnostics
        character(*), intent(in) :: name
        type(error_type), allocatable, intent(inout) :: error
        integer :: i

        call check(error, maxval(abs(sum(diagnostics%source_share, 2) - 1)), 0.0_dp, name, thr=1e-10_dp)
        call check(error, maxval(abs(sum(diagnostics%information_share, 2) - 1)), 0.0_dp, name, thr=1e-12_dp)
        call check(error, all(diagnostics%information_share >= 0) .and. &
                   all([(diagnostics%information_share(i, i), i=1, 3)] < 0.01_dp), name)
        call check(error, diagnostics%bound_known .and. all(diagnostics%sigma > 0.999_dp*diagnostics%bound), name)
        call check(error, all(abs(diagnostics%parameter_correlation) < 1), name)
    end subroutine check_shares

    !> Residuals drawn from the setup's own noise: size, whiteness and spectrum as by chance.
    subroutine test_known_noise(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 600, RUNS = 20
        type(coloured_noise_t) :: noise
        type(random_stream_t) :: stream
        type(whitener_t) :: whitener
        type(error_t), allocatable :: failure
        type(residual_diagnosis_t) :: found
        real(dp) :: x(N), ratios(RUNS), probabilities(RUNS), power
        integer :: run, i

        noise = coloured_noise(noise_spectrum_t(1e-18_dp, 0.1_dp, TWO_SIDED), H, failure)
        call new_whitener(noise, [(i, i=1, N)], whitener, failure)
        if (failed(error, failure)) return
        power = 0
        do run = 1, RUNS
            stream = new_stream(7, 1, 1, run, 1)
            call noise%restart()
            call noise%generate(stream, x)
            x = x - sum(x)/N
            found = diagnose_residuals([(i, i=1, N)], H, x, noise, whitener)
            ratios(run) = found%ratio
            probabilities(run) = found%probability
            power = power + found%rms**2/RUNS
        end do
        ! the constant that is taken out leaves N - 1 degrees of freedom, of which N - 3 are counted
        call check(error, maxval(abs(ratios - 1)) < Z_999*1.1_dp*found%ratio_sigma .and. &
                   abs(sum(ratios)/RUNS - 1) < Z_999*found%ratio_sigma/sqrt(real(RUNS, dp)) + 2.0_dp/N, 'ratio')
        call check(error, minval(probabilities) > 1e-4_dp .and. abs(sum(probabilities)/RUNS - 0.5_dp) < &
                   Z_999/sqrt(12.0_dp*RUNS), 'probabilities are not uniform')
        call check(error, sqrt(power)/found%expected_rms, 1.0_dp, 'expected RMS', thr=0.05_dp)
    end subroutine test_known_noise

    !> Twice the noise, a colour that the setup does not have, and a line of 12 s.
    subroutine test_other_noise(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: N = 600
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(fit_record_t) :: record
        type(fit_diagnostics_t) :: d
        type(error_t), allocatable :: failure
        real(dp) :: ratio
        integer :: k

        call simulate('front-3', .true., observations)
        if (.not. allocated(error)) &
            call estimate_offset('assest-rde', observations, estimation_options_t(), solution, failure, &
                                 record=record)
        if (.not. allocated(failure)) call diagnose(observations%knowledge, solution, record, d, failure)
        if (failed(error, failure)) return
        ! in x the drag bends a little, which its whiteness tells
        call check(error, .not. any(d%residuals%peak_counts) .and. all(d%residuals(2:)%probability > 1e-3_dp) .and. &
                   all(abs(d%residuals%ratio - 1) < 4*d%residuals%ratio_sigma), 'noise alone')
        ratio = d%residuals(3)%ratio

        record%residual(3, :) = 2*record%residual(3, :)
        record%residual(2, :) = (record%residual(2, :) + eoshift(record%residual(2, :), 1))/sqrt(2.0_dp)
        record%residual(1, :) = record%residual(1, :) + 3e-10_dp*[(sin(TWO_PI*k*H/12), k=1, N)]
        call diagnose(observations%knowledge, solution, record, d, failure)
        if (failed(error, failure)) return
        call check(error, d%residuals(3)%ratio, 2*ratio, thr=1e-10_dp)
        call check(error, d%residuals(2)%autocorrelation(1), 0.5_dp, thr=0.15_dp)
        call check(error, d%residuals(2)%probability < 1e-6_dp)
        call check(error, d%residuals(1)%peak_counts .and. abs(d%residuals(1)%peak_frequency - 1/12.0_dp) < 1e-12_dp)
        ! the line's peak over the level: 2/3 of A^2 T/4
        call check(error, d%residuals(1)%peak_ratio, 2/3.0_dp*(3e-10_dp)**2*60/4/1.06e-20_dp, 'peak', &
                   thr=25.0_dp)
    end subroutine test_other_noise

    !> A setup without noise levels: no comparison, but information as with white noise of the residuals'
    !> size.
    subroutine test_unknown_noise(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(fit_record_t) :: record
        type(fit_diagnostics_t) :: d
        type(verdict_t) :: verdict
        type(error_t), allocatable :: failure

        call simulate('front-3', .true., observations)
        observations%knowledge%accelerometer_noise%level = 0
        observations%knowledge%star_camera_sigma = 0
        call estimate_offset('ascrest', observations, estimation_options_t(), solution, failure, record=record)
        if (.not. allocated(failure)) call diagnose(observations%knowledge, solution, record, d, failure)
        if (failed(error, failure)) return
        call check(error, .not. any(d%residuals%noise_known) .and. d%bound_known .and. all(d%bound > 5e-6_dp) .and. &
                   all(d%bound < 5e-5_dp), 'bound')
        call check(error, maxval(abs(sum(d%information_share, 2) - 1)), 0.0_dp, thr=1e-12_dp)
        verdict = judge(observations%knowledge, solution, record, d)
        call check(error, verdict%grade, GRADE_DOUBTFUL)
        call says(error, verdict, 'Accuracy', 'not known')
        call advises(error, verdict%action, DO_NOT_USE, 0, 7, 'the accuracy is not known')
        call says(error, verdict, 'Residuals x', 'gives no noise_level')
        call says(error, verdict, 'Noise of the star camera', 'noise_about_axes')
    end subroutine test_unknown_noise

    !> A finding on the subject must have the words.
    subroutine says(error, verdict, subject, words)
        type(error_type), allocatable, intent(inout) :: error
        type(verdict_t), intent(in) :: verdict
        character(*), intent(in) :: subject, words
        integer :: i

        do i = 1, size(verdict%findings)
            if (verdict%findings(i)%subject /= subject) cycle
            if (index(verdict%findings(i)%text, words) > 0) return
            call test_failed(error, '"'//words//'" is not in: '//verdict%findings(i)%text)
            return
        end do
        call test_failed(error, 'nothing is said of '//subject)
    end subroutine says

    !> The action, the axes of a trim and those of another calibration as numbers, xyz in binary, and words of its reason.
    subroutine advises(error, action, kind, trimmed, again, words)
        type(error_type), allocatable, intent(inout) :: error
        type(action_t), intent(in) :: action
        integer, intent(in) :: kind, trimmed, again
        character(*), intent(in) :: words

        call check(error, action%kind, kind, action%text)
        if (.not. allocated(error)) call check(error, sum(pack([4, 2, 1], action%trimmed)), trimmed, action%text)
        if (.not. allocated(error)) call check(error, sum(pack([4, 2, 1], action%again)), again, action%text)
        if (.not. allocated(error)) call check(error, index(action%text, words) > 0, action%text)
    end subroutine advises

    logical function judgement_fails(name, quiet, tested, verdict, solution, error)
        character(*), intent(in) :: name
        logical, intent(in) :: quiet
        logical, intent(in) :: tested       !! No belief is left untested: whatever it does is not too much
        type(verdict_t), intent(out) :: verdict
        type(solution_t), intent(out) :: solution
        type(error_type), allocatable, intent(inout) :: error
        type(observation_set_t) :: observations
        type(fit_record_t) :: record
        type(fit_diagnostics_t) :: diagnostics
        type(estimation_options_t) :: options
        type(error_t), allocatable :: failure

        call simulate(name, quiet, observations)
        observations%knowledge%a_priori%signs_known = tested
        if (tested) options%wanted_accuracy = 1
        call estimate_offset('assest-fde', observations, options, solution, failure, record=record)
        if (.not. allocated(failure)) call diagnose(observations%knowledge, solution, record, diagnostics, failure)
        call check_passes(error, failure)
        if (.not. allocated(error)) verdict = judge(observations%knowledge, solution, record, diagnostics)
        judgement_fails = allocated(error)
    end function judgement_fails

    !> Case 3 without the density wave: all good, and trim by the estimate, sign and all; but no trim while what a
    !> wrong belief could do unseen is more than is wanted, or nobody has confirmed the signs.
    subroutine test_good(error)
        type(error_type), allocatable, intent(out) :: error
        type(verdict_t) :: verdict
        type(solution_t) :: solution
        type(action_t) :: action

        if (judgement_fails('front-3', .true., .true., verdict, solution, error)) return
        call check(error, verdict%grade, GRADE_GOOD)
        call says(error, verdict, 'Torque', 'times (sigma')
        call advises(error, verdict%action, TRIM_IT, 7, 0, 'trim: move the centre of mass by +0.')
        call act_on(solution, 400.0_dp, action, torque_off=-0.1_dp)
        call check(error, all(action%sigma > 0.1_dp*abs(solution%offset) .and. action%sigma > verdict%action%sigma), &
                   'a torque that is off counts')
        solution%beliefs%signs_known = .false.
        call act_on(solution, 400.0_dp, action)
        call advises(error, action, CALIBRATE_AGAIN, 0, 7, 'say signs_known')
        solution%beliefs%signs_known = .true.
        solution%beliefs%wanted = 1e-6_dp
        call act_on(solution, 400.0_dp, action)
        call advises(error, action, CALIBRATE_AGAIN, 0, 7, 'unseen could be')
        deallocate (solution%beliefs)           ! the options left the tests out, or they failed
        call act_on(solution, 400.0_dp, action)
        call advises(error, action, NOT_TESTED, 0, 0, 'not tested: the options')
        call append(solution%warnings, FAILED_TESTS//'optimal: singular')
        call act_on(solution, 400.0_dp, action)
        call advises(error, action, DO_NOT_USE, 0, 7, 'do not use: '//FAILED_TESTS//'optimal: singular')
        if (judgement_fails('front-3', .true., .false., verdict, solution, error)) return
        call check(error, verdict%grade, GRADE_DOUBTFUL)
        call says(error, verdict, 'Contradicted', 'nothing')
        call says(error, verdict, 'Not testable here', 'sign of the accelerometer')
        call check(error, .not. any(verdict%action%trimmed), verdict%action%text)
    end subroutine test_good

    !> Case 2 hardly shows x; the density wave is in the residuals of x: 3.02 cycles in the arc.
    subroutine test_doubtful(error)
        type(error_type), allocatable, intent(out) :: error
        type(verdict_t) :: verdict
        type(solution_t) :: solution

        if (judgement_fails('front-2', .false., .true., verdict, solution, error)) return
        call check(error, verdict%grade, GRADE_DOUBTFUL)
        call says(error, verdict, 'Accuracy', 'x is not determined')
        call says(error, verdict, 'Residuals x', '0.05 Hz')
        call advises(error, verdict%action, TRIM_IT, 3, 4, 'calibrate again for x (sigma of x 1.')
    end subroutine test_doubtful

    !> No convergence, residuals far above the noise, or a contradiction: not to be used, whatever the sigmas say.
    subroutine test_bad(error)
        type(error_type), allocatable, intent(out) :: error
        type(observation_set_t) :: observations
        type(solution_t) :: solution
        type(fit_record_t) :: record
        type(fit_diagnostics_t) :: d
        type(verdict_t) :: verdict
        type(error_t), allocatable :: failure

        call simulate('front-3', .true., observations)
        if (.not. allocated(error)) &
            call estimate_offset('ascfest', observations, estimation_options_t(), solution, failure, record=record)
        if (.not. allocated(failure)) call diagnose(observations%knowledge, solution, record, d, failure)
        if (failed(error, failure)) return
        solution%converged = .false.
        verdict = judge(observations%knowledge, solution, record, d)
        call check(error, verdict%grade, GRADE_BAD)
        call says(error, verdict, 'Convergence', 'not converged')
        call advises(error, verdict%action, DO_NOT_USE, 0, 7, 'do not use: Convergence')
        solution%converged = .true.
        solution%variance_factor = 500      ! a filter that follows anything has residuals that look good
        verdict = judge(observations%knowledge, solution, record, d)
        call advises(error, verdict%action, DO_NOT_USE, 0, 7, 'do not use: Fit: its squares are 500 times')
        solution%variance_factor = 1
        d%residuals(2)%ratio = 21
        verdict = judge(observations%knowledge, solution, record, d)
        call says(error, verdict, 'Residuals y', 'wrong unit')
        call advises(error, verdict%action, DO_NOT_USE, 0, 7, 'wrong unit')
        solution%beliefs%values(2)%state = CONTRADICTED
        solution%beliefs%values(2)%fair = 9
        verdict = judge(observations%knowledge, solution, record, d)
        call advises(error, verdict%action, DO_NOT_USE, 0, 7, 'gain of rod ')
    end subroutine test_bad

    !> A component within three sigma of 0 is left, whatever the others need.
    subroutine test_leave(error)
        type(error_type), allocatable, intent(out) :: error
        type(action_t) :: action

        call decide(known_offset_t(value=[1e-5_dp, -4e-4_dp, 3e-4_dp], sigma=[1e-5_dp, 2e-5_dp, 3e-4_dp], signs_known=.true.), &
                    400.0_dp, action)
        call advises(error, action, TRIM_IT, 2, 1, '-0.4 mm along y (sigma 0.02 mm; mass moments -160 '// &
                     'kg mm), if the setup and its accelerometer signs hold')
        call advises(error, action, TRIM_IT, 2, 1, 'leave x (within 3 sigma of 0); calibrate again for z')
        call decide(known_offset_t(value=[1e-5_dp, -4e-5_dp, 3e-5_dp], sigma=spread(2e-5_dp, 1, 3)), 400.0_dp, action)
        call advises(error, action, LEAVE_IT, 0, 0, 'leave x, y and z')
        call decide(known_offset_t(value=[1e-5_dp, 4e-4_dp, 3e-5_dp], sigma=[2e-5_dp, 2e-4_dp, 2e-5_dp], signs_known=.true.), &
                    400.0_dp, action)
        call advises(error, action, CALIBRATE_AGAIN, 0, 2, 'leave x and z (within 3 sigma of 0); calibrate again for y')
        call decide(known_offset_t(value=[1e-4_dp, 4e-4_dp, 3e-4_dp], sigma=NAN, &
                                   signs_known=.true.), 400.0_dp, action)
        call advises(error, action, CALIBRATE_AGAIN, 0, 7, 'sigma of x NaN mm')
        ! Of a large offset what is unseen grows with it: nothing would ever be moved
        call decide(known_offset_t(value=[2e-3_dp, -2e-3_dp, 3e-4_dp], sigma=spread(1e-5_dp, 1, 3), signs_known=.true., &
                                   unseen=[1.9e-4_dp, 2.1e-4_dp, 4e-5_dp], tolerated=5e-5_dp), 400.0_dp, action)
        call advises(error, action, TRIM_IT, 5, 6, '; then calibrate again for x (unseen could be up to a tenth')
        ! What the data suggest comes first, the largest first, and once
        call decide(known_offset_t(value=[1e-4_dp, 4e-4_dp, 3e-4_dp], sigma=spread(1e-5_dp, 1, 3), signs_known=.true., &
                                   unseen=[6e-5_dp, 1.2e-4_dp, 1.5e-4_dp], tolerated=5e-5_dp, &
                                   hidden=[character(48) :: 'gain of rod x', 'inertia xx', 'inertia xx'], &
                                   suspicion=[character(120) :: '', 'the inertia xx is less', 'the inertia xx is less']), &
                    400.0_dp, action)
        call advises(error, action, CALIBRATE_AGAIN, 0, 7, 'calibrate again for x, y and z (check the setup: the inertia xx '// &
                     'is less by the data: 0.15 mm of y and z, unseen could be 0.06 mm of x by gain of rod x, wanted 0.05)')
    end subroutine test_leave
end module test_fit_diagnostics
