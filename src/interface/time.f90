!> The C interface: time, and the turn of the Earth. Documented in include/gracecg.h.
module gracecg_interface_time
    use gracecg, only: dp, error_t, utc_t, utc_plus, check_utc_in_range, ARCSECOND, earth_parameters_t, &
        earth_orientation_t, new_earth_orientation, read_earth_parameters
    use gracecg_base_error, only: number_text
    use gracecg_interface_outcome, only: outcome_t, STATUS_BAD_VALUE
    implicit none
    private
    public :: earth_parameters, earth_orientation, later_time

contains

    !> The time `seconds` after an epoch.
    subroutine later_time(epoch, seconds, utc, outcome)
        type(utc_t), intent(in) :: epoch
        real(dp), intent(in) :: seconds         !! s; may be negative
        type(utc_t), intent(out) :: utc
        type(outcome_t), intent(inout) :: outcome

        real(dp), parameter :: LONGEST = 9e9_dp     ! s: utc_plus takes a little more
        type(error_t), allocatable :: failure

        if (abs(seconds) > LONGEST) then
            call outcome%refuse(STATUS_BAD_VALUE, number_text(seconds)//' s from the epoch: at most 9e9 s are allowed')
            return
        end if
        utc = utc_plus(epoch, seconds)
        call check_utc_in_range(utc, failure)
        call outcome%take(failure, STATUS_BAD_VALUE)
    end subroutine later_time

    !> UT1-UTC (s) and x and y of the pole (rad) at a time, each or NULL.
    subroutine earth_parameters(path, utc, ut1_minus_utc, pole, outcome)
        character(*), intent(in) :: path                                !! Of a file of the IERS
        type(utc_t), intent(in) :: utc
        real(dp), intent(inout), optional :: ut1_minus_utc, pole(2)     !! s; rad
        type(outcome_t), intent(inout) :: outcome

        type(earth_parameters_t) :: parameters
        type(error_t), allocatable :: failure

        call read_earth_parameters(path, utc, parameters, failure)
        call outcome%take(failure)
        if (.not. outcome%good()) return
        if (present(ut1_minus_utc)) ut1_minus_utc = parameters%ut1_minus_utc
        if (present(pole)) pole = parameters%pole
    end subroutine earth_parameters

    !> The rotation from inertial (GCRS) to Earth-fixed axes, fixed = rotation * inertial.
    subroutine earth_orientation(utc, ut1_minus_utc, pole, seconds, rotation, outcome)
        type(utc_t), intent(in) :: utc
        real(dp), intent(in) :: ut1_minus_utc, seconds  !! s; s after the time
        real(dp), intent(in), optional :: pole(2)       !! rad
        real(dp), intent(inout) :: rotation(3, 3)       !! A row of C's is a column here
        type(outcome_t), intent(inout) :: outcome

        real(dp), parameter :: GREATEST_POLE = 2*ARCSECOND
        type(earth_parameters_t) :: parameters
        type(earth_orientation_t) :: earth
        type(error_t), allocatable :: failure

        parameters%ut1_minus_utc = ut1_minus_utc
        if (present(pole)) parameters%pole = pole
        if (any(abs(parameters%pole) > GREATEST_POLE)) then
            call outcome%refuse(STATUS_BAD_VALUE, 'the pole has to lie within 2 arcsec, in rad')
            return
        end if
        call new_earth_orientation('iau', utc, 0.0_dp, parameters, earth, failure)
        call outcome%take(failure)
        if (outcome%good()) rotation = transpose(earth%from_inertial(seconds))
    end subroutine earth_orientation
end module gracecg_interface_time
