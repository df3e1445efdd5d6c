!> What an object holds, by name: numbers and texts, of which a caller wants one.
!>
!> An object tells all of its items, one `put` or `say` each. The one that is wanted is kept; all are listed.
module gracecg_interface_items
    use gracecg, only: dp, error_t, string_t
    use gracecg_base_text, only: integer_text
    use gracecg_files_value, only: did_you_mean
    use gracecg_interface_outcome, only: outcome_t, STATUS_BAD_VALUE
    implicit none
    private
    public :: items_t, LIST, lines_of

    character(*), parameter :: LIST = 'items'       !! The text that lists all others
    integer, parameter :: NAME_LENGTH = 32
    character(*), parameter :: LINE = new_line('a')

    !> The items as they are told, and the one that is wanted.
    type :: items_t
        character(NAME_LENGTH) :: wanted = ''           !! Name of the item; LIST: all names
        real(dp), allocatable :: numbers(:)             !! Of the item that is wanted
        character(:), allocatable :: text               !! Of the item that is wanted, or the list
        character(NAME_LENGTH), allocatable :: names(:) !! That have been told
        type(error_t), allocatable :: failure           !! Why the item that is wanted cannot be told
    contains
        procedure :: asks                               !! An item whose name begins so is wanted, or the list
        procedure :: say                                !! A text
        procedure, private :: note, put_number, put_vector, put_matrix, put_cube
        generic :: put => put_number, put_vector, put_matrix, put_cube     !! Numbers
        procedure :: require_found                      !! Refuses a name that is none
    end type items_t

contains

    pure logical function asks(self, beginning)
        class(items_t), intent(in) :: self
        character(*), intent(in) :: beginning   !! Of the names of several items

        asks = self%wanted == LIST .or. index(self%wanted, beginning) == 1
    end function asks

    !> Notes an item, and whether it is the one that is wanted.
    subroutine note(self, name, count, this)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name    !! Of the item
        integer, intent(in) :: count        !! Of its numbers; -1: a text
        logical, intent(out) :: this        !! It is wanted

        this = self%wanted == name
        if (.not. allocated(self%names)) allocate (self%names(0))
        self%names = [character(NAME_LENGTH) :: self%names, name]
        if (self%wanted /= LIST) return
        if (.not. allocated(self%text)) self%text = ''
        if (count >= 0) then
            self%text = self%text//name//' '//integer_text(count)//LINE
        else
            self%text = self%text//name//' text'//LINE
        end if
    end subroutine note

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
        if (this) self%numbers = values
    end subroutine put_vector

    subroutine put_matrix(self, name, values)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of the item
        real(dp), intent(in) :: values(:, :)    !! A row of C's is a column here

        logical :: this

        call self%note(name, size(values), this)
        if (this) self%numbers = reshape(values, [size(values)])
    end subroutine put_matrix

    subroutine put_cube(self, name, values)
        class(items_t), intent(inout) :: self
        character(*), intent(in) :: name        !! Of the item
        real(dp), intent(in) :: values(:, :, :) !! The first index is C's last one

        logical :: this

        call self%note(name, size(values), this)
        if (this) self%numbers = reshape(values, [size(values)])
    end subroutine put_cube

    !> Refuses a name that is none, or that of a text where numbers are asked for, and the other way round.
    subroutine require_found(self, text, outcome)
        class(items_t), intent(in) :: self
        logical, intent(in) :: text             !! A text is asked for
        type(outcome_t), intent(inout) :: outcome

        character(:), allocatable :: names
        integer :: i

        if (merge(allocated(self%text), allocated(self%numbers), text)) return
        if (allocated(self%text) .or. allocated(self%numbers)) then
            call outcome%refuse(STATUS_BAD_VALUE, 'the item "'//trim(self%wanted)//'" is '//merge('numbers', 'a text ', text))
        else if (.not. allocated(self%names)) then
            call outcome%refuse(STATUS_BAD_VALUE, 'no item "'//trim(self%wanted)//'": the object has none')
        else
            names = ''
            do i = 1, size(self%names)
                names = names//', '//trim(self%names(i))
            end do
            call outcome%refuse(STATUS_BAD_VALUE, 'no item "'//trim(self%wanted)//'"'// &
                                did_you_mean(trim(self%wanted), self%names)//'; there are '//names(3:))
        end if
    end subroutine require_found

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
