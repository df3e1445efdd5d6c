!> The offset d from the accelerations of all spans and one source of angular acceleration. For axis a of a sample
!>
!>     y_a = [wd x d + w x (w x d) + mu/r^3 (d - 3 c (c.d))]_a + polynomial + sum_k (L_ak I_k + K_ak dI_k/dt)
!>
!> with one L and one K for all spans and a polynomial by span; observations and columns are projected on a band of
!> frequencies and weighted by the density of their residuals, which has for each axis a level and a tilt in the band.
module gracecg_level1_offset
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, NANOTESLA
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_lapack, only: normal_equations, solve_normal_equations, symmetric_eigen
    use gracecg_base_text, only: integer_text
    use gracecg_base_vectors, only: cross, cross_matrix, identity, inverse_3x3
    use gracecg_level1_angular, only: level1_motion_t
    use gracecg_level1_calibration, only: level1_calibration_t
    implicit none
    private
    public :: level1_solution_t, source_series_t, consider_t, solve_offset, modelled_acceleration, sigma_of
    public :: LEAKAGE_CHOICES

    !> What is done about the leakage of the rods into the accelerometer
    character(8), parameter :: LEAKAGE_CHOICES(3) = [character(8) :: 'estimate', 'prior', 'none']
    integer, parameter :: WEIGHT_ROUNDS = 3
    real(dp), parameter :: WORST_CONDITION = 1e6_dp
    real(dp), parameter :: UNDECIDED = 2    !! Sigma without over with a-priori leakage: the data do not decide

    real(dp), parameter :: FULL_CURRENT = 120, FULL_FIELD = 30000*NANOTESLA     !! Of a proportional leakage: mA, T

    type :: source_series_t
        !! The angular acceleration of one span
        real(dp), allocatable :: acceleration(:, :)     !! rad/s^2; axis, sample
        real(dp), allocatable :: patterns(:, :)         !! Of angles that were differentiated: how their noise of 1 rad shows in
                                                        !! it, as independent numbers; sample, pattern; 1/s^2
        real(dp) :: noise(3) = 0                        !! Sigma of the angles about each axis, rad
    end type source_series_t

    type :: consider_t
        !! Something that is not estimated and is known with a sigma: how it changes the angular acceleration
        real(dp) :: sigma = 0    !! Of what is not estimated, in its unit
        integer :: span = 0                             !! Only this one changes; 0: all
        type(source_series_t), allocatable :: change(:) !! By span, for a change by 1
    end type consider_t

    type :: level1_solution_t
        !! An offset with what it rests on
        character(12) :: source = ''    !! Of the angular acceleration
        character(12) :: leakage = ''                   !! estimated, a priori or none
        real(dp) :: offset(3) = 0                       !! d, m, SRF
        real(dp) :: formal(3, 3) = 0                    !! Covariance by noise and leakage, m^2
        real(dp) :: covariance(3, 3) = 0                !! And by what is considered, m^2
        real(dp) :: leak(3, 3) = 0, leak_sigma(3, 3) = 0            !! L: axis, rod; m/s^2/mA
        real(dp) :: leak_rate(3, 3) = 0, leak_rate_sigma(3, 3) = 0  !! K, m/s^2/(mA/s)
        real(dp) :: sigma_alone(3) = 0                  !! Of d if no leakage is estimated, m
        real(dp) :: sigma_free(3) = 0                   !! If it is estimated without a-priori sigma, m; huge: cannot be
        real(dp) :: condition = 0                       !! Of the scaled normal matrix with leakage, without a-priori sigma
        character(160) :: weakest = ''                  !! Direction that the data determine least
        real(dp) :: rms(3) = 0                          !! Of residuals in the band, by sample, m/s^2
        integer :: samples = 0, spans = 0    !! That are used
        real(dp), allocatable :: span_offset(:, :)      !! By each span alone with the leakage of all, m
        real(dp), allocatable :: span_sigma(:, :)       !! m; negative: not determined
        real(dp), allocatable :: span_rms(:, :)         !! Of residuals in the band, m/s^2
        real(dp) :: chi_square = 0                      !! Of the spans about the combined offset
        integer :: degrees = 0                          !! Of freedom of it
        real(dp) :: whiteness = 0                       !! Mean squares of residuals in the lower half of the band over those in
                                                        !! the upper, of the axis where that, or its inverse, is largest
        type(source_series_t), allocatable :: series(:) !! The source's angular acceleration, by span
        integer :: flag = 2                             !! 0 good, 1 with care, 2 not to be used
        character(200) :: reason = ''                   !! Why not 0
    end type level1_solution_t

    !> One span and axis in the band, each column divided by its amplitude
    type :: block_t
        integer :: axis = 0, span = 0
        real(dp), allocatable :: amplitude(:)   !! Of the noise, relative to the middle of the band
        real(dp), allocatable :: rows(:, :)     !! Parameter, band column
        real(dp), allocatable :: observed(:)
        real(dp), allocatable :: others(:, :)   !! Considered accelerations: band column, each
        real(dp), allocatable :: patterns(:, :) !! Of the source's noise: band column, pattern
        real(dp) :: noise(3) = 0                !! Its sigma by axis of the source
        real(dp), allocatable :: products(:, :) !! I_k B_b of the rods driven, of 120 mA and 30 000 nT: band column, each
    end type block_t

