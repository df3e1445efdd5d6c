!> The physical model that the optimal and the sequential estimator fit, and that the bound is
!> computed from: rotation under the magnetic torque, the gravity gradient and an unknown torque, and
!> what star camera and accelerometer show of it, with the partials of every parameter.
!>
!> Rotation: J d omega/dt = (1 + g) m x (B - b) + 3 mu/r^3 c x (J c) + T + T' (t/t_n - 1/2) -
!> omega x (J omega), CSR-TM-00-01 eqs. (2-16), (2-23), with the rods' gain error g, the magnetometer's
!> bias b, the unknown torque T and its change T' over the arc of length t_n. The attitude error is
!> multiplicative: R(q) = C(zeta) R(q*), d zeta/dt = -omega* x zeta + d omega. J_p stands for the
!> inertia about the centre of mass, from which it differs by 1e-6 (4-6).
!>
!> Accelerometer: S [(A~ + G) d + alpha t + beta + w (gamma P2(t) + (a sin + b cos)(2 pi (f + df) t))], (3-7),
!> (4-17), with S = diag(1 + s), and along the airflow w, which comes from the orbit (body x without one),
!> a density wave and Legendre's polynomial P2 over the arc. What forces of unknown shape do besides (FORCE_BENDS,
!> SIDE_FORCE) is counted as the accelerometer shows it, without S: their a-priori sigmas would pull s otherwise.
module gracecg_estimation_physical_model
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: EARTH_GM, EARTH_ROTATION_RATE, TWO_PI
    use gracecg_base_error, only: number_text
    use gracecg_base_text, only: append
    use gracecg_base_vectors, only: cross, cross_matrix, unit
    use gracecg_base_lanes, only: lanes_of, lanes_carry
    use gracecg_base_quaternion, only: rotation_matrix, quaternion_rate, quaternion_product, &
        conjugate_quaternion, normalised
    use gracecg_spacecraft_torque_rods, only: torque_rods_t, rod_moments, rod_direction, interchange_rods, gain_unit
    use gracecg_observations_knowledge, only: operator_knowledge_t, HEADS
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_interpolation, only: interpolation_t, interpolation_at, cubic_interpolated, &
        LONGEST_ORBIT_SPACING
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_observations_parameters
    use gracecg_estimation_rigid_body, only: rigid_body_t, rotation_t, new_rigid_body
    use gracecg_estimation_offset_model, only: offset_matrix, offset_rate_partials
    use gracecg_estimation_offset_information, only: gravity_gradient_matrix
    use gracecg_estimation_iteration, only: iteration_t
    implicit none
    private
    public :: describe_model_state
    public :: physical_model_t, model_state_t, model_trajectory_t
    public :: prepare_model, initial_state, integrate_trajectory, predict_accelerations, predict_channels, star_angles
    public :: correct_state, turned_by, turn_between, sinc
    public :: airflow_at

    !> Rows and columns of the elements of INERTIA
    integer, parameter :: ELEMENT_ROW(6) = [1, 2, 3, 1, 2, 3], ELEMENT_COLUMN(6) = [1, 2, 3, 2, 3, 1]

    !> What does not change during the fit. Epochs are k h, k = 0..n; half steps are j h/2.
    type :: physical_model_t
        integer :: steps = 0                            !! n
        real(dp) :: interval = 0                        !! h, s
        real(dp) :: inertia(3, 3) = 0                   !! Nominal J, kg m^2
        real(dp), allocatable :: magnetic_torque(:, :)  !! m x B, nominal, (3, 0:2n), N m
        real(dp), allocatable :: dipole(:, :)           !! m, (3, 0:2n), A m^2
        real(dp), allocatable :: moment(:, :), moment_rate(:, :)
        !! Of the rods along themselves, (3, 0:n), A m^2, and its mean change over a sample, A m^2/s; of size 0 unless leakage is
        !! asked for
        real(dp), allocatable :: rate_squared(:)        !! mu/r^3, (0:2n), 1/s^2; 0 without an orbit
        real(dp), allocatable :: upwards(:, :)          !! r/|r|, inertial, (3, 0:2n)
        real(dp), allocatable :: airflow(:, :)          !! Along the velocity in the air, inertial, (3, 0:n)
        logical :: airflow_known = .false.              !! False: the body's x axis stands in
        real(dp) :: wave_frequency = 0                  !! Of the density wave, nominal, Hz; 0: none
        integer :: jump = huge(1)                       !! From which interval on FORCE_JUMP acts; huge(1): never
        real(dp) :: camera_from_body(3, 3, HEADS) = 0    !! Rotation matrix of each head: (3, 3, head)
        real(dp), allocatable :: shape(:, :, :)
        !! Torque by 1 of each of the parameters `shaped`, (3, 0:2n, parameter)
        integer, allocatable :: shaped(:)
        !! Of the rotational parameters those in which the torque is linear: what rods and field do that are not as believed
        integer, allocatable :: estimated(:)            !! Parameters whose partials are computed
        integer, allocatable :: rotational(:)           !! Those of them that act on the rotation
        integer, allocatable :: place(:)
        !! Where an estimated parameter stands among the rotational ones; 0: nowhere
    end type physical_model_t

    !> Values of all parameters. The angles are zero: q* holds the attitude.
    type :: model_state_t
        real(dp) :: quaternion(4) = [0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]   !! q* at t = 0, inertial to body
        real(dp) :: value(PARAMETERS) = 0    !! By the places of the parameters, in their units
    end type model_state_t

    !> The nominal rotation at k h with its partials by the model's `rotational` parameters.
    type :: model_trajectory_t
        real(dp), allocatable :: q(:, :)                !! (4, 0:n)
        real(dp), allocatable :: omega(:, :)            !! (3, 0:n), rad/s
        real(dp), allocatable :: omega_dot(:, :)        !! (3, 0:n), rad/s^2
        real(dp), allocatable :: partials(:, :, :)
        !! x, y, z of d zeta/dp, of d omega/dp and of d(d omega/dt)/dp: (rotational, 9, 0:n), those made up to a multiple
        !! of LANES
    end type model_trajectory_t

    integer, parameter :: PIECE_LENGTH = 32     !! Steps over which partials are carried at once

    !> The equations of the nominal rotation. State: q, omega.
    type, extends(rotation_t) :: nominal_rotation_t
        type(rigid_body_t) :: body                  !! With the state's inertia errors
        type(physical_model_t), pointer :: model => null()
        type(model_state_t), pointer :: state => null()
        type(model_trajectory_t), pointer :: trajectory => null()
    contains
        procedure :: rate => nominal_rate
        procedure :: keep => keep_nominal
    end type nominal_rotation_t

