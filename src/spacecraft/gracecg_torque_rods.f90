!> Magnetic torque rods and the manoeuvre they are driven through.
module gracecg_torque_rods
    use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
    use gracecg_kinds, only: dp
    use gracecg_constants, only: TWO_PI
    use gracecg_error, only: error_t, fail, number_text
    use gracecg_text, only: integer_text
    implicit none
    private
    public :: rod_activation_t, torque_rods_t, new_torque_rods, new_harmonic_manoeuvre
    public :: dipole_moment
    public :: report_pattern, weakest_components_pattern
    public :: MAX_ACTIVATIONS, MAX_DIPOLE

    !> Greatest number of activations of a manoeuvre
    integer, parameter :: MAX_ACTIVATIONS = 16
    real(dp), parameter :: MAX_DIPOLE = 30.0_dp
    !! Greatest linear dipole moment of a rod, A m^2: CSR-TM-00-01 section 4.1

    type :: rod_activation_t
        !! amplitude sin(2 pi frequency (t - start) + phase) for start <= t <= stop, zero otherwise
        integer :: axis = 0             !! Body axis along which the rod lies: 1, 2 or 3
        real(dp) :: amplitude = 0       !! A m^2
        real(dp) :: frequency = 0       !! Hz
        real(dp) :: phase = 0           !! rad
        real(dp) :: start = 0           !! s
        real(dp) :: stop = 0            !! s
    end type rod_activation_t

    type :: torque_rods_t
        !! A manoeuvre; only the first `count` activations exist. Those of one rod add up
        integer :: count = 0                                    !! Number of the activations
        type(rod_activation_t) :: activations(MAX_ACTIVATIONS)  !! The first `count` of them
    end type torque_rods_t

