!> Noise of any spectrum as an autoregressive sequence: of each sample the part that its predecessors predict, and a white
!> rest. Predictors of all orders by N. Levinson's recursion (J. Math. Phys. 25 (1947) 261-278) from autocovariances, so
!> that the first samples are predicted by as many as there are. Samples that are missing get the values that the others on
!> both sides let expect: then the innovations of all have the squares that those that are there have alone.
module gracecg_base_autoregression
    use gracecg_base_kinds, only: dp
    use gracecg_base_lapack, only: factor_bands, solve_bands
    implicit none
    private
    public :: autoregression_t, autocovariances_t, predictors_of, bridge_t, new_bridge

    !> The predictors of a sequence.
    type :: autoregression_t
        integer :: order = 0                        !! Highest
        real(dp), allocatable :: predictor(:, :)    !! (k, order): weight of the sample k before
        real(dp), allocatable :: deviation(:)       !! (0:order): of what is left, unit of the sequence
    contains
        procedure :: innovations                    !! What is left of some series, in standard deviations
        procedure, private :: part                  !! Of a sample in the innovation of another one
    end type autoregression_t

    !> The way over samples that are missing.
    type :: bridge_t
        type(autoregression_t) :: model             !! Of the sequence
        integer, allocatable :: missing(:)          !! Their places, increasing
        real(dp), allocatable, private :: factor(:, :)  !! Cholesky's, of their inverse covariance by all others; by bands
    contains
        procedure :: fill                           !! Puts what is expected in their places
        procedure :: whiten                         !! Innovations with what is expected in their places
        procedure :: covariance => bridge_covariance    !! Of the missing about what is expected
    end type bridge_t

    !> Sums of products of samples some steps apart, over any number of series.
    type :: autocovariances_t
        real(dp), allocatable :: sums(:)            !! (0:order)
        integer :: count = 0                        !! Of samples
    contains
        procedure :: begin                          !! Of an order
        procedure :: add                            !! A series
        procedure :: add_errors                     !! What errors of estimated parameters have taken out of a series
        procedure :: add_missing                    !! What a series lacks whose missing samples were filled
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
    pure subroutine add(self, series)
        class(autocovariances_t), intent(inout) :: self
        real(dp), intent(in) :: series(:)           !! The samples, of mean 0, any unit

        integer :: k

        do k = 0, min(ubound(self%sums, 1), size(series) - 1)
            self%sums(k) = self%sums(k) + dot_product(series(:size(series) - k), series(1 + k:))
        end do
        self%count = self%count + size(series)
    end subroutine add

    !> Adds what the residuals of a fit lack: with partials A and the covariance C of its parameters, the noise has the
    !> covariance that is expected of the residuals, and A C A^T (the expectation of A. P. Dempster, N. M. Laird, D. B. Rubin,
    !> J. Roy. Stat. Soc. B 39 (1977) 1-38; C has to be that by this noise).
    pure subroutine add_errors(self, partials, covariance)
        class(autocovariances_t), intent(inout) :: self
        real(dp), intent(in) :: partials(:, :)      !! (parameters, samples)
        real(dp), intent(in) :: covariance(:, :)    !! Of the parameters

        real(dp) :: errors(size(partials, 1), size(partials, 2))
        integer :: k, n

        errors = matmul(covariance, partials)
        n = size(partials, 2)
        do k = 0, min(ubound(self%sums, 1), n - 1)
            self%sums(k) = self%sums(k) + sum(partials(:, :n - k)*errors(:, 1 + k:))
        end do
    end subroutine add_errors

    !> Adds what a series lacks in which missing samples are what is expected.
    pure subroutine add_missing(self, bridge)
        class(autocovariances_t), intent(inout) :: self
        type(bridge_t), intent(in) :: bridge

        real(dp) :: covariance(size(bridge%missing), size(bridge%missing))
        integer :: i, k, apart

        covariance = bridge%covariance()
        do i = 1, size(bridge%missing)
            do k = i, size(bridge%missing)
                apart = bridge%missing(k) - bridge%missing(i)
                if (apart > ubound(self%sums, 1)) exit
                self%sums(apart) = self%sums(apart) + covariance(k, i)
            end do
        end do
    end subroutine add_missing

    !> What is left of every sample behind what those before it let expect, in standard deviations.
    pure function innovations(self, series) result(left)
        class(autoregression_t), intent(in) :: self
        real(dp), intent(in) :: series(:, :)        !! (series, samples)
        real(dp) :: left(size(series, 1), size(series, 2))

        integer :: i, k, n

        do i = 1, size(series, 2)
            n = min(self%order, i - 1)
            left(:, i) = series(:, i)
            do k = 1, n
                left(:, i) = left(:, i) - self%predictor(k, n)*series(:, i - k)
            end do
            left(:, i) = left(:, i)/self%deviation(n)
        end do
    end function innovations

    !> By what a sample counts in the innovation of sample i.
    pure real(dp) function part(self, i, sample)
        class(autoregression_t), intent(in) :: self
        integer, intent(in) :: i, sample            !! Not later than i, at most `order` earlier

        integer :: n

        n = min(self%order, i - 1)
        part = 1/self%deviation(n)
        if (sample < i) part = -self%predictor(i - sample, n)*part
    end function part

    !> The way over missing samples of a sequence.
    pure function new_bridge(model, there) result(bridge)
        type(autoregression_t), intent(in) :: model
        logical, intent(in) :: there(:)             !! Which samples are
        type(bridge_t) :: bridge

        integer :: i, k, l, n, m

        n = size(there)
        bridge%model = model
        bridge%missing = pack([(i, i=1, n)], .not. there)
        m = size(bridge%missing)
        allocate (bridge%factor(min(m, model%order + 1), m), source=0.0_dp)
        associate (missing => bridge%missing)
            do i = 1, m
                do k = i, min(m, i + model%order)
                    do l = missing(k), min(n, missing(i) + model%order)
                        bridge%factor(1 + k - i, i) = bridge%factor(1 + k - i, i) + model%part(l, missing(i))* &
                            model%part(l, missing(k))
                    end do
                end do
            end do
        end associate
        call factor_bands(bridge%factor)
    end function new_bridge

    !> Puts what the samples that are there let expect in the places of those that are missing.
    pure subroutine fill(self, series)
        class(bridge_t), intent(in) :: self
        real(dp), intent(inout) :: series(:, :)     !! (series, samples)

        if (size(self%missing) == 0) return
        series(:, self%missing) = 0
        series(:, self%missing) = expected(self, self%model%innovations(series))
    end subroutine fill

    !> The innovations of series whose missing samples are what is expected.
    pure subroutine whiten(self, series)
        class(bridge_t), intent(in) :: self
        real(dp), intent(inout) :: series(:, :)     !! (series, samples)

        real(dp) :: filled(size(series, 1), size(self%missing))
        integer :: i, l

        series(:, self%missing) = 0
        series = self%model%innovations(series)
        if (size(self%missing) == 0) return
        filled = expected(self, series)
        do i = 1, size(self%missing)
            do l = self%missing(i), min(size(series, 2), self%missing(i) + self%model%order)
                series(:, l) = series(:, l) + self%model%part(l, self%missing(i))*filled(:, i)
            end do
        end do
    end subroutine whiten

    !> What is expected of the missing samples, by innovations of series where they are zero: (series, missing).
    pure function expected(self, left) result(values)
        class(bridge_t), intent(in) :: self
        real(dp), intent(in) :: left(:, :)          !! (series, samples)
        real(dp) :: values(size(left, 1), size(self%missing))

        real(dp) :: right(size(self%missing), size(left, 1)), sums(size(left, 1))
        integer :: i, l, m

        m = size(self%missing)
        do i = 1, m
            sums = 0
            do l = self%missing(i), min(size(left, 2), self%missing(i) + self%model%order)
                sums = sums - self%model%part(l, self%missing(i))*left(:, l)
            end do
            right(i, :) = sums
        end do
        call solve_bands(self%factor, right)
        values = transpose(right)
    end function expected

    !> The covariance of the missing samples about what is expected, (missing, missing).
    pure function bridge_covariance(self) result(covariance)
        class(bridge_t), intent(in) :: self
        real(dp) :: covariance(size(self%missing), size(self%missing))

        integer :: i, m

        m = size(self%missing)
        covariance = 0
        do i = 1, m
            covariance(i, i) = 1
        end do
        call solve_bands(self%factor, covariance)
    end function bridge_covariance

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
