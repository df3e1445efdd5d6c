!> The estimate while the manoeuvre goes on: what `sequential` estimates under a straight drag with, where its frequency is
!> given, a density wave, fed sample by sample, in memory that does not grow.
!>
!> The arc is a window of one sampling interval: the nominal rotation goes on from its end, and so do its partials by what was
!> at the beginning (gracecg_estimation_model_rotation). A sample is whitened by what the noise of those before it lets expect
!> (T. Kailath, IEEE Trans. Automatic Control 13 (1968) 646-655) and folded into the square-root array of the constants
!> (gracecg_estimation_square_root_information). What Givens' rotations leave of the row is its innovation in units of its
!> standard deviation: one that is too large is left out. After a sample of the star camera the nominal rotation and parameters
!> move to the estimate: the array and what the whitening remembers stay as they are, but for their residuals. Offset, torque and
!> scale factors stay: their products with each other and with the rotation are not linear. While the offset is not known, what
!> these do to the acceleration is not either, and a filter that takes the first guess for it claims to know more than it does.
!> So the first seconds are kept, and linearised anew about what they have told, the past behind them never. A wave's amplitudes
!> and the error of its frequency move with the rotation: they are known long before their product matters, if the frequency is
!> nearly right. Nobody finds it in half a period: it has to be known from an earlier calibration.
module gracecg_estimation_live_estimate
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM, EARTH_ROTATION_RATE
    use gracecg_base_error, only: error_t, fail, number_text
    use gracecg_base_lanes, only: lanes_of
    use gracecg_base_coloured_noise, only: coloured_noise_t, coloured_noise, N_POLES
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_product, conjugate_quaternion, normalised
    use gracecg_base_vectors, only: cross, unit
    use gracecg_environment_sun, only: sun_position, conical_shadow, is_another_light
    use gracecg_environment_time, only: julian_centuries_tt
    use gracecg_observations_knowledge, only: operator_knowledge_t, HEADS
    use gracecg_observations_observation_set, only: LARGEST_ACCELERATION, LARGEST_FIELD
    use gracecg_observations_parameters, only: PARAMETERS, ATTITUDE_ANGLES, RATE, TORQUE, FIELD_BIAS, SCALE_FACTORS, DRIFT, &
        BIAS, OFFSET, WAVE_SINE, WAVE_COSINE, WAVE_FREQUENCY, LOOSE_SIGMAS
    use gracecg_estimation_options, only: sequential_options_t
    use gracecg_estimation_parameters, only: a_priori_sigmas
    use gracecg_estimation_model_state, only: physical_model_t, model_state_t, model_trajectory_t, turned_by
    use gracecg_estimation_physical_model, only: integrate_trajectory, predict_accelerations, star_angles
    use gracecg_estimation_square_root_information, only: constants_t, new_constants
    use gracecg_estimation_sequential, only: check_noise
    implicit none
    private
    public :: live_sample_t, live_estimate_t, begin_live_estimate

    !> The constants; last those whose nominal values stay until they are known
    integer, parameter :: ESTIMATED(27) = [ATTITUDE_ANGLES, RATE, FIELD_BIAS, WAVE_SINE, WAVE_COSINE, WAVE_FREQUENCY, DRIFT, &
                                           BIAS, OFFSET, TORQUE, SCALE_FACTORS]
    integer, parameter :: N = size(ESTIMATED)
    integer, parameter :: LATE = 9                  !! The last ones
    integer, parameter :: TURNING(12) = [1, 2, 3, 4, 5, 6, 7, 8, 9, 22, 23, 24]    !! Those that act on the rotation
    integer, parameter :: OF_WAVE(3) = [10, 11, 12]                                !! Those of the wave
    real(dp), parameter :: FIRST_SECONDS = 10       !! That are kept, s
    real(dp), parameter :: SAME_TIME = 1e-6_dp      !! Times that differ by less are one, sampling intervals
    real(dp), parameter :: KNOWN(LATE) = [1e-4_dp, 1e-4_dp, 1e-4_dp, 5e-6_dp, 5e-6_dp, 5e-6_dp, 0.0_dp, 0.0_dp, 0.0_dp]
    !! Standard deviations of those: of the offset, m; of a torque that is small beside that of the rods, N m; scale factors
    !! stay at 1
    real(dp), parameter :: LONGEST_SILENCE = 30     !! Of the magnetometer, whose last two samples are carried on, s
    real(dp), parameter :: MOST = 0.1_dp            !! Part of the samples that may be left out, chosen: more is no outliers, but
    !! forces of another shape; the density wave of the report's cases, its frequency not given, leaves out a fifth
    real(dp), parameter :: WAVE_SIGMA = 0.01_dp     !! Of a wave's frequency, relative
    real(dp), parameter :: NOTHING_KNOWN = 1        !! Standard deviation of the offset then, m
    real(dp), parameter :: FASTEST = 1              !! First guess of an angular velocity, rad/s
    real(dp), parameter :: MOST_BORNE = 10      !! Times what the setup says that a rod bears: beyond, a moment is of another unit
    real(dp), parameter :: LOWEST_ORBIT = 6.3e6_dp  !! m

    !> What comes within a sampling interval of the accelerometer, at its end.
    type :: live_sample_t
        real(dp) :: time = 0                        !! Of the end, s
        logical :: has_acceleration = .false.       !! False: the accelerometer is silent
        real(dp) :: acceleration(3) = 0             !! Body axes, m/s^2
        real(dp) :: moment(3, 0:2) = 0
        !! Of the rods at the beginning, the middle and the end of the interval, body axes, A m^2
        logical :: has_field = .false.              !! A sample of the magnetometer has come
        real(dp) :: field(3) = 0                    !! Body axes, T
        logical :: has_attitude(HEADS) = .false.    !! By star-camera head: it has given a sample
        real(dp) :: attitude_time(HEADS) = 0        !! Of it, within the interval, s
        real(dp) :: quaternion(4, HEADS) = 0        !! Inertial to camera, scalar last
        real(dp) :: position(3) = 0                 !! Inertial J2000, m; 0: not known, no gravity gradient
    end type live_sample_t

    !> What the noise of the samples so far lets expect of the next ones of an axis, in units of the white noise.
    type :: expectation_t
        real(dp) :: white_sigma = 1                         !! m/s^2
        real(dp) :: correlation(N_POLES) = 0                !! Of one sample with the next
        real(dp) :: variance(N_POLES) = 0                   !! Stationary
        real(dp) :: covariance(N_POLES, N_POLES) = 0
        real(dp) :: predicted(N + 1, N_POLES) = 0           !! Of partials and residual
    end type expectation_t

    !> An estimate that goes on.
    type :: live_estimate_t
        integer :: samples = 0                      !! Intervals that have been added, and the sample that began
        integer :: edited = 0                       !! Samples left out, those of each axis by themselves
        integer :: innovations = 0                  !! Taken: of each axis, and three of a sample of the star camera
        real(dp) :: time = 0                        !! Of the last sample, s
        real(dp) :: first_time = 0                  !! Of the first, s
        type(physical_model_t) :: model             !! Of the last interval
        type(model_state_t) :: state                !! Nominal, at its end
        type(model_trajectory_t) :: trajectory      !! Along it; its partials are by the constants
        type(constants_t) :: constants              !! Known so far
        real(dp) :: kept(N + 1, N) = 0, kept_squares = 0    !! Of them, while a sample is tried
        type(expectation_t) :: expectation(3)       !! By axis
        type(live_sample_t), allocatable :: first(:)    !! The first samples
        type(model_state_t) :: guess                !! About which they begin, moved along but for what is stated beforehand
        real(dp) :: prior_sigma(N) = 1              !! Of the constants, beforehand
        real(dp) :: star_sigma(3) = 1               !! About the camera's axes, rad
        real(dp) :: mounting(4, HEADS) = 0          !! Body to camera
        real(dp) :: scale(3) = 1, field_bias(3) = 0 !! Of accelerometer and magnetometer, as known
        integer :: fields = 0                       !! Samples of the magnetometer, two at most
        real(dp) :: field_time(2) = 0, field(3, 2) = 0      !! Its last two: s; body axes, T
        real(dp) :: position(3) = 0                 !! Of the last sample, m
        real(dp) :: largest_moment = 0              !! That is taken, A m^2
        real(dp) :: sun(3) = 0                      !! Inertial J2000, m
        real(dp) :: light = -1                      !! Of the Sun at the first sample with a position: the part that is seen
        real(dp) :: edit_sigma = 5                  !! An innovation beyond it is left out, standard deviations
    contains
        procedure :: add        !! Takes what has come in the next sampling interval
        procedure :: now        !! The offset and its covariance
        procedure :: wave       !! The density wave
        procedure :: field_at   !! The last samples of the magnetometer, carried on
    end type live_estimate_t

