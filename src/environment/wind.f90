!> Horizontal wind of the thermosphere by latitude and local solar time.
!>
!> The report takes its wind from a program that is not public (CSR-TM-00-01 section 2.3.2.1,
!> "AMSIS"); the embedded table, of HWM93 at the report's epoch and height, stands in for it. It
!> lies within some 20 m/s of what the report's cross-track drag asks for; the models of the time
!> differ by tens of m/s.
module gracecg_environment_wind
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: integer_text
    use gracecg_files_table, only: table_file_t, read_table
    use gracecg_environment_table_wind, only: WIND_LATITUDES, WIND_LOCAL_TIMES, WIND_EAST, WIND_NORTH
    implicit none
    private
    public :: wind_model_t, constant_wind_t, tabulated_wind_t, embedded_wind, read_wind

    type, abstract :: wind_model_t
        !! What gives the horizontal wind relative to the rotating Earth
    contains
        procedure(evaluate_interface), deferred :: evaluate !! Wind at a place and local time
    end type wind_model_t

    abstract interface
        !> The wind at a place and local time.
        pure subroutine evaluate_interface(self, latitude, local_solar_time, east, north)
            import :: wind_model_t, dp
            class(wind_model_t), intent(in) :: self
            real(dp), intent(in) :: latitude            !! Geodetic, rad, -pi/2 to pi/2
            real(dp), intent(in) :: local_solar_time    !! h, cyclic
            real(dp), intent(out) :: east, north        !! m/s
        end subroutine evaluate_interface
    end interface

    type, extends(wind_model_t) :: constant_wind_t
        !! The same wind everywhere; still air unless said otherwise
        real(dp) :: east = 0.0_dp, north = 0.0_dp   !! m/s
    contains
        procedure :: evaluate => evaluate_constant
    end type constant_wind_t

    type, extends(wind_model_t) :: tabulated_wind_t
        !! Wind on a regular grid: latitudes from -90 to 90 deg, local times from 0 h round the day
        private
        real(dp), allocatable :: east(:, :)     !! m/s, (local time 0 h ... 24 h, latitude)
        real(dp), allocatable :: north(:, :)    !! m/s, as `east`
        logical :: smooth = .false.             !! Without the kinks of straight lines between the points
    contains
        procedure :: evaluate => evaluate_table
    end type tabulated_wind_t

    !> Of a file
    character(24), parameter :: COLUMNS(4) = [character(24) :: 'latitude (deg)', 'local time (h)', 'northward wind (m/s)', &
                                              'eastward wind (m/s)']
    real(dp), parameter :: FASTEST_WIND = 3000.0_dp
    !! m/s: above any wind of the thermosphere, below what a slip of units or columns gives

