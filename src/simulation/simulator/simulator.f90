!> From a case to an observation set: the true arc once, the instruments' noise for every run.
!>
!> Everything can be done whole, or piece by piece where the arc is long: a flight goes on by so many epochs, the
!> simulator then holds those, and what is drawn goes on where it has got to. The numbers are the same.
module gracecg_simulation_simulator
    use gracecg_base_kinds, only: dp, i8
    use gracecg_base_constants, only: TWO_PI
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_text, only: integer_text, join
    use gracecg_base_quaternion, only: quaternion_product
    use gracecg_base_random, only: random_stream_t, new_stream
    use gracecg_environment_thermosphere, only: density_wave_t
    use gracecg_environment_time, only: time_tag
    use gracecg_spacecraft_moment_series, only: moment_series_t, new_moment_series, FEWEST_MOMENTS
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_moments, take_measured_moments
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_observations_observation_set, only: observation_set_t
    use gracecg_simulation_accelerometer, only: accelerometer_noise_t, pmc_acceleration_t
    use gracecg_simulation_case, only: case_t
    use gracecg_simulation_dynamics, only: POSITION, VELOCITY
    use gracecg_simulation_flight, only: simulator_t, new_simulator, flight_t, begin_flight, propagate_case, &
        disturbance_at, samples_of, attitude_at
    use gracecg_simulation_operator_errors, only: operator_t, drawn_operator, errors_of, STAR_CAMERA_NOISE
    use gracecg_simulation_operator_view, only: operator_knowledge, believed_position
    use gracecg_files_value, only: did_you_mean
    use gracecg_observations_accelerometer_line, only: accelerometer_line_t
    use gracecg_simulation_arc, only: truth_arc_t
    implicit none
    private
    public :: simulator_t, new_simulator, observe, observe_without_noise, drawn_wave, measure_rods, tell_operator, &
        operator_of_run, propagate_case, disturbance_at, flight_t, begin_flight, run_noise_t, begin_noise, &
        observe_piece, PIECE_EPOCHS, error_switches_t, new_switched_simulator, switch_off, SOURCE_NAMES

    !> Streams of random numbers of one run
    integer, parameter :: STREAM_ACCELEROMETER = 1, STREAM_MAGNETOMETER = 2, STREAM_DENSITY = 3
    integer, parameter :: STREAM_STAR_CAMERA = 4    !! Head 1; head 2 follows
    integer, parameter :: STREAM_FURTHER = 10       !! Of the second accelerometer; the third follows
    integer, parameter :: STREAM_SCALES = 12        !! Of several accelerometers

    real(dp), parameter :: ORBIT_INTERVAL = 1       !! Of the positions in an observation set, s
    integer, parameter :: PIECE_EPOCHS = 2000
    !! Epochs of a piece of a long arc: with all that is seen at them some 2 MB

    !> The instruments' noise of a run, and where it has got to.
    type :: run_noise_t
        private
        type(density_wave_t) :: wave
        type(accelerometer_noise_t), allocatable :: accelerometer(:)
        real(dp), allocatable :: scale(:, :)        ! of several accelerometers by their mean, (3, number)
        type(random_stream_t) :: magnetometer, star_camera(HEADS)
        real(dp) :: felt(3) = 0     ! the field behind the magnetometer's filter at the last epoch, T
    end type run_noise_t

    !> One noisy observation set, with a seed of 32 or 64 bits
    interface observe
        module procedure observe_i4, observe_i8
    end interface observe

    !> The error sources that act. The estimator knows nothing of the switches: its weights stay.
    type :: error_switches_t
        logical :: curved_force = .true.
        !! The non-gravitational acceleration is not linear in time, and the density wave acts
        logical :: accelerometer_noise = .true.     !! Coloured noise of the accelerometer
        logical :: star_camera_noise = .true.       !! Noise of stars and catalogue
        logical :: magnetometer_noise = .true.      !! White noise and resolution of the magnetometer
        logical :: magnetometer_bias = .true.       !! Constant error of the magnetometer
        logical :: scale_factors = .true.           !! The accelerometer's, linear to cubic
    end type error_switches_t

    character(19), parameter :: SOURCE_NAMES(7) = [character(19) :: 'curved-force', 'accelerometer-noise', &
        'star-camera-noise', 'magnetometer-noise', 'magnetometer-bias', 'scale-factors', 'systematic']
    !! What can be switched off by name; systematic stands for curved-force, magnetometer-bias and
    !! scale-factors together

