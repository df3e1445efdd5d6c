!> The words of all tests: numbers, angles, vectors and random numbers, failures and their checks, files that tests make. Test
!> modules use it whole.
!>
!> What is tested and must succeed is followed by `if (failed(error, failure)) return`; what a test only needs, by
!> `call need(failure)`: without it nothing can be tested, so the run ends.
module vocabulary
    use, intrinsic :: iso_fortran_env, only: error_unit
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: PI, TWO_PI, DEGREE, ARCSECOND, MICROMETRE, MILLIMETRE, EARTH_GM, AXES
    use gracecg_base_error, only: error_t, message_of
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_base_text, only: string_t, integer_text
    use gracecg_base_vectors, only: cross, unit, identity, inverse_3x3
    use fixture, check_message_fails => check_fails, check_no_message => check_passes, failed_with_message => failed
    use testdrive, only: new_unittest, unittest_type, error_type, skip_test
    implicit none
    public

    real(dp), protected :: NAN = transfer(9221120237041090560_i8, 1.0_dp)       !! A quiet one

    !> check_fails(error, failure, 'part ... part'): there must be a failure (or the message of one), and its message must have
    !> every one of the parts. The failure is taken away: the next step begins without.
    interface check_fails
        procedure :: check_message_fails
        module procedure check_step_fails
    end interface check_fails

    !> check_passes(error, failure): there must be no failure.
    interface check_passes
        procedure :: check_no_message
        module procedure check_step_passes
    end interface check_passes

    !> failed(error, failure): there must be no failure; is there one now, or was there before, so that a test cannot go on?
    interface failed
        procedure :: failed_with_message
        module procedure step_failed
    end interface failed

    private :: check_step_fails, check_step_passes, step_failed, error_unit

contains

    subroutine check_step_fails(error, failure, parts)
        type(error_type), allocatable, intent(inout) :: error
        type(error_t), allocatable, intent(inout) :: failure
        character(*), intent(in) :: parts

        call check_message_fails(error, message_of(failure), parts)
        if (allocated(failure)) deallocate (failure)
    end subroutine check_step_fails

    subroutine check_step_passes(error, failure)
        type(error_type), allocatable, intent(inout) :: error
        type(error_t), allocatable, intent(in) :: failure

        call check_no_message(error, message_of(failure))
    end subroutine check_step_passes

    logical function step_failed(error, failure)
        type(error_type), allocatable, intent(inout) :: error
        type(error_t), allocatable, intent(in) :: failure

        step_failed = failed_with_message(error, message_of(failure))
    end function step_failed

    !> Ends the run when there is a failure: of a step that a test needs and does not test.
    subroutine need(failure)
        type(error_t), allocatable, intent(in) :: failure

        if (.not. allocated(failure)) return
        write (error_unit, '(a)') 'a test cannot be made: '//failure%message
        error stop 1
    end subroutine need
end module vocabulary
