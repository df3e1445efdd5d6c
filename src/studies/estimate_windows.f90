!> The axis windows of Figures 6.2, 6.3 and 6.6 of CSR-TM-00-01, whose points are estimates of 15 runs, against
!> estimates of the same cases.
!>
!> The report's own points all lie inside, by the choice of the axes. A further point of the same distribution lies
!> beyond the range of n others with probability 2/(n + 1): 1 in 8 for the 15 points of the case that scatters most,
!> and hardly ever for those of the other cases. Rounding to tick marks makes it less.
module gracecg_studies_estimate_windows
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES, MILLIMETRE
    use gracecg_files_data_table, only: data_table_t
    use gracecg_estimation_estimators, only: REPORT_ESTIMATORS
    use gracecg_simulation_report_cases, only: SATELLITES
    use gracecg_studies_published, only: limits_on_ticks, same_limits, share_covered, published_axis
    use gracecg_studies_campaign, only: campaign_t
    use gracecg_studies_magnetometer_loss, only: field_study_t, LOSS_ALGORITHMS
    implicit none
    private
    public :: estimate_window_t, campaign_windows, loss_windows, estimate_windows_table
    public :: LEAST_SHARE_INSIDE, POINTS_OF_CASE

    integer, parameter :: POINTS_OF_CASE = 15           !! Runs in each of these figures
    integer, parameter :: CASES_OF_SATELLITE = 3        !! In Figures 6.2 and 6.3
    real(dp), parameter :: LEAST_SHARE_INSIDE = 1 - 2.0_dp/(POINTS_OF_CASE + 1)/CASES_OF_SATELLITE
    !! Of further points of the same distribution, when one case of three sets the range: 0.958

    !> The points of one panel against its window.
    type :: estimate_window_t
        character(4) :: figure = ''         !! '6.2', '6.3' or '6.6'
        character(5) :: satellite = ''      !! 'front' or 'back'
        character(16) :: algorithm = ''     !! One of REPORT_ESTIMATORS
        character(1) :: axis = ''           !! Body axis
        real(dp) :: low = 0, high = 0       !! The printed axis limits, m
        real(dp) :: step = 0                !! Distance of the printed tick marks, m
        integer :: points = 0               !! Estimates, of all runs
        integer :: inside = 0               !! Of these
        real(dp) :: least = 0, greatest = 0 !! Of the first POINTS_OF_CASE runs, m
        real(dp) :: fill = 0                !! Share of the window that those cover
        logical :: on_ticks = .false.       !! The tick marks next outside those are the printed limits
    end type estimate_window_t

contains

    !> Figure 6.2 or 6.3: cases 1 to 3 of a satellite, a panel each algorithm and axis. The campaign has the report's
    !> cases in their order, with its algorithms, and at least POINTS_OF_CASE runs.
    pure function campaign_windows(campaign, satellite) result(windows)
        type(campaign_t), intent(in) :: campaign
        integer, intent(in) :: satellite            !! 1 front, 2 back
        type(estimate_window_t) :: windows(3*size(REPORT_ESTIMATORS))

        character(3), parameter :: FIGURES(2) = ['6.2', '6.3']
        real(dp), allocatable :: points(:, :)
        integer :: a, axis, i, n

        n = size(campaign%entries(1, 1)%run)
        allocate (points(n, CASES_OF_SATELLITE))
        do a = 1, size(REPORT_ESTIMATORS)
            do axis = 1, 3
                do i = 1, CASES_OF_SATELLITE
                    points(:, i) = campaign%entries(a, (satellite - 1)*CASES_OF_SATELLITE + i)%offset(axis, :)*MILLIMETRE
                end do
                windows(3*(a - 1) + axis) = window_of(FIGURES(satellite), SATELLITES(satellite), trim(REPORT_ESTIMATORS(a)), &
                                                      axis, points)
            end do
        end do
    end function campaign_windows

    !> Figure 6.6: two cases with measured and with modelled field, a panel each algorithm and axis. The studies are
    !> those of the front satellite, with at least POINTS_OF_CASE runs.
    pure function loss_windows(studies) result(windows)
        type(field_study_t), intent(in) :: studies(:)   !! Of `study_magnetometer_loss`
        type(estimate_window_t) :: windows(3*size(LOSS_ALGORITHMS))

        real(dp), allocatable :: points(:, :)
        integer, allocatable :: of_algorithm(:)
        integer :: a, axis, i

        do a = 1, size(LOSS_ALGORITHMS)
            of_algorithm = pack([(i, i=1, size(studies))], studies%algorithm == LOSS_ALGORITHMS(a))
            allocate (points(size(studies(1)%run), size(of_algorithm)))
            do axis = 1, 3
                do i = 1, size(of_algorithm)
                    points(:, i) = studies(of_algorithm(i))%offset(axis, :)
                end do
                windows(3*(a - 1) + axis) = window_of('6.6', 'front', LOSS_ALGORITHMS(a), axis, points)
            end do
            deallocate (points)
        end do
    end function loss_windows

    pure function window_of(figure, satellite, algorithm, axis, points) result(window)
        character(*), intent(in) :: figure, satellite, algorithm
        integer, intent(in) :: axis
        real(dp), intent(in) :: points(:, :)        !! (runs, cases), m
        type(estimate_window_t) :: window

        real(dp) :: limits(3)

        limits = published_axis(figure, satellite, algorithm, AXES(axis))
        window%figure = figure
        window%satellite = satellite
        window%algorithm = algorithm
        window%axis = AXES(axis)
        window%low = limits(1)
        window%high = limits(2)
        window%step = limits(3)
        window%points = size(points)
        window%inside = count(points >= window%low .and. points <= window%high)
        window%least = minval(points(:POINTS_OF_CASE, :))
        window%greatest = maxval(points(:POINTS_OF_CASE, :))
        window%fill = share_covered(window%least, window%greatest, window%low, window%high)
        window%on_ticks = same_limits(limits_on_ticks(window%least, window%greatest, window%step), limits(:2), window%step)
    end function window_of

    !> The panels of Figures 6.2, 6.3 and 6.6, a row each.
    function estimate_windows_table(windows) result(table)
        type(estimate_window_t), intent(in) :: windows(:)
        type(data_table_t) :: table

        integer :: i

        call table%columns_of('figure,satellite,algorithm,axis,low_mm,high_mm,least_mm,greatest_mm,fill,points,inside,on_ticks')
        do i = 1, size(windows)
            associate (w => windows(i))
                call table%add(w%figure, w%satellite, w%algorithm, w%axis)
                call table%add([[w%low, w%high, w%least, w%greatest]/MILLIMETRE, w%fill, real([w%points, w%inside], dp)])
                call table%add(w%on_ticks)
            end associate
        end do
    end function estimate_windows_table
end module gracecg_studies_estimate_windows
