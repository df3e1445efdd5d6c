!> From a case to an observation set: the true arc once, the instruments' noise for every run.
module gracecg_simulation_simulator
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: EARTH_GM, TWO_PI
    use gracecg_base_error, only: error_t, fail, add_context, number_text
    use gracecg_base_text, only: integer_text
    use gracecg_base_quaternion, only: quaternion_product
    use gracecg_environment_time, only: time_tag
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_simulation_dynamics, only: satellite_dynamics_t, POSITION, VELOCITY, OMEGA, ATTITUDE
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series, FEWEST_MOMENTS
    use gracecg_spacecraft_torque_rods, only: check_rod_sampling, rod_moments, take_measured_moments
    use gracecg_simulation_arc, only: truth_arc_t, propagate_arc
    use gracecg_simulation_accelerometer, only: pmc_acceleration, pmc_acceleration_t
    use gracecg_simulation_star_catalogue, only: star_catalogue_t
    use gracecg_simulation_star_camera, only: star_frame_t
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_simulation_case, only: case_t, find_earth_parameters
    use gracecg_simulation_case_models, only: build_dynamics, initial_state, case_star_catalogue
    use gracecg_simulation_operator_errors, only: operator_t, drawn_operator, errors_of, STAR_CAMERA_NOISE
    use gracecg_simulation_operator_view, only: operator_knowledge, believed_position
    use gracecg_simulation_limits, only: check_manoeuvre_limits
    implicit none
    private
    public :: simulator_t, new_simulator, observe, observe_without_noise, drawn_wave
    public :: lose_magnetometer, measure_rods, tell_operator, operator_of_run
    public :: propagate_case, disturbance_at

    !> Streams of random numbers of one run
    integer, parameter :: STREAM_ACCELEROMETER = 1, STREAM_MAGNETOMETER = 2, STREAM_DENSITY = 3
    integer, parameter :: STREAM_STAR_CAMERA = 4    !! Head 1; head 2 follows

    real(dp), parameter :: ORBIT_INTERVAL = 1       !! Of the positions in an observation set, s

    !> All of a case that is the same in every run.
    type :: simulator_t
        type(case_t) :: case                    !! What is simulated
        type(truth_arc_t) :: arc                            !! The truth, propagated once
        type(star_frame_t), allocatable :: frames(:, :)     !! (star-camera epochs, heads)
        real(dp) :: star_camera_sigma(3) = 0
        !! Mean noise of the used head's quaternions, about camera x, y and boresight, rad
        integer, private :: accelerometer_stride, star_camera_stride, magnetometer_stride
        !! Sampling intervals in intervals of the arc
    end type simulator_t

    !> One noisy observation set, with a seed of 32 or 64 bits
    interface observe
        module procedure observe_i4, observe_i8
    end interface observe

