!> Whitening of a series with coloured noise: multiplication by L^-1, where L L^T (Cholesky's factors)
!> is the covariance matrix of the noise. Least squares of whitened observations with unit weights is
!> the best linear unbiased estimate (A. C. Aitken, Proc. R. Soc. Edinburgh 55 (1936) 42-48).
!>
!> The noise (gracecg_base_coloured_noise) is a white sequence and a sum of first-order Gauss-Markov
!> sequences, so the innovations of its Kalman filter, divided by their standard deviations, are
!> exactly the elements of L^-1 v (T. Kailath, IEEE Trans. Automatic Control 13 (1968) 646-655; the
!> likelihood so computed: F. C. Schweppe, IEEE Trans. Information Theory 11 (1965) 61-70). The work
!> grows with the number of samples, not with its cube or square; gaps and samples that are left out
!> only stretch a step of the filter.
!>
!> `whitener_t` does so for these poles, whose transition is diagonal, with gains computed once for any
!> number of series; `process_filter_t` for white noise and any Gauss-Markov process.
module gracecg_estimation_noise_whitening
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t, fail, add_context, number_text
    use gracecg_base_text, only: integer_text
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, noise_spectrum_t, are_alike, N_POLES
    use gracecg_base_autoregression, only: autoregression_t, bridge_t, new_bridge
    use gracecg_base_gauss_markov, only: gauss_markov_t
    use gracecg_base_lanes, only: lanes_filter
    implicit none
    private
    public :: whitener_t, new_whitener, autoregressive_whitener, accelerometer_whiteners, weigh_series
    public :: row_state_t, ROW
    public :: process_filter_t, prepare_filter, nonzero_rows

    integer, parameter :: ROW = 4       !! Series whose next samples are whitened together

    !> The filter's gains for one series of epochs: computed once, used for any number of series.
    type :: whitener_t
        integer :: samples = 0                  !! Epochs, those of samples left out included
        integer :: kept = 0                     !! Samples that count
        real(dp) :: log_determinant = 0         !! ln of the determinant of their covariance matrix
        real(dp), allocatable :: line(:, :)
        !! The constant and the straight line over the epochs, whitened, as two orthonormal rows:
        !! (2, samples); what is orthogonal to them does not depend on a bias and a drift
        real(dp), allocatable, private :: gain(:, :)            !! (N_POLES, samples)
        real(dp), allocatable, private :: decay(:, :)           !! To the next epoch, (N_POLES, samples)
        real(dp), allocatable, private :: inverse_deviation(:)  !! Of the innovations
        logical, allocatable, private :: used(:)                !! False: left out
        type(bridge_t), allocatable :: bridge       !! Of noise of any spectrum, in place of the filter
    contains
        procedure :: whiten    !! Whitens several series in place
        procedure :: whiten_series    !! Whitens one series in place
        procedure :: step_row    !! Whitens the next samples of ROW series
        procedure :: innovations
        !! How far every sample is from what the kept samples before it let expect, in standard deviations
    end type whitener_t

    !> The filter for a process in white noise of variance 1 at given samples, with the three diagonals of the transition
    !> from every epoch to the next.
    type :: process_filter_t
        type(gauss_markov_t) :: process             !! Its transition matrix of blocks of one and two on the diagonal
        integer, allocatable :: epoch(:)            !! Of the samples, in intervals, increasing
        logical, allocatable :: kept(:)             !! (samples)
        real(dp), allocatable :: gain(:, :)         !! P h/F, (states, samples)
        real(dp), allocatable :: inverse_deviation(:)   !! Of the innovations, 1/sqrt F
        real(dp), allocatable :: below(:, :), on(:, :), above(:, :)
        !! Phi(j, j - 1), Phi(j, j), Phi(j, j + 1), (states, samples)
        logical, allocatable :: paired(:)           !! Of states: coupled to the next one
        real(dp) :: log_variance = 0                !! Sum of ln F of the samples kept
    contains
        procedure :: whiten => whiten_by_filter     !! Whitens several series in place
    end type process_filter_t

    !> Where the filter of ROW series has got to, for whitening sample by sample.
    type :: row_state_t
        private
        real(dp) :: predicted(ROW, N_POLES) = 0
    end type row_state_t

contains

    !> The whitener of samples at k h for k in `epoch`. Samples that are not kept are whitened to zero.
    !>
    !> Fails when the noise has no white part (a covariance matrix without it is singular), when the
    !> epochs do not increase, or when fewer than three samples are kept.
    subroutine new_whitener(noise, epoch, whitener, error, kept)
        type(coloured_noise_t), intent(in) :: noise
        integer, intent(in) :: epoch(:)             !! Increasing
        type(whitener_t), intent(out) :: whitener
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: kept(:)    !! All when absent

        real(dp) :: white_variance, correlation(N_POLES), variance(N_POLES)
        real(dp) :: covariance(N_POLES, N_POLES), innovation_variance
        integer :: i, p, n

        n = size(epoch)
        whitener%samples = n
        whitener%kept = n
        if (present(kept)) whitener%kept = count(kept)
        call noise%markov_form(white_variance, correlation, variance)
        if (.not. white_variance > 0) then
            call fail(error, 'the noise level is 0: give a positive level of the noise spectrum, '// &
                      'noise without a white part cannot be whitened')
        else if (any(epoch(2:) <= epoch(:n - 1))) then
            call fail(error, 'the epochs of samples to be whitened must increase')
        else if (whitener%kept < 3) then
            call fail(error, integer_text(whitener%kept)//' samples to be whitened are left, '// &
                      'at least 3 are needed')
        end if
        if (allocated(error)) return
        allocate (whitener%gain(N_POLES, n), whitener%decay(N_POLES, n), whitener%inverse_deviation(n))
        allocate (whitener%used(n), source=.true.)
        if (present(kept)) whitener%used = kept
        whitener%gain = 0
        covariance = 0
        do p = 1, N_POLES
            covariance(p, p) = variance(p)
        end do
        do i = 1, n
            innovation_variance = sum(covariance) + white_variance
            whitener%inverse_deviation(i) = 1/sqrt(innovation_variance)
            if (whitener%used(i)) then
                associate (gain => whitener%gain(:, i))
                    gain = sum(covariance, 2)/innovation_variance
                    do p = 1, N_POLES
                        covariance(:, p) = covariance(:, p) - gain*gain(p)*innovation_variance
                    end do
                end associate
                whitener%log_determinant = whitener%log_determinant + log(innovation_variance)
            end if
            if (i == n) exit
            associate (decay => whitener%decay(:, i))
                decay = correlation**(epoch(i + 1) - epoch(i))
                do p = 1, N_POLES
                    covariance(:, p) = decay*covariance(:, p)*decay(p)
                    covariance(p, p) = covariance(p, p) + variance(p)*(1 - decay(p)**2)
                end do
            end associate
        end do
        whitener%decay(:, n) = 0
        call orthonormal_line(epoch, whitener)
    end subroutine new_whitener

    !> The whitener of noise of any spectrum at epochs that follow one another: innovations of an autoregressive sequence,
    !> those of samples that are not kept with what the others let expect in their places.
    pure subroutine autoregressive_whitener(model, kept, whitener)
        type(autoregression_t), intent(in) :: model
        logical, intent(in) :: kept(:)              !! (samples)
        type(whitener_t), intent(out) :: whitener

        whitener%samples = size(kept)
        whitener%kept = count(kept)
        whitener%used = kept
        whitener%bridge = new_bridge(model, kept)
    end subroutine autoregressive_whitener

    !> The whiteners of the accelerometer's axes from their spectra. Fails, naming the axis, as new_whitener
    !> does and where a level is not positive.
    subroutine accelerometer_whiteners(spectra, interval, epoch, whiteners, error, kept)
        type(noise_spectrum_t), intent(in) :: spectra(3)    !! x, y, z, m^2 s^-4/Hz
        real(dp), intent(in) :: interval                !! Of the accelerometer, s
        integer, intent(in) :: epoch(:)                 !! In units of the interval
        type(whitener_t), intent(out) :: whiteners(3)
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: kept(:, :)     !! (3, samples)

        type(coloured_noise_t) :: noise
        logical :: counted(size(epoch))
        integer :: axis, other

        do axis = 1, 3
            counted = .true.
            if (present(kept)) counted = kept(axis, :)
            if (.not. spectra(axis)%level > 0) then
                call fail(error, 'the noise level, noise_level = '//number_text(spectra(axis)%level)// &
                          ' m^2 s^-4/Hz, has to be positive')
            else
                other = findloc([(are_alike(spectra(axis), spectra(other)) .and. all(counted .eqv. whiteners(other)%used), &
                                  other=1, axis - 1)], .true., 1)
                if (other > 0) then
                    whiteners(axis) = whiteners(other)      ! of noise of another level: the gains are the same
                    associate (mine => whiteners(axis), factor => spectra(axis)%level/spectra(other)%level)
                        mine%inverse_deviation = mine%inverse_deviation/sqrt(factor)
                        mine%log_determinant = mine%log_determinant + mine%kept*log(factor)
                    end associate
                    cycle
                end if
                noise = coloured_noise(spectra(axis), interval, error)
                if (.not. allocated(error)) call new_whitener(noise, epoch, whiteners(axis), error, counted)
            end if
            call add_context(error, 'accelerometer, axis '//AXES(axis))
            if (allocated(error)) return
        end do
    end subroutine accelerometer_whiteners

    !> Whitened bias and drift, made orthonormal (Gram-Schmidt, twice for the rounding).
    subroutine orthonormal_line(epoch, whitener)
        integer, intent(in) :: epoch(:)
        type(whitener_t), intent(inout) :: whitener

        real(dp) :: middle, half_length
        integer :: pass

        associate (n => whitener%samples)
            middle = (epoch(1) + epoch(n))/2.0_dp
            half_length = max(1.0_dp, (epoch(n) - epoch(1))/2.0_dp)
            allocate (whitener%line(2, n))
            whitener%line(1, :) = 1
            whitener%line(2, :) = (epoch - middle)/half_length
        end associate
        call whitener%whiten(whitener%line)
        associate (constant => whitener%line(1, :), slope => whitener%line(2, :))
            constant = constant/norm2(constant)
            do pass = 1, 2
                slope = slope - dot_product(constant, slope)*constant
            end do
            slope = slope/norm2(slope)
        end associate
    end subroutine orthonormal_line

    !> Whitens the next samples of ROW series; a state as it is declared begins them. They lie side by side: their sums over
    !> the poles, each a chain of additions, are done on vectors and beside each other.
    pure subroutine step_row(self, i, state, row_of_values, whitened)
        class(whitener_t), intent(in) :: self
        integer, intent(in) :: i                        !! Number of the sample: 1, 2, 3 ...
        type(row_state_t), intent(inout) :: state
        real(dp), intent(in) :: row_of_values(ROW)      !! The next ones
        real(dp), intent(out) :: whitened(ROW)          !! 0 for a sample that is left out

        real(dp) :: innovation(ROW), factor
        integer :: p

        innovation = 0
        do p = 1, N_POLES
            innovation = innovation + state%predicted(:, p)
        end do
        innovation = row_of_values - innovation
        factor = merge(self%inverse_deviation(i), 0.0_dp, self%used(i))
        whitened = factor*innovation
        do p = 1, N_POLES
            state%predicted(:, p) = self%decay(p, i)*(state%predicted(:, p) + self%gain(p, i)*innovation)
        end do
    end subroutine step_row

    !> Whitens several series in place.
    pure subroutine whiten(self, series, from)
        class(whitener_t), intent(in) :: self
        real(dp), intent(inout) :: series(:, :)         !! (series, samples)
        integer, intent(in), optional :: from
        !! Number of the first of these samples; the series are zero before it. Absent: 1

        integer :: first

        if (allocated(self%bridge)) then
            call self%bridge%whiten(series)
            return
        end if
        first = 1
        if (present(from)) first = from
        call lanes_filter(nonzero_rows(series), self%used(first:), .false., spread(1.0_dp, 1, N_POLES), self%gain(:, first:), &
                          self%inverse_deviation(first:), self%decay(:, first:), series)
    end subroutine whiten

    !> Whitens one series in place.
    pure subroutine whiten_series(self, series)
        class(whitener_t), intent(in) :: self
        real(dp), intent(inout) :: series(:)            !! (samples)

        real(dp) :: row(1, size(series))

        row(1, :) = series
        call self%whiten(row)
        series = row(1, :)
    end subroutine whiten_series

    !> How far every sample is from what the kept samples before it let expect, in standard deviations;
    !> with poles also for samples that are left out.
    pure function innovations(self, series) result(normalised)
        class(whitener_t), intent(in) :: self
        real(dp), intent(in) :: series(:)               !! (samples)
        real(dp) :: normalised(size(series))

        real(dp) :: row(1, size(series))

        row(1, :) = series
        if (allocated(self%bridge)) then
            call self%whiten(row)
        else
            call lanes_filter([1], self%used, .true., spread(1.0_dp, 1, N_POLES), self%gain, &
                              self%inverse_deviation, self%decay, row)
        end if
        normalised = row(1, :)
    end function innovations

    !> Multiplies one series in place with R^-1 freed of bias and drift, L^-T (I - Q Q^T) L^-1, R = L L^T the
    !> covariance matrix of the noise and Q the whitened straight line. What any linear unbiased
    !> estimate makes of a disturbance then is a sum over the unwhitened partials. L^-T is the transpose of
    !> the filter, run backwards.
    pure subroutine weigh_series(self, series)
        type(whitener_t), intent(in) :: self
        real(dp), intent(inout) :: series(:)            !! (samples)

        real(dp) :: later(N_POLES), innovation
        integer :: i

        call self%whiten_series(series)
        series = series - matmul(matmul(self%line, series), self%line)
        later = 0
        do i = self%samples, 1, -1
            later = self%decay(:, i)*later
            innovation = self%inverse_deviation(i)*series(i) + dot_product(self%gain(:, i), later)
            later = later - innovation
            series(i) = innovation
        end do
    end subroutine weigh_series

    !> The filter of a process at some samples. A sample that is left out has the gain that it would have; the next ones do
    !> not know of it.
    pure subroutine prepare_filter(process, epoch, kept, filter)
        type(gauss_markov_t), intent(in) :: process
        integer, intent(in) :: epoch(:)                 !! Of the samples, in intervals, increasing
        logical, intent(in) :: kept(:)                  !! (samples)
        type(process_filter_t), intent(inout) :: filter

        real(dp), dimension(process%n, size(epoch)) :: gain, below, on, above
        real(dp) :: inverse_deviation(size(epoch))
        real(dp), dimension(process%n, process%n) :: covariance, noise, both
        real(dp), dimension(process%n) :: across, phi_below, phi_on, phi_above, under, over
        real(dp) :: variance
        logical :: coupled(process%n)
        integer :: i, j, k, n

        n = process%n
        phi_below = 0
        phi_above = 0
        do j = 1, n         ! the three diagonals of the transition
            phi_on(j) = process%transition(j, j)
            if (j > 1) phi_below(j) = process%transition(j, j - 1)
            if (j < n) phi_above(j) = process%transition(j, j + 1)
        end do
        coupled = abs(phi_below) > 0 .or. abs(phi_above) > 0
        coupled = coupled .or. eoshift(abs(phi_below) > 0, 1) .or. eoshift(abs(phi_above) > 0, -1)
        do j = 1, n
            both(:, j) = phi_on*phi_on(j)
        end do
        noise = process%noise
        covariance = process%covariance
        filter%log_variance = 0
        do i = 1, size(epoch)
            across = 0
            do j = 1, n
                if (abs(process%output(j)) > 0) across = across + process%output(j)*covariance(:, j)
            end do
            variance = 1 + dot_product(process%output, across)
            inverse_deviation(i) = 1/sqrt(variance)
            gain(:, i) = across/variance
            if (kept(i)) then
                filter%log_variance = filter%log_variance + log(variance)
                do j = 1, n
                    covariance(:, j) = covariance(:, j) - gain(j, i)*across
                end do
            end if
            below(:, i) = phi_below
            on(:, i) = phi_on
            above(:, i) = phi_above
            if (i == size(epoch)) exit
            do k = epoch(i) + 1, epoch(i + 1)
                call carry_covariance(n, phi_below, phi_on, phi_above, both, noise, coupled, covariance)
                if (k == epoch(i) + 1) cycle
                ! of two coupled states j, j + 1: a product of two matrices of two rows
                under = below(:, i)
                over = above(:, i)
                below(:, i) = phi_on*under + phi_below*eoshift(on(:, i), -1)
                above(:, i) = phi_on*over + phi_above*eoshift(on(:, i), 1)
                on(:, i) = phi_on*on(:, i) + phi_below*eoshift(over, -1) + phi_above*eoshift(under, 1)
            end do
        end do
        filter%process = process
        filter%epoch = epoch
        filter%kept = kept
        filter%gain = gain
        filter%inverse_deviation = inverse_deviation
        filter%below = below
        filter%on = on
        filter%above = above
        filter%paired = abs(phi_above) > 0 .or. eoshift(abs(phi_below) > 0, 1)
    end subroutine prepare_filter

    !> Phi P Phi^T + Q in place of P. What is not coupled takes one product an element.
    pure subroutine carry_covariance(n, below, on, above, both, noise, coupled, p)
        integer, intent(in) :: n
        real(dp), intent(in) :: below(n), on(n), above(n)
        real(dp), intent(in) :: both(n, n)              ! on(i) on(j)
        real(dp), intent(in) :: noise(n, n)
        logical, intent(in) :: coupled(n)
        real(dp), intent(inout) :: p(n, n)

        real(dp) :: carried(n, n), column(n)            ! of the coupled columns: Phi P
        integer :: i, j

        do j = 1, n
            if (.not. coupled(j)) cycle
            carried(:, j) = on*p(:, j)
            do i = 1, n
                if (abs(below(i)) > 0) carried(i, j) = carried(i, j) + below(i)*p(i - 1, j)
                if (abs(above(i)) > 0) carried(i, j) = carried(i, j) + above(i)*p(i + 1, j)
            end do
        end do
        p = both*p + noise
        do j = 1, n
            if (.not. coupled(j)) cycle
            column = on(j)*carried(:, j) + noise(:, j)
            if (abs(below(j)) > 0) column = column + below(j)*carried(:, j - 1)
            if (abs(above(j)) > 0) column = column + above(j)*carried(:, j + 1)
            p(:, j) = column
            p(j, :) = column
        end do
    end subroutine carry_covariance

    !> Whitens series in place. Series that are zero throughout stay so. Samples that are not kept become zero, or get the
    !> innovation that they would have.
    pure subroutine whiten_by_filter(self, series, predicts)
        class(process_filter_t), intent(in) :: self
        real(dp), intent(inout) :: series(:, :)         !! (series, samples)
        logical, intent(in), optional :: predicts       !! The latter

        logical :: predicted

        predicted = .false.
        if (present(predicts)) predicted = predicts
        call lanes_filter(nonzero_rows(series), self%kept, predicted, self%process%output, self%gain, self%inverse_deviation, &
                          self%on, series, self%paired, self%below, self%above)
    end subroutine whiten_by_filter

    !> The numbers of those rows that are not zero throughout.
    pure function nonzero_rows(a) result(places)
        real(dp), intent(in) :: a(:, :)         !! Of any unit
        integer, allocatable :: places(:)       !! Increasing

        real(dp) :: sums(size(a, 1))
        integer :: i

        sums = 0
        do i = 1, size(a, 2)
            sums = sums + abs(a(:, i))
        end do
        places = pack([(i, i=1, size(a, 1))], .not. sums <= 0)      ! NaN, too
    end function nonzero_rows
end module gracecg_estimation_noise_whitening
