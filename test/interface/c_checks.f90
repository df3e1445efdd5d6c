!> What the tests of the C interface have in common.
module c_checks
    use, intrinsic :: iso_c_binding, only: c_int, c_int32_t, c_intptr_t, c_size_t
    use vocabulary
    use calibrations
    use c_library
    implicit none
    private
    public :: check_ok, check_refused, check_equal, check_answer, free, simulate, simulated_set
    public :: status, failure
    public :: OK, NULL_POINTER, BAD_HANDLE, BAD_SIZE, BAD_VALUE, HAS_FAILED, NOT_CONVERGED, NO_MEMORY, NOT_USABLE, ONE, NONE
    public :: DATE, PLACE, MASS

    integer(c_int), parameter :: OK = 0, NULL_POINTER = 1, BAD_HANDLE = 2, BAD_SIZE = 3, BAD_VALUE = 4
    integer(c_int), parameter :: HAS_FAILED = 5, NOT_CONVERGED = 6, NO_MEMORY = 7, NOT_USABLE = 8
    integer(c_size_t), parameter :: ONE = 1, NONE = 0
    character(*), parameter :: DATE = '1989-01-02T00:00:00'
    real(dp), parameter :: PLACE(3) = [-1.2e6_dp, 5.3e6_dp, 4.1e6_dp]   !! m
    real(dp), parameter :: MASS = 420.0_dp

    integer(c_int) :: status        !! Of the last call of a test of the C interface; these tests run one after the other
    type(error_struct) :: failure   !! What the last call with an error to fill has said

contains

    !> A call, or the last one, must have succeeded. A failure before this one stays.
    subroutine check_ok(error, returned)
        type(error_type), allocatable, intent(inout) :: error
        integer(c_int), intent(in), optional :: returned        !! By the call; left out: `status` has it

        if (present(returned)) status = returned
        call check(error, int(status), int(OK), message_text(failure))
        call check(error, message_text(failure), '', 'a message after success')
    end subroutine check_ok

    !> A call, or the last one, must have failed with a status and, in its message, a text.
    subroutine check_refused(error, expected, part, returned)
        type(error_type), allocatable, intent(inout) :: error
        integer(c_int), intent(in) :: expected
        character(*), intent(in) :: part
        integer(c_int), intent(in), optional :: returned        !! As `check_ok` has it

        if (present(returned)) status = returned
        call check(error, int(status), int(expected), 'status of "'//part//'": '//trim(message_text(failure)))
        call check(error, int(failure%status), int(expected), 'status in the error')
        call check(error, index(message_text(failure), part) > 0, &
                   '"'//part//'" is not in "'//trim(message_text(failure))//'"')
    end subroutine check_refused

    subroutine check_equal(error, actual, expected, what)
        type(error_type), allocatable, intent(inout) :: error
        real(dp), intent(in) :: actual(:), expected(:)
        character(*), intent(in) :: what

        call check(error, all(abs(actual - expected) <= 0) .and. any(abs(expected) > 0), &
                   what//': other numbers than those of the Fortran API')
    end subroutine check_equal

    !> Status 0 and the numbers of the Fortran API.
    subroutine check_answer(error, name, istat, actual, expected)
        type(error_type), allocatable, intent(inout) :: error
        character(*), intent(in) :: name                            ! of the entry
        integer, intent(in) :: istat
        double precision, intent(in) :: actual(:), expected(:)

        call check(error, istat, 0, 'status of '//name)
        call check_equal(error, actual, expected, name)
    end subroutine check_answer

    !> A simulated observation set of a built-in case.
    subroutine simulate(name, seed, run, observations)
        character(*), intent(in) :: name
        integer(c_int32_t), intent(in) :: seed, run
        integer(c_intptr_t), intent(out) :: observations
        integer(c_intptr_t) :: handle, simulator

        observations = 0
        simulator = 0
        status = gracecg_case_open(c_string(name), handle, failure)
        if (status == OK) status = gracecg_simulator_open(handle, simulator, failure)
        if (status == OK) status = gracecg_simulate(simulator, seed, run, observations, failure)
        if (status == OK) call free(simulator, handle)
    end subroutine simulate

    !> Objects that are no longer needed.
    subroutine free(first, second, third, fourth)
        integer(c_intptr_t), intent(inout) :: first
        integer(c_intptr_t), intent(inout), optional :: second, third, fourth

        status = gracecg_free(first)
        if (present(second)) status = gracecg_free(second)
        if (present(third)) status = gracecg_free(third)
        if (present(fourth)) status = gracecg_free(fourth)
    end subroutine free

    !> The observations of a run, by the Fortran API.
    function simulated_set(name, seed, run) result(set)
        character(*), intent(in) :: name        !! Of a case
        integer, intent(in) :: seed, run
        type(observation_set_t) :: set

        call make_observations(name, seed, run, set)
    end function simulated_set
end module c_checks
