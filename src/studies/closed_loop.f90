!> Calibrations that stop when the offset is known: the live estimate, planned anew every ten seconds, many times from the
!> noise on, at places all along a revolution.
!>
!> The truth is a rigid body with its attitude quaternion under rods, gravity gradient and a torque nobody knows, in the field
!> along the nominal flight (gracecg_planning_site); the offset, bias, drift and scale factors of the accelerometer, the bias of
!> the magnetometer and that torque are drawn. A loop stops by its covariance alone. That, and with it the plan, depends on the
!> data through what the samples are linearised about, to second order: so the errors at the moment of stopping have the
!> covariance that is stated. A stop by the estimate itself would not leave it so.
module gracecg_studies_closed_loop
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: EARTH_GM
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise
    use gracecg_base_parallel, only: parallel_work_t, run_parallel
    use gracecg_base_progress, only: progress_t
    use gracecg_base_quaternion, only: quaternion_product, quaternion_rate, rotation_matrix, normalised
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_base_vectors, only: cross, inverse_3x3, unit
    use gracecg_spacecraft_gravity_gradient_torque, only: gravity_gradient_torque
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, dipole_moments, MAX_DIPOLE
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_dynamics, only: POSITION, VELOCITY, RATE => OMEGA, ATTITUDE
    use gracecg_simulation_simulator, only: simulator_t, new_simulator, tell_operator
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_observations_parameters, only: RATE_PLACES => RATE
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_estimation_live_estimate, only: live_estimate_t, live_sample_t, begin_live_estimate
    use gracecg_estimation_model_state, only: turned_by, turn_between
    use gracecg_estimation_offset_information, only: gravity_gradient_matrix
    use gracecg_estimation_offset_model, only: offset_matrix
    use gracecg_planning_next_seconds, only: next_seconds_t, begin_planning
    use gracecg_planning_nominal_orbit, only: nominal_orbit_t, new_nominal_orbit
    use gracecg_planning_site, only: planned_arc_t, manoeuvre_site_t, new_planned_arc, new_manoeuvre_site
    implicit none
    private
    public :: loop_settings_t, loop_t, loop_statistics_t, run_loops, statistics_of_loops

    integer, parameter :: STREAM_TRUTH = 1, STREAM_ACCELEROMETER = 2, STREAM_OTHERS = 5    !! Random numbers of a loop

    !> When a loop ends, and what nobody knows.
    type :: loop_settings_t
        real(dp) :: wanted = 2e-5_dp            !! Standard deviation of the worst axis that ends it, m
        real(dp) :: longest = 120               !! It ends then at the latest, s
        real(dp) :: plan_seconds = 10           !! That a plan is for
        real(dp) :: amplitude = MAX_DIPOLE      !! Of the rods, A m^2
        type(torque_rods_t) :: fixed            !! A manoeuvre that stands in for the plans, if it has activations
        integer :: places = 48                  !! Along the revolution
        logical :: real_forces = .false.        !! Drag and radiation of the case; else a straight line
        real(dp) :: offset_sigma = 3e-4_dp      !! Of each component of d, m
        real(dp) :: torque_sigma = 2e-5_dp      !! Of the torque that nobody knows, N m: Figures 5.6, 5.7 of CSR-TM-00-01
        real(dp) :: bias_sigma = 1e-6_dp        !! Of the accelerometer, m/s^2
        real(dp) :: drift_sigma = 1e-10_dp      !! Of its drift, m/s^3
        real(dp) :: rate_sigma = 1e-4_dp        !! Of the first guess of the angular velocity, rad/s
        integer(i8) :: seed = 1                 !! Of the random numbers
    end type loop_settings_t

    !> What a loop ended with.
    type :: loop_t
        logical :: stopped = .false.            !! By its standard deviation
        real(dp) :: time = 0                    !! When, s
        real(dp) :: error(3) = 0                !! Estimate minus true d, body axes, m
        real(dp) :: sigma(3) = 0                !! That it states, m
        real(dp) :: square = 0                  !! Error squared in units of the covariance
        integer :: edited = 0                   !! Samples left out
        integer :: plans = 0, resting = 0       !! Made; for which no manoeuvre kept the limits
    end type loop_t

    !> What many loops ended with.
    type :: loop_statistics_t
        integer :: loops = 0, stopped = 0       !! All; those that reached what was wanted
        real(dp) :: square = 0                  !! Mean of those: 3
        real(dp) :: square_error = 0            !! Its standard error, from their scatter
        real(dp) :: bias(3) = 0                 !! Mean of error by sigma
        real(dp) :: time = 0, earliest = 0, latest = 0      !! Mean and extremes, s
        real(dp) :: plans = 0                   !! Mean number
        integer :: edited = 0, resting = 0      !! Samples left out, plans without a manoeuvre, of all
    end type loop_statistics_t

    !> Where a loop flies.
    type :: place_t
        real(dp) :: quaternion(4) = 0, rate(3) = 0      !! At the start: inertial to body; body axes, rad/s
        real(dp), allocatable :: field(:, :)            !! (3, 0:2n), inertial, T
        real(dp), allocatable :: position(:, :)         !! (3, 0:2n), inertial, m
        real(dp), allocatable :: force(:, :)            !! (3, 0:n), body axes, m/s^2
        real(dp) :: force_slope(3, 3, 2) = 0            !! As of manoeuvre_site_t
    end type place_t

    !> Loops as pieces of work.
    type, extends(parallel_work_t) :: loops_t
        type(loop_settings_t) :: settings
        type(operator_knowledge_t) :: knowledge
        real(dp) :: field_noise = 0                     !! T
        integer :: number = 0                           !! The case's label
        integer :: steps = 0                            !! Of the longest loop
        type(place_t), allocatable :: places(:)
        type(next_seconds_t) :: planner
        type(loop_t), allocatable :: loops(:)
    contains
        procedure :: do_one => do_loop
    end type loops_t

    !> What a loop cannot know.
    type :: truth_t
        real(dp) :: quaternion(4) = 0, rate(3) = 0, omega_dot(3) = 0
        real(dp) :: offset(3) = 0, torque(3) = 0, bias(3) = 0, drift(3) = 0, scale(3) = 0, field_bias(3) = 0
    end type truth_t

