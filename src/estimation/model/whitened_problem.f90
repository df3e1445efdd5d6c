!> The whitened observations of a calibration as one least-squares problem: accelerometer samples
!> whitened with their spectrum, star-camera angles at their own epochs in units of their noise, and
!> a-priori knowledge. Every row has the weight 1, so the inverse normal matrix is the covariance.
module gracecg_estimation_whitened_problem
    use gracecg_base_kinds, only: dp
    use gracecg_base_error, only: error_t
    use gracecg_base_coloured_noise, only: noise_spectrum_t, are_alike
    use gracecg_base_lapack, only: grouped_normal_equations
    use gracecg_environment_sun, only: edge_of_shadow
    use gracecg_environment_time, only: julian_centuries_tt
    use gracecg_observations_knowledge, only: operator_knowledge_t
    use gracecg_estimation_options, only: estimation_options_t, optimal_options_t, WAVE_GIVEN
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_noise_whitening, only: whitener_t, accelerometer_whiteners
    use gracecg_observations_parameters
    use gracecg_estimation_parameters, only: ALWAYS_ESTIMATED, a_priori_sigmas, feels_lift
    use gracecg_estimation_physical_model
    use gracecg_estimation_batch_problem, only: batch_problem_t
    use gracecg_estimation_iteration, only: iteration_t, rms_of
    implicit none
    private
    public :: whitened_problem_t, assumed_noise_t, prepare_calibration, set_noise, information_matrix
    public :: asked_parameters, estimated_parameters, with_parameters, fit_point_t, point_of, problem_at

    real(dp), parameter :: STEADY = 90
    !! Longest arc over which the other torques are taken as constant, s: in the cases of CSR-TM-00-01 a change over 180 s
    !! is told by the tests, over 120 s not

    !> The noise that the observations are whitened with.
    type :: assumed_noise_t
        type(noise_spectrum_t) :: accelerometer(3)  !! (3-2), m^2 s^-4/Hz
        real(dp) :: star_camera_sigma(3) = 0    !! About camera x, y, boresight, rad
        real(dp) :: second_head_sigma(3) = 0    !! The same of head 2, where it has another; 0: it has not
    contains
        procedure :: of_head                    !! The sigma of a head
    end type assumed_noise_t

    !> Where a fit has got to, without its samples: from this and them the problem is there again.
    type :: fit_point_t
        integer, allocatable :: estimated(:)    !! Its parameters
        type(model_state_t) :: state            !! Where it is linearised
        type(assumed_noise_t) :: noise          !! That gives the weights
        real(dp) :: wave_frequency = 0          !! Of a density wave, Hz; 0: none
        integer :: jump = huge(1)               !! From which interval on FORCE_JUMP acts
        integer, allocatable :: stars_left_out(:), accelerations_left_out(:)
        !! Numbers of the star-camera samples, and places in (3, accelerometer samples)
    end type fit_point_t

    !> Observations in this order: star camera (3 a sample), accelerometer (3 a sample), channels (3 a sample of angular ones
    !> where their bias is estimated, or of each contrast of several accelerometers), a priori.
    type, extends(batch_problem_t) :: whitened_problem_t
        type(physical_model_t) :: model    !! With the parameters that are estimated
        type(model_state_t) :: state    !! About which the problem is linearised
        type(fitting_data_t) :: data    !! The observations, preprocessed
        type(assumed_noise_t) :: noise    !! That gives the weights
        integer, allocatable :: groups(:, :)
        !! Observations that depend on the same parameters: first, last, step; see `grouped_normal_equations`
        type(whitener_t) :: whiteners(3)    !! Of accelerometer x, y, z
        type(whitener_t) :: channel_whiteners(3)    !! Of the channels
        type(noise_spectrum_t), private :: whitened_noise(3)        !! The noise that they are for
        logical, allocatable, private :: whitened_samples(:, :)     !! The samples kept that they are for
        logical, allocatable :: star_kept(:)            !! (star-camera samples)
        logical, allocatable :: acceleration_kept(:, :) !! (3, accelerometer samples)
        real(dp), allocatable :: star_angles(:, :)      !! Observed minus computed, camera axes, rad
        real(dp), allocatable :: acceleration_residual(:, :)        !! Accelerometer, observed minus computed, m/s^2
        real(dp), allocatable :: acceleration_partials(:, :, :) !! (parameters, 3, samples), not whitened
        real(dp), allocatable :: channel_residual(:, :) !! Channels, observed minus computed, rad/s^2; m/s^2
        integer :: star_rows = 0, acceleration_rows = 0, channel_rows = 0
        !! Numbers of scalar observations: they stand in this order, then the a-priori knowledge
        type(model_trajectory_t) :: trajectory    !! The rotation at the last linearisation
        type(model_trajectory_t), private :: rotation   !! At a later state, without partials
        real(dp), allocatable, private :: star_partials(:, :)
        integer, allocatable, private :: known(:)       !! Places of parameters with a-priori knowledge
        real(dp), allocatable, private :: known_sigma(:)
    contains
        procedure :: linearise => linearise_calibration
        procedure :: predict                           !! Rotation and accelerations, with partials that are not whitened
        procedure :: compare => compare_calibration    !! Residuals alone, which cost less
        procedure :: correct => correct_calibration
        procedure :: describe_residuals => residuals_of_calibration
        procedure :: describe_state => state_of_calibration
        procedure :: forget_prior                      !! Of the first parameters
        procedure :: sample_rows                       !! Number of observations that are no a-priori knowledge
    end type whitened_problem_t

