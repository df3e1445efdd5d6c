!> Noise of any spectrum as an autoregressive sequence: of each sample the part that its predecessors predict, and a white
!> rest. Predictors of all orders by N. Levinson's recursion (J. Math. Phys. 25 (1947) 261-278) from autocovariances, so
!> that the first samples behind a gap are predicted by as many as there are.
module gracecg_base_autoregression
    use gracecg_base_kinds, only: dp
    implicit none
    private
    public :: autoregression_t, autocovariances_t, predictors_of

    !> The predictors of a sequence.
    type :: autoregression_t
        integer :: order = 0                        !! Highest
        real(dp), allocatable :: predictor(:, :)    !! (k, order): weight of the sample k before
        real(dp), allocatable :: deviation(:)       !! (0:order): of what is left, unit of the sequence
    end type autoregression_t

    !> Sums of products of samples some steps apart, over any number of series.
    type :: autocovariances_t
        real(dp), allocatable :: sums(:)            !! (0:order)
        integer :: count = 0                        !! Of samples
    contains
        procedure :: begin                          !! Of an order
        procedure :: add                            !! A series
        procedure :: add_errors                     !! What errors of estimated parameters have taken out of a series
    end type autocovariances_t

contains

    !> No samples yet.
    pure subroutine begin(self, order)
        class(autocovariances_t), intent(inout) :: self
        integer, intent(in) :: order                !! Largest distance of two samples

        if (allocated(self%sums)) deallocate (self%sums)
        allocate (self%sums(0:order), source=0.0_dp)
        self%count = 0
    end subroutine begin

    !> Adds a series.
    pure subroutine add(self, epoch, series, kept)
        class(autocovariances_t), intent(inout) :: self
        integer, intent(in) :: epoch(:)             !! Of the samples, increasing
        real(dp), intent(in) :: series(:)    !! The samples, of mean 0, any unit
        logical, intent(in) :: kept(:)              !! A sample that does not count has false

        real(dp) :: there(epoch(1):epoch(size(epoch)))
        integer :: k, last

        there = 0
        there(epoch) = merge(series, 0.0_dp, kept)
        last = ubound(there, 1)
        do k = 0, min(ubound(self%sums, 1), last - epoch(1))
            self%sums(k) = self%sums(k) + dot_product(there(epoch(1):last - k), there(epoch(1) + k:last))
        end do
        self%count = self%count + count(kept)
    end subroutine add

    !> Adds what the residuals of a fit lack: with partials A and the covariance C of its parameters, the noise has the
    !> covariance that is expected of the residuals, and A C A^T (the expectation of A. P. Dempster, N. M. Laird, D. B. Rubin,
    !> J. Roy. Stat. Soc. B 39 (1977) 1-38; C has to be that by this noise).
    pure subroutine add_errors(self, epoch, partials, covariance, kept)
        class(autocovariances_t), intent(inout) :: self
        integer, intent(in) :: epoch(:)             !! Of the samples, increasing
        real(dp), intent(in) :: partials(:, :)      !! (parameters, samples)
        real(dp), intent(in) :: covariance(:, :)    !! Of the parameters
        logical, intent(in) :: kept(:)              !! A sample that does not count has false

        real(dp) :: there(size(partials, 1), epoch(1):epoch(size(epoch)))
        real(dp) :: errors(size(partials, 1), epoch(1):epoch(size(epoch)))
        integer :: i, k, last

        there = 0
        do i = 1, size(epoch)
            if (kept(i)) there(:, epoch(i)) = partials(:, i)
        end do
        errors = matmul(covariance, there)
        last = ubound(there, 2)
        do k = 0, min(ubound(self%sums, 1), last - epoch(1))
            self%sums(k) = self%sums(k) + sum(there(:, epoch(1):last - k)*errors(:, epoch(1) + k:last))
        end do
    end subroutine add_errors

    !> The predictors from autocovariances. Without noise all predict 0, and deviations are tiny.
    pure function predictors_of(sums, redundancy) result(model)
        type(autocovariances_t), intent(in) :: sums
        real(dp), intent(in) :: redundancy    !! Samples, less parameters that a fit has taken from them; 1 at least
        type(autoregression_t) :: model

        real(dp), parameter :: RIDGE = 1e-9_dp      ! Of the variance: keeps the recursion stable
        real(dp) :: reflection, variance
        integer :: n

        n = ubound(sums%sums, 1)
        model%order = n
        allocate (model%predictor(n, n), source=0.0_dp)
        allocate (model%deviation(0:n))
        associate (c => sums%sums(0:)/max(1.0_dp, redundancy), a => model%predictor)
            variance = max(c(1)*(1 + RIDGE), tiny(1.0_dp))
            model%deviation(0) = sqrt(variance)
            do n = 1, model%order
                reflection = c(n + 1)
                if (n > 1) reflection = reflection - dot_product(a(:n - 1, n - 1), c(n:2:-1))
                reflection = reflection/variance
                if (n > 1) a(:n - 1, n) = a(:n - 1, n - 1) - reflection*a(n - 1:1:-1, n - 1)
                a(n, n) = reflection
                variance = variance*(1 - reflection**2)
                model%deviation(n) = sqrt(variance)
            end do
        end associate
    end function predictors_of
end module gracecg_base_autoregression
