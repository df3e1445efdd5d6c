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
    use gracecg_base_text, only: string_t, integer_text
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

        character(16), parameter :: NAMES(4) = [character(16) :: 'lowest degree', 'highest degree', 'number of epochs', &
                                                'order of splines']
        type(string_t), allocatable :: fields(:)
        integer :: numbers(4), k

        allocate (fields, source=file%fields(HEAD_ROW))
        if (size(fields) < size(numbers)) then
            call file%fail_at(HEAD_ROW, 'expected the integers: lowest degree, highest degree, '// &
                              'number of epochs, order of the splines, steps', error)
            return
        end if
        do k = 1, size(numbers)
            call file%get_integer(HEAD_ROW, fields(k), trim(NAMES(k)), numbers(k), error, low=1)
        end do
        call file%check_numbers(HEAD_ROW, fields(size(numbers) + 1:), size(numbers) + 1, error)
        if (allocated(error)) return
        degree = numbers(2)
        epoch_count = numbers(3)
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
        integer :: k

        allocate (epochs(epoch_count))
        call file%get_fields(EPOCH_ROW, epoch_count, 'epochs in decimal years, rising', fields, error)
        do k = 1, epoch_count
            call file%get_real(EPOCH_ROW, fields(k), 'epoch', epochs(k), error)
        end do
        if (allocated(error)) return
        if (.not. all(epochs(2:) > epochs(:epoch_count - 1))) call file%fail_at(EPOCH_ROW, 'the epochs must rise', error)
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
        integer, intent(out) :: place                   !! In the list of coefficients
        real(dp), intent(out) :: values(:)              !! One an epoch
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: fields(:)
        integer :: n, m, k

        call file%get_fields(i, epoch_count + 2, 'degree, order and a value for each epoch', fields, error)
        call file%get_integer(i, fields(1), 'degree', n, error, 1, degree)
        call file%get_integer(i, fields(2), 'order', m, error, -n, n)
        do k = 1, epoch_count
            call file%get_real(i, fields(k + 2), 'value', values(k), error)
        end do
        place = n**2
        if (m > 0) place = n**2 + 2*m - 1
        if (m < 0) place = n**2 - 2*m
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

end module gracecg_environment_shc_file
