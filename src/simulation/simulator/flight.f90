!> The truth of a case on its way: one flight of it, whole or piece by piece, and what its instruments have before them.
module gracecg_simulation_flight
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM
    use gracecg_base_error, only: error_t, fail, add_context, number_text
    use gracecg_base_quaternion, only: quaternion_of_matrix
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_base_text, only: integer_text
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_spacecraft_torque_rods, only: check_rod_sampling, rod_moments, moves_rods
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, STATE_SIZE, POSITION, OMEGA, ATTITUDE
    use gracecg_simulation_arc, only: truth_arc_t, begin_arc, continue_arc
    use gracecg_simulation_accelerometer, only: pmc_acceleration, pmc_acceleration_t
    use gracecg_simulation_star_catalogue, only: star_catalogue_t
    use gracecg_simulation_star_camera, only: star_frame_t
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_simulation_case, only: case_t, find_earth_parameters, flies_under_control
    use gracecg_simulation_case_models, only: build_dynamics, initial_state, case_star_catalogue
    use gracecg_simulation_limits, only: attitude_motion_t, follow_motion, check_motion
    implicit none
    private
    public :: simulator_t, new_simulator, flight_t, begin_flight, propagate_case, disturbance_at, samples_of, attitude_at

    !> All of a case that is the same in every run.
    type :: simulator_t
        type(case_t) :: case                    !! What is simulated
        type(truth_arc_t) :: arc                            !! The truth, propagated once; or a piece of it
        type(star_frame_t), allocatable :: frames(:, :)     !! (star-camera epochs of the arc, heads)
        real(dp), allocatable :: rod_moments(:, :)
        !! (3, 0:steps), along the rods, A m^2, as far as the arc has got; where the attitude is controlled
        real(dp) :: star_camera_sigma(3) = 0
        !! Mean noise of the used head's quaternions, about camera x, y and boresight, rad
        integer :: accelerometer_stride, star_camera_stride, magnetometer_stride
        !! Sampling intervals in intervals of the arc
        real(dp) :: start(STATE_SIZE) = 0                   !! The state at the epoch
    end type simulator_t

    !> The truth of a case on its way: what propagates it, and what is known of it so far.
    type :: flight_t
        private
        type(satellite_dynamics_t) :: dynamics
        type(star_catalogue_t) :: catalogue
        type(attitude_motion_t) :: motion       ! of the manoeuvre, for its limits
        type(random_stream_t) :: any_stream     ! for the noise that an operator expects
        real(dp) :: star_variance(3) = 0        ! sum over the used head's frames, rad^2
    contains
        procedure :: go_on                      !! The next epochs
    end type flight_t

