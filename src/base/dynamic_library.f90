!> Libraries that are loaded while a program runs, by what POSIX has for it (dlfcn.h).
module gracecg_base_dynamic_library
    use, intrinsic :: iso_c_binding, only: c_char, c_funptr, c_int, c_loc, c_null_char, c_null_ptr, c_ptr
    implicit none
    private
    public :: load_library, symbol_in

    integer(c_int), parameter :: RTLD_LAZY = 1      !! Of GNU, musl, the BSDs and macOS

    interface
        type(c_ptr) function c_dlopen(file, mode) bind(c, name='dlopen')
            import :: c_int, c_ptr
            type(c_ptr), value :: file
            integer(c_int), value :: mode
        end function c_dlopen

        type(c_funptr) function c_dlsym(library, symbol) bind(c, name='dlsym')
            import :: c_char, c_funptr, c_ptr
            type(c_ptr), value :: library
            character(kind=c_char), intent(in) :: symbol(*)
        end function c_dlsym
    end interface

contains

    !> Loads a library; null where that fails.
    type(c_ptr) function load_library(name) result(library)
        character(*), intent(in) :: name    !! As the loader finds it; blank: the program with what it has loaded

        character(len(name) + 1), target :: file

        file = trim(name)//c_null_char
        if (name == '') then
            library = c_dlopen(c_null_ptr, RTLD_LAZY)
        else
            library = c_dlopen(c_loc(file), RTLD_LAZY)
        end if
    end function load_library

    !> A function of a library; null where it has none of that name.
    type(c_funptr) function symbol_in(library, name)
        type(c_ptr), intent(in) :: library      !! By load_library
        character(*), intent(in) :: name        !! Of the function

        symbol_in = c_dlsym(library, name//c_null_char)
    end function symbol_in
end module gracecg_base_dynamic_library
