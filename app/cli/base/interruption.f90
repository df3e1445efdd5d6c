!> Ctrl-C (SIGINT) and kill (SIGTERM) as a wish to stop: a command that catches them ends what it is doing, keeps
!> what it has, and ends. A second one ends the program at once.
module gracecg_cli_interruption
    use, intrinsic :: iso_c_binding, only: c_associated, c_funloc, c_funptr, c_int, c_intptr_t, c_null_funptr
    implicit none
    private
    public :: catch_interruption, caught_signal, signal_name, INTERRUPTED

    integer, parameter :: INTERRUPTED = 128
    !! Exit status of a stopped command: this and the number of the signal, as shells have it: 130, 143

    integer(c_int), parameter :: SIGNALS(2) = [2_c_int, 15_c_int]    !! SIGINT and SIGTERM (POSIX)
    character(7), parameter :: NAMES(2) = ['SIGINT ', 'SIGTERM']
    integer(c_intptr_t), parameter :: IGNORED = 1                   !! SIG_IGN of the C library

    integer(c_int), volatile :: caught = 0

    interface
        function c_signal(number, handler) bind(c, name='signal') result(former)
            import :: c_funptr, c_int
            integer(c_int), value :: number
            type(c_funptr), value :: handler    !! Null: what the system does (SIG_DFL)
            type(c_funptr) :: former
        end function c_signal
    end interface

contains

    !> From now on the signals are caught, but for one that the caller of the program has set aside (nohup, say).
    subroutine catch_interruption()
        type(c_funptr) :: former
        integer :: i

        caught = 0
        do i = 1, size(SIGNALS)
            former = c_signal(SIGNALS(i), c_funloc(take_signal))
            if (transfer(former, IGNORED) == IGNORED) former = c_signal(SIGNALS(i), former)
        end do
    end subroutine catch_interruption

    !> Only what a signal handler may do: notes the signal, and lets the next one act as the system has it.
    subroutine take_signal(number) bind(c, name='gracecg_take_signal')
        integer(c_int), value :: number

        type(c_funptr) :: former

        caught = number
        former = c_signal(number, c_null_funptr)
    end subroutine take_signal

    !> The signal that was caught; 0: none.
    integer function caught_signal()
        caught_signal = caught
    end function caught_signal

    !> Its name, for people.
    pure function signal_name(number) result(name)
        integer, intent(in) :: number       !! Of the signal
        character(7) :: name

        integer :: i

        name = 'signal'
        do i = 1, size(SIGNALS)
            if (SIGNALS(i) == number) name = NAMES(i)
        end do
    end function signal_name
end module gracecg_cli_interruption
