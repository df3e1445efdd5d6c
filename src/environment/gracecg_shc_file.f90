!> Geomagnetic coefficients from a file in the format SHC (spherical harmonic coefficients), in
!> which the IGRF and other field models are distributed.
!>
!> After comments (#) come a line of integers (lowest degree, highest degree, number of epochs,
!> order of the splines, steps of a spline; more may follow), a line of epochs in decimal years, and
!> lines `n m value ...` with a value in nT for each epoch; m >= 0 is g(n,m), m < 0 is h(n,-m).
!> Schmidt semi-normalised, reference radius 6371.2 km.
module gracecg_shc_file
    use gracecg_kinds, only: dp
    use gracecg_constants, only: EARTH_RADIUS_IGRF
    use gracecg_error, only: error_t, add_context, fail, fail_in_file
    use gracecg_file, only: text_file_t, read_text_file
    use gracecg_text, only: string_t, integer_text, parse_integer, parse_real, split_words
    use gracecg_spherical_harmonics, only: MAX_DEGREE
    use gracecg_geomagnetic_field, only: igrf_t, coefficients_at, new_igrf
    implicit none
    private
    public :: read_shc

    integer, parameter :: LINEAR = 2    !! Order of a spline that is linear between the epochs

contains

    !> Reads a model at a date. Fails, with file and line, on: a file that cannot be read; splines
    !> that are not linear; a line that cannot be understood; NaN; epochs that do not rise; a
    !> coefficient given twice or not at all; a date outside the epochs.
    subroutine read_shc(file, decimal_year, model, error)
        character(*), intent(in) :: file
        real(dp), intent(in) :: decimal_year
        type(igrf_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: text
        real(dp), allocatable :: epochs(:), tables(:, :), list(:)
        integer :: degree, epoch_count, i

        call read_text_file(file, text, error)
        if (allocated(error)) return
        i = 0
        call read_head(text, i, degree, epoch_count, error)
        if (allocated(error)) return
        call read_epochs(text, i, epoch_count, epochs, error)
        if (allocated(error)) return
        call read_coefficients(text, i, degree, epoch_count, tables, error)
        if (allocated(error)) return
        call coefficients_at(decimal_year, epochs, tables, list, error)
        if (.not. allocated(error)) &
            call new_igrf(text%name, EARTH_RADIUS_IGRF, degree, list, model, error)
        call add_context(error, text%name)
    end subroutine read_shc

    !> The words of the next line that is neither blank nor a comment; none at the end of the file.
    subroutine next_words(text, i, words)
        type(text_file_t), intent(in) :: text
        integer, intent(inout) :: i         !! Line number: of the last line read, then of this one
        type(string_t), allocatable, intent(out) :: words(:)

        do i = i + 1, text%line_count()
            words = split_words(text%line(i))
            if (size(words) == 0) cycle
            if (index(words(1)%text, '#') /= 1) return
        end do
        words = split_words('')
    end subroutine next_words

    subroutine read_head(text, i, degree, epoch_count, error)
        type(text_file_t), intent(in) :: text
        integer, intent(inout) :: i
        integer, intent(out) :: degree, epoch_count
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: words(:)
        integer :: numbers(4), k
        logical :: ok

        call next_words(text, i, words)
        ok = size(words) >= size(numbers)
        do k = 1, size(numbers)
            if (ok) call parse_integer(words(k)%text, numbers(k), ok)
        end do
        if (ok) ok = numbers(1) >= 1 .and. numbers(2) >= numbers(1) .and. numbers(3) >= 1
        if (.not. ok) then
            call fail_at(text, i, 'expected the integers: lowest degree, highest degree, '// &
                         'number of epochs, order of the splines, steps', error)
            return
        end if
        degree = numbers(2)
        epoch_count = numbers(3)
        if (degree > MAX_DEGREE) then
            call fail_at(text, i, 'the highest degree must not exceed '//integer_text(MAX_DEGREE), &
                         error)
        else if (numbers(1) /= 1) then
            call fail_at(text, i, 'the lowest degree must be 1 (the field of the core)', error)
        else if (epoch_count > 1 .and. numbers(4) /= LINEAR) then
            call fail_at(text, i, 'splines of order '//integer_text(numbers(4))// &
                         ' are not supported; order 2 (linear between the epochs) is', error)
        end if
    end subroutine read_head

    subroutine read_epochs(text, i, epoch_count, epochs, error)
        type(text_file_t), intent(in) :: text
        integer, intent(inout) :: i
        integer, intent(in) :: epoch_count
        real(dp), allocatable, intent(out) :: epochs(:)     !! Decimal years
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: words(:)
        logical :: ok

        call next_words(text, i, words)
        ok = size(words) == epoch_count
        if (ok) call parse_values(words, epochs, ok)
        if (ok) ok = all(epochs(2:) > epochs(:epoch_count - 1))
        if (ok) return
        call fail_at(text, i, 'expected '//integer_text(epoch_count)// &
                     ' epochs in decimal years, rising', error)
    end subroutine read_epochs

    !> Lists of coefficients in the order of new_igrf, one column an epoch.
    subroutine read_coefficients(text, i, degree, epoch_count, tables, error)
        type(text_file_t), intent(in) :: text
        integer, intent(inout) :: i
        integer, intent(in) :: degree, epoch_count
        real(dp), allocatable, intent(out) :: tables(:, :)
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: words(:)
        real(dp), allocatable :: values(:)
        logical, allocatable :: given(:)
        integer :: row, missing

        allocate (tables(degree*(degree + 2), epoch_count), source=0.0_dp)
        allocate (given(size(tables, 1)), source=.false.)
        do
            call next_words(text, i, words)
            if (size(words) == 0) exit
            call read_line(text, i, words, degree, epoch_count, row, values, error)
            if (allocated(error)) return
            if (given(row)) then
                call fail_at(text, i, 'this degree and order was given before', error)
                return
            end if
            tables(row, :) = values
            given(row) = .true.
        end do
        missing = findloc(given, .false., 1)
        if (missing == 0) return
        call fail(error, text%name//': there is no coefficient '//coefficient_name(missing)// &
                  '; is the file complete (highest degree '//integer_text(degree)//')?')
    end subroutine read_coefficients

    subroutine read_line(text, i, words, degree, epoch_count, row, values, error)
        type(text_file_t), intent(in) :: text
        integer, intent(in) :: i
        type(string_t), intent(in) :: words(:)
        integer, intent(in) :: degree, epoch_count
        integer, intent(out) :: row                     !! In the list of coefficients; 0 if wrong
        real(dp), allocatable, intent(out) :: values(:) !! One an epoch
        type(error_t), allocatable, intent(out) :: error

        integer :: n, m
        logical :: ok(2)

        row = 0
        if (size(words) /= epoch_count + 2) then
            call fail_at(text, i, 'expected degree, order and '//integer_text(epoch_count)// &
                         ' values, found '//integer_text(size(words))//' fields', error)
            return
        end if
        call parse_integer(words(1)%text, n, ok(1))
        call parse_integer(words(2)%text, m, ok(2))
        if (.not. all(ok) .or. n < 1 .or. n > degree .or. abs(m) > n) then
            call fail_at(text, i, 'degree and order must be integers with 1 <= degree <= '// &
                         integer_text(degree)//' and -degree <= order <= degree', error)
            return
        end if
        row = n**2
        if (m > 0) row = n**2 + 2*m - 1
        if (m < 0) row = n**2 - 2*m
        call parse_values(words(3:), values, ok(1))
        if (.not. ok(1)) call fail_at(text, i, 'the values must be finite numbers', error)
    end subroutine read_line

    !> The name of a place in the list of coefficients.
    function coefficient_name(row) result(name)
        integer, intent(in) :: row
        character(:), allocatable :: name

        integer :: n, place

        n = int(sqrt(row + 0.5))
        place = row - n**2      ! 0: g(n,0), odd: g, even: h
        name = merge('g', 'h', place == 0 .or. mod(place, 2) == 1)//'('//integer_text(n)//','// &
            integer_text((place + 1)/2)//')'
    end function coefficient_name

    subroutine parse_values(words, values, ok)
        type(string_t), intent(in) :: words(:)
        real(dp), allocatable, intent(out) :: values(:)
        logical, intent(out) :: ok

        integer :: k

        allocate (values(size(words)))
        do k = 1, size(words)
            call parse_real(words(k)%text, values(k), ok)
            if (.not. ok) return
        end do
    end subroutine parse_values

    !> A failure at a line of the file.
    subroutine fail_at(text, i, message, error)
        type(text_file_t), intent(in) :: text
        integer, intent(in) :: i                !! Line number
        character(*), intent(in) :: message
        type(error_t), allocatable, intent(out) :: error

        call fail_in_file(error, text%name, i, message, text%line(i))
    end subroutine fail_at
end module gracecg_shc_file