contains

    !> Prepares the model for an observation set's preprocessed data. Without an orbit that reaches
    !> over the arc there is no gravity gradient, of which data%warnings is told.
    subroutine prepare_model(knowledge, data, estimated, model)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(inout) :: data
        integer, intent(in) :: estimated(:)     !! Parameters whose partials shall be computed
        type(physical_model_t), intent(out) :: model

        integer :: j, n, head

        n = data%steps
        model%steps = n
        model%interval = data%interval
        model%inertia = knowledge%inertia
        allocate (model%magnetic_torque(3, 0:2*n), source=data%torque)
        allocate (model%dipole(3, 0:2*n), source=data%dipole)
        call take_gravity(data, model)
        do head = 1, HEADS
            model%camera_from_body(:, :, head) = rotation_matrix(knowledge%mounting(:, head))
        end do
        model%estimated = estimated
        model%rotational = pack(estimated, is_rotational(estimated))
        model%place = [(findloc(model%rotational, estimated(j), 1), j=1, size(estimated))]
        model%shaped = pack(model%rotational, has_shape(model%rotational))
        allocate (model%shape(3, 0:2*n, size(model%shaped)), source=0.0_dp)
        if (size(model%shaped) > 0) call take_torque_shapes(knowledge, data, model)
        call take_moments(knowledge, model)
    end subroutine prepare_model

    !> Is the torque linear in a parameter, by what it does to rods or field?
    elemental logical function has_shape(parameter)
        integer, intent(in) :: parameter        !! Its place

        select case (KIND_OF(parameter))
        case (OF_ROD_GAINS, OF_ROD_DELAYS, OF_ROD_FREQUENCIES, OF_ALL_RODS_DELAY, OF_ALL_RODS_FREQUENCY, OF_ROD_TURNS, &
              OF_ROD_SWAPS, OF_TORQUE_BENDS)
            has_shape = .true.
        case default
            has_shape = is_of_field(parameter)
        end select
    end function has_shape

    !> Does a parameter change the field in proportion to it?
    elemental logical function is_of_field(parameter)
        integer, intent(in) :: parameter        !! Its place

        is_of_field = any(KIND_OF(parameter) == [OF_FIELD_TURN, OF_FIELD_SCALES, OF_FIELD_SHEARS, OF_FIELD_SWAPS, &
                                                 OF_FIELD_DELAY])
    end function is_of_field

    !> What rods and magnetic field that are not as believed would do to the torque m x B.
    subroutine take_torque_shapes(knowledge, data, model)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(fitting_data_t), intent(in) :: data
        type(physical_model_t), intent(inout) :: model

        real(dp), parameter :: TURN_STEP = 1e-6_dp, FREQUENCY_STEP = 1e-7_dp    ! rad, Hz
        type(torque_rods_t) :: rods, other
        real(dp), dimension(3, 0:2*model%steps) :: along, up, down
        real(dp) :: direction(3)
        integer :: i, k

        rods = knowledge%rods
        rods%delay = rods%delay + knowledge%accelerometer_delay
        if (asked(OF_ROD_GAINS)) then
            other = rods
            other%gain = gain_unit(rods%gain)
            call follow(other, along)
            do i = 1, 3
                call add(along(i, :), rod_direction(rods, i), ROD_GAINS(i))
            end do
        end if
        if (asked(OF_ROD_DELAYS) .or. asked(OF_ALL_RODS_DELAY)) then
            ! steps of the spacing of the torque: a jump at an abrupt edge then falls on two places, whose weights in the
            ! Runge-Kutta steps are those of a step wherever they lie
            other = rods
            other%delay = rods%delay + model%interval/2
            call follow(other, up)
            other%delay = rods%delay - model%interval/2
            call follow(other, down)
            call add_to_each_and_all((up - down)/model%interval, ROD_DELAYS, ALL_RODS_DELAY)
        end if
        if (asked(OF_ROD_FREQUENCIES) .or. asked(OF_ALL_RODS_FREQUENCY)) then
            other = rods
            other%activations%frequency = rods%activations%frequency + FREQUENCY_STEP
            call follow(other, up)
            other%activations%frequency = rods%activations%frequency - FREQUENCY_STEP
            call follow(other, down)
            call add_to_each_and_all((up - down)/(2*FREQUENCY_STEP), ROD_FREQUENCIES, ALL_RODS_FREQUENCY)
        end if
        if (asked(OF_ROD_TURNS) .or. asked(OF_ROD_SWAPS)) call follow(rods, along)
        do i = 1, merge(size(ROD_TURNS), 0, asked(OF_ROD_TURNS))
            k = (i + 1)/2
            other = rods
            other%misalignment(i) = rods%misalignment(i) + TURN_STEP
            direction = rod_direction(other, k)
            other%misalignment(i) = rods%misalignment(i) - TURN_STEP
            call add(along(k, :), (direction - rod_direction(other, k))/(2*TURN_STEP), ROD_TURNS(i))
        end do
        do i = 1, merge(3, 0, asked(OF_ROD_SWAPS))
            other = rods
            call interchange_rods(other, i, modulo(i, 3) + 1)
            call follow(other, up)
            do k = 1, 3
                call add(up(k, :) - along(k, :), rod_direction(rods, k), ROD_SWAPS(i))
            end do
        end do
        do i = 1, size(model%shaped)
            if (is_of_field(model%shaped(i))) call take_field_shape(data, model, i)
            if (KIND_OF(model%shaped(i)) == OF_TORQUE_BENDS) call take_bent_torque(model, i)
        end do

    contains

        !> Are parameters of a kind among those asked for?
        logical function asked(kind)
            integer, intent(in) :: kind

            asked = any(KIND_OF(model%shaped) == kind)
        end function asked

        !> The moments of the rods along themselves at the times of the torque.
        subroutine follow(some, moments)
            type(torque_rods_t), intent(in) :: some
            real(dp), intent(out) :: moments(3, 0:2*model%steps)

            integer :: j

            do j = 0, 2*model%steps
                moments(:, j) = rod_moments(some, j*model%interval/2)
            end do
        end subroutine follow

        !> Adds the torque of changes of the moments to the parameter of each rod and to that of all.
        subroutine add_to_each_and_all(change, of_each, of_all)
            real(dp), intent(in) :: change(3, 0:2*model%steps)
            integer, intent(in) :: of_each(3), of_all

            integer :: rod

            do rod = 1, 3
                call add(change(rod, :), rod_direction(rods, rod), of_each(rod))
                call add(change(rod, :), rod_direction(rods, rod), of_all)
            end do
        end subroutine add_to_each_and_all

        !> Adds the torque of a moment of one direction to the shape of a parameter, if that is asked for.
        subroutine add(moment, direction_of, parameter)
            real(dp), intent(in) :: moment(0:2*model%steps), direction_of(3)
            integer, intent(in) :: parameter

            integer :: j, place

            place = findloc(model%shaped, parameter, 1)
            if (place == 0) return
            do j = 0, 2*model%steps
                model%shape(:, j, place) = model%shape(:, j, place) + moment(j)*cross(direction_of, data%field(:, j + 1))
            end do
        end subroutine add
    end subroutine take_torque_shapes

    !> A torque along Legendre's polynomial of degree 2 or 3 over the arc.
    pure subroutine take_bent_torque(model, place)
        type(physical_model_t), intent(inout) :: model
        integer, intent(in) :: place            ! Among model%shaped

        real(dp) :: x
        integer :: axis, j

        axis = (MEMBER_OF(model%shaped(place)) + 1)/2
        do j = 0, 2*model%steps
            x = real(j, dp)/model%steps - 1
            model%shape(axis, j, place) = merge((3*x**2 - 1)/2, (5*x**3 - 3*x)/2, mod(MEMBER_OF(model%shaped(place)), 2) == 1)
        end do
    end subroutine take_bent_torque

    !> The moments of the rods where their leakage is asked for, and how they change over a sample.
    subroutine take_moments(knowledge, model)
        type(operator_knowledge_t), intent(in) :: knowledge
        type(physical_model_t), intent(inout) :: model

        type(torque_rods_t) :: rods
        integer :: k, n

        n = -1
        if (any(is_leakage(model%estimated))) n = model%steps
        allocate (model%moment(3, 0:n), model%moment_rate(3, 0:n))
        rods = knowledge%rods
        rods%delay = rods%delay + knowledge%accelerometer_delay
        do k = 0, n
            associate (t => k*model%interval, half => model%interval/2)
                model%moment(:, k) = rod_moments(rods, t)
                model%moment_rate(:, k) = (rod_moments(rods, t + half) - rod_moments(rods, t - half))/model%interval
            end associate
        end do
    end subroutine take_moments

    !> Does a parameter act by the moments of the rods beside their torque?
    elemental logical function is_leakage(parameter)
        integer, intent(in) :: parameter        !! Its place

        is_leakage = any(KIND_OF(parameter) == [OF_LEAKAGE, OF_LEAKAGE_RATE, OF_CHANNEL_LEAKAGE, OF_CHANNEL_LEAKAGE_RATE])
    end function is_leakage

    !> The torque by a change of the field by 1 of a parameter, m x dB/dp. Samples that are tagged late show the field of an
    !> earlier time: that at t stands at t + delay.
    pure subroutine take_field_shape(data, model, place)
        type(fitting_data_t), intent(in) :: data
        type(physical_model_t), intent(inout) :: model
        integer, intent(in) :: place            ! Among model%shaped

        real(dp) :: change(3)
        integer :: i, next, before, after, j

        i = MEMBER_OF(model%shaped(place))
        next = modulo(i, 3) + 1
        do j = 0, 2*model%steps
            change = 0
            associate (b => data%field(:, j + 1))
                select case (KIND_OF(model%shaped(place)))
                case (OF_FIELD_TURN)
                    change = turned_about(i, b)
                case (OF_FIELD_SCALES)
                    change(i) = -b(i)
                case (OF_FIELD_SHEARS)
                    change([i, next]) = -b([next, i])
                case (OF_FIELD_SWAPS)
                    change([i, next]) = b([next, i]) - b([i, next])
                case (OF_FIELD_DELAY)
                    before = max(0, j - 1)
                    after = min(2*model%steps, j + 1)
                    change = (data%field(:, after + 1) - data%field(:, before + 1))/((after - before)*model%interval/2)
                end select
            end associate
            model%shape(:, j, place) = cross(model%dipole(:, j), change)
        end do
    end subroutine take_field_shape

    !> mu/r^3, the direction upwards and that of the airflow along the orbit.
    subroutine take_gravity(data, model)
        type(fitting_data_t), intent(inout) :: data
        type(physical_model_t), intent(inout) :: model

        type(interpolation_t) :: place
        real(dp) :: position(3), t
        integer :: j

        associate (n => model%steps)
            allocate (model%rate_squared(0:2*n), source=0.0_dp)
            allocate (model%upwards(3, 0:2*n), source=0.0_dp)
            allocate (model%airflow(3, 0:n), source=0.0_dp)
            if (size(data%orbit_time) == 0) then
                call append(data%warnings, 'no orbit: the gravity gradient is left out of rotation and '// &
                            'acceleration')
                return
            end if
            do j = 0, 2*n
                t = j*model%interval/2
                place = interpolation_at(data%orbit_time, t, model%interval, LONGEST_ORBIT_SPACING)
                if (.not. place%supported) then
                    call append(data%warnings, 'orbit: no positions around '//number_text(t)// &
                                ' s: the gravity gradient is left out of rotation and acceleration')
                    model%rate_squared = 0
                    return
                end if
                position = cubic_interpolated(data%orbit_time, data%orbit_position, t)
                model%rate_squared(j) = EARTH_GM/norm2(position)**3
                model%upwards(:, j) = unit(position)
                if (mod(j, 2) == 0) model%airflow(:, j/2) = unit(velocity_in_air(position, t))
            end do
            model%airflow_known = .true.
        end associate

    contains

        !> Relative to air that turns with the Earth; the orbit's velocity by differences over 2 s.
        pure function velocity_in_air(position, t) result(velocity)
            real(dp), intent(in) :: position(3), t
            real(dp) :: velocity(3)

            real(dp), parameter :: STEP = 1         ! s

            velocity = (cubic_interpolated(data%orbit_time, data%orbit_position, t + STEP) - &
                        cubic_interpolated(data%orbit_time, data%orbit_position, t - STEP))/(2*STEP) - &
                       EARTH_ROTATION_RATE*[-position(2), position(1), 0.0_dp]
        end function velocity_in_air
    end subroutine take_gravity

    !> The first guess.
    pure function initial_state(data, options) result(state)
        type(fitting_data_t), intent(in) :: data            !! Has that of the rotation
        type(estimation_options_t), intent(in) :: options   !! Has that of the offset
        type(model_state_t) :: state

        state%quaternion = data%guess_quaternion
        state%value(RATE) = data%guess_angular_velocity
        state%value(OFFSET) = options%guess_offset
    end function initial_state

    !> Applies corrections to the estimated parameters: angles turn the attitude, the others add.
    pure subroutine correct_state(model, correction, state)
        type(physical_model_t), intent(in) :: model
        real(dp), intent(in) :: correction(:)           !! In the order of model%estimated
        type(model_state_t), intent(inout) :: state

        state%value(model%estimated) = state%value(model%estimated) + correction
        state%quaternion = turned_by(state%value(ATTITUDE_ANGLES), state%quaternion)
        state%value(ATTITUDE_ANGLES) = 0
    end subroutine correct_state

    !> Attitude and estimated parameters, for the history of a fit.
    subroutine describe_model_state(model, state, note)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(iteration_t), intent(inout) :: note

        integer, allocatable :: others(:)
        integer :: i

        others = pack(model%estimated, [(all(ATTITUDE_ANGLES /= model%estimated(i)), i=1, size(model%estimated))])
        note%state_names = [character(12) :: 'q1', 'q2', 'q3', 'q4', parameter_names(others)]
        note%state = [state%quaternion, state%value(others)]
    end subroutine describe_model_state

    !> The attitude after a turn by a rotation vector: R = exp(-[zeta x]) R(q), the exact form of
    !> C(zeta) R(q*).
    pure function turned_by(zeta, q) result(turned)
        real(dp), intent(in) :: zeta(3)         !! Body axes, rad
        real(dp), intent(in) :: q(4)            !! Inertial to body
        real(dp) :: turned(4)

        real(dp) :: half

        half = norm2(zeta)/2
        turned = normalised(quaternion_product([zeta/2*sinc(half), cos(half)], q))
    end function turned_by

    !> The rotation vector zeta that turns `from` into `to`: the inverse of turned_by.
    pure function turn_between(from, to) result(zeta)
        real(dp), intent(in) :: from(4), to(4)    !! Inertial to body
        real(dp) :: zeta(3)                     !! rad

        real(dp) :: p(4)

        p = quaternion_product(to, conjugate_quaternion(from))
        if (p(4) < 0) p = -p
        zeta = 2*p(1:3)/sinc(atan2(norm2(p(1:3)), p(4)))
    end function turn_between

    !> sin(x)/x
    pure real(dp) function sinc(x)
        real(dp), intent(in) :: x    !! rad

        sinc = 1
        if (abs(x) > tiny(1.0_dp)) sinc = sin(x)/x
    end function sinc

    !> The body with the state's inertia errors.
    pure function body_of(model, state) result(body)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(rigid_body_t) :: body

        real(dp) :: tensor(3, 3)
        integer :: i

        tensor = model%inertia
        do i = 1, 6
            tensor = tensor + state%value(INERTIA(i))*unit_inertia(i)
        end do
        body = new_rigid_body(tensor)
    end function body_of

    !> dJ/dp of element i of INERTIA.
    pure function unit_inertia(i) result(j)
        integer, intent(in) :: i
        real(dp) :: j(3, 3)

        j = 0
        j(ELEMENT_ROW(i), ELEMENT_COLUMN(i)) = 1
        j(ELEMENT_COLUMN(i), ELEMENT_ROW(i)) = 1
    end function unit_inertia

    !> Integrates the nominal rotation and the variational equations; without partials, the rotation alone.
    subroutine integrate_trajectory(model, state, trajectory, without_partials)
        type(physical_model_t), intent(in), target :: model
        type(model_state_t), intent(in), target :: state
        type(model_trajectory_t), intent(inout), target :: trajectory     !! Reused if it has the right shape
        logical, intent(in), optional :: without_partials   !! None are integrated

        type(nominal_rotation_t) :: rotation
        integer :: parameters

        parameters = size(model%rotational)
        if (present(without_partials)) parameters = merge(0, parameters, without_partials)
        call shape_trajectory(model%steps, lanes_of(parameters), trajectory)
        rotation%steps = model%steps
        rotation%interval = model%interval
        rotation%quaternion = 1
        rotation%body = body_of(model, state)
        rotation%model => model
        rotation%state => state
        rotation%trajectory => trajectory
        call rotation%integrate([state%quaternion, state%value(RATE)])
        if (parameters > 0) call carry_partials(model, state, rotation%body, trajectory)
    end subroutine integrate_trajectory

    pure subroutine nominal_rate(self, half, n, y, dydt)
        class(nominal_rotation_t), intent(in) :: self
        integer, intent(in) :: half, n
        real(dp), intent(in) :: y(n)
        real(dp), intent(out) :: dydt(n)

        real(dp) :: c(3)

        c = turned_into(y(:4), self%model%upwards(:, half))/sum(y(:4)**2)
        dydt(:4) = quaternion_rate(y(:4), y(5:))
        dydt(5:) = times(self%body%inverse_inertia, torque_at(self%model, self%state, self%body, half, c) - &
                         crossed(y(5:), times(self%body%inertia, y(5:))))       ! (4-1), (4-7)
    end subroutine nominal_rate

    subroutine keep_nominal(self, k, n, y, dydt)
        class(nominal_rotation_t), intent(inout) :: self
        integer, intent(in) :: k, n
        real(dp), intent(in) :: y(n), dydt(n)

        self%trajectory%q(:, k) = y(:4)
        self%trajectory%omega(:, k) = y(5:)
        self%trajectory%omega_dot(:, k) = dydt(5:)
    end subroutine keep_nominal

    pure subroutine shape_trajectory(n, lanes, trajectory)
        integer, intent(in) :: n, lanes
        type(model_trajectory_t), intent(inout) :: trajectory

        if (allocated(trajectory%q)) then
            if (all(shape(trajectory%partials) == [lanes, 9, n + 1])) return
            deallocate (trajectory%q, trajectory%omega, trajectory%omega_dot, trajectory%partials)
        end if
        allocate (trajectory%q(4, 0:n), trajectory%omega(3, 0:n), trajectory%omega_dot(3, 0:n), trajectory%partials(lanes, 9, 0:n))
    end subroutine shape_trajectory

    !> All torques at a half step.
    pure function torque_at(model, state, body, half, c) result(acting)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(rigid_body_t), intent(in) :: body
        integer, intent(in) :: half
        real(dp), intent(in) :: c(3)        ! upwards, body axes
        real(dp) :: acting(3)

        integer :: i

        acting = (1 + state%value(ROD_GAIN))*(model%magnetic_torque(:, half) - &
                                              crossed(model%dipole(:, half), state%value(FIELD_BIAS))) + &
                 3*model%rate_squared(half)*crossed(c, times(body%inertia, c)) + state%value(TORQUE) + &
                 (half/(2.0_dp*model%steps) - 0.5_dp)*state%value(TORQUE_CHANGE)
        do i = 1, size(model%shaped)
            acting = acting + state%value(model%shaped(i))*model%shape(:, half, i)
        end do
    end function torque_at

    !> The partials along the nominal rotation: d zeta/dt = -omega x zeta + d omega, d(d omega)/dt = A zeta + B d omega +
    !> J^-1 dT/dp, by the same method of Runge and Kutta. Between the epochs A and B are those of the mean of the attitudes
    !> and of the rate that its derivatives let expect, not of the stages: that changes predicted sigmas by 1e-12 of themselves.
    subroutine carry_partials(model, state, body, trajectory)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(rigid_body_t), intent(in) :: body
        type(model_trajectory_t), intent(inout) :: trajectory

        real(dp), dimension(3, 0:2*PIECE_LENGTH) :: omega, omega_dot, c
        real(dp), dimension(3, 3, 0:2*PIECE_LENGTH) :: by_angles, by_rate
        real(dp) :: driving(size(trajectory%partials, 1), 3, 0:2*PIECE_LENGTH), q(4)
        integer, allocatable :: places(:)
        integer :: i, k, first, last, half
        logical :: inertia_changes

        associate (x => trajectory%partials(:, :, 0), p => size(model%rotational))
            x = 0
            do i = 1, 3
                where (model%rotational == ATTITUDE_ANGLES(i)) x(:p, i) = 1
                where (model%rotational == RATE(i)) x(:p, 3 + i) = 1
            end do
            places = pack([(i, i=1, p)], [(all([ATTITUDE_ANGLES, RATE] /= model%rotational(i)), i=1, p)])
        end associate
        driving = 0
        inertia_changes = any(KIND_OF(model%rotational) == OF_INERTIA)
        do first = 0, max(0, model%steps - 1), PIECE_LENGTH
            last = min(first + PIECE_LENGTH, model%steps)
            do half = 2*first, 2*last
                k = half/2
                i = half - 2*first
                q = trajectory%q(:, k)
                omega(:, i) = trajectory%omega(:, k)
                if (mod(half, 2) == 1) then
                    q = q + trajectory%q(:, k + 1)
                    omega(:, i) = (omega(:, i) + trajectory%omega(:, k + 1))/2 + model%interval/8* &
                                  (trajectory%omega_dot(:, k) - trajectory%omega_dot(:, k + 1))
                end if
                c(:, i) = turned_into(q, model%upwards(:, half))/sum(q**2)
                call linear_rates(body, 3*model%rate_squared(half), omega(:, i), c(:, i), by_angles(:, :, i), by_rate(:, :, i))
                if (inertia_changes) omega_dot(:, i) = &
                    body%angular_acceleration(torque_at(model, state, body, half, c(:, i)), omega(:, i))
            end do
            do i = 1, size(places)
                call take_driving(model, state, body, model%rotational(places(i)), 2*first, 2*(last - first), omega, &
                                  omega_dot, c, driving(places(i), :, :))
            end do
            call lanes_carry(size(driving, 1), last - first, model%interval, omega, by_angles, by_rate, driving, &
                             trajectory%partials(:, :, first:last))
        end do
    end subroutine carry_partials

    !> The partials of d omega/dt by the angles and by the rate: c changes by c x zeta,
    !> A = 3 mu/r^3 J^-1 ([c x] J - [J c x]) [c x], and B = J^-1 ([J omega x] - [omega x] J), (4-11), (4-14).
    pure subroutine linear_rates(body, three_mu, omega, c, by_angles, by_rate)
        type(rigid_body_t), intent(in) :: body
        real(dp), intent(in) :: three_mu, omega(3), c(3)        ! 3 mu/r^3; body axes
        real(dp), intent(out), dimension(3, 3) :: by_angles, by_rate

        real(dp) :: by_c(3, 3), jc(3), j_omega(3)
        integer :: k

        associate (j => body%inertia)
            jc = times(j, c)
            j_omega = times(j, omega)
            do k = 1, 3
                by_c(:, k) = crossed(c, j(:, k))
                by_rate(:, k) = -crossed(omega, j(:, k))
            end do
        end associate
        call add_cross_matrix(-1.0_dp, jc, by_c)
        call add_cross_matrix(1.0_dp, j_omega, by_rate)
        by_angles(:, 1) = by_c(:, 2)*c(3) - by_c(:, 3)*c(2)
        by_angles(:, 2) = by_c(:, 3)*c(1) - by_c(:, 1)*c(3)
        by_angles(:, 3) = by_c(:, 1)*c(2) - by_c(:, 2)*c(1)
        do k = 1, 3
            by_angles(:, k) = three_mu*times(body%inverse_inertia, by_angles(:, k))
            by_rate(:, k) = times(body%inverse_inertia, by_rate(:, k))
        end do
    end subroutine linear_rates

    !> Adds f [v x] to a matrix.
    pure subroutine add_cross_matrix(f, v, matrix)
        real(dp), intent(in) :: f, v(3)
        real(dp), intent(inout) :: matrix(3, 3)

        matrix(2, 1) = matrix(2, 1) + f*v(3)
        matrix(3, 1) = matrix(3, 1) - f*v(2)
        matrix(1, 2) = matrix(1, 2) - f*v(3)
        matrix(3, 2) = matrix(3, 2) + f*v(1)
        matrix(1, 3) = matrix(1, 3) + f*v(2)
        matrix(2, 3) = matrix(2, 3) - f*v(1)
    end subroutine add_cross_matrix

    !> What the change of a parameter by 1 adds to d omega/dt over some half steps.
    pure subroutine take_driving(model, state, body, parameter, first, count, omega, omega_dot, c, driving)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(rigid_body_t), intent(in) :: body
        integer, intent(in) :: parameter, first, count      ! half steps first, ..., first + count
        real(dp), intent(in), dimension(3, 0:count) :: omega, omega_dot, c  ! omega_dot for INERTIA alone
        real(dp), intent(inout) :: driving(:, 0:)

        real(dp) :: acting(3), axis(3), dj(3, 3)
        integer :: i, half, place

        acting = 0
        axis = 0
        axis(mod(MEMBER_OF(parameter) - 1, 3) + 1) = 1
        if (KIND_OF(parameter) == OF_INERTIA) dj = unit_inertia(MEMBER_OF(parameter))
        place = findloc(model%shaped, parameter, 1)
        do i = 0, count
            half = first + i
            select case (KIND_OF(parameter))
            case (OF_TORQUE)
                acting = axis
            case (OF_TORQUE_CHANGE)
                acting = (half/(2.0_dp*model%steps) - 0.5_dp)*axis
            case (OF_ROD_GAIN)
                acting = model%magnetic_torque(:, half) - crossed(model%dipole(:, half), state%value(FIELD_BIAS))
            case (OF_FIELD_BIAS)
                acting = -(1 + state%value(ROD_GAIN))*crossed(model%dipole(:, half), axis)
            case (OF_INERTIA)
                acting = 3*model%rate_squared(half)*crossed(c(:, i), times(dj, c(:, i))) - times(dj, omega_dot(:, i)) - &
                         crossed(omega(:, i), times(dj, omega(:, i)))
            case default
                acting = model%shape(:, half, place)
            end select
            driving(:, i) = times(body%inverse_inertia, acting)
        end do
    end subroutine take_driving

    !> `transformed` of gracecg_base_vectors once more, in this file: so the compiler puts it in line in inner loops.
    pure function times(m, v)
        real(dp), intent(in) :: m(3, 3), v(3)
        real(dp) :: times(3)

        times = m(:, 1)*v(1) + m(:, 2)*v(2) + m(:, 3)*v(3)
    end function times

    !> A vector in the axes that a quaternion q turns into, times q^2; the product of the rotation matrix likewise.
    pure function turned_into(q, v) result(turned)
        real(dp), intent(in) :: q(4), v(3)
        real(dp) :: turned(3)

        real(dp) :: across(3)

        across = crossed(q(:3), v) - q(4)*v
        turned = crossed(q(:3), across) + (q(1)*v(1) + q(2)*v(2) + q(3)*v(3))*q(:3) - q(4)*across
    end function turned_into

    !> `cross` likewise.
    pure function crossed(a, b)
        real(dp), intent(in) :: a(3), b(3)
        real(dp) :: crossed(3)

        crossed = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
    end function crossed

    !> What the accelerometer would show at the samples' epochs, and the partials of the estimated
    !> parameters.
    pure subroutine predict_accelerations(model, state, trajectory, epoch, predicted, partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory    !! Of this state
        integer, intent(in) :: epoch(:)                 !! k of each sample
        real(dp), intent(out), optional :: predicted(:, :)      !! (3, samples), m/s^2
        real(dp), intent(out), optional :: partials(:, :, :)    !! (estimated, 3, samples)

        real(dp) :: factor(3), unscaled(3), matrix(3, 3), changes(3, 4), drag(3), along(3), bends(size(FORCE_BENDS)), shown(3), t
        logical :: drag_changes, side_forces, bent
        integer, allocatable :: linear(:)
        integer :: i, k, n

        linear = pack(model%estimated, is_of_instrument(model%estimated) .and. abs(state%value(model%estimated)) > 0)
        factor = 1 + state%value(SCALE_FACTORS)
        drag_changes = model%wave_frequency > 0 .or. any(model%estimated == DRAG_CURVATURE)
        side_forces = any(model%estimated == SIDE_FORCE(1))
        bent = any(abs(state%value(FORCE_BENDS)) > 0) .or. &
               any(KIND_OF(model%estimated) == OF_FORCE_BENDS)
        changes = 0
        drag = 0
        bends = 0
        do i = 1, size(epoch)
            k = epoch(i)
            t = k*model%interval
            matrix = acceleration_matrix(model, trajectory, k)
            along = airflow_at(model, trajectory%q(:, k), k)
            if (drag_changes) then
                changes = drag_partials(model, state, along, k)
                drag = changes(:, 1)*state%value(DRAG_CURVATURE) + changes(:, 2)*state%value(WAVE_SINE) + &
                       changes(:, 3)*state%value(WAVE_COSINE)
                drag(2:) = drag(2:) + state%value(AIRFLOW_TURN)*dot_product(along, drag)
            end if
            unscaled = times(matrix, state%value(OFFSET)) + state%value(DRIFT)*t + state%value(BIAS) + drag
            if (k >= model%jump) unscaled = unscaled + state%value(FORCE_JUMP)
            shown = factor*unscaled
            if (side_forces) shown(1) = shown(1) + along(2)*state%value(SIDE_FORCE(1)) + along(3)*state%value(SIDE_FORCE(2))
            if (bent) then
                bends = bends_at(model, k)
                do n = 1, size(FORCE_BENDS)
                    shown(BEND_AXIS(n)) = shown(BEND_AXIS(n)) + bends(n)*state%value(FORCE_BENDS(n))
                end do
            end if
            do n = 1, size(linear)
                shown = shown + state%value(linear(n))* &
                        instrument_partial(model, state, trajectory, k, linear(n), factor, unscaled)
            end do
            if (present(predicted)) predicted(:, i) = shown
            if (present(partials)) &
                call acceleration_partials(model, state, trajectory, k, factor, matrix, unscaled, &
                                           drag, changes, along, bends, partials(:, :, i))
        end do
    end subroutine predict_accelerations

    !> What the angular channels would show at the samples' epochs, S d omega/dt + bias + drift t + L m + K dm/dt, and the
    !> partials of the estimated parameters.
    pure subroutine predict_channels(model, state, trajectory, epoch, predicted, partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory      !! Of this state
        integer, intent(in) :: epoch(:)                         !! k of each sample
        real(dp), intent(out) :: predicted(:, :)                !! (3, samples), rad/s^2
        real(dp), intent(out), optional :: partials(:, :, :)    !! (estimated, 3, samples)

        real(dp) :: scales(3, 3), weight(3, 9), slope(3), rotational(size(model%rotational), 3), partial(3)
        integer :: i, j, k, axis, from, before, after

        scales = transpose(reshape(state%value(CHANNEL_SCALES), [3, 3]))
        do i = 1, 3
            scales(i, i) = scales(i, i) + 1
        end do
        weight = 0
        weight(:, 7:9) = scales
        do j = 1, size(epoch)
            k = epoch(j)
            before = max(0, k - 1)
            after = min(model%steps, k + 1)
            slope = (trajectory%omega_dot(:, after) - trajectory%omega_dot(:, before))/((after - before)*model%interval)
            predicted(:, j) = times(scales, trajectory%omega_dot(:, k) - state%value(SAMPLING_DELAY)*slope) + &
                              state%value(CHANNEL_BIAS) + state%value(CHANNEL_DRIFT)*(k*model%interval)
            if (size(model%moment) > 0) predicted(:, j) = predicted(:, j) + &
                matmul(model%moment(:, k), reshape(state%value(CHANNEL_LEAKAGE), [3, 3])) + &
                matmul(model%moment_rate(:, k), reshape(state%value(CHANNEL_LEAKAGE_RATE), [3, 3]))
            if (.not. present(partials)) cycle
            if (any(model%place > 0)) call combine_columns(trajectory%partials(:, :, k), weight, rotational)
            do i = 1, size(model%estimated)
                associate (p => model%estimated(i))
                    partial = 0
                    axis = (MEMBER_OF(p) + 2)/3
                    from = mod(MEMBER_OF(p) - 1, 3) + 1
                    select case (KIND_OF(p))
                    case (OF_CHANNEL_BIAS)
                        partial(from) = 1
                    case (OF_CHANNEL_DRIFT)
                        partial(from) = k*model%interval
                    case (OF_CHANNEL_SCALES)
                        partial(axis) = trajectory%omega_dot(from, k)
                    case (OF_CHANNEL_LEAKAGE)
                        partial(axis) = model%moment(from, k)
                    case (OF_CHANNEL_LEAKAGE_RATE)
                        partial(axis) = model%moment_rate(from, k)
                    case (OF_SAMPLING_DELAY)
                        partial = -times(scales, slope)
                    case default
                        if (model%place(i) > 0) partial = rotational(model%place(i), :)
                    end select
                    partials(i, :, j) = partial
                end associate
            end do
        end do
    end subroutine predict_channels

    !> A~ + G at k h.
    pure function acceleration_matrix(model, trajectory, k) result(matrix)
        type(physical_model_t), intent(in) :: model
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k
        real(dp) :: matrix(3, 3)

        matrix = offset_matrix(trajectory%omega(:, k), trajectory%omega_dot(:, k))
        if (model%rate_squared(2*k) > 0) &
            matrix = matrix + gravity_gradient_matrix(model%rate_squared(2*k), vertical_at(model, trajectory, k))
    end function acceleration_matrix

    pure function vertical_at(model, trajectory, k) result(c)
        type(physical_model_t), intent(in) :: model
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k
        real(dp) :: c(3)            !! Upwards, body axes

        c = turned_into(trajectory%q(:, k), model%upwards(:, 2*k))
    end function vertical_at

    !> The unscaled acceleration along the airflow that is no straight line by its parameters: curvature,
    !> sine, cosine, frequency. The curvature's is Legendre's polynomial of degree 2 over the arc.
    pure function drag_partials(model, state, along, k) result(partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        real(dp), intent(in) :: along(3)    !! The direction of the airflow
        integer, intent(in) :: k
        real(dp) :: partials(3, 4)          !! (axis, parameter); the last one in m/s^2/Hz

        real(dp) :: angle, t, x

        t = k*model%interval
        x = 2*real(k, dp)/model%steps - 1
        angle = TWO_PI*(model%wave_frequency + state%value(WAVE_FREQUENCY))*t
        partials(:, 1) = along*(3*x**2 - 1)/2
        partials(:, 2) = along*sin(angle)
        partials(:, 3) = along*cos(angle)
        partials(:, 4) = along*TWO_PI*t*(state%value(WAVE_SINE)*cos(angle) - state%value(WAVE_COSINE)*sin(angle))
    end function drag_partials

    !> The polynomials of FORCE_BENDS at k h.
    pure function bends_at(model, k) result(values)
        type(physical_model_t), intent(in) :: model
        integer, intent(in) :: k
        real(dp) :: values(size(FORCE_BENDS))

        real(dp) :: x, polynomial(0:6)
        integer :: n

        x = 2*real(k, dp)/model%steps - 1
        polynomial(0) = 1
        polynomial(1) = x
        do n = 1, 5         ! Bonnet's recursion
            polynomial(n + 1) = ((2*n + 1)*x*polynomial(n) - n*polynomial(n - 1))/(n + 1)
        end do
        do n = 1, size(values)
            values(n) = polynomial(BEND_DEGREE(n))
        end do
    end function bends_at

    !> The direction of the airflow at k h.
    pure function airflow_at(model, q, k) result(along)
        type(physical_model_t), intent(in) :: model
        real(dp), intent(in) :: q(4)            !! Attitude, inertial to body
        integer, intent(in) :: k    !! The epoch, in intervals
        real(dp) :: along(3)                    !! Unit vector, body axes

        along = [1.0_dp, 0.0_dp, 0.0_dp]
        if (model%airflow_known) along = turned_into(q, model%airflow(:, k))
    end function airflow_at

    pure subroutine acceleration_partials(model, state, trajectory, k, factor, matrix, unscaled, drag, changes, &
                                          along, bends, partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k
        real(dp), intent(in) :: factor(3), matrix(3, 3), unscaled(3)
        real(dp), intent(in) :: drag(3)             !! That is no straight line
        real(dp), intent(in) :: changes(3, 4)       !! Of drag_partials
        real(dp), intent(in) :: along(3)            !! The direction of the airflow
        real(dp), intent(in) :: bends(size(FORCE_BENDS))    !! The polynomials
        real(dp), intent(out) :: partials(:, :)     !! (estimated, 3)

        real(dp) :: d(3), by_rate(3, 3), by_angles(3, 3), by_acceleration(3, 3), c(3), d_by_c(3), weight(3, 9)
        real(dp) :: rotational(size(model%rotational), 3)
        integer :: i, axis

        ! Not by associate: a vector subscript as its selector stops flang 22
        d = state%value(OFFSET)
        associate (t => k*model%interval)
            by_rate = offset_rate_partials(trajectory%omega(:, k), d)
            by_acceleration = -cross_matrix(d)
            by_angles = 0
            if (model%rate_squared(2*k) > 0) then
                c = vertical_at(model, trajectory, k)
                ! G d = mu/r^3 (d - 3 (c.d) c), and c changes by c x zeta
                d_by_c = crossed(d, c)
                by_angles = dot_product(c, d)*cross_matrix(c)
                do i = 1, 3
                    by_angles(:, i) = -3*model%rate_squared(2*k)*(by_angles(:, i) + c*d_by_c(i))
                end do
            end if
            if (model%airflow_known) by_angles = by_angles + cross_matrix(drag)
            do i = 1, 3
                weight(:, i) = factor*by_angles(:, i)
                weight(:, 3 + i) = factor*by_rate(:, i)
                weight(:, 6 + i) = factor*by_acceleration(:, i)
            end do
            ! a rotation without partials is enough for parameters that do not act on it
            if (any(model%place > 0)) call combine_columns(trajectory%partials(:, :, k), weight, rotational)
            partials = 0
            do i = 1, size(model%estimated)
                associate (p => model%estimated(i), r => model%place(i))
                    if (r > 0) then
                        partials(i, :) = rotational(r, :)
                        cycle
                    end if
                    axis = mod(MEMBER_OF(p) - 1, 3) + 1
                    select case (KIND_OF(p))
                    case (OF_OFFSET)
                        partials(i, :) = factor*matrix(:, axis)
                    case (OF_DRIFT)
                        partials(i, axis) = factor(axis)*t
                    case (OF_BIAS)
                        partials(i, axis) = factor(axis)
                    case (OF_SCALE_FACTORS)
                        partials(i, axis) = unscaled(axis)
                    case (OF_DRAG_CURVATURE, OF_WAVE_SINE, OF_WAVE_COSINE, OF_WAVE_FREQUENCY)
                        partials(i, :) = factor*changes(:, p - DRAG_CURVATURE + 1)
                    case (OF_FORCE_BENDS)
                        partials(i, BEND_AXIS(MEMBER_OF(p))) = bends(MEMBER_OF(p))
                    case (OF_FORCE_JUMP)
                        if (k >= model%jump) partials(i, axis) = factor(axis)
                    case (OF_SIDE_FORCE)
                        partials(i, 1) = along(1 + MEMBER_OF(p))
                    case (OF_AIRFLOW_TURN)
                        axis = 1 + MEMBER_OF(p)
                        partials(i, axis) = factor(axis)*dot_product(along, drag)
                    case default
                        if (is_of_instrument(p)) &
                            partials(i, :) = instrument_partial(model, state, trajectory, k, p, factor, unscaled)
                    end select
                end associate
            end do
        end associate
    end subroutine acceleration_partials

    !> Is a parameter an error of the accelerometer that acts in proportion to its partial?
    elemental logical function is_of_instrument(parameter)
        integer, intent(in) :: parameter        !! Its place

        is_of_instrument = any(KIND_OF(parameter) == [OF_ACCELEROMETER_DELAYS, OF_ACCELEROMETER_TURN, OF_ACCELEROMETER_SWAPS, &
                                                      OF_SAMPLING_DELAY, OF_LEAKAGE, OF_LEAKAGE_RATE])
    end function is_of_instrument

    !> What the accelerometer shows by 1 of such a parameter.
    pure function instrument_partial(model, state, trajectory, k, parameter, factor, unscaled) result(partial)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k                    ! Epoch
        integer, intent(in) :: parameter            ! Its place
        real(dp), intent(in) :: factor(3), unscaled(3)      ! Scale factors, m/s^2
        real(dp) :: partial(3)                      ! m/s^2 by its unit

        real(dp) :: slope(3)
        integer :: axis, other

        axis = MEMBER_OF(parameter)
        other = modulo(axis, 3) + 1
        partial = 0
        select case (KIND_OF(parameter))
        case (OF_ACCELEROMETER_DELAYS)
            slope = acceleration_slope(model, state, trajectory, k)
            partial(axis) = -factor(axis)*slope(axis)
        case (OF_ACCELEROMETER_TURN)
            partial = factor*turned_about(axis, unscaled)
        case (OF_ACCELEROMETER_SWAPS)
            partial(axis) = factor(other)*unscaled(other) - factor(axis)*unscaled(axis)
            partial(other) = -partial(axis)
        case (OF_SAMPLING_DELAY)
            partial = -factor*acceleration_slope(model, state, trajectory, k)
        case (OF_LEAKAGE)
            partial((axis + 2)/3) = model%moment(mod(axis - 1, 3) + 1, k)
        case (OF_LEAKAGE_RATE)
            partial((axis + 2)/3) = model%moment_rate(mod(axis - 1, 3) + 1, k)
        end select
    end function instrument_partial

    !> What three numbers change by with the parameters of the rotation: columns times their weights.
    pure subroutine combine_columns(columns, weight, combined)
        real(dp), contiguous, intent(in) :: columns(:, :)   ! of zeta, omega and d omega/dt: (lanes, 9)
        real(dp), intent(in) :: weight(3, 9)
        real(dp), contiguous, intent(out) :: combined(:, :)

        integer :: i, l

        do i = 1, 3
            do l = 1, size(combined, 1)
                combined(l, i) = (columns(l, 1)*weight(i, 1) + columns(l, 2)*weight(i, 2) + columns(l, 3)*weight(i, 3)) + &
                                 (columns(l, 4)*weight(i, 4) + columns(l, 5)*weight(i, 5) + columns(l, 6)*weight(i, 6)) + &
                                 (columns(l, 7)*weight(i, 7) + columns(l, 8)*weight(i, 8) + columns(l, 9)*weight(i, 9))
            end do
        end do
    end subroutine combine_columns

    !> The cross product of the unit vector along an axis with a vector.
    pure function turned_about(axis, vector) result(change)
        integer, intent(in) :: axis
        real(dp), intent(in) :: vector(3)
        real(dp) :: change(3)

        real(dp) :: along(3)

        along = 0
        along(axis) = 1
        change = cross(along, vector)
    end function turned_about

    !> How fast the unscaled acceleration changes at k h, by a central difference (one-sided at the ends), m/s^3.
    pure function acceleration_slope(model, state, trajectory, k) result(slope)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory
        integer, intent(in) :: k
        real(dp) :: slope(3)

        integer :: before, after

        before = max(0, k - 1)
        after = min(model%steps, k + 1)
        slope = matmul(acceleration_matrix(model, trajectory, after) - acceleration_matrix(model, trajectory, before), &
                       state%value(OFFSET))/((after - before)*model%interval) + state%value(DRIFT)
    end function acceleration_slope

    !> Angles, about the axes of the head that took it, from the computed attitude to a star-camera
    !> sample, and the partials of the computed attitude. The sample's epoch may lie between the steps:
    !> from the nearest one the attitude is carried on with omega and d omega/dt.
    pure subroutine star_angles(model, state, trajectory, time, head, quaternion, angles, partials)
        type(physical_model_t), intent(in) :: model
        type(model_state_t), intent(in) :: state
        type(model_trajectory_t), intent(in) :: trajectory
        real(dp), intent(in) :: time            !! s
        integer, intent(in) :: head    !! That took the sample, 1 to HEADS
        real(dp), intent(in) :: quaternion(4)   !! Sample, inertial to body
        real(dp), intent(out) :: angles(3)      !! Observed minus computed, about camera axes, rad
        real(dp), intent(out), optional :: partials(:, :)   !! (estimated, 3)

        real(dp) :: computed(4), tau, rate(3), turned(3, 3), weight(3, 9), rotational(size(model%rotational), 3)
        integer :: k, i

        k = max(0, min(model%steps, nint(time/model%interval)))
        tau = time - k*model%interval
        associate (omega => trajectory%omega(:, k), camera => model%camera_from_body(:, :, head))
            computed = turned_by(tau*omega + tau**2/2*trajectory%omega_dot(:, k), trajectory%q(:, k))
            angles = matmul(camera, turn_between(computed, quaternion))
            rate = omega + tau*trajectory%omega_dot(:, k)
            do i = 1, size(model%estimated)
                associate (p => model%estimated(i))
                    if (.not. is_of_star_camera(p)) cycle
                    if (abs(state%value(p)) > 0) angles = angles - state%value(p)*camera_partial(p, head, camera, rate, time)
                end associate
            end do
            if (.not. present(partials)) return
            turned = 0
            call add_cross_matrix(-tau, omega, turned)
            do i = 1, 3
                weight(:, i) = camera(:, i) + times(camera, turned(:, i))
                weight(:, 3 + i) = tau*camera(:, i)
                weight(:, 6 + i) = tau**2/2*camera(:, i)
            end do
            call combine_columns(trajectory%partials(:, :, k), weight, rotational)
            partials = 0
            do i = 1, size(model%estimated)
                associate (p => model%estimated(i), r => model%place(i))
                    if (r > 0) then
                        partials(i, :) = rotational(r, :)
                    else if (is_of_star_camera(p)) then
                        partials(i, :) = camera_partial(p, head, camera, rate, time)
                    end if
                end associate
            end do
        end associate
    end subroutine star_angles

    !> The angles that a head shows by 1 of such a parameter.
    pure function camera_partial(parameter, head, camera, rate, time) result(partial)
        integer, intent(in) :: parameter        !! Its place
        integer, intent(in) :: head
        real(dp), intent(in) :: camera(3, 3)    !! Camera from body
        real(dp), intent(in) :: rate(3)         !! Of the body, rad/s
        real(dp), intent(in) :: time            !! s
        real(dp) :: partial(3)                  !! Camera axes, rad by its unit

        partial = 0
        select case (KIND_OF(parameter))
        case (OF_MOUNTING_1, OF_MOUNTING_2)
            if (KIND_OF(parameter) - OF_MOUNTING_1 + 1 == head) partial = camera(:, MEMBER_OF(parameter))
        case (OF_HEAD_DRIFT)
            if (head == 2) partial = camera(:, MEMBER_OF(parameter))*time
        case (OF_HEAD_DELAY)
            if (head == 2) partial = -times(camera, rate)
        case (OF_STAR_CAMERA_DELAY)
            partial = -times(camera, rate)
        end select
    end function camera_partial
end module gracecg_estimation_physical_model
