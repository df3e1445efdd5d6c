!> What a calibration tells of itself: where the information on the offset comes from, which noise its
!> error comes from, what it cannot be told apart from, and whether the residuals look like the noise
!> of the setup. All of it from the observations and the fit; nothing here knows the truth.
module gracecg_estimation_diagnostics
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: symmetric_eigen, solve_normal_equations
    use gracecg_base_spectrum, only: power_spectrum, band_means, HANN
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise
    use gracecg_estimation_noise_whitening, only: whitener_t, new_whitener
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_fit_record, only: fit_record_t, NOISE_SOURCES
    implicit none
    private
    public :: fit_diagnostics_t, residual_diagnosis_t, ellipsoid_t, diagnose
    public :: error_ellipsoid, information_by_axis, diagnose_residuals
    public :: WHITENESS_LAGS

    integer, parameter :: WHITENESS_LAGS = 20       !! Samples, of the test of Ljung and Box
    integer, parameter :: LONGEST_SEGMENT = 4096    !! Of the spectrum, samples
    real(dp), parameter :: BAND = 1/3.0_dp          !! Of the smoothed spectrum, octaves
    real(dp), parameter :: UNLIKELY = 1e-3_dp       !! Of a peak of the spectrum, for it to count
    integer, parameter :: FIRST_BIN = 3
    !! Of the spectrum, to be compared with the expected one: below it the straight line of the fit has
    !! taken the power (frequencies 0 and 1/T, and what the taper mixes into them)

    !> The error ellipsoid of one sigma.
    type :: ellipsoid_t
        real(dp) :: semi_axis(3) = 0            !! Longest first, m
        real(dp) :: direction(3, 3) = 0         !! Unit vectors as columns, body axes
    end type ellipsoid_t

    !> The residuals of one accelerometer axis.
    type :: residual_diagnosis_t
        real(dp) :: rms = 0                     !! m/s^2
        logical :: noise_known = .false.        !! The setup gives the noise; otherwise what follows is 0
        real(dp) :: expected_rms = 0
        !! Of the noise at the frequencies that the record shows, 1/T to half the sampling rate, m/s^2
        real(dp) :: ratio = 0
        !! RMS of the whitened residuals, degrees of freedom counted: 1 if the noise is that of the setup
        real(dp) :: ratio_sigma = 0             !! Standard deviation of `ratio` by chance
        real(dp) :: autocorrelation(WHITENESS_LAGS) = 0     !! Of the whitened residuals, lags 1, 2, ...
        real(dp) :: probability = 0
        !! That white noise has so large autocorrelations (G. M. Ljung, G. E. P. Box, Biometrika 65
        !! (1978) 297-303)
        real(dp) :: worst = 0                   !! Largest residual, m/s^2
        real(dp) :: worst_time = 0              !! s
        real(dp) :: peak_frequency = 0          !! Where the spectrum is farthest above the expected, Hz
        real(dp) :: peak_ratio = 0              !! The quotient there
        logical :: peak_counts = .false.        !! It is larger than chance makes one in a thousand records
    end type residual_diagnosis_t

    !> What one fit tells of itself.
    type :: fit_diagnostics_t
        real(dp) :: sigma(3) = 0                !! Of the offset, m
        logical :: sigma_known = .false.        !! The setup gives the noise of all accelerometer axes
        real(dp) :: correlation(3, 3) = 0    !! Of the components of the offset
        type(ellipsoid_t) :: ellipsoid    !! Of the offset's error
        real(dp) :: source_share(3, NOISE_SOURCES) = 0
        !! Of the variance of each component of the offset: (component, source); a row adds up to 1
        real(dp) :: information(3, 3, 3) = 0
        !! Of each accelerometer axis on the offset: (component, component, axis), 1/m^2
        real(dp) :: information_share(3, 3) = 0 !! (component, axis): a row adds up to 1
        logical :: bound_known = .false.        !! The information alone determines the offset
        real(dp) :: bound(3) = 0
        !! Sigma that the accelerometer allows if the rotation is known: root of the diagonal of the
        !! inverse of the information of all axes, m
        real(dp), allocatable :: parameter_correlation(:, :)
        !! Of the offset with the fit's other parameters: (component, parameter from number 4 on)
        type(residual_diagnosis_t) :: residuals(3)    !! Of accelerometer x, y, z
        real(dp), allocatable :: frequency(:)           !! Of the spectrum, Hz, from 0 on
        real(dp), allocatable :: density(:, :)          !! Two-sided, (axis, frequency), m^2 s^-4/Hz
        real(dp), allocatable :: expected_density(:, :) !! Of the setup's noise; 0 if it is not known
        real(dp), allocatable :: band_frequency(:), band_density(:, :)  !! Means over thirds of octaves
    end type fit_diagnostics_t

