!> Simulated years of a mission: an offset that walks at random, masses that are moved, gas that the tanks lose, and
!> calibrations of a given accuracy; how well the history knows the offset at any time, and whether it knows how well.
module gracecg_studies_history_check
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t
    use gracecg_base_lapack, only: symmetric_eigen
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_environment_time, only: utc_t, utc_plus, seconds_between
    use gracecg_estimation_information, only: squares_of
    use gracecg_estimation_offset_change, only: offset_change_t, is_between
    use gracecg_estimation_offset_history, only: history_settings_t, tank_series_t, offset_history_t, trace_offset, YEAR
    use gracecg_estimation_saved_estimate, only: dated_offset_t
    implicit none
    private
    public :: mission_t, history_check_t, check_history

    integer, parameter :: STREAM_MISSION = 32       !! Random numbers of a mission

    !> A mission that is simulated many times.
    type :: mission_t
        type(utc_t) :: start = utc_t(52350, 0.0_dp)     !! 2002-03-17, the launch of GRACE
        real(dp) :: years = 5    !! Its length
        real(dp) :: spacing = 0.5_dp                    !! Of the calibrations, years
        real(dp) :: covariance(3, 3) = 0                !! Of each calibration, m^2
        type(offset_change_t), allocatable :: changes(:)    !! As they are known: the true ones differ by their sigmas
    end type mission_t

    !> What came out, over all times of all runs.
    type :: history_check_t
        real(dp) :: filtered(3) = 0         !! RMS error of the filter, m
        real(dp) :: smoothed(3) = 0         !! RMS error of the smoother, m
        real(dp) :: filtered_squares = 0    !! Mean normalised square of the error: 3 if the covariance is honest
        real(dp) :: smoothed_squares = 0    !! The same of the smoother
        real(dp) :: worst(3) = 0            !! RMS error of the filter just before a calibration, m
        real(dp) :: statistic = 0           !! Mean of the histories' chi square over its degrees of freedom: 1
    end type history_check_t

contains

    !> Simulates the mission many times. Fails when a covariance is singular.
    subroutine check_history(mission, settings, runs, seed, result, error)
        type(mission_t), intent(in) :: mission
        type(history_settings_t), intent(in) :: settings
        integer, intent(in) :: runs    !! Missions that are simulated
        integer(i8), intent(in) :: seed             !! Of the random numbers
        type(history_check_t), intent(out) :: result
        type(error_t), allocatable, intent(out) :: error

        type(random_stream_t) :: stream
        type(dated_offset_t), allocatable :: offsets(:)
        type(offset_history_t) :: history
        type(offset_change_t), allocatable :: changes(:)
        type(history_settings_t) :: own
        type(tank_series_t) :: no_tanks
        real(dp), allocatable :: truth(:, :)
        real(dp) :: root(3, 3), values(3), vectors(3, 3), noise(3)
        integer :: run, i, k, n, last, counted, before

        own = settings
        own%futures = 1
        call symmetric_eigen(mission%covariance, values, vectors, error)
        if (allocated(error)) return
        root = vectors*spread(sqrt(max(0.0_dp, values)), 1, 3)
        allocate (changes(0))
        if (allocated(mission%changes)) changes = mission%changes
        last = nint(mission%years/mission%spacing)
        counted = 0
        before = 0
        do run = 1, runs
            stream = new_stream(seed, 0, 0, run, STREAM_MISSION)
            ! the times of the history, from a first pass without values
            if (run == 1) then
                allocate (offsets(last + 1))
                do i = 0, last
                    offsets(i + 1)%time = utc_plus(mission%start, i*mission%spacing*YEAR)
                    offsets(i + 1)%covariance = mission%covariance
                end do
                call trace_offset(offsets, changes, no_tanks, own, history, error)
                if (allocated(error)) return
            end if
            associate (points => history%points)
                n = size(points)
                if (.not. allocated(truth)) allocate (truth(3, n))
                call stream%normals(noise)
                truth(:, 1) = 0.3e-3_dp*noise
                do i = 2, n
                    call stream%normals(noise)
                    truth(:, i) = truth(:, i - 1) + noise*settings%walk* &
                                  sqrt(seconds_between(points(i - 1)%time, points(i)%time)/YEAR)
                end do
                do k = 1, size(changes)
                    call stream%normals(noise)
                    do i = 1, n
                        if (is_between(changes(k), mission%start, points(i)%time)) &
                            truth(:, i) = truth(:, i) + changes(k)%change + changes(k)%sigma*noise
                    end do
                end do
                k = 0
                do i = 1, n
                    if (.not. points(i)%is_calibration) cycle
                    k = k + 1
                    call stream%normals(noise)
                    offsets(k)%offset = truth(:, i) + matmul(root, noise)
                end do
            end associate
            call trace_offset(offsets, changes, no_tanks, own, history, error)
            if (allocated(error)) return
            call add_run()
            if (allocated(error)) return
        end do
        result%filtered = sqrt(result%filtered/counted)
        result%smoothed = sqrt(result%smoothed/counted)
        result%filtered_squares = result%filtered_squares/counted
        result%smoothed_squares = result%smoothed_squares/counted
        result%worst = sqrt(result%worst/before)
        result%statistic = result%statistic/runs

    contains

        subroutine add_run()
            integer :: j

            do j = 1, size(history%points)
                associate (point => history%points(j), true => truth(:, j))
                    counted = counted + 1
                    result%filtered = result%filtered + (point%filtered - true)**2
                    result%smoothed = result%smoothed + (point%smoothed - true)**2
                    result%filtered_squares = result%filtered_squares + squares_of(point%filtered - true, point%filtered_covariance)
                    result%smoothed_squares = result%smoothed_squares + squares_of(point%smoothed - true, point%smoothed_covariance)
                    if (j == size(history%points)) cycle
                    if (.not. history%points(j + 1)%is_calibration .or. point%is_calibration) cycle
                    before = before + 1
                    result%worst = result%worst + (point%filtered - true)**2
                end associate
            end do
            result%statistic = result%statistic + history%statistic/history%degrees
        end subroutine add_run
    end subroutine check_history
end module gracecg_studies_history_check
