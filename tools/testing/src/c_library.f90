!> The C interface for tests: what the headers declare, and what makes it handy to call.
module c_library
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_f_pointer, c_int, c_int32_t, c_intptr_t, c_null_char, c_ptr, &
        c_size_t
    use c_declarations
    implicit none
    public

    interface
        function gracecg_version() result(text) bind(c, name='gracecg_version')
            import :: c_ptr
            type(c_ptr) :: text
        end function gracecg_version

        function gracecg_interface_version() result(number) bind(c, name='gracecg_interface_version')
            import :: c_int32_t
            integer(c_int32_t) :: number
        end function gracecg_interface_version

        function gracecg_status_text(status) result(text) bind(c, name='gracecg_status_text')
            import :: c_int, c_ptr
            integer(c_int), intent(in), value :: status
            type(c_ptr) :: text
        end function gracecg_status_text

        function gracecg_name(list, index) result(text) bind(c, name='gracecg_name')
            import :: c_char, c_int32_t, c_ptr
            character(kind=c_char), intent(in), optional :: list(*)
            integer(c_int32_t), intent(in), value :: index
            type(c_ptr) :: text
        end function gracecg_name

        function gracecg_free(object, error) result(status) bind(c, name='gracecg_free')
            import :: c_int, c_intptr_t, error_struct
            integer(c_intptr_t), intent(inout), optional :: object
            type(error_struct), intent(inout), optional :: error
            integer(c_int) :: status
        end function gracecg_free

        pure function c_strlen(text) result(n) bind(c, name='strlen')
            import :: c_ptr, c_size_t
            type(c_ptr), intent(in), value :: text
            integer(c_size_t) :: n
        end function c_strlen
    end interface

contains

    !> A text as C has it.
    pure function c_string(text) result(string)
        character(*), intent(in) :: text
        character(len(text) + 1) :: string

        string = text//c_null_char
    end function c_string

    !> The message of an error, filled up with blanks. Not of deferred length: gfortran keeps the length of
    !> such a result in static memory, where threads would share it.
    pure function message_text(error) result(text)
        type(error_struct), intent(in) :: error
        character(size(error%message)) :: text

        integer :: i

        text = ''
        do i = 1, size(error%message)
            if (error%message(i) == c_null_char) exit
            text(i:i) = error%message(i)
        end do
    end function message_text

    !> The text at an address.
    function text_at(address) result(text)
        type(c_ptr), intent(in) :: address
        character(:), allocatable :: text

        character(kind=c_char), pointer :: characters(:)
        integer :: i

        call c_f_pointer(address, characters, [c_strlen(address)])
        text = repeat(' ', size(characters))
        do i = 1, size(characters)
            text(i:i) = characters(i)
        end do
    end function text_at

    !> Numbers of an object; -1 where they cannot be had.
    function item(object, name, n) result(values)
        integer(c_intptr_t), intent(in) :: object
        character(*), intent(in) :: name
        integer, intent(in) :: n
        real(c_double) :: values(n)

        integer(c_int) :: status

        values = -1
        status = gracecg_get(object, c_string(name), int(n, c_size_t), values)
    end function item

    !> A text of an object; empty where it cannot be had.
    subroutine get_words(object, name, words)
        integer(c_intptr_t), intent(in) :: object
        character(*), intent(in) :: name
        character(:), allocatable, intent(out) :: words
        character(kind=c_char), allocatable :: text(:)
        integer(c_size_t) :: length, i
        integer(c_int) :: status

        length = 0
        words = ''
        status = gracecg_get_text(object, c_string(name), size=0_c_size_t, length=length)
        if (status /= 0) return
        allocate (text(length + 1))
        status = gracecg_get_text(object, c_string(name), text, length + 1)
        words = repeat(' ', int(length))
        do i = 1, length
            words(i:i) = text(i)
        end do
    end subroutine get_words
end module c_library
