!> Simulated years of a mission: an offset that walks at random, and calibrations of a given accuracy; how well the history
!> knows the offset at any time, and whether it knows how well.
module mission_check
    use vocabulary
    use gracecg_base_constants, only: YEAR => JULIAN_YEAR
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_environment_time, only: utc_t, utc_plus, seconds_between
    use gracecg_estimation_information, only: squares_of
    use gracecg_estimation_offset_change, only: offset_change_t
    use gracecg_estimation_offset_history, only: history_settings_t, tank_series_t, offset_history_t, trace_offset
    use gracecg_estimation_saved_estimate, only: dated_offset_t
    implicit none
    private
    public :: mission_result_t, check_mission

    integer, parameter :: STREAM_MISSION = 32                       !! Random numbers of a mission
    type(utc_t), parameter :: START = utc_t(52350, 0.0_dp)          !! 2002-03-17, the launch of GRACE
    real(dp), parameter :: YEARS = 5, SPACING = 0.5_dp              !! Length; between calibrations, years
    real(dp), parameter :: FIRST_SIGMA = 0.3e-3_dp                  !! Of the first offset, m

    !> What came out, over all times of all runs.
    type :: mission_result_t
        real(dp) :: filtered(3) = 0, smoothed(3) = 0    !! RMS errors of filter and smoother, m
        real(dp) :: filtered_squares = 0, smoothed_squares = 0
        !! Mean normalised squares of their errors: 3 if the covariance is honest
        real(dp) :: worst(3) = 0            !! RMS error of the filter just before a calibration, m
        real(dp) :: statistic = 0           !! Mean of the histories' chi square over its degrees of freedom: 1
        integer :: times = 0, before = 0    !! That were counted; of `worst`
    end type mission_result_t

contains

    !> Simulates the mission many times. Fails when a covariance is singular.
    subroutine check_mission(covariance, settings, runs, seed, result, error)
        real(dp), intent(in) :: covariance(3, 3)    !! Of each calibration, m^2
        type(history_settings_t), intent(in) :: settings
        integer, intent(in) :: runs                 !! Missions that are simulated
        integer(i8), intent(in) :: seed             !! Of the random numbers
        type(mission_result_t), intent(out) :: result
        type(error_t), allocatable, intent(out) :: error
        type(dated_offset_t) :: offsets(nint(YEARS/SPACING) + 1)
        type(offset_history_t) :: history
        type(offset_change_t) :: no_changes(0)
        type(history_settings_t) :: own
        type(tank_series_t) :: no_tanks
        real(dp), allocatable :: truth(:, :)
        real(dp) :: root(3, 3), values(3), vectors(3, 3)
        integer :: run, i

        own = settings
        own%futures = 1
        call symmetric_eigen(covariance, values, vectors, error)
        if (allocated(error)) return
        root = vectors*spread(sqrt(max(0.0_dp, values)), 1, 3)
        do i = 1, size(offsets)
            offsets(i)%time = utc_plus(START, (i - 1)*SPACING*YEAR)
            offsets(i)%covariance = covariance
        end do
        ! the times of the history, from a first pass without values
        call trace_offset(offsets, no_changes, no_tanks, own, history, error)
        do run = 1, runs
            call draw(new_stream(seed, 0, 0, run, STREAM_MISSION), root, own, history, truth, offsets)
            call trace_offset(offsets, no_changes, no_tanks, own, history, error)
            if (.not. allocated(error)) call add_run(history, truth, result)
        end do
        result%filtered = sqrt(result%filtered/result%times)
        result%smoothed = sqrt(result%smoothed/result%times)
        result%filtered_squares = result%filtered_squares/result%times
        result%smoothed_squares = result%smoothed_squares/result%times
        result%worst = sqrt(result%worst/result%before)
        result%statistic = result%statistic/runs
    end subroutine check_mission

    !> The true offset at the times of a history, and what the calibrations find.
    subroutine draw(random, root, settings, history, truth, offsets)
        type(random_stream_t), intent(in) :: random
        real(dp), intent(in) :: root(3, 3)          !! Of the covariance of a calibration, m
        type(history_settings_t), intent(in) :: settings
        type(offset_history_t), intent(in) :: history
        real(dp), allocatable, intent(out) :: truth(:, :)       !! (axis, time), m
        type(dated_offset_t), intent(inout) :: offsets(:)
        type(random_stream_t) :: stream
        real(dp) :: noise(3)
        integer :: i, k

        stream = random
        associate (points => history%points)
            allocate (truth(3, size(points)))
            call stream%normals(noise)
            truth(:, 1) = FIRST_SIGMA*noise
            do i = 2, size(points)
                call stream%normals(noise)
                truth(:, i) = truth(:, i - 1) + noise*settings%walk* &
                              sqrt(seconds_between(points(i - 1)%time, points(i)%time)/YEAR)
            end do
            k = 0
            do i = 1, size(points)
                if (.not. points(i)%is_calibration) cycle
                k = k + 1
                call stream%normals(noise)
                offsets(k)%offset = truth(:, i) + matmul(root, noise)
            end do
        end associate
    end subroutine draw

    !> Adds the errors of a history.
    subroutine add_run(history, truth, result)
        type(offset_history_t), intent(in) :: history
        real(dp), intent(in) :: truth(:, :)
        type(mission_result_t), intent(inout) :: result
        real(dp) :: filtered(3), smoothed(3)
        integer :: j

        do j = 1, size(history%points)
            associate (point => history%points(j))
                filtered = point%filtered - truth(:, j)
                smoothed = point%smoothed - truth(:, j)
                result%times = result%times + 1
                result%filtered = result%filtered + filtered**2
                result%smoothed = result%smoothed + smoothed**2
                result%filtered_squares = result%filtered_squares + squares_of(filtered, point%filtered_covariance)
                result%smoothed_squares = result%smoothed_squares + squares_of(smoothed, point%smoothed_covariance)
                if (j == size(history%points)) cycle
                if (.not. history%points(j + 1)%is_calibration .or. point%is_calibration) cycle
                result%before = result%before + 1
                result%worst = result%worst + filtered**2
            end associate
        end do
        result%statistic = result%statistic + history%statistic/history%degrees
    end subroutine add_run
end module mission_check
