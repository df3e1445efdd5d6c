!> Attitude control: torque rods, and thrusters for what rods cannot do, hold a satellite as it stands to its orbit, by a
!> proportional and derivative law.
!>
!> The wanted torque is T = -J_i (w^2 e + 2 zeta w (omega - omega_o)) about each body axis, e the turn away from the
!> attitude that is held, omega_o the rate of the orbital axes, w and zeta those of an oscillator with the moment of
!> inertia J_i. A magnetic moment makes no torque along the field B; of moments that make the rest of T, the least is
!>
!>     m = B x T/|B|^2,    m x B = T - (T.B) B/|B|^2
!>
!> (J. R. Wertz, ed., Spacecraft Attitude Determination and Control, 1978; M. Lovera and A. Astolfi, Spacecraft
!> attitude control using magnetic actuators, Automatica 40 (2004) 1405-1414). By rods alone, in the mean over an orbit,
!> such a satellite is not held against the torques of air and gravity gradient: its smallest moment of inertia is a
!> fifth of the others (theory, section 8). So thrusters, as GRACE has them, give the rest, which is along B: a smooth
!> torque, without the pulses of real ones and without a force.
module gracecg_simulation_attitude_control
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail, add_context, number_text
    use gracecg_base_vectors, only: cross, unit, identity
    use gracecg_base_quaternion, only: rotation_matrix
    use gracecg_files_settings, only: settings_t
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, check_total_moment
    implicit none
    private
    public :: attitude_control_t, orbital_axes, describe_control, check_control

    character(*), parameter :: GROUP = 'control'

    !> The law and what it holds. By default it does nothing.
    type :: attitude_control_t
        logical :: acts = .false.           !! The case has a control
        real(dp) :: frequency = 1e-3_dp         !! w/(2 pi), Hz
        real(dp) :: damping = 1                 !! zeta
        real(dp) :: greatest_moment = 5         !! To which the rods' moment is bounded, smoothly, A m^2
        logical :: thrusters = .true.           !! They give what is along the field
        real(dp) :: body_from_orbit(3, 3) = 0   !! Matrix of the attitude that is held
    contains
        procedure :: hold               !! Takes an attitude as that to be held
        procedure :: turn               !! From the attitude that is held to that of a state
        procedure :: wanted_torque      !! T
        procedure :: act                !! What rods and thrusters do
    end type attitude_control_t