contains

    !> The parameters that `optimal` estimates: those that the options ask for, what is known only within limits, drag
    !> that is no straight line, with a quiet accelerometer the lift, and across the edge of the Earth's shadow the Sun's light.
    pure function estimated_parameters(asked, knowledge, data) result(estimated)
        type(optimal_options_t), intent(in) :: asked
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(in), optional :: data      !! Their orbit tells whether the edge of the shadow is passed
        integer, allocatable :: estimated(:)

        type(optimal_options_t) :: all
        integer, allocatable :: more(:)
        integer :: i

        all = asked
        all%estimate_scale_factors = asked%estimate_scale_factors .or. asked%estimate_within_limits
        all%estimate_magnetometer_bias = asked%estimate_magnetometer_bias .or. asked%estimate_within_limits
        estimated = asked_parameters(all, knowledge)
        if (.not. asked%estimate_within_limits) return
        more = FORCE_SHAPES
        if (knowledge%duration > STEADY) more = [more, TORQUE_CHANGE]
        if (feels_lift(knowledge)) more = [more, LIFT, TILT]
        if (present(data)) then
            if (edge_of_shadow(julian_centuries_tt(knowledge%epoch), data%orbit_time, data%orbit_position, &
                               knowledge%duration) >= 0) more = [more, LIGHT]
        end if
        estimated = [estimated, pack(more, [(.not. any(estimated == more(i)), i=1, size(more))])]
    end function estimated_parameters

    !> The parameters that the options ask for by name; with several accelerometers theirs, inertia, the gain of each rod and
    !> torques that change, too. Torquers have gains of their own.
    pure function asked_parameters(asked, knowledge) result(estimated)
        type(optimal_options_t), intent(in) :: asked
        type(operator_knowledge_t), intent(in) :: knowledge
        integer, allocatable :: estimated(:)

        integer, allocatable :: named(:)
        character(:), allocatable :: unknown    ! none: the options have been looked at
        real(dp) :: sigma(PARAMETERS)
        integer :: i

        estimated = ALWAYS_ESTIMATED
        if (asked%estimate_scale_factors) estimated = [estimated, SCALE_FACTORS]
        if (asked%estimate_rod_gain .and. knowledge%line%number == 1) &
            estimated = [estimated, pack([ROD_GAIN, ROD_GAINS], [.not. knowledge%rods%direct, spread(knowledge%rods%direct, 1, 3)])]
        if (asked%estimate_magnetometer_bias) estimated = [estimated, FIELD_BIAS]
        if (asked%density_wave == WAVE_GIVEN) estimated = [estimated, WAVE_SINE, WAVE_COSINE]
        call find_parameters(asked%also, named, unknown)
        if (knowledge%line%number > 1) then
            associate (n => 3*knowledge%line%number - 3)
                estimated = [estimated, LINE_SCALES(:n), LINE_BIAS(:n), LINE_DRIFT(:n)]
            end associate
            sigma = a_priori_sigmas(knowledge)      ! the rotation shows what makes it
            associate (causes => [INERTIA, ROD_GAINS, TORQUE_CHANGE, TORQUE_BENDS])
                estimated = [estimated, pack(causes, sigma(causes) > 0)]
            end associate
        end if
        estimated = [estimated, pack(named, [(.not. any(estimated == named(i)), i=1, size(named))])]
    end function asked_parameters

    !> Sets up the problem from preprocessed data, at the first guess. Call set_noise next.
    subroutine prepare_calibration(knowledge, options, data, estimated, problem)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(fitting_data_t), intent(inout) :: data     !! Its warnings may grow
        integer, intent(in) :: estimated(:)             !! Parameters, see gracecg_estimation_parameters
        type(whitened_problem_t), intent(out) :: problem

        real(dp) :: sigma(PARAMETERS)
        integer :: i, n

        call prepare_model(knowledge, data, estimated, problem%model)
        if (options%optimal%density_wave == WAVE_GIVEN) &
            problem%model%wave_frequency = 1/options%optimal%density_wave_period
        problem%data = data
        problem%state = initial_state(data, options)
        problem%names = parameter_names(estimated)
        problem%scales = typical_sizes(estimated, knowledge%duration)
        n = size(estimated)
        sigma = a_priori_sigmas(knowledge)
        problem%known = pack([(i, i=1, n)], sigma(estimated) > 0)
        problem%known_sigma = sigma(estimated(problem%known))
        associate (stars => size(data%stars%time), samples => size(data%accelerometer_epoch))
            problem%star_rows = 3*stars
            problem%acceleration_rows = 3*samples
            if (any(estimated == CHANNEL_BIAS(1)) .or. knowledge%line%number > 1) problem%channel_rows = size(data%angular)
            allocate (problem%channel_residual(size(data%angular, 1), problem%channel_rows/size(data%angular, 1)))
            allocate (problem%star_kept(stars), problem%acceleration_kept(3, samples), source=.true.)
            allocate (problem%star_angles(3, stars), problem%acceleration_residual(3, samples))
            allocate (problem%acceleration_partials(n, 3, samples), problem%star_partials(n, 3))
        end associate
        problem%observations = problem%sample_rows() + size(problem%known)
        associate (stars => problem%star_rows, last => problem%star_rows + problem%acceleration_rows, &
                   samples => problem%sample_rows())
            problem%groups = reshape([1, stars, 1, stars + 1, last, 3, stars + 2, last, 3, stars + 3, last, 3, &
                                      samples + 1, problem%observations, 1], [3, 5])
            do n = 1, merge(size(data%angular, 1), 0, samples > last)
                problem%groups = reshape([problem%groups, last + n, samples, size(data%angular, 1)], [3, 5 + n])
            end do
        end associate
        problem%noise%accelerometer = knowledge%accelerometer_noise
        problem%noise%star_camera_sigma = knowledge%star_camera_sigma
    end subroutine prepare_calibration

    !> The same problem, at the same state, with other parameters. Call set_noise next.
    subroutine with_parameters(knowledge, options, problem, estimated, other)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(whitened_problem_t), intent(in) :: problem
        integer, intent(in) :: estimated(:)    !! Parameters, see gracecg_estimation_parameters
        type(whitened_problem_t), intent(out) :: other

        type(fitting_data_t) :: data
        type(fit_point_t) :: point

        data = problem%data
        point = point_of(problem)
        point%estimated = estimated
        call problem_at(knowledge, options, data, point, other)
        other%data%warnings = problem%data%warnings     ! said already
        other%whiteners = problem%whiteners
        other%channel_whiteners = problem%channel_whiteners
        other%whitened_noise = problem%whitened_noise
        if (allocated(problem%whitened_samples)) other%whitened_samples = problem%whitened_samples
    end subroutine with_parameters

    !> Where a problem is.
    pure function point_of(problem) result(point)
        type(whitened_problem_t), intent(in) :: problem
        type(fit_point_t) :: point

        integer :: i

        point%estimated = problem%model%estimated
        point%state = problem%state
        point%noise = problem%noise
        point%wave_frequency = problem%model%wave_frequency
        point%jump = problem%model%jump
        point%stars_left_out = pack([(i, i=1, size(problem%star_kept))], .not. problem%star_kept)
        point%accelerations_left_out = pack([(i, i=1, size(problem%acceleration_kept))], &
                                            .not. reshape(problem%acceleration_kept, [size(problem%acceleration_kept)]))
    end function point_of

    !> The problem that was there, of the same preprocessed data. Call set_noise next.
    subroutine problem_at(knowledge, options, data, point, problem)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(estimation_options_t), intent(in) :: options
        type(fitting_data_t), intent(inout) :: data     !! Its warnings may grow
        type(fit_point_t), intent(in) :: point
        type(whitened_problem_t), intent(out) :: problem

        integer :: i

        call prepare_calibration(knowledge, options, data, point%estimated, problem)
        problem%state = point%state
        problem%noise = point%noise
        problem%model%wave_frequency = point%wave_frequency
        problem%model%jump = point%jump
        problem%star_kept(point%stars_left_out) = .false.
        do i = 1, size(point%accelerations_left_out)
            associate (place => point%accelerations_left_out(i) - 1)
                problem%acceleration_kept(1 + mod(place, 3), 1 + place/3) = .false.
            end associate
        end do
    end subroutine problem_at

    !> Prepares the whitening with problem%noise and of the samples kept. Fails when a level is not
    !> positive.
    subroutine set_noise(problem, error)
        type(whitened_problem_t), intent(inout) :: problem
        type(error_t), allocatable, intent(out) :: error

        type(noise_spectrum_t) :: of_one(3)

        if (allocated(problem%whitened_samples)) then
            if (all(problem%whitened_samples .eqv. problem%acceleration_kept) .and. &
                all(same_noise(problem%whitened_noise, problem%noise%accelerometer))) return
            deallocate (problem%whitened_samples)
        end if
        call accelerometer_whiteners(problem%noise%accelerometer, problem%model%interval, &
                                     problem%data%accelerometer_epoch, problem%whiteners, error, &
                                     problem%acceleration_kept)
        if (allocated(error)) return
        if (problem%model%line%number > 1) then
            of_one = problem%noise%accelerometer
            of_one%level = problem%model%line%number*of_one%level
            call accelerometer_whiteners(of_one, problem%model%interval, problem%data%accelerometer_epoch, &
                                         problem%channel_whiteners, error, problem%acceleration_kept)
            if (allocated(error)) return
        end if
        problem%whitened_noise = problem%noise%accelerometer
        problem%whitened_samples = problem%acceleration_kept

    contains

        elemental logical function same_noise(a, b)
            type(noise_spectrum_t), intent(in) :: a, b

            same_noise = abs(a%level - b%level) <= 0 .and. are_alike(a, b)
        end function same_noise
    end subroutine set_noise

    subroutine linearise_calibration(self, partials, residuals, weights, error)
        class(whitened_problem_t), intent(inout) :: self
        real(dp), contiguous, intent(out) :: partials(:, :)
        real(dp), intent(out) :: residuals(:), weights(:)
        type(error_t), allocatable, intent(out) :: error

        integer :: axis, first, i

        weights = 1
        partials = 0
        call self%predict()
        call linearise_stars(self, partials)
        first = self%star_rows
        do axis = 1, 3
            associate (rows => partials(:, first + axis:first + self%acceleration_rows:3))
                rows = self%acceleration_partials(:, axis, :)
                call self%whiteners(axis)%whiten(rows)
            end associate
        end do
        call linearise_channels(self, partials)
        do i = 1, size(self%known)
            partials(self%known(i), self%sample_rows() + i) = 1/self%known_sigma(i)
        end do
        call whiten_residuals(self, self%trajectory, residuals)
    end subroutine linearise_calibration

    !> Rotation and accelerations at the state: self%acceleration_residual holds what is predicted.
    subroutine predict(self)
        class(whitened_problem_t), intent(inout) :: self

        call integrate_trajectory(self%model, self%state, self%trajectory)
        call predict_accelerations(self%model, self%state, self%trajectory, self%data%accelerometer_epoch, &
                                   self%acceleration_residual, self%acceleration_partials)
    end subroutine predict

    !> Partials of the channels, whitened.
    subroutine linearise_channels(self, partials)
        class(whitened_problem_t), intent(inout) :: self
        real(dp), contiguous, intent(inout) :: partials(:, :)

        real(dp), allocatable :: by(:, :, :)
        integer :: i, first

        if (self%channel_rows == 0) return
        associate (n => size(self%channel_residual, 1))
            allocate (by(size(partials, 1), n, self%channel_rows/n))
            call predict_channel_rows(self, self%trajectory, by)
            first = self%star_rows + self%acceleration_rows
            do i = 1, n
                associate (rows => partials(:, first + i:self%sample_rows():n))
                    rows = by(:, i, :)
                    call self%channel_whiteners(mod(i - 1, 3) + 1)%whiten(rows)
                end associate
            end do
        end associate
    end subroutine linearise_channels

    !> What the channels would show along a rotation, into self%channel_residual, and its partials.
    pure subroutine predict_channel_rows(self, rotation, partials)
        class(whitened_problem_t), intent(inout) :: self
        type(model_trajectory_t), intent(in) :: rotation
        real(dp), intent(out), optional :: partials(:, :, :)

        associate (epoch => self%data%accelerometer_epoch)
            if (self%model%line%number > 1) then
                call predict_contrasts(self%model, self%state, rotation, epoch, self%channel_residual, partials)
            else
                call predict_channels(self%model, self%state, rotation, epoch, self%channel_residual, partials)
            end if
        end associate
    end subroutine predict_channel_rows

    !> Leaves out what is known beforehand of the first parameters, which someone else counts.
    pure subroutine forget_prior(self, first)
        class(whitened_problem_t), intent(inout) :: self
        integer, intent(in) :: first                !! So many

        self%known_sigma = pack(self%known_sigma, self%known > first)
        self%known = pack(self%known, self%known > first)
        self%observations = self%sample_rows() + size(self%known)
        self%groups(:2, 5) = [self%sample_rows() + 1, self%observations]
    end subroutine forget_prior

    !> The number of observations that are no a-priori knowledge.
    pure integer function sample_rows(self)
        class(whitened_problem_t), intent(in) :: self

        sample_rows = self%star_rows + self%acceleration_rows + self%channel_rows
    end function sample_rows

    !> The standard deviations of a star-camera head about its axes, rad.
    pure function of_head(self, head) result(sigma)
        class(assumed_noise_t), intent(in) :: self
        integer, intent(in) :: head    !! Number of the head; 0: the camera
        real(dp) :: sigma(3)

        sigma = merge(self%second_head_sigma, self%star_camera_sigma, head == 2 .and. self%second_head_sigma > 0)
    end function of_head

    !> Residuals at the problem's state, whose rotation is integrated without partials.
    subroutine compare_calibration(self, residuals)
        class(whitened_problem_t), intent(inout) :: self
        real(dp), intent(out) :: residuals(:)   !! As `linearise` gives them

        call integrate_trajectory(self%model, self%state, self%rotation, without_partials=.true.)
        call predict_accelerations(self%model, self%state, self%rotation, self%data%accelerometer_epoch, &
                                   self%acceleration_residual)
        call whiten_residuals(self, self%rotation, residuals)
    end subroutine compare_calibration

    !> The whitened residuals along a rotation; self%acceleration_residual holds the predicted accelerations and gets
    !> what they leave.
    subroutine whiten_residuals(self, rotation, residuals)
        class(whitened_problem_t), intent(inout) :: self
        type(model_trajectory_t), intent(in) :: rotation
        real(dp), intent(out) :: residuals(:)

        integer :: i, axis, first

        residuals = 0
        associate (stars => self%data%stars)
            do i = 1, size(stars%time)
                call star_angles(self%model, self%state, rotation, stars%time(i), stars%head(i), stars%quaternion(:, i), &
                                 self%star_angles(:, i))
                if (self%star_kept(i)) residuals(3*i - 2:3*i) = self%star_angles(:, i)/self%noise%of_head(stars%head(i))
            end do
        end associate
        first = self%star_rows
        self%acceleration_residual = self%data%acceleration - self%acceleration_residual
        do axis = 1, 3
            associate (observed => residuals(first + axis:first + self%acceleration_rows:3))
                observed = self%acceleration_residual(axis, :)
                call self%whiteners(axis)%whiten_series(observed)
            end associate
        end do
        first = first + self%acceleration_rows
        if (self%channel_rows > 0) then
            call predict_channel_rows(self, rotation)
            self%channel_residual = self%data%angular - self%channel_residual
            associate (n => size(self%channel_residual, 1))
                do i = 1, n
                    associate (observed => residuals(first + i:self%sample_rows():n))
                        observed = self%channel_residual(i, :)
                        call self%channel_whiteners(mod(i - 1, 3) + 1)%whiten_series(observed)
                    end associate
                end do
            end associate
        end if
        first = self%sample_rows()
        do i = 1, size(self%known)
            residuals(first + i) = -self%state%value(self%model%estimated(self%known(i)))/self%known_sigma(i)
        end do
    end subroutine whiten_residuals

    subroutine linearise_stars(self, partials)
        class(whitened_problem_t), intent(inout) :: self
        real(dp), intent(inout) :: partials(:, :)

        real(dp) :: sigma(3)
        integer :: i, axis

        associate (stars => self%data%stars)
            do i = 1, size(stars%time)
                if (.not. self%star_kept(i)) cycle
                sigma = self%noise%of_head(stars%head(i))
                call star_angles(self%model, self%state, self%trajectory, stars%time(i), stars%head(i), &
                                 stars%quaternion(:, i), self%star_angles(:, i), self%star_partials)
                do axis = 1, 3
                    partials(:, 3*i - 3 + axis) = self%star_partials(:, axis)/sigma(axis)
                end do
            end do
        end associate
    end subroutine linearise_stars

    subroutine correct_calibration(self, correction)
        class(whitened_problem_t), intent(inout) :: self
        real(dp), intent(inout) :: correction(:)

        call correct_state(self%model, correction, self%state)
    end subroutine correct_calibration

    !> Fisher information of the problem's parameters at its state, and its right-hand side.
    subroutine information_matrix(problem, information, rhs, residuals)
        type(whitened_problem_t), intent(inout) :: problem
        real(dp), allocatable, intent(out) :: information(:, :), rhs(:)
        !! (parameters, parameters), and the side: (parameters)
        real(dp), allocatable, intent(out) :: residuals(:)      !! Whitened

        real(dp), allocatable :: partials(:, :), weights(:)
        type(error_t), allocatable :: error     ! linearise_calibration gives none
        integer :: n, m

        n = size(problem%model%estimated)
        m = problem%observations
        allocate (partials(n, m), weights(m), residuals(m), information(n, n), rhs(n))
        call problem%linearise(partials, residuals, weights, error)
        call grouped_normal_equations(problem%groups, partials, residuals, information, rhs)
    end subroutine information_matrix

    !> RMS of the residuals: angles of the star camera (camera axes), and accelerometer, of the samples kept.
    subroutine residuals_of_calibration(self, residuals, note)
        class(whitened_problem_t), intent(in) :: self
        real(dp), intent(in) :: residuals(:)        !! Whitened: not used
        type(iteration_t), intent(inout) :: note

        real(dp) :: rms(6)
        integer :: axis

        associate (not_used => residuals)
        end associate
        do axis = 1, 3
            rms(axis) = rms_of(pack(self%star_angles(axis, :), self%star_kept))
            rms(3 + axis) = rms_of(pack(self%acceleration_residual(axis, :), self%acceleration_kept(axis, :)))
        end do
        note%residual_names = [character(12) :: 'star_x', 'star_y', 'star_z', 'acc_x', 'acc_y', 'acc_z']
        note%residual_rms = rms
        note%residual_unit = 'rad, m/s^2'
    end subroutine residuals_of_calibration

    !> Attitude, then what is estimated beside it.
    subroutine state_of_calibration(self, note)
        class(whitened_problem_t), intent(in) :: self
        type(iteration_t), intent(inout) :: note

        call describe_model_state(self%model, self%state, note)
    end subroutine state_of_calibration
end module gracecg_estimation_whitened_problem