contains

    !> Row a of the matrix that takes d into the acceleration: wd x, w x (w x, gravity gradient.
    pure function signal_of(acceleration, rate, up, gradient) result(matrix)
        real(dp), intent(in) :: acceleration(3)     !! wd, rad/s^2
        real(dp), intent(in) :: rate(3)             !! w, rad/s
        real(dp), intent(in) :: up(3)               !! c
        real(dp), intent(in) :: gradient            !! mu/r^3, 1/s^2
        real(dp) :: matrix(3, 3)

        real(dp) :: w(3, 3)
        integer :: i

        w = cross_matrix(rate)
        matrix = cross_matrix(acceleration) + matmul(w, w) + gradient*identity(3)
        do i = 1, 3
            matrix(:, i) = matrix(:, i) - 3*gradient*up*up(i)
        end do
    end function signal_of

    !> Standard deviations of the offset.
    pure function sigma_of(solution) result(sigma)
        type(level1_solution_t), intent(in) :: solution
        real(dp) :: sigma(3)                    !! m

        integer :: k

        sigma = sqrt([(solution%covariance(k, k), k=1, 3)])
    end function sigma_of

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
                            proportional)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_motion_t), intent(in) :: motion(:)          !! Of each span
        type(source_series_t), intent(in) :: source(:)          !! Of each span
        type(consider_t), intent(in) :: considered(:)
        logical, intent(in) :: driven(3)                        !! Rods
        character(*), intent(in) :: leakage                     !! One of LEAKAGE_CHOICES
        real(dp), intent(in) :: prior(2)                        !! Sigma of L and K
        real(dp), intent(in) :: scale_sigma                     !! Of the accelerometer, considered
        type(level1_solution_t), intent(inout) :: solution      !! Its source is kept
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: proportional          !! Sigma of what is proportional to I and B, considered:
                                                                !! m/s^2 at 120 mA and 30 000 nT. Absent: 0

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
            priors(3 + (a - 1)*2*r + 1:3 + (a - 1)*2*r + r) = 1/max(prior(1), tiny(1.0_dp))**2
            priors(3 + (a - 1)*2*r + r + 1:3 + a*2*r) = 1/max(prior(2), tiny(1.0_dp))**2
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
        call consider(blocks, weight, x, covariance, considered, scale_sigma, prior, r, solution, error, proportional)
        if (allocated(error)) return
        call span_solutions(calibration, blocks, weight, x, solution)
    end subroutine solve_offset

    !> Everything in the band.
    subroutine make_blocks(calibration, motion, source, considered, rods, blocks)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_motion_t), intent(in) :: motion(:)
        type(source_series_t), intent(in) :: source(:)
        type(consider_t), intent(in) :: considered(:)
        integer, intent(in) :: rods(:)
        type(block_t), allocatable, intent(out) :: blocks(:)

        real(dp), allocatable :: rows(:, :, :)
        integer :: i, k, a, n, m, r, b, c, at

        r = size(rods)
        allocate (blocks(3*count(calibration%spans%used)))
        b = 0
        do i = 1, size(calibration%spans)
            if (.not. calibration%spans(i)%used) cycle
            n = size(calibration%spans(i)%time)
            m = size(motion(i)%band, 2)
            allocate (rows(3, 3, n))
            do k = 1, n
                rows(:, :, k) = signal_of(source(i)%acceleration(:, k), motion(i)%rate(:, k), motion(i)%up(:, k), &
                                          motion(i)%gradient(k))
            end do
            do a = 1, 3
                b = b + 1
                blocks(b)%axis = a
                blocks(b)%span = i
                allocate (blocks(b)%amplitude(m), source=1.0_dp)
                blocks(b)%observed = matmul(calibration%spans(i)%linear(a, :), motion(i)%band)
                allocate (blocks(b)%rows(3 + 6*r, m), source=0.0_dp)
                blocks(b)%rows(1:3, :) = matmul(rows(a, :, :), motion(i)%band)
                at = 3 + (a - 1)*2*r
                do k = 1, r
                    blocks(b)%rows(at + k, :) = matmul(motion(i)%current(rods(k), :), motion(i)%band)
                    blocks(b)%rows(at + r + k, :) = matmul(motion(i)%current_rate(rods(k), :), motion(i)%band)
                end do
                allocate (blocks(b)%products(m, 3*r))
                do k = 1, r
                    do c = 1, 3
                        blocks(b)%products(:, 3*(k - 1) + c) = &
                            matmul(motion(i)%current(rods(k), :)/FULL_CURRENT*motion(i)%field(c, :)/FULL_FIELD, motion(i)%band)
                    end do
                end do
                blocks(b)%noise = source(i)%noise
                if (allocated(source(i)%patterns)) then
                    if (a == 1) blocks(b)%patterns = matmul(transpose(motion(i)%band), source(i)%patterns)
                    if (a > 1) blocks(b)%patterns = blocks(b - 1)%patterns
                end if
                ! Of what is considered the row that belongs to d: [change x d]_a, three columns each.
                allocate (blocks(b)%others(m, 3*size(considered)), source=0.0_dp)
                do c = 1, size(considered)
                    if (considered(c)%span /= 0 .and. considered(c)%span /= i) cycle
                    call cross_row(considered(c)%change(i)%acceleration, a, motion(i)%band, &
                                   blocks(b)%others(:, 3*c - 2:3*c))
                end do
            end do
            deallocate (rows)
        end do
    end subroutine make_blocks

    !> Row a of the cross product with a series, in the band.
    pure subroutine cross_row(series, a, band, columns)
        real(dp), intent(in) :: series(:, :), band(:, :)
        integer, intent(in) :: a
        real(dp), intent(out) :: columns(:, :)

        integer :: next, last

        next = modulo(a, 3) + 1
        last = modulo(a + 1, 3) + 1
        columns = 0
        columns(:, last) = matmul(series(next, :), band)
        columns(:, next) = -matmul(series(last, :), band)
    end subroutine cross_row

    subroutine accumulate(blocks, weight, normal, rhs)
        type(block_t), intent(in) :: blocks(:)
        real(dp), intent(in) :: weight(3)
        real(dp), intent(out) :: normal(:, :), rhs(:)

        real(dp) :: part(size(rhs), size(rhs)), part_rhs(size(rhs))
        integer :: i

        normal = 0
        rhs = 0
        do i = 1, size(blocks)
            call normal_equations(blocks(i)%rows, blocks(i)%observed, part, part_rhs)
            normal = normal + weight(blocks(i)%axis)*part
            rhs = rhs + weight(blocks(i)%axis)*part_rhs
        end do
    end subroutine accumulate

    !> Whether the data separate leakage from d: by the singular values, and by what an a-priori sigma would change.
    subroutine judge_leakage(normal, rhs, priors, rods, leakage, solution)
        real(dp), intent(in) :: normal(:, :), rhs(:), priors(:)
        integer, intent(in) :: rods(:)
        character(*), intent(in) :: leakage
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

    !> Where the columns of a band lie in it, from -1 to 1: they rise in frequency.
    pure function positions(columns) result(u)
        integer, intent(in) :: columns
        real(dp) :: u(columns)

        integer :: k

        u = [((2*k - 1 - columns)/real(columns, dp), k=1, columns)]
    end function positions

    !> Weights from the residuals: their density in the band is level*exp(tilt*u), u from -1 to 1, for each axis.
    !> The tilt makes the likelihood of their squares, exponential numbers with that mean (P. Whittle 1953), greatest:
    !> sum u (s/level - 1) = 0, s the squares by exp(tilt*u), which falls with the tilt.
    subroutine residual_weights(blocks, x, parameters, tilt, weight, rms)
        type(block_t), intent(inout) :: blocks(:)   !! The columns are divided by their amplitudes
        real(dp), intent(in) :: x(:)
        integer, intent(in) :: parameters           !! That were estimated
        real(dp), intent(inout) :: tilt(3)          !! By axis
        real(dp), intent(out) :: weight(3), rms(3)  !! RMS as observed, m/s^2

        integer, parameter :: STEPS = 20            ! Newton's
        real(dp), parameter :: LARGEST_STEP = 1, LARGEST_TILT = 8, SETTLED = 1e-6_dp
        real(dp), allocatable :: left(:), u(:)
        real(dp) :: moments(0:2), step, level
        integer :: axis, i, k, number, free

        free = nint(parameters/3.0_dp)
        do axis = 1, 3
            do k = 1, STEPS
                moments = 0
                level = 0
                number = 0
                do i = 1, size(blocks)
                    if (blocks(i)%axis /= axis) cycle
                    u = positions(size(blocks(i)%observed))
                    left = (blocks(i)%observed - matmul(x, blocks(i)%rows))**2
                    level = level + sum(left*blocks(i)%amplitude**2)
                    left = left*blocks(i)%amplitude**2*exp(-tilt(axis)*u)
                    moments = moments + [sum(left), sum(u*left), sum(u**2*left)]
                    number = number + size(u)
                end do
                if (.not. moments(2) > 0) exit
                step = moments(1)/moments(2)
                tilt(axis) = min(LARGEST_TILT, max(-LARGEST_TILT, tilt(axis) + min(LARGEST_STEP, max(-LARGEST_STEP, step))))
                if (abs(step) < SETTLED) exit
            end do
            rms(axis) = sqrt(level/max(1, number - free))
            weight(axis) = 0
            if (moments(0) > 0) weight(axis) = max(1, number - free)/moments(0)
        end do
        do i = 1, size(blocks)
            call divide_by_amplitude(blocks(i), exp(tilt(blocks(i)%axis)*positions(size(blocks(i)%observed))/2))
        end do
    end subroutine residual_weights

    !> Gives the columns of a block other amplitudes.
    pure subroutine divide_by_amplitude(block, amplitude)
        type(block_t), intent(inout) :: block
        real(dp), intent(in) :: amplitude(:)

        real(dp) :: factor(size(amplitude))
        integer :: k

        factor = block%amplitude/amplitude
        block%amplitude = amplitude
        block%observed = block%observed*factor
        do k = 1, size(factor)
            block%rows(:, k) = block%rows(:, k)*factor(k)
            block%others(k, :) = block%others(k, :)*factor(k)
            block%products(k, :) = block%products(k, :)*factor(k)
            if (allocated(block%patterns)) block%patterns(k, :) = block%patterns(k, :)*factor(k)
        end do
    end subroutine divide_by_amplitude

    !> Adds to the covariance of d what is considered: its effect on d by least squares, times its sigma.
    subroutine consider(blocks, weight, x, covariance, considered, scale_sigma, prior, r, solution, error, proportional)
        type(block_t), intent(in) :: blocks(:)
        real(dp), intent(in) :: weight(3), x(:), covariance(:, :)
        type(consider_t), intent(in) :: considered(:)
        real(dp), intent(in) :: scale_sigma, prior(2)
        integer, intent(in) :: r                        !! Rods
        type(level1_solution_t), intent(inout) :: solution
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: proportional  !! Of what is proportional to I and B, m/s^2

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
        if (present(proportional)) then
            do a = 1, 3         ! force along an axis by each rod and component of the field
                do c = 1, merge(3*r, 0, proportional > 0)
                    effect = 0
                    do i = 1, size(blocks)
                        if (blocks(i)%axis == a) &
                            effect = effect + weight(a)*matmul(blocks(i)%rows, blocks(i)%products(:, c))
                    end do
                    call add(effect, proportional)
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
