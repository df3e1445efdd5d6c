!> Settings in namelist files, described once for reading and writing.
!>
!> A record (a case, the setup of an observation set) is described by one procedure that names each of its settings
!> in turn to a `settings_t`. After `open` that fills them from the file, without it it puts them into a text. So what
!> is written can be read, with the same keys, units, ranges and choices.
module gracecg_files_settings
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t, fail, add_context, nearest_name
    use gracecg_base_text, only: string_t, append, padded, join, lower_case, real_text, integer_text, quoted_text
    use gracecg_files_file, only: text_file_t, read_text_file, text_file_of, output_file_t
    use gracecg_files_namelist, only: entry_t, read_namelist
    use gracecg_files_value, only: real_from_text, integer_from_text, logical_from_text, choice_from_text, &
        allowed_real, allowed_integer, allowed_choice, did_you_mean
    implicit none
    private
    public :: settings_t, FULL_RANGE

    real(dp), parameter :: FULL_RANGE = 1e30_dp     !! A limit for what has no natural one
    character(*), parameter :: LF = achar(10), CR = achar(13)
    integer, parameter :: LARGEST_FILE = 16     !! That is read as settings, MB

    !> What a description talks to. After the first failure nothing more is done.
    !>
    !>     type(settings_t) :: settings                    type(settings_t) :: settings
    !>     call settings%open('case.nml', error)           call describe(settings, record)
    !>     call describe(settings, record)                 call settings%save('case.nml', error)
    !>     call settings%finish(error)
    type :: settings_t
        type(error_t), allocatable :: failure   !! The first thing that went wrong
        logical, private :: reading = .false.
        logical, private :: checking = .false.              ! what would be written, without writing it
        character(:), allocatable, private :: group_name    ! the present one
        integer, private :: group_index = 1                 ! which of that name
        type(text_file_t), private :: source                ! what is read
        type(entry_t), allocatable, private :: entries(:)   ! its groups and keys
        type(string_t), allocatable, private :: known(:)    ! what was asked for: a group's name, blank, key
        character(:), allocatable, private :: written       ! lines, each with its line end
    contains
        procedure :: open => open_settings  !! Reads a file, whose settings the description then fills in
        procedure :: open_text              !! The same of a text in memory
        procedure :: finish                 !! After reading: fails when something failed, or a key was never asked for
        procedure :: check_only             !! What is described from now on is only checked
        procedure :: to_text                !! What was written
        procedure :: save => save_settings  !! The same into a file
        procedure :: comment                !! Writes a line of comment
        procedure :: group                  !! Begins a group
        procedure :: end_group              !! Ends the group
        procedure :: count => count_groups  !! How many groups of a name there are
        procedure :: holds                  !! Is there such a group, or key, to be read?
        procedure :: line_of                !! Where a key stands
        procedure :: real_value             !! A number
        procedure :: real_values            !! Several numbers
        procedure :: real_list              !! Any number of numbers
        procedure :: integer_value          !! An integer
        procedure :: logical_value          !! A logical
        procedure :: text_value             !! A text
        procedure :: reject                 !! Refuses the value of a key
    end type settings_t

