!> What follows from an offset by Level-1 files: residuals and their spectrum, steps of the trim masses, the trend.
module test_level1_results
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI, MICROMETRE, JULIAN_YEAR
    use gracecg_base_error, only: error_t, message_of
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_outcome, only: level1_estimate_t
    use gracecg_level1_residuals, only: residual_spectrum_t, fitted_samples, find_spectrum
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

    !> Residuals of a noiseless day are small beside the signal, and their spectrum has their squares (Parseval).
    subroutine test_residuals(error)
        type(error_type), allocatable, intent(out) :: error

        type(level1_calibration_t) :: calibration
        type(level1_estimate_t) :: estimate
        type(residual_spectrum_t) :: spectrum
        type(error_t), allocatable :: failure
        real(dp), allocatable :: time(:), observed(:, :), residual(:, :)
        real(dp) :: power, squares
        integer :: i, k

        call estimate_day('l1_left', flaws_t(spans=2), setup_said(), calibration, estimate, failure)
        call check_passes(error, message_of(failure))
        if (allocated(error)) return
        do i = 1, 2
            estimate%residuals(i)%linear(2, :) = estimate%residuals(i)%linear(2, :) + &
                1e-9_dp*[(sin(TWO_PI*0.08_dp*k), k=1, size(estimate%residuals(i)%kept))]
        end do
        call fitted_samples(estimate, 2, time, observed, residual)
        call check(error, size(time) > 500 .and. maxval(abs(observed(2, :))) > 3e-9_dp .and. &
                   maxval(abs(residual(1, :))) < 0.1_dp*maxval(abs(observed(1, :))), 'the fit follows')
        estimate%residuals(1)%kept([1, 2]) = .false.    ! a span that is shorter by that
        call find_spectrum(estimate, spectrum)
        call check(error, size(spectrum%density, 2), size(spectrum%frequency))
        if (allocated(error)) return
        i = maxloc(spectrum%density(2, :), 1)
        call check(error, abs(spectrum%frequency(i) - 0.8_dp) < 1.01_dp*spectrum%frequency(2), 'a line that is left')
        power = sum(spectrum%density(2, :)**2)*spectrum%frequency(2)
        squares = sum(residual(2, :)**2)/size(time)
        call check(error, power, squares, thr=0.1_dp, rel=.true., message='its power')
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
        call fit_trend(points(:1), [5e8_dp], 100e-6_dp, trend, failure)
        call check_fails(error, message_of(failure), ['at least 2 dates'])
        if (allocated(error)) return
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