contains

    pure subroutine evaluate_constant(self, latitude, local_solar_time, east, north)
        class(constant_wind_t), intent(in) :: self
        real(dp), intent(in) :: latitude            !! rad; without influence
        real(dp), intent(in) :: local_solar_time    !! h; without influence
        real(dp), intent(out) :: east, north        !! m/s

        ! A place that is not a number is an error elsewhere: it shall not vanish here.
        east = self%east + 0*(latitude + local_solar_time)
        north = self%north + 0*(latitude + local_solar_time)
    end subroutine evaluate_constant

    !> Between the points linear in latitude and, cyclically, in local time, or along cubics that are level at them.
    pure subroutine evaluate_table(self, latitude, local_solar_time, east, north)
        class(tabulated_wind_t), intent(in) :: self
        real(dp), intent(in) :: latitude            !! rad
        real(dp), intent(in) :: local_solar_time    !! h
        real(dp), intent(out) :: east, north        !! m/s

        real(dp) :: row, column, f, g
        integer :: i, j, last_row, last_column

        last_column = size(self%east, 1)
        last_row = size(self%east, 2)
        column = 1 + modulo(local_solar_time, 24.0_dp)/24*(last_column - 1)
        row = 1 + (latitude/DEGREE + 90)/180*(last_row - 1)
        i = max(1, min(int(column), last_column - 1))
        j = max(1, min(int(row), last_row - 1))
        f = column - i
        g = row - j
        if (self%smooth) f = f**2*(3 - 2*f)
        if (self%smooth) g = g**2*(3 - 2*g)
        east = bilinear(self%east)
        north = bilinear(self%north)

    contains

        pure real(dp) function bilinear(table)
            real(dp), intent(in) :: table(:, :)

            bilinear = (1 - g)*((1 - f)*table(i, j) + f*table(i + 1, j)) + &
                       g*((1 - f)*table(i, j + 1) + f*table(i + 1, j + 1))
        end function bilinear
    end subroutine evaluate_table

    !> HWM93 at 1989-01-02 0 h UT and 466 km, by 5 deg and 1 h.
    function embedded_wind(smooth) result(wind)
        logical, intent(in), optional :: smooth     !! As the type has it
        type(tabulated_wind_t) :: wind

        wind = table_of(reshape(WIND_EAST, [WIND_LOCAL_TIMES, WIND_LATITUDES]), &
                        reshape(WIND_NORTH, [WIND_LOCAL_TIMES, WIND_LATITUDES]))
        if (present(smooth)) wind%smooth = smooth
    end function embedded_wind

    !> A table from its grid; repeats the first local time as 24 h.
    pure function table_of(east, north) result(wind)
        real(dp), intent(in) :: east(:, :), north(:, :)     !! m/s, (local time, latitude)
        type(tabulated_wind_t) :: wind

        integer :: n, m

        n = size(east, 1)
        m = size(east, 2)
        allocate (wind%east(n + 1, m), wind%north(n + 1, m))
        wind%east(:n, :) = east
        wind%north(:n, :) = north
        wind%east(n + 1, :) = east(1, :)
        wind%north(n + 1, :) = north(1, :)
    end function table_of

    !> Reads a table of the columns latitude (deg), local time (h), northward, eastward wind (m/s);
    !> `#` begins a comment. The rows go by latitude from -90 to 90 deg and, within each, by local
    !> time from 0 h on, both equally spaced and none left out. Fails with file and line.
    subroutine read_wind(file, wind, error)
        character(*), intent(in) :: file    !! Path of the table
        type(tabulated_wind_t), intent(out) :: wind
        type(error_t), allocatable, intent(out) :: error

        type(table_file_t) :: table
        real(dp), allocatable :: rows(:, :)     ! (row, column)
        integer :: i, n, local_times, latitudes

        call read_table(file, table, error)
        call table%get_numbers(COLUMNS, rows, error)
        if (allocated(error)) return
        n = table%row_count()
        local_times = count(rows(:, 1) <= rows(1, 1))
        latitudes = n/local_times
        if (local_times*latitudes /= n .or. latitudes < 2 .or. local_times < 2) then
            call fail(error, file//': '//integer_text(n)//' rows are no complete grid: every '// &
                      'latitude needs the same local times, and there must be two or more of '// &
                      'both; the first latitude has '//integer_text(local_times))
            return
        end if
        do i = 1, n
            call check_row(table, i, rows(i, :), local_times, latitudes, error)
            if (allocated(error)) return
        end do
        wind = table_of(reshape(rows(:, 4), [local_times, latitudes]), &
                        reshape(rows(:, 3), [local_times, latitudes]))
    end subroutine read_wind

    !> Checks that a row stands where the regular grid wants it, and that no wind is too fast.
    subroutine check_row(table, row, numbers, local_times, latitudes, error)
        type(table_file_t), intent(in) :: table
        integer, intent(in) :: row
        real(dp), intent(in) :: numbers(4)              !! Of COLUMNS
        integer, intent(in) :: local_times, latitudes
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: TOLERANCE = 1e-3_dp      !! deg and h: a rounded table
        real(dp) :: expected(2)

        expected(1) = -90 + 180.0_dp*((row - 1)/local_times)/(latitudes - 1)
        expected(2) = 24.0_dp*mod(row - 1, local_times)/local_times
        if (any(abs(numbers(:2) - expected) > TOLERANCE)) then
            call table%fail_at(row, 'the grid is not regular: expected latitude '// &
                               number_text(expected(1))//' deg and local time '// &
                               number_text(expected(2))//' h here (latitudes from -90 to '// &
                               '90 deg, within each the local times from 0 h on, equally '// &
                               'spaced)', error)
        else if (any(abs(numbers(3:)) > FASTEST_WIND)) then
            call table%fail_at(row, 'a wind of '//number_text(maxval(abs(numbers(3:))))//' m/s is faster than '// &
                               number_text(FASTEST_WIND)//' m/s', error)
        end if
    end subroutine check_row
end module gracecg_environment_wind
