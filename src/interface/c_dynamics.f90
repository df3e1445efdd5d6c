!> The C interface: cases, force model, propagation. Documented in include/gracecg.h.
module gracecg_interface_c_dynamics
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_int32_t, c_intptr_t, c_size_t
    use gracecg, only: dp, error_t, calibration_t, find_calibration, calibration_from_text, calibration_text, &
        initial_state, build_dynamics, satellite_dynamics_t, accelerations_t, loads_t, truth_arc_t, &
        propagate_arc, check_state, nadir_pointing_t, STATE_SIZE, STATE_ATTITUDE, STATE_OMEGA
    use gracecg_base_kinds, only: i8
    use gracecg_base_vectors, only: cross
    use gracecg_simulation_arc, only: MAX_STEPS
    use gracecg_interface_handles, only: object_t, acquire, release
    use gracecg_interface_c_support, only: c_error_t, c_utc_t, STATUS_OK, STATUS_BAD_VALUE, LONGEST_NAME, &
        LONGEST_TEXT, start, raise, pass_on, need, check_count, check_finite, check_result, &
        check_distance, fortran_text, give_text, keep_copy, refuse_handle, free_object
    use gracecg_interface_c_surface, only: check_attitude
    implicit none
    private
    public :: case_object_t, keep_case
    public :: c_case_open, c_case_parse, c_case_free, c_case_text, c_case_values
    public :: c_force_model_open, c_force_model_free, c_force_model_epoch, c_force_model_evaluate
    public :: c_force_model_torques, c_force_model_rate, c_force_model_propagate, c_force_model_propagate_nadir

    !> A case behind a handle, with how it is estimated.
    type, extends(object_t) :: case_object_t
        type(calibration_t) :: calibration      !! As it was read
    end type case_object_t

    type, extends(object_t) :: force_object_t
        type(satellite_dynamics_t) :: dynamics
    end type force_object_t

    character(*), parameter :: CASE_NAME = 'case', FORCE_NAME = 'force model'