contains

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

        type(run_noise_t) :: noise

        if (.not. allocated(self%arc%state)) then
            call fail(error, 'the simulator has not been made (new_simulator)')
            return
        end if
        call begin_noise(self, seed, run, noise, error)
        if (.not. allocated(error)) &
            call observe_piece(self, operator_of_run(self%case, self%case%operator, seed, run), noise, observations, error, &
                               only_used_head)
    end subroutine observe_i8

    !> The noise of a run, before its first sample. Fails when a setting of an instrument is not in its range.
    subroutine begin_noise(self, seed, run, noise, error)
        type(simulator_t), intent(in) :: self
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: run    !! Names them, too
        type(run_noise_t), intent(out) :: noise
        type(error_t), allocatable, intent(out) :: error

        integer :: head, k

        noise%wave = drawn_wave(self, seed, run)
        allocate (noise%accelerometer(self%case%satellite%line%number))
        noise%scale = drawn_scales(self%case%satellite%line, run_stream(self, seed, run, STREAM_SCALES))
        do k = 1, size(noise%accelerometer)
            call self%case%satellite%accelerometer%begin_noise( &
                run_stream(self, seed, run, merge(STREAM_ACCELEROMETER, STREAM_FURTHER + k - 2, k == 1)), &
                self%arc%steps/self%accelerometer_stride, noise%accelerometer(k), error)
            if (allocated(error)) return
        end do
        noise%magnetometer = run_stream(self, seed, run, STREAM_MAGNETOMETER)
        do head = 1, HEADS
            noise%star_camera(head) = run_stream(self, seed, run, STREAM_STAR_CAMERA + head - 1)
        end do
    end subroutine begin_noise

    !> Scale factors of accelerometers on a line by their mean: the contrasts are drawn.
    function drawn_scales(line, stream) result(scales)
        type(accelerometer_line_t), intent(in) :: line
        type(random_stream_t), intent(in) :: stream
        real(dp) :: scales(3, line%number)

        type(random_stream_t) :: own
        real(dp) :: u(3, line%number - 1)
        integer :: j

        own = stream
        do j = 1, line%number - 1
            call own%normals(u(:, j))
            u(:, j) = u(:, j)*line%scale_sigma
        end do
        scales = 1 + matmul(u, transpose(line%weights()))
    end function drawn_scales

    !> The observation set of the epochs that the simulator holds: of the whole arc, or of its next piece.
    subroutine observe_piece(self, operator, noise, observations, error, only_used_head)
        type(simulator_t), intent(in) :: self
        type(operator_t), intent(in) :: operator        !! Of the run
        type(run_noise_t), intent(inout) :: noise       !! Of the run; goes on where it has got to
        type(observation_set_t), intent(out) :: observations
        type(error_t), allocatable, intent(out) :: error
        logical, intent(in), optional :: only_used_head     !! Leave out the other star-camera head

        real(dp), allocatable :: true_values(:, :)
        integer :: k

        call lay_out(self, operator, observations, only_used_head)
        do k = size(noise%accelerometer), 1, -1
            true_values = true_accelerations(self, noise%wave, k)
            if (size(noise%accelerometer) > 1) &
                true_values = true_values*spread(noise%scale(:, k), 2, size(true_values, 2))
            call self%case%satellite%accelerometer%measure_piece(true_values, noise%accelerometer(k), &
                                                                 observations%acceleration, error)
            if (allocated(error)) return
            if (k > 1) observations%further_acceleration(:, :, k - 1) = observations%acceleration
        end do
        call find_true_field(self, true_values, noise%felt)
        call self%case%satellite%magnetometer%measure(true_values, noise%magnetometer, observations%field, error)
        if (allocated(error)) return
        call draw_stars(self, noise, observations, error)
    end subroutine observe_piece

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

        real(dp), allocatable :: field(:, :), values(:, :)
        real(dp) :: felt(3)
        integer :: i, k

        call lay_out(self, self%case%operator, observations, .true.)
        associate (satellite => self%case%satellite)
            do k = satellite%line%number, 1, -1
                values = true_accelerations(self, wave, k)
                do i = 1, size(values, 2)
                    values(:, i) = satellite%accelerometer%digitised(satellite%accelerometer%response(values(:, i)))
                end do
                if (k > 1) observations%further_acceleration(:, :, k - 1) = values
            end do
            observations%acceleration = values
            felt = 0
            call find_true_field(self, field, felt)
            observations%field = field
            do i = 1, size(observations%field, 2)
                observations%field(:, i) = satellite%magnetometer%response(observations%field(:, i))
            end do
        end associate
        do i = 1, size(observations%quaternion, 2)
            observations%quaternion(:, i) = quaternion_product( &
                self%case%satellite%star_camera%mounting(observations%star_camera_head(i)), attitude_at(self, i))
        end do
    end subroutine observe_without_noise

    !> Tells the operator what the rods truly did, in place of what they were commanded to: their moments at
    !> equal intervals; of torquers what they were commanded to, as a history; where the attitude is controlled, at epochs of
    !> the arc. Fails when the intervals are too few.
    subroutine measure_rods(self, interval, observations, error)
        type(simulator_t), intent(in) :: self
        real(dp), intent(in) :: interval
        !! s, shortened so that the last sample is at the end of the arc, or of the arc's intervals the next number
        type(observation_set_t), intent(inout) :: observations
        type(error_t), allocatable, intent(out) :: error

        type(moment_series_t) :: measured
        type(torque_rods_t) :: rods
        real(dp), allocatable :: time(:), moment(:, :)
        integer :: n, i, stride

        rods = self%case%satellite%rods
        if (rods%direct) then
            rods%gain = 1
            rods%delay = 0
        end if

        if (allocated(self%rod_moments)) then
            stride = max(1, nint(interval/self%arc%interval))
            n = self%arc%steps/stride
        else
            n = ceiling(self%case%duration/interval*(1 - 1e-9_dp))
        end if
        if (n + 1 < FEWEST_MOMENTS) then
            call fail(error, 'an interval of '//number_text(interval)//' s gives only '//integer_text(n + 1)// &
                      ' moments of the torque rods in '//number_text(self%case%duration)//' s; at least '// &
                      integer_text(FEWEST_MOMENTS)//' are needed')
            return
        end if
        if (allocated(self%rod_moments)) then
            time = [(time_tag(i*stride, self%arc%interval), i=0, n)]
            moment = self%rod_moments(:, 0:n*stride:stride)
        else
            time = [(i*self%case%duration/n, i=0, n)]
            allocate (moment(3, 0:n))
            do i = 0, n
                moment(:, i) = rod_moments(rods, time(i + 1))
            end do
        end if
        call new_moment_series(time, moment, measured, error, direct=rods%direct)
        if (.not. allocated(error)) call take_measured_moments(measured, observations%knowledge%rods)
    end subroutine measure_rods

    !> Epochs, heads and the operator's knowledge; no values yet.
    subroutine lay_out(self, operator, observations, only_used_head)
        type(simulator_t), intent(in) :: self
        type(operator_t), intent(in) :: operator    !! Of the run
        type(observation_set_t), intent(inout) :: observations
        logical, intent(in), optional :: only_used_head

        integer :: first, last, i, head
        logical :: one_head

        one_head = .false.
        if (present(only_used_head)) one_head = only_used_head
        observations%accelerometer_time = epochs(self, self%accelerometer_stride)
        observations%magnetometer_time = epochs(self, self%magnetometer_stride)
        allocate (observations%acceleration(3, size(observations%accelerometer_time)))
        if (self%case%satellite%line%number > 1) &
            allocate (observations%further_acceleration(3, size(observations%accelerometer_time), &
                                                        self%case%satellite%line%number - 1))
        allocate (observations%field(3, size(observations%magnetometer_time)))
        call samples_of(self%arc, self%star_camera_stride, first, last)
        if (one_head) then
            observations%star_camera_time = epochs(self, self%star_camera_stride)
            observations%star_camera_head = [(self%case%operator%head, i=first, last)]
        else
            observations%star_camera_time = [((time_tag(i*self%star_camera_stride, self%arc%interval), &
                                               head=1, HEADS), i=first, last)]
            observations%star_camera_head = [((head, head=1, HEADS), i=first, last)]
        end if
        allocate (observations%quaternion(4, size(observations%star_camera_time)))
        call tell_operator(self, operator, observations)
    end subroutine lay_out

    !> Puts what an operator knows into an observation set: side knowledge and the orbit, and the rods' moments where
    !> they control the attitude (of a whole arc). Samples stay.
    subroutine tell_operator(self, operator, observations)
        type(simulator_t), intent(in) :: self
        type(operator_t), intent(in) :: operator    !! The case's own, or that of a run
        type(observation_set_t), intent(inout) :: observations

        type(error_t), allocatable :: too_short     ! an arc of few epochs is estimated by nobody

        observations%knowledge = operator_knowledge(self%case, operator)
        if (allocated(self%rod_moments) .and. self%arc%first == 0 .and. self%arc%last == self%arc%steps) &
            call measure_rods(self, self%arc%interval, observations, too_short)
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

        drawn = drawn_operator(operator, seed, case%label(), case%satellite%place(), run)
    end function operator_of_run

    !> The orbit as GPS gives it: positions every second from the epoch and at the end of the arc, true but for the
    !> operator's errors.
    subroutine lay_out_orbit(self, operator, observations)
        type(simulator_t), intent(in) :: self
        type(operator_t), intent(in) :: operator
        type(observation_set_t), intent(inout) :: observations

        integer, allocatable :: epoch(:)
        real(dp), allocatable :: position_told(:, :)
        integer :: stride, first, last, i

        stride = max(1, nint(ORBIT_INTERVAL/self%arc%interval))
        call samples_of(self%arc, stride, first, last)
        if (self%arc%first == 0) first = 0
        if (self%arc%last == self%arc%steps) last = (self%arc%steps + stride - 1)/stride
        epoch = [(min(i*stride, self%arc%steps), i=first, last)]
        observations%orbit_time = time_tag(epoch, self%arc%interval)
        allocate (position_told(3, size(epoch)))
        do i = 1, size(epoch)
            position_told(:, i) = believed_position(operator, self%start([POSITION, VELOCITY]), &
                                                    self%arc%state([POSITION, VELOCITY], epoch(i)), &
                                                    observations%orbit_time(i))
        end do
        call move_alloc(position_told, observations%orbit_position)
    end subroutine lay_out_orbit

    pure function epochs(self, stride) result(times)
        type(simulator_t), intent(in) :: self
        integer, intent(in) :: stride
        real(dp), allocatable :: times(:)   !! s

        integer :: first, last, i

        call samples_of(self%arc, stride, first, last)
        times = [(time_tag(i*stride, self%arc%interval), i=first, last)]
    end function epochs

    !> Of one of the accelerometers.
    pure function true_accelerations(self, wave, number) result(values)
        type(simulator_t), intent(in) :: self
        type(density_wave_t), intent(in) :: wave
        integer, intent(in) :: number
        real(dp), allocatable :: values(:, :)       !! (3, samples), m/s^2

        type(pmc_acceleration_t) :: acceleration
        integer :: first, last, i

        call samples_of(self%arc, self%accelerometer_stride, first, last)
        allocate (values(3, last - first + 1))
        do i = first, last
            acceleration = disturbance_at(self%case, self%arc, wave, i*self%accelerometer_stride, &
                                          self%case%satellite%line%place(number))
            values(:, i - first + 1) = acceleration%total
        end do
    end function true_accelerations

    !> The field that the magnetometer feels, behind its filter if it has one.
    pure subroutine find_true_field(self, values, felt)
        type(simulator_t), intent(in) :: self
        real(dp), allocatable, intent(out) :: values(:, :)  !! (3, samples), T
        real(dp), intent(inout) :: felt(3)      !! At the first epoch, unless that is 0; then at the last, T

        real(dp), allocatable :: field(:, :)
        integer :: first, last, i

        associate (arc => self%arc, magnetometer => self%case%satellite%magnetometer)
            allocate (field(3, arc%first:arc%last))
            do i = arc%first, arc%last
                field(:, i) = arc%loads(i)%field
            end do
            if (arc%first > 0) then
                field(:, :) = magnetometer%passed(field, arc%interval, felt)
            else
                field(:, :) = magnetometer%passed(field, arc%interval)
            end if
            felt = field(:, arc%last)
            call samples_of(self%arc, self%magnetometer_stride, first, last)
            values = field(:, first*self%magnetometer_stride:arc%last:self%magnetometer_stride)
        end associate
    end subroutine find_true_field

    !> Star-camera quaternions.
    subroutine draw_stars(self, noise, observations, error)
        type(simulator_t), intent(in) :: self
        type(run_noise_t), intent(inout) :: noise
        type(observation_set_t), intent(inout) :: observations
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: covariance(3, 3)
        integer :: i, head, frame

        do i = 1, size(observations%star_camera_time)
            head = observations%star_camera_head(i)
            frame = nint(observations%star_camera_time(i)/(self%star_camera_stride*self%arc%interval))
            call self%frames(frame, head)%draw(noise%star_camera(head), observations%quaternion(:, i), covariance, error)
            if (allocated(error)) return
        end do
    end subroutine draw_stars

    function run_stream(self, seed, run, instrument) result(stream)
        type(simulator_t), intent(in) :: self
        integer(i8), intent(in) :: seed        !! Of the random numbers
        integer, intent(in) :: run, instrument
        type(random_stream_t) :: stream

        stream = new_stream(seed, self%case%label(), self%case%satellite%place(), run, instrument)
    end function run_stream

    !> Switches off a source by its name. Fails for a name that is none of SOURCE_NAMES.
    subroutine switch_off(switches, name, error)
        type(error_switches_t), intent(inout) :: switches
        character(*), intent(in) :: name    !! Of the source
        type(error_t), allocatable, intent(out) :: error

        if (.not. any(SOURCE_NAMES == name)) then
            call fail(error, 'no error source "'//name//'"; there are '//join(SOURCE_NAMES, ', ')// &
                      did_you_mean(name, SOURCE_NAMES))
            return
        end if
        associate (systematic => name == 'systematic')
            if (name == 'curved-force' .or. systematic) switches%curved_force = .false.
            if (name == 'accelerometer-noise') switches%accelerometer_noise = .false.
            if (name == 'star-camera-noise') switches%star_camera_noise = .false.
            if (name == 'magnetometer-noise') switches%magnetometer_noise = .false.
            if (name == 'magnetometer-bias' .or. systematic) switches%magnetometer_bias = .false.
            if (name == 'scale-factors' .or. systematic) switches%scale_factors = .false.
        end associate
    end subroutine switch_off

    !> The simulator of a case in which only the error sources that are switched on act. Fails as
    !> `new_simulator` does.
    subroutine new_switched_simulator(case, switches, simulator, error)
        type(case_t), intent(in) :: case
        type(error_switches_t), intent(in) :: switches
        type(simulator_t), intent(out) :: simulator
        type(error_t), allocatable, intent(out) :: error

        type(case_t) :: switched

        switched = case
        if (.not. switches%accelerometer_noise) switched%satellite%accelerometer%noise%level = 0
        if (.not. switches%star_camera_noise) then
            switched%satellite%star_camera%catalogue_noise = 0
            switched%satellite%star_camera%measurement_noise = 0
        end if
        if (.not. switches%magnetometer_noise) switched%satellite%magnetometer%noise = 0
        if (.not. switches%magnetometer_bias) switched%satellite%magnetometer%bias = 0
        if (.not. switches%scale_factors) then
            switched%satellite%accelerometer%scale1 = 1
            switched%satellite%accelerometer%scale2 = 0
            switched%satellite%accelerometer%scale3 = 0
        end if
        call new_simulator(switched, simulator, error)
        if (allocated(error) .or. switches%curved_force) return
        call straighten_force(simulator%arc)
        simulator%case%density_wave_random = .false.
    end subroutine new_switched_simulator

    !> Replaces the non-gravitational acceleration along an arc by its linear fit (least squares).
    !> Orbit and attitude stay.
    pure subroutine straighten_force(arc)
        type(truth_arc_t), intent(inout) :: arc

        real(dp) :: mean(3), slope(3), centred
        integer :: k

        mean = 0
        slope = 0
        do k = 0, arc%steps
            associate (acting => arc%loads(k))
                mean = mean + (acting%drag + acting%srp + acting%erp)/(arc%steps + 1)
            end associate
        end do
        do k = 0, arc%steps
            centred = k - arc%steps/2.0_dp
            associate (acting => arc%loads(k))
                slope = slope + centred*(acting%drag + acting%srp + acting%erp - mean)
            end associate
        end do
        ! sum of the squares of n + 1 equally spaced numbers about their mean
        slope = slope*12/(arc%steps*(arc%steps + 1.0_dp)*(arc%steps + 2.0_dp))
        do k = 0, arc%steps
            arc%loads(k)%drag = mean + slope*(k - arc%steps/2.0_dp)
            arc%loads(k)%srp = 0
            arc%loads(k)%erp = 0
        end do
    end subroutine straighten_force
end module gracecg_simulation_simulator
