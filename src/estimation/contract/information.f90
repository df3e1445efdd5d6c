!> Information about parameters: what independent samples, or knowledge beforehand, say of them together.
!>
!> The weighted squares of the residuals are a parabola of the parameters x,
!>
!>     S(x) = squares - 2 rhs^T x + x^T matrix x,
!>
!> least at matrix x = rhs, with the covariance matrix^-1. Information of independent sources adds; parameters that no
!> other source sees are eliminated where they are (H. Wolf's reduction of normal equations); parameters that change by
!> chance from one source to the next are those of before and a change that is eliminated (the information filter:
!> P. S. Maybeck, Stochastic Models, Estimation, and Control 1 (1979) section 5.7).
module gracecg_estimation_information
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: solve_normal_equations
    use gracecg_base_vectors, only: identity
    implicit none
    private
    public :: information_t, eliminated_t, no_information, information_of, gathered, squares_of

    type :: information_t
        !! About n parameters
        real(dp), allocatable :: matrix(:, :)   !! Normal matrix, n x n, inverse units of the parameters
        real(dp), allocatable :: rhs(:)         !! Right side of the normal equations, n
        real(dp) :: squares = 0                 !! S(0): weighted squares of the residuals
    contains
        procedure :: add            !! What an independent source says of the same parameters
        procedure :: expect         !! That a parameter is 0 but for a standard deviation
        procedure :: seen_through   !! The same about parameters of which these are a linear function
        procedure :: eliminate      !! The last parameters, at their best for whatever the others are
        procedure :: propagate      !! The parameters change, as is known and by chance
        procedure :: solve          !! The best parameters and their covariance
        procedure :: squares_at     !! S(x)
    end type information_t

    type :: eliminated_t
        !! Parameters that have been eliminated, as functions of the others
        real(dp), allocatable :: value(:)           !! The best where the others are 0
        real(dp), allocatable :: inverse(:, :)      !! Their covariance, the others kept
        real(dp), allocatable :: gain(:, :)         !! By which they fall with the others, (others, eliminated)
    contains
        procedure :: value_at       !! The best for values of the others
        procedure :: covariance_with    !! Their covariance when the others are estimated, too
    end type eliminated_t

contains

    !> Nothing is known of n parameters.
    pure function no_information(n) result(information)
        integer, intent(in) :: n    !! Number of parameters
        type(information_t) :: information

        allocate (information%matrix(n, n), information%rhs(n), source=0.0_dp)
    end function no_information

    !> That of an estimate with its covariance. Fails when the covariance is singular.
    subroutine information_of(value, covariance, information, error, names)
        real(dp), intent(in) :: value(:), covariance(:, :)    !! An estimate, n, and its covariance, n x n
        type(information_t), intent(out) :: information
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: names(:)      !! Of the parameters, for messages

        real(dp) :: condition

        allocate (information%matrix, mold=covariance)
        allocate (information%rhs, mold=value)
        call solve_normal_equations(covariance, value, information%rhs, information%matrix, condition, error, names)
        information%squares = dot_product(value, information%rhs)
    end subroutine information_of

    pure subroutine add(self, other)
        class(information_t), intent(inout) :: self
        class(information_t), intent(in) :: other

        self%matrix = self%matrix + other%matrix
        self%rhs = self%rhs + other%rhs
        self%squares = self%squares + other%squares
    end subroutine add

    !> That a parameter is 0 but for a standard deviation; where that is 0 nothing is known.
    pure subroutine expect(self, place, sigma, at)
        class(information_t), intent(inout) :: self
        integer, intent(in) :: place        !! Of the parameter
        real(dp), intent(in) :: sigma       !! In its unit
        real(dp), intent(in), optional :: at    !! Its value, of which the information is about corrections; absent: 0

        if (.not. sigma > 0) return
        self%matrix(place, place) = self%matrix(place, place) + 1/sigma**2
        if (present(at)) self%rhs(place) = self%rhs(place) - at/sigma**2
    end subroutine expect

    !> What several sources and what is known beforehand say together of corrections of the same parameters.
    pure function gathered(sources, prior, at) result(all)
        type(information_t), intent(in) :: sources(:)
        real(dp), intent(in) :: prior(:)        !! A-priori standard deviations of the parameters, n; 0: none
        real(dp), intent(in) :: at(:)           !! Values that are corrected, n
        type(information_t) :: all

        integer :: i

        all = no_information(size(prior))
        do i = 1, size(sources)
            call all%add(sources(i))
        end do
        do i = 1, size(prior)
            call all%expect(i, prior(i), at(i))
        end do
    end function gathered

    !> With x = map p + fixed: the information about p.
    pure function seen_through(self, map, fixed) result(seen)
        class(information_t), intent(in) :: self
        real(dp), intent(in) :: map(:, :)       !! (n, parameters p)
        real(dp), intent(in) :: fixed(:)        !! (n)
        type(information_t) :: seen

        seen%matrix = matmul(transpose(map), matmul(self%matrix, map))
        seen%rhs = matmul(transpose(map), self%rhs - matmul(self%matrix, fixed))
        seen%squares = self%squares_at(fixed)
    end function seen_through

    !> Eliminates the parameters after the first n. Fails when these do not leave them determined.
    subroutine eliminate(self, n, gone, error, names)
        class(information_t), intent(inout) :: self
        integer, intent(in) :: n    !! How many stay
        type(eliminated_t), intent(out) :: gone
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: names(:)      !! Of those that go, for messages

        real(dp) :: condition
        integer :: own

        own = size(self%rhs) - n
        allocate (gone%value(own), gone%inverse(own, own), gone%gain(n, own))
        if (own == 0) return
        call solve_normal_equations(self%matrix(n + 1:, n + 1:), self%rhs(n + 1:), gone%value, gone%inverse, condition, &
                                    error, names)
        if (allocated(error)) return
        gone%gain = matmul(self%matrix(:n, n + 1:), gone%inverse)
        self%squares = self%squares - dot_product(self%rhs(n + 1:), gone%value)
        self%rhs = self%rhs(:n) - matmul(gone%gain, self%rhs(n + 1:))
        self%matrix = self%matrix(:n, :n) - matmul(gone%gain, self%matrix(n + 1:, :n))
        self%matrix = (self%matrix + transpose(self%matrix))/2
    end subroutine eliminate

    !> Parameters that become x + step + w, w by chance: information about what they become.
    subroutine propagate(self, step, variance, error)
        class(information_t), intent(inout) :: self
        real(dp), intent(in) :: step(:)         !! What is known of the change, (n)
        real(dp), intent(in) :: variance(:)     !! Of w, independent, (n); 0: none
        type(error_t), allocatable, intent(out) :: error

        type(information_t) :: wider            ! about what they become and those w that are not 0
        type(eliminated_t) :: chance
        integer, allocatable :: places(:)
        integer :: i, n

        n = size(self%rhs)
        places = pack([(i, i=1, n)], variance > 0)
        associate (unit => identity(n))
            wider = self%seen_through(reshape([unit, -unit(:, places)], [n, n + size(places)]), -step)
        end associate
        do i = 1, size(places)
            call wider%expect(n + i, sqrt(variance(places(i))))
        end do
        call wider%eliminate(n, chance, error)
        self%matrix = wider%matrix
        self%rhs = wider%rhs
        self%squares = wider%squares
    end subroutine propagate

    !> Fails when the parameters are not determined.
    subroutine solve(self, value, covariance, error, names)
        class(information_t), intent(in) :: self
        real(dp), intent(out) :: value(:), covariance(:, :)    !! The estimate, n, and its covariance, n x n
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: names(:)      !! Of the parameters, for messages

        real(dp) :: condition

        call solve_normal_equations(self%matrix, self%rhs, value, covariance, condition, error, names)
    end subroutine solve

    pure real(dp) function squares_at(self, x)
        class(information_t), intent(in) :: self
        real(dp), intent(in) :: x(:)    !! Values of the parameters, n

        squares_at = self%squares - 2*dot_product(self%rhs, x) + dot_product(x, matmul(self%matrix, x))
    end function squares_at

    pure function value_at(self, others) result(value)
        class(eliminated_t), intent(in) :: self
        real(dp), intent(in) :: others(:)    !! Values of the parameters that are left
        real(dp) :: value(size(self%value))

        value = self%value - matmul(others, self%gain)
    end function value_at

    pure function covariance_with(self, others) result(covariance)
        class(eliminated_t), intent(in) :: self
        real(dp), intent(in) :: others(:, :)        !! Covariance of the others
        real(dp) :: covariance(size(self%value), size(self%value))

        covariance = self%inverse + matmul(transpose(self%gain), matmul(others, self%gain))
    end function covariance_with

    !> x^T C^-1 x: chi square of size(x) degrees of freedom, if x is 0 but for errors of this covariance. 0 where that is
    !> singular.
    real(dp) function squares_of(x, covariance) result(squares)
        real(dp), intent(in) :: x(:), covariance(:, :)    !! Errors, n, and their covariance, n x n

        type(information_t) :: information
        type(error_t), allocatable :: singular

        call information_of(x, covariance, information, singular)
        squares = information%squares       ! 0 where that failed
    end function squares_of
end module gracecg_estimation_information
