!> What an estimate from Level-1 data leaves of the accelerations: over time, and its spectrum.
module gracecg_level1_residuals
    use gracecg_base_kinds, only: dp
    use gracecg_base_spectrum, only: power_spectrum, band_means, HANN
    use gracecg_base_statistics, only: median_of
    use gracecg_level1_angular, only: level1_motion_t, NUISANCE_DEGREE
    use gracecg_level1_basis, only: remove_space, polynomial_basis
    use gracecg_level1_calibration, only: level1_calibration_t, level1_span_t
    use gracecg_level1_offset, only: modelled_acceleration
    use gracecg_level1_offset_solution, only: level1_solution_t
    implicit none
    private
    public :: span_residuals_t, residual_spectrum_t, find_residuals, find_spectrum

    type :: span_residuals_t
        !! One span: accelerations in SRF, axis and sample, m/s^2
        real(dp), allocatable :: time(:)            !! From the begin of the span, s
        real(dp), allocatable :: observed(:, :)     !! Without bias and drift (a parabola)
        real(dp), allocatable :: residual(:, :)     !! Of it less the model, without a parabola
        real(dp), allocatable :: observed_band(:, :)    !! In the band of the estimate
        real(dp), allocatable :: modelled_band(:, :)    !! The model there
    end type span_residuals_t

    type :: residual_spectrum_t
        !! Mean of the spans, one-sided amplitude spectral densities
        real(dp), allocatable :: frequency(:)       !! Hz, from 0 on
        real(dp), allocatable :: density(:, :)      !! Axis, frequency, m/s^2/sqrt(Hz)
        real(dp), allocatable :: band_frequency(:)  !! Hz, of means over thirds of octaves
        real(dp), allocatable :: band_density(:, :) !! Axis, band, m/s^2/sqrt(Hz)
    end type residual_spectrum_t

contains

    !> Observed and modelled accelerations of a span that is used.
    subroutine find_residuals(span, motion, solution, number, residuals)
        type(level1_span_t), intent(in) :: span
        type(level1_motion_t), intent(in) :: motion     !! Of the span
        type(level1_solution_t), intent(in) :: solution
        integer, intent(in) :: number                   !! Of the span in the calibration
        type(span_residuals_t), intent(out) :: residuals

        real(dp), allocatable :: parabola(:, :), modelled(:, :)
        integer :: axis

        call polynomial_basis(span%time, NUISANCE_DEGREE, parabola)
        call modelled_acceleration(motion, solution%series(number), solution, modelled)
        residuals%time = span%time - span%start
        residuals%observed = span%linear
        residuals%residual = span%linear - modelled
        do axis = 1, 3
            call remove_space(parabola, residuals%observed(axis, :))
            call remove_space(parabola, residuals%residual(axis, :))
        end do
        residuals%observed_band = matmul(matmul(span%linear, motion%band), transpose(motion%band))
        residuals%modelled_band = matmul(matmul(modelled, motion%band), transpose(motion%band))
    end subroutine find_residuals

    !> The spectrum of the residuals of all spans that are used, in segments as long as the shortest.
    subroutine find_spectrum(calibration, motion, solution, spectrum)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_motion_t), intent(in) :: motion(:)      !! Of each span
        type(level1_solution_t), intent(in) :: solution
        type(residual_spectrum_t), intent(out) :: spectrum

        real(dp), parameter :: BAND = 1/3.0_dp      ! Octaves
        type(span_residuals_t) :: residuals
        real(dp), allocatable :: density(:), means(:), power(:, :)
        real(dp) :: interval
        integer :: i, axis, longest

        longest = huge(longest)
        interval = 0
        do i = 1, size(calibration%spans)
            if (.not. calibration%spans(i)%used) cycle
            associate (t => calibration%spans(i)%time)
                if (.not. interval > 0) interval = median_of(t(2:) - t(:size(t) - 1))
                longest = min(longest, nint((t(size(t)) - t(1))/interval) + 1)
            end associate
        end do
        do i = 1, size(calibration%spans)
            if (.not. calibration%spans(i)%used) cycle
            call find_residuals(calibration%spans(i), motion(i), solution, i, residuals)
            do axis = 1, 3
                call power_spectrum(nint((residuals%time - residuals%time(1))/interval), residuals%residual(axis, :), interval, &
                                    longest, HANN, spectrum%frequency, density)
                if (.not. allocated(power)) allocate (power(3, size(density)), source=0.0_dp)
                power(axis, :) = power(axis, :) + 2*density/count(calibration%spans%used)
            end do
        end do
        do axis = 1, 3
            call band_means(spectrum%frequency, power(axis, :), BAND, spectrum%band_frequency, means)
            if (.not. allocated(spectrum%band_density)) allocate (spectrum%band_density(3, size(means)))
            spectrum%band_density(axis, :) = sqrt(means)
        end do
        spectrum%density = sqrt(power)
    end subroutine find_spectrum
end module gracecg_level1_residuals
