!> The parallel loop: every piece once, the same results with any number of threads, and the failure of the
!> first piece that fails.
module test_parallel
    use vocabulary
    use gracecg_base_error, only: fail
    use gracecg_base_parallel, only: parallel_work_t, run_parallel, MOST_THREADS
    use gracecg_base_progress, only: progress_t, tell, expect_pieces
    implicit none
    private
    public :: collect_parallel

    !> Sums; a piece of `failing` fails.
    type, extends(parallel_work_t) :: sums_t
        integer, allocatable :: times_done(:)
        real(dp), allocatable :: sums(:)
        integer, allocatable :: failing(:)
    contains
        procedure :: do_one => add_up
    end type sums_t

    !> Keeps what it is told, and wants to stop when so many pieces are done.
    type, extends(progress_t) :: listener_t
        character(160) :: latest = ''
        integer :: told = 0
        integer :: patience = huge(1)       !! Pieces
        type(sums_t), pointer :: sums => null()
    contains
        procedure :: progress => listen
        procedure :: stops => out_of_patience
    end type listener_t

contains

    subroutine collect_parallel(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('every-piece-once', test_once), &
                    new_unittest('results-do-not-depend-on-threads', test_threads), &
                    new_unittest('first-failure', test_failure), &
                    new_unittest('nothing-to-do-and-nobody-to-do-it', test_nothing), &
                    new_unittest('stops-when-asked', test_stop), &
                    new_unittest('progress-line', test_line)]
    end subroutine collect_parallel

    subroutine add_up(self, i, error)
        class(sums_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error
        integer :: k

        self%times_done(i) = self%times_done(i) + 1
        do k = 1, 200*(1 + modulo(7*i, 5))      ! not all pieces take as long
            self%sums(i) = self%sums(i) + sin(real(i*k, dp))
        end do
        if (any(self%failing == i)) call fail(error, 'piece '//integer_text(i))
    end subroutine add_up

    function new_sums(n, failing) result(sums)
        integer, intent(in) :: n, failing(:)
        type(sums_t) :: sums

        allocate (sums%times_done(n), source=0)
        allocate (sums%sums(n), source=0.0_dp)
        sums%failing = failing
    end function new_sums

    subroutine test_once(error)
        type(error_type), allocatable, intent(out) :: error
        type(sums_t) :: sums
        type(error_t), allocatable :: failure

        sums = new_sums(1000, [integer ::])
        call run_parallel(sums, 1000, 4, failure)
        call check_passes(error, failure)
        call check(error, all(sums%times_done == 1), 'not every piece once')
        sums = new_sums(0, [integer ::])
        call run_parallel(sums, 0, 2, failure)
        call check_passes(error, failure)
    end subroutine test_once

    subroutine test_threads(error)
        type(error_type), allocatable, intent(out) :: error
        type(sums_t) :: one, other
        type(error_t), allocatable :: failure
        integer :: threads

        one = new_sums(300, [integer ::])
        call run_parallel(one, 300, 1, failure)
        do threads = 2, 5
            other = new_sums(300, [integer ::])
            call run_parallel(other, 300, threads, failure)
            call check(error, all(.not. abs(one%sums - other%sums) > 0), 'another result with '// &
                       integer_text(threads)//' threads')
        end do
    end subroutine test_threads

    !> That with the lowest number, whichever fails first in time; all pieces before it are done.
    subroutine test_failure(error)
        type(error_type), allocatable, intent(out) :: error
        type(sums_t) :: sums
        type(error_t), allocatable :: failure
        integer :: threads, attempt

        do threads = 1, 4
            do attempt = 1, 20
                sums = new_sums(64, [63, 17, 18, 19, 20, 40])
                call run_parallel(sums, 64, threads, failure)
                if (unmet(error, allocated(failure), 'no failure')) return
                call check(error, failure%message, 'piece 17')
                call check(error, all(sums%times_done(:17) == 1) .and. all(sums%times_done <= 1), &
                           'a piece before the failure was not done once')
            end do
        end do
    end subroutine test_failure

    subroutine test_nothing(error)
        type(error_type), allocatable, intent(out) :: error
        integer, parameter :: NONE_SUCH(3) = [-1, 0, MOST_THREADS + 1]
        integer :: i
        type(sums_t) :: sums
        type(error_t), allocatable :: failure

        sums = new_sums(0, [integer ::])
        call run_parallel(sums, 0, 2, failure)
        call check_passes(error, failure)
        do i = 1, 3
            call run_parallel(sums, 0, NONE_SUCH(i), failure)
            call check_fails(error, failure, 'threads = '//integer_text(NONE_SUCH(i))//' ... 1 to 1024')
        end do
    end subroutine test_nothing

    subroutine listen(self, text)
        class(listener_t), intent(inout) :: self
        character(*), intent(in) :: text

        self%told = self%told + 1
        self%latest = text
    end subroutine listen

    logical function out_of_patience(self)
        class(listener_t), intent(in) :: self

        out_of_patience = .false.
        if (associated(self%sums)) out_of_patience = sum(self%sums%times_done) >= self%patience
    end function out_of_patience

    !> What was begun is ended, what was not is not, and the failure says how many are done.
    subroutine test_stop(error)
        type(error_type), allocatable, intent(out) :: error
        type(sums_t), target :: sums
        type(listener_t) :: listener
        type(error_t), allocatable :: failure
        integer :: threads

        do threads = 1, 3
            sums = new_sums(500, [integer ::])
            listener%sums => sums
            listener%patience = 20
            call run_parallel(sums, 500, threads, failure, listener)
            if (unmet(error, allocated(failure), 'did not stop')) return
            call check(error, sum(sums%times_done) >= 20 .and. sum(sums%times_done) < 20 + threads, &
                       integer_text(sum(sums%times_done)))
            call check(error, failure%message, 'stopped: '//integer_text(sum(sums%times_done))//' of 500 are done')
        end do
    end subroutine test_stop

    !> Pieces, parts of a larger work, and percentages; many pieces are shown a few times only.
    subroutine test_line(error)
        type(error_type), allocatable, intent(out) :: error
        type(sums_t) :: sums
        type(listener_t) :: listener
        type(error_t), allocatable :: failure
        integer :: i

        call tell(listener, 'the orbit')
        call check(error, trim(listener%latest), 'the orbit')
        call listener%expect(8, 'runs', 2)
        call tell(listener, 'front-1')
        call check(error, trim(listener%latest), '2/8 runs, 25 %: front-1')
        call listener%expect_parts(4, 'chapters')
        call listener%next_part()
        call expect_pieces(listener, 10, 'runs')
        do i = 1, 5
            call listener%advance()
        end do
        call tell(listener, 'front-1')
        call check(error, trim(listener%latest), '2/4 chapters, 5/10 runs, 37 %: front-1')
        sums = new_sums(2000, [integer ::])
        listener%told = 0
        call expect_pieces(listener, 2000, 'sums')
        call run_parallel(sums, 2000, 2, failure, listener)
        call check(error, listener%told < 200, integer_text(listener%told))
        call tell(listener, 'sums')
        call check_says(error, listener%latest, '2000/2000 sums, 50 %')
    end subroutine test_line
end module test_parallel
