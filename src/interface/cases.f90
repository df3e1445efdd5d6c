!> The C interface: cases, force model, propagation. Documented in include/gracecg.h.
module gracecg_interface_cases
    use gracecg, only: dp, error_t, utc_t, calibration_t, find_calibration, calibration_from_text, calibration_text, &
        options_text, initial_state, satellite_dynamics_t, accelerations_t, loads_t, truth_arc_t, &
        propagate_arc, check_state, nadir_pointing_t, STATE_SIZE, STATE_POSITION, STATE_VELOCITY, design_settings_t
    use gracecg_base_error, only: number_text
    use gracecg_base_vectors, only: cross
    use gracecg_planning_candidates, only: usual_amplitude
    use gracecg_interface_handles, only: object_t
    use gracecg_interface_items, only: items_t
    use gracecg_interface_outcome, only: outcome_t, STATUS_BAD_VALUE
    implicit none
    private
    public :: case_object_t, force_object_t, case_open, is_text, force_model_evaluate, force_model_loads
    public :: force_model_propagate

    !> A case behind a handle, with how it is estimated.
    type, extends(object_t) :: case_object_t
        type(calibration_t) :: calibration      !! As it was read
    contains
        procedure :: tell => tell_case          !! Puts its items
    end type case_object_t

    !> A force model behind a handle.
    type, extends(object_t) :: force_object_t
        type(satellite_dynamics_t) :: dynamics  !! Of a case
    contains
        procedure :: tell => tell_force_model   !! Puts its items
    end type force_object_t

    real(dp), parameter :: CENTURY = 3.2e9_dp   !! s
    real(dp), parameter :: LONGEST_STEP = 60    !! s: a day of front-1 in such steps is right to 0.5 mm
    real(dp), parameter :: USUAL_TOLERANCE = 1e-11_dp   !! Of steps under control, by which it is so, too

