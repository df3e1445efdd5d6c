!> An orbit about an Earth that does not turn.
module gracecg_peer_orbit
    use gracecg_base_kinds, only: dp
    use gracecg_base_runge_kutta, only: ode_system_t
    use gracecg_environment_geopotential, only: gravity_model_t
    implicit none
    private
    public :: orbit_t

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
end module gracecg_peer_orbit

!> What bench/peers.py compares with other programs: seconds a call, and numbers by which their answers are compared.
!>
!>     gracecg_peer gravity 20 | field | density | derivative | orbit
!>
!> Prints `seconds S` (the best of several repeats), `value X Y Z` for the first places, and for `orbit` a line
!> `run TOLERANCE SECONDS X Y Z` each tolerance.
program gracecg_peer
    use, intrinsic :: iso_fortran_env, only: int64
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t
    use gracecg_base_runge_kutta, only: rkf78_integrate
    use gracecg_environment_geopotential, only: gravity_model_t
    use gracecg_environment_gravity_models, only: new_gravity_model
    use gracecg_environment_geomagnetic_field, only: geomagnetic_model_t
    use gracecg_environment_geomagnetic_models, only: new_geomagnetic_model
    use gracecg_environment_thermosphere, only: atmosphere_point_t, atmosphere_state_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_case_models, only: build_dynamics, initial_state
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, STATE_SIZE
    use gracecg_simulation_report_cases, only: report_case
    use gracecg_peer_orbit, only: orbit_t
    implicit none

    integer, parameter :: PLACES = 1000, SHOWN = 5, REPEATS = 5
    real(dp), parameter :: RADIUS = 6.838e6_dp, DAY = 86400.0_dp
    class(gravity_model_t), allocatable :: gravity
    class(geomagnetic_model_t), allocatable :: field
    type(satellite_dynamics_t) :: dynamics
    type(case_t) :: case
    type(error_t), allocatable :: error
    character(16) :: task, argument
    real(dp) :: place(3, PLACES), state(STATE_SIZE), sink
    integer :: degree, i

    do i = 1, PLACES
        place(:, i) = place_of(i)
    end do
    call get_command_argument(1, task)
    call get_command_argument(2, argument)
    degree = 20
    if (argument /= '') read (argument, *) degree
    sink = 0
    call new_gravity_model('egm96', degree, degree, '', gravity, error)
    if (.not. allocated(error)) call new_geomagnetic_model('igrf14', 2020.0_dp, '', field, error)
    if (.not. allocated(error)) call report_case('front-1', case, error)
    if (.not. allocated(error)) call build_dynamics(case, dynamics, error)
    if (allocated(error)) error stop error%message
    state = initial_state(case)
    select case (task)
    case ('gravity')
        call time_it(one_gravity, 400000/degree)
    case ('field')
        call time_it(one_field, 100000)
    case ('density')
        call time_it(one_density, 100000)
    case ('derivative')
        call time_it(one_derivative, 50000)
    case ('orbit')
        call fly()
    case default
        error stop 'gravity DEGREE, field, density, derivative or orbit'
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

    subroutine time_it(work, calls)
        interface
            subroutine work(r, answer)
                import :: dp
                real(dp), intent(in) :: r(3)
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
                call work(place(:, modulo(k, PLACES) + 1), answer)
                sink = sink + answer(1)
            end do
            call system_clock(finish)
            best = min(best, real(finish - start, dp)/ticks/calls)
        end do
        print '(a, es14.6)', 'seconds', best
        do k = 1, SHOWN
            call work(place(:, k), answer)
            print '(a, 3es25.16)', 'value', answer
        end do
    end subroutine time_it

    subroutine one_gravity(r, answer)
        real(dp), intent(in) :: r(3)
        real(dp), intent(out) :: answer(3)

        call gravity%acceleration(r, answer)
    end subroutine one_gravity

    subroutine one_field(r, answer)
        real(dp), intent(in) :: r(3)
        real(dp), intent(out) :: answer(3)

        call field%evaluate(r, answer)
    end subroutine one_field

    subroutine one_density(r, answer)
        real(dp), intent(in) :: r(3)
        real(dp), intent(out) :: answer(3)
        type(atmosphere_state_t) :: air

        call dynamics%atmosphere%evaluate( &
            atmosphere_point_t(450e3_dp, asin(r(3)/RADIUS), 12 + atan2(r(2), r(1))*24/TWO_PI, 80.0_dp), air)
        answer = air%density
    end subroutine one_density

    subroutine one_derivative(r, answer)
        real(dp), intent(in) :: r(3)
        real(dp), intent(out) :: answer(3)
        real(dp) :: rate(STATE_SIZE)

        call dynamics%rate(r(1)*1e-6_dp, state, rate)
        answer = rate(4:6)
    end subroutine one_derivative

    !> A day by Runge-Kutta-Fehlberg 7(8) at several tolerances; the first one is the reference.
    subroutine fly()
        real(dp), parameter :: TOLERANCE(8) = [1e-15_dp, 3e-12_dp, 1e-12_dp, 3e-13_dp, 1e-13_dp, 3e-14_dp, 1e-14_dp, 3e-15_dp]
        real(dp), parameter :: SCALES(6) = [1e7_dp, 1e7_dp, 1e7_dp, 1e4_dp, 1e4_dp, 1e4_dp]
        type(orbit_t) :: orbit
        integer(int64) :: start, finish, ticks
        real(dp) :: y(6), t, best
        integer :: k, repeat, steps

        allocate (orbit%gravity, source=gravity)
        do k = 1, size(TOLERANCE)
            best = huge(best)
            do repeat = 1, REPEATS
                y = [RADIUS, 0.0_dp, 0.0_dp, 0.0_dp, 120.0_dp, 7634.0_dp]
                t = 0
                call system_clock(start, ticks)
                call rkf78_integrate(orbit, t, y, DAY, TOLERANCE(k), SCALES, steps, error)
                if (allocated(error)) error stop error%message
                call system_clock(finish)
                best = min(best, real(finish - start, dp)/ticks)
            end do
            print '(a, 2es14.6, 3es25.16)', 'run', TOLERANCE(k), best, y(:3)
        end do
    end subroutine fly
end program gracecg_peer
