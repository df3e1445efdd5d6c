!> The calibration as a filter sees it: linearised samples of accelerometer and star camera in the
!> order of time, the disturbances of each accelerometer axis as Gauss-Markov processes.
!>
!> The constants are the parts of a disturbance that two axes share with a third, the error of its frequency, the
!> parameters of the physical model at the epoch (gracecg_estimation_linearisation) and, last, the CG offset. Every
!> axis has a process of its own (the
!> flicker noise of the instrument, and what the non-gravitational acceleration does beside its
!> straight line); given the constants, the axes are independent, so each is whitened by itself and
!> what is left meets in the array of the constants (gracecg_estimation_square_root_information).
module gracecg_estimation_linearised_samples
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: sum_of_products
    use gracecg_base_vectors, only: identity
    use gracecg_estimation_information, only: information_t, information_of
    use gracecg_estimation_noise_whitening, only: process_filter_t, prepare_filter, whiten_by_process, nonzero_rows
    use gracecg_base_coloured_noise, only: coloured_noise_t, N_POLES
    use gracecg_base_gauss_markov, only: gauss_markov_t, no_process, first_order_process, superposed
    use gracecg_estimation_square_root_information, only: constants_t, new_constants
    use gracecg_estimation_process_smoother, only: smooth_errors, smooth_signals
    use gracecg_estimation_running_estimate, only: running_estimate_t
    implicit none
    private
    public :: filter_problem_t, SHARED, FREQUENCY
    public :: flicker_process, whiten, whiten_axis, gather, run_through_time, smooth_axis, smooth_star_camera

    integer, parameter :: SHARED(2) = [1, 2]        !! Places of the shared parts among the constants
    integer, parameter :: FREQUENCY = 3     !! Place of the error of a tone's frequency, in units of one cycle an arc

    !> A calibration, linearised about a nominal trajectory.
    type :: filter_problem_t
        integer :: m = 0                            !! Number of constants; the offset is the last three
        integer :: steps = 0                        !! Intervals of the arc
        real(dp) :: interval = 0                    !! Of the accelerometer, s
        real(dp), allocatable :: prior(:, :)        !! [g, r] of the a-priori knowledge: (m + 1, m)
        integer, allocatable :: epoch(:)            !! Of the accelerometer's samples, in intervals
        real(dp), allocatable :: acceleration(:, :, :)
        !! [g, r] in units of the white noise: (m + 1, samples, axis)
        logical, allocatable :: kept(:, :)          !! (samples, axis)
        real(dp), allocatable :: star_time(:)       !! Increasing, s
        real(dp), allocatable :: star(:, :, :)      !! [g, r] in units of the noise: (m + 1, 3, samples)
        logical, allocatable :: star_kept(:)        !! (samples)
        type(gauss_markov_t) :: process(3)          !! By axis, in units of the white noise
        type(process_filter_t) :: filter(3)         !! Of the processes and the samples kept when last used
    end type filter_problem_t

    !> A pole whose correlation time is longer than so many arcs cannot be told from a bias
    real(dp), parameter :: LONG_COMPARED_TO_ARC = 10

