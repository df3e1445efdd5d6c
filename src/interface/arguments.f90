!> The arguments of a call of the C interface: checks, and what is C's made what is Fortran's and back.
!>
!> An absent argument is a NULL pointer. Every check refuses by the argument's name, and does nothing after an earlier
!> refusal.
module gracecg_interface_arguments
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int32_t, c_intptr_t, c_null_char, c_size_t
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_error, only: error_t, number_text
    use gracecg_base_text, only: integer_text, pick_text
    use gracecg_environment_time, only: utc_t, check_utc_in_range
    use gracecg_interface_outcome, only: outcome_t, STATUS_NULL_POINTER, STATUS_BAD_SIZE, STATUS_BAD_VALUE
    implicit none
    private
    public :: c_utc_t, LONGEST_NAME, LONGEST_TEXT
    public :: need, start_handle, check_count, check_integer, check_number, check_numbers, check_positions, check_attitudes
    public :: check_state_vector, check_result, check_results, take_text, take_time, give_text, give_numbers

    integer, parameter :: LONGEST_NAME = 4095       !! Bytes of a name or path
    integer, parameter :: LONGEST_TEXT = 2**20      !! Bytes of a text of settings
    real(dp), parameter :: NEAREST = 6.35e6_dp
    !! Of a position to the Earth's centre, m: just below the ground at the poles; in kilometres it would be far nearer
    real(dp), parameter :: FARTHEST = 1e9_dp        !! Likewise: no satellite of the Earth is so far away
    real(dp), parameter :: ATTITUDE_TOLERANCE = 1e-2_dp
    !! Of the length of a quaternion, which is normalised: an integrator lets it drift

    !> gracecg_utc
    type, bind(c) :: c_utc_t
        integer(c_int32_t) :: mjd       !! Modified Julian day number, UTC
        real(c_double) :: seconds       !! s
    end type c_utc_t

