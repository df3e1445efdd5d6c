!> What the expensive pieces cost: fpm run --example benchmark --profile release
!>
!> Each line is the best of several repeats on one core; varying arguments keep the compiler from
!> hoisting the work out of the loop.
program benchmark
    use, intrinsic :: iso_fortran_env, only: int64, output_unit, error_unit
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t
    use gracecg_environment_geopotential, only: geopotential_t, egm96
    use gracecg_environment_thermosphere, only: atmosphere_point_t, atmosphere_state_t
    use gracecg_environment_sun, only: sun_position
    use gracecg_environment_earth_radiation, only: earth_irradiance_t
    use gracecg_base_runge_kutta, only: rkf78_step
    use gracecg_base_text, only: real_field
    use gracecg_base_spectrum, only: strongest_line
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise
    use gracecg_estimation_noise_propagation, only: stationary_noise_covariance
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, STATE_SIZE
    use gracecg_simulation_arc, only: truth_arc_t
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_solution, only: solution_t
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_report_options, only: report_options
    use gracecg_estimation_estimators, only: estimate_offset
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_report_cases, only: report_case
    use gracecg_simulation_case_models, only: build_dynamics, initial_state
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, propagate_case, observe
    use gracecg_studies_monte_carlo, only: monte_carlo_t, run_monte_carlo
    implicit none

    integer, parameter :: REPEATS = 7, PLACES = 1000, HOUR = 36000     ! HOUR: samples
    real(dp) :: place(3, PLACES)        ! on the orbit, m
    type(case_t) :: case
    type(satellite_dynamics_t) :: dynamics
    type(simulator_t) :: simulator
    type(observation_set_t) :: observations
    type(error_t), allocatable :: error
    type(geopotential_t) :: degree_20, degree_70
    real(dp) :: state(STATE_SIZE), sink

    call prepare()
    write (output_unit, '(a)') 'best of 7 repeats, one thread'
    call report_time('gravity, EGM96 20x20, acceleration', 200000, time_gravity)
    call report_time('gravity, 20x20, with potential and gradient', 100000, time_gravity_20_all)
    call report_time('gravity, 20x20, many places, each', 200000, time_gravity_20_many)
    call report_time('gravity, EGM96 70x70, acceleration', 20000, time_gravity_70)
    call report_time('gravity, 70x70, with potential and gradient', 20000, time_gravity_70_all)
    call report_time('gravity, 70x70, many places, each', 20000, time_gravity_70_many)
    call report_time('geomagnetic field, IGRF-95, degree 10', 200000, time_field)
    call report_time('thermosphere, DTM-77', 200000, time_density)
    call report_time('Sun, position', 200000, time_sun)
    call report_time('Earth radiation, 19 segments', 100000, time_earth_radiation)
    call report_time('whole derivative (2-31)', 100000, time_derivative)
    call report_time('one step of Runge-Kutta-Fehlberg 7(8)', 10000, time_step)
    call report_time('truth arc, 60 s in steps of 0.1 s', 1, time_arc)
    call report_time('the same in steps under control', 1, time_arc_under_control)
    call report_time('simulated observation set', 10, time_observations)
    call report_time('ASSEST (FDE), offset alone', 10, time_assest)
    call report_time('ASSEST (FDE), with covariance', 3, time_assest_covariance)
    call report_time('shortest decimal of a real', 200000, time_decimal)
    call report_time('strongest line, 1 h at 10 Hz, to 1 Hz', 1, time_strongest_line)
    call report_time('covariance of 9 parameters, 1 h at 10 Hz', 1, time_noise_covariance)
    call report_runs_per_second()
    if (sink == huge(sink)) write (output_unit, '(es12.4)') sink    ! keeps the results alive