contains

    !> Loops of a case's satellite. Fails when the case cannot be simulated or its noise is not given, when the rods allow no
    !> manoeuvre, and as the live estimate does.
    subroutine run_loops(case, settings, loops, threads, results, error, progress)
        type(case_t), intent(in) :: case                    !! Its manoeuvre and offset do not matter
        type(loop_settings_t), intent(in) :: settings
        integer, intent(in) :: loops, threads               !! How many; at once
        type(loop_t), allocatable, intent(out) :: results(:)
        type(error_t), allocatable, intent(out) :: error
        class(progress_t), intent(inout), optional :: progress      !! Counts the loops

        type(loops_t) :: work
        type(case_t) :: own
        type(simulator_t) :: simulator
        type(observation_set_t) :: told

        call new_simulator(case, simulator, error)
        if (allocated(error)) return
        call tell_operator(simulator, case%operator, told)
        work%settings = settings
        work%knowledge = told%knowledge
        work%field_noise = case%satellite%magnetometer%noise
        work%number = case%label()
        own = case
        own%duration = settings%longest
        call lay_out_places(own, settings, work, error)
        if (.not. allocated(error)) &
            call begin_planning(work%knowledge, settings%plan_seconds, settings%amplitude, work%planner, error)
        if (allocated(error)) return
        allocate (work%loops(loops))
        call run_parallel(work, loops, threads, error, progress)
        call move_alloc(work%loops, results)
    end subroutine run_loops

    !> Field, orbit and forces at the places.
    subroutine lay_out_places(case, settings, work, error)
        type(case_t), intent(in) :: case
        type(loop_settings_t), intent(in) :: settings
        type(loops_t), intent(inout) :: work
        type(error_t), allocatable, intent(out) :: error

        type(planned_arc_t) :: arc
        type(nominal_orbit_t) :: orbit
        type(manoeuvre_site_t) :: site
        real(dp) :: mean_motion, angle
        integer :: i, j

        call new_planned_arc(case, arc, error)
        if (.not. allocated(error)) call new_nominal_orbit(case, orbit, error, interval=10.0_dp)
        if (allocated(error)) return
        work%steps = arc%samples
        allocate (work%places(settings%places))
        do i = 1, settings%places
            call new_manoeuvre_site(arc, orbit, (i - 1)*orbit%revolution/settings%places, site, error)
            if (allocated(error)) return
            associate (place => work%places(i), n => arc%samples)
                place%quaternion = site%state(ATTITUDE)
                place%rate = site%state(RATE)
                allocate (place%field(3, 0:2*n), place%position(3, 0:2*n), place%force(3, 0:n))
                mean_motion = norm2(site%state(VELOCITY))/norm2(site%state(POSITION))
                do j = 0, 2*n
                    angle = mean_motion*j*arc%interval/2
                    place%field(:, j) = matmul(site%field(:, j), rotation_matrix(held_attitude(place, j*arc%interval/2)))
                    place%position(:, j) = site%state(POSITION)*cos(angle) + site%state(VELOCITY)*(sin(angle)/mean_motion)
                end do
                place%force = site%force
                place%force_slope = site%force_slope
            end associate
        end do
    end subroutine lay_out_places

    !> The attitude without a manoeuvre.
    pure function held_attitude(place, time) result(q)
        type(place_t), intent(in) :: place
        real(dp), intent(in) :: time
        real(dp) :: q(4)

        q = turned_by(place%rate*time, place%quaternion)
    end function held_attitude

    !> One loop, from the first sample to its end.
    subroutine do_loop(self, i, error)
        class(loops_t), intent(inout) :: self
        integer, intent(in) :: i
        type(error_t), allocatable, intent(out) :: error

        type(next_seconds_t) :: planner
        type(live_estimate_t) :: live
        type(truth_t) :: truth
        type(live_sample_t) :: sample
        type(coloured_noise_t) :: noise(3)
        type(random_stream_t) :: others, stream(3)
        real(dp) :: moments(3, 0:2*self%steps), drawn(3, self%steps), guess(3), estimate(3), covariance(3, 3)
        integer :: k, axis, planned

        associate (loop => self%loops(i), h => self%knowledge%accelerometer_interval, &
                   place => self%places(1 + modulo(i - 1, size(self%places))))
            call draw_truth(self, i, place, truth)
            others = new_stream(self%settings%seed, self%number, 0, i, STREAM_OTHERS)
            do axis = 1, 3
                noise(axis) = coloured_noise(self%knowledge%accelerometer_noise(axis), h, error)
                if (allocated(error)) return
                stream(axis) = new_stream(self%settings%seed, self%number, 0, i, STREAM_ACCELEROMETER + axis - 1)
            end do
            call others%normals(guess)
            call begin_live_estimate(self%knowledge, turned_by(self%knowledge%star_camera_sigma*guess, truth%quaternion), &
                                     truth%rate + self%settings%rate_sigma*guess([2, 3, 1]), live, error)
            if (allocated(error)) return
            planner = self%planner
            moments = 0
            if (self%settings%fixed%count > 0) call dipole_moments(self%settings%fixed, h/2, moments)
            planned = nint(self%settings%plan_seconds/h)
            do k = 0, self%steps
                if (k > 0) call fly(self, place, moments(:, 2*k - 2:2*k), k, truth)
                if (mod(k, planned) == 0 .and. k < self%steps) then
                    do axis = 1, 3
                        call noise(axis)%generate(stream(axis), drawn(axis, k + 1:min(k + planned, self%steps)))
                    end do
                end if
                call observe(self, place, truth, k, drawn(:, max(1, k)), others, sample)
                if (k > 0) sample%moment = moments(:, 2*k - 2:2*k)
                call live%add(sample, error)
                if (allocated(error)) return
                call live%now(estimate, covariance)
                loop%sigma = [(sqrt(covariance(axis, axis)), axis=1, 3)]
                loop%stopped = maxval(loop%sigma) <= self%settings%wanted
                if (loop%stopped) exit
                if (mod(k, planned) == 0 .and. k < self%steps .and. self%settings%fixed%count == 0) &
                    call plan_ahead(planner, live, place, covariance, moments(:, 2*k:), loop)
            end do
            loop%time = live%time
            loop%edited = live%edited
            loop%error = estimate - truth%offset
            loop%square = dot_product(loop%error, matmul(inverse_3x3(covariance), loop%error))
        end associate
    end subroutine do_loop

    subroutine draw_truth(self, i, place, truth)
        class(loops_t), intent(in) :: self
        integer, intent(in) :: i
        type(place_t), intent(in) :: place
        type(truth_t), intent(out) :: truth

        type(random_stream_t) :: stream
        real(dp) :: x(3, 6)
        integer :: j

        stream = new_stream(self%settings%seed, self%number, 0, i, STREAM_TRUTH)
        do j = 1, size(x, 2)
            call stream%normals(x(:, j))
        end do
        truth%quaternion = place%quaternion
        truth%rate = place%rate
        truth%offset = self%settings%offset_sigma*x(:, 1)
        truth%torque = self%settings%torque_sigma*x(:, 2)
        truth%bias = self%settings%bias_sigma*x(:, 3)
        truth%drift = self%settings%drift_sigma*x(:, 4)
        truth%scale = self%knowledge%a_priori%aged_scale_sigmas()*x(:, 5)
        truth%field_bias = self%knowledge%a_priori%sigma_magnetometer_bias*x(:, 6)
    end subroutine draw_truth

    !> The rotation over interval k by the classical method of Runge and Kutta.
    pure subroutine fly(self, place, moment, k, truth)
        class(loops_t), intent(in) :: self
        type(place_t), intent(in) :: place
        real(dp), intent(in) :: moment(3, 0:2)      ! at beginning, middle and end
        integer, intent(in) :: k
        type(truth_t), intent(inout) :: truth

        real(dp) :: y(7), s(7, 4), inverse_inertia(3, 3)

        inverse_inertia = inverse_3x3(self%knowledge%inertia)
        associate (h => self%knowledge%accelerometer_interval)
            y = [truth%quaternion, truth%rate]
            s(:, 1) = slope(0, y)
            s(:, 2) = slope(1, y + h/2*s(:, 1))
            s(:, 3) = slope(1, y + h/2*s(:, 2))
            s(:, 4) = slope(2, y + h*s(:, 3))
            y = y + h/6*(s(:, 1) + 2*s(:, 2) + 2*s(:, 3) + s(:, 4))
        end associate
        truth%quaternion = normalised(y(:4))
        truth%rate = y(5:)
        y(:4) = truth%quaternion
        s(:, 1) = slope(2, y)
        truth%omega_dot = s(5:, 1)

    contains

        pure function slope(half, y) result(dydt)
            integer, intent(in) :: half
            real(dp), intent(in) :: y(7)
            real(dp) :: dydt(7)

            real(dp) :: body(3, 3), torque(3)

            body = rotation_matrix(normalised(y(:4)))
            associate (position => place%position(:, 2*k - 2 + half), j => self%knowledge%inertia)
                torque = cross(moment(:, half), matmul(body, place%field(:, 2*k - 2 + half))) + truth%torque + &
                         gravity_gradient_torque(EARTH_GM, norm2(position), matmul(body, unit(position)), j)
                dydt(:4) = quaternion_rate(y(:4), y(5:))
                dydt(5:) = matmul(inverse_inertia, torque - cross(y(5:), matmul(j, y(5:))))
            end associate
        end function slope
    end subroutine fly

    !> What the instruments show at epoch k, (3-7), (3-23).
    subroutine observe(self, place, truth, k, noise, others, sample)
        class(loops_t), intent(in) :: self
        type(place_t), intent(in) :: place
        type(truth_t), intent(in) :: truth
        integer, intent(in) :: k
        real(dp), intent(in) :: noise(3)                ! of the accelerometer, m/s^2
        type(random_stream_t), intent(inout) :: others
        type(live_sample_t), intent(out) :: sample

        real(dp) :: body(3, 3), force(3), turn(3), draws(3)
        integer :: axis, head

        associate (knowledge => self%knowledge, position => place%position(:, 2*k), mounting => self%knowledge%mounting)
            sample%time = k*knowledge%accelerometer_interval
            sample%position = position
            body = rotation_matrix(truth%quaternion)
            sample%has_acceleration = k > 0             ! nothing is known of d omega/dt before
            force = truth%bias + truth%drift*sample%time
            if (self%settings%real_forces) then
                turn = turn_between(held_attitude(place, sample%time), truth%quaternion)
                force = force + place%force(:, k)
                do axis = 1, 3
                    force = force + place%force_slope(:, axis, merge(1, 2, turn(axis) > 0))*turn(axis)
                end do
            end if
            sample%acceleration = (1 + truth%scale)*(force + matmul( &
                offset_matrix(truth%rate, truth%omega_dot) + &
                gravity_gradient_matrix(EARTH_GM/norm2(position)**3, matmul(body, unit(position))), truth%offset)) + noise
            if (mod(k, max(1, nint(knowledge%magnetometer_interval/knowledge%accelerometer_interval))) == 0) then
                sample%has_field = .true.
                call others%normals(draws)
                sample%field = matmul(body, place%field(:, 2*k)) + truth%field_bias + self%field_noise*draws
            end if
            if (mod(k, max(1, nint(knowledge%star_camera_interval/knowledge%accelerometer_interval))) /= 0) return
            head = max(1, knowledge%camera)
            sample%has_attitude(head) = .true.
            sample%attitude_time(head) = sample%time
            call others%normals(draws)
            sample%quaternion(:, head) = turned_by(knowledge%star_camera_sigma*draws, &
                                                   quaternion_product(mounting(:, head), truth%quaternion))
        end associate
    end subroutine observe

    !> Puts the plan for the next seconds into the moments.
    subroutine plan_ahead(planner, live, place, covariance, moments, loop)
        type(next_seconds_t), intent(inout) :: planner
        type(live_estimate_t), intent(in) :: live
        type(place_t), intent(in) :: place
        real(dp), intent(in) :: covariance(3, 3)
        real(dp), intent(inout) :: moments(:, 0:)       ! from now on, every half interval
        type(loop_t), intent(inout) :: loop

        type(torque_rods_t) :: rods
        real(dp) :: expected(3), rate_of_turn(3)

        rate_of_turn = live%state%value(RATE_PLACES)
        call planner%plan(covariance, live%field_at(live%time), turn_between(held_attitude(place, live%time), &
                                                                             live%state%quaternion), &
                          rate_of_turn, place%rate, rods, expected)
        call dipole_moments(rods, live%model%interval/2, moments)
        loop%plans = loop%plans + 1
        if (rods%count == 0) loop%resting = loop%resting + 1
    end subroutine plan_ahead

    !> Of loops that stopped. Fails when none did.
    subroutine statistics_of_loops(loops, statistics, error)
        type(loop_t), intent(in) :: loops(:)
        type(loop_statistics_t), intent(out) :: statistics
        type(error_t), allocatable, intent(out) :: error

        integer :: axis, n

        n = count(loops%stopped)
        statistics%loops = size(loops)
        statistics%stopped = n
        if (n < 2) then
            call fail(error, 'closed loops: none of them reached the standard deviation that is wanted')
            return
        end if
        statistics%square = sum(loops%square, loops%stopped)/n
        statistics%square_error = sqrt(sum((loops%square - statistics%square)**2, loops%stopped)/(n - 1)/n)
        statistics%bias = [(sum(loops%error(axis)/loops%sigma(axis), loops%stopped)/n, axis=1, 3)]
        statistics%time = sum(loops%time, loops%stopped)/n
        statistics%earliest = minval(loops%time, loops%stopped)
        statistics%latest = maxval(loops%time, loops%stopped)
        statistics%plans = sum(real(loops%plans, dp))/size(loops)
        statistics%edited = sum(loops%edited)
        statistics%resting = sum(loops%resting)
    end subroutine statistics_of_loops
end module gracecg_studies_closed_loop
