!> How well the offset is known: whether the data separate it from the leakage, and what its covariance gets by what is not
!> estimated and by noise in the source.
module gracecg_level1_offset_errors
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: solve_normal_equations, symmetric_eigen
    use gracecg_base_text, only: integer_text
    use gracecg_base_vectors, only: identity, inverse_3x3
    use gracecg_level1_offset_solution, only: level1_solution_t, consider_t
    use gracecg_level1_offset_blocks, only: block_t
    implicit none
    private
    public :: judge_leakage, consider

    real(dp), parameter :: WORST_CONDITION = 1e6_dp
    real(dp), parameter :: UNDECIDED = 2    !! Sigma without over with a-priori leakage: the data do not decide

contains

    !> Whether the data separate leakage from d: by the singular values, and by what an a-priori sigma would change.
    subroutine judge_leakage(normal, rhs, priors, rods, leakage, solution)
        real(dp), intent(in) :: normal(:, :), rhs(:)    !! Without what is known a priori
        real(dp), intent(in) :: priors(:)               !! What that adds to the diagonal
        integer, intent(in) :: rods(:)                  !! That are driven
        character(*), intent(in) :: leakage             !! One of LEAKAGE_CHOICES
        type(level1_solution_t), intent(inout) :: solution

        real(dp), dimension(size(rhs), size(rhs)) :: scaled, vectors, covariance, with_prior
        real(dp), dimension(size(rhs)) :: values, x
        real(dp) :: condition, bounded(3)
        type(error_t), allocatable :: failure
        integer :: i, k, n

        n = size(rhs)
        scaled = 0
        do i = 1, n
            do k = 1, n
                if (normal(i, i) > 0 .and. normal(k, k) > 0) scaled(k, i) = normal(k, i)/sqrt(normal(i, i)*normal(k, k))
            end do
        end do
        call symmetric_eigen(scaled, values, vectors, failure)
        solution%condition = huge(1.0_dp)
        if (allocated(failure)) then
            solution%leakage = 'a priori'
            return
        end if
        if (values(1) > values(n)*epsilon(1.0_dp)) solution%condition = values(n)/values(1)
        solution%weakest = direction_text(vectors(:, 1), rods)
        with_prior = normal
        do i = 1, n
            with_prior(i, i) = with_prior(i, i) + priors(i)
        end do
        bounded = 0
        call solve_normal_equations(with_prior, rhs, x, covariance, condition, failure)
        if (.not. allocated(failure)) bounded = sqrt([(covariance(i, i), i=1, 3)])
        solution%sigma_free = huge(1.0_dp)
        call solve_normal_equations(normal, rhs, x, covariance, condition, failure)
        if (.not. allocated(failure)) solution%sigma_free = sqrt([(covariance(i, i), i=1, 3)])
        select case (leakage)
        case ('none')
            solution%leakage = 'none'
        case ('prior')
            solution%leakage = 'a priori'
        case default
            solution%leakage = 'estimated'
            if (solution%condition > WORST_CONDITION .or. any(solution%sigma_free > UNDECIDED*bounded)) &
                solution%leakage = 'a priori'
        end select
    end subroutine judge_leakage

    !> The largest parts of a direction of the parameters.
    pure function direction_text(direction, rods) result(text)
        real(dp), intent(in) :: direction(:)
        integer, intent(in) :: rods(:)
        character(160) :: text

        real(dp), parameter :: SMALL = 0.2_dp
        character(8) :: name
        character(6) :: number
        integer :: i, r, place

        r = size(rods)
        text = ''
        do i = 1, size(direction)
            if (abs(direction(i)) < SMALL) cycle
            if (i <= 3) then
                name = 'd_'//AXES(i)
            else
                place = modulo(i - 4, 2*r)
                name = merge('L', 'K', place < r)//'_'//AXES((i - 4)/(2*r) + 1)//AXES(rods(modulo(place, r) + 1))
            end if
            write (number, '(sp, f6.2)') direction(i)
            text = trim(text)//' '//trim(adjustl(number))//' '//name
        end do
        text = adjustl(text)
    end function direction_text

    !> Adds to the covariance of d what is considered: its effect on d by least squares, times its sigma.
    subroutine consider(blocks, weight, x, covariance, considered, scale_sigma, prior, r, solution, error, forces)
        type(block_t), intent(in) :: blocks(:)
        real(dp), intent(in) :: weight(3)               !! By axis, s^4/m^2
        real(dp), intent(in) :: x(:), covariance(:, :)  !! Of the parameters
        type(consider_t), intent(in) :: considered(:)
        real(dp), intent(in) :: scale_sigma             !! Of the accelerometer
        real(dp), intent(in) :: prior(2)                !! Sigma of L and K
        integer, intent(in) :: r                        !! Rods
        type(level1_solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: forces(2)     !! Of what is proportional to I and B, and of the air's, m/s^2

        real(dp) :: effect(size(x))
        integer :: i, c, a, k

        solution%covariance = solution%formal
        call consider_noise(blocks, weight, x, covariance, solution, error)
        if (allocated(error)) return
        do a = 1, 3             ! scale of the accelerometer
            effect = 0
            do i = 1, size(blocks)
                if (blocks(i)%axis == a) effect = effect + weight(a)* &
                    matmul(blocks(i)%rows, matmul(x(:3), blocks(i)%rows(:3, :)))
            end do
            call add(effect, scale_sigma)
        end do
        do c = 1, size(considered)
            effect = 0
            do i = 1, size(blocks)
                effect = effect + weight(blocks(i)%axis)* &
                    matmul(blocks(i)%rows, matmul(blocks(i)%others(:, 3*c - 2:3*c), x(:3)))
            end do
            call add(effect, considered(c)%sigma)
        end do
        if (present(forces)) then
            do a = 1, 3         ! force along an axis by the angle of the flow, by each rod and component of the field
                effect = 0
                do i = 1, size(blocks)
                    if (blocks(i)%axis == a) effect = effect + weight(a)*matmul(blocks(i)%rows, blocks(i)%flow)
                end do
                call add(effect, forces(2))
                do c = 1, merge(3*r, 0, forces(1) > 0)
                    effect = 0
                    do i = 1, size(blocks)
                        if (blocks(i)%axis == a) &
                            effect = effect + weight(a)*matmul(blocks(i)%rows, blocks(i)%products(:, c))
                    end do
                    call add(effect, forces(1))
                end do
            end do
        end if
        if (solution%leakage /= 'none') return
        do k = 4, size(x)       ! leakage that is not estimated
            effect = 0
            do i = 1, size(blocks)
                effect = effect + weight(blocks(i)%axis)*matmul(blocks(i)%rows, blocks(i)%rows(k, :))
            end do
            call add(effect, merge(prior(1), prior(2), modulo(k - 4, 2*r) < r))
        end do

    contains

        subroutine add(gradient, sigma)
            real(dp), intent(in) :: gradient(:), sigma

            real(dp) :: change(3)
            integer :: j

            change = matmul(covariance(:3, :), gradient)*sigma
            do j = 1, 3
                solution%covariance(:, j) = solution%covariance(:, j) + change*change(j)
            end do
        end subroutine add
    end subroutine consider

    !> Puts into the covariance of d the noise of a source that has some in itself, not in what it is compared with.
    !>
    !> Pattern j of the noise adds E_j d, E_j = [e_b p_j x], to the residuals and E_j to the columns A of d, so that d changes
    !> by C (sum_j z_j sigma_b A^T W E_j d - M d): z_j are normal numbers, and M = sum_j sigma_b^2 E_j^T W E_j, which is
    !> diagonal, makes d too small by the share C M (W. A. Fuller, Measurement error models, 1987, section 1.1.1). What of the
    !> noise is in the residuals, and with them in the formal covariance, is taken out of that. Fails when the noise is no
    !> small part of what determines d.
    subroutine consider_noise(blocks, weight, x, covariance, solution, error)
        type(block_t), intent(in) :: blocks(:)          !! Three of each span, by axis
        real(dp), intent(in) :: weight(3), x(:), covariance(:, :)
        type(level1_solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: LARGEST_SHARE = 0.2_dp   ! Of d, that is lost
        real(dp), allocatable :: change(:, :)
        real(dp) :: squares(3), lost(3), d(3), shares(3), vectors(3, 3), power(3), among
        integer :: i, k, axis, next, last

        lost = 0        ! the diagonal of M
        among = 0
        do i = 1, size(blocks), 3
            if (.not. allocated(blocks(i)%patterns)) return
            among = among + size(blocks(i)%observed)
            associate (span => blocks(i:i + 2), noise => blocks(i)%noise)
                squares = [(sum(span(axis)%patterns**2), axis=1, 3)]
                do axis = 1, 3
                    next = modulo(axis, 3) + 1
                    last = modulo(axis + 1, 3) + 1
                    lost(axis) = lost(axis) + squares(next)*noise(last)**2*weight(next) + squares(last)*noise(next)**2*weight(last)
                end do
            end associate
        end do
        call symmetric_eigen(covariance(:3, :3)*sqrt(spread(lost, 1, 3)*spread(lost, 2, 3)), shares, vectors, error)
        if (allocated(error)) return
        if (shares(3) > LARGEST_SHARE) then
            call fail(error, 'the noise of its angles is '//integer_text(nint(100*min(shares(3), 1.0_dp)))// &
                      ' % of what would determine d: no offset by it')
            return
        end if
        d = matmul(inverse_3x3(identity(3) - covariance(:3, :3)*spread(lost, 1, 3)), x(:3))
        solution%covariance = solution%covariance + spread(d - x(:3), 1, 3)*spread(d - x(:3), 2, 3)
        power = 0
        do i = 1, size(blocks), 3
            associate (span => blocks(i:i + 2), noise => blocks(i)%noise)
                squares = [(sum(span(axis)%patterns**2), axis=1, 3)]
                do axis = 1, 3      ! of the noise
                    next = modulo(axis, 3) + 1
                    last = modulo(axis + 1, 3) + 1
                    change = noise(axis)*matmul(covariance(:3, :), &
                        weight(last)*d(next)*matmul(span(last)%rows, span(last)%patterns) - &
                        weight(next)*d(last)*matmul(span(next)%rows, span(next)%patterns))
                    solution%covariance = solution%covariance + matmul(change, transpose(change))
                    power(last) = power(last) + squares(last)*(noise(axis)*d(next))**2/among
                    power(next) = power(next) + squares(next)*(noise(axis)*d(last))**2/among
                end do
            end associate
        end do
        do i = 1, size(blocks)
            k = blocks(i)%axis
            change = weight(k)*sqrt(min(power(k), 1/weight(k)))*matmul(covariance(:3, :), blocks(i)%rows)
            solution%covariance = solution%covariance - matmul(change, transpose(change))
        end do
    end subroutine consider_noise
end module gracecg_level1_offset_errors