contains

    !> Nothing is known yet but what the operator knows; all memory is taken. Attitude and rate are a guess without weight.
    !>
    !> Fails when a noise level is not given, when a guess or the frequency is out of its range, or when the time tags of the
    !> accelerometer are known to be late.
    subroutine begin_live_estimate(knowledge, quaternion, angular_velocity, self, error, wave_frequency)
        type(operator_knowledge_t), intent(in) :: knowledge     !! Of its rods what they bear; samples have their moments
        real(dp), intent(in) :: quaternion(4)                   !! At the first sample, inertial to body
        real(dp), intent(in) :: angular_velocity(3)             !! The same, body axes, rad/s
        type(live_estimate_t), intent(out) :: self
        type(error_t), allocatable, intent(out) :: error
        real(dp), intent(in), optional :: wave_frequency
        !! Of a density wave, Hz, from an earlier calibration, within some per cent; absent or 0: none

        type(sequential_options_t) :: usual
        real(dp) :: stated(PARAMETERS), frequency

        call check_noise(knowledge, error)
        if (.not. allocated(error)) call expect_noise(self, knowledge, error)
        if (allocated(error)) return
        frequency = 0
        if (present(wave_frequency)) frequency = wave_frequency
        if (.not. (norm2(quaternion) > 0.5_dp .and. norm2(quaternion) < 2)) then
            call fail(error, 'live estimate: the first attitude must be a quaternion')
        else if (.not. norm2(angular_velocity) <= FASTEST) then
            call fail(error, 'live estimate: the first angular velocity is '//number_text(norm2(angular_velocity))// &
                      ' rad/s; it must not be more than '//number_text(FASTEST)//' rad/s')
        else if (.not. (frequency >= 0 .and. 2*frequency*knowledge%accelerometer_interval <= 1)) then
            call fail(error, 'live estimate: wave_frequency = '//number_text(frequency)//' Hz must be from 0 to '// &
                      number_text(0.5_dp/knowledge%accelerometer_interval)//' Hz, half the rate of the accelerometer')
        else if (abs(knowledge%accelerometer_delay) > 0) then
            call fail(error, 'live estimate: accelerometer_delay = '//number_text(knowledge%accelerometer_delay)// &
                      ' s must be 0: take it off the time tags')
        end if
        if (allocated(error)) return
        call lay_out_window(knowledge, self%model, self%trajectory)
        self%model%wave_frequency = frequency
        self%edit_sigma = usual%edit_sigma
        self%sun = sun_position(julian_centuries_tt(knowledge%epoch))
        self%largest_moment = MOST_BORNE*knowledge%rods%largest_moment
        self%star_sigma = knowledge%star_camera_sigma
        self%mounting = knowledge%mounting
        self%scale = knowledge%accelerometer_scale
        self%field_bias = knowledge%magnetometer_bias
        self%guess%quaternion = normalised(quaternion)
        self%guess%value(RATE) = angular_velocity
        stated = a_priori_sigmas(knowledge)
        self%prior_sigma = LOOSE_SIGMAS(ESTIMATED)
        where (stated(ESTIMATED) > 0) self%prior_sigma = stated(ESTIMATED)
        if (frequency > 0) self%prior_sigma(OF_WAVE(3)) = WAVE_SIGMA*frequency
        allocate (self%first(max(1, nint(FIRST_SECONDS/self%model%interval))))
        self%constants = new_constants(N)
        call start(self)
    end subroutine begin_live_estimate

    !> Before the first sample, about the guess.
    subroutine start(self)
        type(live_estimate_t), intent(inout) :: self

        integer :: i, axis

        self%samples = 0
        self%edited = 0
        self%innovations = 0
        self%fields = 0
        self%state = self%guess
        self%trajectory%partials(:, :, 0) = 0
        do i = 1, 6         ! of angles and rate by themselves
            self%trajectory%partials(i, i, 0) = 1
        end do
        self%constants%array(:, :) = 0
        do i = 1, N
            self%constants%array(i, i) = 1/self%prior_sigma(i)
        end do
        self%constants%squares = 0
        do axis = 1, 3
            associate (e => self%expectation(axis))
                e%predicted = 0
                e%covariance = 0
                do i = 1, N_POLES
                    e%covariance(i, i) = e%variance(i)
                end do
            end associate
        end do
    end subroutine start

    !> Adds the samples so far once more, about what they have told of offset and torque. Fails as `take` does.
    subroutine add_again(self, error)
        type(live_estimate_t), intent(inout) :: self
        type(error_t), allocatable, intent(out) :: error

        integer :: i, samples

        samples = self%samples
        call move_to_estimate(self, .true.)
        call start(self)
        do i = 1, samples
            call take(self, self%first(i), error)
            if (allocated(error)) return
        end do
        call move_to_estimate(self, .false.)
    end subroutine add_again

    !> The noise of the accelerometer before its first sample.
    subroutine expect_noise(self, knowledge, error)
        type(live_estimate_t), intent(inout) :: self
        type(operator_knowledge_t), intent(in) :: knowledge
        type(error_t), allocatable, intent(out) :: error

        type(coloured_noise_t) :: noise
        real(dp) :: white_variance
        integer :: axis

        do axis = 1, 3
            noise = coloured_noise(knowledge%accelerometer_noise(axis), knowledge%accelerometer_interval, error)
            if (allocated(error)) return
            associate (e => self%expectation(axis))
                call noise%markov_form(white_variance, e%correlation, e%variance)
                e%white_sigma = sqrt(white_variance)
                e%variance = e%variance/white_variance
            end associate
        end do
    end subroutine expect_noise

    !> The model of one interval, without torque and orbit.
    subroutine lay_out_window(knowledge, model, trajectory)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(physical_model_t), intent(out) :: model
        type(model_trajectory_t), intent(out) :: trajectory

        integer :: i

        model%steps = 1
        model%interval = knowledge%accelerometer_interval
        model%inertia = knowledge%inertia
        allocate (model%magnetic_torque(3, 0:2), model%dipole(3, 0:2), model%upwards(3, 0:2), model%airflow(3, 0:1), source=0.0_dp)
        allocate (model%rate_squared(0:2), model%moment(3, 0), model%moment_rate(3, 0), model%jump_torque(3, 3, 0), &
                  model%shape(3, 0:2, 0), source=0.0_dp)
        allocate (model%shaped(0))
        do i = 1, HEADS
            model%camera_from_body(:, :, i) = rotation_matrix(knowledge%mounting(:, i))
        end do
        model%estimated = ESTIMATED
        model%rotational = ESTIMATED(TURNING)
        model%place = [(findloc(TURNING, i, 1), i=1, N)]
        allocate (trajectory%q(4, 0:1), trajectory%omega(3, 0:1), trajectory%omega_dot(3, 0:1), &
                  trajectory%partials(lanes_of(size(TURNING)), 9, 0:1), source=0.0_dp)
    end subroutine lay_out_window

    !> Takes what has come in the next sampling interval; the first call what came at its end alone. After a quarter, a half
    !> and all of the first seconds these are added anew.
    !>
    !> Fails, and takes nothing, when a number is not finite, when the time is not that of the next interval (an interval in
    !> which the accelerometer is silent has to be added, too: the rods act), when the magnetometer has not yet been heard or
    !> too long ago, and where by its position the Sun rises or sets: the forces are a straight line no more, the estimate ends.
    subroutine add(self, sample, error)
        class(live_estimate_t), intent(inout) :: self
        type(live_sample_t), intent(in) :: sample
        type(error_t), allocatable, intent(out) :: error

        call take(self, sample, error)
        if (allocated(error)) return
        if (self%light < 0 .and. norm2(sample%position) > 0) self%light = conical_shadow(sample%position, self%sun)
        if (any(sample%has_attitude)) call move_to_estimate(self, .false.)
        associate (kept => size(self%first))
            if (self%samples > kept) return
            self%first(self%samples) = sample
            if (any(self%samples == [kept/4, kept/2, kept])) call add_again(self, error)
        end associate
    end subroutine add

    !> Takes a sample.
    subroutine take(self, sample, error)
        type(live_estimate_t), intent(inout) :: self
        type(live_sample_t), intent(in) :: sample
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: predicted(3, 1), partials(N, 3, 1), rows(N + 1, 3)
        integer :: k, axis, head

        call check_sample(self, sample, error)
        if (allocated(error)) return
        k = min(1, self%samples)
        call take_interval(self, sample)
        call integrate_trajectory(self%model, self%state, self%trajectory, goes_on=.true.)
        do head = 1, HEADS
            if (sample%has_attitude(head)) call take_attitude(self, head, sample%attitude_time(head), sample%quaternion(:, head))
        end do
        if (sample%has_acceleration) &
            call predict_accelerations(self%model, self%state, self%trajectory, [k], predicted, partials)
        do axis = 1, 3
            if (sample%has_acceleration) then
                rows(:, axis) = [partials(:, axis, 1), sample%acceleration(axis)/self%scale(axis) - predicted(axis, 1)]/ &
                                self%expectation(axis)%white_sigma
                ! bias and drift as the accelerometer shows them: then the scale factor has no part in them
                rows(N - 3 + axis, axis) = rows(N - 3 + axis, axis) - (self%state%value(BIAS(axis)) + &
                    self%state%value(DRIFT(axis))*(sample%time - self%first_time))/self%expectation(axis)%white_sigma
            end if
            call take_acceleration(self, axis, sample%has_acceleration, rows(:, axis))
        end do
        self%state%quaternion = self%trajectory%q(:, k)
        self%state%value(RATE) = self%trajectory%omega(:, k)
        self%trajectory%partials(:, :, 0) = self%trajectory%partials(:, :, k)
        self%samples = self%samples + 1
        self%time = sample%time
        self%position = sample%position
    end subroutine take

    !> Takes a sample of a star-camera head, against the rotation of the interval.
    subroutine take_attitude(self, head, time, quaternion)
        type(live_estimate_t), intent(inout) :: self
        integer, intent(in) :: head
        real(dp), intent(in) :: time            ! s
        real(dp), intent(in) :: quaternion(4)

        real(dp) :: rows(N + 1, 3), angles(3), body(4)
        integer :: axis

        body = quaternion_product(conjugate_quaternion(self%mounting(:, head)), quaternion)
        call star_angles(self%model, self%state, self%trajectory, time - self%first_time - self%model%start, head, &
                         normalised(body), angles, rows(:N, :))
        do axis = 1, 3
            rows(N + 1, axis) = angles(axis)
            rows(:, axis) = rows(:, axis)/self%star_sigma(axis)
        end do
        if (.not. is_taken(self, rows)) self%edited = self%edited + 1
    end subroutine take_attitude

    !> Refuses what cannot be taken.
    subroutine check_sample(self, sample, error)
        type(live_estimate_t), intent(in) :: self
        type(live_sample_t), intent(in) :: sample
        type(error_t), allocatable, intent(out) :: error

        real(dp) :: expected
        integer :: head

        associate (h => self%model%interval)
            expected = merge(self%time + h, sample%time, self%samples > 0)
            if (.not. allocated(self%constants%array)) then
                call fail(error, 'live estimate: it has not begun')
            else if (.not. (abs(sample%time) <= huge(1.0_dp) .and. all(abs(sample%acceleration) <= huge(1.0_dp)) .and. &
                            all(abs(sample%moment) <= huge(1.0_dp)) .and. all(abs(sample%field) <= huge(1.0_dp)) .and. &
                            all(abs(sample%position) <= huge(1.0_dp)) .and. all(abs(sample%quaternion) <= huge(1.0_dp)))) then
                call fail(error, 'live estimate: the sample at '//number_text(sample%time)//' s has numbers that are not finite')
            else if (norm2(sample%acceleration) > LARGEST_ACCELERATION .or. norm2(sample%field) > LARGEST_FIELD .or. &
                     any(abs(sample%moment) > self%largest_moment) .or. &
                     (norm2(sample%position) > 0 .and. norm2(sample%position) < LOWEST_ORBIT)) then
                call fail(error, 'live estimate: the sample at '//number_text(sample%time)//' s has an acceleration of '// &
                          number_text(norm2(sample%acceleration))//' m/s^2, a field of '//number_text(norm2(sample%field))// &
                          ' T, a moment of '//number_text(maxval(abs(sample%moment)))//' A m^2, a position of '// &
                          number_text(norm2(sample%position))//' m: check their units')
            else if (abs(sample%time - expected) > SAME_TIME*h) then
                call fail(error, 'live estimate: time = '//number_text(sample%time)//' s; the next sample is that at '// &
                          number_text(expected)//' s. Where the accelerometer is silent, add a sample without acceleration')
            else if (.not. (sample%has_field .or. self%fields > 0)) then
                call fail(error, 'live estimate: the first sample needs the field of the magnetometer')
            else if (.not. (sample%has_field .or. sample%time - self%field_time(2) <= LONGEST_SILENCE)) then
                call fail(error, 'live estimate: at '//number_text(sample%time)//' s the magnetometer has been silent since '// &
                          number_text(self%field_time(2))//' s; '//number_text(LONGEST_SILENCE)//' s are bridged')
            else if (self%light >= 0 .and. norm2(sample%position) > 0) then
                if (is_another_light(conical_shadow(sample%position, self%sun), self%light)) &
                    call fail(error, 'live estimate: at '//number_text(sample%time)//' s the Sun rises or sets, and the forces '// &
                              'are no straight line any more: take the estimate that there is, or begin another behind the '// &
                              'edge of the shadow')
            end if
            do head = 1, HEADS
                if (allocated(error) .or. .not. sample%has_attitude(head)) cycle
                if (.not. (abs(sample%attitude_time(head) - (sample%time - h/2)) <= (0.5_dp + SAME_TIME)*h .and. &
                           abs(norm2(sample%quaternion(:, head)) - 1) < 0.5_dp)) &
                    call fail(error, 'live estimate: a sample of the star camera at '// &
                              number_text(sample%attitude_time(head))//' s has to lie in the interval that ends at '// &
                              number_text(sample%time)//' s, and to be a quaternion')
            end do
        end associate
    end subroutine check_sample

    !> Torque and gravity of the interval that a sample ends.
    subroutine take_interval(self, sample)
        type(live_estimate_t), intent(inout) :: self
        type(live_sample_t), intent(in) :: sample

        real(dp) :: length, position(3)
        integer :: j

        length = self%model%interval
        if (self%samples == 0) then
            length = 0
            self%first_time = sample%time
            self%position = sample%position
        end if
        self%model%start = sample%time - length - self%first_time
        if (sample%has_field) then
            self%fields = min(2, self%fields + 1)
            self%field_time = [self%field_time(2), sample%time]
            self%field(:, 1) = self%field(:, 2)
            self%field(:, 2) = sample%field - self%field_bias
        end if
        self%model%airflow_known = length > 0 .and. norm2(sample%position) > 0 .and. norm2(self%position) > 0
        if (self%model%airflow_known) &
            self%model%airflow(:, :) = spread(unit((sample%position - self%position)/length - &
                                             EARTH_ROTATION_RATE*[-sample%position(2), sample%position(1), 0.0_dp]), 2, 2)
        self%model%rate_squared = 0
        do j = 0, 2
            self%model%dipole(:, j) = sample%moment(:, merge(j, 2, length > 0))
            self%model%magnetic_torque(:, j) = cross(self%model%dipole(:, j), self%field_at(sample%time + (j - 2)*length/2))
            if (.not. (norm2(sample%position) > 0 .and. norm2(self%position) > 0)) cycle
            position = ((2 - j)*self%position + j*sample%position)/2
            self%model%rate_squared(j) = EARTH_GM/norm2(position)**3
            self%model%upwards(:, j) = unit(position)
        end do
    end subroutine take_interval

    !> The last samples of the magnetometer, carried on along their straight line.
    pure function field_at(self, time) result(field)
        class(live_estimate_t), intent(in) :: self
        real(dp), intent(in) :: time        !! s
        real(dp) :: field(3)                !! Body axes, T

        field = self%field(:, 2)
        if (self%fields == 2) field = field + (self%field(:, 2) - self%field(:, 1))* &
                                      ((time - self%field_time(2))/(self%field_time(2) - self%field_time(1)))
    end function field_at

    !> Folds rows of unit noise in, unless an innovation is too large.
    logical function is_taken(self, rows)
        type(live_estimate_t), intent(inout) :: self
        real(dp), intent(in) :: rows(:, :)      ! [g, r], (N + 1, rows)

        real(dp) :: before
        integer :: i

        is_taken = .true.
        self%kept(:, :) = self%constants%array
        self%kept_squares = self%constants%squares
        do i = 1, size(rows, 2)
            before = self%constants%squares
            call self%constants%fold_in(rows(:, i))
            is_taken = is_taken .and. self%constants%squares - before <= self%edit_sigma**2     ! false of NaN
        end do
        if (is_taken) then
            self%innovations = self%innovations + size(rows, 2)
        else
            self%constants%array(:, :) = self%kept
            self%constants%squares = self%kept_squares
        end if
    end function is_taken

    !> Whitens and takes a sample of one axis, if there is one, and goes on to the next.
    subroutine take_acceleration(self, axis, there, row)
        type(live_estimate_t), intent(inout) :: self
        integer, intent(in) :: axis
        logical, intent(in) :: there
        real(dp), intent(in) :: row(N + 1)      ! [g, r], white noise = 1

        real(dp) :: innovation(N + 1), gain(N_POLES), variance
        logical :: taken
        integer :: p

        associate (e => self%expectation(axis))
            taken = .false.
            if (there) then
                gain = sum(e%covariance, 2)
                variance = 1 + sum(gain)
                gain = gain/variance
                innovation = row
                do p = 1, N_POLES
                    innovation = innovation - e%predicted(:, p)
                end do
                taken = is_taken(self, reshape(innovation/sqrt(variance), [N + 1, 1]))
                if (.not. taken) self%edited = self%edited + 1
            end if
            do p = 1, N_POLES
                if (taken) then
                    e%predicted(:, p) = e%correlation(p)*(e%predicted(:, p) + gain(p)*innovation)
                    e%covariance(:, p) = e%correlation*e%correlation(p)*(e%covariance(:, p) - gain*gain(p)*variance)
                else
                    e%predicted(:, p) = e%correlation(p)*e%predicted(:, p)
                    e%covariance(:, p) = e%correlation*e%correlation(p)*e%covariance(:, p)
                end if
                e%covariance(p, p) = e%covariance(p, p) + e%variance(p)*(1 - e%correlation(p)**2)
            end do
        end associate
    end subroutine take_acceleration

    !> Moves the nominal rotation, as it is now, and the parameters to the estimate; residuals with them. Components of offset
    !> and torque come along when they are known. For the product of rotation and offset is not linear: about a torque that a
    !> few samples of the star camera have made, the partials of the offset would be wrong. What the rotation is where the
    !> torque stays the triangle gives, since the torque is behind it.
    subroutine move_to_estimate(self, all_of_it)
        type(live_estimate_t), intent(inout) :: self
        logical, intent(in) :: all_of_it        ! offset and torque, too

        integer, parameter :: ANGLES_AND_RATE = 6
        real(dp) :: correction(N), turn(3), last(LATE), covariance(LATE, LATE)
        logical :: stays(LATE)
        integer :: i, p, axis

        call self%constants%last_covariance(last, covariance)
        stays = [(.not. (all_of_it .and. covariance(i, i) < KNOWN(i)**2), i=1, LATE)]
        correction(N - LATE + 1:) = last
        where (stays(4:6)) correction(N - 5:N - 3) = 0
        do i = N - LATE, 1, -1
            correction(i) = (self%constants%array(N + 1, i) - &
                             dot_product(self%constants%array(i + 1:N, i), correction(i + 1:)))/self%constants%array(i, i)
        end do
        where (stays) correction(N - LATE + 1:) = 0
        do i = 1, 3
            associate (by => self%trajectory%partials(:size(TURNING), :, 0))
                turn(i) = dot_product(by(:, i), correction(TURNING))
                self%state%value(RATE(i)) = self%state%value(RATE(i)) + dot_product(by(:, 3 + i), correction(TURNING))
            end associate
        end do
        self%state%quaternion = turned_by(turn, self%state%quaternion)
        do i = ANGLES_AND_RATE + 1, N
            self%state%value(ESTIMATED(i)) = self%state%value(ESTIMATED(i)) + correction(i)
        end do
        self%guess%quaternion = turned_by(correction(:3), self%guess%quaternion)
        associate (loose => [4, 5, 6, OF_WAVE, (i, i=13, 24)])
            self%guess%value(ESTIMATED(loose)) = self%guess%value(ESTIMATED(loose)) + correction(loose)
        end associate
        do i = 1, N
            self%constants%array(N + 1, i) = self%constants%array(N + 1, i) - &
                                             dot_product(self%constants%array(i:N, i), correction(i:))
        end do
        do axis = 1, 3
            do p = 1, N_POLES
                associate (predicted => self%expectation(axis)%predicted(:, p))
                    predicted(N + 1) = predicted(N + 1) - dot_product(predicted(:N), correction)
                end associate
            end do
        end do
    end subroutine move_to_estimate

    !> The offset and its covariance, with everything that has been added. What the samples do not determine has a standard
    !> deviation of a metre; so has all where more than a tenth of the samples was left out, and before `begin_live_estimate`.
    subroutine now(self, estimate, covariance, variance)
        class(live_estimate_t), intent(in) :: self
        real(dp), intent(out) :: estimate(3)            !! Of d, Body axes, m
        real(dp), intent(out) :: covariance(3, 3)       !! m^2
        real(dp), intent(out), optional :: variance     !! Of the innovations in units of what is expected: near 1

        real(dp) :: last(LATE), of_last(LATE, LATE)
        integer :: i

        estimate = 0
        covariance = 0
        do i = 1, 3
            covariance(i, i) = NOTHING_KNOWN**2
        end do
        if (present(variance)) variance = 1
        if (.not. allocated(self%constants%array)) return
        call self%constants%last_covariance(last, of_last)
        estimate = last(:3) + self%state%value(OFFSET)
        if (self%edited <= MOST*(self%edited + self%innovations)) covariance = of_last(:3, :3)
        if (present(variance)) variance = self%constants%squares/max(1, self%innovations)
    end subroutine now

    !> Frequency, Hz, and the amplitudes of sine and cosine of 2 pi f t, t from the first sample, m/s^2, as of the last sample of
    !> a star camera; 0 without a wave.
    pure function wave(self)
        class(live_estimate_t), intent(in) :: self
        real(dp) :: wave(3)

        wave = [self%model%wave_frequency + self%state%value(WAVE_FREQUENCY), self%state%value([WAVE_SINE, WAVE_COSINE])]
    end function wave
end module gracecg_estimation_live_estimate
