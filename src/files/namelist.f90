!> Files in Fortran's namelist syntax, read so that every mistake is shown with file and line.
!>
!>     &spacecraft                         ! a comment
!>         mass = 432.0                    ! key = value
!>         com_offset = 1e-4, 2*0.0        ! several values, by comma or blank; repeat counts
!>         name = 'front', drag = .true.
!>     /
!>
!> The reader collects groups, keys and values; typed `get`s fetch them, with defaults and limits;
!> `check_all_used` then reports what nobody asked for: a misspelt key. A group may stand several
!> times and is then numbered by `index`. Keys and group names are blind to case. Not taken over
!> from Fortran: elements and components as keys (a(2), a%b), null values, texts over several lines
!> or without quotes.
module gracecg_files_namelist
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, nearest_name
    use gracecg_files_file, only: text_file_t, read_text_file, text_file_of
    use gracecg_files_namelist_syntax, only: value_t, entry_t, group_t, read_groups, count_groups, &
        position_of
    use gracecg_files_namelist_writer, only: namelist_writer_t
    use gracecg_base_text, only: string_t, lower_case, append, join, padded, integer_text
    use gracecg_files_value, only: real_from_text, integer_from_text, logical_from_text, &
        choice_from_text, allowed_real, allowed_integer, allowed_choice, did_you_mean
    implicit none
    private
    public :: namelist_file_t, namelist_writer_t

    type :: known_t
        !! A key that was asked for
        character(:), allocatable :: group, key
    end type known_t

    type :: namelist_file_t
        !! The content of a namelist file
        private
        type(text_file_t) :: source
        type(group_t), allocatable :: groups(:)
        type(known_t), allocatable :: known(:)
    contains
        procedure :: read => read_namelist      !! Reads a file
        procedure :: parse => parse_namelist    !! Reads a text in memory
        procedure :: group_count                !! How many groups have a name
        procedure :: has                        !! Does a key stand in the file?
        procedure :: holds                      !! Does a group, or a key that begins so?
        generic :: get => get_real, get_reals, get_integer, get_logical, get_text
        !! The value or values of a key
        procedure :: reject                     !! A failure about the value of a key
        procedure :: check_all_used             !! Fails when a group or key was never asked for
        ! The specific procedures of a generic stay public: when they are private, gfortran 12
        ! refuses to read the module files of two users of this type ("mismatch in components")
        procedure :: get_real       !! One real number
        procedure :: get_reals      !! Several real numbers
        procedure :: get_integer    !! One integer
        procedure :: get_logical    !! One logical
        procedure :: get_text       !! One text
    end type namelist_file_t

