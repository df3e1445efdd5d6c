!> An orbit about an Earth that does not turn.
module gracecg_peer_orbit
    use gracecg_base_kinds, only: dp
    use gracecg_base_runge_kutta, only: ode_system_t, controlled_steps_t, begin_steps
    use gracecg_environment_geopotential, only: gravity_model_t
    implicit none
    private
    public :: orbit_t, rk4_step

    type, extends(ode_system_t) :: orbit_t
        class(gravity_model_t), allocatable :: gravity
    contains
        procedure :: rate => orbit_rate
    end type orbit_t

contains

    pure subroutine orbit_rate(self, t, y, dydt)
        class(orbit_t), intent(in) :: self
        real(dp), intent(in) :: t, y(:)
        real(dp), intent(out) :: dydt(:)

        dydt(1:3) = y(4:6) + 0*t
        call self%gravity%acceleration(y(1:3), dydt(4:6))
    end subroutine orbit_rate

    !> A step of the classical method of Runge and Kutta, of order 4.
    pure subroutine rk4_step(system, h, t, y)
        class(ode_system_t), intent(in) :: system
        real(dp), intent(in) :: h
        real(dp), intent(inout) :: t, y(:)
        real(dp), dimension(size(y)) :: k1, k2, k3, k4

        call system%rate(t, y, k1)
        call system%rate(t + h/2, y + h/2*k1, k2)
        call system%rate(t + h/2, y + h/2*k2, k3)
        call system%rate(t + h, y + h*k3, k4)
        y = y + h/6*(k1 + 2*k2 + 2*k3 + k4)
        t = t + h
    end subroutine rk4_step
end module gracecg_peer_orbit

