!> The one parallel loop: numbered pieces of work on several threads, and the failure of the first that fails.
!>
!> Whoever has such work extends parallel_work_t by what the pieces read and where their results go: an
!> element of its own for each piece, so that the results do not depend on threads or order.
module gracecg_base_parallel
    use gracecg_base_error, only: error_t
    implicit none
    private
    public :: parallel_work_t, run_parallel

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

    !> Does pieces 1 to n. Fails when one of them does: the error is that of the failed piece with the lowest
    !> number; of the pieces after it some are not done then.
    subroutine run_parallel(work, n, threads, error)
        class(parallel_work_t), intent(inout) :: work
        integer, intent(in) :: n            !! Pieces
        integer, intent(in) :: threads      !! How many to use, 1 and more
        type(error_t), allocatable, intent(out) :: error

        type(error_t), allocatable :: failure
        integer :: i, first_failed, known

        first_failed = n + 1
        !$omp parallel do schedule(dynamic) num_threads(threads) default(shared) private(failure, known)
        do i = 1, n
            !$omp atomic read
            known = first_failed
            if (i > known) cycle
            call work%do_one(i, failure)
            if (.not. allocated(failure)) cycle
            !$omp critical (gracecg_parallel_failure)
            if (i < first_failed) then
                !$omp atomic write
                first_failed = i
                call move_alloc(failure, error)
            end if
            !$omp end critical (gracecg_parallel_failure)
        end do
        !$omp end parallel do
    end subroutine run_parallel
end module gracecg_base_parallel