contains

    !> Propagates the truth of a case and finds the stars of every frame. Fails when the accelerometer's
    !> samples cannot follow the manoeuvre, and when that goes beyond its limits.
    subroutine new_simulator(case, simulator, error)
        type(case_t), intent(in) :: case
        type(simulator_t), intent(out) :: simulator
        type(error_t), allocatable, intent(out) :: error

        simulator%case = case
        call check_rod_sampling(case%satellite%rods, case%satellite%accelerometer%sampling_interval, error)
        call add_context(error, 'case '//trim(case%name))
        if (allocated(error)) return
        call find_strides(simulator, error)
        if (allocated(error)) return
        call find_earth_parameters(case, simulator%case%earth_parameters, error)
        if (allocated(error)) return
        call propagate_case(case, simulator%arc, error)
        if (allocated(error)) return
        call check_manoeuvre_limits(case, simulator%arc, error)
        call add_context(error, 'case '//trim(case%name))
        if (allocated(error)) return
        call find_stars(simulator, error)
    end subroutine new_simulator

    !> Propagates the true arc of a case.
    subroutine propagate_case(case, arc, error)
        type(case_t), intent(in) :: case
        type(truth_arc_t), intent(out) :: arc
        type(error_t), allocatable, intent(out) :: error

        type(satellite_dynamics_t) :: dynamics
        integer :: steps

        call build_dynamics(case, dynamics, error)
        if (allocated(error)) return
        steps = nint(case%duration/case%interval)
        if (case%integrator == 'adaptive') then
            call propagate_arc(dynamics, initial_state(case), case%interval, steps, arc, error, &
                               case%tolerance)
        else
            call propagate_arc(dynamics, initial_state(case), case%interval, steps, arc, error, &
                               runge_kutta=case%integrator == 'rkf78')
        end if
        call add_context(error, 'case '//trim(case%name))
    end subroutine propagate_case

    subroutine find_strides(simulator, error)
        type(simulator_t), intent(inout) :: simulator
        type(error_t), allocatable, intent(out) :: error

        associate (case => simulator%case)
            call stride('accelerometer', case%satellite%accelerometer%sampling_interval, &
                        simulator%accelerometer_stride)
            call stride('star camera', case%satellite%star_camera%sampling_interval, simulator%star_camera_stride)
            call stride('magnetometer', case%satellite%magnetometer%sampling_interval, simulator%magnetometer_stride)
        end associate

    contains

        subroutine stride(name, sampling, steps)
            character(*), intent(in) :: name
            real(dp), intent(in) :: sampling
            integer, intent(out) :: steps

            associate (interval => simulator%case%interval)
                steps = nint(sampling/interval)
                if (allocated(error)) return
                if (steps < 1 .or. abs(steps*interval - sampling) > 1e-9_dp*sampling) then
                    call fail(error, 'case '//trim(simulator%case%name)//', '//name//': the interval '// &
                              number_text(sampling)//' s is not a multiple of the arc''s interval '// &
                              number_text(interval)//' s')
                end if
            end associate
        end subroutine stride
    end subroutine find_strides

    subroutine find_stars(simulator, error)
        type(simulator_t), intent(inout) :: simulator
        type(error_t), allocatable, intent(out) :: error

        type(star_catalogue_t) :: catalogue
        integer :: n, i, head

        call case_star_catalogue(simulator%case, catalogue, error)
        if (allocated(error)) return
        n = simulator%arc%steps/simulator%star_camera_stride
        allocate (simulator%frames(n, HEADS))
        do head = 1, HEADS
            do i = 1, n
                call simulator%case%satellite%star_camera%see(catalogue, attitude_at(simulator, i), head, &
                                                    simulator%frames(i, head), error)
                if (allocated(error)) then
                    call add_context(error, 'case '//trim(simulator%case%name)//', head '// &
                                     integer_text(head)//' at '//number_text( &
                                     i*simulator%star_camera_stride*simulator%arc%interval)//' s')
                    return
                end if
            end do
        end do
        call find_star_noise(simulator, error)
    end subroutine find_stars

    !> The noise that an operator would expect of the used head, from QUEST's covariance (3-21), which
    !> is that of half the angles.
    subroutine find_star_noise(simulator, error)
        type(simulator_t), intent(inout) :: simulator
        type(error_t), allocatable, intent(out) :: error

        type(random_stream_t) :: any_stream
        real(dp) :: q(4), covariance(3, 3), variance(3)
        integer :: i, axis

        any_stream = new_stream(0, 0, 0, 0, 0)
        variance = 0
        do i = 1, size(simulator%frames, 1)
            call simulator%frames(i, simulator%case%operator%head)%draw(any_stream, q, covariance, error)
            if (allocated(error)) return
            variance = variance + [(4*covariance(axis, axis), axis=1, 3)]
        end do
        simulator%star_camera_sigma = sqrt(variance/size(simulator%frames, 1))
    end subroutine find_star_noise

    !> True attitude at star-camera epoch i, of unit length.
    pure function attitude_at(simulator, i) result(q)
        type(simulator_t), intent(in) :: simulator
        integer, intent(in) :: i
        real(dp) :: q(4)

        q = simulator%arc%state(ATTITUDE, i*simulator%star_camera_stride)
        q = q/norm2(q)
    end function attitude_at

    !> The parts of the acceleration at the proof-mass centre at epoch k, with the density wave.
    pure function disturbance_at(case, arc, wave, k) result(acceleration)
        type(case_t), intent(in) :: case
        type(truth_arc_t), intent(in) :: arc
        type(density_wave_t), intent(in) :: wave    !! On top of what the arc already has
        integer, intent(in) :: k                    !! Number of the epoch, from 0
        type(pmc_acceleration_t) :: acceleration

        acceleration = pmc_acceleration(arc%state(OMEGA, k), arc%omega_dot(:, k), case%satellite%offset, &
                                        arc%loads(k)%vertical, EARTH_GM, norm2(arc%state(POSITION, k)), &
                                        non_gravitational(case, arc, wave, k))
    end function disturbance_at

    !> Non-gravitational acceleration of the centre of mass at epoch k, body axes (3-5), m/s^2. Drag is
    !> proportional to the density, model times (scale + wave).
    pure function non_gravitational(case, arc, wave, k) result(acceleration)
        type(case_t), intent(in) :: case
        type(truth_arc_t), intent(in) :: arc
        type(density_wave_t), intent(in) :: wave    !! On top of what the arc already has
        integer, intent(in) :: k
        real(dp) :: acceleration(3)

        associate (acting => arc%loads(k))
            acceleration = acting%drag + acting%srp + acting%erp
            if (case%density_scale > 0) then
                acceleration = acceleration + &
                               acting%drag*wave%relative_change(k*arc%interval)/case%density_scale
            end if
        end associate
    end function non_gravitational

    !> The density wave of a run: its phase drawn when the case says so, none when the arc has it.
    function drawn_wave(self, seed, run) result(wave)
        type(simulator_t), intent(in) :: self
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: run    !! Names them, too
        type(density_wave_t) :: wave

        type(random_stream_t) :: stream

        if (.not. self%case%density_wave_random) return
        wave = self%case%density_wave
        stream = run_stream(self, seed, run, STREAM_DENSITY)
        wave%phase = TWO_PI*stream%uniform()
    end function drawn_wave

    !> One noisy observation set. The same seed and run give the same numbers, whatever else is done; what the
    !> operator's errors have a standard deviation of is drawn, too.
    subroutine observe_i8(self, seed, run, observations, error, only_used_head)
        type(simulator_t), intent(in) :: self
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: run    !! Names them, too
        type(observation_set_t), intent(out) :: observations
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: only_used_head     !! Leave out the other star-camera head

        type(random_stream_t) :: stream
        real(dp), allocatable :: true_values(:, :)

        call lay_out(self, operator_of_run(self%case, self%case%operator, seed, run), observations, &
                     only_used_head)
        true_values = true_accelerations(self, drawn_wave(self, seed, run))
        stream = run_stream(self, seed, run, STREAM_ACCELEROMETER)
        call self%case%satellite%accelerometer%measure(true_values, stream, observations%acceleration, error)
        if (allocated(error)) return
        true_values = true_field(self)
        stream = run_stream(self, seed, run, STREAM_MAGNETOMETER)
        call self%case%satellite%magnetometer%measure(true_values, stream, observations%field, error)
        if (allocated(error)) return
        call draw_stars(self, seed, run, observations, error)
    end subroutine observe_i8

    !> The same with a seed of 32 bits.
    subroutine observe_i4(self, seed, run, observations, error, only_used_head)
        type(simulator_t), intent(in) :: self
        integer, intent(in) :: seed, run
        type(observation_set_t), intent(out) :: observations
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: only_used_head

        call observe_i8(self, int(seed, i8), run, observations, error, only_used_head)
    end subroutine observe_i4

    !> An observation set without random errors, with the systematic ones: scale factors and biases.
    subroutine observe_without_noise(self, wave, observations)
        type(simulator_t), intent(in) :: self
        type(density_wave_t), intent(in) :: wave    !! The density wave to apply
        type(observation_set_t), intent(out) :: observations

        integer :: i

        call lay_out(self, self%case%operator, observations, .true.)
        observations%acceleration = true_accelerations(self, wave)
        associate (satellite => self%case%satellite)
            do i = 1, size(observations%acceleration, 2)
                observations%acceleration(:, i) = satellite%accelerometer%digitised( &
                                                  satellite%accelerometer%response(observations%acceleration(:, i)))
            end do
            observations%field = true_field(self)
            do i = 1, size(observations%field, 2)
                observations%field(:, i) = satellite%magnetometer%response(observations%field(:, i))
            end do
        end associate
        do i = 1, size(observations%quaternion, 2)
            observations%quaternion(:, i) = quaternion_product( &
                self%case%satellite%star_camera%mounting(observations%star_camera_head(i)), attitude_at(self, i))
        end do
    end subroutine observe_without_noise

    !> The magnetometer fails at a time: its samples from then on are gone.
    pure subroutine lose_magnetometer(observations, from_time)
        type(observation_set_t), intent(inout) :: observations
        real(dp), intent(in) :: from_time           !! s; 0: all samples are lost

        integer :: kept

        kept = count(observations%magnetometer_time < from_time)
        observations%magnetometer_time = observations%magnetometer_time(:kept)
        observations%field = observations%field(:, :kept)
    end subroutine lose_magnetometer

    !> Tells the operator what the rods truly did, in place of what they were commanded to: their moments at
    !> equal intervals. Fails when the intervals are too few.
    subroutine measure_rods(self, interval, observations, error)
        type(simulator_t), intent(in) :: self
        real(dp), intent(in) :: interval        !! s, shortened so that the last sample is at the end of the arc
        type(observation_set_t), intent(inout) :: observations
        type(error_t), allocatable, intent(out) :: error

        type(moment_series_t) :: measured
        real(dp), allocatable :: time(:), moment(:, :)
        integer :: n, i

        n = ceiling(self%case%duration/interval*(1 - 1e-9_dp))
        if (n + 1 < FEWEST_MOMENTS) then
            call fail(error, 'an interval of '//number_text(interval)//' s gives only '//integer_text(n + 1)// &
                      ' moments of the torque rods in '//number_text(self%case%duration)//' s; at least '// &
                      integer_text(FEWEST_MOMENTS)//' are needed')
            return
        end if
        allocate (moment(3, 0:n))
        time = [(i*self%case%duration/n, i=0, n)]
        do i = 0, n
            moment(:, i) = rod_moments(self%case%satellite%rods, time(i + 1))
        end do
        call new_moment_series(measured, time, moment, error)
        if (.not. allocated(error)) call take_measured_moments(measured, observations%knowledge%rods)
    end subroutine measure_rods

    !> Epochs, heads and the operator's knowledge; no values yet.
    subroutine lay_out(self, operator, observations, only_used_head)
        type(simulator_t), intent(in) :: self
        type(operator_t), intent(in) :: operator    !! Of the run
        type(observation_set_t), intent(inout) :: observations
        logical, intent(in), optional :: only_used_head

        integer :: n, i, head
        logical :: one_head

        one_head = .false.
        if (present(only_used_head)) one_head = only_used_head
        observations%accelerometer_time = epochs(self, self%accelerometer_stride)
        observations%magnetometer_time = epochs(self, self%magnetometer_stride)
        allocate (observations%acceleration(3, size(observations%accelerometer_time)))
        allocate (observations%field(3, size(observations%magnetometer_time)))
        n = size(self%frames, 1)
        if (one_head) then
            observations%star_camera_time = epochs(self, self%star_camera_stride)
            observations%star_camera_head = [(self%case%operator%head, i=1, n)]
        else
            observations%star_camera_time = [((time_tag(i*self%star_camera_stride, self%arc%interval), &
                                               head=1, HEADS), i=1, n)]
            observations%star_camera_head = [((head, head=1, HEADS), i=1, n)]
        end if
        allocate (observations%quaternion(4, size(observations%star_camera_time)))
        call tell_operator(self, operator, observations)
    end subroutine lay_out

    !> Puts what an operator knows into an observation set: side knowledge and the orbit. Samples stay.
    subroutine tell_operator(self, operator, observations)
        type(simulator_t), intent(in) :: self
        type(operator_t), intent(in) :: operator    !! The case's own, or that of a run
        type(observation_set_t), intent(inout) :: observations

        observations%knowledge = operator_knowledge(self%case, operator)
        observations%knowledge%star_camera_sigma = self%star_camera_sigma*errors_of(operator, STAR_CAMERA_NOISE)
        call lay_out_orbit(self, operator, observations)
    end subroutine tell_operator

    !> The operator of a run: what has a standard deviation is drawn.
    function operator_of_run(case, operator, seed, run) result(drawn)
        type(case_t), intent(in) :: case
        type(operator_t), intent(in) :: operator    !! The case's own, or another one
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: run    !! Names them, too
        type(operator_t) :: drawn

        drawn = drawn_operator(operator, seed, case%number, merge(1, 2, case%satellite%name == 'front'), run)
    end function operator_of_run

    !> The orbit as GPS gives it: positions every second and at the end of the arc, true but for the operator's
    !> errors.
    subroutine lay_out_orbit(self, operator, observations)
        type(simulator_t), intent(in) :: self
        type(operator_t), intent(in) :: operator
        type(observation_set_t), intent(inout) :: observations

        integer, allocatable :: epoch(:)
        real(dp), allocatable :: position_told(:, :)
        integer :: stride, i

        stride = max(1, nint(ORBIT_INTERVAL/self%arc%interval))
        epoch = [(min(i*stride, self%arc%steps), i=0, (self%arc%steps + stride - 1)/stride)]
        observations%orbit_time = time_tag(epoch, self%arc%interval)
        allocate (position_told(3, size(epoch)))
        do i = 1, size(epoch)
            position_told(:, i) = believed_position(operator, self%arc%state([POSITION, VELOCITY], 0), &
                                                    self%arc%state([POSITION, VELOCITY], epoch(i)), &
                                                    observations%orbit_time(i))
        end do
        call move_alloc(position_told, observations%orbit_position)
    end subroutine lay_out_orbit

    pure function epochs(self, stride) result(times)
        type(simulator_t), intent(in) :: self
        integer, intent(in) :: stride
        real(dp), allocatable :: times(:)   !! s

        integer :: i

        times = [(time_tag(i*stride, self%arc%interval), i=1, self%arc%steps/stride)]
    end function epochs

    pure function true_accelerations(self, wave) result(values)
        type(simulator_t), intent(in) :: self
        type(density_wave_t), intent(in) :: wave
        real(dp), allocatable :: values(:, :)       !! (3, samples), m/s^2

        type(pmc_acceleration_t) :: acceleration
        integer :: i

        allocate (values(3, self%arc%steps/self%accelerometer_stride))
        do i = 1, size(values, 2)
            acceleration = disturbance_at(self%case, self%arc, wave, i*self%accelerometer_stride)
            values(:, i) = acceleration%total
        end do
    end function true_accelerations

    !> The field that the magnetometer feels, behind its filter if it has one.
    pure function true_field(self) result(values)
        type(simulator_t), intent(in) :: self
        real(dp), allocatable :: values(:, :)       !! (3, samples), T

        real(dp), allocatable :: field(:, :)
        integer :: i

        allocate (field(3, 0:self%arc%steps))
        do i = 0, self%arc%steps
            field(:, i) = self%arc%loads(i)%field
        end do
        field(:, :) = self%case%satellite%magnetometer%passed(field, self%arc%interval)
        values = field(:, self%magnetometer_stride::self%magnetometer_stride)
    end function true_field

    !> Star-camera quaternions.
    subroutine draw_stars(self, seed, run, observations, error)
        type(simulator_t), intent(in) :: self
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: run
        type(observation_set_t), intent(inout) :: observations
        type(error_t), allocatable, intent(out) :: error

        type(random_stream_t) :: streams(HEADS)
        real(dp) :: covariance(3, 3)
        integer :: i, head, frame

        do head = 1, HEADS
            streams(head) = run_stream(self, seed, run, STREAM_STAR_CAMERA + head - 1)
        end do
        do i = 1, size(observations%star_camera_time)
            head = observations%star_camera_head(i)
            frame = nint(observations%star_camera_time(i)/(self%star_camera_stride*self%arc%interval))
            call self%frames(frame, head)%draw(streams(head), observations%quaternion(:, i), covariance, error)
            if (allocated(error)) return
        end do
    end subroutine draw_stars

    function run_stream(self, seed, run, instrument) result(stream)
        type(simulator_t), intent(in) :: self
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: run, instrument
        type(random_stream_t) :: stream

        stream = new_stream(seed, self%case%number, merge(1, 2, self%case%satellite%name == 'front'), run, instrument)
    end function run_stream
end module gracecg_simulation_simulator
