!> The one parallel loop: numbered pieces of work on several threads, and the failure of the first that fails.
!>
!> Whoever has such work extends parallel_work_t by what the pieces read and where their results go: an
!> element of its own for each piece, so that the results do not depend on threads or order.
module gracecg_base_parallel
    use gracecg_base_error, only: error_t, fail, require_range
    use gracecg_base_kinds, only: dp
    use gracecg_base_progress, only: progress_t, is_stopped
    use gracecg_base_text, only: integer_text
    implicit none
    private
    public :: parallel_work_t, run_parallel, MOST_THREADS

    integer, parameter :: MOST_THREADS = 1024   !! That a loop may ask for

    !> Pieces of work that do not depend on each other.
    type, abstract :: parallel_work_t
    contains
        procedure(do_one_interface), deferred :: do_one
        !! Does one piece of the work
    end type parallel_work_t

    abstract interface
        !> Does piece i, and no other; called from several threads at once. The error says which piece it was.
        subroutine do_one_interface(self, i, error)
            import :: parallel_work_t, error_t
            class(parallel_work_t), intent(inout) :: self
            integer, intent(in) :: i
            type(error_t), allocatable, intent(out) :: error
        end subroutine do_one_interface
    end interface

contains

    !> Does pieces 1 to n, and counts them for a listener. Fails when one of them does: the error is that of the
    !> failed piece with the lowest number; of the pieces after it some are not done then. Fails, too, for a number of threads
    !> that is not allowed, and when the listener wants to stop before all pieces are done: those that were begun are done then.
    subroutine run_parallel(work, n, threads, error, progress)
        class(parallel_work_t), intent(inout) :: work
        integer, intent(in) :: n            !! Pieces
        integer, intent(in) :: threads      !! How many to use, 1 to MOST_THREADS
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress  !! Is called by one thread at a time

        type(error_t), allocatable :: failure
        integer :: i, first_failed, known, done

        call require_range('threads', real(threads, dp), real([1, MOST_THREADS], dp), '', error)
        if (allocated(error)) return
        first_failed = n + 1
        done = 0
        !$omp parallel do schedule(dynamic) num_threads(threads) default(shared) private(failure, known)
        do i = 1, n
            !$omp atomic read
            known = first_failed
            if (i > known .or. is_stopped(progress)) cycle
            call work%do_one(i, failure)
            if (.not. allocated(failure)) then
                !$omp critical (gracecg_parallel_progress)
                done = done + 1
                if (present(progress)) call progress%advance()
                !$omp end critical (gracecg_parallel_progress)
                cycle
            end if
            !$omp critical (gracecg_parallel_failure)
            if (i < first_failed) then
                !$omp atomic write
                first_failed = i
                call move_alloc(failure, error)
            end if
            !$omp end critical (gracecg_parallel_failure)
        end do
        !$omp end parallel do
        if (.not. allocated(error) .and. done < n) &
            call fail(error, 'stopped: '//integer_text(done)//' of '//integer_text(n)//' are done')
    end subroutine run_parallel
end module gracecg_base_parallel