contains

    !> An argument that must be there.
    subroutine need(given, name, outcome)
        logical, intent(in) :: given            !! It is not NULL
        character(*), intent(in) :: name        !! Of the argument
        type(outcome_t), intent(inout) :: outcome

        if (.not. given) call outcome%refuse(STATUS_NULL_POINTER, 'the argument '//name//' is NULL')
    end subroutine need

    !> The handle of an object to be made: 0 until it is.
    subroutine start_handle(handle, name, outcome)
        integer(c_intptr_t), intent(inout), optional :: handle  !! 0 out
        character(*), intent(in) :: name                        !! Of the argument
        type(outcome_t), intent(inout) :: outcome

        call need(present(handle), name, outcome)
        if (present(handle)) handle = 0
    end subroutine start_handle

    !> A number of elements.
    subroutine check_count(n, name, low, high, outcome)
        integer(c_size_t), intent(in) :: n      !! As C has it: 2^63 and more is negative here
        character(*), intent(in) :: name        !! Of the argument
        integer, intent(in) :: low, high        !! What is allowed
        type(outcome_t), intent(inout) :: outcome

        if (n >= low .and. n <= high) return
        if (n < 0) then
            call outcome%refuse(STATUS_BAD_SIZE, name//' is negative or too great: at most '//integer_text(high)//' is allowed')
        else
            call outcome%refuse(STATUS_BAD_SIZE, name//' = '//integer_text(int(n, i8))//' is outside '//integer_text(low)// &
                                ' to '//integer_text(high))
        end if
    end subroutine check_count

    !> An integer in its range.
    subroutine check_integer(value, name, low, high, outcome)
        integer, intent(in) :: value            !! As given
        character(*), intent(in) :: name        !! Of the argument
        integer, intent(in) :: low, high        !! What is allowed
        type(outcome_t), intent(inout) :: outcome

        if (value < low .or. value > high) &
            call outcome%refuse(STATUS_BAD_VALUE, name//' = '//integer_text(value)//' is outside '//integer_text(low)//' to '// &
                                integer_text(high))
    end subroutine check_integer

    !> A finite number in its range.
    subroutine check_number(value, name, outcome, low, high, above)
        real(dp), intent(in) :: value                       !! In any unit
        character(*), intent(in) :: name                    !! Of the argument
        type(outcome_t), intent(inout) :: outcome
        real(dp), intent(in), optional :: low, high, above  !! What is allowed; `above` itself is not

        call check_numbers([value], 1_c_size_t, name, .true., outcome)
        if (present(above)) then
            if (value <= above) call outcome%refuse(STATUS_BAD_VALUE, name//' = '//number_text(value)//' has to be positive')
        end if
        if (present(low)) then
            if (value < low) call outcome%refuse(STATUS_BAD_VALUE, name//' = '//number_text(value)//' must not be less than '// &
                                                 number_text(low))
        end if
        if (present(high)) then
            if (value > high) call outcome%refuse(STATUS_BAD_VALUE, name//' = '//number_text(value)// &
                                                  ' must not be greater than '//number_text(high))
        end if
    end subroutine check_number

    !> Finite numbers.
    subroutine check_numbers(values, n, name, needed, outcome)
        real(dp), intent(in), optional :: values(*)     !! In any unit
        integer(c_size_t), intent(in) :: n              !! Their number
        character(*), intent(in) :: name                !! Of the argument
        logical, intent(in) :: needed                   !! It may be absent only when there are none
        type(outcome_t), intent(inout) :: outcome

        integer(c_size_t) :: i

        if (.not. outcome%good()) return
        if (needed) call need(present(values) .or. n == 0, name, outcome)
        if (.not. present(values)) return
        do i = 1, n
            if (abs(values(i)) <= huge(1.0_dp)) cycle
            if (n == 1) then
                call outcome%refuse(STATUS_BAD_VALUE, name//' is NaN or infinite')
            else
                call outcome%refuse(STATUS_BAD_VALUE, 'number '//integer_text(int(i, i8))//' of '//name//' is NaN or infinite')
            end if
            return
        end do
    end subroutine check_numbers

    !> Positions: finite, and not in kilometres or millimetres.
    subroutine check_positions(position, n, name, outcome)
        real(dp), intent(in), optional :: position(3, *)    !! From the Earth's centre, m
        integer(c_size_t), intent(in) :: n                  !! Their number
        character(*), intent(in) :: name                    !! Of the argument
        type(outcome_t), intent(inout) :: outcome

        integer(c_size_t) :: i

        call check_numbers(position, 3*n, name, .true., outcome)
        if (.not. outcome%good() .or. .not. present(position)) return
        do i = 1, n
            if (norm2(position(:, i)) >= NEAREST .and. norm2(position(:, i)) <= FARTHEST) cycle
            call outcome%refuse(STATUS_BAD_VALUE, name//' '//integer_text(int(i, i8))//' lies '// &
                                pick_text(norm2(position(:, i)) < NEAREST, 'inside the Earth, below the ground, ', '')// &
                                number_text(norm2(position(:, i)))//' m from the centre of the Earth; positions have to be '// &
                                'in metres, 6.35e6 to 1e9')
            return
        end do
    end subroutine check_positions

    !> Quaternions of about unit length: they are normalised before use.
    subroutine check_attitudes(quaternion, n, name, outcome)
        real(dp), intent(in), optional :: quaternion(4, *)  !! Inertial to body, scalar last
        integer(c_size_t), intent(in) :: n                  !! Their number
        character(*), intent(in) :: name                    !! Of the argument
        type(outcome_t), intent(inout) :: outcome

        integer(c_size_t) :: i

        call check_numbers(quaternion, 4*n, name, .true., outcome)
        if (.not. outcome%good() .or. .not. present(quaternion)) return
        do i = 1, n
            if (abs(norm2(quaternion(:, i)) - 1) <= ATTITUDE_TOLERANCE) cycle
            call outcome%refuse(STATUS_BAD_VALUE, 'the quaternion has the length '//number_text(norm2(quaternion(:, i)))// &
                                '; allowed is 1 within '//number_text(ATTITUDE_TOLERANCE))
            return
        end do
    end subroutine check_attitudes

    !> Position, velocity, angular velocity and attitude.
    subroutine check_state_vector(state, name, outcome)
        real(dp), intent(in), optional :: state(13)         !! m, m/s, rad/s, quaternion
        character(*), intent(in) :: name                    !! Of the argument
        type(outcome_t), intent(inout) :: outcome

        call check_numbers(state, 13_c_size_t, name, .true., outcome)
        if (.not. present(state)) return
        call check_positions(state(1:3), 1_c_size_t, 'the position of '//name, outcome)
        call check_attitudes(state(10:13), 1_c_size_t, name, outcome)
    end subroutine check_state_vector

    !> A number that goes out.
    subroutine check_result(value, name, outcome)
        real(dp), intent(in), optional :: value         !! In any unit
        character(*), intent(in) :: name                !! Of the argument
        type(outcome_t), intent(inout) :: outcome

        if (present(value)) call check_results([value], 1_c_size_t, name, outcome)
    end subroutine check_result

    !> Numbers that go out.
    subroutine check_results(values, n, name, outcome)
        real(dp), intent(in), optional :: values(*)     !! In any unit
        integer(c_size_t), intent(in) :: n              !! Their number
        character(*), intent(in) :: name                !! Of the argument
        type(outcome_t), intent(inout) :: outcome

        if (.not. present(values) .or. .not. outcome%good()) return
        if (.not. all(abs(values(:n)) <= huge(1.0_dp))) &
            call outcome%refuse(STATUS_BAD_VALUE, name//' would be NaN or infinite: the arguments are far outside what '// &
                                'the model is for; are all positions, the Sun''s too, in metres?')
    end subroutine check_results

    !> A text of the caller's. Fails when it has no end within the longest length.
    subroutine take_text(c_text, longest, name, needed, text, outcome)
        character(kind=c_char), intent(in), optional :: c_text(*)   !! Ends with a zero
        integer, intent(in) :: longest                              !! Greatest number of bytes before the zero
        character(*), intent(in) :: name                            !! Of the argument
        logical, intent(in) :: needed                               !! It must not be absent
        character(:), allocatable, intent(out) :: text              !! Without the zero; empty when absent
        type(outcome_t), intent(inout) :: outcome

        integer :: i, n

        text = ''
        if (needed) call need(present(c_text), name, outcome)
        if (.not. outcome%good() .or. .not. present(c_text)) return
        n = 0
        do while (c_text(n + 1) /= c_null_char)
            n = n + 1
            if (n <= longest) cycle
            call outcome%refuse(STATUS_BAD_VALUE, name//' is longer than '//integer_text(longest)//' bytes')
            return
        end do
        deallocate (text)
        allocate (character(n) :: text)
        do i = 1, n
            text(i:i) = c_text(i)
        end do
    end subroutine take_text

    !> A time of the caller's.
    subroutine take_time(c_utc, name, needed, utc, outcome)
        type(c_utc_t), intent(in), optional :: c_utc
        character(*), intent(in) :: name                !! Of the argument
        logical, intent(in) :: needed                   !! It must not be absent
        type(utc_t), allocatable, intent(out) :: utc    !! Not allocated when absent
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        if (needed) call need(present(c_utc), name, outcome)
        if (.not. present(c_utc)) return
        allocate (utc)
        utc = utc_t(c_utc%mjd, c_utc%seconds)
        call check_utc_in_range(utc, failure)
        call outcome%take(failure, STATUS_BAD_VALUE)
    end subroutine take_time

    !> Gives a text to the caller's buffer of `size` bytes.
    subroutine give_text(text, buffer, size, length, outcome)
        character(:), allocatable, intent(in) :: text                   !! Not allocated after a failure
        character(kind=c_char), intent(inout), optional :: buffer(*)    !! Receives it with a zero behind it
        integer(c_size_t), intent(in) :: size                           !! Of the buffer, bytes
        integer(c_size_t), intent(inout), optional :: length            !! Receives the text's
        type(outcome_t), intent(inout) :: outcome

        integer :: i

        if (.not. outcome%good()) return
        if (present(length)) length = len(text, c_size_t)
        call need(present(buffer) .or. (size == 0 .and. present(length)), 'text', outcome)
        if (.not. present(buffer)) return
        if (size /= 0) buffer(1) = c_null_char
        if (size <= len(text)) then     ! or negative: 2^63 and more
            call outcome%refuse(STATUS_BAD_SIZE, 'the text has '//integer_text(len(text))//' characters; there is room for '// &
                                integer_text(int(size, i8) - 1))
            return
        end if
        do i = 1, len(text)
            buffer(i) = text(i:i)
        end do
        buffer(len(text) + 1) = c_null_char
    end subroutine give_text

    !> Gives numbers to the caller's array with room for `capacity`.
    subroutine give_numbers(found, capacity, values, count, outcome)
        real(dp), allocatable, intent(in) :: found(:)           !! Not allocated after a failure
        integer(c_size_t), intent(in) :: capacity               !! Of the array
        real(c_double), intent(inout), optional :: values(*)    !! Receives them
        integer(c_size_t), intent(inout), optional :: count     !! Receives how many there are
        type(outcome_t), intent(inout) :: outcome

        if (.not. outcome%good()) return
        if (present(count)) count = size(found)
        call need(present(values) .or. (capacity == 0 .and. present(count)), 'values', outcome)
        if (.not. present(values)) return
        if (capacity >= size(found)) then
            values(:size(found)) = found
        else
            call outcome%refuse(STATUS_BAD_SIZE, 'capacity = '//integer_text(int(capacity, i8))//' is too small: there are '// &
                                integer_text(size(found))//' numbers')
        end if
    end subroutine give_numbers
end module gracecg_interface_arguments