contains

    !> The matrix that turns inertial axes into orbital ones, its rows: z to the centre of the Earth, y against the
    !> orbit's normal, x forward.
    pure function orbital_axes(position, velocity) result(axes)
        real(dp), intent(in) :: position(3), velocity(3)    !! Inertial, m, m/s
        real(dp) :: axes(3, 3)

        real(dp) :: y(3), z(3)

        z = -unit(position)
        y = unit(cross(velocity, position))
        axes(1, :) = cross(y, z)
        axes(2, :) = y
        axes(3, :) = z
    end function orbital_axes

    !> From now on the attitude of a state, as it stands to the orbit, is held.
    pure subroutine hold(self, state)
        class(attitude_control_t), intent(inout) :: self
        real(dp), intent(in) :: state(13)       !! See gracecg_simulation_dynamics

        self%body_from_orbit = identity(3)
        self%body_from_orbit = self%turn(state)
    end subroutine hold

    !> The matrix of the turn from the attitude that is held to that of a state.
    pure function turn(self, state) result(matrix)
        class(attitude_control_t), intent(in) :: self
        real(dp), intent(in) :: state(13)       !! Of the 13 equations (2-31)
        real(dp) :: matrix(3, 3)

        real(dp) :: held(3, 3), attitude(3, 3)

        held = matmul(self%body_from_orbit, orbital_axes(state(1:3), state(4:6)))
        attitude = rotation_matrix(state(10:13)/norm2(state(10:13)))
        matrix = matmul(attitude, transpose(held))
    end function turn

    !> The torque that the law wants, body axes, N m. e is the sine of the turn along its axis; the orbital axes turn
    !> with r x v/r^2.
    pure function wanted_torque(self, state, inertia) result(torque)
        class(attitude_control_t), intent(in) :: self
        real(dp), intent(in) :: state(13)       !! Of the 13 equations (2-31)
        real(dp), intent(in) :: inertia(3, 3)   !! kg m^2
        real(dp) :: torque(3)

        real(dp) :: away(3, 3), attitude(3, 3), turned(3), rate(3), w
        integer :: i

        away = self%turn(state)
        turned = [away(2, 3) - away(3, 2), away(3, 1) - away(1, 3), away(1, 2) - away(2, 1)]/2
        attitude = rotation_matrix(state(10:13)/norm2(state(10:13)))
        rate = state(7:9) - matmul(attitude, cross(state(1:3), state(4:6))/dot_product(state(1:3), state(1:3)))
        w = TWO_PI*self%frequency
        torque = [(-inertia(i, i)*(w**2*turned(i) + 2*self%damping*w*rate(i)), i=1, 3)]
    end function wanted_torque

    !> Moment of the rods and torque of the thrusters: smooth functions of the state. The length of the moment stays
    !> below greatest_moment; the thrusters do as much less as the rods do then.
    pure subroutine act(self, state, inertia, field, moment, torque)
        class(attitude_control_t), intent(in) :: self
        real(dp), intent(in) :: state(13)       !! Of the 13 equations (2-31)
        real(dp), intent(in) :: inertia(3, 3)   !! kg m^2
        real(dp), intent(in) :: field(3)        !! B, body axes, T, not 0
        real(dp), intent(out) :: moment(3)      !! Of the rods, body axes, A m^2
        real(dp), intent(out) :: torque(3)      !! Of the thrusters, body axes, N m

        real(dp) :: wanted(3), squared, part

        wanted = self%wanted_torque(state, inertia)
        squared = dot_product(field, field)
        moment = cross(field, wanted)/squared
        part = 1/sqrt(1 + dot_product(moment, moment)/self%greatest_moment**2)
        moment = part*moment
        torque = 0
        if (self%thrusters) torque = part*dot_product(field, wanted)/squared*field
    end subroutine act

    !> The group of a case file: where it stands, the law acts.
    subroutine describe_control(settings, control)
        class(settings_t), intent(inout) :: settings
        type(attitude_control_t), intent(inout) :: control

        ! files without the law, and their checksums, stay what they were
        if (.not. (control%acts .or. settings%holds(GROUP))) return
        control%acts = .true.
        call settings%group(GROUP, 'Rods and thrusters hold the initial attitude to the orbit; the moments are measured')
        call settings%real_value('frequency', control%frequency, 1e-5_dp, 1e-2_dp, 'Hz, of the law as an oscillator', &
                                 unit='Hz')
        call settings%real_value('damping', control%damping, 0.1_dp, 10.0_dp, 'its damping ratio')
        call settings%real_value('greatest_moment', control%greatest_moment, 1e-3_dp, 1e4_dp, &
                                 'A m^2, beside the manoeuvre''s', unit='A m^2')
        call settings%logical_value('thrusters', control%thrusters, 'give the torque along the field, which no rod can')
        call settings%end_group()
    end subroutine describe_control

    !> Fails when the law and a manoeuvre together could ask more of a rod than it bears, or rods are misaligned, the
    !> law's moment being one of body axes, or are no rods.
    subroutine check_control(control, rods, error)
        type(attitude_control_t), intent(in) :: control
        type(torque_rods_t), intent(in) :: rods
        type(error_t), allocatable, intent(out) :: error

        if (.not. control%acts) return
        if (rods%direct) then
            call fail(error, 'control: it acts by rods, and the case has torquers (groups &torquers, &excitation); leave one out')
            return
        else if (any(abs(rods%misalignment) > 0)) then
            call fail(error, 'control: rods with a misalignment are not held by it; set misalignment_deg of &rods to 0')
            return
        end if
        call check_total_moment(rods, control%greatest_moment, error)
        call add_context(error, 'control: with greatest_moment = '//number_text(control%greatest_moment)//' A m^2')
    end subroutine check_control
end module gracecg_simulation_attitude_control
