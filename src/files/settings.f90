!> Settings in namelist files, described once for reading and writing.
!>
!> A record (a case, the setup of an observation set) is described by one procedure that names each
!> of its settings in turn to a `settings_t`. A reader fills the settings from a file, a writer puts
!> them into one. So what is written can be read, with the same keys, units, ranges and choices.
module gracecg_files_settings
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: integer_text, join
    use gracecg_files_namelist, only: namelist_file_t, namelist_writer_t
    implicit none
    private
    public :: settings_t, settings_reader_t, settings_writer_t, FULL_RANGE

    real(dp), parameter :: FULL_RANGE = 1e30_dp     !! A limit for what has no natural one

    !> What a description talks to. After the first failure nothing more is done.
    type, abstract :: settings_t
        type(error_t), allocatable :: failure   !! The first thing that went wrong
        character(:), allocatable, private :: group_name
        integer, private :: group_index = 1
    contains
        procedure(group_interface), deferred :: group           !! Begins a group
        procedure(end_group_interface), deferred :: end_group   !! Ends the group
        procedure(count_interface), deferred :: count           !! How many groups of a name there are
        procedure :: holds                                      !! Is there such a group to be read?
        procedure(real_interface), deferred :: real_value       !! A number
        procedure(reals_interface), deferred :: real_values     !! Several numbers
        procedure(integer_interface), deferred :: integer_value !! An integer
        procedure(logical_interface), deferred :: logical_value !! A logical
        procedure(text_interface), deferred :: text_value       !! A text
        procedure(reject_interface), deferred :: reject         !! Refuses the value of a key
    end type settings_t

    abstract interface
        !> Begins a group; `index` counts groups of one name.
        subroutine group_interface(self, name, meaning, index)
            import :: settings_t
            class(settings_t), intent(inout) :: self
            character(*), intent(in) :: name, meaning
            integer, intent(in), optional :: index
        end subroutine group_interface

        subroutine end_group_interface(self)
            import :: settings_t
            class(settings_t), intent(inout) :: self
        end subroutine end_group_interface

        !> How many groups of this name there are: n in, the file's number out when reading.
        subroutine count_interface(self, name, n)
            import :: settings_t
            class(settings_t), intent(inout) :: self
            character(*), intent(in) :: name
            integer, intent(inout) :: n
        end subroutine count_interface

        !> A number. In the file it stands in a unit of its own: value = number times `factor`.
        !> Without `required` the value on entry is the default.
        subroutine real_interface(self, key, value, low, high, meaning, factor, unit, required)
            import :: settings_t, dp
            class(settings_t), intent(inout) :: self
            character(*), intent(in) :: key, meaning
            real(dp), intent(inout) :: value
            real(dp), intent(in) :: low, high               !! Allowed range, in the file's unit
            real(dp), intent(in), optional :: factor        !! 1 when absent
            character(*), intent(in), optional :: unit      !! In the file, for messages
            logical, intent(in), optional :: required
        end subroutine real_interface

        subroutine reals_interface(self, key, values, low, high, meaning, factor, unit, required)
            import :: settings_t, dp
            class(settings_t), intent(inout) :: self
            character(*), intent(in) :: key, meaning
            real(dp), intent(inout) :: values(:)
            real(dp), intent(in) :: low, high
            real(dp), intent(in), optional :: factor
            character(*), intent(in), optional :: unit
            logical, intent(in), optional :: required
        end subroutine reals_interface

        subroutine integer_interface(self, key, value, low, high, meaning)
            import :: settings_t
            class(settings_t), intent(inout) :: self
            character(*), intent(in) :: key, meaning
            integer, intent(inout) :: value
            integer, intent(in) :: low, high
        end subroutine integer_interface

        subroutine logical_interface(self, key, value, meaning)
            import :: settings_t
            class(settings_t), intent(inout) :: self
            character(*), intent(in) :: key, meaning
            logical, intent(inout) :: value
        end subroutine logical_interface

        subroutine text_interface(self, key, value, meaning, choices, required)
            import :: settings_t
            class(settings_t), intent(inout) :: self
            character(*), intent(in) :: key, meaning
            character(*), intent(inout) :: value
            character(*), intent(in), optional :: choices(:)
            logical, intent(in), optional :: required
        end subroutine text_interface

        !> Refuses the value of a key of the present group for a reason of the caller's.
        subroutine reject_interface(self, key, problem)
            import :: settings_t
            class(settings_t), intent(inout) :: self
            character(*), intent(in) :: key, problem
        end subroutine reject_interface
    end interface

    !> Fills settings from a namelist file. Call `finish` after the description.
    type, extends(settings_t) :: settings_reader_t
        type(namelist_file_t), private :: file
    contains
        procedure :: open => open_reader    !! Reads the file
        procedure :: open_text              !! Takes a text in memory
        procedure :: finish => finish_reader
        !! Closes it: fails when something failed, or a key was never asked for
        procedure :: group => read_group
        procedure :: end_group => read_end_group
        procedure :: count => read_count
        procedure :: holds => read_holds
        procedure :: real_value => read_real
        procedure :: real_values => read_reals
        procedure :: integer_value => read_integer
        procedure :: logical_value => read_logical
        procedure :: text_value => read_text
        procedure :: reject => read_reject
    end type settings_reader_t

    !> Puts settings into a namelist text.
    type, extends(settings_t) :: settings_writer_t
        type(namelist_writer_t) :: file !! Has the text, to be shown or saved
    contains
        procedure :: group => write_group
        procedure :: end_group => write_end_group
        procedure :: count => write_count
        procedure :: real_value => write_real
        procedure :: real_values => write_reals
        procedure :: integer_value => write_integer
        procedure :: logical_value => write_logical
        procedure :: text_value => write_text
        procedure :: reject => write_reject
    end type settings_writer_t

