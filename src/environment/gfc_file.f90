!> Geopotential coefficients from a file in the format of the International Centre for Global Earth
!> Models (ICGEM), usually named *.gfc.
!>
!> A head of lines `keyword value`, closed by `end_of_head` (optional), is followed by lines
!> `gfc n m C S [sigma C, sigma S ...]`, in any order. Text before `begin_of_head`, keywords that do
!> not matter here, comments (#) and blank lines are skipped.
module gracecg_environment_gfc_file
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, add_context, fail
    use gracecg_files_table, only: table_file_t, read_table
    use gracecg_base_text, only: string_t, integer_text, lower_case, parse_integer, parse_real
    use gracecg_environment_geopotential, only: geopotential_t, check_degree_and_order, new_geopotential
    implicit none
    private
    public :: read_gfc

    type :: head_t
        !! What the head of a file says
        character(:), allocatable :: name
        real(dp) :: mu = 0              !! m^3/s^2
        real(dp) :: radius = 0          !! m
        integer :: max_degree = -1
        integer :: fields = 5           !! Fields of a line gfc, at least
        integer :: last_row = 0         !! Of the head
    end type head_t

contains

    !> Reads a model to some degree and order. Fails, with file and line, on: a file that cannot be
    !> read; a head without gravitational constant, radius or maximum degree; another product or
    !> normalisation; a degree the file does not have; a line that cannot be understood; NaN; a
    !> coefficient given twice or (beyond degree 1) not at all; coefficients that change with time.
    subroutine read_gfc(path, degree, order, model, error)
        character(*), intent(in) :: path    !! Of the .gfc file
        integer, intent(in) :: degree       !! Up to which it is read
        integer, intent(in) :: order        !! Up to which it is read
        type(geopotential_t), intent(out) :: model
        type(error_t), allocatable, intent(out) :: error

        type(table_file_t) :: file
        type(head_t) :: head
        real(dp), allocatable :: c(:, :), s(:, :)

        call read_table(path, file, error)
        if (allocated(error)) return
        call read_head(file, head, error)
        if (allocated(error)) return
        call check_degree_and_order(degree, order, head%max_degree, error)
        call add_context(error, file%text%name)
        if (allocated(error)) return
        call read_coefficients(file, head, degree, order, c, s, error)
        if (allocated(error)) return
        call new_geopotential(head%name, head%mu, head%radius, c, s, degree, order, model, error)
        call add_context(error, file%text%name)
    end subroutine read_gfc

    subroutine read_head(file, head, error)
        type(table_file_t), intent(in) :: file
        type(head_t), intent(out) :: head
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: fields(:)
        character(:), allocatable :: keyword
        integer :: i, first

        call find_head(file, first, head%last_row)
        head%name = file%text%name
        do i = first, head%last_row
            call split_row(file, i, fields, keyword)
            if (size(fields) < 2) cycle
            call take_keyword(file, i, keyword, fields(2)%text, head, error)
            if (allocated(error)) return
        end do
        if (.not. head%mu > 0) then
            call fail_missing(file%text%name, 'earth_gravity_constant', error)
        else if (.not. head%radius > 0) then
            call fail_missing(file%text%name, 'radius', error)
        else if (head%max_degree < 0) then
            call fail_missing(file%text%name, 'max_degree', error)
        end if
    end subroutine read_head

    !> The rows of the head: after begin_of_head, to end_of_head or to the first coefficient.
    subroutine find_head(file, first, last)
        type(table_file_t), intent(in) :: file
        integer, intent(out) :: first, last

        type(string_t), allocatable :: fields(:)
        character(:), allocatable :: keyword
        integer :: i, first_coefficient

        first = 1
        first_coefficient = file%row_count() + 1
        do i = 1, file%row_count()
            call split_row(file, i, fields, keyword)
            select case (keyword)
            case ('begin_of_head')
                first = i + 1
            case ('end_of_head')
                last = i
                return
            case ('gfc', 'gfct')
                first_coefficient = min(first_coefficient, i)
            end select
        end do
        last = first_coefficient - 1
    end subroutine find_head

    subroutine split_row(file, i, fields, keyword)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: i                                !! Row
        type(string_t), allocatable, intent(out) :: fields(:)
        character(:), allocatable, intent(out) :: keyword       !! The first field in small letters

        fields = file%fields(i)
        keyword = lower_case(fields(1)%text)
    end subroutine split_row

    subroutine take_keyword(file, i, keyword, value, head, error)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: i                !! Row
        character(*), intent(in) :: keyword, value
        type(head_t), intent(inout) :: head
        type(error_t), allocatable, intent(out) :: error

        character(21), parameter :: ERRORS(4) = [character(21) :: 'no', 'calibrated', 'formal', 'calibrated_and_formal']
        integer, parameter :: FIELDS(4) = [5, 7, 7, 9]      ! of a line gfc
        real(dp), parameter :: OF_EARTH(2, 2) = reshape([3.9e14_dp, 4.1e14_dp, 6.3e6_dp, 6.5e6_dp], [2, 2])
        !! What is allowed of mu, m^3/s^2, and of the radius, m: in kilometres neither would lie there
        character(45) :: allowed
        logical :: ok

        ok = .true.
        select case (keyword)
        case ('product_type')
            allowed = 'gravity_field'
            ok = lower_case(value) == allowed
        case ('modelname')
            head%name = value
        case ('earth_gravity_constant', 'gravity_constant')
            allowed = '3.9e14 to 4.1e14, in m^3/s^2'
            call parse_real(value, head%mu, ok)
            ok = ok .and. head%mu >= OF_EARTH(1, 1) .and. head%mu <= OF_EARTH(2, 1)
        case ('radius')
            allowed = '6.3e6 to 6.5e6, in m'
            call parse_real(value, head%radius, ok)
            ok = ok .and. head%radius >= OF_EARTH(1, 2) .and. head%radius <= OF_EARTH(2, 2)
        case ('max_degree')
            allowed = 'an integer, 0 or more'
            call parse_integer(value, head%max_degree, ok)
            ok = ok .and. head%max_degree >= 0
        case ('norm')
            allowed = 'fully_normalized (convert the coefficients)'
            ok = lower_case(value) == 'fully_normalized'
        case ('errors')
            allowed = 'no, calibrated, formal, calibrated_and_formal'
            ok = any(lower_case(value) == ERRORS)
            if (ok) head%fields = FIELDS(findloc(ERRORS, lower_case(value), 1))
        end select
        if (.not. ok) call file%fail_at(i, keyword//' = '//value//' cannot be used; allowed: '//trim(allowed), error)
    end subroutine take_keyword

    subroutine fail_missing(file, keyword, error)
        character(*), intent(in) :: file, keyword
        type(error_t), allocatable, intent(out) :: error

        call fail(error, file//': the head does not give '//keyword// &
                  '; is this an ICGEM .gfc file?')
    end subroutine fail_missing

    !> The coefficients to degree and order. Those of degree 0 and 1 may be absent: they are then 1
    !> and 0.
    subroutine read_coefficients(file, head, degree, order, c, s, error)
        type(table_file_t), intent(in) :: file
        type(head_t), intent(in) :: head
        integer, intent(in) :: degree, order
        real(dp), allocatable, intent(out) :: c(:, :), s(:, :)
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: fields(:)
        character(:), allocatable :: keyword
        logical, allocatable :: given(:, :)
        integer :: i, n, m

        allocate (c(0:degree, 0:order), s(0:degree, 0:order), source=0.0_dp)
        allocate (given(0:degree, 0:order), source=.false.)
        do i = head%last_row + 1, file%row_count()
            call split_row(file, i, fields, keyword)
            select case (keyword)
            case ('gfc')
                call read_row(file, i, fields, head, c, s, given, error)
            case ('gfct', 'trnd', 'dot', 'acos', 'asin')
                call file%fail_at(i, 'coefficients that change with time are not supported; '// &
                                  'provide the model at one epoch, in lines gfc', error)
            case default
                call file%fail_at(i, 'expected a line "gfc n m C S"', error)
            end select
            if (allocated(error)) return
        end do
        if (.not. any(given)) then
            call fail(error, file%text%name//': there is no line "gfc n m C S" of use')
            return
        end if
        if (.not. given(0, 0)) c(0, 0) = 1
        do n = 2, degree
            do m = 0, min(n, order)
                if (given(n, m)) cycle
                call fail(error, file%text%name//': there is no coefficient of degree '// &
                          integer_text(n)//', order '//integer_text(m)// &
                          '; is the file complete (max_degree '// &
                          integer_text(head%max_degree)//')?')
                return
            end do
        end do
    end subroutine read_coefficients

    !> One line gfc. Degrees and orders beyond the wanted ones are skipped; what stands in them, and
    !> the standard deviations behind C and S, must be numbers all the same.
    subroutine read_row(file, i, fields, head, c, s, given, error)
        type(table_file_t), intent(in) :: file
        integer, intent(in) :: i                            !! Row
        type(string_t), intent(in) :: fields(:)             !! Of this line
        type(head_t), intent(in) :: head
        real(dp), intent(inout) :: c(0:, 0:), s(0:, 0:)
        logical, intent(inout) :: given(0:, 0:)
        type(error_t), allocatable, intent(out) :: error

        real(dp), parameter :: NEAR = 1e-2_dp       ! Of the Earth C(2, 0) is the largest, 5e-4
        integer :: n, m

        if (size(fields) < head%fields) then
            call file%fail_at(i, 'expected at least '//integer_text(head%fields)// &
                              ' fields, found '//integer_text(size(fields)), error)
            return
        end if
        call file%get_integer(i, fields(2), 'degree', n, error, 0, head%max_degree)
        call file%get_integer(i, fields(3), 'order', m, error, 0, n)
        if (allocated(error)) return
        if (n > ubound(c, 1) .or. m > ubound(c, 2)) then
            call file%check_numbers(i, fields(4:), 4, error)
            return
        end if
        if (given(n, m)) then
            call file%fail_at(i, 'this degree and order was given before', error)
            return
        end if
        if (n == 0) then
            call file%get_real(i, fields(4), 'C', c(n, m), error, 1 - NEAR, 1 + NEAR)
        else
            call file%get_real(i, fields(4), 'C', c(n, m), error, -NEAR, NEAR)
        end if
        call file%get_real(i, fields(5), 'S', s(n, m), error, -NEAR, NEAR)
        call file%check_numbers(i, fields(6:), 6, error)
        given(n, m) = .true.
    end subroutine read_row
end module gracecg_environment_gfc_file