contains

    !> Reads a file. Fails when it cannot be read or breaks the syntax.
    subroutine open_settings(self, path, error)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: path    !! Of the file
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: source

        call read_text_file(path, source, error, LARGEST_FILE)
        if (.not. allocated(error)) call self%open_text(source%text, source%name, error)
    end subroutine open_settings

    !> Takes the settings from a text in memory; `name` stands for the file in messages.
    subroutine open_text(self, text, name, error)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: text, name  !! Content; what stands for the file in messages
        type(error_t), allocatable, intent(out) :: error

        self%reading = .true.
        self%source = text_file_of(text, name)
        if (allocated(self%known)) deallocate (self%known)
        allocate (self%known(0))
        call read_namelist(self%source, self%entries, error)
    end subroutine open_text

    !> The first failure of the description, or the first group or key that nobody asked for. A file may have
    !> groups of others, which these are to check; one whose name is nearly that of a group read here is none.
    subroutine finish(self, error, others, only)
        class(settings_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: others(:)     !! Groups that are not checked
        character(*), intent(in), optional :: only(:)       !! Groups that alone are checked

        integer :: i

        call move_alloc(self%failure, error)
        if (allocated(error) .or. .not. self%reading) return
        do i = 1, size(self%entries)
            associate (entry => self%entries(i))
                if (entry%used) cycle
                if (present(others)) then
                    if (any(others == entry%group)) cycle
                end if
                if (present(only)) then
                    if (.not. any(only == entry%group) .and. nearest_name(entry%group, only) == '') cycle
                end if
                call fail_unknown(self, entry, others, error)
                return
            end associate
        end do
    end subroutine finish

    !> Says of a group or key that nobody asked for what there is instead.
    subroutine fail_unknown(self, entry, others, error)
        type(settings_t), intent(in) :: self
        type(entry_t), intent(in) :: entry
        character(*), intent(in), optional :: others(:)
        type(error_t), allocatable, intent(out) :: error

        type(string_t), allocatable :: names(:)
        character(:), allocatable :: what, name
        integer :: i, blank

        allocate (names(0))
        do i = 1, size(self%known)
            associate (known => self%known(i)%text)
                blank = index(known, ' ')
                if (entry%key == '') then
                    if (blank == len(known)) call append(names, known(:blank - 1))
                else if (known(:blank - 1) == entry%group .and. blank < len(known)) then
                    call append(names, known(blank + 1:))
                end if
            end associate
        end do
        name = entry%key
        what = 'the key "'//name//'" is not known in the group &'//entry%group
        if (name == '') then
            name = entry%group
            what = 'the group &'//name
            if (present(others)) then
                do i = 1, size(others)
                    if (.not. any(padded(names) == others(i))) call append(names, trim(others(i)))
                end do
            end if
            if (any(padded(names) == name)) then
                call self%source%fail_at(entry%line, what//' stands here once too often', error)
                return
            end if
            what = what//' is not known'
        end if
        call self%source%fail_at(entry%line, what//did_you_mean(name, padded(names))//'; known: '// &
                                 join(padded(names), ', '), error)
    end subroutine fail_unknown

    !> What was written so far, without a line end at the end. Fails when something cannot be written: a number that
    !> is not finite, a text of several lines.
    subroutine to_text(self, text, error)
        class(settings_t), intent(in) :: self
        character(:), allocatable, intent(out) :: text  !! Lines separated by line feeds
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) error = self%failure
        text = ''
        if (allocated(self%written)) text = self%written(:len(self%written) - 1)
    end subroutine to_text

    !> Saves what was written; fails as `to_text` does, or when the file cannot be written.
    subroutine save_settings(self, path, error)
        class(settings_t), intent(in) :: self
        character(*), intent(in) :: path    !! Of the file to write; an existing one is replaced
        type(error_t), allocatable, intent(out) :: error

        type(output_file_t) :: file
        character(:), allocatable :: text

        call self%to_text(text, error)
        call add_context(error, trim(path))
        if (.not. allocated(error)) call file%open(path, error)
        if (allocated(error)) return
        call file%about('!')
        call file%line(text)
        call file%commit(error)
    end subroutine save_settings

    !> What is described from now on must lie in the ranges that it has in a file, and is not written: `finish` tells.
    subroutine check_only(self)
        class(settings_t), intent(inout) :: self

        self%checking = .true.
    end subroutine check_only

    !> A line of comment in what is written.
    subroutine comment(self, text)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Without the exclamation mark

        call put_line(self, trim('! '//text))
    end subroutine comment

    !> Begins a group; `index` counts groups of one name.
    subroutine group(self, name, meaning, index)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: name, meaning   !! Without the &; written above it as a comment
        integer, intent(in), optional :: index      !! 1 when absent

        integer :: place

        self%group_name = name
        self%group_index = 1
        if (present(index)) self%group_index = index
        if (.not. self%reading) then
            if (len(meaning) > 0) call self%comment(meaning)
            call put_line(self, '&'//name)
            return
        end if
        call remember(self, '')
        place = place_of(self, '')
        if (place > 0) self%entries(place)%used = .true.
    end subroutine group

    subroutine end_group(self)
        class(settings_t), intent(inout) :: self

        self%group_name = ''
        call put_line(self, '/')
    end subroutine end_group

    !> How many groups of this name there are: n in, the file's number out when reading.
    subroutine count_groups(self, name, n)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: name    !! Without the &
        integer, intent(inout) :: n         !! Number of groups of that name

        integer :: i

        if (.not. self%reading) return
        self%group_name = name
        call remember(self, '')
        n = 0
        do i = 1, size(self%entries)
            if (self%entries(i)%key /= '' .or. self%entries(i)%group /= lower_case(name)) cycle
            n = n + 1
            self%entries(i)%used = .true.
        end do
    end subroutine count_groups

    !> Is there a group of this name to be read, or a key whose name begins so? Where settings are written, none.
    pure logical function holds(self, name, key)
        class(settings_t), intent(in) :: self
        character(*), intent(in) :: name    !! Without the &
        character(*), intent(in), optional :: key   !! In the first group of the name

        integer :: i

        holds = .false.
        if (.not. self%reading) return
        do i = 1, size(self%entries)
            if (self%entries(i)%group /= name .or. self%entries(i)%index > 1) cycle
            holds = .not. present(key)
            if (present(key)) holds = index(self%entries(i)%key, key) == 1
            if (holds) return
        end do
    end function holds

    !> The line of the file that a key stands in; 0: in none.
    pure integer function line_of(self, group, key) result(line)
        class(settings_t), intent(in) :: self
        character(*), intent(in) :: group, key      !! In lower case, without the &
        integer :: i

        line = 0
        do i = size(self%entries), 1, -1
            if (self%entries(i)%group == group .and. self%entries(i)%key == key) line = self%entries(i)%line
        end do
    end function line_of

    !> A number. In the file it stands in a unit of its own: value = number times `factor`.
    !> Without `required` the value on entry is the default.
    subroutine real_value(self, key, value, low, high, meaning, factor, unit, required)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning        !! Its name; written behind the value
        real(dp), intent(inout) :: value                !! In SI units
        real(dp), intent(in) :: low, high               !! Allowed range, in the file's unit
        real(dp), intent(in), optional :: factor        !! 1 when absent
        character(*), intent(in), optional :: unit      !! In the file, for messages
        logical, intent(in), optional :: required       !! Must stand in a file; absent: no

        real(dp) :: values(1)

        values = value
        call self%real_values(key, values, low, high, meaning, factor, unit, required)
        value = values(1)
    end subroutine real_value

    !> As many numbers as `values` has elements, each as `real_value`.
    subroutine real_values(self, key, values, low, high, meaning, factor, unit, required)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning        !! Its name; written behind the values
        real(dp), intent(inout) :: values(:)            !! In SI units
        real(dp), intent(in) :: low, high               !! Allowed range, in the file's unit
        real(dp), intent(in), optional :: factor        !! SI units in a unit of the file; absent: 1
        character(*), intent(in), optional :: unit      !! Of the file, for messages; absent: none
        logical, intent(in), optional :: required       !! Must stand in a file; absent: no

        real(dp) :: numbers(size(values)), scale
        character(:), allocatable :: text, problem
        integer :: i, place

        scale = 1
        if (present(factor)) scale = factor
        if (.not. self%reading) then
            if (.not. all(ieee_is_finite(values))) call refuse(self, 'key "'//key//'": its value is not a finite number')
            i = findloc(values/scale < low*(1 - epsilon(low)) .or. values/scale > high*(1 + epsilon(high)), .true., 1)
            if (self%checking .and. i > 0) call self%reject(key, real_text(values(i)/scale)//' is outside the allowed range; '// &
                                                            'it must be '//trim(allowed_real(low, high, unit)))
            if (self%checking) return
            text = ''
            do i = 1, size(values)
                text = text//', '//real_text(in_file_unit(values(i), scale))
            end do
            call put_key(self, key, text(3:), meaning)
            return
        end if
        text = trim(allowed_real(low, high, unit))
        if (size(values) > 1) text = integer_text(size(values))//' numbers, each '//text
        call find(self, key, size(values), .false., text, place, required)
        if (place == 0) return
        do i = 1, size(values)
            call real_from_text(self%entries(place)%values(i)%text, numbers(i), problem, low, high, unit)
            if (.not. allocated(problem)) cycle
            if (size(values) > 1) problem = 'value '//integer_text(i)//': '//problem
            call self%reject(key, problem, i)
            return
        end do
        values = [(in_si_unit(numbers(i), scale), i=1, size(values))]
    end subroutine real_values

    !> As many numbers as there are, each as `real_value`; where there are none the key is not written.
    subroutine real_list(self, key, values, low, high, meaning, unit)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning        !! Its name; written behind the values
        real(dp), allocatable, intent(inout) :: values(:)   !! Not allocated: none
        real(dp), intent(in) :: low, high               !! Allowed range
        character(*), intent(in) :: unit                !! For messages

        integer :: place

        if (self%reading .and. .not. allocated(self%failure)) then
            call remember(self, key)
            place = place_of(self, key)
            if (place > 0) then
                if (allocated(values)) deallocate (values)
                allocate (values(size(self%entries(place)%values)))
            end if
        end if
        if (allocated(values)) call self%real_values(key, values, low, high, meaning, unit=unit)
    end subroutine real_list

    !> An integer. The value on entry is the default.
    subroutine integer_value(self, key, value, low, high, meaning)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning    !! Its name; written behind the value
        integer, intent(inout) :: value             !! The setting
        integer, intent(in) :: low, high            !! Allowed range

        character(:), allocatable :: problem
        integer :: place

        if (self%checking .and. (value < low .or. value > high)) &
            call self%reject(key, integer_text(value)//' is outside the allowed range; it must be '// &
                             trim(allowed_integer(low, high)))
        if (.not. self%reading) call put_key(self, key, integer_text(value), meaning)
        call find(self, key, 1, .false., trim(allowed_integer(low, high)), place)
        if (place == 0) return
        call integer_from_text(self%entries(place)%values(1)%text, value, problem, low, high)
        if (allocated(problem)) call self%reject(key, problem)
    end subroutine integer_value

    !> A logical. The value on entry is the default.
    subroutine logical_value(self, key, value, meaning)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning    !! Its name; written behind the value
        logical, intent(inout) :: value             !! The setting

        character(:), allocatable :: problem
        integer :: place

        if (.not. self%reading) call put_key(self, key, trim(merge('.true. ', '.false.', value)), meaning)
        call find(self, key, 1, .false., '.true. or .false., without quotes', place)
        if (place == 0) return
        call logical_from_text(self%entries(place)%values(1)%text, value, problem)
        if (allocated(problem)) call self%reject(key, problem)
    end subroutine logical_value

    !> A text, one of `choices` where these are given, in whatever case: then in their spelling. Without `required`
    !> the value on entry is the default. One that is longer than `value` is refused.
    subroutine text_value(self, key, value, meaning, choices, required)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning            !! Its name; written behind the value
        character(*), intent(inout) :: value                !! The setting
        character(*), intent(in), optional :: choices(:)    !! Allowed texts; absent: any
        logical, intent(in), optional :: required           !! Must stand in a file; absent: no

        character(:), allocatable :: text, problem
        integer :: place

        if (.not. self%reading) then
            text = value
            if (self%checking .and. present(choices)) call choice_from_text(trim(value), choices, text, problem)
            if (allocated(problem)) call self%reject(key, problem)
            if (self%checking) return
            text = meaning
            if (present(choices)) text = text//': '//join(choices, ' ')
            if (scan(value, LF//CR) > 0) call refuse(self, 'key "'//key//'": a text must stand in one line')
            call put_key(self, key, quoted_text(trim(value), ''''), text)
            return
        end if
        text = 'a text in quotes'
        if (present(choices)) text = text//', '//allowed_choice(choices)
        call find(self, key, 1, .true., text, place, required)
        if (place == 0) return
        text = self%entries(place)%values(1)%text
        if (present(choices)) call choice_from_text(self%entries(place)%values(1)%text, choices, text, problem)
        if (.not. allocated(problem) .and. len(text) > len(value)) &
            problem = 'has more than '//integer_text(len(value))//' characters'
        if (allocated(problem)) then
            call self%reject(key, problem)
        else
            value = text
        end if
    end subroutine text_value

    !> Refuses the value of a key of the present group for a reason of the caller's. What is written
    !> is not judged, unless it is only checked.
    subroutine reject(self, key, problem, item)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, problem    !! What is wrong with it, and what is allowed
        integer, intent(in), optional :: item       !! Which of its values; absent: the first

        character(:), allocatable :: message
        integer :: place, k

        if (.not. (self%reading .or. self%checking) .or. allocated(self%failure)) return
        message = 'key "'//lower_case(key)//'" of group &'//lower_case(self%group_name)//': '//problem
        place = 0
        if (self%reading) place = place_of(self, key)
        if (place == 0) then
            if (self%reading) message = self%source%name//': '//message
            call fail(self%failure, message)
            return
        end if
        k = 1
        if (present(item)) k = item
        call self%source%fail_at(self%entries(place)%values(k)%line, message, self%failure)
    end subroutine reject

    !> Finds a key of the present group among what is read: 0 when it is not there, or is not what it must be.
    subroutine find(self, key, values, in_quotes, allowed, place, required)
        type(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, allowed        !! Its name; what its value must be
        integer, intent(in) :: values                   !! How many
        logical, intent(in) :: in_quotes                !! Each a text
        integer, intent(out) :: place
        logical, intent(in), optional :: required       !! Must be there; absent: no

        integer :: i

        place = 0
        if (.not. self%reading .or. allocated(self%failure)) return
        call remember(self, key)
        place = place_of(self, key)
        if (place == 0) then
            if (present(required)) then
                if (required) call fail_missing(self, key, allowed)
            end if
            return
        end if
        associate (entry => self%entries(place))
            entry%used = .true.
            if (size(entry%values) /= values) then
                call self%reject(key, integer_text(size(entry%values))//' values; it must be '//allowed)
            else
                do i = 1, values
                    if (entry%values(i)%quoted .and. .not. in_quotes) then
                        call self%reject(key, 'a text in quotes; it must be '//allowed, i)
                    else if (in_quotes .and. .not. entry%values(i)%quoted) then
                        call self%reject(key, entry%values(i)%text//' is not in quotes; it must be '//allowed, i)
                    end if
                end do
            end if
        end associate
        if (allocated(self%failure)) place = 0
    end subroutine find

    !> A required key is not there; is one that nobody asked for a misspelling of it?
    subroutine fail_missing(self, key, allowed)
        type(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, allowed

        type(string_t), allocatable :: unused(:)
        character(:), allocatable :: needed, name, near
        integer :: i, header

        name = 'group &'//lower_case(self%group_name)
        if (self%group_index > 1) name = name//' number '//integer_text(self%group_index)
        needed = 'the key "'//lower_case(key)//'" ('//allowed//')'
        header = place_of(self, '')
        if (header == 0) then
            call fail(self%failure, self%source%name//': the '//name//' is missing; it must have '//needed)
            return
        end if
        allocate (unused(0))
        do i = header + 1, size(self%entries)
            if (self%entries(i)%key == '') exit
            if (.not. self%entries(i)%used) call append(unused, self%entries(i)%key)
        end do
        near = nearest_name(lower_case(key), padded(unused))
        if (near /= '') near = '; is "'//near//'" there a misspelling of it?'
        call self%source%fail_at(self%entries(header)%line, needed//' is missing in the '//name//near, self%failure)
    end subroutine fail_missing

    !> Place of a key of the present group; of an empty key, the group's. 0 when it is not there.
    pure integer function place_of(self, key) result(place)
        type(settings_t), intent(in) :: self
        character(*), intent(in) :: key

        character(len(key)) :: wanted
        character(len(self%group_name)) :: group

        wanted = lower_case(key)
        group = lower_case(self%group_name)
        do place = 1, size(self%entries)
            associate (entry => self%entries(place))
                if (entry%key == wanted .and. entry%index == self%group_index .and. entry%group == group) return
            end associate
        end do
        place = 0
    end function place_of

    !> Notes that a key of the present group was asked for; of an empty key, the group.
    subroutine remember(self, key)
        type(settings_t), intent(inout) :: self
        character(*), intent(in) :: key

        character(:), allocatable :: text
        integer :: i

        text = lower_case(self%group_name//' '//key)
        do i = 1, size(self%known)
            if (len(self%known(i)%text) == len(text) .and. self%known(i)%text == text) return
        end do
        call append(self%known, text)
    end subroutine remember

    !> Writes a key.
    subroutine put_key(self, key, value, meaning)
        type(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, value, meaning

        call put_line(self, '    '//key//' = '//value//'  ! '//trim(meaning))
    end subroutine put_key

    !> Writes a line, where settings are written.
    subroutine put_line(self, line)
        type(settings_t), intent(inout) :: self
        character(*), intent(in) :: line

        if (self%reading .or. self%checking) return
        if (.not. allocated(self%written)) self%written = ''
        self%written = self%written//line//LF
    end subroutine put_line

    !> Notes the first thing that cannot be written.
    subroutine refuse(self, message)
        type(settings_t), intent(inout) :: self
        character(*), intent(in) :: message

        if (.not. allocated(self%failure)) call fail(self%failure, message)
    end subroutine refuse

    !> number*factor. For a factor that is the reciprocal of an integer, as all decimal prefixes
    !> below one are, by a division: 50 nT are then exactly 50e-9 T.
    pure real(dp) function in_si_unit(number, factor) result(value)
        real(dp), intent(in) :: number
        real(dp), intent(in) :: factor

        real(dp) :: divisor

        divisor = anint(1/factor)
        if (abs(factor*divisor - 1) < 4*epsilon(factor)) then
            value = number/divisor
        else
            value = number*factor
        end if
    end function in_si_unit

    !> The number that gives `value` back when read, with as few digits as do, at least 15. A few
    !> values are out of reach of any number: then the nearest.
    real(dp) function in_file_unit(value, factor) result(number)
        real(dp), intent(in) :: value
        real(dp), intent(in) :: factor

        character(*), parameter :: FORMATS(3) = ['(es26.14e3)', '(es26.15e3)', '(es26.16e3)']
        character(26) :: digits
        integer :: i

        number = value
        if (abs(factor - 1) <= 0) return
        do i = 1, size(FORMATS)
            write (digits, FORMATS(i)) value/factor
            read (digits, *) number
            if (in_si_unit(number, factor) == value) return
        end do
        do i = -1, 1, 2
            number = nearest(value/factor, real(i, dp))
            if (in_si_unit(number, factor) == value) return
        end do
        number = value/factor
    end function in_file_unit
end module gracecg_files_settings