contains

    !> Everything about one fit. Fails when the covariance has no eigenvalues, or a noise level is out of
    !> its range.
    subroutine diagnose(knowledge, solution, record, diagnostics, error)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(solution_t), intent(in) :: solution
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(out) :: diagnostics
        type(error_t), allocatable, intent(out) :: error

        type(coloured_noise_t) :: noise(3)
        type(whitener_t) :: whitener(3)
        type(error_t), allocatable :: no_whitener
        logical :: known(3)
        integer :: axis

        if (.not. (allocated(record%residual) .and. allocated(record%covariance))) then
            call fail(error, 'the record is not that of a fit')
            return
        end if
        do axis = 1, 3
            noise(axis) = coloured_noise(knowledge%accelerometer_noise(axis), knowledge%accelerometer_interval, error)
            if (allocated(error)) return
            call new_whitener(noise(axis), record%epoch, whitener(axis), no_whitener)
            known(axis) = .not. allocated(no_whitener)
        end do
        diagnostics%sigma_known = all(known)
        call diagnose_covariance(solution%covariance, record, diagnostics, error)
        if (allocated(error)) return
        do axis = 1, 3
            call diagnose_spectrum(axis, record, noise(axis), known(axis), diagnostics)
            associate (diagnosis => diagnostics%residuals(axis), series => record%residual(axis, :), &
                       information => diagnostics%information(:, :, axis), partials => record%partials(axis, :, :))
                if (known(axis)) then
                    information = information_by_axis(record%epoch, partials, whitener(axis))
                    diagnosis = diagnose_residuals(record%epoch, record%interval, series, noise(axis), whitener(axis))
                    call find_peak(diagnostics%frequency, diagnostics%density(axis, :), &
                                   diagnostics%expected_density(axis, :), diagnosis)
                else        ! white noise as large as the residuals
                    information = information_by_axis(record%epoch, partials/max(solution%residual_rms(axis), tiny(1.0_dp)))
                    diagnosis = diagnose_residuals(record%epoch, record%interval, series, noise(axis))
                end if
            end associate
        end do
        call share_information(diagnostics)
    end subroutine diagnose

    !> Sigmas, ellipsoid, correlations and shares of the sources.
    subroutine diagnose_covariance(covariance, record, diagnostics, error)
        real(dp), intent(in) :: covariance(3, 3)        !! Of the offset, m^2
        type(fit_record_t), intent(in) :: record
        type(fit_diagnostics_t), intent(inout) :: diagnostics
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: correlation(size(record%names), size(record%names))
        integer :: i

        call error_ellipsoid(covariance, diagnostics%ellipsoid, error)
        if (allocated(error)) return
        diagnostics%sigma = [(sqrt(max(0.0_dp, covariance(i, i))), i=1, 3)]
        diagnostics%correlation = correlation_matrix(covariance)
        correlation = correlation_matrix(record%covariance)
        diagnostics%parameter_correlation = correlation(:3, 4:)
        do i = 1, 3
            if (covariance(i, i) > 0) diagnostics%source_share(i, :) = record%covariance_by_source(i, i, :)/covariance(i, i)
        end do
    end subroutine diagnose_covariance

    !> The axes' shares of the information, and the bound that all of it gives.
    subroutine share_information(diagnostics)
        type(fit_diagnostics_t), intent(inout) :: diagnostics

        type(error_t), allocatable :: no_bound
        real(dp) :: total(3, 3), covariance(3, 3), unused(3), condition
        integer :: i

        total = sum(diagnostics%information, 3)
        do i = 1, 3
            if (total(i, i) > 0) diagnostics%information_share(i, :) = diagnostics%information(i, i, :)/total(i, i)
        end do
        call solve_normal_equations(total, [0.0_dp, 0.0_dp, 0.0_dp], unused, covariance, condition, no_bound)
        diagnostics%bound_known = .not. allocated(no_bound)
        if (diagnostics%bound_known) diagnostics%bound = [(sqrt(covariance(i, i)), i=1, 3)]
    end subroutine share_information

    !> The spectrum of an axis' residuals beside that expected.
    subroutine diagnose_spectrum(axis, record, noise, known, diagnostics)
        integer, intent(in) :: axis
        type(fit_record_t), intent(in) :: record
        type(coloured_noise_t), intent(in) :: noise
        logical, intent(in) :: known                    !! The setup gives the noise
        type(fit_diagnostics_t), intent(inout) :: diagnostics

        real(dp), allocatable :: density(:), band_density(:)

        associate (d => diagnostics)
            call power_spectrum(record%epoch, record%residual(axis, :), record%interval, LONGEST_SEGMENT, HANN, d%frequency, &
                                density)
            call band_means(d%frequency, density, BAND, d%band_frequency, band_density)
            if (axis == 1) allocate (d%density(3, size(density)), d%expected_density(3, size(density)), &
                                     d%band_density(3, size(band_density)))
            d%density(axis, :) = density
            d%band_density(axis, :) = band_density
            d%expected_density(axis, :) = 0
            if (known) d%expected_density(axis, :) = noise%spectrum(d%frequency)
        end associate
    end subroutine diagnose_spectrum

    !> Semi-axes and directions of the error ellipsoid of one sigma: the roots of the eigenvalues of the
    !> covariance, and its eigenvectors, each with its largest component positive.
    subroutine error_ellipsoid(covariance, ellipsoid, error)
        real(dp), intent(in) :: covariance(3, 3)        !! m^2
        type(ellipsoid_t), intent(out) :: ellipsoid
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: values(3), vectors(3, 3)
        integer :: i

        call symmetric_eigen(covariance, values, vectors, error)
        if (allocated(error)) return
        do i = 1, 3
            associate (v => vectors(:, 4 - i))
                ellipsoid%semi_axis(i) = sqrt(max(0.0_dp, values(4 - i)))
                ellipsoid%direction(:, i) = v*sign(1.0_dp, v(maxloc(abs(v), 1)))
            end associate
        end do
    end subroutine error_ellipsoid

    !> Covariances over the standard deviations; 0 where a variance is 0, but 1 on the diagonal.
    pure function correlation_matrix(covariance) result(correlation)
        real(dp), intent(in) :: covariance(:, :)    !! (n, n), in any units
        real(dp) :: correlation(size(covariance, 1), size(covariance, 1))

        integer :: i, k

        do k = 1, size(covariance, 1)
            do i = 1, size(covariance, 1)
                correlation(i, k) = merge(1.0_dp, 0.0_dp, i == k)
                if (i /= k .and. covariance(i, i) > 0 .and. covariance(k, k) > 0) &
                    correlation(i, k) = covariance(i, k)/(sqrt(covariance(i, i))*sqrt(covariance(k, k)))
            end do
        end do
    end function correlation_matrix

    !> The information of one accelerometer axis on the offset when drift and bias of that axis are not
    !> known: H^T R^-1 H less what goes to the straight line L = [1, t],
    !> H^T R^-1 L (L^T R^-1 L)^-1 L^T R^-1 H, with R the covariance of the noise. The noise of the three
    !> axes is independent, so the sum over the axes is the information of the accelerometer.
    pure function information_by_axis(epoch, partials, whitener) result(information)
        integer, intent(in) :: epoch(:)                 !! Increasing index of each sample
        real(dp), intent(in) :: partials(:, :)          !! da/dd of the axis, (3, samples), 1/s^2
        type(whitener_t), intent(in), optional :: whitener
        !! Of the axis; without it the partials are taken over a white noise
        real(dp) :: information(3, 3)                   !! 1/m^2

        real(dp) :: rows(3, size(epoch)), line(2, size(epoch)), on_line(2, 3)

        rows = partials
        if (present(whitener)) then
            call whitener%whiten(rows)
            line = whitener%line
        else
            line(1, :) = 1/sqrt(real(size(epoch), dp))
            line(2, :) = epoch - sum(real(epoch, dp))/size(epoch)
            line(2, :) = line(2, :)/max(norm2(line(2, :)), tiny(1.0_dp))
        end if
        on_line = matmul(line, transpose(rows))
        information = matmul(rows, transpose(rows)) - matmul(transpose(on_line), on_line)
    end function information_by_axis

    !> Size and whiteness of the residuals of one axis. They are first whitened with the noise of the
    !> setup; three parameters count for each axis (drift, bias, a third of the offset).
    pure function diagnose_residuals(epoch, interval, residuals, noise, whitener) result(diagnosis)
        integer, intent(in) :: epoch(:)             !! Increasing index of each sample
        real(dp), intent(in) :: interval            !! s
        real(dp), intent(in) :: residuals(:)        !! m/s^2
        type(coloured_noise_t), intent(in) :: noise
        type(whitener_t), intent(in), optional :: whitener  !! Of `noise`; absent: noise not known
        type(residual_diagnosis_t) :: diagnosis

        integer, parameter :: PARAMETERS = 3
        real(dp) :: white(size(residuals)), freedom
        integer :: n, worst, k

        n = size(residuals)
        diagnosis%rms = norm2(residuals)/sqrt(real(n, dp))
        worst = maxloc(abs(residuals), 1)
        diagnosis%worst = residuals(worst)
        diagnosis%worst_time = epoch(worst)*interval
        diagnosis%noise_known = present(whitener)
        if (.not. present(whitener) .or. n <= PARAMETERS) return
        associate (span => epoch(n) - epoch(1) + 1)     ! both sides of the spectrum, without frequency 0
            diagnosis%expected_rms = sqrt(sum([(noise%spectrum(min(k, span - k)/(span*interval)), &
                                                k=1, span - 1)])/(span*interval))
        end associate
        white = residuals
        call whitener%whiten_series(white)
        freedom = n - PARAMETERS
        diagnosis%ratio = norm2(white)/sqrt(freedom)
        diagnosis%ratio_sigma = 1/sqrt(2*freedom)
        call test_whiteness(white, diagnosis%autocorrelation, diagnosis%probability)
    end function diagnose_residuals

    !> Autocorrelations, and the probability that those of white noise are as large: Ljung and Box, with
    !> the chi-square distribution by E. B. Wilson, M. M. Hilferty, Proc. Nat. Acad. Sci. 17 (1931)
    !> 684-688.
    pure subroutine test_whiteness(x, autocorrelation, probability)
        real(dp), intent(in) :: x(:)
        real(dp), intent(out) :: autocorrelation(:)
        real(dp), intent(out) :: probability

        real(dp) :: centred(size(x)), statistic, spread_of
        integer :: lag, n, lags

        n = size(x)
        centred = x - sum(x)/n
        autocorrelation = 0
        probability = 1
        lags = min(size(autocorrelation), n - 1)
        if (lags < 1 .or. .not. any(abs(centred) > 0)) return
        do lag = 1, lags
            autocorrelation(lag) = dot_product(centred(:n - lag), centred(lag + 1:))/ &
                                   dot_product(centred, centred)
        end do
        statistic = n*(n + 2.0_dp)*sum(autocorrelation(:lags)**2/[(n - lag, lag=1, lags)])
        spread_of = 2/(9.0_dp*lags)
        probability = erfc(((statistic/lags)**(1/3.0_dp) - (1 - spread_of))/sqrt(2*spread_of))/2
    end subroutine test_whiteness

    !> Where a spectrum is farthest above the expected one. A periodogram of the expected noise is, over
    !> its expectation, distributed as exp(-x): of K frequencies the largest exceeds x with a
    !> probability of about K exp(-x).
    pure subroutine find_peak(frequency, density, expected, diagnosis)
        real(dp), intent(in) :: frequency(:), density(:), expected(:)
        type(residual_diagnosis_t), intent(inout) :: diagnosis

        integer :: peak, bins

        bins = size(frequency) - FIRST_BIN + 1
        if (bins < 1) return
        peak = FIRST_BIN - 1 + maxloc(density(FIRST_BIN:)/expected(FIRST_BIN:), 1)
        diagnosis%peak_frequency = frequency(peak)
        diagnosis%peak_ratio = density(peak)/expected(peak)
        diagnosis%peak_counts = diagnosis%peak_ratio > log(bins/UNLIKELY)
    end subroutine find_peak
end module gracecg_estimation_diagnostics
