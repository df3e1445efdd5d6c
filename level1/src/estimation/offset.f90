!> The offset d from the accelerations of all spans and one source of angular acceleration. For axis a of a sample
!>
!>     y_a = [wd x d + w x (w x d) + mu/r^3 (d - 3 c (c.d))]_a + polynomial + sum_k (L_ak I_k + K_ak dI_k/dt)
!>
!> with one L and one K for all spans and a polynomial by span; observations and columns are projected on a band of
!> frequencies and weighted by the density of their residuals, which has for each axis a level and a tilt in the band.
module gracecg_level1_offset
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations
    use gracecg_level1_angular, only: level1_motion_t
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_offset_solution, only: level1_solution_t, source_series_t, consider_t
    use gracecg_level1_offset_blocks, only: block_t, signal_of, make_blocks, accumulate, residual_weights
    use gracecg_level1_offset_errors, only: judge_leakage, consider
    implicit none
    private
    public :: solve_offset, modelled_acceleration, LEAKAGE_CHOICES

    !> What is done about the leakage of the rods into the accelerometer
    character(8), parameter :: LEAKAGE_CHOICES(3) = [character(8) :: 'estimate', 'prior', 'none']
    integer, parameter :: WEIGHT_ROUNDS = 3

contains

    !> The acceleration of a span by a solution: of d and of the rods' leakage, without bias and drift.
    pure subroutine modelled_acceleration(motion, series, solution, acceleration)
        type(level1_motion_t), intent(in) :: motion         !! Of the span
        type(source_series_t), intent(in) :: series         !! Likewise
        type(level1_solution_t), intent(in) :: solution
        real(dp), allocatable, intent(out) :: acceleration(:, :)    !! (3, samples), m/s^2

        integer :: k

        allocate (acceleration(3, size(motion%gradient)))
        do k = 1, size(motion%gradient)
            acceleration(:, k) = matmul(signal_of(series%acceleration(:, k), motion%rate(:, k), motion%up(:, k), &
                                                  motion%gradient(k)), solution%offset) + &
                matmul(solution%leak, motion%current(:, k)) + matmul(solution%leak_rate, motion%current_rate(:, k))
        end do
    end subroutine modelled_acceleration

    !> The offset by one source. Fails when no span is usable or d is not determined at all.
    subroutine solve_offset(calibration, motion, source, considered, driven, leakage, prior, scale_sigma, solution, error, &
                            forces)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_motion_t), intent(in) :: motion(:)          !! Of each span
        type(source_series_t), intent(in) :: source(:)          !! Of each span
        type(consider_t), intent(in) :: considered(:)
        logical, intent(in) :: driven(3)                        !! Rods
        character(*), intent(in) :: leakage                     !! One of LEAKAGE_CHOICES
        real(dp), intent(in) :: prior(2)                        !! Sigma of L and K, positive
        real(dp), intent(in) :: scale_sigma                     !! Of the accelerometer, considered
        type(level1_solution_t), intent(inout) :: solution      !! Its source is kept
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: forces(2)     !! Sigma of forces that are considered: proportional to I and B, m/s^2
                                                        !! at 120 mA and 30 000 nT; the air's, m/s^2 by its angle. Absent: 0

        type(block_t), allocatable :: blocks(:)
        real(dp), allocatable :: normal(:, :), rhs(:), x(:), covariance(:, :), priors(:)
        real(dp) :: weight(3), condition, d3(3), c3(3, 3), tilt(3)
        integer, allocatable :: rods(:)
        integer :: parameters, round, r, i, k, a
        character(12) :: used

        rods = pack([1, 2, 3], driven)
        r = size(rods)
        parameters = 3 + 6*r
        solution%spans = count(calibration%spans%used)
        if (solution%spans == 0) then
            call fail(error, 'no span is usable')
            return
        end if
        solution%samples = 0
        do i = 1, size(calibration%spans)
            if (calibration%spans(i)%used) solution%samples = solution%samples + size(calibration%spans(i)%time)
        end do
        call make_blocks(calibration, motion, source, considered, rods, blocks)
        allocate (normal(parameters, parameters), rhs(parameters), x(parameters), covariance(parameters, parameters), &
                  priors(parameters))
        priors = 0
        do a = 1, 3
            priors(3 + (a - 1)*2*r + 1:3 + (a - 1)*2*r + r) = 1/prior(1)**2
            priors(3 + (a - 1)*2*r + r + 1:3 + a*2*r) = 1/prior(2)**2
        end do
        weight = 0
        do i = 1, size(blocks)
            weight(blocks(i)%axis) = weight(blocks(i)%axis) + sum(blocks(i)%observed**2)/size(blocks(i)%observed)
        end do
        weight = solution%spans/max(weight, tiny(1.0_dp))
        used = ''
        tilt = 0
        do round = 1, WEIGHT_ROUNDS
            call accumulate(blocks, weight, normal, rhs)
            call solve_normal_equations(normal(:3, :3), rhs(:3), d3, c3, condition, error)
            if (allocated(error)) return
            solution%sigma_alone = sqrt([(c3(k, k), k=1, 3)])
            call judge_leakage(normal, rhs, priors, rods, leakage, solution)
            used = solution%leakage
            if (used == 'none') then
                x = 0
                covariance = 0
                x(:3) = d3
                covariance(:3, :3) = c3
            else
                if (used == 'a priori') then
                    do k = 1, parameters
                        normal(k, k) = normal(k, k) + priors(k)
                    end do
                end if
                call solve_normal_equations(normal, rhs, x, covariance, condition, error)
                if (allocated(error)) return
            end if
            call residual_weights(blocks, x, merge(3, parameters, used == 'none'), tilt, weight, solution%rms)
        end do
        solution%offset = x(:3)
        solution%formal = covariance(:3, :3)
        do a = 1, 3
            do k = 1, r
                i = 3 + (a - 1)*2*r + k
                solution%leak(a, rods(k)) = x(i)
                solution%leak_sigma(a, rods(k)) = sqrt(covariance(i, i))
                solution%leak_rate(a, rods(k)) = x(i + r)
                solution%leak_rate_sigma(a, rods(k)) = sqrt(covariance(i + r, i + r))
            end do
        end do
        call consider(blocks, weight, x, covariance, considered, scale_sigma, prior, r, solution, error, forces)
        if (allocated(error)) return
        call span_solutions(calibration, blocks, weight, x, solution)
    end subroutine solve_offset

    !> Each span alone with the leakage of all; chi square of the spans about the combined offset.
    subroutine span_solutions(calibration, blocks, weight, x, solution)
        type(level1_calibration_t), intent(in) :: calibration
        type(block_t), intent(in) :: blocks(:)
        real(dp), intent(in) :: weight(3), x(:)
        type(level1_solution_t), intent(inout) :: solution

        real(dp) :: normal(3, 3), rhs(3), part(3, 3), part_rhs(3), d(3), covariance(3, 3), condition
        real(dp), allocatable :: left(:), partials(:, :)
        type(error_t), allocatable :: failure
        real(dp) :: halves(2, 3)
        integer :: i, k, half

        halves = 0
        allocate (solution%span_offset(3, size(calibration%spans)), solution%span_sigma(3, size(calibration%spans)), &
                  solution%span_rms(3, size(calibration%spans)), source=0.0_dp)
        solution%span_sigma = -1
        solution%chi_square = 0
        solution%degrees = -3
        do i = 1, size(calibration%spans)
            if (.not. calibration%spans(i)%used) cycle
            normal = 0
            rhs = 0
            do k = 1, size(blocks)
                if (blocks(k)%span /= i) cycle
                left = blocks(k)%observed - matmul(x(4:), blocks(k)%rows(4:, :))
                partials = blocks(k)%rows(:3, :)
                call normal_equations(partials, left, part, part_rhs)
                normal = normal + weight(blocks(k)%axis)*part
                rhs = rhs + weight(blocks(k)%axis)*part_rhs
                left = (left - matmul(x(:3), partials))*blocks(k)%amplitude
                solution%span_rms(blocks(k)%axis, i) = sqrt(sum(left**2)/size(left))
                half = size(left)/2     ! columns of the band rise in frequency
                halves(1, blocks(k)%axis) = halves(1, blocks(k)%axis) + sum(left(:half)**2)/half
                halves(2, blocks(k)%axis) = halves(2, blocks(k)%axis) + sum(left(half + 1:)**2)/(size(left) - half)
            end do
            call solve_normal_equations(normal, rhs, d, covariance, condition, failure)
            if (allocated(failure)) cycle
            solution%span_offset(:, i) = d
            solution%span_sigma(:, i) = sqrt([(covariance(k, k), k=1, 3)])
            solution%chi_square = solution%chi_square + dot_product(d - x(:3), matmul(normal, d - x(:3)))
            solution%degrees = solution%degrees + 3
        end do
        halves = max(halves, tiny(1.0_dp))
        k = maxloc(abs(log(halves(1, :)/halves(2, :))), 1)
        solution%whiteness = halves(1, k)/halves(2, k)
    end subroutine span_solutions
end module gracecg_level1_offset
