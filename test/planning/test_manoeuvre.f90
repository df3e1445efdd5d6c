!> Manoeuvres with all waveforms on a satellite: what the integrators make of them, their limits, and
!> how case files state them.
module test_manoeuvre
    use vocabulary
    use calibrations
    use gracecg_spacecraft_torque_rods
    use gracecg_simulation_dynamics, only: OMEGA, ATTITUDE
    use gracecg_simulation_arc, only: truth_arc_t
    use gracecg_estimation_attitude_fit, only: attitude_fit_t, fitted_rotation_t, new_attitude_fit
    use gracecg_simulation_case, only: read_case, case_text
    use gracecg_simulation_simulator, only: new_simulator
    use gracecg_simulation_limits
    implicit none
    private
    public :: collect_manoeuvre

contains

    subroutine collect_manoeuvre(testsuite)
        type(unittest_type), allocatable, intent(out) :: testsuite(:)

        testsuite = [ &
                    new_unittest('fit-resolves-every-waveform', test_fit_converges), &
                    new_unittest('taper-keeps-the-attitude', test_taper_in_flight), &
                    new_unittest('limits-of-rate-pointing-and-sampling', test_limits), &
                    new_unittest('case-file', test_case_file)]
    end subroutine collect_manoeuvre

    !> Front case 1 with all three rods at 5, 6 and 7 cycles a minute.
    subroutine example(waveform, case)
        integer, intent(in) :: waveform
        type(case_t), intent(out) :: case
        type(rod_activation_t) :: activations(3)
        type(error_t), allocatable :: failure
        integer :: axis

        call take_case('front-1', case)
        do axis = 1, 3
            activations(axis) = rod_activation_t(axis, 30.0_dp, (4 + axis)/60.0_dp, 0.3_dp*axis, 0.0_dp, &
                                                 60.0_dp, waveform)
            if (waveform == TAPERED) activations(axis)%taper = 5
        end do
        call new_torque_rods(activations, case%satellite%rods, failure)
        call need(failure)
    end subroutine example

    !> The estimators' Runge-Kutta steps, of order 4, in a constant field: halving the step leaves
    !> less than a twelfth of the error for the smooth waveforms and less than a sixth for the square
    !> one, whose third derivative jumps at the edges; at 0.1 s it is below 1e-10 rad/s.
    subroutine test_fit_converges(error)
        type(error_type), allocatable, intent(out) :: error
        real(dp), parameter :: FIELD(3) = [-24.4e-6_dp, -3.6e-6_dp, 7.5e-6_dp]
        type(case_t) :: case
        type(fitted_rotation_t) :: reference, trial
        real(dp) :: errors(2)
        integer :: waveform, i

        do waveform = SINE, SQUARE
            call example(waveform, case)
            reference = fitted(case, 0.00625_dp)
            do i = 1, 2
                trial = fitted(case, 0.2_dp/2**i)
                errors(i) = maxval(abs(trial%omega - reference%omega(:, ::32/2**i)))
            end do
            call check(error, errors(1) < 1e-10_dp, WAVEFORM_NAMES(waveform))
            call check(error, errors(2) < errors(1)/merge(6, 12, waveform == SQUARE), WAVEFORM_NAMES(waveform))
        end do

    contains

        function fitted(case, step) result(rotation)
            type(case_t), intent(in) :: case
            real(dp), intent(in) :: step
            type(fitted_rotation_t) :: rotation

            type(attitude_fit_t) :: fit
            real(dp), allocatable :: torque(:, :)
            integer :: j, n

            n = nint(60/step)
            allocate (torque(3, 0:2*n))
            do j = 0, 2*n
                torque(:, j) = cross(dipole_moment(case%satellite%rods, j*step/2), FIELD)
            end do
            fit = new_attitude_fit(case%satellite%inertia, step, torque)
            call fit%integrate([0.0_dp, 0.0_dp, 0.0_dp, 1.0_dp], case%angular_velocity, rotation)
        end function fitted
    end subroutine test_fit_converges

    !> A sine of the report's frequency that starts abruptly leaves a mean rate that turns the
    !> satellite away; with tapers of one period the greatest turn is less than half
    !> of that (what is left is the turn by the gravity gradient).
    subroutine test_taper_in_flight(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(attitude_motion_t) :: abrupt, smooth

        call report_motion(abrupt)
        case%satellite%rods%activations%waveform = TAPERED
        case%satellite%rods%activations%taper = 10
        call motion_of(smooth)
        call check(error, abrupt%excursion > 0.05_dp*DEGREE .and. smooth%excursion < abrupt%excursion/2)

    contains

        subroutine report_motion(motion)
            type(attitude_motion_t), intent(out) :: motion

            call take_case('front-2', case)
            call motion_of(motion)
        end subroutine report_motion

        subroutine motion_of(motion)
            type(attitude_motion_t), intent(out) :: motion
            type(truth_arc_t) :: arc

            call make_arc(case, arc)
            call follow_motion(arc%interval, arc%state(OMEGA, 0), arc%state(ATTITUDE, 0), 0, arc%state(OMEGA, :), &
                               arc%state(ATTITUDE, :), motion)
        end subroutine motion_of
    end subroutine test_taper_in_flight

    !> Front case 2 with a constant moment about x: 2e-5 rad/s^2 carry it over 0.1 deg/s.
    subroutine test_limits(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case
        type(simulator_t) :: simulator
        type(error_t), allocatable :: failure

        call take_case('front-2', case)
        call new_torque_rods([rod_activation_t(2, 30.0_dp, 0.0_dp, PI/2, 0.0_dp, 90.0_dp)], case%satellite%rods, failure)
        case%duration = 90
        case%limits%pointing = PI
        call new_simulator(case, simulator, failure)
        call check_fails(error, failure, 'case front-2 ... deg/s at t = 90 s ... at most 0.1 deg/s ... rate_deg_s')
        case%limits%rate = 0.15_dp*DEGREE
        call new_simulator(case, simulator, failure)
        call check_passes(error, failure)
        call take_case('front-2', case)
        case%limits%pointing = 0.05_dp*DEGREE
        call new_simulator(case, simulator, failure)
        call check_fails(error, failure, 'case front-2 ... away from its attitude ... at most 0.05 deg ... pointing_deg')
        ! free flight is not a manoeuvre
        call new_torque_rods([rod_activation_t ::], case%satellite%rods, failure)
        case%limits%rate = 1e-5_dp
        call new_simulator(case, simulator, failure)
        call check_passes(error, failure)
        call take_case('front-1', case)
        case%satellite%rods%activations%frequency = 5
        call new_simulator(case, simulator, failure)
        call check_fails(error, failure, 'case front-1 ... frequency = 5 Hz ... below 5 Hz')
    end subroutine test_limits

    !> Waveform, taper, edges and limits are written and read back; what is wrong is refused with
    !> file and line.
    subroutine test_case_file(error)
        type(error_type), allocatable, intent(out) :: error
        type(case_t) :: case, again
        type(error_t), allocatable :: failure
        character(:), allocatable :: text
        integer :: waveform

        do waveform = SINE, SQUARE
            call example(waveform, case)
            case%satellite%rods%activations%rise_time = 1.25_dp
            case%limits%rate = 0.09_dp*DEGREE
            case%limits%pointing = 0.4_dp*DEGREE
            call case_text(case, text, failure)
            call make_file('manoeuvre.nml', text)
            call read_case(FOLDER//'manoeuvre.nml', again, failure)
            if (failed(error, failure)) return
            associate (a => case%satellite%rods%activations(:3), b => again%satellite%rods%activations(:3))
                call check(error, all(a%waveform == b%waveform .and. a%taper == b%taper .and. &
                                      a%rise_time == b%rise_time))
            end associate
            call check(error, again%limits%rate == case%limits%rate .and. &
                       again%limits%pointing == case%limits%pointing)
        end do
        call refused(replaced(text, "'square'", "'sqare'"), 'waveform ... sqare ... square')
        call refused(replaced(text, "'square'", "'tapered'"), 'needs a taper')
        call refused(replaced(text, '1.25', '0.2'), 'manoeuvre.nml ... rise_time = 0.2')
        call refused(replaced(text, 'rate_deg_s = 9', 'rate_deg_s = -9'), 'rate_deg_s')

    contains

        subroutine refused(content, parts)
            character(*), intent(in) :: content, parts

            call make_file('manoeuvre.nml', content)
            call read_case(FOLDER//'manoeuvre.nml', again, failure)
            call check_fails(error, failure, parts)
        end subroutine refused
    end subroutine test_case_file
end module test_manoeuvre