contains

    !> The flicker part of an accelerometer axis, in units of its white part.
    function flicker_process(noise, steps) result(process)
        type(coloured_noise_t), intent(in) :: noise
        integer, intent(in) :: steps                !! Of the arc
        type(gauss_markov_t) :: process

        real(dp) :: white_variance, correlation(N_POLES), variance(N_POLES)
        integer :: i

        call noise%markov_form(white_variance, correlation, variance)
        process = no_process()
        do i = 1, N_POLES
            if (.not. variance(i) > 0) cycle
            if (-log(correlation(i))*steps*LONG_COMPARED_TO_ARC < 1) cycle
            process = superposed(process, first_order_process(sqrt(variance(i)/white_variance), correlation(i)))
        end do
    end function flicker_process

    !> The samples of an axis, whitened by its process.
    pure subroutine whiten_axis(problem, axis, remainder)
        class(filter_problem_t), intent(inout) :: problem
        integer, intent(in) :: axis     !! 1, 2, 3
        real(dp), intent(out) :: remainder(:, :)        !! (m + 1, samples)

        call prepare_filter(problem%process(axis), problem%epoch, problem%kept(:, axis), problem%filter(axis))
        call whiten_by_process(problem%filter(axis), problem%acceleration(:, :, axis), remainder)
    end subroutine whiten_axis

    !> The samples of all axes.
    pure subroutine whiten(problem, remainder)
        class(filter_problem_t), intent(inout) :: problem
        real(dp), allocatable, intent(inout) :: remainder(:, :, :)      !! (m + 1, samples, axis)

        integer :: axis

        if (.not. allocated(remainder)) allocate (remainder(problem%m + 1, size(problem%epoch), 3))
        do axis = 1, 3
            call whiten_axis(problem, axis, remainder(:, :, axis))
        end do
    end subroutine whiten

    !> The constants from what is known a priori, the star camera and, if given, the axes' remainders, but for
    !> one axis if `without` names it.
    pure subroutine gather(problem, constants, remainder, without)
        class(filter_problem_t), intent(in) :: problem
        type(constants_t), intent(out) :: constants
        real(dp), intent(in), optional :: remainder(:, :, :)    !! (m + 1, samples, axis)
        integer, intent(in), optional :: without    !! The axis to leave out, 1, 2 or 3

        real(dp) :: stars(problem%m + 1, 3*size(problem%star_time))
        integer :: i, n, axis

        call gather_prior(problem, constants)
        n = 0
        do i = 1, size(problem%star_time)
            if (.not. problem%star_kept(i)) cycle
            stars(:, n + 1:n + 3) = problem%star(:, :, i)
            n = n + 3
        end do
        call constants%fold_in_all(stars(:, :n))
        if (.not. present(remainder)) return
        do axis = 1, 3
            if (present(without)) then
                if (axis == without) cycle
            end if
            call constants%fold_in_all(remainder(:, :, axis))
        end do
    end subroutine gather

    pure subroutine gather_prior(problem, constants)
        class(filter_problem_t), intent(in) :: problem
        type(constants_t), intent(out) :: constants

        integer :: i

        constants = new_constants(problem%m)
        do i = 1, problem%m
            call constants%fold_in(problem%prior(:, i))
        end do
        constants%squares = 0           ! of the observations alone
    end subroutine gather_prior

    !> The same in the order of time, with the estimate of the offset as it stands at every step.
    pure subroutine run_through_time(problem, remainder, nominal_offset, constants, running)
        class(filter_problem_t), intent(in) :: problem
        real(dp), intent(in) :: remainder(:, :, :)      !! (m + 1, samples, axis)
        real(dp), intent(in) :: nominal_offset(3)       !! About which the problem is linearised, m
        type(constants_t), intent(out) :: constants
        type(running_estimate_t), intent(out) :: running

        real(dp) :: covariance(3, 3), t
        integer :: k, i, star, axis, edited, edited_stars

        allocate (running%time(0:problem%steps), running%offset(3, 0:problem%steps), &
                  running%sigma(3, 0:problem%steps), running%edited_accelerometer(0:problem%steps), &
                  running%edited_star_camera(0:problem%steps))
        call gather_prior(problem, constants)
        i = 1
        star = 1
        edited = 0
        edited_stars = 0
        do k = 0, problem%steps
            t = k*problem%interval
            do while (star <= size(problem%star_time))
                if (problem%star_time(star) > t + problem%interval/2 .and. k < problem%steps) exit
                do axis = 1, merge(3, 0, problem%star_kept(star))
                    call constants%fold_in(problem%star(:, axis, star))
                end do
                if (.not. problem%star_kept(star)) edited_stars = edited_stars + 1
                star = star + 1
            end do
            do while (i <= size(problem%epoch))
                if (problem%epoch(i) > k) exit
                do axis = 1, 3
                    if (problem%kept(i, axis)) call constants%fold_in(remainder(:, i, axis))
                    if (.not. problem%kept(i, axis)) edited = edited + 1
                end do
                i = i + 1
            end do
            running%time(k) = t
            call constants%last_covariance(running%offset(:, k), covariance)
            running%offset(:, k) = running%offset(:, k) + nominal_offset
            running%sigma(:, k) = [(sqrt(covariance(axis, axis)), axis=1, 3)]
            running%edited_accelerometer(k) = edited
            running%edited_star_camera(k) = edited_stars
        end do
    end subroutine run_through_time

    !> What smoothing tells of one axis: its process at every sample, and how far the sample is from what
    !> all others predict, as a chi-square with one degree of freedom ("deletion residual": P. de Jong,
    !> J. Penzer, J. Am. Stat. Assoc. 93 (1998) 796-806). With the smoothed errors u of the partials and the observation
    !> (gracecg_estimation_process_smoother), e = u_r - u_g y and V = u_g C u_g^T, y the constants and C their covariance,
    !> that is e^2/(D - V) of a sample in use and (e/D)^2/(1/D + V/D^2) of one that is left out.
    subroutine smooth_axis(problem, axis, constants, signals, disturbance, residual, chi_square)
        class(filter_problem_t), intent(inout) :: problem
        integer, intent(in) :: axis    !! 1, 2, 3
        type(constants_t), intent(in) :: constants      !! After all observations
        real(dp), intent(in) :: signals(:, :)           !! Of the process' states those wanted: h, a part of it; by column
        real(dp), intent(out) :: disturbance(:, :)      !! signals^T p, (signals, samples), white noise = 1
        real(dp), intent(out) :: residual(:)            !! Smoothed residuals; of one left out against the others
        real(dp), intent(out) :: chi_square(:)          !! (samples)

        real(dp), allocatable :: rows(:, :), root(:, :)
        real(dp), dimension(size(problem%epoch)) :: errors, information
        real(dp) :: y(problem%m), through(problem%m, size(problem%epoch)), spread
        integer, allocatable :: seen(:)
        integer :: i, n

        y = constants%solution()
        root = constants%inverse_root()
        seen = nonzero_rows(problem%acceleration(:problem%m, :, axis))
        n = size(seen)
        rows = problem%acceleration([seen, problem%m + 1], :, axis)
        associate (process => problem%process(axis), kept => problem%kept(:, axis))
            call prepare_filter(process, problem%epoch, kept, problem%filter(axis))
            call smooth_errors(problem%filter(axis), rows, information)
            errors = rows(n + 1, :) - matmul(y(seen), rows(:n, :))
            call sum_of_products(problem%m, size(problem%epoch), n, transpose(root(seen, :)), transpose(rows(:n, :)), through)
            do i = 1, size(problem%epoch)
                spread = sum(through(:, i)**2)
                associate (d => information(i))
                    if (kept(i)) then
                        residual(i) = errors(i)
                        chi_square(i) = errors(i)**2/max(d - spread, epsilon(d)*d)
                    else
                        residual(i) = errors(i)/d
                        chi_square(i) = residual(i)**2/(1/d + spread/d**2)
                    end if
                end associate
            end do
            call smooth_signals(process, problem%epoch, kept, errors, signals, disturbance)
        end associate
    end subroutine smooth_axis

    !> The same of the star camera: a chi-square with three degrees of freedom of every sample against
    !> all others, e^T (I - V)^-1 e, or e^T (I + V)^-1 e of one that is not kept.
    subroutine smooth_star_camera(problem, constants, chi_square)
        class(filter_problem_t), intent(in) :: problem
        type(constants_t), intent(in) :: constants
        real(dp), intent(out) :: chi_square(:)          !! (samples)

        type(information_t) :: information
        type(error_t), allocatable :: not_positive
        real(dp) :: y(problem%m), root(problem%m, problem%m), left(3, problem%m), v(3, 3), e(3)
        integer :: i

        y = constants%solution()
        root = constants%inverse_root()
        do i = 1, size(problem%star_time)
            associate (rows => problem%star(:, :, i))
                e = rows(problem%m + 1, :) - matmul(y, rows(:problem%m, :))
                left = matmul(transpose(rows(:problem%m, :)), root)
            end associate
            v = identity(3) + merge(-1, 1, problem%star_kept(i))*matmul(left, transpose(left))
            call information_of(e, v, information, not_positive)
            chi_square(i) = merge(huge(1.0_dp), information%squares, allocated(not_positive))
        end do
    end subroutine smooth_star_camera
end module gracecg_estimation_linearised_samples
