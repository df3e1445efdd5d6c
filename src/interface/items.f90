!> What an object holds, by name: numbers and texts, of which a caller wants some.
!>
!> An object tells all of its items, one `put` or `say` each. Those that are wanted are kept; all are listed.
module gracecg_interface_items
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_text, only: string_t, integer_text, split_words
    use gracecg_files_value, only: did_you_mean
    use gracecg_interface_outcome, only: outcome_t, STATUS_BAD_VALUE, STATUS_FAILED
    implicit none
    private
    public :: items_t, LIST, lines_of

    character(*), parameter :: LIST = 'items'       !! The text that lists all others
    integer, parameter :: NAME_LENGTH = 32
    character(*), parameter :: LINE = new_line('a')

    !> An item that is wanted.
    type :: wanted_t
        character(NAME_LENGTH) :: name = ''             !! LIST stands for all names
        real(dp), allocatable :: numbers(:)             !! Allocated once they are told
    end type wanted_t

    !> The items as they are told, and those that are wanted.
    type :: items_t
        type(wanted_t), allocatable, private :: wanted(:)       !! In the order of the caller
        character(:), allocatable :: text               !! Of the item that is wanted, or the list
        character(NAME_LENGTH), allocatable, private :: names(:)    !! That have been told
        type(error_t), allocatable :: failure           !! Why what is wanted cannot be told
    contains
        procedure :: want_numbers                       !! Of one item or several
        procedure :: want_text                          !! Of one item
        procedure :: asks                               !! An item whose name begins so is wanted, or the list
        procedure :: say                                !! A text
        procedure, private :: note, keep, put_number, put_vector, put_matrix, put_cube
        generic :: put => put_number, put_vector, put_matrix, put_cube     !! Numbers
        procedure :: require_found                      !! Refuses a name that is none
        procedure :: numbers                            !! Of all that are wanted, one after another
    end type items_t

contains

    subroutine want_numbers(self, names)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: names       !! Blanks between them

        type(string_t), allocatable :: words(:)
        integer :: i

        words = split_words(names)
        allocate (self%wanted(max(size(words), 1)))
        do i = 1, size(words)
            self%wanted(i)%name = words(i)%text
        end do
    end subroutine want_numbers

    subroutine want_text(self, name)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of the item; LIST stands for all names

        allocate (self%wanted(1))
        self%wanted(1)%name = name
    end subroutine want_text

    pure logical function asks(self, beginning)
        class(items_t), intent(in) :: self
        character(*), intent(in) :: beginning   !! Of the names of several items

        asks = any(index(self%wanted%name, beginning) == 1 .or. self%wanted%name == LIST)
    end function asks

    !> Notes an item, and whether it is wanted.
    subroutine note(self, name, count, this)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name    !! Of the item
        integer, intent(in) :: count        !! Of its numbers; -1: a text
        logical, intent(out) :: this        !! It is wanted

        this = any(self%wanted%name == name)
        if (.not. allocated(self%names)) allocate (self%names(0))
        self%names = [character(NAME_LENGTH) :: self%names, name]
        if (.not. self%asks(LIST)) return
        if (.not. allocated(self%text)) self%text = ''
        if (count >= 0) then
            self%text = self%text//name//' '//integer_text(count)//LINE
        else
            self%text = self%text//name//' text'//LINE
        end if
    end subroutine note

    subroutine keep(self, name, values)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of an item that is wanted, once or twice
        real(dp), intent(in) :: values(:)

        integer :: i

        do i = 1, size(self%wanted)
            if (self%wanted(i)%name == name) self%wanted(i)%numbers = values
        end do
    end subroutine keep

    subroutine say(self, name, text)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name, text  !! Of the item; itself

        logical :: this

        call self%note(name, -1, this)
        if (this) self%text = text
    end subroutine say

    subroutine put_number(self, name, value)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of the item
        real(dp), intent(in) :: value

        call self%put_vector(name, [value])
    end subroutine put_number

    subroutine put_vector(self, name, values)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of the item
        real(dp), intent(in) :: values(:)

        logical :: this

        call self%note(name, size(values), this)
        if (this) call self%keep(name, values)
    end subroutine put_vector

    subroutine put_matrix(self, name, values)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of the item
        real(dp), intent(in) :: values(:, :)    !! A row of C's is a column here

        logical :: this

        call self%note(name, size(values), this)
        if (this) call self%keep(name, reshape(values, [size(values)]))
    end subroutine put_matrix

    subroutine put_cube(self, name, values)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of the item
        real(dp), intent(in) :: values(:, :, :) !! The first index is C's last one

        logical :: this

        call self%note(name, size(values), this)
        if (this) call self%keep(name, reshape(values, [size(values)]))
    end subroutine put_cube

    !> Refuses a name that is none, or that of a text where numbers are asked for, and the other way round.
    subroutine require_found(self, text, outcome)
        class(items_t), intent(in) :: self
        logical, intent(in) :: text             !! A text is asked for
        type(outcome_t), intent(inout) :: outcome

        character(NAME_LENGTH) :: name
        character(:), allocatable :: names
        integer :: i, k

        do k = 1, size(self%wanted)
            name = self%wanted(k)%name
            if (merge(allocated(self%text), allocated(self%wanted(k)%numbers), text)) cycle
            if (.not. allocated(self%names)) then
                call outcome%refuse(STATUS_FAILED, 'no item "'//trim(name)//'": the object has none')
            else if (name == LIST .or. any(self%names == name)) then
                call outcome%refuse(STATUS_BAD_VALUE, 'the item "'//trim(name)//'" is '//merge('numbers', 'a text ', text))
            else
                names = ''
                do i = 1, size(self%names)
                    names = names//', '//trim(self%names(i))
                end do
                call outcome%refuse(STATUS_FAILED, 'no item "'//trim(name)//'"'//did_you_mean(trim(name), self%names)// &
                                    '; there are '//names(3:))
            end if
        end do
    end subroutine require_found

    !> Of all that are wanted, one after another; each has been found.
    subroutine numbers(self, values)
        class(items_t), intent(inout) :: self
        real(dp), allocatable, intent(out) :: values(:)     !! In the items' units

        integer :: i

        call move_alloc(self%wanted(1)%numbers, values)
        do i = 2, size(self%wanted)
            values = [values, self%wanted(i)%numbers]
        end do
    end subroutine numbers

    !> Texts as lines; an empty text without any.
    subroutine lines_of(texts, lines)
        type(string_t), allocatable, intent(in) :: texts(:)
        character(:), allocatable, intent(out) :: lines     !! Each ended by a newline

        integer :: i

        lines = ''
        if (.not. allocated(texts)) return
        do i = 1, size(texts)
            lines = lines//texts(i)%text//LINE
        end do
    end subroutine lines_of
end module gracecg_interface_items
