!> Settings in namelist files, described once for reading and writing.
!>
!> A record (a case, the setup of an observation set) is described by one procedure that names each
!> of its settings in turn to a `settings_t`. After `open` that fills them from the file, without it
!> it puts them into a text. So what is written can be read, with the same keys, units, ranges and
!> choices.
module gracecg_files_settings
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, join
    use gracecg_files_namelist, only: namelist_file_t, namelist_writer_t
    implicit none
    private
    public :: settings_t, FULL_RANGE

    real(dp), parameter :: FULL_RANGE = 1e30_dp     !! A limit for what has no natural one

    !> What a description talks to. After the first failure nothing more is done.
    !>
    !>     type(settings_t) :: settings                    type(settings_t) :: settings
    !>     call settings%open('case.nml', error)           call describe(settings, record)
    !>     call describe(settings, record)                 call settings%save('case.nml', error)
    !>     call settings%finish(error)
    type :: settings_t
        type(error_t), allocatable :: failure   !! The first thing that went wrong
        logical, private :: reading = .false.
        type(namelist_file_t), private :: source
        type(namelist_writer_t), private :: target
        character(:), allocatable, private :: group_name
        integer, private :: group_index = 1
    contains
        procedure :: open => open_settings  !! Reads a file, whose settings the description then fills in
        procedure :: open_text              !! The same of a text in memory
        procedure :: finish                 !! After reading: fails when something failed, or a key was never asked for
        procedure :: to_text                !! What was written
        procedure :: save => save_settings  !! The same into a file
        procedure :: comment                !! Writes a line of comment
        procedure :: group                  !! Begins a group
        procedure :: end_group              !! Ends the group
        procedure :: count => count_groups  !! How many groups of a name there are
        procedure :: holds                  !! Is there such a group, or key, to be read?
        procedure :: real_value             !! A number
        procedure :: real_values            !! Several numbers
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

        self%reading = .true.
        call self%source%read(path, error)
    end subroutine open_settings

    !> Takes the settings from a text in memory; `name` stands for the file in messages.
    subroutine open_text(self, text, name, error)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: text, name  !! Content; what stands for the file in messages
        type(error_t), allocatable, intent(out) :: error

        self%reading = .true.
        call self%source%parse(text, name, error)
    end subroutine open_text

    !> The first failure of the description, or the first group or key that nobody asked for. A file may have
    !> groups of others, which these are to check.
    subroutine finish(self, error, others, only)
        class(settings_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: others(:)     !! Groups that are not checked
        character(*), intent(in), optional :: only(:)       !! Groups that alone are checked

        if (allocated(self%failure)) then
            call move_alloc(self%failure, error)
        else if (self%reading) then
            call self%source%check_all_used(error, others, only)
        end if
    end subroutine finish

    !> What was written so far, without a line end at the end. Fails when a setting is not finite.
    subroutine to_text(self, text, error)
        class(settings_t), intent(in) :: self
        character(:), allocatable, intent(out) :: text  !! Lines separated by line feeds
        type(error_t), allocatable, intent(out) :: error

        call self%target%to_text(text, error)
    end subroutine to_text

    !> Saves what was written; fails as `to_text` does, or when the file cannot be written.
    subroutine save_settings(self, path, error)
        class(settings_t), intent(in) :: self
        character(*), intent(in) :: path    !! Of the file to write; an existing one is replaced
        type(error_t), allocatable, intent(out) :: error

        call self%target%save(path, error)
    end subroutine save_settings

    !> A line of comment in what is written.
    subroutine comment(self, text)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: text    !! Without the exclamation mark

        if (.not. self%reading) call self%target%comment(text)
    end subroutine comment

    !> Begins a group; `index` counts groups of one name.
    subroutine group(self, name, meaning, index)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: name, meaning   !! Without the &; written above it as a comment
        integer, intent(in), optional :: index      !! 1 when absent

        self%group_name = name
        self%group_index = 1
        if (present(index)) self%group_index = index
        if (self%reading) return
        if (len(meaning) > 0) call self%target%comment(meaning)
        call self%target%group(name)
    end subroutine group

    subroutine end_group(self)
        class(settings_t), intent(inout) :: self

        self%group_name = ''
        if (.not. self%reading) call self%target%end_group()
    end subroutine end_group

    !> How many groups of this name there are: n in, the file's number out when reading.
    subroutine count_groups(self, name, n)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: name    !! Without the &
        integer, intent(inout) :: n
        !! Number of groups of that name

        if (self%reading) n = self%source%group_count(name)
    end subroutine count_groups

    !> Is there a group of this name to be read, or a key whose name begins so? Where settings are written, none.
    logical function holds(self, name, key)
        class(settings_t), intent(in) :: self
        character(*), intent(in) :: name    !! Without the &
        character(*), intent(in), optional :: key   !! In the first group of the name

        holds = self%reading
        if (holds) holds = self%source%holds(name, key)
    end function holds

    !> A number. In the file it stands in a unit of its own: value = number times `factor`.
    !> Without `required` the value on entry is the default.
    subroutine real_value(self, key, value, low, high, meaning, factor, unit, required)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning        !! Its name; written behind the value
        real(dp), intent(inout) :: value                !! In SI units
        real(dp), intent(in) :: low, high               !! Allowed range, in the file's unit
        real(dp), intent(in), optional :: factor        !! 1 when absent
        character(*), intent(in), optional :: unit      !! In the file, for messages
        logical, intent(in), optional :: required
        !! Must stand in a file; absent: no

        real(dp) :: values(1)

        values = value
        call self%real_values(key, values, low, high, meaning, factor, unit, required)
        value = values(1)
    end subroutine real_value

    !> As many numbers as `values` has elements, each as `real_value`.
    subroutine real_values(self, key, values, low, high, meaning, factor, unit, required)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        !! Name of the setting
        real(dp), intent(inout) :: values(:)
        !! The settings, in SI units
        real(dp), intent(in) :: low, high
        !! Greatest value allowed, in the file's unit
        real(dp), intent(in), optional :: factor
        !! SI units in a unit of the file; absent: 1
        character(*), intent(in), optional :: unit
        !! Of the file, for messages; absent: none
        logical, intent(in), optional :: required
        !! Must stand in a file; absent: no

        real(dp) :: numbers(size(values)), scale
        integer :: i

        scale = 1
        if (present(factor)) scale = factor
        if (.not. self%reading) then
            call self%target%entry(key, [(in_file_unit(values(i), scale), i=1, size(values))], meaning)
            return
        end if
        if (allocated(self%failure)) return
        if (.not. is_true(required) .and. .not. self%source%has(self%group_name, key, self%group_index)) then
            call remember(self, key)
            return
        end if
        if (size(values) == 1) then
            call self%source%get(self%group_name, key, numbers(1), self%failure, low=low, high=high, unit=unit, &
                                 index=self%group_index)
        else
            call self%source%get(self%group_name, key, numbers, self%failure, low=low, high=high, unit=unit, &
                                 index=self%group_index)
        end if
        if (.not. allocated(self%failure)) values = [(in_si_unit(numbers(i), scale), i=1, size(values))]
    end subroutine real_values

    !> Makes an absent, optional key known, so that it can be suggested for a misspelt one.
    subroutine remember(self, key)
        type(settings_t), intent(inout) :: self
        character(*), intent(in) :: key

        real(dp) :: ignored

        call self%source%get(self%group_name, key, ignored, self%failure, default=0.0_dp, &
                             index=self%group_index)
    end subroutine remember

    !> An integer. The value on entry is the default.
    subroutine integer_value(self, key, value, low, high, meaning)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning    !! Its name; written behind the value
        integer, intent(inout) :: value
        !! The setting, in SI units
        integer, intent(in) :: low, high            !! Allowed range

        integer :: default

        default = value
        if (.not. self%reading) then
            call self%target%entry(key, value, meaning)
        else if (.not. allocated(self%failure)) then
            call self%source%get(self%group_name, key, value, self%failure, default=default, low=low, &
                                 high=high, index=self%group_index)
        end if
    end subroutine integer_value

    !> A logical. The value on entry is the default.
    subroutine logical_value(self, key, value, meaning)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning    !! Its name; written behind the value
        logical, intent(inout) :: value
        !! The setting, in SI units

        logical :: default

        default = value
        if (.not. self%reading) then
            call self%target%entry(key, value, meaning)
        else if (.not. allocated(self%failure)) then
            call self%source%get(self%group_name, key, value, self%failure, default=default, &
                                 index=self%group_index)
        end if
    end subroutine logical_value

    !> A text, one of `choices` where these are given. Without `required` the value on entry is the
    !> default. One that is longer than `value` is refused.
    subroutine text_value(self, key, value, meaning, choices, required)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning        !! Its name; written behind the value
        character(*), intent(inout) :: value
        !! The setting, in SI units
        character(*), intent(in), optional :: choices(:)
        !! Allowed texts; absent: any
        logical, intent(in), optional :: required
        !! Must stand in a file; absent: no

        character(:), allocatable :: text

        if (.not. self%reading) then
            text = meaning
            if (present(choices)) text = text//': '//join(choices, ' ')
            call self%target%entry(key, trim(value), text)
            return
        end if
        if (allocated(self%failure)) return
        if (is_true(required)) then
            call self%source%get(self%group_name, key, text, self%failure, choices=choices, &
                                 index=self%group_index)
        else
            call self%source%get(self%group_name, key, text, self%failure, default=trim(value), &
                                 choices=choices, index=self%group_index)
        end if
        if (allocated(self%failure)) return
        if (len(text) > len(value)) then
            call self%reject(key, 'has more than '//integer_text(len(value))//' characters')
        else
            value = text
        end if
    end subroutine text_value

    !> Refuses the value of a key of the present group for a reason of the caller's. What is written
    !> is not judged.
    subroutine reject(self, key, problem)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: key, problem    !! What is wrong with it, and what is allowed

        if (self%reading .and. .not. allocated(self%failure)) &
            call self%source%reject(self%group_name, key, problem, self%failure, self%group_index)
    end subroutine reject

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

    pure logical function is_true(flag)
        logical, intent(in), optional :: flag

        is_true = .false.
        if (present(flag)) is_true = flag
    end function is_true
end module gracecg_files_settings