contains

    !> Reads a file. Fails when it cannot be read or breaks the syntax.
    subroutine read_namelist(self, path, error)
        class(namelist_file_t), intent(out) :: self
        character(*), intent(in) :: path    !! Of the file
        type(error_t), allocatable, intent(out) :: error

        call read_text_file(path, self%source, error)
        if (allocated(error)) return
        allocate (self%known(0))
        call read_groups(self%source, self%groups, error)
    end subroutine read_namelist

    !> Reads a text in memory; `name` stands for the file in messages.
    subroutine parse_namelist(self, text, name, error)
        class(namelist_file_t), intent(out) :: self
        character(*), intent(in) :: text, name  !! Content; what stands for the file in messages
        type(error_t), allocatable, intent(out) :: error

        self%source = text_file_of(text, name)
        allocate (self%known(0))
        call read_groups(self%source, self%groups, error)
    end subroutine parse_namelist

    !> How often a group stands in the file.
    integer function group_count(self, group)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group       !! Its name, without the &

        integer :: i

        group_count = count_groups(self%groups, lower_case(group))
        do i = 1, size(self%groups)
            if (self%groups(i)%name == lower_case(group)) self%groups(i)%used = .true.
        end do
        if (.not. any([(self%known(i)%group == lower_case(group), i=1, size(self%known))])) &
            call remember(self, lower_case(group), '')
    end function group_count

    !> Does the key stand in the file? Asking does not mark it as used.
    logical function has(self, group, key, index)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: group, key      !! Their names, in whatever case
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        integer :: i

        i = group_position(self, group, index)
        has = i > 0
        if (has) has = position_of(self%groups(i), lower_case(key)) > 0
    end function has

    !> Does a group stand in the file, or a key in its first one whose name begins with `key`? Asking does not
    !> mark it as used.
    pure logical function holds(self, group, key)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: group               !! Its name, in whatever case
        character(*), intent(in), optional :: key       !! The beginning of its name, in lower case

        integer :: i, j

        i = group_position(self, group)
        holds = i > 0
        if (holds .and. present(key)) &
            holds = any([(index(self%groups(i)%entries(j)%key, key) == 1, j=1, size(self%groups(i)%entries))])
    end function holds

    !> One real number. Fails when the key is missing and has no default, or its value is not one
    !> finite number within the limits (both ends included).
    subroutine get_real(self, group, key, value, error, default, low, high, unit, index)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key      !! Their names, in whatever case
        real(dp), intent(out) :: value              !! In the file's unit
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: default, low, high    !! Allowed range, in the file's unit
        character(*), intent(in), optional :: unit  !! Of the range, for the message
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        type(entry_t) :: entry
        character(:), allocatable :: problem
        logical :: found

        value = 0
        if (present(default)) value = default
        call look_up(self, group, key, index, trim(allowed_real(low, high, unit)), 1, &
                     .not. present(default), entry, found, error)
        if (.not. found) return
        call real_from_value(entry%values(1), value, problem, low, high, unit)
        if (allocated(problem)) call reject(self, group, key, problem, error, index)
    end subroutine get_real

    !> As many real numbers as `value` has elements, each within the limits.
    subroutine get_reals(self, group, key, value, error, default, low, high, unit, index)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key          !! Their names, in whatever case
        real(dp), intent(out) :: value(:)               !! In the file's unit
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: default(:)    !! As long as `value`
        real(dp), intent(in), optional :: low, high     !! Allowed range of each, in the file's unit
        character(*), intent(in), optional :: unit      !! Of the range, for the message
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        type(entry_t) :: entry
        character(:), allocatable :: problem
        logical :: found
        integer :: i

        value = 0
        if (present(default)) value = default
        call look_up(self, group, key, index, integer_text(size(value))//' numbers, each '// &
                     trim(allowed_real(low, high, unit)), size(value), .not. present(default), &
                     entry, found, error)
        if (.not. found) return
        do i = 1, size(value)
            call real_from_value(entry%values(i), value(i), problem, low, high, unit)
            if (.not. allocated(problem)) cycle
            call reject(self, group, key, 'value '//integer_text(i)//': '//problem, error, index, &
                        item=i)
            return
        end do
    end subroutine get_reals

    subroutine real_from_value(given, value, problem, low, high, unit)
        type(value_t), intent(in) :: given
        real(dp), intent(out) :: value
        character(:), allocatable, intent(out) :: problem
        real(dp), intent(in), optional :: low, high
        character(*), intent(in), optional :: unit

        if (given%quoted) then
            value = 0
            problem = 'a text in quotes; it must be '//trim(allowed_real(low, high, unit))
        else
            call real_from_text(given%text, value, problem, low, high, unit)
        end if
    end subroutine real_from_value

    !> One integer.
    subroutine get_integer(self, group, key, value, error, default, low, high, index)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key      !! Their names, in whatever case
        integer, intent(out) :: value               !! As in the file, or the default
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: default, low, high !! Allowed range
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        type(entry_t) :: entry
        character(:), allocatable :: problem
        logical :: found

        value = 0
        if (present(default)) value = default
        call look_up(self, group, key, index, trim(allowed_integer(low, high)), 1, &
                     .not. present(default), entry, found, error)
        if (.not. found) return
        if (entry%values(1)%quoted) then
            problem = 'a text in quotes; it must be '//trim(allowed_integer(low, high))
        else
            call integer_from_text(entry%values(1)%text, value, problem, low, high)
        end if
        if (allocated(problem)) call reject(self, group, key, problem, error, index)
    end subroutine get_integer

    !> One logical.
    subroutine get_logical(self, group, key, value, error, default, index)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key      !! Their names, in whatever case
        logical, intent(out) :: value               !! As in the file, or the default
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: default    !! Without it the key is required
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        type(entry_t) :: entry
        character(:), allocatable :: problem
        logical :: found

        value = .false.
        if (present(default)) value = default
        call look_up(self, group, key, index, '.true. or .false.', 1, .not. present(default), &
                     entry, found, error)
        if (.not. found) return
        if (entry%values(1)%quoted) then
            problem = 'a text in quotes; it must be .true. or .false. without quotes'
        else
            call logical_from_text(entry%values(1)%text, value, problem)
        end if
        if (allocated(problem)) call reject(self, group, key, problem, error, index)
    end subroutine get_logical

    !> One text in quotes; with `choices`, one of these, in whatever case, returned in their
    !> spelling.
    subroutine get_text(self, group, key, value, error, default, choices, index)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key      !! Their names, in whatever case
        character(:), allocatable, intent(out) :: value !! As in the file, or the default
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: default   !! Without it the key is required
        character(*), intent(in), optional :: choices(:)    !! What is allowed; anything when absent
        integer, intent(in), optional :: index      !! Which group of that name; 1 if absent

        type(entry_t) :: entry
        character(:), allocatable :: problem, allowed
        logical :: found

        value = ''
        if (present(default)) value = default
        allowed = 'a text in quotes'
        if (present(choices)) allowed = allowed//', '//allowed_choice(choices)
        call look_up(self, group, key, index, allowed, 1, .not. present(default), entry, found, &
                     error)
        if (.not. found) return
        value = entry%values(1)%text
        if (.not. entry%values(1)%quoted) then
            problem = value//' is not in quotes; it must be '//allowed
        else if (present(choices)) then
            call choice_from_text(entry%values(1)%text, choices, value, problem)
        end if
        if (allocated(problem)) call reject(self, group, key, problem, error, index)
    end subroutine get_text

    !> Finds an entry and marks it as used. Fails when it is missing but required, or has another
    !> number of values.
    subroutine look_up(self, group, key, index, allowed, number_of_values, required, entry, &
                       found, error)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key
        integer, intent(in), optional :: index
        character(*), intent(in) :: allowed         !! What the value must be
        integer, intent(in) :: number_of_values
        logical, intent(in) :: required
        type(entry_t), intent(out) :: entry
        logical, intent(out) :: found               !! False too after a failure
        type(error_t), allocatable, intent(out) :: error

        integer :: i, j

        call remember(self, lower_case(group), lower_case(key))
        i = group_position(self, group, index)
        j = 0
        if (i > 0) then
            self%groups(i)%used = .true.
            j = position_of(self%groups(i), lower_case(key))
        end if
        found = j > 0
        if (.not. found) then
            if (required) &
                call fail_missing(self, lower_case(group), lower_case(key), i, index, allowed, &
                                  error)
            return
        end if
        self%groups(i)%entries(j)%used = .true.
        entry = self%groups(i)%entries(j)
        found = size(entry%values) == number_of_values
        if (.not. found) &
            call reject(self, group, key, integer_text(size(entry%values))//' values; it must '// &
                        'be '//allowed, error, index)
    end subroutine look_up

    subroutine fail_missing(self, group, key, position, index, allowed, error)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: group, key
        integer, intent(in) :: position             !! Of the group; 0 when that is missing too
        integer, intent(in), optional :: index
        character(*), intent(in) :: allowed
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: unused(:)
        character(:), allocatable :: needed, name, near
        integer :: j

        name = 'group &'//group
        if (present(index)) name = name//' number '//integer_text(index)
        needed = 'the key "'//key//'" ('//allowed//')'
        if (position == 0) then
            call fail(error, self%source%name//': the '//name//' is missing; it must have '//needed)
            return
        end if
        allocate (unused(0))
        do j = 1, size(self%groups(position)%entries)
            associate (entry => self%groups(position)%entries(j))
                if (.not. entry%used) call append(unused, entry%key)
            end associate
        end do
        near = nearest_name(key, padded(unused))
        if (near /= '') near = '; is "'//near//'" there a misspelling of it?'
        call self%source%fail_at(self%groups(position)%line, needed//' is missing in the '//name// &
                                 near, error)
    end subroutine fail_missing

    !> A failure about the value of a key, for a check of the caller's own: names file, line and
    !> key, and shows the line.
    subroutine reject(self, group, key, problem, error, index, item)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: group, key  !! Their names, in whatever case
        character(*), intent(in) :: problem     !! What is wrong with it, and what is allowed
        type(error_t), allocatable, intent(out) :: error
        integer, intent(in), optional :: index  !! Which group of that name; 1 if absent
        integer, intent(in), optional :: item   !! Which of the values; the first if absent

        character(:), allocatable :: message
        integer :: i, j, k

        message = 'key "'//lower_case(key)//'" of group &'//lower_case(group)//': '//problem
        i = group_position(self, group, index)
        j = 0
        if (i > 0) j = position_of(self%groups(i), lower_case(key))
        if (j == 0) then
            call fail(error, self%source%name//': '//message)
            return
        end if
        k = 1
        if (present(item)) k = item
        call self%source%fail_at(self%groups(i)%entries(j)%values(k)%line, message, error)
    end subroutine reject

    !> Fails for the first group or key of the file that nobody asked for.
    subroutine check_all_used(self, error, others, only)
        class(namelist_file_t), intent(in) :: self
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: others(:)     !! Groups that are not checked, in lower case
        character(*), intent(in), optional :: only(:)       !! Groups that alone are checked

        integer :: i, j

        do i = 1, size(self%groups)
            if (present(others)) then
                if (any(others == self%groups(i)%name)) cycle
            end if
            if (present(only)) then
                if (.not. any(only == self%groups(i)%name)) cycle
            end if
            if (.not. self%groups(i)%used) then
                call fail_unknown_group(self, self%groups(i), error, others)
                return
            end if
            do j = 1, size(self%groups(i)%entries)
                if (self%groups(i)%entries(j)%used) cycle
                call fail_unknown_key(self, self%groups(i)%name, self%groups(i)%entries(j), error)
                return
            end do
        end do
    end subroutine check_all_used

    subroutine fail_unknown_group(self, group, error, others)
        class(namelist_file_t), intent(in) :: self
        type(group_t), intent(in) :: group
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: others(:)

        type(string_t), allocatable :: names(:)
        character(:), allocatable :: problem
        integer :: i

        allocate (names, source=known_names(self))
        if (present(others)) then
            do i = 1, size(others)
                if (.not. any(padded(names) == others(i))) call append(names, trim(others(i)))
            end do
        end if
        if (any(padded(names) == group%name)) then
            problem = ' stands here once too often'
        else
            problem = ' is not known'//did_you_mean(group%name, padded(names))// &
                      '; known: '//join(padded(names), ', ')
        end if
        call self%source%fail_at(group%line, 'the group &'//group%name//problem, error)
    end subroutine fail_unknown_group

    subroutine fail_unknown_key(self, group, entry, error)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: group
        type(entry_t), intent(in) :: entry
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: names(:)

        allocate (names, source=known_names(self, group))
        call self%source%fail_at(entry%line, 'the key "'//entry%key//'" is not known in the '// &
                                 'group &'//group//did_you_mean(entry%key, padded(names))// &
                                 '; known: '//join(padded(names), ', '), error)
    end subroutine fail_unknown_key

    !> The keys of a group that were asked for; without `group`, the groups.
    function known_names(self, group) result(names)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in), optional :: group
        type(string_t), allocatable :: names(:)

        integer :: i

        allocate (names(0))
        do i = 1, size(self%known)
            associate (known => self%known(i))
                if (.not. present(group)) then
                    if (any(padded(names) == known%group)) cycle
                    call append(names, known%group)
                else if (known%group == group .and. known%key /= '') then
                    call append(names, known%key)
                end if
            end associate
        end do
    end function known_names

    !> Notes that a key was asked for, once.
    subroutine remember(self, group, key)
        class(namelist_file_t), intent(inout) :: self
        character(*), intent(in) :: group, key

        type(known_t), allocatable :: longer(:)
        integer :: i, n

        n = size(self%known)
        do i = 1, n
            if (self%known(i)%group == group .and. self%known(i)%key == key) return
        end do
        allocate (longer(n + 1))
        longer(:n) = self%known
        longer(n + 1)%group = group
        longer(n + 1)%key = key
        call move_alloc(longer, self%known)
    end subroutine remember

    !> Position of a group in the file's list; 0 when it is not there.
    pure integer function group_position(self, name, index) result(position)
        class(namelist_file_t), intent(in) :: self
        character(*), intent(in) :: name
        integer, intent(in), optional :: index

        integer :: wanted

        wanted = 1
        if (present(index)) wanted = index
        do position = 1, size(self%groups)
            if (self%groups(position)%name == lower_case(name) .and. &
                self%groups(position)%index == wanted) return
        end do
        position = 0
    end function group_position
end module gracecg_files_namelist
