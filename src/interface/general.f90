!> The C interface: version and names, the items of objects; what the shells do with handles.
module gracecg_interface_general
    use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int32_t, c_intptr_t, c_loc, c_null_char, c_null_ptr, c_ptr
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_text, only: integer_text
    use gracecg_base_version, only: LIBRARY_VERSION => VERSION
    use gracecg_simulation_report_cases, only: CASE_NAMES => REPORT_CASE_NAMES
    use gracecg_estimation_estimators, only: ESTIMATOR_NAMES
    use gracecg_interface_handles, only: object_t, store, remove, MAX_OBJECTS
    use gracecg_interface_outcome, only: outcome_t, c_error_t, reported, leaves_object, STATUS_OK, STATUS_BAD_HANDLE, &
        STATUS_NO_MEMORY
    use gracecg_interface_arguments, only: need, take_text, LONGEST_NAME
    use gracecg_interface_items, only: items_t
    implicit none
    private
    public :: c_version, c_interface_version, c_status_text, c_name, c_free, get, get_text, INTERFACE_VERSION
    public :: keep, check_memory, refuse_handle

    integer(c_int32_t), parameter :: INTERFACE_VERSION = 1      !! GRACECG_INTERFACE_VERSION
    integer, parameter :: NAME_SIZE = 32            !! Bytes of a constant text with its closing zero
    integer(c_int), parameter :: LAST_STATUS = 8
    character(NAME_SIZE), parameter :: STATUS_TEXTS(0:LAST_STATUS + 1) = [character(NAME_SIZE) :: &
        'success'//c_null_char, 'a needed argument is NULL'//c_null_char, &
        'not a valid handle'//c_null_char, 'wrong size'//c_null_char, &
        'a value is not allowed'//c_null_char, 'the work failed'//c_null_char, &
        'not converged'//c_null_char, 'no memory'//c_null_char, 'not to be used'//c_null_char, 'unknown status'//c_null_char]
    integer :: k
    ! Constant texts that callers point to: never changed, so that threads may read them
    character(NAME_SIZE), save, target :: version_text = LIBRARY_VERSION//c_null_char
    character(NAME_SIZE), save, target :: status_names(0:LAST_STATUS + 1) = STATUS_TEXTS
    character(NAME_SIZE), save, target :: algorithm_names(size(ESTIMATOR_NAMES)) = &
        [(trim(ESTIMATOR_NAMES(k))//repeat(c_null_char, NAME_SIZE - len_trim(ESTIMATOR_NAMES(k))), k=1, size(ESTIMATOR_NAMES))]
    character(NAME_SIZE), save, target :: builtin_cases(size(CASE_NAMES)) = &
        [(trim(CASE_NAMES(k))//repeat(c_null_char, NAME_SIZE - len_trim(CASE_NAMES(k))), k=1, size(CASE_NAMES))]

contains

    !> gracecg_version
    function c_version() result(text) bind(c, name='gracecg_version')
        type(c_ptr) :: text

        text = c_loc(version_text)
    end function c_version

    !> gracecg_interface_version
    integer(c_int32_t) function c_interface_version() result(number) bind(c, name='gracecg_interface_version')
        number = INTERFACE_VERSION
    end function c_interface_version

    !> gracecg_status_text
    function c_status_text(status) result(text) bind(c, name='gracecg_status_text')
        integer(c_int), intent(in), value :: status
        type(c_ptr) :: text

        text = c_loc(status_names(LAST_STATUS + 1))
        if (status >= 0 .and. status <= LAST_STATUS) text = c_loc(status_names(status))
    end function c_status_text

    !> gracecg_name
    function c_name(list, index) result(text) bind(c, name='gracecg_name')
        character(kind=c_char), intent(in), optional :: list(*)
        integer(c_int32_t), intent(in), value :: index      !! From 0
        type(c_ptr) :: text

        type(outcome_t) :: outcome
        character(:), allocatable :: name

        text = c_null_ptr
        call take_text(list, LONGEST_NAME, 'list', .false., name, outcome)
        if (index < 0) return
        if (name == 'algorithm' .and. index < size(algorithm_names)) text = c_loc(algorithm_names(index + 1))
        if (name == 'case' .and. index < size(builtin_cases)) text = c_loc(builtin_cases(index + 1))
    end function c_name

    !> gracecg_free
    function c_free(handle, error) result(status) bind(c, name='gracecg_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(outcome_t) :: outcome
        logical :: removed

        call need(present(handle), 'object', outcome)
        if (present(handle)) then
            removed = .true.
            if (handle /= 0) removed = remove(int(handle, i8))
            if (.not. removed) call refuse_handle('gracecg object', outcome)
            if (removed) handle = 0
        end if
        status = reported(outcome, error)
    end function c_free

    !> Numbers of an object.
    subroutine get(object, item, values, outcome)
        class(object_t), intent(in) :: object
        character(*), intent(in) :: item                !! Its name, or several with blanks between them
        real(dp), allocatable, intent(out) :: values(:) !! In the items' units, in C's order
        type(outcome_t), intent(inout) :: outcome

        type(items_t) :: items

        call items%want_numbers(item)
        call ask(object, .false., items, outcome)
        if (outcome%good()) call items%numbers(values)
    end subroutine get

    !> A text of an object.
    subroutine get_text(object, item, text, outcome)
        class(object_t), intent(in) :: object
        character(*), intent(in) :: item                    !! Its name
        character(:), allocatable, intent(out) :: text    !! What the item says
        type(outcome_t), intent(inout) :: outcome

        type(items_t) :: items

        call items%want_text(item)
        call ask(object, .true., items, outcome)
        call move_alloc(items%text, text)
    end subroutine get_text

    subroutine ask(object, text, items, outcome)
        class(object_t), intent(in) :: object
        logical, intent(in) :: text             !! It has to be one
        type(items_t), intent(inout) :: items   !! Those that are wanted are known
        type(outcome_t), intent(inout) :: outcome

        call object%tell(items)
        call outcome%take(items%failure)
        call items%require_found(text, outcome)
    end subroutine ask

    !> Stores a new object and gives its handle out; without room, or after a failure, the object is deallocated.
    subroutine keep(object, handle, outcome)
        class(object_t), pointer, intent(inout) :: object   !! Not associated: nothing was made
        integer(c_intptr_t), intent(inout), optional :: handle  !! Of the object; absent after a failure only
        type(outcome_t), intent(inout) :: outcome

        integer :: number

        if (.not. associated(object)) return
        number = 0
        if (leaves_object(outcome%status)) then
            call store(object, number)
            if (number == 0) then
                outcome%status = STATUS_OK
                call outcome%refuse(STATUS_NO_MEMORY, 'there are '//integer_text(MAX_OBJECTS)// &
                                    ' objects already; free those that are not needed')
            end if
        end if
        if (number == 0) deallocate (object)
        if (present(handle)) handle = number
    end subroutine keep

    !> Memory for an object was had.
    subroutine check_memory(memory, outcome)
        integer, intent(in) :: memory       !! Of an allocation: 0 when all is well
        type(outcome_t), intent(inout) :: outcome

        if (memory /= 0) call outcome%refuse(STATUS_NO_MEMORY, 'no memory for a new object')
    end subroutine check_memory

    !> The handle is not what it should be.
    subroutine refuse_handle(name, outcome)
        character(*), intent(in) :: name        !! Of the object that is wanted
        type(outcome_t), intent(inout) :: outcome

        call outcome%refuse(STATUS_BAD_HANDLE, 'the handle is not that of '// &
                            trim(merge('an', 'a ', scan(name(:1), 'aeiou') > 0))//' '//name// &
                            ': it was never made, was freed, or is of another kind')
    end subroutine refuse_handle
end module gracecg_interface_general