contains

    !> A calibration case: satellite, orbit, models, instruments and manoeuvre.
    subroutine case_open(source, made, outcome)
        character(*), intent(in) :: source          !! Name, path or text
        type(case_object_t), intent(inout) :: made
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        if (is_text(source)) then
            call calibration_from_text(source, 'text', made%calibration, failure)
        else
            call find_calibration(source, made%calibration, failure)
        end if
        call outcome%take(failure)
    end subroutine case_open

    !> Whether it is the text of settings, not the name of a file.
    pure logical function is_text(source)
        character(*), intent(in) :: source      !! Of the caller

        is_text = index(adjustl(source), '&') == 1 .or. index(source, new_line('a')) > 0
    end function is_text

    subroutine tell_case(self, items)
        class(case_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        type(design_settings_t) :: default      ! the planner's own, that gracecg_design is given
        integer :: i

        associate (case => self%calibration%case)
            call tell_time(items, 'epoch', case%epoch)
            call items%put('duration', case%duration)
            call items%put('interval', case%interval)
            call items%put('state', initial_state(case))
            call items%put('offset', case%satellite%offset)
            associate (rods => case%satellite%rods%activations(:case%satellite%rods%count))
                call items%put('rods', reshape([(rods(i)%amplitude, rods(i)%frequency, rods(i)%phase, rods(i)%start, &
                                                 rods(i)%stop, rods(i)%taper, rods(i)%rise_time, i=1, size(rods))], &
                                               [7, size(rods)]))
                call items%put('rod_kinds', real([(rods(i)%axis, rods(i)%waveform, i=1, size(rods))], dp))
            end associate
            call items%put('design_settings', [0.0_dp, case%duration, usual_amplitude(case%satellite%rods), &
                                               default%lowest_frequency, default%highest_frequency, default%taper, &
                                               default%rise_time, case%limits%rate, case%limits%pointing])
            call items%put('design_choices', real([merge(1, 0, default%rod_used), merge(1, 0, default%waveform_used), &
                                                   default%threads], dp))
        end associate
        call tell_settings(self%calibration, items)
    end subroutine tell_case

    subroutine tell_time(items, name, time)
        type(items_t), intent(inout) :: items
        character(*), intent(in) :: name
        type(utc_t), intent(in) :: time

        call items%put(name, [real(time%mjd, dp), time%seconds])
    end subroutine tell_time

    !> The texts of a case, which are made when they are asked for.
    subroutine tell_settings(calibration, items)
        type(calibration_t), intent(in) :: calibration
        type(items_t), intent(inout) :: items

        character(:), allocatable :: text

        text = ''
        if (items%asks('text')) call calibration_text(calibration, text, items%failure)
        call items%say('text', text)
        if (items%asks('options')) call options_text(calibration%options, text, items%failure)
        call items%say('options', text)
    end subroutine tell_settings

    subroutine tell_force_model(self, items)
        class(force_object_t), intent(in) :: self
        type(items_t), intent(inout) :: items

        call tell_time(items, 'epoch', self%dynamics%epoch)
        call items%put('sidereal_angle', self%dynamics%earth%angle)
    end subroutine tell_force_model

    !> Accelerations [n][3] (m/s^2, inertial axes) at `seconds`[n] from the epoch.
    subroutine force_model_evaluate(model, n, seconds, position, velocity, quaternion, gravity, drag, solar_radiation, &
                                    earth_radiation, total, outcome)
        class(force_object_t), intent(in) :: model
        integer, intent(in) :: n                                        !! Times
        real(dp), intent(in) :: seconds(n)                              !! s from the epoch
        real(dp), intent(in) :: position(3, n), velocity(3, n)          !! Inertial, m, m/s
        real(dp), intent(in) :: quaternion(4, n)                        !! Inertial to body
        real(dp), dimension(3, n), intent(inout), optional :: gravity, drag, solar_radiation, earth_radiation, total
        !! m/s^2, inertial axes
        type(outcome_t), intent(inout) :: outcome

        type(accelerations_t) :: acting
        integer :: i

        do i = 1, n
            call check_motion(model, seconds(i), [position(:, i), velocity(:, i), 0.0_dp, 0.0_dp, 0.0_dp, quaternion(:, i)], &
                              outcome)
            if (.not. outcome%good()) return
            call model%dynamics%accelerations(seconds(i), position(:, i), velocity(:, i), quaternion(:, i), acting)
            if (present(gravity)) gravity(:, i) = acting%gravity
            if (present(drag)) drag(:, i) = acting%drag
            if (present(solar_radiation)) solar_radiation(:, i) = acting%solar_radiation
            if (present(earth_radiation)) earth_radiation(:, i) = acting%earth_radiation
            if (present(total)) total(:, i) = acting%total
        end do
    end subroutine force_model_evaluate

    !> A state and time that the models are made for.
    subroutine check_motion(model, seconds, state, outcome)
        class(force_object_t), intent(in) :: model
        real(dp), intent(in) :: seconds, state(STATE_SIZE)
        type(outcome_t), intent(inout) :: outcome

        type(error_t), allocatable :: failure

        if (.not. outcome%good()) return
        if (abs(seconds) > CENTURY) call outcome%refuse(STATUS_BAD_VALUE, number_text(seconds)//' s from the epoch: at most '// &
                                                        'a century, 3.2e9 s, is allowed')
        call check_state(model%dynamics, seconds, state, failure)
        call outcome%take(failure, STATUS_BAD_VALUE)
    end subroutine check_motion

    !> For one state: torques [4][3] (N m, body axes, about the centre of mass) of air, sunlight, gravity gradient and torque
    !> rods; magnetic flux density (T, body axes); time derivative of the state [13]; rotation [3][3] from inertial to
    !> Earth-fixed axes.
    subroutine force_model_loads(model, seconds, state, torques, flux_density, rate, rotation, outcome)
        class(force_object_t), intent(in) :: model
        real(dp), intent(in) :: seconds, state(STATE_SIZE)          !! s from the epoch; m, m/s, rad/s, quaternion
        real(dp), intent(inout), optional :: torques(3, 4)          !! Air, sunlight, gravity gradient, rods; body axes, N m
        real(dp), intent(inout), optional :: flux_density(3)        !! Body axes, T
        real(dp), intent(inout), optional :: rate(STATE_SIZE)       !! Of the state, per s
        real(dp), intent(inout), optional :: rotation(3, 3)         !! A row of C's is a column here
        type(outcome_t), intent(inout) :: outcome

        type(loads_t) :: acting

        call check_motion(model, seconds, state, outcome)
        if (.not. outcome%good()) return
        if (present(torques) .or. present(flux_density)) call model%dynamics%loads(seconds, state, acting)
        if (present(torques)) torques = reshape([acting%torque_aero, acting%torque_solar, acting%torque_gravity, &
                                                 acting%torque_magnetic], [3, 4])
        if (present(flux_density)) flux_density = acting%field
        if (present(rate)) call model%dynamics%rate(seconds, state, rate)
        if (present(rotation)) rotation = transpose(model%dynamics%earth%from_inertial(seconds))
    end subroutine force_model_loads

    !> Integrates orbit and attitude (Runge-Kutta-Fehlberg 7(8)) from time 0: states [steps + 1][13], the attitude free or
    !> held: body z to the centre of the Earth, y across the orbit.
    subroutine force_model_propagate(model, state, pointing, interval, steps, tolerance, states, outcome)
        class(force_object_t), intent(in) :: model
        real(dp), intent(in) :: state(STATE_SIZE), interval             !! At time 0; s
        integer, intent(in) :: pointing, steps                          !! 0 free, 1 body x along the orbit, 2 against it
        real(dp), intent(in) :: tolerance                               !! 0: one step an interval of up to LONGEST_STEP
        real(dp), intent(inout) :: states(STATE_SIZE, 0:steps)          !! At each interval
        type(outcome_t), intent(inout) :: outcome

        real(dp), parameter :: ROUNDING = 1e-12_dp      ! of a product of parallel vectors: with fused multiply-add it is not 0
        type(nadir_pointing_t) :: held

        if (pointing == 0) then
            call check_motion(model, 0.0_dp, state, outcome)
            call propagate(model%dynamics, state, interval, steps, tolerance, states, outcome)
            return
        end if
        associate (position => state(STATE_POSITION), velocity => state(STATE_VELOCITY))
            if (.not. norm2(cross(position, velocity)) > ROUNDING*norm2(position)*norm2(velocity)) &
                call outcome%refuse(STATUS_BAD_VALUE, 'position and velocity span no plane of an orbit')
        end associate
        call check_motion(model, 0.0_dp, state, outcome)
        held%satellite_dynamics_t = model%dynamics
        held%forward = pointing == 1
        call propagate(held, state, interval, steps, tolerance, states, outcome)
    end subroutine force_model_propagate

    !> One step an interval, or steps under control; these also where an interval is too long for one step.
    subroutine propagate(dynamics, state, interval, steps, tolerance, states, outcome)
        class(satellite_dynamics_t), intent(in) :: dynamics
        real(dp), intent(in) :: state(STATE_SIZE), interval, tolerance
        integer, intent(in) :: steps
        real(dp), intent(inout) :: states(STATE_SIZE, 0:steps)
        type(outcome_t), intent(inout) :: outcome

        type(truth_arc_t) :: arc
        type(error_t), allocatable :: failure

        if (.not. outcome%good()) return
        if (tolerance > 0 .or. interval > LONGEST_STEP) then
            call propagate_arc(dynamics, state, interval, steps, arc, failure, merge(tolerance, USUAL_TOLERANCE, tolerance > 0))
        else
            call propagate_arc(dynamics, state, interval, steps, arc, failure)
        end if
        call outcome%take(failure, STATUS_BAD_VALUE)
        if (outcome%good()) states = arc%state
    end subroutine propagate
end module gracecg_interface_cases
