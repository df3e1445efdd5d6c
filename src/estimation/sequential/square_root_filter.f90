!> Square-root information filter and smoother for constants that are observed through coloured noise.
!>
!> The state is (p, y): p follows a Gauss-Markov process p(k+1) = Phi p(k) + L n(k), y is constant. A
!> scalar observation with unit noise is r = h^T p + g^T y + e. The filter keeps the triangular array
!>
!>     [ R_p  R_py | z_p ]      whose solution is the estimate and whose inverse squared is the
!>     [  0   R_y  | z_y ]      covariance,
!>
!> and never forms a covariance matrix: what enters is folded in by orthogonal transformations, so
!> that rounding errors do not grow with the ratio of the largest to the smallest variance
!> (G. J. Bierman, Factorization Methods for Discrete Sequential Estimation (1977), chapters V-VII and X;
!> P. Dyer, S. McReynolds, J. Optim. Theory Appl. 3 (1969) 444-458).
!>
!> The upper part belongs to one process (`process_filter_t`). Several processes that are independent
!> of each other, each seen by observations of its own, may share the lower part (`constants_t`): the
!> remainder of an observation, after p has taken what it can, is an observation of y alone. It is
!> the standardised innovation of a filter for p, and its partials: the observation whitened.
!>
!> Constants that move by a known linear law (attitude errors) are estimated as what they were at
!> the epoch: Bierman's "pseudo-epoch state".
module gracecg_estimation_square_root_filter
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_estimation_noise_whitening, only: nonzero_rows
    use gracecg_base_gauss_markov, only: gauss_markov_t
    implicit none
    private
    public :: constants_t, process_filter_t, process_smoother_t, innovation_t
    public :: new_constants, new_process_filter, start_smoother

    !> The array [R_y | z_y] of the constants.
    type :: constants_t
        integer :: n = 0                            !! Number of constants
        real(dp), allocatable :: array(:, :)        !! (n + 1, n): column i is row i of [R_y | z_y]
        real(dp) :: squares = 0                     !! Sum of the squared residuals so far
        real(dp), allocatable, private :: row(:)    !! Workspace (n + 1)
    contains
        procedure :: fold_in
        !! Folds an observation of the constants in, by Givens' rotations: row = [g, r], unit noise
        procedure :: fold_in_all
        !! The same with many observations that see the same constants
        procedure :: is_determined    !! True when every constant has been observed
        procedure :: solution    !! The estimate R_y^-1 z_y
        procedure :: last_covariance
        !! Estimate and covariance of the last few constants: only their corner of R_y is needed, so they
        !! cost little at every epoch
        procedure :: inverse_root    !! R_y^-1: times its transpose the covariance
        procedure :: log_determinant => constants_log_determinant    !! ln det(R_y^T R_y)
    end type constants_t

    !> The array [R_p R_py | z_p] of a process.
    type :: process_filter_t
        type(gauss_markov_t) :: process    !! That is filtered
        integer :: n = 0                            !! Number of states of the process
        integer :: m = 0                            !! Number of constants
        real(dp), allocatable :: array(:, :)        !! (n + m + 1, n): column i is row i of the array
        real(dp) :: log_variance = 0
        !! Sum of the logarithms of the innovations' variances, given y: with the remainders'
        !! squares the likelihood of the observations
        integer :: step = 0                         !! Intervals since the start
        real(dp), allocatable :: history(:, :, :)   !! (2n + m + 1, n, steps): rows of w for the smoother
        real(dp), allocatable, private :: row(:)    !! Workspace (n + m + 1)
        real(dp), allocatable, private :: work(:, :)    !! Workspace (2n + m + 1, 2n)
        real(dp), allocatable, private :: left(:, :)    !! Phi^-1 L, n x n
        real(dp), allocatable, private :: reflected(:)  !! Workspace (2n + m + 1)
    contains
        procedure :: observe    !! Folds an observation r = h^T p + g^T y + e in
        procedure :: advance    !! To the next epoch: p(k+1) in place of p(k)
        procedure :: predict_observation
        !! The innovation of an observation that has not been folded in, without solving for the state: with
        !! R^T u = (h, g), observed minus predicted is r - u.z and its variance 1 + u.u
    end type process_filter_t

    !> What the filter expects of an observation before it is folded in.
    type :: innovation_t
        logical :: defined = .false.    !! The estimate so far predicts the observation
        real(dp) :: residual = 0        !! Observed minus predicted
        real(dp) :: variance = 0        !! Of that, the observation's own (1) included
    end type innovation_t

    !> The process at one epoch given all observations: p = mean + gain^T y + noise of covariance C.
    type :: process_smoother_t
        integer :: step = 0                         !! The epoch, in intervals since the start
        real(dp), allocatable :: mean(:)            !! (n), for y = 0
        real(dp), allocatable :: gain(:, :)         !! (m, n): column i belongs to state i
        real(dp), allocatable :: covariance(:, :)   !! C, given y: n x n
    contains
        procedure :: step_back
        !! One epoch back, after Dyer and McReynolds (Bierman, section X.2): the kept rows give w from
        !! p(k+1) and y, and p(k) = Phi^-1 (p(k+1) - L w)
    end type process_smoother_t

