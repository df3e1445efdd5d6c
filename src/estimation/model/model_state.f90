!> What the physical model (gracecg_estimation_physical_model) knows, its parameters' values, and its rotation.
module gracecg_estimation_model_state
    use gracecg_base_kinds, only: dp
    use gracecg_base_quaternion, only: quaternion_product, conjugate_quaternion, normalised
    use gracecg_base_vectors, only: cross
    use gracecg_observations_accelerometer_line, only: accelerometer_line_t
    use gracecg_observations_knowledge, only: HEADS
    use gracecg_observations_parameters
    use gracecg_estimation_options, only: estimation_options_t
    use gracecg_estimation_fitting_data, only: fitting_data_t
    use gracecg_estimation_iteration, only: iteration_t
    implicit none
    private
    public :: physical_model_t, model_state_t, model_trajectory_t, initial_state, correct_state, &
        describe_model_state, turned_by, turn_between, turned_about, sinc

    !> What does not change during the fit. Epochs are k h, k = 0..n; half steps are j h/2.
    type :: physical_model_t
        integer :: steps = 0                            !! n
        real(dp) :: interval = 0                        !! h, s
        real(dp) :: start = 0                           !! Of the arc in the time that DRIFT counts from, s
        real(dp) :: inertia(3, 3) = 0                   !! Nominal J, kg m^2
        real(dp), allocatable :: magnetic_torque(:, :)  !! m x B, nominal, (3, 0:2n), N m
        real(dp), allocatable :: dipole(:, :)           !! m, (3, 0:2n), A m^2
        real(dp), allocatable :: moment(:, :), moment_rate(:, :)
        !! Of the rods along themselves, (3, 0:n), A m^2, and its mean change over a sample, A m^2/s; of size 0 unless leakage is
        !! asked for
        real(dp), allocatable :: jump_torque(:, :, :)
        !! Of moments that are held: what acts at an epoch besides magnetic_torque, by rod, (3, rod, 0:n), N m; else of size 0
        real(dp), allocatable :: rate_squared(:)        !! mu/r^3, (0:2n), 1/s^2; 0 without an orbit
        real(dp), allocatable :: upwards(:, :)          !! r/|r|, inertial, (3, 0:2n)
        real(dp), allocatable :: airflow(:, :)          !! Along the velocity in the air, inertial, (3, 0:n)
        logical :: airflow_known = .false.              !! False: the body's x axis stands in
        type(accelerometer_line_t) :: line              !! Where there are several accelerometers
        real(dp) :: wave_frequency = 0                  !! Of the density wave, nominal, Hz; 0: none
        real(dp), allocatable :: light(:)               !! Part of the Sun that is seen, (0:n), where LIGHT is estimated
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

contains

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

    !> The cross product of the unit vector along an axis with a vector.
    pure function turned_about(axis, vector) result(change)
        integer, intent(in) :: axis            !! 1, 2 or 3
        real(dp), intent(in) :: vector(3)      !! Any unit
        real(dp) :: change(3)

        real(dp) :: along(3)

        along = 0
        along(axis) = 1
        change = cross(along, vector)
    end function turned_about

    !> sin(x)/x
    pure real(dp) function sinc(x)
        real(dp), intent(in) :: x    !! rad

        sinc = 1
        if (abs(x) > tiny(1.0_dp)) sinc = sin(x)/x
    end function sinc
end module gracecg_estimation_model_state
