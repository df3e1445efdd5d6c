!> The force model as an orbit integrator calls it: calls per second, in one thread and in two.
!>
!> fpm run --example force_model --profile release [-- CALLS]. tools/check_allocations.py counts with it what
!> a call takes from the heap: nothing.
program force_model
    use, intrinsic :: iso_fortran_env, only: int64, output_unit, error_unit
    use gracecg, only: dp, error_t, message_of, case_t, find_case, build_dynamics, initial_state, &
        satellite_dynamics_t, accelerations_t, STATE_SIZE, STATE_POSITION, STATE_VELOCITY, STATE_ATTITUDE
    implicit none

    integer, parameter :: REPEATS = 5
    type(case_t) :: case
    type(satellite_dynamics_t) :: dynamics
    type(error_t), allocatable :: error
    real(dp) :: state(STATE_SIZE)
    integer :: calls
    character(20) :: argument

    calls = 100000
    call get_command_argument(1, argument)
    if (argument /= '') read (argument, *) calls
    call find_case('front-1', case, error)
    if (.not. allocated(error)) call build_dynamics(case, dynamics, error)
    if (allocated(error)) then
        write (error_unit, '(a)') message_of(error)
        error stop 1
    end if
    state = initial_state(case)
    call measure(1)
    call measure(2)

contains

    !> The best of several repeats.
    subroutine measure(threads)
        integer, intent(in) :: threads

        integer(int64) :: start, finish, ticks_per_second
        real(dp) :: best, total
        integer :: i, repeat

        best = huge(best)
        do repeat = 1, REPEATS
            total = 0
            call system_clock(start, ticks_per_second)
            !$omp parallel do num_threads(threads) reduction(+:total)
            do i = 1, threads
                total = total + work()
            end do
            !$omp end parallel do
            call system_clock(finish)
            best = min(best, real(max(1_int64, finish - start), dp)/ticks_per_second)
        end do
        write (output_unit, '("threads: ", i0, ",", f12.0, " calls per second (sum", es24.16, ")")') &
            threads, calls*threads/best, total/threads
    end subroutine measure

    !> Calls at times and places a little apart; their sum keeps the compiler from leaving them out.
    real(dp) function work() result(total)
        type(accelerations_t) :: acting
        integer :: i

        total = 0
        do i = 1, calls
            call dynamics%accelerations(1e-4_dp*i, state(STATE_POSITION) + 1e-3_dp*i, state(STATE_VELOCITY), &
                                        state(STATE_ATTITUDE), acting)
            total = total + acting%total(1)
        end do
    end function work
end program force_model
