!> What follows from an offset by Level-1 files: residuals and their spectrum, steps of the trim masses, the trend.
module test_level1_results
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI, MICROMETRE, JULIAN_YEAR
    use gracecg_base_error, only: error_t, message_of
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_residuals, only: span_residuals_t, residual_spectrum_t, find_residuals, find_spectrum
    use gracecg_level1_results, only: trim_command_t, trim_commands
    use gracecg_level1_trend, only: trend_point_t, level1_trend_t, fit_trend, predicted_change
    use testdrive, only: unittest_type, error_type, new_unittest
    use fixture, only: check, check_fails, check_passes
    use level1_day, only: flaws_t, setup_said, estimate_day
    implicit none
    private
    public :: collect_level1_results

contains

    subroutine collect_level1_results(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('trim-steps', test_trim), &
                    new_unittest('residuals', test_residuals), &
                    new_unittest('trend', test_trend)]
    end subroutine collect_level1_results

    !> steps = nint(change/2.5 um M/4.8 kg), in commands of at most 12000.
    subroutine test_trim(error)
        type(error_type), allocatable, intent(out) :: error

        type(trim_command_t), allocatable :: commands(:)

        call trim_commands(setup_said(), [310e-6_dp, 0.0_dp, -25e-6_dp], commands)
        call check(error, size(commands), 3, 'commands')
        if (allocated(error)) return
        call check(error, all(commands%steps == [12000, 2983, -1208]), 'steps')
        call check(error, index(commands(3)%text, '1208 steps NEG') > 0, 'direction')
    end subroutine test_trim

    !> What is put into the samples is found in the residuals, and as much of it in their spectrum (Parseval).
    subroutine test_residuals(error)
        type(error_type), allocatable, intent(out) :: error

        real(dp), parameter :: SIZE_OF_LINE = 3e-9_dp, FREQUENCY = 0.8_dp       ! m/s^2, Hz: above the band
        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(span_residuals_t) :: residuals
        type(residual_spectrum_t) :: spectrum
        type(error_t), allocatable :: failure
        real(dp), allocatable :: line(:)
        real(dp) :: power
        integer :: i

        call estimate_day('l1_left', flaws_t(spans=2), setup_said(), calibration, estimate, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        do i = 1, 2
            associate (span => calibration%spans(i))
                line = SIZE_OF_LINE*sin(TWO_PI*FREQUENCY*(span%time - span%start))
                span%linear(2, :) = span%linear(2, :) + line
            end associate
        end do
        call find_residuals(calibration%spans(2), estimate%motion(2), estimate%solutions(1), 2, residuals)
        ! The parabola takes a little of the line at the ends.
        call check(error, maxval(abs(residuals%residual(2, :) - line)) < 0.06_dp*SIZE_OF_LINE .and. &
                   maxval(abs(residuals%residual(1, :))) < 0.02_dp*SIZE_OF_LINE, 'the line is left, on its axis')
        call check(error, maxval(abs(residuals%observed_band - residuals%modelled_band)) < 0.02_dp*SIZE_OF_LINE, &
                   'the band has nothing of it')
        call find_spectrum(calibration, estimate%motion, estimate%solutions(1), spectrum)
        i = maxloc(spectrum%density(2, :), 1)
        call check(error, abs(spectrum%frequency(i) - FREQUENCY) < 1.01_dp*spectrum%frequency(2), 'its frequency')
        power = sum(spectrum%density(2, :)**2)*spectrum%frequency(2)
        call check(error, power, SIZE_OF_LINE**2/2, thr=0.02_dp, rel=.true., message='its power')
    end subroutine test_residuals

    !> A line with a step is found again, and what the gas does.
    subroutine test_trend(error)
        type(error_type), allocatable, intent(out) :: error

        type(trend_point_t) :: points(6)
        type(level1_trend_t) :: trend
        type(error_t), allocatable :: failure
        real(dp), parameter :: RATE(3) = [12e-6_dp, -3e-6_dp, 0.0_dp], JUMP(3) = [-40e-6_dp, 5e-6_dp, 1e-6_dp]    ! m/a, m
        real(dp) :: at
        integer :: i

        do i = 1, size(points)
            points(i)%time = 6e8_dp + 0.5_dp*i*JULIAN_YEAR
            points(i)%sigma = [2, 1, 1]*MICROMETRE
            points(i)%offset = [30e-6_dp, 10e-6_dp, 0.0_dp] + RATE*0.5_dp*i
            if (i > 3) points(i)%offset = points(i)%offset + JUMP
        end do
        at = 6e8_dp + 1.75_dp*JULIAN_YEAR
        call fit_trend(points, [5e8_dp, at, at + 60, 9e8_dp], 100e-6_dp, trend, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        call check(error, size(trend%step_time), 1, 'steps that the dates see')
        if (allocated(error)) return
        call check(error, maxval(abs(trend%rate*JULIAN_YEAR - RATE)) < 1e-11_dp .and. &
                   maxval(abs(trend%step(:, 1) - JUMP)) < 1e-11_dp, 'rate and step')
        call check(error, maxval(trend%chi_square) < 1e-8_dp .and. trend%degrees == 3, 'chi square')
        call check(error, maxval(abs(trend%at(trend%passes))) > 100e-6_dp .and. &
                   maxval(abs(trend%at(trend%passes - 86400))) <= 100e-6_dp, &
                   'the date of 100 um')
        ! 1 g less in tank 1 at -0.6 m: the centre of mass moves by +1.03 um along x, d by -1.03 um
        call check(error, maxval(abs(predicted_change(setup_said(), [13.0_dp, 13.0_dp], [12.999_dp, 13.0_dp]) - &
                                     [-0.6e-3_dp/580, 0.0_dp, 0.0_dp])) < 1e-15_dp, 'by gas')
        call fit_trend(points(:1), [real(dp) ::], 100e-6_dp, trend, failure)
        call check_fails(error, message_of(failure), ['at least 2 dates'])
    end subroutine test_trend
end module test_level1_results
