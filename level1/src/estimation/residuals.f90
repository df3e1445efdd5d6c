!> What an estimate from Level-1 data leaves of the accelerations: over time, and its spectrum.
module gracecg_level1_residuals
    use gracecg_base_kinds, only: dp
    use gracecg_base_spectrum, only: power_spectrum, band_means, HANN
    use gracecg_level1_outcome, only: level1_estimate_t
    implicit none
    private
    public :: residual_spectrum_t, fitted_samples, find_spectrum

    type :: residual_spectrum_t
        !! Mean of the arcs, one-sided amplitude spectral densities
        real(dp), allocatable :: frequency(:)       !! Hz, from 0 on
        real(dp), allocatable :: density(:, :)      !! Axis, frequency, m/s^2/sqrt(Hz)
        real(dp), allocatable :: band_frequency(:)  !! Hz, of means over thirds of octaves
        real(dp), allocatable :: band_density(:, :) !! Axis, band, m/s^2/sqrt(Hz)
    end type residual_spectrum_t

contains

    !> Samples of an arc that the fit kept: their times, observed without bias and drift, and residuals.
    pure subroutine fitted_samples(estimate, arc, time, observed, residual)
        type(level1_estimate_t), intent(in) :: estimate
        integer, intent(in) :: arc                              !! Its number
        real(dp), allocatable, intent(out) :: time(:)           !! s from the begin of the arc
        real(dp), allocatable, intent(out) :: observed(:, :)    !! (3, n), m/s^2
        real(dp), allocatable, intent(out) :: residual(:, :)    !! Likewise

        integer, allocatable :: place(:), kept(:)
        integer :: axis, k

        associate (set => estimate%arcs(arc), left => estimate%residuals(arc))
            place = nint(set%accelerometer_time/set%knowledge%accelerometer_interval) + 1
            kept = pack([(k, k=1, size(place))], left%kept(place))
            time = set%accelerometer_time(kept)
            observed = set%acceleration(:, kept)
            residual = left%linear(:, place(kept))
        end associate
        associate (t => time - sum(time)/size(time))
            do axis = 1, 3
                observed(axis, :) = observed(axis, :) - sum(observed(axis, :))/size(time)
                observed(axis, :) = observed(axis, :) - dot_product(observed(axis, :), t)/max(sum(t**2), tiny(1.0_dp))*t
            end do
        end associate
    end subroutine fitted_samples

    !> The spectrum of the residuals of all arcs, in segments as long as the shortest.
    subroutine find_spectrum(estimate, spectrum)
        type(level1_estimate_t), intent(in) :: estimate
        type(residual_spectrum_t), intent(out) :: spectrum

        real(dp), parameter :: BAND = 1/3.0_dp      ! Octaves
        real(dp), allocatable :: time(:), observed(:, :), residual(:, :), density(:), means(:), power(:, :)
        integer :: i, axis, longest

        longest = huge(longest)
        do i = 1, size(estimate%arcs)       ! samples at an end may be left out
            call fitted_samples(estimate, i, time, observed, residual)
            longest = min(longest, nint((time(size(time)) - time(1))/estimate%arcs(i)%knowledge%accelerometer_interval) + 1)
        end do
        do i = 1, size(estimate%arcs)
            call fitted_samples(estimate, i, time, observed, residual)
            associate (interval => estimate%arcs(i)%knowledge%accelerometer_interval)
                do axis = 1, 3
                    call power_spectrum(nint((time - time(1))/interval), residual(axis, :), interval, longest, HANN, &
                                        spectrum%frequency, density)
                    if (.not. allocated(power)) allocate (power(3, size(density)), source=0.0_dp)
                    power(axis, :) = power(axis, :) + 2*density/size(estimate%arcs)
                end do
            end associate
        end do
        do axis = 1, 3
            call band_means(spectrum%frequency, power(axis, :), BAND, spectrum%band_frequency, means)
            if (.not. allocated(spectrum%band_density)) allocate (spectrum%band_density(3, size(means)))
            spectrum%band_density(axis, :) = sqrt(means)
        end do
        spectrum%density = sqrt(power)
    end subroutine find_spectrum
end module gracecg_level1_residuals
