!> Geomagnetic coefficients from a file in the format SHC (spherical harmonic coefficients), in
!> which the IGRF and other field models are distributed.
!>
!> After comments (#) come a line of integers (lowest degree, highest degree, number of epochs,
!> order of the splines, steps of a spline; more may follow), a line of epochs in decimal years, and
!> lines `n m value ...` with a value in nT for each epoch; m >= 0 is g(n,m), m < 0 is h(n,-m).
!> Schmidt semi-normalised, reference radius 6371.2 km.
module gracecg_environment_shc_file
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_RADIUS_IGRF
    use gracecg_base_error, only: error_t, add_context, fail
    use gracecg_files_table, only: table_file_t, read_table
    use gracecg_base_text, only: string_t, integer_text, parse_integer, parse_real
    use gracecg_environment_spherical_harmonics, only: MAX_DEGREE
    use gracecg_environment_geomagnetic_field, only: igrf_t, coefficients_at, new_igrf
    implicit none
    private
    public :: read_shc

    integer, parameter :: HEAD_ROW = 1, EPOCH_ROW = 2
    integer, parameter :: LINEAR = 2    !! Order of a spline that is linear between the epochs

contains

    !> Reads a model at a date. Fails, with file and line, on: a file that cannot be read; splines
    !> that are not linear; a line that cannot be understood; NaN; epochs that do not rise; a
    !> coefficient given twice or not at all; a date outside the epochs.
    subroutine read_shc(path, decimal_year, model, error)
        character(*), intent(in) :: path        !! Of the .shc file
        real(dp), intent(in) :: decimal_year    !! Year with decimals
        type(igrf_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        type(table_file_t) :: file
        real(dp), allocatable :: epochs(:), tables(:, :), list(:)
        integer :: degree, epoch_count

        call read_table(path, file, error)
        if (allocated(error)) return
        call read_head(file, degree, epoch_count, error)
        if (allocated(error)) return
        call read_epochs(file, epoch_count, epochs, error)
        if (allocated(error)) return
        call read_coefficients(file, degree, epoch_count, tables, error)
        if (allocated(error)) return
        call coefficients_at(decimal_year, epochs, tables, list, error)
        if (.not. allocated(error)) &
            call new_igrf(file%text%name, EARTH_RADIUS_IGRF, degree, list, model, error)
        call add_context(error, file%text%name)
    end subroutine read_shc

    subroutine read_head(file, degree, epoch_count, error)
        type(table_file_t), intent(in) :: file
        integer, intent(out) :: degree, epoch_count
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: fields(:)
        integer :: numbers(4), k
        logical :: ok

        allocate (fields, source=file%fields(HEAD_ROW))
        ok = size(fields) >= size(numbers)
        do k = 1, size(numbers)
            if (ok) call parse_integer(fields(k)%text, numbers(k), ok)
        end do
        if (ok) ok = numbers(1) >= 1 .and. numbers(2) >= numbers(1) .and. numbers(3) >= 1
        if (.not. ok) then
            call file%fail_at(HEAD_ROW, 'expected the integers: lowest degree, highest degree, '// &
                              'number of epochs, order of the splines, steps', error)
            return
        end if
        degree = numbers(2)
        epoch_count = numbers(3)
        call file%check_numbers(HEAD_ROW, fields(size(numbers) + 1:), size(numbers) + 1, error)
        if (allocated(error)) return
        if (degree > MAX_DEGREE) then
            call file%fail_at(HEAD_ROW, 'the highest degree must not exceed '// &
                              integer_text(MAX_DEGREE), error)
        else if (numbers(1) /= 1) then
            call file%fail_at(HEAD_ROW, 'the lowest degree must be 1 (the field of the core)', &
                              error)
        else if (epoch_count > 1 .and. numbers(4) /= LINEAR) then
            call file%fail_at(HEAD_ROW, 'splines of order '//integer_text(numbers(4))// &
                              ' are not supported; order 2 (linear between the epochs) is', error)
        end if
    end subroutine read_head

    subroutine read_epochs(file, epoch_count, epochs, error)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: epoch_count
        real(dp), allocatable, intent(out) :: epochs(:)     !! Decimal years
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: fields(:)
        logical :: ok

        allocate (fields, source=file%fields(EPOCH_ROW))
        ok = size(fields) == epoch_count
        allocate (epochs(size(fields)))
        if (ok) call parse_values(fields, epochs, ok)
        if (ok) ok = all(epochs(2:) > epochs(:epoch_count - 1))
        if (ok) return
        call file%fail_at(EPOCH_ROW, 'expected '//integer_text(epoch_count)//' epochs in '// &
                          'decimal years, rising', error)
    end subroutine read_epochs

    !> Lists of coefficients in the order of new_igrf, one column an epoch.
    subroutine read_coefficients(file, degree, epoch_count, tables, error)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: degree, epoch_count
        real(dp), allocatable, intent(out) :: tables(:, :)
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: values(epoch_count)
        logical, allocatable :: given(:)
        integer :: i, place, missing

        allocate (tables(degree*(degree + 2), epoch_count), source=0.0_dp)
        allocate (given(size(tables, 1)), source=.false.)
        do i = EPOCH_ROW + 1, file%row_count()
            call read_row(file, i, degree, epoch_count, place, values, error)
            if (allocated(error)) return
            if (given(place)) then
                call file%fail_at(i, 'this degree and order was given before', error)
                return
            end if
            tables(place, :) = values
            given(place) = .true.
        end do
        missing = findloc(given, .false., 1)
        if (missing == 0) return
        call fail(error, file%text%name//': there is no coefficient '//trim(coefficient_name(missing))// &
                  '; is the file complete (highest degree '//integer_text(degree)//')?')
    end subroutine read_coefficients

    subroutine read_row(file, i, degree, epoch_count, place, values, error)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: i                        !! Row of the file
        integer, intent(in) :: degree, epoch_count
        integer, intent(out) :: place                   !! In the list of coefficients; 0 if wrong
        real(dp), intent(out) :: values(:)              !! One an epoch
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: fields(:)
        integer :: n, m
        logical :: ok(2)

        place = 0
        values = 0
        allocate (fields, source=file%fields(i))
        if (size(fields) /= epoch_count + 2) then
            call file%fail_at(i, 'expected degree, order and '//integer_text(epoch_count)// &
                              ' values, found '//integer_text(size(fields))//' fields', error)
            return
        end if
        call parse_integer(fields(1)%text, n, ok(1))
        call parse_integer(fields(2)%text, m, ok(2))
        if (.not. all(ok) .or. n < 1 .or. n > degree .or. abs(m) > n) then
            call file%fail_at(i, 'degree and order must be integers with 1 <= degree <= '// &
                              integer_text(degree)//' and -degree <= order <= degree', error)
            return
        end if
        place = n**2
        if (m > 0) place = n**2 + 2*m - 1
        if (m < 0) place = n**2 - 2*m
        call parse_values(fields(3:), values, ok(1))
        if (.not. ok(1)) call file%fail_at(i, 'the values must be finite numbers', error)
    end subroutine read_row

    !> The name of a place in the list of coefficients.
    function coefficient_name(place) result(name)
        integer, intent(in) :: place
        character(30) :: name       !! Blanks behind it

        integer :: n, rest

        n = int(sqrt(place + 0.5))
        rest = place - n**2      ! 0: g(n,0), odd: g, even: h
        name = merge('g', 'h', rest == 0 .or. mod(rest, 2) == 1)//'('//integer_text(n)//','// &
            integer_text((rest + 1)/2)//')'
    end function coefficient_name

    subroutine parse_values(fields, values, ok)
        type(string_t), intent(in) :: fields(:)
        real(dp), intent(out) :: values(:)      !! As many as there are fields
        logical, intent(out) :: ok

        integer :: k

        ok = .true.
        values = 0
        do k = 1, size(fields)
            call parse_real(fields(k)%text, values(k), ok)
            if (.not. ok) return
        end do
    end subroutine parse_values
end module gracecg_environment_shc_file
