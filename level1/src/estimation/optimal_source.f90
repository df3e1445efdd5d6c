!> The offset from Level-1 data by the library's own estimator: all spans as arcs of one fit (gracecg_estimation_arcs), with
!> gains and delay of the rods, delay and angular channels of the accelerometer, leakage and all of an arc's own.
module gracecg_level1_optimal_source
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_observations_parameters
    use gracecg_estimation_arcs, only: arcs_fit_t, estimate_arcs
    use gracecg_estimation_information, only: information_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_level1_calibration, only: level1_calibration_t
    use gracecg_level1_gyros, only: gyro_axes_t
    use gracecg_level1_offset_solution, only: level1_solution_t
    use gracecg_level1_setup, only: level1_setup_t
    use gracecg_level1_to_observations, only: arcs_of_spans
    implicit none
    private
    public :: solve_optimal

    integer, parameter :: OF_ARC(*) = [ATTITUDE_ANGLES, RATE, TORQUE, TORQUE_CHANGE, TORQUE_BENDS, DRIFT, BIAS, FORCE_BENDS, &
                                       FIELD_BIAS]
    integer, parameter :: OF_ALL(*) = [OFFSET, SCALE_FACTORS, ROD_GAINS, ALL_RODS_DELAY, LEAKAGE, LEAKAGE_RATE]
    integer, parameter :: OF_CHANNELS(*) = [SAMPLING_DELAY, CHANNEL_SCALES, CHANNEL_LEAKAGE, CHANNEL_LEAKAGE_RATE]
    real(dp), parameter :: ANY_DELAY = 1            !! A-priori standard deviations of what nobody knows, s
    real(dp), parameter :: ANY_CHANNEL = 1          !! Of a scale of the channels
    real(dp), parameter :: ANY_CHANNEL_LEAKAGE = 1e-6_dp    !! rad/s^2 by A m^2, or A m^2/s
    real(dp), parameter :: FREE = 100               !! Times the a-priori leakage: weighs nothing
    real(dp), parameter :: UNDECIDED = 2            !! Sigma without over with a-priori leakage: the data do not decide