contains

    !> Constants of which nothing is known (`sigma` absent), or which are zero with the standard
    !> deviations given.
    pure function new_constants(n, sigma) result(constants)
        integer, intent(in) :: n    !! Their number
        real(dp), intent(in), optional :: sigma(:)    !! Standard deviations, (n)
        type(constants_t) :: constants

        integer :: i

        constants%n = n
        allocate (constants%array(n + 1, n), constants%row(n + 1), source=0.0_dp)
        if (.not. present(sigma)) return
        do i = 1, n
            constants%array(i, i) = 1/sigma(i)
        end do
    end function new_constants

    !> Folds an observation of the constants in, by Givens' rotations: row = [g, r], unit noise.
    pure subroutine fold_in(self, row)
        class(constants_t), intent(inout) :: self
        real(dp), intent(in) :: row(:)          !! (n + 1)

        real(dp) :: contraction

        self%row = row
        call fold_row(self%n, self%n + 1, self%array, self%row, contraction)
        self%squares = self%squares + self%row(self%n + 1)**2
    end subroutine fold_in

    !> The same with many observations: what they see of the constants (the columns that are not zero) is brought
    !> into a triangle of its own first, by Householder's reflections of TOGETHER rows (one square root for all of them),
    !> and its few rows then are folded in. Where they see half of the constants, a row costs a quarter.
    pure subroutine fold_in_all(self, rows)
        class(constants_t), intent(inout) :: self
        real(dp), intent(in) :: rows(:, :)      !! (n + 1, observations)

        integer, parameter :: TOGETHER = 16
        real(dp), allocatable :: own(:, :)      ! the triangle, then the rows to come; columns are rows
        real(dp) :: row(self%n + 1), sum_of_rows(self%n + 1)
        integer, allocatable :: seen(:), places(:)
        integer :: i, first, last, m

        seen = nonzero_rows(rows(:self%n, :))
        m = size(seen)
        places = [seen, self%n + 1]
        allocate (own(m + 1, m + TOGETHER), source=0.0_dp)
        do first = 1, size(rows, 2), TOGETHER
            last = m + min(TOGETHER, size(rows, 2) - first + 1)
            own(:, m + 1:last) = rows(places, first:first + last - m - 1)
            do i = 1, m
                call reflect(own, i, i, m + 1, last, m + 1, sum_of_rows)
            end do
            self%squares = self%squares + sum(own(m + 1, m + 1:last)**2)
        end do
        do i = 1, m
            row = 0
            row(places(i:)) = own(i:, i)
            call self%fold_in(row)
        end do
    end subroutine fold_in_all

    !> True when every constant has been observed.
    pure logical function is_determined(self)
        class(constants_t), intent(in) :: self

        integer :: i

        is_determined = .true.
        do i = 1, self%n
            is_determined = is_determined .and. abs(self%array(i, i)) > 0
        end do
    end function is_determined

    !> The estimate R_y^-1 z_y. The constants must be determined.
    pure function solution(self) result(y)
        class(constants_t), intent(in) :: self
        real(dp) :: y(self%n)

        integer :: i

        do i = self%n, 1, -1
            y(i) = (self%array(self%n + 1, i) - dot_product(self%array(i + 1:self%n, i), y(i + 1:)))/ &
                   self%array(i, i)
        end do
    end function solution

    !> Estimate and covariance of the last few constants: only their corner of R_y is needed, so they
    !> cost little at every epoch. They must be determined.
    pure subroutine last_covariance(self, estimate, covariance)
        class(constants_t), intent(in) :: self
        real(dp), intent(out) :: estimate(:)        !! (k): of the last k constants
        real(dp), intent(out) :: covariance(:, :)   !! k x k

        real(dp) :: inverse(size(estimate), size(estimate))
        integer :: i, j, k, first

        k = size(estimate)
        first = self%n - k
        inverse = 0
        do i = k, 1, -1
            estimate(i) = self%array(self%n + 1, first + i) - &
                          dot_product(self%array(first + i + 1:self%n, first + i), estimate(i + 1:))
            estimate(i) = estimate(i)/self%array(first + i, first + i)
            inverse(i, i) = 1
            do j = i, k
                inverse(i, j) = (inverse(i, j) - dot_product(self%array(first + i + 1:first + j, first + i), &
                                                             inverse(i + 1:j, j)))/ &
                                self%array(first + i, first + i)
            end do
        end do
        covariance = matmul(inverse, transpose(inverse))
    end subroutine last_covariance

    !> R_y^-1: times its transpose the covariance.
    pure function inverse_root(self) result(inverse)
        class(constants_t), intent(in) :: self
        real(dp) :: inverse(self%n, self%n)

        integer :: i, j

        inverse = 0
        do j = 1, self%n
            inverse(j, j) = 1/self%array(j, j)
            do i = j - 1, 1, -1
                inverse(i, j) = -dot_product(self%array(i + 1:j, i), inverse(i + 1:j, j))/self%array(i, i)
            end do
        end do
    end function inverse_root

    !> ln det(R_y^T R_y).
    pure real(dp) function constants_log_determinant(self) result(value)
        class(constants_t), intent(in) :: self

        integer :: i

        value = 0
        do i = 1, self%n
            value = value + 2*log(abs(self%array(i, i)))
        end do
    end function constants_log_determinant

    !> A filter that starts with the process in its initial covariance.
    !>
    !> Fails when that covariance is not positive definite.
    subroutine new_process_filter(process, constants, steps, filter, error)
        type(gauss_markov_t), intent(in) :: process
        integer, intent(in) :: constants                    !! Number of constants m
        integer, intent(in) :: steps                        !! Intervals to come; 0: no smoother wanted
        type(process_filter_t), intent(out) :: filter
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: root(process%n, process%n)
        integer :: i, j, n, m

        n = process%n
        m = constants
        filter%process = process
        filter%n = n
        filter%m = m
        allocate (filter%array(n + m + 1, n), filter%row(n + m + 1), filter%work(2*n + m + 1, 2*n), &
                  filter%reflected(2*n + m + 1), source=0.0_dp)
        allocate (filter%history(2*n + m + 1, n, steps))
        filter%left = matmul(process%inverse_transition, process%noise_root)
        ! covariance = U U^T with U upper triangular, from the last column back; R_p = U^-1
        root = 0
        do j = n, 1, -1
            root(j, j) = process%covariance(j, j) - sum(root(j, j + 1:)**2)
            if (.not. root(j, j) > 0) then
                call fail(error, 'the initial covariance of a process is not positive definite')
                return
            end if
            root(j, j) = sqrt(root(j, j))
            do i = 1, j - 1
                root(i, j) = (process%covariance(i, j) - dot_product(root(i, j + 1:), root(j, j + 1:)))/root(j, j)
            end do
        end do
        do j = 1, n
            filter%array(j, j) = 1/root(j, j)
            do i = j - 1, 1, -1
                filter%array(j, i) = -dot_product(root(i, i + 1:j), filter%array(j, i + 1:j))/root(i, i)
            end do
        end do
    end subroutine new_process_filter

    !> Folds an observation r = h^T p + g^T y + e in. What is left of it is an observation of y alone,
    !> for constants_t%fold_in.
    pure subroutine observe(self, h, row, remainder)
        class(process_filter_t), intent(inout) :: self
        real(dp), intent(in) :: h(:)            !! (n)
        real(dp), intent(in) :: row(:)          !! (m + 1): [g, r]
        real(dp), intent(out) :: remainder(:)   !! (m + 1)

        real(dp) :: contraction

        associate (n => self%n)
            self%row(:n) = h
            self%row(n + 1:) = row
            call fold_row(n, n + self%m + 1, self%array, self%row, contraction)
            self%log_variance = self%log_variance - 2*log(contraction)
            remainder = self%row(n + 1:)
        end associate
    end subroutine observe

    !> Folds a row into triangular rows by Givens' rotations; what is left of it stays in its other columns. The
    !> columns of `array` are its rows.
    pure subroutine fold_row(n, columns, array, row, contraction)
        integer, intent(in) :: n, columns
        real(dp), intent(inout) :: array(columns, n), row(columns)
        real(dp), intent(out) :: contraction        !! Product of the cosines

        real(dp) :: radius, c, s, kept
        integer :: i, j

        contraction = 1
        do i = 1, n
            if (.not. abs(row(i)) > 0) cycle
            radius = sqrt(array(i, i)**2 + row(i)**2)
            c = array(i, i)/radius
            s = row(i)/radius
            contraction = contraction*abs(c)
            do j = i, columns
                kept = array(j, i)
                array(j, i) = c*kept + s*row(j)
                row(j) = c*row(j) - s*kept
            end do
        end do
    end subroutine fold_row

    !> To the next epoch: p(k+1) in place of p(k). With p(k) = Phi^-1 (p(k+1) - L w) the rows
    !>
    !>     [      I              0        0   |  0  ]  w            (the noise is white)
    !>     [ -R_p Phi^-1 L   R_p Phi^-1  R_py | z_p ]  p(k+1), y
    !>
    !> are triangularised by Householder's reflections; those of w are kept for the smoother.
    pure subroutine advance(self)
        class(process_filter_t), intent(inout) :: self

        integer :: i, j, n, last

        n = self%n
        if (n == 0) then
            self%step = self%step + 1
            return
        end if
        last = 2*n + self%m + 1
        self%work(:, :n) = 0
        do i = 1, n
            self%work(i, i) = 1
            self%work(:2*n, n + i) = 0
            do j = i, n
                self%work(:n, n + i) = self%work(:n, n + i) - self%array(j, i)*self%left(j, :)
                self%work(n + 1:2*n, n + i) = self%work(n + 1:2*n, n + i) + &
                                              self%array(j, i)*self%process%inverse_transition(j, :)
            end do
            self%work(2*n + 1:, n + i) = self%array(n + 1:, i)
        end do
        do i = 1, n
            call reflect(self%work, i, i, n + 1, 2*n, last, self%reflected)
        end do
        do i = 1, n - 1
            call reflect(self%work, n + i, n + i, n + i + 1, 2*n, last, self%reflected)
        end do
        self%array = self%work(n + 1:, n + 1:)
        self%step = self%step + 1
        if (self%step <= size(self%history, 3)) self%history(:, :, self%step) = self%work(:, :n)
    end subroutine advance

    !> Householder's reflection of the rows `pivot` and first..last_row that makes their elements in
    !> `column` vanish but for the pivot's. The rows of the array are the columns of `rows`.
    pure subroutine reflect(rows, column, pivot, first, last_row, last_column, sum_of_rows)
        real(dp), contiguous, intent(inout) :: rows(:, :)
        integer, intent(in) :: column, pivot, first, last_row, last_column
        real(dp), contiguous, intent(inout) :: sum_of_rows(:)   !! Workspace

        real(dp) :: length, leading, scale
        integer :: i, j

        length = rows(column, pivot)**2
        do i = first, last_row
            length = length + rows(column, i)**2
        end do
        length = sqrt(length)
        if (.not. length > abs(rows(column, pivot))) return
        if (rows(column, pivot) > 0) length = -length
        leading = rows(column, pivot) - length          ! first element of the reflecting vector
        scale = -1/(length*leading)                     ! 2 over the square of its length
        do j = column + 1, last_column
            sum_of_rows(j) = leading*rows(j, pivot)
        end do
        do i = first, last_row
            do j = column + 1, last_column
                sum_of_rows(j) = sum_of_rows(j) + rows(column, i)*rows(j, i)
            end do
        end do
        do j = column + 1, last_column
            sum_of_rows(j) = scale*sum_of_rows(j)
            rows(j, pivot) = rows(j, pivot) - leading*sum_of_rows(j)
        end do
        do i = first, last_row
            do j = column + 1, last_column
                rows(j, i) = rows(j, i) - rows(column, i)*sum_of_rows(j)
            end do
            rows(column, i) = 0
        end do
        rows(column, pivot) = length
    end subroutine reflect

    !> The innovation of an observation that has not been folded in, without solving for the state:
    !> with R^T u = (h, g), observed minus predicted is r - u.z and its variance 1 + u.u. Undefined
    !> as long as the constants are not determined.
    pure function predict_observation(self, constants, h, row) result(innovation)
        class(process_filter_t), intent(in) :: self
        type(constants_t), intent(in) :: constants
        real(dp), intent(in) :: h(:)            !! (n)
        real(dp), intent(in) :: row(:)          !! (m + 1): [g, r]
        type(innovation_t) :: innovation

        real(dp) :: left(self%n + self%m + 1), u
        integer :: i, n

        innovation%defined = constants%is_determined()
        if (.not. innovation%defined) return
        n = self%n
        left(:n) = h
        left(n + 1:) = row
        innovation%variance = 1
        do i = 1, n
            u = left(i)/self%array(i, i)
            innovation%variance = innovation%variance + u**2
            left(i + 1:) = left(i + 1:) - u*self%array(i + 1:, i)
        end do
        do i = 1, self%m
            u = left(n + i)/constants%array(i, i)
            innovation%variance = innovation%variance + u**2
            left(n + i + 1:) = left(n + i + 1:) - u*constants%array(i + 1:, i)
        end do
        innovation%residual = left(n + self%m + 1)
    end function predict_observation

    !> The process at the last epoch, where filter and smoother are one.
    pure subroutine start_smoother(filter, smoother)
        type(process_filter_t), intent(in) :: filter
        type(process_smoother_t), intent(out) :: smoother

        real(dp) :: solved(filter%n + filter%m + 1, filter%n)
        integer :: i, n

        n = filter%n
        solved = 0
        do i = 1, n
            solved(i, i) = 1
            solved(n + 1:, i) = filter%array(n + 1:, i)
        end do
        call back_substitute(n, n + filter%m + 1, filter%array, solved)
        smoother%step = filter%step
        smoother%covariance = matmul(transpose(solved(:n, :)), solved(:n, :))
        smoother%gain = -solved(n + 1:n + filter%m, :)
        smoother%mean = solved(n + filter%m + 1, :)
    end subroutine start_smoother

    !> One epoch back, after Dyer and McReynolds (Bierman, section X.2): the kept rows give w from
    !> p(k+1) and y, and p(k) = Phi^-1 (p(k+1) - L w). Every covariance is a sum of squares.
    !>
    !> step must be above 0, and the filter must have kept its history.
    pure subroutine step_back(self, filter)
        class(process_smoother_t), intent(inout) :: self
        type(process_filter_t), intent(in) :: filter

        call step_back_sized(filter%n, filter%m, 2*filter%n + filter%m + 1, filter%history(:, :, self%step), &
                             filter%left, filter%process%inverse_transition, self%mean, self%gain, &
                             self%covariance)
        self%step = self%step - 1
    end subroutine step_back

    !> The work of step_back, with sizes that the compiler sees. Rows of matrices are columns here.
    pure subroutine step_back_sized(n, m, columns, kept, left, inverse_transition, mean, gain, covariance)
        integer, intent(in) :: n, m, columns                !! columns = 2n + m + 1
        real(dp), intent(in) :: kept(columns, n)
        real(dp), intent(in) :: left(n, n)                  !! Phi^-1 L
        real(dp), intent(in) :: inverse_transition(n, n)    !! Phi^-1
        real(dp), intent(inout) :: mean(n), gain(m, n), covariance(n, n)

        real(dp) :: solved(columns, n), moved(columns, n), new_mean(n), new_gain(m, n), product(n, n)
        integer :: i, k

        do i = 1, n                             ! [I  R_wp  R_wy  z_w], then R_w^-1 times it
            solved(:n, i) = 0
            solved(i, i) = 1
            solved(n + 1:, i) = kept(n + 1:, i)
        end do
        call back_substitute(n, columns, kept, solved)
        moved = 0                               ! Phi^-1 L R_w^-1 [I  R_wp  R_wy  z_w]
        do i = 1, n
            do k = 1, n
                if (abs(left(i, k)) > 0) moved(:, i) = moved(:, i) + left(i, k)*solved(:, k)
            end do
            moved(n + 1:2*n, i) = moved(n + 1:2*n, i) + inverse_transition(i, :)
        end do
        do i = 1, n
            new_mean(i) = -moved(columns, i)
            new_gain(:, i) = moved(2*n + 1:2*n + m, i)
            product(:, i) = 0
            do k = 1, n
                associate (back => moved(n + k, i))
                    new_mean(i) = new_mean(i) + back*mean(k)
                    new_gain(:, i) = new_gain(:, i) + back*gain(:, k)
                    product(:, i) = product(:, i) + back*covariance(:, k)
                end associate
            end do
        end do
        mean = new_mean
        gain = new_gain
        covariance = matmul(transpose(product), moved(n + 1:2*n, :)) + &
                     matmul(transpose(moved(:n, :)), moved(:n, :))
    end subroutine step_back_sized

    !> Solves R x = b for several b at once: column i of `rows` is row i of R, column i of `b` holds the
    !> elements i of all b.
    pure subroutine back_substitute(n, columns, rows, b)
        integer, intent(in) :: n, columns
        real(dp), intent(in) :: rows(:, :)          !! (at least n, n)
        real(dp), intent(inout) :: b(columns, n)

        integer :: i, k

        do i = n, 1, -1
            do k = i + 1, n
                b(:, i) = b(:, i) - rows(k, i)*b(:, k)
            end do
            b(:, i) = b(:, i)/rows(i, i)
        end do
    end subroutine back_substitute
end module gracecg_estimation_square_root_filter
