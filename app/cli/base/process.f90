!> What the program has to do with the system: the words of its command line, signals and memory.
!>
!> Ctrl-C (SIGINT) and kill (SIGTERM) are a wish to stop: a command that catches them ends what it is doing, keeps what it
!> has, and ends. A second one ends the program at once.
!>
!> An estimate takes and gives back some megabytes in arrays of a few hundred kilobytes; the C library of GNU gives these
!> back to the system at once, and each new one costs the faults of its pages: a sixth of the time of a Monte Carlo. So the
!> program keeps what it has had, up to KEPT bytes. What a program that links the library does with memory is its own.
!> That C library alone has `mallopt`: it is looked up when the program runs (POSIX: dlopen, dlsym), so that the program
!> links with every C library, and without a preprocessor.
module gracecg_cli_process
    use, intrinsic :: iso_c_binding, only: c_associated, c_f_procpointer, c_funloc, c_funptr, c_int, c_intptr_t, &
        c_null_funptr, c_ptr
    use gracecg_base_dynamic_library, only: load_library, symbol_in
    use gracecg_base_text, only: string_t
    implicit none
    private
    public :: process_words, catch_interruption, caught_signal, signal_name, INTERRUPTED, keep_memory

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

    integer(c_int), parameter :: LARGE = 1*2**20        !! Arrays from here on, the most there can be, are given back as before
    integer(c_int), parameter :: KEPT = 256*2**20
    integer(c_int), parameter :: M_TRIM_THRESHOLD = -1, M_MMAP_THRESHOLD = -3       !! malloc.h of GNU

    abstract interface
        integer(c_int) function mallopt_interface(parameter, value) bind(c)
            import :: c_int
            integer(c_int), value :: parameter, value
        end function mallopt_interface
    end interface

contains

    !> The words of the command line, from number `first` on (1 is the first behind the program).
    function process_words(first) result(words)
        integer, intent(in) :: first    !! Number of the first word that is wanted
        type(string_t), allocatable :: words(:)

        integer :: i, length

        allocate (words(max(0, command_argument_count() - first + 1)))
        do i = 1, size(words)
            call get_command_argument(first + i - 1, length=length)
            allocate (character(length) :: words(i)%text)
            call get_command_argument(first + i - 1, words(i)%text)
        end do
    end function process_words

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

        name = 'signal'
        if (any(SIGNALS == number)) name = NAMES(findloc(int(SIGNALS), number, 1))
    end function signal_name

    !> From now on memory that the program has had is not given back to the system at once.
    subroutine keep_memory()
        procedure(mallopt_interface), pointer :: mallopt
        type(c_ptr) :: program_itself
        type(c_funptr) :: found
        integer(c_int) :: status        ! 1: done; whether or not, the program works

        program_itself = load_library('')
        if (.not. c_associated(program_itself)) return
        found = symbol_in(program_itself, 'mallopt')
        if (.not. c_associated(found)) return
        call c_f_procpointer(found, mallopt)
        status = mallopt(M_MMAP_THRESHOLD, LARGE)
        status = mallopt(M_TRIM_THRESHOLD, KEPT)
    end subroutine keep_memory
end module gracecg_cli_process