contains

    !> Models, truth and observations of the report's first case.
    subroutine prepare()
        real(dp) :: angle
        integer :: i

        call report_case('front-1', case, error)
        if (.not. allocated(error)) call build_dynamics(case, dynamics, error)
        if (.not. allocated(error)) call new_simulator(case, simulator, error)
        if (.not. allocated(error)) call observe(simulator, 1, 1, observations, error)
        if (.not. allocated(error)) call egm96(20, 20, degree_20, error)
        if (.not. allocated(error)) call egm96(70, 70, degree_70, error)
        if (allocated(error)) then
            write (error_unit, '(a)') error%message
            error stop 1
        end if
        state = initial_state(case)
        sink = 0
        do i = 1, PLACES
            angle = TWO_PI*modulo(i*0.618034_dp, 1.0_dp)
            place(:, i) = 6.838e6_dp*[cos(angle), 0.0_dp, sin(angle)]
        end do
    end subroutine prepare

    subroutine report_time(name, evaluations, work)
        character(*), intent(in) :: name
        integer, intent(in) :: evaluations

        interface
            subroutine work(evaluations)
                integer, intent(in) :: evaluations
            end subroutine work
        end interface

        integer(int64) :: start, finish, ticks_per_second
        real(dp) :: best, seconds
        integer :: repeat

        best = huge(best)
        do repeat = 1, REPEATS
            call system_clock(start, ticks_per_second)
            call work(evaluations)
            call system_clock(finish)
            best = min(best, real(finish - start, dp)/ticks_per_second/evaluations)
        end do
        seconds = best
        if (seconds < 1e-4_dp) then
            write (output_unit, '(a45, f10.3, a)') name, seconds*1e6_dp, ' microseconds'
        else
            write (output_unit, '(a45, f10.3, a)') name, seconds*1e3_dp, ' milliseconds'
        end if
    end subroutine report_time

    subroutine time_gravity(evaluations)
        integer, intent(in) :: evaluations
        real(dp) :: a(3)
        integer :: i

        do i = 1, evaluations
            call dynamics%gravity%acceleration(place(:, modulo(i, PLACES) + 1), a)
            sink = sink + a(1)
        end do
    end subroutine time_gravity

    subroutine time_gravity_70(evaluations)
        integer, intent(in) :: evaluations
        real(dp) :: a(3)
        integer :: i

        do i = 1, evaluations
            call degree_70%acceleration(place(:, modulo(i, PLACES) + 1), a)
            sink = sink + a(1)
        end do
    end subroutine time_gravity_70

    subroutine time_gravity_20_all(evaluations)
        integer, intent(in) :: evaluations

        call evaluate_all(degree_20, evaluations)
    end subroutine time_gravity_20_all

    subroutine time_gravity_70_all(evaluations)
        integer, intent(in) :: evaluations

        call evaluate_all(degree_70, evaluations)
    end subroutine time_gravity_70_all

    subroutine evaluate_all(model, evaluations)
        type(geopotential_t), intent(in) :: model
        integer, intent(in) :: evaluations
        real(dp) :: u, a(3), tensor(3, 3)
        integer :: i

        do i = 1, evaluations
            call model%all_derivatives(place(:, modulo(i, PLACES) + 1), u, a, tensor)
            sink = sink + a(1) + tensor(1, 1)
        end do
    end subroutine evaluate_all

    subroutine time_gravity_20_many(evaluations)
        integer, intent(in) :: evaluations

        call evaluate_many(degree_20, evaluations)
    end subroutine time_gravity_20_many

    subroutine time_gravity_70_many(evaluations)
        integer, intent(in) :: evaluations

        call evaluate_many(degree_70, evaluations)
    end subroutine time_gravity_70_many

    subroutine evaluate_many(model, evaluations)
        type(geopotential_t), intent(in) :: model
        integer, intent(in) :: evaluations      ! a multiple of PLACES
        real(dp) :: a(3, PLACES)
        integer :: i

        do i = 1, evaluations/PLACES
            call model%accelerations(place, a)
            sink = sink + a(1, 1)
        end do
    end subroutine evaluate_many

    subroutine time_field(evaluations)
        integer, intent(in) :: evaluations
        real(dp) :: b(3)
        integer :: i

        do i = 1, evaluations
            call dynamics%field%evaluate(place(:, modulo(i, PLACES) + 1), b)
            sink = sink + b(1)
        end do
    end subroutine time_field

    subroutine time_density(evaluations)
        integer, intent(in) :: evaluations
        type(atmosphere_state_t) :: air
        integer :: i

        do i = 1, evaluations
            call dynamics%atmosphere%evaluate(atmosphere_point_t(460e3_dp + i, 1e-6_dp*i, 17.0_dp, 1.0_dp), air)
            sink = sink + air%density
        end do
    end subroutine time_density

    subroutine time_sun(evaluations)
        integer, intent(in) :: evaluations
        real(dp) :: sun(3)
        integer :: i

        do i = 1, evaluations
            sun = sun_position(dynamics%julian_centuries_tt + 1e-9_dp*i)
            sink = sink + sun(1)
        end do
    end subroutine time_sun

    subroutine time_earth_radiation(evaluations)
        integer, intent(in) :: evaluations
        type(earth_irradiance_t) :: radiation
        real(dp) :: sun(3)
        integer :: i

        sun = sun_position(dynamics%julian_centuries_tt)
        do i = 1, evaluations
            call dynamics%earth_radiation%irradiance_at(place(:, modulo(i, PLACES) + 1), sun, &
                                                        dynamics%earth_radiation_day, radiation)
            sink = sink + radiation%irradiance(1)
        end do
    end subroutine time_earth_radiation

    subroutine time_derivative(evaluations)
        integer, intent(in) :: evaluations
        real(dp) :: rate(STATE_SIZE)
        integer :: i

        do i = 1, evaluations
            call dynamics%rate(1e-3_dp*i, state, rate)
            sink = sink + rate(4)
        end do
    end subroutine time_derivative

    subroutine time_step(evaluations)
        integer, intent(in) :: evaluations
        real(dp) :: next(STATE_SIZE)
        integer :: i

        do i = 1, evaluations
            call rkf78_step(dynamics, 1e-3_dp*i, state, 0.1_dp, next)
            sink = sink + next(1)
        end do
    end subroutine time_step

    subroutine time_arc(evaluations)
        integer, intent(in) :: evaluations
        type(truth_arc_t) :: arc
        integer :: i

        do i = 1, evaluations
            call propagate_case(case, arc, error)
            sink = sink + arc%state(1, arc%steps)
        end do
    end subroutine time_arc

    subroutine time_arc_under_control(evaluations)
        integer, intent(in) :: evaluations
        type(case_t) :: other
        type(truth_arc_t) :: arc
        integer :: i

        other = case
        other%integrator = 'rkf78-controlled'
        do i = 1, evaluations
            call propagate_case(other, arc, error)
            sink = sink + arc%state(1, arc%steps)
        end do
    end subroutine time_arc_under_control

    subroutine time_decimal(evaluations)
        integer, intent(in) :: evaluations
        character(32) :: field
        integer :: i

        do i = 1, evaluations
            field = real_field(place(1, modulo(i, PLACES) + 1)*(1 + 1e-9_dp*i))
            sink = sink + iachar(field(9:9))
        end do
    end subroutine time_decimal

    subroutine time_strongest_line(evaluations)
        integer, intent(in) :: evaluations
        real(dp) :: values(HOUR), line, frequency
        integer :: i, k

        do i = 1, evaluations
            values = [(sin(1.7_dp*k) + cos(0.31_dp*modulo(k*k, 1000)), k=i, i + HOUR - 1)]
            call strongest_line([(k, k=1, HOUR)], values, HOUR, 0.1_dp, 0.1_dp*HOUR, 1.5_dp, 1.0_dp, line, frequency)
            sink = sink + line
        end do
    end subroutine time_strongest_line

    subroutine time_noise_covariance(evaluations)
        integer, intent(in) :: evaluations
        type(coloured_noise_t) :: noise
        real(dp) :: gain(9, HOUR), covariance(9, 9)
        integer :: i, k

        noise = coloured_noise(observations%knowledge%accelerometer_noise(1), 0.1_dp, error)
        do i = 1, evaluations
            gain = reshape([(sin(1.7_dp*k), k=i, i + 9*HOUR - 1)], [9, HOUR])
            covariance = stationary_noise_covariance(gain, [(k, k=1, HOUR)], noise)
            sink = sink + covariance(1, 1)
        end do
    end subroutine time_noise_covariance

    subroutine time_observations(evaluations)
        integer, intent(in) :: evaluations
        type(observation_set_t) :: drawn
        integer :: i

        do i = 1, evaluations
            call observe(simulator, 1, i, drawn, error, only_used_head=.true.)
            sink = sink + drawn%field(1, 1)
        end do
    end subroutine time_observations

    subroutine time_assest(evaluations)
        integer, intent(in) :: evaluations

        call estimate(evaluations, .false.)
    end subroutine time_assest

    subroutine time_assest_covariance(evaluations)
        integer, intent(in) :: evaluations

        call estimate(evaluations, .true.)
    end subroutine time_assest_covariance

    subroutine estimate(evaluations, covariance)
        integer, intent(in) :: evaluations
        logical, intent(in) :: covariance
        type(estimation_options_t) :: options
        type(solution_t) :: solution
        integer :: i

        options = report_options('front-1')
        options%covariance = covariance
        do i = 1, evaluations
            call estimate_offset('assest-fde', observations, options, solution, error)
            sink = sink + solution%offset(1)
        end do
    end subroutine estimate

    !> Simulated and estimated calibrations per second on 1 and 2 threads.
    subroutine report_runs_per_second()
        integer, parameter :: RUNS = 400
        type(monte_carlo_t) :: results
        integer(int64) :: start, finish, ticks_per_second
        real(dp) :: best, one_thread
        integer :: threads, repeat, i

        one_thread = 0
        do threads = 1, 2
            best = huge(best)
            do repeat = 1, 3
                call system_clock(start, ticks_per_second)
                call run_monte_carlo(simulator, 'assest-fde', report_options('front-1'), 1_i8, [(i, i=1, RUNS)], threads, &
                                     results, error)
                call system_clock(finish)
                best = min(best, real(finish - start, dp)/ticks_per_second)
            end do
            if (threads == 1) one_thread = best
            write (output_unit, '(a38, i2, a5, f10.0, a, f6.2, a)') 'Monte Carlo, ASSEST (FDE), threads:', &
                threads, '', RUNS/best, ' runs per second (', one_thread/best, ' times one thread)'
            sink = sink + results%offset(1, 1)
        end do
    end subroutine report_runs_per_second
end program benchmark
