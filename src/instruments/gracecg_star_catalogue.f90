!> The star catalogue: which stars a camera sees.
!>
!> The built-in one stands in for the catalogue of CSR-TM-00-01 section 3.3.3 (J. Stauffer, 4853
!> stars), which is not public: 4616 stars of the Hipparcos catalogue under the same rules.
module gracecg_star_catalogue
    use gracecg_kinds, only: dp
    use gracecg_constants, only: DEGREE
    use gracecg_error, only: error_t, fail, fail_in_file
    use gracecg_table_bright_stars, only: RIGHT_ASCENSION, DECLINATION, VISUAL_MAGNITUDE
    implicit none
    private
    public :: star_catalogue_t, builtin_star_catalogue, read_star_catalogue

    !> Stars by direction; the order is that of their source.
    type :: star_catalogue_t
        real(dp), allocatable :: direction(:, :)    !! Unit vectors, J2000; (3, stars)
        real(dp), allocatable :: magnitude(:)       !! Visual, mag; (stars)
    contains
        procedure :: visible_stars
    end type star_catalogue_t

    ! Columns of a catalogue file, counted from 1
    integer, parameter :: RA_COLUMN = 3, DEC_COLUMN = 4, MAGNITUDE_COLUMN = 7, PASS_COLUMN = 11
    integer, parameter :: N_COLUMNS = 12
    integer, parameter :: LINE_LENGTH = 512

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
    subroutine read_star_catalogue(file, catalogue, error)
        character(*), intent(in) :: file
        type(star_catalogue_t), intent(out) :: catalogue
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: stars(:, :)
        integer :: unit, status, i

        open (newunit=unit, file=file, status='old', action='read', iostat=status)
        if (status /= 0) then
            call fail(error, 'the star catalogue "'//file//'" cannot be opened: check the path')
            return
        end if
        call read_stars(unit, file, stars, error)
        close (unit)
        if (allocated(error)) return
        allocate (catalogue%magnitude, source=stars(3, :))
        allocate (catalogue%direction(3, size(stars, 2)))
        do i = 1, size(stars, 2)
            catalogue%direction(:, i) = direction_of(stars(1, i), stars(2, i))
        end do
    end subroutine read_star_catalogue

    !> Right ascension, declination (deg) and magnitude of the stars taken.
    subroutine read_stars(unit, file, stars, error)
        integer, intent(in) :: unit
        character(*), intent(in) :: file
        real(dp), allocatable, intent(out) :: stars(:, :)   !! (3, stars)
        type(error_t), allocatable, intent(out) :: error

        character(LINE_LENGTH) :: line
        real(dp) :: star(3)
        integer :: status, number, n
        logical :: taken

        allocate (stars(3, 1024))
        number = 0
        n = 0
        do
            read (unit, '(a)', iostat=status) line
            if (is_iostat_end(status)) exit
            number = number + 1
            if (status /= 0) then
                call fail_in_file(error, file, number, &
                                  'the line cannot be read: is this a text file?')
                return
            end if
            if (index(line, '#') > 0) line(index(line, '#'):) = ''
            if (line == '') cycle
            call read_star(file, number, line, star, taken, error)
            if (allocated(error)) return
            if (.not. taken) cycle
            if (n == size(stars, 2)) stars = reshape(stars, [3, 2*n], pad=[0.0_dp])
            n = n + 1
            stars(:, n) = star
        end do
        if (n == 0) call fail_in_file(error, file, 0, 'there is no star with passA = 1')
        stars = stars(:, :n)
    end subroutine read_stars

    !> Right ascension, declination and magnitude of one line, and whether the star is taken.
    subroutine read_star(file, number, line, star, taken, error)
        character(*), intent(in) :: file, line
        integer, intent(in) :: number       !! Line number
        real(dp), intent(out) :: star(3)
        logical, intent(out) :: taken
        type(error_t), allocatable, intent(out) :: error

        integer :: first(N_COLUMNS), last(N_COLUMNS), n
        character(:), allocatable :: complaint

        star = 0
        taken = .false.
        complaint = ''
        call split(line, first, last, n)
        if (n /= N_COLUMNS) then
            complaint = 'a star needs 12 columns (see the header of data/bright_stars.txt)'
        else if (.not. readable(field(RA_COLUMN), 0.0_dp, 360.0_dp, star(1))) then
            complaint = 'right ascension (column 3) must be a number from 0 to 360 deg'
        else if (.not. readable(field(DEC_COLUMN), -90.0_dp, 90.0_dp, star(2))) then
            complaint = 'declination (column 4) must be a number from -90 to 90 deg'
        else if (.not. readable(field(MAGNITUDE_COLUMN), -30.0_dp, 30.0_dp, star(3))) then
            complaint = 'magnitude V (column 7) must be a number from -30 to 30'
        else if (field(PASS_COLUMN) /= '0' .and. field(PASS_COLUMN) /= '1') then
            complaint = 'passA (column 11) must be 0 or 1'
        else
            taken = field(PASS_COLUMN) == '1'
        end if
        if (complaint /= '') call fail_in_file(error, file, number, complaint, line)

    contains

        function field(column)
            integer, intent(in) :: column
            character(:), allocatable :: field

            field = line(first(column):last(column))
        end function field
    end subroutine read_star

    !> Whether a field is a number inside a range.
    logical function readable(field, low, high, value)
        character(*), intent(in) :: field
        real(dp), intent(in) :: low, high
        real(dp), intent(out) :: value

        integer :: status

        value = 0
        readable = .false.
        if (verify(field, '+-.0123456789eE') > 0) return
        read (field, '(f512.0)', iostat=status) value
        readable = status == 0 .and. value >= low .and. value <= high
    end function readable

    !> Where the fields of a line stand, separated by blanks or tabulators. `n` counts all of them,
    !> also those for which there is no room.
    pure subroutine split(line, first, last, n)
        character(*), intent(in) :: line
        integer, intent(out) :: first(:), last(:)   !! Positions in the line; (fields)
        integer, intent(out) :: n

        character(*), parameter :: BLANKS = ' '//achar(9)//achar(13)
        integer :: position, skipped, length

        first = 1
        last = 0
        n = 0
        position = 1
        do
            skipped = verify(line(position:), BLANKS) - 1
            if (skipped < 0) exit
            position = position + skipped
            length = scan(line(position:)//' ', BLANKS) - 1
            n = n + 1
            if (n <= size(first)) then
                first(n) = position
                last(n) = position + length - 1
            end if
            position = position + length
        end do
    end subroutine split
end module gracecg_star_catalogue
