!> Noise levels from the data: restricted maximum likelihood (H. D. Patterson, R. Thompson,
!> Biometrika 58 (1971) 545-554), which allows for the parameters that the fit takes from the data.
!>
!> Star camera: the variance about each of its axes is the sum of squared residuals over their
!> redundancy, iterated: W. Foerstner's form of Helmert's estimator (Allgemeine
!> Vermessungs-Nachrichten 86 (1979) 446-453), whose fixed point is the same maximum (K.-R. Koch,
!> Parameter Estimation and Hypothesis Testing in Linear Models, 2nd ed., 1999, section 3.6).
!> Accelerometer: level and corner frequency of each axis. The level that maximises the likelihood for
!> a corner is known in closed form; the corner is searched for.
module gracecg_estimation_variance_components
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, noise_spectrum_t
    use gracecg_estimation_noise_whitening, only: whitener_t, new_whitener
    implicit none
    private
    public :: estimate_spectrum, estimate_variance

    real(dp), parameter :: LOWEST_CORNER = 1e-3_dp      !! Of the sampling frequency's half
    integer, parameter :: GRID = 8                      !! Intervals of the first search
    integer, parameter :: REFINEMENTS = 14              !! Of the golden section
    real(dp), parameter :: GOLDEN = (sqrt(5.0_dp) - 1)/2
    real(dp), parameter :: DEPENDENT = 1e-5_dp
    !! A regressor whose part across the others is smaller, relative, is left out

contains

    !> Level and corner frequency of the noise in a series that is known up to a linear combination of
    !> regressors. The corner lies between a thousandth of half the sampling frequency (where a short
    !> arc cannot tell it from 0, and it is returned as 0) and half the sampling frequency.
    !>
    !> Fails when too few samples are kept.
    subroutine estimate_spectrum(interval, sides, epoch, kept, series, regressors, spectrum, error)
        real(dp), intent(in) :: interval            !! Of the epochs, s
        integer, intent(in) :: sides                !! Of the spectrum
        integer, intent(in) :: epoch(:)    !! k of each sample
        logical, intent(in) :: kept(:)    !! (samples)
        real(dp), intent(in) :: series(:)           !! Residuals, (samples)
        real(dp), intent(in) :: regressors(:, :)    !! (regressors, samples)
        type(noise_spectrum_t), intent(out) :: spectrum     !! Unit of the series squared per Hz
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: width, low, high, inner(2), value(2), best_value, grid_value(0:GRID)
        integer :: i, best

        high = log(0.5_dp/interval)
        low = high + log(LOWEST_CORNER)
        width = (high - low)/GRID
        spectrum%sides = sides
        do i = 0, GRID
            call evaluate(exp(low + i*width), grid_value(i))
            if (allocated(error)) return
        end do
        best = minloc(grid_value, 1) - 1
        high = min(high, low + (best + 1)*width)
        low = max(low, low + (best - 1)*width)
        inner = [high - GOLDEN*(high - low), low + GOLDEN*(high - low)]
        call evaluate(exp(inner(1)), value(1))
        if (.not. allocated(error)) call evaluate(exp(inner(2)), value(2))
        do i = 1, REFINEMENTS
            if (allocated(error)) return
            if (value(1) < value(2)) then
                high = inner(2)
                inner = [high - GOLDEN*(high - low), inner(1)]
                value(2) = value(1)
                call evaluate(exp(inner(1)), value(1))
            else
                low = inner(1)
                inner = [inner(2), low + GOLDEN*(high - low)]
                value(1) = value(2)
                call evaluate(exp(inner(2)), value(2))
            end if
        end do
        spectrum%corner = exp((low + high)/2)
        call evaluate(spectrum%corner, best_value)
        if (allocated(error)) return
        call evaluate(0.0_dp, value(1))         ! white noise, when it is as likely
        if (value(1) <= best_value .or. best == 0) then
            spectrum%corner = 0
        else
            call evaluate(spectrum%corner, best_value)
        end if

    contains

        !> Minus twice the restricted log-likelihood at a corner, the level at its maximum.
        subroutine evaluate(at, minus_twice)
            real(dp), intent(in) :: at          !! Hz
            real(dp), intent(out) :: minus_twice

            type(coloured_noise_t) :: noise
            type(whitener_t) :: whitener
            real(dp) :: rows(size(regressors, 1), size(series)), left(size(series)), log_normal
            integer :: rank

            minus_twice = huge(1.0_dp)
            noise = coloured_noise(noise_spectrum_t(1.0_dp, at, sides), interval, error)
            if (.not. allocated(error)) call new_whitener(noise, epoch, whitener, error, kept)
            if (allocated(error)) return
            rows = regressors
            left = series
            call whitener%whiten(rows)
            call whitener%whiten_series(left)
            call project_off(rows, left, rank, log_normal)
            spectrum%level = sum(left**2)/max(1, whitener%kept - rank)
            minus_twice = (whitener%kept - rank)*log(max(spectrum%level, tiny(1.0_dp))) + whitener%log_determinant + &
                          log_normal
        end subroutine evaluate
    end subroutine estimate_spectrum

    !> Removes from a series what the rows explain (modified Gram-Schmidt); ln det of their normal matrix.
    pure subroutine project_off(rows, series, rank, log_normal)
        real(dp), intent(inout) :: rows(:, :)       !! (rows, samples); on return orthonormal or unused
        real(dp), intent(inout) :: series(:)
        integer, intent(out) :: rank
        real(dp), intent(out) :: log_normal

        real(dp) :: before, length
        integer :: i, j

        rank = 0
        log_normal = 0
        do i = 1, size(rows, 1)
            before = norm2(rows(i, :))
            if (.not. before > 0) cycle
            do j = 1, i - 1
                rows(i, :) = rows(i, :) - dot_product(rows(j, :), rows(i, :))*rows(j, :)
            end do
            length = norm2(rows(i, :))
            if (length < DEPENDENT*before) then
                rows(i, :) = 0
                cycle
            end if
            rank = rank + 1
            log_normal = log_normal + 2*log(length)
            rows(i, :) = rows(i, :)/length
            series = series - dot_product(rows(i, :), series)*rows(i, :)
        end do
    end subroutine project_off

    !> The factor of an assumed variance: squared residuals in units of it over their redundancy,
    !> which is their number less the sum of h^T C h, h the partials and C the estimate's covariance.
    pure real(dp) function estimate_variance(residuals, partials, covariance) result(factor)
        real(dp), intent(in) :: residuals(:)        !! In units of the assumed sigma
        real(dp), intent(in) :: partials(:, :)      !! Parameters x residuals, in the same units
        real(dp), intent(in) :: covariance(:, :)    !! Of all parameters: (parameters, parameters)

        real(dp) :: redundancy
        integer :: i

        redundancy = size(residuals)
        do i = 1, size(residuals)
            redundancy = redundancy - dot_product(partials(:, i), matmul(covariance, partials(:, i)))
        end do
        factor = sum(residuals**2)/max(1.0_dp, redundancy)
    end function estimate_variance
end module gracecg_estimation_variance_components
