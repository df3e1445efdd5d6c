!> A satellite whose attitude is held: body z to the centre of the Earth, y across the orbit, x along the orbit or
!> against it. Its orbit is integrated, torques do not turn it.
!>
!> The satellites of GRACE fly so within the 1 degree by which they pitch towards each other: the following one with
!> x along the velocity, the leading one with x against it.
module gracecg_simulation_nadir_pointing
    use gracecg_base_kinds, only: dp
    use gracecg_base_vectors, only: cross
    use gracecg_base_quaternion, only: quaternion_of_matrix
    use gracecg_simulation_attitude_control, only: orbital_axes
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, accelerations_t, loads_t, POSITION, &
        VELOCITY, OMEGA, ATTITUDE
    implicit none
    private
    public :: nadir_pointing_t, held_axes

    !> The dynamics of a satellite that is held so.
    type, extends(satellite_dynamics_t) :: nadir_pointing_t
        logical :: forward = .true.         !! Body x along the velocity, not against it
    contains
        procedure :: rate => orbital_rate   !! dX/dt: that of the orbit, 0 of the attitude, which follows from it
        procedure :: rate_under => orbital_rate_under
        procedure :: hold                   !! Puts attitude and angular velocity to where they are held
    end type nadir_pointing_t

contains

    !> dX/dt of (2-31) for the orbit alone, (2-1).
    pure subroutine orbital_rate(self, t, y, dydt)
        class(nadir_pointing_t), intent(in) :: self
        real(dp), intent(in) :: t           !! Since the epoch, s
        real(dp), intent(in) :: y(:)        !! State, 13 components
        real(dp), intent(out) :: dydt(:)    !! Its derivative by time, per s

        type(accelerations_t) :: acting
        real(dp) :: axes(3, 3)

        axes = held_axes(self%forward, y)
        call self%accelerations(t, y(POSITION), y(VELOCITY), quaternion_of_matrix(axes), acting)
        dydt = 0
        dydt(POSITION) = y(VELOCITY)
        dydt(VELOCITY) = acting%total
    end subroutine orbital_rate

    !> The same under loads that are known.
    pure subroutine orbital_rate_under(self, y, acting, dydt)
        class(nadir_pointing_t), intent(in) :: self
        real(dp), intent(in) :: y(:)            !! State, 13 components
        type(loads_t), intent(in) :: acting     !! At this state
        real(dp), intent(out) :: dydt(:)        !! Its derivative by time, per s

        call self%satellite_dynamics_t%rate_under(y, acting, dydt)
        dydt(OMEGA) = 0
        dydt(ATTITUDE) = 0
    end subroutine orbital_rate_under

    !> Attitude and angular velocity of position and velocity. The axes turn about the orbit's normal h as the
    !> position does, by h/r^2, and about the position as the orbit's plane is turned by the acceleration a across
    !> it, by r a.h/h^2.
    pure subroutine hold(self, t, y)
        class(nadir_pointing_t), intent(in) :: self
        real(dp), intent(in) :: t           !! Since the epoch, s
        real(dp), intent(inout) :: y(:)     !! State, 13 components

        type(accelerations_t) :: acting
        real(dp) :: axes(3, 3), h(3), r

        axes = held_axes(self%forward, y)
        y(ATTITUDE) = quaternion_of_matrix(axes)
        call self%accelerations(t, y(POSITION), y(VELOCITY), y(ATTITUDE), acting)
        h = cross(y(POSITION), y(VELOCITY))
        r = norm2(y(POSITION))
        y(OMEGA) = matmul(axes, h/r**2 + y(POSITION)*dot_product(acting%total, h)/dot_product(h, h))
    end subroutine hold

    !> The matrix that turns inertial into body axes: its rows are the body axes.
    pure function held_axes(forward, y) result(axes)
        logical, intent(in) :: forward      !! Body x along the velocity, not against it
        real(dp), intent(in) :: y(:)        !! State, or its position and velocity alone
        real(dp) :: axes(3, 3)

        axes = orbital_axes(y(POSITION), y(VELOCITY))
        if (.not. forward) axes(:2, :) = -axes(:2, :)
    end function held_axes
end module gracecg_simulation_nadir_pointing
