!> The C interface: Level-1 data of GRACE and GRACE-FO. Documented in include/gracecg_level1.h.
module gracecg_level1_c_files
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_intptr_t, c_size_t
    use gracecg, only: dp, error_t
    use gracecg_level1, only: level1_records_t, read_level1
    use gracecg_base_error, only: fail_unknown_name
    use gracecg_base_kinds, only: i8
    use gracecg_base_text, only: integer_text
    use gracecg_interface_handles, only: object_t, acquire, release
    use gracecg_interface_c_support, only: c_error_t, STATUS_OK, STATUS_BAD_SIZE, LONGEST_NAME, start, raise, pass_on, &
        need, check_finite, fortran_text, give_text, keep_copy, refuse_handle, free_object
    implicit none
    private
    public :: c_level1_read, c_level1_free, c_level1_counts, c_level1_about, c_level1_field, c_level1_times
    public :: c_level1_values, c_level1_warning

    type, extends(object_t) :: level1_object_t
        type(level1_records_t) :: records
    end type level1_object_t

    character(*), parameter :: KIND = 'Level-1 file'

contains

    !> gracecg_level1_read
    function c_level1_read(path, span, handle, error) result(status) bind(c, name='gracecg_level1_read')
        character(kind=c_char), intent(in), optional :: path(*)
        real(c_double), intent(in), optional :: span(2)
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(level1_object_t) :: made
        type(error_t), allocatable :: failure
        character(:), allocatable :: name

        call start(status, error)
        call need(present(handle), 'level1', status, error)
        if (present(handle)) handle = 0
        call fortran_text(path, LONGEST_NAME, 'path', name, status, error)
        if (present(span)) call check_finite(span, 2_c_size_t, 'span', status, error)
        if (status /= STATUS_OK) return
        if (present(span)) then
            call read_level1(name, made%records, failure, spans=reshape(span, [2, 1]))
        else
            call read_level1(name, made%records, failure)
        end if
        call pass_on(failure, status, error)
        if (status == STATUS_OK) call keep_copy(made, handle, status, error)
    end function c_level1_read

    !> gracecg_level1_free
    function c_level1_free(handle, error) result(status) bind(c, name='gracecg_level1_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(level1_object_t) :: mold

        call free_object(handle, KIND, status, error, mold)
    end function c_level1_free

    !> gracecg_level1_counts
    function c_level1_counts(handle, records, fields, warnings, error) result(status) bind(c, name='gracecg_level1_counts')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(inout), optional :: records, fields, warnings
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call acquire(int(handle, i8), object)
        select type (object)
        type is (level1_object_t)
            if (present(records)) records = object%records%count
            if (present(fields)) fields = size(object%records%fields)
            if (present(warnings)) warnings = size(object%records%warnings)
        class default
            call refuse_handle(KIND, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_level1_counts

    !> gracecg_level1_about
    function c_level1_about(handle, text, size, length, error) result(status) bind(c, name='gracecg_level1_about')
        integer(c_intptr_t), intent(in), value :: handle
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: size
        integer(c_size_t), intent(inout), optional :: length
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        character(9) :: about

        call start(status, error)
        call acquire(int(handle, i8), object)
        select type (object)
        type is (level1_object_t)
            about = object%records%layout%product//' '//object%records%satellite//' '//object%records%time_ref
            call give_text(trim(about), text, size, length, status, error)
        class default
            call refuse_handle(KIND, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_level1_about

    !> gracecg_level1_field
    function c_level1_field(handle, index, text, size, length, error) result(status) bind(c, name='gracecg_level1_field')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: index
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: size
        integer(c_size_t), intent(inout), optional :: length
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call acquire(int(handle, i8), object)
        select type (object)
        type is (level1_object_t)
            call check_index(index, ubound(object%records%fields, 1), 'fields', status, error)
            if (status == STATUS_OK) &
                call give_text(trim(object%records%fields(index + 1)), text, size, length, status, error)
        class default
            call refuse_handle(KIND, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_level1_field

    !> gracecg_level1_warning
    function c_level1_warning(handle, index, text, size, length, error) result(status) &
        bind(c, name='gracecg_level1_warning')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: index
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: size
        integer(c_size_t), intent(inout), optional :: length
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call acquire(int(handle, i8), object)
        select type (object)
        type is (level1_object_t)
            call check_index(index, ubound(object%records%warnings, 1), 'warnings', status, error)
            if (status == STATUS_OK) &
                call give_text(object%records%warnings(index + 1)%text, text, size, length, status, error)
        class default
            call refuse_handle(KIND, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_level1_warning

    !> An index from 0.
    subroutine check_index(index, number, what, status, error)
        integer(c_size_t), intent(in) :: index
        integer, intent(in) :: number
        character(*), intent(in) :: what
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        if (index < 0 .or. index >= number) &
            call raise(STATUS_BAD_SIZE, 'the index '//integer_text(int(index, i8))//' is beyond the '// &
                       integer_text(number)//' '//what, status, error)
    end subroutine check_index

    !> gracecg_level1_times
    function c_level1_times(handle, capacity, seconds, fraction, error) result(status) bind(c, name='gracecg_level1_times')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: capacity
        real(c_double), intent(inout), optional :: seconds(*), fraction(*)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        integer :: n

        call start(status, error)
        call acquire(int(handle, i8), object)
        select type (object)
        type is (level1_object_t)
            n = object%records%count
            call check_capacity(capacity, n, status, error)
            if (status == STATUS_OK) then
                if (present(seconds)) seconds(:n) = real(object%records%seconds, dp)
                if (present(fraction)) fraction(:n) = object%records%fraction
            end if
        class default
            call refuse_handle(KIND, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_level1_times

    !> gracecg_level1_values
    function c_level1_values(handle, field, capacity, values, error) result(status) bind(c, name='gracecg_level1_values')
        integer(c_intptr_t), intent(in), value :: handle
        character(kind=c_char), intent(in), optional :: field(*)
        integer(c_size_t), intent(in), value :: capacity
        real(c_double), intent(inout), optional :: values(*)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(error_t), allocatable :: failure
        character(:), allocatable :: name
        integer :: n, column

        call start(status, error)
        call need(present(values), 'values', status, error)
        call fortran_text(field, LONGEST_NAME, 'field', name, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (level1_object_t)
            n = object%records%count
            column = object%records%field_of(name)
            if (column == 0) call fail_unknown_name(failure, 'field of '//object%records%layout%product, name, &
                                                    object%records%fields)
            call pass_on(failure, status, error)
            call check_capacity(capacity, n, status, error)
            if (status == STATUS_OK) values(:n) = object%records%values(:, column)
        class default
            call refuse_handle(KIND, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_level1_values

    !> Arrays must have room for all records.
    subroutine check_capacity(capacity, n, status, error)
        integer(c_size_t), intent(in) :: capacity
        integer, intent(in) :: n
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        if (status /= STATUS_OK) return
        if (capacity >= 0 .and. capacity < n) &
            call raise(STATUS_BAD_SIZE, 'capacity = '//integer_text(int(capacity, i8))//': there are '//integer_text(n)// &
                       ' records', status, error)
    end subroutine check_capacity
end module gracecg_level1_c_files