!> What bench/peers.py compares with other programs: seconds a call, and numbers by which their answers are compared.
!>
!>     gracecg_peer gravity 20 | field | density | forces | forces-dark | derivative | equations | orbit
!>
!> Prints `seconds S` (the best of several repeats), `value X Y Z` for the first places, for the forces (dark: without the
!> Earth's light) a line `size NAME S` each, and for `orbit` a line `run TOLERANCE SECONDS X Y Z` each tolerance.
program gracecg_peer
    use, intrinsic :: iso_fortran_env, only: int64
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_rate
    use gracecg_base_vectors, only: inverse_3x3
    use gracecg_environment_geopotential, only: gravity_model_t
    use gracecg_environment_gravity_models, only: new_gravity_model
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model
    use gracecg_environment_thermosphere, only: atmosphere_point_t, atmosphere_state_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_case_models, only: build_dynamics, initial_state
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, accelerations_t, STATE_SIZE
    use gracecg_simulation_report_cases, only: report_case
    use gracecg_peer_orbit, only: orbit_t, rk4_step
    implicit none

    integer, parameter :: PLACES = 1000, SHOWN = 5, REPEATS = 5
    real(dp), parameter :: RADIUS = 6.838e6_dp, SPEED = 7634.0_dp, DAY = 86400.0_dp, INTERVAL = 5.6_dp
    class(gravity_model_t), allocatable :: gravity
    class(geomagnetic_model_t), allocatable :: field
    type(satellite_dynamics_t) :: dynamics
    type(case_t) :: case
    type(error_t), allocatable :: error
    character(16) :: task, argument
    real(dp) :: place(3, PLACES), state(STATE_SIZE, PLACES), sink
    integer :: degree, i

    do i = 1, PLACES
        place(:, i) = place_of(i)
    end do
    call get_command_argument(1, task)
    call get_command_argument(2, argument)
    degree = 20
    if (task == 'gravity') read (argument, *) degree
    sink = 0
    call new_gravity_model('egm96', degree, degree, '', gravity, error)
    if (.not. allocated(error)) call new_geomagnetic_model('igrf14', 2020.0_dp, '', field, error)
    if (.not. allocated(error)) call report_case('front-1', case, error)
    case%earth_radiation_constants = 'knocke'
    case%earth_radiation_centres = 'half-solid-angle'       ! 0.5 % off the integral with 19 segments
    if (.not. allocated(error)) call build_dynamics(case, dynamics, error)
    if (allocated(error)) error stop error%message
    do i = 1, PLACES
        state(:, i) = state_of(i)
    end do
    select case (task)
    case ('gravity')
        call time_it(one_gravity, 400000/degree)
    case ('field')
        call time_it(one_field, 100000)
    case ('density')
        call time_it(one_density, 100000)
    case ('forces', 'forces-dark')
        dynamics%with_earth_radiation = task == 'forces'
        call time_it(one_force, 50000)
        call show_sizes()
    case ('derivative')
        call time_it(one_derivative, 50000)
    case ('equations')
        call turn()
    case ('orbit')
        call fly()
    case default
        error stop 'gravity DEGREE, field, density, forces, derivative, equations or orbit'
    end select
    if (abs(sink) > huge(sink)) print '(es12.4)', sink      ! keeps the results alive

contains

    !> Places all around, as the other programs have them.
    pure function place_of(i) result(r)
        integer, intent(in) :: i
        real(dp) :: r(3), longitude, latitude

        longitude = TWO_PI*modulo(i*0.618034_dp, 1.0_dp)
        latitude = TWO_PI*(modulo(i*0.381966_dp*0.5_dp, 0.5_dp) - 0.25_dp)*0.98_dp
        r = RADIUS*[cos(latitude)*cos(longitude), cos(latitude)*sin(longitude), sin(latitude)]
    end function place_of

    !> Once around over the poles, INTERVAL after INTERVAL, with the attitude that turns along.
    pure function state_of(i) result(y)
        integer, intent(in) :: i
        real(dp) :: y(STATE_SIZE), angle, start(STATE_SIZE)

        angle = TWO_PI*i/PLACES
        start = initial_state(case)
        y(1:3) = RADIUS*[cos(angle), 0.0_dp, sin(angle)]
        y(4:6) = SPEED*[-sin(angle), 0.0_dp, cos(angle)]
        y(7:9) = start(7:9)
        y(10:13) = cos(angle/2)*start(10:13) + 2*sin(angle/2)*quaternion_rate(start(10:13), [0.0_dp, 1.0_dp, 0.0_dp])
    end function state_of

    subroutine time_it(work, calls)
        interface
            subroutine work(i, answer)
                import :: dp
                integer, intent(in) :: i
                real(dp), intent(out) :: answer(3)
            end subroutine work
        end interface
        integer, intent(in) :: calls

        integer(int64) :: start, finish, ticks
        real(dp) :: best, answer(3)
        integer :: repeat, k

        best = huge(best)
        do repeat = 1, REPEATS
            call system_clock(start, ticks)
            do k = 1, calls
                call work(modulo(k, PLACES) + 1, answer)
                sink = sink + answer(1)
            end do
            call system_clock(finish)
            best = min(best, real(finish - start, dp)/ticks/calls)
        end do
        print '(a, es14.6)', 'seconds', best
        do k = 1, SHOWN
            call work(k, answer)
            print '(a, 3es25.16)', 'value', answer
        end do
    end subroutine time_it

    subroutine one_gravity(i, answer)
        integer, intent(in) :: i
        real(dp), intent(out) :: answer(3)

        call gravity%acceleration(place(:, i), answer)
    end subroutine one_gravity

    subroutine one_field(i, answer)
        integer, intent(in) :: i
        real(dp), intent(out) :: answer(3)

        call field%evaluate(place(:, i), answer)
    end subroutine one_field

    subroutine one_density(i, answer)
        integer, intent(in) :: i
        real(dp), intent(out) :: answer(3)
        type(atmosphere_state_t) :: air

        call dynamics%atmosphere%evaluate( &
            atmosphere_point_t(450e3_dp, asin(place(3, i)/RADIUS), 12 + atan2(place(2, i), place(1, i))*24/TWO_PI, 80.0_dp), air)
        answer = air%density
    end subroutine one_density

    !> All accelerations; gravity, which the others have to the last digits, is the answer.
    subroutine one_force(i, answer)
        integer, intent(in) :: i
        real(dp), intent(out) :: answer(3)
        type(accelerations_t) :: acting

        call dynamics%accelerations(INTERVAL*i, state(1:3, i), state(4:6, i), state(10:13, i), acting)
        sink = sink + acting%total(1)
        answer = acting%gravity
    end subroutine one_force

    !> The mean size of each acceleration, m/s^2.
    subroutine show_sizes()
        type(accelerations_t) :: acting
        real(dp) :: drag, sunlight, earthlight
        integer :: k

        drag = 0
        sunlight = 0
        earthlight = 0
        do k = 1, PLACES
            call dynamics%accelerations(INTERVAL*k, state(1:3, k), state(4:6, k), state(10:13, k), acting)
            drag = drag + norm2(acting%drag)/PLACES
            sunlight = sunlight + norm2(acting%solar_radiation)/PLACES
            earthlight = earthlight + norm2(acting%earth_radiation)/PLACES
        end do
        print '(a, es14.6)', 'size drag', drag, 'size sunlight', sunlight
        if (dynamics%with_earth_radiation) print '(a, es14.6)', 'size earthlight', earthlight
    end subroutine show_sizes

    subroutine one_derivative(i, answer)
        integer, intent(in) :: i
        real(dp), intent(out) :: answer(3)
        real(dp) :: rate(STATE_SIZE)

        call dynamics%rate(INTERVAL*i, state(:, i), rate)
        answer = rate(4:6)
    end subroutine one_derivative

    !> Orbit and free rotation, gravity alone, Earth at rest: a quarter of a Runge-Kutta step of 1 s; after STEPS of them
    !> position, velocity, angular velocity, two of the body's axes.
    subroutine turn()
        integer, parameter :: STEPS = 1000, TIMED = 20000
        real(dp), parameter :: INERTIA(3, 3) = reshape([real(dp) :: 70, 3, 3, 3, 345, 0.3_dp, 3, 0.3_dp, 389], [3, 3])
        type(satellite_dynamics_t) :: free
        integer(int64) :: start, finish, ticks
        real(dp) :: y(STATE_SIZE), t, best, axes(3, 3)
        integer :: k, repeat

        free = dynamics
        deallocate (free%field)
        free%earth%rate = 0
        free%inertia = INERTIA
        free%inverse_inertia = inverse_3x3(INERTIA)
        free%with_drag = .false.
        free%with_solar_radiation = .false.
        free%with_earth_radiation = .false.
        free%with_gravity_gradient = .false.
        free%with_rods = .false.
        y = [RADIUS, 0.0_dp, 0.0_dp, 0.0_dp, 120.0_dp, SPEED, 0.001_dp, 0.0011_dp, -0.002_dp, &
             [0.2_dp, 0.4_dp, -0.6_dp, 0.86_dp]/1.14_dp]
        t = 0
        do k = 1, STEPS
            call rk4_step(free, 1.0_dp, t, y)
        end do
        axes = rotation_matrix(y(10:13)/norm2(y(10:13)))
        print '(5(a, 3es25.16, /))', 'value', y(1:3), 'value', y(4:6), 'value', y(7:9), 'value', axes(1, :), 'value', axes(2, :)
        best = huge(best)
        do repeat = 1, REPEATS
            call system_clock(start, ticks)
            do k = 1, TIMED
                call rk4_step(free, 1.0_dp, t, y)
            end do
            call system_clock(finish)
            best = min(best, real(finish - start, dp)/ticks/TIMED/4)
        end do
        print '(a, es14.6)', 'seconds', best
        sink = sink + y(1)
    end subroutine turn

    !> A day by Runge-Kutta-Fehlberg 7(8) at several tolerances; the first one is the reference.
    subroutine fly()
        real(dp), parameter :: TOLERANCE(8) = [1e-12_dp, 1e-8_dp, 3e-9_dp, 1e-9_dp, 3e-10_dp, 1e-10_dp, 3e-11_dp, 1e-11_dp]
        real(dp), parameter :: SCALES(6) = [1e7_dp, 1e7_dp, 1e7_dp, 1e4_dp, 1e4_dp, 1e4_dp]
        type(orbit_t) :: orbit
        integer(int64) :: start, finish, ticks
        type(controlled_steps_t) :: flight
        real(dp) :: y(6), best
        integer :: k, repeat

        allocate (orbit%gravity, source=gravity)
        do k = 1, size(TOLERANCE)
            best = huge(best)
            do repeat = 1, REPEATS
                y = [RADIUS, 0.0_dp, 0.0_dp, 0.0_dp, 120.0_dp, 7634.0_dp]
                call system_clock(start, ticks)
                call begin_steps(0.0_dp, y, TOLERANCE(k), SCALES, 10.0_dp, flight)
                do while (flight%to < DAY)
                    call flight%advance(orbit, DAY, error)
                    if (allocated(error)) error stop error%message
                end do
                y = flight%state_at(DAY)
                call system_clock(finish)
                best = min(best, real(finish - start, dp)/ticks)
            end do
            print '(a, 2es14.6, 3es25.16)', 'run', TOLERANCE(k), best, y(:3)
        end do
    end subroutine fly
end program gracecg_peer
