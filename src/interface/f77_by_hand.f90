! The Fortran 77 entry points that tools/interface.py does not make (f77_entries.f90); docs/interface/fortran77.md lists them.

!> The version as a text.
subroutine gcvers(vers)
    use gracecg, only: LIBRARY_VERSION
    implicit none
    character(*), intent(inout) :: vers     !! "0.2.0"

    vers = LIBRARY_VERSION
end subroutine gcvers

!> The version of the interface.
subroutine gcvint(nvers)
    use gracecg_interface_general, only: INTERFACE_VERSION
    implicit none
    integer, intent(inout) :: nvers     !! As gracecg_interface_version

    nvers = INTERFACE_VERSION
end subroutine gcvint

!> Gives an object of any kind back; its handle becomes 0.
subroutine gcfree(ih, istat, msg)
    use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t
    use gracecg_interface_outcome, only: c_error_t
    use gracecg_interface_general, only: c_free
    use gracecg_interface_f77_support, only: finish
    implicit none
    integer, intent(inout) :: ih    !! Of any kind; 0 afterwards
    integer, intent(out) :: istat
    character(*), intent(inout) :: msg

    integer(c_intptr_t) :: handle
    type(c_error_t) :: error
    integer(c_int) :: status

    handle = ih
    status = c_free(handle, error)
    ih = int(handle)
    call finish(status, error, istat, msg)
end subroutine gcfree