contains

    !> Is there a group of this name to be read? Where settings are written, none.
    logical function holds(self, name)
        class(settings_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of the group, without the &

        holds = .false.
    end function holds

    subroutine open_reader(self, path, error)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: path    !! Of the file
        type(error_t), allocatable, intent(out) :: error

        call self%file%read(path, error)
    end subroutine open_reader

    !> Takes the settings from a text in memory; `name` stands for the file in messages.
    subroutine open_text(self, text, name, error)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: text, name  !! Content; what stands for the file in messages
        type(error_t), allocatable, intent(out) :: error

        call self%file%parse(text, name, error)
    end subroutine open_text

    !> The first failure of the description, or the first key that nobody asked for.
    subroutine finish_reader(self, error)
        class(settings_reader_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        if (allocated(self%failure)) then
            call move_alloc(self%failure, error)
        else
            call self%file%check_all_used(error)
        end if
    end subroutine finish_reader

    subroutine read_group(self, name, meaning, index)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: name, meaning
        integer, intent(in), optional :: index

        self%group_name = name
        self%group_index = 1
        if (present(index)) self%group_index = index
    end subroutine read_group

    subroutine read_end_group(self)
        class(settings_reader_t), intent(inout) :: self

        self%group_name = ''
    end subroutine read_end_group

    subroutine read_count(self, name, n)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: name
        integer, intent(inout) :: n

        n = self%file%group_count(name)
    end subroutine read_count

    logical function read_holds(self, name) result(holds)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: name

        holds = self%file%group_count(name) > 0
    end function read_holds

    subroutine read_real(self, key, value, low, high, meaning, factor, unit, required)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        real(dp), intent(inout) :: value
        real(dp), intent(in) :: low, high
        real(dp), intent(in), optional :: factor
        character(*), intent(in), optional :: unit
        logical, intent(in), optional :: required

        real(dp) :: values(1)

        values = value
        call self%real_values(key, values, low, high, meaning, factor, unit, required)
        value = values(1)
    end subroutine read_real

    subroutine read_reals(self, key, values, low, high, meaning, factor, unit, required)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        real(dp), intent(inout) :: values(:)
        real(dp), intent(in) :: low, high
        real(dp), intent(in), optional :: factor
        character(*), intent(in), optional :: unit
        logical, intent(in), optional :: required

        real(dp) :: numbers(size(values)), number, scale
        logical :: needed
        integer :: i

        if (allocated(self%failure)) return
        needed = is_true(required)
        if (.not. needed .and. .not. self%file%has(self%group_name, key, self%group_index)) then
            call remember(self, key)
            return
        end if
        scale = 1
        if (present(factor)) scale = factor
        if (size(values) == 1) then
            call self%file%get(self%group_name, key, number, self%failure, low=low, high=high, &
                               unit=unit, index=self%group_index)
            numbers = number
        else
            call self%file%get(self%group_name, key, numbers, self%failure, low=low, high=high, &
                               unit=unit, index=self%group_index)
        end if
        if (allocated(self%failure)) return
        do i = 1, size(values)
            values(i) = in_si_unit(numbers(i), scale)
        end do
    end subroutine read_reals

    !> Makes an absent, optional key known, so that it can be suggested for a misspelt one.
    subroutine remember(self, key)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: key

        real(dp) :: ignored

        call self%file%get(self%group_name, key, ignored, self%failure, default=0.0_dp, &
                           index=self%group_index)
    end subroutine remember

    subroutine read_integer(self, key, value, low, high, meaning)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        integer, intent(inout) :: value
        integer, intent(in) :: low, high

        integer :: default

        if (allocated(self%failure)) return
        default = value
        call self%file%get(self%group_name, key, value, self%failure, default=default, low=low, &
                           high=high, index=self%group_index)
    end subroutine read_integer

    subroutine read_logical(self, key, value, meaning)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        logical, intent(inout) :: value

        logical :: default

        if (allocated(self%failure)) return
        default = value
        call self%file%get(self%group_name, key, value, self%failure, default=default, &
                           index=self%group_index)
    end subroutine read_logical

    subroutine read_text(self, key, value, meaning, choices, required)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        character(*), intent(inout) :: value
        character(*), intent(in), optional :: choices(:)
        logical, intent(in), optional :: required

        character(:), allocatable :: text

        if (allocated(self%failure)) return
        if (is_true(required)) then
            call self%file%get(self%group_name, key, text, self%failure, choices=choices, &
                               index=self%group_index)
        else
            call self%file%get(self%group_name, key, text, self%failure, default=trim(value), &
                               choices=choices, index=self%group_index)
        end if
        if (allocated(self%failure)) return
        if (len(text) > len(value)) then
            call self%reject(key, 'has more than '//integer_text(len(value))//' characters')
        else
            value = text
        end if
    end subroutine read_text

    subroutine read_reject(self, key, problem)
        class(settings_reader_t), intent(inout) :: self
        character(*), intent(in) :: key, problem

        if (.not. allocated(self%failure)) then
            call self%file%reject(self%group_name, key, problem, self%failure, self%group_index)
        end if
    end subroutine read_reject

    subroutine write_group(self, name, meaning, index)
        class(settings_writer_t), intent(inout) :: self
        character(*), intent(in) :: name, meaning
        integer, intent(in), optional :: index

        if (len(meaning) > 0) call self%file%comment(meaning)
        call self%file%group(name)
    end subroutine write_group

    subroutine write_end_group(self)
        class(settings_writer_t), intent(inout) :: self

        call self%file%end_group()
    end subroutine write_end_group

    subroutine write_count(self, name, n)
        class(settings_writer_t), intent(inout) :: self
        character(*), intent(in) :: name
        integer, intent(inout) :: n
    end subroutine write_count

    subroutine write_real(self, key, value, low, high, meaning, factor, unit, required)
        class(settings_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        real(dp), intent(inout) :: value
        real(dp), intent(in) :: low, high
        real(dp), intent(in), optional :: factor
        character(*), intent(in), optional :: unit
        logical, intent(in), optional :: required

        call self%file%entry(key, in_file_unit(value, factor), meaning)
    end subroutine write_real

    subroutine write_reals(self, key, values, low, high, meaning, factor, unit, required)
        class(settings_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        real(dp), intent(inout) :: values(:)
        real(dp), intent(in) :: low, high
        real(dp), intent(in), optional :: factor
        character(*), intent(in), optional :: unit
        logical, intent(in), optional :: required

        integer :: i

        call self%file%entry(key, [(in_file_unit(values(i), factor), i=1, size(values))], meaning)
    end subroutine write_reals

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
        real(dp), intent(in), optional :: factor

        character(*), parameter :: FORMATS(3) = ['(es26.14e3)', '(es26.15e3)', '(es26.16e3)']
        character(26) :: digits
        integer :: i

        number = value
        if (.not. present(factor)) return
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

    subroutine write_integer(self, key, value, low, high, meaning)
        class(settings_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        integer, intent(inout) :: value
        integer, intent(in) :: low, high

        call self%file%entry(key, value, meaning)
    end subroutine write_integer

    subroutine write_logical(self, key, value, meaning)
        class(settings_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        logical, intent(inout) :: value

        call self%file%entry(key, value, meaning)
    end subroutine write_logical

    subroutine write_text(self, key, value, meaning, choices, required)
        class(settings_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, meaning
        character(*), intent(inout) :: value
        character(*), intent(in), optional :: choices(:)
        logical, intent(in), optional :: required

        character(:), allocatable :: comment

        comment = meaning
        if (present(choices)) comment = comment//': '//join(choices, ' ')
        call self%file%entry(key, trim(value), comment)
    end subroutine write_text

    subroutine write_reject(self, key, problem)
        class(settings_writer_t), intent(inout) :: self
        character(*), intent(in) :: key, problem
    end subroutine write_reject

    pure logical function is_true(flag)
        logical, intent(in), optional :: flag

        is_true = .false.
        if (present(flag)) is_true = flag
    end function is_true
end module gracecg_files_settings