contains

    !> gracecg_case_open
    function c_case_open(name_or_file, handle, error) result(status) bind(c, name='gracecg_case_open')
        character(kind=c_char), intent(in), optional :: name_or_file(*)
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(calibration_t) :: calibration
        type(error_t), allocatable :: failure
        character(:), allocatable :: name

        call start(status, error)
        call need(present(handle), 'the_case', status, error)
        if (present(handle)) handle = 0
        call fortran_text(name_or_file, LONGEST_NAME, 'name_or_file', name, status, error)
        if (status /= STATUS_OK) return
        call find_calibration(name, calibration, failure)
        call pass_on(failure, status, error)
        if (status == STATUS_OK) call keep_case(calibration, handle, status, error)
    end function c_case_open

    !> gracecg_case_parse
    function c_case_parse(text, handle, error) result(status) bind(c, name='gracecg_case_parse')
        character(kind=c_char), intent(in), optional :: text(*)
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(calibration_t) :: calibration
        type(error_t), allocatable :: failure
        character(:), allocatable :: settings

        call start(status, error)
        call need(present(handle), 'the_case', status, error)
        if (present(handle)) handle = 0
        call fortran_text(text, LONGEST_TEXT, 'text', settings, status, error)
        if (status /= STATUS_OK) return
        call calibration_from_text(settings, 'text', calibration, failure)
        call pass_on(failure, status, error)
        if (status == STATUS_OK) call keep_case(calibration, handle, status, error)
    end function c_case_parse

    !> Stores a case and gives its handle out.
    subroutine keep_case(calibration, handle, status, error)
        type(calibration_t), intent(in) :: calibration
        integer(c_intptr_t), intent(inout) :: handle    !! Of the case; 0 without room
        integer(c_int), intent(inout) :: status     !! Of the call so far
        type(c_error_t), intent(inout), optional :: error

        type(case_object_t) :: made

        made%calibration = calibration
        call keep_copy(made, handle, status, error)
    end subroutine keep_case

    !> gracecg_case_free
    function c_case_free(handle, error) result(status) bind(c, name='gracecg_case_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(case_object_t) :: mold

        call free_object(handle, CASE_NAME, status, error, mold)
    end function c_case_free

    !> gracecg_case_text
    function c_case_text(handle, text, size, length, error) result(status) &
        bind(c, name='gracecg_case_text')
        integer(c_intptr_t), intent(in), value :: handle
        character(kind=c_char), intent(inout), optional :: text(*)
        integer(c_size_t), intent(in), value :: size
        integer(c_size_t), intent(inout), optional :: length
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(error_t), allocatable :: failure
        character(:), allocatable :: settings

        call start(status, error)
        call check_count(size, 'size', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (case_object_t)
            call calibration_text(object%calibration, settings, failure)
            call pass_on(failure, status, error)
            if (status == STATUS_OK) call give_text(settings, text, size, length, status, error)
        class default
            call refuse_handle(CASE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_case_text

    !> gracecg_case_values
    function c_case_values(handle, epoch, duration, interval, state, offset, error) result(status) &
        bind(c, name='gracecg_case_values')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_utc_t), intent(inout), optional :: epoch
        real(c_double), intent(inout), optional :: duration, interval, state(STATE_SIZE), offset(3)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call acquire(int(handle, i8), object)
        select type (object)
        type is (case_object_t)
            associate (case => object%calibration%case)
                if (present(epoch)) epoch = c_utc_t(case%epoch%mjd, case%epoch%seconds)
                if (present(duration)) duration = case%duration
                if (present(interval)) interval = case%interval
                if (present(state)) state = initial_state(case)
                if (present(offset)) offset = case%satellite%offset
            end associate
        class default
            call refuse_handle(CASE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_case_values

    !> gracecg_force_model_open
    function c_force_model_open(case_handle, handle, error) result(status) &
        bind(c, name='gracecg_force_model_open')
        integer(c_intptr_t), intent(in), value :: case_handle
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(force_object_t) :: made
        type(error_t), allocatable :: failure

        call start(status, error)
        call need(present(handle), 'model', status, error)
        if (present(handle)) handle = 0
        if (status /= STATUS_OK) return
        call acquire(int(case_handle, i8), object)
        select type (object)
        type is (case_object_t)
            call build_dynamics(object%calibration%case, made%dynamics, failure)
            call pass_on(failure, status, error)
        class default
            call refuse_handle(CASE_NAME, status, error)
        end select
        call release(int(case_handle, i8), object)
        call keep_copy(made, handle, status, error)
    end function c_force_model_open

    !> gracecg_force_model_free
    function c_force_model_free(handle, error) result(status) bind(c, name='gracecg_force_model_free')
        integer(c_intptr_t), intent(inout), optional :: handle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        type(force_object_t) :: mold

        call free_object(handle, FORCE_NAME, status, error, mold)
    end function c_force_model_free

    !> gracecg_force_model_epoch
    function c_force_model_epoch(handle, epoch, sidereal_angle, error) result(status) &
        bind(c, name='gracecg_force_model_epoch')
        integer(c_intptr_t), intent(in), value :: handle
        type(c_utc_t), intent(inout), optional :: epoch
        real(c_double), intent(inout), optional :: sidereal_angle
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call acquire(int(handle, i8), object)
        select type (object)
        type is (force_object_t)
            if (present(epoch)) epoch = c_utc_t(object%dynamics%epoch%mjd, object%dynamics%epoch%seconds)
            if (present(sidereal_angle)) sidereal_angle = object%dynamics%earth%angle
        class default
            call refuse_handle(FORCE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_force_model_epoch

    !> gracecg_force_model_orientation
    function c_force_model_orientation(handle, seconds, rotation, error) result(status) &
        bind(c, name='gracecg_force_model_orientation')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), value :: seconds
        real(c_double), intent(inout), optional :: rotation(3, 3)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call need(present(rotation), 'rotation', status, error)
        call check_finite([seconds], 1_c_size_t, 'seconds', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (force_object_t)
            rotation = transpose(object%dynamics%earth%from_inertial(seconds))
        class default
            call refuse_handle(FORCE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_force_model_orientation

    !> gracecg_force_model_evaluate
    function c_force_model_evaluate(handle, n, seconds, position, velocity, quaternion, gravity, drag, &
                                    solar_radiation, earth_radiation, total, error) result(status) &
        bind(c, name='gracecg_force_model_evaluate')
        integer(c_intptr_t), intent(in), value :: handle
        integer(c_size_t), intent(in), value :: n
        real(c_double), intent(in), optional :: seconds(*), position(3, *), velocity(3, *), quaternion(4, *)
        real(c_double), intent(inout), optional :: gravity(3, *), drag(3, *), solar_radiation(3, *)
        real(c_double), intent(inout), optional :: earth_radiation(3, *), total(3, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(accelerations_t) :: acting
        real(dp) :: state(STATE_SIZE)
        integer(c_size_t) :: i

        call start(status, error)
        call check_count(n, 'n', status, error)
        if (n > 0) then
            call need(present(seconds), 'seconds', status, error)
            call need(present(position), 'position', status, error)
            call need(present(velocity), 'velocity', status, error)
            call need(present(quaternion), 'quaternion', status, error)
        end if
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (force_object_t)
            do i = 1, n
                state = [position(:, i), velocity(:, i), 0.0_dp, 0.0_dp, 0.0_dp, quaternion(:, i)]
                call check_motion(object%dynamics, seconds(i), state, status, error)
                if (status /= STATUS_OK) exit
                call object%dynamics%accelerations(seconds(i), position(:, i), velocity(:, i), &
                                                   quaternion(:, i), acting)
                call check_result(acting%total, 'the acceleration', status, error)
                if (status /= STATUS_OK) exit
                if (present(gravity)) gravity(:, i) = acting%gravity
                if (present(drag)) drag(:, i) = acting%drag
                if (present(solar_radiation)) solar_radiation(:, i) = acting%solar_radiation
                if (present(earth_radiation)) earth_radiation(:, i) = acting%earth_radiation
                if (present(total)) total(:, i) = acting%total
            end do
        class default
            call refuse_handle(FORCE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_force_model_evaluate

    !> A state and time that the models are made for.
    subroutine check_motion(dynamics, seconds, state, status, error)
        type(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: seconds, state(STATE_SIZE)
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        type(error_t), allocatable :: failure

        call check_finite([seconds], 1_c_size_t, 'seconds', status, error)
        call check_finite(state, int(STATE_SIZE, c_size_t), 'the state', status, error)
        call check_distance(state, 1_c_size_t, status, error)
        call check_attitude(state(STATE_ATTITUDE), status, error)
        if (status /= STATUS_OK) return
        call check_state(dynamics, seconds, state, failure)
        call pass_on(failure, status, error, STATUS_BAD_VALUE)
    end subroutine check_motion

    !> gracecg_force_model_torques
    function c_force_model_torques(handle, seconds, state, aerodynamic, solar, gravity_gradient, &
                                   magnetic, flux_density, error) result(status) &
        bind(c, name='gracecg_force_model_torques')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), value :: seconds
        real(c_double), intent(in), optional :: state(STATE_SIZE)
        real(c_double), intent(inout), optional :: aerodynamic(3), solar(3), gravity_gradient(3)
        real(c_double), intent(inout), optional :: magnetic(3), flux_density(3)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        type(loads_t) :: acting

        call start(status, error)
        call need(present(state), 'state', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (force_object_t)
            call check_motion(object%dynamics, seconds, state, status, error)
            if (status == STATUS_OK) then
                call object%dynamics%loads(seconds, state, acting)
                call check_result([acting%torque_aero, acting%torque_solar, acting%torque_gravity, &
                                   acting%torque_magnetic, acting%field], 'the torque', status, error)
            end if
            if (status == STATUS_OK) then
                if (present(aerodynamic)) aerodynamic = acting%torque_aero
                if (present(solar)) solar = acting%torque_solar
                if (present(gravity_gradient)) gravity_gradient = acting%torque_gravity
                if (present(magnetic)) magnetic = acting%torque_magnetic
                if (present(flux_density)) flux_density = acting%field
            end if
        class default
            call refuse_handle(FORCE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_force_model_torques

    !> gracecg_force_model_rate
    function c_force_model_rate(handle, seconds, state, rate, error) result(status) &
        bind(c, name='gracecg_force_model_rate')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), value :: seconds
        real(c_double), intent(in), optional :: state(STATE_SIZE)
        real(c_double), intent(inout), optional :: rate(STATE_SIZE)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        real(dp) :: derivative(STATE_SIZE)

        call start(status, error)
        call need(present(state), 'state', status, error)
        call need(present(rate), 'rate', status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (force_object_t)
            call check_motion(object%dynamics, seconds, state, status, error)
            if (status == STATUS_OK) then
                call object%dynamics%rate(seconds, state, derivative)
                call check_result(derivative, 'the derivative', status, error)
                if (status == STATUS_OK) rate = derivative
            end if
        class default
            call refuse_handle(FORCE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_force_model_rate

    !> gracecg_force_model_propagate
    function c_force_model_propagate(handle, state, interval, steps, tolerance, states, error) &
        result(status) bind(c, name='gracecg_force_model_propagate')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), optional :: state(STATE_SIZE)
        real(c_double), intent(in), value :: interval, tolerance
        integer(c_size_t), intent(in), value :: steps
        real(c_double), intent(inout), optional :: states(STATE_SIZE, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object

        call start(status, error)
        call need(present(state), 'state', status, error)
        call need(present(states), 'states', status, error)
        call check_propagation(interval, steps, tolerance, status, error)
        if (status /= STATUS_OK) return
        call acquire(int(handle, i8), object)
        select type (object)
        type is (force_object_t)
            call check_motion(object%dynamics, 0.0_dp, state, status, error)
            if (status == STATUS_OK) &
                call propagate(object%dynamics, state, interval, int(steps), tolerance, states, status, error)
        class default
            call refuse_handle(FORCE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_force_model_propagate

    !> gracecg_force_model_propagate_nadir
    function c_force_model_propagate_nadir(handle, position, velocity, forward, interval, steps, tolerance, states, &
                                           error) result(status) bind(c, name='gracecg_force_model_propagate_nadir')
        integer(c_intptr_t), intent(in), value :: handle
        real(c_double), intent(in), optional :: position(3), velocity(3)
        integer(c_int32_t), intent(in), value :: forward
        real(c_double), intent(in), value :: interval, tolerance
        integer(c_size_t), intent(in), value :: steps
        real(c_double), intent(inout), optional :: states(STATE_SIZE, *)
        type(c_error_t), intent(inout), optional :: error
        integer(c_int) :: status

        class(object_t), pointer :: object
        real(dp), parameter :: ROUNDING = 1e-12_dp      ! of a product of parallel vectors: with fused multiply-add it is not 0
        type(nadir_pointing_t) :: held
        real(dp) :: state(STATE_SIZE)

        call start(status, error)
        call need(present(position), 'position', status, error)
        call need(present(velocity), 'velocity', status, error)
        call need(present(states), 'states', status, error)
        call check_propagation(interval, steps, tolerance, status, error)
        if (status /= STATUS_OK) return
        if (.not. norm2(cross(position, velocity)) > ROUNDING*norm2(position)*norm2(velocity)) then
            call raise(STATUS_BAD_VALUE, 'position and velocity span no plane of an orbit', status, error)
            return
        end if
        call acquire(int(handle, i8), object)
        select type (object)
        type is (force_object_t)
            held%satellite_dynamics_t = object%dynamics
            held%forward = forward /= 0
            state = [position, velocity, 0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp]
            call check_motion(object%dynamics, 0.0_dp, state, status, error)
            if (status == STATUS_OK) &
                call propagate(held, state, interval, int(steps), tolerance, states, status, error)
        class default
            call refuse_handle(FORCE_NAME, status, error)
        end select
        call release(int(handle, i8), object)
    end function c_force_model_propagate_nadir

    !> Refuses what no arc can have.
    subroutine check_propagation(interval, steps, tolerance, status, error)
        real(dp), intent(in) :: interval, tolerance
        integer(c_size_t), intent(in) :: steps
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        call check_count(steps, 'steps', status, error, MAX_STEPS)
        if (status == STATUS_OK .and. .not. (tolerance >= 0 .and. tolerance < 1)) then
            call raise(STATUS_BAD_VALUE, 'tolerance has to lie in 0 to 1; 0 means one step an interval', &
                       status, error)
        else if (status == STATUS_OK .and. .not. abs(interval) <= huge(interval)) then
            call raise(STATUS_BAD_VALUE, 'interval is NaN or infinite', status, error)
        end if
    end subroutine check_propagation

    !> The states of an arc.
    subroutine propagate(dynamics, state, interval, steps, tolerance, states, status, error)
        class(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: state(STATE_SIZE)
        real(dp), intent(in) :: interval, tolerance     !! s; 0: one step an interval
        integer, intent(in) :: steps
        real(dp), intent(inout) :: states(STATE_SIZE, *)
        integer(c_int), intent(inout) :: status
        type(c_error_t), intent(inout), optional :: error

        type(truth_arc_t) :: arc
        type(error_t), allocatable :: failure

        if (tolerance > 0) then
            call propagate_arc(dynamics, state, interval, steps, arc, failure, tolerance)
        else
            call propagate_arc(dynamics, state, interval, steps, arc, failure)
        end if
        call pass_on(failure, status, error)
        if (status == STATUS_OK) states(:, 1:steps + 1) = arc%state
    end subroutine propagate
end module gracecg_interface_c_dynamics
