!> Horizontal wind: the embedded table, its interpolation, and the reader of such tables.
module test_wind
    use vocabulary
    use gracecg_environment_wind
    implicit none
    private
    public :: collect_wind

    character(*), parameter :: FIXTURES = 'test/fixtures/wind'

contains

    subroutine collect_wind(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('constant-wind', test_constant), &
                    new_unittest('embedded-at-points-of-hwm93', test_hwm93), &
                    new_unittest('cyclic-in-local-time', test_cyclic), &
                    new_unittest('continuous-and-linear', test_linear), &
                    new_unittest('file-of-the-user', test_file), &
                    new_unittest('corrupted-files', test_corrupted)]
    end subroutine collect_wind

    !> [east, north] at a latitude in deg and a local time in h.
    function wind_at(model, latitude, local_solar_time) result(wind)
        class(wind_model_t), intent(in) :: model
        real(dp), intent(in) :: latitude, local_solar_time
        real(dp) :: wind(2)

        call model%evaluate(latitude*DEGREE, local_solar_time, wind(1), wind(2))
    end function wind_at

    subroutine test_constant(error)
        type(error_type), allocatable, intent(out) :: error

        call check(error, all(abs(wind_at(constant_wind_t(42.0_dp, -3.0_dp), 12.0_dp, 5.0_dp) - &
                                  [42.0_dp, -3.0_dp]) <= 0))
        call check(error, all(abs(wind_at(constant_wind_t(), 12.0_dp, 5.0_dp)) <= 0))
    end subroutine test_constant

    !> Runs of HWM93 itself. On a grid point the table is exact to its digits; between, the
    !> interpolation is within 3 m/s.
    subroutine test_hwm93(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: GRID(4, 2) = reshape([ &
            45.0_dp, 0.0_dp, 1.7906_dp, -62.1103_dp, &
            -60.0_dp, 10.0_dp, -174.5056_dp, -62.4998_dp], [4, 2])
        real(dp), parameter :: BETWEEN(4, 3) = reshape([ &
            0.0_dp, 17.2267_dp, 54.0687_dp, -1.7071_dp, &
            10.0_dp, 4.4667_dp, 111.0188_dp, -8.0427_dp, &
            0.0_dp, 5.2267_dp, 52.3192_dp, 16.4254_dp], [4, 3])
        type(tabulated_wind_t) :: wind, smooth
        integer :: i

        wind = embedded_wind()
        do i = 1, size(GRID, 2)
            call check(error, all(abs(wind_at(wind, GRID(1, i), GRID(2, i)) - GRID(3:4, i)) &
                       < 0.0051_dp))
        end do
        do i = 1, size(BETWEEN, 2)
            call check(error, all(abs(wind_at(wind, BETWEEN(1, i), BETWEEN(2, i)) - &
                                         BETWEEN(3:4, i)) < 3))
        end do
        ! Smooth: the same on grid points and half-way between; slopes go on across a grid line, where straight lines bend.
        smooth = embedded_wind(smooth=.true.)
        call check(error, norm2(wind_at(smooth, 45.0_dp, 3.0_dp) - wind_at(wind, 45.0_dp, 3.0_dp)), 0.0_dp, thr=1e-12_dp)
        call check(error, norm2(wind_at(smooth, 47.5_dp, 3.5_dp) - wind_at(wind, 47.5_dp, 3.5_dp)), 0.0_dp, thr=1e-12_dp)
        call check(error, bend_of(smooth) < 1e-2_dp .and. bend_of(wind) > 1, 'no kinks')

    contains

        !> Change of the slope at 45 deg, 3 h, m/s by 5 deg.
        real(dp) function bend_of(table) result(bend)
            type(tabulated_wind_t), intent(in) :: table
            real(dp), parameter :: STEP = 1e-4_dp       ! deg

            bend = norm2(wind_at(table, 45 + STEP, 3.0_dp) - 2*wind_at(table, 45.0_dp, 3.0_dp) + &
                         wind_at(table, 45 - STEP, 3.0_dp))/STEP*5
        end function bend_of
    end subroutine test_hwm93

    subroutine test_cyclic(error)
        type(error_type), allocatable, intent(out) :: error
        type(tabulated_wind_t) :: wind
        real(dp) :: t
        integer :: i

        wind = embedded_wind()
        do i = 0, 48
            t = 0.5_dp*i
            call check(error, all(abs(wind_at(wind, 37.0_dp, t) - wind_at(wind, 37.0_dp, t - 24)) &
                       < 1e-9_dp))
        end do
        call check(error, all(abs(wind_at(wind, 37.0_dp, 24 - 1e-9_dp) - &
                                     wind_at(wind, 37.0_dp, 0.0_dp)) < 1e-6_dp))
    end subroutine test_cyclic

    !> Continuous where cells meet, linear within them, up to the poles.
    subroutine test_linear(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: H = 1e-8_dp
        type(tabulated_wind_t) :: wind
        real(dp) :: middle(2)
        integer :: i

        wind = embedded_wind()
        do i = -85, 85, 5
            call check(error, all(abs(wind_at(wind, i + H, 7.0_dp + H) - &
                                         wind_at(wind, i - H, 7.0_dp - H)) < 1e-5_dp))
        end do
        do i = -90, 85, 5
            middle = (wind_at(wind, i + 0.0_dp, 7.0_dp) + wind_at(wind, i + 5.0_dp, 7.0_dp) + &
                      wind_at(wind, i + 0.0_dp, 8.0_dp) + wind_at(wind, i + 5.0_dp, 8.0_dp))/4
            call check(error, all(abs(wind_at(wind, i + 2.5_dp, 7.5_dp) - middle) < 1e-9_dp))
        end do
    end subroutine test_linear

    !> Grid points, between two of them, over midnight, and a pole.
    subroutine test_file(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: EXPECTED(4, 5) = reshape([ &
            0.0_dp, 6.0_dp, -20.0_dp, 6.0_dp, &
            45.0_dp, 6.0_dp, -4.0_dp, 8.0_dp, &
            0.0_dp, 21.0_dp, -25.0_dp, 6.5_dp, &
            90.0_dp, 18.0_dp, 14.0_dp, 12.0_dp, &
            -90.0_dp, 0.0_dp, 10.0_dp, 1.0_dp], [4, 5])
        type(tabulated_wind_t) :: wind
        type(error_t), allocatable :: failure
        integer :: i

        call read_wind(FIXTURES//'.txt', wind, failure)
        if (failed(error, failure)) return
        do i = 1, size(EXPECTED, 2)
            call check(error, all(abs(wind_at(wind, EXPECTED(1, i), EXPECTED(2, i)) - &
                                         EXPECTED(3:4, i)) < 1e-12_dp))
        end do
    end subroutine test_file

    !> Each with a word that its message must hold.
    subroutine test_corrupted(error)
        type(error_type), allocatable, intent(out) :: error
        character(36), parameter :: BAD(2, 10) = reshape([character(36) :: &
            '_missing.txt', 'no such file', &
            '_empty.txt', 'holds no data', &
            '_columns.txt', 'txt:7: has 3 columns', &
            '_number.txt', '"-2O" is not a finite number', &
            '_speed.txt', 'txt:7: a wind of 20000 m/s', &
            '_incomplete.txt', '11 rows are no complete grid', &
            '_latitudes.txt', 'txt:6: the grid is not regular', &
            '_no_poles.txt', 'expected latitude -90 deg', &
            '_local_times.txt', 'local time 12 h here', &
            '_order.txt', 'txt:7: the grid is not regular'], [2, 10])
        type(tabulated_wind_t) :: wind
        type(error_t), allocatable :: failure
        integer :: i

        do i = 1, size(BAD, 2)
            call read_wind(FIXTURES//trim(BAD(1, i)), wind, failure)
            call check_fails(error, failure, joined(BAD(:, i)))
        end do
    end subroutine test_corrupted
end module test_wind
