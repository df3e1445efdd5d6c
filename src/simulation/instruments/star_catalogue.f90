!> The star catalogue: which stars a camera sees.
!>
!> The built-in one stands in for the catalogue of CSR-TM-00-01 section 3.3.3 (J. Stauffer, 4853
!> stars), which is not public: 4616 stars of the Hipparcos catalogue under the same rules.
module gracecg_simulation_star_catalogue
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE
    use gracecg_base_error, only: error_t, fail
    use gracecg_files_table, only: table_file_t, read_table
    use gracecg_base_text, only: string_t
    use gracecg_environment_table_bright_stars, only: RIGHT_ASCENSION, DECLINATION, VISUAL_MAGNITUDE
    implicit none
    private
    public :: star_catalogue_t, builtin_star_catalogue, read_star_catalogue

    !> Stars by direction; the order is that of their source.
    type :: star_catalogue_t
        real(dp), allocatable :: direction(:, :)    !! Unit vectors, J2000; (3, stars)
        real(dp), allocatable :: magnitude(:)       !! Visual, mag; (stars)
    contains
        procedure :: visible_stars  !! Those in a camera's field of view
    end type star_catalogue_t

    ! Columns of a catalogue file, counted from 1
    integer, parameter :: RA_COLUMN = 3, DEC_COLUMN = 4, MAGNITUDE_COLUMN = 7, PASS_COLUMN = 11
    integer, parameter :: N_COLUMNS = 12
    integer, parameter :: UNUSED(7) = [1, 2, 5, 6, 9, 10, 12]   !! Numbers, or - where there is none

contains

    !> The catalogue of the library.
    function builtin_star_catalogue() result(catalogue)
        type(star_catalogue_t) :: catalogue

        integer :: i

        allocate (catalogue%magnitude, source=VISUAL_MAGNITUDE)
        allocate (catalogue%direction(3, size(RIGHT_ASCENSION)))
        do i = 1, size(RIGHT_ASCENSION)
            catalogue%direction(:, i) = direction_of(RIGHT_ASCENSION(i), DECLINATION(i))
        end do
    end function builtin_star_catalogue

    !> Unit vector of right ascension and declination.
    pure function direction_of(ra, dec) result(direction)
        real(dp), intent(in) :: ra, dec     !! deg
        real(dp) :: direction(3)

        direction = [cos(dec*DEGREE)*cos(ra*DEGREE), cos(dec*DEGREE)*sin(ra*DEGREE), &
                     sin(dec*DEGREE)]
    end function direction_of

    !> The indices of the first stars, in the catalogue's order, inside a camera's rectangular field
    !> of view; stops when `indices` is full. A star at camera coordinates (x, y, z) is inside when
    !> |x/z| and |y/z| are at most the tangents of half the angles of the field.
    pure subroutine visible_stars(self, camera, field_of_view, indices, n)
        class(star_catalogue_t), intent(in) :: self
        real(dp), intent(in) :: camera(3, 3)        !! J2000 to camera frame, boresight z
        real(dp), intent(in) :: field_of_view(2)    !! Full angles along camera x and y, rad, < pi
        integer, intent(out) :: indices(:)          !! Those beyond n are 0
        integer, intent(out) :: n                   !! Number found

        real(dp) :: tangent(2), x_axis(3), y_axis(3), boresight(3), z
        integer :: i

        tangent = tan(field_of_view/2)
        x_axis = camera(1, :)
        y_axis = camera(2, :)
        boresight = camera(3, :)
        indices = 0
        n = 0
        do i = 1, size(self%direction, 2)
            if (n == size(indices)) return
            z = dot_product(boresight, self%direction(:, i))
            if (z <= 0) cycle
            if (abs(dot_product(x_axis, self%direction(:, i))) > z*tangent(1)) cycle
            if (abs(dot_product(y_axis, self%direction(:, i))) > z*tangent(2)) cycle
            n = n + 1
            indices(n) = i
        end do
    end subroutine visible_stars

    !> Reads a catalogue file: 12 columns as in data/bright_stars.txt (HIP, HR, right ascension and
    !> declination in deg J2000, proper motions, V, source, companion's distance and magnitude
    !> difference, passA, passB), `#` begins a comment. Stars with passA = 1 are taken.
    !>
    !> Fails when the file cannot be read, a line has not 12 columns, a number used cannot be read
    !> or is out of range, or no star is taken.
    subroutine read_star_catalogue(path, catalogue, error)
        character(*), intent(in) :: path    !! Path of the catalogue
        type(star_catalogue_t), intent(out) :: catalogue
        type(error_t), allocatable, intent(out) :: error

        type(table_file_t) :: file
        real(dp), allocatable :: stars(:, :)    ! Right ascension, declination (deg), magnitude
        logical, allocatable :: taken(:)
        integer :: i, k

        call read_table(path, file, error)
        if (allocated(error)) return
        allocate (stars(3, file%row_count()), taken(file%row_count()))
        do i = 1, file%row_count()
            call read_star(file, i, stars(:, i), taken(i), error)
            if (allocated(error)) return
        end do
        if (.not. any(taken)) then
            call fail(error, file%text%name//': there is no star with passA = 1')
            return
        end if
        allocate (catalogue%magnitude, source=pack(stars(3, :), taken))
        allocate (catalogue%direction(3, count(taken)))
        k = 0
        do i = 1, size(taken)
            if (.not. taken(i)) cycle
            k = k + 1
            catalogue%direction(:, k) = direction_of(stars(1, i), stars(2, i))
        end do
    end subroutine read_star_catalogue

    !> Right ascension, declination and magnitude of one row, and whether the star is taken.
    subroutine read_star(file, row, star, taken, error)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: row
        real(dp), intent(out) :: star(3)    !! deg, deg, mag
        logical, intent(out) :: taken
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: fields(:)
        integer :: i

        star = 0
        taken = .false.
        call file%get_fields(row, N_COLUMNS, 'HIP, HR, right ascension, declination, two proper '// &
                             'motions, V, source, distance and magnitude difference of a '// &
                             'companion, passA, passB', fields, error)
        call file%get_real(row, fields(RA_COLUMN), 'right ascension', star(1), error, 0.0_dp, 360.0_dp, 'deg')
        call file%get_real(row, fields(DEC_COLUMN), 'declination', star(2), error, -90.0_dp, 90.0_dp, 'deg')
        call file%get_real(row, fields(MAGNITUDE_COLUMN), 'magnitude V', star(3), error, -30.0_dp, 30.0_dp)
        if (allocated(error)) return
        taken = fields(PASS_COLUMN)%text == '1'
        if (.not. taken .and. fields(PASS_COLUMN)%text /= '0') &
            call file%fail_at(row, 'passA (column 11) must be 0 or 1', error)
        do i = 1, size(UNUSED)
            call file%check_numbers(row, fields(UNUSED(i):UNUSED(i)), UNUSED(i), error, or_nothing=.true.)
        end do
    end subroutine read_star
end module gracecg_simulation_star_catalogue
