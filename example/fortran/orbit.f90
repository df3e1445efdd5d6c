!> Our force model in an orbit integrator of one's own: a minute of the orbit of front-1, by the classical
!> Runge-Kutta method with steps of one second.
!>
!>     fpm run --example orbit
!>     gfortran orbit.f90 $(pkg-config --cflags --libs gracecg)
!>
!> The positions are those of `gracecg simulate front-1` to a hundredth of a millimetre.
program orbit
    use gracecg, only: dp, error_t, case_t, find_case, build_dynamics, initial_state, &
        satellite_dynamics_t, accelerations_t, quaternion_rate, &
        STATE_SIZE, STATE_POSITION, STATE_VELOCITY, STATE_OMEGA, STATE_ATTITUDE
    implicit none
    real(dp), parameter :: STEP = 1.0_dp        ! s
    integer, parameter :: STEPS = 60
    ! What is integrated: position (m) and velocity (m/s), inertial, and the attitude quaternion
    integer, parameter :: R(3) = [1, 2, 3], V(3) = [4, 5, 6], Q(4) = [7, 8, 9, 10]
    type(case_t) :: case
    type(satellite_dynamics_t) :: satellite     ! gravity 20x20, drag, light of Sun and Earth
    type(accelerations_t) :: acting
    type(error_t), allocatable :: error
    real(dp) :: state(STATE_SIZE), omega(3), y(10)
    integer :: k

    call find_case('front-1', case, error)
    if (.not. allocated(error)) call build_dynamics(case, satellite, error)
    if (allocated(error)) error stop error%message

    state = initial_state(case)
    y = [state(STATE_POSITION), state(STATE_VELOCITY), state(STATE_ATTITUDE)]
    omega = state(STATE_OMEGA)                  ! one turn a revolution, kept constant here

    call satellite%accelerations(0.0_dp, y(R), y(V), y(Q), acting)
    print '(a)', 'accelerations at the epoch, inertial, m/s^2'
    print '(a, 3es16.7)', 'gravity          ', acting%gravity
    print '(a, 3es16.7)', 'drag             ', acting%drag
    print '(a, 3es16.7)', 'solar radiation  ', acting%solar_radiation
    print '(a, 3es16.7)', 'Earth radiation  ', acting%earth_radiation

    print '(/, a)', '   t, s            x, m              y, m              z, m'
    do k = 0, STEPS
        if (mod(k, 10) == 0) print '(f7.1, 3f18.5)', k*STEP, y(R)
        y = runge_kutta_4(k*STEP, y)
    end do

contains

    !> One step of the classical Runge-Kutta method.
    function runge_kutta_4(t, y) result(next)
        real(dp), intent(in) :: t, y(:)
        real(dp) :: next(size(y)), k1(size(y)), k2(size(y)), k3(size(y)), k4(size(y))

        k1 = rate(t, y)
        k2 = rate(t + STEP/2, y + STEP/2*k1)
        k3 = rate(t + STEP/2, y + STEP/2*k2)
        k4 = rate(t + STEP, y + STEP*k3)
        next = y + STEP/6*(k1 + 2*k2 + 2*k3 + k4)
    end function runge_kutta_4

    !> The equations of motion: all that the library has to say is an acceleration.
    function rate(t, y) result(dydt)
        real(dp), intent(in) :: t, y(:)
        real(dp) :: dydt(size(y))
        type(accelerations_t) :: acting

        call satellite%accelerations(t, y(R), y(V), y(Q), acting)
        dydt(R) = y(V)
        dydt(V) = acting%total
        dydt(Q) = quaternion_rate(y(Q), omega)
    end function rate
end program orbit
