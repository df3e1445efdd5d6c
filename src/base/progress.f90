!> Who wants to know how far a long work is.
module gracecg_base_progress
    implicit none
    private
    public :: progress_t, tell

    !> Something that shows progress: the console of the program, say.
    type, abstract :: progress_t
    contains
        procedure(progress_interface), deferred :: progress     !! Shows what is worked on
    end type progress_t

    abstract interface
        subroutine progress_interface(self, text)
            import :: progress_t
            class(progress_t), intent(inout) :: self
            character(*), intent(in) :: text    !! What is worked on now, without a line end
        end subroutine progress_interface
    end interface

contains

    !> Tells a listener, where there is one.
    subroutine tell(listener, text)
        class(progress_t), intent(inout), optional :: listener
        character(*), intent(in) :: text        !! What is worked on now

        if (present(listener)) call listener%progress(text)
    end subroutine tell
end module gracecg_base_progress
