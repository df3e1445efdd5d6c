!> The kinds of number used throughout.
module gracecg_base_kinds
    use, intrinsic :: iso_fortran_env, only: real64, int32, int64
    implicit none
    private
    public :: dp, i4, i8

    integer, parameter :: dp = real64   !! Every real number of the library
    integer, parameter :: i4 = int32    !! Counters and words of 32 bits
    integer, parameter :: i8 = int64    !! Long counters; bits of the random numbers
end module gracecg_base_kinds