contains

    !> Propagates the truth of a case and finds the stars of every frame. Fails when the accelerometer's
    !> samples cannot follow the manoeuvre, and when that goes beyond its limits.
    subroutine new_simulator(case, simulator, error)
        type(case_t), intent(in) :: case
        type(simulator_t), intent(out) :: simulator
        type(error_t), allocatable, intent(out) :: error

        type(flight_t) :: flight

        call begin_flight(case, flight, simulator, error)
        if (.not. allocated(error)) call flight%go_on(simulator%arc%steps, simulator, error)
    end subroutine new_simulator

    !> The first epoch of a flight. Fails as `new_simulator`.
    subroutine begin_flight(case, flight, simulator, error)
        type(case_t), intent(in) :: case
        type(flight_t), intent(out) :: flight
        type(simulator_t), intent(out) :: simulator     !! Holds the epoch
        type(error_t), allocatable, intent(out) :: error

        simulator%case = case
        call check_rod_sampling(case%satellite%rods, case%satellite%accelerometer%sampling_interval, error)
        call add_context(error, 'case '//trim(case%name))
        if (allocated(error)) return
        associate (satellite => case%satellite)
            call find_stride(case, 'accelerometer', satellite%accelerometer%sampling_interval, &
                             simulator%accelerometer_stride, error)
            call find_stride(case, 'star camera', satellite%star_camera%sampling_interval, simulator%star_camera_stride, error)
            call find_stride(case, 'magnetometer', satellite%magnetometer%sampling_interval, &
                             simulator%magnetometer_stride, error)
        end associate
        if (allocated(error)) return
        call find_earth_parameters(case, simulator%case%earth_parameters, error)
        if (allocated(error)) return
        call begin_case(case, flight%dynamics, simulator%arc, error)
        if (allocated(error)) return
        simulator%start = simulator%arc%state(:, 0)
        associate (drag => simulator%case%operator%a_priori%drag, load => simulator%arc%loads(0))
            if (drag <= 0) drag = norm2(load%drag + load%srp + load%erp)
        end associate
        if (case%control%acts) allocate (simulator%rod_moments(3, 0:simulator%arc%steps), source=0.0_dp)
        call case_star_catalogue(case, flight%catalogue, error)
        flight%any_stream = new_stream(0, 0, 0, 0, 0)
    end subroutine begin_flight

    !> The next epochs of a flight, which the simulator then holds with what is seen at them. Fails as `new_simulator`;
    !> the limits are looked at when the arc is at its end.
    subroutine go_on(self, epochs, simulator, error)
        class(flight_t), intent(inout) :: self
        integer, intent(in) :: epochs                   !! How many; fewer at the end of the arc
        type(simulator_t), intent(inout) :: simulator   !! Of `begin_flight`
        type(error_t), allocatable, intent(out) :: error

        associate (case => simulator%case, arc => simulator%arc)
            call continue_arc(self%dynamics, epochs, arc, error)
            if (.not. allocated(error) .and. case%control%acts) then
                call follow_control(self, simulator)
            else if (.not. allocated(error) .and. moves_rods(case%satellite%rods, case%duration)) then
                call follow_motion(arc%interval, simulator%start(OMEGA), simulator%start(ATTITUDE), arc%first, &
                                   arc%state(OMEGA, :), arc%state(ATTITUDE, :), self%motion)
            end if
            if (.not. allocated(error) .and. arc%last == arc%steps) call check_motion(case%limits, self%motion, error)
            call add_context(error, 'case '//trim(case%name))
        end associate
        if (.not. allocated(error)) call find_stars(self, simulator, error)
    end subroutine go_on

    !> What the rods did at the epochs that the simulator holds, and the motion away from the attitude that is held.
    subroutine follow_control(flight, simulator)
        type(flight_t), intent(inout) :: flight
        type(simulator_t), intent(inout) :: simulator

        real(dp), allocatable :: turned(:, :)
        integer :: k

        associate (arc => simulator%arc)
            allocate (turned(4, arc%first:arc%last))
            do k = arc%first, arc%last
                simulator%rod_moments(:, k) = rod_moments(simulator%case%satellite%rods, k*arc%interval) + &
                                              arc%loads(k)%control_moment
                turned(:, k) = quaternion_of_matrix(flight%dynamics%control%turn(arc%state(:, k)))
            end do
            call follow_motion(arc%interval, [0.0_dp, 0.0_dp, 0.0_dp], [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], arc%first, &
                               arc%state(OMEGA, :), turned, flight%motion)
        end associate
    end subroutine follow_control

    !> Propagates the true arc of a case.
    subroutine propagate_case(case, arc, error)
        type(case_t), intent(in) :: case
        type(truth_arc_t), intent(out) :: arc
        type(error_t), allocatable, intent(out) :: error

        type(satellite_dynamics_t) :: dynamics

        call begin_case(case, dynamics, arc, error)
        if (allocated(error)) return
        call continue_arc(dynamics, arc%steps, arc, error)
        call add_context(error, 'case '//trim(case%name))
    end subroutine propagate_case

    !> The first epoch of a case's arc, and its dynamics.
    subroutine begin_case(case, dynamics, arc, error)
        type(case_t), intent(in) :: case
        type(satellite_dynamics_t), intent(out) :: dynamics
        type(truth_arc_t), intent(out) :: arc
        type(error_t), allocatable, intent(out) :: error

        real(dp), allocatable :: tolerance      ! absent: no step control

        call build_dynamics(case, dynamics, error)
        if (allocated(error)) return
        if (flies_under_control(case)) allocate (tolerance, source=case%tolerance)
        call begin_arc(dynamics, initial_state(case), case%interval, nint(case%duration/case%interval), arc, error, tolerance)
        call add_context(error, 'case '//trim(case%name))
    end subroutine begin_case

    !> An instrument's sampling interval in intervals of the arc. Fails when it is no multiple of these.
    subroutine find_stride(case, name, sampling, steps, error)
        type(case_t), intent(in) :: case
        character(*), intent(in) :: name        !! Of the instrument
        real(dp), intent(in) :: sampling        !! s
        integer, intent(out) :: steps
        type(error_t), allocatable, intent(inout) :: error

        steps = nint(sampling/case%interval)
        if (allocated(error)) return
        if (steps < 1 .or. abs(steps*case%interval - sampling) > 1e-9_dp*sampling) &
            call fail(error, 'case '//trim(case%name)//', '//name//': the interval '//number_text(sampling)// &
                      ' s is not a multiple of the arc''s interval '//number_text(case%interval)//' s')
    end subroutine find_stride

    !> The stars of every frame, and the noise that an operator would expect of the used head, from QUEST's covariance
    !> (3-21), which is that of half the angles: the mean so far.
    subroutine find_stars(flight, simulator, error)
        type(flight_t), intent(inout) :: flight
        type(simulator_t), intent(inout) :: simulator
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: q(4), covariance(3, 3)
        integer :: first, last, i, head, axis

        call samples_of(simulator%arc, simulator%star_camera_stride, first, last)
        if (allocated(simulator%frames)) deallocate (simulator%frames)
        allocate (simulator%frames(first:last, HEADS))
        do head = 1, HEADS
            do i = first, last
                call simulator%case%satellite%star_camera%see(flight%catalogue, attitude_at(simulator, i), head, &
                                                              simulator%frames(i, head), error)
                if (.not. allocated(error)) cycle
                call add_context(error, 'case '//trim(simulator%case%name)//', head '//integer_text(head)//' at '// &
                                 number_text(i*simulator%star_camera_stride*simulator%arc%interval)//' s')
                return
            end do
        end do
        do i = first, last
            call simulator%frames(i, simulator%case%operator%head)%draw(flight%any_stream, q, covariance, error)
            if (allocated(error)) return
            flight%star_variance = flight%star_variance + [(4*covariance(axis, axis), axis=1, 3)]
        end do
        if (last > 0) simulator%star_camera_sigma = sqrt(flight%star_variance/last)
    end subroutine find_stars

    !> The numbers of an instrument's samples that the arc holds: sample i is taken at epoch i*stride, none at epoch 0.
    pure subroutine samples_of(arc, stride, first, last)
        type(truth_arc_t), intent(in) :: arc
        integer, intent(in) :: stride           !! In intervals of the arc
        integer, intent(out) :: first, last     !! None, when last is less

        first = arc%first/stride + 1
        last = arc%last/stride
    end subroutine samples_of

    !> True attitude at star-camera epoch i, of unit length.
    pure function attitude_at(simulator, i) result(q)
        type(simulator_t), intent(in) :: simulator
        integer, intent(in) :: i        !! From 1
        real(dp) :: q(4)                !! Inertial to body, scalar last

        q = simulator%arc%state(ATTITUDE, i*simulator%star_camera_stride)
        q = q/norm2(q)
    end function attitude_at

    !> The parts of the acceleration at the proof-mass centre at epoch k. Drag, part of the non-gravitational
    !> acceleration (3-5), is proportional to the density, model times (scale + wave).
    pure function disturbance_at(case, arc, wave, k, place) result(acceleration)
        type(case_t), intent(in) :: case
        type(truth_arc_t), intent(in) :: arc
        type(density_wave_t), intent(in) :: wave    !! On top of what the arc already has
        integer, intent(in) :: k                    !! Number of the epoch, from 0
        real(dp), intent(in), optional :: place(3)  !! Of one of several accelerometers, from their middle, body axes, m
        type(pmc_acceleration_t) :: acceleration

        real(dp) :: force(3)        ! by the mass, body axes, m/s^2
        real(dp) :: offset(3)

        associate (acting => arc%loads(k))
            force = acting%drag + acting%srp + acting%erp
            if (case%density_scale > 0) &
                force = force + acting%drag*wave%relative_change(k*arc%interval)/case%density_scale
            offset = case%satellite%offset
            if (present(place)) offset = offset + place
            acceleration = pmc_acceleration(arc%state(OMEGA, k), arc%omega_dot(:, k), offset, &
                                            acting%vertical, EARTH_GM, norm2(arc%state(POSITION, k)), force)
        end associate
    end function disturbance_at
end module gracecg_simulation_flight
