!> Whether the samples separate the leakage of the rods from the offset.
module gracecg_level1_leakage
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: solve_normal_equations, symmetric_eigen
    use gracecg_level1_solution, only: level1_solution_t
    implicit none
    private
    public :: judge_leakage, LEAKAGE_CHOICES, WORST_CONDITION

    !> What is done about the leakage of the rods into the accelerometer
    character(8), parameter :: LEAKAGE_CHOICES(2) = [character(8) :: 'estimate', 'prior']
    real(dp), parameter :: WORST_CONDITION = 1e6_dp     !! Of the scaled normal matrix
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
        solution%leakage = 'a priori'
        solution%separable = .false.
        if (allocated(failure)) return
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
        solution%separable = solution%condition <= WORST_CONDITION .and. all(solution%sigma_free <= UNDECIDED*bounded)
        if (leakage == 'estimate' .and. solution%separable) solution%leakage = 'estimated'
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
end module gracecg_level1_leakage