contains

    !> The offset. Fails where currents are held from tag to tag, or leakage is not to be estimated: that is not modelled.
    subroutine solve_optimal(calibration, setup, axes, leakage, held, solution, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(gyro_axes_t), intent(in) :: axes       !! Of the gyros
        character(*), intent(in) :: leakage         !! estimate, prior or none
        logical, intent(in) :: held                 !! The currents are
        type(level1_solution_t), intent(inout) :: solution  !! Its source is kept
        type(error_t), allocatable, intent(out) :: error

        type(arcs_fit_t) :: fit
        integer, allocatable :: span_of(:)
        real(dp) :: bounded(3)

        if (held) then
            call fail(error, 'it takes currents as smooth, and these are held from tag to tag')
        else if (leakage == 'none') then
            call fail(error, 'it always estimates the leakage')
        end if
        if (allocated(error)) return
        solution%leakage = 'a priori'
        if (leakage == 'estimate') then
            call fit_spans(calibration, setup, axes, FREE, fit, span_of, error)
            if (allocated(error)) return
            call sigma_with_prior(fit, setup, bounded)
            solution%sigma_free = sigmas(fit)
            if (all(solution%sigma_free <= UNDECIDED*bounded)) solution%leakage = 'estimated'
        end if
        if (solution%leakage == 'a priori') call fit_spans(calibration, setup, axes, 1.0_dp, fit, span_of, error)
        if (.not. allocated(error) .and. .not. fit%converged) call fail(error, 'the delays do not settle')
        if (.not. allocated(error)) call take(calibration, setup, fit, span_of, solution)
    end subroutine solve_optimal

    !> One fit of all spans with the leakage known to a multiple of its a-priori standard deviation.
    subroutine fit_spans(calibration, setup, axes, times, fit, span_of, error)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(gyro_axes_t), intent(in) :: axes
        real(dp), intent(in) :: times               !! The a-priori leakage
        type(arcs_fit_t), intent(out) :: fit
        integer, allocatable, intent(out) :: span_of(:)     !! The span of each arc
        type(error_t), allocatable, intent(out) :: error

        type(observation_set_t), allocatable :: sets(:)
        integer, allocatable :: own(:), shared(:)
        real(dp), allocatable :: prior(:)

        call arcs_of_spans(calibration, setup, axes, sets, span_of, error)
        if (allocated(error)) return
        if (size(sets) == 0) then
            call fail(error, 'no span is long enough')
            return
        end if
        own = OF_ARC
        shared = OF_ALL
        prior = [spread(0.0_dp, 1, 3), spread(setup%scale_sigma, 1, 3), spread(setup%gain_sigma, 1, 3), ANY_DELAY, &
                 spread(times*by_moment(setup, setup%leakage_prior(1)), 1, 9), &
                 spread(times*by_moment(setup, setup%leakage_prior(2)), 1, 9)]
        if (calibration%has_angular) then
            own = [own, CHANNEL_BIAS, CHANNEL_DRIFT]
            shared = [shared, OF_CHANNELS]
            prior = [prior, ANY_DELAY, spread(ANY_CHANNEL, 1, 9), spread(ANY_CHANNEL_LEAKAGE, 1, 18)]
        end if
        if (axes%known) then
            own = [own, MOUNTING_2, HEAD_DRIFT]
            shared = [shared, HEAD_DELAY]
            prior = [prior, ANY_DELAY]
        end if
        call estimate_arcs(sets, estimation_options_t(), shared, prior, own, fit, error)
    end subroutine fit_spans

    !> Leakage by the moment of the weakest rod, from that by its current.
    pure real(dp) function by_moment(setup, by_current)
        type(level1_setup_t), intent(in) :: setup
        real(dp), intent(in) :: by_current          !! m/s^2/mA, or m/s^2/(mA/s)

        by_moment = max(by_current, tiny(by_current))/minval(setup%rod_gain)
    end function by_moment

    pure function sigmas(fit)
        type(arcs_fit_t), intent(in) :: fit
        real(dp) :: sigmas(3)                       !! Of the offset, m

        integer :: k

        sigmas = [(sqrt(fit%covariance(k, k)), k=1, 3)]
    end function sigmas

    !> What sigma would be if the leakage had its a-priori standard deviation, m.
    subroutine sigma_with_prior(fit, setup, sigma)
        type(arcs_fit_t), intent(in) :: fit
        type(level1_setup_t), intent(in) :: setup
        real(dp), intent(out) :: sigma(3)

        type(information_t) :: information
        type(error_t), allocatable :: singular
        real(dp) :: step(size(fit%shared)), covariance(size(fit%shared), size(fit%shared))
        integer :: k

        information = fit%information
        do k = 1, size(fit%shared)
            select case (KIND_OF(fit%shared(k)))
            case (OF_OFFSET)
                continue
            case (OF_LEAKAGE)
                call information%expect(k, by_moment(setup, setup%leakage_prior(1)))
            case (OF_LEAKAGE_RATE)
                call information%expect(k, by_moment(setup, setup%leakage_prior(2)))
            case (OF_SCALE_FACTORS)
                call information%expect(k, setup%scale_sigma)
            case default
                call information%expect(k, ANY_CHANNEL)
            end select
        end do
        call information%solve(step, covariance, singular)
        sigma = 0
        if (.not. allocated(singular)) sigma = sqrt([(covariance(k, k), k=1, 3)])
    end subroutine sigma_with_prior

    !> The fit as a solution among those by sources.
    subroutine take(calibration, setup, fit, span_of, solution)
        type(level1_calibration_t), intent(in) :: calibration
        type(level1_setup_t), intent(in) :: setup
        type(arcs_fit_t), intent(in) :: fit
        integer, intent(in) :: span_of(:)
        type(level1_solution_t), intent(inout) :: solution

        integer :: i, k, axis, rod

        solution%offset = fit%value(:3)
        solution%covariance = fit%covariance(:3, :3)
        solution%formal = solution%covariance
        solution%rms = fit%rms
        solution%samples = fit%samples
        solution%condition = 0                      ! not looked at: the a-priori knowledge keeps it sound
        solution%whiteness = 1                      ! the noise has the spectrum of the residuals
        solution%chi_square = fit%chi_square
        solution%degrees = fit%degrees
        do k = 1, 9
            axis = (k + 2)/3
            rod = mod(k - 1, 3) + 1
            associate (kappa => setup%rod_gain(rod)*setup%rod_sign(rod), l => findloc(fit%shared, LEAKAGE(k), 1), &
                       r => findloc(fit%shared, LEAKAGE_RATE(k), 1))
                solution%leak(axis, rod) = kappa*fit%value(l)
                solution%leak_sigma(axis, rod) = abs(kappa)*sqrt(fit%covariance(l, l))
                solution%leak_rate(axis, rod) = kappa*fit%value(r)
                solution%leak_rate_sigma(axis, rod) = abs(kappa)*sqrt(fit%covariance(r, r))
            end associate
        end do
        allocate (solution%span_offset(3, size(calibration%spans)), solution%span_rms(3, size(calibration%spans)), &
                  source=0.0_dp)
        allocate (solution%span_sigma(3, size(calibration%spans)), source=-1.0_dp)
        do i = 1, size(calibration%spans)
            solution%spans = solution%spans + merge(1, 0, any(span_of == i))
            if (count(span_of == i) /= 1) cycle     ! none, or cut by a firing
            associate (arc => findloc(span_of, i, 1))
                solution%span_offset(:, i) = fit%arc_offset(:, arc)
                solution%span_sigma(:, i) = [(sqrt(fit%arc_covariance(k, k, arc)), k=1, 3)]
                solution%span_rms(:, i) = fit%rms
            end associate
        end do
    end subroutine take
end module gracecg_level1_optimal_source