contains

    !> The manoeuvre of a list of activations. Fails when there are too many, when a number is not
    !> finite, an axis none of 1, 2, 3, a frequency negative, a stop not after its start, or when
    !> what is active at one time on one rod could exceed MAX_DIPOLE.
    subroutine new_torque_rods(self, activations, error)
        type(torque_rods_t), intent(out) :: self
        type(rod_activation_t), intent(in) :: activations(:)
        type(error_t), allocatable, intent(out) :: error

        integer :: i

        if (size(activations) > MAX_ACTIVATIONS) then
            call fail(error, 'torque rods: '//integer_text(size(activations))// &
                      ' activations given, at most '//integer_text(MAX_ACTIVATIONS)// &
                      ' allowed')
            return
        end if
        do i = 1, size(activations)
            call check_activation(activations(i), i, error)
            if (allocated(error)) return
        end do
        call check_total_moment(activations, error)
        if (allocated(error)) return
        self%count = size(activations)
        self%activations(:self%count) = activations
    end subroutine new_torque_rods

    !> The manoeuvre of CSR-TM-00-01 section 5.2,
    !>
    !>     m = pattern amplitude sin(2 pi frequency (t - start)).
    !>
    !> Fails as new_torque_rods does, and when the pattern moves no rod or has another number than
    !> -1, 0 and 1.
    subroutine new_harmonic_manoeuvre(self, pattern, amplitude, frequency, start, stop, error)
        type(torque_rods_t), intent(out) :: self
        integer, intent(in) :: pattern(3)       !! -1, 0 or 1 for each rod, e.g. from report_pattern
        real(dp), intent(in) :: amplitude       !! A m^2
        real(dp), intent(in) :: frequency       !! Hz
        real(dp), intent(in) :: start, stop     !! s
        type(error_t), allocatable, intent(out) :: error

        type(rod_activation_t) :: activations(3)
        integer :: axis

        if (all(pattern == 0) .or. any(abs(pattern) > 1)) then
            call fail(error, 'pattern of the torque rods: -1, 0 or 1 is allowed for each rod, '// &
                      'and not 0 for all three')
            return
        end if
        do axis = 1, 3
            activations(axis) = rod_activation_t(axis=axis, amplitude=pattern(axis)*amplitude, &
                                                 frequency=frequency, start=start, stop=stop)
        end do
        call new_torque_rods(self, pack(activations, pattern /= 0), error)
    end subroutine new_harmonic_manoeuvre

    subroutine check_activation(activation, number, error)
        type(rod_activation_t), intent(in) :: activation
        integer, intent(in) :: number           !! For the message
        type(error_t), allocatable, intent(out) :: error

        character(:), allocatable :: name

        name = 'torque rod activation '//integer_text(number)//': '
        if (activation%axis < 1 .or. activation%axis > 3) then
            call fail(error, name//'axis = '//integer_text(activation%axis)// &
                      ' has to be 1, 2 or 3')
        else if (.not. all(ieee_is_finite( &
                           [activation%amplitude, activation%frequency, activation%phase, &
                            activation%start, activation%stop]))) then
            call fail(error, name//'amplitude, frequency, phase, start and stop have to be '// &
                      'finite numbers')
        else if (activation%frequency < 0) then
            call fail(error, name//'frequency = '//number_text(activation%frequency)// &
                      ' Hz must not be negative')
        else if (activation%stop <= activation%start) then
            call fail(error, name//'stop = '//number_text(activation%stop)//' s has to be '// &
                      'later than start = '//number_text(activation%start)//' s')
        end if
    end subroutine check_activation

    !> A rod's greatest sum of amplitudes occurs where one of its activations starts.
    subroutine check_total_moment(activations, error)
        type(rod_activation_t), intent(in) :: activations(:)
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: total
        integer :: i

        do i = 1, size(activations)
            associate (axis => activations(i)%axis, time => activations(i)%start)
                total = sum(abs(activations%amplitude), mask=activations%axis == axis .and. &
                            activations%start <= time .and. time <= activations%stop)
                if (total > MAX_DIPOLE) then
                    call fail(error, 'torque rod '//integer_text(axis)//': amplitudes '// &
                              'add up to '//number_text(total)//' A m^2 at t = '// &
                              number_text(time)//' s; a rod bears at most '// &
                              number_text(MAX_DIPOLE)//' A m^2')
                    return
                end if
            end associate
        end do
    end subroutine check_total_moment

    !> Dipole moment of all rods at a time, body axes, A m^2.
    pure function dipole_moment(self, time) result(moment)
        type(torque_rods_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s
        real(dp) :: moment(3)

        integer :: i

        moment = 0
        do i = 1, self%count
            associate (a => self%activations(i))
                if (time >= a%start .and. time <= a%stop) then
                    moment(a%axis) = moment(a%axis) + &
                                     a%amplitude*sin(TWO_PI*a%frequency*(time - a%start) + a%phase)
                end if
            end associate
        end do
    end function dipole_moment

    !> Which rods to drive, and with what signs, as CSR-TM-00-01 chooses them at the end of
    !> section 4.2: the x rod rests and m_y = -m_z sign(B_y B_z), so that the x torques of both
    !> rods add up. The common sign, free in the report, is that of m_z = 1. All six printed
    !> patterns agree.
    pure function report_pattern(field) result(pattern)
        real(dp), intent(in) :: field(3)    !! Geomagnetic field in body axes at the start, any unit
        integer :: pattern(3)

        pattern = pattern_of_pair(field, 2, 3)
    end function report_pattern

    !> The general rule of CSR-TM-00-01 section 4.2: with |B_i| > |B_j| > |B_k| the rod along i
    !> rests, m_k = 1 (the report leaves the common sign free) and m_j = -m_k sign(B_j B_k). Near
    !> the poles, where the z component is the greatest, its pattern is not the one the report
    !> uses.
    pure function weakest_components_pattern(field) result(pattern)
        real(dp), intent(in) :: field(3)    !! Geomagnetic field in body axes at the start, any unit
        integer :: pattern(3)

        integer :: i, k

        i = maxloc(abs(field), 1)
        k = minloc(abs(field), 1, back=.true.)      ! the last one, to differ from i in ties
        pattern = pattern_of_pair(field, 6 - i - k, k)
    end function weakest_components_pattern

    !> The pattern with m_k = 1, m_j = -sign(B_j B_k) and the third rod at rest; sign(0) = 0. A
    !> field that is not finite gives the pattern zero, which new_harmonic_manoeuvre refuses.
    pure function pattern_of_pair(field, j, k) result(pattern)
        real(dp), intent(in) :: field(3)
        integer, intent(in) :: j, k         !! The two rods
        integer :: pattern(3)

        pattern = 0
        if (.not. all(ieee_is_finite(field))) return
        pattern(k) = 1
        pattern(j) = -signum(field(j))*signum(field(k))
    end function pattern_of_pair

    pure integer function signum(x)
        real(dp), intent(in) :: x

        signum = merge(1, 0, x > 0) - merge(1, 0, x < 0)
    end function signum
end module gracecg_torque_rods
